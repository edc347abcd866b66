"""Run every benchmark once at its smallest size: they must not rot."""

from __future__ import annotations

import inspect
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from asv_bench import solve, stress

# Some wait for a browser or for workers; longest first.
SCRIPTS = (
    ("claims.py", "--quick"),
    ("desk.py", "--quick"),
    ("../tests/fuzz/robustness.py", "--problems", "2", "--files", "20", "--kills", "1"),
    ("fleet.py", "--quick"),
    ("rolling.py", "--quick"),
    ("volume.py", "--quick"),
    ("latency.py", "--runs", "1", "--points", "48x64", "--only", "info"),
    ("peers.py", "--cases", "smoke"),
    ("memory.py", "--quick"),
    ("record.py", "--quick"),
    ("partial_slip.py", "256"),
    ("leak.py", "--points", "128"),
)


def main() -> None:
    """Run them and print what they say, two at a time: nothing is measured."""
    for module in (solve, stress):
        for name, suite in inspect.getmembers(module, inspect.isclass):
            if hasattr(suite, "params"):
                methods(name, suite)
    with ThreadPoolExecutor(2) as pool:
        for told in pool.map(quickly, SCRIPTS):
            print(told, flush=True)


def methods(name: str, suite: type) -> None:
    """Run a suite at its smallest size, every value of the other parameters once."""
    choices = [suite.params[0][:1], *suite.params[1:]]
    for number in range(max(map(len, choices))):
        values = [values[number % len(values)] for values in choices]
        instance = suite()
        instance.setup(*values)
        for method in dir(instance):
            if method.startswith(("time_", "peakmem_", "track_")):
                getattr(instance, method)(*values)
                print(f"{name}.{method}{tuple(values)}: ran")


def quickly(command: tuple[str, ...]) -> str:
    """Run a script of this folder, or raise with what it said."""
    script, *options = command
    path = Path(__file__).parent / script
    done = subprocess.run(
        [sys.executable, str(path), *options],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    if done.returncode:
        raise RuntimeError(f"{script} ended with status {done.returncode}:\n{done.stdout}")
    return done.stdout


if __name__ == "__main__":
    main()
