"""Anything the program makes as named items of text: arrays by digest, files by what they hold.

Differences between two runs of the same code are removed: wall times, dates, versions and
temporary folders.
"""

from __future__ import annotations

import base64
import dataclasses
import functools
import hashlib
import html
import io
import json
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from matplotlib.image import imread

import roughcontact as rc

Items = dict[str, str]
"""Text of every item by name; an array's text is its type, shape and digest."""

# Texts that differ between two runs of the same code. Numbers of a result are kept.
# Fields and keys. Checksums and seals cover the times.
VOLATILE = re.compile(r"_.*|checksum.*|sha256|seal|(.*_)?(seconds|version)(\.npy| \[s\])?")
_NORMAL = [
    (re.compile(r"\x1b\[[0-9;]*m"), ""),
    (
        re.compile(r"\d{4}-\d\d-\d\d(?:[T ]\d\d:\d\d(?::\d\d(?:\.\d+)?)?)?(?:Z|[+-]\d\d:\d\d)?"),
        "<date>",
    ),
    (re.compile(r"(\"seconds\": )[-+.e\d]+"), r"\1<time>"),
    (re.compile(r"\b[\d.]+(?:e[-+]\d+)? ?(?:s|ms|min|seconds|minutes)\b"), "<time>"),
    (re.compile(r"\b[\d.]+ [KMGT]iB (free|available|of memory)"), r"<memory> \1"),
    (re.compile(r" at 0x[0-9a-f]+"), " at <address>"),
    # Progress messages depend on how long a task takes; files of results hold times.
    (re.compile(r"^progress: .*\n", re.MULTILINE), ""),
    (re.compile(r"(\.nc\": )\"[0-9a-f]{64}\""), r"\1<checksum>"),
    (re.compile(r"[ \t]+$", re.MULTILINE), ""),
]


def normalize_text(text: str, folder: Path) -> str:
    """Return a text without times, dates, versions and the temporary folder."""
    for place in {str(folder), str(folder.resolve())}:
        text = text.replace(place, "<folder>")
    text = text.replace(rc.__version__, "<version>")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    for pattern, word in _NORMAL:
        text = pattern.sub(word, text)
    return text


def digest(content: bytes) -> str:
    """Return the first 16 hexadecimal digits of the SHA-256."""
    return hashlib.sha256(content).hexdigest()[:16]


# Values as text --------------------------------------------------------------------------


def json_value(value: Any) -> Any:
    """Return a value as JSON can write it: arrays by digest, dataclasses by their fields."""
    if isinstance(value, np.ndarray):
        if value.dtype == object:
            return [json_value(entry) for entry in value.ravel()]
        held = repr(value.item()) if value.size == 1 else digest(value.tobytes())
        return f"{value.dtype.str} {value.shape} {held}"
    if isinstance(value, np.generic):
        return json_value(value.item())
    if isinstance(value, rc.Provenance):
        # As text, which is the same for both layouts of the steps.
        names = ("source", "instrument", "channel", "steps")
        value = {name: getattr(value, name) for name in names}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {
            str(key): json_value(entry) for key, entry in value.items() if is_compared(str(key))
        }
    if isinstance(value, list | tuple):
        return [json_value(entry) for entry in value]
    if isinstance(value, bytes):
        return f"bytes {digest(value)}"
    if value is None or isinstance(value, str | bool | int | float):
        return value
    return repr(value)


def is_compared(name: str) -> bool:
    """Return whether a field is compared: public, and the same in every run."""
    return not VOLATILE.fullmatch(name)


def value_text(value: Any) -> str:
    """Return a value as text: a string as it is, everything else as JSON."""
    found = json_value(value)
    return found if isinstance(found, str) else json.dumps(found, indent=1, ensure_ascii=False)


def items_of(value: Any) -> Items:
    """Return fields, properties and summary of a result, as separate items."""
    if not dataclasses.is_dataclass(value) or isinstance(value, type):
        return {"": value_text(value)}
    found = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    for name in dir(type(value)):
        if isinstance(getattr(type(value), name), property | functools.cached_property):
            try:
                found[name] = getattr(value, name)
            except Exception as error:
                found[name] = f"{type(error).__name__}: {error}"
    if hasattr(value, "summary"):
        found["summary"] = value.summary()
    return {name: value_text(entry) for name, entry in found.items() if is_compared(name)}


