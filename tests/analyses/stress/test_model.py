import math
import tracemalloc

import numpy as np
import psutil
import pytest
import xarray

import roughcontact as rc
from roughcontact.analyses.stress import model as subsurface_stress
from roughcontact.cautions import CautionTag
from roughcontact.halfspace import stress, stress_summary, tensors
from roughcontact.report.presentation import presentation_of
from roughcontact.surface import nominal_bodies, shapes
from roughcontact.theory import hertz

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9, name="steel")
SOFT = rc.Material(70e9, 0.2)
PIXEL = (1e-6, 1.2e-6)
RADIUS = 10e-3


def ball(n=96, radius=RADIUS, pixel=PIXEL):
    return rc.Surface(shapes.paraboloid((n, n), pixel, radius), pixel)


@pytest.fixture(scope="module")
def contact_result():
    return rc.solve(ball(), material=STEEL, counter_material=SOFT, load=0.15)


@pytest.fixture(scope="module")
def stress_result(contact_result):
    return subsurface_stress.subsurface_stress(contact_result)


def test_stress_matches_summary_of_pressure(contact_result, stress_result):
    expected = stress_summary.summarize(contact_result.pressure, PIXEL, 0.3, yield_strength=1e9)
    for name, value in vars(expected).items():
        np.testing.assert_array_equal(getattr(stress_result.profile, name), value)
    assert stress_result.material is STEEL
    assert stress_result.max_von_mises == expected.max_von_mises
    assert stress_result.yield_factor == expected.yield_factor
    assert stress_result.yielded_volume == expected.yielded_volume
    row, column = expected.pixel_of_max
    assert stress_result.max_von_mises_at == (
        expected.depth_of_max,
        (row + 0.5) * PIXEL[0],
        (column + 0.5) * PIXEL[1],
    )


