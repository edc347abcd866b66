"""All kinds of results: one row each."""

from __future__ import annotations

from typing import Any

from roughcontact.report import (
    comparison,
    conducted,
    contact,
    curve,
    estimated,
    found,
    inputs,
    lawful,
    leakage,
    rolling,
    steps,
    stress,
    studied,
    volume,
)
from roughcontact.report.kind import Kind

KINDS = (
    inputs.PROFILE_KIND,
    inputs.KIND,
    contact.PROFILE_KIND,
    contact.SHARED_KIND,
    contact.KIND,
    volume.KIND,
    rolling.KIND,
    stress.PROFILE_KIND,
    stress.KIND,
    curve.PROFILE_KIND,
    curve.KIND,
    steps.KIND,
    found.KIND,
    conducted.KIND,
    lawful.KIND,
    leakage.KIND,
    comparison.KIND,
    comparison.SAMPLING_KIND,
    studied.KIND,
    estimated.KIND,
)


def of(result: Any) -> Kind:
    """Return the kind of a result; `TypeError` for what is none."""
    for kind in KINDS:
        if isinstance(result, kind.result) and kind.when(result):
            return kind
    raise TypeError(f"there is no kind of results for a {type(result).__name__}")
