"""Tangential loading of a solved contact under Coulomb friction: stick and slip."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import netcdf
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.roots import brentq
from roughcontact.analyses.history.model import indented_surface
from roughcontact.analyses.stress.model import (
    StressResult,
    add_profile,
    subsurface_stress,
    surface_loads,
)
from roughcontact.cautions import Caution, CautionTag, as_caution, sort_cautions
from roughcontact.contact import archive
from roughcontact.contact.load_case import Load, LoadCase, resolve_force
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.series import StepResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.stiffness import unloading_stiffness
from roughcontact.errors import CapacityError, ConvergenceError, InputError, Sentence, message_parts
from roughcontact.halfspace import stress_summary, tangential as halfspace
from roughcontact.halfspace.stress import slices
from roughcontact.halfspace.stress_summary import larger_principal
from roughcontact.halfspace.tensors import XX, XY, YY
from roughcontact.material.material import CEILING_FACTOR
from roughcontact.solvers import partial_slip
from roughcontact.solvers.partial_slip import STICK, TangentialOperator
from roughcontact.solvers.progress import Status
from roughcontact.units import Quantities, Quantity, format_engineering, format_percent, to_si


@dataclass(frozen=True, eq=False, repr=False)
class Fretting:
    """Stress and fretting parameters of the rough body under the last force.

    δ is the slip amplitude in a cycle between that force and its opposite: half of the slip of the
    last step at the end of a cycle, else the total slip. Ruiz, Boddington and Chen 1984,
    Exp. Mech. 24, 208.
    """

    stress: StressResult  # Stress below the contact, with the largest tension at the surface
    tension: Array  # Larger principal stress in the surface at the pixel centers [Pa], (ny, nx)
    work: Array  # Traction times slip τδ [J/m²], (ny, nx); a cycle dissipates four times as much
    ruiz: Array  # σ_t τδ [Pa²·m], (ny, nx), σ_t the stress along the traction; 0 under compression
    # Tangential force of first yield [N]: 0 if the body yields under the load alone, infinite if
    # the contact slides before; None if the load changes, or without a yield strength.
    yield_force: float | None = None

    def __post_init__(self) -> None:
        """Make the maps read-only."""
        for array in (self.tension, self.work, self.ruiz):
            array.flags.writeable = False

    @property
    def max_work(self) -> float:
        """Largest τδ [J/m²]."""
        return float(self.work.max())

    @property
    def max_ruiz(self) -> float:
        """Largest σ_t τδ [Pa²·m]."""
        return float(self.ruiz.max())

    @property
    def max_ruiz_at(self) -> tuple[float, float]:
        """Position of the largest σ_t τδ: y and x [m] from the corner of the map."""
        row, column = np.unravel_index(self.ruiz.argmax(), self.work.shape)
        return self.stress.center((int(row), int(column)))


def fretting(contact: ContactResult, traction: Array, slip: Array) -> Fretting:
    """Return the fretting result of traction [Pa] and slip [m], components (y, x)."""
    below = subsurface_stress(contact, traction=traction)
    surface = next(
        slices(
            contact.pressure,
            contact.pair.pixel,
            [0.0],
            contact.material.poisson,
            traction=traction,
            **surface_loads(contact.pair, "body", 0.0, 0.0),
        )
    ).stress
    in_plane = surface[[XX, YY, XY]].astype(np.float64)
    size = np.hypot(*traction)
    y, x = np.divide(traction, size, out=np.zeros_like(traction), where=size > 0)
    along = x * x * in_plane[0] + y * y * in_plane[1] + 2 * x * y * in_plane[2]
    work = size * np.hypot(*slip)
    return Fretting(below, larger_principal(in_plane), work, np.maximum(along, 0) * work)


MAX_DUNDURS = 0.05
"""Dundurs' β above which neglected coupling of pressure and traction has a caution."""

# Number of forces of the superposition curve, and the certificate of all but the last.
_POINTS, _DRAWN = 2, 1e-4
# Sum of tractions over that of their sizes, below which it is rounding.
_ROUNDING = 1e-12
# Error of the force of first yield, over the force at sliding.
_YIELD = 1e-3


