"""Results on disk: one NetCDF file holds what went in, what came out and how good it is."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import netcdf
from roughcontact.contact.result import ContactResult
from roughcontact.errors import FormatError, InputError
from roughcontact.files import replacing
from roughcontact.material import hardening
from roughcontact.material.material import Material
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.volume.result import ElastoplasticResult, Increment, PlasticBody

if TYPE_CHECKING:
    import xarray

_MAPS = {
    "height": ("m", "height of the rough body, positive out of the material"),
    "counter_height": ("m", "height of the counter-body, positive out of its material"),
    "initial_gap": ("m", "gap at first touch"),
    "pressure": ("Pa", "contact pressure"),
    "gap": ("m", "displacement plus initial gap plus tilt minus approach"),
    "saturated": ("1", "1 where the pressure is at the ceiling"),
    "ceiling": ("Pa", "largest pressure allowed"),
}
# Attributes that are numbers, with their units.
_NUMBERS = {
    "load": "N",
    "approach": "m",
    "contact_modulus": "Pa",
    "certificate": "1",
    "load_error": "1",
    "tolerance": "1",
    "seconds": "s",
}
_WORDS = ("boundary", "precision", "control", "status", "version")
_COUNTS = ("iterations", "convolutions")
_PAIRS = {"tilt": "1", "moments": "N m"}
_BODIES = ("material", "counter_material")


def surface_to_dataset(surface: Surface) -> xarray.Dataset:
    """Return a height map as an xarray dataset.

    Parameters
    ----------
    surface : Surface
        The map.

    Returns
    -------
    xarray.Dataset
        Variable ``height`` [m] over the centres ``(y, x)`` [m] of the pixels; pixel and
        provenance as attributes.
    """
    return _dataset(surface, {"height": surface.heights}, {"title": "Heights of a surface"})


def to_dataset(result: ContactResult) -> xarray.Dataset:
    """Return a result as an xarray dataset that can be checked without this program.

    Parameters
    ----------
    result : ContactResult
        The result.

    Returns
    -------
    xarray.Dataset
        Variables ``height``, ``initial_gap``, ``pressure``, ``gap``, ``saturated`` over ``(y, x)``
        in SI units, ``ceiling`` and ``counter_height`` where they are maps, and everything else
        as attributes.
    """
    surface = result.surface
    maps: dict[str, Any] = {
        "height": surface.heights,
        "initial_gap": result.initial_gap,
        "pressure": result.pressure,
        "gap": result.gap,
        "saturated": result.saturated.astype(np.int8),
    }
    if result.counter_surface is not None:
        maps["counter_height"] = result.counter_surface.heights
    attributes: dict[str, Any] = {
        "title": "Contact of rough surfaces",
        "regime": result.regime,
        "warnings": "\n".join(result.warnings),
    }
    if result.counter_surface is not None:
        attributes |= _described(result.counter_surface.provenance, "counter_")
    if surface.missing:
        attributes["holes"] = "never touch"
    for name in _NUMBERS:
        attributes[name] = float(getattr(result, name))
        attributes[f"{name}_units"] = _NUMBERS[name]
    for name in (*_WORDS, *_COUNTS):
        attributes[name] = getattr(result, name)
    for name, unit in _PAIRS.items():
        pair = getattr(result, name)
        if pair is not None:
            for axis_name, value in zip("yx", pair, strict=True):
                attributes[f"{name}_{axis_name}"] = value
                attributes[f"{name}_{axis_name}_units"] = unit
    if isinstance(result.ceiling, np.ndarray):
        maps["ceiling"] = result.ceiling
    elif result.ceiling is not None:
        attributes["ceiling"] = result.ceiling
        attributes["ceiling_units"] = "Pa"
    for body in _BODIES:
        material: Material = getattr(result, body)
        attributes[f"{body}_name"] = material.name
        attributes[f"{body}_young"] = material.young
        attributes[f"{body}_young_units"] = "Pa"
        attributes[f"{body}_poisson"] = material.poisson
        for name in ("yield_strength", "hardness"):
            value = getattr(material, name)
            if value is not None:
                attributes[f"{body}_{name}"] = value
                attributes[f"{body}_{name}_units"] = "Pa"
        if material.hardening is not None:
            attributes[f"{body}_hardening"] = hardening.to_text(material.hardening)
    return _dataset(surface, maps, attributes)


def _dataset(surface: Surface, maps: dict[str, Any], attributes: dict[str, Any]) -> xarray.Dataset:
    import xarray

    ny, nx = surface.shape
    axis = {"units": "m", "long_name": "centre of the pixel"}
    return xarray.Dataset(
        {
            name: (("y", "x"), values, dict(zip(("units", "long_name"), _MAPS[name], strict=True)))
            for name, values in maps.items()
        },
        coords={
            "y": ("y", (np.arange(ny) + 0.5) * surface.pixel[0], axis),
            "x": ("x", (np.arange(nx) + 0.5) * surface.pixel[1], axis),
        },
        attrs={
            "Conventions": "CF-1.8",
            "pixel_y": surface.pixel[0],
            "pixel_y_units": "m",
            "pixel_x": surface.pixel[1],
            "pixel_x_units": "m",
            **_described(surface.provenance),
            **attributes,
        },
    )


def _described(provenance: Provenance, prefix: str = "") -> dict[str, str]:
    texts = {
        "source": provenance.source,
        "instrument": provenance.instrument,
        "channel": provenance.channel,
        "preparation": "\n".join(provenance.steps),
    }
    # The name of a file need not be text in any encoding; the file's attributes are UTF-8.
    return {
        f"{prefix}{name}": text.encode("utf-8", "backslashreplace").decode("utf-8")
        for name, text in texts.items()
    }


def _provenance(attributes: dict[str, Any], prefix: str = "") -> Provenance:
    source, instrument, channel, steps = (
        str(attributes[f"{prefix}{name}"])
        for name in ("source", "instrument", "channel", "preparation")
    )
    return Provenance(source, instrument, channel, tuple(filter(None, steps.split("\n"))))


def save_result(result: ContactResult, path: str | os.PathLike[str]) -> None:
    """Write a result to a NetCDF file.

    Parameters
    ----------
    result : ContactResult
        The result.
    path : str or path
        File to write; an old one is replaced when the new one is complete.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path)
    dataset = to_dataset(result)
    # Most pixels carry nothing: these two shrink to little; heights would not.
    packed = {name: {"zlib": True, "complevel": 1} for name in ("pressure", "saturated")}
    with replacing(path) as temporary:
        dataset.to_netcdf(temporary, engine="h5netcdf", encoding=packed)


