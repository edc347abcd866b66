"""The options of many contacts: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from roughcontact.request import parsing
from roughcontact.request.option import Option

RUN = "run"
"""The command."""

LOCAL, DASK = "local", "dask"
"""What the contacts of a project are worked through on."""

ENGINE = "Engine"
"""A heading of its help."""

_MOST = 2**16

OPTIONS = (
    Option(
        "engine", ENGINE, f"{LOCAL}|{DASK}",
        "What works: local, processes of this machine; dask, a Dask cluster; default: local.",
        parsing.choice(LOCAL, DASK), fits=(RUN,), default=LOCAL,
    ),
    Option(
        "scheduler", ENGINE, "ADDRESS",
        "Scheduler of a Dask cluster, such as tls://head:8786; one of tcp:// runs what anybody who "
        "reaches it sends; default: one is started on this machine for the run alone.",
        parsing.words, fits=(RUN,),
    ),
    Option(
        "workers", ENGINE, "NUMBER",
        "Processes of this machine that work at a time; default: one for each core.",
        parsing.counted(1, _MOST), fits=(RUN,),
    ),
)  # fmt: skip
"""The options, in the order of the help."""
