"""Which surface is better: several maps of each under the same nominal pressure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike

from roughcontact import limits
from roughcontact.arguments import checked
from roughcontact.contact.compared import Comparison, Group
from roughcontact.contact.load_curve import spaced
from roughcontact.contact.load_history import load_history
from roughcontact.contact.sample import Sample, sample
from roughcontact.errors import InputError, Mention, require_count, require_positive
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers.bar import drawn
from roughcontact.solvers.progress import Tell
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, quantity

BEFORE, AFTER = "before", "after"
"""Names of the groups on both sides of a first loading."""

_RANGE = 100.0
"""The curves go from this part of the pressure up to it."""

Maps = Mapping[str, Sequence[Surface]]


@drawn
@checked
def compare(
    maps: Maps | Sequence[Surface],
    *,
    material: Material,
    pressure: Quantity,
    steps: int = 7,
    first_pressure: Quantity | None = None,
    paired: bool = False,
    counter_material: Material = RIGID,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    progress: Tell = None,
) -> Comparison:
    """Press several maps under the same nominal pressure, and tell how they differ.

    Parameters
    ----------
    maps : mapping of str to sequence of Surface, or sequence of Surface
        Maps by the names of their groups, or those of one surface. Several maps of one group are
        several places, pieces or measurements, or the parts of one map
        (`roughcontact.partition`).
    material, counter_material, ceiling, boundary, tolerance, max_iterations
        As for `solve`.
    pressure : float, str or quantity of pint
        Nominal pressure [Pa]: load over the area of each map.
    steps : int
        Pressures of the load curve, from a hundredth of ``pressure`` to it in equal ratios; with
        1 there is none but the last.
    first_pressure : float, str or quantity of pint, optional
        Nominal pressure [Pa] of a first loading: the maps as they are then stand beside those that
        it leaves behind (`load_history`), in pairs.
    paired : bool
        Whether the maps of two groups belong together one by one, in their order.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is
        called with a `Progress`, the name of the map as its label.

    Returns
    -------
    Comparison
        Means with their intervals, differences, and how the scatter splits.

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
    wanted = asked(pressure, steps, first_pressure, problem)
    wanted.check({name: len(surfaces) for name, surfaces in groups.items()}, paired)
    pressed = {}
    for name, surfaces in groups.items():
        labels = _names([surface.provenance.source for surface in surfaces])
        pressed[name] = [
            wanted.pressed(surface, label, progress)
            for surface, label in zip(surfaces, labels, strict=True)
        ]
    return wanted.together(pressed, paired)


# What is found of one map: its sample, or those before and after a first loading.
Pressed = tuple[Sample, ...]


@dataclass(frozen=True, eq=False)
class Asked:
    """What each map of a comparison is put under, by itself.

    Parameters
    ----------
    pressures : tuple of float
        Nominal pressures [Pa], ascending.
    before : float or None
        Nominal pressure [Pa] of a first loading, if there is one.
    problem : mapping
        What else `load_curve` takes.
    """

    pressures: tuple[float, ...]
    before: float | None
    problem: Mapping[str, Any]

    def check(self, counts: Mapping[str, int], paired: bool) -> None:
        """Raise `InputError` for so many maps in each group, if they cannot be compared."""
        if self.before is not None and len(counts) != 1:
            raise InputError(
                "sets each map beside itself after a first loading, and goes with one group of "
                "maps", argument="first_pressure",
            )  # fmt: skip
        if not counts or not all(counts.values()):
            raise InputError("has a group without maps", argument="maps")
        numbers = [*counts.values()]
        if self.before is None and paired and (len(counts) != 2 or numbers[0] != numbers[1]):
            raise InputError(
                "needs two groups of as many maps, in the same order; got "
                + ", ".join(f"{count} of {name!r}" for name, count in counts.items()),
                argument="paired",
            )
        if self.before is None and sum(numbers) < 2:
            raise InputError(
                "is a single map, which nothing can be compared with: give a second one, or its "
                "parts", argument="maps",
            )  # fmt: skip

    def pressed(self, surface: Surface, name: str, progress: Tell = None) -> Pressed:
        """Return what is found of one map; as `compare`, with a name for whoever reads along."""
        surfaces = [surface]
        if self.before is not None:
            surfaces.append(_after(surface, self.before, self.problem))
        return tuple(sample(one, name, self.pressures, self.problem, progress) for one in surfaces)

    def together(self, groups: Mapping[str, Sequence[Pressed]], paired: bool) -> Comparison:
        """Return the comparison of maps of which all was found, by the names of their groups."""
        self.check({name: len(maps) for name, maps in groups.items()}, paired)
        samples = {name: [one[0] for one in maps] for name, maps in groups.items()}
        if self.before is not None:
            (maps,) = groups.values()
            samples = {BEFORE: [one[0] for one in maps], AFTER: [one[1] for one in maps]}
        found = tuple(Group(name, _named(group)) for name, group in samples.items())
        return Comparison(found, self.pressures, paired or self.before is not None, self.before)


def asked(
    pressure: Quantity, steps: int, first_pressure: Quantity | None, problem: Mapping[str, Any]
) -> Asked:
    """Return what each map is put under; arguments and errors as of `compare`."""
    before = None
    if first_pressure is not None:
        before = float(quantity(first_pressure, "pressure", "first_pressure"))
        require_positive(first_pressure=before)
    return Asked(_pressures(pressure, steps), before, problem)


def _pressures(pressure: Quantity, steps: int) -> tuple[float, ...]:
    last = quantity(pressure, "pressure", "pressure")
    require_positive(pressure=last)
    require_count(1, limits.STEPS, steps=steps)
    if steps == 1:
        return (float(last),)
    return tuple(spaced(float(last) / _RANGE, float(last), steps))


def _named(samples: Sequence[Sample]) -> tuple[Sample, ...]:
    """Return the samples of a group, each with a name of its own."""
    names = _names([one.source for one in samples])
    return tuple(replace(one, name=name) for one, name in zip(samples, names, strict=True))


def _names(sources: Sequence[str]) -> list[str]:
    """Return what the maps of a group are called."""
    found = []
    for number, source in enumerate(sources, start=1):
        alone = source and sources.count(source) == 1
        found.append(source if alone else f"{source} {number}" if source else f"map {number}")
    return found


def _after(surface: Surface, pressure: float, problem: Mapping[str, Any]) -> Surface:
    """Return what a first loading leaves of a map."""
    terms = {key: value for key, value in problem.items() if key != "tolerance"}
    load = pressure * surface.size[0] * surface.size[1]
    history = load_history(surface, [load, 0.0], **terms)
    if history.indented_body != "surface":
        raise InputError(
            "indents the counter-body, which is softer: the map stays as it is; swap the two ",
            Mention("material"), "s to see what the map keeps", argument="first_pressure",
        )  # fmt: skip
    return history.residual
