"""Errors of the formulas of nominally flat contact, for each case of calibration/atlas."""

import matplotlib.pyplot as plt
import numpy as np

import atlas
import atlas_fit
from roughcontact.analyses.estimate import stored_formulas

ceiling, volume = (atlas_fit.read(place) for place in (atlas.CEILING, atlas.VOLUME))
sets = [(ceiling, "ceiling"), (volume, "volume")]
if atlas.MEASURED.exists():
    sets.append((atlas_fit.read(atlas.MEASURED), "measured"))

figure, panels = plt.subplots(2, 2, figsize=(10, 7.6), layout="constrained")
shown = (
    ("contact", "contact area: error [%]", "contact area / nominal area", 25),
    ("gap", "mean gap: error [% of Sq]", "contact area / nominal area", 15),
    ("saturated", "saturated area: error [% of nominal area]", "contact area / nominal area", 4),
    ("volume", "plastic volume: error [%]", "plastic volume h′/(Sq A₀)", 60),
)
for axes, (quantity, title, label, limit) in zip(panels.flat, shown, strict=True):
    formula = stored_formulas.load_atlas().formula(quantity, True)
    for cases, kind in sets:
        if quantity not in cases.found:
            continue
        found, value = cases.found[quantity], formula.value(cases.groups)
        scale = found if quantity in ("contact", "volume") else 1
        error = 100 * (value - found) / scale
        at = cases.found["volume" if quantity == "volume" else "contact"]
        groups = (
            [(np.ones(found.size, bool), "#c1272d", "measured maps", 9)]
            if kind == "measured"
            else [
                (~cases.is_held_out, "0.7", "maps of the fit", 5),
                (cases.is_held_out, "#0072b2", "held out", 7),
            ]
        )
        for chosen, colour, name, size in groups:
            axes.scatter(
                at[chosen],
                np.clip(error[chosen], -limit, limit),
                s=size,
                color=colour,
                label=name,
                linewidths=0,
            )
    axes.axhline(0, color="0.3", lw=0.8)
    axes.set(xscale="log", xlabel=label, ylabel=title, ylim=(-1.05 * limit, 1.05 * limit))
panels[0, 0].legend(frameon=False, fontsize=8)
