"""The contacts of a project, what each depends on, and which of them are complete."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import uuid4

from roughcontact import checksums
from roughcontact._version import __version__
from roughcontact.errors import Mention
from roughcontact.files import to_json
from roughcontact.request import comparing, pieces
from roughcontact.request.options import GROUP
from roughcontact.request.request import Request
from roughcontact.request.task import Command

OWN = frozenset({"run", "sha256", "seal"})
"""What the file of a contact keeps for itself among the numbers by name."""

DAMAGED = OSError, ValueError, TypeError, LookupError, AttributeError, ImportError, RecursionError
"""What may come of reading a file that was written before, and damaged since."""

SOLVED, KEPT, FAILED = "solved", "solved before", "failed"


@dataclass(frozen=True)
class Entry:
    """One contact of a project.

    Parameters
    ----------
    name : str
        Its name, and that of its files.
    request : Request
        What to do.
    summary : Path
        The JSON file that is written last; with it the contact is complete.
    contact : int
        Entries of the same number ask several things of one contact, which is solved once.
    """

    name: str
    request: Request
    summary: Path
    contact: int


@dataclass(frozen=True)
class Report:
    """How one contact of a project ended.

    Parameters
    ----------
    name : str
        Of the contact.
    state : {"solved", "solved before", "failed"}
        How it ended.
    told : dict
        What its JSON file says; empty if it failed.
    reason : str
        Why it failed, in a sentence.
    """

    name: str
    state: str
    told: Mapping[str, Any]
    reason: str = ""

    @property
    def last(self) -> Mapping[str, Any]:
        """The contact in a few numbers: of several loads the last, of those found the largest."""
        return dict(self.told.get("last", self.told))


def spell_key(mention: Mention, task: Command) -> str:
    """Return an argument in the words of project files.

    Parameters
    ----------
    mention : Mention
        What a message speaks of.
    task : Command
        Of the contact; an argument that it has no key for keeps its name.

    Returns
    -------
    str
        ``key``, or ``key = value``.

    Examples
    --------
    >>> from roughcontact.request.solve import TASK
    >>> spell_key(Mention("load", "1 N"), TASK)
    'load = "1 N"'
    """
    option = task.named(mention.name)
    if option is None:
        return str(mention)
    if mention.value is None:
        return option.name
    if isinstance(mention.value, bool):
        return f"{option.name} = {str(mention.value).lower()}"
    return f"{option.name} = {json.dumps(option.text(mention.value), ensure_ascii=False)}"


def complete(entry: Entry, digest: str) -> dict[str, Any] | None:
    """Return what an earlier run told, if it was the same and left what is there now.

    Parameters
    ----------
    entry : Entry
        The contact.
    digest : str
        What it depends on, from `digest_of`.

    Returns
    -------
    dict or None
        The content of its JSON file, with the files where they lie now. None if anything is
        missing, or is not to the bit what the run wrote.
    """
    try:
        told = json.loads(entry.summary.read_text(encoding="utf-8"))
        if not isinstance(told, dict) or told.get("run") != digest:
            return None
        if told.pop("seal", None) != checksums.of_words(told):
            return None
        # Of a profile fewer figures are drawn than of a map.
        paths = [path for _, path in entry.request.places if path.name in told["sha256"]]
        if told["sha256"] != _sums(paths):
            return None
    except DAMAGED:
        return None
    return {**told, "written": [str(path) for path in paths]}


def sealed(told: Mapping[str, Any], digest: str, written: Iterable[Path]) -> dict[str, Any]:
    """Return what the JSON file of a contact holds, so that `complete` knows it again.

    Parameters
    ----------
    told : mapping
        All numbers by name.
    digest : str
        What they depend on, from `digest_of`.
    written : iterable of Path
        The other files of the contact.

    Returns
    -------
    dict
        The same with ``run``, the digest, ``sha256`` of each file by name, and the ``seal`` of all
        that.
    """
    if taken := OWN & told.keys():
        raise ValueError(f"the file itself keeps {', '.join(sorted(taken))}")
    whole = json.loads(to_json({**told, "run": digest, "sha256": _sums(written)}))
    return {**whole, "seal": checksums.of_words(whole)}


def content_of(path: Path) -> str | None:
    """Return the checksum of a file that is read; nothing where reading will say what is wrong."""
    try:
        # What a device or a pipe gives has no end, or is gone then.
        return checksums.of_file(path) if path.is_file() else None
    except OSError:
        return None


def digest_of(
    entry: Entry, content: Callable[[Path], str | None] = content_of, piece: str = ""
) -> str:
    """Return a word for all that a contact depends on: options and content of files.

    Where the files lie does not matter, nor from where the project is run.

    Parameters
    ----------
    entry : Entry
        The contact.
    content : callable, optional
        What returns the checksum of a file, as `content_of`.
    piece : str, optional
        Which of its `request.pieces` alone, that may be one of several contacts; by default all.
    """
    request = entry.request
    of, others = pieces.depends_on(request, piece) if piece else ("", frozenset())
    # Groups by what they are called, and their files by what they hold.
    given = {
        name: _placeless(value) if request.task.by_name[name].is_place else value
        for name, value in request.given.items()
        if name not in {GROUP.name, *others}
    }
    sizes = map(len, comparing.groups(request).values())
    groups = [list(group) for group in zip(comparing.labels(request), sizes, strict=True)]
    about = {"piece": of} if piece else {"groups": groups} if groups else {}
    inputs = pieces.inputs(request, piece) if piece else request.inputs
    return checksums.of_words(
        {
            "version": __version__,
            "task": request.task.name,
            "options": given,
            # The suffix tells the format.
            # What has no checksum may be another each time.
            "inputs": [[path.suffix.lower(), content(path) or uuid4().hex] for path in inputs],
            **about,
        }
    )


def _placeless(value: str | bool | list[str]) -> str | bool | list[str]:
    """Return paths without their folders."""
    if isinstance(value, list):
        return [Path(text).name for text in value]
    return Path(value).name if isinstance(value, str) else value


def _sums(paths: Iterable[Path]) -> dict[str, str]:
    return {path.name: checksums.of_file(path) for path in paths}
