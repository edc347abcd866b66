"""Load history: permanent indentation along any path of loads and positions."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools import checkpoints, memory
from roughcontact._tools.arguments import set_fields, validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.checkpoints import RunFolder
from roughcontact.cautions import Caution, sort_cautions
from roughcontact.contact import load_case, plausibility
from roughcontact.contact.ceiling import resolve_ceiling
from roughcontact.contact.load_case import GivenLoad, Load, LoadCase, parse_load
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.result import CALIBRATED, CalibrationRecord, ContactResult
from roughcontact.contact.series import StepResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.validation import check_problem
from roughcontact.errors import (
    ArgumentRef,
    CapacityError,
    ConvergenceError,
    InputError,
    Sentence,
    input_error,
    require_count,
)
from roughcontact.halfspace.gpu import runs_on_device
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers.progress import (
    Progress,
    Step,
    Tell,
    progress_callback,
    shows_progress_bar,
)
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, format_lengths, to_si


@dataclass(frozen=True, eq=False)
class SlidingPair:
    """Two bodies at changing relative positions, one of which is indented."""

    pair: Pair  # Bodies at the first position, not yet indented
    counter: Surface | None  # Counter-body on its own grid
    on_counter: bool  # Whether the counter-body keeps the indentation
    origin: tuple[int, int]

    @property
    def indented(self) -> Surface:
        """Body that keeps the indentation, before the path."""
        body = self.counter if self.on_counter else self.pair.surface
        assert body is not None
        return body

    def pair_at(self, indentation: Array, shift: tuple[int, int]) -> Pair:
        """Return the two bodies at a shift, on the grid of the surface."""
        surface, counter = self.pair.surface, self.counter
        if not self.on_counter and indentation.any():
            surface = replace(surface, heights=surface.heights - indentation)
        if counter is None:
            return replace(self.pair, surface=surface)
        heights = counter.heights - indentation if self.on_counter else counter.heights
        moved = np.full(surface.shape, np.nan)
        here, there = self._overlap(shift)
        moved[here] = self._roll_map(heights, shift)[there]
        if np.isnan(moved + surface.heights).all():
            raise CapacityError(
                f"no contact is possible: shifted by {shift} pixels the counter-body has no valid "
                "point opposite one of the surface"
            )
        moved_counter = replace(counter, heights=moved, holes_masked=True)
        return replace(self.pair, surface=surface, counter_surface=moved_counter)

    def indent(self, indentation: Array, new: Array, shift: tuple[int, int]) -> None:
        """Add new indentation, on the grid of the surface, to that of the indented body."""
        if not self.on_counter:
            indentation += new
            return
        here, there = self._overlap(shift)
        own = np.zeros(indentation.shape)
        own[there] = new[here]
        indentation += self._roll_map(own, (-shift[0], -shift[1]))

    def _roll_map(self, values: Array, shift: tuple[int, int]) -> Array:
        """Return a map shifted along its periodic axes."""
        axes = self.pair.boundary.periodic_axes
        return np.roll(values, [shift[axis] for axis in axes], axes) if axes else values

    def _overlap(self, shift: tuple[int, int]) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
        """Return the overlapping slices of the surface and of the counter-body."""
        assert self.counter is not None
        here, there = [], []
        for axis, (points, own) in enumerate(zip(self.pair.shape, self.counter.shape, strict=True)):
            ahead = shift[axis] - self.origin[axis]
            if axis in self.pair.boundary.periodic_axes:
                ahead = 0
            first, last = max(0, ahead), min(points, ahead + own)
            here.append(slice(first, last))
            there.append(slice(first - ahead, last - ahead))
        return tuple(here), tuple(there)


def sliding_pair(pair: Pair, shifts: list[tuple[int, int]]) -> SlidingPair:
    """Return the two bodies of a path of shifts; the softer one is indented."""
    body = pair.softer
    on_counter = pair.material.compliance == 0 if body is None else body is not pair.material
    counter = pair.counter_surface
    if not on_counter or counter is not None:
        return SlidingPair(pair, counter, on_counter, (0, 0))
    # A flat without end: a map of the part that faces the surface along the path.
    shape, origin = list(pair.shape), [0, 0]
    for axis in pair.boundary.free_axes:
        along = [shift[axis] for shift in shifts]
        origin[axis] = max(0, *along)
        shape[axis] += origin[axis] - min(0, *along)
    flat = Surface(np.zeros(shape), pair.pixel, Provenance(source="flat"))
    return SlidingPair(pair, flat, on_counter, (origin[0], origin[1]))


def indent_body(body: Surface, indentation: Array) -> Surface:
    """Return a body lowered by its indentation."""
    if not indentation.any():
        return body
    provenance = body.provenance.then(Operation("indented", found={"depth": indentation.max()}))
    return replace(body, heights=body.heights - indentation, provenance=provenance)


@validate_arguments
def indented_surface(result: ContactResult) -> Surface:
    """Return the surface with the permanent indentation of a contact.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    Surface
        Heights less `ContactResult.residual_indentation`; the surface itself if nothing is
        saturated. Under smaller loads its contact is elastic: unloading and loading again follow
        `roughcontact.analyses.history.model`. All of the indentation is on the surface, even if
        the counter-body is softer; this changes no contact of the two at this position.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> rough = rc.Surface(*rc.reference_map(32))
    >>> loaded = rc.solve(rough, material=steel, load=1.0)
    >>> again = rc.solve(rc.indented_surface(loaded), material=steel, load=1.0)
    >>> loaded.saturated_fraction > 0, round(again.contact_area / loaded.contact_area, 2)
    (True, 1.0)
    """
    return indent_body(result.surface, result.residual_indentation)


NEGLIGIBLE_GROWTH = 1e-5
"""Share of the total indentation volume up to which a step is treated as elastic."""

# Relative tolerance for a load or approach that is reached again.
_REACHED = 1e-6

VOLUME_ACCOUNT = (
    "the indented volume is lost: saturated pixels are lowered and none is raised (no pile-up), "
    "pixels below the ceiling keep their exact height, and there is no other residual displacement "
    "or stress"
)
"""Conserved and lost quantities of the model."""


@dataclass(frozen=True)
class Stage:
    """Stage of a load path: a load or an approach, at a lateral position.

    Parameters
    ----------
    load : float, str, quantity of pint or `Load`, optional
        Normal load W [N], 0 for first contact, or in any form that `solve` takes; give
        either this or ``approach``.
    approach : float, str or quantity of pint, optional
        Approach ω from the first touch of the undeformed bodies at the first position [m]; the
        load is 0 if the bodies do not touch.
    shift : (float, float)
        Lateral shift ``(y, x)`` of the counter-body from its first position [m], a whole number
        of pixels.

    Raises
    ------
    InputError
        If a value cannot be used.
    """

    load: float | Load | None = None
    approach: float | None = None
    shift: tuple[float, float] = (0.0, 0.0)

    @validate_arguments
    def __init__(
        self,
        load: Quantity | Load | None = None,
        approach: Quantity | None = None,
        shift: Quantities = (0.0, 0.0),
    ) -> None:
        way, moved = to_si(approach, "length", "approach"), to_si(shift, "length", "shift")
        set_fields(self, load=load_case.parse_load(load), approach=way, shift=moved)
        if (self.load is None) == (self.approach is None):
            raise InputError("a stage needs either a load or an approach, and only one of them")
        plain = self.load is not None and not isinstance(self.load, Load)
        if plain and not (_is_finite(self.load) and self.force >= 0):
            raise input_error("load", self.load, "must be finite and not negative [N]")
        if self.approach is not None and not _is_finite(self.approach):
            raise input_error("approach", self.approach, "must be finite [m]")
        try:
            y, x = (float(length) for length in self.shift)
        except (TypeError, ValueError):
            y = x = math.nan
        if not (math.isfinite(y) and math.isfinite(x)):
            raise input_error("shift", self.shift, "must be a pair (y, x) of lengths [m]")
        object.__setattr__(self, "shift", (y, x))

    @property
    def force(self) -> float:
        """Load [N], after `with_force` has converted it to a force."""
        assert self.load is not None
        assert not isinstance(self.load, Load)
        return self.load

    def with_force(self, pair: Pair) -> Stage:
        """Return the stage with its load converted to a force on two bodies."""
        if not isinstance(self.load, Load):
            return self
        return replace(self, load=load_case.force_on_pair(self.load, pair))


@dataclass(frozen=True)
class HistoryStep:
    """Scalars of one solved stage."""

    load: float  # W [N]
    approach: float  # ω from the first touch of the undeformed bodies at the first position [m]
    shift_y: float  # Lateral shift of the counter-body [m]
    shift_x: float  # Lateral shift of the counter-body [m]
    contact_area: float  # [m²]
    saturated_area: float  # [m²]
    max_pressure: float  # Largest pressure [Pa]
    indentation_volume: float  # Volume newly indented in this step [m³]
    dissipated_energy: float  # Ceiling times newly indented volume, summed over the pixels [J]
    elastic_energy: float  # Elastic energy stored at the end of the step, ½ Σ p u ΔxΔy [J]
    certificate: float  # Certificate ε
    load_error: float  # Relative error of the load
    convolutions: int  # Number of convolutions on the full grid
    seconds: float  # Wall time of the solve


@dataclass(frozen=True, eq=False, repr=False)
class LoadHistory(StepResult):
    """Path of loads and positions, and its permanent indentation.

    Parameters
    ----------
    path : tuple of Stage
        The stages that were followed.
    steps : tuple of HistoryStep
        Outcome of each stage.
    indented_body : {"surface", "counter_surface"}
        The body that keeps the indentation.
    indentation : ndarray
        Permanent lowering d ≥ 0 of that body [m], on its own grid; read-only.
    origin : (int, int)
        Pixel of ``indentation`` that faced pixel (0, 0) of the surface at the first position:
        (0, 0) unless a flat counter-body without a map was indented at several positions.
    residual : Surface
        The indented body, unloaded.
    last : ContactResult
        Contact of the last stage, with the surfaces before the stage: its approach is from their
        first touch, and its ``residual_indentation`` is the indentation that the stage added.
    largest : ContactResult
        Contact of the stage with the largest load, the first one if there are several.
    before : Pair
        The bodies at the position of that stage, before the path.
    calibration : CalibrationRecord or None
        Calibration of the ceiling, if it is calibrated: for a first loading to the largest load.
    extra_cautions : tuple of Caution
        Remarks on the measurement of the maps.
    specified_load : tuple of GivenLoad
        The loads that were not given as forces, in their given form.
    passes : int
        Number of passes that were followed.
    requested_passes : int
        Number of passes that were requested; passes end with one that adds no indentation.
    """

    path: tuple[Stage, ...]
    steps: tuple[HistoryStep, ...]
    indented_body: str
    indentation: Array
    origin: tuple[int, int]
    residual: Surface
    last: ContactResult
    largest: ContactResult
    before: Pair
    calibration: CalibrationRecord | None = None
    extra_cautions: tuple[Caution, ...] = ()
    specified_load: tuple[GivenLoad, ...] = ()
    passes: int = 1
    requested_passes: int = 1

    @property
    def under_largest(self) -> ContactResult:
        """Contact under the largest load, on the bodies before the path.

        Slopes and summits are those of the measured bodies, and the approach is from their first
        touch; pressure and gap are those of the stage.
        """
        step = max(self.steps, key=lambda step: step.load)
        return replace(
            self.largest,
            pair=self.before,
            approach=step.approach,
            calibration=self.calibration,
            extra_cautions=self.extra_cautions,
        )

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the contact under the largest load."""
        largest = self.under_largest
        advice, ceiling = plausibility.recommended_ceiling_of(largest), largest.ceiling
        if advice is None or not isinstance(ceiling, float):
            return largest.cautions
        caution = plausibility.indentation_caution(advice, ceiling)
        return largest.cautions if caution is None else sort_cautions([*largest.cautions, caution])

    @property
    def hysteresis(self) -> tuple[Array, Array]:
        """Approach [m] and load [N] of the steps, each of shape (n,)."""
        return self.column("approach"), self.column("load")

    @cached_property
    def dissipated_energy(self) -> float:
        """Energy dissipated along the whole path [J]."""
        return math.fsum(self.column("dissipated_energy"))

    @cached_property
    def indentation_volume(self) -> float:
        """Volume of the total indentation [m³]."""
        dy, dx = self.residual.pixel
        return math.fsum(self.indentation.ravel()) * dy * dx

    @cached_property
    def is_elastic_now(self) -> bool:
        """Whether a further pass along the path would stay elastic.

        True if no step indents, or if after the last step that does (more than 1e-5 of the total
        volume) every position of the path has reached its largest load, or its largest approach,
        again.
        """
        volume = self.column("indentation_volume")
        plastic = np.flatnonzero(volume > NEGLIGIBLE_GROWTH * self.indentation_volume)
        if plastic.size == 0:
            return True
        wanted = self._largest(0)
        seen = self._largest(int(plastic[-1]) + 1)
        return all(
            what in seen and seen[what] >= value - _REACHED * abs(value)
            for what, value in wanted.items()
        )

    def _largest(self, first: int) -> dict[tuple[tuple[float, float], str], float]:
        """Return the largest requested load and approach at each position from a stage on."""
        result: dict[tuple[tuple[float, float], str], float] = {}
        for stage in self.path[first:]:
            load = None if stage.load is None else stage.force
            for control, value in (("load", load), ("approach", stage.approach)):
                if value is not None:
                    what = stage.shift, control
                    result[what] = max(result.get(what, value), value)
        return result


