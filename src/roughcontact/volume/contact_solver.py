"""The contact on surfaces that plastic strain has displaced, solved again in each iteration."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.checks import touchable_gap
from roughcontact.errors import InputError
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.shares import Share
from roughcontact.material.material import CEILING_FACTOR
from roughcontact.solvers import bounded
from roughcontact.solvers.operator import Family
from roughcontact.solvers.problem import Loaded, Problem as ContactProblem
from roughcontact.volume.problem import Problem

_CONTACT_CONVOLUTIONS = 500


class ContactSolver:
    """The contact solver, started each time from the pressure before.

    Where the volume lies on several ranks the first solves the contact, a matter of two dimensions
    beside three, and tells the others.
    """

    def __init__(
        self,
        gap: NDArray[np.float64],
        make: Family,
        area: float,
        tolerance: float,
        share: Share,
    ) -> None:
        self._map, self._share = gap, share
        self._make, self.area, self.tolerance = make, area, tolerance
        self.resize(0)
        self.approach = 0.0
        self.convolutions = 0
        self.solution: bounded.Solution | None = None

    def resize(self, margin: int) -> None:
        """Add points that never touch around the map, and forget the pressure."""
        self.initial_gap = np.pad(self._map, margin, constant_values=np.inf)
        self.inside = tuple(slice(margin, margin + n) for n in self._map.shape)
        self.loaded: Loaded | None = None
        self.pressure = np.zeros(self.initial_gap.shape)

    def place(self, gap: NDArray[np.float64], moved: tuple[int, int]) -> None:
        """Take on another gap, of a counter-surface that has moved by some pixels."""
        self._map = gap
        self.initial_gap = np.pad(gap, self.inside[0].start, constant_values=np.inf)
        if self.loaded is None or not any(moved):
            return
        pressure = np.zeros(self.initial_gap.shape)
        pressure.ravel()[self.loaded[0]] = self.loaded[1]
        # A start needs to be good only where it can be: what wraps round is soon let go.
        pressure = np.roll(pressure, moved, (0, 1))
        pressure[np.isinf(self.initial_gap)] = 0
        index = np.flatnonzero(pressure)
        self.loaded = (index, pressure.ravel()[index]) if index.size else None

    def resume(self, pressure: NDArray[np.float64]) -> None:
        """Start from a pressure on the map."""
        self.pressure[self.inside] = pressure
        index = np.flatnonzero(self.pressure)
        if index.size:
            self.loaded = index, self.pressure.ravel()[index]

    def pressed(self, load: float, strength: float) -> NDArray[np.bool_]:
        """Return the contact under a ceiling of three yield strengths, roughly."""
        total = load / self.area
        limit = CEILING_FACTOR * strength
        if total > 0.9 * limit * np.count_nonzero(np.isfinite(self.initial_gap)):
            return np.isfinite(self.initial_gap)
        problem = ContactProblem(self.initial_gap, limit, total)
        rough = self._share.by_first(
            lambda: bounded.solve(problem, self._make, tolerance=1e-2, max_iterations=200)
        )
        pressed = np.zeros(self.initial_gap.shape, bool)
        pressed.ravel()[rough.index] = True
        return pressed

    @property
    def solved(self) -> bool:
        """Whether the last contact, if there is any, is within its tolerance."""
        return self.solution is None or self.solution.status is bounded.Status.CONVERGED

    def press(self, displacement: NDArray[np.float64], load: float) -> None:
        """Find the pressure that carries a load on the surface as plastic strain left it."""
        gap = self.initial_gap + displacement
        self.pressure = np.zeros(gap.shape)
        if load == 0:
            self.loaded, self.solution = None, None
            self.approach = float(gap.min())
            return
        solution = self._share.by_first(
            lambda: bounded.solve(
                ContactProblem(gap, np.inf, load / self.area),
                self._make,
                tolerance=self.tolerance,
                max_iterations=_CONTACT_CONVOLUTIONS,
                start=self.loaded,
            )
        )
        self.convolutions += solution.convolutions
        self.loaded = solution.index, solution.pressure
        self.pressure.ravel()[solution.index] = solution.pressure
        self.approach, self.solution = solution.approach, solution


def untouched(problem: Problem, share: Share, workspace: Workspace) -> ContactSolver:
    """Return the contact without pressure, if there can be one that yields.

    Parameters
    ----------
    problem : Problem
        What all loads have in common.
    share : Share
        Tells what the first rank finds.
    workspace : Workspace
        Threads of the contact.
    """
    if not problem.yielding:
        raise InputError(
            "neither material has a yield strength: nothing can yield; give one, or use solve"
        )
    gap = touchable_gap(problem.pair)
    # The contact is solved again and again on the same few grids.
    make = lru_cache(maxsize=12)(problem.pair.operators("double", workspace))
    return ContactSolver(gap, make, problem.pair.pixel_area, problem.contact_tolerance, share)
