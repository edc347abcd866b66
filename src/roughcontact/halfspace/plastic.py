"""The elastic half-space with plastic strain: strain in layers and pressure in, stress out.

Fourier in the plane, analytic in depth. A layer of plastic strain sends three kinds of decaying
waves up and three down. One sweep from the bottom to the top collects what arrives at the surface,
the free surface reflects it, and a sweep back down gives the stress; the pressure enters with the
reflection. Strain is constant and stress is averaged over the thickness of each layer, so the
discrete operators are exact restrictions of one quadratic form: the stress operator S is symmetric
with 0 ≤ -S ≤ 2μ, and the displacement by strain is the adjoint of the stress by pressure
(Betti). Time and memory grow linearly with the number of layers, whatever their thickness.

Axes: z points into the body and is 0 at its surface, pressure is positive and pushes along z,
displacement is positive into the body. A traceless tensor has five components, in this order::

    zz,  (xx - yy)/2,  xy,  xz,  yz

so that a:b = 3/2 a₀b₀ + 2 (a₁b₁ + a₂b₂ + a₃b₃ + a₄b₄).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError, require_pixel, require_positive
from roughcontact.halfspace.fft import (
    Workspace,
    fast_length,
    frequencies,
    from_half_spectrum,
    half_frequencies,
    half_spectrum,
)

Array = NDArray[Any]
Fill = Callable[[int, Array], slice | None]
Visit = Callable[[int, Array], None]

WEIGHTS = (1.5, 2.0, 2.0, 2.0, 2.0)
"""Weights of the five components in the product a:b of two traceless tensors."""

SWEEP_POINTS = 16384
"""Wave vectors that one thread sweeps at a time, at most."""
# Enough to hide the cost of a call, few enough that what one layer needs stays in a second-level
# cache.
# Periods of the three transforms of a free boundary, over the edge of the map.
_NEAR = 1.5
_FAR = 6.0
# Coarse cells along the shorter edge of the map, at most; cells beyond the map on each side, so
# that the interpolation stays central: an extrapolating one costs the operator its sign.
_COARSE = 20
_GUARD = 2
# Coarse layers over coarse cells, at least.
_COARSE_DEPTH = 0.5
# Short waves fade out of the coarse operators: the response to them jumps at the Nyquist frequency,
# so that periods of different length differ by tails that alternate from cell to cell. Those do
# not cancel, and would cost the operator its sign as well.
_FADE = 6.0


def components(tensor: Array) -> Array:
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


def tensor(deviator: Array, mean: ArrayLike = 0.0) -> Array:
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
    rows = [
        [mean - zz / 2 + half, xy, xz],
        [xy, mean - zz / 2 - half, yz],
        [xz, yz, mean + zz],
    ]
    return np.stack([np.stack(np.broadcast_arrays(*row), axis=-1) for row in rows], axis=-2)


def equivalent(deviator: Array) -> Array:
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
    root: Array = np.sqrt(square)
    return root


def graded_layers(first: float, depth: float, ratio: float = 1.1) -> NDArray[np.float64]:
    """Return thicknesses of layers that grow with depth.

    Parameters
    ----------
    first : float
        Thickness of the layer at the surface [m].
    depth : float
        Least depth of them all [m].
    ratio : float
        Thickness of each layer over that of the one above.

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


