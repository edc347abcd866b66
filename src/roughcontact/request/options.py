"""Options: definition, rules between options, and groups that tasks share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import Enum, StrEnum, auto
from typing import Any, Generic, TypeVar

from roughcontact import units
from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import parsing
from roughcontact.request.parsing import Parser

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)

PICTURES = (".png", ".svg", ".pdf")
LENGTH, PRESSURE = map(parsing.quantity, ("length", "pressure"))

_SETTINGS = (
    "format channel override-size tip-radius invert flip rotate offset angle mirror counter-young "
    "counter-poisson counter-yield-strength counter-coating load-point tolerance max-iterations "
    "precision uncalibrated increments material-uncertainty project drawing author draws "
    "flow-axis temperature gap-pressure"
)
SETTINGS = frozenset(_SETTINGS.split())
"""Names of the options that commands take as ``--set NAME=VALUE``; keys of project files."""

REMOVED = {"hertz": ("load", "hertz {}")}
"""Removed options, with the option that replaces each and its value."""


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
    SETTINGS = "Settings"


@dataclass(frozen=True, eq=False)
class Option(Generic[T_co]):
    """Option of commands and of project files."""

    name: str  # Name without leading dashes
    parse: Parser[T_co]  # `parse(text, argument)` returns the value
    help: str  # Effect
    default: T_co  # Value if the option is not given
    panel: str = Panel.BODIES  # Heading under which the help lists it
    label: str = ""  # Label on the page
    prepares: bool = False  # Whether the prepared maps depend on it
    many: bool = False  # Whether it may be given several times: the value is a tuple
    suffixes: tuple[str, ...] = ()  # Suffixes allowed for a file to write
    files_in: Callable[[str], list[str]] = lambda text: []  # Names of the files to read in a text
    arguments: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Derive the label from the name if none is given."""
        object.__setattr__(self, "label", self.label or self.name.replace("-", " ").capitalize())

    @property
    def argument(self) -> str:
        """Name of the option in errors and in `ArgumentRef`."""
        return self.name.replace("-", "_")

    @property
    def metavar(self) -> str:
        """Placeholder of the value in the help; empty for flags."""
        return self.parse.metavar

    @property
    def is_place(self) -> bool:
        """Whether the value is a file or a folder."""
        is_path = self.parse.function in (parsing.path.function, parsing.group.function)
        return is_path or bool(self.suffixes or self.files_in("measured file"))

    @property
    def is_flag(self) -> bool:
        """Whether the option is given without a value."""
        return not self.metavar

    @property
    def is_setting(self) -> bool:
        """Whether commands take the option as ``--set NAME=VALUE``."""
        return self.name in SETTINGS

    def words(self, text: str | bool) -> list[str]:
        """Return the words of the command line that give the option a value."""
        value = [] if text is True else [str(text)]
        if self.is_setting:
            return ["--set", "=".join([self.name, *value])]
        return [f"--{self.name}", *value]

    def text(self, value: object) -> str:
        """Return a value as text that the option accepts."""
        if not isinstance(value, float):
            return str(value)
        unit = self.parse.unit
        return units.format_engineering(value, unit) if unit else f"{value:g}"

    @staticmethod
    def value(
        name: str, parse: Parser[T], text: str, panel: str = Panel.BODIES, **more: Any
    ) -> Option[T | None]:
        """Return an option without a default."""
        return Option(name, parse, text, None, panel, **more)

    @staticmethod
    def symbol(
        symbol: str, parse: Parser[T], text: str, panel: str = Panel.MAP, default: T | None = None
    ) -> Option[T | None]:
        """Return an option of a roughness parameter, by its symbol."""
        return Option(symbol.lower(), parse, text, default, panel, arguments=(symbol,))

    @staticmethod
    def flag(name: str, text: str, panel: str = Panel.BODIES, **more: Any) -> Option[bool]:
        """Return an option without a value."""
        return Option(name, parsing.flag, text, False, panel, **more)

    @staticmethod
    def file(
        name: str, text: str, suffixes: tuple[str, ...] = (), metavar: str = ""
    ) -> Option[Any]:
        """Return an option of one output file, or of a folder if no suffixes are given."""
        written = f"FILE{'|'.join(suffixes).replace('|.', '|')}" if suffixes else "FOLDER"
        parse = parsing.path.with_metavar(metavar or written)
        return Option(name, parse, text, None, Panel.OUTPUT, suffixes=suffixes)

    @staticmethod
    def figure(shown: str) -> Option[Any]:
        """Return the option of the figure of a result."""
        return Option.file("figure", f"Figure of {shown} (PNG, SVG or PDF).", PICTURES, "FILE")

    @staticmethod
    def output(text: str, suffixes: tuple[str, ...]) -> Option[Any]:
        """Return the option of the output files of a result."""
        text = f"{text}; repeatable."
        return Option("output", parsing.path, text, (), Panel.OUTPUT, many=True, suffixes=suffixes)


