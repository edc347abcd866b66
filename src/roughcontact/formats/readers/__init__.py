"""Import of single readers of SurfaceTopography without its other dependencies.

On import `SurfaceTopography` registers all its functions, and `SurfaceTopography.IO` loads all
readers with their libraries: two seconds for one file. The search path of this package contains the
modules of the library, except those replaced here: ``IO``, which imports nothing, the two modules
of maps, whose functions are not needed, and ``Metadata``, which needs no pydantic. A reader that
cannot be loaded this way is used from the whole library.
"""

from __future__ import annotations

import os
from importlib import import_module
from importlib.util import find_spec
from typing import Any

# Readers whose module has another name.
_MODULES = {"metropro": "MetroPro", "mitutoyo": "Mitutoyo", "opdx": "OPDx", "poir": "OIR"}


def library() -> list[str]:
    """Return the folders of SurfaceTopography without importing it."""
    known = find_spec("SurfaceTopography")
    if known is None or known.submodule_search_locations is None:
        raise ModuleNotFoundError("No module named 'SurfaceTopography'")
    return list(known.submodule_search_locations)


def reader(name: str) -> Any:
    """Return the class of a reader."""
    own = import_module(f"{__name__}.IO")
    for folder in library():
        # An earlier import of either package has not set the location of the library.
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
