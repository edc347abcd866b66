"""Several responses of a half-space to one map, each the sum of a few convolutions.

The kernels of stress are even or odd along each axis; they are sampled, or known as symbols, and
their responses are seen row block by row block as a `Convolution` shows its displacement.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace import fft
from roughcontact.halfspace.fft import Workspace


class Term(NamedTuple):
    """A kernel of `Responses`.

    Parameters
    ----------
    odd : (bool, bool)
        Whether the kernel is odd in y, and in x; else it is even.
    shares : sequence of (int, float)
        The responses that it adds to, with factors.
    """

    odd: tuple[bool, bool]
    shares: Sequence[tuple[int, float]]


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
        self.count = 1 + max(response for term in self.terms for response, _ in term.shares)
        (ny, _), (my, mx) = self.shape, padded
        self._width = mx // 2 + 1
        itemsize = np.dtype(self._complex).itemsize
        # A block of columns is held about four times, of rows once for every response.
        self._column_step = max(4, fft.COLUMN_BYTES // (4 * my * itemsize))
        step = max(1, min(ny, 2 * fft.ROW_BYTES // (self.count * mx * itemsize // 2)))
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
        step = max(4, fft.ROW_BYTES // (8 * lines[0]))

        def fill(top: int) -> None:
            bottom = min(top + step, lines[1])
            rows = every[0] * np.arange(top, bottom)
            line = self.workspace.scratch("half line", (lines[0], bottom - top), self.real)
            kernels = sample(rows, columns)
            for number, (term, kernel) in enumerate(zip(self.terms, kernels, strict=True)):
                np.multiply(kernel, weight, out=line, casting="same_kind")
                fft.half_line_transform(line, term.odd[1])
                samples[number, :, top:bottom] = line

        self.workspace.each(fill, range(0, lines[1], step))

        def block(columns: slice) -> NDArray[Any]:
            size = columns.stop - columns.start
            symbol = self.workspace.scratch("symbol", (count * lines[1], size), self.real)
            symbol = symbol.reshape(count, lines[1], size)
            for number, term in enumerate(self.terms):
                symbol[number] = samples[number, columns].T
                fft.half_line_transform(symbol[number], term.odd[0])
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
                spectra[response, :, part] = fft.fft_columns(product, forward=False)[:ny]

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
                inverse = fft.irfft_rows(whole, mx, line)
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
        along_x = fft.irfft_rows(row, mx, np.empty((self.count, mx), self.real))
        total: NDArray[Any] = np.zeros((my, self.count), self._complex)
        for start in sorted(partial):
            total += partial[start]
        along_y = fft.fft_columns(total, forward=False)
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
            fft.rfft_rows(line, self._spectrum[part])

        self.workspace.each(rows, self._rows)

        def columns(part: slice) -> None:
            size = part.stop - part.start
            column = self.workspace.scratch("column", (my, size), self._complex)
            column[...] = self._spectrum[:, part]
            self._spectrum[:, part] = fft.fft_columns(column, forward=True)

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
        extra = scratch("extra", plain.shape, self._complex)
        for response in range(self.count):
            product[lower : my - upper] = 0
            front, back = product[:lower], product[my - upper :]
            added = False
            for base, mixed in ((plain, False), (turned, True)):
                symbol = self._symbol(block, response, mixed)
                if symbol is None:
                    continue
                to = (extra[:lower], extra[lower:]) if added else (front, back)
                np.multiply(base[:lower], symbol[0], out=to[0])
                np.multiply(base[lower:], symbol[1][upper:0:-1], out=to[1])
                if added:
                    front += to[0]
                    back += to[1]
                added = True
            yield response, product

    def _symbol(
        self, block: NDArray[Any], response: int, mixed: bool
    ) -> tuple[NDArray[Any], NDArray[Any]] | None:
        """Return what a response does to waves of q_y ≥ 0 and < 0, each from q_y = 0 on.

        By its kernels that are odd in one direction, or by the others; None without any.
        """
        even, odd = (
            self._sum(
                [
                    (symbol, -factor if all(term.odd) else factor)
                    for term, symbol in zip(self.terms, block, strict=True)
                    for number, factor in term.shares
                    if number == response and term.odd == (in_y, in_y != mixed)
                ],
                f"odd {in_y}",
            )
            for in_y in (False, True)
        )
        if odd is None:
            return None if even is None else (even, even)
        back = self.workspace.scratch("behind", (odd.shape[0], odd.shape[1]), block.dtype.type)
        if even is None:
            return odd, np.negative(odd, out=back)
        np.subtract(even, odd, out=back)
        front = self.workspace.scratch("ahead", (odd.shape[0], odd.shape[1]), block.dtype.type)
        return np.add(even, odd, out=front), back

    def _sum(self, shares: list[tuple[NDArray[Any], float]], name: str) -> NDArray[Any] | None:
        """Return the sum of arrays times factors; None without any."""
        if not shares:
            return None
        first, factor = shares[0]
        if len(shares) == 1 and factor == 1:
            return first
        total = self.workspace.scratch(name, (first.shape[0], first.shape[1]), first.dtype.type)
        share = self.workspace.scratch("share", total.shape, first.dtype.type)
        np.multiply(first, factor, out=total)
        for symbol, factor in shares[1:]:
            total += np.multiply(symbol, factor, out=share)
        return total


def _stride(length: int) -> int:
    # Rows a power of two apart share a few lines of the cache: SciPy's and ducc0's transforms of
    # 16 rows at once take four times as long there.
    return length + 16
