"""Fitted formulas of nominally flat contact: theory with an effective gradient, on arrays.

Contact and saturated area are those of Persson's theory for a gradient h_eff in place of h′, and
the mean gap that of a plane which cuts off as much of the heights as the theory lets touch for an
effective gradient of the long waves; what is fitted is ln(h_eff/h′), a polynomial in a few groups
without unit. The plastic volume is the area on which the theory finds the pressure of first yield
exceeded, times a fitted depth. Coefficients, their scatter and domain stand in ``atlas.json``
beside this module, which ``benchmarks/atlas.py`` writes.
"""

from __future__ import annotations

import json
import math
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

LEVEL = 0.90
"""Share of maps that fall into the interval of a formula."""

# Middle of the set, from which polynomials count.
_BREADTH, _TEXTURE = 3.0, 0.9
# Gradients from which coordinates are told, over h′; for the gap over Sq/Sal.
_FIRST = {CONTACT: 0.7, SATURATED: 0.7, GAP: 1.2, VOLUME: 0.7}
_LOGARITHMIC = (CONTACT, VOLUME)
_STEEPEST = 20.0
# Peak pressure of a sphere at first yield over three yield strengths, at ν = 0.3.
_FIRST_YIELD = 1.295 * math.exp(0.736 * 0.3) / 3


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
    texture, skewness, kurtosis : ndarray
        Str, Ssk and Sku.
    hardening : ndarray
        H h′/σ_Y, H the hardening modulus.
    """

    pressure: Array
    ratio: Array
    breadth: Array
    texture: Array
    skewness: Array
    kurtosis: Array
    hardening: Array

    @property
    def tails(self) -> Array:
        """Sku over that of a gamma distribution, 3 + 1.5 Ssk²."""
        return self.kurtosis / (3 + 1.5 * self.skewness**2)

    def told(self) -> dict[str, Array]:
        """Return what a domain bounds: all groups, and what follows from them.

        ``middle``, Sku - Ssk² - 1, is 0 of two heights alone.
        """
        return vars(self) | {
            "contact": theory_contact(self),
            "tails": self.tails,
            "middle": self.kurtosis - self.skewness**2 - 1,
        }

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
        contact area; w, plasticity; b, breadth; s, skewness; q, kurtosis; t, texture; k,
        hardening; y, the share of the contact beyond first yield. An empty text is the constant.
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

    def design(self, groups: Groups) -> Array:
        """Return the terms, shape (n, number of terms)."""
        return _products(self.terms, self._coordinates(groups))

    def value(self, groups: Groups, design: Array | None = None) -> Array:
        """Return the quantity, shape (n,); ``design`` where it is known."""
        design = self.design(groups) if design is None else design
        fitted = _sum(design, self.coefficients)
        if self.quantity == VOLUME:
            volume: Array = np.exp(fitted) * _yielded(groups, self._start(groups))
            return volume
        gradient = np.exp(np.minimum(fitted - self._softening(groups), math.log(_STEEPEST)))
        if self.quantity == GAP and not np.isnan(groups.breadth).any():
            gradient = gradient / groups.breadth
        contact, saturated = _theory(groups, gradient)
        if self.quantity == GAP:
            share = np.clip(contact, 1e-12, 1 - 1e-12)
            return gap_below_plane(share, groups.skewness, groups.kurtosis)
        return saturated if self.quantity == SATURATED else contact

    def missed(self, value: Array, found: Array) -> Array:
        """Return by how much values are too large, in the measure in which scatter is told."""
        return self._measured(value) - self._measured(found)

    def _measured(self, value: Array) -> Array:
        """Return values in the measure in which their scatter is told."""
        if self.quantity in _LOGARITHMIC:
            return np.log(value)
        return np.sqrt(value) if self.quantity == SATURATED else value

    def ranged(self, groups: Groups, wider: float = 1.0) -> tuple[Array, Array, Array]:
        """Return the quantity and the ends of its interval, so much wider, each of shape (n,)."""
        coordinates = self._coordinates(groups)
        value = self.value(groups, _products(self.terms, coordinates))
        spread = _sum(_products(self.scatter_terms, coordinates), self.scatter)
        half = wider * self.factor * np.exp(spread)
        return (value, *self._interval(groups, value, half))

    def spread_design(self, groups: Groups) -> Array:
        """Return the terms of the scatter, shape (n, number of them)."""
        return _products(self.scatter_terms, self._coordinates(groups))

    def _interval(self, groups: Groups, value: Array, half: Array) -> tuple[Array, Array]:
        """Return the ends of the interval about a value."""
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

    def _softening(self, groups: Groups) -> Array:
        """Return by how much plasticity lowers ln(h_eff/h′), to begin with."""
        softening: Array = np.log1p((groups.ratio / self.knee) ** 2) / 2
        return softening

    def _start(self, groups: Groups) -> Array:
        """Return the effective gradient over h′ from which coordinates are told."""
        first: Array = _FIRST[self.quantity] * np.exp(-self._softening(groups))
        if self.quantity == GAP and not np.isnan(groups.breadth).any():
            first = first / groups.breadth
        return first

    def _coordinates(self, groups: Groups) -> dict[str, Array]:
        """Return the coordinates of polynomials by their letters."""
        from scipy.special import ndtri

        first = self._start(groups)
        contact = np.clip(_theory(groups, first)[0], 1e-9, 1 - 1e-9)
        found = {
            "z": ndtri(contact) + 1,
            "w": self._softening(groups),
            "b": np.log(groups.breadth / _BREADTH),
            "s": groups.skewness,
            "q": np.log(groups.tails),
            "t": np.log(groups.texture / _TEXTURE),
            "k": np.log1p(groups.hardening),
        }
        if self.quantity == VOLUME:
            found["y"] = np.log(_yielded(groups, first) / contact)
        return found


def theory_contact(groups: Groups) -> Array:
    """Return the contact fraction of Persson's theory with the gradient of the surface itself."""
    return _theory(groups, np.ones_like(groups.pressure))[0]


