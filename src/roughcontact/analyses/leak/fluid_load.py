"""Load that the pressure of a fluid carries between two bodies in contact.

The fluid presses on both bodies where they are in nominal contact, and the solids carry the rest of
the load there. Beyond it the fluid presses on free faces, whose extent no map shows: this thrust
belongs to the clamping force. Without a nominal body the whole map is in nominal contact.

The bodies deform under the sum of the pressures of contact and fluid, p_s + p_f, and its integral
over the nominal contact is the load (Kuznetsov 1985, Wear 102, 177). p_f follows from Reynolds'
equation in the gap, in turn with the contact. Along a periodic axis the map is a short sample of
the land, under its mean pressure; a uniform pressure on a map that is periodic along both axes
deforms nothing, and only reduces the load.

Pressure and load of a contact solved so are those of the solids; its gap is that of the bodies
under both pressures.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.analyses.leak.flow import Flow, components, flow, flow_gap
from roughcontact.contact.ceiling import resolve_ceiling
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.nominal_hertz import (
    SmoothContact,
    has_nominal_body,
    is_nominal_origin,
    relative_curvature,
    solve_smooth,
)
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import CALIBRATED, ContactResult
from roughcontact.contact.solve import solve_pair
from roughcontact.errors import ConvergenceError, InputError
from roughcontact.halfspace.fft import Workspace
from roughcontact.surface.form import level
from roughcontact.surface.surface import Surface
from roughcontact.units import format_engineering

Excess = Callable[[Array], Array]
"""Excess over the outlet pressure [Pa], of the potential of the flow: 1 at the inlet, 0 outside."""

# Certificate of the contact of the smooth forms: its area is known to a pixel.
_SMOOTH_TOLERANCE = 1e-3

# Change of the fluid pressure, integrated, over the load, at which the iteration ends.
_FIELD_TOLERANCE = 1e-3

_MAX_ITERATIONS = 30

# Pixels over a periodic seam among which the nearest open point is searched.
_SEAM = 32


def nominal_contact(pair: Pair, load: float, ceiling: Any) -> Array | None:
    """Return the part of each pixel in nominal contact, 0 to 1; None without a nominal body.

    Hertz's contact of the nominal bodies, on the mean plane of the roughness; where it has no
    closed form or exceeds the ceiling, the contact of the smooth forms, solved on the grid.
    """
    if not has_nominal_body(pair.origins):
        return None
    curvature = relative_curvature(pair.origins)
    ceiling = "auto" if isinstance(ceiling, str) and ceiling == CALIBRATED else ceiling
    form = _form_heights(pair) if curvature is None else _paraboloid(pair, curvature)
    rough = pair.heights - form
    plane = rough - level(rough)
    hertz = solve_smooth(pair, load)
    limit = resolve_ceiling(ceiling, pair)
    if curvature is None or hertz is None or np.min(limit or math.inf) < hertz.max_pressure:
        smooth = Surface(form + plane, pair.pixel, holes_masked=True)
        terms = LoadCase(load, ceiling=ceiling, tolerance=_SMOOTH_TOLERANCE)
        bodies = replace(pair, surface=smooth, counter_surface=None)
        return solve_pair(bodies, terms, on_failure="return").contact.astype(float)
    slope = [
        float(np.nanmean(np.diff(plane, axis=axis))) / edge for axis, edge in enumerate(pair.pixel)
    ]
    return _covered_part(pair, hertz, curvature, np.linalg.pinv(curvature) @ slope)


def _covered_part(pair: Pair, hertz: SmoothContact, curvature: Array, center: Array) -> Array:
    """Return the part of each pixel within the ellipse or strip of a smooth contact."""
    longer = math.inf if hertz.length is not None else hertz.semi_axes[0]
    _, directions = np.linalg.eigh(curvature)
    y, x = (place - at for place, at in zip(_places(pair), center, strict=True))
    radius = np.hypot(
        (directions[0, 0] * y + directions[1, 0] * x) / longer,
        (directions[0, 1] * y + directions[1, 1] * x) / hertz.semi_axes[-1],
    )
    with np.errstate(divide="ignore"):
        part: Array = np.clip((1 - radius) / np.hypot(*np.gradient(radius)) + 0.5, 0, 1)
    return part


def _places(pair: Pair) -> tuple[Array, Array]:
    """Return y as a column and x as a row, from the center of the map [m]."""
    y, x = (
        (np.arange(points, dtype=float) - (points - 1) / 2) * edge
        for points, edge in zip(pair.shape, pair.pixel, strict=True)
    )
    return y[:, None], x


def _paraboloid(pair: Pair, curvature: Array) -> Array:
    y, x = _places(pair)
    heights: Array = -(curvature[0, 0] * y**2 + curvature[1, 1] * x**2) / 2
    return heights - curvature[0, 1] * y * x


def _form_heights(pair: Pair) -> Array:
    """Return the heights of the nominal bodies that have no curvature [m]."""
    forms = [body.heights for body in _bodies(pair) if is_nominal_origin(body.provenance)]
    return sum(forms[1:], forms[0])


def _bodies(pair: Pair) -> list[Surface]:
    return [body for body in (pair.surface, pair.counter_surface) if body is not None]


def fluid_potential(gap: Array, solved: Flow, periodic_axes: tuple[int, ...]) -> Array:
    """Return the potential of the flow on the whole map: 1 at the inlet, 0 at the outlet.

    A pool has the potential of the side that it is open to; closed points have that of the nearest
    open one, as the fluid around a spot presses on its surroundings.
    """
    potential = solved.pressure.astype(np.float64)
    label = components(gap > 0, periodic_axes)
    for side, value in ((0, 1.0), (-1, 0.0)):
        ends = np.unique(label.take(side, solved.axis))
        potential[np.isnan(potential) & (label > 0) & np.isin(label, ends)] = value
    return _fill_from_nearest(potential, periodic_axes)


def _fill_from_nearest(values: Array, periodic_axes: tuple[int, ...]) -> Array:
    """Return values with each NaN replaced by the nearest number; 0 where there is none."""
    from scipy import ndimage

    if np.isnan(values).all():
        return np.zeros_like(values)
    margins = [
        (min(_SEAM, points) if axis in periodic_axes else 0,) * 2
        for axis, points in enumerate(values.shape)
    ]
    padded = np.pad(values, margins, mode="wrap")
    nearest = ndimage.distance_transform_edt(
        np.isnan(padded), return_distances=False, return_indices=True
    )
    inner = tuple(
        slice(margin, margin + points)
        for (margin, _), points in zip(margins, values.shape, strict=True)
    )
    return padded[tuple(nearest)][inner]


def fluid_pressure(
    result: ContactResult, solved: Flow, mean: float, excess: Excess, contact: Array | None
) -> Array:
    """Return the pressure of the fluid within the nominal contact [Pa], shape (ny, nx)."""
    periodic_axes = result.boundary.periodic_axes
    if solved.axis in periodic_axes:
        pressure = np.full(result.pressure.shape, mean)
    else:
        pressure = excess(fluid_potential(flow_gap(result), solved, periodic_axes))
    return pressure if contact is None else pressure * contact


def integrate_pressure(pressure: Array, pair: Pair) -> float:
    """Return the force of a pressure on the map [N]."""
    # The mean of equal numbers has an error of rounding.
    mean = pressure.mean() if np.ptp(pressure) else pressure[0, 0]
    return float(mean * pair.size[0] * pair.size[1])


def solve_with_fluid(
    solve: Callable[..., ContactResult], axis: int, mean: float, excess: Excess
) -> Callable[..., ContactResult]:
    """Return a function that solves contacts as ``solve``, with the fluid pressure in their gap."""

    def solve_wet(surface: Surface, *, load: float, **arguments: Any) -> ContactResult:
        bodies = ("material", "counter_surface", "counter_material", "boundary")
        pair = Pair.from_arguments(surface, *(arguments[name] for name in bodies))
        periodic_axes = pair.boundary.periodic_axes
        contact = nominal_contact(pair, load, arguments["ceiling"])
        pressure = np.full(pair.shape, mean)
        if contact is not None:
            pressure *= contact
        for _ in range(_MAX_ITERATIONS):
            result = _solve_under(solve, pair, pressure, load, arguments)
            if axis in periodic_axes:
                return result
            solved = flow(flow_gap(result), pair.pixel, axis, periodic_axes)
            after = fluid_pressure(result, solved, mean, excess, contact)
            change, pressure = integrate_pressure(np.abs(after - pressure), pair), after
            if change <= _FIELD_TOLERANCE * load:
                return result
        raise ConvergenceError(
            f"gap and fluid pressure do not settle in {_MAX_ITERATIONS} iterations: the fluid "
            "carries nearly the whole load",
            None,
        )

    return solve_wet


def _solve_under(
    solve: Callable[..., ContactResult],
    pair: Pair,
    pressure: Array,
    load: float,
    arguments: dict[str, Any],
) -> ContactResult:
    """Return the contact of two bodies under a given pressure of the fluid."""
    carried = integrate_pressure(pressure, pair)
    require_solid_load(carried, load)
    surface = pair.surface
    if np.ptp(pressure) or len(pair.boundary.periodic_axes) < 2:
        displacement = pair.operators("double", Workspace())(pair.shape, (1, 1))(pressure)
        surface = replace(surface, heights=surface.heights - displacement)
    result = solve(surface, **arguments, load=load - carried)
    return replace(result, pair=pair, fluid_load=load - result.load)


def require_solid_load(carried: float, load: float) -> None:
    """Raise `InputError` if the fluid carries the whole load [N]."""
    if carried >= load:
        raise InputError(
            f"is too small: the pressure of the fluid in the contact carries "
            f"{format_engineering(carried, 'N', 3)} and lifts the bodies",
            argument="load",
        )
