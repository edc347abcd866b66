"""The approximate inverse against dense matrices of Love's coefficients."""

import numpy as np
import pytest
import scipy.linalg

import roughcontact as rc
from roughcontact.halfspace import convolution
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers import preconditioner
from roughcontact.solvers.preconditioner import FreePixelInverse

PIXEL, MODULUS = (0.7e-6, 1e-6), 1e11
SHAPE, EDGES = (32, 40), (8, 8)
KINDS = ["sparse", "dense", "spots", "half"]


def inverse(shape=SHAPE, edges=EDGES):
    """A new inverse, with blocks or without (None), and K₀₀."""
    operator = convolution.free(shape, PIXEL, MODULUS, workspace=Workspace(1))
    unit, wrapped = operator.self_displacement, operator.approximate_inverse()
    if edges is None:
        return FreePixelInverse(wrapped), unit
    number = tuple(-(-points // edge) for points, edge in zip(shape, edges, strict=True))
    lengths = (edges[0] * PIXEL[0], edges[1] * PIXEL[1])
    blocks = convolution.free(number, lengths, MODULUS, workspace=Workspace(1))
    return FreePixelInverse(wrapped, blocks, edges, unit), unit


@pytest.fixture
def exact(monkeypatch):
    """Forces on the blocks to all digits, so that the inverse is a matrix."""
    monkeypatch.setattr(preconditioner, "_ROUGHLY", 1e-8)
    monkeypatch.setattr(preconditioner, "_MOST_STEPS", 300)


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


@pytest.mark.parametrize("edges", [None, EDGES, (16, 6)])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_preconditioner_is_symmetric_positive_and_reduces_iterations(
    exact, independent, kind, seed, edges
):
    index = pixels(kind, seed)
    precondition, unit = inverse(edges=edges)
    found = symmetric(matrix(precondition.restrict_inverse(index), index.size))
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
    pressure = precondition.restrict_inverse(index)(wave.ravel()).reshape(shape)
    q = 2 * np.pi * np.hypot(8 / shape[0] / PIXEL[0], 6 / shape[1] / PIXEL[1])
    # Love's coefficients at eight points a wave are a few percent softer than the continuum.
    # Beyond the edges, where nothing moves, the wave ends.
    inside = np.s_[16:-16, 12:-12]
    expected = wave * unit * q * MODULUS / 2
    np.testing.assert_allclose(pressure[inside], expected[inside], atol=0.06)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("loads", ["random", "even"])
def test_blocks_save_iterations_on_many_spots(exact, independent, seed, loads):
    shape, rng = (96, 120), np.random.default_rng(seed)
    index = spots(rng, shape, 40)
    right = rng.standard_normal(index.size) if loads == "random" else np.ones(index.size)
    counts = []
    for edges in (None, (8, 8)):
        precondition, unit = inverse(shape, edges)
        dense = displacement(independent, index, unit, shape)
        counts.append(conjugate_gradients(dense, precondition.restrict_inverse(index), right))
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
def test_stays_positive_when_the_set_changes(exact, independent, radii):
    # As in a solve that starts from less load, or from the contact of another map.
    precondition, unit = inverse()
    for radius in radii:
        index = disc(radius)
        found = symmetric(matrix(precondition.restrict_inverse(index), index.size))
        assert np.linalg.eigvalsh(found)[0] > 0
        assert condition((found, displacement(independent, index, unit))) < 10


def test_guess_at_lower_load_needs_at_most_twice_convolutions():
    heights, pixel = rc.reference_map(256)
    surface, steel = rc.Surface(heights, pixel), rc.Material(210e9, 0.3)
    little = rc.solve(surface, material=steel, load=0.3)
    cold = rc.solve(surface, material=steel, load=10.0)
    warm = rc.solve(surface, material=steel, load=10.0, initial_guess=little)
    # The cold one has coarse grids to start from: twice its convolutions are fair.
    assert warm.convolutions <= 2 * cold.convolutions


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("hurst", [0.5, 0.8])
def test_dense_contact_rough_to_the_pixel(boundary, hurst):
    edge = 1e-4 / 256
    heights = rc.self_affine(
        (256, 256),
        (edge, edge),
        rms_height=2e-7,
        rolloff_wavelength=2.5e-5,
        cutoff_wavelength=2 * edge,
        hurst=hurst,
        rng=np.random.default_rng(2),
    )
    steel = rc.Material(210e9, 0.3)
    result = rc.solve(
        rc.Surface(heights, (edge, edge)), material=steel, load=100.0, boundary=boundary
    )
    assert result.contact.mean() > 0.3
    # Blocks of 64 pixels and opposite edges that touch took 34 to 58.
    assert result.convolutions <= 30


@pytest.mark.parametrize("edges", [None, EDGES])
def test_fewer_than_two_pixels(exact, edges):
    precondition, _ = inverse(edges=edges)
    nothing = precondition.restrict_inverse(np.empty(0, np.int64))(np.empty(0))
    assert nothing.shape == (0,)
    alone = precondition.restrict_inverse(np.array([100]))(np.array([2.0]))
    # Alone, K is 1. What is wrapped around takes the other pixels for free to move, hence stiffer.
    assert 2.0 < alone[0] < 4.0
    # And such a set is no measure for the next.
    index = disc(8)
    assert (
        np.linalg.eigvalsh(symmetric(matrix(precondition.restrict_inverse(index), index.size)))[0]
        > 0
    )


def test_sets_do_not_disturb_each_other():
    precondition, _ = inverse()
    one, two = disc(8), disc(6)
    first = precondition.restrict_inverse(one)
    values = np.random.default_rng(0).standard_normal(one.size)
    before = first(values)
    precondition.restrict_inverse(two)(values[: two.size])
    np.testing.assert_array_equal(first(values), before)
    # The weights of a set seen before are kept in half precision.
    np.testing.assert_allclose(precondition.restrict_inverse(one)(values), before, atol=2e-3)


def test_stiff_layer_does_not_overflow_stored_weights():
    # NumPy warns where a weight exceeds the type of the stored ones, and warnings are errors here.
    y = np.arange(64) - 31.5
    ball = rc.Surface(-(y[:, None] ** 2 + y**2) / 12800, pixel=(1.0, 1.0))
    body = rc.Material(np.inf, 0.0, coating=[rc.Layer(1e9, 0.5, 0.64)])
    assert rc.solve(ball, material=body, load=4e12, ceiling=None).converged
