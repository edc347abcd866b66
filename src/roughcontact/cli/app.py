"""Commands: parse options with units, call the library, print tables or JSON."""

from __future__ import annotations

import dataclasses
import functools
import importlib.util
import itertools
import logging
import os
import shlex
import sys
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.exceptions import Exit
from click.shell_completion import shell_complete

from roughcontact import units
from roughcontact._tools.files import to_json
from roughcontact._tools.processes import redeliver_interrupts, reject_mpi_run
from roughcontact._tools.text import join_words
from roughcontact._version import __version__
from roughcontact.analyses import tasks
from roughcontact.analyses.generate import task as making
from roughcontact.analyses.tasks import DEMO, FOLDER, INFO, MATERIALS, POINTS, TASKS, VERIFY
from roughcontact.cli import terminal
from roughcontact.cli.help_format import (
    CommandGroup,
    HelpCommand,
    Subject,
    complete_materials,
    eager_option,
)
from roughcontact.cli.terminal import BAD_INPUT, NOT_CONVERGED, SOLVED, DisplayOptions
from roughcontact.errors import (
    ArgumentRef,
    ConvergenceError,
    InputError,
    RoughcontactError,
    Sentence,
    shorten_value,
)
from roughcontact.request import options
from roughcontact.request.options import JSON, NO_DATA, QUIET, READING, REMOVED, VERBOSE, Panel
from roughcontact.request.outputs import UnfinishedError
from roughcontact.request.task import Command, OptionValues, Task, unknown_name

if TYPE_CHECKING:
    from roughcontact.batch.plan import ContactReport
    from roughcontact.cli.terminal import ProgressLine
    from roughcontact.desk.server import Page
    from roughcontact.formats.source import Channel
    from roughcontact.report.inputs import Measured
    from roughcontact.request.outcome import Outcome


# Environment variable of the completion in shells.
_COMPLETE = "_ROUGHCONTACT_COMPLETE"
# Exit status after a signal, as in a shell: 128 + SIGINT, 128 + SIGPIPE.
SIGNALED, INTERRUPTED, PIPE_CLOSED = 128, 130, 141

_NO_MEMORY = Sentence(
    f"the memory is exhausted; {ArgumentRef('crop')} the map or try "
    f"{ArgumentRef('precision', 'single')}"
)

Given = dict[str, Any]
# Function of a command: its argument is a file, a name, several files or nothing.
Act = Callable[[Any, Given], None]


