"""Carry out a request whose map lies on several ranks: read, level, solve, write."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from roughcontact.errors import InputError, RoughcontactError
from roughcontact.ranks import Ranks
from roughcontact.request import options, outputs, run as runs, solve, solve_arguments
from roughcontact.request.outcome import Look, Outcome, Work
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.contact.share import Slab


def check(request: Request) -> None:
    """Raise `InputError` for what is not known of a map on several ranks."""
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
                "takes a map in one place and is not available on several ranks; prepare the map "
                "beforehand and save it as .nc or .npy, or start without mpiexec",
                argument=option.argument,
            )
    for option, known in (
        (options.LEVEL, ("plane", "none")), (options.MISSING, ("error", "mask")),
    ):  # fmt: skip
        if request[option] not in known:
            raise InputError(
                f"must be {' or '.join(known)} on several ranks, got {request[option]!r}; prepare "
                "the map beforehand",
                argument=option.argument,
            )
    for path in request.outputs:
        if path.suffix.lower() != ".nc":
            raise InputError(
                f"of a map on several ranks is written as .nc, got {str(path)!r}",
                argument="output",
            )


def run(request: Request, ranks: Ranks, say: Say, look: Look) -> Outcome:
    """Read, level, solve, and write what was asked for; all ranks call it."""
    from roughcontact.contact import solve as solving

    check(request)
    # The others need not see where the first writes.
    ranks.agreed(lambda: request.check_places() if ranks.first else None)
    slab = _read(request, ranks, say)
    result = solving.solve(
        slab,
        **solve_arguments.arguments(request, (), *options.SOLVER),
        load=request.load[0],
        approach=request[options.APPROACH],
        on_failure="return",
        progress=look,
    )
    outcome = Outcome(request, result, result)
    if not outcome.converged:
        return outcome
    work = Work(request, lambda: (), say, look)
    try:
        return replace(outcome, written=tuple(outputs.write(runs.files(outcome, work), say)))
    except RoughcontactError as error:
        return replace(outcome, failure=error)


def _read(request: Request, ranks: Ranks, say: Say) -> Slab:
    from roughcontact.formats.slab import read_slab

    assert request.file is not None
    say(f"reading {request.file.name}")
    slab = read_slab(
        request.file, ranks, request[options.CHANNEL], request[options.UNIT], request[options.SIZE],
        request[options.OVERRIDE_SIZE], mask_missing=request[options.MISSING] == "mask",
    )  # fmt: skip
    return slab if request[options.LEVEL] == "none" else slab.leveled()
