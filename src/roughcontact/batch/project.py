"""Project files: many contacts in one TOML file."""

from __future__ import annotations

import glob
import os
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact._tools import memory
from roughcontact._tools.files import as_regular_file
from roughcontact.analyses.solve import task as solve
from roughcontact.analyses.tasks import PROJECT_TASKS, SHARED_TASKS
from roughcontact.batch.plan import Entry, spell_key
from roughcontact.errors import ArgumentRef, FormatError, InputError, shorten_value
from roughcontact.request import outputs, parsing
from roughcontact.request.options import (
    COATINGS,
    FOLDER,
    GROUP,
    HEAD,
    LOAD,
    REMOVED,
    REPORT,
    SHOWN,
    Option,
)
from roughcontact.request.request import Request
from roughcontact.request.task import Task, unknown_name

_KEYS = ("folder", "write", "report", "materials", "defaults", "contact")
DESK_TABLE = "desk"
"""Table with the state of the browser app, ignored by batch runs."""

_MAPS = {"file": "a file", "files": "files, a list", "groups": "groups, a table"}
"""Keys for the maps of a contact, with their description in messages."""
_HEAD = [option.name for option in HEAD]
_MATERIAL_KEYS = ("young", "poisson", "yield-strength")
# A task without these options would solve bare bodies.
_COATINGS = {option.name for option in COATINGS}

# Maximum nesting of tables and lists, texts included; groups of files need five levels.
_MAX_NESTING = 20

WRITABLE_SUFFIXES = tuple(
    dict.fromkeys(
        suffix[1:]
        for task in PROJECT_TASKS.values()
        for option in task.options
        for suffix in option.suffixes
        # Each contact writes a summary in any case.
        if suffix != ".json"
    )
)
"""Suffixes of the output files of a contact other than its summary ``.json``."""


def read_project(path: str | os.PathLike[str]) -> list[Entry]:
    """Read and check a project file, and return its entries."""
    path = Path(path)
    try:
        with as_regular_file(path) as file, file.open(encoding="utf-8-sig") as stream:
            text = stream.read(memory.TEXT + 1)
        if len(text) > memory.TEXT:
            raise FormatError(
                f"{path.name} has more than {memory.TEXT // 2**20} million characters; a project "
                "file is a short text"
            )
        read = tomllib.loads(text)
    except FormatError:
        raise
    except OSError as error:
        raise FormatError(
            f"{shorten_value(path)} cannot be read ({error.strerror}); check its name"
        ) from None
    except ValueError as error:
        raise FormatError(f"{path.name} is no TOML file: {error}") from None
    except RecursionError:
        raise FormatError(f"{path.name} nests its tables or brackets too deep") from None
    _check_content(path.name, read)
    project = _parse_project(_Source(path, _key_lines(text)), read)
    result = list(_make_entries(project))
    _check_places(path, result)
    return [entry for _, entry in result]


def _check_content(name: str, read: dict[str, Any]) -> None:
    """Raise `FormatError` for too many nested levels or a null character."""
    level: list[Any] = [read]
    for _ in range(_MAX_NESTING):
        inner: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                inner += [*value, *value.values()]
            elif isinstance(value, list):
                inner += value
            elif isinstance(value, str) and "\0" in value:
                raise FormatError(
                    f"{name} has a text with a null character, which no name may have"
                )
        level = inner
    if level:
        raise FormatError(f"{name} nests its tables or brackets too deep")


Lines = dict[tuple[str, ...], int]

_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]#]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"""\s*("[^"]*"|'[^']*'|[A-Za-z0-9_-]+)\s*=""")


def _key_lines(text: str) -> Lines:
    """Return the line number of each key, by table (with its index in a list) and key."""
    lines: Lines = {}
    table: tuple[str, ...] = ()
    counts: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        header = _HEADER.match(line)
        if header:
            name = header[2]
            table = tuple(part.strip().strip("\"'") for part in name.split("."))
            if header[1] == "[[":
                table = (*table, str(counts.get(name, 0)))
                counts[name] = counts.get(name, 0) + 1
            lines.setdefault(table, number)
            continue
        key = _KEY.match(line)
        if key:
            lines.setdefault((*table, key[1].strip("\"'").replace("_", "-")), number)
    return lines


