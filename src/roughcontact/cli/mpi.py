"""The command line on several ranks: the first speaks, and all end together."""

from __future__ import annotations

import traceback
from collections.abc import Callable

import typer

from roughcontact.cli import result_output, terminal
from roughcontact.cli.terminal import BAD_INPUT, NOT_CONVERGED, Display
from roughcontact.errors import RoughcontactError
from roughcontact.ranks import Ranks, world
from roughcontact.request import elastoplastic_mpi, slab_mpi, solve
from roughcontact.request.request import Request

_FAILED = 1


def carry_out(ask: Callable[[], Request], display: Display) -> None:
    """Carry out a request on all ranks that ``mpiexec`` started, and show what it gave."""
    ranks = world()
    try:
        _carry_out(ask(), ranks, display)
    except (RoughcontactError, OSError) as error:
        # Where all have the same error, the first tells it.
        if not ranks.all_end():
            terminal.complain(f"error: rank {ranks.number}: {terminal.spelled(str(error))}")
            ranks.abort(BAD_INPUT)
        if ranks.first:
            raise
        raise typer.Exit(BAD_INPUT) from None
    except KeyboardInterrupt:
        # All hear it, one says so.
        if not ranks.first:
            terminal.discard_errors()
        raise
    except typer.Exit:
        raise
    except BaseException:
        terminal.complain(f"error: rank {ranks.number} failed, and with it all others")
        traceback.print_exc()
        ranks.abort(_FAILED)


def _carry_out(request: Request, ranks: Ranks, display: Display) -> None:
    from roughcontact.report import phrases

    run = elastoplastic_mpi.run if request.get(solve.MODEL) == solve.VOLUME_MODEL else slab_mpi.run
    time_left = phrases.Forecast()
    with terminal.progress(display is Display.QUIET or not ranks.first) as say:
        outcome = run(
            request, ranks, say, lambda state: say(phrases.described(state) + time_left(state))
        )
    if ranks.first:
        result_output.show_outcome(outcome, display)
    elif outcome.failure is not None:
        raise outcome.failure
    elif not outcome.converged:
        raise typer.Exit(NOT_CONVERGED)
