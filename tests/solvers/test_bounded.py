"""The solver alone, on bare arrays: no Surface, Material or unit."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from roughcontact.halfspace import convolution
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.bounded import _BURSTS, Status, _is_stagnant, solve
from roughcontact.solvers.problem import BoundedProblem

MODULUS = 1.0
PIXEL = (0.7, 1.0)
BOUNDARIES = list(Boundary)


def solve_bounded(
    h0,
    *,
    limit=math.inf,
    total=None,
    approach=None,
    boundary="free",
    pixel=PIXEL,
    tolerance=1e-6,
    max_iterations=300,
    **options,
):
    operator = Boundary(boundary).operators(h0.shape, pixel, MODULUS, workspace=Workspace(1))
    problem = BoundedProblem(h0, limit, total, approach)
    return solve(problem, operator, tolerance=tolerance, max_iterations=max_iterations, **options)


def dense(solution):
    pressure = np.zeros(solution.gap.shape)
    pressure.ravel()[solution.index] = solution.pressure
    return pressure


def assert_solved(independent, solution, h0, limit, boundary, total=None, tolerance=1e-6):
    pressure = dense(solution)
    found = independent.judge_fields(
        pressure, h0, limit, solution.approach, PIXEL, MODULUS, boundary
    )
    assert solution.status is Status.CONVERGED
    assert found.bounded
    # 1e-9: the judge rounds differently.
    assert found.certificate <= tolerance + 1e-9
    assert solution.certificate == pytest.approx(found.certificate, rel=1e-2, abs=1e-9)
    assert found.breach <= tolerance + 1e-9
    assert (np.diff(solution.index) > 0).all()
    assert (solution.pressure > 0).all()
    if total is not None:
        assert math.fsum(solution.pressure) == pytest.approx(total, rel=1e-10)
    return pressure


def gaps(shape, kind, rng):
    ny, nx = shape
    y = (np.arange(ny) - ny // 2)[:, None] * PIXEL[0]
    x = (np.arange(nx) - nx // 2) * PIXEL[1]
    if kind == "white":
        h0 = rng.random(shape)
    elif kind == "checkerboard":
        h0 = (np.indices(shape).sum(axis=0) % 2).astype(float)
    elif kind == "steps":
        h0 = np.floor(4 * x / nx + 0 * y) - np.floor(4 * x / nx).min()
    elif kind == "spikes":
        h0 = rng.random(shape)
        h0[rng.random(shape) < 0.02] -= 30.0
    elif kind == "spike":
        h0 = np.full(shape, 50.0)
        h0[ny // 2, nx // 3] = 0
    elif kind == "flat":
        h0 = np.zeros(shape)
    elif kind == "punch":
        h0 = np.where(np.hypot(y, x) < 0.3 * min(ny, nx), 0.0, 1e3)
    elif kind == "sphere":
        h0 = (y**2 + x**2) / 100
    else:  # walk: a random walk along both axes, like a steep rough map
        h0 = np.cumsum(rng.standard_normal(shape), axis=0)
        h0 = h0 + np.cumsum(rng.standard_normal(shape), axis=1)
    return h0 - h0.min()


KINDS = ["white", "checkerboard", "steps", "spikes", "spike", "flat", "punch", "sphere", "walk"]
# A prime pair, a strip narrower than one coarse pixel, and one that gets coarser grids.
SHAPES = [(61, 97), (4, 512), (2, 300), (70, 66)]


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "shape",
    [*(pytest.param(shape, marks=pytest.mark.long) for shape in SHAPES[:2]), *SHAPES[2:]],
    ids=str,
)
def test_every_shape_elastic_and_with_ceilings(independent, boundary, kind, shape):
    rng = np.random.default_rng([SHAPES.index(shape), KINDS.index(kind)])
    h0 = gaps(shape, kind, rng)
    mean = 0.02 * MODULUS
    total = mean * h0.size
    for limit in (math.inf, 20 * mean, mean / 0.9, mean / 0.999):
        solution = solve_bounded(h0, limit=limit, total=total, boundary=boundary)
        assert_solved(independent, solution, h0, limit, boundary, total)
        # Robust also means that nothing crawls; the worst, white noise on 4 × 512, took 115.
        assert solution.convolutions <= 150


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    shape=st.tuples(st.integers(2, 30), st.integers(2, 30)),
    kind=st.sampled_from(KINDS),
    boundary=st.sampled_from(BOUNDARIES),
    mean=st.floats(-7, 2).map(lambda x: 10**x),
    filling=st.sampled_from([0.0, 1e-3, 0.1, 0.5, 0.9, 0.99, 0.999]),
    ceiling_map=st.booleans(),
    hole=st.sampled_from([0.0, 0.1, 0.6]),
)
def test_any_problem(independent, seed, shape, kind, boundary, mean, filling, ceiling_map, hole):
    rng = np.random.default_rng(seed)
    h0 = gaps(shape, kind, rng)
    masked = rng.random(shape) < hole
    masked[0, 0] = False
    h0[masked] = np.inf
    h0 -= h0.min()
    touchable = int(np.count_nonzero(~masked))
    total = mean * touchable
    limit = mean / filling if filling else math.inf
    if ceiling_map and filling:
        limit = limit * np.exp(rng.standard_normal(shape))
        limit *= total / filling / limit[~masked].sum()
    solution = solve_bounded(h0, limit=limit, total=total, boundary=boundary)
    pressure = assert_solved(independent, solution, h0, limit, boundary, total)
    assert (pressure[masked] == 0).all()


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_exactly_full_capacity(independent, boundary):
    h0 = gaps((33, 40), "walk", np.random.default_rng(3))
    limit = np.random.default_rng(4).uniform(0.5, 2, h0.shape)
    for bound in (0.37, limit):
        total = float(np.broadcast_to(bound, h0.shape).sum())
        solution = solve_bounded(h0, limit=bound, total=total, boundary=boundary)
        pressure = assert_solved(independent, solution, h0, bound, boundary, total)
        np.testing.assert_allclose(pressure, np.broadcast_to(bound, h0.shape), rtol=1e-12)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("limit", [math.inf, 0.05])
def test_approach_reproduces_the_load(independent, boundary, limit):
    h0 = gaps((40, 56), "walk", np.random.default_rng(5))
    total = 0.02 * h0.size
    by_load = solve_bounded(h0, limit=limit, total=total, boundary=boundary, tolerance=1e-9)
    by_approach = solve_bounded(
        h0, limit=limit, approach=by_load.approach, boundary=boundary, tolerance=1e-9
    )
    pressure = assert_solved(independent, by_approach, h0, limit, boundary)
    assert by_approach.approach == by_load.approach
    # Two solutions of certificate 1e-9; the condition of the problem multiplies it.
    error = np.linalg.norm(pressure - dense(by_load)) / np.linalg.norm(pressure)
    assert error < 1e-6
    assert pressure.sum() == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_bodies_apart_are_solved_without_pressure(boundary):
    h0 = gaps((12, 20), "white", np.random.default_rng(2))
    solution = solve_bounded(h0, approach=-0.1, boundary=boundary)
    assert solution.status is Status.CONVERGED
    assert solution.certificate == 0
    assert solution.pressure.size == 0
    np.testing.assert_allclose(solution.gap, h0 + 0.1, rtol=1e-12)


def test_single_pixel_contact_in_closed_form():
    h0 = np.full((16, 16), 10.0)
    h0[5, 7] = 0
    solution = solve_bounded(h0, total=0.3)
    np.testing.assert_array_equal(solution.index, [5 * 16 + 7])
    assert solution.pressure[0] == pytest.approx(0.3, rel=1e-12)
    unit = convolution.free((16, 16), PIXEL, MODULUS, workspace=Workspace(1)).self_displacement
    assert solution.approach == pytest.approx(0.3 * unit, rel=1e-12)


@pytest.mark.parametrize("spread", [1.0, 1e-3])
def test_full_periodic_contact_in_closed_form(independent, spread):
    # With every pixel in contact p = p̄ + (E*/2) |q| ∗ (z - z̄), and the approach is h̄₀.
    rng = np.random.default_rng(6)
    h0 = np.cumsum(rng.standard_normal((24, 35)), axis=1) * spread
    h0 -= h0.min()
    qy = 2 * np.pi * np.fft.fftfreq(24, PIXEL[0])[:, None]
    qx = 2 * np.pi * np.fft.fftfreq(35, PIXEL[1])
    wavy = np.fft.ifft2(-np.fft.fft2(h0) * MODULUS * np.hypot(qy, qx) / 2).real
    mean = -1.2 * wavy.min()
    solution = solve_bounded(h0, total=mean * h0.size, boundary="periodic", tolerance=1e-9)
    pressure = assert_solved(
        independent, solution, h0, math.inf, "periodic", mean * h0.size, tolerance=1e-9
    )
    # 1e-6: certificate times the spread of the eigenvalues, 2/(E* q) over K₀₀.
    np.testing.assert_allclose(pressure, mean + wavy, rtol=0, atol=1e-6 * pressure.max())
    assert solution.approach == pytest.approx(h0.mean(), rel=1e-6)


def test_the_answer_is_the_minimum(independent):
    # Against every active set of a problem small enough to try them all: 3^6 sets.
    rng = np.random.default_rng(7)
    shape, limit, total = (2, 3), 0.4, 1.0
    h0 = rng.random(shape)
    h0 -= h0.min()
    matrix = np.empty((6, 6))
    for pixel in range(6):
        unit = np.zeros(shape)
        unit.ravel()[pixel] = 1
        matrix[:, pixel] = independent.free_displacement(unit, PIXEL, MODULUS)[0].ravel()
    best, best_energy = None, math.inf
    for sets in itertools.product((0, 1, 2), repeat=6):
        state = np.array(sets)
        p = np.where(state == 2, limit, 0.0)
        free = np.flatnonzero(state == 1)
        if free.size:
            system = np.block(
                [
                    [matrix[np.ix_(free, free)], -np.ones((free.size, 1))],
                    [np.ones((1, free.size)), np.zeros((1, 1))],
                ]
            )
            right = np.append(-h0.ravel()[free] - matrix[free] @ p, total - p.sum())
            p[free] = np.linalg.solve(system, right)[:-1]
        if abs(p.sum() - total) > 1e-12 or (p < 0).any() or (p > limit).any():
            continue
        energy = p @ matrix @ p / 2 + h0.ravel() @ p
        if energy < best_energy:
            best, best_energy = p, energy
    solution = solve_bounded(h0, limit=limit, total=total, tolerance=1e-11)
    # 1e-9: certificate 1e-11 and the condition of six pixels.
    np.testing.assert_allclose(dense(solution).ravel(), best, atol=1e-9)


def test_warm_start_from_anything_gives_the_same_answer(independent):
    h0 = gaps((64, 80), "walk", np.random.default_rng(8))
    limit, total = 0.1, 0.02 * h0.size
    cold = solve_bounded(h0, limit=limit, total=total)
    expected = dense(cold)
    rng = np.random.default_rng(9)
    one = np.array([17])
    anywhere = np.flatnonzero(rng.random(h0.size) < 0.1)
    starts = {
        "itself": (cold.index, cold.pressure),
        "a neighbour": (cold.index, 0.8 * cold.pressure),
        "one pixel": (one, np.array([1.0])),
        "beyond the ceiling": (anywhere, 10 * rng.random(anywhere.size)),
        "nothing": (np.empty(0, np.int64), np.empty(0)),
        "zeros": (one, np.array([0.0])),
    }
    for name, start in starts.items():
        warm = solve_bounded(h0, limit=limit, total=total, start=start)
        pressure = assert_solved(independent, warm, h0, limit, "free", total)
        # Both have certificate 1e-6; the condition of the problem makes it 1e-4 at worst.
        error = np.linalg.norm(pressure - expected) / np.linalg.norm(expected)
        assert error < 1e-4, name
        if name == "itself":
            assert warm.convolutions <= 2


@pytest.mark.parametrize("limit", [math.inf, 0.1])
@pytest.mark.parametrize(
    ("kind", "shape", "total", "boundary"),
    [
        ("white", (24, 40), 30, "free"),
        ("steps", (24, 40), 30, "periodic"),
        ("spikes", (24, 40), 30, "free"),
        ("walk", (24, 40), 30, "periodic"),
        ("punch", (24, 40), 30, "free"),
        # One whose active set overshoots.
        ("checkerboard", (65, 65), 300, "periodic"),
    ],
)
def test_no_unit_changes_a_bit(kind, shape, total, boundary, limit):
    # Lengths in units of any power of two: the digits of all that is computed are the same.
    h0 = gaps(shape, kind, np.random.default_rng(1))
    h0 /= np.ptp(h0)
    small, large = (
        solve_bounded(h0 * unit, limit=limit * unit, total=total * unit, boundary=boundary)
        for unit in (2.0**-40, 2.0**40)
    )
    assert small.convolutions == large.convolutions
    assert small.approach * 2.0**80 == large.approach
    np.testing.assert_array_equal(small.index, large.index)
    np.testing.assert_array_equal(small.pressure * 2.0**80, large.pressure)


def test_history_shows_every_level_and_ends_with_the_answer():
    h0 = gaps((130, 140), "walk", np.random.default_rng(10))
    seen = []
    solution = solve_bounded(h0, total=0.02 * h0.size, progress=seen.append)
    assert tuple(seen) == solution.history
    assert seen[-1].shape == (130, 140)
    assert seen[-1].certificate == solution.certificate <= 1e-6
    sizes = [step.shape[0] for step in seen]
    assert sizes == sorted(sizes)
    assert sizes[0] < 130
    assert seen[-1].convolutions == solution.convolutions


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_convolution_limit_returns_best_solution(independent, boundary):
    h0 = gaps((61, 97), "walk", np.random.default_rng(11))
    total = 0.02 * h0.size
    for allowed in (1, 2, 3, 5):
        solution = solve_bounded(
            h0, limit=0.1, total=total, boundary=boundary, max_iterations=allowed, tolerance=1e-12
        )
        assert solution.status is Status.CONVOLUTION_LIMIT
        # One more look may be needed to judge what is handed back.
        assert solution.convolutions <= allowed + 2
        found = independent.judge_fields(
            dense(solution), h0, 0.1, solution.approach, PIXEL, MODULUS, boundary
        )
        assert solution.certificate == pytest.approx(found.certificate, rel=1e-6)
        assert found.bounded
        assert dense(solution).sum() == pytest.approx(total, rel=1e-10)
        on_map = [step.certificate for step in solution.history if step.shape == h0.shape]
        assert solution.certificate <= min(on_map) * (1 + 1e-7)


@pytest.mark.parametrize(
    ("certificate", "bursts", "lost"),
    [(1e-12, 0, True), (9.9e-12, 0, True), (1.01e-11, 0, False), (1e-3, _BURSTS, True)],
)
def test_stagnation_near_rounding_is_detected(certificate, bursts, lost):
    assert _is_stagnant(certificate, 1e-12, bursts) == lost
    assert not _is_stagnant(1e-3, 1e-12, _BURSTS - 1)


@pytest.mark.parametrize("kind", ["white", "walk"])
def test_tolerance_below_rounding_ends_early(kind):
    h0 = gaps((40, 30), kind, np.random.default_rng(3))
    needed = solve_bounded(h0, total=24, tolerance=1e-9)
    solution = solve_bounded(h0, total=24, tolerance=1e-30, max_iterations=500)
    assert solution.certificate < 1e-9
    assert solution.convolutions < 200
    assert needed.status is Status.CONVERGED
    assert needed.convolutions < solution.convolutions


def test_convolutions_do_not_grow_with_the_grid():
    # A smooth body: the same contact on grids up to 8 times finer.
    counts = []
    for n in (32, 64, 128, 256):
        x = (np.arange(n) - n / 2 + 0.5) / n
        h0 = (x[:, None] ** 2 + x**2) / 2
        h0 -= h0.min()
        pixel = (1 / n, 1 / n)
        solution = solve_bounded(h0, total=0.01 * n * n, pixel=pixel)
        assert solution.status is Status.CONVERGED
        counts.append(solution.convolutions)
    # Measured 10 to 16; unpreconditioned conjugate gradients double with every second grid.
    assert counts[-1] <= 1.5 * counts[0] + 4
    assert max(counts) <= 25