def map_option(name: str, parse: Parser[T], text: str, **more: Any) -> Option[T | None]:
    """Return an option of the preparation of maps, without a default."""
    return Option(name, parse, text, None, Panel.MAP, prepares=True, **more)


def _counter_option(option: Option[T], label: str) -> Option[T]:
    """Return the option of the counter-body for a constant of the body."""
    text = f"{option.label} of the counter-body."
    return replace(option, name=f"counter-{option.name}", help=text, label=label)


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


LEVELS = ("plane", "quadric", "mean", "robust", "none")
MISSING_KNOWN = ("error", "fill", "fill-all", "mask", "crop")

# Maps

GROUP: Option[Any] = Option(
    "group",
    parsing.group,
    'Group of maps: "ground=ground*.opd"; repeatable.',
    (),
    Panel.MAP,
    many=True,
    arguments=("maps",),
)

# Reading of a file

FORMAT = map_option("format", parsing.as_text, "File format; default: recognized from the file.")
CHANNEL = map_option(
    "channel",
    parsing.as_text.with_metavar("NAME|INDEX"),
    "Height channel, name or index; default: the proposed one.",
)
UNIT = map_option(
    "unit",
    parsing.as_text.with_metavar("UNIT"),
    'Unit of the heights, e.g. um; of points or a profile "mm, um" (positions first).',
    label="Unit of the heights",
)
SIZE = map_option(
    "size",
    parsing.as_text.with_metavar("LENGTHS"),
    'Side lengths (y, x) if the file has none: "0.1 mm x 0.2 mm".',
    label="Side lengths (y × x)",
)
OVERRIDE_SIZE = Option.flag(
    "override-size",
    "Use --size instead of the size in the file.",
    Panel.MAP,
    label="Use these side lengths instead of the file's",
    prepares=True,
)
NO_DATA: Option[float | str | None] = map_option(
    "no-data",
    parsing.no_data,
    "Value of missing points in the file: -9999; auto: all known codes; none: all are heights.",
    label="Value of missing points",
)
READING = (FORMAT, CHANNEL, UNIT, SIZE, OVERRIDE_SIZE, NO_DATA)

# Preparation of a map

TIP_RADIUS = Option.value(
    "tip-radius",
    LENGTH,
    'Probe tip radius: "10 nm"; used to estimate resolution.',
    Panel.MAP,
    label="Probe tip radius",
)
POINTS = map_option(
    "points", parsing.points, "Grid of a nominal --body without FILE: 256 or 128x512."
)
CROP = map_option(
    "crop",
    parsing.window,
    "Rows and columns to keep: 0:256,100:356.",
    label="Crop (rows, columns)",
    arguments=("rows", "columns"),
)
OUTLIERS = map_option(
    "outliers",
    parsing.number,
    "Remove spikes beyond this many robust standard deviations: 6.",
    label="Remove spikes (standard deviations)",
    arguments=("limit",),
)
LEVEL = Option(
    "level",
    parsing.choice(*LEVELS),
    "Subtract plane, quadric, mean, robust plane or none; default: plane.",
    "plane",
    Panel.MAP,
    prepares=True,
)
FORM = map_option(
    "form",
    parsing.form,
    'Form to remove (least squares): sphere, cylinder or "polynomial 4".',
    label="Form to remove",
)
MISSING = Option(
    "missing",
    parsing.choice(*MISSING_KNOWN),
    "Missing points: error, fill (interpolate, up to 30 %), fill-all, mask (no contact) or crop; "
    "default: error.",
    "error",
    Panel.MAP,
    label="Missing points",
    prepares=True,
)
S_FILTER = map_option(
    "s-filter",
    LENGTH,
    'S-filter: remove wavelengths below "2.5 um" (ISO 16610-61).',
    label="S-filter (removes shorter waves)",
    arguments=("s",),
)
L_FILTER = map_option(
    "l-filter",
    LENGTH,
    'L-filter: remove wavelengths above "80 um".',
    label="L-filter (removes longer waves)",
    arguments=("l",),
)
PIXEL = map_option(
    "pixel",
    LENGTH,
    'Resample (cubic splines) to about this pixel: "0.5 um".',
    label="Resample to pixel",
)
ROTATE = Option(
    "rotate",
    parsing.parse_quarter_turns,
    "Rotation of the map, degrees counterclockwise, a multiple of 90.",
    0,
    Panel.MAP,
    prepares=True,
)
INVERT = Option.flag(
    "invert",
    "Heights times -1: of a replica cast, whose peaks are the pits of the surface.",
    Panel.MAP,
    label="Invert the heights (replica cast)",
    prepares=True,
)
FLIP = map_option(
    "flip",
    parsing.choice("x", "y"),
    "Mirror image of the map: x reverses its rows, y its columns; before rotate.",
)
PREPARATION = (
    *(INVERT, CROP, OUTLIERS, LEVEL, FORM, MISSING, S_FILTER, L_FILTER, PIXEL, FLIP, ROTATE),
)
MAP = (*READING, TIP_RADIUS, POINTS, *PREPARATION)

