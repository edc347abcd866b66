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
from roughcontact.contact.cautions import Caution, Kind, Severity
from roughcontact.errors import InputError, Sentence, Spell, parts_of, worded
from roughcontact.files import write
from roughcontact.plots import sharing
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
class Addition:
    """A chapter that other results add to a report.

    Parameters
    ----------
    title : str
        Its heading.
    text : tuple of str
        Paragraphs, plain text.
    table : tuple of tuple of str
        Rows of a table, the first of them its head; empty for none.
    figures : tuple of (str, Figure)
        Captions with their figures.
    facts : tuple of tuple of str
        Rows of a table without a head.
    cautions : tuple of Caution
        What the summary tells besides those of the result.
    references : References
        What the list of works tells besides those of the result.
    """

    title: str
    text: tuple[str, ...] = ()
    table: tuple[Cells, ...] = ()
    figures: tuple[tuple[str, Figure], ...] = ()
    facts: tuple[Cells, ...] = ()
    cautions: tuple[Caution, ...] = ()
    references: References = NO_REFERENCES


@dataclass(frozen=True)
class Table:
    """Rows of text, the first cell of each its head.

    Parameters
    ----------
    rows : sequence of tuple of str
        The cells.
    head : tuple of str
        Heads of the columns; empty for none.
    """

    rows: Sequence[Cells]
    head: Cells = ()

    @property
    def style(self) -> str:
        """Many columns stand close; few rows stay on one page."""
        dense = "dense" if len(self.head) > _FEW_COLUMNS else ""
        return f"{dense} {'short' if len(self.rows) <= _FEW_ROWS else ''}".strip()


@dataclass
class Picture:
    """A figure as a page takes it.

    Parameters
    ----------
    caption, alt : str
        What stands below it, and what stands for it where it is not seen.
    source : str
        PNG file in base 64; empty until it is drawn.
    width, height : int
        Size in dots.
    number : int
        Its number on the page, given last.
    draw : callable, optional
        What draws it; None if it is drawn.
    """

    caption: str
    alt: str
    source: str = ""
    width: int = 0
    height: int = 0
    number: int = 0
    draw: Callable[[], Figure] | None = None

    @property
    def wide(self) -> bool:
        """Whether it needs the whole width of a page."""
        return self.width > _WIDE


@dataclass
class Chapter:
    """Heading and blocks in their order.

    Parameters
    ----------
    title : str
        The heading.
    blocks : list of (str, object)
        Kind and content: text, warning, steps, table, figure, terms or code.
    anchor : str
        Where links lead to; like the number, given last.
    number : int
        Its number on the page.
    """

    title: str
    blocks: list[tuple[str, Any]] = field(default_factory=list)
    anchor: str = ""
    number: int = 0

    def add(self, kind: str, content: Any) -> None:
        """Append a block."""
        self.blocks.append((kind, content))


def save(text: str, path: str | os.PathLike[str]) -> None:
    """Write a page to an HTML file; it appears only once it is complete."""
    check_path(path)
    write(path, text)


@dataclass(frozen=True)
class Edition:
    """What a report has besides its result.

    Parameters
    ----------
    command : str
        What was typed to get the result; without it a report gives a script where there is one.
    date : date, optional
        Date of the report; today by default.
    spell : callable
        ``spell(mention)`` returns the words for an argument; those of Python without.
    processes : int
        How many may draw its figures; see `sharing.pngs`.
    """

    command: str = ""
    date: datetime.date | None = None
    spell: Spell = str
    processes: int = 1


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
    """Return a page as the text of an HTML file.

    Parameters
    ----------
    chapters : sequence of Chapter
        What follows the summary; they get their numbers here.
    title, subtitle : str
        What the page is on.
    edition : Edition
        Its date, and how it is drawn and worded.
    status : str
        ``"converged"``, or why the solver stopped.
    key_numbers : sequence of (str, str, str)
        Names, values and remarks of what is asked for first.
    regime, regime_text : str
        How far the bodies are from elastic, in two words and in sentences; where there are no such
        words, the sentences are what the page comes to.
    certificate : str
        How exactly it is solved, in sentences.
    cautions : sequence of Caution
        What a reader of the numbers has to know.
    checked : sequence of str
        What the result was looked at for, in a few words each.

    Returns
    -------
    str
        HTML with its figures inside: no other file, no network and no script is needed.
    """
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
    found = []
    for severity, heading in _HEADINGS.items():
        told = [
            sentence(c.text)
            for c in cautions
            # The box above says so, with the reason.
            if c.severity is severity and c.kind != Kind.NOT_CONVERGED
        ]
        if told:
            found.append((str(severity), heading, told))
    return found


_HEADINGS = {
    Severity.WARNING: "Warnings",
    Severity.CAUTION: "Read with care",
    Severity.NOTE: "To know",
}


def _printable(value: Any, spell: Spell) -> Any:
    if isinstance(value, Sentence):
        value = worded(value.parts, spell)
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
    left = {index: one.draw for index, one in enumerate(pictures) if one.draw is not None}
    for index, data in zip(left, sharing.pngs(list(left.values()), processes), strict=True):
        one = pictures[index]
        # Width and height stand first in a PNG file's first chunk.
        one.width, one.height = (int.from_bytes(data[at : at + 4], "big") for at in (16, 20))
        one.source, one.draw = base64.b64encode(data).decode("ascii"), None


def sentence(note: str) -> str:
    """Return a note with a capital letter and a full stop; nothing for nothing."""
    if not note:
        return ""
    first, *rest = parts_of(note)
    head = first[:1].upper() + first[1:] if isinstance(first, str) else first
    return Sentence(head, *rest, *([] if note.endswith(".") else ["."]))


def joined(*notes: str) -> str:
    """Return texts that are not empty as one, with blanks between; arguments stay mentions."""
    parts = [part for note in notes if note for part in (" ", *parts_of(note))]
    return Sentence(*parts[1:])
