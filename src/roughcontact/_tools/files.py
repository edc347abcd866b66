"""Atomic file writes, checks of output paths, and JSON.

`atomic_write`: The bytes are written to a hidden file in the same folder, which is locked
meanwhile. A hidden file without a lock was left by a killed process; the next writer removes it if
it is among the first files of the folder.

`file_lock`: A lock of the operating system on an open file (``flock``, on Windows
``msvcrt.locking``). On a file system without locks every process obtains it.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import os
import re
import stat
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from roughcontact.errors import FormatError, input_error

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl


# Name of an unfinished file, random to avoid collisions.
_UNFINISHED = re.compile(r"\.roughcontact-[0-9a-f]{16}\.part")
# Files of a folder that each writer checks: a check of all is slow in a folder of 10 000 contacts.
_MAX_LISTED = 1000


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[IO[bytes]]:
    """Yield a stream whose bytes become the file at the end, completely or not at all."""
    target = Path(path)
    try:
        remove_unfinished(target.parent, _MAX_LISTED)
        created: list[Path] = []
        try:
            stream, temporary = _create_locked(target.parent, created)
            with stream:
                yield stream
                stream.flush()
                os.fsync(stream.fileno())
                if sys.platform != "win32":
                    # Rename while locked: closing the stream releases the lock.
                    os.replace(temporary, target)
            if sys.platform == "win32":
                # Windows cannot rename an open file.
                os.replace(temporary, target)
        finally:
            for path in created:
                path.unlink(missing_ok=True)
    except OSError as error:
        # The error of a failed write has no name, and the hidden name means nothing to the user.
        hidden = error.filename is None or _UNFINISHED.fullmatch(Path(error.filename).name)
        if error.errno is not None and hidden:
            raise OSError(error.errno, error.strerror, str(target)) from error
        raise


def write_atomically(path: str | os.PathLike[str], content: str | bytes | memoryview) -> None:
    """Write a file completely or not at all; see `atomic_write`."""
    with atomic_write(path) as stream:
        stream.write(content.encode("utf-8") if isinstance(content, str) else content)


def remove_unfinished(folder: str | os.PathLike[str], maximum: int | None = None) -> None:
    """Remove the unfinished files that killed processes left in a folder."""
    if sys.platform == "win32":
        return
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in itertools.islice(entries, maximum):
            if _UNFINISHED.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                with contextlib.suppress(OSError), open(entry.path, "rb+") as stream:
                    fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(entry.path)


def _create_locked(folder: Path, created: list[Path]) -> tuple[IO[bytes], Path]:
    """Return an empty, locked hidden file and its path, which is in ``created`` before it exists.

    A signal may end the process before this function returns.
    """
    while True:
        # A separate name for every call: threads may write the same file, and the last one remains.
        path = folder / f".roughcontact-{os.urandom(8).hex()}.part"
        created.append(path)
        stream = path.open("x+b")
        try:
            if sys.platform != "win32":
                # Shared: a reader that locks files, as HDF5 does, can open it meanwhile.
                _lock(stream, shared=True)
            if path.exists():
                return stream, path
        except BlockingIOError:
            pass
        except BaseException:
            stream.close()
            raise
        # Before the lock another process took this file for an abandoned one, and removes it.
        stream.close()


def _lock(stream: IO[bytes], *, shared: bool = False) -> None:
    """Lock an open file, or raise `BlockingIOError`; do nothing if its file system has no locks."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(stream, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except OSError as error:
        if sys.platform == "win32" or isinstance(error, BlockingIOError):
            raise BlockingIOError from None


def require_suffix(path: str | os.PathLike[str], *suffixes: str) -> None:
    """Raise `InputError` unless a file name ends in one of the suffixes."""
    if Path(path).suffix.lower() not in suffixes:
        raise input_error("path", str(path), f"must end in {' or '.join(suffixes)}")


def to_json(values: Mapping[str, Any]) -> str:
    """Return values as JSON text; values that are not finite become null."""
    return json.dumps(_replace_non_finite(values), indent=2, allow_nan=False)


def _replace_non_finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _replace_non_finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_replace_non_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def file_lock(path: str | os.PathLike[str]) -> Iterator[None]:
    """Hold a file lock during the block, or raise `BlockingIOError`."""
    file = Path(path)
    stream = _locks_locked(file)
    try:
        yield
    finally:
        # Windows cannot remove an open file; elsewhere an unlocked file may be locked by another.
        if sys.platform == "win32":
            stream.close()
        with contextlib.suppress(OSError):
            file.unlink()
        stream.close()


def _locks_locked(file: Path) -> IO[bytes]:
    """Open and lock a lock file, and return its stream."""
    while True:
        stream = file.open("ab")
        try:
            _lock(stream)
            # The previous holder may have removed the file before this lock.
            if os.path.samestat(os.fstat(stream.fileno()), file.stat()):
                return stream
        except FileNotFoundError:
            pass
        except BaseException:
            stream.close()
            raise
        stream.close()


MAX_PIPE_BYTES = 2**30
"""Largest number of bytes read from a pipe into a temporary file."""

_BLOCK = 2**20


@contextmanager
def as_regular_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a regular file during the block: the file itself, or a copy of a pipe."""
    path = Path(path)
    mode = path.stat().st_mode
    if stat.S_ISFIFO(mode):
        with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
            copy = Path(folder) / path.name
            _copy_stream(path, copy)
            yield copy
    elif stat.S_ISREG(mode):
        yield path
    else:
        raise FormatError(f"{path} is not a regular file; copy its content into one")


def _copy_stream(pipe: Path, target: Path) -> None:
    """Copy the content of a pipe to a file, from the start of its writer to the end."""
    with pipe.open("rb") as source, target.open("xb") as copy:
        while block := source.read(_BLOCK):
            copy.write(block)
            if copy.tell() > MAX_PIPE_BYTES:
                raise FormatError(
                    f"{pipe} is a pipe that gives more than {MAX_PIPE_BYTES / 2**30:.0f} GiB; "
                    "write that into a file"
                )
