"""What the page holds: what a command line would say, and what one looks at."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from roughcontact.errors import FormatError, InputError
from roughcontact.fleet.project import DESK
from roughcontact.request.request import Request
from roughcontact.request.solve import TASK as SOLVE
from roughcontact.request.task import Task

Value = str | bool
"""An option as it is given: text, or whether a flag is set."""

Given = Mapping[str, Value]
Line = tuple[float, float, float, float]

LOADS = ("load", "hertz", "approach")
"""Options of which one gives the load."""

CONTACT, PINNED = "contact", "pinned"
"""Names of the two contacts in the project file."""

UNDOING = {
    "cropped": ("crop",),
    "without_outliers": ("outliers",),
    "largest_rectangle": ("holes",),
    "leveled": ("level",),
    "without_form": ("form",),
    "filled": ("holes",),
    "masked": ("holes",),
    "filtered": ("s-filter", "l-filter"),
    "resampled": ("pixel",),
    "rotated": ("rotate",),
    "with_form": ("body",),
    "aligned": ("align", "offset", "angle", "mirror"),
}
"""The options that a step of the preparation comes from, by the method of `Surface`."""

# What undoes an option that has a default which does something.
_UNDONE: dict[str, Value] = {"level": "none"}

_NOTHING: Given = MappingProxyType({})
_NO_NAMES: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class State:
    """A contact as it is asked for, and what is looked at.

    Parameters
    ----------
    given : Mapping
        Options of ``roughcontact solve`` as text, without files that are written.
    file : Path or None
        The measured map.
    names : Mapping
        What the user calls files that were brought, by the name under which they are kept.
    pinned : Mapping or None
        The options of another state, to compare with.
    line : tuple of float or None
        Ends (y, x, y, x) of the section that is looked at [m].
    """

    given: Given = field(default_factory=lambda: _NOTHING)
    file: Path | None = None
    names: Mapping[str, str] = field(default_factory=lambda: _NO_NAMES)
    pinned: Given | None = None
    line: Line | None = None

    @property
    def missing(self) -> tuple[str, ...]:
        """What has to be told before anything can be solved, by the names of options."""
        wanted = []
        nominal = all(name in self.given for name in ("body", "points", "size"))
        if self.file is None and not nominal:
            wanted.append("file")
        elastic = all(name in self.given for name in ("young", "poisson"))
        if "material" not in self.given and not elastic:
            wanted.append("material")
        if "boundary" not in self.given:
            wanted.append("boundary")
        if not any(name in self.given for name in LOADS):
            wanted.append("load")
        return tuple(wanted)

    def name_of(self, path: Path) -> str:
        """Return what the user calls a file."""
        return self.names.get(path.name, path.name)

    def named(self, text: str) -> str:
        """Return a text with the user's names of files, and without the folders of these."""
        paths = (self.file, self.given.get("counter-surface"))
        for path in (Path(str(path)) for path in paths if path is not None):
            text = text.replace(str(path.parent / "_")[:-1], "")
        for kept, name in self.names.items():
            text = text.replace(kept, name)
        return text

    def bringing(self, path: Path | None, name: str = "") -> State:
        """Return the state with another map; what was said of the old one's file is forgotten."""
        of_file = ("format", "channel", "unit", "size", "override-size", "points", "crop")
        kept = {key: value for key, value in self.given.items() if key not in of_file}
        state = replace(self, file=path, given=MappingProxyType(kept), line=None, pinned=None)
        return state if path is None else state._named(path, name)

    def facing(self, path: Path | None, name: str = "") -> State:
        """Return the state with another map of the counter-body, or none."""
        if path is None:
            return self.without("counter-surface", "align", "offset", "angle", "mirror")
        return self.having("counter-surface", str(path))._named(path, name)

    def _named(self, path: Path, name: str) -> State:
        names = {**self.names, path.name: name} if name and name != path.name else self.names
        return replace(self, names=MappingProxyType(dict(names)))

    def having(self, name: str, value: Value) -> State:
        """Return the state with an option set.

        Parameters
        ----------
        name : str
            Of an option of ``solve``; one that gives the load replaces the one that did.
        value : str or bool
            Its text; empty or False takes it away.

        Raises
        ------
        InputError
            If there is no such option, or the text cannot be used; it carries the argument.
        """
        if name not in SOLVE.by_name:
            raise InputError(f"is no option of {SOLVE.name}", argument=name, value=value)
        if isinstance(value, str):
            value = value.strip()
        if value in ("", False):
            return self.without(name)
        SOLVE.parsed({name: value})
        others = LOADS if name in LOADS else ()
        given = {key: old for key, old in self.given.items() if key not in others}
        return replace(self, given=MappingProxyType({**given, name: value}))

    def without(self, *names: str) -> State:
        """Return the state with options taken away."""
        given = {key: value for key, value in self.given.items() if key not in names}
        return replace(self, given=MappingProxyType(given))

    def undoing(self, method: str) -> State:
        """Return the state without a step of the preparation, told by the method of `Surface`."""
        state = self.without(*UNDOING.get(method, ()))
        for name in UNDOING.get(method, ()):
            if name in _UNDONE:
                state = state.having(name, _UNDONE[name])
        return state

    def request(self, task: Task = SOLVE, /, **more: Value) -> Request:
        """Return the request that a state stands for.

        Parameters
        ----------
        task : Task
            What to ask of the contact; of its options those that fit are taken.
        **more : str or bool
            Other options, with ``_`` for ``-`` in their names.

        Raises
        ------
        InputError
            If something is missing, or does not go together.
        """
        known = task.by_name
        loads = () if "from_" in more else LOADS
        given: dict[str, Any] = {
            key: value
            for key, value in self.given.items()
            if key in known and (key not in LOADS or (key in loads and known[key].default is None))
        }
        given |= {key.replace("_", "-").strip("-"): value for key, value in more.items()}
        request = Request.from_text(
            task, self.file, {key: value for key, value in given.items() if value}
        )
        places = {str(path): self.names[path.name] for path in request.inputs
                  if path.name in self.names}  # fmt: skip
        return replace(request, names=places)

    @property
    def script(self) -> str:
        """The state as a project file, which needs the files where they are kept."""
        return self._script(lambda path: path)

    @property
    def told(self) -> str:
        """The state as a project file to stand beside the user's own files."""
        return self._script(lambda path: self.name_of(Path(path)))

    def _script(self, place: Callable[[str], str]) -> str:
        lines = [
            "# Written by roughcontact desk; roughcontact run with this file gives the same.",
            'folder = "results"',
        ]
        contacts = {CONTACT: self.given, PINNED: self.pinned}
        for name, given in contacts.items():
            if given is None:
                continue
            lines += ["", "[[contact]]", f"name = {_toml(name)}"]
            if self.file is not None:
                lines.append(f"file = {_toml(place(str(self.file)))}")
            paths = {key: place(str(given[key])) for key in ("counter-surface",) if key in given}
            lines += [f"{key} = {_toml(value)}" for key, value in {**given, **paths}.items()]
        lines += ["", f"[{DESK}]"]
        if self.line is not None:
            lines.append(f"line = [{', '.join(map(repr, self.line))}]")
        lines += [f"names.{_toml(key)} = {_toml(name)}" for key, name in self.names.items()]
        return "\n".join(lines) + "\n"


