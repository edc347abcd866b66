"""The linked maps hold the numbers of the result; no browser is needed to see that."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from PIL import Image

import roughcontact as rc

pytest.importorskip("panel")

from roughcontact.desk import rasters
from roughcontact.desk.maps import GAP, HEIGHTS, PRESSURE, RESIDUAL, TOUCH, MapsView
from roughcontact.desk.rasters import Box

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)


@pytest.fixture(scope="module")
def surface():
    heights = np.random.default_rng(1).normal(0, 40e-9, (30, 60))
    return rc.Surface(heights, (1e-6, 1e-6))


@pytest.fixture(scope="module")
def results(surface):
    return [rc.solve(surface, load=load, material=STEEL) for load in (0.2, 0.6)]


def test_the_sources_hold_the_numbers_of_the_result(surface, results):
    shown = MapsView()
    shown.show_contact(surface, results[0])
    data = shown.sources[PRESSURE].data
    pressure = np.nan_to_num(data[PRESSURE][0]) / 1e3
    np.testing.assert_allclose(pressure, results[0].pressure * 1e-12, rtol=1e-6)
    assert data["display"][0]["unit"] == "GPa"
    gap = np.where(results[0].contact, np.nan, results[0].gap)
    np.testing.assert_allclose(shown.sources[GAP].data[GAP][0], gap * 1e9, rtol=1e-5)
    heights = (surface.heights - surface.heights.mean()) * 1e9
    np.testing.assert_allclose(
        shown.sources[HEIGHTS].data[HEIGHTS][0], heights, rtol=1e-4, atol=1e-4
    )
    place = [data[name][0] for name in ("x", "y", "dw", "dh")]
    assert place == pytest.approx([0, 0, 60, 30])


def test_another_result_keeps_heights(surface, results):
    shown = MapsView()
    shown.show_contact(surface, results[0])
    heights, pressure = (shown.sources[key].data for key in (HEIGHTS, PRESSURE))
    shown.show_contact(surface, results[1])
    assert shown.sources[HEIGHTS].data is heights
    assert shown.sources[PRESSURE].data is not pressure
    assert "largest 3 GPa" in shown.plot.title.text


def test_title_names_body_of_heights(surface, results):
    shown = MapsView()
    shown.show_contact(surface, results[0])
    title = shown.plot.title
    shown.enlarge(HEIGHTS)
    assert title.text.startswith("Heights, Sq")
    both = rc.solve(surface, load=0.2, material=STEEL, counter_surface=surface)
    shown.show_contact(surface, both)
    assert title.text.startswith("Heights of the body, Sq")
    shown.clear()
    assert title.text == "Heights"


def test_the_view_stays_while_the_map_keeps_its_size(surface, results):
    shown = MapsView()
    shown.show_contact(surface, results[0])
    shown.zoom(Box(5e-6, 10e-6, 15e-6, 30e-6))
    seen = shown.seen
    shown.show_contact(surface.leveled(), results[1])
    assert shown.seen == seen
    shown.show_contact(surface.cropped((0, 20), (0, 20)), None)
    assert shown.seen.right == pytest.approx(20e-6)


@pytest.mark.long
@pytest.mark.parametrize("box", [None, Box(5e-6, 10e-6, 15e-6, 30e-6), Box(0, 0, 29e-6, 3e-6)])
def test_maps_are_true_to_scale_and_show_all_of_the_box(surface, box):
    shown = MapsView()
    shown.show_contact(surface)
    shown.zoom(box)
    wide = shown.x_range.end - shown.x_range.start
    tall = shown.y_range.start - shown.y_range.end
    assert tall > 0  # row 0 is at the top
    frame = shown.plot
    assert wide / tall == pytest.approx(frame.frame_width / frame.frame_height)
    wanted, seen = box or rasters.box_of(surface), shown.seen
    assert seen.left <= wanted.left + 1e-12
    assert seen.right >= wanted.right - 1e-12


def test_moved_ranges_show_their_points(results, surface):
    shown = MapsView()
    shown.show_contact(surface, results[0])
    shown.x_range.update(start=20, end=30)
    shown.y_range.update(start=18, end=10)
    result = shown.sources[HEIGHTS].data["display"][0]
    assert result["cell"] == [1, 1]
    left, top = (
        round(shown.sources[PRESSURE].data["x"][0]),
        round(shown.sources[PRESSURE].data["y"][0]),
    )
    ny, nx = shown.sources[PRESSURE].data[PRESSURE][0].shape
    assert left <= 20 <= 30 <= left + nx
    assert top <= 10 <= 18 <= top + ny
    part = results[0].pressure[top : top + ny, left : left + nx]
    np.testing.assert_allclose(
        np.nan_to_num(shown.sources[PRESSURE].data[PRESSURE][0]), part * 1e-9, rtol=1e-6
    )


def test_missing_maps_are_hidden(surface, results):
    shown = MapsView()
    shown.show_contact(surface, results[0])
    shown.show_contact(surface, None)
    assert shown.sources[PRESSURE].data[PRESSURE] == []
    assert shown.plot.title.text.startswith("Heights, Sq")
    assert len(shown.sources[HEIGHTS].data[HEIGHTS]) == 1
    shown.clear()
    assert shown.sources[HEIGHTS].data[HEIGHTS] == []


def test_a_contact_without_a_ceiling_leaves_nothing(surface):
    elastic = rc.solve(surface, load=0.1, material=rc.Material(210e9, 0.3))
    shown = MapsView()
    shown.show_contact(surface, elastic)
    shown.enlarge(RESIDUAL)
    assert shown.plot.title.text == "Residual indentation, none"
    assert np.isnan(shown.sources[RESIDUAL].data[RESIDUAL][0]).all()
    shown.enlarge(TOUCH)
    assert "saturated" not in shown.plot.title.text


@pytest.mark.long
def test_a_profile_has_no_maps(surface):
    shown = MapsView()
    shown.show_contact(rc.Surface(surface.heights[:1], (1.0, 1e-6)))
    assert not shown.root.visible
    shown.show_contact(surface)
    assert shown.root.visible


def test_one_map_is_large_and_all_are_small(surface, results):
    shown = MapsView()
    shown.show_contact(surface, results[0])
    for key in (GAP, HEIGHTS, TOUCH):
        shown.enlarge(key)
        drawn = shown.plot.renderers
        seen = [name for name, layers in shown._layers.items() if any(x in drawn for x in layers)]
        assert seen == [key]
    for key, address in zip(shown.sources, shown.strip.pictures, strict=True):
        data = base64.b64decode(address.partition(",")[2])
        picture = np.asarray(Image.open(io.BytesIO(data)))
        assert picture.shape == (30, 60, 4), key
    pressure = np.asarray(
        Image.open(io.BytesIO(base64.b64decode(shown.strip.pictures[1].partition(",")[2])))
    )
    np.testing.assert_array_equal(pressure[..., 3] == 0, ~results[0].contact)
