import gc
import pickle
import threading

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.errors import ArgumentRef, ConvergenceError, Sentence, message_parts
from roughcontact.surface.random_surfaces import reference_map

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)


def rough(points: int = 64) -> rc.Surface:
    return rc.Surface(*reference_map(points))


def unconverged() -> rc.ConvergenceError:
    with pytest.raises(rc.ConvergenceError) as caught:
        rc.solve(rough(), load=1.0, material=STEEL, max_iterations=2)
    return caught.value


def test_an_unconverged_result_survives_another_process() -> None:
    error = unconverged()
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error)
    assert str(error).startswith("not converged: certificate")
    np.testing.assert_array_equal(again.result.pressure, error.result.pressure)


def test_every_error_survives_another_process() -> None:
    for kind in (rc.InputError, rc.FormatError, rc.CapacityError, rc.InsufficientMemoryError):
        error = kind("is too much: try ", ArgumentRef("crop"), argument="load", value=2.0)
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is kind
        assert str(again) == str(error) == "load is too much: try crop"
        assert (again.argument, again.value) == ("load", 2.0)


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


def test_infinite_ceiling_is_none() -> None:
    surface = rough()
    ceiling = np.full(surface.shape, np.inf)
    elastic = rc.solve(surface, load=0.1, material=STEEL, ceiling=ceiling)
    assert elastic.ceiling is None
    with pytest.raises(rc.CapacityError, match="full contact"):
        rc.solve(surface, approach=1e-5, material=STEEL, ceiling=ceiling, boundary="periodic")


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