def from_script(text: str, folder: Path) -> State:
    """Return the state that a project file holds.

    Parameters
    ----------
    text : str
        What `State.script` wrote.
    folder : Path
        Where the file stands, to which names of maps are relative.

    Raises
    ------
    FormatError
        If it is no such file.
    InputError
        If an option in it cannot be used.
    """
    try:
        read = tomllib.loads(text)
        contacts = {contact.pop("name"): contact for contact in read["contact"]}
        own = read.get(DESK, {})
        line = own.get("line")
        state = State(
            names=MappingProxyType({str(k): str(v) for k, v in own.get("names", {}).items()}),
            line=None if line is None else _line(line),
        )
        files = [contact.pop("file", None) for contact in contacts.values()]
        given = contacts[CONTACT]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(f"the project file of this page cannot be read ({error})") from None
    if files[0] is not None:
        state = replace(state, file=folder / str(files[0]))
    for key, value in given.items():
        state = state.having(key, _word(value))
    if PINNED in contacts:
        other = State()
        for key, value in contacts[PINNED].items():
            other = other.having(key, _word(value))
        state = replace(state, pinned=other.given)
    return state


def _word(value: Any) -> Value:
    return value if isinstance(value, bool) else str(value)


def _line(ends: Any) -> Line:
    y0, x0, y1, x1 = (float(end) for end in ends)
    return y0, x0, y1, x1


def _toml(value: Value) -> str:
    """Return a value as TOML writes it, whose texts are those of JSON but for one sign."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
