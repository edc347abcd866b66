"""Distributions, spots, curves and stress on the page hold the numbers of what they show."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")

from roughcontact.analyses.solve.fields import CONTACT
from roughcontact.desk import analysis_jobs
from roughcontact.desk.detail_panel import SpectrumPlot, SpotTable, box_around, list_spots
from roughcontact.desk.result_plots import ComparisonView, LoadCurveView
from roughcontact.report.kind import quantity_of
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


def test_a_load_curve_and_the_load_now(surface):
    curve = rc.sweep(surface, material=STEEL, loads=[0.1, 0.3, 1.0])
    shown = LoadCurveView()
    shown.mark(0.3)
    shown.show_result(curve)
    data = shown.source.data
    np.testing.assert_allclose(data["load"], [0.1, 0.3, 1.0])
    share = 100 * curve.column("contact_area") / curve.nominal_area
    np.testing.assert_allclose(data["contact"], share)
    assert shown.now.location == pytest.approx(data["load"][1])
    assert shown.now.visible
    shown.mark(0.0)
    assert not shown.now.visible


def test_file_name_is_escaped():
    from roughcontact.desk import style

    assert "<img" not in style.color_patch("#000000", "<img src=x>")
    model = style.make_markup()
    style.set_markup(model, style.color_patch("#000000", "<img src=x>"))
    assert "&lt;img" not in model.text  # escaped once more on the way
    assert "&amp;lt;img" in model.text


def test_two_contacts_and_their_difference_are_zoomed_together(result):
    other = rc.solve(result.surface, load=2 * result.load, material=result.material)
    shown = ComparisonView(("this", "pinned"))
    shown.show_contacts((result, other))
    first, second, change, _ = (source.data["pressure"][0] for source in shown.sources)
    np.testing.assert_allclose(np.nan_to_num(first), result.pressure * 1e-9, rtol=1e-6)
    np.testing.assert_allclose(np.nan_to_num(second), other.pressure * 1e-9, rtol=1e-6)
    np.testing.assert_allclose(
        np.nan_to_num(change), (result.pressure - other.pressure) * 1e-9, rtol=1e-5, atol=1e-6
    )
    assert all(plot.x_range is shown.plots[0].x_range for plot in shown.plots)
    assert shown.plots[2].visible
    for percent, columns in ((50, 24), (0, 48), (100, 1)):
        shown.swipe.value = percent
        data = shown.swiped.data
        np.testing.assert_array_equal(data["pressure"][0], second[:, 48 - columns :])
        assert shown.edge.location == data["x"][0] == pytest.approx(48 - columns)
    change_of = {
        key: analysis_jobs._quantity_change(quantity_of(CONTACT, key), result, other)
        for key in ("load", "status")
    }
    assert change_of == {"load": ("−1 N", "−50.0 %"), "status": ("", "")}
    coarse = rc.solve(
        rc.Surface(result.surface.heights[::2, ::2], (4e-6, 2e-6)),
        load=result.load,
        material=result.material,
    )
    shown.show_contacts((result, coarse))
    assert not shown.plots[2].visible
