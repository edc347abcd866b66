"""Report of wear."""

from __future__ import annotations

import os
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._tools import netcdf
from roughcontact._tools.files import require_suffix
from roughcontact.analyses.solve.fields import CONTACT
from roughcontact.analyses.wear.figures import running_in
from roughcontact.analyses.wear.model import FRETTING, Wear
from roughcontact.contact import archive
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.drawing import maps
from roughcontact.references import make_use
from roughcontact.report import chapters, kind, phrases
from roughcontact.report.assumptions import Assumption
from roughcontact.report.figures import FRONT, Illustration
from roughcontact.report.kind import PROBLEM, Quantity, quantity_of
from roughcontact.report.page import WIDE, Block
from roughcontact.report.phrases import format_share, format_short
from roughcontact.units import format_change, group_digits, order_of_magnitude


def _is_rough(result: Wear) -> bool:
    return not has_nominal_body(result.first.pair.origins)


def _is_map(result: Wear) -> bool:
    return not result.last.pair.is_profile


def _coefficients(values: tuple[float, float]) -> str:
    return ", ".join(f"{value:.3g} m²/N" for value in values if value)


def _rate(value: float) -> str:
    return f"{format_short(value, 'm')} per meter"


def _volumes(values: tuple[float, float]) -> str:
    return kind.format_value(tuple(filter(None, values)), "m³", phrases.DIGITS)


def _column(key: str, name: str, unit: str = "1", **more: Any) -> kind.Column:
    return kind.Column(key, name, unit, digits=phrases.DIGITS, **more)


def _area(key: str, name: str, **more: Any) -> kind.Column:
    def shares(result: Wear) -> list[float]:
        return [getattr(step, key) / result.last.touchable_area for step in result.steps]

    return kind.Column(key, name, "m²", shown=shares, form=format_share, **more)


_COLUMNS: kind.Columns = (
    _column("distance", "distance", "m"),
    _column("wear", "mean wear", "m"),
    _column("max_wear", "largest wear", "m", brief=False),
    _area("contact_area", "contact"),
    _area("saturated_area", "saturated", brief=False),
    _column("mean_pressure", "mean pressure", "Pa", brief=False),
    _column("max_pressure", "peak pressure", "Pa"),
    _column("mean_gap", "mean gap", "m"),
    _column("Sq", "Sq", "m", when=_is_rough),
    _column("Ssk", "Ssk", form=lambda value: group_digits(f"{value:.2f}"), when=_is_rough),
    _column("Spk", "Spk", "m", when=_is_rough),
    _column("moved", "load moved", form=format_share, brief=False),
    kind.Column("certificate", "certificate", form=order_of_magnitude, brief=False),
    kind.Column("load_error"),
    kind.Column("convolutions"),
    kind.Column("seconds", unit="s"),
)


_STORED = ("source", "preparation", "load", "boundary", "contact_modulus", "ceiling", "tolerance")
_TABLE: kind.Table = (
    *(kind.delegated("first", quantity_of(CONTACT, key), name="", part=PROBLEM) for key in _STORED),
    Quantity("motion", "motion", part=PROBLEM),
    Quantity("coefficients", "wear coefficients", "k", "m²/N", form=_coefficients, part=PROBLEM),
    Quantity("friction"),
    Quantity("distance", "distance", "s", "m"),
    Quantity("wear_rate", "mean wear", form=_rate, meaning="k p̄"),
    Quantity("volumes", "worn volumes", unit="m³", form=_volumes, meaning="k W s", when=_is_map),
    Quantity("friction_work", unit="J"),
    Quantity("conforms"),
    Quantity("step_errors"),
    *kind.CAUTIONS,
    Quantity("steps", of=lambda result: kind.stored_columns(_COLUMNS, result)),
    Quantity("version", of="last.version"),
)


def _question(result: Wear) -> str:
    name = phrases.source(result.first.surface.provenance)
    return f"How does {name} run in under {phrases.load(result.first)}?"


def _answer(result: Wear) -> str:
    """Return distance, contact, roughness and wear depth as a sentence."""
    first, last, area = result.steps[0], result.steps[-1], result.last.touchable_area
    contact = phrases.range_text(first.contact_area / area, last.contact_area / area, format_share)
    reached = f"after {format_short(result.distance, 'm')}: contact {contact}"
    if not _is_rough(result):
        deepest, form = format_short(last.max_wear, "m"), partial(format_short, unit="Pa")
        peaks = phrases.range_text(first.max_pressure, last.max_pressure, form)
        return f"Wears by up to {deepest} {reached}, peak pressure {peaks}."
    heights = phrases.range_text(first.Sq, last.Sq, partial(format_short, unit="m"))
    text = f"{reached}, Sq {heights}, {format_short(last.wear, 'm')} mean wear"
    if not result.conforms:
        return f"Runs in {text}."
    return f"Conforms {text}; from there it wears uniformly by {_rate(result.wear_rate)}."


