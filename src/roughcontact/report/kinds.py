"""Registry of the presentations of all classes of results."""

from __future__ import annotations

import base64
import html as markup
import os
import pkgutil
import textwrap
from collections.abc import Callable
from functools import partial, update_wrapper
from typing import TYPE_CHECKING, Any

from roughcontact.cautions import Severity
from roughcontact.contact import plausibility
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.references import References
from roughcontact.report import (
    assumptions,
    chapters,
    citations,
    figures,
    inputs,
    page,
    phrases,
    python_script,
)
from roughcontact.report.kind import (
    ANSWER,
    PROBLEM,
    TRUST,
    Headline,
    Presentation,
    Row,
    first_and_last,
)
from roughcontact.report.page import PLAIN, Block, Chapter, Edition, Front, PageTable
from roughcontact.result import presentation as connected_module
from roughcontact.units import format_engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def presentation_of(result: Any) -> Presentation:
    """Return the presentation of a result; raise `TypeError` for other objects."""
    places = connected_module().presentations
    for name in (base.__name__ for base in type(result).__mro__):
        for kind in map(_loaded, places.get(name, ())):
            if isinstance(result, kind.result) and kind.when(result):
                return kind
    raise TypeError(f"there is no kind of results for a {type(result).__name__}")


def all_presentations() -> list[Presentation]:
    """Return all presentations."""
    places = connected_module().presentations.values()
    return [_loaded(place) for some in places for place in some]


def _loaded(place: str) -> Presentation:
    return pkgutil.resolve_name(f"roughcontact.{place}")


# --- Functions for any result, by its presentation ---


