"""Validation of heights and pixel edges, blocks of rows and memory of a map."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, InputError, input_error
from roughcontact.units import to_si

VALUES = 2**20
"""Values per block: temporaries of 8 MiB, independent of the size of the map."""


def row_blocks(shape: tuple[int, ...], values: int = 1) -> Iterator[slice]:
    """Yield the rows of a map in blocks."""
    step = max(1, VALUES // max(1, shape[1] * values))
    for start in range(0, shape[0], step):
        yield slice(start, min(start + step, shape[0]))


PROFILE_WIDTH = 1.0
"""Width of the pixels of a profile [m]: its loads and areas are per meter."""


def check_grid(heights: ArrayLike, pixel: Any) -> tuple[NDArray[np.float64], tuple[float, float]]:
    """Return checked heights and pixel edges in the form that a map stores."""
    array = _real(heights)
    if array.ndim == 1:
        array, edges = array[None], (PROFILE_WIDTH, _spacing(pixel))
    else:
        edges = _edges(pixel)
    _require_grid(array, edges)
    copy = _lock(array)
    infinite = int(np.count_nonzero(np.isinf(copy)))
    if infinite:
        raise InputError(
            f"has {infinite} infinite values; mark missing points as NaN instead",
            argument="heights",
        )
    if np.isnan(copy).all():
        raise InputError("has no finite value: every point is missing", argument="heights")
    return copy, edges


FILL = "surface.filled()"
"""Call that fills missing points; commands name their option instead."""


def require_complete(heights: ArrayLike) -> None:
    """Raise `InputError` for a map with missing points."""
    missing = int(np.count_nonzero(np.isnan(heights)))
    if missing:
        raise InputError(
            f"has {missing} missing points; fill or crop them first: {ArgumentRef(FILL)}",
            argument="heights",
        )


def _real(heights: ArrayLike) -> NDArray[Any]:
    if isinstance(heights, np.ma.MaskedArray):
        heights = np.ma.filled(heights.astype(np.float64), np.nan)
    try:
        array = np.asarray(heights)
    except ValueError:
        raise InputError(
            "must be a 2-D array [y, x], got rows of unequal length", argument="heights"
        ) from None
    if array.dtype.kind not in "fiu":
        raise InputError(
            f"must be real numbers in meters, got dtype {array.dtype}", argument="heights"
        )
    return array


def _require_grid(array: NDArray[Any], edges: tuple[float, float]) -> None:
    if array.ndim != 2 or min(array.shape) < 2:
        if array.ndim == 2 and array.shape[0] == 1 and array.shape[1] > 1:
            if edges[0] == PROFILE_WIDTH:
                return
            raise InputError(
                f"of one row are a profile: give the {array.shape[1]} heights as a 1-D array, and "
                "the distance of its points as pixel",
                argument="heights",
            )
        raise InputError(
            "must be a 2-D array [y, x] of at least 2 × 2 points, or a 1-D array of at least 2 of "
            f"a profile, got shape {array.shape}",
            argument="heights",
        )


def _lock(array: NDArray[Any]) -> NDArray[np.float64]:
    # A locked array that owns its data is not copied, as maps may have gigabytes.
    if (
        array.dtype == np.float64
        and array.flags.c_contiguous
        and array.flags.owndata
        and not array.flags.writeable
    ):
        return array
    require_memory((array.shape[0], array.shape[1]), COPIED)
    copy = np.array(array, dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def _edges(pixel: Any) -> tuple[float, float]:
    try:
        dy, dx = (float(edge) for edge in to_si(pixel, "length", "pixel"))
    except (TypeError, ValueError):
        raise input_error("pixel", pixel, "must be a pair (dy, dx) in meters") from None
    if not (0 < dy < np.inf and 0 < dx < np.inf):
        raise input_error("pixel", pixel, "must be positive and finite (dy, dx) [m]")
    return dy, dx


def _spacing(pixel: Any) -> float:
    try:
        spacing = float(to_si(pixel, "length", "pixel"))
    except (TypeError, ValueError):
        raise input_error(
            "pixel", pixel, "of a profile must be the one distance of its points in meters"
        ) from None
    if not 0 < spacing < np.inf:
        raise input_error("pixel", pixel, "must be positive and finite [m]")
    return spacing


SAMPLED_ARRAYS = 7
"""Number of maps held at once while a form is sampled on a grid."""

GENERATED_ARRAYS = 3
"""The same while a random surface is generated."""

TRANSLATED_ARRAYS = 17
"""The same while a map is translated to a distribution of heights and a spectrum."""

RESAMPLED_ARRAYS = 6
"""The same while a map is resampled on another grid."""

CORRELATED_ARRAYS = 10
"""The same while the autocorrelation of a map is computed, for Sal and Str."""

COPIED = 2
"""The same while heights are copied and checked."""

PREPARED = 8
"""Upper bound for any step of the preparation, including the map itself."""

# Number of points below which the system is not queried.
_TRIFLE = 2**20


def require_memory(shape: tuple[int, ...], maps: int, what: str = "a map") -> None:
    """Raise an error unless the memory holds a number of maps in double precision."""
    ny, nx = shape
    if ny * nx < _TRIFLE:
        return
    needed = 8 * maps * ny * nx
    side = memory.square_side(needed, (ny, nx))
    memory.require_memory(
        needed,
        f"{what} of {ny} × {nx} points needs",
        advice=(f"a square grid of up to about {side} × {side} points fits",),
    )
