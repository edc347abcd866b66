"""Comparison of a rough contact with the Hertz contact of its nominal bodies.

`ContactResult.hertz` applies to smooth, elastic bodies with a single contact that is small compared
with their radii.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.cautions import (
    Caution,
    CautionTag,
    as_caution,
    as_note,
    as_warning,
    sort_cautions,
)
from roughcontact.contact.load_case import HertzPressure, LineLoad
from roughcontact.contact.nominal_hertz import (
    CIRCLE,
    ELLIPSE,
    LINE,
    SmoothContact,
    has_nominal_body,
    is_nominal_origin,
    is_smooth,
    relative_curvature,
)
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import MIN_SPOT_PIXELS
from roughcontact.errors import ArgumentRef
from roughcontact.surface.form import level
from roughcontact.units import format_engineering

SMALL_FRACTION = 0.1
"""Ratio of contact size to radius of curvature up to which a paraboloid represents a body."""

FAR_RATIO = 4.0
"""Ratio of period to contact size from which periodic images hardly interact."""

# Curvature of a measured map over that of the nominal bodies from which it matters.
_MIN_CURVATURE = 0.1

# Second moment of Hertz's pressure along a semi-axis, relative to its square.
_MOMENTS = {CIRCLE: 1 / 5, ELLIPSE: 1 / 5, LINE: 1 / 4}
_AXES = ("y", "x")


def equivalent_hertz_size(result: ContactResult) -> tuple[float, ...]:
    """Return the size of the smooth contact with the same spread of pressure as a result."""
    smooth = _smooth_limits(result)
    along, across = contact_axes(smooth)
    weight = result.pressure / result.pressure.sum()
    y, x = distances_from(result, result.center_of_pressure)

    def moment(direction: tuple[float, float]) -> float:
        dy, dx = result.surface.pixel
        cy, cx = direction
        within = ((cy * dy) ** 2 + (cx * dx) ** 2) / 12
        return float((weight * (cy * y + cx * x) ** 2).sum()) + within

    factor = 1 / _MOMENTS[smooth.shape.kind]
    if smooth.shape.kind == LINE:
        return (math.sqrt(factor * moment(across)),)
    if smooth.shape.kind == CIRCLE:
        return (math.sqrt(factor * (moment(along) + moment(across)) / 2),)
    return tuple(math.sqrt(factor * moment(direction)) for direction in (along, across))


def contact_axes(smooth: SmoothContact) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the unit vectors (y, x) along and across a smooth contact; y points down."""
    angle = math.radians(smooth.shape.angle)
    c, s = math.cos(angle), math.sin(angle)
    return (-s, c), (c, s)


def distances_from(result: ContactResult, middle: tuple[float, float]) -> tuple[Array, Array]:
    """Return distances of rows, as a column, and of columns from a point of the map [m]."""
    y, x = (
        (np.arange(points) - (points - 1) / 2) * edge - index
        for points, edge, index in zip(
            result.pressure.shape, result.surface.pixel, middle, strict=True
        )
    )
    return y[:, None], x


def comparison_limits(result: ContactResult) -> tuple[Caution, ...]:
    """Return the differences, except roughness, between a contact and the Hertz contact."""
    smooth = _smooth_limits(result)
    return sort_cautions(
        [
            *_within_map(result, smooth),
            *_line_end_note(result),
            *_size_note(smooth),
            *_yield_note(result, smooth),
        ]
    )


def smooth_reference(result: ContactResult) -> SmoothContact | None:
    """Return the Hertz contact that a result approximates, with no roughness and no plasticity.

    None for rough or saturated contacts, and where the map is too small for the Hertz contact.
    """
    smooth: SmoothContact | None = result.hertz
    if smooth is None or not is_smooth(result.pair) or result.totals.saturated:
        return None
    return smooth if all(item.severity == "note" for item in comparison_limits(result)) else None


def is_unresolved(result: ContactResult) -> bool:
    """Return whether the Hertz contact is narrower than a spot of `MIN_SPOT_PIXELS`."""
    half = min(_smooth_limits(result).semi_axes)
    return math.pi * half**2 < MIN_SPOT_PIXELS * max(result.surface.pixel) ** 2


def is_beyond_map(result: ContactResult) -> bool:
    """Return whether the Hertz contact is larger than the map."""
    return any(item.severity == "warning" for item in _within_map(result, _smooth_limits(result)))


def behind_load(result: ContactResult) -> bool:
    """Return whether the load was given by Hertz's theory, on nominal bodies in contact."""
    form = None if result.specified_load is None else result.specified_load.form
    stands = isinstance(form, (HertzPressure, LineLoad))
    return stands and result.hertz is not None and result.contact_area > 0


def hertz_load_note(result: ContactResult) -> Caution | None:
    """Return why the load of a Hertz peak pressure does not apply to this map, or None."""
    answer = [item for item in comparison_limits(result) if item.severity != "note"]
    return answer[0] if answer else None


