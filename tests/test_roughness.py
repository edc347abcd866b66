import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, ndimage, stats

from roughcontact.errors import InputError
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface

LENGTHS = {"Sq", "Sa", "Sp", "Sv", "Sz", "Sk", "Spk", "Svk", "Vmp", "Vmc", "Vvc", "Vvv"}
PURE = {"Ssk", "Sku", "Str", "Smr1", "Smr2"}


def gaussian_map(
    shape: tuple[int, int], correlation: tuple[float, float], seed: int = 0
) -> np.ndarray:
    """Return a periodic Gaussian map with the correlation exp(-y²/4a² - x²/4b²) in pixels."""
    noise = np.random.default_rng(seed).normal(size=shape)
    return ndimage.gaussian_filter(noise, correlation, mode="wrap", truncate=6)


def test_rms_height_of_a_sine() -> None:
    x = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    heights = 3e-6 * np.sin(x) + np.zeros((5, 1))
    assert roughness.rms_height(heights) == pytest.approx(3e-6 / np.sqrt(2), rel=1e-14)


def test_rms_height_far_from_zero() -> None:
    # The naive mean of squares would return noise of order 1 here.
    heights = 1e8 + np.tile([-1.0, 1.0], (50, 50))
    assert roughness.rms_height(heights) == pytest.approx(1.0, rel=1e-12)


def test_rms_height_leaves_out_missing_points() -> None:
    rng = np.random.default_rng(1)
    heights = rng.normal(size=(30, 40))
    heights[rng.random(heights.shape) < 0.3] = np.nan
    there = heights[~np.isnan(heights)]
    assert roughness.rms_height(heights) == pytest.approx(there.std(), rel=1e-14)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 10), st.floats(0.1, 10))
def test_rms_gradient_of_a_plane(slope_y: float, slope_x: float, dy: float, dx: float) -> None:
    y, x = np.mgrid[:7, :11]
    heights = slope_y * dy * y + slope_x * dx * x
    expected = np.hypot(slope_y, slope_x)
    # Heights up to 400 carry rounding of 5e-14, divided by a pixel of 0.1 at least.
    assert roughness.rms_gradient(heights, (dy, dx)) == pytest.approx(expected, abs=2e-12)


def test_rms_gradient_counts_points_with_both_differences() -> None:
    heights = np.array([[0.0, 1.0, 5.0], [0.0, 2.0, np.nan], [0.0, 0.0, 0.0]])
    # Point (1, 1): 2 along x, 1 along y; (2, 1): 0 and -2; (1, 2) and (2, 2) lack a neighbour.
    assert roughness.rms_gradient(heights, (1.0, 1.0)) == pytest.approx(np.sqrt((5 + 4) / 2))


def test_blocks_do_not_change_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = np.random.default_rng(2).normal(size=(37, 23))
    whole = roughness.rms_height(heights), roughness.rms_gradient(heights, (1.0, 2.0))
    monkeypatch.setattr(roughness, "_BLOCK", 23 * 5)
    blocked = roughness.rms_height(heights), roughness.rms_gradient(heights, (1.0, 2.0))
    assert blocked == pytest.approx(whole, rel=1e-13)


@pytest.mark.parametrize(
    "heights", [np.full((3, 3), np.nan), np.array([[1.0, np.nan], [np.nan, 1.0]])]
)
def test_no_gradient_without_neighbours(heights: np.ndarray) -> None:
    with pytest.raises(InputError, match="no gradient"):
        roughness.rms_gradient(heights, (1.0, 1.0))


def test_no_height_without_points() -> None:
    with pytest.raises(InputError, match="missing"):
        roughness.rms_height(np.full((3, 3), np.nan))


