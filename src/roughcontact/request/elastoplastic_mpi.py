"""Carry out a request of the volume model whose volume lies on several ranks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact.errors import InputError, RoughcontactError
from roughcontact.ranks import Ranks
from roughcontact.request import outputs, run as runs, solve
from roughcontact.request.outcome import Look, Outcome, Work
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.request.outputs import Say
    from roughcontact.surface.surface import Surface


def check(request: Request) -> None:
    """Raise `InputError` for what is not known of a volume on several ranks."""
    if request[solve.FOLDER] is not None:
        raise InputError(
            "keeps the states of one process and is not available on several ranks; leave it out, "
            "or start without mpiexec",
            argument="folder",
        )
    for path in request.outputs:
        if path.suffix.lower() != ".nc":
            raise InputError(
                f"of a volume on several ranks is written as .nc, got {str(path)!r}",
                argument="output",
            )


def run(request: Request, ranks: Ranks, say: Say, look: Look) -> Outcome:
    """Read, prepare, solve, and write what was asked for; all ranks call it."""
    check(request)
    # The others need not see what the first reads, nor where it writes.
    maps = ranks.by_first(lambda: _prepared(request, say))
    work = Work(request, lambda: maps, say, look, ranks=ranks)
    outcome: Outcome = request.task.run(request, work)
    if not outcome.converged:
        return outcome
    # The fields by all, pictures and report by the first, which has the maps whole.
    fields = [(path, outcome.found.save) for path in request.outputs]

    def drawn() -> list[Path]:
        tasks = (task for task in runs.files(outcome, work) if task[0] not in request.outputs)
        return outputs.write(tasks, say)

    try:
        written = (*outputs.write(fields, say), *ranks.by_first(drawn))
    except RoughcontactError as error:
        return replace(outcome, failure=error)
    return replace(outcome, written=written)


def _prepared(request: Request, say: Say) -> list[Surface]:
    request.check_places()
    return runs.prepared(request, say)
