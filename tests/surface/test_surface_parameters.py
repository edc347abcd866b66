import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from maps import gaussian_map
from roughcontact.surface import grid, spectrum
from roughcontact.surface.surface import Surface, summary

LENGTHS = {
    "Sq",
    "Sa",
    "Sp",
    "Sv",
    "Sz",
    "Sk",
    "Spk",
    "Svk",
    "Sxp",
    "Sdc",
    "Vmp",
    "Vmc",
    "Vvc",
    "Vvv",
}

PURE = {"Ssk", "Sku", "Str", "Str_max", "Smr1", "Smr2"}


def small_map(seed: int, holes: bool) -> np.ndarray:
    rng = np.random.default_rng(seed)
    heights = gaussian_map((24, 17), (1.5, 0.8), seed) + rng.gamma(2.0, 0.1, size=(24, 17))
    if holes:
        heights[rng.random(heights.shape) < 0.1] = np.nan
    return heights


def test_parameters_against_surfalize() -> None:
    # surfalize 0.19.2, Surface(1e6 * heights, step_x=0.5, step_y=0.8) in micrometres.
    y, x = np.mgrid[:150, :200]
    waves = np.sin(0.31 * x + 0.11 * y) + 0.7 * np.cos(0.23 * y - 0.17 * x + 1)
    waves += 0.5 * np.sin(0.0741 * x + 0.41 * y + 2) + 0.4 * np.cos(0.53 * x - 0.29 * y)
    values = summary(1e-6 * np.exp(0.4 * waves), (0.8e-6, 0.5e-6))
    peer = {
        "Sa": 0.340126e-6,
        "Ssk": 0.859052,
        "Sku": 3.5032,
        "Sp": 1.70957e-6,
        "Sv": 0.721507e-6,
        "Sdr": 0.0372177,
    }
    assert {name: values[name] for name in peer} == pytest.approx(peer, rel=5e-6)
    # It rounds ratios to one of 10 000 classes, and interpolates the correlation by cubics.
    rounded = {
        "Sk": 0.977025e-6,
        "Smr1": 0.170165,
        "Smr2": 0.957878,
        "Spk": 0.626788e-6,
        "Svk": 0.101828e-6,
        "Vmp": 0.0282769e-6,
        "Vmc": 0.368418e-6,
        "Vvc": 0.601092e-6,
        "Vvv": 0.0246033e-6,
    }
    assert {name: values[name] for name in rounded} == pytest.approx(rounded, rel=3e-3)
    lengths = {"Sal": 2.53153e-6, "Str": 0.454821}
    assert {name: values[name] for name in lengths} == pytest.approx(lengths, rel=1e-2)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.booleans(), st.floats(1e-9, 1e3), st.floats(1e-9, 1e3))
def test_parameters_scale(seed: int, holes: bool, height: float, side: float) -> None:
    heights = small_map(seed, holes)
    before = summary(heights, (2.0, 3.0))
    after = summary(height * heights, (2.0 * side, 3.0 * side))
    for name in LENGTHS:
        assert after[name] == pytest.approx(height * before[name], rel=1e-9, abs=1e-12 * height)
    for name in PURE:
        assert after[name] == pytest.approx(before[name], rel=1e-9, abs=1e-12, nan_ok=True)
    assert after["Sal"] == pytest.approx(side * before["Sal"], rel=1e-9, nan_ok=True)
    assert after["Sdq"] == pytest.approx(height / side * before["Sdq"], rel=1e-9)
    same = summary(height * heights, (2.0 * height, 3.0 * height))
    assert same["Sdr"] == pytest.approx(before["Sdr"], rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.booleans())
def test_parameters_are_invariant_under_transpose_and_mirror(seed: int, holes: bool) -> None:
    heights = small_map(seed, holes)
    before = summary(heights, (2.0, 3.0))
    turned = summary(np.ascontiguousarray(heights.T), (3.0, 2.0))
    # The lay turns with the map.
    del before["Std"], turned["Std"]
    assert turned == pytest.approx(before, rel=1e-9, abs=1e-12, nan_ok=True)
    # The differences of Sdq look back, hence see a mirror in the first and last points.
    del before["Sdq"]
    for mirrored in (heights[::-1], heights[:, ::-1], heights[::-1, ::-1]):
        values = summary(mirrored, (2.0, 3.0))
        del values["Sdq"], values["Std"]
        assert values == pytest.approx(before, rel=1e-9, abs=1e-12, nan_ok=True)


def test_summary_of_a_flat_map() -> None:
    values = summary(np.full((5, 6), 0.1), (1.0, 1.0))
    unknown = {name for name, value in values.items() if math.isnan(value)}
    assert unknown == {"Ssk", "Sku", "Sal", "Str", "Str_max", "Std"}
    assert {values[name] for name in LENGTHS - {"Sq"}} | {values["Sdq"], values["Sdr"]} <= {0.0}
    assert values["Sq"] == pytest.approx(0, abs=1e-16)


def test_summary_does_not_depend_on_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = small_map(11, holes=True)
    whole = summary(heights, (1.0, 2.0))
    shells = spectrum.radial_spectrum(small_map(11, holes=False), (1.0, 2.0))
    monkeypatch.setattr(grid, "VALUES", 17 * 5)
    assert summary(heights, (1.0, 2.0)) == pytest.approx(whole, rel=1e-12, abs=1e-14)
    blocked = spectrum.radial_spectrum(small_map(11, holes=False), (1.0, 2.0))
    for one, other in zip(shells, blocked, strict=True):
        assert one == pytest.approx(other, rel=1e-12)


def test_surface_returns_roughness() -> None:
    surface = Surface(1e-6 * small_map(12, holes=True), pixel=(1e-6, 2e-6))
    values = surface.roughness()
    assert set(values) == LENGTHS | PURE | {"Sal", "Sdq", "Sdr", "Std", "m"}
    assert values["Sq"] == surface.Sq
    assert values["Sdq"] == surface.Sdq
