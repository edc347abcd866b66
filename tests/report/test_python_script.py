import contextlib
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import roughcontact as rc
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.halfspace import boundary
from roughcontact.material import hardening
from roughcontact.report import python_script
from roughcontact.surface import nominal_bodies, placement
from roughcontact.surface.provenance import Operation, from_text, to_text

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
    exec(python_script.script_of_result(result), names)
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
    "inverted": lambda s: s.inverted().filled(),
    "flipped": lambda s: s.filled().flipped("y"),
    "rotated": lambda s: s.filled().rotated(270),
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
    "strip": {"load": 0.1, "boundary": "periodic-y", "ceiling": 2e9},
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
    for field in (
        "material",
        "counter_material",
        "ceiling",
        "boundary",
        "precision",
        "control",
        "moments",
    ):
        assert getattr(again, field) == getattr(result, field)
    assert again.tolerance == result.tolerance


@pytest.mark.long
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


@pytest.mark.long
def test_two_maps_on_nominal_forms_are_laid_on_each_other_again(folder: Path) -> None:
    maps = [rc.read_surface(name).leveled().filled() for name in ("ground.nc", "other.nc")]
    one, two = placement.match_grids(*maps, (1.3e-6, 1e-6 / 3), angle=12.5, mirrored=True)
    on: Any = {"shape": one.shape, "pixel": one.pixel}
    result = rc.solve(
        one.with_form(nominal_bodies.cylinder(radius=0.01, angle=30, **on)),
        counter_surface=two.with_form(nominal_bodies.sphere(radius=1 / 30, **on)),
        material=STEEL,
        counter_material=STEEL,
        load=0.1,
        moments=(0.0, 1e-8 / 3),
    )
    names = repeated(result)
    assert names["result"].pressure.tobytes() == result.pressure.tobytes()
    assert names["result"].tilt == result.tilt
    assert names["counter_surface"].provenance == result.counter_surface.provenance


def test_script_recreates_nominal_bodies(tmp_path: Path) -> None:
    ball = nominal_bodies.parse("sphere 10 mm")(
        shape=(40, 44), pixel=(1e-6, 1e-6), center=(20, 21.5)
    )
    wedge = nominal_bodies.parse("wedge 0.001 30 deg")(shape=ball.shape, pixel=ball.pixel)
    result = rc.solve(ball, counter_surface=wedge, material=STEEL, approach=1e-9 / 3)
    # As it is after a night in a file.
    result.save(tmp_path / "a.nc")
    again = repeated(rc.read_result(tmp_path / "a.nc"))["result"]
    assert again.pressure.tobytes() == result.pressure.tobytes()


def test_an_array_in_memory_has_to_be_supplied(folder: Path) -> None:
    heights, pixel = rc.reference_map(32)
    about = rc.Provenance("made\nup", "", "top", steps=('polished: by "hand"',))
    counter = rc.Surface(1e-9 * np.arange(1024.0).reshape(32, 32), pixel).rotated()
    surface = rc.Surface(heights, pixel, about).leveled()
    result = rc.solve(surface, counter_surface=counter, material=STEEL, load=0.1)
    text = python_script.script_of_result(result)
    assert "supply it as surface.npy, 32 × 32 heights in meters" in text
    assert "supply it as counter_surface.npy" in text
    np.save("surface.npy", heights)
    np.save("counter_surface.npy", 1e-9 * np.arange(1024.0).reshape(32, 32))
    names = repeated(result)
    assert names["result"].pressure.tobytes() == result.pressure.tobytes()
    assert names["surface"].provenance == surface.provenance


def test_a_form_in_memory_has_to_be_supplied(folder: Path) -> None:
    surface = rc.read_surface("ground.nc").filled()
    forms = [rc.Surface(z * surface.heights[::-1], surface.pixel) for z in (0.5, 0.25)]
    whole = surface.with_form(forms[0]).with_form(forms[1].leveled())
    text = python_script.script_of_map(whole)
    assert "supply it as form.npy, 48 × 48 heights in meters, SHA-256 of its bytes" in text
    for name, form in zip(("form.npy", "form_2.npy"), forms, strict=True):
        np.save(name, form.heights)
    names: dict[str, Any] = {}
    exec(text, names)
    assert names["surface"].heights.tobytes() == whole.heights.tobytes()


