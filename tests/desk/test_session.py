from __future__ import annotations

import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings, strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

import roughcontact as rc
from roughcontact.analyses.tasks import from_text
from roughcontact.batch import project
from roughcontact.desk.live_solver import FailedRequest, LiveSolver, PreparedMaps, Preview
from roughcontact.desk.rasters import is_drawn_alike
from roughcontact.desk.session import HISTORY, PINNED, Session, SessionState, from_script
from roughcontact.errors import InputError, RoughcontactError
from roughcontact.request.options import LEVEL
from roughcontact.request.outcome import Outcome
from roughcontact.request.run import run_request
from visits import compare_contacts, give_all

PATIENCE = 60.0


def save_map(folder: Path, name: str, shape: tuple[int, int] = (12, 16), holes: int = 0) -> Path:
    heights = 1e-7 * np.random.default_rng(len(name)).standard_normal(shape)
    heights.flat[:holes] = np.nan
    rc.Surface(heights, (1e-6, 1e-6)).save(folder / name)
    return folder / name


class Heard:
    """Messages of a session."""

    def __init__(self) -> None:
        self.all: list[Any] = []

    def __call__(self, what: Any) -> None:
        self.all.append(what)
        if isinstance(what, FailedRequest):
            # An unexpected error.
            assert "internal error" not in what.error.message_for(), what.error


@pytest.fixture
def heard() -> Heard:
    return Heard()


@pytest.fixture
def session(tmp_path: Path, heard: Heard) -> Iterator[Session]:
    session = Session(tmp_path / "project.toml", heard)
    yield session
    session.close()


GIVEN = {"material": "100Cr6", "boundary": "periodic", "load": "10 mN"}


def wait_for_outcome(session: Session) -> Outcome:
    assert session.wait(PATIENCE)
    assert session.outcome is not None, session.failure
    return session.outcome


