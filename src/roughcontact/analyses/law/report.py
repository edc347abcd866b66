"""Report of an interface law."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator
from typing import Any

from roughcontact._tools.statistics import LEVEL, mean_with_interval
from roughcontact.analyses.law.curve import ERROR
from roughcontact.analyses.law.figures import interface_law
from roughcontact.analyses.law.formats import LAW_FORMATS
from roughcontact.analyses.law.model import InterfaceLaw
from roughcontact.analyses.solve import uncertainty_report
from roughcontact.analyses.solve.fields import PAIR
from roughcontact.references import make_use
from roughcontact.report import chapters, phrases
from roughcontact.report.figures import FRONT, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    PROBLEM,
    CellTable,
    Column,
    Quantity,
    Use,
    capitalize_first,
)
from roughcontact.report.page import WIDE
from roughcontact.report.phrases import format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.surface.surface import Surface
from roughcontact.uncertainty.intervals import Interval
from roughcontact.units import count_noun, format_engineering, format_percent, plain_decimal


def _range(law: InterfaceLaw) -> str:
    result = law.resolved
    if math.isnan(result.low):
        return "none of the pressures"
    return range_text(result.low, result.high, lambda value: format_engineering(value, "Pa", 3))


def _part_size(law: InterfaceLaw) -> str:
    size = law.part_size
    assert size is not None
    verdict = (
        "sufficient, quarters agree to" if size.sufficient else "too small, quarters differ by"
    )
    return f"{verdict} {format_percent(size.off)}"


def _columns(law: InterfaceLaw, branch: str) -> dict[str, list[float]]:
    steps = law.branch_steps(branch)
    names = [column.key for column in LAW_COLUMNS if column.stored and column.key != "branch"]
    return {name: [getattr(step, name) for step in steps] for name in names}


def _tables(law: InterfaceLaw) -> dict[str, Any]:
    names = ("pressure", "separation", "mean_gap", "contact_fraction", "thermal_conductance")
    tables = {branch: law.table(branch) for branch in law.branches}
    return {
        branch: {"error": table.error, **{name: getattr(table, name).tolist() for name in names}}
        for branch, table in tables.items()
    }


def _backbone(law: InterfaceLaw) -> dict[str, dict[str, list[float]]]:
    return {
        name: {key: values.tolist() for key, values in vars(law.backbone(axis)).items()}
        for axis, name in enumerate("yx")
    }


LAW = (
    *PAIR,
    Quantity(
        "maps",
        "maps",
        of="maps.name",
        text=lambda law: count_noun(len(law.maps), "map"),
        part=PROBLEM,
    ),
    Quantity("rim", "rim that is excluded [m]", part=PROBLEM, when=lambda law: law.rim > 0),
    Quantity(
        "first_touch", "separation at first touch $ū₀$ [m]", of=lambda law: law.curve().first_touch
    ),
    Quantity(
        "resolved",
        "p̄(ū) resolved from",
        of=lambda law: (law.resolved.low, law.resolved.high),
        text=_range,
    ),
    Quantity("part_size", "map size", text=_part_size),
    Quantity(
        "persson_length",
        "Persson's u₀ from the spectrum [m]",
        when=lambda law: math.isfinite(law.persson_length),
    ),
    Quantity("deviation", "standard deviation of the heights $σ$ [m]", of="asperities.deviation"),
    Quantity(
        "summit_density",
        "density of summits $η$ [1/m²]",
        of="asperities.density",
        form=lambda value: f"{value * 1e-6:.4g} /mm²",
    ),
    Quantity("summit_radius", "radius of summits $R$ [m]", of="asperities.radius"),
    Quantity("bandwidth", "bandwidth $α$", of="asperities.bandwidth"),
    Quantity("branches", of=lambda law: {branch: _columns(law, branch) for branch in law.branches}),
    Quantity("tables", of=_tables),
    Quantity("friction"),
    Quantity(
        "elastic_slip",
        "elastic slip μ p̄/k_t [m]",
        of=lambda law: law.elastic_slip()[-1],
        when=lambda law: law.friction is not None,
    ),
    Quantity("backbone", of=lambda law: law.friction and _backbone(law)),
    Quantity("coarser"),
    Quantity("calibrated"),
    Quantity("intervals", of=lambda law: _intervals(law)),
    Quantity("thermal_conductance", of="conductance"),
    *CAUTIONS,
)
"""Quantities of an `InterfaceLaw`."""


def _separations(law: InterfaceLaw) -> list[str]:
    """Return the half-widths of the intervals of ū as lengths, because ū may be near zero."""
    return [format_engineering(step.separation_half, "m", 2) for step in law.steps]


def _contacts(law: InterfaceLaw) -> list[str]:
    return [f"{100 * step.contact_half / step.contact_fraction:.2g} %" for step in law.steps]


def _several(law: InterfaceLaw) -> bool:
    return len(law.maps) > 1


def _per_length(value: float) -> str:
    """Return a stiffness per area in GPa/µm."""
    return "∞" if math.isinf(value) else plain_decimal(value * 1e-15, 3)


def _flows(law: InterfaceLaw) -> bool:
    return not law.is_elastic


LAW_COLUMNS = (
    Column("branch", "branch", when=_flows, form=lambda branch: branch.removesuffix("ing")),
    Column("pressure", "pressure [Pa]", digits=3),
    Column("separation", "ū [m]", digits=3),
    Column("separation_half", "± [m]", shown=_separations, when=_several),
    Column("mean_gap", "mean gap [m]", digits=3),
    Column("contact_fraction", "contact", form=format_percent),
    Column("contact_half", "±", shown=_contacts, when=_several),
    Column("saturated_fraction", "saturated", form=format_percent, when=_flows),
    Column("stiffness", "loading [Pa/m]", form=_per_length),
    Column("unloading_stiffness", "falling [Pa/m]", form=_per_length, when=_flows),
    Column(
        "thermal_conductance",
        "conductance [W/(m² K)]",
        digits=3,
        when=lambda law: law.bodies is not None,
    ),
    Column(
        "tangential_stiffness",
        "tangential [Pa/m]",
        form=_per_length,
        when=lambda law: law.friction is not None,
    ),
    Column("separation_deviation", "[m]"),
    Column("contact_deviation"),
    Column("stiffness_deviation", "[Pa/m]"),
    Column("stiffness_half", "[Pa/m]"),
    Column("persson_separation", "Persson [m]", digits=3, listed=lambda law: law.is_elastic),
    Column("resolved", "resolved", form=lambda value: "yes" if value else "no"),
)
"""Columns of the steps of an `InterfaceLaw`."""


def _interpolation_error_text(law: InterfaceLaw) -> str:
    """Return the interpolation error of the law as text; a full stop if unknown."""
    error = max(law.curve(branch).error for branch in law.branches)
    if math.isnan(error):
        return "."
    return f"; between the solved pressures the law has an error of about {100 * error:.2g} %."


_FIGURES = (
    Illustration(
        "law",
        interface_law,
        "Pressure over separation, areas, stiffness, and gap. Thick: mean of the maps. Thin: each "
        "map. Dashed: Persson's elastic theory. Gray: not resolved by the maps.",
        FRONT,
        WIDE,
    ),
)


# Maximum number of pressures in the headline table.
_MAX_SCREEN_ROWS = 5


def _map_names(surfaces: Iterable[Surface]) -> str:
    """Return the names of the different maps of a face."""
    return ", ".join(dict.fromkeys(map(phrases.map_name, surfaces)))


def _intervals(law: InterfaceLaw) -> tuple[Interval, Interval]:
    """Return the intervals of closing and stiffness under the largest pressure."""
    separation = law.values(law.branches[0], "separation")
    means = (
        mean_with_interval(separation[:, 0] - separation[:, -1]),
        law.mean(law.branches[0], "stiffness")[-1],
    )
    coarser = law.coarser and (law.coarser.closing, law.coarser.stiffness)
    changes = coarser or (math.nan, math.nan)
    closing, stiffness = (
        uncertainty_report.joint_interval(law, name, item.value, index, changes[index], item)
        for index, (name, item) in enumerate(zip(("closing", "stiffness"), means, strict=True))
    )
    return closing, stiffness


class LawPresentation(Presentation):
    """Presentation of an interface law."""

    result: InterfaceLaw
    table = LAW
    columns = LAW_COLUMNS
    figures = _FIGURES
    plots = (interface_law,)
    contact_name = "largest"

    def question(self) -> str:
        """Return the question that an interface law answers."""
        pressures = [step.pressure for step in self.result.steps]
        ends = [format_engineering(value, "Pa", 3) for value in (min(pressures), max(pressures))]
        return f"How far does the joint close from {phrases.span(ends)}?"

    def problem(self) -> str:
        """Return bodies and load in one line."""
        contact, pairs = self.result.largest, [item.pair for item in self.result.maps]
        if len(pairs) == 1 or contact.counter_surface is None:
            name = count_noun(len(pairs), "map") if len(pairs) > 1 else ""
            return f"{phrases.bodies(contact, name)}{phrases.boundary(contact)}"
        # Maps of both faces met at random.
        body, other = map(phrases.material_name, (contact.material, contact.counter_material))
        names, counter_names = (
            _map_names(getattr(pair, face) for pair in pairs)
            for face in ("surface", "counter_surface")
        )
        faces = f"{names} ({body}) against {counter_names} ({other})"
        return f"{faces}, {count_noun(len(pairs), 'pair')}{phrases.boundary(contact)}"

    def answer(self) -> str:
        """Return approach and final stiffness over the range of pressures as a sentence."""
        law = self.result
        steps = law.branch_steps(law.branches[0])
        first, last = steps[0].pressure, steps[-1].pressure
        ends = range_text(first, last, lambda value: format_short(value, "Pa"))
        closing, stiffness = _intervals(law)
        by = uncertainty_report.with_interval(closing, lambda value: format_short(value, "m"))
        stiff = uncertainty_report.with_interval(
            stiffness, lambda value: f"{_per_length(value)} GPa/µm"
        )
        return f"From {ends} the faces approach by {by}; the stiffness reaches {stiff}."

    def numbers(self) -> CellTable:
        """Return separation, contact and stiffness at some pressures of first loading."""
        law = self.result
        steps = law.branch_steps(law.branches[0])
        several, flows = _several(law), _flows(law)
        heads = ["pressure", "separation", *([f"± {100 * LEVEL:.0f} %"] * several), "contact"]
        rows = [
            (
                format_short(step.pressure, "Pa"),
                format_short(step.separation, "m"),
                *([format_engineering(step.separation_half, "m", 2)] * several),
                format_percent(step.contact_fraction),
                f"{_per_length(step.stiffness)} GPa/µm",
                *([f"{_per_length(step.unloading_stiffness)} GPa/µm"] * flows),
            )
            for step in steps
        ]
        shown = chapters.evenly_spaced(rows, _MAX_SCREEN_ROWS)
        return (*heads, "stiffness", *["unloading"] * flows), shown

    def remarks(self) -> Iterator[str]:
        """Yield resolved range, interpolation error, and tangential and unloading results."""
        law = self.result
        _, stiffness = _intervals(law)
        if uncertainty_report.has_ends(stiffness):
            yield uncertainty_report.sources(stiffness, hint=False)
        error = max(law.curve(branch).error for branch in law.branches)
        known = [] if math.isnan(error) else [f"interpolation error {100 * error:.2g} %"]
        if law.calibrated is not None:
            known.insert(0, f"stiffness: {uncertainty_report.under_calibrated(law, 1)}")
        if known:
            yield capitalize_first("; ".join(known))
        unloaded = ""
        if len(law.branches) > 1:
            last = min(law.branch_steps(law.branches[1]), key=lambda step: step.pressure)
            at, separation = format_short(last.pressure, "Pa"), format_short(last.separation, "m")
            contact = format_percent(last.contact_fraction)
            unloaded = f"; unloaded to {at}: {separation}, contact {contact}"
        yield f"Resolved: {_range(law)}{unloaded}"
        if law.friction is not None:
            last = law.branch_steps(law.branches[0])[-1]
            each = [
                f"{_per_length(last.unloading_stiffness * ratio)} ({axis})"
                for axis, ratio in zip("yx", law.friction.ratios, strict=True)
            ]
            yield (
                f"Tangential at {format_short(last.pressure, 'Pa')}: {', '.join(each)} "
                f"GPa/µm; elastic slip {format_short(float(law.elastic_slip()[-1]), 'm')}"
            )

    def sentences(self) -> Iterator[str]:
        """Yield the sentences that precede the law."""
        law = self.result
        yield (
            "The separation ū is the distance of the mean planes of the two surfaces, where "
            "indented points have a negative gap; at first touch it is the height of the highest "
            "summit. Overclosure is minus the separation."
        )
        yield (
            "Stiffness per area, in GPa/µm: during loading only the elastic contact resists, "
            "during unloading the whole contact."
        )
        if not law.is_elastic:
            yield (
                "Around spots at the ceiling the elastic contact is often one pixel wide: "
                "loading stiffness scatters by a tenth and more about the slope of the curve."
            )
        if len(law.maps) > 1:
            share = f"{100 * LEVEL:.0f} %"
            yield f"± is half of the {share} interval of the mean over all maps of this surface."
        if law.is_elastic:
            yield "No point is at the ceiling: unloading follows the loading curve."
        elif len(law.branches) == 1:
            yield "The unloading branch was not solved."
        if math.isfinite(law.persson_length):
            of_maps = "the elastic joint with the spectrum of the maps"
            yield f"Persson's theory is evaluated for {of_maps}."
        else:
            yield "Persson's theory needs maps without missing points."
        yield (
            "Tables for other programs have enough rows for linear interpolation to "
            f"{100 * ERROR:.0f} % of the pressure{_interpolation_error_text(law)}"
        )

    def works(self) -> Iterator[Use]:
        """Yield the works cited for the result."""
        yield make_use("separation by theory", "Persson2007", "Yang2008", "Almqvist2011")
        yield make_use("asperities", "Greenwood1970", "Nayak1971")
        if self.result.bodies is not None:
            yield make_use("conductance from the stiffness", "Barber2003")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the law for a program; the suffix selects the format."""
        LAW_FORMATS.write(self.result, path)
