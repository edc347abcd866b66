"""Maps and results in the formats of other programs: VTK, CSV, X3P, SUR, NumPy, JSON.

========= ============ ============ ==========================================================
suffix    of a surface of a result  what is kept
========= ============ ============ ==========================================================
``.nc``   yes          yes          everything; see `roughcontact.contact.archive`
``.npz``  yes          no           heights and pixel, every bit
``.x3p``  yes          no           heights and pixel, every bit; ISO 25178-72
``.sur``  yes          no           heights to 32 bits, pixel in single precision; Digital Surf
``.csv``  yes          one map      every bit, as text
``.vti``  yes          all maps     every bit; ParaView
``.vtr``  no           the volume   strain and stress in the layers, every bit; ParaView
``.json`` no           the summary  numbers and words
========= ============ ============ ==========================================================

Results are those of `roughcontact.solve` and of `roughcontact.solve_elastoplastic`; only these have
a volume. A missing point is a missing point in each of them, and row 0 is the row of smallest y.
What is written appears under its name only once it is complete. Figures are drawn by
`roughcontact.plots`.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import math
import os
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughcontact._version import __version__
from roughcontact.contact.archive import save_result, surface_to_dataset
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.files import replacing, to_json
from roughcontact.formats.matrices import TEXT_MARK
from roughcontact.halfspace import tensors
from roughcontact.surface.surface import Surface
from roughcontact.volume.archive import save_elastoplastic
from roughcontact.volume.result import ElastoplasticResult, PlasticBody

Array = NDArray[np.float64]
Result = ContactResult | ElastoplasticResult
Source = TypeVar("Source", Surface, ContactResult, ElastoplasticResult)

# Every map of a result, with its unit.
_UNITS = {
    "height": "m",
    "counter_height": "m",
    "initial_gap": "m",
    "pressure": "Pa",
    "gap": "m",
    "contact": "1",
    "saturated": "1",
    "residual_indentation": "m",
    "ceiling": "Pa",
    "residual_displacement": "m",
}
# Those that only one of the two models has.
_CEILING_ONLY = {"saturated", "residual_indentation", "ceiling"}
_VOLUME_ONLY = {"residual_displacement"}

_SUMMARY_UNITS = {
    "certificate": "1",
    "load_error": "1",
    "moments": "N m",
    "moment_error": "1",
    "tilt": "rad",
    "tolerance": "1",
    "load": "N",
    "approach": "m",
    "contact_modulus": "Pa",
    "ceiling": "Pa",
    "contact_area": "m2",
    "contact_fraction": "1",
    "saturated_fraction": "1",
    "max_pressure": "Pa",
    "mean_gap": "m",
    "max_residual_indentation": "m",
    "shape": "1",
    "pixel": "m",
    "iterations": "1",
    "convolutions": "1",
    "seconds": "s",
    "young": "Pa",
    "poisson": "1",
    "yield_strength": "Pa",
    "hardness": "Pa",
}

# Bytes handled at a time; divisible by the size of every number.
_BLOCK = 2**20

# Bytes of a member of an archive from which it gets the header for more than 2 GB, which not
# every reader knows.
_LARGE = 2**30


def save_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map in the format that the suffix of the file names.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write: ``.npz``, ``.nc``, ``.x3p``, ``.sur``, ``.csv`` or ``.vti``.

    Raises
    ------
    InputError
        If the suffix is none of these, or the map does not fit into the format.
    OSError
        If the file cannot be written; an old file survives.

    See Also
    --------
    roughcontact.read_surface : Reads all of them but ``.vti``.
    """
    _writer(_SURFACE_WRITERS, path, "a surface")(surface, path)


def save(result: Result, path: str | os.PathLike[str]) -> None:
    """Write a result in the format that the suffix of the file names.

    Parameters
    ----------
    result : ContactResult or ElastoplasticResult
        The result.
    path : str or path
        File to write: ``.nc`` (everything), ``.vti`` (all maps), ``.csv`` (the pressure),
        ``.json`` (the summary) or, with plasticity of the volume, ``.vtr`` (the volume).

    Raises
    ------
    InputError
        If the suffix is none of these.
    OSError
        If the file cannot be written; an old file survives.

    See Also
    --------
    roughcontact.load_result : Reads ``.nc`` again.
    roughcontact.contact.archive.load_elastoplastic : Reads that of an `ElastoplasticResult`.
    """
    if isinstance(result, ElastoplasticResult):
        _writer(_VOLUME_WRITERS, path, "a result with its volume")(result, path)
    else:
        _writer(_RESULT_WRITERS, path, "a result")(result, path)


