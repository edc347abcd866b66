"""Dependence of a contact on the grid, filters and ceiling.

`limits`: Grid convergence index. With the last change e, and p the logarithm to base 2 of the
previous change over e, restricted to 0.5 to 1, the limit is between the last value but one and e
1.25/(2ᵖ - 1) beyond the last value; or 3 e to either side of the last value if the two changes
differ in sign or e is the larger change, provided that e is below 5 % or the change before both is
larger. The interval is wider on either side by 20 % of the change compared with e, a margin of this
package, calibrated on maps other than those of calibration/intervals.py.

Roache 1994, doi:10.1115/1.2910291
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Shape
from roughcontact.cautions import Caution, CautionTag, as_warning
from roughcontact.contact.ceiling import first_ceiling, resolve_ceiling
from roughcontact.contact.load_case import Load, LoadCase, resolve_force
from roughcontact.contact.memory import MemoryNeed
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.result import CALIBRATED, ContactResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.validation import check_problem
from roughcontact.errors import InputError, InsufficientMemoryError, input_error
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import CEILING_FACTOR, RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.progress import Tell, progress_callback, shows_progress_bar
from roughcontact.surface import filters
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, format_change, format_engineering

STEADY_TOLERANCE = 0.05
"""Relative change between grids below which a quantity is treated as converged."""

QUANTITIES = {
    "contact_fraction": "contact area",
    "corrected_fraction": "perimeter-corrected area",
    "saturated_fraction": "saturated area",
    "max_pressure": "maximum pressure",
    "mean_pressure": "mean pressure",
}


# Excluded: both refer to the highest point, which is higher on every finer grid.
_MOVED = ("approach", "mean_gap")

# Minimum and maximum order of convergence; the order of the contact area is one.
_ORDERS = (0.5, 1.0)

# Safety factors if three grids agree on an order, and if they do not (Roache 1994).
_AGREED, _AT_ODDS = 1.25, 3.0

# Margin over the previous change: two grids may agree by coincidence, and heights between the
# points of a map are interpolated; calibration/intervals.py measures the coverage of intervals.
_BY_CHANCE = 0.2


@dataclass(frozen=True)
class Variant:
    """Solve of a study on another grid, filter or ceiling."""

    value: float  # Pixel over that of the map, cut-off [m], or ceiling over the yield strength
    shape: tuple[int, int]  # Grid points
    pixel: tuple[float, float]  # Pixel edges [m]
    contact_fraction: float  # Contact area over nominal area (`ContactResult.contact_fraction`)
    corrected_fraction: float
    saturated_fraction: float  # Saturated area over nominal area
    max_pressure: float  # Largest pressure [Pa]
    mean_pressure: float  # Load over contact area [Pa]
    approach: float  # Approach of the bodies [m]
    mean_gap: float  # Mean gap [m]
    certificate: float  # Certificate of the solve


@dataclass(frozen=True, repr=False)
class ResolutionStudy(Result):
    """Dependence of a contact on grid, filter and ceiling.

    Parameters
    ----------
    grids : tuple of Variant
        The same load on coarser and finer grids, the coarsest first.
    cutoffs : tuple of Variant
        The map without waves shorter than a cut-off, the longest first.
    ceilings : tuple of Variant
        Ceilings of 2.8 to 3.2 yield strengths, or the same parts of another one; empty for an
        elastic contact or a ceiling that differs from pixel to pixel.
    at_ceiling : bool
        Whether the largest pressure is the ceiling on each of the three finest grids.
    at_edge : bool
        Whether the largest pressure has no limit: without a ceiling, contact reaches an edge at
        which the map ends, on the finest grid.
    notes : tuple of str
        Omitted grids and ceilings, with the reason.
    """

    grids: tuple[Variant, ...]
    cutoffs: tuple[Variant, ...]
    ceilings: tuple[Variant, ...]
    at_ceiling: bool
    at_edge: bool = False
    notes: tuple[str, ...] = ()

    def values(self, name: str) -> tuple[float, ...]:
        """Return a quantity on each grid, the coarsest first."""
        known = (*QUANTITIES, *_MOVED)
        if name not in known:
            raise input_error("name", name, f"must be one of {', '.join(known)}")
        return tuple(getattr(grid, name) for grid in self.grids)

    def changes(self, name: str) -> tuple[float, ...]:
        """Return the relative changes of a quantity from each grid to the next finer one."""
        return tuple(_change(old, new) for old, new in pairwise(self.values(name)))

    def limits(self, name: str) -> tuple[float, float]:
        """Return the bounds of a quantity on ever finer grids; see the function `limits`."""
        if self.at_edge and name == "max_pressure":
            return max(self.values(name)), math.inf
        return limits(self.values(name))

    def independent(self, name: str) -> bool:
        """Return whether a quantity no longer changes with the pixel.

        The quantity must change by less than 5 % over the two finest steps: from twice the pixel of
        the map to its pixel, and on to half its pixel. A largest pressure without a limit is never
        independent.
        """
        if self.at_edge and name == "max_pressure":
            return False
        return all(abs(change) < STEADY_TOLERANCE for change in self.changes(name)[-2:])

    @property
    def grid_quantities(self) -> tuple[str, ...]:
        """Names of the quantities that indicate whether the contact depends on the grid.

        A quantity that is zero on all grids is excluded, as is the largest pressure if it is the
        ceiling or has no limit.
        """
        text = (name for name in QUANTITIES if any(self.values(name)))
        known = self.at_ceiling or self.at_edge
        return tuple(name for name in text if not (known and name == "max_pressure"))

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the result of the map, from this study."""
        changes = {
            name: max(self.changes(name)[-2:], key=abs)
            for name in self.grid_quantities
            if not self.independent(name)
        }
        if not changes:
            return ()
        name = max(changes, key=lambda name: abs(changes[name]))
        return (
            as_warning(
                CautionTag.PIXEL,
                f"Depends on the pixel: {QUANTITIES[name]} changes by "
                f"{format_change(changes[name])} "
                "when the pixel is halved.",
                **{name: changes.pop(name)},
                **changes,
            ),
        )

    @property
    def sentences(self) -> tuple[str, ...]:
        """Conclusions of the study, one sentence each."""
        names = [name for name in QUANTITIES if any(self.values(name))]
        studied = self.grid_quantities
        steady = [QUANTITIES[name] for name in studied if self.independent(name)]
        pixels = [format_engineering(max(grid.pixel), "m", 3) for grid in self.grids[-3:]]
        said = []
        if steady:
            said.append(
                f"Independent of the grid (less than {100 * STEADY_TOLERANCE:.0f} % change at each "
                "step over "
                f"pixels of {', '.join(pixels)}): {', '.join(steady)}."
            )
        for name in studied:
            if self.independent(name):
                continue
            steps = [
                f"{format_change(change)} at {pixel}"
                for change, pixel in zip(self.changes(name)[-2:], pixels[1:], strict=True)
            ]
            said.append(
                f"Not converged: from a pixel of {pixels[0]} on the {QUANTITIES[name]} changes by "
                f"{', '.join(steps)}; it reflects the pixel size, and a finer measurement may give "
                "another value."
            )
        if self.at_ceiling:
            said.append(
                "The maximum pressure is the ceiling on these grids: that it does not change says "
                "nothing about the resolution."
            )
        if self.at_edge:
            said.append(
                "The maximum pressure has no limit: the contact is elastic and reaches an edge of "
                "the map."
            )
        if len(self.cutoffs) > 1:
            said.append(_span("Filtering", "the cut-off", self.cutoffs, studied, "m"))
        if len(self.ceilings) > 1:
            said.append(_span("Ceiling", "the factor", self.ceilings, names, ""))
        return (*said, *self.notes)

    def labeled_variants(self) -> list[tuple[str, Variant]]:
        """Return every solve with its name."""
        names = [(f"pixel {format_engineering(max(v.pixel), 'm')}", v) for v in self.grids]
        names += [(f"S-filter {format_engineering(v.value, 'm')}", v) for v in self.cutoffs]
        return names + [(f"ceiling {v.value:.3g} × yield", v) for v in self.ceilings]


