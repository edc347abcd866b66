"""Output files of a run: names, places, figures, and writers."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roughcontact.errors import ArgumentRef, InputError
from roughcontact.request.options import PICTURES, Option

Say = Callable[[str], None]
Writing = tuple[Path, Callable[[Path], object]]
Identity = str | tuple[int, int]

# Maximum number of characters of a name in a message.
_SHOWN = 40


@dataclass(frozen=True)
class SavedSteps:
    """Saved steps in the folder of an interrupted calculation."""

    number: int  # Number of complete steps
    count: int  # Number of all steps
    part: str  # Noun for a step
    folder: Path


class UnfinishedError(Exception):
    """Interrupt by Ctrl-C, with the complete files and the saved steps."""

    def __init__(self, written: Sequence[Path], saved: SavedSteps | None = None) -> None:
        super().__init__()
        self.written, self.saved = written, saved


def write_files(tasks: Iterable[Writing], say: Say) -> list[Path]:
    """Write files one after the other and return the complete files."""
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
                f"{path} cannot be written ({reason}); its previous content is unchanged"
            ) from None
        written.append(path)
    return written


def figure_saver(draw: Callable[[], Any]) -> Callable[[Path], object]:
    """Return a function that draws and saves a figure."""

    def save(path: Path) -> None:
        from roughcontact.drawing import export

        export.save(draw(), path)

    return save


def figure_files(start: str, names: Iterable[str]) -> dict[str, Path]:
    """Return the files of figures, by name: in a folder, or with a prefix."""
    if Path(start).is_dir():
        return {name: Path(start) / f"{name}.png" for name in names}
    if start.endswith(("/", os.sep)):
        raise InputError(
            f"{ArgumentRef('figures')}: the folder '{start}' does not exist; create it first"
        )
    suffix = Path(start).suffix.lower()
    suffix = suffix if suffix in PICTURES else ""
    stem = start[: len(start) - len(suffix)]
    return {name: Path(f"{stem}-{name}{suffix or '.png'}") for name in names}


def check_place(path: Path, argument: str, inputs: Iterable[Path] = ()) -> None:
    """Raise `InputError` unless a file can be written to this path and replaces no input."""
    check_name(path, argument)
    folder = path.parent
    if path.is_dir():
        raise InputError(f"'{path}' is a folder; give the name of a file", argument=argument)
    if not folder.is_dir():
        raise InputError(
            f"{ArgumentRef(argument)}: the folder '{folder}' does not exist; create it first"
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(
            f"{ArgumentRef(argument)}: no permission to write into the folder '{folder}'"
        )
    refuse_inputs(path, argument, {file_identity(other) for other in inputs})


def check_name(path: Path, argument: str) -> None:
    """Raise `InputError` if the file system does not support a name of this length."""
    whole = path.absolute()
    # For a path in a missing folder, the system would only report the folder as missing.
    there = next(folder for folder in whole.parents if os.path.isdir(folder))  # noqa: PTH112
    for place in (*(there / part for part in whole.relative_to(there).parts), whole):
        try:
            place.lstat()
        except OSError as error:
            if error.errno == errno.ENAMETOOLONG:
                name = str(place) if place is whole else place.name
                raise InputError(
                    f"{ArgumentRef(argument)}: the name '{name[:_SHOWN]}…' has {len(name)} "
                    "characters, too many for the file system; give a shorter one"
                ) from None


def refuse_inputs(path: Path, argument: str, inputs: Set[Identity]) -> None:
    """Raise `InputError` if an output file is one of the inputs, under any name."""
    if file_identity(path) in inputs:
        raise InputError(f"'{path}' is an input file; give another name", argument=argument)


def file_identity(path: Path) -> Identity:
    """Return device and inode of a file, or the resolved path if there is no file yet."""
    try:
        result = path.stat()
    except OSError:
        return os.path.realpath(path)
    return result.st_dev, result.st_ino


def check_suffix(
    path: Path, option: Option[Any], known: tuple[str, ...] = (), more: tuple[Any, ...] = ()
) -> None:
    """Raise `InputError` unless a name ends in one of the suffixes of an option."""
    known = known or option.suffixes
    if path.suffix.lower() not in known:
        listed = " or ".join([", ".join(known[:-1]), known[-1]] if known[1:] else known)
        raise InputError(
            f"needs a name that ends in {listed}, got '{path}'",
            *more,
            argument=option.argument,
            value=str(path),
        )
