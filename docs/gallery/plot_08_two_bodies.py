r"""
08 Two rough bodies on nominal forms
====================================

Bodies in machines are seldom flat. Here two cylinders cross, each with its own roughness,
measured on two different grids. Without roughness they touch like a ball on a flat: the roughness
then shows what it changes.
"""

# %%
# Nominal forms are surfaces like any others; ``with_form`` puts roughness on them, and
# ``align=True`` of ``roughcontact.solve`` brings two maps to one grid.

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import nominal_bodies, placement
from roughcontact.theory import hertz

POINTS = 256

side, radius = 2e-4, 5e-3
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=2e9)
modulus = rc.contact_modulus(steel, steel)
load = 2.0
a_hertz = hertz.contact_radius(load, radius, modulus)
p_hertz = hertz.max_pressure(load, radius, modulus)
print(f"Hertz: contact radius {a_hertz * 1e6:.1f} µm, largest pressure {p_hertz / 1e9:.2f} GPa")


def roughness(points: int, rms: float, seed: int) -> rc.Surface:
    """Return a rough flat on a grid of its own."""
    pixel = (side / points, side / points)
    return rc.Surface(
        rc.self_affine(
            (points, points),
            pixel,
            rms_height=rms,
            rolloff_wavelength=side / 10,
            cutoff_wavelength=side / 40,
            rng=np.random.default_rng(seed),
        ),
        pixel,
    )


def solve_cylinders(rms: float) -> rc.ContactResult:
    """Press one rough cylinder across the other."""
    first, second = placement.match_grids(
        roughness(POINTS, rms, 1), roughness(POINTS * 3 // 4, rms, 2)
    )
    lower = first.masked().with_form(
        nominal_bodies.cylinder(radius=radius, angle=0, shape=first.shape, pixel=first.pixel)
    )
    upper = second.masked().with_form(
        nominal_bodies.cylinder(radius=radius, angle=90, shape=first.shape, pixel=first.pixel)
    )
    return rc.solve(lower, counter_surface=upper, material=steel, counter_material=steel, load=load)


# %%
# Three qualities of finish, from polished to ground.

finishes = {1e-9: "Sq 1 nm each", 50e-9: "Sq 50 nm each", 300e-9: "Sq 300 nm each"}
results = {rms: solve_cylinders(rms) for rms in finishes}

figure, panels = plt.subplots(1, 3, figsize=(10.5, 3.9), sharey=True, layout="constrained")
circle = np.linspace(0, 2 * math.pi, 200)
for axes, (rms, name) in zip(panels, finishes.items(), strict=True):
    result = results[rms]
    extent = 1e6 * np.array([-side, side, side, -side]) / 2
    shown = np.where(result.contact, result.pressure / 1e9, np.nan)
    image = axes.imshow(shown, cmap="inferno_r", vmin=0, vmax=6, extent=extent)
    axes.plot(a_hertz * 1e6 * np.cos(circle), a_hertz * 1e6 * np.sin(circle), "k--", lw=1)
    axes.set_facecolor("#f1f1ee")
    axes.set(title=name, xlabel="x [µm]", xlim=(-60, 60), ylim=(60, -60))
panels[0].set_ylabel("y [µm]")
figure.colorbar(image, ax=panels, label="pressure [GPa]", shrink=0.85)
figure.suptitle(
    "Roughness breaks the circle of Hertz (dashed) into spots and spreads them", fontsize=11
)

# %%
# Roughness spreads the load over a wider region, on less area. Greenwood and Tripp (1967) described it:
# roughness matters once its height is no longer small against the approach of the smooth bodies,
# here

approach = hertz.approach(load, radius, modulus)
print(f"approach of the smooth bodies {approach * 1e6:.3f} µm")
y, x = (np.indices(results[1e-9].pressure.shape) - (POINTS - 1) / 2) * side / POINTS
for rms, name in finishes.items():
    result = results[rms]
    spread = math.sqrt((result.pressure * (x**2 + y**2)).sum() / result.pressure.sum())
    print(
        f"{name}: contact {result.contact_area * 1e12:5.0f} µm², load within "
        f"{spread * 1e6:.1f} µm (root mean square), {result.regime}"
    )

# %%
# The polished pair is Hertz's contact, although it was measured on two grids and has the form of
# two cylinders:

radius_error = abs(math.sqrt(results[1e-9].perimeter_corrected_area / math.pi) / a_hertz - 1)
print(f"contact radius within {100 * radius_error:.1f} % of Hertz")
assert radius_error < 0.04  # half a pixel
