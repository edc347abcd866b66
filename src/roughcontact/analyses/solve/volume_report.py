"""Report of an elastoplastic contact."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.analyses.solve.blocks import hertz_blocks, spot_rows
from roughcontact.drawing import elastoplastic as plots
from roughcontact.elastoplastic import archive, plausibility, volume_result as depth
from roughcontact.elastoplastic.plastic_body import LayerProfile
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.formats import export
from roughcontact.report import (
    assumptions,
    chapters,
    citations,
    figures,
    inputs,
    phrases,
    python_script,
)
from roughcontact.report.kind import PROBLEM, CellTable, Presentation, Quantity, Row, Table, rows_of
from roughcontact.report.page import Block
from roughcontact.units import count_noun, format_engineering, format_percent, order_of_magnitude


def question(result: ElastoplasticResult) -> str:
    """Return the question that an elastoplastic contact answers."""
    contact = result.solution
    name = phrases.source(contact.surface.provenance)
    if contact.load:
        return f"How deep does {name} yield {phrases.load_phrase(contact)}?"
    if not result.increments:
        return f"How deep does {name} yield?"
    largest = format_engineering(contact_fields.largest_load(result), "N")
    return f"Which indentation does a load of {largest} leave on {name}?"


def inputs_of(result: ElastoplasticResult, specified: Sequence[Row], drawn: bool) -> list[Block]:
    """Return the blocks on the inputs of an elastoplastic contact."""
    contact = result.solution
    return [
        *chapters.map_blocks(contact, drawn),
        *chapters.body_blocks(
            (contact.material, contact.counter_material), specified, inputs.bodies("volume")
        ),
    ]


def _inputs(result: ElastoplasticResult, drawn: bool) -> list[Block]:
    return inputs_of(result, rows_of(contact_fields.VOLUME, result, PROBLEM), drawn)


def _details(result: ElastoplasticResult, scene: Any, **more: Any) -> list[Block]:
    blocks = []
    for number in range(len(result.bodies)):
        body = figures.VolumeScene(result, number)
        if len(result.bodies) > 1:
            blocks.append(Block("head", f"Plastic strain and stress{body.where}"))
        blocks += chapters.quantities(rows_of(YIELDING, Yielding(result, number)))
        # The section of the first body is on the first page.
        if scene is not None:
            blocks += chapters.figure_blocks(
                (figures.SECTION,) if number else (), body, figures.FRONT
            )
            blocks += chapters.figure_blocks(figures.VOLUME, body.close(), figures.BODY)
    contact = result.solution
    if contact.spots().count:
        blocks += [*chapters.table(spot_rows(contact)), *hertz_blocks(contact)]
    return blocks


def method(result: ElastoplasticResult) -> list[Block]:
    """Return the blocks on the method of the volume model."""
    texts = (
        "Plastic strain follows from J2 plasticity with radial return, layer by layer. It is "
        "iterated with the contact until both agree. Each increment starts from the one before; "
        "increments that did not converge were halved.",
        "Residual: largest change of the plastic strain in the last iteration of an increment, "
        "over its largest strain or the yield strain σ_Y/(2μ). Yield excess: von Mises stress over "
        "yield strength, less one, computed again from strain and pressure. Certificate of the "
        f"contact: ε = ‖p − max(p − g/K₀₀, 0)‖ / ‖p‖. {chapters.RIGHT_PROBLEM}",
    )
    return [Block("text", text) for text in texts]


# --- Headline ---


def _answer(result: ElastoplasticResult) -> str:
    """Return contact area or residual indentation, and plastic depth, as a sentence."""
    if not result.converged:
        return "No solution: the numbers are those of the last load that was reached."
    depth = f"plastic strain reaches {phrases.format_short(result.plastic_depth, 'm')} deep"
    if not result.plastic_volume:
        depth = "nothing yields"
    if not result.solution.load:
        dent = phrases.format_short(float(result.residual_displacement.max()), "m")
        return f"Unloaded: an indentation of {dent} remains; {depth}."
    return (
        f"{phrases.format_share(result.solution.contact_fraction)} of the face is in contact; "
        f"{depth}."
    )


def _numbers(result: ElastoplasticResult) -> CellTable:
    """Return the main quantities of an elastoplastic contact."""
    contact, rows = result.solution, []
    if contact.load:
        area, mean = contact.contact_area, contact.load / contact.contact_area
        whole = phrases.format_short(contact.nominal_area, "m²")
        rows = [
            ("Real contact area", f"{phrases.format_short(area, 'm²')} of {whole}"),
            (
                "Contact pressure",
                f"{phrases.format_short(mean, 'Pa')} mean; "
                f"{phrases.format_short(contact.max_pressure, 'Pa')} peak",
            ),
            ("Approach", f"{phrases.format_short(contact.approach, 'm')} from first contact"),
        ]
    strain = format_percent(result.max_plastic_strain)
    volume = KIND.row(result, "plastic_volume").text
    return (), [
        *rows,
        ("Plastic depth", phrases.format_short(result.plastic_depth, "m")),
        ("Plastic strain", f"{strain} at most, in {volume}"),
        ("Residual displacement", KIND.row(result, "max_residual_displacement").text),
    ]


def _remarks(result: ElastoplasticResult) -> tuple[str, ...]:
    """Return the error of the load steps, and the accuracy of the solution."""
    status = (
        f"Solved: residual {order_of_magnitude(result.residual)} (limit {result.tolerance:.0e}), "
        f"{count_noun(len(result.increments), 'increment')}"
        if result.converged
        else f"Not converged: {result.status}. Do not use these numbers."
    )
    return f"Load steps: {phrases.step_error(result)}", status


KIND = Presentation(
    ElastoplasticResult,
    contact_fields.VOLUME,
    contact_fields.INCREMENTS,
    figures=figures.VOLUME,
    scene=figures.VolumeScene,
    plots=(
        plots.section,
        plots.profile,
        plots.layers,
        plots.path,
        plots.residual_displacement,
        plots.convergence,
    ),
    works=citations.volume_references,
    save=export.VOLUME.write,
    dataset=lambda result: archive.to_dataset(result)[0],
    problem=lambda result: phrases.problem(result.solution),
    answer=_answer,
    numbers=_numbers,
    remarks=_remarks,
    question=question,
    meaning=phrases.volume_regime,
    inputs=_inputs,
    details=_details,
    case=assumptions.volume_case,
    method=method,
    checked=plausibility.performed_checks,
    script=python_script.repeating_volume,
)


class Yielding:
    """Yielding body of an elastoplastic contact, with the largest values of its layers."""

    def __init__(self, result: ElastoplasticResult, number: int) -> None:
        self.result = result
        self.number = number
        self.body = result.bodies[number]

    @cached_property
    def layers(self) -> LayerProfile:
        """Largest values of each layer."""
        return self.result.layers(self.number)

    @property
    def loaded(self) -> bool:
        """Whether the final state is under load."""
        return bool(self.result.solution.load)


def _place(result: Yielding) -> str:
    layer, row, column = depth.most_strained(result.result, result.number)
    dy, dx = result.result.solution.surface.pixel
    deep = format_engineering(float(result.body.depth[layer]), "m")
    y, x = (format_engineering(place, "m") for place in ((row + 0.5) * dy, (column + 0.5) * dx))
    return f"{deep} deep, at y, x = {y}, {x}"


def _deepest(result: Yielding, name: str) -> str:
    values = getattr(result.layers, name)
    deep = float(result.body.depth[int(values.argmax())])
    return f"{format_engineering(float(values.max()), 'Pa')}, {format_engineering(deep, 'm')} deep"


def _layers(result: Yielding) -> str:
    thickness = result.body.thickness
    return f"{thickness.size}, {format_engineering(float(thickness.sum()), 'm')} deep in all"


YIELDING: Table = (
    Quantity(
        "max_plastic_strain",
        "largest accumulated plastic strain",
        of="body.max_plastic_strain",
        text=lambda b: f"{format_percent(b.body.max_plastic_strain)}, {_place(b)}",
        when=lambda b: bool(b.body.plastic_volume),
    ),
    Quantity(
        "max_von_mises",
        "largest stress",
        unit="Pa",
        of="body.max_von_mises",
        text=lambda b: f"{format_engineering(b.body.max_von_mises, 'Pa')}, {_place(b)}",
        when=lambda b: not b.body.plastic_volume,
    ),
    Quantity(
        "plastic_depth",
        "plastic depth",
        unit="m",
        of="body.plastic_depth",
        meaning="lower face of the lowest layer with plastic strain",
    ),
    Quantity(
        "plastic_volume",
        "plastic volume",
        unit="m³",
        of="body.plastic_volume",
        meaning="with any plastic strain",
    ),
    Quantity(
        "max_residual_stress",
        "largest residual von Mises stress",
        unit="Pa",
        of=lambda b: float(b.layers.max_residual_von_mises.max()),
        text=lambda b: _deepest(b, "max_residual_von_mises"),
    ),
    Quantity(
        "max_stress_under_load",
        "largest von Mises stress under load",
        unit="Pa",
        of=lambda b: float(b.layers.max_von_mises.max()),
        text=lambda b: _deepest(b, "max_von_mises"),
        when=lambda b: b.loaded,
    ),
    Quantity("layers", "layers", of=lambda b: b.body.thickness.size, text=_layers),
)
"""Quantities of one yielding body, `Yielding`."""
