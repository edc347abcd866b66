"""Contacts of a project: their digests, complete results and saved subtasks."""

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

from roughcontact._tools import checkpoints, files
from roughcontact._tools.files import to_json
from roughcontact._version import __version__
from roughcontact.analyses.compare import task as comparison
from roughcontact.errors import ArgumentRef
from roughcontact.request.options import GROUP
from roughcontact.request.request import Request
from roughcontact.request.task import Command

RUN_KEYS = frozenset({"run", "sha256", "seal"})
"""Keys of the summary of a contact in addition to its quantities."""

DAMAGED_FILE_ERRORS = (
    OSError,
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ImportError,
    RecursionError,
)
"""Errors raised while reading a damaged file of an earlier run."""

SOLVED, KEPT, FAILED = "solved", "solved before", "failed"


@dataclass(frozen=True)
class Entry:
    """One contact of a project."""

    name: str  # Name in reports; file names derive from it
    request: Request  # Options and input files
    summary: Path  # JSON file, written last
    contact: int  # Number of the contact: its entries share maps and load


@dataclass(frozen=True)
class ContactReport:
    """Outcome of one contact of a project."""

    name: str  # Name of the contact
    state: str  # `SOLVED`, `KEPT` or `FAILED`
    summary: Mapping[str, Any]  # Content of its JSON file
    reason: str = ""  # Reason of the failure, one sentence

    @property
    def last(self) -> Mapping[str, Any]:
        """Main quantities: of the last or largest of several loads, else of the contact."""
        return dict(self.summary.get("last", self.summary))

    def record(self) -> dict[str, Any]:
        """Return the report as values for JSON."""
        return {name: getattr(self, name) for name in ("name", "state", "summary", "reason")}


def spell_key(mention: ArgumentRef, task: Command) -> str:
    """Return an argument, and its value if any, as spelled in project files."""
    option = task.option_of_argument(mention.name)
    if option is None:
        return str(mention)
    if mention.value is None:
        return option.name
    if isinstance(mention.value, bool):
        return f"{option.name} = {str(mention.value).lower()}"
    return f"{option.name} = {json.dumps(option.text(mention.value), ensure_ascii=False)}"


def find_complete(entry: Entry, digest: str) -> dict[str, Any] | None:
    """Return the summary of an identical earlier run with unchanged files, or None."""
    try:
        text = json.loads(entry.summary.read_text(encoding="utf-8"))
        if not isinstance(text, dict) or text.get("run") != digest:
            return None
        if text.pop("seal", None) != checkpoints.checksum_json(text):
            return None
        # A profile has fewer figures than a map.
        paths = [path for _, path in entry.request.places if path.name in text["sha256"]]
        if text["sha256"] != _file_checksums(paths):
            return None
    except DAMAGED_FILE_ERRORS:
        return None
    return {**text, "written": [str(path) for path in paths]}


def seal_summary(text: Mapping[str, Any], digest: str, written: Iterable[Path]) -> dict[str, Any]:
    """Return the content of the JSON file of a contact, sealed for `find_complete`."""
    if taken := RUN_KEYS & text.keys():
        raise ValueError(f"the file itself keeps {', '.join(sorted(taken))}")
    whole = json.loads(to_json({**text, "run": digest, "sha256": _file_checksums(written)}))
    return {**whole, "seal": checkpoints.checksum_json(whole)}


def checksum_if_readable(path: Path) -> str | None:
    """Return the checksum of a regular file; None for other or unreadable files."""
    try:
        # A device or a pipe has no end, or can be read only once.
        return checkpoints.checksum_file(path) if path.is_file() else None
    except OSError:
        return None


def request_digest(
    entry: Entry, content: Callable[[Path], str | None] = checksum_if_readable, piece: str = ""
) -> str:
    """Return the digest of the version, the options and the input files of a contact."""
    request = entry.request
    of, others = request.depends_on(piece) if piece else ("", frozenset())
    # Groups by name and size, their files by content.
    specified = {
        name: _strip_folders(value) if request.task.by_name[name].is_place else value
        for name, value in request.specified.items()
        if name not in {GROUP.name, *others}
    }
    sizes = map(len, comparison.groups(request).values())
    groups = [list(group) for group in zip(comparison.labels(request), sizes, strict=True)]
    about = {"piece": of} if piece else {"groups": groups} if groups else {}
    inputs = request.subtask_inputs(piece) if piece else request.read_files
    return checkpoints.checksum_json(
        {
            "version": __version__,
            "task": request.task.name,
            "options": specified,
            # The suffix gives the format; a file without a checksum may change.
            "inputs": [[path.suffix.lower(), content(path) or uuid4().hex] for path in inputs],
            **about,
        }
    )


def _strip_folders(value: str | bool | list[str]) -> str | bool | list[str]:
    """Return paths without their folders."""
    if isinstance(value, list):
        return [Path(text).name for text in value]
    return Path(value).name if isinstance(value, str) else value


