"""Plasticity of the volume: time, memory and results of whole load paths.

    python benchmarks/volume.py                             # every case; half an hour and more
    python benchmarks/volume.py --cases swift-256 --write   # one, into docs/evidence/performance.md
    python benchmarks/volume.py --cases indentation --peer-python env/bin/python
    python benchmarks/volume.py --quick                     # every case at a tiny size

Each case runs in a process of its own; memory is the peak of that process, the interpreter and all
imports included. *indentation* is also solved by Tamaas where that is installed (``--peer-python``
names its interpreter), one program after the other, both on one core.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from peers import installed, peak_memory

ROOT = Path(__file__).parents[1]
PEERS = ROOT / "tests" / "data" / "peers"
if str(PEERS) not in sys.path:
    sys.path.append(str(PEERS))

import indentation  # noqa: E402 - found beside its stored answers

RESULTS = Path(__file__).with_name("volume.json")
PAGE = ROOT / "docs" / "evidence" / "performance.md"
START, END = "<!-- volume -->", "<!-- volume end -->"

# A sphere of 105 µm under 0.65 N, Swift hardening; Hertz's radius.
SPHERE, SPHERE_LOAD, HERTZ = 105e-6, 0.65, 6.053e-6
# The rough map R(N), in contact on a tenth of it.
ROUGH_LOAD, YIELD = 2.5, 1e9
INCREMENTS = 10


@dataclass(frozen=True)
class Case:
    """One load path; ``tiny`` and ``few`` are points and layers of the quick one.

    Without a number of layers the program chooses them.
    """

    kind: str
    points: int
    layers: int | None
    boundary: str
    precision: str
    tiny: int
    few: int | None
    cores: int | None = None


CASES = {
    "indentation": Case("indentation", 64, 32, "periodic", "double", 32, 16, cores=1),
    "swift-256": Case("swift", 256, 64, "free", "single", 24, 10),
    "rough-256-free": Case("rough", 256, None, "free", "single", 32, None),
    "rough-256-periodic": Case("rough", 256, None, "periodic", "single", 32, None),
    "swift-512": Case("swift", 512, 128, "free", "single", 26, 12),
}


def layers_to(first: float, depth: float, count: int) -> np.ndarray:
    """Return thicknesses of so many layers, each thicker than the one above by the same factor."""
    from scipy.optimize import brentq

    step = np.arange(count)
    ratio = brentq(lambda r: first * (r**step).sum() - depth, 1e-3, 1e3)
    return first * ratio**step


def arguments(case: Case, *, quick: bool) -> dict[str, Any]:
    """Return what `solve_elastoplastic` is called with."""
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
    told: list[int] = []

    def progress(at: rc.results.Progress) -> None:
        told.append(at.step.iteration)

    cpu, began = time.process_time(), time.perf_counter()
    result = rc.solve_elastoplastic(**options, progress=progress, on_failure="return")
    row = {
        "seconds": time.perf_counter() - began,
        "cpu": time.process_time() - cpu,
        "status": result.status,
        "margin": result.bodies[0].margin,
        "layers": result.bodies[0].thickness.size,
        "increments": len(result.increments),
        # Those of increments halved or begun again in a larger volume are counted too.
        "iterations": len(told),
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


def worker(program: str, name: str, folder: Path, *, quick: bool) -> None:
    """Run one case in this process."""
    case = CASES[name]
    if case.cores and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: case.cores])
    run = run_tamaas if program == "tamaas" else run_roughcontact
    row = run(case, folder, quick=quick)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    row |= {"cores": cores, "peak": peak_memory()}
    (folder / "row.json").write_text(json.dumps(row), encoding="utf-8")


def measure(program: str, name: str, folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Run one case in a process of its own."""
    case, python = CASES[name], options.peer_python if program == "tamaas" else sys.executable
    command = [python, __file__, "--worker", program, name, str(folder)]
    environment = dict(os.environ)
    if case.cores:
        environment["OMP_NUM_THREADS"] = str(case.cores)
    row: dict[str, Any] = {
        "case": name,
        "program": program,
        "points": case.tiny if options.quick else case.points,
        "boundary": case.boundary,
        "precision": case.precision,
    }
    try:
        done = subprocess.run(
            command + ["--quick"] * options.quick,
            timeout=options.limit,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return row | {"status": f"no answer in {options.limit:g} s"}
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        return row | {"status": lines[-1] if lines else f"exit status {done.returncode}"}
    return row | json.loads((folder / "row.json").read_text(encoding="utf-8"))


def run_case(name: str, options: argparse.Namespace) -> list[dict[str, Any]]:
    """Run one case with this program, and with Tamaas if it can; print a line each."""
    programs = ["roughcontact"]
    if CASES[name].kind == "indentation" and installed(options.peer_python, "tamaas"):
        programs.append("tamaas")
    rows, fields = [], []
    for program in programs:
        with tempfile.TemporaryDirectory() as folder:
            row = measure(program, name, Path(folder), options)
            if "seconds" in row:
                with np.load(Path(folder) / "fields.npz") as stored:
                    fields.append((stored["pressure"], stored["strain"]))
        rows.append(row)
        print(line(row), flush=True)
    if len(fields) == 2:
        (own, own_strain), (other, other_strain) = fields
        # On one core each: what else runs on the machine is in the wall time alone.
        rows[1]["ratio"] = rows[1]["cpu"] / rows[0]["cpu"]
        rows[1]["difference"] = float(np.abs(own - other).sum() / other.sum())
        rows[1]["strain_difference"] = float(abs(own_strain.max() / other_strain.max() - 1))
        print(
            f"  tamaas takes {rows[1]['ratio']:.0f} × the CPU time; pressures differ by "
            f"{rows[1]['difference']:.2%}, the largest strain by {rows[1]['strain_difference']:.2%}"
        )
    return rows


def line(row: dict[str, Any]) -> str:
    """Return one row in words."""
    head = f"{row['case']:20s} {row['program']:13s} {row['points']:4d}²"
    if "seconds" not in row:
        return f"{head} {row['status']}"
    return (
        f"{head} × {row['layers']:3d}, {row['increments']:2d} increments: {row['seconds']:8.2f} s, "
        f"{row['cpu']:8.2f} s of CPU on {row['cores']} cores, {row['peak']:6.0f} MB, "
        f"{row.get('iterations', '–')} iterations, residual {row['residual']:.0e}, "
        f"pressure {row['max_pressure']:.4g}, strain {row['max_plastic_strain']:.4g}: "
        f"{'; '.join([row['status'], *row.get('warnings', [])])}"
    )


def table(rows: list[dict[str, Any]]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| case | program | points × layers | iterations | time | CPU | peak memory "
        "| largest plastic strain |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        head = f"| {row['case']} | {row['program']} | {row['points']}²"
        if "seconds" not in row:
            lines.append(f"{head} | {row['status']} | | | | |")
            continue
        cpu = f"{row['cpu']:.3g} s"
        if "ratio" in row:
            cpu += f", {row['ratio']:.0f} ×"
        ended = "" if row["status"] == "converged" else f" ({row['status']})"
        lines.append(
            f"{head} × {row['layers']}{ended} | {row.get('iterations', '–')} "
            f"| {row['seconds']:.3g} s | {cpu} | {row['peak']:.0f} MB "
            f"| {row['max_plastic_strain']:.4f} |"
        )
    return "\n".join(lines)


def keep(rows: list[dict[str, Any]]) -> None:
    """Put rows into volume.json, in place of older ones, and the table into the documentation."""
    old = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else []
    unique = {(row["case"], row["program"]): row for row in [*old, *rows]}
    order = list(CASES)
    kept = sorted(unique.values(), key=lambda row: order.index(row["case"]))
    RESULTS.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.index(START) + len(START), text.index(END)
    PAGE.write_text(f"{text[:before]}\n{table(kept)}\n{text[after:]}", encoding="utf-8")


def main() -> None:
    """Print a line for every case; the exit status is 1 if one did not converge."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = list(CASES)
    parser.add_argument(
        "--cases", nargs="+", choices=names, default=names, metavar="CASE", help=", ".join(names)
    )
    parser.add_argument("--quick", action="store_true", help="tiny sizes, two increments")
    parser.add_argument("--peer-python", default=sys.executable, help="interpreter with Tamaas")
    parser.add_argument("--limit", type=float, default=3600, help="seconds for one path")
    parser.add_argument("--json", type=Path, help="write the rows here")
    parser.add_argument("--write", action="store_true", help=f"keep the rows, renew {PAGE.name}")
    parser.add_argument("--worker", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        program, name, folder = options.worker
        worker(program, name, Path(folder), quick=options.quick)
        return
    if options.quick and options.write:
        parser.error("--quick measures nothing that should be kept: leave out --write")
    print(
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}"
    )
    rows = [row for name in options.cases for row in run_case(name, options)]
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    if options.write:
        keep(rows)
    if any(row["status"] != "converged" for row in rows):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