def _numbers(result: Wear) -> kind.CellTable:
    """Return the steps at the requested distances, or some of all steps."""
    heads, rows = KIND.listing(result, True)
    if len(result.distances) == 1:
        return heads, chapters.evenly_spaced(rows, 6)
    wanted = {0.0, *result.distances, result.distance}
    steps = zip(rows, result.steps, strict=True)
    return heads, [row for row, step in steps if step.distance in wanted]


def _remarks(result: Wear) -> tuple[str, ...]:
    """Return the effect of the wear coefficient, and the accuracy of the steps."""
    first, errors = result.first, result.step_errors
    lines = [
        "Contact and roughness depend on the mean wear alone; the distance is for k = "
        f"{_coefficients(result.coefficients)}, which scatters by ±50 % and more"
    ]
    if first.saturated_fraction:
        share = format_share(first.saturated_fraction / first.contact_fraction)
        lines.append(f"Before wear {share} of the contact is at the pressure ceiling")
    layer = sum(item.thickness for item in first.material.coating)
    if layer:
        share = format_share(result.steps[-1].max_wear / layer)
        lines.append(f"The deepest wear is {share} of the coating, which keeps its thickness here")
    if result.friction_work is not None:
        work = format_short(result.friction_work, "J" if _is_map(result) else "J/m")
        lines.append(f"Work of friction: {work}")
    contact, peak = (format_change(errors[key]) for key in ("contact_area", "max_pressure"))
    worst = max(step.certificate for step in result.steps)
    return (
        *lines,
        f"Last step in two: contact {contact}, peak pressure {peak}",
        phrases.worst(worst, first.tolerance, len(result.steps)),
    )


def _method(result: Wear) -> list[Block]:
    text = (
        f"Archard's law at each pixel, in {len(result.steps) - 1} implicit steps: wear coefficient "
        "times distance is an additional compliance of each pixel. The last step is divided in "
        "two, which estimates the error of the steps, and solved again without wear."
    )
    return [Block("text", text)]


_ASSUMPTIONS = (
    Assumption(
        "Archard's law at each pixel; debris leaves",
        lambda r: f"k = {_coefficients(r.coefficients)}, no heat by friction",
        "the mechanism changes, a film forms, or debris is trapped",
    ),
    Assumption(
        "The counter-body is smooth, or the same points meet",
        lambda r: f"{r.motion}, {'both bodies' if r.motion == FRETTING else 'one body'} worn",
        "rough bodies slide farther than an asperity",
    ),
)

_FIGURES = (
    Illustration(
        "running-in",
        running_in,
        "Contact, pressure and roughness over the mean wear depth, which do not depend on the wear "
        "coefficient; dotted: before wear.",
        FRONT,
        WIDE,
    ),
    Illustration(
        "worn", lambda result: maps.surface(result.worn), "The worn body, unloaded.", when=_is_map
    ),
)


def _dataset(result: Wear) -> netcdf.Dataset:
    """Return the worn contact with the wear depth and all steps as a dataset."""
    dataset = archive.to_dataset(result.last)
    about = {"units": "m", "long_name": "wear depth of both bodies"}
    dataset["wear_depth"] = (("y", "x"), result.depth, about)
    for column in _COLUMNS:
        values = np.array(column.values(result), float)
        dataset[f"step_{column.key}"] = ("step", values, {"units": column.unit})
    body, counter = result.coefficients
    dataset.attrs |= {"wear_coefficient": body, "counter_wear_coefficient": counter}
    dataset.attrs |= {"wear_coefficient_units": "m2/N", "motion": result.motion}
    return dataset


def _save(result: Wear, path: str | os.PathLike[str]) -> None:
    """Write maps and steps as NetCDF, or the steps as CSV or JSON."""
    require_suffix(path, ".nc", ".csv", ".json")
    if Path(path).suffix.lower() == ".nc":
        netcdf.write(_dataset(result), path, dict.fromkeys(archive.PACKED, netcdf.PACKED))
    else:
        KIND.write(result, path)


KIND = kind.Presentation(
    Wear,
    _TABLE,
    _COLUMNS,
    figures=_FIGURES,
    plots=(running_in,),
    contact=attrgetter("first"),
    question=_question,
    problem=lambda result: f"{phrases.problem(result.first)}, {result.motion}",
    answer=_answer,
    numbers=_numbers,
    meaning=lambda result: f"After wear: {phrases.regime(result.last)}",
    remarks=_remarks,
    method=_method,
    assumptions=_ASSUMPTIONS,
    save=_save,
    dataset=_dataset,
    works=lambda _: (make_use("wear", "Archard1953", "Podra1999", "Furustig2016"),),
)
