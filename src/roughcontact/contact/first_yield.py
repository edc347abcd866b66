"""First yield below a contact: the load at which the first point of a body yields."""

from __future__ import annotations

import math

from roughcontact.arguments import checked
from roughcontact.contact.pair import BODIES, Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import press
from roughcontact.contact.stress import StressResult
from roughcontact.contact.subsurface import subsurface_stress, traction
from roughcontact.contact.terms import Terms
from roughcontact.errors import ConvergenceError, InputError, require_positive
from roughcontact.halfspace import stress_summary
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import RIGID, Material
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, quantity

# Largest step of the search for first yield, and most contacts that it solves.
_STEP = 1000.0
_SOLVES = 40


@checked
def yield_onset(
    surface: Surface,
    *,
    material: Material,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    body: str = "body",
    friction: float = 0.0,
    direction: float = 0.0,
    boundary: str = "free",
    start: Quantity | None = None,
    tolerance: float = 1e-3,
) -> StressResult:
    """Return the contact at the load at which the first point of a body yields.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, boundary
        As for `contact.solve`; the contact is elastic, without a ceiling.
    body, friction, direction
        As for `subsurface_stress`.
    start : float, optional
        Load to begin with [N]; by default that of one pixel at 1.6 times the yield strength.
    tolerance : float
        How close the largest von Mises stress must come to the yield strength, relatively.

    Returns
    -------
    StressResult
        Its ``solution.load`` is the load of first yield.

    Raises
    ------
    InputError
        If the body is rigid or has no yield strength, or an argument cannot be used.
    ConvergenceError
        If no such load is found.

    Notes
    -----
    The largest stress grows with the load as a power that is 1/3 for a sphere and depends on the
    shape else, so each step is a secant of their logarithms, kept between the loads known to be
    too light and too heavy. A surface that is rough down to the pixel yields at its sharpest summit
    under next to no load: the answer then is one of the resolution.
    """
    pair = Pair(surface, material, counter_surface, counter_material, Boundary(boundary))
    return onset(pair, body, friction, direction, start=start, tolerance=tolerance)


def onset(
    pair: Pair,
    body: str = "body",
    friction: float = 0.0,
    direction: float = 0.0,
    *,
    start: Quantity | None = None,
    tolerance: float = 1e-3,
) -> StressResult:
    """Return the contact of two bodies at which the first point of one yields; see `yield_onset`.

    Parameters
    ----------
    pair : Pair
        The bodies.
    body, friction, direction, start, tolerance
        As for `yield_onset`.
    """
    require_positive(tolerance=tolerance)
    if not pair.is_profile:
        pair.boundary.require_stress()
    first = quantity(start, "force", "start")
    if first is not None:
        require_positive(start=first)
    strength = _yield_strength(pair, body)
    load: float = first or 1.6 * strength * pair.pixel[0] * pair.pixel[1]
    known: list[tuple[float, float]] = []
    last: ContactResult | None = None
    for _ in range(_SOLVES):
        last = press(pair, Terms(load=load, ceiling=None), start=last)
        profile = stress_summary.summarise(
            last.pressure, pair.pixel, pair.material_of(body).poisson,
            **traction(pair, body, friction, direction),
        )  # fmt: skip
        excess = math.log(profile.max_von_mises / strength)
        if abs(excess) <= tolerance:
            return subsurface_stress(last, body=body, friction=friction, direction=direction)
        known.append((math.log(load), excess))
        load = math.exp(_next(known))
    assert last is not None
    raise ConvergenceError(
        f"no load found at which the largest stress is the yield strength: after {_SOLVES} "
        f"contacts it is {math.exp(known[-1][1]):.4g} of it at {last.load:.6g} {pair.load_unit}",
        last,
    )


def _yield_strength(pair: Pair, body: str) -> float:
    material = pair.material_of(body)
    if material.yield_strength is None or math.isinf(material.young):
        raise InputError(f"the {BODIES[body]} has no yield strength: give its material one")
    return material.yield_strength


def _next(known: list[tuple[float, float]]) -> float:
    """Return where an increasing function should vanish, from points of it."""
    light = max((x for x, y in known if y < 0), default=-math.inf)
    heavy = min((x for x, y in known if y > 0), default=math.inf)
    (at, value), *others = sorted(known, key=lambda point: abs(point[1]))
    slope = 1 / 3
    if others and others[0][0] != at:
        slope = max((others[0][1] - value) / (others[0][0] - at), 0.0) or slope
    most = math.log(_STEP)
    guess = at + min(max(-value / slope, -most), most)
    # A secant that leaves the bracket, or creeps along it from one side, is halved instead.
    stuck = len(known) > 3 and len({y > 0 for _, y in known[-3:]}) == 1
    if light < heavy < math.inf and light > -math.inf and (stuck or not light < guess < heavy):
        return 0.5 * (light + heavy)
    return guess
