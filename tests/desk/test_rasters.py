"""Rasters of the page: values of cells and areas are those of the map."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from hypothesis import given, strategies as st
from PIL import Image

import roughcontact as rc
from roughcontact.desk import rasters
from roughcontact.desk.rasters import Box
from roughcontact.drawing.style import ELASTIC, MISSING, OPEN, SATURATED

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)
PIXEL = (2e-6, 1e-6)


@pytest.fixture(scope="module")
def result():
    rng = np.random.default_rng(3)
    heights = rng.normal(0, 50e-9, (37, 50))
    surface = rc.Surface(heights, PIXEL)
    return rc.solve(surface, load=0.5, material=STEEL)


def all_of(result, dots):
    surface = result.surface
    return rasters.window_of(surface.shape, surface.pixel, rasters.box_of(surface), dots)


def bytes_of(colours):
    return np.ascontiguousarray(colours).view(np.uint8).reshape(*colours.shape, 4)


def rgb(colour):
    return [int(colour[i : i + 2], 16) for i in (1, 3, 5)]


def test_a_small_window_shows_the_points(result):
    view = rasters.window_of((37, 50), PIXEL, Box(10e-6, 5e-6, 30e-6, 20e-6), (100, 100))
    assert view.blocks == (1, 1)
    assert view.rows == (5, 15)
    assert view.columns == (5, 20)
    part = rasters.result_window(result, view)
    there = result.pressure[5:15, 5:20]
    np.testing.assert_array_equal(
        rasters.largest_pressure(part), np.where(there > 0, there, np.nan).astype(np.float32)
    )
    kept = result.residual_indentation[5:15, 5:20]
    np.testing.assert_array_equal(
        np.nan_to_num(rasters.deepest_residual(part)), kept.astype(np.float32)
    )
    shown = rasters.mean_heights(result.surface, view, 1e-9)
    np.testing.assert_array_equal(
        shown, (result.surface.heights[5:15, 5:20] - 1e-9).astype(np.float32)
    )


def test_window_includes_margin_within_map():
    seen = Box(20e-6, 10e-6, 40e-6, 30e-6)
    view = rasters.window_of((37, 50), PIXEL, seen, (1e3, 1e3), margin=0.5)
    assert (view.rows, view.columns) == ((5, 25), (0, 40))
    outside = rasters.window_of((37, 50), PIXEL, Box(1.0, 1.0, 2.0, 2.0), (9, 9))
    assert outside.shape == (1, 1)


@given(
    begin=st.floats(-0.5, 1.2),
    side=st.floats(0.01, 2),
    points=st.integers(1, 300),
    dots=st.integers(1, 400),
    moved=st.integers(0, 5),
)
def test_cells_are_dots_or_larger_and_stay_where_they_are(begin, side, points, dots, moved):
    seen = Box(begin * points, 0.0, (begin + side) * points, 1.0)
    view = rasters.window_of((points, 1), (1.0, 1.0), seen, (dots, 1))
    block = view.blocks[0]
    assert block >= side * points / dots * (1 - 1e-6)
    assert 0 <= view.rows[0] < view.rows[1] <= points
    assert view.rows[0] % block == 0
    shifted = Box(seen.top + moved, 0.0, seen.bottom + moved, 1.0)
    assert (rasters.window_of((points, 1), (1.0, 1.0), shifted, (dots, 1)).rows[0] % block) == 0


@pytest.mark.parametrize("dots", [(37, 50), (13, 17), (5, 5), (1, 1)])
def test_area_in_image_matches_contact_area(result, dots):
    view = all_of(result, dots)
    part = rasters.result_window(result, view)
    touching, saturated, missing = (shares.astype(float) for shares in rasters.contact_shares(part))
    rows, columns = (
        np.diff([*range(0, last, block), last])
        for (_, last), block in zip(view[:2], view.blocks, strict=True)
    )
    points = np.outer(rows, columns)
    assert (touching * points).sum() / points.sum() == pytest.approx(result.contact_fraction)
    assert (saturated * points).sum() / points.sum() == pytest.approx(result.saturated_fraction)
    assert not missing.any()
    colors = bytes_of(rasters.contact_colors(part)).astype(float)
    opacity = colors[..., 3:] / 255
    shown = opacity * colors[..., :3] + (1 - opacity) * rgb(OPEN)
    mean = (shown * points[..., None]).sum((0, 1))
    share = result.contact_fraction - result.saturated_fraction, result.saturated_fraction
    wanted = np.dot(
        [1 - sum(share), *share], [rgb(colour) for colour in (OPEN, ELASTIC, SATURATED)]
    )
    np.testing.assert_allclose(mean / points.sum(), wanted, atol=0.8)


@pytest.mark.parametrize("dots", [(37, 50), (7, 11)])
def test_no_peak_is_lost(result, dots):
    part = rasters.result_window(result, all_of(result, dots))
    assert np.nanmax(rasters.largest_pressure(part)) == np.float32(result.max_pressure)
    deepest = result.residual_indentation.max()
    assert np.nanmax(rasters.deepest_residual(part), initial=0) == np.float32(deepest)


def test_a_ceiling_that_differs_from_point_to_point_is_that_of_the_window(result):
    ceiling = np.full(result.pressure.shape, 3e9)
    ceiling[:, :20] = 1e9
    other = rc.solve(result.surface, load=0.5, material=STEEL, ceiling=ceiling)
    view = rasters.window_of((37, 50), PIXEL, Box(0, 15e-6, 74e-6, 30e-6), (1e3, 1e3))
    part = rasters.result_window(other, view)
    np.testing.assert_array_equal(part.saturated, other.saturated[:, 15:30])
    assert part.saturated.any()


def test_missing_points_have_their_colour():
    heights = np.random.default_rng(0).normal(0, 1e-8, (12, 12))
    heights[3:6, 3:6] = np.nan
    result = rc.solve(rc.Surface(heights, PIXEL).masked(), load=1e-3, material=STEEL)
    part = rasters.result_window(result, all_of(result, (4, 4)))
    assert bytes_of(rasters.contact_colors(part))[1, 1].tolist() == [*rgb(MISSING), 255]
    assert bytes_of(rasters.closed_colors(part))[1, 1].tolist() == [*rgb(MISSING), 255]
    assert rasters.contact_shares(part)[2][1, 1] == 1
    assert np.isnan(rasters.mean_heights(result.surface, all_of(result, (4, 4)), 0.0)[1, 1])


def test_cells_are_at_their_points():
    view = rasters.window_of((10, 10), PIXEL, Box(0, 0, 20e-6, 10e-6), (3, 3))
    assert view.blocks == (4, 4)
    assert rasters.window_extent(view, PIXEL) == pytest.approx((0, 0, 24e-6, 12e-6))


def test_a_thumbnail_is_small_and_has_the_colours_of_the_cells():
    from bokeh.models import LinearColorMapper

    mapper = LinearColorMapper(
        palette=["#000000", "#0000ff"], low=0, high=2, nan_color="#ff0000", high_color="#00ff00"
    )
    values = np.array([[0.0, 0.99, 1.0], [2.0, 2.1, np.nan]], np.float32)
    blue, black = [0, 0, 255], [0, 0, 0]
    found = bytes_of(rasters.map_colors(values, mapper))[..., :3]
    np.testing.assert_array_equal(found, [[black, black, blue], [blue, [0, 255, 0], [255, 0, 0]]])
    clear = LinearColorMapper(palette=["#000000"], low=0, high=2, nan_color=rasters.CLEAR)
    assert bytes_of(rasters.map_colors(values, clear))[1, 2].tolist() == [0, 0, 0, 0]
    # Cells of several points have another order in memory.
    many = np.asfortranarray(rasters.map_colors(np.full((900, 700), 2.0, np.float32), mapper))
    for sides, shape in (((9.0, 7.0), (160, 124)), ((9.0, 18.0), (80, 160))):
        data = base64.b64decode(rasters.thumbnail(many, sides).partition(",")[2])
        picture = np.asarray(Image.open(io.BytesIO(data)))
        assert picture.shape == (*shape, 4)
        assert (picture == [*blue, 255]).all()
