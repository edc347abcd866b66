"""Plasticity of the volume: time, memory, disk and results of load paths and of repeated passes.

    python benchmarks/plasticity.py                             # every case; an hour
    python benchmarks/plasticity.py --cases swift-256 --write   # one, stored and on the page
    python benchmarks/plasticity.py --cases indentation --peer-python env/bin/python
    python benchmarks/plasticity.py --quick                     # every case at a tiny size

Each case runs in a separate process; memory is the peak of that process, with the interpreter and
all imports. *indentation* is also solved by Tamaas where it is installed (``--peer-python`` names
its interpreter), both on one core. In the cases *line* and *point* a roller and a ball pass over a
perfectly plastic flat on a periodic map, above the shakedown limit, so that every pass yields.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from measuring import (
    Row,
    core_count,
    is_installed,
    machine,
    make_parser,
    markdown,
    merge_rows,
    peak_memory,
    try_worker,
    write_parts,
)

import indentation  # isort: skip - measuring makes it importable

STORED = Path(__file__).with_name("plasticity.json")

# A sphere of 105 µm under 0.65 N, Swift hardening; Hertz's radius.
SPHERE, SPHERE_LOAD, HERTZ = 105e-6, 0.65, 6.053e-6
# The rough map R(N), in contact on a tenth of it.
ROUGH_LOAD, YIELD = 2.5, 1e9
INCREMENTS = 10


@dataclass(frozen=True)
class Case:
    """A load path; ``tiny`` and ``few`` are points and layers of its quick version.

    Without a number of layers the program chooses it.
    """

    kind: str
    points: int
    layers: int | None
    boundary: str
    precision: str
    tiny: int
    few: int | None
    cores: int | None = None


@dataclass(frozen=True)
class Passes:
    """Repeated passes; ``peak`` is Hertz's pressure over the shear strength, ``half`` in pixels.

    ``tiny`` and ``few`` are the shape and the half-width of the quick version.
    """

    shape: tuple[int, int]
    passes: int
    peak: float
    half: int
    tiny: tuple[int, int]
    few: int
    kept: bool = False
    layers: int = 32
    steps: int = 64


YOUNG, POISSON, EDGE = 210e9, 0.3, 1e-6
LINE = Passes((8, 256), 5, 4.2, 24, (8, 24), 4)
POINT = Passes((128, 128), 10, 5.5, 12, (20, 20), 3)
CASES: dict[str, Case | Passes] = {
    "indentation": Case("indentation", 64, 32, "periodic", "double", 32, 16, cores=1),
    "swift-256": Case("swift", 256, 64, "free", "single", 24, 10),
    "rough-256-free": Case("rough", 256, None, "free", "single", 32, None),
    "rough-256-periodic": Case("rough", 256, None, "periodic", "single", 32, None),
    "swift-512": Case("swift", 512, 128, "free", "single", 26, 12),
    "line": LINE,
    "line-kept": replace(LINE, kept=True),
    "point": POINT,
    "point-kept": replace(POINT, kept=True),
}


def layers_to(first: float, depth: float, count: int) -> np.ndarray:
    """Return thicknesses that grow by the same factor from layer to layer."""
    from scipy.optimize import brentq

    step = np.arange(count)
    ratio = brentq(lambda r: first * (r**step).sum() - depth, 1e-3, 1e3)
    return first * ratio**step


def arguments(case: Case, *, quick: bool) -> dict[str, Any]:
    """Return the arguments of `solve_elastoplastic`."""
    import roughcontact as rc
    from roughcontact.material.hardening import Linear, Swift
    from roughcontact.surface.random_surfaces import reference_map

    points, layers = (case.tiny, case.few) if quick else (case.points, case.layers)
    increments = 2 if quick else INCREMENTS
    more: dict[str, Any] = {"boundary": case.boundary, "precision": case.precision}
    if case.kind == "indentation":
        grid = f"sphere-{points}"
        nodes, side = indentation.GRIDS[grid][0], indentation.SIDE
        thickness = np.full(nodes, indentation.DEPTH / (nodes - 1))
        thickness[[0, -1]] /= 2
        law = Linear(indentation.YIELD, indentation.HARDENING)
        return more | {
            "surface": rc.Surface(indentation.heights(grid), (side / points, side / points)),
            "material": rc.Material(indentation.YOUNG, indentation.POISSON, hardening=law),
            "loads": indentation.LOADS[: increments if quick else None],
            "layers": thickness,
            # Tamaas' own loop stops at 1e-4.
            "tolerance": 1e-5,
        }
    if case.kind == "rough":
        heights, pixel = reference_map(points)
        return more | {
            "surface": rc.Surface(heights, pixel),
            "material": rc.Material(210e9, 0.3, yield_strength=YIELD),
            "load": ROUGH_LOAD / 10 if quick else ROUGH_LOAD,
            "increments": increments,
        }
    edge = 4 * HERTZ / points
    x = (np.arange(points) - (points - 1) / 2) * edge
    return more | {
        "surface": rc.Surface(-(x[:, None] ** 2 + x**2) / (2 * SPHERE), (edge, edge)),
        "material": rc.Material(210e9, 0.3, hardening=Swift(1240e6, 30, 0.085)),
        "load": SPHERE_LOAD,
        "increments": increments,
        "layers": layers_to(edge / 2, 3 * HERTZ, layers or 1),
    }


def run_roughcontact(case: Case, folder: Path, *, quick: bool) -> dict[str, Any]:
    """Follow the load path with this program."""
    import roughcontact as rc

    options = arguments(case, quick=quick)
    iterations: list[int] = []

    def progress(at: rc.results.Progress) -> None:
        iterations.append(at.step.iteration)

    cpu, began = time.process_time(), time.perf_counter()
    result = rc.solve_elastoplastic(**options, progress=progress, on_failure="return")
    row = {
        "seconds": time.perf_counter() - began,
        "cpu": time.process_time() - cpu,
        "status": result.status,
        "margin": result.bodies[0].margin,
        "layers": result.bodies[0].thickness.size,
        "increments": len(result.increments),
        # With those of increments that were halved or repeated in a larger volume.
        "iterations": len(iterations),
        "residual": result.residual,
        "tolerance": result.tolerance,
        "certificate": result.contact.certificate,
        "yield_excess": result.yield_excess,
        "max_pressure": result.contact.max_pressure,
        "max_plastic_strain": result.max_plastic_strain,
        "contact_fraction": result.contact.contact_fraction,
        "plastic_fraction": float(np.mean(result.bodies[0].accumulated > 0)),
        "warnings": list(result.warnings),
        "version": rc.__version__,
    }
    np.savez(
        folder / "fields.npz",
        pressure=result.contact.pressure,
        strain=result.bodies[0].accumulated if case.kind == "indentation" else 0,
    )
    return row


def run_tamaas(case: Case, folder: Path, *, quick: bool) -> dict[str, Any]:
    """Follow the load path with Tamaas."""
    import indentation_with_tamaas
    import tamaas

    points, nodes = (case.tiny, case.few) if quick else (case.points, case.layers)
    loads = indentation.LOADS[: 2 if quick else None]
    cpu = time.process_time()
    answer = indentation_with_tamaas.solve(f"sphere-{points}", loads)
    np.savez(folder / "fields.npz", pressure=answer.pressure[-1], strain=answer.strain[-1])
    return {
        "seconds": float(answer.seconds.sum()),
        "cpu": time.process_time() - cpu,
        "status": "converged",
        "layers": nodes,
        "increments": len(answer.seconds),
        "residual": float(answer.error.max()),
        "tolerance": indentation_with_tamaas.TOLERANCE,
        "max_pressure": float(answer.pressure[-1].max()),
        "max_plastic_strain": float(answer.strain[-1].max()),
        "version": tamaas.__version__,
    }


def run_passes(case: Passes, folder: Path, *, quick: bool) -> Row:
    """Roll over the flat."""
    import roughcontact as rc
    from roughcontact.surface import nominal_bodies

    if quick:
        case = replace(case, shape=case.tiny, half=case.few, layers=8, passes=2, steps=4)
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
        "size": " × ".join(map(str, (*case.shape, case.layers))),
        "passes": case.passes,
        "steps": case.steps,
        "seconds": time.perf_counter() - began,
        "cpu": time.process_time() - cpu,
        "iterations": result.iterations,
        "disk": sum(f.stat().st_size for f in folder.rglob("*") if f.is_file()) / 1e6,
        "answer": rolled.outcome_text,
        "strain": result.max_plastic_strain,
        "tolerance": result.tolerance,
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else math.nan,
    }


def worker(program: str, name: str, folder: Path, *, quick: bool) -> None:
    """Run one case in this process."""
    case = CASES[name]
    if isinstance(case, Passes):
        row = run_passes(case, folder, quick=quick)
    else:
        if case.cores and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: case.cores])
        run = run_tamaas if program == "tamaas" else run_roughcontact
        row = run(case, folder, quick=quick)
        row |= {"points": case.tiny if quick else case.points, "boundary": case.boundary}
    print(json.dumps(row | {"cores": core_count(), "peak": peak_memory()}))


def measure(program: str, name: str, folder: Path, options: argparse.Namespace) -> Row:
    """Run one case in a separate process."""
    row = {"case": name, "program": program}
    found = try_worker(
        __file__,
        *(program, name, folder, *["--quick"] * options.quick),
        python=options.peer_python if program == "tamaas" else sys.executable,
        limit=options.limit,
        variables={"OMP_NUM_THREADS": "1"} if getattr(CASES[name], "cores", None) else None,
    )
    return row | ({"status": found["failed"]} if "failed" in found else found)


def run_case(name: str, options: argparse.Namespace) -> list[Row]:
    """Run one case with this program, and with Tamaas if it can; print the table."""
    programs = ["roughcontact"]
    if name == "indentation" and is_installed(options.peer_python, "tamaas"):
        programs.append("tamaas")
    rows, fields = [], []
    for program in programs:
        with tempfile.TemporaryDirectory() as folder:
            row = measure(program, name, Path(folder), options)
            if (Path(folder) / "fields.npz").exists():
                with np.load(Path(folder) / "fields.npz") as stored:
                    fields.append((stored["pressure"], stored["strain"]))
        rows.append(row)
    if len(fields) == 2:
        (own, own_strain), (other, other_strain) = fields
        # On one core each: other processes of the machine affect the wall time only.
        rows[1]["ratio"] = rows[1]["cpu"] / rows[0]["cpu"]
        rows[1]["difference"] = float(np.abs(own - other).sum() / other.sum())
        rows[1]["strain_difference"] = float(abs(own_strain.max() / other_strain.max() - 1))
        print(
            f"  tamaas takes {rows[1]['ratio']:.0f} × the CPU time; pressures differ by "
            f"{rows[1]['difference']:.2%}, the largest strain by {rows[1]['strain_difference']:.2%}"
        )
    print(tables(rows)[isinstance(CASES[name], Passes)], flush=True)
    return rows


def tables(rows: list[Row]) -> tuple[str, str]:
    """Return the load paths and the passes as tables in Markdown."""
    paths, passes = [], []
    for row in rows:
        if "seconds" not in row:
            paths.append([row["case"], row["program"], row["status"], *[""] * 5])
            continue
        times = f"{row['seconds']:.3g} s", f"{row['cpu']:.3g} s", f"{row['peak']:.0f} MB"
        if "passes" in row:
            extent = row["size"], f"{row['passes']} × {row['steps']}", str(row["iterations"])
            passes.append([row["case"], *extent, *times, f"{row['disk']:.3g} MB", row["answer"]])
            continue
        seconds, cpu, peak = times
        cpu += f", {row['ratio']:.0f} ×" if "ratio" in row else ""
        ended = "" if row["status"] == "converged" else f" ({row['status']})"
        size = f"{row['points']}² × {row['layers']}{ended}"
        extent = size, str(row.get("iterations", "–"))
        strain = f"{row['max_plastic_strain']:.4f}"
        paths.append([row["case"], row["program"], *extent, seconds, cpu, peak, strain])
    both = "iterations", "time", "CPU", "peak memory"
    return (
        markdown(("case", "program", "points × layers", *both, "largest plastic strain"), paths),
        markdown(("case", "points × layers", "passes × steps", *both, "disk", "outcome"), passes),
    )


def main() -> None:
    """Print a table for every case; the exit status is 1 if one did not converge."""
    parser = make_parser(__doc__)
    names = list(CASES)
    parser.add_argument(
        "--cases", nargs="+", choices=names, default=names, metavar="CASE", help=", ".join(names)
    )
    parser.add_argument("--quick", action="store_true", help="tiny sizes")
    parser.add_argument("--peer-python", default=sys.executable, help="interpreter with Tamaas")
    parser.add_argument("--limit", type=float, default=3600, help="seconds for one case")
    parser.add_argument("--write", action="store_true", help="store the rows, renew the page")
    parser.add_argument("--worker", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        program, name, folder = options.worker
        worker(program, name, Path(folder), quick=options.quick)
        return
    if options.quick and options.write:
        parser.error("--quick measures nothing that should be kept: leave out --write")
    print(machine())
    rows = [row for name in options.cases for row in run_case(name, options)]
    if options.write:
        paths, passes = tables(merge_rows(STORED, rows, CASES))
        write_parts("volume", paths)
        write_parts("rolling", passes)
    if any(row.get("status", "converged") != "converged" for row in rows):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
