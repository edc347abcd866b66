"""Lists of points x, y, z that lie on a grid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roughcontact import limits
from roughcontact.errors import FormatError

Array = NDArray[np.float64]

# Part of a step by which coordinates may lie off the grid, by the digits that they are written in.
_OFF = 0.05
# Points of the grid for each point of the list, at most: more are missing than measured.
_SPARSE = 4
# Bytes that laying them on the grid takes a point.
_EACH = 40


def look_like_points(matrix: Array) -> bool:
    """Return whether three columns are coordinates and heights rather than a narrow map."""
    if matrix.shape[1] != 3 or matrix.shape[0] < 9:
        return False
    x, y = matrix[:, 0], matrix[:, 1]
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return False
    counts = [np.unique(values).size for values in (x, y)]
    pairs = np.unique(matrix[:, :2], axis=0).shape[0]
    # Heights of a narrow map do not come back again and again, each with each other.
    return min(counts) > 1 and pairs == matrix.shape[0] <= counts[0] * counts[1] <= 2 * pairs


def gridded(path: Path, matrix: Array) -> tuple[Array, tuple[float, float], int]:
    """Return the heights of points on their grid.

    Parameters
    ----------
    path : Path
        The file, for messages.
    matrix : ndarray, shape (n, 3)
        x, y and height of every point, in any order.

    Returns
    -------
    heights : ndarray, shape (ny, nx)
        NaN where the list has no point; y rises with the rows.
    pixel : (float, float)
        Steps ``(dy, dx)`` in the unit of the coordinates.
    absent : int
        Points of the grid that are not in the list.

    Raises
    ------
    FormatError
        If they lie on no grid with even steps, or one twice.
    """
    if not np.isfinite(matrix[:, :2]).all():
        raise FormatError(f"{path.name} lists points whose x or y is missing; export it again")
    (columns, dx), (rows, dy) = (_steps(path, axis, matrix[:, i]) for i, axis in enumerate("xy"))
    shape = int(rows.max()) + 1, int(columns.max()) + 1
    if shape[0] * shape[1] > _SPARSE * matrix.shape[0] or min(shape) < 2:
        raise FormatError(
            f"{path.name} lists {matrix.shape[0]} points x, y, z that fill no grid (steps of "
            f"{dy:.6g} and {dx:.6g} would make {shape[0]} × {shape[1]}); interpolate them to a "
            "grid first"
        )
    limits.require_points(path.name, shape, _EACH)
    place = rows * shape[1] + columns
    counted = np.bincount(place, minlength=shape[0] * shape[1])
    if counted.max() > 1:
        raise FormatError(
            f"{path.name} lists {int((counted > 1).sum())} points of its grid more than once; "
            "export it again"
        )
    heights = np.full(shape, np.nan)
    heights.reshape(-1)[place] = matrix[:, 2]
    return heights, (dy, dx), int((counted == 0).sum())


def _steps(path: Path, axis: str, values: Array) -> tuple[NDArray[np.int64], float]:
    """Return which step of a grid each coordinate is at, and the length of a step."""
    known = np.unique(values)
    extent = float(known[-1] - known[0])
    gaps = np.diff(known)
    # Digits are cut off: what lies a millionth of the map apart is one place.
    apart = gaps[gaps > 1e-6 * extent]
    if apart.size == 0:
        raise FormatError(f"{path.name} lists points that all have one {axis}; a map was expected")
    step = extent / max(round(extent / float(apart.min())), 1)
    # The least gap has the largest error of digits: the mean over those alike is better.
    alike = apart[apart < 1.5 * step]
    step = extent / max(round(extent / float(alike.mean())), 1)
    place = (values - known[0]) / step
    nearest = np.rint(place)
    if np.abs(place - nearest).max() > _OFF:
        raise FormatError(
            f"{path.name} lists points x, y, z whose {axis} is not evenly spaced; interpolate them "
            "to a grid first"
        )
    return nearest.astype(np.int64), step
