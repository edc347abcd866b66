"""Repeated passes of a counter-body over yielding bodies: shakedown or ratcheting."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import memory, netcdf
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.files import require_suffix, write_atomically
from roughcontact.analyses.history.model import indent_body
from roughcontact.cautions import Caution, sort_cautions
from roughcontact.contact import archive as contact_archive
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.elastoplastic import archive, plausibility
from roughcontact.elastoplastic.plastic_flow import yield_strain
from roughcontact.elastoplastic.solve import TOLERANCE, solve_elastoplastic
from roughcontact.elastoplastic.volume_result import ElastoplasticResult, PathPoint, PlasticBody
from roughcontact.errors import InputError, input_error, require_count
from roughcontact.formats.vtk import save_vtk, save_vtr
from roughcontact.halfspace import tensors
from roughcontact.material.hardening import Perfect
from roughcontact.material.material import RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.progress import Progress, Tell
from roughcontact.surface.roughness import core_parameters, material_ratio_curve, rms_height
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, count_noun, to_si

Array = NDArray[Any]


def _empty_map() -> Array:
    return np.zeros((0, 0))


@dataclass(frozen=True)
class Pass:
    """Summary of one pass."""

    strain_added: float  # Largest added plastic strain: forward and backward strain add up
    strain_net: float  # Largest equivalent of the net plastic strain of the pass
    max_pressure: float  # Largest pressure during the pass [Pa]
    max_plastic_strain: float  # Largest accumulated plastic strain after the pass
    max_residual_stress: float  # Largest residual von Mises stress after the pass [Pa]
    max_residual_displacement: float  # [m]
    steps: int = 0  # Number of increments
    contact_area: float = 0.0  # Largest during the pass [m²]
    approach: float = 0.0  # Largest during the pass [m]
    Sq: float = 0.0  # Sq of the rough body after the pass [m]
    Spk: float = 0.0  # Spk of the rough body after the pass [m]
    shear: Array = field(default_factory=_empty_map, compare=False, repr=False)  # (bodies, nz)
    residual_along: Array = field(default_factory=_empty_map, compare=False, repr=False)
    residual_across: Array = field(default_factory=_empty_map, compare=False, repr=False)

    @property
    def largest_shear(self) -> float:
        """Value of ``shear`` with the largest magnitude."""
        return _largest(self.shear)

    @property
    def in_plane_stress(self) -> float:
        """Largest value by magnitude of both residual stresses [Pa]; tension is positive."""
        return _largest(np.concatenate([self.residual_along, self.residual_across]))


def pass_result(
    result: ElastoplasticResult, before: ElastoplasticResult | None, direction: float
) -> Pass:
    """Return the summary of the pass between two states."""
    flow = gain = 0.0
    shear: list[Array] = []
    for number, body in enumerate(result.bodies):
        old = None if before is None else before.bodies[number]
        flow = max(
            flow, float((body.accumulated - _resample_layers(old, body, "accumulated")).max())
        )
        strain = body.plastic_strain - _resample_layers(old, body, "plastic_strain")
        gain = max(gain, 2 / 3 * float(tensors.equivalent(strain.swapaxes(0, 1)).max()))
        # The sign makes shear positive if the layers above move in the direction.
        shear.append(_over_depth(result, -_shear(strain, direction)))
    along, across = (
        np.array([_over_depth(result, _normal(body, angle)) for body in result.bodies])
        for angle in (direction, direction + 90)
    )
    steps = result.increments[0 if before is None else len(before.increments) :]
    heights = rolled_surface(result).heights
    return Pass(
        strain_added=flow,
        strain_net=gain,
        max_pressure=max(step.max_pressure for step in steps),
        max_plastic_strain=result.max_plastic_strain,
        max_residual_stress=max(float(b.residual_von_mises.max()) for b in result.bodies),
        max_residual_displacement=float(result.residual_displacement.max()),
        steps=len(steps),
        contact_area=max(step.contact_area for step in steps),
        approach=max(step.approach for step in steps),
        Sq=rms_height(heights),
        Spk=core_parameters(*material_ratio_curve(heights))["Spk"],
        shear=np.array(shear),
        residual_along=along,
        residual_across=across,
    )


def rolled_surface(result: ElastoplasticResult) -> Surface:
    """Return the heights of the rough body after a path, without load."""
    return indent_body(result.solution.surface, result.residual_displacement)


@dataclass(frozen=True, eq=False)
class MovieFrame:
    """Fields of one step for a movie."""

    number: int  # Number of the pass
    step: int  # Number of the step in the pass
    pressure: Array  # (ny, nx) Contact pressure [Pa]
    strain: Array  # (nz, n) Largest accumulated plastic strain across the pass


def make_frame(result: ElastoplasticResult, number: int, step: int, along: str) -> MovieFrame:
    """Return the movie frame of a state, in single precision."""
    strain = result.bodies[0].accumulated[:, *result.map_window].max(axis=1 if along == "x" else 2)
    return MovieFrame(
        number, step, result.solution.pressure.astype(np.float32), strain.astype(np.float32)
    )


def _resample_layers(old: PlasticBody | None, new: PlasticBody, name: str) -> Array:
    """Return a field of an earlier state on the layers and points of the present one."""
    wide: Array = np.zeros_like(getattr(new, name))
    if old is not None:
        values = getattr(old, name)
        ny, nx = values.shape[-2:]
        top, left = ((n - m) // 2 for n, m in zip(wide.shape[-2:], (ny, nx), strict=True))
        wide[: len(values), ..., top : top + ny, left : left + nx] = values
    return wide


def _shear(strain: Array, direction: float) -> Array:
    """Return the shear strain γ between depth and a direction, shape (nz, ny, nx)."""
    angle = math.radians(direction)
    return 2 * (strain[:, 3] * math.cos(angle) + strain[:, 4] * math.sin(angle))


def _normal(body: PlasticBody, direction: float) -> Array:
    """Return the residual normal stress along a direction [Pa]."""
    angle, stress = math.radians(2 * direction), body.residual_stress
    mean: Array = body.mean_residual_stress - stress[:, 0] / 2
    return mean + stress[:, 1] * math.cos(angle) + stress[:, 2] * math.sin(angle)


def _over_depth(result: ElastoplasticResult, values: Array) -> Array:
    """Return one value per layer: the mean along periodic, the largest along free axes."""
    axes = tuple(1 + axis for axis in result.solution.boundary.periodic_axes)
    mean = values[:, *result.map_window].mean(axis=axes, keepdims=True, dtype=float)
    lines = mean.reshape(len(values), -1)
    return lines[np.arange(len(lines)), np.abs(lines).argmax(axis=1)]


def _largest(values: Array) -> float:
    return float(values.ravel()[np.abs(values).argmax()]) if values.size else 0.0


# Strain that a pass adds, over the yield strain σ_Y/(3μ), up to which it is treated as zero; and
# net over added strain of a pass up to which the strain is treated as alternating.
_NONE, _LEFT = 0.01, 0.02
# Relative change between passes up to which they are treated as equal.
_STEADY_TOLERANCE = 0.1


class Shakedown(StrEnum):
    """Outcome of repeated passes: shakedown or ratcheting."""

    ELASTIC = "elastic"
    ELASTIC_SHAKEDOWN = "elastic shakedown"
    PLASTIC_SHAKEDOWN = "plastic shakedown"
    RATCHETING = "ratcheting"
    NOT_SETTLED = "not settled"
    NOT_RESOLVED = "not resolved"


@dataclass(frozen=True, eq=False, repr=False)
class RollingResult(Result):
    """Result of repeated passes.

    Parameters
    ----------
    result : ElastoplasticResult
        The state at the end of the last pass.
    passes : tuple of Pass
        Summaries of the passes, in order.
    direction : float
        Travel direction of the counter-body on the first pass [degrees].
    reciprocating : bool
        Whether the travel direction alternates.
    folder : path, optional
        Folder of the saved states.
    step : float
        Distance between the positions of a pass [m]; 0 if not known.
    axis : float, optional
        Direction of the axis of a nominal cylinder that passes [degrees].
    requested : int
        Number of requested passes; passes end with one that adds no plastic strain.
    """

    result: ElastoplasticResult
    passes: tuple[Pass, ...]
    direction: float = 0.0
    reciprocating: bool = False
    folder: Path | None = None
    step: float = 0.0
    axis: float | None = None
    requested: int = 0

    @property
    def shakedown(self) -> Shakedown:
        """Response to repeated passes.

        Elastic shakedown if the last pass adds less than 1 % of the yield strain σ_Y/(3μ). Plastic
        shakedown if the last pass adds the same strain as the pass before, to 10 %, and the net
        strain is less than 2 % of it or 1 % of the yield strain; ratcheting if the net strain is
        larger, and the same as that of the pass before. Not resolved if the steps of a pass are
        longer than the half-width of the contact.
        """
        minimum = self.strain_threshold
        flows, gains = (
            [getattr(p, name) for p in self.passes] for name in ("strain_added", "strain_net")
        )
        if not any(flows):
            return Shakedown.ELASTIC
        if plausibility.too_long(self.result, self.step, self.direction):
            return Shakedown.NOT_RESOLVED
        if flows[-1] <= minimum:
            return Shakedown.ELASTIC_SHAKEDOWN
        if not _is_steady(flows):
            return Shakedown.NOT_SETTLED
        if gains[-1] <= max(minimum, _LEFT * flows[-1]):
            return Shakedown.PLASTIC_SHAKEDOWN
        return Shakedown.RATCHETING if _is_steady(gains) else Shakedown.NOT_SETTLED

    @property
    def settled_after(self) -> int | None:
        """Number of passes after which none adds plastic strain.

        ``None`` if the last one does, or the steps are too long.
        """
        if self.shakedown is Shakedown.NOT_RESOLVED:
            return None
        minimum = self.strain_threshold
        quiet = 0
        while quiet < len(self.passes) and self.passes[-1 - quiet].strain_added <= minimum:
            quiet += 1
        return len(self.passes) - quiet if quiet else None

    @property
    def strain_threshold(self) -> float:
        """Plastic strain of a pass up to which it is treated as zero."""
        return _NONE * min(yield_strain(body.material) for body in self.result.bodies)

    @property
    def outcome_text(self) -> str:
        """The ``shakedown`` as text, with the number of passes or the strain per pass."""
        kind = self.shakedown
        if kind is Shakedown.ELASTIC_SHAKEDOWN:
            return f"shaken down after {count_noun(self.settled_after or 0, 'pass')}"
        if kind is Shakedown.RATCHETING:
            return f"ratchets by a plastic strain of {self.passes[-1].strain_net:.2g} a pass"
        if kind is Shakedown.NOT_SETTLED:
            return f"not settled after {len(self.passes)}: use more passes"
        if kind is Shakedown.NOT_RESOLVED:
            return "not evaluated: the steps are longer than the contact half-width"
        return str(kind)

    @property
    def converged(self) -> bool:
        """Whether the last pass converged to its end."""
        return self.result.converged

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the passes, the most severe first."""
        own = plausibility.rolling_cautions(
            self.result, self.step, self.passes[-1].steps, self.direction, self.axis
        )
        return sort_cautions([*own, *self.result.cautions])

    @property
    def rolled_surface(self) -> Surface:
        """Heights of the rough body after the passes."""
        return rolled_surface(self.result)

    def states(self) -> Iterator[tuple[int, int, ElastoplasticResult]]:
        """Yield number of the pass, number of the step and state of each complete saved step.

        These are the last steps of the passes, or all steps if ``on_step`` of `roll` was given.

        Raises
        ------
        InputError
            If there is no folder of saved states.
        """
        if self.folder is None:
            raise InputError(
                "is needed: the steps of the passes are saved there", argument="folder"
            )
        for number in range(1, len(self.passes) + 1):
            files = sorted(_pass_folder(self.folder, number).glob("step-*.nc"))
            for file in files:
                yield number, int(file.stem[5:]), archive.load_elastoplastic(file)


