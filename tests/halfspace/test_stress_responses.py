import numpy as np
import pytest

from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.stress import Responses, Symbols, Term

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
    workspace = Workspace(options.pop("workers", 1))
    options.setdefault("precision", "double")
    return Responses(source, padded, terms, workspace=workspace, **options)


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
def test_responses_to_sampled_kernels(backend, small_blocks, shape, padded, workers):
    small_blocks(512)
    rng = np.random.default_rng(0)
    source = rng.standard_normal(shape)
    # Kernels that add to one response and to several, alone in it or with others of each parity.
    shares = [
        [(1, 1.0)],
        [(0, 1.0), (2, -0.5)],
        [(1, 2.0)],
        [(2, 1.0), (0, 0.3)],
        [(4, 1.0), (5, 0.2)],
        [(3, -1.0), (5, 0.7)],
        [(3, 3.0), (5, 1.0)],
        [(5, -1.0)],
    ]
    terms = [Term(odd, share) for odd, share in zip(2 * PARITIES, shares, strict=True)]
    kernels = [parity_kernel(padded, term.odd, rng) for term in terms]
    expected = np.zeros((6, *shape))
    for term, kernel in zip(terms, kernels, strict=True):
        for response, factor in term.shares:
            expected[response] += factor * circular(source, kernel)
    operator = responses_to(source, padded, terms, workers=workers)
    symbols = operator.sample(lambda rows, columns: [k[np.ix_(rows, columns)].T for k in kernels])
    size = np.abs(expected).max()
    for first in (0, shape[0] - 1):
        np.testing.assert_allclose(
            streamed(operator, symbols, first), expected, rtol=0, atol=1e-14 * size
        )


@pytest.mark.parametrize("padded", [(6, 8), (7, 9), (1, 5)])
def test_responses_to_symbols_of_any_period(backend, padded):
    # Odd periods have no wave of two points; symbols are the transforms of the kernels.
    rng = np.random.default_rng(1)
    source = rng.standard_normal(padded)
    terms = [Term(odd, [(n, 1.0)]) for n, odd in enumerate(PARITIES)]
    kernels = [parity_kernel(padded, odd, rng) for odd in PARITIES]
    factors = [1, 1j, 1j, -1]
    highest = padded[0] // 2, padded[1] // 2
    quadrants = [
        (factor * np.fft.fft2(kernel)).real[: highest[0] + 1, : highest[1] + 1]
        for factor, kernel in zip(factors, kernels, strict=True)
    ]
    operator = responses_to(source, padded, terms)
    symbols = Symbols(
        highest, lambda columns: np.stack([quadrant[:, columns] for quadrant in quadrants])
    )
    expected = [circular(source, kernel) for kernel in kernels]
    np.testing.assert_allclose(streamed(operator, symbols), expected, rtol=0, atol=1e-13)


def test_responses_leave_out_waves_beyond_the_highest(backend):
    rng = np.random.default_rng(2)
    padded = (12, 16)
    source = rng.standard_normal(padded)
    operator = responses_to(source, padded, [Term((False, False), [(0, 1.0)])])
    symbols = Symbols((2, 3), lambda c: np.ones((1, 3, c.stop - c.start)))
    spectrum = np.fft.fft2(source)
    fy, fx = np.fft.fftfreq(12, 1 / 12), np.fft.fftfreq(16, 1 / 16)
    spectrum[(np.abs(fy)[:, None] > 2) | (np.abs(fx) > 3)] = 0
    expected = np.fft.ifft2(spectrum).real
    np.testing.assert_allclose(streamed(operator, symbols)[0], expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("every", [(2, 1), (2, 4), (3, 2)])
def test_smooth_kernels_need_few_samples(backend, every):
    # Kernels of few waves: samples in steps of ``every`` hold them all.
    padded, source = (24, 32), np.random.default_rng(3).standard_normal((12, 16))
    y, x = (2 * np.pi * np.arange(n) / n for n in padded)
    kernels = [np.outer(1 + np.cos(2 * y), np.cos(3 * x)), np.outer(np.sin(3 * y), 0.2 + np.cos(x))]
    terms = [Term((False, False), [(0, 1.0)]), Term((True, False), [(1, 1.0)])]
    operator = responses_to(source, padded, terms)

    def sample(rows, columns):
        return [kernel[np.ix_(rows, columns)].T for kernel in kernels]

    expected = np.array([circular(source, kernel) for kernel in kernels])
    found = streamed(operator, operator.sample(sample, every))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_responses_in_single_precision(backend):
    rng = np.random.default_rng(4)
    source, kernel = rng.random((20, 30)), parity_kernel((40, 60), (False, True), rng)
    operator = responses_to(source, (40, 60), [Term((False, True), [(0, 1.0)])], precision="single")
    symbols = operator.sample(lambda rows, columns: [kernel[np.ix_(rows, columns)].T])
    expected = circular(source, kernel)
    found = streamed(operator, symbols)[0]
    # Single precision's ε is 1.2e-7; and it is not double.
    error = np.abs(found - expected).max() / np.abs(expected).max()
    assert 1e-9 < error < 2e-6


def test_the_stream_begins_with_the_block_of_a_row(small_blocks):
    # A search for the largest stress looks first where the last slice had it.
    small_blocks(512)
    source = np.random.default_rng(6).standard_normal((40, 8))
    operator = responses_to(source, (80, 16), [Term((False, False), [(0, 1.0)])])
    symbols = Symbols((40, 8), lambda columns: np.ones((1, 41, columns.stop - columns.start)))
    for row in (0, 17, 39):
        seen: list[slice] = []
        operator.stream(symbols, lambda rows, _, seen=seen: seen.append(rows), row)
        assert len(seen) > 3
        assert seen[0].start <= row < seen[0].stop
        assert sorted(i for rows in seen for i in range(rows.start, rows.stop)) == list(range(40))
