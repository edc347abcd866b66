r"""
10 Stress below the surface
===========================

The largest stress lies below a contact, not in it. ``subsurface_stress`` gives the elastic stress
under a solved pressure, at every depth, with friction if there is any; ``first_yield_load`` finds the
load at which the first point yields.
"""

# %%
# Under a ball
# ------------
# The exact answer is known: without friction the von Mises stress is largest on the axis, at
# 0.48 of the contact radius, and there it is 0.62 of the peak pressure (Johnson 1985, sec. 4.2;
# ν = 0.3).

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.analyses.stress.model import first_yield_load, subsurface_stress
from roughcontact.surface import shapes
from roughcontact.theory import hertz

POINTS = 256

radius, side = 1e-3, 1e-4
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
modulus = rc.contact_modulus(steel, rc.RIGID)
pixel = (side / POINTS, side / POINTS)
ball = rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, radius), pixel)
load = 4 * modulus * (side / 6) ** 3 / (3 * radius)
result = rc.solve(ball, material=steel, load=load, ceiling=None)
a_hertz = hertz.contact_radius(load, radius, modulus)
p_hertz = hertz.max_pressure(load, radius, modulus)

depths = a_hertz * np.linspace(0.002, 2, 60)
frictions = (0.0, 0.2, 0.4)
stresses = {mu: subsurface_stress(result, depths, friction=mu) for mu in frictions}

figure, panels = plt.subplots(1, 3, figsize=(11, 3.6), sharey=True, layout="constrained")
for axes, (mu, found) in zip(panels, stresses.items(), strict=True):
    section = found.von_mises_section("x") / p_hertz
    x = (np.arange(POINTS) - (POINTS - 1) / 2) * pixel[1] / a_hertz
    image = axes.contourf(x, depths / a_hertz, section, np.arange(0, 0.81, 0.05), cmap="inferno_r")
    depth, _, place = found.max_von_mises_at
    axes.plot((place - side / 2) / a_hertz, depth / a_hertz, "c+", ms=12, mew=2)
    axes.set(xlabel="$x/a$", title=f"μ = {mu:g}", xlim=(-2, 2))
    print(
        f"μ = {mu:g}: largest von Mises stress {found.max_von_mises / p_hertz:.3f} of the peak "
        f"pressure, at a depth of {depth / a_hertz:.2f} a"
    )
panels[0].set_ylabel("$z/a$")
panels[0].invert_yaxis()
figure.colorbar(image, ax=panels, label="von Mises stress / $p_H$")

# %%
# Friction pulls the maximum towards the surface and to the side of the traction: from a coefficient
# of 0.31 on first yield happens at the surface itself, at the trailing rim.
#
# First yield
# -----------
# The load at which the ball first yields follows from solving, and from Jackson and Green's formula
# :math:`p_Y = 1.295\,\mathrm{e}^{0.736\nu}\sigma_Y`, on which the regime of every result rests.

onset = first_yield_load(ball, material=steel, initial_load=0.2 * load)
formula = hertz.first_yield_load(radius, modulus, steel.first_yield_pressure)
onset_error = abs((onset.solution.load / formula) ** (1 / 3) - 1)
print(f"first yield at {onset.solution.load * 1e3:.2f} mN, by the formula {formula * 1e3:.2f} mN:")
print(f"the peak pressures differ by {100 * onset_error:.2f} %")

# %%
# Under a rough surface
# ---------------------
# Every spot has its own field; from a distance they merge into that of the whole. The largest stress
# is under the most loaded spot, as deep as that spot is wide: a fatigue crack that starts there starts
# at the scale of the roughness.

heights, rough_pixel = rc.reference_map(POINTS)
rough = rc.Surface(heights, rough_pixel)
hard = rc.Material(young=210e9, poisson=0.3, yield_strength=2e9)
contact = rc.solve(rough, material=hard, load=1.0)
below = subsurface_stress(contact, np.geomspace(0.25, 80, 40) * rough_pixel[0])

figure_rough, axes = plt.subplots(figsize=(8.5, 4.2), layout="constrained")
section = below.von_mises_section("x") / 1e9
x = (np.arange(POINTS) + 0.5) * rough_pixel[1] * 1e6
deep = below.profile.depths * 1e6
image = axes.contourf(
    x, deep, section, np.geomspace(0.03, section.max(), 24), norm="log", cmap="inferno_r"
)
axes.set(yscale="log", xlabel="x [µm]", ylabel="depth [µm]")
axes.invert_yaxis()
axes.set_title("Each spot has a field as deep as it is wide", loc="left", fontsize=11)
bar = figure_rough.colorbar(image, label="von Mises stress [GPa]", ticks=[0.03, 0.1, 0.3, 1, 3])
bar.ax.set_yticklabels(["0.03", "0.1", "0.3", "1", "3"])

depth = below.max_von_mises_at[0]
spot = math.sqrt(contact.spots().area[0] / math.pi)
print(f"largest stress {below.max_von_mises / 1e9:.2f} GPa, {depth * 1e6:.2f} µm below the surface")
print(f"the largest spot has a mean radius of {spot * 1e6:.2f} µm")
print(f"elastic stress beyond the yield strength in {below.yielded_volume * 1e18:.0f} µm³")

# %%
# The stress is elastic, under the pressure of the ceiling model. Where it exceeds the yield strength
# it says that the material flows there, not what it carries.
#
# The number to check: under the ball, against 0.620 at ν = 0.3,

ratio = stresses[0.0].max_von_mises / p_hertz
print(f"largest von Mises stress / peak pressure = {ratio:.3f}")
assert abs(ratio - 0.62) < 0.01  # Johnson 1985, sec. 4.2
