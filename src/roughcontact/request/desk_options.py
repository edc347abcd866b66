"""The options of the desk: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from roughcontact.request import parsing
from roughcontact.request.option import OUTPUT, Option

DESK = "desk"
"""The command."""

SERVER = "Server"
"""A heading of its help."""

_LARGEST_PORT = 2**16 - 1


def _option(
    name: str, panel: str, metavar: str, text: str, parse: Callable[[str, str], Any], **more: Any
) -> Option:
    return Option(name, panel, metavar, text, parse, (DESK,), **more)


OPTIONS = (
    _option(
        "folder", OUTPUT, "FOLDER",
        "Where the works are kept, each for 30 days after it was last looked at; default: a folder "
        "of this user for what programs keep.", parsing.path,
    ),
    _option(
        "upload-limit", SERVER, "SIZE", 'Largest file that may be brought, such as "500 MB"; '
        "all files together may have 8 times as much; default: 1 GiB.",
        parsing.data, default=2**30,
    ),
    _option(
        "port", SERVER, "NUMBER", "Port to listen on; default: 5106, or a free one where that is "
        "taken.", parsing.counted(1, _LARGEST_PORT),
    ),
    _option(
        "address", SERVER, "ADDRESS", "Address to listen on. Another than the default, such as "
        "0.0.0.0, lets other machines in, with --allow-origin; default: 127.0.0.1.",
        parsing.words, default="127.0.0.1",
    ),
    _option(
        "allow-origin", SERVER, "URL", "Start of the address under which browsers of other "
        "machines may use the page, such as http://lab-pc:5106; may be given several times.",
        parsing.origin, default=(), many=True,
    ),
    _option("no-browser", SERVER, "", "Print the address, and open no browser.",
            parsing.flag, default=False),
)  # fmt: skip
"""The options, in the order of the help."""
