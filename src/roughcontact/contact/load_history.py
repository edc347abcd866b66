"""Load history: what saturated pixels leave behind, along any path of loads and positions."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact import solve
from roughcontact.contact.result import ContactResult, initial_gap
from roughcontact.errors import CapacityError, ConvergenceError, InputError
from roughcontact.files import replacing
from roughcontact.material.material import RIGID, Material, contact_modulus, softer
from roughcontact.solvers.progress import Step
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Certificate of every step by default.

With it a reloading meets the loading again to some 1e-11 of the approach, with 1e-6 to some 1e-8;
it costs a third more.
"""

SHAKEN_DOWN = 1e-5
"""Share of the whole indentation volume up to which a step counts as elastic."""

# A load that every surface carries, to check the other arguments with.
_LEAST = float(np.finfo(float).tiny)
# A shift this near to whole pixels is one, in pixels.
_WHOLE = 1e-6
# A load or approach is reached again if it is missed by no more than this part.
_REACHED = 1e-6

VOLUME_ACCOUNT = (
    "the indented volume is lost: saturated pixels are lowered and nothing is raised in return "
    "(no pile-up), pixels below the ceiling keep their height to the bit, and no other residual "
    "displacement or stress stays behind"
)
"""What the model conserves and what it does not."""


@dataclass(frozen=True)
class Stage:
    """One point of a path: a load or an approach, at a lateral position.

    Parameters
    ----------
    load : float, optional
        Normal load W [N], 0 for bodies that just touch; give either this or ``approach``.
    approach : float, optional
        Approach ω from the first touch of the undeformed bodies at the first position [m]; where
        they do not touch at it the load is 0.
    shift : (float, float)
        Lateral shift ``(y, x)`` of the counter-body from its first position [m], a whole number
        of pixels.

    Raises
    ------
    InputError
        If a value cannot be used.
    """

    load: float | None = None
    approach: float | None = None
    shift: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse what is no point of a path."""
        if (self.load is None) == (self.approach is None):
            raise InputError("a stage needs either a load or an approach, and only one of them")
        if self.load is not None and not (_is_finite(self.load) and self.load >= 0):
            raise InputError(
                f"must be finite and not negative [N], got {self.load!r}",
                argument="load",
                value=self.load,
            )
        if self.approach is not None and not _is_finite(self.approach):
            raise InputError(
                f"must be finite [m], got {self.approach!r}",
                argument="approach",
                value=self.approach,
            )
        try:
            y, x = (float(length) for length in self.shift)
        except (TypeError, ValueError):
            y = x = math.nan
        if not (math.isfinite(y) and math.isfinite(x)):
            raise InputError(
                f"must be a pair (y, x) of lengths [m], got {self.shift!r}",
                argument="shift",
                value=self.shift,
            )
        object.__setattr__(self, "shift", (y, x))


@dataclass(frozen=True)
class HistoryStep:
    """The scalars of one solved stage.

    Parameters
    ----------
    load : float
        W [N].
    approach : float
        ω from the first touch of the undeformed bodies at the first position [m].
    shift_y, shift_x : float
        Lateral shift of the counter-body [m].
    contact_area, saturated_area : float
        Area with pressure, and at the ceiling [m²].
    max_pressure : float
        Largest pressure [Pa].
    indentation_volume : float
        Volume newly indented in this step [m³].
    dissipated_energy : float
        Ceiling times newly indented volume, summed over the pixels [J].
    elastic_energy : float
        Elastic energy stored at the end of the step, ½ Σ p u ΔxΔy [J].
    certificate, load_error : float
        How exactly the step is solved.
    convolutions : int
        On the full grid.
    seconds : float
        Wall time of the solve.
    """

    load: float
    approach: float
    shift_y: float
    shift_x: float
    contact_area: float
    saturated_area: float
    max_pressure: float
    indentation_volume: float
    dissipated_energy: float
    elastic_energy: float
    certificate: float
    load_error: float
    convolutions: int
    seconds: float


UNITS = {
    "load": "N", "approach": "m", "shift_y": "m", "shift_x": "m", "contact_area": "m²",
    "saturated_area": "m²", "max_pressure": "Pa", "indentation_volume": "m³",
    "dissipated_energy": "J", "elastic_energy": "J", "certificate": "1", "load_error": "1",
    "convolutions": "1", "seconds": "s",
}  # fmt: skip
"""Unit of each field of a `HistoryStep`."""


@dataclass(frozen=True, eq=False)
class LoadHistory:
    """A path of loads and positions, and what it left behind.

    Parameters
    ----------
    path : tuple of Stage
        What was asked for.
    steps : tuple of HistoryStep
        What was found, one a stage.
    indented_body : {"surface", "counter_surface"}
        The body that keeps the indentation.
    indentation : ndarray
        Permanent lowering d ≥ 0 of that body [m], on its own grid; read-only.
    origin : (int, int)
        Pixel of ``indentation`` that faced pixel (0, 0) of the surface at the first position. It
        is (0, 0) unless a counter-body without a map, a flat, was indented at several positions.
    residual : Surface
        That body with its indentation, unloaded.
    last : ContactResult
        The last stage. Its surfaces are those before the stage, its approach counts from their
        first touch, and its ``residual_indentation`` is what the stage added.
    """

    path: tuple[Stage, ...]
    steps: tuple[HistoryStep, ...]
    indented_body: str
    indentation: Array
    origin: tuple[int, int]
    residual: Surface
    last: ContactResult

    def column(self, name: str) -> Array:
        """Return one field of all steps, shape (n,); see `HistoryStep` for names and units."""
        if name not in UNITS:
            raise InputError(
                f"must be one of {', '.join(UNITS)}, got {name!r}", argument="name", value=name
            )
        return np.array([getattr(step, name) for step in self.steps], dtype=float)

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
        """Volume of the whole indentation [m³]."""
        dy, dx = self.residual.pixel
        return math.fsum(self.indentation.ravel()) * dy * dx

    @cached_property
    def shaken_down(self) -> bool:
        """Whether going on along the path would stay elastic.

        True if no step indents, or if after the last step that does (more than 1e-5 of the whole
        volume) every position of the path has seen its largest load, or its largest approach,
        again.
        """
        volume = self.column("indentation_volume")
        plastic = np.flatnonzero(volume > SHAKEN_DOWN * self.indentation_volume)
        if plastic.size == 0:
            return True
        wanted = self._largest(0)
        seen = self._largest(int(plastic[-1]) + 1)
        return all(
            what in seen and seen[what] >= value - _REACHED * abs(value)
            for what, value in wanted.items()
        )

    def _largest(self, first: int) -> dict[tuple[tuple[float, float], str], float]:
        """Return the largest load and approach asked for at each position from a stage on."""
        found: dict[tuple[tuple[float, float], str], float] = {}
        for stage in self.path[first:]:
            for control, value in (("load", stage.load), ("approach", stage.approach)):
                if value is not None:
                    what = stage.shift, control
                    found[what] = max(found.get(what, value), value)
        return found

    def summary(self) -> dict[str, Any]:
        """Return the history by name, in SI units, ready for JSON."""
        last = self.last
        ceiling = last.ceiling
        return {
            "source": last.surface.provenance.source,
            "preparation": list(last.surface.provenance.steps),
            "boundary": last.boundary,
            "contact_modulus": last.contact_modulus,
            "ceiling": "per pixel" if isinstance(ceiling, np.ndarray) else ceiling,
            "tolerance": last.tolerance,
            "indented_body": self.indented_body,
            "indentation_volume": self.indentation_volume,
            "max_indentation": float(self.indentation.max()),
            "dissipated_energy": self.dissipated_energy,
            "shaken_down": self.shaken_down,
            "volume_account": VOLUME_ACCOUNT,
            "control": ["approach" if s.load is None else "load" for s in self.path],
            "steps": {name: self.column(name).tolist() for name in UNITS},
            "version": __version__,
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the steps to a table.

        Parameters
        ----------
        path : str or path
            A name that ends in ``.csv`` (one row a step, units in the head) or ``.json`` (with
            the totals).

        Raises
        ------
        InputError
            If the suffix is another one.
        """
        suffix = Path(path).suffix.lower()
        if suffix not in (".csv", ".json"):
            raise InputError(
                f"must end in .csv or .json, got {str(path)!r}", argument="path", value=str(path)
            )
        if suffix == ".csv":
            table = io.StringIO()
            writer = csv.writer(table, lineterminator="\n")
            writer.writerow([f"{name} [{unit}]" for name, unit in UNITS.items()])
            writer.writerows([list(map(repr, asdict(step).values())) for step in self.steps])
            text = table.getvalue()
        else:
            text = json.dumps(self.summary(), indent=2, ensure_ascii=False) + "\n"
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")


