"""Sums and extremes over all pixels of a map."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace.fft import default_workers

Found = TypeVar("Found")


class LocalSums:
    """What is summed over all pixels of a map that this process holds alone.

    A map on several processes takes the same from an object of its own, which adds up what each
    of them finds; see `roughcontact.solvers.operator.Sums`.
    """

    def size(self, values: NDArray[Any]) -> int:
        """Return how many there are."""
        return values.size

    def total(self, values: NDArray[Any]) -> float:
        """Return their sum."""
        return float(values.sum())

    def dot(self, first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
        """Return the inner product of two rows."""
        # Not by BLAS: its threads spin for a while after each call, and the transforms need the
        # cores.
        return float(np.einsum("i,i->", first, second))

    def count(self, chosen: NDArray[np.bool_]) -> int:
        """Return how many are true."""
        return int(np.count_nonzero(chosen))

    def largest(self, values: NDArray[Any], least: float = -math.inf) -> float:
        """Return the largest, or ``least`` where none is larger."""
        return max(float(values.max()), least) if values.size else least

    def smallest(self, values: NDArray[Any], most: float = math.inf) -> float:
        """Return the smallest, or ``most`` where none is smaller."""
        return min(float(values.min()), most) if values.size else most

    def added(self, parts: NDArray[Any]) -> NDArray[Any]:
        """Return the sums, entry by entry, of what the processes made of their own pixels."""
        return parts

    # What else a contact needs where several processes hold its map.

    def agreed(self, task: Callable[[], Found]) -> Found:
        """Return the result of a task, or raise its error on all processes."""
        return task()

    def following(self, rows: NDArray[Any]) -> NDArray[Any]:
        """Return the same rows of the next process, and of the first one after the last."""
        return rows

    def workers(self) -> int:
        """Return the number of threads of this process."""
        return default_workers()

    def cost(self) -> NDArray[np.float64]:
        """Return time in communication [s] and bytes sent, up to now, mean of all processes."""
        return np.zeros(2)
