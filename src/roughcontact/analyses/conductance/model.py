"""Electrical and thermal conductance of a contact.

`gap_conductance`: In parallel with the contact, whose conductance is computed without the gap.
Compared with contact and gap solved together on rough maps of up to a tenth in contact, the part
of the gap is 0.8 to 1.0 times as large with air, and 1.1 to 1.3 times with oil. For Gaussian gaps
this is the integral of Yovanovich 1982; for g far below the jump it is free-molecular conduction.

Yovanovich, DeVaal and Hegazy 1982, A statistical model to predict thermal gap conductance between
conforming rough surfaces, AIAA paper 82-0888, doi:10.2514/6.1982-888
Song, Yovanovich and Goodman 1993, J. Heat Transfer 115, 533, doi:10.1115/1.2910719

`slip_factor`: Slip of first order at walls that reflect diffusely: the flow through a gap g is
proportional to g³ (1 + 6 λ/g). The factor is the harmonic mean over the map, weighted by the
dissipation of the flow without slip, ``|q|²/g³``: exact for gaps in series, and a lower bound for
all others (Thomson's principle). The flow through rough gaps solved with slip is up to a sixth
larger; above λ/g of about one the true flow is larger still.

Burgdorfer 1959, J. Basic Eng. 81, 94

`greenwood`: Each spot is approximated by a circle with a current in proportion to its radius. For
two bodies of resistivity ρ each this is R = ρ/(2 Σ aᵢ) + ρ/(π (Σ aᵢ)²) ΣΣ aᵢ aⱼ/sᵢⱼ. It holds for
round spots that are further apart than they are wide, not for large spots of many branches. The
double sum is one convolution with the kernel of the contact, the center of each spot rounded to a
pixel.

Greenwood 1966, Constriction resistance and the real area of contact, Brit. J. Appl. Phys. 17,
1621, doi:10.1088/0508-3443/17/12/310
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import statistics
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.statistics import Mean
from roughcontact.cautions import Caution, CautionTag, as_caution, as_note, as_warning
from roughcontact.contact import series
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.contact.stiffness import constriction_length
from roughcontact.errors import ArgumentRef, InputError, input_error
from roughcontact.halfspace.coating import Coatings, ConductingLayer, ConductingStack
from roughcontact.halfspace.fft import Workspace
from roughcontact.material import catalog, fluids
from roughcontact.material.hardness import vickers_correlation
from roughcontact.material.material import Conductor, Layer
from roughcontact.surface import roughness
from roughcontact.surface.form import level
from roughcontact.theory import constriction
from roughcontact.theory.constriction import hottest_spot
from roughcontact.theory.rarefied_gas import jump_distance, mean_free_path
from roughcontact.units import Quantity, format_engineering, format_percent, to_si

ATMOSPHERE = 101325.0
"""Standard atmospheric pressure [Pa]."""

ROOM_TEMPERATURE, BAR = 298.15, 1e5
"""Default temperature [K] and pressure [Pa] of a gas."""

VACUUM = "vacuum"
"""Name of a gap without conductance."""

STEFAN_BOLTZMANN = 5.670374419e-8
"""Stefan-Boltzmann constant [W/(m² K⁴)]."""

TUNNEL_FILM = 1e-12
"""Resistance times area of a film of oxide or tarnish of few nanometers [Ω m²] (Holm 1967, §26)."""

MIN_OXIDE_SHARE = 0.1
"""Share of the resistance from which such a film gives a caution."""

NOBLE = ("gold", "hard gold")
"""Names of metals without such films in air."""

MIN_RADIATION_SHARE = 0.01
"""Share of the conductance above which radiation is reported."""

# Mean temperature of a unit square under unit flux on a half-space of unit conductivity.
_SQUARE = 2 / math.pi * (math.asinh(1) - (math.sqrt(2) - 1) / 3)


@dataclass(frozen=True)
class Filling:
    """Filling of a gap."""

    name: str
    conductivity: float  # Thermal conductivity k [W/(m K)]
    jump: float = 0.0  # Temperature-jump distance of both walls, added to the gap [m]


def filling_of(
    gap: Quantity, pressure: Quantity | None = None, temperature: Quantity | None = None
) -> Filling:
    """Return the filling of a gap from a fluid name, vacuum, or a conductivity [W/(m K)]."""
    if gap == VACUUM:
        return Filling(VACUUM, 0.0)
    fluid = fluids.entries().get(gap) if isinstance(gap, str) else None
    if fluid is None:
        if isinstance(gap, str) and not gap[:1].isdigit():
            known = ", ".join((*fluids.entries(), VACUUM))
            raise input_error("gap", gap, f"must be one of {known}, or a conductivity")
        conductivity = series.parse_positive(gap, "conductivity", "gap")
        return Filling(f"{conductivity:.4g} W/(m K)", conductivity)
    if isinstance(fluid, fluids.Liquid):
        return Filling(fluid.name, fluid.conductivity.value)
    warmth = temperature_or_room(temperature)
    press = series.parse_positive(BAR if pressure is None else pressure, "pressure", "gap_pressure")
    path = mean_free_path(fluid.viscosity_at(warmth), press, fluid.molar_mass.value, warmth)
    ratio, share = fluid.heat_capacity_ratio.value, fluid.accommodation.value
    jump = jump_distance(path, share, ratio, fluid.prandtl)
    return Filling(fluid.name, fluid.conductivity_at(warmth), jump)


def temperature_or_room(temperature: Quantity | None) -> float:
    """Return a temperature [K], by default room temperature."""
    given = ROOM_TEMPERATURE if temperature is None else temperature
    return series.parse_positive(given, "temperature", "temperature")


def gap_conductance(gap: Array, filling: Filling, spreading: float = 0.0) -> float:
    """Return the conductance of a filled gap per area [W/(m² K)] between isothermal faces."""
    there = gap[~np.isnan(gap)]
    with np.errstate(divide="ignore"):
        local = 1 / (np.divide(there + filling.jump, filling.conductivity) + spreading)
    return float(local.sum() / gap.size)


def spreading_resistance(pixel_area: float, resistivity: float) -> float:
    """Return the spreading resistance of two bodies to a uniform flux through one pixel."""
    return _SQUARE * math.sqrt(pixel_area) * resistivity


def slip_factor(gap: Array, density: NDArray[Any], path: float) -> float:
    """Return the leak rate of a gas with slip over the leak rate without slip."""
    open_gap = gap > 0
    g, q = gap[open_gap], density[open_gap].astype(np.float64)
    dissipated = q**2 / g**3
    total = dissipated.sum()
    if not total > 0:
        return math.nan
    return float(total / (dissipated / (1 + 6 * path / g)).sum())


CURVED = 0.75
"""Share of the gap variance in a quadric from which on bodies are treated as curved.

