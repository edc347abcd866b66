"""The strip at the top: the numbers that matter, how sure they are, and what to know of them."""

from __future__ import annotations

from collections.abc import Iterable

from roughcontact.contact.cautions import Caution, Kind
from roughcontact.contact.result import ContactResult
from roughcontact.desk.words import escaped, spelled
from roughcontact.report import chapters, contact, results
from roughcontact.report.quantities import TRUST
from roughcontact.request.solve import TASK as SOLVE

_KEYS = ("load", "approach", "contact_fraction", "mean_pressure", "saturated_fraction", "mean_gap")


def numbers(result: ContactResult) -> str:
    """Return the headline numbers as a list of terms."""
    keys = [key for key in _KEYS if result.ceiling is not None or key != "saturated_fraction"]
    cells = chapters.headlines(contact.kind_of(result), result, keys)
    told = contact.under_calibrated(result)
    others = [
        f" <small>calibrated {escaped(told[key])}</small>" if key in told else "" for key in keys
    ]
    terms = "".join(
        f"<div><dt>{escaped(cell[0])}</dt><dd>{escaped(cell[1])}{other}</dd></div>"
        for cell, other in zip(cells, others, strict=True)
    )
    return f'<dl class="numbers" style="margin: 0">{terms}</dl>'


def trust(result: ContactResult) -> str:
    """Return whether it is solved, and to what certificate, in a line."""
    rows = {row.key: row for row in results.rows(result, TRUST, brief=True)}
    shown = (rows[key] for key in ("status", "certificate") if key in rows)
    texts = ", ".join(f"{row.name} {spelled(row.text)}" for row in shown)
    texts = texts.removeprefix("status ")
    kind = "good" if result.converged else "bad"
    return f'<span class="{kind}">●</span> {escaped(texts)}; regime: {escaped(result.regime)}'


def cautions(told: Iterable[Caution]) -> str:
    """Return what has to be known, the gravest first, as a list."""
    known = [one for one in told if one.kind != Kind.NOT_CONVERGED]
    order = ("warning", "caution", "note")
    known.sort(key=lambda one: order.index(one.severity))
    items = "".join(
        f'<li class="{one.severity}"><b>{one.severity}</b> {escaped(spelled(one.text))}</li>'
        for one in known
    )
    return f'<ul class="cautions">{items}</ul>' if items else '<p class="quiet">No cautions.</p>'


def missing(names: Iterable[str]) -> str:
    """Return what has to be told before anything can be solved."""
    wanted = ", ".join(f"<b>{escaped(_wanted(name))}</b>" for name in names)
    return f"<p>To solve the contact, tell: {wanted}.</p>"


def _wanted(name: str) -> str:
    known = {
        "file": "a map",
        "boundary": "whether the map is the whole contact",
        "holes": "what to do with its missing points",
    }
    return known.get(name) or SOLVE.by_name[name].label.lower()


def table(rows: Iterable[Iterable[str]], heads: Iterable[str] = ()) -> str:
    """Return rows of text as a table."""
    head = "".join(f"<th>{escaped(cell)}</th>" for cell in heads)
    body = "".join(
        "<tr>" + "".join(f"<td>{escaped(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table>{f'<tr>{head}</tr>' if head else ''}{body}</table>"


def all_numbers(result: ContactResult) -> str:
    """Return everything that is told of a contact, as the report does."""
    heads, answer = contact.beside_calibrated(contact.kind_of(result), result)
    told = [(row.title, *texts, row.meaning) for row, texts in answer]
    empty = ("",) * (len(heads) - 1)
    told += [(r.title, r.text, *empty, r.meaning) for r in results.rows(result, TRUST)]
    return table(told, ("", *heads, "") if heads else ())
