"""The figures of an object as its methods: ``result.plot.pressure()``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, update_wrapper
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = Callable[..., "Figure"]


class Plots:
    """The figures of one object, each a function of ``rc.plots`` by its name.

    Parameters
    ----------
    shown : object
        What they are drawn of.
    figures : tuple of callable
        ``figure(shown, ...)`` draws one; the first is the usual one.

    Raises
    ------
    AttributeError
        If there are none.
    """

    def __init__(self, shown: object, figures: tuple[Draw, ...]) -> None:
        if not figures:
            raise AttributeError(f"a {type(shown).__name__} has no figures")
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
