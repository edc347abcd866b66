"""Contacts of one joint under several loads, looked at one at a time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError, Part
from roughcontact.material.material import Material
from roughcontact.units import engineering, lengths

# Edges of pixels that differ by less than this part are one.
_SAME = 1e-6


def of_one_pair(
    contacts: ContactResult | Iterable[ContactResult], what: str
) -> Iterator[ContactResult]:
    """Yield the contacts, once each is known to be one more of the same bodies.

    Parameters
    ----------
    contacts : ContactResult or iterable of ContactResult
        One, or several.
    what : str
        What is asked of them and needs a map, for a message.

    Raises
    ------
    InputError
        If they are profiles, differ in more than the load, or there is none.
    """
    # Not the contact itself, so that its maps are free again.
    first: tuple[Pair, bool] | None = None
    for result in [contacts] if isinstance(contacts, ContactResult) else contacts:
        result.pair.require_map(what)
        pair, is_elastic = result.pair, result.ceiling is None
        first = first or (pair, is_elastic)
        advice = "; give one pair of bodies under several loads"
        require_alike(first[0], pair, "contacts", advice)
        require_one_model(first[1], is_elastic)
        if not same_heights(first[0], pair):
            raise InputError(f"are of different maps{advice}", argument="contacts")
        yield result
    if first is None:
        raise InputError("is empty: give at least one contact", argument="contacts")


def require_alike(
    first: Pair, other: Pair, argument: str, *advice: Part, only_elastic: bool = False
) -> None:
    """Refuse two pairs of bodies that differ in more than their heights.

    Parameters
    ----------
    first, other : Pair
        The bodies of two contacts.
    argument : str
        That they were given for, for a message.
    *advice : str or Mention
        What to do, as the end of the message.
    only_elastic : bool
        Whether strength and hardness of the materials may differ.

    Raises
    ------
    InputError
        If points, pixels, boundaries or materials differ.
    """
    pixels = np.allclose(first.pixel, other.pixel, rtol=_SAME, atol=0)
    if first.shape != other.shape or not pixels:
        one, two = (f"{p.shape[0]} × {p.shape[1]} points of {lengths(p.pixel)}"
                    for p in (first, other))  # fmt: skip
        raise InputError(f"are of different grids, {one} and {two}", *advice, argument=argument)
    if first.boundary != other.boundary:
        told = f"differ in boundary, {first.boundary} and {other.boundary}"
        raise InputError(told, *advice, argument=argument)
    if only_elastic and first.contact_modulus == other.contact_modulus:
        return
    for name, whose in (("material", "body"), ("counter_material", "counter-body")):
        own, others = _constants(getattr(first, name)), _constants(getattr(other, name))
        if own != others:
            raise InputError(
                f"differ in the material of the {whose}, {own} and {others}",
                *advice,
                argument=argument,
            )


def require_one_model(first: bool, other: bool) -> None:
    """Refuse contacts of which one was solved with a ceiling and another elastic."""
    if first != other:
        raise InputError(
            "are some with a ceiling and some elastic; give contacts of one model",
            argument="contacts",
        )


def same_heights(first: Pair, second: Pair) -> bool:
    """Return whether two pairs on one grid have the same maps."""
    if (first.counter_surface is None) != (second.counter_surface is None):
        return False
    return all(
        one is two or np.array_equal(one, two, equal_nan=True)
        for one, two in (
            (first.surface.heights, second.surface.heights), (first.heights, second.heights)
        )
    )  # fmt: skip


def _constants(material: Material) -> str:
    """Return all constants of a material in words; its name is none of them."""
    if math.isinf(material.young):
        return "rigid"
    told = [f"E {engineering(material.young, 'Pa', 12)}", f"ν {material.poisson!r}"]
    for symbol, value in (("σ_Y", material.yield_strength), ("H", material.hardness)):
        if value is not None:
            told.append(f"{symbol} {engineering(value, 'Pa', 12)}")
    if material.hardening is not None:
        told.append(repr(material.hardening))
    return ", ".join(told)