@dataclass(frozen=True)
class TangentialStep:
    """Step of a path; force and shift are along the direction of loading."""

    load: float  # W [N]
    force: float  # Q [N]
    shift: float  # δ [m], rigid shift of the body against its counter-body
    cross_shift: float  # Shift at 90° counter-clockwise from the direction [m]
    stick_fraction: float  # Sticking share of the contact area
    max_slip: float  # Largest total slip [m]
    mean_slip: float  # Mean total slip over the contact [m]
    energy: float  # Energy dissipated in this step [J]
    certificate: float  # Certificate ε_t
    force_error: float  # Error of the force, over the force at sliding
    newton_steps: int  # Newton steps of the solver
    applications: int  # Applications of the displacement operator, each on two fields


@dataclass(frozen=True)
class Superposition:
    """Partial slip by superposition (Ciavarella, Jäger): exact for ν = 0 and for profiles.

    The traction is μ (p(P) - p(P - Q/μ)), the shift μ c (ω(P) - ω(P - Q/μ)).
    """

    force: tuple[float, ...]  # Q, ascending from 0 to the largest force [N]
    shift: tuple[float, ...]  # δ of each force [m]
    stick_fraction: tuple[float, ...]  # Sticking share of the contact area at each force
    cycle_energy: tuple[float, ...]  # Energy of a cycle between ±Q [J]
    traction_difference: float  # ‖q - q_s‖/‖q‖ at the largest force; NaN after several steps


