"""Report of a load curve."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property, partial
from typing import Any

from roughcontact.analyses.solve import fields as contact_fields, uncertainty_report as uncertainty
from roughcontact.analyses.solve.fields import BOUNDARY, ceiling_stored
from roughcontact.analyses.sweep.figures import load_curve
from roughcontact.analyses.sweep.model import LOW_LOAD, LoadCurve
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.result import CALIBRATED, ContactResult
from roughcontact.references import make_use
from roughcontact.report import phrases
from roughcontact.report.citations import CEILING, RECOMMENDED, Uses, map_references, solved_of
from roughcontact.report.figures import FRONT, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    Column,
    Quantity,
    largest_of_steps,
    profile_columns,
    profile_table,
)
from roughcontact.report.page import WIDE
from roughcontact.report.phrases import format_share, format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_engineering, format_percent, order_of_magnitude


def share_of(key: str) -> Callable[[Any], list[float]]:
    """Return a formatter of an area of each step as a share of the nominal area."""
    return lambda result: [getattr(step, key) / _nominal(result) for step in result.steps]


def _nominal(result: Any) -> float:
    return result.nominal_area if isinstance(result, LoadCurve) else result.last.nominal_area


def certificates_of(steps: str = "steps") -> Quantity:
    """Return the quantity of the largest certificate of the steps of a result."""
    name, label = "worst_certificate", "certificates $ε$"
    form: Callable[[float], str] = "{:.1e} at most".format
    return largest_of_steps(name, label, "certificate", steps, form=form, stored=False)


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


def _growth(curve: LoadCurve) -> str:
    first, last = (curve.steps[n].contact_area / curve.nominal_area for n in (0, -1))
    text = range_text(first, last, format_share)
    is_known = curve.contact is not None and not curve.intervals
    ends = uncertainty.area_ends(curve.largest) if is_known else None
    return text if ends is None else f"{text} ({range_text(*ends, format_share)})"


class CurvePresentation(Presentation):
    """Presentation of a load curve."""

    result: LoadCurve
    table = CURVE
    columns = CURVE_COLUMNS
    contact_name = "contact"
    figures = (
        Illustration(
            "curve",
            load_curve,
            lambda curve: (
                "Contact and saturated length; approach and mean gap; stiffness; number of "
                "segments."
                if curve.is_profile
                else "Contact and saturated area with Persson's theory; approach and mean gap; "
                "stiffness of the next small load; contact spots."
            ),
            FRONT,
            WIDE,
        ),
    )
    plots = (load_curve,)
    profile_table = PROFILE_CURVE
    profile_columns = PROFILE_CURVE_COLUMNS
    is_listed = True

    @cached_property
    def report_contact(self) -> ContactResult | None:
        """Contact under the largest load, which is solved for the report."""
        return self.result.largest if self.is_drawn else None

    @property
    def is_profile(self) -> bool:
        """Whether the curve is that of profiles."""
        return self.result.is_profile

    def question(self) -> str:
        """Return the question that a load curve answers."""
        curve = self.result
        unit = "m" if curve.control == "approach" else "N/m" if curve.is_profile else "N"
        ends = [format_engineering(getattr(step, curve.control), unit) for step in curve.steps]
        name = curve.source or "the surface"
        return f"How does the contact of {name} grow from {phrases.span(ends)}?"

    def problem(self) -> str:
        """Return bodies and load in one line."""
        curve = self.result
        name = curve.source or "an unnamed map"
        control = "loads" if curve.control == "load" else "approaches"
        first, last = (getattr(step, curve.control) for step in (curve.steps[0], curve.steps[-1]))
        unit = (
            (contact_fields.LOAD if curve.is_profile else "N") if curve.control == "load" else "m"
        )
        ends = range_text(first, last, lambda value: format_short(value, unit))
        text = f"{name}, {len(curve.steps)} {control} from {ends}"
        if curve.is_profile or has_nominal_body(curve.origins):
            return text
        first, last = (step.load / curve.nominal_area for step in (curve.steps[0], curve.steps[-1]))
        ends = range_text(first, last, lambda value: format_short(value, "Pa"))
        return f"{text} ({ends} nominal)"

    def answer(self) -> str:
        """Return the growth of the contact from first to last load as a sentence."""
        curve = self.result
        what = "profile" if curve.is_profile else "face"
        if curve.base is None:
            return f"The contact grows from {_growth(curve)} of the {what}."
        return (
            f"The contact grows from {_growth(curve)} of the {what} under the ceiling of the "
            f"coating, from {_growth(curve.base)} under that of the base."
        )

    def remarks(self) -> tuple[str, ...]:
        """Return the remarks on the intervals, and the accuracy of the steps."""
        curve = self.result
        most = max(step.certificate for step in curve.steps)
        return (
            *(curve.intervals[-1].remarks if curve.intervals else ()),
            f"Solved: {len(curve.steps)} contacts, certificate {order_of_magnitude(most)} at most",
        )

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the method."""
        text = "Each load is solved as a first loading; the model keeps no history."
        if self.result.low_loads.any() and not self.result.is_profile:
            text += (
                f" At small loads (up to {format_percent(LOW_LOAD)} in contact) the area is A = κ "
                "W/(E* h′). Theory gives κ = 2.5 (Bush, Gibson and Thomas 1975) and 1.6 (Persson "
                "2001), computations 1.8 to 2.3 (Hyun et al. 2004)."
            )
        yield text

    def works(self) -> Uses:
        """Yield the works on contact and stiffness."""
        return curve_references(self.result)
