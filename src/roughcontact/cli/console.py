"""Console output: tables, warnings and errors of fixed width."""

from __future__ import annotations

import io
import re
import sys
import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from roughcontact import units
from roughcontact._tools.text import replace_unprintable
from roughcontact.analyses.generate.task import COMMAND as GENERATE
from roughcontact.analyses.solve.task import TASK as SOLVE
from roughcontact.cli import terminal
from roughcontact.cli.terminal import DisplayOptions
from roughcontact.errors import render_message
from roughcontact.request.task import Command
from roughcontact.units import format_engineering

if TYPE_CHECKING:
    from roughcontact.batch.plan import ContactReport
    from roughcontact.cautions import Caution
    from roughcontact.contact.result import ContactResult
    from roughcontact.elastoplastic.archive import CheckedFile
    from roughcontact.errors import InputError
    from roughcontact.formats.source import Channel
    from roughcontact.material.catalog import Entry
    from roughcontact.report.inputs import Measured
    from roughcontact.report.kind import Headline
    from roughcontact.report.page import Block
    from roughcontact.request.outcome import Outcome
    from roughcontact.surface.surface import Surface


Cells = tuple[str, ...]

_WIDTH = 80
_MAX_WIDTH = 100


# Content of the output


def print_outcome(outcome: Outcome, display: DisplayOptions) -> None:
    """Print the outcome of a request."""
    from roughcontact.report.presentation import presentation_of

    result, task = outcome.result, outcome.request.task
    shown = presentation_of(result, **outcome.extra_results, is_drawn=False)
    first = shown.headline()
    _print_headline(first, task)
    if display is DisplayOptions.VERBOSE:
        _print_blocks(shown.tables(), {_lower_first(row) for row in first.rows}, task)
        _print_cautions(result.cautions, task)
    else:
        _print_messages(result.cautions, task)
    _print_written(outcome.written)


def print_outcomes(
    names: Sequence[str], outcomes: Sequence[Outcome | Exception], task: Command
) -> None:
    """Print the answer for each of several files, the range of their areas, and their cautions."""
    from roughcontact.cautions import merge_cautions
    from roughcontact.contact.nominal_hertz import has_nominal_body
    from roughcontact.report.presentation import presentation_of

    rows: list[Cells] = []
    contacts: list[ContactResult] = []
    cautions: list[tuple[str, Iterable[Caution]]] = []
    for name, item in zip(names, outcomes, strict=True):
        if isinstance(item, Exception):
            rows.append((name, "not solved"))
            continue
        rows.append((name, presentation_of(item.result, **item.extra_results).answer()))
        cautions.append((name, item.result.cautions))
        # The elastoplastic result has its contact as its solution.
        contacts.append(getattr(item.result, "solution", item.result))
    _print_table(rows, heads=("file", "result"), fold=True)
    text = f"{len(contacts)} of {units.count_noun(len(rows), 'file')} solved"
    if contacts and not any(has_nominal_body(contact.pair.origins) for contact in contacts):
        shares = [contact.contact_fraction for contact in contacts]
        low, high = (units.format_percent(end(shares)) for end in (min, max))
        ends = low if low == high else units.join_ends(low, high)
        what = "profile" if contacts[0].pair.is_profile else "face"
        text += f"; {ends} of the {what} is in contact"
    _print_lines(f"{text}.")
    print()
    _print_messages(merge_cautions(cautions, "files"), task)


def _print_blocks(blocks: Iterable[Block], known: set[Cells], task: Command) -> None:
    """Print the tables and the text of a report, without known rows."""
    title = ""
    for kind, content in blocks:
        if kind == "head":
            title = content
        elif kind in ("table", "aside"):
            for table in [content] if kind == "table" else content[1]:
                # The console omits the meaning of the quantities.
                width = (
                    -1 if table.head[-1:] == ("meaning",) else 2 if table.style == "key" else None
                )
                heads = () if table.head[:2] == ("quantity", "value") else table.head[:width]
                rows = [row[:width] for row in table.rows if _lower_first(row) not in known]
                if rows:
                    _print_paragraph(title)
                    _print_table(rows, heads=heads)
                title = ""
        elif kind == "text":
            _print_paragraph(terminal.spell_options(content, task))


