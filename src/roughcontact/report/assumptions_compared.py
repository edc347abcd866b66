"""What a comparison of maps takes for granted: that of each contact, worded for all of them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from roughcontact.contact.cautions import Kind
from roughcontact.contact.sample import Sample
from roughcontact.report import assumptions, wording
from roughcontact.report.assumptions import Statement
from roughcontact.units import engineering


def statements(samples: Sequence[Sample]) -> tuple[Statement, ...]:
    """Return what is assumed of each of several maps under the same nominal pressure.

    Parameters
    ----------
    samples : sequence of Sample
        The maps, between the same bodies, under the same ceiling and boundary.

    Returns
    -------
    tuple of Statement
        As for one contact, with the numbers of the map that is farthest from what is assumed.
    """
    curve, (material, counter_material) = samples[0].curve, samples[0].bodies
    slopes = [one.curve.rms_gradient for one in samples if math.isfinite(one.curve.rms_gradient)]
    steepest = max(slopes, default=math.nan)
    pressure = max(one.numbers["max_pressure"] for one in samples)
    found = (
        assumptions.half_spaces(
            curve.boundary, assumptions.elastic_half_spaces(material, counter_material)
        ),
        assumptions.FLAT,
        assumptions.small_slopes(steepest, "of the steepest map", material, counter_material),
        assumptions.strains(pressure / curve.contact_modulus),
        assumptions.FRICTIONLESS,
        _yielding(samples),
        _resolution(samples),
        _holes(samples),
        assumptions.one_loading("The load on each map is the nominal pressure times its area. "),
    )
    return tuple(statement for statement in found if statement.text)


def _yielding(samples: Sequence[Sample]) -> Statement:
    ceiling, bodies = samples[0].curve.ceiling, samples[0].bodies
    if ceiling is None:
        return assumptions.elastic(*bodies)
    reached = any(one.numbers["saturated_fraction"] > 0 for one in samples)
    return assumptions.limited(wording.limit(ceiling, *bodies), *bodies, reached=reached)


def _resolution(samples: Sequence[Sample]) -> Statement:
    edges = [edge for one in samples for edge in one.pixel]
    small, large = (engineering(edge, "m", 3) for edge in (min(edges), max(edges)))
    return Statement(
        "Resolution",
        f"The pressure is constant on each pixel, of {small}"
        + (f" to {large}" if small != large else "")
        + " along a side, and roughness finer than that is not in the maps. On a rough surface a "
        "finer map has less contact area and higher elastic pressures: maps are compared at the "
        "waves that they show.",
        (Kind.RESOLUTION, Kind.STUDY, Kind.MEASUREMENT),
    )


def _holes(samples: Sequence[Sample]) -> Statement:
    methods = {
        step.method for one in samples for origin in one.curve.origins for step in origin.operations
    }
    parts = [assumptions.FILLED] if "filled" in methods else []
    if "masked" in methods:
        parts.append(
            "Points that were not measured are taken as never touching; the load that they might "
            "carry lies on the others."
        )
    return Statement("Missing points", " ".join(parts), (Kind.FILLED, Kind.MISSING))
