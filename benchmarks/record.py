"""The numbers that stay: times and memory of what people do, kept with their date.

    python benchmarks/record.py            # compare with the last record; exit status 1 if worse
    python benchmarks/record.py --keep     # store it in record.json
    python benchmarks/record.py --quick    # one small task, once
    python benchmarks/record.py --growth 8192   # how cost grows with the grid, up to so many points

`--growth` ends a task where its next grid would take more than `LONGEST` seconds or the memory that
is free; it writes growth.json, which the documentation draws.

Every task runs in a process of its own, several times, each beside some plain padded
``scipy.fft.rfft2`` + ``irfft2`` pairs of 1024 × 1024 points. Times are compared as ratios to
T_pair, the median of these pairs over the whole run, memory as the peak above what the import
takes. What is more than 10 % above the last record is named.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil

import roughcontact as rc
from peers import pair_time, peak_memory

RECORD = Path(__file__).with_name("record.json")
GROWTH = Path(__file__).with_name("growth.json")

# Above the last record by more than that is worse.
WORSE = 0.1
PAIR_POINTS = 1024

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
SWIFT = rc.Material(young=210e9, poisson=0.3, hardening=rc.hardening.Swift(1280e6, 0.004, 0.095))


def _rough(points: int) -> rc.Surface:
    heights, pixel = rc.reference_map(points)
    return rc.Surface(heights, pixel)


def _contact(points: int, **options: Any) -> Callable[[], object]:
    surface = _rough(points)
    return lambda: rc.solve(surface, material=STEEL, load=1.0, **options)


def _curve(points: int) -> Callable[[], object]:
    surface = _rough(points)
    return lambda: rc.sweep(surface, material=STEEL, loads=np.geomspace(0.01, 3, 8))


def _stress(points: int) -> Callable[[], object]:
    result = _contact(points)()
    return lambda: rc.subsurface_stress(result)


def _slip(points: int) -> Callable[[], object]:
    result = _contact(points)()
    return lambda: rc.tangential(result, friction=0.15, force=0.075)


def _leak(points: int) -> Callable[[], object]:
    result = rc.solve(_rough(points), material=STEEL, load=1.0, boundary="periodic")
    return lambda: rc.leakage([result])


def _conductance(points: int) -> Callable[[], object]:
    result = rc.solve(_rough(points), material=STEEL, load=1.0, boundary="periodic")
    body, counter_body = (rc.catalog.entry(name).conductor for name in ("42CrMo4", "Cu-ETP"))
    return lambda: rc.conductance([result], body, counter_body)


def _ball(points: int) -> Callable[[], object]:
    from roughcontact.surface import nominal_bodies

    grid = {"shape": (points, points), "pixel": (4e-4 / points, 4e-4 / points)}
    ball = nominal_bodies.sphere(radius=5e-3, **grid)
    return lambda: rc.solve_elastoplastic(ball, material=SWIFT, load=100.0, increments=4)


def _rolling(points: int) -> Callable[[], object]:
    from roughcontact.surface import nominal_bodies

    grid = {"shape": (8, points), "pixel": (1e-6, 1e-6)}
    roller = nominal_bodies.cylinder(radius=2e-3, angle=90.0, **grid)
    return lambda: rc.roll(
        nominal_bodies.flat(**grid),
        counter_surface=roller,
        material=STEEL,
        load=0.15,
        passes=2,
        steps=16,
        boundary="periodic",
    )


TASKS: dict[str, tuple[Callable[..., Callable[[], object]], int, dict[str, Any]]] = {
    "contact, ceiling, 512²": (_contact, 512, {}),
    "contact, ceiling, 1024²": (_contact, 1024, {}),
    "contact, ceiling, 2048²": (_contact, 2048, {}),
    "contact, elastic, 1024²": (_contact, 1024, {"ceiling": None}),
    "contact, elastic, 2048²": (_contact, 2048, {"ceiling": None}),
    "contact, periodic, ceiling, 1024²": (_contact, 1024, {"boundary": "periodic"}),
    "contact, single precision, 2048²": (_contact, 2048, {"precision": "single"}),
    "load curve, 8 loads, 512²": (_curve, 512, {}),
    "stress below, 512²": (_stress, 512, {}),
    "partial slip, 512²": (_slip, 512, {}),
    "leakage, 512²": (_leak, 512, {}),
    "conductance, 512²": (_conductance, 512, {}),
    "ball with plastic volume, 48²": (_ball, 48, {}),
    "rolling, 2 passes of 16 steps, 8 × 128": (_rolling, 128, {}),
}
QUICK = {"contact, ceiling, 128²": (_contact, 128, {})}
# Task, and points per side of its smallest grid; every next one has twice as many.
GROWING: dict[str, tuple[Callable[..., Callable[[], object]], int]] = {
    "solve": (_contact, 256),
    "sweep": (_curve, 256),
    "stress": (_stress, 256),
    "leak": (_leak, 256),
    "volume": (_ball, 32),
}
# Seconds that a task of `--growth` may take.
LONGEST = 300.0


def worker(name: str, points: int = 0) -> None:
    """Do a task once, in this process, and tell what it took."""
    if points:
        make, options = GROWING[name][0], {}
    else:
        make, points, options = {**TASKS, **QUICK}[name]
    # Libraries are loaded and threads started by a small one.
    make(16 if make is _ball else 32, **options)()
    task = make(points, **options)
    before = peak_memory()
    began = time.perf_counter()
    task()
    seconds = time.perf_counter() - began
    whole = peak_memory()
    print(json.dumps({"seconds": seconds, "above": whole - before, "whole": whole}))


def measured(name: str, repeats: int, pairs: list[float]) -> dict[str, float]:
    """Return time [s] and memory [MB] of a task, medians; add the pairs beside it to others."""
    answers = []
    for _ in range(repeats):
        pairs.append(pair_time(PAIR_POINTS))
        done = subprocess.run(
            [sys.executable, __file__, "--worker", name], capture_output=True, text=True, check=True
        )
        answers.append(json.loads(done.stdout))
    return {
        "seconds": round(statistics.median(answer["seconds"] for answer in answers), 4),
        "above": round(statistics.median(answer["above"] for answer in answers), 1),
    }


def grown(name: str, largest: int) -> dict[int, dict[str, float]]:
    """Return seconds, T_pair of the same grid and bytes a pixel of a task, by points per side."""
    rows: dict[int, dict[str, float]] = {}
    points = GROWING[name][1]
    while points <= largest:
        pair = pair_time(points)
        words = [sys.executable, __file__, "--worker", name, "--points", str(points)]
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        answer = json.loads(done.stdout)
        rows[points] = {
            "seconds": round(answer["seconds"], 4),
            "pairs": round(answer["seconds"] / pair, 2),
            "bytes": round(1e6 * answer["above"] / points**2, 1),
        }
        print(f"{name:8s} {points:5d}² {rows[points]}", flush=True)
        # Of a volume the layers grow, too.
        times = 10 if name == "volume" else 5
        memory = 1e6 * times * answer["whole"]
        if times * answer["seconds"] > LONGEST or memory > psutil.virtual_memory().available:
            break
        points *= 2
    return rows


def worse(now: dict[str, dict[str, float]], last: dict[str, dict[str, float]]) -> list[str]:
    """Return what became slower or larger than it was.

    Parameters
    ----------
    now, last : dict
        Rows of two records by task.

    Returns
    -------
    list of str
        In words; empty where nothing is more than 10 % above.
    """
    told = []
    for name, row in now.items():
        for what, unit in (("pairs", "T_pair"), ("above", "MB")):
            before = last.get(name, {}).get(what)
            # A few megabytes come and go with the allocator.
            least = 5.0 if what == "above" else 0.0
            if before and row[what] - before > max(WORSE * before, least):
                told.append(f"{name}: {row[what]:.3g} {unit}, was {before:.3g}")
    return told


def kept(record: dict[str, Any], records: list[dict[str, Any]]) -> None:
    """Store a record, one per version and day."""
    once = ("date", "version")
    records = [old for old in records if any(old[key] != record[key] for key in once)] + [record]
    RECORD.write_text(json.dumps(records, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main() -> int:
    """Measure, compare, and keep if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="keep what is measured")
    parser.add_argument("--quick", action="store_true", help="one small task, once")
    parser.add_argument("--repeats", type=int, default=5, help="of each task, the median counts")
    parser.add_argument("--growth", type=int, metavar="POINTS", help="up to so many per side")
    parser.add_argument("--worker", choices=[*TASKS, *QUICK, *GROWING], help=argparse.SUPPRESS)
    parser.add_argument("--points", type=int, default=0, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.worker:
        # What a task writes goes with it.
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            worker(given.worker, given.points)
            os.chdir(Path(__file__).parent)
        return 0
    if given.growth:
        found = {name: grown(name, given.growth) for name in GROWING}
        GROWTH.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return 0
    pairs: list[float] = []
    rows = {
        name: measured(name, 1 if given.quick else given.repeats, pairs)
        for name in (QUICK if given.quick else TASKS)
    }
    # One for all: single pairs vary by a third on a shared machine, their median by some per cent.
    pair = statistics.median(pairs)
    for name, row in rows.items():
        row["pairs"] = round(row["seconds"] / pair, 2)
        print(
            f"{name:40s} {row['seconds']:8.3f} s {row['pairs']:8.2f} T_pair {row['above']:8.1f} MB"
        )
    records = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else []
    above = worse(rows, records[-1]["rows"] if records else {})
    print("".join(f"worse: {told}\n" for told in above), end="")
    if given.keep:
        machine = (
            f"{os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}"
        )
        today = datetime.date.today().isoformat()
        record = {"date": today, "version": rc.__version__, "machine": machine, "rows": rows}
        kept(record, records)
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
