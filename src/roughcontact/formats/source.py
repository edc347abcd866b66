"""What all readers share: what is asked of a file, its channels, one kind of complaint."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import pipes
from roughcontact.errors import FormatError, InputError
from roughcontact.formats import archives
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, quantity

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Channel:
    """One channel of a file.

    Parameters
    ----------
    name : str
        Name in the file; empty if the file names none.
    unit : str
        Unit of the values as the file gives it; empty if it gives none.
    is_height : bool
        Whether the channel holds heights, by its name and its unit.
    shape : tuple of int
        Grid points ``(ny, nx)``.
    """

    name: str
    unit: str
    is_height: bool
    shape: tuple[int, ...]


@dataclass(frozen=True)
class Asked:
    """What is said of a file beside its name; see `roughcontact.read_surface`.

    ``override_size`` says that ``size`` counts where the file gives one as well. ``announced`` is
    called with the points ``(ny, nx)`` that the header of a file names, before its heights are
    read, and may refuse them; text has no header, and is judged once it is read.
    """

    channel: str | int | None = None
    unit: str | None = None
    size: Quantities | str | None = None
    override_size: bool = False
    announced: Callable[[tuple[int, int]], None] | None = None

    def __post_init__(self) -> None:
        """Keep a text as it was given, and anything else in metres."""
        if not isinstance(self.size, str):
            object.__setattr__(self, "size", quantity(self.size, "length", "size"))

    def expect(self, shape: tuple[int, ...]) -> None:
        """Tell how large the map will be."""
        if self.announced is not None:
            ny, nx = shape
            self.announced((ny, nx))


@dataclass(frozen=True)
class InputFormat:
    """A format that maps are read from: a line of the table in `roughcontact.formats.read`.

    Parameters
    ----------
    name : str
        As ``format`` of `roughcontact.read_surface` takes it.
    suffixes : tuple of str
        How its files end.
    read : callable
        ``read(path, name, asked)`` returns the map.
    channels : callable
        ``channels(path, name)`` returns the channels in the order of their indices.
    numbered : bool
        Whether three digits as a suffix stand for it as well.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Path, str, Asked], Surface]
    channels: Callable[[Path, str], tuple[Channel, ...]]
    numbered: bool = False


@contextmanager
def existing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a file that is there and not empty, as one that may be opened again and searched.

    What gzip has packed is unpacked.
    """
    path = Path(path)
    with ExitStack() as stack:
        try:
            if path.is_dir():
                raise FormatError(f"{path} is a directory; give the file with the height map")
            if not path.exists():
                raise FormatError(f"{path} does not exist; check the name of the file")
            file = stack.enter_context(pipes.regular(path))
            with file.open("rb"):
                empty = not file.stat().st_size
            file = stack.enter_context(archives.unpacked(file))
        except FormatError:
            raise
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise FormatError(f"{path} cannot be opened ({reason}); check the file") from None
        if empty:
            raise FormatError(f"{path} is empty; export or copy the measurement again")
        yield file


def surface_of(
    path: Path,
    heights: NDArray[Any],
    pixel: tuple[float, float],
    provenance: Provenance,
    metre: float = 1.0,
    stated: tuple[float, float] | None = None,
    acquired: str = "",
) -> Surface:
    """Return a map, or complain of the file that it is from.

    ``metre`` is the file's unit [m], ``stated`` the pixel [m] that it gives, if it gives one, and
    ``acquired`` when the map was measured, if it tells.
    """
    found: dict[str, object] = {"unit": metre}
    if stated is not None and stated != pixel:
        sides = [n * edge for n, edge in zip(heights.shape, stated, strict=True)]
        found["stated_size"] = sides[heights.shape[0] == 1 :]
    if acquired:
        found["acquired"] = acquired
    origin = Operation("read_surface", {"path": path.name}, found)
    try:
        return Surface(heights, pixel, replace(provenance, origin=origin))
    except InputError as error:
        raise FormatError(f"{path.name} holds no height map that can be used: {error}") from None


def one_line(error: BaseException) -> str:
    """Return what another library complains of, in one line."""
    # Readers quote the bytes they stumble over; keep what can be printed.
    printable = "".join(c if c.isprintable() else " " for c in str(error))
    text = " ".join(printable.split()) or "no reason given"
    return f"{type(error).__name__}: {text if len(text) <= 160 else text[:159] + '…'}"
