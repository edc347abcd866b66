"""Quantities and references of the stress below the surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace

from roughcontact.analyses.solve.fields import LOAD
from roughcontact.analyses.stress.model import StressResult
from roughcontact.contact.pair import BODIES
from roughcontact.references import make_use
from roughcontact.report.citations import Uses, stress_references
from roughcontact.report.kind import CAUTIONS, Quantity, Table, pick_quantities, quantity_of
from roughcontact.units import format_engineering, format_percent


def _bears(key: str) -> Callable[[StressResult], bool]:
    return lambda stress: getattr(stress.profile, key) is not None


def _place(stress: StressResult) -> str:
    depth, y, x = (format_engineering(length, "m") for length in stress.max_von_mises_at)
    return f"{depth} deep, at y, x = {y}, {x}"


def _over_pressure(stress: StressResult) -> str:
    ratio = stress.max_von_mises / stress.solution.max_pressure
    return f"{format_engineering(stress.max_von_mises, 'Pa')} ({ratio:.4g} of the largest pressure)"


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


STRESS: Table = (
    Quantity("body", "evaluated body", text=lambda stress: f"the {BODIES[stress.body]}"),
    Quantity(
        "friction",
        "friction",
        symbol="μ",
        meaning="traction over pressure",
        when=lambda stress: bool(stress.friction),
    ),
    Quantity(
        "direction",
        "direction of friction",
        unit="°",
        form=lambda v: f"{v:g}°",
        meaning="from x, counter-clockwise",
        when=lambda stress: bool(stress.friction),
    ),
    Quantity("load", unit="N", of="solution.load"),
    Quantity("max_pressure", unit="Pa", of="solution.max_pressure"),
    Quantity("max_von_mises", "largest von Mises stress", unit="Pa", text=_over_pressure),
    Quantity(
        "max_von_mises_place",
        "its place",
        unit="m",
        of=lambda stress: list(stress.max_von_mises_at),
        text=_place,
    ),
    Quantity(
        "parts",
        "by layer",
        of=lambda s: [part._asdict() for part in s.parts],
        when=lambda s: bool(s.parts),
        text=_by_part,
    ),
    Quantity(
        "faces",
        "at faces",
        of=lambda s: [asdict(face) for face in s.faces],
        when=lambda s: bool(s.faces),
        text=_interface_stresses,
    ),
    Quantity(
        "overall",
        of=lambda s: s.overall and [s.overall.max_von_mises, s.overall.max_von_mises_at[0]],
        when=lambda s: s.overall is not None,
    ),
    Quantity(
        "base",
        of=lambda s: (
            s.base
            and {
                "ceiling": s.base.solution.ceiling,
                "parts": [part._asdict() for part in s.base.parts],
                "faces": [asdict(face) for face in s.base.faces],
            }
        ),
        when=lambda s: s.base is not None,
    ),
    Quantity("max_tension", "largest tension", unit="Pa", when=_has_tension),
    Quantity(
        "max_tension_place",
        "its place",
        unit="m",
        of=lambda stress: list(stress.max_tension_at),
        text=_tension_place,
        when=_has_tension,
    ),
    Quantity("max_tresca", "largest Tresca stress", unit="Pa", of="profile.max_tresca"),
    Quantity(
        "max_orthogonal_shear_along_y",
        "orthogonal shear amplitude, pass along y",
        unit="Pa",
        of=_shear(0),
    ),
    Quantity(
        "max_orthogonal_shear_along_x",
        "orthogonal shear amplitude, pass along x",
        unit="Pa",
        of=_shear(1),
    ),
    Quantity("yield_strength", unit="Pa", of="profile.yield_strength"),
    Quantity(
        "yield_factor",
        "yield strength over largest stress",
        of="profile.yield_factor",
        when=_bears("yield_factor"),
    ),
    Quantity(
        "yielded_volume",
        "volume above the yield strength",
        unit="m³",
        of="profile.yielded_volume",
        when=_bears("yielded_volume"),
    ),
    Quantity(
        "depths", unit="m", of=lambda s: [float(s.profile.depths[0]), float(s.profile.depths[-1])]
    ),
    *CAUTIONS,
    Quantity("precision"),
    Quantity("version"),
)
"""Quantities of a `StressResult`."""


FIRST_YIELD: Table = (
    Quantity("load", "load of first yield", unit="N", of="solution.load"),
    Quantity(
        "max_pressure", "largest pressure at first yield", unit="Pa", of="solution.max_pressure"
    ),
)
"""Quantities of the `StressResult` at first yield."""


def _profile_place(stress: StressResult) -> str:
    depth, _, x = (format_engineering(length, "m") for length in stress.max_von_mises_at)
    return f"{depth} deep, at x = {x}"


_SHEAR = "max_orthogonal_shear_along_x"


PROFILE_STRESS: Table = (
    *pick_quantities(STRESS, "body", "friction", "direction"),
    Quantity("kind", of=lambda _: "profile"),
    replace(quantity_of(STRESS, "load"), unit=LOAD),
    *pick_quantities(STRESS, "max_pressure", "max_von_mises"),
    replace(
        quantity_of(STRESS, "max_von_mises_place"),
        of=lambda stress: [stress.max_von_mises_at[0], stress.max_von_mises_at[2]],
        text=_profile_place,
    ),
    *pick_quantities(STRESS, "max_tension", "max_tresca"),
    replace(quantity_of(STRESS, _SHEAR), name="orthogonal shear amplitude in a pass"),
    *pick_quantities(STRESS, "yield_strength", "yield_factor"),
    replace(
        quantity_of(STRESS, "yielded_volume"),
        key="yielded_section",
        name="cross-section above the yield strength",
        unit="m²",
    ),
    *pick_quantities(STRESS, "depths", "warnings", "cautions", "precision", "version"),
)
"""Quantities of a `StressResult` of profiles."""


PROFILE_FIRST_YIELD: Table = (
    replace(FIRST_YIELD[0], name="load of first yield per length", unit=LOAD),
    *FIRST_YIELD[1:],
)
"""Quantities of the `StressResult` of profiles at first yield."""


def subsurface_references(result: StressResult) -> Uses:
    """Yield the references of the stress, without those of the contact."""
    yield stress_references(result.solution.boundary)
    if result.friction or result.traction is not None:
        yield make_use("stress by friction", "Johnson1985", "Hamilton1983")
