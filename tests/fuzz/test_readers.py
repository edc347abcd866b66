"""Damaged files are rejected or read at the scale that they state.

A small part of `tests/fuzz/damaged_files.py`, and that its judge sees what is wrong.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import damaged_files
import targets
from damaged_files import REFUSED, STATED, UNCHANGED, WRONG, Damaged, Order, Worker
from plain import Plain
from targets import Reading

pytestmark = pytest.mark.process

pytest.importorskip("resource", reason="limits of memory are POSIX")


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("prepared") / "targets"
    targets.prepare(folder)
    return folder


@pytest.fixture(scope="module")
def known(prepared: Path) -> dict[str, targets.Target]:
    return targets.load(prepared)


@pytest.fixture(scope="module")
def worker(prepared: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Worker]:
    worker = Worker(prepared, tmp_path_factory.mktemp("worker"))
    yield worker
    worker.close()


@pytest.fixture(params=list(targets.SHARES))
def name(request: pytest.FixtureRequest, known: dict[str, targets.Target]) -> str:
    if request.param not in known:
        pytest.skip(f"{request.param} or its reader is absent")
    return str(request.param)


def wrong(worker: Worker, orders: list[Order]) -> list[str]:
    outcomes = [worker.attempt(order) for order in orders]
    return [str(outcome) for outcome in outcomes if outcome.verdict == WRONG]


def test_damaged_files(name: str, worker: Worker) -> None:
    assert wrong(worker, [Order(0, name)]) == []


@pytest.mark.slow
def test_many_damaged_files(name: str, worker: Worker) -> None:
    assert wrong(worker, [Order(seed, name) for seed in range(1000, 1400)]) == []


def suffixes_for(name: str) -> list[str]:
    return targets.other_suffixes(Path(name).suffix)


MAPS = (*targets.MADE, *targets.SAVED, *targets.MEASURED)


@pytest.mark.parametrize("name", MAPS, indirect=True)
def test_misnamed_files(name: str, worker: Worker) -> None:
    rng = np.random.default_rng(len(name))
    some = [str(suffix) for suffix in rng.choice(suffixes_for(name), 1, replace=False)]
    assert wrong(worker, [Order(0, name, suffix) for suffix in some]) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", MAPS, indirect=True)
def test_files_under_every_suffix(name: str, worker: Worker) -> None:
    assert wrong(worker, [Order(0, name, suffix) for suffix in suffixes_for(name)]) == []


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        # Scales that a reader replaces by 1 where their names are damaged.
        ("wyko_nt1100_test_1.opd", {26: 0x72}, "no block 'Mult'"),
        ("wyko_nt1100_test_1.opd", {736: 0x60}, "no block 'Aspect'"),
        # Grids and lengths that shear the map.
        ("metropro-1.dat", {53: 0x6C}, "camera frames take"),
        ("metropro-1.dat", {71: 0xB8}, "phases take"),
        ("dvd_afm.sur", {334: 0x11}, "heights end at byte"),
        ("made.sur", {334: 0x0C}, "heights end at byte"),
        ("uncd_afm.001", {23284: 0x33}, "the image has 513 × 512 points by its section"),
        ("made.npy", {61: 0x32}, "bytes of the file unused"),
        ("made.sdf", {104: 0x32}, "announces 440 heights, but has 660"),
        # A length with which a reader never comes to where checksums are compared.
        ("x3p-2.x3p", {3236014: 0x5C, 1205: 0x40, 1084: 0x34}, "packed into 3.1 MiB as no"),
        # An origin in whose digits the heights are lost, and a step.
        ("mnt-1.mnt", {1586381: 0xE4}, "heights span 0 counts, not 22237587"),
        ("mnt-1.mnt", {1586315: 0x3B}, "heights span 0 counts, not 22237587"),
        # More bytes than any memory has.
        ("metropro-1.dat", {68: 0x82, 70: 0x81}, "announces 33248 × 33408 points"),
        # A unit of no letters.
        ("made.sur", dict.fromkeys(range(180, 276), 0), "gives no unit"),
        # h5netcdf leaves half a file behind, which raises an error when it is collected.
        ("made.nc", {246: 0xA2}, ""),
        # A number that is none, of the kind that raises a signal.
        ("made.npy", {134: 0xF0, 135: 0x7F}, ""),
    ],
)
def test_earlier_findings_are_fixed(
    name: str,
    changes: dict[int, int],
    words: str,
    known: dict[str, targets.Target],
    worker: Worker,
    tmp_path: Path,
) -> None:
    if name not in known:
        pytest.skip(f"{name} or its reader is absent")
    content = bytearray(known[name].files[name])
    for place, value in changes.items():
        content[place] = value
    path = tmp_path / name
    path.write_bytes(content)
    outcome = worker.attempt(Order(0, name, path=str(path)))
    assert outcome.verdict == REFUSED if words else outcome.verdict != WRONG, str(outcome)
    assert words in outcome.words


@pytest.mark.parametrize("name", ["made.nc", "made.datx"])
def test_damaged_hdf5_heap_raises_format_error_in_time(
    name: str, known: dict[str, targets.Target], worker: Worker, tmp_path: Path
) -> None:
    if name not in known:
        pytest.skip("the readers of instruments' files are absent")
    content = bytearray(known["made.nc"].files["made.nc"])
    heap = content.index(b"GCOL")
    # The size of its first object, and what follows.
    content[heap + 24 : heap + 36] = bytes(12)
    path = tmp_path / name
    path.write_bytes(content)
    outcome = worker.attempt(Order(0, name, path=str(path)))
    assert outcome.verdict == REFUSED, str(outcome)


# The judge sees it


HOSTILE = """
import pathlib
import roughcontact as rc