def load_history(
    surface: Surface,
    path: Sequence[Stage | float],
    *,
    material: Material,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: str | float | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float = TOLERANCE,
    max_iterations: int = 500,
    progress: Callable[[int, Step], None] | None = None,
) -> LoadHistory:
    """Follow a path of loads and positions with a ceiling that indents for good.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, ceiling, boundary, max_iterations
        As for `solve`.
    path : sequence of Stage or float
        The stages one after the other; a number is a load [N] at the first position.
    tolerance : float
        Certificate ε of every step.
    progress : callable, optional
        Called with the number of the step and the solver's `Step`.

    Returns
    -------
    LoadHistory
        The scalars of every step, and the indented body.

    Raises
    ------
    InputError
        If an argument cannot be used, a shift is no whole number of pixels or leaves the map.
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
    one position the work ∫W dω is what is stored and dissipated. Lateral shifts happen without
    friction and between two stages; their work is not counted.

    The indentation stays on the body with the smaller yield strength: on the surface where both
    are equal or none is known, unless it is rigid. A ceiling per pixel stays with the pixels of
    the surface. On a free boundary what is shifted off the map never touches; a counter-body
    without a map is a flat without end. A periodic counter-body is rolled.

    Volume: an imprint takes its volume away. Saturated pixels are lowered, no pile-up is raised
    in return, and all other pixels keep their height to the bit.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.contact.load_history import load_history
    >>> heights, pixel = rc.reference_map(32)
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> history = load_history(rc.Surface(heights, pixel), [1.0, 0.0, 1.0], material=steel)
    >>> history.shaken_down, history.steps[0].indentation_volume > 0
    (True, True)
    """
    stages = _stages(path)
    problem: dict[str, Any] = {
        "material": material,
        "counter_material": counter_material,
        "ceiling": ceiling,
        "boundary": boundary,
        "tolerance": tolerance,
        "max_iterations": max_iterations,
    }
    solve.check(surface, counter_surface=counter_surface, load=_LEAST, **problem)
    limit = solve.resolved_ceiling(ceiling, material, counter_material, surface.shape)
    problem["ceiling"] = limit
    shifts = [_pixels(stage.shift, surface, n) for n, stage in enumerate(stages, start=1)]
    bodies = _bodies(surface, counter_surface, material, counter_material, boundary, shifts)
    if bodies.on_counter and isinstance(limit, np.ndarray) and any(map(any, shifts)):
        raise InputError(
            "a ceiling per pixel stays with the pixels of surface, but here the counter-body is "
            "indented and moves: give one ceiling, or swap the two bodies"
        )
    indentation = np.zeros(bodies.indented.shape)
    reference = _highest(*bodies.facing(indentation, (0, 0)))
    _check_path(bodies, stages, shifts, reference, problem)

    steps: list[HistoryStep] = []
    solved: ContactResult | None = None
    for number, (stage, shift) in enumerate(zip(stages, shifts, strict=True), start=1):
        first, second = bodies.facing(indentation, shift)
        lowered = reference - _highest(first, second)
        control, target = _target(stage, lowered)
        if target > 0:
            try:
                # Not from the last pressure: on large maps coarse grids find the next one sooner.
                solved = solve.solve(
                    first,
                    counter_surface=second,
                    **{**problem, control: target},
                    progress=None if progress is None else _numbered(progress, number),
                )
            except ConvergenceError as error:
                raise ConvergenceError(
                    f"stage {number} of {len(stages)}: {error}", error.result
                ) from None
        else:
            solved = _apart(first, second, target, control, problem)
        new = solved.residual_indentation
        bodies.indent(indentation, new, shift)
        steps.append(_step(solved, stage, lowered, new))
    assert solved is not None
    indentation.flags.writeable = False
    return LoadHistory(
        path=stages,
        steps=tuple(steps),
        indented_body="counter_surface" if bodies.on_counter else "surface",
        indentation=indentation,
        origin=bodies.origin,
        residual=_indented(bodies.indented, indentation),
        last=solved,
    )


