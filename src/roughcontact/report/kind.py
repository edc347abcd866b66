"""Quantities of a class of results: their sources, names, units and formats."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, is_dataclass, replace
from enum import Enum
from functools import cache
from typing import Any

from roughcontact._tools.text import csv_cell
from roughcontact.references import Reference
from roughcontact.units import format_engineering, group_digits, plain_decimal

PROBLEM, ANSWER, TRUST, HEADLINE = "problem", "answer", "trust", "headline"
"""Parts of a table: input, result, accuracy, and the headline of a report."""

Cells = tuple[str, ...]

ABSENT = "–"
"""Text of a missing quantity in a table of several results."""


@dataclass(frozen=True)
class Row:
    """Quantity of one result."""

    key: str  # Name in files
    name: str  # Name of the quantity
    symbol: str  # Symbol of the quantity
    unit: str  # SI unit of the value
    meaning: str  # Short description
    value: Any  # Value in SI units
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


def read_attribute(value: Any, path: str) -> Any:
    """Return an attribute of an attribute; of a sequence on the path, that of each item.

    None where the path ends early.
    """
    name, _, rest = path.partition(".")
    value = getattr(value, name)
    if not rest or value is None:
        return value
    if isinstance(value, (tuple, list)) and not hasattr(value, "_fields"):
        return [read_attribute(item, rest) for item in value]
    return read_attribute(value, rest)


def plain_value(value: Any) -> Any:
    """Return a value ready for JSON."""
    if hasattr(value, "summary"):
        return value.summary()
    if is_dataclass(value):
        return asdict(value)  # type: ignore[arg-type]
    if hasattr(value, "_asdict"):
        return value._asdict()
    if isinstance(value, (tuple, list)):
        return [plain_value(item) for item in value]
    if hasattr(value, "tolist"):
        return value.tolist()
    return str(value) if isinstance(value, Enum) else value


def always(_: Any) -> bool:
    """Return True: the condition of a quantity that is shown even without a value."""
    return True


_LABEL = re.compile(r"(.*?)(?: \$(.*)\$)?(?: ?\[(.*?)\])?(?:: (.*))?")


@cache
def split_label(label: str) -> tuple[str, str, str, str]:
    """Return name, symbol, SI unit and meaning of ``"mean gap $ū$ [m]: of the open gap"``."""
    parts = _LABEL.fullmatch(label)
    assert parts is not None
    return parts[1], parts[2] or "", parts[3] or "1", parts[4] or ""


@dataclass(frozen=True, kw_only=True)
class _Labeled:
    key: str = field(kw_only=False)  # Name in files
    label: str = field(default="", kw_only=False)  # As in `split_label`; in files only without name
    of: Callable[[Any], Any] | str = ""  # `of(result)`, or the attribute, if not the key
    digits: int = 4  # Significant digits
    form: Callable[[Any], str] | None = None  # `form(value)` returns a value as text
    when: Callable[[Any], bool] | None = None  # Whether it is shown; if a value exists
    brief: bool = True  # Whether the console shows the quantity
    stored: bool = True  # Whether the quantity is in the summary, and so in JSON

    @property
    def name(self) -> str:
        """Name in tables."""
        return split_label(self.label)[0]

    @property
    def unit(self) -> str:
        """SI unit."""
        return split_label(self.label)[2]

    def format_value(self, value: Any) -> str:
        """Return a value as text."""
        return (
            format_value(value, self.unit, self.digits) if self.form is None else self.form(value)
        )


@dataclass(frozen=True, kw_only=True)
class Quantity(_Labeled):
    """Quantity of a class of results: its source and its format."""

    text: Callable[[Any], str] | None = None  # `text(result)` returns the value as text
    part: str = ANSWER  # Part of the table

    def value(self, result: Any) -> Any:
        """Return the value [SI]."""
        return self.of(result) if callable(self.of) else read_attribute(result, self.of or self.key)

    def is_shown(self, result: Any) -> bool:
        """Return whether a result has this quantity."""
        if self.when is not None:
            return self.when(result)
        value = self.value(result)
        return value is not None and not (isinstance(value, (tuple, list)) and not value)

    def row(self, result: Any) -> Row:
        """Return the row of a result."""
        value = self.value(result)
        text = self.format_value(value) if self.text is None else self.text(result)
        return Row(self.key, *split_label(self.label), value, text)


@dataclass(frozen=True, kw_only=True)
class Column(_Labeled):
    """Quantity of each step of a result."""

    shown: Callable[[Any], Sequence[Any]] | None = None  # Values in tables, if others
    listed: Callable[[Any], bool] = always  # Whether tables show it, too
    front: str = ""  # Head in the first table, if this shows only some columns

    def values(self, result: Any) -> Sequence[Any]:
        """Return the values of all steps [SI]; by default of the steps, if they have them."""
        if callable(self.of):
            values = self.of(result)
        else:
            steps: Sequence[Any] = () if self.of else getattr(result, "steps", ())
            is_step = len(steps) and hasattr(steps[0], self.key)
            path = self.of or (f"steps.{self.key}" if is_step else self.key)
            values = read_attribute(result, path)
        return values.tolist() if hasattr(values, "tolist") else values

    def is_shown(self, result: Any) -> bool:
        """Return whether the steps of a result have this quantity."""
        return self.values(result) is not None if self.when is None else self.when(result)

    def texts(self, result: Any) -> list[str]:
        """Return the cells of the column."""
        return [self.format_value(value) for value in (self.shown or self.values)(result)]


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


def largest_of_steps(
    key: str, label: str, name: str, steps: str = "steps", **more: Any
) -> Quantity:
    """Return the quantity of the largest of an error of all steps."""

    def largest(result: Any) -> float:
        return max(getattr(step, name) for step in getattr(result, steps))

    return Quantity(key, label, of=largest, part=TRUST, **more)


REPORT_ONLY: dict[str, Any] = {"stored": False, "brief": False}
"""Arguments of a quantity that only reports show."""

Table = Sequence[Quantity]
Columns = Sequence[Column]


def format_value(value: Any, unit: str, digits: int = 4) -> str:
    """Return a value with its unit, in the format of all tables."""
    if isinstance(value, str):
        return str(value)
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
        if (quantity.brief or not brief) and quantity.is_shown(result)
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


def delegate_quantity(attribute: str, quantity: Quantity, **changes: Any) -> Quantity:
    """Return a quantity of an attribute of a result as a quantity of the result."""

    def delegate(call: Callable[[Any], Any]) -> Callable[[Any], Any]:
        return lambda result: call(read_attribute(result, attribute))

    text = quantity.text and delegate(quantity.text)
    when = quantity.when and delegate(quantity.when)
    return replace(replace(quantity, of=delegate(quantity.value), text=text, when=when), **changes)


# A profile is a map 1 m wide: its quantities are per meter of width.
_UNITS = {"N": "N/m", "N/m": "N/m/m", "J": "J/m", "m²": "m", "m³": "m²"}
_KEYS = {
    "contact_area": "contact_length",
    "saturated_area": "saturated_length",
    "nominal_area": "length",
    "spots": "segments",
    "mean_spot_area": "mean_segment",
    "largest_spot_area": "largest_segment",
    "yielded_volume": "yielded_section",
}
_WORDS = {
    "pixel": "point",
    "pixels": "points",
    "map": "profile",
    "area": "length",
    "spots": "segments",
    "volume": "cross-section",
}


def _profile_names(item: Quantity | Column) -> dict[str, Any]:
    label = re.sub(r"\w+", lambda word: _WORDS.get(word[0], word[0]), item.label)
    label = re.sub(r"\[(.*?)\]", lambda unit: f"[{_UNITS.get(unit[1], unit[1])}]", label)
    return {"key": _KEYS.get(item.key, item.key), "label": label}


def profile_table(table: Table, *absent: str, **changes: dict[str, Any]) -> Table:
    """Return the quantities of profiles: those of maps without some, and with changes by key."""
    return tuple(
        replace(item, **_profile_names(item) | {"of": item.value} | changes.get(item.key, {}))
        for item in table
        if item.key not in absent
    )


def profile_columns(columns: Columns, *absent: str) -> Columns:
    """Return the columns of profiles: those of maps without some."""
    return tuple(
        replace(item, of=item.values, **_profile_names(item))
        for item in columns
        if item.key not in absent
    )


def stored_values(table: Table, result: Any) -> dict[str, Any]:
    """Return the stored quantities of a result by key, in SI units, ready for JSON."""
    return {item.key: plain_value(item.value(result)) for item in table if item.stored}


def stored_only(columns: Columns, result: Any) -> list[Column]:
    """Return the columns of a result that are in files."""
    return [column for column in columns if column.stored and column.is_shown(result)]


def stored_columns(columns: Columns, result: Any) -> dict[str, list[float]]:
    """Return the stored columns of the steps of a result."""
    return {
        column.key: [float(value) for value in column.values(result)]
        for column in stored_only(columns, result)
    }


def listing_of(
    columns: Columns, result: Any, brief: bool = False
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of a table of steps."""
    text = [
        column
        for column in columns
        if column.name and (column.brief or not brief)
        if column.is_shown(result) and column.listed(result)
    ]
    texts = (column.texts(result) for column in text)
    return tuple(column.name for column in text), list(zip(*texts, strict=True))


def stored_steps(columns: Columns, result: Any) -> Iterator[tuple[Any, ...]]:
    """Yield the head, with units, and the values of each step of a result."""
    stored = stored_only(columns, result)
    yield tuple(f"{column.key} [{column.unit}]" for column in stored)
    yield from zip(*(column.values(result) for column in stored), strict=True)


def csv_text(rows: Iterable[tuple[Any, ...]]) -> str:
    """Return the rows of a table as CSV text."""
    return "".join(
        ",".join(csv_cell(value) if isinstance(value, str) else repr(value) for value in row) + "\n"
        for row in rows
    )


CAUTIONS = (Quantity("warnings"), Quantity("cautions"))
"""Stored cautions of any result."""


Use = tuple[str, tuple[Reference, ...]]
CellTable = tuple[Cells, Sequence[Cells]]  # Heads, none if empty, and rows
