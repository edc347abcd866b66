"""SurfaceTopography's readers one by one, without what that library imports beside them.

On import `SurfaceTopography` registers all that it can compute, and `SurfaceTopography.IO` loads
all its readers with the libraries that each of them needs: two seconds for one file. This package
has the library's own modules as its own, by its search path, but for those that stand here:
``IO``, which imports nothing, the two modules of maps, which readers make and nobody computes
with, and ``Metadata``, which needs no pydantic. What does not load this way is read by the whole
library.
"""

from __future__ import annotations

import os
from importlib import import_module
from importlib.util import find_spec
from typing import Any

# Readers whose module is not called as they are.
_MODULES = {"metropro": "MetroPro", "mitutoyo": "Mitutoyo", "opdx": "OPDx", "poir": "OIR"}


def library() -> list[str]:
    """Return the folders of SurfaceTopography, which is found and not imported."""
    known = find_spec("SurfaceTopography")
    if known is None or known.submodule_search_locations is None:
        raise ModuleNotFoundError("No module named 'SurfaceTopography'")
    return list(known.submodule_search_locations)


def reader(name: str) -> Any:
    """Return the class of a reader."""
    own = import_module(f"{__name__}.IO")
    for folder in library():
        # An earlier import of either has not set the location of the library.
        for path, place in ((__path__, folder), (own.__path__, os.path.join(folder, "IO"))):
            if place not in path:
                path.append(place)
    module = import_module(f"{__name__}.IO.{_MODULES.get(name, name.upper())}")
    for known in vars(module).values():
        if getattr(known, "__module__", "") == module.__name__ and _reads(known, name):
            return known
    raise ImportError(f"{module.__name__} has no reader of {name!r}")


def _reads(known: Any, name: str) -> bool:
    return hasattr(known, "channels") and known.format() == name
