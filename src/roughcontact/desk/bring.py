"""Bringing a map: dropped, chosen from the demonstration maps, generated, or a smooth body."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import panel as pn

from roughcontact.desk import headline, style, words
from roughcontact.desk.column import card, fold
from roughcontact.desk.controls import Control, button
from roughcontact.desk.live import Prepared
from roughcontact.desk.session import Session
from roughcontact.desk.state import Value
from roughcontact.errors import RoughcontactError
from roughcontact.report import inputs
from roughcontact.report.quantities import rows_of
from roughcontact.request.options import GENERATE, parsed

Store = Callable[[str, bytes], Path]
"""``store(name, content)`` keeps a file under a name of our own, and returns where."""

DEMONSTRATIONS: dict[str, dict[str, Value]] = {
    "Ground steel": {
        "size": "0.5 mm", "points": "512", "sq": "0.4 um", "sal": "6 um", "str": "0.1",
        "lay": "90", "ssk": "-0.5", "seed": "1",
    },
    "Polished, isotropic": {
        "size": "0.1 mm", "points": "512", "sq": "20 nm", "sal": "4 um", "seed": "2",
    },
    "Honed bore": {
        "size": "1 mm", "points": "512", "sq": "0.6 um", "sal": "15 um", "str": "0.2",
        "honing": "50", "ssk": "-1.2", "seed": "3",
    },
}  # fmt: skip
"""Demonstration maps, by name, as ``roughcontact generate`` is asked for them."""

_FILE = ("channel", "unit", "size", "override-size")
_GENERATED = ("size", "points", "sq", "sal", "sdq", "hurst", "str", "lay", "ssk", "sku", "seed")
_FIRST: dict[str, Value] = {"size": "0.2 mm", "points": "512", "sq": "0.2 um", "sal": "5 um"}


class Bring:
    """The map: what it is, and where another one comes from.

    Parameters
    ----------
    session : Session
        Whose map it is.
    store : callable
        Keeps what is dropped.
    generate : callable
        ``generate(given, done)`` makes a map from options of ``generate`` and calls ``done(path)``.
    changed : callable
        Called after a change.
    """

    def __init__(
        self,
        session: Session,
        store: Store,
        generate: Callable[[dict[str, Value], Callable[[Path], None]], None],
        changed: Callable[[], None],
    ) -> None:
        self._session, self._store, self._changed = session, store, changed
        self._generate = generate
        self._about = pn.pane.HTML("", **style.WIDE)
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self._drop = _dropper("Drop a height map here, or choose a file", self._dropped)
        self._other = _dropper("Drop the map of the counter-body", self._faced)
        self._alone = button("Take it away", self._unfaced)
        self._demonstration = pn.widgets.Select(
            name="Or a demonstration map", options=["", *DEMONSTRATIONS], **style.CONTROL
        )
        self._demonstration.param.watch(self._demonstrated, "value")
        self._file = [Control(name, session.give) for name in _FILE]
        self._nominal = [Control(name, session.give) for name in ("points", "size")]
        self._wanted: dict[str, Value] = dict(_FIRST)
        wanted = [Control(name, self._want, task=GENERATE) for name in _GENERATED]
        for control in wanted:
            control.show(self._wanted)
        self.root = card(
            "Map",
            self._about,
            self._drop,
            self._wrong,
            self._demonstration,
            fold("Channel, unit, sides", *(control.root for control in self._file)),
            fold("Counter-body with a map of its own", self._other, self._alone),
            fold(
                "Generate a surface",
                *(control.root for control in wanted),
                button("Generate", self._make, primary=True),
            ),
            fold(
                "A smooth body without a map",
                pn.pane.HTML('<p class="quiet">Its form stands under Bodies.</p>', **style.SHEET),
                *(control.root for control in self._nominal),
                button("Use no map", self._bare),
            ),
        )

    def show(self, prepared: Prepared | None) -> None:
        """Show what the state holds, and what is known of the map."""
        state = self._session.state
        for control in (*self._file, *self._nominal):
            control.show(state.given)
        name = "No map yet." if state.file is None else state.name_of(state.file)
        told = f"<p><b>{words.escaped(name)}</b></p>"
        if prepared is not None:
            surface = prepared.surfaces[0]
            rows = [row for row in rows_of(inputs.SURFACE, surface) if row.key != "source"]
            told += headline.table((row.name, row.text) for row in rows[:4])
        self._about.object = told

    def _want(self, name: str, value: Value) -> None:
        if value in ("", False):
            self._wanted.pop(name, None)
            return
        parsed({name: value}, GENERATE)
        self._wanted[name] = value

    def _dropped(self, name: str, content: bytes) -> None:
        self._do(lambda: self._session.bring(self._store(name, content), name))

    def _faced(self, name: str, content: bytes) -> None:
        self._do(lambda: self._session.face(self._store(name, content), name))

    def _unfaced(self) -> None:
        self._do(lambda: self._session.face(None))

    def _bare(self) -> None:
        self._do(lambda: self._session.bring(None))

    def _demonstrated(self, event: Any) -> None:
        if event.new:
            self._do(lambda: self._generate(DEMONSTRATIONS[event.new], self._taken(event.new)))

    def _make(self) -> None:
        self._do(lambda: self._generate(dict(self._wanted), self._taken("generated surface")))

    def _taken(self, name: str) -> Callable[[Path], None]:
        return lambda path: self._do(lambda: self._session.bring(path, name))

    def _do(self, action: Callable[[], object]) -> None:
        try:
            action()
        except RoughcontactError as error:
            self._wrong.object = (
                f'<span role="alert" class="wrong">{words.escaped(words.told(error))}</span>'
            )
            self._wrong.visible = True
        else:
            self._wrong.visible = False
        self._changed()


def _dropper(text: str, dropped: Callable[[str, bytes], None]) -> Any:
    """Return where a file is dropped; what it holds is passed on and forgotten."""
    made = pn.widgets.FileDropper(name=text, multiple=False, height=76, **style.CONTROL)

    def take(event: Any) -> None:
        for name, content in (event.new or {}).items():
            made.value = {}
            dropped(name, content if isinstance(content, bytes) else content.encode())

    made.param.watch(take, "value")
    return made
