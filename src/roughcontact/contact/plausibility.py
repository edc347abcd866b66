"""Plausibility checks of contact results, one function per check.

A check examines a solution and returns a caution or None. All presentations of a result, from the
console to the report, show the result of `cautions`.

`ratio_to_elastoplastic`: With the calibrated ceiling, residual depth and energy of perfectly
plastic spheres are 1.1 and 1.3 times those of the volume model; for another ceiling both follow
from the ceiling model. On rough maps, whose spots differ, both ratios are closer to one.

Near is where the bodies touch, or would overlap without deformation: the gap at first contact is
at most the approach. Under a sphere this is √2 times the Hertz radius.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.cautions import (
    Caution,
    CautionTag,
    as_caution,
    as_note,
    as_warning,
    merge_cautions,
    no_checksums,
    sort_cautions,
)
from roughcontact.contact import hertz_comparison
from roughcontact.contact.ceiling import area_change, recommended_ceiling
from roughcontact.contact.result import BASE, CALIBRATED, CalibratedCeiling, ContactResult, Regime
from roughcontact.contact.spots import MIN_SPOT_PIXELS, Spots
from roughcontact.errors import ArgumentRef, Part
from roughcontact.material.material import softer_material
from roughcontact.solvers.progress import Status
from roughcontact.surface import roughness
from roughcontact.surface.cleaning import fill_mode
from roughcontact.surface.surface import Surface
from roughcontact.theory import indenters
from roughcontact.units import count_noun, format_engineering, format_percent, plain_decimal

TRANSITION = 2.0
"""Ratio of the load to that of first yield from which residual indentations are compared."""

# Ratios of residual depth and energy between calibrated ceiling and volume model: 1.0 to 1.3 and
# 1.2 to 1.5, on spheres and rough maps from 4 times the load of first yield on
# (calibration/ceiling_rule.py).
_DEPTH, _ENERGY = 1.1, 1.3

# Ratio below which, and inverse above which, the two have little in common.
_MIN_RESIDUAL_RATIO = 0.5


def ratio_to_elastoplastic(advice: CalibratedCeiling, ceiling: float) -> tuple[float, float]:
    """Return the ratio of a sphere's residual indentation to that of the volume model."""
    depth, energy = _residual_sphere(advice, ceiling)
    usual_depth, usual_energy = _residual_sphere(advice, advice.ceiling)
    return _DEPTH * depth / usual_depth, _ENERGY * energy / usual_energy


def _residual_sphere(advice: CalibratedCeiling, ceiling: float) -> tuple[float, float]:
    """Return residual depth and energy of a sphere, in units independent of the ceiling."""
    share = ceiling / advice.first_yield
    depth, energy = indenters.residual_indentation(advice.load_ratio / share**3)
    return depth * share**2, energy * share**5


def indentation_caution(advice: CalibratedCeiling, ceiling: float) -> Caution | None:
    """Return the caution on the residual indentation if it differs from volume plasticity."""
    if advice.load_ratio < TRANSITION:
        return None
    depth, energy = ratio_to_elastoplastic(advice, ceiling)
    severe = (
        min(depth, energy) < _MIN_RESIDUAL_RATIO or max(depth, energy) > 1 / _MIN_RESIDUAL_RATIO
    )
    return (as_warning if severe else as_caution)(
        CautionTag.INDENTATION,
        f"Indentation is about {depth:.1f}, energy {energy:.1f} times that of the elastoplastic "
        f"model. Exact: {ArgumentRef('rc.solve_elastoplastic, then unload')}.",
        indentation_over_volume=depth,
        energy_over_volume=energy,
        load_ratio=advice.load_ratio,
        recommended_ceiling=advice.ceiling,
    )


LARGE_STRAIN, MAX_STRAIN = 0.1, 0.3
"""Pressure over contact modulus, of the order of the strain; plastic strain.

Above the first linear elasticity is inaccurate, above the second its pressures are meaningless.
"""

MISSING_FRACTION = 0.05
"""Share of missing or filled points from which results do not represent the surface."""

ATOM_SPACING = 0.25e-9
"""Distance of neighboring atoms in a solid [m]."""

MIN_ATOMS = 1000
"""Number of atoms in contact, about 9 nm across, below which a spot is no continuum.

The area of smaller spots is wrong by a factor of two and more (Luan and Robbins, Nature 435 (2005)
929, doi:10.1038/nature03700).
"""

WORK_OF_ADHESION = 0.05
"""Work of adhesion of bodies in air [J/m²], with usual contamination and water."""

