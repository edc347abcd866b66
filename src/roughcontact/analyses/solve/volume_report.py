"""Report of an elastoplastic contact."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cached_property

from roughcontact._tools.netcdf import Dataset
from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.analyses.solve.report import hertz_blocks, spot_rows
from roughcontact.drawing import elastoplastic as plots
from roughcontact.elastoplastic import archive, plausibility, volume_result as depth
from roughcontact.elastoplastic.volume_result import ElastoplasticResult, LayerProfile
from roughcontact.formats import export
from roughcontact.report import assumptions, chapters, citations, figures, phrases, python_script
from roughcontact.report.figures import VolumeScene
from roughcontact.report.kind import PROBLEM, CellTable, Quantity, Use, rows_of
from roughcontact.report.page import Block
from roughcontact.report.phrases import format_share, format_short
from roughcontact.report.presentation import Presentation
from roughcontact.units import count_noun, format_engineering, format_percent, order_of_magnitude


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
    return f"{deep} deep, {phrases.place(((row + 0.5) * dy, (column + 0.5) * dx))}"


def _deepest(result: Yielding, name: str) -> str:
    values = getattr(result.layers, name)
    deep = float(result.body.depth[int(values.argmax())])
    return f"{format_engineering(float(values.max()), 'Pa')}, {format_engineering(deep, 'm')} deep"


def _layers(result: Yielding) -> str:
    thickness = result.body.thickness
    return f"{thickness.size}, {format_engineering(float(thickness.sum()), 'm')} deep in all"


YIELDING = (
    Quantity(
        "max_plastic_strain",
        "largest accumulated plastic strain",
        of="body.max_plastic_strain",
        text=lambda b: f"{format_percent(b.body.max_plastic_strain)}, {_place(b)}",
        when=lambda b: bool(b.body.plastic_volume),
    ),
    Quantity(
        "max_von_mises",
        "largest stress [Pa]",
        of="body.max_von_mises",
        text=lambda b: f"{format_engineering(b.body.max_von_mises, 'Pa')}, {_place(b)}",
        when=lambda b: not b.body.plastic_volume,
    ),
    Quantity(
        "plastic_depth",
        "plastic depth [m]: lower face of the lowest layer with plastic strain",
        of="body.plastic_depth",
    ),
    Quantity(
        "plastic_volume", "plastic volume [m³]: with any plastic strain", of="body.plastic_volume"
    ),
    Quantity(
        "max_residual_stress",
        "largest residual von Mises stress [Pa]",
        of=lambda b: float(b.layers.max_residual_von_mises.max()),
        text=lambda b: _deepest(b, "max_residual_von_mises"),
    ),
    Quantity(
        "max_stress_under_load",
        "largest von Mises stress under load [Pa]",
        of=lambda b: float(b.layers.max_von_mises.max()),
        text=lambda b: _deepest(b, "max_von_mises"),
        when=lambda b: b.loaded,
    ),
    Quantity("layers", "layers", of=lambda b: b.body.thickness.size, text=_layers),
)
"""Quantities of one yielding body, `Yielding`."""


class VolumePresentation(Presentation):
    """Presentation of an elastoplastic contact."""

    result: ElastoplasticResult
    table = contact_fields.VOLUME
    columns = contact_fields.INCREMENTS
    figures = figures.VOLUME
    plots = (
        plots.section,
        plots.profile,
        plots.layers,
        plots.path,
        plots.residual_displacement,
        plots.convergence,
    )

    @property
    def scene(self) -> VolumeScene:
        """Scene of the first body."""
        return VolumeScene(self.result)

    def question(self) -> str:
        """Return the question that an elastoplastic contact answers."""
        result = self.result
        contact = result.solution
        name = phrases.source(contact.surface.provenance)
        if contact.load:
            return f"How deep does {name} yield {phrases.load_phrase(contact)}?"
        if not result.increments:
            return f"How deep does {name} yield?"
        largest = format_engineering(contact_fields.largest_load(result), "N")
        return f"Which indentation does a load of {largest} leave on {name}?"

    def answer(self) -> str:
        """Return contact area or residual indentation, and plastic depth, as a sentence."""
        result = self.result
        if not result.converged:
            return "No solution: the numbers are those of the last load that was reached."
        depth = f"plastic strain reaches {format_short(result.plastic_depth, 'm')} deep"
        if not result.plastic_volume:
            depth = "nothing yields"
        if not result.solution.load:
            dent = format_short(float(result.residual_displacement.max()), "m")
            return f"Unloaded: an indentation of {dent} remains; {depth}."
        return (
            f"{format_share(result.solution.contact_fraction)} of the face is in contact; {depth}."
        )

    def numbers(self) -> CellTable:
        """Return the main quantities of an elastoplastic contact."""
        result = self.result
        contact, rows = result.solution, []
        if contact.load:
            area, mean = contact.contact_area, contact.load / contact.contact_area
            whole = format_short(contact.nominal_area, "m²")
            rows = [
                ("Real contact area", f"{format_short(area, 'm²')} of {whole}"),
                (
                    "Contact pressure",
                    f"{format_short(mean, 'Pa')} mean; "
                    f"{format_short(contact.max_pressure, 'Pa')} peak",
                ),
                ("Approach", f"{format_short(contact.approach, 'm')} from first contact"),
            ]
        strain = format_percent(result.max_plastic_strain)
        volume = self.row("plastic_volume").text
        return (), [
            *rows,
            ("Plastic depth", format_short(result.plastic_depth, "m")),
            ("Plastic strain", f"{strain} at most, in {volume}"),
            ("Residual displacement", self.row("max_residual_displacement").text),
        ]

    def remarks(self) -> tuple[str, ...]:
        """Return the error of the load steps, and the accuracy of the solution."""
        result = self.result
        status = (
            f"Solved: residual {order_of_magnitude(result.residual)} (limit "
            f"{result.tolerance:.0e}), {count_noun(len(result.increments), 'increment')}"
            if result.converged
            else f"Not converged: {result.status}. Do not use these numbers."
        )
        return f"Load steps: {phrases.step_error(result)}", status

    def inputs(self) -> list[Block]:
        """Return the blocks on maps, bodies and load."""
        return chapters.input_blocks(
            self.result.solution, self.rows(PROBLEM), "volume", self.is_drawn
        )

    def details(self) -> list[Block]:
        """Return further blocks of results."""
        result = self.result
        blocks = []
        for number in range(len(result.bodies)):
            body = VolumeScene(result, number)
            if len(result.bodies) > 1:
                blocks.append(Block("head", f"Plastic strain and stress{body.where}"))
            blocks += chapters.quantities(rows_of(YIELDING, Yielding(result, number)))
            # The section of the first body is on the first page.
            if self.is_drawn:
                blocks += chapters.figure_blocks(
                    (figures.SECTION,) if number else (), body, figures.FRONT
                )
                blocks += chapters.figure_blocks(figures.VOLUME, body.close(), figures.BODY)
        contact = result.solution
        if contact.spots().count:
            blocks += [*chapters.table(spot_rows(contact)), *hertz_blocks(contact)]
        return blocks

    def problem(self) -> str:
        """Return the bodies and the load."""
        return phrases.problem(self.result.solution)

    def meaning(self) -> str:
        """Return the regime."""
        return phrases.volume_regime(self.result)

    def case(self) -> assumptions.Case:
        """Return the case of the volume model."""
        return assumptions.contact_case(self.result.solution, volume=self.result)

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the method of the volume model."""
        yield (
            "Plastic strain follows from J2 plasticity with radial return, layer by layer. It is "
            "iterated with the contact until both agree. Each increment starts from the one "
            "before; increments that did not converge were halved."
        )
        yield (
            "Residual: largest change of the plastic strain in the last iteration of an increment, "
            "over its largest strain or the yield strain σ_Y/(3μ). Yield excess: von Mises stress "
            "over yield strength, less one, computed again from strain and pressure. Certificate "
            f"of the contact: ε = ‖p − max(p − g/K₀₀, 0)‖ / ‖p‖. {chapters.RIGHT_PROBLEM}"
        )

    def checks(self) -> tuple[str, ...]:
        """Return the performed checks."""
        return plausibility.performed_checks(self.result)

    def script(self) -> tuple[str, str]:
        """Return a script that repeats the path of loads."""
        return python_script.repeating_volume(self.result), "the same problem"

    def works(self) -> Iterator[Use]:
        """Yield the works on contact and plasticity."""
        return citations.volume_references(self.result)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write fields and quantities; the suffix selects the format."""
        export.VOLUME.write(self.result, path)

    def dataset(self) -> Dataset:
        """Return fields and quantities."""
        return archive.to_dataset(self.result)[0]
