"""Quantities and columns of contacts, maps, profiles and volumes.

Console, report, JSON and CSV are generated from these tables: a new quantity appears in all of
them, with the same digits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np

from roughcontact.analyses.estimate import fields as formulas
from roughcontact.contact import hertz_comparison
from roughcontact.contact.nominal_hertz import CIRCLE, ELLIPSE, LINE, SmoothContact, is_smooth
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import LOAD_TOLERANCE, MOMENT_TOLERANCE
from roughcontact.contact.spots import Spots
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.halfspace.boundary import Boundary
from roughcontact.report import phrases
from roughcontact.report.kind import (
    ABSENT,
    CAUTIONS,
    HEADLINE,
    PROBLEM,
    REPORT_ONLY,
    TRUST,
    Column,
    Quantity,
    always,
    delegate_quantity,
    profile_table,
    quantity_of,
)
from roughcontact.units import (
    count_noun,
    format_engineering,
    format_percent,
    group_digits,
    order_of_magnitude,
)

_SIDES = {
    CIRCLE: ("radius of contact",),
    ELLIPSE: ("longer semi-axis", "shorter semi-axis"),
    LINE: ("half-width",),
}

HERTZ_SIZE = (
    "The size of the rough contact is that of the smooth contact with the same spread of pressure "
    "about its middle."
)


def is_hertz_compared(result: ContactResult) -> bool:
    """Return whether a comparison with Hertz is reported."""
    return result.converged and result.hertz is not None and result.contact_area > 0


def hertz_shapes(smooth: SmoothContact) -> str:
    """Return the shapes of the contacting bodies as text."""
    radii = " and ".join(format_engineering(radius, "m") for radius in smooth.shape.radii)
    many = len(smooth.shape.radii) > 1
    words = f"{smooth.shape.kind}, {'radii' if many else 'radius'} of relative curvature {radii}"
    if smooth.shape.kind != CIRCLE:
        what = "axis" if smooth.shape.kind == LINE else "longer side"
        words += f", {what} at {smooth.shape.angle:g} degrees counter-clockwise from x"
    if smooth.length is not None:
        words += f", {format_engineering(1e-3 * smooth.load / smooth.length, 'N')}/mm"
    return words


def hertz_heads(result: ContactResult) -> tuple[str, ...]:
    """Return the heads of the columns of `hertz_rows`."""
    solved = "solved" if is_smooth(result.pair) else "rough"
    return "compared with Hertz", "smooth (Hertz)", solved, "ratio"


def hertz_rows(result: ContactResult) -> list[tuple[str, ...]]:
    """Return the rows of smooth and rough contact: name, both values, and their ratio."""
    smooth = result.hertz
    assert smooth is not None
    names, sizes = _SIDES[smooth.shape.kind], hertz_comparison.equivalent_hertz_size(result)
    extent, unit = ("length", "m") if result.pair.is_profile else ("area", "m²")
    return [
        *(
            _hertz_row(name, "m", there, here)
            for name, there, here in zip(names, smooth.semi_axes, sizes, strict=True)
        ),
        _hertz_row("largest pressure", "Pa", smooth.max_pressure, result.max_pressure),
        _hertz_row("mean pressure", "Pa", smooth.mean_pressure, result.load / result.contact_area),
        _hertz_row(f"contact {extent}", unit, smooth.area, result.contact_area),
        _hertz_row("approach", "m", smooth.approach, result.approach),
    ]


def _hertz_row(name: str, unit: str, there: float | None, here: float) -> tuple[str, ...]:
    """Return the name, both values and their ratio."""
    text = format_engineering(here, unit)
    if there is None:
        return name, ABSENT, text, ABSENT
    return name, format_engineering(there, unit), text, f"{here / there:.4g}"


def hertz_record(result: ContactResult) -> dict[str, Any] | None:
    """Return the smooth contact as a JSON record in SI units; None if not reported."""
    if not is_hertz_compared(result):
        return None
    smooth = result.hertz
    assert smooth is not None
    return {
        "shape": smooth.shape.kind,
        "radii": list(smooth.shape.radii),
        "angle": smooth.shape.angle,
        "length": smooth.length,
        "semi_axes": list(smooth.semi_axes),
        "max_pressure": smooth.max_pressure,
        "mean_pressure": smooth.mean_pressure,
        "contact_area": smooth.area,
        "approach": smooth.approach,
        "spread_here": list(hertz_comparison.equivalent_hertz_size(result)),
        "limits": [limit.summary() for limit in hertz_comparison.comparison_limits(result)],
    }


def ceiling_stored(result: Any) -> Any:
    """Return the ceiling as stored in files."""
    return "per pixel" if isinstance(result.ceiling, np.ndarray) else result.ceiling


def _status(result: Any) -> str:
    return "converged" if result.converged else f"NOT CONVERGED: {result.status}"


def _specified_text(result: ContactResult, quantity: str, unit: str) -> str:
    value = format_engineering(getattr(result, quantity), unit)
    return f"{value} (given)" if result.control == quantity else value


def _load(result: ContactResult) -> str:
    if not result.fluid_load:
        return _specified_text(result, "load", result.pair.load_unit)
    solid, total = (format_engineering(load, "N") for load in (result.load, result.total_load))
    return f"{solid} of {total}; a fluid carries the rest"


def _tilts(result: ContactResult) -> bool:
    return result.moments is not None


def _has_ceiling(result: ContactResult) -> bool:
    return result.ceiling is not None


def _has_usual_ceiling(result: ContactResult) -> bool:
    """Return whether the calibrated contact was first solved with three yield strengths."""
    calibration, body = result.calibration, result.pair.softer
    # A load that exceeds them starts with a higher ceiling.
    return calibration is not None and calibration.usual_ceiling == (body and body.ceiling)


def _touches(result: ContactResult) -> bool:
    return result.contact_area > 0


def _area_and_share(unit: str) -> Callable[[Any], str]:
    return lambda result: (
        f"{group_digits(format_engineering(result.contact_area, unit))} "
        f"({format_percent(result.contact_fraction)})"
    )


def up_to(value: float) -> str:
    """Return a maximum length as text."""
    return f"up to {format_engineering(value, 'm')}" if value else "none"


def _load_error(result: ContactResult) -> str:
    free = result.control == "approach"
    aim = "the approach was given" if free else f"at most {LOAD_TOLERANCE:.0e}"
    return f"{order_of_magnitude(result.load_error)} ({aim})"


def _format_residual(key: str) -> Callable[[Any], str]:
    return lambda result: (
        f"{order_of_magnitude(getattr(result, key))} (tolerance {result.tolerance:.0e})"
    )


CONTACT = (
    Quantity("status", "status", part=TRUST, text=_status),
    Quantity("certificate", "certificate $ε$", part=TRUST, text=_format_residual("certificate")),
    Quantity("load_error", "load error", part=TRUST, text=_load_error),
    Quantity("tolerance"),
    Quantity("load", "load $W$ [N]: normal force that the pressure adds up to", text=_load),
    Quantity(
        "approach",
        "approach $ω$ [m]: of the bodies from the first touch",
        text=lambda r: _specified_text(r, "approach", "m"),
    ),
    Quantity("control"),
    Quantity(
        "given_load",
        "load given as",
        part=PROBLEM,
        of="specified_load",
        text=lambda r: phrases.given_load(r.specified_load, r),
    ),
    Quantity(
        "moments",
        "moments $W·y, W·x$ [N m]: of the load about the center of the map, as given",
        part=PROBLEM,
    ),
    Quantity(
        "moment_error",
        "moment error",
        part=TRUST,
        when=_tilts,
        form=lambda v: f"{order_of_magnitude(v)} of load × size (at most {MOMENT_TOLERANCE:.0e})",
    ),
    Quantity(
        "tilt",
        "tilt (y, x) [rad]: rotation of the counter-body away from the body, about the center",
        when=_tilts,
    ),
    Quantity(
        "center_of_pressure",
        "center of pressure (y, x) [m]: from the center of the map",
        when=_tilts,
        stored=False,
    ),
    Quantity(
        "boundary", "boundary", part=PROBLEM, text=lambda r: f"{r.boundary}: {r.boundary.meaning}"
    ),
    Quantity(
        "contact_modulus",
        "contact modulus $E*$ [Pa]: from 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂",
        part=PROBLEM,
    ),
    Quantity(
        "ceiling",
        "pressure ceiling [Pa]",
        of=ceiling_stored,
        part=PROBLEM,
        text=phrases.ceiling,
        when=always,
    ),
    Quantity("nominal_area", "nominal area [m²]: of the whole map", **REPORT_ONLY),
    Quantity(
        "nominal_pressure",
        "nominal pressure [Pa]: load over nominal area",
        of=lambda r: r.load / r.nominal_area,
        **REPORT_ONLY,
    ),
    Quantity(
        "contact_area",
        "contact area [m²]: pixels with pressure, and their share of the map",
        text=_area_and_share("m²"),
    ),
    Quantity(
        "contact_fraction",
        "real contact: share of the map in contact",
        form=format_percent,
        part=HEADLINE,
    ),
    Quantity(
        "perimeter_corrected_area",
        "perimeter-corrected area [m²]: without the excess of whole pixels at the perimeter of "
        "spots",
    ),
    Quantity(
        "saturated_fraction",
        "saturated area: share of the map at the ceiling",
        form=format_percent,
        when=_has_ceiling,
    ),
    Quantity(
        "saturated_share",
        "saturated share: of the contact area that is at the ceiling",
        of=lambda result: result.saturated_fraction / result.contact_fraction,
        form=format_percent,
        **REPORT_ONLY,
        when=lambda r: _has_ceiling(r) and _touches(r),
    ),
    Quantity(
        "mean_pressure",
        "mean pressure [Pa]: load over contact area",
        of=lambda r: r.load / r.contact_area,
        stored=False,
        when=_touches,
    ),
    Quantity("max_pressure", "largest pressure [Pa]: on any pixel", text=phrases.largest_pressure),
    Quantity("mean_gap", "mean gap [m]: of the open gap; closed points count 0"),
    Quantity(
        "max_residual_indentation",
        "residual indentation [m]: residual depth of saturated points",
        of="totals.max_indentation",
        form=up_to,
        when=_has_ceiling,
    ),
    Quantity(
        "calibration",
        "with three yield strengths: before calibration of the ceiling, and its difference",
        text=phrases.with_usual_ceiling,
        when=_has_usual_ceiling,
    ),
    Quantity("regime", "regime: of the softer body"),
    Quantity("calibrated"),
    Quantity("uncertainty", of="measurement"),
    *formulas.BY_FORMULA,
    Quantity("hertz", of=hertz_record),
    *CAUTIONS,
    Quantity("shape", of="surface.shape"),
    Quantity("pixel", "[m]", of="surface.pixel"),
    Quantity("source", of="surface.provenance.source"),
    Quantity("preparation", of="surface.provenance.steps"),
    Quantity("iterations", "iterations", part=TRUST, brief=False),
    Quantity("convolutions", "convolutions on the full grid", part=TRUST),
    Quantity("seconds", "time of the solve [s]", part=TRUST),
    Quantity(
        "precision",
        "arithmetic of the transforms",
        part=TRUST,
        form=lambda v: f"{v} precision",
        **REPORT_ONLY,
    ),
    Quantity("version"),
)
"""Quantities of a `ContactResult`."""

HEADLINES = ("contact_fraction", "mean_pressure", "saturated_fraction", "mean_gap")
"""Headline quantities of the report of a contact."""


def _has_load(result: ElastoplasticResult) -> bool:
    return bool(result.solution.load)


def largest_load(result: ElastoplasticResult) -> float:
    """Return the largest load of the path [N]."""
    return max((step.load for step in result.increments), default=0.0)


def _path_of_loads(result: ElastoplasticResult) -> str:
    load, largest = result.solution.load, largest_load(result)
    after = f" after {format_engineering(largest, 'N')}," if largest > load else ""
    return (
        f"{format_engineering(load, 'N')}{after} in "
        f"{count_noun(len(result.increments), 'increment')}"
    )


def _contact_quantity(key: str, **changes: Any) -> Quantity:
    """Return a quantity of the contact as a quantity of the volume model."""
    return delegate_quantity("solution", quantity_of(CONTACT, key), **changes)


def _laws(result: ElastoplasticResult) -> str:
    contact = result.solution
    law = phrases.hardening(contact.material)
    if contact.material.yield_strength is None:
        law = f"of the counter-body: {phrases.hardening(contact.counter_material)}"
    return law


VOLUME = (
    Quantity(
        "turns",
        "loads $W$ [N]: as given",
        part=PROBLEM,
        **REPORT_ONLY,
        form=lambda loads: " → ".join(format_engineering(load, "N") for load in [0.0, *loads]),
    ),
    Quantity("status", "status", part=TRUST, text=_status),
    Quantity(
        "residual",
        "residual of the plastic strain",
        part=TRUST,
        text=lambda r: f"{_format_residual('residual')(r)}, the worst of all increments",
    ),
    Quantity(
        "step_error", "error of the load steps", part=TRUST, text=phrases.step_error, when=always
    ),
    Quantity("yield_excess", "yield excess", part=TRUST, form=lambda v: f"{v:+.1e}", brief=False),
    Quantity("tolerance"),
    _contact_quantity("certificate", label="certificate of the contact $ε$", when=_has_load),
    _contact_quantity("load", text=_path_of_loads),
    _contact_quantity("load_error", when=_has_load, brief=False),
    _contact_quantity("given_load"),
    _contact_quantity("approach", text=None),
    _contact_quantity("nominal_area"),
    _contact_quantity("contact_area", when=_has_load),
    _contact_quantity("contact_fraction"),
    Quantity(
        "perimeter_corrected_area",
        "perimeter-corrected area [m²]: less the excess of whole pixels at the elastic rim of "
        "spots",
        when=_has_load,
        **REPORT_ONLY,
    ),
    _contact_quantity("max_pressure", when=_has_load),
    _contact_quantity("mean_pressure", when=_has_load),
    _contact_quantity("mean_gap", **REPORT_ONLY),
    Quantity(
        "max_residual_displacement",
        "residual displacement [m]: increase of the gap by plastic strain",
        of=lambda r: float(r.residual_displacement.max()),
        form=up_to,
    ),
    Quantity(
        "raised",
        "raised surface [m]: decrease of the gap by plastic strain (pile-up)",
        of=lambda result: max(-float(result.residual_displacement.min()), 0.0),
        form=up_to,
        **REPORT_ONLY,
    ),
    Quantity(
        "max_residual_stress",
        "residual stress [Pa]: von Mises, at most",
        of=lambda r: max(body.max_residual_von_mises for body in r.bodies),
        stored=False,
        part=HEADLINE,
    ),
    Quantity("max_plastic_strain", "plastic strain: accumulated, at most", form=format_percent),
    Quantity("plastic_volume", "plastic volume [m³]: with any plastic strain"),
    Quantity("plastic_depth", "plastic depth [m]: that plastic strain reaches"),
    Quantity("regime", "regime: of the bodies"),
    *CAUTIONS,
    _contact_quantity("boundary"),
    replace(quantity_of(CONTACT, "precision"), label="arithmetic of the volume", stored=True),
    Quantity("layers", of=lambda r: [body.thickness.size for body in r.bodies]),
    _contact_quantity("shape"),
    _contact_quantity("pixel"),
    Quantity("increments", "increments", of=lambda r: len(r.increments), part=PROBLEM, brief=False),
    _contact_quantity("contact_modulus", stored=False),
    Quantity(
        "plasticity",
        "plasticity: in the volume: von Mises, radial return, and how each body hardens",
        of=_laws,
        part=PROBLEM,
        stored=False,
    ),
    Quantity(
        "iterations",
        "iterations",
        part=TRUST,
        text=lambda r: f"{r.iterations} in {count_noun(len(r.increments), 'increment')}",
    ),
    Quantity(
        "convolutions",
        "convolutions of the contact",
        of=lambda r: sum(step.convolutions for step in r.increments),
        part=TRUST,
        **REPORT_ONLY,
    ),
    Quantity("seconds", "time of the solve [s]", part=TRUST),
    Quantity("version"),
)
"""Quantities of an `ElastoplasticResult`."""


def _offset(axis: int) -> Callable[[ElastoplasticResult], list[float]]:
    return lambda result: [step.offset[axis] for step in result.increments]


def _increment(key: str, label: str, **more: Any) -> Column:
    return Column(key, label, of=f"increments.{key}", **more)


_TRAVELLED = attrgetter("has_moved")
INCREMENTS = (
    Column("number", "increment", of=lambda r: range(1, len(r.increments) + 1)),
    _increment("load", "load [N]"),
    Column("offset_y", "moved along y [m]", of=_offset(0), when=_TRAVELLED),
    Column("offset_x", "moved along x [m]", of=_offset(1), when=_TRAVELLED),
    _increment("friction", "friction", when=_TRAVELLED),
    _increment("direction", "towards [degree]", when=_TRAVELLED),
    _increment("approach", "approach [m]"),
    _increment("contact_area", "contact area [m²]"),
    _increment("max_pressure", "largest pressure [Pa]"),
    _increment("max_plastic_strain", "plastic strain", form=format_percent),
    _increment("plastic_volume", "plastic volume [m³]"),
    _increment("residual", "residual", form=order_of_magnitude),
    _increment("iterations", "iterations"),
)
"""Columns of the increments of an `ElastoplasticResult`."""


def stored_quantity(attribute: str, key: str) -> Quantity:
    """Return a quantity of the contact of a result, which is only in files."""
    quantity = quantity_of(CONTACT, key)
    return delegate_quantity(attribute, quantity, label=f"[{quantity.unit}]", part=PROBLEM)


def pair_quantities(attribute: str) -> tuple[Quantity, ...]:
    """Return the quantities of the bodies of the contact of a result, which are only in files."""
    keys = ("source", "preparation", "boundary", "contact_modulus")
    return tuple(stored_quantity(attribute, key) for key in keys)


PAIR = pair_quantities("largest")
"""Quantities of the bodies, from the contact under the largest load."""


LOAD = "N/m"

BOUNDARY = {
    Boundary.PERIODIC_Y: (
        "free",
        "contact occurs only inside the profile, which continues unchanged along y",
    ),
    Boundary.PERIODIC: (
        "periodic",
        "the profile is one period of an endless one, which continues unchanged along y",
    ),
}
"""Boundary condition at the ends of a profile: name and meaning."""

REFERENCE = (
    "from the first touch; on a free profile a line load causes no displacement at a distance of "
    "its length"
)
"""Reference of the approach."""


def edge_condition(result: ContactResult) -> str:
    """Return the name of the boundary condition at the ends of a profile: free or periodic."""
    return BOUNDARY[result.boundary][0]


PROFILE_CONTACT = (
    *profile_table(
        CONTACT,
        *("moments", "moment_error", "tilt", "center_of_pressure", "nominal_area"),
        *("perimeter_corrected_area", "calibration", "calibrated", "uncertainty"),
        *("estimated_contact", "estimated_gap", "shape", "pixel"),
        load={
            "label": "load per length $W′$ [N/m]: normal force that the pressure adds up "
            "to, per meter along y"
        },
        approach={"label": f"approach $ω$ [m]: {REFERENCE}"},
        boundary={"of": edge_condition, "text": lambda r: ": ".join(BOUNDARY[r.boundary])},
        contact_area={"text": _area_and_share("m")},
        contact_fraction={"label": "contact: share of the profile in contact"},
    ),
    Quantity("kind", of=lambda _: "profile"),
    Quantity("load_unit", of=lambda _: LOAD),
    Quantity("points", of=lambda r: r.pressure.size),
    Quantity("spacing", "[m]", of=lambda r: r.surface.pixel[1]),
)
"""Quantities of a `ContactResult` of profiles."""


def segments(result: ContactResult, spots: Spots) -> list[tuple[str, str, str]]:
    """Return the rows of the contact segments: name, text and meaning."""
    largest, load = float(spots.area[0]), float(spots.load[0])
    share = format_percent(min(load / float(spots.load.sum()), 1.0))
    return [
        ("Number", str(spots.count), "connected parts of the profile in contact"),
        ("Mean length", format_engineering(float(spots.area.mean()), "m"), ""),
        (
            "Longest",
            f"{format_engineering(largest, 'm')} ({format_percent(largest / result.contact_area)} "
            "of all)",
            f"{round(largest / result.surface.pixel[1])} points",
        ),
        ("Load on the longest", f"{format_engineering(load, LOAD)} ({share} of the load)", ""),
    ]


def shares(name: str) -> Callable[[Any], list[str]]:
    """Return a formatter of an area of each step as a share of the nominal area."""
    return lambda joint: [
        format_percent(v) for v in (joint.column(name) / joint.nominal_area).tolist()
    ]
