"""Presentation of a class of results in console, report, app and files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact._tools.files import require_suffix, to_json, write_atomically
from roughcontact._tools.text import csv_cell
from roughcontact._version import __version__
from roughcontact.errors import InputError
from roughcontact.references import Reference
from roughcontact.units import format_engineering, group_digits, plain_decimal

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from roughcontact._tools.netcdf import Dataset
    from roughcontact.report.assumptions import Assumption, Case
    from roughcontact.report.figures import Illustrations
    from roughcontact.report.page import Block

PROBLEM, ANSWER, TRUST, HEADLINE = "problem", "answer", "trust", "headline"
"""Parts of a table: input, result, accuracy, and the headline of a report."""

Cells = tuple[str, ...]

ABSENT = "–"
"""Text of a missing quantity in a table of several results."""


@dataclass(frozen=True)
class Row:
    """Quantity of one result."""

    key: str  # Name in files
    symbol: str  # Symbol of the quantity
    name: str  # Name of the quantity
    value: Any  # Value in SI units
    unit: str  # SI unit of the value
    meaning: str  # Short description
    text: str  # The value as text, with its unit

    @property
    def title(self) -> str:
        """Name and symbol: the first cell of a row."""
        return capitalize_first(f"{self.name} {self.symbol}".rstrip())


@dataclass(frozen=True)
class Headline:
    """Headline of a result: problem, answer, key quantities, and their uncertainty."""

    problem: str
    answer: str
    heads: Cells
    rows: Sequence[Cells]
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class Quantity:
    """Quantity of a class of results: its source and its format."""

    key: str  # Name in files
    name: str = ""  # Label
    symbol: str = ""  # As in `Row`
    unit: str = "1"  # As in `Row`
    meaning: str = ""  # As in `Row`
    of: Callable[[Any], Any] | str = ""  # `of(result)` returns the value in SI units
    digits: int = 4  # Significant digits
    form: Callable[[Any], str] | None = None
    text: Callable[[Any], str] | None = None
    part: str = ANSWER  # Part of the table
    when: Callable[[Any], bool] = lambda _: True  # `when(result)`: whether the quantity is shown
    brief: bool = True  # Whether the console shows the quantity
    stored: bool = True  # Whether the quantity is in the summary, and so in JSON

    def value(self, result: Any) -> Any:
        """Return the value [SI]."""
        return self.of(result) if callable(self.of) else attrgetter(self.of or self.key)(result)

    def format_value(self, value: Any) -> str:
        """Return a value as text."""
        return (
            format_value(value, self.unit, self.digits) if self.form is None else self.form(value)
        )

    def row(self, result: Any) -> Row:
        """Return the row of a result."""
        value = self.value(result)
        text = self.format_value(value) if self.text is None else self.text(result)
        return Row(self.key, self.symbol, self.name, value, self.unit, self.meaning, text)


@dataclass(frozen=True)
class Column:
    """Quantity of each step of a result."""

    key: str  # Name in files
    name: str = ""  # Head of the column
    unit: str = "1"  # SI unit
    of: Callable[[Any], Sequence[Any]] | None = None
    steps: str = "steps"  # Attribute of the result that holds its steps
    digits: int = 4  # Significant digits
    form: Callable[[Any], str] | None = None  # `form(value)` returns a value as text
    shown: Callable[[Any], Sequence[Any]] | None = None
    when: Callable[[Any], bool] = lambda _: True  # As for `Quantity`
    brief: bool = True  # As for `Quantity`
    stored: bool = True  # As for `Quantity`

    def values(self, result: Any) -> Sequence[Any]:
        """Return the values of all steps [SI]."""
        if self.of is not None:
            return self.of(result)
        return [getattr(step, self.key) for step in getattr(result, self.steps)]

    def texts(self, result: Any) -> list[str]:
        """Return the cells of the column."""
        form = self.form or (lambda value: format_value(value, self.unit, self.digits))
        return [form(value) for value in (self.shown or self.values)(result)]


# Values below this part of the sum over all steps are rounding errors.
_ROUNDING = 1e-9

# Side of a cube [m], and the name of this unit.
_SIDES = {1e-3: "mm", 1e-6: "µm", 1e-9: "nm"}


def format_without_rounding(key: str) -> Callable[[Any], Sequence[float]]:
    """Return a getter of the values of all steps, ≥ 0, with rounding errors set to zero."""

    def values(result: Any) -> list[float]:
        answer = [float(getattr(step, key)) for step in result.steps]
        minimum = _ROUNDING * sum(answer)
        return [value if value > minimum else 0.0 for value in answer]

    return values


Table = Sequence[Quantity]
Columns = Sequence[Column]


def format_value(value: Any, unit: str, digits: int = 4) -> str:
    """Return a value with its unit, in the format of all tables."""
    if isinstance(value, str):
        return value
    if isinstance(value, (tuple, list)):
        return ", ".join(format_value(entry, unit, digits) for entry in value)
    if unit == "m³":
        # The units of a volume differ by nine decimal digits.
        side = 1e-3 if value >= 1e-12 else 1e-6 if value >= 1e-21 or not value else 1e-9
        return f"{plain_decimal(value / side**3, digits)} {_SIDES[side]}³"
    if unit == "s":
        return f"{value:.2f} s"
    if unit == "1":
        return group_digits(str(value)) if isinstance(value, int) else f"{value:.{digits}g}"
    return group_digits(format_engineering(value, unit, digits))


def capitalize_first(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]


def rows_of(table: Table, result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
    """Return the rows of a result."""
    return [
        quantity.row(result)
        for quantity in table
        if quantity.name and quantity.part == part
        if (quantity.brief or not brief) and quantity.when(result)
    ]


def side_by_side(
    table: Table, results: Iterable[Any], part: str = ANSWER, brief: bool = False
) -> list[tuple[Row, tuple[str, ...]]]:
    """Return the rows of several results: a row, and the text of each result."""
    by_key = [{row.key: row for row in rows_of(table, result, part, brief)} for result in results]
    keys = [quantity.key for quantity in table if any(quantity.key in result for result in by_key)]
    return [
        (
            next(result[key] for result in by_key if key in result),
            tuple(result[key].text if key in result else ABSENT for result in by_key),
        )
        for key in keys
    ]


# Number of steps shown at the start and at the end of a long table.
_ENDS = 3


def first_and_last(rows: Sequence[Cells]) -> Sequence[Cells]:
    """Return the first and the last of many rows."""
    if len(rows) <= 2 * _ENDS:
        return rows
    return [*rows[:_ENDS], ("…",) * len(rows[0]), *rows[-_ENDS:]]


def quantity_of(table: Table, key: str) -> Quantity:
    """Return a quantity by its key."""
    return next(quantity for quantity in table if quantity.key == key)


def pick_quantities(table: Table, *keys: str) -> Table:
    """Return some quantities by their keys."""
    return [quantity_of(table, key) for key in keys]


def delegated(attribute: str, quantity: Quantity, **changes: Any) -> Quantity:
    """Return a quantity of an attribute of a result as a quantity of the result."""
    inner = attrgetter(attribute)

    def delegate(call: Callable[[Any], Any]) -> Callable[[Any], Any]:
        return lambda result: call(inner(result))

    text = None if quantity.text is None else delegate(quantity.text)
    moved = replace(quantity, of=delegate(quantity.value), text=text, when=delegate(quantity.when))
    return replace(moved, **changes)


def stored_values(table: Table, result: Any) -> dict[str, Any]:
    """Return the stored quantities of a result by key, in SI units, ready for JSON."""
    return {quantity.key: quantity.value(result) for quantity in table if quantity.stored}


def _stored_only(columns: Columns, result: Any) -> list[Column]:
    return [column for column in columns if column.stored and column.when(result)]


def stored_columns(columns: Columns, result: Any) -> dict[str, list[float]]:
    """Return the stored columns of the steps of a result."""
    return {
        column.key: [float(value) for value in column.values(result)]
        for column in _stored_only(columns, result)
    }


def frame_of(columns: Columns, result: Any) -> pandas.DataFrame:
    """Return the steps of a result as a pandas table, with units in its attributes."""
    import pandas

    stored_only = _stored_only(columns, result)
    frame = pandas.DataFrame({column.key: column.values(result) for column in stored_only})
    frame.attrs["units"] = {column.key: column.unit for column in stored_only}
    return frame


def listing_of(
    columns: Columns, result: Any, brief: bool = False
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of a table of steps."""
    text = [
        column
        for column in columns
        if column.name and (column.brief or not brief) and column.when(result)
    ]
    texts = (column.texts(result) for column in text)
    return tuple(column.name for column in text), list(zip(*texts, strict=True))


