"""Formulas for nominally flat contact: their cases computed, fitted, tested and stored.

    python calibration/atlas.py                 # what is missing of all cases, then fit and test
    python calibration/atlas.py --maps 4        # the first maps of each kind alone
    python calibration/atlas.py --fit           # fit and test what is stored

Every case is a line of ``atlas/ceiling.csv`` or ``atlas/volume.csv`` as soon as its map is done;
existing cases are not solved again. On all cores, one map each at a time, or on any other engine
of projects (``--engine``, ``--workers``, ``--scheduler`` as for ``roughcontact run``; workers that
are started elsewhere need this folder in their ``PYTHONPATH``). The coefficients go to the
package (``analyses/estimate/atlas.json``), with scatter and domain; what they miss on maps that
took no part
in the fit is printed. ``--measured FOLDER`` presses the measured maps of a folder, of which numbers
alone are kept, in ``atlas/measured.csv``.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import as_completed
from dataclasses import asdict
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np

import atlas_cases as cases
import roughcontact as rc
from roughcontact.analyses.estimate import stored_formulas
from roughcontact.analyses.estimate.model import MIN_WAVES
from roughcontact.analyses.tasks import DASK, LOCAL
from roughcontact.batch import runner
from roughcontact.theory import height_distribution

FOLDER = Path(__file__).parent / "atlas"
CEILING, VOLUME = FOLDER / "ceiling.csv", FOLDER / "volume.csv"
MEASURED = FOLDER / "measured.csv"
DRAWN = ("map", "case", "hurst", "rolloff", "waves")
SURFACE = ("breadth", "Str", "Ssk", "Sku", "nayak", "gradient", "height")
COLUMNS: dict[Path, tuple[str, ...]] = {
    CEILING: (
        *DRAWN,
        *SURFACE,
        "pressure",
        "index",
        "contact",
        "pixels",
        "saturated",
        "gap",
        "contact_coarse",
        "pixels_coarse",
        "saturated_coarse",
        "gap_coarse",
        "separation",
    ),
    VOLUME: (*DRAWN, *SURFACE, "pressure", "index", "hardening", "volume", "contact", "strain"),
}


COLUMNS[MEASURED] = COLUMNS[CEILING]


def read_cases(place: Path) -> list[dict[str, str]]:
    """Return the cases that are in a table; a line that was cut off does not count."""
    if not place.exists():
        return []
    with place.open(newline="") as lines:
        return [
            row
            for row in csv.DictReader(lines)
            if None not in row.values() and None not in row and row[COLUMNS[place][-1]]
        ]


def prepare_table(place: Path) -> None:
    """Make a table ready for further lines."""
    place.parent.mkdir(exist_ok=True)
    if not place.exists():
        place.write_text(",".join(COLUMNS[place]) + "\n")
    elif not place.read_bytes().endswith(b"\n"):
        # The rest of a line that was cut off.
        with place.open("a") as table:
            table.write("\n")


def append_case(place: Path, drawn: cases.Map, case: int, row: cases.Row) -> None:
    """Add a case to its table, in one piece."""
    row = {
        "map": drawn.name,
        "case": case,
        "hurst": drawn.hurst,
        "rolloff": drawn.rolloff,
        "waves": drawn.breadth,
        **row,
    }
    texts = (
        value if isinstance(value := row[name], (str, int)) else f"{value:.6g}"
        for name in COLUMNS[place]
    )
    line = ",".join(map(str, texts)) + "\n"
    with place.open("ab", buffering=0) as table:
        table.write(line.encode())


def measurements(place: Path, name: str) -> str:
    """Solve the cases of a measured map, if it is in the domain of the formulas."""
    surface, about = cases.read_measured(place)
    domain = stored_formulas.load_atlas().domain["ceiling"]
    skewness, kurtosis = float(about["Ssk"]), float(about["Sku"])
    known = {
        "breadth": about["breadth"],
        "texture": about["Str"],
        "skewness": skewness,
        "tails": kurtosis / height_distribution.usual_kurtosis(skewness),
        "middle": kurtosis - height_distribution.least_kurtosis(skewness),
    }
    for group, value in known.items():
        low, high = domain[group]
        if not low <= float(value) <= high:
            return f"{name} left out, {group} {value:.3g}"
    waves = float(about.pop("waves"))
    if waves < MIN_WAVES:
        return f"{name} left out, {waves:.1f} autocorrelation lengths a side"
    # Nothing is known of how it would be drawn; what it has are lengths of its correlation a side.
    drawn = cases.Map(name, surface.shape[0], 0.0, waves, 0.0, 0.0, 0.0, np.empty(0))
    for case, (fraction, index) in enumerate(cases.MEASURED_LOADS):
        pressure = cases.pressure_of(fraction, index)
        append_case(
            MEASURED, drawn, case, about | cases.solve_ceiling_case(surface, pressure, index)
        )
    return name


def measure(folder: Path) -> None:
    """Solve the cases of all measured maps of a folder, again."""
    MEASURED.unlink(missing_ok=True)
    prepare_table(MEASURED)
    for place in sorted(folder.iterdir()):
        try:
            print(measurements(place, f"held-{place.stem}"), flush=True)
        except (rc.RoughcontactError, ValueError) as error:
            print(f"{place.name} left out: {str(error)[:90]}")


def missing_cases(
    place: Path, maps: Iterable[cases.Map], wanted: int
) -> list[tuple[cases.Map, set[int]]]:
    """Return the maps of which cases are missing, with those that are there."""
    there: dict[str, set[int]] = {}
    for row in read_cases(place):
        there.setdefault(row["map"], set()).add(int(row["case"]))
    found = [(drawn, there.get(drawn.name, set())) for drawn in maps]
    return [(drawn, done) for drawn, done in found if len(done) < wanted]


Task = tuple[Path, Callable[..., list[tuple[int, cases.Row]]], cases.Map, set[int]]


def missing_tasks(most: int | None) -> list[Task]:
    """Return the missing cases: table, solver, map, and the existing rows."""
    volume, ceiling = cases.volume_maps()[:most], cases.ceiling_maps()[:most]
    tasks: list[Task] = []
    for place, work, maps, wanted in (
        (CEILING, cases.ceilings, ceiling, cases.CASES),
        (VOLUME, cases.volumes, volume, cases.LOADS),
    ):
        prepare_table(place)
        tasks += [(place, work, drawn, done) for drawn, done in missing_cases(place, maps, wanted)]
    # Those of both models in turns, as they are in their lists.
    tasks.sort(key=lambda task: int(task[2].name[-3:]) / (3 if task[0] == CEILING else 1))
    return tasks


def compute(most: int | None, kind: str, workers: int | None, scheduler: str | None) -> None:
    """Solve what is missing."""
    with runner.open_project(lambda: missing_tasks(most), len, kind, workers, scheduler) as (
        engine,
        tasks,
    ):
        working = {
            engine.executor.submit(cases.solve_cases, engine.threads, *task[1:]): task
            for task in tasks
        }
        for number, one in enumerate(as_completed(working), 1):
            place, _, drawn, _ = working[one]
            failure = one.exception()
            for case, row in () if failure else one.result():
                append_case(place, drawn, case, row)
            status = f"failed: {failure}" if failure else "solved"
            print(f"{number}/{len(working)} {drawn.name} {status}", flush=True)


def fit() -> None:
    """Fit the formulas to what is stored, write them to the package, and say what they miss."""
    import atlas_fit as fitting

    stored: dict[str, Any] = {"formulas": {}, "domain": {}, "held": {}}
    known: dict[str, stored_formulas.Formula] = {}
    for name, place in (("ceiling", CEILING), ("volume", VOLUME)):
        cases = fitting.read(place)
        stored["domain"][name] = fitting.domain_of(cases)
        test, rest = cases.select(cases.is_held_out), cases.select(~cases.is_held_out)
        for quantity in cases.found:
            variants = [("", lambda one: one), ("_without_Sal", fitting.drop_correlation_length)]
            knows_Sal = any("b" in term for term in fitting.TERMS[quantity])
            for suffix, of in variants[: 1 + knows_Sal]:
                formula = fitting.fit_quantity(quantity, of(rest), with_Sal=not suffix)
                judged = fitting.evaluate_formula(formula, of(test))
                stored["formulas"][quantity + suffix] = asdict(formula)
                stored["held"][quantity + suffix] = judged
                words = ", ".join(f"{key} {value:.4g}" for key, value in judged.items())
                print(f"{quantity + suffix}: {words}", flush=True)
                known[quantity + suffix] = formula
    stored["measured"] = fitting.interval_factor(known, fitting.read(MEASURED))
    stored_formulas.STORED.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, help="the first maps of each kind alone")
    parser.add_argument("--fit", action="store_true", help="fit and test what is stored")
    parser.add_argument("--measured", type=Path, help="press the measured maps of this folder")
    parser.add_argument("--engine", choices=(LOCAL, DASK), default=LOCAL, help="what works")
    parser.add_argument("--workers", type=int, help="processes of this machine")
    parser.add_argument("--scheduler", help="that of a Dask cluster")
    options = parser.parse_args()
    if options.measured is not None:
        measure(options.measured)
    else:
        if not options.fit:
            compute(options.maps, options.engine, options.workers, options.scheduler)
        fit()
    # The figures of the page are made from the same cases when it is built.
    import atlas_page

    atlas_page.write(MEASURED)


if __name__ == "__main__":
    main()