def has_measured_map(result: ContactResult) -> bool:
    """Return whether one of the bodies in contact is nominal, and one of them is measured."""
    pair = result.pair
    return not pair.is_profile and has_nominal_body(pair.origins) and not is_smooth(pair)


def measured_form_caution(result: ContactResult) -> Caution | None:
    """Return the caution on a curved map whose form Hertz's theory leaves out."""
    nominal = relative_curvature(result.pair.origins)
    largest = 0.0 if nominal is None else float(np.abs(np.diag(nominal)).max())
    for surface in filter(None, (result.surface, result.counter_surface)):
        is_known = any(step.method == "with_form" for step in surface.provenance.operations)
        if is_known or is_nominal_origin(surface.provenance):
            continue
        rough = level(surface.heights, "quadric")
        shape = level(surface.heights, "plane") - rough
        if not largest or np.nanstd(shape) < np.nanstd(rough):
            continue
        curvatures = [
            abs(float(np.nanmean(np.diff(shape, 2, axis=axis)))) / edge**2
            for axis, edge in enumerate(surface.pixel)
        ]
        if max(curvatures) > _MIN_CURVATURE * largest:
            form = "cylinder" if min(curvatures) < max(curvatures) / 4 else "sphere"
            radius = format_engineering(1 / max(curvatures), "m", 2)
            return as_caution(
                CautionTag.HERTZ,
                f"Hertz's theory leaves out the curvature of the map (radius {radius}). Use "
                f"{ArgumentRef('form', form)} {ArgumentRef('body', f'{form} {radius}')}.",
                radius=1 / max(curvatures),
            )
    return None


def _smooth_limits(result: ContactResult) -> SmoothContact:
    smooth: SmoothContact | None = result.hertz
    assert smooth is not None
    return smooth


def _within_map(result: ContactResult, smooth: SmoothContact) -> Iterator[Caution]:
    """Yield cautions on an ellipse that leaves the map or is close to its periodic image."""
    for axis, reach in enumerate(smooth.reach):
        if not reach or axis == smooth.shape.axis:
            continue
        side, middle = result.surface.size[axis], result.center_of_pressure[axis]
        if axis in result.boundary.free_axes:
            edge = side / 2 - abs(middle)
            if reach > edge:
                yield as_warning(
                    CautionTag.HERTZ,
                    f"Hertz contact (±{format_engineering(reach, 'm', 3)}) is larger than the map "
                    f"(±{format_engineering(edge, 'm', 3)}). Measure a larger map or reduce the "
                    "load.",
                    reach=reach,
                    edge=edge,
                )
        elif side < FAR_RATIO * 2 * reach:
            yield near_copy_caution(side, 2 * reach, "Hertz")


def near_copy_caution(period: float, width: float, name: str) -> Caution:
    """Return the caution on a period of a few contact widths."""
    return as_caution(
        CautionTag.HERTZ,
        f"Periodic copies interact: period is {period / width:.2g} {name} widths, "
        f"{FAR_RATIO:.0f} needed. Use a larger map.",
        period=period,
        width=width,
    )


def _line_end_note(result: ContactResult) -> Iterator[Caution]:
    """Yield a caution on a line contact that ends at the map edge."""
    axis = _smooth_limits(result).shape.axis
    if axis is not None and axis in result.boundary.free_axes:
        yield as_caution(
            CautionTag.HERTZ,
            "The cylinder ends at the map edge, so edge pressure is too high. Use "
            f"{ArgumentRef('boundary', f'periodic-{_AXES[axis]}')}.",
        )


def _size_note(smooth: SmoothContact) -> Iterator[Caution]:
    """Yield cautions on a contact that is not small compared with the bodies."""
    # Each side deforms with the radius in its own direction.
    ratio = max(a / r for a, r in zip(smooth.semi_axes, smooth.shape.radii, strict=True))
    if ratio > SMALL_FRACTION:
        yield as_caution(
            CautionTag.HERTZ,
            f"Hertz contact is {ratio:.2g} of the radius: half-space theory is inaccurate above "
            f"{SMALL_FRACTION:g}.",
            ratio=ratio,
        )


def _yield_note(result: ContactResult, smooth: SmoothContact) -> Iterator[Caution]:
    """Yield a caution if the smooth bodies yield as well."""
    first = None if result.pair.first_to_yield is None else _first_yield(result, smooth)
    if first is not None and smooth.max_pressure >= first:
        yield as_note(
            CautionTag.HERTZ,
            "Smooth bodies also yield: Hertz peak "
            f"{format_engineering(smooth.max_pressure, 'Pa', 3)} "
            f"exceeds first yield at {format_engineering(first, 'Pa', 3)}.",
            first_yield=first,
            peak=smooth.max_pressure,
        )


def _first_yield(result: ContactResult, smooth: SmoothContact) -> float | None:
    """Return the peak pressure at first yield of the nominal bodies."""
    body = result.pair.first_to_yield
    assert body is not None
    return body.line_yield_pressure if smooth.shape.kind == LINE else body.first_yield_pressure
