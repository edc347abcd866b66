"""Map of heights on a regular grid, with its provenance.

`summary`: ISO 25178-2:2021, sections 4.2 to 4.5
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import memory
from roughcontact._tools.arguments import set_fields, validate_public_methods
from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import ArgumentRef, InputError, input_error, require_pixel
from roughcontact.result import Displayable
from roughcontact.surface import (
    alignment,
    cleaning,
    filters,
    grid as grids,
    resolution,
    roughness,
    spectrum,
)
from roughcontact.surface.form import level, remove_form
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.units import Quantities, Quantity, WithUnit, format_lengths, to_si


def summary(heights: Array, pixel: Pixel) -> dict[str, float]:
    """Return the parameters of ISO 25178-2, by the symbols of the standard and in SI units."""
    require_pixel(pixel)
    sal, ratio, largest = spectrum.texture(heights, pixel)
    curve = roughness.material_ratio_curve(heights)
    return {
        **roughness.height_parameters(heights),
        "Sdq": roughness.rms_gradient(heights, pixel),
        "Sdr": roughness.developed_area_ratio(heights, pixel),
        "Sal": sal,
        "Str": ratio,
        "Str_max": largest,
        "Std": spectrum.lay_direction(heights, pixel),
        "m": roughness.mean_slope(heights, pixel),
        **roughness.core_parameters(*curve),
        **roughness.height_differences(*curve),
        **roughness.volume_parameters(*curve),
    }


@dataclass(frozen=True, eq=False, repr=False)
@validate_public_methods
class Surface(Displayable):
    """Heights of a surface on a regular grid, positive out of the material.

    Parameters
    ----------
    heights : array_like or quantity of pint, shape (ny, nx) or (nx,)
        Heights [m], ``heights[y, x]``; NaN where missing. Stored as read-only float64. A single
        line is a profile: a body that continues unchanged along y.
    pixel : (float, float) or float
        Pixel edges ``(dy, dx)`` [m], or with their units, as ``("1 um", "2 um")``; for a profile
        the distance of its points.
    provenance : Provenance
        Source of the map and its preparation.
    holes_masked : bool
        Whether missing points are accepted as points without contact; see `masked`.

    Raises
    ------
    InputError
        If the heights are not a real array of at least 2 × 2 points (2 for a profile), contain
        infinite values or no finite value, or if a pixel edge is not positive and finite.

    Notes
    -----
    A profile is stored as a map of one row of pixels `grid.PROFILE_WIDTH` = 1 m wide. Forces [N]
    and areas [m²] of a map are line loads [N/m] and lengths [m] of a roughness.
    """

    heights: NDArray[np.float64]
    pixel: tuple[float, float]
    provenance: Provenance = field(default_factory=Provenance)
    holes_masked: bool = False
    # Mask of the filled points, as long as the grid is the same.
    _filled: NDArray[np.bool_] | None = field(default=None, init=False)

    def __init__(
        self,
        heights: ArrayLike | WithUnit,
        pixel: Quantities | Quantity,
        provenance: Provenance | None = None,
        holes_masked: bool = False,
    ) -> None:
        array, edges = grids.check_grid(to_si(heights, "length", "heights"), pixel)
        set_fields(self, heights=array, pixel=edges, provenance=provenance or Provenance())
        set_fields(self, holes_masked=bool(holes_masked))

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)``."""
        ny, nx = self.heights.shape
        return ny, nx

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the sides ``(ny·dy, nx·dx)`` [m]."""
        return self.shape[0] * self.pixel[0], self.shape[1] * self.pixel[1]

    @property
    def is_profile(self) -> bool:
        """Whether the map is a profile: one row, of a body that continues unchanged along y."""
        return self.shape[0] == 1

    def require_map(self, what: str) -> None:
        """Raise `InputError` for a profile; ``what`` needs a map."""
        if self.is_profile:
            raise InputError(f"is a profile; {what} needs a map", argument="surface")

    @cached_property
    def missing(self) -> int:
        """Number of missing points."""
        return int(np.count_nonzero(np.isnan(self.heights)))

    @property
    def Sq(self) -> float:  # noqa: N802 - the standard's symbol
        """Root-mean-square height about the mean [m] (ISO 25178-2)."""
        return roughness.rms_height(self.heights)

    @cached_property
    def Sku(self) -> float:  # noqa: N802 - the standard's symbol
        """Kurtosis of the heights (ISO 25178-2)."""
        return roughness.height_parameters(self.heights)["Sku"]

    @property
    def Sdq(self) -> float:  # noqa: N802 - the standard's symbol
        """Root-mean-square gradient (ISO 25178-2)."""
        return roughness.rms_gradient(self.heights, self.pixel)

    def roughness(self) -> dict[str, float]:
        """Return the roughness parameters of ISO 25178-2 by their symbols, in SI units.

        Returns
        -------
        dict
            ``Sq``, ``Sa``, ``Ssk``, ``Sku``, ``Sp``, ``Sv``, ``Sz``, ``Sdq``, ``Sdr``, ``Sal``,
            ``Str``, ``Str_max`` (upper bound of Str), ``Std`` (direction of the lay [degrees],
            counter-clockwise from x, row 0 on top), ``Sk``, ``Spk``, ``Svk``, ``Smr1``, ``Smr2``,
            ``Sxp``, ``Sdc``, ``Vmp``, ``Vmc``, ``Vvc``, ``Vvv``, and ``m``, the mean absolute slope
            along a profile: see `roughcontact.surface.surface.summary`. The map is neither leveled
            nor filtered; missing points are excluded. For a profile ``Pq``, ``Pa``, ``Pt`` and
            others of ISO 21920-2: see `roughcontact.surface.roughness.profile_parameters`.
        """
        if self.is_profile:
            return roughness.profile_parameters(self.heights[0], self.pixel[1], profile="P")
        return summary(self.heights, self.pixel)

    def material_ratio(self, height: Quantity) -> float:
        """Return the material ratio at a height, Smr(c).

        Parameters
        ----------
        height : float or quantity
            Height c above the mean [m].

        Returns
        -------
        float
            Share of the valid points above the height, from 0 to 1.
        """
        c = to_si(height, "length", "height")
        return roughness.ratio_at(*roughness.material_ratio_curve(self.heights), c)

    def height_at_ratio(self, ratio: float) -> float:
        """Return the height at a material ratio, Smc(mr).

        Parameters
        ----------
        ratio : float
            Material ratio, from 0 to 1.

        Returns
        -------
        float
            Height above the mean [m] beyond which this share of the valid points is.

        Raises
        ------
        InputError
            If the ratio is not between 0 and 1.
        """
        if not 0 <= ratio <= 1:
            raise input_error("ratio", ratio, "must be between 0 and 1")
        return float(np.interp(ratio, *roughness.material_ratio_curve(self.heights)))

    def resolution_notes(self, tip_radius: Quantity | None = None) -> tuple[str, ...]:
        """Return the texts of the `resolution_limits` of the map."""
        return tuple(limit.text for limit in self.resolution_limits(tip_radius))

    def resolution_limits(self, tip_radius: Quantity | None = None) -> tuple[resolution.Limit, ...]:
        """Return the limits of the lateral resolution of the map.

        Parameters
        ----------
        tip_radius : float, optional
            Radius of the tip's apex [m], if a tip measured the map.

        Returns
        -------
        tuple of Limit
            The scale below which the map shows the tip (`resolution.tip_cutoff`), if its radius is
            given; otherwise, for a file of a scanning probe, a request for the radius. The
            wavelengths below which the map contains noise (`resolution.noise_cutoff`) or no waves
            (`resolution.smoothing_cutoff`), evaluated on the largest rectangle without holes. Empty
            if there are no limits.

        Raises
        ------
        InputError
            If the radius is not positive.
        """
        radius = to_si(tip_radius, "length", "tip_radius")
        instrument = self.provenance.instrument
        tip = resolution.tip_limits(self.heights, self.pixel, radius, instrument)
        return (*tip, *self._wave_limits)

    @cached_property
    def _wave_limits(self) -> list[resolution.Limit]:
        # Cached, as the app requests the limits for every load.
        return resolution.wave_limits(self.heights, self.pixel)

    def leveled(
        self, form: str = "plane", points: Sequence[tuple[int, int]] | None = None
    ) -> Surface:
        """Return a copy without its plane (or quadric, or mean).

        Parameters
        ----------
        form : {"plane", "quadric", "mean", "robust", "three-point"}
            Form that is fitted to the valid points and subtracted: a least-squares plane, quadric
            or mean; a plane insensitive to outliers ("robust"); or the plane through three points.
            See `form.level`.
        points : three pairs of int, optional
            Indices ``(y, x)`` of the points for "three-point".

        Returns
        -------
        Surface
            The residual heights; least squares leaves a zero mean over the valid points.
        """
        heights = level(self.heights, form, points)
        result: dict[str, object] = {"line": True} if self.is_profile else {}
        return self._after(Operation("leveled", {"form": form, "points": points}, result), heights)

    def without_form(self, shape: str, degree: int | None = None) -> Surface:
        """Return a copy without its least-squares sphere, cylinder or polynomial.

        Parameters
        ----------
        shape : {"sphere", "cylinder", "polynomial"}
            Form that is fitted to the valid points and subtracted.
        degree : int, optional
            Total degree of a polynomial; not allowed for other shapes.

        Returns
        -------
        Surface
            The residual heights, with zero mean over the valid points. The provenance contains the
            radius, see `Operation`; `form.remove_form` returns it.
        """
        heights, result = remove_form(self.heights, self.pixel, shape, degree)
        specified = {"shape": shape, "degree": degree}
        return self._after(Operation("without_form", specified, result), heights)

    def without_outliers(self, limit: float = 6.0, window: int = 5) -> Surface:
        """Return a copy in which spikes are missing points.

        Parameters
        ----------
        limit : float
            Largest accepted deviation from the local median, in robust standard deviations.
        window : int
            Points along each side of the square whose median is taken; odd, 3 to 31.

        Returns
        -------
        Surface
            The other heights are identical. New holes have to be filled, cropped or masked, even if
            the old ones were masked.
        """
        heights = cleaning.remove_outliers(self.heights, limit, window)
        count = int(np.count_nonzero(np.isnan(heights))) - self.missing
        specified = {"limit": limit, "window": window}
        step = Operation("without_outliers", specified, {"points": count})
        return self._after(step, heights, holes_masked=self.holes_masked and not count)

    def filled(self, most: float = cleaning.MAX_FILLED_SHARE) -> Surface:
        """Return a copy with its missing points filled smoothly; measured points do not change.

        Parameters
        ----------
        most : float
            Largest fraction of missing points that is filled; `InputError` above it.

        Returns
        -------
        Surface
            Each hole is filled by Laplace's equation with the measured points around it as
            boundary values, so its heights stay between the lowest and the highest of them.
        """
        if self.missing == 0:
            return self
        # Imported here, as sparse solvers double the time of the first import.
        from roughcontact.surface.cleaning import fill_missing

        result = {"missing": self.missing, "points": self.heights.size}
        heights = fill_missing(self.heights, self.pixel, most)
        filled = np.isnan(self.heights) | (False if self._filled is None else self._filled)
        return self._after(Operation("filled", {"most": most}, result), heights, filled=filled)

    def masked(self) -> Surface:
        """Return a copy whose missing points are accepted as points without contact.

        Returns
        -------
        Surface
            The same heights; `solve` then sets the pressure to zero at missing points.
        """
        if self.missing == 0:
            return self
        step = Operation("masked", found={"missing": self.missing})
        return self._after(step, self.heights, holes_masked=True)

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
            If the part is not inside the map.
        """
        part = cleaning.crop_map(self.heights, rows, columns)
        filled = None if self._filled is None else cleaning.crop_map(self._filled, rows, columns)
        result = {} if filled is None else {"filled": int(filled.sum()), "points": filled.size}
        step = Operation("cropped", {"rows": rows, "columns": columns}, result)
        return self._after(step, part, filled=filled)

    def largest_rectangle(self) -> Surface:
        """Return the largest rectangular part without holes.

        Returns
        -------
        Surface
            The part, with the same pixel.

        Raises
        ------
        InputError
            If no 2 × 2 points without a hole are left.
        """
        rows, columns = cleaning.largest_rectangle(self.heights)
        step = Operation("largest_rectangle", found={"rows": rows, "columns": columns})
        return self._after(step, cleaning.crop_map(self.heights, rows, columns))

    def inverted(self) -> Surface:
        """Return the map with its heights times -1.

        Returns
        -------
        Surface
            The surface of which the map is a replica, seen from the other side: `flipped` as well,
            it has its places.
        """
        return self._after(Operation("inverted"), -self.heights)

    def flipped(self, axis: str = "x") -> Surface:
        """Return the mirror image of the map.

        Parameters
        ----------
        axis : {"x", "y"}
            Axis whose direction is reversed.

        Returns
        -------
        Surface
            The same heights to the bit, in reverse order along the axis.

        Raises
        ------
        InputError
            If the axis is neither x nor y.
        """
        if axis not in ("x", "y"):
            raise input_error("axis", axis, "must be 'x' or 'y'")
        heights = np.flip(self.heights, "yx".index(axis)).copy()
        return self._after(Operation("flipped", {"axis": axis}), heights, pixel=self.pixel)

    def rotated(self, angle: int = 90) -> Surface:
        """Return the map rotated by multiples of 90°.

        Parameters
        ----------
        angle : int
            Angle [degrees], a multiple of 90, counter-clockwise as the map is printed and drawn,
            row 0 on top; negative for clockwise.

        Returns
        -------
        Surface
            The same heights to the bit; an odd number of quarter turns swaps the edges of the
            pixel.

        Raises
        ------
        InputError
            If the angle is not a multiple of 90.
        """
        if angle % 180:
            self.require_map("a quarter turn")
        heights = cleaning.rotate_map(self.heights, angle)
        pixel = self.pixel[::-1] if angle % 180 else self.pixel
        return self._after(Operation("rotated", {"angle": angle}), heights, pixel=pixel)

    def resampled(
        self,
        shape: tuple[int, int] | None = None,
        *,
        pixel: Quantities | None = None,
        method: str = "bandlimited",
    ) -> Surface:
        """Return the map on another grid over the same outline.

        Parameters
        ----------
        shape : (int, int), optional
            Points ``(ny, nx)`` of the new grid; this or ``pixel``.
        pixel : (float, float), optional
            Pixel edges ``(dy, dx)`` [m], approximated as closely as the outline allows.
        method : {"bandlimited", "spline"}
            Trigonometric (the map is treated as periodic, waves too short for the new grid are
            removed) or cubic spline (not periodic, no waves removed); see `filters.resample`.

        Returns
        -------
        Surface
            The same size on the new grid, with pixels of size / shape.

        Raises
        ------
        InputError
            If there are missing points, or if not exactly one of shape and pixel is given.
        """
        wanted = to_si(pixel, "length", "pixel")
        specified = {"shape": shape, "pixel": wanted, "method": method}
        if shape is None:
            if wanted is None:
                raise InputError(
                    f"or {ArgumentRef('pixel')} of the new grid must be given", argument="shape"
                )
            require_pixel(wanted)
            if self.is_profile:
                wanted = (self.size[0], wanted[1])
            ratios = [side / edge for side, edge in zip(self.size, wanted, strict=True)]
            memory.require_grid("pixel", ratios, wanted)
            shape = (round(ratios[0]), round(ratios[1]))
            if min(shape[self.is_profile :]) < 2:
                raise InputError(
                    f"must be at most half the map, {format_lengths(self.size)}, got "
                    f"{format_lengths(wanted)}",
                    argument="pixel",
                    value=pixel,
                )
        elif pixel is not None:
            raise InputError(
                f"and {ArgumentRef('pixel')} exclude each other; give one of them", argument="shape"
            )
        heights = filters.resample(self.heights, shape, method)
        edges = (self.size[0] / heights.shape[0], self.size[1] / heights.shape[1])
        result = {"from": self.shape, "to": heights.shape, "pixel": edges}
        return self._after(Operation("resampled", specified, result), heights, pixel=edges)

    def filtered(
        self,
        s: Quantity | None = None,
        l: Quantity | None = None,  # noqa: E741 - the standard's letter
    ) -> Surface:
        """Return a copy without short waves, long waves, or both (ISO 16610-61).

        Parameters
        ----------
        s : float, optional
            Nesting index of the S-filter [m]: waves shorter than this are removed.
        l : float, optional
            Nesting index of the L-filter [m]: waves longer than this are removed, and the mean.

        Returns
        -------
        Surface
            50 % of a wave's amplitude pass at the cut-off. Missing points stay missing; near edges
            and holes the weights of the valid points are scaled, which biases slopes towards the
            mean: level the map and remove its form first.

        Raises
        ------
        InputError
            If neither is given, or a cut-off is below two pixels or above a side of the map.
        """
        specified = {name: to_si(cut, "length", name) for name, cut in (("s", s), ("l", l))}
        heights = filters.gaussian_band(self.heights, self.pixel, **specified)
        return self._after(Operation("filtered", specified), heights)

    def with_form(self, form: Surface) -> Surface:
        """Return a copy with the heights of a body added: roughness on a nominal form.

        Parameters
        ----------
        form : Surface
            Heights of the body on the same grid, such as ``nominal_bodies.sphere`` makes them.

        Returns
        -------
        Surface
            The sum along z (not along the normal of the body). A point that is missing in either is
            missing. Points outside a nominal body, which have no contact, are accepted; holes of a
            measurement still have to be handled, unless they are outside of the body.

        Raises
        ------
        InputError
            If the grids differ, if no point is left, or if a body that ends on the map is added to
            a measurement with unhandled holes: filling these later would fill the outside too.
        """
        if form.shape != self.shape or not np.allclose(form.pixel, self.pixel, rtol=1e-9, atol=0):
            raise InputError(
                f"has {form.shape} pixels of {format_lengths(form.pixel)}, the surface "
                f"{self.shape} of {format_lengths(self.pixel)}: make it with shape=surface.shape, "
                "pixel=surface.pixel, or resample it with form.aligned(surface)",
                argument="form",
            )
        heights = self.heights + form.heights
        accepted = np.zeros(self.shape, dtype=bool)
        for body in (self, form):
            if body.holes_masked:
                accepted |= np.isnan(body.heights)
        outside = int(np.count_nonzero(accepted))
        holes = int(np.count_nonzero(np.isnan(heights))) - outside
        if holes and outside:
            raise InputError(
                f"{holes} missing points of one map lie inside the other, which ends on the grid; "
                "fill, crop or mask them first, e.g. surface.filled()"
            )
        step = Operation("with_form", {"form": form.traced(identified=True)})
        return self._after(step, heights, holes_masked=outside > 0)

    def aligned(
        self,
        grid: Surface,
        offset: Quantities = (0.0, 0.0),
        angle: float = 0.0,
        mirrored: bool = False,
    ) -> Surface:
        """Return the map on the grid of another one, mirrored, rotated and shifted.

        Parameters
        ----------
        grid : Surface
            Map with the shape and pixel of the new grid; its heights are not used. The centers of
            both outlines coincide before the shift.
        offset : (float, float)
            Shift ``(y, x)`` [m] along the axes of the grid, the last of the three motions.
        angle : float
            Angle [degrees] by which this map is rotated about its center, counter-clockwise as it
            is printed and drawn, row 0 on top: ``angle=90`` is `rotated`.
        mirrored : bool
            Whether x is mirrored first, as needed for two faces in contact that were both measured
            from their front.

        Returns
        -------
        Surface
            Bicubic spline; the same bits where the points of both grids coincide. For a pixel
            larger by more than √2, an S-filter of two such pixels is applied first, see
            `alignment.cutoffs`. Points beyond the centers of the outer pixels and on holes are
            missing; `placement.match_grids` crops two maps to their common rectangle.

        Raises
        ------
        InputError
            If the maps do not overlap, or the motion is not finite.
        """
        self.require_map("alignment")
        shift = to_si(offset, "length", "offset")
        motion = (grid.shape, grid.pixel, shift, angle, mirrored)
        heights = alignment.align(self.heights, self.pixel, *motion)
        placement = alignment.grid_positions(self.shape, self.pixel, *motion)
        first, last = alignment.spans(self.shape, placement, grid.shape)
        outside = grid.heights.size - int(np.maximum(last - first + 1, 0).sum())
        spline = not alignment.is_coincident(placement)
        cutoffs = alignment.cutoffs(placement) if spline else (0.0, 0.0)
        flat = Operation("nominal.flat", {"shape": grid.shape, "pixel": grid.pixel})
        smoothing = [c * edge for c, edge in zip(cutoffs, self.pixel, strict=True)]
        result = {"spline": spline, "smoothing": smoothing, "outside": outside}
        specified = {"offset": shift, "angle": angle, "mirrored": mirrored}
        specified = {"grid": Provenance("nominal flat", origin=flat), **specified}
        step = Operation("aligned", specified, result)
        # Accepted holes do not include points that the map does not cover.
        accepted = self.holes_masked and not outside
        return self._after(step, heights, pixel=grid.pixel, holes_masked=accepted)

    def traced(self, identified: bool = False) -> Provenance:
        """Return the provenance with an origin: an array in memory if no other is known.

        Parameters
        ----------
        identified : bool
            Whether such an array is identified by the SHA-256 of its bytes.

        Returns
        -------
        Provenance
            Everything that a script needs to create the map again.
        """
        if self.provenance.origin is not None:
            return self.provenance
        specified = {"pixel": self.pixel, "holes_masked": self.holes_masked}
        result: dict[str, object] = {"shape": self.shape}
        if identified:
            result["sha256"] = hashlib.sha256(self.heights.data).hexdigest()
        return replace(self.provenance, origin=Operation("Surface", specified, result))

    def _after(
        self,
        step: Operation,
        heights: NDArray[np.float64],
        *,
        pixel: tuple[float, float] | None = None,
        holes_masked: bool | None = None,
        filled: NDArray[np.bool_] | None = None,
    ) -> Surface:
        """Return the map after an operation."""
        accepted = self.holes_masked if holes_masked is None else holes_masked
        after = Surface(heights, pixel or self.pixel, self.traced().then(step), accepted)
        same = filled is None and pixel is None and after.shape == self.shape
        object.__setattr__(after, "_filled", self._filled if same else filled)
        return after
