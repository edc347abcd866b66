"""Report of a tangentially loaded contact."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from roughcontact._tools import netcdf
from roughcontact._tools.files import require_suffix
from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.analyses.stress import (
    fields as stress_fields,
    illustrations as stress_illustrations,
)
from roughcontact.analyses.stress.model import StressResult
from roughcontact.analyses.tangential.figures import fretting, tangential
from roughcontact.analyses.tangential.model import Tangential, tangential_compliance, to_dataset
from roughcontact.references import Reference, make_use
from roughcontact.report import figures, phrases
from roughcontact.report.assumptions import Assumption
from roughcontact.report.figures import FRONT, RESULTS, Illustration, Illustrations
from roughcontact.report.kind import (
    PROBLEM,
    TRUST,
    CellTable,
    Column,
    Columns,
    Presentation,
    Quantity,
    Table,
    delegated,
    quantity_of,
)
from roughcontact.report.page import WIDE
from roughcontact.units import format_change, format_engineering, format_percent, order_of_magnitude


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


def _fretting_getter(attribute: str) -> Callable[[Tangential], Any]:
    """Return a getter of an attribute of the fretting result; None without fretting."""
    get = attrgetter(attribute)
    return lambda result: None if result.fretting is None else get(result.fretting)


def _ruiz(value: float) -> str:
    """Return σ_t τδ as text, in the unit of fretting maps."""
    return f"{1e-9 * value:.4g} MPa²·mm"


_TABLE: Table = (
    *(
        delegated("solution", quantity_of(contact_fields.CONTACT, key), name="", part=PROBLEM)
        for key in ("source", "preparation", "boundary", "contact_modulus")
    ),
    Quantity("friction", "friction", "μ"),
    Quantity("direction", "direction", form=lambda value: f"{value:g}°"),
    Quantity("capacity", "force at which it slides", of="capacity", unit="N"),
    Quantity("initial_stiffness", "stiffness at full stick", "K_t", unit="N/m", text=_initial),
    Quantity(
        "tangent_stiffness",
        "stiffness at the last force",
        unit="N/m",
        text=lambda r: _stiffness(r.tangent_stiffness, r.solution.pair.load_unit),
    ),
    Quantity("stiffness_per_area", unit="Pa/m"),
    Quantity(
        "compliance_ratio",
        "tangential over normal compliance",
        "c",
        of=lambda r: tangential_compliance(r.solution.pair),
    ),
    Quantity(
        "cycle_energy",
        "energy of a cycle",
        unit="J",
        of=lambda r: _finite(r.cycle_energy),
        text=_energy,
        when=lambda r: math.isfinite(r.cycle_energy),
    ),
    Quantity("loss_factor", of=lambda r: _finite(r.loss_factor)),
    Quantity(
        "superposition",
        of=lambda r: (
            None
            if r.superposition is None
            else {
                **asdict(r.superposition),
                "traction_difference": _finite(r.superposition.traction_difference),
            }
        ),
    ),
    Quantity(
        "superposition_shift",
        "shift by superposition",
        unit="m",
        of=lambda r: None if r.superposition is None else r.superposition.shift[-1],
        when=lambda r: r.superposition is not None,
    ),
    *(
        Quantity(key, name, symbol, unit=unit, of=_fretting_getter(of), form=form, when=_has_stress)
        for key, name, symbol, unit, of, form in (
            ("max_von_mises", "largest von Mises stress", "", "Pa", "stress.max_von_mises", None),
            ("max_tension", "largest tension at the surface", "", "Pa", "stress.max_tension", None),
            ("max_work", "largest traction times slip", "τδ", "J/m²", "max_work", None),
            ("max_ruiz", "largest Ruiz parameter", "σ_t τδ", "Pa²·m", "max_ruiz", _ruiz),
        )
    ),
    Quantity(
        "yield_factor",
        "yield strength over largest stress",
        of=_fretting_getter("stress.yield_factor"),
        when=lambda r: _fretting_getter("stress.yield_factor")(r) is not None,
    ),
    Quantity(
        "yield_force",
        "tangential force at first yield",
        unit="N",
        of=lambda r: _finite(_fretting_getter("yield_force")(r)),
        when=lambda r: _finite(_fretting_getter("yield_force")(r)) is not None,
    ),
    Quantity(
        "tangential_certificate",
        "tangential certificate",
        "ε_t",
        form=order_of_magnitude,
        part=TRUST,
        of=lambda r: max(step.certificate for step in r.steps),
    ),
    Quantity(
        "force_error",
        "force error",
        form=order_of_magnitude,
        part=TRUST,
        of=lambda r: max(step.force_error for step in r.steps),
    ),
    Quantity("applications", "applications of the tangential operator", part=TRUST),
    *(quantity_of(contact_fields.CONTACT, key) for key in ("warnings", "cautions")),
)

_COLUMNS: Columns = (
    Column("load", "load", unit="N", brief=False),
    Column("force", "force", unit="N"),
    Column("shift", "shift", unit="m"),
    Column("cross_shift", unit="m", brief=False),
    Column("stick_fraction", "stick", form=format_percent),
    Column("max_slip", "largest slip", unit="m"),
    Column("mean_slip", "mean slip", unit="m", brief=False),
    Column("energy", "energy", unit="J"),
    Column("certificate", form=order_of_magnitude, brief=False),
)


def _answer(result: Tangential) -> str:
    """Return shift and stick under the last force as a sentence."""
    last, unit = result.last, result.solution.pair.load_unit
    force, shift = phrases.format_short(last.force, unit), phrases.format_short(last.shift, "m")
    if not last.stick_fraction:
        return f"The contact slides: {force} shift it {shift}."
    stick = phrases.format_share(last.stick_fraction)
    return f"The joint shifts {shift} under {force}; {stick} of the contact sticks."


def _numbers(result: Tangential) -> CellTable:
    """Return the steps of a path, or the main quantities of a single step."""
    unit, last = result.solution.pair.load_unit, result.last
    if len(result.steps) > 1:
        changes = len({step.load for step in result.steps}) > 1
        rows = [
            (
                *(phrases.format_short(load, unit) for load in [s.load] * changes),
                phrases.format_short(s.force, unit),
                phrases.format_short(s.shift, "m"),
                phrases.format_share(s.stick_fraction),
                phrases.format_short(s.max_slip, "m"),
                phrases.format_short(s.energy, "J"),
            )
            for s in result.steps
        ]
        heads = ("force", "shift", "stick", "largest slip", "energy")
        return (*["load"] * changes, *heads), rows
    share = phrases.format_share(abs(last.force) / result.capacity)
    single = [
        ("Force", f"{share} of the {phrases.format_short(result.capacity, unit)} that slide it"),
        ("Stiffness at full stick", _initial(result)),
        ("Largest slip", phrases.format_short(last.max_slip, "m")),
    ]
    if math.isfinite(result.cycle_energy):
        single.append(("Energy of a cycle", _energy(result)))
    return (), single


def _remarks(result: Tangential) -> tuple[str, ...]:
    """Return cycle, fretting, the comparison with superposition, and the accuracy."""
    curve, last = result.superposition, result.last
    lines = [f"Cycle: {_energy(result)}"] if result.is_cycle else []
    lines += _fretting_sentences(result)
    if curve is not None and math.isfinite(curve.traction_difference):
        change = curve.shift[-1] / abs(last.shift) - 1
        lines.append(
            f"Superposition: shift {phrases.format_short(curve.shift[-1], 'm')} "
            f"({format_change(change)}), "
            f"stick {phrases.format_share(curve.stick_fraction[-1])}"
        )
    worst = max(step.certificate for step in result.steps)
    normal = order_of_magnitude(result.solution.certificate)
    lines.append(f"Solved: tangential certificate {order_of_magnitude(worst)}; contact {normal}")
    return tuple(lines)


def _fretting_sentences(result: Tangential) -> Iterator[str]:
    """Yield largest stress, first yield, tension and Ruiz' parameters."""
    if result.fretting is None:
        return
    stress, works = result.fretting.stress, result.fretting
    depth, strength = stress.max_von_mises_at[0], stress.material.yield_strength
    where = f"{phrases.format_short(depth, 'm')} deep" if depth else "at the surface"
    known = "" if strength is None else f" ({stress.max_von_mises / strength:.3g} σ_Y)"
    yield f"Von Mises stress: {phrases.format_short(stress.max_von_mises, 'Pa')}{known}, {where}"
    if works.yield_force is not None:
        yield f"First yield: {_first_yield(works.yield_force, result.solution.pair.load_unit)}"
    assert stress.max_tension is not None
    yield (
        f"Tension: {phrases.format_short(stress.max_tension, 'Pa')} at the surface, "
        f"{_place(stress.max_tension_at, stress)}"
    )
    yield (
        f"Fretting: τδ {phrases.format_short(works.max_work, 'J/m²')}, σ_t τδ "
        f"{_ruiz(works.max_ruiz)}, "
        f"{_place(works.max_ruiz_at, stress)}"
    )


