"""Elastic stress in a coated body under pressure: layers, base and interfaces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.coating import waves_below
from roughcontact.halfspace.fft import Workspace, free_period
from roughcontact.halfspace.stress import Field, Responses, Streams, Symbols, Term, unit_loads
from roughcontact.halfspace.tensors import XZ, YY, YZ, ZZ, principal
from roughcontact.material.material import Material

Array = NDArray[np.float64]

FACE = 1e-9
"""Distance of a face of a layer from its interface over the depth of the interface."""

# Interpolation points of the stress per factor of e in q; q times depth in the long-wave limit.
_WAVES, _LONGEST = 512, 1e-4


def interfaces(material: Material) -> Array:
    """Return the depths of the interfaces of a coated body [m], the outermost first."""
    return np.cumsum([layer.thickness for layer in material.coating])


def depths_with_faces(material: Material, depths: Array) -> Array:
    """Return depths [m] together with the surface and both sides of each interface."""
    between = interfaces(material)
    listed = np.concatenate([[0.0], depths, between * (1 - FACE), between * (1 + FACE)])
    # There is no stress in a rigid base.
    end = between[-1] if math.isinf(material.young) else math.inf
    return np.unique(listed[listed < end])


def poisson_at(material: Material, depth: float) -> float:
    """Return Poisson's ratio of the layer or base at a depth."""
    part = part_of(material, depth)
    return material.coating[part].poisson if part < len(material.coating) else material.poisson


def part_of(material: Material, depth: float) -> int:
    """Return the index of the layer at a depth; for the base, the number of layers."""
    return int(np.searchsorted(interfaces(material), depth))


