"""Read every file of a folder and list which open, and the errors of the others.

``python tests/fuzz/example_files.py FOLDER [FOLDER …]`` prints a line for each file (read, read
with unit and size, or its error) and the numbers of both. With ``--before SRC``, the sources of
another state of the package, each line has the outcome there as well. Made for the example files of
SurfaceTopography, which are not part of this project.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from roughcontact.errors import FormatError, InputError, RoughcontactError
from roughcontact.formats.read import channels, read_surface

UNIT, SIZE = {"unit": "um"}, {"size": "1 mm x 1 mm"}
UNITS, METRES = {"unit": "um, um"}, {"unit": "m, m"}
LENGTH = {"size": "1 mm"}
HINTS = (UNIT, UNITS, METRES, SIZE, UNIT | SIZE, UNIT | LENGTH)
"""Answers to the questions of a file, in the order of the attempts."""

ALONE, REFUSED = "read", "refused"

Outcome = tuple[str, str]


def judge_file(path: Path) -> Outcome:
    """Return how a file is read, and what is in it or why it is not."""
    try:
        return ALONE, _shape(read_surface(path))
    except FormatError as error:
        return REFUSED, str(error)
    except InputError as error:
        first = str(error)
    for given in HINTS:
        for channel in (None, *range(len(_list_channels(path)))):
            try:
                surface = read_surface(path, channel=channel, **given)  # type: ignore[arg-type]
            except RoughcontactError:
                continue
            needed = [f"{name} {value}" for name, value in given.items()]
            needed += [] if channel is None else ["channel"]
            return f"read with {', '.join(needed)}", _shape(surface)
    return REFUSED, first


def _shape(surface: object) -> str:
    return repr(surface.shape)[1:-1].replace(",", " ×")  # type: ignore[attr-defined]


def _list_channels(path: Path) -> tuple[object, ...]:
    try:
        return channels(path)
    except RoughcontactError:
        return ()


def read_elsewhere(source: Path, paths: Sequence[Path]) -> list[Outcome]:
    """Return the outcomes of files with another state of the package."""
    words = [sys.executable, __file__, "--json", *map(str, paths)]
    environment = os.environ | {"PYTHONPATH": str(source)}
    done = subprocess.run(words, env=environment, check=True, capture_output=True, text=True)
    return [(outcome, text) for outcome, text in json.loads(done.stdout)]


def count_opened(outcomes: Iterable[Outcome]) -> str:
    """Return how many files open."""
    kinds = [kind for kind, _ in outcomes]
    alone, refused = kinds.count(ALONE), kinds.count(REFUSED)
    result = len(kinds) - alone - refused
    return f"of {len(kinds)}: {alone} open alone, {result} with a hint, {refused} do not open"


def table(paths: Sequence[Path], outcomes: Sequence[Outcome], before: Sequence[Outcome]) -> str:
    """Return the table of files in Markdown, with the outcomes before if there are any."""
    heads = ["file", *(["before"] if before else []), "outcome", "points, or why not"]
    lines = [heads, ["---"] * len(heads)]
    for number, (path, (outcome, text)) in enumerate(zip(paths, outcomes, strict=True)):
        earlier = [before[number][0]] if before else []
        lines.append([f"`{path.name}`", *earlier, outcome, text.replace("|", "/")])
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def main() -> None:
    """Print the outcomes of the files."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--before", type=Path, metavar="SRC", help="sources to compare with")
    parser.add_argument("--json", action="store_true", help="print the outcomes alone")
    asked = parser.parse_args()
    found = (p for folder in asked.folders for p in (folder, *folder.rglob("*")) if p.is_file())
    paths = sorted(found)
    outcomes = [judge_file(path) for path in paths]
    if asked.json:
        print(json.dumps(outcomes))
        return
    before = read_elsewhere(asked.before, paths) if asked.before else []
    print(table(paths, outcomes, before))
    print()
    if before:
        print("before,", count_opened(before))
    print("now," if before else "", count_opened(outcomes))


if __name__ == "__main__":
    main()
