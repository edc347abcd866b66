"""What a result of the volume model takes for granted, in words."""

from __future__ import annotations

import itertools
import math

from roughcontact.contact.cautions import Kind
from roughcontact.contact.spots import Spots
from roughcontact.contact.validity import LARGE_STRAIN
from roughcontact.material.hardening import Kinematic
from roughcontact.material.material import Material
from roughcontact.report.assumptions import (
    FRICTIONLESS,
    Statement,
    bodies,
    half_spaces,
    holes,
    resolution,
    slopes,
)
from roughcontact.report.wording import is_rigid
from roughcontact.units import counted, engineering, percent
from roughcontact.volume import judgment
from roughcontact.volume.result import ElastoplasticResult


def statements(result: ElastoplasticResult, spots: Spots) -> tuple[Statement, ...]:
    """Return what a result of the volume model assumes, for the case at hand.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    spots : Spots
        Its contact spots.

    Returns
    -------
    tuple of Statement
        Geometry, slopes, strains, hardening, friction and adhesion, resolution, loading; missing
        points and single precision where there are any.
    """
    contact = result.solution
    found = [
        half_spaces(contact.boundary, _yielding_half_spaces(result)),
        bodies(contact),
        slopes(contact),
        _small_deformations(result),
        _hardening(result),
        _rolling(result) if result.travelled else FRICTIONLESS,
        _layers(result),
        resolution(contact, spots, result) if contact.load else Statement("", ""),
        holes(contact),
        _path(result),
    ]
    if result.precision == "single":
        found.append(
            Statement(
                "Single precision of the volume",
                "Strain and stress in the volume were computed with seven digits instead of "
                "sixteen, the contact with sixteen; pressures change by about a part in 100 000.",
            )
        )
    return tuple(statement for statement in found if statement.text)


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
    slope, strain = judgment.slope_under(result), judgment.largest_strain(result)
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
        (Kind.PLASTIC_STRAINS,),
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
    if judgment.perfectly_plastic(result):
        text += (
            " A perfectly plastic field has too few freedoms for the pressure of single pixels: "
            "it scatters by 5 to 10 %, more at the rim of spots. Means over 3 × 3 pixels or over "
            "spots are right; a little hardening removes the scatter."
        )
    return Statement(
        "Kinematic hardening" if kinematic else "Isotropic hardening",
        text,
        (Kind.HARDENING, Kind.SCATTER),
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
    if not result.travelled:
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
        (Kind.AXIS,),
    )


def _path(result: ElastoplasticResult) -> Statement:
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
    return Statement("Path of loads", text, (Kind.RESIDUAL, Kind.WAY))
