"""The maps of a comparison: read, prepared, cut into quarters if wanted, and compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.contact.cautions import Caution, of_measurement
from roughcontact.errors import InputError, Mention
from roughcontact.request.maps import resolution_notes, surfaces
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress
from roughcontact.surface.partition import partition

if TYPE_CHECKING:
    from roughcontact.contact.compared import Comparison
    from roughcontact.contact.sample import Sample
    from roughcontact.contact.sampling import SamplingStudy
    from roughcontact.surface.surface import Surface

Remarks = dict[str, tuple[Caution, ...]]


def compared(
    request: Request, problem: dict[str, Any], say: Say, look: Callable[[Progress], None]
) -> Comparison | SamplingStudy:
    """Return what the maps of a request give.

    Parameters
    ----------
    request : Request
        What was asked for.
    problem : dict
        What `contact.compare` takes besides maps and pressures.
    say : callable
        Called with a few words before every stage.
    look : callable
        Called with the `Progress` of the solver.

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
    from roughcontact.contact.compare import compare

    groups, remarks = _maps(request, say)
    whole = [surface for surfaces_ in groups.values() for surface in surfaces_]
    studies = tuple(_studied(request, surface, problem, look) for surface in whole
                    if request["sampling"])  # fmt: skip
    studies = tuple(replace(one, whole=_remarked(one.whole, remarks)) for one in studies)
    if len(whole) == 1 and studies and not (request["quarters"] or request["first-load"]):
        return studies[0]
    if request["quarters"]:
        groups = _quarters(request, groups)
    found = compare(
        groups,
        **problem,
        pressure=request["load"],
        steps=request["steps"],
        first_pressure=request["first-load"],
        paired=request["paired"],
        progress=look,
    )
    told = tuple(
        replace(group, samples=tuple(_remarked(sample, remarks) for sample in group.samples))
        for group in found.groups
    )
    return replace(found, groups=told, sampling=studies)


def _maps(request: Request, say: Say) -> tuple[dict[str, list[Surface]], Remarks]:
    """Return the prepared maps by group, and what is known of their measurement by source."""
    groups: dict[str, list[Surface]] = {}
    remarks: Remarks = {}
    files: dict[str, list[Path | None]] = {name: [*paths] for name, paths in request.groups.items()}
    values = {name: value for name, value in request.values.items() if name != "group"}
    for name, paths in (files or {"": [None]}).items():
        for path in paths:
            single = replace(request, file=path, files=(), values=values)
            (surface,) = surfaces(single, say)
            groups.setdefault(name, []).append(surface)
            remarks[surface.provenance.source] = of_measurement(
                resolution_notes(request, [surface])
            )
    return groups, remarks


def _remarked(sample: Sample, remarks: Remarks) -> Sample:
    known = remarks.get(sample.source, ())
    return replace(sample, curve=replace(sample.curve, remarks=known))


def _quarters(request: Request, groups: dict[str, list[Surface]]) -> dict[str, list[Surface]]:
    """Return each map as a group of its quarters, by the name of its file where that is its own."""
    names = [Path(name).name for name in groups]
    found = {}
    for path, surfaces_ in groups.items():
        name = Path(path).name if names.count(Path(path).name) == 1 else path
        try:
            found[name] = list(partition(surfaces_[0], 2, request["level"]))
        except InputError as error:
            raise InputError(Mention("quarters"), ": ", *error.parts) from None
    return found


def _studied(
    request: Request,
    surface: Surface,
    problem: dict[str, Any],
    look: Callable[[Progress], None],
) -> SamplingStudy:
    from roughcontact.contact.sampling import sampling_error

    try:
        return sampling_error(
            surface, **problem, pressure=request["load"], level=request["level"], progress=look
        )
    except InputError as error:
        if error.argument == "surface":
            error.argument = "sampling"
        raise
