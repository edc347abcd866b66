"""Formulas, cases, Persson's theory and that of Greenwood and Williamson on the same axes."""

import matplotlib.pyplot as plt
import numpy as np

import atlas
import atlas_fit
from roughcontact.analyses.estimate import stored_formulas
from roughcontact.theory import greenwood_williamson as gw

cases = atlas_fit.read(atlas.CEILING)
groups = cases.groups
plain = (np.abs(groups.skewness) < 0.05) & (groups.texture > 0.85)
elastic = plain & (groups.ratio < 0.2)

pressure = np.geomspace(2e-3, 0.5, 120)
breadth = 3.0
line = stored_formulas.DimensionlessGroups(
    pressure, *(np.full_like(pressure, value) for value in (0.0, breadth, 0.95, 0.0, 3.0, 0.0))
)
atlas_of = stored_formulas.load_atlas()
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12, 4.2), layout="constrained")

contact = cases.found["contact"]
left.semilogx(
    groups.pressure[elastic],
    contact[elastic] / groups.pressure[elastic],
    "o",
    color="0.6",
    ms=3,
    label="computed",
)
formula = atlas_of.formula("contact", True).value(line)
left.semilogx(pressure, formula / pressure, color="#0072b2", label="formula")
left.semilogx(
    pressure,
    stored_formulas.theory_contact(line) / pressure,
    "--",
    color="#009e73",
    label="Persson",
)
middle.semilogx(
    groups.pressure[elastic], cases.found["gap"][elastic], "o", color="0.6", ms=3, label="computed"
)
middle.semilogx(pressure, atlas_of.formula("gap", True).value(line), color="#0072b2")
separation = np.linspace(-1, 4, 200)
for bandwidth, style in ((3, "-"), (10, "--"), (40, ":")):
    # m₀ = 1 and m₂ = ½, so that h′ = 1.
    tops = gw.summits(1.0, 0.5, bandwidth / 4)
    load = tops.pressure(separation)
    there = (load > 2e-3) & (load < 0.5)
    share = tops.contact_fraction(separation)
    name = f"Greenwood–Williamson, α = {bandwidth}"
    left.semilogx(load[there], (share / load)[there], style, color="#c1272d", label=name)
    middle.semilogx(load[there], tops.gap(separation)[there], style, color="#c1272d")

for index, shade in ((3, 0.4), (12, 0.65), (60, 0.95)):
    ratio = index / 3
    near = plain & (np.abs(np.log(groups.ratio / ratio + 1e-9)) < 0.15)
    right.loglog(
        groups.pressure[near] * groups.ratio[near],
        contact[near],
        "o",
        color=plt.cm.Blues(shade),
        ms=3,
    )
    share = np.geomspace(3e-3, 0.85, 80)
    at = stored_formulas.DimensionlessGroups(
        share / ratio,
        *(np.full_like(share, value) for value in (ratio, breadth, 0.95, 0.0, 3.0, 0.0)),
    )
    value = atlas_of.formula("contact", True).value(at)
    right.loglog(share, value, color=plt.cm.Blues(shade), label=f"E* h′/σ_Y = {index}")
    right.loglog(share, stored_formulas.theory_contact(at), "--", color="#009e73", lw=1)
right.loglog([3e-3, 1], [3e-3, 1], color="0.6", lw=0.8)
left.set(xlabel="p̄/(E* h′)", title="elastic: (A/A₀)/(p̄/(E* h′))", ylim=(0.8, 3.2))
middle.set(xlabel="p̄/(E* h′)", title="elastic: mean gap/Sq", ylim=(0, 3))
right.set(xlabel="p̄/p_lim", title="under a ceiling: A/A₀", ylim=(3e-3, 1))
left.legend(frameon=False, fontsize=7)
right.legend(frameon=False, fontsize=7)
