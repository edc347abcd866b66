"""Independent judges: half-space and certificate in plain NumPy and SciPy, without the package."""

import math
from types import SimpleNamespace

import numpy as np
import scipy.fft
import scipy.special


def _corner(x, y):
    # x ln(y + r) + y ln(x + r) less x ln|x| + y ln|y|, which the four corners cancel.
    with np.errstate(divide="ignore", invalid="ignore"):
        value = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
    return np.where((x == 0) | (y == 0), 0.0, value)


# Distance in long edges of a pixel from which four points along each edge integrate 1/r to 1e-14.
_FAR_EDGES = 16


def love_coefficients(y, x, pixel, modulus):
    """Love's K [m/Pa] at offsets y, x [m]: the textbook's corner sum, far away by quadrature."""
    # The sum loses about r²/dydx roundings of K at a distance r: 64-bit mantissas, where the
    # machine has them, keep 1e-12 as far as it is used, with pixels of up to 1:1000.
    y, x = np.broadcast_arrays(np.asarray(y, np.longdouble), np.asarray(x, np.longdouble))
    b, a = pixel[0] / 2, pixel[1] / 2
    integral = np.empty(y.shape)
    near = np.hypot(y, x) < _FAR_EDGES * max(pixel)
    v, u = y[near], x[near]
    integral[near] = (
        _corner(u + a, v + b)
        + _corner(u - a, v - b)
        - _corner(u + a, v - b)
        - _corner(u - a, v + b)
    )
    v, u = y[~near].astype(np.float64), x[~near].astype(np.float64)
    node, weight = np.polynomial.legendre.leggauss(4)
    far = np.zeros(v.shape)
    for y_node, y_weight in zip(node * b, weight * b, strict=True):
        for x_node, x_weight in zip(node * a, weight * a, strict=True):
            far += y_weight * x_weight / np.hypot(v + y_node, u + x_node)
    integral[~near] = far
    return integral / (math.pi * modulus)


def free_displacement(pressure, pixel, modulus):
    """Displacement and K₀₀ of a free half-space: padded to twice the map, plain FFT."""
    ny, nx = pressure.shape
    y, x = np.arange(ny + 1)[:, None] * pixel[0], np.arange(nx + 1) * pixel[1]
    quadrant = love_coefficients(y, x, pixel, modulus)
    rows, columns = (np.minimum(i, i[::-1] + 1) for i in (np.arange(2 * ny), np.arange(2 * nx)))
    kernel = scipy.fft.rfft2(quadrant[np.ix_(rows, columns)])
    spectrum = scipy.fft.rfft2(pressure, s=(2 * ny, 2 * nx)) * kernel
    displacement = scipy.fft.irfft2(spectrum, s=(2 * ny, 2 * nx))[:ny, :nx]
    return displacement, float(quadrant[0, 0])


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


# K₀ beyond it is below the smallest of its roundings near the row, and below 1e-28 of itself.
_DEAD, _REACH = 700, 64


def strip_coefficients(offsets, edge, q, modulus, datum):
    """Displacement by cos(qx) on a row of pixels, at offsets across: quadrature of K₀, or ln."""
    node, weight = np.polynomial.legendre.leggauss(64)
    node, weight = (node + 1) / 2, weight / 2
    table = np.zeros((offsets, q.size))
    for column, wave in enumerate(q):
        if wave == 0:
            # ∫ ln(y/datum): 64-bit mantissas, as the differences cancel.
            end = np.abs(np.arange(offsets + 1, dtype=np.longdouble) - 0.5) * edge
            area = end * (np.log(end / datum) - 1)
            table[:, column] = -np.append(2 * area[0], np.diff(area[1:]))[:offsets]
            continue
        # Near the row itself v⁵ takes the singularity of the logarithm away; over many wavelengths
        # only the first of them count.
        half = min(0.5 * edge, _REACH / wave)
        s = half * node**5
        table[0, column] = 2 * (scipy.special.k0(wave * s) * 5 * half * node**4 * weight).sum()
        width = min(edge, _REACH / wave)
        panels = math.ceil(wave * width)
        s = (np.arange(panels)[:, None] + node).ravel() * (width / panels)
        rows = np.arange(1, min(offsets, math.ceil(_DEAD / (wave * edge)) + 1))
        far = (rows - 0.5)[:, None] * edge + s
        table[rows, column] = scipy.special.k0(wave * far) @ np.tile(weight, panels)
        table[rows, column] *= width / panels
    return table * 2 / (math.pi * modulus)