def _file_checksums(paths: Iterable[Path]) -> dict[str, str]:
    return {path.name: checkpoints.checksum_file(path) for path in paths}


_PACKAGE = __name__.partition(".")[0]
# Above the size of any subtask: a map of 64 parts under 100 loads has about 10 MB.
_MAX_PIECE_BYTES = 2**28


def pieces_folder(entry: Entry) -> Path:
    """Return the folder of the saved subtasks of a contact, which may not exist."""
    return entry.summary.with_suffix(".pieces")


def save_piece(entry: Entry, digest: str, result: Any) -> None:
    """Save the result of a subtask, if possible."""
    # The next run computes a subtask again that could not be saved.
    with contextlib.suppress(OSError, TypeError):
        described = {"run": digest, "found": _encode_value(result)}
        text = json.dumps({**described, "seal": checkpoints.checksum_json(described)})
        path = _piece_path(entry, digest)
        path.parent.mkdir(parents=True, exist_ok=True)
        files.write_atomically(path, text)


def load_subtasks(entry: Entry, digests: Mapping[str, str]) -> dict[str, Any]:
    """Return the results of finished subtasks of a contact, by their names."""
    known = {}
    for word, digest in digests.items():
        with contextlib.suppress(*DAMAGED_FILE_ERRORS):
            path = _piece_path(entry, digest)
            if path.stat().st_size > _MAX_PIECE_BYTES:
                continue
            read = json.loads(path.read_bytes())
            seal = read.pop("seal")
            if read["run"] == digest and seal == checkpoints.checksum_json(read):
                known[word] = _decode_value(read["found"])
    return known


def remove_pieces(entry: Entry, but: Iterable[str] = ()) -> None:
    """Remove the saved subtasks of a contact, except those with some digests."""
    place = pieces_folder(entry)
    stay = {_piece_path(entry, digest) for digest in but}
    with contextlib.suppress(OSError):
        files.remove_unfinished(place)
        for path in set(place.glob("*.json")) - stay:
            path.unlink()
        if not stay:
            place.rmdir()


def _piece_path(entry: Entry, digest: str) -> Path:
    return pieces_folder(entry) / f"{digest}.json"


# Frozen dataclasses of plain values as JSON. Reading creates only classes of this package:
# `pickle` would execute code from a file.


def _encode_value(value: Any) -> Any:
    """Return a value for JSON, with its type unless it is a text, number or list."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if type(value) is list:
        return [_encode_value(item) for item in value]
    if type(value) is tuple:
        return {"tuple": [_encode_value(item) for item in value]}
    if isinstance(value, Enum):
        return {"enum": _type_name(type(value)), "value": _encode_value(value.value)}
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf":
        specified = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode("ascii")
        shape = list(value.shape) if isinstance(value, np.ndarray) else None
        return {"array": specified, "kind": value.dtype.str, "shape": shape}
    if isinstance(value, Mapping):
        return {
            "mapping": [[_encode_value(key), _encode_value(item)] for key, item in value.items()]
        }
    if is_dataclass(type(value)):
        held = {field.name: _encode_value(getattr(value, field.name)) for field in fields(value)}
        return {"class": _type_name(type(value)), "fields": held}
    raise TypeError(f"{type(value)} has no form in JSON here")


def _type_name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


def _decode_value(text: Any) -> Any:
    """Return the value that `_encode_value` encoded."""
    if isinstance(text, list):
        return [_decode_value(item) for item in text]
    if not isinstance(text, dict):
        return text
    if "tuple" in text:
        return tuple(_decode_value(text["tuple"]))
    if "enum" in text:
        return _find_class(text["enum"], Enum)(_decode_value(text["value"]))
    if "array" in text:
        values = np.frombuffer(base64.b64decode(text["array"]), text["kind"])
        return values[0] if text["shape"] is None else values.reshape(text["shape"]).copy()
    if "mapping" in text:
        return {_decode_value(key): _decode_value(item) for key, item in text["mapping"]}
    # Like `copy` and `pickle`, without the constructor: the values were checked before.
    kind = _find_class(text["class"])
    if text["fields"].keys() != {field.name for field in fields(kind)}:
        raise TypeError(f"{kind} has other fields")
    created = object.__new__(kind)
    for name, value in text["fields"].items():
        object.__setattr__(created, name, _decode_value(value))
    return created


def _find_class(name: str, base: type = object) -> Any:
    """Return a dataclass, or a subclass of ``base``, of this package by its name."""
    module, _, own = name.partition(":")
    if module.partition(".")[0] != _PACKAGE:
        raise TypeError(f"{name} is not of this package")
    kind = getattr(importlib.import_module(module), own)
    if not isinstance(kind, type) or not issubclass(kind, base):
        raise TypeError(f"{name} is not of the expected type")
    if base is object and not is_dataclass(kind):
        raise TypeError(f"{name} is no dataclass")
    return kind
