"""The numbers that stay: what is worse is named, and the page shows what is kept."""

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


def now(**values: float) -> dict[str, dict[str, float]]:
    """Return the rows with other values."""
    return {"contact": {**ROWS["contact"], **values}}


def test_more_than_a_tenth_above_is_named(record: ModuleType) -> None:
    assert record.worse(now(pairs=10.9, above=87.0), ROWS) == []
    # The machine was slower, the program not.
    assert record.worse(now(seconds=5.0), ROWS) == []
    assert record.worse(now(pairs=11.1), ROWS) == ["contact: 11.1 T_pair, was 10"]
    assert record.worse(now(above=89.0), ROWS) == ["contact: 89 MB, was 80"]
    # A few megabytes are the allocator's.
    assert record.worse(now(above=4.0), now(above=1.0)) == []
    assert record.worse(now(pairs=99.0), {}) == []


def test_a_record_is_kept_beside_those_before_and_shown(
    record: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- record -->\nold\n<!-- record end -->\nafter\n", encoding="utf-8")
    monkeypatch.setattr(record, "PAGE", page)
    monkeypatch.setattr(record, "RECORD", tmp_path / "record.json")
    first = {"date": "2026-01-01", "version": "0.1.0", "machine": "", "rows": ROWS}
    record.kept(first, [])
    second = {**first, "date": "2026-02-01", "rows": now(pairs=9.0)}
    record.kept(second, [first])
    # Once more on the same day; what the version before took that day stays.
    record.kept(second, [first, {**second, "rows": now(pairs=8.0)}])
    assert json.loads(record.RECORD.read_text(encoding="utf-8")) == [first, second]
    third = {**second, "version": "0.2.0"}
    record.kept(third, [first, second])
    assert json.loads(record.RECORD.read_text(encoding="utf-8")) == [first, second, third]
    shown = page.read_text(encoding="utf-8")
    assert shown.startswith("before\n")
    assert shown.endswith("after\n")
    assert "| contact | 0.5 s, 10 T_pair, 80 MB | 0.5 s, 9 T_pair, 80 MB |" in shown
    assert "old" not in shown


def test_the_page_shows_the_record(record: ModuleType) -> None:
    records = json.loads(record.RECORD.read_text(encoding="utf-8"))
    assert record.table(records) in record.PAGE.read_text(encoding="utf-8")
    assert [kept["date"] for kept in records] == sorted(kept["date"] for kept in records)


def test_growth_is_shown_by_grid_and_task(record: ModuleType) -> None:
    row = {"seconds": 0.1234, "pairs": 4.567, "bytes": 89.4}
    found = {"solve": {256: row, 512: row}, "volume": {32: row, 256: row}}
    cells = "0.123 s, 4.57 T_pair, 89 B"
    assert record.growth_table(found).splitlines() == [
        "| points | solve | volume |",
        "|---|---|---|",
        f"| 32² | – | {cells} |",
        f"| 256² | {cells} | {cells} |",
        f"| 512² | {cells} | – |",
    ]
    assert {make for make, _ in record.GROWING.values()} < {t[0] for t in record.TASKS.values()}
