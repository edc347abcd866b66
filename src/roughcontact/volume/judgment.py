"""What a contact with plasticity of the volume is judged by before its numbers are believed."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.contact import judgment
from roughcontact.contact.cautions import Caution, Kind, careful, ordered, warned
from roughcontact.contact.validity import LARGE_STRAIN
from roughcontact.errors import Mention, parts_of
from roughcontact.halfspace import tensors
from roughcontact.material.hardening import Kinematic, Linear, Perfect, Tabulated
from roughcontact.volume.result import ElastoplasticResult
from roughcontact.volume.stepping import STEP_ERROR

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
    """Return what a reader of a state of the volume has to know, the severest first.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    tuple of Caution
        On the path, the volume, its strains and hardening, and what the contact shows by itself.
    """
    found = [check(result) for check in _CHECKS]
    shown = (c for c in result.solution.cautions if c.kind not in _OF_THE_CEILING)
    return ordered([*(caution for caution in found if caution is not None), *shown])


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
    """Return the root-mean-square slope of the first gap under contact or plastic strain.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    float
        Without unit; NaN where there is neither.
    """
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
    """Return the largest plastic strain of a state: what counts against the small ones assumed.

    Metal that flows to and fro accumulates without end what it takes back.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    float
        Equivalent of the plastic strain where bodies have travelled; else the accumulated one,
        which is the same on a way up.
    """
    if not result.travelled:
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
    return warned(Kind.NOT_CONVERGED, *parts_of(result.status))


def _steps(result: ElastoplasticResult) -> Caution | None:
    error = result.step_error
    if error is None or not error > STEP_ERROR:
        return None
    return careful(
        Kind.LOAD_STEPS,
        f"the steps to the load make an error of about {100 * error:.2g} % of approach and contact "
        "area: take more of them, ",
        Mention("increments"),
        step_error=error,
    )


def _edge(result: ElastoplasticResult) -> Caution | None:
    return judgment.at_edge(result.solution, "; the volume goes on beyond the edge")


def _excess(result: ElastoplasticResult) -> Caution | None:
    if not result.yield_excess > _EXCESS:
        return None
    return warned(
        Kind.BEYOND_YIELD,
        "the von Mises stress exceeds the yield strength by up to "
        f"{100 * result.yield_excess:.3g} %: plastic strain is so large compared with the "
        "yield strain that it needs a smaller ",
        Mention("tolerance"),
        yield_excess=result.yield_excess,
    )


def _sides(result: ElastoplasticResult) -> Caution | None:
    free = result.solution.boundary.free_axes
    if not (free and any(body.at_rim for body in result.bodies)):
        return None
    return warned(
        Kind.PLASTIC_EDGE,
        "plastic strain reaches the edge of the volume: enlarge the map, or solve with ",
        Mention("boundary", "periodic"),
    )


def _bottom(result: ElastoplasticResult) -> Caution | None:
    if not any(body.at_bottom for body in result.bodies):
        return None
    return warned(
        Kind.PLASTIC_BOTTOM,
        "plastic strain reaches the lowest layer: enlarge the map, or give a larger ",
        Mention("depth"),
    )


def _deformations(result: ElastoplasticResult) -> Caution | None:
    strain = largest_strain(result)
    if strain > LARGE_STRAIN:
        return careful(
            Kind.PLASTIC_STRAINS,
            f"the largest plastic strain is {strain:.2g}, beyond the small strains of the model "
            f"(about {LARGE_STRAIN:g}): read strains and pressures there as estimates",
            max_plastic_strain=strain,
        )
    slope = slope_under(result)
    if slope > LARGE_DEFORMATION:
        return careful(
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
            return careful(
                Kind.HARDENING,
                f"the plastic strain exceeds {law.strain[-1]:.3g}, where the table of the yield "
                "strength ends: beyond it the strength is taken as constant",
                max_plastic_strain=body.max_plastic_strain,
            )
    if perfectly_plastic(result) and result.plastic_volume and result.solution.load:
        return careful(
            Kind.SCATTER,
            "without hardening the pressure of single pixels scatters by 5 to 10 %: use means "
            "over 3 × 3 pixels or more, not the largest value",
        )
    return None


def _residual(result: ElastoplasticResult) -> Caution | None:
    loaded = result.increments and result.solution.load
    if not (loaded and any(body.flows_back for body in result.bodies)):
        return None
    return careful(
        Kind.RESIDUAL,
        "the residual stress exceeds the yield strength, so that the bodies would flow again "
        "on unloading: end the path at zero load (--unload on the command line) to see "
        "what stays",
    )


_CHECKS = (
    _convergence, _excess, _steps, _edge, _sides, _bottom, _deformations, _hardening, _residual,
)  # fmt: skip
