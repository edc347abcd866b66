"""Who makes the displacement operators of a map on several ranks: each the waves of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import require_pixel, require_positive
from roughcontact.halfspace import fft, kernels
from roughcontact.halfspace.convolution import BAND
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.slabs import TRAVELLING, Layout, SlabConvolution, cut_up
from roughcontact.ranks import Ranks

Array = NDArray[np.float64]


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
    precision: str = "double",
    workspace: Workspace,
) -> Callable[[tuple[int, int], tuple[int, int]], SlabConvolution]:
    """Return what makes the operator of a map on several ranks, and that of coarser grids.

    Parameters
    ----------
    symbol : callable
        ``symbol(layout, pixel, ranks, workspace, datum)`` makes the share of a rank: `free`,
        `periodic`, `strip_x` or `strip_y`.
    free_axes : sequence of int
        Axes along which the map ends at its edges.
    datum : float
        Where strips take the displacement as zero [m].
    edges : sequence of int
        First row of each rank, and ``ny``; they stay rows on coarser grids where they are
        multiples of the coarsening.
    shape : (int, int)
        Grid points ``(ny, nx)`` of the whole map.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    contact_modulus : float
        E* [Pa].
    ranks : Ranks
        Those that hold the map.
    precision : {"double", "single"}
        Arithmetic on the grid of the map.
    workspace : Workspace
        Threads and memory of this rank.

    Returns
    -------
    callable
        ``operator(shape, (ky, kx))`` as `bounded.solve` wants it; all ranks call it together.
    """
    require_pixel(pixel)
    require_positive(contact_modulus=contact_modulus)

    def operator(shape: tuple[int, int], coarsening: tuple[int, int]) -> SlabConvolution:
        coarse = (coarsening[0] * pixel[0], coarsening[1] * pixel[1])
        rows = (*(edge // coarsening[0] for edge in edges[:-1]), shape[0])
        padded = _period(free_axes, shape)
        waves = padded[1] // 2 + 1
        columns = _shared_out(waves, ranks.count)
        layout = Layout(shape, padded, rows, columns)
        own, softness = symbol(layout, coarse, ranks, workspace, datum)
        return SlabConvolution(
            own, layout, ranks, workspace,
            # On coarse grids the error of the grid outweighs that of the arithmetic.
            precision=precision if coarsening == (1, 1) else "single",
            softness=softness / contact_modulus,
        )  # fmt: skip

    return operator


def _shared_out(lines: int, count: int) -> tuple[int, ...]:
    """Return the first line of each rank, and their number."""
    return tuple(lines * rank // count for rank in range(count + 1))


def _period(free_axes: Sequence[int], shape: tuple[int, int]) -> tuple[int, int]:
    ny, nx = (
        2 * fft.fast_length(points) if axis in free_axes else points
        for axis, points in enumerate(shape)
    )
    return ny, nx


# What a rank makes of the symbol: that of its own columns, for E* = 1 Pa over a factor.


def free(
    layout: Layout, pixel: tuple[float, float], ranks: Ranks, work: Workspace, datum: float
) -> tuple[Array, float]:
    """Return the share of a rank of the symbol of a free map, and the factor before it."""
    points, width = layout.padded[0] // 2 + 1, layout.padded[1] // 2 + 1
    bands = -(-points // BAND)
    tops = [min(BAND * (bands * rank // ranks.count), points) for rank in range(ranks.count)]
    tops.append(points)
    first, last = tops[ranks.number : ranks.number + 2]
    quadrant = np.empty((last - first, width))
    edges = (1.0, pixel[1] / pixel[0])

    def fill(top: int) -> None:
        rows = quadrant[top : top + BAND]
        rows[...] = kernels.love(rows.shape, edges, 1.0, first_row=first + top)

    work.each(fill, range(0, last - first, BAND))
    fft.even_spectrum(quadrant, work, axes=(1,))
    symbol = _transposed(quadrant, tops, layout.columns, ranks)
    return fft.even_spectrum(symbol, work, axes=(0,)), pixel[0]


def periodic(
    layout: Layout, pixel: tuple[float, float], ranks: Ranks, work: Workspace, datum: float
) -> tuple[Array, float]:
    """Return the share of a rank of the symbol of a period, and the factor before it."""
    return kernels.periodic(layout.shape, pixel, 1.0, layout.waves(ranks.number)), 1.0


def strip_x(
    layout: Layout, pixel: tuple[float, float], ranks: Ranks, work: Workspace, datum: float
) -> tuple[Array, float]:
    """Return the share of a rank for a strip along x, and the factor before it."""
    shape, edges = (layout.padded[0] // 2 + 1, layout.padded[1]), (1.0, pixel[1] / pixel[0])
    own = layout.waves(ranks.number)
    table = kernels.strip(shape, edges, 1.0, datum / pixel[0], own)
    return fft.even_spectrum(table, work, axes=(0,)), pixel[0]


def strip_y(
    layout: Layout, pixel: tuple[float, float], ranks: Ranks, work: Workspace, datum: float
) -> tuple[Array, float]:
    """Return the share of a rank for a strip along y, and the factor before it."""
    # The kernel knows x as the periodic axis.
    shape, edges = (layout.padded[1] // 2 + 1, layout.padded[0]), (1.0, pixel[0] / pixel[1])
    waves = layout.padded[0] // 2 + 1
    tops = _shared_out(waves, ranks.count)
    own = slice(tops[ranks.number], tops[ranks.number + 1])
    table = kernels.strip(shape, edges, 1.0, datum / pixel[1], own)
    rows = fft.even_spectrum(np.ascontiguousarray(table.T), work, axes=(1,))
    return _transposed(rows, tops, layout.columns, ranks), pixel[1]


def _transposed(rows: Array, tops: Sequence[int], columns: Sequence[int], ranks: Ranks) -> Array:
    """Return all rows of the columns of this rank, from its rows of all columns."""
    me = ranks.number
    first, last = columns[me], columns[me + 1]
    found = np.empty((tops[-1], last - first))
    step = max(1, TRAVELLING // (8 * tops[-1]))
    for block in cut_up(int(max(np.diff(columns))), step):
        parts = [
            rows[:, min(start + block.start, end) : min(start + block.stop, end)].ravel()
            for start, end in pairwise(columns)
        ]
        at = slice(min(block.start, last - first), min(block.stop, last - first))
        sizes = [height * (at.stop - at.start) for height in np.diff(tops).tolist()]
        going = np.concatenate(parts)
        exchange = ranks.exchange(going, [part.size for part in parts], np.empty(sum(sizes)), sizes)
        for top, bottom, part in zip(tops, tops[1:], exchange.arrived(), strict=False):
            found[top:bottom, at] = part.reshape(bottom - top, at.stop - at.start)
    return found
