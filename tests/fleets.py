"""Projects that are worked through by real processes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil

from items import items_of_file, normalize_text
from roughcontact._tools import memory
from roughcontact.batch import jobs

PROJECT = """\
folder = "results"
write = ["nc", "csv"]

[defaults]
unit = "um"
size = "0.1 mm x 0.2 mm"
material = "bearing steel"

[[contact]]
name = "one"
file = "maps/rough.npy"
load = [{loads}]

[[contact]]
name = "curve"
task = "sweep"
file = "maps/rough.npy"
from = "1 mN"
to = "10 mN"
steps = 2
folder = "kept"
"""


def write_project(folder: Path, loads: int, more: str = "") -> Path:
    """Write a map and a project of several loads, and of a sweep that keeps its steps."""
    (folder / "maps").mkdir(parents=True, exist_ok=True)
    y, x = np.mgrid[:40, :64] / 40
    noise = np.random.default_rng(3).standard_normal(y.shape)
    np.save(folder / "maps" / "rough.npy", np.cos(7 * y) * np.cos(5 * x) + 0.1 * noise)
    listed = ", ".join(f'"{load} mN"' for load in range(1, loads + 1))
    text = PROJECT.format(loads=listed) + more
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return folder / "project.toml"


ROOM = 2**26
"""Bytes of a starved worker beyond what it takes when it begins."""


def limited(task: jobs.BatchTask) -> jobs.TaskResult:
    """Work with little memory, where the estimate of what is needed is wrong."""
    import resource

    if task.parts[0].entry.name != "large":
        return jobs.run_task(task)
    before = resource.getrlimit(resource.RLIMIT_AS)
    free = memory.free_bytes
    try:
        resource.setrlimit(resource.RLIMIT_AS, (memory.address_space_bytes() + ROOM, before[1]))
        memory.free_bytes = lambda: 2**40  # type: ignore[assignment]
        return jobs.run_task(task)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
        memory.free_bytes = free


LARGE_CONTACT = """
[[contact]]
name = "large"
file = "large.npy"
size = "0.1 mm"
load = "1 N"
"""


def write_large(folder: Path, points: int) -> None:
    """Write the map of the large contact, which is soon solved."""
    y, x = np.mgrid[:points, :points] / points
    np.save(folder / "large.npy", (np.cos(7 * y) * np.cos(5 * x)).astype(np.float32))


ABSENT = """
[[contact]]
name = "bad"
file = "absent.npy"
load = "1 N"
"""


def wait_for(happened: Callable[[], object], seconds: float = 180.0) -> bool:
    """Wait for something, and return whether it came in time."""
    last = time.monotonic() + seconds
    while not happened() and time.monotonic() < last:
        time.sleep(0.02)
    return bool(happened())


def ended(pid: int) -> bool:
    """Return whether a process is gone, or only waits to be asked how it ended."""
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def items(folder: Path) -> dict[str, dict[str, str]]:
    """Return the contents of all files below a folder, without times."""
    return {
        str(file.relative_to(folder)): {
            name: normalize_text(text, folder.resolve())
            for name, text in items_of_file(file).items()
        }
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }
