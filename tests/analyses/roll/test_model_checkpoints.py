"""Runs over a path of places: little is kept on the way, and they resume to the same bits."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import roughcontact as rc
from paths import ROOT
from roughcontact.errors import FormatError, InputError
from roughcontact.solvers.progress import Progress
from roughcontact.surface import nominal_bodies
from volume_runs import StopError, bits

GRID = dict(shape=(8, 16), pixel=(1e-6, 1e-6))
STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
# A roller that reaches 4.1 k over a half-width of 3 pixels.
HERTZ, WIDTH = 4.1e9 / math.sqrt(3), 3e-6
RADIUS = WIDTH * 210e9 / 0.91 / (2 * HERTZ)
LOAD = math.pi / 2 * WIDTH * HERTZ * 8e-6
ARGUMENTS = dict(
    counter_surface=nominal_bodies.cylinder(radius=RADIUS, angle=90.0, **GRID),
    material=STEEL,
    boundary="periodic",
    layers=[0.8e-6] * 8,
    tolerance=1e-3,
)
FLAT = nominal_bodies.flat(**GRID)
PATH = [
    rc.PathPoint(load, (0.0, x * 1e-6))
    for load, x in ((LOAD, 0), (LOAD, 2), (0.5 * LOAD, 4), (LOAD, 6), (LOAD, 7.5))
]


def solve_path(path: list[rc.PathPoint], **more: object) -> rc.ElastoplasticResult:
    return rc.solve_elastoplastic(FLAT, path=path, **(ARGUMENTS | more))


def stopping_at(number: int):
    def stop(at: Progress) -> None:
        if not at.kept and at.number == number:
            raise StopError

    return stop


@pytest.mark.long
@pytest.mark.parametrize("stop", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_a_stopped_path_ends_with_the_same_bits(stop: int, tmp_path: Path) -> None:
    whole = solve_path(PATH)
    assert whole.max_plastic_strain > 1e-3
    with pytest.raises(StopError):
        solve_path(PATH, folder=tmp_path, progress=stopping_at(stop))
    assert {file.name for file in tmp_path.iterdir()} == {"latest.nc", "volume.json"}
    messages: list[Progress] = []
    assert bits(solve_path(PATH, folder=tmp_path, progress=messages.append)) == bits(whole)
    assert (messages[0].number, messages[0].kept) == (stop - 1, True)
    assert {file.name for file in tmp_path.iterdir()} == {"step-0005.nc", "volume.json"}
    assert bits(rc.read_result(tmp_path / "step-0005.nc")) == bits(whole)
    # Nothing is solved again.
    solve_path(PATH, folder=tmp_path, progress=stopping_at(1))


@pytest.mark.long
def test_path_without_yield_is_saved(tmp_path: Path) -> None:
    light = [replace_load(point, 0.2 * LOAD) for point in PATH[:2]]
    with pytest.raises(StopError):
        solve_path(light, folder=tmp_path, progress=stopping_at(2))
    assert bits(solve_path(light, folder=tmp_path)) == bits(solve_path(light))


def replace_load(point: rc.PathPoint, load: float) -> rc.PathPoint:
    return rc.PathPoint(load, point.offset, point.friction, point.direction)


@pytest.mark.long
def test_other_paths_raise_input_error(tmp_path: Path) -> None:
    with pytest.raises(StopError):
        solve_path(PATH, folder=tmp_path, progress=stopping_at(3))
    other = [PATH[0], rc.PathPoint(LOAD, (0.0, 3e-6)), *PATH[2:]]
    with pytest.raises(InputError, match="holds another run: loads differ"):
        solve_path(other, folder=tmp_path)
    with pytest.raises(InputError, match="another run: tolerance differ"):
        solve_path(PATH, folder=tmp_path, tolerance=1e-2)
    file = tmp_path / "latest.nc"
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    with pytest.raises(FormatError, match=r"remove .* to solve it again"):
        solve_path(PATH, folder=tmp_path)


CHILD = """
import sys
sys.path.insert(0, sys.argv[2])
import test_model_checkpoints
test_model_checkpoints.roll_flat(sys.argv[1])
"""


def roll_flat(folder: str | Path | None = None) -> rc.results.RollingResult:
    return rc.roll(FLAT, load=LOAD, passes=2, steps=8, folder=folder, **ARGUMENTS)


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL on this system")
def test_killed_passes_resume(tmp_path: Path) -> None:
    """Killed on the second pass, the same call ends with the same bits."""
    folder = tmp_path / "run"
    paths = os.pathsep.join(
        [str(ROOT / "src"), str(ROOT / "tests"), os.environ.get("PYTHONPATH", "")]
    )
    arguments = [sys.executable, "-c", CHILD, str(folder), str(Path(__file__).parent)]
    child = subprocess.Popen(arguments, env={**os.environ, "PYTHONPATH": paths})
    try:
        for _ in range(60000):
            if (folder / "pass-0002" / "latest.nc").exists() or child.poll() is not None:
                break
            time.sleep(0.005)
    finally:
        child.send_signal(signal.SIGKILL)
        child.wait()
    assert child.returncode == -signal.SIGKILL
    assert not (folder / "pass-0002" / "step-0008.nc").exists()
    resumed, whole = roll_flat(folder), roll_flat()
    assert bits(resumed.result) == bits(whole.result)
    assert resumed.passes == whole.passes
