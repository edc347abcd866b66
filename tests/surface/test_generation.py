"""Generated surfaces have the requested parameters, and report where they have not."""

from __future__ import annotations

import json
import math
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.generate.report import missed_notes
from roughcontact.cautions import CautionTag, Severity
from roughcontact.cli import app
from roughcontact.report import python_script
from roughcontact.surface import (
    generation,
    generation as marks,
    provenance,
    random_surfaces,
    spectrum,
)
from roughcontact.surface.random_surfaces import Spectrum
from roughcontact.theory import height_distribution

Capture = pytest.CaptureFixture[str]

PIXEL = (1e-6, 1e-6)
SHAPE = (128, 160)


def make_map(shape: tuple[int, int] = SHAPE, **asked: Any) -> rc.Surface:
    return rc.generate(shape, PIXEL, **{"Sq": "0.5 um", "Sal": "5 um", **asked})


def missed_parameters(surface: rc.Surface) -> dict[str, float]:
    return {one.name: one.missed for one in generation.compare_parameters(surface) if not one.met}


@pytest.mark.parametrize(
    "asked",
    [
        {},
        {"Ssk": -1.2, "Sku": 5.0},
        {"Ssk": 2.0, "Sku": 8.0},
        {"Str": 0.4, "lay": 30.0, "Ssk": -0.6},
        {"Sal": "6 um", "Sdq": 0.2, "hurst": 0.5},
        {"Sal": None, "Sdq": 0.15},
        {"Sal": None, "rolloff_wavelength": "24 um", "cutoff_wavelength": "3 um", "Sku": 6.0},
        {"Ssk": -0.6, "Sku": 4.0, "honing": 50.0, "Str": 0.5},
    ],
    ids=str,
)
def test_generated_map_has_requested_parameters(asked: dict[str, Any]) -> None:
    surface = make_map(**asked)
    assert missed_parameters(surface) == {}
    named = {one.name: one for one in generation.compare_parameters(surface)}
    values = surface.roughness()
    for name, one in named.items():
        if name != "hurst":
            assert values[name] == pytest.approx(one.measured, rel=1e-12)
    assert values["Sq"] == pytest.approx(0.5e-6, rel=1e-9)


def test_map_with_requested_parameters_is_not_corrected() -> None:
    spectrum_asked = Spectrum(SHAPE, PIXEL, 12e-6, 3e-6, 0.8, 0.5)
    heights = make_map(Str=0.5).heights
    Sal, Str, _ = spectrum.texture(heights, PIXEL)
    asked = generation._Request(
        0.5e-6, Sal, None, 0.8, None, 3e-6, Str, 0.0, 0.0, 3.0, None, None, 0
    )
    near = 1 + generation._CLOSE / 2
    for close in (asked, replace(asked, Str=Str * near), replace(asked, Sal=Sal / near)):
        assert generation._correct_spectrum(spectrum_asked, close, heights) is spectrum_asked
    for share in (0.8, 1.25):
        other = generation._correct_spectrum(
            spectrum_asked, replace(asked, Str=Str * share), heights
        )
        assert (other.ratio > 0.5) == (share > 1)
        assert other.rolloff == spectrum_asked.rolloff


def test_the_same_seed_gives_the_same_bits_and_another_another_map() -> None:
    first, again, other = make_map(), make_map(), make_map(rng=1)
    assert first.heights.tobytes() == again.heights.tobytes()
    assert abs(np.corrcoef(first.heights.ravel(), other.heights.ravel())[0, 1]) < 0.2


def test_a_generator_draws_the_seed_that_is_recorded() -> None:
    surface = make_map(rng=np.random.default_rng(5))
    assert surface.provenance.origin is not None
    seed = surface.provenance.origin.arguments["seed"]
    assert np.array_equal(make_map(rng=seed).heights, surface.heights)
    assert (make_map(rng=None).heights != make_map(rng=None).heights).any()