def csv_text(columns: Columns, result: Any) -> str:
    """Return the steps of a result as CSV text, with units in the head."""
    stored_only = _stored_only(columns, result)
    lines = [",".join(f"{column.key} [{column.unit}]" for column in stored_only)]
    steps = zip(*(column.values(result) for column in stored_only), strict=True)
    lines += [
        ",".join(csv_cell(value) if isinstance(value, str) else repr(value) for value in step)
        for step in steps
    ]
    return "\n".join(lines) + "\n"


CAUTIONS: Table = (
    Quantity("warnings", of=lambda r: list(r.warnings)),
    Quantity("cautions", of=lambda r: [caution.summary() for caution in r.cautions]),
)
"""Stored cautions of any result."""


# --- Presentation ---

Use = tuple[str, tuple[Reference, ...]]
CellTable = tuple[Cells, Sequence[Cells]]  # Heads, none if empty, and rows


def _none(_: Any, **__: Any) -> tuple[Any, ...]:
    return ()


def _empty(_: Any) -> str:
    return ""


def _nothing(*_: Any, **more: Any) -> list[Any]:
    return []


def _itself(result: Any) -> Any:
    return result


@dataclass(frozen=True)
class Presentation:
    """Presentation of a class of results, or of a part of the class."""

    result: type  # The class
    table: Table  # Quantities of the result
    columns: Columns = ()  # Quantities of each step
    when: Callable[[Any], bool] = lambda _: True
    listed: bool = False  # Whether the summary includes the columns
    brief: bool = True  # Whether a session shows only the main rows
    problem: Callable[[Any], str] = _empty  # Bodies and load in one line
    question: Callable[[Any], str] = _empty  # Question: title of the report
    answer: Callable[..., str] = _empty  # Answer in one sentence, with its interval
    numbers: Callable[..., CellTable] | None = None  # Key quantities, in place of the steps
    remarks: Callable[..., tuple[str, ...]] = _none  # Interval, other ceiling, status, in lines
    sentences: Callable[[Any], tuple[str, ...]] = _none
    meaning: Callable[[Any], str] = _empty  # Meaning, in a sentence or two
    inputs: Callable[[Any, bool], list[Block]] | None = None  # Inputs, with or without figures
    details: Callable[..., list[Block]] = _nothing  # Further blocks of the report
    case: Callable[[Any], Case | None] | None = None  # Case of the assumptions, if not a contact's
    assumptions: Sequence[Assumption] = ()  # In addition to those of a contact
    method: Callable[[Any], list[Block]] = _nothing  # Method, in addition to a contact's
    checked: Callable[[Any], tuple[str, ...]] = _none  # Performed checks
    script: Callable[[Any], str] = _empty  # Python script that repeats it
    figures: Illustrations = ()  # Figures of reports and of `--figures`
    scene: Callable[[Any], Any] = _itself  # `scene(result)` returns the scene of the figures
    plots: tuple[Callable[..., Figure], ...] = ()
    contact: Callable[[Any], Any] | None = None  # `contact(result)`: its contact
    largest: Callable[[Any], Any] | None = None  # `largest(result)` solves its contact
    uncertainty: Callable[[Any, Any], list[Block]] = _nothing  # Intervals, given a study
    contact_blocks: Callable[[Any], list[Block]] = _nothing  # Its blocks in other reports
    works: Callable[[Any], Iterable[Use]] = _none
    save: Callable[[Any, str | os.PathLike[str]], None] | None = None
    dataset: Callable[[Any], Dataset] | None = None  # Content of a NetCDF file

    @property
    def has_answer(self) -> bool:
        """Whether a sentence answers the question."""
        return self.answer is not _empty

    def rows(self, result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
        """Return the rows of a result; see `rows_of`."""
        return rows_of(self.table, result, part, brief)

    def headline(self, result: Any, **more: Any) -> Headline:
        """Return the headline of a result."""
        listed: CellTable = (
            self.listing(result, True) if self.numbers is None else self.numbers(result, **more)
        )
        heads, rows = listed
        answer, remarks = self.answer(result, **more), self.remarks(result, **more)
        return Headline(self.problem(result), answer, heads, first_and_last(rows), remarks)

    def row(self, result: Any, key: str) -> Row:
        """Return the row of one quantity of a result."""
        return quantity_of(self.table, key).row(result)

    def listing(
        self, result: Any, brief: bool = False
    ) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Return the head and the rows of the steps of a result; see `listing_of`."""
        return listing_of(self.columns, result, brief)

    def drawings(self, result: Any) -> dict[str, Callable[[], Figure]]:
        """Return the functions that draw the figures of files, by name."""
        scene = self.scene(result)
        return {item.name: partial(item.draw, scene) for item in self.figures if item.name}

    def write(self, result: Any, path: str | os.PathLike[str]) -> None:
        """Write the steps of a result as a table, or the whole result as JSON."""
        require_suffix(path, *((".csv", ".json") if self.columns else (".json",)))
        table = Path(path).suffix.lower() == ".csv"
        text = csv_text(self.columns, result) if table else to_json(self.summary(result)) + "\n"
        write_atomically(path, text)

    def to_pandas(self, result: Any) -> pandas.DataFrame:
        """Return the steps of a result as a pandas table, or its quantities as one row."""
        if self.columns:
            return frame_of(self.columns, result)
        import pandas

        frame = pandas.DataFrame([stored_values(self.table, result)])
        frame.attrs["units"] = {item.key: item.unit for item in self.table if item.stored}
        return frame

    def to_xarray(self, result: Any) -> xarray.Dataset:
        """Return a result as an xarray dataset."""
        if self.dataset is None:
            raise InputError(f"{self.result.__name__} has no NetCDF form: use to_pandas()")
        return self.dataset(result).to_xarray()

    def summary(self, result: Any) -> dict[str, Any]:
        """Return the values of a result by name, in SI units, ready for JSON."""
        numbers = stored_values(self.table, result)
        if self.listed:
            return {**numbers, **stored_columns(self.columns, result), "version": __version__}
        return numbers