def test_contact_follows_options(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    give_all(session, dict(GIVEN))
    first = wait_for_outcome(session).contact
    session.set_option("load", "20 mN")
    second = wait_for_outcome(session).contact
    assert first is not None
    assert second is not None
    assert first.load == pytest.approx(0.01)
    assert second.load == pytest.approx(0.02)


def test_the_numbers_are_those_of_the_command(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    give_all(session, dict(GIVEN))
    for load in ("30 mN", "1 mN", "10 mN"):
        session.set_option("load", load)
        shown = wait_for_outcome(session).contact
    alone = run_request(session.request, lambda _: None).contact
    assert shown is not None
    assert alone is not None
    assert np.array_equal(shown.pressure, alone.pressure)


def test_a_map_shows_before_anything_can_be_solved(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    assert session.wait(PATIENCE)
    assert session.prepared is not None
    assert session.outcome is None


def test_failure_is_reported_and_map_remains_shown(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz", holes=2))
    give_all(session, dict(GIVEN))
    assert session.wait(PATIENCE)
    assert session.failure is not None
    assert "2 missing points" in session.failure.error.message_for()
    # The map is seen nevertheless.
    assert session.prepared is not None
    assert session.prepared.surfaces[0].missing == 2
    session.set_option("missing", "fill")
    wait_for_outcome(session)
    assert session.failure is None


def test_missing_file_is_reported(session: Session, tmp_path: Path) -> None:
    path = save_map(tmp_path, "a.npz")
    path.unlink()
    session.open_map(path)
    assert session.wait(PATIENCE)
    assert session.failure is not None
    assert "a.npz" in session.failure.error.message_for()


def test_only_last_of_several_loads_is_solved(tmp_path: Path) -> None:
    reading = threading.Event()

    heard = Heard()

    def wait_while_reading(what: Any) -> None:
        heard(what)
        if isinstance(what, PreparedMaps):
            reading.wait(PATIENCE)

    session = Session(tmp_path / "project.toml", wait_while_reading)
    session.open_map(save_map(tmp_path, "a.npz"))
    give_all(session, dict(GIVEN))
    for load in ("1 mN", "2 mN", "3 mN", "4 mN"):
        session.set_option("load", load)
    reading.set()
    assert session.wait(PATIENCE)
    loads = [what.contact.load for what in heard.all if isinstance(what, Outcome) and what.contact]
    # Those before it that had begun end: how many is a matter of time, as the next test shows.
    assert loads[-1] == pytest.approx(0.004)
    assert loads.count(loads[-1]) == 1
    session.close()


def test_a_solve_that_began_ends_and_the_newest_waits(tmp_path: Path) -> None:
    began, go_on = threading.Event(), threading.Event()
    messages: list[Any] = []

    def record_event(what: Any) -> None:
        messages.append(what)
        if isinstance(what, PreparedMaps) and "load" in what.request.specified:
            began.set()
            assert go_on.wait(PATIENCE)

    path = save_map(tmp_path, "a.npz")
    live = LiveSolver(record_event)
    given = {**GIVEN, "level": "none"}
    requests = [from_text("solve", path, {**given, "load": f"{mN} mN"}) for mN in (1, 2, 3, 4)]
    live.request(requests[0])
    assert began.wait(PATIENCE)
    for request in requests[1:]:
        live.request(request)
    go_on.set()
    assert live.wait(PATIENCE)
    for kind, solved in ((Preview, [0, 3]), (Outcome, [3])):
        assert [
            requests.index(what.request) for what in messages if isinstance(what, kind)
        ] == solved
    # Other maps need no end of it.
    began.clear(), go_on.clear(), messages.clear()
    live.request(requests[0])
    assert began.wait(PATIENCE)
    live.request(from_text("solve", path, {**given, "level": "mean"}))
    go_on.set()
    assert live.wait(PATIENCE)
    assert [what.request[LEVEL] for what in messages if isinstance(what, Outcome)] == ["mean"]
    live.close()


def test_preview_precedes_calibrated_ceiling(
    session: Session, heard: Heard, tmp_path: Path
) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    give_all(session, {**GIVEN, "load": "1 N"})
    whole = wait_for_outcome(session).contact
    previews = [what for what in heard.all if isinstance(what, Preview)]
    first = previews[-1].contact
    assert first.calibrated is None
    assert whole.calibrated is not None
    assert is_drawn_alike(first, whole)
    session.set_option("ceiling", "none")
    wait_for_outcome(session)
    assert [what for what in heard.all if isinstance(what, Preview)] == previews


def test_the_map_is_read_and_prepared_once(session: Session, tmp_path: Path) -> None:
    path = save_map(tmp_path, "a.npz")
    session.open_map(path)
    give_all(session, dict(GIVEN))
    wait_for_outcome(session)
    assert session.prepared is not None
    before = session.prepared.surfaces
    session.set_option("load", "20 mN")
    wait_for_outcome(session)
    assert session.prepared.surfaces[0] is before[0]
    session.set_option("level", "quadric")
    wait_for_outcome(session)
    assert session.prepared.surfaces[0] is not before[0]


def test_a_file_that_changes_is_read_again(session: Session, tmp_path: Path) -> None:
    path = save_map(tmp_path, "a.npz")
    session.open_map(path)
    give_all(session, dict(GIVEN))
    first = wait_for_outcome(session).contact
    rc.Surface(2e-7 * np.random.default_rng(7).standard_normal((20, 20)), (1e-6, 1e-6)).save(path)
    session.set_option("level", "mean")
    second = wait_for_outcome(session).contact
    assert first is not None
    assert second is not None
    assert second.pressure.shape == (20, 20)


def test_reopened_session_restores_project(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz"), "the real name.opd")
    give_all(session, dict(GIVEN))
    session.pin()
    session.draw_line((0.0, 0.0, 1e-5, 1e-5))
    again = Session(session.project, lambda _: None)
    assert again.state == session.state
    again.close()


def test_undo_reverts_one_step_at_a_time(session: Session, tmp_path: Path) -> None:
    states = [session.state]
    session.open_map(save_map(tmp_path, "a.npz"))
    states.append(session.state)
    for name, value in GIVEN.items():
        session.set_option(name, value)
        states.append(session.state)
    for state in states[-2::-1]:
        session.undo()
        assert session.state == state
    assert not session.can_undo
    for state in states[1:]:
        session.redo()
        assert session.state == state
    assert not session.can_redo


def test_undo_history_survives_reload(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    give_all(session, dict(GIVEN))
    before = session.state
    session.set_option("load", "20 mN")
    session.set_option("load", "30 mN")
    session.undo()
    again = Session(session.project, lambda _: None)
    again.undo()
    assert again.state == before
    again.redo()
    again.redo()
    assert again.state.specified["load"] == "30 mN"
    assert not again.can_redo
    again.close()
    # A damaged history is dropped, and the project opens.
    (tmp_path / HISTORY).write_text('["x"')
    last = Session(session.project, lambda _: None)
    assert last.state == again.state
    assert not last.can_undo
    last.close()


def test_states_of_a_comparison_keep_their_names(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    give_all(session, dict(GIVEN))
    session.pin()
    session.set_option("load", "20 mN")
    assert not session.state.is_first
    session.swap_pinned()
    assert session.state.is_first
    assert session.state.specified["load"] == "10 mN"
    again = Session(session.project, lambda _: None)
    assert again.state == session.state
    again.swap_pinned()
    assert not again.state.is_first
    again.close()


class Desk(RuleBasedStateMachine):
    """No order of actions, on one page or several, raises an unhandled error.

    All visits, the project file and the command agree: on the state after each step, and on the
    contact to the bit.
    """

    @initialize()
    def begin(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        self.maps = [
            save_map(self.root, "a.npz"),
            save_map(self.root, "bb.npz", holes=3),
            save_map(self.root, "ccc.npz", (12, 10)),
            self.root / "gone.npz",
        ]
        (self.root / "text.npz").write_text("no map")
        self.maps.append(self.root / "text.npz")
        self.unhandled: list[BaseException] = []
        self.hook = threading.excepthook
        threading.excepthook = lambda failed: self.unhandled.append(failed.exc_value)
        self.heard = Heard()
        self.visits: list[Session] = []
        self.enter()

    def enter(self) -> None:
        """Open the project again, as the server does: all pages receive the changes of one."""
        own: list[Session] = []

        def share(state: SessionState) -> None:
            for visit in self.visits:
                if visit not in own:
                    visit.adopt_state(state)

        own.append(Session(self.root / "project.toml", self.heard, share=share))
        self.session = own[0]
        self.visits.append(self.session)
        self.session.solve()

    @rule()
    @precondition(lambda self: len(self.visits) < 3)
    def visit_again(self) -> None:
        self.enter()

    @rule(number=st.integers(0, 2))
    def turn_to(self, number: int) -> None:
        self.session = self.visits[number % len(self.visits)]

    @rule()
    @precondition(lambda self: len(self.visits) > 1)
    def leave(self) -> None:
        self.visits.remove(self.session)
        self.session.close()
        self.session = self.visits[0]

    @rule(number=st.sampled_from([0, 2]), load=st.sampled_from(["1 mN", "20 MPa"]))
    def press(self, number: int, load: str) -> None:
        self.session.open_map(self.maps[number])
        give_all(self.session, {**GIVEN, "load": load})

    @rule(number=st.integers(0, 4), name=st.text(max_size=8))
    def bring(self, number: int, name: str) -> None:
        name = name.encode("utf-8", "replace").decode()
        self.session.open_map(self.maps[number], name)

    @rule(number=st.none() | st.integers(0, 4))
    def face(self, number: int | None) -> None:
        self.session.open_counter_map(None if number is None else self.maps[number])

    @rule()
    def use_no_map(self) -> None:
        self.session.open_map(None)

    @rule(
        given=st.sampled_from(
            [
                ("material", "100Cr6"),
                ("material", "kryptonite"),
                ("material", ""),
                ("boundary", "free"),
                ("boundary", "periodic"),
                ("boundary", "endless"),
                ("load", "1 mN"),
                ("load", "20 MPa"),
                ("load", "1 TN"),
                ("load", "-1 N"),
                ("load", "600 N/mm"),
                ("load", "hertz 1 GPa"),
                ("approach", "10 nm"),
                ("approach", "1 km"),
                ("ceiling", "none"),
                ("ceiling", "1 GPa"),
                ("ceiling", "1 Pa"),
                ("young", "1 GPa"),
                ("poisson", "0.7"),
                ("poisson", "0.3"),
                ("yield-strength", "500 MPa"),
                ("level", "none"),
                ("level", "quadric"),
                ("form", "sphere"),
                ("form", "polynomial 3"),
                ("missing", "fill"),
                ("missing", "mask"),
                ("missing", "crop"),
                ("outliers", "6"),
                ("outliers", "-1"),
                ("crop", "0:8,0:8"),
                ("crop", "50:60,0:8"),
                ("crop", "1"),
                ("s-filter", "3 um"),
                ("l-filter", "1 nm"),
                ("pixel", "2 um"),
                ("pixel", "1 m"),
                ("rotate", "90"),
                ("align", True),
                ("align", False),
                ("mirror", True),
                ("body", "sphere 1 mm"),
                ("points", "16"),
                ("size", "20 um"),
                ("model", "elastoplastic"),
                ("load-point", "0 um, 1 um"),
                ("tolerance", "1e-4"),
                ("tolerance", "0"),
                ("nonsense", "1"),
                ("output", "x.nc"),
            ]
        )
    )
    def give(self, given: tuple[str, str | bool]) -> None:
        before = self.session.state
        try:
            self.session.set_option(*given)
        except RoughcontactError:
            assert self.session.state == before

    @rule(method=st.sampled_from(["leveled", "filled", "cropped", "with_form", "unknown"]))
    def undo_step(self, method: str) -> None:
        self.session.undo_step(method)

    @rule()
    def undo(self) -> None:
        self.session.undo()

    @rule()
    def redo(self) -> None:
        self.session.redo()

    @rule()
    def pin(self) -> None:
        self.session.pin()

    @rule()
    @precondition(lambda self: self.session.state.pinned is not None)
    def swap(self) -> None:
        self.session.swap_pinned()

    @rule()
    def unpin(self) -> None:
        self.session.unpin()

    @rule(ends=st.tuples(*[st.floats(0, 1e-5)] * 4))
    def draw(self, ends: tuple[float, float, float, float]) -> None:
        self.session.draw_line(ends)

    @rule()
    def reload(self) -> None:
        self.visits.remove(self.session)
        self.session.close()
        self.enter()

    @rule()
    def look(self) -> None:
        assert self.session.wait(PATIENCE)
        state = self.session.state
        self.compare_contacts()
        if state.missing:
            assert self.session.outcome is None
        else:
            assert (self.session.outcome is None) != (self.session.failure is None)

    def compare_contacts(self) -> None:
        """Solve by the command and by the project file, and compare the bits."""
        if "model" not in self.session.state.specified:
            compare_contacts(self.session, self.root)

    @invariant()
    def all_agree_on_the_state(self) -> None:
        path = self.session.project
        for visit in self.visits:
            assert visit.state == self.session.state
        if path.exists():
            assert from_script(path.read_text("utf-8"), path.parent) == self.session.state
        assert not self.unhandled

    def teardown(self) -> None:
        if hasattr(self, "session"):
            for visit in self.visits:
                assert visit.wait(PATIENCE) or self.unhandled
            self.compare_contacts()
            for visit in self.visits:
                visit.close()
            threading.excepthook = self.hook
            assert not self.unhandled
            self.folder.cleanup()


Desk.TestCase.settings = settings(
    max_examples=40, stateful_step_count=20, deadline=None, suppress_health_check=list(HealthCheck)
)
TestDesk = pytest.mark.long(Desk.TestCase)


@pytest.mark.slow
def test_500_sequences() -> None:
    from hypothesis.stateful import run_state_machine_as_test

    many = settings(Desk.TestCase.settings, max_examples=500)
    run_state_machine_as_test(Desk, settings=many)


def test_a_state_that_is_complete_can_be_run_from_its_file(
    session: Session, tmp_path: Path
) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    give_all(session, dict(GIVEN))
    session.pin()
    session.set_option("load", "20 mN")
    entries = {entry.name: entry.request for entry in project.read_project(session.project)}
    assert entries[PINNED].specified["load"] == "10 mN"
    assert isinstance(session.failure, FailedRequest) is False


def test_repeated_crops_are_combined(session: Session, tmp_path: Path) -> None:
    session.open_map(save_map(tmp_path, "a.npz"))
    session.crop_map((2, 10), (4, 16))
    assert session.state.specified["crop"] == "2:10,4:16"
    session.crop_map((1, 5), (0, 4))
    assert session.state.specified["crop"] == "3:7,4:8"
    session.set_option("rotate", "90")
    with pytest.raises(InputError, match="before"):
        session.crop_map((0, 2), (0, 2))
