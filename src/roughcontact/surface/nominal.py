"""Nominal bodies as surfaces, and bodies written as text."""

from __future__ import annotations

import math
import re
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from roughcontact import units
from roughcontact.errors import InputError, Mention
from roughcontact.surface import shapes
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, quantity

Array = NDArray[np.float64]


class Body(Protocol):
    """A nominal body that can be made on any grid, as `parse` returns it."""

    def __call__(
        self,
        *,
        shape: tuple[int, int],
        pixel: tuple[float, float],
        center: tuple[float, float] | None = None,
    ) -> Surface:
        """Return the body on a grid.

        Parameters
        ----------
        shape : (int, int)
            Grid points ``(ny, nx)``.
        pixel : (float, float)
            Pixel edges ``(dy, dx)`` [m].
        center : (float, float), optional
            Highest point ``(y, x)`` in pixels; by default the middle of the map.

        Returns
        -------
        Surface
            Heights [m], 0 at the highest point.
        """


def flat(
    *,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return a flat body.

    Parameters
    ----------
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        As for the other bodies; a flat has none.

    Returns
    -------
    Surface
        Heights 0 everywhere.

    Raises
    ------
    InputError
        As for `shapes.flat`.
    """
    edges = quantity(pixel, "length", "pixel")
    origin = Operation("nominal.flat", {"shape": shape, "pixel": edges})
    return Surface(shapes.flat(shape, edges), edges, Provenance("nominal flat", origin=origin))


def sphere(
    *,
    radius: Quantity,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return an exact sphere.

    Parameters
    ----------
    radius : float
        R [m].
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        Summit ``(y, x)`` in pixels; by default the middle of the map.

    Returns
    -------
    Surface
        Heights [m], 0 at the summit; points beyond the radius never touch.

    Raises
    ------
    InputError
        As for `shapes.sphere`.

    Examples
    --------
    >>> ball = sphere(radius=0.01, shape=(64, 64), pixel=(1e-6, 1e-6))
    >>> ball.provenance.source
    'nominal sphere of radius 10 mm'
    """
    edges = quantity(pixel, "length", "pixel")
    R = quantity(radius, "length", "radius")
    heights = shapes.sphere(shape, edges, R, center)
    return _nominal(
        "sphere",
        heights,
        f"sphere of radius {_length(R)}",
        radius=R,
        shape=shape,
        pixel=edges,
        center=center,
    )


def ellipsoid(
    *,
    radii: Quantities,
    angle: float = 0.0,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return an ellipsoid near its summit: Hertz's paraboloid with two radii of curvature.

    Parameters
    ----------
    radii : (float, float)
        Principal radii of curvature ``(R_y, R_x)`` [m] of the sections along y and along x.
    angle : float
        Angle [degrees] by which the body is turned, counter-clockwise.
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        Summit ``(y, x)`` in pixels; by default the middle of the map.

    Returns
    -------
    Surface
        Heights [m], 0 at the summit.

    Raises
    ------
    InputError
        As for `shapes.ellipsoid`.
    """
    edges = quantity(pixel, "length", "pixel")
    both = quantity(radii, "length", "radii")
    heights = shapes.ellipsoid(shape, edges, both, angle, center)
    name = (
        f"ellipsoid of the radii of curvature {_length(both[0])} along y and "
        f"{_length(both[1])} along x"
    )
    if angle:
        name += f", turned by {angle:g} degrees counter-clockwise"
    return _nominal(
        "ellipsoid",
        heights,
        name,
        radii=both,
        angle=angle,
        shape=shape,
        pixel=edges,
        center=center,
    )


def cylinder(
    *,
    radius: Quantity,
    angle: float = 0.0,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return an exact lying cylinder; one on each body gives crossed or parallel cylinders.

    Parameters
    ----------
    radius : float
        R [m].
    angle : float
        Angle [degrees] of the axis, counter-clockwise from x: 0 lies along x, 90 along y.
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        A point ``(y, x)`` under the axis in pixels; by default the middle of the map.

    Returns
    -------
    Surface
        Heights [m], 0 on the highest line; points beyond the radius never touch.

    Raises
    ------
    InputError
        As for `shapes.cylinder`.
    """
    edges = quantity(pixel, "length", "pixel")
    R = quantity(radius, "length", "radius")
    heights = shapes.cylinder(shape, edges, R, angle, center)
    name = f"cylinder of radius {_length(R)}, axis at {angle:g} degrees counter-clockwise from x"
    return _nominal(
        "cylinder",
        heights,
        name,
        radius=R,
        angle=angle,
        shape=shape,
        pixel=edges,
        center=center,
    )


def punch(
    *,
    radius: Quantity,
    edge_radius: Quantity = 0.0,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return a flat-ended round punch.

    Parameters
    ----------
    radius : float
        Outer radius [m].
    edge_radius : float
        Radius of the rounded edge [m], inside the outer radius.
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        Axis ``(y, x)`` in pixels; by default the middle of the map.

    Returns
    -------
    Surface
        Heights [m], 0 on the flat; points outside never touch.

    Raises
    ------
    InputError
        As for `shapes.punch`.
    """
    edges = quantity(pixel, "length", "pixel")
    R = quantity(radius, "length", "radius")
    rho = quantity(edge_radius, "length", "edge_radius")
    heights = shapes.punch(shape, edges, R, rho, center)
    name = f"round punch of radius {_length(R)}{_edge(rho)}"
    return _nominal(
        "punch",
        heights,
        name,
        radius=R,
        edge_radius=rho,
        shape=shape,
        pixel=edges,
        center=center,
    )


def rectangular_punch(
    *,
    sides: Quantities,
    edge_radius: Quantity = 0.0,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return a flat-ended punch with sides along y and x.

    Parameters
    ----------
    sides : (float, float)
        Full outer sides ``(l_y, l_x)`` [m].
    edge_radius : float
        Radius of the rounded edges [m], inside the outer sides.
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        Axis ``(y, x)`` in pixels; by default the middle of the map.

    Returns
    -------
    Surface
        Heights [m], 0 on the flat; points outside never touch.

    Raises
    ------
    InputError
        As for `shapes.rectangular_punch`.
    """
    edges = quantity(pixel, "length", "pixel")
    rho = quantity(edge_radius, "length", "edge_radius")
    both = quantity(sides, "length", "sides")
    heights = shapes.rectangular_punch(shape, edges, both, rho, center)
    name = (
        f"rectangular punch of {_length(both[0])} along y by {_length(both[1])} along x{_edge(rho)}"
    )
    return _nominal(
        "rectangular_punch",
        heights,
        name,
        sides=both,
        edge_radius=rho,
        shape=shape,
        pixel=edges,
        center=center,
    )


def cone(
    *,
    slope: float,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return a cone.

    Parameters
    ----------
    slope : float
        Slope of the flank: the cotangent of the half-angle at the tip.
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        Tip ``(y, x)`` in pixels; by default the middle of the map.

    Returns
    -------
    Surface
        Heights [m], 0 at the tip.

    Raises
    ------
    InputError
        As for `shapes.cone`.
    """
    edges = quantity(pixel, "length", "pixel")
    heights = shapes.cone(shape, edges, slope, center)
    return _nominal(
        "cone",
        heights,
        f"cone of slope {slope:g}",
        slope=slope,
        shape=shape,
        pixel=edges,
        center=center,
    )


def wedge(
    *,
    slope: float,
    angle: float = 0.0,
    shape: tuple[int, int],
    pixel: Quantities,
    center: tuple[float, float] | None = None,
) -> Surface:
    """Return a symmetric wedge.

    Parameters
    ----------
    slope : float
        Slope of both faces: the cotangent of half the angle at the ridge.
    angle : float
        Angle [degrees] of the ridge, counter-clockwise from x: 0 lies along x, 90 along y.
    shape, pixel : (int, int), (float, float)
        Points ``(ny, nx)`` and pixel edges ``(dy, dx)`` [m] of the grid.
    center : (float, float), optional
        A point ``(y, x)`` of the ridge in pixels; by default the middle of the map.

    Returns
    -------
    Surface
        Heights [m], 0 on the ridge.

    Raises
    ------
    InputError
        As for `shapes.wedge`.
    """
    edges = quantity(pixel, "length", "pixel")
    heights = shapes.wedge(shape, edges, slope, angle, center)
    name = f"wedge of slope {slope:g}, ridge at {angle:g} degrees counter-clockwise from x"
    return _nominal(
        "wedge", heights, name, slope=slope, angle=angle, shape=shape, pixel=edges, center=center
    )


FORMS = (
    "flat",
    "sphere 10 mm",
    "ellipsoid 10 mm 4 mm 30 deg",
    "cylinder 5 mm 90 deg",
    "punch 20 um",
    "punch 20 um 10 um",
    "punch 20 um edge 2 um",
    "cone 0.01",
    "wedge 0.01 90 deg",
)
"""Every form that `parse` takes, by example."""


def parse(text: str, name: str = "body") -> Body:
    """Return the nominal body that a text describes.

    Parameters
    ----------
    text : str
        Name and sizes, as in `FORMS`: the radius of a sphere, of a cylinder or of a round punch;
        the two radii of curvature of an ellipsoid or the two full sides of a rectangular punch,
        along y first; ``edge`` and the radius of a punch's edge; the slope of a cone or a wedge.
        Lengths have a unit. An angle in ``deg``, counter-clockwise, may follow where the body has
        a direction: it turns an ellipsoid, or is that of the axis or the ridge, from x.
    name : str
        The argument that it is given for, which errors carry.

    Returns
    -------
    Body
        To be called with ``shape`` and ``pixel``, and ``center`` if the body does not stand in
        the middle.

    Raises
    ------
    InputError
        If the text describes no body, or a size is not positive.

    Examples
    --------
    >>> ball = parse("sphere 10 mm")(shape=(64, 64), pixel=(1e-6, 1e-6))
    >>> ball.provenance.source
    'nominal sphere of radius 10 mm'
    """
    examples = ", ".join(repr(form) for form in FORMS)
    wrong = InputError(f"must read like one of {examples}, got {text!r}", argument=name, value=text)
    if not isinstance(text, str) or not text.strip():
        raise wrong
    word, *rest = text.split()
    body, sizes, angle, edge = _taken_apart(word.lower(), " ".join(rest))
    rho = 0.0
    if edge is not None:
        rho = _measured(edge, name, "the edge radius of the punch")
    parts = _QUANTITY.findall(sizes)
    if "".join(parts).replace(" ", "") != sizes.replace(" ", "") or not math.isfinite(angle):
        raise wrong

    def lengths(what: str) -> list[float]:
        return [_measured(part, name, f"{what} of the {body}") for part in parts]

    match body, len(parts):
        case "flat", 0:
            return flat
        case "sphere", 1:
            return partial(sphere, radius=lengths("the radius")[0])
        case "cylinder", 1:
            return partial(cylinder, radius=lengths("the radius")[0], angle=angle)
        case "ellipsoid", 2:
            along_y, along_x = lengths("each radius of curvature")
            return partial(ellipsoid, radii=(along_y, along_x), angle=angle)
        case "punch", 1:
            return partial(punch, radius=lengths("the radius")[0], edge_radius=rho)
        case "punch", 2:
            along_y, along_x = lengths("each side")
            return partial(rectangular_punch, sides=(along_y, along_x), edge_radius=rho)
        case "cone", 1:
            return partial(cone, slope=_slope(parts[0], name, "the slope of the cone"))
        case "wedge", 1:
            slope = _slope(parts[0], name, "the slope of the wedge")
            return partial(wedge, slope=slope, angle=angle)
    raise wrong


def across(body: Body) -> Body:
    """Return a body of `parse` as the profile across it has it.

    Parameters
    ----------
    body : Body
        Flat, or a cylinder or wedge along y, which they take if no angle is given.

    Raises
    ------
    InputError
        If it is another, or lies in another direction.
    """
    if body is flat:
        return body
    if isinstance(body, partial) and body.func in (cylinder, wedge):
        if body.keywords["angle"] in (0.0, 90.0):
            return partial(body.func, **{**body.keywords, "angle": 90.0})
    raise InputError(
        "a profile takes 'flat', a cylinder such as 'cylinder 5 mm' or a wedge such as 'wedge "
        "0.01', which go on alike across it"
    )


def _measured(text: str, name: str, what: str) -> float:
    try:
        return units.parse(text, "length", what)
    except InputError as error:
        own = () if error.argument is None else (Mention(error.argument), " ")
        raise InputError(Mention(name), ": ", *own, *error.parts, value=text) from None


_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"{_NUMBER}(?:\s*[A-Za-z\u00b5\u03bcÅ]+)?")
_ANGLE = re.compile(rf"\s+({_NUMBER})\s*(?:deg|degrees?|°)$")
_EDGE = re.compile(r"\s*\bedge\b\s*(.*)$")


def _taken_apart(body: str, sizes: str) -> tuple[str, str, float, str | None]:
    """Return a body, its sizes, and apart from these its angle and what is said of its edge."""
    angle, edge = 0.0, None
    if body in ("ellipsoid", "cylinder", "wedge") and (found := _ANGLE.search(sizes)):
        sizes, angle = sizes[: found.start()], float(found[1])
    if body == "punch" and (found := _EDGE.search(sizes)):
        sizes, edge = sizes[: found.start()], found[1]
    return body, sizes, angle, edge


def _nominal(method: str, heights: Array, name: str, **given: Any) -> Surface:
    beyond = int(np.count_nonzero(np.isnan(heights)))
    origin = Operation(f"nominal.{method}", given, {"outside": beyond})
    about = Provenance(f"nominal {name}", origin=origin)
    return Surface(heights, given["pixel"], about, holes_masked=beyond > 0)


def _slope(text: str, name: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(
            Mention(name), f": {what} must be a number without a unit, got {text!r}", value=text
        ) from None
    if not 0 < value < math.inf:
        raise InputError(
            Mention(name), f": {what} must be positive and finite, got {text!r}", value=text
        )
    return value


def _length(value: float) -> str:
    return units.engineering(value, "m", 6)


def _edge(edge_radius: float) -> str:
    return f" with an edge radius of {_length(edge_radius)}" if edge_radius else ""