@dataclass(frozen=True)
class _Source:
    """Project file, and the line number of each key."""

    path: Path
    lines: Lines

    def locate(self, table: tuple[str, ...]) -> str:
        line = self.lines.get(table)
        return self.path.name + (f" line {line}" if line else "")

    def make_error(self, table: tuple[str, ...], text: str) -> InputError:
        """Return an error about a key or table."""
        return InputError(f"{self.locate(table)}: {text}")

    def tables(self, read: Any, name: str) -> dict[str, dict[str, Any]]:
        """Return the subtables of a table; raise an error for other values."""
        if not isinstance(read, dict) or not all(
            isinstance(value, dict) for value in read.values()
        ):
            raise self.make_error((name,), f"{name} must be tables, [{name}.NAME]")
        return dict(read)


@dataclass(frozen=True)
class _Project:
    """Content of a project file with checked top-level keys."""

    source: _Source
    target: Path
    write: list[str]
    head: Mapping[str, str]
    materials: Mapping[str, Mapping[str, Any]]
    defaults: Mapping[str, Any]
    contacts: list[Any]


@dataclass(frozen=True)
class _Contact:
    """Contact with its defaults, and the table and key of origin of each value."""

    source: _Source
    table: tuple[str, ...]
    task: Task
    values: dict[str, Any]
    origins: dict[str, tuple[str, ...]]

    def make_error(self, key: str, text: str) -> InputError:
        """Return an error about a key, at its line or the line of the contact."""
        return self.source.make_error(self.origins.get(key, self.table), text)

    def locate_error(self, error: InputError) -> InputError:
        """Return an error with the key of the project file and its line."""
        begins = error.parts[0] if error.parts else ""
        about = error.argument or (begins.name if isinstance(begins, ArgumentRef) else "")
        option = self.task.option_of_argument(about)
        key = about if option is None else option.name
        return self.make_error(key, error.message_for(partial(spell_key, task=self.task)))


def _unknown_key(key: str, known: Sequence[str]) -> str:
    if key in REMOVED:
        other, form = REMOVED[key]
        return f'{key} is gone: give {other} = "{form.format("…")}"'
    return unknown_name("key", key, known)


def _hyphenate_keys(table: Any) -> Any:
    """Return a table with the keys of the command line, which may be given as Python names."""
    if not isinstance(table, dict):
        return table
    return {key.replace("_", "-"): value for key, value in table.items()}


def _parse_project(source: _Source, read: dict[str, Any]) -> _Project:
    for key in read:
        if key not in (*_KEYS, DESK_TABLE):
            raise source.make_error((key,), _unknown_key(key, _KEYS))
    contacts = read.get("contact", [])
    if not isinstance(contacts, list) or not contacts:
        raise source.make_error(("contact",), "there is no [[contact]] in this project")
    folder = read.get("folder", source.path.stem)
    if not isinstance(folder, str):
        raise source.make_error(("folder",), f"folder must be a text, got {folder!r}")
    target = source.path.parent / folder
    try:
        outputs.check_name(target, "folder")
    except InputError as error:
        raise source.make_error(("folder",), error.message_for()) from None
    if target.exists() and not target.is_dir():
        raise source.make_error(("folder",), f"folder '{target}' is a file")
    write = read.get("write", ["nc"])
    if not isinstance(write, list) or not all(suffix in WRITABLE_SUFFIXES for suffix in write):
        raise source.make_error(
            ("write",), f"write must be a list of {', '.join(WRITABLE_SUFFIXES)}, got {write!r}"
        )
    head = read.get("report", {})
    if not isinstance(head, dict) or not all(isinstance(text, str) for text in head.values()):
        raise source.make_error(("report",), "report must be a table of texts, [report]")
    for key in head:
        if key not in _HEAD:
            raise source.make_error(("report", key), _unknown_key(key, _HEAD))
    if head and "html" not in write:
        raise source.make_error(("report",), 'report needs write = ["html"]')
    tables = source.tables(read.get("materials", {}), "materials")
    materials = {name: _hyphenate_keys(table) for name, table in tables.items()}
    for name, constants in materials.items():
        for key in constants:
            if key not in _MATERIAL_KEYS:
                raise source.make_error(("materials", name, key), _unknown_key(key, _MATERIAL_KEYS))
    defaults = _hyphenate_keys(read.get("defaults", {}))
    if not isinstance(defaults, dict):
        raise source.make_error(("defaults",), "defaults must be a table, [defaults]")
    contacts = [_hyphenate_keys(contact) for contact in contacts]
    return _Project(source, target, write, head, materials, defaults, contacts)


