"""State of a contact after a path of loads with plastic flow: bodies and derived quantities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arguments import set_fields, validate_arguments
from roughcontact.cautions import Caution
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import rim_excess
from roughcontact.errors import input_error
from roughcontact.halfspace import tensors
from roughcontact.halfspace.layers import Pull
from roughcontact.material.material import Material
from roughcontact.result import Result, presentation
from roughcontact.surface.placement import shift_surface
from roughcontact.units import Quantities, Quantity, to_si

Array = NDArray[Any]


class _Layers:
    """Layers from the surface down."""

    faces: NDArray[np.float64]

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return _layer_centers(self.faces)


class _Stresses(_Layers):
    stress: Array
    residual_stress: Array

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], a value for each tensor."""
        return tensors.equivalent(tensors.components(self.stress))

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], a value for each tensor."""
        return tensors.equivalent(tensors.components(self.residual_stress))


@dataclass(frozen=True, eq=False)
class DepthProfile(_Stresses):
    """Plastic strain and stress over the depth below a point."""

    point: tuple[int, int]  # Row and column on the map
    place: tuple[float, float]  # Coordinates (y, x) of the point [m]
    faces: NDArray[np.float64]  # (nz + 1,) Depths of the faces of the layers [m], from 0 on
    accumulated: Array  # (nz,) Accumulated plastic strain
    strength: Array  # (nz,) Yield strength at that strain [Pa]
    stress: Array  # (nz, 3, 3) Stress under load [Pa]
    residual_stress: Array  # (nz, 3, 3) Stress by the plastic strain alone [Pa]


@dataclass(frozen=True, eq=False)
class DepthSection(_Stresses):
    """Plastic strain and stress on a vertical plane along a row or a column of the map."""

    along: str  # Horizontal axis of the plane
    index: int  # Row of the plane, or column with `along="y"`
    across: float  # Coordinate of the plane on the other axis [m]
    edges: NDArray[np.float64]  # (n + 1,) Edges of the pixels along the plane [m]
    faces: NDArray[np.float64]  # (nz + 1,) Depths of the faces of the layers [m], from 0 on
    pressure: NDArray[np.float64]  # (n,) Contact pressure [Pa]
    residual_displacement: NDArray[np.float64]  # (n,) Residual displacement [m]
    accumulated: Array  # (nz, n) Accumulated plastic strain
    strength: Array  # (nz, n) Yield strength at that strain [Pa]
    stress: Array  # (nz, n, 3, 3) Stress under load [Pa]
    residual_stress: Array  # (nz, n, 3, 3) Stress by the plastic strain alone [Pa]

    @property
    def place(self) -> NDArray[np.float64]:
        """Centers of the pixels along the plane [m], shape (n,)."""
        return _layer_centers(self.edges)


@dataclass(frozen=True, eq=False)
class LayerProfile(_Layers):
    """Largest values of each layer below the map."""

    faces: NDArray[np.float64]  # (nz + 1,) Depths of the faces of the layers [m], from 0 on
    plastic_fraction: NDArray[np.float64]  # (nz,) Share of the layer with plastic strain
    max_accumulated: Array  # (nz,) Largest accumulated plastic strain
    max_von_mises: Array  # (nz,) Largest von Mises stress under load [Pa]
    max_residual_von_mises: Array  # (nz,) Same by the plastic strain alone [Pa]


def _layer_centers(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    return (edges[1:] + edges[:-1]) / 2


Window = tuple[slice, slice]
Place = tuple[int | slice, int | slice]

GUARD = 2
"""Rows and columns at the edge of the volume that must stay free of plastic strain."""

# Tolerance of the stress after the iteration, over the yield strength.
_ROUNDING = 1e-3


@dataclass(frozen=True, eq=False)
class PlasticBody:
    """Plastic strain and stress of a body, in layers from the surface down."""

    material: Material  # Material of the body
    pixel_area: float  # Area of a pixel [m²]
    margin: int
    thickness: NDArray[np.float64]  # (nz,) Thickness of each layer [m]
    plastic_strain: Array  # (nz, 5, ny, nx) Plastic strain, constant over each layer
    accumulated: Array  # (nz, ny, nx) Accumulated plastic strain e = ∫ √(2/3 dε:dε)
    stress: Array  # (nz, 5, ny, nx) Deviator under load, mean over each layer [Pa]
    mean_stress: Array  # (nz, ny, nx) A third of the trace under load [Pa]
    residual_stress: Array  # (nz, 5, ny, nx) Deviator by the plastic strain alone [Pa]
    mean_residual_stress: Array  # (nz, ny, nx) A third of the trace without load [Pa]

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return np.cumsum(self.thickness) - self.thickness / 2

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], shape (nz, ny, nx)."""
        return tensors.equivalent(self.stress.swapaxes(0, 1))

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], shape (nz, ny, nx)."""
        return tensors.equivalent(self.residual_stress.swapaxes(0, 1))

    @cached_property
    def max_plastic_strain(self) -> float:
        """Largest accumulated plastic strain."""
        return float(self.accumulated.max())

    @cached_property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        cells = np.count_nonzero(self.accumulated, axis=(1, 2))
        return float(cells @ self.thickness) * self.pixel_area

    @cached_property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches [m]: the lower face of its lowest layer."""
        layers = np.flatnonzero(self.accumulated.any(axis=(1, 2)))
        return float(self.thickness[: layers[-1] + 1].sum()) if layers.size else 0.0

    @cached_property
    def max_von_mises(self) -> float:
        """Largest von Mises stress under load [Pa]."""
        return float(self.von_mises.max())

    @cached_property
    def max_residual_von_mises(self) -> float:
        """Largest von Mises stress by the plastic strain alone [Pa]."""
        return float(self.residual_von_mises.max())

    @property
    def has_reached_rim(self) -> bool:
        """Whether plastic strain has reached the outer rows and columns of the volume."""
        rim = np.ones(self.accumulated.shape[1:], bool)
        rim[GUARD:-GUARD, GUARD:-GUARD] = False
        return bool(self.accumulated[:, rim].any())

    @property
    def flows_back(self) -> bool:
        """Whether the residual stress exceeds the yield strength."""
        strength = self.material.law.strength(self.accumulated)
        return bool((self.residual_von_mises > (1 + _ROUNDING) * strength).any())

    def largest_strain_index(self, inside: Window) -> tuple[int, int, int]:
        """Return layer, row and column of the largest plastic strain in a window.

        Without plastic strain in the window: of the largest von Mises stress.
        """
        values = self.accumulated[:, *inside]
        if not values.any():
            values = self.von_mises[:, *inside]
        layer, row, column = np.unravel_index(values.argmax(), values.shape)
        return int(layer), int(row), int(column)

    def layer_profile(self, inside: Window) -> LayerProfile:
        """Return the largest values of each layer in a window of rows and columns."""
        accumulated, loaded, residual = (
            values[:, *inside]
            for values in (self.accumulated, self.von_mises, self.residual_von_mises)
        )
        return LayerProfile(
            np.append(0.0, np.cumsum(self.thickness)),
            (accumulated > 0).mean(axis=(1, 2)),
            *(values.max(axis=(1, 2)) for values in (accumulated, loaded, residual)),
        )

    def depth_values(self, where: Place) -> tuple[Array, Array, Array, Array, Array]:
        """Return faces [m], accumulated strain, strength and both stresses [Pa] at pixels."""
        accumulated = self.accumulated[:, *where].copy()
        stress, residual = (
            tensors.tensor(np.moveaxis(deviator[:, :, *where], 1, 0), mean[:, *where])
            for deviator, mean in (
                (self.stress, self.mean_stress),
                (self.residual_stress, self.mean_residual_stress),
            )
        )
        faces = np.append(0.0, np.cumsum(self.thickness))
        return faces, accumulated, self.material.law.strength(accumulated), stress, residual


