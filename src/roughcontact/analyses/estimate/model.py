"""Estimates of nominally flat contact from roughness parameters, by fitted formulas."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from roughcontact._tools.arguments import validate_arguments
from roughcontact.analyses.estimate.stored_formulas import (
    CONTACT,
    GAP,
    SATURATED,
    VOLUME,
    DimensionlessGroups,
    load_atlas,
    theory_contact,
)
from roughcontact.cautions import Caution, CautionTag, as_note, sort_cautions
from roughcontact.contact.ceiling import recommend_ceiling
from roughcontact.contact.plausibility import IMPLAUSIBLE_SLOPE
from roughcontact.contact.result import CALIBRATED, MIN_SHOWN_CHANGE, ContactResult
from roughcontact.errors import (
    ArgumentRef,
    InputError,
    input_error,
    require_choice,
    require_positive,
)
from roughcontact.material import catalog
from roughcontact.material.fluids import gas
from roughcontact.material.hardening import Linear, Perfect
from roughcontact.material.material import (
    CEILING_FACTOR,
    RIGID,
    Conductor,
    Material,
    contact_modulus,
    softer_material,
)
from roughcontact.result import Result
from roughcontact.surface.surface import Surface
from roughcontact.theory import constriction, height_distribution
from roughcontact.theory.persson import persson_fractions
from roughcontact.theory.rarefied_gas import jump_distance, mean_free_path
from roughcontact.units import Quantity, format_engineering, format_percent, to_si

_CEILING, _VOLUME = "ceiling", "volume"
_MIN_CONTACT_FRACTION = 1e-4
# Slope within the spots over that of the map: 0.76 to 1.03 in 54 contacts of 1 to 28 % of maps
# with 4 to 16 pixels per shortest wave, which gives the calibrated ceiling to 5 %.
_SPOT_SLOPE = 0.9
# Largest contact fraction of the cases that the correlations of joints were compared with.
_JOINT = 0.12
MIN_WAVES = 6.0
"""Minimum shorter side of a map, in autocorrelation lengths, for a representative map."""


@dataclass(frozen=True)
class EstimateRange:
    """Value with the ends of the interval that holds 90 of 100 maps."""

    value: float
    low: float
    high: float

    def times(self, factor: float) -> EstimateRange:
        """Return the value in another unit."""
        return EstimateRange(self.value * factor, self.low * factor, self.high * factor)

    def scale_ends(self, low: float, high: float) -> EstimateRange:
        """Return the value with ends multiplied by factors."""
        return EstimateRange(self.value, self.low * low, self.high * high)


@dataclass(frozen=True)
class Roughness:
    """Surface parameters of the formulas."""

    Sq: float  # Root-mean-square height [m]
    Sdq: float  # Root-mean-square gradient h′
    Sal: float | None  # Autocorrelation length [m]
    Str: float  # Texture aspect ratio
    Ssk: float  # Skewness
    Sku: float  # Kurtosis
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
        Largest pressure [Pa]; None for elastic contact.
    yield_strength : float or None
        Yield strength of the softer body [Pa].
    roughness : Roughness
        Parameters of the surface, or of the gap between two.
    contact, saturated : EstimateRange
        Contact area (saturated area included) and saturated area, over nominal area.
    gap : EstimateRange
        Mean open gap [m].
    plastic_volume : EstimateRange or None
        Volume of material with any plastic strain over nominal area [m], not the displaced volume;
        None where nothing yields or the formula does not hold, see ``cautions``.
    theory_contact : float
        Contact fraction of Persson's theory.
    cautions : tuple of Caution
        Cautions on the result.
    bodies : (Material, Material), optional
        The rough body and its counter-body.
    stiffness : EstimateRange, optional
        Normal stiffness per nominal area at unloading [Pa/m]; None above 12 % contact.
    vacuum_conductance, air_conductance : EstimateRange, optional
        Thermal conductance per nominal area [W/(m² K)], by the spots alone and with air in the
        gap; None above 12 % contact or if a conductivity is unknown.
    finish : str
        Roughness and finish from which the parameters were derived.
    calibrated : Estimate, optional
        The same under the calibrated ceiling, if the ceiling was ``"auto"``.
    """

    pressure: float
    contact_modulus: float
    ceiling: float | None
    yield_strength: float | None
    roughness: Roughness
    contact: EstimateRange
    saturated: EstimateRange
    gap: EstimateRange
    plastic_volume: EstimateRange | None
    theory_contact: float
    cautions: tuple[Caution, ...] = ()
    bodies: tuple[Material, Material] | None = None
    stiffness: EstimateRange | None = None
    vacuum_conductance: EstimateRange | None = None
    air_conductance: EstimateRange | None = None
    finish: str = ""
    calibrated: Estimate | None = None

    @property
    def plasticity_index(self) -> float | None:
        """Plasticity index E* h′/σ_Y; None without a yield strength."""
        if self.yield_strength is None:
            return None
        return self.contact_modulus * self.roughness.Sdq / self.yield_strength