@dataclass(frozen=True, eq=False, repr=False)
class Tangential(StepResult):
    """Result of tangential loading: traction, slip and stiffness.

    Vector maps have the components (y, x), and are those of the last step.

    Parameters
    ----------
    solution : ContactResult
        The contact under the last load.
    friction : float
        Coefficient μ.
    direction : float
        Angle of the force from x [degrees], counter-clockwise as seen in the map.
    steps : tuple of TangentialStep
        Steps of the path, in order.
    traction : ndarray, shape (2, ny, nx)
        Traction on the body [Pa].
    slip : ndarray, shape (2, ny, nx)
        Total slip of the body against its counter-body [m]; 0 outside the contact.
    bound : ndarray, shape (ny, nx)
        Largest traction of each pixel [Pa].
    initial_stiffness : float
        dQ/dδ at full stick [N/m].
    tangent_stiffness : float
        dQ/dδ on a further increase of the last force [N/m].
    superposition : Superposition or None
        Curve by superposition, under a constant load without shear yield.
    messages : tuple of Caution
        Cautions on the tangential loading.
    fretting : Fretting or None
        Stress below the surface, tension and Ruiz' parameters under the last force, if requested.
    calibrated : Tangential or None
        The same loading under the calibrated ceiling, if computed.
    """

    solution: ContactResult
    friction: float
    direction: float
    steps: tuple[TangentialStep, ...]
    traction: Array
    slip: Array
    bound: Array
    initial_stiffness: float
    tangent_stiffness: float
    superposition: Superposition | None = None
    messages: tuple[Caution, ...] = ()
    fretting: Fretting | None = None
    calibrated: Tangential | None = None

    def __post_init__(self) -> None:
        """Make the maps read-only."""
        for array in (self.traction, self.slip, self.bound):
            array.flags.writeable = False

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the result, the most severe first."""
        below = () if self.fretting is None else self.fretting.stress.own_cautions
        return sort_cautions([*self.solution.cautions, *self.messages, *below])

    @property
    def last(self) -> TangentialStep:
        """Last step."""
        return self.steps[-1]

    @property
    def capacity(self) -> float:
        """Force at which the contact slides [N]."""
        return float(self.bound.sum()) * self.solution.pixel_area

    @cached_property
    def stick(self) -> NDArray[np.bool_]:
        """Pixels in contact below their bound, shape (ny, nx)."""
        return np.hypot(*self.traction) < self.bound * (1 - STICK)

    @property
    def stiffness_per_area(self) -> float:
        """Initial tangential stiffness over the nominal area k_t [Pa/m]."""
        return self.initial_stiffness / self.solution.nominal_area

    @property
    def cycle_energy(self) -> float:
        """Energy dissipated in a cycle between ±Q [J].

        The energy of the last two steps if the path ends in Q, -Q, Q; four times the energy of a
        single step (Masing); NaN for other paths.
        """
        if len(self.steps) == 1:
            return math.nan if self.superposition is None else 4 * self.last.energy
        return self.steps[-2].energy + self.last.energy if self.is_cycle else math.nan

    @property
    def loss_factor(self) -> float:
        """Energy of a cycle over 2π times its elastic energy ½ Q δ; NaN like `cycle_energy`."""
        amplitude = self.last.shift
        if self.is_cycle:
            amplitude = 0.5 * (self.last.shift - self.steps[-2].shift)
        work = math.pi * self.last.force * amplitude
        return self.cycle_energy / work if work else math.nan

    @property
    def is_cycle(self) -> bool:
        """Whether the path ends in a cycle Q, -Q, Q under one load."""
        return len(self.steps) > 2 and _is_cycle([(s.load, s.force) for s in self.steps[-3:]])

    @property
    def applications(self) -> int:
        """Applications of the displacement operator in all steps."""
        return sum(step.applications for step in self.steps)


def to_dataset(result: Tangential) -> netcdf.Dataset:
    """Return a tangentially loaded contact as a dataset."""
    dataset = archive.to_dataset(result.solution)
    for name, field, unit, text in (
        ("traction", result.traction, "Pa", "tangential traction on the body"),
        ("slip", result.slip, "m", "slip of the body against its counter-body"),
    ):
        for axis, values in zip("yx", field, strict=True):
            dataset.add(f"{name}_{axis}", ("y", "x"), values, unit, f"{text} along {axis}")
    stick = result.stick.astype(np.uint8)
    dataset.add("stick", ("y", "x"), stick, "1", "contact that sticks")
    if result.fretting is not None:
        add_profile(dataset, result.fretting.stress.profile)
        for name, field, unit, text in (
            ("tension", result.fretting.tension, "Pa", "larger principal stress in the surface"),
            ("frictional_work", result.fretting.work, "J/m2", "traction times slip"),
            ("ruiz", result.fretting.ruiz, "Pa2 m", "tension times traction times slip"),
        ):
            dataset.add(name, ("y", "x"), field, unit, text)
    for name, unit in (("load", "N"), ("force", "N"), ("shift", "m"), ("energy", "J")):
        dataset[f"step_{name}"] = ("step", result.column(name), {"units": unit})
    dataset.attrs |= {
        "title": "Tangential loading of a contact of rough surfaces",
        "friction": result.friction,
        "direction": result.direction,
        "direction_units": "degree",
        "tangential_certificate": max(step.certificate for step in result.steps),
        "warnings": "\n".join(result.warnings),
    }
    return dataset


def _norm(field: Array) -> float:
    # Not by BLAS, whose last digits depend on the number of threads.
    return math.sqrt(float(np.square(field).sum()))


def joint_poisson(pair: Pair) -> float:
    """Return the equivalent Poisson's ratio of the pair, Σ(ν/G)/Σ(1/G)."""
    bodies = _shear(pair)
    return sum(poisson * shear for poisson, shear in bodies) / sum(shear for _, shear in bodies)


def tangential_compliance(pair: Pair) -> float:
    """Return the ratio c of tangential to normal compliance at full stick.

    (2 - ν)/(2 (1 - ν)), which is exact for a circle; 1 for profiles (Mindlin 1949).
    """
    poisson = joint_poisson(pair)
    return 1.0 if pair.is_profile else (2 - poisson) / (2 * (1 - poisson))


def dundurs(pair: Pair) -> float:
    """Return Dundurs' β, the coupling of pressure and tangential displacement."""
    bodies = _shear(pair)
    first, second = ((1 - 2 * poisson) * shear for poisson, shear in bodies)
    return (first - second) / (2 * sum((1 - poisson) * shear for poisson, shear in bodies))


