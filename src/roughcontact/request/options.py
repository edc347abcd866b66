"""The options that tasks share, in groups: all that list a group have what stands in it."""

from __future__ import annotations

from typing import Any

from roughcontact import memory
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import parsing
from roughcontact.request.option import (
    LENGTH,
    NEEDS,
    ONE_OF,
    PRESSURE,
    Option,
    Panel,
    Rule,
    file,
    flag,
)

LEVELS = ("plane", "quadric", "mean", "robust", "none")
MISSING_KNOWN = ("error", "fill", "fill-all", "mask", "crop")
ITERATIONS = parsing.counted(1, memory.ITERATIONS)

# Which maps

GROUP: Option[tuple[tuple[str, tuple[str, ...]], ...]] = Option(
    "group", Panel.MAP, "NAME=FILE[,FILE…]",
    'Maps of one surface, such as ground=a.opd,b.opd or "ground=ground*.opd"; may be repeated. '
    "Files without a group are maps of one surface.", parsing.groups, (), many=True,
    arguments=("maps",),
)  # fmt: skip

# How a file is read

FORMAT = Option(
    "format", Panel.MAP, "NAME", "Format of the file; default: told by its suffix.",
    parsing.words, None, prepares=True,
)  # fmt: skip
CHANNEL = Option(
    "channel", Panel.MAP, "NAME|INDEX", "Height channel; default: the one the file proposes.",
    parsing.words, None, prepares=True, whole_map=False,
)  # fmt: skip
UNIT = Option(
    "unit", Panel.MAP, "UNIT",
    'Unit of the heights, if the file gives none, such as um; of a profile "mm, um", positions '
    "first.",
    parsing.words, None, "Unit of the heights", prepares=True, whole_map=False,
)  # fmt: skip
SIZE = Option(
    "size", Panel.MAP, "LENGTHS",
    'Sides (y, x) of the map, if there is no file or it gives none: "0.1 mm x 0.2 mm".',
    parsing.words, None, "Sides (y × x)", prepares=True, whole_map=False,
)  # fmt: skip
OVERRIDE_SIZE = flag(
    "override-size", Panel.MAP,
    "Take --size though the file gives one, where that is wrong; the preparation records both.",
    label="Take these sides though the file tells others", prepares=True, whole_map=False,
)  # fmt: skip
READING = (FORMAT, CHANNEL, UNIT, SIZE, OVERRIDE_SIZE)

# How a map is prepared

TIP_RADIUS = Option(
    "tip-radius", Panel.MAP, "LENGTH",
    'Radius of the tip of a scanning probe, such as "10 nm", to tell below which scale the map '
    "shows the tip.", LENGTH, None, "Tip radius of the probe",
)  # fmt: skip
POINTS = Option(
    "points", Panel.MAP, "NUMBER|NYxNX", "Grid of a nominal --body without a FILE, such as 256.",
    parsing.points, None, prepares=True,
)  # fmt: skip
CROP = Option(
    "crop", Panel.MAP, "ROWS,COLUMNS", "Part of the map to keep, such as 0:256,100:356.",
    parsing.window, None, "Part to keep (rows, columns)", prepares=True,
)  # fmt: skip
OUTLIERS = Option(
    "outliers", Panel.MAP, "NUMBER",
    "Treat points as missing that lie further from their surroundings than this many robust "
    "standard deviations, such as 6.", parsing.number, None,
    "Outliers beyond (standard deviations)", prepares=True,
)  # fmt: skip
LEVEL = Option(
    "level", Panel.MAP, "|".join(LEVELS),
    "What is fitted and subtracted; default: plane (by least squares).",
    parsing.choice(*LEVELS), "plane", prepares=True, whole_map=False,
)  # fmt: skip
FORM = Option(
    "form", Panel.MAP, "FORM",
    'Form to remove by least squares: sphere, cylinder or "polynomial 4".', parsing.form, None,
    "Form to remove", prepares=True,
)  # fmt: skip
MISSING = Option(
    "missing", Panel.MAP, "|".join(MISSING_KNOWN),
    "Missing points: error refuses them, fill interpolates smoothly up to 30 % of the points "
    "(fill-all any share), mask lets them never touch, crop keeps the largest rectangle "
    "without them; default: error.",
    parsing.choice(*MISSING_KNOWN), "error", "Missing points", prepares=True, whole_map=False,
)  # fmt: skip
S_FILTER = Option(
    "s-filter", Panel.MAP, "LENGTH",
    'Remove waves shorter than this (ISO 16610-61), such as "2.5 um".', LENGTH, None,
    "S-filter (shorter waves go)", arguments=("s",), prepares=True,
)  # fmt: skip
L_FILTER = Option(
    "l-filter", Panel.MAP, "LENGTH", 'Remove waves longer than this, such as "80 um".', LENGTH,
    None, "L-filter (longer waves go)", arguments=("l",), prepares=True,
)  # fmt: skip
PIXEL = Option(
    "pixel", Panel.MAP, "LENGTH",
    'Resample (cubic splines) to about this pixel, such as "0.5 um".', LENGTH, None,
    "Resample to pixel", prepares=True,
)  # fmt: skip
ROTATE = Option(
    "rotate", Panel.MAP, "DEGREES", "Turn the map counter-clockwise by a multiple of 90.",
    parsing.turns, 0, prepares=True,
)  # fmt: skip
PREPARATION = (CROP, OUTLIERS, LEVEL, FORM, MISSING, S_FILTER, L_FILTER, PIXEL, ROTATE)
MAP = (*READING, TIP_RADIUS, POINTS, *PREPARATION)

