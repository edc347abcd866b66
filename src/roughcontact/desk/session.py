"""Session of a page: current state, undo history, and live results."""

from __future__ import annotations

import contextlib
import json
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import roughcontact as rc
from roughcontact import errors
from roughcontact._tools import files
from roughcontact.analyses import tasks
from roughcontact.batch import project as project_files
from roughcontact.desk.live_solver import (
    PREVIEW_POINTS,
    Event,
    FailedRequest,
    LiveAnswer,
    LiveSolver,
    PreparedMaps,
)
from roughcontact.request import options, task as commands
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request

SOLVE = tasks.PROJECT_TASKS["solve"]
"""Command that solves one contact."""

Value = str | bool
"""Value of an option: text, or whether a flag is set."""

Given = Mapping[str, Value]
Line = tuple[float, float, float, float]

LOADS = ("load", "approach")
"""Options that give the load; a state has one of them at most."""

CONTACT, PINNED = "contact", "pinned"
"""Names of the two contacts in the project file."""

HISTORY = "history.json"
"""File next to the project file: project files of earlier and of undone states."""

PAGE: dict[str, Any] = tomllib.loads(
    (Path(__file__).parent / "assets" / "page.toml").read_text(encoding="utf-8")
)
"""Texts and groups of the page."""

OPTIONS_OF_STEP: dict[str, list[str]] = PAGE["steps"]
"""Options that cause a step of the preparation, by the method of `Surface`."""

# Value that disables a step with an effective default.
_UNDONE: dict[str, Value] = {"level": "none"}