def _shear(pair: Pair) -> list[tuple[float, float]]:
    """Return ν and 1/G of both bodies."""
    bodies = (pair.material, pair.counter_material)
    return [(body.poisson, 2 * (1 + body.poisson) / body.young) for body in bodies]


def shear_strength(result: ContactResult) -> float:
    """Return the shear strength σ_Y/√3 of the softer body [Pa]; infinite without a ceiling."""
    if result.ceiling is None:
        return math.inf
    softer = result.pair.softer
    known = None if softer is None else softer.ceiling
    ceiling = float(np.max(result.ceiling)) if known is None else known
    return ceiling / CEILING_FACTOR / math.sqrt(3)


def stick_ratios(result: ContactResult) -> tuple[float, float]:
    """Return tangential over unloading stiffness at full stick, along y and along x.

    2 (1 - ν)/(2 - ν) for a circle (Mindlin 1949); less along a lay, 1 across long narrow spots.
    """
    result.boundary.require_known_below("tangential loading")
    result.pair.require_uncoated("tangential loading")
    operator, index = _operator(result.pair), np.flatnonzero(result.pressure)
    normal = unloading_stiffness(result)
    along_y, along_x = (
        partial_slip.stiffness(operator, index, unit) * result.pixel_area / normal
        for unit in np.eye(2)
    )
    return along_y, along_x


def _operator(pair: Pair) -> TangentialOperator:
    return halfspace.operator(
        pair.boundary, pair.shape, pair.pixel, pair.contact_modulus, joint_poisson(pair)
    )


@validate_arguments
def tangential(
    result: ContactResult,
    *,
    friction: float,
    force: Quantity | Quantities | None = None,
    shift: Quantity | None = None,
    direction: float = 0.0,
    stages: Sequence[tuple[Quantity | Load, Quantity]] | None = None,
    stress: bool = False,
    tolerance: float = 1e-6,
) -> Tangential:
    """Return traction, stick and slip of a contact under a tangential force.

    Parameters
    ----------
    result : ContactResult
        The contact, without tilt, on a free or periodic map or of profiles.
    friction : float
        Coefficient μ of Coulomb's law: the traction is at most μ p, and under a ceiling also at
        most σ_Y/√3 of the softer body.
    force : float, str, quantity of pint, or several of them
        Tangential force Q on the body along ``direction`` [N], for profiles [N/m]; several forces
        are applied one after the other. Give ``force``, ``shift`` or ``stages``.
    shift : float, str or quantity of pint
        Rigid shift δ of the body along ``direction`` [m], instead of a force.
    direction : float
        Angle from x [degrees], counter-clockwise as seen in the map, whose first row is drawn on
        top: 90 points to smaller y.
    stages : sequence of (load, force)
        Loads and tangential forces that change together, starting without contact.
    stress : bool
        Whether to compute also the stress below the surface under the last force, tension, Ruiz'
        parameters and the force of first yield (``fretting`` of the result).
    tolerance : float
        Certificate of each step.

    Returns
    -------
    Tangential
        Traction and slip of the last step, and the scalars of all steps.

    Raises
    ------
    InputError
        If an argument cannot be used, the bodies tilt, or the map is a strip.
    CapacityError
        If friction cannot carry the force, so that the contact slides.
    ConvergenceError
        If a step does not reach the tolerance.

    Notes
    -----
    Quasi-static, elastic half-spaces, small slip. The effect of the traction on the pressure is
    neglected (Goodman 1962), which is exact if Dundurs' β is 0. In each step the slip
    Δs = Δδ - K Δq vanishes where ``|q|`` < μ p, and is along q elsewhere; q has both components.
    On an increase of the load, pixels slip only after they come into contact: their slip in a step
    is less by Δδ - (ΔQ/ΔP) K Δp, that of a traction in proportion to the pressure. Such a traction
    is exact for a ball under Q = kP, k < μ, in any number of stages (Mindlin and Deresiewicz 1953);
    on a rough map 4 stages were within 4 % (RMS) of 64, and 16 within 1.3 %.

    References
    ----------
    Cattaneo 1938, Rend. Accad. Naz. Lincei 27, 342; Mindlin 1949, J. Appl. Mech. 16, 259;
    Mindlin and Deresiewicz 1953, J. Appl. Mech. 20, 327; Goodman 1962, J. Appl. Mech. 29, 515;
    Jäger 1998, J. Tribol. 120, 677; Ciavarella 1998, Int. J. Solids Struct. 35, 2349

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> rough = rc.Surface(*rc.reference_map(64))
    >>> contact = rc.solve(rough, material=steel, counter_material=steel, load=1.0)
    >>> found = rc.tangential(contact, friction=0.15, force="0.1 N")
    >>> bool(0 < found.last.stick_fraction < 1)
    True
    """
    _check(result, friction, direction)
    requested = {"force": force, "shift": shift, "stages": stages}
    if sum(value is not None for value in requested.values()) != 1:
        raise InputError("or shift or stages is needed, and only one of them", argument="force")
    path = _Path(result, friction, direction, tolerance)
    if stages is None:
        path.contact = path.heaviest = result
    if shift is not None:
        path.advance(result, shift=_number(shift, "length", "shift"))
    for load, tangential_force in _stages(result, force, stages):
        path.advance(path.contact_under(load), force=tangential_force)
    found = path.outcome()
    if not stress:
        return found
    amplitude = 0.5 * path.last_slip if found.is_cycle else path.slip
    below = fretting(found.solution, found.traction, amplitude.reshape(found.slip.shape))
    return replace(found, fretting=replace(below, yield_force=_yield_force(path)))


