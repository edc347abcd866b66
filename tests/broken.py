"""Operators that are wrong on purpose: what judges results has to see it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from roughcontact.halfspace import boundary


def replace_free(patch: pytest.MonkeyPatch, make: Callable[..., Any]) -> None:
    """Replace the operators of maps with free edges."""
    entry = boundary._MODELS[boundary.Boundary.FREE]
    wrong = entry._replace(operator=lambda *problem, datum, **options: make(*problem, **options))
    patch.setitem(boundary._MODELS, boundary.Boundary.FREE, wrong)
