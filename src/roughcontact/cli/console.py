"""What the command line shows: tables, warnings, complaints; plain text of a fixed width."""

from __future__ import annotations

import contextlib
import io
import math
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from roughcontact.request import options

if TYPE_CHECKING:
    from roughcontact.contact.curve import LoadCurve
    from roughcontact.contact.history import LoadHistory
    from roughcontact.contact.result import ContactResult
    from roughcontact.contact.stress import StressResult
    from roughcontact.contact.study import ResolutionStudy
    from roughcontact.fleet.plan import Report
    from roughcontact.formats.source import Channel
    from roughcontact.material.catalogue import Entry
    from roughcontact.material.material import Material
    from roughcontact.request.outputs import Say
    from roughcontact.request.run import Outcome
    from roughcontact.solvers.progress import Step
    from roughcontact.surface.surface import Surface
    from roughcontact.volume.result import ElastoplasticResult

Row = tuple[str, ...]

_WIDTH = 80
_WIDEST = 100


# What is shown


@contextlib.contextmanager
def progress(quiet: bool = False) -> Iterator[Say]:
    """Give a function that shows a line on the terminal while the work goes on."""
    if quiet or not sys.stderr.isatty():
        yield lambda text: None
        return
    with Console(stderr=True, highlight=False).status("") as status:
        yield lambda text: status.update(Text(_printable(text)))


def described(step: Step) -> str:
    """Return what the solver is doing, in one line."""
    ny, nx = step.shape
    return (
        f"solving {ny} × {nx}: {step.convolutions} convolutions, "
        f"certificate {step.certificate:.1e}, target {step.tolerance:.0e}"
    )


def show_solution(outcome: Outcome, ceiling: str) -> None:
    """Print problem, answer and trust of a result, then its warnings and files."""
    from roughcontact.report import assumptions

    result = outcome.result
    _print_table(_problem_rows(result, ceiling), _answer_rows(result), _trust_rows(result))
    # The status above has said already where the result is not converged.
    notes = [note for note in result.warnings if not note.startswith("not converged")]
    caution = assumptions.ceiling_caution(result, result.spots())
    _print_warnings([*notes, *([caution] if caution else [])])
    _print_warnings(outcome.notes, "note")
    if outcome.study is not None:
        _print_study(outcome.study)
    _print_written(outcome.written)


def show_curve(curve: LoadCurve, written: Sequence[Path]) -> None:
    """Print a load curve, one row a load, and what the simple laws say."""
    from roughcontact import units

    heads = ("load", "approach", "contact", "saturated", "mean gap", "stiffness", "spots")
    area = curve.nominal_area
    rows = [
        (
            units.engineering(step.load, "N", 3),
            units.engineering(step.approach, "m", 3),
            _percent(step.contact_area / area, 3),
            _percent(step.saturated_area / area, 3),
            units.engineering(step.mean_gap, "m", 3),
            units.engineering(step.stiffness, "N/m", 3),
            str(step.spots),
        )
        for step in curve.steps
    ]
    _print_table(rows, heads=heads)
    worst = max(step.certificate for step in curve.steps)
    facts: list[Row] = [
        ("rms gradient", f"{curve.rms_gradient:.4g}"),
        ("low-load slope", _slope_in_words(curve)),
        ("certificates", f"{worst:.1e} at most"),
    ]
    _print_table(facts)
    _print_written(written)