def _lower_first(row: Cells) -> Cells:
    return tuple(cell.lower() for cell in row)


def _print_paragraph(text: str) -> None:
    if text:
        _print_lines(text)
        print()


def _print_headline(headline: Headline, command: Command = SOLVE) -> None:
    """Print problem, answer, main quantities and remarks."""
    _print_lines(headline.problem)
    print()
    if headline.answer:
        _print_lines(headline.answer, _INDENT)
        print()
    if headline.rows:
        _print_table(headline.rows, heads=headline.heads, indent=_INDENT)
    for line in headline.remarks:
        _print_lines(terminal.spell_options(line, command), _INDENT)
    if headline.remarks:
        print()


# Maximum number of warnings and cautions without --verbose.
_MAX_ROWS = 3


def _print_messages(cautions: Iterable[Caution], command: Command = SOLVE) -> None:
    """Print the first warnings and cautions, and the number of further messages."""
    from roughcontact.cautions import Severity

    listed = list(cautions)
    shown = [c for c in listed if c.severity != Severity.NOTE]
    more, notes = len(shown[_MAX_ROWS:]), len(listed) - len(shown)
    counts = [f"{more} more"] * bool(more) + [units.count_noun(notes, "note")] * bool(notes)
    _print_cautions(shown[:_MAX_ROWS], command, ", ".join(counts))


def _print_lines(text: str, indent: str = "", hang: str = "") -> None:
    """Print wrapped text, without a line break between a number and its unit."""
    joined = _UNIT.sub("\\1\N{NO-BREAK SPACE}\\2", replace_unprintable(text))
    wrapped = textwrap.wrap(
        joined,
        _console_width(),
        initial_indent=indent,
        subsequent_indent=indent + hang,
        break_on_hyphens=False,
    )
    for line in wrapped:
        print(line.replace("\N{NO-BREAK SPACE}", " "))


_UNIT = re.compile(r"(\d) (\S)")
_INDENT = "  "


def show_reports(reports: Sequence[ContactReport], folder: Path) -> None:
    """Print one row for each contact of a project, the cautions and the results folder."""
    from roughcontact.batch.plan import FAILED, spell_key
    from roughcontact.cautions import from_summary, merge_cautions

    def read_caution(summary: Mapping[str, Any]) -> Caution:
        caution = from_summary(summary)
        text = render_message(caution.parts, partial(spell_key, task=SOLVE))
        return replace(caution, parts=(text,))

    states = Counter(report.state for report in reports)
    counts = ", ".join(f"{count} {state}" for state, count in states.items())
    _print_lines(f"{units.count_noun(len(reports), 'contact')}: {counts}")
    print()
    failed_first = sorted(reports, key=lambda report: report.state != FAILED)
    rows = [(item.name, str(item.summary.get("answer", item.state))) for item in failed_first]
    _print_table(rows, heads=("contact", "answer"), fold=True, indent=_INDENT)
    cautions = [
        (report.name, map(read_caution, report.summary.get("cautions", ()))) for report in reports
    ]
    _print_messages(merge_cautions(cautions, "contacts"))
    # The folder has at least the summary of each solved contact.
    if any(report.summary for report in reports):
        _print_written([folder], "written to:")


def print_verified(checked: Sequence[CheckedFile]) -> None:
    """Print stored and recomputed values of results, one row per file."""
    from roughcontact.analyses.solve import fields as contact_fields
    from roughcontact.report.kind import quantity_of

    certificate = quantity_of(contact_fields.CONTACT, "certificate").format_value
    rows: list[Cells] = []
    for item in checked:
        numbers: tuple[str, ...] = ("",) * 5
        if item.verification is not None:
            numbers = (
                format_engineering(item.verification.load, item.verification.load_unit),
                format_engineering(item.verification.found_load, item.verification.load_unit),
                certificate(item.verification.certificate),
                certificate(item.verification.found_certificate),
                "agree" if item.sealed else "none",
            )
        rows.append((item.file, *numbers, "refused" if item.reason else "sound"))
    heads = ("file", "load", "found", "certificate", "found", "checksums", "result")
    _print_table(rows, heads=heads)