@validate_arguments
def roll(
    surface: Surface,
    *,
    counter_surface: CounterSurface,
    material: Material,
    load: Quantity,
    passes: int,
    steps: int = 32,
    travel: Quantity | None = None,
    direction: float = 0.0,
    reciprocating: bool = False,
    start_at_center: bool = False,
    friction: float = 0.0,
    counter_material: Material = RIGID,
    boundary: str = "free",
    depth: Quantity | None = None,
    layers: Quantities | ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = 150,
    precision: str = "single",
    folder: str | os.PathLike[str] | None = None,
    progress: Tell = None,
    on_step: Callable[[int, int, ElastoplasticResult], object] | None = None,
) -> RollingResult:
    """Move a counter-body repeatedly over a body; both may yield.

    Parameters
    ----------
    surface, boundary, depth, layers, tolerance, max_iterations, precision, progress
        As for `roughcontact.solve_elastoplastic`.
    material, counter_material : Material
        A body without a hardening law is perfectly plastic, independent of its hardness.
    counter_surface : Surface or nominal body
        Heights of the counter-body at the start of a pass, or a nominal body.
    load : float, str or quantity of pint
        Normal load during the whole pass [N].
    passes : int
        Maximum number of passes; forward and backward are two passes. Passes end with the first
        that adds no plastic strain, or with the second in a row if reciprocating.
    steps : int
        Number of steps of a pass.
    travel : float, str or quantity of pint
        Length of a pass [m]; by default one period of the map along ``direction``.
    direction : float
        Travel direction of the counter-body [degrees], counterclockwise from x as seen in the
        map.
    reciprocating : bool
        Whether the travel direction alternates, instead of each pass starting again.
    start_at_center : bool
        Whether the counter-surface starts at the center of the travel, instead of its start.
    friction : float
        Coefficient μ of full sliding; the traction on the rough body points in the travel
        direction.
    folder : path, optional
        Folder for the state after every step, one folder per pass; the same call resumes from
        there with identical results.
    on_step : callable, optional
        ``on_step(number, step, state)`` is called after each step of each pass, and for the
        complete states of an earlier run. The folder then keeps every state complete.

    Returns
    -------
    RollingResult
        The last state, and a summary of each pass.

    Raises
    ------
    InputError
        If an argument cannot be used, or ``travel`` is missing on a map that is not periodic along
        the direction.
    ConvergenceError, CapacityError, InsufficientMemoryError, FormatError
        As for `roughcontact.solve_elastoplastic`.

    References
    ----------
    Johnson, Contact Mechanics (1985), sections 9.2 and 9.3; Boucly, Nélias and Green, J. Tribol.
    129 (2007) 235

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> flat = rc.Surface(np.zeros((8, 24)), pixel=(1e-6, 1e-6))
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> rolled = roll(
    ...     flat, counter_surface=rc.cylinder("0.5 mm", angle=90), material=steel, load=0.02,
    ...     passes=1, steps=4, boundary="periodic",
    ... )
    >>> rolled.outcome_text
    'elastic'
    """
    require_count(1, memory.STEPS, passes=passes, steps=steps)
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    length, tell = _pass_length(travel, pair, direction), _label_steps(progress, passes, steps)
    stops, force = _step_positions(length, steps, start_at_center), to_si(load, "force", "load")
    ways = _pass_paths(_pass(force, stops, direction, friction), passes, direction, reciprocating)
    solved = partial(
        solve_elastoplastic,
        surface,
        counter_surface=pair.counter_surface,
        boundary=boundary,
        material=_perfectly_plastic(material),
        counter_material=_perfectly_plastic(counter_material),
        tolerance=tolerance,
        max_iterations=max_iterations,
        precision=precision,
    )
    result, done = _run_passes(
        solved, {"depth": depth, "layers": layers}, ways, folder, tell, on_step
    )
    return RollingResult(
        result,
        done,
        float(direction),
        reciprocating,
        None if folder is None else Path(folder),
        length / steps,
        plausibility.cylinder_axis(pair.origins[-1]),
        passes,
    )