MIN_ROUGHNESS = 10e-9
"""Roughness [m] of nearly every body in waves too short for its map.

It prevents adhesion between bodies that stretch by less before they separate (Fuller and Tabor,
Proc. R. Soc. A 345 (1975) 327, doi:10.1098/rspa.1975.0138), hence between all smooth metals and
ceramics. Below a pixel it is at most a tenth of the pixel.
"""

CAUTION_GROWTH, WARNING_GROWTH = 1.1, 1.5
"""Area growth by adhesion that gives a caution, and a warning."""


def filled_caution(result: ContactResult) -> Caution | None:
    """Return the caution on many points that were filled instead of measured."""
    bodies = [body for body in (result.surface, result.counter_surface) if body is not None]
    share = max(body.provenance.filled_share(body.heights.size) for body in bodies)
    if share <= MISSING_FRACTION:
        return None
    return as_warning(
        CautionTag.MOSTLY_FILLED,
        f"{format_percent(share)} of the {result.pair.whole} is filled, not measured: contact "
        f"there is invented. Crop it, or use {ArgumentRef('missing', 'mask')}.",
        filled=share,
    )


def strain_caution(result: ContactResult) -> Caution | None:
    """Return the caution on pressures that strain the bodies beyond linear elasticity."""
    ratio = result.max_pressure / result.contact_modulus
    if not ratio > LARGE_STRAIN:
        return None
    severe = ratio > MAX_STRAIN
    effect = "Pressures are unreliable, areas are" if severe else "Numbers are"
    return (as_warning if severe else as_caution)(
        CautionTag.STRAIN,
        f"Peak pressure is {_ratio_text(ratio)} E*: beyond linear elasticity. {effect} estimates.",
        strain=ratio,
    )


def _ratio_text(ratio: float) -> str:
    """Return a ratio as the beginning of a product."""
    return f"{format_percent(ratio)} of" if ratio <= 1 else f"{ratio:.3g} times"


def atom_caution(result: ContactResult) -> Caution | None:
    """Return the caution on spots that have too few atoms to be a continuum."""
    spots = result.spots()
    if spots.count == 0:
        return None
    size = spots.load_weighted_median(spots.area)
    count = size / ATOM_SPACING**2
    if not count < MIN_ATOMS:
        return None
    return as_warning(
        CautionTag.FEW_ATOMS,
        f"Half the load is on spots of about {plain_decimal(max(count, 1), 2)} atoms "
        f"({1e18 * size:.3g} nm²) or fewer: no continuum. Numbers are estimates.",
        atoms=count,
    )


def adhesion_caution(result: ContactResult) -> Caution | None:
    """Return the caution on neglected adhesion of the spots that carry half of the load."""
    spots, modulus, work = result.spots(), result.contact_modulus, WORK_OF_ADHESION
    carrying = spots.load > 0
    if not carrying.any() or result.contact.all() or result.pair.is_coated:
        return None
    load = np.where(carrying, spots.load, np.inf)
    radius = 4 * modulus * (spots.area / np.pi) ** 1.5 / (3 * load)
    drawn = indenters.ADHESION_RANGE * np.maximum(indenters.tabor(radius, modulus, work), 1.0)
    felt = carrying & (drawn > min(MIN_ROUGHNESS, 0.1 * min(result.surface.pixel)))
    grown, pull = np.ones(load.shape), np.zeros(load.shape)
    grown[felt] = indenters.enlargement(load[felt], radius[felt], modulus, work)
    pull[felt] = indenters.pull_off(radius[felt], modulus, work) / load[felt]
    times, share = spots.load_weighted_median(grown), spots.load_weighted_median(pull)
    if not times > CAUTION_GROWTH:
        return None
    return (as_warning if times > WARNING_GROWTH else as_caution)(
        CautionTag.ADHESION,
        f"Adhesion is not modeled: at {format_engineering(work, 'J/m²')} the contact area grows "
        f"{times:.3g} times, pull-off takes {_ratio_text(share)} the load.",
        enlargement=times,
        pull_off_over_load=share,
    )


def material_cautions(result: ContactResult) -> Caution | None:
    """Return the cautions on materials whose behavior no contact model here includes."""
    names: dict[str, dict[str, None]] = {}
    for body in (result.material, result.counter_material):
        if body.caveat:
            names.setdefault(body.caveat, {})[body.name or "the body"] = None
    if not names:
        return None
    text = " and ".join(
        f"{' and '.join(bodies)} {'is' if len(bodies) == 1 else 'are'} {caveat}"
        for caveat, bodies in names.items()
    )
    return as_warning(
        CautionTag.MATERIAL, f"{text[0].upper()}{text[1:]}. Numbers hold for the constants given."
    )


