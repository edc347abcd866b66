"""What is said first of a height map."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.report import inputs


@pytest.mark.parametrize(
    ("tilt", "texture"),
    # Straight grooves leave the map: Str is not determined, and at most small.
    [(0.0, "Directional"), (1.0, "Isotropic")],
)
def test_a_lay_that_leaves_the_map_is_directional(tilt: float, texture: str) -> None:
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:96, :96]
    waves = sum(
        np.sin(2 * np.pi * (k * x + tilt * j * y) / 96 + rng.uniform(0, 6))
        for k in range(-9, 10)
        for j in (range(-9, 10) if tilt else (0,))
        if k
    )
    values = rc.Surface(1e-7 * waves, (1e-6, 1e-6)).roughness()
    assert np.isnan(values["Str"]) == (not tilt)
    assert inputs._character(values).startswith(texture)
