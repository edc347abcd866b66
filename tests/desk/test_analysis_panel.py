from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel", reason="needs roughcontact[desk]")

import panel as pn

from roughcontact.desk.analysis_jobs import JOINTS, run_analyses
from roughcontact.desk.analysis_panel import JointPanel
from roughcontact.desk.session import Session
from roughcontact.desk.workers import WorkerPool
from roughcontact.request import contacts

PATIENCE = 60.0
GIVEN = {
    "material": "42CrMo4",
    "counter-material": "6061-T6",
    "boundary": "periodic",
    "load": "1 MPa",
}


RANGE = {"from_": "1 MPa", "to_": "10 MPa", "steps_": "2"}


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
        self.session.give_all({**GIVEN, **more})
        assert self.session.wait(PATIENCE)
        (folder / "made").mkdir()
        self.joint = JointPanel(
            self.session,
            bench,
            self.waiting.append,
            folder / "made",
            lambda path: f"at/{path.name}",
        )

    def start(self) -> None:
        """Press the button, and let the page show what comes."""
        self.joint._started()
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
        return "".join(str(part.object) for part in self.joint._answers.root)


@pytest.fixture
def bench() -> Iterator[WorkerPool]:
    made = WorkerPool(spare=False)
    yield made
    made.close()


@pytest.mark.slow
def test_joint_analyses_show_results_and_commands(tmp_path: Path, bench: WorkerPool) -> None:
    seat = Seat(tmp_path, bench)
    for name, text in RANGE.items():
        seat.joint._set_range_option(name.strip("_"), text)
    seat.start()
    assert seat.said.count("Done in") == 1, seat.said
    for task, question in JOINTS:
        assert question.name in seat.shown
        assert f"roughcontact {task.name} " in seat.shown
    figures = [part for part in seat.joint._answers.root if isinstance(part, pn.pane.Bokeh)]
    assert len(figures) >= len(JOINTS)
    assert "W/(m² K)" in seat.shown
    for name in ("law-1.inp", "law-1.ccx", "conductance-1.csv"):
        assert f'<a href="at/{name}" download>' in seat.shown
        assert (tmp_path / "made" / name).stat().st_size > 100
    assert "--output" not in seat.shown
    # Both pressures.
    assert seat.shown.count("<tr>") > 2 * len(JOINTS)
    seat.session.close()


def test_formulas_are_shown_for_nominally_flat_contact(tmp_path: Path, bench: WorkerPool) -> None:
    heights = rc.self_affine(
        (128, 128),
        (1e-6, 1e-6),
        rms_height=0.3e-6,
        rolloff_wavelength=16e-6,
        cutoff_wavelength=4e-6,
        rng=np.random.default_rng(1),
    )
    seat = Seat(tmp_path, bench, heights, load="30 MPa")
    seat.joint.refresh()
    assert "Real contact by formula" in str(seat.joint._formulas.object)
    seat.session.set_option("boundary", "free")
    assert seat.session.wait(PATIENCE)
    seat.joint.refresh()
    assert "No estimate" in str(seat.joint._formulas.object)
    seat.session.close()


def test_invalid_input_is_reported_in_one_sentence(tmp_path: Path, bench: WorkerPool) -> None:
    seat = Seat(tmp_path, bench, **{"counter-material": "PEEK"})
    for name, box in seat.joint._boxes.items():
        box.value = name == "Conductance"
    seat.start()
    assert "PEEK has none" in seat.said
    for box in seat.joint._boxes.values():
        box.value = False
    seat.start()
    assert "at least one analysis" in seat.said
    with pytest.raises(rc.InputError, match="from"):
        seat.joint._set_range_option("from", "1 banana")
    seat.session.close()


@pytest.mark.slow
def test_joint_analyses_share_solved_contacts(
    tmp_path: Path, bench: WorkerPool, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Elastic, so that the law has no second branch of its own.
    seat = Seat(tmp_path, bench, ceiling="none")
    solved: list[float] = []
    fresh = contacts.solve_uncalibrated

    def record_load(surface: rc.Surface, **options: Any) -> Any:
        solved.append(options["load"])
        return fresh(surface, **options)

    monkeypatch.setattr(contacts, "solve_uncalibrated", record_load)
    requests = [seat.session.state.request(task, **RANGE) for task, question in JOINTS]
    found = run_analyses(lambda _: None, *requests)
    assert len(found) == len(JOINTS)
    assert len(solved) == len(set(solved)) == 2
    seat.session.close()


def test_every_option_of_the_questions_is_one_of_their_tasks() -> None:
    for task, question in JOINTS:
        assert set(question.options) <= set(task.options)
