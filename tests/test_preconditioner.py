"""The approximate inverse against dense matrices of Love's coefficients."""

import numpy as np
import pytest
import scipy.linalg

import roughcontact as rc
from roughcontact.halfspace import convolution
from roughcontact.solvers.preconditioner import FreePixelInverse

PIXEL, MODULUS = (0.7e-6, 1e-6), 1e11
SHAPE, BLOCKS = (32, 40), (4, 5)
KINDS = ["sparse", "dense", "spots", "half"]


def inverse(shape=SHAPE, blocks=BLOCKS):
    """A new inverse, with blocks or without (None), and K₀₀."""
    operator = convolution.free(shape, PIXEL, MODULUS, workers=1)
    unit, response = operator.self_displacement, None
    if blocks is not None:
        size = [-(-points // number) for points, number in zip(shape, blocks, strict=True)]
        force = np.zeros(blocks)
        force[0, 0] = 1 / (size[0] * size[1])
        edges = (size[0] * PIXEL[0], size[1] * PIXEL[1])
        response = convolution.free(blocks, edges, MODULUS, workers=1)(force) / unit
    return FreePixelInverse(operator.approximate_inverse(), response), unit


def matrix(apply, n):
    return np.stack([apply(unit) for unit in np.eye(n)], axis=1)


def displacement(independent, index, unit, shape=SHAPE):
    """K over K₀₀ between some pixels, by the textbook."""
    row, column = np.divmod(index, shape[1])
    y, x = (row[:, None] - row) * PIXEL[0], (column[:, None] - column) * PIXEL[1]
    return independent.love_coefficients(y, x, PIXEL, MODULUS) / unit


def spots(rng, shape=SHAPE, number=12, width=3):
    mask = np.zeros(shape, bool)
    for _ in range(number):
        y, x = (rng.integers(0, points - width) for points in shape)
        mask[y : y + width, x : x + width] = True
    return np.flatnonzero(mask)


def pixels(kind, seed):
    rng = np.random.default_rng(seed)
    if kind == "spots":
        return spots(rng)
    if kind == "half":
        return np.arange(SHAPE[0] * SHAPE[1] // (8 + seed))
    return np.flatnonzero(rng.random(SHAPE[0] * SHAPE[1]) < {"sparse": 0.04, "dense": 0.15}[kind])


def disc(radius):
    y, x = np.ogrid[: SHAPE[0], : SHAPE[1]]
    return np.flatnonzero((y - 16) ** 2 + (x - 20) ** 2 < radius**2)


def symmetric(found):
    # Transforms in single precision.
    assert np.abs(found - found.T).max() < 2e-6 * np.abs(found).max()
    return (found + found.T) / 2


def condition(product_of):
    """Condition of P K from K = L Lᵀ: that of Lᵀ P L, which is symmetric."""
    inverse_matrix, dense = product_of
    factor = np.linalg.cholesky(dense)
    values = np.linalg.eigvalsh(factor.T @ inverse_matrix @ factor)
    assert values[0] > 0
    return values[-1] / values[0]


@pytest.mark.parametrize("blocks", [None, BLOCKS, (2, 7)])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_symmetric_positive_and_better_than_nothing(independent, kind, seed, blocks):
    index = pixels(kind, seed)
    precondition, unit = inverse(blocks=blocks)
    found = symmetric(matrix(precondition.on(index), index.size))
    # Far from zero for single precision, and for weights in half precision.
    assert np.linalg.eigvalsh(found)[0] > 0.01
    dense = displacement(independent, index, unit)
    before = condition((np.eye(index.size), dense))
    assert condition((found, dense)) < 0.85 * before
    if kind == "half":
        # One wide contact: most of the spectrum is that of |q|.
        assert condition((found, dense)) < before / 3


def test_close_to_the_inverse_on_the_whole_map(independent):
    # A single wave far from the rim is divided by its own response, 2/(E*|q|).
    shape = (64, 48)
    precondition, unit = inverse(shape, None)
    index = np.arange(shape[0] * shape[1])
    y, x = np.mgrid[: shape[0], : shape[1]]
    wave = np.cos(2 * np.pi * (8 * y / shape[0] + 6 * x / shape[1]))
    pressure = precondition.on(index)(wave.ravel()).reshape(shape)
    q = 2 * np.pi * np.hypot(8 / shape[0] / PIXEL[0], 6 / shape[1] / PIXEL[1])
    # Love's coefficients at eight points a wave are a few percent softer than the continuum.
    np.testing.assert_allclose(pressure, wave * unit * q * MODULUS / 2, atol=0.06)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("loads", ["random", "even"])
def test_blocks_save_iterations_on_many_spots(independent, seed, loads):
    shape, rng = (96, 120), np.random.default_rng(seed)
    index = spots(rng, shape, 40)
    right = rng.standard_normal(index.size) if loads == "random" else np.ones(index.size)
    counts = []
    for blocks in (None, (8, 10)):
        precondition, unit = inverse(shape, blocks)
        dense = displacement(independent, index, unit, shape)
        counts.append(conjugate_gradients(dense, precondition.on(index), right))
    nothing = conjugate_gradients(dense, lambda displacement: displacement, right)
    wrapped, both = counts
    assert both < wrapped < 0.75 * nothing


def conjugate_gradients(dense, precondition, right):
    """Iterations to a residual of 1e-8."""
    solution, residual = np.zeros_like(right), right.copy()
    direction, product, iterations = np.zeros_like(right), np.inf, 0
    while np.linalg.norm(residual) > 1e-8 * np.linalg.norm(right) and iterations < 200:
        z = precondition(residual)
        previous, product = product, residual @ z
        direction = z + product / previous * direction
        response = dense @ direction
        length = product / (direction @ response)
        solution += length * direction
        residual -= length * response
        iterations += 1
    # Not by luck: the equations are solved.
    expected = scipy.linalg.solve(dense, right, assume_a="pos")
    np.testing.assert_allclose(solution, expected, atol=1e-6 * np.abs(expected).max())
    return iterations


@pytest.mark.parametrize(
    "radii", [(12, 10, 8), (6, 8, 10), (4, 5, 12)], ids=["shrinking", "growing", "jumping"]
)
def test_stays_positive_when_the_set_changes(independent, radii):
    # As in a solve that starts from less load, or from the contact of another map.
    precondition, unit = inverse()
    for radius in radii:
        index = disc(radius)
        found = symmetric(matrix(precondition.on(index), index.size))
        assert np.linalg.eigvalsh(found)[0] > 0
        assert condition((found, displacement(independent, index, unit))) < 10


def test_stays_positive_when_the_spots_move():
    precondition, _ = inverse()
    for seed in range(4):
        index = spots(np.random.default_rng(seed))
        found = symmetric(matrix(precondition.on(index), index.size))
        assert np.linalg.eigvalsh(found)[0] > 0


def test_a_start_at_less_load_costs_no_more_than_none():
    heights, pixel = rc.reference_map(256)
    surface, steel = rc.Surface(heights, pixel), rc.Material(210e9, 0.3)
    little = rc.solve(surface, material=steel, load=0.3)
    cold = rc.solve(surface, material=steel, load=10.0)
    warm = rc.solve(surface, material=steel, load=10.0, start=little)
    # The cold one has coarse grids to start from: twice its convolutions are fair.
    assert warm.convolutions <= 2 * cold.convolutions


@pytest.mark.parametrize("blocks", [None, BLOCKS])
def test_fewer_than_two_pixels(blocks):
    precondition, _ = inverse(blocks=blocks)
    nothing = precondition.on(np.empty(0, np.int64))(np.empty(0))
    assert nothing.shape == (0,)
    alone = precondition.on(np.array([100]))(np.array([2.0]))
    # Alone, K is 1. What is wrapped around takes the other pixels for free to move, hence stiffer.
    assert 2.0 < alone[0] < 4.0
    # And such a set is no measure for the next.
    index = disc(8)
    assert np.linalg.eigvalsh(symmetric(matrix(precondition.on(index), index.size)))[0] > 0


def test_sets_do_not_disturb_each_other():
    precondition, _ = inverse()
    one, two = disc(8), disc(6)
    first = precondition.on(one)
    values = np.random.default_rng(0).standard_normal(one.size)
    before = first(values)
    precondition.on(two)(values[: two.size])
    np.testing.assert_array_equal(first(values), before)
    # The weights of a set seen before are kept in half precision.
    np.testing.assert_allclose(precondition.on(one)(values), before, atol=2e-3)