def _theory(groups: Groups, gradient: Array) -> tuple[Array, Array]:
    with np.errstate(divide="ignore"):
        ceiling = 1 / groups.ratio
    return diffused(groups.pressure, gradient / 2, ceiling)


def _yielded(groups: Groups, gradient: Array) -> Array:
    """Return the fraction of the nominal area on which the theory finds first yield exceeded."""
    with np.errstate(divide="ignore"):
        bound = _FIRST_YIELD / groups.ratio
    # More than that pressure on average is it everywhere.
    pressure = np.minimum(groups.pressure, bound)
    return np.maximum(diffused(pressure, gradient / 2, bound)[1], 1e-12)


def _products(terms: tuple[str, ...], coordinates: dict[str, Array]) -> Array:
    """Return products of coordinates, a column each."""
    columns = np.ones((len(terms), coordinates["z"].size))
    for column, term in zip(columns, terms, strict=True):
        for letter in term:
            column *= coordinates[letter]
    return columns.T


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
        By name: quantities, and those that go without Sal with ``"_without_Sal"`` behind, where
        Sal matters.
    domain : dict
        Least and largest contact fraction, ratio, breadth, texture, skewness and hardening, for
        ``"ceiling"`` and ``"volume"``.
    measured : float
        How much wider an interval is that holds `LEVEL` of measured maps.
    """

    formulas: dict[str, Formula]
    domain: dict[str, dict[str, tuple[float, float]]]
    measured: float

    def formula(self, quantity: str, with_Sal: bool) -> Formula:
        """Return the formula for a quantity."""
        known = self.formulas[quantity]
        return known if with_Sal else self.formulas.get(f"{quantity}_without_Sal", known)


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
        told["measured"],
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
