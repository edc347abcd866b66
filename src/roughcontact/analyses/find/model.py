"""Inverse problems: the load at which a contact has a requested value."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.roots import ACCURACY, NotPassedError, Point, bracket_crossing
from roughcontact.cautions import Caution, sort_cautions
from roughcontact.contact.ceiling import is_bracket, resolve_ceiling
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.plausibility import over_loads
from roughcontact.contact.result import BASE, COATING, ContactResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.validation import check_holes, check_problem, touchable_gap
from roughcontact.errors import ArgumentRef, InputError, input_error
from roughcontact.halfspace import stress_summary
from roughcontact.halfspace.gpu import runs_on_device
from roughcontact.material.material import RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.progress import Step, Tell, progress_callback, shows_progress_bar
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface
from roughcontact.units import (
    Quantities,
    Quantity,
    format_engineering,
    format_percent,
    shares,
    to_si,
)

CONTACT, SATURATED = "contact_fraction", "saturated_share"
APPROACH, GAP, YIELD = "approach", "mean_gap", "first_yield"
"""Quantities that can be requested."""

COUNTED = (CONTACT, SATURATED)
"""Quantities that count whole pixels: piecewise constant, so that they cross a value."""


@dataclass(frozen=True)
class Side:
    """A solved load next to the requested value."""

    load: float  # W [N]
    value: float  # Quantity at the load [SI]


@dataclass(frozen=True, eq=False)
class LoadAnswer:
    """Load at which one quantity has a requested value."""

    quantity: str
    target: float
    value: float
    bracket_low: Side
    bracket_high: Side
    result: ContactResult

    @property
    def load(self) -> float:
        """Load [N]: one end of the bracket, at which the quantity was computed."""
        return self.result.load

    @property
    def bracket(self) -> tuple[float, float]:
        """Neighboring loads between which the quantity crosses the value [N]."""
        return self.bracket_low.load, self.bracket_high.load

    @property
    def error(self) -> float:
        """Relative difference of value and target."""
        return self.value / self.target - 1

    @property
    def certificate(self) -> float:
        """Certificate ε of the contact under this load."""
        return self.result.certificate


@dataclass(frozen=True, eq=False, repr=False)
class LoadSearch(Result):
    """Loads for the requested values.

    Parameters
    ----------
    answers : tuple of LoadAnswer
        Loads in the order of the targets.
    solves : int
        Number of contacts that were solved for all targets.
    convolutions : int
        Number of convolutions of these contacts, on the full grid.
    seconds : float
        Wall time.
    extra_cautions : tuple of Caution
        Remarks on the measurement of the maps.
    base : LoadSearch, optional
        The same targets under the ceiling of the base of a coated body, if both were requested.
    """

    answers: tuple[LoadAnswer, ...]
    solves: int
    convolutions: int
    seconds: float
    extra_cautions: tuple[Caution, ...] = ()
    base: LoadSearch | None = None

    @property
    def largest(self) -> ContactResult:
        """The contact under the largest of the loads."""
        return max(self.answers, key=lambda answer: answer.load).result

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the result, the most severe first."""
        ascending = sorted(self.answers, key=lambda answer: answer.load)
        judged = over_loads([(item.load, item.result.cautions) for item in ascending], "N")
        return sort_cautions([*judged, *self.extra_cautions])


SHARE_ACCURACY = 1e-3
"""Relative accuracy of a share, unless one pixel is more."""

MAX_HELD_RESULTS = 6
"""Maps in memory: pressure and gap at both bracket ends and of the previous answer."""

# Relative load difference up to which a solve starts from the pressure of another load; for larger
# differences the coarse grids of the solver give a better start.
_RESTART_TOLERANCE = 2e-3
# Margin around the contact in the search for the largest stress, in pixels.
_MARGIN = 8
# Smallest load over the load that flattens one pixel.
_MIN_LOAD_FRACTION = 1e-9

