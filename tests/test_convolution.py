import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roughcontact.halfspace import convolution

MODULUS = 3.0
PIXEL = (0.4, 1.0)
# Odd, even, prime, long and thin; with PIXEL also dy ≠ dx.
SHAPES = [(2, 2), (3, 5), (8, 8), (7, 13), (12, 31), (29, 6), (2, 33), (41, 2)]
BOUNDARIES = ["free", "periodic"]


@pytest.fixture(params=["ducc0", "scipy"])
def backend(request, monkeypatch):
    if request.param == "ducc0":
        if convolution._ducc0 is None:
            pytest.skip("ducc0 is not installed")
    else:
        monkeypatch.setattr(convolution, "_ducc0", None)
    return request.param


def make(boundary, shape, pixel=PIXEL, **options):
    options.setdefault("workers", 1)
    return getattr(convolution, boundary)(shape, pixel, MODULUS, **options)


def small_blocks(monkeypatch, size):
    """Give a small map many row and column blocks."""
    for name in ("_ROW_BYTES", "_COLUMN_BYTES"):
        monkeypatch.setattr(convolution, name, size)


def direct(independent, boundary, pressure, pixel=PIXEL):
    """Sum over all pairs of pixels; no transform."""
    ny, nx = pressure.shape
    rows, columns = np.arange(-ny + 1, ny), np.arange(-nx + 1, nx)
    if boundary == "free":
        y, x = rows[:, None] * pixel[0], columns * pixel[1]
        kernel = independent.love_coefficients(y, x, pixel, MODULUS)
    else:
        # The response to one pixel as a sum of cosines over all its waves.
        i, j = np.arange(ny), np.arange(nx)
        fy, fx = np.where(2 * i > ny, i - ny, i), np.where(2 * j > nx, j - nx, j)
        q = 2 * np.pi * np.hypot(fy[:, None] / (ny * pixel[0]), fx / (nx * pixel[1]))
        symbol = np.zeros(q.shape)
        np.divide(2 / MODULUS, q, out=symbol, where=q > 0)
        wave_y = np.exp(2j * np.pi * (np.outer(rows, fy) % ny) / ny)
        wave_x = np.exp(2j * np.pi * (np.outer(fx, columns) % nx) / nx)
        kernel = (wave_y @ symbol @ wave_x).real / (ny * nx)
    displacement = np.zeros(pressure.shape)
    for row, column in zip(*np.nonzero(pressure), strict=True):
        part = kernel[ny - 1 - row : 2 * ny - 1 - row, nx - 1 - column : 2 * nx - 1 - column]
        displacement += pressure[row, column] * part
    return displacement


def random_pressure(shape, seed=0, fill=1.0):
    rng = np.random.default_rng(seed)
    return rng.random(shape) * (rng.random(shape) < fill)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("shape", SHAPES)
def test_direct_sum(independent, backend, boundary, shape):
    pressure = random_pressure(shape)
    expected = direct(independent, boundary, pressure)
    found = make(boundary, shape)(pressure)
    # Rounding of transforms: a few ε of the largest displacement.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * np.abs(expected).max())


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("shape", [(2, 500), (500, 2), (3, 257)])
def test_long_thin_maps(independent, backend, boundary, shape):
    pressure = random_pressure(shape, fill=0.1)
    expected = direct(independent, boundary, pressure)
    found = make(boundary, shape)(pressure)
    # 1e-12 instead of 1e-14: the judge's corner sum cancels at 500 pixels.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_self_displacement_is_the_response_of_a_pixel_to_itself(backend, boundary):
    for shape in [(6, 9), (7, 8), (2, 2)]:
        operator = make(boundary, shape)
        pressure = np.zeros(shape)
        pressure[1, 1] = 1
        found = operator(pressure)[1, 1]
        assert operator.self_displacement == pytest.approx(found, rel=1e-13)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@settings(max_examples=40, deadline=None)
