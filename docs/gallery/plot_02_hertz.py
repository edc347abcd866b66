r"""
02 Hertz, elastic and with ceilings
===================================

A sphere on a flat is the contact that has an exact solution. In the coordinates
:math:`r/a_\mathrm{H}` and :math:`p/p_\mathrm{H}` every sphere, material and load falls on one
curve, and every ceiling adds one more. This is the check that the source paper opens with.
"""

# %%
# The load is chosen so that the map is four contact radii wide. Nothing else matters: in these
# coordinates the result does not depend on the radius of the ball or on the steel.

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.theory import hertz

POINTS = 256

radius, side = 1e-3, 1e-4
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
modulus = rc.contact_modulus(steel, rc.RIGID)
a_hertz = side / 4
load = 4 * modulus * a_hertz**3 / (3 * radius)
p_hertz = hertz.max_pressure(load, radius, modulus)
pixel = (side / POINTS, side / POINTS)
ball = rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, radius), pixel)

fractions = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
results = {1.0: rc.solve(ball, material=steel, load=load, ceiling=None)}
for fraction in fractions[1:]:
    results[fraction] = rc.solve(ball, material=steel, load=load, ceiling=fraction * p_hertz)

# %%
# Each point of the next figure is a pixel, at its distance from the axis. The points of one ceiling
# form one line, so the square grid has no effect.

centre = (np.array(ball.shape) - 1) / 2
y, x = (np.indices(ball.shape) - centre[:, None, None]) * pixel[0]
r = np.hypot(y, x)

figure, axes = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
colours = plt.colormaps["viridis"](np.linspace(0, 0.9, len(fractions)))
for colour, (fraction, result) in zip(colours, results.items(), strict=True):
    touching = result.contact
    label = "no ceiling" if fraction == 1.0 else f"{fraction:g} $p_H$"
    axes.plot(
        r[touching] / a_hertz,
        result.pressure[touching] / p_hertz,
        ".",
        ms=2.5,
        color=colour,
        label=label,
    )
rho = np.linspace(0, 1, 400)
axes.plot(rho, np.sqrt(1 - rho**2), "k-", lw=1, label="Hertz, exact")
axes.set(xlabel="$r/a_H$", ylabel="$p/p_H$", xlim=(0, 1.6), ylim=(0, 1.05))
axes.set_title("A ceiling cuts the pressure and widens the contact", loc="left", fontsize=11)
axes.legend(markerscale=4, fontsize=8.5, frameon=False, ncols=2)

# %%
# The radii follow. Where the contact is fully saturated the load is :math:`p_\mathrm{lim}\pi
# a^2`, so that :math:`a/a_\mathrm{H} = \sqrt{2/(3f)}` with :math:`f =
# p_\mathrm{lim}/p_\mathrm{H}`: an exact limit for low ceilings.

radii, saturated_radii = {}, {}
for fraction, result in results.items():
    # The corrected area leaves out what the pixels on the elastic rim add.
    radii[fraction] = math.sqrt(result.perimeter_corrected_area / math.pi) / a_hertz
    area = np.count_nonzero(result.saturated) * result.pixel_area
    saturated_radii[fraction] = math.sqrt(area / math.pi) / a_hertz

print("p_lim/p_H   a/a_H   saturated radius/a_H   limit")
for fraction in fractions:
    limit = hertz.saturated_radius_ratio(fraction)
    print(f"{fraction:9.1f} {radii[fraction]:7.3f} {saturated_radii[fraction]:22.3f} {limit:7.3f}")

figure, axes = plt.subplots(figsize=(7.5, 3.8), layout="constrained")
f = np.linspace(0.28, 1, 200)
axes.plot(f, np.sqrt(2 / (3 * f)), "k--", lw=1, label=r"fully saturated, $\sqrt{2/(3f)}$")
axes.plot(radii.keys(), radii.values(), "o-", color="#0072b2", label="contact radius")
axes.plot(
    saturated_radii.keys(),
    saturated_radii.values(),
    "s-",
    color="#d55e00",
    label="saturated radius",
)
axes.set(xlabel=r"ceiling $f = p_\mathrm{lim}/p_H$", ylabel="radius / $a_H$", ylim=(0, 1.6))
axes.set_title(
    "Below half the Hertz pressure nearly all of the contact is saturated", loc="left", fontsize=11
)
axes.legend(frameon=False)

# %%
# Away from the contact edge the elastic pressure agrees with Hertz to

inside = r < 0.9 * a_hertz
exact = hertz.pressure(r, a_hertz, p_hertz)
pressure_error = float(np.abs(results[1.0].pressure - exact)[inside].max() / p_hertz)
print(f"{100 * pressure_error:.2f} % of the peak pressure on {POINTS} × {POINTS} points")
assert pressure_error < 0.005
