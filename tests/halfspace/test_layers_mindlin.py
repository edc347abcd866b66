"""Stress by plastic strain in a half-space against Mindlin's point forces.

A smooth strain e acts like the body force f_j = -∂_k (C e)_jk; its displacement is the integral of
Mindlin's solution over it, its stress C applied to the gradient of that. R. D. Mindlin, Physics 7
(1936) 195, doi:10.1063/1.1745385.
"""

import numpy as np
import pytest

from roughcontact.halfspace import plastic_halfspace, tensors

MU, NU = 1.7, 0.3
WIDTH, DEPTH = 1.0, 5.5
TENSOR = np.array([[0.3, 0.5, -0.4], [0.5, 0.5, 0.7], [-0.4, 0.7, -0.8]])
PIXEL = 0.5


def mindlin(x, source):
    """Return displacements G_ij, shape (..., 3, 3), at x along i by a unit force along j."""
    d = x - source
    X, Y, z, c = d[..., 0], d[..., 1], x[..., 2], source[..., 2]
    near, far = z - c, z + c
    r1 = np.sqrt(X * X + Y * Y + near**2)
    r2 = np.sqrt(X * X + Y * Y + far**2)
    k, m = 3 - 4 * NU, 4 * (1 - NU) * (1 - 2 * NU)
    green = np.empty((*np.broadcast(r1).shape, 3, 3))
    for i, a in ((0, X), (1, Y)):
        for j, b in ((0, X), (1, Y)):
            one = float(i == j)
            green[..., i, j] = (
                k * one / r1
                + one / r2
                + a * b / r1**3
                + k * a * b / r2**3
                + 2 * c * z / r2**3 * (one - 3 * a * b / r2**2)
                + m / (r2 + far) * (one - a * b / (r2 * (r2 + far)))
            )
        green[..., i, 2] = a * (
            near / r1**3 + k * near / r2**3 - m / (r2 * (r2 + far)) + 6 * c * z * far / r2**5
        )
        green[..., 2, i] = a * (
            near / r1**3 + k * near / r2**3 + m / (r2 * (r2 + far)) - 6 * c * z * far / r2**5
        )
    green[..., 2, 2] = (
        k / r1
        + (8 * (1 - NU) ** 2 - k) / r2
        + near**2 / r1**3
        + (k * far**2 - 2 * c * z) / r2**3
        + 6 * c * z * far**2 / r2**5
    )
    return green / (16 * np.pi * MU * (1 - NU))


def hooke(gradient):
    strain = (gradient + gradient.T) / 2
    return 2 * MU * (strain + NU / (1 - 2 * NU) * np.trace(strain) * np.eye(3))


def exact(points):
    """Return u_z above, and the stress at, points far from a Gaussian strain of unit width."""
    # The trapezoidal rule is exact to rounding for Gaussians at this spacing.
    line = np.arange(-5, 5.01, 0.4)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), -1).reshape(-1, 3)
    force = 2 * grid @ (2 * MU * TENSOR) * np.exp(-(grid**2).sum(1))[:, None] * 0.4**3
    source = grid + np.array([0, 0, DEPTH])

    def displacement(x):
        return np.einsum("nij,nj->i", mindlin(np.asarray(x, float), source), force)

    step = 1e-4
    result = []
    for point in points:
        gradient = np.array(
            [
                (displacement(point + step * e) - displacement(point - step * e)) / (2 * step)
                for e in np.eye(3)
            ]
        ).T
        result.append((displacement([*point[:2], 0.0])[2], hooke(gradient)))
    return result


def grid_of(points):
    return (np.arange(points) - (points - 1) / 2) * PIXEL


def refined_result(operator, shape, pick):
    """Return the same from an operator with layers of an eighth of the width."""
    thickness = operator.thickness
    bottom = np.cumsum(thickness)
    y, x = grid_of(shape[0]), grid_of(shape[1])
    five = tensors.components(TENSOR)
    node, weight = np.polynomial.legendre.leggauss(4)
    plane = np.exp(-(y[:, None] ** 2) - x**2)

    def fill(layer, out):
        z = bottom[layer] - thickness[layer] / 2 + thickness[layer] / 2 * node - DEPTH
        out[...] = five[:, None, None] * plane * (weight / 2 @ np.exp(-(z**2)))
        return slice(0, shape[0])

    u = operator.displacement(fill, trace=True)
    stress, mean = np.empty((thickness.size, 5, *shape)), np.empty((thickness.size, *shape))
    none = np.zeros(shape)
    operator.stress(none, lambda layer, s: stress.__setitem__(layer, s))
    operator.mean_stress(none, lambda layer, s: mean.__setitem__(layer, s))
    return [(u[j, i], tensors.tensor(stress[k, :, j, i], mean[k, j, i])) for k, j, i in pick]


SHAPE = (22, 24)
THICKNESS = np.full(88, 0.125)
PICK = [(7, 11, 12), (11, 14, 8), (8, 5, 18), (6, 16, 14)]


def errors(results):
    y, x = grid_of(SHAPE[0]), grid_of(SHAPE[1])
    points = [np.array([x[i], y[j], 0.125 * (k + 0.5)]) for k, j, i in PICK]
    truth = exact(points)
    u = max(abs(u) for u, _ in truth)
    s = max(np.abs(s).max() for _, s in truth)
    return (
        max(abs(a[0] - b[0]) for a, b in zip(results, truth, strict=True)) / u,
        max(np.abs(a[1] - b[1]).max() for a, b in zip(results, truth, strict=True)) / s,
    )


@pytest.mark.long
@pytest.mark.parametrize("precision", ["double", "single"])
def test_free_boundary_against_mindlin(precision) -> None:
    operator = plastic_halfspace.PlasticHalfSpace(
        SHAPE, (PIXEL, PIXEL), THICKNESS, shear_modulus=MU, poisson=NU, precision=precision
    )
    displacement, stress = errors(refined_result(operator, SHAPE, PICK))
    # As good as a period of eight times the map.
    assert displacement < 1e-3
    assert stress < 2e-3