LARGE_SLOPE = 0.3
"""Root-mean-square slope at which the error of order slope² is about 10 %."""


CEILING_ERROR = 0.05
"""Relative distance from the calibrated ceiling from which a caution is shown."""

MIN_AREA_CHANGE = 0.005
"""Relative change of the contact area below which two ceilings are equivalent."""

CAUTION_AREA_CHANGE = 0.1
"""Relative change of the contact area under the calibrated ceiling that is a caution."""

IMPLAUSIBLE_SLOPE = 3.0
"""Root-mean-square slope that no measured map has: steeper than 70 degrees everywhere."""

MODULUS_RANGE = (1e6, 2e12)
"""Range of Young's moduli of solids [Pa], from soft rubber to beyond diamond."""

STRENGTH_RANGE = (1e-6, 0.3)
"""Range of yield strength over Young's modulus: soft crystals to beyond ideal strength."""

MAX_SIDE = 10.0
"""Side [m] longer than any measured map."""

SHOWN_CONTACT = 0.3
"""Share of a map in contact above which neighboring spots confine each other."""

SHOWN_SPHERE, SHOWN_ROUGH, SHOWN_HARDENING, SHOWN_CONFINED = 0.05, 0.09, 0.08, 0.09
"""Largest area errors with the calibrated ceiling: spheres and lines, maps, hardening, and periodic
maps with more contact than `SHOWN_CONTACT`."""

SPIKY_KURTOSIS = 20.0
"""Kurtosis of heights beyond that of all manufacturing processes.

It is 3 for Gaussian heights, 2 to 10 for machined and worn surfaces, about 15 for deep grooves
honed into a plateau; nine measured maps have 2 to 5 without their spikes, and 52 to 811 with them.
"""

SPIKY_PEAK = 10.0
"""Height of the highest spike above the median, in robust standard deviations.

The maximum of 10⁹ Gaussian heights is 6 above the median. Pits increase the kurtosis as well, but
have no contact.
"""

SPIKE_LEAD, SPIKE_LOAD = 0.5, 0.1
"""Lead of the first spot relative to the approach, and its share of the load, for a spike.

A real summit that leads by half of the approach has the highest pressure and carries much of the
load.
"""

UNEVEN_LOAD, MUCH_PERIODIC_LOAD = 2.0, 0.5
"""Load near edges that differ over an even one that gives a caution; its share, a warning."""

MIN_PERIODIC_STEP = 0.5
"""Difference of opposite edges over Sq that gives a caution."""

EDGE_LOAD, MUCH_EDGE_LOAD = 0.001, 0.01
"""Load shares at the map edge that give a caution, and that affect the approach."""


@dataclass(frozen=True)
class Check:
    """Plausibility check of a solution."""

    subject: str  # Name in the list of performed checks
    cautions_of: Callable[[ContactResult], Caution | None]
    when: Callable[[ContactResult], bool] = lambda _: True


def cautions(result: ContactResult) -> tuple[Caution, ...]:
    """Return the cautions on a contact, the most severe first."""
    requested = (check.cautions_of(result) for check in CHECKS if check.when(result))
    return sort_cautions(
        [*(caution for caution in requested if caution is not None), *result.extra_cautions]
    )


def performed_checks(result: ContactResult) -> tuple[str, ...]:
    """Return the names of the checks that were performed on a solution."""
    return tuple(check.subject for check in CHECKS if check.when(result))


def over_loads(
    result: Sequence[tuple[float, Iterable[Caution]]], unit: str, noun: str = "loads"
) -> tuple[Caution, ...]:
    """Return merged cautions of several contacts: one per tag, with its range of values."""
    return merge_cautions(
        [(format_engineering(value, unit, 3), text) for value, text in result], noun
    )


def load_bearing_spot_pixels(result: ContactResult, spots: Spots) -> int:
    """Return the pixels per spot that spots with half of the load have or exceed."""
    if spots.count == 0:
        return 0
    return round(spots.load_weighted_median(spots.area) / result.pixel_area)


def recommended_ceiling_of(result: ContactResult) -> CalibratedCeiling | None:
    """Return the calibrated ceiling if the spots are large enough to determine it."""
    pair = result.pair
    if pair.is_profile or load_bearing_spot_pixels(result, result.spots()) < MIN_SPOT_PIXELS:
        return None
    advice = recommended_ceiling(result)
    # A map with free edges sinks in before its nominal pressure reaches the ceiling.
    if advice is None or advice.ceiling * result.touchable_area < result.load:
        return None
    return advice