# Of what the bodies are

MATERIAL = Option(
    "material", Panel.BODIES, "NAME",
    "Material of the catalogue, such as 100Cr6; see roughcontact materials. --young, --poisson "
    "and --yield-strength stand in for it or replace single values.", parsing.material, None,
    whole_map=False,
)  # fmt: skip
YOUNG = Option(
    "young", Panel.BODIES, "PRESSURE", 'Young\'s modulus, such as "210 GPa".', PRESSURE, None,
    "Young's modulus", whole_map=False,
)  # fmt: skip
POISSON = Option(
    "poisson", Panel.BODIES, "NUMBER", "Poisson's ratio, such as 0.3.", parsing.number, None,
    "Poisson's ratio", whole_map=False,
)  # fmt: skip
YIELD_STRENGTH = Option(
    "yield-strength", Panel.BODIES, "PRESSURE", 'Yield strength, such as "1 GPa".', PRESSURE,
    None, whole_map=False,
)  # fmt: skip
COUNTER_MATERIAL = Option(
    "counter-material", Panel.BODIES, "NAME", "Material of the counter-body; default: rigid.",
    parsing.material, None, "Material of the counter-body", whole_map=False,
)  # fmt: skip
COUNTER_YOUNG = Option(
    "counter-young", Panel.BODIES, "PRESSURE", "Young's modulus of the counter-body.", PRESSURE,
    None, "Young's modulus of it", whole_map=False,
)  # fmt: skip
COUNTER_POISSON = Option(
    "counter-poisson", Panel.BODIES, "NUMBER", "Poisson's ratio of the counter-body.",
    parsing.number, None, "Poisson's ratio of it", whole_map=False,
)  # fmt: skip
COUNTER_YIELD_STRENGTH = Option(
    "counter-yield-strength", Panel.BODIES, "PRESSURE", "Yield strength of the counter-body.",
    PRESSURE, None, "Yield strength of it", whole_map=False,
)  # fmt: skip
BODY_CONSTANTS = (MATERIAL, YOUNG, POISSON, YIELD_STRENGTH)
COUNTER_CONSTANTS = (COUNTER_MATERIAL, COUNTER_YOUNG, COUNTER_POISSON, COUNTER_YIELD_STRENGTH)
MATERIALS = (*BODY_CONSTANTS, *COUNTER_CONSTANTS)
HARDENING = Option(
    "hardening", Panel.BODIES, "LAW",
    'Hardening of the rough body: "linear 2 GPa" (modulus) or "swift 945 MPa 20 0.121" (B, C, '
    'n of B (C + 1e6 e)^n); "kinematic 10 GPa", alone or after one of these and a comma, for '
    "metal that yields earlier on its way back; for the volume model, and for the ceiling "
    "that is recommended.",
    parsing.hardening, None,
)  # fmt: skip

# How they are shaped and laid on each other

BODY = Option(
    "body", Panel.BODIES, "FORM",
    'Nominal form under the roughness, or alone with --points and --size: "sphere 10 mm", '
    '"cylinder 5 mm 90 deg", "ellipsoid 10 mm 4 mm", "punch 20 um", "cone 0.01", "wedge 0.01". '
    "Angles run counter-clockwise.", parsing.body, None, "Nominal form under the roughness",
    prepares=True,
)  # fmt: skip
COUNTER_BODY = Option(
    "counter-body", Panel.BODIES, "FORM", "Nominal form of the counter-body; default: flat.",
    parsing.body, None, "Form of the counter-body", prepares=True,
)  # fmt: skip
COUNTER_SURFACE = Option(
    "counter-surface", Panel.BODIES, "FILE",
    "Height map of the counter-body, laid on point by point; on another grid it needs --align.",
    parsing.path, None, "Map of the counter-body", prepares=True,
)  # fmt: skip
ALIGN = flag(
    "align", Panel.BODIES,
    "Bring both maps to one grid, centre on centre, and keep what both cover.",
    label="Bring both maps to one grid", prepares=True,
)  # fmt: skip
OFFSET = Option(
    "offset", Panel.BODIES, "LENGTHS",
    'Shift (y, x) of the aligned counter-map, such as "0 um, 5 um".', parsing.offset, None,
    "Shift of the counter-map (y, x)", prepares=True,
)  # fmt: skip
ANGLE = Option(
    "angle", Panel.BODIES, "DEGREES", "Turn of the aligned counter-map, counter-clockwise.",
    parsing.number, None, "Turn of the counter-map", prepares=True,
)  # fmt: skip
MIRROR = flag(
    "mirror", Panel.BODIES,
    "Mirror the aligned counter-map, as a map measured from its own front needs.",
    label="Mirror the counter-map", prepares=True,
)  # fmt: skip
MOVES: tuple[Option[Any], ...] = (ALIGN, OFFSET, ANGLE, MIRROR)
SHAPES = (BODY, COUNTER_BODY, COUNTER_SURFACE, *MOVES)
CEILING: Option[str | float | None] = Option(
    "ceiling", Panel.BODIES, "PRESSURE",
    'Largest pressure, such as "3 GPa", or a hardness, such as "62 HRC"; auto: 3 times the '
    "smaller yield strength, or else the hardness; recommended: that which gives the contact "
    "area of plasticity in the volume, found by solving again; none: purely elastic; default: "
    "auto.",
    parsing.ceiling, "auto", "Pressure ceiling", whole_map=False,
)  # fmt: skip
BOUNDARY: Option[str] = Option(
    "boundary", Panel.BODIES, "KIND",
    "What lies beyond the edges of the map. "
    f"{'; '.join(f'{kind}: {kind.meaning}' for kind in Boundary)}; default: free.",
    parsing.choice(*Boundary), Boundary.FREE, "What the map is", whole_map=False,
)  # fmt: skip
BODIES = (*MATERIALS, *SHAPES, CEILING, BOUNDARY)

