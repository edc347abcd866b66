"""Leakage through the gap of a contact, and its flow factors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import starmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import statistics
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.statistics import Mean
from roughcontact.analyses.conductance.model import ATMOSPHERE, slip_factor, temperature_or_room
from roughcontact.analyses.leak.flow import (
    Constriction,
    Flow,
    GasState,
    constriction,
    flow,
    flow_gap,
    gas_factor,
)
from roughcontact.analyses.leak.fluid_load import (
    fluid_pressure,
    integrate_pressure,
    nominal_contact,
)
from roughcontact.cautions import Caution, CautionTag, as_caution, as_note, as_warning
from roughcontact.contact import series
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.errors import ArgumentRef, InputError, input_error
from roughcontact.halfspace.fft import Workspace
from roughcontact.material import fluids
from roughcontact.theory.rarefied_gas import mean_free_path
from roughcontact.units import Quantity, format_change, format_engineering, format_percent

THRESHOLD = 0.42
"""Contact fraction at the percolation threshold of isotropic self-affine contact.

Dapp, Lücke, Persson and Müser 2012, doi:10.1103/PhysRevLett.108.244301.
"""

# Distance from the threshold within which a few constrictions determine the leak rate.
_THRESHOLD_DISTANCE = 0.1

_GRID_TOLERANCE = 0.1

MIN_FLUID_SHARE = 0.005
"""Share of the load above which the load on the fluid is subtracted from the load."""

LEAK_CLASSES = (
    (1e-11, "technically tight"),
    (1e-9, "tight against the smallest viruses"),
    (1e-8, "gas-tight"),
    (1e-7, "virus-tight"),
    (1e-6, "oil-tight"),
    (1e-5, "bacteria-tight"),
    (1e-4, "vapor-tight"),
    (1e-3, "watertight"),
)
"""Leak classes: maximum throughput [Pa m³/s] and name, from the tightest on.

