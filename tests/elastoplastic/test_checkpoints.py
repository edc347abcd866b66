"""Runs that were stopped resume to the same bits; folders of other runs are refused."""

from __future__ import annotations

import os
from pathlib import Path

import h5py
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import checkpoints
from roughcontact.elastoplastic import archive
from roughcontact.elastoplastic.archive import load_elastoplastic
from roughcontact.elastoplastic.solve import solve_elastoplastic
from roughcontact.material.hardening import Swift
from roughcontact.solvers.progress import Progress
from volume_runs import StopError, bits

SWIFT = rc.Material(young=210e9, poisson=0.3, hardening=Swift(1240e6, 30, 0.085))
PERFECT = rc.Material(young=210e9, poisson=0.3, yield_strength=1656e6)


def ball(shape: tuple[int, int] = (18, 16)) -> rc.Surface:
    y, x = (1e-6 * (np.arange(n) - (n - 1) / 2) for n in shape)
    return rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 105e-6), pixel=(1e-6, 1e-6))


def stopping_at(load: float, iteration: int = 2):
    def stop(at: Progress) -> None:
        if not at.kept and at.step.load == load and at.step.iteration == iteration:
            raise StopError

    return stop


# The volume grows on the way, steps are cut, loads come back: all of the state of the loop matters.
PATHS = {
    "grows": (dict(material=SWIFT, increments=1, loads=[0.1, 0.3, 0.35], depth=2.5e-6), 0.35),
    "is cut": (
        dict(
            material=PERFECT,
            increments=1,
            loads=[0.1, 0.4, 0.45],
            boundary="periodic",
            max_iterations=8,
            depth=1e-5,
        ),
        0.45,
    ),
    "two bodies": (
        dict(
            material=SWIFT,
            counter_material=PERFECT,
            increments=1,
            loads=[0.1, 0.2],
            precision="double",
            depth=1e-5,
        ),
        0.2,
    ),
    "unloads": (dict(material=SWIFT, increments=1, loads=[0.3, 0.0, 0.35], depth=1e-5), 0.35),
}


@pytest.mark.slow
@pytest.mark.parametrize(("arguments", "stop"), PATHS.values(), ids=PATHS)
def test_a_stopped_run_ends_with_the_same_bits(arguments, stop, tmp_path: Path) -> None:
    arguments = arguments | dict(tolerance=1e-3)
    whole = solve_elastoplastic(ball(), **arguments)
    asked = arguments["loads"]
    assert (len(whole.increments) > len(asked)) == (arguments["material"] is PERFECT)
    deeper = whole.bodies[0].thickness.sum() / arguments["depth"]
    assert (deeper > 1.3) == (arguments["depth"] < 3e-6)
    folder = tmp_path / "run"
    with pytest.raises(StopError):
        solve_elastoplastic(ball(), folder=folder, progress=stopping_at(stop, 1), **arguments)
    names = [f"step-{number:04d}.nc" for number in range(1, len(asked) + 1)]
    kept = asked.index(stop)
    assert sorted(path.name for path in folder.iterdir()) == [*names[:kept], "volume.json"]
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    messages: list[Progress] = []
    resumed = solve_elastoplastic(ball(), folder=folder, progress=messages.append, **arguments)
    assert bits(resumed) == bits(whole)
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in before.items())
    # One report for all stored steps, then the new ones.
    assert (messages[0].number, messages[0].kept) == (kept, True)
    assert {at.count for at in messages} == {len(asked)}
    assert [at.number for at in messages] == sorted(at.number for at in messages)
    assert (messages[0].number, messages[-1].number) == (kept, len(asked))
    assert all(not at.kept and at.step.load != asked[0] for at in messages[1:])
    assert bits(load_elastoplastic(folder / names[-1])) == bits(whole)
    # Arrays of the caller's own result stay read-only.
    with pytest.raises(ValueError, match="read-only"):
        resumed.bodies[0].plastic_strain[...] = 0


@pytest.mark.slow
def test_loads_may_be_added(tmp_path: Path) -> None:
    arguments = dict(material=SWIFT, depth=1e-5, boundary="periodic", tolerance=1e-3)
    solve_elastoplastic(ball(), increments=1, loads=[0.2, 0.3], folder=tmp_path, **arguments)
    more = solve_elastoplastic(
        ball(), increments=1, loads=[0.2, 0.3, 0.4], folder=tmp_path, **arguments
    )
    assert bits(more) == bits(
        solve_elastoplastic(ball(), increments=1, loads=[0.2, 0.3, 0.4], **arguments)
    )
    # Stored steps may be requested alone.
    first = solve_elastoplastic(ball(), increments=1, loads=[0.2], folder=tmp_path, **arguments)
    assert first.contact.load == 0.2
    with pytest.raises(rc.InputError, match="another run: loads differ"):
        solve_elastoplastic(
            ball(), increments=1, loads=[0.2, 0.35, 0.4], folder=tmp_path, **arguments
        )


