"""Wear of a contact by Archard's law, in implicit steps.

The local form of Archard's law is dh = -k p ds. A step of backward Euler, h⁺ = h - k Δs p⁺, changes
the contact conditions of the worn bodies,

    g = K p⁺ + h₀ + k Δs p⁺ - ω ≥ 0,    0 ≤ p⁺ ≤ ceiling,    p⁺ g = 0 below the ceiling,

only in the operator: each pixel has the compliance k Δs in addition, as on a Winkler foundation. So
one bounded solve with its certificate gives the pressure after the step, and the step is stable for
any length. The flow is contractive: errors of the steps add up, and do not grow.

In a step, m = ½ Σ|Δp| / Σp is the part of the load that moves from some pixels to others. Steps
grow or shrink towards a given m. Later wear removes the errors of early steps, so that m is no
measure of the error: the last step is repeated as two steps of half its length, whose result is
kept (``Wear.step_errors``).

Archard 1953, doi:10.1063/1.1721448; steps of computed wear after Põdra and Andersson 1999,
doi:10.1016/S0301-679X(99)00012-2
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import checkpoints, memory
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.checkpoints import RunFolder
from roughcontact.cautions import Caution
from roughcontact.contact import validation
from roughcontact.contact.ceiling import first_ceiling, is_bracket
from roughcontact.contact.load_case import GivenLoad, Load, LoadCase, resolve_force
from roughcontact.contact.nominal_hertz import is_nominal_origin
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.result import BASE, ContactResult
from roughcontact.contact.series import StepResult
from roughcontact.contact.solve import solve_pair
from roughcontact.errors import ArgumentRef, InputError, input_error, require_choice, require_count
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.gpu import runs_on_device
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers.operator import Family
from roughcontact.solvers.progress import Progress, Tell, progress_callback, shows_progress_bar
from roughcontact.surface import roughness
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.resolution import LimitCause, noise_height
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, format_engineering, format_lengths, to_si

SLIDING, FRETTING = "sliding", "fretting"
"""Motions: each point meets all of a smooth counter-body, or always the same point of it."""

CONFORMING, UNIFORM = 0.99, 0.05
"""Contact fraction from which bodies conform, if no larger part of the load than the second would
have to move for a uniform pressure."""

MAX_MOVED = 0.2
"""Default of the part of the load that moves to other pixels in a step."""

MAX_HELD_RESULTS = 8
"""Maps in memory while a step is solved: wear, both bodies, pressure and gap of two contacts."""

FILES, RECORD = "step-*.npz", "wear.json"
"""Files of the steps in a folder, and their record."""

# Compliance of the first step over that of a pixel, and largest growth from step to step.
_FIRST, _GROWTH = 0.2, 3.0
# Excess of the moved part at which a step is repeated, the smallest factor of its length, and the
# maximum number of solves: an inaccurate start moves load in any step.
_EXCESS, _SHORTEN, _MAX_SOLVES = 2.0, 0.25, 6
# Relative distance from a target that is covered with the step before it.
_REACHED = 1e-12
# Metals have 1e-17 to 1e-11 m²/N; larger numbers are dimensionless coefficients.
_MAX_COEFFICIENT = 1e-9


@dataclass(frozen=True, eq=False)
class WearingPair(Pair):
    """Pair of bodies in an implicit step of wear."""

    compliance: float = 0.0  # Wear of both bodies in the step over the pressure, k Δs [m/Pa]

    @classmethod
    def from_pair(cls, pair: Pair, compliance: float) -> WearingPair:
        """Return a pair in a step with this wear over the pressure [m/Pa]."""
        return cls(**{f.name: getattr(pair, f.name) for f in fields(Pair)}, compliance=compliance)

    def operators(self, precision: str, workspace: Workspace, softness: float = 1.0) -> Family:
        """Return a factory of the displacement operator, with the wear of the step."""
        make: Any = super().operators(precision, workspace, softness)
        return lambda *grid: make(*grid).with_foundation(self.compliance * softness)


@dataclass(frozen=True)
class WearStep:
    """Scalars of the worn contact at one distance."""

    distance: float  # Sliding distance [m]
    wear: float  # Mean wear depth of both bodies [m]
    max_wear: float  # Largest wear depth of both bodies [m]
    contact_area: float  # [m²]
    saturated_area: float  # [m²]
    mean_pressure: float  # Load over contact area [Pa]
    max_pressure: float  # Largest pressure [Pa]
    mean_gap: float  # Mean open gap [m]
    Sq: float  # Root-mean-square height of the worn body [m]
    Ssk: float  # Skewness of its heights
    Spk: float  # Reduced peak height [m]
    moved: float  # Part of the load that moved to other pixels in the step
    certificate: float  # Certificate ε
    load_error: float  # Relative error of the load
    convolutions: int  # Number of convolutions on the full grid
    seconds: float  # Wall time of the step


@dataclass(frozen=True, eq=False, repr=False)
class Wear(StepResult):
    """Wear of a contact over a sliding distance.

    Parameters
    ----------
    steps : tuple of WearStep
        The contact before wear and after each step.
    coefficients : (float, float)
        Wear coefficients of the body and of the counter-body [m²/N].
    distances : tuple of float
        Requested distances [m], ascending.
    motion : {"sliding", "fretting"}
        As given.
    first, last : ContactResult
        Contact of the bodies before wear, and of the worn bodies.
    step_errors : dict
        Relative change of ``contact_area``, ``max_pressure`` and ``depth`` (the part of the wear
        at other places) where the last step is divided in two; the error is about as large.
    friction : float or None
        Friction coefficient.
    base : Wear or None
        The same under the ceiling of the base of a coated body, if both were requested.
    """

    steps: tuple[WearStep, ...]
    coefficients: tuple[float, float]
    distances: tuple[float, ...]
    motion: str
    first: ContactResult
    last: ContactResult
    step_errors: Mapping[str, float]
    friction: float | None = None
    base: Wear | None = None

    @property
    def worn(self) -> Surface:
        """The worn body, unloaded."""
        return self.last.surface

    @property
    def worn_counter(self) -> Surface | None:
        """The worn counter-body, unloaded; ``None`` for a flat that keeps its shape."""
        return self.last.counter_surface

    @property
    def depth(self) -> Array:
        """Wear depth of both bodies [m], NaN where missing, shape (ny, nx)."""
        return self.first.pair.heights - self.last.pair.heights

    @property
    def distance(self) -> float:
        """Distance reached [m]."""
        return self.steps[-1].distance

    @property
    def conforms(self) -> bool:
        """Whether more than 99 % of the points touch, under a nearly uniform pressure."""
        return _conforms(self.last.pressure, np.isfinite(self.last.gap))

    @property
    def volumes(self) -> tuple[float, ...]:
        """Worn volumes of the body and of the counter-body [m³], k W s."""
        return tuple(k * self.last.load * self.distance for k in self.coefficients)

    @property
    def wear_rate(self) -> float:
        """Mean wear depth of both bodies over the distance, k p̄ [m/m]."""
        shaping = sum(_shape_coefficients(self.coefficients, self.motion))
        return shaping * self.last.load / self.last.touchable_area

    @property
    def friction_work(self) -> float | None:
        """Work of friction μ W s [J]; ``None`` without a friction coefficient."""
        return None if self.friction is None else self.friction * self.last.load * self.distance

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the contact of the worn bodies."""
        return self.last.cautions


