r"""
04 The source paper, repeated
=============================

*An engineering model for pressure assessment in rough contacts* solves a measured sample of 0.1
mm × 0.1 mm with 1024 × 1024 heights, elastic and with a ceiling of 3 GPa for a yield strength of
1 GPa. This page goes through its figures with numbers of this program. The radial profiles are in
:ref:`the example before <sphx_glr_examples_plot_02_hertz.py>`; here follow the sample, both
solutions, their areas, and two questions that the paper does not answer, the effects of the ceiling and
on the grid.
"""

# %%
# The sample
# ----------
# The measured map is not public, so one is generated, and its spectrum is stated: self-affine
# with a Hurst exponent of 0.8, flat above a wavelength of 25 µm (four waves per side), nothing
# below eight pixels (0.78 µm), 0.2 µm RMS.

import time

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact import plots
from roughcontact.surface import spectrum

POINTS = 1024

side, load = 1e-4, 1.0
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
heights, pixel = rc.reference_map(POINTS)
surface = rc.Surface(heights, pixel)
figure = plots.surface(surface)

# %%
wave_number, density, _ = spectrum.radial_spectrum(heights, pixel)
q = wave_number / (2 * np.pi)
filled = q < POINTS / 8 / side
figure_spectrum, axes = plt.subplots(figsize=(6.5, 3.8), layout="constrained")
axes.loglog(q[filled], density[filled], "-", color="#0072b2", label="of this map")
roll_off = 4 / side
tail = (q > 2 * roll_off) & filled
reference = density[tail][0] * (q / q[tail][0]) ** (-2 - 2 * 0.8)
axes.loglog(q[tail], reference[tail], "k--", lw=1, label=r"slope $-2-2H$, $H = 0.8$")
axes.axvline(roll_off, color="0.6", lw=0.8)
axes.axvline(POINTS / 8 / side, color="0.6", lw=0.8)
axes.set(xlabel="waves per metre", ylabel="spectral density [m⁴]")
axes.set_title(
    "Flat to 25 µm, self-affine to eight pixels, nothing beyond", loc="left", fontsize=11
)
axes.legend(frameon=False)
print(f"Sq {surface.Sq * 1e6:.3f} µm, RMS slope {surface.Sdq:.3f}")

# %%
# Elastic, and with a ceiling of 3 GPa
# ------------------------------------
# The paper needs "a few seconds" for each. Both are solved here to a certificate of 10⁻⁶.

began = time.perf_counter()
elastic = rc.solve(surface, material=steel, load=load, ceiling=None)
limited = rc.solve(surface, material=steel, load=load)
spent = time.perf_counter() - began
print(f"both solved in {spent:.1f} s on {POINTS} × {POINTS} points")
for name, result in (("elastic", elastic), ("ceiling 3 GPa", limited)):
    print(
        f"{name:14} contact {100 * result.contact_fraction:5.2f} %, largest pressure "
        f"{result.max_pressure / 1e9:6.1f} GPa, certificate {result.certificate:.0e}"
    )
figure_comparison = plots.comparison([elastic, limited], ["elastic", "ceiling 3 GPa"])

# %%
# The elastic solution has pressures above what steel can carry. The ceiling spreads them over a larger
# area.

figure_histogram = plots.pressure_histogram(
    [elastic, limited], ["elastic", "ceiling 3 GPa"], scale="log"
)

# %%
# The elastic spots are inside
# ----------------------------
# The paper observes that the elastic spots are inside the contact with the ceiling. This holds here:
# no summit loses contact when its neighbors yield.

inside = float((elastic.contact & limited.contact).sum() / elastic.contact.sum())
ratio = limited.contact_area / elastic.contact_area
print(f"{100 * inside:.1f} % of the elastic contact lies inside the other")
assert inside > 0.99
print(f"area with the ceiling / elastic area = {ratio:.2f}")

row, column = np.unravel_index(np.argmax(elastic.pressure), elastic.pressure.shape)
half = POINTS // 10
rows = slice(max(row - half, 0), row + half)
columns = slice(max(column - half, 0), column + half)
classes = limited.contact.astype(int) + 2 * elastic.contact
extent = 1e6 * np.array([columns.start, columns.stop, rows.stop, rows.start]) * pixel[0]
figure_spots, axes = plt.subplots(figsize=(6.2, 5), layout="constrained")
colours = plt.matplotlib.colors.ListedColormap(["#f1f1ee", "#f2b880", "#d62728", "#0072b2"])
image = axes.imshow(
    classes[rows, columns],
    cmap=colours,
    vmin=-0.5,
    vmax=3.5,
    extent=extent,
    interpolation="nearest",
)
bar = figure_spots.colorbar(image, ticks=range(4), shrink=0.8)
bar.ax.set_yticklabels(["no contact", "only with ceiling", "only elastic", "both"])
axes.set(xlabel="x [µm]", ylabel="y [µm]")
axes.set_title("The elastic spots lie inside the contact with the ceiling", loc="left", fontsize=11)

