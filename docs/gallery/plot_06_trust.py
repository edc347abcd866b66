"""
06 Can it be trusted?
=====================

A certificate says that the stated problem is solved. Whether the map states the right problem is
another question: does the answer change with the grid, with the filter, with the ceiling?
``resolution_study`` solves the same contact again on coarser and finer grids and reports
the changes.
"""

# %%
# Two bodies: a polished ball, which the grid resolves, and a real map, whose roughness goes down to
# the pixel. Matplotlib ships the map with its license: heights of the land at the Jacksboro fault,
# 344 × 403 pixels of 93 × 75 m, 840 m from bottom to top. As contact depends on slopes alone, it is
# that of a rough metal face at a scale of 1 : 10⁸, and unlike a generated one it has no roll-off, no
# period and no shortest wave.

import math

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cbook import get_sample_data

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.uncertainty import resolution as resolution_study

POINTS = 256

steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
side = 1e-4
pixel = (side / POINTS, side / POINTS)
ball = rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, 1e-3), pixel)
data = get_sample_data("jacksboro_fault_dem.npz")
latitude = math.radians((data["ymin"] + data["ymax"]) / 2)
meters = 111.2e3 * data["dy"], 111.2e3 * math.cos(latitude) * data["dx"]
scale = 1e-8
measured = rc.Surface(scale * data["elevation"], (scale * meters[0], scale * meters[1])).leveled()
sides = " × ".join(f"{1e6 * length:.0f}" for length in measured.size)
print(f"Sq {measured.heights.std() * 1e6:.2f} µm on {sides} µm²")

studies = {
    "polished ball": rc.resolution_study(ball, material=steel, load=2.0, ceiling=None),
    "measured map, elastic": rc.resolution_study(measured, material=steel, load=10.0, ceiling=None),
    "measured map, ceiling": rc.resolution_study(measured, material=steel, load=10.0),
}

# %%
# The conclusions for each:

for name, found in studies.items():
    print(f"{name}:")
    for sentence in found.sentences:
        print(f"  {sentence}")
    print()

# %%
# The same as a figure, relative to the values on the measured grid. A quantity of the contact
# remains at 1. A quantity that depends on the pixel does not.

figure, panels = plt.subplots(1, 3, figsize=(10, 3.7), sharey=True, layout="constrained")
for axes, (name, found) in zip(panels, studies.items(), strict=True):
    as_given = next(grid for grid in found.grids if grid.value == 1)
    sizes = [grid.pixel[0] * 1e6 for grid in found.grids]
    for key, mark in (("contact_fraction", "o-"), ("max_pressure", "s--"), ("mean_pressure", "^:")):
        values = np.array([getattr(grid, key) for grid in found.grids]) / getattr(as_given, key)
        axes.plot(sizes, values, mark, ms=5, label=resolution_study.QUANTITIES[key])
    axes.axhspan(0.95, 1.05, color="0.92", zorder=0)
    axes.axvline(as_given.pixel[0] * 1e6, color="0.6", lw=0.8, ls=":")
    axes.set_xscale("log")
    axes.set_xticks(sizes, [f"{size:.2g}" for size in sizes])
    axes.minorticks_off()
    axes.set(xlabel="pixel [µm]", title=name)
panels[0].set_ylabel("value / value on the measured grid")
panels[0].legend(frameon=False, fontsize=9)

# %%
# All results of the ball are independent of the grid. On the measured map elastic area and pressure
# depend on the instrument. With the ceiling the contact area can be reported.

steady = {name: found.independent("corrected_fraction") for name, found in studies.items()}
for name, answer in steady.items():
    print(f"contact area of the {name}: {'independent of' if answer else 'depends on'} the grid")
assert list(steady.values()) == [True, False, True]
