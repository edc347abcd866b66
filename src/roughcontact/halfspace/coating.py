"""Response of a coated half-space to waves and pixels of pressure.

A wave of pressure ``p cos(q x)`` on a stack of bonded layers displaces its surface by
``2/(E₁* q) (1 + F(q h₁)) p cos(q x)``, E₁* and h₁ of the outermost layer. F falls as
exp(-2 q h₁), so that on a free map the effect of the stack is smooth on the scale of h₁:

    K = Love's coefficients of the layer + Δ,  Δ(r) = D(r/h₁)/(π E₁* h₁),  D(ρ) = ∫ F(H) J₀(H ρ) dH.

D and the corner integral M(ρ) = ∫ D ρ dρ are tabulated once for a stack and all pixel sizes. On a
strip the effect is a sum over waves across the strip, and on a profile another table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebfit, chebint, chebval
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.halfspace import fft
from roughcontact.material.material import Material

# Integrals over waves for D, on a ray at this angle to the real axis, where the integrand does not
# oscillate: first and last end of the panels in H ρ, their growth, and the nodes of one panel. F
# has no pole below 30 degrees; its lowest one, of bending, is at 60.
_ANGLE = math.pi / 6
_FIRST, _LAST, _GROWTH, _NODES = 1e-8, 75.0, 3.0, 16
# Chebyshev nodes, and points of the table, per unit of asinh ρ.
_PIECE, _DENSE = 16, 4096
# Distance in pixels within which corners are integrated, and the nodes of their angles.
_NEAR, _ANGLES = 10, 32
# Pixel edge over thickness up to which D hardly changes within a pixel.
_MAX_PIXEL_SHARE = 0.1
# Interpolation points of the response per factor of e in H, up to H = exp(4), where the base has no
# effect; q times the total thickness in the limit of uniform pressure.
_WAVES, _DEEPEST, _LONGEST = 2048, 4, 1e-3
# H below which F is linear to rounding.
_STRAIGHT = 1e-5
# Excess compliance of the bodies over their outermost layers above which these bend.
_SOFT = 2.0
# Exponent beyond which a wave has decayed; terms of a sum over waves shorter than two pixels.
_DEAD, _TERMS = 40.0, 12


@dataclass(frozen=True)
class ConductingLayer:
    """Layer on a conductor."""

    resistivity: float  # Electrical resistivity [Ω m], or 1/k [m K/W]
    thickness: float  # [m]


@dataclass(frozen=True)
class ConductingStack:
    """Layers on a conductor, in place of the coated material of an elastic body.

    The surface potential under a current density ``j cos(q x)`` is ``ρ₁/q (1 + F) j cos(q x)``
    with the resistivity ρ₁ of the outermost layer, as the displacement is ``2/(E* q) (1 + F)``
    times the pressure.
    """

    resistivity: float  # Of the base
    coating: tuple[ConductingLayer, ...] = ()  # The outermost first
    young: float = 1.0  # Finite: the base conducts

    @property
    def compliance(self) -> float:
        """Resistivity at the surface."""
        return self.coating[0].resistivity if self.coating else self.resistivity

    @property
    def uncoated(self) -> ConductingStack:
        """Base without its layers."""
        return ConductingStack(self.resistivity)

    def excess(self, waves: NDArray[Any]) -> NDArray[Any]:
        """Return F as `layer_excess` does; at each interface a part of the wave is reflected.

        Antonetti and Yovanovich 1985, J. Heat Transfer 107, 513, for one layer
        """
        outer, ratio = self.coating[0], np.asarray(self.resistivity / self.coating[0].resistivity)
        for item in reversed(self.coating):
            own = item.resistivity / outer.resistivity
            reflected = (ratio - own) / (ratio + own)
            reflected = reflected * np.exp(-2 * waves * (item.thickness / outer.thickness))
            ratio = own * (1 + reflected) / (1 - reflected)
        return ratio - 1


Coated = Material | ConductingStack


def layer_excess(material: Coated, waves: NDArray[Any]) -> NDArray[Any]:
    """Return F, the relative contribution of what is below the outermost layer.

    Parameters
    ----------
    material : Material
        A coated body.
    waves : ndarray
        H = q h₁, wave numbers times the thickness of the outermost layer; positive, or complex.

    Returns
    -------
    ndarray
        F(H): the displacement is ``2/(E₁* q) (1 + F)`` times the pressure.

    Notes
    -----
    In each layer two waves fall and two rise, each written as exp(-distance from the face where it
    starts), so that no exponential grows. With φ = a exp(s ζ)/q² and ψ = b exp(s ζ)/q, s = -1 for
    falling waves (ζ from the upper face) and +1 for rising waves (ζ ≤ 0 from the lower face)::

        2 μ q u_x = a + ζ b             2 μ q u_z = (3 - 4ν - s ζ) b - s a
        σ_xz = s a + (s ζ - 1 + 2ν) b   σ_zz = -a + (2 (1 - ν) s - ζ) b

    From the base up, each layer transfers the compliance at its lower face to its upper face.

    References
    ----------
    Burmister, J. Appl. Phys. 16 (1945) 89, doi:10.1063/1.1707558;
    O'Sullivan and King, J. Tribol. 110 (1988) 235, doi:10.1115/1.3261591
    """
    if isinstance(material, ConductingStack):
        return material.excess(waves)
    compliance = _layers(material, waves.ravel())[0].compliance()
    return (-compliance[1, 1] / (2 * (1 - material.coating[0].poisson)) - 1).reshape(waves.shape)


def _product(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    """Return the matrix product of arrays of shape (rows, columns, n)."""
    return np.einsum("ijn,jkn->ikn", first, second)


def _inverse(matrix: NDArray[Any]) -> NDArray[Any]:
    """Return the inverses of matrices of shape (2, 2, n)."""
    (a, b), (c, d) = matrix
    return np.array([[d, -b], [-c, a]]) / (a * d - b * c)


def _state(
    sign: int, depth: NDArray[Any], distance: NDArray[Any], poisson: float, shear: float
) -> NDArray[Any]:
    """Return displacements and stresses of the two waves of one direction, shape (5, 2, n).

    The rows are u_x, u_z, σ_xz, σ_zz and σ_xx; displacements times 2 q and the reference modulus
    of ``shear``. ``distance`` is measured from the face where the waves start.
    """
    one = np.ones_like(depth)
    waves = np.array(
        [
            [one / shear, depth / shear],
            [-sign * one / shear, (3 - 4 * poisson - sign * depth) / shear],
            [sign * one, sign * depth - (1 - 2 * poisson)],
            [-one, 2 * (1 - poisson) * sign - depth],
            [one, 2 * poisson * sign + depth],
        ]
    )
    return waves * np.exp(-distance)


@dataclass(frozen=True)
class _Layer:
    """Layer, or elastic base, under waves of n lengths."""

    poisson: float
    shear: float  # Ratio of the shear modulus to the outermost layer
    thickness: NDArray[Any] | None  # q h, shape (n,); None for the base, which is infinite
    rising: NDArray[Any]  # Amplitudes of rising waves over falling waves, (2, 2, n)

    def state(self, depth: NDArray[Any]) -> NDArray[Any]:
        """Return the state by falling waves of unit amplitude at depth q ζ, shape (5, 2, n)."""
        result = _state(-1, depth, depth, self.poisson, self.shear)
        if self.thickness is not None:
            above = self.thickness - depth
            risen = _state(1, -above, above, self.poisson, self.shear)
            result += _product(risen, self.rising)
        return result

    def falling_waves(self) -> NDArray[Any]:
        """Return the amplitudes of falling waves under unit σ_xz and σ_zz on the upper face."""
        return _inverse(self.state(np.zeros_like(self.rising[0, 0]))[2:4])

    def compliance(self) -> NDArray[Any]:
        """Return the displacements of the upper face under unit tractions on it."""
        return _product(self.state(np.zeros_like(self.rising[0, 0]))[:2], self.falling_waves())


def _layers(material: Material, waves: NDArray[Any]) -> list[_Layer]:
    """Return the layers, the outermost first, and the base if it is elastic."""
    outermost = material.coating[0]

    def shear(young: float, poisson: float) -> float:
        return young / (1 + poisson) * (1 + outermost.poisson) / outermost.young

    layers: list[_Layer] = []
    none = np.zeros((2, 2, waves.size), waves.dtype)
    below = none
    if math.isfinite(material.young):
        layers.append(_Layer(material.poisson, shear(material.young, material.poisson), None, none))
        below = layers[0].compliance()
    # At the lower face of a layer, displacements are the compliance times the tractions.
    unit = np.zeros_like(none)
    unit[0, 0] = unit[1, 1] = 1
    held = np.concatenate([unit, -below], axis=1)
    if material.base == "frictionless":
        held = np.zeros((2, 4, waves.size), waves.dtype)
        held[0, 1] = held[1, 2] = 1
    for item in reversed(material.coating):
        ratio, deep = (
            shear(item.young, item.poisson),
            waves * (item.thickness / outermost.thickness),
        )
        start = np.zeros_like(deep)
        fallen = _state(-1, deep, deep, item.poisson, ratio)[:4]
        risen = _state(1, start, start, item.poisson, ratio)[:4]
        rising = -_product(_inverse(_product(held, risen)), _product(held, fallen))
        layers.append(_Layer(item.poisson, ratio, deep, rising))
        held = np.concatenate([unit, -layers[-1].compliance()], axis=1)
    return layers[::-1]


def waves_below(material: Material, waves: Array, depth: float) -> NDArray[Any]:
    """Return the stress at a depth below waves of unit pressure.

    Parameters
    ----------
    material : Material
        A coated body.
    waves : ndarray, shape (n,)
        Wave numbers q > 0 [1/m].
    depth : float
        Depth [m].

    Returns
    -------
    ndarray, shape (3, n)
        Under a pressure cos(q x): σ_xz over sin(q x), σ_zz and σ_xx over cos(q x). Tension is
        positive, the body fills z > 0.
    """
    scaled = waves * material.coating[0].thickness
    traction = np.zeros((2, 1, waves.size))
    traction[1] = -1
    above = 0.0
    for layer, item in zip(_layers(material, scaled), (*material.coating, None), strict=False):
        amplitudes = _product(layer.falling_waves(), traction)
        if item is None or depth <= above + item.thickness:
            return _product(layer.state(waves * (depth - above)), amplitudes)[2:, 0]
        assert layer.thickness is not None
        traction = _product(layer.state(layer.thickness), amplitudes)[2:4]
        above += item.thickness
    raise ValueError("a rigid base has no stress")


@dataclass(frozen=True)
class Table:
    """Table of D and M of a stack at equal steps of asinh ρ."""

    kernel: Array  # D
    corner: Array  # M


def _lookup(table: Array, rho: Array) -> Array:
    """Return D or M at distances ρ in units of the thickness of the outermost layer."""
    return np.interp(np.arcsinh(rho) * _DENSE, np.arange(table.size), table)


@lru_cache(maxsize=16)
def tabulate(material: Coated, pieces: int, *, line: bool = False) -> Table:
    """Return D and M of a coated body up to ``asinh ρ = pieces``.

    J₀ is the real part of a Hankel function, which falls as ``exp(-|H| ρ/2)`` on a path at 30
    degrees; in H ρ, one set of nodes, graded towards 0, serves all distances. For a line load D is
    ``∫ (F - F(0) exp(-H)) cos(H ρ)/H dH`` and M is ``∫ D dρ``.
    """
    from scipy.special import hankel1

    waves, weights = _ray_quadrature()
    weights = weights * (np.exp(1j * waves) if line else hankel1(0, waves))
    nodes = np.cos(np.pi * (np.arange(_PIECE) + 0.5) / _PIECE)
    dense = 2 * np.arange(_DENSE) / _DENSE - 1
    kernel, corner, before = [], [], 0.0
    for piece in range(pieces):
        rho, slope = (f(piece + (nodes + 1) / 2) for f in (np.sinh, np.cosh))
        depths = waves / rho[:, None]
        found = _beyond_log(material, depths) if line else layer_excess(material, depths)
        values = (found * weights).sum(axis=1).real / rho
        kernel.append(chebval(dense, chebfit(nodes, values, _PIECE - 1)))
        width = slope / 2 if line else rho * slope / 2
        grown = chebint(chebfit(nodes, values * width, _PIECE - 1), lbnd=-1)
        corner.append(before + chebval(dense, grown))
        before += float(chebval(1.0, grown))
    return Table(np.concatenate(kernel), np.concatenate(corner))


def _beyond_log(material: Coated, waves: NDArray[Any]) -> NDArray[Any]:
    """Return ``(F(H) - F(0) exp(-H))/H``."""
    size = np.abs(waves)
    straight = waves * np.maximum(1, _STRAIGHT / size)
    return (
        layer_excess(material, straight) - _base_softness(material) * np.exp(-straight)
    ) / straight


def _base_softness(material: Coated) -> float:
    """Return F(0), the excess compliance of the base over the outermost layer; -1 if rigid."""
    return material.uncoated.compliance / material.compliance - 1


def _ray_quadrature() -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the nodes H ρ on the ray, and their weights."""
    panels = math.ceil(math.log(_LAST / _FIRST) / math.log(_GROWTH))
    ends = np.append(0.0, _LAST * _GROWTH ** np.arange(-panels, 1.0))
    nodes, weights = leggauss(_NODES)
    half = np.diff(ends)[:, None] / 2
    turn = np.exp(1j * _ANGLE)
    waves = turn * (ends[:-1, None] + half * (nodes + 1)).ravel()
    return waves, turn * (half * weights).ravel()