def _check(result: ContactResult, friction: float, direction: float) -> None:
    """Raise an error for contacts that cannot be loaded tangentially."""
    result.pair.require_uncoated("tangential loading")
    require_friction(friction)
    if result.moments is not None:
        raise InputError("tangential loading needs a contact without tilt", argument="result")
    if result.pair.is_profile:
        if direction not in (0.0, 180.0):
            raise InputError("must be 0 for a profile", argument="direction", value=direction)
    else:
        result.boundary.require_known_below("tangential loading")
    if not result.contact.any():
        raise CapacityError("the bodies do not touch and carry no tangential force")


def require_friction(friction: float) -> None:
    """Raise `InputError` for an invalid coefficient of friction."""
    if not 0 < friction < math.inf:
        raise InputError(
            f"must be positive, such as 0.15, got {friction!r}", argument="friction", value=friction
        )


def _number(value: Any, dimension: str, argument: str) -> float:
    result = to_si(value, dimension, argument)
    if not math.isfinite(result):
        raise InputError(f"must be finite, got {value!r}", argument=argument, value=value)
    return float(result)


def _stages(
    result: ContactResult, force: Any, stages: Sequence[Any] | None
) -> list[tuple[float, float]]:
    """Return loads and tangential forces of a path [N], or [N/m] for profiles."""
    dimension = result.pair.load_dimension
    if force is not None:
        single = isinstance(force, (str, int, float)) or getattr(force, "shape", None) == ()
        forces = [force] if single or hasattr(force, "m_as") else list(force)
        return [(result.load, _number(item, dimension, "force")) for item in forces]
    if stages is None:
        return []
    resolved = []
    for load, item in stages:
        under = resolve_force(load, result.pair, "stages")[0]
        if not under > 0:
            raise InputError(f"need positive loads, got {load!r}", argument="stages", value=load)
        resolved.append((float(under), _number(item, dimension, "stages")))
    return resolved


