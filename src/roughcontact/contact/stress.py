"""The elastic stress below a contact: what was found, and its file."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import netcdf
from roughcontact.contact import archive
from roughcontact.contact.cautions import Caution, Kind, careful, warned
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.halfspace import stress_summary
from roughcontact.halfspace.tensors import COMPONENTS, von_mises
from roughcontact.material.material import Material
from roughcontact.result import Result

if TYPE_CHECKING:
    import xarray


_NO_LONGER_ELASTIC = (
    "the stress exceeds the yield strength: it is that of an elastic body, which this "
    "one no longer is"
)
_OF_THE_RESOLUTION = (
    "the largest stress lies within two pixels of the surface: it is one of the "
    "resolution of the map"
)
_AT_THE_SURFACE = (
    "the largest stress lies at the surface: at the rim of a spot that slides it is right to 1 % "
    "from 20 pixels a radius on, to 6 % at 6 pixels, and one of the resolution below"
)
_NOT_SHALLOW_ENOUGH = "the largest stress lies at the least depth: look nearer to the surface"


@dataclass(frozen=True, eq=False, repr=False)
class StressResult(Result):
    """Elastic stress below a contact, with everything that went in.

    Arrays are read-only and in SI units; tensors hold xx, yy, zz, yz, xz, xy along their first
    axis, tension positive, z from the surface into the body.

    Parameters
    ----------
    solution : ContactResult
        The contact.
    body : {"body", "counter_body"}
        The body that was looked into.
    friction : float
        Coefficient μ of the traction μ p that the rough body feels in ``direction``; the
        counter-body feels the opposite.
    direction : float
        Angle from x [degrees], counter-clockwise as seen in the map.
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

    solution: ContactResult
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
    def contact(self) -> ContactResult:
        """The ``solution``, by its old name."""
        return self.solution

    @property
    def material(self) -> Material:
        """Material of the body."""
        return self.solution.pair.material_of(self.body)

    @property
    def max_von_mises(self) -> float:
        """Largest von Mises stress [Pa]."""
        return self.profile.max_von_mises

    @property
    def place(self) -> tuple[float, float, float]:
        """Where it is: depth, y and x of its pixel [m], counted from the corner of the map."""
        (row, column), (dy, dx) = self.profile.pixel_of_max, self.solution.surface.pixel
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
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, those of the contact first."""
        found = []
        if self.yielded_volume:
            found.append(careful(Kind.BEYOND_YIELD, _NO_LONGER_ELASTIC, volume=self.yielded_volume))
        if self.max_von_mises > 0 and self.profile.depth_of_max == self.profile.depths[-1]:
            text = "the largest stress lies at the greatest depth: look deeper"
            found.append(warned(Kind.DEEPEST, text, depth=self.profile.depth_of_max))
        if self.max_von_mises > 0:
            found += self._shallow()
        return (*self.solution.cautions, *found)

    def _shallow(self) -> list[Caution]:
        depth = self.profile.depth_of_max
        if depth == 0:
            return [careful(Kind.SHALLOW, _AT_THE_SURFACE, depth=depth)]
        if depth < 2 * max(self.solution.pair.pixel[self.solution.pair.is_profile :]):
            return [careful(Kind.SHALLOW, _OF_THE_RESOLUTION, depth=depth)]
        if depth == self.profile.depths[0]:
            return [warned(Kind.SHALLOW, _NOT_SHALLOW_ENOUGH, depth=depth)]
        return []

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

    def save(self, path: str | os.PathLike[str]) -> None:
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
        packed = {name: {"zlib": True, "complevel": 1} for name in ("pressure", "saturated")}
        netcdf.write(to_dataset(self), path, packed)


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
    dataset = archive.to_dataset(result.solution)
    _add_profile(dataset, result.profile)
    for axis, section in (("x", result.section_x), ("y", result.section_y)):
        dataset[f"section_{axis}"] = _variable(
            ("component", "depth", axis), section, "Pa",
            f"stress on the plane along {axis} through the largest von Mises stress",
        )  # fmt: skip
    depth, y, x = result.place
    dataset.attrs |= {
        "title": "Stress below a contact of rough surfaces",
        "body": result.body,
        "friction": result.friction,
        "direction": result.direction,
        "direction_units": "degree",
        "stress_precision": result.precision,
        "max_von_mises": result.max_von_mises,
        "max_von_mises_units": "Pa",
        "max_von_mises_depth": depth,
        "max_von_mises_y": y,
        "max_von_mises_x": x,
        "warnings": "\n".join(result.warnings),
    }
    return dataset


def _add_profile(dataset: xarray.Dataset, profile: stress_summary.Summary) -> None:
    """Add the largest stresses over the depth, and over the map."""
    about = {"units": "m", "long_name": "depth below the surface"}
    dataset.coords["depth"] = ("depth", profile.depths, about)
    dataset.coords["component"] = ("component", list(COMPONENTS))
    dataset.coords["pass"] = ("pass", ["y", "x"])
    over_depth = {
        "von_mises": (profile.von_mises, "Pa", "largest von Mises stress"),
        "tresca": (profile.tresca, "Pa", "largest Tresca stress"),
        "row": (profile.pixels[:, 0], "1", "row of the largest von Mises stress"),
        "column": (profile.pixels[:, 1], "1", "column of the largest von Mises stress"),
    }
    for name, described in over_depth.items():
        dataset[name] = _variable(("depth",), *described)
    dataset["orthogonal_shear"] = _variable(
        ("depth", "pass"), profile.orthogonal_shear, "Pa",
        "largest amplitude of the orthogonal shear stress in a pass along an axis",
    )  # fmt: skip
    if profile.yielded_area is not None:
        # Of a profile the pixels are one metre wide.
        extent, unit = ("length", "m") if profile.peak.shape[0] == 1 else ("area", "m2")
        dataset["yielded_area"] = _variable(
            ("depth",), profile.yielded_area, unit,
            f"{extent} where the von Mises stress exceeds the yield strength",
        )  # fmt: skip
    dataset["peak_von_mises"] = _variable(
        ("y", "x"), profile.peak, "Pa", "largest von Mises stress over depth"
    )


def _variable(
    axes: tuple[str, ...], values: NDArray[Any], unit: str, long_name: str
) -> tuple[tuple[str, ...], NDArray[Any], dict[str, str]]:
    return axes, values, {"units": unit, "long_name": long_name}
