"""Chapters that all reports share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from importlib import metadata
from typing import Any

from roughcontact._version import __version__
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.material.material import Material
from roughcontact.report import figures, inputs
from roughcontact.report.kind import Cells, Row, side_by_side
from roughcontact.report.page import Block, PageTable, Picture
from roughcontact.surface.surface import Surface


def cells(rows: Iterable[Row]) -> list[Cells]:
    """Return rows as cells of a page: name, value, meaning."""
    return [(row.title, row.text, row.meaning) for row in rows]


def table(rows: Sequence[Cells], head: Cells = (), style: str = "") -> list[Block]:
    """Return the block of a table; empty without rows."""
    return [Block("table", PageTable(rows, head, style))] if rows else []


def quantities(rows: Iterable[Row]) -> list[Block]:
    """Return the block of rows with their meaning."""
    entries = cells(rows)
    if not any(meaning for _, _, meaning in entries):
        return table([(name, text) for name, text, _ in entries], style="key")
    return table(entries, ("quantity", "value", "meaning"), "wide")


def evenly_spaced(rows: Sequence[Cells], count: int) -> list[Cells]:
    """Return at most ``count`` rows, evenly spaced, with the first and the last."""
    if len(rows) <= count:
        return list(rows)
    return [rows[round(index * (len(rows) - 1) / (count - 1))] for index in range(count)]


def figure_blocks(
    table: figures.Illustrations, scene: Any, chapter: str = figures.RESULTS
) -> list[Block]:
    """Return the blocks of the figures of a chapter; none without a scene."""
    return [
        Block("figure", Picture(partial(entry.draw, scene), entry.text(scene), entry.width))
        for entry in table
        if scene is not None and entry.chapter == chapter and entry.when(scene)
    ]


def map_blocks(result: ContactResult, drawn: bool = True) -> list[Block]:
    """Return the blocks on maps and preparation; ``drawn``: with figures and parameters."""
    names = ["map", "counter-body"]
    surfaces: list[Any] = [result.surface]
    if result.counter_surface is not None:
        surfaces.append(result.counter_surface)
    facts = side_by_side(inputs.table_of(result.surface), surfaces)
    rows: list[Cells] = [(row.title, *texts) for row, texts in facts]
    prepared = ("; ".join(map(str, s.provenance.steps)) or "none recorded" for s in surfaces)
    rows.append(("Preparation", *prepared))
    head = ("", *names) if len(surfaces) > 1 else ()
    style = "" if len(surfaces) > 1 else "key"
    if not drawn:
        return table(rows, head, style)
    blocks = []
    measured = [s for s in surfaces if not _is_nominal(s)]
    if not measured or result.pair.is_profile:
        blocks += table(rows, head, style)
    for surface in measured:
        of = " of the counter-body" if surface is result.counter_surface else ""
        entry = figures.PROFILE_MAP if surface.is_profile else figures.MAP
        (block,) = figure_blocks((entry,), figures.MapScene(surface, of), figures.FILES)
        if surface is measured[0] and not surface.is_profile:
            block = Block("aside", (block.content, [PageTable(rows, head, style)]))
        blocks.append(block)
    for surface in measured:
        blocks += _roughness(surface, surface is result.counter_surface)
    return blocks


def _is_nominal(surface: Surface) -> bool:
    # After a move, only the source still identifies a nominal body.
    return surface.provenance.source.startswith("nominal ")


def _roughness(surface: Surface, is_second: bool) -> list[Block]:
    """Return the parameters of a map or profile, names above values."""
    norm = "ISO 21920-2" if surface.is_profile else "ISO 25178-2"
    blocks = [Block("head", f"Roughness{' of the counter-body' if is_second else ''} ({norm})")]
    if surface.is_profile:
        heads, primary, filtered, _ = zip(*inputs.profile_parameters(surface), strict=True)
        rows = [("P", *primary), ("R", *filtered)]
        return blocks + table(rows, ("", *(head.split(",")[0][1:] for head in heads)))
    try:
        values = surface.roughness()
    except InputError:
        # Too many holes: no point has both neighbors.
        values = {}
    for head in _PARAMETERS:
        blocks += table([tuple(inputs.parameter(name, values) for name in head)], head)
    if any(step.method == "with_form" for step in surface.provenance.operations):
        blocks.append(Block("small", "These parameters include the added nominal form."))
    return blocks


_PARAMETERS: tuple[Cells, ...] = (
    ("Sq", "Sa", "Sz", "Ssk", "Sku", "Sdq"),
    ("Sal", "Str", "Sk", "Spk", "Svk", "Smr1"),
)


def body_blocks(
    pair: tuple[Material, Material], specified: Iterable[Row], model: str
) -> list[Block]:
    """Return the blocks on two materials, the sources of their values, and the problem."""
    both = side_by_side(inputs.bodies(model), pair, brief=True)
    rows = [(row.title, *texts) for row, texts in both]
    sources = "; ".join(inputs.sources(pair))
    return [
        Block("head", "Bodies and load"),
        *table(rows, ("property", "body", "counter-body")),
        *([Block("small", f"Sources: {sources}.")] if sources else []),
        *table([(name, text) for name, text, _ in cells(specified)], style="key"),
    ]


def input_blocks(
    contact: ContactResult, specified: Iterable[Row], model: str, drawn: bool
) -> list[Block]:
    """Return the blocks on maps, bodies and load of a contact; see `inputs.bodies`."""
    bodies = contact.material, contact.counter_material
    return [*map_blocks(contact, drawn), *body_blocks(bodies, specified, model)]


RIGHT_PROBLEM = "It verifies the solution of this model; sections 3 and 4 cover the model itself."
"""Scope of a certificate."""

_LIBRARIES = ("numpy", "scipy", "ducc0", "matplotlib")


def certificate(result: ContactResult) -> Iterator[str]:
    """Yield the paragraphs on the method of a contact and its certificate."""
    kernel = "plane strain" if result.pair.is_profile else f"the {result.boundary} half-space"
    below = "" if result.ceiling is None else " and at most the ceiling"
    yield (
        "The pressure minimizes the elastic energy of two half-spaces without overlap; it is "
        f"nowhere negative{below}. The displacement is an FFT convolution with the kernel of "
        f"{kernel}."
    )
    yield (
        "Certificate: ε = ‖p − clip(p − g/K₀₀, 0, p_lim)‖ / ‖p‖, with pressure p, ceiling p_lim, "
        "and a gap g computed again from p; K₀₀ is the displacement of a pixel under unit "
        "pressure. Zero means: no overlap without pressure, no pressure across a gap, yielding "
        f"only at the ceiling. {RIGHT_PROBLEM}"
    )


def script_blocks(version: str, command: str, script: str, what: str) -> list[Block]:
    """Return the blocks on how to reproduce a result."""
    blocks = [Block("code", command)] if command else []
    if not command and script:
        blocks = [Block("text", f"This script solves {what}:"), Block("code", script)]
    versions = ", ".join(f"{name} {_installed_version(name)}" for name in _LIBRARIES)
    solved = f"roughcontact {version or __version__}"
    return [*blocks, Block("small", f"{solved}, {versions}. The same input gives the same digits.")]


def _installed_version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