@validate_arguments
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
    Ra: Quantity | None = None,
    finish: str | None = None,
    counter_Ra: Quantity | None = None,
    counter_finish: str | None = None,
    conductor: Conductor | None = None,
    counter_conductor: Conductor | None = None,
) -> Estimate:
    """Return contact area, gap, stiffness and conductance of a nominally flat contact by formulas.

    Parameters
    ----------
    surface : Surface, optional
        A leveled map without missing points, for the parameters that are not given.
    pressure : float, str or quantity of pint
        Load over nominal area [Pa].
    material, counter_material : Material
        Materials of the rough body and of its counter-body.
    ceiling : "auto", "calibrated", float, str, quantity of pint or None
        Largest pressure [Pa]; ``"auto"`` is three times the smaller yield strength, or else the
        hardness, ``None`` is purely elastic. Intervals of ``"auto"`` and ``"calibrated"`` cover
        both; see `roughcontact.contact.ceiling`.
    Sq : float, str or quantity of pint
        Root-mean-square height [m]; of the gap for two rough bodies: the squares add.
    Sdq : float
        Root-mean-square gradient; of the gap for two rough bodies: the squares add.
    Sal : float, str or quantity of pint, optional
        Autocorrelation length [m]; without it, the intervals of gap and plastic volume are wider.
    Str : float, optional
        Texture aspect ratio; by default 1.
    Ssk : float, optional
        Skewness; by default 0.
    Sku : float, optional
        Kurtosis; by default 3 + 1.5 Ssk², which is 3 of a Gaussian surface.
    Ra, counter_Ra : float, str or quantity of pint, optional
        Arithmetic mean roughness of both faces [m], as on a drawing, instead of Sq and Sdq; without
        ``counter_Ra`` the other face is smooth.
    finish, counter_finish : str, optional
        Finish of the faces, one of `FINISHES`; that of the other face by default the same.
    conductor, counter_conductor : Conductor, optional
        Conductivities; by default from the names of the materials in the catalog.

    Returns
    -------
    Estimate
        Each quantity with the interval that holds 90 of 100 maps: generated surfaces with the
        same parameters, or, with a wider interval, measured maps.

    Raises
    ------
    InputError
        If an argument cannot be used, the ceiling cannot carry the load, or the contact is
        outside the domain of the formulas; the message gives the domain.

    Notes
    -----
    The estimate is for a periodic map, that is for a large, nominally flat surface without edge
    effects. See `roughcontact.analyses.estimate.model` for the form of the formulas, and the page
    on estimates for their limits. The plastic volume is for perfect plasticity or linear hardening
    at ν = 0.3.

    Ra and finish determine the parameters to a factor of two at best: the mean slope of a profile
    is m = 0.125 (σ/µm)^0.402, a correlation of machined faces that is used for the conductance of
    joints, and the intervals hold half and twice this slope. Other correlations are within: m =
    0.076 (σ/µm)^0.52 from σ of 0.2 µm, and the middle of σ/m = 5 to 9 µm for σ of 0.25 to 2.5 µm.
    A finish with a lay has Sdq = √(π/2) m, an isotropic one √π m. Heights are Gaussian, Sq = 1.25
    Ra; intervals hold 1.11 Ra (sine wave) to 1.41 Ra (Laplace distribution).

    Stiffness and conductance are those of the correlations of joints (`theory.constriction`) and
    of Barber's identity, E* times half the constriction length.

    References
    ----------
    Handbooks of joint conductance: Mechanical Engineers' Handbook, vol. 4, Cooling electronic
    equipment, p. 374 (σ/m); the correlations as quoted in the programs SESCTherm (0.125) and in
    public models of joints (0.076), whose first publications were not available
    Barber 2003, doi:10.1098/rspa.2002.1038

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = estimate(pressure="50 MPa", material=steel, Sq="0.5 um", Sdq=0.1, Sal="12 um")
    >>> found.contact.low < found.contact.value < found.contact.high
    True
    """
    drawn = _Drawing.from_faces((Ra, finish), (counter_Ra, counter_finish or finish))
    if surface is not None and drawn.text:
        raise InputError("cannot be combined with a map", argument="Ra")
    specified = {
        "Sq": drawn.Sq if Sq is None else to_si(Sq, "length", "Sq"),
        "Sdq": drawn.Sdq if Sdq is None else Sdq,
        "Sal": to_si(Sal, "length", "Sal"),
        "Str": Str,
        "Ssk": Ssk,
        "Sku": Sku,
    }
    roughness = _roughness(surface, specified)
    mean = to_si(pressure, "pressure", "pressure")
    require_positive(pressure=mean)
    if material.coating or counter_material.coating:
        raise InputError(
            "is not included in the formulas: solve a map of the surface", argument="coating"
        )
    bodies = material, counter_material
    of = catalog.conductor_of
    known = conductor or of(material.name), counter_conductor or of(counter_material.name)
    slopes = SLOPE_FACTORS if drawn.text and Sdq is None else (1.0,)
    heights = HEIGHT_FACTORS if drawn.text and Sq is None else (1.0, 1.0)

    def estimate_at(limit: float | None, slope: float) -> Estimate:
        actual = replace(roughness, Sdq=roughness.Sdq * slope)
        result = _estimate(mean, contact_modulus(*bodies), limit, actual, softer_material(*bodies))
        result = _with_joint(result, heights, *(body.conductivity for body in known))
        return replace(result, bodies=bodies, finish=drawn.text)

    return _estimate_under_ceilings(estimate_at, ceiling, bool(drawn.text), bodies, slopes)


