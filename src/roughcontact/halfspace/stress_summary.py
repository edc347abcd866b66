"""Largest stresses of a volume and their places, from slices that are not stored."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import require_positive
from roughcontact.halfspace import fft, stress_kernels
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.stress import (
    CrossSection,
    Field,
    cross_section,
    depth_list,
    field_of,
    graded_depths,
    planes,
    pulls_of,
)
from roughcontact.halfspace.tensors import (
    XX,
    XY,
    XZ,
    YY,
    YZ,
    may_reach_tresca,
    tresca,
    von_mises_squared,
)

Index = NDArray[np.int64]

# Minimum cosine between the traction and the normal of a rim. Where the traction is nearly along a
# rim, the effect is small, and the slope across the rim does not follow from the slope along the
# traction.
_ACROSS = 0.5
# Minimum cosine between the normal of a rim and the axis along which the rim is located.
_ALONG = 0.6
# The slope is taken from a parabola fitted to the pixels in contact of 5 × 5. No conic goes through
# this minimum number of pixels, so the fit is unique. Smaller spots are not resolved, and get no
# correction.
_HALF, _FEWEST = 2, 15
_WINDOW = list(itertools.product(range(-_HALF, _HALF + 1), repeat=2))
_PARABOLA = np.array([(1, y, x, y * y, x * x, x * y) for y, x in _WINDOW], dtype=np.float64)
# Rims whose stress, by pixels of constant pressure, is below this fraction of the largest are not
# evaluated again.
_WORTHWHILE = 0.9
# Reach of the difference between two interpolations of the pressure between pixels, and the period
# on which the difference is computed, in pixels.
_REACH, _PERIOD = 12, 128
_IN_PLANE = (XX, YY, XY)


class Rim(NamedTuple):
    """Largest stresses at the rims, in the unit of the pressure, and their pixels.

    ``pixel`` has the largest von Mises stress, ``tension_pixel`` the largest principal stress.
    """

    von_mises: float
    tresca: float
    pixel: tuple[int, int]
    tension: float
    tension_pixel: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Sliding:
    """Sliding contact, sampled at the pixel centers of its surface.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Pressure p in any unit; positive where there is contact.
    displacement : ndarray, shape (1, ny, nx) or (2, ny, nx)
        Normal displacement times E* under the pressure, per unit of pressure [m]; with a
        ``traction``, under each of its components as if it were a pressure.
    stress : ndarray, shape (3, ny, nx)
        xx, yy and xy at the surface.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    poisson : float
        Poisson's ratio ν.
    pulls : sequence of (axis, float)
        Tractions on the body along "x" or "y", per pressure; not all zero.
    periodic : bool
        Whether the map is one period, and its pressure a sum of waves; else the map is isolated,
        and the pressure is constant on each pixel.
    traction : ndarray, shape (2, ny, nx), optional
        Traction on the body with the components (y, x), in the unit of the pressure; without
        ``pulls``.
    """

    pressure: NDArray[Any]
    displacement: NDArray[Any]
    stress: NDArray[Any]
    pixel: tuple[float, float]
    poisson: float
    pulls: Sequence[tuple[str, float]]
    periodic: bool
    traction: NDArray[Any] | None = None

    @property
    def friction(self) -> float:
        """Traction over the load of ``displacement``: coefficient μ > 0, or 1 for a map."""
        return math.hypot(*(share for _, share in self.pulls)) if self.traction is None else 1.0

    def direction_at(self, rows: Index, columns: Index) -> Any:
        """Return the unit vector of the traction at pixels, along y and along x."""
        if self.traction is None:
            shares = dict(self.pulls)
            return shares.get("y", 0.0) / self.friction, shares.get("x", 0.0) / self.friction
        found = self.values_at(self.traction, rows, columns)
        return found / np.maximum(np.hypot(*found), np.finfo(float).tiny)

    def loads(self) -> list[tuple[NDArray[Any], float, Sequence[tuple[str, float]]]]:
        """Return the loads of the surface: maps, each with the pressure and traction per unit."""
        if self.traction is None:
            return [(self.pressure, 1.0, self.pulls)]
        along_y, along_x = self.traction
        return [
            (self.pressure, 1.0, ()),
            (along_x, 0.0, [("x", 1.0)]),
            (along_y, 0.0, [("y", 1.0)]),
        ]

    def values_at(self, values: NDArray[Any], rows: Index, columns: Index) -> NDArray[Any]:
        """Return values of a map at pixels, zero beyond its edges."""
        ny, nx = self.pressure.shape
        result: NDArray[Any] = values[..., rows % ny, columns % nx]
        if self.periodic:
            return result
        return np.where((rows >= 0) & (rows < ny) & (columns >= 0) & (columns < nx), result, 0)


class _Points(NamedTuple):
    """Points of rims, each located from a pixel along an axis of the map.

    ``ahead`` is the distance from the center of the pixel in steps, ``normal`` points out of the
    contact, components along y and x.
    """

    rows: Index
    columns: Index
    step: NDArray[np.int64]
    ahead: Array
    normal: Array

    def where(self, chosen: NDArray[Any]) -> _Points:
        """Return the selected points."""
        return _Points(
            self.rows[chosen],
            self.columns[chosen],
            self.step[:, chosen],
            self.ahead[chosen],
            self.normal[:, chosen],
        )


def largest(contact: Sliding) -> Rim | None:
    """Return the largest stresses at the rims of resolved spots, or None without these.

    Parameters
    ----------
    contact : Sliding
        The contact.

    Notes
    -----
    A pressure that is constant on each pixel has waves of a few pixels, whose stress is not in
    plane strain across the rim. So for relevant rims, the stress is first replaced by the stress
    of the sum of waves through the pixel centers.
    """
    points = _with_slope(contact, _points(contact))
    if points is None:
        return None
    place, stress = _largest_of(contact, *points, _von_mises_squared)
    other, tension = _largest_of(contact, *points, larger_principal)
    xx, yy, xy = stress.tolist()
    middle, radius = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    shear = max(abs(middle) + radius, 2 * radius)
    von_mises = math.sqrt(_von_mises_squared(stress))
    return Rim(von_mises, shear, place, float(larger_principal(tension)), other)


def _largest_of(
    contact: Sliding, points: _Points, slope: Array, measure: Callable[[Array], Any]
) -> tuple[tuple[int, int], Array]:
    """Return the pixel where a measure of the stress is largest, and the stress there."""
    sampled = _plane_values(contact, points)
    stress = _rim_stress(contact, points, slope, *sampled)
    if not contact.periodic:
        values = measure(stress)
        high = float(values.max())
        worth = np.flatnonzero(values >= high - (1 - _WORTHWHILE**2) * abs(high))
        points, slope = points.where(worth), slope[worth]
        pressure, near = (values[..., worth] for values in sampled)
        near = near + _wave_correction(contact, points)
        stress = _rim_stress(contact, points, slope, pressure, near)
    place = int(measure(stress).argmax())
    # The pixel that contains the point: the one in contact, or the next one.
    beyond = int(points.ahead[place] > 0.5) * points.step[:, place]
    row, column = int(points.rows[place] + beyond[0]), int(points.columns[place] + beyond[1])
    ny, nx = contact.pressure.shape
    return (row % ny, column % nx), stress[:, place]


def _points(contact: Sliding) -> _Points:
    """Return the rims between three pixels in contact in a row and one without contact."""
    touching = contact.pressure > 0
    result = []
    for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        rim = touching & ~_next_pixels(touching, step, 1, contact.periodic)
        for distance in (-1, -2):
            rim &= _next_pixels(touching, step, distance, contact.periodic)
        if not contact.periodic:
            # The stress of all neighbors is needed.
            rim[[0, -1]] = rim[:, [0, -1]] = False
        rows, columns = np.nonzero(rim)
        steps = np.repeat(np.array(step)[:, None], rows.size, axis=1)
        result.append(_locate_rims(contact, rows, columns, steps))
    return _Points(*(np.concatenate(parts, axis=-1) for parts in zip(*result, strict=True)))


def _next_pixels(values: NDArray[Any], step: tuple[int, int], distance: int, periodic: bool) -> Any:
    """Return the values some steps ahead of each pixel; zero beyond a free edge."""
    shift = [-distance * part for part in step]
    rolled = np.roll(values, shift, axis=(0, 1))
    if not periodic:
        for axis, by in enumerate(shift):
            beyond = slice(None, by) if by > 0 else slice(by or values.shape[axis], None)
            np.moveaxis(rolled, axis, 0)[beyond] = False
    return rolled


def _locate_rims(contact: Sliding, rows: Index, columns: Index, step: Index) -> _Points:
    """Return positions and normals of the rims that are across the step and the traction."""

    def squared(forward: int, right: int = 0) -> Array:
        """Return p², which falls linearly to zero at the rim, some steps ahead and aside."""
        down, along = forward * step + right * step[::-1]
        pressure: Array = contact.values_at(contact.pressure, rows + down, columns + along)
        return pressure**2

    near, far = squared(-1), squared(-2)
    # A pixel at the rim is in contact completely or not at all: extrapolate from the two behind it.
    falling = far > near
    ahead = np.where(falling, near / np.where(falling, far - near, 1) - 1, 0.5)
    forward = squared(1) - squared(-1)
    aside = squared(0, 1) - squared(0, -1)
    slope = -(forward * step + aside * step[::-1]) / np.array(contact.pixel)[:, None]
    normal = slope / np.maximum(np.hypot(*slope), np.finfo(float).tiny)
    y, x = contact.direction_at(rows, columns)
    upright = (normal * step).sum(axis=0) >= _ALONG
    pulled = np.abs(normal[0] * y + normal[1] * x) >= _ACROSS
    points = _Points(rows, columns, step, np.clip(ahead, -0.5, 1.0), normal)
    return points.where(upright & pulled)


def _with_slope(contact: Sliding, points: _Points) -> tuple[_Points, Array] | None:
    """Return the points of resolved spots, and the slope along the traction in contact.

    For a traction map the slope is the divergence of the displacements by both components, which
    for a fixed direction is the slope along the traction.
    """
    # Two steps behind the rim, most of 5 × 5 pixels are in contact.
    rows, columns = points.rows - 2 * points.step[0], points.columns - 2 * points.step[1]
    weight = np.stack(
        [contact.values_at(contact.pressure, rows + y, columns + x) for y, x in _WINDOW]
    )
    weight = (weight > 0).astype(float)
    resolved = weight.sum(axis=0) >= _FEWEST
    if not resolved.any():
        return None
    points, weight = points.where(resolved), weight[:, resolved]
    rows, columns = rows[resolved], columns[resolved]
    normal = np.einsum("kn,ki,kj->nij", weight, _PARABOLA, _PARABOLA)
    down, along = (2 + points.ahead) * points.step
    gradients = []
    for field in contact.displacement:
        heights = np.stack([contact.values_at(field, rows + y, columns + x) for y, x in _WINDOW])
        heights = heights - contact.values_at(field, rows, columns)
        right = np.einsum("kn,kn,ki->ni", weight, heights, _PARABOLA)
        _, y, x, yy, xx, xy = np.linalg.solve(normal, right[..., None])[..., 0].T
        slope_y = (y + 2 * yy * down + xy * along) / contact.pixel[0]
        slope_x = (x + 2 * xx * along + xy * down) / contact.pixel[1]
        gradients.append((slope_y, slope_x))
    towards = contact.direction_at(points.rows, points.columns)
    if contact.traction is None:
        slope: Array = towards[0] * slope_y + towards[1] * slope_x
    else:
        slope = gradients[0][0] + gradients[1][1]
    return points, slope


def _plane_values(contact: Sliding, points: _Points) -> tuple[Array, Array]:
    """Return pressure and stress at the rims, from planes fitted to 3 × 3 pixels."""
    pressure, stress = np.zeros(points.rows.size), np.zeros((3, points.rows.size))
    for rows, columns, weight in _plane(points):
        pressure += weight * contact.values_at(contact.pressure, rows, columns)
        stress += weight * contact.values_at(contact.stress, rows, columns)
    return pressure, stress


def _plane(points: _Points) -> Iterator[tuple[Index, Index, Array]]:
    """Yield the 3 × 3 pixels around each point, and their weights in a plane at the rim."""
    for y, x in itertools.product((-1, 0, 1), repeat=2):
        forward = y * points.step[0] + x * points.step[1]
        yield points.rows + y, points.columns + x, 1 / 9 + points.ahead * forward / 6


def _rim_stress(
    contact: Sliding, points: _Points, slope: Array, pressure: Array, stress: Array
) -> Array:
    """Return the stress at the rims, corrected to the pressure and slope in the contact."""
    nu, mu = contact.poisson, contact.friction
    local = (1 + 2 * nu) * pressure
    if contact.periodic:
        # The mean pressure acts on a body that cannot expand sideways.
        local -= (1 + 2 * nu - 2 * nu / (1 - nu)) * float(contact.pressure.mean())
    sampled = (stress[0] + stress[1] + local) / ((1 + nu) * mu)
    (n_y, n_x), (e_y, e_x) = points.normal, contact.direction_at(points.rows, points.columns)
    e_n, e_t = n_y * e_y + n_x * e_x, e_y * n_x - e_x * n_y
    change = mu * (slope - sampled) / e_n
    along, across = change * e_n + pressure, nu * (change * e_n + 2 * pressure)
    shear = 0.5 * change * e_t
    # The tangent is n_x along y, -n_y along x.
    return stress + np.stack(
        [
            along * n_x**2 + across * n_y**2 - 2 * shear * n_x * n_y,
            along * n_y**2 + across * n_x**2 + 2 * shear * n_x * n_y,
            (along - across) * n_x * n_y + shear * (n_x**2 - n_y**2),
        ]
    )


def _wave_correction(contact: Sliding, points: _Points) -> Array:
    """Return the change of the stress at the rims if the pressure is a sum of waves."""
    reach = np.arange(-_REACH - 1, _REACH + 2)
    change = np.zeros((3, points.rows.size))
    for load, pressure, pulls in contact.loads():
        kernel = _between_pixels(contact, pressure, pulls)[:, ::-1, ::-1]
        near = contact.values_at(
            load, points.rows[:, None, None] + reach[:, None], points.columns[:, None, None] + reach
        )
        for rows, columns, weight in _plane(points):
            down, along = rows[0] - points.rows[0] + 1, columns[0] - points.columns[0] + 1
            window = near[:, down : down + 2 * _REACH + 1, along : along + 2 * _REACH + 1]
            change += weight * np.einsum("cij,nij->cn", kernel, window)
    return change


def _between_pixels(contact: Sliding, pressure: float, pulls: Sequence[tuple[str, float]]) -> Array:
    """Return the stress by waves through one pixel minus the stress by the pixel.

    Shape (3, ny, nx), offsets from ``-_REACH`` to ``_REACH``. Both stresses have the same far
    field, so that the difference decays fast.
    """
    (dy, dx), offsets = contact.pixel, np.arange(-_REACH, _REACH + 1)
    edges: Array = np.arange(-_REACH, _REACH + 2, dtype=np.float64) - 0.5
    qy: Array = 2 * math.pi * fft.frequencies(_PERIOD, dy)[:, None]
    qx: Array = 2 * math.pi * fft.half_frequencies(_PERIOD, dx)
    waves = stress_kernels.waves(qy, qx, 0.0, contact.poisson, pulls)
    x: Array = edges * dx
    y: Array = edges * dy
    parts = stress_kernels.uniform_parts(x, y, 0.0, contact.poisson)
    pixels = stress_kernels.sum_parts(parts, contact.poisson, pressure, pulls)
    difference = np.empty((3, offsets.size, offsets.size))
    for result, component in zip(difference, _IN_PLANE, strict=True):
        # Under pressure xy is odd in both directions; a traction makes each odd in one of them.
        symbol = waves[component].astype(np.complex128) * (-1 if component == XY else 1) * pressure
        for traction in waves[6 + component :: 6]:
            symbol -= 1j * traction
        symbol[_PERIOD // 2] = symbol[:, -1] = 0
        smooth = fft.irfft2(symbol, (_PERIOD, _PERIOD))[np.ix_(offsets, offsets)]
        result[...] = smooth - pixels[component].T
        result -= result.mean()
    return difference


def _von_mises_squared(stress: Array) -> Array:
    xx, yy, xy = stress
    return xx * xx - xx * yy + yy * yy + 3 * xy * xy


def larger_principal(stress: NDArray[Any]) -> NDArray[Any]:
    """Return the larger principal stress in the surface from its components xx, yy, xy."""
    xx, yy, xy = stress
    return 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)


# Maximum number of further depths near the largest stress.
_REFINEMENTS = 4


@dataclass(frozen=True, eq=False)
class Summary:
    """Largest stresses of a volume, depth by depth, and their places.

    Stresses are evaluated at the pixel centers; with friction, at the surface also between the
    centers, at the rims of spots (`stress_summary.largest`).

    Parameters
    ----------
    depths : ndarray, shape (nz,)
        Evaluated depths [m], ascending.
    von_mises, tresca : ndarray, shape (nz,)
        Largest equivalent stress at each depth [Pa].
    pixels : ndarray of int, shape (nz, 2)
        Row and column of the largest von Mises stress at each depth.
    orthogonal_shear : ndarray, shape (nz, 2)
        Amplitude of the orthogonal shear stress at each depth [Pa], for passes along y and
        along x: half the range of σ_yz (σ_xz) on the worst line in this direction, while the
        unchanged pressure passes.
    peak : ndarray, shape (ny, nx)
        Largest von Mises stress over all depths [Pa].
    yield_strength : float or None
        σ_Y [Pa].
    yielded_area : ndarray, shape (nz,), or None
        Area where the von Mises stress exceeds σ_Y at each depth [m²].
    max_tension : float or None
        Largest principal stress in the surface [Pa]; None if the depths do not include the surface.
    tension_pixel : (int, int)
        Row and column of the largest principal stress.
    """

    depths: Array
    von_mises: Array
    tresca: Array
    pixels: NDArray[np.int64]
    orthogonal_shear: Array
    peak: NDArray[Any]
    yield_strength: float | None
    yielded_area: Array | None
    max_tension: float | None = None
    tension_pixel: tuple[int, int] = (0, 0)

    @property
    def max_von_mises(self) -> float:
        """Largest von Mises stress [Pa]."""
        return float(self.von_mises.max())

    @property
    def max_tresca(self) -> float:
        """Largest Tresca stress [Pa]."""
        return float(self.tresca.max())

    @property
    def max_orthogonal_shear(self) -> tuple[float, float]:
        """Largest amplitudes of the orthogonal shear stress for passes along y and x [Pa]."""
        along_y, along_x = self.orthogonal_shear.max(axis=0)
        return float(along_y), float(along_x)

    @property
    def depth_of_max(self) -> float:
        """Depth of the largest von Mises stress [m]."""
        return float(self.depths[self.von_mises.argmax()])

    @property
    def pixel_of_max(self) -> tuple[int, int]:
        """Row and column of the largest von Mises stress."""
        row, column = self.pixels[self.von_mises.argmax()]
        return int(row), int(column)

    @property
    def yield_factor(self) -> float | None:
        """Factor by which the whole pressure may grow until the first point yields.

        σ_Y over the largest von Mises stress. If the area of a contact grows with the load, its
        pressure does not simply scale: its load at first yield requires further solutions.
        """
        if self.yield_strength is None:
            return None
        return self.yield_strength / self.max_von_mises if self.max_von_mises > 0 else math.inf

    @property
    def yielded_volume(self) -> float | None:
        """Volume where the von Mises stress exceeds σ_Y [m³], by the trapezoidal rule in depth."""
        if self.yielded_area is None:
            return None
        means = 0.5 * (self.yielded_area[1:] + self.yielded_area[:-1])
        return float((means * np.diff(self.depths)).sum())


def summarize(pressure: ArrayLike, pixel: Pixel, poisson: float, **options: Any) -> Summary:
    """Return the largest stresses of a volume without storing the volume.

    Parameters
    ----------
    pressure, pixel, poisson
        As for `slices`.
    **options
        ``boundary``, ``friction``, ``direction``, ``traction``, ``precision`` and ``workers`` as
        for `slices`; ``depths`` z ≥ 0 [m], by default those of `graded_depths` and up to four more
        near the largest von Mises stress; ``yield_strength`` σ_Y [Pa].

    Returns
    -------
    Summary
        Largest stresses, their places, and the area and volume above the yield strength.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Examples
    --------
    A Hertz contact of radius 20 pixels:

    >>> y, x = np.mgrid[-31.5:32, -31.5:32]
    >>> pressure = np.sqrt(np.maximum(1 - (x**2 + y**2) / 20**2, 0))
    >>> found = summarize(pressure, (1.0, 1.0), 0.3, yield_strength=1.0)
    >>> round(found.max_von_mises, 2), round(found.depth_of_max / 20, 2)
    (0.62, 0.48)
    """
    passage = _stream_depths(pressure, pixel, poisson, **options)
    return passage.summary(pixel[0] * pixel[1])


def summarize_with_sections(
    pressure: ArrayLike, pixel: Pixel, poisson: float, **options: Any
) -> tuple[Summary, NDArray[Any], NDArray[Any]]:
    """Return the summary, and the stress on planes through its largest von Mises stress.

    Parameters
    ----------
    pressure, pixel, poisson, options
        As for `summarize`; ``tell(number, count)`` is called before each depth.

    Returns
    -------
    summary : Summary
        The result of `summarize`.
    along_x : ndarray, shape (6, nz, nx)
        Stress on the plane along x, for the depths of the summary [Pa].
    along_y : ndarray, shape (6, nz, ny)
        Stress on the plane along y [Pa].
    """
    passage = _stream_depths(pressure, pixel, poisson, **options)
    summary = passage.summary(pixel[0] * pixel[1])
    return summary, *passage.sections(summary.pixel_of_max)


def summarize_field(
    field: Field,
    pressure: Array,
    depths: Array,
    cell: float,
    tell: Callable[[int, int], None] | None = None,
) -> tuple[Summary, NDArray[Any], NDArray[Any]]:
    """Summarize any field like `summarize_with_sections`, with pixels of a given area [m²]."""
    passage = _DepthScan(field, None, pressure, None, tell)
    passage.scan_depths(depths)
    summary = passage.summary(cell)
    return summary, *passage.sections(summary.pixel_of_max)


def _stream_depths(
    pressure: ArrayLike,
    pixel: Pixel,
    poisson: float,
    *,
    depths: ArrayLike | None = None,
    yield_strength: float | None = None,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    traction: ArrayLike | None = None,
    precision: str = "single",
    workers: int | None = None,
    tell: Callable[[int, int], None] | None = None,
) -> _DepthScan:
    """Return the completed depth scan of `summarize`."""
    workspace = Workspace(workers)
    field = field_of(
        pressure, pixel, poisson, boundary, friction, direction, precision, workspace, traction
    )
    if yield_strength is not None:
        require_positive(yield_strength=yield_strength)
    source, pulls = np.asarray(pressure, dtype=np.float64), pulls_of(friction, direction)
    pulled = None if traction is None else np.asarray(traction, dtype=np.float64) / field.unit

    def rim() -> Rim | None:
        """Return the largest stress at the rims of spots, in units of the largest pressure."""
        loaded, known = source / field.unit, Boundary(boundary)
        operator = known.operator(source.shape, pixel, 1.0, workspace=workspace)
        return largest(
            Sliding(
                pressure=loaded,
                displacement=np.stack(list(map(operator, [loaded] if pulled is None else pulled))),
                stress=_along_surface(field),
                pixel=pixel,
                poisson=poisson,
                pulls=pulls,
                periodic=not known.free_axes,
                traction=pulled,
            )
        )

    # The maximum is not searched between the points of a profile.
    looked = (pulls or traction is not None) and field.shape[0] > 1
    passage = _DepthScan(field, yield_strength, source, rim if looked else None, tell)
    if depths is None:
        listed = graded_depths(np.asarray(pressure), pixel, boundary=boundary)
        passage.scan_depths(listed, _REFINEMENTS)
        passage.refine_maximum()
    else:
        passage.scan_depths(depth_list(depths))
    return passage


class _DepthScan:
    """Scan of one stress field over depths, and its results."""

    def __init__(
        self,
        field: Field,
        yield_strength: float | None,
        pressure: NDArray[Any],
        rim: Callable[[], Rim | None] | None,
        tell: Callable[[int, int], None] | None,
    ) -> None:
        self._field, self._strength, self._rim = field, yield_strength, rim
        self._tell, self._count = tell, 0
        self._limit = None if yield_strength is None else (yield_strength / field.unit) ** 2
        self._peak: NDArray[Any] = np.zeros(field.shape, field.real)
        self._layers: dict[float, _Layer] = {}
        # Expected row of the largest stress of the next layer; pixel and value of all layers.
        self._row = int(np.abs(pressure).max(axis=1).argmax())
        self._pixel, self._largest = (self._row, 0), 0.0

    def scan_depths(self, depths: Array, more: int = 0) -> None:
        """Evaluate depths one after the other; up to ``more`` further depths may follow."""
        self._count = depths.size + more
        for depth in depths.tolist():
            self._layers[depth] = self._layer(depth)
            self._row = self._layers[depth].pixel[0]

    def refine_maximum(self) -> None:
        """Evaluate a few more depths at the expected depth of the largest stress."""
        for _ in range(_REFINEMENTS):
            depth = _refined_depth(self._layers)
            if depth is None:
                break
            self._layers[depth] = self._layer(depth)

    def _layer(self, depth: float) -> _Layer:
        if self._tell is not None:
            self._tell(len(self._layers) + 1, self._count)
        layer = self._layer_at_centers(depth)
        rim = None if depth > 0 or self._rim is None else self._rim()
        if rim is not None:
            layer = self._with_rim(layer, rim)
        if layer.von_mises > self._largest:
            self._pixel, self._largest = layer.pixel, layer.von_mises
        return layer

    def _layer_at_centers(self, depth: float) -> _Layer:
        """Evaluate one depth at the pixel centers, and update the squared von Mises stress."""
        cross = CrossSection(self._field, self._pixel)
        ny, nx = self._field.shape
        result: list[tuple[float, int, int]] = []
        tensions: list[tuple[float, int]] = []
        tresca_squared = [0.0]
        x_range = np.zeros(ny)
        y_ranges: list[tuple[NDArray[Any], NDArray[Any]]] = []

        def visit(rows: slice, stress: NDArray[Any]) -> None:
            cross.store_block(rows, stress)
            squared = von_mises_squared(stress)
            np.maximum(self._peak[rows], squared, out=self._peak[rows])
            place = int(squared.argmax())
            top = float(squared.flat[place])
            # Tresca is between one and 2/√3 times von Mises: few pixels can hold its maximum.
            minimum = 0.75 * max(top, max(tresca_squared))
            if top >= minimum:
                near = stress[:, squared >= minimum]
                near = near[:, may_reach_tresca(near, minimum / 0.75)]
                tresca_squared.append(float(tresca(near).max(initial=0)) ** 2)
            yielded = 0 if self._limit is None else int(np.count_nonzero(squared > self._limit))
            result.append((top, rows.start * nx + place, yielded))
            if depth == 0:
                tension = larger_principal(stress[list(_IN_PLANE)])
                tensions.append((float(tension.max()), -rows.start * nx - int(tension.argmax())))
            x_range[rows] = stress[XZ].max(axis=1) - stress[XZ].min(axis=1)
            y_ranges.append((stress[YZ].max(axis=0), stress[YZ].min(axis=0)))

        self._field.stream(depth, visit, self._row)
        top, place = max((entry[0], -entry[1]) for entry in result)
        high = np.max([entry[0] for entry in y_ranges], axis=0)
        low = np.min([entry[1] for entry in y_ranges], axis=0)
        pulled, where = max(tensions, default=(None, 0))
        return _Layer(
            von_mises=math.sqrt(top),
            tresca=math.sqrt(max(tresca_squared)),
            pixel=(-place // nx, -place % nx),
            orthogonal_shear=(float((high - low).max()) / 2, float(x_range.max()) / 2),
            yielded=sum(entry[2] for entry in result),
            cross=cross,
            tension=pulled,
            tension_pixel=(-where // nx, -where % nx),
        )

    def _with_rim(self, layer: _Layer, rim: Rim) -> _Layer:
        """Return the layer at the surface, with the stresses between its pixel centers."""
        squared = rim.von_mises**2
        self._peak[rim.pixel] = max(self._peak[rim.pixel], squared)
        if self._limit is not None and squared > self._limit:
            layer = replace(layer, yielded=max(layer.yielded, 1))
        layer = replace(layer, tresca=max(layer.tresca, rim.tresca))
        assert layer.tension is not None
        if rim.tension > layer.tension:
            layer = replace(layer, tension=rim.tension, tension_pixel=rim.tension_pixel)
        if rim.von_mises <= layer.von_mises:
            return layer
        return replace(layer, von_mises=rim.von_mises, pixel=rim.pixel)

    def sections(self, point: tuple[int, int]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the stress on the planes through a pixel, stored with most of the layers."""
        crosses = [
            layer.cross if layer.cross.point == point else cross_section(self._field, depth, point)
            for depth, layer in sorted(self._layers.items())
        ]
        return planes(self._field, crosses)

    def summary(self, cell: float) -> Summary:
        """Return the summary for pixels of a given area [m²], which ends the scan."""
        depths, unit, peak = sorted(self._layers), self._field.unit, self._peak
        layers = [self._layers[depth] for depth in depths]
        np.sqrt(peak, out=peak)
        peak *= unit
        area = np.array([layer.yielded * cell for layer in layers])
        top = layers[0]
        return Summary(
            depths=np.array(depths),
            von_mises=np.array([layer.von_mises for layer in layers]) * unit,
            tresca=np.array([layer.tresca for layer in layers]) * unit,
            pixels=np.array([layer.pixel for layer in layers]),
            orthogonal_shear=np.array([layer.orthogonal_shear for layer in layers]) * unit,
            peak=peak,
            yield_strength=self._strength,
            yielded_area=None if self._strength is None else area,
            max_tension=None if top.tension is None else top.tension * unit,
            tension_pixel=top.tension_pixel,
        )