@pytest.mark.parametrize("body", ["body", "counter_body"])
def test_a_traction_map_pulls_both_bodies_in_opposite_directions(contact_result, tmp_path, body):
    traction = 0.3 * contact_result.pressure * np.array([0.6, 0.8])[:, None, None]
    # Angles are counter-clockwise as drawn, rows count downwards.
    angle = math.degrees(math.atan2(-0.6, 0.8))
    found = subsurface_stress.subsurface_stress(contact_result, in_body=body, traction=traction)
    expected = subsurface_stress.subsurface_stress(
        contact_result, in_body=body, friction=0.3, direction=angle
    )
    np.testing.assert_allclose(found.profile.von_mises, expected.profile.von_mises, rtol=1e-5)
    np.testing.assert_allclose(found.section_x, expected.section_x, rtol=0, atol=1e-5 * 1e9)
    assert found.max_tension_at == expected.max_tension_at
    found.save(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc") as dataset:
        np.testing.assert_array_equal(dataset["traction_y"], traction[0])
    with pytest.raises(rc.InputError, match="traction"):
        subsurface_stress.subsurface_stress(contact_result, friction=0.3, traction=traction)


def test_planes_go_through_the_largest_stress(stress_result):
    deepest = stress_result.profile.von_mises.argmax()
    row, column = stress_result.profile.pixel_of_max
    for along, pixel in (("x", column), ("y", row)):
        plane = stress_result.von_mises_section(along)
        assert plane.shape == (stress_result.profile.depths.size, 96)
        # A symmetric contact has it in more than one place.
        assert plane[deepest, pixel] == pytest.approx(plane.max(), rel=1e-6)
        # Both in single precision, by other transforms.
        assert plane.max() == pytest.approx(stress_result.max_von_mises, rel=1e-5)
    assert stress_result.section_x.shape == (6, stress_result.profile.depths.size, 96)
    with pytest.raises(rc.InputError, match=r"along.*'z'"):
        stress_result.von_mises_section("z")


def test_the_bodies_differ_by_ratio_and_sign(contact_result):
    options = {"friction": 0.3, "direction": 30.0, "depths": [1e-9, 5e-6], "precision": "double"}
    first = subsurface_stress.subsurface_stress(contact_result, **options)
    second = subsurface_stress.subsurface_stress(contact_result, in_body="counter_body", **options)
    for body, sign, ratio in ((first, 1, 0.3), (second, -1, 0.2)):
        point = body.profile.pixel_of_max
        pull = {"friction": 0.3 * sign, "direction": math.radians(-30), "precision": "double"}
        pieces = stress.slices(contact_result.pressure, PIXEL, [1e-9, 5e-6], ratio, **pull)
        expected = [piece.stress[:, point[0]] for piece in pieces]
        np.testing.assert_array_equal(body.section_x, np.stack(expected, axis=1))
        # Only the traction of the surface: opposite on the two bodies.
        pulled = body.section_x[tensors.XZ, 0].sum()
        assert np.sign(pulled) == -sign
    assert second.material is SOFT
    assert second.yield_factor is second.yielded_volume is None


def test_periodic_contacts_have_periodic_stress():
    heights, pixel = rc.reference_map(64)
    result = rc.solve(rc.Surface(heights, pixel), material=STEEL, load=1.0, boundary="periodic")
    below = subsurface_stress.subsurface_stress(result, [1e-9, 1e-3], precision="double")
    # Far below only the mean pressure is left.
    mean = result.pressure.mean()
    np.testing.assert_allclose(below.section_x[2, 1], -mean, rtol=1e-6)
    np.testing.assert_allclose(below.section_y[0, 1], -0.3 / 0.7 * mean, rtol=1e-6)


def test_arrays_are_read_only(stress_result):
    for array in (
        stress_result.section_x,
        stress_result.section_y,
        stress_result.profile.peak,
        stress_result.profile.depths,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_warnings(contact_result, stress_result):
    def caution_kinds(result):
        return {caution.kind for caution in result.own_cautions}

    assert CautionTag.YIELDED not in caution_kinds(stress_result)
    shallow = subsurface_stress.subsurface_stress(contact_result, [1e-9, 1e-6])
    assert caution_kinds(shallow) >= {CautionTag.STRESS_DEPTH, CautionTag.STRESS_PIXEL}
    hard = rc.solve(ball(radius=1e-3), material=STEEL, load=2.0, ceiling=None)
    beyond = subsurface_stress.subsurface_stress(hard)
    assert CautionTag.YIELDED in caution_kinds(beyond)
    # And those of the contact.
    assert set(hard.warnings) <= set(beyond.warnings)
    assert beyond.yield_factor < 1
    assert beyond.yielded_volume > 0


def test_saved_dataset_holds_everything(stress_result, tmp_path):
    path = tmp_path / "below.nc"
    stress_result.save(path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["below.nc"]
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        profile = stress_result.profile
        for name in ("von_mises", "tresca", "orthogonal_shear", "yielded_area"):
            np.testing.assert_array_equal(data[name], getattr(profile, name))
        np.testing.assert_array_equal(data["depth"], profile.depths)
        np.testing.assert_array_equal(data["row"], profile.pixels[:, 0])
        np.testing.assert_array_equal(data["column"], profile.pixels[:, 1])
        np.testing.assert_array_equal(data["peak_von_mises"], profile.peak)
        np.testing.assert_array_equal(data["section_x"], stress_result.section_x)
        np.testing.assert_array_equal(data["section_y"], stress_result.section_y)
        np.testing.assert_array_equal(data["pressure"], stress_result.solution.pressure)
        assert list(data["component"].values) == list(tensors.COMPONENTS)
        assert data.attrs["material_yield_strength"] == 1e9
        assert data.attrs["load"] == 0.15
        assert data.attrs["body"] == "body"
        assert (
            data.attrs["max_von_mises_depth"],
            data.attrs["max_von_mises_y"],
            data.attrs["max_von_mises_x"],
        ) == stress_result.max_von_mises_at
        for name, variable in data.data_vars.items():
            assert "units" in variable.attrs, name
    with pytest.raises(rc.InputError, match=r"\.nc"):
        stress_result.save(tmp_path / "below.npz")


def test_bad_arguments(contact_result):
    with pytest.raises(rc.InputError, match="ContactResult, got ndarray"):
        subsurface_stress.subsurface_stress(contact_result.pressure)
    with pytest.raises(rc.InputError, match=r"body.*'third'"):
        subsurface_stress.subsurface_stress(contact_result, in_body="third")
    on_rigid = rc.solve(ball(), material=STEEL, load=0.1)
    with pytest.raises(rc.InputError, match="counter-body is rigid"):
        subsurface_stress.subsurface_stress(on_rigid, in_body="counter_body")


def test_insufficient_memory_raises_error(contact_result, monkeypatch):
    need = subsurface_stress.memory_estimate((96, 96))

    class Memory:
        available = need - 1

    monkeypatch.setattr(psutil, "virtual_memory", Memory)
    with pytest.raises(rc.InsufficientMemoryError, match="96 × 96"):
        subsurface_stress.subsurface_stress(contact_result, [1e-6])
    Memory.available = need
    subsurface_stress.subsurface_stress(contact_result, [1e-6])


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_memory_estimate_matches_allocation(boundary, precision, friction):
    options = {"boundary": boundary, "precision": precision, "friction": friction}
    pressure = np.zeros((300, 400))
    pressure[100:180, 100:250] = 1e9
    tracemalloc.start()
    stress_summary.summarize(
        pressure, PIXEL, 0.3, depths=[0.0, 1e-7, 3e-5, 2e-4], direction=0.5, workers=1, **options
    )
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # Buffers of the thread, a few MB, come on top; fast lengths are a little longer.
    estimate, without = (
        subsurface_stress.memory_estimate(shape, **options) for shape in (pressure.shape, (1, 1))
    )
    estimate -= without
    assert 0.9 * estimate < peak < 1.3 * estimate + 8e6


@pytest.mark.long
@pytest.mark.parametrize("poisson", [0.2, 0.3])
@pytest.mark.parametrize("start", [None, 5.0])
def test_first_yield_of_sphere_matches_hertz(poisson, start):
    material = rc.Material(210e9, poisson, yield_strength=1e9)
    modulus = rc.contact_modulus(material, rc.RIGID)
    expected = hertz.first_yield_load(RADIUS, modulus, material.first_yield_pressure)
    a = hertz.contact_radius(expected, RADIUS, modulus)
    pixel = (a / 30, a / 30)
    onset = rc.first_yield_load(ball(96, pixel=pixel), material=material, initial_load=start)
    # The pressure is requested to 1 %, of which the fit of Jackson and Green takes a part.
    assert onset.solution.max_pressure == pytest.approx(material.first_yield_pressure, rel=0.01)
    assert onset.solution.load == pytest.approx(expected, rel=0.03)
    assert onset.yield_factor == pytest.approx(1, abs=1e-3)
    assert onset.solution.ceiling is None


@pytest.mark.long
def test_onset_in_the_counter_body_and_with_friction():
    soft = rc.Material(70e9, 0.33, yield_strength=0.2e9)
    options = {
        "material": rc.Material(210e9, 0.3),
        "counter_material": soft,
        "body": "counter_body",
    }
    # The contact is 30 pixels in radius.
    plain = rc.first_yield_load(ball(radius=3.5e-3), **options)
    sliding = rc.first_yield_load(ball(radius=3.5e-3), friction=0.4, **options)
    assert plain.material is soft
    assert plain.solution.max_pressure == pytest.approx(soft.first_yield_pressure, rel=0.015)
    # With friction the load of first yield falls.
    assert sliding.solution.load < 0.9 * plain.solution.load


def test_onset_needs_a_yield_strength(monkeypatch):
    with pytest.raises(rc.InputError, match="no yield strength"):
        rc.first_yield_load(ball(), material=SOFT)
    with pytest.raises(rc.InputError, match=r"body.*'third'"):
        rc.first_yield_load(ball(), material=STEEL, body="third")
    with pytest.raises(rc.InputError, match=r"start.*-1"):
        rc.first_yield_load(ball(), material=STEEL, initial_load=-1.0)
    monkeypatch.setattr(subsurface_stress, "_MAX_SOLVES", 1)
    with pytest.raises(rc.ConvergenceError, match="after 1 contacts") as caught:
        rc.first_yield_load(ball(), material=STEEL)
    assert caught.value.result.pressure.max() > 0


@pytest.mark.parametrize("power", [0.1, 1 / 3, 1.0, 3.0])
def test_the_search_finds_any_power(power):
    known, at = [], -12.0
    while not known or abs(known[-1][1]) > 1e-6:
        # A power with a bend, like a contact that spreads over a map.
        known.append((at, power * (at - 2.0) + 0.3 * power * math.sin(at)))
        at = subsurface_stress._next_load(known)
        assert len(known) < 30


@pytest.mark.parametrize("depths", [[0.0], [1e-6, -1e-6]])
def test_depths_must_be_below_surface(depths):
    result = rc.solve(rc.Surface(*rc.reference_map(32)), material=STEEL, load=0.1)
    with pytest.raises(rc.InputError, match="depths must be below the surface"):
        subsurface_stress.subsurface_stress(result, depths)


def test_given_depths_do_not_hide_that_the_body_yields() -> None:
    ball = nominal_bodies.sphere(radius=5e-3, shape=(64, 64), pixel=(16e-6, 16e-6))
    steel = rc.Material(210e9, 0.3, 2e9)
    contact = rc.solve(ball, material=steel, counter_material=steel, load="hertz 4 GPa")
    everywhere, near = (rc.subsurface_stress(contact, d) for d in (None, ["5 um", "10 um"]))
    assert near.max_von_mises < 2e9 < everywhere.max_von_mises
    assert near.overall is not None
    assert near.overall.max_von_mises == everywhere.max_von_mises
    assert "The material yields" in str(near)
    assert near.summary()["overall"] == [everywhere.max_von_mises, everywhere.max_von_mises_at[0]]


def test_answer_names_a_ceiling_that_the_other_body_reaches():
    soft = rc.Material(3e9, 0.4, yield_strength=6e6)
    contact = rc.solve(ball(), material=STEEL, counter_material=soft, load=0.15)
    assert contact.saturated_fraction > 0
    answers = [
        presentation_of(subsurface_stress.subsurface_stress(contact, in_body=body)).answer()
        for body in ("body", "counter_body")
    ]
    assert answers[0].startswith("The body does not yield, but the contact reaches its pressure")
    assert "yields" in answers[1]
