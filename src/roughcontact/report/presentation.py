"""Presentation of a result in a session, a notebook, on the console and in a report."""

from __future__ import annotations

import base64
import html as markup
import os
import pkgutil
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property, partial, update_wrapper
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact._tools import netcdf
from roughcontact._tools.files import require_suffix, to_json, write_atomically
from roughcontact._version import __version__
from roughcontact.cautions import Severity
from roughcontact.contact import plausibility
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.formats import export
from roughcontact.references import NO_REFERENCES, References
from roughcontact.report import assumptions, chapters, citations, page, phrases, python_script
from roughcontact.report.figures import FRONT, RESULTS, Illustrations, PlotFunctions
from roughcontact.report.kind import (
    ABSENT,
    ANSWER,
    PROBLEM,
    TRUST,
    Cells,
    CellTable,
    Columns,
    Headline,
    Row,
    Table,
    Use,
    csv_text,
    first_and_last,
    listing_of,
    quantity_of,
    rows_of,
    stored_columns,
    stored_only,
    stored_steps,
    stored_values,
)
from roughcontact.report.page import PLAIN, Block, Chapter, Edition, Front
from roughcontact.result import presentation
from roughcontact.units import format_engineering, format_percent

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


def presentation_of(result: Any, **more: Any) -> Presentation:
    """Return the presentation of a result; raise `TypeError` for other objects."""
    for base in type(result).__mro__:
        place = presentation().presentations.get(base.__name__)
        if place is not None:
            return pkgutil.resolve_name(f"roughcontact.{place}")(result, **more)
    raise TypeError(f"there is no kind of results for a {type(result).__name__}")


# Maximum number of rows of steps in a report.
_MAX_ROWS = 24


