"""Anderson acceleration of a fixed point."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.tensors import WEIGHTS

Array = NDArray[Any]
Parts = list[Array]

# Number of stored steps; growth of the defect at which they are cleared.
_MEMORY = 6
_GROWTH = 3.0
# Iterations without a smaller defect before plain steps follow, and the number of plain steps.
_MAX_FRUITLESS_STEPS = 10
_PLAIN_STEPS = 8
# Relative size below which directions of the memory are treated as linearly dependent.
_DEPENDENT = 1e-7


class Mixer:
    """Anderson acceleration of a fixed point y = x(y) with a growing number of unknowns.

    The next iterate is the combination of the last ones whose defect f = x - y would be the
    smallest if x were linear (Anderson 1965, doi:10.1145/321296.321305; Walker and Ni 2011,
    doi:10.1137/10078356X), in the norm of the energy: tensor product, thickness, modulus. If the
    defect grows, the memory is cleared and a plain step follows; if it has not fallen for several
    iterations, several plain steps. These never raise the defect: they are averaged nonexpansive.

    Parameters
    ----------
    weights : list of float
        Weight of a squared strain in each part of the vectors.
    workspace : Workspace
        Threads.
    """

    def __init__(self, weights: list[float], workspace: Workspace) -> None:
        self._weights, self._workspace = weights, workspace
        self._last: tuple[Parts, Parts] | None = None
        self._steps: list[tuple[Parts, Parts]] = []
        self._gram = np.zeros((0, 0))
        self._smallest = self._best = math.inf
        self._fruitless = self._plain = 0

    def grow(self, part: int, old: Array, new: Array) -> None:
        """Extend the stored vectors by the new unknowns of a part, with values of zero."""
        place = np.searchsorted(new, old)
        pairs = list(self._steps) if self._last is None else [*self._steps, self._last]
        for pair in pairs:
            for parts in pair:
                parts[part] = embedded(parts[part], place, new.size)

    def mix(self, x: Parts, defect: Parts) -> Parts:
        """Return the next iterate."""
        each, count = self._workspace.each, range(len(x))
        size = math.sqrt(self._products([(defect, defect)])[0])
        self._fruitless = 0 if size < self._best else self._fruitless + 1
        self._best = min(self._best, size)
        if self._fruitless == _MAX_FRUITLESS_STEPS:
            self._fruitless, self._plain = 0, _PLAIN_STEPS
        if self._plain or not size <= _GROWTH * self._smallest:
            self._steps, self._last, self._gram = [], None, np.zeros((0, 0))
            self._smallest = math.inf
        if self._plain:
            self._plain -= 1
            return [part.copy() for part in x]
        self._smallest = min(self._smallest, size)
        if self._last is not None:
            old_x, old_defect = self._last
            if len(self._steps) == _MEMORY:
                del self._steps[0]
                self._gram = self._gram[1:, 1:]

            def subtract(part: int) -> None:
                np.subtract(x[part], old_x[part], out=old_x[part])
                np.subtract(defect[part], old_defect[part], out=old_defect[part])

            each(subtract, count)
            self._steps.append((old_x, old_defect))
            row = self._products([(old_defect, step[1]) for step in self._steps])
            gram = np.empty((len(row), len(row)))
            gram[:-1, :-1], gram[-1], gram[:, -1] = self._gram, row, row
            self._gram = gram
        self._last = x, defect
        if not self._steps:
            return [part.copy() for part in x]
        right = self._products([(defect, step[1]) for step in self._steps])
        share = _least_squares(self._gram, right)
        mixed: Parts = [np.empty(0)] * len(x)

        def combine(part: int) -> None:
            result = x[part].copy()
            for factor, (step, _) in zip(share, self._steps, strict=True):
                result -= result.dtype.type(factor) * step[part]
            mixed[part] = result

        each(combine, count)
        return mixed

    def _products(self, pairs: list[tuple[Parts, Parts]]) -> NDArray[np.float64]:
        """Return the inner products of pairs of vectors."""
        sums = np.zeros((len(self._weights), len(pairs)))
        tensor = np.array(WEIGHTS)

        def add(part: int) -> None:
            if pairs and pairs[0][0][part].size:
                for number, (item, other) in enumerate(pairs):
                    each = np.einsum("ki,ki->k", item[part], other[part], dtype=np.float64)
                    sums[part, number] = self._weights[part] * (tensor @ each)

        self._workspace.each(add, range(len(self._weights)))
        result: NDArray[np.float64] = sums.sum(axis=0)
        return result


def embedded(values: Array, place: Array, size: int) -> Array:
    """Return the columns at given places of a wider array that is zero elsewhere."""
    wider = np.zeros((5, size), values.dtype)
    wider[:, place] = values
    return wider


def _least_squares(gram: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve normal equations without linearly dependent directions."""
    scale = np.sqrt(np.diag(gram))
    scale[scale == 0] = 1
    value, vector = np.linalg.eigh(gram / scale / scale[:, None])
    keep = value > _DEPENDENT * value[-1]
    share = vector[:, keep] @ ((vector[:, keep].T @ (right / scale)) / value[keep])
    return share / scale
