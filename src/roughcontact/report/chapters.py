"""Chapters that all reports share."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from importlib import metadata
from typing import TYPE_CHECKING, Any, NamedTuple

from roughcontact._version import __version__
from roughcontact.cautions import Caution
from roughcontact.contact.hertz_comparison import limits
from roughcontact.contact.nominal_hertz import LINE
from roughcontact.contact.pair import BODIES
from roughcontact.contact.plausibility import load_bearing_spot_pixels
from roughcontact.contact.result import ContactResult
from roughcontact.contact.share import Slab
from roughcontact.contact.spots import Spots
from roughcontact.elastoplastic import result as depth
from roughcontact.elastoplastic.plastic_body import LayerProfile
from roughcontact.elastoplastic.result import ElastoplasticResult
from roughcontact.errors import InputError
from roughcontact.material.material import Material
from roughcontact.plots.hertz_comparison import versus_hertz
from roughcontact.report import (
    assumptions,
    contact_fields as of_profile,
    figures,
    hertz_comparison as smooth,
    inputs,
    page,
)
from roughcontact.report.fields import (
    TRUST,
    Quantity,
    Row,
    Table,
    Table as Quantities,
    capital,
    rows_of,
    side_by_side,
)
from roughcontact.report.kind import Kind
from roughcontact.report.page import Cells, Chapter, ExtraChapter, PageTable
from roughcontact.surface.roughness import cutoff
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Spots whose share of the load is told.
_LARGEST = 10


class Spotted(NamedTuple):
    """A contact with its spots."""

    result: ContactResult
    spots: Spots


def _share_of_load(result: Spotted, count: int) -> str:
    load = result.spots.load
    return percent(min(float(load[:count].sum()) / float(load.sum()), 1.0))


def _largest_area(result: Spotted) -> str:
    largest = float(result.spots.area[0])
    share = percent(largest / result.result.contact_area)
    return f"{engineering(largest, 'm²')} ({share} of the contact area)"


SPOTS: Table = (
    Quantity("count", "number of spots", of="spots.count"),
    Quantity("mean_area", "mean area", unit="m²", of=lambda s: float(s.spots.area.mean())),
    Quantity(
        "largest_area", "largest area", unit="m²", of=lambda s: float(s.spots.area[0]),
        text=_largest_area,
    ),
    Quantity(
        "largest_load", "load on the largest", unit="N", of=lambda s: float(s.spots.load[0]),
        text=lambda s: f"{engineering(float(s.spots.load[0]), 'N')} "
        f"({_share_of_load(s, 1)} of the load)",
    ),
    Quantity(
        "largest_loads", f"load on the {_LARGEST} largest",
        of=lambda s: float(s.spots.load[:_LARGEST].sum()),
        text=lambda s: f"{_share_of_load(s, _LARGEST)} of the load",
        when=lambda s: s.spots.count > _LARGEST,
    ),
    Quantity(
        "carrying_pixels", "pixels of a load-carrying spot",
        meaning="spots of at least this size carry half of the load",
        of=lambda s: load_bearing_spot_pixels(s.result, s.spots),
    ),
)  # fmt: skip
"""Of the contact spots, `Spotted`."""


class Yielding:
    """One body that yields, and what its layers hold at most."""

    def __init__(self, result: ElastoplasticResult, number: int) -> None:
        self.result = result
        self.number = number
        self.body = result.bodies[number]

    @cached_property
    def layers(self) -> LayerProfile:
        """Largest values of each layer."""
        return depth.layers(self.result, self.number)

    @property
    def loaded(self) -> bool:
        """Whether there is a load in the end."""
        return bool(self.result.solution.load)


def _place(result: Yielding) -> str:
    layer, row, column = depth.most_strained(result.result, result.number)
    dy, dx = result.result.solution.surface.pixel
    deep = engineering(float(result.body.depth[layer]), "m")
    y, x = (engineering(place, "m") for place in ((row + 0.5) * dy, (column + 0.5) * dx))
    return f"{deep} deep, at y, x = {y}, {x}"


def _deepest(result: Yielding, name: str) -> str:
    values = getattr(result.layers, name)
    deep = float(result.body.depth[int(values.argmax())])
    return f"{engineering(float(values.max()), 'Pa')}, {engineering(deep, 'm')} deep"


def _layers(result: Yielding) -> str:
    thickness = result.body.thickness
    return f"{thickness.size}, {engineering(float(thickness.sum()), 'm')} deep in all"


YIELDING: Table = (
    Quantity(
        "max_plastic_strain", "largest accumulated plastic strain", of="body.max_plastic_strain",
        text=lambda b: f"{percent(b.body.max_plastic_strain)}, {_place(b)}",
        when=lambda b: bool(b.body.plastic_volume),
    ),
    Quantity(
        "max_von_mises", "largest stress", unit="Pa", of="body.max_von_mises",
        text=lambda b: f"{engineering(b.body.max_von_mises, 'Pa')}, {_place(b)}",
        when=lambda b: not b.body.plastic_volume,
    ),
    Quantity(
        "plastic_depth", "plastic depth", unit="m", of="body.plastic_depth",
        meaning="lower face of the lowest layer with plastic strain",
    ),
    Quantity(
        "plastic_volume", "plastic volume", unit="m³", of="body.plastic_volume",
        meaning="with any plastic strain",
    ),
    Quantity(
        "max_residual_stress", "largest residual von Mises stress", unit="Pa",
        of=lambda b: float(b.layers.max_residual_von_mises.max()),
        text=lambda b: _deepest(b, "max_residual_von_mises"),
    ),
    Quantity(
        "max_stress_under_load", "largest von Mises stress under load", unit="Pa",
        of=lambda b: float(b.layers.max_von_mises.max()),
        text=lambda b: _deepest(b, "max_von_mises"), when=lambda b: b.loaded,
    ),
    Quantity("layers", "layers", of=lambda b: b.body.thickness.size, text=_layers),
)  # fmt: skip
"""Of one body of the volume model, `Yielding`."""


# --- Chapters that all reports share ---


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
    facts = [(row.title, *texts) for row, texts in side_by_side(table, surfaces)]
    chapter.add("table", PageTable(facts, ("", *names) if len(names) > 1 else ()))
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        if surface.provenance.steps:
            chapter.add("text", f"Preparation{of}, in this order:")
            chapter.add("steps", [page.sentence(step) for step in surface.provenance.steps])
        else:
            chapter.add("text", f"Preparation{of}: none recorded; the heights are as given.")
        table_of_figures = figures.PROFILE_MAP if surface.is_profile else figures.MAP
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
        wave = cutoff(surface.size[1])
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
        chapter.add("table", PageTable(inputs.profile_parameters(surface), heads))
    return chapter


def _roughness_table(surfaces: Sequence[Surface], names: Sequence[str]) -> PageTable:
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
    return PageTable(rows, ("parameter", *values, "meaning"))


def problem(result: ContactResult, specified: Iterable[Row], model: str) -> Chapter:
    """Return the chapter on materials and load."""
    bodies = (result.material, result.counter_material)
    return pressed(bodies, cells(specified), inputs.bodies(model, result.pair.is_profile))


def pressed(
    bodies: tuple[Material, Material], specified: Sequence[Cells], table: Quantities
) -> Chapter:
    """Return the chapter on two materials and what was asked for, as rows of a page."""
    chapter = Chapter("Materials and load")
    rows = [(row.title, *texts) for row, texts in side_by_side(table, bodies)]
    chapter.add("table", PageTable(rows, ("", "body", "counter-body")))
    chapter.add("table", PageTable(specified))
    return chapter


def cells(rows: Iterable[Row]) -> list[Cells]:
    """Return rows as a page takes them: name, value, meaning."""
    return [(row.title, row.text, row.meaning) for row in rows]


def quantities(rows: Iterable[Row]) -> PageTable:
    """Return rows as a table of a page."""
    return PageTable(cells(rows), ("quantity", "value", "meaning"))


def facts(kind: Kind, result: Any) -> tuple[Cells, ...]:
    """Return what is told of a result of many steps as a whole."""
    rows = [*kind.rows(result), *kind.rows(result, TRUST)]
    return tuple((row.title, row.text) for row in rows)


def headlines(kind: Kind, result: Any, keys: Iterable[str]) -> list[Cells]:
    """Return what a report says first: names, values and remarks."""
    return cells(replace(kind.row(result, key), symbol="") for key in keys)


def stated(result: ContactResult, spots: Spots) -> tuple[assumptions.Statement, ...]:
    """Return what a contact takes for granted."""
    if result.pair.is_profile:
        return assumptions.profile_statements(result, spots)
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
    contact = result.hertz
    if contact is None or not smooth.applies(result):
        return []
    chapter = Chapter("Smooth beside rough")
    chapter.add(
        "text",
        "The nominal bodies without their roughness, under the same load, in closed form (Hertz; "
        f"Johnson 1985, chapter 4): {smooth.bodies(contact)}. {smooth.SIZE}",
    )
    rows = [(capital(name), *texts) for name, *texts in smooth.rows(result)]
    chapter.add("table", PageTable(rows, ("", *smooth.HEADS[1:])))
    if contact.approach is None:
        chapter.add("text", _NO_APPROACH[contact.shape.kind == LINE])
    chapter.add("text", _VALIDITY)
    for limit in limits(result):
        kind = "warning" if limit.severity == "warning" else "text"
        chapter.add(kind, page.sentence(limit.text))
    chapter.add(
        "figure",
        page.picture(
            partial(versus_hertz, result),
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
        chapter.add("table", PageTable(of_profile.segments(result, spots), ("", "value", "")))
        return chapter
    chapter.add(
        "text",
        "A spot is a set of touching pixels joined by their edges. Its area decides how it "
        "carries heat and current, how far below it yielding begins, and whether the map resolves "
        "it.",
    )
    chapter.add("table", quantities(rows_of(SPOTS, Spotted(result, spots))))
    show(chapter, figures.CONTACT, figures.ContactScene(result), figures.SPOTS)
    return chapter


def added(addition: ExtraChapter) -> Chapter:
    """Return a chapter that another result adds."""
    chapter = Chapter(addition.title)
    for paragraph in addition.text:
        chapter.add("text", paragraph)
    if addition.facts:
        chapter.add("table", PageTable(addition.facts))
    if addition.table:
        head, *rows = addition.table
        chapter.add("table", PageTable(rows, head))
    for caption, figure in addition.figures:
        chapter.add("figure", page.picture(partial(_itself, figure), caption, caption))
    return chapter


def _itself(figure: Figure) -> Figure:
    return figure


def repetition(version: str, command: str, lines: str) -> Chapter:
    """Return the chapter on how to get the same result again."""
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
    chapter.add("table", PageTable(rows))
    return chapter


def _installed(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