def _estimate_under_ceilings(
    estimate_at: Callable[[float | None, float], Estimate],
    ceiling: Quantity | None,
    is_drawn: bool,
    bodies: tuple[Material, Material],
    slopes: Sequence[float],
) -> Estimate:
    """Return the estimate under one ceiling, or under both with intervals that cover both."""
    limits = [_limit(ceiling, *bodies)]
    hardness = min(body.hardness or math.inf for body in bodies)
    if is_drawn and ceiling == "auto" and limits[0] is not None:
        limits += [hardness] if limits[0] < hardness < math.inf else []
    results = [estimate_at(*case) for case in itertools.product(limits, slopes)]
    first, is_automatic = results[0], isinstance(ceiling, str) and ceiling in ("auto", CALIBRATED)
    if not is_automatic or first.yield_strength is None:
        return _union(results)
    others = [estimate_at(_calibrated_limit(first, slope, bodies), slope) for slope in slopes]
    if ceiling == CALIBRATED:
        return _union([*others, *results])
    change = others[0].contact.value / first.contact.value - 1
    second = _union(others) if abs(change) > MIN_SHOWN_CHANGE else None
    return replace(_union([*results, *others]), calibrated=second)


FINISHES = {
    **dict.fromkeys(("ground", "milled", "turned", "honed", "planed"), True),
    **dict.fromkeys(("lapped", "polished", "blasted", "eroded", "as-cast"), False),
}
"""Finishes, and whether they have a lay."""

