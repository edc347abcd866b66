"""Load curves: the same contact under one load after the other."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, fields
from itertools import pairwise
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.contact import resume, solve
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.curve import LoadCurve, LoadStep
from roughcontact.contact.pair import initial_gap
from roughcontact.contact.result import ContactResult
from roughcontact.contact.stiffness import stiffness
from roughcontact.errors import ConvergenceError, FormatError, InputError
from roughcontact.files import replacing
from roughcontact.material.material import RIGID, Material, contact_modulus
from roughcontact.solvers.progress import Step
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]


def load_curve(
    surface: Surface,
    *,
    material: Material,
    loads: Sequence[float] | None = None,
    approaches: Sequence[float] | None = None,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: str | float | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 500,
    precision: str = "double",
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[int, Step], None] | None = None,
) -> LoadCurve:
    """Solve a contact under one load after the other.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, ceiling, boundary, tolerance, \
max_iterations, precision
        As for `solve`.
    loads : sequence of float
        Normal loads W [N], ascending; give either this or ``approaches``.
    approaches : sequence of float
        Approaches ω [m], ascending.
    folder : path, optional
        Where every finished step is saved at once; made if it does not exist. The same call on
        the same folder goes on after the last finished step and ends with the same numbers.
    progress : callable, optional
        Called with the number of the step and the solver's `Step`.

    Returns
    -------
    LoadCurve
        The scalars of every step.

    Raises
    ------
    InputError
        If an argument cannot be used, or the folder holds the steps of another sweep.
    CapacityError, InsufficientMemoryError
        As for `solve`; the largest load is checked before the first step.
    ConvergenceError
        If a step did not reach the tolerance; the steps before it stay in the folder.

    Notes
    -----
    Each solve starts from the pressure of the load before it. The model keeps no history:
    every step is the same as if it were solved alone, within its certificate.

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
        raise InputError("give either loads or approaches, and only one of them")
    control = "load" if approaches is None else "approach"
    wanted = _ascending("loads" if approaches is None else "approaches", loads, approaches)
    problem: dict[str, Any] = {
        "material": material,
        "counter_material": counter_material,
        "counter_surface": counter_surface,
        "ceiling": ceiling,
        "boundary": boundary,
        "tolerance": tolerance,
        "max_iterations": max_iterations,
        "precision": precision,
    }
    solve.check(surface, **problem, **{control: wanted[-1]})
    record = None
    if folder is not None:
        record = resume.claim(
            folder, _described(surface, problem, control, wanted),
            kind="sweep", record="sweep.json", pattern="step-*.npz",
        )  # fmt: skip
    steps: list[LoadStep] = []
    pressure: Array | None = None
    # Steps are named by their number, and each is complete once it is there.
    for number, value in enumerate(wanted, start=1):
        path = None if record is None else record / f"step-{number:04d}.npz"
        if path is not None and path.exists():
            step, pressure = _read_step(path, surface.shape)
            steps.append(step)
            continue
        try:
            solved = solve.solve(
                surface,
                **{**problem, control: value},
                start=pressure,
                progress=None if progress is None else _numbered(progress, number),
            )
            step = _step(solved)
        except ConvergenceError as error:
            kept = "" if record is None else f"; the steps before it are kept in {record}"
            unit = "N" if control == "load" else "m"
            raise ConvergenceError(
                f"step {number} of {len(wanted)}, {control} = {value:.6g} {unit}: {error}{kept}",
                error.result,
            ) from None
        pressure = solved.pressure
        if path is not None:
            _write_step(path, step, pressure)
        steps.append(step)
    gap = initial_gap(surface, counter_surface)
    return LoadCurve(
        steps=tuple(steps),
        control=control,
        nominal_area=surface.size[0] * surface.size[1],
        contact_modulus=contact_modulus(material, counter_material),
        rms_gradient=roughness.rms_gradient(gap, surface.pixel),
        ceiling=resolved_ceiling(ceiling, material, counter_material, surface.shape),
        boundary=boundary,
        source=surface.provenance.source,
        preparation=surface.provenance.steps,
    )


def spaced(first: float, last: float, number: int, spacing: str = "log") -> list[float]:
    """Return loads or approaches between two ends.

    Parameters
    ----------
    first, last : float
        The ends, ``0 < first < last``.
    number : int
        How many, both ends included; at least 2.
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
    if number < 2:
        raise InputError(f"must be at least 2, got {number}", argument="number")
    values = (np.geomspace if spacing == "log" else np.linspace)(first, last, number)
    return [float(value) for value in values]


def _ascending(
    name: str, loads: Sequence[float] | None, approaches: Sequence[float] | None
) -> list[float]:
    given = list(loads if loads is not None else approaches or ())
    if not given:
        raise InputError("is empty: give at least one value", argument=name)
    if not all(isinstance(value, Real) and 0 < value < math.inf for value in given):
        raise InputError(f"must be positive and finite, got {given}", argument=name)
    values = [float(value) for value in given]
    if any(second <= first for first, second in pairwise(values)):
        raise InputError(f"must ascend, got {given}; sort them", argument=name)
    return values


def _numbered(progress: Callable[[int, Step], None], number: int) -> Callable[[Step], None]:
    return lambda step: progress(number, step)


def _step(solved: ContactResult) -> LoadStep:
    spots = solved.spots()
    return LoadStep(
        load=solved.load,
        approach=solved.approach,
        contact_area=solved.contact_area,
        corrected_contact_area=solved.corrected_contact_area,
        saturated_area=solved.saturated_fraction * solved.pressure.size * solved.pixel_area,
        max_pressure=solved.max_pressure,
        mean_gap=solved.mean_gap,
        stiffness=stiffness(solved),
        spots=spots.count,
        mean_spot_area=float(spots.area.mean()) if spots.count else 0.0,
        largest_spot_area=float(spots.area[0]) if spots.count else 0.0,
        certificate=solved.certificate,
        load_error=solved.load_error,
        convolutions=solved.convolutions,
        seconds=solved.seconds,
    )


# Steps on disk


def _described(
    surface: Surface, problem: dict[str, Any], control: str, wanted: list[float]
) -> dict[str, Any]:
    ceiling = problem["ceiling"]
    bodies = (problem[name] for name in ("counter_surface", "material", "counter_material"))
    plain = isinstance(ceiling, str) or ceiling is None
    return {
        **resume.contact(surface, *bodies),
        "ceiling": ceiling if plain else resume.digest(ceiling),
        **{n: problem[n] for n in ("boundary", "tolerance", "max_iterations", "precision")},
        "control": control,
        "values": wanted,
    }


def _write_step(path: Path, step: LoadStep, pressure: Array) -> None:
    index = np.flatnonzero(pressure)
    with replacing(path) as temporary:
        arrays: dict[str, Any] = {"index": index, "pressure": pressure.ravel()[index]}
        np.savez(temporary, **arrays, **asdict(step))


def _read_step(path: Path, shape: tuple[int, int]) -> tuple[LoadStep, Array]:
    try:
        with np.load(path) as stored:
            values: dict[str, Any] = {
                field.name: (int if field.type == "int" else float)(stored[field.name])
                for field in fields(LoadStep)
            }
            pressure = np.zeros(shape)
            pressure.ravel()[stored["index"]] = stored["pressure"]
    # NumPy and zipfile fail on damaged files with errors of many kinds.
    except Exception as error:
        raise FormatError(
            f"{path} cannot be read as a step of a sweep ({type(error).__name__}); remove it to "
            "solve it again"
        ) from None
    return LoadStep(**values), pressure
