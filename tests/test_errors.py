import gc
import pickle
import threading
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import errors
from roughcontact.analyses.tasks import TASKS
from roughcontact.cli import app
from roughcontact.errors import ArgumentRef, ConvergenceError, Sentence, message_parts
from roughcontact.surface.random_surfaces import reference_map

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)


def rough(points: int = 64) -> rc.Surface:
    return rc.Surface(*reference_map(points))


def unconverged() -> rc.ConvergenceError:
    with pytest.raises(rc.ConvergenceError) as caught:
        rc.solve(rough(32), load=1.0, material=STEEL, max_iterations=2)
    return caught.value


def test_every_error_survives_another_process() -> None:
    for kind in (rc.InputError, rc.FormatError, rc.CapacityError, rc.InsufficientMemoryError):
        error = kind("is too much: try ", ArgumentRef("crop"), argument="load", value=2.0)
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is kind
        assert str(again) == str(error) == "load is too much: try crop"
        assert (again.argument, again.value) == ("load", 2.0)


LONG = ("x" * 3000, "x y " * 750, "9" * 3000, "1 " + "N" * 3000, "E=1, 2 um " * 300, "ü'" * 1500)


@pytest.mark.parametrize("value", LONG, ids=range(len(LONG)))
def test_long_value_of_an_option_is_cut(value: str) -> None:
    messages = []
    for option in {option for task in TASKS for option in task.options if not option.is_flag}:
        try:
            option.parse(value, option.argument)
        except rc.InputError as error:
            messages.append(str(error))
    assert len(messages) > 40
    assert max(map(len, messages)) < 500
    assert any("…" in message for message in messages)


def test_long_names_are_cut(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = "n" * 240
    np.savez(tmp_path / f"{name}.npz", **{"x" * 3000: np.zeros((4, 4)), "y": np.ones((4, 4))})
    text = tmp_path / "table.csv"
    text.write_text(f"1,2,3\n4,{LONG[0]},6\n")
    project = tmp_path / "project.toml"
    project.write_text(f'[[contact]]\nname = "c"\n"{LONG[1]}" = 1\n')
    for words in (
        ["info", str(tmp_path / f"{name}.npz")],
        ["info", str(text)],
        ["info", LONG[1]],
        ["verify", LONG[1]],
        ["run", str(project)],
        ["run", LONG[1]],
        ["solve", "--" + LONG[0]],
        [LONG[0]],
    ):
        assert app.main(words) == app.BAD_INPUT
        shown = capsys.readouterr().err
        assert 0 < len(shown) < 1000, words


def test_short_values_and_apostrophes_are_kept() -> None:
    text = (
        "Young's modulus of the bodies' map '/home/user/measurements/2026/ground, side A, third "
        "repetition, after cleaning/map.x3p' is not 'E = 1' or \"it's\", the body's other value"
    )
    assert str(rc.InputError(text)) == text


def test_stored_errors_hold_no_threads() -> None:
    kept = [unconverged() for _ in range(3)]
    gc.collect()
    before = threading.active_count()
    kept += [unconverged() for _ in range(5)]
    gc.collect()
    assert threading.active_count() <= before


@pytest.mark.parametrize("shape", [(2, 3), (5, 7), (31, 30)])
def test_the_full_capacity_is_a_load_like_any_other(shape: tuple[int, int]) -> None:
    surface = rc.Surface(np.random.default_rng(1).random(shape) * 1e-8, (1e-6, 1e-6))
    load = 3e9 * shape[0] * shape[1] * 1e-12
    result = rc.solve(surface, load=load, material=STEEL)
    assert result.saturated.all()
    assert result.load_error <= 1e-10
    with pytest.raises(rc.CapacityError):
        rc.solve(surface, load=load * (1 + 1e-9), material=STEEL)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("surface", reference_map(32)),
        ("material", None),
        ("counter_material", 210e9),
        ("initial_guess", 3),
        ("ceiling", [[1, 2], [3]]),
        ("ceiling", 1j),
        ("ceiling", np.ma.masked_all((64, 64))),
    ],
)
def test_arguments_of_another_kind_are_named(name: str, value: object) -> None:
    arguments = {"surface": rough(), "load": 1.0, "material": STEEL, name: value}
    with pytest.raises(rc.InputError, match=name):
        rc.solve(**arguments)


def test_sentence_keeps_argument_references() -> None:
    said = Sentence("raise ", ArgumentRef("max_iterations"), ", or stop")
    assert said == "raise max_iterations, or stop"
    assert message_parts(said)[1] == ArgumentRef("max_iterations")
    again = pickle.loads(pickle.dumps(said))
    assert (again, again.parts) == (said, said.parts)
    assert message_parts("plain") == ("plain",)
    error = ConvergenceError(said, None)
    assert (
        error.message_for(lambda mention: f"--{mention.name}") == "raise --max_iterations, or stop"
    )


def test_a_message_in_python_syntax_gets_its_arguments_back() -> None:
    text = 'Use s="2.7 µm", precision="single" or max_iterations=2000; see ceiling.'
    parts = errors.read_message(text)
    assert errors.render_message(parts) == text
    found = [(part.name, part.value) for part in parts if isinstance(part, errors.ArgumentRef)]
    assert found == [("s", "2.7 µm"), ("precision", "single"), ("max_iterations", 2000)]
