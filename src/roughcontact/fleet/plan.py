"""The contacts of a project, what each depends on, and which of them are complete."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact._version import __version__
from roughcontact.errors import Mention
from roughcontact.request.options import SOLVE, named, offered, text_of
from roughcontact.request.request import Request

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
    """

    name: str
    request: Request
    summary: Path


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
        """The contact in a few numbers: of a sweep or a history that at its end."""
        return dict(self.told.get("last", self.told))


def spell_key(mention: Mention, task: str) -> str:
    """Return an argument in the words of project files.

    Parameters
    ----------
    mention : Mention
        What a message speaks of.
    task : str
        Of the contact; an argument that it has no key for keeps its name.

    Returns
    -------
    str
        ``key``, or ``key = value``.

    Examples
    --------
    >>> spell_key(Mention("load", "1 N"), "solve")
    'load = "1 N"'
    """
    key = named(mention.name, task)
    if key is None:
        return str(mention)
    if mention.value is None:
        return key
    if isinstance(mention.value, bool):
        return f"{key} = {str(mention.value).lower()}"
    return f"{key} = {json.dumps(text_of(mention.value, offered(task)[key]), ensure_ascii=False)}"


def finished(entries: list[Entry]) -> list[Path]:
    """Return the JSON files of the contacts that are complete."""
    return [entry.summary for entry in entries if complete(entry, digest_of(entry)) is not None]


def complete(entry: Entry, digest: str) -> dict[str, Any] | None:
    """Return what an earlier run told, if it was the same and all of its files are there."""
    try:
        told = json.loads(entry.summary.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    same = isinstance(told, dict) and told.get("run") == digest
    if not same or not all(Path(path).exists() for path in told.get("written", ())):
        return None
    return dict(told)


def digest_of(entry: Entry) -> str:
    """Return a number for all that a contact depends on."""
    request = entry.request
    digest = hashlib.sha256(__version__.encode())
    # A solve is what a contact is unless another task is named.
    task = {} if request.task == SOLVE else {"task": request.task}
    digest.update(json.dumps({**request.given, **task}, sort_keys=True).encode())
    for path in request.inputs:
        try:
            # What a device or a pipe gives has no end, or is gone then.
            if not path.is_file():
                raise FileNotFoundError(path)
            with path.open("rb") as stream:
                for block in iter(partial(stream.read, 2**20), b""):
                    digest.update(block)
        # Reading it will say what is wrong.
        except OSError:
            digest.update(b"absent")
    return digest.hexdigest()