def pixel_response(
    material: Coated, shape: Shape, pixel: Pixel, first_row: int, table: Table
) -> Array:
    """Return the contribution of the inner layers to the displacement of pixels.

    Parameters
    ----------
    material : Material
        A coated body.
    shape : (int, int)
        Number of offsets ``(ny, nx)``: ``nx`` from 0 in x, ``ny`` from ``first_row`` in y.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    first_row : int
        Offset in y of the first row.
    table : Table
        Table that covers the offsets.

    Returns
    -------
    ndarray, shape (ny, nx)
        π E₁* times the displacement under unit pressure on the pixel ``[0, 0]`` [m], minus the
        displacement of a homogeneous body of the outermost layer, ``π E₁* kernels.love``.

    Notes
    -----
    Near the origin D is integrated over the corners of pixels, ∫∫ D dA = ∫ M(x/cos θ) dθ over each
    of the two triangles of a rectangle; farther away, by 2 × 2 Gauss points.
    """
    thickness = material.coating[0].thickness
    dy, dx = (edge / thickness for edge in pixel)
    rows = np.arange(first_row, first_row + shape[0], dtype=float)[:, None]
    columns = np.arange(shape[1], dtype=float)
    shift = 1 / math.sqrt(12)
    added = np.zeros(shape)
    for side in (-shift, shift):
        for other in (-shift, shift):
            added += _lookup(table.kernel, np.hypot(dy * (rows + side), dx * (columns + other)))
    added *= dy * dx / 4
    near = max(0, min(shape[0], _NEAR - first_row)), min(shape[1], _NEAR)
    if near[0] and max(dy, dx) > _MAX_PIXEL_SHARE:
        y: Array = dy * (np.arange(first_row, first_row + near[0] + 1.0) - 0.5)[:, None]
        x: Array = dx * (np.arange(near[1] + 1.0) - 0.5)
        corners = _corner(table, y, x)
        added[: near[0], : near[1]] = np.diff(np.diff(corners, axis=0), axis=1)
    return added * thickness