# Materials of the bodies

MATERIAL = Option.value(
    "material",
    parsing.material,
    "Catalog material, e.g. 42CrMo4; --young etc. override single values.",
)
YOUNG = Option.value("young", PRESSURE, 'Young\'s modulus: "210 GPa".', label="Young's modulus")
POISSON = Option.value("poisson", parsing.number, "Poisson's ratio: 0.3.", label="Poisson's ratio")
YIELD_STRENGTH = Option.value("yield-strength", PRESSURE, 'Yield strength: "1 GPa".')
COUNTER_MATERIAL = Option.value(
    "counter-material",
    parsing.material,
    "Counter-body material; default: rigid.",
    label="Counter-body material",
)
COUNTER_YOUNG = _counter_option(YOUNG, "Counter-body Young's modulus")
COUNTER_POISSON = _counter_option(POISSON, "Counter-body Poisson's ratio")
COUNTER_YIELD_STRENGTH = _counter_option(YIELD_STRENGTH, "Counter-body yield strength")
BODY_CONSTANTS = (MATERIAL, YOUNG, POISSON, YIELD_STRENGTH)
COUNTER_CONSTANTS = (COUNTER_MATERIAL, COUNTER_YOUNG, COUNTER_POISSON, COUNTER_YIELD_STRENGTH)
MATERIALS = (*BODY_CONSTANTS, *COUNTER_CONSTANTS)
COATING: Option[Any] = Option(
    "coating",
    parsing.coating,
    'Layer on the body: "DLC 2 um", "E=200 GPa, nu=0.2, 2 um"; repeatable, outermost first.',
    (),
    many=True,
)
COUNTER_COATING: Option[Any] = Option(
    "counter-coating",
    parsing.coating,
    "Layer on the counter-body, as for --coating.",
    (),
    label="Counter-body coating",
    many=True,
)
COATINGS = (COATING, COUNTER_COATING)
HARDENING = Option.value(
    "hardening",
    parsing.hardening,
    'Hardening: "linear 2 GPa", "swift 945 MPa 20 0.121", "kinematic 10 GPa"; combine with a '
    "comma.",
)

# Shape and placement of the bodies

BODY = Option.value(
    "body",
    parsing.body,
    'Nominal form: "sphere 10 mm", "cylinder 5 mm 90 deg", "ellipsoid 10 mm 4 mm", "punch 20 '
    'um", "cone 0.01", "wedge 0.01".',
    label="Nominal form",
    prepares=True,
)
COUNTER_BODY = Option.value(
    "counter-body",
    parsing.body,
    'Nominal form of the counter-body, as for --body; "cylinder -5.2 mm" is a groove; '
    "default: flat.",
    label="Counter-body form",
    prepares=True,
)
COUNTER_SURFACE = Option.value(
    "counter-surface",
    parsing.path,
    "Height map of the counter-body; another grid needs --align.",
    label="Counter-body map",
    prepares=True,
    files_in=lambda text: [text],
)
COUNTER_MAPS: Option[Any] = Option(
    "counter-maps",
    parsing.path,
    "Map of the counter-body's face, met at random shifts and turns; repeatable.",
    (),
    label="Maps of the counter-body's face",
    many=True,
    prepares=True,
    files_in=lambda text: [text],
)
DRAWS = Option(
    "draws", parsing.int_parser(2, 100), "Number of pairs of faces drawn; default: 5.", 5
)
ALIGN = Option.flag(
    "align",
    "Resample both maps to one grid, centered, and keep the overlap.",
    label="Resample both maps to one grid",
    prepares=True,
)
OFFSET = Option.value(
    "offset",
    parsing.offset,
    'Shift (y, x) of the aligned counter-map: "0 um, 5 um".',
    label="Counter-map shift (y, x)",
    prepares=True,
)
ANGLE = Option.value(
    "angle",
    parsing.DEGREES,
    "Rotation of the aligned counter-map, degrees counterclockwise.",
    label="Rotation of counter-map",
    prepares=True,
)
MIRROR = Option.flag(
    "mirror",
    "Mirror the aligned counter-map (measured from its own front).",
    label="Mirror counter-map",
    prepares=True,
)
MOVES: tuple[Option[Any], ...] = (ALIGN, OFFSET, ANGLE, MIRROR)
SHAPES = (BODY, COUNTER_BODY, COUNTER_SURFACE, *MOVES)
CEILING: Option[str | float | None] = Option(
    "ceiling",
    parsing.ceiling,
    'Pressure ceiling: "3 GPa", "62 HRC", calibrated, auto (3σ_Y) or none '
    "(elastic); coated: coating, base, bracket; default: auto.",
    "auto",
    label="Pressure ceiling",
)
BOUNDARY: Option[str] = Option(
    "boundary",
    parsing.choice(*Boundary).with_metavar("KIND"),
    "Beyond the map edge. "
    f"{'; '.join(f'{kind}: {kind.meaning}' for kind in Boundary)}; default: free.",
    Boundary.FREE,
)
BODIES = (*MATERIALS, *SHAPES, CEILING, BOUNDARY)

