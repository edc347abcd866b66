"""Projects on a Dask cluster of real processes: the same bits, and what fails alone."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import dask
import psutil
import pytest

import roughcontact as rc
from fleets import ABSENT, LARGE_CONTACT, ended, items, wait_for, write_large, write_project
from roughcontact.batch.executors import connect_cluster
from roughcontact.cli import app

pytest.importorskip("distributed", reason="Dask is absent")

Capture = pytest.CaptureFixture[str]
Start = Callable[..., "subprocess.Popen[str]"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(rc.__file__).parents[1])}


@dataclass
class Cluster:
    """A scheduler and workers that do not use the folder of the tests."""

    start: Start
    folder: Path
    address: str = ""
    scheduler: subprocess.Popen[str] | None = None
    workers: list[subprocess.Popen[str]] = field(default_factory=list)

    def begin(self) -> None:
        """Start a scheduler, where there was one under its address."""
        result = self.folder / f"scheduler-{os.urandom(4).hex()}.json"
        port = self.address.rpartition(":")[2] or "0"
        self.scheduler = self.start(
            "-m",
            "distributed.cli.dask_scheduler",
            "--host",
            "127.0.0.1",
            "--port",
            port,
            "--no-dashboard",
            "--scheduler-file",
            result,
            cwd="/",
            env={**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"},
        )
        assert wait_for(lambda: result.exists() and result.read_text())
        self.address = json.loads(result.read_text())["address"]

    def add(self, *words: str) -> None:
        """Start a worker of one thread."""
        self.workers.append(
            self.start(
                "-m",
                "distributed.cli.dask_worker",
                self.address,
                "--nthreads",
                "1",
                "--no-dashboard",
                "--local-directory",
                self.folder,
                *words,
                cwd="/",
                env=ENVIRONMENT,
            )
        )

    def run(self, project: Path, *words: str, **more: object) -> subprocess.Popen[str]:
        """Start to work through a project."""
        given = ("run", project.name, "--engine", "dask", "--scheduler", self.address, *words)
        return self.start(
            "-c",
            "import sys; from roughcontact.batch import executors, runner; "
            "executors._CONNECT_TIMEOUT = 8; runner._WORKER_LOSS_SECONDS = 0.5; "
            "from roughcontact.cli import app; sys.exit(app.main(sys.argv[1:]))",
            *given,
            cwd=project.parent,
            env=ENVIRONMENT,
            **more,
        )


@pytest.fixture
def cluster(start: Start, tmp_path: Path) -> Cluster:
    (tmp_path / "scratch").mkdir()
    found = Cluster(start, tmp_path / "scratch")
    found.begin()
    return found


def count_solved(project: Path) -> int:
    return len(list((project.parent / "results").glob("*.json")))


def hidden_files(folder: Path) -> list[str]:
    return [file.name for file in folder.rglob(".*")]


@pytest.mark.process
def test_cluster_matches_local_processes_and_only_bad_file_fails(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    cluster.add()
    far = write_project(tmp_path / "far", 5, ABSENT)
    run = cluster.run(far, "--quiet")
    err = run.communicate(timeout=300)[1]
    assert run.returncode == app.NOT_CONVERGED
    assert err.count("\n") == 1
    assert "error: bad: " in err
    assert "absent.npy does not exist" in err
    near = write_project(tmp_path / "near", 5, ABSENT)
    monkeypatch.chdir(near.parent)
    assert app.main(["run", near.name, "--quiet", "--workers", "1"]) == app.NOT_CONVERGED
    capsys.readouterr()
    result, same = items(near.parent), items(far.parent)
    assert result.keys() == same.keys()
    assert [name for name in result if result[name] != same[name]] == []
    assert hidden_files(far.parent) == []
    # Solved contacts are not solved again by another engine.
    stamps = {file: file.stat().st_mtime_ns for file in (far.parent / "results").iterdir()}
    monkeypatch.chdir(far.parent)
    assert app.main(["run", far.name, "--quiet"]) == app.NOT_CONVERGED
    assert stamps == {file: file.stat().st_mtime_ns for file in stamps}


@pytest.mark.slow
@pytest.mark.process
def test_workers_that_are_killed_lose_nothing(cluster: Cluster, tmp_path: Path) -> None:
    cluster.add()
    cluster.add()
    path = write_project(tmp_path / "far", 12)
    run = cluster.run(path, "--quiet")
    assert wait_for(lambda: count_solved(path) >= 3)
    # The nanny of the first begins another.
    for worker in psutil.Process(cluster.workers[0].pid).children(recursive=True):
        worker.kill()
    # The second is gone with its nanny.
    for worker in psutil.Process(cluster.workers[1].pid).children(recursive=True):
        worker.kill()
    cluster.workers[1].kill()
    err = run.communicate(timeout=300)[1]
    assert (run.returncode, err) == (app.SOLVED, "")
    assert count_solved(path) == 13
    assert hidden_files(path.parent) == []


@pytest.mark.slow
@pytest.mark.process
def test_lost_scheduler_fails_and_restarted_one_resumes(cluster: Cluster, tmp_path: Path) -> None:
    cluster.add()
    path = write_project(tmp_path / "far", 16)
    run = cluster.run(path, "--quiet")
    assert wait_for(lambda: count_solved(path) >= 2)
    assert cluster.scheduler is not None
    cluster.scheduler.kill()
    cluster.scheduler.wait()
    cluster.begin()
    cluster.add()
    before = count_solved(path)
    assert wait_for(lambda: count_solved(path) >= before + 3)
    cluster.scheduler.kill()
    err = run.communicate(timeout=300)[1]
    assert run.returncode == app.NOT_CONVERGED
    assert err.count("\n") == 1
    assert f"the scheduler at {cluster.address} does not answer any longer" in err
    left = count_solved(path)
    assert before + 3 <= left < 17
    # The same command does the rest, on any engine.
    assert app.main(["run", str(path), "--quiet", "--workers", "1"]) == app.SOLVED
    assert count_solved(path) == 17


@pytest.mark.slow
@pytest.mark.process
def test_run_waits_for_workers_and_survives_one_without_memory(
    cluster: Cluster, tmp_path: Path, capsys: Capture
) -> None:
    path = write_project(tmp_path / "far", 3, LARGE_CONTACT)
    # The first, so that others wait behind it on the same worker, which ends with all of them.
    head, _, _ = path.read_text(encoding="utf-8").partition(LARGE_CONTACT)
    first = head.index("[[contact]]")
    path.write_text(head[:first] + LARGE_CONTACT.lstrip() + head[first:], encoding="utf-8")
    # Its solve needs some 500 MB: with 300 MB the worker may stop taking tasks, but live on.
    write_large(path.parent, 2048)
    run = cluster.run(path, "--json", stdout=subprocess.PIPE)
    assert run.stderr is not None
    line = run.stderr.readline()
    assert line == (
        f"roughcontact: waiting for workers of the scheduler at {cluster.address} (dask worker "
        f"{cluster.address}), 10 min at most\n"
    )
    cluster.add("--memory-limit", "320MB")
    out, err = run.communicate(timeout=300)
    assert run.returncode == app.NOT_CONVERGED
    # The restart of workers may be reported as well.
    asides = "waiting for workers", "progress: "
    (error,) = (line for line in err.splitlines() if not any(word in line for word in asides))
    assert "error: large: its worker ended 1 time, the last one at tcp://" in error
    assert "is there enough memory?" in error
    states = {one["name"]: one["state"] for one in json.loads(out)["contacts"]}
    assert states.pop("large") == "failed"
    assert set(states.values()) == {"solved"}
    assert hidden_files(path.parent) == []
    assert app.main(["run", str(path), "--json", "--workers", "1"]) == app.SOLVED
    states = {one["name"]: one["state"] for one in json.loads(capsys.readouterr().out)["contacts"]}
    assert states.pop("large") == "solved"
    assert set(states.values()) == {"solved before"}


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL on this system")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_cluster_of_this_machine_ends_with_the_run(
    number: int, start: Start, tmp_path: Path
) -> None:
    path = write_project(tmp_path, 200)
    run = start(
        "-c",
        "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from roughcontact.cli import app; sys.exit(app.main(sys.argv[1:]))",
        "run",
        path,
        "--engine",
        "dask",
        "--workers",
        "1",
        cwd=tmp_path,
        env=ENVIRONMENT,
    )
    assert wait_for(lambda: count_solved(path) >= 2)
    children = [child.pid for child in psutil.Process(run.pid).children(recursive=True)]
    assert children
    run.send_signal(number)
    assert wait_for(lambda: run.poll() is not None, 15)
    assert wait_for(lambda: all(map(ended, children)), 5)
    if number == signal.SIGINT:
        err = run.communicate()[1]
        assert run.returncode == 128 + number
        assert "of 201 contacts saved in" in err.splitlines()[-1]
        assert hidden_files(tmp_path) == []
    assert 2 <= count_solved(path) < 201


@pytest.mark.process
@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no SIGSTOP on this system")
def test_processes_of_a_cluster_have_ended_when_it_is_stopped(
    caplog: pytest.LogCaptureFixture,
) -> None:
    # The file of a process that is still ending could not be removed.
    with connect_cluster(None, 1) as engine:
        process = psutil.Process(engine.executor.submit(os.getpid).result())
        process.suspend()
        assert wait_for(lambda: process.status() == psutil.STATUS_STOPPED)
        threading.Timer(0.5, process.resume).start()
        engine.shut_down()
        assert ended(process.pid)
    assert "was killed by signal" in caplog.text
    assert "Restarting worker" not in caplog.text


@pytest.mark.process
def test_local_cluster_accepts_run_only() -> None:
    from distributed import Security
    from distributed.comm import connect

    with connect_cluster(None, 1) as engine:
        assert engine.executor.submit(os.getpid).result() != os.getpid()
        result = engine.executor._client.scheduler_info()
        nannies = [worker["nanny"] for worker in result["workers"].values()]
        addresses = [result["address"], *result["workers"], *nannies]
        assert len(addresses) == 3
        assert all(address.startswith("tls://127.0.0.1:") for address in addresses)
        # As another account of the machine would, who sees the port.
        plain = result["address"].replace("tls", "tcp")
        foreign = Security.temporary().get_connection_args("client")
        for address, key in ((plain, {}), (result["address"], {}), (result["address"], foreign)):
            with pytest.raises((OSError, TypeError)):
                asyncio.run(connect(address, timeout=1, **key))


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            ("--scheduler", "tcp://127.0.0.1:1"),
            "--scheduler is the address of a cluster with its workers: it needs --engine dask",
        ),
        (
            ("--engine", "dask", "--scheduler", "tcp://127.0.0.1:1", "--workers", "2"),
            "and cannot be combined with --workers",
        ),
        (("--engine", "dask", "--scheduler", "tcp://127.0.0.1:1"), "does not answer at"),
        (("--engine", "dask", "--scheduler", "nowhere"), "--scheduler"),
        (("--engine", "dask", "--scheduler", "tls://127.0.0.1:1"), "does not answer at"),
        (("--engine", "dask", "--scheduler", "ucx://127.0.0.1:1"), "--scheduler does not"),
        (("--workers", "0"), "--workers must be a whole number from 1"),
        (("--engine", "slurm"), "--engine must be one of local, dask"),
    ],
)
def test_invalid_cluster_options_are_rejected(
    words: tuple[str, ...],
    expected: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
) -> None:
    monkeypatch.setattr("roughcontact.batch.executors._CONNECT_TIMEOUT", 1)
    path = write_project(tmp_path, 1)
    assert app.main(["run", str(path), *words]) == app.BAD_INPUT
    # A client that failed to connect is not the default: xarray would ask it for locks.
    assert dask.base.get_scheduler() is None
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert expected in err


def test_project_is_not_run_by_each_process_of_mpiexec(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    path = write_project(tmp_path, 1)
    monkeypatch.setenv("PMI_SIZE", "2")
    for command in (["run", str(path)], ["solve", "nowhere.npy", "--load", "1 N"]):
        assert app.main(command) == app.BAD_INPUT
        assert "mpiexec started several processes" in capsys.readouterr().err
    assert count_solved(path) == 0


@pytest.mark.parametrize("module", ["distributed", "cryptography"])
def test_a_missing_library_is_named(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    path = write_project(tmp_path, 1)
    assert app.main(["run", str(path), "--engine", "dask"]) == app.BAD_INPUT
    err = capsys.readouterr().err
    assert "run pip install 'roughcontact[cluster]'" in err
    assert err.count("\n") == 1
