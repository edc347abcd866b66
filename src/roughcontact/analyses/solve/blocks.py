"""Blocks of the report of a contact: spots, comparison with Hertz."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

from roughcontact.analyses.solve import fields as of_profile, hertz_fields as smooth
from roughcontact.contact.hertz_comparison import comparison_limits
from roughcontact.contact.plausibility import load_bearing_spot_pixels
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.drawing.sections import versus_hertz
from roughcontact.report import page
from roughcontact.report.chapters import cells
from roughcontact.report.kind import Quantity, Table, capitalize_first, rows_of
from roughcontact.report.page import Block, Cells, PageTable, Picture
from roughcontact.units import format_engineering, format_percent


class ContactWithSpots(NamedTuple):
    """A contact with its spots."""

    result: ContactResult
    spots: Spots


def _share_of_load(result: ContactWithSpots, count: int) -> str:
    load = result.spots.load
    return format_percent(min(float(load[:count].sum()) / float(load.sum()), 1.0))


SPOTS: Table = (
    Quantity("count", "contact spots", of="spots.count", meaning="connected pixels in contact"),
    Quantity(
        "largest_area",
        "largest spot",
        unit="m²",
        of=lambda s: float(s.spots.area[0]),
        text=lambda s: (
            f"{format_engineering(float(s.spots.area[0]), 'm²')}, "
            f"{_share_of_load(s, 1)} of the load"
        ),
        meaning="area, and the load that it carries",
    ),
    Quantity(
        "carrying_pixels",
        "pixels of a load-bearing spot",
        meaning="spots of at least this size carry half of the load",
        of=lambda s: load_bearing_spot_pixels(s.result, s.spots),
    ),
)
"""Quantities of the contact spots of a `ContactWithSpots`."""


def spot_rows(result: ContactResult) -> list[Cells]:
    """Return the rows of number, size and load of the spots."""
    found = result.spots()
    if found.count == 0:
        return [("Contact spots", "none", "the bodies do not touch")]
    if result.pair.is_profile:
        return list(of_profile.segments(result, found))
    return cells(rows_of(SPOTS, ContactWithSpots(result, found)))


def hertz_blocks(result: ContactResult) -> list[Block]:
    """Return the blocks that compare with Hertz; none without nominal bodies."""
    contact = result.hertz
    if contact is None or not smooth.applies(result):
        return []
    rows = [(capitalize_first(name), *texts) for name, *texts in smooth.rows(result)]
    picture = Picture(
        partial(versus_hertz, result),
        "Mean and maximum pressure over the distance from the middle, and that of the smooth "
        "bodies. Compare how far roughness spreads the load.",
        page.HALF,
    )
    return [
        Block("head", "Compared with the smooth bodies (Hertz)"),
        Block("small", f"{capitalize_first(smooth.bodies(contact))}. {smooth.SIZE}"),
        Block("aside", (picture, [PageTable(rows, ("", *smooth.heads(result)[1:]))])),
        *(Block("small", page.as_sentence(limit.text)) for limit in comparison_limits(result)),
    ]