@pytest.mark.long
def test_run_from_start_result_resumes_in_new_folder(tmp_path: Path) -> None:
    arguments = dict(
        material=SWIFT, increments=1, loads=[0.25, 0.0], boundary="periodic", tolerance=1e-3
    )
    starts = [
        solve_elastoplastic(
            ball(),
            material=SWIFT,
            increments=1,
            loads=[load],
            depth=1e-5,
            boundary="periodic",
            tolerance=1e-3,
        )
        for load in (0.2, 0.21)
    ]
    whole = solve_elastoplastic(ball(), start=starts[0], **arguments)
    with pytest.raises(StopError):
        solve_elastoplastic(
            ball(), start=starts[0], folder=tmp_path, progress=stopping_at(0.0, 1), **arguments
        )
    with pytest.raises(rc.InputError, match="another run: layers, start differ"):
        solve_elastoplastic(ball(), folder=tmp_path, **arguments)
    with pytest.raises(rc.InputError, match="another run: start differ"):
        solve_elastoplastic(ball(), start=starts[1], folder=tmp_path, **arguments)
    resumed = solve_elastoplastic(ball(), start=starts[0], folder=tmp_path, **arguments)
    assert bits(resumed) == bits(whole)
    assert resumed.increments[0] == starts[0].increments[0]


