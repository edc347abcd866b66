"""Stress and strain tensors: their components, equivalent and principal stresses.

A tensor is an array whose first axis holds xx, yy, zz, yz, xz, xy, in this order. A traceless
tensor needs five components, in this order::

    zz,  (xx - yy)/2,  xy,  xz,  yz

so that a:b = 3/2 a₀b₀ + 2 (a₁b₁ + a₂b₂ + a₃b₃ + a₄b₄).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arrays import Array
from roughcontact.errors import InputError

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
"""Order of the components of a tensor along its first axis."""

XX, YY, ZZ, YZ, XZ, XY = range(6)

WEIGHTS = (1.5, 2.0, 2.0, 2.0, 2.0)
"""Weights of the five components in the product a:b of two traceless tensors."""


def von_mises(stress: ArrayLike) -> NDArray[Any]:
    """Return the equivalent stress of von Mises, ``√(3 J₂)``.

    Parameters
    ----------
    stress : array_like, shape (6, ...)
        Stress tensors [Pa].

    Returns
    -------
    ndarray, shape (...)
        Equivalent stress [Pa]; the octahedral shear stress is √2/3 of it.

    Examples
    --------
    >>> float(von_mises([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    3.0
    """
    return np.sqrt(von_mises_squared(_tensor(stress)))


def von_mises_squared(stress: NDArray[Any]) -> NDArray[Any]:
    """Return the square of `von_mises` in the arithmetic of the input.

    Parameters
    ----------
    stress : ndarray, shape (6, ...)
        Stress tensors [Pa].

    Returns
    -------
    ndarray, shape (...)
        Squared equivalent stress [Pa²].
    """
    xx, yy, zz, yz, xz, xy = stress
    squared: NDArray[Any] = np.square(yz)
    part = np.empty_like(squared)
    squared += np.square(xz, out=part)
    squared += np.square(xy, out=part)
    squared *= 6
    for item, other in ((xx, yy), (yy, zz), (zz, xx)):
        np.subtract(item, other, out=part)
        squared += np.square(part, out=part)
    squared *= 0.5
    return squared


def principal(stress: ArrayLike) -> Array:
    """Return the principal stresses, the largest first.

    Parameters
    ----------
    stress : array_like, shape (6, ...)
        Stress tensors [Pa].

    Returns
    -------
    ndarray, shape (3, ...)
        σ₁ ≥ σ₂ ≥ σ₃ [Pa].

    Notes
    -----
    With the deviator s, J₂ = ½ s:s and J₃ = det s, the roots are
    ``σ_m + 2 √(J₂/3) cos(φ - 2πk/3)`` with ``tan 3φ = √Δ / (√27 J₃)`` and the discriminant
    Δ = 4 J₂³ - 27 J₃². This difference loses half of the digits where two roots coincide, as on
    every axis of symmetry. Δ is also the Gram determinant of 1, s and s², hence a sum of squares
    of their minors (Cauchy and Binet), and is computed as this sum.

    Examples
    --------
    >>> principal([1.0, 1.0, -2.0, 0.0, 0.0, 0.0]).round(12).tolist()
    [1.0, 1.0, -2.0]
    """
    mean, root, angle = _lode(_tensor(stress))
    thirds = np.array([0.0, 2 * math.pi / 3, -2 * math.pi / 3])
    thirds = thirds.reshape((3,) + (1,) * angle.ndim)
    return mean + 2 / math.sqrt(3) * root * np.cos(angle - thirds)


def tresca(stress: ArrayLike) -> Array:
    """Return the equivalent stress of Tresca, ``σ₁ - σ₃``, twice the largest shear stress.

    Parameters
    ----------
    stress : array_like, shape (6, ...)
        Stress tensors [Pa].

    Returns
    -------
    ndarray, shape (...)
        Equivalent stress [Pa], between one and 2/√3 times the von Mises stress.

    Notes
    -----
    ``2 √J₂ sin(φ + π/3)``, with φ as in `principal`.

    Examples
    --------
    >>> float(tresca([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))
    2.0
    """
    _, root, angle = _lode(_tensor(stress))
    return 2 * root * np.sin(angle + math.pi / 3)


def may_reach_tresca(stress: NDArray[Any], bound: float) -> NDArray[np.bool_]:
    """Return where the Tresca stress is at least √bound, up to rounding.

    Parameters
    ----------
    stress : ndarray, shape (6, ...)
        Stress tensors [Pa].
    bound : float
        Square of a Tresca stress [Pa²].

    Returns
    -------
    ndarray of bool, shape (...)
        True for every tensor that reaches the bound, and for few others.

    Notes
    -----
    With the Tresca stress t, the discriminant ``4 J₂³ - 27 J₃²`` of `principal` is
    ``t² (t² - 3 J₂)²``, which increases with t: no root and no angle is needed.
    """
    xx, yy, zz, d, e, f = stress.astype(np.float64)
    mean = (xx + yy + zz) / 3
    a, b, c = xx - mean, yy - mean, zz - mean
    squared = 1.5 * (a * a + b * b + c * c) + 3 * (d * d + e * e + f * f)
    third = a * (b * c - d * d) - f * (f * c - d * e) + e * (f * d - b * e)
    beyond = np.maximum(bound - squared, 0)
    return (
        squared * squared * squared * (4 / 27 + 1e-9) - 27 * third * third
        >= bound * beyond * beyond
    )


def _tensor(stress: ArrayLike) -> NDArray[Any]:
    array = np.asarray(stress)
    if array.dtype.kind != "f":
        array = array.astype(np.float64)
    if array.ndim < 1 or array.shape[0] != 6:
        raise InputError(
            f"must hold the components {', '.join(COMPONENTS)} along its first axis, "
            f"got shape {array.shape}",
            argument="stress",
        )
    return array


def _lode(stress: NDArray[Any]) -> tuple[Array, Array, Array]:
    """Return the mean stress, √J₂ and the angle φ of `principal`."""
    stress = stress.astype(np.float64)
    # A power of two keeps the digits of each tensor.
    scale = math.ldexp(1.0, math.frexp(float(np.abs(stress).max(initial=0)))[1])
    stress /= scale
    mean = stress[:3].mean(axis=0)
    a, b, c = stress[:3] - mean
    d, e, f = stress[3:]
    second = 0.5 * (a * a + b * b + c * c) + d * d + e * e + f * f
    third = a * (b * c - d * d) - f * (f * c - d * e) + e * (f * d - b * e)
    # Entries of s² on and off the diagonal; s itself has a, b, c on it and d, e, f off it.
    squares = (a * a + e * e + f * f, b * b + d * d + f * f, c * c + d * d + e * e)
    crossed = (f * e + d * (b + c), f * d + e * (a + c), d * e + f * (a + b))
    diagonal, off = (a, b, c), (d, e, f)
    discriminant = np.zeros(second.shape)
    for i in range(3):
        j = (i + 1) % 3
        linear, quadratic = diagonal[j] - diagonal[i], squares[j] - squares[i]
        for k in range(3):
            discriminant += 2 * (linear * crossed[k] - off[k] * quadratic) ** 2
        discriminant += 12 * (off[i] * crossed[j] - off[j] * crossed[i]) ** 2
    minor = (b - a) * (squares[2] - squares[0]) - (c - a) * (squares[1] - squares[0])
    discriminant += minor**2
    angle = np.arctan2(np.sqrt(discriminant), math.sqrt(27) * third) / 3
    return mean * scale, np.sqrt(second) * scale, angle


def components(tensor: NDArray[Any]) -> NDArray[Any]:
    """Return the five components of symmetric tensors, without their trace.

    Parameters
    ----------
    tensor : ndarray, shape (..., 3, 3)
        Symmetric tensors, axes x, y, z.

    Returns
    -------
    ndarray, shape (5, ...)
        Components zz, (xx - yy)/2, xy, xz, yz of the deviator.

    Examples
    --------
    >>> components(np.diag([-1.0, -1.0, 2.0])).tolist()
    [2.0, 0.0, 0.0, 0.0, 0.0]
    """
    mean = np.trace(tensor, axis1=-2, axis2=-1) / 3
    return np.stack(
        [
            tensor[..., 2, 2] - mean,
            (tensor[..., 0, 0] - tensor[..., 1, 1]) / 2,
            tensor[..., 0, 1],
            tensor[..., 0, 2],
            tensor[..., 1, 2],
        ]
    )


def tensor(deviator: NDArray[Any], mean: ArrayLike = 0.0) -> NDArray[Any]:
    """Return symmetric tensors from the five components and a mean.

    Parameters
    ----------
    deviator : ndarray, shape (5, ...)
        Components zz, (xx - yy)/2, xy, xz, yz.
    mean : array_like, shape (...)
        A third of the trace.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Tensors, axes x, y, z.
    """
    zz, half, xy, xz, yz = deviator
    rows = [[mean - zz / 2 + half, xy, xz], [xy, mean - zz / 2 - half, yz], [xz, yz, mean + zz]]
    return np.stack([np.stack(np.broadcast_arrays(*row), axis=-1) for row in rows], axis=-2)


def equivalent(deviator: NDArray[Any]) -> NDArray[Any]:
    """Return the von Mises stress √(3/2 s:s) of stress deviators.

    Parameters
    ----------
    deviator : ndarray, shape (5, ...)
        Components zz, (xx - yy)/2, xy, xz, yz.

    Returns
    -------
    ndarray, shape (...)
        Equivalent stress, in the unit of the deviator.

    Examples
    --------
    Uniaxial tension of 3 along z has the deviator (-1, -1, 2).

    >>> float(equivalent(np.array([2.0, 0, 0, 0, 0])))
    3.0
    """
    square = deviator[1] ** 2
    for component in deviator[2:]:
        square += component**2
    square *= 3
    square += 2.25 * deviator[0] ** 2
    return np.sqrt(square)
