"""Report of an interface law."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from operator import attrgetter
from typing import Any

from roughcontact._tools.statistics import LEVEL, mean_with_interval
from roughcontact.analyses.law import illustrations as law_illustrations
from roughcontact.analyses.law.curve import ERROR
from roughcontact.analyses.law.figures import interface_law
from roughcontact.analyses.law.formats import LAW_FORMATS
from roughcontact.analyses.law.model import InterfaceLaw
from roughcontact.analyses.solve import uncertainty_report as uncertainty
from roughcontact.analyses.solve.fields import PAIR
from roughcontact.references import make_use
from roughcontact.report import chapters, phrases
from roughcontact.report.kind import (
    CAUTIONS,
    PROBLEM,
    CellTable,
    Column,
    Columns,
    Presentation,
    Quantity,
    Table,
    Use,
)
from roughcontact.surface.surface import Surface
from roughcontact.uncertainty.intervals import Interval
from roughcontact.units import count_noun, format_engineering, format_percent, plain_decimal


def _range(law: InterfaceLaw) -> str:
    result = law.resolved
    if math.isnan(result.low):
        return "none of the pressures"
    return (
        f"{format_engineering(result.low, 'Pa', 3)} to {format_engineering(result.high, 'Pa', 3)}"
    )


def _part_size(law: InterfaceLaw) -> str:
    size = law.part_size
    assert size is not None
    verdict = (
        "sufficient, quarters agree to" if size.sufficient else "too small, quarters differ by"
    )
    return f"{verdict} {format_percent(size.off)}"


def _columns(law: InterfaceLaw, branch: str) -> dict[str, list[float]]:
    steps = law.of_branch(branch)
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


LAW: Table = (
    *PAIR,
    Quantity(
        "maps",
        "maps",
        of=lambda law: [item.name for item in law.maps],
        text=lambda law: count_noun(len(law.maps), "map"),
        part=PROBLEM,
    ),
    Quantity("rim", "rim that is excluded", unit="m", part=PROBLEM, when=lambda law: law.rim > 0),
    Quantity(
        "first_touch",
        "separation at first touch",
        "ū₀",
        unit="m",
        of=lambda law: law.curve().first_touch,
    ),
    Quantity(
        "resolved",
        "p̄(ū) resolved from",
        of=lambda law: [law.resolved.low, law.resolved.high],
        text=_range,
    ),
    Quantity(
        "part_size",
        "map size",
        of=lambda law: law.part_size and asdict(law.part_size),
        text=_part_size,
        when=lambda law: law.part_size is not None,
    ),
    Quantity(
        "persson_length",
        "Persson's u₀ from the spectrum",
        unit="m",
        when=lambda law: math.isfinite(law.persson_length),
    ),
    Quantity("deviation", "standard deviation of the heights", "σ", "m", of="asperities.deviation"),
    Quantity(
        "summit_density",
        "density of summits",
        "η",
        "1/m²",
        of="asperities.density",
        form=lambda value: f"{value * 1e-6:.4g} /mm²",
        brief=False,
    ),
    Quantity("summit_radius", "radius of summits", "R", "m", of="asperities.radius", brief=False),
    Quantity("bandwidth", "bandwidth", "α", of="asperities.bandwidth", brief=False),
    Quantity("branches", of=lambda law: {branch: _columns(law, branch) for branch in law.branches}),
    Quantity("tables", of=_tables),
    Quantity("friction", of=lambda law: law.friction and asdict(law.friction)),
    Quantity(
        "elastic_slip",
        "elastic slip μ p̄/k_t",
        unit="m",
        of=lambda law: law.elastic_slip()[-1],
        when=lambda law: law.friction is not None,
    ),
    Quantity("backbone", of=lambda law: law.friction and _backbone(law)),
    Quantity("coarser", of=lambda law: law.coarser and asdict(law.coarser)),
    Quantity("calibrated", of=lambda law: law.calibrated and asdict(law.calibrated)),
    Quantity("intervals", of=lambda law: [item.summary() for item in _intervals(law)]),
    Quantity("thermal_conductance", of=lambda law: law.conductance.tolist()),
    *CAUTIONS,
)
"""Quantities of an `InterfaceLaw`."""


def _separations(law: InterfaceLaw) -> list[str]:
    """Return the half-widths of the intervals of ū as lengths, because ū may be near zero."""
    return [format_engineering(step.separation_half, "m", 2) for step in law.steps]


def _contacts(law: InterfaceLaw) -> list[str]:
    return [f"{100 * step.contact_half / step.contact_fraction:.2g} %" for step in law.steps]


def _elastic(law: InterfaceLaw) -> bool:
    return law.is_elastic


def _several(law: InterfaceLaw) -> bool:
    return len(law.maps) > 1


def _per_length(value: float) -> str:
    """Return a stiffness per area in GPa/µm."""
    return "∞" if math.isinf(value) else plain_decimal(value * 1e-15, 3)


def _flows(law: InterfaceLaw) -> bool:
    return not law.is_elastic


LAW_COLUMNS: Columns = (
    Column("branch", "branch", when=_flows, form=lambda branch: branch.removesuffix("ing")),
    Column("pressure", "pressure", unit="Pa", digits=3),
    Column("separation", "ū", unit="m", digits=3),
    Column("separation_half", "±", unit="m", shown=_separations, when=_several),
    Column("mean_gap", "mean gap", unit="m", digits=3, brief=False),
    Column("contact_fraction", "contact", form=format_percent),
    Column("contact_half", "±", shown=_contacts, when=_several, brief=False),
    Column("saturated_fraction", "saturated", form=format_percent, when=_flows),
    Column("stiffness", "loading", unit="Pa/m", form=_per_length),
    Column("unloading_stiffness", "falling", unit="Pa/m", form=_per_length, when=_flows),
    Column(
        "thermal_conductance",
        "conductance",
        unit="W/(m² K)",
        digits=3,
        brief=False,
        when=lambda law: law.bodies is not None,
    ),
    Column(
        "tangential_stiffness",
        "tangential",
        unit="Pa/m",
        form=_per_length,
        brief=False,
        when=lambda law: law.friction is not None,
    ),
    Column("separation_deviation", unit="m"),
    Column("contact_deviation"),
    Column("stiffness_deviation", unit="Pa/m"),
    Column("stiffness_half", unit="Pa/m"),
    Column("persson_separation", unit="m"),
    Column("persson_separation", "Persson", unit="m", digits=3, stored=False, when=_elastic),
    Column("resolved", "resolved", form=lambda value: "yes" if value else "no", brief=False),
)
"""Columns of the steps of an `InterfaceLaw`."""


def _known(law: InterfaceLaw) -> str:
    """Return the interpolation error of the law as text; a full stop if unknown."""
    error = max(law.curve(branch).error for branch in law.branches)
    if math.isnan(error):
        return "."
    return f"; between the solved pressures the law has an error of about {100 * error:.2g} %."


def sentences(law: InterfaceLaw) -> tuple[str, ...]:
    """Return the sentences that precede the law."""
    several = len(law.maps) > 1
    return (
        "The separation ū is the distance of the mean planes of the two surfaces, where indented "
        "points have a negative gap; at first touch it is the height of the highest summit. "
        "Overclosure is minus the separation.",
        "Stiffness per area, in GPa/µm: during loading only the elastic contact resists, during "
        "unloading the whole contact.",
        *(
            ()
            if law.is_elastic
            else (
                "Around spots at the ceiling the elastic contact is often one pixel wide: loading "
                "stiffness scatters by a tenth and more about the slope of the curve.",
            )
        ),
        *(
            (
                f"± is half of the {100 * LEVEL:.0f} % interval of the mean over all maps of this "
                "surface.",
            )
            if several
            else ()
        ),
        *(
            ()
            if law.is_elastic or len(law.branches) > 1
            else ("The unloading branch was not solved.",)
        ),
        *(
            ("No point is at the ceiling: unloading follows the loading curve.",)
            if law.is_elastic
            else ()
        ),
        *(
            ("Persson's theory is evaluated for the elastic joint with the spectrum of the maps.",)
            if math.isfinite(law.persson_length)
            else ("Persson's theory needs maps without missing points.",)
        ),
        f"Tables for other programs have enough rows for linear interpolation to {100 * ERROR:.0f} "
        f"% of the pressure{_known(law)}",
    )


# --- Headline ---

# Maximum number of pressures in the headline table.
_MAX_SCREEN_ROWS = 5


def _problem(law: InterfaceLaw) -> str:
    contact, pairs = law.largest, [item.pair for item in law.maps]
    if len(pairs) == 1 or contact.counter_surface is None:
        name = count_noun(len(pairs), "map") if len(pairs) > 1 else ""
        return f"{phrases.bodies(contact, name)}{phrases.boundary(contact)}"
    # Maps of both faces met at random.
    body, other = map(phrases.material_name, (contact.material, contact.counter_material))
    names, counter_names = (
        _map_names(getattr(pair, face) for pair in pairs) for face in ("surface", "counter_surface")
    )
    faces = f"{names} ({body}) against {counter_names} ({other})"
    return f"{faces}, {count_noun(len(pairs), 'pair')}{phrases.boundary(contact)}"


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
        uncertainty.joint_interval(law, name, item.value, index, changes[index], item)
        for index, (name, item) in enumerate(zip(("closing", "stiffness"), means, strict=True))
    )
    return closing, stiffness


def _answer(law: InterfaceLaw) -> str:
    """Return approach and final stiffness over the range of pressures as a sentence."""
    steps = law.of_branch(law.branches[0])
    first, last = steps[0].pressure, steps[-1].pressure
    ends = phrases.range_text(first, last, lambda value: phrases.format_short(value, "Pa"))
    closing, stiffness = _intervals(law)
    by = uncertainty.with_interval(closing, lambda value: phrases.format_short(value, "m"))
    stiff = uncertainty.with_interval(stiffness, lambda value: f"{_per_length(value)} GPa/µm")
    return f"From {ends} the faces approach by {by}; the stiffness reaches {stiff}."


def _numbers(law: InterfaceLaw) -> CellTable:
    """Return separation, contact and stiffness at some pressures of first loading."""
    steps = law.of_branch(law.branches[0])
    several, flows = _several(law), _flows(law)
    heads = ["pressure", "separation", *([f"± {100 * LEVEL:.0f} %"] * several), "contact"]
    heads.append("stiffness")
    heads += ["unloading"] * flows
    rows = []
    for step in steps:
        row = [
            phrases.format_short(step.pressure, "Pa"),
            phrases.format_short(step.separation, "m"),
        ]
        row += [format_engineering(step.separation_half, "m", 2)] * several
        row += [format_percent(step.contact_fraction), f"{_per_length(step.stiffness)} GPa/µm"]
        row += [f"{_per_length(step.unloading_stiffness)} GPa/µm"] * flows
        rows.append(tuple(row))
    return tuple(heads), chapters.evenly_spaced(rows, _MAX_SCREEN_ROWS)


def _remarks(law: InterfaceLaw) -> tuple[str, ...]:
    """Return resolved range, interpolation error, and tangential and unloading results."""
    _, stiffness = _intervals(law)
    lines: list[str] = []
    if uncertainty.has_ends(stiffness):
        lines.append(uncertainty.sources(stiffness, hint=False))
    lines.append(f"Resolved: {_range(law)}")
    error = max(law.curve(branch).error for branch in law.branches)
    if not math.isnan(error):
        lines[-1] += f"; interpolation error {100 * error:.2g} %"
    if law.friction is not None:
        last = law.of_branch(law.branches[0])[-1]
        each = [
            f"{_per_length(last.unloading_stiffness * ratio)} ({axis})"
            for axis, ratio in zip("yx", law.friction.ratios, strict=True)
        ]
        lines.append(
            f"Tangential at {phrases.format_short(last.pressure, 'Pa')}: {', '.join(each)} GPa/µm; "
            f"elastic slip {phrases.format_short(float(law.elastic_slip()[-1]), 'm')}"
        )
    if len(law.branches) > 1:
        last = min(law.of_branch(law.branches[1]), key=lambda step: step.pressure)
        lines.append(
            f"Unloaded to {phrases.format_short(last.pressure, 'Pa')}: "
            f"{phrases.format_short(last.separation, 'm')}"
            f", contact {format_percent(last.contact_fraction)}"
        )
    return tuple(lines)


def _works(law: InterfaceLaw) -> Iterator[Use]:
    yield make_use("separation by theory", "Persson2007", "Yang2008", "Almqvist2011")
    yield make_use("asperities", "Greenwood1970", "Nayak1971")
    if law.bodies is not None:
        yield make_use("conductance from the stiffness", "Barber2003")


def question(law: InterfaceLaw) -> str:
    """Return the question that an interface law answers."""
    pressures = [step.pressure for step in law.steps]
    ends = [format_engineering(value, "Pa", 3) for value in (min(pressures), max(pressures))]
    return f"How far does the joint close from {phrases.span(ends)}?"


KIND = Presentation(
    InterfaceLaw,
    LAW,
    LAW_COLUMNS,
    question=question,
    sentences=sentences,
    figures=law_illustrations.LAW,
    plots=(interface_law,),
    contact=attrgetter("largest"),
    works=_works,
    save=LAW_FORMATS.write,
    problem=_problem,
    answer=_answer,
    numbers=_numbers,
    remarks=_remarks,
)
