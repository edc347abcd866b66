"""Maps of one surface or of several under the same nominal pressure: means, differences, shares."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from roughcontact import statistics
from roughcontact.contact.cautions import Caution, Kind, careful, noted, ordered
from roughcontact.contact.sample import CURVES, NUMBERS, Sample
from roughcontact.contact.sampling import SamplingStudy
from roughcontact.errors import Mention
from roughcontact.result import Result
from roughcontact.statistics import Components, Difference, Mean
from roughcontact.units import counted, engineering

Pair = tuple[int, int]

# Pixels and waves that differ by less than this part are alike.
_ALIKE = 0.05
# Below so many maps, the interval is some ten times the standard error.
_FEW = 3


@dataclass(frozen=True, eq=False)
class Group:
    """Maps that stand for one surface.

    Parameters
    ----------
    name : str
        What they are called together.
    samples : tuple of Sample
        The maps.
    """

    name: str
    samples: tuple[Sample, ...]

    def values(self, name: str) -> list[float]:
        """Return one of `NUMBERS` of all maps that have it [SI]."""
        found = (sample.numbers[name] for sample in self.samples)
        return [value for value in found if math.isfinite(value)]


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """Groups of maps under the same nominal pressure.

    Parameters
    ----------
    groups : tuple of Group
        The maps; one group is not compared with anything, but has its means.
    pressures : tuple of float
        Nominal pressures [Pa], ascending; the numbers are those of the last.
    paired : bool
        Whether the maps of two groups belong together one by one, such as before and after.
    first_pressure : float or None
        Nominal pressure [Pa] of a first loading that lies between two groups, if there was one.
    sampling : tuple of SamplingStudy
        Of each map the error by its size, if it was asked for.
    """

    groups: tuple[Group, ...]
    pressures: tuple[float, ...]
    paired: bool = False
    first_pressure: float | None = None
    sampling: tuple[SamplingStudy, ...] = ()

    @property
    def pressure(self) -> float:
        """Nominal pressure of the numbers [Pa]."""
        return self.pressures[-1]

    @property
    def samples(self) -> list[Sample]:
        """All maps."""
        return [sample for group in self.groups for sample in group.samples]

    @property
    def names(self) -> list[str]:
        """Those of `NUMBERS` that every group has."""
        limited = any(sample.curve.ceiling is not None for sample in self.samples)
        there = [name for name in NUMBERS if all(group.values(name) for group in self.groups)]
        return [name for name in there if limited or name != "saturated_fraction"]

    def mean(self, group: int, name: str) -> Mean:
        """Return the mean of one of `NUMBERS` over the maps of a group, with its interval."""
        return statistics.mean(self.groups[group].values(name))

    def differences(self, name: str) -> dict[Pair, Difference]:
        """Return how groups differ in one of `NUMBERS`, by the numbers of first and second."""
        if self.paired:
            both = ([sample.numbers[name] for sample in group.samples] for group in self.groups)
            pairs = np.array([pair for pair in zip(*both, strict=True) if np.isfinite(pair).all()])
            return {(0, 1): statistics.paired(*pairs.T)}
        return statistics.differences([group.values(name) for group in self.groups])

    def components(self, name: str) -> Components | None:
        """Return how the scatter of a number splits into that between and that within groups.

        None for one group, for pairs, and where no group has two maps.
        """
        values = [group.values(name) for group in self.groups]
        if len(values) < 2 or self.paired or max(map(len, values)) < 2:
            return None
        return statistics.components(values)

    def curve(self, group: int, name: str) -> list[Mean]:
        """Return the mean of one of `CURVES` over the maps of a group at each pressure."""
        over = [sample.over_pressure(name) for sample in self.groups[group].samples]
        return [statistics.mean(values) for values in zip(*over, strict=True)]

    @property
    def curves(self) -> list[str]:
        """Those of `CURVES` that the maps have."""
        return [name for name in CURVES if name in self.names]

    @property
    def worst_certificate(self) -> float:
        """Largest certificate ε of all contacts."""
        return max(step.certificate for sample in self.samples for step in sample.curve.steps)

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        own = [*self._alike(), *self._sampled(), *self._many()]
        shared = of_samples(self.samples)
        studied = of_samples(self.sampling) if self.sampling else []
        known = {caution.kind for caution in (*shared, *own)}
        return ordered([*shared, *own, *(c for c in studied if c.kind not in known)])

    def _alike(self) -> Iterable[Caution]:
        """Yield what differs between the maps besides their surfaces."""
        pixels = [edge for sample in self.samples for edge in sample.pixel]
        if _differ(pixels):
            low, high = (engineering(end, "m") for end in (min(pixels), max(pixels)))
            yield careful(
                Kind.UNLIKE,
                f"the pixels of the maps differ, {low} to {high}: finer ones show steeper slopes "
                "and less contact, whatever the surfaces; bring the maps to one ",
                Mention("pixel"),
                smallest=min(pixels),
                largest=max(pixels),
            )
        waves = [sample.shortest_wave for sample in self.samples]
        # Where only the pixels differ it is said above.
        if _differ(waves, 4 * _ALIKE) and not _differ(pixels):
            low, high = (engineering(end, "m", 3) for end in (min(waves), max(waves)))
            yield careful(
                Kind.UNLIKE,
                f"the shortest waves that the maps show differ, {low} to {high}, by their optics, "
                "noise or filters: slopes and contact area differ for that, whatever the surfaces; "
                f"a common ",
                Mention("s"),
                " at the longer one takes it out",
                smallest=min(waves),
                largest=max(waves),
            )
        areas = [sample.curve.nominal_area for sample in self.samples]
        if _differ(areas):
            low, high = (engineering(end, "m²", 3) for end in (min(areas), max(areas)))
            yield noted(
                Kind.UNLIKE,
                f"the maps differ in size, {low} to {high}, and have the same nominal pressure, "
                "not the same force; approach, largest pressure, mean gap and heights grow with "
                "the size of a map",
                smallest=min(areas),
                largest=max(areas),
            )

    def _sampled(self) -> Iterable[Caution]:
        """Yield how far the maps stand for their surfaces."""
        few = [group for group in self.groups if len(group.samples) < _FEW]
        if few and not self.paired:
            sizes = sorted({len(group.samples) for group in few})
            told = " or ".join(counted(size, "map") for size in sizes)
            yield careful(
                Kind.FEW,
                f"no more than {told}{_of(few)}: one map has no interval, and that of two is 13 "
                "standard errors to each side",
                maps=min(sizes),
            )
        if self.paired and len(self.groups[0].samples) < _FEW:
            count = len(self.groups[0].samples)
            yield careful(
                Kind.FEW,
                f"{counted(count, 'pair')} alone: one pair has no interval, and that of two is 13 "
                "standard errors to each side",
                maps=count,
            )
        parts = [group for group in self.groups if _of_one_file(group.samples)]
        if parts:
            yield noted(
                Kind.PARTS,
                f"the maps{_of(parts)} are parts of one map; their scatter is that within it, and "
                "says nothing of another place, another piece or another measurement",
            )

    def _many(self) -> Iterable[Caution]:
        """Yield how many intervals there are, any of which may miss."""
        number, pairs = len(self.names), len(self.groups) * (len(self.groups) - 1) // 2
        if not pairs:
            return
        shared = (
            f"; for each number the intervals of the {pairs} pairs are so wide that all of them "
            "hold together (Games and Howell)" if pairs > 1 else ""
        )  # fmt: skip
        yield noted(
            Kind.MULTIPLE,
            f"each of {number} numbers has its own interval of {100 * statistics.LEVEL:.0f} %: "
            f"where nothing differs, about {number * (1 - statistics.LEVEL):.1f} of them exclude "
            f"zero by chance{shared}; choose before you look which number decides",
            numbers=number,
            pairs=pairs,
        )


def _differ(values: Sequence[float], part: float = _ALIKE) -> bool:
    return max(values) > (1 + part) * min(values)


def _of(groups: Sequence[Group]) -> str:
    names = ", ".join(group.name for group in groups if group.name)
    return f" of {names}" if names else ""


def _of_one_file(samples: Sequence[Sample]) -> bool:
    sources = [sample.source for sample in samples if sample.part]
    return len(set(sources)) < len(sources)


def of_samples(samples: Sequence[Sample] | Sequence[SamplingStudy]) -> list[Caution]:
    """Return the cautions of the single maps, one of each kind, with whose it is."""
    once: dict[str, list[tuple[str, Caution]]] = {}
    for sample in samples:
        for caution in sample.cautions:
            once.setdefault(caution.kind, []).append((sample.name, caution))
    found = []
    for told in once.values():
        name, caution = told[0]
        texts = {one.text for _, one in told}
        owners = list(dict.fromkeys(owner for owner, _ in told))
        whose = f"{name}: "
        if len(texts) == 1 and len(owners) == len(samples):
            whose = ""
        elif len(owners) > 1:
            whose = f"{len(owners)} of {len(samples)} maps, {name}: "
        found.append(replace(caution, parts=(whose, *caution.parts)) if whose else caution)
    return found
