import re

import numpy as np
import pytest
from hypothesis import given, strategies as st

from maps import rough
from roughcontact.errors import InputError
from roughcontact.surface import filters
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

PIXEL = (2e-6, 3e-6)


# --- Gaussian filter ---------------------------------------------------------------------------


def transmission(wavelength: float, cutoff: float, axis: int) -> float:
    """Amplitude that a cosine along an axis keeps in the middle of a long map, pixel 1."""
    length = 2 * int(3 * max(cutoff, 2) + 2 * wavelength) + 1
    across = int(np.ceil(cutoff)) + 2
    t = np.arange(length) - length // 2
    wave = np.cos(2 * np.pi * t / wavelength)
    heights = np.tile(wave, (across, 1))
    smooth = filters.gaussian_lowpass(heights if axis else heights.T, (1.0, 1.0), cutoff)
    return float((smooth if axis else smooth.T)[across // 2, length // 2])


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("cutoff", [2.0, 2.5, 3.0, 4.0, 6.0, 7.9, 8.1, 10.0, 33.3, 250.0])
def test_half_of_a_wave_passes_at_the_cutoff(cutoff: float, axis: int) -> None:
    # The rounding of the weights, and 1e-14 cut off; above 8 pixels, 2^-48 of aliasing.
    assert transmission(cutoff, cutoff, axis) == pytest.approx(0.5, abs=1e-8)


@pytest.mark.parametrize("ratio", [0.3, 0.5, 0.8, 1.25, 2.0, 5.0])
def test_transmission_is_that_of_the_standard(ratio: float) -> None:
    # ISO 16610-21: exp(-π (α λc/λ)²) = 2^-(λc/λ)².
    expected = 2 ** -(ratio**-2)
    assert transmission(ratio * 40, 40, 1) == pytest.approx(expected, abs=1e-9)


def test_agrees_with_the_sum_over_all_points() -> None:
    shape, pixel, cutoff = (17, 23), (1.0, 1.5), 12.0
    heights = rough(1, shape, holes=0.3)
    there = np.isfinite(heights)
    y, x = (np.arange(n) * edge for n, edge in zip(shape, pixel, strict=True))
    alpha = np.sqrt(np.log(2) / np.pi)
    smooth = filters.gaussian_lowpass(heights, pixel, cutoff)
    np.testing.assert_array_equal(np.isnan(smooth), ~there)
    for j, i in np.argwhere(there)[::7]:
        square = ((y[:, None] - y[j]) ** 2 + (x - x[i]) ** 2) / (alpha * cutoff) ** 2
        weight = np.where(there, np.exp(-np.pi * square), 0)
        mean = np.nansum(weight * np.where(there, heights, 0)) / weight.sum()
        assert smooth[j, i] == pytest.approx(mean, abs=1e-12)


@given(st.integers(0, 1000), st.floats(6, 40), st.sampled_from([0, 0.2]))
def test_filter_bands_add_up_to_map(seed: int, cutoff: float, holes: float) -> None:
    heights = rough(seed, (30, 27), holes)
    parts = filters.gaussian_band(heights, PIXEL, s=cutoff * 1e-6) + filters.gaussian_band(
        heights, PIXEL, l=cutoff * 1e-6
    )
    np.testing.assert_allclose(parts, heights, atol=1e-14)


def test_band_is_one_filter_after_the_other() -> None:
    heights = rough(3, (40, 30), 0.1)
    smooth = filters.gaussian_lowpass(heights, PIXEL, 9e-6)
    expected = smooth - filters.gaussian_lowpass(smooth, PIXEL, 4e-5)
    np.testing.assert_array_equal(filters.gaussian_band(heights, PIXEL, 9e-6, 4e-5), expected)


def test_filter_by_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = rough(5, (37, 23), holes=0.1)
    whole = filters.gaussian_lowpass(heights, PIXEL, 2e-5)
    monkeypatch.setattr(filters, "_BLOCK", 200)
    np.testing.assert_allclose(filters.gaussian_lowpass(heights, PIXEL, 2e-5), whole, atol=1e-14)


@pytest.mark.parametrize("cutoff", [5.9e-6, 7e-5, 0.0, -1e-5, np.nan, "2 mm"])
def test_cutoffs_the_map_cannot_hold(cutoff) -> None:
    # Two pixels are 6 µm, the sides 80 and 60 µm.
    for call in (
        lambda: filters.gaussian_lowpass(np.zeros((40, 20)), PIXEL, cutoff),
        lambda: filters.gaussian_band(np.zeros((40, 20)), PIXEL, s=cutoff),
        lambda: filters.gaussian_band(np.zeros((40, 20)), PIXEL, l=cutoff),
    ):
        with pytest.raises(InputError, match=r"^(s|l|cutoff) must"):
            call()


def test_band_refuses() -> None:
    with pytest.raises(InputError, match="s or l must be given"):
        filters.gaussian_band(np.zeros((40, 20)), PIXEL)
    with pytest.raises(InputError, match="s must be below l"):
        filters.gaussian_band(np.zeros((40, 20)), PIXEL, 2e-5, 1e-5)


# --- resampling --------------------------------------------------------------------------------


@given(*[st.integers(2, 16)] * 4, st.integers(0, 1000))
def test_finer_and_back_is_exact_for_any_map(
    ny: int, nx: int, more_y: int, more_x: int, seed: int
) -> None:
    heights = rough(seed, (ny, nx))
    finer = filters.resample(heights, (ny + more_y, nx + more_x))
    assert finer.mean() == pytest.approx(heights.mean(), abs=1e-14)
    np.testing.assert_allclose(filters.resample(finer, (ny, nx)), heights, atol=1e-13)


@given(*[st.integers(2, 12)] * 2, st.integers(0, 1000))
def test_a_finer_map_passes_through_the_points(ny: int, nx: int, seed: int) -> None:
    # At three times the points, every third centre is an old one.
    heights = rough(seed, (ny, nx))
    finer = filters.resample(heights, (3 * ny, 3 * nx))
    np.testing.assert_allclose(finer[1::3, 1::3], heights, atol=1e-13)


@pytest.mark.parametrize("shape", [(36, 50), (12, 14), (13, 15), (36, 9), (24, 20)])
def test_waves_stay_where_they_are(shape: tuple[int, int]) -> None:
    def wave(ny: int, nx: int) -> np.ndarray:
        y, x = ((np.arange(n) + 0.5) / n for n in (ny, nx))
        return 3 + np.cos(2 * np.pi * (2 * x - 3 * y[:, None]) + 0.3)

    np.testing.assert_allclose(filters.resample(wave(24, 20), shape), wave(*shape), atol=1e-13)


def test_the_spline_reproduces_cubics() -> None:
    def cubic(ny: int, nx: int) -> np.ndarray:
        y, x = ((np.arange(n) + 0.5) / n for n in (ny, nx))
        return x**3 - 2 * x * y[:, None] ** 2 + y[:, None] ** 3 - 1

    for shape in ((30, 40), (7, 5), (15, 6)):
        new = filters.resample(cubic(9, 12), shape, "spline")
        np.testing.assert_allclose(new, cubic(*shape), atol=1e-13)


@pytest.mark.parametrize("method", ["bandlimited", "spline"])
def test_the_same_grid_keeps_its_bits(method: str) -> None:
    heights = rough(1, (5, 6))
    same = filters.resample(heights, (5, 6), method)
    assert same.tobytes() == heights.tobytes()
    assert not np.shares_memory(same, heights)


def test_resample_refuses() -> None:
    heights = rough(1, (5, 6))
    with pytest.raises(InputError, match="bandlimited, spline, got 'linear'"):
        filters.resample(heights, (4, 4), "linear")
    for shape in ((1, 5), (4,), (4, 4.0), 4, (True, 4)):
        with pytest.raises(
            InputError, match=r"shape must be two integers \(ny, nx\) of at least 2"
        ):
            filters.resample(heights, shape)
    with pytest.raises(InputError, match=r"two integers \(ny, nx\) of a profile \(1, nx\)"):
        filters.resample(heights[:1], (2, 6))
    with pytest.raises(InputError, match="4 × 4 points, got 3 × 6"):
        filters.resample(heights[:3], (4, 4), "spline")
    heights[2, 2] = np.nan
    with pytest.raises(InputError, match="1 missing points; fill or crop"):
        filters.resample(heights, (4, 4))


# --- on a surface --------------------------------------------------------------------------------


def ball() -> Surface:
    y, x = ((np.arange(n) - 0.5 * n) * e for n, e in zip((40, 50), PIXEL, strict=True))
    heights = np.sqrt(1e-6 - x**2 - y[:, None] ** 2) + 1e-9 * rough(1, (40, 50))
    return Surface(heights, PIXEL, Provenance("ball.x3p", steps=("made",)))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: s.leveled("robust"), "robust plane"),
        (lambda s: s.leveled("three-point", [(0, 0), (9, 0), (0, 9)]), r"\(9, 0\), \(0, 9\)"),
        (lambda s: s.without_form("sphere"), r"convex sphere of radius \d+\.\d+ µm$"),
        (lambda s: s.without_form("polynomial", degree=3), "degree 3, .* [nµ]m rms"),
        (lambda s: s.without_outliers(99), "0 points further than 99 robust.*5 × 5"),
        (lambda s: s.largest_rectangle(), "rows 0:40, columns 0:50"),
        (lambda s: s.rotated(-90), "270 degrees counter-clockwise"),
        (lambda s: s.resampled((20, 30)), "periodic, from 40 × 50 to 20 × 30"),
        (lambda s: s.resampled(pixel=(1e-6, 1e-6), method="spline"), "cubic spline.*80 × 150"),
        (lambda s: s.filtered(s=8e-6, l=6e-5), "S-filter at 8 µm and L-filter at 60 µm"),
    ],
)
def test_every_step_returns_copy_with_provenance(call, words: str) -> None:
    surface = ball()
    before = surface.heights.tobytes()
    prepared = call(surface)
    assert surface.heights.tobytes() == before
    assert surface.provenance.steps == ("made",)
    assert prepared.provenance.source == "ball.x3p"
    assert len(prepared.provenance.steps) == 2
    assert re.search(words, prepared.provenance.steps[-1])


