"""Can a result be trusted: the same contact on other grids, with other filters and ceilings."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.contact import solve
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.result import ContactResult
from roughcontact.contact.study import ResolutionStudy, Variant
from roughcontact.errors import InputError, InsufficientMemoryError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import CEILING_FACTOR, RIGID, Material
from roughcontact.surface import filters
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering

Array = NDArray[np.float64]


PIXEL_FACTORS = (4.0, 2.0, 1.0, 0.5)
"""Pixels of the grids over that of the map."""

CUTOFFS = (4, 8, 16)
"""Cut-offs of the S-filter over the larger pixel edge."""

CEILING_FACTORS = (2.8, 3.0, 3.2)
"""Ceilings over the yield strength, from Tabor's 2.8 for metals to 3.2."""


_FEWEST_POINTS = 32


def resolution_study(
    surface: Surface,
    *,
    material: Material,
    load: float,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: str | float | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    precision: str = "double",
    progress: Callable[[str], None] | None = None,
) -> ResolutionStudy:
    """Solve the same contact on other grids, with other filters and other ceilings.

    Parameters
    ----------
    surface, material, load, counter_material, counter_surface, ceiling, boundary, tolerance, \
precision
        As for `solve`.
    progress : callable, optional
        Called with a few words before every solve.

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
contact area, maximum pressure, mean pressure.
    """
    if min(surface.shape) < 2 * _FEWEST_POINTS:
        raise InputError(
            f"has {surface.shape[0]} × {surface.shape[1]} points: a study of the "
            f"resolution needs at least {2 * _FEWEST_POINTS} along each side",
            argument="surface",
        )
    options: dict[str, Any] = {
        "load": load,
        "material": material,
        "counter_material": counter_material,
        "boundary": boundary,
        "tolerance": tolerance,
        "precision": precision,
    }
    solve.check(surface, **options, counter_surface=counter_surface, ceiling=ceiling)
    limit = resolved_ceiling(ceiling, material, counter_material, surface.shape)
    bodies = [body for body in (surface, counter_surface) if body is not None]
    beyond = Boundary(boundary)
    say = progress or (lambda text: None)

    def solved(maps: list[Surface], at: float | Array | None) -> ContactResult:
        return solve.solve(
            maps[0], **options, counter_surface=maps[1] if len(maps) > 1 else None, ceiling=at
        )

    outline = [_divisible(body, beyond) for body in bodies]
    grids, saturated, notes = [], [], []
    for factor in PIXEL_FACTORS:
        if min(surface.shape) / factor < _FEWEST_POINTS:
            continue
        say(f"pixel × {factor:g}")
        maps = [_scaled(body, factor, beyond) for body in outline]
        at = limit
        if isinstance(limit, np.ndarray):
            at = _nearest(limit, outline[0].shape, maps[0].shape)
        try:
            found = solved(maps, at)
        except InsufficientMemoryError as error:
            notes.append(f"The grid with {factor:g} × the pixel was left out: {error}.")
            continue
        grids.append(_variant(factor, found))
        saturated.append(bool(found.saturated.any()))
    cutoffs = []
    for points in sorted(CUTOFFS, reverse=True):
        length = points * max(surface.pixel)
        if length > min(surface.size):
            continue
        say(f"S-filter {engineering(length, 'm')}")
        cutoffs.append(
            _variant(length, solved([_smoothed(body, length) for body in bodies], limit))
        )
    ceilings = []
    if isinstance(limit, float):
        for factor in CEILING_FACTORS:
            say(f"ceiling factor {factor:g}")
            changed = limit * factor / CEILING_FACTOR
            if load > changed * surface.size[0] * surface.size[1]:
                notes.append(f"With a ceiling factor of {factor:g} the load cannot be carried.")
                continue
            ceilings.append(_variant(factor, solved(bodies, changed)))
    return ResolutionStudy(
        tuple(grids), tuple(cutoffs), tuple(ceilings), all(saturated[-3:]), tuple(notes)
    )


def _variant(value: float, found: ContactResult) -> Variant:
    area = found.corrected_contact_area
    return Variant(
        value=value,
        shape=found.surface.shape,
        pixel=found.surface.pixel,
        contact_fraction=area / (found.pressure.size * found.pixel_area),
        saturated_fraction=found.saturated_fraction,
        max_pressure=found.max_pressure,
        mean_pressure=found.load / area if area else math.inf,
        certificate=found.certificate,
    )


def _divisible(surface: Surface, boundary: Boundary) -> Surface:
    rows, columns = (
        points - points % int(max(PIXEL_FACTORS)) if axis in boundary.free_axes else points
        for axis, points in enumerate(surface.shape)
    )
    if (rows, columns) == surface.shape:
        return surface
    return surface.cropped((0, rows), (0, columns))


def _scaled(surface: Surface, factor: float, boundary: Boundary) -> Surface:
    """Return a map on a grid whose pixels are larger by a factor."""
    if factor == 1:
        return surface
    ny, nx = surface.shape
    shape = (round(ny / factor), round(nx / factor))
    pixel = (surface.size[0] / shape[0], surface.size[1] / shape[1])
    # Along the periodic axes first, by the map's own waves.
    heights, grid = surface.heights, surface.shape
    if boundary.periodic_axes or factor < 1:
        rows, columns = (
            (shape if axis in boundary.periodic_axes else grid)[axis] for axis in (0, 1)
        )
        grid = rows, columns
        heights = filters.resample(surface.filled().heights, grid, "bandlimited")
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
