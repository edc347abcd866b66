"""Quantities, columns and references of a load curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from roughcontact.analyses.solve.fields import BOUNDARY, ceiling_stored
from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.contact.result import CALIBRATED
from roughcontact.references import make_use
from roughcontact.report import phrases
from roughcontact.report.citations import CEILING, RECOMMENDED, Uses, map_references, solved_of
from roughcontact.report.kind import (
    CAUTIONS,
    TRUST,
    Column,
    Quantity,
    profile_columns,
    profile_table,
)
from roughcontact.units import format_percent, order_of_magnitude


def share_of(key: str) -> Callable[[Any], list[float]]:
    """Return a formatter of an area of each step as a share of the nominal area."""
    return lambda result: [getattr(step, key) / _nominal(result) for step in result.steps]


def _nominal(result: Any) -> float:
    return result.nominal_area if isinstance(result, LoadCurve) else result.last.nominal_area


def certificates_of() -> Quantity:
    """Return the quantity of the largest certificate."""
    return Quantity(
        "worst_certificate",
        "certificates $ε$",
        of=lambda result: max(step.certificate for step in result.steps),
        form=lambda v: f"{v:.1e} at most",
        part=TRUST,
        stored=False,
    )


def _slope(curve: LoadCurve) -> str:
    slope = f"{curve.low_load_slope:.4g}"
    if curve.low_loads.any():
        return f"{slope}; theory 1.6 (Persson) to 2.5 (Bush, Gibson, Thomas)"
    return f"{slope} at the smallest load; no load is elastic with less than 5 % contact"


def given_loads_of(unit: Callable[[Any], str] = lambda _: "N") -> Quantity:
    """Return the quantity of the loads in the form in which they were given."""
    return Quantity(
        "given_loads",
        "loads given as",
        of="specified_load",
        text=lambda r: phrases.given_loads(r.specified_load, unit(r)),
    )


CURVE = (
    Quantity("source"),
    Quantity("preparation"),
    Quantity("control"),
    given_loads_of(lambda curve: "N/m" if curve.is_profile else "N"),
    Quantity("boundary"),
    Quantity("nominal_area", "[m²]"),
    Quantity("contact_modulus", "[Pa]"),
    Quantity("rms_gradient", "root-mean-square slope $h′$"),
    Quantity("ceiling", "[Pa]", of=ceiling_stored),
    Quantity(
        "low_load_slope",
        "low-load slope $κ$: of A = κ W/(E* h′)",
        text=_slope,
        when=lambda curve: math.isfinite(curve.low_load_slope),
    ),
    Quantity("calibrated", of="contact.calibrated"),
    *CAUTIONS,
    certificates_of(),
)
"""Quantities of a `LoadCurve`."""


def _ends(curve: LoadCurve, name: str, end: str) -> list[float]:
    return [getattr(known.interval(name), end, math.nan) for known in curve.intervals]


def _contact_intervals(curve: LoadCurve) -> list[str]:
    low, high = (_ends(curve, "contact_fraction", end) for end in ("low", "high"))
    return [
        phrases.range_text(*pair, form=phrases.format_share) for pair in zip(low, high, strict=True)
    ]


_INTERVALS = (
    Column(
        "contact",
        "95 of 100",
        shown=_contact_intervals,
        form=str,
        stored=False,
        when=lambda curve: bool(curve.intervals),
    ),
    *(
        Column(
            f"{name}_{end}",
            f"[{unit}]",
            of=partial(_ends, name=name, end=end),
            when=lambda curve: bool(curve.intervals),
        )
        for name, unit in (
            ("contact_fraction", "1"),
            ("saturated_fraction", "1"),
            ("mean_gap", "m"),
            ("approach", "m"),
            ("stiffness", "N/m"),
            ("max_pressure", "Pa"),
        )
        for end in ("value", "low", "high")
    ),
)
"""Columns of the intervals of each step of a `LoadCurve`, if computed."""


def _base_column(key: str, label: str, **shown: Any) -> Column:
    """Return the column of a quantity under the ceiling of the base of a coated body."""
    return Column(f"base_{key}", label, of=f"base.steps.{key}", **shown)


_BASE = (
    _base_column(
        "contact_area",
        "contact (base) [m²]",
        shown=lambda curve: share_of("contact_area")(curve.base),
        form=format_percent,
    ),
    _base_column("saturated_area", "[m²]"),
    _base_column("mean_gap", "mean gap (base) [m]", brief=False),
    _base_column("approach", "[m]"),
    _base_column("stiffness", "[N/m]"),
)
"""Columns of the steps of the ``base`` of a `LoadCurve`."""


CURVE_COLUMNS = (
    Column("load", "load [N]"),
    Column("approach", "approach [m]"),
    Column("contact_area", "contact [m²]", shown=share_of("contact_area"), form=format_percent),
    Column("perimeter_corrected_area", "[m²]"),
    Column(
        "saturated_area", "saturated [m²]", shown=share_of("saturated_area"), form=format_percent
    ),
    Column("max_pressure", "largest pressure [Pa]", brief=False),
    Column("mean_gap", "mean gap [m]"),
    Column("stiffness", "stiffness [N/m]"),
    Column("unloading_stiffness", "[N/m]"),
    Column("spots", "spots"),
    Column("mean_spot_area", "[m²]"),
    Column("largest_spot_area", "[m²]"),
    Column("certificate", "certificate", form=order_of_magnitude, brief=False),
    Column("load_error"),
    Column(
        "pressure_ceiling",
        "ceiling [Pa]",
        of=lambda c: c.column("ceiling"),
        when=lambda c: isinstance(c.ceiling, str),
    ),
    Column("convolutions"),
    Column("seconds", "[s]"),
    Column("constriction_length", "[m]"),
    Column("persson_contact_area", "[m²]", of=lambda c: c.persson[0]),
    Column("persson_saturated_area", "[m²]", of=lambda c: c.persson[1]),
    *_INTERVALS,
    *_BASE,
)
"""Columns of the steps of a `LoadCurve`."""


PROFILE_CURVE = (
    *profile_table(
        CURVE, "low_load_slope", boundary={"of": lambda curve: BOUNDARY[curve.boundary][0]}
    ),
    Quantity("kind", of=lambda _: "profile"),
)
"""Quantities of a `LoadCurve` of profiles."""


PROFILE_CURVE_COLUMNS = profile_columns(
    CURVE_COLUMNS,
    *("perimeter_corrected_area", "constriction_length"),
    *("persson_contact_area", "persson_saturated_area"),
    *(column.key for column in (*_INTERVALS, *_BASE)),
)
"""Columns of the steps of a `LoadCurve` of profiles."""


def curve_references(curve: LoadCurve) -> Uses:
    """Yield the references of a load curve."""
    known = curve.softer is not None and curve.softer.yield_strength is not None
    yield from map_references(curve.origins, curve.is_profile)
    yield from solved_of(curve.boundary, curve.is_profile, known)
    if curve.ceiling is not None:
        yield CEILING
    if isinstance(curve.ceiling, str) and curve.ceiling == CALIBRATED:
        yield RECOMMENDED
    if not curve.is_profile:
        yield make_use("area at small loads", "Bush1975", "Persson2001", "Hyun2004")
    yield make_use("conductance from the stiffness", "Barber2003")
