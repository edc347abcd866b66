"""What is known of a nominally flat joint: pressure, separation, contact and stiffness."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from roughcontact import statistics
from roughcontact.contact.cautions import Caution, ordered
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.joint import law_judgment
from roughcontact.joint.asperities import Asperities, asperities
from roughcontact.joint.law_curve import ERROR, Curve
from roughcontact.joint.law_judgment import Resolved
from roughcontact.joint.window import Window
from roughcontact.material.conductor import Conductor
from roughcontact.result import Result
from roughcontact.statistics import Mean
from roughcontact.surface import roughness
from roughcontact.theory import persson

Array = NDArray[np.float64]

LOADING, UNLOADING = "loading", "unloading"
"""Branches of a law: first loading, and unloading from it or loading again up to it."""

# Pressures of two maps that differ by less than this part are one.
_SAME = 1e-6


@dataclass(frozen=True)
class LawPoint:
    """One map under one nominal pressure; all means are over the part inside its rim.

    Parameters
    ----------
    pressure : float
        Nominal pressure p̄: mean of the contact pressure [Pa].
    separation : float
        Separation of the mean planes ū [m]: mean of the gap between the bodies as they were before
        any contact; negative where more is indented than is open.
    mean_gap : float
        Mean open gap [m].
    contact_fraction, saturated_fraction : float
        Shares of the area that touch, and that are at the ceiling.
    stiffness, unloading_stiffness : float
        -dp̄/dū [Pa/m] as the load grows and as it begins to fall; see
        `contact.stiffness.local_stiffness`.
    spots, contact_points, open_points : int
        Contact spots, and points of the map that touch and that do not.
    """

    pressure: float
    separation: float
    mean_gap: float
    contact_fraction: float
    saturated_fraction: float
    stiffness: float
    unloading_stiffness: float
    spots: int
    contact_points: int
    open_points: int


@dataclass(frozen=True, eq=False)
class MapLaw:
    """The law that one map shows.

    Parameters
    ----------
    name : str
        What the map is called.
    pair : Pair
        The bodies.
    window : (slice, slice) or None
        The part inside the rim; None for all of it.
    first_touch, unloading_touch : float
        Separation at which the bodies first touch, and at which they part after the largest load
        [m].
    loading, unloading : tuple of LawPoint
        The branches by ascending pressure; the second is empty where it was not solved.
    wave_numbers, variances : ndarray
        Spectrum of the gap, as `theory.persson.persson_separation` takes it; empty where points
        are missing.
    """

    name: str
    pair: Pair
    window: Window | None
    first_touch: float
    unloading_touch: float
    loading: tuple[LawPoint, ...]
    unloading: tuple[LawPoint, ...]
    wave_numbers: Array
    variances: Array

    def points(self, branch: str) -> tuple[LawPoint, ...]:
        """Return the points of a branch."""
        return self.loading if branch == LOADING else self.unloading

    def column(self, branch: str, name: str) -> Array:
        """Return one field of all points of a branch, shape (n,)."""
        return np.array([getattr(point, name) for point in self.points(branch)], dtype=float)

    def curve(self, branch: str) -> Curve:
        """Return pressure over separation."""
        touch = self.first_touch if branch == LOADING else self.unloading_touch
        flows = branch == LOADING and any(point.saturated_fraction for point in self.loading)
        stiffness = None if flows else self.column(branch, "unloading_stiffness")
        return _curve(
            self.column(branch, "pressure"), self.column(branch, "separation"), stiffness, touch
        )

    def at(self, branch: str, name: str, pressures: Array) -> Array:
        """Return a field at nominal pressures between the first and the last of a branch."""
        own = self.column(branch, "pressure")
        if own.size == pressures.size and np.allclose(own, pressures, rtol=_SAME, atol=0):
            return self.column(branch, name)
        if name == "separation":
            return self.curve(branch).separation_at(pressures)
        found: Array = np.interp(np.log(pressures), np.log(own), self.column(branch, name))
        return found

    @property
    def gap(self) -> Array:
        """Gap at first touch inside the rim [m]."""
        gap = self.pair.initial_gap
        return gap if self.window is None else gap[self.window]


@dataclass(frozen=True)
class LawStep:
    """All maps under one nominal pressure: means over the maps and how they scatter.

    Parameters
    ----------
    branch : str
        `LOADING` or `UNLOADING`.
    pressure : float
        p̄ [Pa].
    separation, mean_gap, contact_fraction, saturated_fraction, stiffness, unloading_stiffness : \