Of nine measured maps a mirror has 0.91 and the cylinder of a fired bullet 0.76; flat maps have less
than 0.6, parts of self-affine maps without a roll-off up to 0.73.
"""

DISCS = (0.8, 1.25)
"""Range of Greenwood's formula over the solution outside which spots are no discs.

The ratio is 0.82 to 1 on rough maps up to a tenth in contact.
"""


@dataclass(frozen=True, eq=False)
class Texture:
    """Roughness of the gap between two bodies, for the correlations of flat joints."""

    pair: Pair  # The bodies

    @cached_property
    def height(self) -> float:
        """Root-mean-square height σ of the gap [m]."""
        return float(np.nanstd(self.pair.initial_gap))

    @cached_property
    def gradient(self) -> float:
        """Root-mean-square gradient h′ of the gap."""
        return roughness.rms_gradient(self.pair.initial_gap, self.pair.pixel)

    @cached_property
    def curved(self) -> float:
        """Share of the gap variance in a quadric; 0 for a periodic map."""
        gap = self.pair.initial_gap
        if self.pair.boundary.periodic_axes or not self.height > 0 or min(gap.shape) < 3:
            return 0.0
        return 1 - float(np.nanvar(level(gap, "quadric"))) / self.height**2

    @property
    def is_flat(self) -> bool:
        """Whether the bodies are nominally flat, judged by the map."""
        return self.curved < CURVED


CASES = 108
"""Number of rough contacts in the test of the estimates, see `constriction.CORRELATION_RANGE`."""

GREENWOOD_RANGE = (0.82, 1.0)
"""Greenwood's formula over the solution, in 95 % of cases: lower for more contact."""


