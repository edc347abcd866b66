"""Reading touches nothing that other threads share."""

import logging
import sys
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

import samples
from reading import needs_reader
from roughcontact.formats.read import read_surface

pytestmark = needs_reader


def state() -> tuple[object, ...]:
    """Return the global state that libraries change temporarily."""
    return (
        sys.stdout,
        sys.stderr,
        sys.excepthook,
        warnings.showwarning,
        list(warnings.filters),
        Path.cwd(),
        np.geterr(),
        np.get_printoptions(),
        logging.root.level,
        list(logging.root.handlers),
        logging.lastResort,
    )


@pytest.mark.long
def test_many_threads_read_and_leave_everything_as_it_is(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    files = []
    for sample in (*samples.made(tmp_path), *samples.measured()):
        path = tmp_path / sample.name
        path.write_bytes(sample.content)
        # Alone first: importing a library may set its filters.
        files.append((path, sample.arguments, read_surface(path, **sample.arguments)))
    before, seen, wrong = state(), set(), []
    start = threading.Barrier(len(files))

    def read(path: Path, arguments: dict[str, str], expected: object) -> None:
        start.wait()
        for _ in range(3):
            try:
                surface = read_surface(path, **arguments)
                np.testing.assert_array_equal(surface.heights, expected.heights)  # type: ignore[attr-defined]
            except Exception as error:
                wrong.append(f"{path.name}: {error!r}")
            seen.add((id(sys.stdout), id(sys.stderr)))

    threads = [threading.Thread(target=read, args=file) for file in files]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
    assert state() == before
    assert seen == {(id(sys.stdout), id(sys.stderr))}
    assert capfd.readouterr() == ("", "")


def test_another_thread_may_print(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sample = next(sample for sample in samples.made(tmp_path) if sample.name == "made.x3p")
    path = tmp_path / sample.name
    path.write_bytes(sample.content)
    done = threading.Event()

    def talk() -> None:
        for number in range(100_000):
            print(number)
            if done.is_set():
                return

    talker = threading.Thread(target=talk)
    talker.start()
    for _ in range(20):
        read_surface(path)
    done.set()
    talker.join()
    lines = capsys.readouterr().out.splitlines()
    assert lines == [str(number) for number in range(len(lines))]
