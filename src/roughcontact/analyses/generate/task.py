"""The command ``generate``: a random surface with given roughness parameters."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError
from roughcontact.formats import export
from roughcontact.request import options, outputs, parsing
from roughcontact.request.options import LENGTH, Option, Panel
from roughcontact.request.outputs import Say, Writing
from roughcontact.request.task import Command, Given, OptionValues

if TYPE_CHECKING:
    from roughcontact.surface.surface import Surface

_MAX_SEED = 2**63 - 1

SIZE = Option.value(
    "size",
    parsing.as_text.with_metavar("LENGTHS"),
    'Side lengths (y, x): "0.5 mm x 1 mm", or one of a square.',
    Panel.MAP,
    label="Side lengths (y × x)",
)
POINTS = Option(
    "points",
    parsing.points,
    "Grid points, e.g. 512 or 256x1024; default: 1024.",
    (1024, 1024),
    Panel.MAP,
)
SEED = Option(
    "seed",
    parsing.int_parser(0, _MAX_SEED),
    "Random seed; each seed gives another surface; default: 0.",
    0,
    Panel.MAP,
    arguments=("rng",),
)
SQ = Option.symbol("Sq", LENGTH, 'Root-mean-square height Sq: "0.4 um".', Panel.HEIGHTS)
SSK = Option.symbol(
    "Ssk",
    parsing.number,
    "Skewness Ssk: below 0 plateaus with valleys, above 0 peaks; default: 0.",
    Panel.HEIGHTS,
    default=0.0,
)
SKU = Option.symbol(
    "Sku", parsing.number, "Kurtosis Sku; default: 3 + 1.5 Ssk² (Gaussian: 3).", Panel.HEIGHTS
)
SAL = Option.symbol(
    "Sal", LENGTH, 'Autocorrelation length Sal: "12 um"; or --rolloff or --sdq.', Panel.TEXTURE
)
SDQ = Option.symbol(
    "Sdq",
    parsing.number,
    "Root-mean-square slope Sdq; with --sal or --rolloff it sets the cutoff.",
    Panel.TEXTURE,
)
ROLLOFF = Option.value(
    "rolloff",
    LENGTH,
    'Roll-off wavelength; the spectrum is flat above: "50 um".',
    Panel.TEXTURE,
    arguments=("rolloff_wavelength",),
)
CUTOFF = Option.value(
    "cutoff",
    LENGTH,
    'Shortest wavelength: "4 um"; default: 8 pixels.',
    Panel.TEXTURE,
    arguments=("cutoff_wavelength",),
)
HURST = Option(
    "hurst",
    parsing.number,
    "Hurst exponent, 0 (rough to the finest scale) to 1; default: 0.8.",
    0.8,
    Panel.TEXTURE,
)
STR = Option.symbol(
    "Str",
    parsing.number,
    "Texture aspect ratio Str, 0 (directional) to 1 (isotropic); default: 1.",
    Panel.TEXTURE,
)
LAY = Option(
    "lay",
    parsing.DEGREES,
    "Lay direction, degrees counterclockwise from x; default: 0.",
    0.0,
    Panel.TEXTURE,
)
HONING = Option.value(
    "honing",
    parsing.DEGREES,
    "Honing angle between the two groove families, degrees: 45.",
    Panel.TEXTURE,
)
TURNING = Option.value(
    "turning",
    parsing.lengths.with_metavar("FEED,RADIUS"),
    'Turning grooves along the lay, feed and nose radius: "0.1 mm, 0.8 mm".',
    Panel.TEXTURE,
)
OUTPUT = Option.output(f"Map: {export.list_formats(export.SURFACE)}", export.SURFACE.suffixes)
FIGURE = Option.figure("the map")
_TEXTURE: tuple[Option[Any], ...] = (ROLLOFF, CUTOFF, HURST, STR, LAY, HONING, TURNING)
_PARAMETERS = (SEED, SQ, SSK, SKU, SAL, SDQ, *_TEXTURE)


def run_generate(specified: Given, say: Say) -> tuple[Surface, list[Path]]:
    """Generate the surface of the given text options; return it and the written files."""
    from roughcontact.formats.source import pixel_of
    from roughcontact.surface.generation import generate

    requested = COMMAND.parse_values(specified)
    places = _output_places(requested)
    if requested[SQ] is None:
        raise InputError("must be given: root-mean-square height of the surface", argument="Sq")
    shape = requested[POINTS]
    pixel = pixel_of(requested[SIZE], shape)
    say("generating the surface")
    arguments = {(item.arguments or (item.argument,))[0]: requested[item] for item in _PARAMETERS}
    surface = generate(shape, pixel, **arguments)
    draw = outputs.figure_saver(lambda: surface.plot())
    save = partial(export.save_surface, surface)
    files: list[Writing] = [(path, draw if option is FIGURE else save) for option, path in places]
    return surface, outputs.write_files(files, say)


def _output_places(requested: OptionValues) -> list[tuple[Option[Any], Path]]:
    """Return options and paths of the files to write; raise an error if one is unwritable."""
    places = [(OUTPUT, path) for path in requested[OUTPUT]]
    places += [] if requested[FIGURE] is None else [(FIGURE, requested[FIGURE])]
    for option, path in places:
        outputs.check_suffix(path, option)
        outputs.check_place(path, option.name)
    return places


COMMAND = Command(
    "generate",
    """Generate a rough surface with given roughness parameters.

The same seed gives the same surface. Requested and measured parameters are printed.

\b
Example:
roughcontact generate --size "0.5 mm" --sq "0.4 um" --sal "12 um" --ssk -0.8 \\
    --output honed.x3p
""",
    (SIZE, POINTS, *_PARAMETERS, OUTPUT, FIGURE, *options.SHOWN),
)
