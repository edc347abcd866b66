"""The cases behind the formulas go through the engines of projects."""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "calibration"))

import atlas
import atlas_cases
from roughcontact.analyses.tasks import LOCAL


@pytest.mark.slow
def test_cases_are_returned_from_other_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "ceiling.csv"
    monkeypatch.setitem(atlas.COLUMNS, place, atlas.COLUMNS[atlas.CEILING])
    atlas.prepare_table(place)
    drawn = replace(atlas_cases.maps()[0], points=64, breadth=1.2)
    done = set(range(atlas_cases.CASES)) - {3, 5}
    task = (place, atlas_cases.ceilings, drawn, done)
    # A map that cannot be made.
    bad = (place, atlas_cases.ceilings, replace(drawn, points=0), done)
    monkeypatch.setattr(atlas, "missing_tasks", lambda most: [task, bad])
    atlas.compute(None, LOCAL, 1, None)
    output = sorted(capsys.readouterr().out.splitlines(), key=len)
    assert output[0].endswith(f"{drawn.name} solved")
    assert "failed: " in output[1]
    with place.open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert [int(row["case"]) for row in rows] == [3, 5]
    for row, (_, same) in zip(rows, atlas_cases.ceilings(drawn, done), strict=True):
        assert {name: row[name] for name in same} == {
            name: f"{value:.6g}" for name, value in same.items()
        }
