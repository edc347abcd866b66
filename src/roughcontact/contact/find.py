"""Inverse questions: the load at which a contact has a value."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.arguments import checked
from roughcontact.contact import search
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.checks import check, check_holes, touchable_gap
from roughcontact.contact.found import (
    APPROACH,
    CONTACT,
    COUNTED,
    GAP,
    SATURATED,
    YIELD,
    FoundLoad,
    FoundLoads,
    Side,
)
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.search import NotPassedError, Point
from roughcontact.contact.solve import press
from roughcontact.contact.terms import Terms
from roughcontact.errors import InputError, Mention
from roughcontact.halfspace import stress_summary
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers.bar import drawn
from roughcontact.solvers.progress import Step, Tell, numbered
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, engineering, percent, quantity

ACCURACY = 1e-6
"""How close value or loads of a bracket come, relatively."""

HELD = 6
"""Maps held meanwhile: pressure and gap at both ends of the bracket, and of the answer before."""

# Loads less far apart than this, relatively, start from each other; for others the solver's own
# coarse grids find a better start than the pressure of the load before.
_NEAR = 2e-3
# The smallest load, as part of that which presses one pixel flat.
_LEAST = 1e-9

Target = tuple[str, float]

# What arguments are called, and how values are told.
_ARGUMENTS = {CONTACT: "contact", SATURATED: "saturated", APPROACH: "approach", GAP: "mean_gap"}
_NAMES = {
    CONTACT: "the part of the map that touches",
    SATURATED: "the part of the contact at the ceiling",
    APPROACH: "the approach",
    GAP: "the mean gap",
    YIELD: "the largest stress over the yield strength",
}


@drawn
@checked
def find_load(
    surface: Surface,
    *,
    material: Material,
    contact: float | Sequence[float] | None = None,
    saturated: float | Sequence[float] | None = None,
    approach: Quantity | Quantities | None = None,
    mean_gap: Quantity | Quantities | None = None,
    first_yield: bool = False,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    progress: Tell = None,
) -> FoundLoads:
    """Return the loads at which a contact has the values asked for.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, ceiling, boundary, tolerance, \
