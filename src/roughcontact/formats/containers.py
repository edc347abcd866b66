"""Containers: maps of one or more surfaces in a ZIP archive.

Röttger et al. 2022, doi:10.1088/2051-672X/ac860a; layout as in SurfaceTopography 1.27. A text
``index.json``, in older containers ``meta.yml``, lists surfaces and their measurements. Data files
are ``original`` as uploaded, or ``squeezed-netcdf``, the heights after the preparation that the
site shows. The latter are preferred, as they need no other reader.

Keyence's ``.cag`` holds VK files, each in a separate folder, and XML that lists these folders
(``Path``) with the names of the files (``OriginalFileName``).
"""

from __future__ import annotations

import json
import math
import re
import shutil
import tempfile
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._tools import memory
from roughcontact.errors import FormatError, InputError
from roughcontact.formats import matrices, source
from roughcontact.formats.source import (
    Channel,
    InputFormat,
    ReadOptions,
    damage_as_error,
    unit_in_meters,
)
from roughcontact.surface.provenance import Operation
from roughcontact.surface.surface import Surface
from roughcontact.units import format_engineering

NAME = "container"
"""Name of the format."""

_INDEX, _YAML = "index.json", "meta.yml"
_SQUEEZED, _ORIGINAL = "squeezed-netcdf", "original"

# Largest number of measurements of a container, and of characters of its YAML index: they are
# listed within seconds.
_MAX_ENTRIES, _MAX_YAML = 1000, 2 * 10**6

# Relative difference of sizes in the index and in a data file that is noted.
_SIZE_TOLERANCE = 1e-3

# Formats of arrays whose first axis is x in SurfaceTopography, and y here.
_BARE = "npy", "npz", "hdf5"

FormatOf = Callable[[Path], InputFormat]


@dataclass(frozen=True)
class ContainerEntry:
    """Description of a measurement in the container."""

    name: str
    member: str  # Data file in the archive
    is_squeezed: bool
    size: tuple[float, ...]  # Sides along x and y, or length of a line scan, in `unit`
    unit: str
    channel: int  # Index in the data file
    scale: float  # Factor for the heights of the data file
    instrument: str

    @property
    def is_map(self) -> bool:
        """Whether it is a map, not a line scan."""
        return len(self.size) != 1


def read_container(path: Path, requested: ReadOptions, format_of: FormatOf) -> Surface:
    """Return a map of a container."""
    with _container_errors(path):
        measurements = _list_entries(path)
        maps = [name for name, item in measurements.items() if item.is_map]
        names = maps if maps and requested.channel is None else list(measurements)
        item = measurements[matrices.choose_array(path, names, requested.channel)]
        if not item.is_map:
            raise InputError(
                f"{item.name!r} of {path.name} is a line scan; unpack {item.member} and read it",
                argument="channel",
            )
        if item.unit:
            source.refuse_unit(path, requested)
            if item.size and requested.size is not None and not requested.override_size:
                source.resolve_pixel(path, (1.0, 1.0), (1, 1), requested)
        with _unpack_member(path, item.member, format_of) as (file, known):
            surface = _read_entry(path, file, known, item, requested)
    if item.is_squeezed:
        note = "heights as prepared by contact.engineering"
    else:
        surface = _scale_heights(surface, item.scale)
        note = f"heights times {item.scale:g}, as the container states" if item.scale != 1 else ""
    notes = [text for text in (note, _size_note(path, item, surface)) if text]
    about = replace(
        surface.provenance,
        source=path.name,
        channel=item.name if len(measurements) > 1 else "",
        instrument=item.instrument or surface.provenance.instrument,
    )
    for text in notes:
        about = about.then(Operation.note(text))
    return replace(surface, provenance=about)


def _size_note(path: Path, item: ContainerEntry, surface: Surface) -> str:
    """Return the note on a size of the index that contradicts the data file; empty if equal."""
    if not (item.size and item.unit):
        return ""
    metre = unit_in_meters(path, item.unit)
    stated = [side * metre for side in reversed(item.size)]
    if np.allclose(surface.size, stated, rtol=_SIZE_TOLERANCE, atol=0):
        return ""
    sizes = (
        " × ".join(format_engineering(side, "m") for side in sides)
        for sides in (stated, surface.size)
    )
    return "the container states a size of {}, the data file {}, which was used".format(*sizes)


