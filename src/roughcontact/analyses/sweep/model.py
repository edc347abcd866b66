"""Load curves: contact under ascending loads."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import checkpoints
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.checkpoints import RunFolder
from roughcontact.cautions import Caution
from roughcontact.contact.ceiling import is_bracket, resolve_ceiling
from roughcontact.contact.load_case import GivenLoad, Load, LoadCase, resolve_force
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.plausibility import over_loads
from roughcontact.contact.result import BASE, CALIBRATED, COATING, CalibrationRecord, ContactResult
from roughcontact.contact.series import StepResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.stiffness import contact_growth, predict_pressure, unloading_stiffness
from roughcontact.contact.validation import check_problem, check_profile
from roughcontact.errors import ArgumentRef, ConvergenceError, InputError, Sentence
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.gpu import runs_on_device
from roughcontact.material.material import RIGID, Material, softer_material
from roughcontact.solvers.progress import Progress, Tell, progress_callback, shows_progress_bar
from roughcontact.surface import roughness
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.theory import persson
from roughcontact.uncertainty.measurement import check, uncertainty
from roughcontact.units import Quantities, Quantity, to_si

LOW_LOAD = 0.05
"""Contact fraction up to which the area is treated as proportional to the load."""

LOW_SATURATION = 0.1
"""Saturated share of the contact area up to which a contact is treated as elastic."""


@dataclass(frozen=True)
class LoadStep:
    """Scalars of one solved load."""

    load: float  # W [N]
    approach: float  # ω [m]
    contact_area: float  # Real contact area [m²]: the pixels with pressure
    perimeter_corrected_area: float  # Contact area without the excess of spot perimeters [m²]
    saturated_area: float  # Area at the ceiling [m²]
    max_pressure: float  # Largest pressure [Pa]
    mean_gap: float  # Mean open gap [m]
    stiffness: float  # dW/dω on further loading [N/m]
    unloading_stiffness: float  # dW/dω on unloading [N/m]
    spots: int  # Number of contact spots
    mean_spot_area: float  # [m²]
    largest_spot_area: float  # [m²]
    certificate: float  # Certificate ε
    load_error: float  # Relative error of the load
    convolutions: int  # Number of convolutions on the full grid
    seconds: float  # Wall time of the solve
    ceiling: float = math.nan  # Largest pressure allowed [Pa]


@dataclass(frozen=True, eq=False, repr=False)
class LoadCurve(StepResult):
    """Contact over load, with simple laws.

    Parameters
    ----------
    steps : tuple of LoadStep
        The solved loads, ascending.
    control : {"load", "approach"}
        Whether loads or approaches were given.
    nominal_area : float
        Area of the whole map [m²].
    contact_modulus : float
        E* [Pa]; NaN for coated bodies, for which the theories here do not hold.
    rms_gradient : float
        h′ of the gap at first touch.
    ceiling : float, ndarray of shape (ny, nx), "calibrated" or None
        Largest pressure allowed [Pa]; a calibrated ceiling of each load is in the steps.
    boundary : Boundary
        Boundary condition.
    origins : tuple of Provenance
        Origin and preparation of the maps, the counter-body last.
    softer : Material or None
        The body with the smaller ceiling; None without a known strength.
    messages : tuple of Caution
        Cautions on the contacts under these loads.
    extra_cautions : tuple of Caution
        Remarks on the measurement of the maps.
    is_profile : bool
        Whether the bodies are profiles: loads are per length [N/m], areas lengths [m].
    specified_load : tuple of GivenLoad
        The loads that were not given as forces, in their given form.
    intervals : tuple of Uncertainty
        Intervals of each load that include the instrument, if computed.
    base : LoadCurve, optional
        The same loads under the ceiling of the base of a coated body, if both were requested.
    contact : ContactResult, optional
        Contact under the last load with its changes under the calibrated ceiling, if computed.
    _solve_largest : callable, optional
        Function that solves the contact under the last load again, for a report.
    """

    steps: tuple[LoadStep, ...]
    control: str
    nominal_area: float
    contact_modulus: float
    rms_gradient: float
    ceiling: float | NDArray[np.float64] | str | None
    boundary: Boundary
    origins: tuple[Provenance, ...]
    softer: Material | None = None
    messages: tuple[Caution, ...] = ()
    extra_cautions: tuple[Caution, ...] = ()
    is_profile: bool = False
    specified_load: tuple[GivenLoad, ...] = ()
    intervals: tuple[Any, ...] = ()
    base: LoadCurve | None = None
    contact: ContactResult | None = None
    _solve_largest: Callable[[], ContactResult] | None = field(default=None, repr=False)

    @cached_property
    def largest(self) -> ContactResult:
        """Contact under the last load, solved again from its pressure."""
        if self.contact is not None:
            return self.contact
        if self._solve_largest is None:
            raise InputError("this load curve has no contacts: compute the curve again")
        return self._solve_largest()

    @property
    def source(self) -> str:
        """Origin of the map."""
        return self.origins[0].source

    @property
    def preparation(self) -> tuple[str, ...]:
        """Preparation of the map, one sentence per step."""
        return self.origins[0].steps

    @property
    def constriction_length(self) -> Array:
        """Constriction length 2 (dW/dω)/E* of the whole contact [m], shape (n,).

        Of bodies without coating; saturated pixels are included. The constriction length over the
        sum of the resistivities of the two bodies is the electrical conductance, likewise thermal
        (Barber 2003, doi:10.1098/rspa.2002.1038). A circle of radius a has 4 a, elastic or
        saturated: yielded metal conducts.
        """
        return 2 * self.column("unloading_stiffness") / self.contact_modulus

    @cached_property
    def low_loads(self) -> NDArray[np.bool_]:
        """Whether a load has little contact (5 %) and little saturation (10 %), shape (n,)."""
        area, load = self.column("perimeter_corrected_area"), self.column("load")
        return (
            (area <= LOW_LOAD * self.nominal_area)
            & (self.column("saturated_area") <= LOW_SATURATION * area)
            & (load > 0)
        )

    @cached_property
    def low_load_slope(self) -> float:
        """Low-load slope κ of A = κ W/(E* h′), up to 5 % contact.

        Least squares through the origin on the perimeter-corrected contact area of the `low_loads`,
        at which no more than a tenth of it is saturated; without low loads, the secant from the
        origin to the smallest load, for which there is no theory. NaN without load. Theory:
        √(2π) = 2.5 (Bush, Gibson and Thomas 1975), √(8/π) = 1.6 (Persson 2001); boundary elements:
        1.8 to 2.3 (Hyun et al. 2004). The slope is meaningful only with many contact spots.
        """
        area, load = self.column("perimeter_corrected_area"), self.column("load")
        taken = self.low_loads
        if not taken.any():
            if not (load > 0).any():
                return math.nan
            taken = load == load[load > 0].min()
        slope = float(area[taken] @ load[taken] / (load[taken] @ load[taken]))
        return slope * self.contact_modulus * self.rms_gradient

    @property
    def persson(self) -> tuple[Array, Array]:
        """Contact and saturated area by Persson's theory [m²], each of shape (n,).

        The mean of a ceiling per pixel is used. NaN where the mean pressure exceeds the ceiling,
        and for coated bodies.
        """
        ceiling = self.ceiling
        fixed = None if ceiling is None or isinstance(ceiling, str) else float(np.mean(ceiling))
        pairs = []
        for step in self.steps:
            mean = step.load / self.nominal_area
            limit = step.ceiling if isinstance(ceiling, str) else fixed
            unknown = math.isnan(self.contact_modulus) or (limit is not None and mean > limit)
            if mean == 0 or unknown:
                pairs.append((0.0, 0.0) if mean == 0 else (math.nan, math.nan))
            else:
                pairs.append(
                    persson.persson_fractions(mean, self.contact_modulus, self.rms_gradient, limit)
                )
        table = np.array(pairs).reshape(-1, 2) * self.nominal_area
        return table[:, 0], table[:, 1]


MAX_HELD_RESULTS = 5
"""Maps in memory while a step is prepared: last pressure and gap, their rates, start."""


@shows_progress_bar
@runs_on_device
@validate_arguments
def sweep(
    surface: Surface,
    *,
    material: Material,
    loads: str | Quantities | Sequence[Quantity | Load] | None = None,
    approaches: Quantities | None = None,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    precision: str = "double",
    device: str | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Tell = None,
) -> LoadCurve:
    """Compute a load curve: the contact under ascending loads.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, ceiling, boundary, tolerance, \
