"""The report on maps that are compared, and on the area that a map needs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from roughcontact._version import __version__
from roughcontact.contact.compared import Comparison
from roughcontact.contact.sample import Sample
from roughcontact.contact.sampling import SamplingStudy
from roughcontact.plots import samples as plots
from roughcontact.references import cited
from roughcontact.report import (
    assumptions_compared,
    blocks,
    chapters,
    compared,
    inputs,
    page,
    sources,
    tables,
    wording,
)
from roughcontact.report.blocks import Blocks, Cautions, Lines
from roughcontact.report.compared import LEVEL, name_of, unit_of
from roughcontact.report.kind import Kind, Use
from roughcontact.report.page import PLAIN, Cells, Chapter, Edition, Table, joined
from roughcontact.report.quantities import PROBLEM, TRUST, capital, quantity_of, rows_of, within
from roughcontact.report.scenes import Illustration
from roughcontact.units import counted, engineering, lengths

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Groups that a title names.
_NAMED = 3

# What all maps have in common, of a `Sample`.
_TERMS = (
    *(within("curve", quantity_of(tables.CONTACT, key)) for key in ("boundary", "contact_modulus")),
    replace(
        quantity_of(tables.CONTACT, "ceiling"), of="curve.ceiling",
        text=lambda one: wording.limit(one.curve.ceiling, *one.bodies),
    ),
)  # fmt: skip

_FIRST = ("contact_fraction", "saturated_fraction", "mean_gap", "Sq", "Sdq")


def render(
    found: Comparison | SamplingStudy,
    edition: Edition = PLAIN,
) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    found : Comparison or SamplingStudy
        What the report is on.
    edition : Edition
        Command, date, and how it is drawn and worded.

    Returns
    -------
    str
        HTML with its figures inside.
    """
    if isinstance(found, SamplingStudy):
        told, first = [_sampling(found), *_problem(found, [found.whole])], _of_study(found)
        verdict = f"{compared.answer(found)}."
    else:
        told, first, verdict = _chapters(found), _first(found), _verdict(found)
    return page.render(
        [
            *told,
            chapters.repetition(__version__, edition.command, ""),
            sources.chapter(sources.of(kind_of(found), found)),
        ],
        title=_title(found),
        subtitle=f"Nominal pressure {engineering(found.pressure, 'Pa')} on every map",
        edition=edition,
        status="converged",
        key_numbers=first,
        regime="",
        regime_text=verdict,
        certificate=_certificates(found),
        cautions=found.cautions,
        checked=(),
    )


def _title(found: Comparison | SamplingStudy) -> str:
    if isinstance(found, SamplingStudy):
        return f"How sure the numbers of {found.name} are"
    names = [group.name for group in found.groups if group.name]
    if found.first_pressure is not None:
        return f"{counted(len(found.groups[0].samples), 'map')} before and after a first loading"
    if not 1 < len(names) <= _NAMED:
        return _counts(found)
    *most, last = names
    return f"{', '.join(most)} and {last}"


def _counts(found: Comparison) -> str:
    groups = f" in {counted(len(found.groups), 'group')}" if len(found.groups) > 1 else ""
    return f"Comparison of {counted(len(found.samples), 'map')}{groups}"


def _first(found: Comparison) -> list[Cells]:
    keys = [name for name in _FIRST if name in found.names]
    heads = [group.name for group in found.groups]
    return [
        (
            capital(name_of(name)),
            " / ".join(
                compared.told(name, found.mean(at, name).value, digits=3)
                for at in range(len(found.groups))
            ),
            " / ".join(heads) if len(heads) > 1 else "mean of all maps",
        )
        for name in keys
    ]


def _of_study(study: SamplingStudy) -> list[Cells]:
    return [
        (
            capital(name_of(one.name)),
            f"±{compared.part(one.relative)}",
            f"{compared.FIVE} needs {compared.side(one.area)}",
        )
        for one in study.errors
    ]