Rottländer, Umrath and Voss 2016, Fundamentals of leak detection, Leybold, cat. no. 199 79: common
classes for helium from one bar into vacuum; 1 Pa m³/s is 10 mbar l/s.
"""

MIN_GAS_GAP = 5e-5
"""Viscosity [Pa s] below which a fluid is a gas (9 to 35 µPa s; liquids 200 or more)."""

# Slip factor of helium above which slip has a caution; Knudsen number above which, a warning.
_SLIPS, _RAREFIED = 1.05, 0.05


def step_cautions(result: ContactResult, closed: bool) -> Iterator[Caution]:
    """Yield the cautions on the leakage of one contact, with a closed or an open gap."""
    if result.counter_surface is None:
        yield series.ONE_ROUGH_FACE
    if not result.contact.any():
        yield as_note(
            CautionTag.OPEN_GAP, "Bodies do not touch: this is the flow through an open gap."
        )
    fraction = result.contact_fraction
    if not closed and abs(fraction - THRESHOLD) < _THRESHOLD_DISTANCE:
        yield as_caution(
            CautionTag.NEAR_THRESHOLD,
            f"{100 * fraction:.0f} % contact is near the {100 * THRESHOLD:.0f} % sealing "
            "threshold: one constriction decides. Expect large scatter between maps.",
            contact_fraction=fraction,
        )


def slip_caution(
    gap: NDArray[np.float64], flows: Sequence[Flow], viscosity: float, pressure_difference: float
) -> Iterator[Caution]:
    """Yield the caution on excess leakage of gases by slip, for helium and air."""
    open_flows = [flow for flow in flows if flow.percolates]
    if viscosity >= MIN_GAS_GAP or not open_flows:
        return

    def largest_factor(name: str, pressure: float) -> float:
        path = mean_free_path(viscosity, pressure, fluids.gas(name).molar_mass.value)
        return max(slip_factor(gap, flow.density, path) for flow in open_flows)

    # At the mean pressure with the outlet at atmospheric pressure, and in vacuum.
    air = largest_factor("air", ATMOSPHERE + pressure_difference / 2)
    helium = largest_factor("helium", pressure_difference / 2)
    if helium < _SLIPS:
        return
    # Knudsen number of the plane gap with the same slip factor.
    knudsen = (air - 1) / 6
    yield (as_warning if knudsen > _RAREFIED else as_caution)(
        CautionTag.RAREFIED,
        f"Gas slips (Kn {knudsen:.2g}): air leaks at least {air:.2g} times this rate, helium into "
        f"vacuum {helium:.2g} times.",
        knudsen=knudsen,
        air=air,
        helium=helium,
    )


def fluid_load_caution(fluid_load: float, load: float) -> Iterator[Caution]:
    """Yield the caution on a fluid that carries a share of the load."""
    share = fluid_load / load if load > 0 else math.inf
    if share > MIN_FLUID_SHARE:
        yield as_caution(
            CautionTag.FLUID_PRESSURE,
            f"Fluid pressure carries {format_percent(min(share, 1.0))} of the load and opens the "
            "gap. Solve under the rest of the load.",
            share=share,
        )


def grid_caution(changes: tuple[float, float]) -> Iterator[Caution]:
    """Yield the caution on permeabilities that change on a grid of twice the pixel."""
    worst: float = max(
        (change for change in changes if not math.isnan(change)), key=abs, default=0.0
    )
    if abs(worst) > _GRID_TOLERANCE:
        yield as_caution(
            CautionTag.LEAK_PIXEL,
            f"Leak rate changes by {format_change(worst)} on a grid of twice the pixel: narrowest "
            "gaps are not resolved.",
            change=worst,
        )


LEAKAGE_NAME = "the leakage of a contact"
"""Name of the analysis in messages on missing maps."""

AXES = ("y", "x")
"""Names of the flow directions by axis."""


@dataclass(frozen=True)
class Seal:
    """Fluid, pressure difference and sealing face."""

    viscosity: float  # η [Pa s]
    pressure_difference: float  # From inlet to outlet [Pa]
    width: float | None = None  # Width of the face, across the flow [m]
    length: float | None = None  # Length of the face, along the flow [m]
    ring: float | None = None  # Mean diameter of a ring-shaped face [m]
    gas: GasState | None = None  # None for a liquid, and for a gas that is treated as viscous

    @property
    def is_whole(self) -> bool:
        """Whether the width of the face is known, so that the rate is that of the whole seal."""
        return self.ring is not None or self.width is not None

    def excess(self, potential: Array) -> Array:
        """Return the excess over the outlet pressure [Pa] of a potential, 1 at the inlet."""
        if self.gas is None:
            return self.pressure_difference * potential
        inlet, outlet = self.gas.inlet, self.gas.outlet
        return np.sqrt(outlet**2 + potential * (inlet**2 - outlet**2)) - outlet

    @property
    def mean_pressure(self) -> float:
        """Mean excess of the pressure over the outlet pressure [Pa], for a viscous fluid."""
        if self.gas is None:
            return self.pressure_difference / 2
        inlet, outlet = self.gas.inlet, self.gas.outlet
        # p² falls linearly along the land.
        return 2 / 3 * (inlet**3 - outlet**3) / (inlet**2 - outlet**2) - outlet

    def face_dimensions(self, size: tuple[float, float], axis: int) -> tuple[float, float]:
        """Return width and length of the face [m], by default from the map size (y, x)."""
        length = size[axis] if self.length is None else self.length
        if self.ring is not None:
            # Radial flow: the logarithm of outer over inner radius is 2 artanh(l/d).
            return math.pi * length / math.atanh(length / self.ring), length
        return size[1 - axis] if self.width is None else self.width, length


@dataclass(frozen=True)
class LeakageStep:
    """Permeability of the gap under one load; pairs are along (y, x)."""

    load: float  # W [N]
    contact_area: float  # Real contact area [m²]
    saturated_area: float  # Area at the ceiling [m²]
    mean_gap: float  # ū [m], over the whole map
    permeability: tuple[tuple[float, float], tuple[float, float]]  # [m³]
    constriction: tuple[Constriction | None, Constriction | None]
    unbalanced: float  # Larger relative imbalance of the two flows
    steps: int  # Solver steps of both flows
    gas_factor: tuple[float, float] = (1.0, 1.0)  # Gas flow over viscous flow
    sheared_gap: tuple[float, float] = (math.nan, math.nan)  # Mean of g ∂p per unit gradient [m]
    inverse_gap: float = math.nan  # Mean of 1/g where g exceeds σ/100 [1/m]
    fluid_load: float = 0.0  # Load that the fluid carries in the nominal contact [N]
    solid_load: float = math.nan  # Load of the contact pressure [N], below the load if solved wet


@dataclass(frozen=True)
class Change:
    """Change of the results on a coarser grid."""

    pixel: float  # Larger pixel edge of the coarser grid [m]
    permeability: tuple[float, float]  # Relative changes of k along y and x


@dataclass(frozen=True, eq=False, repr=False)
class Leakage(series.StepResult):
    """Permeability, flow factors and leak rate of a contact under one load or several.

    Parameters
    ----------
    steps : tuple of LeakageStep
        By ascending load.
    axes : tuple of int
        Flow axes: 0 along y, 1 along x.
    roughness : float
        Root-mean-square height σ of the gap before contact [m].
    seal : Seal or None
        Seal of the leak rate.
    largest : ContactResult
        The contact under the largest load.
    flows : tuple of Flow
        Pressure and flow density of the gap under the largest load, one flow per direction.
    messages : tuple of Caution
        Cautions on the contacts.
    extra_cautions : tuple of Caution
        Remarks on the measurement of the maps.
    coarser : Change or None
        Change of the results under the largest load on a coarser grid, if known; see
        `with_coarser_grid`.
    calibrated : CalibratedChange or None
        Change of the permeabilities along y and x under the calibrated ceiling, if known; see
        `with_calibrated_ceiling`.
    draws : tuple of Mean
        Permeability along y and x [m³] under the largest load over pairs of faces, times the
        factor of a gas; see `with_draws`.
    base : Leakage, optional
        The same contacts under the ceiling of the base of a coated body, if both ceilings were
        requested.
    """

    steps: tuple[LeakageStep, ...]
    axes: tuple[int, ...]
    roughness: float
    seal: Seal | None
    largest: ContactResult
    flows: tuple[Flow, ...]
    messages: tuple[Caution, ...] = ()
    extra_cautions: tuple[Caution, ...] = ()
    coarser: Change | None = None
    calibrated: series.CalibratedChange | None = None
    draws: tuple[Mean, ...] = ()
    base: Leakage | None = None

    def with_draws(self, others: Sequence[Leakage]) -> Leakage:
        """Return the mean of this and other pairs of faces under the same loads."""
        every = (self, *others)
        steps = tuple(map(_mean_step, zip(*(item.steps for item in every), strict=True)))
        flows = np.array([flow_of(item.steps[-1]) for item in every])
        draws = tuple(statistics.mean_with_interval(flows[:, axis]) for axis in (0, 1))
        return replace(self, steps=steps, draws=draws)

    @property
    def nominal_area(self) -> float:
        """Area of the whole map [m²]."""
        return math.prod(self.largest.pair.size)

    def with_calibrated_ceiling(self, contact: ContactResult) -> Leakage:
        """Return the leakage with its change under the calibrated ceiling.

        Parameters
        ----------
        contact : ContactResult
            The same bodies under the largest load and the calibrated ceiling.
        """
        step, _ = _step(contact, self.axes, self.seal)
        area = self.steps[-1].contact_area
        change = series.CalibratedChange.from_contact(contact, area, *self._changes(step))
        return replace(self, calibrated=change)

    def with_coarser_grid(self, coarser: ContactResult) -> Leakage:
        """Return the leakage with its change on a coarser grid.

        Parameters
        ----------
        coarser : ContactResult
            The same bodies under the largest load on a grid of larger pixels.
        """
        step, _ = _step(coarser, self.axes, self.seal)
        change = Change(max(coarser.pair.pixel), self._changes(step))
        change_of = grid_caution(change.permeability)
        return replace(self, coarser=change, messages=(*self.messages, *change_of))

    def with_axis(self, other: Leakage) -> Leakage:
        """Return this leakage along y with that along x, of contacts under another fluid pressure.

        Areas and gaps are those of this leakage.
        """
        steps = tuple(starmap(_join_axes, zip(self.steps, other.steps, strict=True)))
        changes = {
            name: replace(mine, **{key: _join(getattr(mine, key), getattr(yours, key))})
            for name, key in (("coarser", "permeability"), ("calibrated", "numbers"))
            if (mine := getattr(self, name)) and (yours := getattr(other, name))
        }
        messages = (*self.messages, *(m for m in other.messages if m not in self.messages))
        axes, flows = (0, 1), (*self.flows, *other.flows)
        return replace(self, steps=steps, axes=axes, flows=flows, messages=messages, **changes)

    def _changes(self, step: LeakageStep) -> tuple[float, float]:
        """Return the relative change of the flow along y and x at a step."""
        along_y, along_x = map(series.relative_change, flow_of(step), flow_of(self.steps[-1]))
        return along_y, along_x

    @property
    def fluid_share(self) -> Array:
        """Share of the load that the fluid carries, shape (n,); 0 without a fluid."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.column("fluid_load") / self.column("load")

    @property
    def fluid_load(self) -> Array:
        """Part of the load that was subtracted for the fluid [N], shape (n,)."""
        return self.column("load") - self.column("solid_load")

    def permeability(self, axis: int, along: int | None = None) -> Array:
        """Return the permeability k of all steps [m³], shape (n,).

        Parameters
        ----------
        axis : {0, 1}
            Direction of the flow: 0 y, 1 x.
        along : {0, 1}, optional
            Direction of the pressure gradient; by default the direction of the flow.
        """
        other = axis if along is None else along
        return np.array([step.permeability[axis][other] for step in self.steps])

    def flow_factor(self, axis: int) -> Array:
        """Return the pressure-flow factor φ = k/ū³ of Patir and Cheng, shape (n,).

        The factor is 1 for smooth plates with the same mean gap.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.permeability(axis) / self.column("mean_gap") ** 3

    def shear_flow_factor(self, axis: int) -> Array:
        """Return the shear-flow factor φ_s of Patir and Cheng, shape (n,).

        Sliding of the smooth face at U adds U (ū - σ φ_s)/2 to the mean flow per width, sliding of
        the rough face U (ū + σ φ_s)/2. NaN if both faces are rough.
        """
        if self.largest.counter_surface is not None:
            return np.full(len(self.steps), math.nan)
        sheared = np.array([step.sheared_gap[axis] for step in self.steps])
        return (self.column("mean_gap") - sheared) / self.roughness

    @property
    def shear_stress_factor(self) -> Array:
        """Shear-stress factor φ_f = ū ⟨1/g⟩ of Patir and Cheng, g > σ/100, shape (n,).

        The mean shear stress of the fluid is η U φ_f/ū; closed points contribute zero.
        """
        return self.column("mean_gap") * self.column("inverse_gap")

    @property
    def gap_ratio(self) -> Array:
        """Mean gap over root-mean-square height ū/σ, shape (n,)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.column("mean_gap") / self.roughness

    def critical_gap(self, axis: int) -> Array:
        """Return the gap at the narrowest constriction [m], shape (n,); 0 without open path."""
        places = (step.constriction[axis] for step in self.steps)
        return np.array([0.0 if place is None else place.gap for place in places])

    def rate(self, axis: int) -> Array:
        """Return the leak rate k Δp w/(12 η l) [m³/s], shape (n,); NaN without a fluid.

        For a gas this is the volume at the mean of inlet and outlet pressure; slip is included for
        a named gas.
        """
        if self.seal is None:
            return np.full(len(self.steps), math.nan)
        width, length = self.seal.face_dimensions(self.largest.pair.size, axis)
        driven = self.seal.pressure_difference * width / (12 * self.seal.viscosity * length)
        factor = np.array([step.gas_factor[axis] for step in self.steps])
        return self.permeability(axis) * factor * driven

    def throughput(self, axis: int, unit: str = "Pa m³/s") -> Array:
        """Return the leak rate p V of a named gas, shape (n,); NaN without one.

        Parameters
        ----------
        axis : {0, 1}
            Direction of the flow: 0 y, 1 x.
        unit : {"Pa m³/s", "mbar l/s", "kg/s", "sccm"}
            Unit of the rate; a standard cubic centimeter has 0 °C and 101,325 Pa.
        """
        gas = None if self.seal is None else self.seal.gas
        factor = math.nan if gas is None else gas.mean_pressure * gas.throughput_in(unit)
        return self.rate(axis) * factor

    @property
    def leak_class(self) -> tuple[str, float] | None:
        """Class of the larger gas leak rate under the largest load, and its limit [Pa m³/s].

        A class applies to a whole seal, and to helium from one bar into vacuum: None if the width
        of the face is not known, and for other gases and pressures.
        """
        seal = self.seal
        if seal is None or not seal.is_whole or seal.gas is None or not seal.gas.has_leak_class:
            return None
        leaks = (self, *([] if self.base is None else [self.base]))
        rate = max(leak.throughput(axis)[-1] for leak in leaks for axis in self.axes)
        known = ((name, limit) for limit, name in LEAK_CLASSES if rate < limit)
        return next(known, ("not watertight", math.inf))