float
        Means over the maps; see `LawPoint`.
    separation_deviation, contact_deviation, stiffness_deviation : float
        Standard deviations over the maps; NaN of one map.
    separation_half, contact_half, stiffness_half : float
        Halves of the intervals in which the means lie with confidence `statistics.LEVEL`; NaN of
        one map.
    persson_separation : float
        ū of an elastic joint by Persson's theory from the spectra of the maps [m].
    resolved : bool
        Whether the maps resolve the law under this pressure; see `InterfaceLaw.resolved`.
    thermal_conductance : float
        Of the contact per area [W/(m² K)]; NaN where it is not known what the bodies conduct.
    """

    branch: str
    pressure: float
    separation: float
    mean_gap: float
    contact_fraction: float
    saturated_fraction: float
    stiffness: float
    unloading_stiffness: float
    separation_deviation: float
    contact_deviation: float
    stiffness_deviation: float
    separation_half: float
    contact_half: float
    stiffness_half: float
    persson_separation: float
    resolved: bool
    thermal_conductance: float


@dataclass(frozen=True)
class LawTable:
    """A branch as rows for other programs, straight lines between which are right to an error.

    Parameters
    ----------
    branch : str
        `LOADING` or `UNLOADING`.
    error : float
        Part of the pressure that a straight line between two rows may be off; not of that between
        the first row and the second, below the smallest pressure that was solved.
    pressure : ndarray, shape (n,)
        p̄ [Pa], strictly ascending; the first is zero.
    separation : ndarray, shape (n,)
        ū [m], strictly descending; the first is that of first touch. Overclosure is -ū.
    mean_gap, contact_fraction, thermal_conductance : ndarray, shape (n,)
        At the same pressures [m], [1], [W/(m² K)].
    """

    branch: str
    error: float
    pressure: Array
    separation: Array
    mean_gap: Array
    contact_fraction: Array
    thermal_conductance: Array

    @property
    def overclosure(self) -> Array:
        """-ū, as finite-element programs have it [m], shape (n,)."""
        return -self.separation


@dataclass(frozen=True, eq=False, repr=False)
class InterfaceLaw(Result):
    """Pressure, separation, contact and stiffness of a nominally flat joint.

    Parameters
    ----------
    maps : tuple of MapLaw
        What each map shows.
    rim : float
        Width of the rim that is left out along free edges [m]; the mean over the maps.
    largest : ContactResult
        The contact of the first map under its largest load.
    found : tuple of Caution
        What the contacts give cause for.
    remarks : tuple of Caution
        What else is known of the numbers, from the measurement of the maps.
    parts : InterfaceLaw or None
        The law of equal parts of the maps, if it was asked for: whether the maps are large enough.
    bodies : (Conductor, Conductor) or None
        What both bodies conduct, for decks that hold a conductance.
    thermal_film : float
        Thermal resistance of a film on the contact times its area [m² K/W].
    """

    maps: tuple[MapLaw, ...]
    rim: float
    largest: ContactResult
    found: tuple[Caution, ...] = ()
    remarks: tuple[Caution, ...] = ()
    parts: InterfaceLaw | None = None
    bodies: tuple[Conductor, Conductor] | None = None
    thermal_film: float = 0.0

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]."""
        return self.largest.contact_modulus

    @property
    def is_elastic(self) -> bool:
        """Whether nothing was saturated, so that unloading is the way of loading back."""
        return not any(p.saturated_fraction for law in self.maps for p in law.loading)

    @property
    def branches(self) -> tuple[str, ...]:
        """The branches that differ and were solved."""
        both = not self.is_elastic and all(law.unloading for law in self.maps)
        return (LOADING, UNLOADING) if both else (LOADING,)

    def pressures(self, branch: str = LOADING) -> Array:
        """Return the nominal pressures at which the maps are averaged [Pa], shape (n,).

        Those that were solved where all maps have the same; inside rims each map has its own, and
        these are as many in equal ratios over what all of them cover.
        """
        own = [law.column(branch, "pressure") for law in self.maps]
        first = own[0]
        if all(p.size == first.size and np.allclose(p, first, rtol=_SAME) for p in own):
            return first
        low, high = max(p[0] for p in own), min(p[-1] for p in own)
        found: Array = np.geomspace(low, high, max(p.size for p in own))
        # Exactly, so that no map has to tell more than it covers.
        found[0], found[-1] = low, high
        return found

    def values(self, branch: str, name: str) -> Array:
        """Return a field of `LawPoint` of all maps at `pressures`, shape (maps, n)."""
        pressures = self.pressures(branch)
        return np.array([law.at(branch, name, pressures) for law in self.maps])

    def mean(self, branch: str, name: str) -> list[Mean]:
        """Return the mean of a field over the maps at each of `pressures`, with its interval."""
        return [_mean(values) for values in self.values(branch, name).T]

    @cached_property
    def steps(self) -> tuple[LawStep, ...]:
        """All that is told of each branch and pressure."""
        return tuple(step for branch in self.branches for step in self._steps(branch))

    def of_branch(self, branch: str) -> list[LawStep]:
        """Return the `steps` of one branch."""
        return [step for step in self.steps if step.branch == branch]

    def _steps(self, branch: str) -> Iterator[LawStep]:
        pressures = self.pressures(branch)
        names = ("separation", "mean_gap", "contact_fraction", "saturated_fraction", "stiffness",
                 "unloading_stiffness")  # fmt: skip
        means = {name: self.mean(branch, name) for name in names}
        theory, resolved = self.persson(pressures), self.resolved
        conductance = self.thermal_conductance(branch)
        for number, pressure in enumerate(pressures.tolist()):
            at = {name: found[number] for name, found in means.items()}
            scatter = {
                "separation": at["separation"], "contact": at["contact_fraction"],
                "stiffness": at[_stiffness_of(branch)],
            }  # fmt: skip
            yield LawStep(
                branch=branch,
                pressure=pressure,
                **{name: at[name].value for name in names},
                **{f"{name}_deviation": one.deviation for name, one in scatter.items()},
                **{f"{name}_half": one.high - one.value for name, one in scatter.items()},
                persson_separation=float(theory[number]),
                resolved=resolved.low <= pressure <= resolved.high,
                thermal_conductance=float(conductance[number]),
            )

    def curve(self, branch: str = LOADING) -> Curve:
        """Return the mean of the maps as a curve; see `Curve`."""
        flows = branch == LOADING and not self.is_elastic
        stiffness = None if flows else self.values(branch, "unloading_stiffness")
        touch = [law.first_touch if branch == LOADING else law.unloading_touch for law in self.maps]
        separation = self.values(branch, "separation").mean(axis=0)
        return _curve(self.pressures(branch), separation, stiffness, math.fsum(touch) / len(touch))

    def table(self, branch: str = LOADING, error: float = ERROR) -> LawTable:
        """Return a branch as rows for other programs; see `LawTable`."""
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
        """The range of nominal pressures that the maps resolve, and what ends it."""
        return law_judgment.resolved(
            self.pressures(),
            {
                name: self.values(LOADING, name).mean(axis=0)
                for name in ("spots", "contact_points", "open_points", "contact_fraction")
            },
            self.contact_modulus * self.rms_gradient / 2,
        )

    @cached_property
    def rms_gradient(self) -> float:
        """h′ of the gap at first touch, mean over the maps."""
        found = [roughness.rms_gradient(law.gap, law.pair.pixel) for law in self.maps]
        return math.fsum(found) / len(found)

    @cached_property
    def asperities(self) -> Asperities:
        """Moments of the gap at first touch after Greenwood and Tripp, means over the maps."""
        found = [asperities(law.gap, law.pair.pixel) for law in self.maps]
        means = (
            math.fsum(getattr(one, name) for one in found) / len(found)
            for name in ("m0", "m2", "m4")
        )
        return Asperities(*means)

    def persson(self, pressures: Array) -> Array:
        """Return the separation by Persson's theory of the elastic joint [m], shape (n,).

        The mean over the maps; NaN where one has missing points.
        """
        if not all(law.wave_numbers.size for law in self.maps):
            return np.full(np.shape(pressures), math.nan)
        found: Array = np.mean(
            [
                persson.persson_separation(
                    pressures, self.contact_modulus, law.wave_numbers, law.variances
                )
                for law in self.maps
            ],
            axis=0,
        )
        return found

    @cached_property
    def persson_length(self) -> float:
        """u₀ of Persson's p̄ ∝ exp(-ū/u₀) from the spectra of the maps [m]; see `persson`."""
        if not all(law.wave_numbers.size for law in self.maps):
            return math.nan
        found = [persson.persson_decay(law.wave_numbers, law.variances) for law in self.maps]
        return math.fsum(found) / len(found)

    def thermal_conductance(self, branch: str = LOADING) -> Array:
        """Return the conductance of the contact per area at `pressures` [W/(m² K)], shape (n,).

        From the unloading stiffness of the contacts of the branch, as that of `joint.conductance`;
        the mean over the maps. NaN without `bodies`, infinite where a map is closed.
        """
        if self.bodies is None:
            return np.full(self.pressures(branch).shape, math.nan)
        resistivity = math.fsum(1 / (body.conductivity or math.nan) for body in self.bodies)
        with np.errstate(divide="ignore"):
            constriction = (
                resistivity
                * self.contact_modulus
                / (2 * self.values(branch, "unloading_stiffness"))
            )
            film = self.thermal_film / self.values(branch, "contact_fraction")
            mean: Array = np.mean(1 / (constriction + film), axis=0)
        return mean

    def _conductance_between(self, branch: str, log: Array) -> Array:
        """Return `thermal_conductance` at some ln p̄, a power of p̄ between two that were solved."""
        own, values = np.log(self.pressures(branch)), self.thermal_conductance(branch)
        there = np.isfinite(values)
        if not there.any():
            return np.full(log.shape, values[0])
        found = np.exp(np.interp(log, own[there], np.log(values[there])))
        # A map that is closed resists no more.
        return np.where(log > own[there][-1], values[-1], found)

    @property
    def conductance(self) -> Array:
        """`thermal_conductance` of first loading [W/(m² K)], shape (n,)."""
        return self.thermal_conductance(LOADING)

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        errors = [self.curve(branch).error for branch in self.branches]
        own = [
            *law_judgment.cautions(
                len(self.maps), self.pressures(), self.resolved, self.rim, max(errors)
            )
        ]
        if self.parts is not None:
            parts = self.parts
            half = np.array([one.high - one.value for one in parts.mean(LOADING, "separation")])
            own.append(
                law_judgment.halved(
                    self.curve(), parts.curve(), half, len(parts.maps), self.resolved
                )
            )
        return ordered(dict.fromkeys([*self.found, *own, *self.remarks]))


def _curve(pressure: Array, separation: Array, stiffness: Array | None, touch: float) -> Curve:
    """Return a curve with the slopes that were computed, of one map or the mean of several.

    None stands for a contact that flows. The elastic rims of its spots are often one pixel wide, so
    that the stiffness at one pressure scatters by a tenth and more about the slope of the curve;
    that is taken from the neighbors.
    """
    if stiffness is None:
        return Curve(pressure, separation, None, touch)
    with np.errstate(divide="ignore"):
        compliance = np.atleast_2d(1 / stiffness).mean(axis=0)
    return Curve(pressure, separation, compliance, touch)


def _mean(values: Array) -> Mean:
    # A map that is closed does not yield: its stiffness has no bound, and no scatter either.
    if not np.isfinite(values).all():
        return Mean(values.size, float(values.mean()), math.nan, math.nan, math.nan)
    return statistics.mean(values)


def _stiffness_of(branch: str) -> str:
    """Return which stiffness is the slope of a branch."""
    return "stiffness" if branch == LOADING else "unloading_stiffness"
