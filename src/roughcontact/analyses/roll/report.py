"""Report of repeated passes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact._tools.netcdf import Dataset
from roughcontact._version import __version__
from roughcontact.analyses.roll import figures as plots
from roughcontact.analyses.roll.formats import ROLLING_FORMATS
from roughcontact.analyses.roll.model import RollingResult, Shakedown, to_dataset
from roughcontact.analyses.solve import volume_report
from roughcontact.elastoplastic import plausibility
from roughcontact.formats import export
from roughcontact.references import make_use
from roughcontact.report import assumptions, chapters, citations, figures, phrases
from roughcontact.report.figures import FILES, FRONT, RESULTS, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    PROBLEM,
    Column,
    Columns,
    Quantity,
    Use,
    stored_columns,
)
from roughcontact.report.page import WIDE, Block
from roughcontact.report.presentation import Presentation
from roughcontact.units import count_noun, format_engineering, order_of_magnitude


def _passes(rolling: RollingResult) -> str:
    """Return the number of passes as text."""
    return count_noun(len(rolling.passes), "pass")


def _way(rolling: RollingResult) -> str:
    steps = max(item.steps for item in rolling.passes)
    way = "reciprocating" if rolling.reciprocating else "each from the same start"
    ended = ""
    if len(rolling.passes) < rolling.requested:
        ended = f", ended: the last adds no plastic strain ({rolling.requested} requested)"
    return f"{_passes(rolling)}, {way}, {steps} steps each at most{ended}"


_SMALL, _TINY = 1e-4, 1e-5


def strain(value: float) -> str:
    """Return a strain in per cent; strains at shakedown are small."""
    if 0 < abs(value) < _TINY:
        return "<0.001 %"
    return f"{100 * value:.{2 if abs(value) < _SMALL else 3}g} %"


def _last(key: str) -> Callable[[RollingResult], Any]:
    return lambda rolling: getattr(rolling.passes[-1], key)


def _ran_in(rolling: RollingResult, key: str) -> str:
    heights = rolling.result.solution.surface.roughness()[key], getattr(rolling.passes[-1], key)
    before, after = (format_engineering(value, "m", 3) for value in heights)
    return f"{before} before, {after} after"


def _friction(rolling: RollingResult) -> float:
    return rolling.result.increments[-1].friction


ROLLING = (
    Quantity("passes", "passes", of=lambda r: len(r.passes), text=_way, part=PROBLEM),
    Quantity(
        "direction",
        "direction [degree]: where the counter-body moves, from x, counter-clockwise",
        form=lambda v: f"{v:g}°",
        part=PROBLEM,
    ),
    Quantity(
        "friction",
        "friction $μ$: of full sliding",
        of=_friction,
        part=PROBLEM,
        when=lambda r: bool(_friction(r)),
    ),
    Quantity("requested", of=lambda r: r.requested or len(r.passes)),
    Quantity("reciprocating"),
    Quantity("shakedown", "outcome", text=lambda r: r.outcome_text),
    Quantity("settled_after"),
    Quantity(
        "strain_added",
        "strain by the last pass: plastic, largest, forward and backward added",
        of=_last("strain_added"),
        form=strain,
    ),
    Quantity(
        "strain_net", "net strain of the last pass: largest", of=_last("strain_net"), form=strain
    ),
    Quantity(
        "shear",
        "shear by the last pass $γ$: largest of all layers, towards where the counter-body moved "
        "on the first pass",
        of=_last("largest_shear"),
        form=strain,
    ),
    Quantity("strain_threshold", "threshold of no strain: 1 % of the yield strain", form=strain),
    Quantity(
        "in_plane_stress",
        "residual stress in the plane [Pa]: largest of all layers along and across the pass; "
        "tension is positive",
        of=_last("in_plane_stress"),
    ),
    Quantity("Sq", "Sq [m]", of=_last("Sq"), text=partial(_ran_in, key="Sq")),
    Quantity("Spk", "Spk [m]", of=_last("Spk"), text=partial(_ran_in, key="Spk")),
    Quantity("depth", "[m]", of=lambda r: r.result.bodies[0].depth),
    Quantity("shear_over_depth", of=_last("shear")),
    Quantity("residual_along", "[Pa]", of=_last("residual_along")),
    Quantity("residual_across", "[Pa]", of=_last("residual_across")),
    Quantity("each", of=lambda r: stored_columns(PASSES, r)),
    Quantity("volume", of="result"),
    *CAUTIONS,
    Quantity("version", of=lambda _: __version__),
)
"""Quantities of a `RollingResult`."""


def _column(key: str, label: str = "", **text: Any) -> Column:
    return Column(key, label, of=f"passes.{key}", **text)


PASSES: Columns = (
    Column("number", "pass", of=lambda r: range(1, len(r.passes) + 1), front="pass"),
    _column("strain_added", "strain", form=strain, front="strain added"),
    _column("strain_net", "net strain", form=strain, front="net strain"),
    _column("largest_shear", "shear", form=strain),
    _column("max_plastic_strain", "in all", form=strain),
    _column("max_pressure", "largest pressure [Pa]", digits=3, front="peak pressure"),
    _column("contact_area", "contact area [m²]"),
    _column("approach", "approach [m]"),
    _column("max_residual_stress", "residual von Mises stress [Pa]"),
    _column("in_plane_stress", "residual stress [Pa]", digits=3, front="residual stress"),
    _column("Sq", "Sq [m]", digits=3, front="Sq"),
    _column("Spk", "Spk [m]", digits=3),
    _column("max_residual_displacement", "deepest [m]"),
    _column("steps", "steps"),
)
"""Columns of the passes of a `RollingResult`."""


_CRITERIA = {
    Shakedown.ELASTIC: "No pass added any plastic strain.",
    Shakedown.ELASTIC_SHAKEDOWN: (
        "The last pass added less than {least}, 1 % of the yield strain σ_Y/(3μ): {carried} the "
        "load without yielding."
    ),
    Shakedown.PLASTIC_SHAKEDOWN: (
        "The last pass added the same plastic strain as the one before, within 10 %, and less than "
        "2 % of it remains: the metal yields forward and backward: expect fatigue."
    ),
    Shakedown.RATCHETING: (
        "The last pass added the same plastic strain as the one before, and the same net strain, "
        "both within 10 %: each pass moves the metal further."
    ),
    Shakedown.NOT_SETTLED: (
        "The strain added by a pass still changes by more than 10 % from one to the next, and is "
        "above {least}, 1 % of the yield strain σ_Y/(3μ)."
    ),
    Shakedown.NOT_RESOLVED: (
        "The steps of a pass are longer than the contact half-width: the strain does not represent "
        "a roller in continuous motion. Use more steps."
    ),
}


def _last_state_figure(entry: Illustration) -> Illustration:
    moved = replace(entry, chapter=RESULTS if entry is figures.SECTION else FILES)
    return figures.within_scene(lambda rolling: figures.VolumeScene(rolling.result), moved)


FIGURES = (
    Illustration(
        "passes",
        plots.passes,
        "Pass by pass: plastic strain added and net, mean shear, maximum pressure and contact "
        "area, Sq and Spk of the unloaded body. Check whether the added strain decreases.",
        FRONT,
        WIDE,
    ),
    Illustration(
        "depths",
        plots.depths,
        "Over the depth: shear strain added by the passes; residual normal stress along and across "
        "the pass. Tension is positive.",
        RESULTS,
        WIDE,
    ),
    Illustration(
        "heights",
        plots.heights,
        "Heights of the unloaded body before and after the passes, through the deepest residual "
        "displacement.",
        RESULTS,
        WIDE,
    ),
    *map(_last_state_figure, figures.VOLUME),
)
"""Figures of a `RollingResult`, and of its last state."""


class RollingPresentation(Presentation):
    """Presentation of repeated passes."""

    result: RollingResult
    table = ROLLING
    columns = PASSES
    figures = FIGURES
    plots = (plots.passes, plots.depths, plots.heights)

    def question(self) -> str:
        """Return the question that repeated passes answer."""
        name = phrases.source(self.result.result.solution.surface.provenance)
        return f"Does {name} shake down in {_passes(self.result)}?"

    def problem(self) -> str:
        """Return bodies and load in one line."""
        return phrases.problem(self.result.result.solution)

    def answer(self) -> str:
        """Return the outcome of the passes as a sentence."""
        rolling = self.result
        count, last = len(rolling.passes), rolling.passes[-1]
        added = strain(last.strain_added)
        match rolling.shakedown:
            case Shakedown.ELASTIC:
                return "Nothing yields: no pass adds plastic strain."
            case Shakedown.ELASTIC_SHAKEDOWN:
                settled = count_noun(rolling.settled_after or 0, "pass")
                return f"Shakes down after {settled}: the last one adds {added} plastic strain."
            case Shakedown.PLASTIC_SHAKEDOWN:
                return f"Plastic shakedown: each pass strains by {added} and back. Expect fatigue."
            case Shakedown.RATCHETING:
                return f"Ratchets: each pass adds {strain(last.strain_net)} of net plastic strain."
            case Shakedown.NOT_SETTLED:
                return f"Not settled after {count_noun(count, 'pass')}: the last one adds {added}."
        return "Not resolved: the steps are longer than the contact half-width."

    def remarks(self) -> tuple[str, ...]:
        """Return the strain threshold, and the accuracy of the passes."""
        state = self.result.result
        count = count_noun(len(state.increments), "increment")
        least = strain(self.result.strain_threshold)
        return (
            f"No strain added: below {least} (1 % of the yield strain)",
            f"Solved: residual {order_of_magnitude(state.residual)} (limit {state.tolerance:.0e}), "
            f"{count}",
        )

    def meaning(self) -> str:
        """Return the criterion of the outcome as a sentence."""
        rolling = self.result
        hardens = any(body.material.hardens for body in rolling.result.bodies)
        carried = "residual stress and hardening carry" if hardens else "residual stress carries"
        least = strain(rolling.strain_threshold)
        return _CRITERIA[rolling.shakedown].format(least=least, carried=carried)

    def inputs(self) -> list[Block]:
        """Return the blocks on maps, bodies and load."""
        rolling = self.result
        state = volume_report.VolumePresentation(rolling.result).rows(PROBLEM)
        kept = (row for row in state if row.key not in ("turns", "increments"))
        specified = [*self.rows(PROBLEM), *kept]
        return chapters.input_blocks(rolling.result.solution, specified, "volume", self.is_drawn)

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the volume model."""
        return volume_report.VolumePresentation(self.result.result).method()

    def trust_blocks(self, checked: Sequence[str] | None = None) -> list[Block]:
        """Return the accuracy of the last state, and the performed checks."""
        state = volume_report.VolumePresentation(self.result.result)
        return [*state.trust_blocks(()), *super().trust_blocks(checked)]

    def checks(self) -> tuple[str, ...]:
        """Return the performed checks."""
        state = plausibility.performed_checks(self.result.result)
        return ("steps, pixel and direction of the passes", *state)

    def works(self) -> Iterator[Use]:
        """Yield the works cited for the result."""
        yield from citations.volume_references(self.result.result)
        yield make_use(
            "passes and shakedown", "Johnson1985", "Johnson1989", "Ponter1985", "Boucly2007"
        )
        yield make_use("displacement per pass", "Crook1957", "Merwin1963")

    def case(self) -> assumptions.Case:
        """Return the case of the last state."""
        return volume_report.VolumePresentation(self.result.result).case()

    def script(self) -> tuple[str, str]:
        """Return a script that repeats the path of loads."""
        return volume_report.VolumePresentation(self.result.result).script()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the passes as CSV or JSON, or the last state."""
        if Path(path).suffix.lower() in export.TABLES:
            super().save(path)
        else:
            ROLLING_FORMATS.write(self.result, path)

    def dataset(self) -> Dataset:
        """Return the last state and the passes."""
        return to_dataset(self.result)[0]
