"""What a session shows of surfaces and results: a few lines, a picture in a notebook, plots."""

from __future__ import annotations

from typing import Any


class Shown:
    """An object that a session shows by its headline numbers, and that offers its figures."""

    def __repr__(self) -> str:
        """Return the headline numbers, in some ten lines."""
        from roughcontact.report import glance

        return glance.text(self)

    def _repr_html_(self) -> str:
        """Return the headline numbers beside a picture, as a notebook shows them."""
        from roughcontact.report import glance

        return glance.html(self)

    @property
    def plot(self) -> Any:
        """Its figures: ``plot()`` draws the usual one, ``plot.pressure()`` and so on others."""
        from roughcontact.plots import accessor

        return accessor.of(self)