@dataclass(frozen=True)
class PathPoint:
    """Point of a load path.

    Parameters
    ----------
    load : float, str or quantity of pint
        Normal load [N]; zero separates the bodies.
    offset : (float, float), str or quantity of pint
        Displacement of the counter-surface along ``(y, x)`` [m].
    friction : float
        Coefficient μ of full sliding: traction μ p on the rough body.
    direction : float
        Direction of the traction [degrees], counter-clockwise from x as seen in the map.

    Raises
    ------
    InputError
        If a value is not finite, or the load or the coefficient is negative.
    """

    load: float
    offset: tuple[float, float] = (0.0, 0.0)
    friction: float = 0.0
    direction: float = 0.0

    @validate_arguments
    def __init__(
        self,
        load: Quantity,
        offset: Quantities = (0.0, 0.0),
        friction: float = 0.0,
        direction: float = 0.0,
    ) -> None:
        force, way = to_si(load, "force", "load"), _as_direction(to_si(offset, "length", "offset"))
        set_fields(self, load=force, offset=way, friction=friction, direction=direction)
        for name, minimum in (("load", 0.0), ("friction", 0.0), ("direction", -math.inf)):
            value = getattr(self, name)
            if not (isinstance(value, Real) and minimum <= float(value) < math.inf):
                raise input_error(
                    name, value, f"must be finite{' and not negative' if minimum == 0 else ''}"
                )
            object.__setattr__(self, name, float(value))

    @property
    def traction(self) -> Pull:
        """Traction on the rough body along x and y over the pressure."""
        angle = math.radians(self.direction)
        # The cosine of a right angle is 6e-17 and must be no traction.
        shares = (round(math.cos(angle), 15), round(math.sin(angle), 15))
        return self.friction * shares[0], self.friction * shares[1]

    def interpolate(self, end: PathPoint, part: int, count: int) -> PathPoint:
        """Return the point after ``part`` of ``count`` equal steps to another point.

        Friction and direction are those of the end point.
        """
        (y, x), (end_y, end_x) = self.offset, end.offset
        ways = (self.load, end.load), (y, end_y), (x, end_x)
        load, y, x = (start + (stop - start) * part / count for start, stop in ways)
        return PathPoint(load, (y, x), end.friction, end.direction)


