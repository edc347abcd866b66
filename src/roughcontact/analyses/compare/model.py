"""Comparison of maps under the same nominal pressure: means, differences, scatter."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools import memory, statistics
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.statistics import Components, Difference, Mean
from roughcontact.analyses.compare.sampling import (
    CALIBRATED_NUMBERS,
    CONTACT,
    CURVES,
    NUMBERS,
    Sample,
    SamplingStudy,
    solve_by_ceiling,
    solve_sample,
)
from roughcontact.analyses.history.model import history as load_history
from roughcontact.cautions import (
    MIN_MAPS,
    Caution,
    CautionTag,
    as_caution,
    as_note,
    few_maps,
    merge_cautions,
    sort_cautions,
)
from roughcontact.contact.load_case import space_values
from roughcontact.contact.result import BASE, CALIBRATED, COATING, MIN_SHOWN_CHANGE
from roughcontact.errors import ArgumentRef, InputError, require_count, require_positive
from roughcontact.halfspace.gpu import runs_on_device
from roughcontact.material.material import RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.progress import Tell, shows_progress_bar
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, format_engineering, to_si

Pair = tuple[int, int]

# Relative difference up to which pixels, waves and map sizes are treated as equal.
_SIMILARITY_TOLERANCE = 0.05
# Largest number of groups that a message lists by name.
_NAMED = 3


@dataclass(frozen=True, eq=False)
class Group:
    """Maps of one surface."""

    name: str  # Common name of the maps
    samples: tuple[Sample, ...]  # The maps

    def values(self, name: str) -> list[float]:
        """Return the finite values of one of `NUMBERS` over the maps [SI]."""
        result = (sample.numbers[name] for sample in self.samples)
        return [value for value in result if math.isfinite(value)]


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """Groups of maps under the same nominal pressure.

    Parameters
    ----------
    groups : tuple of Group
        The maps; a single group has means, but no differences.
    pressures : tuple of float
        Nominal pressures [Pa], ascending; `numbers` are evaluated at the last.
    paired : bool
        Whether the maps of two groups are pairs, such as before and after.
    preload_pressure : float or None
        Nominal pressure [Pa] of the first loading between two groups, if there was one.
    sampling : tuple of SamplingStudy
        Sampling error of each map, if requested.
    """

    groups: tuple[Group, ...]
    pressures: tuple[float, ...]
    paired: bool = False
    preload_pressure: float | None = None
    sampling: tuple[SamplingStudy, ...] = ()

    @property
    def pressure(self) -> float:
        """Nominal pressure at which the maps are compared [Pa]."""
        return self.pressures[-1]

    @property
    def samples(self) -> list[Sample]:
        """All maps."""
        return [sample for group in self.groups for sample in group.samples]

    @cached_property
    def base(self) -> Comparison | None:
        """Comparison under the ceiling of the base of coated bodies, if both were requested."""
        groups = tuple(
            replace(group, samples=tuple(item.base for item in group.samples if item.base))
            for group in self.groups
        )
        return replace(self, groups=groups) if all(group.samples for group in groups) else None

    @cached_property
    def calibrated(self) -> Comparison | None:
        """Comparison under the calibrated ceiling; None if it is not known or changes nothing."""
        if self.base is not None or not all(item.calibrated for item in self.samples):
            return None
        changes = [
            abs(item.calibrated[name] / item.numbers[name] - 1)
            for item in self.samples
            for name in ("contact_fraction", "mean_gap")
            if item.numbers[name]
        ]
        if max(changes, default=0.0) <= MIN_SHOWN_CHANGE:
            return None
        groups = (
            replace(group, samples=tuple(replace(x, is_calibrated=True) for x in group.samples))
            for group in self.groups
        )
        return replace(self, groups=tuple(groups))

    @property
    def names(self) -> list[str]:
        """The `NUMBERS` that are available in every group."""
        limited = any(sample.curve.ceiling is not None for sample in self.samples)
        there = [name for name in NUMBERS if all(group.values(name) for group in self.groups)]
        return [name for name in there if limited or name != "saturated_fraction"]

    def mean(self, group: int, name: str) -> Mean:
        """Return the mean of one of `NUMBERS` over the maps of a group, with its interval."""
        return statistics.mean_with_interval(self.groups[group].values(name))

    def differences(self, name: str) -> dict[Pair, Difference]:
        """Return the differences of one of `NUMBERS` by pairs of group indices."""
        if self.paired:
            both = ([sample.numbers[name] for sample in group.samples] for group in self.groups)
            pairs = np.array([pair for pair in zip(*both, strict=True) if np.isfinite(pair).all()])
            return {(0, 1): statistics.paired_difference(*pairs.T)}
        return statistics.differences([group.values(name) for group in self.groups])

    @cached_property
    def corrected(self) -> dict[tuple[str, Pair], float]:
        """p-values of all `differences` by name and pair, Holm-corrected for their number."""
        alone = {
            (name, pair): item.p
            for name in self.names
            for pair, item in self.differences(name).items()
        }
        return dict(zip(alone, statistics.holm([*alone.values()]).tolist(), strict=True))

    def is_significant(self, name: str, pair: Pair = (0, 1)) -> bool:
        """Return whether two groups differ in a quantity, by the corrected p-value.

        A difference whose sign depends on the ceiling is not significant. With both ceilings of a
        coated body it has to be significant under both.
        """
        is_clear = self.corrected.get((name, pair), 1.0) < 1 - statistics.LEVEL
        is_confirmed = self.base is None or self.base.is_significant(name, pair)
        return is_clear and is_confirmed and not self.is_ceiling_dependent(name, pair)

    def is_ceiling_dependent(self, name: str, pair: Pair = (0, 1)) -> bool:
        """Return whether a difference has another sign under the other ceiling.

        The other ceiling is that of the base of a coated body, if both were requested, or else the
        calibrated one.
        """
        if name not in CONTACT:
            return False
        usual, other = [], []
        for index in pair:
            samples = self.groups[index].samples
            usual.append(np.nanmean([sample.numbers[name] for sample in samples]))
            other.append(
                np.nanmean([{**sample.numbers, **sample.other_ceiling}[name] for sample in samples])
            )
        return bool((usual[1] - usual[0]) * (other[1] - other[0]) < 0)

    def components(self, name: str) -> Components | None:
        """Return the variance components of a quantity between and within groups.

        None for a single group, for pairs, and if no group has two maps.
        """
        values = [group.values(name) for group in self.groups]
        if len(values) < 2 or self.paired or max(map(len, values)) < 2:
            return None
        return statistics.components(values)

    def curve(self, group: int, name: str) -> list[Mean]:
        """Return the mean of one of `CURVES` over the maps of a group at each pressure."""
        over = [sample.over_pressure(name) for sample in self.groups[group].samples]
        return [statistics.mean_with_interval(values) for values in zip(*over, strict=True)]

    @property
    def curves(self) -> list[str]:
        """The `CURVES` that are available in every group."""
        return [name for name in CURVES if name in self.names]

    @property
    def worst_certificate(self) -> float:
        """Largest certificate ε of all contacts."""
        own = max(step.certificate for sample in self.samples for step in sample.curve.steps)
        return own if self.base is None else max(own, self.base.worst_certificate)

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the result, the most severe first."""
        own = [*self._alike(), *self._sampling_cautions()]
        shared = sample_cautions(self.samples)
        studied = sample_cautions(self.sampling)
        known = {caution.kind for caution in (*shared, *own)}
        return sort_cautions([*shared, *own, *(c for c in studied if c.kind not in known)])

    def _alike(self) -> Iterable[Caution]:
        """Yield cautions on maps of different pixel, shortest wave or size."""
        pixels = [edge for sample in self.samples for edge in sample.pixel]
        if _differ_beyond(pixels):
            advice = f"finer maps show less contact. Use a common {ArgumentRef('pixel')}."
            text, numbers = _unlike("Pixels", pixels, "m", advice, 4)
            yield as_caution(CautionTag.UNLIKE_PIXEL, text, **numbers)
        waves = [sample.shortest_wave for sample in self.samples]
        # Shortest waves follow from the pixels, which have their own caution.
        if _differ_beyond(waves, 4 * _SIMILARITY_TOLERANCE) and not _differ_beyond(pixels):
            advice = f"contact area differs for that alone. Use a common {ArgumentRef('s')}."
            text, numbers = _unlike("Shortest waves", waves, "m", advice)
            yield as_caution(CautionTag.UNLIKE_PIXEL, text, **numbers)
        areas = [sample.curve.nominal_area for sample in self.samples]
        if _differ_beyond(areas):
            advice = "compare contact area, not approach or peak pressure."
            text, numbers = _unlike("Map sizes", areas, "m²", advice)
            yield as_note(CautionTag.UNLIKE_SIZE, text, **numbers)

    def _sampling_cautions(self) -> Iterable[Caution]:
        """Yield cautions on how well the maps represent their surfaces."""
        fewest = min(len(group.samples) for group in self.groups)
        if fewest < MIN_MAPS:
            few = [group for group in self.groups if len(group.samples) == fewest]
            yield (
                few_maps(fewest, "pair") if self.paired else few_maps(fewest, of=_group_phrase(few))
            )
        if any(_has_parts_of_one_file(group.samples) for group in self.groups):
            yield as_note(
                CautionTag.PARTS,
                "Groups are parts of one map: scatter excludes other places, pieces and "
                "measurements.",
            )


