from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.result import ContactResult
from roughcontact.material import hardening
from roughcontact.report import script

STEEL = rc.Material(210e9, 0.3, 1e9, name="steel")


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two files that name their instrument and have a hole each."""
    path = tmp_path_factory.mktemp("script")
    for name, seed in (("ground.nc", 0), ("other.nc", 1)):
        heights, pixel = rc.reference_map(48, seed)
        heights = heights + 1e-3 * pixel[1] * np.arange(48)
        heights[20:22, 30] = np.nan
        surface = rc.Surface(heights, pixel).masked()
        # A result holds its map, and is thereby a file that `read_surface` knows.
        rc.solve(surface, material=STEEL, load=0.1).save(path / name)
    return path


@pytest.fixture
def folder(files: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """That folder to work in."""
    monkeypatch.chdir(files)
    return files


def repeated(result: ContactResult) -> dict[str, Any]:
    names: dict[str, Any] = {}
    exec(script.repeating(result), names)
    return names


PREPARATIONS: dict[str, Callable[[rc.Surface], rc.Surface]] = {
    "plane": lambda s: s.leveled().filled(),
    "quadric": lambda s: s.leveled("quadric").filled(),
    "mean": lambda s: s.leveled("mean").masked(),
    "robust": lambda s: s.leveled("robust").filled(),
    "three-point": lambda s: s.leveled("three-point", [(0, 0), (40, 3), (7, 41)]).masked(),
    "sphere": lambda s: s.without_form("sphere").filled(),
    "cylinder": lambda s: s.filled().without_form("cylinder"),
    "polynomial": lambda s: s.without_form("polynomial", 3).filled(),
    "outliers": lambda s: s.without_outliers(2.5, 7).filled(),
    "cropped": lambda s: s.cropped((2, 19), (1, 40)),
    "largest rectangle": lambda s: s.largest_rectangle(),
    "rotated": lambda s: s.filled().rotated(3),
    "resampled": lambda s: s.filled().resampled((40, 36)),
    "spline": lambda s: s.filled().resampled((40, 36), method="spline"),
    "S-filter": lambda s: s.filled().filtered(s=5e-6),
    "L-filter": lambda s: s.leveled().filled().filtered(l=4e-5),
    "band": lambda s: s.filled().filtered(s=4.5e-6, l=3e-5),
}


@pytest.mark.parametrize("name", PREPARATIONS)
def test_the_script_prepares_as_the_result_was(name: str, folder: Path) -> None:
    surface = PREPARATIONS[name](rc.read_surface("ground.nc"))
    assert surface.provenance.steps
    result = rc.solve(surface, material=STEEL, load=0.1)
    names = repeated(result)
    np.testing.assert_array_equal(names["surface"].heights, surface.heights)
    assert names["surface"].provenance == surface.provenance
    assert names["result"].pressure.tobytes() == result.pressure.tobytes()


PROBLEMS: dict[str, dict[str, Any]] = {
    "approach": {"approach": 1.23456789e-7},
    "elastic": {"load": 1 / 3, "ceiling": None},
    "ceiling": {"load": 1.0, "ceiling": 2.5e9},
    "periodic": {"load": 0.1, "boundary": "periodic", "tolerance": 1e-5},
    "single": {"load": 0.1, "precision": "single"},
    "moments": {"load": 0.1, "moments": (0.1 * 1e-6, -0.1 * 2e-6)},
    "hardness": {"load": 1.0, "material": rc.Material(400e9, 0.2, None, "alumina", 15e9)},
    "stamp": {"load": 0.1, "material": rc.RIGID, "counter_material": STEEL},
    "elastic counter-body": {
        "load": 0.1,
        "counter_material": rc.Material(np.float64(70e9), 0.33, None, 'a "soft" one'),
    },
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_script_states_the_problem(name: str, folder: Path) -> None:
    problem = {"material": STEEL, **PROBLEMS[name]}
    result = rc.solve(rc.read_surface("ground.nc").filled(), **problem)
    again = repeated(result)["result"]
    assert again.pressure.tobytes() == result.pressure.tobytes()
    for field in ("material", "counter_material", "ceiling", "boundary", "precision", "control",
                  "moments"):  # fmt: skip
        assert getattr(again, field) == getattr(result, field)
    assert again.tolerance == result.tolerance


def test_the_second_body_is_read_too(folder: Path) -> None:
    result = rc.solve(
        rc.read_surface("ground.nc").filled(),
        counter_surface=rc.read_surface("other.nc").leveled().filled(),
        material=STEEL,
        load=0.1,
    )
    again = repeated(result)["result"]
    assert again.pressure.tobytes() == result.pressure.tobytes()


def result_of(about: rc.Provenance, ceiling: Any = None) -> ContactResult:
    heights, pixel = rc.reference_map(32)
    surface = rc.Surface(heights, pixel, about)
    return rc.solve(surface, material=STEEL, load=0.1, ceiling=ceiling)


@pytest.mark.parametrize(
    "about",
    [
        rc.Provenance(),
        rc.Provenance("generated, Hurst exponent 0.8"),
        rc.Provenance("heights.npy", "matrix (npy)"),
        rc.Provenance("ground.opd", "Wyko", steps=("polished: by hand",)),
        rc.Provenance("ground", "Wyko"),
        rc.Provenance("gro\nund.opd", "Wyko"),
        rc.Provenance(
            "a.opd", "W", steps=("leveled: plane through the points __import__('os') subtracted",)
        ),
    ],
)
def test_no_script_where_the_result_tells_too_little(about: rc.Provenance) -> None:
    assert script.repeating(result_of(about)) == ""


def test_no_script_for_a_ceiling_by_point() -> None:
    about = rc.Provenance("ground.opd", "Wyko")
    assert script.repeating(result_of(about)) != ""
    assert script.repeating(result_of(about, np.full((32, 32), 3e9))) == ""


@pytest.mark.parametrize("name", ["a\"b.opd", "a\\b.opd", "ä'b.opd"])  # fmt: skip
def test_names_are_quoted(name: str) -> None:
    text = script.repeating(result_of(rc.Provenance(name, "Wyko", channel=name + "\n")))
    read: list[Any] = []

    class Fake:
        @staticmethod
        def read_surface(path: str, channel: str) -> None:
            read.extend([path, channel])

    line = next(line for line in text.splitlines() if line.startswith("surface"))
    exec(line, {"rc": Fake})
    assert read == [name, name + "\n"]


def test_the_script_follows_the_path_of_the_volume_again(folder: Path) -> None:
    surface = rc.read_surface("ground.nc").leveled().filled().cropped((0, 24), (0, 26))
    body = rc.Material(210e9, 0.3, hardening=hardening.Linear(1e9, 2e9), name="steel")
    result = rc.solve_elastoplastic(
        surface, material=body, counter_material=rc.Material(70e9, 0.33),
        loads=[0.02, 0.03, 0.0], boundary="periodic", tolerance=2e-4, depth=40e-6,
    )  # fmt: skip
    names: dict[str, Any] = {}
    exec(script.repeating_volume(result), names)
    again = names["result"]
    assert again.contact.material == body
    assert [s.load for s in again.increments] == [s.load for s in result.increments]
    # Layers are written with six digits.
    thickness = result.bodies[0].thickness
    np.testing.assert_allclose(again.bodies[0].thickness, thickness, rtol=1e-5)
    assert again.max_plastic_strain == pytest.approx(result.max_plastic_strain, rel=1e-3)
    np.testing.assert_allclose(
        again.residual_displacement, result.residual_displacement,
        atol=2e-3 * result.residual_displacement.max(),
    )  # fmt: skip
    assert (again.tolerance, again.contact.boundary) == (2e-4, "periodic")


def test_no_script_for_a_volume_of_an_unknown_map() -> None:
    heights, pixel = rc.reference_map(32)
    result = rc.solve_elastoplastic(
        rc.Surface(heights, pixel), material=STEEL, loads=[0.01], boundary="periodic"
    )
    assert script.repeating_volume(result) == ""
