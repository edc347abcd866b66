"""FFT operators on maps; the only module that knows FFT libraries and threads.

One application visits the memory three times: rows forward, columns forward and back with the
multiplication in between, rows back. Rows without load are not transformed, columns are handled
in blocks that stay in cache, and whoever wants the result sees it row block by row block while it
is still in cache, so that no whole-array pass is needed around the transforms.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace import kernels

try:
    import ducc0 as _ducc0
except ImportError:
    _ducc0 = None

Visit = Callable[[int, slice, NDArray[Any]], None]

# What one thread works on at a time: a usual second-level cache for the columns, which are read
# twice and transformed twice, half of one for the rows.
_COLUMN_BYTES = 1 << 20
_ROW_BYTES = 1 << 19


def default_workers() -> int:
    """Return the number of processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


# SciPy's FFT is imported where needed: most of the time of `import roughcontact` would be its.


def _rfft_rows(rows: NDArray[Any], out: NDArray[Any]) -> None:
    if _ducc0 is not None:
        _ducc0.fft.r2c(rows, axes=(1,), out=out, nthreads=1)
        return
    import scipy.fft

    out[...] = scipy.fft.rfft(rows, axis=1, workers=1)


def _irfft_rows(spectrum: NDArray[Any], length: int, out: NDArray[Any]) -> NDArray[Any]:
    """Return the unnormalised inverse, in ``out`` where the library can."""
    if _ducc0 is not None:
        _ducc0.fft.c2r(
            spectrum, axes=(1,), lastsize=length, forward=False, out=out, nthreads=1,
            allow_overwriting_input=True,
        )  # fmt: skip
        return out
    import scipy.fft

    inverse: NDArray[Any] = scipy.fft.irfft(
        spectrum, length, axis=1, norm="forward", overwrite_x=True, workers=1
    )
    return inverse


def _fft_columns(columns: NDArray[Any], forward: bool) -> NDArray[Any]:
    """Return the transform along axis 0, in place where the library can; inverse unnormalised."""
    if _ducc0 is not None:
        _ducc0.fft.c2c(columns, axes=(0,), forward=forward, out=columns, nthreads=1)
        return columns
    import scipy.fft

    transformed: NDArray[Any]
    if forward:
        transformed = scipy.fft.fft(columns, axis=0, overwrite_x=True, workers=1)
    else:
        transformed = scipy.fft.ifft(columns, axis=0, norm="forward", overwrite_x=True, workers=1)
    return transformed


def _even_spectrum(quadrant: NDArray[np.float64], workers: int) -> NDArray[np.float64]:
    """Return the discrete Fourier transform of an even sequence, from and as one quadrant."""
    spectrum: NDArray[np.float64]
    if _ducc0 is not None:
        spectrum = _ducc0.fft.dct(quadrant, axes=(0, 1), type=1, out=quadrant, nthreads=workers)
        return spectrum
    import scipy.fft

    spectrum = scipy.fft.dctn(quadrant, type=1, overwrite_x=True, workers=workers)
    return spectrum


def _half_line_transform(columns: NDArray[Any], odd: bool) -> None:
    """Transform, in place along axis 0, sequences of which 0 to half the period are given.

    Even ones give their discrete Fourier transform, odd ones (0 at both ends) i times it.
    """
    part, kind = (columns[1:-1], "dst") if odd else (columns, "dct")
    if odd:
        columns[0] = columns[-1] = 0
    if not part.size:
        return
    if _ducc0 is not None:
        getattr(_ducc0.fft, kind)(part, axes=(0,), type=1, out=part, nthreads=1)
        return
    import scipy.fft

    part[...] = getattr(scipy.fft, kind)(part, type=1, axis=0, workers=1)


