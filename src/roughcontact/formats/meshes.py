"""Triangulated height fields: STL, PLY and OBJ.

The vertices are read, not the triangles: a mesh is a map if its vertices fill a grid, each with one
height. None of the formats has a unit. PLY: G. Turk, The PLY polygon file format.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from roughcontact._tools import memory
from roughcontact._tools.arrays import Array
from roughcontact.errors import FormatError
from roughcontact.formats import matrices, text_files
from roughcontact.formats.source import Channel, ReadOptions, damage_as_error
from roughcontact.formats.text_files import Head
from roughcontact.surface.surface import Surface

_STL_HEAD = 84
_STL_FACET = np.dtype([("normal", "<f4", 3), ("vertices", "<f4", (3, 3)), ("attribute", "<u2")])
_NUMBERS = r"\s+(\S+)\s+(\S+)\s+(\S+)"
_LINES = {
    "obj": re.compile(rb"^v" + _NUMBERS.encode(), re.MULTILINE),
    "stl": re.compile(rb"^\s*vertex" + _NUMBERS.encode(), re.MULTILINE),
}
# Names of types in C that NumPy has under another name.
_PLY_TYPES = dict(
    char="b", uchar="B", short="h", ushort="H", int="i", uint="I", float="f", double="d"
)


def read_mesh(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map of the vertices of a mesh; ``name`` is its format."""
    vertices = _vertices(path, name)
    return matrices.map_of_points(path, name, vertices, Head(0, columns=True), (), requested)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the map of a mesh as its only channel."""
    return (Channel("", "", True, text_files.grid_points(path, _vertices(path, name))[0].shape),)


def _vertices(path: Path, name: str) -> Array:
    """Return the different vertices of a mesh with one height per point of the plane."""
    memory.require_size(path.name, 4 * path.stat().st_size)
    with damage_as_error(path, f"a mesh in {name.upper()}", "copy or export it again"):
        content = path.read_bytes()
        count = int.from_bytes(content[80:_STL_HEAD], "little")
        if name == "ply":
            vertices = _ply(content)
        elif name == "stl" and len(content) == _STL_HEAD + count * _STL_FACET.itemsize:
            vertices = np.frombuffer(content, _STL_FACET, offset=_STL_HEAD)["vertices"]
        else:
            found = _LINES[name].findall(content)
            vertices = np.array([tuple(map(float, numbers)) for numbers in found])
        vertices = vertices.reshape(-1, 3).astype(np.float64)
        points = np.unique(vertices, axis=0)
        if len(points) < 4:
            raise ValueError(f"{len(points)} vertices")
    places = np.unique(points[:, :2], axis=0)
    if len(places) < len(points):
        raise FormatError(
            f"{path.name} is a mesh of {len(points)} vertices with several heights at "
            f"{len(points) - len(places)} points, a body rather than a height field; export the "
            "surface as a map, .x3p, .sur or points x y z"
        )
    return points


def _ply(content: bytes) -> Array:
    """Return the vertices of a PLY file, whose first element they are."""
    head, _, body = content.partition(b"end_header")
    body = body.partition(b"\n")[2]
    words = [line.split() for line in head.decode("ascii").splitlines()]
    kind = next(line[1] for line in words if line[0] == "format")
    first = next(i for i, line in enumerate(words) if line[0] == "element")
    if words[first][1] != "vertex":
        raise ValueError("its first element is no vertex")
    count = int(words[first][2])
    properties = []
    for line in words[first + 1 :]:
        if line[0] != "property":
            break
        properties.append((line[2], np.dtype(_PLY_TYPES.get(line[1], line[1]))))
    if kind == "ascii":
        rows = body.decode("ascii").split("\n", count)[:count]
        table = np.array([row.split() for row in rows], dtype=np.float64)
        names = [name for name, _ in properties]
        return table[:, [names.index(axis) for axis in "xyz"]]
    fields = np.dtype(properties).newbyteorder("<" if "little" in kind else ">")
    values = np.frombuffer(body, fields, count)
    return np.stack([values[axis] for axis in "xyz"], axis=1).astype(np.float64)
