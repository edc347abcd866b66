"""The elastic stress below a contact: what was found, and its file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact import archive
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.files import replacing, require_suffix
from roughcontact.halfspace import stress_summary
from roughcontact.halfspace.tensors import COMPONENTS, von_mises
from roughcontact.material.material import Material

if TYPE_CHECKING:
    import xarray

BODIES = ("first", "second")


@dataclass(frozen=True, eq=False)
class StressResult:
    """Elastic stress below a contact, with everything that went in.

    Arrays are read-only and in SI units; tensors hold xx, yy, zz, yz, xz, xy along their first
    axis, tension positive, z from the surface into the body.

    Parameters
    ----------
    contact : ContactResult
        The contact.
    body : {"first", "second"}
        The body that was looked into.
    friction : float
        Coefficient μ of the traction μ p that the first body feels in ``direction``; the second
        feels the opposite.
    direction : float
        Angle from x towards y [rad].
    precision : {"double", "single"}
        Arithmetic of the transforms.
    profile : stress_summary.Summary
        Largest stresses over the depths, their places, what exceeds the yield strength.
    section_x : ndarray, shape (6, nz, nx)
        Tensors on the plane along x through the largest von Mises stress [Pa].
    section_y : ndarray, shape (6, nz, ny)
        Tensors on the plane along y through it [Pa].
    version : str
        Version of the program.
    """

    contact: ContactResult
    body: str
    friction: float
    direction: float
    precision: str
    profile: stress_summary.Summary
    section_x: NDArray[Any]
    section_y: NDArray[Any]
    version: str = field(default="")

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        held = (*vars(self.profile).values(), self.section_x, self.section_y)
        for array in held:
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @property
    def material(self) -> Material:
        """Material of the body."""
        return body_of(self.contact, self.body)

    @property
    def max_von_mises(self) -> float:
        """Largest von Mises stress [Pa]."""
        return self.profile.max_von_mises

    @property
    def place(self) -> tuple[float, float, float]:
        """Where it is: depth, y and x [m], counted from the corner of the map."""
        (row, column), (dy, dx) = self.profile.pixel_of_max, self.contact.surface.pixel
        return self.profile.depth_of_max, (row + 0.5) * dy, (column + 0.5) * dx

    @property
    def yield_factor(self) -> float | None:
        """Yield strength over the largest von Mises stress; ``None`` if it is unknown.

        The whole pressure may grow by this factor until the first point yields. The load may
        only where the contact area stays as it is; see `yield_onset`.
        """
        return self.profile.yield_factor

    @property
    def yielded_volume(self) -> float | None:
        """Volume where the von Mises stress exceeds the yield strength [m³]."""
        return self.profile.yielded_volume

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the numbers has to know, one sentence each."""
        notes = list(self.contact.warnings)
        if self.yielded_volume:
            notes.append(
                "the stress exceeds the yield strength: it is that of an elastic body, which this "
                "one no longer is"
            )
        if self.max_von_mises > 0 and self.profile.depth_of_max == self.profile.depths[-1]:
            notes.append("the largest stress lies at the greatest depth: look deeper")
        if 0 < self.profile.depth_of_max < 2 * max(self.contact.surface.pixel):
            notes.append(
                "the largest stress lies within two pixels of the surface: it is one of the "
                "resolution of the map"
            )
        return tuple(notes)

    def von_mises_section(self, along: str) -> NDArray[Any]:
        """Return the von Mises stress on a plane through its maximum.

        Parameters
        ----------
        along : {"x", "y"}
            The horizontal axis of the plane.

        Returns
        -------
        ndarray, shape (nz, nx) or (nz, ny)
            Equivalent stress [Pa].

        Raises
        ------
        InputError
            If ``along`` is something else.
        """
        if along not in ("x", "y"):
            raise InputError(f"must be 'x' or 'y', got {along!r}", argument="along", value=along)
        return von_mises(self.section_x if along == "x" else self.section_y)

    def summary(self) -> dict[str, Any]:
        """Return the scalar results by name, in SI units, ready for JSON."""
        from roughcontact.report import results

        return results.summary(self)

    def save(self, path: str | Path) -> None:
        """Write everything to a NetCDF file.

        Parameters
        ----------
        path : str or path
            File to write, ``.nc``; it appears only once it is complete. The dataset is that of
            `to_dataset`.

        Raises
        ------
        InputError
            If the suffix is not ``.nc``.
        OSError
            If the file cannot be written; an old file survives.
        """
        require_suffix(path, ".nc")
        dataset = to_dataset(self)
        packed = {name: {"zlib": True, "complevel": 1} for name in ("pressure", "saturated")}
        with replacing(path) as temporary:
            dataset.to_netcdf(temporary, engine="h5netcdf", encoding=packed)