def deviating_ceiling(result: ContactResult) -> CalibratedCeiling | None:
    """Return the calibrated ceiling if it changes the contact area noticeably."""
    if not isinstance(result.ceiling, float) or result.calibration is not None:
        return None
    advice = recommended_ceiling_of(result)
    if advice is None or result.regime is Regime.BELOW_FIRST_YIELD:
        return None
    return advice if abs(calibrated_area_change(result, advice)) >= MIN_AREA_CHANGE else None


def other_ceiling(result: ContactResult) -> float | None:
    """Return the second ceiling of a contact [Pa]: calibrated, or for a calibrated one 3 σ_Y."""
    if result.calibration is None:
        advice = deviating_ceiling(result)
        return None if advice is None else advice.ceiling
    usual = result.calibration.usual_ceiling
    change = result.calibration.usual_contact_area / result.contact_area - 1
    return usual if abs(change) >= MIN_AREA_CHANGE else None


def calibrated_area_change(result: ContactResult, advice: CalibratedCeiling) -> float:
    """Return the relative change of the contact area under the calibrated ceiling."""
    ceiling = result.ceiling
    assert ceiling is None or isinstance(ceiling, float)
    change = area_change(advice, ceiling, result.contact_modulus)
    # The spheres of the rule have room to grow; a map is at most in full contact.
    return min(change, result.touchable_area / result.contact_area - 1)


def _check_convergence(result: ContactResult) -> Caution | None:
    if result.converged:
        return None
    more: tuple[Part, ...] = ()
    if result.status == Status.CONVOLUTION_LIMIT.value:
        more = (" Increase ", ArgumentRef("max_iterations"), ".")
    return as_warning(
        CautionTag.NOT_CONVERGED,
        f"Not converged: certificate {result.certificate:.1e}, limit {result.tolerance:.0e}. Do "
        "not use these numbers.",
        *more,
        certificate=result.certificate,
        tolerance=result.tolerance,
    )


def edge_caution(result: ContactResult) -> Caution | None:
    """Return the caution on a contact that reaches an edge at which the map ends."""
    share = result.totals.edge_load
    if share is None or share < EDGE_LOAD:
        return None
    smooth, whole, advice = result.hertz, result.pair.whole, beyond_edge(result)
    action: tuple[Part, ...] = (f"Measure a larger {whole}.",)
    if advice is not None:
        kind = f"Sample of a larger {'face' if smooth is None else 'roller'}?"
        action = (f"{kind} Use ", advice, ".")
    return (as_warning if share > MUCH_EDGE_LOAD else as_caution)(
        CautionTag.EDGE,
        f"{format_percent(share)} of the load is at the {whole} edge. ",
        *action,
        edge_load=share,
    )


def _check_periodic_edges(result: ContactResult) -> Caution | None:
    """Return the message on a periodic map whose opposite edges differ."""
    found = find_periodic_step(result)
    if found is None:
        return None
    uneven = found.load > UNEVEN_LOAD * found.area and found.step > MIN_PERIODIC_STEP
    severe = uneven and found.load > MUCH_PERIODIC_LOAD
    action: tuple[Part, ...] = ()
    if uneven:
        advice = (f"Measure a larger {result.pair.whole}.",)
        action = (" ", *(advice if _is_form_removed(result.surface) else _LEVEL_QUADRIC))
    return (as_warning if severe else as_caution if uneven else as_note)(
        CautionTag.PERIODIC_EDGE,
        f"{format_percent(found.load)} of the load is within {format_percent(found.width)} "
        f"of edges that differ by {found.step:.2g} Sq.",
        *action,
        edge_load=found.load,
        step_over_sq=found.step,
        even_load=found.area,
    )


_LEVEL_QUADRIC = ("Use ", ArgumentRef("level", "quadric"), ".")


def _is_form_removed(surface: Surface) -> bool:
    return any(
        step.method in ("without_form", "filtered") or step.arguments.get("form") == "quadric"
        for step in surface.provenance.operations
    )


def beyond_edge(result: ContactResult) -> ArgumentRef | None:
    """Return the boundary for a sample of a larger face or roller; None for other bodies."""
    if result.hertz is None:
        return ArgumentRef("boundary", "periodic")
    axis = result.hertz.shape.axis
    if axis is None or axis in result.boundary.periodic_axes:
        return None
    return ArgumentRef("boundary", f"periodic-{'yx'[axis]}")


