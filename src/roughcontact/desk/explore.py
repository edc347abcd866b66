"""Browser app for an object of a Python session, in a notebook or a browser tab."""

from __future__ import annotations

import html
import tempfile
import threading
import weakref
from pathlib import Path
from typing import TYPE_CHECKING

import roughcontact as rc
from roughcontact.desk.server import Server, Settings
from roughcontact.desk.session import SessionState, Value

if TYPE_CHECKING:
    from roughcontact.desk.server import Page

_HEIGHT = 820


class DeskServer:
    """Server of a page for this machine, until `close` or the end of this object."""

    def __init__(self, server: Server, folder: tempfile.TemporaryDirectory[str]) -> None:
        self.url = server.url
        self._thread = threading.Thread(target=server.run, name="desk", daemon=True)
        self._thread.start()
        self._end = weakref.finalize(self, _close, server, self._thread, folder)

    def close(self) -> None:
        """Stop the server and remove its files."""
        self._end()

    def __repr__(self) -> str:
        """Return the address of the page as text."""
        return f"a page at {self.url}"

    def _repr_html_(self) -> str:
        address = html.escape(self.url, quote=True)
        return (
            f'<iframe src="{address}" title="roughcontact" width="100%" height="{_HEIGHT}" '
            'style="border: 1px solid #d8dee4; border-radius: 6px"></iframe>'
        )


def explore(shown: rc.Surface | rc.ContactResult) -> DeskServer:
    """Open the browser app on a surface or a result."""
    surface = shown if isinstance(shown, rc.Surface) else shown.surface
    surface.require_map("the page")
    specified: dict[str, Value] = {"level": "none"}
    if surface.missing:
        specified["missing"] = "mask"
    counter = None
    if isinstance(shown, rc.ContactResult):
        specified |= _option_values(shown)
        counter = shown.counter_surface
    folder = tempfile.TemporaryDirectory(prefix="roughcontact-desk-")
    server = Server(_page, Settings(folder=Path(folder.name), port=0, browser=False))
    work = server.first
    path = work.make_folder() / "map.npz"
    surface.save(path)
    state = SessionState().with_map(path, surface.provenance.source)
    if counter is not None:
        path = work.folder / "counter.npz"
        counter.save(path)
        state = state.with_counter_surface(path, counter.provenance.source)
    for name, value in specified.items():
        state = state.with_option(name, value)
    work.project.write_text(state.script(work.folder), encoding="utf-8")
    return DeskServer(server, folder)


def _page() -> Page:
    """Return the function that creates a page, imported late: the import takes a second."""
    from roughcontact.desk.page import make_page

    return make_page


def _close(
    server: Server, thread: threading.Thread, folder: tempfile.TemporaryDirectory[str]
) -> None:
    server.stop()
    thread.join()
    folder.cleanup()


def _option_values(result: rc.ContactResult) -> dict[str, Value]:
    """Return the options that reproduce a result, to the last digit."""
    if result.moments is not None or not isinstance(result.ceiling, (float, type(None))):
        raise rc.InputError(
            "the app has no ceiling per pixel and no moments: explore the surface of the result"
        )
    specified: dict[str, Value] = {
        **_constant_options(result.material, ""),
        **_constant_options(result.counter_material, "counter-"),
        "boundary": str(result.boundary),
        "ceiling": "none" if result.ceiling is None else f"{result.ceiling!r} Pa",
        "tolerance": repr(result.tolerance),
    }
    control, unit = ("load", "N") if result.control == "load" else ("approach", "m")
    return {**specified, control: f"{getattr(result, control)!r} {unit}"}


def _constant_options(material: rc.Material, prefix: str) -> dict[str, Value]:
    if material.compliance == 0.0:
        return {}
    constants = {
        "young": f"{material.young!r} Pa",
        "poisson": repr(material.poisson),
        "yield-strength": material.yield_strength and f"{material.yield_strength!r} Pa",
    }
    return {f"{prefix}{name}": text for name, text in constants.items() if text}