def _perfectly_plastic(body: Material) -> Material:
    """Return a body with perfect plasticity unless a law was given.

    The default hardening would lead to shakedown.
    """
    if body.yield_strength is None or body.hardening is not None:
        return body
    return replace(body, hardening=Perfect(body.yield_strength))


def _pass_paths(
    there: list[PathPoint], passes: int, direction: float, reciprocating: bool
) -> list[list[PathPoint]]:
    """Return the points of all passes; every second one is reversed if reciprocating."""
    both = there, [replace(point, direction=direction + 180) for point in reversed(there)]
    return [both[n % 2 * reciprocating] for n in range(passes)]


def _run_passes(
    solved: Callable[..., ElastoplasticResult],
    volume: Mapping[str, Any],
    ways: Sequence[Sequence[PathPoint]],
    folder: str | os.PathLike[str] | None,
    tell: Callable[[int], Tell],
    each: Callable[[int, int, ElastoplasticResult], object] | None,
) -> tuple[ElastoplasticResult, tuple[Pass, ...]]:
    """Solve the passes one after the other; only the first needs the volume arguments."""
    result: ElastoplasticResult | None = None
    done: list[Pass] = []
    alike = len({path[0].direction for path in ways})
    seconds = 0.0
    for number, path in enumerate(ways, 1):
        before = result
        result = solved(
            path=path,
            start=before,
            folder=None if folder is None else _pass_folder(folder, number),
            progress=tell(number),
            on_step=None if each is None else partial(each, number),
            **({} if before else volume),
        )
        seconds += result.seconds
        done.append(pass_result(result, before, ways[0][0].direction))
        # If reciprocating, the backward pass may yield although the forward pass does not.
        if not any(item.strain_added for item in done[-alike:]) and len(done) >= alike:
            break
    assert result is not None
    return replace(result, seconds=seconds), tuple(done)