def _verdict(found: Comparison) -> str:
    """Return in words which differences exclude zero."""
    if len(found.groups) < 2:
        return f"Means of {counted(len(found.samples), 'map')}, each with its {LEVEL} interval."
    sentences = []
    for first, second in found.differences(found.names[0]):
        differ = [
            name_of(name)
            for name in found.names
            if found.differences(name)[first, second].excludes_zero
        ]
        pair = compared.pair_of(found, first, second)
        sentences.append(
            f"For {pair}, the {LEVEL} interval excludes zero in {', '.join(differ)}."
            if differ
            else f"For {pair}, no {LEVEL} interval excludes zero."
        )
    return " ".join(sentences)


def _certificates(found: Comparison | SamplingStudy) -> str:
    if isinstance(found, SamplingStudy):
        return ""
    row = kind_of(found).row(found, "worst_certificate")
    return (
        f"Certificates of {counted(len(found.samples), 'map')}: {row.text}. They say how exactly "
        "each contact is solved, and the intervals how far the maps stand for their surfaces."
    )


def _chapters(found: Comparison) -> list[Chapter]:
    head, rows = compared.means(found)
    numbers = Chapter(f"Numbers under {engineering(found.pressure, 'Pa')}")
    numbers.add("text", f"Each cell: {compared.MEANS}.")
    numbers.add("table", Table(rows, head))
    _show(
        numbers, partial(plots.numbers, found, name_of, unit_of),
        "Each dot is a map; thick lines are means, the bar beside each its interval. Where two or "
        "three maps make it much wider than they lie apart, it runs out of the panel.",
    )  # fmt: skip
    told = [numbers]
    if len(found.groups) > 1:
        told.append(_differences(found))
    if len(found.pressures) > 1:
        told.append(_curves(found))
    told += [_sampling(study) for study in found.sampling]
    return [*told, _maps(found), *_problem(found, found.samples)]


def _differences(found: Comparison) -> Chapter:
    chapter = Chapter("Differences")
    head, rows = compared.differences(found)
    how = (
        "Student's t of the pairs" if found.paired
        else "Welch's t, for groups that may scatter unequally" if len(found.groups) == 2
        else "Games and Howell: for each number the intervals of all pairs hold together"
    )  # fmt: skip
    chapter.add(
        "text",
        f"Intervals of {LEVEL} by {how}. Where one excludes zero, so small a number of maps would "
        "seldom differ as much by chance alone; where it does not, they may still differ by what "
        "the interval holds. The relative difference is that over the mean of the group that is "
        "subtracted.",
    )
    chapter.add("table", Table(rows, head))
    shares, split = compared.components(found)
    if split:
        chapter.add(
            "text",
            "How the scatter of all maps splits into that between groups and that within (one-way, "
            "random effects). Where groups are pieces and maps places on them, the first is how "
            "the pieces differ; where groups are instruments or lenses on one piece, it is the "
            "instrument. Few groups leave the share wide open.",
        )
        chapter.add("table", Table(split, shares))
    return chapter


def _curves(found: Comparison) -> Chapter:
    chapter = Chapter("Load curves")
    _show(
        chapter, partial(plots.curves, found, name_of, unit_of),
        f"Each map a thin line over the nominal pressure, the mean of each group a thick one with "
        f"the band of its {LEVEL} interval at every pressure.",
    )  # fmt: skip
    return chapter


def _sampling(study: SamplingStudy) -> Chapter:
    chapter = Chapter(f"The area that is needed: {study.name}")
    parts = ", ".join(str(len(level)) for level in study.levels.values())
    chapter.add("text", f"{compared.answer(study)}.")
    chapter.add(
        "text",
        f"The map was cut into {parts} equal parts; each was leveled and pressed by itself under "
        "the same nominal pressure. Their scatter gives the error of the whole, which falls with "
        "the root of the area as long as parts are independent.",
    )
    head, rows = SAMPLING_KIND.listing(study)
    chapter.add("table", Table(rows, head))
    _show(
        chapter, partial(plots.sampling, study, name_of),
        "Half of the interval over the side of a square: dots of single parts, squares of the map, "
        f"lines by the root of the area; {compared.FIVE} is dashed.",
    )  # fmt: skip
    return chapter


