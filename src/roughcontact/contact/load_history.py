"""Load history: what saturated pixels leave behind, along any path of loads and positions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact import solve
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.facing import Facing, facing, highest, indented
from roughcontact.contact.history import HistoryStep, LoadHistory, Stage
from roughcontact.contact.pair import initial_gap
from roughcontact.contact.result import ContactResult
from roughcontact.errors import CapacityError, ConvergenceError, InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import RIGID, Material, contact_modulus
from roughcontact.solvers.progress import Step
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Certificate of every step by default.

With it a reloading meets the loading again to some 1e-11 of the approach, with 1e-6 to some 1e-8;
it costs a third more.
"""


# A load that every surface carries, to check the other arguments with.
_LEAST = float(np.finfo(float).tiny)
# A shift this near to whole pixels is one, in pixels.
_WHOLE = 1e-6


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
    limit = resolved_ceiling(ceiling, material, counter_material, surface.shape)
    problem["ceiling"] = limit
    shifts = [_pixels(stage.shift, surface, n) for n, stage in enumerate(stages, start=1)]
    bodies = facing(
        surface, counter_surface, material, counter_material, Boundary(boundary), shifts
    )
    if bodies.on_counter and isinstance(limit, np.ndarray) and any(map(any, shifts)):
        raise InputError(
            "a ceiling per pixel stays with the pixels of surface, but here the counter-body is "
            "indented and moves: give one ceiling, or swap the two bodies"
        )
    indentation = np.zeros(bodies.indented.shape)
    reference = highest(*bodies.facing(indentation, (0, 0)))
    _check_path(bodies, stages, shifts, reference, problem)

    steps: list[HistoryStep] = []
    solved: ContactResult | None = None
    for number, (stage, shift) in enumerate(zip(stages, shifts, strict=True), start=1):
        first, second = bodies.facing(indentation, shift)
        lowered = reference - highest(first, second)
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
        residual=indented(bodies.indented, indentation),
        last=solved,
    )


# Path


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
    bodies: Facing,
    stages: tuple[Stage, ...],
    shifts: list[tuple[int, int]],
    reference: float,
    problem: dict[str, Any],
) -> None:
    """Raise what any stage would raise; indentation changes nothing about that."""
    untouched = np.zeros(bodies.indented.shape)
    for shift in dict.fromkeys(shifts):
        first, second = bodies.facing(untouched, shift)
        lowered = reference - highest(first, second)
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