def greenwood(result: ContactResult) -> float:
    """Return the constriction length [m] of a contact from radii and centers of its spots."""
    spots = result.spots()
    if spots.count == 0:
        return math.nan
    radii = np.sqrt(spots.area / math.pi)
    pair = result.pair
    operator = pair.operators(result.precision, Workspace())(pair.shape, (1, 1))
    pressure = np.zeros(pair.shape)
    middle = _middles(spots, pair.boundary.periodic_axes)
    np.add.at(pressure.ravel(), middle, radii / result.pixel_area)
    near = pressure.ravel()[middle]
    # The first term is the self-interaction of a spot; its periodic images are in the kernel.
    alone = _self_displacement(pair.pixel, pair.contact_modulus)
    others = operator(pressure).ravel()[middle] - alone * near
    total = radii.sum()
    shared = (radii * others).sum() / total**2
    inverse = 1 / (4 * total) + pair.contact_modulus / 2 * shared
    return float(1 / inverse) if inverse > 0 else math.nan


def _middles(spots: Spots, periodic_axes: tuple[int, ...]) -> NDArray[np.int64]:
    """Return flat indices of the pixels nearest to the spot centers, shape (n,)."""
    shape = spots.label.shape
    places = np.nonzero(spots.label)
    number = spots.label[places] - 1
    count = np.bincount(number, minlength=spots.count)
    middle = []
    for axis, place in enumerate(places):
        if axis in periodic_axes:
            # Circular mean, because a spot may cross the periodic seam.
            turn = np.exp(2j * math.pi / shape[axis] * np.arange(shape[axis]))[place]
            total = np.bincount(number, turn.real) + 1j * np.bincount(number, turn.imag)
            mean = np.angle(total) / (2 * math.pi) * shape[axis]
        else:
            mean = np.bincount(number, place) / count
        middle.append(np.rint(mean).astype(np.int64) % shape[axis])
    return np.ravel_multi_index((middle[0], middle[1]), shape)


def _self_displacement(pixel: tuple[float, float], contact_modulus: float) -> float:
    """Return the displacement at the center of a single pixel under unit pressure."""
    dy, dx = pixel
    return 2 / (math.pi * contact_modulus) * (dx * math.asinh(dy / dx) + dy * math.asinh(dx / dy))


SUBJECT = "the resistance of a contact"
"""Name of the analysis in messages on missing maps."""

EVEN_FLOW = 32 / (3 * math.pi**2) - 1
"""Excess constriction of a disc at uniform flux over constant potential: 8.1 %.

Carslaw and Jaeger, Conduction of Heat in Solids (1959), section 8.2.
"""


@dataclass(frozen=True)
class ConductanceStep:
    """Conductances under one load, for bodies of any material."""

    load: float  # W [N]
    contact_area: float  # Real contact area [m²]
    saturated_area: float  # Area at the ceiling [m²]
    spots: int  # Number of contact spots
    length: float  # Constriction length of the whole contact, saturated points included [m]
    greenwood_length: float  # Constriction length by Greenwood's formula [m]
    correlation_length: float  # Constriction length by the correlations [m]
    air_gap: float = math.nan  # Conductance of the gap with air [W/(m² K)]
    oil_gap: float = math.nan  # Conductance of the gap with oil [W/(m² K)]
    filled_gap: float = 0.0  # Conductance of the gap with its filling [W/(m² K)]
    electrical_plating: float = 1.0  # Constriction with the layers of the bodies over without
    thermal_plating: float = 1.0  # The same of heat


@dataclass(frozen=True)
class Change:
    """Change of the results on a coarser grid."""

    pixel: float  # Larger pixel edge of the coarser grid [m]
    length: float  # Relative change of the constriction length
    contact_area: float  # Relative change of the contact area


