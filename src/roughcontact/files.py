"""Files that are whole or not there, places where they may go, and JSON."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from roughcontact.errors import InputError

try:
    import fcntl
except ImportError:
    # Windows.
    fcntl = None  # type: ignore[assignment]


# What a writer works on until it is complete: nobody names a file like this by chance.
_UNFINISHED = re.compile(r"\.roughcontact-[0-9a-f]{16}\.part")
# Files of a folder that each writer looks at: to look at all would make ten thousand contacts slow.
_FEW = 1000


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[IO[bytes]]:
    """Give a stream whose bytes become a file at the end, all of them or none.

    Parameters
    ----------
    path : str or path
        The file wanted.

    Yields
    ------
    binary stream
        Where to write; it can seek. What was written is on the disk before it gets its name, so
        that a power cut leaves the old file or the new one.

    Raises
    ------
    OSError
        If the bytes cannot be written; it names the file wanted. Whatever ends the block early
        leaves the old file, and nothing new.

    Notes
    -----
    The bytes go to a hidden file in the same folder, which is locked as long as it is written to.
    One without a lock was left by a process that was killed, and the next writer removes it if it
    comes upon it among the first files of the folder.
    """
    target = Path(path)
    try:
        clear(target.parent, _FEW)
        stream, temporary = _begun(target.parent)
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
        # A failed write knows no name, and the hidden name is nobody's business.
        hidden = error.filename is None or _UNFINISHED.fullmatch(Path(error.filename).name)
        if error.errno is not None and hidden:
            raise OSError(error.errno, error.strerror, str(target)) from error
        raise


def write(path: str | os.PathLike[str], content: str | bytes | memoryview) -> None:
    """Write a file, all of it or nothing; see `replacing`.

    Parameters
    ----------
    path : str or path
        The file wanted.
    content : str or bytes
        What it is to hold; text in UTF-8.

    Raises
    ------
    OSError
        If it cannot be written; an old file survives.
    """
    with replacing(path) as stream:
        stream.write(content.encode("utf-8") if isinstance(content, str) else content)


def clear(folder: str | os.PathLike[str], most: int | None = None) -> None:
    """Remove the unfinished files that killed processes left in a folder.

    Parameters
    ----------
    folder : str or path
        The folder. Files that are being written to, by whatever process on whatever machine, are
        locked and stay; so does everything where there are no locks.
    most : int, optional
        Of how many of its files, in no order; by default of all.
    """
    if fcntl is None:
        return
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in itertools.islice(entries, most):
            if _UNFINISHED.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                with contextlib.suppress(OSError), open(entry.path, "rb+") as stream:
                    fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(entry.path)


@contextmanager
def marked(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a hidden file that is there as long as the block lasts.

    Parameters
    ----------
    folder : str or path
        The folder. Who finds the file by its name sees the same folder, on whatever machine.

    Yields
    ------
    Path
        The file, empty and locked. What a killed process leaves of it is removed by the next
        writer.
    """
    stream, path = _begun(Path(folder))
    try:
        with stream:
            yield path
    finally:
        path.unlink(missing_ok=True)


def _begun(folder: Path) -> tuple[IO[bytes], Path]:
    """Return an empty hidden file that is locked, and its name."""
    while True:
        # A name of its own for every call: threads may write the same file, and the last one stays.
        path = folder / f".roughcontact-{os.urandom(8).hex()}.part"
        stream = path.open("x+b")
        if _locked(stream) and path.exists():
            return stream, path
        # Another process took it for a left one before it was locked, and removes it.
        stream.close()


def _locked(stream: IO[bytes]) -> bool:
    """Lock a file where that can be done, and return whether nobody is removing it."""
    if fcntl is not None:
        try:
            # Shared: a reader that locks files, as HDF5 does, may look at once.
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            # Some file systems have no locks; there nobody removes anything.
            pass
    return True


def require_suffix(path: str | os.PathLike[str], *suffixes: str) -> None:
    """Raise `InputError` unless a file is named for a format that it can have.

    Parameters
    ----------
    path : str or path
        The file wanted.
    *suffixes : str
        How it may end, such as ``".nc"``.
    """
    if Path(path).suffix.lower() not in suffixes:
        raise InputError(
            f"must end in {' or '.join(suffixes)}, got {str(path)!r}",
            argument="path",
            value=str(path),
        )


def to_json(values: Mapping[str, Any]) -> str:
    """Return JSON text.

    Parameters
    ----------
    values : mapping
        Numbers, words, lists and dictionaries of them.

    Returns
    -------
    str
        Text that every reader of JSON takes: what is not finite, of which JSON knows nothing,
        is ``null``.

    Examples
    --------
    >>> print(to_json({"young": float("inf"), "poisson": 0.5}))
    {
      "young": null,
      "poisson": 0.5
    }
    """
    return json.dumps(_finite(values), indent=2, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
