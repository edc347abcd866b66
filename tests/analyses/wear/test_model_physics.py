"""Wear against closed forms: waves in full contact, ball, flat punch, volume, two bodies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

import roughcontact as rc
from reading import measurement, needs_reader
from roughcontact.analyses.wear.model import WearingPair
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.pair import Pair
from roughcontact.contact.solve import solve_pair
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace

STEEL = rc.Material(210e9, 0.3)
MODULUS = 210e9 / 0.91
SOFT = rc.Material(210e9, 0.3, 0.5e9)
K = 1e-15


def rough(n: int = 32) -> rc.Surface:
    return rc.Surface(*rc.reference_map(n))


def run_in(surface: rc.Surface, **changes: Any) -> rc.results.Wear:
    """Return the wear of a map by 50 nm per meter."""
    terms = {
        "material": STEEL,
        "load": rc.NominalPressure(50e6),
        "distance": 1.0,
        "wear_coefficient": K,
        "boundary": "periodic",
    }
    return rc.wear(surface, **{**terms, **changes})


def volume_of(result: rc.results.Wear) -> float:
    return float(np.nansum(result.depth)) * result.last.pixel_area


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"boundary": "free"},
        {"boundary": "periodic-x"},
        {"material": SOFT},
        {
            "material": rc.Material(210e9, 0.3, coating=rc.Layer(300e9, 0.2, "2 um")),
            "ceiling": None,
        },
        {"steps": 3},
    ],
)
def test_removed_volume_is_coefficient_times_load_times_distance(changes: dict[str, Any]) -> None:
    result = run_in(rough(), **changes)
    assert result.distance == 1.0
    assert volume_of(result) == pytest.approx(K * result.last.load * 1.0, rel=1e-10)
    assert result.volumes == (pytest.approx(volume_of(result), rel=1e-10), 0.0)


def wave(n: int, profile: bool) -> rc.Surface:
    x = 2 * math.pi * np.arange(n) / n
    y = 0.0 if profile else x[:, None]
    return rc.Surface(1e-7 * np.cos(2 * x + y), (1e-6, 1e-6) if not profile else 1e-6)


@pytest.mark.parametrize("steps", [1, 4, 16])
@pytest.mark.parametrize("profile", [False, True])
def test_wave_in_full_contact_decays_by_closed_form(steps: int, profile: bool) -> None:
    # The pressure of a wave of amplitude A is E* q A/2; a step divides A by 1 + k E* q Δs/2.
    surface = wave(16, profile)
    q = 2 * math.pi / 16e-6 * (2 if profile else math.sqrt(5))
    mean = 0.5 * MODULUS * q * 1e-7 / 0.9
    load = rc.LineLoad(mean * 16e-6) if profile else rc.NominalPressure(mean)
    distance = 2 / (K * MODULUS * q)
    result = run_in(surface, load=load, distance=distance, steps=steps, tolerance=1e-13)
    assert result.first.contact_fraction == 1.0
    ratio = result.column("Sq") / surface.Sq
    assert ratio[:-1] == pytest.approx((1 + 1 / steps) ** -np.arange(steps), rel=1e-10)
    # The last step is divided in two.
    want = (1 + 1 / steps) ** (1 - steps) * (1 + 0.5 / steps) ** -2
    heights = result.worn.heights - result.worn.heights.mean()
    assert heights == pytest.approx(want * surface.heights, abs=1e-10 * 1e-7)
    assert result.last.max_pressure / mean - 1 == pytest.approx(0.9 * want, rel=1e-9)


@pytest.mark.long
def test_ball_wears_flat_as_archard_on_a_rigid_flat() -> None:
    # The volume of a flat scar is π a⁴/4R = k W s, under a uniform pressure.
    radius, a, points = 1e-3, 50e-6, 128
    load = 4 * MODULUS * (0.17 * a) ** 3 / (3 * radius)
    distance = math.pi * a**4 / (4 * K * load * radius)
    y, x = (np.indices((points, points)) - (points - 1) / 2) * 1e-6
    ball = rc.Surface(-(x**2 + y**2) / (2 * radius), (1e-6, 1e-6))
    result = run_in(ball, load=load, distance=distance, boundary="free")
    scar = math.sqrt(np.count_nonzero(result.depth) * 1e-12 / math.pi)
    assert scar == pytest.approx(a, rel=2e-3)
    assert math.sqrt(result.last.contact_area / math.pi) == pytest.approx(a, rel=2e-3)
    uniform = result.last.pressure[np.hypot(y, x) < 0.8 * a] * math.pi * a**2 / load
    assert uniform.max() / uniform.min() < 1.005
    # The steps lag behind by what the last one changes.
    assert uniform.mean() + result.step_errors["max_pressure"] == pytest.approx(1, abs=5e-3)


def disk_displacement(r: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return the displacement at r by unit pressure on a disk (Johnson 1985, eqs. 3.29)."""
    inside = np.where(r < a, r / a, 0.5)
    outside = np.where(r < a, 0.5, a / r)
    out = r * (ellipe(outside**2) - (1 - outside**2) * ellipk(outside**2))
    return 4 / (math.pi * MODULUS) * np.where(r < a, a * ellipe(inside**2), out)


