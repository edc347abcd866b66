"""Contacts of one joint under several loads, processed one at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.cautions import Caution, CautionTag, as_note, sort_cautions
from roughcontact.contact.pair import Pair
from roughcontact.contact.plausibility import over_loads
from roughcontact.contact.result import ContactResult
from roughcontact.errors import ArgumentRef, InputError, Part, input_error
from roughcontact.material.material import Material
from roughcontact.result import Result
from roughcontact.surface import spectrum
from roughcontact.units import Quantity, format_engineering, format_lengths, to_si

Step = TypeVar("Step")
Extra = TypeVar("Extra")

# Relative difference up to which pixels are equal.
_PIXEL_TOLERANCE = 1e-6


class StepResult(Result):
    """Result of several loads or stages, one step each."""

    steps: tuple[Any, ...]
    messages: tuple[Caution, ...] = ()
    extra_cautions: tuple[Caution, ...] = ()

    def column(self, name: str) -> Array:
        """Return one field of all steps, shape (n,); see the class of the steps."""
        names = [item.name for item in fields(self.steps[0])]
        if name not in names:
            raise input_error("name", name, f"must be one of {', '.join(names)}")
        return np.array([getattr(step, name) for step in self.steps], dtype=float)

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the result, the most severe first."""
        return sort_cautions([*self.messages, *self.extra_cautions])


@dataclass(frozen=True)
class CalibratedChange:
    """Relative changes under the largest load between usual and calibrated ceiling."""

    ceiling: float  # Calibrated ceiling [Pa]
    contact_area: float  # Relative change of the contact area
    numbers: tuple[float, ...]  # Relative changes of joint quantities; NaN if undefined

    @classmethod
    def from_contact(cls, contact: ContactResult, area: float, *numbers: float) -> CalibratedChange:
        """Return the changes to a contact under the calibrated ceiling, from a contact area."""
        assert isinstance(contact.ceiling, float)
        return cls(contact.ceiling, relative_change(contact.contact_area, area), numbers)


def mean_step(steps: Sequence[Step], skip: Container[str]) -> Step:
    """Return the mean of steps under one load; skipped fields are those of the first step."""
    first: Any = steps[0]
    means = {
        item.name: _mean([getattr(step, item.name) for step in steps])
        for item in fields(first)
        if item.name not in skip
    }
    result: Step = replace(first, **means)
    return result


def _mean(values: Sequence[Any]) -> Any:
    if isinstance(values[0], tuple):
        return tuple(_mean(parts) for parts in zip(*values, strict=True))
    mean = float(np.mean(values))
    return round(mean) if isinstance(values[0], int) else mean


def relative_change(new: float, old: float) -> float:
    """Return a relative change; NaN if the old value is zero or not finite."""
    return new / old - 1 if old and math.isfinite(old) else math.nan


ONE_ROUGH_FACE = as_note(
    CautionTag.ONE_ROUGH_FACE,
    "One rough face against a smooth flat. Two rough faces? Add "
    f"{ArgumentRef('counter_surface')}: roughness rises by about √2.",
)
"""Note for a joint with a smooth counter-body."""


def parse_positive(value: Quantity, dimension: str, argument: str) -> float:
    """Return a positive quantity in SI units."""
    result = to_si(value, dimension, argument)
    if not (isinstance(result, (int, float)) and 0 < result < math.inf):
        raise input_error(argument, value, "must be positive and finite")
    return float(result)


def check_same_pair(
    contacts: ContactResult | Iterable[ContactResult], what: str
) -> Iterator[ContactResult]:
    """Yield the contacts after checking that all are of the same bodies."""
    # Bodies of the first contact without its result, so that its maps are released.
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


def evaluate_contacts(
    contacts: ContactResult | Iterable[ContactResult],
    what: str,
    evaluate: Callable[[ContactResult], tuple[Step, Iterable[Caution], Extra]],
) -> tuple[tuple[Step, ...], tuple[Caution, ...], ContactResult, Extra]:
    """Return steps by ascending load, their cautions, and the largest contact with its extra."""
    steps: list[Any] = []
    largest: tuple[ContactResult, Extra] | None = None
    for result in check_same_pair(contacts, what):
        step, cautions, extra = evaluate(result)
        steps.append((step, (*result.cautions, *cautions)))
        if largest is None or result.load >= largest[0].load:
            largest = result, extra
    assert largest is not None
    steps.sort(key=lambda item: item[0].load)
    judged = over_loads([(step.load, cautions) for step, cautions in steps], "N")
    return tuple(step for step, _ in steps), judged, *largest


