import numpy as np
import pytest

from roughcontact.errors import InputError
from roughcontact.halfspace import plastic, stress
from roughcontact.halfspace.boundary import Boundary

STRIPS = [Boundary.PERIODIC_X, Boundary.PERIODIC_Y]
PIXEL = (0.4, 1.0)
MODULUS = 3.0


def test_values_are_the_texts_of_arguments_and_files():
    assert [str(boundary) for boundary in Boundary] == [
        "free", "periodic", "periodic-x", "periodic-y",
    ]  # fmt: skip
    assert Boundary("periodic-y") is Boundary.PERIODIC_Y
    assert f"{Boundary.FREE}" == "free" == Boundary.FREE


@pytest.mark.parametrize("value", ["open", "", "Free", "periodic_x", None, 3, ["free"]])
def test_other_values_are_refused_with_the_choice(value):
    with pytest.raises(InputError, match="boundary must be 'free' or 'periodic' or") as caught:
        Boundary(value)
    assert caught.value.argument == "boundary"
    assert repr(value) in str(caught.value)
    assert "'periodic-x' or 'periodic-y'" in str(caught.value)


def test_each_axis_is_free_or_periodic():
    axes = {str(b): (b.free_axes, b.periodic_axes) for b in Boundary}
    # Axis 1 is x: maps are [y, x].
    assert axes == {
        "free": ((0, 1), ()), "periodic": ((), (0, 1)),
        "periodic-x": ((0,), (1,)), "periodic-y": ((1,), (0,)),
    }  # fmt: skip


@pytest.mark.parametrize("boundary", Boundary)
def test_the_operator_wraps_along_the_periodic_axes(boundary):
    operator = boundary.operator((6, 9), PIXEL, MODULUS)
    assert operator.wrapped == tuple(axis in boundary.periodic_axes for axis in (0, 1))
    unit = np.zeros((6, 9))
    unit[0, 0] = 1
    moved = operator(unit)
    for axis, near_seam in enumerate((moved[-1, 0], moved[0, -1])):
        near = moved[1, 0] if axis == 0 else moved[0, 1]
        if axis in boundary.periodic_axes:
            assert near_seam == pytest.approx(near, rel=1e-13)
        else:
            assert near_seam < 0.7 * near


@pytest.mark.parametrize("shape", [(12, 31), (31, 12), (2, 33), (8, 8)])
def test_a_strip_along_x_is_that_along_y_transposed(shape):
    pressure = np.random.default_rng(0).random(shape)
    along_x = Boundary.PERIODIC_X.operator(shape, PIXEL, MODULUS)(pressure)
    turned = Boundary.PERIODIC_Y.operator(shape[::-1], PIXEL[::-1], MODULUS)
    along_y = turned(np.ascontiguousarray(pressure.T)).T
    np.testing.assert_allclose(along_x, along_y, rtol=0, atol=2e-15 * along_x.max())


@pytest.mark.parametrize("boundary", STRIPS)
@pytest.mark.parametrize("shape", [(4, 400), (400, 4), (64, 64), (5, 7)])
def test_the_kernel_of_a_strip_is_positive_definite(boundary, shape):
    # Long or short across: every wave of the padded map resists, the mean as well.
    assert boundary.operator(shape, PIXEL, MODULUS).spectrum.min() > 0


@pytest.mark.parametrize("boundary", STRIPS)
def test_parts_and_coarse_grids_of_a_strip_share_the_datum_of_the_map(boundary):
    # The same uniform pressure on the same pixels displaces them alike on a part of the map.
    # The longer side is that which ends: a part of it is shorter.
    free = boundary.free_axes[0]
    shape = (60, 40) if free == 0 else (40, 60)
    half = (shape[0] // 2, shape[1] // 2)
    family = boundary.operators(shape, (1.0, 1.0), MODULUS)
    whole = np.zeros(shape)
    cut = [slice(None), slice(None)]
    cut[free] = slice(10, 20)
    whole[tuple(cut)] = 1
    expected = family(shape, (1, 1))(whole)[tuple(cut)]
    part = [*shape]
    part[free] = 10
    found = family((part[0], part[1]), (1, 1))(np.ones(part))
    np.testing.assert_allclose(found, expected, rtol=1e-13)
    coarse = np.zeros(half)
    cut[free] = slice(5, 10)
    coarse[tuple(cut)] = 1
    # Larger pixels make 0.3 %, half the datum would make 20 %.
    averaged = family(half, (2, 2))(coarse)[tuple(cut)].mean()
    assert averaged == pytest.approx(expected.mean(), rel=1e-2)


def test_words_tell_the_axis():
    for boundary in Boundary:
        words = f"{boundary.meaning} {boundary.heading} {boundary.assumption}"
        assert ("along x" in words) == (len(boundary.periodic_axes) == 1)
    assert "repeats along x" in Boundary.PERIODIC_X.assumption
    assert "repeats along y" in Boundary.PERIODIC_Y.assumption
    assert "datum" in Boundary.PERIODIC_X.assumption


@pytest.mark.parametrize("boundary", STRIPS)
def test_what_is_not_available_on_a_strip_says_so(boundary):
    advice = f"'{boundary}' is not available for .*solve with 'free' or 'periodic'"
    with pytest.raises(InputError, match=advice):
        stress.slices(np.ones((8, 8)), PIXEL, [1.0], 0.3, boundary=boundary)
    with pytest.raises(InputError, match=advice):
        plastic.HalfSpace(
            (8, 8), PIXEL, [1.0], shear_modulus=1.0, poisson=0.3, boundary=str(boundary)
        )


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("shape", [(30, 50), (64, 64)])
def test_memory_of_a_strip_lies_between_that_of_the_others(shape, precision):
    free, periodic, *strips = (boundary.operator_memory(shape, precision) for boundary in Boundary)
    assert periodic < min(strips)
    assert max(strips) < free
