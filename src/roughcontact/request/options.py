"""Options: definition, rules between options, and groups that tasks share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum, StrEnum, auto
from typing import Any, Generic, TypeVar

from roughcontact import units
from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import parsing

T_co = TypeVar("T_co", covariant=True)

TABLES = (".csv", ".json")
PICTURES = (".png", ".svg", ".pdf")
LENGTH, PRESSURE = (parsing.quantity(name) for name in ("length", "pressure"))

_UNITS: dict[Any, str] = {
    parsing.load: "N",
    parsing.nominal: "Pa",
    LENGTH: "m",
    PRESSURE: "Pa",
    parsing.ceiling: "Pa",
}


class Panel(StrEnum):
    """Headings of the help."""

    MAP = "Map and preparation"
    HEIGHTS = "Heights"
    TEXTURE = "Texture"
    BODIES = "Bodies and load"
    SOLVER = "Accuracy"
    ENGINE = "Where to run"
    SERVER = "Server"
    OUTPUT = "Output"


@dataclass(frozen=True, eq=False)
class Option(Generic[T_co]):
    """Option of commands and of project files."""

    name: str  # Name without leading dashes
    panel: str  # Heading under which the help lists it
    metavar: str  # Placeholder of the value
    help: str  # Effect
    parse: Callable[[str, str], T_co]  # `parse(text, argument)` returns the value
    default: T_co  # Value if the option is not given
    label: str = ""  # Label on the page
    prepares: bool = False  # Whether the prepared maps depend on it
    many: bool = False  # Whether it may be given several times
    suffixes: tuple[str, ...] = ()  # Suffixes allowed for a file to write
    arguments: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Derive the label from the name if none is given."""
        object.__setattr__(self, "label", self.label or self.name.replace("-", " ").capitalize())

    @property
    def argument(self) -> str:
        """Name of the option in errors and in `ArgumentRef`."""
        return self.name.replace("-", "_")

    @property
    def is_place(self) -> bool:
        """Whether the value is a file or a folder."""
        return self.parse in (parsing.path, parsing.paths, parsing.groups) or bool(self.suffixes)

    @property
    def is_flag(self) -> bool:
        """Whether the option is given without a value."""
        return not self.metavar

    def text(self, value: object) -> str:
        """Return a value as text that the option accepts."""
        unit = _UNITS.get(self.parse)
        if not isinstance(value, float):
            return str(value)
        return f"{value:g}" if unit is None else units.format_engineering(value, unit)


def flag_option(name: str, panel: str, text: str, **more: Any) -> Option[bool]:
    """Return an option without a value."""
    return Option(name, panel, "", text, parsing.flag, False, **more)


def file_option(
    name: str, metavar: str, text: str, suffixes: tuple[str, ...] = (), **more: Any
) -> Option[Any]:
    """Return an option of one output file or folder."""
    return Option(name, Panel.OUTPUT, metavar, text, parsing.path, None, suffixes=suffixes, **more)


def files_option(name: str, text: str, suffixes: tuple[str, ...], **more: Any) -> Option[Any]:
    """Return an option of output files."""
    return Option(
        name, Panel.OUTPUT, "FILE", text, parsing.paths, (), many=True, suffixes=suffixes, **more
    )


# --- Rules between options, as data ---


class RuleKind(Enum):
    """Type of a rule between options."""

    NEEDED = auto()
    NEEDS = auto()
    EXCLUDES = auto()
    ONE_OF = auto()
    ANY_OF = auto()


NEEDED, NEEDS, EXCLUDES, ONE_OF, ANY_OF = RuleKind


@dataclass(frozen=True, init=False)
class Rule:
    """Rule between options."""

    demand: RuleKind  # Type; `NEEDED`: the first option is given
    options: tuple[Option[Any], ...]  # Options that the rule applies to
    value: str = ""  # Of a `NEEDS`: required value of the other option
    text: str = ""  # Value, or an example of it

    def __init__(self, demand: RuleKind, *options: Option[Any], **more: str) -> None:
        for name, held in {"demand": demand, "options": options, **more}.items():
            object.__setattr__(self, name, held)


