"""One contact on several ranks of MPI beside one process: time, work, memory, communication.

    python benchmarks/mpi.py                                # 2048² and 4096² on 1, 2 and 4 ranks
    python benchmarks/mpi.py --points 8192 --ranks 2        # a quarter of an hour
    python benchmarks/mpi.py --volume --ranks 2             # the volume model: 256² × 64
    python benchmarks/mpi.py --write    # renew the table of docs/evidence/scale.md
    python benchmarks/mpi.py --quick                        # 256² on two ranks

The rough map R(N) with a ceiling of 3 GPa is pressed by 1 N, from a file that each rank reads its
rows of. For the volume model it is the sphere of benchmarks/volume.py, of Swift hardening, whose
layers the ranks share. Every run is a process, or ranks, of their own; memory is the peak of each
(VmHWM), the interpreter and all imports included. One process has as many threads as there are
cores, ranks share the cores. Work is the time of all cores together: on a machine that does other
things it tells more than the time on the clock, which the load of the machine stands beside.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
import volume
from peers import peak_memory
from roughcontact._tools.ranks import Ranks

PAGE = Path(__file__).parents[1] / "docs" / "evidence" / "scale.md"
RESULTS = Path(__file__).with_name("mpi.json")
START, END = "<!-- mpi -->", "<!-- mpi end -->"
STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
LOAD = 1.0
VOLUME = "volume"
# Set for the processes of a quick run.
QUICK = "ROUGHCONTACT_BENCHMARK_QUICK"


def made(points: int, folder: Path) -> Path:
    """Return a file with the heights of R(N) [m]; an old one is used again."""
    path = folder / f"rough-{points}.npy"
    if not path.exists():
        np.save(path, rc.reference_map(points)[0])
    return path


def alone(path: Path, precision: str) -> dict[str, Any]:
    """Solve in this process."""
    if path.stem == VOLUME:
        return pressed(None)[0]
    surface = rc.read_surface(path, unit="m", size="0.1 mm")
    began, work = time.perf_counter(), cpu()
    found = rc.solve(surface, material=STEEL, load=LOAD, precision=precision)
    return {
        "seconds": time.perf_counter() - began,
        "work": cpu() - work,
        "memory": peak_memory(),
        "convolutions": found.convolutions,
        "contact_fraction": found.contact_fraction,
    }


def together(path: Path, precision: str) -> dict[str, Any] | None:
    """Solve on the ranks that mpiexec started; the first returns what all found."""
    from mpi4py import MPI

    comm = MPI.COMM_WORLD
    if path.stem == VOLUME:
        return gathered(comm)
    slab = rc.mpi.read_slab(path, comm, unit="m", size="0.1 mm")
    comm.Barrier()
    began, work = time.perf_counter(), cpu()
    found = rc.solve(slab, material=STEEL, load=LOAD, precision=precision)
    seconds = time.perf_counter() - began
    works, peaks = comm.gather(cpu() - work), comm.gather(peak_memory())
    if comm.Get_rank():
        return None
    return {
        "seconds": seconds,
        "work": sum(works),
        "memory": max(peaks),
        "convolutions": found.convolutions,
        "contact_fraction": found.contact_fraction,
        "communication": found.communication / found.seconds,
        "sent": found.sent,
    }


def pressed(communicator: Any) -> tuple[dict[str, Any], Any]:
    """Solve with the volume model, on ranks or without any."""
    options = volume.arguments(volume.CASES["swift-256"], quick=QUICK in os.environ)
    began, work = time.perf_counter(), cpu()
    found = rc.solve_elastoplastic(**options, ranks=communicator)
    row = {
        "seconds": time.perf_counter() - began,
        "work": cpu() - work,
        "memory": peak_memory(),
        "convolutions": found.iterations,
        "contact_fraction": found.solution.contact_fraction,
        "layers": found.bodies[0].thickness.size,
        "max_pressure": found.solution.max_pressure,
    }
    return row, found


def gathered(comm: Any) -> dict[str, Any] | None:
    """Solve with the volume model on all ranks; the first returns what all found."""
    ranks = Ranks(comm)
    comm.Barrier()
    row, _ = pressed(ranks)
    rows = comm.gather({**row, "communication": ranks.seconds, "sent": ranks.sent})
    if comm.Get_rank():
        return None
    shared = sum(one["communication"] for one in rows) / len(rows)
    return {
        **row,
        "work": sum(one["work"] for one in rows),
        "memory": max(one["memory"] for one in rows),
        "communication": shared / row["seconds"],
        "sent": max(one["sent"] for one in rows),
    }


def cpu() -> float:
    """Return the processor time of this process, all threads [s]."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def measured(path: Path, ranks: int, precision: str) -> dict[str, Any]:
    """Return what a run takes, in a process of its own or on ranks; 0 for one process."""
    words = [sys.executable, __file__, "--run", str(path), "--precision", precision]
    mpiexec = Path(sys.executable).with_name("mpiexec")
    starter = [str(mpiexec) if mpiexec.exists() else "mpiexec", "-n", str(ranks)]
    load = os.getloadavg()[0]
    run = subprocess.run(
        [*(starter if ranks else []), *words, *([] if ranks else ["--alone"])],
        capture_output=True,
        text=True,
    )
    if run.returncode:
        raise SystemExit(run.stderr)
    points = volume.CASES["swift-256"].points if path.stem == VOLUME else named(path)
    about = {"points": points, "ranks": ranks, "precision": precision, "load": load}
    return {**about, **json.loads(run.stdout)}


