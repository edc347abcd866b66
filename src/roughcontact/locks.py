"""Locks that end with their process, however it ends."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

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
def held(path: str | os.PathLike[str]) -> Iterator[None]:
    """Hold a lock as long as the block lasts.

    Parameters
    ----------
    path : str or path
        A file that nobody needs: it is made, and removed at the end. One that a killed process
        left behind is not locked, and taken over.

    Raises
    ------
    BlockingIOError
        If another process or thread holds it.
    OSError
        If the file cannot be made.

    Notes
    -----
    The lock is that of the system on an open file (``flock``, on Windows ``msvcrt.locking``).
    Where a file system has none, everybody holds it.
    """
    file = Path(path)
    stream = _locked(file)
    try:
        yield
    finally:
        # Windows removes no open file; elsewhere, once it is unlocked, the file is another's.
        if sys.platform == "win32":
            stream.close()
        with contextlib.suppress(OSError):
            file.unlink()
        stream.close()


def _locked(file: Path) -> IO[bytes]:
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
