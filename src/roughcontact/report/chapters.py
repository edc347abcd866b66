"""Chapters that all reports share."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable, Sequence
from importlib import metadata

import numpy as np

from roughcontact._version import __version__
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.errors import InputError
from roughcontact.material.material import Material
from roughcontact.plots import maps, profiles
from roughcontact.report import assumptions, page, wording
from roughcontact.report.page import Chapter, Row, Section, Table
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering, percent

_LIBRARIES = ("numpy", "scipy", "ducc0", "matplotlib")


# Spots whose share of the load is told, and spots that make a distribution worth drawing.
_LARGEST = 10

_ENOUGH_SPOTS = 3


ROUGHNESS = {
    "Sq": ("m", "root-mean-square height"),
    "Sa": ("m", "mean absolute height"),
    "Sp": ("m", "highest peak above the mean"),
    "Sv": ("m", "deepest dale below the mean"),
    "Sz": ("m", "height from deepest dale to highest peak"),
    "Ssk": ("", "skewness: negative if dales reach further than peaks"),
    "Sku": ("", "kurtosis: 3 for a Gaussian distribution of heights"),
    "Sdq": ("", "root-mean-square slope"),
    "Sdr": ("%", "excess of the developed over the projected area"),
    "Sal": ("m", "distance over which heights lose their likeness"),
    "Str": ("", "texture: near 1 the same in all directions, near 0 directional"),
    "Sk": ("m", "height of the core"),
    "Spk": ("m", "reduced height of the peaks above the core"),
    "Svk": ("m", "reduced depth of the dales below the core"),
    "Smr1": ("%", "share of the map that the peaks take"),
    "Smr2": ("%", "share of the map that peaks and core take"),
    "Vmp": ("ml/m²", "material volume of the peaks"),
    "Vmc": ("ml/m²", "material volume of the core"),
    "Vvc": ("ml/m²", "void volume of the core"),
    "Vvv": ("ml/m²", "void volume of the dales"),
}
"""Unit and meaning of the parameters of `Surface.roughness`."""


def subtitle(result: ContactResult) -> str:
    """Return bodies, size and grid in one line."""
    ny, nx = result.surface.shape
    height, width = (engineering(side, "m", 3) for side in result.surface.size)
    other = result.counter_surface
    against = "a flat counter-body"
    if other is not None:
        against = other.provenance.source or "a second measured surface"
    return (
        f"{_body(result.material)} against {against} ({_body(result.counter_material)}); "
        f"{height} × {width}, {ny} × {nx} points (y × x)"
    )


def _body(material: Material) -> str:
    if math.isinf(material.young):
        return "rigid"
    stiffness = f"E {engineering(material.young, 'Pa')}"
    return f"{material.name}, {stiffness}" if material.name else stiffness


def prepared(result: ContactResult) -> list[Chapter]:
    """Return the chapters on the maps, their preparation and their roughness."""
    surfaces = [result.surface]
    names = ["map"]
    if result.counter_surface is not None:
        surfaces.append(result.counter_surface)
        names = ["first body", "counter-body"]
    chapter = Chapter("Input and preparation")
    facts = [_facts(surface) for surface in surfaces]
    rows = [(label, *(fact[label] for fact in facts)) for label in facts[0]]
    chapter.add("table", Table(rows, ("", *names) if len(names) > 1 else ()))
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        if surface.provenance.steps:
            chapter.add("text", f"Preparation{of}, in this order:")
            chapter.add("steps", [page.sentence(step) for step in surface.provenance.steps])
        else:
            chapter.add("text", f"Preparation{of}: none recorded; the heights are as given.")
        sq = engineering(surface.Sq, "m", 3)
        chapter.add(
            "figure",
            page.picture(
                maps.surface(surface),
                f"Map of the heights{of}, root-mean-square height {sq}.",
                f"Heights{of} as they were pressed, after preparation. Light is high: contact "
                "begins there." + (" Grey points are missing." if surface.missing else ""),
            ),
        )
    roughness = Chapter("Roughness of the prepared surface")
    roughness.add(
        "text",
        "Parameters of ISO 25178-2, of the heights as they were pressed; no filter is applied "
        "beyond the preparation above.",
    )
    roughness.add("table", _roughness_table(surfaces, names))
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        roughness.add(
            "figure",
            page.picture(
                profiles.bearing_curve(surface),
                f"Material ratio curve{of}.",
                f"Material ratio curve{of} (bearing curve): which share of the map lies above a "
                "height. Steep ends mean few high peaks or deep dales; contact begins at the left "
                "end.",
            ),
        )
    return [chapter, roughness]


def _facts(surface: Surface) -> dict[str, str]:
    about = surface.provenance
    (ny, nx), (dy, dx), (height, width) = surface.shape, surface.pixel, surface.size
    low, high = float(np.nanmin(surface.heights)), float(np.nanmax(surface.heights))
    missing = "none after preparation" if about.steps else "none"
    if surface.missing:
        share = percent(surface.missing / surface.heights.size)
        missing = f"{surface.missing} ({share}), taken as never touching"
    return {
        "Source": about.source or "not named",
        "Instrument": about.instrument or "not named",
        "Channel": about.channel or "the only one",
        "Grid (y × x)": f"{ny} × {nx} points",
        "Pixel (y × x)": f"{engineering(dy, 'm')} × {engineering(dx, 'm')}",
        "Size (y × x)": f"{engineering(height, 'm')} × {engineering(width, 'm')}",
        "Heights": f"{engineering(low, 'm')} to {engineering(high, 'm')}",
        "Missing points": missing,
    }


def _roughness_table(surfaces: Sequence[Surface], names: Sequence[str]) -> Table:
    columns = []
    for surface in surfaces:
        try:
            columns.append(surface.roughness())
        except InputError:
            # Holes that leave no point both of its neighbours.
            columns.append({})
    rows = [
        (
            name,
            *(
                (_texture(value) if name == "Str" else parameter(value, unit))
                for value in (values.get(name, math.nan) for values in columns)
            ),
            meaning,
        )
        for name, (unit, meaning) in ROUGHNESS.items()
    ]
    values = tuple(names) if len(names) > 1 else ("value",)
    return Table(rows, ("parameter", *values, "meaning"))


def parameter(value: float, unit: str) -> str:
    """Return a roughness parameter as text, in its unit of `ROUGHNESS`."""
    if math.isnan(value):
        return "not defined on this map"
    if unit == "%":
        return f"{100 * value:.4g} %"
    if unit == "ml/m²":
        return f"{1e6 * value:.4g} ml/m²"
    return engineering(value, unit)


def _texture(value: float) -> str:
    # The summary has 0 where heights stay alike along one direction across all of the map.
    return "near 0" if value == 0 else parameter(value, "")


def problem(
    result: ContactResult, given: Sequence[Row], plasticity: Sequence[Row], laws: bool = False
) -> Chapter:
    """Return the chapter on materials and load.

    Parameters
    ----------
    result : ContactResult
        The contact.
    given : sequence of (str, str)
        Names and values of what was asked for.
    plasticity : sequence of (str, str)
        How yielding is taken into account.
    laws : bool
        Whether laws of hardening count, and hardness does not.

    Returns
    -------
    Chapter
        Two tables.
    """
    chapter = Chapter("Materials and load")
    bodies = (result.material, result.counter_material)
    rows: list[Row] = [
        ("Material", *(body.name or "not named" for body in bodies)),
        ("Young's modulus E", *(_modulus(body.young) for body in bodies)),
        ("Poisson's ratio ν", *(_ratio(body) for body in bodies)),
        ("Yield strength σ_Y", *(_strength(body.yield_strength) for body in bodies)),
    ]
    if laws or any(body.hardening is not None for body in bodies):
        rows.append(("Hardening", *(wording.hardening(body) for body in bodies)))
    if not laws:
        rows.append(("Hardness", *(_strength(body.hardness) for body in bodies)))
    first = (_strength(body.first_yield_pressure) for body in bodies)
    rows.append(("Peak pressure of first yield, sphere", *first))
    chapter.add("table", Table(rows, ("", "body", "counter-body")))
    boundary = f"{result.boundary}: {result.boundary.meaning}"
    modulus = (
        f"{engineering(result.contact_modulus, 'Pa')}, from 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂"
    )
    rows = [*given, ("Contact modulus E*", modulus), *plasticity, ("Boundary", boundary)]
    chapter.add("table", Table(rows))
    return chapter


def _modulus(young: float) -> str:
    return "rigid" if math.isinf(young) else engineering(young, "Pa")


def _ratio(body: Material) -> str:
    return "–" if math.isinf(body.young) else f"{body.poisson:g}"


def _strength(value: float | None) -> str:
    return "not given" if value is None else engineering(value, "Pa")


def assumed(stated: Iterable[assumptions.Statement]) -> Chapter:
    """Return the chapter on what is taken for granted."""
    chapter = Chapter("What is assumed")
    chapter.add(
        "text",
        "The numbers of this report are those of a model. It takes the following for granted; "
        "where one of these does not hold for the part at hand, the numbers do not either.",
    )
    chapter.add("terms", [(item.topic, item.text, page.sentence(item.caution)) for item in stated])
    return chapter


def contact_spots(result: ContactResult, spots: Spots) -> Chapter:
    """Return the chapter on number, size and load of the spots."""
    chapter = Chapter("Contact spots")
    if spots.count == 0:
        chapter.add("text", "The bodies do not touch.")
        return chapter
    carried = float(spots.load.sum())
    largest = float(spots.area[0])
    chapter.add(
        "text",
        "A spot is a set of touching pixels joined by their edges. Its area decides how it "
        "carries heat and current, how far below it yielding begins, and whether the map resolves "
        "it.",
    )
    rows: list[Row] = [
        ("Number of spots", str(spots.count), ""),
        ("Mean area", engineering(float(spots.area.mean()), "m²"), ""),
        (
            "Largest area",
            engineering(largest, "m²"),
            f"{percent(largest / result.contact_area)} of the contact area",
        ),
        (
            "Load on the largest",
            engineering(float(spots.load[0]), "N"),
            f"{percent(min(float(spots.load[0]) / carried, 1.0))} of the load",
        ),
    ]
    if spots.count > _LARGEST:
        share = float(spots.load[:_LARGEST].sum()) / carried
        rows.append(
            (f"Load on the {_LARGEST} largest", percent(min(share, 1.0)), "of the load")
        )  # fmt: skip
    rows.append(
        (
            "Pixels of a spot that carries",
            str(assumptions.carrying_pixels(result, spots)),
            "spots of at least this size carry half of the load",
        )
    )
    chapter.add("table", Table(rows, ("quantity", "value", "note")))
    if spots.count >= _ENOUGH_SPOTS:
        chapter.add(
            "figure",
            page.picture(
                maps.spots(result),
                f"Number of contact spots of at least a given area; {spots.count} in all.",
                "How many spots have at least a given area, both axes logarithmic. On the shaded "
                "ground spots have so few pixels that the grid decides on their size.",
            ),
        )
    return chapter


def added(section: Section) -> Chapter:
    """Return a chapter that another result adds."""
    chapter = Chapter(section.title)
    for paragraph in section.text:
        chapter.add("text", paragraph)
    if section.table:
        head, *rows = section.table
        chapter.add("table", Table(rows, head))
    for caption, figure in section.figures:
        chapter.add("figure", page.picture(figure, caption, caption))
    return chapter


def repetition(version: str, command: str, lines: str) -> Chapter:
    """Return the chapter on how to get the same result again.

    Parameters
    ----------
    version : str
        Version of the program that solved.
    command : str
        What was typed; empty if nothing was.
    lines : str
        A script; empty if there is none.

    Returns
    -------
    Chapter
        With the command, or else the script, and the versions of the libraries.
    """
    chapter = Chapter("How to repeat it")
    if command:
        chapter.add("text", "The command that gave this result:")
    elif lines:
        chapter.add("text", "This script solves the same problem:")
    if command or lines:
        chapter.add("code", command or lines)
    else:
        chapter.add(
            "text",
            "The surface or its preparation was made in a program of its own, which has to be "
            "kept to repeat the result; all other input is in this report.",
        )
    rows: list[Row] = [
        ("roughcontact", f"{version or 'unknown'} (solved), {__version__} (this report)"),
        *((name, _installed(name)) for name in _LIBRARIES),
        ("Python", platform.python_version()),
        ("System", platform.platform()),
    ]
    chapter.add("text", "Versions where this report was written:")
    chapter.add("table", Table(rows))
    return chapter


def _installed(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
