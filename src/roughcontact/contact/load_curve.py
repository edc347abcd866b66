"""Load curves: the same contact under one load after the other."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact import limits
from roughcontact.arguments import checked
from roughcontact.contact import resume
from roughcontact.contact.advice import RECOMMENDED, AgreedCeiling
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.checks import check, check_profile
from roughcontact.contact.curve import LoadCurve, LoadStep
from roughcontact.contact.judgment import over_loads
from roughcontact.contact.loads import GivenLoad, Load, on
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.resume import Place
from roughcontact.contact.solve import press
from roughcontact.contact.stiffness import ahead, growth, unloading_stiffness
from roughcontact.contact.terms import Terms
from roughcontact.errors import (
    ConvergenceError,
    InputError,
    Mention,
    Sentence,
    require_count,
)
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import RIGID, Material, softer
from roughcontact.solvers.bar import drawn
from roughcontact.solvers.bounded import Status
from roughcontact.solvers.progress import Progress, Tell, numbered
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, quantity

Array = NDArray[np.float64]

HELD = 5
"""Maps held while a step is prepared: pressure and gap of that before, their rates, the start."""


@drawn
@checked
def load_curve(
    surface: Surface,
    *,
    material: Material,
    loads: Quantities | Sequence[Quantity | Load] | None = None,
    approaches: Quantities | None = None,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    precision: str = "double",
    folder: str | os.PathLike[str] | None = None,
    progress: Tell = None,
) -> LoadCurve:
    """Solve a contact under one load after the other.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, ceiling, boundary, tolerance, \
