"""What is told of contacts of profiles: the quantities of maps, per metre of their width."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.contact.stress import StressResult
from roughcontact.halfspace.boundary import Boundary
from roughcontact.report import tables
from roughcontact.report.quantities import (
    PROBLEM,
    Column,
    Columns,
    Quantity,
    Table,
    quantity_of,
)
from roughcontact.units import engineering, percent

LOAD = "N/m"

BOUNDARY = {
    Boundary.PERIODIC_Y: ("free", "the profile is all that touches, alike along y without end"),
    Boundary.PERIODIC: (
        "periodic", "the profile is one period of an endless one, alike along y without end"
    ),
}  # fmt: skip
"""What lies beyond the ends of a profile: its name, and in a few words."""

REFERENCE = (
    "from the first touch; of a free profile a line load displaces nothing at a distance of the "
    "length of the profile"
)
"""What the approach counts from."""


def beyond(result: ContactResult) -> str:
    """Return what lies beyond the ends of a profile, by name."""
    return BOUNDARY[result.boundary][0]


def _of(key: str, **changes: Any) -> Quantity:
    return replace(quantity_of(tables.CONTACT, key), **changes)


def _given(quantity: str, unit: str) -> Callable[[ContactResult], str]:
    def text(result: ContactResult) -> str:
        value = engineering(getattr(result, quantity), unit)
        return f"{value} (given)" if result.control == quantity else value

    return text


def _length(result: ContactResult) -> str:
    return f"{engineering(result.contact_area, 'm')} ({percent(result.contact_fraction)})"


CONTACT: Table = (
    *(_of(key) for key in ("status", "certificate", "load_error", "tolerance")),
    Quantity("kind", of=lambda _: "profile"),
    _of(
        "load", name="load per length", symbol="W′", unit=LOAD, text=_given("load", LOAD),
        meaning="normal force that the pressure adds up to, per metre along y",
    ),
    Quantity("load_unit", of=lambda _: LOAD),
    _of("approach", meaning=REFERENCE),
    *(_of(key) for key in ("control", "given_load")),
    _of(
        "boundary", of=beyond, part=PROBLEM,
        text=lambda r: ": ".join(BOUNDARY[r.boundary]),
    ),
    _of("contact_modulus"),
    _of("ceiling"),
    Quantity(
        "nominal_pressure", "nominal pressure", unit="Pa", meaning="load over length",
        of=lambda r: r.load / r.surface.size[1], stored=False, brief=False,
    ),
    Quantity(
        "contact_length", "contact length", unit="m", of="contact_area", text=_length,
        meaning="points with pressure, and their share of the profile",
    ),
    _of("contact_fraction", name="contact", meaning="share of the profile that touches"),
    _of(
        "saturated_fraction", name="saturated length", meaning="share of the profile at the ceiling"
    ),
    _of("saturated_share", meaning="of the contact length that is at the ceiling"),
    _of("max_pressure", meaning="on any point"),
    _of("mean_pressure", meaning="load over contact length"),
    *(_of(key) for key in ("mean_gap", "max_residual_indentation", "regime", "hertz")),
    *(_of(key) for key in ("warnings", "cautions")),
    Quantity("points", of=lambda r: r.pressure.size),
    Quantity("spacing", unit="m", of=lambda r: r.surface.pixel[1]),
    *(_of(key) for key in ("source", "preparation", "iterations")),
    _of("convolutions", name="convolutions"),
    *(_of(key) for key in ("seconds", "precision", "version")),
)  # fmt: skip
"""Of a `ContactResult` of profiles."""


# Stress below a profile


def _place(stress: StressResult) -> str:
    depth, _, x = (engineering(length, "m") for length in stress.place)
    return f"{depth} deep, at x = {x}"


_SHEAR = "max_orthogonal_shear_along_x"

STRESS: Table = (
    *(quantity_of(tables.STRESS, key) for key in ("body", "friction", "direction")),
    Quantity("kind", of=lambda _: "profile"),
    replace(quantity_of(tables.STRESS, "load"), unit=LOAD),
    *(quantity_of(tables.STRESS, key) for key in ("max_pressure", "max_von_mises")),
    replace(
        quantity_of(tables.STRESS, "max_von_mises_place"),
        of=lambda stress: [stress.place[0], stress.place[2]],
        text=_place,
    ),
    quantity_of(tables.STRESS, "max_tresca"),
    replace(quantity_of(tables.STRESS, _SHEAR), name="orthogonal shear amplitude in a pass"),
    *(quantity_of(tables.STRESS, key) for key in ("yield_strength", "yield_factor")),
    replace(
        quantity_of(tables.STRESS, "yielded_volume"),
        key="yielded_section",
        name="cross-section above the yield strength",
        unit="m²",
    ),
    *(
        quantity_of(tables.STRESS, key)
        for key in ("depths", "warnings", "cautions", "precision", "version")
    ),
)
"""Of a `StressResult` of profiles."""


FIRST_YIELD: Table = (
    replace(tables.FIRST_YIELD[0], name="load of first yield per length", unit=LOAD),
    *tables.FIRST_YIELD[1:],
)
"""Of the `StressResult` at which the first point yields."""


# Many loads


def _share(key: str) -> Callable[[LoadCurve], list[float]]:
    return lambda curve: [getattr(step, key) / curve.nominal_area for step in curve.steps]


def _column(key: str, new: str = "", **changes: Any) -> Column:
    found = next(column for column in tables.CURVE_COLUMNS if column.key == key)
    of = found.of or (lambda curve: [getattr(step, key) for step in curve.steps])
    return replace(found, key=new or key, of=of, **changes)


CURVE: Table = (
    *(
        quantity_of(tables.CURVE, key)
        for key in ("source", "preparation", "control", "given_loads")
    ),
    Quantity("kind", of=lambda _: "profile"),
    Quantity("boundary", of=lambda curve: BOUNDARY[curve.boundary][0]),
    Quantity("length", unit="m", of="nominal_area"),
    *(
        quantity_of(tables.CURVE, key)
        for key in ("contact_modulus", "rms_gradient", "ceiling", "warnings", "cautions")
    ),
    quantity_of(tables.CURVE, "worst_certificate"),
)
"""Of a `LoadCurve` of profiles."""

CURVE_COLUMNS: Columns = (
    _column("load", unit=LOAD),
    _column("approach"),
    _column("contact_area", "contact_length", unit="m", shown=_share("contact_area")),
    _column("saturated_area", "saturated_length", unit="m", shown=_share("saturated_area")),
    *(_column(key) for key in ("max_pressure", "mean_gap")),
    *(_column(key, unit="N/m/m") for key in ("stiffness", "unloading_stiffness")),
    _column("spots", "segments", name="segments"),
    _column("mean_spot_area", "mean_segment", unit="m"),
    _column("largest_spot_area", "largest_segment", unit="m"),
    *(_column(key) for key in ("certificate", "load_error", "pressure_ceiling")),
    *(_column(key) for key in ("convolutions", "seconds")),
)
"""Of the steps of a `LoadCurve` of profiles."""


# The contact segments


def segments(result: ContactResult, spots: Spots) -> list[tuple[str, str, str]]:
    """Return number, length and load of the contact segments, in rows of name, text and meaning.

    Parameters
    ----------
    result : ContactResult
        A contact of profiles.
    spots : Spots
        Its segments, at least one.
    """
    largest, load = float(spots.area[0]), float(spots.load[0])
    share = percent(min(load / float(spots.load.sum()), 1.0))
    return [
        ("Number", str(spots.count), "parts of the profile that touch without a break"),
        ("Mean length", engineering(float(spots.area.mean()), "m"), ""),
        (
            "Longest",
            f"{engineering(largest, 'm')} ({percent(largest / result.contact_area)} of all)",
            f"{round(largest / result.surface.pixel[1])} points",
        ),
        ("Load on the longest", f"{engineering(load, LOAD)} ({share} of the load)", ""),
    ]