def _label_steps(progress: Tell, count: int, steps: int) -> Callable[[int], Tell]:
    """Return a factory of the progress callback of a pass."""

    def report_step(number: int, state: Progress) -> None:
        assert callable(progress)
        done, label = (number - 1) * steps, f"pass {number} of {count}"
        progress(replace(state, number=done + state.number, count=count * steps, label=label))

    return lambda number: partial(report_step, number) if callable(progress) else progress


def _pass_folder(folder: str | os.PathLike[str], number: int) -> Path:
    """Return the folder of the steps of a pass."""
    return Path(folder, f"pass-{number:04d}")


def _pass_length(travel: Quantity | None, pair: Pair, direction: float) -> float:
    """Return the length of a pass [m]."""
    if travel is not None:
        length: float = to_si(travel, "length", "travel")
        if not 0 < length < math.inf:
            raise input_error("travel", length, "must be positive and finite [m]")
        return length
    axis = {0.0: 1, 90.0: 0}.get(round(direction % 180, 9))
    if axis is None or axis not in pair.boundary.periodic_axes:
        raise InputError(
            "is needed where the map is not periodic along the direction: give the length of a "
            "pass [m]",
            argument="travel",
        )
    return pair.size[axis]


def _step_positions(length: float, steps: int, centered: bool) -> list[float]:
    """Return the positions of a pass [m]; a centered pass has half a step at both ends."""
    first = (0.5 / steps - 0.5) * centered
    return [length * (step / steps + first) for step in range(steps)]


