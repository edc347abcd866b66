"""Bodies that tilt until the moments of the pressure balance those of the load."""

import math

import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Material(210e9, 0.3)
MODULUS = 210e9 / 0.91
SIDE = 64e-6


def grid(n: int) -> tuple[np.ndarray, tuple[float, float]]:
    return (np.arange(n) - (n - 1) / 2) * SIDE / n, (SIDE / n, SIDE / n)


@pytest.mark.parametrize("point", [(0.0, 0.0), (0.1, -0.2), (0.0, 0.3)])
def test_circular_punch_loaded_off_its_centre(point: tuple[float, float]) -> None:
    # Johnson 1985, eqs. 3.34 to 3.36: u = θ x under p = (2 E* θ/π) x/√(a² - r²), whose moment is
    # 4/3 E* a³ θ; added to W/(2πa √(a² - r²)) of the central load. Closed up to e = a/3.
    n, a, load = 129, 20e-6, 1.0
    x, pixel = grid(n)
    r = np.hypot(x[:, None], x)
    punch = rc.Surface(np.where(r <= a, 0.0, np.nan), pixel).masked()
    ey, ex = point[0] * a, point[1] * a
    result = rc.solve(punch, load=load, moments=(load * ey, load * ex), material=STEEL)
    assert result.moment_error <= 1e-8
    assert (result.contact == (r <= a)).all()
    # A load at positive x presses the gap shut there. The pixels of the rim make a circle that is
    # larger or smaller by some tenths of a pixel, 2.5 % of the radius: measured 0.15 %.
    angle = -3 * load / (4 * MODULUS * a**3)
    assert result.tilt == pytest.approx((angle * ey, angle * ex), rel=0.01, abs=1e-9)
    assert result.approach == pytest.approx(load / (2 * MODULUS * a), rel=0.01)
    inner = r < 0.8 * a
    flat = load / (2 * math.pi * a * np.sqrt(a**2 - r[inner] ** 2))
    tilted = flat * (1 + 3 * (ey * x[:, None] + ex * x)[inner] / a**2)
    np.testing.assert_allclose(result.pressure[inner], tilted, rtol=0.02)


def test_a_punch_loaded_outside_its_core_lifts_off() -> None:
    n, a = 65, 20e-6
    x, pixel = grid(n)
    r = np.hypot(x[:, None], x)
    punch = rc.Surface(np.where(r <= a, 0.0, np.nan), pixel).masked()
    result = rc.solve(punch, load=1.0, moments=(0.0, 0.5 * a), material=STEEL)
    assert result.moment_error <= 1e-8
    touching = result.contact
    assert touching[32, x > 0.5 * a].sum() > 0
    assert not touching[32, x < -0.8 * a].any()
    # Beyond its rim nothing of the punch can push back.
    with pytest.raises(rc.CapacityError, match="beyond what points that can touch"):
        rc.solve(punch, load=1.0, moments=(0.0, 1.01 * a), material=STEEL)


def test_a_paraboloid_rolls_to_where_the_load_acts() -> None:
    # r²/2R - c·r/R is the same paraboloid about c, c²/2R higher: turned by c/R it touches at c.
    n, radius, load = 64, 0.01, 0.05
    x, pixel = grid(n)
    ball = rc.Surface(-(x**2 + x[:, None] ** 2) / (2 * radius), pixel)
    middle = rc.solve(ball, load=load, moments=(0.0, 0.0), material=STEEL, tolerance=1e-9)
    rows, columns = 9, -6
    cy, cx = rows * pixel[0], columns * pixel[1]
    aside = rc.solve(
        ball, load=load, moments=(load * cy, load * cx), material=STEEL, tolerance=1e-9
    )
    # The moments are met to 1e-8 of the size.
    assert aside.tilt == pytest.approx((-cy / radius, -cx / radius), abs=1e-7 * SIDE / radius)
    np.testing.assert_allclose(
        aside.pressure,
        np.roll(middle.pressure, (rows, columns), (0, 1)),
        atol=1e-6 * middle.max_pressure,
    )
    sunk = middle.approach + aside.initial_gap.min() - middle.initial_gap.min()
    assert aside.approach == pytest.approx(sunk - (cy**2 + cx**2) / (2 * radius), abs=1e-14)


def test_saturated_block_under_an_excentric_load() -> None:
    # All the load at the ceiling: a strip of a flat-ended block as in the plastic hinge. Only
    # the width 2 (b/2 - e) about the load can carry it, at W = p_lim × that area.
    n = 64
    _, pixel = grid(n)
    block = rc.Surface(np.zeros((n, n)), pixel)
    offset = 12 * pixel[1]
    ceiling = 1e6
    load = ceiling * SIDE * (SIDE - 2 * offset)
    result = rc.solve(
        block,
        load=load * (1 - 1e-4),
        moments=(0.0, load * (1 - 1e-4) * offset),
        material=STEEL,
        ceiling=ceiling,
    )
    assert result.moment_error <= 1e-8
    assert result.saturated[:, 26:].all()
    assert not result.contact[:, :23].any()
    with pytest.raises(rc.CapacityError, match="pressures up to the ceiling"):
        rc.solve(
            block,
            load=load * (1 + 1e-4),
            moments=(0.0, load * (1 + 1e-4) * offset),
            material=STEEL,
            ceiling=ceiling,
        )