def test_height_parameters_of_a_wave() -> None:
    # Power sums over whole periods are exact up to the order of points per period; |cos| and the
    # crests need the limit of many points: 1024 leave an error of order (2π/1024)²/24 = 2e-6.
    wave = 3e-6 * np.cos(2 * np.pi * np.arange(4096) / 1024) + np.zeros((3, 1)) + 0.5
    values = roughness.height_parameters(wave)
    assert values["Sq"] == pytest.approx(3e-6 / math.sqrt(2), rel=1e-9)
    assert values["Sa"] == pytest.approx(2 * 3e-6 / math.pi, rel=1e-5)
    assert values["Ssk"] == pytest.approx(0, abs=1e-9)
    assert values["Sku"] == pytest.approx(1.5, rel=1e-9)
    assert values["Sp"] == pytest.approx(3e-6, rel=1e-9)
    assert values["Sv"] == pytest.approx(3e-6, rel=1e-9)
    assert values["Sz"] == values["Sp"] + values["Sv"] == pytest.approx(6e-6, rel=1e-9)


def test_height_parameters_of_gaussian_heights() -> None:
    heights = 2e-7 * np.random.default_rng(3).normal(size=(600, 800))
    values = roughness.height_parameters(heights)
    # Standard deviations of Ssk and Sku: √(6/n) = 0.0035 and √(24/n) = 0.007; four of them.
    assert values["Sa"] == pytest.approx(math.sqrt(2 / math.pi) * values["Sq"], rel=2e-3)
    assert values["Ssk"] == pytest.approx(0, abs=0.014)
    assert values["Sku"] == pytest.approx(3, abs=0.028)


def test_height_parameters_against_scipy_with_holes() -> None:
    rng = np.random.default_rng(4)
    heights = rng.gamma(2.0, size=(70, 50))
    heights[rng.random(heights.shape) < 0.2] = np.nan
    there = heights[~np.isnan(heights)]
    values = roughness.height_parameters(heights)
    assert values["Ssk"] == pytest.approx(stats.skew(there), rel=1e-12)
    assert values["Sku"] == pytest.approx(stats.kurtosis(there, fisher=False), rel=1e-12)
    assert values["Sa"] == pytest.approx(np.abs(there - there.mean()).mean(), rel=1e-12)
    assert values["Sp"] == pytest.approx(there.max() - there.mean(), rel=1e-12)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 10), st.floats(0.1, 10))
def test_developed_area_of_a_plane(slope_y: float, slope_x: float, dy: float, dx: float) -> None:
    y, x = np.mgrid[:7, :11]
    heights = slope_y * dy * y + slope_x * dx * x
    expected = math.sqrt(1 + slope_y**2 + slope_x**2) - 1
    assert roughness.developed_area_ratio(heights, (dy, dx)) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("amplitude", [1e-9, 1e-2, 1.0, 20.0])
def test_gradient_and_developed_area_of_a_wave(amplitude: float) -> None:
    n, wavelength = 2048, 100.0
    dx = wavelength / n
    q = 2 * math.pi / wavelength
    wave = amplitude * np.cos(q * dx * np.arange(n + 1)) + np.zeros((2, 1))
    slope = amplitude * q
    # Differences shorten the slope by sinc(π/n): 4e-7.
    assert roughness.rms_gradient(wave, (3.0, dx)) == pytest.approx(slope / 2**0.5, rel=1e-6)
    exact = integrate.quad(lambda t: math.sqrt(1 + (slope * math.sin(t)) ** 2), 0, math.pi)[0]
    if slope > 0.1:
        expected = exact / math.pi - 1
        tolerance = 2e-6
    else:
        expected = slope**2 / 4  # to second order; the next is -3/64 slope⁴
        tolerance = 2e-6 + slope**2
    ratio = roughness.developed_area_ratio(wave, (3.0, dx))
    assert ratio == pytest.approx(expected, rel=tolerance, abs=0)


def test_developed_area_leaves_out_cells_with_a_hole() -> None:
    heights = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, np.nan]])
    assert roughness.developed_area_ratio(heights, (1.0, 1.0)) == pytest.approx(2**0.5 - 1)
    with pytest.raises(InputError, match="no area"):
        roughness.developed_area_ratio(heights[:, 1:], (1.0, 1.0))


