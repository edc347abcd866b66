import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import quad

from roughcontact.errors import InputError
from roughcontact.halfspace import convolution, kernels

MODULUS = 3.0
EPS = np.finfo(float).eps

# Corner sum of Love's formula with 60 digits (mpmath 1.4.1), dy = 3, dx = 0.75, E* = 2;
# keys are (row, column) in pixels.
LOVE = {
    (0, 0): 0.73638884800807406462,
    (0, 1): 0.35617052286175760803,
    (1, 0): 0.13059298572769567896,
    (1, 1): 0.12481266970931038881,
    (0, 7): 0.067421389135361460034,
    (5, 0): 0.023950763284446945951,
    (3, 19): 0.021244789566545503524,
    (40, 2): 0.002984072584533680244,
    (0, 1000): 0.00047746455075495536695,
    (1000, 0): 0.00011936621695525728568,
    (777, 1234): 0.00014278202159499127023,
}

edges = st.floats(1e-9, 1e3)
moduli = st.floats(1e3, 1e13)


def test_love_against_many_digits():
    rows = 1 + max(row for row, _ in LOVE)
    columns = 1 + max(column for _, column in LOVE)
    found = kernels.love((rows, columns), (3.0, 0.75), 2.0)
    for (row, column), expected in LOVE.items():
        # The docstring promises about N × 1e-16 at N pixels; 8 covers the constant.
        distance = math.hypot(4 * row, column)
        assert found[row, column] == pytest.approx(expected, rel=8 * EPS * (1 + distance))


def test_love_is_the_displacement_of_a_uniform_patch():
    # Integral of 1/(πE* r) over the patch, inner integral in closed form: no code shared.
    dy, dx, modulus = 2e-6, 0.7e-6, 80e9
    found = kernels.love((3, 4), (dy, dx), modulus)
    for row, column in [(0, 1), (1, 0), (2, 3), (1, 1)]:
        y0, x0 = row * dy, column * dx

        def strip(x, y0=y0):
            # ∫ dy / hypot(x, y) over the pixel.
            x = abs(x) or 1e-300
            return math.asinh((y0 + dy / 2) / x) - math.asinh((y0 - dy / 2) / x)

        total, _ = quad(strip, x0 - dx / 2, x0 + dx / 2, points=[0.0] if column == 0 else None)
        # 1e-8: quad's default goal.
        assert found[row, column] == pytest.approx(total / (math.pi * modulus), rel=1e-8)


@given(dy=edges, dx=st.floats(0.1, 10).map(float), modulus=moduli)
def test_self_displacement_in_closed_form(dy, dx, modulus):
    dx = dx * dy
    # Four equal triangles at each side: Johnson (1985), eq. (3.26) at the centre.
    expected = 2 * (dx * math.asinh(dy / dx) + dy * math.asinh(dx / dy)) / (math.pi * modulus)
    found = kernels.love((1, 1), (dy, dx), modulus)[0, 0]
    assert found == pytest.approx(expected, rel=10 * EPS)


def test_self_displacement_of_a_square():
    # 4 ln(1 + √2) / (π E*): the number in every textbook.
    found = kernels.love((1, 1), (1.0, 1.0), 1.0)[0, 0]
    assert found == pytest.approx(4 * math.log(1 + math.sqrt(2)) / math.pi, rel=4 * EPS)


@pytest.mark.parametrize(("dy", "dx"), [(2.0, 1.0), (1.0, 2.0), (0.3, 1.7)])
@pytest.mark.parametrize("direction", [(1, 0), (0, 1), (3, 2), (1, 4)])
def test_far_field_of_an_anisotropic_pixel(dy, dx, direction):
    modulus = 3.0
    steps = np.array([40, 80, 160, 320])
    rows, columns = direction[0] * steps, direction[1] * steps
    found = kernels.love((rows[-1] + 1, columns[-1] + 1), (dy, dx), modulus)[rows, columns]
    y, x = rows * dy, columns * dx
    r = np.hypot(y, x)
    point = dx * dy / (math.pi * modulus * r)
    # Second moments dx²/12 and dy²/12 of the pixel times half the second derivatives of 1/r.
    second = (dx**2 * (2 * x**2 - y**2) + dy**2 * (2 * y**2 - x**2)) / (24 * r**4)
    # Left over: the fourth moments, at most about (d/r)⁴ of K; rounding 1e-16 per pixel.
    size = max(dy, dx)
    bound = 0.2 * (size / r) ** 4 + 1e-15 * steps * max(direction)
    assert (np.abs(found / point - 1 - second) <= bound).all()
    # The next order is there: where it does not vanish, leaving it out is seen.
    seen = np.abs(second) > 4 * bound
    assert (np.abs(found / point - 1)[seen] > 0.5 * np.abs(second)[seen]).all()


