"""Free memory, and the error for jobs that need more.

`free_in_containers`: The limits of all enclosing control groups apply. Inside a container its group
may be mounted as the root, so that the path given by the kernel does not exist: only existing
groups are evaluated. See the kernel's documentation,
https://docs.kernel.org/admin-guide/cgroup-v2.html and …/cgroup-v1/memory.html.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath

from roughcontact.errors import FormatError, InputError, InsufficientMemoryError, Part

GIB = 2**30

# Version 1 writes the largest number of whole pages for no limit.
_NO_LIMIT = 2**62


# Files of control groups by controller, which version 2 does not name: folder, limits, usage, and
# the entry of memory.stat for cached files, which the kernel drops when memory is short.
_GROUPS = {
    "": ("sys/fs/cgroup", ("memory.max", "memory.high"), "memory.current", "inactive_file"),
    "memory": (
        "sys/fs/cgroup/memory",
        ("memory.limit_in_bytes",),
        "memory.usage_in_bytes",
        "total_inactive_file",
    ),
}


def free_bytes() -> int:
    """Return the number of bytes available for a new array."""
    import psutil

    remaining = [
        int(psutil.virtual_memory().available),
        *free_in_containers(Path("/")),
        *_free_under_limits(),
    ]
    return max(0, min(remaining))


def resident_bytes() -> int:
    """Return the resident memory of this process [bytes]."""
    import psutil

    return int(psutil.Process().memory_info().rss)


def free_in_containers(root: Path) -> Iterator[int]:
    """Yield the free bytes of each control group that contains this process."""
    # Lines such as 4:memory:/docker/b3b4, in version 2 0::/user.slice.
    for line in _read_text(root / "proc/self/cgroup").splitlines():
        if line.count(":") < 2:
            continue
        _, controllers, path = line.split(":", 2)
        inner = PurePosixPath(path.lstrip("/"))
        for controller in _GROUPS.keys() & controllers.split(","):
            for folder in (inner, *inner.parents):
                if ".." not in folder.parts:
                    yield from _cgroup_free_bytes(root, folder, *_GROUPS[controller])


def _cgroup_free_bytes(
    root: Path, folder: PurePosixPath, mount: str, limits: tuple[str, ...], usage: str, cached: str
) -> Iterator[int]:
    """Yield the free bytes of one control group, if it has a limit."""
    group = root / mount / folder
    # Without a limit, version 2 has the word max.
    known = [int(text) for name in limits if (text := _read_text(group / name)).isdecimal()]
    used = _read_text(group / usage)
    if min(known, default=_NO_LIMIT) < _NO_LIMIT and used.isdecimal():
        rows = dict(line.split(" ", 1) for line in _read_text(group / "memory.stat").splitlines())
        yield min(known) - int(used) + int(rows.get(cached, 0))


def _read_text(file: Path) -> str:
    """Return the text of a file; empty if it cannot be read."""
    try:
        return file.read_text("ascii").strip()
    except OSError:
        return ""


def _free_under_limits() -> Iterator[int]:
    """Yield the free bytes of address space and data under the limits of this process."""
    import psutil

    try:
        import resource
    except ImportError:
        # Windows has no such limits.
        return
    for limit, kind in ((resource.RLIMIT_AS, "vms"), (resource.RLIMIT_DATA, "data")):
        maximum, _ = resource.getrlimit(limit)
        if maximum != resource.RLIM_INFINITY:
            used = psutil.Process().memory_info()
            yield maximum - int(getattr(used, kind, used.vms))


def require_memory(
    needed: int, *what: Part, advice: tuple[Part, ...], worst_case: tuple[str, int] = ("", 0)
) -> None:
    """Raise `InsufficientMemoryError` with advice unless a job fits into free memory."""
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
    """Return the side of the largest square grid that fits, from the need of another grid."""
    return int(math.sqrt(free_bytes() / needed * shape[0] * shape[1]))


def address_space_bytes() -> int:
    """Return the size of the address space of this process [bytes]."""
    import psutil

    return int(psutil.Process().memory_info().vms)


POINTS = 2**30
"""Largest number of points of a map: 32768 × 32768, or 8 GiB of heights."""

BYTES = 8 * POINTS
"""Largest size of a file with a map, packed or unpacked [bytes]."""

TEXT = 16 * 2**20
"""Largest size of a text that is parsed as a whole, such as a header [bytes]."""

STEPS = 10_000
"""Largest number of loads, increments or stages of one run."""

ITERATIONS = 1_000_000
"""Largest value of an iteration limit."""

# Measured heights are compressed by a small factor. Content that is compressed a hundredfold is
# made to exhaust the memory, unless it is small.
_PACKED, _SMALL = 100, 2**30


def require_points(name: str, shape: Sequence[int], each: int) -> None:
    """Raise an error for a map of a file with too many points, or too large for memory."""
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
    """Raise an error for a file larger, unpacked, than any map or than free memory."""
    text = f"{name} holds {size / GIB:.1f} GiB"
    if size > BYTES:
        raise FormatError(
            f"{text}, more than the {BYTES / GIB:.0f} GiB that a map may take; export a part of it"
        )
    if packed is not None:
        require_packing(name, size, packed)
    require_memory(size, f"reading {name} needs", advice=("export a part of it",))


def require_packing(name: str, size: int, packed: int) -> None:
    """Raise `FormatError` for a compression that no measured data reach."""
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
    # NumPy integers would overflow, and floats may be infinite.
    points = [n if isinstance(n, float) else int(n) for n in shape]
    if math.prod(points) > POINTS:
        grid = " × ".join(f"{n:.6g}" if isinstance(n, float) else str(n) for n in points)
        raise InputError(
            f"gives {grid} points, more than the {POINTS} (2³⁰) that a map may have",
            argument=argument,
            value=tuple(shape) if value is None else value,
        )