@shows_progress_bar
@runs_on_device
@validate_arguments
def wear(
    surface: Surface,
    *,
    material: Material,
    load: Quantity | Load,
    distance: Quantity | Quantities,
    wear_coefficient: Quantity = 0.0,
    counter_wear_coefficient: Quantity = 0.0,
    motion: str = SLIDING,
    friction: float | None = None,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    device: str | None = None,
    max_moved: float = MAX_MOVED,
    steps: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Tell = None,
) -> Wear:
    """Wear two bodies that slide under a load.

    Parameters
    ----------
    surface, material, load, counter_material, counter_surface, boundary, max_iterations, device
        As for `solve`.
    distance : float, str, quantity of pint, or several of them
        Sliding distance [m]; several are reached one after the other.
    wear_coefficient, counter_wear_coefficient : float, str or quantity of pint
        Worn volume over load and distance k of the body and of the counter-body [m²/N], such as
        ``"1e-15 m2/N"`` or ``"1e-6 mm3/Nm"``. A dimensionless coefficient K is k times the
        hardness.
    motion : {"sliding", "fretting"}
        ``"sliding"``: each point of the body meets all of a smooth counter-body, whose wear is even
        and does not change its shape. ``"fretting"``: the slip is shorter than the asperities, so
        that the same points meet; both bodies may be rough, and both change their shape.
    friction : float, optional
        Friction coefficient, for the work of friction. It does not change the pressure.
    ceiling
        As for `solve`; ``"calibrated"`` is that of the contact before wear.
    tolerance : float
        Certificate ε of every step; 1e-6 by default.
    max_moved : float
        Largest part of the load that a step should move to other pixels; a smaller part gives
        smaller steps.
    steps : int, optional
        Number of equal steps over the whole distance, instead of ``max_moved``.
    folder : path, optional
        Folder in which every finished step is saved; created if missing. The same call with the
        same folder resumes after the last finished step, with identical results.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is called with a `Progress`.

    Returns
    -------
    Wear
        The scalars of every step, and the worn bodies. It ends at more than 99 % contact: from
        there the bodies wear uniformly.

    Raises
    ------
    InputError
        If an argument cannot be used, a rough counter-body slides, or the wear is less than the
        noise of the map.
    CapacityError, InsufficientMemoryError, ConvergenceError
        As for `solve`.

    Notes
    -----
    Archard's law holds at each pixel, dh = -k p ds, with one k per body. A step is implicit,
    h⁺ = h - k Δs p⁺: one solve in which each pixel has the additional compliance k Δs. Wear
    removes k W s in total, to the accuracy of the load. The pressure of the last step is solved
    again on the worn bodies. Debris leaves the contact, friction heat is neglected, and pixels at
    the ceiling do not change their height other than by wear.

    Wear coefficients scatter by a factor of two and more between equal tests. Contact and
    roughness at a given wear depth do not depend on them.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> result = rc.wear(rc.Surface(*rc.reference_map(32)), material=steel, boundary="periodic",
    ...     load="50 MPa", wear_coefficient="1e-15 m2/N", distance="1 m")
    >>> bool(result.last.contact_fraction > 2 * result.first.contact_fraction)
    True
    """
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    force, specified = resolve_force(load, pair)
    coefficients = (
        _coefficient(wear_coefficient, "wear_coefficient"),
        _coefficient(counter_wear_coefficient, "counter_wear_coefficient"),
    )
    require_choice((SLIDING, FRETTING), motion=motion)
    shaping = _shape_coefficients(coefficients, motion)
    _check_motion(pair, motion, shaping)
    if not 0 < max_moved < 1:
        raise input_error("max_moved", max_moved, "must be between 0 and 1")
    if steps is not None:
        require_count(1, memory.STEPS, steps=steps)
    if friction is not None and not 0 <= friction < math.inf:
        raise input_error("friction", friction, "must not be negative")
    terms = LoadCase(force, None, None, first_ceiling(pair, ceiling), tolerance, max_iterations)
    validation.check_profile(pair, terms)
    validation.check_problem(pair, terms, held=MAX_HELD_RESULTS)
    run = _Run(pair, terms, shaping, _distances(distance), max_moved, steps)
    run.check_noise()
    stated = {"coefficients": coefficients, "motion": motion, "friction": friction}
    result = run.result(folder, progress, specified, **stated)
    if not is_bracket(pair, ceiling):
        return result
    run, below = replace(run, terms=replace(terms, ceiling=BASE)), folder and Path(folder) / BASE
    return replace(result, base=run.result(below, progress, specified, **stated))


