"""What leaks through the gap of a contact, and the flow factors of its roughness."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughcontact.arguments import checked
from roughcontact.contact.cautions import Caution, ordered
from roughcontact.contact.judgment import over_loads
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.joint import leakage_judgment
from roughcontact.joint.flow import Flow, flow
from roughcontact.joint.percolation import Constriction, constriction
from roughcontact.joint.series import of_one_pair
from roughcontact.result import Result
from roughcontact.units import Quantity, quantity

Array = NDArray[np.float64]

OF = "the leakage of a contact"
"""What needs a map, in words."""

AXES = ("y", "x")
"""Directions of the flow by the number of their axis."""


@dataclass(frozen=True)
class Seal:
    """A fluid, the pressure that drives it, and the face that it leaks through.

    Parameters
    ----------
    viscosity : float
        η [Pa s].
    pressure_difference : float
        From inlet to outlet [Pa].
    width, length : float or None
        Of the face, across the flow and along it [m]; ``None`` for those of the map.
    """

    viscosity: float
    pressure_difference: float
    width: float | None = None
    length: float | None = None


@dataclass(frozen=True)
class LeakageStep:
    """What the gap lets through under one load; pairs are along (y, x).

    Parameters
    ----------
    load : float
        W [N].
    contact_area, saturated_area : float
        Real contact area, and that at the ceiling [m²].
    mean_gap : float
        ū [m], over all of the map; what touches counts as closed.
    permeability : ((float, float), (float, float))
        Tensor k [m³]: mean flow density g³ ∂p along the first index under a unit mean gradient
        along the second. 0 without a way through; NaN where it was not asked for, and across the
        gradient unless the map is periodic along both axes.
    constriction : (Constriction or None, Constriction or None)
        Narrowest place of the widest way along y and x; ``None`` without a way.
    unbalanced : float
        Larger of what the two flows lose or gain on the way, of what flows.
    steps : int
        Steps of the solver, both flows together.
    """

    load: float
    contact_area: float
    saturated_area: float
    mean_gap: float
    permeability: tuple[tuple[float, float], tuple[float, float]]
    constriction: tuple[Constriction | None, Constriction | None]
    unbalanced: float
    steps: int


@dataclass(frozen=True)
class Change:
    """How numbers change from one grid to a coarser one.

    Parameters
    ----------
    pixel : float
        Larger edge of its pixels [m].
    permeability : (float, float)
        Relative changes of k along y and x; NaN where nothing flows on either.
    """

    pixel: float
    permeability: tuple[float, float]


@dataclass(frozen=True, eq=False, repr=False)
class Leakage(Result):
    """Permeability, flow factors and leak rate of a contact under one load or several.

    Parameters
    ----------
    steps : tuple of LeakageStep
        By ascending load.
    axes : tuple of int
        Directions that were asked for: 0 along y, 1 along x.
    roughness : float
        Root-mean-square height σ of the gap before contact [m].
    seal : Seal or None
        What the leak rate is of.
    largest : ContactResult
        The contact under the largest load.
    flows : tuple of Flow
        Pressure and flow density of the gap under the largest load, one a direction.
    found : tuple of Caution
        What the contacts give cause for.
    remarks : tuple of Caution
        What else is known of the numbers, from the measurement of the maps.
    coarser : Change or None
        How the numbers under the largest load change on a coarser grid, where that is known; see
        `beside`.
    """

    steps: tuple[LeakageStep, ...]
    axes: tuple[int, ...]
    roughness: float
    seal: Seal | None
    largest: ContactResult
    flows: tuple[Flow, ...]
    found: tuple[Caution, ...] = ()
    remarks: tuple[Caution, ...] = ()
    coarser: Change | None = None

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        return ordered(dict.fromkeys([*self.found, *self.remarks]))

    @property
    def nominal_area(self) -> float:
        """Area of the whole map [m²]."""
        size = self.largest.pair.size
        return size[0] * size[1]

    def beside(self, coarser: ContactResult) -> Leakage:
        """Return the same with what changes on a coarser grid.

        Parameters
        ----------
        coarser : ContactResult
            The same bodies under the largest load on a grid of larger pixels.
        """
        step, _ = _step(coarser, self.axes)
        fine = self.steps[-1]
        changes = [math.nan, math.nan]
        for axis in self.axes:
            old, new = (one.permeability[axis][axis] for one in (fine, step))
            if old > 0:
                changes[axis] = new / old - 1
        change = Change(max(coarser.pair.pixel), (changes[0], changes[1]))
        told = leakage_judgment.grid(change.permeability, change.pixel)
        return replace(self, coarser=change, found=(*self.found, *told))

    def column(self, name: str) -> Array:
        """Return one number of all steps, shape (n,); see `LeakageStep`."""
        return np.array([getattr(step, name) for step in self.steps], dtype=float)

    def permeability(self, axis: int, along: int | None = None) -> Array:
        """Return k of all steps [m³], shape (n,).

        Parameters
        ----------
        axis : {0, 1}
            Direction of the flow: 0 y, 1 x.
        along : {0, 1}, optional
            Direction of the pressure gradient; by default that of the flow.
        """
        other = axis if along is None else along
        return np.array([step.permeability[axis][other] for step in self.steps])

    def flow_factor(self, axis: int) -> Array:
        """Return the pressure-flow factor φ = k/ū³ of Patir and Cheng, shape (n,).

        It is 1 for smooth plates with the same mean gap.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            factor: Array = self.permeability(axis) / self.column("mean_gap") ** 3
        return factor

    @property
    def film_ratio(self) -> Array:
        """Mean gap over root-mean-square height ū/σ, shape (n,)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio: Array = self.column("mean_gap") / self.roughness
        return ratio

    def critical_gap(self, axis: int) -> Array:
        """Return the gap at the narrowest place of the widest way [m], shape (n,); 0 without."""
        places = (step.constriction[axis] for step in self.steps)
        return np.array([0.0 if place is None else place.gap for place in places])

    def rate(self, axis: int) -> Array:
        """Return the leak rate k Δp w/(12 η l) [m³/s], shape (n,); NaN without a fluid.

        Of a gas it is the volume at the mean of the pressures at inlet and outlet.
        """
        if self.seal is None:
            return np.full(len(self.steps), math.nan)
        size = self.largest.pair.size
        width = size[1 - axis] if self.seal.width is None else self.seal.width
        length = size[axis] if self.seal.length is None else self.seal.length
        driven = self.seal.pressure_difference * width / (12 * self.seal.viscosity * length)
        rate: Array = self.permeability(axis) * driven
        return rate


@checked
def leakage(
    contacts: ContactResult | Iterable[ContactResult],
    *,
    direction: str | None = None,
    viscosity: Quantity | None = None,
    pressure_difference: Quantity | None = None,
    seal_width: Quantity | None = None,
    seal_length: Quantity | None = None,
) -> Leakage:
    """Return what leaks through the gap of a contact.

    Parameters
    ----------
    contacts : ContactResult or iterable of ContactResult
        Solutions of one pair of bodies under one load or several. One at a time is looked at, and
        that under the largest load is kept.
    direction : {"y", "x"}, optional
        Along which the fluid flows; by default both, one after the other.
    viscosity : float, str or quantity of pint, optional
        η of the fluid [Pa s].
    pressure_difference : float, str or quantity of pint, optional
        Between inlet and outlet [Pa].
    seal_width, seal_length : float, str or quantity of pint, optional
        Of the face that leaks, across the flow and along it [m], of which the map is a part; by
        default those of the map.

    Returns
    -------
    Leakage
        Permeability, flow factors, narrowest place and leak rate under each load.

    Raises
    ------
    InputError
        If a quantity is not positive, only one of viscosity and pressure difference is given, the
        direction is none, the contacts are of different maps, or the bodies are profiles.
    ConvergenceError
        As for `roughcontact.joint.flow.flow`.

    Notes
    -----
    Reynolds' equation for a thin film at rest, ∇·(g³ ∇p) = 0, where the bodies do not touch;
    nothing flows through contact, and the fluid does not push the bodies apart. Along an axis
    that is periodic the pressure falls by the same amount over each period; along a free one it
    is given on the two sides of the map. A way through is looked for first: without one nothing
    flows.

    A liquid leaks k Δp w/(12 η l). An ideal gas at one temperature leaks the same volume, counted
    at the mean of both pressures, as p ∇p is ∇p²/2. Where the gap is not much wider than the free
    path of its molecules it slips and leaks more: a caution tells by what factor, see
    `roughcontact.joint.filling.slip_factor`.

    References
    ----------
    Patir and Cheng 1978, J. Lubr. Technol. 100, 12, doi:10.1115/1.3453103: flow factors, there over
    the distance of the mean planes, here over the mean gap, which the continuity of flow asks for

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(64)
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> result = rc.solve(rc.Surface(heights, pixel), material=steel, load=1.0)
    >>> found = rc.leakage(result, viscosity="1 mPa s", pressure_difference="1 bar")
    >>> bool(found.rate(axis=0)[0] > 0)
    True
    """
    axes = _axes(direction)
    seal = seal_of(viscosity, pressure_difference, seal_width, seal_length)
    found: list[tuple[LeakageStep, tuple[Caution, ...]]] = []
    largest: ContactResult | None = None
    flows: tuple[Flow, ...] = ()
    for result in of_one_pair(contacts, OF):
        step, driven = _step(result, axes)
        own = [*leakage_judgment.of_step(result, step.constriction, axes)]
        if seal is not None:
            fluid = seal.viscosity, seal.pressure_difference
            own += leakage_judgment.slip(opened(result), driven, *fluid)
        found.append((step, (*result.cautions, *own)))
        if largest is None or result.load >= largest.load:
            largest, flows = result, driven
    assert largest is not None
    found.sort(key=lambda one: one[0].load)
    judged = over_loads([(step.load, cautions) for step, cautions in found], "N")
    steps = tuple(step for step, _ in found)
    roughness = float(np.nanstd(largest.pair.initial_gap))
    return Leakage(steps, axes, roughness, seal, largest, flows, judged)


def _step(result: ContactResult, axes: tuple[int, ...]) -> tuple[LeakageStep, tuple[Flow, ...]]:
    gap = opened(result)
    periodic_axes = result.boundary.periodic_axes
    flows = tuple(flow(gap, result.pair.pixel, axis, periodic_axes) for axis in axes)
    tensor = np.full((2, 2), math.nan)
    places: list[Constriction | None] = [None, None]
    for found in flows:
        tensor[:, found.axis] = found.permeability
        if found.percolates:
            places[found.axis] = constriction(gap, found.axis, periodic_axes)
    step = LeakageStep(
        load=result.load,
        contact_area=result.contact_area,
        saturated_area=result.saturated_fraction * result.pressure.size * result.pixel_area,
        mean_gap=result.mean_gap,
        permeability=(tuple(tensor[0].tolist()), tuple(tensor[1].tolist())),
        constriction=(places[0], places[1]),
        unbalanced=max(found.unbalanced for found in flows),
        steps=sum(found.steps for found in flows),
    )
    return step, flows


def opened(result: ContactResult) -> Array:
    """Return the gap that fluid may flow through [m], 0 where the bodies touch, shape (ny, nx)."""
    gap: Array = np.where(result.contact, 0.0, np.fmax(result.gap, 0.0))
    return gap


def _axes(direction: str | None) -> tuple[int, ...]:
    if direction is None:
        return 0, 1
    if direction not in AXES:
        raise InputError(
            f"must be 'y' or 'x', or left out for both, got {direction!r}",
            argument="direction",
            value=direction,
        )
    return (AXES.index(direction),)


def seal_of(
    viscosity: Quantity | None,
    pressure_difference: Quantity | None,
    seal_width: Quantity | None,
    seal_length: Quantity | None,
) -> Seal | None:
    """Return what leaks, or refuse what is only half of it."""
    given = {
        "viscosity": (viscosity, "viscosity"),
        "pressure_difference": (pressure_difference, "pressure"),
        "seal_width": (seal_width, "length"),
        "seal_length": (seal_length, "length"),
    }
    known = {
        name: _positive(value, dimension, name)
        for name, (value, dimension) in given.items()
        if value is not None
    }
    if not known:
        return None
    for name, example in (("viscosity", "'1 mPa s'"), ("pressure_difference", "'1 bar'")):
        if name not in known:
            raise InputError(f"is needed for a leak rate, such as {example}", argument=name)
    return Seal(
        known["viscosity"], known["pressure_difference"], known.get("seal_width"),
        known.get("seal_length"),
    )  # fmt: skip


def _positive(value: Quantity, dimension: str, argument: str) -> float:
    found = quantity(value, dimension, argument)
    if not (isinstance(found, (int, float)) and 0 < found < math.inf):
        raise InputError(
            f"must be positive and finite, got {value!r}", argument=argument, value=value
        )
    return float(found)
