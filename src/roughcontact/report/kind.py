"""A kind of result: all that console, report, page and files tell of it, in one object."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from roughcontact.references import Reference
from roughcontact.report.quantities import Columns, Table
from roughcontact.report.scenes import Illustrations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Uses = tuple[tuple[str, tuple[Reference, ...]], ...]


def _none(_: Any) -> tuple[str, ...]:
    return ()


@dataclass(frozen=True)
class Kind:
    """What there is to tell of one class of results.

    Parameters
    ----------
    result : type
        The class.
    table, columns : Table, Columns
        Its quantities, and those of each of its steps.
    title : str
        Of its chapter in the report on the contact that it is of.
    sentences : callable
        What a reader has to know before the numbers.
    figures : Illustrations
        Of reports, and for ``--figures``.
    plots : tuple of callable
        Figures that ``result.plot`` offers, the usual one first.
    works : Uses
        The papers behind it, besides those of the contact that it is of.
    """

    result: type
    table: Table
    columns: Columns = ()
    title: str = ""
    sentences: Callable[[Any], tuple[str, ...]] = _none
    figures: Illustrations = ()
    plots: tuple[Callable[..., Figure], ...] = ()
    works: Uses = ()
