"""Stores what tests take of a core: `python -m pytest -n auto -m "not slow" -p seconds`.

`test_seconds` reads it, so that no test depends on how busy a machine is. Tests that were not run
keep what was stored of them; one that takes less than a second of a core is not stored.
"""

from __future__ import annotations

import json
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest

STORED = Path(__file__).with_name("data") / "seconds.json"
LEAST = 1.0

_found: dict[str, float] = {}


def used() -> float:
    """Return what this process and its children that have ended took of all cores [s]."""
    usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in usage)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    before = used()
    try:
        return (yield)
    finally:
        item.user_properties.append(("seconds", used() - before))


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.when == "call":
        _found[report.nodeid] = float(dict(report.user_properties)["seconds"])  # type: ignore[arg-type]


def pytest_sessionfinish(session: pytest.Session) -> None:
    if not hasattr(session.config, "workerinput"):
        before = json.loads(STORED.read_text("utf-8")) if STORED.exists() else {}
        now = {**before, **_found}
        kept = {name: round(now[name], 1) for name in sorted(now) if now[name] >= LEAST}
        STORED.write_text(json.dumps(kept, indent=0, ensure_ascii=False) + "\n", encoding="utf-8")
