"""Peak memory of solves and analyses, compared with the estimates before they start.

    python benchmarks/memory.py                        # every case; a quarter of an hour
    python benchmarks/memory.py --cases solve --points 512
    python benchmarks/memory.py --write    # renew the table of docs/evidence/performance.md
    python benchmarks/memory.py --quick                # a few small ones

Each case runs in a separate process on Linux: a small problem loads the libraries and starts the
threads, the map is created, and the peak of the resident memory (VmHWM) is read after the solve.
``--cases`` takes the cases whose names begin with one of the given words.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
from measuring import Row, make_parser, markdown, proc_status, run_worker, write_parts
from roughcontact.analyses.history import model as load_history
from roughcontact.analyses.history.model import Stage
from roughcontact.analyses.stress import model as subsurface_stress
from roughcontact.contact import memory, validation
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.pair import Pair
from roughcontact.contact.solve import solve_pair
from roughcontact.elastoplastic import problem as volume_memory
from roughcontact.halfspace.boundary import Boundary
from roughcontact.surface.shapes import paraboloid

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
# Mean pressures [Pa]: from a few asperities to all of the map, without a ceiling and with one.
ELASTIC = {"light": 1e7, "tenth": 1.5e9, "third": 5e9, "half": 1e10, "full": 2e11}
PLASTIC = {"light": 3e6, "tenth": 3e8, "half": 1.5e9, "full": 2.97e9}


def cases() -> dict[str, dict[str, Any]]:
    """Return the cases by name."""
    found: dict[str, dict[str, Any]] = {}
    for boundary in Boundary:
        for precision in ("double", "single"):
            for name, pressure in ELASTIC.items():
                found[f"solve {boundary} {precision} elastic {name}"] = {
                    "boundary": str(boundary),
                    "precision": precision,
                    "pressure": pressure,
                    "ceiling": None,
                }
    for boundary in (Boundary.FREE, Boundary.PERIODIC):
        for name, pressure in PLASTIC.items():
            options = {"boundary": str(boundary), "pressure": pressure}
            found[f"solve {boundary} double ceiling {name}"] = options
    light, half = {"pressure": 1e8}, {"pressure": 1.5e9}
    found |= {
        "solve free double ceilings light": {**light, "ceilings": True},
        "solve free double ceilings half": {**half, "ceilings": True},
        "solve free double holes half": {**half, "holes": 0.1},
        "solve free double two half": {**half, "two": True},
        "solve free double tilt light": {**light, "tilt": 0.1},
        "solve free double tilt half": {**half, "tilt": 0.05},
        "solve free double approach light": {"approach": 2e-7},
        "solve free double approach half": {"approach": 2e-6, "ceiling": None},
        "solve periodic double approach light": {"approach": 2e-7, "boundary": "periodic"},
        "solve free double sphere light": {"map": "sphere", "pressure": 1e7, "ceiling": None},
        "solve free double sphere half": {"map": "sphere", "pressure": 1e9, "ceiling": None},
        "solve free double flat full": {"map": "flat", "pressure": 1e9, "ceiling": None},
        "solve free double strip half": {**half, "rows": 0.5},
        "sweep free double light": {**light, "task": "sweep"},
        "sweep free double half": {**half, "task": "sweep"},
        "history free double light": {**light, "task": "history"},
        "history free double half": {**half, "task": "history"},
        "stress free single": {**light, "task": "stress"},
        "stress free single friction": {**light, "task": "stress", "friction": 0.3},
        "stress free double": {**light, "task": "stress", "precision": "double"},
        "stress periodic single": {**light, "task": "stress", "boundary": "periodic"},
        "volume free single": {**light, "task": "volume", "points": 128},
        "volume periodic single": {
            **light,
            "task": "volume",
            "points": 128,
            "boundary": "periodic",
        },
    }
    return found


QUICK = (
    "solve free double elastic light",
    "solve periodic single elastic full",
    "solve free double ceiling half",
)


# In the process of a case ----------------------------------------------------------------------


def surface(case: dict[str, Any], points: int) -> rc.Surface:
    """Return the map of a case."""
    rows = max(64, round(points * case.get("rows", 1)))
    side = 1e-4
    if case.get("map") == "sphere":
        pixel = (side / points, side / points)
        heights = paraboloid((rows, points), pixel, 1e-2)
    elif case.get("map") == "flat":
        pixel = (side / points, side / points)
        heights = 1e-12 * np.random.default_rng(1).standard_normal((rows, points))
    else:
        heights, pixel = rc.reference_map(points)
        heights = heights[:rows].copy()
    if "holes" in case:
        heights[np.random.default_rng(2).random(heights.shape) < case["holes"]] = np.nan
    heights.flags.writeable = False
    return rc.Surface(heights, pixel, holes_masked="holes" in case)


def problem(case: dict[str, Any], points: int) -> tuple[Pair, LoadCase]:
    """Return bodies and load of a case."""
    body = surface(case, points)
    area = body.size[0] * body.size[1]
    other = surface(case, points).rotated(180) if case.get("two") else None
    boundary = Boundary(case.get("boundary", "free"))
    ceiling: Any = case.get("ceiling", "auto")
    if case.get("ceilings"):
        ceiling = np.full(body.shape, 3e9)
    load = None if "approach" in case else case["pressure"] * area
    moments = None
    if "tilt" in case:
        assert load is not None
        moments = (0.0, load * case["tilt"] * body.size[1])
    # The precision of stress and volume is that of their transforms.
    precision = case.get("precision", "double") if "task" not in case else "double"
    terms = LoadCase(load, case.get("approach"), moments, ceiling, precision=precision)
    return Pair(body, STEEL, other, rc.RIGID, boundary), terms


def task_of(
    case: dict[str, Any], pair: Pair, terms: LoadCase
) -> tuple[int, float, Callable[[], float]]:
    """Return the estimate, its contact fraction, and a function that solves the case.

    The fraction of the estimate is that of a coarse grid, which the program uses if the memory is
    scarce; the function returns the true one.
    """
    task = case.get("task", "solve")
    options: dict[str, Any] = {"material": pair.material, "boundary": pair.boundary}
    if task in ("solve", "sweep", "history"):
        stated = validation.build_problem(pair, terms)
        fraction = memory.coarse_contact_guess(pair, stated.problem, stated.scale)
        fraction = max(fraction, memory.start_fraction(stated.problem, None, task == "sweep"))
        del stated
        held = {"solve": 0, "sweep": 3, "history": load_history.MAX_HELD_RESULTS}[task]
        estimate = memory.MemoryNeed.from_pair(pair, terms, held).estimate(fraction)
        load = terms.load or 0.0
        if task == "solve":
            return estimate, fraction, lambda: solve_pair(pair, terms).contact_fraction
        if task == "sweep":
            loads = [load / 2, load]

            def sweep() -> float:
                curve = rc.sweep(pair.surface, loads=loads, **options)
                return curve.steps[-1].contact_area / curve.nominal_area

            return estimate, fraction, sweep

        def history() -> float:
            path = [Stage(load=load), Stage(load=load / 2), Stage(load=load)]
            return rc.history(pair.surface, path, **options).last.contact_fraction

        return estimate, fraction, history
    result = solve_pair(pair, terms)
    if task == "stress":
        below = {
            "friction": case.get("friction", 0.0),
            "precision": case.get("precision", "single"),
        }
        estimate = subsurface_stress.memory_estimate(pair.shape, boundary=pair.boundary, **below)

        def stress() -> float:
            rc.subsurface_stress(result, **below)
            return result.contact_fraction

        return estimate, result.contact_fraction, stress
    layers = 32
    estimate = volume_memory.memory_estimate(pair.shape, layers, boundary=pair.boundary)

    def volume() -> float:
        thickness = np.full(layers, 8e-7)
        found = rc.solve_elastoplastic(
            pair.surface,
            load=terms.load,
            increments=2,
            layers=thickness,
            tolerance=1e-3,
            on_failure="return",
            **options,
        )
        return found.solution.contact_fraction

    return estimate, result.contact_fraction, volume


def reset_peak() -> float:
    """Release freed memory, reset the peak, and return the resident memory of this process."""
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    return proc_status("VmRSS")


def worker(case: dict[str, Any], points: int) -> None:
    """Measure one case in this process."""
    # The first call loads libraries and starts threads.
    task_of(case, *problem(case, 64))[2]()
    pair, terms = problem(case, points)
    estimate, foreseen, solve = task_of(case, pair, terms)
    before = reset_peak()
    row = {"shape": pair.shape, "contact": solve(), "foreseen": foreseen, "estimate": estimate}
    print(json.dumps(row | {"peak": proc_status("VmHWM") - before}))


def line(row: Row) -> str:
    """Return one row as text."""
    pixels, mega = row["shape"][0] * row["shape"][1], 2**20
    return (
        f"{row['case']:42s} {row['shape'][0]:5d} × {row['shape'][1]:<5d} "
        f"contact {100 * row['contact']:6.2f} % (foreseen {100 * row['foreseen']:6.2f} %)  "
        f"estimate {row['estimate'] / mega:6.0f} MiB, peak {row['peak'] / mega:6.0f} MiB, "
        f"{row['peak'] / pixels:5.0f} B/pixel: {row['peak'] / row['estimate']:.2f}"
    )


def spread(values: list[float], form: str) -> str:
    """Return the smallest and the largest value, or one if they look the same."""
    return " to ".join(dict.fromkeys(format(value, form) for value in (min(values), max(values))))


def table(rows: list[Row]) -> str:
    """Return the ranges over the cases of each task and precision as Markdown."""
    kinds: dict[str, list[Row]] = {}
    for row in rows:
        task, _, precision, *_ = row["case"].split()
        kinds.setdefault(f"{task}, {precision}", []).append(row)
    cells = []
    for kind, of_kind in kinds.items():
        contacts = [100 * row["contact"] for row in of_kind]
        bytes_per_point = [row["peak"] / row["shape"][0] / row["shape"][1] for row in of_kind]
        ratios = [row["peak"] / row["estimate"] for row in of_kind]
        ranges = f"{spread(contacts, '.3g')} %", f"{spread(bytes_per_point, '.0f')} B"
        cells.append([kind, str(len(of_kind)), *ranges, spread(ratios, ".2f")])
    return markdown(("task", "cases", "contact", "peak per point", "peak / estimate"), cells)


def main() -> None:
    """Print a line for every case; the exit status is 1 if one needs more than its estimate."""
    parser = make_parser(__doc__)
    parser.add_argument("--cases", nargs="+", default=[""], metavar="WORDS", help="begin of names")
    parser.add_argument("--points", type=int, default=1024, help="per side of the map")
    parser.add_argument("--quick", action="store_true", help="a few cases on 256 × 256 points")
    parser.add_argument("--write", action="store_true", help="renew the table of the page")
    parser.add_argument("--worker", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        worker(json.loads(options.worker[0]), int(options.worker[1]))
        return
    if not Path("/proc/self/clear_refs").exists():
        print("needs Linux: nothing measured")
        return
    known = cases()
    names = QUICK if options.quick else [n for n in known if n.startswith(tuple(options.cases))]
    largest = 256 if options.quick else options.points
    rows = []
    for name in names:
        points = min(largest, known[name].get("points", largest))
        rows.append({"case": name} | run_worker(__file__, json.dumps(known[name]), points))
        print(line(rows[-1]), flush=True)
    if options.write:
        write_parts("memory", table(rows))
    sys.exit(any(row["peak"] > row["estimate"] for row in rows))


if __name__ == "__main__":
    main()
