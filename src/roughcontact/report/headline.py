"""An object at a glance: what a session prints of it, and a notebook shows."""

from __future__ import annotations

import base64
import html as markup
import textwrap
from collections.abc import Callable
from functools import partial, update_wrapper
from typing import TYPE_CHECKING, Any

from roughcontact.cautions import Severity
from roughcontact.errors import InputError
from roughcontact.plots.export import png
from roughcontact.report import kinds
from roughcontact.report.fields import Headline

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cells = tuple[str, ...]

_WIDE, _SMALL = 420, 340
# Letters of a line.
_LINE = 88


def text(shown: Any) -> str:
    """Return problem, answer and headline numbers of an object, some ten lines."""
    first = _first(shown)
    lines = [f"{_kind(shown)}: {first.problem}".removesuffix(": ")]
    lines += _wrapped(first.answer)
    table = _table(first)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines += [
        "  " + "  ".join(f"{cell:{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]
    for sentence in (*first.remarks, *_cautions(shown)):
        lines += _wrapped(sentence)
    return "\n".join(lines)


def _wrapped(sentence: str) -> list[str]:
    return textwrap.wrap(sentence, _LINE, initial_indent="  ", subsequent_indent="    ")


def html(shown: Any) -> str:
    """Return the same as HTML, beside a picture where there is one of its kind."""
    first = _first(shown)
    rows = "".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in _table(first))
    said = (first.problem, first.answer, *first.remarks, *_cautions(shown))
    before, after = (
        "".join(f"<p>{markup.escape(line, quote=False)}</p>" for line in part if line)
        for part in (said[:2], said[2:])
    )
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 1em; align-items: flex-start">'
        f'{_picture(shown)}<div style="max-width: 40em"><b>{markup.escape(_kind(shown))}</b>'
        f"{before}<table>{rows}</table>{after}</div></div>"
    )


def _first(shown: Any) -> Headline:
    """Return what is said first; of a map its parameters."""
    kind = kinds.of(shown)
    if kind.has_answer:
        return kinds.headline(shown)
    rows = [(row.name, row.text) for row in kind.rows(shown, brief=kind.brief)]
    heads, steps = kind.listing(shown, brief=True)
    return Headline("", "", (), [*rows, *([heads, *steps] if not rows else [])], ())


def _table(first: Headline) -> list[Cells]:
    return [*([first.heads] if any(first.heads) else []), *first.rows]


def _kind(shown: Any) -> str:
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
    try:
        figures = Plots(shown, kinds.of(shown).plots)
        # One map: what shows four at once is too small here.
        figure = figures.pressure() if "pressure" in dir(figures) else figures()
    except (AttributeError, InputError):
        # Kinds that have none, and results that have nothing to draw.
        return ""
    data = base64.b64encode(png(figure)).decode("ascii")
    wide = _WIDE if figure.get_figwidth() > figure.get_figheight() else _SMALL
    return f'<img alt="" style="width: {wide}px" src="data:image/png;base64,{data}">'


# --- The figures of an object as its methods: `result.plot.pressure()` ---


Draw = Callable[..., "Figure"]


class Plots:
    """The figures of one object by their names in ``rc.plots``; the first is the usual one."""

    def __init__(self, shown: object, figures: tuple[Draw, ...]) -> None:
        if not figures:
            raise AttributeError(f"{type(shown).__name__} has no figures")
        self._shown = shown
        self._figures = {figure.__name__: figure for figure in figures}

    def __call__(self, **options: Any) -> Figure:
        """Draw the usual figure."""
        usual = next(iter(self._figures.values()))
        return usual(self._shown, **options)

    def __getattr__(self, name: str) -> Draw:
        """Return what draws a figure, with its own documentation."""
        if name.startswith("_") or name not in self._figures:
            raise AttributeError(f"there is no figure {name!r}, only {', '.join(self._figures)}")
        draw = self._figures[name]
        return update_wrapper(partial(draw, self._shown), draw)

    def __dir__(self) -> list[str]:
        """Return the names of the figures."""
        return list(self._figures)

    def __repr__(self) -> str:
        """Return the names of the figures, as they are called."""
        return "figures: plot(), " + ", ".join(f"plot.{name}()" for name in self._figures)