def passes(
    loads: Sequence[float], count: int, shift: tuple[float, float] = (0.0, 0.0)
) -> list[Stage]:
    """Return the stages of a load cycle that is repeated, each time a step further.

    Parameters
    ----------
    loads : sequence of float
        Normal loads of one pass [N], in their order.
    count : int
        Number of passes.
    shift : (float, float)
        Lateral shift ``(y, x)`` of the counter-body from pass to pass [m].

    Returns
    -------
    list of Stage
        ``count × len(loads)`` stages, the first pass at the first position.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    >>> [stage.load for stage in passes([1.0, 0.0], 2)]
    [1.0, 0.0, 1.0, 0.0]
    >>> passes([1.0], 3, shift=(0.0, 2e-6))[2].shift
    (0.0, 4e-06)
    """
    if not isinstance(count, int) or count < 1:
        raise InputError(
            f"must be a positive integer, got {count!r}", argument="count", value=count
        )
    step = Stage(load=0.0, shift=shift).shift
    return [
        Stage(load=load, shift=(number * step[0], number * step[1]))
        for number in range(count)
        for load in loads
    ]


# Path


def _is_finite(value: Any) -> bool:
    return isinstance(value, Real) and math.isfinite(value)


def _stages(path: Sequence[Stage | float]) -> tuple[Stage, ...]:
    stages = []
    for number, stage in enumerate(path, start=1):
        if not isinstance(stage, (Stage, Real)):
            raise InputError(f"stage {number} must be a Stage or a load [N], got {stage!r}")
        try:
            stages.append(stage if isinstance(stage, Stage) else Stage(load=float(stage)))
        except InputError as error:
            raise InputError(f"stage {number}: {error}") from None
    if not stages:
        raise InputError("is empty: give at least one load", argument="path")
    return tuple(stages)