SLOPE_FACTORS = (1.0, 0.5, 2.0)
"""Factors of the slope from Ra and finish: value and interval."""

# Sq over Ra of Gaussian heights, and that of a sine wave and of Laplace's distribution over it.
_GAUSSIAN = math.sqrt(math.pi / 2)
HEIGHT_FACTORS = (math.pi / math.sqrt(8) / _GAUSSIAN, math.sqrt(2) / _GAUSSIAN)

_RANGES = (
    "contact",
    "saturated",
    "gap",
    "plastic_volume",
    "stiffness",
    "vacuum_conductance",
    "air_conductance",
)

# Least Ra: five of six measured maps of smoother faces had slopes beyond these factors.
_SMOOTHEST = 0.05e-6

_AIR_PRESSURE, _AIR_TEMPERATURE = 1e5, 298.15


@dataclass(frozen=True)
class _Drawing:
    """Roughness of the gap between faces of a drawing."""

    Sq: float | None = None  # [m]
    Sdq: float | None = None
    text: str = ""

    @classmethod
    def from_faces(cls, *faces: tuple[Quantity | None, str | None]) -> _Drawing:
        """Return the gap of faces with Ra and finish; a face without Ra is smooth."""
        heights, slopes, texts = [], [], []
        for (given, finish), prefix in zip(faces, ("", "counter_"), strict=True):
            if given is None:
                continue
            height = to_si(given, "length", f"{prefix}Ra")
            require_positive(**{f"{prefix}Ra": height})
            if height < _SMOOTHEST:
                raise InputError(
                    f"must be at least {format_engineering(_SMOOTHEST, 'm')}, got "
                    f"{format_engineering(height, 'm')}; give Sq and Sdq of smoother faces",
                    argument=f"{prefix}Ra",
                    value=given,
                )
            require_choice(tuple(FINISHES), **{f"{prefix}finish": finish})
            heights.append(_GAUSSIAN * height)
            slope = 0.125 * (1e6 * heights[-1]) ** 0.402
            slopes.append(slope * math.sqrt(math.pi / 2 if FINISHES[str(finish)] else math.pi))
            texts.append(f"{finish} to Ra {format_engineering(height, 'm')}")
        if not heights:
            return cls()
        return cls(math.hypot(*heights), math.hypot(*slopes), " against ".join(texts))


def _union(results: Sequence[Estimate]) -> Estimate:
    """Return the first estimate with the outermost ends of each interval."""
    ranges: dict[str, Any] = {}
    for name in _RANGES:
        known = [item for item in (getattr(result, name) for result in results) if item is not None]
        # A value without a formula in one of the estimates has no interval.
        ranges[name] = None
        if len(known) == len(results):
            low, high = min(item.low for item in known), max(item.high for item in known)
            ranges[name] = EstimateRange(known[0].value, low, high)
    return replace(results[0], **ranges)


