"""A map cut into equal parts, each leveled as a map of its own."""

from __future__ import annotations

import numpy as np

from roughcontact.arguments import checked
from roughcontact.errors import InputError
from roughcontact.surface.surface import Surface

LEAST_POINTS = 16
"""Points along the shorter side of a part, below which a part says little about a surface."""


@checked
def partition(surface: Surface, divisions: int = 2, level: str = "plane") -> tuple[Surface, ...]:
    """Return the equal parts of a map: of two divisions its quarters.

    Parameters
    ----------
    surface : Surface
        The map.
    divisions : int
        Parts along each side; points that are left over at the far edges belong to none.
    level : {"plane", "quadric", "mean", "robust", "none"}
        What is fitted to each part and subtracted, as from a map of that size.

    Returns
    -------
    tuple of Surface
        Row by row. Holes that were accepted stay so; a part that is half holes is left out.

    Raises
    ------
    InputError
        If the parts had fewer than 16 points along a side.

    Examples
    --------
    >>> import numpy as np
    >>> quarters = partition(Surface(np.eye(32), (1e-6, 1e-6)))
    >>> len(quarters), quarters[0].shape
    (4, (16, 16))
    """
    if divisions < 1 or not divides(surface.shape, divisions):
        ny, nx = surface.shape
        raise InputError(
            f"must leave {LEAST_POINTS} points along each side of a part; the map has {ny} × {nx} "
            f"points, got {divisions}",
            argument="divisions",
            value=divisions,
        )
    rows, columns = (points // divisions for points in surface.shape)
    found = []
    for i in range(divisions):
        for j in range(divisions):
            window = (i * rows, (i + 1) * rows), (j * columns, (j + 1) * columns)
            part = _part(surface, *window, level)
            if part is not None:
                found.append(part)
    return tuple(found)


def divides(shape: tuple[int, int], divisions: int) -> bool:
    """Return whether parts of a grid would have points enough."""
    return min(shape) // divisions >= LEAST_POINTS


def _part(
    surface: Surface, rows: tuple[int, int], columns: tuple[int, int], level: str
) -> Surface | None:
    """Return a window of a map; nothing where half of it or more is missing."""
    heights = surface.heights[slice(*rows), slice(*columns)]
    if 2 * np.count_nonzero(np.isnan(heights)) >= heights.size:
        return None
    part = surface.cropped(rows, columns)
    return part if level == "none" else part.leveled(level)