def _pixels(shift: tuple[float, float], surface: Surface, number: int) -> tuple[int, int]:
    """Return a shift in pixels."""
    ratios = [length / edge for length, edge in zip(shift, surface.pixel, strict=True)]
    whole = [round(ratio) for ratio in ratios]
    if any(abs(r - w) > _WHOLE for r, w in zip(ratios, whole, strict=True)):
        near = ", ".join(f"{w * edge:.9g}" for w, edge in zip(whole, surface.pixel, strict=True))
        raise InputError(
            f"stage {number}: shift {shift} m is no whole number of pixels of {surface.pixel} m; "
            f"the nearest is ({near}) m"
        )
    if any(abs(w) >= points for w, points in zip(whole, surface.shape, strict=True)):
        raise InputError(
            f"stage {number}: shift {shift} m is beyond the map of {surface.size} m; stay within it"
        )
    return whole[0], whole[1]


def _target(stage: Stage, lowered: float) -> tuple[str, float]:
    """Return the control of a stage and its value, the approach from the touch of the bodies."""
    if stage.approach is None:
        return "load", stage.load or 0.0
    return "approach", stage.approach - lowered


def _check_path(
    bodies: _Bodies,
    stages: tuple[Stage, ...],
    shifts: list[tuple[int, int]],
    reference: float,
    problem: dict[str, Any],
) -> None:
    """Raise what any stage would raise; indentation changes nothing about that."""
    untouched = np.zeros(bodies.indented.shape)
    for shift in dict.fromkeys(shifts):
        first, second = bodies.facing(untouched, shift)
        lowered = reference - _highest(first, second)
        here = [number for number, other in enumerate(shifts, start=1) if other == shift]
        targets = [(*_target(stages[number - 1], lowered), number) for number in here]
        for control in ("load", "approach"):
            wanted = [(target, number) for kind, target, number in targets if kind == control]
            target, number = max(wanted, default=(0.0, 0))
            if target > 0:
                try:
                    solve.check(first, counter_surface=second, **{**problem, control: target})
                except CapacityError as error:
                    raise CapacityError(f"stage {number} of {len(stages)}: {error}") from None


def _numbered(progress: Callable[[int, Step], None], number: int) -> Callable[[Step], None]:
    return lambda step: progress(number, step)


# Bodies


@dataclass(frozen=True, eq=False)
class _Bodies:
    """Two bodies that face each other at changing positions; one of them is indented.

    ``origin`` is the pixel of the counter-body that faces pixel (0, 0) of the surface unshifted.
    """

    surface: Surface
    counter: Surface | None
    on_counter: bool
    periodic: bool
    origin: tuple[int, int]

    @property
    def indented(self) -> Surface:
        """The body that keeps the indentation, before it."""
        body = self.counter if self.on_counter else self.surface
        assert body is not None
        return body

    def facing(self, indentation: Array, shift: tuple[int, int]) -> tuple[Surface, Surface | None]:
        """Return the two bodies as they face each other, on the grid of the surface."""
        surface, counter = self.surface, self.counter
        if not self.on_counter and indentation.any():
            surface = replace(surface, heights=surface.heights - indentation)
        if counter is None:
            return surface, None
        heights = counter.heights - indentation if self.on_counter else counter.heights
        if self.periodic:
            moved = np.roll(heights, shift, (0, 1))
        else:
            moved = np.full(surface.shape, np.nan)
            here, there = self._overlap(shift)
            moved[here] = heights[there]
        if np.isnan(moved + surface.heights).all():
            raise CapacityError(
                f"no contact is possible: shifted by {shift} pixels the counter-body has no point "
                "left that faces one of the surface"
            )
        return surface, replace(counter, heights=moved, holes_masked=True)

    def _overlap(self, shift: tuple[int, int]) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
        """Return which part of the surface faces the counter-body, and which part of that."""
        assert self.counter is not None
        here, there = [], []
        for axis, (points, own) in enumerate(
            zip(self.surface.shape, self.counter.shape, strict=True)
        ):
            ahead = shift[axis] - self.origin[axis]
            first, last = max(0, ahead), min(points, ahead + own)
            here.append(slice(first, last))
            there.append(slice(first - ahead, last - ahead))
        return tuple(here), tuple(there)

    def indent(self, indentation: Array, new: Array, shift: tuple[int, int]) -> None:
        """Add what was indented on the grid of the surface to the body that keeps it."""
        if not self.on_counter:
            indentation += new
        elif self.periodic:
            indentation += np.roll(new, (-shift[0], -shift[1]), (0, 1))
        else:
            here, there = self._overlap(shift)
            indentation[there] += new[here]


