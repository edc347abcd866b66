"""Line and box that the user drags on the maps."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")

from bokeh.events import DoubleTap

from roughcontact.desk.maps import PRESSURE, MapsView
from roughcontact.desk.rasters import Box

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)


@pytest.fixture
def maps():
    shown = MapsView()
    shown.show_contact(rc.Surface(np.random.default_rng(1).normal(0, 1e-9, (30, 60)), (1e-6, 1e-6)))
    return shown


def test_dragging_an_end_reports_section_line(maps):
    messages = []
    maps.section.set_listener(messages.append)
    maps.section.set_line((10e-6, 10e-6, 20e-6, 50e-6))
    assert messages == []
    assert maps.section.source.data["x"] == pytest.approx([10, 50])
    end = maps.section.ends[1]
    half = (end.right - end.left) / 2
    end.update(left=40 - half, right=40 + half)
    assert messages[-1] == pytest.approx((10e-6, 10e-6, 20e-6, 40e-6))
    assert maps.section.line == messages[-1]


def test_ends_stay_on_the_map(maps):
    maps.section.set_line((-1.0, 10e-6, 20e-6, 1.0))
    assert maps.section.line == pytest.approx((0, 10e-6, 20e-6, 60e-6))
    maps.section.set_line(None)
    assert not any(end.visible for end in maps.section.ends)


def test_zooming_keeps_the_line_and_the_size_of_its_handles(maps):
    messages = []
    maps.section.set_listener(messages.append)
    maps.section.set_line((10e-6, 10e-6, 20e-6, 50e-6))
    end = maps.section.ends[0]
    before = end.right - end.left
    maps.zoom(Box(5e-6, 5e-6, 20e-6, 35e-6))
    assert end.right - end.left == pytest.approx(before / 2)
    assert maps.section.line == pytest.approx((10e-6, 10e-6, 20e-6, 50e-6))
    assert messages == []


def test_drawn_box_selects_rows_and_columns_of_the_map(maps):
    maps.crop.update(left=10.2, right=40.0, top=-5.0, bottom=20.2, visible=True)
    assert maps.cropped == ((0, 20), (10, 40))
    # Another map has no box.
    maps.show_contact(rc.Surface(np.zeros((30, 40)), (1e-6, 1e-6)))
    assert not maps.crop.visible


def test_dragged_color_limits_stay_until_their_bar_is_double_clicked(maps):
    surface = maps.surface
    results = [rc.solve(surface, load=load, material=STEEL) for load in (0.2, 0.6)]
    maps.show_contact(surface, results[0])
    mapper, whole = maps.mappers[PRESSURE], maps.mappers[PRESSURE].high
    assert "beyond the scale" not in maps.legend.text
    # The change comes from the browser.
    mapper.high = whole / 4
    assert "beyond the scale" in maps.legend.text
    # No number is on another line than its unit.
    assert " %" not in maps.legend.text
    assert max(maps.bars[PRESSURE].ticker.ticks) <= whole / 4
    maps.show_contact(surface, results[1])
    assert mapper.high == pytest.approx(whole / 4)
    maps.plot._trigger_event(DoubleTap(maps.plot, x=maps.x_range.end + 1, y=0))
    assert mapper.high > whole
    assert "beyond the scale" not in maps.legend.text
