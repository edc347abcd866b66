"""Keep rows of peers.py, and show them: the table and the plot of docs/evidence/performance.md.

python benchmarks/report.py rows.json [more.json ...]

puts the rows into results.json, in place of older ones of the same case and program, and writes
the table anew. The plot is drawn from results.json when the documentation is built.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from peers import CASES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESULTS = Path(__file__).with_name("results.json")
PAGE = Path(__file__).parents[1] / "docs" / "evidence" / "performance.md"
START, END = "<!-- table -->", "<!-- end -->"


def table(rows: list[dict]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| case | program | time | in T_pair | × roughcontact | certificate | memory per point |",
        "|---|---|---|---|---|---|---|",
    ]
    own = {
        row["case"]: row["seconds"]
        for row in rows
        if row["program"] == "roughcontact" and "seconds" in row
    }
    for row in rows:
        if "failed" in row:
            lines.append(f"| {row['case']} | {row['program']} | {row['failed']} | | | | |")
            continue
        points = CASES[row["case"]][0]
        pair = row["pair"]
        certificate = f"{row.get('own', math.nan):.1e} (own)"
        if "certificate" in row:
            certificate = f"{row['certificate']:.1e}"
        lines.append(
            f"| {row['case']} | {row['program']} | {row['seconds']:.3g} s "
            f"| {'–' if pair != pair else format(row['seconds'] / pair, '.1f')} "
            f"| {row['seconds'] / own.get(row['case'], math.nan):.3g} "
            f"| {certificate} | {1e6 * row['above'] / points**2:.0f} B |"
        )
    return "\n".join(lines)


def plot(rows: list[dict], figure: Figure) -> None:
    """Draw time over grid size, one line a program, with and without a ceiling."""
    panels = figure.subplots(1, 2, sharey=True)
    for axes, kind in zip(panels, ("elastic", "ceiling"), strict=True):
        for program in dict.fromkeys(row["program"] for row in rows):
            chosen = sorted(
                (CASES[row["case"]][0], row["seconds"])
                for row in rows
                if row["program"] == program
                and row["case"].startswith("rough")
                and row["case"].endswith(kind)
                and "seconds" in row
            )
            if chosen:
                axes.loglog(*zip(*chosen, strict=True), "o-", label=program)
        pairs = sorted(
            {
                CASES[row["case"]][0]: row["pair"]
                for row in rows
                if row["case"].endswith(kind) and row["pair"] == row["pair"]
            }.items()
        )
        if pairs:
            axes.loglog(*zip(*pairs, strict=True), "k:", label="one plain FFT pair, T_pair")
        axes.set_xscale("log", base=2)
        axes.set_title("ceiling 3 GPa" if kind == "ceiling" else "elastic")
        axes.set_xlabel("points per side")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    panels[0].set_ylabel("time of one solve [s]")


def stored() -> list[dict]:
    """Return the rows that are kept, in the order of the cases."""
    return [
        row | {"pair": math.nan if row.get("pair") is None else row["pair"]}
        for row in json.loads(RESULTS.read_text(encoding="utf-8"))
    ]


def main() -> None:
    """Keep new rows and write the table."""
    rows = stored()
    for name in sys.argv[1:]:
        rows += json.loads(Path(name).read_text(encoding="utf-8"))
    # A case that was run again keeps its last row.
    unique = {(row["case"], row["program"]): row for row in rows}
    order = list(CASES)
    rows = sorted(unique.values(), key=lambda row: order.index(row["case"]))
    kept = [{k: None if v != v else v for k, v in row.items()} for row in rows]
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.index(START) + len(START), text.index(END)
    PAGE.write_text(f"{text[:before]}\n{table(rows)}\n{text[after:]}", encoding="utf-8")


if __name__ == "__main__":
    main()
