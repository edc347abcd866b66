"""The command line: text with units in, tables or JSON out; the work is the library's."""

from __future__ import annotations

import contextlib
import functools
import io
import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from roughcontact._version import __version__
from roughcontact.errors import InputError, RoughcontactError

if TYPE_CHECKING:
    from roughcontact.formats import Channel
    from roughcontact.material import Material
    from roughcontact.result import ContactResult
    from roughcontact.solver import Step
    from roughcontact.surface import Surface

SOLVED, NOT_CONVERGED, BAD_INPUT = 0, 1, 2
# As a shell reports a program that a signal ended: 128 + SIGINT, 128 + SIGPIPE.
INTERRUPTED, PIPE_CLOSED = 130, 141

Row = tuple[str, ...]
Task = tuple[Path, Callable[[Path], object]]
Say = Callable[[str], None]
Command = TypeVar("Command", bound=Callable[..., None])
Number = TypeVar("Number", int, float)

_WIDTH = 80
_WIDEST = 100

_LEVELS = ("plane", "quadric", "mean", "none")
_HOLES = ("error", "fill", "mask")


class _UnfinishedError(Exception):
    """Ctrl-C, with the files that were complete by then."""

    def __init__(self, written: Sequence[Path]) -> None:
        super().__init__()
        self.written = written


def _reporting(command: Command) -> Command:
    """Return a command that ends every expected failure with one sentence and a status."""

    @functools.wraps(command)
    def reported(*args: Any, **kwargs: Any) -> None:
        try:
            command(*args, **kwargs)
            sys.stdout.flush()
        except RoughcontactError as error:
            _complain(f"error: {_in_options(str(error))}")
            raise typer.Exit(BAD_INPUT) from None
        except MemoryError:
            _complain("error: the memory is used up; --crop the map or try --precision single")
            raise typer.Exit(BAD_INPUT) from None
        except BrokenPipeError:
            _discard_output()
            raise typer.Exit(PIPE_CLOSED) from None
        except OSError as error:
            _complain(f"error: {error.filename or 'standard output'}: {error.strerror or error}")
            _discard_output()
            raise typer.Exit(BAD_INPUT) from None
        except KeyboardInterrupt:
            # Versions of Typer differ in what they make of it; `main` says what happened.
            raise _UnfinishedError(()) from None

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
    except _UnfinishedError as stop:
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
        sentence = _one_line(describe()).rstrip(".")
        sentence = sentence[:1].lower() + sentence[1:]
        _complain(f"error: {sentence}; see {command} --help")
        return BAD_INPUT
    if status == INTERRUPTED:
        names = ", ".join(str(path) for path in written)
        _complain(f"interrupted; {f'only {names}' if names else 'nothing'} was written")
    return status if isinstance(status, int) else SOLVED