def main(argv: list[str] | None = None) -> int:
    """Run the command line, and return the exit status."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    terminal.open_streams()
    # Libraries log warnings for damaged files; one error message replaces them.
    logging.basicConfig(handlers=[logging.NullHandler()])
    with redeliver_interrupts(), terminal.handle_stop_signals() as stopped:
        return _exit_status(arguments, stopped)


def _exit_status(arguments: list[str], stopped: list[int]) -> int:
    """Execute a command, and return its exit status; ``stopped`` lists received signals."""
    status, unfinished = SOLVED, UnfinishedError(())
    try:
        arguments = arguments or ["--help"]
        if (sentence := _expanded_option(arguments) or _moved_option(arguments)) is not None:
            terminal.print_error(f"error: {sentence}")
            return BAD_INPUT
        program = _build_program(arguments[0] if arguments[0] in _COMMAND_FUNCTIONS else None)
        if instruction := os.environ.get(_COMPLETE):
            return shell_complete(program, {}, "roughcontact", _COMPLETE, instruction)
        # Not `program.main`, whose treatment of closed pipes and Ctrl-C depends on the version.
        with program.make_context("roughcontact", arguments) as context:
            program.invoke(context)
        sys.stdout.flush()
    except Exit as stop:
        status = stop.exit_code
    except OSError as error:
        status = _report_write_error(error)
    except UnfinishedError as stop:
        status, unfinished = INTERRUPTED, stop
    except KeyboardInterrupt:
        status = INTERRUPTED
    except click.ClickException as error:
        failed = getattr(error, "ctx", None)
        command = failed.command_path if failed else "roughcontact"
        sentence = join_words(error.format_message()).rstrip(".")
        sentence = sentence[:1].lower() + sentence[1:]
        terminal.print_error(f"error: {sentence}; see {command} --help")
        return BAD_INPUT
    if status == INTERRUPTED:
        terminal.print_error(f"interrupted; {_written_text(unfinished)}")
        return SIGNALED + stopped[0] if stopped else INTERRUPTED
    return status


# Maximum number of file names in the message after an interruption.
_MAX_NAMED_FILES = 8


def _written_text(unfinished: UnfinishedError) -> str:
    """Return the message on the files that were complete at the interruption."""
    written, saved = unfinished.written, unfinished.saved
    if saved is not None and saved.number:
        parts = units.count_noun(saved.count, saved.part)
        return f"{saved.number} of {parts} saved in {saved.folder}; the same command resumes"
    if not written:
        return "nothing was written"
    names = ", ".join(str(path) for path in written[:_MAX_NAMED_FILES])
    more = len(written) - _MAX_NAMED_FILES
    return f"only {names} {f'and {more} more were' if more > 0 else 'was'} written"


# Each command, its positional argument and its function.
_COMMAND_FUNCTIONS: dict[str, tuple[Command, Subject | None, Act]] = {}


@functools.cache
def _build_program(name: str | None = None) -> click.Group:
    """Return the program with one command, or with all."""
    explained = "Explain a message by its tag, e.g. edge."
    program = CommandGroup(
        "roughcontact",
        params=[
            eager_option("--version", "Print the version.", _print_version, is_flag=True),
            eager_option("--explain", explained, _explain_tag, metavar="TAG"),
        ],
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
        help=_ABOUT,
        epilog='Example:\n\nroughcontact solve ground.x3p --load "100 MPa" --material 42CrMo4',
    )
    for command, subject, work in (
        _COMMAND_FUNCTIONS.values() if name is None else (_COMMAND_FUNCTIONS[name],)
    ):
        act = functools.partial(_report_errors, command, work)
        program.add_command(HelpCommand(command, subject, act))
    return program


_ABOUT = """Contact of measured rough surfaces: pressure, real contact area, gap, yielding.