@pytest.mark.long
def test_unrepeatable_surface_is_read_from_result_file(folder: Path) -> None:
    surface = rc.read_surface("ground.nc").filled()
    step = Operation("indented", found={"depth": 1e-9})
    known = dataclasses.replace(surface, provenance=surface.provenance.then(step))
    value = dataclasses.replace(surface, provenance=rc.Provenance("a.opd", steps=("by\nhand",)))
    for about, words in ((known, "indented: by up to 1 nm"), (value, "by hand")):
        result = rc.solve(about, material=STEEL, load=0.1)
        result.save("result.nc")
        text = python_script.script_of_result(result)
        assert f"# No script can repeat these steps: {words}" in text
        names = repeated(result)
        assert names["surface"].heights.tobytes() == surface.heights.tobytes()
        assert names["result"].pressure.tobytes() == result.pressure.tobytes()


@pytest.mark.long
def test_a_ceiling_by_point_is_in_the_file_of_the_result(folder: Path) -> None:
    surface = rc.read_surface("ground.nc").filled()
    ceiling = np.linspace(2e9, 3e9, surface.heights.size).reshape(surface.shape)
    result = rc.solve(surface, material=STEEL, load=1.0, ceiling=ceiling)
    result.save("result.nc")
    assert repeated(result)["result"].pressure.tobytes() == result.pressure.tobytes()


