"""Protocols of the displacement operator, and of sums over all pixels.

A map may be distributed over several processes, each with a slab of its rows: they then run the
same solver in parallel, on arrays of their local pixels. All quantities that depend on all pixels
pass through the `Sums` of the operator, so that all processes take the same decisions; nothing
else in ``roughcontact.solvers`` sums over a map.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

# Squares below this value, or above its inverse, may have lost digits.
_MIN_SAFE_SQUARE = 1e-280

Visit = Callable[[int, slice, NDArray[Any]], None]


class Sums(Protocol):
    """Sums and extremes over all pixels, including those of other processes.

    Arrays hold only the local entries, possibly none; all processes call the same methods in the
    same order. `roughcontact.halfspace.convolution.LocalSums` is for a single process.
    """

    def size(self, values: NDArray[Any]) -> int:
        """Return the number of values."""

    def total(self, values: NDArray[Any]) -> float:
        """Return the sum of the values."""

    def dot(self, first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
        """Return the inner product of two vectors."""

    def count(self, chosen: NDArray[np.bool_]) -> int:
        """Return the number of true values."""

    def largest(self, values: NDArray[Any], floor: float = ...) -> float:
        """Return the largest value, or ``floor`` if none is larger."""

    def smallest(self, values: NDArray[Any], limit: float = ...) -> float:
        """Return the smallest value, or ``limit`` if none is smaller."""

    def allreduce(self, parts: NDArray[Any]) -> NDArray[Any]:
        """Return the entrywise sums over all processes."""


class Support(Protocol):
    """Pixels prepared by an operator for its methods."""

    @property
    def starts(self) -> NDArray[np.int64]:
        """First entry of each local row block, and the number of entries at the end."""


class Operator(Protocol):
    """Linear and symmetric operator from pressure to displacement on a map.

    Flat indices number the local pixels from 0, row by row.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)`` of the whole map."""

    @property
    def rows(self) -> slice:
        """Local rows of the whole map."""

    @property
    def sums(self) -> Sums:
        """Sums over all pixels of the map."""

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
        """Whether no shorter map can replace this map, along y and along x.

        True along periodic axes; along both axes if several processes hold the map.
        """

    def support(self, index: NDArray[np.int64]) -> Support:
        """Prepare the pixels with these ascending flat indices for `spread` and `gather`."""

    def each_block(self, task: Callable[[int, slice], None]) -> None:
        """Call ``task(number, rows)`` for every local row block, on all threads.

        Rows are numbered from the first local row.
        """

    # Result of `support`; an operator may require a specific type.
    def spread(self, support: Any, pressure: NDArray[Any], visit: Visit) -> None:
        """Pass the displacement under pressure [Pa] on some pixels to a callback.

        ``visit(number, rows, displacement)`` receives the blocks of `each_block`, from one of
        several threads; the array is only valid during the call.
        """

    def gather(self, support: Any, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the loaded pixels."""

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of a small map that every process holds completely."""

    def to_single_precision(self) -> Operator:
        """Return the operator in single precision; the same object if it already is."""

    def approximate_inverse(self) -> Operator:
        """Return an approximate ``displacement / K₀₀ → pressure``; only `gather` is used."""


Family = Callable[[tuple[int, int], tuple[int, int]], Operator]
"""``family(shape, (ky, kx))``: the operator on a map of this shape whose pixels are as large as
``ky × kx`` pixels of the finest map."""


def norm(values: NDArray[Any], sums: Sums) -> float:
    """Return the Euclidean norm, summed in double precision."""
    values = values.astype(np.float64, copy=False)
    square = sums.dot(values, values)
    if _MIN_SAFE_SQUARE < square < 1 / _MIN_SAFE_SQUARE:
        return math.sqrt(square)
    # Squares that underflow or overflow, for example under a ceiling near zero.
    largest = max(sums.largest(values, floor=0.0), -sums.smallest(values, limit=0.0))
    if not 0 < largest < math.inf:
        return largest
    scaled = values / largest
    return largest * math.sqrt(sums.dot(scaled, scaled))
