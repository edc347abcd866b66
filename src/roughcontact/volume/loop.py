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
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.result import initial_gap
from roughcontact.errors import InputError
from roughcontact.halfspace import plastic
from roughcontact.halfspace.fft import Workspace, default_workers
from roughcontact.halfspace.plastic import HalfSpace
from roughcontact.material.hardening import Hardening, Perfect, plastic_increment
from roughcontact.material.material import CEILING_FACTOR, Material
from roughcontact.solvers import bounded
from roughcontact.solvers.anderson import Mixer, Parts, embedded
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from roughcontact.volume.solve import ElastoplasticResult

Array = NDArray[Any]

LAYER_RATIO = 1.08
"""Thickness of a layer over that of the one above."""

# How often a load increment may be halved.
_CUTS = 5
# Depth of the layers over that before, when plastic strain has reached the lowest; growth of the
# volume to each side when it has reached the edge, over the edge of the map.
_DEEPER = 1.3
_WIDER = 0.1
CONTACT_TOLERANCE = 1e-6
"""Tolerance of the contact."""

_CONTACT_CONVOLUTIONS = 500

GUARD = 2
"""Rows and columns at the edge of the volume that plastic strain may not reach."""


@dataclass(frozen=True)
class Increment:
    """What one load of the path gave.

    Parameters
    ----------
    load : float
        Normal load [N].
    approach : float
        Approach of the bodies from the first touch [m].
    contact_area : float
        Real contact area [m²].
    max_pressure : float
        Largest pressure [Pa].
    max_plastic_strain : float
        Largest accumulated plastic strain so far.
    plastic_volume : float
        Volume with plastic strain so far, of both bodies [m³].
    residuals : tuple of float
        Largest change of the plastic strain in each iteration over the largest of this increment,
        or over the yield strain σ_Y/(2μ) if that is more.
    convolutions : int
        Convolutions of the contact solver.
    """

    load: float
    approach: float
    contact_area: float
    max_pressure: float
    max_plastic_strain: float
    plastic_volume: float
    residuals: tuple[float, ...]
    convolutions: int

    @property
    def residual(self) -> float:
        """Residual after the last iteration."""
        return self.residuals[-1]

    @property
    def iterations(self) -> int:
        """Iterations of the loop."""
        return len(self.residuals)


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


