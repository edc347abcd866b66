"""What a result of the volume model takes for granted, in words."""

from __future__ import annotations

import itertools
import math

import numpy as np

from roughcontact.contact.spots import Spots
from roughcontact.material.hardening import Linear, Perfect, Tabulated
from roughcontact.material.material import Material
from roughcontact.report.assumptions import (
    FRICTIONLESS,
    LARGE_STRAIN,
    Statement,
    bodies,
    half_spaces,
    holes,
    resolution,
    slopes,
)
from roughcontact.report.wording import is_rigid
from roughcontact.units import counted, engineering, percent
from roughcontact.volume.body import law_of
from roughcontact.volume.result import ElastoplasticResult, PlasticBody

LARGE_DEFORMATION = 0.1
"""Root-mean-square slope under the contact, 0.7 a/R of a sphere.

From a/R = 0.16 on finite elements show large deformations under a sphere (Mesarovic and Fleck 1999,
doi:10.1098/rspa.1999.0423).
"""


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
        half_spaces(contact, _yielding_half_spaces(result)),
        bodies(contact),
        slopes(contact),
        _small_deformations(result),
        _hardening(result),
        FRICTIONLESS,
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


def cautions(result: ElastoplasticResult) -> tuple[str, ...]:
    """Return why the pressures of the volume model have to be read with care, if so.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    tuple of str
        One sentence each, without a full stop: on strains and hardening.
    """
    stated = _small_deformations(result), _hardening(result)
    return tuple(statement.caution for statement in stated if statement.caution)


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
    slope, strain = _slope_under(result), result.max_plastic_strain
    caution = ""
    if strain > LARGE_STRAIN:
        caution = (
            f"the largest plastic strain is {strain:.2g}, beyond the small strains of the model "
            f"(about {LARGE_STRAIN:g}): read strains and pressures there as estimates"
        )
    elif slope > LARGE_DEFORMATION:
        caution = (
            f"the slope under the contact is {slope:.2g}, beyond the small deformations of the "
            f"model (about {LARGE_DEFORMATION:g}): read areas and pressures as estimates"
        )
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
        caution,
    )


def _slope_under(result: ElastoplasticResult) -> float:
    """Return the root-mean-square slope of the first gap under contact or plastic strain."""
    gap = result.solution.initial_gap
    under = result.solution.contact
    if not under.any():
        ny, nx = gap.shape
        for body in result.bodies:
            inside = np.s_[:, body.margin : body.margin + ny, body.margin : body.margin + nx]
            under = under | body.accumulated[inside].any(axis=0)
    square = np.zeros(gap.shape)
    for slope in np.gradient(gap, *result.solution.surface.pixel):
        square += slope * slope
    known = square[under & np.isfinite(square)]
    return math.sqrt(float(known.mean())) if known.size else math.nan


def _hardening(result: ElastoplasticResult) -> Statement:
    text = (
        "Metal flows where the von Mises stress reaches the yield strength, without changing its "
        "volume. The strength grows with the accumulated plastic strain, the same in all "
        "directions: that metals yield earlier after a reversal of the load (Bauschinger effect) "
        "is left out. It does not depend on speed, time or temperature; there is no creep, no "
        "fracture and no change of phase."
    )
    yielding = [body.material for body in result.bodies]
    perfect = any(
        body.hardening is None
        or isinstance(body.hardening, Perfect)
        or (isinstance(body.hardening, Linear) and body.hardening.modulus == 0)
        for body in yielding
    )
    if perfect:
        text += (
            " A perfectly plastic field has too few freedoms for the pressure of single pixels: "
            "it scatters by 5 to 10 %, more at the rim of spots. Means over 3 × 3 pixels or over "
            "spots are right; a little hardening removes the scatter."
        )
    beyond = [
        body.material.hardening.strain[-1]
        for body in result.bodies
        if isinstance(body.material.hardening, Tabulated)
        and body.max_plastic_strain > body.material.hardening.strain[-1]
    ]
    caution = ""
    if beyond:
        caution = (
            f"the plastic strain exceeds {beyond[0]:.3g}, where the table of the yield strength "
            "ends: beyond it the strength is taken as constant"
        )
    elif perfect and result.plastic_volume and result.solution.load:
        caution = (
            "without hardening the pressure of single pixels scatters by 5 to 10 %: use means "
            "over 3 × 3 pixels or more, not the largest value"
        )
    return Statement("Isotropic hardening", text, caution)


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


def _path(result: ElastoplasticResult) -> Statement:
    loads = [step.load for step in result.increments]
    if not loads:
        return Statement("", "")
    turns = any(later < earlier for earlier, later in itertools.pairwise(loads))
    text = (
        f"The load was changed slowly, in {counted(len(loads), 'increment')}, up to "
        f"{engineering(max(loads), 'N')}"
        + (f", and ended at {engineering(loads[-1], 'N')}. " if turns else ". ")
        + "The result depends on this path, and a little on the size of its increments. The "
        "bodies are pressed together without tilting or sliding. They were free of stress before: "
        "residual stress of machining is not in it."
    )
    caution = ""
    if result.solution.load and any(_flows_back(body) for body in result.bodies):
        caution = (
            "the residual stress exceeds the yield strength, so that the bodies would flow again "
            "on unloading: end the path at zero load (--unload on the command line) to see "
            "what stays"
        )
    return Statement("Path of loads", text, caution)


def _flows_back(body: PlasticBody) -> bool:
    law = law_of(body.material)
    over = body.residual_von_mises > (1 + _ROUNDING) * law.strength(body.accumulated)
    return bool(over.any())


# Share of the yield strength by which the iteration may miss it.
_ROUNDING = 1e-3
