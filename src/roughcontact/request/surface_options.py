"""The options of surfaces without a file: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from roughcontact.formats import export
from roughcontact.formats.export import Kind
from roughcontact.request import parsing
from roughcontact.request.option import LENGTH, MAP, OUTPUT, PICTURES, Option

GENERATE = "generate"
"""The command."""

HEIGHTS, TEXTURE = "Heights", "Texture"
"""Headings of its help, beside those that all commands share."""

SURFACES = export.suffixes(Kind.SURFACE)
_LARGEST_SEED = 2**63 - 1


def _option(
    name: str, panel: str, metavar: str, text: str, parse: Callable[[str, str], Any], **more: Any
) -> Option:
    return Option(name, panel, metavar, text, parse, (GENERATE,), **more)


OPTIONS = (
    _option(
        "size", MAP, "LENGTHS", 'Sides (y, x) of the map: "0.5 mm x 1 mm", or one of a square.',
        parsing.words,
    ),
    _option(
        "points", MAP, "NUMBER|NYxNX", "Points of the map; default: 1024.", parsing.points,
        default=(1024, 1024),
    ),
    _option(
        "seed", MAP, "NUMBER", "Seed of the random waves: another seed, another surface of the "
        "same kind; default: 0.", parsing.counted(0, _LARGEST_SEED), default=0,
    ),
    _option(
        "sq", HEIGHTS, "LENGTH", 'Root-mean-square height Sq, such as "0.4 um".', LENGTH,
        arguments=("Sq",),
    ),
    _option(
        "ssk", HEIGHTS, "NUMBER", "Skewness Ssk: below 0 plateaus with dales, above 0 peaks on a "
        "plain; default: 0.", parsing.number, default=0.0, arguments=("Ssk",),
    ),
    _option(
        "sku", HEIGHTS, "NUMBER", "Kurtosis Sku; default: 3 + 1.5 Ssk², which is 3 of a Gaussian "
        "surface.", parsing.number, arguments=("Sku",),
    ),
    _option(
        "sal", TEXTURE, "LENGTH", 'Autocorrelation length Sal, such as "12 um"; this, --rolloff '
        "or --sdq.", LENGTH, arguments=("Sal",),
    ),
    _option(
        "sdq", TEXTURE, "NUMBER", "Root-mean-square slope Sdq; with --sal or --rolloff the "
        "shortest wave follows from it.", parsing.number, arguments=("Sdq",),
    ),
    _option(
        "rolloff", TEXTURE, "LENGTH", "Wavelength above which the spectrum is flat.", LENGTH,
        arguments=("rolloff_wavelength",),
    ),
    _option(
        "cutoff", TEXTURE, "LENGTH", "Shortest wavelength; default: 8 pixels.", LENGTH,
        arguments=("cutoff_wavelength",),
    ),
    _option(
        "hurst", TEXTURE, "NUMBER", "Hurst exponent, from 0 (rough to the finest scale) to 1; "
        "default: 0.8.", parsing.number, default=0.8,
    ),
    _option(
        "str", TEXTURE, "NUMBER", "Texture aspect ratio Str, from near 0 (directional) to 1 (the "
        "same in all directions); default: 1.", parsing.number, arguments=("Str",),
    ),
    _option(
        "lay", TEXTURE, "DEGREES", "Direction of the lay, counter-clockwise from x; default: 0.",
        parsing.number, default=0.0,
    ),
    _option(
        "honing", TEXTURE, "DEGREES", "Angle between the two families of grooves of a honed "
        "surface, either side of the lay.", parsing.number,
    ),
    _option(
        "turning", TEXTURE, "FEED,RADIUS", 'Grooves of turning along the lay: feed and nose '
        'radius, such as "0.1 mm, 0.8 mm".', parsing.lengths,
    ),
    _option(
        "output", OUTPUT, "FILE", f"Write the map: {export.told(Kind.SURFACE)}; may be repeated.",
        parsing.path, default=(), many=True, suffixes=SURFACES,
    ),
    _option(
        "figure", OUTPUT, "FILE", "Draw the map as PNG, SVG or PDF.", parsing.path,
        suffixes=PICTURES,
    ),
)  # fmt: skip
"""What `generate` takes, beside what other commands take as well."""
