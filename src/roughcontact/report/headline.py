"""An object at a glance: what a session prints of it, and a notebook shows."""

from __future__ import annotations

import base64
import html as markup
import textwrap
from typing import Any

from roughcontact.cautions import Severity
from roughcontact.errors import InputError
from roughcontact.plots import accessor
from roughcontact.plots.export import png
from roughcontact.report import contact, kinds

Cells = tuple[str, ...]

# Steps that are shown of many: so many of the first, and so many of the last.
_ENDS = 4
_WIDE, _SMALL = 420, 340
# Letters of a line.
_LINE = 88


def text(shown: Any) -> str:
    """Return the headline numbers of an object, one line each."""
    lines = [_kind(shown) + ":"]
    for table in _tables(shown):
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        lines += [
            "  " + "  ".join(f"{cell:{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
            for row in table
        ]
    for caution in _cautions(shown):
        lines += textwrap.wrap(caution, _LINE, initial_indent="  ", subsequent_indent="    ")
    return "\n".join(lines)


def html(shown: Any) -> str:
    """Return the same as HTML, beside a picture where there is one of its kind."""
    tables = "".join(
        "<table>"
        + "".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in table)
        + "</table>"
        for table in _tables(shown)
    )
    kind = markup.escape(_kind(shown))
    lines = (markup.escape(caution, quote=False) for caution in _cautions(shown))
    cautions = "".join(f"<p>{caution}</p>" for caution in lines)
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 1em; align-items: flex-start">'
        f'{_picture(shown)}<div style="max-width: 40em"><b>{kind}</b>{tables}{cautions}</div></div>'
    )


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


def _tables(shown: Any) -> list[list[Cells]]:
    """Return names with values, and the steps where there are some."""
    kind = kinds.of(shown)
    heads, answer = contact.beside_calibrated(kind, shown, kind.brief)
    table_rows: list[Cells] = [("", *heads)] if heads else []
    table_rows += [(row.name, *texts) for row, texts in answer]
    head, steps = kind.listing(shown, brief=True)
    if len(steps) > 2 * _ENDS:
        steps = [*steps[:_ENDS], ("…",) * len(head), *steps[-_ENDS:]]
    return [table for table in (table_rows, [head, *steps] if steps else []) if table]


def _picture(shown: Any) -> str:
    try:
        figures = accessor.Plots(shown, kinds.of(shown).plots)
        # One map: what shows four at once is too small here.
        figure = figures.pressure() if "pressure" in dir(figures) else figures()
    except (AttributeError, InputError):
        # Kinds that have none, and results that have nothing to draw.
        return ""
    data = base64.b64encode(png(figure)).decode("ascii")
    wide = _WIDE if figure.get_figwidth() > figure.get_figheight() else _SMALL
    return f'<img alt="" style="width: {wide}px" src="data:image/png;base64,{data}">'