def named(path: Path) -> int:
    """Return the points a side of a map of `made`."""
    return int(path.stem.rpartition("-")[2])


HEAD = (
    "| points | ranks | time | work of all cores | memory of a rank | communication | sent "
    "by a rank |\n|---|---|---|---|---|---|---|"
)


def line(found: dict[str, Any], single: dict[str, Any]) -> str:
    """Return a line of the table; ``single`` is that of one process."""
    ranks = str(found["ranks"]) if found["ranks"] else "one process"
    layers = f" × {found['layers']}" if "layers" in found else ""
    told = [f"{found['points']}²{layers}, {found['precision']}", ranks]
    for key, form in (("seconds", "{:.1f} s"), ("work", "{:.1f} s"), ("memory", "{:.2f} GB")):
        value = found[key] / 1e3 if key == "memory" else found[key]
        ratio = f" ({found[key] / single[key]:.2f})" if found["ranks"] else ""
        told.append(form.format(value) + ratio)
    told += (
        [f"{100 * found['communication']:.0f} %", f"{found['sent'] / 1e9:.2f} GB"]
        if found["ranks"]
        else ["–", "–"]
    )
    return f"| {' | '.join(told)} |"


def table(results: list[dict[str, Any]]) -> str:
    """Return the table of all that was measured."""
    singles = {(r["points"], r["precision"]): r for r in results if not r["ranks"]}
    lines = [line(r, singles[r["points"], r["precision"]]) for r in results]
    return "\n".join([HEAD, *lines])


def main() -> None:
    """Measure, print and, if asked, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, nargs="+", default=[2048, 4096])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--precision", choices=("double", "single"), default="double")
    parser.add_argument("--volume", action="store_true", help="the volume model instead")
    parser.add_argument("--folder", type=Path, help="where maps are kept")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--run", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--alone", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.run is not None:
        found = (alone if given.alone else together)(given.run, given.precision)
        if found is not None:
            print(json.dumps(found))
        return
    sizes, ranks = ([256], [2]) if given.quick else (given.points, given.ranks)
    if given.quick:
        os.environ[QUICK] = "1"
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        paths = [Path(VOLUME)] if given.volume else [made(points, folder) for points in sizes]
        for path in paths:
            for number in [0, *ranks]:
                precision = "single" if given.volume else given.precision
                results.append(measured(path, number, precision))
                print(json.dumps(results[-1]), flush=True)
    if given.write:
        stored = json.loads(RESULTS.read_text("utf-8"))["runs"] if RESULTS.exists() else []
        new = {(r["points"], r["precision"]) for r in results}
        kept = [r for r in stored if (r["points"], r["precision"]) not in new]
        runs = sorted([*kept, *results], key=lambda r: (r["precision"], r["points"], r["ranks"]))
        machine = f"{platform.machine()}, {os.cpu_count()} cores"
        RESULTS.write_text(json.dumps({"machine": machine, "runs": runs}, indent=1) + "\n", "utf-8")
        page = PAGE.read_text("utf-8")
        start, end = page.index(START) + len(START), page.index(END)
        PAGE.write_text(f"{page[:start]}\n\n{table(runs)}\n\n{page[end:]}", "utf-8")
    else:
        print(table(results))


if __name__ == "__main__":
    main()