def check_rules(rules: Iterable[Rule], request: Any) -> None:
    """Raise `InputError` for the first rule that a request breaks."""
    for rule in rules:
        first, *others = rule.options
        about = first.argument
        specified = [option for option in rule.options if request.is_given(option)]
        if rule.demand is NEEDED and not specified:
            raise InputError(f"is needed: {rule.text}", argument=about)
        if rule.demand is ONE_OF and len(specified) != 1:
            raise InputError(
                "give one of ",
                *join_mentions(rule.options, " and "),
                ", and no more than one, such as ",
                ArgumentRef(about, rule.text),
            )
        if rule.demand is ANY_OF and not specified:
            raise InputError("no target: give ", *join_mentions(rule.options, " or "))
        if rule.demand is NEEDS and rule.value:
            if first in specified and request.get(others[0]) != rule.value:
                needed = ArgumentRef(others[0].argument, rule.value)
                raise InputError("needs ", needed, argument=about)
        elif rule.demand is NEEDS and specified == [first]:
            raise InputError("needs ", *join_mentions(others, " or "), argument=about)
        if rule.demand is EXCLUDES and first in specified and specified != [first]:
            raise InputError(
                "cannot be combined with ", *join_mentions(others, " and "), argument=about
            )


def join_mentions(options: Iterable[Option[Any]], last: str) -> list[Any]:
    """Return references to options with commas in between, and ``last`` before the last."""
    mentions: list[Any] = [ArgumentRef(option.argument) for option in options]
    parts = [part for mention in mentions for part in (mention, ", ")][:-1]
    if len(mentions) > 1:
        parts[-2] = last
    return parts


# --- Options that tasks share; a task that lists a group has all options of the group ---

LEVELS = ("plane", "quadric", "mean", "robust", "none")
MISSING_KNOWN = ("error", "fill", "fill-all", "mask", "crop")
ITERATIONS = parsing.int_parser(1, memory.ITERATIONS)

# Maps

GROUP: Option[tuple[tuple[str, tuple[str, ...]], ...]] = Option(
    "group",
    Panel.MAP,
    "NAME=FILE[,FILE…]",
    'Group of maps: "ground=ground*.opd"; repeatable.',
    parsing.groups,
    (),
    many=True,
    arguments=("maps",),
)

# Reading of a file

FORMAT = Option(
    "format",
    Panel.MAP,
    "NAME",
    "File format; default: recognized from the file.",
    parsing.as_text,
    None,
    prepares=True,
)
CHANNEL = Option(
    "channel",
    Panel.MAP,
    "NAME|INDEX",
    "Height channel, name or index; default: the proposed one.",
    parsing.as_text,
    None,
    prepares=True,
)
UNIT = Option(
    "unit",
    Panel.MAP,
    "UNIT",
    'Unit of the heights, e.g. um; of a profile "mm, um" (positions first).',
    parsing.as_text,
    None,
    "Unit of the heights",
    prepares=True,
)
SIZE = Option(
    "size",
    Panel.MAP,
    "LENGTHS",
    'Side lengths (y, x) if the file has none: "0.1 mm x 0.2 mm".',
    parsing.as_text,
    None,
    "Side lengths (y × x)",
    prepares=True,
)
OVERRIDE_SIZE = flag_option(
    "override-size",
    Panel.MAP,
    "Use --size instead of the size in the file.",
    label="Use these side lengths instead of the file's",
    prepares=True,
)
NO_DATA: Option[float | str | None] = Option(
    "no-data",
    Panel.MAP,
    "VALUE",
    "Value of missing points in the file: -9999; auto: all known codes; none: all are heights.",
    parsing.no_data,
    None,
    "Value of missing points",
    prepares=True,
)
READING = (FORMAT, CHANNEL, UNIT, SIZE, OVERRIDE_SIZE, NO_DATA)

# Preparation of a map

