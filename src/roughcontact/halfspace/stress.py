"""Elastic stress below a loaded surface, slice by slice.

The body fills z > 0, tension is positive, and x, y are the axes of the map (``[y, x]``). A
tensor is an array whose first axis holds xx, yy, zz, yz, xz, xy, in this order. The surface
carries the normal pressure p, so that σ_zz = -p there, and with friction the traction
q = μ p on the body in one direction of the plane, so that σ_xz = -q_x and σ_yz = -q_y. The effect
of q on the pressure is neglected, as usual (Goodman's approximation; exact for equal bodies).

A depth is computed on its own: a few kernels are sampled, transformed and multiplied with the one
spectrum of the pressure, and a visitor sees the stress row block by row block. Nothing ever holds
the volume.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError, require_pixel
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.stress_field import Field, field_of

Array = NDArray[np.float64]

# Depths per octave of an automatic list, its ends in pixels and contact radii.
_PER_OCTAVE = 3
_SHALLOWEST = 0.5
_DEEPEST = 3.0


def graded_depths(
    pressure: NDArray[Any], pixel: tuple[float, float], *, boundary: str = "free"
) -> Array:
    """Return depths that follow the stress from a single pixel to the whole contact.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Pressure [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period.

    Returns
    -------
    ndarray, shape (nz,)
        0, then a geometric series with three depths an octave, from half the shorter pixel edge,
        below which the stress only shows that pressure is constant on a pixel, to three contact
        radii [m].

    Raises
    ------
    InputError
        If the pixel is not positive, or there is no pressure.

    Notes
    -----
    The stress under a spot of radius r peaks at about r/2 (0.48 r under a Hertz contact) and
    changes by little within a third of an octave. Spots of all sizes from a pixel up may be there,
    so the series is graded alike for all. The contact radius is √5 times the larger standard
    deviation of the pressure's distribution over x and y: a under a Hertz contact, about as much
    as the loaded region measures otherwise. On a periodic map the list ends one side deep, where
    the longest wave is damped to e^(-2π).
    """
    require_pixel(pixel)
    total = float(pressure.sum())
    if not total > 0:
        raise InputError("is zero everywhere: there is no stress to look at", argument="pressure")
    if pressure.shape[0] == 1:
        # How wide a profile is does not matter.
        pixel = (pixel[1], pixel[1])
    reach = 0.0
    for axis, edge in enumerate(pixel):
        weights = pressure.sum(axis=1 - axis) / total
        position = np.arange(weights.size) * edge
        position -= np.einsum("i,i->", weights, position)
        spread = float(np.einsum("i,i->", weights, position**2))
        reach = max(reach, _DEEPEST * math.sqrt(5 * spread))
    if not Boundary(boundary).free_axes:
        reach = min(reach, max(n * edge for n, edge in zip(pressure.shape, pixel, strict=True)))
    first = _SHALLOWEST * min(pixel)
    # A single loaded pixel has no spread; its stress is gone a few pixels below.
    reach = max(reach, _DEEPEST * max(pixel))
    count = math.ceil(_PER_OCTAVE * math.log2(reach / first)) + 1
    return np.concatenate([[0.0], np.geomspace(first, reach, count)])


@dataclass(frozen=True, eq=False)
class Slice:
    """The stress at one depth.

    Parameters
    ----------
    depth : float
        z [m].
    stress : ndarray, shape (6, ny, nx)
        Tensors xx, yy, zz, yz, xz, xy at the pixel centres [Pa].
    """

    depth: float
    stress: NDArray[Any]


def slices(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    depths: ArrayLike,
    poisson: float,
    *,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
    workers: int | None = None,
) -> Iterator[Slice]:
    """Return the stress depth by depth.

    Parameters
    ----------
    pressure : array_like, shape (ny, nx)
        Pressure on the surface [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    depths : array_like, shape (nz,)
        Depths z ≥ 0 [m], in any order.
    poisson : float
        Poisson's ratio ν of the body; its other constants do not matter.
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period.
    friction : float
        Coefficient μ of the traction μ p on this body; the other body carries the opposite.
    direction : float
        Angle of that traction from x towards y [rad].
    precision : {"double", "single"}
        Arithmetic of the transforms. Single is good to about 1e-6 of the largest pressure.
    workers : int, optional
        Threads; by default one for each core that the process may use.

    Returns
    -------
    iterator of Slice
        One for each depth, computed when it is asked for; the caller owns it.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Notes
    -----
    Free: pressure is constant on each pixel, and the stress at the pixel centres is exact
    (`stress_kernels.coefficients`). In single precision, kernels that are smooth at their depth are
    sampled at fewer points, which keeps the stress within 1e-6 of the largest pressure.

    Periodic: pressure is the trigonometric polynomial through the pixel centres, and each of its
    waves has its exact stress (`stress_kernels.waves`). The mean pressure presses on a body that
    cannot expand sideways: σ_xx = σ_yy = -ν/(1-ν) p̄.
    """
    field = field_of(
        pressure, pixel, poisson, boundary, friction, direction, precision, Workspace(workers)
    )
    return (_slice(field, depth) for depth in depth_list(depths).tolist())


def _slice(field: Field, depth: float) -> Slice:
    stress: NDArray[Any] = np.empty((6, *field.shape), field.real)

    def keep(rows: slice, block: NDArray[Any]) -> None:
        np.multiply(block, field.unit, out=stress[:, rows], casting="same_kind")

    responses, symbols = field.at(depth)
    responses.stream(symbols, keep)
    return Slice(depth, stress)


def sections(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    depths: ArrayLike,
    poisson: float,
    point: tuple[int, int],
    *,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
    workers: int | None = None,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the stress on the two vertical planes through a pixel.

    Parameters
    ----------
    pressure, pixel, depths, poisson, boundary, friction, direction, precision, workers
        As for `slices`.
    point : (int, int)
        Row and column of the pixel.

    Returns
    -------
    along_x : ndarray, shape (6, nz, nx)
        Tensors on the plane of the row [Pa].
    along_y : ndarray, shape (6, nz, ny)
        Tensors on the plane of the column [Pa].

    Raises
    ------
    InputError
        If an argument is outside its range.
    """
    field = field_of(
        pressure, pixel, poisson, boundary, friction, direction, precision, Workspace(workers)
    )
    listed, (ny, nx) = depth_list(depths), field.shape
    if not (0 <= point[0] < ny and 0 <= point[1] < nx):
        raise InputError(
            f"must lie on the map of {ny} × {nx} pixels, got {point!r}",
            argument="point",
            value=point,
        )
    along_x: NDArray[Any] = np.empty((6, listed.size, nx), field.real)
    along_y: NDArray[Any] = np.empty((6, listed.size, ny), field.real)
    for number, depth in enumerate(listed.tolist()):
        responses, symbols = field.at(depth)
        row, column = responses.cross(symbols, point)
        along_x[:, number], along_y[:, number] = row * field.unit, column * field.unit
    return along_x, along_y


def depth_list(depths: ArrayLike) -> Array:
    """Return depths as an array; raise `InputError` unless they are finite and ≥ 0."""
    listed = np.asarray(depths, dtype=np.float64)
    if listed.ndim != 1 or not listed.size or not (listed >= 0).all() or np.isinf(listed).any():
        raise InputError(
            f"must be a list of finite depths ≥ 0 [m], got {depths!r}",
            argument="depths",
            value=depths,
        )
    return listed
