"""The figures of an object as its methods: ``result.plot.pressure()``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, update_wrapper
from typing import TYPE_CHECKING, Any

from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.history import LoadHistory
from roughcontact.contact.result import ContactResult
from roughcontact.contact.stress import StressResult
from roughcontact.joint.interface import InterfaceLaw
from roughcontact.plots import curves, laws, maps, profiles, rolling, stress, traces, volume
from roughcontact.surface.surface import Surface
from roughcontact.volume.result import ElastoplasticResult
from roughcontact.volume.rolling import Rolling

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = Callable[..., "Figure"]

# The first is the one that is drawn where none is named.
_FIGURES: dict[type, tuple[Draw, ...]] = {
    Surface: (maps.surface, profiles.bearing_curve),
    ContactResult: (
        maps.overview, maps.pressure, maps.contact, maps.gap, maps.close_up, maps.spots,
        profiles.section, profiles.pressure_histogram,
    ),
    LoadCurve: (curves.load_curve,),
    LoadHistory: (curves.hysteresis,),
    InterfaceLaw: (laws.interface_law,),
    StressResult: (stress.stress_section, stress.stress_depth, stress.stress_map),
    ElastoplasticResult: (
        volume.section, volume.profile, volume.layers, volume.path, volume.residual_displacement,
        volume.convergence,
    ),
    Rolling: (rolling.passes, rolling.depths, rolling.heights),
}  # fmt: skip

_OF_PROFILES: dict[type, tuple[Draw, ...]] = {
    Surface: (traces.heights,),
    ContactResult: (traces.pressed,),
    LoadCurve: (traces.load_curve,),
    StressResult: (stress.stress_section, stress.stress_depth),
}


class Plots:
    """The figures of one object, each a function of ``rc.plots`` by its name.

    Parameters
    ----------
    shown : object
        What they are drawn of.
    figures : tuple of callable
        ``figure(shown, ...)`` draws one; the first is the usual one.
    """

    def __init__(self, shown: object, figures: tuple[Draw, ...]) -> None:
        self._shown = shown
        self._figures = {figure.__name__: figure for figure in figures}

    def __call__(self, **options: Any) -> Figure:
        """Draw the usual figure."""
        usual = next(iter(self._figures.values()))
        return usual(self._shown, **options)

    def __getattr__(self, name: str) -> Draw:
        """Return what draws a figure, with its own documentation."""
        if name.startswith("_") or name not in self._figures:
            raise AttributeError(f"there is no figure {name!r}, only {', '.join(self._figures)}")
        draw = self._figures[name]
        return update_wrapper(partial(draw, self._shown), draw)

    def __dir__(self) -> list[str]:
        """Return the names of the figures."""
        return list(self._figures)

    def __repr__(self) -> str:
        """Return the names of the figures, as they are called."""
        return "figures: plot(), " + ", ".join(f"plot.{name}()" for name in self._figures)


def of(shown: object) -> Plots:
    """Return the figures of an object.

    Parameters
    ----------
    shown : Surface, ContactResult, LoadCurve, LoadHistory, InterfaceLaw, StressResult, \
ElastoplasticResult or Rolling
        The object.

    Raises
    ------
    AttributeError
        If there are none of its kind.
    """
    if isinstance(shown, ContactResult):
        shown.require_whole("figures")
    table = {**_FIGURES, **(_OF_PROFILES if _is_profile(shown) else {})}
    for kind, figures in table.items():
        if isinstance(shown, kind):
            return Plots(shown, figures)
    raise AttributeError(f"a {type(shown).__name__} has no figures")


def _is_profile(shown: Any) -> bool:
    solution = shown.solution if isinstance(shown, StressResult) else shown
    described = solution.pair if isinstance(solution, ContactResult) else solution
    return bool(getattr(described, "is_profile", False))
