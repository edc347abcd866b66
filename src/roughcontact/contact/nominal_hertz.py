"""Hertz's contact of the nominal bodies of a rough contact, in closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.contact.pair import Pair
from roughcontact.halfspace.boundary import Boundary, longer_side
from roughcontact.surface.alignment import cosine_sine
from roughcontact.surface.nominal_bodies import BODIES
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.theory import hertz

# Methods that do not change the nominal body.
_CURVATURE_KEEPING_STEPS = {
    "note",
    "without_outliers",
    "filled",
    "masked",
    "cropped",
    "largest_rectangle",
    "resampled",
    "indented",
}


def curvature_of_map(provenance: Provenance) -> Array | None:
    """Return the curvature of the nominal body added to a map; None if unknown."""
    result = _origin_curvature(provenance.origin)
    for step in provenance.operations:
        if result is None:
            return None
        if step.method == "with_form":
            form = curvature_of_map(step.arguments["form"])
            result = None if form is None else result + form
        else:
            result = _apply_step(result, step)
    return result


def is_smooth(pair: Pair) -> bool:
    """Return whether the bodies of a pair are nominal bodies without roughness."""
    return all(_is_nominal(origin) for origin in pair.origins)


def _is_nominal(provenance: Provenance) -> bool:
    return is_nominal_origin(provenance) and all(
        step.method in _SHAPE_KEEPING_STEPS
        or (step.method == "with_form" and _is_nominal(step.arguments["form"]))
        for step in provenance.operations
    )


def is_nominal_origin(provenance: Provenance) -> bool:
    """Return whether a map was created as a nominal body."""
    origin = provenance.origin
    return origin is not None and origin.method.removeprefix("nominal.") in BODIES


# Methods that add no roughness to a nominal body.
_SHAPE_KEEPING_STEPS = _CURVATURE_KEEPING_STEPS - {"indented"} | {"rotated"}


def _origin_curvature(origin: Operation | None) -> Array | None:
    """Return the curvature of the origin of a map."""
    body = None if origin is None else BODIES.get(origin.method.removeprefix("nominal."))
    if origin is None or body is None:
        return np.zeros((2, 2))
    if body.curvatures is None:
        return None
    result = np.diag(body.curvatures(origin.arguments[body.size]))
    return (
        _rotate_curvature(result, origin.arguments["angle"]) if body.option == "angle" else result
    )


def _apply_step(curvature: Array, step: Operation) -> Array | None:
    """Return the curvature after a preparation step."""
    specified = step.arguments
    if step.method in _CURVATURE_KEEPING_STEPS or not curvature.any():
        return curvature
    match step.method:
        case "leveled":
            # A plane has no curvature; a quadric removes all of it.
            return np.zeros((2, 2)) if specified["form"] == "quadric" else curvature
        case "rotated":
            return _rotate_curvature(curvature, specified["angle"])
        case "aligned":
            if specified["mirrored"]:
                curvature = curvature * [[1, -1], [-1, 1]]
            return _rotate_curvature(curvature, specified["angle"])
        case "filtered":
            # An S-filter of waves far shorter than the body does not change it.
            return curvature if specified["l"] is None else None
    return None


def _rotate_curvature(curvature: Array, angle: float) -> Array:
    """Return a curvature rotated by an angle [degrees], counter-clockwise; y points down."""
    c, s = cosine_sine(angle)
    turn = np.array([[c, -s], [s, c]])
    return turn @ curvature @ turn.T


def principal_radii(curvature: Array) -> tuple[tuple[float, float], float]:
    """Return the principal radii of a curvature, and the direction of the first [degrees]."""
    values, vectors = np.linalg.eigh(curvature)
    small, large = (float(value) for value in values)
    if abs(small) <= _STRAIGHT_TOLERANCE * abs(large):
        small = 0.0
    y, x = (float(part) for part in vectors[:, 0])
    angle = math.degrees(math.atan2(-y, x)) % 180
    # Directions within rounding of an axis are set to the axis.
    angle = round(angle, 9) % 180
    return (math.inf if small == 0 else 1 / small, 1 / large if large else math.inf), angle


# Fraction of the larger curvature up to which the smaller one is rounding.
_STRAIGHT_TOLERANCE = 1e-12


CIRCLE, ELLIPSE, LINE = "circle", "ellipse", "line"
"""Shapes of the contact of smooth bodies."""

# Relative difference of radii up to which they are equal.
_ROUND_TOLERANCE = 1e-9


@dataclass(frozen=True)
class ContactShape:
    """Shape of the contact of two smooth bodies, with their relative curvature."""

    kind: str  # Shape of the contact
    radii: tuple[float, ...]  # Radii of relative curvature [m], the larger first
    angle: float  # Direction of the longer semi-axis or line [degrees], counter-clockwise from x

    @property
    def axis(self) -> int | None:
        """Axis of the map parallel to a line contact: 0 for y, 1 for x, or None."""
        return {0.0: 1, 90.0: 0}.get(self.angle) if self.kind == LINE else None


@dataclass(frozen=True)
class SmoothContact:
    """Hertz's contact of the nominal bodies under the load of a rough contact."""

    shape: ContactShape  # Shape of the contact
    load: float  # W [N]
    semi_axes: tuple[float, ...]  # Semi-axes [m]
    length: float | None  # Length of a line contact: of the map along it [m]
    max_pressure: float  # Peak pressure [Pa]
    approach: float | None  # From first touch [m]

    @property
    def area(self) -> float:
        """Area of contact [m²]."""
        if self.length is not None:
            return 2 * self.semi_axes[0] * self.length
        return math.pi * self.semi_axes[0] * self.semi_axes[-1]

    @property
    def mean_pressure(self) -> float:
        """Load over area [Pa]."""
        return self.load / self.area

    @property
    def reach(self) -> tuple[float, float]:
        """Half-lengths of the contact along y and along x [m]."""
        c, s = (f(math.radians(self.shape.angle)) for f in (math.cos, math.sin))
        if self.length is not None:
            half = self.semi_axes[0]
            return abs(half * c), abs(half * s)
        a, b = self.semi_axes[0], self.semi_axes[-1]
        return math.hypot(a * s, b * c), math.hypot(a * c, b * s)