true = rc.read_surface

def read(path, **given):
    path = pathlib.Path(path).resolve()
    text = path.read_bytes()
    if text.startswith(b"#run"):
        exec(text, {"path": path})
        path = pathlib.Path(__file__).with_name("whole.npy")
    return true(path, **given)

rc.read_surface = read
"""


@pytest.fixture(scope="module")
def hostile(
    prepared: Path, known: dict[str, targets.Target], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Worker]:
    """A worker whose reader does what is in the file."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "sitecustomize.py").write_text(HOSTILE)
    (folder / "whole.npy").write_bytes(known["made.npy"].files["made.npy"])
    limits = damaged_files.Limits(seconds=3.0, growth=2**25)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(folder))
        worker = Worker(prepared, folder / "work", limits)
        yield worker
        worker.close()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("1 / 0", "ZeroDivisionError"),
        ("import os; os.write(1, b'hello')", "printed b'hello"),
        ("import sys; print('hello', file=sys.stderr)", "printed b'hello"),
        ("bytes(4 * 2**30)", "MemoryError"),
        ("import numpy; numpy.ones(2**23)", "took 0.1 GiB"),
        ("open(str(path) + '.part', 'w').close()", "left made.npy.part"),
        ("open(path.parents[1] / 'outside' / 'numbers.bin').close()", "opened another file"),
        ("import sys, io; sys.stdout = io.StringIO()", "another stream"),
        ("import os; os.kill(os.getpid(), 11)", "died with status -11"),
        ("import time; time.sleep(60)", "took more than"),
    ],
)
def test_the_judge_sees_it(content: str, words: str, hostile: Worker, tmp_path: Path) -> None:
    path = tmp_path / "map.npy"
    path.write_text(f"#run\n{content}\n")
    outcome = hostile.attempt(Order(0, "made.npy", path=str(path)))
    assert outcome.verdict == WRONG
    assert words in outcome.words


def damaged(known: dict[str, targets.Target], name: str, **changes: object) -> Damaged:
    target = known[name]
    (file,) = target.files
    return replace(Damaged(target, file, target.files[file], ""), **changes)  # type: ignore[arg-type]


def test_the_judge_sees_other_scales(known: dict[str, targets.Target]) -> None:
    whole = damaged(known, "made.npy")
    original = Reading(plain=known["made.npy"].sample.stated(whole.content))
    plain = original.plain

    def verdict(read: Plain, drawn: Damaged = whole) -> str:
        return damaged_files.judge(drawn, original, Reading(plain=read))[0]

    assert verdict(plain) == UNCHANGED
    dy, dx = plain.pixel
    for other in (
        Plain(plain.heights, (dx, dy)),
        Plain(plain.heights, (dy * 1.001, dx)),
        Plain(plain.heights * 1.001, plain.pixel),
        Plain(plain.heights[:-1], plain.pixel),
        Plain(np.where(np.isnan(plain.heights), 0, plain.heights), plain.pixel),
        Plain(plain.heights, (1.0, 1.0)),
        Plain(plain.heights * 1e6, plain.pixel),
    ):
        assert verdict(other) == WRONG
    # One damaged byte may change one height, where no checksum says otherwise.
    content = bytearray(whole.content)
    content[-1] ^= 1
    heights = plain.heights.copy()
    heights[-1, -1] *= 2
    flipped = replace(whole, content=bytes(content))
    assert verdict(Plain(heights, plain.pixel), flipped) == STATED
    heights[0, 0] *= 2
    assert verdict(Plain(heights, plain.pixel), flipped) == WRONG
    archive = damaged(known, "made.npz", content=bytes(content))
    one = heights.copy()
    one[0, 0] *= 3
    assert verdict(Plain(one, plain.pixel), archive) == WRONG
    for message in ("two\nlines", "another.npy is bad", "made.npy (MemoryError)"):
        assert damaged_files.judge(whole, original, Reading(refused=message))[0] == WRONG
    assert damaged_files.judge(whole, original, Reading(refused="made.npy is bad"))[0] == REFUSED


def test_the_judge_sees_silent_changes(known: dict[str, targets.Target]) -> None:
    drawn = damaged(known, "contact.nc")
    original = Reading(facts={"load": (1.0).hex(), "seconds": "1"})

    def verdict(**changes: object) -> str:
        return damaged_files.judge(drawn, original, replace(original, **changes))[0]  # type: ignore[arg-type]

    assert verdict() == UNCHANGED
    other = {"load": float(np.nextafter(1.0, 2)).hex(), "seconds": "1"}
    assert verdict(facts=other) == WRONG
    assert verdict(facts=other, again=True) == WRONG
    assert verdict(facts=other, said="unsealed") == damaged_files.SAID
    assert verdict(facts={"load": original.facts["load"], "seconds": "2"}) == WRONG
    again = {"load": original.facts["load"], "seconds": "2"}
    assert verdict(facts=again, again=True) == damaged_files.AGAIN
    assert verdict(raised="raised KeyError") == WRONG


def test_facts_are_bits() -> None:
    one = targets.facts({"a": (1.0, [np.arange(3.0)]), "b": None})
    assert set(one) == {".a.0", ".a.1.0", ".b"}
    other = np.arange(3.0)
    other[1:2].view("u8")[0] ^= 1
    assert targets.facts({"a": (1.0, [other]), "b": None}) != one
    assert targets.facts(0.0) != targets.facts(-0.0)


# Damage
