"""Protocols of the displacement operator, and of sums over all pixels.

A map may lie on several processes, each with a band of its rows: they then run the same solver
side by side, on arrays of their own pixels. Whatever depends on the pixels of all of them passes
through the `Sums` of the operator, so that all come to the same decisions; nothing else in this
wing sums over a map.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

# Squares below it, or above its inverse, may have lost digits.
_SMALLEST = 1e-280

Visit = Callable[[int, slice, NDArray[Any]], None]


class Sums(Protocol):
    """Sums and extremes over all pixels, those of other processes included.

    Arrays hold the entries of this process alone, of which there may be none; all processes call
    the same methods in the same order. `roughcontact.halfspace.convolution.LocalSums` serves where
    there is one process.
    """

    def size(self, values: NDArray[Any]) -> int:
        """Return how many there are."""

    def total(self, values: NDArray[Any]) -> float:
        """Return their sum."""

    def dot(self, first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
        """Return the inner product of two rows."""

    def count(self, chosen: NDArray[np.bool_]) -> int:
        """Return how many are true."""

    def largest(self, values: NDArray[Any], floor: float = ...) -> float:
        """Return the largest, or ``floor`` where none is larger."""

    def smallest(self, values: NDArray[Any], limit: float = ...) -> float:
        """Return the smallest, or ``limit`` where none is smaller."""

    def allreduce(self, parts: NDArray[Any]) -> NDArray[Any]:
        """Return the entrywise sums over all processes."""


class Support(Protocol):
    """Some pixels, prepared by an operator for its own use."""

    @property
    def starts(self) -> NDArray[np.int64]:
        """First entry of each row block of this process, and their number behind the last."""


class Operator(Protocol):
    """A map of pressures to the displacement of the same map, linear and symmetric.

    Flat indices count the pixels of this process from 0 on, row by row.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)`` of the whole map."""

    @property
    def rows(self) -> slice:
        """Rows of the whole map that this process holds."""

    @property
    def sums(self) -> Sums:
        """Sums over all pixels of the map."""

    @property
    def real(self) -> type:
        """Kind of number of displacements: that of its arithmetic."""

    @property
    def self_displacement(self) -> float:
        """Displacement of a pixel under unit pressure on itself, K₀₀ [m/Pa]."""

    @property
    def is_long_wave_soft(self) -> bool:
        """Whether it moves far more in long waves than in short ones, as a plate on a soft bed."""

    @property
    def periodic_axes(self) -> tuple[bool, bool]:
        """Axes ``(y, x)`` along which no shorter map can stand for this one.

        Those along which it repeats itself; both where several processes hold it.
        """

    def support(self, index: NDArray[np.int64]) -> Support:
        """Prepare the pixels with these ascending flat indices for `spread` and `gather`."""

    def each_block(self, task: Callable[[int, slice], None]) -> None:
        """Call ``task(number, rows)`` for every row block of this process, on all threads.

        Rows count from the first of this process on.
        """

    # Result of `support`; an operator may require a specific type.
    def spread(self, support: Any, pressure: NDArray[Any], visit: Visit) -> None:
        """Show the displacement under pressure [Pa] on some pixels, row block by row block.

        ``visit(number, rows, displacement)`` gets the blocks of `each_block`, from one of several
        threads; the array is only valid during the call.
        """

    def gather(self, support: Any, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the loaded pixels themselves."""

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of a small map, which every process holds as a whole."""

    def to_single_precision(self) -> Operator:
        """Return the same in single precision; itself where it is so."""

    def approximate_inverse(self) -> Operator:
        """Return ``displacement / K₀₀ → pressure``, about, of which only `gather` is used."""


Family = Callable[[tuple[int, int], tuple[int, int]], Operator]
"""``family(shape, (ky, kx))``: the operator on a map of that shape whose pixels are as large as
``ky × kx`` pixels of the finest one."""


def norm(values: NDArray[Any], sums: Sums) -> float:
    """Return the Euclidean norm, summed in double precision."""
    values = values.astype(np.float64, copy=False)
    square = sums.dot(values, values)
    if _SMALLEST < square < 1 / _SMALLEST:
        return math.sqrt(square)
    # Squares that vanish or overflow, under a ceiling that is next to none for one.
    largest = max(sums.largest(values, floor=0.0), -sums.smallest(values, limit=0.0))
    if not 0 < largest < math.inf:
        return largest
    scaled = values / largest
    return largest * math.sqrt(sums.dot(scaled, scaled))