def rows_by_ceiling(comparison: Comparison) -> list[tuple[str, str, Comparison]]:
    """Return quantity, ceiling and comparison of each row of a table.

    Contact quantities have a second row for the calibrated ceiling if it is known, and those of
    coated bodies one for each ceiling if both were requested.
    """
    both = {"": comparison, CALIBRATED: comparison.calibrated}
    known: Sequence[str] = CALIBRATED_NUMBERS
    if comparison.base is not None:
        both, known = {COATING: comparison, BASE: comparison.base}, CONTACT
    rows = []
    for name in comparison.names:
        cases = both if name in known else {"": comparison}
        rows += [(name, ceiling, case) for ceiling, case in cases.items() if case is not None]
    return rows


def _differ_beyond(values: Sequence[float], part: float = _SIMILARITY_TOLERANCE) -> bool:
    return max(values) > (1 + part) * min(values)


def _unlike(
    what: str, values: Sequence[float], unit: str, advice: str, digits: int = 3
) -> tuple[str, dict[str, float]]:
    """Return text and numbers of a caution on values that differ between maps."""
    low, high = min(values), max(values)
    ends = " to ".join(format_engineering(end, unit, digits) for end in (low, high))
    return f"{what} differ ({ends}): {advice}", dict(ratio=high / low, smallest=low, largest=high)