@dataclass(frozen=True, eq=False, repr=False)
class Conductance(series.StepResult):
    """Electrical and thermal resistance of a contact under one load or several.

    Parameters
    ----------
    steps : tuple of ConductanceStep
        By ascending load.
    bodies : (Conductor, Conductor)
        Body and counter-body.
    film, thermal_film : float
        Resistance of a film on the contact times its area [Ω m²], [m² K/W].
    largest : ContactResult
        The contact under the largest load.
    messages : tuple of Caution
        Cautions on the contacts.
    extra_cautions : tuple of Caution
        Remarks on the measurement of the maps.
    coarser : Change or None
        Change of the results under the largest load on a coarser grid, if known; see
        `with_coarser_grid`.
    filling : Filling or None
        Filling of the gap.
    temperature : float
        Mean temperature of the joint [K].
    current : float or None
        Current through the contact [A].
    calibrated : CalibratedChange or None
        Change of the constriction length under the largest load under the calibrated ceiling, if
        known; see `with_calibrated_ceiling`.
    draws : tuple of Mean
        Constriction length under the largest load over pairs of faces; see `with_draws`.
    base : Conductance or None
        The same under the ceiling of the base of a coated body, if both were requested.
    """

    steps: tuple[ConductanceStep, ...]
    bodies: tuple[Conductor, Conductor]
    film: float
    thermal_film: float
    largest: ContactResult
    messages: tuple[Caution, ...] = ()
    extra_cautions: tuple[Caution, ...] = ()
    coarser: Change | None = None
    calibrated: series.CalibratedChange | None = None
    filling: Filling | None = None
    temperature: float = ROOM_TEMPERATURE
    current: float | None = None
    draws: tuple[Mean, ...] = ()
    base: Conductance | None = None

    def with_draws(self, others: Sequence[Conductance]) -> Conductance:
        """Return the mean of this and other pairs of faces under the same loads."""
        every = (self, *others)
        lengths = [item.steps[-1].length for item in every]
        steps = (
            series.mean_step(steps, ()) for steps in zip(*(x.steps for x in every), strict=True)
        )
        return replace(self, steps=tuple(steps), draws=(statistics.mean_with_interval(lengths),))

    def with_calibrated_ceiling(self, contact: ContactResult) -> Conductance:
        """Return the conductance with its change under the calibrated ceiling.

        Parameters
        ----------
        contact : ContactResult
            The same bodies under the largest load and the calibrated ceiling.
        """
        fine = self.steps[-1]
        length = series.relative_change(constriction_length(contact), fine.length)
        change = series.CalibratedChange.from_contact(contact, fine.contact_area, length)
        return replace(self, calibrated=change)

    def with_length(self, length: float) -> Conductance:
        """Return the conductance with another constriction length [m] under the largest load."""
        return replace(self, steps=(*self.steps[:-1], replace(self.steps[-1], length=length)))

    def with_coarser_grid(self, coarser: ContactResult) -> Conductance:
        """Return the conductance with its change on a coarser grid.

        Parameters
        ----------
        coarser : ContactResult
            The same bodies under the largest load on a grid of larger pixels.
        """
        fine, length = self.steps[-1], constriction_length(coarser)
        changes = (
            new / old - 1 if old and math.isfinite(old) else 0.0
            for new, old in ((length, fine.length), (coarser.contact_area, fine.contact_area))
        )
        return replace(self, coarser=Change(max(coarser.pair.pixel), *changes))

    @property
    def correlation_inputs(self) -> dict[str, float]:
        """Inputs of contact conductance in finite-element programs, of the softer body.

        ``sigma``: root-mean-square height of the gap [m]; ``slope``: mean absolute slope m along a
        profile; ``hardness`` [Pa], and ``c1`` [Pa] and ``c2`` of `hardness.vickers_correlation`,
        if they are known.
        """
        pair = self.largest.pair
        values = {
            "sigma": Texture(pair).height,
            "slope": roughness.mean_slope(pair.initial_gap, pair.pixel),
        }
        known = [body.hardness for body in (pair.material, pair.counter_material) if body.hardness]
        if known:
            values["hardness"] = min(known)
            values |= dict(zip(("c1", "c2"), vickers_correlation(min(known)) or (), strict=False))
        return values

    @property
    def nominal_area(self) -> float:
        """Area of the whole map [m²]."""
        return math.prod(self.largest.pair.size)

    @property
    def electrical_resistivity(self) -> float:
        """Sum of the resistivities of the two bodies [Ω m]; NaN if one is not known."""
        return _sum_resistivity(self.bodies, "electrical")

    @property
    def thermal_resistivity(self) -> float:
        """Sum of 1/k of the two bodies [m K/W]; NaN if one is not known."""
        return _sum_resistivity(self.bodies, "thermal")

    @property
    def electrical_resistance(self) -> Array:
        """Resistance of the contact [Ω], shape (n,): constriction and film in series."""
        return self.resistance("electrical")

    @property
    def thermal_resistance(self) -> Array:
        """Thermal resistance of the contact [K/W], shape (n,)."""
        return self.resistance("thermal")

    @property
    def electrical_conductance(self) -> Array:
        """Conductance of the contact per nominal area [S/m²], shape (n,)."""
        return self._per_area(self.electrical_resistance)

    @property
    def thermal_conductance(self) -> Array:
        """Conductance of the contact per nominal area h [W/(m² K)], shape (n,)."""
        return self._per_area(self.thermal_resistance)

    @property
    def joint_conductance(self) -> Array:
        """Conductance of contact and filled gap in parallel, per area [W/(m² K)], shape (n,)."""
        return self.thermal_conductance + self.column("filled_gap")

    @property
    def voltage(self) -> Array:
        """Contact voltage at the given current [V], shape (n,); NaN without one."""
        return self.electrical_resistance * (math.nan if self.current is None else self.current)

    @property
    def hottest(self) -> Array:
        """Temperature of the hottest spot at the given current [K], shape (n,)."""
        return np.array([hottest_spot(voltage, self.temperature) for voltage in self.voltage])

    @property
    def radiation(self) -> float:
        """Conductance of black faces by radiation, 4 σ T³, an upper bound [W/(m² K)]."""
        return 4 * STEFAN_BOLTZMANN * self.temperature**3

    def filled_conductance(self, filling: str) -> Array:
        """Return h of contact and filled gap in parallel [W/(m² K)], shape (n,).

        Parameters
        ----------
        filling : {"air", "oil"}
            Filling of the gap; see `ConductanceStep`.
        """
        return self.thermal_conductance + self.column(f"{filling}_gap")

    def resistance(self, kind: str, by: str = "length") -> Array:
        """Return the resistance of the contact, shape (n,).

        Parameters
        ----------
        kind : {"electrical", "thermal"}
            Kind of resistance, [Ω] or [K/W]; NaN if the constants of the bodies are not known.
        by : {"length", "greenwood_length", "correlation_length"}
            Constriction length: computed, or an estimate; see `ConductanceStep`.
        """
        resistivity = _sum_resistivity(self.bodies, kind)
        film = self.thermal_film if kind == "thermal" else self.film
        with np.errstate(divide="ignore"):
            resistance: Array = self.column(f"{kind}_plating") * resistivity / self.column(by)
            if film:
                resistance = resistance + film / self.column("contact_area")
        return resistance

    def _per_area(self, resistance: Array) -> Array:
        with np.errstate(divide="ignore"):
            return 1 / (resistance * self.nominal_area)


