"""One run of the program: options in words in, files and a result out."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact import units
from roughcontact.errors import InputError, RoughcontactError
from roughcontact.formats import export

if TYPE_CHECKING:
    from roughcontact.contact.load_curve import LoadCurve
    from roughcontact.contact.load_history import LoadHistory
    from roughcontact.contact.resolution_study import ResolutionStudy
    from roughcontact.contact.result import ContactResult
    from roughcontact.contact.subsurface import StressResult
    from roughcontact.material.material import Material
    from roughcontact.report.chapters import Section
    from roughcontact.solvers.bounded import Step
    from roughcontact.surface.nominal import Body
    from roughcontact.surface.surface import Surface
    from roughcontact.volume.result import ElastoplasticResult

Say = Callable[[str], None]
Task = tuple[Path, Callable[[Path], object]]
Given = Mapping[str, str | bool | list[str]]

MAP, BODIES, SOLVER, OUTPUT = "Map", "Bodies and load", "Solver", "Output"

LEVELS = ("plane", "quadric", "mean", "robust", "none")
HOLES = ("error", "fill", "mask", "crop")
_HARDNESS = re.compile(r"\bH(V|B|BW|RB|RC)\d*\b", re.IGNORECASE)
FIGURES = {
    "ceiling": ("surface", "pressure", "contact", "gap", "histogram"),
    "volume": ("surface", "pressure", "gap", "histogram", "displacement", "section-x", "section-y",
               "profile", "layers", "path", "convergence"),
}  # fmt: skip
"""Names of the figures of each model."""


class UnfinishedError(Exception):
    """Ctrl-C, with the files that were complete by then."""

    def __init__(self, written: Sequence[Path]) -> None:
        super().__init__()
        self.written = written


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


def _quantity(dimension: str) -> Callable[[str, str], float]:
    return lambda text, name: units.parse(text, dimension, name)


def _text(text: str, name: str) -> str:
    return text


def _path(text: str, name: str) -> Path:
    return Path(text)


def _flag(text: str, name: str) -> bool:
    if text.lower() not in ("true", "false"):
        raise InputError(f"{name} must be true or false, got {text!r}")
    return text.lower() == "true"


def _float(text: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{name} must be a number without a unit, got {text!r}") from None


def _int(text: str, name: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise InputError(f"{name} must be a whole number, got {text!r}") from None


def _choice(*known: str) -> Callable[[str, str], str]:
    def chosen(text: str, name: str) -> str:
        if text not in known:
            raise InputError(f"{name} must be one of {', '.join(known)}, got {text!r}")
        return text

    return chosen


def _ceiling(text: str, name: str) -> str | float | None:
    from roughcontact.material import hardness

    plain = text.strip()
    if plain == "none":
        return None
    if plain == "auto":
        return plain
    if _HARDNESS.search(plain):
        try:
            return hardness.ceiling(plain)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
    return units.parse(text, "pressure", name)


def _material_name(text: str, name: str) -> Material:
    from roughcontact.material import catalogue

    try:
        return catalogue.material(text)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _hardening(text: str, name: str) -> tuple[str, tuple[float, ...]]:
    words = text.split()
    law, rest = (words[0].lower(), words[1:]) if words else ("", [])
    if law == "linear" and len(rest) == 2:
        return law, (units.parse(" ".join(rest), "pressure", name),)
    if law == "swift" and len(rest) == 4:
        strength = units.parse(" ".join(rest[:2]), "pressure", name)
        return law, (strength, _float(rest[2], name), _float(rest[3], name))
    raise InputError(
        f"{name} must read like 'linear 2 GPa' or 'swift 945 MPa 20 0.121', got {text!r}"
    )


def _body(text: str, name: str) -> Body:
    from roughcontact.surface import nominal as bodies

    return bodies.parse(text, name)


def _points(text: str, name: str) -> tuple[int, int]:
    match = re.fullmatch(r"\s*(\d+)(?:\s*[x×]\s*(\d+))?\s*", text)
    if match is None or int(match[1]) < 2:
        raise InputError(f"{name} must be a number of points such as 256 or 256x512, got {text!r}")
    return int(match[1]), int(match[2] or match[1])


def _offset(text: str, name: str) -> tuple[float, float]:
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(f"{name} needs two lengths (y, x) such as '0 um, 5 um', got {text!r}")
    y, x = (units.parse(part, "length", name, positive=False) for part in parts)
    return y, x


def _window(text: str, name: str) -> tuple[slice, slice]:
    match = re.fullmatch(r"\s*(\d*)\s*:\s*(\d*)\s*,\s*(\d*)\s*:\s*(\d*)\s*", text)
    if match is None:
        raise InputError(
            f"{name} needs the first row and the row after the last, and the same of the columns, "
            f"such as 0:256,100:356, got {text!r}"
        )
    ends = [int(digits) if digits else None for digits in match.groups()]
    return slice(ends[0], ends[1]), slice(ends[2], ends[3])


def _form(text: str, name: str) -> tuple[str, int | None]:
    words = text.split()
    if words in (["sphere"], ["cylinder"]):
        return words[0], None
    if len(words) == 2 and words[0] == "polynomial" and words[1].isdigit():
        return "polynomial", int(words[1])
    raise InputError(f"{name} must be sphere, cylinder or 'polynomial N', got {text!r}")


def load_or_approach(text: str, name: str) -> tuple[str, float]:
    """Return which of the two a text with a unit is, and its value."""
    try:
        return "approach", units.parse(text, "length", name)
    except InputError:
        pass
    try:
        return "load", units.parse(text, "force", name)
    except InputError as error:
        reason = str(error)
    # Only where neither fits: a number that is not positive has its dimension.
    start, mark, found = reason.partition(", got ")
    if "needs a force" in start and mark:
        reason = f"{name} needs a load such as '1 N', or an approach such as '1 um', got {found}"
    raise InputError(reason)


def stage(text: str, name: str) -> tuple[str, float]:
    """Return which of load and approach a text is, and its value; a load may be zero."""
    plain = text.strip()
    if re.fullmatch(r"0+(\.0*)?\s*\w*N", plain):
        return "load", 0.0
    return load_or_approach(plain, name)


def _turns(text: str, name: str) -> int:
    degrees = _float(text, name)
    if degrees % 90:
        raise InputError(f"{name} must be a multiple of 90 degrees, got {text!r}")
    return int(degrees // 90)


OPTIONS: dict[str, Option] = {
    "format": Option(MAP, "NAME", "Format of the file; by default its suffix decides.", _text),
    "channel": Option(
        MAP, "NAME|INDEX", "Height channel; by default the file's own choice.", _text
    ),
    "unit": Option(MAP, "UNIT", "Unit of the heights, if the file gives none: um.", _text),
    "size": Option(
        MAP, "LENGTHS",
        'Sides (y, x) of the map, if the file gives none or there is none: "0.1 mm x 0.2 mm".',
        _text,
    ),
    "tip-radius": Option(
        MAP, "LENGTH", 'Radius of the tip of a scanning probe, such as "10 nm": tells below which '
        "scale the map shows the tip.", _quantity("length"),
    ),
    "points": Option(
        MAP, "NUMBER|NYxNX", "Grid of a nominal --body that needs no FILE, such as 256.", _points
    ),
    "crop": Option(MAP, "ROWS,COLUMNS", "Part of the map to keep, such as 0:256,100:356.", _window),
    "outliers": Option(
        MAP, "NUMBER",
        "Take points further than so many robust standard deviations from their surroundings as "
        "missing, such as 6.", _float,
    ),
    "level": Option(
        MAP, "|".join(LEVELS),
        "What is fitted and subtracted; plane (least squares) by default.", _choice(*LEVELS),
    ),
    "form": Option(
        MAP, "FORM",
        'Form to remove by least squares: sphere, cylinder or "polynomial 4".', _form,
    ),
    "holes": Option(
        MAP, "|".join(HOLES),
        "Missing points: error (default) refuses them, fill interpolates smoothly, mask "
        "lets them never touch, crop keeps the largest rectangle without them.", _choice(*HOLES),
    ),
    "s-filter": Option(
        MAP, "LENGTH", 'Remove waves shorter than this (ISO 16610-61), such as "2.5 um".',
        _quantity("length"),
    ),
    "l-filter": Option(
        MAP, "LENGTH", 'Remove waves longer than this, such as "80 um".', _quantity("length")
    ),
    "pixel": Option(
        MAP, "LENGTH", 'Resample (cubic splines) to about this pixel, such as "0.5 um".',
        _quantity("length"),
    ),
    "rotate": Option(MAP, "DEGREES", "Turn counter-clockwise by a multiple of 90.", _turns),
    "load": Option(
        BODIES, "FORCE", 'Normal load, such as "1 N"; this or --approach.', _quantity("force")
    ),
    "approach": Option(
        BODIES, "LENGTH", 'Approach of the bodies from the first touch, such as "1 um".',
        _quantity("length"),
    ),
    "material": Option(
        BODIES, "NAME",
        "Material of the catalogue, such as 100Cr6; see roughcontact materials. Or give --young, "
        "--poisson and --yield-strength, which also replace single values of it.", _material_name,
    ),
    "load-point": Option(
        BODIES, "LENGTHS",
        'Let the bodies tilt until the load acts at this offset (y, x) from the middle of the map, '
        'such as "0 um, 5 um"; they keep their angle without.', _offset,
    ),
    "young": Option(
        BODIES, "PRESSURE", 'Young\'s modulus, such as "210 GPa".', _quantity("pressure")
    ),
    "poisson": Option(BODIES, "NUMBER", "Poisson's ratio, such as 0.3.", _float),
    "yield-strength": Option(
        BODIES, "PRESSURE", 'Yield strength, such as "1 GPa".', _quantity("pressure")
    ),
    "counter-material": Option(
        BODIES, "NAME", "Material of the counter-body; it is rigid without.", _material_name
    ),
    "counter-young": Option(
        BODIES, "PRESSURE", "Young's modulus of the counter-body.", _quantity("pressure")
    ),
    "counter-poisson": Option(BODIES, "NUMBER", "Poisson's ratio of the counter-body.", _float),
    "counter-yield-strength": Option(
        BODIES, "PRESSURE", "Yield strength of the counter-body.", _quantity("pressure")
    ),
    "body": Option(
        BODIES, "FORM",
        'Nominal form under the roughness, or alone with --points and --size: "sphere 10 mm", '
        '"cylinder 5 mm 90 deg", "ellipsoid 10 mm 4 mm", "punch 20 um", "cone 0.01", "wedge 0.01".',
        _body,
    ),
    "counter-body": Option(
        BODIES, "FORM", "Nominal form of the counter-body; a flat without.", _body
    ),
    "counter-surface": Option(
        BODIES, "FILE",
        "Height map of the counter-body, laid on point by point, so on the same grid unless "
        "--align is given.", _path,
    ),
    "align": Option(
        BODIES, "",
        "Bring both maps to one grid, centre on centre, and keep what both cover.", _flag,
    ),
    "offset": Option(
        BODIES, "LENGTHS", 'Shift (y, x) of the aligned counter-map: "0 um, 5 um".', _offset
    ),
    "angle": Option(
        BODIES, "DEGREES", "Turn of the aligned counter-map, from x towards y.", _float
    ),
    "mirror": Option(
        BODIES, "", "Mirror the aligned counter-map, as one measured from its front needs.", _flag
    ),
    "ceiling": Option(
        BODIES, "PRESSURE",
        'Largest pressure, such as "3 GPa", or a hardness, such as "62 HRC"; or auto (default): '
        "3 times the smaller yield strength, or the hardness where there is none; or none: purely "
        "elastic.", _ceiling,
    ),
    "model": Option(
        BODIES, "ceiling|volume",
        "ceiling (default): pressures up to the ceiling; volume: plastic strain in the volume, "
        "which takes seconds to minutes.", _choice("ceiling", "volume"),
    ),
    "increments": Option(
        BODIES, "NUMBER", "Steps to the load of the volume model; 10 by default.", _int
    ),
    "unload": Option(
        BODIES, "", "Take the bodies of the volume model apart in the end: what stays.", _flag
    ),
    "hardening": Option(
        BODIES, "LAW",
        'Of the rough body: "linear 2 GPa" (modulus) or "swift 945 MPa 20 0.121" (B, C, n of '
        'B (C + 1e6 e)^n); for the volume model, and for the ceiling that is recommended.',
        _hardening,
    ),
    "boundary": Option(
        BODIES, "free|periodic",
        "free (default): the map is all there is; periodic: it repeats.",
        _choice("free", "periodic"),
    ),
    "tolerance": Option(
        SOLVER, "NUMBER",
        "Certificate to reach; 1e-6 by default, 1e-4 in single precision. Of the volume model the "
        "residual of the plastic strain; 1e-4 by default.", _float,
    ),
    "max-iterations": Option(
        SOLVER, "NUMBER",
        "Most convolutions on any one grid; 500 by default. Of the volume model most iterations at "
        "one load; 150 by default.", _int,
    ),
    "precision": Option(
        SOLVER, "double|single",
        "single needs two thirds of the memory; double by default, single for the volume model.",
        _choice("double", "single"),
    ),
    "study": Option(
        SOLVER, "",
        "Solve again on coarser and finer grids, with filters and other ceilings, and tell what "
        "depends on them.", _flag,
    ),
    "output": Option(
        OUTPUT, "FILE",
        "Write the result: .nc everything, .vti maps for ParaView, .csv pressure, .json numbers, "
        ".vtr strain and stress of the volume model; may be given again.", _path, many=True,
    ),
    "folder": Option(
        OUTPUT, "FOLDER",
        "Where the volume model keeps every load that is reached, to go on later.", _path,
    ),
    "report": Option(
        OUTPUT, "FILE.html", "Write a report with figures into one HTML file.", _path
    ),
    "figures": Option(
        OUTPUT, "FOLDER|PREFIX",
        "Write surface, pressure, contact, gap and histogram (of the volume model sections and "
        "profiles instead of the contact) as PNG into an existing folder, or with this start of "
        "their names; with .svg or .pdf at its end in that format.", _text,
    ),
}  # fmt: skip
"""Every option that describes one run, in the order of the help."""


@dataclass(frozen=True)
class Job:
    """One contact to solve: what was asked for, checked as far as it can be without its files.

    Parameters
    ----------
    file : Path or None
        The measured map; without it, a nominal body on ``points``.
    given : Mapping
        The options that were given, as text, to repeat the run.

    sweeps : bool
        Whether its loads or approaches are given elsewhere.

    The other fields are the values of `OPTIONS`, under their names with underscores.
    """

    file: Path | None
    given: Given = field(default_factory=dict)
    format: str | None = None
    channel: str | None = None
    unit: str | None = None
    size: str | None = None
    tip_radius: float | None = None
    points: tuple[int, int] | None = None
    crop: tuple[slice, slice] | None = None
    outliers: float | None = None
    level: str = "plane"
    form: tuple[str, int | None] | None = None
    holes: str = "error"
    s_filter: float | None = None
    l_filter: float | None = None
    pixel: float | None = None
    rotate: int = 0
    load: float | None = None
    approach: float | None = None
    load_point: tuple[float, float] | None = None
    material: Material | None = None
    young: float | None = None
    poisson: float | None = None
    yield_strength: float | None = None
    counter_material: Material | None = None
    counter_young: float | None = None
    counter_poisson: float | None = None
    counter_yield_strength: float | None = None
    body: Body | None = None
    counter_body: Body | None = None
    counter_surface: Path | None = None
    align: bool = False
    offset: tuple[float, float] | None = None
    angle: float | None = None
    mirror: bool = False
    ceiling: str | float | None = "auto"
    model: str = "ceiling"
    increments: int | None = None
    unload: bool = False
    hardening: tuple[str, tuple[float, ...]] | None = None
    boundary: str = "free"
    tolerance: float | None = None
    max_iterations: int = 500
    precision: str = "double"
    study: bool = False
    output: tuple[Path, ...] = ()
    folder: Path | None = None
    report: Path | None = None
    figures: str | None = None
    sweeps: bool = False

    def __post_init__(self) -> None:
        """Refuse what can be seen to be wrong without looking at any file."""
        if self.file is None and (self.body is None or self.points is None or self.size is None):
            raise InputError(
                "FILE is missing, see roughcontact solve --help; or give --body, --points and "
                "--size for a nominal body without roughness"
            )
        if self.file is not None and self.points is not None:
            raise InputError("--points goes with a nominal --body without FILE; see --pixel")
        if self.counter_surface is None and self._aligned:
            raise InputError("--align, --offset, --angle and --mirror need a --counter-surface")
        self.bodies()
        if (self.load is None) == (self.approach is None) and not self.sweeps:
            raise InputError(
                "give either --load or --approach, and only one of them, such as --load '1 N'"
            )
        if self.model == "volume":
            self._check_volume()
        else:
            for name in ("increments", "unload", "folder"):
                if name in self.given:
                    raise InputError(f"--{name} needs --model volume")
        if self.load_point is not None and (self.load is None or self.study):
            raise InputError("--load-point needs --load, and goes without --study")
        volume = self.model == "volume"
        for path in self.output:
            _check_suffix(
                path, "--output", export.VOLUME_SUFFIXES if volume else export.RESULT_SUFFIXES
            )
        if self.report is not None:
            _check_suffix(self.report, "--report", (".html",))

    def check_places(self) -> None:
        """Refuse outputs that cannot be written, or would replace an input."""
        figures = figure_files(self.figures, FIGURES[self.model]).values()
        for option, path in (
            *(("--output", path) for path in self.output),
            *(("--report", path) for path in (self.report,) if path is not None),
            *(("--figures", path) for path in figures),
        ):
            check_place(path, option)
            for other in self.inputs:
                if path.exists() and other.exists() and path.samefile(other):
                    raise InputError(f"{option} '{path}' is an input file; give another name")

    @property
    def inputs(self) -> list[Path]:
        """The files that are read."""
        return [path for path in (self.file, self.counter_surface) if path is not None]

    def bodies(self) -> tuple[Material, Material]:
        """Return the materials of both bodies; the second is rigid if nothing is said of it."""
        from roughcontact.material.material import RIGID, Material

        first = _material("", self.material, self.young, self.poisson, self.yield_strength)
        if self.hardening is not None:
            first = _hardened(first, self.yield_strength, *self.hardening)
        given = (self.counter_young, self.counter_poisson, self.counter_yield_strength)
        if self.counter_material is None and given[:2] == (None, None):
            strength = self.counter_yield_strength
            rigid = Material(RIGID.young, 0.0, strength, RIGID.name) if strength else RIGID
            return first, rigid
        return first, _material("counter-", self.counter_material, *given)

    def _check_volume(self) -> None:
        given = {
            "--approach": self.approach is not None,
            "--load-point": self.load_point is not None,
            "--ceiling": self.ceiling != "auto",
            "--study": self.study,
        }
        for option, used in given.items():
            if used:
                raise InputError(f"{option} goes with --model ceiling, not with volume")
        if self.increments is not None and self.increments < 1:
            raise InputError(f"--increments must be at least 1, got {self.increments}")
        if all(body.yield_strength is None for body in self.bodies()):
            raise InputError(
                "--model volume needs a --yield-strength such as '1 GPa', or a --material that has "
                "one: otherwise nothing can yield"
            )

    @property
    def moments(self) -> tuple[float, float] | None:
        """Moments (y, x) about the middle of the map that a tilt has to balance [N m]."""
        if self.load_point is None or self.load is None:
            return None
        return self.load * self.load_point[0], self.load * self.load_point[1]

    @property
    def _aligned(self) -> bool:
        given = self.offset is not None or self.angle is not None
        return self.align or self.mirror or given

    def surfaces(self, say: Say) -> list[Surface]:
        """Read and prepare the map, and that of the counter-body if there is one."""
        from roughcontact.formats import read
        from roughcontact.surface import nominal as bodies

        maps = []
        for path in self.inputs:
            say(f"reading {path.name}")
            surface = read.read_surface(path, self.format, self.channel, self.unit, self.size)
            maps.append(self._prepared(surface, path))
        if self.file is None:
            maps.insert(0, self._nominal())
        elif self.body is not None:
            maps[0] = _formed(maps[0], self.body)
        if self._aligned:
            say("aligning the maps")
            place = self.offset or (0.0, 0.0), self.angle or 0.0, self.mirror
            first, second = bodies.matched(maps[0], maps[1], *place)
            # What one of them does not cover the other cannot touch.
            maps = [first.masked(), second.masked()]
        if self.counter_body is not None:
            if len(maps) == 2:
                maps[1] = _formed(maps[1], self.counter_body)
            else:
                maps.append(self.counter_body(shape=maps[0].shape, pixel=maps[0].pixel))
        return maps

    def problem(self, maps: Sequence[Surface]) -> dict[str, Any]:
        """Return the arguments that `solve` and its relatives share, but for load or approach."""
        first, second = self.bodies()
        return {
            "material": first,
            "counter_material": second,
            "counter_surface": maps[1] if len(maps) > 1 else None,
            "ceiling": self.ceiling,
            "boundary": self.boundary,
            "tolerance": self.tolerance,
            "precision": self.precision,
        }

    def resolution_notes(self, maps: Sequence[Surface]) -> tuple[str, ...]:
        """Return what limits the lateral resolution of the prepared maps, each in one sentence."""
        measured = [surface for surface in maps if surface.provenance.instrument]
        notes = (surface.resolution_notes(self.tip_radius) for surface in measured)
        return tuple(dict.fromkeys(note for found in notes for note in found))

    def command(self, name: str) -> str:
        """Return the command that repeats the run."""
        import shlex

        words = ["roughcontact", name, *([] if self.file is None else [str(self.file)])]
        for option, value in self.given.items():
            for text in value if isinstance(value, list) else [value]:
                words += [f"--{option}"] if text is True else [f"--{option}", str(text)]
        return shlex.join(words)

    def _nominal(self) -> Surface:
        from roughcontact.formats import read

        assert self.body is not None
        assert self.points is not None
        pixel = read.pixel_of(self.size, self.points)
        return self.body(shape=self.points, pixel=pixel)

    def _prepared(self, surface: Surface, path: Path) -> Surface:
        # Points go first, then form, then waves: each step sees what the one before has cleaned.
        if self.crop is not None:
            rows, columns = (
                (part.start or 0, points if part.stop is None else part.stop)
                for part, points in zip(self.crop, surface.shape, strict=True)
            )
            surface = surface.cropped(rows, columns)
        if self.outliers is not None:
            surface = surface.without_outliers(self.outliers)
        if self.holes == "crop" and surface.missing:
            surface = surface.largest_rectangle()
        if self.level != "none":
            surface = surface.leveled(self.level)
        if self.form is not None:
            surface = surface.without_form(*self.form)
        if surface.missing and self.holes == "error":
            raise InputError(
                f"{path.name} has {surface.missing} missing points; choose --holes fill (smooth "
                "interpolation), --holes mask (they never touch) or --holes crop (the largest "
                "rectangle without them), or cut them away with --crop"
            )
        surface = surface.filled() if self.holes == "fill" else surface.masked()
        if self.s_filter is not None or self.l_filter is not None:
            surface = surface.filtered(self.s_filter, self.l_filter)
        if self.pixel is not None:
            surface = surface.resampled(pixel=(self.pixel, self.pixel), method="spline")
        return surface.rotated(self.rotate) if self.rotate % 4 else surface


def from_text(
    file: Path | None,
    given: Given,
    name: Callable[[str], str] = lambda key: f"--{key}",
    sweeps: bool = False,
) -> Job:
    """Return the job that options in words describe.

    Parameters
    ----------
    file : Path or None
        The measured map.
    given : Mapping
        Text by the names in `OPTIONS`; ``True`` for a flag, a list for what may come again.
    name : callable
        What an error message calls an option.
    sweeps : bool
        Whether loads or approaches are given elsewhere.

    Returns
    -------
    Job
        The job, checked.

    Raises
    ------
    InputError
        If a value cannot be used, or values do not go together.
    """
    values: dict[str, Any] = {}
    for key, value in given.items():
        parse = OPTIONS[key].parse
        if isinstance(value, list):
            parsed: Any = tuple(parse(text, name(key)) for text in value)
        else:
            parsed = value if isinstance(value, bool) else parse(value, name(key))
        values[key.replace("-", "_")] = parsed
    return Job(file=file, given=dict(given), sweeps=sweeps, **values)


@dataclass(frozen=True)
class Outcome:
    """What a job gave.

    Parameters
    ----------
    result : ContactResult
        The solution, or the best found.
    volume : ElastoplasticResult or None
        What the volume model found, of which ``result`` is the contact.
    study : ResolutionStudy or None
        The same on other grids, if it was asked for.
    notes : tuple of str
        What limits the lateral resolution of the maps.
    written : tuple of Path
        Files that are complete.
    failure : RoughcontactError or None
        Why a file could not be written.
    """

    result: ContactResult
    volume: ElastoplasticResult | None = None
    study: ResolutionStudy | None = None
    notes: tuple[str, ...] = ()
    written: tuple[Path, ...] = ()
    failure: RoughcontactError | None = None

    @property
    def status(self) -> str:
        """``"converged"``, or why the solver stopped."""
        return self.result.status if self.volume is None else self.volume.status


def run(job: Job, say: Say, look: Callable[[Step], None] | None = None) -> Outcome:
    """Read, prepare, solve, and write what was asked for.

    Parameters
    ----------
    job : Job
        What to do.
    say : callable
        Called with a few words before every stage.
    look : callable, optional
        Called with every `Step` of the solver.

    Returns
    -------
    Outcome
        The result, even where its files could not be written. No file is written for one that
        did not converge.

    Raises
    ------
    RoughcontactError
        If the job cannot be done.
    """
    from roughcontact.contact import resolution_study as study
    from roughcontact.contact import solve as contact

    job.check_places()
    maps = job.surfaces(say)
    if job.model == "volume":
        return _run_volume(job, maps, say)
    result = contact.solve(
        maps[0],
        **job.problem(maps),
        load=job.load,
        approach=job.approach,
        moments=job.moments,
        max_iterations=job.max_iterations,
        on_failure="return",
        progress=look,
    )
    if not result.converged:
        return Outcome(result)
    looked_at = None
    if job.study:
        looked_at = study.resolution_study(
            maps[0],
            **job.problem(maps),
            load=result.load,
            progress=lambda text: say(f"study: {text}"),
        )
    notes = job.resolution_notes(maps)
    # The numbers are shown even where the files cannot be written.
    try:
        written = tuple(write(_tasks(job, result, looked_at, notes), say))
    except RoughcontactError as error:
        return Outcome(result, None, looked_at, notes, failure=error)
    return Outcome(result, None, looked_at, notes, written)


def _run_volume(job: Job, maps: Sequence[Surface], say: Say) -> Outcome:
    from roughcontact.volume import loop as increments
    from roughcontact.volume import solve as elastoplastic

    assert job.load is not None
    load = job.load
    first, second = job.bodies()
    # Both models have defaults of their own.
    solver = {
        key.replace("-", "_"): getattr(job, key.replace("-", "_"))
        for key in ("tolerance", "max-iterations", "precision")
        if key in job.given
    }

    def look(at: increments.Progress) -> None:
        state = f"iteration {at.iteration}, residual {at.residual:.1e}"
        say(
            f"{units.percent(at.load / load)} of the load: "
            f"{state if at.iteration else f'kept in {job.folder}'}"
        )

    steps = job.increments or 10
    loads = [*(load * i / steps for i in range(1, steps)), load, *([0.0] * job.unload)]
    try:
        found = elastoplastic.solve_elastoplastic(
            maps[0],
            material=first,
            counter_material=second,
            counter_surface=maps[1] if len(maps) > 1 else None,
            boundary=job.boundary,
            loads=loads,
            on_failure="return",
            folder=job.folder,
            progress=look,
            **solver,
        )
    except KeyboardInterrupt:
        kept = () if job.folder is None else sorted(job.folder.glob("step-*.nc"))
        raise UnfinishedError(kept) from None
    notes = job.resolution_notes(maps)
    if not found.converged:
        return Outcome(found.contact, found, notes=notes)
    tasks: list[Task] = [(path, found.save) for path in job.output]
    if job.report is not None:
        chapters, command = sections(None, notes), job.command("solve")
        tasks.append((job.report, lambda path: found.report(path, command, chapters)))
    tasks += _figure_tasks(job, found.contact, found)
    try:
        written = tuple(write(tasks, say))
    except RoughcontactError as error:
        return Outcome(found.contact, found, notes=notes, failure=error)
    return Outcome(found.contact, found, notes=notes, written=written)


def write(tasks: Iterable[Task], say: Say) -> list[Path]:
    """Write files one after the other and return those that are complete.

    Raises
    ------
    InputError
        If a file cannot be written.
    UnfinishedError
        If Ctrl-C came.
    """
    written: list[Path] = []
    for path, save in tasks:
        say(f"writing {path}")
        try:
            save(path)
        except KeyboardInterrupt:
            raise UnfinishedError(written) from None
        except OSError as error:
            reason = error.strerror or " ".join(str(error).split())
            raise InputError(
                f"{path} cannot be written ({reason}); what was there before is unchanged"
            ) from None
        written.append(path)
    return written


def saver(draw: Callable[[], Any]) -> Callable[[Path], object]:
    """Return what draws a figure and saves it."""
    from roughcontact.plots import saving

    return lambda path: saving.save(draw(), path)


def figure_files(start: str | None, names: Sequence[str]) -> dict[str, Path]:
    """Return the files of figures: in a folder, or with the start of their names."""
    if start is None:
        return {}
    if Path(start).is_dir():
        return {name: Path(start) / f"{name}.png" for name in names}
    if start.endswith(("/", os.sep)):
        raise InputError(f"--figures: the folder '{start}' does not exist; create it first")
    suffix = Path(start).suffix.lower()
    suffix = suffix if suffix in (".png", ".svg", ".pdf") else ""
    stem = start[: len(start) - len(suffix)]
    return {name: Path(f"{stem}-{name}{suffix or '.png'}") for name in names}


def check_place(path: Path, option: str) -> None:
    """Raise `InputError` unless a file of that name can be written."""
    folder = path.parent
    if path.is_dir():
        raise InputError(f"{option} '{path}' is a folder; give the name of a file")
    if not folder.is_dir():
        raise InputError(f"{option}: the folder '{folder}' does not exist; create it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{option}: no permission to write into the folder '{folder}'")


def _material(
    prefix: str,
    known: Material | None,
    young: float | None,
    poisson: float | None,
    yield_strength: float | None,
) -> Material:
    from roughcontact.material.material import Material

    try:
        if known is not None:
            return replace(
                known,
                young=known.young if young is None else young,
                poisson=known.poisson if poisson is None else poisson,
                yield_strength=known.yield_strength if yield_strength is None else yield_strength,
            )
        if young is None or poisson is None:
            missing = f"--{prefix}young" if young is None else f"--{prefix}poisson"
            example = "'210 GPa'" if young is None else "0.3"
            raise InputError(
                f"{missing} is needed, such as {missing} {example}; or --{prefix}material with a "
                "name of the catalogue"
            )
        return Material(young, poisson, yield_strength)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith("--") else f"--{prefix}{text}") from None


def _hardened(
    material: Material, given: float | None, law: str, constants: tuple[float, ...]
) -> Material:
    """Return a material that hardens; ``given`` is the yield strength that was asked for."""
    from roughcontact.material import hardening as plasticity

    if law == "swift":
        try:
            swift = plasticity.Swift(*constants)
        except InputError as error:
            raise InputError(f"--hardening: {error}") from None
        if given is not None and not math.isclose(given, swift.initial, rel_tol=1e-3):
            first, other = (units.engineering(value, "Pa") for value in (swift.initial, given))
            raise InputError(
                f"--hardening starts at a yield strength of {first}, but --yield-strength is "
                f"{other}; leave --yield-strength out"
            )
        return replace(material, yield_strength=None, hardening=swift)
    if material.yield_strength is None:
        raise InputError("--hardening linear needs a --yield-strength to start from")
    linear = plasticity.Linear(material.yield_strength, constants[0])
    return replace(material, hardening=linear)


def _formed(surface: Surface, body: Body) -> Surface:
    return surface.with_form(body(shape=surface.shape, pixel=surface.pixel))


def _check_suffix(path: Path, option: str, suffixes: tuple[str, ...]) -> None:
    if path.suffix.lower() not in suffixes:
        known = " or ".join([", ".join(suffixes[:-1]), suffixes[-1]] if suffixes[1:] else suffixes)
        volume = path.suffix.lower() in export.VOLUME_SUFFIXES and option == "--output"
        more = f"; {path.suffix} needs --model volume" if volume else ""
        raise InputError(f"{option} needs a name that ends in {known}, got '{path}'{more}")


def _tasks(
    job: Job, result: ContactResult, study: ResolutionStudy | None, notes: tuple[str, ...]
) -> list[Task]:
    tasks: list[Task] = [(path, result.save) for path in job.output]
    if job.report is not None:
        chapters, command = sections(study, notes), job.command("solve")
        tasks.append((job.report, lambda path: result.report(path, command, chapters)))
    return tasks + _figure_tasks(job, result)


def _figure_tasks(
    job: Job, result: ContactResult, volume: ElastoplasticResult | None = None
) -> list[Task]:
    from roughcontact.plots import maps, profiles
    from roughcontact.plots import volume as volume_plots

    draw: dict[str, Callable[[], Any]] = {
        "surface": lambda: maps.surface(result.surface),
        "pressure": lambda: maps.pressure(result),
        "contact": lambda: maps.contact(result),
        "gap": lambda: maps.gap(result),
        "histogram": lambda: profiles.pressure_histogram([result]),
    }
    if volume is not None:
        draw |= {
            "displacement": lambda: volume_plots.residual_displacement(volume),
            "section-x": lambda: volume_plots.section(volume, "x"),
            "section-y": lambda: volume_plots.section(volume, "y"),
            "profile": lambda: volume_plots.profile(volume),
            "layers": lambda: volume_plots.layers(volume),
            "path": lambda: volume_plots.path(volume),
            "convergence": lambda: volume_plots.convergence(volume),
        }
    files = figure_files(job.figures, FIGURES[job.model])
    return [(path, saver(draw[name])) for name, path in files.items()]


def sections(study: ResolutionStudy | None, notes: tuple[str, ...]) -> list[Section]:
    """Return the chapters of a report that the result itself does not hold."""
    from roughcontact.report.chapters import Section

    chapters = []
    if notes:
        chapters.append(
            Section("What the measurement resolves", tuple(_sentence(n) for n in notes))
        )
    if study is not None:
        head = ("case", "contact", "saturated", "largest pressure", "mean pressure")
        rows = [
            (
                name,
                units.percent(case.contact_fraction),
                units.percent(case.saturated_fraction),
                units.engineering(case.max_pressure, "Pa"),
                units.engineering(case.mean_pressure, "Pa"),
            )
            for name, case in study.named()
        ]
        chapters.append(Section("Can it be trusted", study.sentences, (head, *rows)))
    return chapters


def first_yield(stress: StressResult) -> StressResult:
    """Return the contact of the same bodies at the load at which the first point yields."""
    from roughcontact.contact import subsurface

    contact = stress.contact
    return subsurface.yield_onset(
        contact.surface,
        material=contact.material,
        counter_material=contact.counter_material,
        counter_surface=contact.counter_surface,
        body=stress.body,
        friction=stress.friction,
        direction=stress.direction,
        boundary=contact.boundary,
    )


def stress_section(stress: StressResult) -> Section:
    """Return the chapter of a report on the stress below the surface."""
    from roughcontact.plots import stress as stress_plots
    from roughcontact.report.chapters import Section

    told = stress.summary()
    depth, y, x = stress.place
    rows = [
        ("quantity", "value"),
        ("Largest von Mises stress", units.engineering(stress.max_von_mises, "Pa")),
        ("Its depth", units.engineering(depth, "m")),
        ("Its place (y, x)", f"{units.engineering(y, 'm')}, {units.engineering(x, 'm')}"),
        ("Largest Tresca stress", units.engineering(told["max_tresca"], "Pa")),
        (
            "Orthogonal shear amplitude, pass along y",
            units.engineering(told["max_orthogonal_shear_along_y"], "Pa"),
        ),
        (
            "Orthogonal shear amplitude, pass along x",
            units.engineering(told["max_orthogonal_shear_along_x"], "Pa"),
        ),
    ]
    if stress.yield_factor is not None:
        rows.append(("Yield strength over largest stress", f"{stress.yield_factor:.4g}"))
    if stress.yielded_volume is not None:
        rows.append(("Volume above the yield strength", f"{1e18 * stress.yielded_volume:.4g} µm³"))
    text = (
        f"Elastic stress in the {stress.body} body under the pressure found"
        + (f", with a friction coefficient of {stress.friction:g}" if stress.friction else "")
        + ". Tension is positive.",
        *(_sentence(note) for note in stress.warnings if note not in stress.contact.warnings),
    )
    figures = (
        ("Largest equivalent stresses at each depth.", stress_plots.stress_depth(stress)),
        ("Von Mises stress on planes through its maximum.", stress_plots.stress_section(stress)),
        ("Largest von Mises stress over all depths.", stress_plots.stress_map(stress)),
    )
    return Section("Stress below the surface", text, tuple(rows), figures)


def history_section(history: LoadHistory) -> Section:
    """Return the chapter of a report on a load history."""
    from roughcontact.plots import curves
    from roughcontact.report.chapters import Section

    head = ("step", "load", "approach", "contact", "saturated", "newly indented", "dissipated")
    nominal = history.last.pressure.size * history.last.pixel_area
    rows = [
        (
            str(number),
            units.engineering(step.load, "N"),
            units.engineering(step.approach, "m"),
            units.percent(step.contact_area / nominal),
            units.percent(step.saturated_area / nominal),
            f"{1e18 * step.indentation_volume:.3g} µm³",
            units.engineering(step.dissipated_energy, "J", 3),
        )
        for number, step in enumerate(history.steps, start=1)
    ]
    told = history.summary()
    body = "first body" if history.indented_body == "surface" else "counter-body"
    text = (
        f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
        f"indentation, {units.engineering(told['max_indentation'], 'm')} at most; unloading is "
        "elastic. The rest of this report is on the last step.",
        "Shaken down: the last pass adds no indentation."
        if history.shaken_down
        else "Not shaken down: the last pass still adds indentation.",
        str(told["volume_account"]),
    )
    figures = (("Load against approach, and what each step costs.", curves.hysteresis(history)),)
    return Section("Load history", text, (head, *rows), figures)


def curve_report(job: Job, maps: Sequence[Surface], curve: LoadCurve) -> Callable[[Path], object]:
    """Return what writes the report of a load curve, with the contact at its last load."""
    from roughcontact.contact import solve as contact
    from roughcontact.report import contact as report

    def save(path: Path) -> None:
        result = contact.solve(
            maps[0],
            **job.problem(maps),
            load=curve.steps[-1].load,
            max_iterations=job.max_iterations,
        )
        chapters = sections(None, job.resolution_notes(maps))
        twin = result.elastic() if result.saturated_fraction else None
        report.save(
            result, path, elastic=twin, curve=curve, sections=chapters,
            command=job.command("sweep"),
        )  # fmt: skip

    return save


def _sentence(note: str) -> str:
    return f"{note[:1].upper()}{note[1:]}."


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
