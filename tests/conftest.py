"""Independent judges: half-space and certificate in plain NumPy and SciPy, without the package."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.fft


def _corner(x, y):
    # x ln(y + r) + y ln(x + r) less x ln|x| + y ln|y|, which the four corners cancel. It loses
    # about N² × 1e-16 of K at N pixels from the origin, 1e-10 on the largest grids here.
    with np.errstate(divide="ignore", invalid="ignore"):
        value = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
    return np.where((x == 0) | (y == 0), 0.0, value)


def love_coefficients(y, x, pixel, modulus):
    """Love's K [m/Pa] at offsets y, x [m], by the textbook's corner sum."""
    b, a = pixel[0] / 2, pixel[1] / 2
    corners = (
        _corner(x + a, y + b)
        + _corner(x - a, y - b)
        - _corner(x + a, y - b)
        - _corner(x - a, y + b)
    )
    return corners / (math.pi * modulus)


def free_displacement(pressure, pixel, modulus):
    """Displacement and K₀₀ of a free half-space: padded to twice the map, plain FFT."""
    ny, nx = pressure.shape
    y = (scipy.fft.fftfreq(2 * ny) * 2 * ny * pixel[0])[:, None]
    x = scipy.fft.fftfreq(2 * nx) * 2 * nx * pixel[1]
    kernel = scipy.fft.rfft2(love_coefficients(y, x, pixel, modulus))
    spectrum = scipy.fft.rfft2(pressure, s=(2 * ny, 2 * nx)) * kernel
    displacement = scipy.fft.irfft2(spectrum, s=(2 * ny, 2 * nx))[:ny, :nx]
    return displacement, float(love_coefficients(np.zeros(1), np.zeros(1), pixel, modulus)[0])


def periodic_displacement(pressure, pixel, modulus):
    """Displacement and K₀₀ of a periodic half-space: the full complex transform."""
    ny, nx = pressure.shape
    q = (
        2
        * math.pi
        * np.hypot(scipy.fft.fftfreq(ny, pixel[0])[:, None], scipy.fft.fftfreq(nx, pixel[1]))
    )
    symbol = np.zeros(q.shape)
    np.divide(2 / modulus, q, out=symbol, where=q > 0)
    displacement = scipy.fft.ifft2(scipy.fft.fft2(pressure) * symbol).real
    return displacement, float(symbol.mean())


def judge_fields(pressure, h0, limit, approach, pixel, modulus, boundary):
    """Certificate ε and the worst breach of each condition, from the bare fields.

    ``h0`` is infinite where the bodies never touch. Breaches are in units of ε: a single pixel
    may violate a condition by no more than the whole norm.
    """
    displace = free_displacement if boundary == "free" else periodic_displacement
    displacement, unit = displace(pressure, pixel, modulus)
    gap = displacement + h0 - approach
    limit = np.broadcast_to(math.inf if limit is None else limit, pressure.shape)
    norm = float(np.linalg.norm(pressure))
    step = pressure - np.clip(pressure - gap / unit, 0, limit)
    # At the ceiling within rounding; what a result calls saturated is tested in assert_solved.
    empty, full = pressure == 0, pressure >= limit * (1 - 1e-12)
    between = ~empty & ~full
    return SimpleNamespace(
        certificate=float(np.linalg.norm(step)) / norm,
        load=float(math.fsum(pressure.ravel())) * pixel[0] * pixel[1],
        displacement=displacement,
        gap=gap,
        unit=unit,
        full=full,
        bounded=bool((pressure >= 0).all() and (pressure <= limit).all()),
        overlap=float(np.max(-gap[empty], initial=0)) / unit / norm,
        hollow=float(np.max(gap[full], initial=0)) / unit / norm,
        misfit=float(np.max(np.abs(gap[between]), initial=0)) / unit / norm,
    )


def judge(result):
    """Judge a `ContactResult` from its inputs, pressure and approach alone."""
    heights = result.surface.heights
    if result.counter_surface is not None:
        heights = heights + result.counter_surface.heights
    h0 = np.nanmax(heights) - heights
    for axis, (points, edge, slope) in enumerate(
        zip(h0.shape, result.surface.pixel, result.tilt, strict=True)
    ):
        plane = slope * (np.arange(points) - (points - 1) / 2) * edge
        h0 = h0 + (plane[:, None] if axis == 0 else plane)
    compliance = sum(
        (1 - body.poisson**2) / body.young for body in (result.material, result.counter_material)
    )
    return judge_fields(
        result.pressure,
        np.where(np.isnan(h0), np.inf, h0),
        result.ceiling,
        result.approach,
        result.surface.pixel,
        1 / compliance,
        result.boundary,
    )


def assert_solved(result, load=None, tolerance=1e-6):
    """Every returned result: what it says of itself holds, by the independent judge."""
    found = judge(result)
    assert result.status == "converged"
    assert found.bounded
    # The judge's kernel and transforms round differently, by far less than 1e-9 of ‖p‖ here.
    slack = 1e-9 if result.precision == "double" else tolerance
    assert found.certificate <= tolerance + slack
    assert result.certificate == pytest.approx(found.certificate, rel=1e-2, abs=slack)
    assert result.certificate <= tolerance
    assert max(found.overlap, found.hollow, found.misfit) <= tolerance + slack
    if load is not None:
        assert result.load == load
        assert abs(found.load - load) <= 1e-10 * load
        assert result.load_error <= 1e-10
    # A pixel one rounding below the ceiling that sinks in is saturated, and must be counted.
    np.testing.assert_array_equal(result.saturated, found.full)
    touchable = np.isfinite(found.gap)
    assert (np.isnan(result.gap) == ~touchable).all()
    assert (result.pressure[~touchable] == 0).all()
    # Displacements cancel to less than K₀₀ p on a periodic map.
    scale = np.abs(found.gap[touchable]).max() + np.abs(found.displacement).max()
    scale += found.unit * result.pressure.max()
    rounding = 1e-9 if result.precision == "double" else 1e-5
    np.testing.assert_allclose(
        result.gap[touchable], found.gap[touchable], rtol=0, atol=rounding * scale
    )
    return found


@pytest.fixture(scope="session")
def independent():
    """The judges above, for tests that import nothing from here."""
    return SimpleNamespace(
        love_coefficients=love_coefficients,
        free_displacement=free_displacement,
        periodic_displacement=periodic_displacement,
        judge_fields=judge_fields,
        judge=judge,
        assert_solved=assert_solved,
    )
