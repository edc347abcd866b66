"""Plastic flow in a body: strain, volume operator and return to the yield surface."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Pixel, Shape
from roughcontact.elastoplastic.volume_result import PlasticBody
from roughcontact.halfspace import fft, tensors
from roughcontact.halfspace.fft import Workspace, frequencies, half_frequencies
from roughcontact.halfspace.layers import Pull
from roughcontact.halfspace.plastic_halfspace import PlasticHalfSpace
from roughcontact.material.hardening import back_modulus, plastic_increment
from roughcontact.material.material import Material

Array = NDArray[Any]
Parts = list[Array]
Way = tuple[float, float]

# Share of a pixel within which a shift is treated as a whole number of pixels.
_WHOLE_PIXEL_TOLERANCE = 1e-6


class StrainSnapshot(NamedTuple):
    """Snapshot of the nonzero plastic strain of a body, layer by layer."""

    shape: tuple[int, int]
    places: Parts
    strain: Parts
    accumulated: Parts


class YieldingBody:
    """Yielding body with its accepted plastic strain and its volume operator."""

    def __init__(
        self,
        material: Material,
        pixel: Pixel,
        boundary: str,
        precision: str,
        workspace: Workspace,
        *,
        pulled: float = 1.0,
    ) -> None:
        # Sign of the traction on this body relative to that on the rough body.
        self._pulled = pulled
        # Sliding distance over the map [pixels]; fields are stored in coordinates of the body.
        self.slid: Way = (0.0, 0.0)
        self.material, self.pixel = material, pixel
        self.boundary, self.precision, self._workspace = boundary, precision, workspace
        self.law = material.law
        # Factor of Prager's back stress to the tensor of plastic strain.
        self._back = 2 / 3 * back_modulus(self.law)
        self.shear_modulus = material.young / (2 * (1 + material.poisson))
        self.real: type = np.float32 if precision == "single" else np.float64
        self.strain: Array = np.zeros((0, 5, 0, 0), self.real)
        self.accumulated: Array = np.zeros((0, 0), self.real)

    def resize(self, thickness: NDArray[np.float64], shape: Shape) -> None:
        """Enlarge the volume by layers below and points around; keep the strain."""
        self.operator = PlasticHalfSpace(
            shape,
            self.pixel,
            thickness,
            shear_modulus=self.shear_modulus,
            poisson=self.material.poisson,
            boundary=self.boundary,
            precision=self.precision,
            workspace=self._workspace,
        )
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
        self._update_strength(range(thickness.size))

    def _update_strength(self, layers: range) -> None:
        if layers.start == 0:
            self._square_strength: Array = np.empty_like(self.accumulated)
            self._rows: list[slice | None] = [None] * len(layers)
        for layer in layers:
            strength = self.law.strength(self.accumulated[layer])
            # An infinite square is correct: no stress reaches it.
            with np.errstate(over="ignore"):
                np.square(strength, out=self._square_strength[layer])
            rows = np.flatnonzero(self.strain[layer].any(axis=(0, 2)))
            self._rows[layer] = slice(int(rows[0]), int(rows[-1]) + 1) if rows.size else None

    def resume(self, strain: Array, accumulated: Array) -> None:
        """Set the plastic strain and the accumulated plastic strain, given on the map."""
        y, x = self._whole_way
        self.strain[...] = np.roll(strain, (-y, -x), (-2, -1))
        self.accumulated[...] = np.roll(accumulated, (-y, -x), (-2, -1)).reshape(
            self.accumulated.shape
        )
        self._update_strength(range(len(self.strain)))

    def snapshot(self) -> StrainSnapshot:
        """Return a snapshot of the accepted plastic strain."""
        places = [np.flatnonzero(layer) for layer in self.accumulated]
        return StrainSnapshot(
            self.shape,
            places,
            [s.reshape(5, -1)[:, index] for s, index in zip(self.strain, places, strict=True)],
            [flowed[index] for flowed, index in zip(self.accumulated, places, strict=True)],
        )

    def restore(self, held: StrainSnapshot) -> None:
        """Restore the strain of a snapshot in the present layers and points."""
        (ny, nx), (old_y, old_x) = self.shape, held.shape
        top, left = (ny - old_y) // 2, (nx - old_x) // 2
        self.strain[...] = 0
        self.accumulated[...] = 0
        for layer, old in enumerate(held.places):
            rows, columns = np.divmod(old, old_x)
            place = (rows + top) * nx + columns + left
            self.strain[layer].reshape(5, -1)[:, place] = held.strain[layer]
            self.accumulated[layer, place] = held.accumulated[layer]
        self._update_strength(range(len(self.strain)))

    def displacement(
        self, places: Parts, added: Parts, *, trace: bool = False
    ) -> NDArray[np.float64]:
        """Return the surface displacement by the accepted and the added strain."""
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

        return shift_field(self.operator.displacement(fill, trace=trace), self.slid)

    def _local_pressure(self, pressure: Array) -> Array:
        """Return a pressure on the map in coordinates of the body."""
        y, x = self.slid
        return shift_field(pressure, (-y, -x))

    @property
    def _whole_way(self) -> tuple[int, int]:
        return round(self.slid[0]), round(self.slid[1])

    def strain_on_map(self) -> tuple[Array, Array]:
        """Return the plastic strain and the accumulated plastic strain on the map."""
        accumulated = self.accumulated.reshape(-1, *self.shape)
        strain, accumulated = self._roll_to_map(self.strain, accumulated)
        return strain, accumulated

    def _roll_to_map(self, *fields: Array) -> list[Array]:
        """Return fields of the body on the map; the same arrays if the body has not slid."""
        if not any(self._whole_way):
            return list(fields)
        return [np.roll(field, self._whole_way, (-2, -1)) for field in fields]

    def _traction(self, pull: Pull) -> Pull:
        return self._pulled * pull[0], self._pulled * pull[1]

    def flow(self, pressure: Array, pull: Pull, places: Parts, added: Parts) -> tuple[Parts, Parts]:
        """Return the yielding points, and the strain that returns to the yield surface."""
        new_places: Parts = [np.empty(0, np.int64)] * len(places)
        flowed: Parts = [np.empty((5, 0), self.real)] * len(places)
        twice = self.real(2 * self.shear_modulus)

        def visit(layer: int, stress: Array) -> None:
            self._subtract_back_stress(stress, layer)
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

        self.operator.stress(self._local_pressure(pressure), visit, self._traction(pull))
        return new_places, flowed

    def _subtract_back_stress(self, stress: Array, layer: int) -> None:
        """Subtract the back stress of the accepted strain."""
        rows = self._rows[layer]
        if self._back and rows is not None:
            stress[:, rows] -= self.real(self._back) * self.strain[layer][:, rows]

    def accept(self, places: Parts, added: Parts) -> None:
        """Add the strain of an increment to the accepted strain."""
        for layer, (place, strain) in enumerate(zip(places, added, strict=True)):
            if place.size:
                self.strain[layer].reshape(5, -1)[:, place] += strain
                self.accumulated[layer, place] += equivalent_strain(strain)
        self._update_strength(range(len(self.strain)))

    @property
    def max_plastic_strain(self) -> float:
        """Largest accumulated plastic strain."""
        return float(self.accumulated.max())

    @property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        cells = np.count_nonzero(self.accumulated, axis=1)
        dy, dx = self.pixel
        return float(cells @ self.thickness) * dy * dx

    def final_layers(self, pressure: Array, pull: Pull, margin: int) -> tuple[PlasticBody, float]:
        """Return the layers with stresses, and the relative excess over yield strength."""
        fields = self.strain.shape[0], *self.strain.shape[2:]
        excess = np.full(fields[0], -1.0)
        stress, residual = np.empty_like(self.strain), np.empty_like(self.strain)
        mean, mean_residual = np.empty(fields, self.real), np.empty(fields, self.real)

        def store_layer(layer: int, values: Array) -> None:
            stress[layer] = values
            self._subtract_back_stress(values, layer)
            q = tensors.equivalent(values).ravel()
            excess[layer] = np.sqrt((q * q / self._square_strength[layer]).max()) - 1

        nothing, pull = np.zeros(fields[1:]), self._traction(pull)
        pressure = self._local_pressure(pressure)
        self.operator.stress(pressure, store_layer, pull)
        self.operator.mean_stress(pressure, lambda layer, v: np.copyto(mean[layer], v), pull)
        self.operator.stress(nothing, lambda layer, v: np.copyto(residual[layer], v))
        self.operator.mean_stress(nothing, lambda layer, v: np.copyto(mean_residual[layer], v))
        body = PlasticBody(
            self.material,
            self.pixel[0] * self.pixel[1],
            margin,
            self.thickness,
            *self.strain_on_map(),
            *self._roll_to_map(stress, mean, residual, mean_residual),
        )
        return body, float(excess.max())


def shift_field(field: NDArray[np.float64], way: Way) -> NDArray[np.float64]:
    """Return a field of a periodic map, shifted by pixels along y and x."""
    if not any(way):
        return field
    whole = round(way[0]), round(way[1])
    if max(abs(part - n) for part, n in zip(way, whole, strict=True)) < _WHOLE_PIXEL_TOLERANCE:
        return np.roll(field, whole, (0, 1))
    y, x = frequencies(field.shape[0])[:, None], half_frequencies(field.shape[1])
    waves = fft.rfft2(field) * np.exp(-2j * math.pi * (y * way[0] + x * way[1]))
    return fft.irfft2(waves, field.shape)


def equivalent_strain(strain: Array) -> Array:
    """Return √(2/3 e:e) of traceless strains, shape (5, n)."""
    return tensors.equivalent(strain) * strain.dtype.type(2 / 3)


def yield_strain(material: Material) -> float:
    """Return the equivalent elastic strain at first yield, σ_Y/(3μ).

    At a von Mises stress of σ_Y the elastic strain s/(2μ) has √(2/3 e:e) = σ_Y/(3μ): Simo and
    Hughes 1998, Computational Inelasticity, sec. 3.3.1, return by (q − σ_Y)/(3μ).
    """
    return float(material.law.initial) * 2 * (1 + material.poisson) / (3 * material.young)
