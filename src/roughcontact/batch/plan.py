"""The contacts of a project, what each depends on, and which of them are complete."""

from __future__ import annotations

import base64
import contextlib
import importlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

from roughcontact._tools import checksums, files
from roughcontact._tools.files import to_json
from roughcontact._version import __version__
from roughcontact.analyses.compare import task as comparison
from roughcontact.errors import ArgumentRef
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
    """One contact of a project."""

    name: str  # Its name, and that of its files
    request: Request  # What to do
    summary: Path  # The JSON file that is written last
    contact: int


@dataclass(frozen=True)
class Report:
    """How one contact of a project ended."""

    name: str  # Of the contact
    state: str  # How it ended
    summary: Mapping[str, Any]  # What its JSON file says
    reason: str = ""  # Why it failed, in a sentence

    @property
    def last(self) -> Mapping[str, Any]:
        """The contact in a few numbers: of several loads the last, of those found the largest."""
        return dict(self.summary.get("last", self.summary))

    def record(self) -> dict[str, Any]:
        """Return its entry in JSON."""
        return {
            "name": self.name, "state": self.state, "told": self.summary, "reason": self.reason,
        }  # fmt: skip


def spell_key(mention: ArgumentRef, task: Command) -> str:
    """Return an argument in the words of project files."""
    option = task.named(mention.name)
    if option is None:
        return str(mention)
    if mention.value is None:
        return option.name
    if isinstance(mention.value, bool):
        return f"{option.name} = {str(mention.value).lower()}"
    return f"{option.name} = {json.dumps(option.text(mention.value), ensure_ascii=False)}"


def complete(entry: Entry, digest: str) -> dict[str, Any] | None:
    """Return the report of an earlier identical run whose output files are unchanged."""
    try:
        text = json.loads(entry.summary.read_text(encoding="utf-8"))
        if not isinstance(text, dict) or text.get("run") != digest:
            return None
        if text.pop("seal", None) != checksums.of_words(text):
            return None
        # Of a profile fewer figures are drawn than of a map.
        paths = [path for _, path in entry.request.places if path.name in text["sha256"]]
        if text["sha256"] != _sums(paths):
            return None
    except DAMAGED:
        return None
    return {**text, "written": [str(path) for path in paths]}


