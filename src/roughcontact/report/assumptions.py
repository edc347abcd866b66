"""What a result takes for granted, in words: statements for readers who did not run it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from roughcontact.cautions import Caution, Kind
from roughcontact.contact import plausibility as judgment
from roughcontact.contact.plausibility import (
    LARGE_SLOPE,
    LARGE_STRAIN,
    SMALL_SLOPE,
    indentation_caution,
    load_bearing_spot_pixels,
)
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import FEW_PIXELS, Spots
from roughcontact.elastoplastic.plausibility import largest_strain, perfectly_plastic, slope_under
from roughcontact.elastoplastic.result import ElastoplasticResult
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.hardening import Kinematic
from roughcontact.material.material import Material, contact_modulus, softer
from roughcontact.report import phrases
from roughcontact.report.page import joined, sentence
from roughcontact.report.phrases import is_rigid
from roughcontact.studies.load_history import VOLUME_ACCOUNT, LoadHistory
from roughcontact.studies.sampling_study import Sample
from roughcontact.units import counted, engineering, percent


@dataclass(frozen=True)
class Statement:
    """One assumption, and whether it is in doubt."""

    topic: str  # What it is about, in two or three words
    text: str  # The assumption with the numbers of the case at hand
    kinds: tuple[Kind, ...] = ()  # Of the cautions that put it in doubt, where the result has them

    def doubts(self, cautions: Iterable[Caution]) -> str:
        """Return why this assumption is in doubt, in sentences; empty if it is not."""
        return joined(*(c.text for c in cautions if c.kind in self.kinds))


FILLED = (
    "Points that were not measured were filled with a smooth surface through the rim of their "
    "hole. It lies between the lowest and the highest height of that rim, and is an "
    "interpolation, not a measurement."
)
FLAT = Statement(
    "Flat counter-body",
    "The counter-body is perfectly smooth and flat. Its own roughness, if it has any, would have "
    "to be measured and given.",
)
FRICTIONLESS = Statement(
    "No friction, no adhesion",
    "The bodies press on each other at right angles to the plane of the map. Friction, and with "
    "it the small sliding of unlike materials against each other, is left out. The bodies do not "
    "attract each other: the pressure is never negative. Adhesion matters for compliant or very "
    "smooth bodies under small loads.",
)


def statements(
    result: ContactResult, spots: Spots, history: LoadHistory | None = None
) -> tuple[Statement, ...]:
    """Return what a result assumes, for the case at hand."""
    answer = [
        half_spaces(result.boundary, elastic_half_spaces(result.material, result.counter_material)),
        bodies(result),
        slopes(result),
        strains(result.max_pressure / result.contact_modulus),
        FRICTIONLESS,
        _yielding(result, history),
        resolution(result, spots),
        holes(result),
        loading(result) if history is None else _path(history),
    ]
    if result.precision == "single":
        answer.append(
            Statement(
                "Single precision",
                "The transforms were computed with seven digits instead of sixteen, which saves "
                f"memory; the certificate asked for is {result.tolerance:.0e}.",
            )
        )
    return tuple(statement for statement in answer if statement.text)


def elastic_half_spaces(material: Material, counter_material: Material) -> str:
    """Return which bodies deform, without a full stop."""
    if is_rigid(material):
        return "The counter-body is an elastic half-space, the body with this map is rigid"
    if is_rigid(counter_material):
        return "The body is an elastic half-space, the counter-body is rigid"
    return "Both bodies are elastic half-spaces"


def half_spaces(boundary: Boundary, who: str) -> Statement:
    """Return the statement on half-spaces and the boundary of the map."""
    text = (
        f"{who}: every spot is pressed into material that goes on without end below and beside "
        "it, isotropic and the same everywhere. The part has to be thick and wide compared with "
        "the contact; coatings, thin walls and edges are not in the model. "
    )
    return Statement(boundary.heading, text + boundary.assumption, (Kind.EDGE,))


def bodies(result: ContactResult) -> Statement:
    """Return the statement on what the counter-body is."""
    if result.counter_surface is None:
        return FLAT
    return Statement(
        "Two measured bodies",
        "The two maps are laid on each other point by point, as they are; only the sum of their "
        "heights counts. Another position of one on the other would give other spots, with "
        "similar statistics.",
    )


def slopes(result: ContactResult) -> Statement:
    """Return the statement on small slopes."""
    pair = result.pair
    whole = pair.whole
    whose = f"of this {whole}" if result.counter_surface is None else f"of both {whole}s together"
    return small_slopes(
        pair.rms_slope, whose, pair.material, pair.counter_material, profile=pair.is_profile
    )


def small_slopes(
    slope: float,
    whose: str,
    material: Material,
    counter_material: Material,
    *,
    profile: bool = False,
) -> Statement:
    """Return the statement on a root-mean-square slope, and whose it is."""
    if math.isnan(slope):
        return Statement("Small slopes", "Slopes are taken as small; this map has none to judge.")
    sideways = _sideways(material, counter_material, profile)

    def error(slope: float) -> float:
        return sideways * slope + slope**2 / 2

    total = percent(min(error(slope), 1.0))
    if slope < SMALL_SLOPE:
        verdict = f"{total}, which is small"
    elif slope < LARGE_SLOPE:
        verdict = f"about {total}, which is noticeable"
    else:
        verdict = f"about {total}: the slopes are not small"
    spot = "width of a spot under a cylinder" if profile else "load on a cone"
    if sideways:
        errors = (
            f"Two errors follow: about half its square, {percent(min(slope**2 / 2, 1.0))}, of "
            f"shapes and areas; and, in proportion to it, {percent(min(sideways * slope, 1.0))} of "
            f"the {spot} of this slope, since the bodies also move sideways, by different amounts, "
            f"which the theory leaves out. Together they are {verdict}. They begin"
        )
    else:
        errors = (
            f"The error of shapes and areas is about half its square, here {verdict}. It begins"
        )
    return Statement(
        "Small slopes",
        f"The theory takes slopes as small against 1. The root-mean-square slope {whose} is "
        f"{slope:.3g} ({math.degrees(math.atan(slope)):.2g}°). {errors} to matter at a slope of "
        f"{SMALL_SLOPE:g} ({100 * error(SMALL_SLOPE):.2g} %); above {LARGE_SLOPE:g} "
        f"({100 * error(LARGE_SLOPE):.2g} %) the results are estimates.",
        (Kind.SLOPES,),
    )


def _sideways(material: Material, counter_material: Material, profile: bool) -> float:
    """Return the error, over the slope, of leaving out that bodies move sideways."""
    first, second = (
        (1 - 2 * body.poisson) * (1 + body.poisson) / body.young
        for body in (material, counter_material)
    )
    dundurs = abs(first - second) * contact_modulus(material, counter_material) / 2
    cone = 2 / math.pi * (0.15483073 + 0.83119312)
    return dundurs * (math.pi / 4 if profile else cone)


def strains(ratio: float) -> Statement:
    """Return the statement on small strains, by the largest pressure over the contact modulus."""
    return Statement(
        "Small strains",
        "Stress and strain are proportional (Hooke's law). Strains are of the order of the "
        f"pressure over the contact modulus, at most {ratio:.2g} here; "
        + (
            f"linear elasticity ends well below {LARGE_STRAIN:g}."
            if ratio > LARGE_STRAIN
            else "this is small."
            if ratio < 0.2 * LARGE_STRAIN
            else "this is not very small."
        ),
        (Kind.STRAIN,),
    )


def _yielding(result: ContactResult, history: LoadHistory | None) -> Statement:
    both = (result.material, result.counter_material)
    if result.ceiling is None:
        return elastic(*both)
    if result.saturated_fraction == 0:
        return limited(phrases.ceiling(result), *both, reached=False)
    indentation = result.residual_indentation if history is None else history.indentation
    deepest = engineering(float(indentation.max()), "m", 3)
    item = limited(phrases.ceiling(result), *both, reached=True, kept=f", up to {deepest},")
    return replace(item, text=joined(item.text, _left_behind(result)))


def elastic(material: Material, counter_material: Material) -> Statement:
    """Return the statement on pressures that nothing limits."""
    body = softer(material, counter_material)
    text = (
        "The solution is purely elastic: nothing limits the pressure, which on sharp peaks "
        "can exceed what any material bears."
    )
    if body is None:
        return Statement("No yielding", f"{text} No yield strength was given.")
    text = f"{text} {_first_yield(body)}".strip()
    return Statement("No yielding", text, (Kind.ABOVE_CEILING,))


def limited(
    ceiling: str,
    material: Material,
    counter_material: Material,
    *,
    reached: bool,
    kept: str = "",
) -> Statement:
    """Return the statement on a ceiling, in words, and how much is kept of what overlaps."""
    body = softer(material, counter_material)
    text = f"The pressure may not exceed a ceiling ({ceiling}). "
    if not reached:
        text += "It is reached nowhere: the solution is the elastic one."
        text += f" {_first_yield(body)}" if body else ""
        return Statement("Yielding", text.strip(), (Kind.CEILING, Kind.HARDNESS))
    text += (
        "Points at the ceiling are called saturated: the material there flows, and the part by "
        f"which it overlaps the counter-body{kept} is kept as a permanent indentation. "
        "Where the displaced material goes, the residual stress that it leaves and hardening are "
        "not in the model: the ceiling stands in for plasticity."
    )
    if body is not None and body.yield_strength is None:
        text += (
            " The hardness is the mean pressure under an indenter, at the end of yielding: smaller "
            "spots, in the transition from elastic to fully plastic, bear less than that, and "
            "their area is larger than shown."
        )
    elif body is not None:
        text += (
            " That the pressure levels off near three yield strengths is Tabor's finding (1951) "
            "for full indentation. The mean pressure on a perfectly plastic sphere of Poisson's "
            "ratio 0.3 is 2.17, 2.41, 2.61 and 2.77 yield strengths at 40, 120, 300 and 700 times "
            "the load of first yield. In this transition a ceiling of three yield strengths is up "
            "to 35 % too high, and the contact area up to 26 % too small; three are right to 5 % "
            "where E*a/(σ_Y R) exceeds about 56 (a: radius of a spot, R: radius of its summit). "
            + _first_yield(body)
        )  # fmt: skip
    doubts = (Kind.CEILING, Kind.HARDNESS)
    return Statement("The ceiling stands in for plasticity", text, doubts)


def _left_behind(result: ContactResult) -> str:
    """Return how far permanent indentation and dissipation are from plasticity of the volume."""
    advice = judgment.advice(result)
    if advice is None or not isinstance(result.ceiling, float):
        return ""
    answer = indentation_caution(advice, result.ceiling)
    return "" if answer is None else answer.text


def _first_yield(body: Material) -> str:
    if body.first_yield_pressure is None:
        return ""
    return (
        "Yielding begins earlier, and below the surface: for a sphere of the softer material at a "
        f"peak pressure of {engineering(body.first_yield_pressure, 'Pa', 3)} "
        "(1.295 exp(0.736 ν) σ_Y, Jackson and Green 2005)."
    )


def resolution(
    result: ContactResult, spots: Spots, volume: ElastoplasticResult | None = None
) -> Statement:
    """Return the statement on what the map resolves; `elastoplastic` where bodies yield."""
    dy, dx = (engineering(edge, "m", 3) for edge in result.surface.pixel)
    pixels = load_bearing_spot_pixels(result, spots)
    text = (
        f"The pressure is constant on each pixel of {dy} × {dx} (y × x), and roughness finer than "
        "that is not in the map. On a rough surface a finer map has less contact area and higher "
        "elastic pressures: both are values at this pixel. "
    )
    if volume is not None and volume.plastic_volume:
        text += "Where a spot flows, its strength bounds the pressure on any map. "
    elif result.saturated_fraction > 0:
        text += "The ceiling bounds the largest pressure on any map. "
    else:
        text += "The largest pressure is the most sensitive to the pixel. "
    corrected = (result if volume is None else volume).perimeter_corrected_area
    rim = "at the rim of a spot" if volume is None else "at the elastic rim of a spot"
    small, large = (engineering(area, "m²", 3) for area in (corrected, result.contact_area))
    change = "not changed in three digits" if small == large else f"{small} instead of {large}"
    if pixels >= FEW_PIXELS:
        # Of fewer the caution says so.
        text += f"Half of the load is carried by spots of {counted(pixels, 'pixel')} or more. "
    text += (
        f"Pixels {rim} count in full; without this excess (Yastrebov, Anciaux and Molinari 2017) "
        f"the contact area is {change}."
    )
    doubts = (Kind.PIXEL, Kind.STUDY, Kind.RESOLUTION)
    return Statement("Resolution", text, doubts)


def holes(result: ContactResult) -> Statement:
    """Return the statement on missing points, empty if there are none."""
    missing = int(np.count_nonzero(np.isnan(result.gap)))
    bodies = [body for body in (result.surface, result.counter_surface) if body is not None]
    filled = any(
        step.method == "filled" for body in bodies for step in body.provenance.operations
    )  # fmt: skip
    parts = []
    if missing:
        part = f"{percent(missing / result.gap.size)} of the {result.pair.whole}"
        parts.append(
            f"{counted(missing, 'point')} ({part}) "
            f"{'was' if missing == 1 else 'were'} not measured. Such points are taken as never "
            "touching; the load that they might carry lies on the others."
        )
    if filled:
        parts.append(FILLED)
    return Statement("Missing points", " ".join(parts), (Kind.MOSTLY_FILLED, Kind.MISSING))


def loading(result: ContactResult) -> Statement:
    """Return the statement on one loading."""
    if result.control == "load":
        specified = "The load was given, and the approach follows from it. "
    else:
        specified = "The approach was given, and the load is what the pressure adds up to. "
    if result.moments is None:
        specified += "The bodies are pressed together without tilting. "
    else:
        specified += "The bodies tilt until the pressure balances the moments that were given. "
    return one_loading(specified)


def one_loading(specified: str) -> Statement:
    """Return the statement on a load that was given, in sentences, and is applied once."""
    return Statement(
        "One loading",
        f"{specified}It is applied once, slowly, to the surfaces as prepared: earlier passes, "
        "unloading, sliding, creep and wear are not in it.",
    )


def _path(history: LoadHistory) -> Statement:
    return Statement(
        "A path of loads",
        f"The bodies are pressed together in {counted(len(history.steps), 'stage')}, one after the "
        "other and slowly, without tilting; each stage begins with the indentation that those "
        "before it left. Saturated points sink in for good, unloading is elastic. Moves to another "
        f"position are free of friction. {sentence(VOLUME_ACCOUNT)}",
    )


# What a comparison of maps takes for granted: that of each contact, worded for all of them.


def comparison_statements(samples: Sequence[Sample]) -> tuple[Statement, ...]:
    """Return what is assumed of each of several maps under the same nominal pressure."""
    curve, (material, counter_material) = samples[0].curve, samples[0].bodies
    slopes = [item.curve.rms_gradient for item in samples if math.isfinite(item.curve.rms_gradient)]
    steepest = max(slopes, default=math.nan)
    pressure = max(item.numbers["max_pressure"] for item in samples)
    result = (
        half_spaces(curve.boundary, elastic_half_spaces(material, counter_material)),
        FLAT,
        small_slopes(steepest, "of the steepest map", material, counter_material),
        strains(pressure / curve.contact_modulus),
        FRICTIONLESS,
        _assumptions_compared_yielding(samples),
        _resolution(samples),
        _holes(samples),
        one_loading("The load on each map is the nominal pressure times its area. "),
    )
    return tuple(statement for statement in result if statement.text)


def _assumptions_compared_yielding(samples: Sequence[Sample]) -> Statement:
    ceiling, bodies = samples[0].curve.ceiling, samples[0].bodies
    if ceiling is None:
        return elastic(*bodies)
    reached = any(item.numbers["saturated_fraction"] > 0 for item in samples)
    return limited(phrases.limit(ceiling, *bodies), *bodies, reached=reached)


def _resolution(samples: Sequence[Sample]) -> Statement:
    edges = [edge for item in samples for edge in item.pixel]
    small, large = (engineering(edge, "m", 3) for edge in (min(edges), max(edges)))
    return Statement(
        "Resolution",
        f"The pressure is constant on each pixel, of {small}"
        + (f" to {large}" if small != large else "")
        + " along a side, and roughness finer than that is not in the maps. On a rough surface a "
        "finer map has less contact area and higher elastic pressures: maps are compared at the "
        "waves that they show.",
        (Kind.PIXEL, Kind.STUDY, Kind.RESOLUTION),
    )


def _holes(samples: Sequence[Sample]) -> Statement:
    methods = {
        step.method
        for item in samples
        for origin in item.curve.origins
        for step in origin.operations
    }
    parts = [FILLED] if "filled" in methods else []
    if "masked" in methods:
        parts.append(
            "Points that were not measured are taken as never touching; the load that they might "
            "carry lies on the others."
        )
    return Statement("Missing points", " ".join(parts), (Kind.MOSTLY_FILLED, Kind.MISSING))


# --- What a result on profiles takes for granted, in words ---


LIMITS = Statement(
    "What a profile cannot know",
    "A profile is pressed as if the body went on alike along y without end, as ridges that are "
    "straight and level do: turned or ground surfaces across their lay, and these only as far as "
    "their ridges reach. The part of the profile that touches is a length, and not the real "
    "contact area of a surface: a surface that is rough in both directions touches on summits, at "
    "other loads and over another area. Whether contact closes a way for a fluid cannot be seen in "
    "a profile either: in one line any touch closes it, on a surface there are ways around.",
)
"""What is said with every contact of a profile."""

_FRICTIONLESS = Statement(
    "No friction, no adhesion",
    "The bodies press on each other across the line of the profile. Friction, and with it the "
    "small sliding of unlike materials against each other, is left out. The bodies do not attract "
    "each other: the pressure is never negative.",
)


def profile_statements(result: ContactResult, spots: Spots) -> tuple[Statement, ...]:
    """Return what a result on profiles assumes, for the case at hand."""
    answer = (
        LIMITS,
        _plane_strain(result),
        bodies(result),
        slopes(result),
        strains(result.max_pressure / result.contact_modulus),
        _FRICTIONLESS,
        _assumptions_profile_yielding(result),
        _assumptions_profile_resolution(result, spots),
        holes(result),
        loading(result),
    )
    return tuple(statement for statement in answer if statement.text)


def _plane_strain(result: ContactResult) -> Statement:
    who = elastic_half_spaces(result.material, result.counter_material)
    text = (
        f"{who}, loaded alike along y without end: plane "
        "strain. The part has to be thick and wide compared with the contact, isotropic and the "
        "same everywhere; coatings, thin walls and edges are not in the model. "
    )
    return Statement("Half-spaces in plane strain", text + half_plane(result), (Kind.EDGE,))


def _assumptions_profile_yielding(result: ContactResult) -> Statement:
    kinds = (Kind.CEILING, Kind.HARDNESS, Kind.ABOVE_CEILING)
    first = result.pair.first_to_yield
    begins = ""
    if first is not None:
        pressure = engineering(result.pair.yields_at(first) or 0.0, "Pa", 3)
        begins = (
            f" Yielding begins earlier: for a cylinder at a peak pressure of {pressure} (Green "
            "2005)."
        )
    if result.ceiling is None:
        return Statement(
            "No yielding",
            "The solution is purely elastic: nothing limits the pressure, which on sharp peaks "
            f"can exceed what any material bears.{begins}",
            kinds,
        )
    text = f"The pressure may not exceed a ceiling ({phrases.ceiling(result)}). "
    if result.saturated_fraction == 0:
        text += "It is reached nowhere: the solution is the elastic one."
    else:
        text += (
            "Points at the ceiling flow, and the part by which they overlap the counter-body is "
            "kept. Where that material goes, residual stress and hardening are not in the model."
        )
    text += (
        " That pressures level off near three yield strengths is known of indenters and of spots "
        "of a surface; ridges in plane strain level off a little lower, near 2.97 yield strengths "
        "by von Mises for a flat one (Prandtl)."
    )
    return Statement("The ceiling stands in for plasticity", text + begins, kinds)


def _assumptions_profile_resolution(result: ContactResult, spots: Spots) -> Statement:
    spacing, pixels = (
        engineering(result.surface.pixel[1], "m", 3),
        load_bearing_spot_pixels(result, spots),
    )
    text = (
        f"The pressure is constant over the {spacing} from point to point, and roughness finer "
        "than that is not in the profile: a finer one touches on less of its length, at higher "
        "elastic pressures. "
    )
    if pixels >= FEW_PIXELS:
        text += f"Half of the load is carried by segments of {counted(pixels, 'point')} or more. "
    text += "A segment counts up to one point too long."
    return Statement("Resolution", text, (Kind.PIXEL, Kind.STUDY, Kind.RESOLUTION))


def half_plane(result: ContactResult) -> str:
    """Return the assumption on what lies beyond a profile, in sentences."""
    if result.boundary is Boundary.PERIODIC:
        return (
            "The profile is one period of an endless one, and the load is that on one period. A "
            "measured profile does not fit its own other end; the seam is then a step that the "
            "surface does not have. The approach counts from the mean line of the deformed body."
        )
    length = engineering(result.surface.size[1], "m", 3)
    return (
        "The profile is all that touches. A line load displaces a half-space without bound, so "
        "the approach of a free profile is known but for a constant: here a line load displaces "
        f"nothing at a distance of the length of the profile, {length}. Approach and stiffness "
        "depend on that; pressures, contact length and gap under a given load do not."
    )


# --- What a result of the volume model takes for granted, in words ---


def volume_statements(result: ElastoplasticResult, spots: Spots) -> tuple[Statement, ...]:
    """Return what a result of the volume model assumes, for the case at hand."""
    contact = result.solution
    answer = [
        half_spaces(contact.boundary, _yielding_half_spaces(result)),
        bodies(contact),
        slopes(contact),
        _small_deformations(result),
        _hardening(result),
        _rolling(result) if result.has_moved else FRICTIONLESS,
        _layers(result),
        resolution(contact, spots, result) if contact.load else Statement("", ""),
        holes(contact),
        _assumptions_volume_path(result),
    ]
    if result.precision == "single":
        answer.append(
            Statement(
                "Single precision of the volume",
                "Strain and stress in the volume were computed with seven digits instead of "
                "sixteen, the contact with sixteen; pressures change by about a part in 100 000.",
            )
        )
    return tuple(statement for statement in answer if statement.text)


def _yielding_half_spaces(result: ElastoplasticResult) -> str:
    def kind(body: Material) -> str:
        if is_rigid(body):
            return "rigid"
        return "an elastic half-space" + (" that yields" if body.yield_strength else "")

    first, second = kind(result.solution.material), kind(result.solution.counter_material)
    if first == second:
        return "Both bodies are elastic half-spaces that yield"
    return f"The body with this map is {first}, the counter-body is {second}"


def _small_deformations(result: ElastoplasticResult) -> Statement:
    slope, strain = slope_under(result), largest_strain(result)
    text = (
        "Equilibrium is that of bodies that keep their shape, and strains are small: those of "
        "elasticity and plastic flow add up. The largest plastic strain is "
        f"{percent(strain)}. "
    )
    if math.isfinite(slope):
        text += (
            f"The root-mean-square slope under the contact is {slope:.3g}, which for a sphere of "
            f"radius R is that of a spot of radius a = {math.sqrt(2) * slope:.2g} R. "
        )
    return Statement(
        "Small strains",
        f"{text}Strain and slope should stay below about {LARGE_STRAIN:g}; from a/R = 0.16 on "
        "large deformations change what a sphere carries (Mesarovic and Fleck 1999).",
        (Kind.PLASTIC_STRAIN,),
    )


_ISOTROPIC = (
    "grows with the accumulated plastic strain, the same in all directions: that metals yield "
    "earlier after a reversal of the load (Bauschinger effect) is left out."
)
_KINEMATIC = (
    "is measured from a back stress in proportion to the plastic strain (Prager), so that metal "
    "yields earlier after a reversal of the load (Bauschinger effect). In truth the back stress "
    "saturates: where strains are large, or their mean creeps on from cycle to cycle, a "
    "proportional one hides it."
)


def _hardening(result: ElastoplasticResult) -> Statement:
    kinematic = any(isinstance(body.material.hardening, Kinematic) for body in result.bodies)
    text = (
        "Metal flows where the von Mises stress reaches the yield strength, without changing its "
        "volume. The strength "
        + (_KINEMATIC if kinematic else _ISOTROPIC)
        + " It does not depend on speed, time or temperature; there is no creep, no fracture and "
        "no change of phase."
    )
    if perfectly_plastic(result):
        text += (
            " A perfectly plastic field has too few freedoms for the pressure of single pixels: "
            "it scatters by 5 to 10 %, more at the rim of spots. Means over 3 × 3 pixels or over "
            "spots are right; a little hardening removes the scatter."
        )
    return Statement(
        "Kinematic hardening" if kinematic else "Isotropic hardening",
        text,
        (Kind.HARDENING_RANGE, Kind.PIXEL_SCATTER),
    )


def _layers(result: ElastoplasticResult) -> Statement:
    body = result.bodies[0]
    thin, thick = (engineering(h, "m", 3) for h in (body.thickness[0], body.thickness[-1]))
    text = (
        f"Strain and stress are averages over layers, {thin} thick at the surface and {thick} at "
        f"the bottom, {engineering(float(body.thickness.sum()), 'm', 3)} down; in the plane they "
        "are values at the centres of pixels. Peaks narrower than that are cut."
    )
    if body.margin:
        text += (
            f" The volume goes on {counted(body.margin, 'pixel')} beyond each edge of the map, "
            "and the body without end."
        )
    return Statement("Layers", text)


def _of_steps(result: ElastoplasticResult) -> str:
    error = result.step_error
    if error is None:
        return "they were given, and the error that they make is not estimated"
    return f"they make an error of about {100 * error:.2g} % of approach and contact area"


def _way(result: ElastoplasticResult) -> str:
    if not result.has_moved:
        return "The bodies are pressed together without tilting or sliding."
    return (
        "The counter-surface moved over the body without tilting, and plastic strain stays at its "
        "place in each body: where nothing pulls, one rolls over the other without slip."
    )


def _rolling(result: ElastoplasticResult) -> Statement:
    """Return what is taken for granted where the counter-surface moved or pulled."""
    largest = max(step.friction for step in result.increments)
    pull = (
        f"The counter-surface pulls with up to {largest:.3g} of the pressure, at full sliding "
        "everywhere in the contact. That a traction also moves surfaces up and down where the "
        "bodies differ in their elastic constants is left out."
        if largest
        else "The counter-surface rolls freely: there is no traction at all in the contact."
    )
    return Statement(
        "Rolling and sliding",
        f"{pull} A contact that sticks in one part and slips in another, as under a driving or "
        "braking torque, and the spin of a ball about the normal are left out. Nor are there "
        "inertia, a lubricant or heat. The bodies do not attract each other.",
        (Kind.CYLINDER_SLIDES,),
    )


def _assumptions_volume_path(result: ElastoplasticResult) -> Statement:
    loads = [step.load for step in result.increments]
    if not loads:
        return Statement("", "")
    turns = any(later < earlier for earlier, later in itertools.pairwise(loads))
    text = (
        f"The load was changed slowly, in {counted(len(loads), 'increment')}, up to "
        f"{engineering(max(loads), 'N')}"
        + (f", and ended at {engineering(loads[-1], 'N')}. " if turns else ". ")
        + "The result depends on this path, and on the size of its increments: "
        f"{_of_steps(result)}. {_way(result)} They were free of stress before: residual stress of "
        "machining is not in it."
    )
    return Statement("Path of loads", text, (Kind.RESIDUAL_YIELD, Kind.STEP_LENGTH))
