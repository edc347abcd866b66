"""Stress under partial slip against closed forms: Cattaneo and Mindlin, Hamilton, Johnson."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hamilton import at_the_rim, sliding_sphere
from roughcontact.halfspace import stress, stress_summary

FRICTION = 0.5


def partial_slip(radius: float, part: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return offsets (y, x), pressure and traction of a sphere under Q = part μP, in pixels.

    Cattaneo 1938, Mindlin 1949: the traction of sliding, less the same of a smaller circle.
    """
    points = int(2.4 * radius)
    y, x = np.mgrid[:points, :points] - (points - 1) / 2
    offsets = np.stack([y + 0.2, x - 0.3])
    r, inner = np.hypot(*offsets), radius * (1 - part) ** (1 / 3)
    pressure, smaller = (np.sqrt(np.maximum(1 - (r / edge) ** 2, 0)) for edge in (radius, inner))
    traction = FRICTION * (pressure - inner / radius * smaller)
    return offsets, pressure, np.stack([0 * traction, traction])


def exact(x: np.ndarray, y: np.ndarray, z: float, part: float, poisson: float) -> np.ndarray:
    """Return the stress below it, lengths in contact radii."""
    inner = (1 - part) ** (1 / 3)
    at = x / inner, y / inner, z / inner, poisson
    stuck = sliding_sphere(*at, FRICTION) - sliding_sphere(*at, 0.0)
    return sliding_sphere(x, y, z, poisson, FRICTION) - inner * stuck


def test_depth_below_a_sphere_that_sticks_in_its_middle() -> None:
    radius, part = 40.0, 0.6
    (y, x), pressure, traction = partial_slip(radius, part)
    for depth in (0.2, 0.5):
        found = next(stress.slices(pressure, (1.0, 1.0), [depth * radius], 0.3, traction=traction))
        expected = exact(x / radius, y / radius, depth, part, 0.3)
        np.testing.assert_allclose(found.stress, expected, atol=1e-3)


@pytest.mark.parametrize(
    ("radius", "part", "error"),
    # The rim of slip is 21, 11, 5 and 2 pixels wide. Pixel centers alone are 11 to 26 % low.
    [(40.0, 0.9, 0.01), (40.0, 0.6, 0.01), (20.0, 0.6, 0.08), (20.0, 0.3, 0.08)],
)
@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_the_largest_tension_is_at_the_trailing_edge(
    poisson: float, radius: float, part: float, error: float
) -> None:
    (y, x), pressure, traction = partial_slip(radius, part)
    found = stress_summary.summarize(pressure, (1.0, 1.0), poisson, depths=[0.0], traction=traction)
    # The smaller circle does not reach the edge; at the edge Hamilton's form has its limit.
    sliding = exact(np.array(-1.0), np.array(1e-9), 1e-9, part, poisson)
    sliding -= sliding_sphere(-1.0, 1e-9, 1e-9, poisson, FRICTION)
    along, across = np.array(at_the_rim(poisson, FRICTION)) + sliding[:2]
    assert found.max_tension == pytest.approx(along, rel=error)
    assert found.von_mises[0] == pytest.approx(math.hypot(along - across / 2, across * 0.75**0.5),
                                               rel=error)  # fmt: skip
    place = x[found.tension_pixel], y[found.tension_pixel]
    assert math.atan2(place[1], -place[0]) == pytest.approx(0, abs=0.5)
    assert math.hypot(*place) == pytest.approx(radius, abs=1.5)


@pytest.mark.parametrize("part", [0.2, 0.7])
def test_a_cylinder_that_sticks_in_its_middle(part: float) -> None:
    """σ_xx at the surface is 2μp₀ √(Q/μP) at the trailing edge (Johnson 1985, sec. 7.5)."""
    radius, inner = 400.0, 400.0 * math.sqrt(1 - part)
    x = np.arange(1001) - 500.0
    pressure, smaller = (np.sqrt(np.maximum(1 - (x / edge) ** 2, 0)) for edge in (radius, inner))
    traction = FRICTION * (pressure - inner / radius * smaller)
    found = next(
        stress.slices(pressure[None], (1.0, 1.0), [0.0], 0.3, boundary="periodic-y",
                      traction=[0 * traction[None], traction[None]], precision="double")
    )  # fmt: skip

    def spread(edge: float) -> np.ndarray:
        """Return σ_xx under the traction of sliding on a strip of half this width."""
        beyond = np.sqrt(np.maximum((x / edge) ** 2 - 1, 0))
        return -2 * FRICTION * (x / edge - np.sign(x) * beyond)

    expected = spread(radius) - inner / radius * spread(inner) - pressure
    # Next to an edge pixels are too wide.
    apart = [np.abs(np.abs(x) - edge) > 2 for edge in (radius, inner)]
    away = np.all(apart, axis=0)
    np.testing.assert_allclose(found.stress[0, 0, away], expected[away], atol=0.01)
    assert expected.max() == pytest.approx(2 * FRICTION * math.sqrt(part), rel=0.01)
    largest = stress_summary.summarize(
        pressure[None], (1.0, 1.0), 0.3, boundary="periodic-y", depths=[0.0],
        traction=[0 * traction[None], traction[None]],
    )  # fmt: skip
    # The pixel next to the edge is half a pixel away from the cusp.
    assert -0.08 < largest.max_tension / (2 * FRICTION * math.sqrt(part)) - 1 < 0
    assert x[largest.tension_pixel[1]] == pytest.approx(-radius, abs=2)
