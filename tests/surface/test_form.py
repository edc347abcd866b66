import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from maps import rough
from roughcontact.errors import InputError
from roughcontact.surface.form import _Fit, level, remove_form


def cap(shape, pixel, radius, centre, holes=0.0, noise=0.0, seed=0):
    """Heights of a sphere, positive radius for a summit, with its centre at (y, x) [m]."""
    rng = np.random.default_rng(seed)
    y, x = (np.arange(n) * edge for n, edge in zip(shape, pixel, strict=True))
    square = (y[:, None] - centre[0]) ** 2 + (x - centre[1]) ** 2
    heights = np.sign(radius) * np.sqrt(radius**2 - square) + noise * rng.normal(size=shape)
    heights[rng.random(shape) < holes] = np.nan
    return heights


@given(st.floats(0.62, 1000), st.sampled_from([-1, 1]), st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_a_sphere_is_recovered_with_holes(radius: float, sign: int, y: float, x: float) -> None:
    # In units of a map of 0.8 × 0.5: from a cap that nearly reaches the equator to a flat one.
    shape, pixel = (41, 31), (0.02, 0.016)
    centre = (0.4 + 0.5 * y, 0.24 + 0.5 * x)
    heights = cap(shape, pixel, sign * radius, centre, holes=0.2)
    residual, found = remove_form(heights, pixel, "sphere")
    # Rounding of the heights over the sag, 0.1/R.
    assert found["radius"] == pytest.approx(sign * radius, rel=1e-11 * (1 + radius**2))
    rounding = 1e-11 * (1 + radius**3)
    assert (found["centre_y"], found["centre_x"]) == pytest.approx(centre, abs=rounding)
    assert abs(found["centre_z"]) < rounding
    np.testing.assert_array_equal(np.isnan(residual), np.isnan(heights))
    assert np.nanmax(np.abs(residual)) < 1e-13 * (1 + radius)


@pytest.mark.parametrize("radius", [0.01, -0.01])
def test_the_radius_of_a_rough_ball_within_a_thousandth(radius: float) -> None:
    # Radius 10 mm, side 1 mm: sag 12 µm at the sides, roughness 0.1 µm, 20 % holes.
    shape, pixel = (256, 200), (4e-6, 5e-6)
    heights = cap(shape, pixel, radius, (5.5e-4, 4.4e-4), holes=0.2, noise=1e-7, seed=3)
    residual, found = remove_form(heights, pixel, "sphere")
    assert found["radius"] == pytest.approx(radius, rel=1e-3)
    assert np.nanstd(residual) == pytest.approx(1e-7, rel=0.02)
    assert abs(np.nanmean(residual)) < 1e-15
    # A paraboloid would leave its fourth-order error.
    steep = cap(shape, pixel, radius / 10, (5.1e-4, 5.1e-4), holes=0.2)
    assert np.nanmax(np.abs(remove_form(steep, pixel, "sphere")[0])) < 1e-16
    assert np.nanmax(np.abs(level(steep, "quadric"))) > 1e-6


@given(st.floats(-1.5, 1.57), st.floats(0.7, 100), st.sampled_from([-1, 1]), st.floats(-0.3, 0.3))
def test_cylinder_is_recovered_for_any_axis(
    angle: float, radius: float, sign: int, slope: float
) -> None:
    shape, pixel = (37, 43), (0.02, 0.016)
    y, x = (np.arange(n) * edge for n, edge in zip(shape, pixel, strict=True))
    y, x = y[:, None] - 0.3, x - 0.37
    along = x * np.cos(angle) + y * np.sin(angle)
    across = y * np.cos(angle) - x * np.sin(angle) + 0.02
    heights = slope * along + sign * np.sqrt(1 + slope**2) * np.sqrt(radius**2 - across**2)
    heights[np.random.default_rng(1).random(shape) < 0.2] = np.nan
    residual, found = remove_form(heights, pixel, "cylinder")
    tolerance = 1e-11 * (1 + radius**2)
    assert found["radius"] == pytest.approx(sign * radius, rel=tolerance)
    assert -90 < found["angle"] <= 90
    # The axis runs from x towards y, which points down: clockwise as drawn.
    turn = (np.radians(found["angle"]) + angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(turn) < tolerance * (1 + radius)
    assert found["slope"] == pytest.approx(slope, abs=tolerance * (1 + radius))
    assert np.nanmax(np.abs(residual)) < 1e-12 * (1 + radius)


@settings(max_examples=40)
@given(st.integers(0, 8), st.integers(0, 1000))
def test_a_polynomial_of_its_degree_is_removed(degree: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.linspace(-1, 1, 29), np.linspace(-1, 1, 34), indexing="ij")
    form = sum(
        rng.normal() * y**power * x ** (total - power)
        for total in range(degree + 1)
        for power in range(total + 1)
    )
    heights = rough(seed, form.shape, holes=0.3)
    pixel = (1e-6, 2e-6)
    bare, _ = remove_form(heights, pixel, "polynomial", degree)
    residual, found = remove_form(heights + form, pixel, "polynomial", degree)
    np.testing.assert_allclose(residual, bare, atol=1e-11)
    assert found["degree"] == degree
    # One degree more than fitted is left in.
    higher = heights + 1e4 * x ** (degree + 1)
    left = remove_form(higher, pixel, "polynomial", degree)[0]
    assert np.nanstd(left) > 5 * np.nanstd(bare)


def test_undetermined_form_raises_input_error() -> None:
    pixel = (1.0, 1.0)
    y, x = np.mgrid[:20, :30] / 20
    flat = 1 + 0.1 * x + 0.2 * y
    noisy = flat + 0.01 * rough(2, y.shape)
    for shape in ("sphere", "cylinder"):
        for heights in (flat, noisy, np.zeros((20, 30))):
            with pytest.raises(InputError, match=f"too flat to fit a {shape}"):
                remove_form(heights, pixel, shape)
        line = np.full((9, 9), np.nan)
        np.fill_diagonal(line, np.arange(9) ** 2)
        with pytest.raises(InputError, match="9 valid points"):
            remove_form(line, pixel, shape)
        with pytest.raises(InputError, match="4 valid points"):
            remove_form(np.ones((2, 2)), pixel, shape)
        with pytest.raises(InputError, match="only with it"):
            remove_form(noisy, pixel, shape, 2)
    with pytest.raises(InputError, match="axis of a cylinder"):
        remove_form(-((x - 0.7) ** 2) - (y - 0.5) ** 2, pixel, "cylinder")
    with pytest.raises(InputError, match="too flat to fit a sphere"):
        remove_form((x - 0.7) ** 2 - (y - 0.5) ** 2, pixel, "sphere")
    with pytest.raises(InputError, match="only with it"):
        remove_form(noisy, pixel, "polynomial")
    for degree in (-1, 21, 2.5):
        with pytest.raises(InputError, match="from 0 to 20"):
            remove_form(noisy, pixel, "polynomial", degree)
    with pytest.raises(InputError, match="polynomial of degree 4"):
        remove_form(np.zeros((4, 40)), pixel, "polynomial", 4)
    with pytest.raises(InputError, match="sphere, got 'cone'"):
        remove_form(noisy, pixel, "cone")


@pytest.mark.parametrize("axis", [0, 25, 45, 70])
def test_error_of_undetermined_cylinder_is_invariant_under_rotation(axis: int) -> None:
    # Too faint a cylinder to be distinguished from the noise of the map.
    y, x = np.mgrid[:30, :30] - 14.5
    across = x * math.cos(math.radians(axis)) + y * math.sin(math.radians(axis))
    heights = 1e-4 * across**2 + 0.1 * rough(5, y.shape)
    messages = []
    for turn in range(4):
        with pytest.raises(InputError, match="too flat to fit a cylinder") as refused:
            remove_form(np.rot90(heights, turn), (1.0, 1.0), "cylinder")
        messages.append(str(refused.value))
    assert messages == [messages[0]] * 4


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_curvature_uncertainty_includes_rounding_of_largest(scale: float) -> None:
    # A saddle without any noise: its mean curvature is rounding.
    y, x = np.mgrid[:31, :31] / 30 - 0.5
    values, covariance = _Fit(scale * (y**2 - x**2), (1.0, 1.0), "sphere").quadric()
    least = 1e-12 * np.abs(values[3:]).max()
    assert (np.diag(covariance) >= 0.99 * least**2).all()
