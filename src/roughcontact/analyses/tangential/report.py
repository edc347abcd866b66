"""Report of a tangentially loaded contact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, replace
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING

from roughcontact._tools import netcdf
from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.analyses.stress import report as stress_report
from roughcontact.analyses.tangential.figures import fretting, tangential
from roughcontact.analyses.tangential.model import Tangential, tangential_compliance, to_dataset
from roughcontact.references import make_use
from roughcontact.report import figures, phrases
from roughcontact.report.figures import FRONT, RESULTS, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    TRUST,
    CellTable,
    Column,
    Quantity,
    Use,
    largest_of_steps,
    profile_columns,
    profile_table,
    read_attribute,
)
from roughcontact.report.page import WIDE
from roughcontact.report.phrases import format_share, format_short
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_change, format_engineering, format_percent, order_of_magnitude

if TYPE_CHECKING:
    from roughcontact.analyses.tangential.model import Tangential


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _energy(result: Tangential) -> str:
    value, factor = result.cycle_energy, result.loss_factor
    return f"{format_engineering(value, 'J')} (loss factor {factor:.3g})"


def _stiffness(value: float, unit: str) -> str:
    """Return a stiffness as text, in N/µm for a map and N/µm/mm for a profile."""
    return f"{1e-6 * value:.4g} N/µm" if unit == "N" else f"{1e-9 * value:.4g} N/µm/mm"


def _initial(result: Tangential) -> str:
    text = _stiffness(result.initial_stiffness, result.solution.pair.load_unit)
    return f"{text} ({1e-12 * result.stiffness_per_area:.4g} N/µm/mm² of the map)"


def _has_stress(result: Tangential) -> bool:
    return result.fretting is not None


def _ruiz(value: float) -> str:
    """Return σ_t τδ as text, in the unit of fretting maps."""
    return f"{1e-9 * value:.4g} MPa²·mm"


_TABLE = (
    *contact_fields.pair_quantities("solution"),
    Quantity("friction", "friction $μ$"),
    Quantity("direction", "direction", form=lambda value: f"{value:g}°"),
    Quantity("capacity", "force at which it slides [N]", of="capacity"),
    Quantity("initial_stiffness", "stiffness at full stick $K_t$ [N/m]", text=_initial),
    Quantity(
        "tangent_stiffness",
        "stiffness at the last force [N/m]",
        text=lambda r: _stiffness(r.tangent_stiffness, r.solution.pair.load_unit),
    ),
    Quantity("stiffness_per_area", "[Pa/m]"),
    Quantity(
        "compliance_ratio",
        "tangential over normal compliance $c$",
        of=lambda r: tangential_compliance(r.solution.pair),
    ),
    Quantity(
        "cycle_energy", "energy of a cycle [J]", of=lambda r: _finite(r.cycle_energy), text=_energy
    ),
    Quantity("loss_factor", of=lambda r: _finite(r.loss_factor)),
    Quantity(
        "superposition",
        of=lambda r: (
            r.superposition
            and {
                **asdict(r.superposition),
                "traction_difference": _finite(r.superposition.traction_difference),
            }
        ),
    ),
    Quantity(
        "superposition_shift",
        "shift by superposition [m]",
        of=lambda r: r.superposition and r.superposition.shift[-1],
    ),
    Quantity("max_von_mises", "largest von Mises stress [Pa]", of="fretting.stress.max_von_mises"),
    Quantity(
        "max_tension", "largest tension at the surface [Pa]", of="fretting.stress.max_tension"
    ),
    Quantity("max_work", "largest traction times slip $τδ$ [J/m²]", of="fretting.max_work"),
    Quantity(
        "max_ruiz", "largest Ruiz parameter $σ_t τδ$ [Pa²·m]", of="fretting.max_ruiz", form=_ruiz
    ),
    Quantity(
        "yield_factor", "yield strength over largest stress", of="fretting.stress.yield_factor"
    ),
    Quantity(
        "yield_force",
        "tangential force at first yield [N]",
        of=lambda r: _finite(read_attribute(r, "fretting.yield_force")),
    ),
    largest_of_steps(
        "tangential_certificate",
        "tangential certificate $ε_t$",
        "certificate",
        form=order_of_magnitude,
    ),
    largest_of_steps("force_error", "force error", "force_error", form=order_of_magnitude),
    Quantity("applications", "applications of the tangential operator", part=TRUST),
    *CAUTIONS,
)

_COLUMNS = (
    Column("load", "load [N]", front="load"),
    Column("force", "force [N]", front="force"),
    Column("shift", "shift [m]", front="shift"),
    Column("cross_shift", "[m]"),
    Column("stick_fraction", "stick", form=format_percent, front="stick"),
    Column("max_slip", "largest slip [m]", front="largest slip"),
    Column("mean_slip", "mean slip [m]"),
    Column("energy", "energy [J]", front="energy"),
    Column("certificate", form=order_of_magnitude),
)


def _fretting_sentences(result: Tangential) -> Iterator[str]:
    """Yield largest stress, first yield, tension and Ruiz' parameters."""
    if result.fretting is None:
        return
    stress, works = result.fretting.stress, result.fretting
    depth, strength = stress.max_von_mises_at[0], stress.material.yield_strength
    where = f"{format_short(depth, 'm')} deep" if depth else "at the surface"
    known = "" if strength is None else f" ({stress.max_von_mises / strength:.3g} σ_Y)"
    yield f"Von Mises stress: {format_short(stress.max_von_mises, 'Pa')}{known}, {where}"
    if works.yield_force is not None:
        yield f"First yield: {_first_yield(works.yield_force, result.solution.pair.load_unit)}"
    assert stress.max_tension is not None
    is_profile = result.solution.pair.is_profile
    tension, ruiz = (
        phrases.place(center, is_profile) for center in (stress.max_tension_at, works.max_ruiz_at)
    )
    yield f"Tension: {format_short(stress.max_tension, 'Pa')} at the surface, {tension}"
    work = format_short(works.max_work, "J/m²")
    yield f"Fretting: τδ {work}, σ_t τδ {_ruiz(works.max_ruiz)}, {ruiz}"


