"""All tasks and commands, grouped in the order of the help."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from roughcontact._tools import memory
from roughcontact.analyses.compare import task as comparison
from roughcontact.analyses.conductance import task as conductance
from roughcontact.analyses.estimate import task as estimate
from roughcontact.analyses.find import task as load_search
from roughcontact.analyses.generate import task as generation
from roughcontact.analyses.history import task as load_history
from roughcontact.analyses.law import task as interface_law
from roughcontact.analyses.leak import task as leakage
from roughcontact.analyses.roll import task as rolling
from roughcontact.analyses.solve import task as solve
from roughcontact.analyses.stress import task as subsurface_stress
from roughcontact.analyses.sweep import task as load_curve
from roughcontact.analyses.tangential import task as tangential
from roughcontact.analyses.wear import task as wear
from roughcontact.request import options, parsing
from roughcontact.request.options import Option, Panel
from roughcontact.request.request import Request
from roughcontact.request.task import Command, Given, Task

POINTS = Option(
    "points",
    parsing.int_parser(32, math.isqrt(memory.POINTS)),
    "Points per side; default: 512.",
    512,
    Panel.MAP,
)
FOLDER = Option(
    "folder",
    parsing.path.with_metavar("FOLDER"),
    "Folder for the files; default: roughcontact-demo.",
    Path("roughcontact-demo"),
    Panel.OUTPUT,
)
PROJECTS_FOLDER = Option.file(
    "folder", "Folder of projects (kept 30 days); default: user state folder."
)
UPLOAD_LIMIT = Option(
    "upload-limit",
    parsing.parse_bytes,
    'Largest upload: "500 MB"; eight times that in total; default: 1 GiB.',
    2**30,
    Panel.SERVER,
)
PORT = Option.value(
    "port", parsing.int_parser(1, 2**16 - 1), "Port; default: 5106, or a free one.", Panel.SERVER
)
ADDRESS = Option(
    "address",
    parsing.as_text.with_metavar("ADDRESS"),
    "Listen address; 0.0.0.0 admits other machines (needs --allow-origin); default: 127.0.0.1.",
    "127.0.0.1",
    Panel.SERVER,
)
ALLOW_ORIGIN: Option[Any] = Option(
    "allow-origin",
    parsing.origin,
    "Address in the browsers of other machines: http://lab-pc:5106; repeatable.",
    (),
    Panel.SERVER,
    many=True,
)
NO_BROWSER = Option.flag("no-browser", "Print the address without opening a browser.", Panel.SERVER)

DESK = Command(
    "desk",
    """Open the browser app.

The app is served to this machine only. Projects are saved. Ctrl-C ends it.
""",
    (PROJECTS_FOLDER, UPLOAD_LIMIT, PORT, ADDRESS, ALLOW_ORIGIN, NO_BROWSER),
    example="roughcontact desk ground.x3p",
)

LOCAL, DASK = "local", "dask"
"""Engines of a project."""

ENGINE = Option(
    "engine",
    parsing.choice(LOCAL, DASK),
    "Where to run: local or dask; default: local.",
    LOCAL,
    Panel.ENGINE,
)
SCHEDULER = Option.value(
    "scheduler",
    parsing.as_text.with_metavar("ADDRESS"),
    "Dask scheduler: tls://head:8786 (tcp:// is unprotected); default: start one.",
    Panel.ENGINE,
)
WORKERS = Option.value(
    "workers", parsing.int_parser(1, 2**16), "Local processes; default: one per core.", Panel.ENGINE
)

RUN = Command(
    "run",
    """Run all analyses of a project file.

A failed analysis does not stop the others. The same command continues where it stopped.
""",
    (ENGINE, SCHEDULER, WORKERS, *options.SHOWN),
    example="roughcontact run project.toml",
)

VERIFY = Command(
    "verify",
    """Check that result files are undamaged and solved.

Compares checksums, and recomputes load, gap and certificate from pressure and heights.
""",
    options.SHOWN,
    example="roughcontact verify result.nc",
)
INFO = Command(
    "info",
    "Show grid, size, roughness and defects of one or more files.",
    (*options.READING, options.VERBOSE, options.JSON),
    reads_map=True,
    example="roughcontact info ground.x3p",
)
MATERIALS = Command(
    "materials",
    "List materials, or the sources of one material's data.",
    (options.JSON,),
    example="roughcontact materials 'bearing steel'",
)
DEMO = Command(
    "demo",
    """Solve an example and write all outputs.

The example is a generated steel surface, 0.1 mm × 0.1 mm, under 1 N.
""",
    (POINTS, FOLDER),
    example="roughcontact demo --folder roughcontact-demo",
)
GROUPS: dict[str, tuple[Command, ...]] = {
    "Solve one contact": (
        solve.TASK,
        load_curve.TASK,
        load_history.TASK,
        load_search.TASK,
        subsurface_stress.TASK,
        rolling.TASK,
        wear.TASK,
    ),
    "Joints of flat faces": (interface_law.TASK, conductance.TASK, leakage.TASK, tangential.TASK),
    "Several surfaces, no map, many jobs": (
        comparison.TASK,
        estimate.TASK,
        generation.COMMAND,
        RUN,
    ),
    "Tools": (INFO, MATERIALS, VERIFY, DESK, DEMO),
}
"""Commands by heading of the help."""
COMMANDS = {command.name: command for group in GROUPS.values() for command in group}
TASKS = tuple(command for command in COMMANDS.values() if isinstance(command, Task))
_TASKS = {task.name: task for task in TASKS}
PRESENTATIONS = {name: place for task in TASKS for name, place in task.presentations.items()}
"""Import paths of the presentations by class of results."""
PROJECT_TASKS = {task.name: task for task in TASKS if task.in_projects}
"""Tasks that project files can request."""
SHARED_TASKS = {task.name: task for task in TASKS if task.shares_contacts}
"""Tasks that can share the contacts of one request."""


def from_text(
    name: str, file: Path | None, specified: Given, files: tuple[Path, ...] = ()
) -> Request:
    """Return the request of a task from text options; see `Request.from_text`."""
    return Request.from_text(_TASKS[name], file, specified, files)
