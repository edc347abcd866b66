"""Units, sizes and plausible scales of what is read."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import units
from roughcontact.errors import ArgumentRef, FormatError, InputError
from roughcontact.formats.source import Asked
from roughcontact.surface.grid import WIDTH
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]

# Units of length as instrument files spell them, where pint does not know the spelling or knows
# another meaning ("A" is the ampere to pint).
_FILE_UNITS = {"A": "angstrom", "Å": "angstrom", "~m": "um"}

# Plausible scales [m]: from a few atoms to a machine bed.
_SIDE_RANGE = (1e-9, 10.0)
_PIXEL_RANGE = (1e-12, 1e-2)
_HEIGHT_OVER_SIDE = 100.0


def refuse_unit(path: Path, requested: Asked) -> None:
    """Raise `InputError` where a unit is given that a file says itself."""
    if requested.unit is not None:
        raise InputError(
            f"{path.name} gives its unit itself; leave out ", ArgumentRef("unit", requested.unit)
        )


def asked_pixel(
    path: Path, stated: tuple[float, float] | None, shape: tuple[int, ...], requested: Asked
) -> tuple[float, float]:
    """Return the pixel of a map, from its file or from whoever reads it."""
    if stated is not None and requested.size is None:
        return stated
    if stated is not None and not requested.override_size:
        raise InputError(
            f"{path.name} gives its size itself; leave out ", ArgumentRef("size", requested.size),
            ", or give ", ArgumentRef("override_size", True), " as well if the file is wrong",
        )  # fmt: skip
    ny, nx = shape
    return pixel_of(requested.size, (ny, nx), path.name)


def unit_in_meters(path: Path, unit: str | None) -> float:
    """Return a unit of length as files spell it [m]; without one, complain."""
    if unit is None:
        raise InputError(
            f"{path.name} gives no unit of the heights; give it, e.g. ", ArgumentRef("unit", "um")
        )
    return units.parse(f"1 {_FILE_UNITS.get(unit, unit)}", "length", "unit")


def is_length(path: Path, unit: str) -> bool:
    """Return whether a unit as a file spells it is one of length."""
    try:
        unit_in_meters(path, unit)
    except InputError:
        return False
    return True


def pixel_of(
    size: units.Quantities | str | None, shape: tuple[int, int], name: str = "the map"
) -> tuple[float, float]:
    """Return the pixel of a grid over an outline."""
    ny, nx = shape
    if size is None and ny == 1:
        raise InputError(
            f"{name} is a profile and gives no length; give it, e.g. ", ArgumentRef("size", "4 mm")
        )
    if size is None:
        raise InputError(
            f"{name} gives no lengths of its sides; give them in the order (y, x), e.g. ",
            ArgumentRef("size", "0.1 mm x 0.2 mm"),
        )
    if isinstance(size, str):
        # An x before no number is part of a unit.
        parts = re.split(r"\s*[x×]\s*(?=[-+\u2212.\d])", size.strip())
        sides = tuple(units.parse(part, "length", "size") for part in parts)
    else:
        try:
            specified = np.asarray(units.quantity(size, "length", "size"), dtype=float)
            sides = tuple(float(side) for side in np.atleast_1d(specified))
        except (TypeError, ValueError):
            raise InputError(
                f"must be a pair (y, x) in metres, got {size!r}", argument="size", value=size
            ) from None
    if ny == 1:
        # The one side of a profile. A map that was cut off in its first row is none.
        if len(sides) == 2 and sides[0] != WIDTH:
            length = units.engineering(sides[-1], "m")
            raise InputError(
                f"gives two sides, {size!r}, but {name} is a single line of heights; a profile has "
                "its length alone, ", ArgumentRef("size", length),
                ", and a map more lines: was it cut off?",
                argument="size", value=size,
            )  # fmt: skip
        sides = (WIDTH, *sides[-1:])
    elif len(sides) == 1 and ny == nx:
        sides *= 2
    if len(sides) != 2:
        raise InputError(
            f"must give both sides (y, x) of a grid of {ny} × {nx} points, got {size!r}; "
            "write e.g. '0.1 mm x 0.2 mm'",
            argument="size",
            value=size,
        )
    if not all(0 < side < math.inf for side in sides):
        raise InputError(f"must be positive and finite, got {size!r}", argument="size", value=size)
    return sides[0] / ny, sides[1] / nx


def in_metres(values: NDArray[Any], metre: float) -> Array:
    """Return values of some unit in metres, locked: a `Surface` takes them as they are."""
    # Damaged numbers overflow, or are NaN of the signalling kind: `Surface` judges the outcome.
    with np.errstate(all="ignore"):
        heights: Array = np.array(values, dtype=np.float64, order="C")
        heights *= metre
    heights.flags.writeable = False
    return heights


def check_scale(path: Path, surface: Surface) -> None:
    """Refuse scales that no measured map has."""
    top, bottom = float(np.nanmax(surface.heights)), float(np.nanmin(surface.heights))
    first = int(surface.is_profile)
    check_lengths(path, surface.size[first:], surface.pixel[first:], (bottom, top))


def check_lengths(
    path: Path, sides: tuple[float, ...], pixel: tuple[float, ...], heights: tuple[float, float]
) -> None:
    """Refuse sides, pixels, or smallest and largest heights [m] that no measured map has."""
    what = "check the unit and the size in the file"
    for name, counted, (low, high) in (
        ("sides (y, x)", sides, _SIDE_RANGE),
        ("pixel (dy, dx)", pixel, _PIXEL_RANGE),
    ):
        if not all(low <= value <= high for value in counted):
            raise FormatError(
                f"{path.name} was read with {name} of {units.lengths(counted)}, which is outside "
                f"{units.engineering(low, 'm')} to {units.engineering(high, 'm')}; {what}, or "
                "replace a size that the file has wrong by ",
                ArgumentRef("size", "0.1 mm x 0.2 mm"),
                " and ",
                ArgumentRef("override_size", True),
            )
    bottom, top = heights
    span, longest = top - bottom, max(sides)
    if span > _HEIGHT_OVER_SIDE * longest:
        raise FormatError(
            f"{path.name} was read with heights that span {units.engineering(span, 'm')} on sides "
            f"of {units.engineering(longest, 'm')}; {what}, or mark outliers as missing"
        )
    if max(top, -bottom) > _SIDE_RANGE[1]:
        raise FormatError(
            f"{path.name} was read with heights from {units.engineering(bottom, 'm')} to "
            f"{units.engineering(top, 'm')}, further than {units.engineering(_SIDE_RANGE[1], 'm')} "
            f"from zero; {what}"
        )
