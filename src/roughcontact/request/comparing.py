"""The maps of a comparison: read, prepared, cut into quarters if wanted, and compared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.contact.cautions import Caution, of_measurement
from roughcontact.errors import InputError, Mention
from roughcontact.request import problem
from roughcontact.request.maps import resolution_notes, surfaces
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress
from roughcontact.surface.partition import partition

if TYPE_CHECKING:
    from roughcontact.contact.compare import Asked, Pressed
    from roughcontact.contact.compared import Comparison
    from roughcontact.contact.sample import Sample
    from roughcontact.contact.sampling import SamplingStudy
    from roughcontact.surface.surface import Surface

Look = Callable[[Progress], None]

_QUARTERS = 4

BESIDE = ("group", "paired")
"""Options that say which maps are set beside which, and nothing of any one of them."""


@dataclass(frozen=True, eq=False)
class Found:
    """What is found of one map of a comparison, by itself.

    Parameters
    ----------
    pressed : tuple
        Of the map, or of each of its quarters, from `contact.compare.Asked.pressed`; empty where
        the sampling error of a single map is all that was asked for.
    study : SamplingStudy or None
        The sampling error, if it was asked for.
    """

    pressed: tuple[Pressed, ...]
    study: SamplingStudy | None = None


def compared(
    request: Request, say: Say, look: Look, known: Mapping[str, Found] | None = None
) -> Comparison | SamplingStudy:
    """Return what the maps of a request give.

    Parameters
    ----------
    request : Request
        What was asked for.
    say : callable
        Called with a few words before every stage.
    look : callable
        Called with the `Progress` of the solver.
    known : mapping, optional
        What was found of each map before, from `found_of`, by the words of `apart`.

    Returns
    -------
    Comparison or SamplingStudy
        The comparison, with the sampling errors if they were asked for; these alone of a single
        map.

    Raises
    ------
    RoughcontactError
        If it cannot be done.
    """
    if known:
        return _together(request, [known[word] for word in apart(request)])
    # All are read first: one that cannot be is told of before any is solved.
    maps = [_read(request, path, say) for _, path in _listed(request)]
    return _together(request, [_found(request, surface, look) for surface in maps])


def apart(request: Request) -> tuple[str, ...]:
    """Return a word for each map of a comparison, each of which can be pressed by itself."""
    return tuple(str(number) for number, _ in enumerate(_listed(request)))


def file_of(request: Request, word: str) -> Path | None:
    """Return the file of one map; None where it is a nominal body."""
    return _listed(request)[int(word)][1]


def found_of(request: Request, word: str, say: Say, look: Look) -> Found:
    """Return what is found of one map, read alone; see `compared`."""
    return _found(request, _read(request, file_of(request, word), say), look)


def _listed(request: Request) -> list[tuple[str, Path | None]]:
    """Return the maps in their order, with the names of their groups."""
    groups = request.groups
    return [(name, path) for name, paths in groups.items() for path in paths] or [("", None)]


def _read(request: Request, path: Path | None, say: Say) -> Surface:
    values = {name: value for name, value in request.values.items() if name != "group"}
    (surface,) = surfaces(replace(request, file=path, files=(), values=values), say)
    return surface


def _found(request: Request, surface: Surface, look: Look) -> Found:
    remarks = of_measurement(resolution_notes(request, [surface]))
    alone = _is_study_alone(request)
    # What cannot be compared is told of before anything is solved.
    asked = None if alone else _asked(request)
    study = _studied(request, surface, look) if request["sampling"] else None
    if study is not None:
        study = replace(study, whole=_remarked(study.whole, remarks))
    if asked is None:
        return Found((), study)
    parts = _quarters(request, surface) if request["quarters"] else (surface,)
    pressed = []
    for number, part in enumerate(parts, start=1):
        # Their own names they are given where all are there.
        name = surface.provenance.source or "map"
        name += f", part {number} of {len(parts)}" if request["quarters"] else ""
        pressed.append(tuple(_remarked(one, remarks) for one in asked.pressed(part, name, look)))
    return Found(tuple(pressed), study)


def _is_study_alone(request: Request) -> bool:
    """Return whether the sampling error of a single map is all that is asked for."""
    more = request["quarters"] or request["first-load"]
    return bool(request["sampling"] and not more and len(_listed(request)) == 1)


def _asked(request: Request) -> Asked:
    from roughcontact.contact.compare import asked

    found = asked(request["load"], request["steps"], request["first-load"], _problem(request))
    counts = Counter(name for name, _ in _listed(request))
    each = _QUARTERS if request["quarters"] else 1
    found.check({name: each * count for name, count in counts.items()}, request["paired"])
    return found


def _problem(request: Request) -> dict[str, Any]:
    options = problem.arguments(request, (), "tolerance", "max-iterations")
    del options["counter_surface"]
    return options


def _together(request: Request, found: list[Found]) -> Comparison | SamplingStudy:
    """Return the comparison of all maps."""
    studies = tuple(one.study for one in found if one.study is not None)
    if _is_study_alone(request):
        return studies[0]
    called = dict(zip(request.groups, labels(request), strict=True))
    groups: dict[str, list[Pressed]] = {}
    for (name, _), one in zip(_listed(request), found, strict=True):
        groups.setdefault(called.get(name, name), []).extend(one.pressed)
    return replace(_asked(request).together(groups, request["paired"]), sampling=studies)


def _remarked(sample: Sample, remarks: tuple[Caution, ...]) -> Sample:
    return replace(sample, curve=replace(sample.curve, remarks=remarks))


def labels(request: Request) -> tuple[str, ...]:
    """Return what each group of a comparison is called.

    Quarters go by the names of their files, where these are their own.
    """
    names = list(request.groups)
    if not request.get("quarters"):
        return tuple(names)
    short = [Path(path).name for path in names]
    return tuple(
        path if short.count(name) > 1 else name for path, name in zip(names, short, strict=True)
    )


def _quarters(request: Request, surface: Surface) -> tuple[Surface, ...]:
    try:
        return partition(surface, 2, request["level"])
    except InputError as error:
        raise InputError(Mention("quarters"), ": ", *error.parts) from None


def _studied(request: Request, surface: Surface, look: Look) -> SamplingStudy:
    from roughcontact.contact.sampling import sampling_error

    try:
        return sampling_error(
            surface,
            **_problem(request),
            pressure=request["load"],
            level=request["level"],
            progress=look,
        )
    except InputError as error:
        if error.argument == "surface":
            error.argument = "sampling"
        raise
