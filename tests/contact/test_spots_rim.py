"""Contact area of circles of few pixels: as counted, and without the excess of the rim."""

import math

import numpy as np
import pytest

import roughcontact as rc

BODY = rc.Material(1.0, 0.0)
RADIUS = 1000.0


@pytest.mark.parametrize(("pixels", "counted", "corrected"), [(3, 0.08, -0.025), (8, 0.03, -0.01)])
def test_errors_are_those_that_are_stated(pixels: int, counted: float, corrected: float) -> None:
    points, area = 3 * pixels + 6, math.pi * pixels**2
    found = []
    # The place of the circle on the grid matters; nine places stand for all.
    for down in np.linspace(0, 0.5, 3):
        for right in np.linspace(0, 0.5, 3):
            y = (np.arange(points) - points / 2 + down)[:, np.newaxis]
            x = np.arange(points) - points / 2 + right
            ball = rc.Surface(-(y**2 + x**2) / 2 / RADIUS, (1.0, 1.0))
            load = 4 / 3 * pixels**3 / RADIUS
            result = rc.solve(ball, load=load, material=BODY, ceiling=None)
            found.append(
                (result.contact_area / area - 1, result.perimeter_corrected_area / area - 1)
            )
    means = np.mean(found, axis=0)
    assert means == pytest.approx((counted, corrected), abs=0.004)
