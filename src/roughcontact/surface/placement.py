"""Parts of a map, registration of two maps on one grid, and shifted surfaces.

`match_grids`: The grid is the grid of the first map, which then keeps its bits, unless the pixel of
the second is smaller by more than √2 along an axis: then the finer edge is used. The finest waves
of either body carry the highest pressures, and a grid that cannot resolve them would make the
contact too large; a coarse map on a fine grid is only interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array, Shape
from roughcontact.errors import InputError
from roughcontact.surface import alignment, nominal_bodies
from roughcontact.surface.nominal_bodies import flat
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import format_lengths

MIN_POINTS = 16
"""Minimum number of points along the shorter side of a part."""


@validate_arguments
def partition(surface: Surface, divisions: int = 2, level: str = "plane") -> tuple[Surface, ...]:
    """Return equal parts of a map, its quarters by default.

    Parameters
    ----------
    surface : Surface
        The map.
    divisions : int
        Parts along each side; remaining points at the far edges are left out.
    level : {"plane", "quadric", "mean", "robust", "none"}
        Form that is fitted to each part and subtracted, as from a map of that size.

    Returns
    -------
    tuple of Surface
        Row by row. Masked points stay masked; a part with half of its points missing is left out.

    Raises
    ------
    InputError
        If the parts would have fewer than 16 points along a side.

    Examples
    --------
    >>> import numpy as np
    >>> quarters = partition(Surface(np.eye(32), (1e-6, 1e-6)))
    >>> len(quarters), quarters[0].shape
    (4, (16, 16))
    """
    if divisions < 1 or not is_divisible(surface.shape, divisions):
        ny, nx = surface.shape
        raise InputError(
            f"must leave {MIN_POINTS} points along each side of a part; the map has {ny} × {nx} "
            f"points, got {divisions}",
            argument="divisions",
            value=divisions,
        )
    rows, columns = (points // divisions for points in surface.shape)
    result = []
    for i in range(divisions):
        for j in range(divisions):
            window = (i * rows, (i + 1) * rows), (j * columns, (j + 1) * columns)
            part = _part(surface, *window, level)
            if part is not None:
                result.append(part)
    return tuple(result)


def is_divisible(shape: Shape, divisions: int) -> bool:
    """Return whether the parts of a grid would have enough points."""
    return min(shape) // divisions >= MIN_POINTS


def _part(
    surface: Surface, rows: tuple[int, int], columns: tuple[int, int], level: str
) -> Surface | None:
    """Return a window of a map; None if half of it or more is missing."""
    heights = surface.heights[slice(*rows), slice(*columns)]
    if 2 * np.count_nonzero(np.isnan(heights)) >= heights.size:
        return None
    part = surface.cropped(rows, columns)
    return part if level == "none" else part.leveled(level)


def match_grids(
    first: Surface,
    second: Surface,
    offset: tuple[float, float] = (0.0, 0.0),
    angle: float = 0.0,
    mirrored: bool = False,
) -> tuple[Surface, Surface]:
    """Return two maps on one grid, cropped to the rectangle that both cover."""
    for name, body in (("first", first), ("second", second)):
        if not isinstance(body, Surface):
            raise InputError(f"must be a Surface, got {type(body).__name__}", argument=name)
    pixel = alignment.common_pixel(first.pixel, second.pixel, angle)
    # Number of points between the centers of the outer pixels of the first map, around its center.
    ny, nx = (
        points if edge == own else int((points - 1) * own / edge) + 1
        for points, own, edge in zip(first.shape, first.pixel, pixel, strict=True)
    )
    shape = ny, nx
    motion: tuple[Any, ...] = (offset, angle, mirrored)
    maps = [
        (body.shape, alignment.grid_positions(body.shape, body.pixel, shape, pixel, *moved))
        for body, moved in ((first, ()), (second, motion))
    ]
    rows, columns = alignment.common_rectangle(maps, shape)
    # Shift from the center of the rectangle to that of the whole grid.
    back_y, back_x = (
        ((points - 1) / 2 - (stop + start - 1) / 2) * edge
        for points, (start, stop), edge in zip(shape, (rows, columns), pixel, strict=True)
    )
    grid = flat(shape=(rows[1] - rows[0], columns[1] - columns[0]), pixel=pixel)
    return (
        first.aligned(grid, (back_y, back_x)),
        second.aligned(grid, (back_y + offset[0], back_x + offset[1]), angle, mirrored),
    )


def drawn_pairs(
    maps: Sequence[Surface], counter_maps: Sequence[Surface], count: int, seed: int = 0
) -> list[tuple[Surface, Surface]]:
    """Return random pairs of faces: the second mirrored, rotated by quarters and shifted.

    Maps that are not square are rotated by half turns. Pairs of maps are used cyclically; of those
    with other pixels, one is resampled.
    """
    rng = np.random.default_rng(seed)
    pairs = []
    for number in range(count):
        surface = maps[number % len(maps)]
        counter = counter_maps[number // len(maps) % len(counter_maps)]
        if not np.allclose(surface.pixel, counter.pixel, rtol=1e-9, atol=0):
            surface, counter = match_grids(surface, counter)
        ny, nx = (min(ends) for ends in zip(surface.shape, counter.shape, strict=True))
        first, second = (
            item if item.shape == (ny, nx) else item.cropped((0, ny), (0, nx))
            for item in (surface, counter)
        )
        is_square = ny == nx and math.isclose(*second.pixel)
        turn = int(rng.integers(4)) * 90 if is_square else int(rng.integers(2)) * 180
        rows, columns = int(rng.integers(ny)), int(rng.integers(nx))
        way = rows * second.pixel[0], columns * second.pixel[1]
        over = second.aligned(second, mirrored=True).rotated(turn)
        pairs.append((first, shift_surface(over, way, (0, 1))))
    return pairs


# Fraction of a pixel within which a shift is treated as a whole number of pixels.
_WHOLE = 1e-6


def shift_surface(
    surface: Surface, way: tuple[float, float], periodic_axes: tuple[int, ...] = ()
) -> Surface:
    """Return a surface moved over its grid."""
    pixels = [part / edge for part, edge in zip(way, surface.pixel, strict=True)]
    whole = [round(part) for part in pixels]
    rest = [
        part - n if abs(part - n) > _WHOLE else 0.0 for part, n in zip(pixels, whole, strict=True)
    ]
    if _is_nominal(surface):
        for axis in {0, 1} - set(periodic_axes):
            whole[axis], rest[axis] = 0, pixels[axis]
    heights = _shift_fraction(surface, rest, periodic_axes) if any(rest) else surface.heights
    for axis, count in enumerate(whole):
        heights = _roll_rows(heights, count, axis, periodic=axis in periodic_axes)
    step = f"moved by {format_lengths(way)} along y and x"
    about = Provenance(surface.provenance.source, steps=(*surface.provenance.steps, step))
    masked = surface.holes_masked or bool(np.isnan(heights).any() and not surface.missing)
    return Surface(heights, surface.pixel, about, holes_masked=masked)


def _is_nominal(surface: Surface) -> bool:
    """Return whether a surface is a nominal form, which can be sampled at another place."""
    created = surface.provenance.origin
    nominally = created is not None and created.method.startswith("nominal.")
    return nominally and not surface.provenance.operations


def _shift_fraction(surface: Surface, rest: list[float], periodic_axes: tuple[int, ...]) -> Array:
    """Return heights moved by fractions of a pixel, or a nominal body sampled again."""
    created = surface.provenance.origin
    if created is not None and _is_nominal(surface):
        again: dict[str, Any] = dict(created.arguments)
        middle = [(n - 1) / 2 for n in surface.shape]
        center = again.pop("center", None) or middle
        again["center"] = tuple(c + part for c, part in zip(center, rest, strict=True))
        body = getattr(nominal_bodies, created.method.removeprefix("nominal."))
        return body(**again).heights
    if surface.missing:
        raise InputError(
            f"has {surface.missing} missing points, between which nothing can be interpolated: "
            "fill them, or move by whole pixels",
            argument="surface",
        )
    from scipy import ndimage

    heights = surface.heights
    for axis, part in enumerate(rest):
        if not part:
            continue
        periodic = axis in periodic_axes
        way = (part, 0.0) if axis == 0 else (0.0, part)
        mode: Literal["grid-wrap", "reflect"] = "grid-wrap" if periodic else "reflect"
        heights = ndimage.shift(heights, way, order=3, mode=mode)
        if not periodic:
            # Mirrored values beyond an edge are not measured, and become NaN.
            edge = [slice(None)] * 2
            edge[axis] = slice(0, 1) if part > 0 else slice(-1, None)
            heights[tuple(edge)] = math.nan
    return heights


def _roll_rows(heights: Array, count: int, axis: int, *, periodic: bool) -> Array:
    """Return heights moved along an axis by whole pixels."""
    moved: Array = np.roll(heights, count, axis)
    if not periodic and count:
        outside = [slice(None)] * 2
        outside[axis] = slice(0, count) if count > 0 else slice(count, None)
        moved[tuple(outside)] = math.nan
    return moved
