import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from roughcontact.errors import InputError
from roughcontact.halfspace import tensors

EPS = np.finfo(float).eps

# Squares of less than 1e-154 are no longer numbers.
components = st.floats(-1e10, 1e10).map(lambda value: value if abs(value) > 1e-60 else 0.0)
stresses = hnp.arrays(np.float64, 6, elements=components)


def matrix(stress):
    xx, yy, zz, yz, xz, xy = np.asarray(stress, float)
    return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), (0, 1), (-2, -1))


def tensor(matrix):
    return np.array([matrix[i, j] for i, j in [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]])


def rotated(values, rng):
    """A tensor with the given principal stresses in random directions."""
    rotation, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    return tensor(rotation @ np.diag(values) @ rotation.T)


@pytest.mark.long
@given(stresses)
def test_principal_stresses_are_the_eigenvalues(stress):
    expected = np.linalg.eigvalsh(matrix(stress))[::-1]
    found = tensors.principal(stress)
    # Both are backward stable: a few ε of the largest component.
    np.testing.assert_allclose(found, expected, rtol=0, atol=20 * EPS * np.abs(stress).max())


@given(stresses)
def test_equivalent_stresses_from_the_eigenvalues(stress):
    one, two, three = np.linalg.eigvalsh(matrix(stress))[::-1]
    mises = np.sqrt(0.5 * ((one - two) ** 2 + (two - three) ** 2 + (three - one) ** 2))
    size = np.abs(stress).max()
    assert tensors.von_mises(stress) == pytest.approx(mises, rel=1e-12, abs=20 * EPS * size)
    assert tensors.tresca(stress) == pytest.approx(one - three, rel=1e-12, abs=20 * EPS * size)


@pytest.mark.parametrize(
    "values", [(1, 1, -2), (2, -1, -1), (3, 3, 3), (1, 1, 1 - 1e-9), (1, 0, 0)]
)
def test_meeting_roots_keep_all_digits(values):
    rng = np.random.default_rng(0)
    for _ in range(20):
        stress = rotated(values, rng)
        # With Δ as a difference, roots that meet would be off by √ε = 1e-8.
        np.testing.assert_allclose(
            tensors.principal(stress), sorted(values, reverse=True), rtol=0, atol=30 * EPS
        )
        assert tensors.tresca(stress) == pytest.approx(max(values) - min(values), abs=30 * EPS)


def test_hydrostatic_stress_has_zero_equivalent_stress():
    assert tensors.von_mises([-7.0, -7.0, -7.0, 0, 0, 0]) == 0
    assert tensors.tresca([-7.0, -7.0, -7.0, 0, 0, 0]) == 0
    assert tensors.principal(np.zeros(6)).tolist() == [0, 0, 0]
    stress = np.random.default_rng(1).standard_normal((6, 4, 5))
    for factor in (1e-70, 1e70):
        for measure in (tensors.tresca, tensors.principal):
            np.testing.assert_allclose(measure(factor * stress), factor * measure(stress))


def test_maps_of_tensors_keep_shape_and_arithmetic():
    stress = np.random.default_rng(2).standard_normal((6, 3, 4))
    for measure in (tensors.von_mises, tensors.tresca):
        found = measure(stress)
        assert found.shape == (3, 4)
        assert found[1, 2] == pytest.approx(float(measure(stress[:, 1, 2])), rel=1e-14)
    assert tensors.principal(stress).shape == (3, 3, 4)
    assert tensors.von_mises(stress.astype(np.float32)).dtype == np.float32
    np.testing.assert_allclose(tensors.von_mises_squared(stress), tensors.von_mises(stress) ** 2)
    assert tensors.von_mises(np.array([1, 0, 0, 0, 0, 0])) == 1


def test_wrong_number_of_components():
    for measure in (tensors.von_mises, tensors.principal, tensors.tresca):
        with pytest.raises(InputError, match=r"xx, yy, zz, yz, xz, xy.*\(5,\)"):
            measure(np.zeros(5))
