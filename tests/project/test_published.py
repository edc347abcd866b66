"""The comparison with published results: its arithmetic, its cheap rows, its page."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import published


def test_rows_agree_where_intervals_overlap() -> None:
    row = published.Row("set-up", "source", (1.0, 2.0), (2.0, 3.0))
    assert row.agrees
    assert not published.Row("set-up", "source", (1.0, 2.0), (2.1, 3.0)).agrees
    assert published.refinement_interval(lambda points: 1 + 1 / points, 4) == pytest.approx(
        (1.0, 1.5)
    )
    assert published.mean_interval([1.0, 2.0, 3.0]) == pytest.approx(
        (2 - 3**-0.5 * 2, 2 + 3**-0.5 * 2)
    )


def test_gradient_of_a_wave_is_a_closed_form() -> None:
    side, amplitude, count = 3.0, 0.1, 4
    q = 2 * math.pi * count / side
    line = amplitude * np.cos(q * np.arange(64) * side / 64)
    gradient = published.gradient_of(np.tile(line, (64, 1)), side)
    assert gradient == pytest.approx(q * amplitude / math.sqrt(2))


@pytest.mark.parametrize(
    ("name", "difference"), [("hertz", 1e-4), ("westergaard", 5e-3), ("mindlin", 1e-3)]
)
def test_closed_forms_are_met(name: str, difference: float) -> None:
    for row in published.ROWS[name]():
        assert sum(row.found) == pytest.approx(sum(row.published), rel=difference)


def test_page_contains_all_rows() -> None:
    text = published.PAGE.read_text(encoding="utf-8")
    names = re.findall(r"^\| `(\w+)`, [\d.]+ s \|", text, re.MULTILINE)
    assert list(dict.fromkeys(names)) == list(published.ROWS)
    assert len(names) >= 12
