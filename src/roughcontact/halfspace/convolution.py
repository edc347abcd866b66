"""Convolution of pressure maps with influence coefficients, by FFT on several threads.

One application passes over the memory three times: rows forward, columns forward and back with the
multiplication in between, rows back. Rows without load are not transformed, columns are handled
in blocks that stay in cache, and a callback receives the result row block by row block while it is
still in cache, so that no whole-array pass is needed around the transforms.
"""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.errors import require_pixel, require_positive
from roughcontact.halfspace import fft, kernels
from roughcontact.halfspace.coating import Coatings
from roughcontact.halfspace.fft import Workspace

MAX_CACHE_BYTES = 2**27
"""Maximum cache of a process in bytes; a map of 2900 × 2900 points needs half of it."""


class ArrayCache:
    """Cache of arrays by key, limited to the most recently used ones.

    Parameters
    ----------
    limit : int
        Maximum bytes of cached arrays; a larger array is not cached.

    Examples
    --------
    >>> cache = ArrayCache(100)
    >>> cache.get("ones", lambda: np.ones(4)) is cache.get("ones", lambda: np.ones(4))
    True
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._arrays: OrderedDict[Hashable, Array] = OrderedDict()
        self._lock = threading.Lock()

    @property
    def nbytes(self) -> int:
        """Bytes of the cached arrays."""
        return sum(array.nbytes for array in self._arrays.values())

    def get(self, key: Hashable, make: Callable[[], Array]) -> Array:
        """Return the result of ``make()`` for this key, read-only."""
        with self._lock:
            if key in self._arrays:
                self._arrays.move_to_end(key)
                return self._arrays[key]
        # Two threads may make the same array at the same time; either result is valid.
        array = make()
        array.flags.writeable = False
        if array.nbytes <= self._limit:
            with self._lock:
                self._arrays[key] = array
                while self.nbytes > self._limit:
                    self._arrays.popitem(last=False)
        return array


# The only state that outlives a call. It changes no result: an array depends only on its key.
SPECTRA = ArrayCache(MAX_CACHE_BYTES)


Visit = Callable[[int, slice, NDArray[Any]], None]

BAND = 64
"""Rows of the kernel that one thread computes at a time.

