import numpy as np
import pytest

from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.rigid_tilt import Punch, flat_punch

PIXEL = (1e-6, 1.6e-6)


def solve_punch(shape, index, boundary, precision="double") -> tuple[Punch, np.ndarray]:
    """Return the punch on some pixels, and the matrix of what they do to all of the map."""
    family = Boundary(boundary).operators(
        shape, PIXEL, 2e11, precision=precision, workspace=Workspace(1)
    )
    found = flat_punch(shape, index, family)
    assert found is not None
    operator = family(shape, (1, 1))
    units = np.eye(shape[0] * shape[1])[index].reshape(-1, *shape)
    return found, np.array([operator(unit).ravel() for unit in units]).T


@pytest.mark.parametrize("boundary", ["free", "periodic", "periodic-x"])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.6, 0.99])
def test_flat_punch_displaces_pixels_equally(boundary: str, share: float) -> None:
    shape = (11, 14)
    chosen = np.random.default_rng(4).random(shape[0] * shape[1]) < share
    # One pixel alone, too.
    chosen[[0, 40]] = False, True
    index = np.flatnonzero(chosen)
    found, matrix = solve_punch(shape, index, boundary)
    exact = np.linalg.solve(matrix[index], np.ones(index.size))
    assert found.total == pytest.approx(exact.sum(), rel=1e-7)
    np.testing.assert_allclose(found.pressure, exact, rtol=0, atol=2e-3 * exact.max())
    np.testing.assert_allclose(found.displacement.ravel(), matrix @ exact, rtol=0, atol=2e-3)
    single, _ = solve_punch(shape, index, boundary, "single")
    assert single.total == pytest.approx(exact.sum(), rel=1e-5)


@pytest.mark.parametrize("precision", ["double", "single"])
def test_periodic_mean_has_no_compliance(precision: str) -> None:
    for shape in ((5, 8), (72, 80)):
        pixels = np.arange(shape[0] * shape[1])
        family = Boundary("periodic").operators(
            shape, PIXEL, 2e11, precision=precision, workspace=Workspace(1)
        )
        full, nearly = flat_punch(shape, pixels, family), flat_punch(shape, pixels[1:], family)
        assert full is not None
        assert nearly is not None
        assert full.total == np.inf
        assert 0 < nearly.total < np.inf
