"""Run every benchmark once at its smallest size: they must not rot."""

from __future__ import annotations

import inspect
import itertools
import subprocess
import sys
from pathlib import Path

from asv_bench import solve, stress


def main() -> None:
    """Run them and print one line each."""
    suites = inspect.getmembers(solve, inspect.isclass) + inspect.getmembers(
        stress, inspect.isclass
    )
    for name, suite in suites:
        if not hasattr(suite, "params"):
            continue
        # The smallest size with every other parameter: the rest only takes longer.
        for values in itertools.product(suite.params[0][:1], *suite.params[1:]):
            instance = suite()
            instance.setup(*values)
            for method in (
                m for m in dir(instance) if m.startswith(("time_", "peakmem_", "track_"))
            ):
                getattr(instance, method)(*values)
                print(f"{name}.{method}{values}: ran")
    for script, *options in (
        ("peers.py", "--cases", "smoke"),
        ("volume.py", "--quick"),
        ("rolling.py", "--quick"),
        ("memory.py", "--quick"),
        ("record.py", "--quick"),
        ("desk.py", "--quick"),
        ("leak.py", "--points", "128"),
        ("fleet.py", "--quick"),
        ("mpi.py", "--quick"),
        ("latency.py", "--runs", "1", "--points", "48x64", "--only", "info"),
        ("robustness.py", "--problems", "10", "--files", "100", "--kills", "5"),
    ):
        path = Path(__file__).with_name(script)
        subprocess.run([sys.executable, str(path), *options], check=True)


if __name__ == "__main__":
    main()
