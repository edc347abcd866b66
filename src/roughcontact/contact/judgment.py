"""What a contact is judged by before its numbers are believed: one check a question.

A check looks at a solution and returns the caution that it gives cause for, or none. Every face
of a result, from the console to the report, tells what `cautions` returns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from roughcontact.contact import hertzian, validity
from roughcontact.contact.advice import RECOMMENDED, RecommendedCeiling
from roughcontact.contact.cautions import (
    Caution,
    Kind,
    careful,
    edge,
    noted,
    ordered,
    unsealed,
    warned,
)
from roughcontact.contact.ceiling import area_change, recommended_ceiling
from roughcontact.contact.result import ContactResult, Regime
from roughcontact.contact.spots import FEW_PIXELS, Spots
from roughcontact.errors import Mention, parts_of
from roughcontact.material.material import softer
from roughcontact.surface.surface import Surface
from roughcontact.units import changed_by, counted, engineering, percent

SMALL_SLOPE, LARGE_SLOPE = 0.1, 0.3
"""Root-mean-square slopes at which the error of order slope² is 1 % and about 10 %."""

TRANSITION = 2.0
"""Load over that of first yield from which plastic flow shows in the contact area."""

CEILING_ERROR = 0.05
"""Distance of a ceiling from the recommended one that is worth a word."""

IMPLAUSIBLE_SLOPE = 3.0
"""Root-mean-square slope that no measured map has: it is steeper than 70 degrees all over."""

MODULI = (1e6, 2e12)
"""Young's moduli of solids [Pa], from soft rubber to beyond diamond."""

STRENGTHS = (1e-6, 0.3)
"""Yield strengths over Young's modulus, from pure soft metal crystals to beyond ideal strength."""

LONGEST_SIDE = 10.0
"""Side of a map [m] that nothing measures."""

SHOWN_CONTACT = 0.3
"""Share of a rough map in contact up to which the recommended ceiling was tried."""

SHOWN_SPHERE, SHOWN_ROUGH, SHOWN_HARDENING = 0.05, 0.09, 0.08
"""Largest errors of the area with the recommended ceiling: spheres and lines, maps, hardening."""

SPIKY_KURTOSIS = 20.0
"""Kurtosis of heights that no process of manufacture gives.

It is 3 of Gaussian heights, 2 to 10 of machined and worn surfaces, some 15 where deep grooves are
honed into a plateau; nine real maps have 2 to 5 without their spikes, and 52 to 811 with them.
"""

SPIKY_PEAK = 10.0
"""Robust standard deviations that the highest of spiky heights stands above their median.

The highest of 10⁹ Gaussian heights stands 6 above it. Pits make a large kurtosis as well, but do
not touch.
"""

SPIKE_LEAD, SPIKE_LOAD = 0.5, 0.1
"""Part of the approach that a first spot leads by, and of the load it bears, if it is a spike.

A summit that leads by half of the approach is pressed the most and bears much of the load.
"""

_LIMITS = {
    Regime.BEYOND_CEILING: "three times the yield strength",
    Regime.BEYOND_HARDNESS: "the hardness",
}


@dataclass(frozen=True)
class Check:
    """A question that a solution is asked.

    Parameters
    ----------
    subject : str
        What is looked at, for a list of what was checked.
    find : callable
        ``find(result)`` returns a `Caution`, or ``None`` where there is no cause for one.
    when : callable
        ``when(result)`` says whether the question can be asked at all.
    shared : bool
        Whether it can be asked where several processes hold the map.
    """

    subject: str
    find: Callable[[ContactResult], Caution | None]
    when: Callable[[ContactResult], bool] = lambda _: True
    shared: bool = False

    def applies(self, result: ContactResult) -> bool:
        """Return whether the question can be asked of a solution."""
        return (self.shared or not result.pair.is_shared) and self.when(result)


def cautions(result: ContactResult) -> tuple[Caution, ...]:
    """Return what a reader of a contact has to know, the severest first.

    Parameters
    ----------
    result : ContactResult
        A solution, or the best that was found.

    Returns
    -------
    tuple of Caution
        What the checks found, and what the result was given to remark.
    """
    asked = (check.find(result) for check in CHECKS if check.applies(result))
    return ordered([*(caution for caution in asked if caution is not None), *result.remarks])


def checked(result: ContactResult) -> tuple[str, ...]:
    """Return what a solution was looked at for, in a few words each."""
    return tuple(check.subject for check in CHECKS if check.applies(result))