def _scale_heights(surface: Surface, factor: float) -> Surface:
    """Return a map with the heights, and the unit of its numbers, times a factor."""
    about = surface.provenance
    assert about.origin is not None
    unit = about.origin.found["unit"] * factor
    origin = replace(about.origin, found={**about.origin.found, "unit": unit})
    return replace(
        surface, heights=surface.heights * factor, provenance=replace(about, origin=origin)
    )


def channels(path: Path, format_of: FormatOf) -> tuple[Channel, ...]:
    """Return the measurements of a container; line scans are not maps."""
    result = []
    # Many measurements may share a data file.
    listed: dict[str, tuple[Channel, ...]] = {}
    with _container_errors(path):
        for item in _list_entries(path).values():
            if not item.is_map:
                result.append(Channel(item.name, item.unit, False, ()))
                continue
            if item.member not in listed:
                with _unpack_member(path, item.member, format_of) as (file, known):
                    listed[item.member] = known.channels(file, known.name)
            inside = listed[item.member][item.channel]
            result.append(replace(inside, name=item.name, unit=inside.unit or item.unit))
    return tuple(result)


def _read_entry(
    path: Path, file: Path, known: InputFormat, item: ContainerEntry, requested: ReadOptions
) -> Surface:
    """Return the map in a data file; the container supplies a missing unit and size."""
    if known.name in _BARE:
        raise FormatError(
            f"{path.name} holds {item.member}, whose first axis may be x or y; unpack it and read "
            "that"
        )
    inside = known.channels(file, known.name)
    channel = item.channel if len(inside) > 1 else None
    requested = replace(requested, channel=channel)
    if not inside[item.channel].unit and item.unit:
        requested = replace(requested, unit=item.unit)
    try:
        return known.read(file, known.name, requested)
    except FormatError:
        raise
    except InputError:
        # Files with a size reject another one.
        if requested.size is not None or not item.size or not item.unit:
            raise
        metre = unit_in_meters(path, item.unit)
        along_x, along_y = item.size
        size = along_y * metre, along_x * metre
        return known.read(file, known.name, replace(requested, size=size))


def _list_entries(path: Path) -> dict[str, ContainerEntry]:
    """Return the entries of a container, with unique names."""
    with zipfile.ZipFile(path) as archive:
        name = next((name for name in (_INDEX, _YAML) if name in archive.namelist()), None)
        if name is None:
            entries = _list_vk_files(path, archive)
            if entries:
                return entries
            raise FormatError(
                f"{path.name} holds neither {_INDEX} nor {_YAML} of contact.engineering, nor VK "
                "files; unpack it and read a file with a map"
            )
        member = archive.getinfo(name)
        source.check_method(path, member)
        if member.file_size > memory.TEXT:
            raise FormatError(f"{path.name} holds {name} of {member.file_size} bytes, too long")
        text = archive.read(member).decode()
    surfaces = (json.loads(text) if name == _INDEX else _from_yaml(path, text))["surfaces"]
    listed = [
        (_text(surface, "name") if len(surfaces) > 1 else "", item)
        for surface in surfaces
        for item in surface["topographies"]
    ]
    if len(listed) > _MAX_ENTRIES:
        raise FormatError(
            f"{path.name} lists {len(listed)} measurements, the limit is {_MAX_ENTRIES}; download "
            "the surfaces one by one"
        )
    names = [
        f"{before}: {label}" if before else label
        for index, (before, item) in enumerate(listed)
        for label in (_text(item, "name") or str(index),)
    ]
    counts = Counter(names)
    result = {}
    for index, (name, (_, item)) in enumerate(zip(names, listed, strict=True)):
        if counts[name] > 1:
            name = f"{name} ({index})"
        result[name] = _parse_entry(path, name, item)
    return result


