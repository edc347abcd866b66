"""Run every benchmark once at its smallest size, two at a time: nothing is measured."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Some wait for a browser or for workers; longest first.
COMMANDS = (
    "desk.py --quick",
    "../tests/fuzz/robustness.py --problems 2 --files 20 --kills 1",
    "fleet.py --quick",
    "plasticity.py --quick",
    "record.py --commands --repeats 1 --points 48x64 --only info",
    "peers.py --cases smoke",
    "memory.py --quick",
    "record.py --quick",
    "joint.py slip --points 256",
    "joint.py leak --points 128",
)


def run(command: str) -> str:
    """Return the output of a script of this folder, or raise its error."""
    script, *options = command.split()
    done = subprocess.run(
        [sys.executable, str(Path(__file__).parent / script), *options],
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    if done.returncode:
        raise RuntimeError(f"{script} ended with status {done.returncode}:\n{done.stdout}")
    return done.stdout


if __name__ == "__main__":
    with ThreadPoolExecutor(2) as pool:
        for output in pool.map(run, COMMANDS):
            print(output, flush=True)
