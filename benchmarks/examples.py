"""Read every file of a folder and write what came of it as a table.

``python benchmarks/examples.py FOLDER [FOLDER …]`` prints a line for each file: read, read once
unit and size are given, or the sentence by which it is refused. Made for the example files of
SurfaceTopography, which are not part of this project.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from roughcontact.errors import FormatError, InputError, RoughcontactError
from roughcontact.formats.read import channels, read_surface

GIVEN = {"unit": "um", "size": "1 mm x 1 mm"}


def judged(path: Path) -> tuple[str, str]:
    """Return how a file is read, and what is in it or why it is not."""
    try:
        return "read", _told(read_surface(path))
    except FormatError as error:
        return "refused", str(error)
    except InputError as error:
        first = str(error)
    for names in (("unit",), ("size",), ("unit", "size")):
        given = {name: GIVEN[name] for name in names}
        for channel in (None, *range(len(_listed(path)))):
            try:
                surface = read_surface(path, channel=channel, **given)
            except RoughcontactError:
                continue
            needed = [*names, *([] if channel is None else ["channel"])]
            return f"read with {', '.join(needed)}", _told(surface)
    return "refused", first


def _told(surface: object) -> str:
    return repr(surface.shape)[1:-1].replace(",", " ×")  # type: ignore[attr-defined]


def _listed(path: Path) -> tuple[object, ...]:
    try:
        return channels(path)
    except RoughcontactError:
        return ()


def table(paths: Iterable[Path]) -> str:
    """Return the table of files in Markdown."""
    lines = ["| file | outcome | points, or why not |", "|---|---|---|"]
    lines += [
        f"| `{path.name}` | {outcome} | {text.replace('|', '/')} |"
        for path in sorted(paths)
        for outcome, text in [judged(path)]
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(p for folder in sys.argv[1:] for p in Path(folder).rglob("*") if p.is_file()))
