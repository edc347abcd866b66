"""Thin-film flow through a gap that contact interrupts, on the pixels of a map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import ConvergenceError, InputError
from roughcontact.joint.percolation import components, through
from roughcontact.solvers.aggregation import (
    Indices,
    Multigrid,
    Network,
    conjugate_gradients,
)

Array = NDArray[np.float64]

TOLERANCE = 1e-8
"""Flow that appears or vanishes anywhere, over the flow through the gap."""

_AIM = 1e-9
"""What the solver aims at by its own count."""

_REDUCTION = 1e-6
"""What a round leaves of what was unbalanced: the digits of much less are lost by rounding."""

_ROUNDS = 8
_MOST_STEPS = 300


@dataclass(frozen=True, eq=False)
class Flow:
    """What flows through a gap per unit of viscosity and of pressure gradient.

    Parameters
    ----------
    axis : {0, 1}
        Along which the mean pressure gradient points: 0 y, 1 x.
    permeability : (float, float)
        Mean of g³ ∂p along y and x per unit mean gradient [m³]; 0 without a way through, and
        NaN across the gradient where the map does not repeat along both axes.
    pressure : ndarray of float32, shape (ny, nx)
        Pressure over the pressure difference between the sides, or between a period and the next;
        NaN where nothing flows.
    density : ndarray of float32, shape (ny, nx)
        Amount of g³ ∇p over the mean gradient [m³].
    unbalanced : float
        Flow that appears or vanishes at a pixel, summed over all pixels, over the flow through the
        gap. What flows in differs less from what flows out.
    steps : int
        Steps of conjugate gradients.
    nodes : int
        Pixels that hang together with a way through.
    """

    axis: int
    permeability: tuple[float, float]
    pressure: NDArray[np.float32]
    density: NDArray[np.float32]
    unbalanced: float
    steps: int
    nodes: int

    @property
    def percolates(self) -> bool:
        """Whether there is a way through."""
        return self.nodes > 0


def flow(
    gap: Array, pixel: tuple[float, float], axis: int, periodic_axes: tuple[int, ...] = ()
) -> Flow:
    """Return the flow through a gap under a mean pressure gradient along an axis.

    Parameters
    ----------
    gap : ndarray, shape (ny, nx)
        Gap [m]; nothing flows where it is zero or less, or NaN.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    axis : {0, 1}
        Along which the mean gradient points: 0 y, 1 x.
    periodic_axes : tuple of int
        Axes along which the map repeats. Where it does along the gradient, the pressure
        falls by the same amount from each period to the next; where it does not, it is given on the
        first and the last side. Nothing flows through the other two sides where it does not
        repeat across the gradient.

    Returns
    -------
    Flow
        Permeability, pressure and flow density.

    Raises
    ------
    InputError
        If there is only one pixel along a flow that repeats.
    ConvergenceError
        If the flow does not balance to `TOLERANCE`.

    Notes
    -----
    ∇·(g³ ∇p) = 0 by finite volumes on the pixels, g³ at the face of two pixels their harmonic
    mean, half a pixel of its own at a side with given pressure. A fluid of viscosity η flows
    at 1/(12 η) of this.

    Near the threshold of percolation all of the pressure falls at one place, and in the pools at
    both ends the pressure differs by less than its last digit. It is therefore held as the sum of
    two numbers, the second of which is found from what the first leaves unbalanced.
    """
    if axis in periodic_axes and gap.shape[axis] < 2:
        raise InputError(
            f"must have at least two points along the flow, got shape {gap.shape}", argument="gap"
        )
    part = through(gap > 0, axis, periodic_axes)
    nodes = int(np.count_nonzero(part))
    if nodes == 0:
        empty = np.full(gap.shape, np.nan, np.float32)
        return Flow(axis, (0.0, 0.0), empty, np.zeros(gap.shape, np.float32), 0.0, 0, 0)
    scale = float(gap[part].max())
    problem = _problem(gap, scale, part, pixel, axis, periodic_axes)
    solved = _solved(problem)
    return _measured(problem, solved, part, pixel, scale**3)


@dataclass(frozen=True, eq=False)
class _Problem:
    """A network with what drives the flow: sides of given pressure, or a jump at a seam.

    ``along`` has the axis of each link, ``forward`` 1, or -1 where it leads back across a seam.
    ``inlet`` and ``outlet`` are conductances to pressure 1 and 0.
    """

    network: Network
    along: NDArray[np.int8]
    forward: NDArray[np.int8]
    inlet: Array
    outlet: Array
    axis: int
    periodic_axes: tuple[int, ...]

    @property
    def driven(self) -> NDArray[np.bool_]:
        """Links over which the pressure falls by 1 more than from node to node."""
        if self.axis not in self.periodic_axes:
            return np.zeros(self.along.size, bool)
        driven: NDArray[np.bool_] = (self.along == self.axis) & (self.forward < 0)
        return driven


def _problem(
    gap: Array,
    scale: float,
    part: NDArray[np.bool_],
    pixel: tuple[float, float],
    axis: int,
    periodic_axes: tuple[int, ...],
) -> _Problem:
    """Return the network of the pixels that are part of a way, of gaps over a scale."""
    cube = np.where(part, gap, 0.0)
    cube /= scale
    cube *= cube * cube
    number = np.full(part.shape, -1, np.int32)
    nodes = int(np.count_nonzero(part))
    number[part] = np.arange(nodes, dtype=np.int32)
    links = [_links(cube, number, pixel, toward, toward in periodic_axes) for toward in (0, 1)]
    along = np.repeat(np.array([0, 1], np.int8), [link[0].size for link in links])
    first, second, conductance, forward = (
        np.concatenate(column) for column in zip(*links, strict=True)
    )
    inlet, outlet, held = np.zeros(nodes), np.zeros(nodes), np.zeros(nodes)
    if axis in periodic_axes:
        # The pressure is up to a constant on each part: one pixel is tied to the ground, through
        # which nothing flows.
        for y, x in _widest(cube, components(part, periodic_axes)):
            held[int(number[y, x])] = cube[y, x]
    else:
        shape = _shape(pixel, axis)
        for side, ends in ((0, inlet), (-1, outlet)):
            at: Indices = np.take(number, side, axis)
            ends[at[at >= 0]] = 2 * shape * np.take(cube, side, axis)[at >= 0]
    network = Network(first, second, conductance, held + inlet + outlet)
    return _Problem(network, along, forward, inlet, outlet, axis, periodic_axes)


def _links(
    cube: Array, number: Indices, pixel: tuple[float, float], axis: int, wraps: bool
) -> tuple[Indices, Indices, Array, NDArray[np.int8]]:
    """Return nodes, conductance and direction of the links along an axis."""
    ends = [(slice(None, -1), slice(1, None), 1)]
    if wraps and number.shape[axis] > 1:
        ends.append((slice(None, 1), slice(-1, None), -1))
    found = []
    for low, high, forward in ends:
        one, two = (
            (part, slice(None)) if axis == 0 else (slice(None), part) for part in (low, high)
        )
        joined = (number[one] >= 0) & (number[two] >= 0)
        k, other = cube[one][joined], cube[two][joined]
        # The harmonic mean, in an order in which no product of small numbers is lost.
        other /= k + other
        other *= 2 * _shape(pixel, axis) * k
        first, second = number[one][joined], number[two][joined]
        found.append((first, second, other, np.full(first.size, forward, np.int8)))
    first, second, conductance, direction = (
        np.concatenate(column) for column in zip(*found, strict=True)
    )
    return first, second, conductance, direction


def _shape(pixel: tuple[float, float], axis: int) -> float:
    """Return width over length of the link of two pixels along an axis."""
    return pixel[1 - axis] / pixel[axis]


def _widest(cube: Array, label: NDArray[np.int32]) -> list[tuple[int, int]]:
    """Return the widest pixel of each part."""
    from scipy import ndimage

    parts = np.unique(label[label > 0])
    places = np.asarray(ndimage.maximum_position(cube, label, parts), dtype=np.int64)
    return [(y, x) for y, x in places.tolist()]


@dataclass(frozen=True, eq=False)
class _Solved:
    """Pressure at the nodes as a sum of two numbers, and what it drives through links and sides."""

    pressure: Array
    small: Array
    through: Array
    inflow: Array
    outflow: Array
    power: float
    steps: int

    @classmethod
    def at(cls, problem: _Problem, pressure: Array, small: Array, steps: int) -> _Solved:
        network = problem.network
        drop = network.drop(pressure)
        drop -= problem.driven
        drop += network.drop(small)
        into, out = (1 - pressure) - small, pressure + small
        through = network.conductance * drop
        inflow, outflow = problem.inlet * into, problem.outlet * out
        power = _dot(through, drop) + _dot(inflow, into) + _dot(outflow, out)
        return cls(pressure, small, through, inflow, outflow, power, steps)

    def unbalanced(self, problem: _Problem) -> Array:
        """Return what flows into each node and not out again."""
        left = problem.network.outflow(self.through)
        np.subtract(self.inflow, left, out=left)
        left -= self.outflow
        return left


def _solved(problem: _Problem) -> _Solved:
    """Return the pressure at which the flow balances, found in rounds."""
    nodes = problem.network.nodes
    inverse = Multigrid(problem.network)
    # What flows at the nodes takes memory: only its sums are kept from round to round.
    pressure, small, steps = np.zeros(nodes), np.zeros(nodes), 0
    for number in range(_ROUNDS):
        left, power = _left(problem, pressure, small)
        total = float(np.abs(left).sum())
        if total <= _AIM * power:
            break
        change, more = _balanced(inverse, left, total, power)
        if number == 0:
            pressure = change
        else:
            small += change
        steps += more
    del inverse
    return _Solved.at(problem, pressure, small, steps)


def _left(problem: _Problem, pressure: Array, small: Array) -> tuple[Array, float]:
    """Return what flows into each node and not out again, and the power of the flow."""
    found = _Solved.at(problem, pressure, small, 0)
    return found.unbalanced(problem), found.power


def _balanced(inverse: Multigrid, left: Array, total: float, power: float) -> tuple[Array, int]:
    """Return the change of pressure that balances what is left, to a part of it."""

    def enough(change: Array, unbalanced: float) -> bool:
        # The power of the flow over the pressure difference, 1, is the flow.
        flow = max(power - _dot(left, change), 0.0)
        return unbalanced <= max(_REDUCTION * total, _AIM * flow)

    return conjugate_gradients(inverse, left, enough, _MOST_STEPS)


def _measured(
    problem: _Problem,
    solved: _Solved,
    part: NDArray[np.bool_],
    pixel: tuple[float, float],
    scale: float,
) -> Flow:
    """Return the flow in units of a scale of g³ [m³]."""
    axis = problem.axis
    sides = [edge * points for edge, points in zip(pixel, part.shape, strict=True)]
    unbalanced = float(np.abs(solved.unbalanced(problem)).sum()) / solved.power
    if not unbalanced <= TOLERANCE:
        raise ConvergenceError(
            f"the flow through the gap balances to {unbalanced:.2g} of it only, after "
            f"{solved.steps} steps, instead of {TOLERANCE:.0e}",
            None,
        )
    forward = solved.through * problem.forward
    permeability = [0.0, 0.0]
    permeability[axis] = scale * solved.power * sides[axis] / sides[1 - axis]
    if set(problem.periodic_axes) == {0, 1}:
        across = float(forward[problem.along != axis].sum()) * pixel[1 - axis]
        permeability[1 - axis] = scale * across / sides[1 - axis]
    else:
        permeability[1 - axis] = math.nan
    density = np.zeros(part.shape, np.float32)
    density[part] = scale * sides[axis] * _amount(problem, solved, forward, pixel)
    pressure = np.full(part.shape, np.nan, np.float32)
    pressure[part] = solved.pressure
    return Flow(
        axis, (permeability[0], permeability[1]), pressure, density, unbalanced, solved.steps,
        problem.network.nodes,
    )  # fmt: skip


def _amount(
    problem: _Problem, solved: _Solved, forward: Array, pixel: tuple[float, float]
) -> Array:
    """Return the amount of the flow density at the nodes, the mean of that at the faces."""
    network = problem.network
    square = np.zeros(network.nodes)
    for axis in (0, 1):
        along = problem.along == axis
        flow = forward[along]
        at = np.bincount(network.first[along], flow, network.nodes).astype(np.float64, copy=False)
        at += np.bincount(network.second[along], flow, network.nodes)
        if axis == problem.axis:
            at += solved.inflow + solved.outflow
        at /= 2 * pixel[1 - axis]
        square += at * at
    return np.sqrt(square)


def _dot(first: Array, second: Array) -> float:
    # Not by BLAS, whose threads would change the last digits.
    return float(np.einsum("i,i->", first, second))
