"""Materials: elastic constants, yield strength, hardness, and properties of pairs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Real

from roughcontact._tools.arguments import set_fields, validate_arguments
from roughcontact._tools.text import replace_unprintable
from roughcontact.errors import (
    ArgumentRef,
    InputError,
    input_error,
    require_choice,
    require_positive,
)
from roughcontact.material.hardening import Hardening, Perfect, Swift
from roughcontact.material.hardness import stress
from roughcontact.result import presentation
from roughcontact.units import Quantity, to_si

CEILING_FACTOR = 3.0
"""Pressure ceiling over yield strength of the softer body (Tabor 1951: H ≈ 3 σ_Y)."""

# Bounds of moduli and strengths [Pa], so that no power of them overflows or underflows.
_LEAST, _MOST = 1e-50, 1e50

# Poisson's ratio up to which a cylinder first yields at its surface.
_AT_SURFACE = 0.1938

MAX_STRENGTH_MISMATCH = 0.15
"""Relative excess of three yield strengths over the hardness that excludes one condition."""

PROOF_STRAIN, TABOR_STRAIN = 0.002, 0.08
"""Plastic strains of a proof stress and of a hardness test (Tabor 1951)."""


BASES = ("bonded", "frictionless")
"""Contact of the innermost layer of a coating with a rigid base."""


@dataclass(frozen=True)
class Layer:
    """Layer of a coating: isotropic, linearly elastic, bonded to its neighbors.

    Parameters
    ----------
    young : float, str or quantity of pint
        Young's modulus E: a number in Pa, or with its unit, as ``"200 GPa"``.
    poisson : float
        Poisson's ratio ν, in (-1, 0.5].
    thickness : float, str or quantity of pint
        Thickness h: a number in m, or with its unit, as ``"2 um"``.
    yield_strength, hardness, name
        As for `Material`.
    residual_stress : float, str or quantity of pint
        Stress in the plane of the layer before any load [Pa], tension positive, as ``"-2 GPa"``.

    Raises
    ------
    InputError
        If a constant is outside its range.

    Examples
    --------
    >>> Layer("200 GPa", 0.2, "2 um", name="DLC").thickness
    2e-06
    """

    young: float
    poisson: float
    thickness: float
    yield_strength: float | None = None
    hardness: float | None = None
    name: str = ""
    residual_stress: float = 0.0

    @validate_arguments
    def __init__(
        self,
        young: Quantity,
        poisson: float,
        thickness: Quantity,
        *,
        yield_strength: Quantity | None = None,
        hardness: Quantity | None = None,
        name: str = "",
        residual_stress: Quantity = 0.0,
    ) -> None:
        bulk = Material(young, poisson, yield_strength, name, hardness)
        if math.isinf(bulk.young):
            raise input_error("young", young, "must be finite: a layer is elastic")
        deep = to_si(thickness, "length", "thickness")
        require_positive(thickness=deep)
        residual = to_si(residual_stress, "pressure", "residual_stress")
        if not math.isfinite(residual):
            raise input_error("residual_stress", residual_stress, "must be finite")
        shared = ("young", "poisson", "yield_strength", "hardness", "name")
        set_fields(self, **{key: getattr(bulk, key) for key in shared})
        set_fields(self, thickness=deep, residual_stress=residual)

    @property
    def bulk(self) -> Material:
        """Body of the same material, without coating."""
        return Material(self.young, self.poisson, self.yield_strength, self.name, self.hardness)


@dataclass(frozen=True)
class Material:
    """Isotropic, linearly elastic material with an optional yield strength or hardness.

    Parameters
    ----------
    young : float, str or quantity of pint
        Young's modulus E: a number in Pa, or with its unit, as ``"210 GPa"``; ``inf`` for a rigid
        body.
    poisson : float
        Poisson's ratio ν, in (-1, 0.5].
    yield_strength : float, str or quantity of pint, optional
        Uniaxial yield strength σ_Y [Pa]; ``None`` if unknown or if the body never yields.
    name : str
        Name for reports.
    hardness : float, str or quantity of pint, optional
        Mean pressure under an indenter over its projected area [Pa], or the number of a test
        such as ``"62 HRC"``, see `hardness.ceiling`; the ceiling without a yield strength, as for
        ceramics.
    hardening : Perfect, Linear, Swift, Tabulated or Kinematic, optional
        Growth of the yield strength with the plastic strain; its initial value is the
        ``yield_strength``. For the default see ``law``.
    caveat : str
        Behavior that the model does not include, such as ``viscoelastic``; every result has a
        caution about this behavior.
    coating : sequence of Layer
        Layers on the body, the outermost first; the other constants are those of the base.
    base : {"bonded", "frictionless"}
        Contact of the innermost layer with a rigid base.

    Raises
    ------
    InputError
        If a constant is outside its range, or yield strength and hardening disagree.
    """

    young: float
    poisson: float
    yield_strength: float | None = None
    name: str = ""
    hardness: float | None = None
    hardening: Hardening | None = None
    caveat: str = ""
    coating: tuple[Layer, ...] = ()
    base: str = "bonded"

    @validate_arguments
    def __init__(
        self,
        young: Quantity,
        poisson: float,
        yield_strength: Quantity | None = None,
        name: str = "",
        hardness: Quantity | None = None,
        hardening: Hardening | None = None,
        caveat: str = "",
        coating: Sequence[Layer] = (),
        base: str = "bonded",
    ) -> None:
        strength = to_si(yield_strength, "pressure", "yield_strength")
        modulus, hard = to_si(young, "pressure", "young"), stress(hardness, "hardness")
        set_fields(self, young=modulus, poisson=poisson, yield_strength=strength, hardness=hard)
        set_fields(self, name=replace_unprintable(name), caveat=replace_unprintable(caveat))
        set_fields(self, hardening=hardening, coating=tuple(coating), base=base)
        self._check()

    @classmethod
    def _from_name(cls, name: str) -> Material:
        """Return a metal of the catalog."""
        return presentation().material(name)

    def _check(self) -> None:
        """Raise `InputError` for invalid constants, and set the yield strength by hardening."""
        for name in ("young", "poisson", "yield_strength", "hardness"):
            value = getattr(self, name)
            optional = name in ("yield_strength", "hardness")
            if not isinstance(value, Real) and not (optional and value is None):
                raise input_error(name, value, "must be a number in SI units")
        for name in ("young", "yield_strength", "hardness"):
            value = getattr(self, name)
            rigid = name == "young" and value == math.inf
            if value is not None and not (_LEAST <= value <= _MOST or rigid):
                without = "inf is rigid" if name == "young" else "leave it out where it is unknown"
                raise InputError(
                    f"must be positive, {_LEAST:g} to {_MOST:g} Pa, got {value!r}; {without}",
                    argument=name,
                    value=value,
                )
        if not -1 < self.poisson <= 0.5:
            raise input_error("poisson", self.poisson, "must be in (-1, 0.5]")
        require_choice(BASES, base=self.base)
        for layer in self.coating:
            if not isinstance(layer, Layer):
                raise input_error("coating", layer, "must be layers, as rc.Layer")
        if self.base == "frictionless" and not (self.coating and math.isinf(self.young)):
            raise input_error("base", self.base, "needs a coating on a rigid body")
        if self.hardening is None:
            return
        if not isinstance(self.hardening, Hardening):
            raise InputError(
                "must be Perfect, Linear, Swift, Tabulated or Kinematic, got "
                f"{type(self.hardening).__name__}",
                argument="hardening",
                value=self.hardening,
            )
        first = self.hardening.initial
        if self.yield_strength is not None and not math.isclose(self.yield_strength, first):
            raise InputError(
                f"= {self.yield_strength:.6g} Pa, but {ArgumentRef('hardening')} starts at "
                f"{first:.6g} Pa; leave one of them out",
                argument="yield_strength",
                value=self.yield_strength,
            )
        object.__setattr__(self, "yield_strength", first)

    @property
    def outermost(self) -> Material:
        """Material at the surface: the outermost layer, or the body itself."""
        return self.coating[0].bulk if self.coating else self

    @property
    def uncoated(self) -> Material:
        """Body without its coating."""
        return replace(self, coating=(), base="bonded") if self.coating else self

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - ν²)/E of the surface [1/Pa]; 0 for a rigid body."""
        surface = self.outermost
        return (1 - surface.poisson**2) / surface.young

    @property
    def ceiling(self) -> float | None:
        """Largest contact pressure of the material [Pa].

        Three yield strengths (Tabor 1951), or the hardness if no yield strength is known; ``None``
        without either, and for a coated body, for which no single value is valid.
        """
        if self.coating:
            return None
        if self.yield_strength is None:
            return self.hardness
        return CEILING_FACTOR * self.yield_strength

    @property
    def law(self) -> Hardening:
        """Hardening law from ``hardening``, yield strength and hardness.

        The law of ``hardening`` if there is one. If the hardness H exceeds 3 σ_Y, Swift's law
        through the yield strength and H/3 at the strain of a hardness test,
        σ = σ_Y (1 + e/0.002)ⁿ with n = ln(H/3σ_Y)/ln(41), at most 1. Else perfect plasticity.

        References
        ----------
        Tabor, The Hardness of Metals (1951): H ≈ 3 σ(8 %); Swift, J. Mech. Phys. Solids 1 (1952) 1
        """
        if self.hardening is not None:
            return self.hardening
        strength = self.yield_strength or math.inf
        usual = CEILING_FACTOR * strength
        if self.hardness is None or self.hardness <= usual:
            return Perfect(strength)
        exponent = math.log(self.hardness / usual) / math.log1p(TABOR_STRAIN / PROOF_STRAIN)
        offset, exponent = 1e6 * PROOF_STRAIN, min(exponent, 1.0)
        return Swift(strength / offset**exponent, offset, exponent)

    @property
    def hardens(self) -> bool:
        """Whether the yield strength grows with the plastic strain."""
        return self.yield_strength is not None and not isinstance(self.law, Perfect)

    @property
    def tabor_ratio(self) -> float | None:
        """Three yield strengths over the hardness, if the ratio exceeds 1 by more than 15 %.

        Strength and hardness are then not of one condition. ``None`` otherwise, and if a hardening
        law is given.
        """
        if self.yield_strength is None or self.hardness is None or self.hardening is not None:
            return None
        ratio = CEILING_FACTOR * self.yield_strength / self.hardness
        return ratio if ratio - 1 > MAX_STRENGTH_MISMATCH else None

    @property
    def first_yield_pressure(self) -> float | None:
        """Peak Hertz pressure of a sphere at first yield below the surface [Pa].

        ``1.295 exp(0.736 ν) σ_Y`` (Jackson and Green 2005, doi:10.1115/1.1866166), which is
        1.615 σ_Y at ν = 0.3. ``None`` without a yield strength, and for a coated body.
        """
        if self.yield_strength is None or self.coating:
            return None
        return 1.295 * math.exp(0.736 * self.poisson) * self.yield_strength

    @property
    def line_yield_pressure(self) -> float | None:
        """Peak Hertz pressure of a cylinder at first yield, in plane strain [Pa].

        ``σ_Y/(1 - 2 ν)`` up to ν = 0.1938, where yield starts at the surface, and beyond
        ``(1.164 + 2.975 ν - 2.906 ν²) σ_Y``, 1.795 σ_Y at ν = 0.3: accurate to 0.2 % (Green, Int.
        J. Appl. Mech. Eng. 10 (2005) 451). ``None`` without a yield strength, and for a coated
        body.
        """
        if self.yield_strength is None or self.coating:
            return None
        ratio = self.poisson
        if ratio <= _AT_SURFACE:
            return self.yield_strength / (1 - 2 * ratio)
        return (1.164 + 2.975 * ratio - 2.906 * ratio**2) * self.yield_strength


