"""A sphere from first yield to full plasticity: what the ceiling model says, and what is known."""

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import shapes

POINTS = 128
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
modulus = rc.contact_modulus(steel, rc.RIGID)
first_yield = steel.first_yield_pressure / steel.yield_strength


def mean_pressure_of_the_model(load_ratio: float) -> float:
    """Return load over contact area in yield strengths, at a load in loads of first yield."""
    peak = first_yield * load_ratio ** (1 / 3) * steel.yield_strength
    side = 1e-4
    a_hertz = side / (4 if peak < 10e9 else 8)
    radius = 2 * modulus * a_hertz / (math.pi * peak)
    load = 4 * modulus * a_hertz**3 / (3 * radius)
    pixel = (side / POINTS, side / POINTS)
    ball = rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, radius), pixel)
    result = rc.solve(ball, material=steel, load=load)
    return load / result.perimeter_corrected_area / steel.yield_strength


def kogut_etsion(load_ratio: np.ndarray) -> np.ndarray:
    """Return the mean pressure in yield strengths after Kogut and Etsion (2002)."""
    light = 1.19 * ((load_ratio / 1.03) ** (1 / 1.425)) ** 0.289
    heavy = 1.61 * ((load_ratio / 1.40) ** (1 / 1.263)) ** 0.117
    change = 1.03 * 6**1.425
    return np.where(load_ratio < change, light, heavy)


loads = np.geomspace(0.3, 1000, 22)
model = [mean_pressure_of_the_model(ratio) for ratio in loads]
fine = np.geomspace(0.3, 1000, 300)
elastic = 2 / 3 * first_yield * fine ** (1 / 3)
measured = fine[(fine > 1.03) & (fine < 1.40 * 110**1.263)]

figure, axes = plt.subplots(figsize=(8, 4.6), layout="constrained")
axes.axvspan(0.3, 1, color="#eef5fb")
axes.axvspan(1, (3 / first_yield) ** 3, color="#f6e3c5")
axes.axvspan((3 / first_yield) ** 3, 1000, color="#f4cdb8")
for place, text in (
    (0.55, "elastic"),
    (2.5, "yielding below\nthe surface"),
    (250, "saturated at\nthe surface"),
):
    axes.text(place, 3.55, text, ha="center", va="top", fontsize=9)
axes.semilogx(fine, elastic, "k:", lw=1.2, label="Hertz, elastic")
axes.semilogx(
    loads, model, "o-", ms=4, color="#7f0d1b", label="this model: ceiling 3 $\\sigma_Y$, solved"
)
axes.semilogx(
    measured,
    kogut_etsion(measured),
    "-",
    color="#0072b2",
    label="Kogut and Etsion 2002, finite elements",
)
axes.axhline(3, color="0.5", lw=0.8)
axes.set(
    xlabel="load / load of first yield",
    ylabel="mean contact pressure / $\\sigma_Y$",
    xlim=(0.3, 1000),
    ylim=(0.5, 3.6),
)
axes.legend(frameon=False, loc="lower right")
