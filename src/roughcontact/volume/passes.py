"""What a pass of a counter-body does to bodies that yield: numbers, profiles, pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.facing import indented
from roughcontact.halfspace import tensors
from roughcontact.surface.bearing import core_parameters, material_ratio_curve
from roughcontact.surface.roughness import rms_height
from roughcontact.surface.surface import Surface
from roughcontact.volume.plastic_body import PlasticBody
from roughcontact.volume.result import ElastoplasticResult

Array = NDArray[Any]


def _nothing() -> Array:
    return np.zeros((0, 0))


@dataclass(frozen=True)
class Pass:
    """What one pass did.

    Parameters
    ----------
    flow : float
        Largest equivalent plastic strain that it added anywhere, there and back counted.
    gain : float
        Largest equivalent of the plastic strain that is left of that.
    max_pressure : float
        Largest pressure on the way [Pa].
    max_plastic_strain : float
        Largest accumulated plastic strain after it.
    max_residual_stress : float
        Largest von Mises stress by the plastic strain alone after it [Pa].
    max_residual_displacement : float
        Deepest point of the residual displacement after it [m], positive into the bodies.
    steps : int
        Increments that it took.
    contact_area, approach : float
        Largest on the way [m²], [m].
    Sq, Spk : float
        Of the heights after it [m]; see `rolled_surface`.
    shear : ndarray, shape (bodies, nz)
        Shear strain γ = 2 ε along the first pass that it added, layer by layer: what leans over to
        where the counter-body moved is positive. Its mean along the axes of the map that are
        periodic; along others the largest there is.
    residual_along, residual_across : ndarray, shape (bodies, nz)
        Normal stress by the plastic strain alone after it [Pa], along the pass and across it,
        taken in the same way.
    """

    flow: float
    gain: float
    max_pressure: float
    max_plastic_strain: float
    max_residual_stress: float
    max_residual_displacement: float
    steps: int = 0
    contact_area: float = 0.0
    approach: float = 0.0
    Sq: float = 0.0
    Spk: float = 0.0
    shear: Array = field(default_factory=_nothing, compare=False, repr=False)
    residual_along: Array = field(default_factory=_nothing, compare=False, repr=False)
    residual_across: Array = field(default_factory=_nothing, compare=False, repr=False)

    @property
    def largest_shear(self) -> float:
        """The largest of ``shear``, with its sign."""
        return _largest(self.shear)

    @property
    def in_plane_stress(self) -> float:
        """The largest of ``residual_along`` and ``residual_across`` [Pa]; tension is positive."""
        return _largest(np.concatenate([self.residual_along, self.residual_across]))


def told(result: ElastoplasticResult, before: ElastoplasticResult | None, direction: float) -> Pass:
    """Return what the pass between two states did.

    Parameters
    ----------
    result : ElastoplasticResult
        The state after it.
    before : ElastoplasticResult or None
        The state before it; None for the first.
    direction : float
        Where the counter-body moved on the first pass [degrees].
    """
    flow = gain = 0.0
    shear: list[Array] = []
    along: list[Array] = []
    across: list[Array] = []
    for number, body in enumerate(result.whole_bodies):
        old = None if before is None else before.whole_bodies[number]
        flow = max(flow, float((body.accumulated - _at(old, body, "accumulated")).max()))
        strain = body.plastic_strain - _at(old, body, "plastic_strain")
        gain = max(gain, 2 / 3 * float(tensors.equivalent(strain.swapaxes(0, 1)).max()))
        # A step aside of what lies above is a shear into the body.
        shear.append(_over_depth(result, body, -_shear(strain, direction)))
        for found, angle in ((along, direction), (across, direction + 90)):
            found.append(_over_depth(result, body, _normal(body, angle)))
    way = result.increments[0 if before is None else len(before.increments) :]
    heights = rolled_surface(result).heights
    return Pass(
        flow=flow,
        gain=gain,
        max_pressure=max(step.max_pressure for step in way),
        max_plastic_strain=result.max_plastic_strain,
        max_residual_stress=max(float(b.residual_von_mises.max()) for b in result.whole_bodies),
        max_residual_displacement=float(result.residual_displacement.max()),
        steps=len(way),
        contact_area=max(step.contact_area for step in way),
        approach=max(step.approach for step in way),
        Sq=rms_height(heights),
        Spk=core_parameters(*material_ratio_curve(heights))["Spk"],
        shear=np.array(shear),
        residual_along=np.array(along),
        residual_across=np.array(across),
    )


def rolled_surface(result: ElastoplasticResult) -> Surface:
    """Return the heights of the rough body after a path, free of load.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    Surface
        Its heights less the residual displacement; where the counter-body yields as well, the
        displacement of both, as a counter-body feels it that has kept its form.
    """
    return indented(result.solution.surface, result.residual_displacement)


@dataclass(frozen=True, eq=False)
class Frame:
    """A picture of a step.

    Parameters
    ----------
    number, step : int
        Which pass, and which of its steps.
    pressure : ndarray, shape (ny, nx)
        Contact pressure [Pa].
    strain : ndarray, shape (nz, n)
        Largest accumulated plastic strain of the rough body on each line across ``along``.
    """

    number: int
    step: int
    pressure: Array
    strain: Array


def frame(result: ElastoplasticResult, number: int, step: int, along: str) -> Frame:
    """Return the picture of a state, in seven digits.

    Parameters
    ----------
    result : ElastoplasticResult
        The state.
    number, step : int
        Which pass, and which of its steps.
    along : {"x", "y"}
        Axis of the map that stays.
    """
    body = result.whole_bodies[0]
    strain = _on_map(result, body, body.accumulated).max(axis=1 if along == "x" else 2)
    return Frame(
        number, step, result.solution.pressure.astype(np.float32), strain.astype(np.float32)
    )


def _at(old: PlasticBody | None, new: PlasticBody, name: str) -> Array:
    """Return a field of a state before, on the layers and points that there are by now."""
    wide: Array = np.zeros_like(getattr(new, name))
    if old is not None:
        values = getattr(old, name)
        ny, nx = values.shape[-2:]
        top, left = ((n - m) // 2 for n, m in zip(wide.shape[-2:], (ny, nx), strict=True))
        wide[: len(values), ..., top : top + ny, left : left + nx] = values
    return wide


def _shear(strain: Array, direction: float) -> Array:
    """Return γ between the depth and a direction, shape (nz, ny, nx)."""
    angle = math.radians(direction)
    sheared: Array = 2 * (strain[:, 3] * math.cos(angle) + strain[:, 4] * math.sin(angle))
    return sheared


def _normal(body: PlasticBody, direction: float) -> Array:
    """Return the residual stress normal to planes across a direction [Pa]."""
    angle, stress = math.radians(2 * direction), body.residual_stress
    mean: Array = body.mean_residual_stress - stress[:, 0] / 2
    return mean + stress[:, 1] * math.cos(angle) + stress[:, 2] * math.sin(angle)


def _on_map(result: ElastoplasticResult, body: PlasticBody, values: Array) -> Array:
    ny, nx = result.solution.pressure.shape
    first = body.margin
    part: Array = values[..., first : first + ny, first : first + nx]
    return part


def _over_depth(result: ElastoplasticResult, body: PlasticBody, values: Array) -> Array:
    """Return one value a layer: the mean along periodic axes, the largest along others."""
    axes = tuple(1 + axis for axis in result.solution.boundary.periodic_axes)
    mean = _on_map(result, body, values).mean(axis=axes, keepdims=True, dtype=float)
    lines = mean.reshape(len(values), -1)
    most: Array = lines[np.arange(len(lines)), np.abs(lines).argmax(axis=1)]
    return most


def _largest(values: Array) -> float:
    return float(values.ravel()[np.abs(values).argmax()]) if values.size else 0.0
