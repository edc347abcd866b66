"""Sections and profiles: the stored fields at the right places, in the coordinates of the map."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.elastoplastic.volume_result import most_strained
from roughcontact.errors import InputError
from roughcontact.halfspace import tensors

# Summit of the ball of conftest.py.
ROW, COLUMN = 13, 17


def test_profile_below_the_summit(loaded) -> None:
    assert loaded.bodies[0].margin > 0
    assert most_strained(loaded)[1:] == (ROW, COLUMN)
    found = loaded.profile()
    assert found.point == (ROW, COLUMN)
    assert found.place == pytest.approx((13.5 * 0.6e-6, 17.5 * 0.5e-6))
    assert found.accumulated.max() == loaded.max_plastic_strain
    # Swift's law by hand, with the constants of conftest.py.
    by_hand = 1240e6 * (30 + 1e6 * found.accumulated.astype(float)) ** 0.085
    np.testing.assert_allclose(found.strength, by_hand, rtol=1e-5)
    flowed = found.accumulated > 0
    # At yield, but for layers that have unloaded in the last increment.
    ratio = found.von_mises[flowed] / found.strength[flowed]
    assert ratio.max() < 1.001
    assert np.median(ratio) == pytest.approx(1, abs=1e-3)
    # Layers: faces bound them, middles are between.
    np.testing.assert_allclose(np.diff(found.faces), loaded.bodies[0].thickness)
    np.testing.assert_allclose(found.depth, loaded.bodies[0].depth)


def test_stress_balances_the_pressure_above(loaded) -> None:
    # Equilibrium at the surface: σ_zz = -p, right below every pixel in contact, wherever the
    # volume extends beyond the map. The average over the first half pixel lies 3 % off inside.
    for along, index in (("x", ROW), ("y", COLUMN)):
        found = loaded.section(along, index)
        inside = found.pressure > 0.7 * found.pressure.max()
        assert inside.sum() > 8
        carried = -found.stress[0, inside, 2, 2]
        np.testing.assert_allclose(carried, found.pressure[inside], rtol=0.05)
        # Without pressure above there is none.
        open_ = np.flatnonzero(found.pressure == 0)[[0, -1]]
        assert np.abs(found.stress[0, open_, 2, 2]).max() < 0.02 * found.pressure.max()


def test_axes_of_the_tensor_on_a_round_contact(loaded) -> None:
    # Round, so that turning x into y turns one section into the other: on the axis both normal
    # stresses agree (pixels are not square, hence 2 %), and the other shear stress vanishes.
    axis = loaded.profile((ROW, COLUMN))
    scale = np.abs(axis.stress).max()
    np.testing.assert_allclose(axis.stress[:, 0, 0], axis.stress[:, 1, 1], atol=0.02 * scale)
    along_x, along_y = loaded.section("x"), loaded.section("y")
    for found, other in ((along_x, 1), (along_y, 0)):
        assert np.abs(found.stress[..., other, 2]).max() < 0.01 * scale
        assert np.abs(found.stress[..., 1 - other, 2]).max() > 0.1 * scale
    # Material is drawn down on both sides: shear changes its sign at the axis, rising along x.
    shear = along_x.stress[..., 0, 2]
    assert np.abs(shear[:, COLUMN]).max() < 0.01 * scale
    layer = np.abs(shear).max(axis=1).argmax()
    assert np.sign(shear[layer, COLUMN - 4]) == -np.sign(shear[layer, COLUMN + 4])


def test_pressure_and_contact_fraction_are_those_of_the_last_load(loaded) -> None:
    assert loaded.pressure is loaded.solution.pressure
    assert loaded.contact_fraction == loaded.solution.contact_fraction > 0


def test_sections_hold_the_fields_of_the_result(loaded) -> None:
    body = loaded.bodies[0]
    row, column = 9, 21
    x, y = loaded.section("x", row), loaded.section("y", column)
    assert (x.index, y.index) == (row, column)
    assert x.across == pytest.approx(9.5 * 0.6e-6)
    assert y.across == pytest.approx(21.5 * 0.5e-6)
    assert x.edges[[0, -1]] == pytest.approx([0, 32 * 0.5e-6])
    assert y.edges[[0, -1]] == pytest.approx([0, 28 * 0.6e-6])
    np.testing.assert_allclose(np.diff(x.place), 0.5e-6)
    contact = loaded.contact
    np.testing.assert_array_equal(x.pressure, contact.pressure[row])
    np.testing.assert_array_equal(y.pressure, contact.pressure[:, column])
    np.testing.assert_array_equal(x.residual_displacement, loaded.residual_displacement[row])
    m = body.margin
    np.testing.assert_array_equal(x.accumulated, body.accumulated[:, row + m, m:-m])
    np.testing.assert_array_equal(y.accumulated, body.accumulated[:, m:-m, column + m])
    np.testing.assert_allclose(x.von_mises, body.von_mises[:, row + m, m:-m], rtol=1e-4)
    residual = body.residual_von_mises[:, m:-m, column + m]
    np.testing.assert_allclose(y.residual_von_mises, residual, rtol=1e-4)
    mean = np.trace(x.stress, axis1=-2, axis2=-1) / 3
    np.testing.assert_allclose(mean, body.mean_stress[:, row + m, m:-m], rtol=1e-4)
    point = loaded.profile((row, column))
    for name in ("accumulated", "strength", "stress", "residual_stress"):
        value = getattr(point, name)
        np.testing.assert_array_equal(getattr(x, name)[:, column], value)
        np.testing.assert_array_equal(getattr(y, name)[:, row], value)


def test_layers_hold_the_largest_values_below_the_map(loaded) -> None:
    body, found = loaded.bodies[0], loaded.layers()
    m = body.margin
    inside = body.accumulated[:, m:-m, m:-m]
    np.testing.assert_array_equal(found.max_accumulated, inside.max(axis=(1, 2)))
    share = np.count_nonzero(inside, axis=(1, 2)) / (28 * 32)
    np.testing.assert_allclose(found.plastic_fraction, share)
    assert (
        found.depth[found.max_accumulated.argmax()]
        == loaded.profile().depth[loaded.profile().accumulated.argmax()]
    )
    assert found.max_von_mises.max() == pytest.approx(body.von_mises[:, m:-m, m:-m].max())
    assert (found.max_residual_von_mises < found.max_von_mises).any()


def test_unloaded_stress_is_the_residual_one(loaded, released) -> None:
    found = released.section("x")
    np.testing.assert_array_equal(found.stress, found.residual_stress)
    assert not found.pressure.any()
    assert released.regime == loaded.regime == "plastic up to the surface"
    # The residual displacement stays, within the rounding of single precision.
    np.testing.assert_allclose(
        released.residual_displacement, loaded.residual_displacement, atol=1e-12
    )


def test_elastic_result_shows_largest_stress() -> None:
    y, x = np.mgrid[:16, :18] - np.array([6, 10])[:, None, None]
    surface = rc.Surface(-(y**2 + x**2) * (0.5e-6) ** 2 / 2e-4, (0.5e-6, 0.5e-6))
    steel = rc.Material(210e9, 0.3, 20e9)
    result = rc.solve_elastoplastic(surface, material=steel, increments=1, loads=[0.05])
    layer, row, column = most_strained(result)
    assert not result.plastic_volume
    assert (row, column) == (6, 10)
    held = result.bodies[0]
    stress = tensors.equivalent(held.stress[layer, :, row + held.margin, column + held.margin])
    assert stress == pytest.approx(held.von_mises.max())


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda r: r.profile(body=1), "body must be one of 1"),
        (lambda r: r.layers(body=-1), "body must be one of 1"),
        (lambda r: r.profile((28, 0)), r"map of \(28, 32\) points"),
        (lambda r: r.profile((0, -1)), "map of"),
        (lambda r: r.section("z"), "along must be"),
        (lambda r: r.section("x", 28), "index must be a row of 28"),
        (lambda r: r.section("y", 32), "index must be a column of 32"),
    ],
)
def test_bad_arguments(loaded, ask, words) -> None:
    with pytest.raises(InputError, match=words):
        ask(loaded)
