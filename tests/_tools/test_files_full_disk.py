"""A disk that is full costs the new file and nothing else: one sentence, and the old file lives.

All commands run in one process, which has to end well: HDF5 used to end it with a segmentation
fault long after the sentence.
"""

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc

STEEL = ["--young", "210 GPa", "--poisson", "0.3", "--quiet"]
MAP = ["rough.npy", "--unit", "m", "--size", "32 um x 32 um", *STEEL]
SOLVE = ["solve", *MAP, "--load", "10 mN"]
SWEEP = ["sweep", *MAP, "--from", "1 mN", "--to", "10 mN", "--steps", "3"]
STRESS = ["stress", *MAP, "--load", "10 mN", "--depths", "1 um"]
HISTORY = ["history", *MAP, "--path", "10 mN, 0 N", "--yield-strength", "2 GPa"]
BALL = [
    *shlex.split("solve --body 'sphere 10 mm' --points 16 --size '0.4 mm'"),
    *STEEL,
    *shlex.split(
        "--yield-strength '1 GPa' --model elastoplastic --load '60 N' --set increments=2 "
        "--set tolerance=1e-3"
    ),
]

PROJECT = """
folder = "box"
write = ["nc"]
[[contact]]
name = "out"
file = "rough.npy"
unit = "m"
size = "32 um x 32 um"
young = "210 GPa"
poisson = 0.3
load = "10 mN"
"""

# The command, the file that cannot be written, and whether a few kilobytes are left before.
CASES = {
    **{
        f"solve {end}": ([*SOLVE, "--output", f"box/out.{end}"], f"out.{end}", False)
        for end in ("nc", "vti", "csv", "json")
    },
    "report": ([*SOLVE, "--report", "box/out.html"], "out.html", False),
    **{
        f"figures {end}": ([*SOLVE, "--figures", f"box/out.{end}"], f"out-surface.{end}", False)
        for end in ("png", "svg", "pdf")
    },
    "sweep steps": ([*SWEEP, "--folder", "box/kept"], "kept/step-0001.npz", True),
    "sweep record": ([*SWEEP, "--folder", "box/kept"], "kept", False),
    **{
        f"sweep {end}": ([*SWEEP, "--output", f"box/out.{end}"], f"out.{end}", False)
        for end in ("csv", "json")
    },
    "sweep figure": ([*SWEEP, "--figure", "box/out.png"], "out.png", False),
    "stress": ([*STRESS, "--output", "box/out.nc"], "out.nc", False),
    "history": ([*HISTORY, "--output", "box/out.csv"], "out.csv", False),
    **{
        f"residual {end}": ([*HISTORY, "--indented-surface", f"box/out.{end}"], f"out.{end}", False)
        for end in ("nc", "npz", "x3p", "sur", "csv", "vti")
    },
    **{
        f"volume {end}": ([*BALL, "--output", f"box/out.{end}"], f"out.{end}", False)
        for end in ("nc", "vtr")
    },
    "volume steps": ([*BALL, "--folder", "box/kept"], "kept/step-0001.nc", True),
    "run": (["run", "project.toml", "--quiet"], "out.nc", False),
    "run summary": (["run", "bare.toml", "--quiet"], "out.json", False),
    "demo": (["demo", "--folder", "box/demo", "--points", "32"], "demo/ground.x3p", False),
}

# Drawing takes time, and fails alike.
ON_DISK = {
    name: case for name, case in CASES.items() if not case[1].endswith((".html", ".pdf", ".svg"))
}

# Carries out the commands on a disk or under a limit that leaves no room, or one page.
CHILD = """
import contextlib, io, json, os, resource, shutil, sys
from pathlib import Path
import matplotlib.font_manager
from roughcontact.cli import app

def tell(box, kind, command, wanted, room):
    for entry in box.iterdir():
        shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
    old = box / wanted
    if not wanted.startswith(("kept", "demo")):
        old.write_text("an older file")
    if kind == "disk":
        with contextlib.suppress(OSError), open(box / "filler", "wb", buffering=0) as filler:
            while True:
                filler.write(bytes(4096))
        if room:
            os.truncate(box / "filler", (box / "filler").stat().st_size - 4096)
    else:
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096 if room else 64, resource.RLIM_INFINITY))
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = app.main(command)
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    return dict(
        status=status, out=out.getvalue(), err=err.getvalue(),
        left=[str(path.relative_to(box)) for path in box.rglob("*") if path.is_file()],
        old=old.read_text() if old.is_file() else None,
    )

if __name__ == "__main__":
    cases = json.load(open("cases.json"))
    found = {name: tell(Path("box"), sys.argv[1], *case) for name, case in cases.items()}
    print(json.dumps(found))
"""


def run_all_commands(kind, folder):
    """Messages and remaining files of every command where nothing can be written."""
    noise = np.random.default_rng(3).standard_normal((32, 32))
    np.save(folder / "rough.npy", 1e-8 * noise)
    (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
    (folder / "bare.toml").write_text(PROJECT.replace('["nc"]', "[]"), encoding="utf-8")
    cases = ON_DISK if kind == "disk" else CASES
    (folder / "cases.json").write_text(json.dumps(cases), encoding="utf-8")
    (folder / "box").mkdir()
    (folder / "child.py").write_text(CHILD, encoding="utf-8")
    command = [sys.executable, "-B", "child.py", kind]
    if kind == "disk":
        # A separate small disk, which is unmounted with the process.
        own = ["unshare", "--map-root-user", "--mount"]
        mount = "mount -t tmpfs -o size=256k none box"
        if (
            shutil.which("unshare") is None
            or subprocess.run([*own, "sh", "-c", mount], cwd=folder, capture_output=True).returncode
        ):
            pytest.skip("no small disk can be mounted here")
        command = [*own, "sh", "-c", f'{mount} && exec "$@"', "sh", *command]
    elif sys.platform == "win32":
        pytest.skip("no limit for the size of files on this system")
    source = str(Path(rc.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": source}
    ran = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, "")
    return json.loads(ran.stdout)


@pytest.mark.slow
# One process for all commands of a kind: a test of each would start it again in every worker.
@pytest.mark.process
@pytest.mark.parametrize("kind", ["limit", "disk"])
def test_full_disk_gives_one_sentence_and_keeps_old_file(kind: str, tmp_path: Path) -> None:
    result = run_all_commands(kind, tmp_path)
    assert set(result) == set(ON_DISK if kind == "disk" else CASES)
    reason = "No space left on device" if kind == "disk" else "File too large"
    for name, found in result.items():
        _, wanted, room = CASES[name]
        assert (name, found["status"]) == (name, 1 if name.startswith("run") else 2)
        assert (name, found["err"].count("\n"), found["out"]) == (name, 1, "")
        assert f"box/{wanted}" in found["err"]
        assert reason in found["err"]
        assert "Error" not in found["err"]
        kept = {"filler"} if kind == "disk" else set()
        if found["old"] is not None:
            assert (name, found["old"]) == (name, "an older file")
            kept |= {wanted}
        if room:
            kept |= {"kept/sweep.json" if name.startswith("sweep") else "kept/volume.json"}
        if name == "run summary":
            # The previous files are of another run.
            kept |= {"out.json"}
        assert (name, set(found["left"])) == (name, kept)
