"""The command ``desk``: the page in the browser."""

from __future__ import annotations

from roughcontact.request import parsing
from roughcontact.request.option import Option, Panel, file, flag
from roughcontact.request.task import Command

_LARGEST_PORT = 2**16 - 1

FOLDER = file(
    "folder", "FOLDER",
    "Folder of projects (kept 30 days); default: user state folder.",
)  # fmt: skip
UPLOAD_LIMIT = Option(
    "upload-limit", Panel.SERVER, "SIZE",
    'Largest upload: "500 MB"; eight times that in total; default: 1 GiB.',
    parsing.data, 2**30,
)  # fmt: skip
PORT = Option(
    "port", Panel.SERVER, "NUMBER",
    "Port; default: 5106, or a free one.",
    parsing.counted(1, _LARGEST_PORT), None,
)  # fmt: skip
ADDRESS = Option(
    "address", Panel.SERVER, "ADDRESS",
    "Listen address; 0.0.0.0 admits other machines (needs --allow-origin); default: 127.0.0.1.",
    parsing.words, "127.0.0.1",
)  # fmt: skip
ALLOW_ORIGIN: Option[tuple[str, ...]] = Option(
    "allow-origin", Panel.SERVER, "URL",
    "Address in the browsers of other machines: http://lab-pc:5106; repeatable.",
    parsing.origins, (), many=True,
)  # fmt: skip
NO_BROWSER = flag("no-browser", Panel.SERVER, "Print the address without opening a browser.")

COMMAND = Command(
    "desk",
    """Open the browser app.

The app is served to this machine only. Projects are saved. Ctrl-C ends it.
""",
    (FOLDER, UPLOAD_LIMIT, PORT, ADDRESS, ALLOW_ORIGIN, NO_BROWSER),
    example="roughcontact desk ground.x3p",
)