def over_loads(
    found: Sequence[tuple[float, tuple[Caution, ...]]], unit: str
) -> tuple[Caution, ...]:
    """Return the cautions of a row of contacts, one of each kind.

    Parameters
    ----------
    found : sequence of (float, tuple of Caution)
        Load or approach and cautions of each, ascending.
    unit : str
        Of the first.

    Returns
    -------
    tuple of Caution
        That of the last contact which has it; where not all have it, with those that do.
    """
    once: dict[str, list[tuple[float, Caution]]] = {}
    for value, cautions_there in found:
        for caution in cautions_there:
            once.setdefault(caution.kind, []).append((value, caution))
    return ordered(_spread(told, len(found), unit) for told in once.values())


def _spread(told: list[tuple[float, Caution]], count: int, unit: str) -> Caution:
    (first, _), (last, caution) = told[0], told[-1]
    if len(told) == count:
        return caution
    where = f"at {engineering(first, unit)}"
    if len(told) > 1:
        where = f"at {len(told)} of {count} steps, {engineering(first, unit)} to "
        where += f"{engineering(last, unit)}; the last of them"
    return replace(caution, parts=(f"{where}: ", *caution.parts))


def carrying_pixels(result: ContactResult, spots: Spots) -> int:
    """Return how large the spots are that matter.

    Parameters
    ----------
    result : ContactResult
        A solution.
    spots : Spots
        Its contact spots.

    Returns
    -------
    int
        Pixels of the spot at which, going from the largest down, half of the load is reached.
    """
    if spots.count == 0:
        return 0
    return round(spots.halfway(spots.area) / result.pixel_area)


def advice(result: ContactResult) -> RecommendedCeiling | None:
    """Return the ceiling that is recommended, where the spots are large enough to be judged.

    None for profiles, too: what is known is known of the spots of a map; and where several
    processes hold the map, so that its spots are not known.
    """
    pair = result.pair
    if pair.is_profile or pair.is_shared or carrying_pixels(result, result.spots()) < FEW_PIXELS:
        return None
    return recommended_ceiling(result)


# The checks


def _convergence(result: ContactResult) -> Caution | None:
    if result.converged:
        return None
    return warned(
        Kind.NOT_CONVERGED,
        f"not converged: certificate {result.certificate:.1e}, tolerance {result.tolerance:.0e} (",
        *parts_of(result.status),
        ")",
        certificate=result.certificate,
        tolerance=result.tolerance,
    )


def at_edge(result: ContactResult, *more: str) -> Caution | None:
    """Return what is said of a contact that reaches an edge at which the map ends.

    Parameters
    ----------
    result : ContactResult
        A solution.
    *more : str
        What else is said where it does.
    """
    share = result.totals.edge_load
    return None if share is None else edge(result.pair.whole, share, *more)


def _below_ceiling(result: ContactResult) -> Caution | None:
    if result.regime not in _LIMITS:
        return None
    advice = "solve with a ceiling" if result.ceiling is None else "the ceiling lies above it"
    return warned(
        Kind.BEYOND_CEILING,
        f"the pressure exceeds {_LIMITS[result.regime]} of the softer body: {advice}",
        max_pressure=result.max_pressure,
    )


def _resolution(result: ContactResult) -> Caution | None:
    pixels = carrying_pixels(result, result.spots())
    if not 0 < pixels < FEW_PIXELS:
        return None
    return warned(
        Kind.RESOLUTION,
        f"half of the load is carried by spots of {counted(pixels, 'pixel')} or fewer: the "
        f"{result.pair.whole} does not resolve the contact, and "
        f"{'lengths' if result.pair.is_profile else 'areas'} and pressures depend on its pixel",
        carrying_pixels=pixels,
    )


def _slopes(result: ContactResult) -> Caution | None:
    slope = result.pair.rms_slope
    if (mistaken := heights_mistaken(slope)) is not None:
        return mistaken
    if not slope >= LARGE_SLOPE:
        return None
    return careful(
        Kind.SLOPES,
        f"the slopes are not small (root mean square {slope:.2g}, limit about "
        f"{LARGE_SLOPE:g}): read areas and pressures as estimates",
        rms_slope=slope,
    )


def heights_mistaken(slope: float) -> Caution | None:
    """Return what is said of heights whose root-mean-square slope is that of no measured map."""
    if not slope >= IMPLAUSIBLE_SLOPE:
        return None
    what = (
        f"the heights have a root-mean-square slope of {slope:.3g}, as no measured map has; their "
        "unit may be another, or some of them stand for missing points"
    )
    return _mistaken(what, _METRES, rms_slope=slope)


_METRES = "metres, so 1 µm is 1e-6 or '1 um'"


