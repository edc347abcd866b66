"""Comparison of the ceiling model with the elastoplastic model, and the best ceiling.

A pressure ceiling has one parameter, its ratio to the yield strength. Three is right for metals in
full plasticity; before that the plateau of the pressure is lower, and with hardening it rises. The
ratio depends on the load over that of first yield, which follows from the solution with any
ceiling: see `recommended_ceiling`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.arrays import Array
from roughcontact._tools.files import require_suffix, to_json, write_atomically
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.validation import check_problem
from roughcontact.elastoplastic import solve
from roughcontact.elastoplastic.increments import AUTO
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.errors import InputError, input_error
from roughcontact.material.material import CEILING_FACTOR, RIGID, Material
from roughcontact.solvers.progress import Progress, Tell, shows_progress_bar
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, to_si

QUANTITIES = {
    "approach": "m",
    "contact_area": "m²",
    "mean_pressure": "Pa",
    "plateau_pressure": "Pa",
    "max_pressure": "Pa",
}
"""Compared quantities, with units."""

# Change of a relative error that is within the tolerance of the solver.
_NEGLIGIBLE = 1e-5


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """Results of the ceiling model and the elastoplastic model at the same loads.

    Arrays over ceilings and loads have the shape (k, n).

    Parameters
    ----------
    factors : tuple of float
        Ceilings over the yield strength at first yield, k of them, ascending.
    ceiling : tuple of tuple of ContactResult
        For each factor, the solution at each load.
    volume : tuple of ElastoplasticResult
        State of the volume model after each of the n loads, applied in order.
    yield_strength : float
        Yield strength σ_Y of the softer body [Pa], without plastic strain if it hardens.
    """

    factors: tuple[float, ...]
    ceiling: tuple[tuple[ContactResult, ...], ...]
    volume: tuple[ElastoplasticResult, ...]
    yield_strength: float

    @property
    def loads(self) -> Array:
        """Loads W [N], shape (n,)."""
        return np.array([state.solution.load for state in self.volume])

    def column(self, model: str, name: str) -> Array:
        """Return one quantity of one model at all loads.

        Parameters
        ----------
        model : {"ceiling", "elastoplastic"}
            The model.
        name : {"approach", "contact_area", "mean_pressure", "plateau_pressure", "max_pressure"}
            The quantity. Areas are without the excess of an elastic rim. The plateau pressure
            is the mean of the pressure over the load, Σp²/Σp: unlike the largest pressure, it is
            not affected by the scatter of single pixels with perfect plasticity.

        Returns
        -------
        ndarray, shape (k, n) of the ceilings or (n,) of the volume
            Its values [SI].

        Raises
        ------
        InputError
            If there is no such model or quantity.
        """
        if model not in ("ceiling", "elastoplastic"):
            raise input_error("model", model, "must be 'ceiling' or 'elastoplastic'")
        if name not in QUANTITIES:
            raise input_error("name", name, f"must be one of {', '.join(QUANTITIES)}")
        if model == "elastoplastic":
            return np.array([_value(state.solution, state, name) for state in self.volume])
        return np.array([[_value(result, result, name) for result in row] for row in self.ceiling])

    def excess(self, name: str) -> Array:
        """Return the relative error of the ceiling model: its ratio to the volume model - 1.

        Parameters
        ----------
        name : str
            As for `column`.

        Returns
        -------
        ndarray, shape (k, n)
            Relative error of the ceiling model.
        """
        ratio: Array = self.column("ceiling", name) / self.column("elastoplastic", name)
        return ratio - 1

    def map_error(self) -> Array:
        """Return the relative difference between the pressure maps of the models.

        Returns
        -------
        ndarray, shape (k, n)
            Σ abs(p - q)/Σp with the pressure p of the ceiling model and q of the volume model,
            which carry the same load; 0 to 2. With perfect plasticity the scatter of the pixels of
            q contributes about 0.05 to 0.1.
        """
        return np.array(
            [
                [
                    np.abs(result.pressure - state.solution.pressure).sum() / result.pressure.sum()
                    for result, state in zip(row, self.volume, strict=True)
                ]
                for row in self.ceiling
            ]
        )

    def best_factor(self, name: str) -> Array:
        """Return the ceiling factor that reproduces the value of the volume model.

        Parameters
        ----------
        name : str
            As for `column`.

        Returns
        -------
        ndarray, shape (n,)
            Between two factors whose errors differ in sign, by linear interpolation; else the
            factor with the smallest error. NaN where no factor makes a difference.
        """
        factors, error = np.array(self.factors), self.excess(name)
        best = []
        for row in error.T:
            change = np.flatnonzero(row[:-1] * row[1:] < 0)
            if len(row) > 1 and np.ptp(row) < _NEGLIGIBLE:
                best.append(math.nan)
            elif change.size:
                # First sign change: errors may be near zero at ceilings that are hardly reached.
                i = change[0]
                share = row[i] / (row[i] - row[i + 1])
                best.append(factors[i] + share * (factors[i + 1] - factors[i]))
            else:
                best.append(factors[np.argmin(np.abs(row))])
        return np.array(best)

    @property
    def mean_pressure_ratio(self) -> Array:
        """Mean pressure of the volume model over the yield strength, shape (n,).

        Factor of the ceiling that would carry the load on the same area if all of the area were
        saturated.
        """
        return self.column("elastoplastic", "mean_pressure") / self.yield_strength

    def summary(self) -> dict[str, Any]:
        """Return the quantities of both models by name, in SI units, as JSON values."""
        return {
            "load": self.loads.tolist(),
            "yield_strength": self.yield_strength,
            "factors": list(self.factors),
            "mean_pressure_ratio": self.mean_pressure_ratio.tolist(),
            **{
                f"{model}_{name}": self.column(model, name).tolist()
                for name in QUANTITIES
                for model in ("ceiling", "elastoplastic")
            },
            **{f"{name}_excess": self.excess(name).tolist() for name in QUANTITIES},
            "pressure_map_error": self.map_error().tolist(),
            "step_error": [state.step_error for state in self.volume],
            "max_plastic_strain": [state.max_plastic_strain for state in self.volume],
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the comparison to a JSON file.

        Parameters
        ----------
        path : str or path
            File name that ends in ``.json``.

        Raises
        ------
        InputError
            If the name has another ending.
        """
        require_suffix(path, ".json")
        write_atomically(path, to_json(self.summary()) + "\n")


