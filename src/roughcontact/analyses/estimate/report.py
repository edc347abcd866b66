"""Report of an estimate of a nominally flat contact, alone or compared with a solution."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from roughcontact.analyses.estimate.fields import length_of, share
from roughcontact.analyses.estimate.model import Estimate, EstimateRange
from roughcontact.material.material import RIGID
from roughcontact.references import make_use
from roughcontact.report import phrases
from roughcontact.report.kind import CAUTIONS, PROBLEM, CellTable, Presentation, Quantity, Table
from roughcontact.units import format_engineering, format_percent, plain_decimal

_ENDS = ("low", "high")


def _ranged(
    key: str, name: str, unit: str, meaning: str, symbol: str, form: Callable[[EstimateRange], str]
) -> Table:
    """Return the row of a quantity with its interval, and the stored interval ends."""

    def part(end: str) -> Callable[[Any], Any]:
        def value(result: Any) -> Any:
            whole = getattr(result, key)
            return None if whole is None else getattr(whole, end)

        return value

    return (
        Quantity(
            key,
            name,
            symbol=symbol,
            unit=unit,
            meaning=meaning,
            of=part("value"),
            text=lambda result: form(getattr(result, key)),
            when=lambda result: getattr(result, key) is not None,
        ),
        *(Quantity(f"{key}_{end}", unit=unit, of=part(end)) for end in _ENDS),
    )


def _roughness_quantity(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(
        name,
        name,
        unit=unit,
        meaning=meaning,
        of=lambda result: getattr(result.roughness, name),
        part=PROBLEM,
        when=lambda result: getattr(result.roughness, name) is not None,
    )


def _per_length(value: float) -> str:
    """Return a stiffness per area in GPa/µm."""
    return f"{plain_decimal(value * 1e-15, 3)} GPa/µm"


def _form(result: EstimateRange, unit: str) -> str:
    return _ends(result, partial(phrases.format_short, unit=unit))


def _limited(result: Estimate) -> bool:
    return result.ceiling is not None


ESTIMATE: Table = (
    Quantity("pressure", "nominal pressure", "p̄", "Pa", "load over nominal area", part=PROBLEM),
    Quantity(
        "contact_modulus",
        "contact modulus",
        symbol="E*",
        unit="Pa",
        meaning="from 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂",
        part=PROBLEM,
    ),
    Quantity("ceiling", "pressure ceiling", unit="Pa", part=PROBLEM, when=_limited),
    _roughness_quantity("Sq", "m", "root-mean-square height"),
    _roughness_quantity("Sdq", "1", "root-mean-square gradient h′"),
    _roughness_quantity("Sal", "m", "autocorrelation length"),
    _roughness_quantity("Str", "1", "texture aspect ratio"),
    _roughness_quantity("Ssk", "1", "skewness"),
    _roughness_quantity("Sku", "1", "kurtosis"),
    Quantity(
        "plasticity_index",
        "plasticity index",
        symbol="E* h′/σ_Y",
        part=PROBLEM,
        when=lambda result: result.plasticity_index is not None,
    ),
    *_ranged(
        "contact", "real contact", "1", "of nominal area; in brackets 90 % of maps", "A/A₀", share
    ),
    *_ranged(
        "saturated", "saturated area", "1", "area at the ceiling over nominal area", "", share
    ),
    *_ranged("gap", "mean gap", "m", "of the open gap; closed points count 0", "ū", length_of),
    *_ranged(
        "plastic_volume",
        "mean depth with plastic strain",
        "m",
        "volume of material with any plastic strain over nominal area, not the displaced volume",
        "",
        length_of,
    ),
    *_ranged(
        "stiffness",
        "normal stiffness",
        "Pa/m",
        "per nominal area, at unloading",
        "",
        lambda result: _ends(result, _per_length),
    ),
    *_ranged(
        "vacuum_conductance",
        "thermal conductance in vacuum",
        "W/(m² K)",
        "per nominal area, by the spots alone",
        "",
        partial(_form, unit="W/(m² K)"),
    ),
    *_ranged(
        "air_conductance",
        "thermal conductance in air",
        "W/(m² K)",
        "per nominal area, with air at 1 bar and 25 °C in the gap",
        "",
        partial(_form, unit="W/(m² K)"),
    ),
    Quantity("finish", stored=True),
    Quantity(
        "theory_contact",
        "Persson's theory",
        meaning="its contact area over nominal area",
        form=format_percent,
    ),
    *CAUTIONS,
)
"""Quantities of an `Estimate`."""


# --- Headline ---


def _problem(result: Estimate) -> str:
    parts = [result.finish] if result.finish else []
    parts += [f"Sq {phrases.format_short(result.roughness.Sq, 'm')}"]
    if result.roughness.Sdq is not None:
        parts.append(f"Sdq {result.roughness.Sdq:.3g}")
    if result.roughness.Sal is not None:
        parts.append(f"Sal {phrases.format_short(result.roughness.Sal, 'm')}")
    bodies = ""
    if result.bodies is not None:
        body, other = map(phrases.material_name, result.bodies)
        bodies = f" ({body}) on a {'rigid flat' if other == RIGID.name else f'flat ({other})'}"
    pressure = phrases.format_short(result.pressure, "Pa")
    return f"Nominally flat surface{bodies}, {', '.join(parts)}, {pressure}"


def _ends(result: EstimateRange, form: Callable[[float], str]) -> str:
    return f"{form(result.value)} ({phrases.range_text(result.low, result.high, form)})"


def _answer(result: Estimate) -> str:
    """Return the contact area with its interval as a sentence."""
    return f"About {_ends(result.contact, phrases.format_share)} of the face is in contact."


def _numbers(result: Estimate) -> CellTable:
    """Return gap, saturated area, plastic depth and plasticity index."""
    length = partial(phrases.format_short, unit="m")
    rows = [("Mean gap", _ends(result.gap, length))]
    if result.saturated is not None:
        rows.append(("At the ceiling", _ends(result.saturated, phrases.format_share)))
    if result.plastic_volume is not None:
        rows.append(("Plastic depth, mean", _ends(result.plastic_volume, length)))
    if result.plasticity_index is not None:
        rows.append(("Plasticity index", f"E*h′/σ_Y = {result.plasticity_index:.3g}"))
    if result.stiffness is not None:
        rows.append(("Normal stiffness", _ends(result.stiffness, _per_length)))
    for name, conductance in (
        ("in air", result.air_conductance),
        ("in vacuum", result.vacuum_conductance),
    ):
        if conductance is not None:
            rows.append((f"Conductance {name}", _form(conductance, "W/(m² K)")))
    return (), rows


def _remarks(result: Estimate) -> tuple[str, ...]:
    """Return the meaning of the intervals."""
    if result.finish:
        return (
            "Intervals: slope from Ra and finish to a factor of two, Sq 1.11 to 1.41 Ra, ceiling "
            "3 σ_Y to the hardness. A map narrows them.",
        )
    return ("Intervals hold 90 of 100 such surfaces. Formula, not a solution: solve a map.",)


def question(result: Estimate) -> str:
    """Return the question that an estimate answers."""
    pressure = format_engineering(result.pressure, "Pa")
    return f"How much of a nominally flat surface is in contact at {pressure}?"


KIND = Presentation(
    Estimate,
    ESTIMATE,
    question=question,
    works=lambda result: (
        make_use("formulas of nominally flat contact", "Persson2001", "Yang2008"),
        make_use("correlations of flat joints", "Cooper1969", "Mikic1974", "Barber2003"),
        *(
            (make_use("air in the gap", "Yovanovich1982", "Song1993"),)
            if result.air_conductance
            else ()
        ),
    ),
    problem=_problem,
    answer=_answer,
    numbers=_numbers,
    remarks=_remarks,
)