def _pass(
    load: float, stops: Sequence[float], direction: float, friction: float
) -> list[PathPoint]:
    # `PathPoint` rejects values that are not finite.
    start = PathPoint(load, (0.0, 0.0), friction, direction)
    angle = math.radians(direction)
    y, x = round(math.sin(angle), 15), round(math.cos(angle), 15)
    return [replace(start, offset=(y * stop, x * stop)) for stop in stops]


def _is_steady(values: list[float]) -> bool:
    return len(values) > 1 and abs(values[-1] - values[-2]) <= _STEADY_TOLERANCE * values[-1]


@validate_arguments
def shakedown_load(
    surface: Surface,
    *,
    low: Quantity,
    high: Quantity,
    rel_tol: float = 0.03,
    passes: int = 6,
    **options: Any,
) -> tuple[float, float]:
    """Return a bracket of the elastic shakedown limit.

    Parameters
    ----------
    surface : Surface
        Heights of the rough body.
    low, high : float, str or quantity of pint
        Loads [N] between which the limit is searched.
    rel_tol : float
        Relative width of the bracket at which the search ends.
    passes : int
        Number of passes of each trial.
    **options
        Further arguments of `roll`.

    Returns
    -------
    (float, float)
        Loads [N]: under the first the passes shake down or stay elastic, under the second not.

    Raises
    ------
    InputError
        If an argument cannot be used, the limit is not between the loads, or the steps of a pass
        are longer than the half-width of the contact.
    """
    ends = [float(to_si(end, "force", name)) for end, name in ((low, "low"), (high, "high"))]
    if not 0 < ends[0] < ends[1] < math.inf:
        raise InputError(f"must be positive and below high, got {ends}", argument="low", value=low)
    if not rel_tol > 0:
        raise input_error("rel_tol", rel_tol, "must be positive")

    def shakes(load: float) -> bool:
        rolled = roll(surface, load=load, passes=passes, **options)
        if rolled.shakedown is Shakedown.NOT_RESOLVED:
            raise InputError(
                f"must be larger: at {load:.4g} N the steps are longer than the contact half-width",
                argument="steps",
            )
        return rolled.shakedown in (Shakedown.ELASTIC, Shakedown.ELASTIC_SHAKEDOWN)

    for end, expected, name in zip(ends, (True, False), ("low", "high"), strict=True):
        if shakes(end) is not expected:
            raise InputError(
                f"= {end:.4g} N {'does not shake' if expected else 'still shakes'} down in "
                f"{passes} passes: give a {'smaller' if expected else 'larger'} load",
                argument=name,
            )
    while ends[1] - ends[0] > rel_tol * (ends[0] + ends[1]) / 2:
        middle = math.sqrt(ends[0] * ends[1])
        ends[0 if shakes(middle) else 1] = middle
    return ends[0], ends[1]


