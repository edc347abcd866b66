"""Multigrid by aggregation on networks of conductances."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from roughcontact.solvers import aggregation
from roughcontact.solvers.aggregation import Multigrid, Network, conjugate_gradients

Array = NDArray[np.float64]


def lattice(n: int, conductance: Array) -> Network:
    """Return n by n nodes with links along x, then along y; the first column is grounded."""
    number = np.arange(n * n, dtype=np.int32).reshape(n, n)
    first = np.concatenate([number[:, :-1].ravel(), number[:-1].ravel()])
    second = np.concatenate([number[:, 1:].ravel(), number[1:].ravel()])
    ground = np.zeros((n, n))
    ground[:, 0] = 1.0
    return Network(first, second, conductance, ground.ravel())


def steps_of(network: Network) -> int:
    right = np.zeros(network.nodes)
    right[-1] = 1.0
    inverse = Multigrid(network)
    found, steps = conjugate_gradients(inverse, right, lambda _, left: left <= 1e-9, 300)
    # Rounding of potentials of a million and more.
    assert np.abs(right - inverse.levels[0].apply(found)).sum() < 1e-5
    return steps


def pools(n: int, rng: np.random.Generator) -> Array:
    """Return conductances of pools of two nodes, which narrow ends of many widths join."""
    inside = np.arange(n - 1) % 2 == 0
    along_x = np.where(inside[None, :], 1.0, 10 ** rng.uniform(-5, -2, (n, n - 1)))
    along_y = 10 ** rng.uniform(-5, -2, (n - 1, n))
    return np.concatenate([along_x.ravel(), along_y.ravel()])


@pytest.mark.parametrize(("kind", "most"), [("even", 25), ("pools", 25), ("six decades", 70)])
def test_step_count_is_small_for_any_size(kind: str, most: int) -> None:
    steps = []
    for n in (64, 128, 256):
        rng = np.random.default_rng(n)
        links = 2 * n * (n - 1)
        conductance = {
            "even": np.ones(links),
            "six decades": 10 ** rng.uniform(-6, 0, links),
            "pools": pools(n, rng),
        }[kind]
        steps.append(steps_of(lattice(n, conductance)))
    # Independent neighbors are the hardest, and no gap is like that.
    assert max(steps) <= most, steps


def test_a_pool_with_narrow_ends_stays_by_itself() -> None:
    n = 64
    network = lattice(n, pools(n, np.random.default_rng(0)))
    inverse = Multigrid(network)
    group = inverse._groups[0].reshape(n, n)
    # Both nodes of a pool are taken together in one level, and no pool with another.
    np.testing.assert_array_equal(group[:, ::2], group[:, 1::2])
    assert len(np.unique(group)) == n * n // 2


def test_levels_conserve_conductance() -> None:
    n = 60
    network = lattice(n, 10 ** np.random.default_rng(1).uniform(-6, 0, 2 * n * (n - 1)))
    inverse = Multigrid(network)
    assert len(inverse.levels) > 1
    for level in inverse.levels:
        # At one potential everywhere only the ground takes anything.
        leaving = level.apply(np.ones(level.diagonal.size))
        assert leaving.sum() == pytest.approx(network.ground.sum())
        assert level.diagonal.min() > 0
    assert inverse.levels[-1].diagonal.size <= aggregation._COARSEST
