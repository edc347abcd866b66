"""Required map size, from the scatter between parts of a map."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import fmean
from typing import Any

from numpy.typing import ArrayLike

from roughcontact._tools import statistics
from roughcontact._tools.arguments import validate_arguments
from roughcontact.analyses.sweep.model import LoadCurve, contact_curve
from roughcontact.cautions import Caution, CautionTag, as_caution, as_note, sort_cautions
from roughcontact.contact.ceiling import is_bracket
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import BASE, COATING
from roughcontact.contact.solve import add_calibrated
from roughcontact.errors import ConvergenceError, InputError, Sentence, require_positive
from roughcontact.material.material import RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.progress import Progress, Tell, shows_progress_bar
from roughcontact.surface import resolution
from roughcontact.surface.placement import is_divisible, partition
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, count_noun, format_change, to_si

CONTACT = ("contact_fraction", "saturated_fraction", "max_pressure", "mean_gap", "approach")
"""Contact quantities under the largest pressure."""

ROUGHNESS = ("Sq", "Sa", "Ssk", "Sku", "Sdq", "Sal", "Sk", "Spk", "Svk")
"""Parameters of the prepared map, after ISO 25178-2."""

NUMBERS = (*CONTACT, *ROUGHNESS)
"""Quantities that maps are compared by."""

NAMES = {
    "contact_fraction": "contact area",
    "saturated_fraction": "saturated area",
    "mean_gap": "mean gap",
}
"""Names of some `NUMBERS` in messages."""

CURVES = ("contact_fraction", "saturated_fraction", "mean_gap", "approach")
"""Quantities with a curve over the pressure."""

CALIBRATED_NUMBERS = ("contact_fraction", "saturated_fraction", "mean_gap", "approach")
"""Quantities that are known under the calibrated ceiling as well."""

_LENGTHS = ("mean_gap", "approach", "max_pressure")


@dataclass(frozen=True, eq=False)
class Sample:
    """One map under one or several nominal pressures."""

    name: str  # Name
    source: str  # Origin of the map
    part: bool  # Whether it was cropped from a larger map
    size: tuple[float, float]  # Sides (y, x) of the map [m]
    pixel: tuple[float, float]  # Pixel edges (y, x) [m]
    shortest_wave: float  # [m]
    curve: LoadCurve  # Contact under the pressures
    roughness: Mapping[str, float]  # `ROUGHNESS` of the map, in SI units
    bodies: tuple[Material, Material]  # Rough body, and counter-body
    # Numbers under the largest pressure and the calibrated ceiling, where they differ [SI]
    calibrated: Mapping[str, float] = field(default_factory=dict)
    # The map under the ceiling of the base of a coated body, if both ceilings were requested
    base: Sample | None = None
    is_calibrated: bool = False  # Whether its numbers are those under the calibrated ceiling

    @property
    def other_ceiling(self) -> dict[str, float]:
        """Contact quantities under the calibrated ceiling or that of the base, if known [SI]."""
        return {**self.calibrated, **({} if self.base is None else self.base.contact_numbers)}

    @property
    def contact_numbers(self) -> dict[str, float]:
        """The `CONTACT` quantities by name, in SI units."""
        if self.is_calibrated:
            return {name: self.calibrated.get(name, math.nan) for name in CONTACT}
        return {name: self.over_pressure(name)[-1] for name in CONTACT}

    @property
    def numbers(self) -> dict[str, float]:
        """All `NUMBERS` by name, in SI units."""
        return self.contact_numbers | {name: self.roughness[name] for name in ROUGHNESS}

    def over_pressure(self, name: str) -> list[float]:
        """Return one of `CONTACT` under all pressures [SI]."""
        if name in _LENGTHS:
            return [float(value) for value in self.curve.column(name)]
        area = self.curve.column(name.replace("_fraction", "_area"))
        return [float(value) for value in area / self.curve.nominal_area]

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the contacts of the map."""
        return self.curve.cautions


def solve_by_ceiling(
    surface: Surface,
    problem: Mapping[str, Any],
    solve: Callable[[Mapping[str, Any]], tuple[Sample, ...]],
) -> tuple[Sample, ...]:
    """Return the samples of a problem, of a coated body under both ceilings if requested."""
    bodies = problem["material"], None, problem.get("counter_material", RIGID)
    pair = Pair.from_arguments(surface, *bodies, problem.get("boundary", "free"))
    if not is_bracket(pair, problem.get("ceiling")):
        return solve(problem)
    coating, base = (solve({**problem, "ceiling": ceiling}) for ceiling in (COATING, BASE))
    return tuple(replace(first, base=other) for first, other in zip(coating, base, strict=True))


