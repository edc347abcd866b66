"""Intervals of a load curve of a measured map."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.solve import solve_pair
from roughcontact.uncertainty.measurement import check, uncertainty


def curve_uncertainty(curve: LoadCurve, *how: Any, **more: Any) -> LoadCurve:
    """Return a load curve with the intervals of each load; see `ContactResult.uncertainty`.

    Equal seeds give equal draws, so that the surfaces are the same for all loads.
    """
    largest = curve.largest
    check(largest)
    known = []
    for step in curve.steps:
        ceiling = None if math.isnan(step.ceiling) else step.ceiling
        contact = solve_pair(largest.pair, LoadCase(step.load, ceiling=ceiling))
        known.append(uncertainty(contact, *how, **more))
    return replace(curve, intervals=tuple(known))