class Layers:
    """The operators of a laterally periodic half-space, on one grid.

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
        Whether the period stands for an infinite surface, see Notes.
    workspace : Workspace
        Threads.
    precision : {"double", "single"}
        Arithmetic of transforms and sweeps.
    smooth : bool
        Whether short waves are left out, fading from half the Nyquist frequency on.

    Notes
    -----
    The wave of infinite length: plastic strain finds no mean strain in the plane, so its mean
    stress is local, s = -2μ/(1-ν) [e₁₁ + ν e₂₂, e₂₂ + ν e₁₁] and -2μ e₁₂. Pressure p gives
    σ_zz = -p and, isolated, σ_xx = σ_yy = -p (1 + 2ν)/2, the mean of the limit over all
    directions; periodic, -p ν/(1 - ν), no mean strain in the plane. The mean displacement by
    strain is the adjoint of that. Waves at the Nyquist frequency run in two mirrored directions
    that the grid cannot tell apart; they get the mean of the operators of both. At the corner
    of the spectrum, Nyquist along both axes, s = -2μ e and nothing reaches the surface.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        pixel: tuple[float, float],
        thickness: NDArray[np.float64],
        shear_modulus: float,
        poisson: float,
        padded: tuple[int, int],
        *,
        isolated: bool,
        workspace: Workspace,
        precision: str = "double",
        smooth: bool = False,
    ) -> None:
        self.shape, self.thickness, self.padded = shape, thickness, padded
        self.real: type = np.float32 if precision == "single" else np.float64
        self._complex: type = np.complex64 if precision == "single" else np.complex128
        self._modulus, self._poisson, self._isolated = shear_modulus, poisson, isolated
        self._workspace = workspace
        self._quiet = True
        (my, mx), (dy, dx) = padded, pixel
        self._half, self._width = my // 2 + 1, mx // 2 + 1
        qy = 2 * math.pi * frequencies(my, dy)[:, None]
        qx = 2 * math.pi * half_frequencies(mx, dx)
        q = np.hypot(qy, qx)
        q[0, 0] = 1
        cosine, sine = qx / q, qy / q
        cosine[0, 0] = 1
        # cos θ, sin θ, cos 2θ, sin 2θ of the wave vector
        self._angles = np.stack(
            [cosine, sine, cosine**2 - sine**2, 2 * cosine * sine], dtype=self.real
        )
        q[0, 0] = 0
        # The mirrors of a wave at Nyquist: what they turn in opposite ways has no mean.
        self._turns = self._angles.copy()
        if mx % 2 == 0:
            self._turns[[0, 3], :, -1] = 0
        if my % 2 == 0:
            self._turns[[1, 3], my // 2] = 0
            if mx % 2 == 0:
                q[my // 2, -1] = 0
        self._q = q[: self._half].astype(self.real)
        self._fade: Array | None = None
        if smooth:
            from scipy.special import erfc

            waves = frequencies(my), half_frequencies(mx)
            fade = [erfc(_FADE * (2 * np.abs(wave) - 0.5)) / 2 for wave in waves]
            self._fade = np.outer(*fade).astype(self.real)
        self._fill_tables(q[: self._half])
        self._spectra = np.zeros((0, 5, 2, my, self._width), self.real)
        self._trace: Array | None = None

    def _fill_tables(self, q: NDArray[np.float64]) -> None:
        """Tabulate what depends on |q| alone, for the rows with qy ≥ 0."""
        nz, nu = self.thickness.size, self._poisson
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
            # Of those at q = 0 the longest wave has a pressure, the corner of the spectrum none.
            first = table[:, 0, 0].copy()
            table[:, ~waves] = 0
            first[1] = first[2] = 0
            if not self._isolated:
                first[0] = -(2 - 4 * nu) / (3 * (1 - nu))
                first[3] = -(1 + nu) / (3 * (1 - nu))
            table[:, 0, 0] = first

        self._workspace.each(fill, range(nz))

    def displacement(
        self, fill: Fill, *, trace: bool = False, see: Visit | None = None
    ) -> NDArray[np.float64]:
        """Take in a plastic strain and return the surface displacement that it causes.

        Parameters
        ----------
        fill : callable
            ``fill(layer, out)`` writes the strain of one layer into ``out``, shape
            ``(5, ny, nx)``, and returns the rows that are not zero, or ``None`` if none is;
            called from several threads.
        trace : bool
            Whether `mean_stress` will be asked for.
        see : callable, optional
            Called with each layer that has strain and that strain.

        Returns
        -------
        ndarray, shape (ny, nx)
            Normal displacement [m], positive into the body, without the elastic one by pressure.
        """
        (my, mx), (ny, nx), nz = self.padded, self.shape, self.thickness.size
        scale = 1 / (my * mx)
        if not self._spectra.size:
            self._spectra = np.empty((nz, 5, 2, my, self._width), self.real)
        if trace and self._trace is None:
            self._trace = np.empty((nz, 2, my, self._width), self.real)
        # Of the waves at Nyquist, the components that their mirrors have with the other sign: along
        # x then along y, kept from the sweep of the others. And all at the corner.
        self._odd: Array = np.zeros((nz, 5, 2, 1, my + self._width), self.real)
        self._corner: Array = np.zeros((nz, 5, 2), self.real)
        loud = np.zeros(nz, bool)

        def forward(layer: int) -> None:
            strain = self._array("strain", (5, ny, nx))
            rows = fill(layer, strain)
            if rows is None:
                self._spectra[layer] = 0
                return
            loud[layer] = True
            if see is not None:
                see(layer, strain)
            for component in range(5):
                scratch = self._array("spectrum", (my, self._width), self._complex)
                spectrum = half_spectrum(strain[component], rows, self.padded, scratch)
                if self._fade is not None:
                    spectrum *= self._fade
                plane = self._spectra[layer, component]
                # Strains xz and yz are kept times i: then every coefficient is real.
                if component < 3:
                    np.multiply(spectrum.real, scale, out=plane[0])
                    np.multiply(spectrum.imag, scale, out=plane[1])
                else:
                    np.multiply(spectrum.imag, -scale, out=plane[0])
                    np.multiply(spectrum.real, scale, out=plane[1])
                self._take_nyquist(plane, layer, component)

        self._workspace.each(forward, range(nz))
        self._quiet = not loud.any()
        if self._quiet:
            if self._trace is not None:
                self._trace[...] = 0
            return np.zeros(self.shape)
        weights = -self.thickness * (0.5 - self._poisson)
        if not self._isolated:
            weights /= 0.5 * (1 - self._poisson)
        mean = float(weights @ self._spectra[:, 0, 0, 0, 0])
        surface: Array = np.empty((my, self._width), self._complex)
        step = min(SWEEP_POINTS // self._width, my // (2 * self._workspace.workers))
        step = max(1, step)
        # A band of rows lies on one side of the tables' fold.
        bands = [slice(i, min(i + step, self._half)) for i in range(0, self._half, step)]
        bands += [slice(i, min(i + step, my)) for i in range(self._half, my, step)]

        def sweep(rows: slice) -> None:
            fold = rows if rows.start < self._half else slice(my - rows.start, my - rows.stop, -1)
            self._sweep(
                self._spectra[..., rows, :], self._angles[:, rows], self._q[fold],
                self._decay[:, fold], self._mean[:, fold], surface[rows],
                self._trace[..., rows, :] if trace and self._trace is not None else None,
            )  # fmt: skip

        self._workspace.each(sweep, bands)
        self._sweep(self._odd, *self._at_nyquist, None, None)
        surface[0, 0] = mean
        return from_half_spectrum(surface, self.shape, self.padded).astype(np.float64)

    def _take_nyquist(self, plane: Array, layer: int, component: int) -> None:
        """Move what mirrored waves at Nyquist have with opposite signs out of the sweep's way."""
        my, mx = self.padded
        if my % 2 == 0 and mx % 2 == 0:
            self._corner[layer, component] = plane[:, my // 2, -1]
        for along_x, even, odd in ((True, mx % 2 == 0, (2, 3)), (False, my % 2 == 0, (2, 4))):
            if even and component in odd:
                waves = plane[..., -1] if along_x else plane[:, my // 2]
                place = slice(0, my) if along_x else slice(my, None)
                self._odd[layer, component, :, 0, place] = waves
                waves[...] = 0

    @property
    def _at_nyquist(self) -> tuple[Array, Array, Array, Array]:
        """Angles, q, decay and mean of the waves at Nyquist, along x then along y."""
        my = self.padded[0]
        angles = np.concatenate([self._angles[:, :, -1], self._angles[:, my // 2]], axis=1)
        fold = np.minimum(np.arange(my), my - np.arange(my))
        tables = [
            np.concatenate([table[..., fold, -1], table[..., my // 2, :]], axis=-1)[..., None, :]
            for table in (self._q, self._decay, self._mean)
        ]
        return angles[:, None], tables[0], tables[1], tables[2]

    def _sweep(
        self,
        spectra: Array,
        angles: Array,
        q: Array,
        decays: Array,
        means: Array,
        surface: Array | None,
        trace: Array | None,
    ) -> None:
        """Sweep a band of wave vectors up and down; leave the stress in place of the strain.

        States hold 4(1-ν) q (α - (3-4ν) β), 4(1-ν) q β and i q γ of the amplitudes α, β, γ of
        the waves; e^(-x) and its mean over a layer are all that the layers' integrals need.
        """
        nu, nz = self._poisson, self.thickness.size
        cosine, sine, cosine2, sine2 = angles
        shape = (2, *q.shape)
        arrays = self._array("sweep", (12, *shape))
        first, second, third, temp, total, one, two, three, four, a, b, g = arrays
        up = self._array("up", (nz, 3, *shape))
        size = (4, *shape[1:])
        x, weight, pull, tail = self._array("weights", size)

        def rotate(into: tuple[Array, Array], these: tuple[Array, Array], c: Array, s: Array,
                   back: bool) -> None:  # fmt: skip
            """Turn a pair of components by an angle: (c f + s g, c g - s f), or back."""
            np.multiply(c, these[0], out=first)
            np.multiply(s, these[1], out=temp)
            np.multiply(c, these[1], out=second)
            np.multiply(s, these[0], out=third)
            if back:
                np.subtract(first, temp, out=into[0])
                np.add(second, third, out=into[1])
            else:
                np.add(first, temp, out=into[0])
                np.subtract(second, third, out=into[1])

        def propagate(layer: int, direction: int) -> None:
            """Carry the state through a layer and add what the layer sends on."""
            zz, p, t, shear, cross = spectra[layer]
            decay = decays[layer]
            # pull and tail: (1 - e^-x) and 1 - (1 + x) e^-x
            np.multiply(x, b, out=temp)
            np.subtract(a, temp, out=a)
            for state in (a, b, g):
                np.multiply(state, decay, out=state)
            combine = np.add if direction < 0 else np.subtract
            combine(zz, shear, out=temp)
            np.multiply(temp, -(2 - 4 * nu), out=temp)
            np.multiply(temp, pull, out=temp)
            np.add(a, temp, out=a)
            np.multiply(zz, 1.5, out=temp)
            np.subtract(temp, p, out=temp)
            combine(temp, shear, out=temp)
            combine(temp, shear, out=temp)
            np.multiply(temp, tail, out=first)
            np.subtract(a, first, out=a)
            np.multiply(temp, pull, out=temp)
            np.add(b, temp, out=b)
            (np.subtract if direction < 0 else np.add)(t, cross, out=temp)
            np.multiply(temp, pull, out=temp)
            np.add(g, temp, out=g)

        def weigh(layer: int) -> None:
            np.multiply(q, self.real(self.thickness[layer]), out=x)
            np.subtract(means[layer], decays[layer], out=weight)
            np.multiply(x, means[layer], out=pull)
            np.multiply(x, weight, out=tail)

        a[...] = b[...] = g[...] = 0
        for layer in range(nz - 1, -1, -1):
            zz, half, xy, xz, yz = spectra[layer]
            rotate((half, xy), (half, xy), cosine2, sine2, False)
            rotate((xz, yz), (xz, yz), cosine, sine, False)
            up[layer, 0], up[layer, 1], up[layer, 2] = a, b, g
            weigh(layer)
            propagate(layer, -1)

        # What comes up moves the surface and is thrown back by it.
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

        mu = self._modulus
        unit = mu / (2 * (1 - nu))
        for layer in range(nz):
            zz, p, t, shear, cross = spectra[layer]
            from_a, from_b, from_g = up[layer]
            mean = means[layer]
            weigh(layer)
            # two = mean (b↓ + b↑ - own), total = weight (same) - mean (a↓ + a↑ - own ...)
            np.add(b, from_b, out=one)
            np.multiply(zz, 3, out=temp)
            np.subtract(one, temp, out=one)
            np.add(one, p, out=one)
            np.add(one, p, out=one)
            np.multiply(mean, one, out=two)
            np.multiply(weight, one, out=total)
            np.add(a, from_a, out=one)
            np.multiply(zz, 7 - 8 * nu, out=temp)
            np.add(one, temp, out=one)
            np.subtract(one, p, out=one)
            np.subtract(one, p, out=one)
            np.multiply(mean, one, out=one)
            np.subtract(total, one, out=total)
            # Shear 13, times i: differences of the waves.
            np.subtract(b, from_b, out=one)
            np.multiply(one, 2 - 2 * nu, out=three)
            np.subtract(a, from_a, out=temp)
            np.add(three, temp, out=three)
            np.multiply(three, mean, out=three)
            np.multiply(shear, 4, out=temp)
            np.add(one, temp, out=one)
            np.multiply(one, weight, out=one)
            np.subtract(three, one, out=three)
            np.multiply(three, unit, out=three)
            # Shear 23, times i.
            np.subtract(g, from_g, out=four)
            np.subtract(four, cross, out=four)
            np.subtract(four, cross, out=four)
            np.multiply(four, mean, out=four)
            np.add(four, cross, out=four)
            np.add(four, cross, out=four)
            np.multiply(four, -mu, out=four)
            # Shear 12.
            np.add(g, from_g, out=one)
            np.subtract(one, t, out=one)
            np.subtract(one, t, out=one)
            np.multiply(one, mean, out=one)
            np.multiply(one, mu, out=one)
            propagate(layer, +1)
            if trace is not None:
                # -2 (1 + ν) (two + 3 zz - 2 p) and the local part, a third of them.
                np.subtract(two, p, out=temp)
                np.subtract(temp, p, out=temp)
                np.add(temp, zz, out=temp)
                np.multiply(temp, -2 * (1 + nu) / 3 * unit, out=trace[layer])
            # Own parts of zz and (11 - 22)/2, then the waves.
            np.multiply(zz, -(10 - 8 * nu) / 3, out=first)
            np.multiply(p, -4 / 3 * (1 - 2 * nu), out=second)
            np.add(first, second, out=first)
            np.multiply(zz, -(1 - 2 * nu), out=second)
            np.subtract(second, p, out=second)
            np.subtract(second, p, out=second)
            np.subtract(first, total, out=first)
            np.multiply(two, (1 - 2 * nu) + 2 / 3 * (1 + nu), out=third)
            np.add(first, third, out=first)
            np.multiply(first, unit, out=zz)
            np.multiply(two, 3 - 4 * nu, out=third)
            np.subtract(total, third, out=total)
            np.multiply(total, 0.5, out=total)
            np.add(second, total, out=second)
            np.multiply(second, unit, out=total)
            rotate((p, t), (total, one), cosine2, sine2, True)
            rotate((shear, cross), (three, four), cosine, sine, True)

    def stress(self, pressure: Array, visit: Visit) -> None:
        """Show the deviator of the stress by the strain taken in last and by a pressure.

        Parameters
        ----------
        pressure : ndarray, shape (ny, nx)
            Pressure on the surface [Pa].
        visit : callable
            ``visit(layer, stress)`` gets the layer averages, shape ``(5, ny, nx)`` [Pa], from one
            of several threads; the array is only valid during the call.
        """
        load, loaded = self._pressure_spectrum(pressure)
        cosine, sine, cosine2, sine2 = self._turns
        # Unit pressure gives zz, 11 - 22 and 13 (times i) in the frame of its wave vector.
        turned = [(0, load)]
        if loaded:
            turned += [(1, load * cosine2), (1, load * sine2), (2, load * cosine), (2, load * sine)]

        def backward(layer: int) -> None:
            stress = self._array("stress", (5, *self.shape))
            for component in range(5):
                parts = self._array("parts", load.shape)
                if self._quiet:
                    parts[...] = 0
                else:
                    np.copyto(parts, self._spectra[layer, component])
                    self._put_nyquist(parts, layer, component)
                if loaded:
                    number, wave = turned[component]
                    self._add(parts, self._elastic[layer, number], wave)
                if self._quiet and not loaded:
                    stress[component] = 0
                else:
                    stress[component] = self._to_map(parts, times_i=component > 2)
            visit(layer, stress)

        self._workspace.each(backward, range(self.thickness.size))

    def mean_stress(self, pressure: Array, visit: Visit) -> None:
        """Show the mean stress, a third of the trace; see `stress`.

        The strain must have been taken in with ``trace=True``; arrays have shape ``(ny, nx)``.
        """
        load, loaded = self._pressure_spectrum(pressure)

        def backward(layer: int) -> None:
            parts = self._array("parts", load.shape)
            parts[...] = 0
            if not self._quiet and self._trace is not None:
                np.copyto(parts, self._trace[layer])
                if not any(n % 2 for n in self.padded):
                    parts[:, self.padded[0] // 2, -1] = 0
            if loaded:
                self._add(parts, self._elastic[layer, 3], load)
            visit(layer, self._to_map(parts, times_i=False))

        self._workspace.each(backward, range(self.thickness.size))

    def _pressure_spectrum(self, pressure: Array) -> tuple[Array, bool]:
        my, mx = self.padded
        parts: Array = np.zeros((2, my, self._width), self.real)
        if not pressure.any():
            return parts, False
        scratch: Array = np.empty((my, self._width), self._complex)
        values: Array = pressure.astype(self.real, copy=False)
        spectrum = half_spectrum(values, slice(0, self.shape[0]), self.padded, scratch)
        if self._fade is not None:
            spectrum *= self._fade
        parts[0], parts[1] = spectrum.real, spectrum.imag
        parts /= my * mx
        return parts, True

    def _add(self, parts: Array, table: Array, wave: Array) -> None:
        """Add a wave times a table whose rows fold over at the middle."""
        half = self._half
        product = self._array("product", parts.shape)
        np.multiply(wave[:, :half], table, out=product[:, :half])
        folded = table[1 : self.padded[0] - half + 1][::-1]
        np.multiply(wave[:, half:], folded, out=product[:, half:])
        np.add(parts, product, out=parts)

    def _put_nyquist(self, parts: Array, layer: int, component: int) -> None:
        """Put back what was moved by `_take_nyquist`."""
        my, mx = self.padded
        odd = self._odd[layer, component, :, 0]
        if mx % 2 == 0 and component in (2, 3):
            parts[..., -1] = odd[:, :my]
        if my % 2 == 0 and component in (2, 4):
            parts[:, my // 2] = odd[:, my:]
        if my % 2 == 0 and mx % 2 == 0:
            parts[:, my // 2, -1] = self._corner[layer, component] * self.real(-2 * self._modulus)

    def _to_map(self, parts: Array, times_i: bool) -> Array:
        spectrum = self._array("spectrum", parts.shape[1:], self._complex)
        if times_i:
            spectrum.real = parts[1]
            np.negative(parts[0], out=spectrum.imag)
        else:
            spectrum.real, spectrum.imag = parts
        return from_half_spectrum(spectrum, self.shape, self.padded)

    def _array(self, name: str, shape: tuple[int, ...], dtype: type | None = None) -> Array:
        """Return memory of this thread."""
        flat = self._workspace.scratch(name, (1, math.prod(shape)), dtype or self.real)
        array: Array = flat.reshape(shape)
        return array


class HalfSpace:
    """A half-space that deforms plastically: strain and pressure in, displacement and stress out.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the surface.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    thickness : array_like, shape (nz,)
        Thickness of each layer [m], from the surface down; the body is elastic below.
    shear_modulus : float
        μ [Pa].
    poisson : float
        ν.
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period of an endless surface.
    workspace : Workspace, optional
        Threads to use instead of new ones.
    precision : {"double", "single"}
        Arithmetic of transforms and sweeps.

    Raises
    ------
    InputError
        If an argument is not positive and finite, or the choice is unknown.

    Notes
    -----
    With a free boundary the map is padded with zeros to 1.5 times its edges. What the periodic
    images of that still do, which falls with the third power of the period and varies on its
    scale, is taken off by the difference of two operators on coarse cells and coarse layers, one
    of the same period and one of six times the edge of the map, both of long waves only.
    Restriction is the transpose of the interpolation, which keeps the symmetries.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        pixel: tuple[float, float],
        thickness: ArrayLike,
        *,
        shear_modulus: float,
        poisson: float,
        boundary: str = "free",
        workspace: Workspace | None = None,
        precision: str = "double",
    ) -> None:
        require_pixel(pixel)
        require_positive(shear_modulus=shear_modulus)
        layers = np.asarray(thickness, np.float64)
        if layers.ndim != 1 or not layers.size or not (layers > 0).all():
            raise InputError(
                f"must be a row of positive numbers [m], got {thickness!r}",
                argument="thickness",
                value=thickness,
            )
        if boundary not in ("free", "periodic"):
            raise InputError(
                f"must be 'free' or 'periodic', got {boundary!r}",
                argument="boundary",
                value=boundary,
            )
        self.shape, self.thickness = shape, layers
        self.workspace = workspace or Workspace()
        free = boundary == "free"
        padded = shape
        self._images: _Images | None = None
        if free:
            coarse, cells = _coarse_grid(shape)
            near, far = _periods(shape, coarse, cells)
            padded = near[0] * coarse, near[1] * coarse
        self._fine = Layers(
            shape, pixel, layers, float(shear_modulus), float(poisson), padded,
            isolated=free, workspace=self.workspace, precision=precision,
        )  # fmt: skip
        self.real = self._fine.real
        if free:
            self._images = _Images(self._fine, pixel, coarse, cells, near, far, precision)

    def displacement(self, fill: Fill, *, trace: bool = False) -> NDArray[np.float64]:
        """Take in a plastic strain and return the surface displacement that it causes.

        Parameters
        ----------
        fill, trace
            As for `Layers.displacement`.

        Returns
        -------
        ndarray, shape (ny, nx)
            Normal displacement [m], positive into the body.
        """
        if self._images is None:
            return self._fine.displacement(fill, trace=trace)
        self._images.clear()
        displacement = self._fine.displacement(fill, trace=trace, see=self._images.take)
        return displacement + self._images.displacement(trace=trace)

    def stress(self, pressure: Array, visit: Visit) -> None:
        """Show the deviator of the stress, layer by layer; see `Layers.stress`."""
        images = self._images
        if images is None:
            self._fine.stress(pressure, visit)
            return
        images.stress(pressure)

        def corrected(layer: int, stress: Array) -> None:
            for component in range(5):
                stress[component] += images.on_layer(layer, component)
            visit(layer, stress)

        self._fine.stress(pressure, corrected)

    def mean_stress(self, pressure: Array, visit: Visit) -> None:
        """Show the mean stress, layer by layer, after ``displacement(..., trace=True)``."""
        images = self._images
        if images is None:
            self._fine.mean_stress(pressure, visit)
            return
        images.mean_stress(pressure)
        self._fine.mean_stress(
            pressure, lambda layer, mean: visit(layer, mean + images.on_layer(layer, 0))
        )


def _coarse_grid(shape: tuple[int, int]) -> tuple[int, tuple[int, int]]:
    """Return points per coarse cell, and the cells ``(my, mx)`` with guards around the map."""
    coarse = -(-min(shape) // _COARSE)
    cells = [-(-n // coarse) + 2 * _GUARD for n in shape]
    return coarse, (cells[0], cells[1])


def _periods(
    shape: tuple[int, int], coarse: int, cells: tuple[int, int]
) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the coarse cells of the near and of the far period.

    The near one is a whole number of coarse cells, and the same on both grids.
    """
    near = [
        fast_length(max(cell, math.ceil(_NEAR * n / coarse)))
        for n, cell in zip(shape, cells, strict=True)
    ]
    far = [fast_length(math.ceil(_FAR * cell)) for cell in cells]
    return (near[0], near[1]), (far[0], far[1])


def points_transformed(shape: tuple[int, int], boundary: str) -> int:
    """Return the points of all periods in which a `HalfSpace` transforms a layer.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the surface.
    boundary : {"free", "periodic"}
        As for `HalfSpace`.

    Returns
    -------
    int
        Points; those of the coarse grids of a free boundary too, as if it had all the layers.
    """
    if boundary == "periodic":
        return shape[0] * shape[1]
    coarse, cells = _coarse_grid(shape)
    near, far = _periods(shape, coarse, cells)
    return near[0] * near[1] * (coarse**2 + 1) + far[0] * far[1]


def _cubic(points: int, coarse: int, cells: int) -> NDArray[np.float64]:
    """Return the matrix, shape (points, cells), of the interpolation by cubics (Lagrange)."""
    # Where the points lie, counted in cells from the centre of the first one.
    place = (np.arange(points) + 0.5) / coarse - 0.5 + _GUARD
    left = np.floor(place).astype(int)
    t = place - left
    weights = (
        -t * (t - 1) * (t - 2) / 6,
        (t + 1) * (t - 1) * (t - 2) / 2,
        -(t + 1) * t * (t - 2) / 2,
        (t + 1) * t * (t - 1) / 6,
    )
    matrix = np.zeros((points, cells))
    for offset, weight in zip((-1, 0, 1, 2), weights, strict=True):
        matrix[np.arange(points), left + offset] = weight
    return matrix


def _linear(fine: NDArray[np.float64], coarse: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (nz, mz) that interpolates between the centres of two sets of layers."""
    below = np.cumsum(coarse) - coarse / 2
    at = np.cumsum(fine) - fine / 2
    left = np.clip(np.searchsorted(below, at) - 1, 0, max(0, below.size - 2))
    matrix = np.zeros((fine.size, coarse.size))
    rows = np.arange(fine.size)
    if coarse.size == 1:
        matrix[:, 0] = 1
        return matrix
    share = (at - below[left]) / (below[left + 1] - below[left])
    matrix[rows, left] = 1 - share
    matrix[rows, left + 1] = share
    return matrix


def _merged(thickness: NDArray[np.float64], least: float) -> NDArray[np.float64]:
    """Return layers that are sums of neighbours, of at least some thickness but the last."""
    merged, current = [], 0.0
    for layer in thickness:
        current += layer
        if current >= least:
            merged.append(current)
            current = 0.0
    if current:
        merged.append(current)
    return np.array(merged)


class _Images:
    """What an infinite surface does other than a periodic one, on coarse cells."""

    def __init__(
        self,
        fine: Layers,
        pixel: tuple[float, float],
        coarse: int,
        cells: tuple[int, int],
        near: tuple[int, int],
        far: tuple[int, int],
        precision: str,
    ) -> None:
        import scipy.sparse

        workspace = fine._workspace
        self._workspace, self._fine = workspace, fine
        edges = pixel[0] * coarse, pixel[1] * coarse
        thickness = _merged(fine.thickness, _COARSE_DEPTH * min(edges))
        arguments = (cells, edges, thickness, fine._modulus, fine._poisson)
        more: dict[str, Any] = dict(
            isolated=True, workspace=workspace, precision=precision, smooth=True
        )
        self._near = Layers(*arguments, near, **more)
        self._far = Layers(*arguments, far, **more)
        matrix = scipy.sparse.csr_array
        self._up_y = matrix(_cubic(fine.shape[0], coarse, cells[0]).astype(fine.real))
        self._up_x = matrix(_cubic(fine.shape[1], coarse, cells[1]).astype(fine.real))
        self._down_y, self._down_x = self._up_y.T.tocsr(), self._up_x.T.tocsr()
        self._up_z = _linear(fine.thickness, thickness)
        # The transpose under the inner products of both grids: cells times thickness.
        self._down_z = (self._up_z * fine.thickness[:, None]).T / thickness[:, None] / coarse**2
        self._scale = 1 / coarse**2
        self._parts: dict[int, Array] = {}
        self._strain: Array = np.zeros((thickness.size, 5, *cells), fine.real)
        self._stress = np.zeros_like(self._strain)
        self._cells = cells

    def clear(self) -> None:
        """Forget the strain."""
        self._parts.clear()

    def _restricted(self, values: Array) -> Array:
        halfway = self._down_y @ values
        coarse: Array = (self._down_x @ halfway.T).T
        return coarse

    def take(self, layer: int, strain: Array) -> None:
        """Restrict the strain of one layer."""
        self._parts[layer] = np.stack([self._restricted(values) for values in strain])

    def displacement(self, *, trace: bool) -> Array:
        """Return the correction of the displacement by the strain taken."""
        self._strain[...] = 0
        # In order: which thread came first must not change the last bits of the sum.
        for layer, part in sorted(self._parts.items()):
            for into in np.flatnonzero(self._down_z[:, layer]):
                self._strain[into] += self._down_z[into, layer] * part
        rows = slice(0, self._cells[0])

        def fill(layer: int, out: Array) -> slice | None:
            out[...] = self._strain[layer]
            return rows if self._strain[layer].any() else None

        far = self._far.displacement(fill, trace=trace)
        far -= self._near.displacement(fill, trace=trace)
        return self._prolonged(far.astype(self._fine.real))

    def stress(self, pressure: Array) -> None:
        """Work out the correction of the stress on the coarse layers."""
        coarse = self._restricted(pressure.astype(self._fine.real)) * self._scale
        self._far.stress(coarse, lambda layer, values: np.copyto(self._stress[layer], values))

        def subtract(layer: int, values: Array) -> None:
            self._stress[layer] -= values

        self._near.stress(coarse, subtract)

    def mean_stress(self, pressure: Array) -> None:
        """Work out the correction of the mean stress on the coarse layers."""
        coarse = self._restricted(pressure.astype(self._fine.real)) * self._scale
        first = self._stress[:, 0]
        self._far.mean_stress(coarse, lambda layer, values: np.copyto(first[layer], values))

        def subtract(layer: int, values: Array) -> None:
            first[layer] -= values

        self._near.mean_stress(coarse, subtract)

    def on_layer(self, layer: int, component: int) -> Array:
        """Return the correction on one fine layer."""
        near = np.flatnonzero(self._up_z[layer])
        coarse = np.einsum("z,zyx->yx", self._up_z[layer, near], self._stress[near, component])
        return self._prolonged(coarse.astype(self._fine.real))

    def _prolonged(self, coarse: Array) -> Array:
        halfway = self._up_y @ coarse
        result: Array = (self._up_x @ halfway.T).T
        return result