def _check_places(path: Path, result: list[tuple[_Contact, Entry]]) -> None:
    """Raise `InputError` for a project that overwrites inputs, other outputs or itself."""
    read = [other for _, entry in result for other in entry.request.read_files]
    inputs = {outputs.file_identity(other) for other in (*read, path)}
    writers: dict[outputs.Identity, Entry] = {}
    for contact, entry in result:
        for argument, place in (*entry.request.places, ("output", entry.summary)):
            try:
                outputs.check_name(place, argument)
                outputs.refuse_inputs(place, argument, inputs)
            except InputError as error:
                text = error.message_for(partial(spell_key, task=contact.task))
                raise contact.make_error("name", text) from None
            other = writers.setdefault(outputs.file_identity(place), entry)
            if other is not entry:
                raise contact.make_error(
                    "name",
                    f"{argument} '{place}' is a file of {other.name!r}, too; give another name",
                )


def _make_entries(project: _Project) -> Iterator[tuple[_Contact, Entry]]:
    seen: dict[str, str] = {}
    idle = set(project.defaults)
    contacts = 0
    for number, read in enumerate(project.contacts):
        requested = _expand_tasks(project, number, read)
        idle -= {
            contact.origins.get(key, (key,))[-1] for contact in requested for key in contact.values
        }
        for load in _listed_loads(requested[0]):
            contacts += 1
            for contact in requested:
                parts = [contact.values["name"], *([] if load is None else [load])]
                parts += [contact.task.name] if len(requested) > 1 else []
                name = " ".join(map(str, parts))
                stem = re.sub(r"[^\w.+-]+", "-", name)
                if stem in seen:
                    text = f"the name {name!r} is taken by {seen[stem]}"
                    raise project.source.make_error(contact.table, text)
                seen[stem] = project.source.locate(contact.table)
                request = _make_request(project, contact, load, stem)
                yield contact, Entry(name, request, project.target / f"{stem}.json", contacts)
    for key in sorted(idle):
        raise project.source.make_error(("defaults", key), f"{key} fits none of the contacts")


def _listed_loads(contact: _Contact) -> list[Any]:
    """Return each load of a list; ``[None]`` for a single load."""
    loads = contact.values.get(LOAD.name)
    if loads == []:
        raise contact.make_error(LOAD.name, "load is an empty list")
    return loads if isinstance(loads, list) else [None]


def _make_request(project: _Project, contact: _Contact, load: Any, stem: str) -> Request:
    """Return the request of a contact under one of its loads."""
    values = contact.values if load is None else {**contact.values, LOAD.name: load}
    folder = project.source.path.parent
    described = _as_options(contact, values, project.materials)
    described |= _output_options(project, contact.task, stem)
    if REPORT.name in described:
        described = {**project.head, **described}
    if FOLDER.name in described:
        # All contacts may have the same folder: each gets a subfolder.
        described[FOLDER.name] = str(folder / str(described[FOLDER.name]) / stem)
    file = None if "file" not in values else folder / values["file"]
    files = tuple(folder / name for name in values.get("files", ()))
    try:
        return Request.from_text(contact.task, file, described, files)
    except InputError as error:
        raise contact.locate_error(error) from None


