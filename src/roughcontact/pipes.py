"""What is given as a file, as a regular file: one that a reader may open again and search."""

from __future__ import annotations

import os
import select
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from roughcontact.errors import FormatError

MOST = 2**30
"""Most bytes that a pipe may give; they lie in a temporary file while they are read."""

_BLOCK = 2**20
# Seconds for whoever waits to write to a named pipe, and now can.
_PATIENCE = 1.0


@contextmanager
def regular(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a regular file for as long as the block takes.

    Parameters
    ----------
    path : str or path
        A regular file, or a pipe such as a shell makes of ``<(zcat map.csv.gz)``.

    Yields
    ------
    Path
        The file itself; of a pipe, a copy under its name of all that it gave.

    Raises
    ------
    FormatError
        If it is a device or a socket, or a pipe that nobody writes to, or that gives more than
        `MOST` bytes.
    OSError
        If it is not there.
    """
    path = Path(path)
    mode = path.stat().st_mode
    if stat.S_ISFIFO(mode):
        with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
            copy = Path(folder) / path.name
            _copy(path, copy)
            yield copy
    elif stat.S_ISREG(mode):
        yield path
    else:
        raise FormatError(f"{path} is no regular file; copy it into one")


def _copy(pipe: Path, target: Path) -> None:
    """Write all that a pipe gives into a file."""
    size, written_to = 0, False
    end = time.monotonic() + _PATIENCE
    # With O_NONBLOCK a named pipe opens at once, and reading tells whether anybody writes to it.
    with os.fdopen(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), "rb", 0) as source:
        with target.open("xb") as copy:
            while size <= MOST:
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
        f"{pipe} is a pipe that gives more than {MOST / 2**30:.0f} GiB; write that into a file"
    )
