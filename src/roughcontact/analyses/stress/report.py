"""Report of the stress below a contact."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

from roughcontact._tools.netcdf import Dataset
from roughcontact.analyses.stress.figures import stress_depth, stress_map, stress_section
from roughcontact.analyses.stress.model import StressResult, to_dataset
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.pair import BODIES
from roughcontact.halfspace.coating_stress import Face
from roughcontact.references import make_use
from roughcontact.report import chapters, phrases
from roughcontact.report.citations import Uses, stress_references
from roughcontact.report.figures import FRONT, RESULTS, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    CellTable,
    Quantity,
    Row,
    plain_value,
    profile_table,
    rows_of,
)
from roughcontact.report.page import HALF, MIDDLE, Block
from roughcontact.report.phrases import format_short
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_engineering, format_percent


def _place(stress: StressResult) -> str:
    depth, *center = stress.max_von_mises_at
    is_profile = stress.solution.pair.is_profile
    return f"{format_engineering(depth, 'm')} deep, {phrases.place(center, is_profile)}"


def _over_pressure(stress: StressResult) -> str:
    ratio = stress.max_von_mises / stress.solution.max_pressure
    return f"{format_engineering(stress.max_von_mises, 'Pa')} ({ratio:.4g} p_max)"


def _tension_place(stress: StressResult) -> str:
    return f"at the surface, {phrases.place(stress.max_tension_at)}"


def _has_tension(stress: StressResult) -> bool:
    return bool(stress.friction or stress.traction is not None) and stress.max_tension is not None


def _shear(axis: int) -> Callable[[StressResult], float]:
    return lambda stress: stress.profile.max_orthogonal_shear[axis]


def _by_part(stress: StressResult) -> str:
    return "; ".join(
        f"{part.name} {format_engineering(part.max_von_mises, 'Pa', 3)}, "
        f"{format_engineering(part.depth, 'm', 3)} deep"
        + ("" if part.strength is None else f" ({format_percent(part.use)} of its strength)")
        for part in stress.parts
    )


def _interface_stresses(stress: StressResult) -> str:
    names = [part.name for part in stress.parts]
    return "; ".join(
        f"{names[face.part]} at {format_engineering(face.depth, 'm', 3)}: {_tractions(face)}"
        if face.depth
        else f"surface: tension {format_engineering(face.tension.value, 'Pa', 3)}"
        for face in stress.faces
    )


def _tractions(face: Face) -> str:
    """Return tension, shear and pull at an interface."""
    tension, shear, pull = (
        format_engineering(value, "Pa", 3)
        for value in (face.tension.value, face.shear.value, max(face.pull.value, 0.0))
    )
    return f"tension {tension}, shear {shear}, pull {pull}"


STRESS = (
    Quantity("body", "evaluated body", text=lambda stress: f"the {BODIES[stress.body]}"),
    Quantity(
        "friction",
        "friction $μ$: traction over pressure",
        when=lambda stress: bool(stress.friction),
    ),
    Quantity(
        "direction",
        "direction of friction [°]: from x, counter-clockwise",
        form=lambda v: f"{v:g}°",
        when=lambda stress: bool(stress.friction),
    ),
    Quantity("load", "[N]", of="solution.load"),
    Quantity("max_pressure", "[Pa]", of="solution.max_pressure"),
    Quantity("max_von_mises", "largest von Mises stress [Pa]", text=_over_pressure),
    Quantity("max_von_mises_place", "its place [m]", of="max_von_mises_at", text=_place),
    Quantity("parts", "by layer", text=_by_part),
    Quantity("faces", "at faces", text=_interface_stresses),
    Quantity(
        "overall",
        of=lambda s: s.overall and [s.overall.max_von_mises, s.overall.max_von_mises_at[0]],
    ),
    Quantity(
        "base",
        of=lambda s: (
            s.base
            and {
                "ceiling": s.base.solution.ceiling,
                "parts": plain_value(s.base.parts),
                "faces": plain_value(s.base.faces),
            }
        ),
    ),
    Quantity("max_tension", "largest tension [Pa]", when=_has_tension),
    Quantity(
        "max_tension_place",
        "its place [m]",
        of="max_tension_at",
        text=_tension_place,
        when=_has_tension,
    ),
    Quantity("max_tresca", "largest Tresca stress [Pa]", of="profile.max_tresca"),
    Quantity(
        "max_orthogonal_shear_along_y",
        "orthogonal shear amplitude, pass along y [Pa]",
        of=_shear(0),
    ),
    Quantity(
        "max_orthogonal_shear_along_x",
        "orthogonal shear amplitude, pass along x [Pa]",
        of=_shear(1),
    ),
    Quantity("yield_strength", "[Pa]", of="profile.yield_strength"),
    Quantity("yield_factor", "yield strength over largest stress", of="profile.yield_factor"),
    Quantity("yielded_volume", "volume above the yield strength [m³]", of="profile.yielded_volume"),
    Quantity(
        "depths", "[m]", of=lambda s: [float(s.profile.depths[0]), float(s.profile.depths[-1])]
    ),
    *CAUTIONS,
    Quantity("precision"),
    Quantity("version"),
)
"""Quantities of a `StressResult`."""


FIRST_YIELD = (
    Quantity("load", "load of first yield [N]", of="solution.load"),
    Quantity("max_pressure", "largest pressure at first yield [Pa]", of="solution.max_pressure"),
)
"""Quantities of the `StressResult` at first yield."""


PROFILE_STRESS = (
    *profile_table(
        STRESS,
        *("parts", "faces", "overall", "base"),
        *("max_tension_place", "max_orthogonal_shear_along_y"),
        max_von_mises_place={"of": lambda stress: list(stress.max_von_mises_at[::2])},
        max_orthogonal_shear_along_x={"label": "orthogonal shear amplitude in a pass [Pa]"},
    ),
    Quantity("kind", of=lambda _: "profile"),
)
"""Quantities of a `StressResult` of profiles."""


def subsurface_references(result: StressResult) -> Uses:
    """Yield the references of the stress, without those of the contact."""
    yield stress_references(result.solution.boundary)
    if result.friction or result.traction is not None:
        yield make_use("stress by friction", "Johnson1985", "Hamilton1983")


FIGURES = (
    Illustration(
        "stress-depth",
        stress_depth,
        "Largest equivalent stresses at each depth. Look for the depth of the maximum.",
        RESULTS,
        HALF,
    ),
    Illustration(
        "stress-section",
        stress_section,
        "Von Mises stress on the plane along x through its maximum (cross), true to scale.",
        FRONT,
        MIDDLE,
    ),
    Illustration(
        "stress-map",
        stress_map,
        "Largest von Mises stress over all depths, seen from above. The cross marks the maximum.",
        RESULTS,
        HALF,
    ),
)
"""Figures of a `StressResult`."""


def _first_yield(onset: StressResult) -> list[Row]:
    """Return the rows on the contact at the load of first yield."""
    changes = {"load": {"label": "load of first yield per length [N/m]"}}
    of_profile = profile_table(FIRST_YIELD, **changes)
    return rows_of(of_profile if onset.solution.pair.is_profile else FIRST_YIELD, onset)


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
            "" if stress.base is None else f" With the ceiling of the base: {_weakest(stress.base)}"
        )
        return _weakest(stress) + under
    strength = stress.material.yield_strength
    if strength is None:
        return f"The von Mises stress reaches {reached}, {where}."
    if math.isclose(stress.max_von_mises, strength, rel_tol=_AT_YIELD):
        return f"First yield at {_load(stress)}, {where}; σ_Y = {format_short(strength, 'Pa')}."
    known = f"{reached} (σ_Y = {format_short(strength, 'Pa')})".replace(") (", "; ")
    if stress.max_von_mises > strength:
        return f"The material yields: the von Mises stress reaches {known}, {where}."
    return f"{_unyielding(stress)}: the von Mises stress reaches {known}, {where}."


def _unyielding(stress: StressResult) -> str:
    """Return whether a pressure ceiling is reached where the body itself does not yield."""
    if not stress.solution.totals.saturated:
        return "Nothing yields"
    name = "body" if stress.body == "body" else "counter-body"
    return f"The {name} does not yield, but the contact reaches its pressure ceiling"


def _weakest(stress: StressResult) -> str:
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
    return f"{_unyielding(stress)}; nearest is {first.name}: {reached} of {strength}, {where}."


def _layer_rows(stress: StressResult) -> list[tuple[str, str]]:
    """Return the largest stress of each layer, and the tractions of its interfaces."""
    rows = []
    for part in stress.parts:
        reached, depth = (format_short(part.max_von_mises, "Pa"), format_short(part.depth, "m"))
        rows.append((part.name, f"von Mises {reached}, {depth} deep"))
    surface, *others = stress.faces
    rows.append(("Tension at surface", format_short(surface.tension.value, "Pa")))
    bottoms = [(f"Bottom of {stress.parts[face.part].name}", face) for face in others[::2]]
    return [*rows, *((name, _tractions(face)) for name, face in bottoms)]


class StressPresentation(Presentation):
    """Presentation of the stress below a contact."""

    result: StressResult
    table = STRESS
    figures = FIGURES
    plots = (stress_section, stress_depth, stress_map)
    profile_table = PROFILE_STRESS
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
        return subsurface_references(self.result)

    def dataset(self) -> Dataset:
        """Return the stress maps."""
        return to_dataset(self.result)
