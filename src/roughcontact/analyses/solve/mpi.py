"""Execution of a request on several ranks, which share one map or volume."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact._tools.ranks import Ranks
from roughcontact.analyses.solve import task as solve
from roughcontact.errors import InputError, RoughcontactError
from roughcontact.request import options, outputs, run as runs
from roughcontact.request.outcome import OnProgress, Outcome, TaskContext
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.contact.share import Slab
    from roughcontact.surface.surface import Surface


def run(request: Request, ranks: Ranks, say: Say, look: OnProgress) -> Outcome:
    """Read, prepare, solve and write a request; collective call of all ranks."""
    is_volume = request.get(solve.MODEL) == solve.VOLUME_MODEL
    _check(request, is_volume)
    outcome, work = (_volume if is_volume else _map)(request, ranks, say, look)
    if not outcome.converged:
        return outcome
    try:
        if not is_volume:
            return replace(
                outcome, written=tuple(outputs.write_files(runs.files(outcome, work), say))
            )
        # All ranks write the fields; the root rank has whole maps and writes figures and report.
        fields = [(path, outcome.result.save) for path in request.outputs]

        def write_figures() -> list[Path]:
            tasks = (task for task in runs.files(outcome, work) if task[0] not in request.outputs)
            return outputs.write_files(tasks, say)

        written = (*outputs.write_files(fields, say), *ranks.broadcast_from_first(write_figures))
    except RoughcontactError as error:
        return replace(outcome, failure=error)
    return replace(outcome, written=written)


def _check(request: Request, is_volume: bool) -> None:
    """Raise `InputError` for options that are not available on several ranks."""
    if is_volume and request[solve.FOLDER] is not None:
        raise InputError(
            "needs all states in one process and is not available on several ranks; leave it out, "
            "or start without mpiexec",
            argument="folder",
        )
    if not is_volume:
        _check_map(request)
    for path in request.outputs:
        if path.suffix.lower() != ".nc":
            what = "volume" if is_volume else "map"
            raise InputError(
                f"of a {what} on several ranks is written as .nc, got {str(path)!r}",
                argument="output",
            )


def _check_map(request: Request) -> None:
    if request.task is not solve.TASK or request[solve.MODEL] != solve.SURFACE_MODEL:
        raise InputError(
            "several ranks solve one contact, with a ceiling or with the volume model; start this "
            "without mpiexec"
        )
    if request.file is None:
        raise InputError("is needed: ranks read their rows of it", argument="file")
    for option in request.task.options:
        if option.whole_map and request.is_given(option):
            raise InputError(
                "needs the whole map in one process and is not available on several ranks; prepare "
                "the map beforehand and save it as .nc or .npy, or start without mpiexec",
                argument=option.argument,
            )
    for option, known in ((options.LEVEL, ("plane", "none")), (options.MISSING, ("error", "mask"))):
        if request[option] not in known:
            raise InputError(
                f"must be {' or '.join(known)} on several ranks, got {request[option]!r}; prepare "
                "the map beforehand",
                argument=option.argument,
            )


def _map(request: Request, ranks: Ranks, say: Say, look: OnProgress) -> tuple[Outcome, TaskContext]:
    """Read, level and solve a map in slabs of rows, one per rank."""
    from roughcontact.contact import solve as solving

    # Only the root rank needs access to the output folder.
    ranks.run_on_all(lambda: request.check_places() if ranks.is_root else None)
    slab = _read_slab(request, ranks, say)
    result = solving.solve(
        slab,
        **request.arguments((), *options.SOLVER),
        load=request.load[0],
        approach=request[options.APPROACH],
        on_failure="return",
        progress=look,
    )
    return Outcome(request, result, result), TaskContext(request, lambda: (), say, look)


def _volume(
    request: Request, ranks: Ranks, say: Say, look: OnProgress
) -> tuple[Outcome, TaskContext]:
    """Solve the elastoplastic model, with layers distributed over the ranks."""

    def prepared() -> list[Surface]:
        request.check_places()
        return runs.prepare_maps(request, say)

    # Only the root rank needs access to input and output files.
    maps = ranks.broadcast_from_first(prepared)
    work = TaskContext(request, lambda: maps, say, look, ranks=ranks)
    return request.task.run(request, work), work


def _read_slab(request: Request, ranks: Ranks, say: Say) -> Slab:
    from roughcontact.formats.slab import read_slab

    assert request.file is not None
    say(f"reading {request.file.name}")
    slab = read_slab(
        request.file,
        ranks,
        request[options.CHANNEL],
        request[options.UNIT],
        request[options.SIZE],
        request[options.OVERRIDE_SIZE],
        request[options.NO_DATA],
        mask_missing=request[options.MISSING] == "mask",
    )
    return slab if request[options.LEVEL] == "none" else slab.leveled()