@given(dy=edges, ratio=st.floats(0.05, 20), modulus=moduli)
def test_transposed_pixels_give_the_transposed_kernel(dy, ratio, modulus):
    dx = ratio * dy
    there = kernels.love((7, 5), (dy, dx), modulus)
    back = kernels.love((5, 7), (dx, dy), modulus)
    # 200 ε: both sides round the same sums in another order, up to 140 short edges away.
    np.testing.assert_allclose(there, back.T, rtol=200 * EPS)
    np.testing.assert_array_equal(
        kernels.periodic((7, 5), (dy, dx), modulus), kernels.periodic((5, 7), (dx, dy), modulus).T
    )


@given(dy=edges, ratio=st.floats(0.05, 20), modulus=moduli)
def test_love_falls_with_the_distance_and_scales(dy, ratio, modulus):
    dx = ratio * dy
    found = kernels.love((9, 6), (dy, dx), modulus)
    assert (found > 0).all()
    assert (np.diff(found, axis=0) < 0).all()
    assert (np.diff(found, axis=1) < 0).all()
    # Lengths times 7, modulus times 3: displacement per pressure times 7/3.
    scaled = kernels.love((9, 6), (7 * dy, 7 * dx), 3 * modulus)
    np.testing.assert_allclose(scaled, 7 / 3 * found, rtol=200 * EPS)


def test_twice_as_long_in_y_is_not_twice_as_long_in_x():
    # A swapped dy and dx passes symmetry, far field on squares, reciprocity.
    found = kernels.love((4, 4), (2.0, 1.0), 1.0)
    assert found[1, 0] < 0.6 * found[0, 1]
    # Two units away along either axis: the long pixel reaches nearer along its own.
    assert 1.05 < found[1, 0] / found[0, 2] < 1.2


def test_row_blocks_leave_no_seam(monkeypatch):
    whole = kernels.love((37, 11), (0.4, 1.0), 1.0)
    monkeypatch.setattr(kernels, "_BLOCK_BYTES", 8 * 12 * 5)
    np.testing.assert_array_equal(kernels.love((37, 11), (0.4, 1.0), 1.0), whole)


def test_displacement_converges_with_the_square_of_the_pixel():
    # Gaussian pressure exp(-r²/2s²): u(0) = √(2π) s / E* × p₀ (Hankel transform; p̂ 2/(E*q)).
    s, modulus = 1.0, 5.0
    exact = math.sqrt(2 * math.pi) * s / modulus
    sizes, errors = np.array([120, 180, 270, 405]), []
    for n in sizes:
        dy, dx = 16 * s / n, 14 * s / n  # dy ≠ dx; pressure at the edges below 3e-11 p₀
        half_y, half_x = n // 2, n // 2
        p_y = np.exp(-((np.arange(-half_y, half_y + 1) * dy) ** 2) / 2 / s**2)[:, None]
        p_x = np.exp(-((np.arange(-half_x, half_x + 1) * dx) ** 2) / 2 / s**2)
        quadrant = kernels.love((half_y + 1, half_x + 1), (dy, dx), modulus)
        right = np.hstack([quadrant[:, :0:-1], quadrant])
        full = np.vstack([right[:0:-1], right])
        errors.append(abs(float((full * p_y * p_x).sum()) - exact))
    order = np.polyfit(np.log(1 / sizes), np.log(errors), 1)[0]
    # A term of third order, from the pixel under the point, still takes 0.05 on these grids.
    assert order == pytest.approx(2, abs=0.08)
    assert errors[-1] < 1e-4 * exact