def relative_curvature(origins: Sequence[Provenance]) -> Array | None:
    """Return the sum of the curvatures of nominal bodies [1/m]; None if one has none."""
    result = [curvature_of_map(origin) for origin in origins]
    known = [item for item in result if item is not None]
    return sum(known[1:], known[0]) if len(known) == len(result) else None


def has_nominal_body(origins: Sequence[Provenance]) -> bool:
    """Return whether a nominal body, and not the map, bounds the contact of two bodies.

    The load over the area of the map is then no nominal pressure.
    """
    curvature = relative_curvature(origins)
    return any(map(is_nominal_origin, origins)) if curvature is None else bool(curvature.any())


def shape_of(pair: Pair) -> ContactShape | None:
    """Return the shape of the contact of the nominal bodies of a pair; None without one."""
    total = relative_curvature(pair.origins)
    if total is None or not total.any():
        return None
    if pair.is_profile:
        return ContactShape(LINE, (1 / float(total[1, 1]),), 90.0) if total[1, 1] > 0 else None
    (larger, smaller), angle = principal_radii(total)
    if larger < 0 or smaller < 0:
        # A body narrower than its hollow touches at the rim.
        return None
    if math.isinf(larger):
        return ContactShape(LINE, (smaller,), angle)
    if larger <= (1 + _ROUND_TOLERANCE) * smaller:
        return ContactShape(CIRCLE, (smaller,), 0.0)
    return ContactShape(ELLIPSE, (larger, smaller), angle)


def solve_smooth(pair: Pair, load: float) -> SmoothContact | None:
    """Return Hertz's contact of the nominal bodies of a pair; None without one."""
    shape, modulus = shape_of(pair), pair.contact_modulus
    if shape is None or not load > 0 or pair.is_coated:
        return None
    if shape.kind == LINE:
        return None if shape.axis is None else _line_contact(pair, shape, load)
    if shape.kind == CIRCLE:
        radius = shape.radii[0]
        sides: tuple[float, ...] = (hertz.contact_radius(load, radius, modulus),)
        peak = hertz.max_pressure(load, radius, modulus)
        approach = hertz.approach(load, radius, modulus)
    else:
        result = hertz.elliptic_contact(load, (shape.radii[0], shape.radii[1]), modulus)
        sides, peak, approach = result.semi_axes, result.max_pressure, result.approach
    alone = pair.boundary is Boundary.FREE
    return SmoothContact(shape, load, sides, None, peak, approach if alone else None)


def _line_contact(pair: Pair, shape: ContactShape, load: float) -> SmoothContact:
    axis, radius, modulus = shape.axis, shape.radii[0], pair.contact_modulus
    assert axis is not None
    length, datum = pair.size[axis], longer_side(pair.shape, pair.pixel)
    result = hertz.line_contact(load / length, radius, modulus)
    approach = None
    # Reference of the displacement of the strip, see `Boundary`.
    if pair.boundary.periodic_axes == (axis,) and datum > result.half_width:
        approach = hertz.line_approach(load / length, radius, modulus, datum)
    return SmoothContact(shape, load, (result.half_width,), length, result.max_pressure, approach)


def load_of_peak_pressure(pair: Pair, shape: ContactShape, max_pressure: float) -> float | None:
    """Return the load at which the smooth bodies have a given peak pressure."""
    pair.require_uncoated("Hertz's peak pressure")
    modulus, radius = pair.contact_modulus, shape.radii[0]
    if shape.kind == CIRCLE:
        return hertz.load_at_pressure(max_pressure, radius, modulus)
    if shape.kind == ELLIPSE:
        return hertz.elliptic_load(max_pressure, (radius, shape.radii[1]), modulus)
    if shape.axis is None:
        return None
    return hertz.line_load(max_pressure, radius, modulus) * pair.size[shape.axis]