@pytest.mark.parametrize(("shape", "holes"), [((9, 12), 0.0), ((8, 5), 0.3), ((13, 6), 0.5)])
def test_autocorrelation_against_its_definition(shape: tuple[int, int], holes: float) -> None:
    rng = np.random.default_rng(5)
    heights = 1e3 + rng.normal(size=shape)
    heights[rng.random(shape) < holes] = np.nan
    z = heights - np.nanmean(heights)
    function = roughness.autocorrelation(heights)
    ny, nx = shape
    assert function.shape == (2 * (ny // 2) + 1, nx // 2 + 1)
    for j in range(-(ny // 2), ny // 2 + 1):
        for i in range(nx // 2 + 1):
            here = z[max(0, -j) : ny - max(0, j), : nx - i]
            there = z[max(0, j) : ny - max(0, -j), i:]
            expected = np.nanmean(here * there) / np.nanmean(z * z)
            assert function[j + ny // 2, i] == pytest.approx(expected, abs=1e-10)


def test_autocorrelation_without_pairs_is_unknown() -> None:
    heights = np.full((8, 8), np.nan)
    heights[:2] = np.random.default_rng(6).normal(size=(2, 8))
    function = roughness.autocorrelation(heights)
    assert np.isnan(function[[0, 1, 2, 6, 7, 8]]).all()
    assert np.isfinite(function[3:6]).all()


def test_correlation_lengths_of_a_cosine() -> None:
    # Forty periods: the overlap holds no whole number of them, an error of 1/(2π·2·40) = 0.2 %.
    wave = np.cos(2 * np.pi * np.arange(2000)[:, None] / 50) + np.zeros((1, 8))
    fastest, slowest = roughness.autocorrelation_lengths(wave, (2e-6, 5e-6))
    assert fastest == pytest.approx(100e-6 * math.acos(0.2) / (2 * math.pi), rel=5e-3)
    assert slowest == math.inf
    values = roughness.summary(wave, (2e-6, 5e-6))
    assert values["Sal"] == fastest
    assert values["Str"] == 0.0


def test_correlation_lengths_of_an_isotropic_surface() -> None:
    heights = gaussian_map((512, 640), (3.0, 3.0))
    # exp(-t²/4a²) = 0.2. The map holds ny·nx/(2πa²) = 5800 independent spots, so f is known to
    # 0.013 and its crossing, where it falls by 0.084 a pixel, to 0.16 pixel or 2 %; three of them.
    expected = 2 * 3.0 * math.sqrt(math.log(5))
    fastest, slowest = roughness.autocorrelation_lengths(heights, (1.0, 1.0))
    assert fastest == pytest.approx(expected, rel=0.06)
    assert slowest == pytest.approx(expected, rel=0.06)
    assert roughness.summary(heights, (1.0, 1.0))["Str"] > 0.9


def test_correlation_lengths_of_ridges_on_unequal_pixels() -> None:
    heights = gaussian_map((600, 600), (24.0, 3.0), seed=1)
    pixel = (0.5e-6, 1e-6)
    fastest, slowest = roughness.autocorrelation_lengths(heights, pixel)
    unit = 2 * math.sqrt(math.log(5))
    assert fastest == pytest.approx(3e-6 * unit, rel=0.06)
    # Along the ridges there are only some ten independent lengths times a hundred ridges.
    assert slowest == pytest.approx(12e-6 * unit, rel=0.15)


def test_correlation_lengths_of_oblique_ridges() -> None:
    y, x = np.mgrid[:512, :512]
    across = (2 * x + y) / math.sqrt(5)
    heights = np.interp(across, np.arange(-10, 1000), gaussian_map((1, 1010), (0.0, 4.0))[0])
    fastest, slowest = roughness.autocorrelation_lengths(heights, (1.0, 1.0))
    # One line of about 50 independent ridges, hence the tolerance.
    assert fastest == pytest.approx(2 * 4 * math.sqrt(math.log(5)), rel=0.25)
    assert slowest == math.inf


def test_correlation_lengths_with_holes() -> None:
    heights = gaussian_map((400, 300), (4.0, 4.0))
    whole = roughness.autocorrelation_lengths(heights, (1.0, 1.0))
    heights[np.random.default_rng(7).random(heights.shape) < 0.3] = np.nan
    holed = roughness.autocorrelation_lengths(heights, (1.0, 1.0))
    assert holed == pytest.approx(whole, rel=0.02)


def test_a_large_threshold_is_met_sooner() -> None:
    heights = gaussian_map((200, 200), (4.0, 4.0))
    near = roughness.autocorrelation_lengths(heights, (1.0, 1.0), threshold=0.5)
    far = roughness.autocorrelation_lengths(heights, (1.0, 1.0), threshold=0.2)
    assert near[0] < far[0]
    with pytest.raises(InputError, match="threshold"):
        roughness.autocorrelation_lengths(heights, (1.0, 1.0), threshold=1.0)


def test_material_ratio_curve_of_a_sample() -> None:
    heights = np.array([[2.0, np.nan, 5.0], [2.0, 3.0, 3.0]])
    ratio, height = roughness.material_ratio_curve(heights)
    assert ratio == pytest.approx([0, 0.1, 0.4, 0.8, 1])
    assert height == pytest.approx([2, 2, 0, -1, -1])


def test_grouping_keeps_the_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = np.random.default_rng(8).gamma(3.0, size=(150, 200))
    whole = {**roughness.core_parameters(*roughness.material_ratio_curve(heights)),
             **roughness.volume_parameters(*roughness.material_ratio_curve(heights))}  # fmt: skip
    monkeypatch.setattr(roughness, "_CURVE_POINTS", 2**12)
    curve = roughness.material_ratio_curve(heights)
    assert 2**11 < curve[0].size <= 2**12 + 2
    assert np.all(np.diff(curve[1]) <= 0)
    grouped = {**roughness.core_parameters(*curve), **roughness.volume_parameters(*curve)}
    assert grouped == pytest.approx(whole, rel=2e-3)


def test_bearing_parameters_of_uniform_heights() -> None:
    n = 40_000
    heights = np.random.default_rng(9).permutation((np.arange(n) + 0.5) / n * 2e-6)
    curve = roughness.material_ratio_curve(heights.reshape(200, 200))
    values = {**roughness.core_parameters(*curve), **roughness.volume_parameters(*curve)}
    expected = {"Sk": 2e-6, "Spk": 0.0, "Svk": 0.0, "Smr1": 0.0, "Smr2": 1.0, "Vmp": 1e-8,
                "Vmc": 63e-8, "Vvc": 77e-8, "Vvv": 4e-8}  # fmt: skip
    # Steps of 1/n at either end.
    assert values == pytest.approx(expected, rel=1e-4, abs=1e-12)


def test_bearing_parameters_of_gaussian_heights() -> None:
    n = 250_000
    z = stats.norm.ppf((np.arange(n) + 0.5) / n)
    curve = roughness.material_ratio_curve(z.reshape(500, 500))
    values = roughness.core_parameters(*curve)
    # The central region is symmetric, 30 to 70 %; its least-squares slope by quadrature.
    moment = integrate.quad(lambda p: (p - 0.5) * stats.norm.isf(p), 0.3, 0.7)[0]
    Sk = -12 * moment / 0.4**3
    Smr1 = stats.norm.sf(Sk / 2)
    Spk = 2 / Smr1 * (stats.norm.pdf(Sk / 2) - Sk / 2 * Smr1)
    expected = {"Sk": Sk, "Spk": Spk, "Svk": Spk, "Smr1": Smr1, "Smr2": 1 - Smr1}
    assert pytest.approx(2.574, abs=1e-3) == Sk
    # The least slope is flat about the middle: the region is found to 1e-3 or so.
    assert values == pytest.approx(expected, rel=1e-3)
    c10, c80 = stats.norm.isf(0.1), stats.norm.isf(0.8)
    volumes = roughness.volume_parameters(*curve)
    assert volumes["Vmp"] == pytest.approx(stats.norm.pdf(c10) - 0.1 * c10, rel=1e-3)
    assert volumes["Vvv"] == pytest.approx(stats.norm.pdf(c80) + 0.2 * c80, rel=1e-3)
    # Vm(p) - Vv(p) = ∫ c - c(p) over all ratios = -c(p), for a mean of zero.
    assert volumes["Vmp"] - volumes["Vvc"] - volumes["Vvv"] == pytest.approx(-c10, rel=1e-4)
    assert volumes["Vmp"] + volumes["Vmc"] - volumes["Vvv"] == pytest.approx(-c80, rel=1e-4)


def test_bearing_parameters_of_a_plateau_with_pits_and_peaks() -> None:
    # Three straight pieces: slopes 20 to 10 %, 1 to 70 %, 10 to 100 %.
    ratio, height = np.array([0, 0.1, 0.7, 1.0]), np.array([2.0, 0.0, -0.6, -3.6])
    values = roughness.core_parameters(ratio, height)
    # The line is 0.1 - r: the curve meets 0.1 at r = 0.095 and -0.9 at r = 0.73.
    expected = {"Sk": 1.0, "Spk": 1.9, "Svk": 2.7, "Smr1": 0.095, "Smr2": 0.73}
    assert values == pytest.approx(expected, rel=1e-12)


def test_bearing_parameters_do_not_see_coarse_digits() -> None:
    heights = gaussian_map((200, 200), (2.0, 2.0))
    heights /= heights.std()
    fine = roughness.core_parameters(*roughness.material_ratio_curve(heights))
    coarse = roughness.core_parameters(*roughness.material_ratio_curve(np.round(heights, 1)))
    assert coarse == pytest.approx(fine, rel=0.02)


def test_volumes_are_means_over_the_points() -> None:
    heights = np.random.default_rng(13).gamma(2.0, size=(200, 300))
    volumes = roughness.volume_parameters(*roughness.material_ratio_curve(heights))
    c10, c80 = np.quantile(heights, [0.9, 0.2], method="hazen")
    direct = {
        "Vmp": np.maximum(heights - c10, 0).mean(),
        "Vmc": np.maximum(heights - c80, 0).mean() - np.maximum(heights - c10, 0).mean(),
        "Vvc": np.maximum(c10 - heights, 0).mean() - np.maximum(c80 - heights, 0).mean(),
        "Vvv": np.maximum(c80 - heights, 0).mean(),
    }
    # The straight pieces of the curve differ from its steps by 1/n².
    assert volumes == pytest.approx(direct, rel=1e-6)


@pytest.mark.parametrize(("peak", "core"), [(0.0, 0.8), (0.8, 0.1), (0.1, 1.0)])
def test_ratios_of_the_volumes_are_in_order(peak: float, core: float) -> None:
    with pytest.raises(InputError, match="0 < peak < core < 1"):
        roughness.volume_parameters(np.array([0.0, 1.0]), np.array([1.0, 0.0]), peak, core)


@pytest.mark.parametrize("shape", [(32, 48), (31, 48), (32, 47), (31, 45)])
def test_spectrum_holds_the_variance(shape: tuple[int, int]) -> None:
    heights = 5.0 + np.random.default_rng(10).normal(size=shape)
    pixel = (2e-6, 0.7e-6)
    q, C, waves = roughness.radial_spectrum(heights, pixel)
    area = heights.size * pixel[0] * pixel[1]
    assert waves.sum() == heights.size - 1
    assert np.all(np.diff(q) > 0)
    assert np.sum(C * waves) / area == pytest.approx(heights.var(), rel=1e-12)


def test_spectrum_integrates_to_the_variance() -> None:
    # Band-limited, with C = 4π a² Sq² exp(-a² q²) for the correlation exp(-t²/4a²).
    a, pixel = 3.0, (1.0, 1.5)
    heights = gaussian_map((400, 300), (a / pixel[0], a / pixel[1]))
    q, C, waves = roughness.radial_spectrum(heights, pixel)
    Sq = roughness.rms_height(heights)
    assert integrate.trapezoid(q * C, q) / (2 * np.pi) == pytest.approx(Sq**2, rel=0.02)
    expected = 4 * np.pi * a**2 * Sq**2 * np.exp(-((a * q) ** 2))
    inner = (q > 0.1) & (q * a < 2)
    # Each shell is a mean over `waves`/2 exponential variates.
    error = (C / expected - 1)[inner] * np.sqrt(waves[inner] / 2)
    assert abs(error.mean()) < 0.6
    assert 0.7 < error.std() < 1.3


def test_spectrum_of_a_wave_is_one_shell() -> None:
    y, x = np.mgrid[:40, :60]
    heights = 2.0 * np.cos(2 * np.pi * (3 * y / 40 + 4 * x / 60))
    q, C, waves = roughness.radial_spectrum(heights, (1.5, 1.0))
    top = int(np.argmax(C))
    assert q[top] * 60 / (2 * np.pi) == pytest.approx(5, abs=0.5)
    # Two of the wave vectors in the shell carry A²/4 each, times the area.
    assert C[top] * waves[top] == pytest.approx(2 * 60 * 60, rel=1e-9)


def test_spectrum_asks_for_a_full_map() -> None:
    heights = np.ones((4, 4))
    heights[1, 2] = np.nan
    with pytest.raises(InputError, match=r"1 missing points; fill or crop.*filled\(\)"):
        roughness.radial_spectrum(heights, (1.0, 1.0))


def test_parameters_against_surfalize() -> None:
    # surfalize 0.19.2, Surface(1e6 * heights, step_x=0.5, step_y=0.8) in micrometres.
    y, x = np.mgrid[:150, :200]
    waves = np.sin(0.31 * x + 0.11 * y) + 0.7 * np.cos(0.23 * y - 0.17 * x + 1)
    waves += 0.5 * np.sin(0.0741 * x + 0.41 * y + 2) + 0.4 * np.cos(0.53 * x - 0.29 * y)
    values = roughness.summary(1e-6 * np.exp(0.4 * waves), (0.8e-6, 0.5e-6))
    peer = {"Sa": 0.340126e-6, "Ssk": 0.859052, "Sku": 3.5032, "Sp": 1.70957e-6,
            "Sv": 0.721507e-6, "Sdr": 0.0372177}  # fmt: skip
    assert {name: values[name] for name in peer} == pytest.approx(peer, rel=5e-6)
    # It rounds ratios to one of 10 000 classes, and interpolates the correlation by cubics.
    rounded = {"Sk": 0.977025e-6, "Smr1": 0.170165, "Smr2": 0.957878, "Spk": 0.626788e-6,
               "Svk": 0.101828e-6, "Vmp": 0.0282769e-6, "Vmc": 0.368418e-6,
               "Vvc": 0.601092e-6, "Vvv": 0.0246033e-6}  # fmt: skip
    assert {name: values[name] for name in rounded} == pytest.approx(rounded, rel=3e-3)
    lengths = {"Sal": 2.53153e-6, "Str": 0.454821}
    assert {name: values[name] for name in lengths} == pytest.approx(lengths, rel=1e-2)


def small_map(seed: int, holes: bool) -> np.ndarray:
    rng = np.random.default_rng(seed)
    heights = gaussian_map((24, 17), (1.5, 0.8), seed) + rng.gamma(2.0, 0.1, size=(24, 17))
    if holes:
        heights[rng.random(heights.shape) < 0.1] = np.nan
    return heights


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.booleans(), st.floats(1e-9, 1e3), st.floats(1e-9, 1e3))
def test_parameters_scale(seed: int, holes: bool, height: float, side: float) -> None:
    heights = small_map(seed, holes)
    before = roughness.summary(heights, (2.0, 3.0))
    after = roughness.summary(height * heights, (2.0 * side, 3.0 * side))
    for name in LENGTHS:
        assert after[name] == pytest.approx(height * before[name], rel=1e-9, abs=1e-12 * height)
    for name in PURE:
        assert after[name] == pytest.approx(before[name], rel=1e-9, abs=1e-12, nan_ok=True)
    assert after["Sal"] == pytest.approx(side * before["Sal"], rel=1e-9, nan_ok=True)
    assert after["Sdq"] == pytest.approx(height / side * before["Sdq"], rel=1e-9)
    same = roughness.summary(height * heights, (2.0 * height, 3.0 * height))
    assert same["Sdr"] == pytest.approx(before["Sdr"], rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.booleans())
def test_parameters_do_not_know_the_axes(seed: int, holes: bool) -> None:
    heights = small_map(seed, holes)
    before = roughness.summary(heights, (2.0, 3.0))
    turned = roughness.summary(np.ascontiguousarray(heights.T), (3.0, 2.0))
    assert turned == pytest.approx(before, rel=1e-9, abs=1e-12, nan_ok=True)
    # The differences of Sdq look back, hence see a mirror in the first and last points.
    del before["Sdq"]
    for mirrored in (heights[::-1], heights[:, ::-1], heights[::-1, ::-1]):
        values = roughness.summary(mirrored, (2.0, 3.0))
        del values["Sdq"]
        assert values == pytest.approx(before, rel=1e-9, abs=1e-12, nan_ok=True)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.floats(-10, 10))
def test_peaks_become_dales_upside_down(seed: int, shift: float) -> None:
    heights = small_map(seed, holes=True)
    before = roughness.summary(heights, (1.0, 1.0))
    after = roughness.summary(shift - heights, (1.0, 1.0))
    for name in ("Sq", "Sa", "Sku", "Sz", "Sdq", "Sdr", "Sal", "Str"):
        assert after[name] == pytest.approx(before[name], rel=1e-9, abs=1e-9, nan_ok=True)
    assert after["Ssk"] == pytest.approx(-before["Ssk"], abs=1e-9)
    for name, other in (("Sp", "Sv"), ("Spk", "Svk")):
        assert after[name] == pytest.approx(before[other], rel=1e-8, abs=1e-9)
    assert after["Smr1"] == pytest.approx(1 - before["Smr2"], abs=1e-8)


def test_summary_of_a_flat_map() -> None:
    values = roughness.summary(np.full((5, 6), 0.1), (1.0, 1.0))
    unknown = {name for name, value in values.items() if math.isnan(value)}
    assert unknown == {"Ssk", "Sku", "Sal", "Str"}
    assert {values[name] for name in LENGTHS - {"Sq"}} | {values["Sdq"], values["Sdr"]} <= {0.0}
    assert values["Sq"] == pytest.approx(0, abs=1e-16)


def test_summary_does_not_depend_on_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = small_map(11, holes=True)
    whole = roughness.summary(heights, (1.0, 2.0))
    spectrum = roughness.radial_spectrum(small_map(11, holes=False), (1.0, 2.0))
    monkeypatch.setattr(roughness, "_BLOCK", 17 * 5)
    assert roughness.summary(heights, (1.0, 2.0)) == pytest.approx(whole, rel=1e-12, abs=1e-14)
    blocked = roughness.radial_spectrum(small_map(11, holes=False), (1.0, 2.0))
    for one, other in zip(spectrum, blocked, strict=True):
        assert one == pytest.approx(other, rel=1e-12)


def test_a_surface_knows_its_roughness() -> None:
    surface = Surface(1e-6 * small_map(12, holes=True), pixel=(1e-6, 2e-6))
    values = surface.roughness()
    assert set(values) == LENGTHS | PURE | {"Sal", "Sdq", "Sdr"}
    assert values["Sq"] == surface.Sq
    assert values["Sdq"] == surface.Sdq


@pytest.mark.parametrize("function", [
    roughness.height_parameters, roughness.autocorrelation, roughness.material_ratio_curve,
])  # fmt: skip
def test_nothing_without_points(function) -> None:
    with pytest.raises(InputError, match="every point is missing"):
        function(np.full((3, 3), np.nan))
