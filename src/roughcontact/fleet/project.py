"""Project files: many contacts in one TOML file."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from roughcontact.errors import FormatError, InputError
from roughcontact.fleet.plan import Entry
from roughcontact.request.options import OPTIONS
from roughcontact.request.request import from_text

WRITABLE = ("nc", "html", "png", "svg", "pdf", "vti", "vtr", "csv")
"""What a contact may write besides its ``.json``, by suffix."""

_OWN_KEYS = ("name", "file")
_PLACED = ("output", "figures", "report")
_MATERIAL_KEYS = ("young", "poisson", "yield-strength")


def load(path: str | os.PathLike[str]) -> list[Entry]:
    """Read and check a project file.

    Parameters
    ----------
    path : str or path
        The file. ``folder`` and ``write`` (a list of suffixes) say what is written where;
        ``[materials.NAME]`` holds constants; ``[defaults]`` and each ``[[contact]]`` hold the
        options of ``roughcontact solve`` under their names, and a contact its ``name`` and
        ``file``. A list of loads makes one contact of each, and the ``folder`` of the volume model
        gets a folder for each. Paths are relative to the file.

    Returns
    -------
    list of Entry
        One for each contact and load.

    Raises
    ------
    FormatError
        If the file cannot be read or is no TOML.
    InputError
        If a key is unknown or a value cannot be used; the message names key and line.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        read = tomllib.loads(text)
    except OSError as error:
        raise FormatError(f"{path} cannot be read ({error.strerror}); check its name") from None
    except ValueError as error:
        raise FormatError(f"{path.name} is no TOML file: {error}") from None
    return list(_entries(path, read, _lines(text)))


Lines = dict[tuple[str, ...], int]

_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]#]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"""\s*("[^"]*"|'[^']*'|[A-Za-z0-9_-]+)\s*=""")


def _lines(text: str) -> Lines:
    """Return the line of every key, by table (with its number in a list) and key."""
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
            lines.setdefault((*table, key[1].strip("\"'")), number)
    return lines


def _entries(path: Path, read: dict[str, Any], lines: Lines) -> Iterator[Entry]:
    def place(*table: str) -> str:
        line = lines.get(table)
        return path.name + (f" line {line}" if line else "")

    for key in read:
        if key not in ("folder", "write", "materials", "defaults", "contact"):
            raise InputError(
                f"{place(key)}: unknown key {key}; known are folder, write, materials, defaults "
                "and contact"
            )
    contacts = read.get("contact", [])
    if not isinstance(contacts, list) or not contacts:
        raise InputError(f"{place('contact')}: there is no [[contact]] in this project")
    folder = read.get("folder", path.stem)
    if not isinstance(folder, str):
        raise InputError(f"{place('folder')}: folder must be a text, got {folder!r}")
    target = path.parent / folder
    if target.exists() and not target.is_dir():
        raise InputError(f"{place('folder')}: folder '{target}' is a file")
    wanted = read.get("write", ["nc"])
    if not isinstance(wanted, list) or not all(suffix in WRITABLE for suffix in wanted):
        raise InputError(
            f"{place('write')}: write must be a list of {', '.join(WRITABLE)}, got {wanted!r}"
        )
    materials = _tables(read.get("materials", {}), "materials", place)
    for name, constants in materials.items():
        for key in constants:
            if key not in _MATERIAL_KEYS:
                raise InputError(
                    f"{place('materials', name, key)}: unknown key {key}; known are "
                    f"{', '.join(_MATERIAL_KEYS)}"
                )
    defaults = read.get("defaults", {})
    if not isinstance(defaults, dict):
        raise InputError(f"{place('defaults')}: defaults must be a table, [defaults]")
    seen: dict[str, str] = {}
    for number, contact in enumerate(contacts):
        table = ("contact", str(number))
        if not isinstance(contact, dict):
            raise InputError(f"{place(*table)}: each contact must be a table, [[contact]]")
        where: dict[str, tuple[str, ...]] = {key: ("defaults", key) for key in defaults}
        where |= {key: (*table, key) for key in contact}
        values = {**defaults, **contact}
        for key in values:
            if key in _PLACED or (key not in OPTIONS and key not in _OWN_KEYS):
                known = ", ".join(k for k in (*_OWN_KEYS, *OPTIONS) if k not in _PLACED)
                raise InputError(f"{place(*where[key])}: unknown key {key}; known are {known}")
        for key in _OWN_KEYS:
            if not isinstance(contact.get(key), str) or not contact[key].strip():
                raise InputError(f"{place(*table)}: this contact needs a {key}, a text")
        loads = values.pop("load", None)
        where.setdefault("load", table)
        if loads == []:
            raise InputError(f"{place(*where['load'])}: load is an empty list")
        for load in loads if isinstance(loads, list) else [loads]:
            name = contact["name"] if not isinstance(loads, list) else f"{contact['name']} {load}"
            stem = re.sub(r"[^\w.+-]+", "-", name)
            if stem in seen:
                raise InputError(f"{place(*table)}: the name {name!r} is taken by {seen[stem]}")
            seen[stem] = place(*table)
            given = values if load is None else {**values, "load": load}
            described = _described(path, given, materials, where, place)
            described |= _outputs(target, stem, wanted)
            if "folder" in described:
                # One may be given to all contacts.
                described["folder"] = str(path.parent / str(described["folder"]) / stem)
            try:
                made = from_text(
                    path.parent / contact["file"], described, _namer(place, where, table)
                )
            except InputError as error:
                raise _placed(error, where, table, place) from None
            yield Entry(name, made, target / f"{stem}.json")