_NUMBERS = {
    "strain_added": ("1", "largest plastic strain added by the pass, forward and backward"),
    "strain_net": ("1", "largest net plastic strain of the pass"),
    "max_pressure": ("Pa", "largest contact pressure during the pass"),
    "max_plastic_strain": ("1", "largest accumulated plastic strain after the pass"),
    "max_residual_stress": ("Pa", "largest von Mises stress by the plastic strain alone"),
    "max_residual_displacement": ("m", "deepest residual displacement"),
    "steps": ("1", "increments"),
    "contact_area": ("m2", "largest contact area during the pass"),
    "approach": ("m", "largest approach during the pass"),
    "Sq": ("m", "root-mean-square height of the rough body after the pass"),
    "Spk": ("m", "reduced peak height of the rough body after the pass"),
}
# Names in files since version 0.2.
_STORED = {"strain_added": "flow", "strain_net": "gain"}
_PROFILES = {
    "shear": ("1", "shear strain added by the pass, along the first pass"),
    "residual_along": ("Pa", "normal stress by the plastic strain alone, along the pass"),
    "residual_across": ("Pa", "normal stress by the plastic strain alone, across the pass"),
}


def save_rolling(rolling: RollingResult, path: str | os.PathLike[str]) -> None:
    """Write passes and their last state to a NetCDF file; `load_rolling` reads it."""
    dataset, packed = to_dataset(rolling)
    netcdf.write(dataset, path, packed)


