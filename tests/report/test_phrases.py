"""Phrases that reports share."""

import math
import re
from types import SimpleNamespace

import pytest

import roughcontact as rc
from roughcontact.report import phrases


def test_load_of_line_contact_is_a_force_per_length() -> None:
    modulus, radius, peak = 210e9 / 0.91, 5e-3, 0.5e9
    roller = rc.cylinder(radius, shape=(64, 8), pixel=(2e-6, 5e-6))
    result = rc.solve(
        roller, material=rc.Material(210e9, 0.3), load="hertz 0.5 GPa", boundary="periodic-x"
    )
    # p₀² = w E*/(π R)
    expected = 1e-3 * math.pi * radius * peak**2 / modulus
    _, cells = phrases.load_column(result, [result.load])
    question = phrases.load_range(SimpleNamespace(largest=result, steps=[result]))
    for text in (phrases.load(result), question, *cells):
        assert float(re.search(r"([\d.]+) N/mm", text)[1]) == pytest.approx(expected, rel=0.002)
    assert phrases.problem_of_loads(result, [result.load / 2, result.load]).count("N/mm") == 1