def show_volume(volume: ElastoplasticResult, notes: Sequence[str], written: Sequence[Path]) -> None:
    """Print problem, answer and trust of a contact with plasticity of the volume."""
    from roughcontact import units
    from roughcontact.report import assumptions_volume, wording

    contact = volume.contact
    problem = _problem_rows(contact, None)
    law = wording.hardening(contact.material)
    if contact.material.yield_strength is None:
        law = f"of the counter-body: {wording.hardening(contact.counter_material)}"
    problem.append(("plasticity", law))
    area = units.engineering(contact.contact_area, "m²")
    steps = units.counted(len(volume.increments), "increment")
    largest = max((step.load for step in volume.increments), default=0.0)
    after = f" after {units.engineering(largest, 'N')}," if largest > contact.load else ""
    answer: list[Row] = [
        ("load", f"{units.engineering(contact.load, 'N')}{after} in {steps}"),
        ("approach", _length(contact.approach)),
        ("max pressure", _pressure(contact.max_pressure)),
        ("contact area", f"{area} ({_percent(contact.contact_fraction)})"),
        ("plastic strain", f"{_percent(volume.max_plastic_strain)} at most"),
        (
            "plastic volume",
            f"{_volume(volume.plastic_volume)}, {_length(volume.plastic_depth)} deep",
        ),
        ("residual displacement", f"{_length(float(volume.residual_displacement.max()))} at most"),
        ("regime", volume.regime),
    ]
    status = f"NOT CONVERGED: {options.in_options(volume.status)}"
    trust: list[Row] = [
        ("status", "converged" if volume.converged else status),
        ("residual", f"{volume.residual:.1e} (tolerance {volume.tolerance:.0e})"),
        ("certificate", f"{contact.certificate:.1e} of the contact"),
        ("work", f"{units.counted(volume.iterations, 'iteration')}, {volume.seconds:.2f} s"),
    ]
    _print_table(problem, answer, trust)
    told = [note for note in volume.warnings if note != volume.status]
    _print_warnings([*told, *assumptions_volume.cautions(volume)])
    _print_warnings(notes, "note")
    _print_written(written)


def show_stress(stress: StressResult, onset: StressResult | None, written: Sequence[Path]) -> None:
    """Print the largest stresses below a contact, and where it yields."""
    from roughcontact import units

    told = stress.summary()
    depth, y, x = stress.place
    ratio = stress.max_von_mises / stress.contact.max_pressure
    along = [_pressure(told[f"max_orthogonal_shear_along_{axis}"]) for axis in "yx"]
    rows: list[Row] = [
        ("body", stress.body),
        ("von Mises", f"{_pressure(stress.max_von_mises)} ({ratio:.3f} of the largest pressure)"),
        ("at", f"depth {_length(depth)}, y {_length(y)}, x {_length(x)}"),
        ("Tresca", _pressure(told["max_tresca"])),
        ("orthogonal shear", f"{along[0]} for passes along y, {along[1]} along x"),
    ]
    if stress.friction:
        rows.insert(1, ("friction", f"{stress.friction:g}"))
    if stress.yield_factor is not None:
        rows.append(("yield strength", f"{stress.yield_factor:.4g} of the largest stress"))
    if stress.yielded_volume is not None:
        rows.append(("above yield", _volume(stress.yielded_volume)))
    if onset is not None:
        contact = onset.contact
        load, pressure = units.engineering(contact.load, "N"), _pressure(contact.max_pressure)
        rows.append(("first yield", f"at {load}, largest pressure {pressure}"))
    _print_table(rows)
    _print_warnings(note for note in stress.warnings if note not in stress.contact.warnings)
    _print_written(written)


def show_history(history: LoadHistory, written: Sequence[Path]) -> None:
    """Print the steps of a load history, and what it left behind."""
    from roughcontact import units

    last = history.last
    nominal = last.pressure.size * last.pixel_area
    rows = [
        (
            units.engineering(step.load, "N", 3),
            units.engineering(step.approach, "m", 3),
            _percent(step.contact_area / nominal, 3),
            _percent(step.saturated_area / nominal, 3),
            units.engineering(step.max_pressure, "Pa", 3),
            _volume(step.indentation_volume),
            units.engineering(step.dissipated_energy, "J", 3),
        )
        for step in history.steps
    ]
    heads = ("load", "approach", "contact", "saturated", "pressure", "indented", "dissipated")
    _print_table(rows, heads=heads)
    shaken = "yes: the last pass added none" if history.shaken_down else "no"
    facts: list[Row] = [
        ("indentation", f"{_length(float(history.indentation.max()))} at most"),
        ("volume", _volume(history.indentation_volume)),
        ("dissipated", units.engineering(history.dissipated_energy, "J")),
        ("shaken down", shaken),
        ("certificates", f"{max(step.certificate for step in history.steps):.1e} at most"),
    ]
    _print_table(facts)
    _print_written(written)