class _Path:
    """State of a contact along a path of loads and tangential forces."""

    def __init__(
        self, result: ContactResult, friction: float, direction: float, tolerance: float
    ) -> None:
        self.result, self.friction, self.direction = result, friction, direction
        self.tolerance = tolerance
        angle = math.radians(direction)
        # Rows count downwards, angles counter-clockwise.
        self.along = np.round([-math.sin(angle), math.cos(angle)], 15)
        self.across = np.array([-self.along[1], self.along[0]])
        self.operator = _operator(result.pair)
        points = result.pressure.size
        self.contact: ContactResult | None = None
        self.heaviest: ContactResult | None = None
        self.traction, self.slip = np.zeros((2, points)), np.zeros((2, points))
        self.last_slip = self.slip
        self.bound = np.zeros(points)
        self.shift = np.zeros(2)
        self.steps: list[TangentialStep] = []

    def contact_under(self, load: float) -> ContactResult:
        """Return the contact under a load; unloading is elastic on the indented surface."""
        heaviest, result = self.heaviest, self.result
        if heaviest is not None and load < heaviest.load:
            return _unload(heaviest, load)
        return result if load == result.load else solve_pair(result.pair, _case(result, load))

    def advance(
        self, contact: ContactResult, force: float | None = None, shift: float | None = None
    ) -> None:
        """Solve one step and append it to the path."""
        index, area = np.flatnonzero(contact.pressure), contact.pixel_area
        bound = self.friction * contact.pressure.ravel()[index]
        bound = np.minimum(bound, shear_strength(self.result))
        before = self.steps[-1].force if self.steps else 0.0
        if force is not None:
            self._require_stick(contact, force, float(bound.sum()) * area)
        offset = self._offset(contact, index, 0.0 if force is None else force - before)
        earlier = self.traction[:, index]
        goal = None if force is None else force / area * self.along
        reverses = contact is self.contact and force and math.isclose(force, -before, rel_tol=1e-9)
        solution = partial_slip.solve(
            self.operator,
            partial_slip.PartialSlipProblem(
                index,
                bound,
                offset,
                total=goal,
                shift=None if shift is None else shift * self.along,
                # At full reversal the traction is that before the step with opposite sign (Masing).
                start=-earlier if reverses else None,
                scale=_norm(earlier),
            ),
            self.tolerance,
        )
        self._append_step(contact, index, bound, solution)
        if solution.status is not Status.CONVERGED:
            text = (
                f"tangential loading not converged: certificate {solution.certificate:.1e} "
                f"(tolerance {self.tolerance:.0e}), force error {solution.force_error:.1e}: "
            )
            words = Sentence(text, *message_parts(solution.status.value))
            raise ConvergenceError(words, self.outcome())

    def _require_stick(self, contact: ContactResult, force: float, capacity: float) -> None:
        if abs(force) < capacity * (1 - 1e-9):
            return
        unit = contact.pair.load_unit
        raise CapacityError(
            f"= {format_engineering(force, unit)}, but the contact slides at "
            f"{format_engineering(capacity, unit)}"
            f" (μ {self.friction:g}); give a smaller force, or a shift",
            argument="force",
            value=force,
        )

    def _offset(self, contact: ContactResult, index: NDArray[np.int64], growth: float) -> Array:
        """Return K q before the step, less the slip before new pixels come into contact."""
        offset = self._displacement(self.traction, index)
        before = self.contact
        load, approach, gap, pressure = (
            (0.0, 0.0, contact.initial_gap, np.zeros_like(contact.pressure))
            if before is None
            else (before.load, before.approach, before.gap, before.pressure)
        )
        if contact.load <= load or not growth:
            return offset
        rate = growth / (contact.load - load) * self.along[:, None]
        change = (contact.pressure - pressure).ravel()
        # A change without slip is in proportion to that of the pressure.
        moved = self._displacement(rate * change, index)
        entered, saturated = pressure.ravel()[index] == 0, contact.saturated.ravel()[index]
        compliance = tangential_compliance(contact.pair) * rate
        shift = compliance * (contact.approach - approach)
        held = ~entered & ~saturated
        if held.any():
            shift = moved[:, held].mean(axis=1, keepdims=True)
        # The normal displacement of saturated pixels is not elastic.
        slip = np.where(saturated, compliance * np.fmax(gap.ravel()[index], 0.0), shift - moved)
        return offset - entered * slip

    def _displacement(self, traction: Array, index: NDArray[np.int64]) -> Array:
        """Return K q at some pixels, for the traction of all, shape (2, n)."""
        if not traction.any():
            return np.zeros((2, index.size))
        union = np.union1d(index, np.flatnonzero(traction.any(axis=0)))
        displacement = self.operator.gather(self.operator.support(union), traction[:, union])
        return displacement[:, np.searchsorted(union, index)]

    def _append_step(
        self,
        contact: ContactResult,
        index: NDArray[np.int64],
        bound: Array,
        solution: partial_slip.PartialSlipSolution,
    ) -> None:
        """Append a solved step and update the state."""
        area, size = contact.pixel_area, np.hypot(*solution.traction)
        slips = size >= bound * (1 - STICK)
        slip = solution.slip * slips
        self.last_slip, total = np.zeros_like(self.slip), np.zeros_like(self.slip)
        self.last_slip[:, index] = slip
        total[:, index] = self.slip[:, index] + slip
        self.traction, self.bound = np.zeros_like(self.slip), np.zeros_like(self.bound)
        self.traction[:, index], self.bound[index] = solution.traction, bound
        self.slip, self.contact, self.shift = total, contact, self.shift + solution.shift
        if self.heaviest is None or contact.load >= self.heaviest.load:
            self.heaviest = contact
        length = np.hypot(*total[:, index])
        force = float(self.along @ solution.traction.sum(axis=1)) * area
        self.steps.append(
            TangentialStep(
                load=contact.load,
                # A force removed again leaves the rounding of the sum.
                force=force if abs(force) > _ROUNDING * float(size.sum()) * area else 0.0,
                shift=float(self.along @ self.shift),
                cross_shift=float(self.across @ self.shift),
                stick_fraction=1 - int(np.count_nonzero(slips)) / index.size,
                max_slip=float(length.max()),
                mean_slip=float(length.mean()),
                energy=float((solution.traction * slip).sum()) * area,
                certificate=solution.certificate,
                force_error=solution.force_error,
                newton_steps=solution.steps,
                applications=solution.applications,
            )
        )

    def outcome(self) -> Tangential:
        """Return the result of the steps so far."""
        contact = self.contact
        assert contact is not None
        shape = contact.pressure.shape
        index = np.flatnonzero(contact.pressure)
        ahead = self.along if self.steps[-1].force >= 0 else -self.along
        area = contact.pixel_area
        end = self.traction[:, index], self.last_slip[:, index], self.bound[index]
        return Tangential(
            solution=contact,
            friction=self.friction,
            direction=self.direction,
            steps=tuple(self.steps),
            traction=self.traction.reshape(2, *shape),
            slip=self.slip.reshape(2, *shape),
            bound=self.bound.reshape(shape),
            initial_stiffness=area * partial_slip.stiffness(self.operator, index, ahead),
            tangent_stiffness=area * partial_slip.stiffness(self.operator, index, ahead, end),
            superposition=self._superposition(),
            messages=tuple(_messages(self, contact)),
        )

    def _superposition(self) -> Superposition | None:
        """Return the superposition curve; None if the load changes, at sliding or shear yield."""
        contact = self.contact
        assert contact is not None
        constant = all(step.load == self.result.load for step in self.steps)
        force = max(abs(step.force) for step in self.steps)
        limit = self.friction * contact.load * (1 - 1e-9)
        if not constant or not 0 < force < limit or self.bound.max() >= shear_strength(contact):
            return None
        return _superpose_partial_slip(self, contact, force)