def save_netcdf(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map to a NetCDF file: heights, pixel and provenance.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.nc``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".nc")
    with replacing(path) as temporary:
        surface_to_dataset(surface).to_netcdf(temporary, engine="h5netcdf")


def save_npz(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map to a NumPy archive.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.npz``. It holds the arrays ``heights`` [y, x] and
        ``pixel`` (dy, dx), and in ``unit`` the unit of both: an archive with these three needs no
        unit and size when it is read.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".npz")
    with replacing(path) as temporary, temporary.open("wb") as stream:
        np.savez(stream, heights=surface.heights, pixel=np.array(surface.pixel), unit=np.array("m"))


def save_csv(
    source: Surface | Result, path: str | os.PathLike[str], field: str | None = None
) -> None:
    """Write one map as a matrix of numbers, one row of the map a line.

    Parameters
    ----------
    source : Surface, ContactResult or ElastoplasticResult
        Where the map is taken from.
    path : str or path
        File to write; it must end in ``.csv``.
    field : str, optional
        Which map: ``"height"``, ``"counter_height"``, ``"initial_gap"``, ``"pressure"``,
        ``"gap"``, ``"contact"``, ``"saturated"``, ``"residual_indentation"``, ``"ceiling"``,
        ``"residual_displacement"``, as far as the source has them. By default the heights of a
        surface, the pressure of a result.

    Raises
    ------
    InputError
        If the suffix is another, or the source has no such map.
    OSError
        If the file cannot be written; an old file survives.

    Notes
    -----
    Lines that start with # head the file and name quantity, unit and pixel; `read_surface` takes
    unit and size of a file of heights from them. Every number keeps its bits; "nan" is a missing
    point, and masks are 0 and 1.
    """
    _require_suffix(path, ".csv")
    if field is None:
        field = "height" if isinstance(source, Surface) else "pressure"
    known = _names(source)
    if field not in known:
        raise InputError(
            f"must be one of {', '.join(known)}, got {field!r}", argument="field", value=field
        )
    (dy, dx), values = _surface_of(source).pixel, _values(source, field)
    if values.dtype == np.bool_:
        values = values.astype(np.uint8)
    with (
        replacing(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.write(
            f"{TEXT_MARK}\n"
            f"# quantity: {field}\n"
            f"# unit: {_UNITS[field]}\n"
            f"# pixel_y: {dy!r} m\n"
            f"# pixel_x: {dx!r} m\n"
            f"# {values.shape[0]} rows along y from the smallest y on, {values.shape[1]} columns "
            "along x; nan where missing\n"
        )
        for row in values:
            stream.write(",".join(map(repr, row.tolist())))
            stream.write("\n")


def save_table(result: ContactResult, path: str | os.PathLike[str]) -> None:
    """Write the summary of a result as a table of name, value and unit.

    Parameters
    ----------
    result : ContactResult
        The result.
    path : str or path
        File to write; it must end in ``.csv``. One line a number or word; several values of one
        name are separated by semicolons, pairs in the order (y, x). Units are SI.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".csv")
    rows = [
        (f"{name}_{part}" if part else name, entry)
        for name, value in record(result).items()
        for part, entry in (value.items() if isinstance(value, dict) else [("", value)])
    ]
    with (
        replacing(path) as temporary,
        temporary.open("w", encoding="utf-8", errors="backslashreplace", newline="") as stream,
    ):
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(("name", "value", "unit"))
        for name, value in rows:
            quantity = name.removeprefix("counter_").removeprefix("material_")
            unit = _SUMMARY_UNITS.get(quantity, "")
            table.writerow((name, _cell(value), "" if isinstance(value, str) else unit))


def save_json(result: Result, path: str | os.PathLike[str]) -> None:
    """Write the summary of a result, as `record` gives it, as JSON in SI units.

    Parameters
    ----------
    result : ContactResult or ElastoplasticResult
        The result.
    path : str or path
        File to write; it must end in ``.json``. Numbers that are not finite are ``null``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".json")
    with replacing(path) as temporary:
        temporary.write_text(to_json(record(result)) + "\n", encoding="utf-8")


def record(result: Result) -> dict[str, Any]:
    """Return the summary of a result with the bodies that went in.

    Parameters
    ----------
    result : ContactResult or ElastoplasticResult
        The result.

    Returns
    -------
    dict
        `ContactResult.summary` and ``converged``, ``precision``, ``material``,
        ``counter_material``, ``counter_source``, ``counter_preparation``; SI units. With plasticity
        of the volume also ``volume``, the `ElastoplasticResult.summary`.
    """
    if isinstance(result, ElastoplasticResult):
        told = result.summary()
        # The contact alone knows no plastic strain.
        own = {name: told[name] for name in ("status", "regime", "warnings")}
        return {**record(result.contact), **own, "converged": result.converged, "volume": told}
    bodies = {"material": result.material, "counter_material": result.counter_material}
    other = result.counter_surface
    return {
        **result.summary(),
        "converged": result.converged,
        "precision": result.precision,
        **{
            name: {
                "rigid": math.isinf(body.young),
                "young": body.young,
                "poisson": body.poisson,
                "yield_strength": body.yield_strength,
                "hardness": body.hardness,
            }
            for name, body in bodies.items()
        },
        "counter_source": None if other is None else other.provenance.source,
        "counter_preparation": None if other is None else list(other.provenance.steps),
    }


def save_vtk(source: Surface | Result, path: str | os.PathLike[str]) -> None:
    """Write all maps to one VTK image, which ParaView opens.

    Parameters
    ----------
    source : Surface, ContactResult or ElastoplasticResult
        The heights of a surface; of a result ``height``, ``initial_gap``, ``pressure``, ``gap``,
        ``contact``, and ``counter_height`` where it is a map; with a ceiling ``saturated``,
        ``residual_indentation`` and ``ceiling`` where it is a map; with plasticity of the volume
        ``residual_displacement``. NaN where missing.
    path : str or path
        File to write; it must end in ``.vti``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.

    See Also
    --------
    save_vtr : What lies below the surface.

    Notes
    -----
    A pixel is an area, yet its values are stored at its centre, as data of the points of the
    image, not of its cells: *Warp By Scalar*, which turns the flat image into a relief, takes
    nothing else. Choose ``height`` in it and a scale factor to exaggerate the heights, and colour
    by ``pressure``. The image therefore ends half a pixel before the edge of the map on each side.
    *Threshold* over the whole range of ``height`` cuts the missing points out of the relief.

    All lengths are in metres; the field data ``units`` says the unit of each map. The layout is
    VTK's XML ImageData with appended data, base64, zlib, little-endian, headers of 64 bits.

    References
    ----------
    Kitware, VTK File Formats, "XML File Formats", https://docs.vtk.org/en/latest/vtk_file_formats/
    """
    _require_suffix(path, ".vti")
    surface = _surface_of(source)
    (ny, nx), (dy, dx) = surface.shape, surface.pixel
    names = _names(source)
    maps = [_VtkArray.of(name, _values(source, name), _UNITS[name]) for name in names]
    shown = "pressure" if "pressure" in names else "height"
    _write_vtk(
        path, "ImageData", f"0 {nx - 1} 0 {ny - 1} 0 0",
        f' Origin="{dx / 2!r} {dy / 2!r} 0" Spacing="{dx!r} {dy!r} 1"',
        {f'PointData Scalars="{shown}"': maps},
    )  # fmt: skip


def save_vtr(result: ElastoplasticResult, path: str | os.PathLike[str]) -> None:
    """Write plastic strain and stress of the volume to a VTK grid, which ParaView opens.

    Parameters
    ----------
    result : ElastoplasticResult
        The result.
    path : str or path
        File to write; it must end in ``.vtr``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.

    See Also
    --------
    save_vtk : The maps of the surface.

    Notes
    -----
    A cell is a pixel of a layer; its values are those of the layer, averages over its thickness.
    The map begins at x = y = 0 as in the file of `save_vtk`, and the margin of the volume lies
    around it. The surface is z = 0 and z points up: the rough body lies below, its counter-body
    above, as far as they yield. The tensors are in these axes, hence the shear components xz and yz
    of the lower body are those of `PlasticBody`, whose z points into the body, with the other sign.

    ``plastic_strain``, ``stress`` and ``residual_stress`` have the components XX, YY, ZZ, XY, YZ,
    XZ, in which VTK keeps symmetric tensors; shear strains are those of the tensor, half the
    engineering ones. Stress includes its mean, tension is positive. ``accumulated_plastic_strain``,
    ``von_mises`` and ``residual_von_mises`` are scalars. Numbers have the precision of the volume,
    lengths are in metres, the field data ``units`` says the rest. The layout is VTK's XML
    RectilinearGrid with appended data as in `save_vtk`: the layers are graded, and an image knows
    equal steps only.

    References
    ----------
    Kitware, VTK File Formats, "XML File Formats", https://docs.vtk.org/en/latest/vtk_file_formats/
    """
    _require_suffix(path, ".vtr")
    (ny, nx), (dy, dx) = result.contact.surface.shape, result.contact.surface.pixel
    margin = result.bodies[0].margin
    pair = result.contact.material, result.contact.counter_material
    sides = [
        side for side, body in zip((-1, 1), pair, strict=True) if body.yield_strength is not None
    ]
    cells: list[tuple[int, PlasticBody, int]] = []
    faces = [0.0]
    for side, body in zip(sides, result.bodies, strict=True):
        layers = [(side, body, layer) for layer in range(body.thickness.size)]
        depths = np.cumsum(body.thickness).tolist()
        if side < 0:
            cells, faces = layers[::-1], [-depth for depth in depths[::-1]] + faces
        else:
            cells, faces = cells + layers, faces + depths

    def array(
        name: str, unit: str, show: Callable[[int, PlasticBody, int], NDArray[Any]], components: int
    ) -> _VtkArray:
        # One layer after the other: a tensor of the whole volume would need its memory again.
        parts = (np.asarray(show(*cell)) for cell in cells)
        return _VtkArray(name, result.bodies[0].stress.dtype, unit, components, parts)

    def tensor(name: str, mean: str | None) -> Callable[[int, PlasticBody, int], NDArray[Any]]:
        def show(side: int, body: PlasticBody, layer: int) -> NDArray[Any]:
            trace = 0 if mean is None else getattr(body, mean)[layer]
            full = tensors.tensor(getattr(body, name)[layer], trace)
            six = full[..., (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)]
            six[..., 4:] *= side
            return six

        return show

    data = [
        array("plastic_strain", "1", tensor("plastic_strain", None), 6),
        array("accumulated_plastic_strain", "1", lambda _, body, k: body.accumulated[k], 1),
        array("stress", "Pa", tensor("stress", "mean_stress"), 6),
        array("von_mises", "Pa", lambda _, body, k: tensors.equivalent(body.stress[k]), 1),
        array("residual_stress", "Pa", tensor("residual_stress", "mean_residual_stress"), 6),
        array(
            "residual_von_mises", "Pa",
            lambda _, body, k: tensors.equivalent(body.residual_stress[k]), 1,
        ),
    ]  # fmt: skip
    x = np.arange(-margin, nx + margin + 1) * dx
    y = np.arange(-margin, ny + margin + 1) * dy
    axes = [_VtkArray.of(n, v, "m") for n, v in zip("xyz", (x, y, np.array(faces)), strict=True)]
    _write_vtk(
        path, "RectilinearGrid", f"0 {x.size - 1} 0 {y.size - 1} 0 {len(faces) - 1}", "",
        {'CellData Scalars="von_mises"': data, "Coordinates": axes},
    )  # fmt: skip


def save_x3p(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map as X3P, the exchange format of ISO 25178-72 (ISO 5436-2).

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.x3p``. Heights in metres with all their bits, NaN where
        missing, as the standard has it for data in floating point; source and preparation are in
        the comment. The dates that the standard asks for are those of the writing.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.

    References
    ----------
    ISO 25178-72:2017, Geometrical product specifications (GPS), Surface texture: Areal, Part 72:
    XML file format x3p
    """
    _require_suffix(path, ".x3p")
    heights = _bytes(surface.heights)
    document = _x3p_document(surface, _md5(heights)).encode("utf-8")
    members: dict[str, bytes | memoryview] = {
        "main.xml": document,
        "bindata/data.bin": heights,
        "md5checksum.hex": f"{_md5(document)} *main.xml\n".encode("ascii"),
    }
    with (
        replacing(path) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for name, content in members.items():
            with archive.open(name, "w", force_zip64=len(content) > _LARGE) as member:
                for block in _blocks(content):
                    member.write(block)


def save_sur(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map as SUR, the format of Digital Surf's programs.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.sur``.

    Raises
    ------
    InputError
        If the suffix is another, or the map has more points or other scales than the header can
        tell.
    OSError
        If the file cannot be written; an old file survives.

    Notes
    -----
    The format holds integers of 32 bits and their step, hence heights to within half a step of
    max|z| / (2³¹ - 2), and the pixel in single precision, hence to 6 × 10⁻⁸ of itself. X3P and
    NPZ keep every bit. Heights are integer × step; the header's offset is zero, since some readers
    add it, others leave it out, and one counts from the lowest point instead.

    References
    ----------
    Surf file format of Digital Surf, as D. Nečas and P. Klapetek describe it in Gwyddion's
    ``surffile.c``
    """
    _require_suffix(path, ".sur")
    (ny, nx), heights = surface.shape, surface.heights
    if surface.heights.size >= 2**31:
        raise InputError(
            f"{path} can hold fewer than 2³¹ points, got {ny} × {nx}; write .x3p or .npz"
        )
    # Missing points are the least height less 2, which has to be an integer of 32 bits as well.
    limit = 2**31 - 2
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    largest = 1e3 * max(abs(low), abs(high))
    with np.errstate(over="ignore"):
        single = np.float32(max(largest / limit, float(np.finfo(np.float32).tiny)))
        if float(single) * limit < largest:
            single = np.nextafter(single, np.float32(np.inf))
        edges = [float(np.float32(1e3 * edge)) for edge in surface.pixel]
    step = float(single)
    if not all(0 < value < math.inf for value in (step, *edges)):
        raise InputError(
            f"{path} keeps pixel and step of the heights in single precision, got pixel "
            f"{surface.pixel} m and heights up to {largest / 1e3:g} m; write .x3p or .npz"
        )
    lowest, highest = (round(1e3 * extreme / step) for extreme in (low, high))
    missing = lowest - 2
    with replacing(path) as temporary, temporary.open("wb") as stream:
        stream.write(_sur_header(surface, (lowest, highest), (edges[0], edges[1]), step))
        rows = max(1, _BLOCK // (8 * nx))
        for first in range(0, ny, rows):
            block = np.rint(1e3 * heights[first : first + rows] / step)
            stream.write(np.where(np.isnan(block), missing, block).astype("<i4").tobytes())


_SURFACE_WRITERS: dict[str, Callable[[Surface, str | os.PathLike[str]], None]] = {
    ".nc": save_netcdf,
    ".npz": save_npz,
    ".x3p": save_x3p,
    ".sur": save_sur,
    ".csv": save_csv,
    ".vti": save_vtk,
}
_RESULT_WRITERS: dict[str, Callable[[ContactResult, str | os.PathLike[str]], None]] = {
    ".nc": save_result,
    ".vti": save_vtk,
    ".csv": save_csv,
    ".json": save_json,
}

_VOLUME_WRITERS: dict[str, Callable[[ElastoplasticResult, str | os.PathLike[str]], None]] = {
    ".nc": save_elastoplastic,
    ".vtr": save_vtr,
    ".vti": save_vtk,
    ".csv": save_csv,
    ".json": save_json,
}

SURFACE_SUFFIXES = tuple(_SURFACE_WRITERS)
"""Suffixes that `save_surface` knows."""

RESULT_SUFFIXES = tuple(_RESULT_WRITERS)
"""Suffixes that `save` knows."""

VOLUME_SUFFIXES = tuple(_VOLUME_WRITERS)
"""Suffixes that `save` knows with plasticity of the volume."""


def _writer(
    writers: Mapping[str, Callable[[Source, str | os.PathLike[str]], None]],
    path: str | os.PathLike[str],
    what: str,
) -> Callable[[Source, str | os.PathLike[str]], None]:
    suffix = Path(path).suffix.lower()
    if suffix not in writers:
        raise InputError(
            f"must end in one of {', '.join(writers)} for {what}, got {str(path)!r}; figures "
            "are written by roughcontact.plots",
            argument="path",
            value=str(path),
        )
    return writers[suffix]


def _require_suffix(path: str | os.PathLike[str], suffix: str) -> None:
    if Path(path).suffix.lower() != suffix:
        raise InputError(
            f"must end in {suffix}, got {str(path)!r}", argument="path", value=str(path)
        )


# Maps and numbers


def _surface_of(source: Surface | Result) -> Surface:
    if isinstance(source, ElastoplasticResult):
        return source.contact.surface
    return source if isinstance(source, Surface) else source.surface


def _names(source: Surface | Result) -> list[str]:
    if isinstance(source, Surface):
        return ["height"]
    if isinstance(source, ElastoplasticResult):
        contact, absent = source.contact, set(_CEILING_ONLY)
    else:
        contact, absent = source, set(_VOLUME_ONLY)
    if contact.counter_surface is None:
        absent.add("counter_height")
    if not isinstance(contact.ceiling, np.ndarray):
        absent.add("ceiling")
    return [name for name in _UNITS if name not in absent]


def _values(source: Surface | Result, name: str) -> NDArray[Any]:
    if isinstance(source, Surface):
        return source.heights
    if isinstance(source, ElastoplasticResult):
        if name in _VOLUME_ONLY:
            return source.residual_displacement
        return _values(source.contact, name)
    if name == "height":
        return source.surface.heights
    if name == "counter_height" and source.counter_surface is not None:
        return source.counter_surface.heights
    values: NDArray[Any] = getattr(source, name)
    return values


def _cell(value: Any) -> str:
    if isinstance(value, list):
        return "; ".join(map(_cell, value))
    return "" if value is None else str(value)


# Bytes


def _bytes(values: NDArray[Any]) -> memoryview:
    """Return the little-endian bytes of a map; nothing is copied on most machines."""
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return little.reshape(-1).view(np.uint8).data


def _blocks(content: bytes | memoryview) -> Iterator[memoryview]:
    view = memoryview(content)
    for start in range(0, len(view), _BLOCK):
        yield view[start : start + _BLOCK]


def _md5(content: bytes | memoryview) -> str:
    # A checksum that the standard asks for, no protection.
    return hashlib.md5(content, usedforsecurity=False).hexdigest()


# VTK


_VTK_TYPES = {"b1": "UInt8", "f4": "Float32", "f8": "Float64"}
_SYMMETRIC = ("XX", "YY", "ZZ", "XY", "YZ", "XZ")


@dataclass(frozen=True, eq=False)
class _VtkArray:
    """One array of a VTK file; its numbers come in parts, one after the other."""

    name: str
    dtype: np.dtype[Any]
    unit: str
    components: int
    parts: Iterable[NDArray[Any]]

    @classmethod
    def of(cls, name: str, values: NDArray[Any], unit: str) -> _VtkArray:
        return cls(name, values.dtype, unit, 1, (values,))

    def tag(self, offset: int) -> str:
        shape = ""
        if self.components > 1:
            shape = f' NumberOfComponents="{self.components}"' + "".join(
                f' ComponentName{number}="{name}"' for number, name in enumerate(_SYMMETRIC)
            )
        return (
            f'        <DataArray type="{_VTK_TYPES[self.dtype.str[1:]]}" Name="{self.name}"{shape} '
            # Of one length whatever the number is: the head is written again at the end.
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
        left = iter(offsets)
        data = "".join(
            f"      <{tag}>\n"
            + "".join(array.tag(next(left)) for array in group)
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

    with replacing(path) as temporary, temporary.open("wb") as stream:
        start = stream.write(head([0] * len(arrays)))
        offsets = []
        for array in arrays:
            offsets.append(stream.tell() - start)
            _append(stream, array.parts)
        stream.write(b"\n  </AppendedData>\n</VTKFile>\n")
        stream.seek(0)
        stream.write(head(offsets))


def _append(stream: IO[bytes], parts: Iterable[NDArray[Any]]) -> None:
    """Write one array of appended data: its table of blocks, then the blocks, in base64."""
    blocks, pending = [], b""
    for part in parts:
        for piece in _blocks(_bytes(part)):
            pending += piece
            if len(pending) >= _BLOCK:
                blocks.append(zlib.compress(pending[:_BLOCK], 1))
                pending = pending[_BLOCK:]
    if pending:
        blocks.append(zlib.compress(pending, 1))
    table = (len(blocks), _BLOCK, len(pending), *map(len, blocks))
    stream.write(base64.b64encode(struct.pack(f"<{len(table)}Q", *table)))
    # Encoded as one stream: three bytes become four letters, and only the end is filled up.
    rest = b""
    for block in blocks:
        joined = rest + block
        whole = len(joined) // 3 * 3
        stream.write(base64.b64encode(joined[:whole]))
        rest = joined[whole:]
    stream.write(base64.b64encode(rest))


# Headers


def _x3p_document(surface: Surface, checksum: str) -> str:
    (ny, nx), (dy, dx), about = surface.shape, surface.pixel, surface.provenance
    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    comment = "\n".join(_xml(line) for line in (about.source, about.channel, *about.steps) if line)
    return f"""<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"\
 xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\
 xsi:schemaLocation="http://www.opengps.eu/2008/ISO5436_2\
 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
      <CX>
        <AxisType>I</AxisType>
        <DataType>L</DataType>
        <Increment>{dx!r}</Increment>
        <Offset>0</Offset>
      </CX>
      <CY>
        <AxisType>I</AxisType>
        <DataType>L</DataType>
        <Increment>{dy!r}</Increment>
        <Offset>0</Offset>
      </CY>
      <CZ>
        <AxisType>A</AxisType>
        <DataType>D</DataType>
        <Increment>1</Increment>
        <Offset>0</Offset>
      </CZ>
    </Axes>
  </Record1>
  <Record2>
    <Date>{now}</Date>
    <Instrument>
      <Manufacturer>unknown</Manufacturer>
      <Model>{_xml(about.instrument) or "unknown"}</Model>
      <Serial>unknown</Serial>
      <Version>roughcontact {__version__}</Version>
    </Instrument>
    <CalibrationDate>{now}</CalibrationDate>
    <ProbingSystem>
      <Type>Software</Type>
      <Identification>unknown</Identification>
    </ProbingSystem>
    <Comment>{comment}</Comment>
  </Record2>
  <Record3>
    <MatrixDimension>
      <SizeX>{nx}</SizeX>
      <SizeY>{ny}</SizeY>
      <SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink>
      <PointDataLink>bindata/data.bin</PointDataLink>
      <MD5ChecksumPointData>{checksum.upper()}</MD5ChecksumPointData>
    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>md5checksum.hex</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"""


def _xml(text: str) -> str:
    # Imported late: it brings the network with it.
    from xml.sax.saxutils import escape

    return escape(_printable(text))


def _printable(text: str) -> str:
    # XML has no way to write most control characters, and UTF-8 none to write lone surrogates.
    return "".join(c if c.isprintable() else " " for c in text)


def _sur_header(
    surface: Surface, extremes: tuple[int, int], pixel: tuple[float, float], step: float
) -> bytes:
    """Return the 512 bytes ahead of the heights; pixel and step in mm."""
    ny, nx = surface.shape
    source = _printable(surface.provenance.source).encode("latin-1", "replace")[:30]
    return struct.pack(
        "<12s4H30s30s5H8xH5i3f" + 9 * "16s" + "3f3H12x7Hf10x2H128s3f34x",
        b"DIGITAL SURF",
        # PC format, one object, version, surface.
        0, 1, 1, 2,
        # The object and who measured it. Words are filled up with blanks.
        source.ljust(30), b" " * 30,
        # Material, acquisition and range unknown; missing points or none; absolute heights.
        0, 0, 0, int(surface.missing > 0), 1,
        32, *extremes, nx, ny, nx * ny,
        pixel[1], pixel[0], step,
        *(name.ljust(16) for name in (b"X", b"Y", b"Z", *6 * (b"mm",))),
        1.0, 1.0, 1.0,
        # Neither imprint nor inverted nor levelled; date and duration unknown; no comment, no
        # offsets.
        0, 0, 0,
        0, 0, 0, 0, 0, 0, 0, 0.0,
        0, 0, b" " * 128, 0.0, 0.0, 0.0,
    )  # fmt: skip