def _group_phrase(groups: Sequence[Group]) -> str:
    names = [group.name for group in groups if group.name]
    named = ", ".join(names) if len(names) <= _NAMED else f"each of {len(names)} groups"
    return f" of {named}" if names else ""


def _has_parts_of_one_file(samples: Sequence[Sample]) -> bool:
    sources = [sample.source for sample in samples if sample.part]
    return len(set(sources)) < len(sources)


def sample_cautions(samples: Sequence[Sample] | Sequence[SamplingStudy]) -> tuple[Caution, ...]:
    """Return the cautions of the individual maps, one of each tag."""
    return merge_cautions([(sample.name, sample.cautions) for sample in samples], "maps")


BEFORE, AFTER = "before", "after"
"""Names of the groups before and after a first loading."""

_RANGE = 100.0
"""Largest over smallest pressure of the load curves."""

Maps = Mapping[str, Sequence[Surface]]


@shows_progress_bar
@runs_on_device
@validate_arguments
def compare(
    maps: Maps | Sequence[Surface],
    *,
    material: Material,
    pressure: Quantity,
    steps: int = 7,
    preload_pressure: Quantity | None = None,
    paired: bool = False,
    counter_material: Material = RIGID,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    device: str | None = None,
    progress: Tell = None,
) -> Comparison:
    """Compare several maps under the same nominal pressure.

    Parameters
    ----------
    maps : mapping of str to sequence of Surface, or sequence of Surface
        Maps by group name, or the maps of one group. The maps of a group are different places,
        pieces or measurements, or the parts of one map (`roughcontact.partition`).
    material, counter_material, ceiling, boundary, tolerance, max_iterations, device
        As for `solve`. With the ceiling ``"bracket"`` of a coated body the comparison is that
        under the ceiling of the coating, and its ``base`` that under the ceiling of the base.
    pressure : float, str or quantity of pint
        Nominal pressure [Pa]: load over the area of each map.
    steps : int
        Number of pressures of the load curve, in equal ratios from a hundredth of ``pressure`` to
        ``pressure``; 1 for ``pressure`` alone.
    preload_pressure : float, str or quantity of pint, optional
        Nominal pressure [Pa] of a first loading; each map is compared with itself after it
        (`history`).
    paired : bool
        Whether the maps of two groups are pairs, in their order.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`, the name of the map as its label.

    Returns
    -------
    Comparison
        Means with their intervals, differences, and contributions to the scatter.

    Raises
    ------
    InputError
        If an argument cannot be used, or there is only one map.
    CapacityError, InsufficientMemoryError, ConvergenceError
        As for `solve`.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> rough = {seed: rc.Surface(*rc.reference_map(64, seed)) for seed in range(4)}
    >>> smooth = [rc.Surface(0.5 * rough[seed].heights, rough[seed].pixel) for seed in (2, 3)]
    >>> found = rc.compare(
    ...     {"ground": [rough[0], rough[1]], "lapped": smooth}, material=steel, pressure="100 MPa"
    ... )
    >>> found.differences("contact_fraction")[0, 1].value > 0
    True
    """
    groups = dict(maps) if isinstance(maps, Mapping) else {"": list(maps)}
    problem = {
        "material": material,
        "counter_material": counter_material,
        "ceiling": ceiling,
        "boundary": boundary,
        "tolerance": tolerance,
        "max_iterations": max_iterations,
    }
    wanted = build_load_case(pressure, steps, preload_pressure, problem)
    wanted.check({name: len(surfaces) for name, surfaces in groups.items()}, paired)
    pressed = {}
    for name, surfaces in groups.items():
        labels = _names([surface.provenance.source for surface in surfaces])
        pressed[name] = [
            wanted.solve_map(surface, label, progress)
            for surface, label in zip(surfaces, labels, strict=True)
        ]
    return wanted.together(pressed, paired)