@dataclass(frozen=True, eq=False)
class PlasticBody:
    """Plastic strain and stress of one body; layers from its surface down.

    Tensors without trace have the components zz, (xx - yy)/2, xy, xz, yz, z into the body;
    `roughcontact.halfspace.plastic.tensor` makes matrices of them. Arrays are read-only.

    Parameters
    ----------
    material : Material
        Of the body.
    pixel_area : float
        Area of a pixel [m²].
    margin : int
        Rows and columns of the volume beyond each edge of the map, included in the arrays.
    thickness : ndarray, shape (nz,)
        Thickness of each layer [m].
    plastic_strain : ndarray, shape (nz, 5, ny, nx)
        Plastic strain, constant over each layer.
    accumulated : ndarray, shape (nz, ny, nx)
        Accumulated plastic strain e = ∫ √(2/3 dε:dε).
    stress, mean_stress : ndarray, shapes (nz, 5, ny, nx) and (nz, ny, nx)
        Deviator and a third of the trace of the stress under load, averages over the layers [Pa].
    residual_stress, mean_residual_stress : ndarray
        Those by the plastic strain alone [Pa]: what the load leaves when it is gone, unless the
        body flows again on unloading.
    """

    material: Material
    pixel_area: float
    margin: int
    thickness: NDArray[np.float64]
    plastic_strain: Array
    accumulated: Array
    stress: Array
    mean_stress: Array
    residual_stress: Array
    mean_residual_stress: Array

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        middle: NDArray[np.float64] = np.cumsum(self.thickness) - self.thickness / 2
        return middle

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], shape (nz, ny, nx)."""
        return plastic.equivalent(self.stress.swapaxes(0, 1))

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], shape (nz, ny, nx)."""
        return plastic.equivalent(self.residual_stress.swapaxes(0, 1))

    @property
    def elastic_stress(self) -> Array:
        """Deviator of the stress by the pressure alone [Pa], shape (nz, 5, ny, nx)."""
        elastic: Array = self.stress - self.residual_stress
        return elastic

    @cached_property
    def max_plastic_strain(self) -> float:
        """Largest accumulated plastic strain."""
        return float(self.accumulated.max())

    @cached_property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        cells = np.count_nonzero(self.accumulated, axis=(1, 2))
        return float(cells @ self.thickness) * self.pixel_area

    @cached_property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches [m]: the lower face of its lowest layer."""
        layers = np.flatnonzero(self.accumulated.any(axis=(1, 2)))
        return float(self.thickness[: layers[-1] + 1].sum()) if layers.size else 0.0


@dataclass(frozen=True, eq=False)
class Problem:
    """What all loads of a path have in common; see `solve_elastoplastic`."""

    surface: Surface
    counter_surface: Surface | None
    material: Material
    counter_material: Material
    boundary: str
    tolerance: float
    max_iterations: int
    precision: str

    @property
    def yielding(self) -> list[Material]:
        """Materials with a yield strength, that of the rough body first."""
        both = self.material, self.counter_material
        return [body for body in both if body.yield_strength is not None]

    def check_same(self, what: str, before: ElastoplasticResult) -> None:
        """Raise `InputError` if a result is one of other bodies or another boundary."""
        old = before.contact
        gap = initial_gap(self.surface, self.counter_surface)
        same = {
            "surface": old.pressure.shape == self.surface.shape
            and np.array_equal(old.initial_gap, gap, equal_nan=True),
            "pixel": old.surface.pixel == self.surface.pixel,
            "material": old.material == self.material,
            "counter_material": old.counter_material == self.counter_material,
            "boundary": old.boundary == self.boundary,
        }
        for name, agrees in same.items():
            if not agrees:
                raise InputError(
                    f"{what} was solved with another {name}: plastic strain stays with it"
                )


def memory_estimate(
    shape: tuple[int, int],
    layers: int,
    *,
    bodies: int = 1,
    boundary: str = "free",
    precision: str = "single",
) -> int:
    """Return about the memory that `solve_elastoplastic` needs.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    layers : int
        Number of layers.
    bodies : int
        How many of the two yield.
    boundary, precision
        As for `solve_elastoplastic`.

    Returns
    -------
    int
        Bytes, if a quarter of the volume yields.
    """
    real = 8 if precision == "double" else 4
    points = shape[0] * shape[1]
    padded = plastic.points_transformed(shape, boundary)
    # Spectra of strain and mean stress and the tables; strain, stresses, and what Anderson's
    # acceleration remembers of a quarter of the points. The bodies share what threads sweep with.
    swept = min(default_workers() * plastic.SWEEP_POINTS, padded / 4)
    volume = bodies * layers * (7.5 * padded + 35 * points) + (6 * layers + 28) * swept
    return int(real * volume) + 200 * points


class Contact:
    """The contact solver, started each time from the pressure before."""

    def __init__(self, gap: NDArray[np.float64], make: bounded.Operator, area: float) -> None:
        self._map = gap
        self._make, self.area = make, area
        self.resize(0)
        self.approach = 0.0
        self.convolutions = 0
        self.solution: bounded.Solution | None = None

    def resize(self, margin: int) -> None:
        """Add points that never touch around the map, and forget the pressure."""
        self.initial_gap = np.pad(self._map, margin, constant_values=np.inf)
        self.inside = tuple(slice(margin, margin + n) for n in self._map.shape)
        self.loaded: bounded.Loaded | None = None
        self.pressure = np.zeros(self.initial_gap.shape)

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
        problem = bounded.Problem(self.initial_gap, limit, total)
        rough = bounded.solve(problem, self._make, tolerance=1e-2, max_iterations=200)
        pressed = np.zeros(self.initial_gap.shape, bool)
        pressed.ravel()[rough.index] = True
        return pressed

    @property
    def solved(self) -> bool:
        """Whether the last contact, if there is any, is within its tolerance."""
        return self.solution is None or self.solution.status is bounded.Status.CONVERGED

    def press(self, displacement: NDArray[np.float64], load: float, tolerance: float) -> None:
        """Find the pressure that carries a load on the surface as plastic strain left it."""
        gap = self.initial_gap + displacement
        self.pressure = np.zeros(gap.shape)
        if load == 0:
            self.loaded, self.solution = None, None
            self.approach = float(gap.min())
            return
        solution = bounded.solve(
            bounded.Problem(gap, np.inf, load / self.area),
            self._make,
            tolerance=tolerance,
            max_iterations=_CONTACT_CONVOLUTIONS,
            start=self.loaded,
        )
        self.convolutions += solution.convolutions
        self.loaded = solution.index, solution.pressure
        self.pressure.ravel()[solution.index] = solution.pressure
        self.approach, self.solution = solution.approach, solution


class Body:
    """A body that yields: its plastic strain up to now, and its volume operator."""

    def __init__(
        self,
        material: Material,
        pixel: tuple[float, float],
        boundary: str,
        precision: str,
        workspace: Workspace,
    ) -> None:
        self.material, self.pixel = material, pixel
        self.boundary, self.precision, self._workspace = boundary, precision, workspace
        self.law = law_of(material)
        self.shear_modulus = material.young / (2 * (1 + material.poisson))
        self.real: type = np.float32 if precision == "single" else np.float64
        self.strain: Array = np.zeros((0, 5, 0, 0), self.real)
        self.accumulated: Array = np.zeros((0, 0), self.real)

    def resize(self, thickness: NDArray[np.float64], shape: tuple[int, int]) -> None:
        """Take on more layers below and more points around those there are."""
        self.operator = HalfSpace(
            shape, self.pixel, thickness,
            shear_modulus=self.shear_modulus, poisson=self.material.poisson,
            boundary=self.boundary, precision=self.precision, workspace=self._workspace,
        )  # fmt: skip
        old, accumulated = self.strain, self.accumulated
        ny, nx = old.shape[-2:]
        top, left = (shape[0] - ny) // 2, (shape[1] - nx) // 2
        place = np.s_[: len(old), ..., top : top + ny, left : left + nx]
        self.thickness, self.shape = thickness, shape
        self.strain = np.zeros((thickness.size, 5, *shape), self.real)
        self.strain[place] = old
        fields: Array = np.zeros((thickness.size, *shape), self.real)
        fields[place] = accumulated.reshape(len(old), ny, nx)
        self.accumulated = fields.reshape(thickness.size, -1)
        self._hardened(range(thickness.size))

    def _hardened(self, layers: range) -> None:
        if layers.start == 0:
            self._square_strength: Array = np.empty_like(self.accumulated)
            self._rows: list[slice | None] = [None] * len(layers)
        for layer in layers:
            strength = self.law.strength(self.accumulated[layer])
            # A square beyond the range of the numbers is one that no stress reaches.
            with np.errstate(over="ignore"):
                np.square(strength, out=self._square_strength[layer])
            rows = np.flatnonzero(self.strain[layer].any(axis=(0, 2)))
            self._rows[layer] = slice(int(rows[0]), int(rows[-1]) + 1) if rows.size else None

    def resume(self, old: PlasticBody) -> None:
        """Take over the plastic strain of a result."""
        self.strain[...] = old.plastic_strain
        self.accumulated[...] = old.accumulated.reshape(self.accumulated.shape)
        self._hardened(range(len(self.strain)))

    def displacement(
        self, places: Parts, added: Parts, *, trace: bool = False
    ) -> NDArray[np.float64]:
        """Return the surface displacement by the strain so far and some more."""
        nx = self.shape[1]

        def fill(layer: int, out: Array) -> slice | None:
            rows, place = self._rows[layer], places[layer]
            if not place.size:
                if rows is not None:
                    out[...] = self.strain[layer]
                return rows
            out[...] = self.strain[layer]
            out.reshape(5, -1)[:, place] += added[layer]
            low, high = int(place[0] // nx), int(place[-1] // nx) + 1
            if rows is None:
                return slice(low, high)
            return slice(min(low, rows.start), max(high, rows.stop))

        return self.operator.displacement(fill, trace=trace)

    def flow(self, pressure: Array, places: Parts, added: Parts) -> tuple[Parts, Parts]:
        """Return where the stress is returned to the yield surface, and the strain that does it.

        Parameters
        ----------
        pressure : ndarray, shape (ny, nx)
            Pressure on the surface [Pa].
        places, added : list of ndarray, shapes (n,) and (5, n)
            Pixels of each layer, ascending, and the strain of this increment in the stress.

        Returns
        -------
        places, strain : list of ndarray
            The same, after the return; no pixel is lost.
        """
        new_places: Parts = [np.empty(0, np.int64)] * len(places)
        flowed: Parts = [np.empty((5, 0), self.real)] * len(places)
        twice = self.real(2 * self.shear_modulus)

        def visit(layer: int, stress: Array) -> None:
            trial, place = stress.reshape(5, -1), places[layer]
            if place.size:
                trial[:, place] += twice * added[layer]
            square = trial[1] * trial[1]
            for component in trial[2:]:
                square += component * component
            square *= 3
            square += self.real(2.25) * (trial[0] * trial[0])
            yields = square > self._square_strength[layer]
            yields[place] = True
            place = np.flatnonzero(yields)
            if not place.size:
                return
            q = np.sqrt(square[place])
            step = plastic_increment(
                q, self.accumulated[layer, place], self.law, self.shear_modulus
            )
            factor = self.real(1.5) * step / np.where(q > 0, q, 1)
            new_places[layer], flowed[layer] = place, trial[:, place] * factor

        self.operator.stress(pressure, visit)
        return new_places, flowed

    def accept(self, places: Parts, added: Parts) -> None:
        """Add the strain of an increment."""
        for layer, (place, strain) in enumerate(zip(places, added, strict=True)):
            if place.size:
                self.strain[layer].reshape(5, -1)[:, place] += strain
                self.accumulated[layer, place] += _equivalent_strain(strain)
        self._hardened(range(len(self.strain)))

    @property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        cells = np.count_nonzero(self.accumulated, axis=1)
        dy, dx = self.pixel
        return float(cells @ self.thickness) * dy * dx

    def finished(self, pressure: Array, margin: int) -> tuple[PlasticBody, float]:
        """Return the body with its stresses, and how far the stress passes the yield strength."""
        fields = self.strain.shape[0], *self.strain.shape[2:]
        excess = np.full(fields[0], -1.0)
        stress, residual = np.empty_like(self.strain), np.empty_like(self.strain)
        mean, mean_residual = np.empty(fields, self.real), np.empty(fields, self.real)

        def keep(layer: int, values: Array) -> None:
            stress[layer] = values
            q = plastic.equivalent(values).ravel()
            excess[layer] = np.sqrt((q * q / self._square_strength[layer]).max()) - 1

        nothing = np.zeros(fields[1:])
        self.operator.stress(pressure, keep)
        self.operator.mean_stress(pressure, lambda layer, v: np.copyto(mean[layer], v))
        self.operator.stress(nothing, lambda layer, v: np.copyto(residual[layer], v))
        self.operator.mean_stress(nothing, lambda layer, v: np.copyto(mean_residual[layer], v))
        dy, dx = self.pixel
        body = PlasticBody(
            self.material, dy * dx, margin, self.thickness, self.strain,
            self.accumulated.reshape(fields), stress, mean, residual, mean_residual,
        )  # fmt: skip
        return body, float(excess.max())


def law_of(body: Material) -> Hardening:
    """Return the law of hardening of a material, perfect plasticity without one."""
    return body.hardening or Perfect(body.yield_strength or math.inf)


def _equivalent_strain(strain: Array) -> Array:
    """Return √(2/3 e:e) of traceless strains, shape (5, n)."""
    result: Array = plastic.equivalent(strain) * strain.dtype.type(2 / 3)
    return result


class Loop:
    """The loop over increments and iterations."""

    def __init__(
        self,
        problem: Problem,
        contact: Contact,
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
                changes[part] = _equivalent_strain(defect[part]).max()
                sizes[part] = _equivalent_strain(x[part]).max()

        self._workspace.each(measure, range(len(x)))
        least = max(body.law.initial / (2 * body.shear_modulus) for body in self.bodies)
        return float(changes.max() / max(least, sizes.max()))
