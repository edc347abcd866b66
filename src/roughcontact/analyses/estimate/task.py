"""The task ``estimate``: contact area, gap and plastic depth by formulas."""

from __future__ import annotations

from typing import Any

from roughcontact.errors import InputError
from roughcontact.request import options, parsing
from roughcontact.request.options import LENGTH, PRESSURE, Option
from roughcontact.request.outcome import Outcome, TaskContext
from roughcontact.request.request import Request
from roughcontact.request.task import Task

SQ = Option.symbol(
    "Sq", LENGTH, 'Root-mean-square height Sq: "0.4 um". Given parameters replace those of FILE.'
)
SDQ = Option.symbol("Sdq", parsing.number, "Root-mean-square slope Sdq.")
SAL = Option.symbol("Sal", LENGTH, 'Autocorrelation length Sal: "12 um"; narrows the gap interval.')
STR = Option.symbol("Str", parsing.number, "Texture aspect ratio Str; default: 1.")
SSK = Option.symbol("Ssk", parsing.number, "Skewness Ssk; default: 0.")
SKU = Option.symbol("Sku", parsing.number, "Kurtosis Sku; default: 3 + 1.5 Ssk² (Gaussian: 3).")
RA = Option.symbol(
    "Ra", LENGTH, 'Roughness Ra of a drawing instead of Sq and Sdq: "0.8 um"; needs --finish.'
)
FINISH = Option.value(
    "finish",
    parsing.as_text,
    "Finish: ground, milled, turned, honed, planed, lapped, polished, blasted, eroded, as-cast.",
)
COUNTER_RA = Option.value(
    "counter-ra", LENGTH, "Ra of the other face; default: smooth.", arguments=("counter_Ra",)
)
COUNTER_FINISH = Option.value(
    "counter-finish", parsing.as_text, "Finish of the other face; default: the same."
)
NOMINAL_PRESSURE = Option.value(
    "pressure", PRESSURE, 'Nominal pressure (load over nominal area): "20 MPa".'
)
OUTPUT = Option.output("Estimate as JSON", (".json",))
_PARAMETERS: tuple[Option[Any], ...] = (SQ, SDQ, SAL, STR, SSK, SKU)
_DRAWING: tuple[Option[Any], ...] = (RA, FINISH, COUNTER_RA, COUNTER_FINISH)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.estimate.model import estimate

    material, counter_material = request.bodies
    specified = {
        (*option.arguments, option.argument)[0]: request[option]
        for option in (*_PARAMETERS, *_DRAWING)
    }
    try:
        result = estimate(
            None if request.file is None else work.maps[0],
            pressure=request.require(NOMINAL_PRESSURE),
            material=material,
            counter_material=counter_material,
            ceiling=request[options.CEILING],
            **specified,
        )
    except InputError as error:
        if request.file is not None and specified.get(error.argument or "", 0) is None:
            # The option was not given: the value is from the map.
            raise InputError(f"{request.file} ", *error.parts) from None
        raise
    return Outcome(request, result)


def _memory(_: Request, shape: tuple[int, int]) -> None:
    """Do nothing: the functions that read the map check its memory."""


TASK = Task(
    "estimate",
    """Estimate contact area, gap, stiffness and conductance from roughness parameters.

Each interval holds 90 of 100 nominally flat surfaces. Input outside the fitted range is rejected.

\b
Example:
roughcontact estimate --sq "0.5 um" --sdq 0.1 --sal "12 um" \\
    --pressure "100 MPa" --material 42CrMo4
""",
    (
        *options.READING,
        *options.PREPARATION,
        *_PARAMETERS,
        *_DRAWING,
        NOMINAL_PRESSURE,
        options.CEILING,
        *options.MATERIALS,
        options.HARDENING,
        OUTPUT,
        *options.OUTPUT,
    ),
    short_help="sq sdq sal ssk ra finish pressure material missing json",
    run=_run,
    rules=(
        options.Rule(
            options.NEEDED, NOMINAL_PRESSURE, text="load over nominal area, such as '20 MPa'"
        ),
        options.Rule(options.NEEDS, RA, FINISH),
        options.Rule(options.EXCLUDES, RA, SQ),
        options.Rule(options.NEEDS, FINISH, RA),
        options.Rule(options.NEEDS, COUNTER_RA, RA),
        options.Rule(options.NEEDS, COUNTER_FINISH, COUNTER_RA),
    ),
    memory=_memory,
    needs_map=False,
    in_projects=False,
    presentations={"Estimate": "analyses.estimate.report:EstimatePresentation"},
)
