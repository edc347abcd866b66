"""The Contact-Mechanics Challenge: its parameters, its grids, and the page that shows it."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import challenge

STORED = json.loads(challenge.STORED.read_text(encoding="utf-8"))


def test_moments_of_a_wave_are_closed_forms() -> None:
    side, amplitude, waves = 3.0, 0.1, 4
    q = 2 * math.pi * waves / side
    line = amplitude * np.cos(q * np.arange(64) * side / 64)
    height, gradient, radius = challenge.moments(np.tile(line, (64, 1)), side)
    assert height == pytest.approx(amplitude / math.sqrt(2))
    assert gradient == pytest.approx(q * amplitude / math.sqrt(2))
    assert 1 / radius == pytest.approx(math.sqrt(3 / 16) * q**2 * amplitude)


def test_finer_grids_are_of_one_body() -> None:
    heights = challenge.rc.self_affine(
        32,
        1 / 32,
        rms_height=0.1,
        rolloff_wavelength=0.5,
        cutoff_wavelength=0.1,
        rng=np.random.default_rng(1),
    )
    finer = challenge.sampled(heights, 64)
    np.testing.assert_allclose(finer[::2, ::2], heights, atol=1e-14)
    np.testing.assert_allclose(challenge.sampled(finer, 32), heights, atol=1e-14)
    before, after = (challenge.moments(values, 1.0) for values in (heights, finer))
    assert after == pytest.approx(before)


def test_parameters_follow_from_each_other() -> None:
    assert STORED["gradient"] == pytest.approx(1)
    assert STORED["tabor"] == pytest.approx(3, rel=2e-3)
    assert STORED["Sq"] == pytest.approx(0.765e-6, rel=0.01)


def test_page_matches_stored_results() -> None:
    assert challenge.page(STORED) in challenge.PAGE.read_text(encoding="utf-8")
    for name, (low, high) in STORED["limits"].items():
        assert low <= STORED["grids"][-1][name] <= high or name == "contact"
