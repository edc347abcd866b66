"""Report of the stress below a contact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from roughcontact._tools.netcdf import Dataset
from roughcontact.analyses.stress import fields as stress_fields, figures as draw
from roughcontact.analyses.stress.model import StressResult, to_dataset
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.report import chapters, phrases
from roughcontact.report.citations import Uses
from roughcontact.report.kind import CellTable, Row, profile_table, rows_of
from roughcontact.report.page import Block
from roughcontact.report.phrases import format_short
from roughcontact.report.presentation import Presentation


def _first_yield(onset: StressResult) -> list[Row]:
    """Return the rows on the contact at the load of first yield."""
    changes = {"load": {"label": "load of first yield per length [N/m]"}}
    of_profile = profile_table(stress_fields.FIRST_YIELD, **changes)
    return rows_of(
        of_profile if onset.solution.pair.is_profile else stress_fields.FIRST_YIELD, onset
    )


# Relative tolerance of the yield strength, as in `first_yield_load`.
_AT_YIELD = 1e-3


def _load(stress: StressResult) -> str:
    solution = stress.solution
    load = format_short(solution.load, solution.pair.load_unit)
    if has_nominal_body(solution.pair.origins):
        return load
    pressure = format_short(solution.load / solution.nominal_area, "Pa")
    return f"{load} ({pressure} nominal)"


def _answer(stress: StressResult) -> str:
    """Return largest stress, its depth, and whether the material yields, as a sentence."""
    if stress.overall is not None:
        there = format_short(stress.max_von_mises, "Pa")
        deep = format_short(stress.max_von_mises_at[0], "m")
        return f"{_answer(stress.overall)} At the given depths: {there}, {deep} deep."
    depth, other = stress.max_von_mises_at[0], stress.calibrated
    reached = phrases.with_range(
        stress.max_von_mises,
        None if other is None else other.max_von_mises,
        partial(format_short, unit="Pa"),
    )
    where = f"{format_short(depth, 'm')} deep" if depth else "at the surface"
    if stress.parts:
        under = (
            "" if stress.base is None else f" With the ceiling of the base: {_layered(stress.base)}"
        )
        return _layered(stress) + under
    strength = stress.material.yield_strength
    if strength is None:
        return f"The von Mises stress reaches {reached}, {where}."
    if math.isclose(stress.max_von_mises, strength, rel_tol=_AT_YIELD):
        return f"First yield at {_load(stress)}, {where}; σ_Y = {format_short(strength, 'Pa')}."
    known = f"{reached} (σ_Y = {format_short(strength, 'Pa')})".replace(") (", "; ")
    if stress.max_von_mises > strength:
        return f"The material yields: the von Mises stress reaches {known}, {where}."
    return f"Nothing yields: the von Mises stress reaches {known}, {where}."


def _layered(stress: StressResult) -> str:
    """Return the layer (or base) closest to its strength, as a sentence."""
    known = [part for part in stress.parts if part.strength]
    if not known:
        largest = max(stress.parts, key=lambda part: part.max_von_mises)
        reached = format_short(largest.max_von_mises, "Pa")
        return f"The von Mises stress reaches {reached}, in {largest.name}."
    first = max(known, key=lambda part: part.use)
    reached, strength = (
        format_short(value or 0.0, "Pa") for value in (first.max_von_mises, first.strength)
    )
    where = f"{format_short(first.depth, 'm')} deep" if first.depth else "at the surface"
    if first.of_hardness:
        strength += " (a third of its hardness)"
    if first.use > 1:
        return f"{first.name} yields first: {reached} of {strength}, {where}."
    return f"Nothing yields; nearest is {first.name}: {reached} of {strength}, {where}."


def _layer_rows(stress: StressResult) -> list[tuple[str, str]]:
    """Return the largest stress of each layer, and the tractions of its interfaces."""
    rows = []
    for part in stress.parts:
        reached, depth = (format_short(part.max_von_mises, "Pa"), format_short(part.depth, "m"))
        rows.append((part.name, f"von Mises {reached}, {depth} deep"))
    surface, *others = stress.faces
    rows.append(("Tension at surface", format_short(surface.tension.value, "Pa")))
    for face in others[::2]:
        name = stress.parts[face.part].name
        rows.append(
            (
                f"Bottom of {name}",
                f"tension {format_short(face.tension.value, 'Pa')}, shear "
                f"{format_short(face.shear.value, 'Pa')}, pull "
                f"{format_short(max(face.pull.value, 0.0), 'Pa')}",
            )
        )
    return rows


class StressPresentation(Presentation):
    """Presentation of the stress below a contact."""

    result: StressResult
    table = stress_fields.STRESS
    figures = stress_fields.FIGURES
    plots = (draw.stress_section, draw.stress_depth, draw.stress_map)
    profile_table = stress_fields.PROFILE_STRESS
    # A profile has no map.
    profile_figures = figures[:2]
    profile_plots = plots[:2]
    contact_name = "solution"

    def answer(self) -> str:
        """Return largest stress, its depth, and whether the material yields, as a sentence."""
        return _answer(self.result)

    def question(self) -> str:
        """Return the question that a stress answers."""
        contact = self.result.solution
        name = phrases.source(contact.surface.provenance)
        return f"How large is the stress below {name} {phrases.load_phrase(contact)}?"

    def numbers(self) -> CellTable:
        """Return largest stress, its position, load of first yield and orthogonal shear."""
        stress = self.result
        if stress.base is not None:
            columns = zip(_layer_rows(stress), _layer_rows(stress.base), strict=True)
            heads = ("", "ceiling of the coating", "ceiling of the base")
            return heads, [(*first, second[1]) for first, second in columns]
        if stress.parts:
            return (), _layer_rows(stress)
        rows = [
            ("Maximum von Mises", self.row("max_von_mises").text),
            ("At", self.row("max_von_mises_place").text),
        ]
        if self.onset is not None:
            rows.append(("Yields from", _load(self.onset)))
        if not stress.solution.pair.is_profile:
            shear = (
                f"±{format_short(amplitude, 'Pa')} {axis}"
                for axis, amplitude in zip("yx", stress.profile.max_orthogonal_shear, strict=True)
            )
            rows.append(("Orthogonal shear", ", ".join(shear)))
        return (), rows

    def remarks(self) -> Iterator[str]:
        """Yield the accuracy of the contact."""
        yield phrases.status(self.result.solution)

    def details(self) -> list[Block]:
        """Return further blocks of results."""
        return [] if self.onset is None else chapters.quantities(_first_yield(self.onset))

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the method."""
        yield "Elastic stress below the contact pressure. Tension is positive."

    def works(self) -> Uses:
        """Yield the works on the stress."""
        return stress_fields.subsurface_references(self.result)

    def dataset(self) -> Dataset:
        """Return the stress maps."""
        return to_dataset(self.result)
