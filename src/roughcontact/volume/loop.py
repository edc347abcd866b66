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

import itertools
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import Mention, Sentence
from roughcontact.halfspace.layers import Pull
from roughcontact.halfspace.shares import Share
from roughcontact.solvers.anderson import Mixer, Parts, embedded
from roughcontact.solvers.problem import Loaded
from roughcontact.volume import memory
from roughcontact.volume.body import Body, Held, Way, equivalent_strain
from roughcontact.volume.contact_solver import ContactSolver
from roughcontact.volume.extent import Extent
from roughcontact.volume.going import Going
from roughcontact.volume.path import PathPoint
from roughcontact.volume.plastic_body import GUARD
from roughcontact.volume.problem import Problem
from roughcontact.volume.result import CONVERGED, Increment

Array = NDArray[Any]

# How often a load increment may be halved.
_CUTS = 5


@dataclass(frozen=True)
class Look:
    """One iteration while the loop runs.

    Parameters
    ----------
    load : float
        Load at work [N].
    target : float
        Last load of the path [N].
    iteration : int
        Iterations at this load so far.
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


class Stride(NamedTuple):
    """What an increment of the path was: change of the load [N], way in whole pixels."""

    load: float = 0.0
    y: int = 0
    x: int = 0


@dataclass(frozen=True, eq=False)
class State:
    """What a loop was at some time: plastic strain, and what the next increment starts from."""

    extent: Extent
    bodies: list[Held]
    loaded: Loaded | None
    places: list[Parts]
    added: list[Parts]
    stride: Stride
    point: PathPoint


class Loop:
    """The loop over increments and iterations.

    Parameters
    ----------
    problem : Problem
        What all loads have in common.
    solver : ContactSolver
        Of the contact, untouched.
    share : Share
        Which layers and waves of the volume are here, and threads.
    extent : Extent
        The volume to start with.
    deepen : bool
        Whether it may grow at its bottom; at its edge it may where the map ends there.
    """

    def __init__(
        self,
        problem: Problem,
        solver: ContactSolver,
        share: Share,
        extent: Extent,
        *,
        deepen: bool,
    ) -> None:
        self.problem, self.solver = problem, solver
        self.share, self._workspace = share, share.workspace
        self._deepen, self._widen = deepen, bool(problem.pair.boundary.free_axes)
        pair = problem.pair
        both = (pair.material, 1.0), (pair.counter_material, -1.0)
        yielding = [(body, sign) for body, sign in both if body.yield_strength is not None]
        self.bodies = [
            Body(material, pair.pixel, pair.boundary, problem.precision, share, pulled=sign)
            for material, sign in yielding
        ]
        # The counter-body takes its strain along where it slides.
        self._sliding = [number for number, (_, sign) in enumerate(yielding) if sign < 0]
        self._point, self._slid = PathPoint(0.0), (0.0, 0.0)
        self._resize(extent)

    def _resize(self, extent: Extent) -> None:
        """Enlarge the volume of all bodies, and start the increment again."""
        self.extent = extent
        self.solver.resize(extent.margin)
        ny, nx = self.solver.initial_gap.shape
        for body in self.bodies:
            body.resize(extent.thickness, (ny, nx))
        self._forget()

    def _forget(self) -> None:
        # Strain of the increment before, and its load: the first guess of the next.
        self._places, self._added = self._nothing()
        self._stride = Stride()

    def _nothing(self) -> tuple[list[Parts], list[Parts]]:
        """Return places and strain of an increment without plastic flow, body by body."""
        places: list[Parts] = []
        added: list[Parts] = []
        for body in self.bodies:
            layers = len(body.strain)
            places.append([np.empty(0, np.int64)] * layers)
            added.append([np.empty((5, 0), body.real)] * layers)
        return places, added

    def carried(self) -> dict[str, Array]:
        """Return what one load hands on to the next beside the state."""
        held = {"stride": np.array(self._stride)}
        if self.solver.loaded is not None:
            held["index"], held["pressure"] = self.solver.loaded
        for body, (places, added) in enumerate(zip(self._places, self._added, strict=True)):
            held[f"sizes_{body}"] = np.array([place.size for place in places])
            held[f"places_{body}"] = np.concatenate(places)
            held[f"added_{body}"] = np.concatenate(added, axis=1)
        return held

    def going(
        self, done: Sequence[Increment], largest: tuple[float, Array | None], seconds: float
    ) -> Going:
        """Return what the next point starts from, as long as none is visited."""
        bodies = [body.on_map() for body in self.bodies]
        pressure = self.solver.pressure[self.solver.inside]
        return Going(self.extent, bodies, pressure, tuple(done), largest, seconds, self.carried())

    def resume(self, before: Going) -> None:
        """Go on from what a run had come to."""
        points = [step.point for step in before.increments]
        for start, end in itertools.pairwise(points):
            self._slid = self._slid_to(start, end)
        self._slide(self._slid)
        for yielding, old in zip(self.bodies, before.bodies, strict=True):
            yielding.resume(*old)
        self.solver.resume(before.pressure)
        if before.increments:
            self._point = before.increments[-1].point
            self.solver.place(self.problem.gap_at(self._point.offset), (0, 0))
        held = before.carried
        if not held:
            return
        # Arrays without numbers may be missing.
        load, *way = held["stride"].tolist()
        self._stride = Stride(load, *map(int, way))
        if "index" in held:
            self.solver.loaded = held["index"], held["pressure"]
        for body in range(len(self.bodies)):
            if f"places_{body}" in held:
                cuts = np.cumsum(held[f"sizes_{body}"])[:-1]
                self._places[body] = np.split(held[f"places_{body}"], cuts)
                self._added[body] = np.split(held[f"added_{body}"], cuts, axis=1)

    def held(self) -> State:
        """Return the state that `restore` goes back to."""
        return State(
            self.extent,
            [body.held() for body in self.bodies],
            self.solver.loaded,
            [list(places) for places in self._places],
            [list(added) for added in self._added],
            self._stride,
            self._point,
        )

    def restore(self, state: State) -> None:
        """Go back to a state; layers and points that came since are kept."""
        for body, held in zip(self.bodies, state.bodies, strict=True):
            body.restore(held)
        self._go(state.point)
        if self.extent is state.extent:
            self.solver.loaded = state.loaded
            self._places = [list(places) for places in state.places]
            self._added = [list(added) for added in state.added]
            self._stride = state.stride
        else:
            self._forget()

    @property
    def pull(self) -> Pull:
        """Traction on the rough body over the pressure, at the point of the path reached."""
        return self._point.pull

    @property
    def flowing(self) -> bool:
        """Whether there was plastic flow in the last increment."""
        return self.share.any(any(part.any() for added in self._added for part in added))

    def thaw(self) -> None:
        """Let the strain change that a result has frozen, when that is on disk."""
        for body in self.bodies:
            body.strain.flags.writeable = True

    def displacement(self) -> Array:
        """Return the displacement by the strain accepted, with what its trace adds."""
        places, added = self._nothing()
        displacement = np.zeros(self.solver.initial_gap.shape)
        for body, place, strain in zip(self.bodies, places, added, strict=True):
            displacement += body.displacement(place, strain, trace=True)
        return displacement

    def _go(self, point: PathPoint) -> None:
        """Put the counter-surface where a point of the path wants it."""
        if point.offset != self._point.offset:
            way = self._way(self._point, point)
            self.solver.place(self.problem.gap_at(point.offset), way)
        self._point = point

    def _slid_to(self, before: PathPoint, point: PathPoint) -> Way:
        """Return how far the counter-body has slid at a point, in pixels."""
        if not point.friction:
            return self._slid
        ways = zip(self._slid, point.offset, before.offset, self.problem.pair.pixel, strict=True)
        y, x = (slid + (end - start) / edge for slid, end, start, edge in ways)
        return y, x

    def _slide(self, way: Way) -> None:
        for number in self._sliding:
            self.bodies[number].slid = way

    def _way(self, before: PathPoint, point: PathPoint) -> tuple[int, int]:
        """Return the way between two points to the nearest pixel."""
        edges, ends = self.problem.pair.pixel, zip(before.offset, point.offset, strict=True)
        y, x = (round((end - start) / edge) for (start, end), edge in zip(ends, edges, strict=True))
        return y, x

    def reach(
        self, point: PathPoint, done: list[Increment], watch: Callable[[float, int, float], None]
    ) -> str:
        """Visit a point, by smaller steps where it takes them; return why it stopped.

        Parameters
        ----------
        point : PathPoint
            The point of the path.
        done : list of Increment
            Those before; the new ones are added.
        watch : callable
            Called after every iteration with load, iteration and residual.

        Returns
        -------
        str
            `CONVERGED`, or a reason in words.
        """
        todo = [point]
        before = done[-1].point if done else PathPoint(0.0, point.offset)
        cuts = 0
        while todo:
            point = todo[-1]
            kept = self.solver.loaded
            self._go(point)
            slid = self._slid_to(before, point)
            self._slide(slid)
            found = self._relax(before, watch)
            if found is None:
                self._go(before)
                self._slide(self._slid)
                self.solver.loaded = kept
                self._forget()
                if cuts == _CUTS or (not done and point.load == 0):
                    return self._reason(point.load, cuts)
                cuts += 1
                todo.append(before.between(point, 1, 2))
                continue
            if self._enlarged():
                self._go(before)
                self._slide(self._slid)
                continue
            todo.pop()
            cuts = max(0, cuts - 1)
            self._accept()
            self._stride = Stride(point.load - before.load, *self._way(before, point))
            before, self._slid = point, slid
            done.append(self._increment(*found))
        return CONVERGED

    def _reason(self, load: float, cuts: int) -> str:
        what = "plastic strain" if self.solver.solved else "contact"
        return Sentence(
            f"stopped on the way to {load:.6g} N: the {what} did not settle in "
            f"{int(self.problem.max_iterations)} iterations, though the step was halved {cuts} "
            "times; raise ",
            Mention("max_iterations"),
            ", or ask for a larger ",
            Mention("tolerance"),
        )

    def _accept(self) -> None:
        for body, places, added in zip(self.bodies, self._places, self._added, strict=True):
            body.accept(places, added)

    def _increment(self, residuals: tuple[float, ...], convolutions: int) -> Increment:
        """Return what a point of the path gave whose strain is accepted."""
        pressure, (dy, dx) = self.solver.pressure, self.problem.pair.pixel
        return Increment(
            **asdict(self._point),
            approach=self.solver.approach,
            contact_area=int(np.count_nonzero(pressure)) * dy * dx,
            max_pressure=float(pressure.max()),
            max_plastic_strain=max(body.max_plastic_strain for body in self.bodies),
            plastic_volume=sum(body.plastic_volume for body in self.bodies),
            residuals=residuals,
            convolutions=convolutions,
        )

    def _enlarged(self) -> bool:
        """Enlarge the volume if plastic strain has come to its bottom or its edge."""
        surface, old = self.problem.pair, self.extent
        new = old.grown(
            surface.shape,
            surface.pixel,
            deeper=self._deepen and self._at_bottom(),
            wider=self._widen and self._at_edge(),
        )
        sizes = [(one.grid(surface.shape), one.thickness.size) for one in (old, new)]
        # Where it does not fit the result says that plastic strain has come that far.
        if sizes[0] == sizes[1]:
            return False
        if self.share.any(not memory.fits(self.problem, self.share, *sizes)):
            return False
        self._resize(new)
        return True

    def _at_bottom(self) -> bool:
        layers = self.extent.thickness.size
        lowest = self.bodies[0].here[-1] == layers - 1
        return self.share.any(lowest and any(parts[-1].any() for parts in self._added))

    def _at_edge(self) -> bool:
        ny, nx = self.bodies[0].shape
        edge = np.ones((ny, nx), bool)
        edge[GUARD:-GUARD, GUARD:-GUARD] = False
        flat = edge.ravel()
        return self.share.any(
            any(
                strain[:, flat[place]].any()
                for places, added in zip(self._places, self._added, strict=True)
                for place, strain in zip(places, added, strict=True)
            )
        )

    def _relax(
        self, before: PathPoint, watch: Callable[[float, int, float], None]
    ) -> tuple[tuple[float, ...], int] | None:
        """Find the plastic strain of one increment; keep it beside that accepted.

        Returns the residuals of the iterations and the convolutions of the contact.
        """
        solver, tolerance, load = self.solver, self.problem.tolerance, self._point.load
        self._guess(Stride(load - before.load, *self._way(before, self._point)))
        mixer = Mixer(self._weights(), self._workspace, self._whole)
        convolutions = solver.convolutions
        residuals: list[float] = []
        for iteration in range(1, int(self.problem.max_iterations) + 1):
            displacement = sum(
                body.displacement(places, added)
                for body, places, added in zip(self.bodies, self._places, self._added, strict=True)
            )
            solver.press(np.asarray(displacement), load)
            x, y = self._flow(mixer)
            defect = [one - other for one, other in zip(x, y, strict=True)]
            residuals.append(self._residual(x, defect))
            watch(load, iteration, residuals[-1])
            settled = residuals[-1] <= tolerance and solver.solved
            self._keep(x if settled else mixer.mix(x, defect))
            if settled:
                return tuple(residuals), solver.convolutions - convolutions
        return None

    def _guess(self, stride: Stride) -> None:
        """Start from the strain of the increment before: in proportion to the load, or moved on."""
        last, self._stride = self._stride, Stride()
        if stride[1:] != last[1:]:
            self._places, self._added = self._nothing()
        elif any(stride[1:]):
            # The same way again: what flows goes along with the contact.
            for number, body in enumerate(self.bodies):
                if number in self._sliding and self._point.friction:
                    continue
                for layer in range(len(body.strain)):
                    self._carry(number, layer, stride)
        elif last.load * stride.load > 0:
            factor = min(stride.load / last.load, 1.0)
            self._added = [[part * part.dtype.type(factor) for part in a] for a in self._added]
        elif last.load:
            self._places, self._added = self._nothing()

    def _carry(self, number: int, layer: int, stride: Stride) -> None:
        """Move the strain of the increment before with the counter-surface."""
        place = self._places[number][layer]
        if not place.size:
            return
        shape = self.bodies[number].shape
        there, inside = [], np.ones(place.size, bool)
        for axis, (at, way, count) in enumerate(
            zip(np.divmod(place, shape[1]), stride[1:], shape, strict=True)
        ):
            moved = at + way
            if axis in self.problem.pair.boundary.periodic_axes:
                moved %= count
            inside &= (moved >= 0) & (moved < count)
            there.append(moved)
        flat = (there[0] * shape[1] + there[1])[inside]
        order = np.argsort(flat)
        self._places[number][layer] = flat[order]
        self._added[number][layer] = self._added[number][layer][:, inside][:, order]

    def _weights(self) -> list[float]:
        """Return what a square of strain counts in each layer here, body after body."""
        first = self.bodies[0]
        return [
            body.shear_modulus / first.shear_modulus * float(h / first.thickness[0])
            for body in self.bodies
            for h in body.thickness[body.here]
        ]

    def _whole(self, rows: Array) -> Array:
        """Return rows of all layers of those here, body after body."""
        layers = self.extent.thickness.size
        bodies = np.split(rows, len(self.bodies))
        return np.concatenate([self.share.whole(part, layers) for part in bodies])

    def _flow(self, mixer: Mixer) -> tuple[Parts, Parts]:
        """Return the strain after the return to the yield surface, and that before it.

        Both are layer by layer, all bodies one after the other, on the same places, which grow.
        """
        x: Parts = []
        y: Parts = []
        for number, body in enumerate(self.bodies):
            old_places, old = self._places[number], self._added[number]
            places, flowed = body.flow(self.solver.pressure, self.pull, old_places, old)
            for layer, place in enumerate(places):
                if place.size > old_places[layer].size:
                    mixer.grow(len(x) + layer, old_places[layer], place)
                    at = np.searchsorted(place, old_places[layer])
                    old[layer] = embedded(old[layer], at, place.size)
            self._places[number] = places
            x += flowed
            y += old
        return x, y

    def _keep(self, x: Parts) -> None:
        """Take over the strain of all layers, body by body."""
        cut = 0
        for number, body in enumerate(self.bodies):
            self._added[number] = x[cut : cut + len(body.strain)]
            cut += len(body.strain)

    def _residual(self, x: Parts, defect: Parts) -> float:
        """Return the largest change over the largest strain, or over the yield strain."""
        changes, sizes = np.zeros(len(x)), np.zeros(len(x))

        def measure(part: int) -> None:
            if x[part].size:
                changes[part] = equivalent_strain(defect[part]).max()
                sizes[part] = equivalent_strain(x[part]).max()

        self._workspace.each(measure, range(len(x)))
        least = max(body.law.initial / (2 * body.shear_modulus) for body in self.bodies)
        change, size = (self.share.largest(float(found.max())) for found in (changes, sizes))
        return float(change / max(least, size))
