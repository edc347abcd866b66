"""The tables of docs/evidence/estimates.md, from the stored cases and formulas of the atlas."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import atlas_fit
from roughcontact.analyses.estimate import stored_formulas

PAGE = Path(__file__).parents[1] / "docs" / "evidence" / "estimates.md"
NAMES = {
    "contact": "contact area",
    "saturated": "saturated area",
    "gap": "mean gap",
    "volume": "plastic volume",
}


def validation_table() -> str:
    """Return the errors of the formulas on maps that took no part in the fit."""
    errors = json.loads(stored_formulas.STORED.read_text(encoding="utf-8"))["held"]
    lines = [
        "| quantity | cases held out | median | nine in ten | covered | half width |",
        "|---|---|---|---|---|---|",
    ]
    for key, judged in errors.items():
        name, _, without = key.partition("_without")
        digits = 2 if name == "saturated" else 1
        numbers = (judged[part] for part in ("median", "nine_in_ten", "covered", "half_width"))
        median, most, covered, half = (100 * number for number in numbers)
        lines.append(
            f"| {NAMES[name]}{', without Sal' if without else ''} | {judged['cases']:.0f} "
            f"| {median:.{digits}f} % | {most:.{digits}f} % | {covered:.0f} % "
            f"| {half:.{digits}f} % |"
        )
    return "\n".join(lines)


def measured_table(place: Path) -> str:
    """Return the errors of the formulas on measured maps, the median over the cases of each."""
    cases = atlas_fit.read(place)
    lines = [
        "| map | side/Sal | Sdq Sal/Sq | Str | Ssk | Sku | contact area | mean gap / Sq "
        "| cases in the interval |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    atlas = stored_formulas.load_atlas()
    for name in np.unique(cases.maps):
        one = cases.select(cases.maps == name)
        area, gap = (
            atlas_fit.evaluate_formula(atlas.formula(quantity, True), one, atlas.measured)
            for quantity in ("contact", "gap")
        )
        about = (one.table[key][0] for key in ("rolloff", "breadth", "Str", "Ssk", "Sku"))
        numbers = " | ".join(f"{value:.2g}" for value in about)
        lines.append(
            f"| {name.removeprefix('held-')} | {numbers} | {100 * area['median']:.1f} % "
            f"| {100 * gap['median']:.1f} % | {100 * area['covered']:.0f} %, "
            f"{100 * gap['covered']:.0f} % |"
        )
    return "\n".join(lines)


def tables(place: Path) -> dict[str, str]:
    """Return the tables of the page by the names of their marks."""
    return {"held": validation_table(), "measured": measured_table(place)}


def write(place: Path) -> None:
    """Put the tables into the page."""
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables(place).items():
        start, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
        before, _, rest = text.partition(start)
        _, _, after = rest.partition(end)
        text = f"{before}{start}\n\n{table}\n\n{end}{after}"
    PAGE.write_text(text, encoding="utf-8")