def solve_sample(
    surface: Surface,
    name: str,
    pressures: Sequence[float],
    problem: Mapping[str, Any],
    progress: Tell = None,
    is_calibrated: bool = False,
) -> Sample:
    """Solve one map under all pressures and one ceiling; return its sample.

    With ``is_calibrated`` the largest pressure is solved under the calibrated ceiling as well.
    """
    surface.require_map("a comparison")
    area = surface.size[0] * surface.size[1]
    watch = None
    if callable(progress):
        tell = progress

        def watch(state: Progress) -> None:
            tell(replace(state, label=name))

    try:
        loads = [pressure * area for pressure in pressures]
        curve = contact_curve(surface, loads, watch, **problem)
    except ConvergenceError as error:
        raise ConvergenceError(Sentence(f"{name}: ", *error.parts), error.result) from None
    values = surface.roughness()
    calibrated = _calibrated_numbers(curve, problem.get("ceiling")) if is_calibrated else {}
    return Sample(
        name=name,
        source=surface.provenance.source,
        part=any(step.method == "cropped" for step in surface.provenance.operations),
        size=surface.size,
        pixel=surface.pixel,
        shortest_wave=_shortest_wave(surface),
        # Without the solver, which would keep the map in memory.
        curve=replace(curve, _solve_largest=None),
        roughness={key: values[key] for key in ROUGHNESS},
        bodies=(problem["material"], problem.get("counter_material", RIGID)),
        calibrated=calibrated,
    )


def _calibrated_numbers(curve: LoadCurve, ceiling: Any) -> dict[str, float]:
    """Return the numbers under the largest pressure and the calibrated ceiling, if they differ."""
    if not (isinstance(ceiling, str) and ceiling == "auto"):
        return {}
    other = add_calibrated(curve.largest).calibrated
    return {} if other is None else {name: getattr(other, name) for name in CALIBRATED_NUMBERS}


def _shortest_wave(surface: Surface) -> float:
    filters = (step for step in surface.provenance.operations if step.method == "filtered")
    cuts = [float(step.arguments["s"] or 0.0) for step in filters]
    return max([resolution.shortest_wave(surface.heights, surface.pixel), *cuts])


# Required area, from the scatter between parts of a map and its decrease with the area.


AVERAGES = ("contact_fraction", "saturated_fraction", "mean_gap", "Sq", "Sa", "Sdq")
"""Quantities that are means over a map; others (peak pressure) grow with its size."""

WANTED = 0.05
"""Relative error for which the required area is given."""

DIVISIONS = (2, 4, 8)
"""Parts along a side of the map."""

# Relative difference of the mean of the parts from the whole map above which it is reported.
_DRIFT = 0.05


@dataclass(frozen=True)
class SamplingError:
    """Sampling error of a quantity of a map, compared with an infinite surface."""

    name: str  # One of `AVERAGES`
    value: float  # Value of the whole map [SI]
    half: float  # Half-width of the interval at confidence `statistics.LEVEL` [SI]
    parts: int  # Number of equal parts whose scatter gives the error
    area: float  # Area at which the half-width is `WANTED` of the value [m²]
    area_low: float  # Lower end of the interval of the area [m²]
    area_high: float  # Upper end of the interval of the area [m²]
    drift: float
    scaling: float  # Scaling of the scatter: 1 if it falls with the root of the area
    falls: bool  # Whether chance explains a `scaling` other than 1

    @property
    def relative(self) -> float:
        """Half-width of the interval over the value."""
        return self.half / abs(self.value)

    @property
    def bound(self) -> str:
        """Kind of bound of error and area ("at most", "at least"); empty for an estimate."""
        if self.falls:
            return ""
        return "at most" if self.scaling < 1 else "at least"


