"""What a request falls into that can be solved apart, in any order, on any machine.

Pieces do not start from each other: the whole has the same bits however they were solved.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from roughcontact.request.outcome import Look
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.request.task import Pieces


def of(request: Request) -> tuple[str, ...]:
    """Return a word for each piece of a request; none where it is one.

    Of a comparison the pieces are its maps, of a contact with a study the grids, cut-offs and
    ceilings of that. All else goes on from contact to contact, or looks at the whole of each: a
    sweep, a history, loads that are sought, those of a joint.
    """
    found = _pieces(request).of(request) if request.task.pieces else ()
    return found if len(found) > 1 else ()


def inputs(request: Request, word: str) -> tuple[Path, ...]:
    """Return the files that a piece reads, or without a word the rest where all are found."""
    file_of = _pieces(request).file_of
    if file_of is None:
        return tuple(request.inputs)
    file = file_of(request, word) if word else None
    return () if file is None else (file,)


def depends_on(request: Request, word: str) -> tuple[str, frozenset[str]]:
    """Return the name of what a piece is of, and the options that it has nothing to do with.

    Of two maps that are told apart by their names alone, what is found differs by these.
    """
    written = {option.name for option in request.task.options if option.suffixes}
    pieces = _pieces(request)
    if pieces.file_of is None:
        return word, frozenset(written)
    file = pieces.file_of(request, word)
    beside = {option.name for option in pieces.beside}
    return "" if file is None else file.name, frozenset(written | beside)


def found_of(request: Request, word: str, say: Say, look: Look) -> Any:
    """Return what is found of a piece, which `request.run.run` takes by its word.

    Errors are those of `request.run.run`.
    """
    return _pieces(request).find(request, word, say, look)


def _pieces(request: Request) -> Pieces:
    pieces = request.task.pieces
    assert pieces is not None
    return pieces