def strip_displacement(pressure, pixel, modulus, axis, datum=None):
    """Displacement and K₀₀ of a half-space periodic along one axis: padded across, plain FFT."""
    if datum is None:
        datum = max(points * edge for points, edge in zip(pressure.shape, pixel, strict=True))
    if axis == 0:
        found, unit = strip_displacement(pressure.T, pixel[::-1], modulus, 1, datum)
        return found.T, unit
    ny, nx = pressure.shape
    q = 2 * math.pi * scipy.fft.rfftfreq(nx, pixel[1])
    table = strip_coefficients(ny + 1, pixel[0], q, modulus, datum)
    rows = np.arange(2 * ny)
    symbol = scipy.fft.fft(table[np.minimum(rows, rows[::-1] + 1)], axis=0)
    waves = scipy.fft.fft(scipy.fft.rfft(pressure, axis=1), 2 * ny, axis=0)
    moved = scipy.fft.ifft(symbol * waves, axis=0)[:ny]
    return scipy.fft.irfft(moved, nx, axis=1), float(scipy.fft.irfft(table[0], nx)[0])


def _displacement(boundary, pressure, pixel, modulus):
    if boundary == "free":
        return free_displacement(pressure, pixel, modulus)
    if boundary == "periodic":
        return periodic_displacement(pressure, pixel, modulus)
    return strip_displacement(pressure, pixel, modulus, "yx".index(boundary[-1]))


def _norm(values):
    largest = np.abs(values).max(initial=0)
    return float(np.linalg.norm(values / largest)) * largest if largest else 0.0


def judge_fields(
    pressure, h0, limit, approach, pixel, modulus, boundary, digits=np.float64, summed=None
):
    """Certificate ε and the worst breach of a condition, from the bare fields.

    ``h0`` is infinite where the bodies never touch. ``breach`` is in units of ε: a single pixel
    may violate a condition by no more than the whole norm. ``doubt`` is what ε could become if
    displacement and initial gap were known to the last of their digits only; ``summed`` is what
    the initial gap is a sum of, each without its sign. ``scale`` is what the gap is rounded to
    some digits of.
    """
    displacement, unit = _displacement(boundary, pressure, pixel, modulus)
    gap = displacement + h0 - approach
    limit = np.broadcast_to(math.inf if limit is None else limit, pressure.shape)
    norm = _norm(pressure)
    step = pressure - np.clip(pressure - gap / unit, 0, limit)
    # At the ceiling within rounding; what a result calls saturated is tested in assert_solved.
    empty, full = pressure == 0, pressure >= limit * (1 - 1e-12)
    # The last pixel to fill takes up what the sum of all others is rounded by.
    between = ~empty & (pressure < limit - 1e-12 * pressure.sum())
    touchable = np.isfinite(h0)
    summed = h0 if summed is None else summed
    lost = np.finfo(digits).eps * np.where(touchable, np.abs(displacement) + summed, 0)
    reach = pressure - gap / unit
    doubt = np.clip(reach + lost / unit, 0, limit) - np.clip(reach - lost / unit, 0, limit)
    breach = np.where(empty, -gap, 0) + np.where(full, gap, 0) + np.where(between, np.abs(gap), 0)
    # Sums do not determine where less than their digits belongs; single precision promises 1e-4.
    counted = touchable & (limit > (1e-12 if digits is np.float64 else 1e-4) * norm)
    breach = np.max(breach[counted] - lost[counted], initial=0)
    # Displacements cancel: to less than K₀₀ p, and on a periodic map to less than the longest wave.
    side = max(edge * points for edge, points in zip(pixel, pressure.shape, strict=True))
    scale = np.abs(gap[touchable]).max() + np.abs(displacement).max()
    scale += unit * pressure.max() + side / (math.pi * modulus) * norm / math.sqrt(pressure.size)
    return SimpleNamespace(
        certificate=_norm(step) / norm,
        doubt=_norm(doubt[touchable]) / norm,
        breach=float(breach) / unit / norm,
        scale=float(scale),
        load=float(math.fsum(pressure.ravel())) * pixel[0] * pixel[1],
        displacement=displacement,
        gap=gap,
        unit=unit,
        full=full,
        bounded=bool((pressure >= 0).all() and (pressure <= limit).all()),
    )


