"""Files that a run writes: their names, their places, and the writing of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from roughcontact.errors import InputError
from roughcontact.formats import export
from roughcontact.report import figures

Say = Callable[[str], None]
Task = tuple[Path, Callable[[Path], object]]

FIGURES = {"ceiling": figures.names(figures.CONTACT), "volume": figures.names(figures.VOLUME)}
"""Names of the figures of each model."""


class UnfinishedError(Exception):
    """Ctrl-C, with the files that were complete by then."""

    def __init__(self, written: Sequence[Path]) -> None:
        super().__init__()
        self.written = written


def write(tasks: Iterable[Task], say: Say) -> list[Path]:
    """Write files one after the other and return those that are complete.

    Raises
    ------
    InputError
        If a file cannot be written.
    UnfinishedError
        If Ctrl-C came.
    """
    written: list[Path] = []
    for path, save in tasks:
        say(f"writing {path}")
        try:
            save(path)
        except KeyboardInterrupt:
            raise UnfinishedError(written) from None
        except OSError as error:
            reason = error.strerror or " ".join(str(error).split())
            raise InputError(
                f"{path} cannot be written ({reason}); what was there before is unchanged"
            ) from None
        written.append(path)
    return written


def saver(draw: Callable[[], Any]) -> Callable[[Path], object]:
    """Return what draws a figure and saves it."""
    from roughcontact.plots import saving

    return lambda path: saving.save(draw(), path)


def figure_files(start: str | None, names: Sequence[str]) -> dict[str, Path]:
    """Return the files of figures: in a folder, or with the start of their names."""
    if start is None:
        return {}
    if Path(start).is_dir():
        return {name: Path(start) / f"{name}.png" for name in names}
    if start.endswith(("/", os.sep)):
        raise InputError(f"--figures: the folder '{start}' does not exist; create it first")
    suffix = Path(start).suffix.lower()
    suffix = suffix if suffix in (".png", ".svg", ".pdf") else ""
    stem = start[: len(start) - len(suffix)]
    return {name: Path(f"{stem}-{name}{suffix or '.png'}") for name in names}


def check_place(path: Path, option: str) -> None:
    """Raise `InputError` unless a file of that name can be written."""
    folder = path.parent
    if path.is_dir():
        raise InputError(f"{option} '{path}' is a folder; give the name of a file")
    if not folder.is_dir():
        raise InputError(f"{option}: the folder '{folder}' does not exist; create it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{option}: no permission to write into the folder '{folder}'")


def check_suffix(path: Path, option: str, suffixes: tuple[str, ...]) -> None:
    """Raise `InputError` unless a name ends in one of the suffixes."""
    if path.suffix.lower() not in suffixes:
        known = " or ".join([", ".join(suffixes[:-1]), suffixes[-1]] if suffixes[1:] else suffixes)
        volume = path.suffix.lower() in export.suffixes(export.Kind.VOLUME) and option == "--output"
        more = f"; {path.suffix} needs --model volume" if volume else ""
        raise InputError(f"{option} needs a name that ends in {known}, got '{path}'{more}")