def _with_joint(
    result: Estimate, heights: tuple[float, float], first: float | None, second: float | None
) -> Estimate:
    """Return an estimate with stiffness and conductance, for heights between factors of Sq."""
    shape, volume = result.roughness, result.plastic_volume
    gap = result.gap.scale_ends(*heights)
    volume = None if volume is None else volume.scale_ends(*heights)
    result = replace(result, gap=gap, plastic_volume=volume)
    if result.contact.value > _JOINT:
        return result
    slope = shape.Sdq / math.sqrt(math.pi)
    lengths = [constriction.elastic_joint(result.pressure, result.contact_modulus, slope, shape.Sq)]
    if result.ceiling is not None:
        lengths.append(constriction.plastic_joint(result.pressure, result.ceiling, slope, shape.Sq))
    least, most = constriction.CORRELATION_RANGE
    middle = max(lengths) / math.sqrt(least * most)
    spread = math.sqrt(most / least)
    length = EstimateRange(middle, middle / spread / heights[1], middle * spread / heights[0])
    result = replace(result, stiffness=length.times(result.contact_modulus / 2))
    if first is None or second is None:
        return result
    solid = length.times(1 / (1 / first + 1 / second))
    ends = [
        part + _air_conductance(separation, shape.Sq)
        for part, separation in zip(
            (solid.value, solid.low, solid.high), (gap.value, gap.high, gap.low), strict=True
        )
    ]
    return replace(result, vacuum_conductance=solid, air_conductance=EstimateRange(*ends))


def _air_conductance(gap: float, Sq: float) -> float:
    """Return the conductance of air below a plane over Gaussian heights [W/(m² K)].

    The plane is at the height that gives the mean gap; the local conductance is k/(g + M).
    Yovanovich, DeVaal and Hegazy 1982, doi:10.2514/6.1982-888
    """
    air = gas("air")
    path = mean_free_path(
        air.viscosity_at(_AIR_TEMPERATURE), _AIR_PRESSURE, air.molar_mass.value, _AIR_TEMPERATURE
    )
    jump = jump_distance(path, air.accommodation.value, air.heat_capacity_ratio.value, air.prandtl)
    from scipy.special import ndtr

    scores, step = np.linspace(-6, 6, 1201, retstep=True)
    density = np.exp(-(scores**2) / 2) / math.sqrt(2 * math.pi)
    depth = Sq * (np.interp(gap / Sq, scores * ndtr(scores) + density, scores) - scores)
    below = depth > 0
    conductivity = air.conductivity_at(_AIR_TEMPERATURE)
    return float(step * conductivity * np.sum(density[below] / (depth[below] + jump)))


def estimate_result(result: ContactResult) -> Estimate | None:
    """Return the estimate for a solved contact; None if the formulas do not apply."""
    pair = result.pair
    flat = not pair.is_profile and len(result.boundary.periodic_axes) == 2
    flat = flat and not pair.is_coated
    if not flat or result.hertz is not None or isinstance(result.ceiling, np.ndarray):
        return None
    gap = Surface(-np.asarray(result.initial_gap), pair.pixel)
    try:
        return _estimate(
            result.load / math.prod(pair.size),
            result.contact_modulus,
            result.ceiling,
            surface_parameters(gap),
            pair.softer,
        )
    except InputError:
        return None


def surface_parameters(surface: Surface) -> Roughness:
    """Return the roughness parameters of a map for the formulas."""
    values = surface.roughness()
    texture = values["Str"] if math.isfinite(values["Str"]) else values["Str_max"]
    known = {name: values[name] for name in ("Sq", "Sdq", "Sal", "Ssk", "Sku")}
    for name, value in (*known.items(), ("Str", texture)):
        if not math.isfinite(value):
            raise InputError(
                f"shows no {name}: it is flat, or its waves are longer than the map",
                argument="surface",
            )
    return Roughness(**known, Str=texture, waves=min(surface.size) / known["Sal"])


