"""Report of wear."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from roughcontact._tools import netcdf
from roughcontact.analyses.solve import uncertainty_report
from roughcontact.analyses.solve.fields import stored_quantity
from roughcontact.analyses.wear.figures import running_in
from roughcontact.analyses.wear.model import Wear
from roughcontact.contact import archive
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.result import ContactResult
from roughcontact.drawing import maps
from roughcontact.errors import ArgumentRef, Sentence
from roughcontact.references import make_use
from roughcontact.report import assumptions, chapters, phrases
from roughcontact.report.figures import FRONT, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    PROBLEM,
    CellTable,
    Column,
    Columns,
    Quantity,
    Use,
    format_value,
    stored_columns,
)
from roughcontact.report.page import WIDE
from roughcontact.report.phrases import format_share, format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_change, group_digits, join_ends, order_of_magnitude


def _is_rough(result: Wear) -> bool:
    return not has_nominal_body(result.first.pair.origins)


def _is_map(result: Wear) -> bool:
    return not result.last.pair.is_profile


def _coefficients(values: tuple[float, float]) -> str:
    return ", ".join(f"{value:.3g} m²/N" for value in values if value)


def _contact(result: ContactResult, base: ContactResult | None = None) -> str:
    """Return the contact fraction of a contact with its interval, which covers both ceilings."""
    ends = list(uncertainty_report.area_ends(result) or ())
    if base is not None:
        ends += [result.contact_fraction, base.contact_fraction]
    whole = result.nominal_area / result.touchable_area
    text = format_share(result.contact_fraction * whole)
    if not ends:
        return text
    low, high = (format_share(end(ends) * whole) for end in (min, max))
    return text if low == high else f"{text} ({join_ends(low, high)})"


# Rise of the plane of the worn map over its Sq from which leveling changes the contact.
_MIN_RISE = 0.01


def _plane_rise(result: Wear) -> float:
    """Return the height that a plane through the worn map rises over the map [m]."""
    if not _is_rough(result):
        return 0.0
    plane = result.worn.heights - result.worn.leveled().heights
    return float(np.nanmax(plane) - np.nanmin(plane))


def _rate(value: float) -> str:
    return f"{format_short(value, 'm')} per meter"


def _volumes(values: tuple[float, float]) -> str:
    return format_value(tuple(filter(None, values)), "m³", phrases.DIGITS)


def _column(key: str, label: str, **more: Any) -> Column:
    return Column(key, label, digits=phrases.DIGITS, **more)


def _area(key: str, label: str, **more: Any) -> Column:
    def shares(result: Wear) -> list[float]:
        return [getattr(step, key) / result.last.touchable_area for step in result.steps]

    return Column(key, label, shown=shares, form=format_share, **more)


_COLUMNS: Columns = (
    _column("distance", "distance [m]"),
    _column("wear", "mean wear [m]"),
    _column("max_wear", "largest wear [m]", brief=False),
    _area("contact_area", "contact [m²]"),
    _area("saturated_area", "saturated [m²]", brief=False),
    _column("mean_pressure", "mean pressure [Pa]", brief=False),
    _column("max_pressure", "peak pressure [Pa]"),
    _column("mean_gap", "mean gap [m]"),
    _column("Sq", "Sq [m]", when=_is_rough),
    _column("Ssk", "Ssk", form=lambda value: group_digits(f"{value:.2f}"), when=_is_rough),
    _column("Spk", "Spk [m]", when=_is_rough),
    _column("moved", "load moved", form=format_share, brief=False),
    Column("certificate", "certificate", form=order_of_magnitude, brief=False),
    Column("load_error"),
    Column("convolutions"),
    Column("seconds", "[s]"),
)


_STORED = ("source", "preparation", "load", "boundary", "contact_modulus", "tolerance")
_TABLE = (
    *(stored_quantity("first", key) for key in (*_STORED, "ceiling", "calibrated")),
    Quantity("motion", "motion", part=PROBLEM),
    Quantity("coefficients", "wear coefficients $k$ [m²/N]", form=_coefficients, part=PROBLEM),
    Quantity("friction"),
    Quantity("distance", "distance $s$ [m]"),
    Quantity("wear_rate", "mean wear: k p̄", form=_rate),
    Quantity("volumes", "worn volumes [m³]: k W s", form=_volumes, when=_is_map),
    Quantity("friction_work", "[J]"),
    Quantity("conforms"),
    Quantity("step_errors"),
    *CAUTIONS,
    Quantity("base", of=lambda result: result.base and stored_columns(_COLUMNS, result.base)),
    Quantity("steps", of=lambda result: stored_columns(_COLUMNS, result)),
    Quantity("version", of="last.version"),
)


class WearPresentation(Presentation):
    """Presentation of wear."""

    result: Wear
    table = _TABLE
    columns = _COLUMNS
    figures = (
        Illustration(
            "running-in",
            running_in,
            "Contact, pressure and roughness over the mean wear depth, which do not depend on the "
            "wear coefficient; dotted: before wear.",
            FRONT,
            WIDE,
        ),
        Illustration(
            "worn",
            lambda result: maps.surface(result.worn),
            "The worn body, unloaded.",
            when=_is_map,
        ),
    )
    plots = (running_in,)
    contact_name = "first"
    contact_state = "Before wear"
    packed = archive.PACKED

    def question(self) -> str:
        """Return the question that the wear answers."""
        first = self.result.first
        name = phrases.source(first.surface.provenance)
        return f"How does {name} run in under {phrases.load(first)}?"

    def problem(self) -> str:
        """Return the contact and the motion."""
        return f"{super().problem()}, {self.result.motion}"

    def answer(self) -> str:
        """Return distance, contact, roughness and wear depth as a sentence."""
        result = self.result
        first, last = result.steps[0], result.steps[-1]
        base = None if result.base is None else result.base.last
        contact = f"{_contact(result.first)} to {_contact(result.last, base)}"
        reached = f"after {format_short(result.distance, 'm')}: contact {contact}"
        if not _is_rough(result):
            deepest, form = format_short(last.max_wear, "m"), partial(format_short, unit="Pa")
            peaks = range_text(first.max_pressure, last.max_pressure, form)
            return f"Wears by up to {deepest} {reached}, peak pressure {peaks}."
        heights = range_text(first.Sq, last.Sq, partial(format_short, unit="m"))
        text = f"{reached}, Sq {heights}, {format_short(last.wear, 'm')} mean wear"
        if not result.conforms:
            return f"Runs in {text}."
        return f"Conforms {text}; from there it wears uniformly by {_rate(result.wear_rate)}."

    def meaning(self) -> str:
        """Return the regime of the worn contact."""
        return f"After wear: {phrases.regime(self.result.last)}"

    def numbers(self) -> CellTable:
        """Return the steps at the requested distances, or some of all steps."""
        result = self.result
        heads, rows = self.listing(brief=True)
        if len(result.distances) == 1:
            return heads, chapters.evenly_spaced(rows, 6)
        wanted = {0.0, *result.distances, result.distance}
        steps = zip(rows, result.steps, strict=True)
        return heads, [row for row, step in steps if step.distance in wanted]

    def remarks(self) -> Iterator[str]:
        """Yield the effect of the wear coefficient, and the accuracy of the steps."""
        result, first, errors = self.result, self.result.first, self.result.step_errors
        yield (
            "Contact and roughness depend on the mean wear alone; the distance is for k = "
            f"{_coefficients(result.coefficients)}, which scatters by ±50 % and more"
        )
        if first.saturated_fraction:
            share = format_share(first.saturated_fraction / first.contact_fraction)
            yield f"Before wear {share} of the contact is at the pressure ceiling"
        layer = sum(item.thickness for item in first.material.coating)
        if layer:
            share = format_share(result.steps[-1].max_wear / layer)
            yield f"The deepest wear is {share} of the coating, which keeps its thickness here"
        if result.friction_work is not None:
            work = format_short(result.friction_work, "J" if _is_map(result) else "J/m")
            yield f"Work of friction: {work}"
        if (rise := _plane_rise(result)) > _MIN_RISE * result.worn.Sq:
            advice = f"Do not level the worn map again: {ArgumentRef('level', 'none')}"
            tilt = f"a plane would tilt its plateau by {format_short(rise, 'm')}"
            yield Sentence(f"{advice}; {tilt}")
        contact, peak = (format_change(errors[key]) for key in ("contact_area", "max_pressure"))
        yield f"Last step in two: contact {contact}, peak pressure {peak}"
        worst = max(step.certificate for step in result.steps)
        yield phrases.worst(worst, first.tolerance, len(result.steps))

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the method."""
        yield (
            f"Archard's law at each pixel, in {len(self.result.steps) - 1} implicit steps: wear "
            "coefficient times distance is an additional compliance of each pixel. The last step "
            "is divided in two, which estimates the error of the steps, and solved again without "
            "wear. Debris leaves, friction causes no heat, and the counter-body is smooth or the "
            "same points meet: rough bodies slide farther than an asperity, films form, and debris "
            "may be trapped."
        )

    def case(self) -> assumptions.Case:
        """Return the case of the worn contact."""
        return replace(assumptions.contact_case(self.result.last), wear=self.result)

    def works(self) -> Iterator[Use]:
        """Yield the works on wear."""
        yield make_use("wear", "Archard1953", "Podra1999", "Furustig2016")

    def dataset(self) -> netcdf.Dataset:
        """Return the worn contact with the wear depth and all steps as a dataset."""
        result = self.result
        dataset = archive.to_dataset(result.last)
        dataset.add("wear_depth", ("y", "x"), result.depth, "m", "wear depth of both bodies")
        for column in _COLUMNS:
            values = np.array(column.values(result), float)
            dataset[f"step_{column.key}"] = ("step", values, {"units": column.unit})
        body, counter = result.coefficients
        dataset.attrs |= {"wear_coefficient": body, "counter_wear_coefficient": counter}
        dataset.attrs |= {"wear_coefficient_units": "m2/N", "motion": result.motion}
        return dataset
