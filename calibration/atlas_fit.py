"""The formulas fitted to the cases of the atlas, and tested on maps that took no part.

`atlas.py` runs it. A fit is least squares with a loss that lets single cases lie far off; scatter
is estimated by fits in turn to all but a fifth of the maps, so that it is that of maps which a fit
has not seen. The maps named ``held`` take part in neither.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from roughcontact.analyses.estimate.stored_formulas import (
    CONTACT,
    GAP,
    SATURATED,
    VOLUME,
    DimensionlessGroups,
    Formula,
)

Array = NDArray[np.float64]

_LINEAR = ("", "z", "s", "w")
_CURVED = ("zz", "zs", "ss", "t", "tz", "wz", "ws", "ww", "zss", "zzs", "ts", "tt", "wss", "tw")
_TAILS = ("q", "zq", "wq", "sq", "qq", "zzq", "zqq")
_BROAD = ("b", "zb", "bb", "wb", "sb")
_SCATTER = {
    CONTACT: ("", "z", "zz", "ss", "w", "ww", "zw", "q", "qq"),
    SATURATED: ("", "z", "zz", "ss", "w", "ww", "zw", "q", "qq"),
    GAP: ("", "z", "zz", "ss", "w", "q", "qq"),
    VOLUME: ("", "z", "y", "ss"),
}
KNEES = {CONTACT: 4 / 3, SATURATED: 4 / 3, GAP: 10 / 3, VOLUME: 4 / 3}
TERMS = {
    CONTACT: (*_LINEAR, *_CURVED, *_TAILS, *_BROAD),
    SATURATED: (*_LINEAR, *_CURVED, *_TAILS, *_BROAD),
    GAP: (*_LINEAR, "zzz", *_CURVED, *_TAILS, *_BROAD),
    VOLUME: ("", "z", "w", "ww", "s", "k", "y", "yy", "zz", "wz", "kw", "sz"),
}
# Residuals beyond this, in the measure of the formula, are treated as linear ones.
_LOSS = {CONTACT: 0.03, SATURATED: 0.01, GAP: 0.03, VOLUME: 0.05}
_PARTS = 5
# Plasticity index from which the plastic volume is given.
_MIN_INDEX = 3.0
# Share of the cases that the width of the intervals is taken from: more than `LEVEL`, as the cases
# of a map are correlated, and some tens of maps determine the share to a few percent only.
_CAUTIOUS = 0.95
# Residual that rounding alone may leave.
_FLOOR = 1e-4


@dataclass(frozen=True)
class Cases:
    """Cases of one model.

    Parameters
    ----------
    maps : ndarray of str, shape (n,)
        The map of each.
    groups : Groups
        Inputs of the formulas.
    found : dict
        Computed values, by quantity.
    table : dict
        All columns.
    """

    maps: NDArray[np.str_]
    groups: DimensionlessGroups
    found: dict[str, Array]
    table: dict[str, Array]

    def select(self, chosen: Any) -> Cases:
        return Cases(
            self.maps[chosen],
            self.groups.select(chosen),
            {name: values[chosen] for name, values in self.found.items()},
            {name: values[chosen] for name, values in self.table.items()},
        )

    @property
    def is_held_out(self) -> NDArray[np.bool_]:
        """Those of maps that take no part."""
        return np.char.find(self.maps, "held") >= 0


def read(place: Path) -> Cases:
    """Return the cases of a table."""
    with place.open(newline="") as lines:
        rows = [row for row in csv.DictReader(lines) if None not in row.values()]
    # Below first yield there is no plastic volume, and close to it hardly one that grids resolve.
    rows = [row for row in rows if "volume" not in row or float(row["index"]) >= _MIN_INDEX]
    rows = [row for row in rows if float(row.get("volume", 1)) > 0]
    table = {
        name: np.array([float(row[name]) for row in rows]) for name in rows[0] if name != "map"
    }
    volume = "volume" in table
    index = table["index"]
    groups = DimensionlessGroups(
        pressure=table["pressure"],
        ratio=index / 3,
        breadth=table["breadth"],
        texture=table["Str"],
        skewness=table["Ssk"],
        kurtosis=table["Sku"],
        hardening=table["hardening"] * (1 - 0.3**2) * index if volume else np.zeros_like(index),
    )
    if volume:
        found = {VOLUME: table["volume"] * table["gradient"] / table["height"]}
    else:
        # Share that carries the load at the ceiling at most, and share that can be at it.
        bound = groups.pressure * groups.ratio
        found = {
            CONTACT: np.maximum(extrapolate(table, "contact"), bound),
            SATURATED: np.minimum(extrapolate(table, "saturated"), bound),
            GAP: table["gap"] / table["height"],
        }
    return Cases(np.array([row["map"] for row in rows]), groups, found, table)


def extrapolate(table: dict[str, Array], name: str) -> Array:
    """Return the limit of a vanishing pixel: errors are proportional to the pixel."""
    fine, coarse = table[name], table[f"{name}_coarse"]
    return np.where(fine > 0, np.maximum(2 * fine - coarse, fine / 2), 0.0)


def fit_quantity(quantity: str, cases: Cases, with_Sal: bool = True) -> Formula:
    """Return the formula for a quantity, with its scatter."""
    terms = tuple(term for term in TERMS[quantity] if with_Sal or "b" not in term)
    groups = cases.groups
    if not with_Sal:
        groups = replace(groups, breadth=np.full_like(groups.pressure, np.nan))
    usable = np.isfinite(formulas_design(quantity, terms, groups)).all(axis=1)
    groups, found = groups.select(usable), cases.found[quantity][usable]
    maps = cases.maps[usable]
    whole = solve_least_squares(quantity, terms, groups, found)
    missed = np.empty_like(found)
    for train, test in parts(maps):
        one = solve_least_squares(quantity, terms, groups.select(train), found[train])
        part = groups.select(test)
        missed[test] = one.overestimate(one.value(part), found[test])
    return add_scatter(whole, groups, missed)


def formulas_design(quantity: str, terms: tuple[str, ...], groups: DimensionlessGroups) -> Array:
    return Formula(quantity, KNEES[quantity], terms, ()).design(groups)


def solve_least_squares(
    quantity: str, terms: tuple[str, ...], groups: DimensionlessGroups, found: Array
) -> Formula:
    """Return a formula by least squares."""
    start = Formula(quantity, KNEES[quantity], terms, (0.0,) * len(terms))
    design = start.design(groups)

    def residuals(coefficients: Array) -> Array:
        one = replace(start, coefficients=tuple(coefficients))
        value = np.maximum(one.value(groups, design), 1e-9)
        return one.overestimate(value, found)

    begin = np.zeros(len(terms))
    begin[0] = {GAP: 0.2, VOLUME: 0.0}.get(quantity, np.log(0.7))
    best = least_squares(residuals, begin, loss="soft_l1", f_scale=_LOSS[quantity])
    return replace(start, coefficients=tuple(float(f"{value:.5g}") for value in best.x))


def parts(maps: NDArray[np.str_]) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """Yield which cases to fit and which to test, all of a map on one side."""
    names, number = np.unique(maps, return_inverse=True)
    turn = np.random.default_rng(1).permutation(names.size) % _PARTS
    for part in range(_PARTS):
        test = turn[number] == part
        yield ~test, test


def add_scatter(formula: Formula, groups: DimensionlessGroups, missed: Array) -> Formula:
    """Return a formula with the scatter of what it missed on maps that it had not seen."""
    formula = replace(formula, scatter_terms=_SCATTER[formula.quantity])
    # Where nothing or all is saturated the theory is exact, and says nothing of the rest.
    off = np.abs(missed) > _FLOOR
    missed, design = missed[off], formula.spread_design(groups)[off]
    # The mean of ln |x| of a normal variable is -0.635.
    logarithm = np.log(np.abs(missed)) + 0.635
    coefficients = np.linalg.lstsq(design, logarithm, rcond=None)[0]
    share = np.abs(missed) / np.exp(np.sum(design * coefficients, axis=1))
    return replace(
        formula,
        scatter=tuple(float(f"{value:.4g}") for value in coefficients),
        factor=float(f"{np.quantile(share, _CAUTIOUS):.4g}"),
    )


NAMED = {CONTACT: "ceiling", SATURATED: "ceiling", GAP: "ceiling", VOLUME: "volume"}


def domain_of(cases: Cases) -> dict[str, tuple[float, float]]:
    """Return where there are cases, in the groups that formulas know."""
    groups = cases.groups
    values = groups.values()
    names = ["contact", "ratio", "breadth", "texture", "skewness", "tails", "middle"]
    if "hardening" in cases.table:
        names.append("hardening")
    found = {}
    for name in names:
        usual = values[name][np.isfinite(values[name])]
        found[name] = (float(f"{usual.min():.3g}"), float(f"{usual.max():.3g}"))
    # Gaussian maps of one kind of wave are as much alike in all directions as maps get.
    return found | {"texture": (found["texture"][0], 1.0)}


def drop_correlation_length(cases: Cases) -> Cases:
    """Return cases of surfaces of which Sal is not known."""
    groups = replace(cases.groups, breadth=np.full_like(cases.groups.pressure, np.nan))
    return replace(cases, groups=groups)


def interval_factor(fitted: dict[str, Formula], cases: Cases) -> float:
    """Return by how much the intervals have to be wider to hold measured cases."""
    shares = []
    for quantity, found in cases.found.items():
        formula, groups = fitted[quantity], cases.groups
        missed = np.abs(formula.overestimate(formula.value(groups), found))
        spread = np.sum(formula.spread_design(groups) * np.array(formula.scatter), axis=1)
        off = missed > _FLOOR
        shares.append((missed / (formula.factor * np.exp(spread)))[off])
    return float(f"{max(np.quantile(share, _CAUTIOUS) for share in shares):.2g}")


def evaluate_formula(formula: Formula, cases: Cases, wider: float = 1.0) -> dict[str, float]:
    """Return how far a formula is off on cases, and how many its interval holds."""
    groups = cases.groups
    found = cases.found[formula.quantity]
    value, low, high = formula.with_interval(groups, wider)
    relative = formula.quantity in (CONTACT, VOLUME)
    scale = found if relative else 1.0
    missed = np.abs(value - found) / scale
    return {
        "cases": found.size,
        "median": float(np.median(missed)),
        "nine_in_ten": float(np.quantile(missed, 0.9)),
        "covered": float(np.mean((found >= low) & (found <= high))),
        "half_width": float(np.median((high - low) / 2 / scale)),
    }
