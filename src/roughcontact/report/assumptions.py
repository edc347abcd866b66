"""What a result takes for granted, in words: statements for readers who did not run it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.contact import imprint, judgment
from roughcontact.contact.cautions import Caution, Kind
from roughcontact.contact.history import VOLUME_ACCOUNT, LoadHistory
from roughcontact.contact.judgment import LARGE_SLOPE, SMALL_SLOPE, carrying_pixels
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import FEW_PIXELS, Spots
from roughcontact.contact.validity import LARGE_STRAIN
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material, contact_modulus, softer
from roughcontact.report import wording
from roughcontact.report.page import joined, sentence
from roughcontact.report.wording import is_rigid
from roughcontact.units import counted, engineering, percent

if TYPE_CHECKING:
    from roughcontact.volume.result import ElastoplasticResult


@dataclass(frozen=True)
class Statement:
    """One assumption, and whether it is in doubt.

    Parameters
    ----------
    topic : str
        What it is about, in two or three words.
    text : str
        The assumption with the numbers of the case at hand; sentences.
    kinds : tuple of Kind
        Of the cautions that put it in doubt, where the result has them.
    """

    topic: str
    text: str
    kinds: tuple[Kind, ...] = ()

    def doubts(self, cautions: Iterable[Caution]) -> str:
        """Return why this assumption is in doubt, in sentences; empty if it is not."""
        return joined(*(sentence(c.text) for c in cautions if c.kind in self.kinds))


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
    """Return what a result assumes, for the case at hand.

    Parameters
    ----------
    result : ContactResult
        A solution.
    spots : Spots
        Its contact spots.
    history : LoadHistory, optional
        The path of which the result is one stage.

    Returns
    -------
    tuple of Statement
        Geometry, slopes, strains, friction and adhesion, yielding, resolution, loading; missing
        points and single precision where there are any.
    """
    found = [
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
        found.append(
            Statement(
                "Single precision",
                "The transforms were computed with seven digits instead of sixteen, which saves "
                f"memory; the certificate asked for is {result.tolerance:.0e}.",
            )
        )
    return tuple(statement for statement in found if statement.text)


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
    """Return the error, over the slope, of leaving out that bodies move sideways.

    Of the load on a cone, after Hay, Bolshakov and Pharr 1999, eq. (12), to first order; of the
    half-width under a cylinder, after Johnson 1985, eq. (2.24a). Both are in proportion to
    Dundurs' β (Johnson, eq. 5.3), of which they have that against a rigid body.
    """
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
        (Kind.STRAINS,),
    )


def _yielding(result: ContactResult, history: LoadHistory | None) -> Statement:
    both = (result.material, result.counter_material)
    if result.ceiling is None:
        return elastic(*both)
    if result.saturated_fraction == 0:
        return limited(wording.ceiling(result), *both, reached=False)
    kept = result.residual_indentation if history is None else history.indentation
    deepest = engineering(float(kept.max()), "m", 3)
    item = limited(wording.ceiling(result), *both, reached=True, kept=f", up to {deepest},")
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
    return Statement("No yielding", text, (Kind.BEYOND_CEILING,))


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
    bodies = (result.material, result.counter_material)
    found = imprint.doubt(advice, result.ceiling, any(body.hardens for body in bodies))
    return "" if found is None else sentence(found.text)


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
    """Return the statement on what the map resolves; `volume` where bodies yield."""
    dy, dx = (engineering(edge, "m", 3) for edge in result.surface.pixel)
    pixels = carrying_pixels(result, spots)
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
    corrected = (result if volume is None else volume).corrected_contact_area
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
    doubts = (Kind.RESOLUTION, Kind.STUDY, Kind.MEASUREMENT)
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
    return Statement("Missing points", " ".join(parts), (Kind.FILLED, Kind.MISSING))


def loading(result: ContactResult) -> Statement:
    """Return the statement on one loading."""
    if result.control == "load":
        given = "The load was given, and the approach follows from it. "
    else:
        given = "The approach was given, and the load is what the pressure adds up to. "
    if result.moments is None:
        given += "The bodies are pressed together without tilting. "
    else:
        given += "The bodies tilt until the pressure balances the moments that were given. "
    return one_loading(given)


def one_loading(given: str) -> Statement:
    """Return the statement on a load that was given, in sentences, and is applied once."""
    return Statement(
        "One loading",
        f"{given}It is applied once, slowly, to the surfaces as prepared: earlier passes, "
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
