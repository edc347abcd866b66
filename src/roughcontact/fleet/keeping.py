"""What is found of the pieces of a contact, kept on the disk for the runs to come."""

from __future__ import annotations

import base64
import contextlib
import importlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact import checksums, files
from roughcontact.fleet.plan import DAMAGED, Entry

_PACKAGE = __name__.partition(".")[0]
# Above all that pieces take: a map of 64 parts under 100 loads has some 10 MB.
_MOST = 2**28


def place_of(entry: Entry) -> Path:
    """Return the folder of what is kept of a contact; there is none where nothing is."""
    return entry.summary.with_suffix(".pieces")


def keep(entry: Entry, digest: str, found: Any) -> None:
    """Keep what is found of a piece, if that can be done.

    Parameters
    ----------
    entry : Entry
        The contact.
    digest : str
        What the piece depends on, from `plan.digest_of`.
    found : object
        What was found.
    """
    # Whatever cannot be kept is found once more by the next run.
    with contextlib.suppress(OSError, TypeError):
        described = {"run": digest, "found": _described(found)}
        text = json.dumps({**described, "seal": checksums.of_words(described)})
        path = _file(entry, digest)
        path.parent.mkdir(parents=True, exist_ok=True)
        files.write(path, text)


def kept(entry: Entry, digests: Mapping[str, str]) -> dict[str, Any]:
    """Return what earlier runs found of pieces of a contact, by their words.

    Parameters
    ----------
    entry : Entry
        The contact.
    digests : mapping of str to str
        What each of its `request.pieces` depends on now.

    Returns
    -------
    dict
        What was found, to the bit. What is missing in it was not kept, depends on something
        else, or is damaged.
    """
    known = {}
    for word, digest in digests.items():
        with contextlib.suppress(*DAMAGED):
            path = _file(entry, digest)
            if path.stat().st_size > _MOST:
                continue
            read = json.loads(path.read_bytes())
            seal = read.pop("seal")
            if read["run"] == digest and seal == checksums.of_words(read):
                known[word] = _made(read["found"])
    return known


def drop(entry: Entry, but: Iterable[str] = ()) -> None:
    """Remove what is kept of a contact that is complete.

    Parameters
    ----------
    entry : Entry
        The contact.
    but : iterable of str
        What those pieces depend on that stay.
    """
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


def _described(value: Any) -> Any:
    """Return a value as JSON has it, with the type of all that is no text, number or list."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if type(value) is list:
        return [_described(one) for one in value]
    if type(value) is tuple:
        return {"tuple": [_described(one) for one in value]}
    if isinstance(value, Enum):
        return {"enum": _name(type(value)), "value": _described(value.value)}
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf":
        given = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode("ascii")
        shape = list(value.shape) if isinstance(value, np.ndarray) else None
        return {"array": given, "kind": value.dtype.str, "shape": shape}
    if isinstance(value, Mapping):
        return {"mapping": [[_described(key), _described(one)] for key, one in value.items()]}
    if is_dataclass(type(value)):
        held = {field.name: _described(getattr(value, field.name)) for field in fields(value)}
        return {"class": _name(type(value)), "fields": held}
    raise TypeError(f"{type(value)} has no form in JSON here")


def _name(kind: type) -> str:
    return f"{kind.__module__}:{kind.__qualname__}"


def _made(told: Any) -> Any:
    """Return the value that `_described` described."""
    if isinstance(told, list):
        return [_made(one) for one in told]
    if not isinstance(told, dict):
        return told
    if "tuple" in told:
        return tuple(_made(told["tuple"]))
    if "enum" in told:
        return _class(told["enum"], Enum)(_made(told["value"]))
    if "array" in told:
        values = np.frombuffer(base64.b64decode(told["array"]), told["kind"])
        return values[0] if told["shape"] is None else values.reshape(told["shape"]).copy()
    if "mapping" in told:
        return {_made(key): _made(one) for key, one in told["mapping"]}
    # As `copy` and `pickle` do it: what was checked when it was made is not made again.
    kind = _class(told["class"])
    if told["fields"].keys() != {field.name for field in fields(kind)}:
        raise TypeError(f"{kind} has other fields")
    made = object.__new__(kind)
    for name, value in told["fields"].items():
        object.__setattr__(made, name, _made(value))
    return made


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