def limits(values: Sequence[float]) -> tuple[float, float]:
    """Return the bounds of a quantity in the limit, from its values on several grids."""
    if len(values) < 3 or not all(map(math.isfinite, values)):
        return math.nan, math.nan
    changes = [new - old for old, new in pairwise(values[-4:])]
    last, before, size = values[-1], changes[-2], abs(changes[-1])
    if size < abs(before) and changes[-1] * before > 0:
        order = min(max(math.log2(abs(before) / size), _ORDERS[0]), _ORDERS[1])
        beyond = last + changes[-1] * _AGREED / (2**order - 1)
        ends = values[-2], beyond
    else:
        if size >= abs(before):
            before = changes[0]
        if size >= abs(before) and size > STEADY_TOLERANCE * abs(last):
            return -math.inf, math.inf
        ends = last - _AT_ODDS * size, last + _AT_ODDS * size
    margin = _BY_CHANCE * abs(before)
    return min(ends) - margin, max(ends) + margin


def _change(old: float, new: float) -> float:
    if old == new:
        return 0.0
    return new / old - 1 if old else math.inf


def _span(
    what: str, argument: str, variants: tuple[Variant, ...], names: Sequence[str], unit: str
) -> str:
    first, last = variants[0], variants[-1]
    ends = [format_engineering(v.value, unit) if unit else f"{v.value:.3g}" for v in (first, last)]
    parts = [
        f"{QUANTITIES[name]} {format_change(_change(getattr(first, name), getattr(last, name)))}"
        for name in names
    ]
    return f"{what}: as {argument} goes from {ends[0]} to {ends[1]}: {', '.join(parts)}."