# Load

LOAD = Option.value(
    "load",
    parsing.load,
    'Load: "1 N", nominal pressure "20 MPa", line load "600 N/mm", or "hertz 1.5 GPa", the peak '
    "pressure of the smooth bodies.",
)
APPROACH = Option.value(
    "approach", LENGTH, 'Approach from first contact, instead of a load: "1 um".'
)
LOAD_POINT = Option.value(
    "load-point",
    parsing.offset,
    "Load position (y, x) from the map center; allows tilt. Default: no tilt.",
    label="Load position (y, x)",
)
LOADS = (LOAD, APPROACH, LOAD_POINT)
LOAD_RULES = (Rule(ONE_OF, LOAD, APPROACH, text="1 N"), Rule(NEEDS, LOAD_POINT, LOAD))

# Accuracy of the solve

TOLERANCE = Option.value(
    "tolerance",
    parsing.number,
    "Certificate limit; default: 1e-6 (single precision and elastoplastic model: 1e-4).",
    Panel.SOLVER,
)
MAX_ITERATIONS = Option.value(
    "max-iterations",
    parsing.int_parser(1, memory.ITERATIONS),
    "Maximum convolutions per grid; default: 2000 (elastoplastic model: 150 iterations per step).",
    Panel.SOLVER,
    label="Maximum convolutions",
)
PRECISION: Option[str | None] = Option.value(
    "precision",
    parsing.choice("double", "single"),
    "double or single (two thirds of the memory); default: double (elastoplastic model: single).",
    Panel.SOLVER,
)
DEVICE: Option[str | None] = Option.value(
    "device",
    parsing.choice("cpu", "cuda"),
    "cpu or cuda (displacement on a GPU, with the extra gpu); default: cpu.",
    Panel.SOLVER,
)
"""Device of all contacts of a run."""
SOLVER_DOUBLE = (TOLERANCE, MAX_ITERATIONS, DEVICE)
SOLVER = (*SOLVER_DOUBLE, PRECISION)

# Output files and console

FIGURES = Option.value(
    "figures",
    parsing.as_text.with_metavar("FOLDER|PREFIX"),
    "Figures: folder or file prefix; add .svg or .pdf for the format.",
    Panel.OUTPUT,
    suffixes=PICTURES,
)
REPORT = Option.file("report", "Report with figures as one HTML file.", (".html",))
FOLDER = Option.file("folder", "Folder for finished steps; the same command resumes.")
JSON = Option.flag("json", "Print JSON in SI units.", Panel.OUTPUT)
QUIET = Option.flag("quiet", "Print errors only.", Panel.OUTPUT)
VERBOSE = Option.flag("verbose", "Print all quantities, checks and notes.", Panel.OUTPUT)
SHOWN = (VERBOSE, JSON, QUIET)
"""Options of the console, which are not part of a run."""
HEAD = tuple(
    Option.value(
        name,
        parsing.as_text.with_metavar("TEXT"),
        f"{text} in the head of the report.",
        Panel.OUTPUT,
    )
    for name, text in (("project", "Project"), ("drawing", "Drawing number"), ("author", "Author"))
)
"""Options of the head of a report, with a line for the signature."""
REPORTING = (REPORT, *HEAD)
OUTPUT = (*REPORTING, *SHOWN)

RULES = (
    *(Rule(NEEDS, move, COUNTER_SURFACE) for move in MOVES),
    *(Rule(NEEDS, entry, REPORT) for entry in HEAD),
)
"""Rules of all tasks that have these options."""