def _bodies(
    surface: Surface,
    counter: Surface | None,
    material: Material,
    counter_material: Material,
    boundary: str,
    shifts: list[tuple[int, int]],
) -> _Bodies:
    body = softer(material, counter_material)
    on_counter = material.compliance == 0 if body is None else body is not material
    origin = (0, 0)
    if on_counter and counter is None:
        shape = surface.shape
        if boundary == "free":
            # A flat without end: as much of it as will face the map.
            least = [min(0, *(shift[axis] for shift in shifts)) for axis in (0, 1)]
            origin = max(0, *(y for y, _ in shifts)), max(0, *(x for _, x in shifts))
            shape = shape[0] + origin[0] - least[0], shape[1] + origin[1] - least[1]
        counter = Surface(np.zeros(shape), surface.pixel, Provenance(source="flat"))
    return _Bodies(surface, counter, on_counter, boundary == "periodic", origin)


def _indented(body: Surface, indentation: Array) -> Surface:
    if not indentation.any():
        return body
    step = f"indented: by up to {indentation.max():.6g} m where the ceiling was reached"
    provenance = replace(body.provenance, steps=(*body.provenance.steps, step))
    return replace(body, heights=body.heights - indentation, provenance=provenance)


def _highest(first: Surface, second: Surface | None) -> float:
    """Return the largest sum of heights that face each other: there they touch first."""
    heights = first.heights if second is None else first.heights + second.heights
    return float(np.fmax.reduce(heights, axis=None))


def _apart(
    first: Surface, second: Surface | None, approach: float, control: str, problem: dict[str, Any]
) -> ContactResult:
    """Return the contact without load, at an approach up to first touch."""
    material, counter_material = problem["material"], problem["counter_material"]
    return ContactResult(
        surface=first,
        counter_surface=second,
        material=material,
        counter_material=counter_material,
        contact_modulus=contact_modulus(material, counter_material),
        ceiling=problem["ceiling"],
        boundary=problem["boundary"],
        precision="double",
        tolerance=problem["tolerance"],
        control=control,
        load=0.0,
        approach=approach,
        pressure=np.zeros(first.shape),
        gap=initial_gap(first, second) - approach,
        certificate=0.0,
        load_error=0.0,
        status="converged",
        iterations=0,
        convolutions=0,
        seconds=0.0,
        version=__version__,
    )


def _step(solved: ContactResult, stage: Stage, lowered: float, new: Array) -> HistoryStep:
    area = solved.pixel_area
    loaded = np.flatnonzero(solved.pressure)
    pressure = solved.pressure.ravel()[loaded]
    opened = solved.gap.ravel()[loaded] - solved.initial_gap.ravel()[loaded]
    displacement = opened + solved.approach
    return HistoryStep(
        load=solved.load,
        approach=solved.approach + lowered,
        shift_y=stage.shift[0],
        shift_x=stage.shift[1],
        contact_area=solved.contact_area,
        saturated_area=int(np.count_nonzero(solved.saturated)) * area,
        max_pressure=solved.max_pressure,
        indentation_volume=float(new.sum()) * area,
        dissipated_energy=float((solved.pressure * new).sum()) * area,
        elastic_energy=0.5 * float((pressure * displacement).sum()) * area,
        certificate=solved.certificate,
        load_error=solved.load_error,
        convolutions=solved.convolutions,
        seconds=solved.seconds,
    )