# The load on them

LOAD = Option(
    "load", Panel.BODIES, "LOAD",
    'Normal load, such as "1 N"; or as a nominal pressure on the area of the map, such as '
    '"20 MPa"; or per length of a profile or of a nominal cylinder, such as "600 N/mm"; this, '
    "--hertz or --approach.", parsing.load, None, whole_map=False,
)  # fmt: skip
HERTZ = Option(
    "hertz", Panel.BODIES, "PRESSURE",
    'Load under which the nominal bodies, smooth, have this peak pressure, such as "1.5 GPa".',
    parsing.peak, None, "Hertz pressure of the smooth bodies",
)  # fmt: skip
APPROACH = Option(
    "approach", Panel.BODIES, "LENGTH", 'Approach of the bodies from first touch, such as "1 um".',
    LENGTH, None, whole_map=False,
)  # fmt: skip
LOAD_POINT = Option(
    "load-point", Panel.BODIES, "LENGTHS",
    'Let the bodies tilt until the load acts at this offset (y, x) from the middle of the map, '
    'such as "0 um, 5 um"; default: they do not tilt.', parsing.offset, None,
    "Load acts at (y, x)",
)  # fmt: skip
LOADS = (LOAD, HERTZ, APPROACH, LOAD_POINT)
LOAD_RULES = (
    Rule(ONE_OF, LOAD, HERTZ, APPROACH, text="1 N"),
    Rule(NEEDS, LOAD_POINT, LOAD, HERTZ),
)

# How exactly it is solved

TOLERANCE = Option(
    "tolerance", Panel.SOLVER, "NUMBER",
    "Certificate to reach; default: 1e-6, in single precision 1e-4.", parsing.number, None,
)  # fmt: skip
TOLERANCE_DOUBLE = Option(
    "tolerance", Panel.SOLVER, "NUMBER", "Certificate to reach; default: 1e-6.", parsing.number,
    None,
)  # fmt: skip
MAX_ITERATIONS = Option(
    "max-iterations", Panel.SOLVER, "NUMBER",
    "Most convolutions on any one grid; default: 2000.", ITERATIONS, None, "Most convolutions",
)  # fmt: skip
PRECISION: Option[str | None] = Option(
    "precision", Panel.SOLVER, "double|single",
    "single needs two thirds of the memory; default: double.",
    parsing.choice("double", "single"), None,
)  # fmt: skip
SOLVER = (TOLERANCE, MAX_ITERATIONS, PRECISION)
SOLVER_DOUBLE = (TOLERANCE_DOUBLE, MAX_ITERATIONS)

# What is written and shown

REPORT = file(
    "report", "FILE.html", "Write a report with figures into one HTML file.", (".html",),
    whole_map=False,
)  # fmt: skip
FOLDER = file("folder", "FOLDER", "Where finished steps are kept, to go on later.")
JSON = flag("json", Panel.OUTPUT, "Print JSON in SI units, and nothing else.", whole_map=False)
QUIET = flag(
    "quiet", Panel.OUTPUT, "Print nothing but errors, and JSON if wanted.", whole_map=False
)
VERBOSE = flag("verbose", Panel.OUTPUT, "Print all quantities, checks and notes.", whole_map=False)
SHOWN = (VERBOSE, JSON, QUIET)
"""What the terminal shows, which does not describe a run."""
OUTPUT = (REPORT, *SHOWN)

RULES = tuple(Rule(NEEDS, move, COUNTER_SURFACE) for move in MOVES)
"""What holds wherever these options stand."""
