"""The page that a report is: chapters of text, tables and figures in one HTML file.

It needs nothing else and prints to A4.
"""

from __future__ import annotations

import base64
import datetime
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact._version import __version__
from roughcontact.cautions import Caution, Kind, Severity
from roughcontact.errors import InputError, Sentence, Spell, message_parts, render_message
from roughcontact.files import write
from roughcontact.plots import export
from roughcontact.plots.style import DPI
from roughcontact.references import NO_REFERENCES, References

if TYPE_CHECKING:
    import jinja2
    from matplotlib.figure import Figure

_TEMPLATE = "report.html.j2"

_FEW_COLUMNS, _FEW_ROWS = 5, 24


# Dots from which a figure has several panels, and needs the whole width of a page.
_WIDE = 8 * DPI

Cells = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class ExtraChapter:
    """A chapter that other results add to a report."""

    title: str  # Its heading
    text: tuple[str, ...] = ()  # Paragraphs, plain text
    table: tuple[Cells, ...] = ()  # Rows of a table, the first of them its head
    figures: tuple[tuple[str, Figure], ...] = ()  # Captions with their figures
    facts: tuple[Cells, ...] = ()  # Rows of a table without a head
    cautions: tuple[Caution, ...] = ()  # What the summary tells besides those of the result
    references: References = NO_REFERENCES


@dataclass(frozen=True)
class PageTable:
    """Rows of text, the first cell of each its head."""

    rows: Sequence[Cells]  # The cells
    head: Cells = ()  # Heads of the columns

    @property
    def style(self) -> str:
        """Many columns stand close; few rows stay on one page."""
        dense = "dense" if len(self.head) > _FEW_COLUMNS else ""
        return f"{dense} {'short' if len(self.rows) <= _FEW_ROWS else ''}".strip()


@dataclass
class Picture:
    """A figure as a page takes it."""

    caption: str  # Text below the figure
    alt: str  # Text in place of the figure
    source: str = ""  # PNG file in base 64
    width: int = 0  # In dots
    height: int = 0  # In dots
    number: int = 0  # Its number on the page, given last
    draw: Callable[[], Figure] | None = None  # What draws it

    @property
    def wide(self) -> bool:
        """Whether it needs the whole width of a page."""
        return self.width > _WIDE


@dataclass
class Chapter:
    """Heading and blocks in their order."""

    title: str  # The heading
    blocks: list[tuple[str, Any]] = field(default_factory=list)
    anchor: str = ""  # Where links lead to
    number: int = 0  # Its number on the page

    def add(self, kind: str, content: Any) -> None:
        """Append a block."""
        self.blocks.append((kind, content))


def save(text: str, path: str | os.PathLike[str]) -> None:
    """Write a page to an HTML file; it appears only once it is complete."""
    check_path(path)
    write(path, text)


@dataclass(frozen=True)
class Edition:
    """What a report has besides its result."""

    command: str = ""  # What was typed to get the result
    date: datetime.date | None = None  # Date of the report
    spell: Spell = str  # `spell(mention)` returns the words for an argument
    processes: int = 1  # How many may draw its figures


PLAIN = Edition()
"""An edition without a command, of today."""


def check_path(path: str | os.PathLike[str]) -> None:
    """Raise `InputError` unless a report can have this name, before anything is computed."""
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm"):
        raise InputError(
            f"of a report must end in .html, got {str(target)!r}",
            argument="path",
            value=str(target),
        )
    if target.is_dir():
        raise InputError(f"{str(target)!r} is a folder; give the name of a file", argument="path")
    if not target.parent.is_dir():
        raise InputError(
            f"the folder of the report {str(target)!r} does not exist; create it first"
        )


def render(
    chapters: Sequence[Chapter],
    *,
    title: str,
    subtitle: str,
    edition: Edition,
    status: str,
    key_numbers: Sequence[Cells],
    regime: str,
    regime_text: str,
    certificate: str,
    cautions: Sequence[Caution],
    checked: Sequence[str],
) -> str:
    """Return a page as the text of an HTML file."""
    _draw(_number(chapters), edition.processes)
    return _template(edition.spell).render(
        title=title,
        subtitle=subtitle,
        date=(edition.date or datetime.date.today()).isoformat(),
        version=__version__,
        converged=status == "converged",
        status=status,
        key_numbers=key_numbers,
        regime=regime,
        regime_text=regime_text,
        certificate=certificate,
        boxes=_boxes(cautions),
        checked=checked,
        chapters=chapters,
    )


def _template(spell: Spell) -> jinja2.Template:
    """Return what a page is made with, in the words of one edge for arguments."""
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


def _boxes(cautions: Sequence[Caution]) -> list[tuple[str, str, list[str]]]:
    """Return severity, heading and sentences of what has to be known, the severest first."""
    result = []
    for severity, heading in _HEADINGS.items():
        text = [
            sentence(c.text)
            for c in cautions
            # The box above says so, with the reason.
            if c.severity is severity and c.kind != Kind.NOT_CONVERGED
        ]
        if text:
            result.append((str(severity), heading, text))
    return result


_HEADINGS = {
    Severity.WARNING: "Warnings",
    Severity.CAUTION: "Read with care",
    Severity.NOTE: "To know",
}


def _printable(value: Any, spell: Spell) -> Any:
    if isinstance(value, Sentence):
        value = render_message(value.parts, spell)
    # A file name can hold bytes that are no text, or control characters, which HTML forbids.
    if type(value) is not str or value.isprintable():
        return value
    return "".join(c if c.isprintable() or c in "\n\t" else "�" for c in value)


def _number(chapters: Sequence[Chapter]) -> list[Picture]:
    """Give chapters and pictures their numbers, and return the pictures."""
    pictures: list[Picture] = []
    for number, chapter in enumerate(chapters, start=1):
        chapter.number = number
        chapter.anchor = f"chapter-{number}"
        for kind, content in chapter.blocks:
            if kind == "figure":
                pictures.append(content)
                content.number = len(pictures)
    return pictures


def picture(draw: Callable[[], Figure], alt: str, caption: str) -> Picture:
    """Return a figure as a page takes it, to be drawn with all others of the page."""
    return Picture(caption, alt, draw=draw)


def _draw(pictures: Sequence[Picture], processes: int) -> None:
    """Draw what is not drawn yet."""
    remaining = {index: item.draw for index, item in enumerate(pictures) if item.draw is not None}
    for index, data in zip(
        remaining, export.pngs(list(remaining.values()), processes), strict=True
    ):
        item = pictures[index]
        # Width and height stand first in a PNG file's first chunk.
        item.width, item.height = (
            int.from_bytes(data[index : index + 4], "big") for index in (16, 20)
        )
        item.source, item.draw = base64.b64encode(data).decode("ascii"), None


def sentence(note: str) -> str:
    """Return a note with a capital letter and a full stop; nothing for nothing."""
    if not note:
        return ""
    first, *rest = message_parts(note)
    head = first[:1].upper() + first[1:] if isinstance(first, str) else first
    return Sentence(head, *rest, *([] if note.endswith(".") else ["."]))


def joined(*notes: str) -> str:
    """Return texts that are not empty as one, with blanks between; arguments stay mentions."""
    parts = [part for note in notes if note for part in (" ", *message_parts(note))]
    return Sentence(*parts[1:])
