"""Contacts of one pair of bodies under several loads, looked at one at a time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError


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
        If they are profiles, of different maps, or none.
    """
    shape: tuple[int, int] | None = None
    for result in [contacts] if isinstance(contacts, ContactResult) else contacts:
        if shape is not None and result.pair.shape != shape:
            raise InputError(
                f"are of different maps: {result.pair.shape} and {shape} points; give one pair of "
                "bodies under several loads",
                argument="contacts",
            )
        result.pair.require_map(what)
        shape = result.pair.shape
        yield result
    if shape is None:
        raise InputError("is empty: give at least one contact", argument="contacts")
