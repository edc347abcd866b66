"""The command ``desk``: the page in the browser."""

from __future__ import annotations

from roughcontact.request import parsing
from roughcontact.request.option import Option, Panel, file, flag
from roughcontact.request.task import Command

_LARGEST_PORT = 2**16 - 1

FOLDER = file(
    "folder", "FOLDER",
    "Where the works are kept, each for 30 days after it was last looked at; default: a folder "
    "of this user for what programs keep.",
)  # fmt: skip
UPLOAD_LIMIT = Option(
    "upload-limit", Panel.SERVER, "SIZE", 'Largest file that may be brought, such as "500 MB"; '
    "all files together may have 8 times as much; default: 1 GiB.", parsing.data, 2**30,
)  # fmt: skip
PORT = Option(
    "port", Panel.SERVER, "NUMBER", "Port to listen on; default: 5106, or a free one where that is "
    "taken.", parsing.counted(1, _LARGEST_PORT), None,
)  # fmt: skip
ADDRESS = Option(
    "address", Panel.SERVER, "ADDRESS", "Address to listen on. Another than the default, such as "
    "0.0.0.0, lets other machines in, with --allow-origin; default: 127.0.0.1.",
    parsing.words, "127.0.0.1",
)  # fmt: skip
ALLOW_ORIGIN: Option[tuple[str, ...]] = Option(
    "allow-origin", Panel.SERVER, "URL", "Start of the address under which browsers of other "
    "machines may use the page, such as http://lab-pc:5106; may be given several times.",
    parsing.origins, (), many=True,
)  # fmt: skip
NO_BROWSER = flag("no-browser", Panel.SERVER, "Print the address, and open no browser.")

COMMAND = Command(
    "desk",
    """Open a page in the browser: drop a map, drag the load, watch the contact grow.

All of the program is at hand there. The page is served by this machine to itself alone, and what
one does is kept for the next time. Ctrl-C ends it.
""",
    (FOLDER, UPLOAD_LIMIT, PORT, ADDRESS, ALLOW_ORIGIN, NO_BROWSER),
    example="roughcontact desk ground.opd",
)
