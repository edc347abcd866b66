"""A map of heights on a regular grid, and where it came from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact import preparation, roughness
from roughcontact.errors import InputError


@dataclass(frozen=True)
class Provenance:
    """Where a map came from and what was done to it.

    Parameters
    ----------
    source : str
        File name, or how the map was made; empty if unknown.
    instrument : str
        Instrument or file format as the file names it; empty if unknown.
    channel : str
        Height channel that was read; empty if there is only one.
    steps : tuple of str
        Preparation steps in their order, each one sentence.
    """

    source: str = ""
    instrument: str = ""
    channel: str = ""
    steps: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Surface:
    """Heights of a surface on a regular grid, positive out of the material.

    Parameters
    ----------
    heights : array_like, shape (ny, nx)
        Heights [m], ``heights[y, x]``; NaN where missing. Kept as read-only float64.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    provenance : Provenance
        Where the map came from.
    holes_masked : bool
        Whether missing points are accepted as points that never touch; see `masked`.

    Raises
    ------
    InputError
        If the heights are not a real 2-D array of at least 2 × 2 points, hold infinite values or
        no finite one, or if a pixel edge is not positive and finite.
    """

    heights: NDArray[np.float64]
    pixel: tuple[float, float]
    provenance: Provenance = field(default_factory=Provenance)
    holes_masked: bool = False

    def __init__(
        self,
        heights: ArrayLike,
        pixel: tuple[float, float],
        provenance: Provenance | None = None,
        holes_masked: bool = False,
    ) -> None:
        object.__setattr__(self, "heights", _checked_heights(heights))
        object.__setattr__(self, "pixel", _checked_pixel(pixel))
        object.__setattr__(self, "provenance", provenance or Provenance())
        object.__setattr__(self, "holes_masked", bool(holes_masked))

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)``."""
        ny, nx = self.heights.shape
        return ny, nx

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the sides ``(ny·dy, nx·dx)`` [m]."""
        return self.shape[0] * self.pixel[0], self.shape[1] * self.pixel[1]

    @cached_property
    def missing(self) -> int:
        """Number of missing points."""
        return int(np.count_nonzero(np.isnan(self.heights)))

    @property
    def Sq(self) -> float:  # noqa: N802 - the standard's symbol
        """Root-mean-square height about the mean [m] (ISO 25178-2)."""
        return roughness.rms_height(self.heights)

    @property
    def Sdq(self) -> float:  # noqa: N802 - the standard's symbol
        """Root-mean-square gradient (ISO 25178-2)."""
        return roughness.rms_gradient(self.heights, self.pixel)

    def roughness(self) -> dict[str, float]:
        """Return the roughness parameters of ISO 25178-2 under their symbols, in SI units.

        Returns
        -------
        dict
            ``Sq``, ``Sa``, ``Ssk``, ``Sku``, ``Sp``, ``Sv``, ``Sz``, ``Sdq``, ``Sdr``, ``Sal``,
            ``Str``, ``Sk``, ``Spk``, ``Svk``, ``Smr1``, ``Smr2``, ``Vmp``, ``Vmc``, ``Vvc``,
            ``Vvv``: see `roughcontact.roughness.summary`. Nothing is levelled or filtered first;
            missing points are left out.
        """
        return roughness.summary(self.heights, self.pixel)

    def leveled(self, form: str = "plane") -> Surface:
        """Return a copy without its least-squares plane (or quadric, or mean).

        Parameters
        ----------
        form : {"plane", "quadric", "mean"}
            What is fitted to the points that are there, and subtracted.

        Returns
        -------
        Surface
            The residual heights, with zero mean over the points that are there.
        """
        return self._prepared(
            preparation.level(self.heights, form), f"leveled: least-squares {form} subtracted"
        )

    def filled(self) -> Surface:
        """Return a copy with its holes filled smoothly; measured points keep their bits.

        Returns
        -------
        Surface
            Each hole holds the solution of Laplace's equation with the measured rim as its
            boundary values, hence stays between the lowest and the highest of them.
        """
        if self.missing == 0:
            return self
        # Imported late: sparse solvers double the time of the first import.
        from roughcontact.filling import fill

        return self._prepared(
            fill(self.heights, self.pixel),
            f"filled: {self.missing} missing points by harmonic interpolation",
        )

    def masked(self) -> Surface:
        """Return a copy whose missing points are accepted as points that never touch.

        Returns
        -------
        Surface
            The same heights; `solve` then keeps the pressure at zero where they are missing.
        """
        if self.missing == 0:
            return self
        step = f"masked: {self.missing} missing points never touch"
        return replace(self, holes_masked=True, provenance=self._with_step(step))

    def cropped(self, rows: tuple[int, int], columns: tuple[int, int]) -> Surface:
        """Return the part of the map between two rows and two columns.

        Parameters
        ----------
        rows, columns : (int, int)
            First index and the index after the last, as in a slice; at least two points each.

        Returns
        -------
        Surface
            The part, with the same pixel.

        Raises
        ------
        InputError
            If the part does not lie on the map.
        """
        part = preparation.crop(self.heights, rows, columns)
        return self._prepared(
            part, f"cropped: rows {rows[0]}:{rows[1]}, columns {columns[0]}:{columns[1]}"
        )

    def _prepared(self, heights: NDArray[np.float64], step: str) -> Surface:
        return replace(self, heights=heights, provenance=self._with_step(step))

    def _with_step(self, step: str) -> Provenance:
        return replace(self.provenance, steps=(*self.provenance.steps, step))


def _checked_heights(heights: ArrayLike) -> NDArray[np.float64]:
    if isinstance(heights, np.ma.MaskedArray):
        heights = np.ma.filled(heights.astype(np.float64), np.nan)
    try:
        array = np.asarray(heights)
    except ValueError:
        raise InputError("heights must be a 2-D array [y, x], got rows of unequal length") from None
    if array.dtype.kind not in "fiu":
        raise InputError(f"heights must be real numbers in metres, got dtype {array.dtype}")
    if array.ndim != 2 or min(array.shape) < 2:
        raise InputError(
            f"heights must be a 2-D array [y, x] of at least 2 × 2 points, got shape {array.shape}"
        )
    # Whoever locks an array that owns its data means it: a map of gigabytes is not copied then.
    if (
        array.dtype == np.float64
        and array.flags.c_contiguous
        and array.flags.owndata
        and not array.flags.writeable
    ):
        copy = array
    else:
        copy = np.array(array, dtype=np.float64, order="C")
        copy.flags.writeable = False
    infinite = int(np.count_nonzero(np.isinf(copy)))
    if infinite:
        raise InputError(
            f"heights has {infinite} infinite values; mark missing points as NaN instead"
        )
    if np.isnan(copy).all():
        raise InputError("heights has no finite value: every point is missing")
    return copy


def _checked_pixel(pixel: tuple[float, float]) -> tuple[float, float]:
    try:
        dy, dx = (float(edge) for edge in pixel)
    except (TypeError, ValueError):
        raise InputError(f"pixel must be a pair (dy, dx) in metres, got {pixel!r}") from None
    if not (0 < dy < np.inf and 0 < dx < np.inf):
        raise InputError(f"pixel must be positive and finite (dy, dx) [m], got {pixel!r}")
    return dy, dx
