"""Can a result be trusted: the same contact on other grids, with other filters and ceilings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.arguments import checked
from roughcontact.contact.advice import RECOMMENDED
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.checks import check
from roughcontact.contact.loads import Load, on
from roughcontact.contact.memory import Room
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import press
from roughcontact.contact.study import ResolutionStudy, Variant
from roughcontact.contact.terms import Terms
from roughcontact.errors import InputError, InsufficientMemoryError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import CEILING_FACTOR, RIGID, Material
from roughcontact.solvers.bar import drawn
from roughcontact.solvers.progress import Tell, numbered
from roughcontact.surface import filters
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, engineering

Array = NDArray[np.float64]


PIXEL_FACTORS = (4.0, 2.0, 1.0, 0.5)
"""Pixels of the grids over that of the map."""

CUTOFFS = (4, 8, 16)
"""Cut-offs of the S-filter over the larger pixel edge."""

CEILING_FACTORS = (2.8, 3.0, 3.2)
"""Ceilings over the yield strength, from Tabor's 2.8 for metals to 3.2."""


_FEWEST_POINTS = 32


@drawn
@checked
def resolution_study(
    surface: Surface,
    *,
    material: Material,
    load: Quantity | Load,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    precision: str = "double",
    progress: Tell = None,
) -> ResolutionStudy:
    """Solve the same contact on other grids, with other filters and other ceilings.

    Parameters
    ----------
    surface, material, load, counter_material, counter_surface, ceiling, boundary, tolerance, \
precision
        As for `solve`. All solves have the ceiling that is recommended on the map itself.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`: the number of the solve, its name and the solver's `Step`.

    Returns
    -------
    ResolutionStudy
        The solves, and what they say in plain words.

    Raises
    ------
    InputError, CapacityError, ConvergenceError
        As for `solve`; and `InputError` if the map has fewer than 64 points along a side.

    Notes
    -----
    Coarser grids hold the means of blocks of points, as an instrument with larger pixels would
    measure; the finer one is interpolated by cubic splines (free) or by its own waves
    (periodic) and adds no roughness: it shows the error of the grid alone. Whether peaks below
    the pixel would change the result can only be read from the trend over the coarser grids.
    All grids cover the same outline, which may lose up to three rows and columns of a free map.
    Along a periodic axis a map keeps its outline, and its own waves make all grids.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.surface import shapes
    >>> ball = shapes.paraboloid((128, 128), (1e-6, 1e-6), 0.01)
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> study = rc.resolution_study(rc.Surface(ball, (1e-6, 1e-6)), material=steel, load=0.5)
    >>> print(study.sentences[0])
    Independent of the grid (less than 5 % change at each step over pixels of 2 µm, 1 µm, 500 nm): \
contact area, contact area without rim excess, maximum pressure, mean pressure.
    """
    pair = Pair(surface, material, counter_surface, counter_material, Boundary(boundary))
    terms = Terms(load=on(load, pair)[0], ceiling=ceiling, tolerance=tolerance, precision=precision)
    study = _begun(pair, terms, progress)
    return together([study.part(name) for name in PARTS])


PARTS = ("grids", "cutoffs", "ceilings")
"""The fields of a study that do not depend on each other."""


def part_of(name: str, pair: Pair, terms: Terms, progress: Tell = None) -> ResolutionStudy:
    """Return a study with one of its `PARTS` alone; errors are those of `resolution_study`."""
    return _begun(pair, terms, progress).part(name)


def together(parts: Sequence[ResolutionStudy]) -> ResolutionStudy:
    """Return the study of which these are the `PARTS`, in their order."""
    grids, cutoffs, ceilings = parts
    return replace(
        grids,
        cutoffs=cutoffs.cutoffs,
        ceilings=ceilings.ceilings,
        notes=(*grids.notes, *cutoffs.notes, *ceilings.notes),
    )


def _begun(pair: Pair, terms: Terms, progress: Tell) -> _Study:
    """Return a study, its arguments checked, with the ceiling that all of its solves have."""
    pair.require_map("a study of the resolution")
    if min(pair.shape) < 2 * _FEWEST_POINTS:
        raise InputError(
            f"has {pair.shape[0]} × {pair.shape[1]} points: a study of the "
            f"resolution needs at least {2 * _FEWEST_POINTS} along each side",
            argument="surface",
        )
    check(pair, terms)
    limit = resolved_ceiling(terms.ceiling, pair)
    if isinstance(terms.ceiling, str) and terms.ceiling == RECOMMENDED:
        limit = press(pair, terms).ceiling
    return _Study(pair, replace(terms, ceiling=limit), progress)


