"""Header of the page: key quantities, state, checklist of inputs, and cautions."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import partial
from typing import Any

import panel as pn

from roughcontact.analyses.solve import report as contact, uncertainty_report
from roughcontact.analyses.solve.fields import CONTACT, PROFILE_CONTACT
from roughcontact.analyses.solve.task import TASK as SOLVE
from roughcontact.cautions import Caution, Severity
from roughcontact.contact.result import ContactResult
from roughcontact.desk import style
from roughcontact.desk.controls import (
    Give,
    escape_markup,
    gravest_first,
    make_button,
    markup_table,
    spell_sentence,
)
from roughcontact.desk.load_panel import FORCE, NOMINAL, LoadForm, load_text
from roughcontact.desk.session import PAGE
from roughcontact.errors import ArgumentRef
from roughcontact.report import kinds
from roughcontact.report.kind import TRUST, quantity_of
from roughcontact.units import count_noun

_KEYS = ("load", "contact_fraction", "saturated_fraction", "mean_pressure", "mean_gap", "approach")

_CHECKS: dict[str, list[str]] = PAGE["checks"]
"""Required inputs of a contact by option: label, and step where the input is entered."""


def key_numbers(result: ContactResult, form: LoadForm = FORCE) -> str:
    """Return the key quantities with intervals, or values under the calibrated ceiling.

    A load that is given as nominal pressure is shown as such, with its force below.
    """
    ends, calibrated = uncertainty_report.brief_ends(result), contact.calibrated_numbers(result)
    table = PROFILE_CONTACT if result.pair.is_profile else CONTACT
    cells = []
    for key in _KEYS:
        if result.ceiling is None and key == "saturated_fraction":
            continue
        quantity = quantity_of(table, key)
        row = quantity.row(result)
        other = ends.get(key) or (f"calibrated {calibrated[key]}" if key in calibrated else "")
        name, value = row.name[:1].upper() + row.name[1:], quantity.format_value(row.value)
        if key == "load" and form is NOMINAL:
            value, other = str(load_text(result, form, 4)), value
        cells.append(
            f"<div><dt>{escape_markup(name)}</dt><dd>{escape_markup(value)}</dd>"
            f"<small>{escape_markup(other)}</small></div>"
        )
    return f'<dl class="numbers">{"".join(cells)}</dl>'


def trust_line(result: ContactResult) -> str:
    """Return the status, certificate and regime of a result as one line."""
    rows = {row.key: row for row in kinds.rows(result, TRUST, brief=True)}
    shown = (rows[key] for key in ("status", "certificate") if key in rows)
    texts = ", ".join(f"{row.name} {spell_sentence(row.text)}" for row in shown)
    texts = texts.removeprefix("status ")
    kind = "good" if result.converged else "bad"
    return (
        f'<span class="{kind}">●</span> {escape_markup(texts)}; regime: '
        f"{escape_markup(result.regime)}"
    )


def suggested_settings(caution: Caution) -> Iterable[tuple[str, str, str | bool]]:
    """Yield the settings that a caution suggests: text, option and value."""
    for part in caution.parts:
        if not isinstance(part, ArgumentRef) or part.value is None:
            continue
        option = SOLVE.option_of_argument(part.name)
        if option is not None:
            value = True if part.value is True else option.text(part.value)
            yield f"Use {option.label.lower()} {value}", option.name, value


class Header:
    """Second line of the page header, and the drawer that it opens."""

    def __init__(self, load: Any, give: Give, seek: Callable[[str], None]) -> None:
        self._give = give
        self.numbers = pn.pane.HTML("", margin=0, stylesheets=[style.TEXT, style.CSS["NUMBERS"]])
        self._checks = {
            name: make_button("", partial(seek, place)) for name, (_, place) in _CHECKS.items()
        }
        self.checklist = pn.Row(*self._checks.values(), margin=0, visible=False)
        self.state = pn.pane.HTML("", margin=(2, 0), stylesheets=[style.TEXT, style.CSS["CHIP"]])
        self.count = make_button("", partial(self._open, "Cautions"), margin=0, visible=False)
        self._cautions: Sequence[Caution] = ()
        self._topic = ""
        self.drawer = pn.Column(
            visible=False, stylesheets=[style.TEXT, style.CSS["DRAWER"]], margin=0
        )
        status = pn.Column(self.state, self.count, width=180, margin=0, styles={"flex": "none"})
        self.root = pn.Row(
            load,
            self.numbers,
            self.checklist,
            status,
            sizing_mode="stretch_width",
            min_height=76,
            margin=0,
            stylesheets=[style.CSS["BAR"]],
        )

    def show_state(self, text: str, kind: str = "quiet") -> None:
        """Show the state as text: solving, up to date, out of date."""
        self.state.object = f'<span role="status" class="chip {kind}">{escape_markup(text)}</span>'

    def show_numbers(self, text: str, cautions: Iterable[Caution]) -> None:
        """Show the key quantities of a contact and the number of its cautions."""
        self.checklist.visible, self.numbers.visible = False, True
        self.numbers.object = text
        self.show_cautions(cautions)

    def show_lacking(self, lacking: Collection[str]) -> None:
        """Show the checklist of required inputs, with a check mark on complete ones."""
        self.numbers.visible, self.checklist.visible = False, True
        self.numbers.object = ""
        self.show_cautions(())
        first = next((name for name in _CHECKS if name in lacking), None)
        for name, check in self._checks.items():
            title = _CHECKS[name][0]
            check.visible = name != "missing" or name in lacking
            check.label = title if name in lacking else f"✓ {title}"
            check.color = "primary" if name == first else "default"

    def show_cautions(self, cautions: Iterable[Caution]) -> None:
        """Show the number of cautions by severity; an open drawer lists the cautions."""
        self._cautions = gravest_first(cautions)
        counts = [
            count_noun(sum(item.severity == kind for item in self._cautions), str(kind))
            for kind in Severity
            if any(item.severity == kind for item in self._cautions)
        ]
        self.count.label, self.count.visible = " · ".join(counts), bool(counts)
        severe = bool(self._cautions) and self._cautions[0].severity == Severity.WARNING
        self.count.styles = {"--text": "var(--severe)"} if severe else {}
        if self._topic == "Cautions":
            self._fill()

    def handle_key(self, key: str) -> None:
        """Handle a key: ``?`` toggles the list of keys, any other key closes the drawer."""
        if key == "?":
            self._open("Keys")
        elif self._topic:
            self.close()

    def close(self) -> None:
        """Close the drawer."""
        self._topic, self.drawer.visible = "", False

    def _open(self, topic: str) -> None:
        if self._topic == topic:
            self.close()
            return
        self._topic = topic
        self._fill()
        self.drawer.visible = True

    def _fill(self) -> None:
        head = pn.Row(
            pn.pane.HTML(f"<h2>{self._topic}</h2>", sizing_mode="stretch_width", **style.SHEETS),
            make_button("Close", self.close, margin=0),
            sizing_mode="stretch_width",
        )
        if self._topic == "Keys":
            text = markup_table(PAGE["keys"].items())
            self.drawer[:] = [head, pn.pane.HTML(text, **style.SHEET)]
            return
        parts = [part for caution in self._cautions for part in self._caution(caution)]
        self.drawer[:] = [head, *parts] if parts else [head, pn.pane.HTML("No cautions.")]

    def _caution(self, caution: Caution) -> list[Any]:
        name = caution.kind.replace("-", " ")
        text = (
            f'<p><b class="{caution.severity}">{caution.severity} · {escape_markup(name)}</b></p>'
            f"<p>{escape_markup(spell_sentence(caution.text))}</p>"
        )
        todo = [
            make_button(words, partial(self._give, option, value), margin=(0, 6, 12, 0))
            for words, option, value in suggested_settings(caution)
        ]
        return [pn.pane.HTML(text, sizing_mode="stretch_width", **style.SHEET), *todo]