@pytest.mark.parametrize("shape", [(8, 8), (9, 14), (16, 5), (7, 7)])
def test_periodic_symbol_against_a_cosine_pressure(shape):
    # Johnson (1985), eq. (13.1): p cos(q·r) displaces by 2/(E*|q|) of itself.
    (ny, nx), (dy, dx), modulus = shape, (0.3, 2.0), 7.0
    symbol = kernels.periodic(shape, (dy, dx), modulus)
    assert symbol.shape == (ny // 2 + 1, nx // 2 + 1)
    for i, j in [(1, 0), (0, 1), (2, 1), (ny // 2, nx // 2)]:
        q = math.hypot(2 * math.pi * i / (ny * dy), 2 * math.pi * j / (nx * dx))
        assert symbol[i, j] == pytest.approx(2 / (modulus * q), rel=4 * EPS)
        y = np.arange(ny)[:, None] * dy
        x = np.arange(nx) * dx
        wave = np.cos(2 * math.pi * i * y / (ny * dy) + 2 * math.pi * j * x / (nx * dx) + 0.4)
        operator = convolution.periodic(shape, (dy, dx), modulus, workers=1)
        # 1e-13: rounding of the transforms.
        np.testing.assert_allclose(
            operator(wave), 2 / (modulus * q) * wave, rtol=0, atol=1e-13 * symbol[1, 0]
        )
    assert symbol[0, 0] == 0


def test_periodic_is_not_free():
    pressure = np.zeros((16, 16))
    pressure[3, 5] = 1
    free = convolution.free((16, 16), (1.0, 1.0), 1.0, workers=1)(pressure)
    periodic = convolution.periodic((16, 16), (1.0, 1.0), 1.0, workers=1)(pressure)
    # Across the seam the periodic neighbour is near, the free one far.
    assert periodic[3, 5 - 8] == pytest.approx(periodic[3, 5 + 8], rel=1e-12)
    assert free[3, 15] != pytest.approx(free[3, 11], rel=0.1)
    assert abs(periodic.mean()) < 1e-15
    assert free.min() > 0


@pytest.mark.parametrize(
    ("shape", "pixel"), [((40, 16), (0.4, 1.0)), ((300, 9), (1.0, 0.03)), ((12, 301), (0.01, 1.0))]
)
def test_strip_against_a_quadrature(independent, shape, pixel):
    found = kernels.strip(shape, pixel, MODULUS, 7.0)
    q = 2 * math.pi * np.arange(shape[1] // 2 + 1) / (shape[1] * pixel[1])
    expected = independent.strip_coefficients(shape[0], pixel[0], q, MODULUS, 7.0)
    # Some roundings of the peak of each wave, those of the quadrature included.
    assert (np.abs(found - expected) <= 1e-14 * np.abs(expected).max(axis=0)).all()


def test_strip_in_parts_is_the_strip_at_once():
    whole = kernels.strip((33, 40), (0.4, 1.0), MODULUS, 7.0)
    parts = [
        kernels.strip((33, 40), (0.4, 1.0), MODULUS, 7.0, waves)
        for waves in (slice(0, 3), slice(3, 4), slice(4, None))
    ]
    np.testing.assert_allclose(np.hstack(parts), whole, rtol=0, atol=1e-15 * whole.max())


def test_strip_row_blocks_leave_no_seam(monkeypatch):
    whole = kernels.strip((60, 40), (0.05, 1.0), MODULUS, 7.0)
    monkeypatch.setattr(kernels, "_BLOCK_BYTES", 1)
    rows = kernels.strip((60, 40), (0.05, 1.0), MODULUS, 7.0)
    np.testing.assert_allclose(rows, whole, rtol=0, atol=1e-15 * whole.max())


def test_a_wave_on_a_wide_strip_is_that_of_the_half_plane():
    # Sum over all rows: the wave with the same pressure everywhere, 2/(E* q).
    dy, nx, dx = 0.05, 12, 0.5
    table = kernels.strip((4000, nx), (dy, dx), MODULUS, 1.0)
    q = 2 * math.pi * np.arange(1, nx // 2 + 1) / (nx * dx)
    np.testing.assert_allclose(
        2 * table[1:, 1:].sum(axis=0) + table[0, 1:], 2 / (MODULUS * q), rtol=1e-13
    )


def test_the_datum_of_a_strip_is_where_a_line_displaces_nothing():
    # The mean of ln|y| over a pixel of edge h at y lies h²/24y² below the logarithm there.
    table = kernels.strip((101, 2), (0.1, 1.0), MODULUS, 10.0)[:, 0]
    assert (table[:100] > 0).all()
    expected = 2 * 0.1 / (math.pi * MODULUS) / (24 * 100**2)
    assert table[100] == pytest.approx(expected, rel=1e-4)
    # Another datum is another constant.
    other = kernels.strip((101, 2), (0.1, 1.0), MODULUS, 5.0)[:, 0]
    np.testing.assert_allclose(table - other, 0.2 / (math.pi * MODULUS) * math.log(2), rtol=1e-13)


def strip_of_datum_1(shape, pixel, contact_modulus):
    return kernels.strip(shape, pixel, contact_modulus, 1.0)


@pytest.mark.parametrize("datum", [0.0, -1.0, math.inf, math.nan])
def test_a_datum_that_cannot_be(datum):
    with pytest.raises(ValueError, match="datum"):
        kernels.strip((4, 4), (1.0, 1.0), 1.0, datum)


@pytest.mark.parametrize("kernel", [kernels.love, kernels.periodic, strip_of_datum_1])
@pytest.mark.parametrize(
    ("pixel", "modulus", "words"),
    [
        ((0.0, 1.0), 1.0, "pixel.*0.0"),
        ((1.0, -2.5), 1.0, "pixel.*-2.5"),
        ((math.nan, 1.0), 1.0, "pixel.*nan"),
        ((1.0, math.inf), 1.0, "pixel.*inf"),
        ((1.0, 1.0), 0.0, "contact_modulus.*0.0"),
        ((1.0, 1.0), -3e9, "contact_modulus.*-3"),
        ((1.0, 1.0), math.nan, "contact_modulus.*nan"),
        ((1.0, 1.0), math.inf, "contact_modulus.*inf"),
    ],
)
def test_invalid_pixel_or_modulus_raises_input_error(kernel, pixel, modulus, words):
    with pytest.raises(InputError, match=words):
        kernel((4, 4), pixel, modulus)
