"""A request whose files lie elsewhere: seen from another folder, or on another machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from roughcontact.request import parsing
from roughcontact.request.options import GROUP
from roughcontact.request.request import Request, matching

Move = Callable[[Path], Path]
"""Returns where a file lies, for the path that was given."""


def moved(request: Request, read: Move, written: Move) -> Request:
    """Return the same request of files that lie elsewhere.

    Parameters
    ----------
    request : Request
        What was asked for.
    read, written : callable
        Where a file that is read lies, and one that is written, or a folder of such. They keep
        their names.

    Returns
    -------
    Request
        What it leaves is the same to the bit: its `names` tell what the user calls its files.
        Wildcards stand for the files that they fit now.
    """
    names: dict[str, str] = {}

    def known(new: str, old: str) -> str:
        names[new] = request.names.get(old, old)
        return new

    def word(text: str, name: str) -> str:
        option = request.task.by_name[name]
        if option is GROUP:
            group, words = parsing.group(text, name)
            paths = (path for one in words for path in matching(one))
            lie = [known(str(read(path)), str(path)) for path in paths]
            return known(parsing.group_text(group, lie), text)
        move = written if option.is_written else read
        return known(str(move(Path(text))), text)

    given: dict[str, str | bool | list[str]] = {}
    for name, value in request.given.items():
        if isinstance(value, bool) or not request.task.by_name[name].is_place:
            given[name] = value
        elif isinstance(value, str):
            given[name] = word(value, name)
        else:
            given[name] = [word(text, name) for text in value]
    paths = [path for path in (request.file, *request.files) if path is not None]
    lie = {path: Path(known(str(read(path)), str(path))) for path in paths}
    file = None if request.file is None else lie[request.file]
    files = tuple(lie[path] for path in request.files)
    return replace(Request.from_text(request.task, file, given, files), names=names)