def _roughness(surface: Surface | None, specified: dict[str, Any]) -> Roughness:
    for name, value in specified.items():
        if value is not None and name != "Ssk":
            require_positive(**{name: value})
        elif value is not None and not math.isfinite(value):
            raise input_error(name, value, "must be finite")
    stated = {name: value for name, value in specified.items() if value is not None}
    if stated.get("Sdq", 0.0) > IMPLAUSIBLE_SLOPE:
        raise input_error("Sdq", stated["Sdq"], f"is a slope, at most {IMPLAUSIBLE_SLOPE:g}")
    if surface is not None:
        if surface.is_profile:
            raise InputError(
                "is a profile, and the formulas apply to areas: give Sq and Sdq of the surface",
                argument="surface",
            )
        return replace(surface_parameters(surface), **stated)
    for name, what in (("Sq", "root-mean-square height"), ("Sdq", "root-mean-square slope")):
        if name not in stated:
            raise InputError(
                f"is needed without a map: the {what}; or give {ArgumentRef('Ra')} and "
                f"{ArgumentRef('finish')}",
                argument=name,
            )
    skewness = stated.get("Ssk", 0.0)
    usual = {
        "Sal": None,
        "Str": 1.0,
        "Ssk": skewness,
        "Sku": height_distribution.usual_kurtosis(skewness),
    }
    return Roughness(**usual | stated)


def _calibrated_limit(usual: Estimate, factor: float, bodies: tuple[Material, Material]) -> float:
    """Return the calibrated ceiling of a surface with this factor of the slope [Pa]."""
    mean = usual.pressure / usual.contact.value
    within = math.sqrt(2) * _SPOT_SLOPE * factor * usual.roughness.Sdq
    return recommend_ceiling(bodies, within, mean, usual.pressure).ceiling


def _limit(ceiling: Quantity | None, *bodies: Material) -> float | None:
    if ceiling is None:
        return None
    if isinstance(ceiling, str) and ceiling == CALIBRATED:
        softer = softer_material(*bodies)
        if softer is None or softer.yield_strength is None:
            raise InputError("needs the yield strength of the softer body", argument="ceiling")
        return softer.ceiling
    if isinstance(ceiling, str) and ceiling == "auto":
        return min((body.ceiling for body in bodies if body.ceiling is not None), default=None)
    limit = to_si(ceiling, "pressure", "ceiling")
    require_positive(ceiling=limit)
    return float(limit)


def _hardening_modulus(softer: Material | None) -> float | None:
    """Return the hardening modulus of the softer body [Pa]; None for a nonlinear law."""
    law = None if softer is None else softer.hardening
    if isinstance(law, Linear):
        return float(law.modulus)
    return 0.0 if law is None or isinstance(law, Perfect) else None


def _estimate(
    pressure: float,
    modulus: float,
    ceiling: float | None,
    roughness: Roughness,
    softer: Material | None,
) -> Estimate:
    if ceiling is not None and pressure > ceiling:
        raise InputError(
            f"= {pressure / 1e6:.6g} MPa exceeds the ceiling of {ceiling / 1e6:.6g} MPa",
            argument="pressure",
            value=pressure,
        )
    stress = modulus * roughness.Sdq
    domain = load_atlas().domain[_CEILING]
    # Above the largest ratio the contact fraction is p̄ over the ceiling for any slope.
    ratio = 0.0 if ceiling is None else min(stress / ceiling, domain["ratio"][1])
    groups = _groups(pressure, ratio * ceiling if ceiling else stress, ratio, roughness)
    fitted, highest = domain["contact"]
    _require(groups, {**domain, "contact": (_MIN_CONTACT_FRACTION, highest)}, roughness)
    contact, saturated, gap = (
        _with_interval(name, groups, roughness) for name in (CONTACT, SATURATED, GAP)
    )
    strength = None if softer is None else softer.yield_strength
    volume, said = _volume(pressure, stress, strength, _hardening_modulus(softer), roughness)
    if float(theory_contact(groups)[0]) < fitted:
        text = f"Lighter than the fitted contacts ({format_percent(fitted)}): extrapolated."
        said.append(as_note(CautionTag.ESTIMATE_DOMAIN, text))
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
        cautions=sort_cautions(said),
    )


def _groups(
    pressure: float, stress: float, ratio: float, roughness: Roughness, hardening: float = 0.0
) -> DimensionlessGroups:
    """Return the dimensionless groups of one contact."""
    known = roughness.Sal is not None
    breadth = roughness.Sdq * (roughness.Sal or math.nan) / roughness.Sq if known else math.nan
    shape = (roughness.Str, roughness.Ssk, roughness.Sku)
    values = (pressure / stress, ratio, breadth, *shape, hardening)
    return DimensionlessGroups(*(np.array([float(value)]) for value in values))