Array = NDArray[np.float64]


PIXEL_FACTORS = (4.0, 2.0, 1.0, 0.5)
"""Pixels of the grids over that of the map."""

CUTOFFS = (4, 8, 16)
"""Cut-offs of the S-filter over the larger pixel edge."""

CEILING_FACTORS = (2.8, 3.0, 3.2)
"""Ceilings over the yield strength, from Tabor's 2.8 for metals to 3.2."""


_MIN_POINTS = 32


@shows_progress_bar
@validate_arguments
def resolution_study(
    surface: Surface,
    *,
    material: Material,
    load: Quantity | Load,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
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
        As for `solve`. All solves have the calibrated ceiling on the map itself, or of both
        ceilings of a coated body (``"bracket"``) that of the coating.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`: the number of the solve, its name and the solver's `Step`.

    Returns
    -------
    ResolutionStudy
        The solves and their conclusions.

    Raises
    ------
    InputError, CapacityError, ConvergenceError
        As for `solve`; and `InputError` if the map has fewer than 64 points along a side.

    Notes
    -----
    Coarser grids contain block means, as an instrument with larger pixels would measure; the
    finer one is interpolated by cubic splines (free) or by its own waves (periodic).
    It adds no roughness and shows the error of the grid alone. The trend over the coarser grids
    shows whether peaks below the pixel would change the result.
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
contact area, perimeter-corrected area, maximum pressure, mean pressure.
    """
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    terms = LoadCase(
        load=resolve_force(load, pair)[0], ceiling=ceiling, tolerance=tolerance, precision=precision
    )
    return _checked_study(pair, terms, progress).run()


def _checked_study(pair: Pair, terms: LoadCase, progress: Tell) -> _Study:
    """Return a study with checked arguments and the common ceiling of its solves."""
    pair.require_map("a study of the resolution")
    if min(pair.shape) < 2 * _MIN_POINTS:
        raise InputError(
            f"has {pair.shape[0]} × {pair.shape[1]} points: a study of the "
            f"resolution needs at least {2 * _MIN_POINTS} along each side",
            argument="surface",
        )
    terms = replace(terms, ceiling=first_ceiling(pair, terms.ceiling))
    check_problem(pair, terms)
    limit = resolve_ceiling(terms.ceiling, pair)
    if isinstance(terms.ceiling, str) and terms.ceiling == CALIBRATED:
        limit = solve_pair(pair, terms).ceiling
    return _Study(pair, replace(terms, ceiling=limit), progress)


def coarsen_pair(pair: Pair) -> Pair | None:
    """Return the same bodies on a grid of twice the pixel, as in the study."""
    if min(pair.shape) < 2 * _MIN_POINTS:
        return None
    outline = _change_maps(pair, partial(_divisible, boundary=pair.boundary))
    return _change_maps(outline, partial(_coarsen, factor=2.0, boundary=pair.boundary))


@dataclass(eq=False)
class _Study:
    """Solves of a study, one after the other, with notes on omitted solves."""

    pair: Pair
    terms: LoadCase
    progress: Tell
    number: int = 0
    notes: list[str] = field(default_factory=list)

    def run(self) -> ResolutionStudy:
        """Return the study of grids, filters and ceilings."""
        grids = self.grids()
        return ResolutionStudy(
            grids=tuple(grid for grid, _, _ in grids),
            cutoffs=self.cutoffs(),
            ceilings=self.ceilings(),
            at_ceiling=all(saturated for _, saturated, _ in grids[-3:]),
            at_edge=any(at_edge for _, _, at_edge in grids[-1:]),
            notes=tuple(self.notes),
        )

    @property
    def factors(self) -> list[float]:
        """Pixels of the grids with enough points, over the pixel of the map."""
        return [f for f in PIXEL_FACTORS if min(self.pair.shape) / f >= _MIN_POINTS]

    @property
    def lengths(self) -> list[float]:
        """Cut-offs up to the shorter side of the map [m]."""
        lengths = [points * max(self.pair.pixel) for points in sorted(CUTOFFS, reverse=True)]
        return [length for length in lengths if length <= min(self.pair.size)]

    @property
    def ceiling_factors(self) -> tuple[float, ...]:
        """Ceilings over the yield strength; none without a ceiling or with one per pixel."""
        return CEILING_FACTORS if isinstance(self.terms.ceiling, float) else ()

    def solve_next(self, label: str, pair: Pair, terms: LoadCase) -> ContactResult:
        """Solve a contact with progress of the study, and return its result."""
        count = len(self.factors) + len(self.lengths) + len(self.ceiling_factors)
        return solve_pair(
            pair, terms, progress=progress_callback(self.progress, self.number, count, label)
        )

    def grids(self) -> list[tuple[Variant, bool, bool]]:
        """Return the solves on other grids, with flags: reaches a ceiling, reaches a free edge."""
        boundary = self.pair.boundary
        outline = _change_maps(self.pair, partial(_divisible, boundary=boundary))
        answer = []
        for factor in self.factors:
            self.number += 1
            terms, limit = self.terms, self.terms.ceiling
            try:
                # Checked before the map is created: the finer grid has four times the points.
                MemoryNeed(_shape(outline.shape, factor), boundary, terms.precision).require()
                scaled = _change_maps(outline, partial(_coarsen, factor=factor, boundary=boundary))
                if isinstance(limit, np.ndarray):
                    terms = replace(terms, ceiling=_nearest(limit, outline.shape, scaled.shape))
                result = self.solve_next(f"pixel × {factor:g}", scaled, terms)
            except InsufficientMemoryError as error:
                self.notes.append(f"The grid with {factor:g} × the pixel was left out: {error}.")
                continue
            at_edge = result.ceiling is None and result.totals.edge_load is not None
            answer.append((_variant(factor, result), result.totals.saturated > 0, at_edge))
        return answer

    def cutoffs(self) -> tuple[Variant, ...]:
        """Return the solves of filtered maps."""
        result = []
        for length in self.lengths:
            self.number += 1
            smooth = _change_maps(self.pair, partial(_smooth, length=length))
            label = f"S-filter {format_engineering(length, 'm')}"
            result.append(_variant(length, self.solve_next(label, smooth, self.terms)))
        return tuple(result)

    def ceilings(self) -> tuple[Variant, ...]:
        """Return the solves with other ceilings."""
        answer = []
        limit: Any = self.terms.ceiling
        body = self.pair.softer
        usual = limit if body is None or body.ceiling is None else body.ceiling
        for part in self.ceiling_factors:
            self.number += 1
            # A ceiling other than three yield strengths is varied by the same relative amounts.
            factor, ceiling = part * (limit / usual), limit * part / CEILING_FACTOR
            label = f"ceiling factor {factor:.3g}"
            if self.terms.target > ceiling * self.pair.size[0] * self.pair.size[1]:
                self.notes.append(
                    f"With a ceiling factor of {factor:.3g} the load cannot be carried."
                )
                continue
            result = self.solve_next(label, self.pair, replace(self.terms, ceiling=ceiling))
            answer.append(_variant(factor, result))
        return tuple(answer)


def _change_maps(pair: Pair, change: Callable[[Surface], Surface]) -> Pair:
    """Return a pair with both maps changed."""
    surface, counter = change(pair.surface), pair.counter_surface
    counter = None if counter is None else change(counter)
    return replace(pair, surface=surface, counter_surface=counter)


def _variant(value: float, result: ContactResult) -> Variant:
    touching, nominal = result.contact_area, result.pressure.size * result.pixel_area
    return Variant(
        value=value,
        shape=result.surface.shape,
        pixel=result.surface.pixel,
        contact_fraction=result.contact_fraction,
        corrected_fraction=result.perimeter_corrected_area / nominal,
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


def _shape(shape: Shape, factor: float) -> tuple[int, int]:
    """Return the number of points of the same outline with pixels larger by a factor."""
    return round(shape[0] / factor), round(shape[1] / factor)


def _coarsen(surface: Surface, factor: float, boundary: Boundary) -> Surface:
    """Return a map on a grid whose pixels are larger by a factor."""
    if factor == 1:
        return surface
    shape = _shape(surface.shape, factor)
    pixel = (surface.size[0] / shape[0], surface.size[1] / shape[1])
    # First along the periodic axes, by the Fourier series of the map.
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
        # A block with a missing point has no unbiased mean: the result is missing as well.
        heights = heights.reshape(shape[0], block[0], shape[1], block[1]).mean(axis=(1, 3))
    return replace(surface, heights=heights, pixel=pixel)


def _nearest(values: Array, shape: Shape, wanted: tuple[int, int]) -> Array:
    """Return a map on another grid over the same outline by nearest-neighbor sampling."""
    rows, columns = (
        ((np.arange(new) + 0.5) * old / new).astype(int)
        for old, new in zip(shape, wanted, strict=True)
    )
    return values[np.ix_(rows, columns)]


def _smooth(surface: Surface, length: float) -> Surface:
    return replace(
        surface, heights=filters.gaussian_lowpass(surface.heights, surface.pixel, length)
    )
