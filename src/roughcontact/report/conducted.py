"""What is told of what a contact conducts."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from roughcontact.joint.conductance import Conductance
from roughcontact.material.conductor import Conductor
from roughcontact.report import tables
from roughcontact.report.quantities import (
    PROBLEM,
    Column,
    Columns,
    Quantity,
    Table,
    quantity_of,
    within,
)
from roughcontact.units import engineering, percent


def _of_contact(key: str) -> Quantity:
    changes: dict[str, Any] = {"name": "", "part": PROBLEM}
    return within("largest", quantity_of(tables.CONTACT, key), **changes)


def _body(number: int) -> Callable[[Conductance], dict[str, Any]]:
    def told(found: Conductance) -> dict[str, Any]:
        body = found.bodies[number]
        return {
            "name": body.name, "resistivity": body.resistivity, "conductivity": body.conductivity,
        }  # fmt: skip

    return told


def _words(body: Conductor) -> str:
    """Return what a body conducts."""
    parts = [body.name] if body.name else []
    if body.resistivity is not None:
        parts.append(f"ρ {engineering(body.resistivity, 'Ω m')}")
    if body.conductivity is not None:
        parts.append(f"k {body.conductivity:.4g} W/(m K)")
    return ", ".join(parts)


def _electrical(found: Conductance) -> bool:
    return not math.isnan(found.electrical_resistivity)


def _thermal(found: Conductance) -> bool:
    return not math.isnan(found.thermal_resistivity)


def _ratio(name: str) -> Callable[[Conductance], list[str]]:
    """Return how far an estimate of the constriction length is off, a resistance being over it."""

    def shown(found: Conductance) -> list[str]:
        ratios = found.column(name) / found.column("length")
        return ["–" if math.isnan(ratio) else f"{ratio:.3g}" for ratio in ratios.tolist()]

    return shown


def _share(name: str) -> Callable[[Conductance], list[str]]:
    return lambda found: [
        percent(value) for value in (found.column(name) / found.nominal_area).tolist()
    ]


CONDUCTANCE: Table = (
    *(_of_contact(key) for key in ("source", "preparation", "boundary", "contact_modulus")),
    Quantity("nominal_area", unit="m²"),
    Quantity("body", "body", of=_body(0), text=lambda r: _words(r.bodies[0])),
    Quantity("counter_body", "counter-body", of=_body(1), text=lambda r: _words(r.bodies[1])),
    Quantity("film", "film", unit="Ω m²", when=_electrical),
    Quantity("thermal_film", "thermal film", unit="m² K/W", when=_thermal),
    *(quantity_of(tables.CONTACT, key) for key in ("warnings", "cautions")),
)  # fmt: skip
"""Of a `Conductance`."""

CONDUCTANCE_COLUMNS: Columns = (
    Column("load", "load", unit="N"),
    Column("contact_area", "contact", unit="m²", shown=_share("contact_area")),
    Column("saturated_area", "saturated", unit="m²", shown=_share("saturated_area")),
    Column("spots", "spots"),
    Column("length", "constriction length", unit="m"),
    Column(
        "electrical_resistance", "resistance", unit="Ω", when=_electrical,
        of=lambda r: r.electrical_resistance.tolist(),
    ),
    Column(
        "thermal_resistance", "thermal resistance", unit="K/W", when=_thermal,
        of=lambda r: r.thermal_resistance.tolist(),
    ),
    Column(
        "electrical_conductance", unit="S/m²", when=_electrical,
        of=lambda r: r.electrical_conductance.tolist(),
    ),
    Column(
        "thermal_conductance", "h per nominal area", unit="W/(m² K)", when=_thermal,
        of=lambda r: r.thermal_conductance.tolist(),
    ),
    Column(
        "greenwood_length", "Greenwood", unit="m", shown=_ratio("greenwood_length"),
    ),
    Column(
        "correlation_length", "correlation", unit="m", shown=_ratio("correlation_length"),
    ),
)  # fmt: skip
"""Of the loads of a `Conductance`."""
