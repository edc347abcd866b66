"""A kind of result: all that console, report, page and files show of it, in one object."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact._version import __version__
from roughcontact.errors import InputError
from roughcontact.files import require_suffix, to_json, write
from roughcontact.ranks import Ranks
from roughcontact.references import Reference
from roughcontact.report.fields import (
    ANSWER,
    Cells,
    Columns,
    Headline,
    Row,
    Table,
    csv_text,
    frame_of,
    listing_of,
    quantity_of,
    rows_of,
    some,
    stored,
    stored_columns,
)

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from roughcontact.report.assumptions import Assumption, Case
    from roughcontact.report.figures import Illustrations
    from roughcontact.report.page import Block

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
class Kind:
    """What there is to tell of one class of results, or of some of them."""

    result: type  # The class
    table: Table  # Its quantities
    columns: Columns = ()  # Those of each of its steps
    when: Callable[[Any], bool] = lambda _: True
    listed: bool = False  # Whether the summary has the columns, too
    brief: bool = True  # Whether a session shows the main rows alone
    problem: Callable[[Any], str] = _empty  # Bodies and load in one line
    question: Callable[[Any], str] = _empty  # What was asked, the title of its report
    answer: Callable[..., str] = _empty  # The answer in one sentence, with its interval
    numbers: Callable[..., CellTable] | None = None  # A few of them, in place of the steps
    remarks: Callable[..., tuple[str, ...]] = _none  # Interval, other ceiling, status: a line each
    sentences: Callable[[Any], tuple[str, ...]] = _none
    meaning: Callable[[Any], str] = _empty  # What they mean, in a sentence or two
    inputs: Callable[[Any, bool], list[Block]] | None = None  # What went in; whether drawn
    details: Callable[..., list[Block]] = _nothing  # What its report shows besides
    case: Callable[[Any], Case | None] | None = None  # Of assumptions, if not a contact's
    assumptions: Sequence[Assumption] = ()  # Besides those of a contact
    method: Callable[[Any], list[Block]] = _nothing  # How it is solved, besides a contact
    checked: Callable[[Any], tuple[str, ...]] = _none  # What it was checked for
    script: Callable[[Any], str] = _empty  # Python that repeats it
    figures: Illustrations = ()  # Of reports, and for `--figures`
    scene: Callable[[Any], Any] = _itself  # `scene(result)` is what they are drawn of
    plots: tuple[Callable[..., Figure], ...] = ()
    contact: Callable[[Any], Any] | None = None  # `contact(result)` is the contact that it is of
    largest: Callable[[Any], Any] | None = None  # `largest(result)` solves that of its report
    works: Callable[[Any], Iterable[Use]] = _none
    save: Callable[[Any, str | os.PathLike[str]], None] | None = None
    dataset: Callable[[Any], xarray.Dataset] | None = None  # What its NetCDF file holds
    ranks: Callable[[Any], Ranks | None] = lambda _: None

    @property
    def has_answer(self) -> bool:
        """Whether there is a sentence that answers what was asked."""
        return self.answer is not _empty

    def rows(self, result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
        """Return what is told of a result; see `fields.rows_of`."""
        return rows_of(self.table, result, part, brief)

    def headline(self, result: Any, **more: Any) -> Headline:
        """Return what is said first of a result."""
        listed: CellTable = (
            self.listing(result, True) if self.numbers is None else self.numbers(result, **more)
        )
        heads, rows = listed
        answer, remarks = self.answer(result, **more), self.remarks(result, **more)
        return Headline(self.problem(result), answer, heads, some(rows), remarks)

    def row(self, result: Any, key: str) -> Row:
        """Return one quantity of a result."""
        return quantity_of(self.table, key).row(result)

    def listing(
        self, result: Any, brief: bool = False
    ) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Return the head and the rows of the steps of a result; see `fields.listing_of`."""
        return listing_of(self.columns, result, brief)

    def drawings(self, result: Any) -> dict[str, Callable[[], Figure]]:
        """Return what draws the figures that are written to files, by name."""
        scene = self.scene(result)
        return {item.name: partial(item.draw, scene) for item in self.figures if item.name}

    def write(self, result: Any, path: str | os.PathLike[str]) -> None:
        """Write the steps of a result as a table, or all of it as JSON."""
        require_suffix(path, *((".csv", ".json") if self.columns else (".json",)))
        table = Path(path).suffix.lower() == ".csv"
        text = csv_text(self.columns, result) if table else to_json(self.summary(result)) + "\n"
        write(path, text)

    def to_pandas(self, result: Any) -> pandas.DataFrame:
        """Return the steps of a result as a table of pandas."""
        if not self.columns:
            raise InputError(f"{self.result.__name__} has no steps: use summary()")
        return frame_of(self.columns, result)

    def to_xarray(self, result: Any) -> xarray.Dataset:
        """Return a result as a dataset of xarray."""
        if self.dataset is None:
            other = "to_pandas()" if self.columns else "summary()"
            raise InputError(f"{self.result.__name__} has no NetCDF form: use {other}")
        return self.dataset(result)

    def summary(self, result: Any) -> dict[str, Any]:
        """Return a result by name, in SI units, ready for JSON."""
        numbers = stored(self.table, result)
        if self.listed:
            return {**numbers, **stored_columns(self.columns, result), "version": __version__}
        return numbers