Target = tuple[str, float]

# Argument of a quantity, if it has another name.
_ARGUMENTS = {SATURATED: "saturated_fraction"}
_NAMES = {
    CONTACT: "the share of the map in contact",
    SATURATED: "the share of the contact at the ceiling",
    APPROACH: "the approach",
    GAP: "the mean gap",
    YIELD: "the largest stress over the yield strength",
}


@shows_progress_bar
@runs_on_device
@validate_arguments
def find_load(
    surface: Surface,
    *,
    material: Material,
    contact_fraction: float | str | Sequence[float] | None = None,
    saturated_fraction: float | str | Sequence[float] | None = None,
    approach: Quantity | Quantities | None = None,
    mean_gap: Quantity | Quantities | None = None,
    first_yield: bool = False,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    device: str | None = None,
    progress: Tell = None,
) -> LoadSearch:
    """Return the loads at which a contact has the requested values.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, ceiling, boundary, tolerance, \
max_iterations, device
        As for `solve`.
    contact_fraction : float, str or sequence of float, optional
        Share of the map in contact, between 0 and 1, or as ``"1 %, 5 %"``.
    saturated_fraction : float, str or sequence of float, optional
        Share of the contact area at the ceiling.
    approach, mean_gap : float, str, quantity of pint, or sequence of these, optional
        Approach of the bodies from the first touch, mean open gap [m].
    first_yield : bool
        Whether to find the load at which the first point of either body yields, at or below the
        surface; this contact is elastic, without a ceiling.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`: the number of the target and the `Step` of the solver.

    Returns
    -------
    LoadSearch
        Load of each target, in the order of the arguments, with its bracket and contact.

    Raises
    ------
    InputError
        If no target is given, an argument cannot be used, or no load gives the value; the message
        then gives the value at the last load.
    CapacityError, InsufficientMemoryError, ConvergenceError
        As for `solve`.

    Notes
    -----
    Approach and mean gap are met to 1e-6 of the value, at both ends of the bracket. Contact and
    saturation are counts of pixels and cross a value in steps: the bracket ends where its loads
    differ by one pixel, or by 1e-6, or where both are within 1e-3 of the value, and the answer is
    the smaller load at which the value is reached. The saturated share of the contact need not
    grow with the load; if it crosses the value several times, the answer is the crossing at the
    largest evaluated load.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(64)
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = rc.find_load(rc.Surface(heights, pixel), material=steel, mean_gap="0.5 um")
    >>> again = rc.solve(rc.Surface(heights, pixel), material=steel, load=found.answers[0].load)
    >>> print(f"{again.mean_gap * 1e6:.6f}")
    0.500000
    """
    targets = _targets(contact_fraction, saturated_fraction, approach, mean_gap, first_yield)
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    pair.require_map("a search of loads")
    terms = LoadCase(ceiling=ceiling, tolerance=tolerance, max_iterations=max_iterations)
    if not is_bracket(pair, ceiling):
        return _search(pair, terms, targets, progress)
    base = _search(pair, replace(terms, ceiling=BASE), targets, progress)
    return replace(_search(pair, replace(terms, ceiling=COATING), targets, progress), base=base)


def _search(pair: Pair, terms: LoadCase, targets: list[Target], progress: Tell) -> LoadSearch:
    """Return the loads of the targets under one ceiling."""
    began = time.perf_counter()
    finder, elastic = (_Finder(pair, t) for t in (terms, replace(terms, ceiling=None)))
    of = {target: elastic if target[0] == YIELD else finder for target in targets}
    for target in targets:
        of[target].check(target)
    answers = []
    for number, target in enumerate(targets, start=1):
        of[target].progress = progress_callback(progress, number, len(targets))
        answers.append(of[target].answer(target))
    return LoadSearch(
        tuple(answers),
        solves=finder.solves + elastic.solves,
        convolutions=finder.convolutions + elastic.convolutions,
        seconds=time.perf_counter() - began,
    )


