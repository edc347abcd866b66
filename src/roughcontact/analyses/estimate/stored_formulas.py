"""Formulas fitted to solved contacts, and their atlas."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.theory.height_distribution import gap_below_plane
from roughcontact.theory.persson import diffuse_fractions

STORED = Path(__file__).with_name("atlas.json")

CONTACT, SATURATED, GAP, VOLUME = "contact", "saturated", "gap", "volume"
"""Quantities with a formula."""

LEVEL = 0.90
"""Share of maps that fall into the interval of a formula."""

# Center of the fitted set: origin of the polynomials.
_BREADTH, _TEXTURE = 3.0, 0.9
# Initial effective gradients for the coordinates, over h′; for the gap over Sq/Sal.
_FIRST = {CONTACT: 0.7, SATURATED: 0.7, GAP: 1.2, VOLUME: 0.7}
_LOGARITHMIC = (CONTACT, VOLUME)
# Contact fraction below which the effective gradient is constant in the coordinates, so that the
# area of light contacts is proportional to the load.
_LIGHT = 0.004
_STEEPEST = 20.0
# Peak pressure of a sphere at first yield over three yield strengths, at ν = 0.3.
_FIRST_YIELD = 1.295 * math.exp(0.736 * 0.3) / 3


@dataclass(frozen=True)
class DimensionlessGroups:
    """Dimensionless groups of nominally flat contacts; arrays of one shape (n,)."""

    pressure: Array  # p̄/(E* h′), h′ the root-mean-square gradient Sdq
    ratio: Array  # E* h′ over the pressure ceiling, of the volume model over three yield strengths
    breadth: Array  # Sdq Sal/Sq: breadth of the spectrum
    texture: Array  # Str
    skewness: Array  # Ssk
    kurtosis: Array  # Sku
    hardening: Array  # H h′/σ_Y, H the hardening modulus

    @property
    def tails(self) -> Array:
        """Sku over the kurtosis of a gamma distribution, 3 + 1.5 Ssk²."""
        return self.kurtosis / (3 + 1.5 * self.skewness**2)

    def values(self) -> dict[str, Array]:
        """Return the quantities that a domain bounds: all groups, and derived quantities."""
        return vars(self) | {
            "contact": theory_contact(self),
            "tails": self.tails,
            "middle": self.kurtosis - self.skewness**2 - 1,
        }

    def select(self, chosen: Any) -> DimensionlessGroups:
        """Return a subset of the contacts."""
        return DimensionlessGroups(**{name: values[chosen] for name, values in vars(self).items()})


@dataclass(frozen=True)
class Formula:
    """Fitted formula of one quantity."""

    quantity: str  # A/A₀, saturated area/A₀, mean gap/Sq, or plastic volume h′/(Sq A₀)
    knee: float  # `ratio` beyond which the effective gradient decreases
    terms: tuple[str, ...]
    coefficients: tuple[float, ...]  # Coefficients of the terms
    scatter_terms: tuple[str, ...] = ("",)
    scatter: tuple[float, ...] = (0.0,)
    factor: float = 1.96  # Half-width of the interval of `LEVEL` over the fitted scatter

    def design(self, groups: DimensionlessGroups) -> Array:
        """Return the terms, shape (n, number of terms)."""
        return _products(self.terms, self._coordinates(groups))

    def value(self, groups: DimensionlessGroups, design: Array | None = None) -> Array:
        """Return the quantity, shape (n,); ``design`` is computed if it is not given."""
        design = self.design(groups) if design is None else design
        fitted = _sum(design, self.coefficients)
        if self.quantity == VOLUME:
            return np.exp(fitted) * _yielded_fraction(groups, self._start(groups))
        gradient = np.exp(np.minimum(fitted - self._gradient_decrease(groups), math.log(_STEEPEST)))
        if self.quantity == GAP and not np.isnan(groups.breadth).any():
            gradient = gradient / groups.breadth
        contact, saturated = _theory(groups, gradient)
        if self.quantity == GAP:
            share = np.clip(contact, 1e-12, 1 - 1e-12)
            return gap_below_plane(share, groups.skewness, groups.kurtosis)
        return saturated if self.quantity == SATURATED else contact

    def overestimate(self, value: Array, result: Array) -> Array:
        """Return the excess of one value over another, on the scale of their scatter."""
        return self._to_scatter_scale(value) - self._to_scatter_scale(result)

    def _to_scatter_scale(self, value: Array) -> Array:
        """Return values on the scale of their scatter: logarithm, square root or identity."""
        if self.quantity in _LOGARITHMIC:
            return np.log(value)
        return np.sqrt(value) if self.quantity == SATURATED else value

    def with_interval(
        self, groups: DimensionlessGroups, wider: float = 1.0
    ) -> tuple[Array, Array, Array]:
        """Return the quantity and the ends of its widened interval, each of shape (n,)."""
        coordinates = self._coordinates(groups)
        value = self.value(groups, _products(self.terms, coordinates))
        spread = _sum(_products(self.scatter_terms, coordinates), self.scatter)
        return (value, *self._interval(groups, value, wider * self.factor * np.exp(spread)))

    def spread_design(self, groups: DimensionlessGroups) -> Array:
        """Return the terms of the scatter, shape (n, number of terms)."""
        return _products(self.scatter_terms, self._coordinates(groups))

    def _interval(
        self, groups: DimensionlessGroups, value: Array, half: Array
    ) -> tuple[Array, Array]:
        """Return the ends of the interval about a value."""
        middle = self._to_scatter_scale(value)
        low, high = middle - half, middle + half
        if self.quantity in _LOGARITHMIC:
            low, high = np.exp(low), np.exp(high)
        else:
            low = np.maximum(low, 0)
        if self.quantity == SATURATED:
            low, high = low**2, high**2
        # Area that carries the load at the ceiling: least contact area, largest saturated area.
        minimum = groups.pressure * groups.ratio
        if self.quantity == CONTACT:
            return np.clip(low, minimum, 1), np.clip(high, minimum, 1)
        return (low, np.minimum(high, minimum)) if self.quantity == SATURATED else (low, high)

    def _gradient_decrease(self, groups: DimensionlessGroups) -> Array:
        """Return the initial decrease of ln(h_eff/h′) by plasticity."""
        return np.log1p((groups.ratio / self.knee) ** 2) / 2

    def _start(self, groups: DimensionlessGroups) -> Array:
        """Return the initial effective gradient over h′, for the coordinates."""
        first: Array = _FIRST[self.quantity] * np.exp(-self._gradient_decrease(groups))
        if self.quantity == GAP and not np.isnan(groups.breadth).any():
            first = first / groups.breadth
        return first

    def _coordinates(self, groups: DimensionlessGroups) -> dict[str, Array]:
        """Return the coordinates of the polynomials by letter."""
        from scipy.special import ndtri

        first = self._start(groups)
        contact = np.clip(_theory(groups, first)[0], _LIGHT, 1 - 1e-9)
        result = {
            "z": ndtri(contact) + 1,
            "w": self._gradient_decrease(groups),
            "b": np.log(groups.breadth / _BREADTH),
            "s": groups.skewness,
            "q": np.log(groups.tails),
            "t": np.log(groups.texture / _TEXTURE),
            "k": np.log1p(groups.hardening),
        }
        if self.quantity == VOLUME:
            result["y"] = np.log(_yielded_fraction(groups, first) / contact)
        return result


def theory_contact(groups: DimensionlessGroups) -> Array:
    """Return the contact fraction of Persson's theory with the gradient of the surface."""
    return _theory(groups, np.ones_like(groups.pressure))[0]


