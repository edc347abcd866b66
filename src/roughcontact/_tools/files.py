"""Atomic file writes, checks of output paths, and JSON.

`atomic_write`: The bytes go to a hidden file in the same folder, which is locked as long as it
is written to. One without a lock was left by a process that was killed, and the next writer
removes it if it comes upon it among the first files of the folder.

`file_lock`: The lock is that of the system on an open file (``flock``, on Windows
``msvcrt.locking``). Where a file system has none, everybody holds it.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import os
import re
import select
import stat
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from roughcontact.errors import FormatError, input_error

try:
    import fcntl
except ImportError:
    # Windows.
    fcntl = None  # type: ignore[assignment]


# Name of an unfinished file, random to avoid collisions.
_UNFINISHED = re.compile(r"\.roughcontact-[0-9a-f]{16}\.part")
# Files of a folder that each writer looks at: to look at all would make ten thousand contacts slow.
_MAX_LISTED = 1000


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[IO[bytes]]:
    """Give a stream whose bytes become a file at the end, all of them or none."""
    target = Path(path)
    try:
        remove_unfinished(target.parent, _MAX_LISTED)
        stream, temporary = _create_locked(target.parent)
        try:
            with stream:
                yield stream
                stream.flush()
                os.fsync(stream.fileno())
                if fcntl is not None:
                    # Renamed before the lock ends with the stream.
                    os.replace(temporary, target)
            if fcntl is None:
                # Windows renames no open file.
                os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        # The error of a failed write must not show the hidden name.
        hidden = error.filename is None or _UNFINISHED.fullmatch(Path(error.filename).name)
        if error.errno is not None and hidden:
            raise OSError(error.errno, error.strerror, str(target)) from error
        raise


def write_atomically(path: str | os.PathLike[str], content: str | bytes | memoryview) -> None:
    """Write a file, all of it or nothing; see `atomic_write`."""
    with atomic_write(path) as stream:
        stream.write(content.encode("utf-8") if isinstance(content, str) else content)


def remove_unfinished(folder: str | os.PathLike[str], maximum: int | None = None) -> None:
    """Remove the unfinished files that killed processes left in a folder."""
    if fcntl is None:
        return
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in itertools.islice(entries, maximum):
            if _UNFINISHED.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                with contextlib.suppress(OSError), open(entry.path, "rb+") as stream:
                    fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(entry.path)


@contextmanager
def hold_marker_file(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a hidden file that is there as long as the block lasts."""
    stream, path = _create_locked(Path(folder))
    try:
        with stream:
            yield path
    finally:
        path.unlink(missing_ok=True)


def _create_locked(folder: Path) -> tuple[IO[bytes], Path]:
    """Return an empty hidden file that is locked, and its name."""
    while True:
        # A separate name for every call: threads may write the same file, and the last one remains.
        path = folder / f".roughcontact-{os.urandom(8).hex()}.part"
        stream = path.open("x+b")
        if _try_lock(stream) and path.exists():
            return stream, path
        # Another process took it for a left one before it was locked, and removes it.
        stream.close()


def _try_lock(stream: IO[bytes]) -> bool:
    """Lock a file if possible, and return whether no other process is removing it."""
    if fcntl is not None:
        try:
            # Shared: a reader that locks files, as HDF5 does, may look at once.
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            # Some file systems have no locks; there no process removes anything.
            pass
    return True


def require_suffix(path: str | os.PathLike[str], *suffixes: str) -> None:
    """Raise `InputError` unless a file is named for a format that it can have."""
    if Path(path).suffix.lower() not in suffixes:
        raise input_error("path", str(path), f"must end in {' or '.join(suffixes)}")


def to_json(values: Mapping[str, Any]) -> str:
    """Return JSON text."""
    return json.dumps(_replace_non_finite(values), indent=2, allow_nan=False)


def _replace_non_finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _replace_non_finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_replace_non_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


# --- Locks that end with their process, however it ends ---


if sys.platform == "win32":
    import msvcrt

    def _take(stream: IO[bytes]) -> None:
        try:
            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            raise BlockingIOError from None

else:
    import fcntl

    def _take(stream: IO[bytes]) -> None:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:
            # A file system without locks.
            pass


@contextmanager
def file_lock(path: str | os.PathLike[str]) -> Iterator[None]:
    """Hold a lock as long as the block lasts."""
    file = Path(path)
    stream = _locks_locked(file)
    try:
        yield
    finally:
        # Windows removes no open file; elsewhere, once it is unlocked, the file is another's.
        if sys.platform == "win32":
            stream.close()
        with contextlib.suppress(OSError):
            file.unlink()
        stream.close()


def _locks_locked(file: Path) -> IO[bytes]:
    """Return the file of a lock, open and locked."""
    while True:
        stream = file.open("ab")
        try:
            _take(stream)
            # Its last holder may have removed it before it was locked.
            if os.path.samestat(os.fstat(stream.fileno()), file.stat()):
                return stream
        except FileNotFoundError:
            pass
        except BaseException:
            stream.close()
            raise
        stream.close()


# --- Input streams as regular files that a reader may open again and search ---


MAX_PIPE_BYTES = 2**30
"""Largest number of bytes from a pipe; they are stored in a temporary file."""

_BLOCK = 2**20
# Seconds for a process that waits to write to a named pipe.
_PIPE_TIMEOUT = 1.0


@contextmanager
def as_regular_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a regular file for as long as the block takes."""
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
        raise FormatError(f"{path} is no regular file; copy it into one")


def _copy_stream(pipe: Path, target: Path) -> None:
    """Write all that a pipe gives into a file."""
    size, written_to = 0, False
    end = time.monotonic() + _PIPE_TIMEOUT
    # With O_NONBLOCK a named pipe opens immediately; reading detects whether it has a writer.
    with (
        os.fdopen(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), "rb", 0) as source,
        target.open("xb") as copy,
    ):
        while size <= MAX_PIPE_BYTES:
            block = source.read(_BLOCK)
            if block:
                size += copy.write(block)
            elif block is None:
                written_to = True
                select.select([source], [], [])
            elif size or written_to:
                return
            elif time.monotonic() > end:
                raise FormatError(
                    f"{pipe} is a pipe that nobody writes to; start what writes to it, or "
                    "give a file"
                )
            else:
                time.sleep(0.01)
    raise FormatError(
        f"{pipe} is a pipe that gives more than {MAX_PIPE_BYTES / 2**30:.0f} GiB; write that into "
        "a file"
    )
