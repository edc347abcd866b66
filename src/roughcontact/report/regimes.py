"""How far from elastic a result is, as a sentence with its numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact.contact.result import ContactResult, Regime
from roughcontact.elastoplastic.result import ElastoplasticResult, PlasticRegime
from roughcontact.material.material import Material
from roughcontact.report import phrases
from roughcontact.units import engineering, percent

if TYPE_CHECKING:
    pass


def regime(result: ContactResult) -> str:
    """Return the regime of a result as a sentence with its numbers."""
    largest = engineering(result.max_pressure, "Pa", 3)
    name = result.regime
    if name is Regime.SATURATED:
        share = percent(result.saturated_fraction / result.contact_fraction)
        return (
            f"The material yields at the surface: on {share} of the contact {_extent(result)} the "
            "pressure is at its ceiling, and the surface there keeps an indentation."
        )
    body = result.pair.softer
    if name is Regime.UNKNOWN and (body is None or body.hardness is None):
        return f"Yielding is unknown without a yield strength (maximum pressure {largest})."
    assert body is not None
    if name in (Regime.UNKNOWN, Regime.BEYOND_HARDNESS):
        assert body.hardness is not None
        hardness = engineering(body.hardness, "Pa", 3)
        if name is Regime.UNKNOWN:
            return (
                f"The largest pressure, {largest}, stays below the hardness of the softer body, "
                f"{hardness}. Whether it yields below the surface cannot be said without a yield "
                "strength."
            )
        return (
            f"The elastic pressure, up to {largest}, exceeds the hardness of the softer body, "
            f"{hardness}, more than it can carry. The true contact {_extent(result)} is larger, "
            "the true pressure lower."
        )
    yielding = result.pair.first_to_yield
    assert yielding is not None
    pressure = result.pair.yields_at(yielding)
    assert pressure is not None
    first = engineering(pressure, "Pa", 3)
    if name is Regime.BELOW_FIRST_YIELD:
        return (
            f"Nothing yields: the largest pressure, {largest}, stays below {first}, at which "
            f"{_sphere(result)} first yields below its surface.{_other(result)}"
        )
    if name is Regime.YIELDING_BELOW:
        return (
            f"The material yields below the surface of the most loaded spots: the largest "
            f"pressure, {largest}, exceeds {first}, at which {_sphere(result)} first yields, but "
            "no point reaches "
            + ("the ceiling." if result.ceiling is not None else _strength(body))
            + " The pressures shown are those of an elastic body."
        )
    assert name is Regime.BEYOND_CEILING
    assert body.yield_strength is not None
    times = result.max_pressure / body.yield_strength
    return (
        f"The elastic pressure, up to {largest}, is {times:.3g} times the yield strength of the "
        f"softer body, more than it can carry. The true contact {_extent(result)} is larger, the "
        "true pressure lower."
    )


def _strength(softer: Material) -> str:
    return "the hardness." if softer.yield_strength is None else "three yield strengths."


def _sphere(result: ContactResult) -> str:
    """Return whose sphere yields first, where both bodies may."""
    pair = result.pair
    what = "a cylinder" if pair.is_profile else "a sphere"
    if None in (pair.material.first_yield_pressure, pair.counter_material.first_yield_pressure):
        return what
    whose = "body" if pair.first_to_yield is pair.material else "counter-body"
    return f"{what} of the {whose}"


def _extent(result: ContactResult) -> str:
    return "length" if result.pair.is_profile else "area"


def _other(result: ContactResult) -> str:
    """Return what is said where only one of two bodies that deform has a known strength."""
    pair = result.pair
    for body, who in ((pair.material, "body"), (pair.counter_material, "counter-body")):
        if not phrases.is_rigid(body) and body.ceiling is None:
            return f" Yielding of the {who} is unknown without its strength."
    return ""


def volume_regime(result: ElastoplasticResult) -> str:
    """Return the regime of a result of the volume model as a sentence with its numbers."""
    if result.regime is PlasticRegime.ELASTIC:
        share = percent(min(1 + result.yield_excess, 1.0))
        return (
            f"Nothing has yielded: the von Mises stress is at most {share} of the yield strength."
        )
    reached = engineering(result.plastic_depth, "m", 3)
    strain = percent(result.max_plastic_strain)
    text = f"Plastic strain, up to {strain}, reaches down to {reached}"
    surface = (
        " and up to the surface."
        if result.regime is PlasticRegime.AT_SURFACE
        else "; the surface above it has stayed elastic."
    )
    if result.solution.load:
        return text + surface
    deepest = engineering(float(result.residual_displacement.max()), "m", 3)
    return f"{text}{surface} The load is gone, and has left an indentation of up to {deepest}."
