"""The decaying waves that layers of plastic strain send through a half-space: up, back and down.

For one wave vector q of the plane, axes 1 along it, 2 across it, 3 = z into the body. The strain
of a layer has the components zz, (11 - 22)/2 = p, 12, 13 and 23, the last two times i: then every
coefficient is real. Three kinds of waves run up and three run down, of amplitudes α, β, γ, all of
them decaying on their way; what is kept of them is ::

    a = 4(1-ν) q (α - (3-4ν) β)      b = 4(1-ν) q β      g = i q γ

Of a layer of thickness h, with x = qh, only these enter::

    decay d = e^-x    mean m = (1 - d)/x    weight w = m - d
    pull x m = 1 - d  tail x w = 1 - (1 + x) e^-x

Every step below writes into named arrays of the thread, and each of its lines is one pass over
them: fresh memory would cost more than the arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Pair = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class Body:
    """What a half-space of layers is made of.

    Parameters
    ----------
    thickness : ndarray, shape (nz,)
        Thickness of each layer [m], from the surface down; elastic below.
    shear_modulus, poisson : float
        μ [Pa] and ν.
    """

    thickness: NDArray[np.float64]
    shear_modulus: float
    poisson: float


@dataclass(frozen=True, eq=False)
class Band:
    """Wave vectors that are swept together.

    Parameters
    ----------
    angles : ndarray, shape (4, ...)
        cos θ, sin θ, cos 2θ, sin 2θ of the wave vectors.
    q : ndarray
        Their lengths [1/m].
    decay, mean : ndarray, shape (nz, ...)
        e^-x and its mean over each layer.
    """

    angles: Array
    q: Array
    decay: Array
    mean: Array


class Sweep:
    """The waves of one band on their way through the layers.

    Parameters
    ----------
    body : Body
        The layers.
    band : Band
        The wave vectors.
    spectra : ndarray, shape (nz, 5, 2, ...)
        Strain of the layers in the axes of the map, real and imaginary part; `down` leaves the
        deviator of the stress there.
    array : callable
        ``array(name, shape)`` returns memory of this thread.
    """

    def __init__(
        self,
        body: Body,
        band: Band,
        spectra: Array,
        array: Callable[[str, tuple[int, ...]], Array],
    ) -> None:
        self._body, self._band, self._spectra = body, band, spectra
        shape = (2, *band.q.shape)
        # The waves that arrive at a layer; what a layer adds to its stress; scratch.
        (
            self._a, self._b, self._g,
            self._thrust, self._bend, self._shear12, self._shear13, self._shear23,
            self._first, self._second, self._third, self._temp,
        ) = array("sweep", (12, *shape))  # fmt: skip
        # The waves that come up to each layer from below.
        self._risen = array("up", (body.thickness.size, 3, *shape))
        self._x, self._weight, self._pull, self._tail = array("weights", (4, *shape[1:]))

    def up(self) -> None:
        """Sweep from the bottom to the top; turn the strain into the axes of its wave vector."""
        cosine, sine, cosine2, sine2 = self._band.angles
        self._a[...] = self._b[...] = self._g[...] = 0
        for layer in range(self._body.thickness.size - 1, -1, -1):
            _, half, xy, xz, yz = self._spectra[layer]
            self._rotate((half, xy), (half, xy), cosine2, sine2)
            self._rotate((xz, yz), (xz, yz), cosine, sine)
            risen = self._risen[layer]
            risen[0], risen[1], risen[2] = self._a, self._b, self._g
            self._weigh(layer)
            self._propagate(layer, upwards=True)

    def reflect(self, surface: Array | None) -> None:
        """Throw back what arrives at the surface, and write the displacement that it causes.

        The free surface moves by (a + (1-2ν) b)/q and sends down ::

            a' = -(3-4ν) a - 4(1-ν)(1-2ν) b      b' = (3-4ν) b + 2a      g' = g
        """
        nu, q, x = self._body.poisson, self._band.q, self._x
        a, b, first, temp = self._a, self._b, self._first, self._temp
        np.multiply(b, 1 - 2 * nu, out=temp)
        np.add(temp, a, out=temp)
        with np.errstate(divide="ignore"):
            np.divide(1, q, out=x)
        x[q == 0] = 0
        np.multiply(temp, x, out=temp)
        if surface is not None:
            surface.real, surface.imag = temp[0], temp[1]
        np.multiply(a, 2, out=temp)
        np.multiply(a, -(3 - 4 * nu), out=a)
        np.multiply(b, -4 * (1 - nu) * (1 - 2 * nu), out=first)
        np.add(a, first, out=a)
        np.multiply(b, 3 - 4 * nu, out=b)
        np.add(b, temp, out=b)

    def down(self, trace: Array | None) -> None:
        """Sweep from the top to the bottom and leave the stress in place of the strain.

        Parameters
        ----------
        trace : ndarray, shape (nz, 2, ...), optional
            Where to write the mean stress.
        """
        cosine, sine, cosine2, sine2 = self._band.angles
        for layer in range(self._body.thickness.size):
            _, half, xy, xz, yz = self._spectra[layer]
            self._weigh(layer)
            self._press(layer)
            self._shear(layer)
            self._propagate(layer, upwards=False)
            if trace is not None:
                self._write_mean(layer, trace[layer])
            self._write_normal(layer)
            self._rotate((half, xy), (self._bend, self._shear12), cosine2, sine2, back=True)
            self._rotate((xz, yz), (self._shear13, self._shear23), cosine, sine, back=True)

    def _rotate(
        self, into: Pair, these: Pair, cosine: Array, sine: Array, *, back: bool = False
    ) -> None:
        """Turn a pair of components (f, h) by an angle: (c f + s h, c h - s f), or back."""
        first, second, third, temp = self._first, self._second, self._third, self._temp
        np.multiply(cosine, these[0], out=first)
        np.multiply(sine, these[1], out=temp)
        np.multiply(cosine, these[1], out=second)
        np.multiply(sine, these[0], out=third)
        if back:
            np.subtract(first, temp, out=into[0])
            np.add(second, third, out=into[1])
        else:
            np.add(first, temp, out=into[0])
            np.subtract(second, third, out=into[1])

    def _weigh(self, layer: int) -> None:
        """Work out x, weight, pull and tail of a layer."""
        decay, mean, x = self._band.decay[layer], self._band.mean[layer], self._x
        np.multiply(self._band.q, x.dtype.type(self._body.thickness[layer]), out=x)
        np.subtract(mean, decay, out=self._weight)
        np.multiply(x, mean, out=self._pull)
        np.multiply(x, self._weight, out=self._tail)

    def _propagate(self, layer: int, *, upwards: bool) -> None:
        """Carry the waves through a layer and add what the layer sends on.

        Upper signs upwards, with the push r = 3/2 zz - p ± 2·13::

            a' = (a - x b) d - (2-4ν)(zz ± 13) pull - r tail
            b' = b d + r pull
            g' = g d + (12 ∓ 23) pull
        """
        nu, pull, decay = self._body.poisson, self._pull, self._band.decay[layer]
        a, b, g, first, temp = self._a, self._b, self._g, self._first, self._temp
        zz, p, in_plane, shear, cross = self._spectra[layer]
        with_sign, against_sign = (np.add, np.subtract) if upwards else (np.subtract, np.add)
        np.multiply(self._x, b, out=temp)
        np.subtract(a, temp, out=a)
        for state in (a, b, g):
            np.multiply(state, decay, out=state)
        with_sign(zz, shear, out=temp)
        np.multiply(temp, -(2 - 4 * nu), out=temp)
        np.multiply(temp, pull, out=temp)
        np.add(a, temp, out=a)
        push = temp
        np.multiply(zz, 1.5, out=push)
        np.subtract(push, p, out=push)
        with_sign(push, shear, out=push)
        with_sign(push, shear, out=push)
        np.multiply(push, self._tail, out=first)
        np.subtract(a, first, out=a)
        np.multiply(push, pull, out=push)
        np.add(b, push, out=b)
        against_sign(in_plane, cross, out=temp)
        np.multiply(temp, pull, out=temp)
        np.add(g, temp, out=g)

    def _press(self, layer: int) -> None:
        """Work out what the waves through a layer and its own strain press, averaged over it.

        With the sums a, b of the waves from above and from below::

            thrust = m (b - 3 zz + 2p)
            bend = w (b - 3 zz + 2p) - m (a + (7-8ν) zz - 2p)
        """
        nu, mean, temp = self._body.poisson, self._band.mean[layer], self._temp
        zz, p, bend, both = (
            self._spectra[layer, 0],
            self._spectra[layer, 1],
            self._bend,
            self._first,
        )
        a_risen, b_risen, _ = self._risen[layer]
        np.add(self._b, b_risen, out=both)
        np.multiply(zz, 3, out=temp)
        np.subtract(both, temp, out=both)
        np.add(both, p, out=both)
        np.add(both, p, out=both)
        np.multiply(mean, both, out=self._thrust)
        np.multiply(self._weight, both, out=bend)
        np.add(self._a, a_risen, out=both)
        np.multiply(zz, 7 - 8 * nu, out=temp)
        np.add(both, temp, out=both)
        np.subtract(both, p, out=both)
        np.subtract(both, p, out=both)
        np.multiply(mean, both, out=both)
        np.subtract(bend, both, out=bend)

    def _shear(self, layer: int) -> None:
        """Work out the shear stresses, averaged over a layer.

        With the sum (Σ) and the difference (Δ) of the waves from above and from below::

            σ₁₃ = μ/(2(1-ν)) [m ((2-2ν) Δb + Δa) - w (Δb + 4·13)]
            σ₂₃ = -μ [m (Δg - 2·23) + 2·23]
            σ₁₂ = μ m (Σg - 2·12)

        the first two of them times i, as the strain is.
        """
        mu, nu, mean = self._body.shear_modulus, self._body.poisson, self._band.mean[layer]
        _, _, in_plane, shear, cross = self._spectra[layer]
        a_risen, b_risen, g_risen = self._risen[layer]
        temp, along, across, flat = self._temp, self._shear13, self._shear23, self._shear12
        bent = self._first
        np.subtract(self._b, b_risen, out=bent)
        np.multiply(bent, 2 - 2 * nu, out=along)
        np.subtract(self._a, a_risen, out=temp)
        np.add(along, temp, out=along)
        np.multiply(along, mean, out=along)
        np.multiply(shear, 4, out=temp)
        np.add(bent, temp, out=bent)
        np.multiply(bent, self._weight, out=bent)
        np.subtract(along, bent, out=along)
        np.multiply(along, mu / (2 * (1 - nu)), out=along)
        np.subtract(self._g, g_risen, out=across)
        np.subtract(across, cross, out=across)
        np.subtract(across, cross, out=across)
        np.multiply(across, mean, out=across)
        np.add(across, cross, out=across)
        np.add(across, cross, out=across)
        np.multiply(across, -mu, out=across)
        np.add(self._g, g_risen, out=flat)
        np.subtract(flat, in_plane, out=flat)
        np.subtract(flat, in_plane, out=flat)
        np.multiply(flat, mean, out=flat)
        np.multiply(flat, mu, out=flat)

    def _write_mean(self, layer: int, out: Array) -> None:
        """Write the mean stress of a layer, -μ (1+ν)/(3(1-ν)) (thrust + zz - 2p)."""
        mu, nu, temp = self._body.shear_modulus, self._body.poisson, self._temp
        zz, p, *_ = self._spectra[layer]
        np.subtract(self._thrust, p, out=temp)
        np.subtract(temp, p, out=temp)
        np.add(temp, zz, out=temp)
        np.multiply(temp, -2 * (1 + nu) / 3 * (mu / (2 * (1 - nu))), out=out)

    def _write_normal(self, layer: int) -> None:
        """Write the deviator zz of a layer, and (11 - 22)/2 in place of its bend.

        Over μ/(2(1-ν))::

            s_zz = -(10-8ν)/3 zz - 4/3 (1-2ν) p - bend + ((1-2ν) + 2/3 (1+ν)) thrust
            (s₁₁ - s₂₂)/2 = -(1-2ν) zz - 2p + (bend - (3-4ν) thrust)/2
        """
        nu, thrust, bend = self._body.poisson, self._thrust, self._bend
        unit = self._body.shear_modulus / (2 * (1 - nu))
        zz, p, *_ = self._spectra[layer]
        first, second, third = self._first, self._second, self._third
        np.multiply(zz, -(10 - 8 * nu) / 3, out=first)
        np.multiply(p, -4 / 3 * (1 - 2 * nu), out=second)
        np.add(first, second, out=first)
        np.multiply(zz, -(1 - 2 * nu), out=second)
        np.subtract(second, p, out=second)
        np.subtract(second, p, out=second)
        np.subtract(first, bend, out=first)
        np.multiply(thrust, (1 - 2 * nu) + 2 / 3 * (1 + nu), out=third)
        np.add(first, third, out=first)
        np.multiply(first, unit, out=zz)
        np.multiply(thrust, 3 - 4 * nu, out=third)
        np.subtract(bend, third, out=bend)
        np.multiply(bend, 0.5, out=bend)
        np.add(second, bend, out=second)
        np.multiply(second, unit, out=bend)
