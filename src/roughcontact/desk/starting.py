"""What is seen while the program is still imported: its name; the page's scripts are read ahead.

Importing Panel takes a second, in which a browser that asks would show nothing, and in which it can
fetch what it needs of files anyway.
"""

from __future__ import annotations

import asyncio
import hashlib
import importlib.util
import json
from pathlib import Path
from typing import Any

from tornado.routing import Router
from tornado.web import Application, RequestHandler, StaticFileHandler

from roughcontact.desk import style
from roughcontact.desk.guard import Guarded

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>roughcontact</title>{scripts}
<style>body {{ margin: 16px 12px; font: 13px {font}; color: {ink}; }}
h1 {{ font-size: 16px; font-weight: 600; }} p {{ color: {quiet}; }}</style></head>
<body><h1>roughcontact</h1><p role="status">starting …</p>
"""
_GO_ON = "<script>location.replace(location.href)</script></body></html>\n"

# The packages whose files the page asks for: where they are in the package, and on the server.
_BOKEH = "bokeh", "server/static", "static"
_PANEL = "panel", "dist", "static/extensions/panel"
_OF_BOKEH = ("bokeh", "bokeh-gl", "bokeh-widgets", "bokeh-tables")


class Doors(Router):
    """Leads to the page as soon as there is one, and to what is seen before.

    Attributes
    ----------
    opened : asyncio.Event
        Whether there is a page.
    """

    def __init__(self) -> None:
        self.opened = asyncio.Event()
        self._app: Any = Application(
            [
                (r"/", _Waiting, {"opened": self.opened}),
                *(
                    (f"/{place}/(.*)", StaticFileHandler, {"path": str(_folder(package, inside))})
                    for package, inside, place in (_PANEL, _BOKEH)
                ),
                (r".*", _Later, {"opened": self.opened}),
            ],
            transforms=[Guarded],
            log_function=lambda _: None,
        )

    def open(self, app: Any) -> None:
        """Lead to a page from now on, and have those come in who wait."""
        self._app = app
        self.opened.set()

    def find_handler(self, request: Any, **more: Any) -> Any:
        """Return what answers a request."""
        return self._app.find_handler(request, **more)


def addresses() -> list[str]:
    """Return where the scripts of the page are, with their versions, as Bokeh asks for them."""
    found = []
    for name in _OF_BOKEH:
        content = (_folder(*_BOKEH[:2]) / "js" / f"{name}.min.js").read_bytes()
        found.append(f"static/js/{name}.min.js?v={hashlib.sha512(content).hexdigest()}")
    package = json.loads((_folder("panel", "package.json")).read_bytes())
    version = hashlib.sha256(package["version"].encode()).hexdigest()
    return [*found, f"{_PANEL[2]}/panel.min.js?v={version}"]


def _folder(package: str, inside: str) -> Path:
    found = importlib.util.find_spec(package)
    assert found is not None
    assert found.origin is not None
    return Path(found.origin).parent / inside


class _Waiting(RequestHandler):
    """The page before it is there; it takes its own place."""

    def initialize(self, opened: asyncio.Event) -> None:
        self._opened = opened

    async def get(self) -> None:
        self.set_header("Content-Type", "text/html; charset=UTF-8")
        self.set_header("Cache-Control", "no-store")
        try:
            found = addresses()
        except (OSError, LookupError, ValueError):
            # Another version keeps them elsewhere: the page asks for them by itself.
            found = []
        scripts = "".join(f'\n<link rel="preload" as="script" href="{one}">' for one in found)
        self.write(_PAGE.format(scripts=scripts, font=style.FONT, ink=style.INK, quiet=style.QUIET))
        await self.flush()
        await self._opened.wait()
        self.finish(_GO_ON)


class _Later(RequestHandler):
    """Anything else: asked again when there is a page."""

    def initialize(self, opened: asyncio.Event) -> None:
        self._opened = opened

    async def prepare(self) -> None:
        await self._opened.wait()
        self.redirect(self.request.uri or "/", status=307)
