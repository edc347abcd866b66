import re
import shlex
import subprocess
import sys
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import memory
from roughcontact.cli import app
from roughcontact.contact import memory as contact_memory, solve, validation
from roughcontact.contact.memory import MemoryNeed, fixed_bytes
from roughcontact.contact.pair import Pair
from roughcontact.contact.stiffness import stiffness
from roughcontact.halfspace import convolution, fft
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.convolution import MAX_CACHE_BYTES, ArrayCache
from roughcontact.surface import nominal_bodies, random_surfaces

GIB = 2**30
STEEL = rc.Material(young=210e9, poisson=0.3)
KINDS = [(b, p) for b in Boundary for p in ("double", "single")]
NO_LIMIT = 9223372036854771712


def leave(monkeypatch: pytest.MonkeyPatch, size: float) -> None:
    monkeypatch.setattr(memory, "free_bytes", lambda: int(size))


def build_need(shape: tuple[int, int], boundary: str = "free", **options: object) -> MemoryNeed:
    return MemoryNeed(shape, Boundary(boundary), **options)


def memory_estimate(
    shape: tuple[int, int], contact_fraction: float = 1.0, **options: object
) -> int:
    return build_need(shape, **options).estimate(contact_fraction)


def require(shape: tuple[int, int], contact_fraction: float = 0.0, **options: object) -> None:
    build_need(shape, **options).require(contact_fraction)


# Free memory ----------------------------------------------------------------------------------


def tree(root: Path, processes: str, files: dict[str, object]) -> Path:
    """Write what Linux shows of control groups below a folder."""
    for name, content in {"proc/self/cgroup": processes, **files}.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{content}\n", encoding="ascii")
    return root


def left(root: Path) -> list[int]:
    found: Iterator[int] = memory.free_in_containers(root)
    return list(found)


def second(folder: str, most: object, used: int, high: object = "max", files: int = 0):
    """Return the files of one group of version 2."""
    at = f"sys/fs/cgroup/{folder}".rstrip("/")
    return {
        f"{at}/memory.max": most,
        f"{at}/memory.high": high,
        f"{at}/memory.current": used,
        f"{at}/memory.stat": f"anon 1\nfile {2 * files}\ninactive_file {files}\nslab 3",
    }


def first(folder: str, most: object, used: int, files: int = 0):
    """Return the files of one group of version 1."""
    at = f"sys/fs/cgroup/memory/{folder}".rstrip("/")
    return {
        f"{at}/memory.limit_in_bytes": most,
        f"{at}/memory.usage_in_bytes": used,
        f"{at}/memory.stat": f"inactive_file 9\ntotal_inactive_file {files}",
    }


def test_missing_control_groups_set_no_limit(tmp_path: Path) -> None:
    assert left(tmp_path) == []
    assert left(tree(tmp_path, "0::/", {})) == []
    # The outermost group of a machine has no limit.
    assert left(tree(tmp_path, "0::/", {"sys/fs/cgroup/memory.stat": "inactive_file 5"})) == []
    assert left(tree(tmp_path, "nonsense\n0:no path\n\n", {})) == []


def test_a_container_of_version_2(tmp_path: Path) -> None:
    tree(tmp_path, "0::/", second("", 8 * GIB, 3 * GIB, files=GIB))
    assert left(tmp_path) == [6 * GIB]


def test_memory_above_high_limit_is_not_free(tmp_path: Path) -> None:
    tree(tmp_path, "0::/", second("", 8 * GIB, 3 * GIB, high=4 * GIB))
    assert left(tmp_path) == [GIB]
    tree(tmp_path, "0::/", second("", "max", 3 * GIB, high=5 * GIB))
    assert left(tmp_path) == [2 * GIB]


