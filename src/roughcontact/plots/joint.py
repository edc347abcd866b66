"""Figures of joints: conductance, leakage, interface law, and tangential loading."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.joint.conductance import CASES, CORRELATED
from roughcontact.joint.interface_law import LOADING, UNLOADING, InterfaceLaw
from roughcontact.joint.law_curve import between
from roughcontact.plots import maps, style
from roughcontact.units import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from roughcontact.joint.conductance import Conductance
    from roughcontact.joint.flow import Flow
    from roughcontact.joint.leakage import Leakage
    from roughcontact.joint.tangential import Tangential

Array = NDArray[np.float64]

# --- Conductance ---

_RESISTANCES = (
    ("length", "o-", style.SERIES[0], "computed"),
    ("greenwood_length", "s--", style.SERIES[1], "Greenwood's formula"),
    ("correlation_length", ":", style.NEUTRAL, "correlation for flat joints"),
)


def _band(axes: Axes, load: Array, correlated: Array) -> None:
    """Draw between which resistances 95 % of rough maps were, by their correlation."""
    known = np.isfinite(correlated) & (correlated > 0)
    if np.count_nonzero(known) > 1:
        low, high = (factor * correlated[known] for factor in CORRELATED)
        label = f"95 % of {CASES} rough maps about it"
        axes.fill_between(load[known], low, high, color=style.NEUTRAL, alpha=0.2, lw=0, label=label)


def conductance(result: Conductance) -> Figure:
    """Draw the resistances of a contact over the load.

    Parameters
    ----------
    result : Conductance
        The resistances.

    Returns
    -------
    Figure
        One panel for each known resistance, electrical and thermal: computed, by Greenwood's
        formula, and by the correlation for flat joints with its scatter on other maps.
    """
    kinds = [
        (title, unit, kind)
        for title, unit, kind in (
            ("Electrical resistance", "Ω", "electrical"), ("Thermal resistance", "K/W", "thermal")
        )
        if not np.isnan(result.resistance(kind)).all()
    ]  # fmt: skip
    figure = style.blank(5.6 * len(kinds), 4.6)
    load = result.column("load")
    factor, load_unit = style.prefixed(float(load.max()), "N")
    for axes, (title, unit, kind) in zip(
        figure.subplots(1, len(kinds), squeeze=False)[0], kinds, strict=True
    ):
        for name, marker, colour, label in _RESISTANCES:
            values = result.resistance(kind, name)
            values[~(np.isfinite(values) & (values > 0))] = np.nan
            if not np.isnan(values).all():
                line = marker if load.size > 1 else "o"
                axes.plot(load * factor, values, line, color=colour, label=label)
                style.log_scale(axes, "y")
        _band(axes, load * factor, result.resistance(kind, "correlation_length"))
        style.log_scale(axes, "x")
        style.plain_axes(axes, f"load [{load_unit}]", f"resistance [{unit}]", title)
        if axes.lines:
            style.plain_legend(axes)
    return figure


# --- Leakage ---

_DECADES = 4
# Of the flow density, from the largest down: less is no part of what leaks.


def leak(result: Leakage) -> Figure:
    """Draw the gap under the largest load, and where the fluid flows through it.

    Parameters
    ----------
    result : Leakage
        What leaks.

    Returns
    -------
    Figure
        The open gap with the contact, and the flow density over its mean in each direction that
        percolates, over four decades. A cross marks the narrowest constriction. A cell of several
        points shows its largest flow density.
    """
    flows = [flow for flow in result.flows if flow.percolates]
    aspect = style.shown_aspect(result.largest.pair.size)
    figure = style.blank(4.9 * (1 + len(flows)), 1.0 + 3.6 * aspect)
    first, *others = figure.subplots(1, 1 + len(flows), squeeze=False)[0]
    _draw_leak(first, result, bool(flows))
    for axes, flow in zip(others, flows, strict=True):
        _draw_flow(axes, result, flow)
    return figure


def flow_factors(result: Leakage) -> Figure:
    """Draw the flow factors over the mean gap, and the narrowest place over the load.

    Parameters
    ----------
    result : Leakage
        What leaks.

    Returns
    -------
    Figure
        Pressure flow factors φ = k/ū³ over ū/σ; mean gap and narrowest gap over the load.
    """
    figure, (left, right) = style.panels(11.2, 4.6, 1, 2)
    load = result.column("load")
    mean = result.column("mean_gap")
    load_factor, load_unit = style.prefixed(float(load.max()), "N")
    factor, unit = style.prefixed(float(mean.max()), "m")
    right.plot(load * load_factor, mean * factor, "k:", label="mean gap")
    for axis in result.axes:
        line, colour = ("o-", "s--")[axis], style.SERIES[axis]
        label = f"along {'yx'[axis]}"
        left.plot(result.gap_ratio, _positive(result.flow_factor(axis)), line, color=colour,
                  label=label)  # fmt: skip
        narrow = _positive(result.critical_gap(axis)) * factor
        right.plot(load * load_factor, narrow, line, color=colour, label=f"narrowest, {label}")
    for axes, x, y, title in (
        (left, "mean gap over roughness ū/σ", "flow factor φ", "Pressure-flow factors"),
        (right, f"load [{load_unit}]", f"gap [{unit}]", "Gap at the narrowest place"),
    ):
        if any(np.isfinite(line.get_ydata()).any() for line in axes.lines):
            style.log_scale(axes, "y")
        style.plain_axes(axes, x, y, title)
        style.plain_legend(axes)
    style.log_scale(right, "x")
    return figure


def _positive(values: Array) -> Array:
    return np.where(values > 0, values, np.nan)


def _draw_leak(axes: Axes, answer: Leakage, flows: bool) -> None:
    result = answer.largest
    maps.draw_gap(axes, result, style.CELLS_IN_PANEL)
    for axis in answer.axes:
        _mark(axes, answer, axis)
    more = "" if flows else ", no way through"
    style.name_axes(axes, title=f"Gap and contact at {style.load_text(result)}{more}")


def _draw_flow(axes: Axes, answer: Leakage, flow: Flow) -> None:
    from matplotlib import colormaps
    from matplotlib.colors import LogNorm

    result = answer.largest
    size = result.surface.size
    blocks = style.cell_size(flow.density.shape, size, style.CELLS_IN_PANEL)
    mean = flow.permeability[flow.axis]
    values = style.cell_max(flow.density.astype(float), blocks) / mean
    maximum = float(values.max())
    image = style.draw_map(
        axes, np.maximum(values, maximum * 10.0**-_DECADES), size, blocks, flow.density.shape
    )
    image.set_cmap(colormaps["inferno"])
    image.set_norm(LogNorm(maximum * 10.0**-_DECADES, maximum))
    style.colour_bar(axes, image, "flow density over its mean", "min")
    _mark(axes, answer, flow.axis)
    style.name_axes(axes, title=f"Flow along {'yx'[flow.axis]}")


def _mark(axes: Axes, result: Leakage, axis: int) -> None:
    """Mark the narrowest place under the largest load."""
    place = result.steps[-1].constriction[axis]
    if place is None:
        return
    pixel = result.largest.pair.pixel
    factor, _ = style.prefixed_window(0.0, max(result.largest.pair.size))
    y, x = ((index + 0.5) * edge * factor for index, edge in zip(place.place, pixel, strict=True))
    for colour, width in (("white", 3.0), (style.SERIES[1], 1.5)):
        axes.plot([x], [y], "x", color=colour, markersize=9, markeredgewidth=width)


# --- Interface law ---

_COLOURS = {LOADING: style.SERIES[0], UNLOADING: style.ELASTIC}
_NAMES = {LOADING: "first loading", UNLOADING: "unloading, loading again"}


def interface_law(law: InterfaceLaw) -> Figure:
    """Draw the law of an interface.

    Parameters
    ----------
    law : InterfaceLaw
        The law.

    Returns
    -------
    Figure
        Pressure over separation, areas, stiffness and gap over pressure. Thick lines are means of
        the maps, thin ones single maps; Persson's theory of the elastic joint is dashed, and
        pressures that the maps do not resolve are grey.
    """
    figure, grid = style.panels(11.0, 9.4, 2, 2)
    _draw_separation(grid[0, 0], law)
    _draw_areas(grid[0, 1], law)
    _draw_stiffness(grid[1, 0], law)
    _draw_law_gap(grid[1, 1], law)
    factor, unit = _pressure(law)
    for axes in (grid[0, 1], grid[1, 0], grid[1, 1]):
        style.log_scale(axes, "x")
        style.name_axes(axes, f"nominal pressure [{unit}]")
        axes.set_xlim(*(law.pressures()[[0, -1]] * factor * np.array([0.9, 1.1])))
    for axes in grid.ravel():
        style.plain_axes(axes)
        style.plain_legend(axes)
    return figure


def _pressure(law: InterfaceLaw) -> tuple[float, str]:
    return style.prefixed(float(law.pressures()[-1]), "Pa")


def _draw_separation(axes: Axes, law: InterfaceLaw) -> None:
    factor, unit = _pressure(law)
    scale, length = style.prefixed(max(abs(item.first_touch) for item in law.maps), "m")
    for branch in law.branches:
        colour = _COLOURS[branch]
        if len(law.maps) > 1:
            for item in law.maps:
                own = item.column(branch, "separation"), item.column(branch, "pressure")
                axes.plot(own[0] * scale, own[1] * factor, color=colour, linewidth=0.7, alpha=0.5)
        p, u = law.curve(branch).fine()
        axes.plot(u * scale, p * factor, color=colour, linewidth=2, label=_NAMES[branch])
        pressures = law.pressures(branch)
        separation = law.values(branch, "separation").mean(axis=0)
        axes.plot(separation * scale, pressures * factor, "o", color=colour, markersize=4)
    fine = between(law.pressures(), 8)
    theory = law.persson(fine)
    if np.isfinite(theory).all():
        axes.plot(
            theory * scale, fine * factor, "--", color=style.NEUTRAL, label="Persson, elastic"
        )
    _shade(axes.axhspan, law)
    style.log_scale(axes, "y")
    style.name_axes(
        axes,
        f"separation of the mean planes [{length}]",
        f"nominal pressure [{unit}]",
        "Pressure and separation",
    )


def _shade(span: Callable[..., Any], law: InterfaceLaw) -> None:
    factor, _ = _pressure(law)
    low, high = law.pressures()[[0, -1]]
    result = law.resolved
    for first, last in ((low, result.low), (result.high, high)):
        if last > first:
            span(first * factor, last * factor, color=style.NEUTRAL, alpha=0.12, linewidth=0)


def _line(
    axes: Axes, law: InterfaceLaw, branch: str, name: str, scale: float, **look: Any
) -> Array:
    factor, _ = _pressure(law)
    pressures = law.pressures(branch)
    values = law.values(branch, name) * scale
    values[~(np.isfinite(values) & (values > 0))] = np.nan
    if len(law.maps) > 1:
        axes.plot(pressures * factor, values.T, color=look["color"], linewidth=0.7, alpha=0.5)
    mean: Array = values.mean(axis=0)
    axes.plot(pressures * factor, mean, **look)
    return mean


def _draw_areas(axes: Axes, law: InterfaceLaw) -> None:
    _shade(axes.axvspan, law)
    _line(
        axes, law, LOADING, "contact_fraction", 100, color=style.SERIES[0], marker="o",
        label="contact",
    )  # fmt: skip
    if not law.is_elastic:
        _line(
            axes, law, LOADING, "saturated_fraction", 100, color=style.SATURATED, marker="s",
            label="saturated",
        )  # fmt: skip
    if UNLOADING in law.branches:
        _line(
            axes, law, UNLOADING, "contact_fraction", 100, color=style.ELASTIC, marker="o",
            label="contact, unloading",
        )  # fmt: skip
    style.log_scale(axes, "y")
    style.name_axes(axes, y="share of the area [%]", title="Contact and saturated area")


def _draw_stiffness(axes: Axes, law: InterfaceLaw) -> None:
    factor, _ = _pressure(law)
    _shade(axes.axvspan, law)
    scale, unit = 1e-15, "GPa/µm"
    _line(
        axes, law, LOADING, "stiffness", scale, color=style.SERIES[0], marker="o", label="loading"
    )
    if not law.is_elastic:
        _line(
            axes, law, LOADING, "unloading_stiffness", scale, color=style.SATURATED, marker="s",
            label="as the load begins to fall",
        )  # fmt: skip
    if UNLOADING in law.branches:
        _line(
            axes, law, UNLOADING, "unloading_stiffness", scale, color=style.ELASTIC, marker="o",
            label="unloading, loading again",
        )  # fmt: skip
    if np.isfinite(law.persson_length):
        line = law.pressures() / law.persson_length * scale
        axes.plot(law.pressures() * factor, line, "--", color=style.NEUTRAL, label="p̄/u₀, Persson")
    style.log_scale(axes, "y")
    style.name_axes(axes, y=f"stiffness per area [{unit}]", title="Stiffness")


def _draw_law_gap(axes: Axes, law: InterfaceLaw) -> None:
    factor, _ = _pressure(law)
    scale, unit = style.prefixed(max(abs(item.first_touch) for item in law.maps), "m")
    _shade(axes.axvspan, law)
    for branch in law.branches:
        own = {LOADING: "", UNLOADING: ", unloading"}[branch]
        pressures = law.pressures(branch) * factor
        for name, marker, label in (
            ("separation", "o-", "separation"),
            ("mean_gap", "s:", "mean gap"),
        ):
            values = law.values(branch, name).mean(axis=0) * scale
            axes.plot(
                pressures, values, marker, color=_COLOURS[branch], markersize=4, label=label + own
            )
        half = np.array([item.high - item.value for item in law.mean(branch, "separation")]) * scale
        if np.isfinite(half).all():
            mean = law.values(branch, "separation").mean(axis=0) * scale
            axes.fill_between(
                pressures, mean - half, mean + half, color=_COLOURS[branch], alpha=0.2, linewidth=0
            )
    style.name_axes(
        axes,
        y=f"separation, mean gap [{unit}]",
        title="Separation of the mean planes and mean open gap",
    )


# --- Tangential loading ---

# Colors of contact that sticks and that slips.
_STICK, _SLIP = style.ELASTIC, style.SATURATED


def tangential(result: Tangential) -> Figure:
    """Draw traction, stick and slip, and the force over the shift.

    Parameters
    ----------
    result : Tangential
        A tangentially loaded contact.

    Returns
    -------
    Figure
        Maps of the traction and of stick and slip, of a profile the traction and its bound along
        it; and force over shift: the steps, the curve of superposition, and its loop (Masing). A
        cell of several points shows the largest traction, and the shares that stick and slip.
    """
    pair = result.solution.pair
    aspect = 0.8 if pair.is_profile else style.shown_aspect(pair.size)
    panels = 2 if pair.is_profile else 3
    figure = style.blank(5.2 * panels, max(1.6 + 3.6 * aspect, 4.4))
    first, *middle, last = figure.subplots(1, panels)
    if pair.is_profile:
        _draw_profile(first, result)
    else:
        _draw_traction(first, result)
        _draw_stick(middle[0], result)
    _draw_curve(last, result)
    return figure


def _draw_traction(axes: Axes, result: Tangential) -> None:
    from matplotlib import colormaps

    size, shape = result.solution.pair.size, result.bound.shape
    blocks = style.cell_size(shape, size, style.CELLS_IN_PANEL)
    values = style.cell_max(np.hypot(*result.traction), blocks)
    factor, unit = style.prefixed(float(values.max()), "Pa")
    image = style.draw_map(axes, np.where(values > 0, values * factor, np.nan), size, blocks, shape)
    image.set_cmap(colormaps["viridis_r"].with_extremes(bad=style.OPEN))
    style.colour_bar(axes, image, f"traction [{unit}]", "neither")
    style.name_axes(axes, title="Tangential traction")


def _draw_stick(axes: Axes, result: Tangential) -> None:
    size, shape = result.solution.pair.size, result.bound.shape
    blocks = style.cell_size(shape, size, style.CELLS_IN_PANEL)
    slips = (result.bound > 0) & ~result.stick
    shares = [
        (_STICK, style.cell_share(result.stick, blocks)),
        (_SLIP, style.cell_share(slips, blocks)),
    ]
    style.draw_map(axes, style.mixed(shares, style.OPEN), size, blocks, shape)
    style.patch_legend(axes, [(_STICK, "stick"), (_SLIP, "slip"), (style.OPEN, "no contact")])
    style.name_axes(axes, title=f"{percent(result.last.stick_fraction)} of the contact sticks")


def _draw_profile(axes: Axes, result: Tangential) -> None:
    x = (np.arange(result.bound.size) + 0.5) * result.solution.pair.pixel[1]
    length, name = style.prefixed(float(x[-1]), "m")
    factor, unit = style.prefixed(float(result.bound.max()), "Pa")
    axes.plot(
        x * length, result.bound[0] * factor, ":", color=style.SERIES[1], label="largest traction"
    )
    axes.plot(x * length, result.traction[1, 0] * factor, color=style.SERIES[0], label="traction")
    style.plain_axes(axes, f"x [{name}]", f"traction [{unit}]", "Tangential traction")
    style.legend_below(axes)


def _draw_curve(axes: Axes, result: Tangential) -> None:
    shift = np.array([0.0, *result.column("shift")])
    force = np.array([0.0, *result.column("force")])
    length, name = style.prefixed(float(abs(shift).max()), "m")
    factor, unit = style.prefixed(float(abs(force).max()), result.solution.pair.load_unit)
    curve = result.superposition
    if curve is not None:
        points = np.array(curve.shift) * length, np.array(curve.force) * factor
        # As smooth as it is, through all points.
        through = np.polynomial.Polynomial.fit(*points, points[0].size - 1)
        along = np.linspace(0, points[0][-1], 50)
        up = through(along)
        sign = np.sign(result.last.force)
        axes.plot(sign * along, sign * up, color=style.SERIES[0], label="superposition")
        # Masing: the loop is the curve at twice its size, from either end.
        for end in (1, -1):
            label = "cycle" if end == 1 else None
            axes.plot(end * (along[-1] - 2 * along), end * (up[-1] - 2 * up), "--",
                      color=style.SERIES[2], label=label)  # fmt: skip
    axes.plot(shift * length, force * factor, "o", color=style.SERIES[1], label="solved")
    reach = 1.1 * float(abs(shift).max()) * length
    initial = np.array([0.0, abs(force).max()]) / (result.initial_stiffness or 1.0)
    axes.plot(np.sign(result.last.force) * initial * length,
              np.sign(result.last.force) * np.array([0.0, abs(force).max()]) * factor,
              ":", color=style.SERIES[6], label="full stick")  # fmt: skip
    axes.set_xlim(-reach, reach)
    style.plain_axes(axes, f"shift [{name}]", f"tangential force [{unit}]", "Force over shift")
    style.legend_below(axes, 2)


def fretting(result: Tangential) -> Figure:
    """Draw the tension at the surface, and Ruiz' parameter.

    Parameters
    ----------
    result : Tangential
        A tangentially loaded contact with its stress.

    Returns
    -------
    Figure
        Maps of both, of a profile lines. A cell of several points shows the largest value in it.

    Raises
    ------
    InputError
        If the result has no stress.
    """
    if result.fretting is None:
        raise InputError("the result has no stress: compute it with stress=True")
    pair, loaded = result.solution.pair, result.bound > 0
    tension = np.maximum(result.fretting.tension, 0)
    ruiz = np.where(loaded, result.fretting.ruiz, np.nan)
    panels = (
        ("Tension at the surface", tension, *style.prefixed(float(tension.max()), "Pa")),
        ("Ruiz' parameter", ruiz, 1e-9, "MPa²·mm"),
    )
    aspect = 0.8 if pair.is_profile else style.shown_aspect(pair.size)
    figure = style.blank(10.4, max(1.6 + 3.6 * aspect, 4.4))
    for axes, (title, field, factor, unit) in zip(figure.subplots(1, 2), panels, strict=True):
        if pair.is_profile:
            x = (np.arange(field.size) + 0.5) * pair.pixel[1]
            length, name = style.prefixed(float(x[-1]), "m")
            axes.plot(x * length, field[0] * factor, color=style.SERIES[0])
            style.plain_axes(axes, f"x [{name}]", f"[{unit}]", title)
            continue
        blocks = style.cell_size(field.shape, pair.size, style.CELLS_IN_PANEL)
        cells = style.cell_max(np.nan_to_num(field, nan=-1.0), blocks) * factor
        values = np.where(cells < 0, np.nan, cells)
        image = style.draw_map(axes, values, pair.size, blocks, field.shape)
        image.set_cmap(style.field_colours().with_extremes(bad=style.OPEN))
        style.colour_bar(axes, image, f"[{unit}]", "neither")
        style.name_axes(axes, title=title)
    return figure
