"""The task ``compare``: read, prepare and compare maps, or the quarters of each map."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.formats import export
from roughcontact.request import options, parsing
from roughcontact.request.options import Option
from roughcontact.request.outcome import OnProgress, Outcome, TaskContext
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.request.task import Subtasks, Task
from roughcontact.solvers.progress import one_of_several

if TYPE_CHECKING:
    from roughcontact.analyses.compare.model import Comparison, MapLoadCase, Pressed
    from roughcontact.analyses.compare.sampling import Sample, SamplingStudy
    from roughcontact.cautions import Caution
    from roughcontact.surface.surface import Surface

QUARTERS = Option.flag(
    "quarters", "Split each map into four quarters, one group per map.", options.Panel.MAP
)
SAMPLING = Option.flag(
    "sampling", "Estimate the sampling error and the area needed for 5 %.", options.Panel.MAP
)
PAIRED = Option.flag(
    "paired", "Pair the maps of two groups (same places, before and after).", options.Panel.MAP
)
LOAD = Option.value(
    "load",
    parsing.nominal,
    'Nominal pressure, the same for all maps: "20 MPa".',
    arguments=("pressure",),
)
PRELOAD = Option.value(
    "preload",
    parsing.nominal,
    'Preload; compare each map before and after: "200 MPa".',
    arguments=("preload_pressure",),
)
STEPS = Option(
    "steps",
    parsing.int_parser(1, memory.STEPS),
    "Points of the load curve; 1 for none; default: 7.",
    7,
)
OUTPUT = Option.output("Table of means and differences", export.TABLES)
FIGURE = Option.figure("load curves and numbers")

_QUARTERS = 4


@dataclass(frozen=True, eq=False)
class MapFindings:
    """Results of one map of a comparison."""

    pressed: tuple[Pressed, ...]
    study: SamplingStudy | None = None  # The sampling error, if requested


def _run(request: Request, work: TaskContext) -> Outcome:
    if work.known:
        return Outcome(
            request, _compare_all(request, [work.known[word] for word in part_names(request)])
        )
    # Read all maps first: an unreadable file is reported before the first solve.
    maps = [_read_map(request, path, work.say) for _, path in _list_maps(request)]
    result = [
        _compress_map(request, surface, one_of_several(work.look, number, len(maps)))
        for number, surface in enumerate(maps, start=1)
    ]
    return Outcome(request, _compare_all(request, result))


def part_names(request: Request) -> tuple[str, ...]:
    """Return the subtask names of a comparison, one per map."""
    return tuple(str(number) for number, _ in enumerate(_list_maps(request)))


def file_of(request: Request, word: str) -> Path | None:
    """Return the file of the map of a subtask; None for a nominal body."""
    return _list_maps(request)[int(word)][1]


def find_one_map(request: Request, word: str, say: Say, look: OnProgress) -> MapFindings:
    """Read and solve one map; the results are the same as in the whole comparison."""
    return _compress_map(request, _read_map(request, file_of(request, word), say), look)


def groups(request: Request) -> dict[str, list[Path]]:
    """Return the files to compare by group name."""
    if not request.get(QUARTERS) or request.task is not TASK:
        return request.groups
    paths = [path for listed in request.groups.values() for path in listed]
    return {request.names.get(str(path), str(path)): [path] for path in paths}


def _list_maps(request: Request) -> list[tuple[str, Path | None]]:
    """Return group name and file of all maps, in order."""
    named = groups(request).items()
    return [(name, path) for name, paths in named for path in paths] or [("", None)]


def _read_map(request: Request, path: Path | None, say: Say) -> Surface:
    from roughcontact.request.preparation import surfaces

    values = {name: value for name, value in request.values.items() if name != options.GROUP.name}
    (surface,) = surfaces(replace(request, file=path, files=(), values=values), say)
    return surface


def _compress_map(request: Request, surface: Surface, look: OnProgress) -> MapFindings:
    from roughcontact.request.preparation import resolution_cautions

    extra_cautions = resolution_cautions(request, [surface])
    alone = _is_study_alone(request)
    # Check the request first: an error is raised before the first solve.
    requested = None if alone else _load_case(request)
    study = _study_sampling(request, surface, look) if request[SAMPLING] else None
    if study is not None:
        study = replace(study, whole=_with_remarks(study.whole, extra_cautions))
    if requested is None:
        return MapFindings((), study)
    parts = _quarters(request, surface) if request[QUARTERS] else (surface,)
    pressed = []
    for number, part in enumerate(parts, start=1):
        # Unique names are set later, once all maps of a group are known.
        name = surface.provenance.source or "map"
        name += f", part {number} of {len(parts)}" if request[QUARTERS] else ""
        pressed.append(
            tuple(
                _with_remarks(item, extra_cautions)
                for item in requested.solve_map(part, name, look)
            )
        )
    return MapFindings(tuple(pressed), study)


def _is_study_alone(request: Request) -> bool:
    """Return whether the request is only the sampling error of a single map."""
    more = request[QUARTERS] or request[PRELOAD]
    return bool(request[SAMPLING] and not more and len(_list_maps(request)) == 1)


def _load_case(request: Request) -> MapLoadCase:
    from roughcontact.analyses.compare.model import build_load_case

    result = build_load_case(
        request.require(LOAD), request[STEPS], request[PRELOAD], _problem(request)
    )
    counts = Counter(name for name, _ in _list_maps(request))
    each = _QUARTERS if request[QUARTERS] else 1
    result.check({name: each * count for name, count in counts.items()}, request[PAIRED])
    return result


def _problem(request: Request) -> dict[str, Any]:
    arguments = request.arguments(())
    del arguments["counter_surface"]
    return arguments


def _compare_all(request: Request, result: list[MapFindings]) -> Comparison | SamplingStudy:
    """Return the comparison of all maps, or the sampling study of a single one."""
    studies = tuple(item.study for item in result if item.study is not None)
    if _is_study_alone(request):
        return studies[0]
    called = dict(zip(groups(request), labels(request), strict=True))
    by_name: dict[str, list[Pressed]] = {}
    for (name, _), item in zip(_list_maps(request), result, strict=True):
        by_name.setdefault(called.get(name, name), []).extend(item.pressed)
    return replace(_load_case(request).together(by_name, request[PAIRED]), sampling=studies)


def _with_remarks(sample: Sample, extra_cautions: tuple[Caution, ...]) -> Sample:
    return replace(sample, curve=replace(sample.curve, extra_cautions=extra_cautions))


def labels(request: Request) -> tuple[str, ...]:
    """Return the label of each group of a comparison."""
    names = list(groups(request))
    if names == list(request.groups):
        return tuple(names)
    short = [Path(path).name for path in names]
    return tuple(
        path if short.count(name) > 1 else name for path, name in zip(names, short, strict=True)
    )


def _quarters(request: Request, surface: Surface) -> tuple[Surface, ...]:
    from roughcontact.surface.placement import partition

    try:
        return partition(surface, 2, request[options.LEVEL])
    except InputError as error:
        raise InputError(ArgumentRef("quarters"), ": ", *error.parts) from None


def _study_sampling(request: Request, surface: Surface, look: OnProgress) -> SamplingStudy:
    from roughcontact.analyses.compare.sampling import sampling_study

    try:
        return sampling_study(
            surface,
            **_problem(request),
            pressure=request.require(LOAD),
            level=request[options.LEVEL],
            progress=look,
        )
    except InputError as error:
        if error.argument == "surface":
            error.argument = "sampling"
        raise


def _check(request: Request) -> None:
    maps = sum(map(len, groups(request).values())) or 1
    alone = not any(map(request.is_given, (QUARTERS, SAMPLING, PRELOAD)))
    # A request with a file covers a single map of a larger comparison.
    if maps < 2 and alone and request.file is None:
        raise InputError(
            f"a single map cannot be compared: give a second one, or {ArgumentRef('quarters')} for "
            f"its four quarters, or {ArgumentRef('sampling')} for the error of its numbers"
        )


TASK = Task(
    "compare",
    """Compare groups of maps, with 95 % intervals.