# Contents of files --------------------------------------------------------------------------------


def read_html(path: Path) -> Items:
    """Return the readable text of a report, and its pictures."""
    text = path.read_text(encoding="utf-8")
    pictures = re.findall(r"data:image/png;base64,([A-Za-z0-9+/=\s]+)", text)
    pixels = [imread(io.BytesIO(base64.b64decode(entry))) for entry in pictures]
    text = re.sub(r"<(script|style)\b.*?</\1>", "", text, flags=re.DOTALL)
    text = re.sub(r"<svg\b.*?</svg>", "[svg]", text, flags=re.DOTALL)
    text = re.sub(r"[ \t]*\n\s*", "\n", html.unescape(re.sub(r"<[^>]*>", " ", text)))
    return {"": re.sub(r"[ \t]+", " ", text), "pictures": value_text(pixels)}


def read_netcdf(path: Path) -> Items:
    """Return variables and attributes, less what the format keeps for itself."""
    found: dict[str, Any] = {}
    own = ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")

    def visit(name: str, node: Any) -> None:
        for key, entry in node.attrs.items():
            if is_compared(key) and key not in own:
                found[f"{name}@{key}"] = entry
        if isinstance(node, h5py.Dataset) and is_compared(name.rpartition("/")[2]):
            found[name] = node[()]

    with h5py.File(path, "r") as file:
        visit("", file)
        file.visititems(visit)
    return {"": value_text(dict(sorted(found.items())))}


def read_zip(path: Path) -> Items:
    """Return the members of an archive: X3P without its checksum, which covers the date."""
    found: dict[str, Any] = {}
    with zipfile.ZipFile(path) as archive:
        for name in sorted(archive.namelist()):
            content = archive.read(name)
            if not is_compared(name):
                continue
            if name.endswith(".npy"):
                found[name] = np.load(io.BytesIO(content))
            elif not name.endswith("md5checksum.hex"):
                found[name] = content.decode() if name.endswith(".xml") else content
    return {"": "\n".join(f"{name}\n{value_text(entry)}" for name, entry in found.items())}


def read_csv(path: Path) -> Items:
    """Return a table without the columns of times."""
    lines = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    columns = [n for n, name in enumerate(lines[0]) if is_compared(name.strip())]
    if len(columns) == len(lines[0]):
        return {"": path.read_text(encoding="utf-8")}
    return {"": "\n".join(",".join(line[n] for n in columns) for line in lines)}


def read_svg(path: Path) -> Items:
    """Return a drawing with its random names numbered in their order."""
    text = path.read_text(encoding="utf-8")
    names: dict[str, str] = {}
    for name in re.findall(r"\bid=\"([^\"]+)\"", text):
        names.setdefault(name, f"name{len(names)}")
    return {"": re.sub(r"(?<=[\"#])[\w-]+(?=[\")])", lambda m: names.get(m[0], m[0]), text)}


def read_vtk(path: Path) -> Items:
    """Return the header as text and everything as bytes."""
    content = path.read_bytes().replace(rc.__version__.encode(), b"<version>")
    head = content.partition(b"<AppendedData")[0][:4000].decode("utf-8", "replace")
    return {"": f"{head}\nbytes {digest(content)}"}


READERS: dict[str, Callable[[Path], Items]] = {
    ".html": read_html,
    ".nc": read_netcdf,
    ".csv": read_csv,
    ".npz": read_zip,
    ".x3p": read_zip,
    ".svg": read_svg,
    ".vti": read_vtk,
    ".vtr": read_vtk,
    ".png": lambda path: {"": value_text(imread(path))},
    ".pdf": lambda path: {"": path.read_bytes()[:5].decode()},
    ".npy": lambda path: {"": value_text(np.load(path))},
    ".json": lambda path: {"": value_text(json.loads(path.read_text(encoding="utf-8")))},
}


def items_of_file(path: Path) -> Items:
    """Return the content of a file; text and unknown formats unchanged."""
    if path.suffix in READERS:
        return READERS[path.suffix](path)
    content = path.read_bytes()
    try:
        return {"": content.decode("utf-8")}
    except UnicodeDecodeError:
        return {"": value_text(content)}
