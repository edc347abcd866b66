"""The result of a command on the console or as JSON, and the exit status."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from roughcontact import units
from roughcontact.cli import terminal
from roughcontact.cli.terminal import NOT_CONVERGED, Display
from roughcontact.files import to_json
from roughcontact.request.options import FOLDER

if TYPE_CHECKING:
    from roughcontact.request.outcome import Outcome


def show_outcome(outcome: Outcome, display: Display) -> None:
    """Show what a request gave, and end where it gave no solution."""
    request, folder = outcome.request, outcome.request.get(FOLDER)
    if display is Display.JSON:
        # Of this run alone: what was solved is the same, taken from a folder or not.
        about = {} if folder is None else {"reused": outcome.reused}
        print(to_json({**outcome.record(), **about}))
    elif display is not Display.QUIET:
        # What draws tables takes time to import.
        from roughcontact.cli import console

        console.show(outcome, display)
        if outcome.reused:
            loads = units.counted(outcome.reused, "load")
            print(f"taken from {folder}, solved by an earlier run: {loads}")
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.converged:
        wanted = any(option.suffixes and request[option] for option in request.task.options)
        terminal.complain(
            f"error: {terminal.spelled(outcome.shortfall, request.task)}"
            + ("; no file was written" if wanted else "")
            + (f"; the loads before it are kept in {folder}" if folder else "")
        )
        raise typer.Exit(NOT_CONVERGED)
