"""Many contacts: gain of a second worker, cost of a contact in addition to its solve, and bits.

``python benchmarks/fleet.py [--quick] [--memory] [--json FILE]``. All workers are processes of this
machine, those of Dask reached through a separate scheduler. Times say something on a machine that
does nothing else: the load of the last minute is printed as well.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import psutil

from items import items_of_file, normalize_text
from roughcontact.batch import executors, jobs, plan, project, runner
from roughcontact.batch.executors import Engine
from roughcontact.surface.random_surfaces import reference_map

SOURCE = str(Path(runner.__file__).parents[2])

HEAD = """\
folder = "results"
write = ["nc"]
[defaults]
unit = "um"
size = "0.1 mm"
young = "210 GPa"
poisson = 0.3
yield-strength = "1 GPa"
"""


def write_project(folder: Path, sizes: list[int], loads: int) -> Path:
    """Write a project: one map of each size, under several loads each."""
    folder.mkdir(parents=True)
    text = HEAD
    for size in sizes:
        heights, _ = reference_map(size)
        np.save(folder / f"rough-{size}.npy", heights * 1e6)
        listed = ", ".join(f'"{round(100 + 900 * k / loads, 3)} mN"' for k in range(loads))
        text += f'[[contact]]\nname = "{size}"\nfile = "rough-{size}.npy"\nload = [{listed}]\n'
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return folder / "project.toml"


@contextmanager
def local_engine(workers: int) -> Iterator[Engine]:
    """Give local processes of one thread each, which have imported what they need."""
    with executors.local_processes(workers) as engine:
        # Every one of them: each task takes long enough for the others to be given away.
        calls = [engine.executor.submit(_warm) for _ in range(workers)]
        assert [call.result() for call in calls] == [None] * workers
        yield dataclasses.replace(engine, threads=1)


def _warm() -> None:
    time.sleep(1.0)


@contextmanager
def dask(workers: int, watch: list[psutil.Process] | None = None) -> Iterator[Engine]:
    """Give a Dask cluster: a scheduler and workers, each a separate program."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        scheduler_file = folder / "scheduler.json"
        run = [sys.executable, "-m"]
        about = {"env": {**os.environ, "PYTHONPATH": SOURCE}, "stderr": subprocess.DEVNULL}
        begun = [
            subprocess.Popen(
                [
                    *run,
                    *shlex.split(
                        "distributed.cli.dask_scheduler --host 127.0.0.1 --port 0 --no-dashboard "
                        "--scheduler-file"
                    ),
                    str(scheduler_file),
                ],
                **about,
            )
        ]
        stack.callback(lambda: [process.terminate() for process in reversed(begun)])
        while not scheduler_file.exists() or not scheduler_file.read_text():
            time.sleep(0.05)
        address = json.loads(scheduler_file.read_text())["address"]
        begun += [
            subprocess.Popen(
                [
                    *run,
                    "distributed.cli.dask_worker",
                    address,
                    *shlex.split("--nthreads 1 --no-dashboard --local-directory"),
                    str(folder),
                ],
                **about,
            )
            for _ in range(workers)
        ]
        if watch is not None:
            watch.append(psutil.Process(begun[0].pid))
        with executors.connect_cluster(address, workers) as engine:
            while engine.slots() < workers:
                time.sleep(0.1)
            yield engine


def time_contacts(path: Path, engine: Engine, backwards: bool = False) -> list[float]:
    """Work through a project; return the seconds after which each contact was done."""
    entries = project.read_project(path)
    begun = time.perf_counter()
    at: list[float] = []
    reports = runner.run_project(
        entries[::-1] if backwards else entries,
        lambda _: at.append(time.perf_counter() - begun),
        engine,
    )
    failed = [report.reason for report in reports if report.state == plan.FAILED]
    assert not failed, failed[0]
    return at


def bits(path: Path) -> dict[str, dict[str, str]]:
    """Return the files of a project, without times."""
    folder = (path.parent / "results").resolve()
    return {
        file.name: {
            name: normalize_text(text, folder) for name, text in items_of_file(file).items()
        }
        for file in sorted(folder.iterdir())
    }


