"""
07 From a raw measurement to a contact
======================================

A measurement is not yet a surface: the sample lay askew, the instrument lost points and invented
spikes, and the form of the part hides its roughness. Each step of the preparation is one method,
and the provenance keeps them in order.
"""

# %%
# A ball of 8 mm radius as an optical profilometer shows it: tilted, rough, with spikes and lost
# points. As it is made here, the truth is known.

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface.form import remove_form

POINTS = 256

side, radius = 2e-4, 8e-3
pixel = (side / POINTS, side / POINTS)
rng = np.random.default_rng(4)
y, x = (np.indices((POINTS, POINTS)) - POINTS / 2 + 0.5) * pixel[0]
roughness = rc.self_affine(
    (POINTS, POINTS),
    pixel,
    rms_height=0.05e-6,
    rolloff_wavelength=side / 10,
    cutoff_wavelength=4 * pixel[0],
    rng=rng,
)
truth = np.sqrt(radius**2 - x**2 - y**2) - radius + roughness
raw = truth + 0.004 * x - 0.002 * y
spikes = rng.random(raw.shape) < 1e-3
raw[spikes] += rng.uniform(0.5e-6, 2e-6, np.count_nonzero(spikes))
patch = (rng.normal(size=(POINTS // 8, POINTS // 8)) > 2.0).repeat(8, 0).repeat(8, 1)
raw[patch] = np.nan
measured = rc.Surface(raw, pixel, rc.Provenance(source="simulated measurement of a ball"))
print(f"{measured.missing} points are missing, {np.count_nonzero(spikes & ~patch)} are spikes")

# %%
# Remove spikes first, because they affect every later fit. Then fit the form, and fill missing points.

clean = measured.without_outliers()
rough = clean.without_form("sphere")
whole = rough.filled()
smooth = whole.filtered(s=4 * pixel[0])
for step in smooth.provenance.steps:
    print("-", step)

figure, panels = plt.subplots(1, 4, figsize=(12, 3.4), layout="constrained")
titles = ("as measured", "without spikes", "without the sphere", "filled and filtered")
for axes, surface, title in zip(panels, (measured, clean, rough, smooth), titles, strict=True):
    heights = 1e6 * (surface.heights - np.nanmedian(surface.heights))
    low, high = np.nanquantile(heights, [0.002, 0.998])
    extent = np.array([0, side, side, 0]) * 1e6
    colours = plt.colormaps["viridis"].with_extremes(bad="#d62728")
    image = axes.imshow(heights, cmap=colours, vmin=low, vmax=high, extent=extent)
    bar = figure.colorbar(image, ax=axes, orientation="horizontal", shrink=0.9, label="height [µm]")
    axes.set_title(title, fontsize=11)
    axes.set(xlabel="x [µm]")
panels[0].set_ylabel("y [µm]")
figure.suptitle("Missing points in red", fontsize=10, x=0.01, ha="left")

# %%
# The fitted radius is right in spite of roughness, tilt and missing points:

_, found = remove_form(clean.heights, pixel, "sphere")
radius_error = abs(found["radius"] / radius - 1)
print(
    f"radius {found['radius'] * 1e3:.3f} mm, true {radius * 1e3:.3f} mm: {100 * radius_error:.2f} % off"
)
assert radius_error < 0.02
print(f"roughness Sq {whole.Sq * 1e9:.1f} nm, true {roughness.std() * 1e9:.1f} nm")

# %%
# Effect on the contact
# ---------------------
# The ball is pressed on a flat, once with its spikes and once without. Filling keeps the form:
# only the tilt is removed before, for the highest point decides where the ball touches.

steel = rc.Material(young=210e9, poisson=0.3, yield_strength=2e9)
load = 0.5
with_spikes = rc.solve(measured.leveled().filled(), material=steel, load=load)
without = rc.solve(clean.leveled().filled(), material=steel, load=load)
exact = rc.solve(rc.Surface(truth, pixel).leveled(), material=steel, load=load)
for name, result in (("with spikes", with_spikes), ("without", without), ("the true ball", exact)):
    print(
        f"{name:14} contact {result.contact_area * 1e12:6.1f} µm², "
        f"mean gap {result.mean_gap * 1e6:.3f} µm, {result.spots().count} spots"
    )

figure_pressure, panels = plt.subplots(1, 3, figsize=(10, 3.6), sharey=True, layout="constrained")
for axes, (name, result) in zip(
    panels,
    (("with spikes", with_spikes), ("without spikes", without), ("the true ball", exact)),
    strict=True,
):
    shown = np.where(result.contact, result.pressure / 1e9, np.nan)
    image = axes.imshow(
        shown, cmap="inferno_r", vmin=0, vmax=6, extent=np.array([0, side, side, 0]) * 1e6
    )
    axes.set_facecolor("#f1f1ee")
    axes.set(title=name, xlabel="x [µm]", xlim=(60, 140), ylim=(140, 60))
panels[0].set_ylabel("y [µm]")
figure_pressure.colorbar(image, ax=panels, label="pressure [GPa]", shrink=0.85)
