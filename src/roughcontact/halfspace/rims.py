"""Stress of a sliding contact at the very rim of its spots, between the pixels.

Pressure goes to zero there like the square root of the distance, and so does, outside, what the
slope of the surface lacks. With friction both are felt along the surface: the largest stress is a
cusp at the trailing rim, which pixel centres miss by 4 to 8 % at 20 pixels a contact radius. What
makes the cusp is known, however. The sum of the stresses along a free surface is local::

    σ_xx + σ_yy = -(1+2ν) p + (1+ν) μ E* ∂u/∂e

with the normal displacement u and the direction e of the traction μ p; and across a rim with the
normal n and the tangent t all that is not smooth is that of plane strain::

    -p (nn + 2ν tt) + μ E* ∂u/∂n (e_n (nn + ν tt) + e_t (nt + tn) / 2)

So this part is taken off the sampled stress; the rest goes on smoothly to the rim. There the
pressure is zero, and the slope is that of the surface in contact, which has no cusp.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace import fft, stress_kernels
from roughcontact.halfspace.tensors import XX, XY, YY

Array = NDArray[np.float64]
Index = NDArray[np.int64]

# Where the traction runs nearly along a rim, little happens, and the slope across the rim is not to
# be had from that along the traction.
_ACROSS = 0.5
# Least cosine between the normal of a rim and the axis along which its place is looked for.
_ALONG = 0.6
# The slope is that of the parabola through the pixels in contact of 5 × 5. No conic goes through so
# many of them, so there is one. Smaller spots are not resolved, and are left as they are.
_HALF, _FEWEST = 2, 15
_WINDOW = list(itertools.product(range(-_HALF, _HALF + 1), repeat=2))
_PARABOLA = np.array([(1, y, x, y * y, x * x, x * y) for y, x in _WINDOW], dtype=np.float64)
# Rims whose stress is below this part of the largest, as pixels of constant pressure give it, need
# not be looked at again.
_WORTHWHILE = 0.9
# Reach of the difference between two ways to tell the pressure between pixels, and the period on
# which it is found.
_REACH, _PERIOD = 12, 128
_IN_PLANE = (XX, YY, XY)


class Rim(NamedTuple):
    """The largest stress at the rims, in the unit of the pressure, and the pixel that holds it."""

    von_mises: float
    tresca: float
    pixel: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Sliding:
    """A sliding contact, sampled at the pixel centres of its surface.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Pressure p in any unit; positive where there is contact.
    displacement : ndarray, shape (ny, nx)
        Normal displacement times E*, per unit of pressure [m].
    stress : ndarray, shape (3, ny, nx)
        xx, yy and xy at the surface.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    poisson : float
        Poisson's ratio ν.
    pulls : sequence of (axis, float)
        Tractions on the body along "x" or "y", per pressure; not all zero.
    periodic : bool
        Whether the map is one period, and its pressure a sum of waves; else it is all there is,
        and the pressure is constant on each pixel.
    """

    pressure: NDArray[Any]
    displacement: NDArray[Any]
    stress: NDArray[Any]
    pixel: tuple[float, float]
    poisson: float
    pulls: Sequence[tuple[str, float]]
    periodic: bool

    @property
    def friction(self) -> float:
        """Coefficient μ > 0."""
        return math.hypot(*(share for _, share in self.pulls))

    @property
    def direction(self) -> tuple[float, float]:
        """Unit vector of the traction, along y and along x."""
        shares = dict(self.pulls)
        return shares.get("y", 0.0) / self.friction, shares.get("x", 0.0) / self.friction

    def at(self, values: NDArray[Any], rows: Index, columns: Index) -> NDArray[Any]:
        """Return values of a map at pixels, which may lie beyond its edges: nothing is there."""
        ny, nx = self.pressure.shape
        found: NDArray[Any] = values[..., rows % ny, columns % nx]
        if self.periodic:
            return found
        return np.where((rows >= 0) & (rows < ny) & (columns >= 0) & (columns < nx), found, 0)


class _Points(NamedTuple):
    """Points of rims, each looked for from a pixel along an axis of the map.

    ``ahead`` is the distance from the centre of the pixel in steps, ``normal`` points out of the
    contact, components along y and x.
    """

    rows: Index
    columns: Index
    step: NDArray[np.int64]
    ahead: Array
    normal: Array

    def where(self, chosen: NDArray[Any]) -> _Points:
        """Return some of the points."""
        return _Points(
            self.rows[chosen],
            self.columns[chosen],
            self.step[:, chosen],
            self.ahead[chosen],
            self.normal[:, chosen],
        )


def largest(contact: Sliding) -> Rim | None:
    """Return the largest stress at the rims of resolved spots; none if there are none.

    Parameters
    ----------
    contact : Sliding
        The contact.

    Notes
    -----
    Where pressure is constant on each pixel, its waves of a few pixels have a stress of their own
    that is not that of plane strain across the rim. So for rims that matter, the stress is first
    made that of the sum of waves through the pixel centres.
    """
    ny, nx = contact.pressure.shape
    points = _with_slope(contact, _points(contact))
    if points is None:
        return None
    found, slope = points
    sampled = _around(contact, found)
    stress = _at_rim(contact, found, slope, *sampled)
    if not contact.periodic:
        squared = _von_mises_squared(stress)
        worth = np.flatnonzero(squared >= _WORTHWHILE**2 * squared.max())
        found, slope = found.where(worth), slope[worth]
        pressure, near = (values[..., worth] for values in sampled)
        near = near + _of_waves(contact, found)
        stress = _at_rim(contact, found, slope, pressure, near)
    squared = _von_mises_squared(stress)
    place = int(squared.argmax())
    xx, yy, xy = stress[:, place].tolist()
    middle, radius = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    shear = max(abs(middle) + radius, 2 * radius)
    # The pixel that holds the point: the one in contact, or the next.
    beyond = int(found.ahead[place] > 0.5) * found.step[:, place]
    row, column = int(found.rows[place] + beyond[0]), int(found.columns[place] + beyond[1])
    return Rim(math.sqrt(squared[place]), shear, (row % ny, column % nx))


def _points(contact: Sliding) -> _Points:
    """Return the rims between pixels in contact, three in a row, and one that is not."""
    touching = contact.pressure > 0
    found = []
    for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        rim = touching & ~_ahead(touching, step, 1, contact.periodic)
        for distance in (-1, -2):
            rim &= _ahead(touching, step, distance, contact.periodic)
        if not contact.periodic:
            # The stress around is needed.
            rim[[0, -1]] = rim[:, [0, -1]] = False
        rows, columns = np.nonzero(rim)
        steps = np.repeat(np.array(step)[:, None], rows.size, axis=1)
        found.append(_placed(contact, rows, columns, steps))
    return _Points(*(np.concatenate(parts, axis=-1) for parts in zip(*found, strict=True)))


def _ahead(values: NDArray[Any], step: tuple[int, int], distance: int, periodic: bool) -> Any:
    """Return what lies some steps ahead of each pixel; nothing lies beyond a free edge."""
    shift = [-distance * part for part in step]
    rolled = np.roll(values, shift, axis=(0, 1))
    if not periodic:
        for axis, by in enumerate(shift):
            beyond = slice(None, by) if by > 0 else slice(by or values.shape[axis], None)
            np.moveaxis(rolled, axis, 0)[beyond] = False
    return rolled


def _placed(contact: Sliding, rows: Index, columns: Index, step: Index) -> _Points:
    """Return where the rims are, and how they lie; those across another axis are left out."""

    def squared(forward: int, right: int = 0) -> Array:
        """Return p², which goes straight to zero, some steps ahead and aside."""
        down, along = forward * step + right * step[::-1]
        pressure: Array = contact.at(contact.pressure, rows + down, columns + along)
        return pressure**2

    near, far = squared(-1), squared(-2)
    # Pixels at the rim are in contact as a whole or not at all: the two behind them tell.
    falling = far > near
    ahead = np.where(falling, near / np.where(falling, far - near, 1) - 1, 0.5)
    forward = squared(1) - squared(-1)
    aside = squared(0, 1) - squared(0, -1)
    slope = -(forward * step + aside * step[::-1]) / np.array(contact.pixel)[:, None]
    normal = slope / np.maximum(np.hypot(*slope), np.finfo(float).tiny)
    y, x = contact.direction
    upright = (normal * step).sum(axis=0) >= _ALONG
    pulled = np.abs(normal[0] * y + normal[1] * x) >= _ACROSS
    points = _Points(rows, columns, step, np.clip(ahead, -0.5, 1.0), normal)
    return points.where(upright & pulled)


def _with_slope(contact: Sliding, points: _Points) -> tuple[_Points, Array] | None:
    """Return the points of resolved spots, with the slope along the traction in the contact."""
    # Two steps behind the rim, most of 5 × 5 pixels are in contact.
    rows, columns = points.rows - 2 * points.step[0], points.columns - 2 * points.step[1]
    weight = np.stack([contact.at(contact.pressure, rows + y, columns + x) for y, x in _WINDOW])
    weight = (weight > 0).astype(float)
    resolved = weight.sum(axis=0) >= _FEWEST
    if not resolved.any():
        return None
    points, weight = points.where(resolved), weight[:, resolved]
    rows, columns = rows[resolved], columns[resolved]
    heights = np.stack(
        [contact.at(contact.displacement, rows + y, columns + x) for y, x in _WINDOW]
    )
    heights = heights - contact.at(contact.displacement, rows, columns)
    normal = np.einsum("kn,ki,kj->nij", weight, _PARABOLA, _PARABOLA)
    right = np.einsum("kn,kn,ki->ni", weight, heights, _PARABOLA)
    _, y, x, yy, xx, xy = np.linalg.solve(normal, right[..., None])[..., 0].T
    down, along = (2 + points.ahead) * points.step
    slope_y = (y + 2 * yy * down + xy * along) / contact.pixel[0]
    slope_x = (x + 2 * xx * along + xy * down) / contact.pixel[1]
    towards = contact.direction
    slope: Array = towards[0] * slope_y + towards[1] * slope_x
    return points, slope


def _around(contact: Sliding, points: _Points) -> tuple[Array, Array]:
    """Return pressure and stress on the planes through 3 × 3 pixels, taken at the rims."""
    pressure, stress = np.zeros(points.rows.size), np.zeros((3, points.rows.size))
    for rows, columns, weight in _plane(points):
        pressure += weight * contact.at(contact.pressure, rows, columns)
        stress += weight * contact.at(contact.stress, rows, columns)
    return pressure, stress


def _plane(points: _Points) -> Iterator[tuple[Index, Index, Array]]:
    """Yield 3 × 3 pixels around, and their weight for a plane fitted to them at the rims."""
    for y, x in itertools.product((-1, 0, 1), repeat=2):
        forward = y * points.step[0] + x * points.step[1]
        yield points.rows + y, points.columns + x, 1 / 9 + points.ahead * forward / 6


def _at_rim(
    contact: Sliding, points: _Points, slope: Array, pressure: Array, stress: Array
) -> Array:
    """Return the stress at the rims, with pressure and slope of the contact for those sampled."""
    nu, mu = contact.poisson, contact.friction
    local = (1 + 2 * nu) * pressure
    if contact.periodic:
        # The mean pressure presses on a body that cannot expand sideways.
        local -= (1 + 2 * nu - 2 * nu / (1 - nu)) * float(contact.pressure.mean())
    sampled = (stress[0] + stress[1] + local) / ((1 + nu) * mu)
    (n_y, n_x), (e_y, e_x) = points.normal, contact.direction
    e_n, e_t = n_y * e_y + n_x * e_x, e_y * n_x - e_x * n_y
    change = mu * (slope - sampled) / e_n
    along, across = change * e_n + pressure, nu * (change * e_n + 2 * pressure)
    shear = 0.5 * change * e_t
    # The tangent is n_x along y, -n_y along x.
    found: Array = stress + np.stack(
        [
            along * n_x**2 + across * n_y**2 - 2 * shear * n_x * n_y,
            along * n_y**2 + across * n_x**2 + 2 * shear * n_x * n_y,
            (along - across) * n_x * n_y + shear * (n_x**2 - n_y**2),
        ]
    )
    return found


def _of_waves(contact: Sliding, points: _Points) -> Array:
    """Return what the stress at the rims changes by where pressure is a sum of waves."""
    kernel = _between_pixels(contact)[:, ::-1, ::-1]
    reach = np.arange(-_REACH - 1, _REACH + 2)
    near = contact.at(
        contact.pressure,
        points.rows[:, None, None] + reach[:, None],
        points.columns[:, None, None] + reach,
    )
    change = np.zeros((3, points.rows.size))
    for rows, columns, weight in _plane(points):
        down, along = rows[0] - points.rows[0] + 1, columns[0] - points.columns[0] + 1
        window = near[:, down : down + 2 * _REACH + 1, along : along + 2 * _REACH + 1]
        change += weight * np.einsum("cij,nij->cn", kernel, window)
    return change


def _between_pixels(contact: Sliding) -> Array:
    """Return the stress of a wave through one pixel, less that of the pixel, shape (3, ny, nx).

    Offsets go from ``-_REACH`` to ``_REACH``. Both fall off alike, the difference falls off fast.
    """
    (dy, dx), offsets = contact.pixel, np.arange(-_REACH, _REACH + 1)
    edges: Array = np.arange(-_REACH, _REACH + 2, dtype=np.float64) - 0.5
    qy: Array = 2 * math.pi * fft.frequencies(_PERIOD, dy)[:, None]
    qx: Array = 2 * math.pi * fft.half_frequencies(_PERIOD, dx)
    waves = stress_kernels.waves(qy, qx, 0.0, contact.poisson, contact.pulls)
    x: Array = edges * dx
    y: Array = edges * dy
    parts = stress_kernels.uniform_parts(x, y, 0.0, contact.poisson)
    pixels = stress_kernels.of_parts(parts, contact.poisson, 1.0, contact.pulls)
    difference = np.empty((3, offsets.size, offsets.size))
    for found, component in zip(difference, _IN_PLANE, strict=True):
        # A pressure has xy odd in both directions; a traction makes each odd in one of them.
        symbol = waves[component].astype(np.complex128) * (-1 if component == XY else 1)
        for traction in waves[6 + component :: 6]:
            symbol -= 1j * traction
        symbol[_PERIOD // 2] = symbol[:, -1] = 0
        smooth = fft.irfft2(symbol, (_PERIOD, _PERIOD))[np.ix_(offsets, offsets)]
        found[...] = smooth - pixels[component].T
        found -= found.mean()
    return difference


def _von_mises_squared(stress: Array) -> Array:
    xx, yy, xy = stress
    squared: Array = xx * xx - xx * yy + yy * yy + 3 * xy * xy
    return squared
