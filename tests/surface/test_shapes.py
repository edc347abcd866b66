import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from roughcontact.errors import InputError
from roughcontact.surface import random_surfaces, shapes

BODY = {"rms_height": 2e-7, "rolloff_wavelength": 2.5e-5, "cutoff_wavelength": 8e-6}


def make(shape, side, seed=0, **changes):
    pixel = (side[0] / shape[0], side[1] / shape[1])
    rng = np.random.default_rng(seed)
    return random_surfaces.self_affine(shape, pixel, **{**BODY, **changes}, rng=rng)


def test_paraboloid_has_its_curvature_and_centre():
    radius, pixel = 1e-3, (2e-6, 3e-6)
    z = shapes.paraboloid((5, 8), pixel, radius)
    assert (z <= 0).all()
    np.testing.assert_array_equal(z, z[::-1, ::-1])
    np.testing.assert_allclose(np.diff(z, 2, axis=0), -(pixel[0] ** 2) / radius)
    np.testing.assert_allclose(np.diff(z, 2, axis=1), -(pixel[1] ** 2) / radius)
    assert z[2].max() == pytest.approx(-(1.5e-6**2) / (2 * radius))
    moved = shapes.paraboloid((5, 8), pixel, radius, center=(1, 6))
    assert np.unravel_index(moved.argmax(), moved.shape) == (1, 6)
    assert moved[1, 6] == 0


def test_waves_run_along_their_axes():
    z = shapes.wavy((3, 8), (1.0, 0.5), 2.0, 4.0)
    np.testing.assert_array_equal(z, np.broadcast_to(z[0], z.shape))
    np.testing.assert_allclose(z[0, [0, 2, 4, 6]], [2, 0, -2, 0], atol=1e-15)
    both = shapes.crossed_waves((4, 8), (1.0, 0.5), 2.0, 4.0)
    np.testing.assert_allclose(both[:, 0], [2, 0, -2, 0], atol=1e-15)
    np.testing.assert_allclose(both[[0, 2]], [z[0], -z[0]], atol=1e-15)


def test_invalid_grid_raises_input_error():
    with pytest.raises(InputError, match=r"^shape"):
        shapes.paraboloid((0, 4), (1.0, 1.0), 1.0)
    with pytest.raises(InputError, match=r"^pixel"):
        shapes.wavy((4, 4), (1.0, -1.0), 1.0, 1.0)
    with pytest.raises(InputError, match=r"^radius"):
        shapes.paraboloid((4, 4), (1.0, 1.0), -1.0)
    for n in (0, 16):
        with pytest.raises(InputError):
            random_surfaces.reference_map(n)


GRID = (31, 44), (2e-6, 3e-6)


def from_center(center=None):
    (ny, nx), (dy, dx) = GRID
    cy, cx = center or ((ny - 1) / 2, (nx - 1) / 2)
    return np.broadcast_arrays((np.arange(ny)[:, None] - cy) * dy, (np.arange(nx) - cx) * dx)


@given(st.floats(5e-6, 1e3), st.tuples(st.floats(-3, 33), st.floats(-3, 46)))
def test_every_point_of_a_sphere_is_at_its_radius(radius, center):
    y, x = from_center(center)
    r = np.hypot(y, x)
    if r.min() > radius:
        with pytest.raises(InputError, match="no point of the grid is under the sphere"):
            shapes.sphere(*GRID, radius, center=center)
        return
    z = shapes.sphere(*GRID, radius, center=center)
    on = np.isfinite(z)
    # The square root of rounding decides at the rim.
    np.testing.assert_array_equal(
        on[np.abs(r / radius - 1) > 1e-7], (r < radius)[np.abs(r / radius - 1) > 1e-7]
    )
    distance = np.sqrt(r**2 + (z + radius) ** 2)
    np.testing.assert_allclose(distance[on], radius, rtol=1e-12)
    assert (z[on] <= 0).all()
    # Large balls are met without cancellation: r²/2R (1 + r²/4R²).
    if radius > 1:
        np.testing.assert_allclose(z, -(r**2) / (2 * radius), rtol=1e-8)


