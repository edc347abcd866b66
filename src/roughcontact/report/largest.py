"""What is told of the bodies of contacts under several loads: that of the largest of them."""

from __future__ import annotations

from roughcontact.report import tables
from roughcontact.report.quantities import PROBLEM, Quantity, Table, quantity_of, within


def of_largest(key: str) -> Quantity:
    """Return a quantity of the contact under the largest load as one of all; in files alone.

    Parameters
    ----------
    key : str
        Of `tables.CONTACT`; the result holds the contact as ``largest``.
    """
    return within("largest", quantity_of(tables.CONTACT, key), name="", part=PROBLEM)


PAIR: Table = tuple(
    of_largest(key) for key in ("source", "preparation", "boundary", "contact_modulus")
)
"""What is pressed on what."""
