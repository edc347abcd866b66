"""FFT, its threads and work memory: the only module that calls FFT libraries of the processor.

ducc0, or SciPy if ducc0 is not installed, transforms maps for the displacement and the stress of a
half-space, in blocks of rows or columns, each on one thread of a `Workspace`. The processing of
surfaces uses `rfft`, `rfft2` and similar functions, which are always NumPy's: a filtered map does
not depend on the installed packages, and SciPy, with bitwise equal results, takes a quarter of a
second to import.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Shape

Norm = Literal["backward", "forward"]

try:
    import ducc0 as _ducc0
except ImportError:
    _ducc0 = None

# Bytes that one thread transforms at a time: a typical second-level cache for columns, which are
# read twice and transformed twice, and half of it for rows.
COLUMN_BYTES = 1 << 20
ROW_BYTES = 1 << 19
# Lines that a library may transform together; blocks of lines are a multiple of this number.
_LINES = 8


# Set only by `limit_threads`, for the calls in its block.
_thread_limit: ContextVar[int | None] = ContextVar("most", default=None)


def default_workers() -> int:
    """Return the number of processor cores that this process may use; see `limit_threads`."""
    result = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return min(result or 1, _thread_limit.get() or result or 1)


@contextmanager
def limit_threads(threads: int) -> Iterator[None]:
    """Limit the number of threads in the block, for this thread.

    Parameters
    ----------
    threads : int
        Maximum number of threads; the other cores are left to other tasks.
    """
    token = _thread_limit.set(threads)
    try:
        yield
    finally:
        _thread_limit.reset(token)


# SciPy's FFT is imported lazily: it would take most of the time of `import roughcontact`.


def rfft_rows(rows: NDArray[Any], out: NDArray[Any]) -> None:
    """Transform real rows into their half spectra."""
    if _ducc0 is not None:
        _ducc0.fft.r2c(rows, axes=(1,), out=out, nthreads=1)
        return
    import scipy.fft

    out[...] = scipy.fft.rfft(rows, axis=1, workers=1)


def irfft_rows(spectrum: NDArray[Any], length: int, out: NDArray[Any]) -> NDArray[Any]:
    """Return the unnormalized inverse of `rfft_rows`, in ``out`` if supported."""
    if _ducc0 is not None:
        _ducc0.fft.c2r(
            spectrum,
            axes=(1,),
            lastsize=length,
            forward=False,
            out=out,
            nthreads=1,
            allow_overwriting_input=True,
        )
        return out
    import scipy.fft

    return scipy.fft.irfft(spectrum, length, axis=1, norm="forward", overwrite_x=True, workers=1)


def fft_columns(columns: NDArray[Any], forward: bool) -> NDArray[Any]:
    """Return the transform along axis 0, in place if supported; inverse unnormalized."""
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


def half_line_transform(columns: NDArray[Any], odd: bool) -> None:
    """Transform even or odd sequences, given over half a period, in place along axis 0.

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
    """Return the period of a zero-padded map without an effect of its periodic images.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.

    Returns
    -------
    (int, int)
        Even lengths, at least twice the shape, with fast transforms.
    """
    return 2 * fast_length(shape[0]), 2 * fast_length(shape[1])


def half_spectrum(
    values: NDArray[Any], rows: slice, padded: Shape, out: NDArray[Any]
) -> NDArray[Any]:
    """Return the half spectrum of a real map padded with zeros.

    Parameters
    ----------
    values : ndarray, shape (ny, nx)
        The map.
    rows : slice
        Nonzero rows of the map; the others are not read.
    padded : (int, int)
        Points ``(my, mx)`` of the transform.
    out : ndarray of complex, shape (my, mx//2 + 1)
        Memory for the result.

    Returns
    -------
    ndarray of complex, shape (my, mx//2 + 1)
        The sum over the map times ``exp(-i(qy·y + qx·x))`` for qx ≥ 0: ``out`` if the library
        works in place. One thread.
    """
    out[: rows.start] = 0
    out[rows.stop :] = 0
    wide = np.zeros((rows.stop - rows.start, padded[1]), values.dtype)
    wide[:, : values.shape[1]] = values[rows]
    rfft_rows(wide, out[rows])
    return fft_columns(out, forward=True)


def from_half_spectrum(spectrum: NDArray[Any], shape: Shape, padded: Shape) -> NDArray[Any]:
    """Return the first points of the unnormalized inverse transform of a half spectrum.

    Parameters
    ----------
    spectrum : ndarray of complex, shape (my, mx//2 + 1)
        Half spectrum; it is overwritten.
    shape : (int, int)
        Number of points ``(ny, nx)`` to return, from the first.
    padded : (int, int)
        Points ``(my, mx)`` of the transform.

    Returns
    -------
    ndarray, shape (ny, nx)
        ``my·mx`` times the map with this half spectrum. One thread.
    """
    columns = fft_columns(spectrum, forward=False)
    wide = np.empty((shape[0], padded[1]), spectrum.real.dtype)
    return irfft_rows(columns[: shape[0]], padded[1], wide)[:, : shape[1]]