# %%
# How the answer depends on the ceiling
# -------------------------------------
# With a low ceiling the area is :math:`W/p_\mathrm{lim}` for any surface. A high ceiling is never
# reached, and the area is the elastic one. On this sample 3 GPa is on the first branch.

ceilings = np.array([1, 1.5, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48]) * 1e9
areas, saturated = [], []
start = limited
for ceiling in ceilings:
    start = rc.solve(surface, material=steel, load=load, ceiling=ceiling, initial_guess=start)
    areas.append(start.contact_fraction)
    saturated.append(start.saturated_fraction)

figure_ceiling, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.loglog(ceilings / 1e9, 100 * np.array(areas), "o-", color="#0072b2", label="contact area")
reached = np.array(saturated) > 0
axes.loglog(
    ceilings[reached] / 1e9,
    100 * np.array(saturated)[reached],
    "s-",
    color="#7f0d1b",
    label="saturated area",
)
axes.loglog(
    ceilings / 1e9, 100 * load / ceilings / side**2, "k--", lw=1, label=r"$W/p_\mathrm{lim}$"
)
axes.axhline(100 * elastic.contact_fraction, color="0.4", ls=":", label="elastic")
axes.set(xlabel="ceiling [GPa]", ylabel="area [% of the map]", ylim=(0.05, None))
axes.set_title("A low ceiling alone decides the contact area", loc="left", fontsize=11)
axes.legend(frameon=False)

# %%
# How it depends on the grid
# --------------------------
# These are two questions. *The same body on a finer grid* has no new waves, and the discretization
# error converges to zero. *A finer measurement* adds shorter waves. The body is steeper, and its
# elastic contact area decreases without limit. Under the ceiling the area is the load over the
# ceiling, on any grid.

grids = [POINTS // 8, POINTS // 4, POINTS // 2, POINTS, 2 * POINTS]
curves: dict[str, list[float]] = {
    "same elastic": [],
    "same ceiling": [],
    "finer elastic": [],
    "finer ceiling": [],
}
slopes = []
for points in grids:
    step = (side / points, side / points)
    same = rc.self_affine(
        (points, points),
        step,
        rms_height=0.2e-6,
        rolloff_wavelength=side / 4,
        cutoff_wavelength=8 * side / grids[0],
        rng=np.random.default_rng(0),
    )
    finer, _ = rc.reference_map(points)
    slopes.append(rc.Surface(finer, step).Sdq)
    for name, body in (("same", same), ("finer", finer)):
        for kind, ceiling in (("elastic", None), ("ceiling", 3e9)):
            found = rc.solve(rc.Surface(body, step), material=steel, load=load, ceiling=ceiling)
            curves[f"{name} {kind}"].append(found.perimeter_corrected_area / side**2)

figure_grid, panels = plt.subplots(1, 2, figsize=(9, 3.9), sharey=True, layout="constrained")
for axes, name, title in zip(
    panels, ("same", "finer"), ("same body, finer grid", "finer measurement"), strict=True
):
    axes.semilogx(
        grids,
        100 * np.array(curves[f"{name} ceiling"]),
        "s-",
        color="#7f0d1b",
        label="ceiling 3 GPa",
    )
    axes.semilogx(
        grids, 100 * np.array(curves[f"{name} elastic"]), "o-", color="#0072b2", label="elastic"
    )
    axes.set_xscale("log", base=2)
    axes.set(xlabel="points per side", title=title, ylim=(0, None))
panels[0].set_ylabel("contact area [% of the map]")
panels[0].legend(frameon=False)

print("points   RMS slope   elastic area   area under 3 GPa")
for points, slope, first, second in zip(
    grids, slopes, curves["finer elastic"], curves["finer ceiling"], strict=True
):
    print(f"{points:6d} {slope:10.3f} {100 * first:12.3f} % {100 * second:14.3f} %")

# %%
# The elastic area of a finer measurement falls as the RMS slope grows, :math:`A = \kappa W/(E^*
# h')`. An elastic contact area without the resolution of the instrument is therefore no result;
# the area under a ceiling hardly depends on it.

elastic_change = curves["finer elastic"][-1] / curves["finer elastic"][0] - 1
ceiling_change = curves["finer ceiling"][-1] / curves["finer ceiling"][0] - 1
print(
    f"from {grids[0]} to {grids[-1]} points per side: elastic area {100 * elastic_change:+.0f} %, "
    f"with the ceiling {100 * ceiling_change:+.1f} %"
)
