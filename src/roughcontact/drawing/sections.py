"""Line plots of a result: sections, material ratio curve, pressure distribution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.contact import hertz_comparison
from roughcontact.contact.nominal_hertz import LINE, SmoothContact
from roughcontact.contact.result import ContactResult
from roughcontact.drawing import style
from roughcontact.errors import InputError, input_error, require_positive
from roughcontact.solvers import rigid_tilt
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface
from roughcontact.units import format_engineering, format_percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Mask = NDArray[np.bool_]


def pressure_histogram(
    results: ContactResult | Sequence[ContactResult],
    labels: Sequence[str] | None = None,
    scale: str = "linear",
) -> Figure:
    """Draw the distribution of contact area over pressure.

    Parameters
    ----------
    results : ContactResult or sequence of them
        One or several solved contacts, drawn over the same bins.
    labels : sequence of str, optional
        One name per result.
    scale : {"linear", "log"}
        Scale of the pressure axis. With ``"log"`` the density is per decade of pressure.

    Returns
    -------
    Figure
        Density of contact area over pressure, in percent of the contact area of the result. The
        share of points at the ceiling, a peak without width, is given in the legend.

    Raises
    ------
    InputError
        If there is no result, the labels do not fit, or the scale is unknown.
    """
    if isinstance(results, ContactResult):
        results = [results]
    names = style.result_names(results, labels)
    if scale not in ("linear", "log"):
        raise input_error("scale", scale, "must be 'linear' or 'log'")
    figure, axes = style.panels(7.2, 5.2)
    draw_histogram(axes, results, names, scale)
    axes.set_title("Distribution of the contact pressure", fontsize=style.TITLE, pad=24)
    return figure


def section(result: ContactResult, width: float | None = None) -> Figure:
    """Draw sections through the highest peak: profile before and under load, and pressure.

    Parameters
    ----------
    result : ContactResult
        A solved contact.
    width : float, optional
        Drawn length [m], around the peak but within the map; by default the whole map.

    Returns
    -------
    Figure
        Along x on the left, along y on the right. Zero height is the counter-body: the profile
        before loading, shifted by approach and tilt, overlaps the counter-body; the profile under
        load does not, except for the indentation of saturated points. For two measured bodies,
        the sum of their heights is drawn. Heights are exaggerated.

    Raises
    ------
    InputError
        If the width is not positive and finite.
    """
    if width is not None:
        require_positive(width=width)
    before = result.initial_gap
    peak = _highest(before)
    length = min(width or math.inf, max(result.surface.size))
    lines = [line_of(result, before, peak, axis, width or math.inf) for axis in (1, 0)]
    far = max(line.limits[1] for line in lines)
    factor, unit = style.prefixed_window(far - length, far)
    figure, grid = style.panels(
        10.6, 7.2, 2, 2, sharex="col", sharey="row", height_ratios=(1.25, 1)
    )
    draw_lines(result, lines, grid, factor, ticks=6)
    for (upper, lower), line, name, other in zip(grid.T, lines, "xy", "yx", strict=True):
        where = style.in_unit(line.across, (factor, unit), "m")
        style.name_axes(upper, title=f"along {name}, at {other} = {where}")
        style.name_axes(lower, f"{name} [{unit}]")
        for axes in (upper, lower):
            axes.axvline(line.peak * factor, color=style.NEUTRAL, lw=0.9, ls=":")
    style.shared_legend(
        figure,
        grid,
        "Sections through the highest peak at "
        f"{style.load_text(result)}{style.doubt_suffix(result)}",
    )
    return figure


def bearing_curve(surface: Surface) -> Figure:
    """Draw the areal material ratio curve of a surface (bearing or Abbott-Firestone curve).

    Parameters
    ----------
    surface : Surface
        The map; missing points are excluded.

    Returns
    -------
    Figure
        Height above the mean over the share of higher points, with the equivalent straight line
        of the core and the triangles of reduced peaks and dales, see
        `roughness.core_parameters`.
    """
    ratio, height, core, upper = bearing_parts(surface)
    lower = upper - core["Sk"]
    scale = factor, unit = style.axis_unit(float(np.abs(height).max()), "m")
    figure, axes = style.panels(7.2, 5.2)
    first, second = 100 * core["Smr1"], 100 * core["Smr2"]
    axes.plot(100 * ratio, height * factor, color=style.SERIES[0], lw=2.2, zorder=3)
    axes.fill(
        [0, 0, first],
        [upper * factor, (upper + core["Spk"]) * factor, upper * factor],
        color=style.SERIES[4],
        label=f"reduced peaks: Spk {style.in_unit(core['Spk'], scale, 'm')}, Smr1 {first:.1f} %",
    )
    axes.plot(
        [0, 100],
        [upper * factor, lower * factor],
        color=style.NEUTRAL,
        ls=(0, (5, 3)),
        lw=1.5,
        label=f"core: Sk {style.in_unit(core['Sk'], scale, 'm')}",
    )
    axes.fill(
        [100, 100, second],
        [lower * factor, (lower - core["Svk"]) * factor, lower * factor],
        color=style.SERIES[5],
        label=f"reduced dales: Svk {style.in_unit(core['Svk'], scale, 'm')}, Smr2 {second:.1f} %",
    )
    for value in (upper, lower):
        axes.axhline(value * factor, color=style.NEUTRAL, lw=0.8, ls=":")
    axes.set_xlim(0, 100)
    style.plain_axes(
        axes, "material ratio [%]", f"height above mean [{unit}]", "Material ratio curve"
    )
    style.legend_below(axes)
    return figure


def bearing_parts(surface: Surface) -> tuple[Array, Array, dict[str, float], float]:
    """Return ratios, heights [m], core parameters and top of the core [m] of a surface."""
    ratio, height = roughness.material_ratio_curve(surface.heights)
    core = roughness.core_parameters(ratio, height)
    # The core line meets the curve at Smr1 and Smr2, unless it exceeds the heights of the map.
    if core["Smr1"] > 0:
        upper = float(np.interp(core["Smr1"], ratio, height))
    elif core["Smr2"] < 1:
        upper = float(np.interp(core["Smr2"], ratio, height)) + core["Sk"]
    else:
        upper = core["Sk"] / 2
    return ratio, height, core, upper


class Line(NamedTuple):
    """Points on a section; lengths and heights [m], heights above the counter-body."""

    place: Array
    pixel: float
    peak: float
    across: float
    limits: tuple[float, float]
    before: Array
    under: Array
    pressure: Array
    saturated: Mask
    ceiling: Array | None


def _tilt_gap(result: ContactResult, where: tuple[int | slice, ...]) -> Array:
    """Return the contribution of the tilt to the gap on a section [m]."""
    y, x = rigid_tilt.moment_arms(result.gap.shape, result.surface.pixel)
    slope_y, slope_x = (slope * max(result.surface.size) for slope in result.tilt)
    return (slope_y * y + slope_x * x)[where]


def _highest(initial_gap: Array) -> tuple[int, int]:
    y, x = np.unravel_index(np.nanargmin(initial_gap), initial_gap.shape)
    return int(y), int(x)


def window(centre: int, pixel: float, points: int, width: float) -> tuple[int, int]:
    """Return the first point, and the point after the last, of a length around a point."""
    if width >= points * pixel:
        return 0, points
    shown = min(max(math.ceil(width / pixel - 1e-9), 2), points)
    first = min(max(centre - shown // 2, 0), points - shown)
    return first, first + shown


def line_of(
    result: ContactResult, before: Array, peak: tuple[int, int], axis: int, width: float
) -> Line:
    """Return the section along an axis through a point, of a length [m] around this point."""
    here: list[int | slice] = list(peak)
    pixel, points = result.surface.pixel[axis], result.surface.shape[axis]
    first, last = window(peak[axis], pixel, points, width)
    here[axis] = slice(first, last)
    where = tuple(here)
    ceiling = result.ceiling
    return Line(
        place=pixel * (np.arange(first, last, dtype=np.float64) + 0.5),
        pixel=pixel,
        peak=(peak[axis] + 0.5) * pixel,
        across=(peak[1 - axis] + 0.5) * result.surface.pixel[1 - axis],
        limits=(first * pixel, last * pixel),
        before=result.approach - before[where] - _tilt_gap(result, where),
        under=-result.gap[where],
        pressure=result.pressure[where],
        saturated=result.saturated[where],
        ceiling=None
        if ceiling is None
        else np.broadcast_to(ceiling, result.pressure.shape)[where].astype(np.float64),
    )


def _largest(*values: Array) -> float:
    return max(float(np.nanmax(np.abs(v), initial=0.0)) for v in values)


def draw_lines(
    result: ContactResult, lines: Sequence[Line], grid: NDArray[Any], factor: float, ticks: int
) -> None:
    """Draw profiles above their pressures; the grid has two rows, and a column for each line."""
    from matplotlib.ticker import MaxNLocator

    height_factor, height_unit = style.axis_unit(
        max(_largest(line.before, line.under) for line in lines), "m"
    )
    top = max(_largest(line.pressure) for line in lines)
    # Ceilings far above all pressures do not extend the axis.
    ceilings = [line.ceiling for line in lines if line.ceiling is not None]
    top = max([top, *(_largest(values[values <= 2 * top]) for values in ceilings)])
    pressure_factor, pressure_unit = style.axis_unit(top, "Pa")
    for (upper, lower), line in zip(grid.T, lines, strict=True):
        _draw_profile(upper, line, factor, height_factor)
        _draw_pressure(lower, line, top, factor, pressure_factor)
        lower.set_xlim(line.limits[0] * factor, line.limits[1] * factor)
        for axes in (upper, lower):
            axes.xaxis.set_major_locator(MaxNLocator(ticks))
            style.plain_axes(axes)
    what = "height" if result.counter_surface is None else "sum of heights"
    style.name_axes(grid[0, 0], y=f"{what} [{height_unit}]")
    style.name_axes(grid[1, 0], y=f"pressure [{pressure_unit}]")
    grid[1, 0].set_ylim(0, 1.08 * (top or 1.0) * pressure_factor)


def _draw_profile(axes: Axes, line: Line, factor: float, height_factor: float) -> None:
    """Draw a section before and under load into axes."""
    place = line.place * factor
    before, under = line.before * height_factor, line.under * height_factor
    axes.fill_between(place, under, 0, where=under < 0, color="#dcebf5", label="gap left")
    axes.plot(place, before, color="#8a8a8a", lw=1.1, label="before loading, moved by the approach")
    axes.axhline(0, color="#000000", lw=1.2, label="counter-body")
    axes.plot(place, under, color=style.SERIES[0], lw=1.6, label="under load")
    if line.saturated.any():
        axes.fill_between(
            place,
            np.where(line.saturated, np.maximum(under, 0), 0.0),
            0,
            step="mid",
            color=style.SATURATED,
            label="overlap that flows plastically (saturated)",
        )


def _draw_pressure(
    axes: Axes, line: Line, top: float, factor: float, pressure_factor: float
) -> None:
    """Draw the pressure on a section into axes; the caller sets the limits."""
    from matplotlib.patches import StepPatch

    edges = np.append(line.place - line.pixel / 2, line.place[-1] + line.pixel / 2) * factor
    for mask, colour in ((~line.saturated, style.ELASTIC), (line.saturated, style.SATURATED)):
        values = np.where(mask, line.pressure, 0.0) * pressure_factor
        # `stairs` would compute limits from every edge, which are known here.
        axes.add_artist(StepPatch(values, edges, fill=True, color=colour, lw=0))
    if line.ceiling is not None and (line.ceiling <= top).any():
        axes.plot(
            line.place * factor,
            np.where(line.ceiling <= top, line.ceiling, np.nan) * pressure_factor,
            color=style.NEUTRAL,
            ls=(0, (5, 3)),
            lw=1.3,
            label="ceiling",
        )


def draw_histogram(
    axes: Axes, results: Sequence[ContactResult], names: Sequence[str], scale: str
) -> None:
    """Draw the distributions of pressures into axes; see `pressure_histogram`."""
    below = [result.pressure[result.contact & ~result.saturated] for result in results]
    bins = (_logarithmic if scale == "log" else linear_bins)(results, below)
    edges, shown, (_, last) = bins
    factor, unit = style.axis_unit(last, "Pa")
    widths, per = np.diff(edges) * factor, unit
    if scale == "log":
        widths, per = np.diff(np.log10(edges)), "decade"
    for index, (result, name, values) in enumerate(zip(results, names, below, strict=True)):
        counts, _ = np.histogram(np.clip(values, edges[0], edges[-1]), edges)
        axes.stairs(
            100 * counts / max(int(np.count_nonzero(result.contact)), 1) / widths,
            edges * factor,
            color=style.SERIES[index % len(style.SERIES)],
            lw=1.8,
            ls=("-", "--", ":")[index // len(style.SERIES) % 3],
            fill=len(results) == 1,
            label=histogram_label(result, name, values, bins.limits, (factor, unit)),
        )
    for row, ceiling in enumerate(shown):
        text = f"ceiling {style.in_unit(ceiling, (factor, unit), 'Pa')}"
        if len(results) == 1 and results[0].saturated_fraction > 0:
            text = f"{_share_at_ceiling(results[0])} at the {text}"
        axes.axvline(ceiling * factor, color=style.NEUTRAL, ls=(0, (5, 3)), lw=1.5)
        side, place = "right" if ceiling > 0.85 * last else "center", axes.get_xaxis_transform()
        offset = 0, 3 + 14 * (row % 2)
        style.label_point(axes, text, (ceiling * factor, 1), offset, xycoords=place, ha=side)
    if scale == "log":
        style.log_scale(axes, "x")
    else:
        begin, end = bins.limits
        axes.set_xlim(begin * factor, (end + 0.03 * (end - begin)) * factor)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.1)
    style.plain_axes(axes, f"pressure [{unit}]", f"density of contact area [% per {per}]")
    style.legend_below(axes)


# A linear axis spans the contact pressures from this quantile to one minus this quantile.
_RARE = 0.005
# Largest ratios of a ceiling and of the largest pressure to the upper quantile for which the axis
# includes them; ratio of lower to upper quantile from which the axis does not begin at zero.
_NEAR_CEILING, _NEAR_END, _FAR_FROM_ZERO = 1.3, 2.0, 1 / 3


class Bins(NamedTuple):
    """Edges of the bins, drawn ceilings, and limits of the axis [Pa]."""

    edges: Array
    ceilings: list[float]
    limits: tuple[float, float]


def _number_of_bins(pressures: Sequence[Array], minimum: int) -> float:
    # Number of bins by Rice's rule.
    return float(min(max(2 * max(p.size for p in pressures) ** (1 / 3), minimum), 60))


def _ceilings(results: Sequence[ContactResult]) -> list[float]:
    return sorted({_uniform_ceiling(r) for r in results} - {math.inf})


def linear_bins(results: Sequence[ContactResult], pressures: Sequence[Array]) -> Bins:
    """Return equal bins over the range of pressures, and one for the rest on each side."""
    touching = [r.pressure[r.contact] for r in results if r.contact.any()]
    ends = [np.quantile(p, (_RARE, 1 - _RARE)) for p in touching]
    largest = max(r.max_pressure for r in results) or 1.0
    last = max((float(high) for _, high in ends), default=largest)
    first = min((float(low) for low, _ in ends), default=0.0)
    last = largest if largest <= _NEAR_END * last else last
    first = first if _FAR_FROM_ZERO * last < first < (1 - 1e-9) * last else 0.0
    ceilings = [ceiling for ceiling in _ceilings(results) if ceiling > first]
    shown = [ceiling for ceiling in ceilings if ceiling <= _NEAR_CEILING * last]
    last = max([last, *shown])
    step = (last - first) / _number_of_bins(pressures, 5)
    # The lowest ceiling is an edge, so that no bin extends beyond it; but not if it is smaller than
    # half a bin, which would need too many bins.
    if shown and 2 * (shown[0] - first) >= step:
        step = (shown[0] - first) / max(round((shown[0] - first) / step), 1)
    equal = first + step * np.arange(math.ceil((last - first) / step - 1e-9) + 1)
    beyond = {p for p in (*ceilings, largest) if equal[-1] * (1 + 1e-9) < p <= largest}
    edges = [*[0.0] * (first > 0), *equal.tolist(), *sorted(beyond)]
    return Bins(np.array(edges, dtype=np.float64), shown, (first, last))


def _logarithmic(results: Sequence[ContactResult], pressures: Sequence[Array]) -> Bins:
    """Return equal logarithmic bins over the decades of the pressures, at most four."""
    largest = max(r.max_pressure for r in results) or 1.0
    # Ceilings far above all pressures are in the legend but do not extend the axis.
    shown = [ceiling for ceiling in _ceilings(results) if ceiling <= 2 * largest]
    top = max([largest, *shown])
    lowest = min((float(p.min()) for p in pressures if p.size), default=0.1 * top)
    decades = min(max(math.log10(top / lowest), 0.5), 4.0)
    step = decades / _number_of_bins(pressures, 10)
    # The lowest ceiling is an edge of a bin.
    anchor = math.log10(shown[0] if shown else top)
    before = math.ceil((decades - math.log10(top) + anchor) / step)
    after = math.ceil((math.log10(top) - anchor) / step - 1e-9)
    exponents = anchor + step * np.arange(-max(before, 1), after + 1)
    return Bins(np.asarray(10.0**exponents), shown, (0.0, top))


def histogram_label(
    result: ContactResult,
    name: str,
    values: Array,
    limits: tuple[float, float],
    scale: tuple[float, str],
) -> str:
    """Return the label of a pressure distribution, in several lines."""
    text = f"{name}: " if name else ""
    text += (
        f"{format_percent(result.contact_fraction)} of the map in "
        f"contact{style.doubt_suffix(result)}"
    )
    if result.ceiling is not None:
        ceiling = _uniform_ceiling(result)
        which = "its" if math.isinf(ceiling) else f"the {format_engineering(ceiling, 'Pa', 3)}"
        if result.saturated_fraction == 0:
            text += f",\nnone of it at {which} ceiling"
        else:
            text += f",\n{_share_at_ceiling(result)} of it at {which} ceiling (not drawn)"
    rare = values[(values < limits[0]) | (values > limits[1] * (1 + 1e-9))]
    if rare.size:
        share = format_percent(rare.size / int(np.count_nonzero(result.contact)))
        end = f"down to {style.in_unit(float(rare.min()), scale, 'Pa')}"
        if rare.max() > limits[1]:
            end = f"up to {style.in_unit(float(rare.max()), scale, 'Pa')}"
        text += f",\n{share} of it {end} (beyond the axis)"
    return text


def _share_at_ceiling(result: ContactResult) -> str:
    return format_percent(result.saturated_fraction / result.contact_fraction)


def _uniform_ceiling(result: ContactResult) -> float:
    # Infinite without a ceiling, or with a ceiling that varies between points.
    ceiling = result.ceiling
    return ceiling if isinstance(ceiling, (int, float)) else math.inf


# Minimum range of the axis over the half-width of the Hertz contact.
_AROUND = 1.5


def versus_hertz(result: ContactResult) -> Figure:
    """Draw the pressure over the distance from the contact center, rough and Hertzian.

    Parameters
    ----------
    result : ContactResult
        A solved contact of nominal bodies, with pressure.

    Returns
    -------
    Figure
        Mean and largest pressure on lines along a cylinder, or on rings of the shape of the Hertz
        contact about the center of pressure, one pixel wide, and the Hertz pressure.

    Raises
    ------
    InputError
        If the bodies have no Hertz contact.
    """
    smooth = result.hertz
    if smooth is None:
        raise InputError("has no nominal bodies covered by Hertz's theory", argument="result")
    line = smooth.shape.kind == LINE
    distance, mean, largest = _mean_lines(result, smooth) if line else _rings(result, smooth)
    half = smooth.semi_axes[0]
    ends = _distance_ends(distance, largest, half, line)
    factor, unit = style.axis_unit(max(map(abs, ends)), "m")
    scale, pressure_unit = style.axis_unit(max(float(largest.max()), smooth.max_pressure), "Pa")
    figure, axes = style.panels(7.2, 5.0)
    where = "along the axis" if line else "on the ring"
    axes.plot(
        distance * factor, largest * scale, color=style.SATURATED, lw=1.0, label=f"largest {where}"
    )
    axes.plot(distance * factor, mean * scale, color=style.ELASTIC, lw=2.2, label=f"mean {where}")
    position = np.linspace(-half if line else 0.0, half, 400)
    axes.plot(
        position * factor,
        smooth.max_pressure * np.sqrt(np.maximum(1 - (position / half) ** 2, 0)) * scale,
        color=style.NEUTRAL,
        lw=1.8,
        ls="--",
        label="Hertz, smooth",
    )
    axes.set_xlim(ends[0] * factor, ends[1] * factor)
    axes.set_ylim(bottom=0)
    name = "distance across from the middle" if line else "distance from the middle"
    if smooth.shape.kind == "ellipse":
        name += " along the longer side"
    style.plain_axes(
        axes,
        f"{name} [{unit}]",
        f"pressure [{pressure_unit}]",
        f"Compared with Hertz at {style.load_text(result)}{style.doubt_suffix(result)}",
    )
    style.legend_below(axes, columns=1)
    return figure


def _mean_lines(result: ContactResult, smooth: SmoothContact) -> tuple[Array, Array, Array]:
    """Return distances across a cylinder, and mean and largest pressure along it."""
    axis = smooth.shape.axis
    assert axis is not None
    across = hertz_comparison.distances_from(result, result.center_of_pressure)[1 - axis].ravel()
    return across, result.pressure.mean(axis=axis), result.pressure.max(axis=axis)


def _rings(result: ContactResult, smooth: SmoothContact) -> tuple[Array, Array, Array]:
    """Return distances from the center, and mean and largest pressure on rings."""
    a, b = smooth.semi_axes[0], smooth.semi_axes[-1]
    along, across = hertz_comparison.contact_axes(smooth)
    y, x = hertz_comparison.distances_from(result, result.center_of_pressure)
    u, v = (cy * y + cx * x for cy, cx in (along, across))
    distance = np.sqrt(u**2 + (v * (a / b)) ** 2).ravel()
    width = max(result.surface.pixel) * (a / b)
    ring = (distance / width).astype(np.intp)
    count = np.bincount(ring)
    mean = np.bincount(ring, result.pressure.ravel()) / np.maximum(count, 1)
    largest = np.zeros(count.size)
    np.maximum.at(largest, ring, result.pressure.ravel())
    filled = count > 0
    middle = (np.flatnonzero(filled) + 0.5) * width
    return middle.astype(np.float64), mean[filled], largest[filled]


def _distance_ends(distance: Array, largest: Array, half: float, line: bool) -> tuple[float, float]:
    """Return the ends of the axis: around both contacts, within the map."""
    far = max(_AROUND * half, float(np.abs(distance[largest > 0]).max(initial=0.0)) * 1.05)
    low, high = float(distance.min()), float(distance.max())
    return (max(-far, low) if line else 0.0), min(far, max(high, half))


def heights(surface: Surface) -> Figure:
    """Draw the heights of a profile.

    Parameters
    ----------
    surface : Surface
        A profile; the line is interrupted at missing points.

    Returns
    -------
    Figure
        Heights over the position, not to scale: heights are exaggerated.
    """
    z, spacing = surface.heights[0], surface.pixel[1]
    x = spacing * (np.arange(z.size) + 0.5)
    along, unit_along = style.axis_unit(surface.size[1], "m")
    up, unit_up = style.axis_unit(float(np.nanmax(np.abs(z))), "m")
    figure, axes = style.panels(10.6, 3.8)
    axes.plot(x * along, z * up, color=style.SERIES[0], lw=0.9)
    axes.set_xlim(0, surface.size[1] * along)
    style.plain_axes(axes, f"x [{unit_along}]", f"height [{unit_up}]", "Profile")
    return figure


def loaded_profile(
    result: ContactResult, width: float | None = None, middle: int | None = None
) -> Figure:
    """Draw a profile before and under load, and the contact pressure.

    Parameters
    ----------
    result : ContactResult
        A contact of profiles.
    width : float, optional
        Drawn length [m]; by default the whole profile.
    middle : int, optional
        Index of the central point; by default the point of the largest pressure.

    Returns
    -------
    Figure
        Zero height is the counter-body. For two profiles, the sum of their heights is drawn.

    Raises
    ------
    InputError
        If the width is not positive and finite.
    """
    if width is not None:
        require_positive(width=width)
    place = 0, int(np.argmax(result.pressure)) if middle is None else middle
    line = line_of(result, result.initial_gap, place, 1, width or math.inf)
    factor, unit = style.prefixed_window(*line.limits)
    figure, grid = style.panels(
        10.6, 6.8, 2, 1, sharex=True, height_ratios=(1.25, 1), squeeze=False
    )
    draw_lines(result, [line], grid, factor, ticks=8)
    style.name_axes(grid[1, 0], f"x [{unit}]")
    style.shared_legend(
        figure, grid, f"Profile under {style.load_text(result)}{style.doubt_suffix(result)}"
    )
    return figure
