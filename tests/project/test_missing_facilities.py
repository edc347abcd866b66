"""Facilities that other systems lack are not needed: each is removed, and the tasks still run."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import roughcontact as rc
from layers import all_nodes, module_paths, tree_of

SOURCE = Path(rc.__file__).parents[1]
ROOT = SOURCE.parent
# Names that Windows keeps for devices, and characters that its paths do not have.
RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?|.*[<>:\"|?*\\].*|.*[. ]")

# Missing facilities: on macOS, on Windows. No child begins with these gone, so that nothing but
# this program meets them.
MACOS = """
del os.sched_getaffinity
# As Python 3.13 has it where there is no affinity.
os.process_cpu_count = os.cpu_count
"""
WINDOWS = """
import signal
os.process_cpu_count = os.cpu_count
for name in ("fork", "sched_getaffinity", "O_NONBLOCK", "getuid", "geteuid", "killpg", "setsid"):
    if hasattr(os, name):
        delattr(os, name)
for name in ("SIGHUP", "SIGKILL", "SIGALRM", "SIGUSR1", "pthread_sigmask", "setitimer"):
    if hasattr(signal, name):
        delattr(signal, name)
for name in ("fcntl", "resource", "pwd", "grp", "termios"):
    sys.modules[name] = None
class Locks:
    LK_NBLCK, LK_UNLCK, held = 1, 0, []
    def locking(self, number, mode, count):
        self.held.append((mode, count))
sys.modules["msvcrt"] = Locks()
sys.platform = "win32"
"""

WORK = """
import roughcontact as rc
from roughcontact.report import page
from roughcontact.report.presentation import presentation_of
heights, pixel = rc.reference_map(32)
surface = rc.Surface(heights, pixel)
steel = rc.Material(210e9, 0.3, 1e9)
result = rc.solve(surface, load=1.0, material=steel)
for name in ("out.nc", "out.vti", "out.csv", "out.json"):
    result.save(name)
assert rc.read_result("out.nc").load == result.load
presentation_of(result).report("out.html", page.Edition(processes=2))
surface.save("map.npz")
assert rc.read_surface("map.npz").shape == (32, 32)
curve = rc.sweep(surface, loads=[0.1, 1.0], material=steel, folder="sweep")
curve.save("curve.csv")
print("done")
"""


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize("gone", [MACOS, WINDOWS], ids=["macos", "windows"])
@pytest.mark.skipif(sys.platform == "win32", reason="nothing to remove here")
def test_analysis_runs_without_missing_facilities(gone: str, tmp_path: Path) -> None:
    # The first imports are other packages, which depend on the system.
    first = "import sys, os, tempfile, subprocess, asyncio, numpy, scipy.sparse, matplotlib.figure"
    code = f"{first}\nimport h5py, xarray, psutil, multiprocessing.connection\n{gone}\n{WORK}"
    run = subprocess.run(
        [sys.executable, "-W", "error::DeprecationWarning", "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": str(SOURCE)},
    )
    assert (run.returncode, run.stdout.strip()) == (0, "done"), run.stderr[-2000:]
    written = [path.relative_to(tmp_path) for path in tmp_path.rglob("*")]
    assert len(written) > 8
    assert not [path for path in written if any(map(RESERVED.fullmatch, path.parts))]


def test_no_file_of_the_tree_has_a_name_that_windows_lacks() -> None:
    paths = [
        path.relative_to(ROOT)
        for folder in ("src", "tests", "docs", "benchmarks", "calibration", "scripts")
        for path in (ROOT / folder).rglob("*")
    ]
    assert not [path for path in paths if any(map(RESERVED.fullmatch, path.parts))]
    # Two names that differ in their letters' case alone are one there.
    folded = [path.as_posix().casefold() for path in paths]
    assert len(folded) == len(set(folded))


def test_processes_are_begun_in_the_way_that_every_system_has() -> None:
    for module in module_paths():
        for node in all_nodes(tree_of(module)):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "get_context":
                assert ast.unparse(node.args[0]) == "'spawn'", module
            # Only where the system has it, see `can_fork`.
            if isinstance(node, ast.Attribute) and node.attr == "fork":
                assert (module, ast.unparse(node)) == ("_tools.processes", "os.fork")
