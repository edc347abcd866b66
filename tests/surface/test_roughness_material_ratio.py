import numpy as np
import pytest
from scipy import integrate, stats

from maps import gaussian_map
from roughcontact.errors import InputError
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface


def test_material_ratio_curve_of_a_sample() -> None:
    heights = np.array([[2.0, np.nan, 5.0], [2.0, 3.0, 3.0]])
    ratio, height = roughness.material_ratio_curve(heights)
    assert ratio == pytest.approx([0, 0.1, 0.4, 0.8, 1])
    assert height == pytest.approx([2, 2, 0, -1, -1])


def test_grouping_keeps_the_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = np.random.default_rng(8).gamma(3.0, size=(150, 200))
    whole = {
        **roughness.core_parameters(*roughness.material_ratio_curve(heights)),
        **roughness.volume_parameters(*roughness.material_ratio_curve(heights)),
    }
    monkeypatch.setattr(roughness, "_CURVE_POINTS", 2**12)
    curve = roughness.material_ratio_curve(heights)
    assert 2**11 < curve[0].size <= 2**12 + 2
    assert np.all(np.diff(curve[1]) <= 0)
    grouped = {**roughness.core_parameters(*curve), **roughness.volume_parameters(*curve)}
    assert grouped == pytest.approx(whole, rel=2e-3)


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


def test_height_differences_of_uniform_and_gaussian_heights() -> None:
    n = 40_000
    uniform = (np.arange(n) + 0.5) / n
    rng = np.random.default_rng(4)
    for heights, at in ((uniform, stats.uniform.isf), (stats.norm.isf(uniform), stats.norm.isf)):
        curve = roughness.material_ratio_curve(rng.permutation(heights).reshape(200, 200))
        values = roughness.height_differences(*curve)
        expected = {"Sxp": at(0.025) - at(0.5), "Sdc": at(0.1) - at(0.8)}
        assert values == pytest.approx(expected, rel=1e-4)


def test_mean_slope_of_planes_and_gaussian_maps() -> None:
    y, x = np.mgrid[:6, :7]
    # A slope of 3 along x and -4 along y, for any pixel.
    assert roughness.mean_slope(3.0 * x - 8.0 * y, (2.0, 1.0)) == pytest.approx(np.sqrt(12.5))
    heights = gaussian_map((512, 512), (3.0, 3.0))
    slope = roughness.rms_gradient(heights, (1.0, 1.0)) / np.sqrt(np.pi)
    assert roughness.mean_slope(heights, (1.0, 1.0)) == pytest.approx(slope, rel=0.01)
    heights[3, 4] = np.nan
    assert roughness.mean_slope(heights, (1.0, 1.0)) == pytest.approx(slope, rel=0.01)


def test_material_ratio_and_height_are_inverse() -> None:
    surface = Surface(1e-6 * gaussian_map((64, 64), (2.0, 2.0)), (1e-6, 1e-6))
    for ratio in (0.02, 0.3, 0.9):
        assert surface.material_ratio(surface.height_at_ratio(ratio)) == pytest.approx(ratio)
    share = float(np.mean(surface.heights - surface.heights.mean() > 1e-7))
    assert surface.material_ratio("0.1 um") == pytest.approx(share, abs=2e-4)
    assert surface.material_ratio(1.0) == 0.0
    with pytest.raises(InputError, match="ratio must be between 0 and 1"):
        surface.height_at_ratio(1.5)
