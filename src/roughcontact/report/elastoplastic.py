"""What is shown of an elastoplastic contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from roughcontact.elastoplastic import plausibility
from roughcontact.elastoplastic.result import ElastoplasticResult
from roughcontact.formats import export
from roughcontact.plots import elastoplastic as plots
from roughcontact.report import (
    assumptions,
    blocks,
    chapters,
    citations,
    contact_fields,
    figures,
    inputs,
    phrases,
    python_script,
    regimes,
)
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.fields import PROBLEM, Row, rows_of
from roughcontact.report.kind import Kind
from roughcontact.report.page import Block
from roughcontact.units import engineering


def question(result: ElastoplasticResult) -> str:
    """Return the question that an elastoplastic contact answers."""
    contact = result.solution
    name = phrases.source(contact.surface.provenance)
    if contact.load:
        return f"How deep does {name} yield {phrases.under(contact)}?"
    if not result.increments:
        return f"How deep does {name} yield?"
    largest = engineering(contact_fields.largest_load(result), "N")
    return f"What does a load of {largest} leave on {name}?"


def headlines(result: ElastoplasticResult) -> tuple[str, ...]:
    """Return the keys of the key numbers."""
    if result.solution.load:
        return contact_fields.VOLUME_HEADLINES
    return contact_fields.RELEASED_HEADLINES


def inputs_of(result: ElastoplasticResult, specified: Sequence[Row]) -> list[Block]:
    """Return the blocks on what went into an elastoplastic contact."""
    contact = result.solution
    return [
        *chapters.maps(contact),
        *chapters.bodies(
            (contact.material, contact.counter_material), specified, inputs.bodies("volume")
        ),
    ]


def _inputs(result: ElastoplasticResult) -> list[Block]:
    return inputs_of(result, rows_of(contact_fields.VOLUME, result, PROBLEM))


def _details(result: ElastoplasticResult, scene: Any, **more: Any) -> list[Block]:
    blocks = []
    for number in range(len(result.bodies)):
        body = figures.VolumeScene(result, number)
        if len(result.bodies) > 1:
            blocks.append(Block("head", f"Plastic strain and stress{body.where}"))
        blocks += chapters.quantities(rows_of(chapters.YIELDING, chapters.Yielding(result, number)))
        # That of the first is on the first page.
        blocks += chapters.shown((figures.SECTION,) if number else (), body, figures.FRONT)
        blocks += chapters.shown(figures.VOLUME, body.close(), figures.BODY)
    contact = result.solution
    if contact.spots().count:
        blocks += [*chapters.table(chapters.spots(contact)), *chapters.with_hertz(contact)]
    return blocks


def method(result: ElastoplasticResult) -> list[Block]:
    """Return the blocks on how an elastoplastic contact is solved."""
    texts = (
        "Plastic strain follows from J2 plasticity with radial return, layer by layer. It is "
        "iterated with the contact until both agree. Each increment starts from the one before; "
        "those that did not settle were halved.",
        "Residual: largest change of the plastic strain in the last iteration of an increment, "
        "over its largest strain or the yield strain σ_Y/(2μ). Yield excess: von Mises stress over "
        "yield strength, less one, computed again from strain and pressure. Certificate of the "
        f"contact: ε = ‖p − max(p − g/K₀₀, 0)‖ / ‖p‖. {chapters.RIGHT_PROBLEM}",
    )
    return [Block("text", text) for text in texts]


def shown(result: ElastoplasticResult) -> Blocks:
    """Return what the console shows: problem, answer and trust, then cautions."""
    problem = blocks.problem(KIND, result, result.solution)
    answer = blocks.cells(KIND.rows(result, brief=True))
    return [*blocks.table(problem, answer, blocks.trust(KIND, result)), Cautions(result.cautions)]


KIND = Kind(
    ElastoplasticResult, contact_fields.VOLUME, contact_fields.INCREMENTS, figures=figures.VOLUME,
    scene=figures.VolumeScene,
    plots=(
        plots.section, plots.profile, plots.layers, plots.path, plots.residual_displacement,
        plots.convergence,
    ),
    works=citations.of_volume, save=export.save_volume, blocks=shown,
    question=question, headlines=headlines, meaning=regimes.volume_regime,
    inputs=_inputs, details=_details,
    case=assumptions.of_volume, method=method, checked=plausibility.checked,
    script=python_script.repeating_volume,
)  # fmt: skip
