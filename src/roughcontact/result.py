"""What all results and maps share: how a session shows, draws, saves, reports and cites them."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from roughcontact.references import References

Path = str | os.PathLike[str]


class Face(Protocol):
    """What the wings above do for maps and results; `roughcontact.face` is it."""

    def text(self, shown: object) -> str:
        """Return the headline numbers, one line each."""

    def html(self, shown: object) -> str:
        """Return the headline numbers as HTML."""

    def plots(self, shown: object) -> Any:
        """Return the figures as methods."""

    def explore(self, shown: object) -> Any:
        """Open the page in the browser."""

    def save(self, shown: object, path: Path) -> None:
        """Write a file in the format that its suffix names."""

    def summary(self, shown: object) -> dict[str, Any]:
        """Return the numbers by name."""

    def references(self, shown: object) -> References:
        """Return the papers."""


_loaded: list[Callable[[], Face]] = []


def connect(load: Callable[[], Face]) -> None:
    """Say what loads the face; the package does so on import."""
    _loaded[:] = [load]


def _face() -> Face:
    return _loaded[0]()


class Shown:
    """An object that a session shows by its headline numbers, and that offers its figures."""

    def __repr__(self) -> str:
        """Return the headline numbers, in some ten lines."""
        return _face().text(self)

    def _repr_html_(self) -> str:
        """Return the headline numbers beside a picture, as a notebook shows them."""
        return _face().html(self)

    @property
    def plot(self) -> Any:
        """Its figures: ``plot()`` draws the usual one, ``plot.pressure()`` and so on others."""
        return _face().plots(self)

    def save(self, path: Path) -> None:
        """Write to the format that the suffix of the file names; the error lists those it has.

        Parameters
        ----------
        path : str or path
            File to write; it appears only once it is complete.

        Raises
        ------
        InputError
            If nothing of this kind is written with this suffix.
        OSError
            If the file cannot be written; an old file survives.
        """
        _face().save(self, path)

    def explore(self) -> Any:
        """Open it in the browser; see `roughcontact.desk.explore.explore`."""
        return _face().explore(self)


class Result(Shown):
    """A solved problem: numbers with units, their papers, and a report."""

    def summary(self) -> dict[str, Any]:
        """Return the numbers by name, in SI units, ready for JSON."""
        return _face().summary(self)

    def references(self) -> References:
        """Return the papers behind what was used for it, as text and as BibTeX."""
        return _face().references(self)