@pytest.mark.parametrize("name", ['a"b.npy', "a\\b.npy", "ä'b.npy", "__import__('os').npy"])
def test_names_are_quoted(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.save(name, rc.reference_map(32)[0])
    surface = rc.read_surface(name, unit="m", size=(1e-4, 1e-4))
    result = rc.solve(surface, material=STEEL, load=0.1)
    assert repeated(result)["surface"].provenance.source == name


def test_text_of_file_is_not_executed(tmp_path: Path) -> None:
    heights, pixel = rc.reference_map(32)
    about = rc.Provenance("a\nraise SystemExit", "b\r", '"', steps=("c\u2028raise SystemExit",))
    for surface in (rc.Surface(heights, pixel, about), rc.Surface(heights, pixel, about).leveled()):
        text = python_script.script_of_result(rc.solve(surface, material=STEEL, load=0.1))
        compile(text, "script", "exec")
        assert not any(line.startswith("raise") for line in text.splitlines())


# --- every method of `Surface`, in any order ------------------------------------------------------


def _grid(draw: st.DrawFn, surface: rc.Surface) -> rc.Surface:
    ny, nx = draw(st.tuples(st.integers(6, 14), st.integers(6, 14)))
    edges = [
        draw(st.floats(0.4, 1.3)) * size / n for size, n in zip(surface.size, (ny, nx), strict=True)
    ]
    return nominal_bodies.flat(shape=(ny, nx), pixel=(edges[0], edges[1]))


def _form(draw: st.DrawFn, surface: rc.Surface) -> rc.Surface:
    on: Any = {"shape": surface.shape, "pixel": surface.pixel}
    radius, angle = draw(st.floats(1e-4, 1.0)), draw(st.floats(-200, 200))
    center = draw(st.none() | st.tuples(st.floats(0, 5), st.floats(0, 5)))
    # Too many points beyond the body leave nothing, or unhandled holes of the map outside.
    wide = 2 * max(surface.size)
    bodies: list[Callable[[], rc.Surface]] = [
        lambda: nominal_bodies.flat(**on),
        lambda: nominal_bodies.sphere(radius=wide + radius, center=center, **on),
        lambda: nominal_bodies.sphere(radius=radius, **on),
        lambda: nominal_bodies.cylinder(radius=wide + radius, angle=angle, center=center, **on),
        lambda: nominal_bodies.ellipsoid(radii=(radius, 0.3), angle=angle, center=center, **on),
        lambda: nominal_bodies.punch(radius=wide, edge_radius=wide / 3, **on),
        lambda: nominal_bodies.rectangular_punch(sides=(1.0, 2.0), **on),
        lambda: nominal_bodies.cone(slope=radius, center=center, **on),
        lambda: nominal_bodies.wedge(slope=radius, angle=angle, **on),
        lambda: rc.read_surface("counter.csv", unit="nm", size=(1.0, 1.0)).aligned(surface),
    ]
    body = draw(st.sampled_from(bodies))()
    return body.rotated(180) if draw(st.booleans()) else body


def _resampled(draw: st.DrawFn, s: rc.Surface) -> rc.Surface:
    method = draw(st.sampled_from(["bandlimited", "spline"]))
    if draw(st.booleans()):
        return s.resampled((draw(st.integers(6, 16)), draw(st.integers(6, 16))), method=method)
    scale = draw(st.floats(0.5, 1.5))
    return s.resampled(pixel=(s.pixel[0] * scale, s.pixel[1] / scale), method=method)


def _cropped(draw: st.DrawFn, s: rc.Surface) -> rc.Surface:
    rows, columns = ((draw(st.integers(0, 2)), n - draw(st.integers(0, 2))) for n in s.shape)
    return s.cropped(rows, columns)


def _leveled(draw: st.DrawFn, s: rc.Surface) -> rc.Surface:
    form = draw(st.sampled_from(["plane", "quadric", "mean", "robust", "three-point"]))
    points = [(0, 0), (0, np.int64(4)), (4, 0)] if form == "three-point" else None
    return s.leveled(form, points)


def _filtered(draw: st.DrawFn, s: rc.Surface) -> rc.Surface:
    shortest = 2 * max(s.pixel)
    cutoffs = st.floats(shortest, max(shortest, 0.9 * min(s.size)))
    return s.filtered(s=draw(st.none() | cutoffs), l=draw(cutoffs))


STEPS: dict[str, Callable[[st.DrawFn, rc.Surface], rc.Surface]] = {
    "leveled": _leveled,
    "without_form": lambda draw, s: s.without_form(
        *draw(st.sampled_from([("sphere",), ("cylinder",), ("polynomial", 3)]))
    ),
    "without_outliers": lambda draw, s: s.without_outliers(
        draw(st.floats(1.5, 9)), draw(st.sampled_from([3, np.int64(5)]))
    ),
    "filled": lambda draw, s: s.filled(),
    "masked": lambda draw, s: s.masked(),
    "cropped": _cropped,
    "largest_rectangle": lambda draw, s: s.largest_rectangle(),
    "inverted": lambda draw, s: s.inverted(),
    "flipped": lambda draw, s: s.flipped(draw(st.sampled_from("xy"))),
    "rotated": lambda draw, s: s.rotated(draw(st.sampled_from([90, 180.0, -90, 450]))),
    "resampled": _resampled,
    "filtered": _filtered,
    "with_form": lambda draw, s: s.with_form(_form(draw, s)),
    "aligned": lambda draw, s: s.aligned(
        _grid(draw, s),
        (draw(st.floats(-2e-6, 2e-6)), np.float64(1e-6)),
        draw(st.sampled_from([0, 90]) | st.floats(-180, 180)),
        draw(st.booleans()),
    ),
}


def test_no_method_is_forgotten() -> None:
    from inspect import getdoc, getmembers, isfunction

    prepares = {
        name
        for name, method in getmembers(rc.Surface, isfunction)
        if not name.startswith("_") and "Surface" == str(method.__annotations__.get("return"))
    }
    assert prepares == set(STEPS)
    assert all(getdoc(getattr(rc.Surface, name)) for name in prepares)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with small maps in files that say little of themselves."""
    path = tmp_path_factory.mktemp("small")
    rng = np.random.default_rng(5)
    heights = 1e-7 * rng.normal(size=(13, 11)) + 1e-8 * np.arange(11)
    heights[4, 5] = heights[9:11, 2] = np.nan
    np.save(path / "map.npy", 1e6 * heights)
    np.savez(path / "maps.npz", other=heights, heights=heights[:, ::-1])
    head = "\n".join(
        [
            "# roughcontact map",
            "# quantity: height",
            "# unit: nm",
            "# pixel_y: 2 um",
            "# pixel_x: 1.5 um",
            "",
        ]
    )
    rows = "\n".join(
        ",".join("" if np.isnan(z) else repr(float(z)) for z in row) for row in 1e9 * heights
    )
    (path / "map.csv").write_text(head + rows + "\n")
    np.savetxt(path / "counter.csv", rng.normal(size=(9, 8)), delimiter=",")
    np.save(path / "surface.npy", heights)
    return path


def _read_surface(kind: str) -> rc.Surface:
    match kind:
        case "npy":
            return rc.read_surface(Path("map.npy"), unit="um", size="26 um x 22 um")
        case "npz":
            return rc.read_surface("maps.npz", "npz", "other", "m", (np.float64(2.6e-5), 2.2e-5))
        case "csv":
            return rc.read_surface("map.csv")
        case "memory":
            return rc.Surface(np.load("surface.npy"), (2e-6, 2e-6))
    return nominal_bodies.sphere(radius=5e-4, shape=(13, 11), pixel=(2e-6, 2e-6), center=(3, 4.5))


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.data())
def test_the_script_repeats_any_chain_of_steps_to_the_bit(small: Path, data: st.DataObject) -> None:
    with contextlib.chdir(small):
        surface = _read_surface(
            data.draw(st.sampled_from(["npy", "npz", "csv", "memory", "sphere"]))
        )
        for name in data.draw(st.lists(st.sampled_from(sorted(STEPS)), max_size=6)):
            # Not every step is possible after any other.
            with contextlib.suppress(InputError):
                surface = STEPS[name](data.draw, surface)
        names: dict[str, Any] = {}
        text = python_script.script_of_map(surface)
        exec(text, names)
        again = names["surface"]
        assert again.heights.tobytes() == surface.heights.tobytes()
        assert again.pixel == surface.pixel
        assert again.holes_masked == surface.holes_masked
        assert again.provenance == surface.provenance
        # And so it does from a file.
        kept = from_text(to_text(surface.provenance))
        assert kept == surface.provenance
        assert kept.steps == surface.provenance.steps


def test_the_script_follows_the_path_of_the_volume_again(folder: Path) -> None:
    surface = rc.read_surface("ground.nc").leveled().filled().cropped((0, 24), (0, 26))
    law = hardening.Kinematic(hardening.Linear(1e9, 2e9), 20e9)
    body = rc.Material(210e9, 0.3, hardening=law, name="steel")
    result = rc.solve_elastoplastic(
        surface,
        material=body,
        counter_material=rc.Material(70e9, 0.33),
        increments=1,
        loads=[0.02, 0.03, 0.0],
        boundary="periodic",
        tolerance=2e-4,
        depth=40e-6,
    )
    names: dict[str, Any] = {}
    exec(python_script.repeating_volume(result), names)
    again = names["result"]
    assert again.contact.material == body
    assert [s.load for s in again.increments] == [s.load for s in result.increments]
    assert again.bodies[0].thickness.tobytes() == result.bodies[0].thickness.tobytes()
    assert again.max_plastic_strain == result.max_plastic_strain
    assert again.residual_displacement.tobytes() == result.residual_displacement.tobytes()
    assert (again.tolerance, again.contact.boundary) == (2e-4, "periodic")


def test_a_boundary_that_does_not_repeat_is_stated_too(monkeypatch: pytest.MonkeyPatch) -> None:
    wavy = rc.Surface(1e-8 * np.cos(np.arange(16) * np.ones((16, 1)) * np.pi / 8), (1e-6, 1e-6))
    result = rc.solve(wavy, material=STEEL, load=1e-3, boundary="periodic")
    plain = boundary._MODELS[boundary.Boundary.PERIODIC]._replace(periodic_axes=())
    monkeypatch.setitem(boundary._MODELS, boundary.Boundary.PERIODIC, plain)
    assert 'boundary="periodic"' in python_script.script_of_result(result)
