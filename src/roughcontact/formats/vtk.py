"""Maps and volumes for ParaView, in VTK's XML formats.

`save_vtk`: A pixel is an area, but its values are stored at its center, as data of the points of
the image, not of its cells: *Warp By Scalar*, which converts the flat image into a relief, requires
point data. Select ``height`` in it and a scale factor to exaggerate the heights, and color by
``pressure``. The image therefore ends half a pixel before the edge of the map on each side.
*Threshold* over the whole range of ``height`` removes the missing points from the relief.

All lengths are in meters; the field data ``units`` gives the unit of each map. The layout is VTK's
XML ImageData with appended data, base64, zlib, little-endian, headers of 64 bits.

Kitware, VTK File Formats, "XML File Formats", https://docs.vtk.org/en/latest/vtk_file_formats/

`save_vtr`: A cell is a pixel of a layer; its values are averages over the thickness of the layer.
The map begins at x = y = 0 as in the file of `save_vtk`, surrounded by the margin of the volume.
The surface is z = 0 and z points up: the rough body is below, its counter-body above, as far as
they yield. The tensors are in these axes, hence the shear components xz and yz of the lower body
have the opposite sign of those of `PlasticBody`, whose z points into the body.

``plastic_strain``, ``stress`` and ``residual_stress`` have the components XX, YY, ZZ, XY, YZ, XZ,
the order of symmetric tensors in VTK; shear strains are tensor components, half the engineering
strains. Stress includes its mean, tension is positive. ``accumulated_plastic_strain``,
``von_mises`` and ``residual_von_mises`` are scalars. Numbers have the precision of the volume,
lengths are in meters, the field data ``units`` gives the other units. The layout is VTK's XML
RectilinearGrid with appended data as in `save_vtk`: the layers are graded, and an image has equal
steps only.

Kitware, VTK File Formats, "XML File Formats", https://docs.vtk.org/en/latest/vtk_file_formats/

`save_pvd`: A step is one second of ParaView's time; the volume is part 0 of the series, the surface
part 1.
"""

from __future__ import annotations

import base64
import os
import struct
import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.files import atomic_write, require_suffix
from roughcontact.elastoplastic.volume_result import ElastoplasticResult, PlasticBody
from roughcontact.formats import tables
from roughcontact.formats.source import BLOCK, iter_blocks, little_endian
from roughcontact.halfspace.tensors import equivalent, tensor
from roughcontact.surface.surface import Surface

_VTK_TYPES = {"b1": "UInt8", "f4": "Float32", "f8": "Float64"}
_SYMMETRIC = ("XX", "YY", "ZZ", "XY", "YZ", "XZ")


def save_vtk(source: Surface | tables.Result, path: str | os.PathLike[str]) -> None:
    """Write all maps to one VTK image, which ParaView opens."""
    require_suffix(path, ".vti")
    surface = tables.surface_of(source)
    (ny, nx), (dy, dx) = surface.shape, surface.pixel
    names = tables.map_names(source)
    maps = [
        _VtkArray.from_values(name, tables.field_values(source, name), tables.UNITS[name])
        for name in names
    ]
    shown = "pressure" if "pressure" in names else "height"
    _write_vtk(
        path,
        "ImageData",
        f"0 {nx - 1} 0 {ny - 1} 0 0",
        f' Origin="{dx / 2!r} {dy / 2!r} 0" Spacing="{dx!r} {dy!r} 1"',
        {f'PointData Scalars="{shown}"': maps},
    )


def save_vtr(result: ElastoplasticResult, path: str | os.PathLike[str]) -> None:
    """Write plastic strain and stress of the volume to a VTK grid, which ParaView opens."""
    require_suffix(path, ".vtr")
    (ny, nx), (dy, dx) = result.solution.surface.shape, result.solution.surface.pixel
    margin = result.bodies[0].margin
    x = np.arange(-margin, nx + margin + 1) * dx
    y = np.arange(-margin, ny + margin + 1) * dy
    z, cells = _stack_layers(result)
    axes = [
        _VtkArray.from_values(name, values, "m")
        for name, values in zip("xyz", (x, y, z), strict=True)
    ]
    # One layer at a time: a tensor of the whole volume would need its memory again.
    data = [
        _VtkArray(name, cells[0].body.stress.dtype, unit, components, map(show, cells))
        for name, unit, components, show in _CELL_DATA
    ]
    _write_vtk(
        path,
        "RectilinearGrid",
        f"0 {x.size - 1} 0 {y.size - 1} 0 {z.size - 1}",
        "",
        {'CellData Scalars="von_mises"': data, "Coordinates": axes},
    )


class _Layer(NamedTuple):
    """Layer of cells; ``side`` is -1 below the surface, 1 above."""

    side: int
    body: PlasticBody
    number: int

    def layer_values(self, name: str) -> NDArray[Any]:
        """Return the part of an array of the body in this layer."""
        return getattr(self.body, name)[self.number]


