"""Response of a laterally periodic half-space to plastic strain and pressure.

Fourier in the plane, analytic in depth. A layer of plastic strain sends three kinds of decaying
waves up and three down. One sweep from the bottom to the top collects the waves that arrive at the
surface, the free surface reflects them, and a sweep back down gives the stress; the stress by
pressure is tabulated and added. Strain is constant and stress is averaged over the thickness of
each layer, so the discrete operators are exact restrictions of one quadratic form: the stress
operator S is symmetric with 0 ≤ -S ≤ 2μ, and the displacement by strain is the adjoint of the
stress by pressure (Betti). Time and memory grow linearly with the number of layers, independent of
their thickness.

Axes: z points into the body and is 0 at its surface, pressure is positive and pushes along z,
displacement is positive into the body. Strain and the deviator of the stress have the five
components of `tensors`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Pixel, Shape
from roughcontact.errors import require_positive
from roughcontact.halfspace import fft

Array = NDArray[Any]
Pair = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class LayerStack:
    """Layers and elastic constants of a half-space.

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
    """Wave vectors of one sweep.

    Parameters
    ----------
    angles : ndarray, shape (4, ...)
        cos θ, sin θ, cos 2θ, sin 2θ of the wave vectors.
    q : ndarray
        Wave numbers [1/m].
    decay, mean : ndarray, shape (nz, ...)
        e^-x and its mean over each layer.
    """

    angles: Array
    q: Array
    decay: Array
    mean: Array


