"""The whole attack in one command: random problems, damaged files and killed runs.

    python tests/fuzz/robustness.py                       # 1000, 20 000 and 50: half an hour
    python tests/fuzz/robustness.py --write               # and docs/evidence/robustness.md from it
    python tests/fuzz/robustness.py --files 0 --kills 0   # the problems alone
    python tests/fuzz/robustness.py --problems 50 --files 200 --kills 5    # a small part of each
    python tests/fuzz/robustness.py --first 20000         # others
    python tests/fuzz/robustness.py --only problems 17 230    # single ones again, each in a line

Each part is in a separate module: `random_problems`, `damaged_files`, `killed_runs`. The exit
status is 1 if anything was wrong.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import damaged_files
import killed_runs
import random_problems

PAGE = Path(__file__).parents[2] / "docs" / "evidence" / "robustness.md"


@dataclass(frozen=True)
class Part:
    """One of the attacks.

    Parameters
    ----------
    option : str
        Name of its number on the command line.
    name : str
        Under which the page holds its table.
    count : int
        How many there are of it.
    module : module
        With ``run(seeds, every=False)``, ``page(outcomes, seconds)`` and the verdict ``WRONG``.
    """

    option: str
    name: str
    count: int
    module: ModuleType


PARTS = (
    Part("problems", "problems", 1000, random_problems),
    Part("files", "damaged files", 20_000, damaged_files),
    Part("kills", "killed runs", 50, killed_runs),
)


def marks(name: str) -> tuple[str, str]:
    """Return the text before and after the table of a part."""
    return f"<!-- {name} -->", f"<!-- end of {name} -->"


def renewed(text: str, name: str, table: str) -> str:
    """Return the page with another table of a part."""
    start, end = marks(name)
    head, rest = text.split(start)
    _, tail = rest.split(end)
    return f"{head}{start}\n{table}\n{end}{tail}"


def shorten(table: str) -> str:
    """Return the total and two notes of a part, without the rows of each kind."""
    head, rule, *rest = table.splitlines()
    kept = [line for line in rest if line.startswith(("| all |", "- "))]
    return "\n".join([head, rule, *kept[:1], "", *kept[1:3]])


def run_part(part: Part, seeds: Sequence[int], every: bool = False) -> tuple[str, int]:
    """Run a part and return its table, and how much was wrong."""
    began = time.perf_counter()
    outcomes = part.module.run(seeds, every=every)
    table = part.module.page(outcomes, time.perf_counter() - began)
    return table, sum(outcome.verdict == part.module.WRONG for outcome in outcomes)


def main() -> None:
    """Run the selected parts, print the tables, and fail if anything was wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for part in PARTS:
        words = f"number of {part.name}, 0 for none; {part.count} without it"
        parser.add_argument(f"--{part.option}", type=int, default=part.count, help=words)
    parser.add_argument("--first", type=int, default=0, help="seed of the first of each")
    names = ", ".join(part.option for part in PARTS)
    words = f"one of {names}, and seeds of it: these alone"
    parser.add_argument("--only", nargs="+", metavar="SEED", help=words)
    parser.add_argument("--write", action="store_true", help=f"renew {PAGE.name}")
    options = parser.parse_args()
    chosen = {
        part: range(options.first, options.first + getattr(options, part.option)) for part in PARTS
    }
    if options.only:
        kind, *seeds = options.only
        chosen = {part: list(map(int, seeds)) for part in PARTS if part.option == kind}
        if not chosen:
            parser.error(f"--only begins with one of {names}, got {kind!r}")
    wrong = 0
    for part, seeds in chosen.items():
        if not seeds:
            continue
        table, faults = run_part(part, seeds, every=bool(options.only))
        wrong += faults
        print(
            f"\n{part.name.capitalize()}: {faults} wrong of {len(seeds)}\n\n{table}\n", flush=True
        )
        if options.write:
            text = PAGE.read_text(encoding="utf-8")
            PAGE.write_text(renewed(text, part.name, shorten(table)), encoding="utf-8")
    if wrong:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
