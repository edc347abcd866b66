"""A line and a box on the maps, as one drags them."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")

from bokeh.events import SelectionGeometry

from roughcontact.desk.maps import MapsView
from roughcontact.desk.rasters import Box


@pytest.fixture
def maps():
    shown = MapsView()
    shown.show_contact(rc.Surface(np.random.default_rng(1).normal(0, 1e-9, (30, 60)), (1e-6, 1e-6)))
    return shown


def test_dragging_an_end_reports_section_line(maps):
    told = []
    maps.section.set_listener(told.append)
    maps.section.set_line((10e-6, 10e-6, 20e-6, 50e-6))
    assert told == []
    assert maps.section.source.data["x"] == pytest.approx([10, 50])
    end = maps.section.ends[1]
    half = (end.right - end.left) / 2
    end.update(left=40 - half, right=40 + half)
    assert told[-1] == pytest.approx((10e-6, 10e-6, 20e-6, 40e-6))
    assert maps.section.line == told[-1]


def test_ends_stay_on_the_map(maps):
    maps.section.set_line((-1.0, 10e-6, 20e-6, 1.0))
    assert maps.section.line == pytest.approx((0, 10e-6, 20e-6, 60e-6))
    maps.section.set_line(None)
    assert not any(end.visible for end in maps.section.ends)


def test_zooming_keeps_the_line_and_the_size_of_its_handles(maps):
    told = []
    maps.section.set_listener(told.append)
    maps.section.set_line((10e-6, 10e-6, 20e-6, 50e-6))
    end = maps.section.ends[0]
    before = end.right - end.left
    maps.zoom(Box(5e-6, 5e-6, 20e-6, 35e-6))
    assert end.right - end.left == pytest.approx(before / 2)
    assert maps.section.line == pytest.approx((10e-6, 10e-6, 20e-6, 50e-6))
    assert told == []


def test_box_is_drawn_moved_and_removed(maps):
    told = []
    maps.crop.set_listener(told.append)
    plot = maps.plot
    geometry = {"type": "rect", "x0": 40.0, "x1": 10.0, "y0": -5.0, "y1": 20.2}
    plot._trigger_event(SelectionGeometry(plot, geometry=geometry, final=True))
    assert told[-1] == pytest.approx((0, 10e-6, 20.2e-6, 40e-6))
    assert maps.crop.frame.visible
    maps.crop.frame.update(left=12.0)
    assert told[-1] == pytest.approx((0, 12e-6, 20.2e-6, 40e-6))
    maps.crop.set_box(None)
    assert not maps.crop.frame.visible
    assert len(told) == 2