max_iterations, precision
        As for `solve`. With ``"recommended"`` every load has its own ceiling.
    loads : sequence of float, str, quantity of pint, or `Load`
        Normal loads W, ascending: numbers in N, or in any form that `solve` takes, as ``"1 N"`` or
        ``"20 MPa"``; give either this or ``approaches``.
    approaches : sequence of float, str or quantity of pint
        Approaches ω [m], ascending.
    folder : path, optional
        Where every finished step is saved at once; made if it does not exist. The same call on
        the same folder goes on after the last finished step and ends with the same numbers.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`: the number of the load and the solver's `Step`.

    Returns
    -------
    LoadCurve
        The scalars of every step.

    Raises
    ------
    InputError
        If an argument cannot be used, or the folder is in use or holds another sweep.
    FormatError
        If a step in the folder is damaged, or of another load.
    CapacityError, InsufficientMemoryError
        As for `solve`; the largest load is checked before the first step.
    ConvergenceError
        If a step did not reach the tolerance; the steps before it stay in the folder.

    Notes
    -----
    Each solve starts from the load before it, whose pressure and gap go on as they grow where the
    stiffness is known. The model keeps no history: every step is the same as if it were solved
    alone, within its certificate.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(64)
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> curve = rc.load_curve(rc.Surface(heights, pixel), material=steel, loads=[0.1, 1, 10])
    >>> bool((np.diff(curve.column("contact_area")) > 0).all())
    True
    """
    if (loads is None) == (approaches is None):
        raise InputError(
            "give either ", Mention("loads"), " or ", Mention("approaches"),
            ", and only one of them",
        )  # fmt: skip
    pair = Pair(surface, material, counter_surface, counter_material, Boundary(boundary))
    terms = Terms(None, None, None, ceiling, tolerance, max_iterations, precision)
    asked = None if loads is None else [on(load, pair, "loads") for load in _listed(pair, loads)]
    sweep = _Sweep(
        pair,
        terms,
        "load" if approaches is None else "approach",
        _ascending(pair, None if asked is None else [force for force, _ in asked], approaches),
        tuple(given for _, given in asked or () if given is not None),
    )
    sweep.check()
    if folder is None:
        return sweep.curve(_steps(sweep, None, progress))
    with resume.claimed(
        folder, sweep.record(), kind="sweep", record="sweep.json", pattern="step-*.npz"
    ) as place:
        return sweep.curve(_steps(sweep, place, progress))


@dataclass(frozen=True, eq=False)
class _Sweep:
    """The loads or approaches wanted of two bodies."""

    pair: Pair
    terms: Terms
    control: str
    values: list[float]
    given: tuple[GivenLoad, ...] = ()

    def terms_at(self, value: float) -> Terms:
        """Return the terms of one load or approach."""
        if self.control == "load":
            return replace(self.terms, load=value)
        return replace(self.terms, approach=value)

    @property
    def own(self) -> bool:
        """Whether each load has a ceiling of its own."""
        ceiling = self.terms.ceiling
        return isinstance(ceiling, str) and ceiling == RECOMMENDED

    def check(self) -> None:
        """Raise what any step would raise; the largest asks for the most."""
        check_profile(self.pair, self.terms)
        largest = self.terms_at(self.values[-1])
        check(self.pair, largest, held=HELD, series=len(self.values) > 1)

    def record(self) -> dict[str, Any]:
        """Return what the steps depend on."""
        ceiling = self.terms.ceiling
        plain = isinstance(ceiling, str) or ceiling is None
        return {
            **self.pair.record(),
            "ceiling": ceiling if plain else resume.digest(ceiling),
            "boundary": str(self.pair.boundary),
            "tolerance": self.terms.tolerance,
            "max_iterations": self.terms.max_iterations,
            "precision": self.terms.precision,
            "control": self.control,
            "values": self.values,
        }

    def curve(self, solved: Iterable[tuple[LoadStep, Array]]) -> LoadCurve:
        """Return the solved steps with what they have in common."""
        pair, steps, judged = self.pair, [], []
        for step, pressure in solved:
            steps.append(step)
            cautions = self.seen(step, pressure).cautions
            judged.append((getattr(step, self.control), cautions))
        return LoadCurve(
            steps=tuple(steps),
            control=self.control,
            nominal_area=pair.size[0] * pair.size[1],
            contact_modulus=pair.contact_modulus,
            rms_gradient=roughness.rms_gradient(pair.initial_gap, pair.pixel),
            ceiling=RECOMMENDED if self.own else resolved_ceiling(self.terms.ceiling, pair),
            boundary=pair.boundary,
            origins=pair.origins,
            softer=pair.softer,
            is_profile=pair.is_profile,
            found=over_loads(judged, pair.load_unit if self.control == "load" else "m"),
            given=self.given,
        )

    def seen(self, step: LoadStep, pressure: Array) -> ContactResult:
        """Return a step as the result that it is judged by; of its gap only the holes count."""
        return ContactResult(
            pair=self.pair,
            ceiling=step.ceiling if self.own else resolved_ceiling(self.terms.ceiling, self.pair),
            precision=self.terms.precision,
            tolerance=self.terms.certificate,
            control=self.control,
            load=step.load,
            approach=step.approach,
            pressure=pressure,
            gap=self.pair.initial_gap,
            certificate=step.certificate,
            load_error=step.load_error,
            status=Status.CONVERGED.value,
            iterations=0,
            convolutions=step.convolutions,
            seconds=step.seconds,
            recommended=self._agreed(step) if self.own else None,
        )

    def _agreed(self, step: LoadStep) -> AgreedCeiling | None:
        """Return that the ceiling of a step was recommended; what else was found is not kept."""
        body = softer(self.pair.material, self.pair.counter_material)
        if body is None or not body.ceiling or not step.ceiling:
            return None
        if math.isclose(step.ceiling, body.ceiling):
            return None
        factor = step.ceiling / (body.yield_strength or math.nan)
        return AgreedCeiling(step.load, math.nan, factor, 0.0, 0, body.ceiling, *[math.nan] * 3)


def _steps(sweep: _Sweep, place: Place | None, progress: Tell) -> Iterator[tuple[LoadStep, Array]]:
    """Yield the steps with their pressures, each read from the folder or solved and kept there."""
    start: Array | None = None
    # Steps are named by their number, and each is complete once it is there.
    for number, value in enumerate(sweep.values, start=1):
        path = None if place is None else place.folder / f"step-{number:04d}.npz"
        # What makes a step one of this sweep, at this load.
        mark = {} if place is None else {"problem": place.problem, "asked": value}
        if path is not None and path.exists():
            step, pressure, start = _read_step(path, sweep.pair.shape, mark)
            if callable(progress):
                progress(Progress(number, len(sweep.values), None, kept=True))
        else:
            try:
                step, pressure, start = _solved_step(sweep, number, start, progress)
            except ConvergenceError as error:
                raise _unsolved(sweep, number, place, error) from None
            if path is not None:
                _write_step(path, step, pressure, start, mark)
        yield step, pressure


def _solved_step(
    sweep: _Sweep,
    number: int,
    start: Array | None,
    progress: Tell,
) -> tuple[LoadStep, Array, Array]:
    """Return a step and its pressure, and the pressure from which the next one starts."""
    result = press(
        sweep.pair,
        sweep.terms_at(sweep.values[number - 1]),
        start=start,
        progress=numbered(progress, number, len(sweep.values)),
    )
    # First, so that what it takes is free again.
    whole = unloading_stiffness(result) if result.saturated.any() else None
    grown = growth(result)
    following = result.pressure
    if number < len(sweep.values):
        following = ahead(result, grown, **{sweep.control: sweep.values[number]})
    return _step(result, grown.stiffness, whole), result.pressure, following


def _unsolved(
    sweep: _Sweep, number: int, place: Place | None, error: ConvergenceError
) -> ConvergenceError:
    unit = sweep.pair.load_unit if sweep.control == "load" else "m"
    at = f"{sweep.control} = {sweep.values[number - 1]:.6g} {unit}"
    kept = "" if place is None else f"; the steps before it are kept in {place.folder}"
    return ConvergenceError(
        Sentence(f"step {number} of {len(sweep.values)}, {at}: ", *error.parts, kept),
        error.result,
    )


@checked
def spaced(first: float, last: float, number: int, spacing: str = "log") -> list[float]:
    """Return loads or approaches between two ends.

    Parameters
    ----------
    first, last : float
        The ends, ``0 < first < last``.
    number : int
        How many, both ends included; 2 to 10,000.
    spacing : {"log", "linear"}
        Equal ratios or equal differences.

    Returns
    -------
    list of float
        Ascending values; the ends are exact.

    Raises
    ------
    InputError
        If the ends or the number do not fit.

    Examples
    --------
    >>> spaced(1, 100, 3), spaced(1, 5, 3, "linear")
    ([1.0, 10.0, 100.0], [1.0, 3.0, 5.0])
    """
    if spacing not in ("log", "linear"):
        raise InputError(
            f"must be 'log' or 'linear', got {spacing!r}", argument="spacing", value=spacing
        )
    if not (0 < first < last < math.inf):
        raise InputError(f"the first value must be positive and below the last: {first}, {last}")
    require_count(2, limits.STEPS, number=number)
    values = (np.geomspace if spacing == "log" else np.linspace)(first, last, number)
    return [float(value) for value in values]


def _listed(pair: Pair, loads: Any) -> list[Any]:
    """Return loads one by one; a quantity of pint may hold all of them."""
    if not hasattr(loads, "m_as"):
        return list(loads)
    return list(quantity(loads, pair.load_dimension, "loads"))


def _ascending(pair: Pair, loads: Quantities | None, approaches: Quantities | None) -> list[float]:
    name, dimension = "approaches", "length"
    if loads is not None:
        name, dimension = "loads", pair.load_dimension
    given: list[Any] = list(quantity(approaches if loads is None else loads, dimension, name))
    if not given:
        raise InputError("is empty: give at least one value", argument=name)
    if not all(isinstance(value, Real) and 0 < float(value) < math.inf for value in given):
        raise InputError(f"must be positive and finite, got {given}", argument=name)
    values = [float(value) for value in given]
    if any(second <= first for first, second in pairwise(values)):
        raise InputError(f"must ascend, got {given}; sort them", argument=name)
    return values


def _step(result: ContactResult, stiffness: float, unloading: float | None) -> LoadStep:
    spots = result.spots()
    return LoadStep(
        load=result.load,
        approach=result.approach,
        contact_area=result.contact_area,
        corrected_contact_area=result.corrected_contact_area,
        saturated_area=result.saturated_fraction * result.pressure.size * result.pixel_area,
        max_pressure=result.max_pressure,
        mean_gap=result.mean_gap,
        stiffness=stiffness,
        unloading_stiffness=stiffness if unloading is None else unloading,
        spots=spots.count,
        mean_spot_area=float(spots.area.mean()) if spots.count else 0.0,
        largest_spot_area=float(spots.area[0]) if spots.count else 0.0,
        certificate=result.certificate,
        load_error=result.load_error,
        convolutions=result.convolutions,
        seconds=result.seconds,
        ceiling=result.ceiling if isinstance(result.ceiling, float) else math.nan,
    )


# Steps on disk


def _write_step(
    path: Path, step: LoadStep, pressure: Array, following: Array, mark: Mapping[str, Any]
) -> None:
    index, start = np.flatnonzero(pressure), np.flatnonzero(following)
    arrays = {
        "index": index,
        "pressure": pressure.ravel()[index],
        "following_index": start,
        "following": following.ravel()[start],
        **asdict(step),
    }
    resume.write_step(path, arrays, mark)


def _read_step(
    path: Path, shape: tuple[int, int], mark: Mapping[str, Any]
) -> tuple[LoadStep, Array, Array]:
    names = [field.name for field in fields(LoadStep)]
    held = ("index", "pressure", "following_index", "following", *names)
    arrays = resume.read_step(path, held, mark, "sweep")
    pressure, following = np.zeros(shape), np.zeros(shape)
    pressure.ravel()[arrays["index"]] = arrays["pressure"]
    following.ravel()[arrays["following_index"]] = arrays["following"]
    values: dict[str, Any] = {
        field.name: (int if field.type == "int" else float)(arrays[field.name])
        for field in fields(LoadStep)
    }
    return LoadStep(**values), pressure, following
