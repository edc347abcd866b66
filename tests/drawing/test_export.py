"""Figures that several processes draw."""

from __future__ import annotations

import os
import select
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.cli import app
from roughcontact.drawing import export
from roughcontact.drawing.export import png
from roughcontact.errors import InputError
from roughcontact.halfspace.fft import default_workers

FIRST = os.getpid()
needs_fork = pytest.mark.skipif(
    not hasattr(os, "fork") or sys.platform == "darwin", reason="one process draws alone"
)


def line(height: float) -> Figure:
    figure = Figure(figsize=(2, 1))
    figure.subplots().plot([0, height])
    return figure


def drawings(count: int = 7) -> list[export.Drawing]:
    return [lambda height=number: line(height) for number in range(count)]


@pytest.fixture
def forks(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Processes that were begun."""
    begun: list[int] = []
    fork = os.fork

    def count_fork() -> int:
        helper = fork()
        begun.append(helper)
        return helper

    monkeypatch.setattr(os, "fork", count_fork)
    return begun


def have_all_ended(helpers: list[int]) -> bool:
    for helper in helpers:
        try:
            os.waitpid(helper, os.WNOHANG)
        except ChildProcessError:
            continue
        return False
    return True


@pytest.mark.long
@needs_fork
def test_figures_are_identical_for_any_process_count(forks: list[int]) -> None:
    expected = [png(draw()) for draw in drawings()]
    assert export.draw_pngs(drawings(), 1) == expected
    assert not forks
    assert export.draw_pngs(drawings(), 3) == expected
    assert len(forks) == 2
    assert export.draw_pngs([], 3) == []
    assert have_all_ended(forks)


@pytest.mark.long
@needs_fork
def test_helpers_end_with_the_process_that_began_them() -> None:
    script = """
import os, time
from matplotlib.figure import Figure
from roughcontact.drawing import export

def slow():
    os.write(1, f"{os.getpid()}\\n".encode())
    time.sleep(60)
    return Figure()

export.draw_pngs([slow, slow, slow], 3)
"""
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        drawing = [int(process.stdout.readline()) for _ in range(3)]
        assert process.pid in drawing
        process.kill()
        # Every process held this pipe: its end says that all are gone.
        assert select.select([process.stdout], [], [], 10)[0]
        assert process.stdout.read() == ""


@needs_fork
def test_helpers_draw(tmp_path: Path) -> None:
    def processes() -> set[str]:
        return {path.name.split("-")[1] for path in tmp_path.iterdir()}

    def record_message(number: int) -> Figure:
        (tmp_path / f"{number}-{os.getpid()}").touch()
        # Until another process has come, which it has in a moment.
        last = time.monotonic() + 20
        while time.monotonic() < last and len(processes()) < 2:
            time.sleep(0.01)
        return line(number)

    export.draw_pngs([lambda number=number: record_message(number) for number in range(4)], 2)
    assert sorted(path.name[0] for path in tmp_path.iterdir()) == ["0", "1", "2", "3"]
    assert len(processes()) == 2


@pytest.mark.long
@needs_fork
def test_figure_failed_in_child_is_drawn_in_parent(forks: list[int]) -> None:
    def fails_elsewhere(number: int) -> Figure:
        if os.getpid() != FIRST:
            raise MemoryError
        return line(number)

    given = [lambda number=number: fails_elsewhere(number) for number in range(4)]
    assert export.draw_pngs(given, 2) == [png(draw()) for draw in drawings(4)]
    assert have_all_ended(forks)


@needs_fork
@pytest.mark.parametrize("error", [InputError("nothing to draw"), KeyboardInterrupt()])
def test_an_error_ends_all_of_them(error: BaseException, forks: list[int]) -> None:
    def fails() -> Figure:
        raise error

    with pytest.raises(type(error)):
        export.draw_pngs([fails, *drawings(3), fails], 3)
    assert have_all_ended(forks)


def test_figures_are_drawn_without_fork(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = [png(draw()) for draw in drawings(2)]
    monkeypatch.delattr(os, "fork", raising=False)
    assert export.draw_pngs(drawings(2), 2) == expected


@needs_fork
def test_no_process_is_begun_without_memory_for_a_copy(
    monkeypatch: pytest.MonkeyPatch, forks: list[int]
) -> None:
    monkeypatch.setattr(export.memory, "free_bytes", lambda: 1)
    assert len(export.draw_pngs(drawings(2), 2)) == 2
    assert not forks


def test_commands_share_and_the_library_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def noted(drawings: list[Any], processes: int, tell: object) -> list[bytes]:
        asked.append(processes)
        return [bytes(24)] * len(drawings)

    monkeypatch.setattr(export, "draw_pngs", noted)
    heights, pixel = rc.reference_map(32)
    surface = rc.Surface(heights, pixel)
    surface.save(tmp_path / "map.npz")
    words = [
        str(tmp_path / "map.npz"),
        "--material",
        "100Cr6",
        "--report",
        str(tmp_path / "r.html"),
    ]
    assert app.main(["solve", *words, "--load", "0.01 N", "--quiet"]) == 0
    assert app.main(["history", *words, "--path", "0.01 N, 0 N", "--quiet"]) == 0
    steps = ["--from", "1 mN", "--to", "10 mN", "--steps", "2"]
    assert app.main(["sweep", *words, *steps, "--quiet"]) == 0
    assert asked == [default_workers()] * 3
    rc.solve(surface, material=rc.Material(210e9, 0.3), load=0.01).report(tmp_path / "own.html")
    assert asked[3:] == [1]