def _units(result: ContactResult) -> Caution | None:
    """Return which number looks as if it were in another unit than the one it is taken in."""
    for body, whose in (
        (result.material, "the body"),
        (result.counter_material, "the counter-body"),
    ):
        E, strength = body.young, body.yield_strength
        if math.isinf(E):
            continue
        if not MODULI[0] <= E <= MODULI[1]:
            what = f"Young's modulus of {whose} is {engineering(E, 'Pa')}, that of no solid"
            return _mistaken(what, "pascals, so 210 GPa are 210e9 or '210 GPa'", young=E)
        share = STRENGTHS[0] if strength is None else strength / E
        if not STRENGTHS[0] <= share <= STRENGTHS[1]:
            what = f"the yield strength of {whose} is {share:.2g} of its modulus, as in no solid"
            return _mistaken(what, "pascals, so 1 GPa is 1e9 or '1 GPa'", yield_over_young=share)
    side = max(result.pair.size[result.pair.is_profile :])
    if side > LONGEST_SIDE:
        what = f"the {result.pair.whole} is {engineering(side, 'm')} long"
        return _mistaken(what, _METRES, side=side)
    return None


def _mistaken(what: str, unit: str, **numbers: float) -> Caution:
    return warned(Kind.UNITS, f"{what}: numbers without a unit are taken in {unit}", **numbers)


def _ceiling(result: ContactResult) -> Caution | None:
    """Return which ceiling would be nearer to plasticity of the volume, if another one would.

    None if the numbers under that ceiling are there, if the ceiling is right to `CEILING_ERROR`, is
    not felt, or cannot be judged: a map of ceilings, spots of a few pixels.
    """
    ceiling, body = result.ceiling, softer(result.material, result.counter_material)
    if ceiling is None or isinstance(ceiling, np.ndarray) or body is None:
        return None
    # One caution about the ceiling at most: `_hardness` tells of numbers of two conditions.
    if result.calibrated is not None or result.recommended is not None or body.at_odds is not None:
        return None
    found = advice(result)
    if found is None or found.load_ratio < TRANSITION:
        return None
    too_high = min(ceiling, result.max_pressure) > (1 + CEILING_ERROR) * found.ceiling
    too_low = result.saturated_fraction > 0 and ceiling < (1 - CEILING_ERROR) * found.ceiling
    if not (too_high or too_low):
        return None
    change = area_change(found, ceiling, result.contact_modulus)
    return careful(
        Kind.CEILING,
        f"under the calibrated ceiling, {found.factor:.2f} yield strengths, the contact area "
        f"changes by about {changed_by(change)}: ",
        Mention("ceiling", RECOMMENDED),
        recommended_ceiling=found.ceiling,
        load_ratio=found.load_ratio,
        area_change=change,
    )


def shown_error(result: ContactResult) -> float:
    """Return how well the recommended ceiling gives the contact area, as a part of it.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    float
        Largest error of the area that was found beside plasticity of the volume, on contacts of
        its kind (see the page of assumptions); NaN where none was tried.
    """
    bodies = [body for body in (result.material, result.counter_material) if body.yield_strength]
    rough = result.spots().count > 1
    if any(body.poisson < 0 for body in bodies):
        return math.nan
    if rough and result.contact_fraction > SHOWN_CONTACT:
        return math.nan
    if any(body.hardens for body in bodies):
        return SHOWN_HARDENING
    return SHOWN_ROUGH if rough else SHOWN_SPHERE


def _hardness(result: ContactResult) -> Caution | None:
    """Return that the yield strength of the softer body is too high for its hardness."""
    ceiling, body = result.ceiling, softer(result.material, result.counter_material)
    if ceiling is None or isinstance(ceiling, np.ndarray) or body is None:
        return None
    ratio, hardness = body.at_odds, body.hardness
    if ratio is None or hardness is None or not result.max_pressure > (1 + 1e-9) * hardness:
        return None
    return careful(
        Kind.HARDNESS,
        f"three yield strengths of {body.name or 'the softer body'} are {ratio:.2g} times its "
        "hardness, which no contact exceeds: ",
        Mention("ceiling", engineering(hardness, "Pa", 4)),
        three_yield_strengths=ratio * hardness,
        hardness=hardness,
    )


