"""A request whose files lie elsewhere: seen from another folder, or on another machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughcontact.request import parsing
from roughcontact.request.options import GROUP
from roughcontact.request.outcome import Look
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request, matching
from roughcontact.request.task import Pieces

Move = Callable[[Path], Path]
"""Returns where a file lies, for the path that was given."""


def with_relocated_files(request: Request, read: Move, written: Move) -> Request:
    """Return the same request of files that lie elsewhere."""
    names: dict[str, str] = {}

    def known(new: str, old: str) -> str:
        names[new] = request.names.get(old, old)
        return new

    def word(text: str, name: str) -> str:
        option = request.task.by_name[name]
        if option is GROUP:
            group, words = parsing.group(text, name)
            paths = (path for item in words for path in matching(item))
            lie = [known(str(read(path)), str(path)) for path in paths]
            return known(parsing.group_text(group, lie), text)
        move = written if option.is_written else read
        return known(str(move(Path(text))), text)

    specified: dict[str, str | bool | list[str]] = {}
    for name, value in request.specified.items():
        if isinstance(value, bool) or not request.task.by_name[name].is_place:
            specified[name] = value
        elif isinstance(value, str):
            specified[name] = word(value, name)
        else:
            specified[name] = [word(text, name) for text in value]
    paths = [path for path in (request.file, *request.files) if path is not None]
    lie = {path: Path(known(str(read(path)), str(path))) for path in paths}
    file = None if request.file is None else lie[request.file]
    files = tuple(lie[path] for path in request.files)
    return replace(Request.from_text(request.task, file, specified, files), names=names)


# --- What a request falls into that can be solved apart, in any order, on any machine ---


def subtask_ids(request: Request) -> tuple[str, ...]:
    """Return a word for each piece of a request; none where it is one."""
    result = _pieces(request).of(request) if request.task.pieces else ()
    return result if len(result) > 1 else ()


def inputs(request: Request, word: str) -> tuple[Path, ...]:
    """Return the files that a piece reads, or without a word the rest where all are found."""
    file_of = _pieces(request).file_of
    if file_of is None:
        return tuple(request.inputs)
    file = file_of(request, word) if word else None
    return () if file is None else (file,)


def depends_on(request: Request, word: str) -> tuple[str, frozenset[str]]:
    """Return the name of what a piece is of, and the options that it has nothing to do with."""
    written = {option.name for option in request.task.options if option.suffixes}
    pieces = _pieces(request)
    if pieces.file_of is None:
        return word, frozenset(written)
    file = pieces.file_of(request, word)
    reference = {option.name for option in pieces.shared_options}
    return "" if file is None else file.name, frozenset(written | reference)


def found_of(request: Request, word: str, say: Say, look: Look) -> Any:
    """Return what is found of a piece, which `request.run.run` takes by its word."""
    return _pieces(request).find(request, word, say, look)


def _pieces(request: Request) -> Pieces:
    pieces = request.task.pieces
    assert pieces is not None
    return pieces
