"""Archive of results: one NetCDF file with input, output and certificate."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import cautions
from roughcontact._tools import memory, netcdf
from roughcontact._tools.arrays import Array
from roughcontact._tools.files import to_json
from roughcontact.contact import load_case
from roughcontact.contact.memory import MemoryNeed
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import Calibrated, CalibrationRecord, ContactResult
from roughcontact.errors import FormatError, InsufficientMemoryError, shorten_value
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.material import hardening
from roughcontact.material.material import Layer, Material
from roughcontact.result import presentation
from roughcontact.surface.provenance import Provenance, from_text, to_text
from roughcontact.surface.surface import Surface

# Tolerances between stored and recomputed values. On the same machine both are identical; other
# libraries and numbers of threads round differently.
_PART, _LEAST, _DIGITS = 1e-3, 1e-12, 4.0
_GAP_TOLERANCE = {"double": 1e-12, "single": 1e-5}
_LOAD_TOLERANCE = 1e-12
# Number of maps that the comparison needs in addition to those of a solve.
_MAX_MAPS = 8


@dataclass(frozen=True)
class Verification:
    """Stated values of a result, and values recomputed from its pressures and heights."""

    load: float  # Stated load [N]
    certificate: float  # Stated ε
    found_load: float
    found_certificate: float
    doubt: float  # Change of the certificate by the last digit of displacement and initial gap
    gap_error: float
    load_error: float  # Stated load error, under load control
    precision: str  # Arithmetic of the transforms
    load_unit: str = "N"  # Unit of the loads

    @property
    def differences(self) -> tuple[str, ...]:
        """Names of load, certificate and gap where stated and recomputed values differ."""
        off = abs(self.found_certificate - self.certificate)
        missed = abs(self.found_load - self.load)
        same = {
            "load": missed <= (self.load_error + _LOAD_TOLERANCE) * self.load,
            "certificate": off <= _PART * self.certificate + _LEAST + _DIGITS * self.doubt,
            "gap": self.gap_error <= _GAP_TOLERANCE[self.precision],
        }
        return tuple(name for name, agrees in same.items() if not agrees)

    def require(self, name: str) -> None:
        """Raise `FormatError` for a file of this name if any value differs."""
        words = {
            "load": f"the load is {self.found_load:.6g} {self.load_unit} instead of "
            f"{self.load:.6g} {self.load_unit}",
            "certificate": f"the certificate is {self.found_certificate:.2g} instead of "
            f"{self.certificate:.2g}",
            "gap": f"the gap differs by {self.gap_error:.1g} of its size",
        }
        if self.differences:
            text = ", ".join(words[what] for what in self.differences)
            raise FormatError(
                f"{name} does not contain the solution that it states: recomputed from its "
                f"pressures and heights, {text}; take a copy of the file, or solve again"
            )


def verify_solution(result: ContactResult, displaced: Array | None = None) -> Verification:
    """Recompute load and certificate of a result with one application of the operator."""
    initial = _initial_gap(result, displaced)
    opened, unit = _displacement_plus_gap(result, initial)
    there = np.isfinite(initial)
    opened, initial, pressure = opened[there], initial[there], result.pressure[there]
    gap = opened - result.approach
    bound: Any = math.inf if result.ceiling is None else result.ceiling
    if isinstance(bound, np.ndarray):
        bound = bound[there]
    reach = pressure - gap / unit
    eps = float(np.finfo(np.float64 if result.precision == "double" else np.float32).eps)
    digit = 0.5 * eps * (np.abs(opened) + np.abs(initial)) / unit
    doubt = np.clip(reach + digit, 0, bound) - np.clip(reach - digit, 0, bound)
    # Without contact there is nothing to certify.
    size = float(np.linalg.norm(pressure)) or math.inf
    largest = max(float(np.abs(opened - initial).max()), float(np.abs(initial).max()))
    return Verification(
        load=result.load,
        certificate=result.certificate,
        found_load=float(result.pressure.sum()) * result.pixel_area,
        found_certificate=float(np.linalg.norm(pressure - np.clip(reach, 0, bound))) / size,
        doubt=0.5 * float(np.linalg.norm(doubt)) / size,
        gap_error=float(np.abs(gap - result.gap[there]).max()) / (largest or math.inf),
        load_error=result.load_error if result.control == "load" else 0.0,
        precision=result.precision,
        load_unit=result.pair.load_unit,
    )


def _initial_gap(result: ContactResult, displaced: Array | None) -> Array:
    """Return the gap without pressure or approach [m], not finite without possible contact."""
    gap = result.initial_gap
    if displaced is not None:
        gap += displaced
    for axis, slope in enumerate(result.tilt):
        points, edge = gap.shape[axis], result.surface.pixel[axis]
        lever = slope * edge * (np.arange(points) - (points - 1) / 2)
        gap += lever[:, None] if axis == 0 else lever
    return gap


def _displacement_plus_gap(result: ContactResult, initial: Array) -> tuple[Array, float]:
    """Return displacement plus initial gap [m], and the self-influence of a pixel."""
    pair = result.pair
    MemoryNeed(pair.shape, pair.boundary, result.precision, _MAX_MAPS).require()
    operator = pair.operators(result.precision, Workspace())(pair.shape, (1, 1))
    opened = initial.copy()

    def add(number: int, rows: slice, displacement: NDArray[Any]) -> None:
        opened[rows] += displacement

    index = np.flatnonzero(result.pressure)
    if index.size:
        operator.spread(operator.support(index), result.pressure.ravel()[index], add)
    return opened, operator.self_displacement


_ARCHIVE_MAPS = {
    "height": ("m", "height of the rough body, positive out of the material"),
    "counter_height": ("m", "height of the counter-body, positive out of its material"),
    "initial_gap": ("m", "gap at first touch"),
    "pressure": ("Pa", "contact pressure"),
    "gap": ("m", "displacement plus initial gap plus tilt minus approach"),
    "saturated": ("1", "1 where the pressure is at the ceiling"),
    "ceiling": ("Pa", "largest pressure allowed"),
}
# Numerical attributes, and units of these and of calibrated ceilings; 1 for all others.
_NUMBERS = (
    *("load", "approach", "contact_modulus", "certificate"),
    *("load_error", "tolerance", "seconds"),
)
_UNITS = {
    "load": "N",
    "approach": "m",
    "contact_modulus": "Pa",
    "seconds": "s",
    "ceiling": "Pa",
    "contact_area": "m²",
    "mean_gap": "m",
    "max_indentation": "m",
    "usual_ceiling": "Pa",
    "usual_contact_area": "m²",
    "usual_approach": "m",
    "usual_indentation": "m",
}
# Attributes of a calibrated ceiling.
_RECOMMENDED = [field.name for field in fields(CalibrationRecord)]
_CALIBRATED = [field.name for field in fields(Calibrated) if field.name != "control"]
_WORDS = ("boundary", "precision", "control", "status", "version")
# Attributes that are properties of the bodies.
_PAIR_ATTRIBUTES = ("contact_modulus", "boundary")
_COUNTS = ("iterations", "convolutions")
_PAIRS = {"tilt": "1", "moments": "N m"}
_UNSEALED = "unsealed"
_GIVEN = "given_load"
MATERIALS = ("material", "counter_material")

PACKED = ("pressure", "saturated")
"""Maps that are compressed, as most of their pixels are zero."""


def surface_to_dataset(surface: Surface) -> netcdf.Dataset:
    """Return a height map as a dataset."""
    return _dataset(surface, {"height": surface.heights}, {"title": "Heights of a surface"})


def to_dataset(result: ContactResult) -> netcdf.Dataset:
    """Return a result as a dataset that can be checked without this program."""
    maps: dict[str, NDArray[Any]] = {
        "height": result.surface.heights,
        "initial_gap": result.initial_gap,
        "pressure": result.pressure,
        "gap": result.gap,
        "saturated": result.saturated.astype(np.int8),
    }
    if result.counter_surface is not None:
        maps["counter_height"] = result.counter_surface.heights
    if isinstance(result.ceiling, np.ndarray):
        maps["ceiling"] = result.ceiling
    return _dataset(result.surface, maps, _attributes(result))


def _attributes(result: ContactResult) -> dict[str, Any]:
    attributes = {
        "title": "Contact of rough surfaces",
        "regime": str(result.regime),
        "warnings": "\n".join(result.warnings),
        "cautions": cautions.to_text(result.cautions),
    }
    if result.extra_cautions:
        attributes["remarks"] = cautions.to_text(result.extra_cautions)
    if result.counter_surface is not None:
        attributes |= _provenance_texts(result.counter_surface.provenance, "counter_")
    if result.surface.missing:
        attributes["holes"] = "never touch"
    attributes |= _scalar_attributes(result)
    if not (result.ceiling is None or isinstance(result.ceiling, np.ndarray)):
        attributes |= _with_unit("ceiling", result.ceiling, "Pa")
    if result.without_checksums:
        # New checksums would not prove that the old file is undamaged.
        attributes[_UNSEALED] = "from a file without checksums"
    for name in MATERIALS:
        attributes |= _material_attributes(name, getattr(result, name))
    return attributes


def _scalar_attributes(result: ContactResult) -> dict[str, Any]:
    attributes: dict[str, Any] = {}
    for name in _NUMBERS:
        held = result.pair.load_unit if name == "load" else _UNITS.get(name, "1")
        attributes |= _with_unit(name, float(getattr(result, name)), held)
    attributes |= {name: str(getattr(result, name)) for name in _WORDS}
    attributes |= {name: getattr(result, name) for name in _COUNTS}
    for name, unit in _PAIRS.items():
        pair = getattr(result, name)
        if pair is not None:
            for axis, value in zip("yx", pair, strict=True):
                attributes |= _with_unit(f"{name}_{axis}", value, unit)
    if result.specified_load is not None:
        attributes[_GIVEN] = to_json(result.specified_load.summary())
    if result.measurement is not None:
        attributes["uncertainty"] = to_json(result.measurement.summary())
    for prefix, record, names in (
        ("recommended", result.calibration, _RECOMMENDED),
        ("calibrated", result.calibrated, _CALIBRATED),
    ):
        for name in names if record is not None else ():
            value = getattr(record, name)
            attributes |= _with_unit(f"{prefix}_{name}", value, _UNITS.get(name, "1"))
    return attributes


def _material_attributes(body: str, material: Material) -> dict[str, Any]:
    attributes = {
        f"{body}_name": material.name,
        **_with_unit(f"{body}_young", material.young, "Pa"),
        f"{body}_poisson": material.poisson,
    }
    for name in ("yield_strength", "hardness"):
        value = getattr(material, name)
        if value is not None:
            attributes |= _with_unit(f"{body}_{name}", value, "Pa")
    if material.hardening is not None:
        attributes[f"{body}_hardening"] = hardening.to_text(material.hardening)
    if material.caveat:
        attributes[f"{body}_caveat"] = material.caveat
    if material.coating:
        attributes[f"{body}_coating"] = json.dumps([asdict(layer) for layer in material.coating])
        attributes[f"{body}_base"] = material.base
    return attributes


def _with_unit(name: str, value: float, unit: str) -> dict[str, Any]:
    return {name: value, f"{name}_units": unit}


def _dataset(surface: Surface, maps: dict[str, Any], attributes: dict[str, Any]) -> netcdf.Dataset:
    dataset = netcdf.Dataset(
        {
            "Conventions": "CF-1.8",
            "pixel_y": surface.pixel[0],
            "pixel_y_units": "m",
            "pixel_x": surface.pixel[1],
            "pixel_x_units": "m",
            **_provenance_texts(surface.provenance),
            **attributes,
        }
    )
    for name, values in maps.items():
        unit, text = _ARCHIVE_MAPS[name]
        dataset.add(name, ("y", "x"), values, unit, text)
    for axis, count, pixel in zip("yx", surface.shape, surface.pixel, strict=True):
        dataset.add(axis, axis, (np.arange(count) + 0.5) * pixel, "m", "center of the pixel")
    return dataset


def _provenance_texts(provenance: Provenance, prefix: str = "") -> dict[str, str]:
    texts = {
        "source": provenance.source,
        "instrument": provenance.instrument,
        "channel": provenance.channel,
        "preparation": "\n".join(provenance.steps),
        "provenance": to_text(provenance),
    }
    # The name of a file may be text in no encoding; attributes of a file are UTF-8.
    return {
        f"{prefix}{name}": text.encode("utf-8", "backslashreplace").decode("utf-8")
        for name, text in texts.items()
    }


def _provenance(attributes: dict[str, Any], prefix: str = "") -> Provenance:
    source, instrument, channel, steps = (
        str(attributes[f"{prefix}{name}"])
        for name in ("source", "instrument", "channel", "preparation")
    )
    stored = attributes.get(f"{prefix}provenance")
    if stored is None:
        # Earlier versions stored only the sentences.
        return Provenance(source, instrument, channel, filter(None, steps.split("\n")))
    return replace(from_text(str(stored)), source=source, instrument=instrument, channel=channel)


def save_result(result: ContactResult, path: str | os.PathLike[str]) -> None:
    """Write a result to a NetCDF file."""
    netcdf.write(to_dataset(result), path, dict.fromkeys(PACKED, netcdf.PACKED))


def open_archive(path: str | os.PathLike[str]) -> netcdf.Dataset:
    """Return the content of a file after a check of its checksums."""
    if not Path(path).is_file():
        raise FormatError(f"{shorten_value(path)} does not exist or is not a file; check its name")
    with as_format_error(path, "ContactResult"), netcdf.open_dataset(Path(path)) as dataset:
        memory.require_memory(
            dataset.nbytes,
            f"reading {Path(path).name} needs",
            advice=("check that the file is complete, or read it on a larger machine",),
        )
        dataset.load()
        changed = netcdf.changed_names(dataset)
    if changed:
        raise netcdf.changed_file_error(Path(path).name, changed)
    return dataset


@contextmanager
def as_format_error(path: str | os.PathLike[str], kind: str) -> Iterator[None]:
    """Convert any error in the content of a file into a `FormatError`."""
    try:
        yield
    except (FormatError, InsufficientMemoryError):
        raise
    # h5py fails on damaged files with OSError, KeyError, ValueError and others;
    # inconsistent content fails in the checks of this package.
    except Exception as error:
        raise FormatError(
            f"{Path(path).name} cannot be read as a result ({type(error).__name__}: {error}); "
            f"expected a NetCDF file written by {kind}.save"
        ) from None


def from_dataset(dataset: netcdf.Dataset) -> ContactResult:
    """Return the result of a dataset that `to_dataset` wrote."""
    attributes = dataset.attrs
    maps = _maps(dataset)
    ceiling: Any = maps.get("ceiling")
    if ceiling is None and "ceiling" in attributes:
        ceiling = float(attributes["ceiling"])
    return ContactResult(
        pair=_pair(maps, attributes),
        ceiling=ceiling,
        pressure=maps["pressure"],
        gap=maps["gap"],
        without_checksums=netcdf.CHECKSUM not in attributes or _UNSEALED in attributes,
        # Files of earlier versions have no cautions.
        extra_cautions=cautions.from_text(str(attributes.get("remarks", "[]"))),
        **_read_scalars(attributes),
    )


def _maps(dataset: netcdf.Dataset) -> dict[str, NDArray[np.float64]]:
    maps = {}
    for name in _ARCHIVE_MAPS:
        if name in dataset:
            if dataset[name].dims != ("y", "x"):
                raise ValueError(f"{name} has dimensions {dataset[name].dims}, not (y, x)")
            maps[name] = np.array(dataset[name].values, dtype=float)
            maps[name].flags.writeable = False
    return maps


def _pair(maps: dict[str, NDArray[np.float64]], attributes: dict[str, Any]) -> Pair:
    pixel = float(attributes["pixel_y"]), float(attributes["pixel_x"])
    holes = "holes" in attributes
    surface = Surface(maps["height"], pixel, _provenance(attributes), holes_masked=holes)
    counter = None
    if "counter_height" in maps:
        origin = _provenance(attributes, "counter_")
        counter = Surface(maps["counter_height"], pixel, origin, holes_masked=True)
    bodies = {
        body: Material(
            young=float(attributes[f"{body}_young"]),
            poisson=float(attributes[f"{body}_poisson"]),
            yield_strength=_read_optional(attributes, f"{body}_yield_strength"),
            name=str(attributes[f"{body}_name"]),
            hardness=_read_optional(attributes, f"{body}_hardness"),
            hardening=_parse_hardening(attributes.get(f"{body}_hardening")),
            caveat=str(attributes.get(f"{body}_caveat", "")),
            coating=[
                Layer(**layer) for layer in json.loads(attributes.get(f"{body}_coating", "[]"))
            ],
            base=str(attributes.get(f"{body}_base", "bonded")),
        )
        for body in MATERIALS
    }
    boundary = Boundary(str(attributes["boundary"]))
    return Pair(surface, bodies["material"], counter, bodies["counter_material"], boundary)


def _read_scalars(attributes: dict[str, Any]) -> dict[str, Any]:
    scalars: dict[str, Any] = {name: float(attributes[name]) for name in _NUMBERS}
    scalars |= {name: str(attributes[name]) for name in _WORDS}
    scalars |= {name: int(attributes[name]) for name in _COUNTS}
    for name in _PAIR_ATTRIBUTES:
        del scalars[name]
    if "recommended_load" in attributes:
        text: dict[str, Any] = {
            name: float(attributes[f"recommended_{name}"]) for name in _RECOMMENDED
        }
        scalars["calibration"] = CalibrationRecord(**text | {"solves": int(text["solves"])})
    if "calibrated_ceiling" in attributes:
        # Files of earlier versions have no indentation.
        text = {name: float(attributes.get(f"calibrated_{name}", "nan")) for name in _CALIBRATED}
        text |= {"control": scalars["control"], "convolutions": int(text["convolutions"])}
        scalars["calibrated"] = Calibrated(**text)
    if "uncertainty" in attributes:
        record = json.loads(str(attributes["uncertainty"]))
        scalars["measurement"] = presentation().stored_uncertainty(record)
    if _GIVEN in attributes:
        scalars["specified_load"] = load_case.from_summary(json.loads(str(attributes[_GIVEN])))
    # Files of earlier versions have no tilt.
    return scalars | {
        name: (float(attributes[f"{name}_y"]), float(attributes[f"{name}_x"]))
        for name in _PAIRS
        if f"{name}_y" in attributes
    }


def _read_optional(attributes: dict[str, Any], name: str) -> float | None:
    value = attributes.get(name)
    return None if value is None or math.isnan(float(value)) else float(value)


def _parse_hardening(text: Any) -> hardening.Hardening | None:
    return None if text is None else hardening.from_text(str(text))
