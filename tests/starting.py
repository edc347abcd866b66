"""Starts programs on several ranks of MPI, and says what a refusal on them looks like."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

MPIEXEC = Path(sys.executable).with_name("mpiexec")
MPIEXEC = MPIEXEC if MPIEXEC.exists() else shutil.which("mpiexec")
SOURCE = Path(__file__).parents[1] / "src"


def mpiexec(count, *words, timeout=300):
    """Run a command of Python on so many ranks."""
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    if MPIEXEC is None:
        pytest.skip("there is no mpiexec")
    paths = [str(SOURCE), os.environ.get("PYTHONPATH", "")]
    return subprocess.run(
        [MPIEXEC, "-n", str(count), sys.executable, *map(str, words)],
        capture_output=True,
        text=True,
        timeout=timeout,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
    )


def command(count, *words):
    return mpiexec(count, "-m", "roughcontact", *words)


def assert_rejected(run, sentence):
    assert run.returncode == 2
    lines = [line for line in run.stderr.splitlines() if line.startswith("roughcontact:")]
    assert len(lines) == 1, run.stderr
    assert sentence in lines[0]
    assert "Traceback" not in run.stderr
