"""The options of repeated passes: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from roughcontact import limits
from roughcontact.formats import export
from roughcontact.formats.export import Kind
from roughcontact.request import parsing
from roughcontact.request.option import (
    BODIES,
    LENGTH,
    OUTPUT,
    PICTURES,
    ROLL,
    SOLVER,
    TABLES,
    Option,
)

_ONLY = (ROLL,)

WAYS = (
    Option(
        "passes", BODIES, "NUMBER",
        "How often the counter-body passes, ended by a pass that adds no plastic strain; there and "
        "back are two; default: 5.", parsing.counted(1, limits.STEPS), fits=_ONLY, default=5,
    ),
    Option(
        "steps", BODIES, "NUMBER", "Places at which the contact of a pass is solved; default: 32.",
        parsing.counted(1, limits.STEPS), fits=_ONLY, default=32,
    ),
    Option(
        "way", BODIES, "LENGTH",
        'Length of a pass, such as "80 um", half of it to each side of the place of the '
        "counter-body; default: once round a map that is periodic along --direction.", LENGTH,
        fits=_ONLY,
    ),
    Option(
        "direction", BODIES, "DEGREES",
        "Where the counter-body moves, counter-clockwise from x; default: 0.", parsing.number,
        fits=_ONLY, default=0.0,
    ),
    Option(
        "to-and-fro", BODIES, "", "Let every other pass go back, instead of each beginning anew.",
        fits=_ONLY, default=False,
    ),
    Option(
        "friction", BODIES, "NUMBER",
        "Coefficient of friction at full sliding, which pulls the body to where the counter-body "
        "moves; default: 0.", parsing.number, fits=_ONLY, default=0.0,
    ),
)  # fmt: skip
"""How the counter-body moves."""

SOLVERS = (
    Option(
        "tolerance", SOLVER, "NUMBER",
        "Residual of the plastic strain to reach; default: 1e-4.", parsing.number, fits=_ONLY,
    ),
    Option(
        "max-iterations", SOLVER, "NUMBER", "Most iterations at one step; default: 150.",
        parsing.counted(1, limits.ITERATIONS), fits=_ONLY,
    ),
    Option(
        "precision", SOLVER, "double|single", "Arithmetic of the volume; default: single.",
        parsing.choice("double", "single"), fits=_ONLY,
    ),
)  # fmt: skip
"""How exactly it is solved."""

FILES = (
    Option(
        "output", OUTPUT, "FILE",
        f"Write the passes: {export.told(Kind.ROLLING)}, .csv a row a pass, .json numbers; may be "
        "repeated.", parsing.path, fits=_ONLY, default=(), many=True,
        suffixes=(*export.suffixes(Kind.ROLLING), *TABLES),
    ),
    Option(
        "folder", OUTPUT, "FOLDER", "Where every step is kept, to go on later.",
        parsing.path, fits=_ONLY,
    ),
    Option(
        "movie", OUTPUT, "FILE.gif",
        "Film pressure and plastic strain, step by step, as an animated GIF.", parsing.path,
        fits=_ONLY, suffixes=(".gif",),
    ),
    Option(
        "figures", OUTPUT, "FOLDER|PREFIX",
        "Draw figures, such as passes, heights and depths, as PNG into an existing folder, or with "
        "this start of their names; ending in .svg or .pdf, in that format.", parsing.words,
        fits=_ONLY, suffixes=PICTURES,
    ),
)  # fmt: skip
"""What is written."""