TIP_RADIUS = Option(
    "tip-radius",
    Panel.MAP,
    "LENGTH",
    'Probe tip radius: "10 nm"; used to estimate resolution.',
    LENGTH,
    None,
    "Probe tip radius",
)
POINTS = Option(
    "points",
    Panel.MAP,
    "NUMBER|NYxNX",
    "Grid of a nominal --body without FILE: 256 or 128x512.",
    parsing.points,
    None,
    prepares=True,
)
CROP = Option(
    "crop",
    Panel.MAP,
    "ROWS,COLUMNS",
    "Rows and columns to keep: 0:256,100:356.",
    parsing.window,
    None,
    "Crop (rows, columns)",
    prepares=True,
)
OUTLIERS = Option(
    "outliers",
    Panel.MAP,
    "NUMBER",
    "Remove spikes beyond this many robust standard deviations: 6.",
    parsing.number,
    None,
    "Remove spikes (standard deviations)",
    prepares=True,
)
LEVEL = Option(
    "level",
    Panel.MAP,
    "|".join(LEVELS),
    "Subtract plane, quadric, mean, robust plane or none; default: plane.",
    parsing.choice(*LEVELS),
    "plane",
    prepares=True,
)
FORM = Option(
    "form",
    Panel.MAP,
    "FORM",
    'Form to remove (least squares): sphere, cylinder or "polynomial 4".',
    parsing.form,
    None,
    "Form to remove",
    prepares=True,
)
MISSING = Option(
    "missing",
    Panel.MAP,
    "|".join(MISSING_KNOWN),
    "Missing points: error, fill (interpolate, up to 30 %), fill-all, mask (no contact) or crop; "
    "default: error.",
    parsing.choice(*MISSING_KNOWN),
    "error",
    "Missing points",
    prepares=True,
)
S_FILTER = Option(
    "s-filter",
    Panel.MAP,
    "LENGTH",
    'S-filter: remove wavelengths below "2.5 um" (ISO 16610-61).',
    LENGTH,
    None,
    "S-filter (removes shorter waves)",
    arguments=("s",),
    prepares=True,
)
L_FILTER = Option(
    "l-filter",
    Panel.MAP,
    "LENGTH",
    'L-filter: remove wavelengths above "80 um".',
    LENGTH,
    None,
    "L-filter (removes longer waves)",
    arguments=("l",),
    prepares=True,
)
PIXEL = Option(
    "pixel",
    Panel.MAP,
    "LENGTH",
    'Resample (cubic splines) to about this pixel: "0.5 um".',
    LENGTH,
    None,
    "Resample to pixel",
    prepares=True,
)
ROTATE = Option(
    "rotate",
    Panel.MAP,
    "DEGREES",
    "Rotation of the map, degrees counterclockwise, a multiple of 90.",
    parsing.parse_quarter_turns,
    0,
    prepares=True,
)
PREPARATION = (CROP, OUTLIERS, LEVEL, FORM, MISSING, S_FILTER, L_FILTER, PIXEL, ROTATE)
MAP = (*READING, TIP_RADIUS, POINTS, *PREPARATION)

# Materials of the bodies

