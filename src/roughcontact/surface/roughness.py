"""Roughness parameters of a height map, after ISO 25178-2.

The standard's parameters belong to a scale-limited surface, without form and filtered. Nothing is
levelled or filtered here: level the map first. Only its mean is subtracted, which the standard
takes to be zero. Missing points (NaN) are left out of every average. Material ratios and Sdr are
fractions, not per cent.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError, require_pixel
from roughcontact.halfspace import fft

Array = NDArray[np.float64]

# Values per block of rows: temporaries of 8 MiB, whatever the size of the map.
_BLOCK = 2**20

# Points of a material ratio curve; maps with more heights have them averaged in groups.
_CURVE_POINTS = 2**18

# A lag counts where this share of the points has a partner; fewer say little.
_LEAST_OVERLAP = 0.05


def summary(heights: Array, pixel: tuple[float, float]) -> dict[str, float]:
    """Return the parameters of ISO 25178-2, under the standard's symbols and in SI units.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], levelled and, if wanted, filtered before; NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    dict
        ``Sq, Sa, Sp, Sv, Sz`` [m], ``Ssk, Sku`` (`height_parameters`); ``Sdq`` (`rms_gradient`),
        ``Sdr`` (`developed_area_ratio`); ``Sal`` [m], ``Str`` (`autocorrelation_lengths`);
        ``Sk, Spk, Svk`` [m], ``Smr1, Smr2`` (`core_parameters`); ``Vmp, Vmc, Vvc, Vvv``
        [m³/m²] (`volume_parameters`).

        Ssk, Sku, Sal and Str of a flat map are NaN. Sal and Str are NaN too if the
        correlation decays in no direction on this map. Str is 0 if it decays in some directions
        but not in all: the ratio is then smaller than this map can show.

    Raises
    ------
    InputError
        If the pixel is not positive, or if no point, no slope or no cell of four is there.

    References
    ----------
    ISO 25178-2:2021, sections 4.2 to 4.5

    Examples
    --------
    >>> wave = np.cos(2 * np.pi * np.arange(64) / 16) * np.ones((64, 1))
    >>> values = summary(wave, (1.0, 1.0))
    >>> round(values["Sq"], 6), round(values["Sku"], 6), values["Str"]
    (0.707107, 1.5, 0.0)
    """
    require_pixel(pixel)
    fastest, slowest = autocorrelation_lengths(heights, pixel)
    decays = math.isfinite(fastest)
    curve = material_ratio_curve(heights)
    return {
        **height_parameters(heights),
        "Sdq": rms_gradient(heights, pixel),
        "Sdr": developed_area_ratio(heights, pixel),
        "Sal": fastest if decays else math.nan,
        "Str": fastest / slowest if decays else math.nan,
        **core_parameters(*curve),
        **volume_parameters(*curve),
    }


def height_parameters(heights: Array) -> dict[str, float]:
    """Return the height parameters Sq, Sa, Ssk, Sku, Sp, Sv and Sz.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.

    Returns
    -------
    dict
        ``Sq, Sa, Sp, Sv, Sz`` in the unit of the heights; ``Ssk, Sku`` without unit, NaN if
        all heights are equal.

    Raises
    ------
    InputError
        If every point is missing.

    Notes
    -----
    With z the height above the mean and ⟨ ⟩ the average over the points that are there:
    Sq = √⟨z²⟩, ``Sa = ⟨|z|⟩``, Ssk = ⟨z³⟩/Sq³, Sku = ⟨z⁴⟩/Sq⁴ (3 for a Gaussian surface),
    Sp = max z, Sv = -min z, Sz = Sp + Sv.

    References
    ----------
    ISO 25178-2:2021, section 4.2

    Examples
    --------
    >>> height_parameters(np.array([[0.0, 0.0], [0.0, 4.0]]))["Sz"]
    4.0
    """
    Sq = rms_height(heights)
    mean, count = _mean(heights)
    top, bottom = float(np.nanmax(heights)), float(np.nanmin(heights))
    flat = top == bottom
    absolute, third, fourth = 0.0, 0.0, 0.0
    for rows in _blocks(heights.shape):
        z = heights[rows] - mean
        absolute += float(np.nansum(np.abs(z)))
        if not flat:
            z /= Sq
            square = z * z
            third += float(np.nansum(square * z))
            fourth += float(np.nansum(np.square(square, out=square)))
    return {
        "Sq": Sq,
        "Sa": absolute / count,
        "Ssk": math.nan if flat else third / count,
        "Sku": math.nan if flat else fourth / count,
        "Sp": top - mean,
        "Sv": mean - bottom,
        "Sz": top - bottom,
    }


def rms_height(heights: NDArray[np.float64]) -> float:
    """Return the root-mean-square height about the mean, Sq.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing; missing points are left out of the sums.

    Returns
    -------
    float
        Sq, in the unit of the heights.

    Raises
    ------
    InputError
        If every point is missing.

    References
    ----------
    ISO 25178-2:2021, root mean square height; the mean is subtracted here, nothing else.

    Examples
    --------
    >>> rms_height(np.array([[1.0, 3.0], [np.nan, 2.0]])) ** 2  # doctest: +ELLIPSIS
    0.666...
    """
    total, count = 0.0, 0
    for rows in _blocks(heights.shape):
        count += int(np.count_nonzero(~np.isnan(heights[rows])))
        total += float(np.nansum(heights[rows]))
    if count == 0:
        raise InputError("has no finite value: every point is missing", argument="heights")
    mean = total / count
    squares, rest = 0.0, 0.0
    for rows in _blocks(heights.shape):
        deviation = heights[rows] - mean
        rest += float(np.nansum(deviation))
        squares += float(np.nansum(np.square(deviation, out=deviation)))
    # The second term takes out the rounding of the mean of a map far from zero height.
    return float(np.sqrt(max(squares / count - (rest / count) ** 2, 0.0)))


def rms_gradient(heights: NDArray[np.float64], pixel: tuple[float, float]) -> float:
    """Return the root-mean-square gradient, Sdq.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    float
        Sdq, a slope without unit. A point counts where both of its differences are defined.

    Raises
    ------
    InputError
        If no point has both differences.

    Notes
    -----
    The standard defines Sdq² as the mean of ``(∂z/∂x)² + (∂z/∂y)²`` and leaves the differences
    open. Here they are the first differences to the neighbours before,
    ``(z[j, i] - z[j, i-1])/dx`` and ``(z[j, i] - z[j-1, i])/dy``, over the (ny - 1)(nx - 1) points
    that have both: the shortest distance measured counts in full, where central differences
    would pass over it.

    References
    ----------
    ISO 25178-2:2021, root mean square gradient; the differences after Stout et al., The
    development of methods for the characterisation of roughness in three dimensions (1993),
    EUR 15178 EN.

    Examples
    --------
    >>> x = np.arange(4.0)
    >>> rms_gradient(3.0 * x + 4.0 * x[:, None], (1.0, 1.0))
    5.0
    """
    dy, dx = pixel
    total, count = 0.0, 0
    for rows in _blocks((heights.shape[0] - 1, heights.shape[1])):
        here = heights[rows.start + 1 : rows.stop + 1]
        slope_y = (here[:, 1:] - heights[rows, 1:]) / dy
        slope_x = np.diff(here, axis=1) / dx
        squares = slope_x * slope_x + slope_y * slope_y
        count += int(np.count_nonzero(~np.isnan(squares)))
        total += float(np.nansum(squares))
    if count == 0:
        raise InputError(
            "has no point with both neighbours there: no gradient is defined", argument="heights"
        )
    return float(np.sqrt(total / count))


def developed_area_ratio(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the developed interfacial area ratio, Sdr, by triangulation.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    float
        Sdr, area of the surface over its projection, minus 1; a fraction, not per cent.

    Raises
    ------
    InputError
        If no cell has all four corners.

    Notes
    -----
    The standard defines Sdr as the mean of ``√(1 + (∂z/∂x)² + (∂z/∂y)²) - 1``. Here every cell
    between four points is cut into two triangles along either diagonal, and both cuts are
    averaged, so that mirroring the map changes nothing. A triangle with the slopes s_x and s_y
    along its two edges on the grid has ``√(1 + s_x² + s_y²)`` times its projected area, hence a
    cell the mean of that over its two s_x and its two s_y.

    References
    ----------
    ISO 25178-2:2021, section 4.4; the triangles after Stout et al., The development of methods
    for the characterisation of roughness in three dimensions (1993), EUR 15178 EN.

    Examples
    --------
    >>> x = np.arange(4.0)
    >>> round(developed_area_ratio(x + 0 * x[:, None], (1.0, 1.0)) + 1, 6)
    1.414214
    """
    dy, dx = pixel
    total, count = 0.0, 0
    for rows in _blocks((heights.shape[0] - 1, heights.shape[1])):
        part = heights[rows.start : rows.stop + 1]
        squares_x = np.square(np.diff(part, axis=1) / dx)
        squares_y = np.square(np.diff(part, axis=0) / dy)
        excess = np.zeros((part.shape[0] - 1, part.shape[1] - 1))
        for along_x in (squares_x[:-1], squares_x[1:]):
            for along_y in (squares_y[:, :-1], squares_y[:, 1:]):
                square = along_x + along_y
                # √(1 + s²) - 1 without cancellation at small slopes.
                excess += square / (1 + np.sqrt(1 + square))
        count += int(np.count_nonzero(~np.isnan(excess)))
        total += float(np.nansum(excess)) / 4
    if count == 0:
        raise InputError(
            "has no cell with all four corners there: no area is defined", argument="heights"
        )
    return total / count


