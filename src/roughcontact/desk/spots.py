"""The contact spots as a table that can be sorted; who chooses a row sees its spot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import Column, ColumnDataSource, DataTable, NumberFormatter, TableColumn
from numpy.typing import NDArray

from roughcontact.contact.result import ContactResult
from roughcontact.desk import look
from roughcontact.desk.pictures import Box
from roughcontact.plots.style import prefixed, prefixed_area, prefixed_window
from roughcontact.units import counted

# Rows of the table, at most: the largest spots.
_MOST = 1000
# A spot is shown with so many times its own size around it, and no fewer points than that.
_AROUND, _FEWEST = 1.5, 24


class Listed(NamedTuple):
    """The largest spots of a contact [SI]; a place is that of the largest pressure on a spot."""

    area: NDArray[np.float64]
    load: NDArray[np.float64]
    peak: NDArray[np.float64]
    saturated: NDArray[np.float64]
    y: NDArray[np.float64]
    x: NDArray[np.float64]


def listed(result: ContactResult, most: int = _MOST) -> Listed:
    """Return the largest spots: area, load, largest pressure, saturated share, place."""
    spots = result.spots()
    count = min(spots.count, most)
    inside = np.flatnonzero(spots.label)
    label = spots.label.ravel()[inside] - 1
    pressure = result.pressure.ravel()[inside]
    # The last of equal keys stays: that of the largest pressure.
    order = np.argsort(pressure, kind="stable")
    place = np.zeros(spots.count, np.intp)
    place[label[order]] = inside[order]
    rows, columns = np.divmod(place[:count], result.pressure.shape[1])
    pixels = np.bincount(label, minlength=spots.count)
    full = np.bincount(label, result.saturated.ravel()[inside], spots.count)
    dy, dx = result.surface.pixel
    return Listed(
        spots.area[:count],
        spots.load[:count],
        spots.peak[:count],
        (full / np.maximum(pixels, 1))[:count],
        (rows + 0.5) * dy,
        (columns + 0.5) * dx,
    )


def box_around(result: ContactResult, number: int) -> Box:
    """Return the box in which a spot is seen with what lies around it [m], by its row.

    Of a spot that goes on beyond an edge of a periodic map, it is the part with the largest
    pressure in the middle that counts.
    """
    mask = result.spots().label == number + 1
    place = np.unravel_index(np.argmax(np.where(mask, result.pressure, -1.0)), mask.shape)
    edges = []
    for axis in (0, 1):
        along = np.flatnonzero(mask.any(axis=1 - axis))
        # Parts apart from each other lie on both edges: that with the place counts.
        parts = np.split(along, np.flatnonzero(np.diff(along) > 1) + 1)
        part = next(one for one in parts if place[axis] in one)
        middle = (part[0] + part[-1] + 1) / 2
        half = max((_AROUND + 0.5) * (part[-1] + 1 - part[0]), _FEWEST) / 2
        edges.append(((middle - half) * result.surface.pixel[axis],
                      (middle + half) * result.surface.pixel[axis]))  # fmt: skip
    (top, bottom), (left, right) = edges
    return Box(top, left, bottom, right)


class SpotTable:
    """A table of the largest spots."""

    def __init__(self) -> None:
        self._result: ContactResult | None = None
        self._call: Callable[[Box], None] | None = None
        self.source: Any = ColumnDataSource({name: [] for name in ("number", *_NAMES)})
        self.columns = {
            name: TableColumn(
                field=name, title=title, formatter=NumberFormatter(format="0.[000000]")
            )
            for name, title in (("number", "spot"), *_NAMES.items())
        }
        self.columns["number"].formatter = NumberFormatter(format="0")
        self.columns["number"].width = 60
        self.table: Any = DataTable(
            source=self.source, columns=list(self.columns.values()), index_position=None,
            sortable=True, reorderable=False, selectable=True, height=300,
            sizing_mode="stretch_width", autosize_mode="fit_viewport",
        )  # fmt: skip
        self.note: Any = look.markup(sizing_mode="stretch_width")
        self.root = Column(self.note, self.table, sizing_mode="stretch_width")
        self.source.selected.on_change("indices", self._chosen)

    def on_spot(self, call: Callable[[Box], None]) -> None:
        """Have ``call(box)`` called with the box [m] around a spot that is chosen."""
        self._call = call

    def clear(self) -> None:
        """Show nothing."""
        self._result = None
        self.source.data = {name: [] for name in self.source.data}
        look.put(self.note, "")

    def show(self, result: ContactResult) -> None:
        """Show the spots of a result."""
        self._result = result
        found = listed(result)
        count = found.area.size
        units = _units(result, found)
        with look.together(self.table.document):
            self.source.selected.indices = []
            self.source.data = {
                "number": np.arange(1, count + 1),
                **{name: _rounded(getattr(found, name) * units[name][0]) for name in _NAMES},
            }
            for name, title in _NAMES.items():
                self.columns[name].title = f"{title} [{units[name][1]}]"
            whole = counted(result.spots().count, "contact spot")
            shown = f", the {count} largest of them here" if count < result.spots().count else ""
            look.put(
                self.note,
                f"{whole}{shown}. Choose a row to see its spot; its place is that of its largest "
                "pressure.",
            )

    def _chosen(self, attr: str, old: Any, new: Any) -> None:
        if new and self._result is not None and self._call is not None:
            self._call(box_around(self._result, int(new[0])))


def _rounded(values: NDArray[np.float64]) -> list[float]:
    # To four digits, as all numbers are told; they are sorted by what one reads.
    return [float(f"{value:.4g}") for value in values]


_NAMES = {
    "area": "area", "load": "load", "peak": "largest pressure", "saturated": "saturated",
    "y": "y", "x": "x",
}  # fmt: skip


def _units(result: ContactResult, found: Listed) -> dict[str, tuple[float, str]]:
    def largest(values: NDArray[np.float64]) -> float:
        return float(values.max(initial=0.0))

    place = prefixed_window(0.0, max(result.surface.size))
    return {
        "area": prefixed_area(largest(found.area)),
        "load": prefixed(largest(found.load), result.pair.load_unit),
        "peak": prefixed(largest(found.peak), "Pa"),
        "saturated": (100.0, "%"),
        "y": place,
        "x": place,
    }
