"""How much memory is free, and what to say where a job needs more."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from roughcontact.errors import InsufficientMemoryError, Part

GIB = 2**30

# Version 1 has a number for no limit, the largest one in whole pages.
_NO_LIMIT = 2**62


class _Group(NamedTuple):
    """Where a version of Linux's control groups keeps what it knows of a container's memory."""

    controller: str
    mount: str
    limits: tuple[str, ...]
    used: str
    # Of what is used, the files that the kernel drops before it refuses anything.
    droppable: str


_GROUPS = (
    _Group("", "sys/fs/cgroup", ("memory.max", "memory.high"), "memory.current", "inactive_file"),
    _Group(
        "memory", "sys/fs/cgroup/memory", ("memory.limit_in_bytes",), "memory.usage_in_bytes",
        "total_inactive_file",
    ),
)  # fmt: skip


def free() -> int:
    """Return the bytes that a new array may take now.

    Returns
    -------
    int
        The least of what the machine has left, the containers around this process, and its own
        limits of address space and data (``ulimit -v``, ``ulimit -d``).
    """
    import psutil

    left = [int(psutil.virtual_memory().available), *left_in_containers(Path("/")), *_left_to_us()]
    return max(0, min(left))


def held() -> int:
    """Return the bytes of the memory of the machine that this process holds."""
    import psutil

    return int(psutil.Process().memory_info().rss)


def left_in_containers(root: Path) -> Iterator[int]:
    """Yield the bytes that each control group around this process leaves it.

    Parameters
    ----------
    root : Path
        Folder that holds ``proc`` and ``sys``.

    Yields
    ------
    int
        Limit less use, files that can be dropped not counted as used; of every group that has a
        limit, from the innermost out. Nothing where there are no control groups.

    Notes
    -----
    A group is bound by the limits of those around it. Inside a container its own group may be
    mounted as the outermost one, so that the path that the kernel names does not exist there: the
    groups that do are looked at. See the kernel's documentation,
    https://docs.kernel.org/admin-guide/cgroup-v2.html and …/cgroup-v1/memory.html.
    """
    try:
        lines = (root / "proc/self/cgroup").read_text("utf-8").splitlines()
    except OSError:
        return
    # Lines such as 4:memory:/docker/b3b4, in version 2 0::/user.slice.
    for _, controllers, path in (line.split(":", 2) for line in lines if line.count(":") >= 2):
        for group in _GROUPS:
            if group.controller not in controllers.split(","):
                continue
            inner = PurePosixPath(path.lstrip("/"))
            for folder in (inner, *inner.parents):
                if ".." not in folder.parts:
                    yield from _left_in(root / group.mount / folder, group)


def _left_in(folder: Path, group: _Group) -> Iterator[int]:
    """Yield what one control group leaves, if it has a limit."""
    known = (_number(folder / name) for name in group.limits)
    limit = min((limit for limit in known if limit is not None), default=_NO_LIMIT)
    if limit < _NO_LIMIT and (used := _number(folder / group.used)) is not None:
        yield limit - used + _droppable(folder / "memory.stat", group.droppable)


def _number(file: Path) -> int | None:
    """Return the number in a file; None without a file, and where it says that there is none."""
    try:
        return int(file.read_text("ascii"))
    # ValueError: the limit is "max".
    except (OSError, ValueError):
        return None


def _droppable(file: Path, name: str) -> int:
    try:
        rows = (line.split() for line in file.read_text("ascii").splitlines())
        return next((int(row[1]) for row in rows if row[0] == name), 0)
    except OSError:
        return 0


def _left_to_us() -> Iterator[int]:
    """Yield what the limits of this process leave of its address space and its data."""
    import psutil

    try:
        import resource
    except ImportError:
        # Windows has none.
        return
    for limit, kind in ((resource.RLIMIT_AS, "vms"), (resource.RLIMIT_DATA, "data")):
        most, _ = resource.getrlimit(limit)
        if most != resource.RLIM_INFINITY:
            used = psutil.Process().memory_info()
            yield most - int(getattr(used, kind, used.vms))


def require(
    needed: int, *what: Part, advice: tuple[Part, ...], most: tuple[str, int] = ("", 0)
) -> None:
    """Raise an error with advice unless a job fits into the memory that is free.

    Parameters
    ----------
    needed : int
        Bytes, by the job's own estimate.
    *what : str or Mention
        The job, as the subject of a sentence: ``"a map of 512 × 512 points needs"``.
    advice : tuple of str or Mention
        What would fit.
    most : (str, int)
        The worst case and its bytes, where the job may turn out to need more.

    Raises
    ------
    InsufficientMemoryError
        If the estimate exceeds the memory that is free.
    """
    there = free()
    if needed > there:
        worst = f" ({most[1] / GIB:.1f} GiB {most[0]})" if most[1] > needed else ""
        raise InsufficientMemoryError(
            *what,
            f" about {needed / GIB:.1f} GiB{worst}, and {there / GIB:.1f} GiB are free: ",
            *advice,
        )


def square_side(needed: int, shape: tuple[int, int]) -> int:
    """Return the points along the largest square grid that fits, by an estimate for another.

    Parameters
    ----------
    needed : int
        Bytes for a grid of ``shape``, taken as proportional to its points.
    shape : (int, int)
        Grid points ``(ny, nx)``.
    """
    return int(math.sqrt(free() / needed * shape[0] * shape[1]))


def taken() -> int:
    """Return the bytes of address space that this process takes."""
    import psutil

    return int(psutil.Process().memory_info().vms)