def _maps(found: Comparison) -> Chapter:
    chapter = Chapter("Maps")
    rows: list[Cells] = [
        (
            sample.name,
            group.name,
            lengths(sample.size),
            lengths(sample.pixel),
            engineering(sample.shortest_wave, "m", 3),
        )
        for group in found.groups
        for sample in group.samples
    ]
    head = ("map", "group", "size (y × x)", "pixel (y × x)", "shortest wave")
    chapter.add("table", Table(rows, head))
    rows = [(row.title, row.text) for row in kind_of(found).rows(found, TRUST)]
    chapter.add("table", Table(rows))
    _prepared(chapter, found.samples)
    return chapter


def _prepared(chapter: Chapter, samples: Sequence[Sample]) -> None:
    """Add how the maps were prepared, once if all of them were alike."""
    steps = [tuple(page.sentence(step) for step in one.curve.preparation) for one in samples]
    if len(set(steps)) > 1:
        rows = [
            (one.name, joined(*told) or "none recorded")
            for one, told in zip(samples, steps, strict=True)
        ]
        chapter.add("table", Table(rows, ("map", "preparation")))
    elif steps[0]:
        chapter.add("text", "Preparation of each map, in this order:")
        chapter.add("steps", list(steps[0]))
    else:
        chapter.add("text", "Preparation: none recorded; the heights are as given.")


def _problem(found: Comparison | SamplingStudy, samples: Sequence[Sample]) -> list[Chapter]:
    """Return the chapters on what was pressed how, and on what is assumed."""
    given = [*kind_of(found).rows(found, PROBLEM), *rows_of(_TERMS, samples[0], PROBLEM)]
    stated = assumptions_compared.statements(samples)
    return [
        chapters.pressed(samples[0].bodies, chapters.cells(given), inputs.bodies("ceiling")),
        chapters.assumed(stated, found.cautions),
    ]


def _show(chapter: Chapter, draw: Callable[[], Figure], caption: str) -> None:
    chapter.add("figure", page.picture(draw, caption, caption))


def overview(found: Comparison) -> Figure:
    """Return all that is compared in one figure."""
    return plots.overview(found, name_of, unit_of)


def sampling(study: SamplingStudy) -> Figure:
    """Return how an error falls with the area."""
    return plots.sampling(study, name_of)


def _works(study: SamplingStudy) -> Iterator[Use]:
    yield from sources.of_curve(study.whole.curve)
    yield cited("intervals of the means", "Student1908")


def shown(found: Comparison | SamplingStudy) -> Blocks:
    """Return what the console shows: means, differences, shares of the scatter; areas needed."""
    parts = blocks.table(blocks.cells(kind_of(found).rows(found, PROBLEM, brief=True)))
    studies: Sequence[SamplingStudy] = (found,) if isinstance(found, SamplingStudy) else ()
    if isinstance(found, Comparison):
        for heads, rows in compared.tables_of(found):
            parts += blocks.table(rows, heads=heads)
        left_out = compared.left_out(found)
        parts += [Lines((left_out,))] if left_out else []
        studies = found.sampling
    for study in studies:
        parts += [*blocks.steps(SAMPLING_KIND, study), Lines((f"{compared.answer(study)}.",))]
    return [*parts, Cautions(found.cautions)]


KIND = Kind(
    Comparison, compared.COMPARISON, compared.COMPARISON_COLUMNS, works=sources.of_comparison,
    figures=(Illustration("comparison", overview, "", ""),), report=render, blocks=shown,
)  # fmt: skip
SAMPLING_KIND = Kind(
    SamplingStudy, compared.SAMPLING, compared.SAMPLING_COLUMNS, works=_works,
    figures=(Illustration("sampling", sampling, "", ""),), report=render, blocks=shown,
)  # fmt: skip


def kind_of(found: Comparison | SamplingStudy) -> Kind:
    """Return the kind: of maps that are compared, or of the area that a map needs."""
    return SAMPLING_KIND if isinstance(found, SamplingStudy) else KIND
