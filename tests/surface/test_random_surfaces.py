import math

import numpy as np
import pytest
import scipy.fft
from hypothesis import given, settings, strategies as st

from roughcontact.errors import InputError
from roughcontact.surface import random_surfaces

BODY = {"rms_height": 2e-7, "rolloff_wavelength": 2.5e-5, "cutoff_wavelength": 8e-6}


def make(shape, side, seed=0, **changes):
    pixel = (side[0] / shape[0], side[1] / shape[1])
    rng = np.random.default_rng(seed)
    return random_surfaces.self_affine(shape, pixel, **{**BODY, **changes}, rng=rng)


def power(heights, side):
    """|amplitude|² and |q| [waves/m] of every wave."""
    ny, nx = heights.shape
    i, j = scipy.fft.fftfreq(ny, 1 / ny), scipy.fft.fftfreq(nx, 1 / nx)
    q = np.hypot(i[:, None] / side[0], j / side[1])
    return np.abs(scipy.fft.fft2(heights, norm="forward")) ** 2, q


@pytest.mark.parametrize("shape", [(64, 64), (63, 65), (48, 130), (1, 64), (64, 2)])
def test_rms_height_is_exact_and_mean_zero(shape):
    z = make(shape, (shape[0] * 1e-6, shape[1] * 1e-6))
    assert z.shape == shape
    assert z.dtype == np.float64
    assert np.sqrt(np.mean(z**2)) == pytest.approx(2e-7, rel=1e-12)
    assert abs(z.mean()) < 1e-20


@given(
    rows=st.tuples(st.integers(26, 70), st.integers(26, 70)),
    columns=st.tuples(st.integers(51, 120), st.integers(51, 120)),
    ratio=st.sampled_from([1.0, 2.0, 1 / 3, 0.7]),
    seed=st.integers(0, 2**32),
)
@settings(max_examples=60, deadline=None)
def test_same_seed_is_the_same_body_on_every_grid(rows, columns, ratio, seed):
    side = (1e-4, 1e-4 * ratio * 2)
    columns = tuple(math.ceil(c * ratio) for c in columns)
    one, two = (make(s, side, seed) for s in zip(rows, columns, strict=True))
    # 12 and 12·2·ratio waves per side are the most the cut-off allows.
    most = (12, int(side[1] / 8e-6 + 1e-6))
    waves = [
        scipy.fft.fft2(z, norm="forward")[
            np.ix_(range(-most[0], most[0] + 1), range(-most[1], most[1] + 1))
        ]
        for z in (one, two)
    ]
    np.testing.assert_allclose(waves[0], waves[1], rtol=0, atol=1e-20)


@pytest.mark.parametrize(("shape", "side"), [((96, 96), (1e-4, 1e-4)), ((64, 160), (1e-4, 3e-4))])
def test_spectrum_has_the_exponent_and_the_limits(shape, side):
    # Mean over 200 maps: each wave's power is exponentially distributed, so a wave errs by 7 %,
    # the fit over some hundred waves by about 0.02 in the exponent.
    maps = [make(shape, side, seed, hurst=0.6) for seed in range(200)]
    mean = np.mean([power(z, side)[0] for z in maps], axis=0)
    q = power(maps[0], side)[1]
    inside = (q > 0) & (q <= 1 / 8e-6 * (1 + 1e-6))
    assert (mean[~inside] < 1e-12 * mean.max()).all()
    assert (mean[inside] > 0).all()
    fractal = inside & (q >= 1 / 2.5e-5)
    slope = np.polyfit(np.log(q[fractal]), np.log(mean[fractal]), 1)[0]
    assert slope == pytest.approx(-2 - 2 * 0.6, abs=0.1)
    # Flat below the roll-off, and continuous with the power law there.
    plateau = mean[inside & (q < 1 / 2.5e-5)]
    assert plateau.std() < 0.15 * plateau.mean()
    law = mean[fractal] * (q[fractal] * 2.5e-5) ** 3.2
    assert law.mean() == pytest.approx(plateau.mean(), rel=0.05)


def test_heights_are_uncorrelated_between_directions():
    # Both signs of a row index have to be drawn apart: else the map is mirror-symmetric.
    waves = scipy.fft.fft2(make((64, 64), (1e-4, 1e-4)))
    up, down = waves[1:8, 1:8].ravel(), waves[-1:-8:-1, 1:8].ravel()
    assert abs(np.vdot(up, down)) < 0.5 * np.linalg.norm(up) * np.linalg.norm(down)


def test_reference_map_is_the_problem_of_the_design():
    z, pixel = random_surfaces.reference_map(128)
    assert pixel == (1e-4 / 128, 1e-4 / 128)
    assert z.std() == pytest.approx(0.2e-6, rel=1e-12)
    p, q = power(z, (1e-4, 1e-4))
    held = p > 1e-20 * p.max()
    waves = q * 1e-4
    assert held.sum() == np.count_nonzero((waves > 0) & (waves < 16 + 1e-6))
    assert waves[held].max() == pytest.approx(16)


def test_reference_map_does_not_change_unnoticed():
    # Written down from this code with NumPy 2: published timings refer to this body.
    z = random_surfaces.reference_map(64, rng=0)[0]
    np.testing.assert_allclose(
        z[[0, 5], [0, 40]], [-1.725145206997369e-07, 1.1729079876084779e-07], rtol=1e-9
    )
    assert abs(random_surfaces.reference_map(64, rng=1)[0] - z).max() > 1e-7


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rms_height": 0.0}, "^rms_height must be positive"),
        ({"hurst": 1.2}, r"^hurst must be in \[0, 1\], got 1.2"),
        ({"cutoff_wavelength": 1e-6}, "^cutoff_wavelength must be at least two pixels"),
        ({"cutoff_wavelength": 3e-5}, "^cutoff_wavelength must not exceed"),
        ({"rolloff_wavelength": 3e-4, "cutoff_wavelength": 2e-4}, "^no wave"),
    ],
)
def test_invalid_spectrum_raises_input_error(change, message):
    with pytest.raises(InputError, match=message):
        make((64, 64), (1e-4, 1e-4), **change)


def test_amplitudes_go_down_to_two_pixels():
    waves = random_surfaces.random_amplitudes((64, 64), (1e-6, 1e-6), np.random.default_rng(3))
    # 2.2 pixels: 29 periods on a side of 64.
    assert waves[0, 29] != 0
    assert waves[29, 0] != 0
    assert waves[0, 0] == 0
