r"""
17 One surface, three instruments
=================================

An instrument smooths a surface and adds noise, so each map of it has another contact. Here a surface
that is known is measured by three virtual instruments. ``result.uncertainty`` corrects the numbers of
each map and gives an interval; all three should hold the number of the surface.
"""

# %%
# Measure it three times
# ----------------------

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import random_surfaces

POINTS = 512

rng = np.random.default_rng(12)
pixel = 128e-6 / POINTS
shortest = 16 * pixel
heights = random_surfaces.self_affine(
    POINTS, pixel, rms_height=0.3e-6, rolloff_wavelength=40e-6, cutoff_wavelength=shortest, rng=rng
)
surface = rc.Surface(heights, (pixel, pixel))
polymer = rc.Material("3 GPa", 0.4)
terms = {"material": polymer, "load": "200 mN", "boundary": "periodic"}
truth = rc.solve(surface, **terms)

instruments = {
    "microscope 20x": rc.measure.Instrument("optical", resolution=20 * pixel, noise="2 nm"),
    "microscope 50x": rc.measure.Instrument("optical", resolution=10 * pixel, noise="1 nm"),
    "stylus": rc.measure.Instrument("tip", tip_radius="2 um", noise="1 nm"),
}
answers = {}
for name, instrument in instruments.items():
    image = instrument.measure(surface, points=(POINTS // 4, POINTS // 4), periodic=True, rng=rng)
    result = rc.solve(image, **terms)
    answers[name] = result.uncertainty(instrument, shortest_wave=shortest)

# %%
# Compare with the surface
# ------------------------

figure, panels = plt.subplots(1, 2, figsize=(9, 3), sharey=True, layout="constrained")
held = []
for axes, key, scale, label in zip(
    panels,
    ("contact_fraction", "mean_gap"),
    (100, 1e9),
    ("real contact [%]", "mean gap [nm]"),
    strict=True,
):
    exact = getattr(truth, key)
    for place, answer in enumerate(answers.values()):
        found = answer.interval(key)
        axes.plot([scale * found.low, scale * found.high], [place, place], lw=3, color="#0072b2")
        axes.plot(scale * found.value, place, "o", color="#0072b2", label="corrected")
        axes.plot(scale * found.measured, place, "x", color="#d55e00", label="as measured")
        held.append(found.low <= exact <= found.high)
    axes.axvline(scale * exact, color="0.4", ls="--", lw=1)
    axes.annotate("surface", (scale * exact, 2.3), ha="center", va="bottom", fontsize=9)
    axes.set(xlabel=label, ylim=(-0.5, 2.6), xlim=(0, None))
panels[0].set_yticks(range(len(answers)), list(answers))
handles, names = panels[0].get_legend_handles_labels()
panels[0].legend(handles[:2], names[:2], frameon=False, loc="upper left")
held_share = float(np.mean(held))
print(f"{sum(held)} of {len(held)} intervals hold the number of the surface")
assert held_share >= 0.8

# %%
# As measured, the maps differ from the surface and from each other. Corrected, the intervals of all
# three overlap, and the finest instrument has the shortest.
