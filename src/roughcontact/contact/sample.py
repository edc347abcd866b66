"""One map as a sample of a surface: its numbers under given nominal pressures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from roughcontact.contact.cautions import Caution
from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.load_curve import load_curve
from roughcontact.errors import ConvergenceError, Sentence
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers.progress import Progress, Tell
from roughcontact.surface import resolution
from roughcontact.surface.surface import Surface

CONTACT = ("contact_fraction", "saturated_fraction", "max_pressure", "mean_gap", "approach")
"""Numbers of the contact under the largest of the pressures."""

ROUGHNESS = ("Sq", "Sa", "Ssk", "Sku", "Sdq", "Sal", "Sk", "Spk", "Svk")
"""Parameters of the prepared map, after ISO 25178-2."""

NUMBERS = (*CONTACT, *ROUGHNESS)
"""What maps are compared by."""

NAMES = {
    "contact_fraction": "contact area",
    "saturated_fraction": "saturated area",
    "mean_gap": "mean gap",
}
"""What messages call those of `NUMBERS` whose symbol does not tell it."""

CURVES = ("contact_fraction", "saturated_fraction", "mean_gap", "approach")
"""Numbers that are followed over the pressure."""

_LENGTHS = ("mean_gap", "approach", "max_pressure")


@dataclass(frozen=True, eq=False)
class Sample:
    """One map under a row of nominal pressures.

    Parameters
    ----------
    name : str
        What it is called.
    source : str
        Where its map came from.
    part : bool
        Whether it was cut out of a map.
    size, pixel : (float, float)
        Sides and pixel edges (y, x) of the map [m].
    shortest_wave : float
        Shortest wave that the map shows [m], by its filters and `resolution.shortest_wave`.
    curve : LoadCurve
        Its contact under these pressures.
    roughness : mapping of str to float
        Its `ROUGHNESS`, in SI units; NaN where one is not defined.
    bodies : (Material, Material)
        That with the map, and the counter-body.
    """

    name: str
    source: str
    part: bool
    size: tuple[float, float]
    pixel: tuple[float, float]
    shortest_wave: float
    curve: LoadCurve
    roughness: Mapping[str, float]
    bodies: tuple[Material, Material]

    @property
    def numbers(self) -> dict[str, float]:
        """All `NUMBERS` by name, in SI units."""
        return {name: self.over_pressure(name)[-1] for name in CONTACT} | {
            name: self.roughness[name] for name in ROUGHNESS
        }

    def over_pressure(self, name: str) -> list[float]:
        """Return one of `CONTACT` under all pressures [SI]."""
        if name in _LENGTHS:
            return [float(value) for value in self.curve.column(name)]
        area = self.curve.column(name.replace("_fraction", "_area"))
        return [float(value) for value in area / self.curve.nominal_area]

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of its numbers has to know."""
        return self.curve.cautions


def sample(
    surface: Surface,
    name: str,
    pressures: Sequence[float],
    problem: Mapping[str, Any],
    progress: Tell = None,
) -> Sample:
    """Return the numbers of one map.

    Parameters
    ----------
    surface : Surface
        The prepared map.
    name : str
        What it is called.
    pressures : sequence of float
        Nominal pressures [Pa], ascending.
    problem : mapping
        What else `load_curve` takes.
    progress : callable, optional
        Called with a `Progress`, the name of the map as its label.

    Returns
    -------
    Sample
        The numbers.

    Raises
    ------
    InputError, CapacityError, InsufficientMemoryError, ConvergenceError
        As for `load_curve`.
    """
    surface.require_map("a comparison")
    area = surface.size[0] * surface.size[1]
    watch = None
    if callable(progress):
        tell = progress

        def watch(at: Progress) -> None:
            tell(replace(at, label=name))

    try:
        curve = load_curve(
            surface, loads=[pressure * area for pressure in pressures], progress=watch, **problem
        )
    except ConvergenceError as error:
        raise ConvergenceError(Sentence(f"{name}: ", *error.parts), error.result) from None
    values = surface.roughness()
    return Sample(
        name=name,
        source=surface.provenance.source,
        part=any(step.method == "cropped" for step in surface.provenance.operations),
        size=surface.size,
        pixel=surface.pixel,
        shortest_wave=_shortest_wave(surface),
        curve=curve,
        roughness={key: values[key] for key in ROUGHNESS},
        bodies=(problem["material"], problem.get("counter_material", RIGID)),
    )


def _shortest_wave(surface: Surface) -> float:
    filters = (step for step in surface.provenance.operations if step.method == "filtered")
    cuts = [float(step.arguments["s"] or 0.0) for step in filters]
    return max([resolution.shortest_wave(surface.heights, surface.pixel), *cuts])
