"""How time and memory of each task grow with the grid, from benchmarks/growth.json."""

import json

import matplotlib.pyplot as plt

import record

grown = json.loads(record.GROWTH.read_text(encoding="utf-8"))
panels = plt.figure(figsize=(9, 4), layout="constrained").subplots(1, 2)
for axes, key, label in zip(
    panels, ("seconds", "bytes"), ("time [s]", "bytes per point"), strict=True
):
    for name, rows in grown.items():
        points = [int(number) for number in rows]
        axes.loglog(points, [row[key] for row in rows.values()], "o-", label=name)
    axes.set_xscale("log", base=2)
    axes.set(xlabel="points per side", ylabel=label)
    axes.grid(color="#dddddd")
panels[0].legend(frameon=False)
