"""Repeated passes over a body that yields: time, memory, disk and what they come to.

    python benchmarks/rolling.py                        # every case
    python benchmarks/rolling.py --cases line --write   # one, into docs/evidence/performance.md
    python benchmarks/rolling.py --quick                # every case at a tiny size

A roller and a ball pass over a perfectly plastic flat, round and round on a periodic map, above the
shakedown limit, so that every pass flows. Each case runs in a process of its own; memory is the
peak of that process, the interpreter and all imports included.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from peers import peak_memory

RESULTS = Path(__file__).with_name("rolling.json")
PAGE = Path(__file__).parents[1] / "docs" / "evidence" / "performance.md"
START, END = "<!-- rolling -->", "<!-- rolling end -->"

YOUNG, POISSON, YIELD, EDGE = 210e9, 0.3, 1e9, 1e-6


@dataclass(frozen=True)
class Case:
    """Some passes; ``peak`` is Hertz's pressure over the shear strength, ``half`` in pixels."""

    shape: tuple[int, int]
    layers: int
    passes: int
    steps: int
    peak: float
    half: int
    kept: bool = False


CASES = {
    "line": Case((8, 256), 32, 5, 64, 4.2, 24),
    "line-kept": Case((8, 256), 32, 5, 64, 4.2, 24, kept=True),
    "point": Case((128, 128), 32, 10, 64, 5.5, 12),
    "point-kept": Case((128, 128), 32, 10, 64, 5.5, 12, kept=True),
}
TINY = {"line": ((8, 24), 4), "point": ((20, 20), 3)}


def quick(name: str) -> Case:
    """Return a case at a tiny size."""
    case = CASES[name]
    shape, half = TINY[name.removesuffix("-kept")]
    return Case(shape, 8, 2, 4, case.peak, half, case.kept)


def run(case: Case, folder: Path) -> dict[str, Any]:
    """Go the passes of a case."""
    import roughcontact as rc
    from roughcontact.surface import nominal_bodies

    grid: dict[str, Any] = {"shape": case.shape, "pixel": (EDGE, EDGE)}
    pressure, width = case.peak * YIELD / math.sqrt(3), case.half * EDGE
    radius = width * YOUNG / (1 - POISSON**2) / (2 * pressure)
    if case.shape[0] == case.shape[1]:
        radius *= 4 / math.pi
        body = nominal_bodies.sphere(radius=radius, **grid)
        load = 2 / 3 * math.pi * width**2 * pressure
    else:
        body = nominal_bodies.cylinder(radius=radius, angle=90.0, **grid)
        load = math.pi / 2 * width * pressure * case.shape[0] * EDGE
    cpu, began = time.process_time(), time.perf_counter()
    rolled = rc.roll(
        nominal_bodies.flat(**grid),
        counter_surface=body,
        material=rc.Material(YOUNG, POISSON, YIELD),
        load=load,
        passes=case.passes,
        steps=case.steps,
        boundary="periodic",
        layers=np.full(case.layers, 2.5 * width / case.layers),
        folder=folder / "kept" if case.kept else None,
    )
    result = rolled.result
    return {
        "seconds": time.perf_counter() - began,
        "cpu": time.process_time() - cpu,
        "iterations": result.iterations,
        "disk": sum(f.stat().st_size for f in folder.rglob("*") if f.is_file()) / 1e6,
        "answer": rolled.outcome_text,
        "strain": result.max_plastic_strain,
        "tolerance": result.tolerance,
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else math.nan,
    }


def worker(name: str, folder: Path, *, tiny: bool) -> None:
    """Run one case in this process."""
    row = run(quick(name) if tiny else CASES[name], folder)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    print(json.dumps(row | {"cores": cores, "peak": peak_memory()}))


def measure(name: str, *, tiny: bool) -> dict[str, Any]:
    """Run one case in a process of its own."""
    case = quick(name) if tiny else CASES[name]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, "--worker", name, folder, *["--quick"] * tiny]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{name}: {done.stderr.strip()}")
    found = json.loads(done.stdout.splitlines()[-1])
    size = " × ".join(map(str, (*case.shape, case.layers)))
    return {"case": name, "size": size, "passes": case.passes, "steps": case.steps, **found}


def table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| case | points × layers | passes × steps | iterations | time | CPU | peak memory "
        "| disk | outcome |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row['case']} | {row['size']} | {row['passes']} × {row['steps']} | {row['iterations']} "
        f"| {row['seconds']:.3g} s | {row['cpu']:.3g} s | {row['peak']:.0f} MB "
        f"| {row['disk']:.3g} MB | {row['answer']} |"
        for row in rows
    ]
    return "\n".join(lines)


def keep(rows: list[dict[str, Any]]) -> None:
    """Put rows into rolling.json, in place of older ones, and the table into the documentation."""
    old = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else []
    unique = {row["case"]: row for row in [*old, *rows]}
    kept = [unique[name] for name in CASES if name in unique]
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.index(START) + len(START), text.index(END)
    PAGE.write_text(f"{text[:before]}\n{table(kept)}\n{text[after:]}", encoding="utf-8")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = list(CASES)
    parser.add_argument(
        "--cases", nargs="+", choices=names, default=names, metavar="CASE", help=", ".join(names)
    )
    parser.add_argument("--quick", action="store_true", help="tiny sizes, two passes")
    parser.add_argument("--write", action="store_true", help=f"keep the rows, renew {PAGE.name}")
    parser.add_argument("--worker", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        worker(options.worker[0], Path(options.worker[1]), tiny=options.quick)
        return
    if options.quick and options.write:
        parser.error("--quick measures nothing that should be kept: leave out --write")
    rows = [measure(name, tiny=options.quick) for name in options.cases]
    print(table(rows))
    if options.write:
        keep(rows)


if __name__ == "__main__":
    main()
