"""The options of all commands and of project files: one table."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from roughcontact import limits, units
from roughcontact.errors import Mention
from roughcontact.formats import export
from roughcontact.formats.export import Kind
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import (
    comparison_options,
    desk_options,
    estimate_options,
    fleet_options,
    joint_options,
    parsing,
    rolling_options,
    surface_options,
    tasks,
)
from roughcontact.request.option import (
    BODIES,
    CAPPED,
    COMPARE as COMPARE,
    CONDUCTANCE as CONDUCTANCE,
    ESTIMATE as ESTIMATE,
    FIND as FIND,
    HISTORY as HISTORY,
    JOINTS,
    LAW as LAW,
    LENGTH,
    MAP,
    OUTPUT,
    PICTURES as PICTURES,
    PREPARED,
    PRESSURE,
    ROLL as ROLL,
    SINGLE,
    SOLVE as SOLVE,
    SOLVER,
    STRESS as STRESS,
    SWEEP as SWEEP,
    TABLES,
    TASKS as TASKS,
    Option as Option,
)

GENERATE, DESK, RUN = surface_options.GENERATE, desk_options.DESK, fleet_options.RUN
VERIFY, INFO, MATERIALS, DEMO = "verify", "info", "materials", "demo"
COMMANDS = (*TASKS, ESTIMATE, GENERATE, RUN, DESK, VERIFY, INFO, MATERIALS, DEMO)

Given = Mapping[str, str | bool | list[str]]
"""Options as text by their names: True for a flag, a list for what may be repeated."""

CEILING, VOLUME = "ceiling", "volume"
"""The models of ``SOLVE``."""

LEVELS = ("plane", "quadric", "mean", "robust", "none")
HOLES = ("error", "fill", "fill-all", "mask", "crop")
SURFACES = export.suffixes(Kind.SURFACE)
RESULTS = {CEILING: export.suffixes(Kind.CONTACT), VOLUME: export.suffixes(Kind.VOLUME)}
"""How files of results may end, by model."""
ALL_RESULTS = export.suffixes(Kind.CONTACT, Kind.VOLUME)
_UNITS = {
    parsing.load: "N", parsing.nominal: "Pa", LENGTH: "m", PRESSURE: "Pa", parsing.ceiling: "Pa",
}  # fmt: skip

OPTIONS = (
    *surface_options.OPTIONS,
    *desk_options.OPTIONS,
    *fleet_options.OPTIONS,
    *comparison_options.MAPS,
    *joint_options.MAPS,
    Option(
        "format", MAP, "NAME", "Format of the file; default: told by its suffix.", parsing.words,
        fits=(*PREPARED, INFO), prepares=True,
    ),
    Option(
        "channel", MAP, "NAME|INDEX", "Height channel; default: the one the file proposes.",
        parsing.words, fits=(*PREPARED, INFO), prepares=True,
    ),
    Option(
        "unit", MAP, "UNIT",
        'Unit of the heights, if the file gives none, such as um; of a profile "mm, um", positions '
        "first.",
        parsing.words, fits=(*PREPARED, INFO), prepares=True,
    ),
    Option(
        "size", MAP, "LENGTHS",
        'Sides (y, x) of the map, if there is no file or it gives none: "0.1 mm x 0.2 mm".',
        parsing.words, fits=(*PREPARED, INFO), prepares=True,
    ),
    Option(
        "override-size", MAP, "",
        "Take --size though the file gives one, where that is wrong; the preparation records both.",
        fits=(*PREPARED, INFO), default=False, prepares=True,
    ),
    Option(
        "tip-radius", MAP, "LENGTH",
        'Radius of the tip of a scanning probe, such as "10 nm", to tell below which scale the map '
        "shows the tip.", LENGTH,
    ),
    Option(
        "points", MAP, "NUMBER|NYxNX", "Grid of a nominal --body without a FILE, such as 256.",
        parsing.points, prepares=True,
    ),
    Option(
        "points", MAP, "NUMBER", "Points per side; default: 1024.",
        parsing.counted(32, math.isqrt(limits.POINTS)), fits=(DEMO,), default=1024,
    ),
    Option(
        "crop", MAP, "ROWS,COLUMNS", "Part of the map to keep, such as 0:256,100:356.",
        parsing.window, fits=PREPARED, prepares=True,
    ),
    Option(
        "outliers", MAP, "NUMBER",
        "Treat points as missing that lie further from their surroundings than this many robust "
        "standard deviations, such as 6.", parsing.number, fits=PREPARED, prepares=True,
    ),
    Option(
        "level", MAP, "|".join(LEVELS),
        "What is fitted and subtracted; default: plane (by least squares).",
        parsing.choice(*LEVELS), default="plane", fits=PREPARED, prepares=True,
    ),
    Option(
        "form", MAP, "FORM",
        'Form to remove by least squares: sphere, cylinder or "polynomial 4".', parsing.form,
        fits=PREPARED, prepares=True,
    ),
    Option(
        "holes", MAP, "|".join(HOLES),
        "Missing points: error refuses them, fill interpolates smoothly up to 30 % of the points "
        "(fill-all any share), mask lets them never touch, crop keeps the largest rectangle "
        "without them; default: error.",
        parsing.choice(*HOLES), default="error", fits=PREPARED, prepares=True,
    ),
    Option(
        "s-filter", MAP, "LENGTH", 'Remove waves shorter than this (ISO 16610-61), such as '
        '"2.5 um".', LENGTH, arguments=("s",), fits=PREPARED, prepares=True,
    ),
    Option(
        "l-filter", MAP, "LENGTH", 'Remove waves longer than this, such as "80 um".', LENGTH,
        arguments=("l",), fits=PREPARED, prepares=True,
    ),
    Option(
        "pixel", MAP, "LENGTH", 'Resample (cubic splines) to about this pixel, such as "0.5 um".',
        LENGTH, fits=PREPARED, prepares=True,
    ),
    Option(
        "rotate", MAP, "DEGREES", "Turn the map counter-clockwise by a multiple of 90.",
        parsing.turns, default=0, fits=PREPARED, prepares=True,
    ),
    *comparison_options.LOADS,
    *joint_options.LOADS,
    *estimate_options.OPTIONS,
    Option(
        "load", BODIES, "LOAD",
        'Normal load, such as "1 N"; or as a nominal pressure on the area of the map, such as '
        '"20 MPa"; or per length of a profile or of a nominal cylinder, such as "600 N/mm"; this, '
        "--hertz or --approach.", parsing.load, fits=(SOLVE, STRESS),
    ),
    Option(
        "load", BODIES, "LOAD",
        'Normal load on the whole way, such as "1 N" or "20 MPa" or "600 N/mm", as for solve; this '
        "or --hertz.", parsing.load, fits=(ROLL,),
    ),
    Option(
        "hertz", BODIES, "PRESSURE",
        "Load under which the nominal bodies, smooth, have this peak pressure, such as "
        '"1.5 GPa".', parsing.peak, fits=(SOLVE, STRESS, ROLL),
    ),
    Option(
        "approach", BODIES, "LENGTH", 'Approach of the bodies from first touch, such as "1 um".',
        LENGTH, fits=(SOLVE, STRESS), model=CEILING,
    ),
    Option(
        "contact", BODIES, "SHARES",
        'Find the load at which this part of the map touches, such as "5 %", or several: '
        '"1 %, 5 %".', parsing.shares, fits=(FIND,),
    ),
    Option(
        "saturated", BODIES, "SHARES",
        'Find the load at which this part of the contact is at the ceiling, such as "1 %".',
        parsing.shares, fits=(FIND,),
    ),
    Option(
        "approach", BODIES, "LENGTHS",
        'Find the load of this approach from first touch, such as "1 um", or several.',
        parsing.lengths, fits=(FIND,),
    ),
    Option(
        "mean-gap", BODIES, "LENGTHS",
        'Find the load at which the mean gap is this, such as "0.5 um", or several.',
        parsing.lengths, fits=(FIND,),
    ),
    Option(
        "first-yield", BODIES, "",
        "Find the load at which the first point of either body yields, at the surface or below "
        "it; that contact is elastic.", fits=(FIND,), default=False,
    ),
    Option(
        "from", BODIES, "LOAD|APPROACH", 'First load, such as "10 mN", "1 MPa", "50 N/mm" (as for '
        '--load of solve) or "hertz 0.5 GPa" (as for --hertz), or approach, such as "0.1 um".',
        parsing.load_or_approach, fits=(SWEEP,),
    ),
    Option(
        "to", BODIES, "LOAD|APPROACH", "Last load or approach.", parsing.load_or_approach,
        fits=(SWEEP,),
    ),
    Option(
        "steps", BODIES, "NUMBER", "How many loads or approaches; default: 13.",
        parsing.counted(2, limits.STEPS), fits=(SWEEP,), default=13,
    ),
    Option(
        "spacing", BODIES, "log|linear", "log: equal ratios; linear: equal differences; default: "
        "log.", parsing.choice("log", "linear"), fits=(SWEEP,), default="log",
    ),
    Option(
        "path", BODIES, "LOADS", 'Loads or approaches in their order: "1 N, 0 N, 1 N"; or '
        '"20 MPa", "600 N/mm", "hertz 1.5 GPa", as for --load and --hertz of solve.',
        parsing.stages, fits=(HISTORY,),
    ),
    Option(
        "passes", BODIES, "NUMBER", "How often the path is followed, ended by a pass that indents "
        "nothing; default: 1.", parsing.counted(1, limits.STEPS), fits=(HISTORY,), default=1,
    ),
    Option(
        "shift", BODIES, "LENGTHS",
        'Shift (y, x) of the counter-body from pass to pass, such as "0 um, 5 um"; default: none.',
        parsing.offset, fits=(HISTORY,), default=(0.0, 0.0),
    ),
    *rolling_options.WAYS,
    Option(
        "load-point", BODIES, "LENGTHS",
        'Let the bodies tilt until the load acts at this offset (y, x) from the middle of the map, '
        'such as "0 um, 5 um"; default: they do not tilt.', parsing.offset, fits=(SOLVE, STRESS),
        model=CEILING,
    ),
    Option(
        "material", BODIES, "NAME",
        "Material of the catalogue, such as 100Cr6; see roughcontact materials. --young, --poisson "
        "and --yield-strength stand in for it or replace single values.", parsing.material,
        fits=PREPARED,
    ),
    Option(
        "young", BODIES, "PRESSURE", 'Young\'s modulus, such as "210 GPa".', PRESSURE,
        fits=PREPARED,
    ),
    Option(
        "poisson", BODIES, "NUMBER", "Poisson's ratio, such as 0.3.", parsing.number,
        fits=PREPARED,
    ),
    Option(
        "yield-strength", BODIES, "PRESSURE", 'Yield strength, such as "1 GPa".', PRESSURE,
        fits=PREPARED,
    ),
    Option(
        "counter-material", BODIES, "NAME", "Material of the counter-body; default: rigid.",
        parsing.material, fits=PREPARED,
    ),
    Option(
        "counter-young", BODIES, "PRESSURE", "Young's modulus of the counter-body.", PRESSURE,
        fits=PREPARED,
    ),
    Option(
        "counter-poisson", BODIES, "NUMBER", "Poisson's ratio of the counter-body.",
        parsing.number, fits=PREPARED,
    ),
    Option(
        "counter-yield-strength", BODIES, "PRESSURE", "Yield strength of the counter-body.",
        PRESSURE, fits=PREPARED,
    ),
    *joint_options.CONDUCTORS,
    *tasks.OPTIONS,
    Option(
        "body", BODIES, "FORM",
        'Nominal form under the roughness, or alone with --points and --size: "sphere 10 mm", '
        '"cylinder 5 mm 90 deg", "ellipsoid 10 mm 4 mm", "punch 20 um", "cone 0.01", "wedge 0.01". '
        "Angles run counter-clockwise.", parsing.body, prepares=True,
    ),
    Option(
        "counter-body", BODIES, "FORM", "Nominal form of the counter-body; default: flat.",
        parsing.body, fits=SINGLE, prepares=True,
    ),
    Option(
        "counter-surface", BODIES, "FILE",
        "Height map of the counter-body, laid on point by point; on another grid it needs --align.",
        parsing.path, fits=SINGLE, prepares=True,
    ),
    Option(
        "align", BODIES, "",
        "Bring both maps to one grid, centre on centre, and keep what both cover.", default=False,
        fits=SINGLE, prepares=True,
    ),
    Option(
        "offset", BODIES, "LENGTHS", 'Shift (y, x) of the aligned counter-map, such as "0 um, '
        '5 um".', parsing.offset, fits=SINGLE, prepares=True,
    ),
    Option(
        "angle", BODIES, "DEGREES", "Turn of the aligned counter-map, counter-clockwise.",
        parsing.number, fits=SINGLE, prepares=True,
    ),
    Option(
        "mirror", BODIES, "",
        "Mirror the aligned counter-map, as a map measured from its own front needs.",
        default=False, fits=SINGLE, prepares=True,
    ),
    Option(
        "ceiling", BODIES, "PRESSURE",
        'Largest pressure, such as "3 GPa", or a hardness, such as "62 HRC"; auto: 3 times the '
        "smaller yield strength, or else the hardness; recommended: that which gives the contact "
        "area of plasticity in the volume, found by solving again; none: purely elastic; default: "
        "auto.",
        parsing.ceiling, default="auto", fits=CAPPED, model=CEILING,
    ),
    Option(
        "uncalibrated", BODIES, "",
        "Do not solve again under the calibrated ceiling, whose numbers are a second column.",
        default=False, fits=(SOLVE,), model=CEILING,
    ),
    Option(
        "model", BODIES, f"{CEILING}|{VOLUME}",
        "ceiling: pressures up to the ceiling; volume: plastic strain in the volume, which takes "
        "seconds to minutes; default: ceiling.", parsing.choice(CEILING, VOLUME), fits=(SOLVE,),
        default=CEILING,
    ),
    Option(
        "increments", BODIES, "NUMBER|auto",
        "Equal steps to the load of the volume model; auto: as many as keep the error by the steps "
        "below 1 %; default: auto.",
        parsing.counted_or_auto(1, limits.STEPS), fits=(SOLVE,), default="auto", model=VOLUME,
    ),
    Option(
        "unload", BODIES, "",
        "Take the bodies of the volume model apart at the end, to see what stays.", fits=(SOLVE,),
        default=False, model=VOLUME,
    ),
    Option(
        "hardening", BODIES, "LAW",
        'Hardening of the rough body: "linear 2 GPa" (modulus) or "swift 945 MPa 20 0.121" (B, C, '
        'n of B (C + 1e6 e)^n); "kinematic 10 GPa", alone or after one of these and a comma, for '
        "metal that yields earlier on its way back; for the volume model, and for the ceiling "
        "that is recommended.",
        parsing.hardening, fits=(SOLVE, ROLL, ESTIMATE),
    ),
    Option(
        "boundary", BODIES, "KIND",
        "What lies beyond the edges of the map. "
        f"{'; '.join(f'{kind}: {kind.meaning}' for kind in Boundary)}; default: free.",
        parsing.choice(*Boundary), default=Boundary.FREE,
    ),
    Option(
        "which", BODIES, "body|counter-body", "Body to look into; default: body.",
        parsing.choice("body", "counter-body"), fits=(STRESS,), default="body",
    ),
    Option(
        "friction", BODIES, "NUMBER", "Coefficient of friction; default: 0.", parsing.number,
        fits=(STRESS,), default=0.0,
    ),
    Option(
        "direction", BODIES, "DEGREES",
        "Direction of the traction on the body, counter-clockwise from x; default: 0.",
        parsing.number, fits=(STRESS,), default=0.0,
    ),
    Option(
        "depths", SOLVER, "LENGTHS", 'Depths, such as "1 um, 2 um"; default: the contact '
        "chooses.", parsing.lengths, fits=(STRESS,),
    ),
    Option(
        "onset", SOLVER, "", "Find the load at which the first point yields.", fits=(STRESS,),
        default=False,
    ),
    Option(
        "tolerance", SOLVER, "NUMBER",
        "Certificate to reach; default: 1e-6, in single precision 1e-4. In the volume model, "
        "residual of the plastic strain to reach; default: 1e-4.", parsing.number, fits=(SOLVE,),
    ),
    Option(
        "tolerance", SOLVER, "NUMBER",
        "Certificate to reach; default: 1e-6, in single precision 1e-4.", parsing.number,
        fits=(SWEEP, STRESS, *JOINTS),
    ),
    Option(
        "tolerance", SOLVER, "NUMBER", "Certificate to reach; default: 1e-6.", parsing.number,
        fits=(HISTORY, FIND, COMPARE),
    ),
    Option(
        "max-iterations", SOLVER, "NUMBER",
        "Most convolutions on any one grid; default: 2000. In the volume model, most iterations at "
        "one load; default: 150.", parsing.counted(1, limits.ITERATIONS), fits=(SOLVE,),
    ),
    Option(
        "max-iterations", SOLVER, "NUMBER", "Most convolutions on any one grid; default: 2000.",
        parsing.counted(1, limits.ITERATIONS),
        fits=(SWEEP, STRESS, HISTORY, FIND, *JOINTS, COMPARE),
    ),
    Option(
        "precision", SOLVER, "double|single",
        "single needs two thirds of the memory; default: double, in the volume model single.",
        parsing.choice("double", "single"), fits=(SOLVE,),
    ),
    Option(
        "precision", SOLVER, "double|single",
        "single needs two thirds of the memory; default: double.",
        parsing.choice("double", "single"), fits=(SWEEP, STRESS, *JOINTS),
    ),
    Option(
        "study", SOLVER, "",
        "Solve again on coarser and finer grids, with filters and other ceilings, and tell what "
        "depends on them.", fits=(SOLVE,), default=False, model=CEILING,
    ),
    *rolling_options.SOLVERS,
    *comparison_options.FILES,
    *joint_options.FILES,
    *estimate_options.FILES,
    *rolling_options.FILES,
    Option(
        "output", OUTPUT, "FILE",
        f"Write the result: {export.told(Kind.CONTACT, Kind.VOLUME)}; may be repeated.",
        parsing.path,
        fits=(SOLVE,), default=(), many=True, suffixes=ALL_RESULTS,
    ),
    Option(
        "output", OUTPUT, "FILE.csv|json", "Write the table of loads.", parsing.path,
        fits=(SWEEP,), suffixes=TABLES,
    ),
    Option(
        "output", OUTPUT, "FILE.csv|json", "Write the table of steps.", parsing.path,
        fits=(HISTORY,), suffixes=TABLES,
    ),
    Option(
        "output", OUTPUT, "FILE.csv|json", "Write the table of answers.", parsing.path,
        fits=(FIND,), suffixes=TABLES,
    ),
    Option(
        "output", OUTPUT, "FILE.nc", "Write contact and stress as NetCDF.", parsing.path,
        fits=(STRESS,), suffixes=(".nc",),
    ),
    Option(
        "residual", OUTPUT, "FILE",
        f"Write the indented surface: {', '.join(SURFACES)}.", parsing.path,
        fits=(HISTORY,), suffixes=SURFACES,
    ),
    Option(
        "folder", OUTPUT, "FOLDER",
        "Where the volume model keeps every load it reaches, to go on later.", parsing.path,
        fits=(SOLVE,), model=VOLUME,
    ),
    Option(
        "folder", OUTPUT, "FOLDER", "Where finished steps are kept, to go on later.", parsing.path,
        fits=(SWEEP, HISTORY),
    ),
    Option(
        "folder", OUTPUT, "FOLDER", "Where the files go; default: roughcontact-demo.",
        parsing.path, fits=(DEMO,), default=parsing.path("roughcontact-demo", "folder"),
    ),
    Option(
        "report", OUTPUT, "FILE.html", "Write a report with figures into one HTML file.",
        parsing.path, suffixes=(".html",),
    ),
    Option(
        "figures", OUTPUT, "FOLDER|PREFIX",
        "Draw figures, such as surface, pressure and gap (of the volume model sections and "
        "profiles, too), as PNG into an existing folder, or with this start of their names; ending "
        "in .svg or .pdf, in that format.", parsing.words, fits=(SOLVE,),
        suffixes=PICTURES,
    ),
    Option(
        "figures", OUTPUT, "FOLDER|PREFIX",
        "Draw figures, such as the section of the stress, as PNG into an existing folder, or with "
        "this start of their names; ending in .svg or .pdf, in that format.", parsing.words,
        fits=(STRESS,), suffixes=PICTURES,
    ),
    Option(
        "figure", OUTPUT, "FILE", "Draw the curve as PNG, SVG or PDF.", parsing.path,
        fits=(SWEEP,), suffixes=PICTURES,
    ),
    Option(
        "figure", OUTPUT, "FILE", "Draw the loop as PNG, SVG or PDF.", parsing.path,
        fits=(HISTORY,), suffixes=PICTURES,
    ),
    Option(
        "json", OUTPUT, "", "Print JSON in SI units, and nothing else.",
        fits=(*PREPARED, GENERATE, RUN, VERIFY, INFO, MATERIALS), default=False,
    ),
    Option(
        "quiet", OUTPUT, "", "Print nothing but errors, and JSON if wanted.",
        fits=(*PREPARED, GENERATE, RUN, VERIFY), default=False,
    ),
)  # fmt: skip
"""Every option of every command, in the order of the help."""

SHOWN = ("json", "quiet")
"""Options about what the terminal shows, which do not describe a run."""


@lru_cache
def offered(command: str) -> Mapping[str, Option]:
    """Return the options that fit a command, by name, in the order of its help."""
    return {option.name: option for option in OPTIONS if command in option.fits}


@lru_cache
def all_names() -> frozenset[str]:
    """Return the names of the options of all commands."""
    return frozenset(option.name for option in OPTIONS)


@lru_cache
def preparing() -> tuple[str, ...]:
    """Return the names of the options that the prepared maps depend on."""
    return tuple(dict.fromkeys(option.name for option in OPTIONS if option.prepares))


def named(argument: str, command: str) -> str | None:
    """Return the name of the option that an argument stands for, None if the command has none."""
    for name, option in offered(command).items():
        if argument == option.argument or argument in option.arguments:
            return name
    return None


def parsed(given: Given, command: str) -> dict[str, Any]:
    """Return the values of options that were given as text.

    Parameters
    ----------
    given : Mapping
        Text by the names of options that the command has; a bool for a flag, a list for what may
        be repeated.
    command : str
        The command.

    Raises
    ------
    InputError
        If a value cannot be used; it carries the argument.
    """
    values: dict[str, Any] = {}
    for name, value in given.items():
        option = offered(command)[name]
        if isinstance(value, bool):
            values[name] = value
        elif option.many:
            listed = [value] if isinstance(value, str) else value
            values[name] = tuple(option.parse(text, option.argument) for text in listed)
        else:
            values[name] = option.parse(str(value), option.argument)
    return values


def text_of(value: object, option: Option) -> str:
    """Return a value as it would be given for an option."""
    if isinstance(value, float):
        unit = _UNITS.get(option.parse)
        return f"{value:g}" if unit is None else units.engineering(value, unit)
    return str(value)


def spell_option(mention: Mention, command: str) -> str:
    """Return an argument in the words of the command line.

    Parameters
    ----------
    mention : Mention
        What a message speaks of.
    command : str
        The command that was given; an argument that it has no option for keeps its name.

    Returns
    -------
    str
        ``--name``, or ``--name value`` quoted for a shell.

    Examples
    --------
    >>> spell_option(Mention("max_iterations"), "solve")
    '--max-iterations'
    >>> spell_option(Mention("size", "0.1 mm x 0.2 mm"), "solve")
    "--size '0.1 mm x 0.2 mm'"
    """
    if mention.name == "file" and command in (*PREPARED, INFO):
        return "FILE"
    name = named(mention.name, command)
    if name is None:
        return str(mention)
    if mention.value is None or mention.value is True:
        return f"--{name}"
    return f"--{name} {shlex.quote(text_of(mention.value, offered(command)[name]))}"