def _yield_force(path: _Path) -> float | None:
    """Return the tangential force of first yield of the body; see `Fretting`."""
    contact, bound = path.result, path.bound
    strength = contact.material.yield_strength
    if strength is None or any(step.load != contact.load for step in path.steps):
        return None
    capacity = float(bound.sum()) * contact.pixel_area
    ahead = math.copysign(1.0, path.steps[-1].force)

    @cache
    def excess(force: float) -> float:
        traction = ahead * path.along[:, None] * bound
        if force < capacity:
            trial = _Path(contact, path.friction, path.direction, _DRAWN)
            trial.contact = contact
            trial.advance(contact, force=ahead * force)
            traction = trial.traction
        summary = stress_summary.summarize(
            contact.pressure,
            contact.pair.pixel,
            contact.material.poisson,
            traction=traction.reshape(2, *contact.pressure.shape),
            **surface_loads(contact.pair, "body", 0.0, 0.0),
        )
        return summary.max_von_mises / strength - 1

    if excess(0.0) >= 0:
        return 0.0
    if excess(capacity) < 0:
        return math.inf
    return brentq(excess, 0.0, capacity, xtol=_YIELD * capacity)


def _case(result: ContactResult, load: float) -> LoadCase:
    return LoadCase(
        load=load, ceiling=result.ceiling, tolerance=result.tolerance, precision=result.precision
    )


