"""Contact-Mechanics Challenge without adhesion, from benchmarks/challenge.json."""

import json
import math

import matplotlib.pyplot as plt
import numpy as np

import challenge

answer = json.loads(challenge.STORED.read_text(encoding="utf-8"))
loads, fields = answer["loads"], answer["distributions"]
load = np.array([row["load"] for row in loads])
panels = plt.figure(figsize=(10, 6), layout="constrained").subplots(2, 3)

axes = panels[0, 0]
for name in ("contact", "corrected"):
    axes.loglog(load, [row[name] for row in loads], "o-", label=challenge.QUANTITIES[name])
axes.loglog(load, [math.erf(math.sqrt(2) * p) for p in load], "--", color="gray", label="Persson")
axes.set(xlabel="pressure / (E* gradient)", ylabel="contact fraction")

axes = panels[0, 1]
height = answer["Sq"] * 1e6
axes.loglog([row["gap"] / height for row in loads], load, "o-", label="pressure / E*")
axes.loglog(
    [row["gap"] / height for row in loads],
    [row["stiffness"] for row in loads],
    "s-",
    label="stiffness Sq / E*",
)
axes.set(xlabel="mean gap / Sq", ylabel="pressure, stiffness")

for axes, (name, xlabel, ylabel, scale) in zip(
    (panels[0, 2], panels[1, 0], panels[1, 1]),
    (
        ("pressure", "pressure / E*", "probability density", "linear"),
        ("gap", "gap [µm]", "probability density [1/µm]", "linear"),
        ("spots", "spot area [µm²]", "spots [1/µm⁴]", "log"),
    ),
    strict=True,
):
    edges, density = map(np.array, fields[name])
    axes.stairs(density, edges)
    axes.set(xlabel=xlabel, ylabel=ylabel, xscale=scale, yscale="log")

axes = panels[1, 2]
axes.loglog(*fields["stress"])
axes.set(xlabel="wave number [1/µm]", ylabel="stress spectrum / E*² [µm²]")
for axes in panels.flat:
    axes.grid(color="#dddddd")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False)