def _coefficient(value: Any, argument: str) -> float:
    """Return a wear coefficient [m²/N]."""
    result = float(to_si(value, "wear coefficient", argument))
    if not 0 <= result <= _MAX_COEFFICIENT:
        text = "must be a wear coefficient such as '1e-15 m2/N': divide K by the hardness"
        raise input_error(argument, value, text)
    return result


def _distances(value: Any) -> tuple[float, ...]:
    row = validation.as_finite_row(to_si(value, "length", "distance"), "distance")
    distances = tuple(map(float, row))
    if not (np.diff(row, prepend=0.0) > 0).all():
        text = f"must be positive and ascending, got {format_lengths(distances, ', ')}"
        raise InputError(text, argument="distance", value=value)
    return distances


def _shape_coefficients(coefficients: tuple[float, float], motion: str) -> tuple[float, float]:
    """Return the wear coefficients of the bodies whose shape changes."""
    return coefficients if motion == FRETTING else (coefficients[0], 0.0)


def _check_motion(pair: Pair, motion: str, shaping: tuple[float, float]) -> None:
    """Raise `InputError` for bodies that cannot wear in this motion."""
    counter, other = pair.counter_surface, ArgumentRef("motion", FRETTING)
    if not any(shaping):
        raise InputError(
            "is needed, such as '1e-15 m2/N'; a sliding counter-body wears evenly and keeps its "
            f"shape: swap the bodies, or give {other}",
            argument="wear_coefficient",
        )
    if motion == SLIDING and counter is not None and not is_nominal_origin(counter.provenance):
        raise InputError(
            "is rough: sliding bodies meet at ever new positions, and a solve has only one. Give a "
            f"smooth counter-body, or {other} for slip shorter than the asperities",
            argument="counter_surface",
        )


