import math

import numpy as np
import pytest

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


def test_love_against_many_digits():
    rows = 1 + max(row for row, _ in LOVE)
    columns = 1 + max(column for _, column in LOVE)
    found = kernels.love((rows, columns), (3.0, 0.75), 2.0)
    for (row, column), expected in LOVE.items():
        # The docstring promises about N × 1e-16 at N pixels; 8 covers the constant.
        distance = math.hypot(4 * row, column)
        assert found[row, column] == pytest.approx(expected, rel=8 * EPS * (1 + distance))


@pytest.mark.parametrize("dx", [0.3, 1.0, 4.0])
def test_self_displacement_in_closed_form(dx):
    # Four equal triangles at each side: Johnson (1985), eq. (3.26) at the center.
    expected = 2 * (dx * math.asinh(1 / dx) + math.asinh(dx)) / (math.pi * 7.0)
    found = kernels.love((1, 1), (1.0, dx), 7.0)
    assert found == pytest.approx(expected, rel=10 * EPS)


def test_row_blocks_leave_no_seam(monkeypatch):
    whole = kernels.love((37, 11), (0.4, 1.0), 1.0)
    monkeypatch.setattr(kernels, "_BLOCK_BYTES", 8 * 12 * 5)
    np.testing.assert_array_equal(kernels.love((37, 11), (0.4, 1.0), 1.0), whole)


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
        operator = convolution.periodic(shape, (dy, dx), modulus)
        # 1e-13: rounding of the transforms.
        np.testing.assert_allclose(
            operator(wave), 2 / (modulus * q) * wave, rtol=0, atol=1e-13 * symbol[1, 0]
        )
    assert symbol[0, 0] == 0


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
