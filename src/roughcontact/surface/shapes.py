"""Heights of analytical shapes: indenters and waves.

Heights [m] are positive out of the material, ``heights[y, x]``; pairs are ``(y, x)``. Angles are
counter-clockwise as a map is printed and drawn, row 0 on top.

`ellipsoid`: The elliptic paraboloid of Hertz's theory: two radii of curvature do not determine an
ellipsoid, whose third axis is free. The neglected part is of the order of ``r⁴/(8R³)``, a fraction
(r/2R)² of the height at r.

Johnson, Contact Mechanics (1985), sec. 4.1, doi:10.1017/CBO9781139171731

`punch`: A pixel is under the punch if its center is: the area is accurate to about a pixel along
the rim.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import wraps
from numbers import Real
from typing import Any

import numpy as np

from roughcontact._tools import memory
from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.errors import InputError, input_error, require_pixel, require_positive
from roughcontact.surface import grid
from roughcontact.surface.alignment import cosine_sine


def flat(shape: Shape, pixel: Pixel) -> Array:
    """Return the heights of a flat."""
    require_grid(shape, pixel)
    return np.zeros(shape)


def _body(heights: Callable[..., Array]) -> Callable[..., Array]:
    """Return the heights of a body as function of a grid, sizes and ``center`` [pixels].

    The heights are a function of the positions y and x from the center [m] and of the sizes.
    """

    @wraps(heights)
    def sample(
        shape: Shape,
        pixel: Pixel,
        *sizes: Any,
        center: tuple[float, float] | None = None,
        **options: Any,
    ) -> Array:
        result = heights(*_from_center(shape, pixel, center), *sizes, **options)
        if np.isnan(result).all():
            raise InputError(
                f"no point of the grid is under the {heights.__name__.rpartition('_')[2]}: check "
                "its size and center against the pixel"
            )
        return result

    return sample


@_body
def paraboloid(y: Array, x: Array, radius: float) -> Array:
    """Return the heights ``-r²/(2R)`` of a paraboloid, a sphere near its summit."""
    require_positive(radius=radius)
    return -(y**2 + x**2) / (2 * radius)


@_body
def sphere(y: Array, x: Array, radius: float) -> Array:
    """Return the heights ``(R² - r²)^(1/2) - R`` of a sphere; negative R is a hollow."""
    _require_radii(radius=radius)
    return _arc(y**2 + x**2, radius)


@_body
def ellipsoid(y: Array, x: Array, radii: tuple[float, float], angle: float = 0.0) -> Array:
    """Return the heights ``-y²/(2R_y) - x²/(2R_x)`` of an ellipsoid; negative R is concave."""
    radius_y, radius_x = _pair("radii", radii, _require_radii)
    along, across = _rotate_positions(y, x, angle)
    return -(across**2 / (2 * radius_y) + along**2 / (2 * radius_x))


@_body
def cylinder(y: Array, x: Array, radius: float, angle: float = 0.0) -> Array:
    """Return the heights ``(R² - d²)^(1/2) - R`` of a cylinder; negative R is a groove."""
    _require_radii(radius=radius)
    return _arc(_rotate_positions(y, x, angle)[1] ** 2, radius)


@_body
def punch(y: Array, x: Array, radius: float, edge_radius: float = 0.0) -> Array:
    """Return the heights of a flat-ended round punch."""
    require_positive(radius=radius)
    flat = radius - _checked_edge(edge_radius, radius)
    return _round_edge(np.hypot(y, x) - flat, edge_radius, radius)


@_body
def rectangular_punch(
    y: Array, x: Array, sides: tuple[float, float], edge_radius: float = 0.0
) -> Array:
    """Return the heights of a flat-ended punch with sides along y and x."""
    half_y, half_x = (side / 2 for side in _pair("sides", sides))
    rho = _checked_edge(edge_radius, min(half_y, half_x))
    beyond_y, beyond_x = np.abs(y) - (half_y - rho), np.abs(x) - (half_x - rho)
    beyond = np.hypot(np.maximum(beyond_y, 0), np.maximum(beyond_x, 0))
    return _round_edge(beyond, edge_radius, max(half_y, half_x))


@_body
def cone(y: Array, x: Array, slope: float) -> Array:
    """Return the heights ``-m r`` of a cone."""
    require_positive(slope=slope)
    return -slope * np.hypot(y, x)


@_body
def wedge(y: Array, x: Array, slope: float, angle: float = 0.0) -> Array:
    """Return the heights ``-m d`` of a symmetric wedge, d from its ridge."""
    require_positive(slope=slope)
    return -slope * np.abs(_rotate_positions(y, x, angle)[1])


def wavy(shape: Shape, pixel: Pixel, amplitude: float, wavelength: float) -> Array:
    """Return waves along x, ``Δ cos(2πx/λ)``, with a crest at the first column."""
    require_grid(shape, pixel)
    require_positive(amplitude=amplitude, wavelength=wavelength)
    return np.tile(amplitude * _wave(shape[1], pixel[1], wavelength), (shape[0], 1))


def crossed_waves(shape: Shape, pixel: Pixel, amplitude: float, wavelength: float) -> Array:
    """Return waves along both axes, ``Δ cos(2πx/λ) cos(2πy/λ)``, crest at the first pixel."""
    require_grid(shape, pixel)
    require_positive(amplitude=amplitude, wavelength=wavelength)
    along_y, along_x = (_wave(n, d, wavelength) for n, d in zip(shape, pixel, strict=True))
    return amplitude * along_y[:, None] * along_x


_SLACK = 1e-9


def _wave(points: int, pixel: float, wavelength: float) -> Array:
    return np.cos(2 * math.pi * pixel / wavelength * np.arange(points))


def _from_center(
    shape: Shape, pixel: Pixel, center: tuple[float, float] | None
) -> tuple[Array, Array]:
    # Positions [m] of rows, as a column, and of columns.
    require_grid(shape, pixel)
    middle = ((shape[0] - 1) / 2, (shape[1] - 1) / 2)
    try:
        cy, cx = (float(c) for c in (middle if center is None else center))
    except (TypeError, ValueError):
        raise input_error("center", center, "must be a pair (y, x) in pixels") from None
    if not (math.isfinite(cy) and math.isfinite(cx)):
        raise input_error("center", center, "must be finite (y, x)")
    y: Array = pixel[0] * (np.arange(shape[0], dtype=np.float64) - cy)
    x: Array = pixel[1] * (np.arange(shape[1], dtype=np.float64) - cx)
    return y[:, None], x


def _rotate_positions(y: Array, x: Array, angle: float) -> tuple[Array, Array]:
    # Positions along and across a direction at the angle from x, counter-clockwise: y points down.
    c, s = cosine_sine(angle)
    along: Array = c * x - s * y
    across: Array = c * y + s * x
    return along, across


def _require_radii(**radii: float) -> None:
    """Raise an error unless radii of curvature are finite and not zero."""
    for name, radius in radii.items():
        if not isinstance(radius, Real) or radius == 0 or not math.isfinite(radius):
            raise input_error(name, radius, "must be finite and not zero; negative is concave")


def _pair(
    name: str, values: tuple[float, float], require: Callable[..., None] = require_positive
) -> tuple[float, float]:
    try:
        along_y, along_x = values
    except (TypeError, ValueError):
        raise input_error(name, values, "must be a pair (y, x) in meters") from None
    require(**{f"{name}[0]": along_y, f"{name}[1]": along_x})
    return along_y, along_x


def _checked_edge(edge_radius: float, largest: float) -> float:
    if not isinstance(edge_radius, Real) or not 0 <= edge_radius <= largest:
        raise input_error(
            "edge_radius",
            edge_radius,
            f"must be between 0 and {largest:g} m, which rounds the whole punch",
        )
    return float(edge_radius)


def _arc(square: Array, radius: float) -> Array:
    # Height of a circle over the square of the distance from its summit, without cancellation;
    # below a tangent for a positive radius, above for a negative one.
    with np.errstate(invalid="ignore"):
        root = np.copysign(np.sqrt(radius**2 - square), radius)
    return -square / (radius + root)


def _round_edge(beyond: Array, edge_radius: float, size: float) -> Array:
    # Height over the distance from the flat; the slack accepts rounding on the outline.
    distance = np.maximum(beyond, 0)
    outside = distance > edge_radius + _SLACK * size
    if edge_radius == 0:
        return np.where(outside, np.nan, 0.0)
    return np.where(outside, np.nan, _arc(np.minimum(distance, edge_radius) ** 2, edge_radius))


def require_grid(shape: Shape, pixel: Pixel, maps: int = grid.SAMPLED_ARRAYS) -> None:
    """Raise an error unless grid and pixel edges are positive and the maps fit in memory."""
    if len(shape) != 2 or min(shape) < 1:
        raise input_error("shape", shape, "must be (ny, nx), both at least 1")
    memory.require_grid("shape", shape)
    require_pixel(pixel)
    grid.require_memory(shape, maps)
