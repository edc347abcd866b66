"""The command line: text with units in, tables or JSON out; the work is the library's."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import inspect
import math
import sys
import typing
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from roughcontact._version import __version__
from roughcontact.cli import console
from roughcontact.errors import InputError, RoughcontactError
from roughcontact.files import to_json
from roughcontact.formats import export, tables
from roughcontact.report import figures as report_figures
from roughcontact.report import inputs, sections
from roughcontact.report.quantities import stored
from roughcontact.request import options, outputs, parsing, run
from roughcontact.request.options import BODIES, MAP, OPTIONS, OUTPUT, SOLVER
from roughcontact.request.request import Request, from_text

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.solvers.progress import Step

SOLVED, NOT_CONVERGED, BAD_INPUT = 0, 1, 2
# As a shell reports a program that a signal ended: 128 + SIGINT, 128 + SIGPIPE.
INTERRUPTED, PIPE_CLOSED = 130, 141

Command = TypeVar("Command", bound=Callable[..., None])


def _reporting(command: Command) -> Command:
    """Return a command that ends every expected failure with one sentence and a status."""

    @functools.wraps(command)
    def reported(*args: Any, **kwargs: Any) -> None:
        try:
            command(*args, **kwargs)
            sys.stdout.flush()
        except RoughcontactError as error:
            console.complain(f"error: {options.in_options(str(error))}")
            raise typer.Exit(BAD_INPUT) from None
        except MemoryError:
            console.complain(
                "error: the memory is used up; --crop the map or try --precision single"
            )
            raise typer.Exit(BAD_INPUT) from None
        except BrokenPipeError:
            console.discard_output()
            raise typer.Exit(PIPE_CLOSED) from None
        except OSError as error:
            console.complain(
                f"error: {error.filename or 'standard output'}: {error.strerror or error}"
            )
            console.discard_output()
            raise typer.Exit(BAD_INPUT) from None
        except KeyboardInterrupt:
            # Versions of Typer differ in what they make of it; `main` says what happened.
            raise outputs.UnfinishedError(()) from None

    return reported  # type: ignore[return-value]


def main(argv: list[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : list of str, optional
        Arguments without the program's name; by default those of the process.

    Returns
    -------
    int
        Exit status: 0 solved, 1 not converged, 2 bad input or usage, 130 interrupted.
    """
    arguments = sys.argv[1:] if argv is None else list(argv)
    for stream in (sys.stdout, sys.stderr):
        # File names need not be text in the encoding of the terminal.
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    written: Sequence[Path] = ()
    try:
        status = _app(arguments or ["--help"], prog_name="roughcontact", standalone_mode=False)
    except SystemExit as stop:
        status = stop.code
    except outputs.UnfinishedError as stop:
        status, written = INTERRUPTED, stop.written
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    except Exception as error:
        # Typer brings its own copy of click or uses the installed one: known by what it can do.
        describe = getattr(error, "format_message", None)
        if describe is None:
            raise
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "roughcontact"
        sentence = console.one_line(describe()).rstrip(".")
        sentence = sentence[:1].lower() + sentence[1:]
        console.complain(f"error: {sentence}; see {command} --help")
        return BAD_INPUT
    if status == INTERRUPTED:
        names = ", ".join(str(path) for path in written)
        console.complain(f"interrupted; {f'only {names}' if names else 'nothing'} was written")
    return status if isinstance(status, int) else SOLVED


_app = typer.Typer(
    name="roughcontact",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog='Example:\n\nroughcontact solve ground.opd --load "1 N" --young "210 GPa" --poisson 0.3',
)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"roughcontact {__version__}")
        raise typer.Exit(SOLVED)


