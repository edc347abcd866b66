"""Theories behind the formulas of nominally flat contact, each against an independent result."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate, ndimage, stats

import roughcontact as rc
from roughcontact.theory import greenwood_williamson as gw, height_distribution, persson

HEIGHTS = {
    "normal": stats.norm(),
    "lognormal": stats.lognorm(0.4),
    "long tails": stats.johnsonsu(0.4, 1.5),
    "plateaus": stats.johnsonsu(1.2, 1.8),
    "two levels": stats.johnsonsb(0.4, 0.7),
}


@pytest.mark.parametrize("name", HEIGHTS)
@pytest.mark.parametrize("ratio", [1e-4, 0.05, 0.5, 0.98])
def test_the_gap_below_a_plane_is_its_integral(name: str, ratio: float) -> None:
    of = HEIGHTS[name]
    _, variance, skewness, kurtosis = map(float, of.stats("mvsk"))
    plane = of.isf(ratio)
    expected, _ = integrate.quad(lambda z: (plane - z) * of.pdf(z), of.ppf(1e-14), plane, limit=200)
    found = height_distribution.gap_below_plane(
        np.array([ratio]), np.array([skewness]), np.array([kurtosis + 3])
    )
    assert found[0] == pytest.approx(expected / np.sqrt(variance), rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("power", [0, 1, 1.5])
@pytest.mark.parametrize("separation", [-2.0, 0.0, 1.3, 4.0])
def test_the_integrals_of_greenwood_and_williamson(power: float, separation: float) -> None:
    def integrand(s: float) -> float:
        return (s - separation) ** power * float(stats.norm.pdf(s))

    expected, _ = integrate.quad(integrand, separation, np.inf, epsabs=1e-14)
    assert gw.excess(power, np.array([separation]))[0] == pytest.approx(expected, rel=1e-6)


def test_summits_are_those_that_one_counts() -> None:
    # The shortest wave has 16 pixels, so that a summit is a pixel above its eight neighbours.
    n, pixel = 1024, 1e-6
    surface = rc.generate(
        (n, n),
        (pixel, pixel),
        Sq=1e-6,
        rolloff_wavelength=24 * pixel,
        cutoff_wavelength=16 * pixel,
        rng=5,
    )
    z: NDArray[np.float64] = surface.heights
    m0 = float(np.mean(z * z))
    slopes = [(np.roll(z, -1, axis) - np.roll(z, 1, axis)) / (2 * pixel) for axis in (0, 1)]
    bends = [(np.roll(z, -1, a) - 2 * z + np.roll(z, 1, a)) / pixel**2 for a in (0, 1)]
    m2 = float(np.mean([np.mean(s * s) for s in slopes]))
    m4 = float(np.mean([np.mean(b * b) for b in bends]))
    expected = gw.summits(m0, m2, m4)
    tops = z == ndimage.maximum_filter(z, size=3, mode="wrap")
    count = int(tops.sum())
    # Some 1200 of them: their number scatters by 2 %, a standard deviation by as much.
    assert count > 1000
    assert expected.density == pytest.approx(count / (n * pixel) ** 2, rel=0.06)
    assert expected.mean_height == pytest.approx(float(z[tops].mean()), rel=0.05)
    assert expected.deviation == pytest.approx(float(z[tops].std()), rel=0.06)
    curvature = -(bends[0] + bends[1])[tops] / 2
    assert 1 / expected.radius == pytest.approx(float(curvature.mean()), rel=0.05)


def test_a_surface_of_one_wavelength_is_the_least_of_bandwidths() -> None:
    with pytest.raises(rc.InputError, match=r"at least 1\.5"):
        gw.summits(1.0, 1.0, 1.4)


@pytest.mark.parametrize("ceiling", [0.7, 1.5, 6.0])
def test_both_forms_of_the_diffusion_agree(ceiling: float) -> None:
    # Where they meet, √V is half the ceiling; on either side of it the other form is as good.
    mean = np.linspace(0.02, 0.95, 12) * ceiling
    for share in (0.4, 0.5, 0.6):
        deviation, limit = np.full_like(mean, share * ceiling), np.full_like(mean, ceiling)
        images = persson._by_images(mean, deviation, limit)
        waves = persson._by_waves(mean, deviation, limit)
        np.testing.assert_allclose(images, waves, rtol=0, atol=1e-13)


def test_vectorized_fractions_match_single_contacts() -> None:
    mean, deviation = np.array([0.1, 0.5, 2.0]), np.array([0.2, 3.0, 1.0])
    ceiling = np.array([np.inf, 1.0, 2.5])
    contact, saturated = persson.diffuse_fractions(mean, deviation, ceiling)
    for place in range(3):
        limit = None if np.isinf(ceiling[place]) else float(ceiling[place])
        alone = persson.persson_fractions(
            float(mean[place]), 2 * float(deviation[place]), 1.0, limit
        )
        assert (contact[place], saturated[place]) == pytest.approx(alone, rel=1e-13)