MATERIAL = Option(
    "material",
    Panel.BODIES,
    "NAME",
    "Catalog material, e.g. 42CrMo4; --young etc. override single values.",
    parsing.material,
    None,
)
YOUNG = Option(
    "young",
    Panel.BODIES,
    "PRESSURE",
    'Young\'s modulus: "210 GPa".',
    PRESSURE,
    None,
    "Young's modulus",
)
POISSON = Option(
    "poisson",
    Panel.BODIES,
    "NUMBER",
    "Poisson's ratio: 0.3.",
    parsing.number,
    None,
    "Poisson's ratio",
)
YIELD_STRENGTH = Option(
    "yield-strength", Panel.BODIES, "PRESSURE", 'Yield strength: "1 GPa".', PRESSURE, None
)
COUNTER_MATERIAL = Option(
    "counter-material",
    Panel.BODIES,
    "NAME",
    "Counter-body material; default: rigid.",
    parsing.material,
    None,
    "Counter-body material",
)
COUNTER_YOUNG = Option(
    "counter-young",
    Panel.BODIES,
    "PRESSURE",
    "Young's modulus of the counter-body.",
    PRESSURE,
    None,
    "Counter-body Young's modulus",
)
COUNTER_POISSON = Option(
    "counter-poisson",
    Panel.BODIES,
    "NUMBER",
    "Poisson's ratio of the counter-body.",
    parsing.number,
    None,
    "Counter-body Poisson's ratio",
)
COUNTER_YIELD_STRENGTH = Option(
    "counter-yield-strength",
    Panel.BODIES,
    "PRESSURE",
    "Yield strength of the counter-body.",
    PRESSURE,
    None,
    "Counter-body yield strength",
)
BODY_CONSTANTS = (MATERIAL, YOUNG, POISSON, YIELD_STRENGTH)
COUNTER_CONSTANTS = (COUNTER_MATERIAL, COUNTER_YOUNG, COUNTER_POISSON, COUNTER_YIELD_STRENGTH)
MATERIALS = (*BODY_CONSTANTS, *COUNTER_CONSTANTS)
COATING: Option[Any] = Option(
    "coating",
    Panel.BODIES,
    "LAYER",
    'Layer on the body: "DLC 2 um", "E=200 GPa, nu=0.2, 2 um"; repeatable, outermost first.',
    parsing.coatings,
    (),
    many=True,
)
COUNTER_COATING: Option[Any] = Option(
    "counter-coating",
    Panel.BODIES,
    "LAYER",
    "Layer on the counter-body, as for --coating.",
    parsing.coatings,
    (),
    "Counter-body coating",
    many=True,
)
COATINGS = (COATING, COUNTER_COATING)
HARDENING = Option(
    "hardening",
    Panel.BODIES,
    "LAW",
    'Hardening: "linear 2 GPa", "swift 945 MPa 20 0.121", "kinematic 10 GPa"; combine with a '
    "comma.",
    parsing.hardening,
    None,
)

# Shape and placement of the bodies

BODY = Option(
    "body",
    Panel.BODIES,
    "FORM",
    'Nominal form: "sphere 10 mm", "cylinder 5 mm 90 deg", "ellipsoid 10 mm 4 mm", "punch 20 '
    'um", "cone 0.01", "wedge 0.01".',
    parsing.body,
    None,
    "Nominal form",
    prepares=True,
)
COUNTER_BODY = Option(
    "counter-body",
    Panel.BODIES,
    "FORM",
    "Nominal form of the counter-body, as for --body; default: flat.",
    parsing.body,
    None,
    "Counter-body form",
    prepares=True,
)
COUNTER_SURFACE = Option(
    "counter-surface",
    Panel.BODIES,
    "FILE",
    "Height map of the counter-body; another grid needs --align.",
    parsing.path,
    None,
    "Counter-body map",
    prepares=True,
)
COUNTER_MAPS: Option[Any] = Option(
    "counter-maps",
    Panel.BODIES,
    "FILE",
    "Map of the counter-body's face, met at random shifts and turns; repeatable.",
    parsing.paths,
    (),
    "Maps of the counter-body's face",
    many=True,
    prepares=True,
)
DRAWS = Option(
    "draws",
    Panel.BODIES,
    "NUMBER",
    "Number of pairs of faces drawn; default: 5.",
    parsing.int_parser(2, 100),
    5,
)
ALIGN = flag_option(
    "align",
    Panel.BODIES,
    "Resample both maps to one grid, centered, and keep the overlap.",
    label="Resample both maps to one grid",
    prepares=True,
)
OFFSET = Option(
    "offset",
    Panel.BODIES,
    "LENGTHS",
    'Shift (y, x) of the aligned counter-map: "0 um, 5 um".',
    parsing.offset,
    None,
    "Counter-map shift (y, x)",
    prepares=True,
)
ANGLE = Option(
    "angle",
    Panel.BODIES,
    "DEGREES",
    "Rotation of the aligned counter-map, degrees counterclockwise.",
    parsing.number,
    None,
    "Rotation of counter-map",
    prepares=True,
)
MIRROR = flag_option(
    "mirror",
    Panel.BODIES,
    "Mirror the aligned counter-map (measured from its own front).",
    label="Mirror counter-map",
    prepares=True,
)
MOVES: tuple[Option[Any], ...] = (ALIGN, OFFSET, ANGLE, MIRROR)
SHAPES = (BODY, COUNTER_BODY, COUNTER_SURFACE, *MOVES)
CEILING: Option[str | float | None] = Option(
    "ceiling",
    Panel.BODIES,
    "PRESSURE",
    'Pressure ceiling: "3 GPa", "62 HRC", calibrated, auto (3σ_Y) or none '
    "(elastic); default: auto.",
    parsing.ceiling,
    "auto",
    "Pressure ceiling",
)
BOUNDARY: Option[str] = Option(
    "boundary",
    Panel.BODIES,
    "KIND",
    "Beyond the map edge. "
    f"{'; '.join(f'{kind}: {kind.meaning}' for kind in Boundary)}; default: free.",
    parsing.choice(*Boundary),
    Boundary.FREE,
    "Boundary",
)
BODIES = (*MATERIALS, *SHAPES, CEILING, BOUNDARY)

