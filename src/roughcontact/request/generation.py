"""The command ``generate``: a surface made from its parameters."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError
from roughcontact.formats import export
from roughcontact.formats.export import Kind
from roughcontact.request import options, outputs, parsing
from roughcontact.request.option import LENGTH, PICTURES, Option, Panel, file, files
from roughcontact.request.outputs import Say, Writing
from roughcontact.request.task import Command, Given, Values

if TYPE_CHECKING:
    from roughcontact.surface.surface import Surface

_LARGEST_SEED = 2**63 - 1

SIZE = Option(
    "size", Panel.MAP, "LENGTHS", 'Sides (y, x) of the map: "0.5 mm x 1 mm", or one of a square.',
    parsing.words, None, "Sides (y × x)",
)  # fmt: skip
POINTS = Option(
    "points", Panel.MAP, "NUMBER|NYxNX", "Points of the map; default: 1024.", parsing.points,
    (1024, 1024),
)  # fmt: skip
SEED = Option(
    "seed", Panel.MAP, "NUMBER", "Seed of the random waves: another seed, another surface of the "
    "same kind; default: 0.", parsing.counted(0, _LARGEST_SEED), 0,
)  # fmt: skip
SQ = Option(
    "sq", Panel.HEIGHTS, "LENGTH", 'Root-mean-square height Sq, such as "0.4 um".', LENGTH, None,
    arguments=("Sq",),
)  # fmt: skip
SSK = Option(
    "ssk", Panel.HEIGHTS, "NUMBER", "Skewness Ssk: below 0 plateaus with dales, above 0 peaks on a "
    "plain; default: 0.", parsing.number, 0.0, arguments=("Ssk",),
)  # fmt: skip
SKU = Option(
    "sku", Panel.HEIGHTS, "NUMBER", "Kurtosis Sku; default: 3 + 1.5 Ssk², which is 3 of a Gaussian "
    "surface.", parsing.number, None, arguments=("Sku",),
)  # fmt: skip
SAL = Option(
    "sal", Panel.TEXTURE, "LENGTH", 'Autocorrelation length Sal, such as "12 um"; this, --rolloff '
    "or --sdq.", LENGTH, None, arguments=("Sal",),
)  # fmt: skip
SDQ = Option(
    "sdq", Panel.TEXTURE, "NUMBER", "Root-mean-square slope Sdq; with --sal or --rolloff the "
    "shortest wave follows from it.", parsing.number, None, arguments=("Sdq",),
)  # fmt: skip
ROLLOFF = Option(
    "rolloff", Panel.TEXTURE, "LENGTH", "Wavelength above which the spectrum is flat.", LENGTH,
    None, arguments=("rolloff_wavelength",),
)  # fmt: skip
CUTOFF = Option(
    "cutoff", Panel.TEXTURE, "LENGTH", "Shortest wavelength; default: 8 pixels.", LENGTH, None,
    arguments=("cutoff_wavelength",),
)  # fmt: skip
HURST = Option(
    "hurst", Panel.TEXTURE, "NUMBER", "Hurst exponent, from 0 (rough to the finest scale) to 1; "
    "default: 0.8.", parsing.number, 0.8,
)  # fmt: skip
STR = Option(
    "str", Panel.TEXTURE, "NUMBER", "Texture aspect ratio Str, from near 0 (directional) to 1 (the "
    "same in all directions); default: 1.", parsing.number, None, arguments=("Str",),
)  # fmt: skip
LAY = Option(
    "lay", Panel.TEXTURE, "DEGREES", "Direction of the lay, counter-clockwise from x; default: 0.",
    parsing.number, 0.0,
)  # fmt: skip
HONING = Option(
    "honing", Panel.TEXTURE, "DEGREES", "Angle between the two families of grooves of a honed "
    "surface, either side of the lay.", parsing.number, None,
)  # fmt: skip
TURNING = Option(
    "turning", Panel.TEXTURE, "FEED,RADIUS", 'Grooves of turning along the lay: feed and nose '
    'radius, such as "0.1 mm, 0.8 mm".', parsing.lengths, None,
)  # fmt: skip
OUTPUT = files(
    "output",
    f"Write the map: {export.format_list_text(Kind.SURFACE)}; may be repeated.",
    export.suffixes(Kind.SURFACE),
)
FIGURE = file("figure", "FILE", "Draw the map as PNG, SVG or PDF.", PICTURES)
_PARAMETERS: tuple[Option[Any], ...] = (
    SQ, SSK, SKU, SAL, SDQ, ROLLOFF, CUTOFF, HURST, STR, LAY, HONING, TURNING,
)  # fmt: skip


def run_generate(specified: Given, say: Say) -> tuple[Surface, list[Path]]:
    """Return the surface that options in words ask for, and the files that it was written to."""
    from roughcontact.formats.scale import pixel_of
    from roughcontact.surface.generation import generate

    requested = COMMAND.read(specified)
    places = _places(requested)
    if requested[SQ] is None:
        raise InputError("must be given: how high the surface is", argument="Sq")
    shape = requested[POINTS]
    pixel = pixel_of(requested[SIZE], shape)
    say("generating the surface")
    arguments = {(item.arguments or (item.argument,))[0]: requested[item] for item in _PARAMETERS}
    surface = generate(shape, pixel, seed=requested[SEED], **arguments)
    files: list[Writing] = [
        (path, _drawn(surface) if option is FIGURE else partial(export.save_surface, surface))
        for option, path in places
    ]
    return surface, outputs.write(files, say)


def _places(requested: Values) -> list[tuple[Option[Any], Path]]:
    """Return the files to write, each with the option that asks for it; refuse those that fail."""
    places = [(OUTPUT, path) for path in requested[OUTPUT]]
    places += [] if requested[FIGURE] is None else [(FIGURE, requested[FIGURE])]
    for option, path in places:
        outputs.check_suffix(path, option)
        outputs.check_place(path, option.name)
    return places


def _drawn(surface: Surface) -> Any:
    def draw() -> Any:
        from roughcontact.plots import maps

        return maps.surface(surface)

    return outputs.saver(draw)


COMMAND = Command(
    "generate",
    """Make a rough surface from its parameters: Sq, Sal or Sdq, Str, Ssk, Sku, lay.

The same seed gives the same surface. What the map has is printed beside what was asked for.

\b
Example:
roughcontact generate --size "0.5 mm" --sq "0.4 um" --sal "12 um" --ssk -0.8 \\
    --output honed.x3p
""",
    (SIZE, POINTS, SEED, *_PARAMETERS, OUTPUT, FIGURE, *options.SHOWN),
)
