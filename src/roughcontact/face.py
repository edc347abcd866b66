"""What results and maps offer to a session, by the wings that do it; see `roughcontact.result`."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from roughcontact.references import References

Path = str | os.PathLike[str]


def text(shown: object) -> str:
    """Return the headline numbers, one line each."""
    from roughcontact.report import glance

    return glance.text(shown)


def html(shown: object) -> str:
    """Return the headline numbers as HTML."""
    from roughcontact.report import glance

    return glance.html(shown)


def plots(shown: object) -> Any:
    """Return the figures as methods."""
    from roughcontact.plots import accessor
    from roughcontact.report import kinds

    kind = kinds.of(shown)
    return accessor.of(shown) if kind is None else accessor.Plots(shown, kind.plots)


def explore(shown: Any) -> Any:
    """Open the page in the browser."""
    from roughcontact.desk import explore

    return explore.explore(shown)


def save(shown: Any, path: Path) -> None:
    """Write a file in the format that its suffix names."""
    from roughcontact.report import results

    results.save(shown, path)


def summary(shown: object) -> dict[str, Any]:
    """Return the numbers by name."""
    from roughcontact.report import results

    return results.summary(shown)


def references(shown: object) -> References:
    """Return the papers."""
    from roughcontact.report import sources

    return sources.of(shown)
