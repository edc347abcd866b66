"""What a result on profiles takes for granted, in words."""

from __future__ import annotations

from roughcontact.contact.cautions import Kind
from roughcontact.contact.judgment import carrying_pixels
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import FEW_PIXELS, Spots
from roughcontact.halfspace.boundary import Boundary
from roughcontact.report import assumptions, wording
from roughcontact.report.assumptions import Statement
from roughcontact.units import counted, engineering

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


def statements(result: ContactResult, spots: Spots) -> tuple[Statement, ...]:
    """Return what a result on profiles assumes, for the case at hand.

    Parameters
    ----------
    result : ContactResult
        A contact of profiles.
    spots : Spots
        Its segments.

    Returns
    -------
    tuple of Statement
        What a profile cannot know, plane strain, then as for maps.
    """
    found = (
        LIMITS,
        _plane_strain(result),
        assumptions.bodies(result),
        assumptions.slopes(result),
        assumptions.strains(result.max_pressure / result.contact_modulus),
        _FRICTIONLESS,
        _yielding(result),
        _resolution(result, spots),
        assumptions.holes(result),
        assumptions.loading(result),
    )
    return tuple(statement for statement in found if statement.text)


def _plane_strain(result: ContactResult) -> Statement:
    who = assumptions.elastic_half_spaces(result.material, result.counter_material)
    text = (
        f"{who}, loaded alike along y without end: plane "
        "strain. The part has to be thick and wide compared with the contact, isotropic and the "
        "same everywhere; coatings, thin walls and edges are not in the model. "
    )
    return Statement("Half-spaces in plane strain", text + half_plane(result), (Kind.EDGE,))


def _yielding(result: ContactResult) -> Statement:
    kinds = (Kind.CEILING, Kind.HARDNESS, Kind.BEYOND_CEILING)
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
    text = f"The pressure may not exceed a ceiling ({wording.ceiling(result)}). "
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


def _resolution(result: ContactResult, spots: Spots) -> Statement:
    spacing, pixels = engineering(result.surface.pixel[1], "m", 3), carrying_pixels(result, spots)
    text = (
        f"The pressure is constant over the {spacing} from point to point, and roughness finer "
        "than that is not in the profile: a finer one touches on less of its length, at higher "
        "elastic pressures. "
    )
    if pixels >= FEW_PIXELS:
        text += f"Half of the load is carried by segments of {counted(pixels, 'point')} or more. "
    text += "A segment counts up to one point too long."
    return Statement("Resolution", text, (Kind.RESOLUTION, Kind.STUDY, Kind.MEASUREMENT))


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