@validate_arguments
def conductance(
    contacts: ContactResult | Iterable[ContactResult],
    conductor: Conductor | str,
    counter_conductor: Conductor | str,
    *,
    electrical_film: Quantity = 0.0,
    thermal_film: Quantity = 0.0,
    gap: Quantity | None = None,
    gap_pressure: Quantity | None = None,
    temperature: Quantity | None = None,
    current: Quantity | None = None,
) -> Conductance:
    """Return electrical resistance and thermal conductance of a contact.

    Parameters
    ----------
    contacts : ContactResult or iterable of ContactResult
        Solutions of one pair of bodies under one or several loads; an iterator needs memory for
        one at a time.
    conductor, counter_conductor : Conductor or str
        Conductors of the bodies, or their names in the catalog.
    electrical_film : float, str or quantity of pint
        Electrical resistance of a film on the contact times its area [Ω m²].
    thermal_film : float, str or quantity of pint
        Thermal resistance of a film on the contact times its area [m² K/W].
    gap : str, float or quantity of pint, optional
        Fluid in the gap: ``"air"``, ``"nitrogen"``, ``"helium"``, ``"argon"``, ``"vacuum"``,
        ``"oil"``, ``"grease"``, or a conductivity [W/(m K)]; needs a periodic boundary.
    gap_pressure, temperature : float, str or quantity of pint, optional
        Pressure of a gas in the gap [Pa], by default 1 bar; mean temperature of the joint [K], by
        default 25 °C.
    current : float, str or quantity of pint, optional
        Current through the contact [A], for its voltage and its hottest spot.

    Returns
    -------
    Conductance
        Resistances under each load.

    Raises
    ------
    InputError
        If neither the resistivity nor the conductivity of both bodies is known, a film or a gap
        has no matching property, a gap has a boundary that is not periodic, the contacts belong
        to different bodies, or the bodies are profiles.
    ConvergenceError, InsufficientMemoryError
        As for `roughcontact.contact.stiffness.unloading_stiffness`.

    Notes
    -----
    The potential on the contact is constant, as is the displacement under a rigid punch of the
    same outline: with the stiffness K of that punch the constriction length is L = 2 K/E*, and
    R = Σρ/L (Barber 2003, doi:10.1098/rspa.2002.1038). The gap conducts nothing, unless ``gap``
    fills it: then it adds the mean of k/(g + M) over its pixels, M the jump distance of a gas, see
    `Conductance.joint_conductance`. `Conductance.filled_conductance` adds air or oil in any case.
    Radiation of black faces is 4 σ T³; a note shows it from 1 % of the conductance on.

    With a free boundary this is the resistance between distant points in both bodies, including
    the spreading from the whole map. With a periodic boundary it is the excess of the joint over
    the bodies of one period: 0 for full contact, and to be used per area. With a map that is
    periodic along one axis it is the resistance up to a distance of the longer side of the map, as
    the potential of an endless strip has no bound.

    A film adds its resistance over the contact area. As a film makes the flow more uniform, the
    true resistance is slightly larger: on a disc by at most 8.1 % of the constriction
    (`EVEN_FLOW`).

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(64)
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> result = rc.solve(rc.Surface(heights, pixel), material=steel, load=1.0)
    >>> found = rc.conductance(result, "6061-T6", rc.Conductor(resistivity="17 nohm m"))
    >>> bool(found.electrical_resistance[0] > 0)
    True
    """
    bodies = conductor_of(conductor), conductor_of(counter_conductor)
    films = (
        parse_film(electrical_film, "film", "electrical_film"),
        parse_film(thermal_film, "thermal film", "thermal_film"),
    )
    _check(bodies, films)
    warmth = temperature_or_room(temperature)
    filling = None if gap is None else filling_of(gap, gap_pressure, warmth)
    if filling is not None and math.isnan(_sum_resistivity(bodies, "thermal")):
        raise InputError("needs the conductivity of both bodies", argument="gap")
    amperes = None if current is None else series.parse_positive(current, "current", "current")
    if amperes and None in (body.resistivity for body in bodies):
        raise InputError("needs the resistivity of both bodies", argument="current")
    texture_of = lru_cache(maxsize=1)(Texture)

    def evaluate(result: ContactResult) -> tuple[ConductanceStep, Iterator[Caution], None]:
        if filling is not None and len(result.boundary.periodic_axes) < 2:
            raise InputError("needs ", ArgumentRef("boundary", "periodic"), argument="gap")
        texture = texture_of(result.pair)
        return _step(result, texture, bodies, filling), _joint_cautions(result, texture), None

    steps, messages, largest, _ = series.evaluate_contacts(contacts, SUBJECT, evaluate)
    result = Conductance(
        steps,
        bodies,
        *films,
        largest,
        messages,
        filling=filling,
        temperature=warmth,
        current=amperes,
    )
    more = (*_radiation(result), *_melting_cautions(result), *_oxide(result))
    return replace(result, messages=(*result.messages, *more))


