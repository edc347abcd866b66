"""That `benchmarks/same.py` sees one digit that changes, in every case of a task."""

import copy
import dataclasses
import functools
import re

import numpy as np
import pytest

import roughcontact as rc
import same
from items import is_compared

PYTHON = (
    "leakage",
    "conductance",
    "law",
    "find-load",
    "rolling",
    "estimate",
    "generation",
    "profile",
    "comparison",
)
COMMANDS = (
    "tasks",
    "leak",
    "conductance",
    "law",
    "find",
    "roll",
    "estimate",
    "generate",
    "profile",
    "compare",
    "verify",
)
QUICK = ("leakage", "conductance", "estimate")
# Where digits may change: wall times.
TIMES = re.compile(r"time of|seconds|\b(took|after|for) \d|\d m?s\b")


def cases(names, quick=()):
    return [pytest.param(name, marks=[] if name in quick else pytest.mark.slow) for name in names]


def nudged(value):
    """Return a value with the last digit of one number changed, or None where it has none."""
    if isinstance(value, float) and np.isfinite(value):
        return float(np.nextafter(value, np.inf))
    if isinstance(value, np.ndarray) and value.dtype.kind == "f" and np.isfinite(value).any():
        changed = value.copy()
        where = tuple(np.argwhere(np.isfinite(value))[-1])
        changed[where] = np.nextafter(value[where], value.dtype.type(np.inf))
        return changed
    if isinstance(value, rc.Provenance):  # as text
        return None
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            changed = nudged(getattr(value, field.name)) if is_compared(field.name) else None
            if changed is not None:
                result = copy.copy(value)
                object.__setattr__(result, field.name, changed)
                return result
    if isinstance(value, dict | list | tuple):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, entry in pairs:
            changed = nudged(entry)
            if changed is not None:
                result = dict(value) if isinstance(value, dict) else list(value)
                result[key] = changed
                return result
    return None


@pytest.mark.parametrize("name", cases(PYTHON, QUICK))
def test_one_digit_of_a_result_is_seen(name, tmp_path):
    values = same.CASES[f"py-{name}"](tmp_path)
    before = same.collect_items(functools.partial(dict, values), tmp_path, {})
    assert "failed" not in before
    assert before == same.collect_items(functools.partial(dict, values), tmp_path, {})
    for key, value in values.items():
        changed = values | {key: nudged(value)}
        after = same.collect_items(functools.partial(dict, changed), tmp_path, {})
        assert before.keys() == after.keys()
        seen = {item for item in before if before[item] != after[item]}
        assert seen, key
        assert all(item.startswith(key) for item in seen)


@pytest.mark.parametrize("name", cases(COMMANDS))
def test_change_of_one_printed_digit_is_found(name, tmp_path):
    same.write_inputs(tmp_path)
    for key, text in same.run_commands(name, tmp_path).items():
        assert "exit status 0\n" in text
        lost = set()
        for line in text.splitlines():
            before = same.normalize_text(line, tmp_path)
            for found in re.finditer(r"\d", line):
                at = found.start()
                changed = f"{line[:at]}{(int(found[0]) + 1) % 10}{line[at + 1 :]}"
                if same.normalize_text(changed, tmp_path) == before:
                    lost.add(line)
        assert [line for line in lost if not TIMES.search(line)] == [], key


def test_a_case_that_differs_is_named(tmp_path):
    for state, number in (("old", 1.5), ("new", 1.6)):
        items = {"result": f"{number} N", "rest": "2 N"}
        same.store(tmp_path / state, [("py-one", items), ("py-two", {"result": "3 N"})])
    (found,) = same.differences(tmp_path / "old", tmp_path / "new", "*")
    assert found.startswith("py-one/result: differs")
