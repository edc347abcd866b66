"""Repeated passes of a counter-body over bodies that yield, and whether they shake down."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from roughcontact import limits
from roughcontact.arguments import checked
from roughcontact.contact.cautions import Caution, ordered
from roughcontact.errors import InputError, require_count
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.hardening import Perfect
from roughcontact.material.material import RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.progress import Progress, Tell
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, quantity
from roughcontact.volume import archive, passes as passes_of, rolling_judgment
from roughcontact.volume.passes import Pass as Pass
from roughcontact.volume.path import PathPoint
from roughcontact.volume.plastic_body import PlasticBody
from roughcontact.volume.result import ElastoplasticResult
from roughcontact.volume.solve import TOLERANCE, solve_elastoplastic

# Strain that a pass adds, over the yield strain σ_Y/3μ, up to which it counts as none; and what is
# left of it after the pass, over it, up to which it has gone to and fro.
_NONE, _LEFT = 0.01, 0.02
# Change from one pass to the next up to which they count as alike.
_ALIKE = 0.1


class Shakedown(StrEnum):
    """What repeated passes come to."""

    ELASTIC = "elastic"
    SHAKEN_DOWN = "shaken down"
    ALTERNATING = "alternating"
    RATCHETTING = "ratchetting"
    UNSETTLED = "not settled"
    UNRESOLVED = "not resolved"


@dataclass(frozen=True, eq=False, repr=False)
class Rolling(Result):
    """Bodies after repeated passes.

    Parameters
    ----------
    result : ElastoplasticResult
        The state at the end of the last pass.
    passes : tuple of Pass
        One after the other.
    direction : float
        Where the counter-body moved on the first of them [degrees].
    to_and_fro : bool
        Whether every other pass went back.
    folder : path, optional
        Where the state after every step is kept.
    step : float
        Distance between the places of a pass [m]; 0 where it is not known.
    axis : float, optional
        Where the axis of a nominal cylinder lies that passes [degrees].
    requested : int
        How many passes were requested; they end with one that adds no plastic strain.
    """

    result: ElastoplasticResult
    passes: tuple[Pass, ...]
    direction: float = 0.0
    to_and_fro: bool = False
    folder: Path | None = None
    step: float = 0.0
    axis: float | None = None
    requested: int = 0

    @property
    def shakedown(self) -> Shakedown:
        """What the passes have come to.

        Shaken down where the last pass adds less than 1 % of the yield strain σ_Y/3μ. Alternating
        where it adds as much as that before, to 10 %, and less than 2 % of that is left, or 1 % of
        the yield strain; ratchetting where more is left, and as much as of that before. Not
        resolved where the steps of a pass are longer than the half-width of the contact.
        """
        least = self.least_strain
        flows, gains = ([getattr(p, name) for p in self.passes] for name in ("flow", "gain"))
        if not any(flows):
            return Shakedown.ELASTIC
        if rolling_judgment.too_long(self.result, self.step, self.direction):
            return Shakedown.UNRESOLVED
        if flows[-1] <= least:
            return Shakedown.SHAKEN_DOWN
        if not _alike(flows):
            return Shakedown.UNSETTLED
        if gains[-1] <= max(least, _LEFT * flows[-1]):
            return Shakedown.ALTERNATING
        return Shakedown.RATCHETTING if _alike(gains) else Shakedown.UNSETTLED

    @property
    def settled_after(self) -> int | None:
        """Number of passes after which none adds plastic strain.

        ``None`` if the last one does, or the steps are too long to tell.
        """
        if self.shakedown is Shakedown.UNRESOLVED:
            return None
        least = self.least_strain
        quiet = 0
        while quiet < len(self.passes) and self.passes[-1 - quiet].flow <= least:
            quiet += 1
        return len(self.passes) - quiet if quiet else None

    @property
    def least_strain(self) -> float:
        """Plastic strain that a pass adds up to which it counts as none."""
        return _NONE * min(map(_yield_strain, self.result.whole_bodies))

    @property
    def answer(self) -> str:
        """The ``shakedown`` in words, with its number."""
        kind = self.shakedown
        if kind is Shakedown.SHAKEN_DOWN:
            count = self.settled_after
            return f"shaken down after {count} {'pass' if count == 1 else 'passes'}"
        if kind is Shakedown.RATCHETTING:
            return f"ratchets by a plastic strain of {self.passes[-1].gain:.2g} a pass"
        if kind is Shakedown.UNSETTLED:
            return f"not settled after {len(self.passes)}: ask for more passes"
        if kind is Shakedown.UNRESOLVED:
            return "not told: the steps are longer than the half-width of the contact"
        return str(kind)

    @property
    def converged(self) -> bool:
        """Whether the last pass was followed to its end."""
        return self.result.converged

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        own = rolling_judgment.cautions(
            self.result, self.step, self.passes[-1].steps, self.direction, self.axis
        )
        return ordered([*own, *self.result.cautions])

    @property
    def rolled_surface(self) -> Surface:
        """Heights of the rough body after the passes; see `passes.rolled_surface`."""
        return passes_of.rolled_surface(self.result)

    def states(self) -> Iterator[tuple[int, int, ElastoplasticResult]]:
        """Yield number of the pass, number of the step and state of each step that is kept whole.

        Those are the last ones of passes, and all of them where ``each`` of `roll` was given.

        Raises
        ------
        InputError
            If nothing is kept.
        """
        if self.folder is None:
            raise InputError("is needed: the steps of the passes are kept there", argument="folder")
        for number in range(1, len(self.passes) + 1):
            files = sorted(_place(self.folder, number).glob("step-*.nc"))
            for file in files:
                yield number, int(file.stem[5:]), archive.load_elastoplastic(file)


@checked
def roll(
    surface: Surface,
    *,
    counter_surface: Surface,
    material: Material,
    load: Quantity,
    passes: int,
    steps: int = 32,
    way: Quantity | None = None,
    direction: float = 0.0,
    to_and_fro: bool = False,
    centered: bool = False,
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
    each: Callable[[int, int, ElastoplasticResult], object] | None = None,
) -> Rolling:
    """Pass a counter-body over a body again and again, both of which may yield.

    Parameters
    ----------
    surface, boundary, depth, layers, tolerance, max_iterations, precision, progress
        As for `roughcontact.solve_elastoplastic`.
    material, counter_material : Material
        A body without a law of hardening is perfectly plastic, whatever its hardness.
    counter_surface : Surface
        Heights of the counter-body at the start of a pass.
    load : float, str or quantity of pint
        Normal load on the whole way [N].
    passes : int
        How many; there and back are two. The last is the first that adds no plastic strain at
        all, of those to and fro the second in a row: all further ones would add none.
    steps : int
        Steps of a pass.
    way : float, str or quantity of pint
        Length of a pass [m]; by default the period of the map along ``direction``, round and round.
    direction : float
        Where the counter-body moves [degrees], counter-clockwise from x as seen in the map.
    to_and_fro : bool
        Whether every other pass goes back, instead of beginning anew at the start.
    centered : bool
        Whether the way lies half before and half behind the place of the counter-surface, in place
        of all of it before.
    friction : float
        Coefficient μ of full sliding; the traction on the rough body points to where the
        counter-body moves.
    folder : path, optional
        Where the state after every step is kept, in one folder a pass; the same call goes on from
        there and ends with the same numbers.
    each : callable, optional
        ``each(number, step, state)`` is called after each step of each pass, with those that stand
        whole in the folder, too. The folder then keeps all of them whole.

    Returns
    -------
    Rolling
        The last state, and what each pass did.

    Raises
    ------
    InputError
        If an argument cannot be used, or no way is given on a map that ends along the direction.
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
    >>> from roughcontact.surface import nominal
    >>> grid = dict(shape=(8, 24), pixel=(1e-6, 1e-6))
    >>> roller = nominal.cylinder(radius=500e-6, angle=90.0, **grid)
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> rolled = roll(
    ...     nominal.flat(**grid), counter_surface=roller, material=steel, load=0.02, passes=1,
    ...     steps=4, boundary="periodic",
    ... )
    >>> rolled.answer
    'elastic'
    """
    require_count(1, limits.STEPS, passes=passes, steps=steps)
    length = _length(quantity(way, "length", "way"), surface, Boundary(boundary), direction)
    stops, force = _stops(length, steps, centered), quantity(load, "force", "load")
    ways = _ways(_pass(force, stops, direction, friction), passes, direction, to_and_fro)
    solved = partial(
        solve_elastoplastic, surface, counter_surface=counter_surface, material=_flows(material),
        counter_material=_flows(counter_material), boundary=boundary, tolerance=tolerance,
        max_iterations=max_iterations, precision=precision,
    )  # fmt: skip
    tell = _labelled(progress, passes, steps)
    result, done = _rolled(solved, {"depth": depth, "layers": layers}, ways, folder, tell, each)
    return Rolling(
        result, done, float(direction), to_and_fro, None if folder is None else Path(folder),
        length / steps, rolling_judgment.axis_of(counter_surface), passes,
    )  # fmt: skip


def _flows(body: Material) -> Material:
    """Return a body that does not harden unless a law was given: one that hardens shakes down."""
    if body.yield_strength is None or body.hardening is not None:
        return body
    return replace(body, hardening=Perfect(body.yield_strength))


def _ways(
    there: list[PathPoint], passes: int, direction: float, to_and_fro: bool
) -> list[list[PathPoint]]:
    """Return the points of all passes, of which every other may go back."""
    both = there, [replace(point, direction=direction + 180) for point in reversed(there)]
    return [both[n % 2 * to_and_fro] for n in range(passes)]


def _rolled(
    solved: Callable[..., ElastoplasticResult],
    volume: Mapping[str, Any],
    ways: Sequence[Sequence[PathPoint]],
    folder: str | os.PathLike[str] | None,
    tell: Callable[[int], Tell],
    each: Callable[[int, int, ElastoplasticResult], object] | None,
) -> tuple[ElastoplasticResult, tuple[Pass, ...]]:
    """Go the passes one after the other; the first needs to know its volume."""
    result: ElastoplasticResult | None = None
    done: list[Pass] = []
    alike = len({path[0].direction for path in ways})
    seconds = 0.0
    for number, path in enumerate(ways, 1):
        before = result
        result = solved(
            path=path,
            start=before,
            folder=None if folder is None else _place(folder, number),
            progress=tell(number),
            each=None if each is None else partial(each, number),
            **({} if before else volume),
        )
        seconds += result.seconds
        done.append(passes_of.told(result, before, ways[0][0].direction))
        # Of those to and fro the way back may flow where the way there does not.
        if not any(one.flow for one in done[-alike:]) and len(done) >= alike:
            break
    assert result is not None
    return replace(result, seconds=seconds), tuple(done)


def _labelled(progress: Tell, count: int, steps: int) -> Callable[[int], Tell]:
    """Return what gives, by the number of a pass, what is told of its steps."""

    def told(number: int, at: Progress) -> None:
        assert callable(progress)
        done, label = (number - 1) * steps, f"pass {number} of {count}"
        progress(replace(at, number=done + at.number, count=count * steps, label=label))

    return lambda number: partial(told, number) if callable(progress) else progress


def _place(folder: str | os.PathLike[str], number: int) -> Path:
    """Return where the steps of a pass are kept."""
    return Path(folder, f"pass-{number:04d}")


def _length(way: float | None, surface: Surface, boundary: Boundary, direction: float) -> float:
    """Return the length of a pass [m]."""
    if way is not None:
        if not 0 < way < math.inf:
            raise InputError(
                f"must be positive and finite [m], got {way!r}", argument="way", value=way
            )
        return way
    axis = {0.0: 1, 90.0: 0}.get(round(direction % 180, 9))
    if axis is None or axis not in boundary.periodic_axes:
        raise InputError(
            "is needed where the map is not periodic along the direction: give the length of a "
            "pass [m]",
            argument="way",
        )
    return surface.size[axis]


def _stops(length: float, steps: int, centered: bool) -> list[float]:
    """Return the places of a pass [m]; half a step lies before and behind a way with two ends."""
    first = (0.5 / steps - 0.5) * centered
    return [length * (step / steps + first) for step in range(steps)]


def _pass(
    load: float, stops: Sequence[float], direction: float, friction: float
) -> list[PathPoint]:
    # It refuses what is not finite.
    start = PathPoint(load, (0.0, 0.0), friction, direction)
    angle = math.radians(direction)
    y, x = round(math.sin(angle), 15), round(math.cos(angle), 15)
    return [replace(start, offset=(y * stop, x * stop)) for stop in stops]


def _alike(values: list[float]) -> bool:
    return len(values) > 1 and abs(values[-1] - values[-2]) <= _ALIKE * values[-1]


def _yield_strain(body: PlasticBody) -> float:
    modulus = body.material.young / (2 * (1 + body.material.poisson))
    return body.material.law.initial / (3 * modulus)


@checked
def shakedown_load(
    surface: Surface,
    *,
    low: Quantity,
    high: Quantity,
    within: float = 0.03,
    passes: int = 6,
    **options: Any,
) -> tuple[float, float]:
    """Return a bracket of the largest load that repeated passes shake down under.

    Parameters
    ----------
    surface : Surface
        Heights of the rough body.
    low, high : float, str or quantity of pint
        Loads [N] between which the limit is sought.
    within : float
        Width of the bracket over its middle at which the search ends.
    passes : int
        Of each trial.
    **options
        What else `roll` takes.

    Returns
    -------
    (float, float)
        Loads [N]: the passes shake down under the first, or stay elastic, and not under the second.

    Raises
    ------
    InputError
        If an argument cannot be used, the limit is not between the loads, or the steps of a pass
        are longer than the half-width of the contact.
    """
    ends = [float(quantity(end, "force", name)) for end, name in ((low, "low"), (high, "high"))]
    if not 0 < ends[0] < ends[1] < math.inf:
        raise InputError(f"must be positive and below high, got {ends}", argument="low", value=low)
    if not within > 0:
        raise InputError(f"must be positive, got {within!r}", argument="within", value=within)

    def shakes(load: float) -> bool:
        rolled = roll(surface, load=load, passes=passes, **options)
        if rolled.shakedown is Shakedown.UNRESOLVED:
            raise InputError(
                f"must be more: at {load:.4g} N they are longer than the half-width of the contact",
                argument="steps",
            )
        return rolled.shakedown in (Shakedown.ELASTIC, Shakedown.SHAKEN_DOWN)

    for end, expected, name in zip(ends, (True, False), ("low", "high"), strict=True):
        if shakes(end) is not expected:
            raise InputError(
                f"= {end:.4g} N {'does not shake' if expected else 'still shakes'} down in "
                f"{passes} passes: give a {'smaller' if expected else 'larger'} load",
                argument=name,
            )
    while ends[1] - ends[0] > within * (ends[0] + ends[1]) / 2:
        middle = math.sqrt(ends[0] * ends[1])
        ends[0 if shakes(middle) else 1] = middle
    return ends[0], ends[1]
