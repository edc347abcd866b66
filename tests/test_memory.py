import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact import solve
from roughcontact.contact.checks import check_memory, memory_estimate
from roughcontact.contact.pair import Pair
from roughcontact.halfspace.boundary import Boundary

psutil = pytest.importorskip("psutil")

GIB = 2**30
STEEL = rc.Material(young=210e9, poisson=0.3)
KINDS = [(b, p) for b in Boundary for p in ("double", "single")]


def leave(monkeypatch: pytest.MonkeyPatch, size: float) -> None:
    class Memory:
        available = int(size)

    monkeypatch.setattr(psutil, "virtual_memory", Memory)


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
def test_estimate_grows_with_the_points(boundary: str, precision: str) -> None:
    options = {"boundary": boundary, "precision": precision}
    sizes = [memory_estimate((n, n), **options) for n in (64, 128, 257, 1024, 4096)]
    assert sizes == sorted(set(sizes))
    # In proportion, to the rims.
    assert sizes[-1] / sizes[-2] == pytest.approx(16, rel=0.01)
    assert memory_estimate((100, 300), **options) < memory_estimate((101, 300), **options)
    assert memory_estimate((100, 300), **options) < memory_estimate((100, 302), **options)


@pytest.mark.parametrize("shape", [(64, 64), (1000, 333), (4096, 4096)])
def test_single_and_periodic_need_less(shape: tuple[int, int]) -> None:
    for boundary in Boundary:
        double = memory_estimate(shape, boundary=boundary)
        single = memory_estimate(shape, boundary=boundary, precision="single")
        # The two maps that are returned, or at least the pressure, stay double.
        assert 0.4 * double < single < 0.8 * double
    assert memory_estimate(shape, boundary="periodic") < memory_estimate(shape)


def test_estimate_holds_at_least_what_is_returned() -> None:
    # Pressure and gap, and the spectra of the padded rows, in double.
    n = 1000
    assert memory_estimate((n, n)) > 8 * n * n * (2 + 2)


def test_the_message_says_need_free_and_what_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = (20000, 10000)
    need = memory_estimate(shape)
    leave(monkeypatch, need / 10)
    with pytest.raises(rc.InsufficientMemoryError) as caught:
        check_memory(shape)
    assert isinstance(caught.value, MemoryError)
    message = str(caught.value)
    assert "20000 × 10000 points" in message
    assert f"about {need / GIB:.1f} GiB" in message
    assert f"{need / 10 / GIB:.1f} GiB are free" in message
    # A tenth does not hold single precision either.
    assert "single" not in message
    high, wide = map(int, re.findall(r"up to about (\d+) × (\d+)", message)[0])
    assert high == wide == pytest.approx(np.sqrt(2e8 / 10), rel=0.01)


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
@pytest.mark.parametrize("shape", [(3000, 3000), (200, 50000), (50000, 3)])
def test_the_grid_that_is_advised_fits(
    boundary: str, precision: str, shape: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    options = {"boundary": boundary, "precision": precision}
    free = memory_estimate(shape, **options) / 2
    leave(monkeypatch, free)
    with pytest.raises(rc.InsufficientMemoryError) as caught:
        check_memory(shape, **options)
    points = int(re.findall(r"about (\d+) × \d+ points fits", str(caught.value))[0])
    # "About": within one percent, and no less than is of use.
    assert memory_estimate((points, points), **options) <= 1.01 * free
    assert memory_estimate((points, points), **options) >= 0.6 * free


def test_single_precision_is_advised_where_it_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = (5000, 5000)
    single = memory_estimate(shape, precision="single")
    leave(monkeypatch, single + 1)
    with pytest.raises(rc.InsufficientMemoryError, match='precision="single" fits the whole map'):
        check_memory(shape)
    check_memory(shape, precision="single")
    leave(monkeypatch, single - 1)
    for precision in ("double", "single"):
        with pytest.raises(rc.InsufficientMemoryError) as caught:
            check_memory(shape, precision=precision)
        assert "single" not in str(caught.value)


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
def test_just_enough_is_enough(
    boundary: str, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = {"boundary": boundary, "precision": precision}
    leave(monkeypatch, memory_estimate((512, 512), **options))
    check_memory((512, 512), **options)
    with pytest.raises(rc.InsufficientMemoryError):
        check_memory((512, 514), **options)


@pytest.mark.parametrize(("boundary", "precision"), KINDS)
def test_solve_refuses_before_it_computes(
    boundary: str, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def touched(*_: object, **__: object) -> None:
        raise AssertionError("computed")

    surface = rc.Surface(np.eye(40, 50) * 1e-6, (1e-6, 1e-6))
    options = {"boundary": boundary, "precision": precision}
    monkeypatch.setattr(solve.bounded, "solve", touched)
    monkeypatch.setattr(Pair, "initial_gap", property(touched))
    leave(monkeypatch, memory_estimate(surface.shape, **options) - 1)
    with pytest.raises(rc.InsufficientMemoryError, match="40 × 50"):
        rc.solve(surface, material=STEEL, load=1e-3, **options)
    # With one byte more the same call goes on.
    leave(monkeypatch, memory_estimate(surface.shape, **options))
    with pytest.raises(AssertionError, match="computed"):
        rc.solve(surface, material=STEEL, load=1e-3, **options)


SCRIPT = """
import sys
import numpy as np
import roughcontact as rc

def status(name):
    with open("/proc/self/status") as lines:
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith(name))

path, edge, boundary, precision = sys.argv[1:]
steel = rc.Material(210e9, 0.3, 1e9)
options = dict(material=steel, boundary=boundary, precision=precision)
heights, pixel = rc.reference_map(64)
# Libraries are loaded and threads started by the first solve.
rc.solve(rc.Surface(heights, pixel), load=1.0, **options)
heights = np.empty(np.load(path, mmap_mode="r").shape)
with open(path, "rb") as file:
    file.seek(-heights.nbytes, 2)
    file.readinto(heights.data)
heights.flags.writeable = False
surface = rc.Surface(heights, (float(edge), float(edge)))
before, peak = status("VmRSS"), status("VmHWM")
result = rc.solve(surface, load=1.0, **options)
after = status("VmHWM")
assert result.converged and after > peak
print(after - before)
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc to read the peak from")
@pytest.mark.parametrize(("boundary", "precision"), KINDS)
@pytest.mark.parametrize("n", [1024, 2048])
def test_estimate_is_the_peak_that_is_measured(
    n: int, boundary: str, precision: str, tmp_path: Path
) -> None:
    heights, pixel = rc.reference_map(n)
    np.save(tmp_path / "map.npy", heights)
    source = Path(rc.__file__).parents[1]
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path / "map.npy"), repr(pixel[0]),
         boundary, precision],
        capture_output=True, text=True, check=False, env={"PYTHONPATH": str(source)},
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    measured = int(run.stdout)
    estimate = memory_estimate((n, n), boundary=boundary, precision=precision)
    assert estimate / 1.5 < measured < 1.5 * estimate
