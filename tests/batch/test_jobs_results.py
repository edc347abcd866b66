"""Stored results of pieces: to the bit, and without executing the content of a file."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roughcontact._tools import checkpoints
from roughcontact.analyses.tasks import from_text
from roughcontact.batch import plan
from roughcontact.batch.plan import Entry
from roughcontact.cautions import Caution, CautionTag, as_note
from roughcontact.errors import ArgumentRef
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import RIGID, Material

FOUND = (
    None,
    True,
    3,
    0.1,
    -math.inf,
    "σ",
    [1, (2.0, [])],
    Boundary("free"),
    RIGID,
    Material(young=210e9, poisson=0.3, yield_strength=1e9, name="steel"),
    np.float64(0.1),
    np.int64(-7),
    np.arange(6.0, dtype=">f4").reshape(2, 3),
    np.zeros((0, 2)),
    {2: "two", (4, "four"): None},
    as_note(CautionTag.EDGE, "Of ", ArgumentRef("load", "1 N"), ".", size=1e-6),
)


@pytest.fixture
def entry(tmp_path: Path) -> Entry:
    given = {"load": "1 N", "unit": "um", "material": "bearing steel"}
    request = from_text("solve", tmp_path / "map.npy", given)
    return Entry("one", request, tmp_path / "results" / "one.json", 1)


def same(one: Any, other: Any) -> bool:
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray | np.generic):
        return one.dtype == other.dtype and checkpoints.checksum_array(
            one
        ) == checkpoints.checksum_array(other)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def rewrite_record(entry: Entry, change: Any) -> None:
    """Replace the content of a file, with its checksum."""
    file = entry.summary.with_suffix(".pieces") / "digest.json"
    read = json.loads(file.read_text(encoding="utf-8"))
    del read["seal"]
    change(read)
    file.write_text(json.dumps({**read, "seal": checkpoints.checksum_json(read)}), encoding="utf-8")


def known(entry: Entry, digest: str = "digest") -> Any:
    return plan.load_subtasks(entry, {"0": digest}).get("0")


def test_saved_subtask_is_identical(entry: Entry) -> None:
    plan.save_piece(entry, "digest", FOUND)
    plan.save_piece(entry, "second", math.pi)
    found = plan.load_subtasks(entry, {"0": "digest", "1": "absent", "2": "second"})
    assert found.keys() == {"0", "2"}
    assert same(found["0"], FOUND)
    assert isinstance(found["0"][-1], Caution)
    plan.remove_pieces(entry, ["second", "absent"])
    assert plan.load_subtasks(entry, {"0": "digest", "1": "absent", "2": "second"}) == {
        "2": math.pi
    }
    plan.remove_pieces(entry)
    assert not any(entry.summary.parent.iterdir())
    assert known(entry, "second") is None
    plan.remove_pieces(entry)


def test_object_unknown_to_json_is_not_saved(entry: Entry) -> None:
    plan.save_piece(entry, "digest", [1.0, {"a": object()}])
    assert known(entry) is None


def test_file_in_place_of_folder_saves_nothing(entry: Entry) -> None:
    entry.summary.parent.mkdir()
    place = entry.summary.with_suffix(".pieces")
    place.write_text("mine", encoding="utf-8")
    plan.save_piece(entry, "digest", 1.0)
    assert known(entry) is None
    plan.remove_pieces(entry)
    assert place.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    "found",
    [
        {"class": "subprocess:Popen", "fields": {"args": "touch done"}},
        {"class": "roughcontact.batch.plan:files", "fields": {}},
        {"class": "roughcontact.batch.plan:keep", "fields": {}},
        {"class": "roughcontact.batch.executors:LocalExecutor", "fields": {}},
        {"class": "roughcontact.nowhere:Material", "fields": {}},
        {"class": "roughcontact.material.material:Material", "fields": {"young": 1.0}},
        {"enum": "enum:Enum", "value": 1},
        {"enum": "roughcontact.material.material:Material", "value": 1},
        {"enum": "roughcontact.halfspace.boundary:Boundary", "value": "bananas"},
        {"array": "AAAA", "kind": "<f8", "shape": [1]},
        {"array": "AAAAAAAAAAA=", "kind": "O", "shape": [1]},
        {"bananas": 1},
    ],
    ids=lambda found: str(found)[:40],
)
def test_foreign_class_in_saved_subtask_is_not_created(entry: Entry, found: Any) -> None:
    plan.save_piece(entry, "digest", 1.0)
    rewrite_record(entry, lambda read: read.update(found=2.0))
    assert known(entry) == 2.0
    rewrite_record(entry, lambda read: read.update(found=[found]))
    assert known(entry) is None


def test_a_file_that_is_damaged_or_large_is_not_read(
    entry: Entry, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan.save_piece(entry, "digest", 1.0)
    file = entry.summary.with_suffix(".pieces") / "digest.json"
    whole = file.read_bytes()
    for content in (b"", whole[:-1], whole.replace(b"1.0", b"1.5"), b"[]", b"\xff", b"[" * 10**5):
        file.write_bytes(content)
        assert known(entry) is None
    file.write_bytes(whole)
    assert known(entry) == 1.0
    # Under another name it is not used.
    file.with_name("other.json").write_bytes(whole)
    assert known(entry, "other") is None
    monkeypatch.setattr(plan, "_MAX_PIECE_BYTES", len(whole) - 1)
    assert known(entry) is None
