"""A section holds the values of the points that its line crosses."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")

from roughcontact.desk.detail_panel import SectionPlot, bodies_on_line, points_on_line, whole_line
from roughcontact.drawing.style import SATURATED

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)
PIXEL = (2e-6, 1e-6)


@pytest.fixture(scope="module")
def surface():
    return rc.Surface(np.random.default_rng(1).normal(0, 40e-9, (20, 40)), PIXEL)


@pytest.fixture(scope="module")
def result(surface):
    return rc.solve(surface, load=0.5, material=STEEL)


@pytest.fixture(scope="module")
def two_bodies(surface):
    return rc.solve(surface, load=0.5, material=STEEL, counter_material=rc.Material(70e9, 0.33))


def test_a_row_is_a_row(result, surface):
    where = points_on_line(surface, (7e-6, 0, 7e-6, 40e-6))
    found = bodies_on_line(result, where)
    np.testing.assert_array_equal(found.pressure, result.pressure[3])
    np.testing.assert_array_equal(found.gap, result.gap[3])
    np.testing.assert_array_equal(found.saturated, result.saturated[3])
    np.testing.assert_allclose(where.place, (np.arange(40) + 0.5) * 1e-6)


@pytest.mark.parametrize("line", [(1e-6, 2e-6, 39e-6, 37e-6), (30e-6, 39e-6, 0, 0)])
def test_an_oblique_line_has_the_values_of_the_nearest_points(result, surface, line):
    where = points_on_line(surface, line)
    assert where.step <= min(PIXEL) * (1 + 1e-9)
    along = where.place / np.hypot(line[2] - line[0], line[3] - line[1])
    y = line[0] + (line[2] - line[0]) * along
    x = line[1] + (line[3] - line[1]) * along
    assert np.abs((where.rows + 0.5) * PIXEL[0] - y).max() <= PIXEL[0] / 2 * (1 + 1e-9)
    assert np.abs((where.columns + 0.5) * PIXEL[1] - x).max() <= PIXEL[1] / 2 * (1 + 1e-9)
    np.testing.assert_array_equal(
        bodies_on_line(result, where).pressure, result.pressure[where.rows, where.columns]
    )


def test_a_rigid_counter_body_stays_flat(result, surface):
    upper = bodies_on_line(result, points_on_line(surface, (1e-6, 2e-6, 39e-6, 37e-6))).upper
    assert np.ptp(upper) < 1e-14


def test_each_body_gives_way_by_its_compliance(two_bodies, surface):
    where = points_on_line(surface, (7e-6, 0, 7e-6, 40e-6))
    found = bodies_on_line(two_bodies, where)
    np.testing.assert_allclose(found.upper - found.lower, found.gap, atol=1e-18)
    before = surface.heights[3] - surface.heights.mean()
    down, up = before - found.lower, found.upper - found.upper.mean()
    ratio = two_bodies.counter_material.compliance / two_bodies.material.compliance
    np.testing.assert_allclose(up, (down - down.mean()) * ratio, atol=1e-15)


def test_the_sources_hold_the_numbers(result, surface):
    shown = SectionPlot()
    shown.show_section(surface, result, (7e-6, 0, 7e-6, 40e-6))
    data = shown.source.data
    np.testing.assert_allclose(data["gap"], result.gap[3] * 1e9)
    np.testing.assert_allclose(data["pressure"], result.pressure[3] * 1e-9)
    touching = result.pressure[3] > 0
    assert shown.bars.data["top"].size == touching.sum()
    marked = shown.bars.data["colour"] == SATURATED
    np.testing.assert_array_equal(marked, result.saturated[3][touching])
    assert "nearest" not in shown.heights.title.text
    shown.show_section(surface, None, (0, 0, 40e-6, 40e-6))
    assert "nearest" in shown.heights.title.text
    assert shown.bars.data["top"].size == 0
    assert not shown.pressure.visible
    shown.clear()
    assert len(shown.source.data["gap"]) == 0


def test_a_profile_has_one_section(surface):
    profile = rc.Surface(surface.heights[:1], (1.0, 1e-6))
    line = whole_line(profile)
    result = rc.solve(profile, load=1e3, material=STEEL)
    shown = SectionPlot()
    shown.show_section(profile, result, line)
    np.testing.assert_allclose(shown.source.data["gap"], result.gap[0] * 1e9)
    assert "nearest" not in shown.heights.title.text


def test_initial_line_passes_through_summit(surface):
    row = np.argmax(surface.heights.max(axis=1))
    assert whole_line(surface) == pytest.approx((2e-6 * (row + 0.5), 0, 2e-6 * (row + 0.5), 40e-6))