def _along_surface(field: Field) -> NDArray[Any]:
    """Return xx, yy and xy at the surface, in units of the largest pressure."""
    result: NDArray[Any] = np.empty((3, *field.shape), field.real)

    def store_stress(rows: slice, stress: NDArray[Any]) -> None:
        result[:, rows] = stress[[XX, YY, XY]]

    field.stream(0.0, store_stress)
    return result


@dataclass(frozen=True)
class _Layer:
    von_mises: float
    tresca: float
    pixel: tuple[int, int]
    orthogonal_shear: tuple[float, float]
    yielded: int
    cross: CrossSection
    tension: float | None  # Largest principal stress in the surface; None below it
    tension_pixel: tuple[int, int]


def _refined_depth(layers: dict[float, _Layer]) -> float | None:
    """Return the expected depth of the largest stress, or None if it is close enough."""
    depths = sorted(layers)
    values = [layers[depth].von_mises for depth in depths]
    place = int(np.argmax(values))
    if place in (0, len(depths) - 1):
        return None
    (left, middle, right) = depths[place - 1 : place + 2]
    (low, top, high) = values[place - 1 : place + 2]
    # Vertex of the parabola through the three depths.
    before, behind = middle - left, right - middle
    fall_before, fall_behind = (top - low) / before, (top - high) / behind
    if not fall_before + fall_behind > 0:
        return None
    vertex = middle + 0.5 * (fall_before * behind - fall_behind * before) / (
        fall_before + fall_behind
    )
    # Within half a percent of the depth the stress is flat to 1e-4.
    return vertex if abs(vertex - middle) > 5e-3 * middle else None