def coarsened(pair: Pair) -> Pair | None:
    """Return the same bodies on a grid of twice the pixel, as the study has them.

    Returns
    -------
    Pair or None
        None where fewer than 32 points a side would be left. The outline may lose up to three rows
        and columns of a free map.
    """
    if min(pair.shape) < 2 * _FEWEST_POINTS:
        return None
    outline = _changed(pair, partial(_divisible, boundary=pair.boundary))
    return _changed(outline, partial(_scaled, factor=2.0, boundary=pair.boundary))


@dataclass(eq=False)
class _Study:
    """The solves of a study, one after the other, and what has to be said of those left out."""

    pair: Pair
    terms: Terms
    progress: Tell
    number: int = 0
    notes: list[str] = field(default_factory=list)

    def part(self, name: str) -> ResolutionStudy:
        """Return a study with one of `PARTS` alone."""
        self.number = sum(map(len, self._wanted[: PARTS.index(name)]))
        self.notes = []
        found = ResolutionStudy((), (), (), at_ceiling=False)
        if name == "grids":
            grids = self.grids()
            found = replace(
                found,
                grids=tuple(grid for grid, _, _ in grids),
                at_ceiling=all(saturated for _, saturated, _ in grids[-3:]),
                at_edge=any(at_edge for _, _, at_edge in grids[-1:]),
            )
        elif name == "cutoffs":
            found = replace(found, cutoffs=self.cutoffs())
        else:
            found = replace(found, ceilings=self.ceilings())
        return replace(found, notes=tuple(self.notes))

    @property
    def _wanted(self) -> tuple[Sequence[float], ...]:
        """What the solves of each part are for."""
        return self.factors, self.lengths, self.ceiling_factors

    @property
    def factors(self) -> list[float]:
        """Pixels of the grids that are fine enough, over that of the map."""
        return [f for f in PIXEL_FACTORS if min(self.pair.shape) / f >= _FEWEST_POINTS]

    @property
    def lengths(self) -> list[float]:
        """Cut-offs that the map is long enough for [m]."""
        lengths = [points * max(self.pair.pixel) for points in sorted(CUTOFFS, reverse=True)]
        return [length for length in lengths if length <= min(self.pair.size)]

    @property
    def ceiling_factors(self) -> tuple[float, ...]:
        """Ceilings over the yield strength; none without a ceiling or with one per pixel."""
        return CEILING_FACTORS if isinstance(self.terms.ceiling, float) else ()

    def pressed(self, label: str, pair: Pair, terms: Terms) -> ContactResult:
        """Return the next solve."""
        count = sum(map(len, self._wanted))
        return press(pair, terms, progress=numbered(self.progress, self.number, count, label))

    def grids(self) -> list[tuple[Variant, bool, bool]]:
        """Return the solves on other grids; whether they reach a ceiling, an edge without one."""
        boundary = self.pair.boundary
        outline = _changed(self.pair, partial(_divisible, boundary=boundary))
        found = []
        for factor in self.factors:
            self.number += 1
            terms, limit = self.terms, self.terms.ceiling
            try:
                # Before the map is made: the finer one has four times the points.
                Room(_shape(outline.shape, factor), boundary, terms.precision).require()
                scaled = _changed(outline, partial(_scaled, factor=factor, boundary=boundary))
                if isinstance(limit, np.ndarray):
                    terms = replace(terms, ceiling=_nearest(limit, outline.shape, scaled.shape))
                result = self.pressed(f"pixel × {factor:g}", scaled, terms)
            except InsufficientMemoryError as error:
                self.notes.append(f"The grid with {factor:g} × the pixel was left out: {error}.")
                continue
            at_edge = result.ceiling is None and result.totals.edge_load is not None
            found.append((_variant(factor, result), result.totals.saturated > 0, at_edge))
        return found

    def cutoffs(self) -> tuple[Variant, ...]:
        """Return the solves of filtered maps."""
        found = []
        for length in self.lengths:
            self.number += 1
            smooth = _changed(self.pair, partial(_smoothed, length=length))
            label = f"S-filter {engineering(length, 'm')}"
            found.append(_variant(length, self.pressed(label, smooth, self.terms)))
        return tuple(found)

    def ceilings(self) -> tuple[Variant, ...]:
        """Return the solves with other ceilings."""
        found = []
        limit: Any = self.terms.ceiling
        body = self.pair.softer
        usual = limit if body is None or body.ceiling is None else body.ceiling
        for part in self.ceiling_factors:
            self.number += 1
            # A ceiling that is not three yield strengths is varied by the same parts of itself.
            factor, ceiling = part * (limit / usual), limit * part / CEILING_FACTOR
            label = f"ceiling factor {factor:.3g}"
            if self.terms.target > ceiling * self.pair.size[0] * self.pair.size[1]:
                self.notes.append(
                    f"With a ceiling factor of {factor:.3g} the load cannot be carried."
                )
                continue
            result = self.pressed(label, self.pair, replace(self.terms, ceiling=ceiling))
            found.append(_variant(factor, result))
        return tuple(found)