@given(st.floats(1e-4, 1e2), st.floats(-720, 720))
def test_a_cylinder_is_straight_along_its_axis_and_round_across(radius, angle):
    z = shapes.cylinder(*GRID, radius, angle)
    y, x = from_center()
    t = -math.radians(angle)
    across = y * math.cos(t) - x * math.sin(t)
    # 720° in radians is off by 1e-15, the map is 132 µm long.
    np.testing.assert_allclose(across**2 + (z + radius) ** 2, radius**2, rtol=1e-12)
    # Between the paraboloid and twice it; without cancellation where they meet.
    paraboloid = -(across**2) / (2 * radius)
    assert (z <= paraboloid + 1e-18).all()
    assert (z >= 2 * paraboloid - 1e-18).all()
    if radius > 1:
        np.testing.assert_allclose(z, paraboloid, rtol=1e-8, atol=1e-18)


def test_a_narrow_cylinder_ends_at_its_radius():
    z = shapes.cylinder(*GRID, 10e-6, 0, center=(15, 0))
    assert np.isfinite(z[10:21]).all()
    assert np.isnan(np.delete(z, np.s_[10:21], axis=0)).all()
    assert (z[15] == 0).all()


@given(
    st.tuples(st.floats(1e-4, 1.0), st.floats(1e-4, 1.0)), st.floats(-400, 400), st.floats(0, 90)
)
def test_the_ellipsoid_has_its_radii_in_its_directions(radii, angle, more):
    z = shapes.ellipsoid(*GRID, radii, angle)
    y, x = from_center()
    # The quadratic form by its tensor: rotated principal curvatures.
    t = -math.radians(angle)
    turn = np.array([[math.cos(t), math.sin(t)], [-math.sin(t), math.cos(t)]])  # (y, x) body → map
    tensor = turn @ np.diag([1 / radii[0], 1 / radii[1]]) @ turn.T
    expected = -0.5 * (tensor[0, 0] * y**2 + 2 * tensor[0, 1] * y * x + tensor[1, 1] * x**2)
    np.testing.assert_allclose(z, expected, rtol=0, atol=1e-12 * abs(z).max())
    swapped = shapes.ellipsoid(*GRID, radii[::-1], angle + 90)
    np.testing.assert_allclose(swapped, z, rtol=0, atol=1e-12 * abs(z).max())


def test_a_punch_is_flat_and_ends():
    y, x = from_center()
    z = shapes.punch(*GRID, 20e-6)
    np.testing.assert_array_equal(z, np.where(np.hypot(y, x) < 20e-6, 0, np.nan))
    # Row 5 is at -20 µm: on the outline.
    assert shapes.punch(*GRID, 20e-6, center=(15, 21))[5, 21] == 0
    z = shapes.rectangular_punch(*GRID, (24e-6, 60e-6))
    inside = (np.abs(y) < 12.1e-6) & (np.abs(x) < 30.1e-6)
    np.testing.assert_array_equal(z, np.where(inside, 0, np.nan))


def test_a_rounded_punch_ends_in_a_quarter_circle():
    z = shapes.punch(*GRID, 25e-6, 10e-6, center=(15, 10))
    r = np.hypot(*from_center((15, 10)))
    assert (z[r <= 15e-6] == 0).all()
    edge = (r > 15e-6) & (r < 25e-6)
    np.testing.assert_allclose((r[edge] - 15e-6) ** 2 + (z[edge] + 10e-6) ** 2, 1e-10, rtol=1e-12)
    assert np.isnan(z[r > 25.001e-6]).all()
    whole = shapes.punch(*GRID, 25e-6, 25e-6)
    np.testing.assert_allclose(whole, shapes.sphere(*GRID, 25e-6), rtol=1e-9, atol=1e-20)


