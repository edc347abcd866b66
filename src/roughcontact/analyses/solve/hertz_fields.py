"""Comparison of rough contact with the Hertz contact of the smooth nominal bodies."""

from __future__ import annotations

from typing import Any

from roughcontact.contact import hertz_comparison
from roughcontact.contact.nominal_hertz import CIRCLE, ELLIPSE, LINE, SmoothContact, is_smooth
from roughcontact.contact.result import ContactResult
from roughcontact.report.kind import ABSENT
from roughcontact.units import format_engineering

_SIDES = {
    CIRCLE: ("radius of contact",),
    ELLIPSE: ("longer semi-axis", "shorter semi-axis"),
    LINE: ("half-width",),
}

SIZE = (
    "The size of the rough contact is that of the smooth contact with the same spread of pressure "
    "about its middle."
)


def applies(result: ContactResult) -> bool:
    """Return whether a comparison with Hertz is reported."""
    return result.converged and result.hertz is not None and result.contact_area > 0


def bodies(smooth: SmoothContact) -> str:
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


def heads(result: ContactResult) -> tuple[str, ...]:
    """Return the heads of the columns of `rows`."""
    solved = "solved" if is_smooth(result.pair) else "rough"
    return "compared with Hertz", "smooth (Hertz)", solved, "ratio"


def rows(result: ContactResult) -> list[tuple[str, ...]]:
    """Return the rows of smooth and rough contact: name, both values, and their ratio."""
    smooth = result.hertz
    assert smooth is not None
    names = _SIDES[smooth.shape.kind]
    rows: list[tuple[str, str, float | None, float]] = [
        (name, "m", there, here)
        for name, there, here in zip(
            names, smooth.semi_axes, hertz_comparison.equivalent_hertz_size(result), strict=True
        )
    ]
    rows += [
        ("largest pressure", "Pa", smooth.max_pressure, result.max_pressure),
        ("mean pressure", "Pa", smooth.mean_pressure, result.load / result.contact_area),
        (*_area(result), smooth.area, result.contact_area),
        ("approach", "m", smooth.approach, result.approach),
    ]
    return [_row(*item) for item in rows]


def _area(result: ContactResult) -> tuple[str, str]:
    return ("contact length", "m") if result.pair.is_profile else ("contact area", "m²")


def _row(name: str, unit: str, there: float | None, here: float) -> tuple[str, ...]:
    if there is None:
        return name, ABSENT, format_engineering(here, unit), ABSENT
    return (
        name,
        format_engineering(there, unit),
        format_engineering(here, unit),
        f"{here / there:.4g}",
    )


def record(result: ContactResult) -> dict[str, Any] | None:
    """Return the smooth contact as a JSON record in SI units; None if not reported."""
    if not applies(result):
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
