"""Bringing a map: dropped, chosen from the demonstration maps, generated, or a smooth body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import panel as pn

from roughcontact.desk import headline, style, words
from roughcontact.desk.column import Group, card, fold
from roughcontact.desk.controls import Control, button
from roughcontact.desk.dropping import Drop
from roughcontact.desk.live import Prepared
from roughcontact.desk.server import Visit
from roughcontact.desk.session import Session
from roughcontact.desk.state import Value, from_script
from roughcontact.desk.works import KEPT, Work
from roughcontact.errors import InputError, Mention, RoughcontactError
from roughcontact.report import inputs
from roughcontact.report.quantities import rows_of
from roughcontact.request.making import COMMAND as GENERATE
from roughcontact.surface.surface import Surface

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

UPLOADS = "upload"
"""Where the server takes files, as seen from the page."""

_LISTED = 12
_FILE = ("channel", "unit", "size", "override-size", "format")
_GENERATED = ("size", "points", "sq", "sal", "sdq", "hurst", "str", "lay", "ssk", "sku", "seed")
_FIRST: dict[str, Value] = {"size": "0.2 mm", "points": "512", "sq": "0.2 um", "sal": "5 um"}


class Bring:
    """The map: what it is, and where another one comes from.

    Parameters
    ----------
    session : Session
        Whose map it is.
    visit : Visit
        Where the server keeps what is dropped, and what else is kept there.
    generate : callable
        ``generate(given, done)`` makes a map from options of ``generate`` and calls ``done(path)``.
    changed : callable
        Called after a change.
    removed : callable
        Called when the work is not wanted any more.
    """

    def __init__(
        self,
        session: Session,
        visit: Visit,
        generate: Callable[[dict[str, Value], Callable[[Path], None]], None],
        changed: Callable[[], None],
        removed: Callable[[], None],
    ) -> None:
        self._session, self._visit, self._changed = session, visit, changed
        self._removed = removed
        self._folder = visit.work.folder
        self._generate = generate
        self._about = pn.pane.HTML("", **style.WIDE)
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self._drop = _dropper("Drop a height map here, or choose a file", self._dropped)
        self._nominal = Group(session)
        self._demonstration = pn.widgets.Select(
            label="Or a demonstration map", options=["", *DEMONSTRATIONS], **style.CONTROL
        )
        self._demonstration.param.watch(self._demonstrated, "value")
        self._group = Group(session)
        self._channels: Sequence[str] = ()
        self._told_of: Surface | None = None
        self._table = ""
        self._wanted: dict[str, Value] = dict(_FIRST)
        self._of_file = fold("Channel, unit, sides", self._about_file)
        self.root = card(
            "Map",
            self._about,
            self._drop,
            self._wrong,
            self._demonstration,
            self._of_file,
            fold("Earlier work, or remove this", self._about_works),
            fold("Counter-body with a map of its own", self._about_other),
            fold("Generate a surface", self._about_generated),
            fold("A smooth body without a map", self._about_smooth),
        )

    def _about_file(self) -> list[Any]:
        made = self._group.roots(*_FILE)
        self.tell_channels(self._channels)
        return made

    def _about_works(self) -> list[Any]:
        links = "".join(
            f'<p><a href="?work={work.key}">{words.escaped(_title(work))}</a></p>'
            for work in self._visit.earlier()[:_LISTED]
        )
        told = pn.pane.HTML(links or '<p class="quiet">No other work is kept.</p>', **style.SHEET)
        asked = pn.widgets.TextInput(
            label='To remove this work with all its files, type "remove"', **style.CONTROL
        )
        asked.param.watch(self._remove, "value")
        return [told, asked]

    def _remove(self, event: Any) -> None:
        if event.new.strip().lower() == "remove":
            self._removed()

    def _about_other(self) -> list[Any]:
        drop = _dropper("Drop the map of the counter-body", self._faced)
        return [drop, button("Take it away", self._unfaced)]

    def _about_generated(self) -> list[Any]:
        wanted = [Control(name, self._want, task=GENERATE) for name in _GENERATED]
        for control in wanted:
            control.show(self._wanted)
        made = button("Generate", self._make, primary=True)
        return [*(control.root for control in wanted), made]

    def _about_smooth(self) -> list[Any]:
        words = '<p class="quiet">Its form stands under Bodies.</p>'
        nominal = self._nominal.roots("points", "size")
        return [pn.pane.HTML(words, **style.SHEET), *nominal, button("Use no map", self._bare)]

    def show(self, prepared: Prepared | None) -> None:
        """Show what the state holds, and what is known of the map."""
        state = self._session.state
        self._group.show()
        self._nominal.show()
        name = "No map yet." if state.file is None else state.name_of(state.file)
        told = f"<p><b>{words.escaped(name)}</b></p>"
        surface = None if prepared is None else prepared.surfaces[0]
        if surface is not self._told_of:
            self._told_of = surface
            self._table = "" if surface is None else _described(surface)
        self._about.object = told + self._table

    def tell_channels(self, names: Sequence[str]) -> None:
        """Propose the channels of the file."""
        self._channels = names
        if "channel" in self._group.controls:
            self._group.controls["channel"].suggest(names)

    def tell_lacking(self, error: RoughcontactError) -> bool:
        """Ask for what the file does not tell; return whether an error is about that."""
        about = {part.name for part in error.sentence if isinstance(part, Mention)}
        lacking = [name for name in _FILE if name in about]
        if lacking:
            self._of_file.collapsed = False
            text = self._session.state.named(words.told(error))
            self._group.controls[lacking[0]].complain(text)
        return bool(lacking)

    def _want(self, name: str, value: Value) -> None:
        if value in ("", False):
            self._wanted.pop(name, None)
            return
        GENERATE.parsed({name: value})
        self._wanted[name] = value

    def _dropped(self, told: dict[str, Any]) -> None:
        self._do(lambda: self._session.bring(*self._arrived(told)))

    def _faced(self, told: dict[str, Any]) -> None:
        self._do(lambda: self._session.face(*self._arrived(told)))

    def _arrived(self, told: dict[str, Any]) -> tuple[Path, str]:
        """Return where a file is that came, and what the user calls it."""
        if "error" in told:
            raise InputError(str(told["error"]))
        path = self._folder / Path(str(told.get("file", ""))).name
        # A browser tells what it likes: only what the server keeps for this work is taken.
        if not path.is_file() or not path.name.startswith(KEPT):
            raise InputError("the file did not arrive; bring it again")
        return path, str(told.get("name", ""))

    def _unfaced(self) -> None:
        self._do(lambda: self._session.face(None))

    def _bare(self) -> None:
        self._do(lambda: self._session.bring(None))

    def _demonstrated(self, event: Any) -> None:
        if event.new:
            self._do(
                lambda: self._generate(DEMONSTRATIONS[event.new], self._taken(f"{event.new}.npz"))
            )

    def _make(self) -> None:
        self._generate(dict(self._wanted), self._taken("generated.npz"))

    def _taken(self, name: str) -> Callable[[Path], None]:
        return lambda path: self._do(lambda: self._session.bring(path, name))

    def _do(self, action: Callable[[], object]) -> None:
        try:
            action()
        except RoughcontactError as error:
            self.refuse(error)
        else:
            self._wrong.visible = False
        self._changed()

    def refuse(self, error: RoughcontactError) -> None:
        """Say why no map came."""
        told = words.escaped(words.told(error))
        self._wrong.object = f'<span role="alert" class="wrong">{told}</span>'
        self._wrong.visible = True


def _dropper(text: str, arrived: Callable[[dict[str, Any]], None]) -> Any:
    """Return where a file is dropped."""
    made = Drop(words=text, address=UPLOADS, **style.BLOCK)
    made.param.watch(lambda event: arrived(event.new), "arrived")
    return made


def _described(surface: Surface) -> str:
    """Return the table of what is told of a map."""
    rows = [row for row in rows_of(inputs.SURFACE, surface) if row.key != "source"]
    return headline.table((row.name, row.text) for row in rows[:4])


def _title(work: Work) -> str:
    """Return what a work is called: its map, and when it was last used."""
    used = datetime.fromtimestamp(work.folder.stat().st_mtime).strftime("%Y-%m-%d %H:%M")
    try:
        state = from_script(work.project.read_text(encoding="utf-8"), work.folder)
    except (InputError, OSError):
        return f"cannot be read, {used}"
    return f"{'no map' if state.file is None else state.name_of(state.file)}, {used}"
