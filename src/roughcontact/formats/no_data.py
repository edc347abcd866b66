"""Codes for points without data in maps whose format has no marker for them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.errors import ArgumentRef, InputError, input_error
from roughcontact.surface.cleaning import fill_mode
from roughcontact.units import count_noun

AUTO, NONE = "auto", "none"
"""Values of ``no_data``: mark all codes that are recognized, or none."""

# Relative distance of equal values, for single precision and codes given with six digits.
_TOLERANCE = 2e-6
# Smallest integers of 16 and 32 bits, perhaps in decimal fractions of a unit, and their largest.
_INTEGERS = (3.2768, 3.2767, 2.147483648)
_NINES = tuple(10.0**digits - 1 for digits in range(3, 10))
_MIN_CODE = 1e-9
# From here on powers of ten, and then all values, have no other meaning: 1e10, 1.70141e38, 3.4e38.
_MIN_POWER, _MIN_HUGE = 1e10, 1e30
# Distance to the next value over the range of all others; zero is a usual height.
_DISTANCE, _DISTANCE_OF_ZERO = 0.25, 1.0


def parse_no_data(value: object, argument: str = "no_data") -> float | str | None:
    """Return a code as a number, or one of `AUTO`, `NONE` and None."""
    if value is None or value in (AUTO, NONE):
        return value if value is None else str(value)
    try:
        code = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        code = math.nan
    if isinstance(value, bool) or not math.isfinite(code):
        raise input_error(
            argument,
            value,
            f"must be the number in the file that marks points without data, {AUTO} or {NONE}",
        )
    return code


def find_code(heights: Array, unit: float) -> tuple[float, int] | None:
    """Return the value, in units of the file, that marks points without data, and their number.

    A code is a known one, occurs more than once, and is far from all other values.
    """
    values = heights[np.isfinite(heights)]
    for extreme in _extremes(values):
        code = extreme / unit
        if not _is_known(code):
            continue
        marked = _are_equal(values, extreme)
        count, others = int(np.count_nonzero(marked)), values[~marked]
        low, high = _extremes(others)
        distance = max(low - extreme, extreme - high)
        required = _DISTANCE_OF_ZERO if extreme == 0 else _DISTANCE
        if count > 1 and low < high and distance > required * (high - low):
            return code, count
    return None


def mark_missing(
    name: str, heights: Array, unit: float, no_data: float | str | None
) -> tuple[Array, Mapping[float, int]]:
    """Return the heights of a file with NaN for codes, and the number of points of each code.

    Raises
    ------
    InputError
        If ``no_data`` is a number or None, and there is another code.
    """
    codes: dict[float, int] = {}
    if no_data == NONE:
        return heights, codes
    if isinstance(no_data, float):
        marked = _are_equal(heights, no_data * unit)
        codes[no_data] = int(np.count_nonzero(marked))
        heights = np.where(marked, np.nan, heights)
    while (found := find_code(heights, unit)) is not None:
        code, count = found
        if no_data != AUTO:
            remedy = AUTO if no_data is not None else float(format_code(code))
            raise InputError(
                f"{name} holds {format_code(code)} at {count_noun(count, 'point')}, far from all "
                "other heights: a code for missing data. Set them missing with ",
                ArgumentRef("no_data", remedy),
                " and, for example, ",
                ArgumentRef("missing", fill_mode(count / heights.size)),
                ", or keep the heights with ",
                ArgumentRef("no_data", NONE),
            )
        codes[code] = count
        heights = np.where(_are_equal(heights, code * unit), np.nan, heights)
    return heights, codes


def describe_codes(codes: Mapping[float, int]) -> tuple[str, ...]:
    """Return the marked points as text, one sentence per code."""
    return tuple(
        f"read: {count_noun(count, 'point')} at {format_code(code)} set missing"
        for code, count in codes.items()
    )


def format_code(code: float) -> str:
    """Return a code with the digits by which it is found."""
    return f"{code:.9g}"


def _extremes(values: Array) -> tuple[float, float]:
    """Return the smallest and the largest value; infinite without values."""
    return float(values.min(initial=math.inf)), float(values.max(initial=-math.inf))


def _is_known(code: float) -> bool:
    size = abs(code)
    if size == 0 or size >= _MIN_HUGE:
        return True
    if size < _MIN_CODE:
        return False
    digits = size / 10.0 ** math.floor(math.log10(size))
    text = f"{size:.12g}"
    if "." in text and len(text) > 5 and set(text) == {"9", "."}:
        return True
    known = (*_INTEGERS, *((1.0, 10.0) if size > 0.9 * _MIN_POWER else ()))
    return any(math.isclose(digits, value, rel_tol=_TOLERANCE) for value in known) or any(
        math.isclose(size, value, rel_tol=_TOLERANCE) for value in _NINES
    )


def _are_equal(heights: Array, value: float) -> NDArray[np.bool_]:
    equal: NDArray[np.bool_] = np.abs(heights - value) <= _TOLERANCE * abs(value)
    return equal
