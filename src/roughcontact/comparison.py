"""The ceiling beside plasticity of the volume: the same contact by both models."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import contact, elastoplastic, export
from roughcontact.archive import replacing
from roughcontact.elastoplastic import ElastoplasticResult, Progress
from roughcontact.errors import ConvergenceError, InputError
from roughcontact.material import RIGID, Material, softer
from roughcontact.result import ContactResult
from roughcontact.surface import Surface

Array = NDArray[np.float64]

QUANTITIES = {"approach": "m", "contact_area": "m²", "mean_pressure": "Pa", "max_pressure": "Pa"}
"""What is compared, with units."""


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """The same loads by the ceiling and by plasticity of the volume.

    Parameters
    ----------
    ceiling : tuple of ContactResult
        Solution with the ceiling at each load.
    volume : tuple of ElastoplasticResult
        State of the volume model after each load, the loads following each other.
    yield_strength : float
        σ_Y of the softer body [Pa].
    """

    ceiling: tuple[ContactResult, ...]
    volume: tuple[ElastoplasticResult, ...]
    yield_strength: float

    @property
    def loads(self) -> Array:
        """Loads W [N], shape (n,)."""
        return np.array([result.load for result in self.ceiling])

    def column(self, model: str, name: str) -> Array:
        """Return one quantity of one model at all loads.

        Parameters
        ----------
        model : {"ceiling", "volume"}
            The model.
        name : {"approach", "contact_area", "mean_pressure", "max_pressure"}
            The quantity, areas without the excess of their rim.

        Returns
        -------
        ndarray, shape (n,)
            Its values [SI].

        Raises
        ------
        InputError
            If there is no such model or quantity.
        """
        if model not in ("ceiling", "volume"):
            raise InputError(f"model must be 'ceiling' or 'volume', got {model!r}")
        if name not in QUANTITIES:
            raise InputError(f"name must be one of {', '.join(QUANTITIES)}, got {name!r}")
        found = self.ceiling if model == "ceiling" else [state.contact for state in self.volume]
        areas = np.array([result.corrected_contact_area for result in found])
        if name == "contact_area":
            return areas
        if name == "mean_pressure":
            means: Array = self.loads / areas
            return means
        return np.array([getattr(result, name) for result in found])

    def excess(self, name: str) -> Array:
        """Return what the ceiling gives too much of a quantity, over what the volume gives."""
        ratio: Array = self.column("ceiling", name) / self.column("volume", name)
        return ratio - 1

    @property
    def factor(self) -> Array:
        """Mean pressure of the volume model over the yield strength, shape (n,).

        The factor that a ceiling would need to carry the load on the same area if all of it
        were saturated.
        """
        return self.column("volume", "mean_pressure") / self.yield_strength

    def summary(self) -> dict[str, Any]:
        """Return both models by name, in SI units, ready for JSON."""
        return {
            "load": self.loads.tolist(),
            "yield_strength": self.yield_strength,
            "factor": self.factor.tolist(),
            **{
                f"{model}_{name}": self.column(model, name).tolist()
                for name in QUANTITIES
                for model in ("ceiling", "volume")
            },
            **{f"{name}_excess": self.excess(name).tolist() for name in QUANTITIES},
            "max_plastic_strain": [state.max_plastic_strain for state in self.volume],
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the comparison to a JSON file.

        Parameters
        ----------
        path : str or path
            A name that ends in ``.json``.

        Raises
        ------
        InputError
            If it ends otherwise.
        """
        if Path(path).suffix.lower() != ".json":
            raise InputError(f"path must end in .json, got {str(path)!r}")
        with replacing(path) as temporary:
            temporary.write_text(export.to_json(self.summary()) + "\n", encoding="utf-8")


def compare_models(
    surface: Surface,
    *,
    material: Material,
    loads: Sequence[float],
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    boundary: str = "free",
    progress: Callable[[Progress], None] | None = None,
) -> ModelComparison:
    """Solve the same loads with the ceiling and with plasticity of the volume.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, boundary
        As for `solve`; at least one body has a yield strength.
    loads : sequence of float
        Normal loads [N], ascending. The volume model follows them one after the other: a first
        load far beyond first yield wants smaller ones before it.
    progress : callable, optional
        Called with the `Progress` of the volume model.

    Returns
    -------
    ModelComparison
        Both models at each load.

    Raises
    ------
    InputError
        If no body yields, or the loads do not ascend.
    CapacityError
        If the ceiling cannot carry the largest load.
    ConvergenceError
        If one of the solves did not reach its tolerance.

    Notes
    -----
    The volume model is followed by `solve_elastoplastic`, which takes minutes on large maps.
    Where the contact yields below its surface but is far from full plasticity, the ceiling of
    three yield strengths is too high: by about a third in the mean pressure of a sphere at 10 to
    100 times the load of its first yield.
    """
    body = softer(material, counter_material)
    if body is None or body.yield_strength is None:
        raise InputError("no body has a yield strength: there is no plasticity to compare")
    given = [float(load) for load in loads]
    if not given or sorted(set(given)) != given or not given[0] > 0:
        raise InputError(f"loads must be positive and ascend, got {list(loads)}")
    bodies: dict[str, Any] = {
        "material": material,
        "counter_material": counter_material,
        "counter_surface": counter_surface,
        "boundary": boundary,
    }
    contact.check(surface, load=given[-1], **bodies)
    limited: list[ContactResult] = []
    states: list[ElastoplasticResult] = []
    for load in given:
        limited.append(
            contact.solve(surface, load=load, start=limited[-1] if limited else None, **bodies)
        )
        state = elastoplastic.solve_elastoplastic(
            surface, loads=[load], start=states[-1] if states else None, progress=progress, **bodies
        )
        if not state.converged:
            raise ConvergenceError(f"volume model at {load:.6g} N: {state.status}", state)
        states.append(state)
    return ModelComparison(tuple(limited), tuple(states), body.yield_strength)