RIGID = Material(young=math.inf, poisson=0.0, name="rigid")
"""Body that neither deforms nor yields."""


@validate_arguments
def contact_modulus(material: Material, counter_material: Material) -> float:
    """Return the contact modulus E* of two bodies.

    Parameters
    ----------
    material, counter_material : Material
        The two bodies; at most one of them rigid.

    Returns
    -------
    float
        E* [Pa], from 1/E* = (1 - ν₁²)/E₁ + (1 - ν₂²)/E₂.

    Raises
    ------
    InputError
        If both bodies are rigid.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (4.9), doi:10.1017/CBO9781139171731

    Examples
    --------
    >>> steel = Material(young=210e9, poisson=0.3)
    >>> round(contact_modulus(steel, RIGID) / 1e9, 2)
    230.77
    """
    compliance = material.compliance + counter_material.compliance
    if compliance == 0:
        raise InputError("both bodies are rigid: at least one needs a finite Young's modulus")
    return 1 / compliance


def softer_material(first: Material, second: Material) -> Material | None:
    """Return the body with the smaller ceiling; ``None`` if unknown or a body is coated."""
    if first.coating or second.coating:
        return None
    known = [body for body in (first, second) if body.ceiling is not None]
    return min(known, key=lambda body: body.ceiling or math.inf, default=None)


