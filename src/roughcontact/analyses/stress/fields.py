"""Quantities and references of the stress below the surface."""

from __future__ import annotations

from collections.abc import Callable

from roughcontact.analyses.stress import figures as draw
from roughcontact.analyses.stress.model import StressResult
from roughcontact.contact.pair import BODIES
from roughcontact.references import make_use
from roughcontact.report.citations import Uses, stress_references
from roughcontact.report.figures import FRONT, RESULTS, Illustration
from roughcontact.report.kind import CAUTIONS, Quantity, plain_value, profile_table
from roughcontact.report.page import HALF, MIDDLE
from roughcontact.units import format_engineering, format_percent


def _is_profile(stress: StressResult) -> bool:
    return stress.solution.pair.is_profile


def _place(stress: StressResult) -> str:
    depth, y, x = (format_engineering(length, "m") for length in stress.max_von_mises_at)
    return (
        f"{depth} deep, at x = {x}" if _is_profile(stress) else f"{depth} deep, at y, x = {y}, {x}"
    )


def _over_pressure(stress: StressResult) -> str:
    ratio = stress.max_von_mises / stress.solution.max_pressure
    return f"{format_engineering(stress.max_von_mises, 'Pa')} ({ratio:.4g} p_max)"


def _tension_place(stress: StressResult) -> str:
    y, x = (format_engineering(length, "m") for length in stress.max_tension_at)
    return f"at the surface, at y, x = {y}, {x}"


def _has_tension(stress: StressResult) -> bool:
    pulled = stress.friction or stress.traction is not None
    return bool(pulled) and stress.max_tension is not None


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
        f"{names[face.part]} at {format_engineering(face.depth, 'm', 3)}: tension "
        f"{format_engineering(face.tension.value, 'Pa', 3)}, shear "
        f"{format_engineering(face.shear.value, 'Pa', 3)}, pull "
        f"{format_engineering(max(face.pull.value, 0.0), 'Pa', 3)}"
        if face.depth
        else f"surface: tension {format_engineering(face.tension.value, 'Pa', 3)}"
        for face in stress.faces
    )


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


FIGURES = (
    Illustration(
        "stress-depth",
        draw.stress_depth,
        "Largest equivalent stresses at each depth. Look for the depth of the maximum.",
        RESULTS,
        HALF,
    ),
    Illustration(
        "stress-section",
        draw.stress_section,
        "Von Mises stress on the plane along x through its maximum (cross), true to scale.",
        FRONT,
        MIDDLE,
    ),
    Illustration(
        "stress-map",
        draw.stress_map,
        "Largest von Mises stress over all depths, seen from above. The cross marks the maximum.",
        RESULTS,
        HALF,
    ),
)
"""Figures of a `StressResult`."""


def subsurface_references(result: StressResult) -> Uses:
    """Yield the references of the stress, without those of the contact."""
    yield stress_references(result.solution.boundary)
    if result.friction or result.traction is not None:
        yield make_use("stress by friction", "Johnson1985", "Hamilton1983")
