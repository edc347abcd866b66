"""Interface law of a nominally flat joint: pressure, contact area, stiffness."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import statistics
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.statistics import Mean
from roughcontact.analyses.conductance.model import conductor_of, parse_film
from roughcontact.analyses.law import curve as law_curve
from roughcontact.analyses.law.curve import ERROR, Asperities, Curve, Resolved, asperities
from roughcontact.analyses.tangential import model as tangential
from roughcontact.cautions import Caution, CautionTag, as_caution, merge_cautions, sort_cautions
from roughcontact.contact import series, spots
from roughcontact.contact.nominal_hertz import shape_of
from roughcontact.contact.pair import Pair
from roughcontact.contact.plausibility import over_loads
from roughcontact.contact.result import ContactResult
from roughcontact.contact.stiffness import local_stiffness
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.material.material import Conductor
from roughcontact.result import Result
from roughcontact.surface import roughness, spectrum
from roughcontact.theory import persson
from roughcontact.units import Quantity

LOADING, UNLOADING = "loading", "unloading"
"""Branches of a law: first loading, and unloading (or reloading to the largest load)."""

# Relative difference up to which pressures of two maps are treated as equal.
_PRESSURE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class LawPoint:
    """State of one map under one nominal pressure; means are over the part inside its rim."""

    pressure: float  # Nominal pressure p̄: mean of the contact pressure [Pa]
    separation: float  # Separation ū of the mean planes [m]
    mean_gap: float  # Mean open gap [m]
    contact_fraction: float  # Contact area over nominal area
    saturated_fraction: float  # Area at the ceiling over nominal area
    stiffness: float  # -dp̄/dū on further loading [Pa/m]
    unloading_stiffness: float  # -dp̄/dū on unloading [Pa/m]
    spots: int  # Number of contact spots
    contact_points: int  # Points of the map in contact
    open_points: int  # Points of the map without contact


@dataclass(frozen=True, eq=False)
class MapLaw:
    """Interface law of one map."""

    name: str  # Name of the map
    pair: Pair  # The bodies
    window: series.Window | None  # The part inside the rim
    first_touch: float  # Separation ū at first touch [m]
    unloading_touch: float  # Separation ū at first touch, of the unloading branch [m]
    loading: tuple[LawPoint, ...]  # By ascending pressure
    unloading: tuple[LawPoint, ...]  # By ascending pressure
    wave_numbers: Array  # Wave numbers of the gap spectrum, see `theory.persson`
    variances: Array  # Variances of the gap at these wave numbers

    def points(self, branch: str) -> tuple[LawPoint, ...]:
        """Return the points of a branch."""
        return self.loading if branch == LOADING else self.unloading

    def column(self, branch: str, name: str) -> Array:
        """Return one field of all points of a branch, shape (n,)."""
        return np.array([getattr(point, name) for point in self.points(branch)], dtype=float)

    def curve(self, branch: str) -> Curve:
        """Return pressure over separation of a branch."""
        touch = self.first_touch if branch == LOADING else self.unloading_touch
        flows = branch == LOADING and any(point.saturated_fraction for point in self.loading)
        stiffness = None if flows else self.column(branch, "unloading_stiffness")
        return _curve(
            self.column(branch, "pressure"), self.column(branch, "separation"), stiffness, touch
        )

    def interpolate(self, branch: str, name: str, pressures: Array) -> Array:
        """Return a field at nominal pressures within the range of a branch."""
        own = self.column(branch, "pressure")
        if own.size == pressures.size and np.allclose(
            own, pressures, rtol=_PRESSURE_TOLERANCE, atol=0
        ):
            return self.column(branch, name)
        if name == "separation":
            return self.curve(branch).separation_at(pressures)
        return np.interp(np.log(pressures), np.log(own), self.column(branch, name))

    @property
    def gap(self) -> Array:
        """Gap at first touch inside the rim [m]."""
        gap = self.pair.initial_gap
        return gap if self.window is None else gap[self.window]


@dataclass(frozen=True)
class LawStep:
    """State of all maps under one nominal pressure: means, deviations and intervals."""

    branch: str  # `LOADING` or `UNLOADING`
    pressure: float  # p̄ [Pa]
    separation: float  # Mean [m]
    mean_gap: float  # Mean [m]
    contact_fraction: float  # Mean
    saturated_fraction: float  # Mean
    stiffness: float  # Mean [Pa/m]
    unloading_stiffness: float  # Mean [Pa/m]
    separation_deviation: float  # Standard deviation [m]
    contact_deviation: float  # Standard deviation
    stiffness_deviation: float  # Standard deviation [Pa/m]
    separation_half: float
    contact_half: float
    stiffness_half: float
    persson_separation: float  # [m]
    resolved: bool  # Whether the maps resolve the law at this pressure
    thermal_conductance: float  # Conductance of the contact per area [W/(m² K)]
    tangential_stiffness: float  # dτ/dδ of a joint that sticks, mean over x and y [Pa/m]


@dataclass(frozen=True)
class Friction:
    """Resistance of a joint to a tangential force."""

    coefficient: float  # μ
    ratios: tuple[float, float]
    shear_strength: float  # σ_Y/√3 of the softer body [Pa]; infinite without a yield strength
    sliding: float  # Shear stress over pressure at sliding; less than μ where shear yields

    @property
    def ratio(self) -> float:
        """Mean of ``ratios``: tangential over unloading stiffness along y and x."""
        return sum(self.ratios) / 2


@dataclass(frozen=True)
class Backbone:
    """Shear stress of a joint over its tangential shift, under the largest pressure."""

    shift: Array  # δ [m], (n,), ascending from 0 to where the joint slides
    shear_stress: Array  # τ [Pa], (n,), from 0 to μ p̄
    stiffness: Array  # dτ/dδ [Pa/m], (n,), 0 at the end
    iwan_density: Array  # -d²τ/dδ² between two points [Pa/m²], (n - 1,)


@dataclass(frozen=True)
class LawChange:
    """Change of a law under the largest load on a coarser grid."""

    pixel: float  # Larger pixel edge of the coarser grid [m]
    closing: float  # Relative change of the approach from the smallest load on
    stiffness: float  # Relative change of the stiffness


@dataclass(frozen=True)
class LawTable:
    """Branch as rows for other programs, interpolated linearly within an error."""

    branch: str  # `LOADING` or `UNLOADING`
    error: float  # Relative pressure error of a straight line between two rows
    pressure: Array  # (n,) p̄ [Pa], strictly ascending
    separation: Array  # (n,) ū [m], strictly descending
    mean_gap: Array  # (n,) [m]
    contact_fraction: Array  # (n,)
    thermal_conductance: Array  # (n,) [W/(m² K)]

    @property
    def overclosure(self) -> Array:
        """Overclosure -ū, as in finite-element programs [m], shape (n,)."""
        return -self.separation


@dataclass(frozen=True, eq=False, repr=False)
class InterfaceLaw(Result):
    """Pressure, separation, contact and stiffness of a nominally flat joint.

    Parameters
    ----------
    maps : tuple of MapLaw
        Points of each map.
    rim : float
        Width of the rim that is excluded along free edges [m]; the mean over the maps.
    largest : ContactResult
        The contact of the first map under its largest load.
    messages : tuple of Caution
        Cautions on the contacts.
    extra_cautions : tuple of Caution
        Remarks on the measurement of the maps.
    parts : InterfaceLaw or None
        Law of equal parts of the maps, if requested, to check whether the maps are large enough.
    bodies : (Conductor, Conductor) or None
        Conductors of both bodies, for decks with a conductance.
    thermal_film : float
        Thermal resistance of a film on the contact times its area [m² K/W].
    friction : Friction or None
        Tangential resistance, if a coefficient of friction was given.
    coarser : LawChange or None
        Change of the first map on a coarser grid, if known; see `with_coarser_grid`.
    calibrated : CalibratedChange or None
        Change of closing and stiffness of the first map under the calibrated ceiling, if known;
        see `with_calibrated_ceiling`.
    """

    maps: tuple[MapLaw, ...]
    rim: float
    largest: ContactResult
    messages: tuple[Caution, ...] = ()
    extra_cautions: tuple[Caution, ...] = ()
    parts: InterfaceLaw | None = None
    bodies: tuple[Conductor, Conductor] | None = None
    thermal_film: float = 0.0
    friction: Friction | None = None
    coarser: LawChange | None = None
    calibrated: series.CalibratedChange | None = None

    def with_coarser_grid(self, contact: ContactResult) -> InterfaceLaw:
        """Return the law with its change on a coarser grid.

        Parameters
        ----------
        contact : ContactResult
            The first map under its largest load on a grid of larger pixels.
        """
        return replace(self, coarser=LawChange(max(contact.pair.pixel), *self._changes(contact)))

    def with_calibrated_ceiling(self, contact: ContactResult) -> InterfaceLaw:
        """Return the law with its change under the calibrated ceiling.

        Parameters
        ----------
        contact : ContactResult
            The first map under its largest load and the calibrated ceiling.
        """
        area, changes = self.largest.contact_area, self._changes(contact)
        return replace(
            self, calibrated=series.CalibratedChange.from_contact(contact, area, *changes)
        )

    def _changes(self, contact: ContactResult) -> tuple[float, float]:
        """Return the relative changes of closing and stiffness of the first map."""
        law = self.maps[0]
        window, last = law.window, law.loading[-1]
        if window is not None:
            factors = [
                round(new / old)
                for new, old in zip(contact.pair.pixel, law.pair.pixel, strict=True)
            ]
            rows, columns = (
                slice(-(-part.start // factor), part.stop // factor)
                for part, factor in zip(window, factors, strict=True)
            )
            window = rows, columns
        point = _point(contact, window, 0.0)
        closing = law.loading[0].separation - last.separation
        return (
            (last.separation - point.separation) / closing,
            series.relative_change(point.stiffness, last.stiffness),
        )

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* [Pa]."""
        return self.largest.contact_modulus

    @property
    def is_elastic(self) -> bool:
        """Whether no point was saturated, so that unloading follows loading."""
        return not any(p.saturated_fraction for law in self.maps for p in law.loading)

    @property
    def branches(self) -> tuple[str, ...]:
        """Branches that were solved and are different."""
        both = not self.is_elastic and all(law.unloading for law in self.maps)
        return (LOADING, UNLOADING) if both else (LOADING,)

    def pressures(self, branch: str = LOADING) -> Array:
        """Return the nominal pressures at which the maps are averaged [Pa], shape (n,).

        The solved pressures if they are the same for all maps. Otherwise, as inside rims, pressures
        in equal ratios over the common range, in the largest number that a map has.
        """
        own = [law.column(branch, "pressure") for law in self.maps]
        first = own[0]
        if all(
            p.size == first.size and np.allclose(p, first, rtol=_PRESSURE_TOLERANCE) for p in own
        ):
            return first
        low, high = max(p[0] for p in own), min(p[-1] for p in own)
        result: Array = np.geomspace(low, high, max(p.size for p in own))
        # Set exactly: rounding must not exceed the range of a map.
        result[0], result[-1] = low, high
        return result

    def values(self, branch: str, name: str) -> Array:
        """Return a field of `LawPoint` of all maps at `pressures`, shape (maps, n)."""
        pressures = self.pressures(branch)
        return np.array([law.interpolate(branch, name, pressures) for law in self.maps])

    def mean(self, branch: str, name: str) -> list[Mean]:
        """Return the mean of a field over the maps at each of `pressures`, with its interval."""
        return [_mean(values) for values in self.values(branch, name).T]

    @cached_property
    def steps(self) -> tuple[LawStep, ...]:
        """Steps of all branches, by pressure."""
        return tuple(step for branch in self.branches for step in self._steps(branch))

    def branch_steps(self, branch: str) -> list[LawStep]:
        """Return the `steps` of one branch."""
        return [step for step in self.steps if step.branch == branch]

    def _steps(self, branch: str) -> Iterator[LawStep]:
        pressures = self.pressures(branch)
        names = (
            "separation",
            "mean_gap",
            "contact_fraction",
            "saturated_fraction",
            "stiffness",
            "unloading_stiffness",
        )
        means = {name: self.mean(branch, name) for name in names}
        theory, resolved = self.persson(pressures), self.resolved
        conductance = self.thermal_conductance(branch)
        ratio = math.nan if self.friction is None else self.friction.ratio
        for number, pressure in enumerate(pressures.tolist()):
            point = {name: result[number] for name, result in means.items()}
            scatter = {
                "separation": point["separation"],
                "contact": point["contact_fraction"],
                "stiffness": point[("stiffness" if branch == LOADING else "unloading_stiffness")],
            }
            yield LawStep(
                branch=branch,
                pressure=pressure,
                **{name: point[name].value for name in names},
                **{f"{name}_deviation": item.deviation for name, item in scatter.items()},
                **{f"{name}_half": item.high - item.value for name, item in scatter.items()},
                persson_separation=float(theory[number]),
                resolved=resolved.low <= pressure <= resolved.high,
                thermal_conductance=float(conductance[number]),
                tangential_stiffness=ratio * point["unloading_stiffness"].value,
            )

    def curve(self, branch: str = LOADING) -> Curve:
        """Return the mean of the maps as a `Curve`."""
        flows = branch == LOADING and not self.is_elastic
        stiffness = None if flows else self.values(branch, "unloading_stiffness")
        touch = [law.first_touch if branch == LOADING else law.unloading_touch for law in self.maps]
        separation = self.values(branch, "separation").mean(axis=0)
        return _curve(self.pressures(branch), separation, stiffness, fmean(touch))

    def table(self, branch: str = LOADING, error: float = ERROR) -> LawTable:
        """Return a branch as a `LawTable` for other programs."""
        pressure, separation = self.curve(branch).table(error)
        log, own = np.log(pressure[1:]), np.log(self.pressures(branch))
        more = []
        for name, start in (("mean_gap", separation[0]), ("contact_fraction", 0.0)):
            values = np.interp(log, own, self.values(branch, name).mean(axis=0))
            more.append(np.concatenate([[start], values]))
        values = self._conductance_between(branch, log)
        more.append(np.concatenate([[math.nan if self.bodies is None else 0.0], values]))
        return LawTable(branch, error, pressure, separation, *more)

    @cached_property
    def resolved(self) -> Resolved:
        """Range of nominal pressures that the maps resolve, with the limits at both ends."""
        return law_curve.resolved_range(
            self.pressures(),
            {
                name: self.values(LOADING, name).mean(axis=0)
                for name in ("spots", "contact_points", "open_points", "contact_fraction")
            },
            self.contact_modulus * self.rms_gradient / 2,
        )

    @cached_property
    def rms_gradient(self) -> float:
        """Root-mean-square gradient h′ of the gap at first touch, mean over the maps."""
        return fmean(roughness.rms_gradient(law.gap, law.pair.pixel) for law in self.maps)

    @cached_property
    def asperities(self) -> Asperities:
        """Greenwood-Tripp moments of the gap at first touch, means over the maps."""
        result = [asperities(law.gap, law.pair.pixel) for law in self.maps]
        means = (fmean(getattr(item, name) for item in result) for name in ("m0", "m2", "m4"))
        return Asperities(*means)

    def persson(self, pressures: Array) -> Array:
        """Return the separation by Persson's theory of the elastic joint [m], shape (n,).

        The mean over the maps; NaN if a map has missing points.
        """
        if not all(law.wave_numbers.size for law in self.maps):
            return np.full(np.shape(pressures), math.nan)
        of_spectrum = partial(persson.persson_separation, pressures, self.contact_modulus)
        return np.mean([of_spectrum(law.wave_numbers, law.variances) for law in self.maps], axis=0)

    @cached_property
    def persson_length(self) -> float:
        """u₀ of Persson's p̄ ∝ exp(-ū/u₀) from the spectra of the maps [m]; see `persson`."""
        if not all(law.wave_numbers.size for law in self.maps):
            return math.nan
        return fmean(persson.persson_decay(law.wave_numbers, law.variances) for law in self.maps)

    def thermal_conductance(self, branch: str = LOADING) -> Array:
        """Return the conductance of the contact per area at `pressures` [W/(m² K)], shape (n,).

        From the unloading stiffness of the contacts of the branch, as in
        `analyses.conductance.model.conductance`; the mean over the maps. NaN without `bodies`,
        infinite where a map is closed.
        """
        resistivity = math.fsum(1 / (body.conductivity or math.nan) for body in self.bodies or ())
        return self._conductance(branch, resistivity, self.thermal_film)

    def electrical_conductance(self, branch: str = LOADING) -> Array:
        """Return the electrical conductance per area at `pressures` [S/m²], shape (n,).

        Like `thermal_conductance`, without a film; NaN if a resistivity is not known.
        """
        bodies = self.bodies or ()
        return self._conductance(
            branch, math.fsum(body.resistivity or math.nan for body in bodies), 0.0
        )

    def _conductance(self, branch: str, resistivity: float, film: float) -> Array:
        if self.bodies is None:
            return np.full(self.pressures(branch).shape, math.nan)
        stiffness = self.values(branch, "unloading_stiffness")
        with np.errstate(divide="ignore"):
            constriction = resistivity * self.contact_modulus / (2 * stiffness)
            extra = film / self.values(branch, "contact_fraction")
            return np.mean(1 / (constriction + extra), axis=0)

    def elastic_slip(self, branch: str = LOADING) -> Array:
        """Return the elastic slip μ p̄/k_t at `pressures` [m], shape (n,).

        This is the shift at which a joint of constant stiffness slides; it is about constant, as
        k_t is about proportional to p̄.
        """
        steps = self.branch_steps(branch)
        friction = math.nan if self.friction is None else self.friction.sliding
        return np.array([friction * step.pressure / step.tangential_stiffness for step in steps])

    def backbone(self, axis: int = 1) -> Backbone:
        """Return shear stress over shift along y (0) or x (1) under the largest pressure.

        Superposition: τ = μ (p̄ - p*), δ = μ c (ū(p*) - ū(p̄)), with the separation of the unloading
        branch and the ratio c of tangential to normal compliance (Ciavarella 1998, Jäger 1998).
        The Iwan density is the part of the joint that begins to slip at each shift (Iwan 1966).
        """
        if self.friction is None:
            raise InputError("is needed for a backbone, such as 0.15", argument="friction")
        friction, ratio = self.friction.sliding, self.friction.ratios[axis]
        steps = self.branch_steps(self.branches[-1])[::-1]
        pressure, separation, normal = (
            np.array([getattr(step, name) for step in steps])
            for name in ("pressure", "separation", "unloading_stiffness")
        )
        touch = self.curve(self.branches[-1]).first_touch
        shift = friction / ratio * (np.append(separation, touch) - separation[0])
        stiffness = np.append(ratio * normal, 0.0)
        return Backbone(
            shift,
            friction * (pressure[0] - np.append(pressure, 0.0)),
            stiffness,
            -np.diff(stiffness) / np.diff(shift),
        )

    def _conductance_between(self, branch: str, log: Array) -> Array:
        """Return `thermal_conductance` at given ln p̄, by power laws between solved pressures."""
        own, values = np.log(self.pressures(branch)), self.thermal_conductance(branch)
        there = np.isfinite(values)
        if not there.any():
            return np.full(log.shape, values[0])
        result = np.exp(np.interp(log, own[there], np.log(values[there])))
        # A closed map has no resistance.
        return np.where(log > own[there][-1], values[-1], result)

    @property
    def conductance(self) -> Array:
        """`thermal_conductance` of first loading [W/(m² K)], shape (n,)."""
        return self.thermal_conductance(LOADING)

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the law, the most severe first."""
        own = [*law_curve.cautions(len(self.maps), self.resolved, self.rim)]
        if self.part_size is not None and self.part_size.caution is not None:
            own.append(self.part_size.caution)
        if self.friction is not None and self.friction.sliding < 0.99 * self.friction.coefficient:
            text = (
                f"Shear yields before friction {self.friction.coefficient:g} is reached: the joint "
                f"slides at {self.friction.sliding:.2g} of the pressure."
            )
            own.append(as_caution(CautionTag.SHEAR_YIELD, text, sliding=self.friction.sliding))
        return sort_cautions([*self.messages, *own, *self.extra_cautions])

    @property
    def part_size(self) -> law_curve.PartSize | None:
        """Difference of the laws of parts and whole maps; None if not requested."""
        if self.parts is None:
            return None
        half = np.array([item.high - item.value for item in self.parts.mean(LOADING, "separation")])
        return law_curve.judge_part_size(self.curve(), self.parts.curve(), half, self.resolved)


def _curve(pressure: Array, separation: Array, stiffness: Array | None, touch: float) -> Curve:
    """Return a curve with its computed slopes, of one map or the mean of several."""
    if stiffness is None:
        return Curve(pressure, separation, None, touch)
    with np.errstate(divide="ignore"):
        compliance = np.atleast_2d(1 / stiffness).mean(axis=0)
    return Curve(pressure, separation, compliance, touch)


def _mean(values: Array) -> Mean:
    # A closed map has infinite stiffness, hence a mean without scatter.
    if not np.isfinite(values).all():
        return Mean(values.size, float(values.mean()), math.nan, math.nan, math.nan)
    return statistics.mean_with_interval(values)


LAW_NAME = "an interface law"
"""Name of the analysis in messages on missing maps."""

# Relative height difference up to which heights are treated as equal.
_ROUNDING = 1e-9


@validate_arguments
def interface_law(
    contacts: Iterable[ContactResult],
    unloading: Iterable[ContactResult] = (),
    *,
    conductor: Conductor | str | None = None,
    counter_conductor: Conductor | str | None = None,
    thermal_film: Quantity = 0.0,
    friction: float | None = None,
) -> InterfaceLaw:
    """Return the law of a nominally flat joint: pressure and stiffness over separation.

    Parameters
    ----------
    contacts : iterable of ContactResult
        Solutions of one map or several maps of one surface, each under two loads at least, one map
        after the other. An iterator needs memory for one contact at a time.
    unloading : iterable of ContactResult
        Solutions of the maps as the largest load left them (`roughcontact.indented_surface`),
        under loads up to the largest, the maps in the same order. Without these, the law has no
        second branch; if nothing was saturated, none is needed.
    conductor, counter_conductor : Conductor or str, optional
        Conductors of the bodies, or their names in the catalog of materials, for the thermal
        conductance over pressure.
    thermal_film : float, str or quantity of pint
        Thermal resistance of a film on the contact times its area [m² K/W].
    friction : float, optional
        Coefficient μ of Coulomb's law, for the tangential stiffness and the elastic slip.

    Returns
    -------
    InterfaceLaw
        Law of each map, mean and scatter, resolved range, and tables for other programs.

    Raises
    ------
    InputError
        If there are fewer than two contacts of a map, the maps are profiles, curved, too small or
        of different grids, or the bodies differ in more than their maps.
    ConvergenceError, InsufficientMemoryError
        As for `roughcontact.contact.stiffness.local_stiffness`.

    Notes
    -----
    The *separation* ū is the distance of the mean planes of the two rough surfaces, each displaced
    by its elastic deformation: the mean of the gap, negative where a surface is indented. Far above
    and below the joint, the bodies approach each other by the decrease of ū and by their bulk
    compression. At *first touch*, without load, ū is the height of the highest summit above the
    mean plane. The *overclosure* of finite-element programs is -ū: zero where the mean planes meet,
    negative before.

    The tangential stiffness is the unloading stiffness of the whole contact times the ratio of
    tangential to unloading stiffness of the first map under its largest load at full stick.

    On first loading, the stiffness is that of the elastic contact alone, as saturated points yield
    further; on unloading, and reloading up to the largest load, the whole contact resists.

    With a periodic boundary, means are over the whole map. On a free boundary, a rim along the
    edges is excluded (`roughcontact.contact.series`), and p̄ and ū are means inside the rim; these
    follow the same local relation although the pressure of a flat body rises towards its edges.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> rough = rc.Surface(*rc.reference_map(64))
    >>> law = rc.interface_law(
    ...     rc.solve(rough, material=steel, load=rc.NominalPressure(p), boundary="periodic")
    ...     for p in ("100 MPa", "300 MPa", "1 GPa")
    ... )
    >>> first, *_, last = law.steps
    >>> first.separation > last.separation, first.stiffness < last.stiffness
    (True, True)
    """
    collected = _collect_points(contacts)
    _add_unloading(unloading, collected)
    for number, samples in enumerate(collected, start=1):
        if len(samples.points) < 2:
            raise InputError(
                f"has {len(samples.points)} pressure at which map {number} has contact inside its "
                "rim: a law needs at least two",
                argument="contacts",
            )
    film = parse_film(thermal_film, "thermal film", "thermal_film")
    bodies = None
    if conductor is not None and counter_conductor is not None:
        bodies = (conductor_of(conductor), conductor_of(counter_conductor))
    return InterfaceLaw(
        maps=tuple(_law(samples, number, collected) for number, samples in enumerate(collected, 1)),
        rim=fmean(samples.rim for samples in collected),
        largest=collected[0].largest,
        messages=_merge_cautions(collected),
        bodies=bodies,
        thermal_film=film,
        friction=None if friction is None else _friction(collected[0].largest, friction),
    )


def _friction(result: ContactResult, coefficient: float) -> Friction:
    tangential.require_friction(coefficient)
    ratios = tangential.stick_ratios(result)
    pressure, strength = result.pressure, tangential.shear_strength(result)
    bound = np.minimum(coefficient * pressure, strength)
    return Friction(float(coefficient), ratios, strength, float(bound.sum() / pressure.sum()))


@dataclass(eq=False)
class _Samples:
    """Points of the law collected from one map."""

    pair: Pair
    window: series.Window | None
    rim: float
    largest: ContactResult
    points: list[LawPoint] = field(default_factory=list)
    judged: list[tuple[float, tuple[Caution, ...]]] = field(default_factory=list)
    unloading: list[LawPoint] = field(default_factory=list)
    unloading_touch: float = math.nan

    @property
    def loads(self) -> list[float]:
        """Loads of the contacts of the map [N]."""
        return [load for load, _ in self.judged]

    def add(self, result: ContactResult) -> None:
        point = _point(result, self.window, 0.0)
        self.judged.append((result.load, result.cautions))
        if point.contact_points and point.pressure > 0:
            self.points.append(point)
        if result.load >= self.largest.load:
            self.largest = result


def _collect_points(contacts: Iterable[ContactResult]) -> list[_Samples]:
    """Return the points of the law, map by map."""
    answer: list[_Samples] = []
    for result in [contacts] if isinstance(contacts, ContactResult) else contacts:
        # A repeated load starts another map, even one with the same heights.
        known = (item for item in answer if result.load not in item.loads)
        _check(result, answer[0].largest if answer else result)
        samples = next(
            (item for item in known if series.same_heights(item.pair, result.pair)), None
        )
        if samples is None:
            samples = _Samples(result.pair, *series.window_of(result.pair), result)
            answer.append(samples)
        samples.add(result)
    if not answer:
        raise InputError("is empty: give at least two contacts", argument="contacts")
    return answer


def _add_unloading(unloading: Iterable[ContactResult], collected: Sequence[_Samples]) -> None:
    """Add the unloading points of each map, and the separation at first touch."""
    pairs: list[Pair] = []
    loads: set[float] = set()
    for result in unloading:
        again = result.load in loads
        series.require_alike(
            collected[0].pair,
            result.pair,
            "unloading",
            "; give contacts of the same bodies and boundary",
            only_elastic=True,
        )
        if not pairs or again or not series.same_heights(pairs[-1], result.pair):
            loads.clear()
            if len(pairs) == len(collected):
                raise _unlike_error(len(pairs) + 1)
            pairs.append(result.pair)
        loads.add(result.load)
        samples = collected[len(pairs) - 1]
        lowered = _indentation_inside(samples, result.pair, len(pairs))
        point = _point(result, samples.window, lowered)
        if point.contact_points and point.pressure > 0:
            samples.unloading.append(point)
            samples.unloading_touch = _first_touch(result.pair, samples.window) - lowered
    if pairs and len(pairs) < len(collected):
        raise InputError(
            f"has {len(pairs)} maps, and there are {len(collected)}: give all of them, or none",
            argument="unloading",
        )


def _indentation_inside(samples: _Samples, pair: Pair, number: int) -> float:
    """Return the mean indentation depth of a map inside its rim [m]."""
    depth = samples.pair.heights - pair.heights
    scale = float(np.nanmax(np.abs(samples.pair.heights)))
    if np.nanmin(depth) < -_ROUNDING * scale:
        raise _unlike_error(number)
    return float(np.nanmean(_inside(depth, samples.window)))


def _unlike_error(number: int) -> InputError:
    return InputError(
        f"map {number} is not map {number} of the contacts after its largest load: give the maps "
        f"in the same order, each from {ArgumentRef('indented_surface')}",
        argument="unloading",
    )


def _point(result: ContactResult, window: series.Window | None, lowered: float) -> LawPoint:
    """Return the point of the law of one contact, inside its rim."""
    pressure, gap = _inside(result.pressure, window), _inside(result.gap, window)
    contact = pressure > 0
    loading, whole = local_stiffness(result, window)
    axes = result.boundary.periodic_axes if window is None else ()
    return LawPoint(
        pressure=float(pressure.mean()),
        separation=float(np.nanmean(gap)) - lowered,
        mean_gap=float(np.nanmean(np.maximum(gap, 0))),
        contact_fraction=float(contact.mean()),
        saturated_fraction=float(_inside(result.saturated, window).mean()),
        # On the unloading branch, all contact points are elastic.
        stiffness=whole if lowered else loading,
        unloading_stiffness=whole,
        spots=spots.find_spots(np.ascontiguousarray(pressure), result.pair.pixel, axes).count,
        contact_points=int(contact.sum()),
        open_points=int(np.count_nonzero(~contact & ~np.isnan(gap))),
    )


def _inside(values: NDArray[Any], window: series.Window | None) -> NDArray[Any]:
    return values if window is None else values[window]


def _first_touch(pair: Pair, window: series.Window | None) -> float:
    """Return the separation at which the bodies first touch inside the rim [m]."""
    gap = _inside(pair.initial_gap, window)
    return float(np.nanmean(gap) - np.nanmin(gap))


def _law(samples: _Samples, number: int, all_of_them: Sequence[_Samples]) -> MapLaw:
    pair = samples.pair
    source = pair.surface.provenance.source
    alone = [item.pair.surface.provenance.source for item in all_of_them].count(source) == 1
    first = _first_touch(pair, samples.window)
    loading, after = (
        tuple(sorted(points, key=lambda point: point.pressure))
        for points in (samples.points, samples.unloading)
    )
    return MapLaw(
        name=source if source and alone else f"{source or 'map'} {number}".strip(),
        pair=pair,
        window=samples.window,
        first_touch=first,
        unloading_touch=samples.unloading_touch if samples.unloading else first,
        loading=loading,
        unloading=after,
        **_spectrum(pair, samples.window),
    )


def _spectrum(pair: Pair, window: series.Window | None) -> dict[str, Array]:
    """Return wave numbers and variances of the gap for Persson's theory."""
    gap = np.array(_inside(pair.initial_gap, window), dtype=np.float64)
    if np.isnan(gap).any():
        return {"wave_numbers": np.empty(0), "variances": np.empty(0)}
    gap -= gap.mean()
    if window is not None:
        variance = gap.var()
        for axis in pair.boundary.free_axes:
            taper = np.hanning(gap.shape[axis] + 2)[1:-1]
            gap *= taper[:, None] if axis == 0 else taper
        gap -= gap.mean()
        gap *= math.sqrt(variance / gap.var())
    q, density, waves = spectrum.radial_spectrum(gap, pair.pixel)
    return {"wave_numbers": q, "variances": density * waves / (gap.size * pair.pixel_area)}


