"""Files that need more memory than any machine has are rejected at once.

They are read by a second process under a limit of time and of memory, see `bounded_reader`.
"""

import re
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import samples
from bounded_reader import Reader, wrong_in_message
from samples import Sample

NUMBERS = (2**15 - 1, 2**16 - 1, 2**31 - 1, 2**32 - 1, 2**48)


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reader]:
    pytest.importorskip("resource", reason="limits of memory are POSIX")
    reader = Reader(tmp_path_factory.mktemp("reader"))
    yield reader
    reader.close()


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> list[Sample]:
    return [*samples.made(tmp_path_factory.mktemp("made")), *samples.measured()]


def enlarge(sample: Sample, rng: np.random.Generator) -> bytes:
    """Return a file with a number in its header that is huge."""
    fields = sample.fields or ((0, len(sample.content)),)
    start, stop = fields[int(rng.integers(len(fields)))]
    field = sample.content[start:stop]
    words = list(re.finditer(rb"\d+", field))
    if words and rng.random() < 0.5:
        word = words[int(rng.integers(len(words)))]
        field = field[: word.start()] + b"9" * int(rng.integers(5, 20)) + field[word.end() :]
    else:
        number = NUMBERS[int(rng.integers(len(NUMBERS)))]
        width = 2 if number < 2**16 else 4 if number < 2**32 else 8
        packed = number.to_bytes(width, "little" if rng.random() < 0.7 else "big")
        at = int(rng.integers(max(len(field) - width, 0) + 1))
        field = field[:at] + packed + field[at + width :]
    return sample.content[:start] + field + sample.content[stop:]


def findings(reader: Reader, samples: list[Sample], folder: Path, count: int) -> list[str]:
    found = []
    for sample in samples:
        path = folder / sample.name
        for index in range(count):
            rng = np.random.default_rng([zlib.crc32(sample.name.encode()), index])
            path.write_bytes(enlarge(sample, rng))
            answer = reader.read(path, sample.arguments)
            wrong = str(answer.get("raised", ""))
            if "refused" in answer:
                wrong = wrong_in_message(sample, answer)
            if wrong:
                found.append(f"{sample.name} #{index}: {wrong}")
    return found


@pytest.mark.slow
def test_huge_numbers_in_headers(reader: Reader, every: list[Sample], tmp_path: Path) -> None:
    assert not findings(reader, every, tmp_path, 5)


@pytest.mark.slow
def test_many_huge_numbers(reader: Reader, every: list[Sample], tmp_path: Path) -> None:
    assert not findings(reader, every, tmp_path, 200)


def test_files_of_a_terabyte(reader: Reader, every: list[Sample], tmp_path: Path) -> None:
    # All of it a hole: it takes no room on the disk.
    for sample in every:
        path = tmp_path / sample.name
        path.write_bytes(sample.content)
        with path.open("r+b") as stream:
            try:
                stream.truncate(2**40)
            except OSError as error:
                pytest.skip(f"no file of that size can be made here: {error}")
        answer = reader.read(path, sample.arguments)
        path.unlink()
        assert "raised" not in answer, (sample.name, answer)
        if "refused" in answer:
            assert not wrong_in_message(sample, answer), (sample.name, answer)
        else:
            # HDF5 stores the end of its file.
            assert sample.name.endswith(".nc")


def test_map_larger_than_memory_raises_error(
    reader: Reader, every: list[Sample], tmp_path: Path
) -> None:
    (sample,) = (sample for sample in every if sample.name == "made.sur")
    head = bytearray(sample.content[:525])
    struct.pack_into("<iiI", head, 108, 30000, 30000, 30000**2)
    path = tmp_path / "made.sur"
    path.write_bytes(head)
    with path.open("r+b") as stream:
        stream.truncate(525 + 4 * 30000**2)
    refused = str(reader.read(path, {})["refused"])
    assert re.fullmatch(r"reading the 30000 × 30000 points of made.sur needs about .*", refused)