class Sweep:
    """Sweep of the waves of one band through the layers.

    Parameters
    ----------
    body : LayerStack
        The layers.
    band : Band
        The wave vectors.
    spectra : ndarray, shape (nz, 5, 2, ...)
        Strain of the layers in the axes of the map, real and imaginary part; `sweep_down` writes
        the deviator of the stress there.
    array : callable
        ``array(name, shape)`` returns memory of this thread.
    """

    def __init__(
        self,
        body: LayerStack,
        band: Band,
        spectra: Array,
        array: Callable[[str, tuple[int, ...]], Array],
    ) -> None:
        self._body, self._band, self._spectra = body, band, spectra
        shape, nz = (2, *band.q.shape), body.thickness.size
        # Layers are handled in groups, except for the waves: with a call for each layer, threads
        # would wait for the interpreter.
        step = min(nz, max(1, 2 * SWEEP_POINTS // band.q.size))
        self._parts = [slice(top, min(top + step, nz)) for top in range(0, nz, step)]
        self._state, self._temp = array("state", (3, *shape)), array("temp", shape)
        # Waves that arrive at each layer from below, and at the layers of one group from above.
        self._risen = array("up", (nz, 3, *shape))
        self._fallen = array("down", (step, 3, *shape))
        # Contributions of the layers to the waves and to the stress; work memory.
        self._memory = array("sweep", (9, step, *shape))
        self._weights = array("weights", (4, step, *shape[1:]))

    def sweep_up(self) -> None:
        """Rotate the strain to the axes of its wave vectors, and sweep from bottom to top."""
        cosine, sine, cosine2, sine2 = self._band.angles
        self._state[...] = 0
        for part in reversed(self._parts):
            _, half, xy, xz, yz = self._strain(part)
            self._rotate((half, xy), (half, xy), cosine2, sine2)
            self._rotate((xz, yz), (xz, yz), cosine, sine)
            self._layer_weights(part)
            self._layer_sources(part, upwards=True)
            for layer in range(part.stop - 1, part.start - 1, -1):
                self._risen[layer] = self._state
                self._propagate(layer, layer - part.start)

    def reflect_at_surface(self, surface: Array | None) -> None:
        """Reflect the waves at the surface, and write the displacement that they cause.

        The free surface is displaced by (a + (1-2ν) b)/q and reflects ::

            a' = -(3-4ν) a - 4(1-ν)(1-2ν) b      b' = (3-4ν) b + 2a      g' = g
        """
        nu, q, x = self._body.poisson, self._band.q, self._weights[0, 0]
        (a, b, _), first, temp = self._state, self._memory[0, 0], self._temp
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

    def sweep_down(self, trace: Array | None) -> None:
        """Sweep from top to bottom, and replace the strain by the deviator of the stress.

        Parameters
        ----------
        trace : ndarray, shape (nz, 2, ...), optional
            Array to fill with the mean stress.
        """
        cosine, sine, cosine2, sine2 = self._band.angles
        for part in self._parts:
            self._layer_weights(part)
            self._layer_sources(part, upwards=False)
            for number, layer in enumerate(range(part.start, part.stop)):
                self._fallen[number] = self._state
                self._propagate(layer, number)
            self._layer_thrust(part)
            self._layer_shear(part)
            if trace is not None:
                self._write_mean(part, trace[part])
            self._write_normal(part)
            _, half, xy, xz, yz = self._strain(part)
            _, bend, shear12, shear13, shear23 = self._stress(part)
            self._rotate((half, xy), (bend, shear12), cosine2, sine2, back=True)
            self._rotate((xz, yz), (shear13, shear23), cosine, sine, back=True)

    def _strain(self, part: slice) -> Array:
        """Return the strain components of some layers, each of shape (layers, 2, ...)."""
        return self._spectra[part].swapaxes(0, 1)

    def _scratch(self, part: slice) -> Array:
        """Return memory for some layers."""
        return self._memory[:4, : part.stop - part.start]

    def _stress(self, part: slice) -> Array:
        """Return the arrays of the thrust, the bend, and the shear stresses 12, 13 and 23."""
        return self._memory[4:, : part.stop - part.start]

    def _waves(self, part: slice) -> tuple[Array, Array]:
        """Return the waves a, b, g that arrive at some layers from above, and from below."""
        fallen = self._fallen[: part.stop - part.start]
        return fallen.swapaxes(0, 1), self._risen[part].swapaxes(0, 1)

    def _tables(self, part: slice) -> tuple[Array, ...]:
        """Return decay, mean, x, weight, pull and tail of some layers."""
        weights = self._weights[:, : part.stop - part.start, None]
        return self._band.decay[part, None], self._band.mean[part, None], *weights

    def _rotate(
        self, into: Pair, these: Pair, cosine: Array, sine: Array, *, back: bool = False
    ) -> None:
        """Rotate a pair of components (f, h) by an angle: (c f + s h, c h - s f), or back."""
        first, second, third, temp = self._memory[:4, : these[0].shape[0]]
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

    def _layer_weights(self, part: slice) -> None:
        """Compute x, weight, pull and tail of some layers."""
        decay, mean, x, weight, pull, tail = (table[:, 0] for table in self._tables(part))
        thickness = self._body.thickness[part].astype(x.dtype)
        np.multiply(self._band.q, thickness.reshape(-1, *[1] * self._band.q.ndim), out=x)
        np.subtract(mean, decay, out=weight)
        np.multiply(x, mean, out=pull)
        np.multiply(x, weight, out=tail)

    def _layer_sources(self, part: slice, *, upwards: bool) -> None:
        """Compute the contributions of some layers to the waves.

        Upper signs for the sweep up, with the push r = 3/2 zz - p ± 2·13::

            a' = (a - x b) d - (2-4ν)(zz ± 13) pull - r tail
            b' = b d + r pull
            g' = g d + (12 ∓ 23) pull
        """
        nu = self._body.poisson
        zz, p, in_plane, shear, cross = self._strain(part)
        _, _, _, _, pull, tail = self._tables(part)
        near, far, push, turn = self._scratch(part)
        with_sign, against_sign = (np.add, np.subtract) if upwards else (np.subtract, np.add)
        with_sign(zz, shear, out=near)
        np.multiply(near, -(2 - 4 * nu), out=near)
        np.multiply(near, pull, out=near)
        np.multiply(zz, 1.5, out=push)
        np.subtract(push, p, out=push)
        with_sign(push, shear, out=push)
        with_sign(push, shear, out=push)
        np.multiply(push, tail, out=far)
        np.multiply(push, pull, out=push)
        against_sign(in_plane, cross, out=turn)
        np.multiply(turn, pull, out=turn)

    def _propagate(self, layer: int, number: int) -> None:
        """Propagate the waves through a layer, ``number`` in its group; see `_layer_sources`."""
        (a, b, g), temp = self._state, self._temp
        near, far, push, turn = self._memory[:4, number]
        np.multiply(self._weights[0, number], b, out=temp)
        np.subtract(a, temp, out=a)
        np.multiply(self._state, self._band.decay[layer], out=self._state)
        np.add(a, near, out=a)
        np.subtract(a, far, out=a)
        np.add(b, push, out=b)
        np.add(g, turn, out=g)

    def _layer_thrust(self, part: slice) -> None:
        """Compute thrust and bend by the waves and the local strain, averaged over each layer.

        With the sums a, b of the waves from above and from below::

            thrust = m (b - 3 zz + 2p)
            bend = w (b - 3 zz + 2p) - m (a + (7-8ν) zz - 2p)
        """
        zz, p, *_ = self._strain(part)
        _, mean, _, weight, _, _ = self._tables(part)
        nu, (both, temp, *_) = self._body.poisson, self._scratch(part)
        thrust, bend, *_ = self._stress(part)
        (a, b, _), (a_risen, b_risen, _) = self._waves(part)
        np.add(b, b_risen, out=both)
        np.multiply(zz, 3, out=temp)
        np.subtract(both, temp, out=both)
        np.add(both, p, out=both)
        np.add(both, p, out=both)
        np.multiply(mean, both, out=thrust)
        np.multiply(weight, both, out=bend)
        np.add(a, a_risen, out=both)
        np.multiply(zz, 7 - 8 * nu, out=temp)
        np.add(both, temp, out=both)
        np.subtract(both, p, out=both)
        np.subtract(both, p, out=both)
        np.multiply(mean, both, out=both)
        np.subtract(bend, both, out=bend)

    def _layer_shear(self, part: slice) -> None:
        """Compute the shear stresses, averaged over each layer.

        With the sum (Σ) and the difference (Δ) of the waves from above and from below::

            σ₁₃ = μ/(2(1-ν)) [m ((2-2ν) Δb + Δa) - w (Δb + 4·13)]
            σ₂₃ = -μ [m (Δg - 2·23) + 2·23]
            σ₁₂ = μ m (Σg - 2·12)

        the first two times i, like the strain.
        """
        mu, nu = self._body.shear_modulus, self._body.poisson
        _, _, in_plane, shear, cross = self._strain(part)
        _, mean, _, weight, _, _ = self._tables(part)
        bent, temp, *_ = self._scratch(part)
        _, _, flat, along, across = self._stress(part)
        (a, b, g), (a_risen, b_risen, g_risen) = self._waves(part)
        np.subtract(b, b_risen, out=bent)
        np.multiply(bent, 2 - 2 * nu, out=along)
        np.subtract(a, a_risen, out=temp)
        np.add(along, temp, out=along)
        np.multiply(along, mean, out=along)
        np.multiply(shear, 4, out=temp)
        np.add(bent, temp, out=bent)
        np.multiply(bent, weight, out=bent)
        np.subtract(along, bent, out=along)
        np.multiply(along, mu / (2 * (1 - nu)), out=along)
        np.subtract(g, g_risen, out=across)
        np.subtract(across, cross, out=across)
        np.subtract(across, cross, out=across)
        np.multiply(across, mean, out=across)
        np.add(across, cross, out=across)
        np.add(across, cross, out=across)
        np.multiply(across, -mu, out=across)
        np.add(g, g_risen, out=flat)
        np.subtract(flat, in_plane, out=flat)
        np.subtract(flat, in_plane, out=flat)
        np.multiply(flat, mean, out=flat)
        np.multiply(flat, mu, out=flat)

    def _write_mean(self, part: slice, out: Array) -> None:
        """Write the mean stress of some layers, -μ (1+ν)/(3(1-ν)) (thrust + zz - 2p)."""
        mu, nu, temp = self._body.shear_modulus, self._body.poisson, self._scratch(part)[0]
        zz, p, *_ = self._strain(part)
        np.subtract(self._stress(part)[0], p, out=temp)
        np.subtract(temp, p, out=temp)
        np.add(temp, zz, out=temp)
        np.multiply(temp, -2 * (1 + nu) / 3 * (mu / (2 * (1 - nu))), out=out)

    def _write_normal(self, part: slice) -> None:
        """Write the deviator zz of some layers, and replace their bend by (11 - 22)/2.

        In units of μ/(2(1-ν))::

            s_zz = -(10-8ν)/3 zz - 4/3 (1-2ν) p - bend + ((1-2ν) + 2/3 (1+ν)) thrust
            (s₁₁ - s₂₂)/2 = -(1-2ν) zz - 2p + (bend - (3-4ν) thrust)/2
        """
        nu, (thrust, bend, *_) = self._body.poisson, self._stress(part)
        unit = self._body.shear_modulus / (2 * (1 - nu))
        zz, p, *_ = self._strain(part)
        first, second, third, _ = self._scratch(part)
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


Fill = Callable[[int, Array], slice | None]
Visit = Callable[[int, Array], None]

Pull = tuple[float, float]

NO_PULL: Pull = (0.0, 0.0)
"""No traction."""

# Large enough to hide the cost of a call, small enough to keep the data of one layer in a
# second-level cache.
SWEEP_POINTS = 16384
"""Maximum number of wave vectors that one thread sweeps at a time."""

MIN_SWEEP_POINTS = 2048
"""Minimum number of wave vectors that one thread sweeps at a time: fewer take the same time."""

# Short waves are damped in the coarse operators: their response jumps at the Nyquist frequency, so
# that periods of different length differ by tails that alternate from cell to cell. These tails do
# not cancel, and would make the operator indefinite.
_DECAY_LIMIT = 6.0


def graded_layers(first: float, depth: float, ratio: float = 1.1) -> NDArray[np.float64]:
    """Return the thicknesses of layers that grow with depth.

    Parameters
    ----------
    first : float
        Thickness of the layer at the surface [m].
    depth : float
        Minimum depth of the lowest layer [m].
    ratio : float
        Ratio of the thickness of each layer to the layer above.

    Returns
    -------
    ndarray, shape (nz,)
        Thicknesses [m].

    Examples
    --------
    >>> graded_layers(1.0, 3.0, ratio=2.0).tolist()
    [1.0, 2.0]
    """
    require_positive(first=first, depth=depth, ratio=ratio)
    layers = [first]
    while sum(layers) < depth:
        layers.append(layers[-1] * ratio)
    return np.array(layers)


class PeriodicHalfSpace:
    """Operators of a laterally periodic half-space on one grid.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` that carry strain and pressure.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    thickness : ndarray, shape (nz,)
        Thickness of each layer [m], from the surface down; elastic below.
    shear_modulus, poisson : float
        μ [Pa] and ν.
    padded : (int, int)
        Points ``(my, mx)`` of one period.
    isolated : bool
        Whether the period represents an infinite surface; see Notes.
    workspace : Workspace
        Threads.
    precision : {"double", "single"}
        Arithmetic of transforms and sweeps.
    smooth : bool
        Whether short waves are damped, from half the Nyquist frequency up.

    Notes
    -----
    The wave of infinite length: the plane has no mean strain, so the mean stress by plastic
    strain is local, s = -2μ/(1-ν) [e₁₁ + ν e₂₂, e₂₂ + ν e₁₁] and -2μ e₁₂. Pressure p gives
    σ_zz = -p and, isolated, σ_xx = σ_yy = -p (1 + 2ν)/2, the mean of the limit over all
    directions; periodic, -p ν/(1 - ν), no mean strain in the plane. The mean displacement by
    strain is the adjoint of this stress. Waves at the Nyquist frequency have two mirrored
    directions that the grid cannot distinguish; they get the mean of both operators. At the corner
    of the spectrum, Nyquist along both axes, s = -2μ e and the surface is not displaced.
    """

    def __init__(
        self,
        shape: Shape,
        pixel: Pixel,
        thickness: NDArray[np.float64],
        shear_modulus: float,
        poisson: float,
        padded: Shape,
        *,
        isolated: bool,
        workspace: fft.Workspace,
        precision: str = "double",
        smooth: bool = False,
    ) -> None:
        self.shape, self.thickness, self.padded = shape, thickness, padded
        self.real: type = np.float32 if precision == "single" else np.float64
        self._complex: type = np.complex64 if precision == "single" else np.complex128
        self.body, self._isolated = LayerStack(thickness, shear_modulus, poisson), isolated
        self._workspace = workspace
        self._quiet = True
        (my, mx), (dy, dx) = padded, pixel
        self._half, self._width = my // 2 + 1, mx // 2 + 1
        # Whether there are waves at Nyquist along x.
        self._has_shortest = mx % 2 == 0
        qy = 2 * math.pi * fft.frequencies(my, dy)[:, None]
        qx = 2 * math.pi * fft.half_frequencies(mx, dx)
        q = np.hypot(qy, qx)
        q[0, 0] = 1
        cosine, sine = qx / q, qy / q
        cosine[0, 0] = 1
        # cos θ, sin θ, cos 2θ, sin 2θ of the wave vector
        self._angles = np.stack(
            [cosine, sine, cosine**2 - sine**2, 2 * cosine * sine], dtype=self.real
        )
        q[0, 0] = 0
        # Mirrored waves at Nyquist: components with opposite signs have a mean of zero.
        self._turns = self._angles.copy()
        if self._has_shortest:
            self._turns[[0, 3], :, -1] = 0
        if my % 2 == 0:
            self._turns[[1, 3], my // 2] = 0
            if mx % 2 == 0:
                q[my // 2, -1] = 0
        q = q[: self._half]
        self._q = q.astype(self.real)
        self._fade: Array | None = None
        if smooth:
            from scipy.special import erfc

            waves = fft.frequencies(my), fft.half_frequencies(mx)
            fade = [erfc(_DECAY_LIMIT * (2 * np.abs(wave) - 0.5)) / 2 for wave in waves]
            self._fade = np.outer(*fade).astype(self.real)
        self._fill_tables(q)
        self._spectra = np.zeros((0, 5, 2, my, self._width), self.real)
        self._trace: Array | None = None

    def _fill_tables(self, q: NDArray[np.float64]) -> None:
        """Tabulate the factors that depend only on |q|, for the rows with qy ≥ 0."""
        nz, nu = self.thickness.size, self.body.poisson
        shape = (nz, *q.shape)
        self._decay, self._mean = np.empty(shape, self.real), np.empty(shape, self.real)
        # Deviator and mean of the stress by unit pressure: zz, (11 - 22)/2, i·13, mean.
        self._elastic = np.empty((nz, 4, *q.shape), self.real)
        top = np.append(0, np.cumsum(self.thickness))
        waves = q > 0

        def fill(layer: int) -> None:
            x = q * self.thickness[layer]
            decay = np.exp(-x)
            mean = np.ones_like(x)
            np.divide(-np.expm1(-x), x, out=mean, where=waves)
            self._decay[layer], self._mean[layer] = decay, mean
            # Averages over the layer of e^(-qz) and qz e^(-qz); 1 and 0 for the longest wave.
            flat = np.exp(-q * top[layer])
            bent = flat * (q * top[layer] * mean + (mean - decay))
            flat *= mean
            table = self._elastic[layer]
            table[0] = -flat - bent + 2 * (1 + nu) / 3 * flat
            table[1] = (bent - flat) / 2 + nu * flat
            table[2] = -bent
            table[3] = -2 * (1 + nu) / 3 * flat
            # Of the entries with q = 0, the longest wave has pressure, the corner of the spectrum
            # has none.
            first = table[:, 0, :1].copy()
            table[:, ~waves] = 0
            first[1] = first[2] = 0
            if not self._isolated:
                first[0] = -(2 - 4 * nu) / (3 * (1 - nu))
                first[3] = -(1 + nu) / (3 * (1 - nu))
            table[:, 0, :1] = first

        self._workspace.each(fill, range(nz))

    def displacement(
        self, fill: Fill, *, trace: bool = False, see: Visit | None = None
    ) -> NDArray[np.float64]:
        """Set the plastic strain and return the surface displacement that it causes.

        Parameters
        ----------
        fill : callable
            ``fill(layer, out)`` writes the strain of one layer into ``out``, shape
            ``(5, ny, nx)``, and returns the nonzero rows, or ``None`` if there are none; called
            from several threads.
        trace : bool
            Whether `mean_stress` will be called.
        see : callable, optional
            ``see(layer, strain)`` is called for each layer with strain.

        Returns
        -------
        ndarray, shape (ny, nx)
            Normal displacement [m], positive into the body, without the displacement by pressure.
        """
        nz, my = self.thickness.size, self.padded[0]
        if not self._spectra.size:
            self._spectra = np.empty((nz, 5, 2, my, self._width), self.real)
        if trace and self._trace is None:
            self._trace = np.empty((nz, 2, my, self._width), self.real)
        # Components of the waves at Nyquist whose mirrors have the opposite sign, along x then
        # along y, which are swept separately; and all components at the corner.
        self._odd: Array = np.zeros((nz, 5, 2, 1, my + self._width), self.real)
        self._corner: Array = np.zeros((nz, 5, 2), self.real)
        self._quiet = not self._transform(fill, see)
        if self._quiet:
            if self._trace is not None:
                self._trace[...] = 0
            return np.zeros(self.shape)
        mean = self._mean_displacement()
        surface = self._sweep(self._trace if trace else None)
        surface[0, 0] = mean
        return fft.from_half_spectrum(surface, self.shape, self.padded).astype(np.float64)

    def _transform(self, fill: Fill, see: Visit | None) -> bool:
        """Store the spectra of the strain of all layers; return whether any layer has strain."""
        (my, mx), (ny, nx) = self.padded, self.shape
        scale = 1 / (my * mx)

        def forward(layer: int) -> None:
            strain = self._array("strain", (5, ny, nx))
            rows = fill(layer, strain)
            if rows is None:
                self._spectra[layer] = 0
                return
            if see is not None:
                see(layer, strain)
            for component, plane in enumerate(self._spectra[layer]):
                scratch = self._array("spectrum", (my, self._width), self._complex)
                spectrum = fft.half_spectrum(strain[component], rows, self.padded, scratch)
                if self._fade is not None:
                    spectrum *= self._fade
                # Strains xz and yz are stored times i, so that every coefficient is real.
                if component < 3:
                    np.multiply(spectrum.real, scale, out=plane[0])
                    np.multiply(spectrum.imag, scale, out=plane[1])
                else:
                    np.multiply(spectrum.imag, -scale, out=plane[0])
                    np.multiply(spectrum.real, scale, out=plane[1])
            self._take_nyquist(layer)
            has_strain[layer] = True

        has_strain = np.zeros(len(self._spectra), bool)
        self._workspace.each(forward, range(len(self._spectra)))
        return bool(has_strain.any())

    def _mean_displacement(self) -> float:
        """Return the mean displacement by the strain: the adjoint of the longest wave's stress."""
        nu = self.body.poisson
        weights = -self.thickness * (0.5 - nu)
        if not self._isolated:
            weights /= 0.5 * (1 - nu)
        return float(weights @ self._spectra[:, 0, 0, 0, 0])

    def _sweep(self, trace: Array | None) -> Array:
        """Replace the strain by the stress; return the spectrum of the displacement."""
        my = self.padded[0]
        surface: Array = np.empty((my, self._width), self._complex)
        step = max(my // (2 * self._workspace.workers), MIN_SWEEP_POINTS // self._width)
        step = max(1, min(SWEEP_POINTS // self._width, step))
        # A band of rows must be on one side of the fold of the tables.
        bands = [slice(i, min(i + step, self._half)) for i in range(0, self._half, step)]
        bands += [slice(i, min(i + step, my)) for i in range(self._half, my, step)]

        def sweep(rows: slice) -> None:
            fold = rows if rows.start < self._half else slice(my - rows.start, my - rows.stop, -1)
            band = Band(
                self._angles[:, rows], self._q[fold], self._decay[:, fold], self._mean[:, fold]
            )
            waves = Sweep(self.body, band, self._spectra[..., rows, :], self._array)
            waves.sweep_up()
            waves.reflect_at_surface(surface[rows])
            waves.sweep_down(None if trace is None else trace[..., rows, :])

        self._workspace.each(sweep, bands)
        waves = Sweep(self.body, self._nyquist_waves, self._odd, self._array)
        waves.sweep_up()
        waves.reflect_at_surface(None)
        waves.sweep_down(None)
        return surface

    def _take_nyquist(self, layer: int) -> None:
        """Move components with opposite signs in mirrored waves at Nyquist to a separate sweep."""
        my = self.padded[0]
        for component, plane in enumerate(self._spectra[layer]):
            if my % 2 == 0 and self._has_shortest:
                self._corner[layer, component] = plane[:, my // 2, -1]
            odd_x, odd_y = (True, self._has_shortest, (2, 3)), (False, my % 2 == 0, (2, 4))
            for along_x, even, odd in (odd_x, odd_y):
                if even and component in odd:
                    waves = plane[..., -1] if along_x else plane[:, my // 2]
                    place = slice(0, my) if along_x else slice(my, None)
                    self._odd[layer, component, :, 0, place] = waves
                    waves[...] = 0

    @property
    def _nyquist_waves(self) -> Band:
        """Waves at Nyquist, along x then along y."""
        my = self.padded[0]
        angles = np.concatenate([self._angles[:, :, -1], self._angles[:, my // 2]], axis=1)
        fold = np.minimum(np.arange(my), my - np.arange(my))
        tables = [
            np.concatenate([table[..., fold, -1], table[..., my // 2, :]], axis=-1)[..., None, :]
            for table in (self._q, self._decay, self._mean)
        ]
        return Band(angles[:, None], *tables)

    def stress(self, pressure: Array, visit: Visit, pull: Pull = NO_PULL) -> None:
        """Pass the deviator of the stress by the current strain and a pressure to a callback.

        Parameters
        ----------
        pressure : ndarray, shape (ny, nx)
            Pressure on the surface [Pa].
        visit : callable
            ``visit(layer, stress)`` receives the layer averages, shape ``(5, ny, nx)`` [Pa], from
            one of several threads; the array is only valid during the call.
        pull : (float, float)
            Traction on the surface along x and y, per pressure.
        """
        load, loaded = self._pressure_spectrum(pressure)
        pulled = self._traction_factors(load, pull) if loaded and any(pull) else None
        cosine, sine, cosine2, sine2 = self._turns
        # Unit pressure gives zz, 11 - 22 and 13 (times i) in the frame of its wave vector.
        turned = [(0, load)]
        if loaded:
            turned += [(1, load * cosine2), (1, load * sine2), (2, load * cosine), (2, load * sine)]

        def spectrum(layer: int, component: int) -> Array:
            parts = self._array("parts", load.shape)
            if self._quiet:
                parts[...] = 0
            else:
                np.copyto(parts, self._spectra[layer, component])
                self._put_nyquist(parts, layer, component)
            if loaded:
                number, wave = turned[component]
                self._add(parts, self._elastic[layer, number], wave)
            if pulled is not None:
                for table, wave in zip(self._averages(layer), pulled[component], strict=True):
                    self._add(parts, table, wave)
            return parts

        def transform_stress(layer: int) -> None:
            stress = self._array("stress", (5, *self.shape))
            if self._quiet and not loaded:
                stress[...] = 0
            else:
                for component in range(5):
                    stress[component] = self._to_map(
                        spectrum(layer, component), times_i=component > 2
                    )
            visit(layer, stress)

        self._workspace.each(transform_stress, range(self.thickness.size))

    def mean_stress(self, pressure: Array, visit: Visit, pull: Pull = NO_PULL) -> None:
        """Pass the mean stress, a third of the trace, to a callback; see `stress`.

        The strain must have been set with ``trace=True``; arrays have shape ``(ny, nx)``.
        """
        load, loaded = self._pressure_spectrum(pressure)
        along = self._along(load, pull) if loaded and any(pull) else None

        def transform_mean(layer: int) -> None:
            parts = self._array("parts", load.shape)
            parts[...] = 0
            if not self._quiet and self._trace is not None:
                np.copyto(parts, self._trace[layer])
                if self._has_shortest and self.padded[0] % 2 == 0:
                    parts[:, self.padded[0] // 2, -1] = 0
            if loaded:
                self._add(parts, self._elastic[layer, 3], load)
            if along is not None:
                # Effect of a pressure, with the opposite sign.
                self._add(parts, -self._elastic[layer, 3], along)

            visit(layer, self._to_map(parts, times_i=False))

        self._workspace.each(transform_mean, range(self.thickness.size))

    def _along(self, load: Array, pull: Pull) -> Array:
        """Return the traction along each wave vector, times i, without the longest wave."""
        cosine, sine, _, _ = self._turns
        along: Array = _times_i(load) * (pull[0] * cosine + pull[1] * sine)
        along[:, 0, 0] = 0
        return along

    def _traction_factors(self, load: Array, pull: Pull) -> list[tuple[Array, Array]]:
        """Return the factors of the tables of `_averages`, for each component of the stress.

        A wave of traction T₁ along its vector and T₂ across it gives (Airy's function z e^(-qz))::

            zz = i T₁ (qz - 2/3 (1+ν)) e^(-qz)      13 = -T₁ (1 - qz) e^(-qz)      12 = i T₂ e^(-qz)
            (11 - 22)/2 = i T₁ (1 - ν - qz/2) e^(-qz)                             23 = -T₂ e^(-qz)
        """
        nu = self.body.poisson
        my, waves = self.padded[0], _times_i(load)
        flat: Array = np.zeros((5, *load.shape), self.real)
        bent = np.zeros_like(flat)
        cosine, sine, cosine2, sine2 = self._angles
        for axis, share in enumerate(pull):
            if not share:
                continue
            along, across = (cosine, sine) if axis == 0 else (sine, -cosine)
            of_flat = [
                -2 / 3 * (1 + nu) * along,
                (1 - nu) * cosine2 * along + sine2 * across,
                (1 - nu) * sine2 * along - cosine2 * across,
                -cosine * along - sine * across,
                -sine * along + cosine * across,
            ]
            of_bent = [
                along,
                -cosine2 * along / 2,
                -sine2 * along / 2,
                cosine * along,
                sine * along,
            ]
            # Mirrored waves at Nyquist: along the traction and across it.
            odd = [(0, 1, 4), (2, 4)] if axis == 0 else [(2, 3), (0, 1, 3)]
            for component in range(5):
                for total, part in ((flat, of_flat), (bent, of_bent)):
                    factor = share * part[component]
                    if self._has_shortest and component in odd[0]:
                        factor[:, -1] = 0
                    if my % 2 == 0 and component in odd[1]:
                        factor[my // 2] = 0
                    # Only a shear stress.
                    factor[0, 0] = -share if part is of_flat and component == 3 + axis else 0
                    total[component] += waves * factor
        flat[..., 0, 0] /= self._averages(0)[0][0, 0]
        return list(zip(flat, bent, strict=True))

    def _averages(self, layer: int) -> tuple[Array, Array]:
        """Return averages over a layer of e^(-qz) and qz e^(-qz); zero at the corner."""
        table = self._elastic[layer]
        return table[3] / self.real(-2 / 3 * (1 + self.body.poisson)), -table[2]

    def _pressure_spectrum(self, pressure: Array) -> tuple[Array, bool]:
        my, mx = self.padded
        parts: Array = np.zeros((2, my, self._width), self.real)
        if not pressure.any():
            return parts, False
        scratch: Array = np.empty((my, self._width), self._complex)
        values: Array = pressure.astype(self.real, copy=False)
        spectrum = fft.half_spectrum(values, slice(0, self.shape[0]), self.padded, scratch)
        if self._fade is not None:
            spectrum *= self._fade
        parts[0], parts[1] = spectrum.real, spectrum.imag
        parts /= my * mx
        return parts, True

    def _add(self, parts: Array, table: Array, wave: Array) -> None:
        """Add a wave times a table whose rows are mirrored at the middle."""
        half = self._half
        product = self._array("product", parts.shape)
        np.multiply(wave[:, :half], table, out=product[:, :half])
        folded = table[1 : self.padded[0] - half + 1][::-1]
        np.multiply(wave[:, half:], folded, out=product[:, half:])
        np.add(parts, product, out=parts)

    def _put_nyquist(self, parts: Array, layer: int, component: int) -> None:
        """Write the stress of the components moved by `_take_nyquist`."""
        my = self.padded[0]
        odd = self._odd[layer, component, :, 0]
        if self._has_shortest and component in (2, 3):
            parts[..., -1] = odd[:, :my]
        if my % 2 == 0 and component in (2, 4):
            parts[:, my // 2] = odd[:, my:]
        if my % 2 == 0 and self._has_shortest:
            parts[:, my // 2, -1] = self._corner[layer, component] * self.real(
                -2 * self.body.shear_modulus
            )

    def _to_map(self, parts: Array, times_i: bool) -> Array:
        spectrum = self._array("spectrum", parts.shape[1:], self._complex)
        if times_i:
            spectrum.real = parts[1]
            np.negative(parts[0], out=spectrum.imag)
        else:
            spectrum.real, spectrum.imag = parts
        return fft.from_half_spectrum(spectrum, self.shape, self.padded)

    def _array(self, name: str, shape: tuple[int, ...], dtype: type | None = None) -> Array:
        """Return memory of this thread."""
        flat = self._workspace.scratch(name, (1, math.prod(shape)), dtype or self.real)
        return flat.reshape(shape)


def _times_i(parts: Array) -> Array:
    return np.stack([-parts[1], parts[0]])