def throughput(folder: Path, sizes: list[int], loads: int) -> dict[str, float]:
    """Return contacts per second on one worker and on two, and whether the bits are the same."""
    ways = {
        "one worker": (lambda: local_engine(1), False),
        "two workers": (lambda: local_engine(2), True),
        "Dask, two workers": (lambda: dask(2), False),
    }
    found, left = {}, {}
    for name, (opened, backwards) in ways.items():
        path = write_project(folder / name.replace(" ", "-"), sizes, loads)
        with opened() as engine:
            at = time_contacts(path, engine, backwards)
        found[name] = len(at) / at[-1]
        left[name] = bits(path)
    first = left["one worker"]
    for name, same in left.items():
        assert same == first, f"{name} left other bits"
    found["gain of the second, of twice"] = found["two workers"] / found["one worker"] / 2
    return found


def overhead(folder: Path, contacts: int) -> dict[str, float]:
    """Return the seconds that a contact takes on engines beyond what it takes without one."""
    entries = project.read_project(write_project(folder / "alone", [32], contacts))
    entries[0].summary.parent.mkdir()
    tasks = [jobs.BatchTask((jobs.SubtaskRequest(k, one, ""),), 1) for k, one in enumerate(entries)]
    jobs.run_task(tasks[0])
    begun = time.perf_counter()
    for task in tasks:
        jobs.run_task(task)
    alone = (time.perf_counter() - begun) / contacts
    found = {"alone": alone}
    for name, opened in (("local", lambda: local_engine(1)), ("Dask", lambda: dask(1))):
        path = write_project(folder / name, [32], contacts)
        with opened() as engine:
            at = time_contacts(path, engine)
        # The first contacts make the worker import what it needs.
        skip = contacts // 10
        found[name] = (at[-1] - at[skip]) / (contacts - skip - 1) - alone
    return found


def measure_scheduler(folder: Path, contacts: int) -> dict[str, float]:
    """Return the memory of a scheduler under many tiny contacts, and their pace at the ends."""
    watch: list[psutil.Process] = []
    path = write_project(folder / "many", [32], contacts)
    largest = 0
    with dask(2, watch) as engine:
        entries = project.read_project(path)
        begun, at = time.perf_counter(), []

        def record_memory(report: plan.ContactReport) -> None:
            nonlocal largest
            at.append(time.perf_counter() - begun)
            if len(at) % 10 == 0:
                largest = max(largest, watch[0].memory_info().rss)

        runner.run_project(entries, record_memory, engine)
    part = contacts // 10
    return {
        "scheduler [MB]": largest / 1e6,
        "second tenth [1/s]": part / (at[2 * part - 1] - at[part - 1]),
        "last tenth [1/s]": part / (at[-1] - at[-1 - part]),
    }


def memory(folder: Path, sizes: list[int]) -> dict[str, float]:
    """Return the largest memory [MB] of a worker of one thread: idle, and by the points a side."""
    found = {}
    for name, opened in (("local", lambda: local_engine(1)), ("Dask", lambda: dask(1))):
        for size in sizes:
            path = write_project(folder / f"{name}-{size}", [size], 3)
            with opened() as engine:
                found.setdefault(f"{name} idle", engine.executor.submit(peak).result())
                time_contacts(path, engine)
                found[f"{name} {size}"] = engine.executor.submit(peak).result()
    return found


def peak() -> float:
    """Return the most memory that this process has held [MB]; Linux alone keeps it."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * 1024 / 1e6


def main() -> None:
    """Print what was measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few and small contacts")
    parser.add_argument("--memory", action="store_true", help="the memory of a worker alone")
    parser.add_argument("--json", type=Path, help="write the numbers into a file")
    options = parser.parse_args()
    sizes, loads = ([64, 96], 2) if options.quick else ([256, 384, 512, 768, 1024], 40)
    few, tiny = (4, 20) if options.quick else (200, 10_000)
    held = [64] if options.quick else [512, 1024, 2048]
    found = {}
    with tempfile.TemporaryDirectory(prefix="roughcontact-fleet-") as name:
        folder = Path(name)
        timings = (
            ("throughput [1/s]", lambda: throughput(folder, sizes, loads)),
            (f"overhead of {few} contacts [s]", lambda: overhead(folder, few)),
            (f"{tiny} contacts", lambda: measure_scheduler(folder, tiny)),
        )
        for what, measured in (
            *(() if options.memory else timings),
            ("memory of a worker [MB]", lambda: memory(folder / "memory", held)),
        ):
            found[what] = measured()
            load = psutil.getloadavg()[0]
            text = ", ".join(f"{key} {value:.3g}" for key, value in found[what].items())
            print(f"{what}: {text} (load {load:.1f})", flush=True)
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