# Result of one map: its sample, or its samples before and after a first loading.
Pressed = tuple[Sample, ...]


@dataclass(frozen=True, eq=False)
class MapLoadCase:
    """Load case that is common to the maps of a comparison."""

    pressures: tuple[float, ...]  # Nominal pressures [Pa], ascending
    before: float | None  # Nominal pressure [Pa] of a first loading, if there is one
    problem: Mapping[str, Any]  # Further arguments of `sweep`

    def check(self, counts: Mapping[str, int], paired: bool) -> None:
        """Raise `InputError` if groups with these numbers of maps cannot be compared."""
        if self.before is not None and len(counts) != 1:
            raise InputError(
                "compares each map before and after a first loading; it needs a single group of "
                "maps",
                argument="preload_pressure",
            )
        if not counts or not all(counts.values()):
            raise InputError("has a group without maps", argument="maps")
        numbers = [*counts.values()]
        if self.before is None and paired and (len(counts) != 2 or numbers[0] != numbers[1]):
            raise InputError(
                "needs two groups with the same number of maps, in the same order; got "
                + ", ".join(f"{count} of {name!r}" for name, count in counts.items()),
                argument="paired",
            )
        if self.before is None and sum(numbers) < 2:
            raise InputError(
                "is a single map; give a second one to compare with, or its parts", argument="maps"
            )

    def solve_map(self, surface: Surface, name: str, progress: Tell = None) -> Pressed:
        """Solve one map; return its samples. The name is for progress messages."""

        def solve(problem: Mapping[str, Any]) -> Pressed:
            surfaces = [surface]
            if self.before is not None:
                surfaces.append(_after_preload(surface, self.before, problem))
            return tuple(
                solve_sample(item, name, self.pressures, problem, progress, is_calibrated=True)
                for item in surfaces
            )

        return solve_by_ceiling(surface, self.problem, solve)

    def together(self, groups: Mapping[str, Sequence[Pressed]], paired: bool) -> Comparison:
        """Return the comparison of solved maps, which are given by group name."""
        self.check({name: len(maps) for name, maps in groups.items()}, paired)
        samples = {name: [item[0] for item in maps] for name, maps in groups.items()}
        if self.before is not None:
            (maps,) = groups.values()
            samples = {BEFORE: [item[0] for item in maps], AFTER: [item[1] for item in maps]}
        result = tuple(Group(name, _rename_samples(group)) for name, group in samples.items())
        return Comparison(result, self.pressures, paired or self.before is not None, self.before)