def test_groups_inside_groups_of_version_2(tmp_path: Path) -> None:
    files = {
        **second("user.slice/job/step", "max", GIB),
        **second("user.slice/job", 2 * GIB, GIB, files=GIB // 2),
        **second("user.slice", 64 * GIB, 63 * GIB),
    }
    tree(tmp_path, "0::/user.slice/job/step", files)
    assert left(tmp_path) == [GIB + GIB // 2, GIB]
    # Others do not matter.
    tree(tmp_path, "0::/user.slice/job/step", second("other", GIB, GIB))
    assert min(left(tmp_path)) == GIB


def test_groups_of_version_1(tmp_path: Path) -> None:
    processes = "5:cpu,cpuacct:/docker/b3b4\n4:memory:/docker/b3b4\n1:name=systemd:/\n0::/"
    files = {
        **first("docker/b3b4", 4 * GIB, 3 * GIB, files=GIB // 4),
        **first("docker", NO_LIMIT, 30 * GIB),
        **first("", NO_LIMIT, 40 * GIB),
    }
    tree(tmp_path, processes, files)
    assert left(tmp_path) == [GIB + GIB // 4]


@pytest.mark.parametrize("path", ["/docker/b3b4", "/../../other", "/"])
def test_container_uses_its_group_as_root(path: str, tmp_path: Path) -> None:
    # The kernel names the path as the machine has it, and no such folder is mounted.
    tree(tmp_path, f"4:memory:{path}\n0::{path}", first("", 2 * GIB, GIB))
    assert left(tmp_path) == [GIB]
    other = tree(tmp_path / "2", f"0::{path}", second("", 2 * GIB, GIB, files=5))
    assert left(other) == [GIB + 5]


def test_unlimited_groups_leave_the_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tree(tmp_path, "4:memory:/", first("", NO_LIMIT, GIB))
    assert left(tmp_path) == []
    assert 0 < memory.free_bytes() < 2**60
    monkeypatch.setattr(memory, "free_in_containers", lambda root: iter([GIB, 5, 7]))
    assert memory.free_bytes() == 5
    # A group may use more than it was allowed later.
    monkeypatch.setattr(memory, "free_in_containers", lambda root: iter([-3]))
    assert memory.free_bytes() == 0


def limited(kind: str, script: str, size: int = 8 * GIB) -> str:
    """Run a script in a process that has a separate limit; return what it prints."""
    pytest.importorskip("resource")
    begin = f"import resource; resource.setrlimit(resource.{kind}, ({size}, {size}))\n"
    run = subprocess.run(
        [sys.executable, "-c", begin + script],
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": str(Path(rc.__file__).parents[1])},
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not keep these limits")
@pytest.mark.parametrize("kind", ["RLIMIT_AS", "RLIMIT_DATA"])
def test_limits_of_the_process_count(kind: str) -> None:
    script = """
from roughcontact._tools import memory
before = memory.free_bytes()
block = bytearray(2**28)
print(before, before - memory.free_bytes())
"""
    before, less = map(int, limited(kind, script).split())
    assert 0 < before < 8 * GIB
    assert less >= min(2**28, before)


# Memory of a contact --------------------------------------------------------------------------


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
def test_estimate_grows_with_the_points(boundary: str, precision: str) -> None:
    options = {"boundary": boundary, "precision": precision}
    sizes = [memory_estimate((n, n), **options) for n in (64, 128, 257, 1024, 4096)]
    assert sizes == sorted(set(sizes))
    # In proportion, but for rims, and for the gaps between arrays that are not large.
    larger, smaller = (size - fixed_bytes() for size in sizes[:-3:-1])
    assert 14 < larger / smaller < 16.2
    assert memory_estimate((100, 300), **options) < memory_estimate((101, 300), **options)
    assert memory_estimate((100, 300), **options) < memory_estimate((100, 302), **options)


@pytest.mark.parametrize("shape", [(64, 64), (1000, 333), (4096, 4096)])
def test_single_and_periodic_need_less(shape: tuple[int, int]) -> None:
    for boundary in Boundary:
        double, single = (
            memory_estimate(shape, boundary=boundary, precision=kind, contact_fraction=0.0)
            - fixed_bytes()
            for kind in ("double", "single")
        )
        assert 0.4 * double < single < 0.8 * double
        # The memory per touching pixel is double in both.
        full = memory_estimate(shape, boundary=boundary, precision="single")
        assert full > double + fixed_bytes()
    assert memory_estimate(shape, boundary="periodic") < memory_estimate(shape)


def test_message_states_need_free_memory_and_fitting_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = (20000, 10000)
    light, full = memory_estimate(shape, contact_fraction=0.0), memory_estimate(shape)
    leave(monkeypatch, light / 10)
    with pytest.raises(rc.InsufficientMemoryError) as caught:
        require(shape)
    assert isinstance(caught.value, MemoryError)
    message = str(caught.value)
    assert "20000 × 10000 points" in message
    assert f"about {light / GIB:.1f} GiB ({full / GIB:.1f} GiB in full contact)" in message
    assert f"{light / 10 / GIB:.1f} GiB are free" in message
    # A tenth does not hold single precision either.
    assert "single" not in message
    high, wide = map(int, re.findall(r"up to about (\d+) × (\d+)", message)[0])
    larger = memory_estimate((high + 1, wide + 1), contact_fraction=0.0)
    assert memory_estimate((high, wide), contact_fraction=0.0) <= light / 10 < larger
    high, wide = map(int, re.findall(r"in full contact one of (\d+) × (\d+)", message)[0])
    assert memory_estimate((high, wide)) <= light / 10 < memory_estimate((high + 1, wide + 1))


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
@pytest.mark.parametrize("shape", [(3000, 3000), (200, 50000), (500000, 3)])
@pytest.mark.parametrize("fraction", [0.0, 0.1, 1.0])
def test_the_grid_that_is_advised_fits(
    boundary: str,
    precision: str,
    shape: tuple[int, int],
    fraction: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    options = {"boundary": boundary, "precision": precision}
    options["contact_fraction"] = fraction
    free = memory_estimate(shape, **options) / 2
    leave(monkeypatch, free)
    with pytest.raises(rc.InsufficientMemoryError) as caught:
        require(shape, **options)
    points = int(re.findall(r"about (\d+) × \d+ points fits", str(caught.value))[0])
    # "About": within one percent, and no less than is of use.
    assert memory_estimate((points, points), **options) <= 1.01 * free
    assert memory_estimate((points, points), **options) >= 0.6 * free


def test_single_precision_is_advised_where_it_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = (5000, 5000)
    single = memory_estimate(shape, precision="single", contact_fraction=0.0)
    leave(monkeypatch, single + 1)
    with pytest.raises(rc.InsufficientMemoryError, match='precision="single" fits the whole map'):
        require(shape)
    require(shape, precision="single")
    leave(monkeypatch, single - 1)
    for precision in ("double", "single"):
        with pytest.raises(rc.InsufficientMemoryError) as caught:
            require(shape, precision=precision)
        assert "single" not in str(caught.value)


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
def test_just_enough_is_enough(
    boundary: str, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = {"boundary": boundary, "precision": precision}
    leave(monkeypatch, memory_estimate((512, 512), contact_fraction=0.0, **options))
    require((512, 512), **options)
    with pytest.raises(rc.InsufficientMemoryError):
        require((512, 514), **options)


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
def test_solve_raises_memory_error_before_it_computes(
    boundary: str, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def touched(*_: object, **__: object) -> None:
        raise AssertionError("computed")

    surface = rc.Surface(np.eye(40, 50) * 1e-6, (1e-6, 1e-6))
    options = {"boundary": boundary, "precision": precision}
    monkeypatch.setattr(solve.bounded, "solve", touched)
    monkeypatch.setattr(Pair, "initial_gap", property(touched))
    needed = memory_estimate(surface.shape, contact_fraction=0.0, **options)
    leave(monkeypatch, needed - 1)
    with pytest.raises(rc.InsufficientMemoryError, match="40 × 50"):
        rc.solve(surface, material=STEEL, load=1e-3, **options)
    # With one byte more the same call continues.
    leave(monkeypatch, needed)
    with pytest.raises(AssertionError, match="computed"):
        rc.solve(surface, material=STEEL, load=1e-3, **options)


def rough(points: int = 96) -> rc.Surface:
    return rc.Surface(*rc.reference_map(points))


@pytest.mark.parametrize("boundary", Boundary)
@pytest.mark.parametrize("approach", [None, 2e-7])
def test_memory_check_uses_size_of_contact(
    boundary: str, approach: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    surface = rough()
    given = {"material": STEEL, "boundary": boundary}
    loads = {"load": 0.1} if approach is None else {"approach": approach}
    result = rc.solve(surface, **given, **loads)
    assert 0 < result.contact_fraction < 0.3
    # Enough for twice that part, not for all of the map.
    leave(
        monkeypatch,
        memory_estimate(
            surface.shape, boundary=boundary, contact_fraction=2 * result.contact_fraction
        ),
    )
    again = rc.solve(surface, **given, **loads)
    np.testing.assert_array_equal(again.pressure, result.pressure)
    with pytest.raises(rc.InsufficientMemoryError) as caught:
        rc.solve(surface, **given, load=1e4)
    assert "96 × 96 points in contact on 100 % of it needs about" in str(caught.value)


def test_a_start_is_part_of_the_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    surface = rough()
    leave(monkeypatch, memory_estimate(surface.shape, contact_fraction=0.5))
    rc.solve(surface, material=STEEL, load=0.1)
    with pytest.raises(rc.InsufficientMemoryError, match="in contact on"):
        rc.solve(surface, material=STEEL, load=0.1, initial_guess=np.ones(surface.shape))


@pytest.mark.parametrize(("ceiling", "fits"), [(None, True), (3e9, False)])
def test_guess_with_low_ceiling_needs_memory_of_whole_map(
    ceiling: float | None, fits: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    surface, given = rough(), {"material": STEEL, "ceiling": ceiling}
    start = rc.solve(surface, load=0.1, **given)
    leave(monkeypatch, memory_estimate(surface.shape, contact_fraction=0.6, maps=3))
    rc.solve(surface, load=0.2, **given)
    if fits:
        rc.solve(surface, load=0.2, initial_guess=start, **given)
        rc.sweep(surface, loads=[0.1, 0.2], **given)
        return
    with pytest.raises(rc.InsufficientMemoryError, match="in contact on 100 %"):
        rc.solve(surface, load=0.2, initial_guess=start, **given)
    # Said before the first step.
    monkeypatch.setattr(solve.bounded, "solve", lambda *_, **__: pytest.fail("solved"))
    monkeypatch.setattr(validation, "coarse_contact_guess", lambda *_: 0.01)
    with pytest.raises(rc.InsufficientMemoryError, match="in contact on 100 %"):
        rc.sweep(surface, loads=[0.1, 0.2], **given)


@pytest.mark.parametrize("ceiling", [None, 3e9])
def test_coarse_grid_does_not_underestimate_contact(
    ceiling: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    surface = rough(128)
    monkeypatch.setattr(contact_memory, "_PREVIEW_PIXELS", 32**2)
    for load in (0.03, 1.0, 10.0):
        pair, foreseen = Pair(surface, STEEL), []
        scout = contact_memory.coarse_contact_guess

        def record_guess(*problem, scout=scout, foreseen=foreseen):
            foreseen.append(scout(*problem))
            return foreseen[-1]

        monkeypatch.setattr(validation, "coarse_contact_guess", record_guess)
        leave(monkeypatch, memory_estimate(pair.shape) - 1)
        result = rc.solve(surface, material=STEEL, load=load, ceiling=ceiling)
        assert 0.9 * result.contact_fraction <= foreseen[0] <= 4 * result.contact_fraction
        monkeypatch.undo()
        monkeypatch.setattr(contact_memory, "_PREVIEW_PIXELS", 32**2)


def test_stiffness_checks_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    result = rc.solve(rough(), material=STEEL, load=0.1)
    leave(monkeypatch, memory_estimate((96, 96), contact_fraction=0.0))
    with pytest.raises(rc.InsufficientMemoryError, match="96 × 96 points in contact on"):
        stiffness(result)


def test_study_leaves_out_too_large_finer_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    surface = rough(64)
    given = {"material": STEEL, "load": 0.1, "ceiling": None}
    leave(monkeypatch, memory_estimate((64, 64), contact_fraction=0.3))
    monkeypatch.setattr(
        "roughcontact.uncertainty.resolution.filters.resample", lambda *_, **__: pytest.fail("made")
    )
    study = rc.resolution_study(surface, **given)
    assert len(study.grids) == 2
    assert "0.5 × the pixel was left out: a map of 128 × 128 points needs" in study.notes[0]


# Before maps are made --------------------------------------------------------------------------


HUGE_SHAPE = (30000, 30000)
PIXEL = (1e-8, 1e-8)


@pytest.mark.parametrize(
    "made",
    [
        lambda: rc.Surface(np.broadcast_to(0.0, HUGE_SHAPE), PIXEL),
        lambda: rc.Surface(np.broadcast_to(np.int16(0), HUGE_SHAPE), PIXEL),
        lambda: nominal_bodies.sphere(radius=0.01, shape=HUGE_SHAPE, pixel=PIXEL),
        lambda: nominal_bodies.flat(shape=HUGE_SHAPE, pixel=PIXEL),
        lambda: rc.reference_map(HUGE_SHAPE[0]),
        lambda: rough(32).resampled(HUGE_SHAPE),
        lambda: rough(32).resampled(HUGE_SHAPE, method="spline"),
    ],
    ids=["heights", "integers", "sphere", "flat", "generated", "waves", "spline"],
)
def test_large_maps_raise_memory_error_before_allocation(made, monkeypatch) -> None:
    leave(monkeypatch, GIB)
    with pytest.raises(rc.InsufficientMemoryError) as caught:
        made()
    assert "30000 × 30000 points" in str(caught.value)
    assert "1.0 GiB are free" in str(caught.value)


# Not ru_maxrss, in which that of the process it was forked from counts, too.
COMMAND = """
from pathlib import Path
from roughcontact.cli import app
status = app.main({arguments!r})
lines = Path("/proc/self/status").read_text("ascii").splitlines()
print(status, next(int(line.split()[1]) // 1024 for line in lines if line.startswith("VmHWM")))
"""
CONSTANTS = ("--young", "210 GPa", "--poisson", "0.3", "--yield-strength", "1 GPa")
BODY = ("--body", "sphere 10 mm", "--size", "1 mm", *CONSTANTS)
TASKS = {
    "solve": ("solve", "--load", "1 N"),
    "volume": ("solve", "--load", "1 N", "--model", "elastoplastic"),
    "sweep": ("sweep", "--from", "1 mN", "--to", "1 N"),
    "history": ("history", "--path", "1 N, 0 N"),
    "stress": ("stress", "--load", "1 N"),
    "roll": ("roll", "--load", "1 N", "--counter-body", "sphere 10 mm"),
    "leak": ("leak", "--load", "1 N"),
    "conductance": (
        *shlex.split(
            "conductance --load '1 N' --conductivity '40 W/m/K' --counter-conductivity '40 W/m/K'"
        ),
    ),
}


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not keep these limits")
def test_command_is_rejected_before_it_allocates() -> None:
    # The kernel ended it after a minute.
    script = COMMAND.format(arguments=["solve", *BODY, "--points", "30000", "--load", "1 N"])
    status, peak = map(int, limited("RLIMIT_AS", script).split())
    assert status == 2
    assert peak < 150


def read_rejection(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that must end with status 2; return its one sentence."""
    assert app.main(list(arguments)) == app.BAD_INPUT
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    return err


@pytest.mark.parametrize("task", TASKS)
def test_nominal_bodies_are_rejected_by_memory_of_task(
    task: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rc.Surface, "__init__", lambda *_, **__: pytest.fail("made"))
    leave(monkeypatch, GIB)
    said = read_rejection(capsys, *TASKS[task], *BODY, "--points", "5000x6000")
    assert "5000 × 6000 points" in said
    assert "1.0 GiB are free" in said


def test_too_large_demo_is_rejected_before_allocation(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(random_surfaces, "reference_map", lambda *_: pytest.fail("made"))
    leave(monkeypatch, GIB)
    assert "8000 × 8000 points needs" in read_rejection(capsys, "demo", "--points", "8000")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".nc", ".x3p", ".sur", ".csv"])
def test_too_large_files_are_rejected_by_their_header(
    suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    surface, path = rough(96), tmp_path / f"map{suffix}"
    given = [*TASKS["solve"], str(path), *CONSTANTS]
    if suffix == ".npy":
        np.save(path, surface.heights)
        given += ["--unit", "m", "--size", "0.1 mm"]
    else:
        surface.save(path)
    needed = memory_estimate(surface.shape, contact_fraction=0.0)
    monkeypatch.setattr(rc.Surface, "__init__", lambda *_, **__: pytest.fail("made"))
    leave(monkeypatch, needed)
    # The map itself comes on top, of which only what is kept counts.
    assert "96 × 96 points needs about" in read_rejection(capsys, *given)
    with pytest.raises(pytest.fail.Exception):
        app.main([*given, "--crop", "0:64,0:64"])


@pytest.mark.parametrize(
    ("more", "maps"),
    [(("--report", "out.html"), 13), (("--counter-body", "sphere 1 mm"), 2)],
    ids=["report", "counter-body"],
)
def test_memory_estimate_includes_further_outputs(
    more: tuple[str, str],
    maps: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(rc.Surface, "__init__", lambda *_, **__: pytest.fail("made"))
    given = [*TASKS["solve"], *BODY, "--points", "2000"]
    leave(monkeypatch, memory_estimate((2000, 2000), contact_fraction=0.0, maps=1))
    with pytest.raises(pytest.fail.Exception):
        app.main(given)
    said = read_rejection(capsys, *given, *more)
    assert "a map of 2000 × 2000 points needs about" in said
    assert ("the report on" in said) == ("--report" in more)
    least = memory_estimate((2000, 2000), contact_fraction=0.0, maps=2)
    leave(monkeypatch, max(least, 8 * maps * 2000**2))
    with pytest.raises(pytest.fail.Exception):
        app.main([*given, *more])


def test_too_fine_pixel_is_rejected_before_resampling(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    surface, path = rough(96), tmp_path / "map.npz"
    surface.save(path)
    monkeypatch.setattr(rc.Surface, "resampled", lambda *_, **__: pytest.fail("made"), raising=True)
    leave(monkeypatch, memory_estimate((400, 400), contact_fraction=0.0))
    given = [*TASKS["solve"], str(path), *CONSTANTS, "--pixel"]
    assert "500 × 500 points needs about" in read_rejection(capsys, *given, "200 nm")
    with pytest.raises(pytest.fail.Exception):
        app.main([*given, "500 nm"])


@pytest.mark.long
@pytest.mark.parametrize(("boundary", "precision"), KINDS)
def test_arrays_take_no_more_than_the_estimate(
    boundary: str, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Without the parts for libraries and for gaps between arrays, which would hide a forgotten
    # array of this size; with one thread, whose own arrays are as large on any machine.
    steel, n = rc.Material(210e9, 0.3, 1e9), 1024
    options = {"boundary": boundary, "precision": precision}
    surface = rc.Surface(*rc.reference_map(n))
    monkeypatch.setattr(convolution, "SPECTRA", ArrayCache(MAX_CACHE_BYTES))
    with fft.limit_threads(1):
        tracemalloc.start()
        try:
            result = rc.solve(surface, load=0.5, material=steel, calibrated=False, **options)
            _, most = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
        estimate = memory_estimate((n, n), contact_fraction=result.contact_fraction, **options)
    assert most < estimate - 2**24 - 8 * n * n


def test_a_map_needs_eight_bytes_a_point(monkeypatch):
    from roughcontact.surface import grid

    asked = []
    monkeypatch.setattr(
        memory, "require_memory", lambda needed, *what, advice: asked.append(needed)
    )
    grid.require_memory((2048, 1024), 3)
    grid.require_memory((64, 64), 3)
    assert asked == [8 * 3 * 2048 * 1024]
