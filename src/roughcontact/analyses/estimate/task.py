"""The task ``estimate``: contact area, gap and plastic depth by formulas."""

from __future__ import annotations

from typing import Any

from roughcontact.errors import InputError
from roughcontact.request import options, parsing
from roughcontact.request.options import LENGTH, PRESSURE, Option, symbol_option
from roughcontact.request.outcome import Outcome, TaskContext
from roughcontact.request.request import Request
from roughcontact.request.task import Task

SQ = symbol_option(
    "Sq",
    "LENGTH",
    'Root-mean-square height Sq: "0.4 um". Given parameters replace those of FILE.',
    LENGTH,
    None,
)
SDQ = symbol_option("Sdq", "NUMBER", "Root-mean-square slope Sdq.", parsing.number, None)
SAL = symbol_option(
    "Sal", "LENGTH", 'Autocorrelation length Sal: "12 um"; narrows the gap interval.', LENGTH, None
)
STR = symbol_option("Str", "NUMBER", "Texture aspect ratio Str; default: 1.", parsing.number, None)
SSK = symbol_option("Ssk", "NUMBER", "Skewness Ssk; default: 0.", parsing.number, None)
SKU = symbol_option(
    "Sku", "NUMBER", "Kurtosis Sku; default: 3 + 1.5 Ssk² (Gaussian: 3).", parsing.number, None
)
RA = symbol_option(
    "Ra",
    "LENGTH",
    'Roughness Ra of a drawing instead of Sq and Sdq: "0.8 um"; needs --finish.',
    LENGTH,
    None,
)
FINISH = Option(
    "finish",
    "NAME",
    "Finish: ground, milled, turned, honed, planed, lapped, polished, blasted, eroded, as-cast.",
    parsing.as_text,
    None,
)
COUNTER_RA = Option(
    "counter-ra",
    "LENGTH",
    "Ra of the other face; default: smooth.",
    LENGTH,
    None,
    arguments=("counter_Ra",),
)
COUNTER_FINISH = Option(
    "counter-finish", "NAME", "Finish of the other face; default: the same.", parsing.as_text, None
)
NOMINAL_PRESSURE = Option(
    "pressure", "PRESSURE", 'Nominal pressure (load over nominal area): "20 MPa".', PRESSURE, None
)
CEILING: Option[str | float | None] = Option(
    "ceiling",
    "PRESSURE",
    'Pressure ceiling: "3 GPa", "62 HRC", auto (3σ_Y) or none (elastic); default: auto.',
    parsing.ceiling,
    "auto",
    label="Pressure ceiling",
)
OUTPUT = options.file_option("output", "FILE.json", "Estimate as JSON.", (".json",))
_PARAMETERS: tuple[Option[Any], ...] = (SQ, SDQ, SAL, STR, SSK, SKU)
_DRAWING: tuple[Option[Any], ...] = (RA, FINISH, COUNTER_RA, COUNTER_FINISH)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.estimate.model import estimate

    material, counter_material = request.bodies()
    specified = {
        (*option.arguments, option.argument)[0]: request[option]
        for option in (*_PARAMETERS, *_DRAWING)
    }
    try:
        result = estimate(
            None if request.file is None else work.maps[0],
            pressure=request.needed(NOMINAL_PRESSURE),
            material=material,
            counter_material=counter_material,
            ceiling=request[CEILING],
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
        CEILING,
        *options.MATERIALS,
        options.HARDENING,
        OUTPUT,
        *options.SHOWN,
    ),
    (
        SQ,
        SDQ,
        SAL,
        SSK,
        RA,
        FINISH,
        NOMINAL_PRESSURE,
        options.MATERIAL,
        options.MISSING,
        options.JSON,
    ),
    run=_run,
    rules=(
        options.Rule(
            options.NEEDED, NOMINAL_PRESSURE, text="load over nominal area, such as '20 MPa'"
        ),
        options.Rule(options.NEEDS, RA, FINISH),
        options.Rule(options.NEEDS, FINISH, RA),
        options.Rule(options.NEEDS, COUNTER_RA, RA),
        options.Rule(options.NEEDS, COUNTER_FINISH, COUNTER_RA),
    ),
    memory=_memory,
    needs_map=False,
    in_projects=False,
    presentations={"Estimate": "analyses.estimate.report:EstimatePresentation"},
)