def _list_vk_files(path: Path, archive: zipfile.ZipFile) -> dict[str, ContainerEntry]:
    """Return the VK files of a Keyence project by their original names."""
    names: dict[str, str] = {}
    files: list[str] = []
    for member in archive.infolist():
        source.check_method(path, member)
        with archive.open(member) as stream:
            start = stream.read(3)
        if start in (b"VK3", b"VK4", b"VK6", b"VK7"):
            files.append(member.filename)
        elif start.startswith((b"<", b"\xef\xbb\xbf")) and member.file_size <= memory.TEXT:
            text = archive.read(member).decode("utf-8", "replace")
            folders, originals = (
                re.findall(f"<{tag}>([^<]+)<", text) for tag in ("Path", "OriginalFileName")
            )
            if len(folders) == len(originals):
                names.update(zip(folders, originals, strict=True))
    found: dict[str, ContainerEntry] = {}
    for index, file in enumerate(files):
        name = re.split(r"[/\\]", names.get(Path(file).parent.name, file))[-1]
        name = f"{name} ({index})" if name in found else name
        found[name] = ContainerEntry(name, file, False, (), "", 0, 1.0, "")
    return found


def _text(item: dict[str, Any], key: str) -> str:
    """Return a text of the index, where YAML has numbers as well; empty if it is missing."""
    value = item.get(key)
    if not isinstance(value, str | int | float | None):
        raise TypeError(f"{key} is a {type(value).__name__}, not a text")
    return str(value or "")


def _parse_entry(path: Path, name: str, item: dict[str, Any]) -> ContainerEntry:
    files = item["datafile"]
    squeezed = _text(files, _SQUEEZED)
    scale = item.get("height_scale")
    scale, source_index = 1.0 if scale is None else float(scale), int(item.get("data_source") or 0)
    size = tuple(map(float, item.get("size") or ()))
    for key, value, allowed in (
        ("size", size, len(size) <= 2 and all(0 < side < math.inf for side in size)),
        ("height_scale", scale, 0 < scale < math.inf),
        ("data_source", source_index, source_index >= 0),
    ):
        if not allowed:
            raise FormatError(f"{path.name} states {key} = {value} of {name!r}; correct its index")
    return ContainerEntry(
        name,
        squeezed or _text(files, _ORIGINAL),
        is_squeezed=bool(squeezed),
        size=size,
        unit=_text(item, "unit"),
        channel=0 if squeezed else source_index,
        scale=scale,
        instrument=_text(item.get("instrument") or {}, "name"),
    )


def _from_yaml(path: Path, text: str) -> Any:
    """Return the content of a YAML text; some containers have Python tuples."""
    yaml = source.import_optional(path, "yaml")
    # The parser of libyaml is ten times faster, where PyYAML has it.
    base: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    limit = _MAX_YAML if base is not yaml.SafeLoader else _MAX_YAML // 10
    if len(text) > limit:
        raise FormatError(f"{path.name} holds {_YAML} of {len(text)} characters, too long")
    # Nested aliases expand to more values than fit in memory.
    if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, base)):
        raise FormatError(f"{path.name} holds {_YAML} with aliases, which no container needs")
    loader: Any = type("Loader", (base,), {})
    loader.add_constructor("tag:yaml.org,2002:python/tuple", loader.construct_sequence)
    return yaml.load(text, loader)


@contextmanager
def _unpack_member(
    path: Path, name: str, format_of: FormatOf
) -> Iterator[tuple[Path, InputFormat]]:
    """Extract a data file of a container under its original name; yield path and format."""
    with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
        file = Path(folder) / Path(name).name
        with zipfile.ZipFile(path) as archive:
            member = archive.getinfo(name)
            source.check_method(path, member)
            size = member.file_size
            memory.require_size(f"{name} in {path.name}", size, packed=path.stat().st_size)
            with archive.open(member) as packed, file.open("xb") as copy:
                shutil.copyfileobj(packed, copy, source.BLOCK)
        known = format_of(file)
        if known.name == NAME:
            # An archive that contains itself would be unpacked forever.
            raise FormatError(f"{path.name} holds {name}, another archive; unpack it and read that")
        yield file, known


def _container_errors(path: Path) -> AbstractContextManager[None]:
    return damage_as_error(path, "a container", "download or export it again")
