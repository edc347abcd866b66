"""Report of a conductance result."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from roughcontact.analyses.conductance import model as joint
from roughcontact.analyses.conductance.figures import conductance
from roughcontact.analyses.solve import fields as contact_fields, uncertainty_report
from roughcontact.analyses.solve.fields import PAIR
from roughcontact.drawing import maps
from roughcontact.material.material import Conductor
from roughcontact.references import make_use
from roughcontact.report import phrases
from roughcontact.report.figures import FRONT, Illustration
from roughcontact.report.kind import CAUTIONS, CellTable, Column, Quantity, Use
from roughcontact.report.page import MIDDLE, WIDE
from roughcontact.report.phrases import format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.theory.constriction import CORRELATION_RANGE
from roughcontact.uncertainty.intervals import Interval
from roughcontact.units import format_change, format_engineering, format_percent, plain_decimal


def _facts(result: joint.Conductance, number: int) -> dict[str, Any]:
    names = ("name", "resistivity", "conductivity")
    return {name: getattr(result.bodies[number], name) for name in names}


def _words(body: Conductor) -> str:
    """Return the conductivities of a body as text."""
    parts = [body.name] if body.name else []
    if body.resistivity is not None:
        parts.append(f"ρ {format_engineering(body.resistivity, 'Ω m')}")
    if body.conductivity is not None:
        parts.append(f"k {body.conductivity:.4g} W/(m K)")
    return ", ".join(parts)


def _electrical(result: joint.Conductance) -> bool:
    return not math.isnan(result.electrical_resistivity)


def _thermal(result: joint.Conductance) -> bool:
    return not math.isnan(result.thermal_resistivity)


def _by_area(result: joint.Conductance) -> bool:
    """Return whether the conductance of the joint is proportional to its area."""
    return len(result.largest.boundary.periodic_axes) == 2


def _has_filling_estimate(result: joint.Conductance) -> bool:
    """Return whether the report shows the effect of air or oil in the gap."""
    return _thermal(result) and _by_area(result) and result.filling is None


def _in_gap(result: joint.Conductance, filling: str) -> str:
    """Return h with a filled gap, and its excess, at both ends of the loads."""
    whole = result.filled_conductance(filling)
    with np.errstate(divide="ignore"):
        added = result.column(f"{filling}_gap") / result.thermal_conductance
    return " to ".join(
        f"{format_engineering(whole[end], 'W/(m² K)', 3)} ({format_change(added[end])})"
        for end in sorted({0, len(result.steps) - 1})
    )


def _share_of_gap(result: joint.Conductance) -> str:
    """Return conductance and share of the filled gap, under the smallest and largest load."""
    gap = result.column("filled_gap")
    return " to ".join(
        f"{format_engineering(gap[end], 'W/(m² K)', 3)} ({format_percent(gap[end] / whole[end])})"
        for whole in [result.joint_conductance]
        for end in sorted({0, len(result.steps) - 1})
    )


def _has_filling(result: joint.Conductance) -> bool:
    return result.filling is not None


def _has_current(result: joint.Conductance) -> bool:
    return result.current is not None


def _conductance_with_filling(name: str) -> Callable[[joint.Conductance], Any]:
    return lambda result: result.filled_conductance(name)


def _ratio(result: joint.Conductance, name: str, low: float, high: float) -> list[str]:
    """Return the estimated over the computed constriction length, within a range."""
    ratios = result.column(name) / result.column("length")
    return [f"{ratio:.3g}" if low <= ratio <= high else "–" for ratio in ratios.tolist()]


def _correlation_words(values: dict[str, float]) -> str:
    """Return the inputs of contact conductance as text."""
    text = f"σ {format_engineering(values['sigma'], 'm')}, m {values['slope']:.3g}"
    if "hardness" in values:
        text += f", H {format_engineering(values['hardness'], 'Pa')}"
        text += "; no c₁, c₂ for this hardness" if "c1" not in values else ""
    if "c1" in values:
        text += f", c₁ {format_engineering(values['c1'], 'Pa')}, c₂ {plain_decimal(values['c2'])}"
    return text


CONDUCTANCE = (
    *PAIR,
    Quantity("nominal_area", "[m²]"),
    Quantity("body", "body", of=partial(_facts, number=0), text=lambda r: _words(r.bodies[0])),
    Quantity(
        "counter_body",
        "counter-body",
        of=partial(_facts, number=1),
        text=lambda r: _words(r.bodies[1]),
    ),
    Quantity(
        "film", "film [Ω m²]", form=lambda v: f"{v:.4g} Ω m²" if v else "none", when=_electrical
    ),
    Quantity(
        "thermal_film",
        "thermal film [m² K/W]",
        form=lambda v: f"{v:.4g} m² K/W" if v else "none",
        when=_thermal,
    ),
    Quantity("gap", "gap", of="filling", text=lambda r: f"{r.filling.name}: {_share_of_gap(r)}"),
    Quantity("temperature", "[K]"),
    Quantity("current", "[A]"),
    *(
        Quantity(
            f"with_{name}",
            f"with {name} in the gap [W/(m² K)]",
            stored=False,
            when=_has_filling_estimate,
            of=_conductance_with_filling(name),
            text=partial(_in_gap, filling=name),
        )
        for name in ("air", "oil")
    ),
    Quantity(
        "coarser",
        "on a coarser grid",
        text=lambda r: (
            f"pixels of {format_engineering(r.coarser.pixel, 'm')}: length "
            f"{format_change(r.coarser.length)},"
            f" contact area {format_change(r.coarser.contact_area)}"
        ),
    ),
    Quantity("calibrated"),
    Quantity("correlation_inputs", "for COMSOL, Ansys", form=_correlation_words),
    Quantity("draws"),
    Quantity("interval", of=lambda r: _interval(r)),
    *CAUTIONS,
)
"""Quantities of a `Conductance`."""


def _is_plated(result: joint.Conductance) -> bool:
    return result.largest.pair.is_coated


CONDUCTANCE_COLUMNS = (
    Column("load", "load [N]"),
    Column("contact_area", "contact [m²]", shown=contact_fields.shares("contact_area")),
    Column("saturated_area", "saturated [m²]", shown=contact_fields.shares("saturated_area")),
    Column("spots", "spots"),
    Column("length", "length [m]"),
    Column("electrical_plating", when=_is_plated),
    Column("thermal_plating", when=_is_plated),
    *(
        Column(f"base_{name}", f"[{unit}]", of=f"base.{name}", when=lambda r: r.base is not None)
        for name, unit in (("electrical_resistance", "Ω"), ("thermal_resistance", "K/W"))
    ),
    Column("electrical_resistance", "resistance [Ω]", when=_electrical),
    # Tables show the resistance of a free map, and the conductance per area of a periodic one.
    Column("thermal_resistance", "thermal [K/W]", when=_thermal, listed=lambda r: not _by_area(r)),
    Column("electrical_conductance", "[S/m²]", when=_electrical),
    Column("thermal_conductance", "per area [W/(m² K)]", when=_thermal, listed=_by_area),
    Column("voltage", "[V]", when=_has_current),
    Column("hottest", "[K]", when=_has_current),
    Column("gap_conductance", "gap [W/(m² K)]", when=_has_filling, of="steps.filled_gap"),
    Column("joint_conductance", "joint [W/(m² K)]", when=_has_filling),
    *(
        Column(
            f"thermal_conductance_{name}",
            f"with {name} [W/(m² K)]",
            of=_conductance_with_filling(name),
            when=_has_filling_estimate,
        )
        for name in ("air", "oil")
    ),
    Column(
        "greenwood_length",
        "Greenwood [m]",
        shown=lambda r: _ratio(r, "greenwood_length", *joint.DISCS),
    ),
    Column(
        "correlation_length",
        "correlation [m]",
        shown=lambda r: _ratio(r, "correlation_length", 0.0, math.inf),
    ),
)
"""Columns of the loads of a `Conductance`."""

_MEANING = {
    (): "The resistance is between distant points in both bodies: it includes the spreading from "
    "the whole map. A larger map has less, but not in proportion to its area.",
    (0, 1): "The resistance is that of the joint over one period, inversely proportional to the "
    "area.",
}
_STRIP = (
    "The resistance is that of one period, up to a distance of the longer side of the map: the "
    "potential of an endless strip is unbounded."
)


def _span(spread: tuple[float, float]) -> str:
    return f"{spread[0]:g} to {spread[1]:g}"


def _gap_sentence(result: joint.Conductance) -> str:
    if result.filling is not None:
        return f"contact and gap, filled with {result.filling.name}, conduct side by side"
    filled = (
        ", unless it is filled: with air (1 bar) or oil in it the contact and the gap conduct side "
        "by side"
    )
    return f"the gap conducts nothing{filled if _has_filling_estimate(result) else ''}"


_FIGURES = (
    Illustration(
        "conductance",
        conductance,
        "Resistance over load, computed and by two estimates: Greenwood's formula for circular "
        "spots and the correlation for large flat joints.",
        FRONT,
        WIDE,
        lambda result: len(result.steps) > 1,
    ),
    Illustration(
        "crossed",
        lambda result: maps.pressure(result.largest),
        "Contact pressure. Heat and current cross the spots in color.",
        FRONT,
        MIDDLE,
        lambda result: len(result.steps) == 1,
    ),
)


_ZERO_CELSIUS = 273.15


def _joint_texts(result: joint.Conductance, index: int) -> list[str]:
    """Return conductance and resistance under one of the loads."""
    texts = []
    if _thermal(result):
        if _by_area(result):
            texts.append(f"h = {format_short(result.joint_conductance[index], 'W/(m² K)')}")
        else:
            texts.append(f"R = {format_short(result.thermal_resistance[index], 'K/W')} (thermal)")
    if _electrical(result):
        resistance = result.electrical_resistance[index]
        if _by_area(result):
            area = resistance * result.nominal_area
            texts.append(f"R·A = {plain_decimal(area * 1e12, 3)} Ω µm²")
        else:
            texts.append(f"R = {format_short(resistance, 'Ω')}")
    return texts


def _joint_values(result: joint.Conductance, index: int) -> list[str]:
    """Return `_joint_texts` without their names."""
    texts = _joint_texts(result, index)
    return [text.partition(" = ")[2].removesuffix(" (thermal)") for text in texts]


def _interval(result: joint.Conductance) -> Interval:
    """Return the interval of the constriction length under the largest load."""
    coarser = math.nan if result.coarser is None else result.coarser.length
    change = math.nan if result.base is None else _change(result, result.base)
    return uncertainty_report.joint_interval(
        result, "length", result.steps[-1].length, 0, coarser, *result.draws, base=change
    )


def _change(result: joint.Conductance, base: joint.Conductance) -> float:
    """Return the relative change of the constriction length under the ceiling of the base."""
    kind = joint.KINDS[not _electrical(result)]
    first, second = (item.resistance(kind)[-1] for item in (result, base))
    return float(first / second - 1)


def _plating_texts(result: joint.Conductance) -> Iterator[str]:
    """Yield the constriction with the layers over that of the bare bodies."""
    if _is_plated(result):
        changes = ", ".join(
            f"{kind} {format_change(result.column(f'{kind}_plating')[-1] - 1)}"
            for kind, known in (("thermal", _thermal), ("electrical", _electrical))
            if known(result)
        )
        yield f"Spreading in the layers changes the constriction of the bare bodies: {changes}"


class ConductancePresentation(Presentation):
    """Presentation of a conductance."""

    result: joint.Conductance
    table = CONDUCTANCE
    columns = CONDUCTANCE_COLUMNS
    is_listed = True
    figures = _FIGURES
    contact_name = "largest"

    def question(self) -> str:
        """Return the question that a conductance answers."""
        names = [
            name for name, of in (("heat", _thermal), ("current", _electrical)) if of(self.result)
        ]
        verb = "does" if len(names) == 1 else "do"
        loads = phrases.load_range(self.result)
        return f"How well {verb} {' and '.join(names)} cross the joint {loads}?"

    def answer(self) -> str:
        """Return the answer in one sentence."""
        result = self.result
        texts, interval = _joint_texts(result, -1), _interval(result)
        if uncertainty_report.has_ends(interval):
            shown = [
                _joint_values(result.with_length(length), -1)
                for length in (interval.low, interval.high)
            ]
            # The smaller constriction length gives the larger resistance.
            pairs = [
                ends if text[0] == "h" else ends[::-1]
                for text, *ends in zip(texts, *shown, strict=True)
            ]
            texts = [
                f"{text} ({range_text(low, high, str)})"
                for text, (low, high) in zip(texts, pairs, strict=True)
            ]
        return f"At {phrases.load(result.largest)}: {', '.join(texts)}."

    def numbers(self) -> CellTable:
        """Return pressure, contact, conductance and resistance of each load."""
        result = self.result
        head, loads = phrases.load_column(result.largest, result.column("load"))
        heads = ["thermal h" if _by_area(result) else "thermal R"] * _thermal(result)
        heads += ["electrical R·A" if _by_area(result) else "electrical R"] * _electrical(result)
        contacts = contact_fields.shares("contact_area")(result)
        texts = [_joint_values(result, index) for index in range(len(loads))]
        cells = [(*row, *text) for *row, text in zip(loads, contacts, texts, strict=True)]
        return (head, "contact", *heads), cells

    def remarks(self) -> Iterator[str]:
        """Yield the effects of a filled gap and of the pixel, and the accuracy."""
        result = self.result
        if result.filling is not None:
            solid = result.thermal_conductance
            ends = sorted({0, len(solid) - 1})
            yield f"Contact: {' to '.join(format_short(solid[end], 'W/(m² K)') for end in ends)}"
            yield f"Gap ({result.filling.name}): {_share_of_gap(result)}"
        elif _has_filling_estimate(result):
            yield f"Gas is not included. With air in the gap: {_in_gap(result, 'air')}"
        if result.current is not None:
            amperes = format_short(result.current, "A")
            voltage = format_short(float(result.voltage[0]), "V")
            hot = plain_decimal(float(result.hottest[0]) - _ZERO_CELSIUS, 3)
            smallest = " under the smallest load" * (len(result.steps) > 1)
            yield f"At {amperes}: contact voltage {voltage}, hottest spot {hot} °C{smallest}"
        yield uncertainty_report.sources(_interval(result), hint=False)
        yield from phrases.draws_text(result.draws)
        others = []
        if result.coarser is not None:
            others.append(f"twice the pixel {format_change(result.coarser.length)}")
        if result.calibrated is not None:
            others.append(uncertainty_report.under_calibrated(result, 0))
        if others:
            yield f"Constriction length: {', '.join(others)}"
        if result.base is not None:
            ceiling = format_engineering(float(result.base.largest.ceiling or 0), "Pa", 3)
            texts = ", ".join(_joint_texts(result.base, -1))
            yield f"With the ceiling of the base ({ceiling}): {texts}"
        yield from _plating_texts(result)
        yield phrases.status(result.largest)

    def sentences(self) -> Iterator[str]:
        """Yield the sentences that precede the resistances."""
        result = self.result
        yield (
            "The constriction length over the sum of the resistivities of the two bodies, or of "
            "their 1/k, is the conductance."
        )
        yield _MEANING.get(result.largest.boundary.periodic_axes, _STRIP)
        yield f"The whole contact conducts, including yielded metal; {_gap_sentence(result)}."
        if result.film or result.thermal_film:
            yield (
                "The film is added over the contact area; as it makes the flow more uniform, the "
                "true resistance is slightly larger, on a disk by at most "
                f"{format_percent(joint.EVEN_FLOW)} of the constriction."
            )
        yield (
            "The resistance of an elastic contact depends on its coarse outline, where the current "
            "concentrates: a cluster of small spots conducts like one spot of its size. The "
            "contact area, and a film on it, depend on the finest scales; under a ceiling, which "
            "bounds the area, more and smaller spots conduct better. The last two columns are "
            "estimates of the constriction length, relative to the computed one: Greenwood's "
            "formula from radii and places of the spots (1966), and the correlation for large flat "
            "rough joints, which depends on the slope and so on the pixel; 95 % of "
            f"{joint.CASES} rough maps had {_span(joint.GREENWOOD_RANGE)} and "
            f"{_span(CORRELATION_RANGE)}. A dash is outside the range of the formula."
        )

    def problem(self) -> str:
        """Return the bodies and the range of loads."""
        return phrases.problem_of_loads(self.result.largest, self.result.column("load").tolist())

    def works(self) -> Iterator[Use]:
        """Yield the works on spots, joints and gaps."""
        if self.result.current:
            yield make_use("temperature of the spots", "Kohlrausch1900")
        yield make_use("conductance from the stiffness", "Barber2003")
        yield make_use("resistance of the spots", "Holm1967", "Greenwood1966")
        if _is_plated(self.result):
            yield make_use("spreading in layers", "Antonetti1985")
        yield make_use("correlations of flat joints", "Cooper1969", "YovanovichCorrelations1982")
        yield make_use("elastic joints and microhardness", "Mikic1974", "Sridhar1996")
        yield make_use("gas in the gap", "Song1993", "Yovanovich1982")
