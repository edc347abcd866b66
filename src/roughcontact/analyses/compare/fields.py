"""Names and units of compared quantities."""

from __future__ import annotations

from roughcontact.analyses.solve.fields import CONTACT
from roughcontact.drawing.style import axis_unit
from roughcontact.report import inputs
from roughcontact.report.kind import quantity_of

_SHARES = ("contact_fraction", "saturated_fraction")


def unit_of(name: str) -> str:
    """Return the SI unit of a compared quantity."""
    if name in inputs.ROUGHNESS:
        return inputs.ROUGHNESS[name][0] or "1"
    return quantity_of(CONTACT, name).unit


def name_of(name: str, ceiling: str = "") -> str:
    """Return the name of a compared quantity, with its ceiling if there are two."""
    if name in inputs.ROUGHNESS:
        return name
    text = quantity_of(CONTACT, name).name
    return f"{text}, {ceiling}" if ceiling else text


def scale_of(name: str, largest: float) -> tuple[float, str]:
    """Return the display factor of a quantity, and its unit."""
    if name in _SHARES:
        return 100.0, "%"
    unit = unit_of(name)
    return (1.0, "") if unit == "1" else axis_unit(abs(largest), unit)
