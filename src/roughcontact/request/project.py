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
    "What works: local, processes of this machine; dask, a Dask cluster; default: local.",
    parsing.choice(LOCAL, DASK), LOCAL,
)  # fmt: skip
SCHEDULER = Option(
    "scheduler", Panel.ENGINE, "ADDRESS",
    "Scheduler of a Dask cluster, such as tls://head:8786; one of tcp:// runs what anybody who "
    "reaches it sends; default: one is started on this machine for the run alone.",
    parsing.words, None,
)  # fmt: skip
WORKERS = Option(
    "workers", Panel.ENGINE, "NUMBER",
    "Processes of this machine that work at a time; default: one for each core.",
    parsing.counted(1, _MOST), None,
)  # fmt: skip

COMMAND = Command(
    "run",
    """Work through the contacts of a project file on all cores.

One that fails does not stop the others. The same command goes on where it was interrupted:
what was solved before from the same options and files is kept.
""",
    (ENGINE, SCHEDULER, WORKERS, *options.SHOWN),
    example="roughcontact run project.toml",
)