def show_reports(reports: Sequence[Report]) -> None:
    """Print how the contacts of a project ended, one row each."""
    from roughcontact import units

    rows: list[Row] = []
    for report in reports:
        told = report.told
        if not told:
            rows.append((report.name, report.state, "", "", "", "", ""))
            continue
        rows.append(
            (
                report.name,
                report.state,
                units.engineering(told["load"], "N", 3),
                units.engineering(told["max_pressure"], "Pa", 3),
                _percent(told["contact_fraction"], 3),
                # The volume model has no ceiling.
                "–" if "volume" in told else _percent(told["saturated_fraction"], 3),
                f"{told['certificate']:.0e}",
            )
        )
    heads = ("contact", "state", "load", "max pressure", "contact", "saturated", "certificate")
    _print_table(rows, heads=heads)
    paths = (Path(path) for report in reports for path in report.told.get("written", ()))
    _print_written(dict.fromkeys(path.parent for path in paths), "written to:")


def show_catalogue(entries: Sequence[Entry]) -> None:
    """Print the constants of materials, one row each."""
    rows = [
        (
            entry.key,
            ", ".join(entry.names[:2]),
            _pressure(entry.young.value),
            f"{entry.poisson.value:g}",
            "" if entry.yield_strength is None else _pressure(entry.yield_strength.value),
            "" if entry.hardness is None else entry.hardness.text,
        )
        for entry in entries
    ]
    _print_table(rows, heads=("material", "or", "E", "Poisson", "yield", "hardness"))
    print("`roughcontact materials NAME` gives condition and sources.")


def show_entry(entry: Entry) -> None:
    """Print a material with the source of each of its values."""
    rows = [("material", entry.key), ("or", ", ".join(entry.names))]
    rows += [("condition", entry.condition)] + ([("note", entry.note)] if entry.note else [])
    values: list[Row] = [
        ("Young's modulus", _pressure(entry.young.value), entry.young.source),
        ("Poisson's ratio", f"{entry.poisson.value:g}", entry.poisson.source),
    ]
    if entry.yield_strength is not None:
        strength = entry.yield_strength
        values.append(("yield strength", _pressure(strength.value), strength.source))
    if entry.hardness is not None:
        values.append(("hardness", entry.hardness.text, entry.hardness.source))
    _print_table(rows)
    _print_table(values, heads=("", "value", "source"))


def _slope_in_words(curve: LoadCurve) -> str:
    slope = curve.low_load_slope
    if math.isnan(slope):
        return "not defined: no load is low (5 % of the map) and elastic"
    return f"A = {slope:.3g} W/(E* h'); theory 1.6 (Persson) to 2.5 (Bush, Gibson, Thomas)"


def _print_study(study: ResolutionStudy) -> None:
    rows = [
        (
            name,
            _percent(case.contact_fraction, 3),
            _percent(case.saturated_fraction, 3),
            _pressure(case.max_pressure),
            _pressure(case.mean_pressure),
        )
        for name, case in study.named()
    ]
    _print_table(rows, heads=("study", "contact", "saturated", "max pressure", "mean pressure"))
    for sentence in study.sentences:
        _print(Text(sentence))
    print()


def _print_written(written: Iterable[Path], words: str = "written:") -> None:
    # Each on a line of its own and never wrapped, so that it can be found and copied.
    paths = list(written)
    if paths:
        print(words)
        for path in paths:
            print(_printable(str(path)))
        print()


def show_info(surface: Surface, found: dict[str, Any], channels: Sequence[Channel]) -> None:
    """Print what is in a file."""
    low, high = found["height_min"], found["height_max"]
    rows: list[Row] = [
        *_map_rows(surface),
        ("instrument", found["instrument"] or "not named in the file"),
        ("heights", f"{_length(low)} to {_length(high)}, range {_length(high - low)}"),
        ("Sq", f"{_length(found['Sq'])}, after plane {_length(found['Sq_leveled'])}"),
        ("Sdq", f"{found['Sdq']:.4g}, after plane {found['Sdq_leveled']:.4g}"),
        ("missing points", f"{found['missing']} ({_percent(found['missing_fraction'])})"),
    ]
    listed: list[Row] = []
    for index, entry in enumerate(channels):
        name = f"{index}: {entry.name or 'heights'}" + (f" [{entry.unit}]" if entry.unit else "")
        listed.append(
            ("" if listed else "channels", name + ("" if entry.is_height else ", no heights"))
        )
    _print_table(rows, listed)
    _print_table(_roughness_rows(found["roughness_leveled"]), heads=("after plane", "", ""))


