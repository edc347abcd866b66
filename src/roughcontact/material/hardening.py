"""Von Mises plasticity: hardening laws, back stress, and radial return.

A law is a frozen dataclass with two methods: ``strength(strain)`` returns the yield strength [Pa]
at an accumulated plastic strain, ``slope(strain)`` its derivative [Pa]. `Kinematic` adds a back
stress to one of the others, which depends on the direction of plastic strain.

`plastic_increment`: Simo and Hughes, Computational Inelasticity (1998), boxes 3.1 and 3.2,
doi:10.1007/b98904; as "universal algorithm" Fotiu and Nemat-Nasser, Int. J. Plast. 12 (1996),
doi:10.1016/S0749-6419(96)00024-4
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arguments import set_fields, validate_arguments
from roughcontact.errors import ArgumentRef, InputError, input_error, require_positive
from roughcontact.units import Quantities, Quantity, to_si

Array = NDArray[Any]

# Maximum number of Newton steps of a return mapping; concave laws need three to six.
_STEPS = 50


@dataclass(frozen=True)
class Perfect:
    """Perfect plasticity: constant yield strength.

    Parameters
    ----------
    initial : float
        Yield strength σ_Y [Pa].

    Raises
    ------
    InputError
        If the yield strength is not positive and finite.
    """

    initial: float

    @validate_arguments
    def __init__(self, initial: Quantity) -> None:
        object.__setattr__(self, "initial", to_si(initial, "pressure", "initial"))
        require_positive(initial=self.initial)

    def strength(self, strain: Array) -> Array:
        """Return the yield strength [Pa] at accumulated plastic strains."""
        return np.full_like(strain, self.initial)

    def slope(self, strain: Array) -> Array:
        """Return the derivative of the yield strength [Pa]."""
        return np.zeros_like(strain)


@dataclass(frozen=True)
class Linear:
    """Linear hardening: yield strength σ_Y + H e at the plastic strain e.

    Parameters
    ----------
    initial : float
        Initial yield strength σ_Y [Pa].
    modulus : float
        Hardening modulus H [Pa]: slope of stress over *plastic* strain. From a tangent modulus
        E_t of the stress-strain curve, ``H = E_t/(1 - E_t/E)``.

    Raises
    ------
    InputError
        If the strength is not positive or the modulus is negative.

    Examples
    --------
    >>> float(Linear(initial=1e9, modulus=2e9).strength(np.array(0.1)))
    1200000000.0
    """

    initial: float
    modulus: float

    @validate_arguments
    def __init__(self, initial: Quantity, modulus: Quantity) -> None:
        object.__setattr__(self, "initial", to_si(initial, "pressure", "initial"))
        object.__setattr__(self, "modulus", to_si(modulus, "pressure", "modulus"))
        require_positive(initial=self.initial)
        _require_modulus(self.modulus)

    def strength(self, strain: Array) -> Array:
        """Return the yield strength [Pa] at accumulated plastic strains."""
        return self.initial + self.modulus * strain

    def slope(self, strain: Array) -> Array:
        """Return the derivative of the yield strength [Pa]."""
        return np.full_like(strain, self.modulus)


@dataclass(frozen=True)
class Swift:
    """Swift's hardening law: yield strength B (C + 10⁶ e)ⁿ.

    Parameters
    ----------
    coefficient : float
        B [Pa].
    offset : float
        C, in millionths of strain.
    exponent : float
        n, from 0 to 1.

    Raises
    ------
    InputError
        If B or C is not positive and finite, or n is outside [0, 1].

    References
    ----------
    Swift, J. Mech. Phys. Solids 1 (1952) 1, doi:10.1016/0022-5096(52)90002-1; in this form
    El Ghazal, cited by Nélias et al., J. Tribol. 128 (2006) 235, doi:10.1115/1.2163360

    Examples
    --------
    >>> law = Swift(coefficient=1240e6, offset=30, exponent=0.085)
    >>> round(law.initial / 1e6)
    1656
    """

    coefficient: float
    offset: float
    exponent: float

    @validate_arguments
    def __init__(self, coefficient: Quantity, offset: float, exponent: float) -> None:
        stress = to_si(coefficient, "pressure", "coefficient")
        set_fields(self, coefficient=stress, offset=offset, exponent=exponent)
        require_positive(coefficient=self.coefficient, offset=self.offset)
        if not isinstance(self.exponent, Real) or not 0 <= self.exponent <= 1:
            raise input_error("exponent", self.exponent, "must be in [0, 1]")

    @property
    def initial(self) -> float:
        """Yield strength before any plastic strain [Pa]."""
        return float(self.coefficient * self.offset**self.exponent)

    def strength(self, strain: Array) -> Array:
        """Return the yield strength [Pa] at accumulated plastic strains."""
        return self.coefficient * (self.offset + 1e6 * strain) ** self.exponent

    def slope(self, strain: Array) -> Array:
        """Return the derivative of the yield strength [Pa]."""
        factor = 1e6 * self.exponent * self.coefficient
        return factor * (self.offset + 1e6 * strain) ** (self.exponent - 1)


@dataclass(frozen=True)
class Tabulated:
    """Yield strength interpolated between measured points, constant beyond the last one.

    Parameters
    ----------
    strain : tuple of float
        Plastic strains, increasing from 0.
    stress : tuple of float
        Yield strengths at these strains [Pa], never decreasing.

    Raises
    ------
    InputError
        If the table is too short, of unequal length, not in order or not positive.

    Examples
    --------
    >>> law = Tabulated(strain=(0.0, 0.01, 0.1), stress=(1.0e9, 1.2e9, 1.3e9))
    >>> law.strength(np.array([0.005, 0.5])).tolist()
    [1100000000.0, 1300000000.0]
    """

    strain: tuple[float, ...]
    stress: tuple[float, ...]

    @validate_arguments
    def __init__(self, strain: Sequence[float], stress: Quantities) -> None:
        set_fields(self, strain=strain, stress=to_si(stress, "pressure", "stress"))
        self._check()

    def _check(self) -> None:
        """Raise `InputError` for a table that is too short, out of order or not positive."""
        try:
            strain, stress = (np.array(row, float) for row in (self.strain, self.stress))
        except ValueError:
            raise InputError(
                f"and {ArgumentRef('stress')} must be rows of numbers", argument="strain"
            ) from None
        if strain.ndim != 1 or strain.shape != stress.shape or strain.size < 2:
            raise InputError(
                f"and {ArgumentRef('stress')} must be rows of the same length, two or more; got "
                f"shapes {strain.shape} and {stress.shape}",
                argument="strain",
            )
        if strain[0] != 0 or not (np.diff(strain) > 0).all() or not np.isfinite(strain).all():
            raise input_error("strain", self.strain, "must increase from 0 on")
        if not stress[0] > 0 or not np.isfinite(stress).all():
            raise input_error("stress", self.stress, "must be positive and finite [Pa]")
        if (np.diff(stress) < 0).any():
            raise InputError(
                f"must not decrease, got {self.stress!r}: a material that softens has no "
                "unique solution here",
                argument="stress",
                value=self.stress,
            )
        set_fields(self, strain=tuple(strain.tolist()), stress=tuple(stress.tolist()))

    @property
    def initial(self) -> float:
        """Yield strength before any plastic strain [Pa]."""
        return self.stress[0]

    def strength(self, strain: Array) -> Array:
        """Return the yield strength [Pa] at accumulated plastic strains."""
        return np.interp(strain, self.strain, self.stress).astype(strain.dtype)

    def slope(self, strain: Array) -> Array:
        """Return the derivative of the yield strength [Pa], from the right at a point."""
        steps = np.append(np.diff(self.stress) / np.diff(self.strain), 0.0)
        place = np.searchsorted(self.strain, strain, side="right") - 1
        return steps[place].astype(strain.dtype)


Isotropic = Perfect | Linear | Swift | Tabulated


@dataclass(frozen=True)
class Kinematic:
    """Kinematic hardening: yield strength around a back stress linear in plastic strain.

    After plastic strain in one direction, metal yields earlier in the opposite direction
    (Bauschinger effect), and under alternating loads the strain ends in a closed cycle.

    Parameters
    ----------
    isotropic : Perfect, Linear, Swift or Tabulated
        Growth of the yield strength with the accumulated plastic strain.
    modulus : float
        C [Pa]: the back stress is 2/3 C times the tensor of plastic strain (Prager's linear law),
        so that a bar carries σ_Y + C e in its first tension. The part of a measured slope that is
        recovered at reversals belongs here, the rest in ``isotropic``.

    Raises
    ------
    InputError
        If ``isotropic`` is not one of the laws, or the modulus is negative.

    References
    ----------
    Prager, Proc. Inst. Mech. Eng. 169 (1955) 41, doi:10.1243/PIME_PROC_1955_169_015_02;
    Simo and Hughes, Computational Inelasticity (1998), section 3.3, doi:10.1007/b98904

    Examples
    --------
    >>> law = Kinematic(Perfect(1e9), modulus=10e9)
    >>> float(law.strength(np.array(0.02))), float(flow_stress(law, np.array(0.02)))
    (1000000000.0, 1200000000.0)
    """

    isotropic: Isotropic
    modulus: float

    @validate_arguments
    def __init__(self, isotropic: Isotropic, modulus: Quantity) -> None:
        set_fields(self, isotropic=isotropic, modulus=to_si(modulus, "pressure", "modulus"))
        _require_modulus(self.modulus)

    @property
    def initial(self) -> float:
        """Yield strength before any plastic strain [Pa]."""
        return self.isotropic.initial

    def strength(self, strain: Array) -> Array:
        """Return the yield strength around the back stress [Pa]."""
        return self.isotropic.strength(strain)

    def slope(self, strain: Array) -> Array:
        """Return the derivative of the yield strength around the back stress [Pa]."""
        return self.isotropic.slope(strain)


Hardening = Isotropic | Kinematic


def back_modulus(law: Hardening) -> float:
    """Return C [Pa] of the back stress 2/3 C ε_p; zero for laws without back stress."""
    return law.modulus if isinstance(law, Kinematic) else 0.0


def flow_stress(law: Hardening, strain: Array) -> Array:
    """Return the stress [Pa] of a bar under monotonic plastic strain."""
    return law.strength(strain) + back_modulus(law) * strain


def _require_modulus(modulus: Any) -> None:
    if not isinstance(modulus, Real) or not 0 <= float(modulus) < math.inf:
        raise InputError(
            f"must be zero or positive and finite [Pa], got {modulus!r}: "
            "a material that softens has no unique solution here",
            argument="modulus",
            value=modulus,
        )


def to_text(law: Hardening) -> str:
    """Return a hardening law as JSON."""
    return json.dumps(law, default=lambda law: {"law": type(law).__name__, **vars(law)})


def from_text(text: str) -> Hardening:
    """Return the hardening law from the result of `to_text`."""
    try:
        return _law(json.loads(text))
    except (KeyError, TypeError, AttributeError, json.JSONDecodeError):
        raise input_error("hardening", text, "must be JSON that names a law") from None


def _law(constants: dict[str, Any]) -> Hardening:
    laws: dict[str, type[Hardening]] = {
        law.__name__: law for law in (Perfect, Linear, Swift, Tabulated, Kinematic)
    }
    kind = laws[constants.pop("law")]
    if kind is Kinematic:
        constants["isotropic"] = _law(constants["isotropic"])
    return kind(**constants)


def plastic_increment(trial: Array, strain: Array, law: Hardening, shear_modulus: float) -> Array:
    """Return the plastic strain increment that returns trial stresses to the yield surface."""
    stiffness = 3 * shear_modulus + back_modulus(law)
    law = law.isotropic if isinstance(law, Kinematic) else law
    excess = trial - law.strength(strain)
    flows = excess > 0
    if isinstance(law, Perfect | Linear):
        step = excess / (stiffness + (law.modulus if isinstance(law, Linear) else 0.0))
        return np.maximum(step, 0)
    step = np.zeros_like(trial)
    # Newton steps may oscillate at the corners of a table: a bracket ensures convergence.
    low, high = np.zeros_like(trial), np.maximum(excess, 0) / stiffness
    small = 4 * float(np.finfo(trial.dtype).eps)
    for _ in range(_STEPS):
        shifted = strain + step
        miss = trial - stiffness * step - law.strength(shifted)
        if not (flows & (np.abs(miss) > small * trial)).any():
            break
        low = np.where(miss > 0, step, low)
        high = np.where(miss > 0, high, step)
        newton = step + miss / (stiffness + law.slope(shifted))
        step = np.where((newton >= low) & (newton <= high), newton, (low + high) / 2)
    step[~flows] = 0
    return step