max_iterations
        As for `solve`.
    contact : float or sequence of float, optional
        Share of the map that touches, between 0 and 1.
    saturated : float or sequence of float, optional
        Share of the contact area that is at the ceiling.
    approach, mean_gap : float, str, quantity of pint, or sequence of these, optional
        Approach of the bodies from the first touch, mean open gap [m].
    first_yield : bool
        Whether to find the load at which the first point of either body yields, at the surface
        or below it; that contact is elastic, without a ceiling.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`: the number of the question and the solver's `Step`.

    Returns
    -------
    FoundLoads
        An answer to each question, in the order of the arguments, with its bracket and contact.

    Raises
    ------
    InputError
        If nothing is asked, an argument cannot be used, or no load gives the value: the message
        says what is reached at the last load.
    CapacityError, InsufficientMemoryError, ConvergenceError
        As for `solve`.

    Notes
    -----
    Approach and mean gap are met to 1e-6 of the value, at both ends of the bracket. Contact and
    saturation are counts of pixels and pass a value in steps: the bracket ends where its loads
    differ by one pixel, or by 1e-6, and the answer is the smaller load at which the value is
    reached. The part of the contact that is saturated need not grow with the load; where it
    passes the value several times the answer is the passage at the largest load that was seen.

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
    began = time.perf_counter()
    targets = _targets(contact, saturated, approach, mean_gap, first_yield)
    pair = Pair(surface, material, counter_surface, counter_material, Boundary(boundary))
    pair.require_map("a search of loads")
    terms = Terms(ceiling=ceiling, tolerance=tolerance, max_iterations=max_iterations)
    finder, elastic = (_Finder(pair, t) for t in (terms, replace(terms, ceiling=None)))
    of = {target: elastic if target[0] == YIELD else finder for target in targets}
    for target in targets:
        of[target].check(target)
    answers = tuple(
        of[target].answer(target, numbered(progress, number, len(targets)))
        for number, target in enumerate(targets, start=1)
    )
    return FoundLoads(
        answers,
        solves=finder.solves + elastic.solves,
        convolutions=finder.convolutions + elastic.convolutions,
        seconds=time.perf_counter() - began,
    )


@dataclass(eq=False)
class _Finder:
    """The contacts of two bodies at the loads that were looked at, for all questions."""

    pair: Pair
    terms: Terms
    seen: dict[float, dict[str, float]] = field(default_factory=dict)
    """What there was at each load, by its logarithm."""
    held: dict[float, ContactResult] = field(default_factory=dict)
    last: ContactResult | None = None
    solves: int = 0
    convolutions: int = 0

    def check(self, target: Target) -> None:
        """Raise what can be told before the first solve."""
        name, value = target
        check_holes(self.pair)
        check(self.pair, replace(self.terms, load=math.exp(self.ends()[0])), held=HELD)
        argument = _ARGUMENTS.get(name)
        if name == SATURATED and resolved_ceiling(self.terms.ceiling, self.pair) is None:
            raise InputError(
                "needs a ", Mention("ceiling"), " or a ", Mention("yield_strength"),
                ": without one nothing is saturated", argument=argument,
            )  # fmt: skip
        if name == GAP:
            open_gap = float(np.nanmean(self.pair.initial_gap))
            if value >= open_gap:
                raise InputError(
                    f"must be below that of the bodies at their first touch, "
                    f"{engineering(open_gap, 'm')}, got {engineering(value, 'm')}",
                    argument=argument,
                )  # fmt: skip
        if name == YIELD:
            self.pair.boundary.require_stress()
            if not _yielding(self.pair):
                raise InputError(
                    "needs a ", Mention("yield_strength"), " of either body",
                    argument="first_yield",
                )  # fmt: skip

    def ends(self) -> tuple[float, float]:
        """Return the logarithms of the smallest and largest load looked at."""
        pair = self.pair
        ceiling = resolved_ceiling(self.terms.ceiling, pair)
        touchable = np.isfinite(touchable_gap(pair))
        limit = pair.contact_modulus if ceiling is None else np.asarray(ceiling)
        largest = float(np.broadcast_to(limit, pair.shape)[touchable].sum()) * pair.pixel_area
        least = _LEAST * pair.contact_modulus * pair.pixel_area
        return math.log(min(least, _LEAST * largest)), math.log(largest)

    def answer(self, target: Target, progress: Callable[[Step], None] | None) -> FoundLoad:
        """Return the load of one question."""
        name, value = target
        first = self.first(target, progress)
        known = [(x, _excess(name, there, value)) for x, there in self.seen.items()
                 if name in there]  # fmt: skip
        near = min(known, key=lambda point: abs(point[1]), default=None)
        if near is not None and name != APPROACH:
            first = near[0]
        try:
            low, high = search.passage(
                lambda x: self.excess(x, target, progress),
                first,
                self.ends(),
                accuracy=ACCURACY,
                known=known,
                adjacent=(lambda a, b: self.adjacent(name, a, b)) if name in COUNTED
                else (lambda a, b: False),
            )  # fmt: skip
        except NotPassedError as stop:
            raise self.refusal(target, stop.end) from None
        upper = name in COUNTED or abs(high[1]) <= abs(low[1])
        x = high[0] if upper else low[0]
        result = self.held.get(x) or self.at(x, name, progress)
        below, above = (
            Side(math.exp(at), self.seen[at][name]) for at, _ in (low, high)
        )  # fmt: skip
        self.held = {x: result}
        return FoundLoad(name, value, _values(result, name)[name], below, above, result)

    def first(self, target: Target, progress: Callable[[Step], None] | None) -> float:
        """Return the logarithm of a load to begin with."""
        name, value = target
        pair = self.pair
        if name == APPROACH:
            terms = replace(self.terms, load=None, approach=value)
            return math.log(self.solved(terms, None, progress).load)
        if name == YIELD:
            body = min(strength for _, strength in _yielding(pair))
            return math.log(1.6 * body * pair.pixel_area)
        # Spots of rough surfaces bear E* h'/2 under little load, or the ceiling.
        slope = max(roughness.rms_gradient(pair.initial_gap, pair.pixel), 1e-9)
        ceiling = resolved_ceiling(self.terms.ceiling, pair)
        bears = 0.5 * slope * pair.contact_modulus
        if ceiling is not None:
            bears = min(bears, float(np.mean(ceiling)))
        share = value if name == CONTACT else 0.05
        return math.log(share * bears * pair.size[0] * pair.size[1])

    def excess(self, x: float, target: Target, progress: Callable[[Step], None] | None) -> float:
        """Return ln(quantity / value) at the load exp(x), negative where it is not reached."""
        name, value = target
        if x not in self.seen or name not in self.seen[x]:
            result = self.held.get(x) or self.at(x, name, progress)
            self.seen.setdefault(x, {}).update(_values(result, name))
            self.held[x] = result
        self.forget(target)
        return _excess(name, self.seen[x], value)

    def forget(self, target: Target) -> None:
        """Keep the contacts at the ends of the bracket, and no other."""
        name, value = target
        signed = sorted((x, _excess(name, there, value)) for x, there in self.seen.items()
                        if name in there)  # fmt: skip
        below = [x for x, y in signed if y < 0][-1:]
        above = [x for x, y in signed if y >= 0][:1]
        self.held = {x: self.held[x] for x in (*below, *above) if x in self.held}

    def at(self, x: float, name: str, progress: Callable[[Step], None] | None) -> ContactResult:
        """Return the contact under the load exp(x)."""
        load = math.exp(x)
        near = [r for r in (*self.held.values(), self.last)
                if r is not None and abs(r.load / load - 1) < _NEAR]  # fmt: skip
        start = min(near, key=lambda r: abs(r.load / load - 1), default=None)
        if name in COUNTED:
            # Which pixels touch next to a step depends on the start, within the tolerance.
            start = None
        return self.solved(replace(self.terms, load=load, approach=None), start, progress)

    def solved(
        self, terms: Terms, start: ContactResult | None, progress: Callable[[Step], None] | None
    ) -> ContactResult:
        """Return one more contact, and count it."""
        self.last = press(self.pair, terms, start=start, progress=progress)
        self.solves += 1
        self.convolutions += self.last.convolutions
        return self.last

    def adjacent(self, name: str, low: float, high: float) -> bool:
        """Return whether no whole pixel lies between two loads."""
        pixels = self.pair.shape[0] * self.pair.shape[1]
        counts = [(round(there[CONTACT] * pixels), round(there["saturated_fraction"] * pixels))
                  for there in (self.seen[low], self.seen[high])]  # fmt: skip
        apart = [abs(b - a) for a, b in zip(*counts, strict=True)]
        return apart[0] <= 1 and (name == CONTACT or apart[1] <= 1)

    def refusal(self, target: Target, end: Point) -> InputError:
        """Return the error for a value that no load gives."""
        name, value = target
        reached = self.seen[end[0]][name]
        side = "largest" if end[1] < 0 else "smallest"
        return InputError(
            f"{_told(name, value)} is not passed at any load: under the {side} that was tried, "
            f"{engineering(math.exp(end[0]), 'N')}, {_NAMES[name]} is {_told(name, reached)}",
            argument=_ARGUMENTS.get(name, name),
        )  # fmt: skip


def _told(name: str, value: float) -> str:
    if name in COUNTED:
        return percent(value)
    return f"{value:.4g}" if name == YIELD else engineering(value, "m")


def _values(result: ContactResult, name: str) -> dict[str, float]:
    """Return all that a contact tells at once, and what it tells only if asked."""
    touching, saturated = (int(np.count_nonzero(m)) for m in (result.contact, result.saturated))
    found = {
        CONTACT: touching / result.pressure.size,
        "saturated_fraction": result.saturated_fraction,
        SATURATED: saturated / touching if touching else 0.0,
        APPROACH: result.approach,
        GAP: result.mean_gap,
    }
    if name == YIELD:
        found[YIELD] = _utilization(result)
    return found


def _yielding(pair: Pair) -> list[tuple[Material, float]]:
    """Return the bodies that can yield, with their strengths."""
    return [
        (body, body.yield_strength)
        for body in (pair.material, pair.counter_material)
        if body.yield_strength is not None and math.isfinite(body.young)
    ]


def _utilization(result: ContactResult) -> float:
    """Return the largest von Mises stress at or below the surface over the yield strength."""
    pair = result.pair
    return max(
        stress_summary.summarise(
            result.pressure, pair.pixel, body.poisson, boundary=pair.boundary
        ).max_von_mises
        / strength
        for body, strength in _yielding(pair)
    )


def _excess(name: str, there: dict[str, float], value: float) -> float:
    found = there[name]
    if name == GAP:
        # Rough surfaces close by the logarithm of the load: this is what is straight in it.
        return 1 - found / value
    return math.log(found / value) if found > 0 else -math.inf


def _targets(
    contact: Any, saturated: Any, approach: Any, mean_gap: Any, first_yield: bool
) -> list[Target]:
    """Return what is asked, in the order of the arguments."""
    targets = [
        *_shares(CONTACT, contact),
        *_shares(SATURATED, saturated),
        *_lengths(APPROACH, approach),
        *_lengths(GAP, mean_gap),
        *([(YIELD, 1.0)] if first_yield else []),
    ]
    if not targets:
        raise InputError(
            "nothing is asked: give ", Mention("contact"), ", ", Mention("saturated"), ", ",
            Mention("approach"), ", ", Mention("mean_gap"), " or ", Mention("first_yield"),
        )  # fmt: skip
    return targets


def _shares(name: str, given: Any) -> list[Target]:
    """Return targets from one share or several."""
    argument = _ARGUMENTS[name]
    found = [] if given is None else list(given) if np.ndim(given) else [given]
    for share in found:
        if not 0 < share <= 1:
            raise InputError(
                f"must be a share above 0 and up to 1, got {share!r}",
                argument=argument, value=share,
            )  # fmt: skip
    return [(name, float(share)) for share in found]


def _lengths(name: str, given: Any) -> list[Target]:
    """Return targets from one length or several."""
    argument = _ARGUMENTS[name]
    values = quantity(given, "length", argument)
    found = [] if values is None else list(values) if np.ndim(values) else [values]
    for length in found:
        if not (isinstance(length, (int, float)) and 0 < length < math.inf):
            raise InputError(
                f"must be positive and finite [m], got {length!r}", argument=argument, value=length
            )
    return [(name, float(length)) for length in found]