def _first_yield(force: float, unit: str) -> str:
    """Return the tangential force of first yield as text."""
    if not force:
        return "under the load alone"
    if math.isinf(force):
        return "not before it slides"
    return f"at a tangential force of {format_short(force, unit)}"


_FIGURES = (
    Illustration(
        "tangential",
        tangential,
        "Traction (left), stick and slip (middle), and force over shift (right): solved points, "
        "the curve by superposition, and the cycle between both forces.",
        FRONT,
        WIDE,
    ),
    Illustration(
        "",
        fretting,
        "Largest tension at the surface (left). Ruiz' parameter, the product of tension, traction "
        "and slip (right): cracks start where it is large.",
        RESULTS,
        WIDE,
        _has_stress,
    ),
    *(
        replace(
            figures.within_scene(attrgetter("fretting.stress"), item), name="", when=_has_stress
        )
        for item in stress_report.FIGURES[:2]
    ),
)


class TangentialPresentation(Presentation):
    """Presentation of a tangentially loaded contact."""

    result: Tangential
    table = _TABLE
    columns = _COLUMNS
    profile_table = profile_table(_TABLE)
    profile_columns = profile_columns(_COLUMNS)
    is_listed = True
    figures = _FIGURES
    plots = (tangential, fretting)
    contact_name = "solution"
    packed = ("pressure", "saturated", "stick")

    def question(self) -> str:
        """Return the question that the result answers."""
        contact = self.result.solution
        name = phrases.source(contact.surface.provenance)
        return f"How far does {name} shift and slip {phrases.load_phrase(contact)}?"

    def answer(self) -> str:
        """Return shift and stick under the last force as a sentence."""
        last, unit = self.result.last, self.result.solution.pair.load_unit
        force, other = format_short(last.force, unit), self.result.calibrated
        shift = phrases.with_range(
            last.shift, None if other is None else other.last.shift, partial(format_short, unit="m")
        )
        if not last.stick_fraction:
            return f"The contact slides: {force} shift it {shift}."
        stick = format_share(last.stick_fraction)
        return f"The joint shifts {shift} under {force}; {stick} of the contact sticks."

    def numbers(self) -> CellTable:
        """Return the steps of a path, or the main quantities of a single step."""
        result = self.result
        unit, last = result.solution.pair.load_unit, result.last
        if len(result.steps) > 1:
            heads, rows = super().numbers()
            if len({step.load for step in result.steps}) > 1:
                return heads, rows
            return heads[1:], [row[1:] for row in rows]
        share = format_share(abs(last.force) / result.capacity)
        single = [
            ("Force", f"{share} of the {format_short(result.capacity, unit)} that slide it"),
            ("Stiffness at full stick", _initial(result)),
            ("Largest slip", format_short(last.max_slip, "m")),
        ]
        if math.isfinite(result.cycle_energy):
            single.append(("Energy of a cycle", _energy(result)))
        return (), single

    def remarks(self) -> Iterator[str]:
        """Yield cycle, fretting, the comparison with superposition, and the accuracy."""
        result, curve = self.result, self.result.superposition
        if result.is_cycle:
            yield f"Cycle: {_energy(result)}"
        yield from _fretting_sentences(result)
        if curve is not None and math.isfinite(curve.traction_difference):
            change = format_change(curve.shift[-1] / abs(result.last.shift) - 1)
            shift, stick = format_short(curve.shift[-1], "m"), curve.stick_fraction[-1]
            yield f"Superposition: shift {shift} ({change}), stick {format_share(stick)}"
        worst = order_of_magnitude(max(step.certificate for step in result.steps))
        normal = order_of_magnitude(result.solution.certificate)
        yield f"Solved: tangential certificate {worst}; contact {normal}"

    def sentences(self) -> tuple[str, ...]:
        """Return the sentences on the model."""
        return (
            "Coulomb friction on elastic half-spaces: traction is at most friction times pressure, "
            "and slip is along the traction.",
            "Both components of the traction are solved for. The pressure does not change with it.",
            "The shift is that of the interface, without the shear of the bodies.",
        )

    def works(self) -> Iterator[Use]:
        """Yield the references of the path, the stress and the fretting parameters."""
        result = self.result
        if len({step.load for step in result.steps}) > 1:
            yield make_use("load and force together", "Mindlin1953")
        if result.fretting is not None:
            yield from stress_report.subsurface_references(result.fretting.stress)
            yield make_use("fretting parameters", "Ruiz1984")
        yield make_use("partial slip", "Cattaneo1938", "Mindlin1949", "Goodman1962")
        yield make_use("superposition", "Jaeger1998", "Ciavarella1998")
        yield make_use("tangential influence coefficients", "Johnson1985", "Pohrt2014")
        yield make_use("stick and slip by Newton steps", "Hintermueller2002", "Birgin2000")

    def problem(self) -> str:
        """Return the contact and the friction."""
        return f"{super().problem()}, friction {self.result.friction:g}"

    def dataset(self) -> netcdf.Dataset:
        """Return the maps of traction and slip."""
        return to_dataset(self.result)
