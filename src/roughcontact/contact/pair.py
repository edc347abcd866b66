"""Pair of bodies: two surfaces, two materials, and the boundary condition."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.checkpoints import digest_arrays
from roughcontact._version import __version__
from roughcontact.errors import ArgumentRef, InputError, require_choice
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.coating import Coatings
from roughcontact.halfspace.fft import Workspace
from roughcontact.material.material import RIGID, Material, contact_modulus, softer_material
from roughcontact.solvers.operator import Family
from roughcontact.surface import roughness
from roughcontact.surface.nominal_bodies import NominalBody
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import format_lengths

BODIES = {"body": "body", "counter_body": "counter-body"}
"""Labels of the two bodies: the rough body and its counter-body."""

CounterSurface = Surface | NominalBody
"""Types of a counter-body; a nominal body takes the grid of the rough map."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two bodies in contact: maps, materials and boundary."""

    surface: Surface  # Heights of the rough body
    material: Material  # Material of the rough body
    counter_surface: Surface | None = None  # Heights of the counter-body on the same grid
    counter_material: Material = RIGID  # Material of the counter-body
    boundary: Boundary = Boundary.FREE  # Boundary condition

    @classmethod
    def from_arguments(
        cls,
        surface: Surface,
        material: Material,
        counter_surface: CounterSurface | None,
        counter_material: Material,
        boundary: str,
    ) -> Pair:
        """Return the pair described by arguments of the public interface."""
        if not isinstance(counter_surface, NominalBody):
            return cls(surface, material, counter_surface, counter_material, Boundary(boundary))
        pair = cls(surface, material, None, counter_material, Boundary(boundary))
        return replace(pair, counter_surface=counter_surface.sample_body(pair.surface))

    def __post_init__(self) -> None:
        """Raise `InputError` for bodies that cannot be combined."""
        for name, value, kind in (
            ("surface", self.surface, Surface),
            ("counter_surface", self.counter_surface, Surface | None),
            ("material", self.material, Material),
            ("counter_material", self.counter_material, Material),
        ):
            if not isinstance(value, kind):
                wanted = "Material" if kind is Material else "Surface"
                raise InputError(f"must be a {wanted}, got {type(value).__name__}", argument=name)
        self._require_one_grid()
        # Raises if both are rigid.
        contact_modulus(self.material, self.counter_material)
        if self.is_profile:
            object.__setattr__(self, "boundary", self.boundary.profile_boundary)

    def _require_one_grid(self) -> None:
        counter = self.counter_surface
        if counter is None:
            return
        surface = self.surface
        if counter.shape != surface.shape or not np.allclose(
            counter.pixel, surface.pixel, rtol=1e-9, atol=0
        ):
            text = [
                f"{body.shape[0]} × {body.shape[1]} points of {format_lengths(body.pixel)}"
                for body in (counter, surface)
            ]
            raise InputError(
                f"has {text[0]}, the surface {text[1]}: both bodies need the same grid; "
                f"{ArgumentRef('align', True)} resamples one to the grid of the other",
                argument="counter_surface",
            )

    @property
    def is_profile(self) -> bool:
        """Whether the bodies are profiles: plane strain, with loads and areas per meter."""
        return self.surface.is_profile

    def require_map(self, what: str, *, coated: bool = True) -> None:
        """Raise `InputError` for profiles, optionally for coatings; ``what`` needs a map."""
        if self.is_profile:
            self.surface.require_map(what)
        if not coated:
            self.require_uncoated(what)

    @property
    def is_coated(self) -> bool:
        """Whether one of the bodies has a coating."""
        return bool(self.material.coating or self.counter_material.coating)

    def require_uncoated(self, what: str) -> None:
        """Raise `InputError` for coated bodies, which ``what`` does not support."""
        if self.is_coated:
            raise InputError(
                f"is not available for {what}; leave it out, or solve the contact alone",
                argument="coating",
            )

    @property
    def whole(self) -> str:
        """Kind of the surface: ``"map"`` or ``"profile"``."""
        return "profile" if self.is_profile else "map"

    @property
    def load_dimension(self) -> str:
        """Dimension of loads for `units.to_si`: force, for profiles line load."""
        return "line load" if self.is_profile else "force"

    @property
    def load_unit(self) -> str:
        """Unit of loads: N, for profiles N/m."""
        return "N/m" if self.is_profile else "N"

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)``."""
        return self.surface.shape

    @property
    def pixel(self) -> tuple[float, float]:
        """Pixel edges ``(dy, dx)`` [m]."""
        return self.surface.pixel

    @property
    def pixel_area(self) -> float:
        """Area of one pixel [m²]."""
        return self.pixel[0] * self.pixel[1]

    @property
    def size(self) -> tuple[float, float]:
        """Edges of the map ``(y, x)`` [m]."""
        return self.surface.size

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]; for coated bodies of their outermost layers."""
        return contact_modulus(self.material, self.counter_material)

    @property
    def softer(self) -> Material | None:
        """Material with the smaller ceiling, or ``None`` if none is known."""
        return softer_material(self.material, self.counter_material)

    @property
    def origins(self) -> tuple[Provenance, ...]:
        """Provenance of the maps, of the counter-body last."""
        bodies = (self.surface, self.counter_surface)
        return tuple(body.provenance for body in bodies if body is not None)

    @property
    def first_to_yield(self) -> Material | None:
        """Body that yields first under a contact spot; ``None`` if no strength is known."""
        if self.is_coated:
            return None
        known = [b for b in (self.material, self.counter_material) if b.first_yield_pressure]
        return min(known, key=lambda body: self.yields_at(body) or math.inf, default=None)

    def yields_at(self, body: Material) -> float | None:
        """Return the peak pressure at which a body first yields under a contact spot [Pa]."""
        return body.line_yield_pressure if self.is_profile else body.first_yield_pressure

    @property
    def has_holes(self) -> bool:
        """Whether a height of either body is missing."""
        bodies = (self.surface, self.counter_surface)
        return any(body is not None and body.missing > 0 for body in bodies)

    @property
    def heights(self) -> NDArray[np.float64]:
        """Sum of the heights of both bodies [m], shape (ny, nx); NaN where one is missing."""
        if self.counter_surface is None:
            return self.surface.heights
        return self.surface.heights + self.counter_surface.heights

    @property
    def highest(self) -> float:
        """Largest of `heights` [m], at the point of first contact."""
        return _highest(self.heights)

    @property
    def initial_gap(self) -> NDArray[np.float64]:
        """Gap at first touch [m], a new array of shape (ny, nx); NaN where one is missing."""
        heights = self.heights
        return _highest(heights) - heights

    @cached_property
    def rms_slope(self) -> float:
        """Root-mean-square slope of both bodies together; NaN if no point has both neighbors."""
        try:
            return roughness.rms_gradient(self.initial_gap, self.pixel)
        except InputError:
            return math.nan

    def material_of(self, body: str) -> Material:
        """Return the material of ``"body"`` or ``"counter_body"``."""
        require_choice(tuple(BODIES), in_body=body)
        return self.material if body == "body" else self.counter_material

    def operators(self, precision: str, workspace: Workspace, softness: float = 1.0) -> Family:
        """Return a factory of the displacement operator on the grid."""
        where = self.shape, self.pixel, self.contact_modulus / softness
        coatings = Coatings.from_bodies(self.material, self.counter_material)
        return self.boundary.operators(
            *where, coatings=coatings, precision=precision, workspace=workspace
        )

    def record(self) -> dict[str, Any]:
        """Return the record of bodies and program version for `checkpoints.lock_folder`."""
        surface, counter = self.surface, self.counter_surface
        return {
            "version": __version__,
            "surface": digest_arrays(surface.heights, surface.pixel, surface.holes_masked),
            "counter_surface": counter and digest_arrays(counter.heights, counter.pixel),
            "source": surface.provenance.source,
            "material": _words(self.material),
            "counter_material": _words(self.counter_material),
            "boundary": str(self.boundary),
        }


def _highest(heights: NDArray[np.float64]) -> float:
    # Unlike np.nanmax, an empty maximum gives NaN without a warning.
    return float(np.fmax.reduce(heights, axis=None))


def _words(material: Material) -> dict[str, str]:
    return {name: str(value) for name, value in asdict(material).items()}
