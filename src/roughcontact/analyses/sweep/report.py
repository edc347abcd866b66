"""Report of a load curve."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

from roughcontact.analyses.solve import fields as contact_fields, uncertainty_report as uncertainty
from roughcontact.analyses.sweep import fields as sweep_fields
from roughcontact.analyses.sweep.figures import load_curve
from roughcontact.analyses.sweep.model import LOW_LOAD, LoadCurve
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.result import ContactResult
from roughcontact.report import phrases
from roughcontact.report.citations import Uses
from roughcontact.report.figures import FRONT, Illustration
from roughcontact.report.page import WIDE
from roughcontact.report.phrases import format_share, format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_engineering, format_percent, order_of_magnitude


def _growth(curve: LoadCurve) -> str:
    first, last = (curve.steps[n].contact_area / curve.nominal_area for n in (0, -1))
    text = range_text(first, last, format_share)
    is_known = curve.contact is not None and not curve.intervals
    ends = uncertainty.area_ends(curve.largest) if is_known else None
    return text if ends is None else f"{text} ({range_text(*ends, format_share)})"


class CurvePresentation(Presentation):
    """Presentation of a load curve."""

    result: LoadCurve
    table = sweep_fields.CURVE
    columns = sweep_fields.CURVE_COLUMNS
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
    profile_table = sweep_fields.PROFILE_CURVE
    profile_columns = sweep_fields.PROFILE_CURVE_COLUMNS
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
        limits = curve.intervals[-1].remarks if curve.intervals else ()
        return (
            *limits,
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
        return sweep_fields.curve_references(self.result)