class Presentation:
    """Presentation of a result in console, report, app and files.

    Each class of results has a subclass; a method that it does not override shows nothing, or what
    follows from the contact of the result. A resolution study and the stress at first yield are
    shown with the result; without ``is_drawn``, as on the console, no figures are.
    """

    table: Table = ()  # Quantities of the result
    columns: Columns = ()  # Quantities of each step
    is_listed = False  # Whether the summary includes the columns
    figures: Illustrations = ()  # Figures of reports and of `--figures`
    plots: PlotFunctions = ()  # Figures of `result.plot`, the default first
    profile_table: Table = ()  # The same for profiles, if others
    profile_columns: Columns = ()
    profile_figures: Illustrations = ()
    profile_plots: PlotFunctions = ()
    contact_name = ""  # Attribute of the result that holds its contact, if any
    contact_state = ""  # State of the contact, if it is not that of the answer
    packed: Sequence[str] = ()  # Packed variables of its NetCDF file, if `save` writes one

    def __init__(
        self, result: Any, study: Any = None, onset: Any = None, is_drawn: bool = True
    ) -> None:
        self.result, self.study, self.onset, self.is_drawn = result, study, onset, is_drawn

    # --- Methods that subclasses override ---

    @cached_property
    def contact(self) -> ContactResult | None:
        """Contact that the result is computed from, if any."""
        return attrgetter(self.contact_name)(self.result) if self.contact_name else None

    @cached_property
    def report_contact(self) -> ContactResult | None:
        """Contact whose inputs and results the report includes, if any."""
        return self.contact

    @property
    def limited(self) -> Any:
        """Contact or result that has the ceiling."""
        return self.result if self.contact is None else self.contact

    @cached_property
    def second(self) -> Presentation | None:
        """Presentation of the same result under the second ceiling, if computed."""
        other = getattr(self.result, "calibrated", None)
        return presentation_of(other) if isinstance(other, type(self.result)) else None

    @property
    def is_profile(self) -> bool:
        """Whether the bodies are profiles."""
        return self.contact is not None and self.contact.pair.is_profile

    @property
    def scene(self) -> Any:
        """Scene of the figures."""
        return self.result

    def question(self) -> str:
        """Return the question that the result answers: the title of a report."""
        return ""

    def problem(self) -> str:
        """Return bodies and load in one line."""
        return "" if self.contact is None else phrases.problem(self.contact)

    def answer(self) -> str:
        """Return the answer in one sentence, with its interval."""
        return ""

    def numbers(self) -> CellTable:
        """Return head and rows of the key quantities: by default some columns of the steps."""
        columns = []
        for column in filter(attrgetter("front"), self.own("columns")):
            form = phrases.format_share if column.form is format_percent else column.form
            label = f"{column.front} [{column.unit}]"
            columns.append(replace(column, label=label, form=form, digits=phrases.DIGITS))
        return listing_of(columns, self.result) if columns else self.listing(brief=True)

    def remarks(self) -> Iterable[str]:
        """Return the sources of the interval, and the accuracy, one line each."""
        return ()

    def meaning(self) -> str:
        """Return the meaning of the result in a sentence or two."""
        contact = self.report_contact
        if contact is None or not contact.load:
            return ""
        under = format_engineering(contact.total_load, contact.pair.load_unit)
        text = phrases.regime(contact, in_layers=bool(getattr(self.result, "faces", ())))
        return text and f"{text} (Under {under}.)"

    def inputs(self) -> list[Block]:
        """Return the blocks on maps, bodies and load."""
        contact, rows = self.report_contact, self.rows(PROBLEM)
        if contact is None:
            return chapters.quantities(rows)
        other = presentation_of(contact)
        rows += [other.row(contact.control), *other.rows(PROBLEM)]
        specified = reversed({row.key: row for row in reversed(rows)}.values())
        return chapters.input_blocks(contact, specified, "ceiling", self.is_drawn)

    def details(self) -> list[Block]:
        """Return further blocks of results."""
        return []

    def contact_blocks(self) -> list[Block]:
        """Return the blocks of a contact in reports on other results."""
        return []

    def uncertainty(self) -> list[Block]:
        """Return the blocks on the intervals of the contact."""
        if self.report_contact is None:
            return []
        return presentation_of(self.report_contact, study=self.study).uncertainty()

    def case(self) -> assumptions.Case | None:
        """Return the case of the assumptions, if the model makes those of a contact."""
        contact = self.report_contact
        return None if contact is None else assumptions.contact_case(contact)

    def method(self) -> Iterable[str]:
        """Return the paragraphs on the method, in addition to those of a contact."""
        return ()

    def sentences(self) -> Iterable[str]:
        """Return the sentences on the model that precede the quantities."""
        return ()

    def checks(self) -> tuple[str, ...]:
        """Return the performed checks."""
        contact = self.report_contact
        return () if contact is None else plausibility.performed_checks(contact)

    def script(self) -> tuple[str, str]:
        """Return a Python script that repeats the result, and what it solves."""
        if self.report_contact is None:
            return "", ""
        is_whole = self.report_contact is self.result
        what = "the same problem" if is_whole else "the contact under the largest load"
        return python_script.script_of_result(self.report_contact), what

    def works(self) -> Iterable[Use]:
        """Return the works cited for the result, without those of its contact."""
        return ()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the steps of the result as a table, or the whole result as JSON or NetCDF."""
        tables = export.TABLES if self.columns else (".json",)
        require_suffix(path, *([".nc"] if self.packed else []), *tables)
        suffix = Path(path).suffix.lower()
        if suffix == ".nc":
            netcdf.write(self.dataset(), path, dict.fromkeys(self.packed, netcdf.PACKED))
            return
        steps = stored_steps(self.own("columns"), self.result)
        if suffix == ".xlsx":
            from roughcontact.formats.spreadsheets import write_workbook

            write_workbook(steps, path)
        else:
            text = csv_text(steps) if suffix == ".csv" else f"{to_json(self.summary())}\n"
            write_atomically(path, text)

    def dataset(self) -> netcdf.Dataset:
        """Return the content of a NetCDF file."""
        raise InputError(f"{type(self.result).__name__} has no NetCDF form: use to_pandas()")

    # --- Quantities ---

    def own(self, name: str) -> Any:
        """Return a table of the class by name; for a profile that of profiles, if there is one."""
        return (self.is_profile and getattr(self, f"profile_{name}")) or getattr(self, name)

    def rows(self, part: str = ANSWER, brief: bool = False) -> list[Row]:
        """Return the rows of the result; see `rows_of`."""
        return rows_of(self.own("table"), self.result, part, brief)

    def row(self, key: str) -> Row:
        """Return the row of one quantity."""
        return quantity_of(self.own("table"), key).row(self.result)

    def listing(self, brief: bool = False) -> tuple[Cells, list[Cells]]:
        """Return the head and the rows of the steps; see `listing_of`."""
        return listing_of(self.own("columns"), self.result, brief)

    def headline(self) -> Headline:
        """Return problem, answer, key quantities and remarks."""
        heads, rows = self.numbers()
        if self.second is not None and not heads:
            heads = ("", *phrases.ceiling_heads(self.limited, self.second.limited))
            texts = {row[0]: row[1] for row in self.second.numbers()[1]}
            rows = [(*row, texts.get(row[0], ABSENT)) for row in rows]
        remarks = list(filter(None, self.remarks()))
        # The last line is the accuracy of the solution.
        if self.contact is not None and (text := phrases.under_other_ceiling(self.contact)):
            state = self.contact_state
            remarks.insert(-1, f"{state}, {text[:1].lower()}{text[1:]}" if state else text)
        return Headline(self.problem(), self.answer(), heads, first_and_last(rows), tuple(remarks))

    def summary(self) -> dict[str, Any]:
        """Return the values of the result by name, in SI units, ready for JSON."""
        numbers = stored_values(self.own("table"), self.result)
        if self.second is not None:
            ceiling = getattr(self.second.limited, "ceiling", None)
            numbers["calibrated"] = {**self.second.summary(), "ceiling": ceiling}
        if self.is_listed:
            numbers |= {**stored_columns(self.own("columns"), self.result), "version": __version__}
        return numbers

    def to_pandas(self) -> pandas.DataFrame:
        """Return the steps of the result as a pandas table, or its quantities as one row."""
        import pandas

        table = [item for item in self.own("table") if item.stored]
        data: Any = [stored_values(table, self.result)]
        if self.columns:
            table = stored_only(self.own("columns"), self.result)
            data = {column.key: column.values(self.result) for column in table}
        frame = pandas.DataFrame(data)
        frame.attrs["units"] = {item.key: item.unit for item in table}
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Return the result as an xarray dataset."""
        return self.dataset().to_xarray()

    def references(self) -> References:
        """Return the works cited for the result, by use."""
        contact = () if self.contact is None else citations.contact_references(self.contact)
        return sum((References((use,)) for use in (*contact, *self.works())), NO_REFERENCES)

    def drawings(self) -> dict[str, Callable[[], Figure]]:
        """Return the functions that draw the figures of files, by name."""
        return {
            item.name: partial(item.draw, self.scene) for item in self.own("figures") if item.name
        }

    # --- Blocks of the report ---

    def steps(self, count: int = _MAX_ROWS) -> list[Block]:
        """Return the block of the steps, at most ``count`` of them, evenly spaced."""
        head, rows = self.listing()
        chosen = chapters.evenly_spaced(rows, count)
        blocks = chapters.table(chosen, head)
        if len(chosen) < len(rows):
            blocks.append(Block("small", f"{len(chosen)} of {len(rows)} steps; files have all."))
        return blocks

    def figure_blocks(self, chapter: str = RESULTS) -> list[Block]:
        """Return the blocks of the figures of a chapter."""
        scene = self.scene if self.is_drawn else None
        return chapters.figure_blocks(self.own("figures"), scene, chapter)

    def results(self) -> list[Block]:
        """Return the blocks of all results."""
        _, rows = self.listing()
        # The first page may show all columns and rows.
        has_front = any(column.front for column in self.own("columns"))
        is_own = has_front or type(self).numbers is not Presentation.numbers
        is_front = not is_own and first_and_last(rows) == rows
        contact = self.report_contact
        shown = contact is not None and contact.load
        return [
            *chapters.quantities(self.rows()),
            *([] if is_front else self.steps()),
            *self.figure_blocks(),
            *self.details(),
            *(presentation_of(contact).contact_blocks() if shown else []),
        ]

    def tables(self) -> list[Block]:
        """Return the content of a report except its figures and method."""
        stated = [*self.inputs(), *self.results(), *self.uncertainty()]
        return [*stated, Block("text", " ".join(self.sentences())), *self.trust_blocks()]

    def trust_blocks(self, checked: Sequence[str] | None = None) -> list[Block]:
        """Return the blocks on the accuracy of the result and the checks performed."""
        checked = self.checks() if checked is None else checked
        rows = [(row.title, row.text) for row in self.rows(TRUST, brief=True)]
        if not rows and self.report_contact is not None and self.report_contact is not self.result:
            return presentation_of(self.report_contact).trust_blocks(checked)
        return [
            *chapters.table(rows, style="key"),
            *([Block("small", f"Checked: {', '.join(checked)}.")] if checked else []),
        ]

    def _assumption_blocks(self) -> list[Block]:
        case = self.case()
        if case is None:
            return []
        explained = Block("small", "The user guide explains each assumption: “Assumptions”.")
        return [explained, *chapters.table(assumptions.assumption_rows(case), assumptions.HEAD)]

    def render(self, edition: Edition = PLAIN) -> str:
        """Return the report as the text of an HTML file."""
        texts = [*self.method(), " ".join(self.sentences())]
        if self.report_contact is not None:
            texts += chapters.certificate(self.report_contact)
        version = getattr(self.result, "version", "")
        cited = [work.text for work in self.references() if work.authors or work.year]
        sections: dict[str, list[Block]] = {
            "Input": self.inputs(),
            "Results": self.results(),
            "Uncertainty": self.uncertainty(),
            "Assumptions": self._assumption_blocks(),
            "Method and certificate": [
                *(Block("text", text) for text in texts if text),
                *self.trust_blocks(),
            ],
            "How to repeat": chapters.script_blocks(version, edition.command, *self.script()),
            "References": [Block("list", cited)],
        }
        chapters_shown = [Chapter(title, blocks) for title, blocks in sections.items() if blocks]
        lead = next(iter(self.figure_blocks(FRONT)), None)
        front = Front(
            self.question(),
            self.headline(),
            self.meaning(),
            lead and lead.content,
            self.result.cautions,
            getattr(self.result, "status", "converged"),
        )
        return page.render(front, chapters_shown, edition)

    def report(self, path: str | os.PathLike[str], edition: Edition = PLAIN) -> None:
        """Write the report to an HTML file."""
        page.check_path(path)
        if not self.question():
            raise InputError(f"there is no report on a {type(self.result).__name__} alone")
        write_atomically(path, self.render(edition))


# Widths of wide and of other figures of a notebook [pixels].
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
