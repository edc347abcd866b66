"""Projects on processes that MPI has started."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import roughcontact as rc
from fleets import ABSENT, items, write_project
from roughcontact.cli import app

MPIEXEC = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")


@pytest.mark.process
@pytest.mark.mpi
@pytest.mark.skipif(MPIEXEC is None, reason="mpiexec is absent")
def test_ranks_give_the_bits_of_local_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mpi4py", reason="mpi4py is absent")
    far = write_project(tmp_path / "far", 3, ABSENT)
    source = str(Path(rc.__file__).parents[1])
    monkeypatch.setenv("PYTHONPATH", source)
    done = subprocess.run(
        [str(MPIEXEC), "-n", "3", sys.executable, "-m", "roughcontact", "run", far.name,
         "--engine", "mpi", "--quiet"],
        cwd=far.parent, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == app.NOT_CONVERGED
    assert done.stderr.count("roughcontact: error: bad: ") == 1
    near = write_project(tmp_path / "near", 3, ABSENT)
    monkeypatch.chdir(near.parent)
    assert app.main(["run", near.name, "--quiet", "--workers", "1"]) == app.NOT_CONVERGED
    told, same = items(near.parent), items(far.parent)
    assert told.keys() == same.keys()
    assert [name for name in told if told[name] != same[name]] == []
    # A project that cannot be read is told of once, and nobody waits.
    far.write_text("contact = 3", encoding="utf-8")
    done = subprocess.run(
        [str(MPIEXEC), "-n", "2", sys.executable, "-m", "roughcontact", "run", far.name,
         "--engine", "mpi"],
        cwd=far.parent, capture_output=True, text=True, timeout=180, check=False,
    )  # fmt: skip
    assert done.returncode == app.BAD_INPUT
    assert done.stderr.count("no [[contact]]") == 1


@pytest.mark.mpi
@pytest.mark.skipif(MPIEXEC is None, reason="mpiexec is absent")
def test_one_process_alone_is_told_how_to_start(tmp_path: Path) -> None:
    pytest.importorskip("mpi4py", reason="mpi4py is absent")
    path = write_project(tmp_path, 1)
    done = subprocess.run(
        [sys.executable, "-m", "roughcontact", "run", str(path), "--engine", "mpi"],
        capture_output=True, text=True, timeout=180, check=False,
    )  # fmt: skip
    assert done.returncode == app.BAD_INPUT
    assert "mpiexec -n 3 roughcontact run" in done.stderr
    assert done.stderr.count("\n") == 1
