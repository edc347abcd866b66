"""How large an area is needed: the scatter between parts of a map, and how it falls with area."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from numpy.typing import ArrayLike

from roughcontact import statistics
from roughcontact.arguments import checked
from roughcontact.contact.cautions import Caution, Kind, careful, noted, ordered, warned
from roughcontact.contact.sample import NAMES, Sample, sample
from roughcontact.errors import InputError, require_positive
from roughcontact.material.material import RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.bar import drawn
from roughcontact.solvers.progress import Tell
from roughcontact.surface.partition import divides, partition
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, changed_by, counted, quantity

AVERAGES = ("contact_fraction", "saturated_fraction", "mean_gap", "Sq", "Sa", "Sdq")
"""Numbers that average over a map; others, such as the largest pressure, grow with it."""

WANTED = 0.05
"""Part of a number to which an area is told."""

DIVISIONS = (2, 4, 8)
"""Parts along a side of the map."""

# A mean of the parts that is off from the whole by more than this part is told.
_DRIFT = 0.05


@dataclass(frozen=True)
class SamplingError:
    """How far a number of a map may be from that of an endless surface like it.

    Parameters
    ----------
    name : str
        One of `AVERAGES`.
    value : float
        The number of the whole map [SI].
    half : float
        Half of its interval of confidence `statistics.LEVEL` [SI].
    parts : int
        Equal parts whose scatter it comes from.
    area : float
        Area at which the half would be `WANTED` of the value [m²].
    area_low, area_high : float
        Between which that area lies, since the scatter of a few parts is not sure either [m²].
    drift : float
        Mean of the parts over the value, less one: what a smaller map makes of the number.
    scaling : float
        Whether the scatter falls with the root of the area, 1 if it does; see `statistics.Whole`.
    falls : bool
        Whether chance alone explains that it is not 1; false where it is not known.
    """

    name: str
    value: float
    half: float
    parts: int
    area: float
    area_low: float
    area_high: float
    drift: float
    scaling: float
    falls: bool

    @property
    def relative(self) -> float:
        """Half of the interval over the value."""
        return self.half / abs(self.value)

    @property
    def bound(self) -> str:
        """What error and area are where the scatter is not known to fall with the area."""
        if self.falls:
            return ""
        return "at most" if self.scaling < 1 else "at least"


@dataclass(frozen=True, eq=False, repr=False)
class SamplingStudy(Result):
    """A map, its parts, and what their scatter says of the area that is needed.

    Parameters
    ----------
    whole : Sample
        The map.
    levels : mapping of int to tuple of Sample
        Its parts, by how many there are along a side.
    """

    whole: Sample
    levels: Mapping[int, tuple[Sample, ...]]

    @property
    def name(self) -> str:
        """What the map is called."""
        return self.whole.name

    @property
    def pressure(self) -> float:
        """Nominal pressure [Pa]."""
        return self.whole.curve.steps[-1].load / self.whole.curve.nominal_area

    @property
    def errors(self) -> tuple[SamplingError, ...]:
        """The error of each of `AVERAGES` that is not zero."""
        names = (name for name in AVERAGES if self.whole.numbers[name])
        return tuple(self.error(name) for name in names)

    def values(self, divisions: int, name: str) -> list[float]:
        """Return a number of all parts [SI]."""
        return [part.numbers[name] for part in self.levels[divisions]]

    def error(self, name: str) -> SamplingError:
        """Return how far a number may be from that of an endless surface; see `AVERAGES`.

        Each part is pressed by itself, leveled by itself, under the nominal pressure of the whole;
        `statistics.of_whole` says which of them tell it.
        """
        value = self.whole.numbers[name]
        found = statistics.of_whole({n: self.values(n, name) for n in self.levels})
        parts = self.values(found.divisions, name)
        area = self.whole.curve.nominal_area * (found.half / (WANTED * value)) ** 2
        low, high = statistics.spread_of(found.parts)
        return SamplingError(
            name=name,
            value=value,
            half=found.half,
            parts=found.parts,
            area=area,
            area_low=area * low**2,
            area_high=area * high**2,
            drift=math.fsum(parts) / len(parts) / value - 1,
            scaling=found.scaling,
            falls=found.falls,
        )

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        return ordered([*self.whole.cautions, *self._judged()])

    def _judged(self) -> Iterator[Caution]:
        """Yield where the parts do not stand for the whole."""
        errors = self.errors
        blind = [one for one in errors if math.isnan(one.scaling)]
        if blind:
            yield careful(
                Kind.SCALING,
                "a map below 128 points a side has too few parts to tell whether the scatter falls "
                "with the root of the area; error and area are at least what is told",
                parts=max(one.parts for one in blind),
            )
        slow = [one for one in errors if not one.falls and one.scaling > 1]
        if slow:
            yield warned(
                Kind.SCALING,
                f"{_names(slow)}: neighboring parts are alike, the scatter falls more slowly than "
                "with the root of the area; error and area are at least what is told, and waves "
                "longer than the parts make a larger map differ in more than its error",
                **{one.name: one.scaling for one in slow},
            )
        fast = [one for one in errors if not one.falls and one.scaling < 1]
        if fast:
            yield careful(
                Kind.SCALING,
                f"{_names(fast)}: the scatter falls faster than with the root of the area, by what "
                "edges and single pixels do to small parts; error and area are at most what is "
                "told",
                **{one.name: one.scaling for one in fast},
            )
        drifting = [one for one in errors if abs(one.drift) > max(_DRIFT, one.relative)]
        if drifting:
            told = ", ".join(f"{_names([one])} {changed_by(one.drift)}" for one in drifting)
            yield careful(
                Kind.SCALING,
                f"the parts have other means than the whole ({told}): these numbers depend on the "
                "size of a map, and a larger one moves them by more than its error",
                **{one.name: one.drift for one in drifting},
            )
        few = min(one.parts for one in errors) if errors else 0
        if few and few < statistics.USUAL**2:
            yield careful(
                Kind.FEW,
                f"some errors come from {counted(few, 'part')} alone: they are told to a factor of "
                f"{statistics.spread_of(few)[1]:.1f}",
                parts=few,
            )
        yield noted(
            Kind.PARTS,
            "parts of one map tell of other places like this one; they say nothing of a place that "
            "looks different, of another piece or of the instrument",
        )


@drawn
@checked
def sampling_error(
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
    """Press a map and its parts, and tell how large an area is needed.

    Parameters
    ----------
    surface : Surface
        The map, of 64 points a side at least.
    material, counter_material, ceiling, boundary, tolerance, max_iterations
        As for `solve`.
    pressure : float, str or quantity of pint
        Nominal pressure [Pa] on the map and on each part.
    level : {"plane", "quadric", "mean", "robust", "none"}
        What is subtracted from each part, as from a map of that size.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`, the part as its label.

    Returns
    -------
    SamplingStudy
        4, 16 and 64 parts, as far as they keep 16 points a side, and what their scatter says.

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
    >>> study = rc.sampling_error(
    ...     rc.Surface(*rc.reference_map(64)), material=steel, pressure="100 MPa"
    ... )
    >>> found = study.error("contact_fraction")
    >>> found.parts, found.area_low < found.area < found.area_high
    (16, True)
    """
    given = quantity(pressure, "pressure", "pressure")
    require_positive(pressure=given)
    if not divides(surface.shape, statistics.USUAL):
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
    name, pressures = surface.provenance.source or "map", [float(given)]
    levels = {}
    for divisions in (n for n in DIVISIONS if divides(surface.shape, n)):
        parts = partition(surface, divisions, level)
        levels[divisions] = tuple(
            sample(part, f"{name}, part {number} of {len(parts)}", pressures, problem, progress)
            for number, part in enumerate(parts, start=1)
        )
    return SamplingStudy(sample(surface, name, pressures, problem, progress), levels)


def _names(errors: list[SamplingError]) -> str:
    return ", ".join(NAMES.get(one.name, one.name) for one in errors)