@validate_arguments
def leakage(
    contacts: ContactResult | Iterable[ContactResult],
    *,
    flow_axis: str | None = None,
    viscosity: Quantity | None = None,
    pressure_difference: Quantity | None = None,
    seal_width: Quantity | None = None,
    seal_length: Quantity | None = None,
    ring: Quantity | None = None,
    gas: str | None = None,
    inlet: Quantity | None = None,
    outlet: Quantity | None = None,
    temperature: Quantity | None = None,
) -> Leakage:
    """Return leak rate, permeability and flow factors of the gap of a contact.

    Parameters
    ----------
    contacts : ContactResult or iterable of ContactResult
        Solutions of one pair of bodies under one or several loads; an iterator needs memory for
        one at a time.
    flow_axis : {"y", "x"}, optional
        Axis of the flow; by default both, separately.
    viscosity : float, str or quantity of pint, optional
        η of the fluid [Pa s].
    pressure_difference : float, str or quantity of pint, optional
        Pressure difference between inlet and outlet [Pa].
    seal_width, seal_length : float, str or quantity of pint, optional
        Dimensions of the sealing face across and along the flow [m]; by default the map size.
    ring : float, str or quantity of pint, optional
        Mean diameter of a ring-shaped sealing face [m], instead of its width.
    gas : {"air", "nitrogen", "helium", "argon"}, optional
        Gas that leaks, instead of viscosity and pressure difference.
    inlet, outlet : float, str or quantity of pint, optional
        Absolute pressures of the gas [Pa].
    temperature : float, str or quantity of pint, optional
        Temperature of the gas [K], by default 25 °C.

    Returns
    -------
    Leakage
        Permeability, flow factors, narrowest constriction and leak rate under each load.

    Raises
    ------
    InputError
        If a quantity is not positive, only one of viscosity and pressure difference is given, a
        gas has no pressures, the outlet is not below the inlet, the axis is unknown, a nominal body
        has a length of the face, the contacts belong to different maps, or the bodies are profiles.
    ConvergenceError
        As for `roughcontact.analyses.leak.flow.flow`.

    Notes
    -----
    Reynolds' equation for a thin film at rest, ∇·(g³ ∇p) = 0, where the bodies do not touch; there
    is no flow through contact, and the fluid does not deform the bodies. Along a periodic axis the
    pressure falls by the same amount over each period; along a free axis the pressure is given on
    the two sides of the map. An open path is searched first: without one there is no flow.

    The leak rate of a liquid is k Δp w/(12 η l). For an isothermal ideal gas, this is the volume at
    the mean of both pressures, as p ∇p is ∇p²/2. If the gap is not much wider than the mean free
    path, the gas slips and the rate is higher: a caution gives the factor, see
    `roughcontact.analyses.conductance.model.slip_factor`. The flow of a named ``gas`` is computed
    from viscous to free molecular, by the local Knudsen number: see
    `roughcontact.analyses.leak.flow`.

    The fluid carries a share of the load where the smooth forms of the bodies touch, and on the
    whole map without a nominal body; a caution shows this share from 5 % on.

    References
    ----------
    Patir and Cheng 1978, J. Lubr. Technol. 100, 12, doi:10.1115/1.3453103: flow factors, there over
    the distance of the mean planes, here over the mean gap, as required by the continuity of flow

    Patir and Cheng 1979, J. Lubr. Technol. 101, 220, doi:10.1115/1.3453329: sliding. The flow that
    is dragged along by a sliding face follows from the pressure flow by reciprocity.

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
    axes = flow_axes(flow_axis)
    supply = gas, inlet, outlet, temperature
    seal = seal_of(viscosity, pressure_difference, seal_width, seal_length, ring, *supply)

    def evaluate(result: ContactResult) -> tuple[LeakageStep, Iterator[Caution], tuple[Flow, ...]]:
        require_land(seal, result.pair, axes)
        step, flows = _step(result, axes, seal)
        return step, _step_messages(result, step, flows, axes, seal), flows

    steps, judged, largest, flows = series.evaluate_contacts(contacts, LEAKAGE_NAME, evaluate)
    roughness = float(np.nanstd(largest.pair.initial_gap))
    return Leakage(steps, axes, roughness, seal, largest, flows, judged)


def _step_messages(
    result: ContactResult,
    step: LeakageStep,
    flows: tuple[Flow, ...],
    axes: tuple[int, ...],
    seal: Seal | None,
) -> Iterator[Caution]:
    """Yield the cautions on the leakage of one contact."""
    yield from step_cautions(result, None in [step.constriction[axis] for axis in axes])
    if seal is None:
        return
    if step.load == step.solid_load:
        yield from fluid_load_caution(step.fluid_load, step.load)
    if seal.gas is None:
        yield from slip_caution(flow_gap(result), flows, seal.viscosity, seal.pressure_difference)


def flow_of(step: LeakageStep) -> tuple[float, float]:
    """Return the permeability along y and x times the factor of a gas [m³]."""
    along_y, along_x = (step.permeability[axis][axis] * step.gas_factor[axis] for axis in (0, 1))
    return along_y, along_x


def _mean_step(steps: Sequence[LeakageStep]) -> LeakageStep:
    mean = series.mean_step(steps, ("constriction", "gas_factor"))
    # Average the flows of the pairs, not their factors.
    flows = np.mean([flow_of(step) for step in steps], axis=0)
    along_y, along_x = (
        float(flow / mean.permeability[axis][axis]) if mean.permeability[axis][axis] else 1.0
        for axis, flow in enumerate(flows)
    )
    return replace(mean, gas_factor=(along_y, along_x))


_MIN_FILM_RATIO = 100.0
"""σ over the thinnest film with shear stress (Patir and Cheng 1979)."""


def _step(
    result: ContactResult, axes: tuple[int, ...], seal: Seal | None
) -> tuple[LeakageStep, tuple[Flow, ...]]:
    gap, pixel = flow_gap(result), result.pair.pixel
    periodic_axes = result.boundary.periodic_axes
    found: dict[int, Flow] = {}
    places: list[Constriction | None] = [None, None]
    factors = [1.0, 1.0]

    def solve(axis: int) -> None:
        found[axis] = viscous = flow(gap, pixel, axis, periodic_axes)
        place = constriction(gap, axis, periodic_axes) if viscous.percolates else None
        places[axis] = place
        if place is not None and seal is not None and seal.gas is not None:
            factors[axis] = gas_factor(gap, pixel, viscous, place.gap, seal.gas, periodic_axes)

    Workspace().each(solve, axes)
    flows = tuple(found[axis] for axis in axes)
    tensor = np.full((2, 2), math.nan)
    sheared = [math.nan, math.nan]
    for answer in flows:
        tensor[:, answer.axis] = answer.permeability
        sheared[answer.axis] = answer.sheared_gap
    thinnest = float(np.nanstd(result.pair.initial_gap)) / _MIN_FILM_RATIO
    step = LeakageStep(
        load=result.total_load,
        contact_area=result.contact_area,
        saturated_area=result.saturated_fraction * result.pressure.size * result.pixel_area,
        mean_gap=result.mean_gap,
        permeability=(tuple(tensor[0].tolist()), tuple(tensor[1].tolist())),
        constriction=(places[0], places[1]),
        unbalanced=max(result.unbalanced for result in flows),
        steps=sum(result.steps for result in flows),
        gas_factor=(factors[0], factors[1]),
        sheared_gap=(sheared[0], sheared[1]),
        inverse_gap=float((1 / gap[gap > thinnest]).sum() / gap.size),
        fluid_load=_fluid_load(result, flows, seal),
        solid_load=result.load,
    )
    return step, flows


def _fluid_load(result: ContactResult, flows: tuple[Flow, ...], seal: Seal | None) -> float:
    """Return the load that the fluid carries between the bodies [N], of the axis with the most."""
    if seal is None:
        return 0.0
    if result.fluid_load:
        return result.fluid_load
    contact = nominal_contact(result.pair, result.load, result.ceiling) if result.load else None
    fields = (
        fluid_pressure(result, solved, seal.mean_pressure, seal.excess, contact) for solved in flows
    )
    return max(integrate_pressure(pressure, result.pair) for pressure in fields)


def _join(along_y: tuple[Any, ...], along_x: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the first of one pair (y, x) and the second of another."""
    return along_y[0], along_x[1]


