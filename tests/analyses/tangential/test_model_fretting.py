"""Stress under partial slip against closed forms: Cattaneo and Mindlin, Hamilton, Johnson."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from hamilton import rim_stress, sliding_sphere
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


def trailing_edge_stresses(part: float, poisson: float) -> tuple[float, float]:
    """Return the largest tension under Q = part μP and the von Mises stress there, over p₀."""
    # The smaller circle does not reach the edge; at the edge Hamilton's form has its limit.
    sliding = exact(np.array(-1.0), np.array(1e-9), 1e-9, part, poisson)
    sliding -= sliding_sphere(-1.0, 1e-9, 1e-9, poisson, FRICTION)
    along, across = np.array(rim_stress(poisson, FRICTION)) + sliding[:2]
    return along, math.hypot(along - across / 2, across * 0.75**0.5)


@pytest.mark.parametrize(
    ("radius", "part", "error"),
    # The rim of slip is 21, 11, 5, 4.5 and 2 pixels wide. Pixel centers alone are 11 to 26 % low.
    [(40.0, 0.9, 0.01), (40.0, 0.6, 0.01), (20.0, 0.6, 0.08), (40.0, 0.3, 0.16), (20.0, 0.3, 0.08)],
)
@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_the_largest_tension_is_at_the_trailing_edge(
    poisson: float, radius: float, part: float, error: float
) -> None:
    (y, x), pressure, traction = partial_slip(radius, part)
    found = stress_summary.summarize(pressure, (1.0, 1.0), poisson, depths=[0.0], traction=traction)
    tension, von_mises = trailing_edge_stresses(part, poisson)
    assert found.max_tension == pytest.approx(tension, rel=error)
    assert found.von_mises[0] == pytest.approx(von_mises, rel=error)
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
        stress.slices(
            pressure[None],
            (1.0, 1.0),
            [0.0],
            0.3,
            boundary="periodic-y",
            traction=[0 * traction[None], traction[None]],
            precision="double",
        )
    )

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
        pressure[None],
        (1.0, 1.0),
        0.3,
        boundary="periodic-y",
        depths=[0.0],
        traction=[0 * traction[None], traction[None]],
    )
    # The pixel next to the edge is half a pixel away from the cusp.
    assert -0.08 < largest.max_tension / (2 * FRICTION * math.sqrt(part)) - 1 < 0
    assert x[largest.tension_pixel[1]] == pytest.approx(-radius, abs=2)


@pytest.mark.parametrize(("boundary", "angle"), [("free", 0.0), ("free", 40.0), ("periodic", 0.0)])
def test_ruiz_of_a_sphere(boundary: str, angle: float) -> None:
    """Slip is that of superposition, exact without ν: μ (gap that P* leaves, less that of P)."""
    radius, load, part = 10e-3, 1.0, 0.75
    body = rc.Material(young=210e9, poisson=0.0)
    a = (3 * load * radius / (4 * rc.contact_modulus(body, body))) ** (1 / 3)
    points, pixel = (128, a / 48) if boundary == "free" else (256, a / 32)
    y = (np.arange(points) - points / 2 + 0.5) * pixel
    ball = rc.Surface(-(y[:, None] ** 2 + y**2) / (2 * radius), pixel=(pixel, pixel))
    contact = rc.solve(
        ball, material=body, counter_material=body, load=load, boundary=boundary, calibrated=False
    )
    found = rc.tangential(
        contact, friction=FRICTION, force=part * FRICTION * load, direction=angle, stress=True
    )
    p0, c = 1.5 * load / (math.pi * a**2), a * (1 - part) ** (1 / 3)
    r = np.linspace(c, a, 200)[1:-1]
    beyond = (2 * c**2 - r**2) * np.arcsin(c / r) + c * np.sqrt(r**2 - c**2)
    slip = FRICTION / radius * (r**2 / 2 - c**2 + beyond / math.pi)
    traction = FRICTION * p0 * np.sqrt(1 - (r / a) ** 2)
    along = p0 * exact(-r / a, np.full(r.size, 1e-9), 1e-9, part, 0.0)[0]
    fretting = found.fretting
    assert found.last.max_slip == pytest.approx(slip.max(), rel=0.03)
    assert fretting.max_work == pytest.approx((traction * slip).max(), rel=0.03)
    assert fretting.max_ruiz == pytest.approx((along * traction * slip).max(), rel=0.04)
    # Behind the stick zone; rows count downwards.
    down, right = np.array(fretting.max_ruiz_at) - points * pixel / 2
    turn = math.radians(angle)
    assert right * math.cos(turn) - down * math.sin(turn) < -c
    # All of the slip, and nothing else, does work: a cycle dissipates four times as much.
    area = contact.pixel_area
    assert 4 * fretting.work.sum() * area == pytest.approx(found.cycle_energy, rel=1e-6)
    assert fretting.stress.max_tension >= fretting.tension.max()


@pytest.mark.long
@pytest.mark.parametrize(
    ("part", "factor", "expected"),
    # Sliding itself is Hamilton's; pressure alone reaches 0.62 p₀.
    [(0.7, 1.0, 0.7), (0.97, 1.0, 0.97), (0.9999, 1.03, math.inf), (0.7, 0.5, 0.0)],
)
def test_a_sphere_yields_first_at_its_trailing_edge(
    part: float, factor: float, expected: float
) -> None:
    radius, load, points = 10e-3, 1.0, 96
    modulus = rc.contact_modulus(*2 * [rc.Material(young=210e9, poisson=0.3)])
    a = (3 * load * radius / (4 * modulus)) ** (1 / 3)
    strength = factor * trailing_edge_stresses(part, 0.3)[1] * 1.5 * load / (math.pi * a**2)
    body = rc.Material(young=210e9, poisson=0.3, yield_strength=strength)
    y = (np.arange(points) - points / 2 + 0.5) * a / 40
    ball = rc.Surface(-(y[:, None] ** 2 + y**2) / (2 * radius), pixel=(a / 40, a / 40))
    contact = rc.solve(ball, material=body, counter_material=body, load=load, ceiling=None)
    result = rc.tangential(contact, friction=FRICTION, force=0.2 * FRICTION * load, stress=True)
    assert result.fretting.yield_force == pytest.approx(expected * FRICTION * load, rel=0.03)


def test_the_slip_of_a_cycle_is_its_amplitude() -> None:
    """A load that grows leaves slip behind, which does not change the next cycle."""
    heights, pixel = rc.reference_map(32)
    body = rc.Material(young=210e9, poisson=0.0)
    contact = rc.solve(
        rc.Surface(heights, pixel), material=body, counter_material=body, load=1.0, ceiling=None
    )
    options = {"friction": 0.15, "stress": True, "tolerance": 1e-8}
    cycle = [(1.0, 0.06), (1.0, -0.06), (1.0, 0.06)]
    plain, after = (
        rc.tangential(contact, stages=[*before, *cycle], **options).fretting
        for before in ([], [(0.3, 0.03)])
    )
    once = rc.tangential(contact, force=0.06, **options).fretting
    np.testing.assert_allclose(plain.work, once.work, atol=1e-5 * once.max_work)
    np.testing.assert_allclose(after.work, once.work, atol=1e-5 * once.max_work)
