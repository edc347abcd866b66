"""Thin-film flow of a liquid or a gas through a gap with contact, on the pixels of a map.

`percolating_points`: Exact on the pixels: pixels with a common edge are connected, pixels with a
common corner are not, as in the flow. Parts of the map that meet across a periodic seam are joined
with the number of periods between them; a part percolates if two paths to it differ in that
number.

`constriction`: The largest gap at which the points with at least this gap still percolate, by
bisection among the gaps of the map. In two dimensions nearly all of the pressure drop is at a few
such constrictions (Persson and Yang 2008, doi:10.1088/0953-8984/20/31/315011).

`flow`: ∇·(g³ ∇p) = 0 by finite volumes on the pixels; g³ at the face of two pixels is their
harmonic mean, and a side with given pressure is half a pixel away. The flow of a fluid of viscosity
η is 1/(12 η) of this.

Near the percolation threshold the whole pressure drop is at one constriction, and in the pools on
both sides the pressure differs by less than its last digit. The pressure is therefore stored as the
sum of two numbers, the second of which is computed from the imbalance of the first.

The flow that is dragged along by a smooth sliding face follows by reciprocity from the mean of g ∂p
(``Flow.sheared_gap``), without a second flow solution.

The conductances of a rarefied gas depend on the pressure: the network is solved again with the
conductances at the last pressure until the flow balances.

The throughput of a gap g per width is g³ G p ∇p/(12 η) [Pa m³/s], with G = 6 Q(D)/D by the local
rarefaction D = √π g p/(2 λ p) of `roughcontact.theory.rarefied_gas.channel_flow`; G is 1 where the
gas is viscous. In terms of the potential Φ = ∫ p G dp of the narrowest constriction, the throughput
is g³ ∇Φ/(12 η) for gaps of the same width, and G/G_c times this for others. This factor depends
little on the pressure, and not at all if the gas is viscous or free molecular everywhere.

Along a periodic axis the sample is short compared with the land: its permeability is computed at
one pressure, and averaged by Gauss quadrature over the land, along which Φ falls linearly. Along a
free axis the sample is the land, with the inlet at the first row or column: the mobility depends on
the pressure of each pixel (`roughcontact.analyses.leak.flow.flow` with a mobility).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.contact.result import ContactResult
from roughcontact.errors import ConvergenceError, InputError
from roughcontact.material.fluids import GAS_CONSTANT
from roughcontact.solvers.aggregation import Indices, Multigrid, Network, conjugate_gradients
from roughcontact.theory.rarefied_gas import channel_flow, mean_free_path

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Constriction:
    """Narrowest place of the widest path through a gap."""

    gap: float  # Critical gap [m]: the largest of the narrowest gaps of all paths
    place: tuple[int, int]  # Pixel `(y, x)`


def flow_gap(result: ContactResult) -> Array:
    """Return the gap for the fluid [m], 0 where the bodies touch, shape (ny, nx)."""
    return np.where(result.contact, 0.0, np.fmax(result.gap, 0.0))


def percolating_points(opened: Mask, axis: int, periodic_axes: tuple[int, ...] = ()) -> Mask:
    """Return the open points that belong to a percolating part of the map."""
    label, parts = _label_parts(opened, axis, periodic_axes)
    root = parts.roots()
    leads = np.zeros(root.size, bool)
    if axis in periodic_axes:
        leads[list(parts.winding)] = True
        leads = leads[root]
    else:
        first, last = (root[np.unique(label.take(side, axis))] for side in (0, -1))
        leads = np.isin(root, np.intersect1d(first, last))
    leads[0] = False
    return leads[label]


def components(opened: Mask, periodic_axes: tuple[int, ...] = ()) -> NDArray[np.int32]:
    """Return a label for each connected part of the open points, 0 where not open."""
    label, parts = _label_parts(opened, 0, periodic_axes)
    return parts.roots()[label]


def constriction(gap: Array, axis: int, periodic_axes: tuple[int, ...] = ()) -> Constriction | None:
    """Return the narrowest place of the widest path through a gap; None without a path."""
    gaps = np.unique(gap[percolating_points(gap > 0, axis, periodic_axes)])
    if gaps.size == 0:
        return None
    low, high = 0, gaps.size
    while high - low > 1:
        middle = (low + high) // 2
        if percolating_points(gap >= gaps[middle], axis, periodic_axes).any():
            low = middle
        else:
            high = middle
    wide = percolating_points(gap >= gaps[low], axis, periodic_axes)
    y, x = np.argwhere(wide & (gap == gaps[low]))[0].tolist()
    return Constriction(float(gaps[low]), (y, x))


def _label_parts(
    opened: Mask, axis: int, periodic_axes: tuple[int, ...]
) -> tuple[NDArray[np.int32], _Parts]:
    """Return labels of the parts inside the map, and their connections across seams."""
    from scipy import ndimage

    label = np.empty(opened.shape, np.int32)
    parts = _Parts(int(ndimage.label(opened, output=label)) + 1)
    for seam in periodic_axes:
        for item, two in _seam_neighbors(label, seam):
            parts.join(item, two, int(seam == axis))
    return label, parts


def _seam_neighbors(label: NDArray[np.int32], axis: int) -> Iterator[tuple[int, int]]:
    """Yield pairs of parts that meet across the seam of an axis: last row, first row."""
    pairs = np.stack([label.take(-1, axis), label.take(0, axis)], axis=1)
    pairs = pairs[(pairs > 0).all(axis=1)]
    if pairs.size:
        yield from (tuple(pair) for pair in np.unique(pairs, axis=0).tolist())


class _Parts:
    """Union-find of parts that are joined across seams, with their period indices."""

    def __init__(self, count: int) -> None:
        self._parent = list(range(count))
        self._period = [0] * count
        self.winding: set[int] = set()

    def find_root(self, part: int) -> tuple[int, int]:
        """Return the root of a part, and the number of periods from the root to the part."""
        periods = 0
        while self._parent[part] != part:
            periods += self._period[part]
            part = self._parent[part]
        return part, periods

    def roots(self) -> NDArray[np.int32]:
        """Return the root of each part."""
        return np.array([self.find_root(part)[0] for part in range(len(self._parent))], np.int32)

    def join(self, item: int, two: int, periods: int) -> None:
        """Join two parts, the second shifted by a number of periods."""
        (first, before), (second, after) = self.find_root(item), self.find_root(two)
        if first == second:
            if before + periods != after:
                self.winding.add(first)
            return
        self._parent[second] = first
        self._period[second] = before + periods - after
        if second in self.winding:
            self.winding.add(first)


TOLERANCE = 1e-8
"""Maximum imbalance, summed over all nodes, over the flow through the gap."""

_TARGET_IMBALANCE = 1e-9
"""Target imbalance of the solver, below `TOLERANCE`."""

_REDUCTION = 1e-6
"""Reduction of the imbalance per round; rounding prevents smaller values."""

_ROUNDS = 8
_MAX_STEPS = 300
_MAX_MOBILITY_UPDATES = 30

Mobility = Callable[[Array], Array]
"""Factors of g³ at the nodes, from their pressure: 1 at the inlet, 0 at the outlet."""


@dataclass(frozen=True, eq=False)
class Flow:
    """Flow through a gap per unit mean pressure gradient, without the factor 1/(12 η)."""

    axis: int  # Direction of the mean pressure gradient: 0 y, 1 x
    permeability: tuple[float, float]  # Mean of g³ ∂p along y and x per unit mean gradient [m³]
    pressure: NDArray[np.float32]  # (ny, nx)
    density: NDArray[np.float32]  # (ny, nx) Magnitude of g³ ∇p over the mean gradient [m³]
    sheared_gap: float  # Mean of g ∂p along the axis per unit mean gradient [m]
    unbalanced: float
    steps: int  # Steps of conjugate gradients
    nodes: int  # Number of percolating pixels

    @property
    def percolates(self) -> bool:
        """Whether there is an open path."""
        return self.nodes > 0


def flow(
    gap: Array,
    pixel: tuple[float, float],
    axis: int,
    periodic_axes: tuple[int, ...] = (),
    mobility: Mobility | None = None,
) -> Flow:
    """Return the flow through a gap under a mean pressure gradient along an axis."""
    if axis in periodic_axes and gap.shape[axis] < 2:
        raise InputError(
            f"must have at least two points along the flow, got shape {gap.shape}", argument="gap"
        )
    part = percolating_points(gap > 0, axis, periodic_axes)
    nodes = int(np.count_nonzero(part))
    if nodes == 0:
        empty = np.full(gap.shape, np.nan, np.float32)
        return Flow(axis, (0.0, 0.0), empty, np.zeros(gap.shape, np.float32), 0.0, 0.0, 0, 0)
    scale = float(gap[part].max())
    cube = np.where(part, gap, 0.0)
    cube /= scale
    cube *= cube * cube
    problem = _problem(cube, part, pixel, axis, periodic_axes)
    solved, moved = _solve_pressure(problem), cube
    if mobility is not None:
        for left in reversed(range(_MAX_MOBILITY_UPDATES)):
            moved = cube.copy()
            moved[part] *= mobility(solved.pressure + solved.small)
            problem = _problem(moved, part, pixel, axis, periodic_axes)
            solved = _Solved.from_pressure(problem, solved.pressure, solved.small, solved.steps)
            total = float(np.abs(solved.net_flow(problem)).sum())
            # If the last iteration does not balance, `_flow_from_pressure` raises an error.
            if total <= TOLERANCE * solved.power or not left:
                break
            solved = _solve_pressure(problem, solved)
    sheared = _sheared_gap(problem, solved, gap[part], moved[part]) / part.shape[1 - axis]
    return _flow_from_pressure(problem, solved, part, pixel, scale**3, sheared)


@dataclass(frozen=True, eq=False)
class _Problem:
    """Flow network and its drive: sides of given pressure, or a pressure jump at a seam."""

    network: Network
    along: NDArray[np.int8]
    forward: NDArray[np.int8]
    inlet: Array
    outlet: Array
    axis: int
    periodic_axes: tuple[int, ...]

    @property
    def driven(self) -> NDArray[np.bool_]:
        """Links across the seam, with an additional pressure drop of 1."""
        if self.axis not in self.periodic_axes:
            return np.zeros(self.along.size, bool)
        return (self.along == self.axis) & (self.forward < 0)


def _problem(
    cube: Array,
    part: NDArray[np.bool_],
    pixel: tuple[float, float],
    axis: int,
    periodic_axes: tuple[int, ...],
) -> _Problem:
    """Return the network of the percolating pixels from the cubes of their gaps."""
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
        # The pressure of each part is known up to a constant: one pixel is grounded, without flow
        # to the ground.
        for y, x in _widest_pixels(cube, components(part, periodic_axes)):
            held[int(number[y, x])] = cube[y, x]
    else:
        shape = _shape(pixel, axis)
        for side, ends in ((0, inlet), (-1, outlet)):
            index: Indices = np.take(number, side, axis)
            ends[index[index >= 0]] = 2 * shape * np.take(cube, side, axis)[index >= 0]
    network = Network(first, second, conductance, held + inlet + outlet)
    return _Problem(network, along, forward, inlet, outlet, axis, periodic_axes)


def _links(
    cube: Array, number: Indices, pixel: tuple[float, float], axis: int, wraps: bool
) -> tuple[Indices, Indices, Array, NDArray[np.int8]]:
    """Return both nodes, conductance and direction of the links along an axis."""
    ends = [(slice(None, -1), slice(1, None), 1)]
    if wraps and number.shape[axis] > 1:
        ends.append((slice(None, 1), slice(-1, None), -1))
    result = []
    for low, high, forward in ends:
        item, two = (
            (part, slice(None)) if axis == 0 else (slice(None), part) for part in (low, high)
        )
        joined = (number[item] >= 0) & (number[two] >= 0)
        k, other = cube[item][joined], cube[two][joined]
        # Harmonic mean, in an order without underflow of products of small numbers.
        other /= k + other
        other *= 2 * _shape(pixel, axis) * k
        first, second = number[item][joined], number[two][joined]
        result.append((first, second, other, np.full(first.size, forward, np.int8)))
    first, second, conductance, direction = (
        np.concatenate(column) for column in zip(*result, strict=True)
    )
    return first, second, conductance, direction


def _shape(pixel: tuple[float, float], axis: int) -> float:
    """Return width over length of the link of two pixels along an axis."""
    return pixel[1 - axis] / pixel[axis]


def _widest_pixels(cube: Array, label: NDArray[np.int32]) -> list[tuple[int, int]]:
    """Return the widest pixel of each part."""
    widest = np.zeros(int(label.max()) + 1)
    np.maximum.at(widest, label, cube)
    places = np.flatnonzero((label > 0) & (cube == widest[label]))
    _, first = np.unique(label.ravel()[places], return_index=True)
    rows, columns = np.unravel_index(places[first], label.shape)
    return list(zip(rows.tolist(), columns.tolist(), strict=True))


@dataclass(frozen=True, eq=False)
class _Solved:
    """Pressure at the nodes as a sum of two numbers, and flow through links and sides."""

    pressure: Array
    small: Array
    through: Array
    inflow: Array
    outflow: Array
    power: float
    steps: int

    @classmethod
    def from_pressure(cls, problem: _Problem, pressure: Array, small: Array, steps: int) -> _Solved:
        network = problem.network
        drop = network.drop(pressure)
        # Pressures on both sides of a seam differ by about 1; all other rounding is relative to the
        # drop of a link.
        seam = np.flatnonzero(problem.driven)
        ends = (pressure[of[seam]] for of in (network.first, network.second))
        drop[seam], rounded = _exact_sum(next(ends), -next(ends))
        drop[seam] -= 1
        drop[seam] += rounded
        drop += network.drop(small)
        into, out = (1 - pressure) - small, pressure + small
        through = network.conductance * drop
        inflow, outflow = problem.inlet * into, problem.outlet * out
        power = _dot(through, drop) + _dot(inflow, into) + _dot(outflow, out)
        return cls(pressure, small, through, inflow, outflow, power, steps)

    def net_flow(self, problem: _Problem) -> Array:
        """Return the net flow into each node."""
        residual = problem.network.outflow(self.through)
        np.subtract(self.inflow, residual, out=residual)
        residual -= self.outflow
        return residual


def _exact_sum(first: Array, second: Array) -> tuple[Array, Array]:
    """Return a sum and its rounding error (Knuth, The Art of Computer Programming 2, 4.2.2)."""
    total = first + second
    added = total - first
    return total, (first - (total - added)) + (second - added)


def _solve_pressure(problem: _Problem, start: _Solved | None = None) -> _Solved:
    """Return the pressure at which the flow balances, by iterative refinement."""
    nodes = problem.network.nodes
    inverse = Multigrid(problem.network)
    # To save memory, the flow through links is not stored between iterations.
    pressure, small, steps = np.zeros(nodes), np.zeros(nodes), 0
    if start is not None:
        pressure, steps = start.pressure + start.small, start.steps
    for _ in range(_ROUNDS):
        residual, power = _imbalance(problem, pressure, small)
        total = float(np.abs(residual).sum())
        if total <= _TARGET_IMBALANCE * power:
            break
        change, more = _solve_correction(inverse, residual, total, power)
        # The second number keeps what the first one rounds, also between constrictions, where a
        # correction shifts the pressure of a wide region as a whole.
        pressure, small = _exact_sum(pressure, small + change)
        steps += more
    del inverse
    return _Solved.from_pressure(problem, pressure, small, steps)


def _imbalance(problem: _Problem, pressure: Array, small: Array) -> tuple[Array, float]:
    """Return the net flow into each node, and the power of the flow."""
    result = _Solved.from_pressure(problem, pressure, small, 0)
    return result.net_flow(problem), result.power


def _solve_correction(
    inverse: Multigrid, residual: Array, total: float, power: float
) -> tuple[Array, int]:
    """Return the pressure change that balances the residual flow, up to `_REDUCTION`."""

    def enough(change: Array, unbalanced: float) -> bool:
        # Power over pressure difference (1) is the flow.
        flow = max(power - _dot(residual, change), 0.0)
        return unbalanced <= max(_REDUCTION * total, _TARGET_IMBALANCE * flow)

    return conjugate_gradients(inverse, residual, enough, _MAX_STEPS)


def _flow_from_pressure(
    problem: _Problem,
    solved: _Solved,
    part: NDArray[np.bool_],
    pixel: tuple[float, float],
    scale: float,
    sheared: float,
) -> Flow:
    """Return the flow of a solution in units of the scale of g³ [m³]."""
    axis = problem.axis
    sides = [edge * points for edge, points in zip(pixel, part.shape, strict=True)]
    unbalanced = float(np.abs(solved.net_flow(problem)).sum()) / solved.power
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
        axis,
        (permeability[0], permeability[1]),
        pressure,
        density,
        sheared,
        unbalanced,
        solved.steps,
        problem.network.nodes,
    )


def _sheared_gap(problem: _Problem, solved: _Solved, gap: Array, cube: Array) -> float:
    """Return the sum of gap times pressure drop along the flow, over links and sides [m].

    The pressure drop of a link is split between its two pixels in the ratio of 1/g³.
    """
    network, along = problem.network, problem.along == problem.axis
    first, second = network.first[along], network.second[along]
    drop = solved.through[along] / network.conductance[along] * problem.forward[along]
    middle = gap[first] * cube[second] + gap[second] * cube[first]
    total = _dot(drop, middle / (cube[first] + cube[second]))
    for flow, side in ((solved.inflow, problem.inlet), (solved.outflow, problem.outlet)):
        joined = side > 0
        total += _dot(flow[joined] / side[joined], gap[joined])
    return total


def _amount(
    problem: _Problem, solved: _Solved, forward: Array, pixel: tuple[float, float]
) -> Array:
    """Return the magnitude of the flow density at the nodes, from means over the faces."""
    network = problem.network
    square = np.zeros(network.nodes)
    for axis in (0, 1):
        along = problem.along == axis
        flow = forward[along]
        index = np.bincount(network.first[along], flow, network.nodes).astype(
            np.float64, copy=False
        )
        index += np.bincount(network.second[along], flow, network.nodes)
        if axis == problem.axis:
            index += solved.inflow + solved.outflow
        index /= 2 * pixel[1 - axis]
        square += index * index
    return np.sqrt(square)


def _dot(first: Array, second: Array) -> float:
    # Not by BLAS, whose last digits depend on the number of threads.
    return float(np.einsum("i,i->", first, second))


STANDARD_TEMPERATURE, STANDARD_PRESSURE = 273.15, 101325.0
"""Standard state [K], [Pa] of a cubic centimeter: 0 °C and one atmosphere (SEMI E12)."""

# Test pressures [Pa] of the classes of leak rates of helium, with a margin of 1 %: 1 bar or one
# atmosphere at the inlet, at most 1 mbar at the outlet (Rottländer, Umrath and Voss 2016).
_CLASS_INLET, _CLASS_OUTLET = (0.99e5, 1.01 * STANDARD_PRESSURE), 101.0

# Number of quadrature points over the land, and of points in the table of the potential.
_POINTS, _TABLE = 2, 4001


@dataclass(frozen=True)
class GasState:
    """Gas between two pressures."""

    name: str
    molar_mass: float  # M [kg/mol]
    viscosity: float  # η [Pa s]
    temperature: float  # T [K]
    inlet: float  # Absolute inlet pressure [Pa]
    outlet: float  # Absolute outlet pressure [Pa]

    @property
    def mean_pressure(self) -> float:
        """Mean of the pressures at inlet and outlet [Pa]."""
        return (self.inlet + self.outlet) / 2

    @property
    def has_leak_class(self) -> bool:
        """Whether leak classes hold: helium from 1 bar or an atmosphere into vacuum, 1 mbar."""
        low, high = _CLASS_INLET
        is_test = low <= self.inlet <= high and self.outlet <= _CLASS_OUTLET
        return self.name == "helium" and is_test

    def knudsen(self, gap: float, pressure: float) -> float:
        """Return the Knudsen number Kn = λ/g."""
        return mean_free_path(self.viscosity, pressure, self.molar_mass, self.temperature) / gap

    def mobility(self, gap: Array | float, pressure: Array | float) -> Array:
        """Return the mobility G: the flow over the flow of a viscous gas."""
        rarefaction = math.sqrt(math.pi) / 2 * gap * pressure / self.knudsen(1.0, 1.0)
        return 6 * channel_flow(rarefaction) / rarefaction

    def throughput_in(self, unit: str) -> float:
        """Return the throughput of one Pa m³/s of this gas in another unit."""
        warmth = STANDARD_TEMPERATURE / self.temperature
        return {
            "Pa m³/s": 1.0,
            "mbar l/s": 10.0,
            "kg/s": self.molar_mass / (GAS_CONSTANT * self.temperature),
            "sccm": 60e6 * warmth / STANDARD_PRESSURE,
        }[unit]


def gas_factor(
    gap: Array,
    pixel: tuple[float, float],
    viscous: Flow,
    narrowest: float,
    state: GasState,
    periodic_axes: tuple[int, ...] = (),
    points: int = _POINTS,
) -> float:
    """Return the throughput of a gas over its throughput in purely viscous flow."""
    pressures = np.geomspace(state.outlet, state.inlet, _TABLE)
    # dΦ = p G dp = p² G d(ln p)
    slope = pressures**2 * state.mobility(narrowest, pressures)
    step = math.log(state.inlet / state.outlet) / (_TABLE - 1)
    potential = np.concatenate([[0.0], np.cumsum((slope[1:] + slope[:-1]) / 2 * step)])
    rise = float(potential[-1])

    def relative(part: Array, pressure: Array) -> Array:
        return state.mobility(part, pressure) / state.mobility(narrowest, pressure)

    axis = viscous.axis
    if axis in periodic_axes:
        nodes, weights = np.polynomial.legendre.leggauss(points)
        conducted = 0.0
        for pressure, weight in zip(
            np.interp((nodes + 1) / 2 * rise, potential, pressures), weights / 2, strict=True
        ):
            wide = gap.copy()
            wide[gap > 0] *= np.cbrt(relative(gap[gap > 0], pressure))
            conducted += weight * flow(wide, pixel, axis, periodic_axes).permeability[axis]
    else:
        there = gap[np.isfinite(viscous.pressure)]

        def mobility(fallen: Array) -> Array:
            return relative(there, np.interp(np.clip(fallen, 0, 1) * rise, potential, pressures))

        conducted = flow(gap, pixel, axis, periodic_axes, mobility).permeability[axis]
    viscous_rise = state.mean_pressure * (state.inlet - state.outlet)
    return float(conducted * rise / (viscous.permeability[axis] * viscous_rise))
