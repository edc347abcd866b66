"""Elastic stress in a coated body under pressure: layers, base and interfaces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.halfspace import stress_kernels
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.coating import waves_below
from roughcontact.halfspace.fft import Workspace, free_period
from roughcontact.halfspace.stress import Field, Offsets, Responses, Symbols, Term, UnitLoads
from roughcontact.halfspace.tensors import XX, XZ, YY, YZ, ZZ, principal
from roughcontact.material.material import Layer, Material

FACE = 1e-9
"""Distance of a face of a layer from its interface over the depth of the interface."""

# Interpolation points of the stress per factor of e in q; q times depth in the long-wave limit.
_WAVES, _LONGEST = 512, 1e-4
# On a free map, waves below a wave number are integrated, waves above it are summed over a period.
# The transition is an error function of this steepness s: at the periodic images, the sum has
# decayed to exp(-s²).
_STEEPNESS = 3.5
# Octaves of the integrated waves, and Gauss nodes of an octave of waves longer than the map.
_OCTAVES, _NODES = 14, 6
# Maximum length of a map over the distance of its periodic images.
_MAX_ASPECT = 16


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
    return (layer_at(material, depth) or material).poisson


def layer_at(material: Material, depth: float) -> Layer | None:
    """Return the layer at a depth; None in the base."""
    return next(iter(material.coating[part_of(material, depth) :]), None)


def part_of(material: Material, depth: float) -> int:
    """Return the index of the layer at a depth; for the base, the number of layers."""
    return int(np.searchsorted(interfaces(material), depth))


def field_of(
    pressure: Array,
    pixel: Pixel,
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
    wave: short waves are summed on a padded period, within which their sum decays; long waves,
    whose sum would reach the periodic images, are integrated (division by wave number as by Ewald,
    Ann. Phys. 369 (1921) 253, doi:10.1002/andp.19213690304).
    """
    boundary.require_known_below("the stress below the surface")
    unit = float(pressure.max()) or 1.0
    shape = (pressure.shape[0], pressure.shape[1])
    period = stress_period(shape, pixel, boundary)
    terms = UnitLoads(pixel, material.poisson).wave_terms()
    responses = Responses(pressure / unit, period, terms, workspace=workspace, precision=precision)
    qy, qx = (
        2 * math.pi / (points * edge) * np.arange(points // 2 + 1, dtype=np.float64)
        for points, edge in zip(period, pixel, strict=True)
    )
    smooth_y, smooth_x = (_pixel_factor(q, edge) for q, edge in zip((qy, qx), pixel, strict=True))
    long = _LongWaves.from_map(shape, pixel, period) if boundary.free_axes else None

    def in_depth(depth: float) -> tuple[Responses, Symbols]:
        waves = _Waves.from_depth(material, depth, (qy, qx), long)
        known = None
        if long is not None:
            integrated, waves = long.divide(waves)
            own = UnitLoads(pixel, poisson_at(material, depth))
            kernels = long.integrate(integrated, terms)
            known = responses.sample(partial(_sum_kernels, own, depth, kernels))

        def block(columns: slice) -> NDArray[Any]:
            added = waves.components(qy[:, None], qx[columns])
            # The wave at Nyquist has no sine. Along x the real transform drops it.
            if period[0] % 2 == 0:
                for term, symbol in zip(terms, added, strict=True):
                    symbol[-1] *= not term.odd[0]
            if known is None:
                return added
            result = known.block(columns)
            added *= np.outer(smooth_y, smooth_x[columns])
            result += added.astype(result.dtype)
            return result

        return responses, Symbols((period[0] // 2, period[1] // 2), block)

    def residual(depth: float) -> float:
        layer = layer_at(material, depth)
        return layer.residual_stress / unit if layer else 0.0

    return Field(unit, shape, responses.real, in_depth, residual)


def stress_period(shape: Shape, pixel: Pixel, boundary: Boundary) -> tuple[int, int]:
    """Return the period of the waves of the stress, in pixels."""
    if not boundary.free_axes:
        return shape
    apart = max(points * edge for points, edge in zip(shape, pixel, strict=True)) / _MAX_ASPECT
    y, x = (
        math.ceil((points + max(points, apart / edge)) / 2)
        for points, edge in zip(shape, pixel, strict=True)
    )
    return free_period((y, x))


def _pixel_factor(waves: Array, edge: float) -> Array:
    """Return the mean of waves over a pixel, from its center."""
    return np.sinc(waves * edge / (2 * math.pi))


@dataclass(frozen=True)
class _Waves:
    """Stress of waves of unit pressure at a depth, over the logarithm of the wave number.

    On a free map, minus the stress in a homogeneous body.
    """

    waves: Array  # Wave numbers [1/m], ascending
    parts: Array  # σ along the wave, across the wave, into the body, and the shear σ_lz
    uniform: tuple[float, float]  # σ in the plane, and into the body, where q = 0

    @classmethod
    def from_depth(
        cls, material: Material, depth: float, grid: tuple[Array, Array], long: _LongWaves | None
    ) -> _Waves:
        """Return the stress of waves as long and as short as on a grid and among long waves."""
        grids = [grid] if long is None else [grid, (long.y.waves, long.x.waves)]
        least = min(float(q[q > 0].min(initial=math.inf)) for axes in grids for q in axes)
        most = max(math.hypot(qy[-1], qx[-1]) for qy, qx in grids)
        waves = np.geomspace(least, most, math.ceil(_WAVES * math.log(most / least)) + 2)
        # In longer waves, which are at their limit, rounding grows.
        limited = np.maximum(waves, _LONGEST / float(interfaces(material)[-1]))
        poisson = poisson_at(material, depth)
        shear, normal, along = waves_below(material, limited, depth)
        parts = np.stack([along, poisson * (along + normal), normal, shear])
        if long is None:
            return cls(waves, parts, (-poisson / (1 - poisson), -1.0))
        own = stress_kernels.waves(np.zeros((1, 1)), limited, depth, poisson, [])
        parts -= np.concatenate([own[XX], own[YY], own[ZZ], own[XZ]])
        return cls(waves, parts, (0.0, 0.0))

    def components(self, qy: Array, qx: Array) -> Array:
        """Return xx, yy, zz, yz, xz, xy in the convention of `stress_kernels.waves`."""
        q = np.hypot(qy, qx)
        still = q == 0
        at, logs = np.log(np.where(still, 1.0, q)), np.log(self.waves)
        along, across, normal, shear = (np.interp(at, logs, part) for part in self.parts)
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
        return result


class _Axis(NamedTuple):
    """Integral over waves along an axis, at Chebyshev nodes up to half a period."""

    waves: Array  # Nodes of the integral [1/m], shape (m,)
    cosine: Array  # Cosine and sine times their weights, shape (m, n)
    sine: Array
    offsets: Array  # Interpolation from the Chebyshev nodes to offsets in pixels, shape (p, n)

    @classmethod
    def from_period(cls, points: int, edge: float, cutoff: float) -> _Axis:
        """Return the integral over waves up to twice a cutoff [1/m]."""
        half, reach = points // 2, points // 2 * edge
        ends = 2 * cutoff * np.append(0.0, 2.0 ** np.arange(-_OCTAVES, 1))
        waves, weights = [], []
        for width, start in zip(np.diff(ends).tolist(), ends.tolist(), strict=False):
            nodes, shares = leggauss(_NODES + math.ceil(width * reach / 2))
            waves.append(start + width * (1 + nodes) / 2)
            weights.append(width / 2 * shares)
        q = np.concatenate(waves)
        weight = np.concatenate(weights) * _pixel_factor(q, edge) * edge / math.pi
        degree = math.ceil(cutoff * reach) + 12
        angles = math.pi * (np.arange(degree) + 0.5) / degree
        turns = np.outer(q, reach * (1 + np.cos(angles)) / 2)
        to_series = 2 / degree * np.cos(np.outer(np.arange(degree), angles))
        to_series[0] /= 2
        series = chebvander(np.linspace(-1.0, 1.0, half + 1), degree - 1)
        # Not by BLAS, whose last digits depend on the number of threads.
        offsets = np.einsum("pk,kn->pn", series, to_series)
        return cls(q, weight[:, None] * np.cos(turns), weight[:, None] * np.sin(turns), offsets)


@dataclass(frozen=True)
class _LongWaves:
    """Waves that are integrated on a free map, because their sum would reach periodic images."""

    cutoff: float  # Wave number half of whose stress is integrated [1/m]
    y: _Axis
    x: _Axis

    @classmethod
    def from_map(cls, shape: Shape, pixel: Pixel, period: Shape) -> _LongWaves:
        """Return the waves that reach the images of a map with a period in pixels."""
        apart = (edge * (m - n) for edge, m, n in zip(pixel, period, shape, strict=True))
        cutoff = 2 * _STEEPNESS**2 / min(apart)
        y, x = (_Axis.from_period(m, edge, cutoff) for m, edge in zip(period, pixel, strict=True))
        return cls(cutoff, y, x)

    def divide(self, waves: _Waves) -> tuple[_Waves, _Waves]:
        """Return the parts of the stress that are integrated and summed."""
        from scipy.special import erfc

        share = erfc(_STEEPNESS * (waves.waves / self.cutoff - 1)) / 2
        return (
            replace(waves, parts=waves.parts * share),
            replace(waves, parts=waves.parts * (1 - share)),
        )

    def integrate(self, waves: _Waves, terms: Sequence[Term]) -> list[tuple[Array, Array]]:
        """Return kernels under unit pressure on the pixel at the origin, as factors X and Y.

        A kernel is the sum of ``X[column] * Y[row]`` over the last axis.
        """
        y, x = self.y, self.x
        result = []
        components = waves.components(y.waves[:, None], x.waves)
        for term, component in zip(terms, components, strict=True):
            along_y, along_x = (
                axis.sine if odd else axis.cosine
                for axis, odd in zip((y, x), term.odd, strict=True)
            )
            nodes = np.einsum("lj,li->ij", np.einsum("kl,kj->lj", component, along_y), along_x)
            if y.offsets.shape[1] < x.offsets.shape[1]:
                result.append((np.einsum("ci,ij->cj", x.offsets, nodes), y.offsets))
            else:
                result.append((x.offsets, np.einsum("rj,ij->ri", y.offsets, nodes)))
        return result


def _sum_kernels(
    own: UnitLoads, depth: float, long: list[tuple[Array, Array]], rows: Offsets, columns: Offsets
) -> Iterator[Array]:
    """Yield kernels of a homogeneous body together with long waves."""
    for kernel, (x, y) in zip(own.sample_pixels(depth, rows, columns), long, strict=True):
        yield kernel + np.einsum("ci,ri->cr", x[columns], y[rows])


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
    found, width = [], field.shape[1]
    for depth in depths_with_faces(material, np.empty(0)).tolist():
        # Value and negative place, so that the first of equal values is the largest.
        blocks: list[list[tuple[float, int]]] = []

        def find_largest(
            rows: slice, stress: NDArray[Any], blocks: list[list[tuple[float, int]]] = blocks
        ) -> None:
            shear = np.hypot(stress[XZ], stress[YZ])
            values = principal(stress).max(axis=0), shear, stress[ZZ]
            places = [int(part.argmax()) for part in values]
            blocks.append(
                [
                    (float(part.flat[place]), -rows.start * width - place)
                    for part, place in zip(values, places, strict=True)
                ]
            )

        field.stream(depth, find_largest)
        tension, shear, pull = (
            Peak(value * field.unit, divmod(-place, width))
            for value, place in map(max, zip(*blocks, strict=True))
        )
        found.append(Face(depth, part_of(material, depth), tension, shear, pull))
    return tuple(found)
