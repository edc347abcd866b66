"""Chapters that all reports share."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from importlib import metadata
from typing import TYPE_CHECKING, Any

from roughcontact._version import __version__
from roughcontact.contact import hertzian
from roughcontact.contact.cautions import Caution
from roughcontact.contact.pair import BODIES
from roughcontact.contact.result import ContactResult
from roughcontact.contact.slab import Slab
from roughcontact.contact.smooth import LINE
from roughcontact.contact.spots import Spots
from roughcontact.errors import InputError
from roughcontact.material.material import Material
from roughcontact.plots import hertz
from roughcontact.report import (
    assumptions,
    assumptions_profile,
    details,
    figures,
    inputs,
    page,
    profile as of_profile,
    smooth,
    traces,
)
from roughcontact.report.kind import Kind
from roughcontact.report.page import Addition, Cells, Chapter, Table
from roughcontact.report.quantities import (
    TRUST,
    Row,
    Table as Quantities,
    beside,
    capital,
    rows_of,
)
from roughcontact.surface import profile
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RIGHT_PROBLEM = "Whether it is the right problem is for the assumptions to say."
"""What no certificate knows."""

_LIBRARIES = ("numpy", "scipy", "ducc0", "matplotlib")


def subtitle(result: ContactResult) -> str:
    """Return bodies, size and grid in one line."""
    ny, nx = result.pair.shape
    height, width = (engineering(side, "m", 3) for side in result.pair.size)
    other = result.counter_surface
    grid = f"{height} × {width}, {ny} × {nx} points (y × x)"
    if isinstance(result.share, Slab):
        grid += f", on {result.share.ranks.count} ranks"
    if result.pair.is_profile:
        grid = f"profile of {width}, {nx} points"
    against = "a flat counter-body"
    if other is not None:
        against = other.provenance.source or "a second measured surface"
    return f"{_body(result.material)} against {against} ({_body(result.counter_material)}); {grid}"


def _body(material: Material) -> str:
    if math.isinf(material.young):
        return "rigid"
    stiffness = f"E {engineering(material.young, 'Pa')}"
    return f"{material.name}, {stiffness}" if material.name else stiffness


def show(
    chapter: Chapter, table: figures.Illustrations, scene: Any, part: str = figures.RESULTS
) -> None:
    """Add the figures of a table that belong to a chapter."""
    for entry in table:
        if entry.chapter == part and entry.when(scene):
            alt, caption = entry.words(scene)
            chapter.add("figure", page.picture(partial(entry.draw, scene), alt, caption))


def prepared(result: ContactResult) -> list[Chapter]:
    """Return the chapters on the maps, their preparation and their roughness."""
    surfaces = [result.surface]
    names = ["map"]
    if result.counter_surface is not None:
        surfaces.append(result.counter_surface)
        names = list(BODIES.values())
    chapter = Chapter("Input and preparation")
    table = inputs.table_of(result.surface)
    facts = [(row.title, *texts) for row, texts in beside(table, surfaces)]
    chapter.add("table", Table(facts, ("", *names) if len(names) > 1 else ()))
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        if surface.provenance.steps:
            chapter.add("text", f"Preparation{of}, in this order:")
            chapter.add("steps", [page.sentence(step) for step in surface.provenance.steps])
        else:
            chapter.add("text", f"Preparation{of}: none recorded; the heights are as given.")
        table_of_figures = traces.MAP if surface.is_profile else figures.MAP
        show(chapter, table_of_figures, figures.MapScene(surface, of), figures.PREPARATION)
    if result.surface.is_profile:
        return [chapter, _profile_roughness(surfaces, names)]
    roughness = Chapter("Roughness of the prepared surface")
    roughness.add(
        "text",
        "Parameters of ISO 25178-2, of the heights as they were pressed; no filter is applied "
        "beyond the preparation above.",
    )
    for surface, name in zip(surfaces, names, strict=True):
        if any(step.method == "with_form" for step in surface.provenance.operations):
            of = f" of the {name}" if len(names) > 1 else ""
            roughness.add(
                "text",
                f"A nominal form was added to the heights{of}: the form is in them, and so in "
                "these parameters. Those of the roughness alone are found without it.",
            )
    roughness.add("table", _roughness_table(surfaces, names))
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        show(roughness, figures.MAP, figures.MapScene(surface, of), figures.ROUGHNESS)
    return [chapter, roughness]


def _profile_roughness(surfaces: Sequence[Surface], names: Sequence[str]) -> Chapter:
    chapter = Chapter("Roughness of the prepared profile")
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        wave = profile.cutoff(surface.size[1])
        rest = (
            f"R without the waves beyond λc = {engineering(wave, 'm')}, the largest of the "
            "standard of which five fit into the profile, by the Gaussian filter of ISO 16610-21."
            if wave
            else "R not determined: five of the smallest λc, 80 µm, do not fit into the profile."
        )
        chapter.add(
            "text",
            f"Parameters of ISO 21920-2{of}: P with all waves of the heights as they were pressed, "
            f"{rest}",
        )
        heads = ("parameter", "P: all waves", "R: without λc", "meaning")
        chapter.add("table", Table(inputs.profile_parameters(surface), heads))
    return chapter


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
            *(inputs.parameter(name, values) for values in columns),
            meaning,
        )
        for name, (_, meaning) in inputs.ROUGHNESS.items()
    ]
    values = tuple(names) if len(names) > 1 else ("value",)
    return Table(rows, ("parameter", *values, "meaning"))


def problem(result: ContactResult, given: Iterable[Row], model: str) -> Chapter:
    """Return the chapter on materials and load.

    Parameters
    ----------
    result : ContactResult
        The contact.
    given : iterable of Row
        What was asked for.
    model : {"ceiling", "volume"}
        What of a material counts.

    Returns
    -------
    Chapter
        Two tables.
    """
    bodies = (result.material, result.counter_material)
    return pressed(bodies, cells(given), inputs.bodies(model, result.pair.is_profile))


def pressed(
    bodies: tuple[Material, Material], given: Sequence[Cells], table: Quantities
) -> Chapter:
    """Return the chapter on two materials and what was asked for, as rows of a page.

    Parameters
    ----------
    bodies : (Material, Material)
        That with the map, and the counter-body.
    given : sequence of tuple of str
        What was asked for.
    table : Table
        What of a material counts, from `inputs.bodies`.

    Returns
    -------
    Chapter
        Two tables.
    """
    chapter = Chapter("Materials and load")
    told = [(row.title, *texts) for row, texts in beside(table, bodies)]
    chapter.add("table", Table(told, ("", "body", "counter-body")))
    chapter.add("table", Table(given))
    return chapter


def cells(rows: Iterable[Row]) -> list[Cells]:
    """Return rows as a page takes them: name, value, meaning."""
    return [(row.title, row.text, row.meaning) for row in rows]


def quantities(rows: Iterable[Row]) -> Table:
    """Return rows as a table of a page."""
    return Table(cells(rows), ("quantity", "value", "meaning"))


def facts(kind: Kind, result: Any) -> tuple[Cells, ...]:
    """Return what is told of a result of many steps as a whole."""
    told = [*kind.rows(result), *kind.rows(result, TRUST)]
    return tuple((row.title, row.text) for row in told)


def headlines(kind: Kind, result: Any, keys: Iterable[str]) -> list[Cells]:
    """Return what a report says first: names, values and remarks."""
    return cells(replace(kind.row(result, key), symbol="") for key in keys)


def stated(result: ContactResult, spots: Spots) -> tuple[assumptions.Statement, ...]:
    """Return what a contact takes for granted."""
    if result.pair.is_profile:
        return assumptions_profile.statements(result, spots)
    return assumptions.statements(result, spots)


def assumed(stated: Iterable[assumptions.Statement], cautions: Sequence[Caution]) -> Chapter:
    """Return the chapter on what is taken for granted, and what puts it in doubt."""
    chapter = Chapter("What is assumed")
    chapter.add(
        "text",
        "The numbers of this report are those of a model. It takes the following for granted; "
        "where one of them does not hold for the part at hand, neither do the numbers.",
    )
    chapter.add("terms", [(item.topic, item.text, item.doubts(cautions)) for item in stated])
    return chapter


def smooth_beside_rough(result: ContactResult) -> list[Chapter]:
    """Return the chapter on Hertz's contact of the nominal bodies; none where none is given."""
    contact = result.smooth
    if contact is None or not smooth.applies(result):
        return []
    chapter = Chapter("Smooth beside rough")
    chapter.add(
        "text",
        "The nominal bodies without their roughness, under the same load, in closed form (Hertz; "
        f"Johnson 1985, chapter 4): {smooth.bodies(contact)}. {smooth.SIZE}",
    )
    told = [(capital(name), *texts) for name, *texts in smooth.rows(result)]
    chapter.add("table", Table(told, ("", *smooth.HEADS[1:])))
    if contact.approach is None:
        chapter.add("text", _NO_APPROACH[contact.shape.kind == LINE])
    chapter.add("text", _VALIDITY)
    for limit in hertzian.limits(result):
        kind = "warning" if limit.severity == "warning" else "text"
        chapter.add(kind, page.sentence(limit.text))
    chapter.add(
        "figure",
        page.picture(
            partial(hertz.beside_hertz, result),
            "Pressure against the distance from the middle of the contact, here and after Hertz.",
            "Pressure here, its mean and its largest value "
            + ("on lines along the cylinder" if contact.shape.kind == LINE
               else "on rings of the shape of Hertz's contact")
            + ", and Hertz's of the smooth bodies.",
        ),
    )  # fmt: skip
    return [chapter]