@_app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Contact of measured rough surfaces: pressure, real contact area, yielding and gap.

    Every quantity takes its unit, in quotes: "1 N", "210 GPa", "0.1 mm".
    Exit status: 0 solved, 1 not converged, 2 bad input or usage.
    """


_FILE = typer.Argument(
    metavar="FILE",
    help="Measured height map: an instrument's file, or a matrix as .npy, .npz, .csv, .txt, .asc.",
    show_default=False,
)


def _option(name: str, metavar: str, text: str, panel: str) -> Any:
    return typer.Option(name, metavar=metavar, help=text, rich_help_panel=panel, show_default=False)


def _flag(name: str, text: str) -> Any:
    return typer.Option(name, help=text, rich_help_panel=OUTPUT)


def _words(key: str) -> Any:
    option = OPTIONS[key]
    if option.metavar:
        return _option(f"--{key}", option.metavar, option.help, option.panel)
    return typer.Option(f"--{key}", help=option.help, rich_help_panel=option.panel)


_Json = Annotated[bool, _flag("--json", "Print JSON in SI units, and nothing else.")]
_Quiet = Annotated[bool, _flag("--quiet", "Print nothing but errors, and JSON if wanted.")]


# What only `solve` takes.
_VOLUME = ("model", "increments", "unload", "hardening", "folder")


def _describing(*without: str) -> Callable[[Command], Command]:
    """Give a command ``FILE`` and all options of a job but some; it gets the job itself."""
    keys = [key for key in OPTIONS if key not in without]

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def described(file: Path | None, **words: Any) -> None:
            given = {key: words.pop(key.replace("-", "_")) for key in keys}
            given = {key: value for key, value in given.items() if value}
            command(from_text(file, given, sweeps="load" in without), **words)

        hints = typing.get_type_hints(command, include_extras=True)
        own = list(inspect.signature(command).parameters.values())[1:]
        kind = inspect.Parameter.KEYWORD_ONLY
        positional = inspect.Parameter.POSITIONAL_OR_KEYWORD
        parameters = [inspect.Parameter("file", positional, default=None)]
        annotations: dict[str, Any] = {"file": Annotated[Path | None, _FILE]}
        for key in keys:
            name, option = key.replace("-", "_"), OPTIONS[key]
            value = list[str] if option.many else str if option.metavar else bool
            annotations[name] = Annotated[value | None, _words(key)]
            parameters.append(inspect.Parameter(name, kind, default=None))
        parameters += [parameter.replace(kind=kind) for parameter in own]
        annotations |= {parameter.name: hints[parameter.name] for parameter in own}
        # Typer reads what a command takes from here.
        described.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [p.replace(annotation=annotations[p.name]) for p in parameters]
        )
        described.__annotations__ = annotations
        return described  # type: ignore[return-value]

    return decorate


@_app.command(
    "solve",
    help="""Press a measured map against a flat or another map: pressure, contact, gap.

Give a unit with every quantity, in quotes.

\b
Example:
roughcontact solve ground.opd --load "1 N" --young "210 GPa" --poisson 0.3 \\
    --yield-strength "1 GPa" --holes fill --output out.nc --figures out
""",
)
@_reporting
@_describing()
def _solve(asked: Request, as_json: _Json = False, quiet: _Quiet = False) -> None:
    with console.progress(quiet) as say:
        outcome = run.run(asked, say, lambda step: say(console.described(step)))
    result, volume = outcome.result, outcome.volume
    if as_json:
        told = {**tables.record(volume or result), "resolution_notes": list(outcome.notes)}
        if outcome.study is not None:
            told["study"] = outcome.study.summary()
        print(to_json({**told, "written": [str(path) for path in outcome.written]}))
    elif not quiet and volume is not None:
        console.show_volume(volume, outcome.notes, outcome.written)
    elif not quiet:
        console.show_solution(outcome)
    if outcome.failure is not None:
        raise outcome.failure
    if outcome.status != "converged":
        wanted = asked.output or asked.report or asked.figures
        # The increments of the volume that are told of have settled; the status says which did not.
        reached = (
            f"certificate {result.certificate:.1e}, tolerance {result.tolerance:.0e}, "
            f"load error {result.load_error:.1e}; "
            if volume is None
            else ""
        )
        console.complain(
            f"error: not converged: {reached}{options.in_options(outcome.status)}"
            + ("; no file was written" if wanted else "")
            + (f"; the loads before it are kept in {asked.folder}" if asked.folder else "")
        )
        raise typer.Exit(NOT_CONVERGED)


@_app.command(
    "sweep",
    help="""Solve the contact under one load after the other: area, gap, stiffness, spots.

With --folder every finished step is saved at once, and the same command goes on where it was
interrupted.

\b
Example:
roughcontact sweep ground.opd --from "10 mN" --to "10 N" --steps 13 --young "210 GPa" \\
    --poisson 0.3 --holes fill --folder ground-sweep --output curve.csv