@given(
    ny=st.integers(2, 40),
    nx=st.integers(2, 40),
    ratio=st.floats(0.1, 10),
    seed=st.integers(0, 2**32 - 1),
    factor=st.floats(-1e3, 1e3),
)
def test_reciprocity_and_superposition(boundary, ny, nx, ratio, seed, factor):
    rng = np.random.default_rng(seed)
    p, q = rng.standard_normal((2, ny, nx))
    operator = make(boundary, (ny, nx), (ratio, 1.0))
    up, uq = operator(p), operator(q)
    scale = np.linalg.norm(p) * np.linalg.norm(uq) + np.linalg.norm(q) * np.linalg.norm(up)
    # Betti: the work of either load on the other's displacement; rounding only.
    assert abs(np.vdot(p, uq) - np.vdot(q, up)) <= 1e-13 * scale
    together = operator(p + factor * q)
    size = np.abs(up).max() + abs(factor) * np.abs(uq).max()
    np.testing.assert_allclose(together, up + factor * uq, rtol=0, atol=1e-13 * size)
    # The elastic energy of any load is positive (free), or zero for the mean alone (periodic).
    assert np.vdot(p, up) > 0


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_mirrored_load_mirrors_the_displacement(boundary):
    pressure = random_pressure((17, 24))
    operator = make(boundary, pressure.shape)
    expected = operator(pressure)
    for mirror in (np.s_[::-1], np.s_[:, ::-1]):
        found = operator(np.ascontiguousarray(pressure[mirror]))[mirror]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * expected.max())


