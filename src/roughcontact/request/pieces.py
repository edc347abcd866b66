"""What a request falls into that can be solved apart, in any order, on any machine.

Pieces do not start from each other: the whole has the same bits however they were solved.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from roughcontact.request import comparing, studying
from roughcontact.request.options import COMPARE, SOLVE, offered
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress


def of(request: Request) -> tuple[str, ...]:
    """Return a word for each piece of a request; none where it is one.

    Of a comparison the pieces are its maps, of a contact with a study the grids, cut-offs and
    ceilings of that. All else goes on from contact to contact, or looks at the whole of each: a
    sweep, a history, loads that are sought, those of a joint.
    """
    found: tuple[str, ...] = ()
    if request.kind == COMPARE:
        found = comparing.apart(request)
    elif request.kind == SOLVE:
        found = studying.apart(request)
    return found if len(found) > 1 else ()


def inputs(request: Request, word: str) -> tuple[Path, ...]:
    """Return the files that a piece reads, or without a word the rest where all are found."""
    if request.kind != COMPARE:
        return tuple(request.inputs)
    file = comparing.file_of(request, word) if word else None
    return () if file is None else (file,)


def depends_on(request: Request, word: str) -> tuple[str, frozenset[str]]:
    """Return the name of what a piece is of, and the options that it has nothing to do with.

    Of two maps that are told apart by their names alone, what is found differs by these.
    """
    written = {name for name, option in offered(request.task).items() if option.suffixes}
    if request.kind != COMPARE:
        return word, frozenset(written)
    file = comparing.file_of(request, word)
    return "" if file is None else file.name, frozenset({*written, *comparing.BESIDE})


def found_of(request: Request, word: str, say: Say, look: Callable[[Progress], None]) -> Any:
    """Return what is found of a piece, which `request.run.run` takes by its word.

    Errors are those of `request.run.run`.
    """
    solved = comparing.found_of if request.kind == COMPARE else studying.found_of
    return solved(request, word, say, look)
