"""Load increments of bodies that yield in their volume: strain, contact and stress in one loop.

A load increment is one convex problem in the plastic strain that it adds: the elastic energy with
the contact solved for its pressure, plus what plastic flow dissipates and hardening stores. Its
gradient is minus the stress, with Lipschitz constant 2μ on deviators, and the proximal map of
dissipation and hardening is the radial return. So one loop holds all::

    strain → displacement of the surface → pressure of the contact → stress → radial return

A step of it is a proximal gradient step with step size 1/(2μ), which never fails to descend;
Anderson's acceleration makes it fast. Nothing is relaxed and nothing is nested but the solver of
the contact, which starts each time from the pressure before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.anderson import Mixer, Parts, embedded
from roughcontact.volume.body import Body, equivalent_strain
from roughcontact.volume.contact_solver import CONTACT_TOLERANCE, ContactSolver
from roughcontact.volume.extent import LAYER_RATIO
from roughcontact.volume.memory import memory_estimate
from roughcontact.volume.problem import Problem
from roughcontact.volume.result import GUARD, ElastoplasticResult, Increment

Array = NDArray[Any]

# How often a load increment may be halved.
_CUTS = 5
# Depth of the layers over that before, when plastic strain has reached the lowest; growth of the
# volume to each side when it has reached the edge, over the edge of the map.
_DEEPER = 1.3
_WIDER = 0.1


@dataclass(frozen=True)
class Progress:
    """One iteration while the loop runs.

    Parameters
    ----------
    load : float
        Load at work [N].
    target : float
        Last load of the path [N].
    iteration : int
        Iterations at this load so far; 0 if this load and those before it stood in the folder.
    residual : float
        See `Increment`.
    tolerance : float
        Residual at which the load is done.
    """

    load: float
    target: float
    iteration: int
    residual: float
    tolerance: float


class Loop:
    """The loop over increments and iterations."""

    def __init__(
        self,
        problem: Problem,
        contact: ContactSolver,
        workspace: Workspace,
        target: float,
        progress: Callable[[Progress], None] | None,
    ) -> None:
        pixel, boundary = problem.surface.pixel, problem.boundary
        self.bodies = [
            Body(material, pixel, boundary, problem.precision, workspace)
            for material in problem.yielding
        ]
        self.contact = contact
        self._workspace, self._tolerance = workspace, problem.tolerance
        self._max_iterations = int(problem.max_iterations)
        self._target, self._progress = target, progress
        # Strain of the increment before, and its load: the first guess of the next.
        self._places: list[Parts] = []
        self._added: list[Parts] = []
        self._stride = 0.0

    def carried(self) -> dict[str, Array]:
        """Return what one load hands on to the next beside the state."""
        held = {"stride": np.array([self._stride])}
        if self.contact.loaded is not None:
            held["index"], held["pressure"] = self.contact.loaded
        for body, (places, added) in enumerate(zip(self._places, self._added, strict=True)):
            held[f"sizes_{body}"] = np.array([place.size for place in places])
            held[f"places_{body}"] = np.concatenate(places)
            held[f"added_{body}"] = np.concatenate(added, axis=1)
        return held

    def resume(self, before: ElastoplasticResult, held: Mapping[str, Array]) -> None:
        """Go on from a result, and from what `carried` returned with it if that is known."""
        for yielding, old in zip(self.bodies, before.bodies, strict=True):
            yielding.resume(old)
        self.contact.resume(before.contact.pressure)
        if not held:
            return
        # Arrays without numbers may be missing.
        self._stride = float(held["stride"][0])
        if "index" in held:
            self.contact.loaded = held["index"], held["pressure"]
        for body in range(len(self.bodies)):
            if f"places_{body}" in held:
                cuts = np.cumsum(held[f"sizes_{body}"])[:-1]
                self._places[body] = np.split(held[f"places_{body}"], cuts)
                self._added[body] = np.split(held[f"added_{body}"], cuts, axis=1)

    def resize(self, thickness: NDArray[np.float64], margin: int) -> None:
        """Enlarge the volume of all bodies, and start the increment again."""
        self.margin = margin
        self.contact.resize(margin)
        ny, nx = self.contact.initial_gap.shape
        for body in self.bodies:
            body.resize(thickness, (ny, nx))
        self._places, self._added = self.nothing()
        self._stride = 0.0

    def thaw(self) -> None:
        """Let the strain change that a result has frozen, when that is on disk."""
        for body in self.bodies:
            body.strain.flags.writeable = True

    def nothing(self) -> tuple[list[Parts], list[Parts]]:
        """Return places and strain of an increment without plastic flow, body by body."""
        places: list[Parts] = []
        added: list[Parts] = []
        for body in self.bodies:
            layers = len(body.strain)
            places.append([np.empty(0, np.int64)] * layers)
            added.append([np.empty((5, 0), body.real)] * layers)
        return places, added

    def follow(self, path: list[float], done: list[Increment], *, deepen: bool, widen: bool) -> str:
        """Visit loads one after the other; return why it stopped."""
        todo = path[::-1]
        before = done[-1].load if done else 0.0
        cuts = 0
        while todo:
            load = todo[-1]
            kept = self.contact.loaded
            found = self._relax(load, before)
            if found is None:
                self.contact.loaded = kept
                self._places, self._added = self.nothing()
                self._stride = 0.0
                if cuts == _CUTS or (not done and load == 0):
                    what = "plastic strain" if self.contact.solved else "contact"
                    return (
                        f"stopped on the way to {load:.6g} N: the {what} did not settle in "
                        f"{self._max_iterations} iterations, though the step was halved {cuts} "
                        "times; raise max_iterations, or ask for a larger tolerance"
                    )
                cuts += 1
                todo.append((before + load) / 2)
                continue
            if self._enlarged(deepen, widen):
                continue
            todo.pop()
            cuts = max(0, cuts - 1)
            for body, places, added in zip(self.bodies, self._places, self._added, strict=True):
                body.accept(places, added)
            residuals, convolutions = found
            self._stride, before = load - before, load
            contact = self.contact
            dy, dx = self.bodies[0].pixel
            done.append(
                Increment(
                    load=load,
                    approach=contact.approach,
                    contact_area=int(np.count_nonzero(contact.pressure)) * dy * dx,
                    max_pressure=float(contact.pressure.max()),
                    max_plastic_strain=max(float(b.accumulated.max()) for b in self.bodies),
                    plastic_volume=sum(body.plastic_volume for body in self.bodies),
                    residuals=residuals,
                    convolutions=convolutions,
                )
            )
        return "converged"

    def _enlarged(self, deepen: bool, widen: bool) -> bool:
        """Enlarge the volume if plastic strain has come to its bottom or its edge."""
        body = self.bodies[0]
        thickness, margin = list(body.thickness), self.margin
        (ny, nx), (dy, dx) = body.shape, body.pixel
        deepest, widest = 2 * max(ny * dy, nx * dx), max(ny, nx)
        if deepen and any(parts[-1].any() for parts in self._added):
            depth = min(_DEEPER * sum(thickness), deepest)
            while sum(thickness) < depth:
                thickness.append(thickness[-1] * LAYER_RATIO)
        if widen and 4 * margin < widest and self._at_edge():
            margin += max(GUARD, math.ceil(_WIDER * min(ny, nx)))
        if len(thickness) == body.thickness.size and margin == self.margin:
            return False
        wider = ny + 2 * (margin - self.margin), nx + 2 * (margin - self.margin)
        if not self._fits(wider, len(thickness)):
            # The result says that plastic strain has come to the bottom or to the edge.
            return False
        self.resize(np.array(thickness), margin)
        return True

    def _fits(self, shape: tuple[int, int], layers: int) -> bool:
        import psutil

        body = self.bodies[0]
        more: dict[str, Any] = dict(
            bodies=len(self.bodies), boundary=body.boundary, precision=body.precision
        )
        needed = memory_estimate(shape, layers, **more)
        held = memory_estimate(body.shape, body.thickness.size, **more)
        return needed - held < psutil.virtual_memory().available

    def _at_edge(self) -> bool:
        ny, nx = self.bodies[0].shape
        edge = np.ones((ny, nx), bool)
        edge[GUARD:-GUARD, GUARD:-GUARD] = False
        flat = edge.ravel()
        return any(
            bool(strain[:, flat[place]].any())
            for places, added in zip(self._places, self._added, strict=True)
            for place, strain in zip(places, added, strict=True)
        )

    def _relax(self, load: float, before: float) -> tuple[tuple[float, ...], int] | None:
        """Find the plastic strain of one increment; keep it beside that accepted.

        Returns the residuals of the iterations and the convolutions of the contact.
        """
        bodies, contact = self.bodies, self.contact
        stride = load - before
        if self._stride * stride > 0:
            factor = min(stride / self._stride, 1.0)
            self._added = [[part * part.dtype.type(factor) for part in a] for a in self._added]
        elif self._stride:
            self._places, self._added = self.nothing()
        self._stride = 0.0
        weights = [
            body.shear_modulus / bodies[0].shear_modulus * float(h / bodies[0].thickness[0])
            for body in bodies
            for h in body.thickness
        ]
        mixer = Mixer(weights, self._workspace)
        convolutions = contact.convolutions
        residuals: list[float] = []
        for iteration in range(1, self._max_iterations + 1):
            displacement = sum(
                body.displacement(places, added)
                for body, places, added in zip(bodies, self._places, self._added, strict=True)
            )
            contact.press(np.asarray(displacement), load, CONTACT_TOLERANCE)
            x: Parts = []
            y: Parts = []
            for number, body in enumerate(bodies):
                old_places, old = self._places[number], self._added[number]
                places, flowed = body.flow(contact.pressure, old_places, old)
                for layer, place in enumerate(places):
                    if place.size > old_places[layer].size:
                        mixer.grow(len(x) + layer, old_places[layer], place)
                        at = np.searchsorted(place, old_places[layer])
                        old[layer] = embedded(old[layer], at, place.size)
                self._places[number] = places
                x += flowed
                y += old
            defect = [one - other for one, other in zip(x, y, strict=True)]
            residual = self._residual(x, defect)
            residuals.append(residual)
            if self._progress is not None:
                self._progress(Progress(load, self._target, iteration, residual, self._tolerance))
            settled = residual <= self._tolerance and contact.solved
            if not settled:
                x = mixer.mix(x, defect)
            cut = 0
            for number, body in enumerate(bodies):
                self._added[number] = x[cut : cut + len(body.strain)]
                cut += len(body.strain)
            if settled:
                return tuple(residuals), contact.convolutions - convolutions
        return None

    def _residual(self, x: Parts, defect: Parts) -> float:
        """Return the largest change over the largest strain, or over the yield strain."""
        changes, sizes = np.zeros(len(x)), np.zeros(len(x))

        def measure(part: int) -> None:
            if x[part].size:
                changes[part] = equivalent_strain(defect[part]).max()
                sizes[part] = equivalent_strain(x[part]).max()

        self._workspace.each(measure, range(len(x)))
        least = max(body.law.initial / (2 * body.shear_modulus) for body in self.bodies)
        return float(changes.max() / max(least, sizes.max()))
