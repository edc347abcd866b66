"""Plausibility checks of elastoplastic results."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from roughcontact.cautions import (
    Caution,
    CautionTag,
    as_caution,
    as_note,
    as_warning,
    sort_cautions,
)
from roughcontact.contact import hertz_comparison, plausibility
from roughcontact.contact.plausibility import LARGE_STRAIN
from roughcontact.contact.result import ContactResult
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.errors import ArgumentRef, Part
from roughcontact.halfspace import tensors
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.hardening import Kinematic, Linear, Perfect, Tabulated
from roughcontact.surface.provenance import Provenance
from roughcontact.units import format_engineering

LARGE_DEFORMATION = 0.1
"""Limit of the root-mean-square slope under the contact, 0.7 a/R of a sphere.

From a/R = 0.16 on finite elements show large deformations under a sphere (Mesarovic and Fleck 1999,
doi:10.1098/rspa.1999.0423).
"""

# Relative excess of stress over the yield strength above which a warning is given.
_EXCESS = 0.05

# Cautions of the contact that do not account for plasticity of the volume: left out.
_OF_THE_CEILING = (
    CautionTag.NOT_CONVERGED,
    CautionTag.EDGE,
    CautionTag.ABOVE_CEILING,
    CautionTag.CEILING,
    CautionTag.HARDNESS,
    CautionTag.STRAIN,
)


def cautions(result: ElastoplasticResult) -> tuple[Caution, ...]:
    """Return the cautions on a state of the volume, the most severe first."""
    shown = (c for c in result.solution.cautions if c.kind not in _OF_THE_CEILING)
    own = (c for check in _CHECKS for c in check(result))
    return sort_cautions(map(_with_full_period, (*own, *shown)))


def performed_checks(result: ElastoplasticResult) -> tuple[str, ...]:
    """Return short descriptions of the checks performed on a result."""
    subjects = [
        "convergence",
        "stress against the yield strength",
        "plastic strain at the ends of the volume",
        "size of plastic strains",
        "the law of hardening",
    ]
    if result.solution.boundary.free_axes:
        subjects.append("contact at the edges")
    if result.solution.boundary.periodic_axes:
        subjects.append("opposite edges of a periodic map")
    return (
        *subjects,
        "size of the spots in pixels",
        "slopes",
        "spikes of the measurement",
        "filled and missing points",
    )


def slope_under(result: ElastoplasticResult) -> float:
    """Return the RMS slope of the initial gap in the contact, or where strain is plastic."""
    gap = result.solution.initial_gap
    under = result.solution.contact
    if not under.any():
        for body in result.bodies:
            under = under | np.asarray(body.accumulated.any(axis=0))[result.map_window]
    square = np.zeros(gap.shape)
    for slope in np.gradient(gap, *result.solution.surface.pixel):
        square += slope * slope
    known = square[under & np.isfinite(square)]
    return math.sqrt(float(known.mean())) if known.size else math.nan


def largest_strain(result: ElastoplasticResult) -> float:
    """Return the largest plastic strain to compare with the limit of small strains.

    The accumulated strain, or with a counter-surface that has moved the present strain.
    """
    if not result.has_moved:
        return result.max_plastic_strain
    tensor = (body.plastic_strain.swapaxes(0, 1) for body in result.bodies)
    return 2 / 3 * max(float(tensors.equivalent(strain).max()) for strain in tensor)


def perfectly_plastic(result: ElastoplasticResult) -> bool:
    """Return whether any yielding body is perfectly plastic."""
    return any(
        isinstance(law, Perfect) or (isinstance(law, Linear | Kinematic) and law.modulus == 0)
        for law in (body.material.law for body in result.bodies)
    )


# Checks


def _check_convergence(result: ElastoplasticResult) -> Iterator[Caution]:
    if not result.converged:
        yield as_warning(
            CautionTag.NOT_CONVERGED,
            "Not converged: the load path stopped at "
            f"{format_engineering(result.solution.load, 'N', 3)}. "
            f"Increase {ArgumentRef('max_iterations')} or {ArgumentRef('tolerance')}.",
        )
    if result.yield_excess > _EXCESS:
        yield as_warning(
            CautionTag.YIELD_EXCESS,
            f"Stress exceeds yield strength by {100 * result.yield_excess:.3g} %: plastic strain "
            f"is not converged. Use a smaller {ArgumentRef('tolerance')}.",
            yield_excess=result.yield_excess,
        )


def _check_ends(result: ElastoplasticResult) -> Iterator[Caution]:
    if (caution := plausibility.edge_caution(result.solution)) is not None:
        yield caution
    free = bool(result.solution.boundary.free_axes)
    side = free and any(body.has_reached_rim for body in result.bodies)
    bottom = any(body.accumulated[-1].any() for body in result.bodies)
    text: tuple[Part, ...]
    if side and bottom:
        text = ("the side and the deepest layer. Enlarge the map and ", ArgumentRef("depth"), ".")
    elif side:
        boundary = plausibility.beyond_edge(result.solution)
        more = () if boundary is None else (" or use ", boundary)
        text = ("the side of the volume. Enlarge the map", *more, ".")
    elif bottom:
        text = ("the deepest layer. Increase ", ArgumentRef("depth"), ".")
    else:
        return
    yield as_warning(CautionTag.PLASTIC_EDGE, f"Plastic zone reaches {text[0]}", *text[1:])


def _check_deformation(result: ElastoplasticResult) -> Iterator[Caution]:
    strain = largest_strain(result)
    if strain > LARGE_STRAIN:
        yield as_caution(
            CautionTag.STRAIN,
            f"Plastic strain {100 * strain:.3g} % exceeds the small-strain limit "
            f"({100 * LARGE_STRAIN:.0f} %): local values are estimates.",
            max_plastic_strain=strain,
        )
    elif (slope := slope_under(result)) > LARGE_DEFORMATION:
        yield as_caution(
            CautionTag.SLOPES,
            f"Slope under the contact is {slope:.2g}, limit {LARGE_DEFORMATION:g}: areas and "
            "pressures are estimates.",
            slope=slope,
        )


def _check_hardening(result: ElastoplasticResult) -> Iterator[Caution]:
    for body in result.bodies:
        law = body.material.law
        law = law.isotropic if isinstance(law, Kinematic) else law
        if isinstance(law, Tabulated) and body.max_plastic_strain > law.strain[-1]:
            yield as_caution(
                CautionTag.HARDENING_RANGE,
                f"Plastic strain exceeds your hardening table ({law.strain[-1]:.3g}). Strength is "
                "held constant beyond it.",
                max_plastic_strain=body.max_plastic_strain,
            )
            return


def _check_flow(result: ElastoplasticResult) -> Iterator[Caution]:
    if perfectly_plastic(result) and result.plastic_volume and result.solution.load:
        yield as_note(
            CautionTag.PIXEL_SCATTER,
            "Single-pixel pressures scatter by 5 to 10 % without hardening. Use 3 × 3 means.",
        )
    loaded = result.increments and result.solution.load
    if loaded and any(body.flows_back for body in result.bodies):
        yield as_caution(
            CautionTag.RESIDUAL_YIELD,
            "Bodies would yield again on unloading. End the load path at zero "
            f"({ArgumentRef('unload')}).",
        )


_CHECKS = (_check_convergence, _check_ends, _check_deformation, _check_hardening, _check_flow)


# Steps, pixel and direction of repeated passes, besides the last state.


LONG_STEP, LONGEST_STEP = 0.5, 1.0
"""Steps over the contact half-width above which strains are too small, or meaningless.

