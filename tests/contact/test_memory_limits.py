import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import memory
from roughcontact.analyses.history.model import repeat_stages
from roughcontact.analyses.history.task import PASSES
from roughcontact.analyses.tasks import COMMANDS, from_text
from roughcontact.errors import (
    FormatError,
    InputError,
    InsufficientMemoryError,
    require_count,
    short_repr,
)
from roughcontact.surface import shapes

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
MAP_FILE = Path("map.csv")
MAP = rc.Surface(np.eye(16) * 1e-9, (1e-6, 1e-6))


def leave(monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    monkeypatch.setattr(memory, "free_bytes", lambda: size)


# Sizes in files


def test_points_of_a_map(monkeypatch: pytest.MonkeyPatch) -> None:
    leave(monkeypatch, 2**60)
    memory.require_points("map.sur", (2**15, 2**15), 40)
    with pytest.raises(FormatError, match=r"^map.sur announces 32768 × 32769 points, more than"):
        memory.require_points("map.sur", (2**15, 2**15 + 1), 40)
    leave(monkeypatch, 40 * 2**20 - 1)
    with pytest.raises(
        InsufficientMemoryError,
        match=r"^reading the 1024 × 1024 points of map.sur needs about 0.0 GiB, and 0.0 GiB are",
    ):
        memory.require_points("map.sur", (1024, 1024), 40)
    leave(monkeypatch, 40 * 2**20)
    memory.require_points("map.sur", (1024, 1024), 40)


def test_bytes_of_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    leave(monkeypatch, 2**60)
    memory.require_size("map.x3p", memory.BYTES)
    with pytest.raises(FormatError, match=r"^map.x3p holds 8.0 GiB, more than the 8 GiB"):
        memory.require_size("map.x3p", memory.BYTES + 1)
    # A flat map packs a thousand times smaller, and is small.
    memory.require_size("map.x3p", 2**30, packed=2**20)
    memory.require_size("map.x3p", 2**32, packed=2**26)
    with pytest.raises(FormatError, match=r"holds 4.0 GiB or more, packed into 32.0 MiB as no"):
        memory.require_size("map.x3p", 2**32, packed=2**25)
    leave(monkeypatch, 2**20 - 1)
    with pytest.raises(InsufficientMemoryError, match=r"^reading map.x3p needs"):
        memory.require_size("map.x3p", 2**20)


# Sizes in arguments


@pytest.mark.parametrize("value", [0, -1, 11, 10**30, 2.0, "3", None, math.inf])
def test_count_error_states_name_value_and_bounds(value: object) -> None:
    require_count(1, 10, first=1, last=10, numpy=np.int64(4))
    with pytest.raises(InputError) as caught:
        require_count(1, 10, good=3, turns=value)
    assert (
        str(caught.value) == f"turns must be a whole number from 1 to 10, got {short_repr(value)}"
    )
    assert (caught.value.argument, caught.value.value) == ("turns", value)


@pytest.mark.parametrize(
    ("argument", "ask"),
    [
        ("count", lambda: repeat_stages([1.0, 0.0], 5001)),
        ("max_iterations", lambda: rc.solve(MAP, material=STEEL, load=1e-3, max_iterations=10**9)),
        (
            "increments",
            lambda: rc.solve_elastoplastic(MAP, material=STEEL, load=1e-3, increments=10**9),
        ),
        (
            "max_iterations",
            lambda: rc.solve_elastoplastic(MAP, material=STEEL, load=1e-3, max_iterations=10**9),
        ),
        ("shape", lambda: shapes.flat((10**5, 10**5), (1e-6, 1e-6))),
        ("shape", lambda: shapes.sphere((10**9, 2), (1e-6, 1e-6), 1.0)),
        ("shape", lambda: rc.reference_map(10**6)),
        ("shape", lambda: MAP.resampled(shape=(10**5, 10**5))),
        ("pixel", lambda: MAP.resampled(pixel=(1e-12, 1e-12))),
        ("pixel", lambda: MAP.resampled(pixel=(1e-320, 1e-320))),
        ("shape", lambda: MAP.resampled(shape=(10**400, 2))),
        ("shape", lambda: MAP.resampled(shape=tuple(np.array([2**40, 2**40])))),
    ],
)
def test_huge_counts_raise_input_error(
    argument: str, ask: Callable[[], object], monkeypatch: pytest.MonkeyPatch
) -> None:
    leave(monkeypatch, 2**60)
    with pytest.raises(InputError) as caught:
        ask()
    assert caught.value.argument == argument
    assert caught.value.value is not None


@pytest.mark.parametrize(
    ("command", "name", "text"),
    [
        ("sweep", "steps", "1000000000"),
        ("history", "passes", "100000000"),
        ("solve", "increments", "1000000000"),
        ("solve", "points", "1000000000"),
        ("solve", "points", "40000x40000"),
        ("solve", "points", "1" * 5000),
        ("solve", "crop", f"0:{'1' * 5000},0:1"),
        ("solve", "form", f"polynomial {'1' * 5000}"),
        ("solve", "max-iterations", "1000000000"),
        ("solve", "max-iterations", "1" * 5000),
        ("stress", "max-iterations", "0"),
        ("demo", "points", "40000"),
    ],
)
def test_options_have_the_same_bounds(command: str, name: str, text: str) -> None:
    with pytest.raises(InputError) as caught:
        COMMANDS[command].parse_options({name: text})
    assert caught.value.argument == name.replace("-", "_")


def test_passes_count_every_stage() -> None:
    given = {"path": "1 N, 0 N", "material": "100Cr6", "passes": "5000"}
    assert from_text("history", MAP_FILE, given)[PASSES] == 5000
    with pytest.raises(InputError, match="passes must be a whole number from 1 to 5000, got 5001"):
        from_text("history", MAP_FILE, {**given, "passes": "5001"})
