"""The task ``solve``: one contact, with a ceiling or with plastic strain in the volume."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from roughcontact._tools.memory import STEPS
from roughcontact.errors import ArgumentRef, CapacityError
from roughcontact.formats import export
from roughcontact.request import measurement, options, outputs, parsing
from roughcontact.request.options import Option
from roughcontact.request.outcome import Outcome, TaskContext
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.uncertainty.resolution import ResolutionStudy


SURFACE_MODEL, VOLUME_MODEL = "ceiling", "elastoplastic"
RESULTS = {SURFACE_MODEL: export.CONTACT.suffixes, VOLUME_MODEL: export.VOLUME.suffixes}
"""File suffixes of results, by model."""

UNCALIBRATED = Option.flag("uncalibrated", "Omit the second column (calibrated ceiling).")
MODEL = Option(
    "model",
    parsing.choice(SURFACE_MODEL, VOLUME_MODEL),
    "ceiling (fast) or elastoplastic (minutes); default: ceiling.",
    SURFACE_MODEL,
)
INCREMENTS: Option[int | str] = Option(
    "increments",
    parsing.count_or_auto(1, STEPS),
    "Load steps of the elastoplastic model, e.g. 8; default: auto (error below 1 %).",
    "auto",
)
UNLOAD = Option.flag("unload", "Unload at the end; report residual shape and stress.")
OUTPUT = Option.output(
    f"Result: {export.list_formats(export.VOLUME, export.CONTACT)}", export.VOLUME.suffixes
)
FOLDER = Option.file("folder", "Folder for finished elastoplastic steps; the same command resumes.")
STUDY = Option.flag("study", "Check dependence on grid, filter and ceiling.", options.Panel.SOLVER)


def contact(
    request: Request,
    work: TaskContext,
    *,
    calibrated: bool,
    load: tuple[Any, str] | None = None,
    ceiling: Any = None,
) -> ContactResult:
    """Solve the contact of a request; return the best iterate if it does not converge.

    Another ``load`` than that of the request is given with the name of its argument.
    """
    from roughcontact.contact.load_case import LoadCase
    from roughcontact.contact.solve import solve_case

    pair = request.pair(work.maps)
    force, specified = request.force(pair, *(load or (request[options.LOAD],)))
    point = request[options.LOAD_POINT]
    terms = LoadCase(
        force,
        request[options.APPROACH],
        None if point is None else (force * point[0], force * point[1]),
        request[options.CEILING] if ceiling is None else ceiling,
        specified=specified,
        **request.solver(),
    )
    result = solve_case(pair, terms, on_failure="return", progress=work.look)
    if not calibrated or result.ceiling is None:
        return result
    work.show(result)
    return work.add_calibrated(result)


def under_other_ceiling(
    request: Request, work: TaskContext, first: ContactResult, **more: Any
) -> ContactResult | None:
    """Return the same contact under its second ceiling; None if there is none."""
    from roughcontact.contact.ceiling import is_bracket
    from roughcontact.contact.plausibility import other_ceiling
    from roughcontact.contact.result import BASE

    ceiling = BASE if is_bracket(first.pair, request[options.CEILING]) else other_ceiling(first)
    if ceiling is None:
        return None
    with suppress(CapacityError):
        result = contact(request, work, calibrated=False, ceiling=ceiling, **more)
        return result if result.converged else None
    return None


def _run(request: Request, work: TaskContext) -> Outcome:
    if request[MODEL] == VOLUME_MODEL:
        return _volume(request, work)
    result = contact(request, work, calibrated=not request[UNCALIBRATED])
    extra_cautions, extras = work.extra_cautions, {}
    if request[STUDY] and result.converged:
        study = resolution_study_of(request, work, result.load)
        extra_cautions, extras = ((*extra_cautions, *study.cautions), {STUDY.name: study})
    if request[measurement.UNCERTAINTY] and result.converged:
        result = measurement.add_intervals(request, result, work.look)
    result = replace(result, extra_cautions=extra_cautions)
    return Outcome(request, result, result, extras)


def _volume(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.elastoplastic.increments import AUTO, points_between
    from roughcontact.elastoplastic.solve import solve_elastoplastic
    from roughcontact.elastoplastic.volume_result import PathPoint

    load, specified = request.force(request.pair(work.maps), request[options.LOAD])
    steps = request[INCREMENTS]
    way = points_between(PathPoint(0.0), PathPoint(load), 1 if steps == AUTO else int(steps))
    loads = [point.load for point in way]
    loads += [0.0] * request[UNLOAD]
    arguments = request.arguments(work.maps)
    del arguments["ceiling"]
    with work.report_saved_steps_on_interrupt("step-*.nc", "load") as (watch, reused):
        result = solve_elastoplastic(
            work.maps[0],
            **arguments,
            loads=loads,
            increments=steps,
            on_failure="return",
            folder=request[FOLDER],
            progress=watch,
        )
    solution = replace(
        result.solution, specified_load=specified, extra_cautions=work.extra_cautions
    )
    # Number of the last reused step.
    extras = {"reused": max(reused, default=0)}
    return Outcome(request, replace(result, solution=solution), solution, extras)


def _check(request: Request) -> None:
    model = request[MODEL]
    if model == VOLUME_MODEL:
        request.require_yield(ArgumentRef("model", VOLUME_MODEL))
    other = next(name for name in RESULTS if name != model)
    for path in request[OUTPUT]:
        suffix = path.suffix.lower()
        fits_other = ("; ", suffix, " needs ", ArgumentRef("model", other))
        outputs.check_suffix(
            path, OUTPUT, RESULTS[model], fits_other if suffix in RESULTS[other] else ()
        )


def record(outcome: Outcome) -> dict[str, Any]:
    """Return all quantities of a contact by name, in SI units."""
    from roughcontact.formats import tables
    from roughcontact.uncertainty import intervals

    record = tables.result_record(outcome.result)
    study = outcome.extras.get(STUDY.name)
    if study is not None:
        record["study"] = study.summary()
    if outcome.contact is not None and outcome.result is outcome.contact:
        result = intervals.uncertainty_intervals(outcome.contact, study)
        record["intervals"] = {interval.name: interval.summary() for interval in result}
    return record


def _figures(request: Request) -> str:
    is_volume = request[MODEL] == VOLUME_MODEL
    return "report.figures:VOLUME" if is_volume else "report.figures:CONTACT"


def _memory(request: Request, shape: tuple[int, int]) -> None:
    if request[MODEL] == VOLUME_MODEL:
        request.require_volume(shape)
    else:
        request.require_contact(shape)


def resolution_study_of(request: Request, work: TaskContext, load: float) -> ResolutionStudy:
    """Return the study of a contact under a load [N]."""
    from roughcontact.uncertainty.resolution import resolution_study

    arguments = request.arguments(work.maps)
    arguments.pop(options.MAX_ITERATIONS.argument, None)
    return resolution_study(
        work.maps[0],
        **arguments,
        load=load,
        progress=lambda state: work.look(replace(state, label=f"study: {state.label}")),
    )


# Options that the elastoplastic model does not have.
_OF_SURFACE = (options.APPROACH, options.LOAD_POINT, options.CEILING, options.DEVICE)

TASK = Task(
    "solve",
    """Compute pressure, real contact area and gap under one load.