@pytest.mark.long
def test_the_spectrum_is_flat_then_falls_then_ends() -> None:
    surface = make_map((256, 256), Sal=None, rolloff_wavelength=32e-6, hurst=0.6, Ssk=-1.0)
    q, power, _ = spectrum.radial_spectrum(surface.heights, PIXEL)
    waves_per_metre = q / (2 * np.pi)
    flat = waves_per_metre < 0.9 / 32e-6
    sloped = (waves_per_metre > 1.2 / 32e-6) & (waves_per_metre < 0.9 / 8e-6)
    beyond = waves_per_metre > 1.1 / 8e-6
    assert np.ptp(power[flat]) < 0.01 * power[flat].mean()
    slope = np.polyfit(np.log(q[sloped]), np.log(power[sloped]), 1)[0]
    assert slope == pytest.approx(-2 - 2 * 0.6, abs=0.06)
    assert power[beyond].max() < 1e-12 * power[flat].mean()


def longest_direction(heights: np.ndarray) -> float:
    """Return the direction [degrees] in which a map is alike longest, as it is drawn."""
    slope_y, slope_x = np.gradient(heights)
    # The structure tensor's weak axis; rows count downwards.
    tensor = [
        [np.mean(slope_x**2), -np.mean(slope_x * slope_y)],
        [-np.mean(slope_x * slope_y), np.mean(slope_y**2)],
    ]
    _, axes = np.linalg.eigh(tensor)
    return float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])) % 180)


@pytest.mark.parametrize("lay", [0.0, 30.0, 90.0, 135.0])
def test_the_lay_is_counter_clockwise_as_drawn(lay: float) -> None:
    surface = make_map(Str=0.3, lay=lay)
    apart = (longest_direction(surface.heights) - lay + 90) % 180 - 90
    assert abs(apart) < 4
    turned = marks.turned_heights((200, 200), PIXEL, 20e-6, 1e-3, lay)
    assert abs((longest_direction(turned[5:-5, 5:-5]) - lay + 90) % 180 - 90) < 6


@pytest.mark.slow
def test_honing_crosses_at_its_angle() -> None:
    surface = make_map((160, 160), Sal=None, rolloff_wavelength=2e-5, honing=60.0, lay=20.0)
    power = np.abs(np.fft.fft2(surface.heights)) ** 2
    fy, fx = np.meshgrid(np.fft.fftfreq(160), np.fft.fftfreq(160), indexing="ij")
    # A wave across grooves runs at right angles to them.
    grooves = (np.degrees(np.arctan2(-fy, fx)) + 90) % 180
    ring = (np.hypot(fy, fx) > 0.02) & (np.hypot(fy, fx) < 0.12)
    angles = np.arange(0, 180, 5)
    shares = [power[ring & (np.abs((grooves - a + 90) % 180 - 90) < 2.5)].mean() for a in angles]
    assert set(angles[np.argsort(shares)[-2:]]) == {50, 170}


def test_turning_leaves_cusps_and_roughness_between_them() -> None:
    shape, feed, radius = (64, 250), 50e-6, 0.4e-3
    grooves = marks.turned_heights(shape, PIXEL, feed, radius, lay=90.0)
    assert np.ptp(grooves) == pytest.approx(feed**2 / (8 * radius), rel=0.05)
    np.testing.assert_allclose(grooves[:, :50], grooves[:, 50:100], rtol=0, atol=1e-14)
    surface = rc.generate(shape, PIXEL, Sq=0.4e-6, turning=(feed, radius), lay=90.0)
    assert surface.Sq == pytest.approx(0.4e-6, rel=1e-9)
    assert np.corrcoef(surface.heights.ravel(), grooves.ravel())[0, 1] > 0.3
    assert [one.name for one in generation.compare_parameters(surface)] == ["Sq"]


