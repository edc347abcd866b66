"""The progress line of a calculation, and the state after Ctrl-C."""

import io

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.tasks import from_text
from roughcontact.cautions import CautionTag
from roughcontact.report import phrases
from roughcontact.request.run import run_request
from roughcontact.solvers import progress
from roughcontact.solvers.progress import Forecast, Progress, ProgressBar, Step, one_of_several

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")


def rough():
    return rc.Surface(*rc.reference_map(96, 3))


def test_a_bar_shows_the_share_that_is_done():
    stream = io.StringIO()
    bar = ProgressBar(stream)
    for certificate, done in ((1e-1, 0.0), (1e-2, 0.25), (1e-4, 0.75), (1e-6, 1.0)):
        bar(Progress(1, 2, Step((8, 8), 0, 1, certificate, 1e-5, done)))
    bar(Progress(2, 2, None, "map", kept=True))
    bar.close()
    drawn = stream.getvalue().split("\r")[1:]
    assert [line.count("█") for line in drawn] == [0, 3, 9, 12, 24]
    assert "1 of 2, 1e-02, target 1e-05" in drawn[1]
    assert drawn[-1].rstrip("\n").split(maxsplit=1)[1].strip() == "map, 2 of 2, from an earlier run"
    # Each line hides the one before, and the last ends.
    lengths = [len(line.rstrip("\n")) for line in drawn]
    assert all(later >= len(line.rstrip()) for line, later in zip(drawn, lengths[1:], strict=False))
    assert drawn[-1].endswith("\n")


@pytest.mark.parametrize("of", ["solve", "sweep", "find_load", "solve_elastoplastic"])
def test_progress_true_draws_bar(of, capsys):
    options = {
        "solve": {"load": 0.5},
        "sweep": {"loads": [0.1, 0.5]},
        "find_load": {"contact_fraction": 0.05},
        "solve_elastoplastic": {"load": 0.01, "increments": 1, "tolerance": 1e-2},
    }[of]
    surface = rc.Surface(*rc.reference_map(32, 3)) if of == "solve_elastoplastic" else rough()
    quiet = getattr(rc, of)(surface, material=STEEL, **options)
    assert capsys.readouterr().err == ""
    result = getattr(rc, of)(surface, material=STEEL, progress=True, **options)
    drawn = capsys.readouterr().err
    assert drawn.count("\r") >= 1
    assert drawn.endswith("\n")
    assert "target" in drawn
    if of == "solve":
        np.testing.assert_array_equal(result.pressure, quiet.pressure)


def interrupting(after):
    """A progress callback that raises Ctrl-C at one call."""
    looks = []

    def watch(at):
        looks.append(at.step)
        if len(looks) == after:
            raise KeyboardInterrupt

    return watch


@pytest.mark.parametrize("after", [1, 3, 5])
def test_interrupt_returns_last_state_with_option(after):
    whole = rc.solve(rough(), material=STEEL, load=0.5)
    cut = rc.solve(
        rough(), material=STEEL, load=0.5, on_interrupt="return", progress=interrupting(after)
    )
    assert cut.status == "interrupted"
    assert not cut.converged
    assert cut.certificate > cut.tolerance
    # It is a state of this contact: load, ceiling, and the gap of this pressure.
    assert cut.load_error < 1e-10
    assert cut.max_pressure <= cut.ceiling
    assert CautionTag.NOT_CONVERGED in {caution.kind for caution in cut.cautions}
    # And a start for resuming.
    again = rc.solve(rough(), material=STEEL, load=0.5, initial_guess=cut)
    np.testing.assert_allclose(again.pressure, whole.pressure, atol=1e-4 * whole.max_pressure)


def test_interrupt_raises_by_default():
    with pytest.raises(KeyboardInterrupt):
        rc.solve(rough(), material=STEEL, load=0.5, progress=interrupting(3))
    with pytest.raises(rc.InputError, match="on_interrupt"):
        rc.solve(rough(), material=STEEL, load=0.5, on_interrupt="stop")
    # The session continues as if nothing had been.
    assert rc.solve(rough(), material=STEEL, load=0.5).converged


@pytest.fixture
def clock(monkeypatch):
    """Return a function that sets the time."""
    times = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: times[-1])
    return times.append


