"""Names of 0.2 that work until 0.4, each with the one that replaced it: the one table of them."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

NAMES = {
    "FoundLoad": "studies.load_search.LoadAnswer",
    "FoundLoads": "studies.load_search.LoadSearch",
    "Kinematic": "hardening.Kinematic",
    "Linear": "hardening.Linear",
    "Perfect": "hardening.Perfect",
    "Rolling": "RollingResult",
    "Slab": "mpi.Slab",
    "SlabResult": "ContactResult",
    "Swift": "hardening.Swift",
    "Tabulated": "hardening.Tabulated",
    "catalogue": "catalog",
    "load_curve": "sweep",
    "load_elastoplastic": "read_result",
    "load_history": "history",
    "load_result": "read_result",
    "load_rolling": "read_result",
    "read_slab": "mpi.read_slab",
    "sampling_error": "sampling_study",
    "save_result": "contact.archive.save_result",
    "save_slabs": "contact.archive.save_result",
    "slab_rows": "mpi.slab_rows",
    "solve_slab": "solve",
    "yield_onset": "first_yield_load",
}
"""Of the package: old name to new name or place."""

ARGUMENTS: dict[str, dict[str, str]] = {
    "compare": {"first_pressure": "preload_pressure", "steps": "curve_points"},
    "conductance": {"body": "conductor", "counter_body": "counter_conductor"},
    "contact_modulus": {"first": "material", "second": "counter_material"},
    "find_load": {"contact": "contact_fraction", "saturated": "saturated_fraction"},
    "first_yield_load": {"start": "initial_load"},
    "generate": {"seed": "rng"},
    "history": {"path": "stages"},
    "leakage": {"direction": "flow_axis"},
    "read_slab": {"holes_masked": "mask_missing"},
    "reference_map": {"rng_seed": "rng"},
    "roll": {
        "centered": "start_at_center", "each": "on_step", "to_and_fro": "reciprocating",
        "way": "travel",
    },
    "shakedown_load": {"within": "rel_tol"},
    "solve": {"start": "initial_guess"},
    "solve_elastoplastic": {"communicator": "ranks", "each": "on_step"},
    "subsurface_stress": {"body": "in_body"},
}  # fmt: skip
"""Of functions: old keyword to new one."""

ATTRIBUTES: dict[str, dict[str, str]] = {
    "ContactResult": {
        "centre_of_pressure": "center_of_pressure",
        "corrected_contact_area": "perimeter_corrected_area", "given": "specified_load",
        "recommended": "calibration", "remarks": "extra_cautions", "smooth": "hertz",
        "unsealed": "without_checksums",
    },
    "ElastoplasticResult": {"flowed": "yielded", "travelled": "has_moved"},
    "InterfaceLaw": {"found": "messages"},
    "Leakage": {"beside": "with_coarser_grid", "film_ratio": "gap_ratio"},
    "LoadAnswer": {"above": "bracket_high", "below": "bracket_low"},
    "LoadHistory": {"shaken_down": "is_elastic_now"},
    "Material": {"at_odds": "tabor_ratio"},
    "Pass": {"flow": "strain_added", "gain": "strain_net"},
    "PathPoint": {"pull": "traction"},
    "RollingResult": {"answer": "outcome_text", "least_strain": "strain_threshold"},
    "StressResult": {"place": "max_von_mises_at"},
    "Surface": {"holes_masked": "missing_masked"},
}  # fmt: skip
"""Of objects: old attribute to new one, by class."""


def warn(old: str, new: str) -> None:
    """Say that a name has another one now."""
    warnings.warn(
        f"{old} is {new} now; the old name works until 0.4", DeprecationWarning, stacklevel=4
    )


def renamed(name: str) -> Any:
    """Return what a name of the package means now; `AttributeError` where it never had one."""
    if name not in NAMES:
        raise AttributeError(f"module 'roughcontact' has no attribute {name!r}")
    new = NAMES[name]
    warn(f"roughcontact.{name}", f"roughcontact.{new}")
    package = import_module("roughcontact")
    first, _, rest = new.partition(".")
    if not rest or first in package.__dir__():
        value: Any = package
        for part in new.split("."):
            value = getattr(value, part)
        return value
    module, _, attribute = new.rpartition(".")
    return getattr(import_module(f"roughcontact.{module}"), attribute)


def arguments(function: str, named: Mapping[str, Any]) -> dict[str, Any]:
    """Return keyword arguments of a function under their new names."""
    table, result = ARGUMENTS.get(function, {}), {}
    for name, value in named.items():
        if name in table:
            warn(f"{function}({name}=)", f"{table[name]}=")
        result[table.get(name, name)] = value
    return result


class Renamed:
    """An object whose attributes had other names."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Return what an old name of an attribute means."""
            for kind in type(self).__mro__:
                if new := ATTRIBUTES.get(kind.__name__, {}).get(name):
                    warn(f"{kind.__name__}.{name}", new)
                    return getattr(self, new)
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
