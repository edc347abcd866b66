"""What every change runs is quick: a test that takes long is marked, and run by another command."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import seconds

ROOT = Path(__file__).parents[1]
MARKS = ("long", "process", "slow")
MOST = 2.0


def test_no_test_without_a_mark_takes_long(request: pytest.FixtureRequest) -> None:
    stored = json.loads(seconds.STORED.read_text("utf-8"))
    assert [
        item.nodeid
        for item in request.session.items
        if stored.get(item.nodeid, 0.0) > MOST and not any(map(item.get_closest_marker, MARKS))
    ] == []


def test_every_test_whose_time_is_stored_exists() -> None:
    stored = json.loads(seconds.STORED.read_text("utf-8"))
    named = {tuple(name.partition("[")[0].split("::")) for name in stored if ".py::test_" in name}
    assert len(named) > 50
    for file, name in named:
        assert re.search(rf"^def {name}\(", (ROOT / file).read_text("utf-8"), re.MULTILINE), name