def _theory(groups: DimensionlessGroups, gradient: Array) -> tuple[Array, Array]:
    with np.errstate(divide="ignore"):
        ceiling = 1 / groups.ratio
    return diffuse_fractions(groups.pressure, gradient / 2, ceiling)


def _yielded_fraction(groups: DimensionlessGroups, gradient: Array) -> Array:
    """Return the area fraction above first yield by Persson's theory."""
    with np.errstate(divide="ignore"):
        bound = _FIRST_YIELD / groups.ratio
    # A mean pressure above the bound exceeds first yield everywhere.
    pressure = np.minimum(groups.pressure, bound)
    return np.maximum(diffuse_fractions(pressure, gradient / 2, bound)[1], 1e-12)


def _products(terms: tuple[str, ...], coordinates: dict[str, Array]) -> Array:
    """Return the products of coordinates, one column per term."""
    columns = np.ones((len(terms), coordinates["z"].size))
    for column, term in zip(columns, terms, strict=True):
        for letter in term:
            column *= coordinates[letter]
    return columns.T


def _sum(design: Array, coefficients: tuple[float, ...]) -> Array:
    # Not by BLAS, whose last digits depend on the number of threads.
    return np.sum(design * np.array(coefficients), axis=1)


@dataclass(frozen=True)
class Atlas:
    """Formulas, their domains, and the interval factor of measured maps."""

    formulas: dict[str, Formula]
    domain: dict[str, dict[str, tuple[float, float]]]
    measured: float  # Factor by which an interval is wider that holds `LEVEL` of measured maps

    def formula(self, quantity: str, with_Sal: bool) -> Formula:
        """Return the formula for a quantity."""
        known = self.formulas[quantity]
        return known if with_Sal else self.formulas.get(f"{quantity}_without_Sal", known)


@lru_cache(maxsize=1)
def load_atlas() -> Atlas:
    """Return the formulas of the package."""
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    return Atlas(
        {name: _formula(item) for name, item in stored["formulas"].items()},
        {
            model: {name: (low, high) for name, (low, high) in ranges.items()}
            for model, ranges in stored["domain"].items()
        },
        stored["measured"],
    )


def _formula(text: dict[str, Any]) -> Formula:
    return Formula(
        text["quantity"],
        text["knee"],
        tuple(text["terms"]),
        tuple(text["coefficients"]),
        tuple(text["scatter_terms"]),
        tuple(text["scatter"]),
        text["factor"],
    )
