"""Spots and spectrum on the page hold the numbers of what they show."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")


from roughcontact.desk.detail_panel import SpectrumPlot, SpotTable, box_around, list_spots
from roughcontact.surface.roughness import radial_spectrum

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)


@pytest.fixture(scope="module")
def surface():
    return rc.Surface(np.random.default_rng(1).normal(0, 40e-9, (32, 48)), (2e-6, 1e-6))


@pytest.fixture(scope="module")
def result(surface):
    return rc.solve(surface, load=1.0, material=STEEL, boundary="periodic")


def test_spectrum_matches_surface_or_states_requirement(surface):
    shown = SpectrumPlot()
    shown.show_surface(surface)
    q, power, _ = radial_spectrum(surface.heights, surface.pixel)
    np.testing.assert_array_equal(shown.source.data["q"], q)
    np.testing.assert_array_equal(shown.source.data["C"], power)
    heights = surface.heights.copy()
    heights[3, 4] = np.nan
    shown.show_surface(rc.Surface(heights, surface.pixel))
    assert len(shown.source.data["q"]) == 0
    assert "fill them" in shown.note.text


def test_the_table_of_spots_has_their_numbers(result):
    spots, found = result.spots(), list_spots(result)
    np.testing.assert_array_equal(found.area, spots.area)
    np.testing.assert_array_equal(found.load, spots.load)
    for number in (0, spots.count // 2, spots.count - 1):
        mask = spots.label == number + 1
        row, column = int(found.y[number] / 2e-6), int(found.x[number] / 1e-6)
        assert mask[row, column]
        assert result.pressure[row, column] == found.peak[number]
        assert found.saturated[number] == pytest.approx(result.saturated[mask].mean())
    assert list_spots(result, 3).area.size == 3


def test_choosing_a_row_shows_its_spot(result):
    shown, told = SpotTable(), []
    shown.set_spot_listener(told.append)
    shown.show_result(result)
    shown.source.selected.indices = [2]
    found = list_spots(result)
    assert told[-1] == box_around(result, 2)
    assert told[-1].top < found.y[2] < told[-1].bottom
    assert told[-1].left < found.x[2] < told[-1].right
    areas = shown.source.data["area"]
    np.testing.assert_allclose(areas, found.area * 1e12, rtol=1e-3)
    shown.clear()
    assert len(told) == 1


def test_a_spot_across_an_edge_is_shown_at_its_peak():
    heights = np.full((16, 16), -1e-6)
    heights[4:7, [0, 15]] = 0
    heights[5, 0] = 1e-8
    flat = rc.Surface(heights, (1e-6, 1e-6))
    result = rc.solve(flat, load=0.05, material=rc.Material(210e9, 0.3), boundary="periodic")
    assert result.spots().count == 1
    box = box_around(result, 0)
    assert (box.left + box.right) / 2 == pytest.approx(list_spots(result).x[0])
    assert box.right - box.left < 30e-6
