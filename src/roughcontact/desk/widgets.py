"""Widgets for keyboards and screen readers, where those of Bokeh need a pointer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import panel as pn
import param
from bokeh.events import ConnectionLost, DocumentReady
from bokeh.models import CustomJS
from panel.custom import JSComponent

from roughcontact.desk import style


class FileDrop(JSComponent):  # type: ignore[misc]
    """Upload area for one file; ``arrived`` is the response of the server."""

    words = param.String("")
    arrived = param.Dict({})
    count = param.Integer(0)

    _esm = style.read_script("send", "file_drop")
    _stylesheets: ClassVar = [style.CSS["FILE_DROP"]]


# Widgets for keyboards and screen readers, where those of Bokeh need a pointer


LOST = (
    "The program has ended, or cannot be reached. The project is saved: start the program again, "
    "and reload this page."
)

BROKEN = "This page shows an old state. Reload it."


class TabStrip(JSComponent):  # type: ignore[misc]
    """Strip of tabs; ``active`` is the index of the active tab.

    If ``pictured``, each tab has a thumbnail: a URL in ``pictures``, ``side`` dots wide and high.
    ``body`` is the class of the element with the active panel.
    """

    names = param.List([])
    active = param.Integer(0)
    pictured = param.Boolean(False)
    pictures = param.List([])
    side = param.Integer(0)
    body = param.String("")

    _esm = style.read_script("find", "tab_strip")
    _stylesheets: ClassVar = [style.CSS["TAB_STRIP"]]


class Tabs:
    """Tabs that build only the active panel."""

    def __init__(
        self, parts: Mapping[str, Any], turned: Callable[[], None], sizing: str = "stretch_width"
    ) -> None:
        self._parts, self._turned, names = list(parts.values()), turned, list(parts)
        name = f"body-{names[0].lower()}"
        self.strip = TabStrip(names=names, body=name, height=36, **style.STRIP)
        self.body = pn.Column(css_classes=[name], sizing_mode=sizing, margin=(4, 0), **style.SHEETS)
        self.strip.param.watch(lambda _: self._turn(), "active")
        self._update_body()

    def _update_body(self) -> None:
        self.body[:] = [self._parts[self.strip.active]]

    def _turn(self) -> None:
        self._update_body()
        self._turned()


class Slider(JSComponent):  # type: ignore[misc]
    """Slider with a scale and a text for each position; reports each move in ``moved``.

    ``text`` is the text of the current value, which may be between two positions. Before a value
    is given, ``value`` is -1: the slider has no thumb.
    """

    words = param.String("")
    end = param.Integer(1)
    value = param.Integer(-1)
    text = param.String("")
    texts = param.List([])
    ticks = param.List([])
    moved = param.Dict({})

    # Delay of a value for a later one [ms]: the default of 50 is half the time of a step.
    _debounce: ClassVar[int] = 5
    _esm = style.read_script("slider")
    _stylesheets: ClassVar = [style.CSS["SLIDER"]]


class Frame(JSComponent):  # type: ignore[misc]
    """Browser window: size, color scheme, pressed key, dropped file; ``sought`` gets the focus."""

    size = param.List([1280, 800])
    dark = param.Boolean(False)
    key = param.Dict({})
    sought = param.Dict({})
    arrived = param.Dict({})
    count = param.Integer(0)
    beat = param.Integer(0)

    _esm = style.read_script("send", "find", "frame")
    _stylesheets: ClassVar = [style.CSS["FRAME"]]


def send_all_after_pull(document: Any) -> None:
    """Send also changes between the copy of a document and its first rendering."""
    copied = document.to_json

    def copy(*more: Any, **named: Any) -> Any:
        created = copied(*more, **named)
        pn.state._connected[document] = True
        return created

    document.to_json = copy


def watch_connection(document: Any) -> None:
    """Reload a page that cannot apply a change; show a message if it fails again, or is lost."""
    show = style.read_asset("lost.js", WARNING=style.WARNING, FONT=style.FONT)
    for event, words, code in (
        (DocumentReady, BROKEN, style.read_script("broken")),
        (ConnectionLost, LOST, "show_lost(words)"),
    ):
        document.js_on_event(event, CustomJS(args={"words": words}, code=show + code))


class TabPanel:
    """Panel of a tab."""

    root: Any
    """Content of the panel."""

    _working: Any = None
    """Button of the job, a `controls.JobButton`; None without a job."""

    def refresh(self) -> None:
        """Update the panel; called after each change while it is visible."""

    def cancel(self) -> None:
        """Cancel the running job."""
        if self._working is not None:
            self._working.cancel()


class TabPanels(Tabs):
    """Tabs of the page: the first panel is given, the others are built when first shown."""

    def __init__(self, first: Any, others: Mapping[str, Callable[[], TabPanel]]) -> None:
        self._makers = list(others.values())
        self._created: dict[int, TabPanel] = {}
        self._places = [
            pn.Column(sizing_mode="stretch_both", margin=0, stylesheets=[style.CSS["VIEW"]])
            for _ in others
        ]
        parts = {"Contact": first, **dict(zip(others, self._places, strict=True))}
        super().__init__(parts, self.refresh, "stretch_both")

    def refresh(self) -> None:
        """Update the visible panel."""
        active = int(self.strip.active)
        if active == 0:
            return
        if active not in self._created:
            self._created[active] = created = self._makers[active - 1]()
            self._places[active - 1].append(created.root)
        self._created[active].refresh()

    def close(self) -> None:
        """Cancel the running jobs of all panels."""
        for view in self._created.values():
            view.cancel()
