"""Maps of a contact reduced to screen resolution, as compact arrays.

A screen has fewer dots than a map has points. A cell of several points shows the mean of their
heights, the largest of their pressures and of their residual indentations, and the shares of their
contact classes, as in the figures of a report (`roughcontact.drawing.maps`): the image keeps the
contact area. A window with fewer points than dots shows each point.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import roughcontact as rc
from roughcontact.drawing import maps as drawing_maps, style as drawing_style

CLEAR = "#00000000"
"""Color of values that no point has: the ground of the page."""

Array = NDArray[np.float64]
Pixel = tuple[float, float]
Mask = NDArray[np.bool_]
Values = NDArray[np.float32]
Colours = NDArray[np.uint32]


class Box(NamedTuple):
    """Rectangle on a map: its edges from the corner of row 0 and column 0 [m]."""

    top: float
    left: float
    bottom: float
    right: float


class Window(NamedTuple):
    """Part of a map, and the number of points (y, x) per cell of its image."""

    rows: tuple[int, int]
    columns: tuple[int, int]
    blocks: tuple[int, int]

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along y and x."""
        rows, columns = (
            math.ceil((last - first) / block)
            for (first, last), block in zip(self[:2], self.blocks, strict=True)
        )
        return rows, columns

    @property
    def part(self) -> tuple[slice, slice]:
        """Slices of the points of the map in the window."""
        return slice(*self.rows), slice(*self.columns)


def box_of(surface: rc.Surface) -> Box:
    """Return the box of a whole map."""
    return Box(0.0, 0.0, *surface.size)


def window_of(
    shape: tuple[int, int], pixel: Pixel, seen: Box, dots: tuple[float, float], margin: float = 0.0
) -> Window:
    """Return the window of a visible box of a map, with a margin, for a number of dots."""
    sides = zip(shape, pixel, dots, (seen.top, seen.left), (seen.bottom, seen.right), strict=True)
    spans, blocks = [], []
    for points, edge, dot, begin, end in sides:
        begin, end = sorted((begin / edge, end / edge))
        block = max(math.ceil((end - begin) / max(dot, 1.0) - 1e-9), 1)
        beyond = margin * (end - begin)
        first = min(max(math.floor(begin - beyond + 1e-9), 0), points - 1) // block * block
        last = min(max(math.ceil(end + beyond - 1e-9), first + 1), points)
        last = min(first + math.ceil((last - first) / block) * block, points)
        spans.append((first, last))
        blocks.append(block)
    return Window(spans[0], spans[1], (blocks[0], blocks[1]))


def whole_window(shape: tuple[int, int], dots: int) -> Window:
    """Return the window of a whole map, with at most ``dots`` cells per side."""
    block = math.ceil(max(shape) / dots)
    return Window((0, shape[0]), (0, shape[1]), (block, block))


def window_extent(view: Window, pixel: Pixel) -> Box:
    """Return the extent of the cells of a window [m]; the last may exceed the map."""
    (top, bottom), (left, right) = (
        (first * edge, (first + cells * block) * edge)
        for (first, _), cells, block, edge in zip(
            view[:2], view.shape, view.blocks, pixel, strict=True
        )
    )
    return Box(top, left, bottom, right)


def mean_heights(surface: rc.Surface, view: Window, mean: float) -> Values:
    """Return the mean height of each cell above a mean [m]; NaN if half is missing."""
    heights = drawing_style.cell_mean(surface.heights[view.part], view.blocks)
    return (heights - mean).astype(np.float32)


class ResultWindow(NamedTuple):
    """Fields of a result at the points of a window."""

    pressure: Array
    gap: Array
    touching: Mask
    saturated: Mask
    view: Window
    shares: drawing_maps.Shares

    @property
    def blocks(self) -> tuple[int, int]:
        """Number of points (y, x) per cell."""
        return self.view.blocks


def result_window(result: rc.ContactResult, view: Window) -> ResultWindow:
    """Return the fields of a result in a window."""
    pressure, saturated = result.pressure[view.part], saturated_at(result, view.part)
    touching, gap = pressure > 0, result.gap[view.part]
    shares = drawing_maps.cell_shares(touching, saturated, gap, view.blocks)
    return ResultWindow(pressure, gap, touching, saturated, view, shares)


def saturated_at(result: rc.ContactResult, where: Any) -> Mask:
    """Return which points of a part of a map are at the ceiling; the part is an index."""
    ceiling = math.inf if result.ceiling is None else result.ceiling
    return result.pressure[where] >= np.broadcast_to(ceiling, result.pressure.shape)[where]


def is_drawn_alike(result: rc.ContactResult | None, other: rc.ContactResult | None) -> bool:
    """Return whether two results have the same maps, such as before calibration."""
    if result is None or other is None:
        return result is other
    return result.pressure is other.pressure


