"""The largest stresses of a volume and their places, from slices that are not kept."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import require_positive
from roughcontact.halfspace import rims
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.stress import depth_list, graded_depths
from roughcontact.halfspace.stress_field import Field, field_of, pulls_of
from roughcontact.halfspace.tensors import XX, XY, XZ, YY, YZ, tresca, von_mises_squared

Array = NDArray[np.float64]

# How often the neighbourhood of the largest stress is looked at again.
_REFINEMENTS = 4


@dataclass(frozen=True, eq=False)
class Summary:
    """The largest stresses of a volume, depth by depth, and their places.

    They are those at the pixel centres; with friction, those at the surface are also looked for
    between them, at the rims of spots (`rims.largest`).

    Parameters
    ----------
    depths : ndarray, shape (nz,)
        Depths looked at [m], ascending.
    von_mises, tresca : ndarray, shape (nz,)
        Largest equivalent stress at each depth [Pa].
    pixels : ndarray of int, shape (nz, 2)
        Row and column of the largest von Mises stress at each depth.
    orthogonal_shear : ndarray, shape (nz, 2)
        Amplitude of the orthogonal shear stress at each depth [Pa], for passes along y and
        along x: half the range that σ_yz (σ_xz) runs through on the worst line in that direction,
        while the pressure passes by unchanged.
    peak : ndarray, shape (ny, nx)
        Largest von Mises stress over all depths [Pa].
    yield_strength : float or None
        σ_Y [Pa].
    yielded_area : ndarray, shape (nz,), or None
        Area where the von Mises stress exceeds σ_Y at each depth [m²].
    """

    depths: Array
    von_mises: Array
    tresca: Array
    pixels: NDArray[np.int64]
    orthogonal_shear: Array
    peak: NDArray[Any]
    yield_strength: float | None
    yielded_area: Array | None

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

        σ_Y over the largest von Mises stress. A contact whose area grows with the load does not
        simply scale its pressure: its load at first yield takes new solutions.
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


def summarise(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    poisson: float,
    *,
    depths: ArrayLike | None = None,
    yield_strength: float | None = None,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
    workers: int | None = None,
) -> Summary:
    """Return the equivalent stresses of a volume, without ever holding it.

    Parameters
    ----------
    pressure, pixel, poisson, boundary, friction, direction, precision, workers
        As for `slices`.
    depths : array_like, optional
        Depths z ≥ 0 [m]; by default those of `graded_depths`, and up to four more that close in
        on the largest von Mises stress.
    yield_strength : float, optional
        σ_Y [Pa].

    Returns
    -------
    Summary
        Largest stresses, their places, and what exceeds the yield strength.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Examples
    --------
    A Hertz contact of radius 20 pixels:

    >>> y, x = np.mgrid[-31.5:32, -31.5:32]
    >>> pressure = np.sqrt(np.maximum(1 - (x**2 + y**2) / 20**2, 0))
    >>> found = summarise(pressure, (1.0, 1.0), 0.3, yield_strength=1.0)
    >>> round(found.max_von_mises, 2), round(found.depth_of_max / 20, 2)
    (0.62, 0.48)
    """
    workspace = Workspace(workers)
    field = field_of(pressure, pixel, poisson, boundary, friction, direction, precision, workspace)
    if yield_strength is not None:
        require_positive(yield_strength=yield_strength)
    pulls = pulls_of(friction, direction)
    rim = partial(_rim, field, pressure, pixel, poisson, Boundary(boundary), pulls, workspace)
    # Between the points of a profile nothing is looked for.
    looked = pulls and field.shape[0] > 1
    passage = _Passage(field, yield_strength, np.asarray(pressure), rim if looked else None)
    if depths is None:
        passage.look(graded_depths(np.asarray(pressure), pixel, boundary=boundary))
        passage.close_in()
    else:
        passage.look(depth_list(depths))
    return passage.summary(pixel[0] * pixel[1])


class _Passage:
    """The depths of one stress field as they pass, and what is kept of them."""

    def __init__(
        self,
        field: Field,
        yield_strength: float | None,
        pressure: NDArray[Any],
        rim: Callable[[], rims.Rim | None] | None,
    ) -> None:
        self._field, self._strength, self._rim = field, yield_strength, rim
        self._limit = None if yield_strength is None else (yield_strength / field.unit) ** 2
        self._peak: NDArray[Any] = np.zeros(field.shape, field.real)
        self._layers: dict[float, _Layer] = {}
        # Where the largest stress is thought to be.
        self._row = int(np.abs(pressure).max(axis=1).argmax())

    def look(self, depths: Array) -> None:
        """Look at some depths, one after the other."""
        for depth in depths.tolist():
            self._layers[depth] = self._layer(depth)
            self._row = self._layers[depth].pixel[0]

    def close_in(self) -> None:
        """Look a few times more where the largest stress should be."""
        for _ in range(_REFINEMENTS):
            depth = _between(self._layers)
            if depth is None:
                break
            self._layers[depth] = self._layer(depth)

    def _layer(self, depth: float) -> _Layer:
        layer = _layer(self._field, depth, self._peak, self._limit, self._row)
        rim = None if depth > 0 or self._rim is None else self._rim()
        return layer if rim is None else self._with_rim(layer, rim)

    def _with_rim(self, layer: _Layer, rim: rims.Rim) -> _Layer:
        """Return the layer at the surface with what lies between its pixels."""
        squared = rim.von_mises**2
        self._peak[rim.pixel] = max(self._peak[rim.pixel], squared)
        if self._limit is not None and squared > self._limit:
            layer = replace(layer, yielded=max(layer.yielded, 1))
        layer = replace(layer, tresca=max(layer.tresca, rim.tresca))
        if rim.von_mises <= layer.von_mises:
            return layer
        return replace(layer, von_mises=rim.von_mises, pixel=rim.pixel)

    def summary(self, cell: float) -> Summary:
        """Return what was found, with pixels of this area; nothing can be looked at afterwards."""
        depths, unit, peak = sorted(self._layers), self._field.unit, self._peak
        layers = [self._layers[depth] for depth in depths]
        np.sqrt(peak, out=peak)
        peak *= unit
        area = np.array([layer.yielded * cell for layer in layers])
        return Summary(
            depths=np.array(depths),
            von_mises=np.array([layer.von_mises for layer in layers]) * unit,
            tresca=np.array([layer.tresca for layer in layers]) * unit,
            pixels=np.array([layer.pixel for layer in layers]),
            orthogonal_shear=np.array([layer.orthogonal_shear for layer in layers]) * unit,
            peak=peak,
            yield_strength=self._strength,
            yielded_area=None if self._strength is None else area,
        )


def _rim(
    field: Field,
    pressure: ArrayLike,
    pixel: tuple[float, float],
    poisson: float,
    boundary: Boundary,
    pulls: list[tuple[str, float]],
    workspace: Workspace,
) -> rims.Rim | None:
    """Return the largest stress at the rims of spots, in units of the largest pressure."""
    source = np.asarray(pressure, dtype=np.float64) / field.unit
    return rims.largest(
        rims.Sliding(
            pressure=source,
            displacement=_displacement(source, pixel, boundary, workspace),
            stress=_along_surface(field),
            pixel=pixel,
            poisson=poisson,
            pulls=pulls,
            periodic=not boundary.free_axes,
        )
    )


def _displacement(
    pressure: Array, pixel: tuple[float, float], boundary: Boundary, workspace: Workspace
) -> Array:
    """Return the normal displacement times E* [m] under a pressure without unit."""
    operator = boundary.operator(
        (pressure.shape[0], pressure.shape[1]), pixel, 1.0, workspace=workspace
    )
    loaded = np.flatnonzero(pressure)
    found: Array = np.empty(pressure.shape)

    def keep(_: int, rows: slice, displacement: NDArray[Any]) -> None:
        found[rows] = displacement

    operator.spread(operator.support(loaded), pressure.flat[loaded], keep)
    return found


def _along_surface(field: Field) -> NDArray[Any]:
    """Return xx, yy and xy at the surface, per largest pressure."""
    found: NDArray[Any] = np.empty((3, *field.shape), field.real)

    def keep(rows: slice, stress: NDArray[Any]) -> None:
        found[:, rows] = stress[[XX, YY, XY]]

    responses, symbols = field.at(0.0)
    responses.stream(symbols, keep)
    return found


@dataclass(frozen=True)
class _Layer:
    von_mises: float
    tresca: float
    pixel: tuple[int, int]
    orthogonal_shear: tuple[float, float]
    yielded: int


def _layer(field: Field, depth: float, peak: NDArray[Any], limit: float | None, row: int) -> _Layer:
    """Look at one depth: squared von Mises stress into ``peak``, and what the layer adds.

    ``row`` is where the largest stress is thought to be.
    """
    ny, nx = field.shape
    found: list[tuple[float, int, int]] = []
    tresca_squared = [0.0]
    x_range = np.zeros(ny)
    y_ranges: list[tuple[NDArray[Any], NDArray[Any]]] = []

    def visit(rows: slice, stress: NDArray[Any]) -> None:
        squared = von_mises_squared(stress)
        np.maximum(peak[rows], squared, out=peak[rows])
        place = int(squared.argmax())
        top = float(squared.flat[place])
        # Tresca is between one and 2/√3 times von Mises: few pixels can hold its maximum.
        least = 0.75 * max(top, max(tresca_squared))
        if top >= least:
            near = stress[:, squared >= least]
            tresca_squared.append(float(tresca(near).max()) ** 2)
        yielded = 0 if limit is None else int(np.count_nonzero(squared > limit))
        found.append((top, rows.start * nx + place, yielded))
        x_range[rows] = stress[XZ].max(axis=1) - stress[XZ].min(axis=1)
        y_ranges.append((stress[YZ].max(axis=0), stress[YZ].min(axis=0)))

    responses, symbols = field.at(depth)
    responses.stream(symbols, visit, row)
    top, place = max((entry[0], -entry[1]) for entry in found)
    high = np.max([entry[0] for entry in y_ranges], axis=0)
    low = np.min([entry[1] for entry in y_ranges], axis=0)
    return _Layer(
        von_mises=math.sqrt(top),
        tresca=math.sqrt(max(tresca_squared)),
        pixel=(-place // nx, -place % nx),
        orthogonal_shear=(float((high - low).max()) / 2, float(x_range.max()) / 2),
        yielded=sum(entry[2] for entry in found),
    )


def _between(layers: dict[float, _Layer]) -> float | None:
    """Return the depth where the largest stress should be, or nothing if it is known."""
    depths = sorted(layers)
    values = [layers[depth].von_mises for depth in depths]
    place = int(np.argmax(values))
    if place in (0, len(depths) - 1):
        return None
    (left, middle, right) = depths[place - 1 : place + 2]
    (low, top, high) = values[place - 1 : place + 2]
    # Vertex of the parabola through the three.
    before, behind = middle - left, right - middle
    fall_before, fall_behind = (top - low) / before, (top - high) / behind
    if not fall_before + fall_behind > 0:
        return None
    vertex = middle + 0.5 * (fall_before * behind - fall_behind * before) / (
        fall_before + fall_behind
    )
    # Within half a percent of the depth the stress is flat to 1e-4.
    return vertex if abs(vertex - middle) > 5e-3 * middle else None
