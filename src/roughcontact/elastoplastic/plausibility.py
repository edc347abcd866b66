"""What a contact with plasticity of the volume is judged by before its numbers are believed."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact.cautions import Caution, Kind, as_caution, as_warning, ordered
from roughcontact.contact import plausibility
from roughcontact.contact.plausibility import LARGE_STRAIN
from roughcontact.elastoplastic.increments import STEP_ERROR
from roughcontact.elastoplastic.result import ElastoplasticResult
from roughcontact.errors import ArgumentRef, message_parts
from roughcontact.halfspace import tensors
from roughcontact.material.hardening import Kinematic, Linear, Perfect, Tabulated
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering

LARGE_DEFORMATION = 0.1
"""Root-mean-square slope under the contact, 0.7 a/R of a sphere.

From a/R = 0.16 on finite elements show large deformations under a sphere (Mesarovic and Fleck 1999,
doi:10.1098/rspa.1999.0423).
"""

# Stress beyond the yield strength, over it, that is worth a word.
_EXCESS = 0.05

# What the contact alone says without knowing of the volume.
_OF_THE_CEILING = (
    Kind.NOT_CONVERGED,
    Kind.EDGE,
    Kind.BEYOND_CEILING,
    Kind.CEILING,
    Kind.HARDNESS,
    Kind.STRAINS,
)


def cautions(result: ElastoplasticResult) -> tuple[Caution, ...]:
    """Return what a reader of a state of the volume has to know, the severest first."""
    answer = [check(result) for check in _CHECKS]
    shown = (c for c in result.solution.cautions if c.kind not in _OF_THE_CEILING)
    return ordered([*(caution for caution in answer if caution is not None), *shown])


def checked(result: ElastoplasticResult) -> tuple[str, ...]:
    """Return what a state of the volume was looked at for, in a few words each."""
    subjects = [
        "convergence", "stress against the yield strength",
        "plastic strain at the ends of the volume", "size of plastic strains",
        "the law of hardening",
    ]  # fmt: skip
    if result.step_error is not None:
        subjects.append("error of the load steps")
    if result.solution.boundary.free_axes:
        subjects.append("contact at the edges")
    return (
        *subjects,
        "size of the spots in pixels",
        "slopes",
        "spikes of the measurement",
        "filled and missing points",
    )


def slope_under(result: ElastoplasticResult) -> float:
    """Return the root-mean-square slope of the first gap under contact or plastic strain."""
    gap = result.solution.initial_gap
    under = result.solution.contact
    if not under.any():
        ny, nx = gap.shape
        for body in result.bodies:
            inside = np.s_[body.margin : body.margin + ny, body.margin : body.margin + nx]
            under = under | body.flowed_under[inside]
    square = np.zeros(gap.shape)
    for slope in np.gradient(gap, *result.solution.surface.pixel):
        square += slope * slope
    known = square[under & np.isfinite(square)]
    return math.sqrt(float(known.mean())) if known.size else math.nan


def largest_strain(result: ElastoplasticResult) -> float:
    """Return the largest plastic strain of a state: what counts against the small ones assumed."""
    if not result.has_moved:
        return result.max_plastic_strain
    tensor = (body.plastic_strain.swapaxes(0, 1) for body in result.whole_bodies)
    return 2 / 3 * max(float(tensors.equivalent(strain).max()) for strain in tensor)


def perfectly_plastic(result: ElastoplasticResult) -> bool:
    """Return whether a body that yields does not harden."""
    return any(
        isinstance(law, Perfect) or (isinstance(law, Linear | Kinematic) and law.modulus == 0)
        for law in (body.material.law for body in result.bodies)
    )


# The checks


def _convergence(result: ElastoplasticResult) -> Caution | None:
    if result.converged:
        return None
    return as_warning(Kind.NOT_CONVERGED, *message_parts(result.status))


def _steps(result: ElastoplasticResult) -> Caution | None:
    error = result.step_error
    if error is None or not error > STEP_ERROR:
        return None
    return as_caution(
        Kind.LOAD_STEPS,
        f"the steps to the load make an error of about {100 * error:.2g} % of approach and contact "
        "area: take more of them, ",
        ArgumentRef("increments"),
        step_error=error,
    )


def _edge(result: ElastoplasticResult) -> Caution | None:
    return plausibility.at_edge(result.solution, "; the volume goes on beyond the edge")


def _excess(result: ElastoplasticResult) -> Caution | None:
    if not result.yield_excess > _EXCESS:
        return None
    return as_warning(
        Kind.BEYOND_YIELD,
        "the von Mises stress exceeds the yield strength by up to "
        f"{100 * result.yield_excess:.3g} %: plastic strain is so large compared with the "
        "yield strain that it needs a smaller ",
        ArgumentRef("tolerance"),
        yield_excess=result.yield_excess,
    )


def _sides(result: ElastoplasticResult) -> Caution | None:
    free = result.solution.boundary.free_axes
    if not (free and any(body.at_rim for body in result.bodies)):
        return None
    return as_warning(
        Kind.PLASTIC_EDGE,
        "plastic strain reaches the edge of the volume: enlarge the map, or solve with ",
        ArgumentRef("boundary", "periodic"),
    )


def _bottom(result: ElastoplasticResult) -> Caution | None:
    if not any(body.at_bottom for body in result.bodies):
        return None
    return as_warning(
        Kind.PLASTIC_BOTTOM,
        "plastic strain reaches the lowest layer: enlarge the map, or give a larger ",
        ArgumentRef("depth"),
    )


def _deformations(result: ElastoplasticResult) -> Caution | None:
    strain = largest_strain(result)
    if strain > LARGE_STRAIN:
        return as_caution(
            Kind.PLASTIC_STRAINS,
            f"the largest plastic strain is {strain:.2g}, beyond the small strains of the model "
            f"(about {LARGE_STRAIN:g}): read strains and pressures there as estimates",
            max_plastic_strain=strain,
        )
    slope = slope_under(result)
    if slope > LARGE_DEFORMATION:
        return as_caution(
            Kind.PLASTIC_STRAINS,
            f"the slope under the contact is {slope:.2g}, beyond the small deformations of the "
            f"model (about {LARGE_DEFORMATION:g}): read areas and pressures as estimates",
            slope=slope,
        )
    return None


def _hardening(result: ElastoplasticResult) -> Caution | None:
    for body in result.bodies:
        law = body.material.law
        law = law.isotropic if isinstance(law, Kinematic) else law
        if isinstance(law, Tabulated) and body.max_plastic_strain > law.strain[-1]:
            return as_caution(
                Kind.HARDENING,
                f"the plastic strain exceeds {law.strain[-1]:.3g}, where the table of the yield "
                "strength ends: beyond it the strength is taken as constant",
                max_plastic_strain=body.max_plastic_strain,
            )
    if perfectly_plastic(result) and result.plastic_volume and result.solution.load:
        return as_caution(
            Kind.SCATTER,
            "without hardening the pressure of single pixels scatters by 5 to 10 %: use means "
            "over 3 × 3 pixels or more, not the largest value",
        )
    return None


def _residual(result: ElastoplasticResult) -> Caution | None:
    loaded = result.increments and result.solution.load
    if not (loaded and any(body.flows_back for body in result.bodies)):
        return None
    return as_caution(
        Kind.RESIDUAL,
        "the residual stress exceeds the yield strength, so that the bodies would flow again "
        "on unloading: end the path at zero load (--unload on the command line) to see "
        "what stays",
    )


_CHECKS = (
    _convergence, _excess, _steps, _edge, _sides, _bottom, _deformations, _hardening, _residual,
)  # fmt: skip


# What repeated passes are judged by besides their last state: their steps, pixel and direction.


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
    """Return where the axis of a nominal cylinder lies [degrees], ``None`` for other bodies."""
    created = counter_surface.provenance.origin
    if (
        created is None
        or created.method != "nominal.cylinder"
        or counter_surface.provenance.operations
    ):
        return None
    return float(created.arguments["angle"])


def half_width(result: ElastoplasticResult, direction: float) -> float:
    """Return half the length of the contact along a direction."""
    solution = result.solution
    touching, answer = solution.contact, np.nonzero(solution.contact)
    if not touching.any():
        return math.inf
    along = np.zeros(answer[0].size)
    for axis, share in enumerate(_shares(direction)):
        index = answer[axis]
        used: NDArray[np.bool_] = np.any(touching, axis=1 - axis)
        if axis in solution.boundary.periodic_axes:
            if share and used.all():
                return math.inf
            index = (index - _begin(used)) % used.size
        along += share * solution.surface.pixel[axis] * index
    return (float(np.ptp(along)) + _pixel(result, direction)) / 2


def too_long(result: ElastoplasticResult, step: float, direction: float) -> bool:
    """Return whether the dents of neighbouring places of a pass may lie apart."""
    return _stride(result, step, direction) > LONGEST_STEP


def rolling_cautions(
    result: ElastoplasticResult, step: float, count: int, direction: float, axis: float | None
) -> Iterator[Caution]:
    """Yield what a reader of passes has to know of their steps, grid and direction."""
    if axis is not None and abs((axis - direction + 90) % 180 - 90) <= _ALONG:
        yield _slides(axis, direction)
        return
    half = half_width(result, direction)
    stride = _stride(result, step, direction)
    if stride > LONG_STEP:
        yield _coarse(stride, half, math.ceil(count * stride / _FINE_STEP - 1e-9))
    pixels = half / _pixel(result, direction)
    if pixels < FEW_PIXELS:
        yield as_warning(
            Kind.RESOLUTION,
            f"the half-width of the contact along the way, {engineering(half, 'm', 3)}, has only "
            f"{pixels:.2g} pixels: what a pass adds depends on the pixel; take at least "
            f"{FEW_PIXELS}, for numbers sixteen",
            pixels=pixels,
        )


def _coarse(stride: float, half: float, steps: int) -> Caution:
    """Return what is said of steps of so many half-widths."""
    judged = as_warning if stride > LONGEST_STEP else as_caution
    outcome = (
        "dents may lie apart, each of which bears the counter-body by itself"
        if stride > LONGEST_STEP
        else "strain by a pass comes out too small"
    )
    return judged(
        Kind.WAY,
        f"the steps of a pass are {stride:.2g} times the half-width of the contact along the way, "
        f"{engineering(half, 'm', 3)}: {outcome}; take steps of a quarter of it, ",
        ArgumentRef("steps", steps),
        step_over_half_width=stride,
        half_width=half,
    )


def _slides(axis: float, direction: float) -> Caution:
    """Return what is said of a cylinder that goes where its axis points."""
    across = f"{(direction + 90) % 180:g}"
    return as_warning(
        Kind.AXIS,
        f"the cylinder moves along its axis, which lies at {axis:g} degrees: it slides on one line "
        f"and rolls over nothing; let its axis lie across, as in 'cylinder 2 mm {across} deg', or "
        "give ",
        ArgumentRef("direction", (axis + 90) % 180),
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