@dataclass(frozen=True, eq=False)
class _State:
    """State after a step."""

    distance: float  # [m]
    depth: Array  # Wear depth of both bodies [m]
    pressure: Array  # [Pa]
    proposed: float  # Compliance of the next step [m/Pa]
    compliance: float = 0.0  # Compliance of the step [m/Pa]


@dataclass(frozen=True, eq=False)
class _Run:
    """Requested wear of two bodies."""

    pair: Pair
    terms: LoadCase
    shaping: tuple[float, float]  # Wear coefficients of the bodies whose shape changes [m²/N]
    distances: tuple[float, ...]
    max_moved: float
    count: int | None

    @cached_property
    def touchable(self) -> NDArray[np.bool_]:
        """Points without a hole in either body."""
        return np.isfinite(self.pair.heights)

    @property
    def targets(self) -> list[float]:
        """Distances at which a step ends [m]."""
        even = np.linspace(0, self.distances[-1], (self.count or 0) + 1)[1:]
        return sorted({*map(float, even), *self.distances})

    def check_noise(self) -> None:
        """Raise `InputError` if the wear is less than the noise of the map."""
        body = self.measured_body(self.pair)
        mean = sum(self.shaping) * self.terms.target * self.distances[-1] / math.prod(body.size)
        waves = [x.wave for x in body.resolution_limits() if x.cause is LimitCause.NOISE]
        noise = noise_height(body.filled(1.0).heights, body.pixel) if waves else 0.0
        if mean < noise:
            raise InputError(
                f"wears {format_engineering(mean, 'm', 2)} on average, less than the noise of the "
                f"map, {format_engineering(noise, 'm', 2)}: only noise would wear. Give a longer "
                "one, or remove the noise with ",
                ArgumentRef("s", format_engineering(waves[0], "m", 3)),
                argument="distance",
            )

    def measured_body(self, pair: Pair) -> Surface:
        """Return the body whose roughness is reported."""
        return pair.surface if self.shaping[0] else pair.counter_surface or pair.surface

    def worn_bodies(self, depth: Array, *notes: Operation) -> Pair:
        """Return the worn bodies."""
        bodies: list[Surface | None] = [self.pair.surface, self.pair.counter_surface]
        for number, coefficient in enumerate(self.shaping):
            if not coefficient:
                continue
            body = bodies[number] or Surface(np.zeros(depth.shape), self.pair.pixel, _FLAT)
            heights = body.heights - coefficient / sum(self.shaping) * depth
            provenance = replace(body.provenance, operations=(*body.provenance.operations, *notes))
            bodies[number] = replace(body, heights=heights, provenance=provenance)
        assert bodies[0] is not None
        return replace(self.pair, surface=bodies[0], counter_surface=bodies[1])

    def follow_distance(
        self, place: RunFolder | None, progress: Tell
    ) -> tuple[tuple[WearStep, ...], tuple[ContactResult, ContactResult], dict[str, float]]:
        """Return the steps, the contacts before and after them, and the errors of the last."""
        first = solve_pair(self.pair, self.terms, progress=progress_callback(progress, 1, 2))
        run = replace(self, terms=replace(self.terms, ceiling=first.ceiling))
        start = _FIRST * self.pair.pixel[1] / self.pair.contact_modulus
        states = [_State(0.0, np.zeros(self.pair.shape), first.pressure, start)]
        steps, last, errors = [run.record(first, states[0])], first, dict.fromkeys(_ERRORS, 0.0)
        for step, state in run.iter_steps(states[0], place, progress):
            steps.append(step)
            states = [states[-1], state]
        if len(states) > 1:
            # The last step, in two halves.
            before, after = states
            half = replace(run, count=1)
            _, state = half.advance(before, 0.5 * (before.distance + after.distance), None)
            end, state = half.advance(state, after.distance, None)
            mean = format_engineering(end.wear, "m", 3)
            pair = run.worn_bodies(state.depth, Operation("worn", {"mean": mean}))
            last = solve_pair(pair, run.terms, start=state.pressure)
            whole = steps.pop()
            errors = {name: getattr(end, name) / getattr(whole, name) - 1 for name in _ERRORS}
            errors["depth"] = _moved_share(after.depth, state.depth)
            costs = _costs([whole, end, last])
            steps.append(replace(run.record(last, state), moved=whole.moved, **costs))
        return tuple(steps), (first, last), errors

    def iter_steps(
        self, state: _State, place: RunFolder | None, progress: Tell
    ) -> Iterator[tuple[WearStep, _State]]:
        """Yield the steps, each read from the folder or solved and saved."""
        number = 1
        for target in self.targets:
            while state.distance < target * (1 - _REACHED):
                if _conforms(state.pressure, self.touchable):
                    return
                saved = None if place is None else _read_step(place, number, state)
                if saved is not None and callable(progress):
                    progress(Progress(number, number + 1, None, kept=True))
                watch = progress_callback(progress, number, number + 1)
                step, state = saved or self.advance(state, target, watch)
                if place is not None and saved is None:
                    _write_step(place, number, step, state)
                yield step, state
                number += 1

    def advance(self, state: _State, target: float, watch: Any) -> tuple[WearStep, _State]:
        """Return the step towards a distance, and the state after it."""
        remaining = sum(self.shaping) * (target - state.distance)
        wanted = remaining if self.count else state.proposed
        # The last two steps to a target are equal, so that none is tiny.
        compliance = wanted if remaining > 2 * wanted else remaining / (1 + (remaining > wanted))
        worn, solved = self.worn_bodies(state.depth), []
        while True:
            pair = WearingPair.from_pair(worn, compliance)
            result = solve_pair(pair, self.terms, start=state.pressure, progress=watch)
            solved.append(result)
            moved = _moved_share(state.pressure, result.pressure)
            enough = self.count or moved <= _EXCESS * self.max_moved
            if enough or len(solved) == _MAX_SOLVES:
                break
            compliance *= max(_SHORTEN, self.max_moved / moved)
        growth = min(max(self.max_moved / max(moved, 1e-9), 1 / _GROWTH), _GROWTH)
        # A step that was shortened only to end at the target does not shorten the next one.
        proposed = max(compliance * growth, wanted if moved < self.max_moved else 0.0)
        distance = state.distance + compliance / sum(self.shaping)
        distance, depth = min(distance, target), state.depth + compliance * result.pressure
        after = _State(distance, depth, result.pressure, proposed, compliance)
        step = self.record(replace(result, pair=self.worn_bodies(after.depth)), after)
        return replace(step, moved=moved, **_costs(solved)), after

    def record(self, result: ContactResult, state: _State) -> WearStep:
        """Return the scalars of a contact of the worn bodies."""
        heights = self.measured_body(result.pair).heights
        height = roughness.height_parameters(heights)
        return WearStep(
            **{name: getattr(result, name) for name in _OF_CONTACT},
            distance=state.distance,
            wear=float(state.depth.sum()) / int(self.touchable.sum()),
            max_wear=float(state.depth.max()),
            saturated_area=result.saturated_fraction * result.nominal_area,
            mean_pressure=result.load / result.contact_area,
            Sq=height["Sq"],
            Ssk=height["Ssk"],
            Spk=roughness.core_parameters(*roughness.material_ratio_curve(heights))["Spk"],
            moved=0.0,
        )

    def result(
        self, folder: Any, progress: Tell, specified: GivenLoad | None, **stated: Any
    ) -> Wear:
        """Return the wear over the whole distance."""
        with checkpoints.lock_folder(
            folder, self.inputs, kind="wear", record=RECORD, pattern=FILES
        ) as place:
            solved, (first, last), errors = self.follow_distance(place, progress)
        return Wear(
            solved,
            distances=self.distances,
            first=replace(first, specified_load=specified),
            last=replace(last, specified_load=specified),
            step_errors=errors,
            **stated,
        )

    def inputs(self) -> dict[str, Any]:
        """Return the record of the inputs of the steps."""
        ceiling = self.terms.ceiling
        held = ceiling if isinstance(ceiling, str | None) else checkpoints.digest_arrays(ceiling)
        record = {**self.pair.record(), "boundary": str(self.pair.boundary), "ceiling": held}
        terms = ("load", "tolerance", "max_iterations")
        record |= {name: getattr(self.terms, name) for name in terms}
        record |= {"distance": self.distances, "wear_coefficients": self.shaping}
        return record | {"max_moved": self.max_moved, "steps": self.count}


