"""Helpers of the benchmarks: memory, time of a pair of transforms, child processes, tables."""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import platform
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft

ROOT = Path(__file__).parents[1]
EVIDENCE = ROOT / "docs" / "evidence"
PERFORMANCE = EVIDENCE / "performance.md"
# NumPy alone: problems that other programs solved, and independent checks of results.
for _folder in ("tests", "tests/data/peers"):
    if str(ROOT / _folder) not in sys.path:
        sys.path.append(str(ROOT / _folder))

Row = dict[str, Any]


def make_parser(description: str | None) -> argparse.ArgumentParser:
    """Return a parser whose help is the docstring of a script."""
    return argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def peak_memory() -> float:
    """Return the largest resident memory of this process so far [MB = 10⁶ bytes]."""
    return proc_status("VmHWM") / 1e6


def proc_status(name: str) -> float:
    """Return a size that Linux reports for this process [bytes]."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(name):
            return 1024 * int(line.split()[1])
    return math.nan


def core_count() -> int:
    """Return the number of cores of this process."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return cores or 1


def pair_time(points: int) -> float:
    """Return the median time [s] of a padded rfft2 + irfft2 pair on all cores: T_pair."""
    padded = np.zeros((2 * points, 2 * points))
    padded[:points, :points] = np.random.default_rng(0).random((points, points))
    times = []
    for _ in range(3 if points > 4096 else 7):
        began = time.perf_counter()
        spectrum = scipy.fft.rfft2(padded, workers=core_count())
        scipy.fft.irfft2(spectrum, padded.shape, workers=core_count())
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def is_installed(python: str, module: str) -> bool:
    """Return whether an interpreter can find a module."""
    if python == sys.executable:
        return importlib.util.find_spec(module) is not None
    probe = f"import importlib.util as u; raise SystemExit(u.find_spec({module!r}) is None)"
    return subprocess.run([python, "-c", probe], check=False).returncode == 0


def machine() -> str:
    """Return the processor and the versions of Python and NumPy."""
    processor = platform.processor() or platform.machine()
    return f"{processor}, Python {platform.python_version()}, NumPy {np.__version__}"


def run_worker(script: str, *words: object) -> Row:
    """Return the row of ``script --worker WORDS`` in a separate process, or raise its error."""
    row = try_worker(script, *words)
    if "failed" in row:
        raise SystemExit(f"{script} {' '.join(map(str, words))}: {row['failed']}")
    return row


def try_worker(
    script: str,
    *words: object,
    python: str = sys.executable,
    limit: float | None = None,
    variables: dict[str, str] | None = None,
) -> Row:
    """Run ``script --worker WORDS`` in a separate process.

    Returns
    -------
    dict
        Its last line, parsed as JSON; an entry ``failed`` if it raised or exceeded the limit [s].
    """
    try:
        done = subprocess.run(
            [python, script, "--worker", *map(str, words)],
            timeout=limit,
            env={**os.environ, **(variables or {})},
            capture_output=True,
            text=True,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"no answer in {limit:g} s"}
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        return {"failed": lines[-1] if lines else f"exit status {done.returncode}"}
    return json.loads(done.stdout.splitlines()[-1])


def markdown(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    head = list(head)
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    lines += [f"| {' | '.join(cells)} |".replace("  ", " ") for cells in rows]
    return "\n".join(lines)


def read_part(mark: str, page: Path = PERFORMANCE) -> str:
    """Return the first part of a page between ``<!-- mark -->`` and ``<!-- mark end -->``."""
    return (
        page.read_text(encoding="utf-8").partition(f"<!-- {mark} -->\n")[2].partition("\n<!--")[0]
    )


def write_parts(mark: str, *parts: str, page: Path = PERFORMANCE) -> None:
    """Replace the parts of a page between ``<!-- mark -->`` and ``<!-- mark end -->``, in order."""
    expression = re.compile(f"(?<=<!-- {mark} -->\n).*?(?=\n<!-- {mark} end -->)", re.DOTALL)
    texts = iter(parts)
    text = expression.sub(lambda _: next(texts), page.read_text(encoding="utf-8"))
    page.write_text(text, encoding="utf-8")


def read_rows(path: Path) -> list[Row]:
    """Return stored rows."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else []


def merge_rows(path: Path, rows: Iterable[Row], order: Iterable[str]) -> list[Row]:
    """Store rows instead of older ones of the same case and program; return all, ordered."""
    unique = {(row["case"], row.get("program")): row for row in [*read_rows(path), *rows]}
    positions = list(order)
    kept = sorted(unique.values(), key=lambda row: positions.index(row["case"]))
    path.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return kept