def judge(result):
    """Judge a `ContactResult` from its inputs, pressure and approach alone."""
    heights = result.surface.heights
    if result.counter_surface is not None:
        heights = heights + result.counter_surface.heights
    h0 = np.nanmax(heights) - heights
    summed = h0
    for axis, (points, edge, slope) in enumerate(
        zip(h0.shape, result.surface.pixel, result.tilt, strict=True)
    ):
        plane = slope * (np.arange(points) - (points - 1) / 2) * edge
        plane = plane[:, None] if axis == 0 else plane
        h0, summed = h0 + plane, summed + np.abs(plane)
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
        np.float64 if result.precision == "double" else np.float32,
        np.where(np.isnan(h0), np.inf, summed),
    )


def moment_error(result):
    """Distance of the resultant from where the load acts, along y or x, over the longer side."""
    side = max(e * n for e, n in zip(result.surface.pixel, result.pressure.shape, strict=True))
    load = math.fsum(result.pressure.ravel())
    worst = 0.0
    for axis, (edge, moment) in enumerate(zip(result.surface.pixel, result.moments, strict=True)):
        line = result.pressure.sum(axis=1 - axis)
        place = (np.arange(line.size) - (line.size - 1) / 2) * edge
        worst = max(worst, abs(math.fsum(line * place) / load - moment / result.load) / side)
    return worst


def faults(result, load=None, tolerance=1e-6):
    """Return the statements of a result that the independent judge denies."""
    found = judge(result)
    # The judge's transforms round differently, by far less than 1e-9 of ‖p‖ here.
    slack = 1e-9 if result.precision == "double" else tolerance
    said, seen = result.certificate, found.certificate
    touchable = np.isfinite(found.gap)
    rounding = 1e-9 if result.precision == "double" else 1e-5
    off = float(np.abs(result.gap[touchable] - found.gap[touchable]).max(initial=0))
    statements = [
        (result.status == "converged", f"status {result.status}"),
        (found.bounded, "a pressure below zero or above the ceiling"),
        (seen <= tolerance + slack, f"certificate {seen:.3e} above {tolerance:.0e}"),
        (said <= tolerance, f"certificate said to be {said:.3e}, above {tolerance:.0e}"),
        (
            abs(said - seen) <= max(1e-2 * seen, slack, found.doubt),
            f"certificate said to be {said:.3e}, found {seen:.3e}",
        ),
        (found.breach <= tolerance + slack, f"a pixel breaks its condition by {found.breach:.3e}"),
        # A pixel one rounding below the ceiling that sinks in is saturated, and must be counted.
        (np.array_equal(result.saturated, found.full), "pixels at the ceiling miscounted"),
        (np.array_equal(np.isnan(result.gap), ~touchable), "gap is not NaN where there is none"),
        ((result.pressure[~touchable] == 0).all(), "pressure where nothing can touch"),
        (off <= rounding * found.scale, f"gap off by {off:.3e} m of {found.scale:.3e} m"),
    ]
    if load is not None:
        error = abs(found.load - load) / load
        statements += [
            (result.load == load, f"load {result.load!r} instead of {load!r}"),
            (error <= 1e-10, f"load error {error:.3e}"),
            (result.load_error <= 1e-10, f"load error said to be {result.load_error:.3e}"),
        ]
    if result.moments is None:
        statements.append((result.tilt == (0, 0), f"tilted by {result.tilt} without moments"))
    else:
        off = moment_error(result)
        statements += [
            (off <= 1e-8 + 1e-12, f"moment error {off:.3e}"),
            (abs(result.moment_error - off) <= 1e-12, f"said to be {result.moment_error:.3e}"),
        ]
    return [fault for holds, fault in statements if not holds]


def assert_solved(result, load=None, tolerance=1e-6):
    """Assert that what a returned result says of itself holds; return the judgement."""
    assert faults(result, load, tolerance) == []
    return judge(result)