_NO_APPROACH = {
    True: "Hertz's line contact has no approach of its own here: a line load displaces a "
    "half-space without bound.",
    False: "Hertz's approach is that of a contact alone on its half-space, and not given beside "
    "that of a map which repeats.",
}

_VALIDITY = (
    "Hertz's numbers hold for smooth, elastic bodies whose contact is small beside their radii, "
    "lies within the map and has no neighbors. Roughness spreads the same load over a wider "
    "region of single spots; the approach here counts from the first touch of the highest peak."
)


def contact_spots(result: ContactResult, spots: Spots) -> Chapter:
    """Return the chapter on number, size and load of the spots."""
    what = "segments" if result.pair.is_profile else "spots"
    chapter = Chapter(f"Contact {what}")
    if spots.count == 0:
        chapter.add("text", "The bodies do not touch.")
        return chapter
    if result.pair.is_profile:
        chapter.add("table", Table(of_profile.segments(result, spots), ("", "value", "")))
        return chapter
    chapter.add(
        "text",
        "A spot is a set of touching pixels joined by their edges. Its area decides how it "
        "carries heat and current, how far below it yielding begins, and whether the map resolves "
        "it.",
    )
    chapter.add("table", quantities(rows_of(details.SPOTS, details.Spotted(result, spots))))
    show(chapter, figures.CONTACT, figures.ContactScene(result), figures.SPOTS)
    return chapter


def added(addition: Addition) -> Chapter:
    """Return a chapter that another result adds."""
    chapter = Chapter(addition.title)
    for paragraph in addition.text:
        chapter.add("text", paragraph)
    if addition.facts:
        chapter.add("table", Table(addition.facts))
    if addition.table:
        head, *rows = addition.table
        chapter.add("table", Table(rows, head))
    for caption, figure in addition.figures:
        chapter.add("figure", page.picture(partial(_itself, figure), caption, caption))
    return chapter


def _itself(figure: Figure) -> Figure:
    return figure


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
            "No load was reached, hence there is nothing to repeat; all input is in this report.",
        )
    rows: list[Cells] = [
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