@dataclass(eq=False)
class _Finder:
    """Contacts of two bodies at the evaluated loads, for all targets."""

    pair: Pair
    terms: LoadCase
    seen: dict[float, dict[str, float]] = field(default_factory=dict)
    """Values at each load, by its logarithm."""
    held: dict[float, ContactResult] = field(default_factory=dict)
    last: ContactResult | None = None
    progress: Callable[[Step], None] | None = None
    solves: int = 0
    convolutions: int = 0

    def check(self, target: Target) -> None:
        """Raise errors that can be detected before the first solve."""
        name, value = target
        check_holes(self.pair)
        check_problem(
            self.pair, replace(self.terms, load=math.exp(self.ends()[0])), held=MAX_HELD_RESULTS
        )
        if name == SATURATED and resolve_ceiling(self.terms.ceiling, self.pair) is None:
            raise InputError(
                f"needs a {ArgumentRef('ceiling')} or a {ArgumentRef('yield_strength')}: without "
                "one nothing is saturated",
                argument=_ARGUMENTS[name],
            )
        if name == GAP:
            open_gap = float(np.nanmean(self.pair.initial_gap))
            if value >= open_gap:
                raise InputError(
                    f"must be below that of the bodies at their first touch, "
                    f"{format_engineering(open_gap, 'm')}, got {format_engineering(value, 'm')}",
                    argument=name,
                )
        if name == YIELD:
            self.pair.boundary.require_known_below("the stress below the surface")
            self.pair.require_uncoated("the load of first yield")
            if not _yielding_bodies(self.pair):
                raise InputError(
                    f"needs a {ArgumentRef('yield_strength')} of either body", argument=name
                )

    def ends(self) -> tuple[float, float]:
        """Return the logarithms of the smallest and largest evaluated load."""
        pair = self.pair
        ceiling = resolve_ceiling(self.terms.ceiling, pair)
        touchable = np.isfinite(touchable_gap(pair))
        limit = pair.contact_modulus if ceiling is None else np.asarray(ceiling)
        largest = float(np.broadcast_to(limit, pair.shape)[touchable].sum()) * pair.pixel_area
        minimum = _MIN_LOAD_FRACTION * pair.contact_modulus * pair.pixel_area
        return math.log(min(minimum, _MIN_LOAD_FRACTION * largest)), math.log(largest)

    def answer(self, target: Target) -> LoadAnswer:
        """Return the load of one target."""
        name, value = target
        first, known = self.initial_load(target), self.known_excesses(target)
        near = min(known, key=lambda point: abs(point[1]), default=None)
        if near is not None and name != APPROACH:
            first = near[0]
        try:
            low, high = bracket_crossing(
                lambda x: self.excess(x, target),
                first,
                self.ends(),
                accuracy=SHARE_ACCURACY if name in COUNTED else ACCURACY,
                slope=self.slope(target),
                known=known,
                adjacent=partial(self.adjacent, name),
            )
        except NotPassedError as stop:
            raise self.refusal(target, stop.end) from None
        x = high[0] if name in COUNTED or abs(high[1]) <= abs(low[1]) else low[0]
        result = self.held.get(x) or self.contact_at(x, name)
        below, above = (Side(math.exp(index), self.seen[index][name]) for index, _ in (low, high))
        self.held = {x: result}
        return LoadAnswer(name, value, _values(result, name)[name], below, above, result)

    def initial_load(self, target: Target) -> float:
        """Return the logarithm of the initial load."""
        name, value = target
        pair = self.pair
        ceiling = resolve_ceiling(self.terms.ceiling, pair)
        flat = name == GAP and ceiling is None and not pair.boundary.free_axes
        if name == APPROACH or flat:
            # The mean displacement of a periodic surface is zero.
            approach = float(pair.initial_gap.mean()) - value if flat else value
            terms = replace(self.terms, load=None, approach=approach)
            return math.log(self.solve_load(terms, None).load)
        if name == YIELD:
            body = min(strength for _, strength in _yielding_bodies(pair))
            return math.log(1.6 * body * pair.pixel_area)
        # Spots of rough surfaces carry E* h'/2 under small loads, or the ceiling.
        slope = max(roughness.rms_gradient(pair.initial_gap, pair.pixel), 1e-9)
        bears = 0.5 * slope * pair.contact_modulus
        if ceiling is not None:
            bears = min(bears, float(np.mean(ceiling)))
        return math.log((value if name == CONTACT else 0.05) * bears * pair.size[0] * pair.size[1])

    def slope(self, target: Target) -> float:
        """Return the approximate slope of ln(quantity / value) over ln(load)."""
        name, value = target
        if name == SATURATED:
            # Under any load the highest asperities are at the ceiling.
            return 0.15
        if name != GAP:
            return 1.0
        # W ~ exp(-gap / (Sq / 2)): Persson 2007, doi:10.1103/PhysRevLett.99.125502
        return 0.5 * float(np.nanstd(self.pair.initial_gap)) / value

    def excess(self, x: float, target: Target) -> float:
        """Return the excess of the quantity over the value at the load exp(x); see `_excess`."""
        name, value = target
        if x not in self.seen or name not in self.seen[x]:
            result = self.held.get(x) or self.contact_at(x, name)
            self.seen.setdefault(x, {}).update(_values(result, name))
            self.held[x] = result
        self.drop_contacts(target)
        return _excess(name, self.seen[x], value)

    def known_excesses(self, target: Target) -> list[Point]:
        """Return logarithm and excess of the loads at which the quantity is known."""
        name, value = target
        seen = self.seen.items()
        return [(x, _excess(name, there, value)) for x, there in seen if name in there]

    def drop_contacts(self, target: Target) -> None:
        """Drop all contacts except the ends of the bracket."""
        signed = sorted(self.known_excesses(target))
        below = [x for x, y in signed if y < 0][-1:]
        above = [x for x, y in signed if y >= 0][:1]
        self.held = {x: self.held[x] for x in (*below, *above) if x in self.held}

    def contact_at(self, x: float, name: str) -> ContactResult:
        """Return the contact under the load exp(x)."""
        load = math.exp(x)
        known = [r for r in (*self.held.values(), self.last) if r is not None]
        start = min(known, key=lambda r: abs(r.load / load - 1), default=None)
        if start is not None and not abs(start.load / load - 1) < _RESTART_TOLERANCE:
            start = None
        if name in COUNTED:
            # Near a step, the pixels in contact depend on the start, within the tolerance.
            start = None
        return self.solve_load(replace(self.terms, load=load, approach=None), start)

    def solve_load(self, terms: LoadCase, start: ContactResult | None) -> ContactResult:
        """Solve a contact and count the solve."""
        self.last = solve_pair(self.pair, terms, start=start, progress=self.progress)
        self.solves += 1
        self.convolutions += self.last.convolutions
        return self.last

    def adjacent(self, name: str, low: float, high: float) -> bool:
        """Return whether the contacts of two loads differ by at most one pixel."""
        if name not in COUNTED:
            return False
        pixels = self.pair.shape[0] * self.pair.shape[1]
        counts = [
            (round(there[CONTACT] * pixels), round(there["saturated_fraction"] * pixels))
            for there in (self.seen[low], self.seen[high])
        ]
        differences = [abs(b - a) for a, b in zip(*counts, strict=True)]
        return differences[0] <= 1 and (name == CONTACT or differences[1] <= 1)

    def refusal(self, target: Target, end: Point) -> InputError:
        """Return the error for a value that no load gives."""
        name, value = target
        reached = self.seen[end[0]][name]
        side = "largest" if end[1] < 0 else "smallest"
        return InputError(
            f"{_text(name, value)} is not reached at any load: under the {side} load tried, "
            f"{format_engineering(math.exp(end[0]), 'N')}, {_NAMES[name]} is "
            f"{_text(name, reached)}",
            argument=_ARGUMENTS.get(name, name),
        )