@dataclass(frozen=True)
class Conductor:
    """Electrical resistivity and thermal conductivity of an isotropic body.

    Parameters
    ----------
    resistivity : float, str or quantity of pint, optional
        Electrical resistivity ρ: a number in Ω m, or with its unit, as ``"17 nohm m"``.
    conductivity : float, str or quantity of pint, optional
        Thermal conductivity k: a number in W/(m K), or with its unit, as ``"46 W/m/K"``.
    name : str
        Name for reports.
    softening_voltage, melting_voltage : float, str or quantity of pint, optional
        Contact voltages at which spots soften and melt [V].

    Raises
    ------
    InputError
        If a constant is not positive and finite.

    Examples
    --------
    >>> Conductor(resistivity="17 nohm m").resistivity
    1.7e-08
    """

    resistivity: float | None = None
    conductivity: float | None = None
    name: str = ""
    softening_voltage: float | None = None
    melting_voltage: float | None = None

    @validate_arguments
    def __init__(
        self,
        resistivity: Quantity | None = None,
        conductivity: Quantity | None = None,
        name: str = "",
        softening_voltage: Quantity | None = None,
        melting_voltage: Quantity | None = None,
    ) -> None:
        for argument, value, dimension in (
            ("resistivity", resistivity, "resistivity"),
            ("conductivity", conductivity, "conductivity"),
            ("softening_voltage", softening_voltage, "voltage"),
            ("melting_voltage", melting_voltage, "voltage"),
        ):
            object.__setattr__(self, argument, _positive(value, dimension, argument))
        object.__setattr__(self, "name", replace_unprintable(name))


def _positive(value: Quantity | None, dimension: str, argument: str) -> float | None:
    result = to_si(value, dimension, argument)
    if result is None:
        return None
    if not (isinstance(result, Real) and 0 < float(result) < math.inf):
        raise InputError(
            f"must be positive and finite, got {value!r}; leave it out where it is unknown",
            argument=argument,
            value=value,
        )
    return float(result)