def test_a_lay_turned_half_around_is_the_same() -> None:
    # Along an axis the grooves close on themselves, whichever way the axis is named.
    for lay in (0.0, 90.0):
        one, other = (
            marks.turned_heights((100, 250), PIXEL, 30e-6, 0.4e-3, lay=lay + half)
            for half in (0, 180)
        )
        np.testing.assert_allclose(other, one[::-1, ::-1], rtol=0, atol=1e-14)
    down = marks.turned_heights((100, 250), PIXEL, 30e-6, 0.4e-3, lay=-90.0)
    across = marks.turned_heights((100, 250), PIXEL, 30e-6, 0.4e-3, lay=90.0)
    np.testing.assert_allclose(down, across[:, ::-1], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        ({"Sal": None}, "Sal or Sdq or rolloff_wavelength must be given"),
        ({"rolloff_wavelength": 2e-5}, "Sal and rolloff_wavelength set the same"),
        ({"Sal": 3e-6}, "Sal must be at least 3."),
        ({"Sal": 6e-5}, "Sal must be at most a quarter of the shorter side"),
        ({"Sdq": 3.0}, "Sdq must be in 0.1"),
        ({"Str": 0.0}, r"Str must be in \(0, 1\]"),
        ({"Ssk": 1.0, "Sku": 2.0}, r"Sku must exceed Ssk² \+ 1 = 2"),
        ({"honing": 180.0}, "honing must be an angle"),
        ({"hurst": 1.2}, "hurst must be in"),
        ({"cutoff_wavelength": 1e-6}, "cutoff_wavelength must be at least two pixels"),
        ({"rng": -1}, "rng must be a whole number"),
        ({"Sq": -1.0}, "Sq must be positive"),
        ({"turning": (5e-5, 1e-3)}, "Sal cannot be combined with turning"),
        ({"Sal": None, "turning": (5e-5, 1e-3), "Ssk": 1.0}, "Ssk cannot be combined with turning"),
        ({"Sal": None, "turning": (5e-5, 1e-5)}, "turning has a nose radius"),
        ({"Sal": None, "turning": (2e-6, 1e-3), "cutoff_wavelength": 2e-6}, "turning has a feed"),
        ({"Sal": None, "turning": (8e-5, 1e-4)}, "Sq must be at least 3.434e-06 m, the Sq of the"),
        ({"Sal": None, "turning": 5e-5}, r"turning must be a pair"),
    ],
)
def test_impossible_parameters_raise_input_error(asked: dict[str, Any], expected: str) -> None:
    with pytest.raises(rc.InputError, match=f"^{expected}"):
        make_map((96, 128), **asked)


@pytest.mark.long
def test_unreachable_moments_raise_input_error() -> None:
    with pytest.raises(rc.InputError, match=r"^Ssk -0\.8 with Sku 3.96 is not reachable"):
        rc.generate(48, (2e-6, 2e-6), Sq=4e-7, Sal=1.2e-5, Ssk=-0.8, honing=40)


@pytest.mark.slow
def test_missed_parameters_are_reported_with_reason() -> None:
    grooves = make_map((96, 96), Str=0.05)
    result = missed_notes(grooves)[0]
    assert (result.kind, result.severity) == (CautionTag.GENERATE_MISSED, Severity.NOTE)
    assert "Str is at most 0.1" in result.text
    few = make_map((96, 96), Sal=16e-6, Str=1.0, cutoff_wavelength="16 um")
    result = missed_notes(few)[0]
    assert "correlation areas fit" in result.text


def test_narrow_spectrum_is_reported_with_its_ends() -> None:
    (result,) = missed_notes(make_map((96, 96), cutoff_wavelength="8 um"))
    assert result.kind == CautionTag.NARROW_SPECTRUM
    assert result.numbers["span"] == pytest.approx(1.6, rel=0.2)
    assert (
        missed_notes(
            make_map((96, 96), rolloff_wavelength="16 um", Sal=None, cutoff_wavelength="4 um")
        )
        == ()
    )


@pytest.mark.long
def test_provenance_reproduces_map() -> None:
    surface = make_map(Ssk=-0.5, Str=0.5, lay=20.0, rng=7)
    about = surface.provenance
    assert provenance.from_text(provenance.to_text(about)) == about
    assert about.source == "generated rough surface, seed 7"
    (result,) = about.steps
    assert result.startswith(
        "generated: Sq 500 nm, Sal 5 µm, Str 0.5, Ssk -0.5, Hurst exponent 0.8"
    )
    assert "numpy.random.default_rng(7)" in result
    names: dict[str, Any] = {}
    exec(python_script.script_of_map(surface), names)
    assert names["surface"].heights.tobytes() == surface.heights.tobytes()
    with pytest.raises(rc.InputError, match="not an unchanged generated map"):
        generation.compare_parameters(surface.leveled())