def field_of(
    pressure: Array,
    pixel: tuple[float, float],
    material: Material,
    boundary: Boundary,
    precision: str,
    workspace: Workspace,
) -> Field:
    """Return the stress field below a pressure in a coated body.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Pressure on the surface [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    material : Material
        The coated body.
    boundary : Boundary
        Free or periodic.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    workspace : Workspace
        Threads and memory.

    Returns
    -------
    Field
        The stress.

    Notes
    -----
    Periodic: each wave has its exact stress. Free: the stress of a homogeneous body of the
    material at that depth is exact (`stress.slices`). The effect of the layers is added wave by
    wave on a padded period. Its long-range part, of the orders q⁰ and q¹, is replaced by the stress
    of homogeneous bodies at two depths; the rest falls as 1/r⁵, so that images hardly contribute.
    """
    boundary.require_stress()
    unit = float(pressure.max()) or 1.0
    shape = (pressure.shape[0], pressure.shape[1])
    free = bool(boundary.free_axes)
    period = _free_period(material, shape, pixel) if free else shape

    loads = unit_loads(pixel, material.poisson)
    terms = loads.terms() if free else loads.wave_terms()
    responses = Responses(pressure / unit, period, terms, workspace=workspace, precision=precision)
    grid = _Grid.from_period(period, pixel)

    def in_depth(depth: float) -> tuple[Streams, Symbols]:
        bodies = _bodies(material, depth) if free else ()
        below = _Waves.from_depth(material, depth, grid, bodies)
        known = responses.sampled(partial(_kernels, bodies, pixel)) if free else None

        def block(columns: slice) -> NDArray[Any]:
            added = below.components(grid, columns, terms)
            if known is None:
                return added
            result = known.block(columns)
            added *= np.outer(grid.smooth[0], grid.smooth[1][columns])
            result += added.astype(result.dtype)
            return result

        symbols = Symbols((period[0] // 2, period[1] // 2), block)
        return _prestressed(responses, material, depth, unit), symbols

    return Field(unit, shape, responses.real, in_depth)


class _Grid(NamedTuple):
    """Wave numbers of a period [1/m], and the factor of a pixel for each wave."""

    period: tuple[int, int]
    qy: Array
    qx: Array
    smooth: tuple[Array, Array]

    @classmethod
    def from_period(cls, period: tuple[int, int], pixel: tuple[float, float]) -> _Grid:
        """Return the waves of a period with this pixel."""
        numbers = [np.arange(points // 2 + 1, dtype=np.float64) for points in period]
        qy, qx = (
            2 * math.pi / (points * edge) * number
            for points, edge, number in zip(period, pixel, numbers, strict=True)
        )
        y, x = (np.sinc(number / points) for points, number in zip(period, numbers, strict=True))
        return cls(period, qy, qx, (y, x))


def _prestressed(responses: Responses, material: Material, depth: float, unit: float) -> Streams:
    """Return responses to a pressure, plus the residual stress of the layer at a depth."""
    part = part_of(material, depth)
    residual = material.coating[part].residual_stress if part < len(material.coating) else 0.0
    return _Prestressed(responses, residual / unit) if residual else responses


class _Prestressed(NamedTuple):
    """Responses plus a residual stress in the plane."""

    responses: Responses
    residual: float

    def stream(
        self, symbols: Symbols, visit: Callable[[slice, NDArray[Any]], None], first_row: int = 0
    ) -> None:
        """Pass the stress to a callback in row blocks; see `Responses.stream`."""

        def add_residual(rows: slice, block: NDArray[Any]) -> None:
            block[: YY + 1] += self.residual
            visit(rows, block)

        self.responses.stream(symbols, add_residual, first_row)


def _free_period(
    material: Material, shape: tuple[int, int], pixel: tuple[float, float]
) -> tuple[int, int]:
    """Return a period in which the bending of the layers does not reach the images."""
    base = material.young if math.isfinite(material.young) else material.coating[0].young
    stiffest = max(layer.young for layer in material.coating)
    bent = float(interfaces(material)[-1]) * max(1.0, stiffest / base) ** (1 / 3)
    y, x = (
        points + min(points, math.ceil(2 * bent / edge))
        for points, edge in zip(shape, pixel, strict=True)
    )
    return free_period((y, x))


class _Body(NamedTuple):
    """Homogeneous body whose stress at a depth is subtracted from the waves, times factors."""

    depth: float
    poisson: float
    in_plane: float  # Factor of xx, yy and xy
    shear: float  # Factor of xz and yz
    normal: float  # Factor of zz

    def sample_pixels(self, pixel: tuple[float, float], rows: Any, columns: Any) -> Iterator[Array]:
        """Yield kernels of the stress under unit pressure on the pixel at the origin."""
        kernels = unit_loads(pixel, self.poisson).sample_pixels(self.depth, rows, columns)
        factors = {ZZ: self.normal, XZ: self.shear, YZ: self.shear}
        for number, kernel in enumerate(kernels):
            yield kernel * factors.get(number, self.in_plane)

    def waves(self, waves: Array) -> tuple[Array, Array, Array, Array]:
        """Return the stress along the waves, across them, into the body, and the shear."""
        qz = waves * self.depth
        damping = np.exp(-qz)
        return (
            self.in_plane * (qz - 1) * damping,
            -2 * self.in_plane * self.poisson * damping,
            -self.normal * (1 + qz) * damping,
            -self.shear * qz * damping,
        )


def _bodies(material: Material, depth: float) -> tuple[_Body, ...]:
    """Return the homogeneous body at a depth, and two for the long-range part of layers."""
    poisson = poisson_at(material, depth)
    own, reach = _Body(depth, poisson, 1.0, 1.0, 1.0), float(interfaces(material)[-1])
    waves = np.array([1.0, 2.0]) * _LONGEST / max(depth, reach)
    shear, normal, along = waves_below(material, waves, depth)
    known = own.waves(waves)
    added = np.array([along - known[0], poisson * (along + normal) - known[1], shear - known[3]])
    slope = (added[:, 1] - added[:, 0]) / waves[0]
    limit = added[:, 0] - waves[0] * slope
    # At the depths t and 2 t: along -A (1 - 2 q z), across -2 A ν (1 - q z), shear -B q z.
    lower = slope[0] / (2 * reach) + limit[0], slope[1] / reach + limit[1]
    upper = -limit[0] - lower[0], -limit[1] - lower[1]
    ratios = [across / (2 * part) if part else 0.0 for part, across in (upper, lower)]
    return (
        own,
        _Body(reach, ratios[0], upper[0], -slope[2] / reach, 0.0),
        _Body(2 * reach, ratios[1], lower[0], 0.0, 0.0),
    )


def _kernels(
    bodies: tuple[_Body, ...], pixel: tuple[float, float], rows: Any, columns: Any
) -> Iterator[Array]:
    """Yield the sums of the kernels of some bodies."""
    parts = [body.sample_pixels(pixel, rows, columns) for body in bodies]
    yield from (sum(kernels[1:], kernels[0]) for kernels in zip(*parts, strict=True))


@dataclass(frozen=True)
class _Waves:
    """Stress of waves of unit pressure at a depth, over the logarithm of the wave number."""

    waves: Array  # Logarithms, ascending
    along: Array  # σ along the wave; then σ across the wave, σ into the body, and the shear σ_lz
    across: Array
    normal: Array
    shear: Array
    uniform: tuple[float, float]  # σ in the plane, and into the body, where q = 0

    @classmethod
    def from_depth(
        cls, material: Material, depth: float, grid: _Grid, bodies: tuple[_Body, ...]
    ) -> _Waves:
        """Return the stress of waves minus the stress of homogeneous bodies."""
        qy, qx = grid.qy, grid.qx
        least = min(qy[1] if qy.size > 1 else math.inf, qx[1] if qx.size > 1 else math.inf)
        most = math.hypot(qy[-1], qx[-1])
        steps = math.ceil(_WAVES * math.log(most / least)) + 2
        waves = np.geomspace(least, most, steps)
        poisson = poisson_at(material, depth)
        shear, normal, along = waves_below(material, waves, depth)
        across = poisson * (along + normal)
        uniform = -poisson / (1 - poisson), -1.0
        if bodies:
            uniform = 0.0, 0.0
        for body in bodies:
            parts = zip((along, across, normal, shear), body.waves(waves), strict=True)
            along, across, normal, shear = (part - of_body for part, of_body in parts)
        return cls(np.log(waves), along, across, normal, shear, uniform)

    def components(self, grid: _Grid, columns: slice, terms: Sequence[Term]) -> Array:
        """Return xx, yy, zz, yz, xz, xy in the convention of `stress_kernels.waves`."""
        qy, qx = grid.qy[:, None], grid.qx[columns]
        q = np.hypot(qy, qx)
        still = q == 0
        at = np.log(np.where(still, 1.0, q))
        along, across, normal, shear = (
            np.interp(at, self.waves, part)
            for part in (self.along, self.across, self.normal, self.shear)
        )
        inverse = np.divide(1, q, out=np.zeros(q.shape), where=~still)
        c, s = qx * inverse, qy * inverse
        result = np.stack(
            [
                c * c * along + s * s * across,
                s * s * along + c * c * across,
                normal,
                s * shear,
                c * shear,
                # Odd in both directions: the transform is -S.
                c * s * (across - along),
            ]
        )
        result[:, still] = 0
        result[:2, still], result[2, still] = self.uniform
        # The wave at Nyquist has no sine. Along x the real transform drops it.
        if grid.period[0] % 2 == 0:
            for term, symbol in zip(terms, result, strict=True):
                symbol[-1] *= not term.odd[0]
        return result


class Peak(NamedTuple):
    """Largest value of a stress at a depth, and its pixel."""

    value: float  # [Pa]
    pixel: tuple[int, int]  # Row and column


@dataclass(frozen=True)
class Face:
    """Largest stresses on one side of the surface or of an interface."""

    depth: float  # [m]
    part: int  # Index of the layer; for the base, the number of layers
    tension: Peak  # Largest principal stress
    shear: Peak  # Traction along the face
    pull: Peak  # Largest normal stress on the face; negative if all of it is in compression


def faces(field: Field, material: Material) -> tuple[Face, ...]:
    """Return the largest stresses of the surface and of both sides of each interface."""
    found = []
    for depth in depths_with_faces(material, np.empty(0)).tolist():
        stress: NDArray[Any] = np.empty((6, *field.shape), field.real)

        def store_rows(rows: slice, block: NDArray[Any], stress: NDArray[Any] = stress) -> None:
            stress[:, rows] = block

        responses, symbols = field.in_depth(depth)
        responses.stream(symbols, store_rows)

        def peak(values: NDArray[Any]) -> Peak:
            row, column = divmod(int(values.argmax()), field.shape[1])
            return Peak(float(values[row, column]) * field.unit, (row, column))

        tension = principal(stress).max(axis=0)
        shear = np.hypot(stress[XZ], stress[YZ])
        found.append(
            Face(depth, part_of(material, depth), peak(tension), peak(shear), peak(stress[ZZ]))
        )
    return tuple(found)
