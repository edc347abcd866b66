"""First example, which needs no measurement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact.cli import console, terminal
from roughcontact.errors import InputError
from roughcontact.request import outputs
from roughcontact.solvers.progress import Progress

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult

_LABELS = ("elastic", "ceiling 3 GPa")


def run_demo(folder: Path, points: int) -> None:
    """Solve a generated surface twice, write all results, and print them."""
    _check_folder(folder)
    with terminal.show_progress() as line:
        line.set_stage("generating the surface")
        results = _solve_demo(points, line)
        folder.mkdir(exist_ok=True)
        files = _demo_files(folder, results)
        outputs.write_files(files, line.set_stage)
    console.show_demo(results, _LABELS, folder, [path.name for path, _ in files])


def _solve_demo(points: int, line: terminal.ProgressLine) -> list[ContactResult]:
    from roughcontact.contact.memory import MemoryNeed
    from roughcontact.contact.solve import solve
    from roughcontact.halfspace.boundary import Boundary
    from roughcontact.material.material import Material
    from roughcontact.surface import random_surfaces
    from roughcontact.surface.provenance import Operation, Provenance
    from roughcontact.surface.surface import Surface

    # The map and the first result stay in memory during the second solve.
    MemoryNeed((points, points), Boundary.FREE, maps=3).require()
    steel = Material(young=210e9, poisson=0.3, yield_strength=1e9, name="steel")
    heights, pixel = random_surfaces.reference_map(points)
    created = Operation("reference_map", {"n": points})
    source = "generated self-affine surface, Hurst exponent 0.8"
    surface = Surface(heights, pixel, Provenance(source, origin=created))
    results = []
    for number, (label, ceiling) in enumerate(zip(_LABELS, (None, "auto"), strict=True), start=1):

        def report_progress(state: Progress, number: int = number, label: str = label) -> None:
            line.update(replace(state, number=number, count=len(_LABELS), label=label))

        result = solve(
            surface,
            load=1.0,
            material=steel,
            ceiling=ceiling,
            progress=report_progress,
            calibrated=False,
        )
        results.append(result)
    return results


def _check_folder(folder: Path) -> None:
    if folder.is_dir():
        outputs.check_place(folder / "elastic.nc", "folder")
    elif folder.exists():
        raise InputError(f"'{folder}' is a file; give the name of a folder", argument="folder")
    else:
        outputs.check_place(folder, "folder")


def _demo_files(
    folder: Path, results: Sequence[ContactResult]
) -> list[tuple[Path, Callable[[Path], object]]]:
    from roughcontact.drawing import maps, sections

    elastic, limited = results
    pair, names = list(results), list(_LABELS)
    return [
        (folder / "ground.x3p", limited.surface.save),
        (folder / "elastic.nc", elastic.save),
        (folder / "ceiling.nc", limited.save),
        (folder / "surface.png", outputs.figure_saver(lambda: maps.surface(limited.surface))),
        (folder / "comparison.png", outputs.figure_saver(lambda: maps.comparison(pair, names))),
        (
            folder / "histogram.png",
            outputs.figure_saver(lambda: sections.pressure_histogram(pair, names)),
        ),
        (folder / "overview.png", outputs.figure_saver(lambda: maps.overview(limited))),
    ]
