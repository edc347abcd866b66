"""What is told of any result, by its kind."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError
from roughcontact.references import References
from roughcontact.report import additions, blocks, figures, kinds, page, sources
from roughcontact.report.blocks import Blocks
from roughcontact.report.page import Edition
from roughcontact.report.quantities import ANSWER, Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def rows(result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
    """Return what is told of a result; see `quantities.rows_of`."""
    return kinds.of(result).rows(result, part, brief)


def listing(result: Any, brief: bool = False) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of the steps of a result; see `quantities.listing_of`."""
    return kinds.of(result).listing(result, brief)


def sentences(result: Any) -> tuple[str, ...]:
    """Return what a reader of a result has to know before its numbers."""
    return kinds.of(result).sentences(result)


def summary(result: Any) -> dict[str, Any]:
    """Return a result by name, in SI units, ready for JSON."""
    return kinds.of(result).summary(result)


def references(result: Any) -> References:
    """Return the papers behind a result."""
    return sources.of(kinds.of(result), result)


def shown(result: Any, **more: Any) -> Blocks:
    """Return what the console shows of a result."""
    kind = kinds.of(result)
    told = kind.blocks or partial(blocks.usual, kind)
    return told(result, **more)


def drawings(result: Any) -> dict[str, Callable[[], Figure]]:
    """Return what draws the figures of a result that are written to files, by name."""
    return figures.drawings(kinds.of(result), result)


def save(result: Any, path: str | os.PathLike[str]) -> None:
    """Write a map or a result in the format that the suffix of the file names."""
    kind = kinds.of(result)
    (kind.save or kind.write)(result, path)


def report(result: Any, path: str | os.PathLike[str], edition: Edition, **more: Any) -> None:
    """Write the report on a result to an HTML file.

    Parameters
    ----------
    result : object
        What the report is on.
    path : str or path
        File to write, ``.html`` or ``.htm``; it appears only once it is complete, and a file
        that was there stays as it was until then.
    edition : Edition
        What the report has besides.
    **more
        What reports of its kind take besides; what is empty or None is left out.

    Raises
    ------
    InputError
        If the suffix is another one, the folder does not exist, or there is no report of its kind.
    OSError
        If the file cannot be written.
    """
    page.check_path(path)
    kind = kinds.of(result)
    render = kind.report or (partial(additions.report, kind) if kind.title else None)
    if render is None:
        raise InputError(f"there is no report on a {type(result).__name__} alone")
    more = {name: one for name, one in more.items() if one}
    text, ranks = render(result, edition, **more), kind.ranks(result)
    if ranks is None:
        page.save(text, path)
    else:
        ranks.agreed(lambda: page.save(text, path) if ranks.first else None)
