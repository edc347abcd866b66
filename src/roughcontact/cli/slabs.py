"""The command line on several ranks: the first speaks, and all end together."""

from __future__ import annotations

import traceback
from collections.abc import Callable

import typer

from roughcontact.cli import shown, terminal
from roughcontact.cli.terminal import BAD_INPUT, NOT_CONVERGED
from roughcontact.errors import RoughcontactError
from roughcontact.files import to_json
from roughcontact.ranks import Ranks, world
from roughcontact.request import slabs, solve
from roughcontact.request.request import Request

_FAILED = 1


def carry_out(ask: Callable[[], Request], as_json: bool, quiet: bool) -> None:
    """Carry out a request on all ranks that ``mpiexec`` started, and show what it gave.

    Parameters
    ----------
    ask : callable
        Returns the request.
    as_json, quiet : bool
        How it is shown.
    """
    ranks = world()
    try:
        request = ask()
        carried = (
            _carry_out_volume if request.get(solve.MODEL) == solve.VOLUME_MODEL else _carry_out
        )
        carried(request, ranks, as_json, quiet)
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


def _carry_out(request: Request, ranks: Ranks, as_json: bool, quiet: bool) -> None:
    with terminal.progress(quiet or not ranks.first) as say:
        outcome = slabs.run(
            request, ranks, say,
            lambda step: say(f"{step.shape[0]} × {step.shape[1]}: {step.certificate:.1e}"),
        )  # fmt: skip
    if ranks.first and as_json:
        print(to_json(outcome.record()))
    elif ranks.first and not quiet:
        from roughcontact.cli import console

        console.show_result(outcome.result, solve.TASK, outcome.written)
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.result.converged:
        if ranks.first:
            from roughcontact.contact.slab_result import unsolved

            terminal.complain(f"error: {terminal.spelled(unsolved(outcome.result))}")
        raise typer.Exit(NOT_CONVERGED)


def _carry_out_volume(request: Request, ranks: Ranks, as_json: bool, quiet: bool) -> None:
    from roughcontact.report import underway
    from roughcontact.request import volumes

    left = underway.Forecast()
    with terminal.progress(quiet or not ranks.first) as say:
        outcome = volumes.run(
            request, ranks, say, lambda at: say(underway.described(at) + left(at))
        )  # fmt: skip
    if ranks.first:
        shown.show(outcome, as_json, quiet)
    elif outcome.failure is not None:
        raise outcome.failure
    elif not outcome.converged:
        raise typer.Exit(NOT_CONVERGED)
