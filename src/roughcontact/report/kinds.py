"""Display of any result: in a session, a notebook and a report."""

from __future__ import annotations

import base64
import html as markup
import os
import textwrap
from collections.abc import Callable
from functools import partial, update_wrapper
from typing import TYPE_CHECKING, Any

from roughcontact._tools.files import write_atomically
from roughcontact.cautions import Severity
from roughcontact.errors import InputError
from roughcontact.report import page
from roughcontact.report.kind import ANSWER, Headline, Row
from roughcontact.report.page import PLAIN, Edition
from roughcontact.report.presentation import presentation_of as presentation_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def rows(result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
    """Return the rows of a result; see `kind.rows_of`."""
    return presentation_of(result).rows(part, brief)


def listing(result: Any, brief: bool = False) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of the steps of a result; see `kind.listing_of`."""
    return presentation_of(result).listing(brief)


def sentences(result: Any) -> tuple[str, ...]:
    """Return the sentences that precede the quantities of a result."""
    return tuple(presentation_of(result).sentences())


def drawings(result: Any) -> dict[str, Callable[[], Figure]]:
    """Return the functions that draw the figures of files, by name."""
    return presentation_of(result).drawings()


def report(result: Any, path: str | os.PathLike[str], edition: Edition, **more: Any) -> None:
    """Write the report on a result to an HTML file."""
    page.check_path(path)
    shown = presentation_of(result, **more)
    if not shown.question():
        raise InputError(f"there is no report on a {type(result).__name__} alone")
    write_atomically(path, shown.render(edition))


def render(result: Any, edition: Edition = PLAIN, **more: Any) -> str:
    """Return the report on any result as the text of an HTML file."""
    return presentation_of(result, **more).render(edition)


_WIDE, _SMALL = 420, 340
# Characters of a line.
_LINE = 88


def headline_text(shown: Any) -> str:
    """Return problem, answer and main quantities of an object as text, about ten lines."""
    first = _headline_of(shown)
    lines = [f"{_class_name(shown)}: {first.problem}".removesuffix(": ")]
    lines += _wrap_text(first.answer)
    table = _table(first)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines += [
        "  " + "  ".join(f"{cell:{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]
    for sentence in (*first.remarks, *_cautions(shown)):
        lines += _wrap_text(sentence)
    return "\n".join(lines)


def _wrap_text(sentence: str) -> list[str]:
    return textwrap.wrap(sentence, _LINE, initial_indent="  ", subsequent_indent="    ")


def headline_html(shown: Any) -> str:
    """Return the headline as HTML, next to a figure if there is one."""
    first = _headline_of(shown)
    rows = "".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in _table(first))
    said = (first.problem, first.answer, *first.remarks, *_cautions(shown))
    before, after = (
        "".join(f"<p>{markup.escape(line, quote=False)}</p>" for line in part if line)
        for part in (said[:2], said[2:])
    )
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 1em; align-items: flex-start">'
        f'{_picture(shown)}<div style="max-width: 40em"><b>{markup.escape(_class_name(shown))}</b>'
        f"{before}<table>{rows}</table>{after}</div></div>"
    )


def _headline_of(shown: Any) -> Headline:
    """Return the headline of a result; of a map, its roughness parameters."""
    kind = presentation_of(shown)
    first = kind.headline()
    if first.answer:
        return first
    rows = [(row.name, row.text) for row in kind.rows()]
    return Headline("", "", (), rows or [first.heads, *first.rows], ())


def _table(first: Headline) -> list[tuple[str, ...]]:
    return [*([first.heads] if any(first.heads) else []), *first.rows]


def _class_name(shown: Any) -> str:
    kind = type(shown).__name__
    return kind if getattr(shown, "converged", True) else f"{kind}, not converged"


def _cautions(shown: Any) -> list[str]:
    """Return the warnings and cautions, one line each."""
    return [
        f"{caution.severity.upper()} {caution.kind}: {caution.text}"
        for caution in getattr(shown, "cautions", ())
        if caution.severity != Severity.NOTE
    ]


def _cell(text: str) -> str:
    return f'<td style="text-align: left">{markup.escape(text)}</td>'


def _picture(shown: Any) -> str:
    from roughcontact.drawing.export import png

    try:
        figures = Plots(shown)
        # One panel only: the figure of four panels is too large for a notebook cell.
        figure = figures.pressure() if "pressure" in dir(figures) else figures()
    except (AttributeError, InputError):
        # Some classes have no figures, and some results nothing to draw.
        return ""
    data = base64.b64encode(png(figure)).decode("ascii")
    wide = _WIDE if figure.get_figwidth() > figure.get_figheight() else _SMALL
    return f'<img alt="" style="width: {wide}px" src="data:image/png;base64,{data}">'


Draw = Callable[..., "Figure"]


class Plots:
    """Figures of an object by their names in ``rc.plots``; the first is the default."""

    def __init__(self, shown: object) -> None:
        self._shown = shown
        self._figures = {figure.__name__: figure for figure in presentation_of(shown).own("plots")}
        if not self._figures:
            raise AttributeError(f"{type(shown).__name__} has no figures")

    def __call__(self, **options: Any) -> Figure:
        """Draw the default figure."""
        return next(iter(self._figures.values()))(self._shown, **options)

    def __getattr__(self, name: str) -> Draw:
        """Return the function that draws a figure, with its documentation."""
        if name.startswith("_") or name not in self._figures:
            raise AttributeError(f"there is no figure {name!r}, only {', '.join(self._figures)}")
        draw = self._figures[name]
        return update_wrapper(partial(draw, self._shown), draw)

    def __dir__(self) -> list[str]:
        """Return the names of the figures."""
        return list(self._figures)

    def __repr__(self) -> str:
        """Return the calls of the figures as text."""
        return "figures: plot(), " + ", ".join(f"plot.{name}()" for name in self._figures)
