"""Solvers on an operator of another make, with the protocol and nothing more."""

import math

import numpy as np
import pytest

from roughcontact.halfspace import convolution, kernels
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers import active_set, bounded, preconditioner, rigid_tilt
from roughcontact.solvers.operator import dot, norm
from roughcontact.solvers.problem import BoundedProblem
from roughcontact.solvers.progress import Status

SHAPE, PIXEL, MODULUS = (24, 31), (0.7, 1.0), 1.0


class Chosen:
    def __init__(self, index):
        self.index, self.starts = index, np.array([0, index.size])


class Dense:
    """Symmetric matrix with the protocol of `Operator`: one block of rows, no FFT."""

    real = np.float64
    periodic_axes, is_long_wave_soft = (True, True), False

    def __init__(self, matrix, shape):
        self.matrix, self.shape = matrix, shape
        self.self_displacement = float(matrix[0, 0])

    def support(self, index):
        return Chosen(index)

    def each_block(self, task):
        task(0, slice(0, self.shape[0]))

    def _displaced(self, index, pressure):
        loaded = np.zeros(len(self.matrix))
        loaded[index] = pressure
        return (self.matrix @ loaded).reshape(self.shape)

    def spread(self, support, pressure, visit):
        visit(0, slice(0, self.shape[0]), self._displaced(support.index, pressure))

    def gather(self, support, pressure):
        return self._displaced(support.index, pressure).ravel()[support.index]

    def __call__(self, pressure):
        return (self.matrix @ pressure.ravel()).reshape(self.shape)

    def to_single_precision(self):
        return self

    def approximate_inverse(self):
        # A little resists even where nothing does, so that there is an inverse.
        resisted = self.matrix + self.self_displacement / len(self.matrix)
        return Dense(np.linalg.inv(resisted) * self.self_displacement, self.shape)


def dense(shape, coarsening, matrix_of=None):
    edges = tuple(n * d for n, d in zip(coarsening, PIXEL, strict=True))
    return Dense((matrix_of or love)(shape, edges), shape)


def love(shape, pixel):
    quadrant = kernels.love(shape, pixel, MODULUS)
    row, column = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    return quadrant[np.abs(row[:, None] - row), np.abs(column[:, None] - column)]


def waves(shape, pixel):
    unit = np.zeros(shape)
    unit[0, 0] = 1
    response = convolution.periodic(shape, pixel, MODULUS, workspace=Workspace(1))(unit)
    row, column = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    return response[row[:, None] - row, column[:, None] - column]


def by_fft(shape, coarsening):
    edges = tuple(n * d for n, d in zip(coarsening, PIXEL, strict=True))
    return convolution.free(shape, edges, MODULUS, workspace=Workspace(1))


def pressure_map(solution):
    pressure = np.zeros(SHAPE)
    pressure.ravel()[solution.index] = solution.pressure
    return pressure


@pytest.fixture
def several_levels(monkeypatch):
    """Coarse grids and collective modes on a map small enough for a matrix."""
    monkeypatch.setattr(bounded, "_COARSEST", 4)
    monkeypatch.setattr(preconditioner, "_BLOCK", 4)
    monkeypatch.setattr(preconditioner, "_SMALL", 8)


def gap(kind):
    y, x = (np.arange(n) - n / 2 for n in SHAPE)
    ball = (y[:, None] ** 2 * 0.49 + x**2) / 60
    rough = np.random.default_rng(4).normal(size=SHAPE) * 0.4
    if kind == "rough":
        return ball + rough
    if kind == "holes":
        found = ball + rough
        found[5:9, 4:20] = np.inf
        return found
    # Nothing touches on the last rows.
    return np.hypot(y[:, None] + 9, x) / 4


CASES = {
    "elastic": ("rough", np.inf, {"total": 60.0}),
    "approach": ("rough", np.inf, {"approach": 0.3}),
    "ceiling": ("rough", 0.4, {"total": 60.0}),
    "ceilings": ("holes", np.random.default_rng(5).uniform(0.2, 0.8, SHAPE), {"total": 40.0}),
    "holes": ("holes", np.inf, {"total": 60.0}),
    "one side": ("one side", 0.6, {"total": 5.0}),
    "full": ("rough", np.inf, {"total": 9000.0}),
}


@pytest.mark.parametrize("case", CASES)
def test_solution_is_independent_of_operator(several_levels, case):
    kind, limit, target = CASES[case]
    expected, found = (
        bounded.solve(
            BoundedProblem(gap(kind), limit, **target), family, tolerance=1e-9, max_iterations=300
        )
        for family in (by_fft, dense)
    )
    assert expected.status is found.status is Status.CONVERGED
    pressure, other = pressure_map(expected), pressure_map(found)
    np.testing.assert_array_equal(other > 0, pressure > 0)
    np.testing.assert_allclose(other, pressure, rtol=0, atol=1e-7 * pressure.max())
    assert found.approach == pytest.approx(expected.approach, rel=1e-8, abs=1e-8)
    np.testing.assert_allclose(found.gap, expected.gap, rtol=0, atol=1e-7)


def test_tilted_solution_is_independent_of_operator(several_levels):
    problem, target = BoundedProblem(gap("rough"), 0.5, 60.0), np.array([0.05, -0.02])
    (expected, slope), (found, other) = (
        rigid_tilt.solve(problem, family, target, PIXEL, tolerance=1e-8, max_iterations=300)
        for family in (by_fft, dense)
    )
    assert other == pytest.approx(slope, rel=1e-5)
    pressure = pressure_map(expected)
    np.testing.assert_allclose(pressure_map(found), pressure, atol=1e-5 * pressure.max())


def test_uniform_wave_without_resistance_ends_at_first_ceiling() -> None:
    # All of a periodic map moves as one until the first pixel meets its ceiling.
    limit = np.full(SHAPE, 1.0)
    limit[20, 3] = 0.3
    full = np.ones(limit.size)
    assert active_set._feasible_length(0 * full, full, limit.ravel()) == 0.3
    found = bounded.solve(
        BoundedProblem(np.zeros(SHAPE), limit, approach=0.5),
        lambda shape, coarsening: dense(shape, coarsening, waves),
        tolerance=1e-9,
        max_iterations=300,
    )
    assert found.status is Status.CONVERGED


def test_norm_of_values_whose_squares_overflow_or_vanish():
    values = np.array([3.0, -4.0])
    assert (dot(values, values), norm(values), norm(np.zeros(2))) == (25, 5, 0)
    assert dot(np.empty(0), np.empty(0)) == norm(np.empty(0)) == 0
    for scale in (1e-200, 1e200):
        assert norm(scale * values) == pytest.approx(5 * scale)
    assert norm(np.array([math.inf, 1])) == math.inf
