"""What all results and maps share: how a session shows, draws, saves, reports and cites them.

`Result.report`: Where a contact reaches its ceiling, the same problem is solved without one for
comparison.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from roughcontact.deprecated import Renamed

if TYPE_CHECKING:
    import pandas
    import xarray

    from roughcontact.references import References

Path = str | os.PathLike[str]


class Face(Protocol):
    """What the wings above do for maps, materials and results; `roughcontact.face` is it."""

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

    def to_pandas(self, shown: object) -> pandas.DataFrame:
        """Return the table of steps."""

    def to_xarray(self, shown: object) -> xarray.Dataset:
        """Return what a NetCDF file holds."""

    def summary(self, shown: object) -> dict[str, Any]:
        """Return the numbers by name."""

    def references(self, shown: object) -> References:
        """Return the papers."""

    def report(self, shown: object, path: Path, command: str, **more: Any) -> None:
        """Write a report."""

    def contact_cautions(self, shown: Any) -> Any:
        """Return what a reader of a contact has to know."""

    def volume_cautions(self, shown: Any) -> Any:
        """Return what a reader of a contact with its volume has to know."""

    def elastic(self, shown: Any) -> Any:
        """Return the same contact without a ceiling."""

    def stiffness(self, shown: Any) -> float:
        """Return the contact stiffness."""

    def estimate(self, shown: Any) -> Any:
        """Return what formulas say of a contact."""

    def profile(self, shown: Any, point: tuple[int, int] | None, body: int) -> Any:
        """Return plastic strain and stress over the depth."""

    def section(self, shown: Any, along: str, index: int | None, body: int) -> Any:
        """Return plastic strain and stress on a vertical plane."""

    def layers(self, shown: Any, body: int) -> Any:
        """Return what each layer holds at most."""

    def material(self, name: str) -> Any:
        """Return a material of the catalogue."""


_loaded: list[Callable[[], Face]] = []


def connect(load: Callable[[], Face]) -> None:
    """Say what loads the face; the package does so on import."""
    _loaded[:] = [load]


def face() -> Face:
    """Return the face of the house."""
    return _loaded[0]()


class Displayable(Renamed):
    """An object that a session shows by its headline numbers, and that offers its figures."""

    def __repr__(self) -> str:
        """Return the headline numbers, in some ten lines."""
        return face().text(self)

    def _repr_html_(self) -> str:
        """Return the headline numbers beside a picture, as a notebook shows them."""
        return face().html(self)

    @property
    def plot(self) -> Any:
        """Its figures: ``plot()`` draws the usual one, ``plot.pressure()`` and so on others."""
        return face().plots(self)

    def save(self, path: Path) -> None:
        """Write it in the format that the suffix of the file names."""
        face().save(self, path)

    def explore(self) -> Any:
        """Open the page on a map or a contact; see `roughcontact.desk.explore.explore`."""
        return face().explore(self)


class Result(Displayable):
    """A solved problem: numbers with units, their papers, and a report."""

    if TYPE_CHECKING:

        @property
        def cautions(self) -> tuple[Any, ...]:
            """What a reader of the numbers has to know, the severest first."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """The ``cautions``, one sentence each."""
        return tuple(caution.text for caution in self.cautions)

    def summary(self) -> dict[str, Any]:
        """Return the numbers by name, in SI units, ready for JSON."""
        return face().summary(self)

    def to_pandas(self) -> pandas.DataFrame:
        """Return its steps as a table of pandas: one row per step, one column per quantity.

        Returns
        -------
        pandas.DataFrame
            Values in SI units; ``attrs["units"]`` holds the unit of each column.

        Raises
        ------
        InputError
            If the result has no steps.
        """
        return face().to_pandas(self)

    def to_xarray(self) -> xarray.Dataset:
        """Return its maps and numbers as a dataset of xarray.

        Returns
        -------
        xarray.Dataset
            The dataset that ``save("result.nc")`` writes, in SI units.

        Raises
        ------
        InputError
            If the result has no NetCDF form, or several processes hold it.
        """
        return face().to_xarray(self)

    def references(self) -> References:
        """Return the papers behind what was used for it, as text and as BibTeX."""
        return face().references(self)

    def report(self, path: Path, command: str = "", study: Any = None, onset: Any = None) -> None:
        """Write a report that needs no other file and prints to A4."""
        face().report(self, path, command, study=study, onset=onset)
