"""The options of one run: one table behind the command line and project files."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from roughcontact.formats import export
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import parsing

MAP, BODIES, SOLVER, OUTPUT = "Map", "Bodies and load", "Solver", "Output"

LEVELS = ("plane", "quadric", "mean", "robust", "none")
HOLES = ("error", "fill", "mask", "crop")


@dataclass(frozen=True)
class Option:
    """One word of the command line and of project files.

    Parameters
    ----------
    panel : str
        Heading under which the help lists it.
    metavar : str
        What is to be given; empty for a flag.
    help : str
        What it does.
    parse : callable
        ``parse(text, name)`` returns the value; its errors start with the name.
    many : bool
        Whether it may be given several times.
    """

    panel: str
    metavar: str
    help: str
    parse: Callable[[str, str], Any]
    many: bool = False


OPTIONS: dict[str, Option] = {
    "format": Option(
        MAP, "NAME", "Format of the file; by default its suffix decides.", parsing.words,
    ),
    "channel": Option(
        MAP, "NAME|INDEX", "Height channel; by default the file's own choice.", parsing.words
    ),
    "unit": Option(MAP, "UNIT", "Unit of the heights, if the file gives none: um.", parsing.words),
    "size": Option(
        MAP, "LENGTHS",
        'Sides (y, x) of the map, if the file gives none or there is none: "0.1 mm x 0.2 mm".',
        parsing.words,
    ),
    "tip-radius": Option(
        MAP, "LENGTH", 'Radius of the tip of a scanning probe, such as "10 nm": tells below which '
        "scale the map shows the tip.", parsing.quantity("length"),
    ),
    "points": Option(
        MAP, "NUMBER|NYxNX", "Grid of a nominal --body that needs no FILE, such as 256.",
        parsing.points
    ),
    "crop": Option(
        MAP, "ROWS,COLUMNS", "Part of the map to keep, such as 0:256,100:356.", parsing.window,
    ),
    "outliers": Option(
        MAP, "NUMBER",
        "Take points further than so many robust standard deviations from their surroundings as "
        "missing, such as 6.", parsing.number,
    ),
    "level": Option(
        MAP, "|".join(LEVELS),
        "What is fitted and subtracted; plane (least squares) by default.", parsing.choice(*LEVELS),
    ),
    "form": Option(
        MAP, "FORM",
        'Form to remove by least squares: sphere, cylinder or "polynomial 4".', parsing.form,
    ),
    "holes": Option(
        MAP, "|".join(HOLES),
        "Missing points: error (default) refuses them, fill interpolates smoothly, mask "
        "lets them never touch, crop keeps the largest rectangle without them.",
        parsing.choice(*HOLES),
    ),
    "s-filter": Option(
        MAP, "LENGTH", 'Remove waves shorter than this (ISO 16610-61), such as "2.5 um".',
        parsing.quantity("length"),
    ),
    "l-filter": Option(
        MAP, "LENGTH", 'Remove waves longer than this, such as "80 um".', parsing.quantity("length")
    ),
    "pixel": Option(
        MAP, "LENGTH", 'Resample (cubic splines) to about this pixel, such as "0.5 um".',
        parsing.quantity("length"),
    ),
    "rotate": Option(MAP, "DEGREES", "Turn counter-clockwise by a multiple of 90.", parsing.turns),
    "load": Option(
        BODIES, "FORCE", 'Normal load, such as "1 N"; this or --approach.',
        parsing.quantity("force")
    ),
    "approach": Option(
        BODIES, "LENGTH", 'Approach of the bodies from the first touch, such as "1 um".',
        parsing.quantity("length"),
    ),
    "material": Option(
        BODIES, "NAME",
        "Material of the catalogue, such as 100Cr6; see roughcontact materials. Or give --young, "
        "--poisson and --yield-strength, which also replace single values of it.", parsing.material,
    ),
    "load-point": Option(
        BODIES, "LENGTHS",
        'Let the bodies tilt until the load acts at this offset (y, x) from the middle of the map, '
        'such as "0 um, 5 um"; they keep their angle without.', parsing.offset,
    ),
    "young": Option(
        BODIES, "PRESSURE", 'Young\'s modulus, such as "210 GPa".', parsing.quantity("pressure")
    ),
    "poisson": Option(BODIES, "NUMBER", "Poisson's ratio, such as 0.3.", parsing.number),
    "yield-strength": Option(
        BODIES, "PRESSURE", 'Yield strength, such as "1 GPa".', parsing.quantity("pressure")
    ),
    "counter-material": Option(
        BODIES, "NAME", "Material of the counter-body; it is rigid without.", parsing.material
    ),
    "counter-young": Option(
        BODIES, "PRESSURE", "Young's modulus of the counter-body.", parsing.quantity("pressure")
    ),
    "counter-poisson": Option(
        BODIES, "NUMBER", "Poisson's ratio of the counter-body.", parsing.number,
    ),
    "counter-yield-strength": Option(
        BODIES, "PRESSURE", "Yield strength of the counter-body.", parsing.quantity("pressure")
    ),
    "body": Option(
        BODIES, "FORM",
        'Nominal form under the roughness, or alone with --points and --size: "sphere 10 mm", '
        '"cylinder 5 mm 90 deg", "ellipsoid 10 mm 4 mm", "punch 20 um", "cone 0.01", "wedge 0.01".',
        parsing.body,
    ),
    "counter-body": Option(
        BODIES, "FORM", "Nominal form of the counter-body; a flat without.", parsing.body
    ),
    "counter-surface": Option(
        BODIES, "FILE",
        "Height map of the counter-body, laid on point by point, so on the same grid unless "
        "--align is given.", parsing.path,
    ),
    "align": Option(
        BODIES, "",
        "Bring both maps to one grid, centre on centre, and keep what both cover.", parsing.flag,
    ),
    "offset": Option(
        BODIES, "LENGTHS", 'Shift (y, x) of the aligned counter-map: "0 um, 5 um".', parsing.offset
    ),
    "angle": Option(
        BODIES, "DEGREES", "Turn of the aligned counter-map, counter-clockwise.", parsing.number
    ),
    "mirror": Option(
        BODIES, "", "Mirror the aligned counter-map, as one measured from its front needs.",
        parsing.flag
    ),
    "ceiling": Option(
        BODIES, "PRESSURE",
        'Largest pressure, such as "3 GPa", or a hardness, such as "62 HRC"; or auto (default): '
        "3 times the smaller yield strength, or the hardness where there is none; or none: purely "
        "elastic.", parsing.ceiling,
    ),
    "model": Option(
        BODIES, "ceiling|volume",
        "ceiling (default): pressures up to the ceiling; volume: plastic strain in the volume, "
        "which takes seconds to minutes.", parsing.choice("ceiling", "volume"),
    ),
    "increments": Option(
        BODIES, "NUMBER", "Steps to the load of the volume model; 10 by default.", parsing.whole
    ),
    "unload": Option(
        BODIES, "", "Take the bodies of the volume model apart in the end: what stays.",
        parsing.flag
    ),
    "hardening": Option(
        BODIES, "LAW",
        'Of the rough body: "linear 2 GPa" (modulus) or "swift 945 MPa 20 0.121" (B, C, n of '
        'B (C + 1e6 e)^n); for the volume model, and for the ceiling that is recommended.',
        parsing.hardening,
    ),
    "boundary": Option(
        BODIES, "|".join(Boundary),
        "free (default): the map is all there is; periodic: it repeats; periodic-x, periodic-y: it "
        "repeats along x, or along y, and ends along the other.",
        parsing.choice(*Boundary),
    ),
    "tolerance": Option(
        SOLVER, "NUMBER",
        "Certificate to reach; 1e-6 by default, 1e-4 in single precision. Of the volume model the "
        "residual of the plastic strain; 1e-4 by default.", parsing.number,
    ),
    "max-iterations": Option(
        SOLVER, "NUMBER",
        "Most convolutions on any one grid; 500 by default. Of the volume model most iterations at "
        "one load; 150 by default.", parsing.whole,
    ),
    "precision": Option(
        SOLVER, "double|single",
        "single needs two thirds of the memory; double by default, single for the volume model.",
        parsing.choice("double", "single"),
    ),
    "study": Option(
        SOLVER, "",
        "Solve again on coarser and finer grids, with filters and other ceilings, and tell what "
        "depends on them.", parsing.flag,
    ),
    "output": Option(
        OUTPUT, "FILE",
        f"Write the result: {export.told(export.Kind.CONTACT, export.Kind.VOLUME)}; may be given "
        "again.", parsing.path, many=True,
    ),
    "folder": Option(
        OUTPUT, "FOLDER",
        "Where the volume model keeps every load that is reached, to go on later.", parsing.path,
    ),
    "report": Option(
        OUTPUT, "FILE.html", "Write a report with figures into one HTML file.", parsing.path
    ),
    "figures": Option(
        OUTPUT, "FOLDER|PREFIX",
        "Write surface, pressure, contact, gap and histogram (of the volume model sections and "
        "profiles instead of the contact) as PNG into an existing folder, or with this start of "
        "their names; with .svg or .pdf at its end in that format.", parsing.words,
    ),
}  # fmt: skip
"""Every option that describes one run, in the order of the help."""


_ARGUMENT = re.compile(
    r"""\b(format|channel|unit|size|precision)=("[^"]*"|'[^']*')?"""
    r"|^(format|unit|size|load|approach|ceiling|tolerance|boundary|precision|folder)\b(?= |$)"
    r"|\b(max_iterations|counter_surface|tip_radius)\b"
)


def in_options(message: str) -> str:
    """Return a message of the library in the words of the command line."""

    def option(match: re.Match[str]) -> str:
        keyword, value, leading, underscored = match.groups()
        name = (keyword or leading or underscored).replace("_", "-")
        return f"--{name} {value}" if value else f"--{name}"

    return _ARGUMENT.sub(option, message)
