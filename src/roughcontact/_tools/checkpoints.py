"""Checksums, and saved steps of a run in a folder, from which the same call resumes.

Checksums of arrays and JSON values are independent of their storage.

A record describes the problem of the steps. Each step is a separate file with a checksum, written
atomically. The folder is locked by one run at a time.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import files
from roughcontact._tools.arrays import Array
from roughcontact._tools.files import atomic_write, to_json, write_atomically
from roughcontact.errors import FormatError, InputError, OtherRunError


def checksum_array(values: ArrayLike) -> str:
    """Return the checksum of the dtype, the shape and the values of an array."""
    array = np.asarray(values)
    if array.dtype.kind not in "biufc":
        return checksum_json(["text", array.shape, array.tolist()])
    little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    result = hashlib.sha256(f"{little.dtype.str} {array.shape} ".encode())
    result.update(little.reshape(-1).view(np.uint8).data)
    return result.hexdigest()


def checksum_arrays(arrays: Mapping[str, ArrayLike]) -> str:
    """Return the checksum of arrays with their names, independent of their order."""
    return checksum_json({name: checksum_array(values) for name, values in arrays.items()})


def checksum_file(path: str | os.PathLike[str]) -> str:
    """Return the checksum of the bytes of a file."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def checksum_json(words: Any) -> str:
    """Return the checksum of JSON values, independent of the order of mappings."""
    text = json.dumps(words, sort_keys=True, default=_to_json_value)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _to_json_value(value: Any) -> Any:
    """Return a JSON value for an object that JSON does not support."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else repr(value)


Step = TypeVar("Step")


@dataclass(frozen=True)
class RunFolder:
    """Locked folder with the steps of a run."""

    folder: Path  # The folder, with the record in it
    problem: str  # Checksum of the inputs of the steps


@contextmanager
def lock_folder(
    folder: str | os.PathLike[str] | None,
    problem: Callable[[], Mapping[str, Any]],
    *,
    kind: str,
    record: str,
    pattern: str,
) -> Iterator[RunFolder | None]:
    """Lock the folder of a run, if any, and write its record or compare it with the problem."""
    if folder is None:
        yield None
        return
    folder = Path(folder)
    # With the types that JSON returns, for the comparison with the file.
    described: dict[str, Any] = json.loads(to_json(problem()))
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder", argument="folder")
    with _lock_exclusively(folder, f"{Path(record).stem}.lock", kind):
        path = folder / record
        if path.exists():
            _require_same(path, described, kind)
        elif any(folder.glob(pattern)):
            raise InputError(
                f"{folder} holds steps without {record}; give another folder", argument="folder"
            )
        else:
            try:
                write_atomically(path, to_json(described))
            except OSError as error:
                raise _closed_error(folder, f" ({error.strerror})") from None
        yield RunFolder(folder, checksum_json(described))


@contextmanager
def _lock_exclusively(folder: Path, name: str, kind: str) -> Iterator[None]:
    """Create and lock a folder, or raise `InputError`."""
    with ExitStack() as stack:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not os.access(folder, os.W_OK | os.X_OK):
                raise _closed_error(folder)
            stack.enter_context(files.file_lock(folder / name))
        except BlockingIOError:
            raise InputError(
                f"{folder} is in use: another {kind} is writing to it; let it finish, or give "
                "another folder",
                argument="folder",
            ) from None
        except OSError as error:
            raise _closed_error(folder, f" ({error.strerror})") from None
        yield


def _require_same(path: Path, described: dict[str, Any], kind: str) -> None:
    """Raise an error unless a record describes this problem."""
    try:
        before = json.loads(path.read_text(encoding="utf-8"))
        other = [name for name, value in described.items() if before.get(name) != value]
    except (OSError, ValueError, AttributeError):
        raise FormatError(f"{path} is damaged; give another folder") from None
    if other:
        verb = "differs" if len(other) == 1 else "differ"
        raise OtherRunError(
            f"{path.parent} holds another {kind}: {', '.join(other)} {verb}; give another "
            "folder, or remove this one to start again",
            argument="folder",
        )


def _closed_error(folder: Path, reason: str = "") -> InputError:
    return InputError(
        f"{folder} cannot be written to{reason}; give another folder", argument="folder"
    )


def pack_map(name: str, values: Array, index: str = "index") -> dict[str, NDArray[Any]]:
    """Return the values of a map that are not zero, and their places."""
    places = np.flatnonzero(values)
    return {index: places, name: values.ravel()[places]}


def unpack_map(
    arrays: Mapping[str, Any], name: str, shape: tuple[int, ...], index: str = "index"
) -> Array:
    """Return a map from its arrays of `pack_map`."""
    values = np.zeros(shape)
    values.ravel()[arrays[index]] = arrays[name]
    return values


def write_step(path: Path, step: Any, arrays: Mapping[str, Any], mark: Mapping[str, Any]) -> None:
    """Write the numbers and arrays of a finished step, atomically, with the mark of its run."""
    held = {**arrays, **asdict(step), **mark}
    try:
        with atomic_write(path) as stream:
            np.savez(stream, **held, checksum=checksum_arrays(held))
    except OSError as error:
        raise InputError(
            f"{path} cannot be written ({error.strerror}); earlier steps are saved"
        ) from None


def read_step(
    path: Path, step: type[Step], names: Sequence[str], mark: Mapping[str, Any], kind: str
) -> tuple[Step, dict[str, NDArray[Any]]]:
    """Return a step of `write_step` and its arrays; ``kind`` names the run in errors."""
    numbers = {
        item.name: int if item.type == "int" else float for item in fields(cast("Any", step))
    }
    try:
        with path.open("rb") as stream, np.load(stream) as stored:
            arrays = {name: stored[name] for name in (*names, *numbers, *mark)}
            sound = str(stored["checksum"]) == checksum_arrays(arrays)
    # NumPy and zipfile raise many types of errors on damaged files.
    except Exception as error:
        raise FormatError(
            f"{path} cannot be read as a step of a {kind} ({type(error).__name__}); remove it to "
            "solve it again"
        ) from None
    if not sound:
        raise FormatError(
            f"{path} was damaged or changed after it was written; remove it to solve it again"
        )
    if any(arrays[name].item() != value for name, value in mark.items()):
        raise FormatError(
            f"{path} is a step of another {kind} or of another load; remove it to solve it again"
        )
    return step(**{name: number(arrays[name]) for name, number in numbers.items()}), arrays


def digest_arrays(*parts: Any) -> str:
    """Return the SHA-256 digest of the shapes and values of arrays, in double precision."""
    result = hashlib.sha256()
    for part in parts:
        values = np.ascontiguousarray(part, dtype=np.float64)
        result.update(repr(values.shape).encode())
        result.update(values.tobytes())
    return result.hexdigest()
