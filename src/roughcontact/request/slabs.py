"""Carry out a request whose map lies on several ranks: read, level, solve, write."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from roughcontact.errors import InputError, RoughcontactError
from roughcontact.ranks import Ranks
from roughcontact.request import outputs, problem, run as runs
from roughcontact.request.options import SHOWN, SOLVE, offered
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.request.run import Look, Outcome

if TYPE_CHECKING:
    from roughcontact.contact.slab import Slab

_KNOWN = (
    "channel", "unit", "size", "override-size", "level", "holes", "load", "approach", "material",
    "counter-material", "young", "poisson", "yield-strength", "counter-young", "counter-poisson",
    "counter-yield-strength", "ceiling", "boundary", "model", "tolerance", "max-iterations",
    "precision", "output", "report", *SHOWN,
)  # fmt: skip
"""Options that a map on several ranks can have; ``level`` a plane or none, ``holes`` masked."""


def check(request: Request) -> None:
    """Raise `InputError` for what is not known of a map on several ranks."""
    if request.task != SOLVE or request.kind != SOLVE:
        raise InputError(
            "several ranks solve one contact, with a ceiling or with the volume model; start this "
            "without mpiexec"
        )
    if request.file is None:
        raise InputError("is needed: ranks read their rows of it", argument="file")
    for name, option in offered(SOLVE).items():
        if name not in _KNOWN and request[name] != option.default:
            raise InputError(
                "takes a map in one place and is not available on several ranks; prepare the map "
                "beforehand and save it as .nc or .npy, or start without mpiexec",
                argument=option.argument,
            )
    for name, known in (("level", ("plane", "none")), ("holes", ("error", "mask"))):
        if request[name] not in known:
            raise InputError(
                f"must be {' or '.join(known)} on several ranks, got {request[name]!r}; prepare "
                "the map beforehand",
                argument=name,
            )
    for path in request.outputs:
        if path.suffix.lower() != ".nc":
            raise InputError(
                f"of a map on several ranks is written as .nc, got {str(path)!r}",
                argument="output",
            )


def run(
    request: Request,
    ranks: Ranks,
    say: Say,
    look: Look,
) -> Outcome:
    """Read, level, solve, and write what was asked for; all ranks call it.

    Parameters
    ----------
    request : Request
        What to do: a solve with a ceiling.
    ranks : Ranks
        Those that will hold the map.
    say, look : callable
        As for `roughcontact.request.run.run`.

    Returns
    -------
    Outcome
        The contact, the same numbers on all ranks.

    Raises
    ------
    RoughcontactError, OSError
        If the request cannot be done, on all ranks.
    """
    from roughcontact.contact.solve import solve

    check(request)
    # The others need not see where the first writes.
    ranks.agreed(lambda: request.check_places() if ranks.first else None)
    slab = _read(request, ranks, say)
    result = solve(
        slab,
        **problem.arguments(request, (), "tolerance", "max-iterations", "precision"),
        load=request["load"],
        approach=request["approach"],
        on_failure="return",
        progress=look,
    )
    outcome = Outcome(request, result)
    return _written(outcome, say) if result.converged else outcome


def _read(request: Request, ranks: Ranks, say: Say) -> Slab:
    from roughcontact.formats.slabs import read_slab

    assert request.file is not None
    say(f"reading {request.file.name}")
    slab = read_slab(
        request.file, ranks, request["channel"], request["unit"], request["size"],
        request["override-size"], holes_masked=request["holes"] == "mask",
    )  # fmt: skip
    return slab if request["level"] == "none" else slab.leveled()


def _written(outcome: Outcome, say: Say) -> Outcome:
    """Write the files of an outcome, and return it with their names."""
    request, result = outcome.request, outcome.result
    assert result is not None
    files: list[outputs.Task] = [(path, result.save) for path in request.outputs]
    if request["report"] is not None:
        files.append((request["report"], partial(runs.report, outcome, ())))
    try:
        return replace(outcome, written=tuple(outputs.write(files, say)))
    except RoughcontactError as error:
        return replace(outcome, failure=error)
