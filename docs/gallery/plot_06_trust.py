"""
06 Can it be trusted?
=====================

A certificate says that the stated problem is solved. Whether the map states the right problem is
another question: does the answer change with the grid, with the filter, with the ceiling?
``resolution_study`` solves the same contact again on coarser and finer grids and reports
the changes.
"""

# %%
# Two bodies with the same kind of map: a polished ball, which the grid resolves, and a ground
# surface, whose roughness goes down to the pixel.

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.uncertainty import resolution as resolution_study

POINTS = 256

steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
side = 1e-4
pixel = (side / POINTS, side / POINTS)
ball = rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, 1e-3), pixel)
noise = rc.self_affine(
    (POINTS, POINTS),
    pixel,
    rms_height=0.2e-6,
    rolloff_wavelength=side / 4,
    cutoff_wavelength=2 * pixel[0],
    rng=np.random.default_rng(2),
)
ground = rc.Surface(noise, pixel)

studies = {
    "polished ball": rc.resolution_study(ball, material=steel, load=2.0, ceiling=None),
    "ground surface, elastic": rc.resolution_study(ground, material=steel, load=1.0, ceiling=None),
    "ground surface, ceiling": rc.resolution_study(ground, material=steel, load=1.0),
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
    measured = next(grid for grid in found.grids if grid.value == 1)
    sizes = [grid.pixel[0] * 1e6 for grid in found.grids]
    for key, mark in (("contact_fraction", "o-"), ("max_pressure", "s--"), ("mean_pressure", "^:")):
        values = np.array([getattr(grid, key) for grid in found.grids]) / getattr(measured, key)
        axes.plot(sizes, values, mark, ms=5, label=resolution_study.QUANTITIES[key])
    axes.axhspan(0.95, 1.05, color="0.92", zorder=0)
    axes.axvline(pixel[0] * 1e6, color="0.6", lw=0.8, ls=":")
    axes.set_xscale("log")
    axes.set_xticks(sizes, [f"{size:.2g}" for size in sizes])
    axes.minorticks_off()
    axes.set(xlabel="pixel [µm]", title=name)
panels[0].set_ylabel("value / value on the measured grid")
panels[0].legend(frameon=False, fontsize=9)

# %%
# All results of the ball are independent of the grid. On the ground surface elastic area and pressure
# depend on the instrument. With the ceiling the contact area can be reported.

steady = {name: found.independent("corrected_fraction") for name, found in studies.items()}
for name, answer in steady.items():
    print(f"contact area of the {name}: {'independent of' if answer else 'depends on'} the grid")
assert list(steady.values()) == [True, False, True]