def punch_pressures(distances: list[float], rings: int = 60, steps: int = 100) -> list[float]:
    """Return p(0)/p̄ of a wearing flat punch of radius 1 at distances k E* s, by rings."""
    edges = np.sin(np.linspace(0, math.pi / 2, rings + 1))
    middle = 0.5 * (edges[1:] + edges[:-1])
    area = np.diff(edges**2)
    inner = np.maximum(edges, 1e-9)
    system = np.zeros((rings + 1, rings + 1))
    grid = disk_displacement(middle[:, None], inner[None, :])
    system[:-1, :-1] = np.diff(grid, axis=1) * MODULUS
    system[:-1, -1], system[-1, :-1] = -1, area
    worn, result, before = np.zeros(rings), [], 0.0
    for distance in distances:
        for step in np.full(steps, (distance - before) / steps):
            matrix = system.copy()
            matrix[np.arange(rings), np.arange(rings)] += step
            solved = np.linalg.solve(matrix, np.append(-worn, 1.0))
            worn = worn + step * solved[:-1]
        result.append(float(solved[0]))
        before = distance
    return result


@pytest.mark.long
def test_punch_pressure_becomes_uniform() -> None:
    a, points = 20e-6, 48
    y, x = (np.indices((points, points)) - (points - 1) / 2) * 1e-6
    heights = np.where(np.hypot(y, x) <= a, 0.0, -1e-3)
    surface = rc.Surface(heights, (1e-6, 1e-6))
    scaled = [0.2, 0.5, 1.0, 2.0, 4.0]
    noted = [0.642, 0.772, 0.900, 0.984, 0.9996]
    rings = punch_pressures(scaled)
    found, area = [], np.count_nonzero(heights == 0) * 1e-12
    for value in scaled:
        result = run_in(
            surface,
            load=1.0,
            boundary="free",
            wear_coefficient=1e-14,
            distance=value * a / (1e-14 * MODULUS),
            max_moved=0.01,
        )
        middle = result.last.pressure[points // 2, points // 2]
        found.append(middle * area / 1.0)
    assert rings == pytest.approx(noted, rel=0.01)
    assert found == pytest.approx(rings, rel=0.01)


def test_two_bodies_share_wear_by_their_coefficients() -> None:
    split = {"wear_coefficient": 0.3 * K, "counter_wear_coefficient": 0.7 * K, "steps": 6}
    counter = rc.Surface(np.roll(rough().heights[::-1], 5, 0), rough().pixel)
    for other in (None, counter):
        result = run_in(rough(), counter_surface=other, motion="fretting", **split)
        one = run_in(rough(), counter_surface=other, motion="fretting", steps=6)
        start = 0.0 if other is None else other.heights
        assert result.worn_counter is not None
        mine = rough().heights - result.worn.heights
        theirs = start - result.worn_counter.heights
        assert mine.sum() / theirs.sum() == pytest.approx(3 / 7, rel=1e-12)
        assert mine + theirs == pytest.approx(one.depth, abs=1e-14)
        assert result.last.max_pressure == pytest.approx(one.last.max_pressure, rel=1e-6)


def test_rough_bodies_wear_to_full_contact() -> None:
    result = run_in(rough(), distance=100.0)
    assert result.conforms
    assert result.distance < 100.0
    assert result.last.contact_fraction > 0.99
    assert result.last.max_pressure < 1.5 * 50e6
    assert result.worn.Sq < 0.1 * rough().Sq
    assert result.wear_rate == pytest.approx(K * 50e6)


@pytest.mark.long
@pytest.mark.parametrize("material", [STEEL, SOFT])
def test_error_of_steps_is_of_first_order(material: rc.Material) -> None:
    exact = run_in(rough(), steps=160, material=material).depth
    errors = []
    for steps in (6, 12, 24):
        depth = run_in(rough(), steps=steps, material=material).depth
        errors.append(np.abs(depth - exact).sum() / exact.sum())
    order = -np.polyfit(np.log2([6, 12, 24]), np.log2(errors), 1)[0]
    assert order == pytest.approx(1, abs=0.25)


@pytest.mark.long
def test_step_errors_estimate_error_of_result() -> None:
    exact = run_in(rough(64), max_moved=0.02)
    for max_moved in (0.1, 0.3):
        result = run_in(rough(64), max_moved=max_moved)
        depth = np.abs(result.depth - exact.depth).sum() / exact.depth.sum() / 2
        peak = result.last.max_pressure / exact.last.max_pressure - 1
        assert 0.5 < result.step_errors["depth"] / depth < 2
        assert 0.5 < -result.step_errors["max_pressure"] / peak < 2
        assert result.last.contact_area == pytest.approx(exact.last.contact_area, rel=5e-3)
        assert len(result.steps) < len(exact.steps) / 4


@pytest.mark.long
@pytest.mark.parametrize("material", [STEEL, SOFT])
def test_implicit_steps_agree_with_explicit_ones(material: rc.Material) -> None:
    # Explicit steps are stable below 4/(k E* q), q of the shortest wave.
    surface, terms = rough(), {"material": material, "boundary": "periodic"}
    q = math.sqrt(2) * math.pi / surface.pixel[0]
    limit = 4 / (K * MODULUS * q)
    worn, steps = surface, 48
    for _ in range(steps):
        contact = rc.solve(worn, load=rc.NominalPressure(50e6), calibrated=False, **terms)
        heights = worn.heights - K * limit / 4 * contact.pressure
        worn = rc.Surface(heights, surface.pixel)
    result = run_in(surface, distance=steps * limit / 4, material=material, steps=steps)
    error = np.abs(result.worn.heights - worn.heights).sum() / result.depth.sum()
    assert error < 0.03
    contact = rc.solve(worn, load=rc.NominalPressure(50e6), calibrated=False, **terms)
    assert result.last.contact_area == pytest.approx(contact.contact_area, rel=0.05)


@pytest.mark.long
@needs_reader
@pytest.mark.parametrize("material", [STEEL, SOFT])
def test_measured_map_runs_in_at_the_cost_of_twenty_solves(material: rc.Material) -> None:
    surface = rc.read_surface(measurement("wyko_nt1100_test_1.opd"))
    surface = surface.cropped((100, 228), (100, 228)).filled().leveled()
    result = run_in(surface, distance=4.0, material=material)
    assert result.last.contact_fraction > 0.3
    assert result.column("certificate").max() <= 1e-6
    assert volume_of(result) == pytest.approx(result.volumes[0], rel=1e-10)
    assert result.column("convolutions").sum() < 20 * result.first.convolutions


@pytest.mark.parametrize("boundary", ["free", "periodic", "periodic-y"])
@pytest.mark.parametrize("ceiling", [None, 2e9])
def test_step_is_certified_like_any_contact(boundary: str, ceiling: float | None) -> None:
    pair, compliance = Pair(rough(), STEEL, boundary=Boundary(boundary)), 2e-16
    terms = LoadCase(rc.solve(rough(), material=STEEL, load="50 MPa").load, ceiling=ceiling)
    result = solve_pair(WearingPair.from_pair(pair, compliance), terms)
    operator = pair.operators("double", Workspace())(pair.shape, (1, 1))
    worn = rough().heights - compliance * result.pressure
    gap = operator(result.pressure) + rough().heights.max() - worn - result.approach
    assert result.gap == pytest.approx(gap, abs=1e-6 * gap.max())
    unit = operator.self_displacement + compliance
    step = result.pressure - np.clip(result.pressure - result.gap / unit, 0, ceiling)
    error = np.linalg.norm(step) / np.linalg.norm(result.pressure)
    assert result.certificate == pytest.approx(error, rel=1e-3)
    assert error < 1e-6
