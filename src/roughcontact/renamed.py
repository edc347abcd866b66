"""Names of version 0.2 that work for one more release."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult


def _contact_result() -> type[ContactResult]:
    from roughcontact.contact.result import ContactResult

    return ContactResult


def _save() -> Callable[..., None]:
    return lambda result, path: result.save(path)


def _solve() -> Callable[..., ContactResult]:
    from roughcontact.contact.solve import solve

    def solve_slab(slab: Any, *, progress: Any = None, **options: Any) -> ContactResult:
        # It was called with a step alone.
        look = None if progress is None else lambda at: progress(at.step)
        return solve(slab, progress=look, **options)

    return solve_slab


OLD: dict[str, tuple[str, Callable[[], Any]]] = {
    "SlabResult": ("ContactResult", _contact_result),
    "save_slabs": ("result.save(path)", _save),
    "solve_slab": ("solve", _solve),
}
"""Each with its new name, and with what gives it."""


def found(name: str) -> Any:
    """Return what an old name stands for, with a warning that names the new one."""
    new, give = OLD[name]
    warnings.warn(
        f"{name} is now {new}; the old name works until 0.4", DeprecationWarning, stacklevel=3
    )
    return give()
