"""Spots, spectrum and texture on the page hold the numbers of what they show."""

from __future__ import annotations

import re

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")

from roughcontact.desk import detail_panel
from roughcontact.surface.spectrum import radial_spectrum

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)


@pytest.fixture(scope="module")
def surface():
    return rc.Surface(np.random.default_rng(1).normal(0, 40e-9, (32, 48)), (2e-6, 1e-6))


@pytest.fixture(scope="module")
def result(surface):
    return rc.solve(surface, load=1.0, material=STEEL, boundary="periodic")


def test_spectrum_matches_surface(surface):
    (axes,) = detail_panel.draw_spectrum(surface).axes
    q, power, _ = radial_spectrum(surface.heights, surface.pixel)
    drawn = axes.lines[0].get_xydata()
    np.testing.assert_array_equal(drawn, np.column_stack([q, power])[power > 0])


@pytest.mark.long
def test_texture_of_a_map_with_missing_points_states_what_the_spectrum_needs(surface):
    heights = surface.heights.copy()
    heights[3, 4] = np.nan
    text = detail_panel.surface_texture(rc.Surface(heights, surface.pixel))
    assert "without missing points" in text
    assert text.count('<img class="figure"') == 1


def cells_of(text: str) -> list[list[str]]:
    rows = re.findall("<tr>(.*?)</tr>", text)
    return [re.findall("<t[hd]>(.*?)</t[hd]>", row) for row in rows]


def test_the_table_of_spots_has_their_numbers(result):
    spots = result.spots()
    heads, *rows = cells_of(detail_panel.spot_table(result))
    assert heads[1:3] == ["area [µm²]", "load [mN]"]
    assert len(rows) == min(spots.count, 100)
    for number in (0, len(rows) // 2, len(rows) - 1):
        first, *values = rows[number]
        area, load, peak, saturated, y, x = map(float, values)
        assert first == str(number + 1)
        assert area == pytest.approx(1e12 * spots.area[number], rel=1e-3)
        assert load == pytest.approx(1e3 * spots.load[number], rel=1e-3)
        mask = spots.label == number + 1
        row, column = int(y / 2), int(x)
        assert mask[row, column]
        assert result.pressure[row, column] == spots.peak[number]
        assert peak == pytest.approx(1e-9 * spots.peak[number], rel=1e-3)
        assert saturated == pytest.approx(100 * result.saturated[mask].mean(), rel=1e-3)
