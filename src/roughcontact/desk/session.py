"""One piece of work at the desk: its state, what was before, and what follows from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from roughcontact import files
from roughcontact.desk.live import Failed, Live, Prepared, Told
from roughcontact.desk.state import Line, State, Value, from_script
from roughcontact.errors import FormatError, InputError, Mention
from roughcontact.request.outcome import Outcome
from roughcontact.request.parsing import window
from roughcontact.request.request import Request

_REMEMBERED = 200
"""States that undoing goes back."""

# What a surface is prepared with where only that can be done: any material serves.
_STAND_IN = {"material": "100Cr6", "load": "1 N", "boundary": "free"}


class Session:
    """A state, the project file that always holds it, and the contact that follows it.

    Parameters
    ----------
    project : Path
        The project file; what it holds is taken up.
    told : callable
        ``told(what)`` is called from another thread with what `Live` tells.
    follow : callable
        Makes what solves: `Live`, or what is like it.
    share : callable
        ``share(state)`` is called with each new state, for the other pages on the same work.

    Attributes
    ----------
    prepared : Prepared or None
        The maps as they are prepared, as soon as they are there.
    failure : Failed or None
        Why there is none.
    number : int
        Of the request for the state: each is larger than those before.
    """

    def __init__(
        self,
        project: Path,
        told: Callable[[Told], None],
        follow: Callable[[Callable[[Told], None]], Live] = Live,
        share: Callable[[State], None] = lambda _: None,
    ) -> None:
        self.project = project
        self.number = 0
        self._share = share
        self.prepared: Prepared | None = None
        self._outcome: Outcome | None = None
        self.failure: Failed | None = None
        self._told = told
        self._wanted: Request | None = None
        self._past: list[State] = []
        self._future: list[State] = []
        self._state = State()
        if project.exists():
            self._state = from_script(project.read_text(encoding="utf-8"), project.parent)
        self._live = follow(self._hear)

    @property
    def state(self) -> State:
        """What is asked for now."""
        return self._state

    @property
    def outcome(self) -> Outcome | None:
        """The contact of the state, as soon as it is there."""
        found = self._outcome
        return found if found is not None and self.is_wanted(found.request) else None

    def is_wanted(self, request: Request) -> bool:
        """Return whether a request is that of the state."""
        return request is self._wanted

    @property
    def can_undo(self) -> bool:
        """Whether there is a state to go back to."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether a state was undone."""
        return bool(self._future)

    # What one does.

    def bring(self, path: Path | None, name: str = "") -> None:
        """Take another map; None for a nominal body alone."""
        self._change(self._state.bringing(path, name))

    def face(self, path: Path | None, name: str = "") -> None:
        """Take another map of the counter-body, or none."""
        self._change(self._state.facing(path, name))

    def give(self, name: str, value: Value) -> None:
        """Set an option; empty takes it away. See `State.having` for what is refused."""
        self._change(self._state.having(name, value))

    def give_all(self, given: dict[str, Value]) -> None:
        """Set several options as one step."""
        state = self._state
        for name, value in given.items():
            state = state.having(name, value)
        self._change(state)

    def undo_step(self, method: str) -> None:
        """Take away a step of the preparation."""
        self._change(self._state.undoing(method))

    def keep(self, rows: tuple[int, int], columns: tuple[int, int]) -> None:
        """Crop the map to some rows and columns of it as it is prepared.

        Raises
        ------
        InputError
            If the map as it is prepared has not the rows and columns of the file.
        """
        state = self._state
        changing = [name for name in ("rotate", "pixel", "align") if name in state.given]
        if state.given.get("holes") == "crop":
            changing.append("holes")
        if changing:
            raise InputError(
                "is done before ", Mention(changing[0].replace("-", "_")), ": take that away, draw "
                "the part again, and put it back", argument="crop",
            )  # fmt: skip
        before = window(str(state.given.get("crop", ":,:")), "crop")
        top, left = (part.start or 0 for part in before)
        bounds = (top + rows[0], top + rows[1]), (left + columns[0], left + columns[1])
        self.give("crop", ",".join(f"{first}:{last}" for first, last in bounds))

    def pin(self) -> None:
        """Keep the state to compare with."""
        self._change(replace(self._state, pinned=self._state.given))

    def unpin(self) -> None:
        """Forget it."""
        self._change(replace(self._state, pinned=None))

    def swap(self) -> None:
        """Make the pinned state that which is worked on, and pin this one."""
        if self._state.pinned is None:
            raise InputError("nothing is pinned: pin a state first")
        given = self._state.given
        self._change(replace(self._state, given=self._state.pinned, pinned=given))

    def draw_line(self, line: Line | None) -> None:
        """Look at another section."""
        self._change(replace(self._state, line=line), solve=False)

    def undo(self) -> None:
        """Go back by one change."""
        if self._past:
            self._future.append(self._state)
            self._become(self._past.pop())

    def redo(self) -> None:
        """Do again what was undone."""
        if self._future:
            self._past.append(self._state)
            self._become(self._future.pop())

    def adopt(self, state: State) -> None:
        """Take up the state to which another page on the same work came."""
        before = self._state
        self._remember()
        self._state = state
        if (state.given, state.file) != (before.given, before.file):
            self.solve()

    def solve(self) -> None:
        """Solve the state, or prepare its maps where something is missing for more."""
        state = self._state
        self.number += 1
        self._outcome = self._wanted = self.failure = None
        if "file" in state.missing:
            self._live.cancel()
            self.prepared = None
            return
        given = {**state.given, **{name: _STAND_IN[name] for name in state.missing}}
        if state.missing:
            given.setdefault("holes", "mask")
        try:
            request = replace(state, given=MappingProxyType(given)).request()
        except InputError as error:
            self._live.cancel()
            self.failure = Failed(None, error)
            self._told(self.failure)
            return
        self._wanted = request
        self._live.ask(request, prepare_only=bool(state.missing))

    def close(self) -> None:
        """End the work of this session; the project file stays."""
        self._live.close()

    def wait(self, seconds: float) -> bool:
        """Wait until nothing is under way; return whether that came to be."""
        return self._live.wait(seconds)

    @property
    def request(self) -> Request:
        """The request of the state."""
        return self._state.request()

    # What follows.

    def _change(self, state: State, solve: bool = True) -> None:
        if state == self._state:
            return
        self._remember()
        self._become(state, solve)

    def _remember(self) -> None:
        self._past = [*self._past[-_REMEMBERED + 1 :], self._state]
        self._future.clear()

    def _become(self, state: State, solve: bool = True) -> None:
        files.write(self.project, state.script)
        self._state = state
        if solve:
            self.solve()
        self._share(state)

    def _hear(self, what: Told) -> None:
        # What was under way when something else was asked for.
        is_late = isinstance(what, (Prepared, Outcome, Failed)) and what.request is not self._wanted
        if is_late and not isinstance(what, Outcome):
            return
        if isinstance(what, Prepared):
            self.prepared = what
        elif isinstance(what, Outcome):
            self._outcome = None if is_late else what
        elif isinstance(what, Failed):
            self.failure = what
            self._show_at_least(what)
        self._told(what)

    def _show_at_least(self, failed: Failed) -> None:
        """Have the map seen where only its holes keep it from being pressed."""
        request = failed.request
        if request is None or "holes" in request.given or isinstance(failed.error, FormatError):
            return
        given = {**self._state.given, **{name: _STAND_IN[name] for name in self._state.missing}}
        given["holes"] = "mask"
        self._wanted = replace(self._state, given=MappingProxyType(given)).request()
        self._live.ask(self._wanted, prepare_only=True)
