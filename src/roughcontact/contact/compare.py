"""Which surface is better: several maps of each under the same nominal pressure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from roughcontact import limits
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
    pressures = _pressures(pressure, steps)
    groups = dict(maps) if isinstance(maps, Mapping) else {"": list(maps)}
    problem = {
        "material": material,
        "counter_material": counter_material,
        "ceiling": ceiling,
        "boundary": boundary,
        "tolerance": tolerance,
        "max_iterations": max_iterations,
    }
    before = None
    if first_pressure is not None:
        before = float(quantity(first_pressure, "pressure", "first_pressure"))
        require_positive(first_pressure=before)
        groups = _after(groups, before, problem)
        paired = True
    _check(groups, paired)
    found = tuple(
        Group(name, tuple(_samples(surfaces, pressures, problem, progress)))
        for name, surfaces in groups.items()
    )
    return Comparison(found, pressures, paired, before)


def _pressures(pressure: Quantity, steps: int) -> tuple[float, ...]:
    last = quantity(pressure, "pressure", "pressure")
    require_positive(pressure=last)
    require_count(1, limits.STEPS, steps=steps)
    if steps == 1:
        return (float(last),)
    return tuple(spaced(float(last) / _RANGE, float(last), steps))


def _check(groups: Mapping[str, Sequence[Surface]], paired: bool) -> None:
    counts = [len(surfaces) for surfaces in groups.values()]
    if not counts or not all(counts):
        raise InputError("has a group without maps", argument="maps")
    if paired and (len(counts) != 2 or counts[0] != counts[1]):
        raise InputError(
            "needs two groups of as many maps, in the same order; got "
            + ", ".join(f"{len(surfaces)} of {name!r}" for name, surfaces in groups.items()),
            argument="paired",
        )
    if sum(counts) < 2:
        raise InputError(
            "is a single map, which nothing can be compared with: give a second one, or its parts",
            argument="maps",
        )


def _samples(
    surfaces: Sequence[Surface],
    pressures: Sequence[float],
    problem: Mapping[str, Any],
    progress: Tell,
) -> Iterator[Sample]:
    """Yield the numbers of the maps of a group, each under a name of its own."""
    sources = [surface.provenance.source for surface in surfaces]
    for number, (surface, source) in enumerate(zip(surfaces, sources, strict=True), start=1):
        alone = source and sources.count(source) == 1
        name = source if alone else f"{source} {number}" if source else f"map {number}"
        yield sample(surface, name, pressures, problem, progress)


def _after(groups: Maps, pressure: float, problem: Mapping[str, Any]) -> dict[str, list[Surface]]:
    """Return the maps before and after a first loading."""
    if len(groups) != 1:
        raise InputError(
            "sets each map beside itself after a first loading, and goes with one group of maps",
            argument="first_pressure",
        )
    ((_, before),) = groups.items()
    terms = {key: value for key, value in problem.items() if key != "tolerance"}
    after = []
    for surface in before:
        load = pressure * surface.size[0] * surface.size[1]
        history = load_history(surface, [load, 0.0], **terms)
        if history.indented_body != "surface":
            raise InputError(
                "indents the counter-body, which is softer: the map stays as it is; swap the two ",
                Mention("material"), "s to see what the map keeps", argument="first_pressure",
            )  # fmt: skip
        after.append(history.residual)
    return {BEFORE: list(before), AFTER: after}
