from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel", reason="needs roughcontact[desk]")

from roughcontact.desk.analysis_jobs import ANALYSES, JOINTS
from roughcontact.desk.job_panels import AnalysisPanel
from roughcontact.desk.session import Session
from roughcontact.desk.workers import WorkerPool
from visits import give_all

PATIENCE = 60.0
GIVEN = {
    "material": "42CrMo4",
    "counter-material": "6061-T6",
    "boundary": "periodic",
    "load": "1 MPa",
}


class Seat:
    """A tab on a session that has solved its contact."""

    def __init__(
        self, folder: Path, bench: WorkerPool, heights: np.ndarray | None = None, **more: str
    ) -> None:
        if heights is None:
            heights = 1e-7 * np.random.default_rng(1).standard_normal((24, 32))
        rc.Surface(heights, (1e-6, 1e-6)).save(folder / "map.npz")
        self.waiting: list[Callable[[], None]] = []
        self.session = Session(folder / "project.toml", lambda _: None)
        self.session.open_map(folder / "map.npz")
        give_all(self.session, {**GIVEN, **more})
        assert self.session.wait(PATIENCE)
        (folder / "made").mkdir()
        visit: Any = SimpleNamespace(
            workers=bench, folder=folder / "made", offer=lambda path: f"at/{path.name}"
        )
        self.joint = AnalysisPanel(
            self.session, visit, self.waiting.append, self.session.set_option, is_joint=True
        )

    def start(self, name: str) -> None:
        """Press the button of an analysis, and let the page show what comes."""
        self.joint._choice.value = name
        self.joint._working.start()
        last = time.monotonic() + PATIENCE
        while self.joint._working._job is not None and time.monotonic() < last:
            while self.waiting:
                self.waiting.pop(0)()
            time.sleep(0.02)

    @property
    def said(self) -> str:
        return str(self.joint._working._status.object)

    @property
    def shown(self) -> str:
        return "".join(str(part.object) for part in self.joint._answer[0])


@pytest.fixture
def bench() -> Iterator[WorkerPool]:
    made = WorkerPool(spare=False)
    yield made
    made.close()


@pytest.mark.slow
def test_joint_analyses_show_results_and_commands(tmp_path: Path, bench: WorkerPool) -> None:
    seat = Seat(tmp_path, bench)
    for number, (task, question) in enumerate(JOINTS, 1):
        form = seat.joint._forms[question.name]
        for name, text in (("to", "10 MPa"), ("steps", "2")):
            form.set_option(name, text)
        seat.start(question.name)
        assert "Done in" in seat.said, seat.said
        assert f"roughcontact {task.name} " in seat.shown
        assert "--output" not in seat.shown
        assert '<img class="figure"' in seat.shown
        # Both pressures.
        assert seat.shown.count("<tr>") > 2
        files = [path.name for path in (tmp_path / "made").glob(f"{task.name}-{number}.*")]
        for name in files:
            assert f'<a href="at/{name}" download>' in seat.shown
            assert (tmp_path / "made" / name).stat().st_size > 100
        assert ("law-1.inp" in files) == (number == 1)
    seat.session.close()


def test_formulas_are_shown_for_nominally_flat_contact(tmp_path: Path, bench: WorkerPool) -> None:
    seat = Seat(tmp_path, bench, rc.reference_map(128)[0], load="30 MPa")
    seat.joint.refresh()
    assert "Real contact by formula" in str(seat.joint._formulas.object)
    seat.session.set_option("boundary", "free")
    assert seat.session.wait(PATIENCE)
    seat.joint.refresh()
    assert seat.joint._formulas.object == ""
    seat.session.close()


def test_invalid_input_is_reported_in_one_sentence(tmp_path: Path, bench: WorkerPool) -> None:
    seat = Seat(tmp_path, bench, **{"counter-material": "PEEK"})
    seat.start("Conductance")
    assert "PEEK has none" in seat.said
    with pytest.raises(rc.InputError, match="from"):
        seat.joint._forms["Conductance"].set_option("from", "1 banana")
    seat.session.close()


def test_analyses_have_at_most_six_options_of_their_task_in_sight() -> None:
    for task, question in (*JOINTS, *ANALYSES):
        assert {*question.options, *question.folded} <= set(task.options)
        assert len(question.options) <= 6, question.name
