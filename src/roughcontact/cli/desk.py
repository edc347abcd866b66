"""The desk, started: a page in the browser, served until Ctrl-C."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact.errors import InputError
from roughcontact.request import desk_options
from roughcontact.request.task import Values

if TYPE_CHECKING:
    from roughcontact.desk.server import Page


def run(file: Path | None, asked: Values) -> None:
    """Serve the page.

    Parameters
    ----------
    file : Path or None
        A map to begin with.
    asked : Values
        The options.

    Raises
    ------
    InputError
        If Panel is not installed, the file is not there, or the server cannot be.
    """
    if importlib.util.find_spec("panel") is None:
        raise InputError("the desk needs Panel; run pip install 'roughcontact[desk]'")
    from roughcontact.desk import server
    from roughcontact.formats.source import existing

    if file is not None:
        with existing(file):
            file = Path(file).resolve()
    settings = server.Settings(
        file,
        asked[desk_options.ADDRESS],
        asked[desk_options.PORT],
        asked[desk_options.ALLOW_ORIGIN],
        asked[desk_options.FOLDER],
        asked[desk_options.UPLOAD_LIMIT],
        not asked[desk_options.NO_BROWSER],
    )
    server.serve(_page, settings, lambda text: print(text, flush=True))


def _page() -> Page:
    """Return what makes a page, which takes a second to import."""
    from roughcontact.desk.page import page

    return page
