"""Report of an estimate of a nominally flat contact, alone or compared with a solution."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from roughcontact.analyses.estimate.fields import length_of, share, with_ends
from roughcontact.analyses.estimate.model import Estimate, EstimateRange
from roughcontact.material.material import RIGID
from roughcontact.references import make_use
from roughcontact.report import chapters, phrases
from roughcontact.report.kind import CAUTIONS, PROBLEM, CellTable, Quantity, Table, Use, split_label
from roughcontact.report.page import Block
from roughcontact.report.phrases import format_share, format_short
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_engineering, format_percent, plain_decimal


def _range_row(key: str, label: str, form: Callable[[EstimateRange], str]) -> Table:
    """Return the row of a quantity with its interval, and the stored interval ends."""
    unit = f"[{split_label(label)[2]}]"
    return (
        Quantity(key, label, of=f"{key}.value", text=lambda result: form(getattr(result, key))),
        *(Quantity(f"{key}_{end}", unit, of=f"{key}.{end}") for end in ("low", "high")),
    )


def _stiffness_text(result: EstimateRange) -> str:
    """Return a stiffness per area in GPa/µm."""
    return with_ends(result, lambda value: f"{plain_decimal(value * 1e-15, 3)} GPa/µm")


def _conductance_text(result: EstimateRange) -> str:
    return with_ends(result, partial(format_short, unit="W/(m² K)"))


def _roughness_quantity(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, f"{name} [{unit}]: {meaning}", of=f"roughness.{name}", part=PROBLEM)


ESTIMATE = (
    Quantity("pressure", "nominal pressure $p̄$ [Pa]: load over nominal area", part=PROBLEM),
    Quantity(
        "contact_modulus",
        "contact modulus $E*$ [Pa]: from 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂",
        part=PROBLEM,
    ),
    Quantity("ceiling", "pressure ceiling [Pa]", part=PROBLEM),
    _roughness_quantity("Sq", "m", "root-mean-square height"),
    _roughness_quantity("Sdq", "1", "root-mean-square gradient h′"),
    _roughness_quantity("Sal", "m", "autocorrelation length"),
    _roughness_quantity("Str", "1", "texture aspect ratio"),
    _roughness_quantity("Ssk", "1", "skewness"),
    _roughness_quantity("Sku", "1", "kurtosis"),
    Quantity("plasticity_index", "plasticity index $E* h′/σ_Y$", part=PROBLEM),
    *_range_row("contact", "real contact $A/A₀$: of nominal area; in brackets 90 % of maps", share),
    *_range_row("saturated", "saturated area: area at the ceiling over nominal area", share),
    *_range_row("gap", "mean gap $ū$ [m]: of the open gap; closed points count 0", length_of),
    *_range_row(
        "plastic_volume",
        "mean depth with plastic strain [m]: volume of material with any plastic strain over "
        "nominal area, not the displaced volume",
        length_of,
    ),
    *_range_row(
        "stiffness", "normal stiffness [Pa/m]: per nominal area, at unloading", _stiffness_text
    ),
    *_range_row(
        "vacuum_conductance",
        "thermal conductance in vacuum [W/(m² K)]: per nominal area, by the spots alone",
        _conductance_text,
    ),
    *_range_row(
        "air_conductance",
        "thermal conductance in air [W/(m² K)]: per nominal area, with air at 1 bar and 25 °C in "
        "the gap",
        _conductance_text,
    ),
    Quantity("finish"),
    Quantity(
        "theory_contact",
        "Persson's theory: its contact area over nominal area",
        form=format_percent,
    ),
    *CAUTIONS,
)
"""Quantities of an `Estimate`."""


class EstimatePresentation(Presentation):
    """Presentation of an estimate."""

    result: Estimate
    table = ESTIMATE

    def question(self) -> str:
        """Return the question that an estimate answers."""
        pressure = format_engineering(self.result.pressure, "Pa")
        return f"How much of a nominally flat surface is in contact at {pressure}?"

    def problem(self) -> str:
        """Return bodies and load in one line."""
        result = self.result
        parts = [*filter(None, (result.finish,)), f"Sq {format_short(result.roughness.Sq, 'm')}"]
        parts.append(f"Sdq {result.roughness.Sdq:.3g}")
        if result.roughness.Sal is not None:
            parts.append(f"Sal {format_short(result.roughness.Sal, 'm')}")
        bodies = ""
        if result.bodies is not None:
            body, other = map(phrases.material_name, result.bodies)
            bodies = f" ({body}) on a {'rigid flat' if other == RIGID.name else f'flat ({other})'}"
        pressure = format_short(result.pressure, "Pa")
        return f"Nominally flat surface{bodies}, {', '.join(parts)}, {pressure}"

    def answer(self) -> str:
        """Return the contact area with its interval as a sentence."""
        return f"About {with_ends(self.result.contact, format_share)} of the face is in contact."

    def numbers(self) -> CellTable:
        """Return gap, saturated area, plastic depth and plasticity index."""
        result = self.result
        length = partial(with_ends, form=partial(format_short, unit="m"))
        rows: tuple[tuple[str, Any, Callable[[Any], str]], ...] = (
            ("Mean gap", result.gap, length),
            ("At the ceiling", result.saturated, partial(with_ends, form=format_share)),
            ("Plastic depth, mean", result.plastic_volume, length),
            ("Plasticity index", result.plasticity_index, "E*h′/σ_Y = {:.3g}".format),
            ("Normal stiffness", result.stiffness, _stiffness_text),
            ("Conductance in air", result.air_conductance, _conductance_text),
            ("Conductance in vacuum", result.vacuum_conductance, _conductance_text),
        )
        return (), [(name, text(value)) for name, value, text in rows if value is not None]

    def remarks(self) -> tuple[str, ...]:
        """Return the meaning of the intervals, and what the formulas do not cover."""
        meaning = "Intervals hold 90 of 100 such surfaces. Formula, not a solution: solve a map."
        if self.result.finish:
            meaning = (
                "Intervals: slope from Ra and finish to a factor of two, Sq 1.11 to 1.41 Ra, "
                "ceiling 3 σ_Y to the hardness. A map narrows them."
            )
        if self.result.stiffness is not None:
            return (meaning,)
        return (meaning, "No stiffness or conductance: their formulas end at 12 % contact.")

    def inputs(self) -> list[Block]:
        """Return the blocks on both bodies, the surface and the load."""
        if self.result.bodies is None:
            return super().inputs()
        return chapters.body_blocks(self.result.bodies, self.rows(PROBLEM), "ceiling")

    def method(self) -> Iterator[str]:
        """Yield the paragraph on the formulas."""
        yield (
            "Polynomials corrected by Persson's theory, fitted to solved contacts of generated "
            "maps; 90 of 100 such maps are within the intervals. Stiffness and conductance are "
            "those of correlations of flat joints. No solution was computed: nothing is certified."
        )

    def works(self) -> Iterator[Use]:
        """Yield the works on the formulas."""
        yield make_use("formulas of nominally flat contact", "Persson2001", "Yang2008")
        yield make_use("correlations of flat joints", "Cooper1969", "YovanovichCorrelations1982")
        yield make_use("elastic joints", "Mikic1974", "Barber2003")
        if self.result.air_conductance:
            yield make_use("air in the gap", "Yovanovich1982", "Song1993")
