r"""
15 Partial slip and fretting
============================

A ball is pressed on its like and pulled sideways with half of the force that would slide it. Its
middle sticks, its edge slips. A force that alternates slips there forward and backward: the loop of
force over shift has an area, and cracks start behind the slipping edge. ``rc.tangential`` finds all of
it, here and on a rough surface.
"""

# %%
# A cycle
# -------
# Mindlin and Deresiewicz (1953) give the energy of a cycle for bodies without Poisson's ratio.

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import shapes

POINTS = 192

radius, load, friction, part = 10e-3, 1.0, 0.5, 0.5
body = rc.Material(young=210e9, poisson=0.0)
a_hertz = (3 * load * radius / (4 * rc.contact_modulus(body, body))) ** (1 / 3)
p_hertz = 1.5 * load / (math.pi * a_hertz**2)
pixel = (2.6 * a_hertz / POINTS,) * 2
ball = rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, radius), pixel)
contact = rc.solve(ball, material=body, counter_material=body, load=load, tolerance=1e-8)

most = part * friction * load
ramp = most * np.arange(1, 9) / 8
forces = [*ramp, *ramp[-2::-1], 0.0, *-ramp, *-ramp[-2::-1], 0.0, *ramp]
path = rc.tangential(contact, friction=friction, force=forces)
cycle = rc.tangential(contact, friction=friction, force=[most, -most, most], stress=True)

compliance = 2 * 2 * 2 / 210e9  # Σ(2 - ν)/G
exact = (
    9
    * (friction * load) ** 2
    / (10 * a_hertz)
    * compliance
    * (1 - (1 - part) ** (5 / 3) - 5 * part / 6 * (1 + (1 - part) ** (2 / 3)))
)
energy_error = cycle.cycle_energy / exact - 1
print(f"energy of a cycle {cycle.cycle_energy * 1e9:.3f} nJ, exact {exact * 1e9:.3f} nJ")

figure, (loop, state) = plt.subplots(1, 2, figsize=(9.5, 4), layout="constrained")
loop.plot(1e9 * path.column("shift"), path.column("force"), ".-", color="#0072b2")
loop.plot(0, 0, ".", color="#0072b2")
loop.set(xlabel="shift [nm]", ylabel="tangential force [N]")
loop.set_title("The loop closes; its area is friction", loc="left", fontsize=11)
half = 1.3
state.imshow(
    np.where(cycle.bound > 0, np.where(cycle.stick, 1.0, 0.5), np.nan),
    cmap="Blues",
    vmin=0,
    vmax=1.2,
    extent=(-half, half, half, -half),
)
angle = np.linspace(0, 2 * math.pi, 200)
stick_radius = (1 - part) ** (1 / 3)
state.plot(stick_radius * np.cos(angle), stick_radius * np.sin(angle), "k--", lw=1, label="Mindlin")
state.set(xlabel="$x/a$", ylabel="$y/a$")
state.set_title(f"{cycle.last.stick_fraction:.0%} of the contact sticks", loc="left", fontsize=11)
state.legend(frameon=False)

# %%
# Tension behind the edge
# -----------------------
# The traction pulls to the right, so the surface is in tension at the left edge. Ruiz' parameter is
# tension times traction times slip. It is zero where the contact sticks, under compression, and at the
# edge, where the traction ends. It is largest a little inside the left edge: there cracks start.

below = cycle.fretting
middle = POINTS // 2
x = (np.arange(POINTS) - (POINTS - 1) / 2) * pixel[1] / a_hertz
figure_line, axes = plt.subplots(figsize=(7.5, 4), layout="constrained")
axes.plot(x, cycle.traction[1, middle] / p_hertz, color="#0072b2", label="traction")
axes.plot(x, below.tension[middle] / p_hertz, color="#d55e00", label="tension")
axes.plot(
    x, below.ruiz[middle] / below.max_ruiz, ":", color="k", label="Ruiz' parameter over its largest"
)
axes.axvspan(-stick_radius, stick_radius, color="0.85", zorder=0, label="stick")
axes.set(xlabel="$x/a$", ylabel="stress over the peak pressure", ylim=(-0.1, None))
axes.legend(frameon=False)
print(f"largest tension {below.stress.max_tension / p_hertz:.2f} of the peak pressure")
print(f"largest σ_t τδ {below.max_ruiz * 1e-9:.2f} MPa²·mm")

# %%
# A rough surface
# ---------------
# Each spot is such a contact. Small spots slip as a whole, large ones at their edges alone.

heights, rough_pixel = rc.reference_map(POINTS)
rough = rc.Surface(0.5 * heights, rough_pixel)
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
spots = rc.solve(rough, material=steel, counter_material=steel, load=1.0, boundary="periodic")
fretted = rc.tangential(spots, friction=0.15, force=0.075, stress=True)
print(fretted)
figure_slip = fretted.plot()
figure_fretting = fretted.plot.fretting()

# %%
# The number to check: the energy of a cycle of the ball,

print(f"energy of a cycle: {energy_error:+.1e} from the closed form")
assert abs(energy_error) < 2e-3  # the stick zone is some pixels in radius