def to_dataset(result: StressResult) -> xarray.Dataset:
    """Return a stress result as an xarray dataset.

    Parameters
    ----------
    result : StressResult
        The result.

    Returns
    -------
    xarray.Dataset
        The dataset of the contact (`archive.to_dataset`), and over ``depth`` the largest
        ``von_mises`` and ``tresca``, their pixel, ``orthogonal_shear`` for passes along y and x,
        and ``yielded_area``; the map ``peak_von_mises``; tensors on the planes ``section_x`` and
        ``section_y``, whose place is in the attributes.
    """
    profile = result.profile
    dataset = archive.to_dataset(result.contact)

    def add(name: str, axes: tuple[str, ...], values: Any, unit: str, long_name: str) -> None:
        dataset[name] = (axes, values, {"units": unit, "long_name": long_name})

    dataset.coords["depth"] = (
        "depth", profile.depths, {"units": "m", "long_name": "depth below the surface"},
    )  # fmt: skip
    dataset.coords["component"] = ("component", list(COMPONENTS))
    dataset.coords["pass"] = ("pass", ["y", "x"])
    add("von_mises", ("depth",), profile.von_mises, "Pa", "largest von Mises stress")
    add("tresca", ("depth",), profile.tresca, "Pa", "largest Tresca stress")
    add("row", ("depth",), profile.pixels[:, 0], "1", "row of the largest von Mises stress")
    add("column", ("depth",), profile.pixels[:, 1], "1", "column of the largest von Mises stress")
    add(
        "orthogonal_shear", ("depth", "pass"), profile.orthogonal_shear, "Pa",
        "largest amplitude of the orthogonal shear stress in a pass along an axis",
    )  # fmt: skip
    if profile.yielded_area is not None:
        add(
            "yielded_area", ("depth",), profile.yielded_area, "m2",
            "area where the von Mises stress exceeds the yield strength",
        )  # fmt: skip
    add("peak_von_mises", ("y", "x"), profile.peak, "Pa", "largest von Mises stress over depth")
    for axis, section in (("x", result.section_x), ("y", result.section_y)):
        add(
            f"section_{axis}", ("component", "depth", axis), section, "Pa",
            f"stress on the plane along {axis} through the largest von Mises stress",
        )  # fmt: skip
    depth, y, x = result.place
    dataset.attrs |= {
        "title": "Stress below a contact of rough surfaces",
        "body": result.body,
        "friction": result.friction,
        "direction": result.direction,
        "direction_units": "rad",
        "stress_precision": result.precision,
        "max_von_mises": result.max_von_mises,
        "max_von_mises_units": "Pa",
        "max_von_mises_depth": depth,
        "max_von_mises_y": y,
        "max_von_mises_x": x,
        "warnings": "\n".join(result.warnings),
    }
    return dataset


def body_of(result: ContactResult, body: str) -> Material:
    """Return the material of a body of a contact, or raise `InputError`."""
    if body not in BODIES:
        raise InputError(f"must be 'first' or 'second', got {body!r}", argument="body", value=body)
    return result.material if body == "first" else result.counter_material