def _faces(result: Conductance) -> list[Conductor]:
    """Return the conductors that touch: the outermost layers, or the bodies."""
    metals = result.largest.material, result.largest.counter_material
    return [
        catalog.conductor_of(metal.coating[0].name) if metal.coating else body
        for metal, body in zip(metals, result.bodies, strict=True)
    ]


def _oxide(result: Conductance) -> Iterator[Caution]:
    """Yield the caution on films of oxide, unless a film is given or both faces are noble."""
    area, resistance = result.steps[-1].contact_area, float(result.electrical_resistance[-1])
    is_noble = all(face.name in NOBLE for face in _faces(result))
    if result.film or not area * resistance > 0 or is_noble:
        return
    share = TUNNEL_FILM / area / resistance
    yield (as_caution if share > MIN_OXIDE_SHARE else as_note)(
        CautionTag.OXIDE,
        f"Faces are clean. A film of oxide, {TUNNEL_FILM:g} Ω m², adds {format_percent(share)}. "
        f"Give {ArgumentRef('electrical_film')}.",
        share=share,
    )


def _melting_cautions(result: Conductance) -> Iterator[Caution]:
    """Yield the caution on spots that soften or melt, at the highest contact voltage."""
    voltage = float(np.nanmax(result.voltage, initial=0.0))
    for limit, effect, severity in (
        ("melting_voltage", "melt and weld", as_warning),
        ("softening_voltage", "soften and grow", as_caution),
    ):
        known = [(value, body.name) for body in _faces(result) if (value := getattr(body, limit))]
        lowest, name = min(known, default=(math.inf, ""))
        if voltage > lowest:
            yield severity(
                CautionTag.HOT_SPOTS,
                f"Contact voltage {format_engineering(voltage, 'V', 3)} exceeds the "
                f"{limit.replace('_', ' ')} of {name or 'a body'} ({lowest:g} V): spots {effect}.",
                voltage=voltage,
            )
            return