def _expand_tasks(project: _Project, number: int, read: Any) -> list[_Contact]:
    """Return a contact once for each of its tasks."""
    tasks = read.get("task", project.defaults.get("task")) if isinstance(read, dict) else None
    if not isinstance(tasks, list):
        return [_parse_contact(project, number, read)]
    table = ("contact", str(number))
    names = set(map(str, tasks))
    if not tasks or len(names) < len(tasks) or names - SHARED_TASKS.keys():
        raise project.source.make_error(
            (*table, "task"),
            f"several tasks must be different ones of {', '.join(SHARED_TASKS)}, got {tasks!r}",
        )
    known = {key for task in tasks for key in _allowed_keys(SHARED_TASKS[task])}
    result = []
    for task in tasks:
        # Omit keys that only the other tasks of the contact have.
        others = known - set(_allowed_keys(SHARED_TASKS[task])) - _COATINGS
        own = {key: value for key, value in read.items() if key not in others}
        result.append(_parse_contact(project, number, {**own, "task": task}))
    return result


def _parse_contact(project: _Project, number: int, read: Any) -> _Contact:
    """Return a contact with its defaults and checked keys."""
    table = ("contact", str(number))
    if not isinstance(read, dict):
        raise project.source.make_error(table, "each contact must be a table, [[contact]]")
    # A material of the contact takes precedence over default constants.
    aside = {
        f"{prefix}{constant}"
        for prefix in ("", "counter-")
        for constant in _MATERIAL_KEYS
        if f"{prefix}material" in read
    }
    defaults = {key: value for key, value in project.defaults.items() if key not in aside}
    where: dict[str, tuple[str, ...]] = {key: ("defaults", key) for key in defaults}
    where |= {key: (*table, key) for key in read}
    values = {**defaults, **read}
    name = values.get("task", solve.TASK.name)
    task = PROJECT_TASKS.get(str(name), solve.TASK)
    contact = _Contact(project.source, table, task, values, where)
    if name != task.name:
        raise contact.make_error(
            "task", f"task must be one of {', '.join(PROJECT_TASKS)}, got {name!r}"
        )
    known = _allowed_keys(task)
    for key in list(values):
        others = [name for name, other in PROJECT_TASKS.items() if key in _allowed_keys(other)]
        if key in known and (key in read or _is_applicable(key, task, values)):
            continue
        if not others:
            raise contact.make_error(key, _unknown_key(key, known))
        if key in read or key in _COATINGS:
            wanted = " or ".join(f'"{other}"' for other in others)
            reason = f": {task.uncoated}" if key in _COATINGS and task.uncoated else ""
            text = f'{key} needs task = {wanted}, got "{task.name}"{reason}'
            raise contact.make_error(key, text)
        del values[key]
    for key in ("name",) if task.many_maps else ("name", "file"):
        nominal = key == "file" and key not in read and "points" in values
        if not nominal and (not isinstance(read.get(key), str) or not read[key].strip()):
            raise project.source.make_error(table, f"this contact needs a {key}, a text")
    if task.many_maps:
        _check_maps(contact)
    return contact


def _check_maps(contact: _Contact) -> None:
    """Raise `InputError` if a task on several maps has none, or invalid names."""
    specified = {key: contact.values[key] for key in contact.task.maps if key in contact.values}
    if not specified:
        listed = ", or ".join(_MAPS[key] for key in contact.task.maps)
        raise contact.make_error("name", f'task = "{contact.task.name}" needs {listed}')
    if not isinstance(specified.get("file", ""), str):
        raise contact.make_error("file", f"file must be a text, got {specified['file']!r}")
    lists = [specified["files"]] if "files" in specified else []
    groups = specified.get("groups", {})
    named = groups if isinstance(groups, dict) else {"": groups}
    for key, listed in [
        *(("files", item) for item in lists),
        *(("groups", g) for g in named.values()),
    ]:
        if not isinstance(listed, list) or not all(isinstance(item, str) for item in listed):
            wanted = "a list of files" if key == "files" else "a table of lists of files by name"
            raise contact.make_error(key, f"{key} must be {wanted}, got {specified[key]!r}")


