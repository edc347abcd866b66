"""Multigrid by aggregation: conjugate gradients for networks of conductances.

A network has nodes, conductances between them, and conductances from nodes to the ground. Strongly
coupled nodes are aggregated in pairs, three times per level, so that coarse levels follow the
network: conductances over twenty orders of magnitude, holes, narrow channels and dead ends, where
a coarse grid of squares would bridge the barriers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.solvers.operator import dot

if TYPE_CHECKING:
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import SuperLU

Indices = NDArray[np.int32]

_COARSEST = 2000
"""Maximum number of nodes of a direct solution."""

_MAX_LEVELS = 30

_PAIRINGS = 3
"""Pairings from level to level: with two, coarse levels take most of the time."""

_STRONG = 0.1
"""Minimum conductance over the smaller sum at its ends for which two nodes may be paired."""

_RANDOM_FACTOR = 0.5
"""Maximum relative random increase of a coupling in the choice of a partner."""

_ROUNDS = 6
_ENOUGH = 0.25
"""Reduction of the residual by the first step on a coarse level that needs no second step."""

_FIRST, _SECOND = 48 / 41, 32 / 41
"""Coefficients of two Chebyshev steps for eigenvalues of 1 - B from 0.5 to 2, their maximum."""


@dataclass(frozen=True, eq=False)
class Network:
    """Network of nodes and conductances.

    Parameters
    ----------
    first, second : ndarray of int32, shape (m,)
        The two nodes of each link, first < second.
    conductance : ndarray, shape (m,)
        Conductance of each link, positive.
    ground : ndarray, shape (n,)
        Conductance from each node to the ground, zero or positive. Each connected part of the
        network needs a positive one.
    """

    first: Indices
    second: Indices
    conductance: Array
    ground: Array

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.ground.size

    def outflow(self, flow: Array) -> Array:
        """Return the outflow of each node [in units of the flow], shape (n,).

        Parameters
        ----------
        flow : ndarray, shape (m,)
            Flow through each link, from its first to its second node.
        """
        leaving = _sum_by_group(self.first, flow, self.nodes)
        leaving -= _sum_by_group(self.second, flow, self.nodes)
        return leaving

    def drop(self, potential: Array) -> Array:
        """Return the drop of potential from the first to the second node, shape (m,)."""
        drop: Array = potential[self.first]
        drop -= potential[self.second]
        return drop


class Level:
    """Matrix of a network in the form D (1 - B), where each row of B averages.

    Parameters
    ----------
    network : Network
        Nodes and conductances.
    """

    def __init__(self, network: Network) -> None:
        from scipy.sparse import coo_array

        nodes = network.nodes
        half = coo_array(
            (network.conductance, (network.first, network.second)), shape=(nodes, nodes)
        ).tocsr()
        self.diagonal: Array = half.sum(axis=1)
        self.diagonal += half.sum(axis=0)
        self.diagonal += network.ground
        self._average: csr_array = half + half.T
        self._average.data /= np.repeat(self.diagonal, np.diff(self._average.indptr))

    def excess(self, potential: Array) -> Array:
        """Return the outflow of each node at a potential, over D."""
        average: Array = self._average @ potential
        return np.subtract(potential, average, out=average)

    def apply(self, potential: Array) -> Array:
        """Return the outflow of each node at a potential."""
        leaving = self.excess(potential)
        leaving *= self.diagonal
        return leaving

    def smooth(self, residual: Array) -> Array:
        """Return the result of two Chebyshev steps from zero for a residual over D."""
        result: Array = self._average @ residual
        result *= _SECOND
        result += _FIRST * residual
        return result

    def factors(self) -> SuperLU:
        """Return the LU factors of the matrix."""
        from scipy.sparse import diags_array, eye_array
        from scipy.sparse.linalg import splu

        matrix = diags_array(self.diagonal) @ (eye_array(self.diagonal.size) - self._average)
        return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A")


class Multigrid:
    """Approximate inverse of a network, of nearly the same quality for all sizes.

    Parameters
    ----------
    network : Network
        Nodes and conductances.

    Notes
    -----
    Pairs of strongly coupled nodes are aggregated, then pairs of pairs, and pairs of those; the
    coarser network has one node for each aggregate, its conductances are the sums. On every level
    two Chebyshev steps smooth before and after; a coarse network is solved by one or two steps of
    conjugate gradients with the coarser levels as preconditioner, so that corrections that are
    constant on an aggregate suffice.

    References
    ----------
    Notay 2010, Electron. Trans. Numer. Anal. 37, 123: pairwise aggregation, and cycles of
    conjugate gradients
    """

    def __init__(self, network: Network) -> None:
        self.levels: list[Level] = []
        self._groups: list[Indices] = []
        random = np.random.default_rng(0)
        while True:
            level = Level(network)
            self.levels.append(level)
            if network.nodes <= _COARSEST or len(self.levels) == _MAX_LEVELS:
                break
            group, network = _pair_nodes(network, level.diagonal, random)
            for _ in range(_PAIRINGS - 1):
                # Include the links inside a group, so that a pool with narrow ends is not merged
                # with the nodes beyond.
                inner = _sum_by_group(group, level.diagonal, network.nodes)
                second, network = _pair_nodes(network, inner, random)
                group = second[group]
            self._groups.append(group)
        self._factors = self.levels[-1].factors()

    def __call__(self, residual: Array) -> Array:
        """Return the potential that approximately balances a residual, shape (n,)."""
        return self._cycle(0, residual / self.levels[0].diagonal)

    def _cycle(self, depth: int, residual: Array) -> Array:
        """Return the potential that approximately balances a residual over D, overwriting it."""
        level = self.levels[depth]
        if depth == len(self._groups):
            return np.asarray(self._factors.solve(residual * level.diagonal))
        group = self._groups[depth]
        result = level.smooth(residual)
        residual -= level.excess(result)
        diagonal = self.levels[depth + 1].diagonal
        coarse = _sum_by_group(group, residual * level.diagonal, diagonal.size)
        coarse /= diagonal
        change = self._solve_level(depth + 1, coarse)[group]
        residual -= level.excess(change)
        result += change
        result += level.smooth(residual)
        return result

    def _solve_level(self, depth: int, residual: Array) -> Array:
        """Return the result of one or two conjugate-gradient steps on a coarse level."""
        if depth == len(self._groups):
            return self._cycle(depth, residual)
        level = self.levels[depth]
        first = self._cycle(depth, residual.copy())
        through = level.apply(first)
        energy = dot(first, through)
        if not energy > 0:
            return first
        balance = residual * level.diagonal
        step = dot(first, balance) / energy
        remaining = balance - step * through
        if dot(remaining, remaining) <= _ENOUGH**2 * dot(balance, balance):
            first *= step
            return first
        second = self._cycle(depth, remaining / level.diagonal)
        # Make the second direction conjugate to the first.
        common = dot(second, through) / energy
        second -= common * first
        rest = dot(second, level.apply(second))
        first *= step
        if rest > 0:
            first += dot(second, remaining) / rest * second
        return first


def conjugate_gradients(
    inverse: Multigrid, residual: Array, enough: Callable[[Array, float], bool], max_steps: int
) -> tuple[Array, int]:
    """Return the potential that balances a residual.

    Parameters
    ----------
    inverse : Multigrid
        Network and approximate inverse, which is not linear.
    residual : ndarray, shape (n,)
        Inflow of each node.
    enough : callable
        ``enough(potential, unbalanced)`` returns whether to stop; ``unbalanced`` is the sum of the
        absolute residuals of all nodes.
    max_steps : int
        Maximum number of steps.

    Returns
    -------
    potential : ndarray, shape (n,)
        Potential that balances the residual.
    steps : int
        Number of steps.
    """
    level = inverse.levels[0]
    result = np.zeros_like(residual)
    remaining = residual.copy()
    direction = through = result
    energy = 0.0
    for step in range(max_steps):
        if enough(result, float(np.abs(remaining).sum())):
            return result, step
        better = inverse(remaining)
        if energy > 0:
            # Orthogonalize against the last direction itself: the recurrence of the residuals
            # requires a linear inverse.
            better -= dot(better, through) / energy * direction
        direction = better
        through = level.apply(direction)
        energy = dot(direction, through)
        if not energy > 0:
            return result, step
        length = dot(direction, remaining) / energy
        result += length * direction
        remaining -= length * through
    return result, max_steps


def _pair_nodes(
    network: Network, diagonal: Array, random: np.random.Generator
) -> tuple[Indices, Network]:
    """Return the group of each node, and the network of the groups."""
    nodes = network.nodes
    group = np.full(nodes, -1, np.int32)
    first, second, weight = _strong_links(network, diagonal, random)
    count = 0
    for _ in range(_ROUNDS):
        best = np.zeros(nodes)
        np.maximum.at(best, first, weight)
        np.maximum.at(best, second, weight)
        agreed = (weight == best[first]) & (weight == best[second])
        pairs = int(np.count_nonzero(agreed))
        if pairs == 0:
            break
        number = np.arange(count, count + pairs, dtype=np.int32)
        group[first[agreed]] = number
        group[second[agreed]] = number
        count += pairs
        remaining = (group[first] < 0) & (group[second] < 0)
        first, second, weight = first[remaining], second[remaining], weight[remaining]
    alone = np.nonzero(group < 0)[0]
    group[alone] = np.arange(count, count + alone.size, dtype=np.int32)
    return group, _merge_network(network, group, count + alone.size)


def _strong_links(
    network: Network, diagonal: Array, random: np.random.Generator
) -> tuple[Indices, Indices, Array]:
    """Return the links along which nodes may be paired, and their weights."""
    first, second = network.first, network.second
    weight = diagonal[first]
    np.minimum(weight, diagonal[second], out=weight)
    np.divide(network.conductance, weight, out=weight)
    strong = weight >= _STRONG
    weight = weight[strong]
    # Otherwise a slope of conductances would be one long chain, each node preferring the next.
    weight *= 1 + _RANDOM_FACTOR * random.random(weight.size)
    return first[strong], second[strong], weight


def _merge_network(network: Network, group: Indices, count: int) -> Network:
    """Return the network of groups of nodes, without links inside a group."""
    from scipy.sparse import coo_array

    first, second = group[network.first], group[network.second]
    between = np.nonzero(first != second)[0]
    first, second = first[between], second[between]
    low = np.minimum(first, second)
    np.maximum(first, second, out=second)
    links = coo_array((network.conductance[between], (low, second)), shape=(count, count))
    links = links.tocsr().tocoo()
    return Network(
        links.row.astype(np.int32, copy=False),
        links.col.astype(np.int32, copy=False),
        links.data,
        _sum_by_group(group, network.ground, count),
    )


def _sum_by_group(group: Indices, values: Array, count: int) -> Array:
    return np.bincount(group, values, count).astype(np.float64, copy=False)
