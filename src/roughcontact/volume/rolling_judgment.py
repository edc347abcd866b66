"""What repeated passes are judged by besides their last state: their steps, pixel and direction."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.cautions import Caution, Kind, careful, warned
from roughcontact.errors import Mention
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering
from roughcontact.volume.result import ElastoplasticResult

LONG_STEP, LONGEST_STEP = 0.5, 1.0
"""Step over the half-width of the contact from which strains are too small, and nothing is told.

A roller at 4.5 k, which ratchets: a pass leaves 24 % less strain with steps of 0.5 than with steps
of 0.25, 39 % less with 0.67 and 89 % less with 1; with 2.7 the dents lie apart, and it seems to
shake down.
"""

FEW_PIXELS = 4
"""Pixels to the half-width below which what a pass leaves depends on the grid.

The same roller with steps of 0.5: 16 and 8 pixels agree to 1 %, 4 leave 11 % less strain, 3 leave
17 % less and 2 leave 75 % less.
"""

_FINE_STEP = 0.25
# Angle between the axis of a roller and its way up to which it slides along it [degrees].
_ALONG = 5.0


def axis_of(counter_surface: Surface) -> float | None:
    """Return where the axis of a nominal cylinder lies [degrees], ``None`` for other bodies.

    Parameters
    ----------
    counter_surface : Surface
        Heights of the counter-body, which forget their form once they have moved.
    """
    made = counter_surface.provenance.origin
    if made is None or made.method != "nominal.cylinder" or counter_surface.provenance.operations:
        return None
    return float(made.arguments["angle"])


def half_width(result: ElastoplasticResult, direction: float) -> float:
    """Return half the length of the contact along a direction.

    Parameters
    ----------
    result : ElastoplasticResult
        A state under load.
    direction : float
        In degrees from x, counter-clockwise.

    Returns
    -------
    float
        Of the patch as a whole [m], gaps between its spots included; infinite where it goes round
        a period, and without contact.
    """
    solution = result.solution
    touching, found = solution.contact, np.nonzero(solution.contact)
    if not touching.any():
        return math.inf
    along = np.zeros(found[0].size)
    for axis, share in enumerate(_shares(direction)):
        at = found[axis]
        used: NDArray[np.bool_] = np.any(touching, axis=1 - axis)
        if axis in solution.boundary.periodic_axes:
            if share and used.all():
                return math.inf
            at = (at - _begin(used)) % used.size
        along += share * solution.surface.pixel[axis] * at
    return (float(np.ptp(along)) + _pixel(result, direction)) / 2


def too_long(result: ElastoplasticResult, step: float, direction: float) -> bool:
    """Return whether the dents of neighbouring places of a pass may lie apart.

    Parameters
    ----------
    result : ElastoplasticResult
        The state at the end of the last pass.
    step : float
        Distance between the places of a pass [m]. One pixel is never too long.
    direction : float
        Of the passes [degrees].
    """
    return _stride(result, step, direction) > LONGEST_STEP


def cautions(
    result: ElastoplasticResult, step: float, count: int, direction: float, axis: float | None
) -> Iterator[Caution]:
    """Yield what a reader of passes has to know of their steps, grid and direction.

    Parameters
    ----------
    result : ElastoplasticResult
        The state at the end of the last pass.
    step, count : float, int
        Distance between the places of a pass [m], and how many they are.
    direction : float
        Of the passes [degrees].
    axis : float or None
        Where the axis of a cylinder lies [degrees].
    """
    if axis is not None and abs((axis - direction + 90) % 180 - 90) <= _ALONG:
        yield _slides(axis, direction)
        return
    half = half_width(result, direction)
    stride = _stride(result, step, direction)
    if stride > LONG_STEP:
        yield _coarse(stride, half, math.ceil(count * stride / _FINE_STEP - 1e-9))
    pixels = half / _pixel(result, direction)
    if pixels < FEW_PIXELS:
        yield warned(
            Kind.RESOLUTION,
            f"the half-width of the contact along the way, {engineering(half, 'm', 3)}, has only "
            f"{pixels:.2g} pixels: what a pass adds depends on the pixel; take at least "
            f"{FEW_PIXELS}, for numbers sixteen",
            pixels=pixels,
        )


def _coarse(stride: float, half: float, steps: int) -> Caution:
    """Return what is said of steps of so many half-widths."""
    judged = warned if stride > LONGEST_STEP else careful
    outcome = (
        "dents may lie apart, each of which bears the counter-body by itself"
        if stride > LONGEST_STEP
        else "strain by a pass comes out too small"
    )
    return judged(
        Kind.WAY,
        f"the steps of a pass are {stride:.2g} times the half-width of the contact along the way, "
        f"{engineering(half, 'm', 3)}: {outcome}; take steps of a quarter of it, ",
        Mention("steps", steps),
        step_over_half_width=stride,
        half_width=half,
    )


def _slides(axis: float, direction: float) -> Caution:
    """Return what is said of a cylinder that goes where its axis points."""
    across = f"{(direction + 90) % 180:g}"
    return warned(
        Kind.AXIS,
        f"the cylinder moves along its axis, which lies at {axis:g} degrees: it slides on one line "
        f"and rolls over nothing; let its axis lie across, as in 'cylinder 2 mm {across} deg', or "
        "give ",
        Mention("direction", (axis + 90) % 180),
        axis=axis,
        direction=direction,
    )


def _stride(result: ElastoplasticResult, step: float, direction: float) -> float:
    """Return a step over the half-width; 0 for one of a pixel, which passes over no point."""
    if step <= (1 + 1e-9) * _pixel(result, direction):
        return 0.0
    return step / half_width(result, direction)


def _shares(direction: float) -> tuple[float, float]:
    """Return the parts of a direction along y and x; a right angle has a cosine of 6e-17."""
    angle = math.radians(direction)
    return round(math.sin(angle), 15), round(math.cos(angle), 15)


def _pixel(result: ElastoplasticResult, direction: float) -> float:
    """Return the length of a pixel along a direction [m]."""
    edges = zip(_shares(direction), result.solution.surface.pixel, strict=True)
    return sum(abs(share) * edge for share, edge in edges)


def _begin(used: NDArray[np.bool_]) -> int:
    """Return the first index behind the longest gap round a period."""
    index = np.flatnonzero(used)
    gaps = np.diff(index, append=index[0] + used.size)
    return int(index[(gaps.argmax() + 1) % index.size])
