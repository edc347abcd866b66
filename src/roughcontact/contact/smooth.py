"""The nominal bodies of a contact without their roughness: Hertz's contact in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass

from roughcontact.contact.pair import Pair
from roughcontact.halfspace.boundary import Boundary, longer_side
from roughcontact.surface import curvature
from roughcontact.theory import hertz

CIRCLE, ELLIPSE, LINE = "circle", "ellipse", "line"
"""Shapes of a contact of smooth bodies."""

# Radii that differ by less than this part are equal.
_ROUND = 1e-9


@dataclass(frozen=True)
class Shape:
    """Where two smooth bodies touch, and how they curve there against each other.

    Parameters
    ----------
    kind : {"circle", "ellipse", "line"}
        What the contact looks like.
    radii : tuple of float
        Radii of relative curvature [m], the larger first; one where the other is none, or the
        same.
    angle : float
        Direction of the longer side, or of the line, counter-clockwise from x [degrees].
    """

    kind: str
    radii: tuple[float, ...]
    angle: float

    @property
    def axis(self) -> int | None:
        """Axis of the map that a line lies along: 0 y, 1 x; None if it lies along neither."""
        return {0.0: 1, 90.0: 0}.get(self.angle) if self.kind == LINE else None


@dataclass(frozen=True)
class Smooth:
    """Hertz's contact of the nominal bodies under the load of a rough contact.

    Parameters
    ----------
    shape : Shape
        Of the contact.
    load : float
        W [N].
    semi_axes : tuple of float
        Radius of the circle, semi-axes of the ellipse (the longer first), or half-width of the
        line [m].
    length : float or None
        Of a line: that of the map along it [m].
    max_pressure : float
        Peak pressure [Pa].
    approach : float or None
        From first touch [m]; None where it depends on what lies far away from a line, or on
        copies of the map.
    """

    shape: Shape
    load: float
    semi_axes: tuple[float, ...]
    length: float | None
    max_pressure: float
    approach: float | None

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
        """How far the contact reaches from its middle along y and along x [m]."""
        c, s = (f(math.radians(self.shape.angle)) for f in (math.cos, math.sin))
        if self.length is not None:
            half = self.semi_axes[0]
            return abs(half * c), abs(half * s)
        a, b = self.semi_axes[0], self.semi_axes[-1]
        return math.hypot(a * s, b * c), math.hypot(a * c, b * s)


def shape_of(pair: Pair) -> Shape | None:
    """Return how the nominal bodies of a pair curve against each other.

    Parameters
    ----------
    pair : Pair
        The bodies; their surfaces know whether they are nominal ones, see `surface.curvature`.

    Returns
    -------
    Shape or None
        None where both are flat, or one is no body of Hertz's theory.
    """
    found = [curvature.of(origin) for origin in pair.origins]
    known = [one for one in found if one is not None]
    total = sum(known[1:], known[0]) if len(known) == len(found) else None
    if total is None or not total.any():
        return None
    if pair.is_profile:
        return Shape(LINE, (1 / float(total[1, 1]),), 90.0) if total[1, 1] else None
    (larger, smaller), angle = curvature.principal(total)
    if math.isinf(larger):
        return Shape(LINE, (smaller,), angle)
    if larger <= (1 + _ROUND) * smaller:
        return Shape(CIRCLE, (smaller,), 0.0)
    return Shape(ELLIPSE, (larger, smaller), angle)


def smooth(pair: Pair, load: float) -> Smooth | None:
    """Return Hertz's contact of the nominal bodies of a pair.

    Parameters
    ----------
    pair : Pair
        The bodies.
    load : float
        Normal load W [N]; on a line that on the length of the map.

    Returns
    -------
    Smooth or None
        None where `shape_of` gives none, without load, or for a cylinder that lies askew on the
        map, whose length the map does not tell.
    """
    shape, modulus = shape_of(pair), pair.contact_modulus
    if shape is None or not load > 0:
        return None
    if shape.kind == LINE:
        return None if shape.axis is None else _line(pair, shape, load)
    if shape.kind == CIRCLE:
        radius = shape.radii[0]
        sides: tuple[float, ...] = (hertz.contact_radius(load, radius, modulus),)
        peak = hertz.max_pressure(load, radius, modulus)
        approach = hertz.approach(load, radius, modulus)
    else:
        found = hertz.elliptic_contact(load, (shape.radii[0], shape.radii[1]), modulus)
        sides, peak, approach = found.semi_axes, found.max_pressure, found.approach
    alone = pair.boundary is Boundary.FREE
    return Smooth(shape, load, sides, None, peak, approach if alone else None)


def _line(pair: Pair, shape: Shape, load: float) -> Smooth:
    axis, radius, modulus = shape.axis, shape.radii[0], pair.contact_modulus
    assert axis is not None
    length, datum = pair.size[axis], longer_side(pair.shape, pair.pixel)
    found = hertz.line_contact(load / length, radius, modulus)
    approach = None
    # The datum of the strip, see `Boundary`.
    if pair.boundary.periodic_axes == (axis,) and datum > found.half_width:
        approach = hertz.line_approach(load / length, radius, modulus, datum)
    return Smooth(shape, load, (found.half_width,), length, found.max_pressure, approach)


def load_of(pair: Pair, shape: Shape, max_pressure: float) -> float | None:
    """Return the load at which smooth bodies have a peak pressure.

    Parameters
    ----------
    pair : Pair
        The bodies.
    shape : Shape
        As from `shape_of`.
    max_pressure : float
        Peak pressure [Pa].

    Returns
    -------
    float or None
        W [N], on a line that on the length of the map; None for a line askew on it.
    """
    modulus, radius = pair.contact_modulus, shape.radii[0]
    if shape.kind == CIRCLE:
        return hertz.load_at_pressure(max_pressure, radius, modulus)
    if shape.kind == ELLIPSE:
        return hertz.elliptic_load(max_pressure, (radius, shape.radii[1]), modulus)
    if shape.axis is None:
        return None
    return hertz.line_load(max_pressure, radius, modulus) * pair.size[shape.axis]