_app = typer.Typer(
    name="roughcontact",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": _WIDEST},
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


_MAP, _BODIES, _SOLVER, _OUTPUT = "Map", "Bodies and load", "Solver", "Output"

_File = Annotated[
    Path,
    typer.Argument(
        metavar="FILE",
        help="Measured height map: an instrument's file, or a matrix as .npy, .npz, .csv, .txt, "
        ".asc.",
        show_default=False,
    ),
]


def _option(name: str, metavar: str, text: str, panel: str) -> Any:
    return typer.Option(name, metavar=metavar, help=text, rich_help_panel=panel, show_default=False)


def _flag(name: str, text: str) -> Any:
    return typer.Option(name, help=text, rich_help_panel=_OUTPUT)


_Format = Annotated[
    str | None,
    _option("--format", "NAME", "Format of the file; by default its suffix decides.", _MAP),
]
_Channel = Annotated[
    str | None,
    _option("--channel", "NAME|INDEX", "Height channel; by default the file's own choice.", _MAP),
]
_Unit = Annotated[
    str | None,
    _option("--unit", "UNIT", "Unit of the heights, if the file gives none: um.", _MAP),
]
_Size = Annotated[
    str | None,
    _option(
        "--size", "LENGTHS",
        'Sides (y, x) of the map, if the file gives none: "0.1 mm x 0.2 mm".', _MAP,
    ),
]  # fmt: skip
_Json = Annotated[bool, _flag("--json", "Print JSON in SI units, and nothing else.")]


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
def _solve(
    file: _File,
    load: Annotated[
        str | None,
        _option("--load", "FORCE", 'Normal load, such as "1 N"; this or --approach.', _BODIES),
    ] = None,
    approach: Annotated[
        str | None,
        _option(
            "--approach", "LENGTH",
            'Approach of the bodies from the first touch, such as "1 um".', _BODIES,
        ),
    ] = None,
    young: Annotated[
        str | None,
        _option("--young", "PRESSURE", 'Young\'s modulus, such as "210 GPa"; needed.', _BODIES),
    ] = None,
    poisson: Annotated[
        str | None,
        _option("--poisson", "NUMBER", "Poisson's ratio, such as 0.3; needed.", _BODIES),
    ] = None,
    yield_strength: Annotated[
        str | None,
        _option("--yield-strength", "PRESSURE", 'Yield strength, such as "1 GPa".', _BODIES),
    ] = None,
    counter_young: Annotated[
        str | None,
        _option(
            "--counter-young", "PRESSURE",
            "Young's modulus of the counter-body; it is rigid without.", _BODIES,
        ),
    ] = None,
    counter_poisson: Annotated[
        str | None,
        _option("--counter-poisson", "NUMBER", "Poisson's ratio of the counter-body.", _BODIES),
    ] = None,
    counter_yield_strength: Annotated[
        str | None,
        _option(
            "--counter-yield-strength", "PRESSURE",
            "Yield strength of the counter-body.", _BODIES,
        ),
    ] = None,
    counter_surface: Annotated[
        Path | None,
        _option(
            "--counter-surface", "FILE",
            "Height map of the counter-body on the same grid, laid on point by point; a flat "
            "without.", _BODIES,
        ),
    ] = None,
    ceiling: Annotated[
        str,
        _option(
            "--ceiling", "PRESSURE",
            'Largest pressure, such as "3 GPa"; or auto (default): 3 times the smaller yield '
            "strength; or none: purely elastic.", _BODIES,
        ),
    ] = "auto",
    boundary: Annotated[
        str,
        _option(
            "--boundary", "free|periodic",
            "free (default): the map is all there is; periodic: it repeats.", _BODIES,
        ),
    ] = "free",
    level: Annotated[
        str,
        _option(
            "--level", "|".join(_LEVELS),
            "Least-squares form to subtract; plane by default.", _MAP,
        ),
    ] = "plane",
    holes: Annotated[
        str,
        _option(
            "--holes", "|".join(_HOLES),
            "Missing points: error (default) refuses them, fill interpolates smoothly, mask "
            "lets them never touch.", _MAP,
        ),
    ] = "error",
    crop: Annotated[
        str | None,
        _option(
            "--crop", "ROWS,COLUMNS", "Part of the map to keep, such as 0:256,100:356.", _MAP
        ),
    ] = None,
    format_name: _Format = None,
    channel: _Channel = None,
    unit: _Unit = None,
    size: _Size = None,
    tolerance: Annotated[
        str | None,
        _option(
            "--tolerance", "NUMBER",
            "Certificate to reach; 1e-6 by default, 1e-4 in single precision.", _SOLVER,
        ),
    ] = None,
    max_iterations: Annotated[
        str,
        _option(
            "--max-iterations", "NUMBER", "Most convolutions on any one grid; 500 by default.",
            _SOLVER,
        ),
    ] = "500",
    precision: Annotated[
        str,
        _option(
            "--precision", "double|single", "single halves the memory; double by default.",
            _SOLVER,
        ),
    ] = "double",
    output: Annotated[
        Path | None,
        _option("--output", "FILE.nc", "Write the result to this NetCDF file.", _OUTPUT),
    ] = None,
    figures: Annotated[
        str | None,
        _option(
            "--figures", "FOLDER|PREFIX",
            "Write surface, pressure, contact, gap and histogram as PNG into an existing folder, "
            "or with this start of their names.", _OUTPUT,
        ),
    ] = None,
    as_json: _Json = False,
    quiet: Annotated[
        bool, _flag("--quiet", "Print nothing but errors, and JSON if wanted.")
    ] = False,
) -> None:  # fmt: skip
    from roughcontact import units

    for name, value, known in (
        ("--level", level, _LEVELS),
        ("--holes", holes, _HOLES),
        ("--boundary", boundary, ("free", "periodic")),
        ("--precision", precision, ("double", "single")),
    ):
        if value not in known:
            raise InputError(f"{name} must be one of {', '.join(known)}, got {value!r}")
    if (load is None) == (approach is None):
        raise InputError(
            "give either --load or --approach, and only one of them, such as --load '1 N'"
        )
    force = None if load is None else units.parse(load, "force", "--load")
    depth = None if approach is None else units.parse(approach, "length", "--approach")
    material = _material("", young, poisson, yield_strength)
    counter = _counter_material(counter_young, counter_poisson, counter_yield_strength)
    limit: str | float | None = {"auto": "auto", "none": None}.get(ceiling.strip(), ceiling)
    if isinstance(limit, str) and limit != "auto":
        limit = units.parse(limit, "pressure", "--ceiling")
    target = None if tolerance is None else _number(tolerance, float, "--tolerance")
    most = _number(max_iterations, int, "--max-iterations")
    window = None if crop is None else _window(crop)
    inputs = [path for path in (file, counter_surface) if path is not None]
    result_file = None if output is None else _result_file(output, inputs)
    pictures = {} if figures is None else _figure_files(figures)

    from roughcontact import contact, export, formats

    with _progress(quiet) as say:
        maps = []
        for path in inputs:
            say(f"reading {path.name}")
            surface = formats.read_surface(path, format_name, channel, unit, size)
            maps.append(_prepared(surface, path, window, level, holes))
        result = contact.solve(
            maps[0],
            load=force,
            approach=depth,
            material=material,
            counter_material=counter,
            counter_surface=maps[1] if len(maps) > 1 else None,
            ceiling=limit,
            boundary=boundary,
            tolerance=target,
            max_iterations=most,
            precision=precision,
            on_failure="return",
            progress=lambda step: say(_described(step)),
        )
        written: list[Path] = []
        failure: RoughcontactError | None = None
        if result.converged:
            # Its numbers are shown even where its files cannot be written.
            try:
                written = _write(_tasks(result, result_file, pictures), say)
            except RoughcontactError as error:
                failure = error
    if as_json:
        print(export.to_json({**export.record(result), "written": list(map(str, written))}))
    elif not quiet:
        _show_solution(result, ceiling, written)
    if failure is not None:
        raise failure
    if not result.converged:
        wanted = result_file is not None or bool(pictures)
        _complain(
            f"error: not converged: certificate {result.certificate:.1e}, tolerance "
            f"{result.tolerance:.0e}, load error {result.load_error:.1e}; "
            + _in_options(result.status)
            + ("; no file was written" if wanted else "")
        )
        raise typer.Exit(NOT_CONVERGED)


@_app.command("info", epilog="Example:\n\nroughcontact info ground.opd")
@_reporting
def _info(
    file: _File,
    format_name: _Format = None,
    channel: _Channel = None,
    unit: _Unit = None,
    size: _Size = None,
    as_json: _Json = False,
) -> None:
    """Tell what is in a file: grid, size, heights, roughness, missing points, channels."""
    from roughcontact import export, formats

    surface = formats.read_surface(file, format_name, channel, unit, size)
    channels = formats.channels(file, format_name)
    facts = _facts(surface)
    if as_json:
        listed = [
            {"name": c.name, "unit": c.unit, "is_height": c.is_height, "shape": list(c.shape)}
            for c in channels
        ]
        print(export.to_json({**facts, "channels": listed}))
    else:
        _show_info(surface, facts, channels)


@_app.command("demo", epilog="Example:\n\nroughcontact demo --folder roughcontact-demo")
@_reporting
def _demo(
    folder: Annotated[
        Path,
        _option(
            "--folder", "FOLDER", "Where the files go; roughcontact-demo by default.", _OUTPUT
        ),
    ] = Path("roughcontact-demo"),
    points: Annotated[
        str, _option("--points", "NUMBER", "Points per side; 1024 by default.", _MAP)
    ] = "1024",
) -> None:  # fmt: skip
    """Solve a generated rough surface, elastic and with a ceiling, and write all results.

    Needs no measurement: 0.1 mm × 0.1 mm of rough steel under 1 N.
    """
    side = _number(points, int, "--points")
    if side < 32:
        raise InputError(f"--points must be at least 32, got {side}")
    _check_folder(folder)

    from roughcontact import contact, generate
    from roughcontact.material import Material
    from roughcontact.surface import Provenance, Surface

    steel = Material(young=210e9, poisson=0.3, yield_strength=1e9, name="steel")
    labels = ("elastic", "ceiling 3 GPa")
    results: list[ContactResult] = []
    with _progress() as say:
        say("generating the surface")
        heights, pixel = generate.reference_map(side)
        source = "generated self-affine surface, Hurst exponent 0.8"
        surface = Surface(heights, pixel, Provenance(source=source))
        for label, ceiling in zip(labels, (None, "auto"), strict=True):

            def tell(step: Step, label: str = label) -> None:
                say(f"{label}: {_described(step)}")

            results.append(
                contact.solve(surface, load=1.0, material=steel, ceiling=ceiling, progress=tell)
            )
        folder.mkdir(exist_ok=True)
        described = _demo_files(folder, results, labels)
        _write([(path, write) for path, write, _ in described], say)
    _show_demo(results, labels, folder, [(path.name, text) for path, _, text in described])


# Arguments


def _material(
    prefix: str, young: str | None, poisson: str | None, yield_strength: str | None
) -> Material:
    from roughcontact import units
    from roughcontact.material import Material

    if young is None or poisson is None:
        missing = f"--{prefix}young" if young is None else f"--{prefix}poisson"
        example = "'210 GPa'" if young is None else "0.3"
        raise InputError(f"{missing} is needed, such as {missing} {example}")
    modulus = units.parse(young, "pressure", f"--{prefix}young")
    ratio = _number(poisson, float, f"--{prefix}poisson")
    strength = None
    if yield_strength is not None:
        strength = units.parse(yield_strength, "pressure", f"--{prefix}yield-strength")
    try:
        return Material(modulus, ratio, strength)
    except InputError as error:
        raise InputError(f"--{prefix}{error}") from None


def _counter_material(
    young: str | None, poisson: str | None, yield_strength: str | None
) -> Material:
    from roughcontact import units
    from roughcontact.material import RIGID, Material

    if young is not None or poisson is not None:
        return _material("counter-", young, poisson, yield_strength)
    if yield_strength is None:
        return RIGID
    strength = units.parse(yield_strength, "pressure", "--counter-yield-strength")
    return Material(RIGID.young, RIGID.poisson, strength, RIGID.name)


def _number(text: str, kind: type[Number], name: str) -> Number:
    try:
        return kind(text)
    except ValueError:
        wanted = "a whole number" if kind is int else "a number without a unit"
        raise InputError(f"{name} must be {wanted}, got {text!r}") from None


def _window(text: str) -> tuple[slice, slice]:
    match = re.fullmatch(r"\s*(\d*)\s*:\s*(\d*)\s*,\s*(\d*)\s*:\s*(\d*)\s*", text)
    if match is None:
        raise InputError(
            "--crop needs the first row and the row after the last, and the same of the columns, "
            f"such as 0:256,100:356, got {text!r}"
        )
    ends = [int(digits) if digits else None for digits in match.groups()]
    return slice(ends[0], ends[1]), slice(ends[2], ends[3])


def _prepared(
    surface: Surface, path: Path, window: tuple[slice, slice] | None, level: str, holes: str
) -> Surface:
    if window is not None:
        rows, columns = (
            (part.start or 0, points if part.stop is None else part.stop)
            for part, points in zip(window, surface.shape, strict=True)
        )
        surface = surface.cropped(rows, columns)
    if level != "none":
        surface = surface.leveled(level)
    if surface.missing and holes == "error":
        raise InputError(
            f"{path.name} has {surface.missing} missing points; choose --holes fill (smooth "
            "interpolation) or --holes mask (they never touch), or cut them away with --crop"
        )
    return {"error": surface.masked, "mask": surface.masked, "fill": surface.filled}[holes]()


# Files that are written


def _result_file(path: Path, inputs: Iterable[Path]) -> Path:
    if path.suffix.lower() != ".nc":
        raise InputError(f"--output writes NetCDF: give a name that ends in .nc, got '{path}'")
    _check_place(path, "--output")
    for other in inputs:
        if path.exists() and other.exists() and path.samefile(other):
            raise InputError(f"--output '{path}' is an input file; give another name")
    return path


def _figure_files(start: str) -> dict[str, Path]:
    names = ("surface", "pressure", "contact", "gap", "histogram")
    if Path(start).is_dir():
        paths = {name: Path(start) / f"{name}.png" for name in names}
    elif start.endswith(("/", os.sep)):
        raise InputError(f"--figures: the folder '{start}' does not exist; create it first")
    else:
        paths = {name: Path(f"{start.removesuffix('.png')}-{name}.png") for name in names}
    for path in paths.values():
        _check_place(path, "--figures")
    return paths


def _check_place(path: Path, option: str) -> None:
    folder = path.parent
    if path.is_dir():
        raise InputError(f"{option} '{path}' is a folder; give the name of a file")
    if not folder.is_dir():
        raise InputError(f"{option}: the folder '{folder}' does not exist; create it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{option}: no permission to write into the folder '{folder}'")


def _check_folder(folder: Path) -> None:
    if folder.is_dir():
        _check_place(folder / "elastic.nc", "--folder")
    elif folder.exists():
        raise InputError(f"--folder '{folder}' is a file; give the name of a folder")
    else:
        _check_place(folder, "--folder")


def _tasks(
    result: ContactResult, result_file: Path | None, pictures: dict[str, Path]
) -> list[Task]:
    tasks: list[Task] = [] if result_file is None else [(result_file, result.save)]
    if not pictures:
        return tasks
    from roughcontact import plots

    draw: dict[str, Callable[[], Any]] = {
        "surface": lambda: plots.surface(result.surface),
        "pressure": lambda: plots.pressure(result),
        "contact": lambda: plots.contact(result),
        "gap": lambda: plots.gap(result),
        "histogram": lambda: plots.pressure_histogram([result]),
    }
    return tasks + [(path, _saver(draw[name])) for name, path in pictures.items()]


def _saver(draw: Callable[[], Any]) -> Callable[[Path], object]:
    from roughcontact import plots

    return lambda path: plots.save(draw(), path)


def _demo_files(
    folder: Path, results: Sequence[ContactResult], labels: Sequence[str]
) -> list[tuple[Path, Callable[[Path], object], str]]:
    from roughcontact import plots

    elastic, limited = results
    pair, names = list(results), list(labels)
    return [
        (folder / "elastic.nc", elastic.save, "elastic solution: all maps and what went in"),
        (folder / "ceiling.nc", limited.save, "solution with the ceiling"),
        (
            folder / "surface.png",
            _saver(lambda: plots.surface(limited.surface)),
            "the generated heights",
        ),
        (
            folder / "comparison.png",
            _saver(lambda: plots.comparison(pair, names)),
            "both pressure maps, same colours",
        ),
        (
            folder / "histogram.png",
            _saver(lambda: plots.pressure_histogram(pair, names)),
            "how often each pressure occurs",
        ),
        (
            folder / "overview.png",
            _saver(lambda: plots.overview(limited)),
            "with the ceiling: heights, pressure, contact, histogram",
        ),
    ]


def _write(tasks: Sequence[Task], say: Say) -> list[Path]:
    written: list[Path] = []
    for path, write in tasks:
        say(f"writing {path}")
        try:
            write(path)
        except KeyboardInterrupt:
            raise _UnfinishedError(written) from None
        except OSError as error:
            raise InputError(
                f"{path} cannot be written ({error.strerror or _one_line(str(error))}); "
                "what was there before is unchanged"
            ) from None
        written.append(path)
    return written


# What is shown


@contextlib.contextmanager
def _progress(quiet: bool = False) -> Iterator[Say]:
    """Give a function that shows a line on the terminal while the work goes on."""
    if quiet or not sys.stderr.isatty():
        yield lambda text: None
        return
    with Console(stderr=True, highlight=False).status("") as status:
        yield lambda text: status.update(Text(_printable(text)))


def _described(step: Step) -> str:
    ny, nx = step.shape
    return (
        f"solving {ny} × {nx}: {step.convolutions} convolutions, "
        f"certificate {step.certificate:.1e}, target {step.tolerance:.0e}"
    )


def _show_solution(result: ContactResult, ceiling: str, written: Sequence[Path]) -> None:
    _print_table(_problem_rows(result, ceiling), _answer_rows(result), _trust_rows(result))
    # The status above has said already where the result is not converged.
    _print_warnings(note for note in result.warnings if not note.startswith("not converged"))
    if written:
        _print_table([("written" if path is written[0] else "", str(path)) for path in written])


def _show_info(surface: Surface, facts: dict[str, Any], channels: Sequence[Channel]) -> None:
    low, high = facts["height_min"], facts["height_max"]
    rows: list[Row] = [
        *_map_rows(surface),
        ("instrument", facts["instrument"] or "not named in the file"),
        ("heights", f"{_length(low)} to {_length(high)}, range {_length(high - low)}"),
        ("Sq", f"{_length(facts['Sq'])}, after plane {_length(facts['Sq_leveled'])}"),
        ("Sdq", f"{facts['Sdq']:.4g}, after plane {facts['Sdq_leveled']:.4g}"),
        ("missing points", f"{facts['missing']} ({_percent(facts['missing_fraction'])})"),
    ]
    listed: list[Row] = []
    for index, entry in enumerate(channels):
        name = f"{index}: {entry.name or 'heights'}" + (f" [{entry.unit}]" if entry.unit else "")
        listed.append(
            ("" if listed else "channels", name + ("" if entry.is_height else ", no heights"))
        )
    _print_table(rows, listed)


def _show_demo(
    results: Sequence[ContactResult], labels: Sequence[str], folder: Path, files: Sequence[Row]
) -> None:
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
    _print(Text(f"Written to {_printable(str(folder))}:"))
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
    if not isinstance(result.ceiling, float):
        known = ceiling.strip() == "none"
        return "none: purely elastic" + ("" if known else ", no yield strength is given")
    automatic = ceiling.strip() == "auto"
    return _pressure(result.ceiling) + (" (3 × yield strength)" if automatic else "")


def _answer_rows(result: ContactResult) -> list[Row]:
    from roughcontact import units

    indentation = float(result.residual_indentation.max())
    given = {result.control: " (given)"}
    area = units.engineering(result.contact_area, "m²")
    return [
        ("load", units.engineering(result.load, "N") + given.get("load", "")),
        ("approach", _length(result.approach) + given.get("approach", "")),
        ("max pressure", _pressure(result.max_pressure)),
        ("contact area", f"{area} ({_percent(result.contact_fraction)})"),
        ("saturated", _percent(result.saturated_fraction)),
        ("mean gap", _length(result.mean_gap)),
        ("residual indentation", f"up to {_length(indentation)}" if indentation else "none"),
        ("regime", result.regime),
    ]


def _trust_rows(result: ContactResult) -> list[Row]:
    status = "converged" if result.converged else f"NOT CONVERGED: {_in_options(result.status)}"
    return [
        ("status", status),
        ("certificate", f"{result.certificate:.1e} (tolerance {result.tolerance:.0e})"),
        ("load error", f"{result.load_error:.1e}" if result.load_error else "0"),
        ("work", f"{result.convolutions} convolutions, {result.seconds:.2f} s"),
    ]


def _facts(surface: Surface) -> dict[str, Any]:
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
    }