def _unload(
    heaviest: ContactResult, load: float, start: Any = None, tolerance: float = 0.0
) -> ContactResult:
    """Return the contact under a smaller load, elastic on the indented surface."""
    pair = replace(heaviest.pair, surface=indented_surface(heaviest))
    case = replace(
        _case(heaviest, load), ceiling=None, tolerance=max(heaviest.tolerance, tolerance)
    )
    return solve_pair(pair, case, start=start)


def _superpose_partial_slip(path: _Path, contact: ContactResult, force: float) -> Superposition:
    """Return partial slip by superposition of pressures on the unloading branch."""
    friction, area = path.friction, contact.pixel_area
    compliance = tangential_compliance(contact.pair)
    full = contact
    if contact.saturated.any():
        full = _unload(contact, contact.load, contact.pressure)
    forces, shifts, sticks, energies = [0.0], [0.0], [1.0], [0.0]
    smaller = full
    for part in range(1, _POINTS + 1):
        forces.append(force * part / _POINTS)
        rough = _DRAWN if part < _POINTS else 0.0
        smaller = _unload(contact, contact.load - forces[-1] / friction, smaller.pressure, rough)
        traction = friction * (full.pressure - smaller.pressure)
        shifts.append(friction * compliance * (full.approach - smaller.approach))
        sticks.append(
            int(np.count_nonzero(smaller.pressure)) / int(np.count_nonzero(full.pressure))
        )
        opened = np.where(full.contact, smaller.gap - full.gap, 0.0)
        energies.append(4 * friction * compliance * float((traction * opened).sum()) * area)
    difference = math.nan
    if len(path.steps) == 1:
        sign = math.copysign(1.0, path.steps[0].force)
        apart = path.traction - sign * path.along[:, None] * traction.ravel()
        difference = _norm(apart) / _norm(path.traction)
    return Superposition(tuple(forces), tuple(shifts), tuple(sticks), tuple(energies), difference)


def _is_cycle(points: Sequence[tuple[float, float]]) -> bool:
    """Return whether three points are Q, -Q, Q under one load."""
    (first, up), (second, down), (third, again) = points
    close = 1e-6 * abs(up)
    return first == second == third and abs(up - again) <= close and abs(up + down) <= close


def _messages(path: _Path, contact: ContactResult) -> Iterator[Caution]:
    """Yield the cautions of the tangential loading."""
    beta = dundurs(contact.pair)
    if abs(beta) > MAX_DUNDURS:
        yield as_caution(
            CautionTag.UNLIKE_BODIES,
            f"Unlike bodies (Dundurs β {beta:.2f}): coupling of pressure and traction is "
            "neglected. Stiffness error is about 3 % or less.",
            beta=beta,
        )
    area = np.count_nonzero(contact.pressure)
    yields = np.count_nonzero(path.bound >= shear_strength(path.result)) / area
    if yields:
        yield as_caution(
            CautionTag.SHEAR_YIELD,
            f"Shear yields on {format_percent(yields)} of the contact at most: traction is limited "
            "to σ_Y/√3 there.",
            share=yields,
        )
    saturated = np.count_nonzero(contact.saturated) / area
    if saturated:
        yield as_caution(
            CautionTag.JUNCTION_GROWTH,
            f"{format_percent(saturated)} of the contact is at the ceiling: shear enlarges such "
            "junctions. The model keeps their area.",
            share=saturated,
        )