def _corner(table: Table, y: Array, x: Array) -> Array:
    """Return the integral of D from the origin to the corners (y, x), odd in both."""
    nodes, weights = leggauss(_ANGLES)
    corner = np.zeros(np.broadcast_shapes(y.shape, x.shape))
    for side, other in ((np.abs(x), np.abs(y)), (np.abs(y), np.abs(x))):
        half = np.arctan2(other, side) / 2
        for node, weight in zip(nodes, weights, strict=True):
            corner += weight * half * _lookup(table.corner, side / np.cos(half * (1 + node)))
    return corner * np.sign(y) * np.sign(x)


@dataclass(frozen=True)
class Coatings:
    """Contribution of the layers of two bodies to the response of their surfaces."""

    bodies: tuple[Coated, ...]  # The coated bodies
    shares: tuple[float, ...]  # Their shares of 1/E*, with E* of both surfaces
    grounded: bool  # Whether every deformable body is on a rigid base

    @classmethod
    def from_bodies(cls, *bodies: Coated) -> Coatings | None:
        """Return the coatings of two bodies, or None if neither is coated."""
        total = sum(body.compliance for body in bodies)
        coated = tuple(body for body in bodies if body.coating)
        if not coated:
            return None
        shares = tuple(body.compliance / total for body in coated)
        return cls(coated, shares, all(math.isinf(body.young) for body in bodies))

    @property
    def is_long_wave_soft(self) -> bool:
        """Whether long waves are far more compliant than short ones: stiff films, soft bodies."""
        softer = map(_base_softness, self.bodies)
        return sum(s * more for s, more in zip(self.shares, softer, strict=True)) > _SOFT

    def tables(self, reach: float) -> list[Table]:
        """Return the tables up to a distance [m]; call it before threads share the tables."""
        return [
            tabulate(body, math.ceil(math.asinh(reach / body.coating[0].thickness)) + 1)
            for body in self.bodies
        ]

    def pixels(self, shape: Shape, pixel: Pixel, first_row: int, tables: list[Table]) -> Array:
        """Return π E* times the contribution of the coatings to `kernels.love` of E* [m]."""
        added = np.zeros(shape)
        for body, share, table in zip(self.bodies, self.shares, tables, strict=True):
            added += share * pixel_response(body, shape, pixel, first_row, table)
        return added

    def factor(self, waves: Array) -> Array:
        """Return the response over ``2/(E* q)`` for wave numbers q > 0 [1/m], of any shape."""
        result = np.ones(waves.shape)
        for body, share in zip(self.bodies, self.shares, strict=True):
            depths = np.log(waves * body.coating[0].thickness)
            known = _interpolant(body, min(math.floor(depths.min(initial=0.0)), 0))
            result += share * np.expm1(np.interp(depths, *known))
        return result

    def uniform(self) -> float:
        """Return E*/2 times the displacement under uniform pressure [m]; 0 unless grounded."""
        if not self.grounded:
            return 0.0
        wave = _LONGEST / sum(layer.thickness for body in self.bodies for layer in body.coating)
        return float(self.factor(np.array([wave]))[0]) / wave

    def strip(self, shape: Shape, pixel: Pixel, datum: float, waves: slice) -> Array:
        """Return E* times the contribution of the coatings to `kernels.strip`; same arguments.

        Notes
        -----
        For a wave q the contribution is the transform across the strip of F over the wave number,
        ``∫ F(κ h₁)/κ cos(k y) dk`` with κ² = q² + k², over the pixel; for a uniform line load,
        ``-F(0)/2 ln((y² + h₁²)/(d² + h₁²)) + D(y/h₁) - D(d/h₁)`` with the datum d. If every
        deformable body is on a rigid base, displacement has a natural zero, and d cancels.
        """
        (ny, nx), (dy, dx) = shape, pixel
        q: Array = 2 * math.pi * np.arange(nx // 2 + 1, dtype=np.float64)[waves] / (nx * dx)
        added = np.zeros((ny, q.size))
        first = int(np.count_nonzero(q == 0))
        if first:
            added[:, 0] = self._below_line(ny, dy, datum)
        while first < q.size:
            last = int(np.searchsorted(q, 2 * q[first]))
            added[:, first:last] = self._row_response(ny, dy, q[first:last])
            first = last
        return added * (2 / math.pi)

    def _below_line(self, offsets: int, width: float, datum: float) -> Array:
        """Return the contribution under a uniform line load, summed over the bodies [m]."""
        added = np.zeros(offsets)
        for body, share in zip(self.bodies, self.shares, strict=True):
            thickness = body.coating[0].thickness
            reach = max(datum, (offsets + 1) * width) / thickness
            table = tabulate(body, math.ceil(math.asinh(reach)) + 1, line=True)
            w, far = width / thickness, datum / thickness
            rest = _row_means(table, offsets, w)
            zero = 0.0
            if not self.grounded:
                rest -= _lookup(table.kernel, np.array(far))
                zero = 1.0
            edges = w * (np.arange(offsets + 1.0) - 0.5)
            logs = edges * np.log(edges**2 + 1) - 2 * edges + 2 * np.arctan(edges)
            logs = np.diff(logs) / w - math.log(far**2 + zero)
            added += share * width * (rest - _base_softness(body) / 2 * logs)
        return added

    def _row_response(self, offsets: int, width: float, waves: Array) -> Array:
        """Return π E*/2 times the contribution under waves along rows, at offsets from 0 [m²]."""
        # The period of the sum over waves is so long that the images have decayed.
        far = offsets + math.ceil(_DEAD / (waves[0] * width))
        half = fft.fast_length(max(offsets, far // 2 + 1))
        k = math.pi / (half * width) * np.arange(half + 1.0)[:, None]
        symbol = self._over_wave(k, waves) * width * np.sinc(k * width / (2 * math.pi))
        # Waves that the pixels alias; their signs alternate.
        folded = np.zeros_like(symbol)
        thinnest = min(body.coating[0].thickness for body in self.bodies)
        for turn, weight in enumerate(_alternating_weights(_TERMS), 1):
            if (2 * turn - 1) * math.pi * thinnest > _DEAD / 2 * width:
                break
            for side in (-1, 1):
                short = k + side * turn * 2 * math.pi / width
                folded -= weight * self._over_wave(short, waves) / short
        symbol += 2 * np.sin(k * width / 2) * folded
        fft.half_line_transform(symbol, odd=False)
        return symbol[:offsets] * (math.pi / (2 * half * width))

    def _over_wave(self, across: Array, along: Array) -> Array:
        """Return F over the wave number of waves across and along a strip."""
        waves = np.hypot(across, along)
        return (self.factor(waves) - 1) / waves


@lru_cache(maxsize=16)
def _interpolant(material: Coated, lowest: int) -> tuple[Array, Array]:
    """Return ln H from an exponent up, and ln(1 + F) at these values."""
    known = np.linspace(lowest, _DEEPEST, (_DEEPEST - lowest) * _WAVES + 1)
    return known, np.log1p(layer_excess(material, np.exp(known)))


def _row_means(table: Table, offsets: int, width: float) -> Array:
    """Return the means of D over pixels of a profile at consecutive offsets from 0."""
    places, shift = width * np.arange(offsets, dtype=float), width / math.sqrt(12)
    means = _lookup(table.kernel, np.abs(places - shift)) + _lookup(table.kernel, places + shift)
    means /= 2
    near = min(offsets, _NEAR)
    if width > _MAX_PIXEL_SHARE:
        edges = width * (np.arange(near + 1.0) - 0.5)
        means[:near] = np.diff(np.sign(edges) * _lookup(table.corner, np.abs(edges))) / width
    return means


def _alternating_weights(terms: int) -> list[float]:
    """Return weights of the first terms of an alternating series for the sum of all terms.

    Cohen, Rodriguez Villegas and Zagier, Exp. Math. 9 (2000) 3: an error of 5.8 to the -terms.
    """
    scale = math.cosh(terms * math.acosh(3))
    weights, b, c = [], -1.0, -scale
    for k in range(terms):
        c = b - c
        weights.append(c / scale)
        b *= (k + terms) * (k - terms) / ((k + 0.5) * (k + 1))
    return weights