def _join_axes(along_y: LeakageStep, along_x: LeakageStep) -> LeakageStep:
    """Return the step of both axes from two contacts under one load."""
    pairs: dict[str, Any] = {
        name: _join(getattr(along_y, name), getattr(along_x, name))
        for name in ("constriction", "gas_factor", "sheared_gap")
    }
    tensor = [_join(*rows) for rows in zip(along_y.permeability, along_x.permeability, strict=True)]
    return replace(
        along_y,
        **pairs,
        permeability=(tensor[0], tensor[1]),
        unbalanced=max(along_y.unbalanced, along_x.unbalanced),
        steps=along_y.steps + along_x.steps,
    )


def require_land(seal: Seal | None, pair: Pair, axes: tuple[int, ...]) -> None:
    """Raise `InputError` for the length of a land where the nominal body bounds the contact."""
    across = any(axis in pair.boundary.free_axes for axis in axes)
    if seal is not None and seal.length is not None and across and has_nominal_body(pair.origins):
        raise InputError(
            "is not valid with a nominal body: the load sets the length of its contact along the "
            "flow; leave it out",
            argument="seal_length",
        )


def flow_axes(direction: str | None) -> tuple[int, ...]:
    """Return the requested flow axes; by default both."""
    if direction is None:
        return 0, 1
    if direction not in AXES:
        raise input_error("flow_axis", direction, "must be 'y' or 'x', or left out for both")
    return (AXES.index(direction),)