def test_size_and_pixel_follow() -> None:
    surface = ball()
    assert surface.rotated().pixel == (3e-6, 2e-6)
    assert surface.rotated(180).pixel == (2e-6, 3e-6)
    for new in (surface.resampled((33, 20)), surface.resampled(pixel=(1.1e-6, 7e-6))):
        assert new.size == pytest.approx(surface.size, rel=1e-14)
    assert surface.resampled(pixel=(1.1e-6, 7e-6)).shape == (73, 21)
    with pytest.raises(InputError, match="exclude"):
        surface.resampled((4, 4), pixel=PIXEL)
    with pytest.raises(InputError, match="shape or pixel"):
        surface.resampled()
    with pytest.raises(InputError, match="at most half"):
        surface.resampled(pixel=(1.0, 1.0))


def test_new_holes_are_not_masked_by_an_old_promise() -> None:
    heights = 1e-9 * rough(1, (20, 20))
    heights[3, 3] = np.nan
    masked = Surface(heights, PIXEL).masked()
    assert masked.without_outliers(limit=50).holes_masked
    heights[9, 9] = 1.0
    cleaned = Surface(heights, PIXEL).masked().without_outliers()
    assert cleaned.missing == 2
    assert not cleaned.holes_masked


# --- one axis at a time ---------------------------------------------------------------------------


