"""What holds of every result with plasticity of the volume, whatever file it comes from."""

from __future__ import annotations

import numpy as np

from roughcontact.contact.ranges import require_finite, require_not_negative
from roughcontact.errors import InputError, require_choice, require_positive
from roughcontact.volume.plastic_body import PlasticBody
from roughcontact.volume.result import CONVERGED, ElastoplasticResult

_TENSORS = ("plastic_strain", "stress", "residual_stress")
_FIELDS = ("accumulated", "mean_stress", "mean_residual_stress")
_NUMBERS = ("load", "contact_area", "max_pressure", "max_plastic_strain", "plastic_volume",
            "convolutions")  # fmt: skip


def check(result: ElastoplasticResult) -> None:
    """Raise `InputError` where numbers of a result contradict each other, or cannot be.

    Parameters
    ----------
    result : ElastoplasticResult
        As it was read; `roughcontact.contact.ranges.check` has seen its contact.

    Raises
    ------
    InputError
        The first that is found; it names what it is about.
    """
    require_choice(("double", "single"), precision=result.precision)
    require_positive(tolerance=result.tolerance)
    require_not_negative(seconds=result.seconds)
    require_finite("yield_excess", result.yield_excess, ())
    require_finite(
        "residual_displacement", result.residual_displacement, result.solution.pair.shape
    )
    if result.largest_pressure is not None:
        require_finite("largest_pressure", result.largest_pressure, result.solution.pair.shape)
        if not (result.increments and result.largest_pressure.min() >= 0):
            raise InputError("must not be negative, after increments", argument="largest_pressure")
    if not result.bodies:
        raise InputError("has none that yields", argument="bodies")
    for body in result.whole_bodies:
        _check_body(body, result.solution.pair.shape)
    _check_increments(result)


def _check_body(body: PlasticBody, shape: tuple[int, int]) -> None:
    if body.margin < 0:
        raise InputError(f"must not be negative, got {body.margin}", argument="margin")
    thickness = body.thickness
    if thickness.ndim != 1 or not thickness.size or not (thickness > 0).all():
        raise InputError("must be a row of positive numbers [m]", argument="thickness")
    require_finite("thickness", thickness, thickness.shape)
    grid = tuple(points + 2 * body.margin for points in shape)
    for name in _TENSORS:
        require_finite(name, getattr(body, name), (thickness.size, 5, *grid))
    for name in _FIELDS:
        require_finite(name, getattr(body, name), (thickness.size, *grid))
    if not (body.accumulated >= 0).all():
        raise InputError("must not be negative", argument="accumulated")


def _check_increments(result: ElastoplasticResult) -> None:
    """Refuse increments that end at another state, or beyond what was asked for."""
    load = result.solution.load
    last = result.increments[-1].load if result.increments else 0.0
    if last != load:
        raise InputError(
            f"= {load:.6g} N, but the last increment ends at {last:.6g} N", argument="load"
        )
    for step in result.increments:
        require_not_negative(**{name: getattr(step, name) for name in _NUMBERS})
        require_finite("approach", step.approach, ())
        if step.step_error is not None:
            require_not_negative(step_error=step.step_error)
        residuals = np.asarray(step.residuals)
        require_finite("residuals", residuals, residuals.shape)
        if not residuals.size or residuals.min() < 0:
            raise InputError("must be numbers that are not negative", argument="residuals")
    # Those before may be of another run, with another tolerance.
    if result.status == CONVERGED and result.increments:
        residual = result.increments[-1].residual
        if residual > result.tolerance:
            raise InputError(
                f"= {residual:.2g} is that of no settled increment: it may be "
                f"{result.tolerance:.2g}",
                argument="residual",
            )