""",
)
@_reporting
@_describing("load", "approach", "load-point", *_VOLUME, "study", "output", "figures")
def _sweep(
    asked: Request,
    first: Annotated[
        str | None,
        _option("--from", "LOAD|APPROACH", 'First load "10 mN" or approach "0.1 um".', BODIES),
    ] = None,
    last: Annotated[
        str | None, _option("--to", "LOAD|APPROACH", "Last load or approach.", BODIES)
    ] = None,
    steps: Annotated[
        str, _option("--steps", "NUMBER", "How many loads; 13 by default.", BODIES)
    ] = "13",
    spacing: Annotated[
        str,
        _option("--spacing", "log|linear", "Equal ratios (default) or differences.", BODIES),
    ] = "log",
    folder: Annotated[
        Path | None,
        _option("--folder", "FOLDER", "Where finished steps are kept, to go on later.", OUTPUT),
    ] = None,
    output: Annotated[
        Path | None, _option("--output", "FILE.csv|json", "Write the curve as a table.", OUTPUT)
    ] = None,
    figure: Annotated[
        Path | None, _option("--figure", "FILE", "Draw the curve as PNG, SVG or PDF.", OUTPUT)
    ] = None,
    as_json: _Json = False,
    quiet: _Quiet = False,
) -> None:
    from roughcontact.contact import load_curve
    from roughcontact.plots import curves

    if first is None or last is None:
        missing = "--from" if first is None else "--to"
        raise InputError(f"{missing} is needed: a load such as '1 N' or an approach such as '1 um'")
    control, low = parsing.load_or_approach(first, "--from")
    other, high = parsing.load_or_approach(last, "--to")
    if control != other:
        raise InputError(
            f"--from and --to must both be loads or both approaches, got {first!r} and {last!r}"
        )
    number = OPTIONS["max-iterations"].parse(steps, "--steps")
    values = load_curve.spaced(low, high, number, spacing)
    for path, option in ((output, "--output"), (figure, "--figure"), (asked.report, "--report")):
        if path is not None:
            outputs.check_place(path, option)
    if output is not None and output.suffix.lower() not in (".csv", ".json"):
        raise InputError(f"--output must end in .csv or .json, got '{output}'")
    with console.progress(quiet) as say:
        maps = asked.surfaces(say)
        curve = load_curve.load_curve(
            maps[0],
            **asked.problem(maps),
            loads=values if control == "load" else None,
            approaches=values if control == "approach" else None,
            max_iterations=asked.max_iterations,
            folder=folder,
            progress=lambda n, step: say(f"{n} of {number}: {console.described(step)}"),
        )
        tasks: list[outputs.Task] = [] if output is None else [(output, curve.save)]
        if figure is not None:
            tasks.append((figure, outputs.saver(lambda: curves.load_curve(curve))))
        if asked.report is not None:
            tasks.append((asked.report, run.curve_report(asked, maps, curve)))
        written = outputs.write(tasks, say)
    if as_json:
        print(to_json({**curve.summary(), "written": [str(path) for path in written]}))
    elif not quiet:
        console.show_curve(curve, written)


@_app.command(
    "stress",
    help="""Solve the contact, and compute the elastic stress below it: where it yields first.

\b
Example:
roughcontact stress ground.opd --load "1 N" --material 100Cr6 --holes fill \\
    --output stress.nc --figures out