def autocorrelation(heights: Array) -> Array:
    """Return the autocorrelation function of a map, f_ACF, for lags up to half its sides.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.

    Returns
    -------
    ndarray, shape (2*(ny//2) + 1, nx//2 + 1)
        ``[j, i]`` belongs to the lag (j - ny//2, i) in pixels, so that zero lag, with the value
        1, is ``[ny//2, 0]``; lags with negative x follow from f(-t) = f(t). NaN where fewer
        than 5 % of the points have a partner, and everywhere if the map is flat.

    Raises
    ------
    InputError
        If every point is missing.

    Notes
    -----
    f(t) = ⟨z(r) z(r + t)⟩ / ⟨z²⟩, with z the height above the mean and the upper average over
    the pairs of points that are both there. The map is not continued beyond its edges and holes
    need no filling. Longer lags have less than a quarter of the pairs in the corners of the map
    of lags: they carry chance rather than texture. The transforms take about nine times the
    memory of the map.

    References
    ----------
    ISO 25178-2:2021, section 3 (autocorrelation function)

    Examples
    --------
    >>> stripes = np.tile([-1.0, 1.0], (4, 2))
    >>> autocorrelation(stripes)[2].round(12) + 0.0
    array([ 1., -1.,  1.])
    """
    ny, nx = heights.shape
    half_y, half_x = ny // 2, nx // 2
    mean, count = _mean(heights)
    Sq = rms_height(heights)
    if Sq == 0 or np.nanmax(heights) == np.nanmin(heights):
        return np.full((2 * half_y + 1, half_x + 1), math.nan)
    padded = (
        fft.fast_length(ny + half_y),
        fft.fast_length(nx + half_x),
    )

    def correlate(scratch: Array) -> Array:
        spectrum = fft.rfft2(scratch)
        for rows in _blocks(spectrum.shape):
            spectrum[rows] = np.square(spectrum[rows].real) + np.square(spectrum[rows].imag)
        sums: Array = fft.irfft2(spectrum, padded)
        return np.concatenate([sums[padded[0] - half_y :, : half_x + 1],
                               sums[: half_y + 1, : half_x + 1]])  # fmt: skip

    scratch = np.zeros(padded)
    for rows in _blocks(heights.shape):
        z = (heights[rows] - mean) / Sq
        z[np.isnan(z)] = 0.0
        scratch[rows, :nx] = z
    function = correlate(scratch)
    if count == heights.size:
        pairs = np.outer(ny - np.abs(np.arange(-half_y, half_y + 1.0)),
                         nx - np.arange(half_x + 1.0))  # fmt: skip
    else:
        for rows in _blocks(heights.shape):
            scratch[rows, :nx] = ~np.isnan(heights[rows])
        pairs = np.rint(correlate(scratch))
    pairs[pairs < max(_LEAST_OVERLAP * count, 1)] = math.nan
    function /= pairs
    return function