@pytest.mark.parametrize("lay", [0.0, 90.0])
def test_a_wave_as_long_as_the_cutoff_belongs_to_the_map(lay: float) -> None:
    # However its length is rounded.
    for points in (60, 96, 140):
        for wave in range(2, points // 2 - 1, 3):
            for pixel in (1e-6, 0.7e-6, 3.1e-7):
                cutoff = points * pixel / wave
                power = Spectrum(
                    (points, points), (pixel, pixel), 4 * cutoff, cutoff, 0.8, 1.0, lay
                ).power
                assert power[0, wave] > 0
                assert power[wave, 0] > 0
                assert power[0, wave + 1] == 0


@pytest.mark.parametrize("shape", [(8, 12), (7, 12), (8, 11), (7, 11)])
def test_a_wave_of_two_pixels_has_no_power(shape: tuple[int, int]) -> None:
    # It has no phase that a real map could tell. All others down to there have some.
    power = Spectrum(shape, (1e-6, 1e-6), 1e-5, 1e-6, 0.8).power
    none = np.zeros(power.shape, bool)
    none[0, 0] = True
    if shape[0] % 2 == 0:
        none[shape[0] // 2] = True
    if shape[1] % 2 == 0:
        none[:, -1] = True
    np.testing.assert_array_equal(power == 0, none)


def test_a_gradient_is_that_of_the_first_differences() -> None:
    found = Spectrum((64, 80), (1e-6, 2e-6), 30e-6, 6e-6, 0.7, 0.5, 25.0)
    rng = np.random.default_rng(0)
    phases = np.exp(2j * np.pi * rng.random(found.power.shape))
    # One column stands for both signs of a wave, and must agree with itself.
    phases[:, 0] = 1
    heights = np.fft.irfft2(np.sqrt(found.power) * phases, (64, 80))
    slope_y, slope_x = (
        (heights - np.roll(heights, 1, axis)) / edge for axis, edge in enumerate((1e-6, 2e-6))
    )
    expected = math.sqrt(np.mean(slope_y**2 + slope_x**2)) / heights.std()
    assert found.gradient() == pytest.approx(expected, rel=1e-9)
    again = random_surfaces.with_gradient(found, "cutoff", 1e-7 * 0.9 * found.gradient(), 1e-7)
    assert again.gradient() == pytest.approx(0.9 * found.gradient(), rel=5e-3)


@pytest.mark.slow
def test_the_command_prints_both_and_writes_every_format(tmp_path: Path, capsys: Capture) -> None:
    files = [tmp_path / f"made{suffix}" for suffix in (".nc", ".npz", ".csv", ".vti")]
    figure = tmp_path / "made.png"
    words = shlex.split(
        "generate --points 96x128 --size '96 um x 128 um' --sq '0.5 um' --sal '5 um' --ssk -0.5 "
        "--seed 4"
    )
    outputs = [word for path in files for word in ("--output", str(path))]
    assert app.main([*words, *outputs, "--figure", str(figure)]) == app.SOLVED
    shown = capsys.readouterr().out
    assert "requested" in shown
    assert "Sal" in shown
    assert "96 × 128 points" in shown
    assert figure.stat().st_size > 1000
    expected = make_map((96, 128), Ssk=-0.5, rng=4).heights
    for path in files[:3]:
        assert rc.read_surface(path).heights.tobytes() == expected.tobytes()
    assert app.main([*words, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    sal = next(one for one in record["parameters"] if one["name"] == "Sal")
    assert sal["asked"] == 5e-6
    assert sal["met"]
    assert record["seed"] == 4


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], "--sq must be given"),
        (["--sq", "1 um"], "the map gives no lengths of its sides"),
        (["--sq", "1 um", "--size", "1 mm"], "--sal or --sdq or --rolloff must be given"),
        (["--sq", "1 um", "--size", "1 mm", "--sal", "9 um", "--ssk", "2", "--sku", "4"], "--sku"),
        (["--sq", "1 um", "--size", "1 mm", "--sal", "9 um", "--output", "x.stl"], "--output"),
        (["--sq", "1"], "--sq"),
    ],
)
def test_invalid_options_are_rejected_in_one_sentence(
    words: list[str], expected: str, capsys: Capture
) -> None:
    assert app.main(["generate", *words]) == app.BAD_INPUT
    shown = capsys.readouterr()
    assert shown.err.startswith(f"roughcontact: error: {expected}")
    assert shown.err.count("\n") == 1
    assert shown.out == ""


def test_usual_kurtosis_is_that_of_a_gamma_distribution() -> None:
    from scipy import stats

    for skewness in (0.3, 1.0, 2.0):
        shape = 4 / skewness**2
        kurtosis = 3 + float(stats.gamma(shape).stats("k"))
        assert height_distribution.usual_kurtosis(skewness) == pytest.approx(kurtosis)