def move_counter_surface(pair: Pair, offset: tuple[float, float]) -> Pair:
    """Return a pair with its counter-surface moved along ``(y, x)`` [m]."""
    counter = pair.counter_surface
    if counter is None or not any(offset):
        return pair
    return replace(
        pair, counter_surface=shift_surface(counter, offset, pair.boundary.periodic_axes)
    )


def _as_direction(values: Any) -> tuple[float, float]:
    if (
        isinstance(values, Sequence | np.ndarray)
        and len(values) == 2
        and all(isinstance(value, Real) and math.isfinite(value) for value in values)
    ):
        return float(values[0]), float(values[1])
    raise input_error("offset", values, "must be two finite numbers, along y and x [m]")


CONVERGED = "converged"
"""Status of a completed path."""


class PlasticRegime(StrEnum):
    """Regime of plastic strain: none, below the surface, or up to it."""

    ELASTIC = "elastic"
    BELOW_SURFACE = "plastic below the surface"
    AT_SURFACE = "plastic up to the surface"


@dataclass(frozen=True)
class Increment:
    """Outcome of a load increment of the path."""

    load: float  # Normal load [N]
    approach: float  # Approach of the bodies from the first touch [m]
    contact_area: float  # Real contact area [m²]
    max_pressure: float  # Largest pressure [Pa]
    max_plastic_strain: float  # Largest accumulated plastic strain so far
    plastic_volume: float  # Volume with plastic strain so far, of both bodies [m³]
    residuals: tuple[float, ...]
    convolutions: int  # Convolutions of the contact solver
    step_error: float | None = None
    offset: tuple[float, float] = (0.0, 0.0)  # Offset of the counter-surface (y, x) [m]
    friction: float = 0.0  # Traction over pressure
    direction: float = 0.0  # Direction of the traction [°]

    @property
    def point(self) -> PathPoint:
        """Point of the path."""
        return PathPoint(self.load, self.offset, self.friction, self.direction)

    @property
    def has_moved(self) -> bool:
        """Whether the counter-surface has moved or slid."""
        return bool(any(self.offset) or self.friction)

    @property
    def residual(self) -> float:
        """Residual after the last iteration."""
        return self.residuals[-1]

    @property
    def iterations(self) -> int:
        """Iterations of the loop."""
        return len(self.residuals)