def fast_length(points: int) -> int:
    """Return the smallest length ≥ ``points`` with a fast transform."""
    if _ducc0 is not None:
        return int(_ducc0.fft.good_size(points, True))
    import scipy.fft

    return int(scipy.fft.next_fast_len(points, real=True))


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
        """Call a task for every item, on all threads including the calling one."""
        items = list(items)
        # One iterator for all: an idle thread takes the next item, and nothing is queued.
        remaining = iter(items)

        def work() -> None:
            for item in remaining:
                task(item)

        # Operators made by an item are on the device of the caller.
        number = min(self.workers, len(items)) - 1
        helpers = [self._pool.submit(copy_context().run, work) for _ in range(number)]
        try:
            work()
        finally:
            # A thread that has not started yet is cancelled: no item is left.
            # result() raises an error of a thread in the caller.
            for helper in helpers:
                if not helper.cancel():
                    helper.result()

    def reserve(self, size: int) -> None:
        """Ensure that `shared_array` arrays of this total size need no new memory."""
        if self._memory.size < size:
            self._memory = np.empty(size, np.uint8)

    def shared_array(self, shape: Shape, dtype: type) -> NDArray[Any]:
        """Return the array that all operators share; its content is undefined."""
        size = shape[0] * shape[1] * np.dtype(dtype).itemsize
        self.reserve(size)
        return self._memory[:size].view(dtype).reshape(shape)

    def scratch(self, name: str, shape: Shape, dtype: type) -> NDArray[Any]:
        """Return a reused array of this thread: new memory costs a page fault per 4 KiB."""
        size = shape[0] * shape[1] * np.dtype(dtype).itemsize
        memory = getattr(self._local, name, None)
        if memory is None or memory.size < size:
            memory = np.empty(size, np.uint8)
            setattr(self._local, name, memory)
        return memory[:size].view(dtype).reshape(shape)


def quadrant_spectrum(
    quadrant: Array, workspace: Workspace, axes: tuple[int, ...] = (0, 1), odd: bool = False
) -> Array:
    """Return the transform of an array that is even or odd along axes, both as one quadrant.

    In place, on all threads of the workspace, in blocks that do not depend on the number of
    threads: a library that distributes the lines itself transforms several lines together, and the
    remaining lines of each share get other last digits.
    """
    for axis in axes:
        lines = quadrant if axis == 0 else quadrant.T
        step = max(_LINES, COLUMN_BYTES // (8 * len(lines)) // _LINES * _LINES)

        def transform(start: int, lines: Array = lines, step: int = step) -> None:
            half_line_transform(lines[:, start : start + step], odd)

        workspace.each(transform, range(0, lines.shape[1], step))
    return quadrant


# NumPy's transforms, independent of the installed libraries; see the docstring of this module.


rfft, irfft = np.fft.rfft, np.fft.irfft
"""Transform of real values along an axis, and its inverse for a number of points."""


def ifft(
    spectrum: NDArray[np.complex128], axis: int = -1, norm: Norm = "backward"
) -> NDArray[np.complex128]:
    """Return the inverse transform of complex values along an axis, in place."""
    return np.fft.ifft(spectrum, axis=axis, norm=norm, out=spectrum)


def rfft2(values: Array) -> NDArray[np.complex128]:
    """Return the transform of a real map."""
    # Axis by axis, because `numpy.fft.rfft2` holds two spectra.
    spectrum = np.fft.rfft(values)
    return np.fft.fft(spectrum, axis=0, out=spectrum)


def irfft2(spectrum: NDArray[np.complex128], shape: Shape) -> Array:
    """Return the inverse of `rfft2` with a given shape; the spectrum is overwritten."""
    np.fft.ifft(spectrum, axis=0, norm="forward", out=spectrum)
    values = np.fft.irfft(spectrum, n=shape[1], norm="forward")
    # One factor for both axes, bitwise equal to the factor of the library for a whole map.
    values *= float(1 / np.longdouble(shape[0] * shape[1]))
    return values


def frequencies(points: int, spacing: float = 1.0) -> Array:
    """Return the frequencies of a transform, in cycles per unit of ``spacing``."""
    return np.fft.fftfreq(points, spacing).astype(np.float64, copy=False)


def half_frequencies(points: int, spacing: float = 1.0) -> Array:
    """Return the frequencies of the transform of real values, from 0."""
    return np.fft.rfftfreq(points, spacing).astype(np.float64, copy=False)