def _namer(
    place: Callable[..., str], where: Mapping[str, tuple[str, ...]], table: tuple[str, ...]
) -> Callable[[str], str]:
    return lambda key: f"{place(*where.get(key, table))}: {key}"


def _tables(read: Any, name: str, place: Callable[..., str]) -> dict[str, dict[str, Any]]:
    if not isinstance(read, dict) or not all(isinstance(value, dict) for value in read.values()):
        raise InputError(f"{place(name)}: {name} must be tables, [{name}.NAME]")
    return read


def _described(
    path: Path,
    values: Mapping[str, Any],
    materials: Mapping[str, Mapping[str, Any]],
    where: dict[str, tuple[str, ...]],
    place: Callable[..., str],
) -> dict[str, str | bool | list[str]]:
    """Return the options of a contact as the command line would give them.

    Constants of a material of the project go in its place; `where` then tells their keys.
    """
    given: dict[str, str | bool | list[str]] = {}
    for key, value in values.items():
        if key in _OWN_KEYS:
            continue
        prefix = key.removesuffix("material")
        if prefix != key and isinstance(value, str) and value in materials:
            for constant, text in materials[value].items():
                option = f"{prefix}{constant}"
                if option not in values:
                    where[option] = ("materials", value, constant)
                    given[option] = _word(text, constant, place(*where[option]))
            continue
        given[key] = _word(value, key, place(*where[key]))
        if key == "counter-surface":
            given[key] = str(path.parent / str(value))
    return given


def _word(value: Any, key: str, at: str) -> str | bool:
    flag = key in OPTIONS and not OPTIONS[key].metavar
    if isinstance(value, bool) and flag:
        return value
    if flag or isinstance(value, bool) or not isinstance(value, (str, int, float)):
        wanted = "true or false" if flag else "a text or a number"
        raise InputError(f"{at}: {key} must be {wanted}, got {value!r}")
    return str(value)


def _outputs(target: Path, stem: str, wanted: list[str]) -> dict[str, str | bool | list[str]]:
    """Return the options that write the wanted files of a contact."""
    given: dict[str, str | bool | list[str]] = {}
    for suffix in wanted:
        path = str(target / f"{stem}.{suffix}")
        if suffix in ("png", "svg", "pdf"):
            given["figures"] = path
        elif suffix == "html":
            given["report"] = path
        else:
            given["output"] = [*given.get("output", []), path]  # type: ignore[misc]
    return given


def _placed(
    error: InputError,
    where: Mapping[str, tuple[str, ...]],
    table: tuple[str, ...],
    place: Callable[..., str],
) -> InputError:
    """Return an error with the line of the key that it names, in the words of the file."""
    text = str(error)
    named = re.match(r"--([a-z-]+)", text)
    if named is None and ": " in text and text.startswith(place(*table).partition(" ")[0]):
        return error
    key = named[1] if named else ""
    return InputError(f"{place(*where.get(key, table))}: {text.replace('--', '')}")
