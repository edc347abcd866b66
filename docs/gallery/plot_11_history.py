r"""
11 Loading, unloading, and passing again
========================================

A ceiling leaves an indentation behind. ``rc.history`` carries it from stage to stage: unloading
is elastic about the indented surface, and the second loading follows it: at one place the contact
has shaken down after a single pass. A counter-body that rolls along takes longer.
"""

# %%
# One load cycle
# --------------
# Up, down to nothing, and up again.

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.analyses.history.model import history as load_history, repeat_stages

POINTS = 256

heights, pixel = rc.reference_map(POINTS)
surface = rc.Surface(heights, pixel)
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
up = [0.1, 0.25, 0.5, 0.75, 1.0]
cycle = load_history(surface, [*up, 0.75, 0.5, 0.25, 0.1, 0.0, *up], material=steel)

approach, load = cycle.hysteresis
figure, axes = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
axes.plot(1e6 * approach[:5], load[:5], "o-", color="#7f0d1b", label="first loading")
axes.plot(1e6 * approach[4:10], load[4:10], "s--", color="#0072b2", label="unloading")
axes.plot(1e6 * approach[9:], load[9:], "^:", color="#009e73", label="second loading")
axes.set(xlabel="approach [µm]", ylabel="load [N]", ylim=(0, None))
axes.set_title("The second loading follows the unloading", loc="left", fontsize=11)
axes.legend(frameon=False)

print(
    f"permanently indented: {cycle.indentation_volume * 1e18:.2f} µm³, at most {cycle.indentation.max() * 1e9:.0f} nm"
)
print(f"dissipated: {cycle.dissipated_energy * 1e9:.1f} nJ")
print(f"shaken down: {cycle.is_elastic_now}")

# %%
# The loop between loading and unloading is the work that the ceiling has dissipated. The residual
# indentation is shown below. Summits are plateaus where the contact was saturated.

figure_indented, axes = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
shown = np.where(cycle.indentation > 0, 1e9 * cycle.indentation, np.nan)
side = 1e6 * surface.size[0]
image = axes.imshow(shown, cmap="inferno_r", extent=(0, side, side, 0))
axes.set_facecolor("#f1f1ee")
axes.set(xlabel="x [µm]", ylabel="y [µm]")
axes.set_title("What a load of 1 N leaves behind", loc="left", fontsize=11)
figure_indented.colorbar(image, label="permanent indentation [nm]")

# %%
# Passes
# ------
# A rough counter-body rolls over the surface, an eighth of the map further with each pass, three
# rounds in all. Each place brings other summits together, and a summit that was lowered at one
# place leaves its load to others at the next: running-in takes many passes, and each of them
# finds less to flatten.

counter_heights, _ = rc.reference_map(POINTS, rng=7)
counter = rc.Surface(0.3 * counter_heights, pixel)
places, rounds = 8, 3
count = places * rounds
still = load_history(
    surface,
    repeat_stages([1.0, 0.0], count),
    material=steel,
    counter_surface=counter,
    boundary="periodic",
)
around = repeat_stages([1.0, 0.0], places, shift=(0.0, surface.size[1] / places)) * rounds
moving = load_history(surface, around, material=steel, counter_surface=counter, boundary="periodic")

figure_passes, axes = plt.subplots(figsize=(6.5, 4), layout="constrained")
number = np.arange(1, count + 1)
for name, history, mark in (
    ("at one place", still, "s--"),
    ("an eighth of the map further", moving, "o-"),
):
    volume = history.column("indentation_volume")[::2] * 1e18
    axes.plot(number, volume, mark, label=name)
for turn in range(1, rounds):
    axes.axvline(turn * places + 0.5, color="0.6", lw=0.8, ls=":")
axes.set(xlabel="pass", ylabel="newly indented volume [µm³]", ylim=(0, None))
axes.set_title(
    "Rolling along runs the surface in; standing still does not", loc="left", fontsize=11
)
axes.legend(frameon=False)

# %%
# At one place a single pass is enough: the ceiling model has no more to give.

first, second = still.column("indentation_volume")[[0, 2]]
print(f"same place: the second pass indents {100 * second / first:.4f} % of what the first did")
volume = moving.column("indentation_volume")[::2].reshape(rounds, places).sum(axis=1)
last_share = float(volume[-1] / volume[0])
print(f"moving: round {rounds} indents {100 * last_share:.1f} % of what the first did")
assert 0.05 < last_share < 0.55

# %%
# The model has no pile-up and no residual stress. In a real contact residual stress supports the
# shakedown.