@given(st.integers(0, 1000), st.floats(2, 15), st.sampled_from([0, 0.2]))
def test_equal_cutoffs_along_both_axes_are_the_areal_filter(
    seed: int, cutoff: float, holes: float
) -> None:
    heights = rough(seed, (15, 18), holes)
    smooth = filters.along_axes(heights, (cutoff, cutoff))
    np.testing.assert_array_equal(smooth, filters.gaussian_lowpass(heights, (1.0, 1.0), cutoff))


def test_filter_along_one_axis() -> None:
    heights = rough(5, (20, 30))
    smooth = filters.along_axes(heights, (0.0, 6.0))
    # Each row by itself: a map of one row repeated.
    for row in (0, 7, 19):
        alone = filters.gaussian_lowpass(np.tile(heights[row], (30, 1)), (1.0, 1.0), 6.0)
        np.testing.assert_allclose(smooth[row], alone[0], rtol=0, atol=1e-13)
    across = filters.along_axes(heights.T, (6.0, 0.0)).T
    np.testing.assert_allclose(across, smooth, rtol=0, atol=1e-14)
    np.testing.assert_allclose(filters.along_axes(heights, (0.0, 0.0)), heights, atol=1e-15)


@pytest.mark.parametrize("cutoffs", [(1.9, 4.0), (4.0, -1.0), (np.nan, 4.0), (4.0, np.inf)])
def test_invalid_cutoffs_along_axes_raise_input_error(cutoffs: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="cutoffs must be 0 or at least two pixels"):
        filters.along_axes(rough(1, (8, 8)), cutoffs)