max_iterations, precision, device
        As for `solve`. With ``"calibrated"`` the ceiling is calibrated for each load; with
        ``"bracket"`` the curve is that of the coating, and its ``base`` that of the base.
    loads : sequence of float, str, quantity of pint, or `Load`
        Normal loads W, ascending: numbers in N, or any form that `solve` takes, such as ``"1 N"``
        or ``"20 MPa, 50 MPa"``; give either this or ``approaches``.
    approaches : sequence of float, str or quantity of pint
        Approaches ω [m], ascending.
    folder : path, optional
        Folder in which every step is saved; created if missing. The same call resumes after the
        last finished step, with identical results.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`: the number of the load and the `Step` of the solver.

    Returns
    -------
    LoadCurve
        The scalars of every step.

    Raises
    ------
    InputError
        If an argument cannot be used, or the folder is in use or holds another sweep.
    FormatError
        If a step in the folder is damaged, or belongs to another load.
    CapacityError, InsufficientMemoryError
        As for `solve`; the largest load is checked before the first step.
    ConvergenceError
        If a step did not reach the tolerance; the steps before it stay in the folder.

    Notes
    -----
    Each solve starts from the pressure and gap of the previous load, extrapolated if the stiffness
    is known. The model has no history: every step is the same as a separate solve, within its
    certificate.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(64)
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> curve = rc.sweep(rc.Surface(heights, pixel), material=steel, loads=[0.1, 1, 10])
    >>> bool((np.diff(curve.column("contact_area")) > 0).all())
    True
    """
    if (loads is None) == (approaches is None):
        raise InputError(
            f"give either {ArgumentRef('loads')} or {ArgumentRef('approaches')}, and only one of "
            "them"
        )
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    listed = [] if loads is None else _list_loads(pair, loads)
    resolved = [resolve_force(load, pair, "loads") for load in listed]
    forces = None if loads is None else [force for force, _ in resolved]
    stated = tuple(specified for _, specified in resolved if specified is not None)
    control = "load" if approaches is None else "approach"
    values = _require_ascending(pair, forces, approaches)

    def solve_curve(ceiling: Any, folder: Path | None) -> LoadCurve:
        terms = LoadCase(None, None, None, ceiling, tolerance, max_iterations, precision)
        sweep = _Sweep(pair, terms, control, values, stated)
        sweep.check()
        with checkpoints.lock_folder(
            folder, sweep.record, kind="sweep", record="sweep.json", pattern="step-*.npz"
        ) as place:
            return sweep.curve(_steps(sweep, place, progress))

    place = None if folder is None else Path(folder)
    if not is_bracket(pair, ceiling):
        return solve_curve(ceiling, place)
    return replace(solve_curve(COATING, place), base=solve_curve(BASE, place and place / BASE))


def contact_curve(
    surface: Surface,
    loads: list[float],
    progress: Tell = None,
    *,
    material: Material,
    counter_material: Material = RIGID,
    boundary: str = "free",
    **terms: Any,
) -> LoadCurve:
    """Return a load curve without stiffness, whose cost exceeds the solves; see `sweep`."""
    pair = Pair.from_arguments(surface, material, None, counter_material, boundary)
    sweep = _Sweep(
        pair, LoadCase(**terms), "load", _require_ascending(pair, loads, None), has_stiffness=False
    )
    sweep.check()
    return sweep.curve(_steps(sweep, None, progress))


@dataclass(frozen=True, eq=False)
class _Sweep:
    """Requested loads or approaches of two bodies."""

    pair: Pair
    terms: LoadCase
    control: str
    values: list[float]
    specified_load: tuple[GivenLoad, ...] = ()
    has_stiffness: bool = True

    def terms_at(self, value: float) -> LoadCase:
        """Return the load case of one load or approach."""
        if self.control == "load":
            return replace(self.terms, load=value)
        return replace(self.terms, approach=value)

    @property
    def own(self) -> bool:
        """Whether the ceiling is calibrated for each load."""
        ceiling = self.terms.ceiling
        return isinstance(ceiling, str) and ceiling == CALIBRATED

    def check(self) -> None:
        """Raise the errors of all steps in advance; the largest load is the most demanding."""
        check_profile(self.pair, self.terms)
        largest = self.terms_at(self.values[-1])
        check_problem(self.pair, largest, held=MAX_HELD_RESULTS, series=len(self.values) > 1)

    def record(self) -> dict[str, Any]:
        """Return the record of the inputs of the steps."""
        return {
            **self.pair.record(),
            **self.terms.record(),
            "precision": self.terms.precision,
            "control": self.control,
            "values": self.values,
        }

    def curve(self, solved: Iterable[tuple[LoadStep, Array]]) -> LoadCurve:
        """Return the load curve of the solved steps."""
        pair, steps, judged = self.pair, [], []
        for step, pressure in solved:
            steps.append(step)
            cautions = self.step_as_result(step, pressure).cautions
            judged.append((getattr(step, self.control), cautions))
        return LoadCurve(
            steps=tuple(steps),
            control=self.control,
            nominal_area=pair.size[0] * pair.size[1],
            contact_modulus=math.nan if pair.is_coated else pair.contact_modulus,
            rms_gradient=roughness.rms_gradient(pair.initial_gap, pair.pixel),
            ceiling=CALIBRATED if self.own else resolve_ceiling(self.terms.ceiling, pair),
            boundary=pair.boundary,
            origins=pair.origins,
            softer=pair.softer,
            is_profile=pair.is_profile,
            messages=over_loads(judged, pair.load_unit if self.control == "load" else "m"),
            specified_load=self.specified_load,
            _solve_largest=partial(
                solve_pair, pair, self.terms_at(self.values[-1]), start=pressure
            ),
        )

    def step_as_result(self, step: LoadStep, pressure: Array) -> ContactResult:
        """Return a step as a contact result for its cautions; only holes of its gap are used."""
        return ContactResult(
            pair=self.pair,
            ceiling=step.ceiling if self.own else resolve_ceiling(self.terms.ceiling, self.pair),
            precision=self.terms.precision,
            tolerance=self.terms.certificate,
            control=self.control,
            load=step.load,
            approach=step.approach,
            pressure=pressure,
            gap=self.pair.initial_gap,
            certificate=step.certificate,
            load_error=step.load_error,
            convolutions=step.convolutions,
            seconds=step.seconds,
            calibration=self._stored_calibration(step) if self.own else None,
        )

    def _stored_calibration(self, step: LoadStep) -> CalibrationRecord | None:
        """Return the calibration record of a stored ceiling, without its details."""
        body = softer_material(self.pair.material, self.pair.counter_material)
        if body is None or not body.ceiling or not step.ceiling:
            return None
        if math.isclose(step.ceiling, body.ceiling):
            return None
        factor = step.ceiling / (body.yield_strength or math.nan)
        return CalibrationRecord(step.load, math.nan, factor, 0.0, 0, body.ceiling, *[math.nan] * 3)


def _steps(
    sweep: _Sweep, place: RunFolder | None, progress: Tell
) -> Iterator[tuple[LoadStep, Array]]:
    """Yield the steps with their pressures, each read from the folder or solved and saved."""
    start: Array | None = None
    # File names have the step number; an existing file is complete.
    for number, value in enumerate(sweep.values, start=1):
        path = None if place is None else place.folder / f"step-{number:04d}.npz"
        # Load and inputs identify a step of this sweep.
        mark = {} if place is None else {"problem": place.problem, "asked": value}
        if path is not None and path.exists():
            step, pressure, start = _read_step(path, sweep.pair.shape, mark)
            if callable(progress):
                progress(Progress(number, len(sweep.values), None, kept=True))
        else:
            try:
                step, pressure, start = _solved_step(sweep, number, start, progress)
            except ConvergenceError as error:
                raise _step_error(sweep, number, place, error) from None
            if path is not None:
                arrays = checkpoints.pack_map("pressure", pressure)
                arrays |= checkpoints.pack_map("following", start, "following_index")
                checkpoints.write_step(path, step, arrays, mark)
        yield step, pressure


def _solved_step(
    sweep: _Sweep, number: int, start: Array | None, progress: Tell
) -> tuple[LoadStep, Array, Array]:
    """Solve a step; return it, its pressure, and the initial pressure of the next step."""
    result = solve_pair(
        sweep.pair,
        sweep.terms_at(sweep.values[number - 1]),
        start=start,
        progress=progress_callback(progress, number, len(sweep.values)),
    )
    if not sweep.has_stiffness:
        return _step(result, math.nan, None), result.pressure, result.pressure
    # Computed first, so that its memory is free again before the growth is computed.
    whole = unloading_stiffness(result) if result.saturated.any() else None
    grown = contact_growth(result)
    following = result.pressure
    if number < len(sweep.values):
        following = predict_pressure(result, grown, **{sweep.control: sweep.values[number]})
    return _step(result, grown.stiffness, whole), result.pressure, following


def _step_error(
    sweep: _Sweep, number: int, place: RunFolder | None, error: ConvergenceError
) -> ConvergenceError:
    unit = sweep.pair.load_unit if sweep.control == "load" else "m"
    label = f"{sweep.control} = {sweep.values[number - 1]:.6g} {unit}"
    hint = "" if place is None else f"; earlier steps are saved in {place.folder}"
    return ConvergenceError(
        Sentence(f"step {number} of {len(sweep.values)}, {label}: ", *error.parts, hint),
        error.result,
    )


def _list_loads(pair: Pair, loads: Any) -> list[Any]:
    """Return a list of loads from a text, a quantity of pint or a sequence."""
    if isinstance(loads, str):
        return [part.strip() for part in loads.split(",")]
    if not hasattr(loads, "m_as"):
        return list(loads)
    return list(to_si(loads, pair.load_dimension, "loads"))


def _require_ascending(
    pair: Pair, loads: Quantities | None, approaches: Quantities | None
) -> list[float]:
    name, dimension = "approaches", "length"
    if loads is not None:
        name, dimension = "loads", pair.load_dimension
    specified: list[Any] = list(to_si(approaches if loads is None else loads, dimension, name))
    if not specified:
        raise InputError("is empty: give at least one value", argument=name)
    if not all(isinstance(value, Real) and 0 < float(value) < math.inf for value in specified):
        raise InputError(f"must be positive and finite, got {specified}", argument=name)
    values = [float(value) for value in specified]
    if any(second <= first for first, second in pairwise(values)):
        raise InputError(f"must ascend, got {specified}; sort them", argument=name)
    return values


def _step(result: ContactResult, stiffness: float, unloading: float | None) -> LoadStep:
    spots = result.spots()
    return LoadStep(
        load=result.load,
        approach=result.approach,
        contact_area=result.contact_area,
        perimeter_corrected_area=result.perimeter_corrected_area,
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


def _read_step(
    path: Path, shape: tuple[int, int], mark: Mapping[str, Any]
) -> tuple[LoadStep, Array, Array]:
    names = "index", "pressure", "following_index", "following"
    step, arrays = checkpoints.read_step(path, LoadStep, names, mark, "sweep")
    following = checkpoints.unpack_map(arrays, "following", shape, "following_index")
    return step, checkpoints.unpack_map(arrays, "pressure", shape), following


def curve_uncertainty(curve: LoadCurve, *how: Any, **more: Any) -> LoadCurve:
    """Return a load curve with the intervals of each load; see `ContactResult.uncertainty`.

    Equal seeds give equal draws, so that the surfaces are the same for all loads.
    """
    largest = curve.largest
    check(largest)
    known = []
    for step in curve.steps:
        ceiling = None if math.isnan(step.ceiling) else step.ceiling
        contact = solve_pair(largest.pair, LoadCase(step.load, ceiling=ceiling))
        known.append(uncertainty(contact, *how, **more))
    return replace(curve, intervals=tuple(known))
