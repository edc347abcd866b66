"""How well a contact conducts electricity and heat."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughcontact.arguments import checked
from roughcontact.contact.cautions import Caution, ordered
from roughcontact.contact.judgment import over_loads
from roughcontact.contact.result import ContactResult
from roughcontact.contact.stiffness import unloading_stiffness
from roughcontact.errors import InputError
from roughcontact.joint import judgment
from roughcontact.joint.filling import AIR, OIL, gap_conductance, spreading
from roughcontact.joint.judgment import Texture
from roughcontact.joint.series import of_one_pair
from roughcontact.joint.spread import greenwood
from roughcontact.material import catalogue
from roughcontact.material.conductor import Conductor
from roughcontact.result import Result
from roughcontact.theory import constriction
from roughcontact.units import Quantity, quantity

Array = NDArray[np.float64]

OF = "the resistance of a contact"
"""What needs a map, in words."""

EVEN_FLOW = 32 / (3 * math.pi**2) - 1
"""Constriction of a disc by uniform flow over that of constant potential, less one: 8.1 %.

Carslaw and Jaeger, Conduction of Heat in Solids (1959), section 8.2.
"""


@dataclass(frozen=True)
class ConductanceStep:
    """What conducts under one load, for bodies of any material.

    Parameters
    ----------
    load : float
        W [N].
    contact_area, saturated_area : float
        Real contact area, and that at the ceiling [m²].
    spots : int
        Number of contact spots.
    length : float
        Constriction length of the whole contact, saturated points included [m]; infinite where
        all of a periodic map touches.
    greenwood_length : float
        The same by Greenwood's formula from radii and places of the spots [m]; see
        `roughcontact.joint.spread.greenwood`.
    correlation_length : float
        The same by the correlation for nominally flat rough joints [m]: Cooper, Mikic and
        Yovanovich under a ceiling, Mikic without, and the spreading from the outline of a free map;
        NaN where the bodies are curved as a whole, or periodic along one axis only.
    air_gap, oil_gap : float
        What air or oil in the gap conducts beside the contact, per area [W/(m² K)]; NaN unless the
        conductivities are known and the map is periodic along both axes. See
        `roughcontact.joint.filling.gap_conductance`.
    """

    load: float
    contact_area: float
    saturated_area: float
    spots: int
    length: float
    greenwood_length: float
    correlation_length: float
    air_gap: float = math.nan
    oil_gap: float = math.nan


@dataclass(frozen=True)
class Change:
    """How numbers change from one grid to a coarser one.

    Parameters
    ----------
    pixel : float
        Larger edge of its pixels [m].
    length, contact_area : float
        Relative changes.
    """

    pixel: float
    length: float
    contact_area: float


@dataclass(frozen=True, eq=False, repr=False)
class Conductance(Result):
    """Electrical and thermal resistance of a contact under one load or several.

    Parameters
    ----------
    steps : tuple of ConductanceStep
        By ascending load.
    bodies : (Conductor, Conductor)
        Body and counter-body.
    film, thermal_film : float
        Resistance of a film on the contact times its area [Ω m²], [m² K/W].
    largest : ContactResult
        The contact under the largest load.
    found : tuple of Caution
        What the contacts give cause for.
    remarks : tuple of Caution
        What else is known of the numbers, from the measurement of the maps.
    coarser : Change or None
        How the numbers under the largest load change on a coarser grid, where that is known; see
        `beside`.
    """

    steps: tuple[ConductanceStep, ...]
    bodies: tuple[Conductor, Conductor]
    film: float
    thermal_film: float
    largest: ContactResult
    found: tuple[Caution, ...] = ()
    remarks: tuple[Caution, ...] = ()
    coarser: Change | None = None

    def beside(self, coarser: ContactResult) -> Conductance:
        """Return the same with what changes on a coarser grid.

        Parameters
        ----------
        coarser : ContactResult
            The same bodies under the largest load on a grid of larger pixels.
        """
        coarse = _step(coarser, Texture(coarser.pair), self.thermal_resistivity)
        fine = self.steps[-1]
        length, area = (
            new / old - 1 if old and math.isfinite(old) else 0.0
            for new, old in (
                (coarse.length, fine.length), (coarse.contact_area, fine.contact_area)
            )
        )  # fmt: skip
        pixel = max(coarser.pair.pixel)
        caution = judgment.grid(length, area, pixel)
        found = self.found if caution is None else (*self.found, caution)
        return replace(self, coarser=Change(pixel, length, area), found=found)

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        return ordered(dict.fromkeys([*self.found, *self.remarks]))

    @property
    def nominal_area(self) -> float:
        """Area of the whole map [m²]."""
        size = self.largest.pair.size
        return size[0] * size[1]

    @property
    def electrical_resistivity(self) -> float:
        """Sum of the resistivities of the two bodies [Ω m]; NaN where one is not known."""
        first, second = (body.resistivity or math.nan for body in self.bodies)
        return first + second

    @property
    def thermal_resistivity(self) -> float:
        """Sum of 1/k of the two bodies [m K/W]; NaN where one is not known."""
        return _thermal_resistivity(self.bodies)

    def column(self, name: str) -> Array:
        """Return one field of all steps, shape (n,); see `ConductanceStep`."""
        return np.array([getattr(step, name) for step in self.steps], dtype=float)

    @property
    def electrical_resistance(self) -> Array:
        """Resistance of the contact [Ω], shape (n,): constriction and film one after the other."""
        return self.resistance("electrical")

    @property
    def thermal_resistance(self) -> Array:
        """Thermal resistance of the contact [K/W], shape (n,)."""
        return self.resistance("thermal")

    @property
    def electrical_conductance(self) -> Array:
        """Conductance of the contact per nominal area [S/m²], shape (n,)."""
        return self._per_area(self.electrical_resistance)

    @property
    def thermal_conductance(self) -> Array:
        """Conductance of the contact per nominal area h [W/(m² K)], shape (n,)."""
        return self._per_area(self.thermal_resistance)

    def filled_conductance(self, filling: str) -> Array:
        """Return h of contact and gap side by side [W/(m² K)], shape (n,).

        Parameters
        ----------
        filling : {"air", "oil"}
            What is in the gap; see `ConductanceStep`.
        """
        return self.thermal_conductance + self.column(f"{filling}_gap")

    def resistance(self, kind: str, by: str = "length") -> Array:
        """Return the resistance of the contact, shape (n,).

        Parameters
        ----------
        kind : {"electrical", "thermal"}
            Which, [Ω] or [K/W]; NaN where the bodies' constants are not known.
        by : {"length", "greenwood_length", "correlation_length"}
            Constriction length to take: computed, or an estimate; see `ConductanceStep`.
        """
        thermal = kind == "thermal"
        resistivity = self.thermal_resistivity if thermal else self.electrical_resistivity
        film = self.thermal_film if thermal else self.film
        with np.errstate(divide="ignore"):
            resistance: Array = resistivity / self.column(by)
            if film:
                resistance = resistance + film / self.column("contact_area")
        return resistance

    def _per_area(self, resistance: Array) -> Array:
        with np.errstate(divide="ignore"):
            conductance: Array = 1 / (resistance * self.nominal_area)
        return conductance


@checked
def conductance(
    contacts: ContactResult | Iterable[ContactResult],
    body: Conductor | str,
    counter_body: Conductor | str,
    *,
    film: Quantity = 0.0,
    thermal_film: Quantity = 0.0,
) -> Conductance:
    """Return the electrical and thermal resistance of a contact.

    Parameters
    ----------
    contacts : ContactResult or iterable of ContactResult
        Solutions of one pair of bodies under one load or several. One at a time is looked at, and
        that under the largest load is kept.
    body, counter_body : Conductor or str
        What the bodies conduct, or their names in the catalogue of materials.
    film : float, str or quantity of pint
        Electrical resistance of a film on the contact times its area [Ω m²].
    thermal_film : float, str or quantity of pint
        Thermal resistance of a film on the contact times its area [m² K/W].

    Returns
    -------
    Conductance
        Resistances under each load.

    Raises
    ------
    InputError
        If neither the resistivity nor the conductivity of both bodies is known, a film lacks that
        which it goes with, the contacts are of different bodies, or the bodies are profiles.
    ConvergenceError, InsufficientMemoryError
        As for `roughcontact.contact.stiffness.unloading_stiffness`.

    Notes
    -----
    The potential on the contact is constant, as is the displacement under a rigid punch of the
    same outline: with the stiffness K of that punch the constriction length is L = 2 K/E*, and
    R = Σρ/L (Barber 2003, doi:10.1098/rspa.2002.1038). The gap conducts nothing;
    `Conductance.filled_conductance` adds air or oil in it.

    With a free boundary this is the resistance between points far away in both bodies, in which
    the spreading from all of the map is contained. With a periodic one it is what the joint adds to
    the bodies of one period: 0 where all of the map touches, and the one to be taken per area. With
    a map that is periodic along one axis it is that up to a distance of the longer side of the map,
    as the potential of an endless strip has no bound.

    A film adds its resistance over the contact area. As it evens the flow out, the true
    resistance is a little larger: on a disc by at most 8.1 % of the constriction (`EVEN_FLOW`).

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(64)
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> result = rc.solve(rc.Surface(heights, pixel), material=steel, load=1.0)
    >>> found = rc.conductance(result, "6061-T6", rc.Conductor(resistivity="17 nohm m"))
    >>> bool(found.electrical_resistance[0] > 0)
    True
    """
    bodies = (conductor_of(body), conductor_of(counter_body))
    films = (_film(film, "film", "film"), _film(thermal_film, "thermal film", "thermal_film"))
    _check(bodies, films)
    steps, judged, largest = _looked_at(contacts, _thermal_resistivity(bodies))
    return Conductance(steps, bodies, *films, largest, over_loads(judged, "N"))


Judged = list[tuple[float, tuple[Caution, ...]]]


def _looked_at(
    contacts: ContactResult | Iterable[ContactResult], resistivity: float
) -> tuple[tuple[ConductanceStep, ...], Judged, ContactResult]:
    """Return what each contact has and is judged by, by ascending load, and the last of them."""
    found: list[tuple[ConductanceStep, tuple[Caution, ...]]] = []
    largest: ContactResult | None = None
    texture: Texture | None = None
    for result in of_one_pair(contacts, OF):
        if texture is None or texture.pair is not result.pair:
            texture = Texture(result.pair)
        step = _step(result, texture, resistivity)
        found.append((step, (*result.cautions, *_cautions(result, step, texture))))
        if largest is None or result.load >= largest.load:
            largest = result
    assert largest is not None
    found.sort(key=lambda one: one[0].load)
    steps = tuple(step for step, _ in found)
    return steps, [(step.load, cautions) for step, cautions in found], largest


def _step(result: ContactResult, texture: Texture, resistivity: float) -> ConductanceStep:
    gaps = {}
    if len(result.boundary.periodic_axes) == 2 and not math.isnan(resistivity):
        gap = np.where(result.contact, np.nan, np.maximum(result.gap, 0))
        spread = spreading(result.pixel_area, resistivity)
        gaps = {
            "air_gap": gap_conductance(gap, AIR, spread),
            "oil_gap": gap_conductance(gap, OIL, spread),
        }
    return ConductanceStep(
        load=result.load,
        contact_area=result.contact_area,
        saturated_area=result.saturated_fraction * result.pressure.size * result.pixel_area,
        spots=result.spots().count,
        length=2 * unloading_stiffness(result) / result.contact_modulus,
        greenwood_length=greenwood(result),
        correlation_length=_correlation(result, texture),
        **gaps,
    )


def _cautions(result: ContactResult, step: ConductanceStep, texture: Texture) -> Iterator[Caution]:
    """Yield what is known of the estimates of one contact."""
    if result.smooth is None:
        yield from judgment.form(texture)
    spots = judgment.discs(step.load, result.contact_fraction, step.greenwood_length, step.length)
    if spots is not None:
        yield spots


def _correlation(result: ContactResult, texture: Texture) -> float:
    """Return the constriction length that simple theory gives a nominally flat joint."""
    height, gradient = texture.height, texture.gradient
    rough = result.load > 0 and height > 0 and gradient > 0
    strip = len(result.pair.boundary.periodic_axes) == 1
    if result.smooth is not None or strip or not rough or not texture.is_flat:
        return math.nan
    area = result.pair.size[0] * result.pair.size[1]
    # Of Gaussian heights alike in all directions: √(2/π) of the slope along a line, h′/√2.
    slope = gradient / math.sqrt(math.pi)
    pressure = result.load / area
    if result.ceiling is None:
        modulus = result.contact_modulus
        joint = area * constriction.elastic_joint(pressure, modulus, slope, height)
    else:
        hardness = float(np.mean(result.ceiling))
        joint = area * constriction.plastic_joint(pressure, hardness, slope, height)
    if result.pair.boundary.periodic_axes:
        return joint
    # Spreading from all of the map comes on top: an ellipse of its area and sides has that of a
    # square to 2 %.
    whole = constriction.ellipse(*(side / math.sqrt(math.pi) for side in result.pair.size))
    return 1 / (1 / joint + 1 / whole)


def _thermal_resistivity(bodies: tuple[Conductor, Conductor]) -> float:
    first, second = (1 / (body.conductivity or math.nan) for body in bodies)
    return first + second


def conductor_of(given: Conductor | str) -> Conductor:
    """Return a conductor, which may be given by its name in the catalogue."""
    return catalogue.entry(given).conductor if isinstance(given, str) else given


def _film(value: Quantity, dimension: str, argument: str) -> float:
    found = quantity(value, dimension, argument)
    if not (isinstance(found, (int, float)) and 0 <= found < math.inf):
        raise InputError(
            f"must be zero or positive, and finite, got {value!r}", argument=argument, value=value
        )
    return float(found)


def _check(bodies: tuple[Conductor, Conductor], films: tuple[float, float]) -> None:
    """Refuse bodies of which too little is known."""
    electrical = [body.resistivity is not None for body in bodies]
    thermal = [body.conductivity is not None for body in bodies]
    if not all(electrical) and not all(thermal):
        raise InputError(
            "needs the resistivity of both bodies, or the conductivity of both; known are "
            f"{_known(bodies[0])} of the body and {_known(bodies[1])} of the counter-body",
            argument="conductance",
        )
    for film, known, argument, what in (
        (films[0], electrical, "film", "resistivity"),
        (films[1], thermal, "thermal_film", "conductivity"),
    ):
        if film and not all(known):
            raise InputError(f"needs the {what} of both bodies", argument=argument, value=film)


def _known(body: Conductor) -> str:
    names = [name for name in ("resistivity", "conductivity") if getattr(body, name) is not None]
    return " and ".join(names) or "neither"
