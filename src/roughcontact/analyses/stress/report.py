"""Report of the stress below a contact."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._tools.netcdf import Dataset
from roughcontact.analyses.stress.model import StressResult, to_dataset
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.pair import BODIES
from roughcontact.drawing import style
from roughcontact.drawing.sections import window
from roughcontact.errors import InputError, input_error
from roughcontact.halfspace.coating_stress import interfaces
from roughcontact.references import make_use
from roughcontact.report import chapters, phrases
from roughcontact.report.citations import Uses, stress_references
from roughcontact.report.figures import FRONT, RESULTS, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    CellTable,
    Quantity,
    Row,
    plain_value,
    profile_table,
    rows_of,
)
from roughcontact.report.page import HALF, MIDDLE, Block
from roughcontact.report.phrases import format_short
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_engineering, format_percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def _is_profile(stress: StressResult) -> bool:
    return stress.solution.pair.is_profile


def _place(stress: StressResult) -> str:
    depth, y, x = (format_engineering(length, "m") for length in stress.max_von_mises_at)
    return (
        f"{depth} deep, at x = {x}" if _is_profile(stress) else f"{depth} deep, at y, x = {y}, {x}"
    )


def _over_pressure(stress: StressResult) -> str:
    ratio = stress.max_von_mises / stress.solution.max_pressure
    return f"{format_engineering(stress.max_von_mises, 'Pa')} ({ratio:.4g} p_max)"


def _tension_place(stress: StressResult) -> str:
    y, x = (format_engineering(length, "m") for length in stress.max_tension_at)
    return f"at the surface, at y, x = {y}, {x}"


def _has_tension(stress: StressResult) -> bool:
    pulled = stress.friction or stress.traction is not None
    return bool(pulled) and stress.max_tension is not None


def _shear(axis: int) -> Callable[[StressResult], float]:
    return lambda stress: stress.profile.max_orthogonal_shear[axis]


def _by_part(stress: StressResult) -> str:
    return "; ".join(
        f"{part.name} {format_engineering(part.max_von_mises, 'Pa', 3)}, "
        f"{format_engineering(part.depth, 'm', 3)} deep"
        + ("" if part.strength is None else f" ({format_percent(part.use)} of its strength)")
        for part in stress.parts
    )


def _interface_stresses(stress: StressResult) -> str:
    names = [part.name for part in stress.parts]
    return "; ".join(
        f"{names[face.part]} at {format_engineering(face.depth, 'm', 3)}: tension "
        f"{format_engineering(face.tension.value, 'Pa', 3)}, shear "
        f"{format_engineering(face.shear.value, 'Pa', 3)}, pull "
        f"{format_engineering(max(face.pull.value, 0.0), 'Pa', 3)}"
        if face.depth
        else f"surface: tension {format_engineering(face.tension.value, 'Pa', 3)}"
        for face in stress.faces
    )


STRESS = (
    Quantity("body", "evaluated body", text=lambda stress: f"the {BODIES[stress.body]}"),
    Quantity(
        "friction",
        "friction $μ$: traction over pressure",
        when=lambda stress: bool(stress.friction),
    ),
    Quantity(
        "direction",
        "direction of friction [°]: from x, counter-clockwise",
        form=lambda v: f"{v:g}°",
        when=lambda stress: bool(stress.friction),
    ),
    Quantity("load", "[N]", of="solution.load"),
    Quantity("max_pressure", "[Pa]", of="solution.max_pressure"),
    Quantity("max_von_mises", "largest von Mises stress [Pa]", text=_over_pressure),
    Quantity("max_von_mises_place", "its place [m]", of="max_von_mises_at", text=_place),
    Quantity("parts", "by layer", text=_by_part),
    Quantity("faces", "at faces", text=_interface_stresses),
    Quantity(
        "overall",
        of=lambda s: s.overall and [s.overall.max_von_mises, s.overall.max_von_mises_at[0]],
    ),
    Quantity(
        "base",
        of=lambda s: (
            s.base
            and {
                "ceiling": s.base.solution.ceiling,
                "parts": plain_value(s.base.parts),
                "faces": plain_value(s.base.faces),
            }
        ),
    ),
    Quantity("max_tension", "largest tension [Pa]", when=_has_tension),
    Quantity(
        "max_tension_place",
        "its place [m]",
        of="max_tension_at",
        text=_tension_place,
        when=_has_tension,
    ),
    Quantity("max_tresca", "largest Tresca stress [Pa]", of="profile.max_tresca"),
    Quantity(
        "max_orthogonal_shear_along_y",
        "orthogonal shear amplitude, pass along y [Pa]",
        of=_shear(0),
    ),
    Quantity(
        "max_orthogonal_shear_along_x",
        "orthogonal shear amplitude, pass along x [Pa]",
        of=_shear(1),
    ),
    Quantity("yield_strength", "[Pa]", of="profile.yield_strength"),
    Quantity("yield_factor", "yield strength over largest stress", of="profile.yield_factor"),
    Quantity("yielded_volume", "volume above the yield strength [m³]", of="profile.yielded_volume"),
    Quantity(
        "depths", "[m]", of=lambda s: [float(s.profile.depths[0]), float(s.profile.depths[-1])]
    ),
    *CAUTIONS,
    Quantity("precision"),
    Quantity("version"),
)
"""Quantities of a `StressResult`."""


FIRST_YIELD = (
    Quantity("load", "load of first yield [N]", of="solution.load"),
    Quantity("max_pressure", "largest pressure at first yield [Pa]", of="solution.max_pressure"),
)
"""Quantities of the `StressResult` at first yield."""


PROFILE_STRESS = (
    *profile_table(
        STRESS,
        *("parts", "faces", "overall", "base"),
        *("max_tension_place", "max_orthogonal_shear_along_y"),
        max_von_mises_place={"of": lambda stress: list(stress.max_von_mises_at[::2])},
        max_orthogonal_shear_along_x={"label": "orthogonal shear amplitude in a pass [Pa]"},
    ),
    Quantity("kind", of=lambda _: "profile"),
)
"""Quantities of a `StressResult` of profiles."""


def subsurface_references(result: StressResult) -> Uses:
    """Yield the references of the stress, without those of the contact."""
    yield stress_references(result.solution.boundary)
    if result.friction or result.traction is not None:
        yield make_use("stress by friction", "Johnson1985", "Hamilton1983")


SECTION_ROWS = 400
"""Number of rows of a drawn section."""

# Share of the largest stress from which on stress is strong; width of a section over the connected
# strong part around the maximum; minimum width in pixels; share of the map from which on the whole
# map is drawn; minimum depth over width.
_STRONG = 0.25
_AROUND = 2.5
_MIN_PIXELS = 24
_MAX_MAP_SHARE = 0.5
_MIN_DEPTH_RATIO = 0.4


def stress_depth(result: StressResult) -> Figure:
    """Draw the largest stresses at each depth below a contact.

    Parameters
    ----------
    result : StressResult
        The stress below a contact.

    Returns
    -------
    Figure
        Largest von Mises and Tresca stress and amplitude of the orthogonal shear stress against
        the depth, with the yield strength if known. The depth axis is logarithmic, except at its
        beginning, if the largest stress is close to the surface.
    """
    profile = result.profile
    figure, axes = style.panels(7.2, 6.0)
    strength = profile.yield_strength or 0.0
    factor, unit = style.prefixed(max(profile.max_tresca, strength), "Pa")
    near = profile.depths.size > 2 and profile.depth_of_max < 0.05 * profile.depths[-1]
    # The unit of a logarithmic axis is that of its center.
    ends = (
        math.sqrt(float(profile.depths[profile.depths > 0][0] * profile.depths[-1])) if near else 0
    )
    length = style.prefixed(ends or float(profile.depths[-1]), "m")
    depths = profile.depths * length[0]
    for (values, name), colour, line in zip(
        (
            (profile.von_mises, "largest von Mises stress"),
            (profile.tresca, "largest Tresca stress"),
            (profile.orthogonal_shear.max(axis=1), "orthogonal shear amplitude in a pass"),
        ),
        style.SERIES,
        ("-", "--", ":"),
        strict=False,
    ):
        axes.plot(
            depths, values * factor, line, color=colour, linewidth=1.8, marker=".", label=name
        )
    for number, edge in enumerate(interfaces(result.material) if result.parts else ()):
        axes.axvline(float(edge) * length[0], color=style.NEUTRAL, linewidth=1)
        axes.annotate(
            result.parts[number].name,
            (float(edge) * length[0], 1),
            xytext=(-3, -3),
            xycoords=axes.get_xaxis_transform(),
            ha="right",
            va="top",
            rotation=90,
            **_LABEL,
        )
    if strength:
        _draw_yield_strength(axes, strength, (factor, unit))
    if near:
        first = 10.0 ** math.ceil(math.log10(float(depths[depths > 0][0])))
        axes.set_xscale("symlog", linthresh=first, linscale=0.5)
    axes.set_xlim(0, float(depths[-1]) or None)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.1)
    style.plain_axes(axes, f"depth [{length[1]}]", f"stress [{unit}]")
    style.legend_below(axes)
    style.name_axes(axes, title=_stress_title(result, (factor, unit), length))
    return figure


# Style of small labels at lines, with an offset in points.
_LABEL: dict[str, Any] = {
    "textcoords": "offset points",
    "fontsize": style.TICK,
    "color": style.NEUTRAL,
}


def _draw_yield_strength(axes: Axes, strength: float, scale: tuple[float, str]) -> None:
    """Draw the yield strength as a labeled line."""
    height = strength * scale[0]
    axes.axhline(height, color=style.NEUTRAL, linestyle=(0, (5, 3)), linewidth=1.5)
    axes.annotate(
        f"yield strength {style.in_unit(strength, scale, 'Pa')}",
        (1, height),
        xycoords=axes.get_yaxis_transform(),
        xytext=(-3, 3),
        ha="right",
        **_LABEL,
    )


def stress_section(
    result: StressResult, along: str = "x", depth: float | None = None, width: float | None = None
) -> Figure:
    """Draw the von Mises stress on a vertical plane through its maximum.

    Parameters
    ----------
    result : StressResult
        The stress below a contact.
    along : {"x", "y"}
        The horizontal axis of the plane.
    depth : float, optional
        Depth of the section [m]; by default down to a quarter of the largest stress, but at least
        two fifths of the width; limited by the depths of the result.
    width : float, optional
        Width of the section [m], around the maximum but within the map; by default two and a half
        times the connected part with at least a quarter of the largest stress, or the whole map
        if this is more than half of the map.

    Returns
    -------
    Figure
        The stress, true to scale, with a cross on its maximum. Stress above the yield strength is
        black.

    Raises
    ------
    InputError
        If ``along`` is unknown, depth or width is not positive, or there is only one depth.
    """
    values = result.von_mises_section(along)
    axis = 1 if along == "x" else 0
    edge = result.solution.surface.pixel[axis]
    columns = shown_columns(result, values, edge, width)
    values = values[:, columns]
    first, last = columns.start * edge, columns.stop * edge
    depth = shown_depth(result, values, depth, last - first)
    block = max(math.ceil(values.shape[1] / style.CELLS_ALONE), 1)
    rows = section_rows(
        style.reduce_cells(np.maximum, values, (1, block)), result.profile.depths, depth
    )
    across = np.append(np.arange(columns.start, columns.stop, block), columns.stop) * edge
    aspect = depth / (last - first)
    height = max(5.8 * min(aspect, 1.6), 0.4) + (3.0 if aspect <= style.MIN_LABEL_RATIO else 1.8)
    figure, axes = style.panels(7.2, height)
    top, scale = stress_scale(result)
    length = style.prefixed_window(first, last)
    mesh = _draw_section(axes, across * length[0], depth * length[0], rows * scale[0])
    mesh.set_clim(0, top * scale[0])
    place = result.max_von_mises_at[1 + axis] * length[0], result.max_von_mises_at[0] * length[0]
    axes.plot(
        [place[0]],
        [place[1]],
        "+",
        color=style.SERIES[0],
        markersize=11,
        markeredgewidth=2,
        clip_on=False,
    )
    style.name_axes(axes, f"{along} [{length[1]}]", f"depth [{length[1]}]")
    style.few_ticks(axes, aspect)
    _stress_bar(axes, mesh, result, scale[1])
    style.name_axes(axes, title=_stress_title(result, scale, length))
    return figure


def _draw_section(axes: Axes, across: Any, depth: float, rows: Any) -> Any:
    """Draw rows of stress down to a depth, true to scale; return the mesh."""
    mesh = axes.pcolormesh(
        across,
        np.linspace(0, depth, SECTION_ROWS + 1),
        rows,
        cmap=style.field_colours(over=style.OVER),
        rasterized=True,
    )
    axes.set_aspect("equal")
    axes.set_xlim(across[0], across[-1])
    axes.set_ylim(depth, 0)
    axes.tick_params(labelsize=style.TICK)
    return mesh


def shown_columns(result: StressResult, values: Any, edge: float, width: float | None) -> slice:
    """Return the drawn pixels of a section."""
    strongest = values.max(axis=0)
    middle, points = int(strongest.argmax()), values.shape[1]
    if width is None:
        weak = np.flatnonzero(strongest < _STRONG * strongest[middle])
        first = int(weak[weak < middle].max(initial=-1)) + 1
        last = int(weak[weak > middle].min(initial=points))
        middle = (first + last) // 2
        wide = max(math.ceil(_AROUND * (last - first)), _MIN_PIXELS)
        width = wide * edge if wide < _MAX_MAP_SHARE * points else math.inf
    elif not width > 0:
        raise input_error("width", width, "must be positive [m]")
    return slice(*window(middle, edge, points, width))


def shown_depth(result: StressResult, values: Any, depth: float | None, width: float) -> float:
    """Return the depth of a drawn section [m]; raise `InputError` if it is invalid."""
    depths = result.profile.depths
    if depths.size < 2:
        raise InputError("a section needs at least two depths, and the result has one")
    if depth is None:
        strong = int(np.flatnonzero(values.max(axis=1) >= _STRONG * values.max())[-1])
        weak = min(strong + 1, depths.size - 1)
        depth = max(float(depths[weak]), _MIN_DEPTH_RATIO * width)
    if not 0 < depth < math.inf:
        raise input_error("depth", depth, "must be positive and finite [m]")
    return min(depth, float(depths[-1]))


def section_rows(cells: Any, depths: Any, depth: float) -> Any:
    """Return the cells of a section, resampled to rows of equal height down to a depth [m]."""
    # Depths are graded: interpolate linearly.
    fine = depth / SECTION_ROWS * (np.arange(SECTION_ROWS) + 0.5)
    return np.array([np.interp(fine, depths, column) for column in cells.T]).T


def stress_map(result: StressResult) -> Figure:
    """Draw the largest von Mises stress below each point of the map.

    Parameters
    ----------
    result : StressResult
        The stress below a contact.

    Returns
    -------
    Figure
        Maximum over the depth, with a cross at its largest value. Stress above the yield strength
        is black.
    """
    peak, size = result.profile.peak, result.solution.surface.size
    strength = result.profile.yield_strength
    over = strength is not None and result.max_von_mises > strength
    figure, axes = style.single_axes(size, legend=over)
    blocks = style.cell_size(peak.shape, size, style.CELLS_ALONE)
    top, (factor, unit) = stress_scale(result)
    cells = style.cell_max(peak, blocks)
    image = style.draw_map(axes, cells * factor, size, blocks, peak.shape)
    image.set_cmap(style.field_colours(over=style.OVER))
    image.set_clim(0, top * factor)
    length = style.prefixed(max(size), "m")
    _, y, x = result.max_von_mises_at
    axes.plot(
        [x * length[0]],
        [y * length[0]],
        "+",
        color=style.SERIES[0],
        markersize=11,
        markeredgewidth=2,
    )
    _stress_bar(axes, image, result, unit)
    more = ""
    if over and strength is not None:
        share = format_percent(float(np.count_nonzero(peak > strength)) / peak.size)
        style.patch_legend(
            axes, [(style.OVER, f"yield strength exceeded below {share} of the map")]
        )
        black = float(style.cell_points(peak.shape, blocks)[cells > strength].sum()) / peak.size
        more = f"That makes {format_percent(black)} of the figure black."
    style.name_axes(axes, title=_stress_title(result, (factor, unit), length))
    style.cell_note(figure, blocks, "the largest stress in it", more)
    return figure


def _stress_title(result: StressResult, scale: tuple[float, str], length: tuple[float, str]) -> str:
    stress = style.in_unit(result.max_von_mises, scale, "Pa")
    depth = result.max_von_mises_at[0]
    where = f"at depth {style.in_unit(depth, length, 'm')}" if depth > 0 else "at the surface"
    which = "" if result.body == "body" else " in the counter-body"
    return (
        f"Von Mises stress{which} at {style.load_text(result.solution)}, largest\n"
        f"{stress} {where}{style.doubt_suffix(result.solution)}"
    )


def stress_scale(result: StressResult) -> tuple[float, tuple[float, str]]:
    """Return the end of the color scale [Pa], at most the yield strength, and its unit."""
    strength = result.profile.yield_strength
    top = result.max_von_mises if strength is None else min(result.max_von_mises, strength)
    return top or 1.0, style.prefixed(top, "Pa")


def _stress_bar(axes: Axes, image: Any, result: StressResult, unit: str) -> None:
    over = result.max_von_mises > stress_scale(result)[0]
    label = f"von Mises stress [{unit}]" + (", black: above yield" if over else "")
    style.colour_bar(axes, image, label, "max" if over else "neither")


FIGURES = (
    Illustration(
        "stress-depth",
        stress_depth,
        "Largest equivalent stresses at each depth. Look for the depth of the maximum.",
        RESULTS,
        HALF,
    ),
    Illustration(
        "stress-section",
        stress_section,
        "Von Mises stress on the plane along x through its maximum (cross), true to scale.",
        FRONT,
        MIDDLE,
    ),
    Illustration(
        "stress-map",
        stress_map,
        "Largest von Mises stress over all depths, seen from above. The cross marks the maximum.",
        RESULTS,
        HALF,
    ),
)
"""Figures of a `StressResult`."""


def _first_yield(onset: StressResult) -> list[Row]:
    """Return the rows on the contact at the load of first yield."""
    changes = {"load": {"label": "load of first yield per length [N/m]"}}
    of_profile = profile_table(FIRST_YIELD, **changes)
    return rows_of(of_profile if onset.solution.pair.is_profile else FIRST_YIELD, onset)


# Relative tolerance of the yield strength, as in `first_yield_load`.
_AT_YIELD = 1e-3


def _load(stress: StressResult) -> str:
    solution = stress.solution
    load = format_short(solution.load, solution.pair.load_unit)
    if has_nominal_body(solution.pair.origins):
        return load
    pressure = format_short(solution.load / solution.nominal_area, "Pa")
    return f"{load} ({pressure} nominal)"


def _answer(stress: StressResult) -> str:
    """Return largest stress, its depth, and whether the material yields, as a sentence."""
    if stress.overall is not None:
        there = format_short(stress.max_von_mises, "Pa")
        deep = format_short(stress.max_von_mises_at[0], "m")
        return f"{_answer(stress.overall)} At the given depths: {there}, {deep} deep."
    depth, other = stress.max_von_mises_at[0], stress.calibrated
    reached = phrases.with_range(
        stress.max_von_mises,
        None if other is None else other.max_von_mises,
        partial(format_short, unit="Pa"),
    )
    where = f"{format_short(depth, 'm')} deep" if depth else "at the surface"
    if stress.parts:
        under = (
            "" if stress.base is None else f" With the ceiling of the base: {_layered(stress.base)}"
        )
        return _layered(stress) + under
    strength = stress.material.yield_strength
    if strength is None:
        return f"The von Mises stress reaches {reached}, {where}."
    if math.isclose(stress.max_von_mises, strength, rel_tol=_AT_YIELD):
        return f"First yield at {_load(stress)}, {where}; σ_Y = {format_short(strength, 'Pa')}."
    known = f"{reached} (σ_Y = {format_short(strength, 'Pa')})".replace(") (", "; ")
    if stress.max_von_mises > strength:
        return f"The material yields: the von Mises stress reaches {known}, {where}."
    return f"Nothing yields: the von Mises stress reaches {known}, {where}."


def _layered(stress: StressResult) -> str:
    """Return the layer (or base) closest to its strength, as a sentence."""
    known = [part for part in stress.parts if part.strength]
    if not known:
        largest = max(stress.parts, key=lambda part: part.max_von_mises)
        reached = format_short(largest.max_von_mises, "Pa")
        return f"The von Mises stress reaches {reached}, in {largest.name}."
    first = max(known, key=lambda part: part.use)
    reached, strength = (
        format_short(value or 0.0, "Pa") for value in (first.max_von_mises, first.strength)
    )
    where = f"{format_short(first.depth, 'm')} deep" if first.depth else "at the surface"
    if first.of_hardness:
        strength += " (a third of its hardness)"
    if first.use > 1:
        return f"{first.name} yields first: {reached} of {strength}, {where}."
    return f"Nothing yields; nearest is {first.name}: {reached} of {strength}, {where}."


def _layer_rows(stress: StressResult) -> list[tuple[str, str]]:
    """Return the largest stress of each layer, and the tractions of its interfaces."""
    rows = []
    for part in stress.parts:
        reached, depth = (format_short(part.max_von_mises, "Pa"), format_short(part.depth, "m"))
        rows.append((part.name, f"von Mises {reached}, {depth} deep"))
    surface, *others = stress.faces
    rows.append(("Tension at surface", format_short(surface.tension.value, "Pa")))
    for face in others[::2]:
        name = stress.parts[face.part].name
        rows.append(
            (
                f"Bottom of {name}",
                f"tension {format_short(face.tension.value, 'Pa')}, shear "
                f"{format_short(face.shear.value, 'Pa')}, pull "
                f"{format_short(max(face.pull.value, 0.0), 'Pa')}",
            )
        )
    return rows


class StressPresentation(Presentation):
    """Presentation of the stress below a contact."""

    result: StressResult
    table = STRESS
    figures = FIGURES
    plots = (stress_section, stress_depth, stress_map)
    profile_table = PROFILE_STRESS
    # A profile has no map.
    profile_figures = figures[:2]
    profile_plots = plots[:2]
    contact_name = "solution"

    def answer(self) -> str:
        """Return largest stress, its depth, and whether the material yields, as a sentence."""
        return _answer(self.result)

    def question(self) -> str:
        """Return the question that a stress answers."""
        contact = self.result.solution
        name = phrases.source(contact.surface.provenance)
        return f"How large is the stress below {name} {phrases.load_phrase(contact)}?"

    def numbers(self) -> CellTable:
        """Return largest stress, its position, load of first yield and orthogonal shear."""
        stress = self.result
        if stress.base is not None:
            columns = zip(_layer_rows(stress), _layer_rows(stress.base), strict=True)
            heads = ("", "ceiling of the coating", "ceiling of the base")
            return heads, [(*first, second[1]) for first, second in columns]
        if stress.parts:
            return (), _layer_rows(stress)
        rows = [
            ("Maximum von Mises", self.row("max_von_mises").text),
            ("At", self.row("max_von_mises_place").text),
        ]
        if self.onset is not None:
            rows.append(("Yields from", _load(self.onset)))
        if not stress.solution.pair.is_profile:
            shear = (
                f"±{format_short(amplitude, 'Pa')} {axis}"
                for axis, amplitude in zip("yx", stress.profile.max_orthogonal_shear, strict=True)
            )
            rows.append(("Orthogonal shear", ", ".join(shear)))
        return (), rows

    def remarks(self) -> Iterator[str]:
        """Yield the accuracy of the contact."""
        yield phrases.status(self.result.solution)

    def details(self) -> list[Block]:
        """Return further blocks of results."""
        return [] if self.onset is None else chapters.quantities(_first_yield(self.onset))

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the method."""
        yield "Elastic stress below the contact pressure. Tension is positive."

    def works(self) -> Uses:
        """Yield the works on the stress."""
        return subsurface_references(self.result)

    def dataset(self) -> Dataset:
        """Return the stress maps."""
        return to_dataset(self.result)
