r"""
09 Which material, which ceiling?
=================================

The ceiling is the one number of the model that is no elastic constant. By default it is three
yield strengths of the softer body, or its hardness where no yield strength is known. This page
shows what that means for real materials, and when the ceiling matters at all.
"""

# %%
# The catalog lists materials with the source of each value. Here the same ground surface carries the
# same load:

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.material import catalog, hardness
from roughcontact.theory import persson

POINTS = 256

heights, pixel = rc.reference_map(POINTS)
surface = rc.Surface(heights, pixel)
load = 1.0
names = ("100Cr6", "42CrMo4", "X5CrNi18-10", "6061-T6", "Ti-6Al-4V", "Al2O3", "PEEK")
results = {}
print("material      ceiling      contact   saturated   regime")
for name in names:
    material = catalog.material(name)
    result = rc.solve(surface, material=material, load=load)
    results[name] = result
    print(
        f"{name:12} {material.ceiling / 1e9:6.2f} GPa {100 * result.contact_fraction:8.2f} % "
        f"{100 * result.saturated_fraction:9.2f} %   {result.regime}"
    )

# %%
# A hardness as the ceiling
# -------------------------
# Three yield strengths are right for a metal that does not harden (Tabor 1951). A metal
# that hardens carries more. Its hardness is then the better ceiling, and it is known more often than
# the yield strength.

figure, axes = plt.subplots(figsize=(7.5, 4), layout="constrained")
ratios = {}
for entry in catalog.entries():
    if entry.yield_strength is None or entry.hardness is None:
        continue
    ratios[entry.key] = hardness.ceiling(entry.hardness.text) / entry.yield_strength.value
order = sorted(ratios, key=lambda key: ratios[key])
axes.barh(order, [ratios[key] for key in order], color="#0072b2")
axes.axvline(3, color="#7f0d1b", lw=1.5)
axes.annotate("3 σ$_Y$", (3, -0.4), xytext=(4, 0), textcoords="offset points", color="#7f0d1b")
axes.set(xlabel="hardness (mean pressure) / yield strength", xlim=(0, None))
axes.set_title(
    "Hardened steels lie near three; soft alloys harden beyond it", loc="left", fontsize=11
)
axes.tick_params(axis="y", labelsize=8)

# %%
# When does it matter?
# --------------------
# The answer depends on two numbers, the plasticity index :math:`E^* h'/\sigma_Y` and the nominal
# pressure over the yield strength, :math:`\bar p/\sigma_Y`. The figure shows one contact for each
# point of a grid over both. It holds for every material with this spectrum.

modulus = rc.contact_modulus(rc.Material(young=210e9, poisson=0.3), rc.RIGID)
area = surface.size[0] * surface.size[1]
indices = np.geomspace(0.5, 200, 10)
nominal = np.geomspace(3e-3, 2.8, 7)


def saturated_share(index: float, mean: float) -> float:
    """Return the share of the contact that is at the ceiling."""
    strength = modulus * surface.Sdq / index
    body = rc.Material(young=210e9, poisson=0.3, yield_strength=strength)
    found = rc.solve(surface, material=body, load=mean * strength * area, boundary="periodic")
    return found.saturated_fraction / found.contact_fraction


table = np.array([[saturated_share(index, mean) for index in indices] for mean in nominal])

figure_map, axes = plt.subplots(figsize=(7.5, 5), layout="constrained")
levels = [0.01, 0.1, 0.5, 0.9]
filled = axes.contourf(
    indices,
    nominal,
    table,
    [-0.01, *levels, 1.01],
    colors=["#eef5fb", "#cfe3f3", "#f6e3c5", "#f2b880", "#d9795d"],
)
lines = axes.contour(indices, nominal, table, levels, colors="0.3", linewidths=0.8)
axes.clabel(lines, fmt=lambda level: f"{100 * level:.0f} %", fontsize=9)
axes.axhline(3, color="k", lw=1.5)
axes.annotate("capacity: 3 σ$_Y$ everywhere", (0.55, 3.2), fontsize=9)
axes.set(xscale="log", yscale="log", xlim=(0.5, 200), ylim=(3e-3, 5))
axes.set(xlabel=r"plasticity index $E^* h'/\sigma_Y$", ylabel=r"mean pressure $\bar p/\sigma_Y$")
axes.set_title("Share of the contact that is saturated", loc="left", fontsize=11)
for name in ("100Cr6", "42CrMo4", "6061-T6", "X5CrNi18-10", "PEEK"):
    strength = catalog.material(name).yield_strength
    place = (results[name].contact_modulus * surface.Sdq / strength, load / area / strength)
    axes.plot(*place, "D", color="k", ms=5)
    axes.annotate(name, place, xytext=(-4, 6), textcoords="offset points", ha="right", fontsize=9)

# %%
# Below an index of about two even the summits stay elastic and no ceiling matters; far above
# thirty nearly all that touches is saturated, and the contact area is the load over the ceiling.
# Between the two elastic constants, slope and ceiling all count, and one needs the solver.
#
# Persson's theory with a ceiling is a quick guess at the area, but not at this share: it counts
# as saturated what has once been loaded to the ceiling on any scale. At an index of ten:

mild, middle, steep = (saturated_share(index, 0.1) for index in (1.0, 10.0, 100.0))
contact, saturated = persson.persson_fractions(0.1, 1.0, 10.0, 3.0)
print(f"index 1:   {100 * mild:.1f} % of the contact saturated")
print(f"index 10:  {100 * middle:.1f} %, Persson's theory {100 * saturated / contact:.1f} %")
print(f"index 100: {100 * steep:.1f} %")
assert steep > 0.85
