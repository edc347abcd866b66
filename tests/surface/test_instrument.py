"""The virtual instrument against closed forms."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
import virtual_microscope
from roughcontact.errors import InputError
from roughcontact.surface import instrument
from roughcontact.surface.instrument import Instrument, dilate

UM = 1e-6


def sine(points: int, waves: int) -> rc.Surface:
    x = (np.arange(points) + 0.5) / points
    return rc.Surface(np.tile(np.sin(2 * math.pi * waves * x), (points, 1)) * UM, (UM, UM))


@pytest.mark.parametrize("step", [1, 2, 4])
def test_a_sine_is_sampled_at_pixel_centers_with_half_its_amplitude(step: int) -> None:
    surface, waves, n = sine(64, 4), 4, 64 // step
    tool = Instrument(resolution=64 * UM / waves)
    rng = np.random.default_rng(0)
    image = tool.measure(surface, points=(n, n), periodic=True, rng=rng)
    x = (np.arange(n) + 0.5) / n
    expected = 0.5 * np.sinc(waves / n) * UM * np.sin(2 * math.pi * waves * x)
    assert image.pixel == (step * UM, step * UM)
    np.testing.assert_allclose(image.heights[3], expected, rtol=0, atol=1e-12 * UM)


def test_a_map_that_ends_is_mirrored() -> None:
    # A step from one edge to the other would blur into both.
    ramp = rc.Surface(np.outer(np.ones(32), np.linspace(0, UM, 32)), (UM, UM))
    image = Instrument(resolution=4 * UM).measure(ramp, rng=np.random.default_rng(0))
    assert np.abs(image.heights - ramp.heights).max() < 0.05 * UM


def test_transfer_of_a_pupil_is_the_autocorrelation_of_a_disc() -> None:
    y, x = np.mgrid[-256:256, -256:256]
    disc = (np.hypot(y, x) < 100).astype(float)
    overlap = np.fft.irfft2(np.abs(np.fft.rfft2(disc)) ** 2, disc.shape)[0, :200] / disc.sum()
    np.testing.assert_allclose(
        instrument.round_pupil(np.arange(200) / 200), overlap, rtol=0, atol=2e-3
    )
    tool = Instrument("optical", numerical_aperture=0.4, wavelength="633 nm", shape=0.0)
    assert tool.resolution == pytest.approx(1.2377 * 633e-9 / 0.4, rel=1e-4)
    waves = np.array([0.25, 0.5, 1.0]) * 2 * 0.4 / 633e-9
    np.testing.assert_allclose(tool.lateral_transfer(waves), [*overlap[[50, 100]], 0], atol=2e-3)


def test_shapes_of_one_resolution_differ_for_longer_waves() -> None:
    waves = np.array([0.25, 0.5, 1.0]) / UM
    pupil, middle, gaussian = (
        Instrument(resolution=UM, shape=shape).lateral_transfer(waves) for shape in (0, 0.5, 1)
    )
    np.testing.assert_allclose(pupil, [0.8716, 0.7446, 0.5], atol=1e-4)
    np.testing.assert_allclose(gaussian, 2.0 ** -np.array([1 / 16, 1 / 4, 1]), rtol=1e-12)
    np.testing.assert_allclose(middle, np.sqrt(pupil * gaussian), rtol=1e-12)
    given = Instrument("gaussian", resolution=UM)
    np.testing.assert_array_equal(given.lateral_transfer(waves), gaussian)
    assert given.u_shape == 0 < Instrument(resolution=UM).u_shape
    coherent = Instrument("coherent", numerical_aperture=0.55)
    assert coherent.lateral_transfer(np.array([0.99, 1.01]) / UM).tolist() == [1, 0]


def test_measured_transfer_is_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "itf.csv"
    path.write_text("# 1/mm, transfer\n0, 1\n100, 0.9\n200, 0.6\n300, 0.2\n", "utf-8")
    tool = Instrument.from_name(f"measured {path}")
    assert tool.resolution == pytest.approx(1 / 225e3)
    np.testing.assert_allclose(
        tool.lateral_transfer(np.array([0, 50e3, 200e3, 300e3, 301e3])), [1, 0.95, 0.6, 0.2, 0]
    )
    assert Instrument(**vars(tool)) == tool
    path.write_text("1 2 3\n4 5 6\n", "utf-8")
    with pytest.raises(InputError, match="has 3 columns"):
        Instrument.from_name(f"measured {path}")
    with pytest.raises(InputError, match="increasing"):
        Instrument.from_transfer([2, 1], [1, 0.5])
    with pytest.raises(InputError, match="is not a transfer function"):
        Instrument.from_name(f"measured {tmp_path / 'none.csv'}")


def test_noise_and_missing_points() -> None:
    flat = rc.Surface(np.zeros((128, 128)), (UM, UM))
    missing = np.zeros((128, 128), bool)
    missing[3, 5] = True
    tool = Instrument(resolution=4 * UM, noise="2 nm")
    image = tool.measure(flat, missing=missing, rng=np.random.default_rng(1))
    assert np.isnan(image.heights[3, 5])
    assert image.missing == 1
    # The standard deviation of a standard deviation of n points is 1/√(2n).
    assert image.Sq == pytest.approx(2e-9, rel=4 / math.sqrt(2 * 128**2))


def test_a_sphere_under_a_tip_has_the_sum_of_both_radii() -> None:
    y, x = np.mgrid[-32:32, -32:32] * UM
    top = dilate(-(x**2 + y**2) / (2 * 1e-3), (UM, UM), 2e-3)
    inside = np.hypot(y, x) < 20 * UM
    # It touches between points: at points alone it was up to 0.25 pixels² / 2e-3 m too low.
    assert np.abs(top + (x**2 + y**2) / (2 * 3e-3))[inside].max() < 1e-6 * UM


def test_a_small_tip_touches_between_points() -> None:
    # At points alone the image lost a quarter of what this tip adds to the heights.
    known = virtual_microscope.draw_measurement(9, "tip")
    fine, radius = known.heights, 0.25 / float(np.std(virtual_microscope.curvature(known.heights)))
    expected = (dilate(fine, (1, 1), radius) - fine)[::2, ::2]
    added = dilate(fine[::2, ::2], (2, 2), radius) - fine[::2, ::2]
    assert np.sqrt(np.mean((added - expected) ** 2)) < 0.05 * np.sqrt(np.mean(expected**2))


def test_noise_from_two_maps_and_from_a_plateau() -> None:
    surface = rc.generate(128, UM, Sq="0.3 um", Sal="10 um", rng=2)
    tool = Instrument(resolution=0.0, noise="5 nm")
    missing = np.eye(128) > 0
    maps = [tool.measure(surface, missing=missing, periodic=True, rng=k) for k in range(2)]
    repeated = Instrument.from_repeats(*maps, resolution=2 * UM)
    assert repeated.noise == pytest.approx(5e-9, rel=0.03)
    assert repeated.resolution == 2 * UM
    estimated = Instrument.from_map(maps[0].filled())
    assert estimated.noise == pytest.approx(5e-9, rel=0.15)
    # The generated surface has no waves below eight pixels.
    assert Instrument.from_map(surface).noise == 0
    with pytest.raises(InputError, match=r"must have \(128, 128\) points"):
        Instrument.from_repeats(maps[0], maps[1].cropped((0, 64), (0, 64)), resolution=UM)


def test_every_row_of_the_catalog_has_a_source() -> None:
    rows = tomllib.loads(instrument.STORED.read_text("utf-8"))["instrument"]
    for row in rows:
        assert row["source"]
        tool = rc.measure.Instrument.from_name(row["name"].upper(), noise="1 nm")
        assert tool.name == row["name"]
        assert tool.noise == 1e-9
    # 1.24 λ/NA at 550 nm.
    assert Instrument.from_name("CSI 50x").resolution == pytest.approx(
        1.24 * 550e-9 / 0.55, rel=0.04
    )
    assert Instrument.from_name("tip 50 nm").tip_radius == pytest.approx(50e-9)
    assert Instrument.from_name("optical 1.5 um").resolution == pytest.approx(1.5e-6)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"kind": "optical"}, "resolution is needed"),
        ({"kind": "tip"}, "tip_radius is needed"),
        ({"kind": "eye", "resolution": 0}, "kind must be"),
        ({"resolution": -1.0}, "must not be negative"),
    ],
)
def test_invalid_instruments_raise_input_error(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Instrument(**arguments)


def test_invalid_measurements_raise_input_error() -> None:
    rng, tool = np.random.default_rng(0), Instrument(resolution=UM)
    with pytest.raises(InputError, match="must divide"):
        tool.measure(sine(64, 4), points=(63, 64), rng=rng)
    hole = sine(64, 4).heights.copy()
    hole[0, 0] = np.nan
    with pytest.raises(InputError, match="fill them first"):
        tool.measure(rc.Surface(hole, (UM, UM)), rng=rng)
    with pytest.raises(InputError, match="not in the catalog"):
        Instrument.from_name("CSI 51x")