def _below_ceiling(result: ContactResult) -> Caution | None:
    body = result.pair.softer
    if result.regime not in _BEYOND or body is None or body.ceiling is None:
        return None
    # With both strengths known, the hardness is the lower one, see `_check_hardness`.
    mixed = body.tabor_ratio is not None
    limit = (body.hardness if mixed else None) or body.ceiling
    what = "the hardness" if mixed or body.yield_strength is None else "3σ_Y"
    known = "auto" if body.yield_strength is None else CALIBRATED
    return as_warning(
        CautionTag.ABOVE_CEILING,
        f"Peak pressure {format_engineering(result.max_pressure, 'Pa', 3)} is "
        f"{result.max_pressure / limit:.3g} times {what}: contact area is too small. Use ",
        ArgumentRef("ceiling", format_engineering(limit, "Pa", 4) if mixed else known),
        ".",
        ratio=result.max_pressure / limit,
        max_pressure=result.max_pressure,
    )


_BEYOND = (Regime.BEYOND_CEILING, Regime.BEYOND_HARDNESS)


def _check_resolution(result: ContactResult) -> Caution | None:
    pixels = load_bearing_spot_pixels(result, result.spots())
    if not 0 < pixels < MIN_SPOT_PIXELS:
        return None
    whole = result.pair.whole
    return as_warning(
        CautionTag.PIXEL,
        f"Half the load is on spots of {count_noun(pixels, 'pixel')} or fewer: "
        f"{'length' if result.pair.is_profile else 'area'} and pressure need a finer {whole}.",
        carrying_pixels=pixels,
    )


def _check_slopes(result: ContactResult) -> Caution | None:
    slope = rms_slope(result)
    if (mistaken := _implausible_slope(slope, "RMS slope at the contact is")) is not None:
        return mistaken
    if not slope >= LARGE_SLOPE:
        return None
    return as_caution(
        CautionTag.SLOPES,
        f"RMS slope at the contact {slope:.2g} exceeds {LARGE_SLOPE:g}: small-slope theory is 10 % "
        "off or more. Numbers are estimates.",
        rms_slope=slope,
    )


def map_cautions(surface: Surface) -> tuple[Caution, ...]:
    """Return the cautions on a leveled map that hold in every contact."""
    slope = roughness.median_gradient(surface.heights, surface.pixel)
    steep = _implausible_slope(slope, "Half of the map is steeper than")
    found = (steep, spike_caution(surface))
    return sort_cautions(caution for caution in found if caution is not None)


def _implausible_slope(slope: float, what: str) -> Caution | None:
    """Return the message on a slope that no measured map has."""
    if not slope >= IMPLAUSIBLE_SLOPE:
        return None
    return as_warning(
        CautionTag.UNITS,
        f"{what} {slope:.3g} ({math.degrees(math.atan(slope)):.0f}°): no real surface is this "
        "steep. Check unit and missing points.",
        slope=slope,
    )


def _range_adjective(value: float, ends: tuple[float, float], low: str, high: str) -> str:
    """Return the adjective for a value outside a range; empty inside."""
    return low if value < ends[0] else high if value > ends[1] else ""


def _check_units(result: ContactResult) -> Caution | None:
    """Return the caution on a value that appears to be in another unit."""
    for body in (result.material, result.counter_material):
        E, strength = body.young, body.yield_strength
        if math.isinf(E):
            continue
        if kind := _range_adjective(E, MODULUS_RANGE, "soft", "stiff"):
            return as_warning(
                CautionTag.UNITS,
                f"Young's modulus is {format_engineering(E, 'Pa', 3)}: no solid is this {kind}. "
                "Give the "
                'unit, for example "210 GPa".',
                young=E,
            )
        share = STRENGTH_RANGE[0] if strength is None else strength / E
        if kind := _range_adjective(share, STRENGTH_RANGE, "weak", "strong"):
            return as_warning(
                CautionTag.UNITS,
                f"Yield strength is {share:.2g} of Young's modulus: no solid is this {kind}. "
                "Check both units.",
                yield_over_young=share,
            )
    side = max(result.pair.size[result.pair.is_profile :])
    if side > MAX_SIDE:
        return as_warning(
            CautionTag.UNITS,
            f"The {result.pair.whole} is {format_engineering(side, 'm', 3)} long: its unit is "
            "probably smaller. Give the unit of the lengths.",
            side=side,
        )
    return None