@dataclass(frozen=True, eq=False, repr=False)
class SamplingStudy(Result):
    """Map and its parts, with the required area from their scatter.

    Parameters
    ----------
    whole : Sample
        The map.
    levels : mapping of int to tuple of Sample
        Parts of the map, by their number along a side.
    """

    whole: Sample
    levels: Mapping[int, tuple[Sample, ...]]

    @property
    def base(self) -> SamplingStudy | None:
        """The study under the ceiling of the base of a coated body, if both were requested."""
        if self.whole.base is None:
            return None
        levels = {
            number: tuple(part.base for part in parts if part.base is not None)
            for number, parts in self.levels.items()
        }
        return SamplingStudy(self.whole.base, levels)

    @property
    def name(self) -> str:
        """Name of the map."""
        return self.whole.name

    @property
    def pressure(self) -> float:
        """Nominal pressure [Pa]."""
        return self.whole.curve.steps[-1].load / self.whole.curve.nominal_area

    @property
    def errors(self) -> tuple[SamplingError, ...]:
        """Sampling errors of the nonzero `AVERAGES`."""
        names = (name for name in AVERAGES if self.whole.numbers[name])
        return tuple(self.error(name) for name in names)

    def values(self, divisions: int, name: str) -> list[float]:
        """Return a quantity of all parts of a level [SI]."""
        return [part.numbers[name] for part in self.levels[divisions]]

    def error(self, name: str) -> SamplingError:
        """Return the sampling error of one of `AVERAGES`.

        Each part is leveled and solved separately, under the nominal pressure of the whole map;
        the error follows from their scatter (`statistics.parts_interval`).
        """
        value = self.whole.numbers[name]
        result = statistics.parts_interval({n: self.values(n, name) for n in self.levels})
        parts = self.values(result.divisions, name)
        area = self.whole.curve.nominal_area * (result.half / (WANTED * value)) ** 2
        low, high = statistics.deviation_range(result.parts)
        return SamplingError(
            name=name,
            value=value,
            half=result.half,
            parts=result.parts,
            area=area,
            area_low=area * low**2,
            area_high=area * high**2,
            drift=fmean(parts) / value - 1,
            scaling=result.scaling,
            falls=result.falls,
        )

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the study, the most severe first."""
        return sort_cautions([*self.whole.cautions, *self._sampling_cautions()])

    def _sampling_cautions(self) -> Iterator[Caution]:
        """Yield cautions on how well the parts represent the map."""
        errors = self.errors
        yield from self._scaling_caution(errors)
        few = min(item.parts for item in errors) if errors else 0
        if few and few < statistics.MIN_COUNT**2:
            yield as_note(
                CautionTag.SAMPLING,
                f"Only {count_noun(few, 'part')}: stated errors are uncertain by a factor of "
                f"{statistics.deviation_range(few)[1]:.1f}.",
                parts=few,
            )
        yield as_note(
            CautionTag.PARTS,
            "Parts are of one map: scatter excludes other places, pieces and measurements.",
        )

    def _scaling_caution(self, errors: Sequence[SamplingError]) -> Iterator[Caution]:
        """Yield the main caution on the scaling of the errors to larger maps."""
        drifting = {
            item.name: item.drift for item in errors if abs(item.drift) > max(_DRIFT, item.relative)
        }
        falls = {item.name: item.scaling for item in errors if not item.falls}
        if drifting:
            name = max(drifting, key=lambda name: abs(drifting[name]))
            text = (
                f"{_title(name)} depends on map size ({format_change(drifting[name])} in the "
                "parts): no area is large enough."
            )
            numbers = {name: drifting[name], **drifting}
        elif any(math.isnan(scaling) for scaling in falls.values()):
            text = (
                "Too few parts: stated errors and areas are lower bounds. Use 128 points per side."
            )
            numbers = {}
        elif any(scaling > 1 for scaling in falls.values()):
            text = "Scatter falls slower than 1/√area: stated errors and areas are lower bounds."
            numbers = falls
        elif falls:
            text = "Scatter falls faster than 1/√area: stated errors and areas are upper bounds."
            numbers = falls
        else:
            return
        yield as_caution(CautionTag.SAMPLING, text, **numbers)


@shows_progress_bar
@validate_arguments
def sampling_study(
    surface: Surface,
    *,
    material: Material,
    pressure: Quantity,
    level: str = "plane",
    counter_material: Material = RIGID,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    progress: Tell = None,
) -> SamplingStudy:
    """Solve a map and its parts, and estimate the area needed.

    Parameters
    ----------
    surface : Surface
        The map, of 64 points a side at least.
    material, counter_material, ceiling, boundary, tolerance, max_iterations
        As for `solve`.
    pressure : float, str or quantity of pint
        Nominal pressure [Pa] on the map and on each part.
    level : {"plane", "quadric", "mean", "robust", "none"}
        Leveling of each part, as of a map of that size.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`, the part as its label.

    Returns
    -------
    SamplingStudy
        4, 16 and 64 parts, with at least 16 points per side, and the errors from their scatter.

    Raises
    ------
    InputError
        If an argument cannot be used, or the map is too small for sixteen parts.
    CapacityError, InsufficientMemoryError, ConvergenceError
        As for `solve`.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> study = rc.sampling_study(
    ...     rc.Surface(*rc.reference_map(64)), material=steel, pressure="100 MPa"
    ... )
    >>> found = study.error("contact_fraction")
    >>> found.parts, found.area_low < found.area < found.area_high
    (16, True)
    """
    specified = to_si(pressure, "pressure", "pressure")
    require_positive(pressure=specified)
    if not is_divisible(surface.shape, statistics.MIN_COUNT):
        ny, nx = surface.shape
        raise InputError(
            f"needs 64 points along each side for sixteen parts, got {ny} × {nx}",
            argument="surface",
        )
    problem = {
        "material": material,
        "counter_material": counter_material,
        "ceiling": ceiling,
        "boundary": boundary,
        "tolerance": tolerance,
        "max_iterations": max_iterations,
    }
    name, pressures = surface.provenance.source or "map", [float(specified)]

    def solve_map(surface: Surface, name: str) -> Sample:
        def solve(problem: Mapping[str, Any]) -> tuple[Sample, ...]:
            return (solve_sample(surface, name, pressures, problem, progress),)

        (sample,) = solve_by_ceiling(surface, problem, solve)
        return sample

    levels = {}
    for divisions in (n for n in DIVISIONS if is_divisible(surface.shape, n)):
        parts = partition(surface, divisions, level)
        levels[divisions] = tuple(
            solve_map(part, f"{name}, part {n} of {len(parts)}")
            for n, part in enumerate(parts, start=1)
        )
    return SamplingStudy(solve_map(surface, name), levels)


def _title(name: str) -> str:
    text = NAMES.get(name, name)
    return text[0].upper() + text[1:]
