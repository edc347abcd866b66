"""The command ``run``: many contacts."""

from __future__ import annotations

from roughcontact.request import options, parsing
from roughcontact.request.option import Option, Panel
from roughcontact.request.task import Command

LOCAL, DASK = "local", "dask"
"""What the contacts of a project are worked through on."""

_MOST = 2**16

ENGINE = Option(
    "engine", Panel.ENGINE, f"{LOCAL}|{DASK}",
    "Where to run: local or dask; default: local.",
    parsing.choice(LOCAL, DASK), LOCAL,
)  # fmt: skip
SCHEDULER = Option(
    "scheduler", Panel.ENGINE, "ADDRESS",
    "Dask scheduler: tls://head:8786 (tcp:// is unprotected); default: start one.",
    parsing.words, None,
)  # fmt: skip
WORKERS = Option(
    "workers", Panel.ENGINE, "NUMBER",
    "Local processes; default: one per core.",
    parsing.counted(1, _MOST), None,
)  # fmt: skip

COMMAND = Command(
    "run",
    """Run all analyses of a project file.

A failed analysis does not stop the others. The same command continues where it stopped.
""",
    (ENGINE, SCHEDULER, WORKERS, *options.SHOWN),
    example="roughcontact run project.toml",
)
