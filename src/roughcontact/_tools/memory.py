"""Free memory, and the error for jobs that need more.

`left_in_containers`: A group is bound by the limits of those around it. Inside a container its
own group may be mounted as the outermost one, so that the path that the kernel names does not
exist there: the groups that do are looked at. See the kernel's documentation,
https://docs.kernel.org/admin-guide/cgroup-v2.html and …/cgroup-v1/memory.html.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from roughcontact.errors import FormatError, InputError, InsufficientMemoryError, Part

GIB = 2**30

# Version 1 has a number for no limit, the largest one in whole pages.
_NO_LIMIT = 2**62


class _Group(NamedTuple):
    """Files in which a version of Linux's control groups states the memory of a container."""

    controller: str
    mount: str
    limits: tuple[str, ...]
    used: str
    # Of what is used, the files that the kernel drops before it refuses anything.
    droppable: str


_GROUPS = (
    _Group("", "sys/fs/cgroup", ("memory.max", "memory.high"), "memory.current", "inactive_file"),
    _Group(
        "memory",
        "sys/fs/cgroup/memory",
        ("memory.limit_in_bytes",),
        "memory.usage_in_bytes",
        "total_inactive_file",
    ),
)


def free_bytes() -> int:
    """Return the bytes that a new array may take now."""
    import psutil

    remaining = [
        int(psutil.virtual_memory().available),
        *left_in_containers(Path("/")),
        *_left_to_us(),
    ]
    return max(0, min(remaining))


def resident_bytes() -> int:
    """Return the bytes of the memory of the machine that this process holds."""
    import psutil

    return int(psutil.Process().memory_info().rss)


def left_in_containers(root: Path) -> Iterator[int]:
    """Yield the bytes that each control group around this process leaves it."""
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
                    yield from _cgroup_free_bytes(root / group.mount / folder, group)


def _cgroup_free_bytes(folder: Path, group: _Group) -> Iterator[int]:
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
        maximum, _ = resource.getrlimit(limit)
        if maximum != resource.RLIM_INFINITY:
            used = psutil.Process().memory_info()
            yield maximum - int(getattr(used, kind, used.vms))


def require_memory(
    needed: int, *what: Part, advice: tuple[Part, ...], worst_case: tuple[str, int] = ("", 0)
) -> None:
    """Raise an error with advice unless a job fits into the memory that is free."""
    there = free_bytes()
    if needed > there:
        worst = (
            f" ({worst_case[1] / GIB:.1f} GiB {worst_case[0]})" if worst_case[1] > needed else ""
        )
        raise InsufficientMemoryError(
            *what,
            f" about {needed / GIB:.1f} GiB{worst}, and {there / GIB:.1f} GiB are free: ",
            *advice,
        )


def square_side(needed: int, shape: tuple[int, int]) -> int:
    """Return the points along the largest square grid that fits, by an estimate for another."""
    return int(math.sqrt(free_bytes() / needed * shape[0] * shape[1]))


def address_space_bytes() -> int:
    """Return the bytes of address space that this process takes."""
    import psutil

    return int(psutil.Process().memory_info().vms)


# --- Limits of the size of files and arguments: one rule, applied before any allocation ---


POINTS = 2**30
"""Most points of one map: 32768 × 32768, or 8 GiB of heights."""

BYTES = 8 * POINTS
"""Most bytes that a file with a map, or all that is packed in it, may take."""

TEXT = 16 * 2**20
"""Most bytes of a text that is taken apart as a whole, such as a header or a project file."""

STEPS = 10_000
"""Largest number of loads, increments or stages of one run."""

ITERATIONS = 1_000_000
"""Most iterations that a solver may be allowed."""

# Heights that were measured pack a few times smaller. What packs a hundred times smaller is made
# to fill memory, unless it is small anyway.
_PACKED, _SMALL = 100, 2**30


def require_points(name: str, shape: Sequence[int], each: int) -> None:
    """Raise `InputError` for an announced map that is too large for any map or for the memory."""
    grid = " × ".join(map(str, shape))
    if math.prod(shape) > POINTS:
        raise FormatError(
            f"{name} announces {grid} points, more than the {POINTS} (2³⁰) that a map may have; "
            "check that the file is complete, or export a part of it"
        )
    require_memory(
        math.prod(shape) * each,
        f"reading the {grid} points of {name} needs",
        advice=("export a part of it",),
    )


def require_size(name: str, size: int, packed: int | None = None) -> None:
    """Raise `InputError` for a file larger, unpacked, than any map or than the memory."""
    text = f"{name} holds {size / GIB:.1f} GiB"
    if size > BYTES:
        raise FormatError(
            f"{text}, more than the {BYTES / GIB:.0f} GiB that a map may take; export a part of it"
        )
    if packed is not None:
        require_packing(name, size, packed)
    require_memory(size, f"reading {name} needs", advice=("export a part of it",))


def require_packing(name: str, size: int, packed: int) -> None:
    """Raise `FormatError` for bytes that are packed into so few as nothing that was measured is."""
    if size > max_unpacked_bytes(packed):
        raise FormatError(
            f"{name} holds {size / GIB:.1f} GiB or more, packed into "
            f"{packed / 2**20:.1f} MiB as no measurement is; check where the file is from"
        )


def max_unpacked_bytes(packed: int) -> int:
    """Return the largest unpacked size of a file of this size [bytes]."""
    return min(BYTES, max(_SMALL, _PACKED * packed))


def require_grid(argument: str, shape: Sequence[float], value: object = None) -> None:
    """Raise `InputError`, naming argument and value, for more points than a map may have."""
    # NumPy's integers would overflow, and floats may be infinite.
    points = [n if isinstance(n, float) else int(n) for n in shape]
    if math.prod(points) > POINTS:
        grid = " × ".join(f"{n:.6g}" if isinstance(n, float) else str(n) for n in points)
        raise InputError(
            f"asks for {grid} points, more than the {POINTS} (2³⁰) that a map may have",
            argument=argument,
            value=tuple(shape) if value is None else value,
        )