def _roughness_rows(values: dict[str, float]) -> list[Row]:
    from roughcontact.report import chapters

    return [
        (name, chapters.parameter(values[name], unit), meaning)
        for name, (unit, meaning) in chapters.ROUGHNESS.items()
    ]


def show_demo(
    results: Sequence[ContactResult], labels: Sequence[str], folder: Path, files: Sequence[Row]
) -> None:
    """Print both solutions of the example side by side, and the files."""
    _print_table(_problem_rows(results[1], None))
    answers, trust = (
        [
            (left[0], left[1], right[1])
            for left, right in zip(rows(results[0]), rows(results[1]), strict=True)
        ]
        for rows in (_answer_rows, _trust_rows)
    )
    _print_table(answers, trust, heads=("", *labels))
    notes: dict[str, list[str]] = {}
    for label, result in zip(labels, results, strict=True):
        for note in result.warnings:
            notes.setdefault(note, []).append(label)
    _print_warnings(f"{' and '.join(names)}: {note}" for note, names in notes.items())
    _print_written([folder], "written to:")
    _print_table(files)
    print("The surface is generated, not measured; `roughcontact solve FILE` takes yours.")


def _map_rows(surface: Surface) -> list[Row]:
    (ny, nx), (dy, dx), (height, width) = surface.shape, surface.pixel, surface.size
    source = surface.provenance.source or "no name"
    if surface.provenance.channel:
        source += f", channel {surface.provenance.channel}"
    return [
        ("map", source),
        ("grid (y × x)", f"{ny} × {nx} points, pixel {_length(dy)} × {_length(dx)}"),
        ("size (y × x)", f"{_length(height)} × {_length(width)}"),
    ]


def _problem_rows(result: ContactResult, ceiling: str | None) -> list[Row]:
    rows = _map_rows(result.surface)
    rows += _step_rows("preparation", result.surface)
    rows.append(("body", _in_words(result.material)))
    rows.append(("counter-body", _in_words(result.counter_material)))
    if result.counter_surface is None:
        rows[-1] = ("counter-body", f"{rows[-1][1]}, flat")
    else:
        rows += _map_rows(result.counter_surface)[:1]
        rows += _step_rows("preparation", result.counter_surface)
    rows.append(("contact modulus", _pressure(result.contact_modulus)))
    if ceiling is not None:
        rows.append(("ceiling", _ceiling_in_words(result, ceiling)))
    rows.append(("boundary", result.boundary))
    return rows


def _step_rows(name: str, surface: Surface) -> list[Row]:
    steps = surface.provenance.steps or ("none",)
    return [("" if index else name, step) for index, step in enumerate(steps)]


def _ceiling_in_words(result: ContactResult, ceiling: str) -> str:
    from roughcontact.material.material import softer

    given = ceiling.strip()
    body = softer(result.material, result.counter_material)
    if not isinstance(result.ceiling, float):
        known = given == "none"
        return "none: purely elastic" + ("" if known else ", no yield strength is given")
    if given == "auto" and body is not None:
        source = "hardness" if body.yield_strength is None else "3 × yield strength"
        return f"{_pressure(result.ceiling)} ({source})"
    return _pressure(result.ceiling) + (f" ({given})" if "H" in given.upper() else "")


def _answer_rows(result: ContactResult) -> list[Row]:
    from roughcontact import units

    indentation = float(result.residual_indentation.max())
    given = {result.control: " (given)"}
    area = units.engineering(result.contact_area, "m²")
    return [
        ("load", units.engineering(result.load, "N") + given.get("load", "")),
        ("approach", _length(result.approach) + given.get("approach", "")),
        *([("tilt (y, x)", _tilt_in_words(result))] if result.moments is not None else []),
        ("max pressure", _pressure(result.max_pressure)),
        ("contact area", f"{area} ({_percent(result.contact_fraction)})"),
        ("saturated", _percent(result.saturated_fraction)),
        ("mean gap", _length(result.mean_gap)),
        ("residual indentation", f"up to {_length(indentation)}" if indentation else "none"),
        ("regime", result.regime),
    ]