def _in_words(material: Material) -> str:
    stiffness = "rigid"
    if math.isfinite(material.young):
        stiffness = f"E {_pressure(material.young)}, Poisson {material.poisson:g}"
    if material.yield_strength is None:
        return stiffness
    return f"{stiffness}, yield strength {_pressure(material.yield_strength)}"


def _length(value: float) -> str:
    from roughcontact import units

    return units.engineering(value, "m")


def _pressure(value: float) -> str:
    from roughcontact import units

    return units.engineering(value, "Pa")


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.4g} %"


# Printing


def _print_table(*blocks: Sequence[Row], heads: Row = ()) -> None:
    table = Table(box=box.SIMPLE, show_header=bool(heads), pad_edge=False, show_edge=False)
    names = heads or ("",) * len(blocks[0][0])
    for index, head in enumerate(names):
        table.add_column(head, overflow="fold", no_wrap=index == 0)
    for block in blocks:
        for row in block:
            table.add_row(*(Text(_printable(cell)) for cell in row))
        table.add_section()
    _print(table)
    print()


def _print_warnings(notes: Iterable[str]) -> None:
    lines = [f"warning: {_printable(_in_options(note))}" for note in notes]
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


def _complain(sentence: str) -> None:
    with contextlib.suppress(BrokenPipeError):
        print(f"roughcontact: {_one_line(sentence)}", file=sys.stderr, flush=True)


def _one_line(text: str) -> str:
    return " ".join(_printable(text).split())


def _printable(text: str) -> str:
    # A file name can carry the terminal's control sequences.
    return "".join(c if c.isprintable() else " " for c in text)


def _discard_output() -> None:
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


_ARGUMENT = re.compile(
    r"""\b(format|channel|unit|size|precision)=("[^"]*"|'[^']*')?"""
    r"|^(format|unit|size|load|approach|ceiling|tolerance|boundary|precision)\b(?= |$)"
    r"|\b(max_iterations|counter_surface)\b"
)


def _in_options(message: str) -> str:
    """Return a message of the library in the words of the command line."""

    def option(match: re.Match[str]) -> str:
        keyword, value, leading, underscored = match.groups()
        name = (keyword or leading or underscored).replace("_", "-")
        return f"--{name} {value}" if value else f"--{name}"

    return _ARGUMENT.sub(option, message)
