"""Words that several figures share: load, doubt, names of results."""

from __future__ import annotations

from collections.abc import Sequence

from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.units import engineering
from roughcontact.volume.result import ElastoplasticResult


def result_names(results: Sequence[ContactResult], labels: Sequence[str] | None) -> list[str]:
    """Return one name a result; `InputError` unless the labels fit."""
    if not results:
        raise InputError("is empty: give at least one", argument="results")
    if labels is None:
        return [""] if len(results) == 1 else [f"result {i + 1}" for i in range(len(results))]
    if isinstance(labels, str) or len(labels) != len(results):
        raise InputError(
            f"must hold one text a result, got {labels!r} for {len(results)}",
            argument="labels",
            value=labels,
        )
    return list(labels)


def load_text(result: ContactResult) -> str:
    """Return the load of a result for a title."""
    return engineering(result.load, result.pair.load_unit, 3)


def doubt(result: ContactResult | ElastoplasticResult) -> str:
    """Return what a title adds where a result is not to be trusted."""
    return "" if result.converged else " (NOT CONVERGED)"