A roller at 4.5 k, which ratchets: a pass leaves 24 % less strain with steps of 0.5 than with steps
of 0.25, 39 % less with 0.67 and 89 % less with 1; with 2.7 the indentations are separate, and the
roller seems to shake down.
"""

FEW_PIXELS = 4
"""Pixels per contact half-width below which the strain of a pass depends on the grid.

The same roller with steps of 0.5: 16 and 8 pixels agree to 1 %; 4 pixels give 11 % less strain, 3
give 17 % less and 2 give 75 % less.
"""

_FINE_STEP = 0.25
# Share of the travel along an axis from which its period counts.
_OBLIQUE = 0.5
# Largest angle between axis and travel of a roller that slides along its axis [degrees].
_ALONG = 5.0


def cylinder_axis(counter_body: Provenance) -> float | None:
    """Return the angle of the axis of a nominal cylinder [degrees]; None for other bodies."""
    created = counter_body.origin
    if created is None or created.method != "nominal.cylinder" or counter_body.operations:
        return None
    return float(created.arguments["angle"])


def half_width(result: ElastoplasticResult, direction: float) -> float:
    """Return half the length of the contact along a direction [m]; may be infinite."""
    solution = result.solution
    touching, answer = solution.contact, np.nonzero(solution.contact)
    if not touching.any():
        return math.inf
    along = np.zeros(answer[0].size)
    for axis, share in enumerate(_direction_components(direction)):
        index = answer[axis]
        used: NDArray[np.bool_] = np.any(touching, axis=1 - axis)
        if axis in solution.boundary.periodic_axes:
            if share and used.all():
                return math.inf
            index = (index - _first_after_gap(used)) % used.size
        along += share * solution.surface.pixel[axis] * index
    return (float(np.ptp(along)) + _pixel_along(result, direction)) / 2


def too_long(result: ElastoplasticResult, step: float, direction: float) -> bool:
    """Return whether the indentations of successive steps of a pass may be separate."""
    return _relative_step(result, step, direction) > LONGEST_STEP


def _with_full_period(caution: Caution) -> Caution:
    """Return a caution that recommends no strip: the volume has two free or periodic axes."""
    parts = tuple(
        ArgumentRef("boundary", Boundary.PERIODIC)
        if isinstance(part, ArgumentRef) and part.name == "boundary"
        else part
        for part in caution.parts
    )
    return replace(caution, parts=parts)


def rolling_cautions(
    result: ElastoplasticResult, step: float, count: int, direction: float, axis: float | None
) -> Iterator[Caution]:
    """Yield the cautions on steps, grid and direction of passes."""
    if axis is not None and abs((axis - direction + 90) % 180 - 90) <= _ALONG:
        yield _axial_motion_caution(axis, direction)
        return
    half = half_width(result, direction)
    yield from _near_copy_cautions(result.solution, half, direction)
    stride = _relative_step(result, step, direction)
    if stride > LONG_STEP:
        yield _coarse_step_caution(stride, half, math.ceil(count * stride / _FINE_STEP - 1e-9))
    pixels = half / _pixel_along(result, direction)
    if pixels < FEW_PIXELS:
        yield as_warning(
            CautionTag.ROLLING_PIXEL,
            f"Contact half-width has {pixels:.2g} pixels: strain per pass is too small. Use at "
            "least 8, better 16.",
            pixels=pixels,
        )


def _near_copy_cautions(
    solution: ContactResult, half: float, direction: float
) -> Iterator[Caution]:
    """Yield the caution on a period of a few contact widths along the travel."""
    for axis, share in enumerate(_direction_components(direction)):
        side = solution.surface.size[axis]
        width = min(2 * half, side)
        is_along = axis in solution.boundary.periodic_axes and abs(share) > _OBLIQUE
        if is_along and side < hertz_comparison.FAR_RATIO * width:
            yield hertz_comparison.near_copy_caution(side, width, "contact")


def _coarse_step_caution(stride: float, half: float, steps: int) -> Caution:
    """Return the caution on the step length over the contact half-width."""
    apart = stride > LONGEST_STEP
    return (as_warning if apart else as_caution)(
        CautionTag.STEP_LENGTH,
        f"Step is {stride:.2g} contact half-widths: "
        f"{'strain is meaningless' if apart else 'strain per pass is too small'}. Use ",
        ArgumentRef("steps", steps),
        ".",
        step_over_half_width=stride,
        half_width=half,
    )


def _axial_motion_caution(axis: float, direction: float) -> Caution:
    """Return the caution on a cylinder that moves along its axis."""
    return as_warning(
        CautionTag.CYLINDER_SLIDES,
        "The cylinder moves along its own axis: it slides, not rolls. Use ",
        ArgumentRef("direction", (axis + 90) % 180),
        ".",
        axis=axis,
        direction=direction,
    )


def _relative_step(result: ElastoplasticResult, step: float, direction: float) -> float:
    """Return a step over the half-width; 0 for a step of a pixel, which skips no point."""
    if step <= (1 + 1e-9) * _pixel_along(result, direction):
        return 0.0
    return step / half_width(result, direction)


def _direction_components(direction: float) -> tuple[float, float]:
    """Return the components of a direction along y and x, exactly zero at right angles."""
    angle = math.radians(direction)
    return round(math.sin(angle), 15), round(math.cos(angle), 15)


def _pixel_along(result: ElastoplasticResult, direction: float) -> float:
    """Return the length of a pixel along a direction [m]."""
    edges = zip(_direction_components(direction), result.solution.surface.pixel, strict=True)
    return sum(abs(share) * edge for share, edge in edges)


def _first_after_gap(used: NDArray[np.bool_]) -> int:
    """Return the first index after the longest gap in a period."""
    index = np.flatnonzero(used)
    gaps = np.diff(index, append=index[0] + used.size)
    return int(index[(gaps.argmax() + 1) % index.size])
