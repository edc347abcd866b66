"""Table of model assumptions, with the values of the case.

The user guide explains each assumption; see ``docs/assumptions.md``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from roughcontact.contact import plausibility
from roughcontact.contact.plausibility import LARGE_SLOPE, LARGE_STRAIN, load_bearing_spot_pixels
from roughcontact.contact.result import ContactResult
from roughcontact.elastoplastic.plausibility import largest_strain, slope_under
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material, contact_modulus, softer_material
from roughcontact.report.kind import Cells
from roughcontact.surface.provenance import Provenance
from roughcontact.units import count_noun, format_engineering, format_percent

HEAD = ("The model assumes", "In this case", "Matters if")


@dataclass(frozen=True, eq=False)
class Case:
    """Inputs of assumptions: bodies, slope, pressure and grid."""

    bodies: tuple[Material, Material]  # Body with the map, and counter-body
    boundary: Boundary  # Boundary condition
    origins: Sequence[Provenance]  # Provenances of the maps
    slope: float  # rms slope of the gap
    contact_slope: float  # The same from points near the contact
    max_pressure: float  # Largest pressure [Pa]
    ceiling: Any  # Pressure ceiling, as in results
    reached: bool  # Whether the pressure reaches the ceiling anywhere
    contact: ContactResult | None = None  # Contact, if any
    volume: ElastoplasticResult | None = None  # Result of the volume model, if any
    history: Any = None  # Load history, if any
    wear: Any = None  # Wear, if any

    @property
    def is_profile(self) -> bool:
        """Whether the bodies are profiles."""
        return self.contact is not None and self.contact.pair.is_profile

    @property
    def modulus(self) -> float:
        """Contact modulus E* [Pa]."""
        return contact_modulus(*self.bodies)

    def is_prepared_by(self, method: str) -> bool:
        """Return whether a preparation step of any map has this name."""
        return any(step.method == method for item in self.origins for step in item.operations)


def contact_case(
    result: ContactResult, history: Any = None, volume: ElastoplasticResult | None = None
) -> Case:
    """Return the case of a contact, alone, after a load history or of the volume model."""
    pair = result.pair
    return Case(
        (result.material, result.counter_material),
        result.boundary,
        pair.origins,
        pair.rms_slope,
        plausibility.rms_slope(result),
        result.max_pressure,
        result.ceiling,
        result.saturated_fraction > 0,
        result,
        volume,
        history,
    )


def sample_case(samples: Sequence[Any]) -> Case:
    """Return the case of several maps under one nominal pressure: the worst of each value."""
    first = samples[0]
    slopes = [s.curve.rms_gradient for s in samples if math.isfinite(s.curve.rms_gradient)]
    return Case(
        first.bodies,
        first.curve.boundary,
        [o for s in samples for o in s.curve.origins],
        *2 * (max(slopes, default=math.nan),),
        max(s.numbers["max_pressure"] for s in samples),
        first.curve.ceiling,
        any(s.numbers["saturated_fraction"] > 0 for s in samples),
    )


@dataclass(frozen=True)
class Assumption:
    """Row of the table of assumptions."""

    name: str  # Assumption of the model
    case: str | Callable[[Any], str]  # The assumption in this case, with its values
    matters: str  # Where it does not hold
    when: Callable[[Any], bool] = lambda _: True  # Whether the model makes it


def slope_errors(case: Case) -> tuple[float, float]:
    """Return the relative errors of shapes and of loads caused by a slope.

    The first is half the square of the slope. The second is proportional to the slope, since the
    lateral displacements of the bodies differ: a part of the load on a cone of this slope or, for
    a profile, of the width of a spot under a cylinder.
    """
    first, second = ((1 - 2 * b.poisson) * (1 + b.poisson) / b.young for b in case.bodies)
    dundurs = abs(first - second) * case.modulus / 2
    cone = 2 / math.pi * (0.15483073 + 0.83119312)
    sideways = dundurs * (math.pi / 4 if case.is_profile else cone)
    return case.contact_slope**2 / 2, sideways * case.contact_slope


def _slope(case: Case) -> str:
    if math.isnan(case.contact_slope):
        return "no slope is known on this map"
    error = format_percent(min(sum(slope_errors(case)), 1.0))
    return f"rms slope {case.contact_slope:.3g} at the contact: error {error}"


def _periodic(case: Case) -> bool:
    # A profile with free ends is periodic along y.
    ends = case.is_profile and case.boundary is Boundary.PERIODIC_Y
    return bool(case.boundary.periodic_axes) and not ends


def _ceiling_text(case: Case) -> str:
    if not case.reached:
        return "no point reaches it"
    body = softer_material(*case.bodies)
    if body is None or body.yield_strength is None or math.isnan(case.slope):
        return "some points reach it"
    return f"some points reach it; E*h′/σ_Y = {case.modulus * case.slope / body.yield_strength:.3g}"


def _yields(case: Case) -> bool:
    return case.volume is not None


def _path_travels(case: Case) -> bool:
    return case.volume is not None and case.volume.has_moved


def _counter_body(case: Case) -> bool:
    return case.contact is not None and case.contact.counter_surface is not None


def _grid(case: Case) -> str:
    if case.contact is None or not case.contact.load:
        return "no detail below the pixel"
    pixels = load_bearing_spot_pixels(case.contact, case.contact.spots())
    what = "segments" if case.is_profile else "spots"
    return f"half of the load is on {what} of {count_noun(pixels, 'pixel')} or more"


def _holes(case: Case) -> str:
    text = []
    if case.contact is not None and (gone := int(np.count_nonzero(np.isnan(case.contact.gap)))):
        share = format_percent(gone / case.contact.gap.size)
        text.append(f"{count_noun(gone, 'point')} ({share}) without height are never in contact")
    elif case.is_prepared_by("masked"):
        text.append("points without height are never in contact")
    if case.is_prepared_by("filled"):
        text.append("filled points are interpolated, not measured")
    return "; ".join(text)


def _strain(case: Case) -> str:
    return f"peak pressure / E* = {case.max_pressure / case.modulus:.2g}"


def _plastic_strain(case: Case) -> str:
    assert case.volume is not None
    slope = slope_under(case.volume)
    strain = f"plastic strain {format_percent(largest_strain(case.volume))} at most"
    # Sphere of radius R with a spot of radius a: a/R = √2 times the rms slope.
    return strain if math.isnan(slope) else f"{strain}; slope under the contact {slope:.3g}"


def _layers(case: Case) -> str:
    assert case.volume is not None
    layers = case.volume.bodies[0].thickness
    sizes = (layers[0], layers[-1], float(layers.sum()))
    thin, thick, deep = (format_engineering(size, "m", 3) for size in sizes)
    return f"layers of {thin} (surface) to {thick}, {deep} deep"


def _friction(case: Case) -> str:
    assert case.volume is not None
    largest = max(step.friction for step in case.volume.increments)
    return f"traction {largest:.3g} of the pressure everywhere" if largest else "no traction"


def _is_single(case: Case) -> bool:
    result = case.volume or case.contact
    return result is not None and result.precision == "single"


ASSUMPTIONS = (
    Assumption(
        "Straight ridges",
        "the profile continues unchanged along y",
        "the surface is rough in both directions",
        lambda c: c.is_profile,
    ),
    Assumption("Half-spaces", "no other face is near", "a coating, thin wall or edge is near"),
    Assumption(
        "Periodic sample", "the map is one period", "waves are longer than the map", _periodic
    ),
    Assumption(
        "No contact beyond the map edge",
        "the face ends with the map",
        "the map is a sample of a larger face",
        lambda c: not _periodic(c),
    ),
    Assumption(
        "Datum of the approach",
        "a line load causes no displacement at a distance of the longer side",
        "approach or stiffness is used",
        lambda c: len(c.boundary.periodic_axes) == 1,
    ),
    Assumption("Small slopes", _slope, f"the slope is above {LARGE_SLOPE:g}"),
    Assumption("Small strains", _strain, f"above {LARGE_STRAIN:g}", lambda c: not _yields(c)),
    Assumption("Small strains", _plastic_strain, f"either is above {LARGE_STRAIN:g}", _yields),
    Assumption(
        "Ceiling for plastic flow",
        _ceiling_text,
        "residual stress, pile-up or many passes matter",
        lambda case: case.ceiling is not None and not _yields(case),
    ),
    Assumption(
        "No plastic flow",
        "elastic at any pressure",
        "a metal yields (peak pressure above 1.6 σ_Y)",
        lambda case: case.ceiling is None and not _yields(case),
    ),
    Assumption(
        "Hardening",
        "independent of speed and temperature",
        "load reverses, or creep, fracture or heat occur",
        _yields,
    ),
    Assumption("Layers", _layers, "peaks are narrower than a layer or pixel", _yields),
    Assumption(
        "No friction, no adhesion",
        "pressure is normal and never negative",
        "bodies slide, are soft, or are very smooth",
        lambda c: not _path_travels(c),
    ),
    Assumption(
        "Rolling without slip zones", _friction, "torque, spin or a lubricant act", _path_travels
    ),
    Assumption(
        "Smooth counter-body",
        "its roughness is not included",
        "both faces are rough",
        lambda c: not _counter_body(c),
    ),
    Assumption(
        "Two surfaces in one position",
        "only the sum of their heights counts",
        "their position may change",
        _counter_body,
    ),
    Assumption("Constant pressure on a pixel", _grid, "spots have fewer than 10 pixels"),
    Assumption("Missing points", _holes, "they are on summits", lambda c: bool(_holes(c))),
    Assumption(
        "One slow loading",
        "applied once",
        "faces are run in, creep or wear",
        lambda c: c.history is None and c.wear is None and not _yields(c),
    ),
    Assumption(
        "Archard's law of wear",
        "one load; debris leaves",
        "debris, films, heat or creep change the faces",
        lambda c: c.wear is not None,
    ),
    Assumption(
        "Path of loads",
        "unloading is elastic, displaced material is lost",
        "displaced material or residual stress matters",
        lambda c: c.history is not None,
    ),
    Assumption(
        "Path of loads", "from unstressed bodies", "machining left residual stress", _yields
    ),
    Assumption(
        "Single precision",
        "seven digits in the transforms",
        "you need a smaller tolerance",
        _is_single,
    ),
)
"""Assumptions of any contact, for a `Case`."""


def assumption_rows(case: Case) -> list[Cells]:
    """Return the assumptions of a model in a case."""
    return [
        (item.name, item.case if isinstance(item.case, str) else item.case(case), item.matters)
        for item in ASSUMPTIONS
        if item.when(case)
    ]