# Load

LOAD = Option(
    "load",
    Panel.BODIES,
    "LOAD",
    'Load: "1 N", nominal pressure "20 MPa", or line load "600 N/mm".',
    parsing.load,
    None,
)
HERTZ = Option(
    "hertz",
    Panel.BODIES,
    "PRESSURE",
    'Load given as Hertz peak pressure of the smooth bodies: "1.5 GPa".',
    parsing.hertz_load,
    None,
    "Hertz pressure",
)
APPROACH = Option(
    "approach",
    Panel.BODIES,
    "LENGTH",
    'Approach from first contact, instead of a load: "1 um".',
    LENGTH,
    None,
)
LOAD_POINT = Option(
    "load-point",
    Panel.BODIES,
    "LENGTHS",
    "Load position (y, x) from the map center; allows tilt. Default: no tilt.",
    parsing.offset,
    None,
    "Load position (y, x)",
)
LOADS = (LOAD, HERTZ, APPROACH, LOAD_POINT)
LOAD_RULES = (Rule(ONE_OF, LOAD, HERTZ, APPROACH, text="1 N"), Rule(NEEDS, LOAD_POINT, LOAD, HERTZ))

# Accuracy of the solve

TOLERANCE = Option(
    "tolerance",
    Panel.SOLVER,
    "NUMBER",
    "Certificate limit; default: 1e-6 (single precision: 1e-4).",
    parsing.number,
    None,
)
TOLERANCE_DOUBLE = Option(
    "tolerance", Panel.SOLVER, "NUMBER", "Certificate limit; default: 1e-6.", parsing.number, None
)
MAX_ITERATIONS = Option(
    "max-iterations",
    Panel.SOLVER,
    "NUMBER",
    "Maximum convolutions per grid; default: 2000.",
    ITERATIONS,
    None,
    "Maximum convolutions",
)
PRECISION: Option[str | None] = Option(
    "precision",
    Panel.SOLVER,
    "double|single",
    "double or single (two thirds of the memory); default: double.",
    parsing.choice("double", "single"),
    None,
)
SOLVER = (TOLERANCE, MAX_ITERATIONS, PRECISION)
SOLVER_DOUBLE = (TOLERANCE_DOUBLE, MAX_ITERATIONS)

# Output files and console

FIGURES = Option(
    "figures",
    Panel.OUTPUT,
    "FOLDER|PREFIX",
    "Figures: folder or file prefix; add .svg or .pdf for the format.",
    parsing.as_text,
    None,
    suffixes=PICTURES,
)
REPORT = file_option("report", "FILE.html", "Report with figures as one HTML file.", (".html",))
FOLDER = file_option("folder", "FOLDER", "Folder for finished steps; the same command resumes.")
JSON = flag_option("json", Panel.OUTPUT, "Print JSON in SI units.")
QUIET = flag_option("quiet", Panel.OUTPUT, "Print errors only.")
VERBOSE = flag_option("verbose", Panel.OUTPUT, "Print all quantities, checks and notes.")
SHOWN = (VERBOSE, JSON, QUIET)
"""Options of the console, which are not part of a run."""
OUTPUT = (REPORT, *SHOWN)

RULES = tuple(Rule(NEEDS, move, COUNTER_SURFACE) for move in MOVES)
"""Rules of all tasks that have these options."""
