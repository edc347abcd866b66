"""Error of the ceiling model over load and ceiling, from calibration/ceiling_error.json."""

import matplotlib.pyplot as plt
import numpy as np

import ceiling_error

found = ceiling_error.read_stored()
factors = found["factors"]
three = factors.index(3.0)
balls = [row for row in found["spheres"] if row["law"] == "perfect"]
loads = [row["load_ratio"] for row in balls]

figure, panels = plt.subplots(1, 3, figsize=(11, 4.2), layout="constrained")
for axes, name, title in (
    (panels[0], "contact_area", "contact area of a sphere"),
    (panels[1], "approach", "approach of a sphere"),
):
    for factor, shade in ((1.8, 0.25), (2.2, 0.45), (2.6, 0.65), (3.0, 1.0)):
        error = [100 * row["errors"][name][factors.index(factor)] for row in balls]
        axes.semilogx(
            loads, error, "-", color=plt.cm.Reds(shade), label=f"ceiling {factor:g} $\\sigma_Y$"
        )
    advised = [100 * row["calibrated"][name] for row in balls]
    axes.semilogx(loads, advised, "o--", color="#009e73", ms=4, label="calibrated")
    axes.axhline(0, color="0.6", lw=0.8)
    axes.set(xlabel="load / load of first yield", ylabel="error [%]", ylim=(-30, 40), title=title)
panels[0].legend(frameon=False, fontsize=8, loc="upper left")

axes = panels[2]
for law, marker in (("perfect", "o"), ("linear", "s"), ("Swift", "^")):
    rows = [row for row in found["maps"] if row["law"] == law and row["nominal"] > 0.05]
    at = [row["calibrated"]["load_ratio"] for row in rows]
    usual = np.array([row["errors"]["contact_area"][0] for row in rows])
    advised = np.array([row["calibrated"]["contact_area"] for row in rows])
    axes.semilogx(at, 100 * usual, marker, color="#7f0d1b", ms=4, alpha=0.6, mew=0)
    axes.semilogx(at, 100 * advised, marker, color="#009e73", ms=4, mew=0, label=law)
axes.axhline(0, color="0.6", lw=0.8)
axes.set(
    xlabel="load / first yield, of the sphere alike",
    title="contact area of rough maps",
    ylabel="error [%]",
    ylim=(-30, 70),
)
axes.legend(frameon=False, fontsize=8, loc="upper left")
axes.text(
    0.97,
    0.95,
    "red: 3 $\\sigma_Y$\ngreen: recommended",
    transform=axes.transAxes,
    ha="right",
    va="top",
    fontsize=8,
)
