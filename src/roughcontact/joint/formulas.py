"""Fitted formulas of nominally flat contact: theory with an effective gradient, on arrays.

Contact and saturated area are those of Persson's theory for a gradient h_eff in place of h′, the
mean gap that of a plane which cuts off as much of the heights as the theory lets touch for
an effective gradient of the long waves, and the plastic volume a power law with a slowly changing
exponent. What is fitted is ln(h_eff/h′), a polynomial in a few groups without unit. Its
coefficients, their scatter and domain stand in ``atlas.json`` beside this module, which
``benchmarks/atlas.py`` writes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.theory.heights import gap_below_plane
from roughcontact.theory.persson import diffused

Array = NDArray[np.float64]

STORED = Path(__file__).with_name("atlas.json")

CONTACT, SATURATED, GAP, VOLUME = "contact", "saturated", "gap", "volume"
"""What there is a formula for."""

LEVEL = 0.95
"""Share of maps that fall into the interval of a formula."""

# Middle of the set, from which polynomials count.
_BREADTH, _TEXTURE = 3.0, 0.9
# Gradients from which coordinates are told, over h′; for the gap over Sq/Sal.
_FIRST = {CONTACT: 0.7, SATURATED: 0.7, GAP: 1.2, VOLUME: 0.7}
_LOGARITHMIC = (CONTACT, VOLUME)
_STEEPEST = 20.0


@dataclass(frozen=True)
class Groups:
    """Nominally flat contacts in groups without unit; arrays of one shape (n,).

    Parameters
    ----------
    pressure : ndarray
        p̄/(E* h′), h′ the root-mean-square gradient Sdq.
    ratio : ndarray
        E* h′ over the pressure ceiling, of the volume model over three yield strengths; 0 where
        nothing yields.
    breadth : ndarray
        Sdq Sal/Sq: how many slopes the waves have beside the longest; NaN where Sal is not known.
    texture, skewness : ndarray
        Str and Ssk.
    hardening : ndarray
        H h′/σ_Y, H the hardening modulus.
    """

    pressure: Array
    ratio: Array
    breadth: Array
    texture: Array
    skewness: Array
    hardening: Array

    def taken(self, chosen: Any) -> Groups:
        """Return some of them."""
        return Groups(**{name: values[chosen] for name, values in vars(self).items()})


@dataclass(frozen=True)
class Formula:
    """A formula for one quantity.

    Parameters
    ----------
    quantity : {"contact", "saturated", "gap", "volume"}
        A/A₀, saturated area/A₀, mean gap/Sq, or plastic volume h′/(Sq A₀).
    knee : float
        ``ratio`` beyond which the effective gradient falls with it.
    terms : tuple of str
        Products of coordinates, a letter each: z, load, as the normal score of the theory's
        contact area; w, plasticity; b, breadth; s, skewness; t, texture; k, hardening. An empty
        text is the constant.
    coefficients : tuple of float
        Of the terms.
    scatter_terms, scatter : tuple
        The same of ln of the standard deviation of what it misses: of ln(quantity) for contact
        and volume, of the root of the saturated area, and of the gap itself.
    factor : float
        Half width of the interval of `LEVEL`, over that.
    """

    quantity: str
    knee: float
    terms: tuple[str, ...]
    coefficients: tuple[float, ...]
    scatter_terms: tuple[str, ...] = ("",)
    scatter: tuple[float, ...] = (0.0,)
    factor: float = 1.96

    def design(self, groups: Groups, terms: tuple[str, ...] | None = None) -> Array:
        """Return the terms (those of the formula, or others), shape (n, number of terms)."""
        coordinates = _coordinates(self, groups)
        columns = []
        for term in self.terms if terms is None else terms:
            column = np.ones_like(groups.pressure)
            for letter in term:
                column = column * coordinates[letter]
            columns.append(column)
        return np.stack(columns, axis=1)

    def value(self, groups: Groups, design: Array | None = None) -> Array:
        """Return the quantity, shape (n,); ``design`` where it is known."""
        design = self.design(groups) if design is None else design
        fitted = _sum(design, self.coefficients)
        if self.quantity == VOLUME:
            volume: Array = np.exp(fitted)
            return volume
        gradient = np.exp(np.minimum(fitted - _plasticity(self, groups), np.log(_STEEPEST)))
        if self.quantity == GAP and not np.isnan(groups.breadth).any():
            gradient = gradient / groups.breadth
        contact, saturated = _theory(groups, gradient)
        if self.quantity == GAP:
            return gap_below_plane(np.clip(contact, 1e-12, 1 - 1e-12), groups.skewness)
        return saturated if self.quantity == SATURATED else contact

    def missed(self, value: Array, found: Array) -> Array:
        """Return by how much values are too large, in the measure in which scatter is told."""
        return self._measured(value) - self._measured(found)

    def _measured(self, value: Array) -> Array:
        """Return values in the measure in which their scatter is told."""
        if self.quantity in _LOGARITHMIC:
            return np.log(value)
        return np.sqrt(value) if self.quantity == SATURATED else value

    def interval(self, groups: Groups, value: Array) -> tuple[Array, Array]:
        """Return the ends of the interval about a value."""
        spread = _sum(self.design(groups, self.scatter_terms), self.scatter)
        half = self.factor * np.exp(spread)
        middle = self._measured(value)
        low, high = middle - half, middle + half
        if self.quantity in _LOGARITHMIC:
            low, high = np.exp(low), np.exp(high)
        else:
            low = np.maximum(low, 0)
        if self.quantity == SATURATED:
            low, high = low**2, high**2
        # What carries the load at no more than the ceiling, and what can be at it.
        least = groups.pressure * groups.ratio
        if self.quantity == CONTACT:
            return np.clip(low, least, 1), np.clip(high, least, 1)
        return (low, np.minimum(high, least)) if self.quantity == SATURATED else (low, high)


def theory_contact(groups: Groups) -> Array:
    """Return the contact fraction of Persson's theory with the gradient of the surface itself."""
    return _theory(groups, np.ones_like(groups.pressure))[0]