def rows(result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
    """Return the rows of a result; see `kind.rows_of`."""
    return presentation_of(result).rows(result, part, brief)


def listing(result: Any, brief: bool = False) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of the steps of a result; see `kind.listing_of`."""
    return presentation_of(result).listing(result, brief)


def sentences(result: Any) -> tuple[str, ...]:
    """Return the sentences that precede the quantities of a result."""
    return presentation_of(result).sentences(result)


def summary(result: Any) -> dict[str, Any]:
    """Return the values of a result by name, in SI units, ready for JSON."""
    return presentation_of(result).summary(result)


def references(result: Any) -> References:
    """Return the references of a result."""
    return citations.references_of(presentation_of(result), result)


def headline(result: Any, **more: Any) -> Headline:
    """Return the headline of a result."""
    return presentation_of(result).headline(result, **more)


def tables(result: Any, **more: Any) -> list[Block]:
    """Return the content of a report except its figures and method."""
    kind = presentation_of(result)
    contact_of = None if kind.contact is None else kind.contact(result)
    stated = [
        *_inputs(kind, result, contact_of, drawn=False),
        *_results(kind, result, None, contact_of, more),
    ]
    stated += _uncertainty(contact_of, more.get("study"))
    solved = [block for block in kind.method(result) if block.kind == "table"]
    return [*stated, *solved, *_sentences(kind, result), *_trust(kind, result, contact_of)]


def drawings(result: Any) -> dict[str, Callable[[], Figure]]:
    """Return the functions that draw the figures of files, by name."""
    return presentation_of(result).drawings(result)


def save(result: Any, path: str | os.PathLike[str]) -> None:
    """Write a map or a result to a file; the suffix selects the format."""
    kind = presentation_of(result)
    (kind.save or kind.write)(result, path)


# --- The report on any result ---


def report(result: Any, path: str | os.PathLike[str], edition: Edition, **more: Any) -> None:
    """Write the report on a result to an HTML file."""
    page.check_path(path)
    if not presentation_of(result).question(result):
        raise InputError(f"there is no report on a {type(result).__name__} alone")
    more = {name: item for name, item in more.items() if item}
    page.save(render(result, edition, **more), path)


def render(result: Any, edition: Edition = PLAIN, **more: Any) -> str:
    """Return the report on any result as the text of an HTML file."""
    kind = presentation_of(result)
    scene = kind.scene(result)
    pressed_by = kind.largest or kind.contact
    pressed = None if pressed_by is None else pressed_by(result)
    sections: dict[str, list[Block]] = {
        "Input": _inputs(kind, result, pressed),
        "Results": _results(kind, result, scene, pressed, more),
        "Uncertainty": _uncertainty(pressed, more.get("study")),
        "Assumptions": _assumptions(kind, result, pressed),
        "Method and certificate": _method(kind, result, pressed),
        "How to repeat": _repetition(kind, result, pressed, edition),
        "References": [Block("list", citations.cited_works(references(result)))],
    }
    return page.render(
        _front_page(kind, result, scene, pressed, more.get("study")),
        [Chapter(title, blocks) for title, blocks in sections.items() if blocks],
        edition,
    )


def _front_page(kind: Presentation, result: Any, scene: Any, pressed: Any, study: Any) -> Front:
    first = kind.headline(result, **({} if study is None else {"study": study}))
    numbers = PageTable(first.rows, first.heads, "" if first.heads else "key")
    lead = next(iter(chapters.picture_list(kind.figures, scene, figures.FRONT)), None)
    meaning = kind.meaning(result)
    if not meaning and pressed is not None and result is not pressed and pressed.load:
        under = format_engineering(pressed.total_load, pressed.pair.load_unit)
        meaning = phrases.regime(pressed, in_layers=bool(getattr(result, "faces", ())))
        meaning = meaning and f"{meaning} (Under {under}.)"
    return Front(
        kind.question(result),
        first.problem,
        first.answer,
        numbers,
        [*filter(None, (meaning, *first.remarks))],
        lead,
        result.cautions,
        getattr(result, "status", "converged"),
    )


def _inputs(
    kind: Presentation, result: Any, pressed: ContactResult | None, drawn: bool = True
) -> list[Block]:
    """Return the blocks on the input of a result: maps, bodies and load of its contact."""
    if kind.inputs is not None:
        return kind.inputs(result, drawn)
    if pressed is None:
        return chapters.quantities(kind.rows(result, PROBLEM))
    of_contact = presentation_of(pressed)
    rows = [
        *kind.rows(result, PROBLEM),
        of_contact.row(pressed, pressed.control),
        *of_contact.rows(pressed, PROBLEM),
    ]
    specified = {row.key: row for row in reversed(rows)}.values()
    return [
        *chapters.map_blocks(pressed, drawn),
        *chapters.body_blocks(
            (pressed.material, pressed.counter_material),
            reversed(specified),
            inputs.bodies("ceiling", pressed.pair.is_profile),
        ),
    ]


def _uncertainty(pressed: ContactResult | None, study: Any) -> list[Block]:
    return [] if pressed is None else presentation_of(pressed).uncertainty(pressed, study)


def _contact_blocks(pressed: ContactResult) -> list[Block]:
    return presentation_of(pressed).contact_blocks(pressed)


def _fits_on_front(kind: Presentation, result: Any) -> bool:
    """Return whether the first page shows all rows of the steps."""
    _, rows = kind.listing(result)
    return not rows or (kind.numbers is None and first_and_last(rows) == rows)


def _results(
    kind: Presentation, result: Any, scene: Any, pressed: ContactResult | None, more: dict[str, Any]
) -> list[Block]:
    if result is pressed:
        return kind.details(result, scene, **more)
    return [
        *chapters.quantities(kind.rows(result)),
        *([] if _fits_on_front(kind, result) else chapters.steps(kind, result)),
        *chapters.figure_blocks(kind.figures, scene),
        *kind.details(result, scene, **more),
        *([] if pressed is None or not pressed.load else _contact_blocks(pressed)),
    ]


def _assumptions(kind: Presentation, result: Any, pressed: ContactResult | None) -> list[Block]:
    case = None if kind.case is None else kind.case(result)
    if case is None and pressed is not None:
        case = assumptions.contact_case(pressed)
    rows = [] if case is None else assumptions.assumption_rows(assumptions.ASSUMPTIONS, case)
    rows += assumptions.assumption_rows(kind.assumptions, result)
    explained = Block("small", "The user guide explains each assumption: “Assumptions”.")
    return [explained, *chapters.table(rows, assumptions.HEAD)] if rows else []


def _method(kind: Presentation, result: Any, pressed: ContactResult | None) -> list[Block]:
    certificate = [] if pressed is None else chapters.certificate(pressed)
    known = _sentences(kind, result)
    return [*kind.method(result), *known, *certificate, *_trust(kind, result, pressed)]


def _sentences(kind: Presentation, result: Any) -> list[Block]:
    text = " ".join(kind.sentences(result))
    return [Block("text", text)] if text else []


def _trust(kind: Presentation, result: Any, pressed: ContactResult | None) -> list[Block]:
    """Return the blocks on the accuracy of a result and the checks performed."""
    checked = kind.checked(result)
    if pressed is not None:
        checked = checked or plausibility.performed_checks(pressed)
    if not kind.rows(result, TRUST) and pressed is not None:
        return chapters.trust_blocks(presentation_of(pressed), pressed, checked)
    return chapters.trust_blocks(kind, result, checked)


def _repetition(
    kind: Presentation, result: Any, pressed: ContactResult | None, edition: Edition
) -> list[Block]:
    script, what, version = kind.script(result), "the same problem", getattr(result, "version", "")
    if pressed is not None and not script:
        script, what = python_script.script_of_result(pressed), "the contact under the largest load"
    return chapters.script_blocks(version, edition.command, script, what)


# --- Display of a result in a session and in a notebook ---

_WIDE, _SMALL = 420, 340
# Characters of a line.
_LINE = 88


def headline_text(shown: Any) -> str:
    """Return problem, answer and main quantities of an object as text, about ten lines."""
    first = _headline_of(shown)
    lines = [f"{_class_name(shown)}: {first.problem}".removesuffix(": ")]
    lines += _wrap_text(first.answer)
    table = _table(first)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines += [
        "  " + "  ".join(f"{cell:{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]
    for sentence in (*first.remarks, *_cautions(shown)):
        lines += _wrap_text(sentence)
    return "\n".join(lines)


def _wrap_text(sentence: str) -> list[str]:
    return textwrap.wrap(sentence, _LINE, initial_indent="  ", subsequent_indent="    ")


def headline_html(shown: Any) -> str:
    """Return the headline as HTML, next to a figure if there is one."""
    first = _headline_of(shown)
    rows = "".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in _table(first))
    said = (first.problem, first.answer, *first.remarks, *_cautions(shown))
    before, after = (
        "".join(f"<p>{markup.escape(line, quote=False)}</p>" for line in part if line)
        for part in (said[:2], said[2:])
    )
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 1em; align-items: flex-start">'
        f'{_picture(shown)}<div style="max-width: 40em"><b>{markup.escape(_class_name(shown))}</b>'
        f"{before}<table>{rows}</table>{after}</div></div>"
    )


def _headline_of(shown: Any) -> Headline:
    """Return the headline of a result; of a map, its roughness parameters."""
    kind = presentation_of(shown)
    if kind.has_answer:
        return headline(shown)
    rows = [(row.name, row.text) for row in kind.rows(shown, brief=kind.brief)]
    heads, steps = kind.listing(shown, brief=True)
    return Headline("", "", (), [*rows, *([heads, *steps] if not rows else [])], ())


def _table(first: Headline) -> list[tuple[str, ...]]:
    return [*([first.heads] if any(first.heads) else []), *first.rows]


def _class_name(shown: Any) -> str:
    kind = type(shown).__name__
    return kind if getattr(shown, "converged", True) else f"{kind}, not converged"


def _cautions(shown: Any) -> list[str]:
    """Return the warnings and cautions, one line each."""
    return [
        f"{caution.severity.upper()} {caution.kind}: {caution.text}"
        for caution in getattr(shown, "cautions", ())
        if caution.severity != Severity.NOTE
    ]


def _cell(text: str) -> str:
    return f'<td style="text-align: left">{markup.escape(text)}</td>'


def _picture(shown: Any) -> str:
    from roughcontact.drawing.export import png

    try:
        figures = Plots(shown)
        # One panel only: the figure of four panels is too large for a notebook cell.
        figure = figures.pressure() if "pressure" in dir(figures) else figures()
    except (AttributeError, InputError):
        # Some classes have no figures, and some results nothing to draw.
        return ""
    data = base64.b64encode(png(figure)).decode("ascii")
    wide = _WIDE if figure.get_figwidth() > figure.get_figheight() else _SMALL
    return f'<img alt="" style="width: {wide}px" src="data:image/png;base64,{data}">'


# --- Figures of an object as its methods: `result.plot.pressure()` ---


Draw = Callable[..., "Figure"]


class Plots:
    """Figures of an object by their names in ``rc.plots``; the first is the default."""

    def __init__(self, shown: object) -> None:
        self._shown = shown
        self._figures = {figure.__name__: figure for figure in presentation_of(shown).plots}
        if not self._figures:
            raise AttributeError(f"{type(shown).__name__} has no figures")

    def __call__(self, **options: Any) -> Figure:
        """Draw the default figure."""
        return next(iter(self._figures.values()))(self._shown, **options)

    def __getattr__(self, name: str) -> Draw:
        """Return the function that draws a figure, with its documentation."""
        if name.startswith("_") or name not in self._figures:
            raise AttributeError(f"there is no figure {name!r}, only {', '.join(self._figures)}")
        draw = self._figures[name]
        return update_wrapper(partial(draw, self._shown), draw)

    def __dir__(self) -> list[str]:
        """Return the names of the figures."""
        return list(self._figures)

    def __repr__(self) -> str:
        """Return the calls of the figures as text."""
        return "figures: plot(), " + ", ".join(f"plot.{name}()" for name in self._figures)
