"""All tasks and commands: one row each, in the order of the help."""

from __future__ import annotations

import math
from pathlib import Path

from roughcontact import memory
from roughcontact.request import (
    comparison,
    conductance,
    desk,
    estimate,
    generation,
    interface_law,
    leakage,
    load_curve,
    load_history,
    load_search,
    options,
    parsing,
    project,
    rolling,
    solve,
    subsurface_stress,
)
from roughcontact.request.option import Option, Panel
from roughcontact.request.request import Request
from roughcontact.request.task import Command, Given, Task

POINTS = Option(
    "points", Panel.MAP, "NUMBER", "Points per side; default: 1024.",
    parsing.counted(32, math.isqrt(memory.POINTS)), 1024,
)  # fmt: skip
FOLDER = Option(
    "folder", Panel.OUTPUT, "FOLDER", "Where the files go; default: roughcontact-demo.",
    parsing.path, Path("roughcontact-demo"),
)  # fmt: skip
VERIFY = Command(
    "verify",
    """Tell whether results are as they were written, and whether they are solutions.

Checksums are compared; load, gap and certificate are computed again from pressures and heights.
""",
    options.SHOWN,
    example="roughcontact verify result.nc",
)
INFO = Command(
    "info",
    "Tell what is in a file: grid, size, heights, roughness, missing points, channels.",
    (*options.READING, options.VERBOSE, options.JSON),
    reads_map=True,
    example="roughcontact info ground.opd",
)
MATERIALS = Command(
    "materials",
    "List the catalogue of materials, or one of them with the source of every value.",
    (options.JSON,),
    example="roughcontact materials 'bearing steel'",
)
DEMO = Command(
    "demo",
    """Solve a generated rough surface, elastic and with a ceiling, and write all results.

Needs no measurement: 0.1 mm × 0.1 mm of rough steel under 1 N.
""",
    (POINTS, FOLDER),
    example="roughcontact demo --folder roughcontact-demo",
)
TASKS: tuple[Task, ...] = (
    solve.TASK,
    load_curve.TASK,
    subsurface_stress.TASK,
    load_history.TASK,
    rolling.TASK,
    load_search.TASK,
    conductance.TASK,
    interface_law.TASK,
    leakage.TASK,
    comparison.TASK,
    estimate.TASK,
)
COMMANDS: dict[str, Command] = {
    command.name: command
    for command in (
        *TASKS, generation.COMMAND, project.COMMAND, desk.COMMAND, VERIFY, INFO,
        MATERIALS, DEMO,
    )
}  # fmt: skip
_TASKS = {task.name: task for task in TASKS}
PROJECT_TASKS = {task.name: task for task in TASKS if task.in_projects}
"""What project files may ask for."""
SHARED_TASKS = {task.name: task for task in TASKS if task.shares_contacts}
"""Those of which several may be asked of one contact."""


def from_text(
    name: str, file: Path | None, specified: Given, files: tuple[Path, ...] = ()
) -> Request:
    """Return the request that options in words describe; see `Request.from_text`."""
    return Request.from_text(_TASKS[name], file, specified, files)
