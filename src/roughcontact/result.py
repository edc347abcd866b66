"""Shared methods of results and maps: display, plots, save, report and references.

`Result.report`: Where a contact reaches its ceiling, the same problem is solved without one for
comparison.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from roughcontact._tools.deprecated import RenamedAttributes

if TYPE_CHECKING:
    import pandas
    import xarray

    from roughcontact.references import References

Path = str | os.PathLike[str]


_connected: list[Any] = []


def set_presentation(module: Any) -> None:
    """Set what the wings above do for maps, materials and results: `roughcontact.face`."""
    _connected[:] = [module]


def presentation() -> Any:
    """Return the module `roughcontact.face`, which stands above all that share this."""
    return _connected[0]


class Displayable(RenamedAttributes):
    """An object that a session shows by its headline numbers, and that offers its figures."""

    def __repr__(self) -> str:
        """Return the headline numbers, in some ten lines."""
        return presentation().text(self)

    def _repr_html_(self) -> str:
        """Return the headline with a figure, as a notebook shows it."""
        return presentation().html(self)

    @property
    def plot(self) -> Any:
        """Its figures: ``plot()`` draws the usual one, ``plot.pressure()`` and so on others."""
        return presentation().plots(self)

    def save(self, path: Path) -> None:
        """Write it in the format that the suffix of the file names."""
        presentation().save(self, path)

    def explore(self) -> Any:
        """Open the page on a map or a contact; see `roughcontact.desk.explore.explore`."""
        return presentation().explore(self)


class Result(Displayable):
    """A solved problem: numbers with units, their papers, and a report."""

    if TYPE_CHECKING:

        @property
        def cautions(self) -> tuple[Any, ...]:
            """Cautions on the result, the most severe first."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """The ``cautions``, one sentence each."""
        return tuple(caution.text for caution in self.cautions)

    def summary(self) -> dict[str, Any]:
        """Return the numbers by name, in SI units, ready for JSON."""
        return presentation().summary(self)

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
        return presentation().to_pandas(self)

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
        return presentation().to_xarray(self)

    def references(self) -> References:
        """Return the papers behind what was used for it, as text and as BibTeX."""
        return presentation().references(self)

    def report(self, path: Path, command: str = "", study: Any = None, onset: Any = None) -> None:
        """Write a report that needs no other file and prints to A4."""
        presentation().report(self, path, command, study=study, onset=onset)