def _value(result: ContactResult, area_of: ContactResult | ElastoplasticResult, name: str) -> float:
    if name == "contact_area":
        return area_of.perimeter_corrected_area
    if name == "mean_pressure":
        return result.load / area_of.perimeter_corrected_area
    if name == "plateau_pressure":
        return float((result.pressure**2).sum() / result.pressure.sum())
    return float(getattr(result, name))


@shows_progress_bar
@validate_arguments
def compare_models(
    surface: Surface,
    *,
    material: Material,
    loads: Quantities,
    factors: Sequence[float] = (CEILING_FACTOR,),
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    boundary: str = "free",
    increments: int | str = AUTO,
    progress: Tell = None,
) -> ModelComparison:
    """Solve the same loads with several ceilings and with the elastoplastic model.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, boundary
        As for `solve`; at least one body has a yield strength.
    loads : sequence of float, str or quantity of pint
        Normal loads [N], ascending. The volume model applies them in order.
    factors : sequence of float
        Ceilings over the yield strength of the softer body, ascending.
    increments : int or "auto"
        Steps of the volume model to each load, as for `solve_elastoplastic`.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is called with the `Progress` of the
        volume model.

    Returns
    -------
    ModelComparison
        Both models at each load.

    Raises
    ------
    InputError
        If no body yields, or the loads or factors do not ascend.
    CapacityError
        If the lowest ceiling cannot carry the largest load.
    ConvergenceError
        If a solve did not reach its tolerance.

    Notes
    -----
    The volume model is solved by `solve_elastoplastic`, which takes minutes on large maps.
    If the contact yields below its surface but is far from full plasticity, the ceiling of three
    yield strengths is too high: by a quarter to a third in the mean pressure of a sphere at 10 to
    100 times the load of its first yield. `recommended_ceiling` returns a better ceiling without
    the volume model.
    """
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    pair.require_map("plasticity of the volume", coated=False)
    body = pair.softer
    if body is None or body.yield_strength is None:
        raise InputError("no body has a yield strength: there is no plasticity to compare")
    specified = _check_ascending("loads", to_si(loads, "force", "loads"))
    tried = _check_ascending("factors", factors)
    strength = body.yield_strength
    check_problem(pair, LoadCase(load=specified[-1], ceiling=tried[0] * strength))
    states = _solve_volume(pair, specified, increments, progress)
    rows = tuple(_solve_ceiling(pair, specified, factor * strength) for factor in tried)
    return ModelComparison(tuple(tried), rows, states, strength)


def _solve_volume(
    pair: Pair, loads: list[float], increments: int | str, progress: Tell
) -> tuple[ElastoplasticResult, ...]:
    """Return the state of the volume model after each load."""
    states: list[ElastoplasticResult] = []
    for number, load in enumerate(loads, start=1):

        def report_progress(state: Progress, number: int = number) -> None:
            if callable(progress):
                progress(replace(state, number=number, count=len(loads)))

        states.append(
            solve.solve_elastoplastic(
                pair.surface,
                material=pair.material,
                counter_surface=pair.counter_surface,
                counter_material=pair.counter_material,
                boundary=pair.boundary,
                loads=[load],
                increments=increments,
                start=states[-1] if states else None,
                progress=report_progress,
            )
        )
    return tuple(states)


def _solve_ceiling(pair: Pair, loads: list[float], ceiling: float) -> tuple[ContactResult, ...]:
    """Return the solution at each load under one ceiling."""
    row: list[ContactResult] = []
    for load in loads:
        terms = LoadCase(load=load, ceiling=ceiling)
        row.append(solve_pair(pair, terms, start=row[-1] if row else None))
    return tuple(row)


def _check_ascending(name: str, values: Sequence[float]) -> list[float]:
    try:
        specified = np.array(values, float)
    except (TypeError, ValueError):
        raise input_error(name, values, "must be a row of numbers") from None
    steps = np.diff(specified, prepend=0.0) if specified.ndim == 1 else specified
    if (
        specified.ndim != 1
        or not specified.size
        or not ((steps > 0) & np.isfinite(specified)).all()
    ):
        raise input_error(name, values, "must be positive and ascend")
    return [float(value) for value in specified]
