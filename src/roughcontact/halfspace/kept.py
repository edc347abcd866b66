"""Spectra of kernels, kept from one operator to the next.

A second solve on the same grid, a neighboring load or a coarser grid of it, then makes none.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST = 2**27
"""Bytes that are kept at most, in a process; a map of 2900 × 2900 points needs half of it."""


class Kept:
    """Arrays by what they depend on, the last used ones within a memory.

    Parameters
    ----------
    most : int
        Bytes that are kept at most. What is larger is made each time.

    Examples
    --------
    >>> kept = Kept(100)
    >>> kept.get("ones", lambda: np.ones(4)) is kept.get("ones", lambda: np.ones(4))
    True
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._arrays: OrderedDict[Hashable, Array] = OrderedDict()
        self._lock = threading.Lock()

    @property
    def nbytes(self) -> int:
        """Bytes that are kept now."""
        return sum(array.nbytes for array in self._arrays.values())

    def get(self, key: Hashable, make: Callable[[], Array]) -> Array:
        """Return what ``make()`` returned for this key, read-only."""
        with self._lock:
            if key in self._arrays:
                self._arrays.move_to_end(key)
                return self._arrays[key]
        # Two threads may make the same array, which is the same either way.
        array = make()
        array.flags.writeable = False
        if array.nbytes <= self._most:
            with self._lock:
                self._arrays[key] = array
                while self.nbytes > self._most:
                    self._arrays.popitem(last=False)
        return array


# The one thing that outlives a call. It changes no result: an array depends on its key alone.
SPECTRA = Kept(MOST)
