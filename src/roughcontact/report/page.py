"""HTML report: front page and numbered chapters in one self-contained file.

The report prints to A4.
"""

from __future__ import annotations

import base64
import datetime
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from roughcontact._tools.text import replace_unprintable
from roughcontact._version import __version__
from roughcontact.cautions import Caution, CautionTag, Severity
from roughcontact.drawing import export
from roughcontact.drawing.style import DPI
from roughcontact.errors import (
    InputError,
    Sentence,
    Spell,
    input_error,
    message_parts,
    render_message,
)
from roughcontact.report.kind import Cells, Headline

if TYPE_CHECKING:
    import jinja2
    from matplotlib.figure import Figure

_TEMPLATE = "report.html.j2"

HALF, MIDDLE, WIDE = 84, 124, 178
"""Widths of figures [mm]: two in a row, one next to its caption, and the whole page."""

# Printed over drawn size of all figures: the smallest text, 10.5 points, is printed as 7.1.
_SCALE = 0.68

# Largest height over width of the widest figures, to leave space for the key quantities.
_MAX_ASPECT_RATIO = 0.62

# Number of columns from which a table has a dense layout.
_MANY_COLUMNS = 7

# Number of rows up to which a table is kept on one page.
_FEW_ROWS = 12


@dataclass(frozen=True, eq=False)
class PageTable:
    """Table of text; the first cell of each row is its head."""

    rows: Sequence[Cells]  # Cells of each row
    head: Cells = ()  # Heads of the columns
    style: str = ""  # Class of the style sheet

    @property
    def styles(self) -> str:
        """Style classes; many columns are dense, few rows stay on one page."""
        dense = "dense" if len(self.head) >= _MANY_COLUMNS else ""
        whole = "whole" if len(self.rows) <= _FEW_ROWS else ""
        return " ".join(filter(None, (self.style, dense, whole)))


@dataclass(frozen=True, eq=False)
class Picture:
    """Figure of a page."""

    draw: Callable[[], Figure]  # Function that draws the figure
    caption: str  # Text below the figure, and its alternative text
    width: int = MIDDLE  # `HALF`, `MIDDLE` or `WIDE`

    def draw_figure(self) -> Figure:
        """Return the figure in the size at which all figures have the same printed text size."""
        figure = self.draw()
        wide, tall = figure.get_size_inches()
        inches = self.width / 25.4 / _SCALE
        height = tall * inches / wide
        if self.width == WIDE and figure.get_layout_engine() is not None:
            height = min(height, _MAX_ASPECT_RATIO * inches)
        figure.set_size_inches(inches, height)
        # Keep the number of dots: a map needs at least one for each of its cells.
        figure.set_dpi(DPI * max(wide / inches, 1.0))
        if self.width == HALF:
            # Titles and notes do not fit; the caption replaces them.
            for axes in figure.axes:
                axes.set_title("")
            figure.suptitle("")
            figure.supxlabel("")
        return figure


class Block(NamedTuple):
    """Part of a chapter: type and content."""

    kind: str  # "text", "small", "head", "warning", "code", "table", "figure", "aside" or "list"
    content: Any  # Text, table, figure, or a list of these


class Chapter(NamedTuple):
    """Chapter of a report: heading and blocks in order."""

    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Front:
    """First page of a report: question, answer, one figure and the key quantities."""

    question: str  # Title
    headline: Headline  # Problem, answer, key quantities and remarks
    meaning: str  # Meaning of the result
    figure: Picture | None  # Most informative figure
    cautions: Sequence[Caution]  # Cautions
    status: str = "converged"  # Or the reason why the solver stopped

    @property
    def numbers(self) -> PageTable:
        """Table of the key quantities."""
        heads = self.headline.heads
        return PageTable(self.headline.rows, heads, "" if heads else "key")

    @property
    def remarks(self) -> list[str]:
        """Sentences below the table, one paragraph each."""
        return [*filter(None, (self.meaning, *self.headline.remarks))]