def _check_ceiling(result: ContactResult) -> Caution | None:
    """Return the caution on a ceiling that differs from the calibrated one."""
    ceiling, body = result.ceiling, softer_material(result.material, result.counter_material)
    if ceiling is None or isinstance(ceiling, np.ndarray) or body is None:
        return None
    # At most one caution about the ceiling.
    if result.regime in _BEYOND:
        return None
    known = result.calibration
    if known is not None and math.isnan(known.mismatch):
        reason = "the calibrated one does not carry the load"
        if math.isnan(known.load_ratio):
            reason = "single pixels and flats have no slope to calibrate it"
        return as_caution(CautionTag.CEILING, f"Ceiling stays at {known.factor:.3g} σ_Y: {reason}.")
    if known is not None or body.tabor_ratio is not None:
        return None
    answer = recommended_ceiling_of(result)
    if answer is None or answer.load_ratio < TRANSITION:
        return None
    too_high = min(ceiling, result.max_pressure) > (1 + CEILING_ERROR) * answer.ceiling
    too_low = result.saturated_fraction > 0 and ceiling < (1 - CEILING_ERROR) * answer.ceiling
    if not (too_high or too_low):
        return None
    change, calibrated = calibrated_area_change(result, answer), answer.ceiling
    # The severity is that of the rule: the same in every command, with and without a second solve.
    severity = as_caution if abs(change) >= CAUTION_AREA_CHANGE else as_note
    if (other := result.calibrated) is not None and not other.is_of_base:
        change, calibrated = other.contact_area / result.contact_area - 1, other.ceiling
    excess = ceiling / calibrated - 1
    effect = f"{100 * abs(change):.2g} % {('more' if change > 0 else 'less')} contact area"
    # The rule is that of a given load.
    is_known = other is not None or result.control == "load"
    return severity(
        CautionTag.CEILING,
        f"Ceiling {format_engineering(ceiling, 'Pa', 3)} is {100 * abs(excess):.0f} % "
        f"{('above' if excess > 0 else 'below')} the calibrated one"
        f"{f', which gives {effect}' if is_known else ''}. Use "
        f"{ArgumentRef('ceiling', CALIBRATED)}.",
        area_change=change,
        recommended_ceiling=calibrated,
        load_ratio=answer.load_ratio,
    )


def _check_extrapolation(result: ContactResult) -> Caution | None:
    fraction = result.contact_fraction
    if not (fraction > SHOWN_CONTACT and math.isnan(shown_error(result))):
        return None
    if result.calibration is None and recommended_ceiling_of(result) is None:
        return None
    return as_note(
        CautionTag.CEILING_EXTRAPOLATED,
        f"Calibrated ceiling is extrapolated: it was tested up to {100 * SHOWN_CONTACT:.0f} % "
        f"contact, here {100 * fraction:.0f} %.",
        contact_fraction=fraction,
    )


def shown_error(result: ContactResult) -> float:
    """Return the validated relative error of the area with the calibrated ceiling."""
    bodies = [body for body in (result.material, result.counter_material) if body.yield_strength]
    if any(body.poisson < 0 for body in bodies):
        return math.nan
    hardens, rough = any(body.hardens for body in bodies), result.spots().count > 1
    if result.contact_fraction > SHOWN_CONTACT:
        # A periodic map nearly in full contact has one spot, and is no sphere.
        if not result.boundary.free_axes:
            return math.nan if hardens else SHOWN_CONFINED
        if rough:
            return math.nan
    return SHOWN_HARDENING if hardens else SHOWN_ROUGH if rough else SHOWN_SPHERE


def _check_coating(result: ContactResult) -> Caution | None:
    """Return the caution on an indentation deeper than the coating."""
    thinnest = min(
        sum(layer.thickness for layer in body.coating)
        for body in (result.material, result.counter_material)
        if body.coating
    )
    depth = result.totals.max_indentation
    if depth <= thinnest:
        return None
    return as_caution(
        CautionTag.THIN_COATING,
        f"Indentation {format_engineering(depth, 'm', 3)} exceeds the coating of "
        f"{format_engineering(thinnest, 'm', 3)}: it tears, and the base carries. Use "
        f"{ArgumentRef('ceiling', BASE)}.",
        ratio=depth / thinnest,
    )


def _check_hardness(result: ContactResult) -> Caution | None:
    """Return the caution on a yield strength too high for the hardness of the softer body."""
    ceiling, body = result.ceiling, softer_material(result.material, result.counter_material)
    if ceiling is None or isinstance(ceiling, np.ndarray) or body is None:
        return None
    ratio, hardness = body.tabor_ratio, body.hardness
    if ratio is None or hardness is None or result.regime in _BEYOND:
        return None
    if not result.max_pressure > (1 + 1e-9) * hardness:
        return None
    return as_caution(
        CautionTag.HARDNESS,
        f"3σ_Y is {ratio:.2g} times the hardness of {body.name or 'the softer body'}, "
        "which no contact exceeds. Use ",
        ArgumentRef("ceiling", format_engineering(hardness, "Pa", 4)),
        ".",
        ratio=ratio,
        three_yield_strengths=ratio * hardness,
        hardness=hardness,
    )