def _with_interval(
    quantity: str, groups: DimensionlessGroups, roughness: Roughness
) -> EstimateRange:
    """Return a quantity with its interval, which is wider for a measured map."""
    atlas = load_atlas()
    formula = atlas.formula(quantity, roughness.Sal is not None)
    wider = 1.0 if roughness.waves is None else atlas.measured
    return EstimateRange(*(float(end[0]) for end in formula.with_interval(groups, wider)))


# Name of each group in messages, and the argument that sets it.
_GROUPS = {
    "contact": ("a contact fraction", "pressure"),
    "ratio": ("E* Sdq over the ceiling", "ceiling"),
    "breadth": ("Sdq Sal/Sq", "Sal"),
    "texture": ("Str", "Str"),
    "skewness": ("Ssk", "Ssk"),
    "tails": ("Sku/(3 + 1.5 Ssk²)", "Sku"),
    "middle": ("Sku − Ssk² − 1", "Sku"),
    "hardening": ("H Sdq/σ_Y", "hardening"),
}


def _outside_domain(
    groups: DimensionlessGroups, domain: dict[str, tuple[float, float]]
) -> dict[str, float]:
    """Return name and value of the groups outside a domain."""
    values = {name: float(of[0]) for name, of in groups.values().items()}
    return {
        name: values[name]
        for name, (low, high) in domain.items()
        if not math.isnan(values[name]) and not low <= values[name] <= high
    }


def _range_text(name: str, value: float, domain: dict[str, tuple[float, float]]) -> str:
    low, high = domain[name]
    if name == "contact":
        return (
            f"{_GROUPS[name][0]} of {format_percent(low)} to {format_percent(high)}, got about "
            f"{format_percent(value)}"
        )
    return f"{_GROUPS[name][0]} of {low:.3g} to {high:.3g}, got {value:.3g}"


def _require(
    groups: DimensionlessGroups, domain: dict[str, tuple[float, float]], roughness: Roughness
) -> None:
    if roughness.waves is not None and roughness.waves < MIN_WAVES:
        raise InputError(
            f"shows its own form: its shorter side is {roughness.waves:.1f} autocorrelation "
            f"lengths, and the formulas need {MIN_WAVES:g}; solve the contact on it instead",
            argument="surface",
            value=roughness.waves,
        )
    for name, value in _outside_domain(groups, domain).items():
        raise InputError(
            f"is outside the range of the formulas, {_range_text(name, value, domain)}; solve the "
            "contact on a map instead",
            argument=_GROUPS[name][1],
            value=value,
        )


def _volume(
    pressure: float,
    stress: float,
    strength: float | None,
    hardening: float | None,
    roughness: Roughness,
) -> tuple[EstimateRange | None, list[Caution]]:
    """Return the plastic volume over nominal area, or None with the reason as a note."""
    if strength is None:
        return None, []
    if hardening is None:
        text = (
            "No formula for plastic depth with this hardening law. Use "
            f"{ArgumentRef('model', 'elastoplastic')}."
        )
        return None, [as_note(CautionTag.ESTIMATE_DOMAIN, text)]
    ratio = stress / (CEILING_FACTOR * strength)
    groups = _groups(pressure, stress, ratio, roughness, hardening * roughness.Sdq / strength)
    domain = load_atlas().domain[_VOLUME]
    for name, value in _outside_domain(groups, domain).items():
        text = f"No plastic depth: its formula holds for {_range_text(name, value, domain)}."
        return None, [as_note(CautionTag.ESTIMATE_DOMAIN, text)]
    return _with_interval(VOLUME, groups, roughness).times(roughness.Sq / roughness.Sdq), []