Files without --group form one group.

\b
Example:
roughcontact compare --group "ground=ground-?.x3p" \\
    --group "honed=honed-?.x3p" \\
    --load "20 MPa" --boundary periodic --material 42CrMo4
""",
    (
        options.GROUP,
        QUARTERS,
        SAMPLING,
        PAIRED,
        *options.MAP,
        LOAD,
        PRELOAD,
        STEPS,
        *options.MATERIALS,
        *options.COATINGS,
        options.BODY,
        options.CEILING,
        options.BOUNDARY,
        *options.SOLVER_DOUBLE,
        OUTPUT,
        FIGURE,
        *options.OUTPUT,
    ),
    short_help="load group quarters sampling preload material missing pixel output report",
    run=_run,
    rules=(
        options.Rule(
            options.NEEDED,
            LOAD,
            text="a nominal pressure such as '20 MPa', the same for maps of all sizes",
        ),
        options.Rule(options.EXCLUDES, QUARTERS, options.GROUP, PAIRED),
    ),
    check=_check,
    last=lambda _: {},
    held="analyses.sweep.model:MAX_HELD_RESULTS",
    maps=("files", "groups"),
    pieces=Subtasks(part_names, find_one_map, file_of),
    presentations={
        "Comparison": "analyses.compare.report:ComparisonPresentation",
        "SamplingStudy": "analyses.compare.report:SamplingPresentation",
    },
)
