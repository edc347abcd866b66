"""Displacement operator of a map whose rows are distributed over several ranks.

Each rank transforms its local rows. Then columns are distributed: each rank receives its columns of
all rows, transforms them along y without communication, and returns them. Rows without load are
neither transformed nor sent. Columns are sent in blocks, the next while one is transformed, so that
the message buffers do not grow with the map; returned columns replace those that were sent.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.ranks import PendingExchange, Ranks
from roughcontact.errors import require_pixel, require_positive
from roughcontact.halfspace import fft
from roughcontact.halfspace.coating import Coatings
from roughcontact.halfspace.convolution import (
    BAND,
    MIN_BLOCK_GAP,
    Found,
    LocalSums,
    Part,
    Visit,
    free_rows,
    join_blocks,
    multiply_columns,
    periodic_symbol,
    strip_rows,
)
from roughcontact.halfspace.fft import Workspace

Array = NDArray[np.float64]

MAX_MESSAGE_BYTES = 1 << 23
"""Bytes of the columns of all rows that one rank transforms at a time."""

# Rows that one thread copies at a time.
_ROWS = 512


class SlabSums:
    """Sums and extremes over all pixels of a map on several ranks.

    Ranks exchange their partial results, and sum them in the same order.

    Parameters
    ----------
    ranks : Ranks
        Ranks that hold the map.
    """

    def __init__(self, ranks: Ranks) -> None:
        self.ranks, self._here = ranks, LocalSums()

    def size(self, values: NDArray[Any]) -> int:
        """Return the number of values."""
        return int(self.ranks.allreduce_scalar(values.size))

    def total(self, values: NDArray[Any]) -> float:
        """Return the sum of the values."""
        return self.ranks.allreduce_scalar(self._here.total(values))

    def dot(self, first: Array, second: Array) -> float:
        """Return the inner product of two vectors."""
        return self.ranks.allreduce_scalar(self._here.dot(first, second))

    def count(self, chosen: NDArray[np.bool_]) -> int:
        """Return the number of true values."""
        return int(self.ranks.allreduce_scalar(self._here.count(chosen)))

    def largest(self, values: NDArray[Any], floor: float = -math.inf) -> float:
        """Return the largest value, or ``floor`` if none is larger."""
        return float(self.ranks.allgather(self._here.largest(values, floor)).max())

    def smallest(self, values: NDArray[Any], limit: float = math.inf) -> float:
        """Return the smallest value, or ``limit`` if none is smaller."""
        return float(self.ranks.allgather(self._here.smallest(values, limit)).min())

    def allreduce(self, parts: NDArray[Any]) -> NDArray[Any]:
        """Return the entrywise sums over all ranks."""
        return self.ranks.allreduce(parts)

    def run_on_all(self, task: Callable[[], Found]) -> Found:
        """Return the local result of a task, or raise an error of one rank on all ranks."""
        return self.ranks.run_on_all(task)

    def next_rows(self, rows: NDArray[Any]) -> NDArray[Any]:
        """Return the corresponding rows of the next rank, cyclically."""
        return self.ranks.shift(rows)

    def thread_count(self) -> int:
        """Return the number of threads of this rank: its share of the cores of its node."""
        return max(1, fft.default_workers() // self.ranks.node_size())

    def communication_cost(self) -> Array:
        """Return communication time [s] and bytes sent so far, averaged over all ranks."""
        return self.allreduce(np.array([self.ranks.seconds, self.ranks.sent])) / self.ranks.count


@dataclass(frozen=True)
class Layout:
    """Distribution of the rows and the waves of a map over ranks.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the map.
    padded : (int, int)
        Period of the convolution.
    edges : tuple of int
        First row of each rank, and ``ny``.
    columns : tuple of int
        First wave along x of each rank, and their number.
    """

    shape: tuple[int, int]
    padded: tuple[int, int]
    edges: tuple[int, ...]
    columns: tuple[int, ...]

    def rows(self, rank: int) -> slice:
        """Return the rows of a rank."""
        return slice(self.edges[rank], self.edges[rank + 1])

    def waves(self, rank: int, block: slice = slice(None)) -> slice:
        """Return the columns of a rank, or one block of them."""
        first, last = self.columns[rank], self.columns[rank + 1]
        if block.stop is None:
            return slice(first, last)
        return slice(min(first + block.start, last), min(first + block.stop, last))


@dataclass(frozen=True, eq=False)
class SlabSupport:
    """Selected local pixels of a map, and the rows of all ranks with selected pixels.

    Parameters
    ----------
    index, position, starts
        As for `roughcontact.halfspace.convolution.Support`, on this rank.
    runs : tuple of list of slice
        Rows of the row blocks of each rank with selected pixels, with adjacent blocks joined.
    """

    index: NDArray[np.int64]
    position: NDArray[np.int64]
    starts: NDArray[np.int64]
    runs: tuple[list[slice], ...]


class SlabConvolution:
    """`Convolution` of a map on several ranks, with the operator protocol of the solvers.

    Parameters
    ----------
    spectrum : ndarray, shape (my//2 + 1, columns)
        Transform of the kernel for the local waves along x.
    layout : Layout
        Distribution over the ranks.
    ranks : Ranks
        Ranks that hold the map.
    workspace : Workspace
        Threads and memory of this rank.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    softness : float
        Factor of the spectrum.
    self_displacement : float, optional
        K₀₀ [m/Pa]; by default computed from the spectrum.
    """

    periodic_axes = (True, True)

    def __init__(
        self,
        spectrum: NDArray[Any],
        layout: Layout,
        ranks: Ranks,
        workspace: Workspace,
        *,
        precision: str = "double",
        softness: float = 1.0,
        self_displacement: float | None = None,
    ) -> None:
        self.real: type = np.float32 if precision == "single" else np.float64
        self._complex: type = np.complex64 if precision == "single" else np.complex128
        self.layout, self.ranks, self.workspace = layout, ranks, workspace
        self.shape, self.sums = layout.shape, SlabSums(ranks)
        self.rows = layout.rows(ranks.number)
        if self_displacement is None:
            columns = layout.waves(ranks.number)
            part = _part_at_origin(spectrum, layout.padded, columns)
            self_displacement = softness * ranks.allreduce_scalar(part)
        self.self_displacement = self_displacement
        self.spectrum = spectrum.astype(self.real, copy=False)
        self.surface: NDArray[Any] | None = None
        self.softness = softness
        itemsize = np.dtype(self._complex).itemsize
        workspace.reserve(self._local_shape[0] * self._local_shape[1] * itemsize)
        (my, mx), (ny, _) = layout.padded, layout.shape
        self._step = max(1, min(ny, fft.ROW_BYTES // (mx * itemsize // 2)))
        self._blocks = cut_up(self._height, self._step)
        self._column_step = max(4, fft.COLUMN_BYTES // (my * itemsize))
        widest = max(np.diff(layout.columns))
        travelling = max(self._column_step, MAX_MESSAGE_BYTES // (ny * itemsize))
        self._travels = cut_up(int(widest), int(travelling))

    @property
    def is_long_wave_soft(self) -> bool:
        """Whether long waves are far more compliant than short ones; see `Convolution`."""
        return self.surface is not None

    @property
    def _height(self) -> int:
        return _height([self.rows])

    @property
    def _local_shape(self) -> tuple[int, int]:
        return self._height, self.layout.columns[-1]

    def support(self, index: NDArray[np.int64]) -> SlabSupport:
        """Return the support of local pixels with these ascending flat indices."""
        nx, mx = self.shape[1], self.layout.padded[1]
        tops = [rows.start * nx for rows in self._blocks] + [self._height * nx]
        position = index
        if mx > nx:
            position = index // nx
            position *= mx - nx
            position += index
        starts = np.searchsorted(index, tops)
        blocks = [cut_up(int(height), self._step) for height in np.diff(self.layout.edges)]
        loaded = np.diff(starts).astype(bool).view(np.uint8)
        everyone = self.ranks.allgatherv(loaded, [len(own) for own in blocks])
        runs, place = [], 0
        for first, own in zip(self.layout.edges, blocks, strict=False):
            numbers = np.flatnonzero(everyone[place : place + len(own)])
            place += len(own)
            runs.append([_copy_block(rows, first) for rows in join_blocks(own, numbers)])
        return SlabSupport(index, position, starts, tuple(runs))

    def each_block(self, task: Callable[[int, slice], None]) -> None:
        """Call ``task(number, rows)`` for every row block of this rank, on all its threads."""
        numbers = range(len(self._blocks))
        self.workspace.each(lambda number: task(number, self._blocks[number]), numbers)

    def spread(self, support: SlabSupport, pressure: NDArray[Any], visit: Visit) -> None:
        """Pass the displacement of the local rows to a callback; see `Convolution.spread`."""

        def crop_rows(number: int, rows: slice, padded: NDArray[Any]) -> None:
            visit(number, rows, padded[:, : self.shape[1]])

        everything = tuple([self.layout.rows(rank)] for rank in range(self.ranks.count))
        self._apply(support, pressure, crop_rows, range(len(self._blocks)), everything)

    def gather(self, support: SlabSupport, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the local loaded pixels."""
        displacement = np.empty(support.index.size)
        starts = support.starts

        def gather_rows(number: int, rows: slice, padded: NDArray[Any]) -> None:
            part = slice(starts[number], starts[number + 1])
            positions = support.position[part] - rows.start * self.layout.padded[1]
            displacement[part] = padded.ravel()[positions]

        self._apply(support, pressure, gather_rows, np.flatnonzero(np.diff(starts)), support.runs)
        return displacement

    def __call__(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of a small map that every rank holds completely."""
        displacement: NDArray[Any] = np.empty((self._height, self.shape[1]), self.real)

        def visit(number: int, rows: slice, block: NDArray[Any]) -> None:
            displacement[rows] = block

        here = pressure[self.rows]
        index = np.flatnonzero(here)
        self.spread(self.support(index), here.ravel()[index], visit)
        return self.ranks.allgatherv(displacement, np.diff(self.layout.edges).tolist())

    def to_single_precision(self) -> SlabConvolution:
        """Return the operator in single precision; the same object if it already is."""
        if self.real is np.float32:
            return self
        single = SlabConvolution(
            self.spectrum,
            self.layout,
            self.ranks,
            self.workspace,
            precision="single",
            softness=self.softness,
            self_displacement=self.self_displacement,
        )
        single.surface = self.surface
        return single

    def approximate_inverse(self) -> SlabConvolution:
        """Return ``displacement / K₀₀ → pressure``; see `Convolution.approximate_inverse`.

        Each wave along x is on the rank that holds the nearest wave of the padded map.
        """
        layout = self.layout
        period = [
            points if long == points else 2 * fft.fast_length(points // 2 + MIN_BLOCK_GAP)
            for points, long in zip(self.shape, layout.padded, strict=True)
        ]
        waves_y, waves_x = (
            np.rint(np.arange(short // 2 + 1) * (long / short)).astype(np.int64)
            for short, long in zip(period, layout.padded, strict=True)
        )
        columns = tuple(np.searchsorted(waves_x, layout.columns).tolist())
        inverse = replace(layout, padded=(period[0], period[1]), columns=columns)
        here = waves_x[inverse.waves(self.ranks.number)] - layout.columns[self.ranks.number]
        of = self.spectrum if self.surface is None else self.surface
        spectrum = of[np.ix_(waves_y, here)].astype(np.float64)
        spectrum[spectrum <= 0] = self.sums.largest(spectrum)
        np.divide(self.self_displacement / self.softness, spectrum, out=spectrum)
        return SlabConvolution(spectrum, inverse, self.ranks, self.workspace, precision="single")

    def _apply(
        self,
        support: SlabSupport,
        values: NDArray[Any],
        show: Visit,
        shown: Sequence[int] | NDArray[Any],
        wanted: tuple[list[slice], ...],
    ) -> None:
        (my, mx), blocks, starts = self.layout.padded, self._blocks, support.starts
        spectra = self.workspace.shared(self._local_shape, self._complex)
        scratch_array, each = self.workspace.scratch, self.workspace.each
        scale = self.softness / (my * mx)

        def forward(number: int) -> None:
            rows = blocks[number]
            padded = scratch_array("row", (rows.stop - rows.start, mx), self.real)
            padded[...] = 0
            part = slice(starts[number], starts[number + 1])
            positions = support.position[part] - rows.start * mx
            padded.ravel()[positions] = values[part] * scale
            fft.rfft_rows(padded, spectra[rows])

        each(forward, np.flatnonzero(np.diff(starts)))
        self._columns(spectra, support.runs, wanted)

        def backward(number: int) -> None:
            rows = blocks[number]
            padded = scratch_array("row", (rows.stop - rows.start, mx), self.real)
            show(number, rows, fft.irfft_rows(spectra[rows], mx, padded))

        each(backward, shown)

    def _columns(
        self,
        spectra: NDArray[Any],
        loaded: tuple[list[slice], ...],
        wanted: tuple[list[slice], ...],
    ) -> None:
        """Replace the spectra of the rows by the spectra of their displacement."""
        returning: PendingExchange | None = None
        ahead = self._send(spectra, loaded, 0)
        for number in range(len(self._travels)):
            arriving = ahead
            if number + 1 < len(self._travels):
                ahead = self._send(spectra, loaded, number + 1)
            answer = self._answer(spectra, arriving, loaded, wanted, number)
            if returning is not None:
                self._store_returned(spectra, returning, wanted, number - 1)
            returning = answer
        assert returning is not None
        self._store_returned(spectra, returning, wanted, len(self._travels) - 1)

    def _send(
        self, spectra: NDArray[Any], loaded: tuple[list[slice], ...], number: int
    ) -> PendingExchange:
        """Send the loaded rows of a block of columns to the ranks that transform them."""
        block, me = self._travels[number], self.ranks.number
        own = loaded[me]
        widths = [self._width(rank, block) for rank in range(self.ranks.count)]
        parts = [_height(own) * width * (rank != me) for rank, width in enumerate(widths)]
        sizes = [_height(rows) * widths[me] * (rank != me) for rank, rows in enumerate(loaded)]
        outgoing = self._memory("sent", number, sum(parts))
        copies, index = [], 0
        for rank in (rank for rank in range(self.ranks.count) if rank != me):
            columns = self.layout.waves(rank, block)
            for rows in own:
                part, index = _cut(outgoing, index, rows, widths[rank])
                copies += _pieces(part, spectra[self._local_rows(rows), columns])
        self._copy(copies)
        return self.ranks.exchange(
            outgoing, parts, self._memory("coming", number, sum(sizes)), sizes
        )

    def _answer(
        self,
        spectra: NDArray[Any],
        arriving: PendingExchange,
        loaded: tuple[list[slice], ...],
        wanted: tuple[list[slice], ...],
        number: int,
    ) -> PendingExchange:
        """Transform the columns of a block, multiply, transform back, and send the rows back."""
        block, me = self._travels[number], self.ranks.number
        columns, width = self.layout.waves(me, block), self._width(me, block)
        parts = [_height(rows) * width * (rank != me) for rank, rows in enumerate(wanted)]
        back = self._memory("back", number, sum(parts))
        coming = self._shares(spectra, loaded, columns, arriving.wait())
        outgoing = self._shares(spectra, wanted, columns, np.split(back, np.cumsum(parts)[:-1]))
        my, first = self.layout.padded[0], columns.start - self.layout.columns[me]

        def transform(start: int) -> None:
            block = slice(start, min(start + self._column_step, width))
            multiply_columns(
                [(rows, part[:, block]) for rows, part in coming],
                [(rows, part[:, block]) for rows, part in outgoing],
                self.spectrum[:, first + block.start : first + block.stop],
                self.workspace.scratch("column", (my, block.stop - block.start), self._complex),
            )

        self.workspace.each(transform, range(0, width, self._column_step))
        own = _height(wanted[me])
        sizes = [own * self._width(rank, block) * (rank != me) for rank in range(len(parts))]
        return self.ranks.exchange(back, parts, self._memory("taken", number, sum(sizes)), sizes)

    def _store_returned(
        self,
        spectra: NDArray[Any],
        returning: PendingExchange,
        wanted: tuple[list[slice], ...],
        number: int,
    ) -> None:
        """Store the returned columns of a block in the local rows."""
        block, me, copies = self._travels[number], self.ranks.number, []
        for rank, part in enumerate(returning.wait()):
            columns, width, index = self.layout.waves(rank, block), self._width(rank, block), 0
            for rows in wanted[me] if rank != me else ():
                piece, index = _cut(part, index, rows, width)
                copies += _pieces(spectra[self._local_rows(rows), columns], piece)
        self._copy(copies)

    def _shares(
        self,
        spectra: NDArray[Any],
        runs: tuple[list[slice], ...],
        columns: slice,
        parts: list[NDArray[Any]],
    ) -> list[Part]:
        """Return the rows of some columns, from received buffers or from local memory."""
        result: list[Part] = []
        width = columns.stop - columns.start
        for rank, (own, part) in enumerate(zip(runs, parts, strict=True)):
            index = 0
            for rows in own:
                if rank == self.ranks.number:
                    result.append((rows, spectra[self._local_rows(rows), columns]))
                    continue
                piece, index = _cut(part, index, rows, width)
                result.append((rows, piece))
        return result

    def _width(self, rank: int, block: slice) -> int:
        return _height([self.layout.waves(rank, block)])

    def _local_rows(self, rows: slice) -> slice:
        """Return the local indices of rows of the map."""
        return _copy_block(rows, -self.rows.start)

    def _memory(self, name: str, number: int, size: int) -> NDArray[Any]:
        """Return a message buffer; the buffer of the previous block is still in use."""
        return self.workspace.scratch(f"{name}{number % 2}", (1, size), self._complex)[0]

    def _copy(self, copies: list[tuple[NDArray[Any], NDArray[Any]]]) -> None:
        self.workspace.each(lambda pair: np.copyto(*pair), copies)


def cut_up(points: int, step: int) -> list[slice]:
    """Return slices of equal size; the last one may be shorter."""
    return [slice(first, min(first + step, points)) for first in range(0, points, step)]


def _copy_block(rows: slice, by: int) -> slice:
    return slice(rows.start + by, rows.stop + by)


def _height(runs: Sequence[slice]) -> int:
    return sum(rows.stop - rows.start for rows in runs)


def _cut(flat: NDArray[Any], index: int, rows: slice, width: int) -> tuple[NDArray[Any], int]:
    """Return the part of a message for some rows, and the start of the next part."""
    height = rows.stop - rows.start
    end = index + height * width
    return flat[index:end].reshape(height, width), end


def _pieces(target: NDArray[Any], source: NDArray[Any]) -> list[tuple[NDArray[Any], NDArray[Any]]]:
    """Return pairs of row blocks to copy, for several threads."""
    return [(target[rows], source[rows]) for rows in cut_up(len(source), _ROWS)]


def _part_at_origin(spectrum: Array, padded: tuple[int, int], columns: slice) -> float:
    """Return the contribution of some waves along x to the kernel at the origin."""
    # Waves have mirrors in the other quadrants, except at 0 and at Nyquist.
    weights = []
    for points, waves in zip(padded, (slice(0, padded[0] // 2 + 1), columns), strict=True):
        number = np.arange(waves.start, waves.stop)
        weights.append(np.where((number == 0) | (2 * number == points), 1.0, 2.0))
    lines = np.einsum("ij,i->j", spectrum, weights[0])
    return float(np.einsum("j,j->", lines, weights[1])) / (padded[0] * padded[1])


# Factory of displacement operators of a map on several ranks: each computes its local waves.


def operators(
    symbol: Callable[..., tuple[Array, float]],
    free_axes: Sequence[int],
    datum: float,
    edges: Sequence[int],
    shape: tuple[int, int],
    pixel: tuple[float, float],
    contact_modulus: float,
    ranks: Ranks,
    *,
    coatings: Coatings | None = None,
    precision: str = "double",
    workspace: Workspace,
) -> Callable[[tuple[int, int], tuple[int, int]], SlabConvolution]:
    """Return a factory of the operators of a map on several ranks, and of coarser grids.

    Parameters
    ----------
    symbol : callable
        ``symbol(grid)`` returns the share of a rank: `free`, `periodic`, `strip_x` or `strip_y`.
    free_axes : sequence of int
        Axes along which the map ends at its edges.
    datum : float
        Distance at which the displacement of strips is zero [m].
    edges : sequence of int
        First row of each rank, and ``ny``; divided by the coarsening on coarser grids, exactly if
        they are multiples.
    shape : (int, int)
        Grid points ``(ny, nx)`` of the whole map.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    contact_modulus : float
        E* [Pa].
    ranks : Ranks
        Ranks that hold the map.
    coatings : Coatings, optional
        Coatings of the bodies.
    precision : {"double", "single"}
        Arithmetic on the grid of the map.
    workspace : Workspace
        Threads and memory of this rank.

    Returns
    -------
    callable
        ``operator(shape, (ky, kx))`` as required by `bounded.solve`; a collective call.
    """
    require_pixel(pixel)
    require_positive(contact_modulus=contact_modulus)

    def operator(shape: tuple[int, int], coarsening: tuple[int, int]) -> SlabConvolution:
        coarse = (coarsening[0] * pixel[0], coarsening[1] * pixel[1])
        rows = (*(edge // coarsening[0] for edge in edges[:-1]), shape[0])
        padded = _period(free_axes, shape)
        waves = padded[1] // 2 + 1
        columns = _distribute_lines(waves, ranks.count)
        layout = Layout(shape, padded, rows, columns)
        grid = Grid(layout, coarse, datum, coatings, ranks, workspace)
        own, softness = symbol(grid)
        result = SlabConvolution(
            own,
            layout,
            ranks,
            workspace,
            # On coarse grids the discretization error exceeds the rounding error.
            precision=precision if coarsening == (1, 1) else "single",
            softness=softness / contact_modulus,
        )
        if coatings is not None and coatings.is_long_wave_soft:
            result.surface = symbol(grid._replace(coatings=None))[0]
        return result

    return operator


def _distribute_lines(lines: int, count: int) -> tuple[int, ...]:
    """Return the first line of each rank, and their number."""
    return tuple(lines * rank // count for rank in range(count + 1))


def _period(free_axes: Sequence[int], shape: tuple[int, int]) -> tuple[int, int]:
    ny, nx = (
        2 * fft.fast_length(points) if axis in free_axes else points
        for axis, points in enumerate(shape)
    )
    return ny, nx


# Part of the symbol on this rank: the local columns, for E* = 1 Pa and without the factor.


class Grid(NamedTuple):
    """Grid of an operator on several ranks."""

    layout: Layout
    pixel: tuple[float, float]  # Edges (dy, dx) [m]
    datum: float  # Distance at which the displacement of strips is zero [m]
    coatings: Coatings | None
    ranks: Ranks
    workspace: Workspace


def free(grid: Grid) -> tuple[Array, float]:
    """Return the local share of the symbol of a free map, and its factor."""
    layout, pixel, _, coatings, ranks, work = grid
    points, width = layout.padded[0] // 2 + 1, layout.padded[1] // 2 + 1
    bands = -(-points // BAND)
    tops = [min(BAND * (bands * rank // ranks.count), points) for rank in range(ranks.count)]
    tops.append(points)
    first, last = tops[ranks.number : ranks.number + 2]
    quadrant = np.empty((last - first, width))
    reach = math.hypot(points * pixel[0], width * pixel[1])
    tables = [] if coatings is None else coatings.tables(reach)

    def fill(top: int) -> None:
        rows = quadrant[top : top + BAND]
        rows[...] = free_rows(rows.shape, pixel, first + top, coatings, tables)

    work.each(fill, range(0, last - first, BAND))
    fft.even_spectrum(quadrant, work, axes=(1,))
    symbol = _transpose_columns(quadrant, tops, layout.columns, ranks)
    return fft.even_spectrum(symbol, work, axes=(0,)), pixel[0]


def periodic(grid: Grid) -> tuple[Array, float]:
    """Return the local share of the symbol of a periodic map, and its factor."""
    waves = grid.layout.waves(grid.ranks.number)
    return periodic_symbol(grid.layout.shape, grid.pixel, 1.0, grid.coatings, waves), 1.0


def strip_x(grid: Grid) -> tuple[Array, float]:
    """Return the local share of the symbol of a strip along x, and its factor."""
    shape = (grid.layout.padded[0] // 2 + 1, grid.layout.padded[1])
    own = grid.layout.waves(grid.ranks.number)
    table = strip_rows(shape, grid.pixel, grid.datum, own, grid.coatings)
    return fft.even_spectrum(table, grid.workspace, axes=(0,)), grid.pixel[0]


def strip_y(grid: Grid) -> tuple[Array, float]:
    """Return the local share of the symbol of a strip along y, and its factor."""
    layout, ranks = grid.layout, grid.ranks
    # The kernel has x as the periodic axis.
    shape = (layout.padded[1] // 2 + 1, layout.padded[0])
    waves = layout.padded[0] // 2 + 1
    tops = _distribute_lines(waves, ranks.count)
    own = slice(tops[ranks.number], tops[ranks.number + 1])
    table = strip_rows(shape, grid.pixel[::-1], grid.datum, own, grid.coatings)
    rows = fft.even_spectrum(np.ascontiguousarray(table.T), grid.workspace, axes=(1,))
    return _transpose_columns(rows, tops, layout.columns, ranks), grid.pixel[1]


def _transpose_columns(
    rows: Array, tops: Sequence[int], columns: Sequence[int], ranks: Ranks
) -> Array:
    """Return all rows of the local columns from the local rows of all columns."""
    me = ranks.number
    first, last = columns[me], columns[me + 1]
    result = np.empty((tops[-1], last - first))
    step = max(1, MAX_MESSAGE_BYTES // (8 * tops[-1]))
    for block in cut_up(int(max(np.diff(columns))), step):
        parts = [
            rows[:, min(start + block.start, end) : min(start + block.stop, end)].ravel()
            for start, end in pairwise(columns)
        ]
        index = slice(min(block.start, last - first), min(block.stop, last - first))
        sizes = [height * (index.stop - index.start) for height in np.diff(tops).tolist()]
        outgoing = np.concatenate(parts)
        exchange = ranks.exchange(
            outgoing, [part.size for part in parts], np.empty(sum(sizes)), sizes
        )
        for top, bottom, part in zip(tops, tops[1:], exchange.wait(), strict=False):
            result[top:bottom, index] = part.reshape(bottom - top, index.stop - index.start)
    return result
