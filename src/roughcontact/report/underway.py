"""What is done while one waits, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact import units
from roughcontact.solvers.progress import Progress, Step

if TYPE_CHECKING:
    from roughcontact.volume.loop import Look


def described(at: Progress) -> str:
    """Return what a solver is doing, in one line.

    Parameters
    ----------
    at : Progress
        What it tells.
    """
    part = f"{at.number} of {at.count}: " if at.count > 1 else ""
    label = f"{at.label}: " if at.label else ""
    if at.kept:
        return f"{label}{part}kept from before"
    return f"{label}{part}{_step(at.step) if isinstance(at.step, Step) else _look(at.step)}"


def _step(step: Step) -> str:
    ny, nx = step.shape
    return (
        f"solving {ny} × {nx}: {step.convolutions} convolutions, "
        f"certificate {step.certificate:.1e}, target {step.tolerance:.0e}"
    )


def _look(look: Look) -> str:
    load = units.engineering(look.load, "N")
    return f"at {load}: iteration {look.iteration}, residual {look.residual:.1e}"
