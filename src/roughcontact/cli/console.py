"""What the command line shows: tables, warnings, complaints; plain text of a fixed width."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from roughcontact.cli import terminal
from roughcontact.request.options import (
    COMPARE,
    ESTIMATE,
    FIND,
    HISTORY,
    INFO,
    ROLL,
    SOLVE,
    STRESS,
    SWEEP,
)
from roughcontact.units import engineering

if TYPE_CHECKING:
    from roughcontact.contact.cautions import Caution
    from roughcontact.contact.compared import Comparison
    from roughcontact.contact.curve import LoadCurve
    from roughcontact.contact.found import FoundLoads
    from roughcontact.contact.history import LoadHistory
    from roughcontact.contact.result import ContactResult
    from roughcontact.contact.sampling import SamplingStudy
    from roughcontact.contact.slab import Share
    from roughcontact.contact.stress import StressResult
    from roughcontact.contact.study import ResolutionStudy
    from roughcontact.fleet.plan import Report
    from roughcontact.formats.source import Channel
    from roughcontact.joint.estimate import Estimate
    from roughcontact.material.catalogue import Entry
    from roughcontact.material.material import Material
    from roughcontact.report.inputs import Measured
    from roughcontact.report.quantities import Row
    from roughcontact.request.joints import Joint
    from roughcontact.request.run import Outcome
    from roughcontact.surface.surface import Surface
    from roughcontact.volume.result import ElastoplasticResult
    from roughcontact.volume.rolling import Rolling
    from roughcontact.volume.verification import Checked

Cells = tuple[str, ...]

_WIDTH = 80
_WIDEST = 100


# What is shown


def show(outcome: Outcome) -> None:
    """Print what a request gave."""
    if outcome.curve is not None:
        show_curve(outcome.curve, outcome.written)
    elif outcome.history is not None:
        show_history(outcome.history, outcome.written)
    elif outcome.rolling is not None:
        show_rolling(outcome.rolling, outcome.written)
    elif outcome.loads is not None:
        show_loads(outcome.loads, outcome.written)
    elif outcome.joint is not None:
        show_joint(outcome.joint, outcome.request.task, outcome.written)
    elif outcome.comparison is not None:
        show_comparison(outcome.comparison, outcome.written)
    elif outcome.volume is not None:
        show_volume(outcome.volume, outcome.written)
    elif outcome.stress is None:
        show_solution(outcome)
    else:
        show_solution(replace(outcome, written=()))
        show_stress(outcome.stress, outcome.first_yield, outcome.written)


def show_solution(outcome: Outcome) -> None:
    """Print problem, answer and trust of a result, then its warnings and files."""
    from roughcontact.report import results, smooth, sureness

    result = outcome.result
    assert result is not None
    heads, answer = results.beside_calibrated(result, brief=True)
    cells = [(_title(row), *texts) for row, texts in answer]
    trust = _trust(result)
    if heads:
        _print_table(_problem(result, result))
        _print_table(cells, heads=("", *heads))
        _print_table(trust)
    else:
        _print_table(_problem(result, result), cells, trust)
    if result.converged and result.load:
        _print_table(sureness.rows(result, outcome.study), heads=sureness.HEADS)
    if smooth.applies(result):
        _print_table(smooth.rows(result), heads=smooth.HEADS)
    _print_cautions(result.cautions, outcome.request.task)
    if outcome.study is not None:
        _print_study(outcome.study)
    _print_written(outcome.written)


def show_curve(curve: LoadCurve, written: Sequence[Path]) -> None:
    """Print a load curve, one row a load, and what the simple laws say."""
    _print_steps(curve)
    _print_cautions(curve.cautions, SWEEP)
    _print_written(written)


def show_loads(loads: FoundLoads, written: Sequence[Path]) -> None:
    """Print the loads that were asked for, one row each."""
    _print_steps(loads)
    _print_cautions(loads.cautions, FIND)
    _print_written(written)


def show_joint(found: Joint, task: str, written: Sequence[Path]) -> None:
    """Print what a joint does, one row a load, and what it means."""
    from roughcontact.report import results

    _print_steps(found)
    for sentence in results.sentences(found):
        _print(Text(sentence))
    _print_cautions(found.cautions, task)
    _print_written(written)


def show_estimate(found: Estimate, written: Sequence[Path]) -> None:
    """Print what formulas were given, and what they say."""
    from roughcontact.report import results
    from roughcontact.report.quantities import PROBLEM

    _print_table(_cells(results.rows(found, PROBLEM, brief=True)))
    _print_table(_cells(results.rows(found, brief=True)))
    _print_cautions(found.cautions, ESTIMATE)
    _print_written(written)


def show_comparison(found: Comparison | SamplingStudy, written: Sequence[Path]) -> None:
    """Print means, differences and shares of the scatter, then the area that maps need."""
    from roughcontact.contact.compared import Comparison
    from roughcontact.report import compared, results
    from roughcontact.report.quantities import PROBLEM

    _print_table(_cells(results.rows(found, PROBLEM, brief=True)))
    studies = found.sampling if isinstance(found, Comparison) else (found,)
    if isinstance(found, Comparison):
        for heads, rows in compared.tables_of(found):
            _print_table(rows, heads=heads)
        _print_lines(compared.left_out(found))
    for study in studies:
        _print_steps(study)
        _print_lines(f"{compared.answer(study)}.")
    _print_cautions(found.cautions, COMPARE)
    _print_written(written)


def show_volume(volume: ElastoplasticResult, written: Sequence[Path]) -> None:
    """Print problem, answer and trust of a contact with plasticity of the volume."""
    _print_table(_problem(volume, volume.solution), *_answers(volume))
    _print_cautions(volume.cautions, SOLVE)
    _print_written(written)


def show_rolling(rolling: Rolling, written: Sequence[Path]) -> None:
    """Print problem, passes and answer, then how exactly the last state is solved."""
    from roughcontact.report import results
    from roughcontact.report.quantities import PROBLEM, TRUST

    state = rolling.result
    asked = _cells(results.rows(rolling, PROBLEM, brief=True))
    _print_table(_problem(state, state.solution), asked)
    _print_steps(rolling)
    _print_table(_cells(results.rows(state, TRUST, brief=True)))
    _print_cautions(rolling.cautions, ROLL)
    _print_written(written)


def show_stress(stress: StressResult, onset: StressResult | None, written: Sequence[Path]) -> None:
    """Print the largest stresses below a contact that was shown, and where it yields."""
    from roughcontact.report import results

    rows = results.rows(stress, brief=True)
    if onset is not None:
        rows += results.first_yield(onset, brief=True)
    _print_table(_cells(rows))
    # Those of the contact stand above, with its numbers.
    own = [caution for caution in stress.cautions if caution not in stress.solution.cautions]
    _print_cautions(own, STRESS)
    _print_written(written)


def show_history(history: LoadHistory, written: Sequence[Path]) -> None:
    """Print the steps of a load history, and what it left behind."""
    _print_steps(history)
    _print_cautions(history.cautions, HISTORY)
    _print_written(written)


def show_reports(reports: Sequence[Report], folder: Path) -> None:
    """Print how the contacts of a project ended, one row each, and where all numbers stand."""
    from roughcontact.report import tables
    from roughcontact.report.quantities import ABSENT, quantity_of

    keys = ("load", "max_pressure", "contact_fraction", "saturated_fraction", "certificate")
    quantities = [quantity_of(tables.CONTACT, key) for key in keys]
    rows: list[Cells] = []
    for report in reports:
        last = report.last
        told = {q.key: q.told(last[q.key]) for q in quantities if q.key in last}
        if told and report.told.get("kind") == "profile":
            told["load"] = engineering(last["load"], "N/m")
        if told and last["ceiling"] is None:
            told["saturated_fraction"] = ABSENT
        rows.append((report.name, report.state, *(told.get(key, "") for key in keys)))
    heads = ("contact", "state", *(quantity.name for quantity in quantities))
    _print_table(rows, heads=heads, fold=True)
    _print_shared(
        (report.name, caution) for report in reports for caution in report.told.get("cautions", ())
    )
    # Where nothing else is written, the numbers of each contact are.
    if any(report.told for report in reports):
        _print_written([folder], "written to:")


def show_verified(checked: Sequence[Checked]) -> None:
    """Print what files state of their results beside what was computed again, one row each."""
    from roughcontact.report import tables
    from roughcontact.report.quantities import quantity_of

    certificate = quantity_of(tables.CONTACT, "certificate").told
    rows: list[Cells] = []
    for one in checked:
        numbers: tuple[str, ...] = ("",) * 5
        if one.found is not None:
            numbers = (
                engineering(one.found.load, one.found.load_unit),
                engineering(one.found.found_load, one.found.load_unit),
                certificate(one.found.certificate),
                certificate(one.found.found_certificate),
                "agree" if one.sealed else "none",
            )
        rows.append((one.file, *numbers, "refused" if one.reason else "sound"))
    heads = ("file", "load", "found", "certificate", "found", "checksums", "result")
    _print_table(rows, heads=heads)


def show_catalogue(entries: Sequence[Entry]) -> None:
    """Print the constants of materials, one row each."""
    rows = [
        (
            entry.key,
            ", ".join(entry.names[:2]),
            engineering(entry.young.value, "Pa"),
            f"{entry.poisson.value:g}",
            "" if entry.yield_strength is None else engineering(entry.yield_strength.value, "Pa"),
            "" if entry.hardness is None else entry.hardness.text,
        )
        for entry in entries
    ]
    _print_table(rows, heads=("material", "also called", "E", "Poisson", "yield", "hardness"))
    print("`roughcontact materials NAME` gives condition and sources.")


def show_entry(entry: Entry) -> None:
    """Print a material with the source of each of its values."""
    rows = [("material", entry.key), ("also called", ", ".join(entry.names))]
    rows.append(("condition", entry.condition))
    if entry.note:
        rows.append(("note", entry.note))
    values: list[Cells] = [
        ("Young's modulus", engineering(entry.young.value, "Pa"), entry.young.source),
        ("Poisson's ratio", f"{entry.poisson.value:g}", entry.poisson.source),
    ]
    if entry.yield_strength is not None:
        strength = entry.yield_strength
        values.append(("yield strength", engineering(strength.value, "Pa"), strength.source))
    if entry.hardness is not None:
        values.append(("hardness", entry.hardness.text, entry.hardness.source))
    if entry.exponent is not None:
        exponent = entry.exponent
        values.append(("hardening exponent", f"{exponent.value:g}", exponent.source))
    if entry.resistivity is not None:
        text = engineering(entry.resistivity.value, "Ω m")
        values.append(("resistivity", text, entry.resistivity.source))
    if entry.conductivity is not None:
        text = f"{entry.conductivity.value:g} W/(m K)"
        values.append(("conductivity", text, entry.conductivity.source))
    _print_table(rows)
    _print_table(values, heads=("", "value", "source"))


def _print_study(study: ResolutionStudy) -> None:
    _print_steps(study)
    for sentence in study.sentences:
        _print(Text(sentence))
    print()


def _print_written(written: Iterable[Path], words: str = "written:") -> None:
    # Each on a line of its own and never wrapped, so that it can be found and copied.
    paths = list(written)
    if paths:
        print(words)
        for path in paths:
            print(terminal.printable(str(path)))
        print()


def show_info(measured: Measured, channels: Sequence[Channel]) -> None:
    """Print what is in a file."""
    from roughcontact.contact.judgment import heights_mistaken
    from roughcontact.report import inputs
    from roughcontact.report.quantities import rows_of

    listed: list[Cells] = []
    for index, entry in enumerate(channels):
        name = f"{index}: {entry.name or 'heights'}" + (f" [{entry.unit}]" if entry.unit else "")
        listed.append(
            ("" if listed else "channels", name + ("" if entry.is_height else ", no heights"))
        )
    _print_table(_cells(rows_of(inputs.file_table(measured), measured)), listed)
    if measured.surface.is_profile:
        heads = ("after line", "all waves", "without λc", "")
        _print_table(inputs.profile_parameters(measured.leveled), heads=heads)
    else:
        values = measured.leveled.roughness()
        roughness = [
            (name, inputs.parameter(name, values), meaning)
            for name, (_, meaning) in inputs.ROUGHNESS.items()
        ]
        _print_table(roughness, heads=("after plane", "", ""))
    mistaken = heights_mistaken(measured.leveled.Sdq)
    _print_cautions([] if mistaken is None else [mistaken], INFO)


def show_generated(surface: Surface, written: Sequence[Path]) -> None:
    """Print what was asked for of a generated map beside what it has, and why where it differs."""
    from roughcontact.report import generated

    _print_table(generated.about(surface))
    _print_table(generated.rows(surface), heads=generated.HEADS)
    _print_told(("note", reason) for reason in generated.unmet(surface))
    _print_written(written)


def show_demo(
    results: Sequence[ContactResult], labels: Sequence[str], folder: Path, files: Sequence[Cells]
) -> None:
    """Print both solutions of the example side by side, and the files."""
    from roughcontact.report import tables
    from roughcontact.report.quantities import ANSWER, TRUST, beside

    _print_table(_problem(results[1], results[1], without=("ceiling",)))
    answers, trust = (
        [(_title(row), *texts) for row, texts in beside(tables.CONTACT, results, part, brief=True)]
        for part in (ANSWER, TRUST)
    )
    _print_table(answers, trust, heads=("", *labels))
    said: dict[tuple[str, str], list[str]] = {}
    for label, result in zip(labels, results, strict=True):
        for caution in result.cautions:
            said.setdefault((caution.severity, caution.text), []).append(label)
    _print_told(
        (severity, f"{' and '.join(who)}: {text}") for (severity, text), who in said.items()
    )
    _print_written([folder], "written to:")
    _print_table(files)
    print("The surface is generated, not measured; `roughcontact solve FILE` takes yours.")


# Rows


def _title(row: Row) -> str:
    return f"{row.name} {row.symbol}".rstrip()


def _cells(rows: Iterable[Row]) -> list[Cells]:
    return [(_title(row), row.text) for row in rows]


def _map(surface: Share) -> list[Cells]:
    from roughcontact.report import inputs
    from roughcontact.report.quantities import rows_of

    steps = surface.provenance.steps or ("none",)
    prepared = [("" if index else "preparation", str(step)) for index, step in enumerate(steps)]
    return [*_cells(rows_of(inputs.table_of(surface), surface, brief=True)), *prepared]


def _body(material: Material) -> str:
    """Return name and constants of a material in one line."""
    from roughcontact.report import inputs
    from roughcontact.report.quantities import rows_of
    from roughcontact.report.wording import is_rigid

    if is_rigid(material):
        return "rigid"
    rows = rows_of(inputs.BODY, material, brief=True)
    told = {row.key: f"{row.name} {row.text}" for row in rows if row.value is not None}
    constants = (told[key] for key in ("young", "poisson", "yield_strength", "hardness")
                 if key in told)  # fmt: skip
    return (f"{material.name}: " if material.name else "") + ", ".join(constants)


def _problem(
    result: ContactResult | ElastoplasticResult,
    contact: ContactResult,
    without: Sequence[str] = (),
) -> list[Cells]:
    from roughcontact.report import results
    from roughcontact.report.quantities import PROBLEM

    cells = [*_map(contact.share), ("body", _body(contact.material))]
    other = _body(contact.counter_material)
    if contact.counter_surface is None:
        cells.append(("counter-body", f"{other}, flat"))
    else:
        cells += [("counter-body", other), *_map(contact.counter_surface)]
    asked = results.rows(result, PROBLEM, brief=True)
    return cells + _cells(row for row in asked if row.key not in without)


def _answers(result: Any) -> tuple[list[Cells], list[Cells]]:
    """Return what came out, and how exactly it is solved."""
    from roughcontact.report import results

    return _cells(results.rows(result, brief=True)), _trust(result)


def _trust(result: Any) -> list[Cells]:
    """Return how exactly a result is solved."""
    from roughcontact.report import results
    from roughcontact.report.quantities import TRUST

    return [
        (title, terminal.spelled(text))
        for title, text in _cells(results.rows(result, TRUST, brief=True))
    ]


def _print_lines(text: str) -> None:
    if text:
        _print(Text(terminal.printable(text)))
        print()


def _print_steps(
    result: LoadCurve
    | LoadHistory
    | Rolling
    | FoundLoads
    | Joint
    | ResolutionStudy
    | SamplingStudy,
) -> None:
    """Print one row a step, and what is told of all steps together."""
    from roughcontact.report import results
    from roughcontact.report.quantities import TRUST

    heads, rows = results.listing(result, brief=True)
    _print_table(rows, heads=heads)
    told = [*results.rows(result, brief=True), *results.rows(result, TRUST, brief=True)]
    if told:
        _print_table(_cells(told))


# Printing


def _print_table(*blocks: Sequence[Cells], heads: Cells = (), fold: bool = False) -> None:
    """Print rows under their heads; ``fold`` where the first column may take several lines."""
    table = Table(box=box.SIMPLE, show_header=bool(heads), pad_edge=False, show_edge=False)
    names = heads or ("",) * len(blocks[0][0])
    for index, head in enumerate(names):
        table.add_column(head, overflow="fold", no_wrap=index == 0 and not fold)
    for block in blocks:
        if not block:
            continue
        for row in block:
            table.add_row(*(Text(terminal.printable(cell)) for cell in row))
        table.add_section()
    _print(table)
    print()


def _print_cautions(cautions: Iterable[Caution], command: str) -> None:
    """Print what has to be known; the status above says already where nothing converged."""
    from roughcontact.contact.cautions import Kind

    told = ((c.severity, c.text) for c in cautions if c.kind != Kind.NOT_CONVERGED)
    _print_told(told, command)


def _print_shared(told: Iterable[tuple[str, Mapping[str, Any]]]) -> None:
    """Print cautions of several results, in the form of their summary: each once, with whose."""
    said: dict[tuple[str, str], list[str]] = {}
    for name, caution in told:
        said.setdefault((caution["severity"], caution["text"]), []).append(name)
    _print_told((severity, f"{', '.join(who)}: {text}") for (severity, text), who in said.items())


def _print_told(told: Iterable[tuple[str, str]], command: str = SOLVE) -> None:
    lines = [
        f"{severity}: {terminal.printable(terminal.spelled(text, command))}"
        for severity, text in told
    ]
    for line in lines:
        _print(Text(line))
    if lines:
        print()


def _print(thing: Table | Text) -> None:
    """Print text laid out by Rich, without its trailing blanks and its colours."""
    # A pipe has no width: the same text for everyone, whatever COLUMNS says.
    width = min(Console().width, _WIDEST) if sys.stdout.isatty() else _WIDTH
    # Printed here, since Rich ends with status 1 where a pipe is closed: "not converged".
    text = io.StringIO()
    Console(file=text, width=width, color_system=None, highlight=False).print(thing)
    for line in text.getvalue().splitlines():
        print(line.rstrip())