""",
)
@_reporting
@_describing(*_VOLUME, "study", "output", "figures")
def _stress(
    asked: Request,
    depths: Annotated[
        str | None,
        _option(
            "--depths", "LENGTHS", 'Depths "1 um, 2 um"; chosen by the contact without.', SOLVER
        ),
    ] = None,
    which: Annotated[
        str, _option("--which", "first|second", "Body to look into; first by default.", BODIES)
    ] = "first",
    friction: Annotated[
        str, _option("--friction", "NUMBER", "Coefficient of friction; 0 by default.", BODIES)
    ] = "0",
    direction: Annotated[
        str,
        _option(
            "--direction", "DEGREES",
            "Direction of the traction on the first body, from x towards y.", BODIES,
        ),
    ] = "0",
    onset: Annotated[
        bool,
        typer.Option(
            "--onset", help="Find the load at which the first point yields.",
            rich_help_panel=SOLVER,
        ),
    ] = False,
    output: Annotated[
        Path | None, _option("--output", "FILE.nc", "Write contact and stress as NetCDF.", OUTPUT)
    ] = None,
    figures: Annotated[
        str | None,
        _option(
            "--figures", "FOLDER|PREFIX",
            "Write depth profile, section and map of the stress as PNG, SVG or PDF.", OUTPUT,
        ),
    ] = None,
    as_json: _Json = False,
    quiet: _Quiet = False,
) -> None:  # fmt: skip
    from roughcontact.contact import subsurface

    listed = (
        None
        if depths is None
        else [OPTIONS["s-filter"].parse(word.strip(), "--depths") for word in depths.split(",")]
    )
    pull = OPTIONS["poisson"].parse(friction, "--friction")
    angle = OPTIONS["angle"].parse(direction, "--direction")
    if which not in ("first", "second"):
        raise InputError(f"--which must be first or second, got {which!r}")
    pictures = outputs.figure_files(figures, report_figures.names(report_figures.STRESS))
    for path in pictures.values():
        outputs.check_place(path, "--figures")
    if output is not None:
        if output.suffix.lower() != ".nc":
            raise InputError(f"--output must end in .nc, got '{output}'")
        outputs.check_place(output, "--output")
    report, asked = asked.report, dataclasses.replace(asked, report=None)
    if report is not None:
        outputs.check_place(report, "--report")
    with console.progress(quiet) as say:
        outcome = run.run(asked, say, lambda step: say(console.described(step)))
        if not outcome.result.converged:
            console.complain(f"error: not converged: {options.in_options(outcome.result.status)}")
            raise typer.Exit(NOT_CONVERGED)
        say("stress below the surface")
        found = subsurface.subsurface_stress(
            outcome.result, listed, body=which, friction=pull, direction=math.radians(angle)
        )
        first = None
        if onset:
            say("searching the load of first yield")
            first = run.first_yield(found)
        tasks: list[outputs.Task] = [] if output is None else [(output, found.save)]
        drawings = report_figures.drawings(found)
        tasks += [(path, outputs.saver(drawings[name])) for name, path in pictures.items()]
        if report is not None:
            chapters = [
                *sections.sections(None, outcome.notes),
                sections.stress_section(found, first),
            ]
            command = asked.command("stress")
            tasks.append((report, lambda path: found.contact.report(path, command, chapters)))
        written = outputs.write(tasks, say)
    if as_json:
        told = {**tables.record(found.contact), "stress": found.summary()}
        if first is not None:
            told["first_yield"] = first.summary()
        print(to_json({**told, "written": [str(path) for path in written]}))
    elif not quiet:
        console.show_solution(outcome)
        console.show_stress(found, first, written)


@_app.command(
    "history",
    help="""Follow a path of loads: indentation that stays, unloading, repeated passes.

The ceiling acts as perfect plasticity of the surface: what it indents stays indented.

\b
Example:
roughcontact history ground.opd --path "1 N, 0 N, 1 N" --material 100Cr6 --holes fill \\
    --output history.csv --residual indented.x3p