_FLAT = Provenance("flat")
_ERRORS = ("contact_area", "max_pressure")
_OF_CONTACT = (*_ERRORS, "mean_gap", "certificate", "load_error", "convolutions", "seconds")


def _costs(solved: list[Any]) -> dict[str, Any]:
    """Return the cost of several solves."""
    names = ("convolutions", "seconds")
    return {name: sum(getattr(item, name) for item in solved) for name in names}


def _conforms(pressure: Array, touchable: NDArray[np.bool_]) -> bool:
    """Return whether nearly all points touch, under a nearly uniform pressure."""
    inside = pressure[touchable]
    touching = int(np.count_nonzero(inside)) > CONFORMING * inside.size
    return touching and _moved_share(np.full(inside.shape, inside.mean()), inside) < UNIFORM


def _moved_share(before: Array, after: Array) -> float:
    """Return the part of a sum that two maps with this sum have at other pixels."""
    return float(np.abs(after - before).sum() / after.sum()) / 2


def _file(place: RunFolder, number: int) -> tuple[Path, dict[str, Any]]:
    """Return the file of a step, and the record that identifies it."""
    return place.folder / f"step-{number:04d}.npz", {"problem": place.problem, "number": number}


def _write_step(place: RunFolder, number: int, step: WearStep, state: _State) -> None:
    file, mark = _file(place, number)
    arrays: dict[str, Any] = checkpoints.pack_map("pressure", state.pressure)
    arrays |= {"proposed": state.proposed, "compliance": state.compliance}
    checkpoints.write_step(file, step, arrays, mark)


def _read_step(place: RunFolder, number: int, before: _State) -> tuple[WearStep, _State] | None:
    """Return a saved step and the state after it; None if there is none."""
    file, mark = _file(place, number)
    if not file.exists():
        return None
    names = "index", "pressure", "proposed", "compliance"
    step, arrays = checkpoints.read_step(file, WearStep, names, mark, "wear")
    pressure = checkpoints.unpack_map(arrays, "pressure", before.pressure.shape)
    compliance = float(arrays["compliance"])
    depth, proposed = before.depth + compliance * pressure, float(arrays["proposed"])
    return step, _State(step.distance, depth, pressure, proposed, compliance)
