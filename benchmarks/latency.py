"""How long a whole command takes, from the shell and back to it, with files in the disk's memory.

python benchmarks/latency.py [--before FOLDER] [--runs 5] [--points 576x768] [--only=info]

FOLDER is the ``src`` of another state of the program, such as ``git worktree add`` makes: both
are run in turns, so that a busy machine is as busy for one as for the other. Each command is run
once before it is timed, which compiles modules and fills the disk's memory. Processor time is that
of all threads; where it is well below the other, the machine had other work to do.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"
MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"
MEASURED = "wyko_nt1100_test_1.opd"
# Of a map that is made here if there is no measurement: what an instrument would give.
MAKE = """
import sys
import numpy as np
import roughcontact as rc
name, ny, nx = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
heights = rc.self_affine(
    (ny, nx), (1e-6, 1e-6), rms_height=0.4e-6, rolloff_wavelength=nx * 1e-6 / 8,
    cutoff_wavelength=8e-6, rng=np.random.default_rng(1),
)
rc.Surface(heights, (1e-6, 1e-6)).save(name)
"""

Timing = tuple[float, float]


def commands(map_file: str, folder: Path) -> dict[str, list[str]]:
    """Return what is timed, by name."""
    solve = ["solve", map_file, "--load", "1 N", "--material", "100Cr6", "--missing", "fill"]
    report = ["--report", str(folder / "report.html")]
    # Six maps, as far as the program knows.
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


def once(source: Path, words: list[str]) -> Timing:
    """Return the seconds that a command takes, and those of the processors."""
    about = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    start = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, "-m", "roughcontact", *words],
        env={**about, "PYTHONPATH": str(source)},
        stdout=subprocess.DEVNULL,
    ) as process:
        _, status, used = os.wait4(process.pid, 0)
        taken = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(words)} ended with status {process.returncode}")
    return taken, used.ru_utime + used.ru_stime


def timed(sources: dict[str, Path], words: list[str], runs: int) -> dict[str, Timing]:
    """Return the medians of each state of the program, run in turns."""
    for source in sources.values():
        once(source, words)
    taken: dict[str, list[Timing]] = {name: [] for name in sources}
    for _ in range(runs):
        for name, source in sources.items():
            taken[name].append(once(source, words))
    return {
        name: (
            statistics.median(wall for wall, _ in found),
            statistics.median(used for _, used in found),
        )
        for name, found in taken.items()
    }


def made(folder: Path, shape: str) -> Path:
    """Return a map of that many points, in an instrument's format."""
    path = folder / f"made-{shape}.x3p"
    about = {**os.environ, "PYTHONPATH": str(SOURCE)}
    subprocess.run(
        [sys.executable, "-c", MAKE, str(path), *shape.split("x")], env=about, check=True
    )
    return path


def main() -> None:
    """Print a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", type=Path, help="src of another state of the program")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--points", default="576x768", help="of the map that is made")
    parser.add_argument("--only", help="one of the commands")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sources = {"now": SOURCE}
        if given.before is not None:
            # A copy, in which modules may be compiled.
            shutil.copytree(given.before, folder / "before")
            sources = {"before": folder / "before", **sources}
        maps = [made(folder, given.points)]
        if (MEASUREMENTS / MEASURED).exists():
            maps.append(MEASUREMENTS / MEASURED)
        titles = " | ".join(f"{name} | processor" for name in sources)
        print(f"| file | command | {titles} |")
        print(f"|---|---|{'---|' * 2 * len(sources)}")
        for path in maps:
            for name in ("a-1", "a-2", "a-3", "b-1", "b-2", "b-3"):
                shutil.copy(path, folder / f"{name}{path.suffix}")
            for command, words in commands(str(path), folder).items():
                if given.only in (None, command):
                    found = timed(sources, words, given.runs)
                    cells = " | ".join(f"{a:.2f} s | {b:.2f} s" for a, b in found.values())
                    print(f"| {path.name} | {command} | {cells} |", flush=True)


if __name__ == "__main__":
    main()
