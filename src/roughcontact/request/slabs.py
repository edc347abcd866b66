"""Carry out a request whose map lies on several ranks: read, level, solve, write."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError, RoughcontactError
from roughcontact.ranks import Ranks
from roughcontact.request import options, solve
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Step

if TYPE_CHECKING:
    from roughcontact.contact.slab import Slab
    from roughcontact.contact.slab_result import SlabResult


@dataclass(frozen=True)
class SlabOutcome:
    """What a request gave.

    Parameters
    ----------
    result : SlabResult
        The contact, the same numbers on all ranks.
    written : tuple of Path
        Files that are complete.
    failure : RoughcontactError or OSError or None
        Why a file could not be written.
    """

    result: SlabResult
    written: tuple[Path, ...] = ()
    failure: RoughcontactError | OSError | None = None

    def record(self) -> dict[str, Any]:
        """Return all numbers by name, in SI units, ready for JSON."""
        from roughcontact.report import results

        return {**results.summary(self.result), "written": [str(path) for path in self.written]}


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
        (options.LEVEL, ("plane", "none")), (options.HOLES, ("error", "mask")),
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


def run(
    request: Request,
    ranks: Ranks,
    say: Callable[[str], None],
    look: Callable[[Step], None] | None = None,
) -> SlabOutcome:
    """Read, level, solve, and write what was asked for; all ranks call it.

    Parameters
    ----------
    request : Request
        What to do: a solve with a ceiling.
    ranks : Ranks
        Those that will hold the map.
    say : callable
        Called with a few words before every stage.
    look : callable, optional
        Called with every `Step` of the solver.

    Raises
    ------
    RoughcontactError, OSError
        If the request cannot be done, on all ranks.
    """
    from roughcontact.contact.slabs import solve_slab

    check(request)
    # The others need not see where the first writes.
    ranks.agreed(lambda: request.check_places() if ranks.first else None)
    slab = _read(request, ranks, say)
    material, counter = request.bodies()
    result = solve_slab(
        slab,
        material=material,
        counter_material=counter,
        load=request.load[0],
        approach=request[options.APPROACH],
        ceiling=request[options.CEILING],
        boundary=request[options.BOUNDARY],
        on_failure="return",
        progress=look,
        **request.solver(*options.SOLVER),
    )
    outcome = SlabOutcome(result)
    return _written(request, outcome, say) if result.converged else outcome


def _read(request: Request, ranks: Ranks, say: Callable[[str], None]) -> Slab:
    from roughcontact.formats.slabs import read_slab

    assert request.file is not None
    say(f"reading {request.file.name}")
    slab = read_slab(
        request.file, ranks, request[options.CHANNEL], request[options.UNIT], request[options.SIZE],
        request[options.OVERRIDE_SIZE], holes_masked=request[options.HOLES] == "mask",
    )  # fmt: skip
    return slab if request[options.LEVEL] == "none" else slab.leveled()


def _written(request: Request, outcome: SlabOutcome, say: Callable[[str], None]) -> SlabOutcome:
    """Write the files of an outcome, and return it with their names."""
    from roughcontact.contact.slab_archive import save_slabs
    from roughcontact.contact.slab_result import reduced

    result, ranks = outcome.result, outcome.result.slab.ranks
    try:
        for path in request.outputs:
            say(f"writing {path}")
            save_slabs(result, path)
            outcome = replace(outcome, written=(*outcome.written, path))
        if request[options.REPORT] is not None:
            from roughcontact.report import slabs as report
            from roughcontact.report.page import Edition

            say(f"writing {request[options.REPORT]}")
            maps = reduced(result)
            edition = Edition(request.command, spell=request.task.spelled)
            ranks.agreed(
                lambda: (
                    report.save(result, maps, request[options.REPORT], edition)
                    if ranks.first
                    else None
                )
            )
            outcome = replace(outcome, written=(*outcome.written, request[options.REPORT]))
    except (RoughcontactError, OSError) as error:
        return replace(outcome, failure=error)
    return outcome