\b
Example:
roughcontact solve ground.x3p --load "100 MPa" --boundary periodic \\
    --material 42CrMo4 --report ground.html
""",
    (
        *options.MAP,
        *options.LOADS,
        *options.MATERIALS,
        *options.COATINGS,
        *options.SHAPES,
        options.CEILING,
        UNCALIBRATED,
        MODEL,
        INCREMENTS,
        UNLOAD,
        options.HARDENING,
        options.BOUNDARY,
        *options.SOLVER,
        STUDY,
        *measurement.OPTIONS,
        OUTPUT,
        FOLDER,
        options.FIGURES,
        *options.OUTPUT,
    ),
    short_help="load boundary material young poisson yield-strength ceiling missing output report",
    run=_run,
    rules=(
        *options.LOAD_RULES,
        *measurement.RULES,
        options.Rule(options.EXCLUDES, options.LOAD_POINT, measurement.UNCERTAINTY),
        options.Rule(options.EXCLUDES, options.LOAD_POINT, STUDY),
        *(
            options.Rule(options.NEEDS, option, MODEL, value=SURFACE_MODEL)
            for option in (*_OF_SURFACE, UNCALIBRATED, STUDY, measurement.UNCERTAINTY)
        ),
        *(
            options.Rule(options.NEEDS, option, MODEL, value=VOLUME_MODEL)
            for option in (INCREMENTS, UNLOAD, FOLDER)
        ),
    ),
    check=_check,
    record=record,
    memory=_memory,
    figures=_figures,
    questions=(
        Analysis(
            "Resolution study",
            "The same contact on coarser and finer grids, with filters and other ceilings.",
            fixed=((STUDY, True),),
        ),
        Analysis(
            "Elastoplastic model",
            "Plastic strain below the surface instead of a ceiling; takes seconds to minutes.",
            fixed=((MODEL, VOLUME_MODEL),),
            is_command=True,
        ),
    ),
    presentations={
        "Surface": "analyses.solve.report:SurfacePresentation",
        "ContactResult": "analyses.solve.report:ContactPresentation",
        "ElastoplasticResult": "analyses.solve.volume_report:VolumePresentation",
        "ResolutionStudy": "analyses.solve.uncertainty_report:StudyPresentation",
        "Uncertainty": "analyses.solve.uncertainty_report:UncertaintyPresentation",
    },
)
