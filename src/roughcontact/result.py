"""Shared methods of results and maps: display, plots, save, report and references.

`Result.report`: if a contact reaches its ceiling, the same problem is solved without a ceiling
for comparison.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas
    import xarray

    from roughcontact.references import References

Path = str | os.PathLike[str]


_connected: list[Any] = []


def set_presentation(module: Any) -> None:
    """Set the module that implements the methods of the higher layers: `roughcontact.face`."""
    _connected[:] = [module]


def presentation() -> Any:
    """Return the module `roughcontact.face`, which this layer cannot import."""
    return _connected[0]


class Displayable:
    """Object with a text display of its main quantities, and with figures."""

    def __repr__(self) -> str:
        """Return the main quantities as text, in about ten lines."""
        return presentation().text(self)

    def _repr_html_(self) -> str:
        """Return the main quantities and a figure as HTML, for notebooks."""
        return presentation().html(self)

    @property
    def plot(self) -> Any:
        """Figures: ``plot()`` draws the default figure, ``plot.pressure()`` etc. the others."""
        return presentation().plots(self)

    def save(self, path: Path) -> None:
        """Write the object to a file; the suffix selects the format."""
        presentation().presentation_of(self).save(path)

    def explore(self) -> Any:
        """Open the page on a map or a contact; see `roughcontact.desk.explore.explore`."""
        return presentation().explore(self)


class Result(Displayable):
    """Solved problem: quantities with units, references, and a report."""

    if TYPE_CHECKING:

        @property
        def cautions(self) -> tuple[Any, ...]:
            """Cautions on the result, the most severe first."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """The ``cautions``, one sentence each."""
        return tuple(caution.text for caution in self.cautions)

    def summary(self) -> dict[str, Any]:
        """Return the quantities by name, in SI units, ready for JSON."""
        return presentation().presentation_of(self).summary()

    def to_pandas(self) -> pandas.DataFrame:
        """Return a pandas table: one row per step, or one row, and one column per quantity.

        Returns
        -------
        pandas.DataFrame
            Values in SI units; ``attrs["units"]`` holds the unit of each column.
        """
        return presentation().presentation_of(self).to_pandas()

    def to_xarray(self) -> xarray.Dataset:
        """Return maps and quantities as an xarray dataset.

        Returns
        -------
        xarray.Dataset
            The dataset that ``save("result.nc")`` writes, in SI units.

        Raises
        ------
        InputError
            If the result has no NetCDF form.
        """
        return presentation().presentation_of(self).to_xarray()

    def references(self) -> References:
        """Return the references of the methods used, as text and as BibTeX."""
        return presentation().presentation_of(self).references()

    def report(self, path: Path, command: str = "", study: Any = None, onset: Any = None) -> None:
        """Write a self-contained report that prints to A4."""
        presentation().report(self, path, command, study=study, onset=onset)