def require_alike(
    first: Pair, other: Pair, argument: str, *advice: Part, only_elastic: bool = False
) -> None:
    """Raise `InputError` for pairs of bodies that differ in more than their heights."""
    pixels = np.allclose(first.pixel, other.pixel, rtol=_PIXEL_TOLERANCE, atol=0)
    if first.shape != other.shape or not pixels:
        item, two = (
            f"{p.shape[0]} × {p.shape[1]} points of {format_lengths(p.pixel)}"
            for p in (first, other)
        )
        raise InputError(f"are of different grids, {item} and {two}", *advice, argument=argument)
    if first.boundary != other.boundary:
        text = f"differ in boundary, {first.boundary} and {other.boundary}"
        raise InputError(text, *advice, argument=argument)
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
    """Raise `InputError` for contacts of which one has a ceiling and another is elastic."""
    if first != other:
        raise InputError(
            "are partly with a ceiling and partly elastic; give contacts of one model",
            argument="contacts",
        )


def same_heights(first: Pair, second: Pair) -> bool:
    """Return whether two pairs on one grid have the same maps."""
    if (first.counter_surface is None) != (second.counter_surface is None):
        return False
    return all(
        item is two or np.array_equal(item, two, equal_nan=True)
        for item, two in (
            (first.surface.heights, second.surface.heights),
            (first.heights, second.heights),
        )
    )


def _constants(material: Material) -> str:
    """Return all constants of a material as text, without its name."""
    if math.isinf(material.young):
        return "rigid"
    parts = [f"E {format_engineering(material.young, 'Pa', 12)}", f"ν {material.poisson!r}"]
    for symbol, value in (("σ_Y", material.yield_strength), ("H", material.hardness)):
        if value is not None:
            parts.append(f"{symbol} {format_engineering(value, 'Pa', 12)}")
    if material.hardening is not None:
        parts.append(repr(material.hardening))
    return ", ".join(parts)


RIM = 3.0
"""Width of the rim, in autocorrelation lengths.

Beyond the edge of a free map there is no contact, which changes the local relation of pressure and
gap within the longest wavelength. On self-affine maps with a roll-off, this is about three lengths
Sal, and the inner part follows the relation of the periodic map to about 2 %, for any pressure at
the edge (``tests/physics/test_interface_law``).
"""

MIN_POINTS = 16
"""Minimum number of points along each side of the part of a map that gives a law."""

# Maximum share of each side that the rims may occupy.
_MAX_RIM_SHARE = 0.5

Window = tuple[slice, slice]


def window_of(pair: Pair) -> tuple[Window | None, float]:
    """Return the part of a map inside its rim, and the width of the rim [m]."""
    if min(pair.shape) < MIN_POINTS:
        ny, nx = pair.shape
        raise InputError(
            f"has {ny} × {nx} points: an interface law needs {MIN_POINTS} along each side",
            argument="surface",
        )
    free = pair.boundary.free_axes
    if not free:
        return None, 0.0
    length, _, _ = spectrum.texture(pair.initial_gap, pair.pixel)
    rim = RIM * length
    slices = [slice(0, points) for points in pair.shape]
    for axis in free:
        side = pair.size[axis]
        if math.isnan(rim) or 2 * rim > _MAX_RIM_SHARE * side:
            raise _nothing_left(pair, rim)
        margin = math.ceil(rim / pair.pixel[axis])
        slices[axis] = slice(margin, pair.shape[axis] - margin)
    if min(part.stop - part.start for part in slices) < MIN_POINTS:
        raise _nothing_left(pair, rim)
    return (slices[0], slices[1]), rim


def _nothing_left(pair: Pair, rim: float) -> InputError:
    wide = "without end" if math.isnan(rim) else f"of {format_engineering(rim, 'm', 3)}"
    return InputError(
        f"of {format_lengths(pair.size)} is too small for a free boundary: a rim {wide} along each "
        f"edge, {RIM:.0f} autocorrelation lengths, leaves less than half of a side; remove long "
        f"waves with {ArgumentRef('l')}, give a larger map, or "
        f"{ArgumentRef('boundary', 'periodic')}",
        argument="surface",
    )