def build_load_case(
    pressure: Quantity, steps: int, preload_pressure: Quantity | None, problem: Mapping[str, Any]
) -> MapLoadCase:
    """Return the load case of the maps; arguments and errors as for `compare`."""
    before = None
    if preload_pressure is not None:
        before = float(to_si(preload_pressure, "pressure", "preload_pressure"))
        require_positive(preload_pressure=before)
    return MapLoadCase(_pressures(pressure, steps), before, problem)


def _pressures(pressure: Quantity, steps: int) -> tuple[float, ...]:
    last = to_si(pressure, "pressure", "pressure")
    require_positive(pressure=last)
    require_count(1, memory.STEPS, steps=steps)
    if steps == 1:
        return (float(last),)
    return tuple(space_values(float(last) / _RANGE, float(last), steps))


def _rename_samples(samples: Sequence[Sample]) -> tuple[Sample, ...]:
    """Return the samples of a group, each with a unique name."""
    names = _names([item.source for item in samples])
    return tuple(replace(item, name=name) for item, name in zip(samples, names, strict=True))


def _names(sources: Sequence[str]) -> list[str]:
    """Return the names of the maps of a group."""
    result = []
    for number, source in enumerate(sources, start=1):
        alone = source and sources.count(source) == 1
        result.append(source if alone else f"{source} {number}" if source else f"map {number}")
    return result


def _after_preload(surface: Surface, pressure: float, problem: Mapping[str, Any]) -> Surface:
    """Return a map as a first loading leaves it."""
    terms = {key: value for key, value in problem.items() if key != "tolerance"}
    bodies = (problem.get(name) for name in ("material", "counter_material"))
    if any(isinstance(body, Material) and body.coating for body in bodies):
        raise InputError(
            "needs bodies without a coating: the base yields below it, and how the coated surface "
            "is indented then is not modeled",
            argument="preload_pressure",
        )
    history = load_history(surface, [pressure * surface.size[0] * surface.size[1], 0.0], **terms)
    if history.indented_body != "surface":
        raise InputError(
            "indents the counter-body, which is softer, and leaves the map unchanged; swap the "
            f"two {ArgumentRef('material')}s to indent the map",
            argument="preload_pressure",
        )
    return history.residual