\b
Give every quantity with its unit, in quotes: "1 N", "20 MPa", "0.1 mm".
Exit status: 0 solved, 1 not converged, 2 invalid input.
"""


def _print_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted:
        print(f"roughcontact {__version__}")
        ctx.exit()


def _explain_tag(ctx: click.Context, _: click.Parameter, tag: str | None) -> None:
    if tag is not None:
        from roughcontact.cautions import explain_tag

        try:
            print(textwrap.fill(explain_tag(tag), 80))
        except InputError as error:
            raise click.BadParameter(str(error)) from None
        ctx.exit()


# Commands from the table


def _report_errors(command: Command, work: Act, subject: Any = None, **parameters: Any) -> None:
    """Execute a command; report an expected error in one sentence, and exit."""
    try:
        work(subject, _given_options(command, parameters))
        sys.stdout.flush()
    except RoughcontactError as error:
        terminal.print_error(f"error: {error.message_for(command.spell_argument)}")
        status = NOT_CONVERGED if isinstance(error, ConvergenceError) else BAD_INPUT
        raise Exit(status) from None
    except MemoryError:
        terminal.print_error(f"error: {terminal.spell_options(_NO_MEMORY)}")
        raise Exit(BAD_INPUT) from None
    except OSError as error:
        raise Exit(_report_write_error(error)) from None
    except KeyboardInterrupt:
        # `main` reports the interruption.
        raise UnfinishedError(()) from None


def _given_options(command: Command, parameters: Given) -> Given:
    """Return the given options, and the settings of ``--set NAME=VALUE``, by name."""
    values = {
        item.name: parameters[item.argument] for item in command.options if not item.is_setting
    }
    values = {name: value for name, value in values.items() if value}
    known = [option.name for option in command.options if option.is_setting]
    for text in parameters.get("set", ()):
        name, sign, value = text.partition("=")
        if (option := command.by_name.get(name.strip().replace("_", "-"))) is None:
            raise InputError(f"--set: {unknown_name('setting', name, known)}")
        if option.is_flag:
            values[option.name] = option.parse(value or "true", option.argument)
        elif not sign:
            raise InputError(f"needs a value, {option.metavar}", argument=option.argument)
        else:
            values[option.name] = [*values.get(option.name, ()), value]
    for option in command.options:
        given = values.get(option.name)
        if not given or option.many or option.is_flag:
            continue
        if len(given) > 1:
            raise InputError(
                f"is given {len(given)} times ({', '.join(given)}); give it once",
                argument=option.argument,
            )
        values[option.name] = given[0]
    return values


def _expanded_option(arguments: list[str]) -> str | None:
    """Return the error on an option of a file that is followed by others, None if there is none.

    A shell that expands a pattern after an option makes its other files maps of the surface. Only
    a single input after the option, or inputs after an option of the output, are unambiguous.
    """
    command = tasks.COMMANDS.get(arguments[0])
    if command is None or len(arguments) < 2:
        return None
    options = {
        f"--{item.name}": item
        for item in command.options
        if "FILE" in item.metavar and not item.is_setting
    }
    is_first = not arguments[1].startswith("-")
    ambiguous: list[tuple[str, list[str]]] = []
    for index, word in enumerate(arguments):
        name, sign, _ = word.partition("=")
        if name in options and (is_first or options[name].panel != Panel.OUTPUT):
            rest = arguments[index + (1 if sign else 2) :]
            if files := [*itertools.takewhile(lambda word: not word.startswith("-"), rest)]:
                ambiguous.append((name, files))
    if not ambiguous or (not is_first and sum(len(files) for _, files in ambiguous) == 1):
        return None
    name, files = ambiguous[0]
    advice = f"repeat {name} for each of its files, and " if options[name].many else ""
    return (
        f"{name} takes one file, and {', '.join(files)} "
        f"{'follows' if len(files) == 1 else 'follow'} it: {advice}give all other maps before the "
        "options"
    )


def _moved_option(arguments: list[str]) -> str | None:
    """Return the sentence on an option that is a setting, gone or missing with a reason."""
    command = tasks.COMMANDS.get(arguments[0])
    for word, following in zip(arguments, [*arguments[1:], ""], strict=True):
        name, sign, value = word.partition("=")
        if command is None or not name.startswith("--"):
            continue
        name, value = name[2:], value if sign else following
        option = command.by_name.get(name)
        if option is not None and option.is_setting:
            text = option.is_flag or value or option.metavar
            return f"--{name} is a setting: give {shlex.join(option.words(text))}"
        if name in REMOVED:
            other, form = REMOVED[name]
            return f"--{name} is gone: give --{other} {shlex.quote(form.format(value))}"
        is_coating = name in [coating.name for coating in options.COATINGS]
        if is_coating and option is None and (reason := getattr(command, "uncoated", "")):
            others = ", ".join(t.name for t in TASKS if options.COATING in t.options)
            return f"--{name} is not available: {reason}; {others} include layers"
    return None


def _report_write_error(error: OSError) -> int:
    """Report a write error, unless a pipe is closed, and return the exit status."""
    if not isinstance(error, BrokenPipeError):
        place = shorten_value(error.filename or "standard output")
        terminal.print_error(f"error: {place}: {error.strerror or error}")
    terminal.discard_output()
    return PIPE_CLOSED if isinstance(error, BrokenPipeError) else BAD_INPUT


def _make_command(command: Command, subject: Subject | None = None) -> Callable[[Act], Act]:
    """Return a decorator that registers the function of a command."""

    def registered(work: Act) -> Act:
        _COMMAND_FUNCTIONS[command.name] = command, subject, work
        return work

    return registered


# Functions of the commands

_FILE = "Height map: instrument file, or matrix (.npy, .npz, .csv, .txt, .asc)."
_MAP = Subject("[FILE]", _FILE)
_SEVERAL = Subject("[FILE...]", f"{_FILE} Several give a row each.", nargs=-1)
_MAPS = Subject("[FILE...]", "Height maps of one surface.", nargs=-1)


def _display(specified: Given) -> DisplayOptions:
    """Remove the options of the console output, and return the selected output."""
    names = [item.name for item in (JSON, QUIET, VERBOSE) if specified.pop(item.name, False)]
    return DisplayOptions[names[0].upper()] if names else DisplayOptions.BRIEF


def _run_task(task: Task, subject: Any, specified: Given) -> None:
    """Execute a task, and print its result."""
    from roughcontact.request.request import Request
    from roughcontact.request.run import run_request

    reject_mpi_run()
    display = _display(specified)
    several = isinstance(subject, (list, tuple))
    files = tuple(map(Path, subject if several else filter(None, [subject])))
    if len(files) > 1 and not task.many_maps:
        _run_each(task, files, specified, display)
        return
    file = None if task.many_maps or not files else files[0]
    request = Request.from_text(task, file, specified, files if task.many_maps else ())
    with terminal.show_progress(display is DisplayOptions.QUIET) as line:
        outcome = run_request(request, line.set_stage, line.update)
    _show_outcome(outcome, display)


def _run_each(task: Task, files: Sequence[Path], specified: Given, display: DisplayOptions) -> None:
    """Execute a task for each of several files, and print a row for each."""
    from roughcontact.request.request import Request
    from roughcontact.request.run import run_request

    for option in task.options:
        if option.suffixes and option.name in specified:
            raise InputError(
                "takes the result of one file; solve files one by one, or by a project",
                argument=option.argument,
            )
    outcomes: list[Outcome | RoughcontactError] = []
    with terminal.show_progress(display is DisplayOptions.QUIET) as line:
        for file in files:
            try:
                request = Request.from_text(task, file, specified)
                outcomes.append(run_request(request, line.set_stage, line.update))
            except RoughcontactError as error:
                outcomes.append(error)
    failed = [item for item in outcomes if isinstance(item, RoughcontactError)]
    if display is DisplayOptions.JSON:
        records = [
            {"error": item.message_for(task.spell_argument)}
            if isinstance(item, RoughcontactError)
            else item.record()
            for item in outcomes
        ]
        print(to_json({"files": records}))
    elif display is not DisplayOptions.QUIET:
        from roughcontact.cli import console

        console.print_outcomes([file.name for file in files], outcomes, task)
    for item in failed:
        terminal.print_error(f"error: {item.message_for(task.spell_argument)}")
    if failed or not all(item.converged for item in outcomes if not isinstance(item, Exception)):
        raise Exit(BAD_INPUT if failed else NOT_CONVERGED)


def _show_outcome(outcome: Outcome, display: DisplayOptions) -> None:
    """Print the outcome of a request; raise its failure, or exit without convergence."""
    request, folder = outcome.request, outcome.request.get(options.FOLDER)
    if display is DisplayOptions.JSON:
        # Only the number of reused loads depends on an earlier run, not the results.
        about = {} if folder is None else {"reused": outcome.reused}
        print(to_json({**outcome.record(), **about}))
    elif display is not DisplayOptions.QUIET:
        # The import of the table library takes time.
        from roughcontact.cli import console

        console.print_outcome(outcome, display)
        if outcome.reused:
            loads = units.count_noun(outcome.reused, "load")
            print(f"taken from {folder}, solved by an earlier run: {loads}")
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.converged:
        wanted = any(option.suffixes and request[option] for option in request.task.options)
        terminal.print_error(
            f"error: {terminal.spell_options(outcome.shortfall, request.task)}"
            + ("; no file was written" if wanted else "")
            + (f"; earlier loads are saved in {folder}" if folder else "")
        )
        raise Exit(NOT_CONVERGED)


for _task in TASKS:
    _subject = _MAPS if _task.many_maps else _SEVERAL if _task.name == "solve" else _MAP
    _make_command(_task, _subject)(functools.partial(_run_task, _task))


@_make_command(making.COMMAND)
def _generate(_: Any, specified: Given) -> None:
    from roughcontact.analyses.generate.report import record
    from roughcontact.cli import console

    display = _display(specified)
    with terminal.show_progress(display is DisplayOptions.QUIET) as line:
        surface, written = making.run_generate(specified, line.set_stage)
    if display is DisplayOptions.JSON:
        print(to_json(record(surface)))
    elif display is not DisplayOptions.QUIET:
        console.print_generated(surface, written)


@_make_command(tasks.RUN, Subject("PROJECT", "Project file (TOML)."))
def _run(file: Path | str | None, specified: Given) -> None:
    from roughcontact.batch import plan
    from roughcontact.cli import console

    display = _display(specified)
    with terminal.show_progress(display is DisplayOptions.QUIET) as line:
        reports, folder = _run_project(
            str(file), tasks.RUN.parse_values(specified), line, display is DisplayOptions.QUIET
        )
    if display is DisplayOptions.JSON:
        print(to_json({"contacts": [report.record() for report in reports]}))
    elif display is not DisplayOptions.QUIET:
        console.show_reports(reports, folder)
    failed: dict[str, list[str]] = {}
    for report in reports:
        if report.state == plan.FAILED:
            failed.setdefault(report.reason, []).append(report.name)
    for reason, names in failed.items():
        more = f" and {len(names) - 3} more" if len(names) > 4 else ""
        terminal.print_error(f"error: {', '.join(names[: 3 if more else 4])}{more}: {reason}")
    if failed:
        raise Exit(NOT_CONVERGED)


def _run_project(
    file: str, requested: OptionValues, line: ProgressLine, quiet: bool
) -> tuple[list[ContactReport], Path]:
    """Run a project; return the reports of its contacts and the folder of the results."""
    from roughcontact.batch import plan, project, runner
    from roughcontact.solvers.progress import Forecast, Progress

    load = functools.partial(project.read_project, file)
    scheduler, workers = requested[tasks.SCHEDULER], requested[tasks.WORKERS]
    with runner.open_project(
        load, runner.task_limit, requested[tasks.ENGINE], scheduler=scheduler, workers=workers
    ) as (engine, entries):
        states: list[str] = []
        forecast = Forecast()
        forecast(Progress(1, len(entries), None))
        dashboard = f"; {engine.dashboard}" if engine.dashboard else ""

        def show_report(report: plan.ContactReport) -> None:
            states.append(report.state)
            number, kept = len(states), report.state == plan.KEPT
            seconds = forecast(Progress(number + (not kept), len(entries), None, kept=kept))
            failed = f", {states.count(plan.FAILED)} failed" if plan.FAILED in states else ""
            of = f"{number} of {len(entries)} done{failed}"
            line.set_stage(f"{of}, {report.name} {report.state}{dashboard}", seconds)

        line.set_stage(f"working through {len(entries)} contacts{dashboard}")
        warn = (lambda text: None) if quiet else terminal.print_error
        reports = runner.run_project(
            entries,
            show_report,
            engine,
            say=lambda text: line.set_stage(f"{text}{dashboard}"),
            warn=warn,
        )
        return reports, entries[0].summary.parent


@_make_command(tasks.DESK, _MAP)
def _desk(file: Any, specified: Given) -> None:
    """Serve the browser app until Ctrl-C."""
    if importlib.util.find_spec("panel") is None:
        raise InputError("the desk needs Panel; run pip install 'roughcontact[desk]'")
    from roughcontact.desk import server
    from roughcontact.formats.source import open_existing

    requested = tasks.DESK.parse_values(specified)
    if file is not None:
        with open_existing(file):
            file = Path(file).resolve()
    settings = server.Settings(
        file,
        requested[tasks.ADDRESS],
        requested[tasks.PORT],
        requested[tasks.ALLOW_ORIGIN],
        requested[tasks.PROJECTS_FOLDER],
        requested[tasks.UPLOAD_LIMIT],
        not requested[tasks.NO_BROWSER],
    )
    server.serve(_load_page, settings, lambda text: print(text, flush=True))


def _load_page() -> Page:
    """Return the function that makes a page; its import takes a second."""
    from roughcontact.desk.page import make_page

    return make_page


@_make_command(
    VERIFY, Subject("FILE...", "NetCDF results (.nc) of --output or --folder.", nargs=-1)
)
def _verify(files: Any, specified: Given) -> None:
    from roughcontact.cli import console
    from roughcontact.elastoplastic import archive

    display = _display(specified)
    with terminal.show_progress(display is DisplayOptions.QUIET) as line:
        checked = []
        for path in files:
            line.set_stage(f"verifying {path}")
            checked.append(archive.check_file(Path(path)))
    if display is DisplayOptions.JSON:
        print(to_json({"files": [item.record() for item in checked]}))
    elif display is not DisplayOptions.QUIET:
        console.print_verified(checked)
    failed = [item for item in checked if item.reason]
    for item in failed:
        terminal.print_error(f"error: {item.reason}")
    if failed:
        raise Exit(BAD_INPUT)


@_make_command(INFO, Subject("FILE...", _FILE, nargs=-1))
def _info(files: Any, specified: Given) -> None:
    from roughcontact.formats import read
    from roughcontact.formats.no_data import AUTO
    from roughcontact.report import inputs

    assert isinstance(files, Sequence)
    reading = {item.argument: specified[item.name] for item in READING if item.name in specified}
    # The options that `solve` needs are shown with the heights before these options.
    reading.setdefault(NO_DATA.argument, AUTO)
    display = _display(specified)
    listed = display in (DisplayOptions.JSON, DisplayOptions.VERBOSE)
    result: list[tuple[Measured | InputError, Sequence[Channel]]] = []
    for file in files:
        try:
            if listed:
                surface, channels = read.read_with_channels(str(file), **reading)
            else:
                surface, channels = read.read_surface(str(file), **reading), ()
            result.append((inputs.measured_map(surface), channels))
        except InputError as error:
            if len(files) == 1:
                raise
            result.append((error, ()))
    if display is DisplayOptions.JSON:
        records = [_info_record(*item) for item in result]
        print(to_json(records[0] if len(files) == 1 else {"files": records}))
    else:
        from roughcontact.cli import console

        console.show_info(result, list(map(str, files)), display)
    failed = [found for found, _ in result if isinstance(found, InputError)]
    for item in failed:
        terminal.print_error(f"error: {item.message_for(INFO.spell_argument)}")
    if failed:
        raise Exit(BAD_INPUT)


def _info_record(item: Measured | InputError, channels: Sequence[Channel]) -> dict[str, Any]:
    """Return the quantities of a file, or its error."""
    from roughcontact.contact.plausibility import map_cautions
    from roughcontact.report import inputs
    from roughcontact.report.kind import stored_values

    if isinstance(item, InputError):
        return {"error": item.message_for(INFO.spell_argument)}
    listed = [
        {"name": c.name, "unit": c.unit, "is_height": c.is_height, "shape": list(c.shape)}
        for c in channels
    ]
    cautions = [caution.summary() for caution in map_cautions(item.leveled)]
    return {
        **stored_values(inputs.file_table(item), item),
        "channels": listed,
        "cautions": cautions,
    }


@_make_command(MATERIALS, Subject("[NAME]", "Material to show.", complete_materials))
def _materials(name: Path | str | None, specified: Given) -> None:
    from roughcontact.cli import console
    from roughcontact.material import catalog

    result = catalog.entries() if name is None else (catalog.entry(str(name)),)
    if _display(specified) is DisplayOptions.JSON:
        text = [dataclasses.asdict(entry) for entry in result]
        print(to_json({"materials": text}))
    elif name is None:
        console.show_catalogue(result)
    else:
        console.show_entry(result[0])


@_make_command(DEMO)
def _demo(_: Path | str | None, specified: Given) -> None:
    from roughcontact.cli import demo

    requested = DEMO.parse_values(specified)
    demo.run_demo(requested[FOLDER], requested[POINTS])