@dataclass(frozen=True, eq=False, repr=False)
class ElastoplasticResult(Result):
    """Contact after a path of loads, with its plastic strain.

    Parameters
    ----------
    solution : ContactResult
        Pressure, gap, approach and certificate at the last load; the gap includes the residual
        displacement.
    residual_displacement : ndarray, shape (ny, nx)
        Change of the gap by plastic strain [m], positive into the bodies.
    bodies : tuple of PlasticBody
        Yielding bodies, the rough body first.
    increments : tuple of Increment
        Load increments in order, including those of a resumed run.
    yield_excess : float
        Largest ratio of von Mises stress to local yield strength, minus one; negative if no
        point is at yield.
    precision : {"double", "single"}
        Arithmetic of the volume; the contact is solved in double.
    tolerance : float
        Limit of the residual.
    status : str
        ``"converged"``, or the reason why the path was not completed.
    seconds : float
        Wall time.
    version : str
        Version of the program.
    largest_pressure : ndarray, optional
        Pressure at the largest load [Pa], shape (ny, nx), if the path ends at a lower load.
    """

    solution: ContactResult
    residual_displacement: NDArray[np.float64]
    bodies: tuple[PlasticBody, ...]
    increments: tuple[Increment, ...]
    yield_excess: float
    precision: str
    tolerance: float
    status: str
    seconds: float
    version: str = field(default="")
    largest_pressure: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        """Make the maps read-only."""
        self.residual_displacement.flags.writeable = False
        if self.largest_pressure is not None:
            self.largest_pressure.flags.writeable = False

    @property
    def turns(self) -> list[float]:
        """Loads at which the path reverses, and the last load [N]."""
        loads = [step.load for step in self.increments]
        return [
            load
            for before, load, after in zip([0.0, *loads], loads, [*loads[1:], None], strict=False)
            if after is None or (load - before) * (after - load) < 0
        ]

    @property
    def contact(self) -> ContactResult:
        """Old name of ``solution``."""
        return self.solution

    @property
    def pressure(self) -> NDArray[np.float64]:
        """Pressure at the last load [Pa], shape (ny, nx)."""
        return self.solution.pressure

    @property
    def contact_fraction(self) -> float:
        """Contact area at the last load over the area of the whole map."""
        return self.solution.contact_fraction

    @property
    def largest(self) -> tuple[float, NDArray[np.float64]]:
        """Largest load [N] and its pressure [Pa]; the last load if no larger one is stored."""
        if self.largest_pressure is None:
            return self.solution.load, self.solution.pressure
        return max(step.load for step in self.increments), self.largest_pressure

    @property
    def has_moved(self) -> bool:
        """Whether the counter-surface moved or slid on the path."""
        return any(step.has_moved for step in self.increments)

    @property
    def converged(self) -> bool:
        """Whether the path was completed within the tolerances."""
        return self.status == CONVERGED

    @property
    def residual(self) -> float:
        """Largest residual of the plastic strain along the path; see `Increment`."""
        return max((step.residual for step in self.increments), default=0.0)

    @property
    def step_error(self) -> float | None:
        """Relative error of approach and area by the finite load steps; None if unknown."""
        return self.increments[-1].step_error if self.increments else 0.0

    @property
    def iterations(self) -> int:
        """Iterations of the loop, all loads together."""
        return sum(step.iterations for step in self.increments)

    @property
    def max_plastic_strain(self) -> float:
        """Largest accumulated plastic strain in any body."""
        return max(body.max_plastic_strain for body in self.bodies)

    @property
    def plastic_volume(self) -> float:
        """Volume with plastic strain, of all bodies [m³]."""
        return sum(body.plastic_volume for body in self.bodies)

    @property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches in any body [m]."""
        return max(body.plastic_depth for body in self.bodies)

    @property
    def yielded(self) -> NDArray[np.bool_]:
        """Pixels with plastic strain in the uppermost layer of any body, shape (ny, nx)."""
        return np.any([body.accumulated[0][self.map_window] > 0 for body in self.bodies], axis=0)

    @property
    def map_window(self) -> Window:
        """Rows and columns of the volume below the map."""
        (ny, nx), first = self.solution.pressure.shape, self.bodies[0].margin
        return slice(first, first + ny), slice(first, first + nx)

    @property
    def perimeter_corrected_area(self) -> float:
        """Contact area without the excess of an elastic rim by the pixels [m²].

        See `ContactResult.perimeter_corrected_area`; the perimeter of yielded pixels, where the
        pressure drops from the plateau to zero, is not corrected.
        """
        pressed = self.solution
        elastic = pressed.contact & ~self.yielded
        excess = rim_excess(pressed.contact, elastic, pressed.boundary) * pressed.pixel_area
        return max(pressed.contact_area - excess, 0.0)

    @property
    def regime(self) -> PlasticRegime:
        """Regime of plastic strain: none, below the surface, or up to it."""
        if not self.plastic_volume:
            return PlasticRegime.ELASTIC
        return PlasticRegime.AT_SURFACE if self.plastic_at_surface else PlasticRegime.BELOW_SURFACE

    @property
    def plastic_at_surface(self) -> bool:
        """Whether plastic strain reaches the contact, or without contact the free surface."""
        touching, flowed = self.solution.contact, self.yielded
        return bool((flowed & touching if touching.any() else flowed).any())

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the result, the most severe first."""
        return presentation().volume_cautions(self)

    def profile(self, point: tuple[int, int] | None = None, body: int = 0) -> DepthProfile:
        """Return plastic strain and stress over the depth below a point."""
        held = _body(self, body)
        row, column = most_strained(self, body)[1:] if point is None else point
        shape = self.solution.pressure.shape
        if not (0 <= row < shape[0] and 0 <= column < shape[1]):
            raise input_error("point", point, f"must be inside the map of {shape} points")
        dy, dx = self.solution.surface.pixel
        where = row + held.margin, column + held.margin
        return DepthProfile(
            (int(row), int(column)),
            ((row + 0.5) * dy, (column + 0.5) * dx),
            *held.depth_values(where),
        )

    def section(self, along: str = "x", index: int | None = None, body: int = 0) -> DepthSection:
        """Return plastic strain and stress on a vertical plane along a row or a column."""
        held = _body(self, body)
        if along not in ("x", "y"):
            raise input_error("along", along, "must be 'x' or 'y'")
        axis = 1 if along == "x" else 0
        pressure, pixel = self.solution.pressure, self.solution.surface.pixel
        shape = pressure.shape
        chosen = most_strained(self, body)[2 - axis] if index is None else index
        if not 0 <= chosen < shape[1 - axis]:
            line = "row" if along == "x" else "column"
            raise input_error("index", index, f"must be a {line} of {shape[1 - axis]}")
        ends = slice(held.margin, held.margin + shape[axis])
        position = chosen + held.margin
        on_map = np.s_[chosen, :] if along == "x" else np.s_[:, chosen]
        faces, *fields = held.depth_values((position, ends) if along == "x" else (ends, position))
        return DepthSection(
            along,
            int(chosen),
            (chosen + 0.5) * pixel[1 - axis],
            np.arange(shape[axis] + 1) * pixel[axis],
            faces,
            pressure[on_map],
            self.residual_displacement[on_map],
            *fields,
        )

    def layers(self, body: int = 0) -> LayerProfile:
        """Return the largest plastic strain and stresses of each layer below the map."""
        return _body(self, body).layer_profile(self.map_window)


def most_strained(result: ElastoplasticResult, body: int = 0) -> tuple[int, int, int]:
    """Return layer, row and column of the largest plastic strain below the map."""
    return _body(result, body).largest_strain_index(result.map_window)


def _body(result: ElastoplasticResult, body: int) -> PlasticBody:
    if not 0 <= body < len(result.bodies):
        raise input_error("body", body, f"must be one of {len(result.bodies)} that yield")
    return result.bodies[body]