def _check(result: ContactResult, first: ContactResult) -> None:
    """Raise `InputError` for a map without a law, or one that does not match the first."""
    pair, other = result.pair, first.pair
    pair.require_map(LAW_NAME, coated=False)
    if shape_of(pair) is not None:
        raise InputError(
            "are of curved bodies, and an interface law requires nominally flat ones: remove the "
            "form, or omit the nominal bodies",
            argument="contacts",
        )
    series.require_alike(
        other,
        pair,
        "contacts",
        "; contact and stiffness depend on all of them: give maps of one surface on one grid "
        f"({ArgumentRef('pixel')}), solved with the same bodies and boundary",
    )
    series.require_one_model(first.ceiling is None, result.ceiling is None)


def _merge_cautions(collected: Sequence[_Samples]) -> tuple[Caution, ...]:
    """Return the cautions of all contacts, one of each tag."""
    maps = [
        (
            samples.pair.surface.provenance.source or f"map {number}",
            over_loads(sorted(samples.judged, key=lambda entry: entry[0]), "N"),
        )
        for number, samples in enumerate(collected, start=1)
    ]
    # The excluded margin makes the caution on loaded edges redundant.
    result = tuple(c for c in merge_cautions(maps, "maps") if c.kind != CautionTag.EDGE)
    if collected[0].pair.counter_surface is not None:
        return result
    return (*result, series.ONE_ROUGH_FACE)