The first row of a band decides which of its pixels are treated as near, and hence their last
digits: it must not depend on the number of threads.
"""

MIN_BLOCK_GAP = 4
"""Half the number of zero rows and columns that separate the opposite edges of a map."""


@dataclass(frozen=True, eq=False)
class Support:
    """Selected pixels of a map, and their positions in each row block.

    Parameters
    ----------
    index : ndarray of int, shape (n,)
        Flat indices of the pixels, ascending.
    position : ndarray of int, shape (n,)
        Flat indices of the same pixels in a map whose rows have the padded length.
    starts : ndarray of int
        First entry of each row block, and ``n`` at the end.
    """

    index: NDArray[np.int64]
    position: NDArray[np.int64]
    starts: NDArray[np.int64]


class Convolution:
    """Circular convolution of real maps with a kernel that is even in x and in y.

    Parameters
    ----------
    spectrum : ndarray, shape (my//2 + 1, mx//2 + 1)
        Transform of the kernel over ``my × mx`` points, first quadrant.
    shape : (int, int)
        Grid points ``(ny, nx)`` of the maps.
    padded : (int, int)
        Period ``(my, mx)`` of the convolution, at least ``shape``; maps are padded with zeros.
    workspace : Workspace
        Threads and memory; no other operator may use them at the same time.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    softness : float
        Factor of the spectrum.

    Attributes
    ----------
    self_displacement : float
        Displacement of a pixel under unit pressure on itself, K₀₀ [m/Pa].
    surface : ndarray, optional
        Spectrum of the outermost layers alone, if the bodies below are much softer; it gives the
        better `approximate_inverse`, because blocks of pixels represent the long waves.
    """

    def __init__(
        self,
        spectrum: NDArray[Any],
        shape: Shape,
        padded: Shape,
        *,
        workspace: Workspace,
        precision: str = "double",
        softness: float = 1.0,
    ) -> None:
        self.real: type = np.float32 if precision == "single" else np.float64
        self._complex: type = np.complex64 if precision == "single" else np.complex128
        self.shape, self.padded, self.workspace = shape, padded, workspace
        self.spectrum = spectrum.astype(self.real, copy=False)
        self.surface: NDArray[Any] | None = None
        self.softness = softness
        self.self_displacement = softness * _value_at_origin(spectrum, padded)
        self._rows = (shape[0], padded[1] // 2 + 1)
        itemsize = np.dtype(self._complex).itemsize
        workspace.reserve(self._rows[0] * self._rows[1] * itemsize)
        step = max(1, min(shape[0], fft.ROW_BYTES // (padded[1] * itemsize // 2)))
        self._blocks = [slice(top, min(top + step, shape[0])) for top in range(0, shape[0], step)]
        self._column_step = max(4, min(self._rows[1], fft.COLUMN_BYTES // (padded[0] * itemsize)))

    @property
    def is_long_wave_soft(self) -> bool:
        """Whether long waves are far more compliant than short ones: a plate on a soft bed."""
        return self.surface is not None

    @property
    def periodic_axes(self) -> tuple[bool, bool]:
        """Whether the map is periodic along y and along x."""
        return self.padded[0] == self.shape[0], self.padded[1] == self.shape[1]

    def support(self, index: NDArray[np.int64]) -> Support:
        """Return the support of the pixels with these ascending flat indices."""
        nx = self.shape[1]
        tops = [rows.start * nx for rows in self._blocks] + [self.shape[0] * nx]
        # Without padding along x, rows are as long as in the map.
        position = index
        if self.padded[1] > nx:
            position = index // nx
            position *= self.padded[1] - nx
            position += index
        return Support(index, position, np.searchsorted(index, tops))

    def each_block(self, task: Callable[[int, slice], None]) -> None:
        """Call ``task(number, rows)`` for every row block, on all threads."""
        numbers = range(len(self._blocks))
        self.workspace.each(lambda number: task(number, self._blocks[number]), numbers)

    def spread(self, support: Support, pressure: NDArray[Any], visit: Visit) -> None:
        """Pass the displacement of the whole map under pressure on some pixels to a callback.

        Parameters
        ----------
        support : Support
            The ``n`` loaded pixels.
        pressure : ndarray, shape (n,)
            Pressure on them [Pa].
        visit : callable
            ``visit(number, rows, displacement)`` receives each row block, shape ``(rows, nx)``,
            from one of several threads; the array is only valid during the call.
        """

        def crop_rows(field: int, number: int, rows: slice, padded: NDArray[Any]) -> None:
            visit(number, rows, padded[:, : self.shape[1]])

        self._apply(support, pressure, crop_rows, range(len(self._blocks)))

    def gather(self, support: Support, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the loaded pixels, in the shape of the pressure, ``(n,)``."""
        displacement = np.empty_like(pressure, float)
        fields, starts = np.atleast_2d(displacement), support.starts

        def gather_rows(field: int, number: int, rows: slice, padded: NDArray[Any]) -> None:
            part = slice(starts[number], starts[number + 1])
            positions = support.position[part] - rows.start * self.padded[1]
            fields[field, part] = padded.ravel()[positions]

        self._apply(support, pressure, gather_rows, np.flatnonzero(np.diff(starts)))
        return displacement

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the whole map under a pressure map, shape ``(ny, nx)``."""
        displacement: NDArray[Any] = np.empty(self.shape, self.real)

        def visit(number: int, rows: slice, block: NDArray[Any]) -> None:
            displacement[rows] = block

        index = np.flatnonzero(pressure)
        self.spread(self.support(index), pressure.ravel()[index], visit)
        return displacement

    def to_single_precision(self) -> Convolution:
        """Return the operator in single precision; the same object if it already is.

        The buffer is shared: the two operators must not be used at the same time.
        """
        if self.real is np.float32:
            return self
        single = self._derive(self.spectrum, softness=self.softness)
        single.surface = self.surface
        return single

    def with_foundation(self, compliance: float) -> Convolution:
        """Return the operator of the body on a Winkler foundation.

        Parameters
        ----------
        compliance : float
            Displacement of a pixel under unit pressure on itself alone [m/Pa]; it adds to the
            symbol of every wave.
        """
        share = self.real(compliance / self.softness)
        precision = "single" if self.real is np.float32 else "double"
        result = self._derive(self.spectrum + share, precision=precision, softness=self.softness)
        result.surface = None if self.surface is None else self.surface + share
        return result

    def approximate_inverse(self) -> Convolution:
        """Return ``displacement / K₀₀ → pressure`` with little padding, in single precision.

        The inverse of a circular convolution divides by the spectrum. A few rows and columns of
        zeros separate opposite free edges; each wave has the symbol of the nearest wave of the
        padded map. A wave whose symbol is not positive gets the largest symbol: without it, a
        given approach could not be inverted. The buffer is shared: the two operators must not be
        used at the same time.
        """
        period, waves = self.inverse_grid()
        of = self.spectrum if self.surface is None else self.surface
        spectrum = of[np.ix_(*waves)].astype(np.float64)
        spectrum[spectrum <= 0] = spectrum.max()
        np.divide(self.self_displacement / self.softness, spectrum, out=spectrum)
        return self._derive(spectrum, period)

    def _derive(
        self,
        spectrum: NDArray[Any],
        padded: tuple[int, int] | None = None,
        precision: str = "single",
        **options: Any,
    ) -> Convolution:
        """Return an operator of the same map, with the same threads and memory."""
        options |= {"workspace": self.workspace, "precision": precision}
        return type(self)(spectrum, self.shape, padded or self.padded, **options)

    def inverse_grid(self) -> tuple[tuple[int, int], list[NDArray[np.int64]]]:
        """Return the period of `approximate_inverse`, and the nearest waves of the padded map."""
        period = [
            points if wrapped else 2 * fft.fast_length(points // 2 + MIN_BLOCK_GAP)
            for points, wrapped in zip(self.shape, self.periodic_axes, strict=True)
        ]
        waves = [
            np.rint(np.arange(short // 2 + 1) * (long / short)).astype(np.int64)
            for short, long in zip(period, self.padded, strict=True)
        ]
        return (period[0], period[1]), waves

    def _apply(
        self,
        support: Support,
        values: NDArray[Any],
        show: Callable[[int, int, slice, NDArray[Any]], None],
        shown: Sequence[int] | NDArray[Any],
    ) -> None:
        """Pass each field of the displacement to a callback, one of the given row blocks a time."""
        (my, mx), (ny, width) = self.padded, self._rows
        blocks, starts, work = self._blocks, support.starts, self.workspace
        fields = np.atleast_2d(values)
        spectra = work.shared_array((len(fields) * ny, width), self._complex).reshape(-1, ny, width)
        scale = self.softness / (my * mx)

        def forward(number: int) -> None:
            rows, part = blocks[number], slice(starts[number], starts[number + 1])
            positions = support.position[part] - rows.start * mx
            padded = work.scratch("row", (rows.stop - rows.start, mx), self.real)
            for field, spectrum in zip(fields, spectra, strict=True):
                padded[...] = 0
                padded.ravel()[positions] = field[part] * scale
                fft.rfft_rows(padded, spectrum[rows])

        loaded = np.flatnonzero(np.diff(starts))
        work.each(forward, loaded)
        runs_in = join_blocks(blocks, loaded)
        runs_out = join_blocks(blocks, shown)

        def columns(first: int) -> None:
            block = slice(first, min(first + self._column_step, width))
            memory = work.scratch("column", (len(fields) * my, block.stop - first), self._complex)
            waves = []
            for field, spectrum in zip(memory.reshape(len(fields), my, -1), spectra, strict=True):
                end = 0
                for rows in runs_in:
                    field[end : rows.start] = 0
                    field[rows] = spectrum[rows, block]
                    end = rows.stop
                field[end:] = 0
                waves.append(fft.fft_columns(field, forward=True))
            self._multiply(waves, block)
            for field, spectrum in zip(waves, spectra, strict=True):
                displaced = fft.fft_columns(field, forward=False)
                for rows in runs_out:
                    spectrum[rows, block] = displaced[rows]

        work.each(columns, range(0, width, self._column_step))

        def backward(number: int) -> None:
            rows = blocks[number]
            padded = work.scratch("row", (rows.stop - rows.start, mx), self.real)
            for field, spectrum in enumerate(spectra):
                show(field, number, rows, fft.irfft_rows(spectrum[rows], mx, padded))

        work.each(backward, shown)

    def _multiply(self, waves: list[NDArray[Any]], block: slice) -> None:
        """Multiply some columns of the waves by the spectrum, in place."""
        # The kernel is even: the upper half mirrors the lower one.
        symbol, half = self.spectrum[:, block], len(self.spectrum)
        waves[0][:half] *= symbol
        waves[0][half:] *= symbol[self.padded[0] - half : 0 : -1]


def join_blocks(blocks: Sequence[slice], numbers: Iterable[int]) -> list[slice]:
    """Return the rows of some blocks, with adjacent blocks joined."""
    runs: list[slice] = []
    for number in numbers:
        rows = blocks[number]
        if runs and runs[-1].stop == rows.start:
            runs[-1] = slice(runs[-1].start, rows.stop)
        else:
            runs.append(rows)
    return runs


def _value_at_origin(spectrum: NDArray[np.float64], padded: Shape) -> float:
    """Return the kernel at the origin: the mean of its spectrum over all wave vectors."""
    # Waves have mirrors in the other quadrants, except at 0 and at Nyquist.
    rows = 2 * spectrum.sum(axis=1) - spectrum[:, 0]
    if padded[1] % 2 == 0:
        rows -= spectrum[:, -1]
    total = 2 * rows.sum() - rows[0]
    if padded[0] % 2 == 0:
        total -= rows[-1]
    return float(total) / (padded[0] * padded[1])


def free(
    shape: Shape,
    pixel: Pixel,
    contact_modulus: float,
    *,
    coatings: Coatings | None = None,
    precision: str = "double",
    workspace: Workspace | None = None,
) -> Convolution:
    """Return the operator ``pressure → displacement`` of a free half-space.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    contact_modulus : float
        E* [Pa]; for coated bodies, of their outermost layers.
    coatings : Coatings, optional
        Coatings of the bodies.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    workspace : Workspace, optional
        Threads and memory to use instead of new ones.

    Returns
    -------
    Convolution
        Linear convolution with Love's coefficients, exact to rounding by zero padding.
    """
    require_pixel(pixel)
    require_positive(contact_modulus=contact_modulus)
    work = workspace or Workspace()
    half = (fft.fast_length(shape[0]), fft.fast_length(shape[1]))
    # Without coatings, the size of the pixels and the modulus only enter as a factor.
    edges = (1.0, pixel[1] / pixel[0])

    def make() -> NDArray[np.float64]:
        quadrant = np.empty((half[0] + 1, half[1] + 1))
        reach = math.hypot(quadrant.shape[0] * pixel[0], quadrant.shape[1] * pixel[1])
        tables = [] if coatings is None else coatings.tables(reach)

        def fill(top: int) -> None:
            rows = quadrant[top : top + BAND]
            rows[...] = kernels.love(rows.shape, edges, 1.0, top)
            if coatings is not None:
                rows += coatings.pixels(rows.shape, pixel, top, tables) / (math.pi * pixel[0])

        work.each(fill, range(0, quadrant.shape[0], BAND))
        return fft.quadrant_spectrum(quadrant, work)

    return Convolution(
        SPECTRA.get(("free", half, edges if coatings is None else pixel, coatings), make),
        shape,
        (2 * half[0], 2 * half[1]),
        workspace=work,
        precision=precision,
        softness=pixel[0] / contact_modulus,
    )


def periodic(
    shape: Shape,
    pixel: Pixel,
    contact_modulus: float,
    *,
    coatings: Coatings | None = None,
    precision: str = "double",
    workspace: Workspace | None = None,
) -> Convolution:
    """Return the operator ``pressure → displacement`` of a periodic half-space.

    Parameters
    ----------
    shape, pixel, contact_modulus, coatings, precision, workspace
        As for `free`; the map is one period.

    Returns
    -------
    Convolution
        Circular convolution with the symbol ``2/(E* |q|)``, zero at q = 0 except for coatings on a
        rigid base.
    """
    # Not cached: it is computed as fast as it would be read.
    symbol = kernels.periodic(shape, pixel, contact_modulus)
    if coatings is not None:
        moved = symbol > 0
        symbol[moved] *= coatings.factor(2 / contact_modulus / symbol[moved])
        symbol[~moved] = 2 / contact_modulus * coatings.uniform()
    workspace = workspace or Workspace()
    return Convolution(symbol, shape, shape, workspace=workspace, precision=precision)


def strip(
    shape: Shape,
    pixel: Pixel,
    contact_modulus: float,
    axis: int,
    *,
    datum: float | None = None,
    coatings: Coatings | None = None,
    precision: str = "double",
    workspace: Workspace | None = None,
) -> Convolution:
    """Return the operator ``pressure → displacement``, periodic along one axis.

    Parameters
    ----------
    shape, pixel, contact_modulus, coatings, precision, workspace
        As for `free`.
    axis : {0, 1}
        Axis along which the map is periodic: 0 for y, 1 for x.
    datum : float, optional
        Distance from a uniform line load at which the displacement is zero [m]; by default the
        longer side of the map. Without effect for coatings on a rigid base.

    Returns
    -------
    Convolution
        Circular along that axis, with the pressure expanded in waves as by `periodic`, and linear
        along the other one, exact to rounding by zero padding.

    Notes
    -----
    The kernel decreases and is convex along the free axis (`kernels.strip`), and is positive up to
    the datum: so no wave of the padded map has a negative symbol. With a stiff coating that bends,
    the kernel is not convex, and some of these symbols are negative; those of the map itself are
    not.
    """
    require_pixel(pixel)
    if datum is None:
        datum = max(shape[0] * pixel[0], shape[1] * pixel[1])
    require_positive(contact_modulus=contact_modulus, datum=datum)
    work = workspace or Workspace()
    # The kernel has x as the periodic axis.
    period, across = shape[axis], (pixel[1 - axis], pixel[axis])
    edges, far = (1.0, across[1] / across[0]), datum / across[0]
    # For homogeneous bodies, the size of the strip only enters as a factor.
    known = (edges[1], far) if coatings is None else (across, datum)
    half = fft.fast_length(shape[1 - axis])

    def make() -> NDArray[np.float64]:
        table = np.zeros((half + 1, period // 2 + 1))

        def fill(waves: slice) -> None:
            part = kernels.strip((half + 1, period), edges, 1.0, far, waves)
            if coatings is not None:
                part += coatings.strip((half + 1, period), across, datum, waves) / across[0]
            table[:, waves] = part

        # Equal work for each octave: from one to the next, waves decay over half the distance.
        ends = [0, *(1 << n for n in range((period // 2).bit_length() + 1))]
        work.each(fill, [slice(*pair) for pair in pairwise(ends)])
        fft.quadrant_spectrum(table, work, axes=(0,))
        return table if axis == 1 else np.ascontiguousarray(table.T)

    return Convolution(
        SPECTRA.get(("strip", axis, half, period, known, coatings), make),
        shape,
        (2 * half, period) if axis == 1 else (period, 2 * half),
        workspace=work,
        precision=precision,
        softness=across[0] / contact_modulus,
    )
