"""The report on a contact; also the part of other reports on the contact under the largest load.

Everything in it comes from the results that are handed over, but the elastic solution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from roughcontact.contact import plausibility
from roughcontact.contact.result import ContactResult
from roughcontact.contact.share import Slab
from roughcontact.errors import ConvergenceError, InsufficientMemoryError
from roughcontact.formats import export
from roughcontact.plots import cells, maps, profiles as draw
from roughcontact.plots.sections import pressure_histogram, section
from roughcontact.report import (
    blocks,
    chapters,
    contact_fields,
    estimate,
    figures,
    hertz_comparison,
    inputs,
    phrases,
    python_script,
    regimes,
    uncertainty,
)
from roughcontact.report.blocks import Blocks, Cautions, Lines
from roughcontact.report.fields import (
    ABSENT,
    PROBLEM,
    Row,
    capital,
    quantity_of,
    rows_of,
)
from roughcontact.report.figure_data import FRONT, RESULTS, Illustration
from roughcontact.report.kind import Kind
from roughcontact.report.page import HALF, Block, Cells
from roughcontact.studies.resolution_study import ResolutionStudy
from roughcontact.units import engineering


def question(result: ContactResult) -> str:
    """Return the question that a contact answers."""
    name, under = phrases.source(result.share.provenance), phrases.under(result)
    smooth = result.smooth if not result.pair.is_shared else None
    if result.control == "approach":
        return f"Which load does {name} carry {under}?"
    if smooth is not None:
        return f"How large is the contact of {name} {under}?"
    return f"How much of {name} is in contact {under}?"


def inputs_of(kind: Kind, result: Any, pressed: ContactResult | None) -> list[Block]:
    """Return the blocks on what went into a result: maps, bodies and load of its contact."""
    if kind.inputs is not None:
        return kind.inputs(result)
    if pressed is None:
        return chapters.quantities(kind.rows(result, PROBLEM))
    own = kind_of(pressed)
    rows = [*kind.rows(result, PROBLEM), own.row(pressed, pressed.control),
            *own.rows(pressed, PROBLEM)]  # fmt: skip
    specified = {row.key: row for row in reversed(rows)}.values()
    return [
        *chapters.maps(pressed),
        *chapters.bodies(
            (pressed.material, pressed.counter_material), reversed(specified),
            inputs.bodies("ceiling", pressed.pair.is_profile),
        ),
    ]  # fmt: skip


def uncertainty_of(result: ContactResult | None, study: ResolutionStudy | None) -> list[Block]:
    """Return the blocks on the intervals of a contact and what contributes to them."""
    if result is None or not (result.converged and result.load):
        return []
    known = uncertainty.ends(result, study)
    rows = [
        (capital(name), interval, causes)
        for name, interval, causes in uncertainty.uncertainty_rows(result, study)
        if interval in known.values()
    ]
    blocks = chapters.table(rows, ("quantity", "interval", "contributions"))
    table = kind_of(result).table
    keys = ("contact_fraction", "saturated_fraction", "max_pressure", "mean_gap", "approach")
    others = [quantity_of(table, key).name for key in keys if key not in known]
    hint = "" if study is not None else " The pixel was not studied (--study)."
    blocks.append(Block("small", f"No interval is known of: {', '.join(others)}.{hint}"))
    formula = chapters.cells(rows_of(estimate.BESIDE, result))
    blocks += chapters.table([(name, text) for name, text, _ in formula])
    if study is not None:
        blocks += [Block("text", " ".join(study.sentences))]
        blocks += chapters.steps(uncertainty.KIND, study)
    return [*blocks, Block("small", uncertainty.NOT_INCLUDED)]


def details(result: ContactResult, scene: Any, **more: Any) -> list[Block]:
    """Return the blocks with all results of a contact."""
    kind, elastic = kind_of(result), None
    if result.saturated_fraction > 0 and not result.pair.is_shared:
        elastic = _best(result.elastic)
    answer = [*_columns(kind, result, elastic)]
    if elastic is not None and not elastic.converged:
        answer.append(
            Block(
                "warning",
                f"The elastic solution did not converge: certificate {elastic.certificate:.1e}, "
                f"limit {elastic.tolerance:.0e}. Its column is not a solution.",
            )
        )
    answer += chapters.shown(kind.figures, scene, FRONT)[1:]
    answer += chapters.shown(kind.figures, scene)
    return answer if result.pair.is_shared else [*answer, *chapters.with_hertz(result)]


def in_short(result: ContactResult) -> list[Block]:
    """Return the blocks on the contact under the largest load of other results."""
    kind = kind_of(result)
    keys = [key for key in headlines(result) if quantity_of(kind.table, key).when(result)]
    rows = [*chapters.headlines(kind, result, keys), *chapters.spots(result)]
    head = f"Contact under {engineering(result.load, result.pair.load_unit)}, the largest load"
    scene = figures.ContactScene(result)
    front = chapters.shown(kind.figures, scene, FRONT)
    if not (result.pair.is_profile or scene.is_sparse):
        # Its gap is that of bodies on the way, where they have a history.
        front += chapters.shown(kind.figures, scene)
    count = 1 if result.pair.is_profile or scene.is_sparse else 2
    shown = [*chapters.table(rows, style="key"), *front[:count], *chapters.with_hertz(result)]
    return [Block("head", head), *shown]


def _columns(
    kind: Kind, result: ContactResult, elastic: ContactResult | None = None
) -> list[Block]:
    """Return the block of all results: a column for each ceiling, the elastic one last."""
    heads, answer = beside_calibrated(kind, result, brief=True)
    others = {}
    if elastic is not None:
        heads = (*(heads or (_ceiling_head(result),)), "elastic")
        others = {row.key: row.text for row in kind.rows(elastic, brief=True)}
    rows = [
        (row.title, *texts, *((others.get(row.key, ABSENT),) if others else ()), row.meaning)
        for row, texts in answer
    ]
    if not result.pair.is_shared and result.load:
        empty = ("",) * (len(heads or ("value",)) - 1)
        rows += [(name, text, *empty, note) for name, text, note in chapters.spots(result)]
    return chapters.table(rows, ("quantity", *(heads or ("value",)), "meaning"), "wide")


def _ceiling_head(result: ContactResult) -> str:
    if isinstance(result.ceiling, np.ndarray):
        return "with ceiling"
    return f"ceiling {engineering(float(result.ceiling or 0), 'Pa', 3)}"


def remarks(result: ContactResult) -> list[str]:
    """Return what the calibrated ceiling changes, in a sentence."""
    other = under_calibrated(result)
    if not other:
        return []
    names = {key: quantity_of(contact_fields.CONTACT, key).name for key in other}
    texts = (f"{names[key]} {other[key]}" for key in ("contact_fraction", "mean_gap", "approach"))
    return [f"With a ceiling of {_ceilings(result)[1]}: {', '.join(texts)}."]


def headlines(result: ContactResult) -> tuple[str, ...]:
    """Return the keys of the key numbers."""
    other = "approach" if result.control == "load" else "load"
    return (*contact_fields.HEADLINES, other, "max_residual_indentation")


@dataclass(frozen=True, eq=False)
class SharedScene:
    """Reduced maps of a contact whose map several ranks hold."""

    size: tuple[float, float]
    blocks: Sequence[Any]  # Of the first rank; None on others

    @classmethod
    def of(cls, result: ContactResult) -> SharedScene:
        """Reduce the maps; all ranks that hold them call it."""
        share, gap, pressure = result.share, result.gap, result.pressure
        assert isinstance(share, Slab)
        return cls(
            share.size,
            [share.reduced(values, largest=values is pressure)
             for values in (share.heights, pressure, gap)],
        )  # fmt: skip

    def drawn(self, index: int) -> Any:
        """Return one of the maps as a figure."""
        return list(cells.figures(self.size, *self.blocks).values())[index]()


def _reduced(index: int, caption: str, chapter: str) -> Illustration:
    return Illustration("", lambda s: s.drawn(index), caption, caption, chapter, HALF)


_SHARED = (
    _reduced(1, "Largest pressure in each block of points.", FRONT),
    _reduced(0, "Mean height of each block of points.", RESULTS),
    _reduced(2, "Mean gap of each block of points.", RESULTS),
)


def _best(solve: Callable[[], ContactResult]) -> ContactResult | None:
    """Return the same problem under another ceiling, or the best that was found of it."""
    try:
        return solve()
    except ConvergenceError as error:
        # The report shows it as what it is.
        return error.result if isinstance(error.result, ContactResult) else None
    except InsufficientMemoryError:
        # The report stays worth having without it.
        return None


_CALIBRATED = (
    "contact_area", "contact_fraction", "saturated_fraction", "mean_pressure", "mean_gap",
    "approach",
)  # fmt: skip


def under_calibrated(result: Any) -> dict[str, str]:
    """Return what is told under the calibrated ceiling, by key; nothing where it is the same."""
    other = getattr(result, "calibrated", None)
    if other is None or not other.differs:
        return {}
    return {key: quantity_of(contact_fields.CONTACT, key).row(other).text for key in _CALIBRATED}


def _ceilings(result: ContactResult) -> tuple[str, str]:
    """Return the heads of two columns: the ceiling of a result, and the calibrated one."""
    assert result.calibrated is not None
    factors = (result.calibrated.factor * float(result.ceiling or 0) / result.calibrated.ceiling,
               result.calibrated.factor)  # fmt: skip
    own, other = (f"{factor:.3g} σ_Y" for factor in factors)
    return f"ceiling {own}", f"calibrated, {other}"


def beside_calibrated(
    kind: Kind, result: Any, brief: bool = False
) -> tuple[Cells, list[tuple[Row, Cells]]]:
    """Return heads and rows of an answer, with a second column where another ceiling changes it."""
    answer, calibrated = kind.rows(result, brief=brief), under_calibrated(result)
    if not calibrated:
        return (), [(row, (row.text,)) for row in answer]
    return _ceilings(result), [(row, (row.text, calibrated.get(row.key, ""))) for row in answer]


def shown(result: ContactResult, study: ResolutionStudy | None = None) -> Blocks:
    """Return what the console shows: problem, answer, trust and how sure; then cautions, study."""
    kind = kind_of(result)
    heads, answer = beside_calibrated(kind, result, brief=True)
    problem, trust = blocks.problem(kind, result, result), blocks.trust(kind, result)
    rows = [(blocks.title(row), *texts) for row, texts in answer]
    parts = blocks.table(problem, rows, trust)
    if heads:
        parts = [
            blocks.Block((problem,)),
            blocks.Block((rows,), ("", *heads)),
            blocks.Block((trust,)),
        ]
    if result.converged and result.load:
        parts += blocks.table(uncertainty.uncertainty_rows(result, study), heads=uncertainty.HEADS)
    if hertz_comparison.applies(result):
        parts += blocks.table(hertz_comparison.rows(result), heads=hertz_comparison.HEADS)
    parts.append(Cautions(result.cautions))
    if study is not None:
        parts += [*blocks.steps(uncertainty.KIND, study), Lines(study.sentences)]
    return parts


KIND = Kind(
    ContactResult, contact_fields.CONTACT, figures=figures.CONTACT, scene=figures.ContactScene,
    plots=(
        maps.overview, maps.pressure, maps.contact, maps.gap, maps.close_up, maps.spots,
        section, pressure_histogram,
    ),
    contact=lambda result: result, save=export.save_contact, blocks=shown,
    question=question, headlines=headlines, details=details, meaning=regimes.regime,
    checked=plausibility.checked, script=python_script.repeating,
)  # fmt: skip
PROFILE_KIND = replace(
    KIND, table=contact_fields.PROFILE_CONTACT, when=lambda result: result.pair.is_profile,
    figures=figures.PROFILE_CONTACT, plots=(draw.pressed,),
)  # fmt: skip

SHARED_KIND = replace(
    KIND,
    table=contact_fields.SHARED,
    when=lambda result: result.pair.is_shared,
    figures=_SHARED,
    scene=SharedScene.of,
    plots=(),
    script=lambda _: "",
    ranks=lambda result: result.share.ranks,
)


def kind_of(result: ContactResult) -> Kind:
    """Return the kind of a contact: of a map in one place or on several ranks, or of a profile."""
    if result.pair.is_shared:
        return SHARED_KIND
    return PROFILE_KIND if result.pair.is_profile else KIND