def autocorrelation_lengths(
    heights: Array, pixel: tuple[float, float], threshold: float = 0.2
) -> tuple[float, float]:
    """Return the distances of fastest and of slowest decay of the autocorrelation function.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], levelled before: a slope left in the map correlates over all of it. NaN
        where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    threshold : float
        Value s to which the function decays from 1, between 0 and 1.

    Returns
    -------
    (float, float)
        Fastest, which is Sal, and slowest [m]; the texture aspect ratio Str is their quotient.
        The slowest is infinite if in some direction the function stays above the threshold over
        half the map, both are if it does so in every direction. NaN if the map is flat.

    Raises
    ------
    InputError
        If every point is missing, the pixel is not positive or the threshold is outside (0, 1).

    Notes
    -----
    ``Sal = min |t|`` over the lags with f(t) ≤ s; ``Str = Sal / max |t|`` over the lags that are
    joined to zero lag by a straight line on which f ≥ s. Both follow from the first crossing of s
    on the rays from zero lag to every lag on the border of `autocorrelation`, with linear
    interpolation. Lengths of about one pixel are therefore the pixel's rather than the
    surface's.

    References
    ----------
    ISO 25178-2:2021, section 4.3; the default threshold of 0.2 is that of ISO 25178-3.

    Examples
    --------
    >>> wave = np.cos(2 * np.pi * np.arange(4096) / 64) * np.ones((4, 1))
    >>> fastest, slowest = autocorrelation_lengths(wave, (1.0, 1.0))
    >>> round(fastest / 64, 3), round(float(np.arccos(0.2)) / (2 * np.pi), 3), slowest
    (0.218, 0.218, inf)
    """
    require_pixel(pixel)
    if not 0 < threshold < 1:
        raise InputError(
            f"must lie between 0 and 1, got {threshold!r}", argument="threshold", value=threshold
        )
    function = autocorrelation(heights)
    half_y, half_x = function.shape[0] // 2, function.shape[1] - 1
    if np.isnan(function[half_y, 0]):
        return math.nan, math.nan
    # Rays advance by one pixel along the axis they are closer to.
    y, x = _border(half_y, half_x)
    reach = np.maximum(np.abs(y), x)
    y, x, reach = y[reach > 0], x[reach > 0], reach[reach > 0]
    uy, ux = y / reach, x / reach
    stride = np.hypot(uy * pixel[0], ux * pixel[1])
    lengths = np.full(reach.size, math.inf)
    live, before = np.arange(reach.size), np.ones(reach.size)
    for step in range(1, max(half_y, half_x) + 1):
        inside = reach[live] >= step
        live, before = live[inside], before[inside]
        value = _bilinear(function, half_y + step * uy[live], step * ux[live])
        low = value <= threshold
        crossing = step - (threshold - value[low]) / (before[low] - value[low])
        lengths[live[low]] = crossing * stride[live[low]]
        # A ray that runs into lags without enough pairs ends there, undecided.
        high = value > threshold
        live, before = live[high], value[high]
        if live.size == 0:
            break
    return float(lengths.min()), float(lengths.max())