def largest_pressure(part: ResultWindow) -> Values:
    """Return the largest pressure of each cell [Pa]; NaN without contact."""
    largest = drawing_style.cell_max(part.pressure, part.blocks)
    return np.where(largest > 0, largest, np.nan).astype(np.float32)


def contact_colors(part: ResultWindow) -> Colours:
    """Return the colors of elastic, saturated and missing points; open points are clear.

    Over the ground of figures, `OPEN`, they are the colors of figures.
    """
    from matplotlib.colors import to_rgb

    ground = np.array(to_rgb(drawing_style.OPEN))

    def mix_classes(shares: drawing_maps.Shares) -> Array:
        covered = np.minimum(shares.touching + shares.missing, 1.0)[..., None]
        over = (drawing_maps.class_colors(shares) - ground) / covered
        return np.clip(np.dstack([ground + over, covered]), 0.0, 1.0)

    return _pack_covered(part, drawing_style.OPEN, mix_classes)


def _pack_covered(
    part: ResultWindow, ground: str, mix: Callable[[drawing_maps.Shares], Array]
) -> Colours:
    """Return the colors of closed and missing cells, few of all; the others are clear."""
    from matplotlib.colors import to_rgba

    covered = part.shares.touching + part.shares.missing > 0
    result = np.full(covered.shape, pack_colors(np.array([[to_rgba(ground, 0.0)]]))[0, 0])
    shares = drawing_maps.Shares(*(share[covered][None] for share in part.shares))
    result[covered] = pack_colors(mix(shares))[0]
    return result


def contact_shares(part: ResultWindow) -> list[NDArray[Any]]:
    """Return the shares of points in contact, saturated and missing of each cell."""
    shares = part.shares
    # A cell of one point is of one class: a byte is enough.
    kind = np.uint8 if part.blocks == (1, 1) else np.float32
    return [share.astype(kind) for share in (shares.touching, shares.saturated, shares.missing)]


def mean_gap(part: ResultWindow) -> Values:
    """Return the mean gap of the open points of each cell [m]; NaN if none is open."""
    return drawing_maps.open_gap(part.touching, part.gap, part.blocks).astype(np.float32)


def closed_colors(part: ResultWindow) -> Colours:
    """Return the colors of closed and missing points, with their share as opacity."""
    mix = partial(drawing_maps.closed_cover, colour=drawing_style.CLOSED)
    return _pack_covered(part, drawing_style.CLOSED, mix)


def deepest_residual(part: ResultWindow) -> Values:
    """Return the deepest residual indentation of each cell [m]; NaN if there is none."""
    indentation = np.where(part.saturated, np.maximum(-part.gap, 0), 0.0)
    deepest = drawing_style.cell_max(indentation, part.blocks)
    return np.where(deepest > 0, deepest, np.nan).astype(np.float32)


def pack_colors(colours: Array) -> Colours:
    """Return colors with components from 0 to 1 as integers, red in the lowest byte."""
    result = np.full((*colours.shape[:2], 4), 255, np.uint8)
    result[..., : colours.shape[2]] = np.rint(colours * 255)
    return result.view(np.dtype("<u4"))[..., 0]


# Thumbnails: the same cells, reduced to small images


_SIDE = 160
"""Maximum length of the longer side of a thumbnail [dots]."""


def map_colors(values: Values, mapper: Any) -> Colours:
    """Return the colors of values under a color mapper of Bokeh."""
    colors = [*mapper.palette, mapper.high_color or mapper.palette[-1], mapper.nan_color]
    bytes_of = np.array([int(f"{color[1:]:f<8}", 16) for color in colors], ">u4")[None, :, None]
    table = pack_colors(bytes_of.view(np.uint8) / 255)[0]
    levels = len(mapper.palette)
    with np.errstate(invalid="ignore"):
        steps = (values - np.float32(mapper.low)) * np.float32(levels / (mapper.high - mapper.low))
    # The largest value has the last color.
    steps = np.where(values == np.float32(mapper.high), levels - 1, np.clip(steps, 0, levels))
    index = np.where(np.isnan(steps), levels + 1, steps).astype(np.intp)
    return table[index]


def thumbnail(colours: Colours, sides: tuple[float, float], cover: Colours | None = None) -> str:
    """Return colors, with an optional cover, as a small image with the sides (y, x) of a map."""
    from PIL import Image

    layers = (np.ascontiguousarray(layer) for layer in (colours, cover) if layer is not None)
    ground, *more = (
        Image.fromarray(layer.view(np.uint8).reshape(*layer.shape, 4), "RGBA") for layer in layers
    )
    for layer in more:
        ground = Image.alpha_composite(ground, layer)
    longer = min(_SIDE, max(ground.size))
    height, width = (max(round(longer * side / max(sides)), 1) for side in sides)
    small = ground.resize((width, height), Image.Resampling.BOX)
    stream = io.BytesIO()
    small.save(stream, "png", compress_level=1)
    return f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode('ascii')}"
