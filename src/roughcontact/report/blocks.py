"""What the console shows of a result, block by block: tables, sentences, cautions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from roughcontact.cautions import Caution
from roughcontact.contact.result import ContactResult
from roughcontact.contact.share import Share
from roughcontact.material.material import Material
from roughcontact.report import inputs
from roughcontact.report.fields import PROBLEM, TRUST, Headline, Row, rows_of
from roughcontact.report.kind import CellTable, Kind
from roughcontact.report.phrases import is_rigid

Cells = tuple[str, ...]


@dataclass(frozen=True)
class Block:
    """A table of one or several parts under common heads."""

    parts: tuple[Sequence[Cells], ...]
    heads: Cells = ()


@dataclass(frozen=True)
class Lines:
    """Sentences, each on a line of its own."""

    sentences: tuple[str, ...]
    gap: bool = True


@dataclass(frozen=True)
class Cautions:
    """What a reader has to know."""

    cautions: tuple[Caution, ...]


Blocks = list[Block | Lines | Cautions]


def table(*parts: Sequence[Cells], heads: Cells = ()) -> Blocks:
    """Return the block of a table, if it has rows."""
    return [Block(parts, heads)] if any(parts) else []


def title(row: Row) -> str:
    """Return a name and its symbol."""
    return f"{row.name} {row.symbol}".rstrip()


def cells(rows: Iterable[Row]) -> list[Cells]:
    """Return names and values of rows."""
    return [(title(row), row.text) for row in rows]


# Steps that are shown of many: so many of the first, and so many of the last.
_ENDS = 3


def some(rows: Sequence[Cells]) -> Sequence[Cells]:
    """Return the first and the last of many rows."""
    if len(rows) <= 2 * _ENDS:
        return rows
    return [*rows[:_ENDS], ("…",) * len(rows[0]), *rows[-_ENDS:]]


def headline(kind: Kind, result: Any, **more: Any) -> Headline:
    """Return what is said first of a result."""
    listed: CellTable
    listed = kind.listing(result, True) if kind.numbers is None else kind.numbers(result, **more)
    heads, rows = listed
    return Headline(
        kind.problem(result), kind.answer(result, **more), heads, some(rows),
        kind.remarks(result, **more),
    )  # fmt: skip


def trust(kind: Kind, result: Any) -> list[Cells]:
    """Return how exactly a result is solved."""
    return cells(kind.rows(result, TRUST, brief=True))


def steps(kind: Kind, result: Any) -> Blocks:
    """Return one row a step, and what is told of all steps together."""
    heads, rows = kind.listing(result, brief=True)
    listed = [*cells(kind.rows(result, brief=True)), *trust(kind, result)]
    return [*table(rows, heads=heads), *table(listed)]


def usual(kind: Kind, result: Any) -> Blocks:
    """Return what is shown of a kind that says nothing else."""
    sentences = kind.sentences(result)
    return [
        *steps(kind, result),
        *([Lines(sentences, gap=False)] if sentences else []),
        Cautions(result.cautions),
    ]


def _map(surface: Share) -> list[Cells]:
    done = surface.provenance.steps or ("none",)
    prepared = [("" if index else "preparation", str(step)) for index, step in enumerate(done)]
    return [*cells(rows_of(inputs.table_of(surface), surface, brief=True)), *prepared]


def body(material: Material) -> str:
    """Return name and constants of a material in one line."""
    if is_rigid(material):
        return "rigid"
    rows = rows_of(inputs.BODY, material, brief=True)
    by_key = {row.key: f"{row.name} {row.text}" for row in rows if row.value is not None}
    constants = (by_key[key] for key in ("young", "poisson", "yield_strength", "hardness")
                 if key in by_key)  # fmt: skip
    return (f"{material.name}: " if material.name else "") + ", ".join(constants)


def problem(
    kind: Kind, result: Any, contact: ContactResult, without: Sequence[str] = ()
) -> list[Cells]:
    """Return maps and bodies of a contact, and what was asked for."""
    lines = [*_map(contact.share), ("body", body(contact.material))]
    other = body(contact.counter_material)
    if contact.counter_surface is None:
        lines.append(("counter-body", f"{other}, flat"))
    else:
        lines += [("counter-body", other), *_map(contact.counter_surface)]
    requested = kind.rows(result, PROBLEM, brief=True)
    return lines + cells(row for row in requested if row.key not in without)