def _changed(pair: Pair, change: Callable[[Surface], Surface]) -> Pair:
    """Return a pair with both maps changed."""
    surface, counter = change(pair.surface), pair.counter_surface
    counter = None if counter is None else change(counter)
    return replace(pair, share=surface, counter_surface=counter)


def _variant(value: float, result: ContactResult) -> Variant:
    touching, nominal = result.contact_area, result.pressure.size * result.pixel_area
    return Variant(
        value=value,
        shape=result.surface.shape,
        pixel=result.surface.pixel,
        contact_fraction=result.contact_fraction,
        corrected_fraction=result.corrected_contact_area / nominal,
        saturated_fraction=result.saturated_fraction,
        max_pressure=result.max_pressure,
        mean_pressure=result.load / touching if touching else math.inf,
        approach=result.approach,
        mean_gap=result.mean_gap,
        certificate=result.certificate,
    )


def _divisible(surface: Surface, boundary: Boundary) -> Surface:
    rows, columns = (
        points - points % int(max(PIXEL_FACTORS)) if axis in boundary.free_axes else points
        for axis, points in enumerate(surface.shape)
    )
    if (rows, columns) == surface.shape:
        return surface
    return surface.cropped((0, rows), (0, columns))


def _shape(shape: tuple[int, int], factor: float) -> tuple[int, int]:
    """Return the points of the same outline with pixels larger by a factor."""
    return round(shape[0] / factor), round(shape[1] / factor)


def _scaled(surface: Surface, factor: float, boundary: Boundary) -> Surface:
    """Return a map on a grid whose pixels are larger by a factor."""
    if factor == 1:
        return surface
    shape = _shape(surface.shape, factor)
    pixel = (surface.size[0] / shape[0], surface.size[1] / shape[1])
    # Along the periodic axes first, by the map's own waves.
    heights, grid = surface.heights, surface.shape
    if boundary.periodic_axes or factor < 1:
        rows, columns = (
            (shape if axis in boundary.periodic_axes else grid)[axis] for axis in (0, 1)
        )
        grid = rows, columns
        heights = filters.resample(surface.filled(1.0).heights, grid, "bandlimited")
        if factor < 1:
            grid = shape
            heights = filters.resample(heights, grid, "spline")
        if surface.missing:
            holes = np.isnan(surface.heights).astype(float)
            heights[_nearest(holes, surface.shape, grid) > 0] = np.nan
    if factor > 1 and boundary.free_axes:
        block = [int(factor) if axis in boundary.free_axes else 1 for axis in (0, 1)]
        # A hole anywhere in a block leaves no honest mean of it.
        heights = heights.reshape(shape[0], block[0], shape[1], block[1]).mean(axis=(1, 3))
    return replace(surface, heights=heights, pixel=pixel)


def _nearest(values: Array, shape: tuple[int, int], wanted: tuple[int, int]) -> Array:
    """Return a map on another grid over the same outline, each point as the nearest old one."""
    rows, columns = (
        ((np.arange(new) + 0.5) * old / new).astype(int)
        for old, new in zip(shape, wanted, strict=True)
    )
    picked: Array = values[np.ix_(rows, columns)]
    return picked


def _smoothed(surface: Surface, length: float) -> Surface:
    return replace(surface, heights=filters.gaussian(surface.heights, surface.pixel, length))
