r"""
13 A roller on a strip of raceway
=================================

A line contact is long one way and narrow the other: rollers, gears, seals. A map shows a short
piece of it. Taken as ``free``, the piece has ends that the roller has not, with peaks of pressure
on them; taken as ``periodic``, it has neighbors across the contact that do not exist.
``boundary="periodic-x"`` repeats the map along x, the axis of the roller, and ends it along y.
"""

# %%
# First a smooth roller of 10 mm radius under 20 N/mm, with a contact half as wide as
# the map. Without a ceiling this is the line contact of Hertz.

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import shapes

POINTS = 128

radius, line_load = 0.01, 2e4
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=2e9)
modulus = rc.contact_modulus(steel, rc.RIGID)
half_width = math.sqrt(4 * line_load * radius / (math.pi * modulus))
p_hertz = 2 * line_load / (math.pi * half_width)
side = 4 * half_width
pixel = (side / POINTS, side / POINTS)
load = line_load * side

heights = shapes.cylinder((POINTS, POINTS), pixel, radius)
roller = rc.Surface(heights, pixel)
boundaries = ("free", "periodic", "periodic-x")
smooth = {
    boundary: rc.solve(roller, material=steel, load=load, boundary=boundary, ceiling=None)
    for boundary in boundaries
}
for boundary, result in smooth.items():
    print(f"{boundary:12s} largest pressure over Hertz: {result.max_pressure / p_hertz:.4f}")

# %%
# Only the strip has the pressure of Hertz, the same on every cut. The free piece has peaks on its
# ends, as high as the pixels are small, and too little in between; the periodic one is pressed up
# by its neighbors across.

peak_error = smooth["periodic-x"].max_pressure / p_hertz - 1
assert abs(peak_error) < 1e-3

y = (np.arange(POINTS) - (POINTS - 1) / 2) * pixel[0]
figure, (across, along) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
colours = dict(zip(boundaries, ("tab:orange", "tab:green", "tab:blue"), strict=True))
middle = POINTS // 2
for boundary, result in smooth.items():
    style = {"color": colours[boundary], "label": boundary}
    across.plot(y / half_width, result.pressure[:, middle] / p_hertz, **style)
    along.plot(y / half_width, result.pressure[middle] / p_hertz, **style)
rho = np.linspace(-1, 1, 400)
across.plot(rho, np.sqrt(1 - rho**2), "k:", lw=1, label="Hertz")
across.set(xlabel="across the roller, $y/a$", ylabel="pressure over $p_H$")
along.set(xlabel="along the roller, $x/a$", ylim=(0, 2))
for axes in (across, along):
    axes.spines[["top", "right"]].set_visible(False)
across.legend(frameon=False)
plt.show()

# %%
# Now the raceway is rough. The generated map repeats along both axes, as the strip wants it along
# x; a measured one has a seam there, at which its two edges meet.

rough = rc.self_affine(
    (POINTS, POINTS),
    pixel,
    rms_height=2e-8,
    rolloff_wavelength=side / 4,
    cutoff_wavelength=max(side / 32, 2 * pixel[0]),
    rng=np.random.default_rng(4),
)
pressed = rc.Surface(heights + rough, pixel)
result = rc.solve(pressed, material=steel, load=load, boundary="periodic-x")
print(result.status, result.regime, f"{result.spots().count} spots")

figure, axes = plt.subplots(figsize=(6, 4.2), layout="constrained")
extent = [1e6 * edge for edge in (0, side, side, 0)]
image = axes.imshow(1e-9 * result.pressure, cmap="magma_r", extent=extent)
axes.set(xlabel="x along the roller [µm]", ylabel="y [µm]")
figure.colorbar(image, label="pressure [GPa]")
plt.show()

# %%
# The approach of a line contact needs a datum, as a line load displaces a half-space without
# bound: here a uniform line load causes no displacement at the distance d of the longer side of the map,
# and the approach is :math:`W'/(\pi E^*)\, (2 \ln(2d/a) + 1)`. Between two loads on one map only the
# difference counts, and pressure, area and gap do not depend on it.

expected = line_load / (math.pi * modulus) * (2 * math.log(2 * side / half_width) + 1)
print(f"approach {smooth['periodic-x'].approach:.4g} m, line contact {expected:.4g} m")
