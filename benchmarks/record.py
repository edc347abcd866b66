"""Times and memory of usual tasks and commands, stored with their date.

    python benchmarks/record.py            # compare with the last record; exit status 1 if worse
    python benchmarks/record.py --keep     # store it in record.json
    python benchmarks/record.py --quick    # one small task, once
    python benchmarks/record.py --growth 8192      # growth with the grid, up to 8192 points
    python benchmarks/record.py --growth 16384 --device cuda    # one solve, on a GPU and without
    python benchmarks/record.py --commands [--before FOLDER] [--points 576x768] [--only info]

Every task runs in a separate process, several times, each after padded ``scipy.fft.rfft2`` +
``irfft2`` pairs of 1024 × 1024 points. Times are compared as ratios to T_pair, the median of these
pairs over the whole run, memory as the peak above that of the import. Increases of more than 10 %
above the last record are listed.

`--growth` ends a task if its next grid would take more than `MAX_SECONDS` or the free memory; it
writes growth.json, from which the documentation draws a figure. With `--device` it prints one solve
from 1024² points up on that device and on the processor, in turns, and writes nothing.

`--commands` times whole commands from the shell, with files in the page cache. FOLDER is the
``src`` of another state of the program (`git worktree add`): both run in turns. Each command runs
once before it is timed, to compile modules. Processor time is that of all threads; if it is well
below the wall time, other processes used the machine.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import shutil
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
from measuring import ROOT, machine, make_parser, markdown, pair_time, peak_memory, run_worker

RECORD = Path(__file__).with_name("record.json")
GROWTH = Path(__file__).with_name("growth.json")
SOURCE = ROOT / "src"
MEASURED = ROOT / ".." / "shared" / "measurements" / "wyko_nt1100_test_1.opd"

# Share above the last record that is listed.
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


def _slip_task(points: int) -> Callable[[], object]:
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
    "partial slip, 512²": (_slip_task, 512, {}),
    "leakage, 512²": (_leak, 512, {}),
    "conductance, 512²": (_conductance, 512, {}),
    "ball with plastic volume, 48²": (_ball, 48, {}),
    "rolling, 2 passes of 16 steps, 8 × 128": (_rolling, 128, {}),
}
QUICK = {"contact, ceiling, 128²": (_contact, 128, {})}
# Task, and points per side of its smallest grid; each next one has twice the points.
GROWING: dict[str, tuple[Callable[..., Callable[[], object]], int]] = {
    "solve": (_contact, 256),
    "sweep": (_curve, 256),
    "stress": (_stress, 256),
    "leak": (_leak, 256),
    "volume": (_ball, 32),
}
# Largest time of a task of `--growth` [s].
MAX_SECONDS = 300.0

Timing = tuple[float, float]


def worker(name: str, points: int = 0, device: str = "") -> None:
    """Run a task once, in this process, and print its time and memory."""
    if points:
        make, options = GROWING[name][0], {"device": device} if device else {}
    else:
        make, points, options = {**TASKS, **QUICK}[name]
    # Libraries are loaded and threads started by a small one.
    make(16 if make is _ball else 32, **options)()
    task = make(points, **options)
    before = peak_memory()
    began = time.perf_counter()
    result = task()
    seconds = time.perf_counter() - began
    whole = peak_memory()
    row = {"seconds": seconds, "above": whole - before, "whole": whole}
    if isinstance(result, rc.ContactResult):
        row |= {"convolutions": result.convolutions, "certificate": result.certificate}
    print(json.dumps(row))


def measure_task(name: str, repeats: int, pairs: list[float]) -> dict[str, float]:
    """Return time [s] and memory [MB] of a task, medians; add times of pairs."""
    answers = []
    for _ in range(repeats):
        pairs.append(pair_time(PAIR_POINTS))
        answers.append(run_worker(__file__, name))
    return {
        "seconds": round(statistics.median(answer["seconds"] for answer in answers), 4),
        "above": round(statistics.median(answer["above"] for answer in answers), 1),
    }


def measure_growth(name: str, largest: int) -> dict[int, dict[str, float]]:
    """Return seconds, T_pair of the same grid and bytes a pixel of a task, by points per side."""
    rows: dict[int, dict[str, float]] = {}
    points = GROWING[name][1]
    while points <= largest:
        pair = pair_time(points)
        answer = run_worker(__file__, name, points)
        rows[points] = {
            "seconds": round(answer["seconds"], 4),
            "pairs": round(answer["seconds"] / pair, 2),
            "bytes": round(1e6 * answer["above"] / points**2, 1),
        }
        print(f"{name:8s} {points:5d}² {rows[points]}", flush=True)
        # The number of layers of a volume grows, too.
        times = 10 if name == "volume" else 5
        memory = 1e6 * times * answer["whole"]
        if times * answer["seconds"] > MAX_SECONDS or memory > psutil.virtual_memory().available:
            break
        points *= 2
    return rows


def compare_device(device: str, largest: int) -> None:
    """Print time and memory of the processor for one solve, on a device and on the processor."""
    points = 1024
    while points <= largest:
        for name in (device, "cpu"):
            answer = run_worker(__file__, "solve", points, name)
            print(
                f"{name:5s} {points:5d}² {answer['seconds']:8.3f} s {answer['above']:8.0f} MB "
                f"{answer['convolutions']:3d} convolutions, ε = {answer['certificate']:.1e}",
                flush=True,
            )
        points *= 2


def find_slower(now: dict[str, dict[str, float]], last: dict[str, dict[str, float]]) -> list[str]:
    """Return a line for each row of a record that is more than 10 % above the last record."""
    lines = []
    for name, row in now.items():
        for what, unit in (("pairs", "T_pair"), ("above", "MB")):
            before = last.get(name, {}).get(what)
            # The allocator changes the peak by a few megabytes.
            least = 5.0 if what == "above" else 0.0
            if before and row[what] - before > max(WORSE * before, least):
                lines.append(f"{name}: {row[what]:.3g} {unit}, was {before:.3g}")
    return lines


def store_record(record: dict[str, Any], records: list[dict[str, Any]]) -> None:
    """Store a record, one per version and day."""
    once = ("date", "version")
    records = [old for old in records if any(old[key] != record[key] for key in once)] + [record]
    RECORD.write_text(json.dumps(records, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def commands(map_file: str, folder: Path) -> dict[str, list[str]]:
    """Return the arguments of the commands, by name."""
    solve = ["solve", map_file, "--load", "1 N", "--material", "100Cr6", "--missing", "fill"]
    report = ["--report", str(folder / "report.html")]
    grouped = [
        word
        for name in "ab"
        for word in ("--group", f"{name}={folder}/{name}-*{Path(map_file).suffix}")
    ]
    return {
        "--help": ["--help"],
        "info": ["info", map_file],
        "solve --json": [*solve, "--json"],
        "solve --report": [*solve, *report],
        "sweep": ["sweep", map_file, "--from", "10 MPa", "--to", "300 MPa", *solve[4:]],
        "stress --output": ["stress", *solve[1:], "--output", str(folder / "stress.nc")],
        "leak": ["leak", *solve[1:3], "1 N, 3 N", *solve[4:]],
        "compare": ["compare", *grouped, "--load", "20 MPa", *solve[4:], *report],
    }


def time_command(source: Path, words: list[str]) -> Timing:
    """Return wall and processor time of a command [s]."""
    variables = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    start = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, "-m", "roughcontact", *words],
        env={**variables, "PYTHONPATH": str(source)},
        stdout=subprocess.DEVNULL,
    ) as process:
        _, status, used = os.wait4(process.pid, 0)
        taken = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(words)} ended with status {process.returncode}")
    return taken, used.ru_utime + used.ru_stime


def time_commands(sources: dict[str, Path], words: list[str], runs: int) -> dict[str, Timing]:
    """Return the medians of each state of the program, run in turns."""
    for source in sources.values():
        time_command(source, words)
    taken: dict[str, list[Timing]] = {name: [] for name in sources}
    for _ in range(runs):
        for name, source in sources.items():
            taken[name].append(time_command(source, words))
    return {
        name: (
            statistics.median(wall for wall, _ in found),
            statistics.median(used for _, used in found),
        )
        for name, found in taken.items()
    }


def compare_commands(given: argparse.Namespace, folder: Path) -> None:
    """Print the times of commands on a generated and a measured map, in Markdown."""
    sources = {"now": SOURCE}
    if given.before is not None:
        # A copy, in which modules may be compiled.
        shutil.copytree(given.before, folder / "before")
        sources = {"before": folder / "before", **sources}
    ny, nx = map(int, given.points.split("x"))
    heights = rc.self_affine(
        (ny, nx),
        (1e-6, 1e-6),
        rms_height=0.4e-6,
        rolloff_wavelength=nx * 1e-6 / 8,
        cutoff_wavelength=8e-6,
        rng=np.random.default_rng(1),
    )
    made = folder / f"made-{given.points}.x3p"
    rc.Surface(heights, (1e-6, 1e-6)).save(made)
    head = ["file", "command", *(f"{name}{kind}" for name in sources for kind in ("", ", CPU"))]
    for path in (made, MEASURED) if MEASURED.exists() else (made,):
        for name in ("a-1", "a-2", "a-3", "b-1", "b-2", "b-3"):
            shutil.copy(path, folder / f"{name}{path.suffix}")
        rows = []
        for command, words in commands(str(path), folder).items():
            if given.only in (None, command):
                found = time_commands(sources, words, given.repeats).values()
                rows.append([path.name, command, *(f"{s:.2f} s" for both in found for s in both)])
        print(markdown(head, rows), flush=True)


def main() -> int:
    """Measure, compare, and store on request."""
    parser = make_parser(__doc__)
    parser.add_argument("--keep", action="store_true", help="store the record")
    parser.add_argument("--quick", action="store_true", help="one small task, once")
    parser.add_argument("--repeats", type=int, default=5, help="of each task or command; median")
    parser.add_argument("--growth", type=int, metavar="POINTS", help="largest points per side")
    parser.add_argument("--device", help="of one solve of `--growth`, such as cuda")
    parser.add_argument("--commands", action="store_true", help="time commands")
    parser.add_argument(
        "--before", type=os.path.abspath, help="src of another state of the program"
    )
    parser.add_argument("--points", default="576x768", help="of the map for commands")
    parser.add_argument("--only", help="one of the commands")
    parser.add_argument("--worker", nargs="+", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.worker or given.commands:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            if given.worker:
                name, *rest = given.worker
                worker(name, *map(int, rest[:1]), *rest[1:])
            else:
                compare_commands(given, Path(folder))
            os.chdir(ROOT)
        return 0
    if given.growth and given.device:
        compare_device(given.device, given.growth)
        return 0
    if given.growth:
        found = {name: measure_growth(name, given.growth) for name in GROWING}
        GROWTH.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return 0
    pairs: list[float] = []
    rows = {
        name: measure_task(name, 1 if given.quick else given.repeats, pairs)
        for name in (QUICK if given.quick else TASKS)
    }
    # Single pairs vary by a third on a shared machine, the median of all by a few per cent.
    pair = statistics.median(pairs)
    for name, row in rows.items():
        row["pairs"] = round(row["seconds"] / pair, 2)
        print(
            f"{name:40s} {row['seconds']:8.3f} s {row['pairs']:8.2f} T_pair {row['above']:8.1f} MB"
        )
    records = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else []
    above = find_slower(rows, records[-1]["rows"] if records else {})
    print("".join(f"worse: {line}\n" for line in above), end="")
    if given.keep:
        today = datetime.date.today().isoformat()
        record = {"date": today, "version": rc.__version__, "machine": machine(), "rows": rows}
        store_record(record, records)
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