def _first_yield(force: float, unit: str) -> str:
    """Return the tangential force of first yield as text."""
    if not force:
        return "under the load alone"
    if math.isinf(force):
        return "not before it slides"
    return f"at a tangential force of {phrases.format_short(force, unit)}"


def _place(center: tuple[float, float], stress: StressResult) -> str:
    y, x = (format_engineering(length, "m") for length in center)
    return f"at x = {x}" if stress.solution.pair.is_profile else f"at y, x = {y}, {x}"


def _sentences(result: Tangential) -> tuple[str, ...]:
    """Return the sentences on the model."""
    return (
        "Coulomb friction on elastic half-spaces: traction is at most friction times pressure, and "
        "slip is along the traction.",
        "Both components of the traction are solved for. The pressure does not change with it.",
        "The shift is that of the interface, without the shear of the bodies.",
    )


def _question(result: Tangential) -> str:
    contact = result.solution
    name = phrases.source(contact.surface.provenance)
    return f"How far does {name} shift and slip {phrases.load_phrase(contact)}?"


def _save(result: Tangential, path: str | os.PathLike[str]) -> None:
    """Write maps as NetCDF, or the steps as CSV or JSON."""
    require_suffix(path, ".nc", ".csv", ".json")
    if Path(path).suffix.lower() != ".nc":
        KIND.write(result, path)
        return
    packed = dict.fromkeys(("pressure", "saturated", "stick"), netcdf.PACKED)
    netcdf.write(to_dataset(result), path, packed)