def seal_of(
    viscosity: Quantity | None,
    pressure_difference: Quantity | None,
    seal_width: Quantity | None,
    seal_length: Quantity | None,
    ring: Quantity | None,
    gas: str | None,
    inlet: Quantity | None,
    outlet: Quantity | None,
    temperature: Quantity | None,
) -> Seal | None:
    """Return the seal; raise `InputError` if its description is incomplete."""
    specified = {
        "viscosity": (viscosity, "viscosity"),
        "pressure_difference": (pressure_difference, "pressure"),
        "seal_width": (seal_width, "length"),
        "seal_length": (seal_length, "length"),
        "ring": (ring, "length"),
        "inlet": (inlet, "pressure"),
        "outlet": (outlet, "pressure"),
    }
    known = {
        name: series.parse_positive(value, dimension, name)
        for name, (value, dimension) in specified.items()
        if value is not None
    }
    if not known and gas is None:
        return None
    face = known.get("seal_width"), known.get("seal_length"), known.get("ring")
    _check_ring(*face)
    if gas is None:
        for name in ("inlet", "outlet"):
            if name in known:
                raise InputError(f"needs {ArgumentRef('gas', 'helium')}", argument=name)
        _require(known, {"viscosity": "'1 mPa s'", "pressure_difference": "'1 bar'"})
        return Seal(known["viscosity"], known["pressure_difference"], *face)
    for name in ("viscosity", "pressure_difference"):
        if name in known:
            raise InputError(f"cannot be combined with {ArgumentRef('gas')}", argument=name)
    _require(known, {"inlet": "'2 bar'", "outlet": "'1 mbar'"})
    state = _gas_state(gas, known["inlet"], known["outlet"], temperature)
    return Seal(state.viscosity, state.inlet - state.outlet, *face, state)


def _gas_state(name: str, inlet: float, outlet: float, temperature: Quantity | None) -> GasState:
    gas = fluids.gas(name)
    if not outlet < inlet:
        ends = (format_engineering(pressure, "Pa") for pressure in (inlet, outlet))
        raise InputError(
            "must be below the inlet pressure, {}, got {}".format(*ends), argument="outlet"
        )
    warmth = temperature_or_room(temperature)
    return GasState(name, gas.molar_mass.value, gas.viscosity_at(warmth), warmth, inlet, outlet)


def _require(known: dict[str, float], examples: dict[str, str]) -> None:
    for name, example in examples.items():
        if name not in known:
            raise InputError(f"is needed for a leak rate, such as {example}", argument=name)


def _check_ring(width: float | None, length: float | None, ring: float | None) -> None:
    if ring is None:
        return
    if width is not None:
        raise InputError(f"cannot be combined with {ArgumentRef('ring')}", argument="seal_width")
    if length is not None and not length < ring:
        raise input_error("seal_length", length, "must be below the diameter of the ring")