def free_period(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the period to which zeros must pad a map so that its images do not meet it.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.

    Returns
    -------
    (int, int)
        Even lengths, at least twice the shape, that transform fast.
    """
    return 2 * fast_length(shape[0]), 2 * fast_length(shape[1])


def half_spectrum(
    values: NDArray[Any], rows: slice, padded: tuple[int, int], out: NDArray[Any]
) -> NDArray[Any]:
    """Return the transform of a real map that is padded with zeros.

    Parameters
    ----------
    values : ndarray, shape (ny, nx)
        The map.
    rows : slice
        Its rows that are not zero; the others are not read.
    padded : (int, int)
        Points ``(my, mx)`` of the transform.
    out : ndarray of complex, shape (my, mx//2 + 1)
        Memory for the result.

    Returns
    -------
    ndarray of complex, shape (my, mx//2 + 1)
        The sum over the map times ``exp(-i(qy·y + qx·x))`` for qx ≥ 0: ``out`` where the library
        can work in place. One thread.
    """
    out[: rows.start] = 0
    out[rows.stop :] = 0
    wide = np.zeros((rows.stop - rows.start, padded[1]), values.dtype)
    wide[:, : values.shape[1]] = values[rows]
    _rfft_rows(wide, out[rows])
    return _fft_columns(out, forward=True)


def from_half_spectrum(
    spectrum: NDArray[Any], shape: tuple[int, int], padded: tuple[int, int]
) -> NDArray[Any]:
    """Return the first points of the unnormalised inverse transform of a half spectrum.

    Parameters
    ----------
    spectrum : ndarray of complex, shape (my, mx//2 + 1)
        Half spectrum; it is overwritten.
    shape : (int, int)
        Points ``(ny, nx)`` wanted, from the first on.
    padded : (int, int)
        Points ``(my, mx)`` of the transform.

    Returns
    -------
    ndarray, shape (ny, nx)
        ``my·mx`` times the map whose transform this is. One thread.
    """
    columns = _fft_columns(spectrum, forward=False)
    wide = np.empty((shape[0], padded[1]), spectrum.real.dtype)
    return _irfft_rows(columns[: shape[0]], padded[1], wide)[:, : shape[1]]


def fast_length(points: int) -> int:
    """Return the smallest length ≥ ``points`` that transforms fast."""
    if _ducc0 is not None:
        return int(_ducc0.fft.good_size(points, True))
    import scipy.fft

    return int(scipy.fft.next_fast_len(points, real=True))


@dataclass(frozen=True, eq=False)
class Support:
    """The pixels of a map that matter, and where they lie in each row block.

    Parameters
    ----------
    index : ndarray of int, shape (n,)
        Flat indices of the pixels, ascending.
    position : ndarray of int, shape (n,)
        Flat indices of the same pixels in a map whose rows have the padded length.
    starts : ndarray of int
        First entry of each row block, and ``n`` behind the last.
    """

    index: NDArray[np.int64]
    position: NDArray[np.int64]
    starts: NDArray[np.int64]


class Workspace:
    """Threads and memory that operators use one after the other.

    Parameters
    ----------
    workers : int, optional
        Threads; by default one for each core that the process may use.
    """

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or default_workers()
        self._pool = ThreadPoolExecutor(max(1, self.workers - 1))
        self._memory = np.empty(0, np.uint8)
        self._local = threading.local()

    def each(self, task: Callable[[Any], None], items: Iterable[Any]) -> None:
        """Call a task for every item, on all threads and this one."""
        # One iterator for all: whoever is free takes the next item, and nothing is queued.
        left = iter(items)

        def work() -> None:
            for item in left:
                task(item)

        helpers = [self._pool.submit(work) for _ in range(self.workers - 1)]
        try:
            work()
        finally:
            # result() hands an error inside a thread to the caller.
            for helper in helpers:
                helper.result()

    def reserve(self, size: int) -> None:
        """Make sure that `shared` arrays of so many bytes need no new memory."""
        if self._memory.size < size:
            self._memory = np.empty(size, np.uint8)

    def shared(self, shape: tuple[int, int], dtype: type) -> NDArray[Any]:
        """Return the one array that all operators share; its content is anything."""
        size = shape[0] * shape[1] * np.dtype(dtype).itemsize
        self.reserve(size)
        return self._memory[:size].view(dtype).reshape(shape)

    def scratch(self, name: str, shape: tuple[int, int], dtype: type) -> NDArray[Any]:
        """Return an array of this thread: fresh memory would cost a page fault every 4 KiB."""
        size = shape[0] * shape[1] * np.dtype(dtype).itemsize
        memory = getattr(self._local, name, None)
        if memory is None or memory.size < size:
            memory = np.empty(size, np.uint8)
            setattr(self._local, name, memory)
        array: NDArray[Any] = memory[:size].view(dtype).reshape(shape)
        return array


class Convolution:
    """A circular convolution of real maps with a kernel that is even in x and in y.

    Parameters
    ----------
    spectrum : ndarray, shape (my//2 + 1, mx//2 + 1)
        Transform of the kernel over ``my × mx`` points, first quadrant.
    shape : (int, int)
        Grid points ``(ny, nx)`` of the maps.
    padded : (int, int)
        Period ``(my, mx)`` of the convolution, at least ``shape``; maps are padded with zeros.
    workspace : Workspace
        Threads and memory; no other operator on it may be at work at the same time.
    precision : {"double", "single"}
        Arithmetic of the transforms.

    Attributes
    ----------
    self_displacement : float
        Displacement of a pixel under unit pressure on itself, K₀₀ [m/Pa].
    """

    def __init__(
        self,
        spectrum: NDArray[Any],
        shape: tuple[int, int],
        padded: tuple[int, int],
        *,
        workspace: Workspace,
        precision: str = "double",
    ) -> None:
        self.real: type = np.float32 if precision == "single" else np.float64
        self._complex: type = np.complex64 if precision == "single" else np.complex128
        self.shape, self.padded, self.workspace = shape, padded, workspace
        self.spectrum = spectrum.astype(self.real, copy=False)
        self.self_displacement = _value_at_origin(spectrum, padded)
        self._rows = (shape[0], padded[1] // 2 + 1)
        itemsize = np.dtype(self._complex).itemsize
        workspace.reserve(self._rows[0] * self._rows[1] * itemsize)
        step = max(1, min(shape[0], _ROW_BYTES // (padded[1] * itemsize // 2)))
        self._blocks = [slice(top, min(top + step, shape[0])) for top in range(0, shape[0], step)]
        self._column_step = max(4, min(self._rows[1], _COLUMN_BYTES // (padded[0] * itemsize)))

    def support(self, index: NDArray[np.int64]) -> Support:
        """Return where the pixels with these ascending flat indices lie in the row blocks."""
        nx = self.shape[1]
        tops = [rows.start * nx for rows in self._blocks] + [self.shape[0] * nx]
        position = index // nx
        position *= self.padded[1] - nx
        position += index
        return Support(index, position, np.searchsorted(index, tops))

    def each_block(self, task: Callable[[int, slice], None]) -> None:
        """Call ``task(number, rows)`` for every row block, on all threads."""
        numbers = range(len(self._blocks))
        self.workspace.each(lambda number: task(number, self._blocks[number]), numbers)

    def spread(self, support: Support, pressure: NDArray[Any], visit: Visit) -> None:
        """Show the displacement of the whole map under pressure on some pixels.

        Parameters
        ----------
        support : Support
            The ``n`` loaded pixels.
        pressure : ndarray, shape (n,)
            Pressure on them [Pa].
        visit : callable
            ``visit(number, rows, displacement)`` gets each row block, shape ``(rows, nx)``, from
            one of several threads; the array is only valid during the call.
        """

        def show(number: int, rows: slice, padded: NDArray[Any]) -> None:
            visit(number, rows, padded[:, : self.shape[1]])

        self._apply(support, pressure, show, range(len(self._blocks)))

    def gather(self, support: Support, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the loaded pixels themselves, shape ``(n,)``."""
        displacement = np.empty(support.index.size)
        starts = support.starts

        def show(number: int, rows: slice, padded: NDArray[Any]) -> None:
            part = slice(starts[number], starts[number + 1])
            positions = support.position[part] - rows.start * self.padded[1]
            displacement[part] = padded.ravel()[positions]

        self._apply(support, pressure, show, np.flatnonzero(np.diff(starts)))
        return displacement

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the whole map under a pressure map, shape ``(ny, nx)``."""
        displacement: NDArray[Any] = np.empty(self.shape, self.real)

        def visit(number: int, rows: slice, block: NDArray[Any]) -> None:
            displacement[rows] = block

        index = np.flatnonzero(pressure)
        self.spread(self.support(index), pressure.ravel()[index], visit)
        return displacement

    def approximate_inverse(self) -> Convolution:
        """Return ``displacement / K₀₀ → pressure`` without padding, in single precision.

        The inverse of a circular convolution divides by the spectrum, and every second wave of
        the padded map is a wave of the unpadded one. A wave that the spectrum does not move is
        taken for the softest of the others: one left out could not be inverted under a given
        approach. The buffer is shared: the two operators must not be at work at the same time.
        """
        step = 1 if self.padded == self.shape else 2
        spectrum = self.spectrum[::step, ::step].astype(np.float64)
        spectrum[spectrum <= 0] = spectrum.max()
        np.divide(self.self_displacement, spectrum, out=spectrum)
        return Convolution(
            spectrum,
            self.shape,
            (self.padded[0] // step, self.padded[1] // step),
            workspace=self.workspace,
            precision="single",
        )

    def _apply(
        self,
        support: Support,
        values: NDArray[Any],
        show: Visit,
        shown: Sequence[int] | NDArray[Any],
    ) -> None:
        (my, mx), blocks, starts = self.padded, self._blocks, support.starts
        spectra = self.workspace.shared(self._rows, self._complex)
        scratch_array, each = self.workspace.scratch, self.workspace.each
        half, width = my // 2 + 1, self._rows[1]
        scale = 1 / (my * mx)

        def forward(number: int) -> None:
            rows = blocks[number]
            padded = scratch_array("row", (rows.stop - rows.start, mx), self.real)
            padded[...] = 0
            part = slice(starts[number], starts[number + 1])
            positions = support.position[part] - rows.start * mx
            padded.ravel()[positions] = values[part] * scale
            _rfft_rows(padded, spectra[rows])

        loaded = np.flatnonzero(np.diff(starts))
        each(forward, loaded)
        runs_in = _runs(blocks, loaded)
        runs_out = _runs(blocks, shown)

        def columns(left: int) -> None:
            right = min(left + self._column_step, width)
            scratch = scratch_array("column", (my, right - left), self._complex)
            end = 0
            for rows in runs_in:
                scratch[end : rows.start] = 0
                scratch[rows] = spectra[rows, left:right]
                end = rows.stop
            scratch[end:] = 0
            scratch = _fft_columns(scratch, forward=True)
            symbol = self.spectrum[:, left:right]
            scratch[:half] *= symbol
            scratch[half:] *= symbol[my - half : 0 : -1]
            scratch = _fft_columns(scratch, forward=False)
            for rows in runs_out:
                spectra[rows, left:right] = scratch[rows]

        each(columns, range(0, width, self._column_step))

        def backward(number: int) -> None:
            rows = blocks[number]
            padded = scratch_array("row", (rows.stop - rows.start, mx), self.real)
            show(number, rows, _irfft_rows(spectra[rows], mx, padded))

        each(backward, shown)


class Term(NamedTuple):
    """A kernel of `Responses`.

    Parameters
    ----------
    response : int
        The response that it adds to.
    odd : (bool, bool)
        Whether the kernel is odd in y, and in x; else it is even.
    """

    response: int
    odd: tuple[bool, bool]


@dataclass(frozen=True, eq=False)
class Symbols:
    """The kernels of `Responses` as functions of the wave vector.

    Parameters
    ----------
    highest : (int, int)
        Highest wave numbers along y and x; waves beyond have no response.
    block : callable
        ``block(columns)`` returns an array of shape ``(terms, highest[0] + 1, columns)`` of real
        numbers S that the caller may overwrite, from one of several threads. The transform of a
        term for wave numbers ≥ 0 is S if it is even, -i S if it is odd in one direction, and -S
        if it is odd in both.
    """

    highest: tuple[int, int]
    block: Callable[[slice], NDArray[Any]]


class Responses:
    """Several responses to one real map: sums of circular convolutions with kernels of parity.

    The spectrum of the map is made once; each set of kernels then costs one inverse transform a
    response, and nobody but the visitor keeps a response.

    Parameters
    ----------
    source : ndarray, shape (ny, nx)
        The map.
    padded : (int, int)
        Period ``(my, mx)`` of the convolutions, at least the shape of the map, which is padded
        with zeros.
    terms : sequence of Term
        The kernels; each response has one at least.
    workspace : Workspace
        Threads and memory; no other operator on it may be at work at the same time.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    """

    def __init__(
        self,
        source: NDArray[Any],
        padded: tuple[int, int],
        terms: Sequence[Term],
        *,
        workspace: Workspace,
        precision: str = "single",
    ) -> None:
        self.real: type = np.float32 if precision == "single" else np.float64
        self._complex: type = np.complex64 if precision == "single" else np.complex128
        self.shape: tuple[int, int] = source.shape[0], source.shape[1]
        self.padded, self.terms, self.workspace = padded, tuple(terms), workspace
        self.count = 1 + max(term.response for term in self.terms)
        (ny, _), (my, mx) = self.shape, padded
        self._width = mx // 2 + 1
        itemsize = np.dtype(self._complex).itemsize
        # A block of columns is held four times, a block of rows once for every response.
        self._column_step = max(4, _COLUMN_BYTES // (4 * my * itemsize))
        step = max(1, min(ny, 2 * _ROW_BYTES // (self.count * mx * itemsize // 2)))
        self._rows = [slice(top, min(top + step, ny)) for top in range(0, ny, step)]
        self._samples = np.empty(0, self.real)
        self._spectrum = np.zeros((my, self._width), self._complex)
        workspace.reserve(self.count * ny * self._width * itemsize)
        self._transform(source)

    def sampled(
        self,
        sample: Callable[[NDArray[np.int64], NDArray[np.int64]], Iterable[NDArray[np.float64]]],
        every: tuple[int, int] = (1, 1),
    ) -> Symbols:
        """Return the symbols of kernels that are known at points.

        Parameters
        ----------
        sample : callable
            ``sample(rows, columns)`` gives one kernel after the other at these offsets ≥ 0, in
            steps of ``every``, each of shape ``(columns, rows)``, from one of several threads.
            Periods are even; at half a period, where no offset on the map lies, a kernel may have
            any value.
        every : (int, int)
            Steps along y and x, divisors of half the period. Kernels that are smooth on this
            scale need no more samples: waves beyond are left out.

        Returns
        -------
        Symbols
            Valid until the next call of this method.
        """
        (my, mx), count = self.padded, len(self.terms)
        highest = my // 2 // every[0], mx // 2 // every[1]
        lines = (highest[1] + 1, highest[0] + 1)
        size = count * lines[0] * lines[1]
        if self._samples.size < size:
            self._samples = np.empty(size, self.real)
        samples = self._samples[:size].reshape(count, *lines)
        columns = np.arange(0, mx // 2 + 1, every[1])
        weight = every[0] * every[1]
        step = max(4, _ROW_BYTES // (8 * lines[0]))

        def fill(top: int) -> None:
            bottom = min(top + step, lines[1])
            rows = every[0] * np.arange(top, bottom)
            line = self.workspace.scratch("half line", (lines[0], bottom - top), self.real)
            kernels = sample(rows, columns)
            for number, (term, kernel) in enumerate(zip(self.terms, kernels, strict=True)):
                np.multiply(kernel, weight, out=line, casting="same_kind")
                _half_line_transform(line, term.odd[1])
                samples[number, :, top:bottom] = line

        self.workspace.each(fill, range(0, lines[1], step))

        def block(columns: slice) -> NDArray[Any]:
            size = columns.stop - columns.start
            symbol = self.workspace.scratch("symbol", (count * lines[1], size), self.real)
            symbol = symbol.reshape(count, lines[1], size)
            for number, term in enumerate(self.terms):
                symbol[number] = samples[number, columns].T
                _half_line_transform(symbol[number], term.odd[0])
            return symbol

        return Symbols(highest, block)

    def stream(
        self,
        symbols: Symbols,
        visit: Callable[[slice, NDArray[Any]], None],
        first_row: int = 0,
    ) -> None:
        """Show the responses of the whole map, block by block.

        Parameters
        ----------
        symbols : Symbols
            The kernels.
        visit : callable
            ``visit(rows, responses)`` gets each row block, shape ``(responses, rows, nx)``, from
            one of several threads; the array is only valid during the call.
        first_row : int
            A row of the block to begin with.
        """
        (ny, nx), (_, mx) = self.shape, self.padded
        width = symbols.highest[1] + 1
        spectra = self.workspace.shared((self.count * ny, width), self._complex)
        spectra = spectra.reshape(self.count, ny, width)

        def columns(part: slice) -> None:
            for response, product in self._products(symbols, part):
                spectra[response, :, part] = _fft_columns(product, forward=False)[:ny]

        self.workspace.each(columns, self._columns(width))

        def rows(part: slice) -> None:
            size = part.stop - part.start
            lines = self.workspace.scratch("lines", (self.count * size, _stride(mx)), self.real)
            lines = lines[:, :mx].reshape(self.count, size, mx)
            whole = self.workspace.scratch("whole", (size, self._width), self._complex)
            for line, spectrum in zip(lines, spectra[:, part], strict=True):
                if width == self._width:
                    whole = spectrum
                else:
                    whole[:, :width] = spectrum
                    whole[:, width:] = 0
                inverse = _irfft_rows(whole, mx, line)
                if inverse is not line:
                    line[...] = inverse
            visit(part, lines[:, :, :nx])

        first = first_row // (self._rows[0].stop - self._rows[0].start)
        self.workspace.each(rows, self._rows[first:] + self._rows[:first])

    def cross(self, symbols: Symbols, point: tuple[int, int]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the responses on the row and on the column through one pixel.

        Parameters
        ----------
        symbols : Symbols
            The kernels.
        point : (int, int)
            Row and column of the pixel.

        Returns
        -------
        along_x : ndarray, shape (responses, nx)
            The responses on the row of the pixel.
        along_y : ndarray, shape (responses, ny)
            The responses on its column.
        """
        (ny, nx), (my, mx) = self.shape, self.padded
        row: NDArray[Any] = np.zeros((self.count, self._width), self._complex)
        partial = {}
        wave_y = self._wave(point[0], np.arange(my), my)
        wave_x = self._wave(point[1], np.arange(self._width), mx)
        # Columns other than 0 and Nyquist stand for their mirror images too.
        wave_x[1 : (mx + 1) // 2] *= 2

        def columns(part: slice) -> None:
            column: NDArray[Any] = np.empty((my, self.count), self._complex)
            for response, product in self._products(symbols, part):
                # No matrix product: threads of BLAS would take the cores from the transforms.
                row[response, part] = np.einsum("i,ij->j", wave_y, product)
                column[:, response] = np.einsum("ij,j->i", product, wave_x[part])
            partial[part.start] = column

        self.workspace.each(columns, self._columns(symbols.highest[1] + 1))
        along_x = _irfft_rows(row, mx, np.empty((self.count, mx), self.real))
        total: NDArray[Any] = np.zeros((my, self.count), self._complex)
        for start in sorted(partial):
            total += partial[start]
        along_y = _fft_columns(total, forward=False)
        return along_x[:, :nx], np.ascontiguousarray(along_y[:ny].real.T)

    def _columns(self, width: int) -> list[slice]:
        step = self._column_step
        return [slice(left, min(left + step, width)) for left in range(0, width, step)]

    def _wave(self, position: int, numbers: NDArray[np.int64], period: int) -> NDArray[Any]:
        wave: NDArray[Any] = np.exp(2j * np.pi / period * (position * numbers % period))
        return wave.astype(self._complex)

    def _transform(self, source: NDArray[Any]) -> None:
        (_, nx), (my, mx) = self.shape, self.padded
        scale = 1 / (my * mx)

        def rows(part: slice) -> None:
            line = self.workspace.scratch("lines", (part.stop - part.start, _stride(mx)), self.real)
            line = line[:, :mx]
            np.multiply(source[part], scale, out=line[:, :nx], casting="same_kind")
            line[:, nx:] = 0
            _rfft_rows(line, self._spectrum[part])

        self.workspace.each(rows, self._rows)

        def columns(part: slice) -> None:
            size = part.stop - part.start
            column = self.workspace.scratch("column", (my, size), self._complex)
            column[...] = self._spectrum[:, part]
            self._spectrum[:, part] = _fft_columns(column, forward=True)

        self.workspace.each(columns, self._columns(self._width))

    def _products(self, symbols: Symbols, part: slice) -> Iterator[tuple[int, NDArray[Any]]]:
        """Yield, one after the other, the spectra of the responses on some columns."""
        my, size = self.padded[0], part.stop - part.start
        # Wave numbers 0 to `lower` - 1 come first, the negative ones last.
        lower = symbols.highest[0] + 1
        upper = min(symbols.highest[0], my - lower)
        scratch = self.workspace.scratch
        block = symbols.block(part)
        plain = scratch("plain", (lower + upper, size), self._complex)
        plain[:lower] = self._spectrum[:lower, part]
        plain[lower:] = self._spectrum[my - upper :, part]
        turned = np.multiply(plain, -1j, out=scratch("turned", plain.shape, self._complex))
        product = scratch("column", (my, size), self._complex)
        extra = scratch("term", plain.shape, self._complex)
        for response in range(self.count):
            product[lower : my - upper] = 0
            first = True
            for term, symbol in zip(self.terms, block, strict=True):
                if term.response != response:
                    continue
                base = turned if term.odd[0] != term.odd[1] else plain
                front, back = (
                    (product[:lower], product[my - upper :])
                    if first
                    else (extra[:lower], extra[lower:])
                )
                if all(term.odd):
                    np.negative(symbol, out=symbol)
                np.multiply(base[:lower], symbol, out=front)
                if term.odd[0]:
                    np.negative(symbol, out=symbol)
                np.multiply(base[lower:], symbol[upper:0:-1], out=back)
                if not first:
                    product[:lower] += front
                    product[my - upper :] += back
                first = False
            yield response, product


def _stride(length: int) -> int:
    # Rows a power of two apart share a few lines of the cache: SciPy's and ducc0's transforms of
    # 16 rows at once take four times as long there.
    return length + 16


def _runs(blocks: list[slice], numbers: Iterable[int]) -> list[slice]:
    """Return the rows of some blocks, joined where they touch."""
    runs: list[slice] = []
    for number in numbers:
        rows = blocks[number]
        if runs and runs[-1].stop == rows.start:
            runs[-1] = slice(runs[-1].start, rows.stop)
        else:
            runs.append(rows)
    return runs


def _value_at_origin(spectrum: NDArray[np.float64], padded: tuple[int, int]) -> float:
    """Return the kernel at the origin: the mean of its spectrum over all wave vectors."""
    # Waves of the other quadrants count again; those at 0 and at Nyquist have no other.
    rows = 2 * spectrum.sum(axis=1) - spectrum[:, 0]
    if padded[1] % 2 == 0:
        rows -= spectrum[:, -1]
    total = 2 * rows.sum() - rows[0]
    if padded[0] % 2 == 0:
        total -= rows[-1]
    return float(total) / (padded[0] * padded[1])


def free(
    shape: tuple[int, int],
    pixel: tuple[float, float],
    contact_modulus: float,
    *,
    workers: int | None = None,
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
        E* [Pa].
    workers : int, optional
        Threads; by default one for each core that the process may use.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    workspace : Workspace, optional
        Threads and memory to use instead of new ones.

    Returns
    -------
    Convolution
        Linear convolution with Love's coefficients, exact to rounding by zero padding.
    """
    workspace = workspace or Workspace(workers)
    half = (fast_length(shape[0]), fast_length(shape[1]))
    quadrant = np.empty((half[0] + 1, half[1] + 1))
    band = max(1, min(64, -(-quadrant.shape[0] // workspace.workers)))

    def fill(top: int) -> None:
        rows = quadrant[top : top + band]
        rows[...] = kernels.love(rows.shape, pixel, contact_modulus, first_row=top)

    workspace.each(fill, range(0, quadrant.shape[0], band))
    spectrum = _even_spectrum(quadrant, workspace.workers)
    padded = (2 * half[0], 2 * half[1])
    return Convolution(spectrum, shape, padded, workspace=workspace, precision=precision)


def periodic(
    shape: tuple[int, int],
    pixel: tuple[float, float],
    contact_modulus: float,
    *,
    workers: int | None = None,
    precision: str = "double",
    workspace: Workspace | None = None,
) -> Convolution:
    """Return the operator ``pressure → displacement`` of a periodic half-space.

    Parameters
    ----------
    shape, pixel, contact_modulus, workers, precision, workspace
        As for `free`; the map is one period.

    Returns
    -------
    Convolution
        Circular convolution with the symbol ``2/(E* |q|)``, zero at q = 0.
    """
    symbol = kernels.periodic(shape, pixel, contact_modulus)
    workspace = workspace or Workspace(workers)
    return Convolution(symbol, shape, shape, workspace=workspace, precision=precision)