_FIGURES: Illustrations = (
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
        for item in stress_illustrations.STRESS[:2]
    ),
)

_ASSUMPTIONS = (
    Assumption(
        "Coulomb friction",
        lambda r: f"one coefficient, μ = {r.friction:g}",
        "friction varies over the face, with slip, or in time",
    ),
    Assumption(
        "Small slip",
        lambda r: (
            f"{format_engineering(r.last.max_slip, 'm', 3)} at most, against "
            f"pixels of {format_engineering(max(r.solution.pair.pixel[-1:]), 'm', 3)}"
        ),
        "slip reaches the size of a pixel",
    ),
)


def _works(result: Tangential) -> Iterator[tuple[str, tuple[Reference, ...]]]:
    """Yield the references of the path, the stress and the fretting parameters."""
    if len({step.load for step in result.steps}) > 1:
        yield make_use("load and force together", "Mindlin1953")
    if result.fretting is not None:
        yield from stress_fields.subsurface_references(result.fretting.stress)
        yield make_use("fretting parameters", "Ruiz1984")


KIND = Presentation(
    Tangential,
    _TABLE,
    _COLUMNS,
    listed=True,
    question=_question,
    assumptions=_ASSUMPTIONS,
    sentences=_sentences,
    figures=_FIGURES,
    plots=(tangential, fretting),
    save=_save,
    dataset=to_dataset,
    contact=attrgetter("solution"),
    answer=_answer,
    numbers=_numbers,
    remarks=_remarks,
    problem=lambda result: f"{phrases.problem(result.solution)}, friction {result.friction:g}",
    works=lambda result: (
        *_works(result),
        make_use("partial slip", "Cattaneo1938", "Mindlin1949", "Goodman1962"),
        make_use("superposition", "Jaeger1998", "Ciavarella1998"),
        make_use("tangential influence coefficients", "Johnson1985", "Pohrt2014"),
        make_use("stick and slip by Newton steps", "Hintermueller2002", "Birgin2000"),
    ),
)

_PER_METER = {"N": "N/m", "N/m": "Pa", "J": "J/m", "Pa/m": "Pa/m"}
PROFILE_KIND = replace(
    KIND,
    table=[replace(item, unit=_PER_METER.get(item.unit, item.unit)) for item in _TABLE],
    columns=[replace(item, unit=_PER_METER.get(item.unit, item.unit)) for item in _COLUMNS],
    when=lambda result: result.solution.pair.is_profile,
)