def _check_spikes(result: ContactResult) -> Caution | None:
    for surface in (result.surface, result.counter_surface):
        caution = None if surface is None else spike_caution(surface)
        if caution is not None:
            return caution
    return _first_touch(result)


def spike_caution(surface: Surface) -> Caution | None:
    """Return the message on a map whose heights look like spikes on a surface."""
    answer = spike_statistics(surface)
    if answer is None:
        return None
    kurtosis, peak = answer
    return as_warning(
        CautionTag.SPIKES,
        f"Measurement spikes: kurtosis {kurtosis:.3g}, highest point {peak:.3g} robust σ above "
        f"median. {_remove_spikes(surface)}.",
        kurtosis=kurtosis,
        peak=peak,
    )


def _remove_spikes(*surfaces: Surface | None) -> str:
    """Return how to remove spikes: with all options that it takes."""
    steps = [step.method for body in surfaces if body for step in body.provenance.operations]
    if "without_outliers" in steps:
        # Wider than the window of the median.
        return f"Cut them away with {ArgumentRef('crop')}"
    share = max(body.missing / body.heights.size for body in surfaces if body)
    return f"Remove with {ArgumentRef('outliers', 6.0)} {ArgumentRef('missing', fill_mode(share))}"


def _first_touch(result: ContactResult) -> Caution | None:
    """Return the caution for first contact on a spike that carries almost no load."""
    answer, gap = result.spots(), result.initial_gap
    first = int(np.nanargmin(gap))
    number = int(answer.label.flat[first])
    others = (answer.label > 0) & (answer.label != number)
    if number == 0 or not others.any():
        return None
    lead = float(gap[others].min() - gap.flat[first])
    pixels = round(float(answer.area[number - 1]) / result.pixel_area)
    share = float(answer.load[number - 1] / answer.load.sum())
    if pixels >= MIN_SPOT_PIXELS or share > SPIKE_LOAD or lead < SPIKE_LEAD * result.approach:
        return None
    deepest = float(result.residual_indentation.max())
    own = deepest > 0 and deepest == result.residual_indentation.flat[first]
    part = f"{format_percent(min(lead / result.approach, 1.0))} of the approach"
    effect = f" with {part} and the deepest indentation" if own else f": {part} is its flattening"
    return as_warning(
        CautionTag.SPIKES,
        f"First contact is a {pixels}-pixel spike{effect}. "
        f"{_remove_spikes(result.surface, result.counter_surface)}.",
        lead=lead,
        spike_load=share,
    )


def spike_statistics(surface: Surface) -> tuple[float, float] | None:
    """Return kurtosis and highest peak of a map whose heights contain spikes."""
    heights = surface.heights
    kurtosis = surface.Sku
    if not kurtosis > SPIKY_KURTOSIS:
        return None
    middle = float(np.nanmedian(heights))
    deviation = 1.4826 * float(np.nanmedian(np.abs(heights - middle)))
    if deviation == 0:
        return None
    peak = (float(np.nanmax(heights)) - middle) / deviation
    return (kurtosis, peak) if peak > SPIKY_PEAK else None


def _check_missing(result: ContactResult) -> Caution | None:
    missing, share = missing_points(result)
    if not missing:
        return None
    return (as_note if share < MISSING_FRACTION else as_caution)(
        CautionTag.MISSING,
        f"{format_percent(share)} of the points near the contact is missing and cannot touch: "
        "contact area may be low.",
        share=share,
        missing=missing,
    )