def sealed(text: Mapping[str, Any], digest: str, written: Iterable[Path]) -> dict[str, Any]:
    """Return what the JSON file of a contact holds, so that `complete` knows it again."""
    if taken := OWN & text.keys():
        raise ValueError(f"the file itself keeps {', '.join(sorted(taken))}")
    whole = json.loads(to_json({**text, "run": digest, "sha256": _sums(written)}))
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
    """Return a word for all that a contact depends on: options and content of files."""
    request = entry.request
    of, others = request.depends_on(piece) if piece else ("", frozenset())
    # Groups by name, their files by content.
    specified = {
        name: _placeless(value) if request.task.by_name[name].is_place else value
        for name, value in request.specified.items()
        if name not in {GROUP.name, *others}
    }
    sizes = map(len, comparison.groups(request).values())
    groups = [list(group) for group in zip(comparison.labels(request), sizes, strict=True)]
    about = {"piece": of} if piece else {"groups": groups} if groups else {}
    inputs = request.subtask_inputs(piece) if piece else request.inputs
    return checksums.of_words(
        {
            "version": __version__,
            "task": request.task.name,
            "options": specified,
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


# --- What is found of the pieces of a contact, kept on the disk for the runs to come ---


_PACKAGE = __name__.partition(".")[0]
# Above all that pieces take: a map of 64 parts under 100 loads has some 10 MB.
_MOST = 2**28


def place_of(entry: Entry) -> Path:
    """Return the folder of what is kept of a contact; there is none where nothing is."""
    return entry.summary.with_suffix(".pieces")


def keep(entry: Entry, digest: str, result: Any) -> None:
    """Keep what is found of a piece, if that can be done."""
    # A piece that cannot be saved is computed again by the next run.
    with contextlib.suppress(OSError, TypeError):
        described = {"run": digest, "found": _encode(result)}
        text = json.dumps({**described, "seal": checksums.of_words(described)})
        path = _file(entry, digest)
        path.parent.mkdir(parents=True, exist_ok=True)
        files.write(path, text)


def load_subtasks(entry: Entry, digests: Mapping[str, str]) -> dict[str, Any]:
    """Return what earlier runs found of pieces of a contact, by their words."""
    known = {}
    for word, digest in digests.items():
        with contextlib.suppress(*DAMAGED):
            path = _file(entry, digest)
            if path.stat().st_size > _MOST:
                continue
            read = json.loads(path.read_bytes())
            seal = read.pop("seal")
            if read["run"] == digest and seal == checksums.of_words(read):
                known[word] = _decode(read["found"])
    return known


def drop(entry: Entry, but: Iterable[str] = ()) -> None:
    """Remove what is kept of a contact that is complete."""
    place = place_of(entry)
    stay = {_file(entry, digest) for digest in but}
    with contextlib.suppress(OSError):
        files.clear(place)
        for path in set(place.glob("*.json")) - stay:
            path.unlink()
        if not stay:
            place.rmdir()


def _file(entry: Entry, digest: str) -> Path:
    return place_of(entry) / f"{digest}.json"


# Frozen dataclasses of plain values as JSON. Nothing is called in reading but what makes them:
# `pickle` would carry out whatever a file says.


def _encode(value: Any) -> Any:
    """Return a value as JSON has it, with the type of all that is no text, number or list."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if type(value) is list:
        return [_encode(item) for item in value]
    if type(value) is tuple:
        return {"tuple": [_encode(item) for item in value]}
    if isinstance(value, Enum):
        return {"enum": _name(type(value)), "value": _encode(value.value)}
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf":
        specified = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode("ascii")
        shape = list(value.shape) if isinstance(value, np.ndarray) else None
        return {"array": specified, "kind": value.dtype.str, "shape": shape}
    if isinstance(value, Mapping):
        return {"mapping": [[_encode(key), _encode(item)] for key, item in value.items()]}
    if is_dataclass(type(value)):
        held = {field.name: _encode(getattr(value, field.name)) for field in fields(value)}
        return {"class": _name(type(value)), "fields": held}
    raise TypeError(f"{type(value)} has no form in JSON here")


def _name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


def _decode(text: Any) -> Any:
    """Return the value that `_encode` described."""
    if isinstance(text, list):
        return [_decode(item) for item in text]
    if not isinstance(text, dict):
        return text
    if "tuple" in text:
        return tuple(_decode(text["tuple"]))
    if "enum" in text:
        return _class(text["enum"], Enum)(_decode(text["value"]))
    if "array" in text:
        values = np.frombuffer(base64.b64decode(text["array"]), text["kind"])
        return values[0] if text["shape"] is None else values.reshape(text["shape"]).copy()
    if "mapping" in text:
        return {_decode(key): _decode(item) for key, item in text["mapping"]}
    # As `copy` and `pickle` do it: what was checked when it was made is not made again.
    kind = _class(text["class"])
    if text["fields"].keys() != {field.name for field in fields(kind)}:
        raise TypeError(f"{kind} has other fields")
    created = object.__new__(kind)
    for name, value in text["fields"].items():
        object.__setattr__(created, name, _decode(value))
    return created


def _class(name: str, base: type = object) -> Any:
    """Return a dataclass or an enumeration of this package, of which there is no other."""
    module, _, own = name.partition(":")
    if module.partition(".")[0] != _PACKAGE:
        raise TypeError(f"{name} is not of this package")
    kind = getattr(importlib.import_module(module), own)
    if not isinstance(kind, type) or not issubclass(kind, base):
        raise TypeError(f"{name} is not what it is taken for")
    if base is object and not is_dataclass(kind):
        raise TypeError(f"{name} is no dataclass")
    return kind