def _radiation(result: Conductance) -> Iterator[Caution]:
    """Yield the note on radiation above a negligible share."""
    if result.largest.boundary.periodic_axes != (0, 1):
        return
    with np.errstate(divide="ignore"):
        share = float(np.nanmax(result.radiation / result.joint_conductance, initial=0.0))
    if share > MIN_RADIATION_SHARE:
        yield as_note(
            CautionTag.RADIATION,
            f"Radiation adds up to {format_percent(min(share, 1.0))} between black faces and is "
            "not included.",
            share=share,
        )


def _step(
    result: ContactResult,
    texture: Texture,
    bodies: tuple[Conductor, Conductor],
    filling: Filling | None,
) -> ConductanceStep:
    gaps, resistivity = {}, _sum_resistivity(bodies, "thermal")
    length = constriction_length(result)
    if len(result.boundary.periodic_axes) == 2 and not math.isnan(resistivity):
        gap = np.where(result.contact, np.nan, np.maximum(result.gap, 0))
        spread = spreading_resistance(result.pixel_area, resistivity)
        fillings = {"air_gap": filling_of("air"), "oil_gap": filling_of("oil")}
        if filling is not None:
            fillings["filled_gap"] = filling
        gaps = {name: gap_conductance(gap, item, spread) for name, item in fillings.items()}
    return ConductanceStep(
        load=result.load,
        contact_area=result.contact_area,
        saturated_area=result.saturated_fraction * result.pressure.size * result.pixel_area,
        spots=result.spots().count,
        length=length,
        greenwood_length=math.nan if result.pair.is_coated else greenwood(result),
        correlation_length=_correlation(result, texture),
        **gaps,
        **{f"{kind}_plating": _plating_factor(result, bodies, kind, length) for kind in KINDS},
    )


KINDS = ("electrical", "thermal")
"""Kinds of the resistance of a contact."""


def _plating_factor(
    result: ContactResult, bodies: tuple[Conductor, Conductor], kind: str, length: float
) -> float:
    """Return the constriction with the layers of the bodies over that without; NaN if unknown."""
    pair = result.pair
    if not (pair.is_coated and length):
        return 1.0
    bases = [_resistivity(body, kind) for body in bodies]
    if math.isnan(sum(bases)):
        return math.nan
    stacks = [
        ConductingStack(base, tuple(_conducting_layer(layer, kind) for layer in material.coating))
        for base, material in zip(bases, (pair.material, pair.counter_material), strict=True)
    ]
    outer = sum(stack.compliance for stack in stacks)
    with_layers = outer / constriction_length(result, Coatings.from_bodies(*stacks))
    return with_layers / (sum(bases) / length)