CHECKS = (
    Check("convergence", _check_convergence),
    Check("contact at the edges", edge_caution, lambda r: bool(r.boundary.free_axes)),
    Check(
        "opposite edges of a periodic map",
        _check_periodic_edges,
        lambda r: bool(r.boundary.periodic_axes),
    ),
    Check(
        "pressure against the strength of the softer body",
        _below_ceiling,
        lambda r: r.regime is not Regime.UNKNOWN,
    ),
    Check("size of the spots in pixels", _check_resolution),
    Check("units of moduli, strengths and lengths", _check_units),
    Check("slopes", _check_slopes),
    Check("strains", strain_caution),
    Check("number of atoms in contact", atom_caution, lambda r: not r.pair.is_profile),
    Check("adhesion", adhesion_caution, lambda r: not r.pair.is_profile),
    Check("material behavior outside the model", material_cautions),
    Check(
        "the ceiling against plasticity of the volume",
        _check_ceiling,
        lambda r: r.ceiling is not None and not isinstance(r.ceiling, np.ndarray),
    ),
    Check("indentation against the coating", _check_coating, lambda r: r.pair.is_coated),
    Check(
        "the range of the calibrated ceiling",
        _check_extrapolation,
        lambda r: isinstance(r.ceiling, float) and r.regime is not Regime.BELOW_FIRST_YIELD,
    ),
    Check(
        "the yield strength against the hardness",
        _check_hardness,
        lambda r: (
            r.pair.softer is not None
            and None not in (r.pair.softer.yield_strength, r.pair.softer.hardness)
        ),
    ),
    Check("spikes of the measurement", _check_spikes),
    Check("filled points", filled_caution),
    Check("missing points", _check_missing),
    Check(
        "Hertz's theory behind the load",
        hertz_comparison.hertz_load_note,
        hertz_comparison.behind_load,
    ),
    Check(
        "curvature of the measured map",
        hertz_comparison.measured_form_caution,
        hertz_comparison.has_measured_map,
    ),
    Check("checksums of its file", lambda _: no_checksums(), lambda r: r.without_checksums),
)

EDGE_WIDTH = 0.05
"""Part of a side that is near an edge."""

# Points along a side below which one of them is too much of it.
_MIN_POINTS = 8

# Step between opposite edges over that between neighbors, from which the map is not periodic.
_SEAM = 2.0


def points_near_contact(result: ContactResult) -> NDArray[np.bool_]:
    """Return the measured points inside or near the contact, shape (ny, nx)."""
    return (result.initial_gap <= result.approach) | result.contact


def rms_slope(result: ContactResult) -> float:
    """Return the RMS slope of both bodies together from points near the contact to neighbors.

    NaN if no such point has both neighbors.
    """
    near = points_near_contact(result)
    if near.shape[0] == 1:
        near = np.repeat(near, 2, axis=0)
    counted = near[1:, 1:] | near[:-1, 1:] | near[1:, :-1]
    row, total, count = 0, 0.0, 0
    for squares in roughness.squared_gradients(result.initial_gap, result.pair.pixel):
        known = squares[counted[row : row + len(squares)] & ~np.isnan(squares)]
        row, total, count = row + len(squares), total + float(known.sum()), count + known.size
    return math.sqrt(total / count) if count else math.nan


@dataclass(frozen=True)
class PeriodicStep:
    """Step between opposite edges of a periodic map, and the load near them."""

    step: float  # Largest rms step over the standard deviation of the gap
    width: float  # Part of a side next to an edge: `EDGE_WIDTH` or one point
    load: float  # Share of the load near these edges
    area: float  # Share of the area near these edges, hence of an even load


def find_periodic_step(result: ContactResult) -> PeriodicStep | None:
    """Return the step between opposite edges along periodic axes; None where the map has none."""
    gap, pressure = result.initial_gap, result.pressure
    deviation, steps, widths = float(np.nanstd(gap)), [], []
    inner = [slice(None), slice(None)]
    for axis in result.boundary.periodic_axes:
        points = gap.shape[axis]
        if points < _MIN_POINTS:
            continue
        seam = _rms(np.take(gap, 0, axis) - np.take(gap, -1, axis))
        if seam > _SEAM * _rms(np.diff(gap, axis=axis)):
            steps.append(seam / deviation)
            near = max(1, round(EDGE_WIDTH * points))
            inner[axis] = slice(near, points - near)
            widths.append(near / points)
    total = float(pressure.sum())
    if not steps or total == 0:
        return None
    part = pressure[tuple(inner)]
    load, area = 1 - float(part.sum()) / total, 1 - part.size / gap.size
    return PeriodicStep(max(steps), max(widths), load, area)


def _rms(values: NDArray[np.float64]) -> float:
    known = values[~np.isnan(values)]
    return float(np.sqrt(np.mean(np.square(known)))) if known.size else math.nan


def missing_points(result: ContactResult) -> tuple[int, float]:
    """Return the number of missing points near the contact, and their share of all there.

    A missing point is near if the next measured point is.
    """
    missing = math.prod(result.pair.shape) - result.totals.points
    if not missing:
        return 0, 0.0
    from scipy import ndimage

    near, absent = points_near_contact(result), np.isnan(result.initial_gap)
    nearest = ndimage.distance_transform_edt(
        absent, result.pair.pixel, return_distances=False, return_indices=True
    )
    count = int(np.count_nonzero(near[tuple(nearest)] & absent))
    return count, count / max(count + int(np.count_nonzero(near)), 1)
