"""Stored times and memory: what is worse is named."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType

import pytest

from paths import ROOT


@pytest.fixture
def record(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    return importlib.import_module("record")


ROWS = {"contact": {"seconds": 0.5, "pairs": 10.0, "above": 80.0}}


def change_values(**values: float) -> dict[str, dict[str, float]]:
    """Return the rows with other values."""
    return {"contact": {**ROWS["contact"], **values}}


def test_more_than_a_tenth_above_is_named(record: ModuleType) -> None:
    assert record.find_slower(change_values(pairs=10.9, above=87.0), ROWS) == []
    # The machine was slower, the program not.
    assert record.find_slower(change_values(seconds=5.0), ROWS) == []
    assert record.find_slower(change_values(pairs=11.1), ROWS) == ["contact: 11.1 T_pair, was 10"]
    assert record.find_slower(change_values(above=89.0), ROWS) == ["contact: 89 MB, was 80"]
    # A few megabytes are the allocator's.
    assert record.find_slower(change_values(above=4.0), change_values(above=1.0)) == []
    assert record.find_slower(change_values(pairs=99.0), {}) == []


def test_kept_replaces_record_of_same_version_and_day(
    record: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record, "RECORD", tmp_path / "record.json")
    first = {"date": "2026-01-01", "version": "0.1.0", "machine": "", "rows": ROWS}
    second = {**first, "date": "2026-02-01", "rows": change_values(pairs=9.0)}
    third = {**second, "version": "0.2.0"}
    record.store_record(second, [first, {**second, "rows": change_values(pairs=8.0)}])
    assert json.loads(record.RECORD.read_text(encoding="utf-8")) == [first, second]
    record.store_record(third, [first, second])
    assert json.loads(record.RECORD.read_text(encoding="utf-8")) == [first, second, third]


def test_stored_records_and_growth_match_the_tasks(record: ModuleType) -> None:
    records = json.loads(record.RECORD.read_text(encoding="utf-8"))
    assert [kept["date"] for kept in records] == sorted(kept["date"] for kept in records)
    assert {make for make, _ in record.GROWING.values()} < {t[0] for t in record.TASKS.values()}
