"""Report of a leakage result."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import starmap
from typing import Any

import numpy as np

from roughcontact.analyses.leak.figures import flow_factors, leak
from roughcontact.analyses.leak.model import AXES, MIN_FLUID_SHARE, Leakage, flow_of
from roughcontact.analyses.solve import fields as contact_fields, uncertainty_report
from roughcontact.analyses.solve.fields import PAIR
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.series import relative_change
from roughcontact.errors import ArgumentRef, Sentence
from roughcontact.references import make_use
from roughcontact.report import phrases
from roughcontact.report.figures import FRONT, RESULTS, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    CellTable,
    Column,
    Columns,
    Quantity,
    Use,
    always,
    largest_of_steps,
)
from roughcontact.report.page import WIDE
from roughcontact.report.presentation import Presentation
from roughcontact.uncertainty.intervals import Interval
from roughcontact.units import (
    format_change,
    format_engineering,
    format_percent,
    order_of_magnitude,
    plain_decimal,
)


def _seal(result: Leakage) -> str:
    seal = result.seal
    if seal is None:
        return ""
    sides = [
        f"{name} {'of the map' if side is None else format_engineering(side, 'm')}"
        for name, side in (("width", seal.width), ("length", seal.length))
    ]
    if seal.ring is not None:
        sides[0] = f"ring of {format_engineering(seal.ring, 'm')}"
    if seal.gas is None:
        fluid = f"Δp {format_engineering(seal.pressure_difference, 'Pa')}"
    else:
        inlet, outlet = (format_engineering(p, "Pa") for p in (seal.gas.inlet, seal.gas.outlet))
        fluid = f"{seal.gas.name} at {seal.gas.temperature:.4g} K, {inlet} to {outlet}"
    return f"η {format_engineering(seal.viscosity, 'Pa s')}, {fluid}, {', '.join(sides)}"


def _is_gas(result: Leakage) -> bool:
    return result.seal is not None and result.seal.gas is not None


def _is_liquid(result: Leakage) -> bool:
    return result.seal is not None and result.seal.gas is None


def _is_smooth(result: Leakage) -> bool:
    return result.largest.counter_surface is None


def _coarser(result: Leakage) -> str:
    assert result.coarser is not None
    parts = [
        f"k along {name} {format_change(change)}"
        for name, change in zip(AXES, result.coarser.permeability, strict=True)
        if not math.isnan(change)
    ]
    return (
        f"pixels of {format_engineering(result.coarser.pixel, 'm')}: "
        f"{', '.join(parts) or 'no flow'}"
    )


def _narrowest(result: Leakage, axis: int) -> dict[str, float] | None:
    place = result.steps[-1].constriction[axis]
    if place is None:
        return None
    y, x = (
        (index + 0.5) * edge
        for index, edge in zip(place.place, result.largest.pair.pixel, strict=True)
    )
    return {"gap": place.gap, "y": y, "x": x}


def _place(result: Leakage, axis: int) -> str:
    place = _narrowest(result, axis)
    if place is None:
        return "no way through"
    y, x = (format_engineering(place[name], "m") for name in ("y", "x"))
    return f"{format_engineering(place['gap'], 'm')} at y {y}, x {x}"


def _digits(unit: str) -> Callable[[float], str]:
    suffix = "" if unit == "1" else f" {unit}"
    return lambda value: f"{value:.3g}{suffix}" if value else "0"


_FLOWS = (
    ("throughput", "Pa m³/s"),
    ("throughput_mbar", "mbar l/s"),
    ("mass_flow", "kg/s"),
    ("standard_flow", "sccm"),
)
"""Names of the leak rate of a gas in its units."""

_SHOWN_FLOW = "throughput_mbar"


def _along(axis: int) -> Columns:
    """Return the columns of a flow direction, with leak rate or permeability."""
    name = AXES[axis]

    def column(key: str, label: str, unit: str, of: Any, when: Any = always) -> Column:
        return Column(
            f"{key}_{name}",
            f"{label and f'{label} along {name}'} [{unit}]",
            of=of,
            form=None if unit == "m" else _digits(unit),
            when=lambda r: axis in r.axes and when(r),
        )

    def flow(key: str, unit: str) -> Column:
        label = "leak" if key == _SHOWN_FLOW else ""
        return column(key, label, unit, lambda r: r.throughput(axis, unit), _is_gas)

    return (
        column("permeability", "k", "m³", lambda r: r.permeability(axis)),
        column("flow_factor", "φ", "1", lambda r: r.flow_factor(axis)),
        column("critical_gap", "narrowest", "m", lambda r: r.critical_gap(axis)),
        column("leak_rate", "leak", "m³/s", lambda r: r.rate(axis), _is_liquid),
        column("shear_flow_factor", "", "1", lambda r: r.shear_flow_factor(axis), _is_smooth),
        *starmap(flow, _FLOWS),
        column("gas_factor", "", "1", lambda r: [s.gas_factor[axis] for s in r.steps], _is_gas),
    )


_TABLE = (
    *PAIR,
    Quantity("nominal_area", "[m²]"),
    Quantity("roughness", "roughness $σ$ [m]"),
    Quantity("sealing", "fluid", of="seal", text=_seal),
    *(
        Quantity(
            f"narrowest_{name}",
            f"narrowest place along {name}",
            of=partial(_narrowest, axis=axis),
            text=partial(_place, axis=axis),
            when=partial(lambda axis, result: axis in result.axes, axis),
        )
        for axis, name in enumerate(AXES)
    ),
    Quantity("permeability_tensor", "[m³]", of="steps.permeability"),
    Quantity("coarser", "on a coarser grid", text=_coarser),
    Quantity("leak_class", of=lambda r: r.leak_class and r.leak_class[0]),
    Quantity("calibrated"),
    Quantity("draws"),
    Quantity("intervals", of=lambda r: [_interval(r, axis) for axis in r.axes]),
    largest_of_steps("unbalanced", "flow out of balance", "unbalanced", form=order_of_magnitude),
    *CAUTIONS,
)

_COLUMNS: tuple[Column, ...] = (
    Column("load", "load [N]"),
    Column("contact_area", "contact [m²]", shown=contact_fields.shares("contact_area")),
    Column("saturated_area", "[m²]"),
    Column("mean_gap", "mean gap [m]"),
    Column("gap_ratio", "ū/σ"),
    Column("shear_stress_factor"),
    *_along(0),
    *_along(1),
    Column(
        "permeability_yx",
        "[m³]",
        of=lambda r: r.permeability(0, 1),
        when=lambda r: not np.isnan(r.permeability(0, 1)).all(),
    ),
    Column("fluid_share", when=lambda r: r.seal is not None),
    Column("fluid_load", "[N]", of="fluid_load", when=lambda r: r.seal is not None),
    Column("unbalanced"),
)


_OF_BASE = (
    *("contact_area", "mean_gap", "permeability", "flow_factor", "critical_gap", "leak_rate"),
    *("gas_factor", *(name for name, _ in _FLOWS)),
)
"""Quantities of a coated body that are stored under the ceiling of its base, too."""


def _base_column(column: Column) -> Column:
    """Return the column of a quantity under the ceiling of the base of a coated body."""
    return replace(
        column,
        key=f"base_{column.key}",
        label=f"[{column.unit}]",
        of=lambda r: column.values(r.base),
        when=lambda r: r.base is not None and column.is_shown(r),
    )


_COLUMNS += tuple(
    _base_column(column) for column in _COLUMNS if column.stored and column.key.startswith(_OF_BASE)
)


def _sides(result: Leakage) -> str:
    periodic_axes = result.largest.boundary.periodic_axes
    if all(axis in periodic_axes for axis in result.axes):
        return (
            "The pressure falls by the same amount over each period of the map; flow needs an open "
            "path from each period to the next."
        )
    return (
        "Where the map ends the pressure is given at two opposite sides, and no fluid flows "
        "through the other two. The gap along the sides of a free map is for contact inside the "
        "map only: for a part of a larger face use a periodic boundary."
    )


def _fluid_load_sentence(result: Leakage) -> str:
    """Return where the fluid carries a part of the load as a sentence."""
    where = "on the whole map"
    if has_nominal_body(result.largest.pair.origins):
        where = (
            "where the smooth forms of the bodies touch (its thrust on free faces belongs to the "
            "clamping force)"
        )
    share = format_percent(MIN_FLUID_SHARE)
    return (
        f"The fluid carries a part of the load {where}; from {share} on the bodies deform under "
        "both pressures."
    )


# From this rate [m³/s] on, rates are given in cubic millimeters per second.
_PER_SECOND = 1e-9


def _rate(value: float) -> str:
    if value >= _PER_SECOND:
        return f"{plain_decimal(value * 1e9, 3)} mm³/s"
    return f"{plain_decimal(value * 3.6e12, 3)} mm³/h"


def _flows(result: Leakage, axis: int) -> bool:
    return bool(result.permeability(axis)[-1])


def _interval(result: Leakage, axis: int) -> Interval:
    """Return the interval of a permeability under the largest load."""
    coarser = math.nan if result.coarser is None else result.coarser.permeability[axis]
    value = float(result.permeability(axis)[-1])
    base = None if result.base is None else flow_of(result.base.steps[-1])[axis]
    change = math.nan if base is None else relative_change(base, flow_of(result.steps[-1])[axis])
    draws = result.draws[axis:][:1]
    return uncertainty_report.joint_interval(
        result, f"permeability_{AXES[axis]}", value, axis, coarser, *draws, base=change
    )


def _rate_of(result: Leakage, axis: int) -> Callable[[float], str]:
    """Return a function that formats the leak rate of a permeability [m³]."""
    flow = result.throughput(axis, "mbar l/s") if _is_gas(result) else result.rate(axis)
    factor = float(flow[-1] / result.permeability(axis)[-1])
    form = _gas_rate if _is_gas(result) else _rate
    return lambda permeability: form(factor * permeability)


def _gas_rate(throughput: float) -> str:
    return f"{throughput:.3g} mbar l/s"


def _leaks(result: Leakage) -> str:
    """Return the leak rate or permeability under one ceiling as a sentence."""
    at = phrases.load(result.largest)
    closed = [AXES[axis] for axis in result.axes if not _flows(result, axis)]
    if len(closed) == len(result.axes):
        return f"Sealed at {at} on this map: no open path along {' or '.join(closed)}."
    texts = " and ".join(
        _with_interval(result, axis) for axis in result.axes if _flows(result, axis)
    )
    if result.seal is None:
        return f"At {at} the permeability is {texts}."
    if result.seal.gas is None:
        return f"It leaks {texts} at {at}."
    return f"{result.seal.gas.name.capitalize()} leaks {texts} at {at}."


def _class(result: Leakage) -> str:
    """Return the class of a leak rate as a sentence."""
    if result.leak_class is None:
        return ""
    name, limit = result.leak_class
    bound = f" (below {10 * limit:.0e} mbar l/s)".replace("e-0", "e-") if limit < math.inf else ""
    return f" Class: {name}{bound}."


def _with_interval(result: Leakage, axis: int) -> str:
    """Return the leak rate or the permeability along an axis, with its interval."""
    form = "{:.3g} m³".format if result.seal is None else _rate_of(result, axis)
    return f"{uncertainty_report.with_interval(_interval(result, axis), form)} along {AXES[axis]}"


def _number_columns(result: Leakage) -> dict[str, list[str]]:
    """Return the cells of contact, gap, rate and flow factor, by head."""
    columns = {
        "contact": contact_fields.shares("contact_area")(result),
        "mean gap": [phrases.format_short(gap, "m") for gap in result.column("mean_gap")],
    }
    for axis in result.axes:
        if result.seal is None:
            head, cells = "k", [f"{value:.3g} m³" for value in result.permeability(axis)]
        elif _is_gas(result):
            head, cells = "leak", [_gas_rate(v) for v in result.throughput(axis, "mbar l/s")]
        else:
            head, cells = "leak", [_rate(value) for value in result.rate(axis)]
        columns[f"{head} along {AXES[axis]}"] = cells
    for axis in result.axes:
        columns[f"φ {AXES[axis]}"] = [f"{value:.3g}" for value in result.flow_factor(axis)]
    return columns


def _fluid_lines(result: Leakage) -> Iterator[str]:
    """Yield gas flow in other units, Knudsen numbers, and the load share of the fluid."""
    seal = result.seal
    flowing = [axis for axis in result.axes if _flows(result, axis)]
    if seal is None or not flowing:
        return
    axis = flowing[0]
    if (gas := seal.gas) is not None:
        rates = (
            f"{result.throughput(axis, unit)[-1]:.3g} {unit}"
            for key, unit in _FLOWS
            if key != _SHOWN_FLOW
        )
        yield f"Along {AXES[axis]}: {', '.join(rates)}"
        if seal.is_whole and not gas.has_leak_class:
            yield "No leak class: classes are for helium from 1 bar into vacuum, 1 mbar or less"
        gap = float(result.critical_gap(axis)[-1])
        low, high = (gas.knudsen(gap, p) for p in (gas.inlet, gas.outlet))
        yield (
            f"Kn at the narrowest constriction: {low:.2g} (inlet) to {high:.2g} (outlet), "
            f"{result.steps[-1].gas_factor[axis]:.3g} times the viscous flow"
        )
    largest = float(np.max(result.fluid_share))
    smallest = "smallest " * (len(result.steps) > 1)
    effect = "included" if result.fluid_load.any() else "neglected"
    where = ""
    if has_nominal_body(result.largest.pair.origins):
        where = " in the nominal contact; its thrust on free faces belongs to the clamping force"
    yield (
        f"Fluid pressure carries {format_percent(largest)} of the {smallest}load ({effect}){where}"
    )


_FIGURES = (
    Illustration(
        "leak",
        leak,
        "Open gap with the contact, and flow density over its mean (logarithmic) in each "
        "direction. The cross marks the narrowest constriction: most of the pressure falls there.",
        FRONT,
        WIDE,
    ),
    Illustration(
        "flow-factors",
        flow_factors,
        "Flow factors over mean gap / roughness (left); mean gap and critical gap of the narrowest "
        "constriction over load (right).",
        RESULTS,
        WIDE,
        lambda result: len(result.steps) > 1,
    ),
)


class LeakagePresentation(Presentation):
    """Presentation of a leakage."""

    result: Leakage
    table = _TABLE
    columns = _COLUMNS
    is_listed = True
    figures = _FIGURES
    plots = (leak, flow_factors)
    contact_name = "largest"

    def question(self) -> str:
        """Return the question that the result answers."""
        result = self.result
        source, loads = (
            phrases.source(result.largest.surface.provenance),
            phrases.load_range(result),
        )
        if result.seal is None:
            return f"How permeable is the gap of {source} {loads}?"
        return f"How much leaks past {source} {loads}?"

    def answer(self) -> str:
        """Return the leak rate or permeability under the largest load as a sentence."""
        result = self.result
        if result.base is None:
            return _leaks(result) + _class(result)
        coating, base = (f"Ceiling of the {name}: " for name in ("coating", "base"))
        return f"{coating}{_leaks(result)} {base}{_leaks(result.base)}{_class(result)}"

    def numbers(self) -> CellTable:
        """Return contact, gap, rate and flow factor of each load."""
        result = self.result
        head, loads = phrases.load_column(result.largest, result.column("load"))
        columns = _number_columns(result)
        if result.base is not None:
            # Two columns each of contact and rate; gaps and flow factors would not fit.
            base = {f"{head} (base)": cells for head, cells in _number_columns(result.base).items()}
            pairs = zip(columns.items(), base.items(), strict=True)
            kept = ("contact", "leak", "k ")
            columns = dict(item for pair in pairs for item in pair if item[0].startswith(kept))
        return (head, *columns), list(zip(loads, *columns.values(), strict=True))

    def remarks(self) -> Iterator[str]:
        """Yield remarks on the scaling of the rate, the narrowest constriction and accuracy."""
        result, seal = self.result, self.result.seal
        if seal is None:
            rate = f"{ArgumentRef('viscosity')} and {ArgumentRef('pressure_difference')}"
            yield Sentence(f"Flow of a liquid: Q = k w Δp/(12 η L); give {rate} for a leak rate")
        elif has_nominal_body(result.largest.pair.origins):
            if not seal.is_whole:
                yield Sentence(f"Rate scales with the width: {ArgumentRef('seal_width')}")
        elif seal.length is None or not seal.is_whole:
            edges = f"{ArgumentRef('seal_width')}, {ArgumentRef('seal_length')}"
            yield Sentence(f"Rate scales with width/length of the land: {edges}")
        yield from _fluid_lines(result)
        places = [
            f"{phrases.format_short(place.gap, 'm')} (along {AXES[axis]})"
            for axis, place in enumerate(result.steps[-1].constriction)
            if place is not None and axis in result.axes
        ]
        if places:
            yield f"Narrowest constriction at the largest load: {', '.join(places)}"
        flowing = [axis for axis in result.axes if _flows(result, axis)]
        for axis in flowing[:1]:
            if result.calibrated is not None:
                yield f"Along {AXES[axis]}: {uncertainty_report.under_calibrated(result, axis)}"
            yield uncertainty_report.sources(_interval(result, axis), hint=False)
        yield from phrases.draws_text(result.draws)
        yield phrases.status(result.largest)

    def sentences(self) -> Iterator[str]:
        """Yield the sentences on the model."""
        result = self.result
        yield "Reynolds' equation of a thin film in the gap: nothing flows through contact."
        if result.seal is not None:
            yield _fluid_load_sentence(result)
        yield _sides(result)
        if _is_gas(result):
            yield (
                "The gas flows from viscous to free molecular by the local Knudsen number, walls "
                "reflect its molecules diffusely, and its temperature is constant."
            )
        elif result.seal is not None:
            yield (
                "The rate is k Δp w/(12 η l) for a liquid; for a gas without slip it is the "
                "volume at the mean of inlet and outlet pressure."
            )
        yield (
            "The flow factor φ is k over the cube of the mean gap ū, 1 between smooth plates; "
            "closed points are included in ū as zero. The leak rate depends on the narrowest "
            "constrictions, and so on single summits. Another part of the same face may differ by "
            "a factor, near sealing most of all."
        )

    def problem(self) -> str:
        """Return the bodies and the range of loads."""
        return phrases.problem_of_loads(self.result.largest, self.result.column("load").tolist())

    def works(self) -> Iterator[Use]:
        """Yield the works on the flow."""
        yield make_use("flow through the gap", "Patir1978", "Patir1979")
        if _is_gas(self.result):
            yield make_use("gas of any rarefaction", "Cercignani1963", "Fukui1990")
            yield make_use("classes of leak rates", "Rottlaender2016")
        else:
            yield make_use("gas that slips", "Burgdorfer1959")
        yield make_use("pressure of the fluid", "Kuznetsov1985")
        yield make_use("equations of the flow", "Notay2010")
        yield make_use("narrowest place of the gap", "Persson2008", "Dapp2012")