def _text(name: str, value: float) -> str:
    if name in COUNTED:
        return format_percent(value)
    return f"{value:.4g}" if name == YIELD else format_engineering(value, "m")


def _values(result: ContactResult, name: str) -> dict[str, float]:
    """Return the quantities of a contact; the stress only if it is requested."""
    touching, saturated = (int(np.count_nonzero(m)) for m in (result.contact, result.saturated))
    answer = {
        CONTACT: touching / result.pressure.size,
        "saturated_fraction": result.saturated_fraction,
        SATURATED: saturated / touching if touching else 0.0,
        APPROACH: result.approach,
        GAP: result.mean_gap,
    }
    if name == YIELD:
        answer[YIELD] = _utilization(result)
    return answer


def _yielding_bodies(pair: Pair) -> list[tuple[Material, float]]:
    """Return the bodies that can yield, with their yield strengths."""
    return [
        (body, body.yield_strength)
        for body in (pair.material, pair.counter_material)
        if body.yield_strength is not None and math.isfinite(body.young)
    ]


def _utilization(result: ContactResult) -> float:
    """Return the largest von Mises stress at or below the surface over the yield strength."""
    pair, pressure = result.pair, result.pressure
    # The largest stress is below or next to loaded pixels: crop the map to these.
    for axis in pair.boundary.free_axes:
        loaded = np.flatnonzero(pressure.any(axis=1 - axis))
        first, end = max(int(loaded[0]) - _MARGIN, 0), int(loaded[-1]) + _MARGIN + 1
        pressure = np.moveaxis(np.moveaxis(pressure, axis, 0)[first:end], 0, axis)
    return max(
        stress_summary.summarize(
            pressure, pair.pixel, body.poisson, boundary=pair.boundary
        ).max_von_mises
        / strength
        for body, strength in _yielding_bodies(pair)
    )