def show_catalogue(entries: Sequence[Entry]) -> None:
    """Print the constants of materials, one row each."""
    rows = [
        (
            entry.key,
            ", ".join(entry.names[:2]),
            format_engineering(entry.young.value, "Pa"),
            f"{entry.poisson.value:g}",
            ""
            if entry.yield_strength is None
            else format_engineering(entry.yield_strength.value, "Pa"),
            "" if entry.hardness is None else entry.hardness.text,
        )
        for entry in entries
    ]
    _print_table(rows, heads=("material", "also called", "E", "Poisson", "yield", "hardness"))
    print("`roughcontact materials NAME` gives condition and sources.")


def show_entry(entry: Entry) -> None:
    """Print a material with the source of each value."""
    rows = [("material", entry.key), ("also called", ", ".join(entry.names))]
    rows += [("condition", entry.condition), *([("note", entry.note)] if entry.note else [])]
    listed = (
        ("Young's modulus", entry.young, _with_unit("Pa")),
        ("Poisson's ratio", entry.poisson, "{:g}".format),
        ("yield strength", entry.yield_strength, _with_unit("Pa")),
        ("hardness", entry.hardness, str),
        ("hardening exponent", entry.hardening_exponent, "{:.3g}".format),
        ("resistivity", entry.resistivity, _with_unit("Ω m")),
        ("conductivity", entry.conductivity, "{:g} W/(m K)".format),
        ("softening voltage", entry.softening_voltage, "{:g} V".format),
        ("melting voltage", entry.melting_voltage, "{:g} V".format),
    )
    values = [(name, form(item[0]), item.source) for name, item, form in listed if item is not None]
    _print_table(rows)
    _print_table(values, heads=("", "value", "source"))


def _with_unit(unit: str) -> Callable[[Any], str]:
    return lambda value: format_engineering(value, unit)


def _print_written(written: Iterable[Path], words: str = "written:") -> None:
    # Each path on a separate unwrapped line, so that it can be copied.
    paths = list(written)
    if paths:
        print(words)
        for path in paths:
            print(replace_unprintable(str(path)))
        print()


def show_info(
    result: Sequence[tuple[Measured | InputError, Sequence[Channel]]],
    files: Sequence[str],
    display: DisplayOptions,
) -> None:
    """Print the parameters of the map in a file, or a row for each of several files."""
    from roughcontact.contact.plausibility import map_cautions
    from roughcontact.report import inputs

    measured, channels = result[0]
    items = [None if isinstance(item, Exception) else item for item, _ in result]
    if len(files) > 1 or isinstance(measured, Exception):
        names = [Path(file).name for file in files]
        rows = [inputs.file_row(item, name) for item, name in zip(items, names, strict=True)]
        _print_table(rows, heads=inputs.FILE_HEADS)
        _print_lines(inputs.files_verdict(items))
        return
    file = files[0]
    _print_headline(inputs.headline(measured, Path(file).name))
    if display is DisplayOptions.VERBOSE:
        _print_parameters(measured, channels)
    else:
        print("All parameters and channels: --verbose")
        print()
    _print_messages(map_cautions(measured.leveled))


def _print_parameters(measured: Measured, channels: Sequence[Channel]) -> None:
    """Print all parameters and channels of a file."""
    from roughcontact.report import inputs
    from roughcontact.report.kind import rows_of

    listed: list[Cells] = []
    for index, entry in enumerate(channels):
        name = f"{index}: {entry.name or 'heights'}" + (f" [{entry.unit}]" if entry.unit else "")
        listed.append(
            ("" if listed else "channels", name + ("" if entry.is_height else ", no heights"))
        )
    rows = [(row.title, row.text) for row in rows_of(inputs.file_table(measured), measured)]
    _print_table(rows, listed)
    if measured.surface.is_profile:
        heads = ("after line", "P: all waves", "R: below λc", "")
        _print_table(inputs.profile_parameters(measured.leveled), heads=heads)
    else:
        values = measured.leveled.roughness()
        roughness = [
            (name, inputs.parameter(name, values), meaning)
            for name, (_, meaning) in inputs.ROUGHNESS.items()
        ]
        _print_table(roughness, heads=("after plane", "", ""))