""",
)
@_reporting
@_describing("load", "approach", "load-point", *_VOLUME, "precision", "study", "output", "figures")
def _history(
    asked: Request,
    path: Annotated[
        str | None,
        _option("--path", "LOADS", 'Loads or approaches in their order: "1 N, 0 N, 1 N".', BODIES),
    ] = None,
    passes: Annotated[
        str, _option("--passes", "NUMBER", "How often the path is followed; once without.", BODIES)
    ] = "1",
    shift: Annotated[
        str | None,
        _option(
            "--shift", "LENGTHS",
            'Shift (y, x) of the counter-body from pass to pass: "0 um, 5 um".', BODIES,
        ),
    ] = None,
    output: Annotated[
        Path | None, _option("--output", "FILE.csv|json", "Write the steps as a table.", OUTPUT)
    ] = None,
    residual: Annotated[
        Path | None,
        _option(
            "--residual", "FILE",
            f"Write the indented surface: {', '.join(export.suffixes(export.Kind.SURFACE))}.",
            OUTPUT,
        ),
    ] = None,
    figure: Annotated[
        Path | None, _option("--figure", "FILE", "Draw the loop as PNG, SVG or PDF.", OUTPUT)
    ] = None,
    as_json: _Json = False,
    quiet: _Quiet = False,
) -> None:  # fmt: skip
    from roughcontact.contact.history import Stage
    from roughcontact.contact.load_history import load_history
    from roughcontact.plots import curves

    if path is None:
        raise InputError("--path is needed: loads in their order, such as '1 N, 0 N, 1 N'")
    points = [parsing.stage(word, "--path") for word in path.split(",")]
    count = OPTIONS["max-iterations"].parse(passes, "--passes")
    if count < 1:
        raise InputError(f"--passes must be at least 1, got {count}")
    move = (0.0, 0.0) if shift is None else OPTIONS["offset"].parse(shift, "--shift")
    stages = [
        Stage(**{control: value}, shift=(number * move[0], number * move[1]))
        for number in range(count)
        for control, value in points
    ]
    for place, option in (
        (output, "--output"), (residual, "--residual"), (figure, "--figure"),
        (asked.report, "--report"),
    ):  # fmt: skip
        if place is not None:
            outputs.check_place(place, option)
    if output is not None and output.suffix.lower() not in (".csv", ".json"):
        raise InputError(f"--output must end in .csv or .json, got '{output}'")
    if residual is not None and residual.suffix.lower() not in export.suffixes(export.Kind.SURFACE):
        known = ", ".join(export.suffixes(export.Kind.SURFACE))
        raise InputError(f"--residual must end in one of {known}, got '{residual}'")
    with console.progress(quiet) as say:
        maps = asked.surfaces(say)
        problem = asked.problem(maps)
        del problem["precision"]
        if problem["tolerance"] is None:
            del problem["tolerance"]
        found = load_history(
            maps[0],
            stages,
            **problem,
            max_iterations=asked.max_iterations,
            progress=lambda n, step: say(f"{n} of {len(stages)}: {console.described(step)}"),
        )
        tasks: list[outputs.Task] = [] if output is None else [(output, found.save)]
        if residual is not None:
            tasks.append((residual, found.residual.save))
        if figure is not None:
            tasks.append((figure, outputs.saver(lambda: curves.hysteresis(found))))
        if asked.report is not None:
            chapters = [
                *sections.sections(None, asked.resolution_notes(maps)),
                sections.history_section(found),
            ]
            command = asked.command("history")
            tasks.append((asked.report, lambda place: found.last.report(place, command, chapters)))
        written = outputs.write(tasks, say)
    if as_json:
        print(to_json({**found.summary(), "written": [str(place) for place in written]}))
    elif not quiet:
        console.show_history(found, written)


@_app.command("run", epilog="Example:\n\nroughcontact run project.toml")
@_reporting
def _run(
    file: Annotated[
        Path,
        typer.Argument(metavar="PROJECT", help="Project file (TOML).", show_default=False),
    ],
    as_json: _Json = False,
    quiet: _Quiet = False,
) -> None:
    """Work through the contacts of a project file on all cores.

    One that fails does not stop the others. The same command goes on where it was interrupted:
    what was solved before from the same options and files is kept.
    """
    from roughcontact.fleet import engines, plan, project

    entries = project.load(file)
    names: list[str] = []

    def told(report: plan.Report) -> None:
        names.append(report.name)
        say(f"{len(names)} of {len(entries)} done, {report.name} {report.state}")

    try:
        with console.progress(quiet) as say:
            say(f"working through {len(entries)} contacts")
            reports = engines.run(entries, told)
    except KeyboardInterrupt:
        raise outputs.UnfinishedError(plan.finished(entries)) from None
    if as_json:
        print(to_json({"contacts": [dataclasses.asdict(report) for report in reports]}))
    elif not quiet:
        console.show_reports(reports)
    failed = [report for report in reports if report.state == plan.FAILED]
    for report in failed:
        console.complain(f"error: {report.name}: {options.in_options(report.reason)}")
    if failed:
        raise typer.Exit(NOT_CONVERGED)


@_app.command("info", epilog="Example:\n\nroughcontact info ground.opd")
@_reporting
def _info(
    file: Annotated[Path, _FILE],
    format_name: Annotated[str | None, _words("format")] = None,
    channel: Annotated[str | None, _words("channel")] = None,
    unit: Annotated[str | None, _words("unit")] = None,
    size: Annotated[str | None, _words("size")] = None,
    as_json: _Json = False,
) -> None:
    """Tell what is in a file: grid, size, heights, roughness, missing points, channels."""
    from roughcontact.formats import read

    surface = read.read_surface(file, format_name, channel, unit, size)
    channels = read.channels(file, format_name)
    measured = inputs.measured(surface)
    if as_json:
        listed = [
            {"name": c.name, "unit": c.unit, "is_height": c.is_height, "shape": list(c.shape)}
            for c in channels
        ]
        print(to_json({**stored(inputs.FILE, measured), "channels": listed}))
    else:
        console.show_info(measured, channels)


@_app.command("materials", epilog="Example:\n\nroughcontact materials 'bearing steel'")
@_reporting
def _materials(
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="Show one, with its sources.", show_default=False),
    ] = None,
    as_json: _Json = False,
) -> None:
    """List the catalogue of materials, or one of them with the source of every value."""
    from roughcontact.material import catalogue

    found = catalogue.entries() if name is None else (catalogue.entry(name),)
    if as_json:
        print(to_json({"materials": [dataclasses.asdict(entry) for entry in found]}))
    elif name is None:
        console.show_catalogue(found)
    else:
        console.show_entry(found[0])


@_app.command("demo", epilog="Example:\n\nroughcontact demo --folder roughcontact-demo")
@_reporting
def _demo(
    folder: Annotated[
        Path,
        _option(
            "--folder", "FOLDER", "Where the files go; roughcontact-demo by default.", OUTPUT
        ),
    ] = Path("roughcontact-demo"),
    points: Annotated[
        str, _option("--points", "NUMBER", "Points per side; 1024 by default.", MAP)
    ] = "1024",
) -> None:  # fmt: skip
    """Solve a generated rough surface, elastic and with a ceiling, and write all results.

    Needs no measurement: 0.1 mm × 0.1 mm of rough steel under 1 N.
    """
    side = OPTIONS["max-iterations"].parse(points, "--points")
    if side < 32:
        raise InputError(f"--points must be at least 32, got {side}")
    _check_folder(folder)

    from roughcontact.contact import solve
    from roughcontact.material.material import Material
    from roughcontact.surface import synthetic
    from roughcontact.surface.provenance import Operation, Provenance
    from roughcontact.surface.surface import Surface

    steel = Material(young=210e9, poisson=0.3, yield_strength=1e9, name="steel")
    labels = ("elastic", "ceiling 3 GPa")
    results: list[ContactResult] = []
    with console.progress() as say:
        say("generating the surface")
        heights, pixel = synthetic.reference_map(side)
        source = "generated self-affine surface, Hurst exponent 0.8"
        made = Operation("reference_map", {"n": side})
        surface = Surface(heights, pixel, Provenance(source, origin=made))
        for label, ceiling in zip(labels, (None, "auto"), strict=True):

            def tell(step: Step, label: str = label) -> None:
                say(f"{label}: {console.described(step)}")

            results.append(
                solve.solve(surface, load=1.0, material=steel, ceiling=ceiling, progress=tell)
            )
        folder.mkdir(exist_ok=True)
        described = _demo_files(folder, results, labels)
        outputs.write([(path, write) for path, write, _ in described], say)
    console.show_demo(results, labels, folder, [(path.name, text) for path, _, text in described])


def _check_folder(folder: Path) -> None:
    if folder.is_dir():
        outputs.check_place(folder / "elastic.nc", "--folder")
    elif folder.exists():
        raise InputError(f"--folder '{folder}' is a file; give the name of a folder")
    else:
        outputs.check_place(folder, "--folder")


def _demo_files(
    folder: Path, results: Sequence[ContactResult], labels: Sequence[str]
) -> list[tuple[Path, Callable[[Path], object], str]]:
    from roughcontact.plots import maps, profiles

    elastic, limited = results
    pair, names = list(results), list(labels)
    return [
        (folder / "elastic.nc", elastic.save, "elastic solution: all maps and what went in"),
        (folder / "ceiling.nc", limited.save, "solution with the ceiling"),
        (
            folder / "surface.png",
            outputs.saver(lambda: maps.surface(limited.surface)),
            "the generated heights",
        ),
        (
            folder / "comparison.png",
            outputs.saver(lambda: maps.comparison(pair, names)),
            "both pressure maps, same colours",
        ),
        (
            folder / "histogram.png",
            outputs.saver(lambda: profiles.pressure_histogram(pair, names)),
            "how often each pressure occurs",
        ),
        (
            folder / "overview.png",
            outputs.saver(lambda: maps.overview(limited)),
            "with the ceiling: heights, pressure, contact, histogram",
        ),
    ]