def load_result(path: str | os.PathLike[str]) -> ContactResult:
    """Read a result that `ContactResult.save` wrote.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    ContactResult
        The same result; every number keeps its bits.

    Raises
    ------
    FormatError
        If the file is missing, damaged or not a result of this program.
    """
    dataset = _opened(path)
    with _refused(path, "ContactResult"):
        return _from_dataset(dataset)


def _require_suffix(path: str | os.PathLike[str]) -> None:
    if Path(path).suffix.lower() != ".nc":
        raise InputError(f"must end in .nc, got {str(path)!r}", argument="path", value=str(path))


def _opened(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Return the content of a file."""
    if not Path(path).is_file():
        raise FormatError(f"{path} does not exist or is no file; check its name")
    with _refused(path, "ContactResult"), netcdf.opened(Path(path)) as dataset:
        return dataset.load()


@contextmanager
def _refused(path: str | os.PathLike[str], kind: str) -> Iterator[None]:
    """Turn whatever goes wrong with the content of a file into one error."""
    try:
        yield
    # h5py and xarray fail on damaged files with OSError, KeyError, ValueError and more; what does
    # not fit together our own checks refuse.
    except Exception as error:
        raise FormatError(
            f"{Path(path).name} cannot be read as a result ({type(error).__name__}: {error}); "
            f"expected a NetCDF file written by {kind}.save"
        ) from None


def _from_dataset(dataset: xarray.Dataset) -> ContactResult:
    attributes = dataset.attrs
    maps = {}
    for name in _MAPS:
        if name in dataset:
            if dataset[name].dims != ("y", "x"):
                raise ValueError(f"{name} lies over {dataset[name].dims}, not over (y, x)")
            maps[name] = np.array(dataset[name].values, dtype=float)
            maps[name].flags.writeable = False
    pixel = float(attributes["pixel_y"]), float(attributes["pixel_x"])
    surface = Surface(
        maps["height"],
        pixel,
        _provenance(attributes),
        holes_masked="holes" in attributes,
    )
    counter = None
    if "counter_height" in maps:
        origin = _provenance(attributes, "counter_")
        counter = Surface(maps["counter_height"], pixel, origin, holes_masked=True)
    ceiling: Any = maps.get("ceiling")
    if ceiling is None and "ceiling" in attributes:
        ceiling = float(attributes["ceiling"])
    bodies = {
        body: Material(
            young=float(attributes[f"{body}_young"]),
            poisson=float(attributes[f"{body}_poisson"]),
            yield_strength=_optional(attributes, f"{body}_yield_strength"),
            name=str(attributes[f"{body}_name"]),
            hardness=_optional(attributes, f"{body}_hardness"),
            hardening=_law(attributes.get(f"{body}_hardening")),
        )
        for body in _BODIES
    }
    scalars: dict[str, Any] = {name: float(attributes[name]) for name in _NUMBERS}
    scalars |= {name: str(attributes[name]) for name in _WORDS}
    scalars |= {name: int(attributes[name]) for name in _COUNTS}
    # Files of earlier versions know no tilt.
    scalars |= {
        name: (float(attributes[f"{name}_y"]), float(attributes[f"{name}_x"]))
        for name in _PAIRS
        if f"{name}_y" in attributes
    }
    return ContactResult(
        surface=surface,
        counter_surface=counter,
        material=bodies["material"],
        counter_material=bodies["counter_material"],
        ceiling=ceiling,
        pressure=maps["pressure"],
        gap=maps["gap"],
        **scalars,
    )


def _optional(attributes: dict[str, Any], name: str) -> float | None:
    value = attributes.get(name)
    return None if value is None or math.isnan(float(value)) else float(value)


def _law(text: Any) -> hardening.Hardening | None:
    return None if text is None else hardening.from_text(str(text))


_COMPONENTS = ("zz", "(xx-yy)/2", "xy", "xz", "yz")
_TENSORS = {
    "plastic_strain": ("1", "plastic strain"),
    "stress": ("Pa", "deviator of the stress under load, average over the layer"),
    "residual_stress": ("Pa", "deviator of the stress by the plastic strain alone"),
}
_FIELDS = {
    "accumulated": ("1", "accumulated plastic strain"),
    "mean_stress": ("Pa", "a third of the trace of the stress under load"),
    "mean_residual_stress": ("Pa", "a third of the trace of the stress by plastic strain alone"),
}
_STEPS = {
    "load": "N",
    "approach": "m",
    "contact_area": "m2",
    "max_pressure": "Pa",
    "max_plastic_strain": "1",
    "plastic_volume": "m3",
    "convolutions": "1",
}


# Most of the volume carries no plastic strain. Bytes of like weight stand together: half the time,
# a tenth less space.
_PACKED = {"zlib": True, "complevel": 1, "shuffle": True}
_CARRIED = "carried_"


def save_elastoplastic(
    result: ElastoplasticResult,
    path: str | os.PathLike[str],
    carried: Mapping[str, NDArray[Any]] | None = None,
) -> None:
    """Write an elastic-plastic result to a NetCDF file; `load_result` reads its contact.

    Parameters
    ----------
    result : ElastoplasticResult
        The result.
    path : str or path
        File to write; an old one is replaced when the new one is complete.
    carried : mapping of ndarray, optional
        What a run needs besides the result to go on to the same bits, for `load_step`.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path)
    dataset = to_dataset(result.contact)
    unit = {"units": "m", "long_name": "displacement of the surface by plastic strain"}
    dataset["residual_displacement"] = (("y", "x"), result.residual_displacement, unit)
    packed = {"pressure": _PACKED}
    for name, body in zip(_yielding(result.contact), result.bodies, strict=True):
        volume = ("layer", "volume_y", "volume_x")
        units = {"units": "m", "long_name": "thickness of the layer"}
        dataset[f"{name}_thickness"] = ("layer", body.thickness, units)
        for field, (unit_name, text) in (_TENSORS | _FIELDS).items():
            dims = (volume[0], "component", *volume[1:]) if field in _TENSORS else volume
            about = {"units": unit_name, "long_name": text}
            dataset[f"{name}_{field}"] = (dims, getattr(body, field), about)
            packed[f"{name}_{field}"] = _PACKED
        dataset.attrs["volume_margin"] = body.margin
    dataset["component"] = ("component", list(_COMPONENTS))
    for field, unit_name in _STEPS.items():
        values = np.array([getattr(step, field) for step in result.increments])
        dataset[f"increment_{field}"] = ("increment", values, {"units": unit_name})
    counts = [step.iterations for step in result.increments]
    residuals = [residual for step in result.increments for residual in step.residuals]
    about = {"units": "1", "long_name": "iterations of the loop"}
    dataset["increment_iterations"] = ("increment", np.array(counts), about)
    about = {"units": "1", "long_name": "residual after each iteration, increment by increment"}
    dataset["iteration_residual"] = ("iteration", np.array(residuals), about)
    dataset.attrs |= {
        "elastoplastic_status": result.status,
        "elastoplastic_precision": result.precision,
        "elastoplastic_tolerance": result.tolerance,
        "elastoplastic_seconds": result.seconds,
        "elastoplastic_version": result.version,
        "yield_excess": result.yield_excess,
        # The contact alone knows no plastic strain: its words on yield would be wrong.
        "regime": result.regime,
        "warnings": "\n".join(result.warnings),
    }
    for key, array in (carried or {}).items():
        name = f"{_CARRIED}{key}"
        # HDF5 packs no array without numbers.
        if array.size:
            dataset[name] = ([f"{name}_{axis}" for axis in range(array.ndim)], array)
            packed[name] = _PACKED
    with replacing(path) as temporary:
        dataset.to_netcdf(temporary, engine="h5netcdf", encoding=packed)


