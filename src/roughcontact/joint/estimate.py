"""Estimates of nominally flat contact from a few parameters, without solving it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from roughcontact.arguments import checked
from roughcontact.contact.cautions import Caution, Kind, noted, ordered
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError, Mention, require_positive
from roughcontact.joint import formulas
from roughcontact.joint.formulas import CONTACT, GAP, SATURATED, VOLUME, Groups
from roughcontact.material.hardening import Linear, Perfect
from roughcontact.material.material import CEILING_FACTOR, RIGID, Material, contact_modulus
from roughcontact.result import Result
from roughcontact.surface.surface import Surface
from roughcontact.theory import johnson
from roughcontact.theory.persson import persson_fractions
from roughcontact.units import Quantity, percent, quantity

_CEILING, _VOLUME = "ceiling", "volume"
LEAST_WAVES = 6.0
"""Autocorrelation lengths along the shorter side of a map below which it shows its own form."""


@dataclass(frozen=True)
class Range:
    """A value and the ends of the interval in which it lies for 90 of 100 maps."""

    value: float
    low: float
    high: float

    def times(self, factor: float) -> Range:
        """Return it in another unit."""
        return Range(self.value * factor, self.low * factor, self.high * factor)


@dataclass(frozen=True)
class Roughness:
    """What the formulas know of a surface.

    Parameters
    ----------
    Sq : float
        Root-mean-square height [m].
    Sdq : float
        Root-mean-square gradient h′.
    Sal : float or None
        Autocorrelation length [m]; without it gap and plastic volume are less sure.
    Str, Ssk, Sku : float
        Texture aspect ratio, skewness and kurtosis.
    waves : float or None
        Autocorrelation lengths along the shorter side, where it is that of a map.
    """

    Sq: float
    Sdq: float
    Sal: float | None
    Str: float
    Ssk: float
    Sku: float
    waves: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Result):
    """A nominally flat contact by fitted formulas.

    Parameters
    ----------
    pressure : float
        Load over nominal area p̄ [Pa].
    contact_modulus : float
        E* [Pa].
    ceiling : float or None
        Largest pressure [Pa]; None where nothing yields.
    yield_strength : float or None
        Of the softer body [Pa].
    roughness : Roughness
        Parameters of the surface, or of the gap between two.
    contact, saturated : Range
        Contact area, saturated area included, and saturated area, over nominal area.
    gap : Range
        Mean open gap [m].
    plastic_volume : Range or None
        Volume of material with any plastic strain over nominal area [m], not of what is displaced;
        None where nothing yields or the formula does not hold, see ``cautions``.
    theory_contact : float
        Contact fraction of Persson's theory.
    cautions : tuple of Caution
        What a reader of the numbers has to know.
    """

    pressure: float
    contact_modulus: float
    ceiling: float | None
    yield_strength: float | None
    roughness: Roughness
    contact: Range
    saturated: Range
    gap: Range
    plastic_volume: Range | None
    theory_contact: float
    cautions: tuple[Caution, ...] = ()

    @property
    def plasticity_index(self) -> float | None:
        """E* h′/σ_Y; None where no yield strength is known."""
        if self.yield_strength is None:
            return None
        return self.contact_modulus * self.roughness.Sdq / self.yield_strength


@checked
def estimate(
    surface: Surface | None = None,
    *,
    pressure: Quantity,
    material: Material,
    counter_material: Material = RIGID,
    ceiling: Quantity | None = "auto",
    Sq: Quantity | None = None,
    Sdq: float | None = None,
    Sal: Quantity | None = None,
    Str: float | None = None,
    Ssk: float | None = None,
    Sku: float | None = None,
) -> Estimate:
    """Return contact area, gap and plastic volume of a nominally flat contact by formulas.

    Parameters
    ----------
    surface : Surface, optional
        A map, leveled and without holes, whose parameters count where none is given below.
    pressure : float, str or quantity of pint
        Load over nominal area [Pa].
    material, counter_material : Material
        Of the rough body and of its counter-body.
    ceiling : "auto", float, str, quantity of pint or None
        Largest pressure [Pa]; ``"auto"`` is three times the smaller yield strength, or else the
        hardness, ``None`` is purely elastic.
    Sq : float, str or quantity of pint
        Root-mean-square height [m]. Of two rough bodies that of the gap: the squares add.
    Sdq : float
        Root-mean-square gradient; its squares add, too.
    Sal : float, str or quantity of pint, optional
        Autocorrelation length [m]. Without it gap and plastic volume are less sure.
    Str : float, optional
        Texture aspect ratio; by default 1.
    Ssk : float, optional
        Skewness; by default 0.
    Sku : float, optional
        Kurtosis; by default 3 + 1.5 Ssk², which is 3 of a Gaussian surface.

    Returns
    -------
    Estimate
        Each quantity with the interval that holds 90 of 100 maps: of a surface of which nothing
        but the parameters is known, or, wider, of measured ones.

    Raises
    ------
    InputError
        If an argument cannot be used, the ceiling cannot carry the load, or the contact lies
        outside the domain of the formulas; the message says what that is.

    Notes
    -----
    The contact is that of a periodic map: of a large, nominally flat surface, of which the edges
    do not count. See `roughcontact.joint.formulas` for the form of the formulas, and the page on
    estimates for what they miss. The plastic volume is that of perfect plasticity or linear
    hardening at ν = 0.3.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = estimate(pressure="50 MPa", material=steel, Sq="0.5 um", Sdq=0.1, Sal="12 um")
    >>> found.contact.low < found.contact.value < found.contact.high
    True
    """
    given = {"Sq": quantity(Sq, "length", "Sq"), "Sdq": Sdq,
             "Sal": quantity(Sal, "length", "Sal"), "Str": Str, "Ssk": Ssk, "Sku": Sku}  # fmt: skip
    roughness = _roughness(surface, given)
    mean = quantity(pressure, "pressure", "pressure")
    require_positive(pressure=mean)
    strengths = [one.yield_strength for one in (material, counter_material) if one.yield_strength]
    strength = min(strengths, default=None)
    limit = _limit(ceiling, material, counter_material)
    return _estimated(
        mean, contact_modulus(material, counter_material), limit, strength, roughness,
        _hardening(material, counter_material),
    )  # fmt: skip


def of_result(result: ContactResult) -> Estimate | None:
    """Return what the formulas say of a contact that was solved.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    Estimate or None
        None unless the contact is one of a periodic, nominally flat map under one ceiling or
        none, within the domain of the formulas, which one process holds.
    """
    pair = result.pair
    flat = not (pair.is_profile or pair.is_shared) and len(result.boundary.periodic_axes) == 2
    if not flat or result.smooth is not None or isinstance(result.ceiling, np.ndarray):
        return None
    gap = Surface(-np.asarray(result.initial_gap), pair.pixel)
    softer = pair.softer
    strength = None if softer is None else softer.yield_strength
    try:
        return _estimated(
            result.load / math.prod(pair.size), result.contact_modulus, result.ceiling, strength,
            of_surface(gap), _hardening(pair.material, pair.counter_material),
        )  # fmt: skip
    except InputError:
        return None


def of_surface(surface: Surface) -> Roughness:
    """Return what the formulas know of a map."""
    values = surface.roughness()
    texture = values["Str"] if math.isfinite(values["Str"]) else values["Str_max"]
    known = {name: values[name] for name in ("Sq", "Sdq", "Sal", "Ssk", "Sku")}
    for name, value in (*known.items(), ("Str", texture)):
        if not math.isfinite(value):
            raise InputError(
                f"shows no {name}: it is flat, or its waves are longer than it is",
                argument="surface",
            )
    return Roughness(**known, Str=texture, waves=min(surface.size) / known["Sal"])


def _roughness(surface: Surface | None, given: dict[str, Any]) -> Roughness:
    for name, value in given.items():
        if value is not None and name != "Ssk":
            require_positive(**{name: value})
        elif value is not None and not math.isfinite(value):
            raise InputError(f"must be finite, got {value!r}", argument=name, value=value)
    told = {name: value for name, value in given.items() if value is not None}
    if surface is not None:
        if surface.is_profile:
            raise InputError(
                "is a profile, and formulas are of areas: give Sq and Sdq of the surface",
                argument="surface",
            )
        return replace(of_surface(surface), **told)
    for name, what in (("Sq", "how high the surface is"), ("Sdq", "how steep")):
        if name not in told:
            raise InputError(f"must be given, or a map: {what}", argument=name)
    skewness = told.get("Ssk", 0.0)
    usual = {"Sal": None, "Str": 1.0, "Ssk": skewness, "Sku": johnson.usual_kurtosis(skewness)}
    return Roughness(**usual | told)


def _limit(ceiling: Quantity | None, *bodies: Material) -> float | None:
    if ceiling is None:
        return None
    if isinstance(ceiling, str) and ceiling == "auto":
        return min((body.ceiling for body in bodies if body.ceiling is not None), default=None)
    limit = quantity(ceiling, "pressure", "ceiling")
    require_positive(ceiling=limit)
    return float(limit)


def _hardening(*bodies: Material) -> float | None:
    """Return the hardening modulus of the softer body [Pa]; None of another law."""
    yielding = [body for body in bodies if body.yield_strength is not None]
    softer = min(yielding, key=lambda body: body.yield_strength or math.inf, default=None)
    law = None if softer is None else softer.hardening
    if isinstance(law, Linear):
        return float(law.modulus)
    return 0.0 if law is None or isinstance(law, Perfect) else None


# --- the formulas


def _estimated(
    pressure: float,
    modulus: float,
    ceiling: float | None,
    strength: float | None,
    roughness: Roughness,
    hardening: float | None,
) -> Estimate:
    if ceiling is not None and pressure > ceiling:
        raise InputError(
            f"= {pressure:.6g} Pa exceeds the ceiling of {ceiling:.6g} Pa: no such load can be "
            "carried",
            argument="pressure",
            value=pressure,
        )
    stress = modulus * roughness.Sdq
    groups = _groups(pressure, stress, 0.0 if ceiling is None else stress / ceiling, roughness)
    _require(groups, formulas.stored().domain[_CEILING], roughness)
    contact, saturated, gap = (
        _ranged(name, groups, roughness) for name in (CONTACT, SATURATED, GAP)
    )
    volume, said = _volume(pressure, stress, strength, hardening, roughness)
    return Estimate(
        pressure=pressure,
        contact_modulus=modulus,
        ceiling=ceiling,
        yield_strength=strength,
        roughness=roughness,
        contact=contact,
        saturated=saturated,
        gap=gap.times(roughness.Sq),
        plastic_volume=volume,
        theory_contact=persson_fractions(pressure, modulus, roughness.Sdq, ceiling)[0],
        cautions=ordered(said),
    )


def _groups(
    pressure: float, stress: float, ratio: float, roughness: Roughness, hardening: float = 0.0
) -> Groups:
    """Return the groups of one contact."""
    known = roughness.Sal is not None
    breadth = roughness.Sdq * (roughness.Sal or math.nan) / roughness.Sq if known else math.nan
    values = (pressure / stress, ratio, breadth, roughness.Str, roughness.Ssk,
              roughness.Sku, hardening)  # fmt: skip
    return Groups(*(np.array([float(value)]) for value in values))


def _ranged(quantity: str, groups: Groups, roughness: Roughness) -> Range:
    """Return a quantity with its interval, that of measured maps where it is that of a map."""
    atlas = formulas.stored()
    formula = atlas.formula(quantity, roughness.Sal is not None)
    wider = 1.0 if roughness.waves is None else atlas.measured
    return Range(*(float(end[0]) for end in formula.ranged(groups, wider)))


_WORDS = {
    "contact": "a contact fraction",
    "ratio": "E* Sdq over the ceiling",
    "breadth": "Sdq Sal/Sq",
    "texture": "Str",
    "skewness": "Ssk",
    "tails": "Sku/(3 + 1.5 Ssk²)",
    "middle": "Sku − Ssk² − 1",
    "hardening": "H Sdq/σ_Y",
}
_CAUSES = {
    "contact": "pressure", "ratio": "ceiling", "breadth": "Sal", "texture": "Str",
    "skewness": "Ssk", "tails": "Sku", "middle": "Sku", "hardening": "hardening",
}  # fmt: skip


def _outside(groups: Groups, domain: dict[str, tuple[float, float]]) -> dict[str, float]:
    """Return the groups that lie outside a domain, with their values."""
    values = {name: float(of[0]) for name, of in groups.told().items()}
    return {
        name: values[name]
        for name, (low, high) in domain.items()
        if not math.isnan(values[name]) and not low <= values[name] <= high
    }


def _told(name: str, value: float, domain: dict[str, tuple[float, float]]) -> str:
    low, high = domain[name]
    if name == "contact":
        return f"{_WORDS[name]} of {percent(low)} to {percent(high)}, got about {percent(value)}"
    return f"{_WORDS[name]} of {low:.3g} to {high:.3g}, got {value:.3g}"


def _require(groups: Groups, domain: dict[str, tuple[float, float]], roughness: Roughness) -> None:
    if roughness.waves is not None and roughness.waves < LEAST_WAVES:
        raise InputError(
            f"shows its own form: its shorter side is {roughness.waves:.1f} autocorrelation "
            f"lengths, and the formulas need {LEAST_WAVES:g}; solve the contact on it instead",
            argument="surface",
            value=roughness.waves,
        )
    for name, value in _outside(groups, domain).items():
        raise InputError(
            f"lies outside the formulas, which hold for {_told(name, value, domain)}; "
            "solve the contact on a map instead",
            argument=_CAUSES[name],
            value=value,
        )


def _volume(
    pressure: float,
    stress: float,
    strength: float | None,
    hardening: float | None,
    roughness: Roughness,
) -> tuple[Range | None, list[Caution]]:
    """Return the plastic volume over nominal area, or why it is not told."""
    if strength is None:
        return None, []
    if hardening is None:
        return None, [
            noted(Kind.DOMAIN, "the depth with plastic strain is told for perfect plasticity "
                  "and linear hardening only; for this law use ", Mention("model", "volume"))
        ]  # fmt: skip
    ratio = stress / (CEILING_FACTOR * strength)
    groups = _groups(pressure, stress, ratio, roughness, hardening * roughness.Sdq / strength)
    domain = formulas.stored().domain[_VOLUME]
    outside = [_told(name, value, domain) for name, value in _outside(groups, domain).items()]
    if outside:
        return None, [
            noted(
                Kind.DOMAIN,
                "the depth with plastic strain is not told: its formula holds for ",
                outside[0],
            )
        ]
    found = _ranged(VOLUME, groups, roughness)
    return found.times(roughness.Sq / roughness.Sdq), []
