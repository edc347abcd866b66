"""Parts of the page of which one is in sight: each is made when it is first looked at."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import panel as pn

from roughcontact.desk.reach import Tabs


class View(Protocol):
    """A part of the page."""

    root: Any
    """What stands there."""

    def show(self) -> None:
        """Show what there is now; called whenever that changed while it is in sight."""

    def cancel(self) -> None:
        """End what is under way."""


class Views:
    """Tabs, the first of which is always there.

    Parameters
    ----------
    first : viewable
        The first.
    others : Mapping
        What makes the others, by name.
    """

    def __init__(self, first: Any, others: Mapping[str, Callable[[], View]]) -> None:
        self._makers = list(others.values())
        self._made: dict[int, View] = {}
        self._places = [pn.Column(sizing_mode="stretch_both", margin=0) for _ in others]
        parts = {"Contact": first, **dict(zip(others, self._places, strict=True))}
        self._tabs = Tabs(parts, self.show, "stretch_both")
        self.root = self._tabs.root

    def show(self) -> None:
        """Have the part that is in sight show what there is."""
        active = self._tabs.active
        if active == 0:
            return
        if active not in self._made:
            self._made[active] = made = self._makers[active - 1]()
            self._places[active - 1].append(made.root)
        self._made[active].show()

    def close(self) -> None:
        """End what is under way in any of them."""
        for view in self._made.values():
            view.cancel()