@pytest.mark.long
def test_folder_of_another_run_raises_input_error(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    arguments = dict(surface=ball(), material=SWIFT, increments=1, loads=[0.02, 0.04], depth=8e-6)
    solve_elastoplastic(folder=folder, **arguments)
    before = sorted((path.name, path.read_bytes()) for path in folder.iterdir())
    heights = ball().heights.copy()
    heights[0, 0] = np.nextafter(heights[0, 0], 0)
    elastic = rc.Material(young=70e9, poisson=0.3)
    for change, words in (
        (dict(surface=rc.Surface(heights, pixel=(1e-6, 1e-6))), "surface differ"),
        (dict(counter_surface=ball()), "counter_surface differ"),
        (dict(material=PERFECT), "material differ"),
        (dict(counter_material=elastic), "counter_material differ"),
        (dict(boundary="periodic"), "boundary differ"),
        (dict(depth=9e-6), "layers differ"),
        (dict(depth=None, layers=[1e-6] * 8), "layers differ"),
        (dict(tolerance=1e-3), "tolerance differ"),
        (dict(max_iterations=100), "max_iterations differ"),
        (dict(precision="double"), "precision differ"),
        (dict(loads=[0.01, 0.04]), "loads differ"),
    ):
        with pytest.raises(rc.InputError, match=rf"holds another run: {words}s?; give another"):
            solve_elastoplastic(folder=folder, **(arguments | change))
    assert before == sorted((path.name, path.read_bytes()) for path in folder.iterdir())


@pytest.mark.slow
def test_damage_in_the_folder_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    arguments = dict(material=SWIFT, increments=1, loads=[0.02, 0.04], depth=8e-6)
    whole = solve_elastoplastic(ball(), folder=folder, **arguments)
    last = folder / "step-0002.nc"
    sound = last.read_bytes()
    last.write_bytes(sound[: len(sound) // 2])
    with pytest.raises(rc.FormatError, match=r"step-0002\.nc cannot be read .* solve it again"):
        solve_elastoplastic(ball(), folder=folder, **arguments)
    # A result, but none that a run left behind; one that is of another body.
    whole.save(last)
    with pytest.raises(rc.FormatError, match=r"step-0002\.nc is no step of a run; remove it"):
        solve_elastoplastic(ball(), folder=folder, **arguments)
    other = tmp_path / "other"
    solve_elastoplastic(ball(), folder=other, **(arguments | dict(material=PERFECT)))
    last.write_bytes((other / last.name).read_bytes())
    with pytest.raises(rc.InputError, match=r"step-0002\.nc was solved with another material"):
        solve_elastoplastic(ball(), folder=folder, **arguments)
    last.unlink()
    assert bits(solve_elastoplastic(ball(), folder=folder, **arguments)) == bits(whole)


@pytest.mark.slow
def test_changed_step_raises_format_error(tmp_path: Path) -> None:
    arguments = dict(material=SWIFT, increments=1, loads=[0.02], depth=8e-6)
    solve_elastoplastic(ball(), folder=tmp_path / "run", **arguments)
    step = tmp_path / "run" / "step-0001.nc"
    sound = step.read_bytes()
    # A bit of what only the loop reads, not the result.
    with h5py.File(step, "a") as file:
        file["carried_pressure"][0] *= 1 + 1e-15
    with pytest.raises(rc.FormatError, match=r"carried_pressure does not match .* solve it again"):
        solve_elastoplastic(ball(), folder=tmp_path / "run", **arguments)
    # Sound, of the same bodies and loads, but with another tolerance.
    solve_elastoplastic(ball(), folder=tmp_path / "other", tolerance=1e-3, **arguments)
    step.write_bytes((tmp_path / "other" / step.name).read_bytes())
    with pytest.raises(rc.FormatError, match=r"is a step of another run; remove it"):
        solve_elastoplastic(ball(), folder=tmp_path / "run", **arguments)
    step.write_bytes(sound)
    assert solve_elastoplastic(ball(), folder=tmp_path / "run", **arguments).converged


@pytest.mark.long
def test_two_runs_do_not_share_a_folder(tmp_path: Path) -> None:
    arguments = dict(material=SWIFT, increments=1, loads=[0.02], depth=8e-6, folder=tmp_path)

    def meanwhile(at: Progress) -> None:
        with pytest.raises(rc.InputError, match="is in use: another run is writing to it"):
            solve_elastoplastic(ball(), **arguments)

    solve_elastoplastic(ball(), progress=meanwhile, **arguments)
    assert {path.name for path in tmp_path.iterdir()} == {"step-0001.nc", "volume.json"}


@pytest.mark.long
def test_failed_run_keeps_saved_loads(tmp_path: Path) -> None:
    # At 0.02 N the ball is elastic: one iteration.
    arguments = dict(
        material=PERFECT, increments=1, loads=[0.02, 0.65], max_iterations=2, boundary="periodic"
    )
    for _ in range(2):
        with pytest.raises(
            rc.ConvergenceError, match=r"did not converge .* are saved in"
        ) as caught:
            solve_elastoplastic(ball(), folder=tmp_path, depth=1e-5, **arguments)
        assert caught.value.result.contact.load < 0.65
        assert {path.name for path in tmp_path.iterdir()} == {"step-0001.nc", "volume.json"}


def test_failed_first_load_raises_convergence_error(tmp_path: Path) -> None:
    with pytest.raises(rc.ConvergenceError, match="the state at 0 N is kept"):
        solve_elastoplastic(
            ball(), material=PERFECT, increments=1, loads=[1.0], max_iterations=1, depth=1e-5
        )


@pytest.mark.long
def test_full_disk_raises_input_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(result: object, path: Path, carried: object) -> None:
        if path.name == "step-0002.nc":
            raise OSError(28, "No space left on device")
        written(result, path, carried)

    written = archive.save_elastoplastic
    monkeypatch.setattr(archive, "save_elastoplastic", full)
    arguments = dict(material=SWIFT, increments=1, loads=[0.02, 0.04], depth=8e-6)
    with pytest.raises(rc.InputError, match=r"step-0002\.nc cannot be written \(No space left"):
        solve_elastoplastic(ball(), folder=tmp_path, **arguments)
    assert (tmp_path / "step-0001.nc").exists()


# The folder itself


def lock_trial(folder: Path, **problem: object) -> Path:
    with checkpoints.lock_folder(
        folder, lambda: problem, kind="trial", record="trial.json", pattern="part-*.npy"
    ) as place:
        assert place is not None
        return place.folder


def test_folder_is_created_and_recognized(tmp_path: Path) -> None:
    folder = lock_trial(tmp_path / "deep" / "down", load=0.1, name="ä", bodies={"a": [1, 2]})
    assert lock_trial(folder, load=0.1, name="ä", bodies={"a": [1, 2]}) == folder
    with pytest.raises(rc.InputError, match="another trial: load, bodies differ"):
        lock_trial(folder, load=0.1 + 1e-17 + 2e-17, name="ä", bodies={"a": [1, 3]})


def test_folders_that_cannot_be_used(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(rc.InputError, match="file is a file; give the name of a folder"):
        lock_trial(tmp_path / "file")
    with pytest.raises(rc.InputError, match=r"cannot be written to .*; give another folder"):
        lock_trial(tmp_path / "file" / "below")
    used = tmp_path / "used"
    used.mkdir()
    (used / "part-1.npy").write_text("")
    with pytest.raises(rc.InputError, match=r"holds steps without trial\.json"):
        lock_trial(used)
    for text in ("{", "[]", '"word"'):
        (used / "trial.json").write_text(text)
        with pytest.raises(rc.FormatError, match=r"trial\.json is damaged"):
            lock_trial(used, load=1.0)


def test_folder_without_permission_raises_input_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock_trial(tmp_path, load=1.0)
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(rc.InputError, match="cannot be written to; give another folder"):
        lock_trial(tmp_path, load=1.0)
