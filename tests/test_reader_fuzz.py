"""Damaged files are refused or read at the scale that they state, whatever is damaged.

Every measurement is copied with damage of many kinds and read by a second process, under a limit
of time and of memory. What comes back is compared with the undamaged map, and where it differs in
more points than bytes were damaged, with a plain reading of the damaged file: one per format,
see `plain`.
"""

import json
import os
import select
import subprocess
import sys
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import samples
from plain import Plain, differing, implausible, plain_mnt
from samples import Sample

SECONDS = 20.0
MEMORY = 4 * 2**30


# The second process


def serve() -> None:
    """Read the files that are named on standard input, and answer in one line each."""
    import resource

    from roughcontact.errors import RoughcontactError
    from roughcontact.formats.read import read_surface

    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # Whatever a library prints, in Python or in C, goes to a file and is seen.
    noise = os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(noise, 1)
    os.dup2(noise, 2)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for line in sys.stdin:
        order = json.loads(line)
        answer: dict[str, object] = {}
        try:
            surface = read_surface(order["path"], **order["arguments"])
            np.save(order["path"] + ".read.npy", surface.heights)
            answer = {"pixel": surface.pixel}
        except RoughcontactError as error:
            answer = {"refused": str(error), "cause": repr(error.__cause__)}
        except BaseException as error:
            answer = {"raised": repr(error)}
        sys.stdout.flush()
        answer["printed"] = os.lseek(noise, 0, os.SEEK_CUR)
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