def _tilt_in_words(result: ContactResult) -> str:
    y, x = (1e6 * angle for angle in result.tilt)
    return f"{y:.4g}, {x:.4g} µrad; moments balanced to {result.moment_error:.0e} of load × size"


def _trust_rows(result: ContactResult) -> list[Row]:
    status = (
        "converged" if result.converged else f"NOT CONVERGED: {options.in_options(result.status)}"
    )
    return [
        ("status", status),
        ("certificate", f"{result.certificate:.1e} (tolerance {result.tolerance:.0e})"),
        ("load error", f"{result.load_error:.1e}" if result.load_error else "0"),
        ("work", f"{result.convolutions} convolutions, {result.seconds:.2f} s"),
    ]


def facts(surface: Surface) -> dict[str, Any]:
    """Return what is in a map, in SI units, ready for JSON."""
    import numpy as np

    leveled = surface.leveled()
    about = surface.provenance
    return {
        "source": about.source,
        "instrument": about.instrument,
        "channel": about.channel,
        "shape": list(surface.shape),
        "pixel": list(surface.pixel),
        "size": list(surface.size),
        "height_min": float(np.nanmin(surface.heights)),
        "height_max": float(np.nanmax(surface.heights)),
        "Sq": surface.Sq,
        "Sq_leveled": leveled.Sq,
        "Sdq": surface.Sdq,
        "Sdq_leveled": leveled.Sdq,
        "missing": surface.missing,
        "missing_fraction": surface.missing / surface.heights.size,
        "roughness_leveled": leveled.roughness(),
    }


def _in_words(material: Material) -> str:
    words = "rigid"
    if math.isfinite(material.young):
        words = f"E {_pressure(material.young)}, Poisson {material.poisson:g}"
        if material.name:
            words = f"{material.name}: {words}"
    if material.yield_strength is not None:
        words += f", yield strength {_pressure(material.yield_strength)}"
    if material.hardness is not None:
        words += f", hardness {_pressure(material.hardness)}"
    return words


def _length(value: float) -> str:
    from roughcontact import units

    return units.engineering(value, "m")


def _volume(value: float) -> str:
    # Between two prefixes of a cube lie nine digits.
    return f"{1e18 * value:.3g} µm³"


def _pressure(value: float) -> str:
    from roughcontact import units

    return units.engineering(value, "Pa")


def _percent(fraction: float, digits: int = 4) -> str:
    return f"{100 * fraction:.{digits}g} %"


# Printing


def _print_table(*blocks: Sequence[Row], heads: Row = ()) -> None:
    table = Table(box=box.SIMPLE, show_header=bool(heads), pad_edge=False, show_edge=False)
    names = heads or ("",) * len(blocks[0][0])
    for index, head in enumerate(names):
        table.add_column(head, overflow="fold", no_wrap=index == 0)
    for block in blocks:
        if not block:
            continue
        for row in block:
            table.add_row(*(Text(_printable(cell)) for cell in row))
        table.add_section()
    _print(table)
    print()


def _print_warnings(notes: Iterable[str], kind: str = "warning") -> None:
    lines = [f"{kind}: {_printable(options.in_options(note))}" for note in notes]
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


def complain(sentence: str) -> None:
    """Print one sentence on standard error."""
    with contextlib.suppress(BrokenPipeError):
        print(f"roughcontact: {one_line(sentence)}", file=sys.stderr, flush=True)


def one_line(text: str) -> str:
    """Return text without line breaks and control characters."""
    return " ".join(_printable(text).split())


def _printable(text: str) -> str:
    # A file name can carry the terminal's control sequences.
    return "".join(c if c.isprintable() else " " for c in text)


def discard_output() -> None:
    """Turn standard output away if it takes no more, or it would fail again at the end."""
    try:
        sys.stdout.flush()
        return
    except (OSError, ValueError):
        pass
    with contextlib.suppress(OSError, ValueError, AttributeError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)