_NO_OPTIONS: Given = MappingProxyType({})
_NO_NAMES: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class SessionState:
    """Requested contact, and the displayed section."""

    specified: Given = field(default_factory=lambda: _NO_OPTIONS)
    file: Path | None = None  # Measured map
    names: Mapping[str, str] = field(default_factory=lambda: _NO_NAMES)
    pinned: Given | None = None  # Options of another state, for comparison
    is_first: bool = False  # Whether the current state is A of the comparison, the pinned one B
    line: Line | None = None  # Ends (y, x, y, x) of the shown section [m]

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the required options without a value."""
        wanted = []
        nominal = all(name in self.specified for name in ("body", "points", "size"))
        if self.file is None and not nominal:
            wanted.append("file")
        elastic = all(name in self.specified for name in ("young", "poisson"))
        if "material" not in self.specified and not elastic:
            wanted.append("material")
        if "boundary" not in self.specified:
            wanted.append("boundary")
        if not any(name in self.specified for name in LOADS):
            wanted.append("load")
        return tuple(wanted)

    def name_of(self, path: Path) -> str:
        """Return the user's name of a file."""
        return self.names.get(path.name, path.name)

    def with_user_names(self, text: str) -> str:
        """Return a text with the user's names of files, without folders."""
        paths = (self.file, self.specified.get("counter-surface"))
        for path in (Path(str(path)) for path in paths if path is not None):
            text = text.replace(str(path.parent / "_")[:-1], "")
        for stored, name in self.names.items():
            text = text.replace(stored, name)
        return text

    def with_map(self, path: Path | None, name: str = "") -> SessionState:
        """Return the state with another map; file properties of the old one are dropped."""
        of_file = {*(option.name for option in options.READING), "points", "crop"}
        others = {key: value for key, value in self.specified.items() if key not in of_file}
        state = replace(
            self,
            file=path,
            specified=MappingProxyType(others),
            line=None,
            pinned=None,
            is_first=False,
        )
        return state if path is None else state._with_name(path, name)

    def with_counter_surface(self, path: Path | None, name: str = "") -> SessionState:
        """Return the state with another map of the counter-body, or without one."""
        if path is None:
            return self.remove_options("counter-surface", "align", "offset", "angle", "mirror")
        return self.with_option("counter-surface", str(path))._with_name(path, name)

    def _with_name(self, path: Path, name: str) -> SessionState:
        # A project file must not contain a null character.
        name = name.replace("\0", "")
        names = {**self.names, path.name: name} if name and name != path.name else self.names
        return replace(self, names=MappingProxyType(dict(names)))

    def with_option(self, name: str, value: Value) -> SessionState:
        """Return the state with an option set; an empty value removes the option."""
        option = SOLVE.by_name.get(name)
        # Output files are offered by the page itself and have no key in project files.
        if option is None or option.panel is options.Panel.OUTPUT:
            raise rc.InputError(f"is no option of {SOLVE.name}", argument=name, value=value)
        if isinstance(value, str):
            value = value.strip()
        if value in ("", False):
            return self.remove_options(name)
        SOLVE.parse_options({name: value})
        others = LOADS if name in LOADS else ()
        specified = {key: old for key, old in self.specified.items() if key not in others}
        return replace(self, specified=MappingProxyType({**specified, name: value}))

    def remove_options(self, *names: str) -> SessionState:
        """Return the state without some options."""
        specified = {key: value for key, value in self.specified.items() if key not in names}
        return replace(self, specified=MappingProxyType(specified))

    def remove_step(self, method: str) -> SessionState:
        """Return the state without a step of the preparation, given by the method of `Surface`."""
        state = self.remove_options(*OPTIONS_OF_STEP.get(method, ()))
        for name in OPTIONS_OF_STEP.get(method, ()):
            if name in _UNDONE:
                state = state.with_option(name, _UNDONE[name])
        return state

    def request(self, task: commands.Task = SOLVE, /, **more: Value) -> Request:
        """Return the request of a task for the state, with additional options."""
        known = task.by_name
        for option in options.COATINGS:
            if option.name in self.specified and option.name not in known:
                raise rc.InputError(
                    f"is not available for {task.name}; remove it, or leave this analysis out",
                    argument=option.argument,
                )
        loads = () if "from_" in more else LOADS
        specified: dict[str, Any] = {
            key: value
            for key, value in self.specified.items()
            if key in known and (key not in LOADS or (key in loads and known[key].default is None))
        }
        specified |= {key.replace("_", "-").strip("-"): value for key, value in more.items()}
        request = Request.from_text(
            task, self.file, {key: value for key, value in specified.items() if value}
        )
        places = {
            str(path): self.names[path.name] for path in request.inputs if path.name in self.names
        }
        return replace(request, names=places)

    def script(self, folder: Path) -> str:
        """Return the text of the project file in a folder; files in it have relative paths."""

        def place(path: str) -> str:
            return str(Path(path).relative_to(folder)) if folder in Path(path).parents else path

        return self._script(place)

    @property
    def portable_script(self) -> str:
        """Text of the project file, with the user's names of the files."""
        return self._script(lambda path: self.name_of(Path(path)))

    def _script(self, place: Callable[[str], str]) -> str:
        lines = [
            "# Written by roughcontact desk; roughcontact run with this file gives the same.",
            'folder = "results"',
        ]
        contacts = {CONTACT: self.specified, PINNED: self.pinned}
        for name, specified in contacts.items():
            if specified is None:
                continue
            lines += ["", "[[contact]]", f"name = {_toml(name)}"]
            if self.file is not None:
                lines.append(f"file = {_toml(place(str(self.file)))}")
            paths = {
                key: place(str(specified[key]))
                for key in (options.COUNTER_SURFACE.name,)
                if key in specified
            }
            lines += [f"{key} = {_toml(value)}" for key, value in {**specified, **paths}.items()]
        lines += ["", f"[{project_files.DESK_TABLE}]"]
        if self.line is not None:
            lines.append(f"line = [{', '.join(map(repr, self.line))}]")
        if self.is_first:
            lines.append("is-first = true")
        lines += [f"names.{_toml(key)} = {_toml(name)}" for key, name in self.names.items()]
        return "\n".join(lines) + "\n"


def from_script(text: str, folder: Path) -> SessionState:
    """Return the state in the text of a project file in a folder."""
    try:
        read = tomllib.loads(text)
        contacts = {contact.pop("name"): contact for contact in read["contact"]}
        own = read.get(project_files.DESK_TABLE, {})
        line = own.get("line")
        state = SessionState(
            names=MappingProxyType({str(k): str(v) for k, v in own.get("names", {}).items()}),
            line=None if line is None else _line(line),
            is_first=own.get("is-first", False) is True,
        )
        files = [contact.pop("file", None) for contact in contacts.values()]
        specified = contacts[CONTACT]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise rc.FormatError(f"the project file of this page cannot be read ({error})") from None
    if files[0] is not None:
        state = replace(state, file=_stored_file(files[0], folder))
    for key, value in specified.items():
        state = state.with_option(*_word(key, value, folder))
    if PINNED in contacts:
        other = SessionState()
        for key, value in contacts[PINNED].items():
            other = other.with_option(*_word(key, value, folder))
        state = replace(state, pinned=other.specified)
    return state


