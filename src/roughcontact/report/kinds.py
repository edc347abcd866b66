"""All kinds of results: one row each."""

from __future__ import annotations

from typing import Any

from roughcontact.report import leakage
from roughcontact.report.kind import Kind

KINDS = (leakage.KIND,)


def of(result: Any) -> Kind | None:
    """Return the kind of a result."""
    return next((kind for kind in KINDS if isinstance(result, kind.result)), None)