@dataclass(frozen=True)
class Edition:
    """Data of a report other than its result."""

    command: str = ""  # Command that gave the result
    date: datetime.date | None = None  # Date of the report
    spell: Spell = str  # `spell(mention)` returns the spelling of an argument
    processes: int = 1  # Largest number of processes that draw the figures
    tell: Callable[[int, int], None] | None = None  # Called as `tell(number, count)`
    head: Sequence[Cells] = ()  # Project, drawing and author, above a line for the signature


PLAIN = Edition()
"""Edition without a command, with the date of today."""


def check_path(path: str | os.PathLike[str]) -> None:
    """Raise `InputError` unless a report can be written to this path."""
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm"):
        raise input_error("path", str(target), "of a report must end in .html")
    if target.is_dir():
        raise InputError(f"{str(target)!r} is a folder; give the name of a file", argument="path")
    if not target.parent.is_dir():
        raise InputError(
            f"the folder of the report {str(target)!r} does not exist; create it first"
        )


def render(front: Front, chapters: Sequence[Chapter], edition: Edition = PLAIN) -> str:
    """Return a page as the text of an HTML file."""
    pictures = list(_pictures(front, chapters))
    drawings = [picture.draw_figure for picture in pictures]
    data = export.draw_pngs(drawings, edition.processes, edition.tell)
    return _template(edition.spell).render(
        front=front,
        chapters=chapters,
        head=PageTable([*edition.head, ("Signature", "")], style="head") if edition.head else None,
        date=(edition.date or datetime.date.today()).isoformat(),
        version=__version__,
        messages=_messages(front.cautions),
        shown={
            picture: _RenderedPicture(
                number, *_png_size(png), base64.b64encode(png).decode("ascii")
            )
            for number, (picture, png) in enumerate(zip(pictures, data, strict=True), start=1)
        },
    )


class _RenderedPicture(NamedTuple):
    """Drawn figure of a page."""

    number: int
    width: int
    height: int
    source: str


def _png_size(png: bytes) -> tuple[int, int]:
    """Return width and height of a PNG file, from its first chunk."""
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")


def _pictures(front: Front, chapters: Sequence[Chapter]) -> Iterator[Picture]:
    """Yield the figures of a page in order."""
    if front.figure is not None:
        yield front.figure
    for chapter in chapters:
        for kind, content in chapter.blocks:
            if kind in ("figure", "aside"):
                yield content if kind == "figure" else content[0]


def _template(spell: Spell) -> jinja2.Template:
    """Return the page template, with argument names of one interface."""
    # Imported late: only reports need it.
    import jinja2

    environment = jinja2.Environment(
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: _printable(value, spell),
    )
    source = resources.files("roughcontact.report").joinpath("templates", _TEMPLATE)
    return environment.from_string(source.read_text(encoding="utf-8"))


def _messages(cautions: Sequence[Caution]) -> list[tuple[str, str]]:
    """Return severity and sentence of the cautions, the most severe first."""
    return [
        (str(caution.severity), as_sentence(caution.text))
        for severity in Severity
        for caution in cautions
        # The first line of the page reports non-convergence, with the reason.
        if caution.severity is severity and caution.kind != CautionTag.NOT_CONVERGED
    ]


def _printable(value: Any, spell: Spell) -> Any:
    if isinstance(value, Sentence):
        value = render_message(value.parts, spell)
    # A file name can contain undecodable bytes or control characters, which HTML forbids.
    return replace_unprintable(value, "\n\t", "�") if type(value) is str else value


def as_sentence(note: str) -> str:
    """Return a note with a capital letter and a full stop; an empty text stays empty."""
    if not note:
        return ""
    first, *rest = message_parts(note)
    head = first[:1].upper() + first[1:] if isinstance(first, str) else first
    return Sentence(head, *rest, *([] if note.endswith((".", "?")) else ["."]))