def test_time_left_is_shown_after_first_part(clock):
    forecast = Forecast()

    def left(now, number, count, kept=False):
        clock(now)
        return forecast(Progress(number, count, None, kept=kept))

    # Stored steps take no time and give no estimate.
    assert left(100, 4, 10, kept=True) == 0
    assert left(100, 5, 10) == 0
    assert left(150, 5, 10) == 0
    assert left(200, 6, 10) == 500
    assert left(250, 6, 10) == 450
    assert left(500, 6, 10) == 400
    assert left(500, 7, 10) == 800
    # Another series.
    assert left(505, 1, 3) == 0
    assert left(512, 2, 3) == 14


@pytest.mark.parametrize(("boundary", "ceiling"), [("free", "auto"), ("periodic", None)])
def test_time_left_of_solve_is_within_factor_of_two(clock, boundary, ceiling):
    forecast, result = Forecast(), []
    work = at = 0

    def record_progress(state):
        nonlocal work, at
        # A convolution takes a time in proportion to the points of its grid.
        step = state.step
        work += (step.convolutions - (at if step.iteration else 0)) * np.prod(step.shape)
        at = step.convolutions
        clock(float(work))
        result.append((float(work), step.done, forecast(state)))

    surface = rc.Surface(*rc.reference_map(256, 3))
    rc.solve(
        surface,
        material=STEEL,
        load=0.5,
        boundary=boundary,
        ceiling=ceiling,
        progress=record_progress,
        calibrated=False,
    )
    shares = [done for _, done, _ in result]
    assert shares[-1] == 1
    assert all(0 <= done <= 1 for done in shares)
    known = [(left, work - now) for now, done, left in result if left and done < 0.9]
    assert len(known) > 5
    assert all(0.5 < left / true < 2 for left, true in known), known
    # It is known in the first tenth of the work.
    assert known[0][1] > 0.9 * work


def test_time_left_assumes_parts_as_long_as_first(clock):
    forecast = Forecast()

    def left(now, iteration, done):
        clock(now)
        return forecast(Progress(1, 5, Step((8, 8), iteration, 1, 0.1, 1e-6, done)))

    assert left(100, 0, 0.0) == 0
    assert left(101, 1, 0.1) == 0
    assert left(102, 2, 0.25) == pytest.approx(6 + 4 * 8)


def test_the_parts_of_several_calculations_are_counted_together():
    messages = []
    look = one_of_several(messages.append, 2, 3)
    look(Progress(1, 4, None, "honed", kept=True))
    assert messages == [Progress(5, 12, None, "honed", kept=True)]


def test_comparison_progress_counts_all_contacts(tmp_path):
    heights, pixel = rc.reference_map(32, 3)
    names = [str(tmp_path / f"{number}.npz") for number in range(3)]
    for name in names:
        rc.Surface(heights, pixel).save(name)
    given = {
        "group": [f"a={names[0]}", f"b={names[1]}", f"c={names[2]}"],
        "load": "20 MPa",
        "material": "100Cr6",
        "steps": "2",
    }
    messages = []
    run_request(from_text("compare", None, given), lambda text: None, messages.append)
    numbers = [state.number for state in messages]
    assert {state.count for state in messages} == {6}
    assert sorted(numbers) == numbers
    assert set(numbers) == {1, 2, 3, 4, 5, 6}


def collect_messages(task, folder, **more):
    """Return the progress messages of a task."""
    rc.Surface(*rc.reference_map(64, 3)).save(folder / "map.npz")
    given = {"material": "100Cr6", "boundary": "periodic", **more}
    messages = []
    run_request(from_text(task, folder / "map.npz", given), lambda text: None, messages.append)
    return messages


def assert_one_series(states):
    numbers = [state.number for state in states]
    assert numbers == sorted(numbers)
    assert {state.count for state in states} == {states[0].count}
    assert 1 < numbers[-1] <= states[0].count


@pytest.mark.long
def test_progress_shows_stress_depths_and_report_figures(tmp_path):
    report = str(tmp_path / "out.html")
    result = collect_messages("stress", tmp_path, load="20 MPa", report=report)
    for label in ("stress below the surface", f"writing {report}, figures"):
        assert_one_series([state for state in result if state.label == label])
    assert phrases.progress_text(result[-1]) == (
        f"writing {report}, figures: {result[-1].number} of {result[-1].count}"
    )


def test_the_variants_of_a_joint_are_one_series(tmp_path):
    conducts = dict.fromkeys(("conductivity", "counter-conductivity"), "46 W/m/K")
    result = collect_messages("conductance", tmp_path, load="1 GPa", **conducts)
    variants = [state for state in result if state.label]
    assert_one_series(variants)
    assert [*dict.fromkeys(state.label for state in variants)] == [
        "calibrated ceiling",
        "coarser grid",
    ]