class Reader:
    """A process that reads files, replaced by another where it hangs or dies."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process: subprocess.Popen[str] | None = None
        self.printed = 0

    def read(self, path: Path, arguments: dict[str, str]) -> dict[str, object]:
        if self.process is None:
            self.start()
        assert self.process is not None
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        order = json.dumps({"path": str(path), "arguments": arguments})
        self.process.stdin.write(order + "\n")
        self.process.stdin.flush()
        ready, _, _ = select.select([self.process.stdout], [], [], SECONDS)
        line = self.process.stdout.readline() if ready else ""
        if not line:
            died = self.process.wait(SECONDS) if ready else None
            self.close()
            return {"raised": f"died with {died}" if ready else f"took more than {SECONDS} s"}
        answer: dict[str, object] = json.loads(line)
        printed = answer.pop("printed")
        if printed != self.printed:
            noise = (self.folder / "noise").read_bytes()[self.printed :]
            answer = {"raised": f"printed {noise[:300]!r}"}
            self.printed = printed
        if "pixel" in answer:
            answer["heights"] = np.load(f"{path}.read.npy")
        return answer

    def start(self) -> None:
        import roughcontact

        (self.folder / "noise").write_bytes(b"")
        self.printed = 0
        source = Path(roughcontact.__file__).parents[1]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([str(source), os.environ.get("PYTHONPATH", "")]),
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
            "PYTHONUNBUFFERED": "1",
        }
        self.process = subprocess.Popen(
            [sys.executable, __file__, str(self.folder / "noise")],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment,
        )  # fmt: skip

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None


# Damage


def damaged(case: Sample, rng: np.random.Generator) -> tuple[str, bytes]:
    """Return what was done to a file, and the result."""
    content = bytearray(case.content)
    length = len(content)

    def anywhere() -> int:
        return int(rng.integers(length))

    def in_header() -> int:
        # Headers stand at the start, directories of archives at the end.
        where = rng.random()
        if where < 0.5 and case.fields:
            start, stop = case.fields[int(rng.integers(len(case.fields)))]
            return int(rng.integers(start, min(stop, length)))
        if where < 0.8:
            return int(rng.integers(min(2048, length)))
        if where < 0.9:
            return int(rng.integers(min(48 * 1024, length)))
        return int(rng.integers(max(length - 4096, 0), length))

    def flip(place: int) -> str:
        old = content[place]
        if rng.random() < 0.5:
            content[place] ^= 1 << int(rng.integers(8))
        else:
            content[place] = int(rng.integers(256))
        return f"{place}: {old:#04x} to {content[place]:#04x}"

    kinds = {"truncate": 0.13, "flip": 0.06, "header": 0.4, "headers": 0.1, "flips": 0.05,
             "zero": 0.08, "noise": 0.06, "swap": 0.06, "tail": 0.06}  # fmt: skip
    kind = str(rng.choice(list(kinds), p=list(kinds.values())))
    if kind == "truncate":
        keep = anywhere() if rng.random() < 0.7 else in_header()
        return f"truncated to {keep} of {length} bytes", bytes(content[:keep])
    if kind in ("flip", "header"):
        return "flipped " + flip(anywhere() if kind == "flip" else in_header()), bytes(content)
    if kind in ("flips", "headers"):
        places = [anywhere() if kind == "flips" else in_header() for _ in range(rng.integers(2, 9))]
        return "flipped " + ", ".join(flip(place) for place in places), bytes(content)
    start = in_header() if rng.random() < 0.5 else anywhere()
    size = min(int(2 ** rng.uniform(0, 12)), length - start)
    if kind == "zero":
        content[start : start + size] = bytes(size)
        return f"zeroed {size} bytes at {start}", bytes(content)
    if kind == "noise":
        content[start : start + size] = rng.bytes(size)
        return f"noise in {size} bytes at {start}", bytes(content)
    if kind == "swap":
        other = min(anywhere(), length - size)
        block = content[start : start + size]
        content[start : start + size] = content[other : other + size]
        content[other : other + size] = block
        return f"swapped {size} bytes at {start} and {other}", bytes(content[:length])
    size = min(int(2 ** rng.uniform(0, 18)), length)
    return f"last {size} bytes twice", bytes(content + content[length - size :])


def finding(case: Sample, original: Plain, content: bytes, answer: dict[str, object]) -> str:
    """Return what is wrong with an answer; empty if nothing is."""
    if "raised" in answer:
        return str(answer["raised"])
    if "refused" in answer:
        return wrong_in_message(case, answer)
    heights, pixel = np.asarray(answer["heights"]), tuple(answer["pixel"])  # type: ignore[arg-type]
    wrong = implausible(heights, pixel)
    if wrong:
        return wrong
    if heights.shape == original.heights.shape and pixel == original.pixel:
        same = (heights == original.heights) | (np.isnan(heights) & np.isnan(original.heights))
        changed = int(np.count_nonzero(~same))
        common = min(len(content), len(case.content))
        bytes_changed = int(
            np.count_nonzero(
                np.frombuffer(content[:common], "u1") != np.frombuffer(case.content[:common], "u1")
            )
        )
        if changed <= (0 if case.checked else bytes_changed):
            return ""
    try:
        stated = case.stated(content)
    except Exception as error:
        return f"read, while a plain reading fails with {error!r}: {described(original, answer)}"
    wrong = differing(Plain(heights, pixel), stated)
    return f"{wrong}: {described(original, answer)}, stated {stated.pixel}" if wrong else ""


def wrong_in_message(case: Sample, answer: dict[str, object]) -> str:
    message = str(answer["refused"])
    if "\n" in message or not message.isprintable() or len(message) > 700:
        return f"no sentence: {message!r}"
    if case.name.split(".")[0] not in message:
        return f"does not name the file: {message!r}"
    # Memory asked for is asked of a larger machine in vain too.
    if "MemoryError" in message + str(answer["cause"]):
        return f"out of memory: {message!r}"
    return ""


def described(original: Plain, answer: dict[str, object]) -> str:
    heights = np.asarray(answer["heights"])
    text = f"{heights.shape} of pixel {answer['pixel']} for {original.heights.shape} of "
    text += f"{original.pixel}, span {np.nanmin(heights)} to {np.nanmax(heights)}"
    if heights.shape == original.heights.shape:
        differ = heights != original.heights
        differ &= ~(np.isnan(heights) & np.isnan(original.heights))
        text += f", {np.count_nonzero(differ)} heights differ"
    return text


def sound(reader: Reader, case: Sample, path: Path) -> tuple[Sample, Plain]:
    """Return a case with its undamaged map, and check the judge itself on it."""
    path.write_bytes(case.content)
    answer = reader.read(path, case.arguments)
    assert "heights" in answer, answer
    original = Plain(np.asarray(answer["heights"]), tuple(answer["pixel"]))  # type: ignore[arg-type]
    if case.name.endswith(".mnt"):
        counts = (original.heights - np.mean(original.heights)) / 1e-13
        case = replace(case, stated=plain_mnt(case.content, counts))
    assert not differing(original, case.stated(case.content))
    return case, original


def campaign(reader: Reader, case: Sample, folder: Path, count: int, seed: int) -> list[str]:
    """Return the findings of so many damaged copies of a file."""
    path = folder / case.name
    case, original = sound(reader, case, path)
    findings = []
    for index in range(count):
        rng = np.random.default_rng([seed, zlib.crc32(case.name.encode()), index])
        what, content = damaged(case, rng)
        if content == case.content:
            continue
        path.write_bytes(content)
        wrong = finding(case, original, content, reader.read(path, case.arguments))
        if wrong:
            findings.append(f"{case.name} #{index}, {what}: {wrong}")
    return findings


# Tests

MADE = ("made.npy", "made.npz", "made.csv", "made.txt", "made.asc", "bare.nc", "made.nc",
        "made.sdf", "made.x3p", "stored.x3p", "made.sur")  # fmt: skip
MEASURED = ("wyko_nt1100_test_1.opd", "opd-1.opd", "sur-2.sur", "dvd_afm.sur", "metropro-1.dat",
            "uncd_afm.001", "mnt-1.mnt", "x3p-2.x3p", "bullet_land_fixed.x3p")  # fmt: skip


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reader]:
    pytest.importorskip("resource", reason="limits of memory are POSIX")
    reader = Reader(tmp_path_factory.mktemp("reader"))
    yield reader
    reader.close()


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Sample]:
    made = samples.made(tmp_path_factory.mktemp("made"))
    return {case.name: case for case in (*made, *samples.measured())}


@pytest.fixture(params=(*MADE, *MEASURED))
def case(request: pytest.FixtureRequest, cases: dict[str, Sample]) -> Sample:
    if request.param not in cases:
        pytest.skip(f"{request.param} or its reader is absent")
    return cases[request.param]


def test_damaged_files(case: Sample, reader: Reader, tmp_path: Path) -> None:
    findings = campaign(reader, case, tmp_path, 20, seed=1)
    assert not findings, "\n".join(findings)


@pytest.mark.slow
def test_many_damaged_files(case: Sample, reader: Reader, tmp_path: Path) -> None:
    findings = campaign(reader, case, tmp_path, 500, seed=2)
    assert not findings, "\n".join(findings)


def misnamed(reader: Reader, case: Sample, folder: Path, suffixes: list[str]) -> list[str]:
    """Return the findings of a file under other suffixes: refused, or the same map."""
    case, original = sound(reader, case, folder / case.name)
    findings = []
    for suffix in suffixes:
        path = folder / f"{case.name.split('.')[0]}{suffix}"
        path.write_bytes(case.content)
        matrix = suffix in (".npy", ".npz", ".csv", ".txt", ".asc")
        given = {"unit": "um", "size": "30 um x 44 um"} if matrix else {}
        answer = reader.read(path, given)
        if "heights" in answer:
            heights, pixel = np.asarray(answer["heights"]), answer["pixel"]
            wrong = differing(Plain(heights, tuple(pixel)), original)  # type: ignore[arg-type]
        else:
            wrong = str(answer.get("raised", "")) or wrong_in_message(case, answer)
        if wrong:
            findings.append(f"{case.name} as {suffix}: {wrong}")
    return findings


def suffixes_for(case: Sample) -> list[str]:
    from roughcontact.formats.read import SUFFIXES

    return sorted({*SUFFIXES, ".000"} - {case.name[case.name.rindex(".") :]})


def test_misnamed_files(case: Sample, reader: Reader, tmp_path: Path) -> None:
    rng = np.random.default_rng(zlib.crc32(case.name.encode()))
    some = sorted(rng.choice(suffixes_for(case), 5, replace=False))
    findings = misnamed(reader, case, tmp_path, [str(suffix) for suffix in some])
    assert not findings, "\n".join(findings)


@pytest.mark.slow
def test_files_under_every_suffix(case: Sample, reader: Reader, tmp_path: Path) -> None:
    findings = misnamed(reader, case, tmp_path, suffixes_for(case))
    assert not findings, "\n".join(findings)


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
        ("made.npy", {61: 0x32}, "bytes of the file over"),
        ("made.sdf", {104: 0x32}, "announces 440 heights, but has 660"),
        # A length with which a reader never comes to where checksums are compared.
        ("x3p-2.x3p", {3236014: 0x5C, 1205: 0x40, 1084: 0x34}, "checksum of 'bindata/data.bin'"),
        # An origin in whose digits the heights are lost, and a step.
        ("mnt-1.mnt", {1586381: 0xE4}, "heights span 0 counts, not 22237587"),
        ("mnt-1.mnt", {1586315: 0x3B}, "heights span 0 counts, not 22237587"),
        # More bytes than any memory has.
        ("metropro-1.dat", {68: 0x82, 70: 0x81}, "cannot be read"),
        # A unit of no letters.
        ("made.sur", dict.fromkeys(range(180, 276), 0), "gives no unit"),
        # h5netcdf leaves half a file behind, which complains when it is collected.
        ("made.nc", {246: 0xA2}, ""),
        # A number that is none, of the kind that raises a signal.
        ("made.npy", {134: 0xF0, 135: 0x7F}, ""),
    ],
)
def test_what_was_found_before(
    name: str,
    changes: dict[int, int],
    words: str,
    cases: dict[str, Sample],
    reader: Reader,
    tmp_path: Path,
) -> None:
    if name not in cases:
        pytest.skip(f"{name} or its reader is absent")
    case = cases[name]
    content = bytearray(case.content)
    for place, value in changes.items():
        content[place] = value
    path = tmp_path / name
    path.write_bytes(content)
    answer = reader.read(path, case.arguments)
    assert "raised" not in answer
    if words:
        assert words in str(answer.get("refused"))
        assert not wrong_in_message(case, answer)


@pytest.mark.parametrize("suffix", [".nc", ".datx"])
def test_hdf5_does_not_stand_still(
    suffix: str, cases: dict[str, Sample], reader: Reader, tmp_path: Path
) -> None:
    if suffix == ".datx" and "made.sdf" not in cases:
        pytest.skip("the readers of instruments' files are absent")
    content = bytearray(cases["made.nc"].content)
    heap = content.index(b"GCOL")
    # The size of its first object, and what follows.
    content[heap + 24 : heap + 36] = bytes(12)
    path = tmp_path / f"made{suffix}"
    path.write_bytes(content)
    assert "the free space of a heap" in str(reader.read(path, {})["refused"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"import time; time.sleep(60)", "took more than"),
        (b"import os; os.kill(os.getpid(), 11)", "died with -11"),
        (b"import os; os.write(1, b'hello')", "printed b'hello"),
        (b"1 / 0", "ZeroDivisionError"),
        (b"bytes(5 * 2**30)", "MemoryError"),
    ],
)
def test_the_judge_sees_it(
    content: bytes, words: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("resource")
    monkeypatch.setitem(globals(), "SECONDS", 4.0)
    (tmp_path / "sitecustomize.py").write_text(
        "import roughcontact.formats.read as f, pathlib\n"
        "f.read_surface = lambda path, **_: exec(pathlib.Path(path).read_text())\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    reader = Reader(tmp_path)
    path = tmp_path / "map.npy"
    path.write_bytes(content)
    try:
        assert words in str(reader.read(path, {})["raised"])
    finally:
        reader.close()


def test_the_judge_sees_other_scales(cases: dict[str, Sample]) -> None:
    case = cases["made.npy"]
    original = case.stated(case.content)
    good = {"heights": original.heights, "pixel": original.pixel}
    assert finding(case, original, case.content, good) == ""
    dy, dx = original.pixel
    for wrong in (
        {"pixel": (dx, dy)},
        {"pixel": (dy * 1.001, dx)},
        {"heights": original.heights * 1.001},
        {"heights": original.heights[:-1]},
        {"heights": np.where(np.isnan(original.heights), 0, original.heights)},
        {"pixel": (1.0, 1.0)},
        {"heights": original.heights * 1e6},
    ):
        assert finding(case, original, case.content, good | wrong)
    # One damaged byte may change one height.
    content = bytearray(case.content)
    content[-1] ^= 1
    other = original.heights.copy()
    other[-1, -1] *= 2
    assert finding(case, original, bytes(content), good | {"heights": other}) == ""
    other[0, 0] *= 2
    assert finding(case, original, bytes(content), good | {"heights": other})
    for refused in ("two\nlines", "another.npy is bad", "made.npy (MemoryError)"):
        assert finding(case, original, case.content, {"refused": refused, "cause": ""})


if __name__ == "__main__":
    serve()