def _resistivity(conductor: Conductor, kind: str) -> float:
    """Return the electrical resistivity [Ω m], or 1/k [m K/W]; NaN if unknown."""
    if kind == "thermal":
        return 1 / (conductor.conductivity or math.nan)
    return conductor.resistivity or math.nan


def _conducting_layer(layer: Layer, kind: str) -> ConductingLayer:
    """Return a layer with its resistivity, by its name in the catalog."""
    resistivity = _resistivity(catalog.conductor_of(layer.name), kind)
    if math.isnan(resistivity):
        raise InputError(
            f"{layer.name or 'without a name'} has no conductivity in the catalog: name a metal, "
            "as 'hard gold 1 um'",
            argument="coating",
        )
    return ConductingLayer(resistivity, layer.thickness)


def _joint_cautions(result: ContactResult, texture: Texture) -> Iterator[Caution]:
    """Yield the notes on a smooth counter-body, and on curved bodies without correlations."""
    if result.counter_surface is None:
        yield series.ONE_ROUGH_FACE
    if result.hertz is None and not texture.is_flat:
        yield as_note(
            CautionTag.CURVED,
            f"Bodies are curved ({format_percent(texture.curved)} of gap variance): flat-joint "
            f"correlations omitted. Flat face? Add {ArgumentRef('level', 'quadric')}.",
            curved=texture.curved,
        )


def _correlation(result: ContactResult, texture: Texture) -> float:
    """Return the constriction length [m] of a nominally flat joint by the correlations."""
    height, gradient = texture.height, texture.gradient
    rough = result.load > 0 and height > 0 and gradient > 0 and not result.pair.is_coated
    strip = len(result.pair.boundary.periodic_axes) == 1
    if result.hertz is not None or strip or not rough or not texture.is_flat:
        return math.nan
    area = result.pair.size[0] * result.pair.size[1]
    # Isotropic Gaussian heights: the mean slope is √(2/π) of the slope along a profile, h′/√2.
    slope = gradient / math.sqrt(math.pi)
    pressure = result.load / area
    if result.ceiling is None:
        joint = area * constriction.elastic_joint(pressure, result.contact_modulus, slope, height)
    else:
        hardness = float(np.mean(result.ceiling))
        joint = area * constriction.plastic_joint(pressure, hardness, slope, height)
    if result.pair.boundary.periodic_axes:
        return joint
    # Add the spreading from the whole map: an ellipse with its area and aspect ratio, right to 2 %
    # for a square.
    whole = constriction.ellipse(*(side / math.sqrt(math.pi) for side in result.pair.size))
    return 1 / (1 / joint + 1 / whole)


def _sum_resistivity(bodies: tuple[Conductor, Conductor], kind: str) -> float:
    return sum(_resistivity(body, kind) for body in bodies)


def conductor_of(specified: Conductor | str) -> Conductor:
    """Return a conductor, given directly or by its name in the catalog."""
    return catalog.entry(specified).conductor if isinstance(specified, str) else specified


def parse_film(value: Quantity, dimension: str, argument: str) -> float:
    """Return a film resistance × area in SI units; zero without a film."""
    result = to_si(value, dimension, argument)
    if not (isinstance(result, (int, float)) and 0 <= result < math.inf):
        raise input_error(argument, value, "must be zero or positive, and finite")
    return float(result)


def _check(bodies: tuple[Conductor, Conductor], films: tuple[float, float]) -> None:
    """Raise `InputError` for bodies with missing resistivities or conductivities."""
    electrical = [body.resistivity is not None for body in bodies]
    thermal = [body.conductivity is not None for body in bodies]
    if not all(electrical) and not all(thermal):
        first, second = map(_known_properties, bodies)
        raise InputError(
            "needs the resistivity of both bodies, or the conductivity of both; known are "
            f"{first} of the body and {second} of the counter-body",
            argument="conductance",
        )
    for film, known, argument, what in (
        (films[0], electrical, "film", "resistivity"),
        (films[1], thermal, "thermal_film", "conductivity"),
    ):
        if film and not all(known):
            raise InputError(f"needs the {what} of both bodies", argument=argument, value=film)


def _known_properties(body: Conductor) -> str:
    names = [name for name in ("resistivity", "conductivity") if getattr(body, name) is not None]
    return " and ".join(names) or "neither"
