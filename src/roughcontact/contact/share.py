"""Slab: the rows on one rank of a map that is distributed over several ranks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.ranks import Ranks
from roughcontact.errors import ArgumentRef, InputError, require_pixel
from roughcontact.halfspace.distributed import SlabSums
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, to_si

Array = NDArray[np.float64]

# Maximum number of points along the longer side of a reduced map.
_MAX_REDUCED_POINTS = 512


_PLANE = {"form": "plane", "points": None}


def row_bands(shape: tuple[int, int], count: int) -> tuple[int, ...]:
    """Return the first row of each rank, and the number of rows."""
    from roughcontact.solvers import bounded

    # At least two rows per rank, so that no rank has a profile.
    edge = max(1 << bounded.coarser_grids(shape), 2)
    maximum = shape[0] // edge
    if count > maximum:
        raise InputError(
            f"a map of {shape[0]} × {shape[1]} points can be distributed over at most {maximum} "
            f"ranks, got {count}; start fewer of them, each with more threads"
        )
    return (*(edge * (maximum * rank // count) for rank in range(count)), shape[0])


@validate_arguments
def slab_rows(shape: tuple[int, int], ranks: Any) -> slice:
    """Return the rows of a map that belong to this rank.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the map.
    ranks : Ranks or mpi4py communicator
        Ranks that share the map.

    Raises
    ------
    InputError
        As in `row_bands`.
    """
    ranks = ranks if isinstance(ranks, Ranks) else Ranks(ranks)
    return slice(*row_bands(shape, ranks.count)[ranks.number : ranks.number + 2])


@dataclass(frozen=True, eq=False)
class Slab:
    """Rows of a map of heights on this rank; other ranks have the rest.

    Parameters
    ----------
    heights : array_like, shape (rows, nx)
        Heights of the rows of this rank [m]; NaN where missing.
    shape : (int, int)
        Grid points ``(ny, nx)`` of the whole map.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    ranks : Ranks or mpi4py communicator
        Ranks that share the map, each with the rows of `slab_rows`.
    provenance : Provenance
        Source of the map and its preparation.
    holes_masked : bool
        Whether missing points are accepted as points without contact.

    Attributes
    ----------
    missing : int
        Number of missing points of the map.
    highest : float
        The largest height of the map [m].

    Raises
    ------
    InputError
        On all ranks, if the heights of any rank are invalid.
    """

    heights: Array
    shape: tuple[int, int]
    pixel: tuple[float, float]
    ranks: Ranks
    provenance: Provenance = field(default_factory=Provenance)
    holes_masked: bool = False
    missing: int = field(init=False)
    highest: float = field(init=False)

    @validate_arguments
    def __init__(
        self,
        heights: ArrayLike,
        shape: tuple[int, int],
        pixel: Quantities,
        ranks: Any,
        provenance: Provenance | None = None,
        holes_masked: bool = False,
    ) -> None:
        ranks = ranks if isinstance(ranks, Ranks) else Ranks(ranks)
        ny, nx = shape
        dy, dx = to_si(pixel, "length", "pixel")
        values = {
            "shape": (int(ny), int(nx)),
            "pixel": (float(dy), float(dx)),
            "ranks": ranks,
            "provenance": provenance or Provenance(),
            "holes_masked": bool(holes_masked),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "heights", ranks.run_on_all(lambda: self._check_heights(heights)))
        finite = np.isfinite(self.heights)
        known = self.sums.count(finite)
        if not known:
            raise InputError("hold no finite value", argument="heights")
        # Counted here, as a property must not wait for other ranks.
        object.__setattr__(self, "missing", self.shape[0] * self.shape[1] - known)
        object.__setattr__(self, "highest", self.sums.largest(self.heights[finite]))

    def _check_heights(self, heights: ArrayLike) -> Array:
        require_pixel(self.pixel)
        wanted = (self.rows.stop - self.rows.start, self.shape[1])
        taken: Array = np.ascontiguousarray(heights, np.float64)
        if taken.shape != wanted:
            raise InputError(
                f"of rank {self.ranks.number} must be {wanted[0]} × {wanted[1]}, rows "
                f"{self.rows.start} to {self.rows.stop} of the map, got {taken.shape}",
                argument="heights",
            )
        if np.isinf(taken).any():
            raise InputError("must not be infinite; mark missing points by NaN", argument="heights")
        return taken

    @cached_property
    def edges(self) -> tuple[int, ...]:
        """First row of each rank, and the number of rows."""
        return row_bands(self.shape, self.ranks.count)

    @property
    def rows(self) -> slice:
        """Rows of the map on this rank."""
        return slab_rows(self.shape, self.ranks)

    @property
    def sums(self) -> SlabSums:
        """Sums over all pixels of the map."""
        return SlabSums(self.ranks)

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the sides ``(ny·dy, nx·dx)`` of the map [m]."""
        return self.shape[0] * self.pixel[0], self.shape[1] * self.pixel[1]

    @property
    def is_profile(self) -> bool:
        """Whether it is a profile: never, as those fit into one process."""
        return False

    def leveled(self) -> Slab:
        """Return a copy without its least-squares plane; all ranks call it.

        Raises
        ------
        InputError
            If points are missing: the plane is then not found by sums along rows and columns.
        """
        if self.missing:
            raise InputError(
                "has missing points, and on several ranks only a whole map can be leveled; level "
                f"it beforehand, or give {ArgumentRef('level', 'none')}",
                argument="heights",
            )
        ny, nx = self.shape
        y = np.arange(self.rows.start, self.rows.stop) - (ny - 1) / 2
        x = np.arange(nx) - (nx - 1) / 2
        points = math.prod(self.shape)
        heights = self.heights
        # A second pass removes the rounding error of the first.
        for _ in range(2):
            along_y, along_x = heights.sum(axis=1), heights.sum(axis=0)
            parts = [along_y.sum(), (along_y * y).sum(), (along_x * x).sum()]
            mean, tilt_y, tilt_x = self.ranks.allreduce(np.array(parts)) / points
            tilt = 12 * tilt_y / (ny**2 - 1), 12 * tilt_x / (nx**2 - 1)
            plane = mean + tilt[0] * y[:, None] + tilt[1] * x
            heights = heights - plane
        about = self.provenance.then(Operation("leveled", _PLANE))
        return Slab(heights, self.shape, self.pixel, self.ranks, about, self.holes_masked)

    def iter_blocks(self, points: int) -> Iterator[tuple[int, int, int]]:
        """Yield rank, first local row and rows of parts of the map of limited size."""
        step = max(1, points // self.shape[1])
        for rank, (first, last) in enumerate(pairwise(self.edges)):
            for top in range(0, last - first, step):
                yield rank, top, min(step, last - first - top)

    def reduce_blocks(self, values: NDArray[Any], largest: bool = False) -> Array | None:
        """Return a reduced map on the first rank: the mean or the maximum of blocks of pixels.

        Parameters
        ----------
        values : ndarray, shape (rows, nx)
            Rows of this rank.
        largest : bool
            Whether to reduce by the maximum.

        Returns
        -------
        ndarray or None
            About 512 points along the longer side, more if bands are narrow; None on other ranks.
        """
        edge = 1
        # The last block may be incomplete.
        while max(self.shape) > _MAX_REDUCED_POINTS * edge and all(
            first % (2 * edge) == 0 for first in self.edges[:-1]
        ):
            edge *= 2
        take = np.fmax if largest else np.add
        blocks = [range(0, points, edge) for points in values.shape]
        here = take.reduceat(take.reduceat(values, blocks[0], axis=0), blocks[1], axis=1)
        if not largest:
            here = here / np.outer(
                *(
                    np.diff([*tops, points])
                    for tops, points in zip(blocks, values.shape, strict=True)
                )
            )
        counts = [
            len(range(0, e - s, edge)) for s, e in zip(self.edges, self.edges[1:], strict=False)
        ]
        whole = self.ranks.allgatherv(here, counts)
        return whole if self.ranks.is_root else None


MapOrSlab = Surface | Slab
"""Part of a map in a process: all of it, or a band of its rows."""