def _is_applicable(key: str, task: Task, values: Mapping[str, Any]) -> bool:
    """Return whether a default applies to the model of a contact."""
    return all(
        values.get(model.name, model.default) == rule.value
        for rule in task.rules
        if rule.value and rule.options[0].name == key
        for model in rule.options[1:]
    )


def _allowed_keys(task: Task) -> list[str]:
    """Return the keys that a contact may have, without output and console options."""
    own = ("name", "task", *task.maps) if task.many_maps else ("name", *task.maps, "task")
    named = (option for option in task.options if not option.suffixes)
    return [*own, *(option.name for option in named if option not in (*SHOWN, GROUP))]


def _as_options(
    contact: _Contact, values: Mapping[str, Any], materials: Mapping[str, Mapping[str, Any]]
) -> dict[str, str | bool | list[str]]:
    """Return the options of a contact in the form of the command line."""
    specified: dict[str, str | bool | list[str]] = {}
    for key, value in values.items():
        if key == "groups":
            folder = contact.source.path.parent
            specified[GROUP.name] = [
                parsing.group_text(
                    name, [path for file in files for path in _match_files(folder, file)]
                )
                for name, files in value.items()
            ]
        if key in ("name", "task", *_MAPS):
            continue
        prefix = key.removesuffix("material")
        if prefix != key and isinstance(value, str) and value in materials:
            for constant, text in materials[value].items():
                option = f"{prefix}{constant}"
                if option not in values:
                    contact.origins[option] = ("materials", value, constant)
                    specified[option] = _option_text(contact, option, text, constant)
            continue
        is_list = contact.task.by_name[key].many and isinstance(value, list)
        texts = [
            _relocate_files(contact, key, _option_text(contact, key, item, key))
            for item in (value if is_list else [value])
        ]
        specified[key] = texts if is_list else texts[0]
    return specified


def _relocate_files(contact: _Contact, key: str, text: Any) -> Any:
    """Return the text of an option with its files relative to the project file."""
    for name in [] if isinstance(text, bool) else contact.task.by_name[key].files_in(text):
        text = text.replace(name, str(contact.source.path.parent / name), 1)
    return text


def _match_files(folder: Path, word: str) -> list[str]:
    """Return the files below a folder that match a pattern, or else the named path."""
    path = folder / word
    result = [] if path.exists() else sorted(glob.glob(word, root_dir=folder))
    return [str(folder / item) for item in result] or [str(path)]


def _option_text(contact: _Contact, option: str, value: Any, key: str) -> str | bool:
    flag = contact.task.by_name[option].is_flag
    if isinstance(value, bool) and flag:
        return value
    if flag or isinstance(value, bool) or not isinstance(value, (str, int, float)):
        wanted = "true or false" if flag else "a text or a number"
        raise contact.make_error(option, f"{key} must be {wanted}, got {value!r}")
    return str(value)


def _output_options(project: _Project, task: Task, stem: str) -> dict[str, str | bool | list[str]]:
    """Return the options for the requested output files that a task can write."""
    specified: dict[str, str | bool | list[str]] = {}
    for suffix in project.write:
        option = _writer_option(suffix, task)
        if option is None:
            continue
        path = str(project.target / f"{stem}.{suffix}")
        if option.many:
            specified[option.name] = [*specified.get(option.name, []), path]  # type: ignore[misc]
        elif option.name in specified:
            listed = [item for item in project.write if _writer_option(item, task) is option]
            raise project.source.make_error(
                ("write",),
                f'write has {", ".join(listed)}, of which task = "{task.name}" writes one; '
                "leave one",
            )
        else:
            specified[option.name] = path
    return specified


def _writer_option(suffix: str, task: Task) -> Option[Any] | None:
    """Return the option of a task that writes files of a suffix."""
    return next((option for option in task.options if f".{suffix}" in option.suffixes), None)