def _theory(groups: Groups, gradient: Array) -> tuple[Array, Array]:
    with np.errstate(divide="ignore"):
        ceiling = 1 / groups.ratio
    return diffused(groups.pressure, gradient / 2, ceiling)


def _plasticity(formula: Formula, groups: Groups) -> Array:
    softening: Array = np.log1p((groups.ratio / formula.knee) ** 2) / 2
    return softening


def _coordinates(formula: Formula, groups: Groups) -> dict[str, Array]:
    """Return the coordinates of polynomials by their letters."""
    from scipy.special import ndtri

    w = _plasticity(formula, groups)
    first = _FIRST[formula.quantity] * np.exp(-w)
    if formula.quantity == GAP and not np.isnan(groups.breadth).any():
        first = first / groups.breadth
    contact, _ = _theory(groups, first)
    return {
        "z": ndtri(np.clip(contact, 1e-9, 1 - 1e-9)) + 1,
        "w": w,
        "b": np.log(groups.breadth / _BREADTH),
        "s": groups.skewness,
        "t": np.log(groups.texture / _TEXTURE),
        "k": np.log1p(groups.hardening),
    }


def _sum(design: Array, coefficients: tuple[float, ...]) -> Array:
    # Without BLAS, whose last digits depend on its threads.
    total: Array = np.sum(design * np.array(coefficients), axis=1)
    return total


# --- what is stored


@dataclass(frozen=True)
class Atlas:
    """The formulas, where they hold, and what they were fitted to.

    Parameters
    ----------
    formulas : dict
        By name: quantities, and those that go without Sal with ``"_without_Sal"`` behind.
    domain : dict
        Least and largest contact fraction, ratio, breadth, texture, skewness and hardening, for
        ``"ceiling"`` and ``"volume"``.
    """

    formulas: dict[str, Formula]
    domain: dict[str, dict[str, tuple[float, float]]]

    def formula(self, quantity: str, with_Sal: bool) -> Formula:
        """Return the formula for a quantity."""
        return self.formulas[quantity if with_Sal else f"{quantity}_without_Sal"]


@lru_cache(maxsize=1)
def stored() -> Atlas:
    """Return the formulas that the package holds."""
    told = json.loads(STORED.read_text(encoding="utf-8"))
    return Atlas(
        {name: _formula(one) for name, one in told["formulas"].items()},
        {
            model: {name: (low, high) for name, (low, high) in ranges.items()}
            for model, ranges in told["domain"].items()
        },
    )


def _formula(told: dict[str, Any]) -> Formula:
    return Formula(
        told["quantity"],
        told["knee"],
        tuple(told["terms"]),
        tuple(told["coefficients"]),
        tuple(told["scatter_terms"]),
        tuple(told["scatter"]),
        told["factor"],
    )