def _stack_layers(result: ElastoplasticResult) -> tuple[NDArray[np.float64], list[_Layer]]:
    """Return the faces [m] and the layers of all bodies that yield, from the lowest up."""
    pair = result.solution.material, result.solution.counter_material
    sides = [
        side for side, body in zip((-1, 1), pair, strict=True) if body.yield_strength is not None
    ]
    cells: list[_Layer] = []
    faces = [0.0]
    for side, body in zip(sides, result.bodies, strict=True):
        layers = [_Layer(side, body, number) for number in range(body.thickness.size)]
        depths = np.cumsum(body.thickness).tolist()
        if side < 0:
            cells, faces = layers[::-1], [-depth for depth in depths[::-1]] + faces
        else:
            cells, faces = cells + layers, faces + depths
    return np.array(faces), cells


def _tensor(name: str, mean: str | None = None) -> Callable[[_Layer], NDArray[Any]]:
    """Return a function for the six components of a tensor in the axes of the file."""

    def tensor_components(cell: _Layer) -> NDArray[Any]:
        full = tensor(cell.layer_values(name), 0 if mean is None else cell.layer_values(mean))
        six: NDArray[Any] = full[..., (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)]
        six[..., 4:] *= cell.side
        return six

    return tensor_components


# Name, unit and number of components of a field over all cells, and its values in a layer.
_CELL_DATA: tuple[tuple[str, str, int, Callable[[_Layer], NDArray[Any]]], ...] = (
    ("plastic_strain", "1", 6, _tensor("plastic_strain")),
    ("accumulated_plastic_strain", "1", 1, lambda cell: cell.layer_values("accumulated")),
    ("stress", "Pa", 6, _tensor("stress", "mean_stress")),
    ("von_mises", "Pa", 1, lambda cell: equivalent(cell.layer_values("stress"))),
    ("residual_stress", "Pa", 6, _tensor("residual_stress", "mean_residual_stress")),
    ("residual_von_mises", "Pa", 1, lambda cell: equivalent(cell.layer_values("residual_stress"))),
)


@dataclass(frozen=True, eq=False)
class _VtkArray:
    """Array of a VTK file, whose numbers are supplied in consecutive parts."""

    name: str
    dtype: np.dtype[Any]
    unit: str
    components: int
    parts: Iterable[NDArray[Any]]

    @classmethod
    def from_values(cls, name: str, values: NDArray[Any], unit: str) -> _VtkArray:
        return cls(name, values.dtype, unit, 1, (values,))

    def tag(self, offset: int) -> str:
        shape = ""
        if self.components > 1:
            shape = f' NumberOfComponents="{self.components}"' + "".join(
                f' ComponentName{number}="{name}"' for number, name in enumerate(_SYMMETRIC)
            )
        return (
            f'        <DataArray type="{_VTK_TYPES[self.dtype.str[1:]]}" Name="{self.name}"{shape} '
            # Constant length, as the header is overwritten at the end.
            f'format="appended" offset="{offset:020d}"/>\n'
        )


def _write_vtk(
    path: str | os.PathLike[str],
    kind: str,
    extent: str,
    attributes: str,
    groups: Mapping[str, list[_VtkArray]],
) -> None:
    """Write one piece of a structured grid as VTK's XML with appended data."""
    arrays = [array for group in groups.values() for array in group]
    units = [f"{array.name}: {array.unit}\0".encode("ascii") for array in arrays]

    def head(offsets: list[int]) -> bytes:
        remaining = iter(offsets)
        data = "".join(
            f"      <{tag}>\n"
            + "".join(array.tag(next(remaining)) for array in group)
            + f"      </{tag.split()[0]}>\n"
            for tag, group in groups.items()
        )
        text = (
            '<?xml version="1.0"?>\n'
            f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64" compressor="vtkZLibDataCompressor">\n'
            f'  <{kind} WholeExtent="{extent}"{attributes}>\n'
            "    <FieldData>\n"
            f'      <Array type="String" Name="units" NumberOfTuples="{len(units)}" '
            f'format="ascii">{" ".join(map(str, b"".join(units)))}</Array>\n'
            "    </FieldData>\n"
            f'    <Piece Extent="{extent}">\n'
            f"{data}"
            "    </Piece>\n"
            f"  </{kind}>\n"
            '  <AppendedData encoding="base64">\n'
            "_"
        )
        return text.encode("ascii")

    with atomic_write(path) as stream:
        start = stream.write(head([0] * len(arrays)))
        offsets = []
        for array in arrays:
            offsets.append(stream.tell() - start)
            _append(stream, array.parts)
        stream.write(b"\n  </AppendedData>\n</VTKFile>\n")
        stream.seek(0)
        stream.write(head(offsets))


def _append(stream: IO[bytes], parts: Iterable[NDArray[Any]]) -> None:
    """Write an array of appended data: its table of blocks, then the blocks, in base64."""
    packed, pending = [], b""
    for part in parts:
        for piece in iter_blocks(little_endian(part)):
            pending += piece
            if len(pending) >= BLOCK:
                packed.append(zlib.compress(pending[:BLOCK], 1))
                pending = pending[BLOCK:]
    if pending:
        packed.append(zlib.compress(pending, 1))
    table = (len(packed), BLOCK, len(pending), *map(len, packed))
    stream.write(base64.b64encode(struct.pack(f"<{len(table)}Q", *table)))
    # Encoded as one stream: three bytes become four letters, and only the end is padded.
    rest = b""
    for block in packed:
        joined = rest + block
        whole = len(joined) // 3 * 3
        stream.write(base64.b64encode(joined[:whole]))
        rest = joined[whole:]
    stream.write(base64.b64encode(rest))
