"""Report of the stress below a contact."""

from __future__ import annotations

import math
from dataclasses import replace
from operator import attrgetter
from typing import Any

from roughcontact.analyses.stress import (
    fields as stress_fields,
    figures as draw,
    illustrations as stress_illustrations,
)
from roughcontact.analyses.stress.model import StressResult, to_dataset
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.errors import ArgumentRef, Sentence
from roughcontact.report import chapters, phrases
from roughcontact.report.kind import CellTable, Presentation, Row, rows_of
from roughcontact.report.page import Block


def first_yield(onset: StressResult, brief: bool = False) -> list[Row]:
    """Return the rows on the contact at the load of first yield."""
    of_profile = onset.solution.pair.is_profile
    return rows_of(
        stress_fields.PROFILE_FIRST_YIELD if of_profile else stress_fields.FIRST_YIELD,
        onset,
        brief=brief,
    )


def question(stress: StressResult) -> str:
    """Return the question that a stress answers."""
    contact = stress.solution
    name = phrases.source(contact.surface.provenance)
    return f"How large is the stress below {name} {phrases.load_phrase(contact)}?"


def _details(
    stress: StressResult, scene: Any, onset: StressResult | None = None, **more: Any
) -> list[Block]:
    return [] if onset is None else chapters.quantities(first_yield(onset))


def _method(_: StressResult) -> list[Block]:
    return [Block("text", "Elastic stress below the contact pressure. Tension is positive.")]


# --- Headline ---


# Relative tolerance of the yield strength, as in `first_yield_load`.
_AT_YIELD = 1e-3


def _load(stress: StressResult) -> str:
    solution = stress.solution
    load = phrases.format_short(solution.load, solution.pair.load_unit)
    if has_nominal_body(solution.pair.origins):
        return load
    pressure = phrases.format_short(solution.load / solution.nominal_area, "Pa")
    return f"{load} ({pressure} nominal)"


def _answer(stress: StressResult, onset: StressResult | None = None) -> str:
    """Return largest stress, its depth, and whether the material yields, as a sentence."""
    if stress.overall is not None:
        there = phrases.format_short(stress.max_von_mises, "Pa")
        deep = phrases.format_short(stress.max_von_mises_at[0], "m")
        return f"{_answer(stress.overall, onset)} At the given depths: {there}, {deep} deep."
    depth = stress.max_von_mises_at[0]
    reached = phrases.format_short(stress.max_von_mises, "Pa")
    where = f"{phrases.format_short(depth, 'm')} deep" if depth else "at the surface"
    if stress.parts:
        under = (
            "" if stress.base is None else f" With the ceiling of the base: {_layered(stress.base)}"
        )
        return _layered(stress) + under
    strength = stress.material.yield_strength
    if strength is None:
        return f"The von Mises stress reaches {reached}, {where}."
    if math.isclose(stress.max_von_mises, strength, rel_tol=_AT_YIELD):
        return (
            f"First yield at {_load(stress)}, {where}; σ_Y = "
            f"{phrases.format_short(strength, 'Pa')}."
        )
    known = f"(σ_Y = {phrases.format_short(strength, 'Pa')})"
    if stress.max_von_mises > strength:
        return f"The material yields: the von Mises stress reaches {reached} {known}, {where}."
    return f"Nothing yields: the von Mises stress reaches {reached} {known}, {where}."


def _layered(stress: StressResult) -> str:
    """Return the layer (or base) closest to its strength, as a sentence."""
    known = [part for part in stress.parts if part.strength]
    if not known:
        largest = max(stress.parts, key=lambda part: part.max_von_mises)
        reached = phrases.format_short(largest.max_von_mises, "Pa")
        return f"The von Mises stress reaches {reached}, in {largest.name}."
    first = max(known, key=lambda part: part.use)
    reached, strength = (
        phrases.format_short(value or 0.0, "Pa") for value in (first.max_von_mises, first.strength)
    )
    where = f"{phrases.format_short(first.depth, 'm')} deep" if first.depth else "at the surface"
    if first.of_hardness:
        strength += " (a third of its hardness)"
    if first.use > 1:
        return f"{first.name} yields first: {reached} of {strength}, {where}."
    return f"Nothing yields; nearest is {first.name}: {reached} of {strength}, {where}."


def _layer_rows(stress: StressResult) -> list[tuple[str, str]]:
    """Return the largest stress of each layer, and the tractions of its interfaces."""
    rows = []
    for part in stress.parts:
        reached, depth = (
            phrases.format_short(part.max_von_mises, "Pa"),
            phrases.format_short(part.depth, "m"),
        )
        rows.append((part.name, f"von Mises {reached}, {depth} deep"))
    surface, *others = stress.faces
    rows.append(("Tension at surface", phrases.format_short(surface.tension.value, "Pa")))
    for face in others[::2]:
        name = stress.parts[face.part].name
        rows.append(
            (
                f"Bottom of {name}",
                f"tension {phrases.format_short(face.tension.value, 'Pa')}, shear "
                f"{phrases.format_short(face.shear.value, 'Pa')}, pull "
                f"{phrases.format_short(max(face.pull.value, 0.0), 'Pa')}",
            )
        )
    return rows


def _numbers(stress: StressResult, onset: StressResult | None = None) -> CellTable:
    """Return largest stress, its position, load of first yield and orthogonal shear."""
    kind = _kind(stress)
    if stress.base is not None:
        columns = zip(_layer_rows(stress), _layer_rows(stress.base), strict=True)
        heads = ("", "ceiling of the coating", "ceiling of the base")
        return heads, [(*first, second[1]) for first, second in columns]
    if stress.parts:
        return (), _layer_rows(stress)
    rows = [
        ("Maximum von Mises", kind.row(stress, "max_von_mises").text),
        ("At", kind.row(stress, "max_von_mises_place").text),
    ]
    if onset is not None:
        rows.append(("Yields from", _load(onset)))
    if not stress.solution.pair.is_profile:
        shear = (
            f"±{kind.row(stress, f'max_orthogonal_shear_along_{axis}').text} along {axis}"
            for axis in "yx"
        )
        rows.append(("Orthogonal shear", ", ".join(shear)))
    return (), rows


def _remarks(stress: StressResult, onset: StressResult | None = None) -> tuple[str, ...]:
    """Return the accuracy of the contact, and a hint for the plastic depth if it yields."""
    strength = None if stress.parts else stress.material.yield_strength
    lines = [phrases.status(stress.solution)]
    if strength is not None and stress.max_von_mises > strength * (1 + _AT_YIELD):
        lines.append(Sentence(f"Plastic depth: {ArgumentRef('rc.solve_elastoplastic')}"))
    return tuple(lines)


KIND = Presentation(
    StressResult,
    stress_fields.STRESS,
    figures=stress_illustrations.STRESS,
    plots=(draw.stress_section, draw.stress_depth, draw.stress_map),
    contact=attrgetter("solution"),
    works=stress_fields.subsurface_references,
    dataset=to_dataset,
    problem=lambda stress: phrases.problem(stress.solution),
    answer=_answer,
    numbers=_numbers,
    remarks=_remarks,
    question=question,
    details=_details,
    method=_method,
)
PROFILE_KIND = replace(
    KIND,
    table=stress_fields.PROFILE_STRESS,
    when=lambda stress: stress.solution.pair.is_profile,
    # A profile has no map.
    figures=stress_illustrations.STRESS[:2],
    plots=KIND.plots[:2],
)


def _kind(stress: StressResult) -> Presentation:
    return PROFILE_KIND if stress.solution.pair.is_profile else KIND