def _excess(name: str, there: dict[str, float], value: float) -> float:
    result = there[name]
    if name == GAP:
        # The gap of rough surfaces is about linear in the logarithm of the load.
        return 1 - result / value
    return math.log(result / value) if result > 0 else -math.inf


def _targets(
    contact: Any, saturated: Any, approach: Any, mean_gap: Any, first_yield: bool
) -> list[Target]:
    """Return the targets, in the order of the arguments."""
    targets = [*_shares(CONTACT, contact), *_shares(SATURATED, saturated)]
    targets += [*_lengths(APPROACH, approach), *_lengths(GAP, mean_gap)]
    if first_yield:
        targets.append((YIELD, 1.0))
    if not targets:
        raise InputError(
            f"no target: give {ArgumentRef('contact_fraction')}, "
            f"{ArgumentRef('saturated_fraction')}, {ArgumentRef('approach')}, "
            f"{ArgumentRef('mean_gap')} or {ArgumentRef('first_yield')}"
        )
    return targets


def _shares(name: str, specified: Any) -> list[Target]:
    """Return the targets of one share or several."""
    argument = _ARGUMENTS.get(name, name)
    if isinstance(specified, str):
        specified = shares(specified, argument)
    result = [] if specified is None else list(specified) if np.ndim(specified) else [specified]
    for share in result:
        if not 0 < share <= 1:
            raise input_error(argument, share, "must be a share above 0 and up to 1")
    return [(name, float(share)) for share in result]


def _lengths(name: str, specified: Any) -> list[Target]:
    """Return the targets of one length or several."""
    values = to_si(specified, "length", name)
    result = [] if values is None else list(values) if np.ndim(values) else [values]
    for length in result:
        if not (isinstance(length, (int, float)) and 0 < length < math.inf):
            raise input_error(name, length, "must be positive and finite [m]")
    return [(name, float(length)) for length in result]