def save_pvd(rolling: RollingResult, path: str | os.PathLike[str]) -> None:
    """Write all saved steps of repeated passes as a series for ParaView.

    A step is one second of ParaView's time; the volume is part 0 of the series, the surface part 1.
    """
    require_suffix(path, ".pvd")
    folder = Path(path).with_suffix("")
    lines = []
    for time, (_, _, state) in enumerate(rolling.states(), 1):
        folder.mkdir(exist_ok=True)
        for part, (suffix, save) in enumerate(((".vtr", save_vtr), (".vti", save_vtk))):
            name = f"step-{time:04d}{suffix}"
            save(state, folder / name)
            place = quoteattr(f"{folder.name}/{name}")
            lines.append(f'    <DataSet timestep="{time}" part="{part}" file={place}/>\n')
    write_atomically(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        f"{''.join(lines)}  </Collection>\n</VTKFile>\n",
    )


def to_dataset(rolling: RollingResult) -> tuple[netcdf.Dataset, dict[str, Any]]:
    """Return passes and their last state as a dataset, and the packing of its variables."""
    dataset, packed = archive.to_dataset(rolling.result)
    for name, (unit, text) in _NUMBERS.items():
        values = np.array([getattr(item, name) for item in rolling.passes])
        dataset.add(f"pass_{_STORED.get(name, name)}", "pass", values, unit, text)
    layers = rolling.result.bodies[0].thickness.size
    for name, (unit, text) in _PROFILES.items():
        # The volume may become deeper during the passes.
        profiles = np.zeros((len(rolling.passes), len(rolling.result.bodies), layers))
        for number, item in enumerate(rolling.passes):
            values = getattr(item, name)
            profiles[number, :, : values.shape[1]] = values
        axes = ("pass", "yielding_body", "layer")
        dataset.add(f"pass_{name}", axes, profiles, unit, f"{text}, layer by layer")
    dataset.attrs |= {
        "rolling_direction": rolling.direction,
        "rolling_to_and_fro": int(rolling.reciprocating),
        "rolling_step": rolling.step,
        "rolling_requested": rolling.requested,
    }
    if rolling.axis is not None:
        dataset.attrs["rolling_axis"] = rolling.axis
    return dataset, packed


def load_rolling(
    path: str | os.PathLike[str], dataset: netcdf.Dataset | None = None
) -> RollingResult:
    """Read passes that ``RollingResult.save`` wrote."""
    dataset = contact_archive.open_archive(path) if dataset is None else dataset
    with contact_archive.as_format_error(Path(path), "Rolling"):
        columns = {
            name: dataset[f"pass_{_STORED.get(name, name)}"].values.tolist() for name in _NUMBERS
        }
        columns |= {name: list(np.array(dataset[f"pass_{name}"].values)) for name in _PROFILES}
        rows = zip(*columns.values(), strict=True)
        passes = tuple(Pass(**dict(zip(columns, row, strict=True))) for row in rows)
        result, axis = archive.from_dataset(dataset), dataset.attrs.get("rolling_axis")
        # In a resumed run, increments of earlier passes come first.
        if not 0 < sum(columns["steps"]) <= len(result.increments):
            raise InputError("must be those of the increments", argument="steps")
        return RollingResult(
            result=result,
            passes=passes,
            direction=float(dataset.attrs["rolling_direction"]),
            reciprocating=bool(dataset.attrs["rolling_to_and_fro"]),
            # Earlier versions did not write these attributes.
            requested=int(dataset.attrs.get("rolling_requested", 0)),
            step=float(dataset.attrs.get("rolling_step", 0.0)),
            axis=None if axis is None else float(axis),
        )