def _spikes(result: ContactResult) -> Caution | None:
    for surface, whose in (
        (result.surface, f"the {result.pair.whole}"),
        (result.counter_surface, f"the {result.pair.whole} of the counter-body"),
    ):
        found = None if surface is None else spikes(surface)
        if found is not None:
            kurtosis, peak = found
            return careful(
                Kind.SPIKES,
                f"the heights of {whose} have a kurtosis of {kurtosis:.3g} (3 if Gaussian, some 2 "
                f"to 10 of machined surfaces), and the highest stands {peak:.3g} robust standard "
                "deviations above the median: unless the body has such peaks, spikes of the "
                "measurement touch in its place; take them out (without_outliers of the map, ",
                Mention("outliers", 6.0),
                ") and solve again",
                kurtosis=kurtosis,
                peak=peak,
            )
    return _first_touch(result)


def _first_touch(result: ContactResult) -> Caution | None:
    """Return what is said where the bodies touch first on a spike that bears next to nothing."""
    found, gap = result.spots(), result.initial_gap
    first = int(np.nanargmin(gap))
    number = int(found.label.flat[first])
    others = (found.label > 0) & (found.label != number)
    if number == 0 or not others.any():
        return None
    lead = float(gap[others].min() - gap.flat[first])
    pixels = round(float(found.area[number - 1]) / result.pixel_area)
    share = float(found.load[number - 1] / found.load.sum())
    if pixels >= FEW_PIXELS or share > SPIKE_LOAD or lead < SPIKE_LEAD * result.approach:
        return None
    kept = float(result.residual_indentation.max())
    own = kept > 0 and kept == result.residual_indentation.flat[first]
    return careful(
        Kind.SPIKES,
        f"the bodies touch first on a spike of {counted(pixels, 'pixel')}, which stands "
        f"{engineering(lead, 'm', 3)} above what touches next and bears {percent(share)} of the "
        f"load: {percent(min(lead / result.approach, 1.0))} of the approach is its flattening"
        f"{', and the deepest indentation is its own' if own else ''}; unless the body has such a "
        "peak take it out (without_outliers of the map, ",
        Mention("outliers", 6.0),
        ") and solve again",
        lead=lead,
        spike_load=share,
    )


def spikes(surface: Surface) -> tuple[float, float] | None:
    """Return kurtosis and highest peak of a map whose heights look like spikes on a surface.

    Parameters
    ----------
    surface : Surface
        A rough map.

    Returns
    -------
    (float, float) or None
        Sku, and the highest point above the median in robust standard deviations; None where
        either is that of a surface, or most of the map is flat and hence no measurement.
    """
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


def _missing(result: ContactResult) -> Caution | None:
    missing = math.prod(result.pair.shape) - result.totals.points
    if not missing:
        return None
    share = missing / math.prod(result.pair.shape)
    part = f"{percent(share)} of the {result.pair.whole}"
    was = "was" if missing == 1 else "were"
    said = noted if share < validity.MANY_MISSING else careful
    return said(
        Kind.MISSING,
        f"{counted(missing, 'missing point')} ({part}) {was} treated as never touching",
        missing=missing,
    )


def _ranks(result: ContactResult) -> Caution:
    return noted(
        Kind.RANKS,
        "the map lies on several ranks: what needs it in one process was not checked, such as "
        "spots, slopes, spikes and its spectrum",
    )


CHECKS = (
    Check("convergence", _convergence, shared=True),
    Check("ranks", _ranks, lambda r: r.pair.is_shared, shared=True),
    Check("contact at the edges", at_edge, lambda r: bool(r.boundary.free_axes), shared=True),
    Check(
        "pressure against the strength of the softer body",
        _below_ceiling,
        lambda r: r.regime is not Regime.UNKNOWN,
        shared=True,
    ),
    Check("size of the spots in pixels", _resolution),
    Check("units of moduli, strengths and lengths", _units, shared=True),
    Check("slopes", _slopes),
    Check("strains", validity.strains, shared=True),
    Check("number of atoms in contact", validity.atoms, lambda r: not r.pair.is_profile),
    Check("adhesion", validity.adhesion, lambda r: not r.pair.is_profile),
    Check("what the materials do that the model does not", validity.materials, shared=True),
    Check(
        "the ceiling against plasticity of the volume",
        _ceiling,
        lambda r: r.ceiling is not None and not isinstance(r.ceiling, np.ndarray),
    ),
    Check(
        "the yield strength against the hardness",
        _hardness,
        lambda r: (
            r.pair.softer is not None
            and None not in (r.pair.softer.yield_strength, r.pair.softer.hardness)
        ),
        shared=True,
    ),
    Check("spikes of the measurement", _spikes),
    Check("filled points", validity.filled),
    Check("missing points", _missing, shared=True),
    Check("Hertz's theory behind the load", hertzian.of_given_load, hertzian.behind_load),
    Check("checksums of its file", lambda _: unsealed(), lambda r: r.unsealed),
)
