"""Both ceilings in every task: three yield strengths first, the calibrated one second."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roughcontact._tools.files import to_json
from roughcontact.analyses.tasks import TASKS
from roughcontact.report.presentation import presentation_of
from roughcontact.request.request import Request
from roughcontact.request.run import run_request

LOAD = {"load": "60 MPa"}
RANGE = {"from": "30 MPa", "to": "60 MPa", "steps": "2"}
ASKED: dict[str, dict[str, str]] = {
    "solve": LOAD,
    "sweep": RANGE,
    "find": {"contact-fraction": "3 %"},
    "leak": LOAD,
    "conductance": {**LOAD, "conductivity": "40 W/m/K", "counter-conductivity": "40 W/m/K"},
    "law": RANGE,
    "tangential": {**LOAD, "friction": "0.3", "force": "0.05 N"},
    "stress": LOAD,
    "history": {"path": "0.6 N, 0 N"},
    "wear": {**LOAD, "wear": "1e-15 m2/N", "distance": "1 mm"},
    "estimate": {"pressure": "60 MPa"},
}


@pytest.fixture(scope="module")
def waves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a map of 100 µm whose waves are resolved by 12 pixels."""
    rng, points = np.random.default_rng(4), 72
    y, x = np.mgrid[:points, :points] * (2 * np.pi / points)
    orders = [(j, k) for j in range(7) for k in range(-6, 7) if 2 < j**2 + k**2 <= 36]
    heights = sum(
        rng.normal() * np.cos(j * y + k * x + rng.uniform(0, 2 * np.pi)) / (j**2 + k**2)
        for j, k in orders
    )
    path = tmp_path_factory.mktemp("waves") / "waves.npy"
    np.save(path, 0.2 * heights / np.std(heights))
    return path


def run(name: str, path: Path, ceiling: str) -> tuple[Any, dict[str, Any]]:
    """Return the headline and the JSON record of a task."""
    options = {
        **({} if name == "estimate" else {"boundary": "periodic"}),
        "unit": "um",
        "size": "0.1 mm",
        "young": "210 GPa",
        "poisson": "0.3",
        "yield-strength": "1 GPa",
        "ceiling": ceiling,
        **ASKED[name],
    }
    (task,) = (item for item in TASKS if item.name == name)
    request = Request.from_text(task, path, options)
    outcome = run_request(request, lambda _: None)
    return presentation_of(outcome.result).headline(), json.loads(to_json(outcome.record()))


def ceilings_in(record: Any) -> list[float]:
    """Return the second ceilings of a record, at any depth."""
    if isinstance(record, list):
        return [limit for item in record for limit in ceilings_in(item)]
    if not isinstance(record, dict):
        return []
    own = record.get("calibrated")
    return [
        *([own["ceiling"]] if isinstance(own, dict) else []),
        *(limit for item in record.values() for limit in ceilings_in(item)),
    ]


@pytest.mark.parametrize("name", ASKED)
def test_every_task_shows_both_ceilings(name: str, waves: Path) -> None:
    headline, record = run(name, waves, "auto")
    assert any("calibrated" in str(part).lower() for part in (headline.heads, headline.remarks))
    limits = ceilings_in(record)
    assert limits
    assert all(1.6e9 < limit < 2.9e9 for limit in limits)


@pytest.mark.parametrize("name", ASKED)
def test_every_task_accepts_the_calibrated_ceiling(name: str, waves: Path) -> None:
    headline, _ = run(name, waves, "calibrated")
    assert headline.answer
    assert "ceiling not studied" not in str(headline.remarks)