def loads(shape):
    """Supports that leave rows, columns, or nearly everything out."""
    one = np.zeros(shape, bool)
    one[shape[0] // 2, shape[1] // 3] = True
    rows = np.zeros(shape, bool)
    rows[shape[0] // 3 : shape[0] // 2 + 1] = True
    corners = np.zeros(shape, bool)
    corners[0, 0] = corners[-1, -1] = True
    stripes = np.zeros(shape, bool)
    stripes[::3] = True
    random = np.random.default_rng(1).random(shape) < 0.05
    random[0, 0] = True
    return {"one": one, "rows": rows, "corners": corners, "stripes": stripes, "random": random}


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("kind", ["one", "rows", "corners", "stripes", "random"])
@pytest.mark.parametrize("shape", [(23, 41), (2, 2), (64, 32)])
def test_gather_and_spread_equal_the_dense_map(monkeypatch, backend, boundary, kind, shape):
    small_blocks(monkeypatch, 1 << 11)
    operator = make(boundary, shape, workers=2)
    mask = loads(shape)[kind]
    index = np.flatnonzero(mask)
    pressure = np.random.default_rng(2).standard_normal(index.size)
    dense = np.zeros(shape)
    dense.ravel()[index] = pressure
    expected = make(boundary, shape)(dense)
    atol = 1e-14 * max(np.abs(expected).max(), operator.self_displacement)
    support = operator.support(index)
    np.testing.assert_array_equal(support.index, index)
    found = operator.gather(support, pressure)
    np.testing.assert_allclose(found, expected.ravel()[index], rtol=0, atol=atol)
    spread = np.full(shape, np.nan)
    seen = np.zeros(shape[0], int)

    def visit(number, rows, displacement):
        seen[rows] += 1
        spread[rows] = displacement

    operator.spread(support, pressure, visit)
    assert (seen == 1).all()
    np.testing.assert_allclose(spread, expected, rtol=0, atol=atol)
    # Once more: nothing of the first load may be left in the buffers.
    np.testing.assert_allclose(operator.gather(support, pressure), found, rtol=0, atol=atol)
    np.testing.assert_allclose(operator(dense), expected, rtol=0, atol=atol)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_no_load_no_displacement(backend, boundary):
    operator = make(boundary, (9, 7))
    operator(random_pressure((9, 7)))  # something for a stale buffer to hold
    assert (operator(np.zeros((9, 7))) == 0).all()
    nothing = operator.support(np.empty(0, np.int64))
    assert operator.gather(nothing, np.empty(0)).size == 0


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("workers", [2, 3, 8])
def test_any_number_of_threads_gives_the_same_answer(monkeypatch, boundary, workers):
    small_blocks(monkeypatch, 1 << 12)
    pressure = random_pressure((61, 97), fill=0.3)
    alone = make(boundary, pressure.shape, workers=1)(pressure)
    together = make(boundary, pressure.shape, workers=workers)
    for _ in range(3):
        # Each block is transformed by one thread: the same operations, bit by bit, but for
        # the symbol, which may be summed in another order.
        np.testing.assert_allclose(
            together(pressure), alone, rtol=0, atol=1e-15 * np.abs(alone).max()
        )


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_single_precision_is_single_precision(backend, boundary):
    pressure = random_pressure((61, 97), fill=0.3)
    double = make(boundary, pressure.shape)(pressure)
    single = make(boundary, pressure.shape, precision="single")(pressure)
    error = np.abs(single - double).max() / np.abs(double).max()
    # ε of float32 is 1.2e-7 and the error of a transform grows with the log of its length.
    assert 1e-9 < error < 2e-6


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_approximate_inverse_undoes_the_operator(boundary):
    # On pressure of zero mean in the middle of the map it is the inverse but for the wrap-around.
    shape = (48, 40)
    y, x = np.mgrid[:48, :40]
    r2 = ((y - 24) / 4.0) ** 2 + ((x - 20) / 4.0) ** 2
    pressure = (1 - r2) * np.exp(-r2)
    operator = make(boundary, shape, (1.0, 1.0))
    found = operator.approximate_inverse()(operator(pressure) / operator.self_displacement)
    error = np.linalg.norm(found - pressure) / np.linalg.norm(pressure)
    # Periodic: exact, in single precision. Free: only a preconditioner, 10 % is plenty.
    assert error < (1e-5 if boundary == "periodic" else 0.1)


def test_approximate_inverse_takes_the_mean_for_the_softest_wave():
    operator = make("periodic", (48, 40), (1.0, 1.0))
    inverse = operator.approximate_inverse()
    longest = np.cos(2 * np.pi * np.arange(48) / 48)[:, None] * np.ones(40)
    stiffness = inverse(longest)[0, 0]
    assert stiffness > 0
    np.testing.assert_allclose(inverse(np.ones((48, 40))), stiffness, rtol=1e-5)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_in_a_visitor_reaches_the_caller(monkeypatch, workers):
    small_blocks(monkeypatch, 1 << 10)
    operator = make("free", (32, 32), workers=workers)
    support = operator.support(np.array([5]))

    def visit(number, rows, displacement):
        if rows.start > 0:
            raise RuntimeError("no room")

    with pytest.raises(RuntimeError, match="no room"):
        operator.spread(support, np.ones(1), visit)
    # And the operator still works.
    pressure = random_pressure((32, 32))
    np.testing.assert_array_equal(operator(pressure), make("free", (32, 32))(pressure))


def test_operators_leave_no_threads_behind():
    before = threading.active_count()
    for _ in range(20):
        make("free", (8, 8), workers=2)(np.ones((8, 8)))
    # The pool of a dropped operator ends with it; a few may still be on their way out.
    assert threading.active_count() <= before + 6


PARITIES = [(False, False), (True, False), (False, True), (True, True)]


def parity_kernel(shape, odd, rng):
    """A random periodic map that is even or odd along each axis."""
    kernel = rng.standard_normal(shape)
    for axis, sign in enumerate(odd):
        mirrored = np.roll(np.flip(kernel, axis), 1, axis)
        kernel = 0.5 * (kernel - mirrored if sign else kernel + mirrored)
    return kernel


def circular(source, kernel):
    """Sum over all pairs of points; no transform."""
    ny, nx = source.shape
    return sum(
        source[i, j] * np.roll(kernel, (i, j), (0, 1))[:ny, :nx]
        for i, j in np.ndindex(source.shape)
    )


def responses_to(source, padded, terms, **options):
    workspace = convolution.Workspace(options.pop("workers", 1))
    options.setdefault("precision", "double")
    return convolution.Responses(source, padded, terms, workspace=workspace, **options)


def streamed(operator, symbols, first_row=0):
    found = np.full((operator.count, *operator.shape), np.nan)

    def visit(rows, block):
        found[:, rows] = block

    operator.stream(symbols, visit, first_row)
    return found


@pytest.mark.parametrize("workers", [1, 3])
@pytest.mark.parametrize(
    ("shape", "padded"), [((5, 7), (10, 14)), ((9, 3), (24, 8)), ((1, 2), (2, 4))]
)
def test_responses_to_sampled_kernels(backend, monkeypatch, shape, padded, workers):
    small_blocks(monkeypatch, 512)
    rng = np.random.default_rng(0)
    source = rng.standard_normal(shape)
    # Three responses: one term, two terms, one term, in mixed order.
    terms = [convolution.Term(n, odd) for n, odd in zip((1, 0, 1, 2), PARITIES, strict=True)]
    kernels = [parity_kernel(padded, term.odd, rng) for term in terms]
    expected = np.zeros((3, *shape))
    for term, kernel in zip(terms, kernels, strict=True):
        expected[term.response] += circular(source, kernel)
    operator = responses_to(source, padded, terms, workers=workers)
    symbols = operator.sampled(lambda rows, columns: [k[np.ix_(rows, columns)].T for k in kernels])
    size = np.abs(expected).max()
    for first in (0, shape[0] - 1):
        np.testing.assert_allclose(
            streamed(operator, symbols, first), expected, rtol=0, atol=1e-14 * size
        )
    point = shape[0] // 2, shape[1] - 1
    along_x, along_y = operator.cross(symbols, point)
    np.testing.assert_allclose(along_x, expected[:, point[0]], rtol=0, atol=1e-14 * size)
    np.testing.assert_allclose(along_y, expected[:, :, point[1]], rtol=0, atol=1e-14 * size)


@pytest.mark.parametrize("padded", [(6, 8), (7, 9), (1, 5)])
def test_responses_to_symbols_of_any_period(backend, padded):
    # Odd periods have no wave of two points; symbols are the transforms of the kernels.
    rng = np.random.default_rng(1)
    source = rng.standard_normal(padded)
    terms = [convolution.Term(n, odd) for n, odd in enumerate(PARITIES)]
    kernels = [parity_kernel(padded, odd, rng) for odd in PARITIES]
    factors = [1, 1j, 1j, -1]
    highest = padded[0] // 2, padded[1] // 2
    quadrants = [
        (factor * np.fft.fft2(kernel)).real[: highest[0] + 1, : highest[1] + 1]
        for factor, kernel in zip(factors, kernels, strict=True)
    ]
    operator = responses_to(source, padded, terms)
    symbols = convolution.Symbols(
        highest, lambda columns: np.stack([quadrant[:, columns] for quadrant in quadrants])
    )
    expected = [circular(source, kernel) for kernel in kernels]
    np.testing.assert_allclose(streamed(operator, symbols), expected, rtol=0, atol=1e-13)


def test_responses_leave_out_waves_beyond_the_highest(backend):
    rng = np.random.default_rng(2)
    padded = (12, 16)
    source = rng.standard_normal(padded)
    operator = responses_to(source, padded, [convolution.Term(0, (False, False))])
    symbols = convolution.Symbols((2, 3), lambda c: np.ones((1, 3, c.stop - c.start)))
    spectrum = np.fft.fft2(source)
    fy, fx = np.fft.fftfreq(12, 1 / 12), np.fft.fftfreq(16, 1 / 16)
    spectrum[(np.abs(fy)[:, None] > 2) | (np.abs(fx) > 3)] = 0
    expected = np.fft.ifft2(spectrum).real
    np.testing.assert_allclose(streamed(operator, symbols)[0], expected, rtol=0, atol=1e-14)
    along_x, along_y = operator.cross(symbols, (5, 4))
    np.testing.assert_allclose(along_x[0], expected[5], rtol=0, atol=1e-14)
    np.testing.assert_allclose(along_y[0], expected[:, 4], rtol=0, atol=1e-14)


@pytest.mark.parametrize("every", [(2, 1), (2, 4), (3, 2)])
def test_smooth_kernels_need_few_samples(backend, every):
    # Kernels of few waves: samples in steps of ``every`` hold them all.
    padded, source = (24, 32), np.random.default_rng(3).standard_normal((12, 16))
    y, x = (2 * np.pi * np.arange(n) / n for n in padded)
    kernels = [
        np.outer(1 + np.cos(2 * y), np.cos(3 * x)),
        np.outer(np.sin(3 * y), 0.2 + np.cos(x)),
    ]
    terms = [convolution.Term(0, (False, False)), convolution.Term(1, (True, False))]
    operator = responses_to(source, padded, terms)

    def sample(rows, columns):
        return [kernel[np.ix_(rows, columns)].T for kernel in kernels]

    expected = np.array([circular(source, kernel) for kernel in kernels])
    found = streamed(operator, operator.sampled(sample, every))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_responses_in_single_precision(backend):
    rng = np.random.default_rng(4)
    source, kernel = rng.random((20, 30)), parity_kernel((40, 60), (False, True), rng)
    operator = responses_to(
        source, (40, 60), [convolution.Term(0, (False, True))], precision="single"
    )
    symbols = operator.sampled(lambda rows, columns: [kernel[np.ix_(rows, columns)].T])
    expected = circular(source, kernel)
    found = streamed(operator, symbols)[0]
    # Single precision's ε is 1.2e-7; and it is not double.
    error = np.abs(found - expected).max() / np.abs(expected).max()
    assert 1e-9 < error < 2e-6


def test_free_period_is_even_and_long_enough(backend):
    for shape in SHAPES:
        period = convolution.free_period(shape)
        assert all(p % 2 == 0 and p >= 2 * n for p, n in zip(period, shape, strict=True))


@pytest.mark.parametrize("padded", [(7, 9), (10, 16), (15, 9)], ids=str)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_half_spectrum_and_back(backend, padded, dtype) -> None:
    values = np.random.default_rng(8).normal(size=(7, 9)).astype(dtype)
    values[:2] = values[6:] = 0
    out = np.full((padded[0], padded[1] // 2 + 1), np.nan + 0j, np.result_type(dtype, np.complex64))
    spectrum = convolution.half_spectrum(values, slice(2, 6), padded, out)
    # The textbook sum, by matrices.
    y, x = np.arange(7), np.arange(9)
    qy = 2 * np.pi * np.arange(padded[0]) / padded[0]
    qx = 2 * np.pi * np.arange(padded[1] // 2 + 1) / padded[1]
    exact = np.exp(-1j * np.outer(qy, y)) @ values @ np.exp(-1j * np.outer(x, qx))
    rounding = 100 * np.finfo(dtype).eps
    assert spectrum.dtype == out.dtype
    np.testing.assert_allclose(spectrum, exact, atol=rounding)
    back = convolution.from_half_spectrum(spectrum, (7, 9), padded)
    assert back.dtype == dtype
    np.testing.assert_allclose(back / (padded[0] * padded[1]), values, atol=rounding)


def test_fast_lengths(backend) -> None:
    for points in (1, 2, 7, 17, 61, 127, 1025):
        length = convolution.fast_length(points)
        assert points <= length <= 1.3 * points + 1
        while length % 2 == 0:
            length //= 2
        for factor in (3, 5, 7, 11):
            while length % factor == 0:
                length //= factor
        assert length == 1
