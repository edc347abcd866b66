"""The reference set: the program agrees with it, and the judge notices what does not."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from paths import ROOT

FOLDER = ROOT / "reference"
DESCRIBED = json.loads((FOLDER / "problems.json").read_text(encoding="utf-8"))
# A search for the limit of shakedown takes minutes.
MARKS = {"plasticity": pytest.mark.long, "rolling": pytest.mark.slow}


def module(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"reference_{name}", FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    # Its dataclasses look their module up.
    loaded = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def judge_answers(answers: dict[str, Any], folder: Path) -> int:
    file = folder / "answers.json"
    file.write_text(json.dumps(answers), encoding="utf-8")
    return module("judge").main(file)


@pytest.mark.parametrize("name", [pytest.param(n, marks=MARKS.get(n, ())) for n in DESCRIBED])
def test_the_program_agrees_with_the_set(name: str, tmp_path: Path) -> None:
    found = module("generate").answers([name])
    assert set(found[name]) == set(DESCRIBED[name]["answers"])
    assert judge_answers(found, tmp_path) == 0


def references(name: str) -> dict[str, Any]:
    """Return the reference values of a problem as answers."""
    values = {key: answer["value"] for key, answer in DESCRIBED[name]["answers"].items()}
    if None in values.values():
        with np.load(FOLDER / f"{name}.npz") as arrays:
            values |= {key: arrays[key].tolist() for key, v in values.items() if v is None}
    return values


@pytest.mark.parametrize("name", DESCRIBED)
def test_an_answer_that_is_off_is_noticed(name: str, tmp_path: Path) -> None:
    assert judge_answers({name: references(name)}, tmp_path) == 0
    for quantity, value in references(name).items():
        accept = DESCRIBED[name]["answers"][quantity]["accept"]
        for share, wrong in ((0.5, 0), (1.5, 1)):
            off = (np.asarray(value) * (1 + share * accept)).tolist()
            assert judge_answers({name: {quantity: off}}, tmp_path) == wrong, quantity


def test_arrays_may_be_files_of_the_right_shape(tmp_path: Path) -> None:
    with np.load(FOLDER / "tilt.npz") as arrays:
        np.save(tmp_path / "right.npy", arrays["pressure"])
        np.save(tmp_path / "wrong.npy", arrays["pressure"][1:])
    assert judge_answers({"tilt": {"pressure": "right.npy"}}, tmp_path) == 0
    assert judge_answers({"tilt": {"pressure": "wrong.npy"}}, tmp_path) == 1


def test_the_set_is_small_and_complete() -> None:
    assert sum(file.stat().st_size for file in FOLDER.glob("*.*")) < 2e6
    assert len(DESCRIBED) == 12
    text = (FOLDER / "judge.py").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 60
    assert "scipy" not in text
    for name, problem in DESCRIBED.items():
        assert (FOLDER / f"{name}.npz").exists() == bool(problem["arrays"])
        for answer in problem["answers"].values():
            assert 0 < answer["error"] <= answer["accept"]