def material_ratio_curve(heights: Array) -> tuple[Array, Array]:
    """Return the areal material ratio curve (bearing or Abbott-Firestone curve).

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.

    Returns
    -------
    ratio : ndarray, shape (n,)
        Material ratio, the share of the points that lie above a height; rises from 0 to 1.
    height : ndarray, shape (n,)
        That height, above the mean; falls from Sp to -Sv. The curve is straight in between.

    Raises
    ------
    InputError
        If every point is missing.

    Notes
    -----
    Each height that occurs stands at the middle of the step that it makes in the curve. Equal
    heights make one wide step, hence the curve of a map with coarse digits is smooth. Of more
    than 2¹⁸ different heights, neighbours in the order are averaged in groups of equal number.

    References
    ----------
    ISO 25178-2:2021, sections 3 and 4.5 (areal material ratio and its inverse)

    Examples
    --------
    >>> material_ratio_curve(np.array([[3.0, 1.0], [1.0, -1.0]]))[0]
    array([0.   , 0.125, 0.5  , 0.875, 1.   ])
    """
    mean, count = _mean(heights)
    order = heights[~np.isnan(heights)]
    order.sort()
    order = order[::-1]
    order -= mean
    starts = np.concatenate([[0], np.flatnonzero(order[1:] != order[:-1]) + 1])
    group = -(-starts.size // _CURVE_POINTS)
    starts = starts[::group]
    ends = np.append(starts[1:], count)
    middle = order[starts]
    if group > 1:
        middle = np.add.reduceat(order, starts) / (ends - starts)
    ratio = np.concatenate([[0.0], (starts + ends) / (2 * count), [1.0]])
    return ratio, np.concatenate([order[:1], middle, order[-1:]])


def core_parameters(ratio: Array, height: Array) -> dict[str, float]:
    """Return the parameters of a stratified surface: Sk, Spk, Svk, Smr1 and Smr2.

    Parameters
    ----------
    ratio, height : ndarray, shape (n,)
        Curve as `material_ratio_curve` returns it.

    Returns
    -------
    dict
        ``Sk`` core height, ``Spk`` reduced peak height, ``Svk`` reduced dale depth, in the unit
        of the heights; ``Smr1``, ``Smr2`` material ratios of peaks and of peaks with core, as
        fractions.

    Notes
    -----
    The secant over a material ratio of 40 % with the least slope bounds the central region; of
    several, the one at the smallest ratio. The equivalent line is the least-squares fit, in
    height, to the curve in that region. It meets the ratios 0 and 1 at the heights c₁ and c₂:
    Sk = c₁ - c₂, and the curve has these heights at Smr1 and Smr2. Spk and Svk are the heights of
    the right-angled triangles over Smr1 and 1 - Smr2 that have the area between curve and c₁, or
    between c₂ and curve.

    References
    ----------
    ISO 25178-2:2021, section 4.5 (areal parameters for stratified surfaces); the construction is
    that of ISO 13565-2:1996.

    Examples
    --------
    >>> values = core_parameters(np.array([0.0, 0.8, 1.0]), np.array([0.2, -0.6, -4.8]))
    >>> {name: round(value, 12) for name, value in values.items()}
    {'Sk': 1.0, 'Spk': 0.0, 'Svk': 4.0, 'Smr1': 0.0, 'Smr2': 0.809523809524}
    """
    width = 0.4
    # The fall over the width is piecewise linear: its minimum lies where either end has a kink.
    kinks = np.concatenate([ratio, ratio - width, [1 - width]])
    kinks = np.sort(kinks[(kinks >= 0) & (kinks <= 1 - width)])
    fall = np.interp(kinks, ratio, height) - np.interp(kinks + width, ratio, height)
    # A tolerance, lest rounding pick one of several equal secants.
    tolerance = 1e-12 * (height[0] - height[-1])
    start = float(kinks[np.argmax(fall <= fall.min() + tolerance)])
    part, z = _section(ratio, height, start, start + width)
    t = part - (start + width / 2)
    # ∫ t z dt, exactly: Simpson's rule on every straight piece.
    middle = (t[1:] + t[:-1]) * (z[1:] + z[:-1])
    moment = float(np.sum(np.diff(t) * (t[1:] * z[1:] + t[:-1] * z[:-1] + middle))) / 6
    slope = 12 * moment / width**3
    center = _integral(part, z) / width
    c1 = center - slope * (start + width / 2)
    c2 = c1 + slope
    Smr1, Smr2 = _ratio_at(ratio, height, c1), _ratio_at(ratio, height, c2)
    peaks, dales = _section(ratio, height, 0.0, Smr1), _section(ratio, height, Smr2, 1.0)
    peak_area = _integral(peaks[0], np.maximum(peaks[1] - c1, 0.0))
    dale_area = _integral(dales[0], np.maximum(c2 - dales[1], 0.0))
    return {
        "Sk": c1 - c2,
        "Spk": 2 * peak_area / Smr1 if Smr1 > 0 else 0.0,
        "Svk": 2 * dale_area / (1 - Smr2) if Smr2 < 1 else 0.0,
        "Smr1": Smr1,
        "Smr2": Smr2,
    }


def volume_parameters(
    ratio: Array, height: Array, peak: float = 0.1, core: float = 0.8
) -> dict[str, float]:
    """Return the volume parameters Vmp, Vmc, Vvc and Vvv.

    Parameters
    ----------
    ratio, height : ndarray, shape (n,)
        Curve as `material_ratio_curve` returns it.
    peak, core : float
        Material ratios p and q between which the core lies, 0 < p < q < 1.

    Returns
    -------
    dict
        ``Vmp`` and ``Vmc``, material volume of the peaks and of the core, ``Vvc`` and ``Vvv``,
        void volume of the core and of the dales: volumes per area [m³/m²], in the unit of the
        heights. (1 m³/m² = 10⁶ ml/m².)

    Raises
    ------
    InputError
        If the ratios are not in order.

    Notes
    -----
    With c(r) the height at the material ratio r, the material volume above it is
    Vm(r) = ∫₀ʳ (c - c(r)) and the void volume below it Vv(r) = ∫ᵣ¹ (c(r) - c), both over the
    ratio. Vmp = Vm(p), Vmc = Vm(q) - Vm(p), Vvc = Vv(p) - Vv(q), Vvv = Vv(q).

    References
    ----------
    ISO 25178-2:2021, section 4.5 (void and material volume); the default ratios of 10 % and
    80 % are those of ISO 25178-3.

    Examples
    --------
    >>> values = volume_parameters(np.array([0.0, 1.0]), np.array([1.0, 0.0]))
    >>> {name: round(value, 12) for name, value in values.items()}
    {'Vmp': 0.005, 'Vmc': 0.315, 'Vvc': 0.385, 'Vvv': 0.02}
    """
    if not 0 < peak < core < 1:
        raise InputError(
            f"and core must fulfil 0 < peak < core < 1, got {peak!r}, {core!r}",
            argument="peak",
            value=peak,
        )

    def material(r: float) -> float:
        part, c = _section(ratio, height, 0.0, r)
        return _integral(part, c - c[-1])

    def void(r: float) -> float:
        part, c = _section(ratio, height, r, 1.0)
        return _integral(part, c[0] - c)

    return {
        "Vmp": material(peak),
        "Vmc": material(core) - material(peak),
        "Vvc": void(peak) - void(core),
        "Vvv": void(core),
    }


def radial_spectrum(heights: Array, pixel: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Return the radially averaged power spectral density of a map.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m] without holes, levelled before.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    q : ndarray, shape (n,)
        Mean wave number of each shell [rad/m].
    C : ndarray, shape (n,)
        Mean spectral density in the shell, C^iso [m⁴].
    waves : ndarray, shape (n,)
        Number of wave vectors ``(q_y, q_x)`` in the shell, positive and negative ones.

    Raises
    ------
    InputError
        If points are missing or the pixel is not positive.

    Notes
    -----
    ``C(q) = |h̃(q)|² / (Lx Ly)`` with h̃(q) = Δx Δy Σ z exp(-i q·r) and z the height above the mean.
    Shell k holds the wave vectors with ``(k - ½) δ ≤ |q| < (k + ½) δ``, δ = 2π/min(Lx, Ly), without
    q = 0; empty shells do not occur. Hence Sq² = Σ C·waves / (Lx Ly) holds to rounding; the
    integral over the plane is Sq² = ∫ C q dq / 2π.

    Shells beyond π/max(Δx, Δy) are cut off by the corners of the grid; ``waves`` shows it.

    No window is applied: a periodic map is resolved exactly. A map that is not has a step
    between its opposite edges, which adds to C at large q; level it, and distrust slopes of
    log C against log q below -3 at the fine end.

    References
    ----------
    Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8

    Examples
    --------
    >>> wave = np.cos(2 * np.pi * np.arange(32) / 8) * np.ones((32, 1))
    >>> q, C, waves = radial_spectrum(wave, (1.0, 1.0))
    >>> round(float(q[C.argmax()] * 8 / (2 * np.pi)), 1), round(float((C * waves).sum() / 32**2), 6)
    (1.0, 0.5)
    """
    require_pixel(pixel)
    missing = int(np.count_nonzero(np.isnan(heights)))
    if missing:
        raise InputError(
            f"has {missing} missing points; fill or crop them first, e.g. surface.filled()",
            argument="heights",
        )
    (ny, nx), (dy, dx) = heights.shape, pixel
    spectrum = fft.rfft2(heights - _mean(heights)[0])
    qy = 2 * np.pi * fft.frequencies(ny, dy)
    qx = 2 * np.pi * fft.half_frequencies(nx, dx)
    delta = 2 * np.pi / min(ny * dy, nx * dx)
    shells = int(math.hypot(np.abs(qy).max(), qx.max()) / delta + 0.5) + 1
    # The half spectrum stands for both signs of q_x, but for its first and, if even, last column.
    weight = np.full(qx.size, 2.0)
    weight[0] = 1.0
    if nx % 2 == 0:
        weight[-1] = 1.0
    sums = np.zeros((3, shells))
    for rows in _blocks(spectrum.shape):
        q = np.hypot(qy[rows, None], qx)
        shell = (q / delta + 0.5).astype(np.int64).ravel()
        weights = np.broadcast_to(weight, q.shape).copy()
        if rows.start == 0:
            weights[0, 0] = 0.0
        power = np.square(spectrum[rows].real) + np.square(spectrum[rows].imag)
        for total, values in zip(sums, (weights, weights * q, weights * power), strict=True):
            total += np.bincount(shell, values.ravel(), minlength=shells)
    waves, wave_number, power = sums[:, sums[0] > 0]
    return wave_number / waves, power / waves * (dx * dy / (nx * ny)), waves


def _mean(heights: Array) -> tuple[float, int]:
    total, count = 0.0, 0
    for rows in _blocks(heights.shape):
        count += int(np.count_nonzero(~np.isnan(heights[rows])))
        total += float(np.nansum(heights[rows]))
    if count == 0:
        raise InputError("has no finite value: every point is missing", argument="heights")
    mean = total / count
    # Once more, for what rounding took from the mean of a map far from zero height.
    rest = sum(float(np.nansum(heights[rows] - mean)) for rows in _blocks(heights.shape))
    return mean + rest / count, count


def _border(half_y: int, half_x: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    # Lags (y, x) on the rim of the half plane x ≥ 0.
    y, x = np.arange(-half_y, half_y + 1), np.arange(half_x)
    return (
        np.concatenate([y, np.full(half_x, half_y), np.full(half_x, -half_y)]),
        np.concatenate([np.full(y.size, half_x), x, x]),
    )


def _bilinear(values: Array, y: Array, x: Array) -> Array:
    row = np.clip(y.astype(np.int64), 0, max(values.shape[0] - 2, 0))
    column = np.clip(x.astype(np.int64), 0, max(values.shape[1] - 2, 0))
    below, right = (np.minimum(index + 1, length - 1)
                    for index, length in zip((row, column), values.shape, strict=True))  # fmt: skip
    v, u = y - row, x - column
    upper = (1 - u) * values[row, column] + u * values[row, right]
    lower = (1 - u) * values[below, column] + u * values[below, right]
    interpolated: Array = (1 - v) * upper + v * lower
    return interpolated


def _section(ratio: Array, height: Array, start: float, stop: float) -> tuple[Array, Array]:
    inner = (ratio > start) & (ratio < stop)
    part = np.concatenate([[start], ratio[inner], [stop]])
    return part, np.interp(part, ratio, height)


def _integral(x: Array, y: Array) -> float:
    return float(np.sum(np.diff(x) * (y[1:] + y[:-1]))) / 2


def _ratio_at(ratio: Array, height: Array, c: float) -> float:
    if c >= height[0]:
        return 0.0
    if c <= height[-1]:
        return 1.0
    return float(np.interp(-c, -height, ratio))


def _blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    step = max(1, _BLOCK // max(1, shape[1]))
    for start in range(0, shape[0], step):
        yield slice(start, min(start + step, shape[0]))
