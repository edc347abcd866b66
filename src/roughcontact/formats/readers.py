"""Import of single readers of SurfaceTopography without its other dependencies.

On import SurfaceTopography registers all its functions, and ``SurfaceTopography.IO`` loads all
readers with their libraries: two seconds for one file. The package ``_LIBRARY`` contains the
modules of the library without its ``__init__``, except those replaced by this module: maps and
profiles, whose functions are not needed, and metadata, which need no pydantic. A reader that cannot
be loaded this way is used from the whole library.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, module_from_spec
from typing import Any

import numpy as np

_LIBRARY = f"{__name__}.library"
_REPLACED = ("HeightContainer", "Metadata", "NonuniformLineScan", "UniformLineScanAndTopography")
# Readers whose module has another name.
_MODULES = {"metropro": "MetroPro", "mitutoyo": "Mitutoyo", "opdx": "OPDx", "poir": "OIR"}


def reader(name: str) -> Any:
    """Return the class of a reader."""
    _make_packages()
    module = import_module(f"{_LIBRARY}.IO.{_MODULES.get(name, name.upper())}")
    for known in vars(module).values():
        own = getattr(known, "__module__", "") == module.__name__ and hasattr(known, "channels")
        if own and known.format() == name:
            return known
    raise ImportError(f"{module.__name__} has no reader of {name!r}")


def _make_packages() -> None:
    """Create the packages that find the modules of the library, unless they exist."""
    if _LIBRARY in sys.modules:
        return
    folder = _library_folder()
    for name, place in ((f"{_LIBRARY}.IO", f"{folder}/IO"), (_LIBRARY, folder)):
        spec = ModuleSpec(name, None, is_package=True)
        spec.submodule_search_locations = [place]
        sys.modules[name] = module_from_spec(spec)
    for name in _REPLACED:
        sys.modules[f"{_LIBRARY}.{name}"] = sys.modules[__name__]


def _library_folder() -> str:
    """Return the folder of SurfaceTopography without importing it."""
    known = find_spec("SurfaceTopography")
    if known is None or not known.submodule_search_locations:
        raise ModuleNotFoundError("No module named 'SurfaceTopography'")
    return known.submodule_search_locations[0]


class UniformTopographyInterface:
    """Base class of maps and profiles."""

    @classmethod
    def register_function(cls, name: str, function: Callable[..., Any]) -> None:
        """Ignore a function for export, which is not needed here."""


class _Grid(UniformTopographyInterface):
    """Heights and sides in the unit of the file, of a map ``[x, y]`` and ``(x, y)``."""

    is_uniform = True
    _dimensions: int

    def __init__(
        self,
        heights: Any,
        physical_sizes: float | Sequence[float],
        periodic: bool | None = False,
        unit: str | None = None,
        info: Mapping[str, Any] | None = None,
    ) -> None:
        if np.ndim(heights) != self._dimensions:
            raise ValueError(f"the heights have no {self._dimensions} dimensions")
        if not np.ma.is_masked(heights) and not np.isfinite(heights).all():
            heights = np.ma.masked_invalid(heights)
        self._heights = np.asanyarray(heights, dtype=float)
        self._sizes: Any = physical_sizes if np.iterable(physical_sizes) else (physical_sizes,)
        self._factor: float | None = None

    def scale(self, factor: float) -> Any:
        """Return the map or profile with its heights multiplied."""
        scaled = type(self)(self._heights, self._sizes)
        scaled._factor = factor
        return scaled

    @property
    def pixel_size(self) -> tuple[float, ...]:
        """Edges of a pixel, ``(x, y)``, or the distance between the points."""
        return tuple(size / n for size, n in zip(self._sizes, self._heights.shape, strict=False))

    def heights(self) -> Any:
        """Return the heights, masked where some are missing."""
        return self._heights if self._factor is None else self._factor * self._heights


class Topography(_Grid):
    """Map of a reader."""

    _dimensions = 2


class UniformLineScan(_Grid):
    """Profile of a reader."""

    _dimensions = 1


class NonuniformLineScan(UniformTopographyInterface):
    """Positions and heights of a profile in the unit of the file."""

    is_uniform = False

    def __init__(
        self, x: Any, y: Any, unit: str | None = None, info: Mapping[str, Any] | None = None
    ) -> None:
        self._x, self._y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)

    def scale(self, factor: float) -> NonuniformLineScan:
        """Return the profile with its heights multiplied."""
        return NonuniformLineScan(self._x, factor * self._y)

    def positions(self) -> Any:
        """Return the positions."""
        return self._x

    def heights(self) -> Any:
        """Return the heights."""
        return self._y


class InfoModel:
    """Metadata of a file as its reader gives them."""

    def __init__(self, **fields: Any) -> None:
        when = fields.get("acquisition_time")
        if isinstance(when, str):
            fields["acquisition_time"] = datetime.fromisoformat(when)
        self._fields = fields

    def model_dump(self, *, exclude_none: bool = True) -> dict[str, Any]:
        """Return the known metadata by name."""
        return {name: value for name, value in self._fields.items() if value is not None}
