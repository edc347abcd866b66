r"""
05 A load curve
===============

Real contact area, gap, stiffness and spots over four decades of load, compared with the simple laws
say: area in proportion to load at first (:math:`A = \kappa W/(E^* h')`), Persson's theory on the
way, and the ceiling at the end.
"""

# %%
# ``rc.sweep`` starts every load from the solution before. With ``folder=`` it saves every step and
# resumes. The map is periodic, as in the theories. Its shortest wave has sixteen pixels, so that the
# areas do not depend on the grid.

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.contact import load_case

POINTS = 512

side = 1e-4
pixel = (side / POINTS, side / POINTS)
heights = rc.self_affine(
    (POINTS, POINTS),
    pixel,
    rms_height=0.2e-6,
    rolloff_wavelength=side / 8,
    cutoff_wavelength=16 * pixel[0],
    rng=np.random.default_rng(1),
)
surface = rc.Surface(heights, pixel)
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
loads = load_case.space_values(0.3, 300, 10)
curves = {
    "elastic": rc.sweep(surface, material=steel, loads=loads, ceiling=None, boundary="periodic"),
    "ceiling 3 GPa": rc.sweep(
        surface,
        material=steel,
        loads=[w for w in loads if w < 0.99 * 3e9 * side**2],
        boundary="periodic",
    ),
}

# %%
# Area
# ----

colours = {"elastic": "#0072b2", "ceiling 3 GPa": "#7f0d1b"}
figure, axes = plt.subplots(figsize=(7.2, 4.6), layout="constrained")
for name, curve in curves.items():
    fraction = curve.column("perimeter_corrected_area") / curve.nominal_area
    theory, _ = curve.persson
    axes.loglog(curve.column("load"), fraction, "o", color=colours[name], label=f"{name}, solved")
    axes.loglog(
        curve.column("load"),
        theory / curve.nominal_area,
        "-",
        lw=1,
        color=colours[name],
        label=f"{name}, Persson",
    )
elastic = curves["elastic"]
low = np.array([0.3, 10])
line = (
    elastic.low_load_slope
    * low
    / (elastic.contact_modulus * elastic.rms_gradient)
    / elastic.nominal_area
)
axes.loglog(low, line, "k--", lw=1, label=rf"$\kappa$ = {elastic.low_load_slope:.2f}")
axes.set(xlabel="load [N]", ylabel="contact area / nominal area", ylim=(None, 1.3))
axes.set_title("Area grows with load, up to all there is", loc="left", fontsize=11)
axes.legend(frameon=False, fontsize=9)

# %%
# Gap, stiffness, spots
# ---------------------
# The mean gap falls, the stiffness rises in proportion to the load, and the number of spots has a
# maximum where they begin to merge.

figure_rest, panels = plt.subplots(1, 3, figsize=(10, 3.4), layout="constrained")
for name, curve in curves.items():
    w = curve.column("load")
    panels[0].semilogx(
        w, curve.column("mean_gap") * 1e6, "o-", ms=4, color=colours[name], label=name
    )
    finite = np.isfinite(curve.column("stiffness")) & (curve.column("stiffness") > 0)
    panels[1].loglog(
        w[finite], curve.column("stiffness")[finite] / 1e6, "o-", ms=4, color=colours[name]
    )
    panels[2].semilogx(w, curve.column("spots"), "o-", ms=4, color=colours[name])
for axes, label in zip(panels, ("mean gap [µm]", "stiffness [N/µm]", "contact spots"), strict=True):
    axes.set(xlabel="load [N]", ylabel=label)
panels[0].legend(frameon=False)

# %%
# The slope :math:`\kappa` at light load differs between theories. Persson's theory has
# :math:`\sqrt{8/\pi} = 1.60`, the asperity theory of Bush, Gibson and Thomas :math:`\sqrt{2\pi} =
# 2.51`, and boundary elements between 1.8 and 2.3 (Hyun et al. 2004).

kappa = elastic.low_load_slope
print(f"low-load slope κ = {kappa:.2f}")
print(f"RMS slope h′ = {elastic.rms_gradient:.3f}")
assert abs(kappa - 2.1) < 0.5  # one small map scatters
