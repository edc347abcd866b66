"""Names of 0.2 that work until 0.4, each with the one that replaced it: the one table of them."""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import Any

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


def renamed(name: str) -> Any:
    """Return what a name of the package means now; `AttributeError` where it never had one."""
    if name not in NAMES:
        raise AttributeError(f"module 'roughcontact' has no attribute {name!r}")
    new = NAMES[name]
    warnings.warn(
        f"roughcontact.{name} is roughcontact.{new} now; the old name works until 0.4",
        DeprecationWarning,
        stacklevel=3,
    )
    package = import_module("roughcontact")
    first, _, rest = new.partition(".")
    if not rest or first in package.__dir__():
        value: Any = package
        for part in new.split("."):
            value = getattr(value, part)
        return value
    module, _, attribute = new.rpartition(".")
    return getattr(import_module(f"roughcontact.{module}"), attribute)
