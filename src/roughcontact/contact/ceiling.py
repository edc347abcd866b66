"""Pressure ceiling of a contact: as requested, or calibrated to volume plasticity.

A ceiling has one free parameter, its ratio to the yield strength. Three is correct for metals in
full plasticity; before that the plateau of the pressure is lower, and with hardening it is higher.
The ratio depends on how far a contact is beyond first yield, which follows from the solution with
any ceiling: see `recommended_ceiling`.

`ceiling_factor`: On a half-space with small strains there is no other parameter: E*, R and σ_Y only
set the scale of the load, and Poisson's ratio enters by the pressure at first yield. The contact
area then agrees with plasticity of the volume to 3 % for ν from 0 to 0.5.

`recommended_ceiling`: The spots are represented by one sphere. On a disk of radius a the slope of a
paraboloid of radius R has the root mean square g = a/(√2 R). This defines a/R = √2 g for any
contact, with g the root-mean-square slope of the initial gap over the contact spots, less the mean
of each spot. With the mean pressure p̄, the ratio of the load P = π a² p̄ to the load at first
yield P_c = π³ R² p_y³/(6 E*²) is

    P/P_c = 6 (E* a/R)² p̄/(π² p_y³),

with p_y the Hertz peak pressure at first yield. The ratio hardly depends on the ceiling of the
solution, as a lower ceiling gives more area and so more slope.

Under this load each body takes a share of a/R at a common mean pressure: from Hertz's theory for an
elastic body, from `indenters.mean_pressure` for a yielding one. Equal bodies have equal shares; a
body that yields against an elastic one is indented further, and has a higher mean pressure, than at
the same P/P_c under a rigid one. The ceiling is chosen to give this mean pressure.

A hardening material has the flow stress at the strain of 0.15 times its share of a/R. Tabor (1951)
has 0.2 for full indentation; 0.15 is more accurate before, where much of the plastic zone has
strained less. On spheres and rough maps with two laws the area then agrees to 8 %.

`confinement`: On a periodic map neighboring spots confine each other, so that the plateau rises
with the nominal pressure p̄ over the calibrated ceiling of separate spots p_c (asperity
persistence; Childs, Wear 25 (1973) 3; Pullen and Williamson, Proc. R. Soc. A 327 (1972) 159):

    ceiling/p_c = (1 + x^n)^(1/n), x = p̄/p_c, n = 3.5,

which tends to p̄ itself, so that every load is carried and the contact closes gradually. The
exponent is fitted to elastoplastic solutions of rough and bi-sinusoidal maps with E*h′/σ_Y of 3
to 100 and contacts up to 99 %.

`area_change`: For a sphere under the same load, areas are inversely proportional to mean pressures;
the mean pressure under a ceiling is `indenters.mean_under_ceiling`.

`solve_calibrated`: The load ratio hardly depends on the ceiling of the solution, so that two or
three solves are enough. If pixels that alternate between contact and gap prevent convergence, the
last of `MAX_SOLVES` is returned, with the remaining difference in its ``mismatch``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.roots import brentq
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import (
    BASE,
    BRACKET,
    CALIBRATED,
    COATING,
    CalibratedCeiling,
    CalibrationRecord,
    ContactResult,
    Regime,
)
from roughcontact.errors import (
    ArgumentRef,
    CapacityError,
    InputError,
    input_error,
    require_positive,
)
from roughcontact.material.hardening import flow_stress
from roughcontact.material.material import (
    CEILING_FACTOR,
    Material,
    contact_modulus,
    softer_material,
)
from roughcontact.theory import indenters
from roughcontact.units import format_engineering

# Representative strain over the slope a/R: between 0.1 for Swift's law, which is steep at small
# strains, and 0.2 for a linear law, Tabor's value for full indentation.
_REPRESENTATIVE_STRAIN = 0.15

CEILING_TOLERANCE = 2e-3
"""Relative tolerance between a ceiling and the ceiling calibrated from its solution."""

MAX_SOLVES = 6
"""Maximum number of solves for a calibrated ceiling."""

# Exponent of the confinement of neighboring spots (calibration/ceiling_rule.py).
_CONFINEMENT = 3.5

# Nominal pressure over the ceiling of separate spots above which confinement changes the ceiling by
# more than `CEILING_TOLERANCE`.
_MIN_CONFINED = 0.24

# Upper bound of the error of a height difference, relative to the largest height.
_ROUNDING = 16 * float(np.finfo(np.float64).eps)


def resolve_ceiling(
    ceiling: str | float | ArrayLike | None, pair: Pair
) -> float | NDArray[np.float64] | None:
    """Return the ceiling as a number [Pa], an array, or None."""
    if isinstance(ceiling, str):
        if pair.is_coated:
            return _coated_ceiling(ceiling, pair)
        if ceiling not in ("auto", CALIBRATED):
            names = f"'auto', {CALIBRATED!r} or 'none' for a body without a coating"
            raise input_error("ceiling", ceiling, f"must be a pressure, a hardness, {names}")
        body = pair.softer
        if ceiling == CALIBRATED and (body is None or body.yield_strength is None):
            raise InputError(
                f"{ArgumentRef('ceiling', CALIBRATED)} needs the yield strength of the softer "
                f"body, and none is given: give it, or a {ArgumentRef('ceiling')} in Pa"
            )
        return None if body is None else body.ceiling
    if ceiling is None:
        return None
    try:
        specified = np.asarray(ceiling)
    except ValueError:
        raise InputError(
            "must be a number or a map, got rows of unequal length", argument="ceiling"
        ) from None
    if specified.dtype.kind not in "fiu" or isinstance(ceiling, np.ma.MaskedArray):
        raise InputError(
            f"must be real numbers [Pa], got {type(ceiling).__name__}", argument="ceiling"
        )
    values = specified.astype(np.float64)
    if values.ndim == 0:
        require_positive(ceiling=float(values))
        return float(values)
    if values.shape != pair.shape:
        raise InputError(f"has shape {values.shape}, the surface {pair.shape}", argument="ceiling")
    if not (values > 0).all():
        smallest = float(values.min())
        raise InputError(
            f"must be positive everywhere [Pa], its smallest is {smallest!r}", argument="ceiling"
        )
    if np.isinf(values).all():
        return None
    values.flags.writeable = False
    return values


def confinement(pressure_ratio: float) -> float:
    """Return the ceiling of neighboring spots over that of separate spots.

    1 where the change is below `CEILING_TOLERANCE`.
    """
    if pressure_ratio < _MIN_CONFINED:
        return 1.0
    return float((1 + pressure_ratio**_CONFINEMENT) ** (1 / _CONFINEMENT))


def ceiling_factor(load_ratio: float, first_yield: float = 1.615) -> float:
    """Return the ceiling of a perfectly plastic sphere over its yield strength."""
    require_positive(load_ratio=load_ratio, first_yield=first_yield)
    # P = π a² p̄ in terms of the index x is P/P_c = 6 x² (p̄/σ_Y)/(π² C³).
    wanted = load_ratio * math.pi**2 * first_yield**3 / 6
    ratio = _slope_of_load_ratio(wanted, lambda x: indenters.mean_pressure(x, first_yield))
    mean = indenters.mean_pressure(ratio, first_yield)
    return min(indenters.ceiling(ratio, mean, first_yield), CEILING_FACTOR)


def _slope_of_load_ratio(load: float, mean: Callable[[float], float]) -> float:
    """Return the slope at which slope² times the mean pressure equals a load."""
    # The mean pressure increases with the slope, at most proportionally.
    start = load ** (1 / 3)
    low, high = start, start
    while low**2 * mean(low) > load:
        low /= 4
    while high**2 * mean(high) < load:
        high *= 4
    return float(brentq(lambda slope: slope**2 * mean(slope) - load, low, high, rtol=1e-12))


def recommended_ceiling(result: ContactResult) -> CalibratedCeiling | None:
    """Return the ceiling calibrated from one solution of a contact."""
    bodies = _yielding_bodies(result.pair)
    if bodies is None:
        return None
    slope = math.sqrt(2) * _contact_slope(result)
    if slope == 0:
        return None
    mean = result.load / result.perimeter_corrected_area
    nominal = 0.0 if result.boundary.free_axes else result.load / result.touchable_area
    return recommend_ceiling(bodies, slope, mean, nominal)


def _yielding_bodies(pair: Pair) -> tuple[Material, Material] | None:
    """Return both bodies, a harder coated one as elastic; None without a known yield strength."""
    bodies = pair.material, pair.counter_material
    if pair.is_coated:
        softest = {body.ceiling for body in bodies if not body.coating}
        if set(coated_ceilings(pair).values()) != softest:
            return None
        first, second = (
            replace(body.outermost, yield_strength=None, hardness=None) if body.coating else body
            for body in bodies
        )
        bodies = first, second
    softer = softer_material(*bodies)
    return None if softer is None or softer.yield_strength is None else bodies


def coated_ceilings(pair: Pair) -> dict[str, float]:
    """Return the ceilings of the coating and of its base [Pa], by name.

    Each is that of the softer body; both are equal if an uncoated counter-body is the softest.
    """
    bodies = (pair.material, pair.counter_material)
    known = {
        COATING: softer_material(*(body.outermost for body in bodies)),
        BASE: softer_material(*(body.uncoated for body in bodies)),
    }
    return {name: body.ceiling for name, body in known.items() if body and body.ceiling}


def is_bracket(pair: Pair, ceiling: object) -> bool:
    """Return whether a coated body is to be solved under two different ceilings."""
    wanted = pair.is_coated and isinstance(ceiling, str) and ceiling == BRACKET
    return wanted and len(set(coated_ceilings(pair).values())) > 1


def first_ceiling(pair: Pair, ceiling: Any) -> Any:
    """Return a ceiling, or that of the coating if both of a coated body are requested."""
    return COATING if is_bracket(pair, ceiling) else ceiling


def _coated_ceiling(ceiling: str, pair: Pair) -> float:
    """Return the ceiling of the coating or of its base [Pa], by its name."""
    limits = coated_ceilings(pair)
    if ceiling in limits:
        return limits[ceiling]
    if len(limits) > 1 and len(set(limits.values())) == 1 and ceiling in ("auto", BRACKET):
        return limits[COATING]
    offered = [f"{name!r} ({format_engineering(value, 'Pa', 3)})" for name, value in limits.items()]
    if len(limits) > 1 and ceiling != BRACKET:
        offered.append(f"{BRACKET!r} (both)")
    raise InputError(
        "of a coated body has to be given: spots much smaller than the coating yield at its "
        "pressure, much larger ones at the ceiling of the base; give "
        f"{', '.join(offered)}{' or ' if offered else ''}a pressure, or 'none'",
        argument="ceiling",
        value=ceiling,
    )


def area_change(advice: CalibratedCeiling, ceiling: float | None, modulus: float) -> float:
    """Return the relative change of the contact area by plasticity in the volume."""

    def mean(slope: float, limit: float | None) -> float:
        if limit is None:
            return 4 * modulus * slope / (3 * math.pi)
        return limit * indenters.mean_under_ceiling(modulus * slope / limit)

    known = mean(advice.slope, advice.ceiling)
    slope = _slope_of_load_ratio(advice.slope**2 * known, lambda slope: mean(slope, ceiling))
    return mean(slope, ceiling) / known - 1


def recommend_ceiling(
    pair: tuple[Material, Material], slope: float, mean: float, nominal: float = 0.0
) -> CalibratedCeiling:
    """Return the calibrated ceiling for this a/R, mean pressure and nominal pressure [Pa]."""
    softer, modulus = softer_material(*pair), contact_modulus(*pair)
    bodies = [item for item in pair if item.compliance > 0]
    load = slope**2 * mean
    # With the calibrated ceiling the same load is carried at another slope.
    slope = _slope_of_load_ratio(load, lambda s: _share_pressure(bodies, s)[0])
    borne, *taken = _share_pressure(bodies, slope)
    parts = dict(zip(map(id, bodies), taken, strict=True))
    yielding = [item for item in pair if item.yield_strength]
    flow = {id(item): _flow_stress(item, parts.get(id(item), 0.0)) for item in yielding}
    first = min(flow[id(item)] * _first_yield(item) for item in yielding)
    result = indenters.ceiling(modulus * slope, borne, first)
    bounds = [CEILING_FACTOR * flow[id(item)] for item in yielding]
    bounds += [item.hardness for item in bodies if item.hardness]
    separate = min(result, *bounds)
    ceiling = separate * confinement(nominal / separate)
    assert softer is not None
    assert softer.yield_strength is not None
    return CalibratedCeiling(
        load_ratio=6 * modulus**2 * load / (math.pi**2 * first**3),
        slope=slope,
        flow_stress=flow[id(softer)],
        first_yield=first,
        ceiling=ceiling,
        factor=ceiling / softer.yield_strength,
    )


def _share_pressure(bodies: Sequence[Material], slope: float) -> tuple[float, ...]:
    """Return the common mean pressure [Pa] of the bodies, and the slope share of each."""
    if len(bodies) == 1:
        return _sphere_mean_pressure(bodies[0], slope), slope
    item, other = bodies

    def excess(part: float) -> float:
        return _sphere_mean_pressure(item, part) - _sphere_mean_pressure(other, slope - part)

    minimum, maximum = 1e-9 * slope, (1 - 1e-9) * slope
    # A body that carries more at such a small share is practically rigid.
    if excess(minimum) > 0:
        return _sphere_mean_pressure(other, slope), 0.0, slope
    if excess(maximum) < 0:
        return _sphere_mean_pressure(item, slope), slope, 0.0
    part = float(brentq(excess, minimum, maximum, rtol=1e-12))
    return _sphere_mean_pressure(item, part), part, slope - part


def _sphere_mean_pressure(body: Material, slope: float) -> float:
    """Return the mean pressure [Pa] of a body under a rigid sphere of this a/R."""
    if body.yield_strength is None:
        return 4 * slope / (3 * math.pi * body.compliance)
    flow = _flow_stress(body, slope)
    return flow * indenters.mean_pressure(slope / (body.compliance * flow), _first_yield(body))


def _flow_stress(body: Material, slope: float) -> float:
    assert body.yield_strength is not None
    return float(flow_stress(body.law, np.array(_REPRESENTATIVE_STRAIN * slope)))


def _first_yield(body: Material) -> float:
    """Return the Hertz peak pressure at first yield over the yield strength."""
    assert body.first_yield_pressure is not None
    assert body.yield_strength is not None
    return body.first_yield_pressure / body.yield_strength


def solve_calibrated(
    first: ContactResult, again: Callable[[float, ContactResult], ContactResult]
) -> ContactResult:
    """Return the contact under a ceiling that agrees with the one calibrated from it.

    Where no slope or no calibrated ceiling that carries the load is found, the last ceiling stays,
    with a ``mismatch`` of NaN.
    """
    if not first.converged or first.regime is Regime.BELOW_FIRST_YIELD:
        return first
    result, advice = first, recommended_ceiling(first)
    chosen, solves = advice, 1
    while (
        advice is not None
        and solves < MAX_SOLVES
        and abs(advice.ceiling / _uniform_ceiling(result) - 1) > CEILING_TOLERANCE
    ):
        chosen = advice
        try:
            result = again(chosen.ceiling, result)
        except CapacityError:
            advice = None
            break
        solves += 1
        if not result.converged:
            return result
        advice = recommended_ceiling(result)
    ceiling, body = _uniform_ceiling(result), first.pair.softer
    text = CalibrationRecord(
        load=result.load,
        load_ratio=math.nan if chosen is None else chosen.load_ratio,
        factor=ceiling / ((body and body.yield_strength) or math.nan),
        mismatch=math.nan if advice is None else advice.ceiling / ceiling - 1,
        solves=solves,
        usual_ceiling=_uniform_ceiling(first),
        usual_contact_area=first.contact_area,
        usual_approach=first.approach,
        usual_indentation=float(first.residual_indentation.max()),
    )
    return replace(result, calibration=text)


def _uniform_ceiling(result: ContactResult) -> float:
    """Return the ceiling of a result with the same ceiling at all pixels."""
    assert isinstance(result.ceiling, float)
    return result.ceiling


def _contact_slope(result: ContactResult) -> float:
    """Return the root-mean-square slope within the contact spots, less the mean of each."""
    label = result.spots().label
    places = np.nonzero(label)
    bodies = [body for body in (result.surface, result.counter_surface) if body is not None]
    pixel = result.surface.pixel
    # Height differences of a tilted flat that are due to rounding.
    largest = (max(np.nanmax(body.heights), -np.nanmin(body.heights)) for body in bodies)
    rounding = _ROUNDING * float(sum(largest)) / min(pixel)
    gap, spot = result.initial_gap, label[places]
    if not spot.size:
        return 0.0
    count = np.bincount(spot)
    square = np.zeros(spot.size)
    for axis, edge in enumerate(pixel):
        before, after = list(places), list(places)
        before[axis] = np.maximum(places[axis] - 1, 0)
        after[axis] = np.minimum(places[axis] + 1, gap.shape[axis] - 1)
        distance = np.maximum(after[axis] - before[axis], 1) * edge
        slope = (gap[tuple(after)] - gap[tuple(before)]) / distance
        # Missing points have no contact; at their rim only the slope of the spot is used.
        known = ~np.isnan(slope)
        total = np.bincount(spot[known], slope[known], count.size)
        mean = total / np.maximum(np.bincount(spot[known], minlength=count.size), 1)
        square += np.where(known, slope - mean[spot], 0.0) ** 2
    slope = math.sqrt(float(square.mean()))
    return slope if slope > rounding else 0.0