def load_elastoplastic(path: str | os.PathLike[str]) -> ElastoplasticResult:
    """Read a result that `ElastoplasticResult.save` wrote.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    ElastoplasticResult
        The same result; every number keeps its bits, so a run can go on from it.

    Raises
    ------
    FormatError
        If the file is missing, damaged or not an elastic-plastic result of this program.
    """
    return load_step(path)[0]


def load_step(
    path: str | os.PathLike[str],
) -> tuple[ElastoplasticResult, dict[str, NDArray[Any]]]:
    """Read a result of `save_elastoplastic`, and what the run carried on to the next load.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    result : ElastoplasticResult
        See `load_elastoplastic`.
    carried : dict of ndarray
        As it was given, but for arrays without numbers.

    Raises
    ------
    FormatError
        As for `load_elastoplastic`.
    """
    dataset = _opened(path)
    with _refused(path, "ElastoplasticResult"):
        contact = _from_dataset(dataset)
        attributes = dataset.attrs
        bodies = []
        for name in _yielding(contact):
            arrays = {
                field: np.array(dataset[f"{name}_{field}"].values)
                for field in ("thickness", *_TENSORS, *_FIELDS)
            }
            body = PlasticBody(
                material=getattr(contact, name),
                pixel_area=contact.pixel_area,
                margin=int(attributes["volume_margin"]),
                **arrays,
            )
            bodies.append(body)
        columns = {field: dataset[f"increment_{field}"].values.tolist() for field in _STEPS}
        residuals = iter(dataset["iteration_residual"].values.tolist())
        columns["residuals"] = [
            tuple(islice(residuals, count))
            for count in dataset["increment_iterations"].values.tolist()
        ]
        rows = zip(*columns.values(), strict=True)
        result = ElastoplasticResult(
            contact=contact,
            residual_displacement=np.array(dataset["residual_displacement"].values),
            bodies=tuple(bodies),
            increments=tuple(Increment(**dict(zip(columns, row, strict=True))) for row in rows),
            yield_excess=float(attributes["yield_excess"]),
            precision=str(attributes["elastoplastic_precision"]),
            tolerance=float(attributes["elastoplastic_tolerance"]),
            status=str(attributes["elastoplastic_status"]),
            seconds=float(attributes["elastoplastic_seconds"]),
            version=str(attributes["elastoplastic_version"]),
        )
        carried = {
            str(name).removeprefix(_CARRIED): np.array(values)
            for name, values in dataset.data_vars.items()
            if str(name).startswith(_CARRIED)
        }
        return result, carried


def _yielding(contact: ContactResult) -> list[str]:
    """Return which bodies of a contact yield."""
    return [name for name in _BODIES if getattr(contact, name).yield_strength is not None]