def print_generated(surface: Surface, written: Sequence[Path]) -> None:
    """Print requested and actual parameters of a generated map."""
    from roughcontact.analyses.generate import report as generation

    _print_headline(generation.generation_headline(surface))
    _print_messages(generation.missed_notes(surface), GENERATE)
    _print_written(written)


def show_demo(
    results: Sequence[ContactResult], labels: Sequence[str], folder: Path, files: Sequence[str]
) -> None:
    """Print both solutions of the example, the written files and a next command."""
    from dataclasses import replace

    from roughcontact.analyses.solve import fields as contact_fields
    from roughcontact.report.kind import quantity_of
    from roughcontact.report.presentation import presentation_of

    limited = results[1]
    rows = [
        (quantity.row(limited).title, *(quantity.row(result).text for result in results))
        for quantity in (quantity_of(contact_fields.CONTACT, key) for key in _MAIN_QUANTITIES)
    ]
    first = presentation_of(limited).headline()
    _print_headline(replace(first, heads=("", *labels), rows=rows, remarks=first.remarks[-1:]))
    print(f"written to:\n{replace_unprintable(str(folder))}")
    _print_lines(", ".join(files))
    print('Next: roughcontact solve ground.x3p --load "100 MPa" --material 42CrMo4 \\')
    print("          --boundary periodic")


# Quantities that compare the elastic example with the one with a ceiling.
_MAIN_QUANTITIES = ("contact_area", "mean_pressure", "max_pressure", "mean_gap", "approach")


# Layout and printing


def _print_table(
    *blocks: Sequence[Cells], heads: Cells = (), fold: bool = False, indent: str = ""
) -> None:
    """Print rows under their heads; with ``fold``, the first column may wrap."""
    form = None if indent else box.SIMPLE
    table = Table(
        box=form, show_header=bool(heads), pad_edge=False, show_edge=False, padding=(0, 2, 0, 0)
    )
    names = heads or ("",) * len(next(filter(None, blocks))[0])
    for index, head in enumerate(names):
        table.add_column(head, overflow="fold", no_wrap=index == 0 and not fold)
    for block in blocks:
        if not block:
            continue
        for row in block:
            texts = (replace_unprintable(terminal.spell_options(cell)) for cell in row)
            table.add_row(*map(Text, texts))
        table.add_section()
    _print(table, indent)
    print()


def _print_cautions(cautions: Iterable[Caution], command: Command = SOLVE, more: str = "") -> None:
    """Print cautions, except those on convergence, which the headline reports."""
    from roughcontact.cautions import CautionTag

    shown = [caution for caution in cautions if caution.kind != CautionTag.NOT_CONVERGED]
    for caution in shown:
        text = terminal.spell_options(caution.text, command)
        _print_lines(f"{caution.severity.upper()} {caution.kind}: {text}", hang=_INDENT)
    if more:
        print(f"{more}: --verbose")
    if shown or more:
        print()


def _console_width() -> int:
    """Return the number of columns: of the terminal, or fixed if there is none."""
    return min(Console().width, _MAX_WIDTH) if sys.stdout.isatty() else _WIDTH


def _print(thing: Table | Text, indent: str = "") -> None:
    """Print text laid out by Rich, without trailing blanks and colors."""
    # Not printed by Rich, which exits with status 1, "not converged", if a pipe is closed.
    text = io.StringIO()
    width = _console_width() - len(indent)
    Console(file=text, width=width, color_system=None, highlight=False).print(thing)
    for line in text.getvalue().splitlines():
        print((indent + line).rstrip())