def _stored_file(path: object, folder: Path) -> Path:
    """Return the path of a file of a project; files of a moved project are in its folder."""
    result = folder / str(path)
    moved = folder / result.name
    return moved if moved.exists() and not result.exists() else result


def _word(key: str, value: Any, folder: Path) -> tuple[str, Value]:
    """Return the option of a key, which an older version may have written, and its value."""
    if key == options.COUNTER_SURFACE.name:
        return key, str(_stored_file(value, folder))
    name, form = options.REMOVED.get(key, (key, "{}"))
    return name, value if isinstance(value, bool) else form.format(value)


def _line(ends: Any) -> Line:
    y0, x0, y1, x1 = (float(end) for end in ends)
    return y0, x0, y1, x1


def _toml(value: Value) -> str:
    """Return a value as TOML, which differs from JSON texts in one character only."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


_MAX_UNDO = 200
"""Maximum number of states in the undo history."""

# Tolerance of a preview.
_ROUGH = "1e-4"

# Placeholders of missing options, which do not affect the preparation of the maps.
_PREVIEW_OPTIONS = {"material": "100Cr6", "load": "1 N", "boundary": "free"}


class Session:
    """Current state of a page, its project file, and the live solver of its contact."""

    def __init__(
        self,
        project: Path,
        on_event: Callable[[Event], None],
        follow: Callable[[Callable[[Event], None]], LiveSolver] = LiveSolver,
        share: Callable[[SessionState], None] = lambda _: None,
    ) -> None:
        self.project = project
        self.number = 0
        self._share = share
        self.prepared: PreparedMaps | None = None
        self._outcome: Outcome | None = None
        self.failure: FailedRequest | None = None
        self._on_event = on_event
        self._wanted: Request | None = None
        self._past: list[str] = []
        self._future: list[str] = []
        self._state = SessionState()
        if project.exists():
            self._state = from_script(project.read_text(encoding="utf-8"), project.parent)
            # The history is a convenience: without it, or damaged, the project opens.
            with contextlib.suppress(OSError, ValueError, TypeError):
                read = json.loads((project.parent / HISTORY).read_text(encoding="utf-8"))
                self._past, self._future = (list(map(str, states)) for states in read)
        self._live = follow(self._handle_event)

    @property
    def state(self) -> SessionState:
        """Current state."""
        return self._state

    @property
    def outcome(self) -> Outcome | None:
        """Outcome of the current state; None until it is solved."""
        result = self._outcome
        return result if result is not None and self.is_wanted(result.request) else None

    def is_wanted(self, request: Request) -> bool:
        """Return whether a request is the last request of the state."""
        return request is self._wanted

    @property
    def can_undo(self) -> bool:
        """Whether there is a change to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone change to repeat."""
        return bool(self._future)

    # Actions.

    def open_map(self, path: Path | None, name: str = "") -> None:
        """Set the map; None for a nominal body alone."""
        self._change_state(self._state.with_map(path, name))

    def open_counter_map(self, path: Path | None, name: str = "") -> None:
        """Set or remove the map of the counter-body."""
        self._change_state(self._state.with_counter_surface(path, name))

    def set_option(self, name: str, value: Value) -> None:
        """Set an option, or remove it with an empty value, see `SessionState.with_option`."""
        self._change_state(self._state.with_option(name, value))

    def undo_step(self, method: str) -> None:
        """Remove a step of the preparation."""
        self._change_state(self._state.remove_step(method))

    def crop_map(self, rows: tuple[int, int], columns: tuple[int, int]) -> None:
        """Crop the map to some rows and columns of the prepared map."""
        state = self._state
        later = ("flip", "rotate", "pixel", "align")
        changing = [name for name in later if name in state.specified]
        if state.specified.get("missing") == "crop":
            changing.append("missing")
        if changing:
            raise rc.InputError(
                "is done before ",
                errors.ArgumentRef(changing[0].replace("-", "_")),
                ": remove that, draw the part again, and add it back",
                argument="crop",
            )
        before = SOLVE.by_name["crop"].parse(str(state.specified.get("crop", ":,:")), "crop")
        top, left = (part.start or 0 for part in before)
        bounds = (top + rows[0], top + rows[1]), (left + columns[0], left + columns[1])
        self.set_option("crop", ",".join(f"{first}:{last}" for first, last in bounds))

    def pin(self) -> None:
        """Pin the options of the state for comparison, as A; the current state is B from now on."""
        self._change_state(replace(self._state, pinned=self._state.specified, is_first=False))

    def unpin(self) -> None:
        """Remove the pinned options."""
        self._change_state(replace(self._state, pinned=None, is_first=False))

    def swap_pinned(self) -> None:
        """Exchange the current and the pinned options; A and B of the comparison stay."""
        state = self._state
        if state.pinned is None:
            raise rc.InputError("nothing is pinned: pin a state first")
        self._change_state(
            replace(
                state, specified=state.pinned, pinned=state.specified, is_first=not state.is_first
            )
        )

    def draw_line(self, line: Line | None) -> None:
        """Set the line of the displayed section."""
        self._change_state(replace(self._state, line=line), solve=False)

    def undo(self) -> None:
        """Undo the last change."""
        self._step(self._past, self._future)

    def redo(self) -> None:
        """Repeat the last undone change."""
        self._step(self._future, self._past)

    def _step(self, states: list[str], others: list[str]) -> None:
        if states:
            folder = self.project.parent
            state = from_script(states.pop(), folder)
            others.append(self._state.script(folder))
            self._set_state(state)

    def adopt_state(self, state: SessionState) -> None:
        """Adopt the state of another page on the same project."""
        before = self._state
        self._push_undo()
        self._state = state
        if (state.specified, state.file) != (before.specified, before.file):
            self.solve()

    def solve(self) -> None:
        """Request the contact of the state, or only its maps if options are missing."""
        state = self._state
        self.number += 1
        self._outcome = self._wanted = self.failure = None
        if "file" in state.missing:
            self._live.cancel()
            self.prepared = None
            return
        placeholders = {name: _PREVIEW_OPTIONS[name] for name in state.missing}
        if placeholders and "missing" not in state.specified:
            placeholders["missing"] = "mask"
        try:
            request = state.request(**placeholders)
        except rc.InputError as error:
            self._live.cancel()
            self.failure = FailedRequest(None, error)
            self._on_event(self.failure)
            return
        self._wanted = request
        self._live.request(request, LiveAnswer.MAPS if state.missing else LiveAnswer.CONTACT)

    def preview(self, name: str, value: Value) -> bool:
        """Request a preview under another load; return False if the map is small or missing."""
        prepared = self.prepared
        shape = (0,) if prepared is None or self._state.missing else prepared.surfaces[0].shape
        if max(shape) <= PREVIEW_POINTS:
            return False
        request = self._state.with_option(name, value).request(uncalibrated=True, tolerance=_ROUGH)
        self._live.request(request, LiveAnswer.PREVIEW)
        return True

    def close(self) -> None:
        """Close the live solver; the project file stays."""
        self._live.close()

    def wait(self, seconds: float) -> bool:
        """Wait until no job is running; return False on timeout."""
        return self._live.wait(seconds)

    @property
    def request(self) -> Request:
        """Request of the current state."""
        return self._state.request()

    # Changes of the state.

    def _change_state(self, state: SessionState, solve: bool = True) -> None:
        if state == self._state:
            return
        self._push_undo()
        self._set_state(state, solve)

    def _push_undo(self) -> None:
        script = self._state.script(self.project.parent)
        self._past = [*self._past[-_MAX_UNDO + 1 :], script]
        self._future.clear()

    def _set_state(self, state: SessionState, solve: bool = True) -> None:
        folder = self.project.parent
        folder.mkdir(mode=0o700, exist_ok=True)
        files.write_atomically(self.project, state.script(folder))
        files.write_atomically(folder / HISTORY, json.dumps([self._past, self._future]))
        self._state = state
        if solve:
            self.solve()
        self._share(state)

    def _handle_event(self, what: Event) -> None:
        # Events of outdated requests: only outcomes are passed on.
        match what:
            case PreparedMaps() | FailedRequest() if what.request is not self._wanted:
                return
            case PreparedMaps():
                self.prepared = what
            case Outcome():
                self._outcome = what
            case FailedRequest():
                self.failure = what
                self._show_at_least(what)
        self._on_event(what)

    def _show_at_least(self, failed: FailedRequest) -> None:
        """Request the map of a failed request with its missing points masked."""
        request, is_unreadable = failed.request, isinstance(failed.error, rc.FormatError)
        if request is None or "missing" in request.specified or is_unreadable:
            return
        # No option is missing: a request with placeholders masks the points already.
        self._wanted = self._state.request(missing="mask")
        self._live.request(self._wanted, LiveAnswer.MAPS)