def repeat_stages(
    loads: Sequence[Stage | Quantity | Load], count: int, shift: Quantities = (0.0, 0.0)
) -> list[Stage]:
    """Return the stages of a repeated load cycle, shifted by a step in each repetition."""
    require_count(1, most_passes(len(loads)), count=count)
    dy, dx = Stage(load=0.0, shift=shift).shift
    stages = [item if isinstance(item, Stage) else Stage(load=item) for item in loads]
    return [
        replace(stage, shift=(stage.shift[0] + number * dy, stage.shift[1] + number * dx))
        for number in range(count)
        for stage in stages
    ]


def most_passes(stages: int) -> int:
    """Return the maximum number of passes for a path with this number of stages."""
    return max(1, memory.STEPS // max(1, stages))


def _is_finite(value: Any) -> bool:
    return isinstance(value, Real) and math.isfinite(value)


TOLERANCE = 1e-9
"""Default certificate of every step.

At this certificate, reloading meets loading to some 1e-11 of the approach, at 1e-6 to some 1e-8;
it costs a third more.
"""


MAX_HELD_RESULTS = 10
"""Maps in memory while a stage is solved.

The indentation, a map of zeros, the indentation of the last stage, pressure and gap of the last
and the largest stage, and the bodies of three stages.
"""

# Load that every surface carries [N], to check the other arguments.
_PLACEHOLDER_LOAD = 1e-90
# Tolerance of a shift by whole pixels, in pixels.
_WHOLE = 1e-6

# Relative tolerance of a pixel at the ceiling: on reloading, a yielded pixel reaches the ceiling
# elastically, up to the tolerance of the solution.
_AT_CEILING = 1e-6


@shows_progress_bar
@runs_on_device
@validate_arguments
def history(
    surface: Surface,
    path: Sequence[Stage | Quantity | Load],
    *,
    passes: int = 1,
    shift: Quantities = (0.0, 0.0),
    material: Material,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float = TOLERANCE,
    max_iterations: int = 2000,
    device: str | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Tell = None,
) -> LoadHistory:
    """Follow loading and unloading, with permanent indentation at the ceiling.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, ceiling, boundary, max_iterations, device
        As for `solve`. A path has one ceiling: ``"calibrated"`` is that of a first loading to the
        largest load of the path.
    path : sequence of Stage, float, str, quantity of pint or `Load`
        Stages in order; a load in any form that `solve` takes is a stage at the first
        position.
    passes : int
        Number of times the path is followed. Without a shift the passes end with the first that
        adds no more than 1e-5 of the indented volume.
    shift : (float, float)
        Lateral shift ``(y, x)`` of the counter-body from pass to pass [m].
    tolerance : float
        Certificate ε of every step.
    folder : path, optional
        Folder in which every finished step is saved; created if missing. The same call with the
        same folder resumes after the last finished step, with identical results, also with more
        passes.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`: the number of the stage and the `Step` of the solver.

    Returns
    -------
    LoadHistory
        The scalars of every step, and the indented body.

    Raises
    ------
    InputError
        If an argument cannot be used, or a shift is no whole number of pixels or leaves the map.
    CapacityError, InsufficientMemoryError
        As for `solve`. The whole path is checked before its first step.
    ConvergenceError
        If a step did not reach the tolerance.

    Notes
    -----
    The ceiling is taken as perfect plasticity of the separation of the two surfaces. With d the
    permanent indentation, u the elastic displacement and ω the approach, the gap is
    g = u + h₀ + d - ω, and::

        0 ≤ p ≤ p_lim,    g ≥ 0,    p g = 0,    Δd ≥ 0,    (p_lim - p) Δd = 0.

    Each stage is one implicit step of this law: `solve` about the surface indented so far; where
    the pressure is at the ceiling, Δd = -g. Unloading is elastic about the indented surface, and
    reloading starts from it. The first stage is the same as `solve`. The path matters only where
    a pixel leaves the ceiling again while others reach it.

    The energy that a step dissipates, ΔxΔy Σ p_lim Δd, is never negative, and with fine steps at
    one position the work ∫W dω equals the stored and the dissipated energy. Lateral shifts are
    frictionless and between two stages; their work is not included.

    The indentation stays on the body with the smaller yield strength: on the surface if both are
    equal or none is known, unless the surface is rigid. A ceiling per pixel stays with the pixels
    of the surface. On a free boundary, points that are shifted off the map never touch; a
    counter-body without a map is a flat without end. A periodic counter-body is shifted cyclically.

    Volume: an indentation removes its volume. Saturated pixels are lowered without pile-up, and
    all other pixels keep their height to the bit.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(32)
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = rc.history(rc.Surface(heights, pixel), [1.0, 0.0, 1.0], material=steel)
    >>> found.is_elastic_now, found.steps[0].indentation_volume > 0
    (True, True)
    """
    one_pass = _stages(path)
    requested = repeat_stages(one_pass, passes, shift)
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    pair.require_map("a load history", coated=False)
    terms = LoadCase(ceiling=ceiling, tolerance=tolerance, max_iterations=max_iterations)
    way = _path_in_pixels(pair, requested, terms, len(one_pass))
    record = partial(way.record, terms)
    with checkpoints.lock_folder(
        folder, record, kind="history", record="history.json", pattern="step-*.npz"
    ) as place:
        recommended = None
        if isinstance(ceiling, str) and ceiling == CALIBRATED:
            first = _solve_largest(way)
            recommended = first.calibration
            way = replace(way, terms=replace(terms, ceiling=first.ceiling))
            _check_way(way)
        history = _run_path(way, place, progress)
    specified = [
        GivenLoad(item.load, stage.force)
        for item, stage in zip(requested, history.path, strict=False)
        if isinstance(item.load, Load)
    ]
    return replace(history, calibration=recommended, specified_load=tuple(specified))


def _path_in_pixels(pair: Pair, requested: Sequence[Stage], terms: LoadCase, each: int) -> _Path:
    """Check a path of two bodies; return it with shifts in pixels."""
    stages = tuple(stage.with_force(pair) for stage in requested)
    check_problem(pair, replace(terms, load=_PLACEHOLDER_LOAD), held=MAX_HELD_RESULTS)
    limit = resolve_ceiling(terms.ceiling, pair)
    shifts = [_pixels(stage.shift, pair.surface, n) for n, stage in enumerate(stages, start=1)]
    bodies = sliding_pair(pair, shifts)
    if bodies.on_counter and isinstance(limit, np.ndarray) and any(map(any, shifts)):
        raise InputError(
            f"a {ArgumentRef('ceiling')} per pixel belongs to the pixels of "
            f"{ArgumentRef('surface')}, but here the counter-body is indented and moves: give a "
            "single ceiling, or swap the two bodies"
        )
    reference = bodies.pair_at(np.zeros(bodies.indented.shape), (0, 0)).highest
    way = _Path(bodies, replace(terms, ceiling=limit), stages, shifts, reference, each)
    _check_way(way)
    return way


def _solve_largest(way: _Path) -> ContactResult:
    """Return the contact at first loading to the largest load, with calibrated ceiling."""
    usual = [(_first_loaded(way, number, way.terms.ceiling), number) for number in way.largest()]
    result, number = max(usual, key=lambda item: item[0].load)
    return _first_loaded(way, number, CALIBRATED) if result.load else result


def _first_loaded(way: _Path, number: int, ceiling: Any) -> ContactResult:
    """Return the contact of a stage, by its number from 0, at first loading."""
    pair = way.bodies.pair_at(np.zeros(way.bodies.indented.shape), way.shifts[number])
    terms = way.terms_of(way.stages[number], way.touch_delay(pair))
    return _solve_stage(pair, replace(terms, ceiling=ceiling), None)


@dataclass(frozen=True, eq=False)
class _Path:
    """Path of loads and positions of two bodies, in pixels."""

    bodies: SlidingPair
    terms: LoadCase
    stages: tuple[Stage, ...]
    shifts: list[tuple[int, int]]
    reference: float
    each: int

    @property
    def stays(self) -> bool:
        """Whether all passes are at the positions of the first."""
        return all(
            shift == self.shifts[number % self.each] for number, shift in enumerate(self.shifts)
        )

    def record(self, terms: LoadCase) -> dict[str, Any]:
        """Return the record of the inputs of the steps, with the ceiling as given."""
        # Without shifts only the first pass, so that more passes can be requested later; with
        # shifts the map of a flat depends on the number of passes.
        stages = self.stages[: self.each if self.stays else None]
        path = [asdict(stage) for stage in stages]
        return {**self.bodies.pair.record(), **terms.record(), "path": path}

    def is_settled(self, steps: Sequence[HistoryStep]) -> bool:
        """Return whether these steps end with a pass without new indentation."""
        if len(steps) % self.each or not self.stays:
            return False
        volume = [step.indentation_volume for step in steps]
        return math.fsum(volume[-self.each :]) <= NEGLIGIBLE_GROWTH * math.fsum(volume)

    def largest(self) -> list[int]:
        """Return the stages, from 0, of the largest load and the largest approach."""
        result = []
        for control in ("load", "approach"):
            requested = {n: getattr(stage, control) for n, stage in enumerate(self.stages)}
            wanted = {n: value for n, value in requested.items() if value is not None}
            if wanted:
                result.append(max(wanted, key=wanted.__getitem__))
        return result

    def touch_delay(self, pair: Pair) -> float:
        """Return the delay of first touch compared with the first position, as an approach [m]."""
        return self.reference - pair.highest

    def terms_of(self, stage: Stage, lowered: float) -> LoadCase:
        """Return the load case of a stage, with its approach from first touch of the bodies."""
        if stage.approach is None:
            return replace(self.terms, load=stage.force)
        return replace(self.terms, approach=stage.approach - lowered)


def _check_way(way: _Path) -> None:
    """Raise the errors of all stages in advance; they do not depend on the indentation."""
    untouched = np.zeros(way.bodies.indented.shape)
    for shift in dict.fromkeys(way.shifts):
        pair = way.bodies.pair_at(untouched, shift)
        lowered = way.touch_delay(pair)
        here = [number for number, other in enumerate(way.shifts, start=1) if other == shift]
        requested = [(way.terms_of(way.stages[number - 1], lowered), number) for number in here]
        for control in ("load", "approach"):
            wanted = [(terms, number) for terms, number in requested if terms.control == control]
            # The last stage with the largest value.
            terms, number = max(
                wanted, key=lambda item: (item[0].target, item[1]), default=(None, 0)
            )
            if terms is not None and terms.target > 0:
                try:
                    check_problem(pair, terms, held=MAX_HELD_RESULTS)
                except CapacityError as error:
                    raise CapacityError(
                        f"stage {number} of {len(way.stages)}: ", *error.sentence
                    ) from None


def _run_path(way: _Path, place: RunFolder | None, progress: Tell) -> LoadHistory:
    """Solve all stages of a checked path; return the load history."""
    bodies, largest = way.bodies, 0
    indentation = np.zeros(bodies.indented.shape)
    steps: list[HistoryStep] = []
    results: dict[int, ContactResult | None] = {}
    for number, shift in enumerate(way.shifts):
        stored = _cached_step(way, number, place)
        if stored is not None:
            step, new, result = *stored, None
            if callable(progress):
                progress(Progress(number + 1, len(way.stages), None, kept=True))
        else:
            step, new, result = _solve_history_stage(way, number, indentation, place, progress)
            if place is not None:
                file, mark = _place(way, number, place)
                checkpoints.write_step(file, step, checkpoints.pack_map("indented", new), mark)
        bodies.indent(indentation, new, shift)
        steps.append(step)
        if step.load > steps[largest].load:
            largest = number
        # Keep only the largest and the last contact in memory.
        results = {n: result for n, result in results.items() if n == largest} | {number: result}
        if way.is_settled(steps):
            break
    last, maximum = (
        results[n] or _solve_history_stage(way, n, _indented_before(way, n, place), place, None)[2]
        for n in (len(steps) - 1, largest)
    )
    indentation.flags.writeable = False
    return LoadHistory(
        path=way.stages[: len(steps)],
        steps=tuple(steps),
        indented_body="counter_surface" if bodies.on_counter else "surface",
        indentation=indentation,
        origin=bodies.origin,
        residual=indent_body(bodies.indented, indentation),
        last=last,
        largest=maximum,
        before=bodies.pair_at(np.zeros_like(indentation), way.shifts[largest]),
        passes=len(steps) // way.each,
        requested_passes=len(way.stages) // way.each,
    )


def _solve_history_stage(
    way: _Path, number: int, indentation: Array, place: RunFolder | None, progress: Tell
) -> tuple[HistoryStep, Array, ContactResult]:
    """Solve a stage, by its number from 0; return its step, new indentation and contact."""
    count, stage = len(way.stages), way.stages[number]
    pair = way.bodies.pair_at(indentation, way.shifts[number])
    lowered = way.touch_delay(pair)
    label = "" if count == way.each else f"pass {number // way.each + 1} of {count // way.each}"
    try:
        terms = way.terms_of(stage, lowered)
        result = _solve_stage(pair, terms, progress_callback(progress, number + 1, count, label))
    except ConvergenceError as error:
        hint = "" if place is None else f"; earlier stages are saved in {place.folder}"
        text = Sentence(f"stage {number + 1} of {count}: ", *error.parts, hint)
        raise ConvergenceError(text, error.result) from None
    new = result.residual_indentation
    return _step(result, stage, lowered, new), new, result


# Steps on disk: only the new indentation of a contact is saved; solved again, its bits are equal.


def _indented_before(way: _Path, number: int, place: RunFolder | None) -> Array:
    """Return the indentation before a stage, by its number from 0."""
    indentation = np.zeros(way.bodies.indented.shape)
    for before, shift in enumerate(way.shifts[:number]):
        stored = _cached_step(way, before, place)
        assert stored is not None
        way.bodies.indent(indentation, stored[1], shift)
    return indentation


def _place(way: _Path, number: int, place: RunFolder) -> tuple[Path, dict[str, Any]]:
    """Return the file of a stage, by its number from 0, and the record that identifies it."""
    stage = way.stages[number]
    requested = stage.force if stage.approach is None else stage.approach
    mark = {"problem": place.problem, "number": number + 1, "asked": requested}
    return place.folder / f"step-{number + 1:04d}.npz", mark


def _cached_step(
    way: _Path, number: int, place: RunFolder | None
) -> tuple[HistoryStep, Array] | None:
    """Read a stage, by its number from 0, and its new indentation, if it is saved."""
    if place is None:
        return None
    file, mark = _place(way, number, place)
    if not file.exists():
        return None
    step, arrays = checkpoints.read_step(file, HistoryStep, ("index", "indented"), mark, "history")
    return step, checkpoints.unpack_map(arrays, "indented", way.bodies.pair.shape)


def _solve_stage(
    pair: Pair, terms: LoadCase, progress: Callable[[Step], None] | None
) -> ContactResult:
    """Return the contact of a stage; without load if the bodies do not touch."""
    if terms.target > 0:
        # Not from the last pressure: on large maps, coarse grids give a better start.
        return solve_pair(pair, terms, progress=progress)
    ceiling: Any = terms.ceiling
    approach = terms.target
    return ContactResult(
        pair=pair,
        ceiling=ceiling,
        precision="double",
        tolerance=terms.certificate,
        control=terms.control,
        load=0.0,
        approach=approach,
        pressure=np.zeros(pair.shape),
        gap=pair.initial_gap - approach,
    )


def _make_stage(load: Real | Load) -> Stage:
    return Stage(load if isinstance(load, Load) else float(load))


def _stages(path: Sequence[Stage | Quantity | Load]) -> tuple[Stage, ...]:
    stages = []
    for number, stage in enumerate(path, start=1):
        try:
            load = parse_load(stage)
            stages.append(load if isinstance(load, Stage) else _make_stage(load))
        except InputError as error:
            raise InputError(f"stage {number}: ", *error.sentence) from None
    if not stages:
        raise InputError("is empty: give at least one load", argument="path")
    return tuple(stages)


def _pixels(shift: tuple[float, float], surface: Surface, number: int) -> tuple[int, int]:
    """Return a shift in pixels."""
    ratios = [length / edge for length, edge in zip(shift, surface.pixel, strict=True)]
    whole = [round(ratio) for ratio in ratios]
    if any(abs(r - w) > _WHOLE for r, w in zip(ratios, whole, strict=True)):
        near = [w * edge for w, edge in zip(whole, surface.pixel, strict=True)]
        text = ", ".join(f"{1e9 * length:.9g} nm" for length in near)
        raise InputError(
            f"stage {number}: {ArgumentRef('shift')} ({format_lengths(shift, ', ')}) is no whole "
            f"number of pixels of {format_lengths(surface.pixel)}; the nearest is '{text}'"
        )
    if any(abs(w) >= points for w, points in zip(whole, surface.shape, strict=True)):
        raise InputError(
            f"stage {number}: {ArgumentRef('shift')} ({format_lengths(shift, ', ')}) is beyond the "
            f"map of {format_lengths(surface.size)}; stay within it"
        )
    return whole[0], whole[1]


def _step(result: ContactResult, stage: Stage, lowered: float, new: Array) -> HistoryStep:
    area = result.pixel_area
    loaded = np.flatnonzero(result.pressure)
    pressure = result.pressure.ravel()[loaded]
    opened = result.gap.ravel()[loaded] - result.initial_gap.ravel()[loaded]
    displacement = opened + result.approach
    limit = math.inf if result.ceiling is None else result.ceiling
    saturated = result.pressure >= (1 - _AT_CEILING) * limit
    return HistoryStep(
        load=result.load,
        approach=result.approach + lowered,
        shift_y=stage.shift[0],
        shift_x=stage.shift[1],
        contact_area=result.contact_area,
        saturated_area=int(np.count_nonzero(saturated)) * area,
        max_pressure=result.max_pressure,
        indentation_volume=float(new.sum()) * area,
        dissipated_energy=float((result.pressure * new).sum()) * area,
        elastic_energy=0.5 * float((pressure * displacement).sum()) * area,
        certificate=result.certificate,
        load_error=result.load_error,
        convolutions=result.convolutions,
        seconds=result.seconds,
    )
