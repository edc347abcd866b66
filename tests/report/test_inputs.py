"""Headline of a height map."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.report import inputs
from roughcontact.report.kind import quantity_of
from roughcontact.units import format_engineering


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


def iso_parameters(heights: np.ndarray, spacing: float, cutoff: float) -> dict[str, float]:
    """Return P and R parameters by sums over dense weights, independent of the package.

    ISO 21920-2: Gaussian filter of ISO 16610-21, half a cutoff at each end left out, then five
    sections of one cutoff each.
    """
    x = spacing * np.arange(heights.size)
    z = heights - np.polyval(np.polyfit(x, heights, 1), x)
    alpha = np.sqrt(np.log(2) / np.pi)
    weights = np.exp(-np.pi * ((x[:, None] - x) / (alpha * cutoff)) ** 2)
    rough = z - weights @ z / weights.sum(axis=1)
    points = round(cutoff / spacing)
    first = (z.size - 5 * points) // 2
    rough = rough[first : first + 5 * points]
    rough = rough - rough.mean()
    sections = rough.reshape(5, points)
    return {
        "Pq": float(z.std()),
        "Pa": float(np.abs(z).mean()),
        "Pz": float(np.ptp(z)),
        "Pt": float(np.ptp(z)),
        "Pp": float(z.max()),
        "Pv": float(-z.min()),
        "Rq": float(rough.std()),
        "Ra": float(np.abs(rough).mean()),
        "Rsk": float((rough**3).mean() / rough.std() ** 3),
        "Rku": float((rough**4).mean() / rough.std() ** 4),
        "Rt": float(np.ptp(rough)),
        "Rz": float(np.ptp(sections, axis=1).mean()),
        "Rp": float(sections.max(axis=1).mean()),
        "Rv": float(-sections.min(axis=1).mean()),
    }


def test_filled_points_are_counted_in_the_row_of_missing_points() -> None:
    heights = np.random.default_rng(2).standard_normal((20, 20))
    heights[3:5, 4:7] = np.nan
    surface = rc.Surface(heights * 1e-7, (1e-6, 1e-6))
    row = quantity_of(inputs.SURFACE, "missing")
    assert row.row(surface).text.startswith("6 (")
    assert row.row(surface.filled()).text == "none left; 6 filled"


def test_profile_parameters_match_an_independent_computation() -> None:
    # 6.9 cutoffs of 80 µm: the sections are one cutoff each and leave the rest out.
    spacing, cutoff = 0.5e-6, 80e-6
    rng = np.random.default_rng(4)
    x = spacing * np.arange(1104)
    noise = np.convolve(rng.standard_normal(x.size + 20), np.hanning(21), "valid")
    heights = 1e-7 * noise + 2e-6 * np.sin(2 * np.pi * x / 300e-6) + 1e-3 * x
    surface = rc.Surface(heights, spacing).leveled()
    expected = iso_parameters(heights, spacing, cutoff)
    found = {**surface.roughness(), **inputs.filtered_parameters(surface)}
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-6), name
    headline = inputs.headline(inputs.measured_map(surface), "trace.txt")
    shown = "  ".join(cell for row in headline.rows for cell in row)
    for name in ("Rq", "Ra", "Rz", "Rt", "Pq", "Pa", "Pz", "Pt"):
        assert f"{name} {format_engineering(expected[name], 'm')}" in shown
