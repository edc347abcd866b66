"""Physics of the virtual microscopes that judge intervals, by independent calculations."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import interval_coverage
import virtual_microscope as microscope


def wave(points: int, length: float, phase: float = 0.3) -> np.ndarray:
    """Return a wave along x that repeats after the points."""
    return np.tile(np.cos(2 * np.pi * np.arange(points) / length + phase), (points, 1))


def amplitude_of(heights: np.ndarray) -> float:
    return float(np.std(heights)) * math.sqrt(2)


def test_microscope_imports_numpy_and_scipy_only() -> None:
    tree = ast.parse(Path(microscope.__file__).read_text(encoding="utf-8"))
    froms = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    names = {
        name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names
    }
    modules = {str(name).partition(".")[0] for name in froms | names}
    assert modules == {"__future__", "collections", "dataclasses", "math", "numpy", "scipy"}


def test_pupil_transfer_matches_autocorrelation_of_disc() -> None:
    points, radius = 512, 120
    x = np.arange(points) - points / 2
    disc = np.hypot(*np.meshgrid(x, x)) <= radius
    overlap = np.fft.irfft2(np.abs(np.fft.rfft2(disc)) ** 2)[0, : 2 * radius + 1]
    found = microscope.pupil_transfer(np.arange(2 * radius + 1) / (2 * radius))
    np.testing.assert_allclose(found, overlap / overlap[0], atol=2e-3)
    assert microscope.pupil_transfer(1.5) == 0


@pytest.mark.parametrize("kind", ["diffraction", "gaussian"])
def test_blur_halves_wave_of_resolution(kind: str) -> None:
    seen = microscope.blur(wave(96, 16), kind, 16)
    assert amplitude_of(seen) == pytest.approx(0.5, rel=1e-9)
    # Over a long wave a pupil is less faithful than a Gaussian of the same resolution.
    long = amplitude_of(microscope.blur(wave(96, 96), kind, 16))
    expected = {"diffraction": 1 - 4 / np.pi * 0.404 / 6, "gaussian": 1 - math.log(2) / 36}
    assert long == pytest.approx(expected[kind], abs=1e-3)


def test_pixels_average_their_points() -> None:
    q = 1 / 16
    seen = microscope.average_pixels(wave(96, 1 / q))
    expected = math.sin(4 * math.pi * q) / (4 * math.sin(math.pi * q))
    assert seen.shape == (24, 24)
    assert amplitude_of(seen) == pytest.approx(expected, rel=1e-9)


def test_ball_matches_search_over_all_points() -> None:
    rng, points = np.random.default_rng(4), 40
    heights = microscope.remove_short_waves(rng.standard_normal((points, points)), 8)
    heights *= 0.3 / microscope.rms_slope(heights)
    radius = 18.0
    seen = microscope.dilate_with_ball(heights, radius)
    x = np.arange(-points // 2, points // 2)
    square = np.add.outer(x**2, x**2)
    ball = np.where(square < radius**2, np.sqrt(np.maximum(radius**2 - square, 0)), -np.inf)
    for row, column in rng.integers(points, size=(60, 2)):
        around = np.roll(heights, (points // 2 - row, points // 2 - column), (0, 1))
        # The center of the ball comes down until the first point touches.
        center = np.max(around + ball)
        assert seen[row, column] == pytest.approx(center - radius, abs=1e-12)


@pytest.mark.parametrize("number", range(6))
def test_surface_has_stated_waves_and_finish(number: int) -> None:
    case = microscope.draw_measurement(number, "gaussian")
    power = np.abs(np.fft.rfft2(case.heights)) ** 2
    waves = microscope.wave_number(case.heights.shape)
    assert power[waves > 1.001 / case.shortest_wave].max() < 1e-20 * power.max()
    steps = [float(np.std(case.heights - np.roll(case.heights, 1, axis))) for axis in (0, 1)]
    assert 0.045 < math.hypot(*steps) < 0.155
    assert 8 <= case.shortest_wave <= 32
    skew, across, along = (
        stats.skew(case.heights, axis=None),
        *(float(np.std(slope)) for slope in microscope.gradient(case.heights)),
    )
    assert (skew < -0.8) == (case.finish == "honed")
    if case.finish in ("lapped", "bifractal", "blasted"):
        assert across == pytest.approx(along, rel=0.15)


def test_lapped_spectrum_falls_with_hurst_exponent() -> None:
    rng = np.random.default_rng(1)
    field = microscope.random_field(microscope.self_affine_amplitude(0.7, 100), rng)
    power = np.abs(np.fft.rfft2(field)) ** 2
    waves = microscope.wave_number(field.shape)
    bands = [power[(waves > low) & (waves < 1.1 * low)].mean() for low in (0.02, 0.04, 0.08)]
    np.testing.assert_allclose(np.diff(np.log2(bands)), -2 - 2 * 0.7, atol=0.3)


def test_number_has_one_surface_and_one_draw_under_all_instruments() -> None:
    cases = [microscope.draw_measurement(7, kind) for kind in microscope.KINDS]
    for case in cases[1:]:
        np.testing.assert_array_equal(case.heights, cases[0].heights)
        assert case.stated_resolution == cases[0].stated_resolution
        assert case.pressure == cases[0].pressure
    np.testing.assert_array_equal(
        microscope.draw_measurement(7, "tip").image, cases[2].image, strict=True
    )


def test_missing_points_are_clustered_on_steep_places() -> None:
    case = microscope.draw_measurement(1, "gaussian")
    lost = np.isnan(case.image)
    assert lost.mean() == pytest.approx(0.04, abs=0.001)
    seen = microscope.average_pixels(microscope.blur(case.heights, "gaussian", case.resolution))
    steep = np.hypot(*microscope.gradient(seen))
    assert steep[lost].mean() > 1.2 * steep.mean()
    assert lost[np.roll(lost, 1, 0) | np.roll(lost, 1, 1)].mean() > 0.3


def test_noise_is_white_and_as_drawn() -> None:
    case = microscope.draw_measurement(3, "diffraction")
    seen = microscope.average_pixels(microscope.blur(case.heights, "diffraction", case.resolution))
    noise = case.image - seen
    assert noise.std() == pytest.approx(case.noise, rel=0.03)
    assert 0.001 <= case.noise / case.heights.std() <= 0.03
    assert abs(np.mean(noise * np.roll(noise, 1, 0))) < 0.05 * case.noise**2


def test_true_surface_is_drawn_surface_between_points() -> None:
    case = interval_coverage.draw_case(0, "gaussian")
    drawn = microscope.draw_measurement(0, "gaussian").heights
    np.testing.assert_allclose(
        case.surface.heights[::2, ::2], interval_coverage.SPACING * drawn, atol=1e-18
    )
    assert case.surface.size == pytest.approx(case.map.size)
    assert case.surface.Sdq == pytest.approx(microscope.rms_slope(drawn), rel=0.02)


def test_share_has_clopper_pearson_interval() -> None:
    known = stats.binomtest(17, 20).proportion_ci()
    expected = f"0.850 ({known.low:.3f} to {known.high:.3f}) 20"
    assert interval_coverage.format_share(17, 20) == expected
