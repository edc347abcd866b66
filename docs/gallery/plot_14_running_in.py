r"""
14 A ground raceway runs in
===========================

A roller passes over a ground raceway at a Hertz pressure of 1.5 GPa. Smooth, the contact would stay
elastic; the peaks of the roughness do not. How many passes does it take until they have been
pressed in, what roughness is left, and what residual stress below it? The volume model follows each
step of each pass. The model of the source paper, a ceiling on the pressure, does the same at the
surface alone, in a tenth of the time, and is compared with it.
"""

# %%
# A strip of ground steel with its lay along the axis of the roller. It is generated here, and
# periodic; `read_surface` takes a measured one. The yield strength is that of a hardened bearing
# steel, 1.7 GPa, and grows by 20 GPa times the plastic strain.

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.analyses.history.model import Stage
from roughcontact.surface import nominal_bodies

POINTS = 96
PASSES, STEPS = 10, 16
LENGTH, RADIUS, HERTZ = 200e-6, 2e-3, 1.5e9

grid = {"shape": (POINTS // 4, POINTS), "pixel": (LENGTH / POINTS, LENGTH / POINTS)}
ground = rc.generate(
    **grid, Sq=0.2e-6, Sal=6e-6, cutoff_wavelength=9e-6, Str=0.3, lay=90.0, Ssk=-0.5, rng=4
)
roller = nominal_bodies.cylinder(radius=RADIUS, angle=90.0, **grid)
steel = rc.Material(young=210e9, poisson=0.3, hardening=rc.hardening.Linear("1.7 GPa", "20 GPa"))
load = math.pi * HERTZ**2 * RADIUS / rc.contact_modulus(steel, rc.RIGID) * LENGTH / 4

# %%
# Ten passes in one direction over the period of the map. The contact of each is solved at sixteen
# positions, every half of a contact half-width, 26 µm.

rolled = rc.roll(
    ground,
    counter_surface=roller,
    material=steel,
    load=load,
    passes=PASSES,
    steps=STEPS,
    boundary="periodic",
)
before = ground.roughness()
left = {name: getattr(rolled.passes[-1], name) / before[name] for name in ("Sq", "Spk")}
print(f"left of Sq {left['Sq']:.0%}, of Spk {left['Spk']:.0%}")
assert 0.25 < left["Spk"] < 0.55  # the peaks that stood out go on the first pass
print(rolled)

# %%
# Nearly all plastic strain is from the first pass: peaks with more than four Hertz pressures yield.
# The second pass adds a twentieth of it, each later one a sixth of the one before. After three passes
# the strain added is below a hundredth of the yield strain, and the raceway carries the roller without
# yielding. The largest pressure is then four times that of the smooth contact. Running-in lowers the
# peaks (Spk) and leaves the valleys, so that Sq changes little.

figure, (adding, heights) = plt.subplots(1, 2, figsize=(10.5, 4), layout="constrained")
number = np.arange(1, PASSES + 1)
adding.semilogy(
    number, [100 * one.strain_added for one in rolled.passes], "o-", label="largest, added"
)
adding.axhline(100 * rolled.strain_threshold, color="0.4", ls="-.", label="negligible")
adding.set(xlabel="pass", ylabel="plastic strain by the pass [%]")
adding.legend(frameon=False)
for name, colour in (("Sq", "tab:blue"), ("Spk", "tab:orange")):
    values = [before[name], *(getattr(one, name) for one in rolled.passes)]
    heights.plot(range(PASSES + 1), 1e9 * np.array(values), "o-", color=colour, label=name)
heights.set(xlabel="passes done", ylabel="roughness without load [nm]", ylim=(0, None))
heights.legend(frameon=False)

# %%
# The residual stress below the surface is compressive, here as the mean of each layer that X-rays
# measure. It is largest a few micrometers deep and vanishes within two or three correlation lengths.
# The peaks are its cause: the smooth roller, at p₀ = 0.88 σ_Y, reaches only half of the yield strength,
# at a depth of 0.7 half-widths, 18 µm.

faces = 1e6 * np.append(0.0, np.cumsum(rolled.result.bodies[0].thickness))
figure_below, panels = plt.subplots(1, 2, figsize=(9.5, 4.2), sharey=True, layout="constrained")
for axes, key, name in zip(
    panels, ("residual_along", "residual_across"), ("rolling", "axis"), strict=True
):
    for which, colour in ((0, "#9ecae1"), (PASSES - 1, "#08306b")):
        (stress,) = getattr(rolled.passes[which], key)
        axes.stairs(
            1e-6 * stress,
            faces[: stress.size + 1],
            orientation="horizontal",
            baseline=None,
            color=colour,
            lw=2,
            label=f"pass {which + 1}",
        )
    axes.axvline(0, color="k", lw=0.8)
    axes.set_xlabel(f"residual stress along the {name} [MPa]")
panels[0].set(ylabel="depth [µm]", ylim=(faces[-1], 0))
panels[0].legend(frameon=False)
compression = rolled.passes[-1].in_plane_stress

# %%
# The ceiling model, with three times the yield strength, 5.1 GPa, indents the surface wherever the
# pressure would be higher. ``rc.history`` follows the same positions.

stages = [Stage(load, shift=(0.0, LENGTH * step / STEPS)) for step in range(STEPS)]
capped, surface = [], ground
for _ in range(PASSES):
    history = rc.history(
        surface, stages, material=steel, counter_surface=roller, boundary="periodic"
    )
    surface = history.residual
    capped.append((surface.roughness(), max(step.max_pressure for step in history.steps)))
peaks = [rolled.passes[-1].max_pressure, capped[-1][1]]
print("largest pressure, volume and ceiling:", *(f"{1e-9 * peak:.2f} GPa" for peak in peaks))
print(
    "Spk left, volume and ceiling:",
    f"{left['Spk']:.0%}, {capped[-1][0]['Spk'] / before['Spk']:.0%}",
)

figure_models, (spk, profile) = plt.subplots(1, 2, figsize=(10.5, 4), layout="constrained")
values = [before["Spk"], *(one.Spk for one in rolled.passes)]
spk.plot(range(PASSES + 1), 1e9 * np.array(values), "o-", color="#0072b2", label="volume")
values = [before["Spk"], *(values["Spk"] for values, _ in capped)]
spk.plot(range(PASSES + 1), 1e9 * np.array(values), "s--", color="#7f0d1b", label="ceiling")
spk.set(xlabel="passes done", ylabel="Spk [nm]", ylim=(0, None))
spk.legend(frameon=False)

row = int(np.unravel_index(rolled.result.residual_displacement.argmax(), grid["shape"])[0])
x = 1e6 * (np.arange(POINTS) + 0.5) * LENGTH / POINTS
shown = (
    (ground, "0.5", "-", "before"),
    (rolled.rolled_surface, "#0072b2", "-", "volume"),
    (surface, "#7f0d1b", "--", "ceiling"),
)
for what, colour, line, name in shown:
    profile.plot(x, 1e9 * what.heights[row], line, color=colour, label=name)
profile.set(xlabel="x [µm]", ylabel=f"height after {PASSES} passes [nm]")
profile.legend(frameon=False)

# %%
# Both models indent the same peaks, and both reach shakedown. They differ in three respects:
#
# * the ceiling cuts all peaks at one pressure and gives them flat tops: it leaves less of Spk, and
#   more of Sq;
# * in the elastoplastic model the largest pressure exceeds three initial yield strengths, because the
#   metal has hardened. This ceiling does not include hardening;
# * only the elastoplastic model has residual stress and strain, and can show ratcheting.
#
# Use the ceiling for a first estimate of running-in, and the elastoplastic model for residual stress and
# for shakedown.
