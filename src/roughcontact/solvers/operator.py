"""Protocol of the displacement operator, and inner products of arrays of pixels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

# Squares below this value, or above its inverse, may have lost digits.
_MIN_SAFE_SQUARE = 1e-280

Visit = Callable[[int, slice, NDArray[Any]], None]


class Support(Protocol):
    """Pixels prepared by an operator for its methods."""

    @property
    def starts(self) -> NDArray[np.int64]:
        """First entry of each row block, and the number of entries at the end."""


class Operator(Protocol):
    """Linear and symmetric operator from pressure to displacement on a map.

    Flat indices number the pixels from 0, row by row.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)`` of the map."""

    @property
    def real(self) -> type:
        """Floating-point type of the displacement."""

    @property
    def self_displacement(self) -> float:
        """Displacement of a pixel under unit pressure on itself, K₀₀ [m/Pa]."""

    @property
    def is_long_wave_soft(self) -> bool:
        """Whether long waves are far more compliant than short ones: a plate on a soft bed."""

    @property
    def periodic_axes(self) -> tuple[bool, bool]:
        """Whether the map is periodic along y and along x."""

    def support(self, index: NDArray[np.int64]) -> Support:
        """Prepare the pixels with these ascending flat indices for `spread` and `gather`."""

    def each_block(self, task: Callable[[int, slice], None]) -> None:
        """Call ``task(number, rows)`` for every row block, on all threads."""

    # Result of `support`; an operator may require a specific type.
    def spread(self, support: Any, pressure: NDArray[Any], visit: Visit) -> None:
        """Pass the displacement under pressure [Pa] on some pixels to a callback.

        ``visit(number, rows, displacement)`` receives the blocks of `each_block`, from one of
        several threads; the array is only valid during the call.
        """

    def gather(self, support: Any, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the loaded pixels."""

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of a map under a pressure map, shape ``(ny, nx)``."""

    def to_single_precision(self) -> Operator:
        """Return the operator in single precision; the same object if it already is."""

    def approximate_inverse(self) -> Operator:
        """Return an approximate ``displacement / K₀₀ → pressure``; only `gather` is used."""


Family = Callable[[tuple[int, int], tuple[int, int]], Operator]
"""``family(shape, (ky, kx))``: the operator on a map of this shape whose pixels are as large as
``ky × kx`` pixels of the finest map."""


def dot(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Return the inner product of two vectors."""
    # Not by BLAS: its threads spin for a while after each call, and the transforms need the cores.
    return float(np.einsum("i,i->", first, second))


def norm(values: NDArray[Any]) -> float:
    """Return the Euclidean norm, summed in double precision."""
    values = values.astype(np.float64, copy=False)
    square = dot(values, values)
    if _MIN_SAFE_SQUARE < square < 1 / _MIN_SAFE_SQUARE:
        return math.sqrt(square)
    # Squares that underflow or overflow, for example under a ceiling near zero.
    largest = float(np.abs(values).max(initial=0.0))
    if not 0 < largest < math.inf:
        return largest
    scaled = values / largest
    return largest * math.sqrt(dot(scaled, scaled))
