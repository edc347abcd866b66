"""Names of 0.2 work until 0.4 and say what they are called now."""

from __future__ import annotations

import inspect
import json
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import deprecated
from roughcontact.analyses.tasks import COMMANDS
from roughcontact.batch import project
from roughcontact.cli import app
from roughcontact.surface import nominal_bodies

STEEL = rc.Material(210e9, 0.3, 1e9)
BALL = (
    "--body",
    "sphere 1 mm",
    "--points",
    "24",
    "--size",
    "60 um",
    "--young",
    "210 GPa",
    "--poisson",
    "0.3",
    "--load",
    "0.1 N",
    "--json",
)


@pytest.mark.parametrize("name", deprecated.NAMES)
def test_an_old_name_of_the_package_warns_and_works(name: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"roughcontact.{name} is") as warned:
        assert getattr(rc, name) is not None
    # By default Python shows such a warning only where the script itself is to blame.
    assert warned[0].filename == __file__


def test_every_new_name_exists() -> None:
    for function, table in deprecated.ARGUMENTS.items():
        known = inspect.signature(getattr(rc, function)).parameters
        assert set(table.values()) <= set(known), function
        assert not set(table) & set(known), function
    for name, table in deprecated.OPTIONS.items():
        for command in [COMMANDS[name]] if name else COMMANDS.values():
            offered = command.by_name
            assert not set(table) & set(offered), command.name
            assert not name or set(table.values()) <= set(offered)


@pytest.mark.parametrize(
    ("function", "old"),
    [(function, old) for function, table in deprecated.ARGUMENTS.items() for old in table],
)
def test_old_argument_warns_with_line_of_caller(function: str, old: str) -> None:
    called = getattr(rc, function)
    with (
        pytest.raises((TypeError, rc.InputError)),
        pytest.warns(DeprecationWarning, match=rf"{function}\({old}=\) is") as warned,
    ):
        called(**{old: None}, nonsense=None)
    assert warned[0].filename == __file__


class Result(deprecated.RenamedAttributes):
    """A result whose new names are set."""


def classes() -> set[type]:
    """Return what has had other names, of all that the face returns."""
    found = {getattr(rc.results, name) for name in dir(rc.results) if name[0].isupper()}
    modules = [sys.modules[kind.__module__] for kind in (*found, rc.Material)]
    every = {kind for module in modules for kind in vars(module).values() if inspect.isclass(kind)}
    return {kind for kind in every if issubclass(kind, deprecated.RenamedAttributes)}


@pytest.mark.parametrize("old", deprecated.ATTRIBUTES)
def test_old_attribute_warns_with_line_of_reader(old: str) -> None:
    new = deprecated.ATTRIBUTES[old]
    assert any(hasattr(kind, new) or new in kind.__annotations__ for kind in classes())
    result = Result()
    setattr(result, new, 1)
    with pytest.warns(DeprecationWarning, match=f"Result.{old} is {new}") as warned:
        assert getattr(result, old) == 1
    assert warned[0].filename == __file__


def test_an_old_argument_and_value_warn_and_work() -> None:
    with pytest.warns(DeprecationWarning, match=r"contact_modulus\(first=\)"):
        old = rc.contact_modulus(first=STEEL, counter_material=STEEL)  # type: ignore[call-arg]
    assert old == rc.contact_modulus(STEEL, STEEL)
    ball = nominal_bodies.sphere(radius=1e-3, shape=(24, 24), pixel=(2.5e-6, 2.5e-6))
    with pytest.warns(DeprecationWarning, match="calibrated"):
        result = rc.solve(ball, material=STEEL, load=0.5, ceiling="recommended")
    assert result.calibration is None or result.calibration.factor > 0
    with pytest.warns(DeprecationWarning, match="center_of_pressure"):
        assert result.centre_of_pressure == result.center_of_pressure  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = result.nonsense  # type: ignore[attr-defined]


def test_old_attributes_of_every_result_warn_and_work() -> None:
    surface = rc.Surface(*rc.reference_map(32))
    curve = rc.sweep(surface, loads=["10 MPa", "20 MPa"], material=STEEL)
    history = rc.history(surface, ["20 MPa", 0.0], material=STEEL)
    wanted = rc.find_load(surface, contact_fraction=0.02, material=STEEL)
    conductor = rc.Conductor(1e-7, 50.0)
    joint = rc.conductance(history.largest, conductor, conductor)
    for owner, old in (
        (curve, "given"),
        (curve, "found"),
        (curve, "remarks"),
        (curve.steps[0], "corrected_contact_area"),
        (history, "given"),
        (history, "recommended"),
        (history, "shaken_down"),
        (wanted, "remarks"),
        (wanted.answers[0], "below"),
        (joint, "beside"),
        (joint, "found"),
        (STEEL, "at_odds"),
    ):
        new = deprecated.ATTRIBUTES[old]
        with pytest.warns(DeprecationWarning, match=f"{type(owner).__name__}.{old} is {new}"):
            assert getattr(owner, old) == getattr(owner, new)
    assert not hasattr(surface, "given")


def test_old_option_works_with_one_message(capsys: pytest.CaptureFixture[str]) -> None:
    assert app.main(["solve", *BALL, "--holes", "mask"]) == app.SOLVED
    out, err = capsys.readouterr()
    assert json.loads(out)["converged"]
    assert err.count("'missing'") == err.count("\n") == 1


def test_an_old_key_of_a_project_is_read(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((9, 9)))
    path = tmp_path / "p.toml"
    path.write_text(
        '[defaults]\nholes = "mask"\n[[contact]]\nname = "a"\nfile = "a.npy"\nunit = "um"\n'
        'size = "9 um x 9 um"\nyoung = "210 GPa"\npoisson = 0.3\nload = "1 mN"\n',
        encoding="utf-8",
    )
    with pytest.warns(DeprecationWarning, match="missing"):
        (entry,) = project.read_project(path)
    assert entry.request.specified["missing"] == "mask"


def test_run_by_mpiexec_raises_input_error(monkeypatch: pytest.MonkeyPatch) -> None:
    for value in ("", "1"):
        monkeypatch.setenv("PMI_SIZE", value)
        deprecated.reject_mpi_run()
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    with pytest.raises(rc.InputError, match="start a single one"):
        deprecated.reject_mpi_run()
