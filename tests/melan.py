"""Shakedown limits of rolling and sliding line contacts by Melan's theorem, from closed forms.

A body shakes down if some residual stress keeps the von Mises stress below yield all the time.
After passes along x a line contact can only leave σx and σy that vary with depth (Johnson 1985,
section 9.3): the others would not be in equilibrium. So at each depth the best two numbers are
sought, and the worst depth sets the limit. Independent of the package: NumPy and SciPy alone.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

Array = NDArray[np.float64]


def stress(x: Array, z: Array, friction: float) -> tuple[Array, Array, Array]:
    """Return σx, σz and τxz over the Hertz pressure, lengths over the half-width.

    Pressure √(1 - x²) and the traction μ √(1 - x²) along x on the surface z = 0 of a half-plane
    z > 0 (McEwen; Johnson 1985, equations 4.49 and 7.8).
    """
    root = np.sqrt((1 - x**2 + z**2) ** 2 + 4 * x**2 * z**2)
    m = np.sqrt(np.maximum(root + (1 - x**2 + z**2), 0) / 2)
    n = np.sign(x) * np.sqrt(np.maximum(root - (1 - x**2 + z**2), 0) / 2)
    both = np.maximum(m**2 + n**2, 1e-300)
    along = -(m * (1 + (z**2 + n**2) / both) - 2 * z)
    across = -m * (1 - (z**2 + n**2) / both)
    shear = -n * (m**2 - z**2) / both
    dragged = n * (2 - (z**2 - m**2) / both) - 2 * x
    return along + friction * dragged, across + friction * shear, shear + friction * along


def von_mises(along: Array, other: Array, across: Array, shear: Array) -> Array:
    """Return the von Mises stress of σx, σy, σz and τxz."""
    return np.sqrt(
        ((along - other) ** 2 + (other - across) ** 2 + (across - along) ** 2) / 2 + 3 * shear**2
    )


def first_yield(friction: float, poisson: float) -> float:
    """Return the Hertz pressure of first yield over the shear strength k = σ_Y/√3."""
    x, z = np.meshgrid(np.linspace(-1.5, 1.5, 1201), np.linspace(1e-9, 2, 801))
    along, across, shear = stress(x, z, friction)
    largest = von_mises(along, poisson * (along + across), across, shear).max()
    return math.sqrt(3) / float(largest)


def limit_at(depth: float, friction: float, poisson: float, thickness: float = 0.0) -> float:
    """Return the shakedown limit over k if only this depth could yield.

    Stresses are averaged over a layer of some thickness around it.
    """
    x = np.concatenate(
        [np.linspace(-4, -1.2, 100), np.linspace(-1.2, 1.2, 1201), np.linspace(1.2, 4, 100)]
    )
    nodes, weights = np.polynomial.legendre.leggauss(8)
    parts = [
        weight / 2 * np.array(stress(x, np.full_like(x, depth + thickness / 2 * node), friction))
        for node, weight in zip(nodes, weights, strict=True)
    ]
    along, across, shear = sum(parts)
    other = poisson * (along + across)

    # A convex function of two numbers.
    def worst(residual: Array) -> float:
        return float(von_mises(along + residual[0], other + residual[1], across, shear).max())

    options = {"xatol": 1e-7, "fatol": 1e-9, "maxiter": 4000}
    found = [
        optimize.minimize(worst, start, method="Nelder-Mead", options=options).fun
        for start in ((0.0, 0.0), (-0.4, -0.2))
    ]
    return math.sqrt(3) / float(min(found))


def line_limit(friction: float, poisson: float, layers: Array) -> float:
    """Return the shakedown limit of a line contact over k on layers of some thickness."""
    depths = np.cumsum(layers) - layers / 2
    return min(
        limit_at(float(depth), friction, poisson, float(thickness))
        for depth, thickness in zip(depths, layers, strict=True)
    )