def test_the_corner_of_a_rounded_rectangle_is_part_of_a_ball():
    z = shapes.rectangular_punch(*GRID, (40e-6, 60e-6), 10e-6)
    y, x = np.abs(from_center())
    corner = np.hypot(y - 10e-6, x - 20e-6)
    at = (y > 10e-6) & (x > 20e-6)
    np.testing.assert_array_equal(np.isnan(z[at]), corner[at] > 10e-6)
    on = at & (corner < 10e-6)
    assert on.sum() > 10
    np.testing.assert_allclose(corner[on] ** 2 + (z[on] + 10e-6) ** 2, 1e-10, rtol=1e-12)
    side = (y <= 10e-6) & (x > 20e-6) & (x < 30e-6)
    np.testing.assert_allclose((x[side] - 20e-6) ** 2 + (z[side] + 10e-6) ** 2, 1e-10, rtol=1e-12)


def test_cone_and_wedge_have_their_slope():
    y, x = from_center((3, 5))
    np.testing.assert_allclose(shapes.cone(*GRID, 0.02, center=(3, 5)), -0.02 * np.hypot(y, x))
    np.testing.assert_array_equal(shapes.wedge(*GRID, 0.02, 0, center=(3, 5)), -0.02 * np.abs(y))
    np.testing.assert_array_equal(shapes.wedge(*GRID, 0.02, 90, center=(3, 5)), -0.02 * np.abs(x))
    dy, dx = np.gradient(shapes.wedge(*GRID, 0.02, 30, center=(-9, 5)), *GRID[1])
    # Well off the ridge, which rises to the right as drawn: y falls along it.
    np.testing.assert_allclose(np.hypot(dy, dx)[25:], 0.02, rtol=1e-9)
    np.testing.assert_allclose(dx[25:] / dy[25:], math.tan(math.radians(30)), rtol=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: shapes.sphere(*GRID, 0.0), "^radius must be finite and not zero"),
        (lambda: shapes.cylinder(*GRID, np.inf), "^radius must be finite and not zero"),
        (lambda: shapes.cylinder(*GRID, 1.0, np.nan), "^angle must be a finite number"),
        (
            lambda: shapes.cylinder(*GRID, 1e-6, 0, center=(40, 0)),
            "^no point .* under the cylinder",
        ),
        (lambda: shapes.ellipsoid(*GRID, (1.0, 0.0)), r"^radii\[1\] must be finite and not"),
        (lambda: shapes.ellipsoid(*GRID, 1.0), "^radii must be a pair"),
        (lambda: shapes.punch(*GRID, 1e-9), "^no point of the grid is under the punch"),
        (lambda: shapes.punch(*GRID, 1e-5, 2e-5), "^edge_radius must be between 0 and 1e-05"),
        (lambda: shapes.punch(*GRID, 1e-5, -1e-6), "^edge_radius"),
        (lambda: shapes.rectangular_punch(*GRID, (1e-5, 0)), r"^sides\[1\] must be positive"),
        (lambda: shapes.rectangular_punch(*GRID, (1e-5, 3e-5), 6e-6), "between 0 and 5e-06"),
        (lambda: shapes.cone(*GRID, -0.1), "^slope must be positive"),
        (lambda: shapes.wedge(*GRID, np.nan), "^slope must be positive"),
        (lambda: shapes.flat((3, 0), (1.0, 1.0)), "^shape must be"),
        (lambda: shapes.cone((3, 3), (1.0, 0.0), 0.1), "^pixel must be"),
        (lambda: shapes.cone(*GRID, 0.1, center=3), "^center must be a pair"),
        (lambda: shapes.cone(*GRID, 0.1, center=(3, np.nan)), "^center must be finite"),
    ],
)
def test_invalid_bodies_raise_input_error(make, message):
    with pytest.raises(InputError, match=message):
        make()
