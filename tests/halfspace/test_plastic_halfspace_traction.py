"""Stress in the volume by a traction on its surface, against the kernels of the stress below it.

`stress` integrates Cerruti's point force over each pixel without layers or sweeps.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roughcontact.halfspace import stress, tensors
from roughcontact.halfspace.plastic_halfspace import PlasticHalfSpace

PIXEL = (0.1, 0.1)
THICKNESS = np.array([0.2, 0.3, 0.5, 0.8])
NU = 0.3


def averages(
    pressure: NDArray[np.float64], boundary: str, friction: float, direction: float
) -> NDArray[np.float64]:
    """Return the stress over each layer, shape (nz, ny, nx, 3, 3), by Gauss's quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    top = np.append(0, np.cumsum(THICKNESS))
    layers = []
    for upper, thickness in zip(top, THICKNESS, strict=False):
        depths = upper + thickness * (nodes + 1) / 2
        total: Any = 0.0
        for weight, found in zip(
            weights / 2,
            stress.slices(
                pressure,
                PIXEL,
                depths,
                NU,
                boundary=boundary,
                friction=friction,
                direction=direction,
                precision="double",
            ),
            strict=True,
        ):
            xx, yy, zz, yz, xz, xy = found.stress
            rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
            total = total + weight * np.stack([np.stack(row, -1) for row in rows], -2)
        layers.append(total)
    return np.array(layers)


def volume_response(
    pressure: NDArray[np.float64], boundary: str, pull: tuple[float, float]
) -> NDArray[np.float64]:
    space = PlasticHalfSpace(
        pressure.shape, PIXEL, THICKNESS, shear_modulus=1.0, poisson=NU, boundary=boundary
    )
    nothing = (len(THICKNESS), *pressure.shape)
    deviator, mean = np.empty((nothing[0], 5, *nothing[1:])), np.empty(nothing)
    space.displacement(lambda layer, out: None, trace=True)
    space.stress(pressure, lambda layer, s: np.copyto(deviator[layer], s), pull)
    space.mean_stress(pressure, lambda layer, s: np.copyto(mean[layer], s), pull)
    return tensors.tensor(deviator.swapaxes(0, 1), mean)


@pytest.mark.parametrize("shape", [(9, 7), (8, 10)])
@pytest.mark.parametrize("direction", [0.0, 90.0, 217.0])
def test_periodic_traction(shape: tuple[int, int], direction: float) -> None:
    pressure = np.random.default_rng(3).random(shape)
    # The layers leave out the corner of the spectrum, a chequerboard of pixels.
    chequers = (-1.0) ** np.add.outer(*map(np.arange, shape))
    if not any(points % 2 for points in shape):
        pressure -= chequers * (chequers * pressure).mean()
    angle = math.radians(direction)
    expected = averages(pressure, "periodic", 0.4, angle)
    pull = 0.4 * math.cos(angle), 0.4 * math.sin(angle)
    np.testing.assert_allclose(volume_response(pressure, "periodic", pull), expected, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("direction", [0.0, 90.0, 217.0])
def test_free_traction(direction: float) -> None:
    y, x = (np.mgrid[:96, :80] - np.array([47.5, 39.5])[:, None, None]) * 0.1
    # Over 14 pixels, so that constant pixels and waves mean the same: errors fall with its square.
    pressure = np.exp(-(x**2 + y**2) / 1.4**2)
    angle = math.radians(direction)
    pull = 0.4 * math.cos(angle), 0.4 * math.sin(angle)
    expected = averages(pressure, "free", 0.4, angle) - averages(pressure, "free", 0.0, 0.0)
    both = volume_response(pressure, "free", pull) - volume_response(pressure, "free", (0.0, 0.0))
    np.testing.assert_allclose(both, expected, atol=0.4 * 3.5e-3)
    # Below the surface only what periodic images leave is in the way.
    np.testing.assert_allclose(both[1:], expected[1:], atol=0.4 * 8e-4)
