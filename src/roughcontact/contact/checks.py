"""What has to hold before a contact is solved; each check says what, found, do."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact import memory
from roughcontact.contact.result import ContactResult
from roughcontact.errors import CapacityError, InputError, Mention, Part
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material
from roughcontact.solvers import tilt
from roughcontact.surface.surface import Surface


def check_bodies(
    surface: Surface,
    material: Material,
    counter_material: Material,
    counter_surface: Surface | None,
) -> None:
    """Raise `InputError` for bodies of another type."""
    for name, value, kind in (
        ("surface", surface, Surface),
        ("counter_surface", counter_surface, Surface),
        ("material", material, Material),
        ("counter_material", counter_material, Material),
    ):
        if not (isinstance(value, kind) or (name == "counter_surface" and value is None)):
            raise InputError(f"{name} must be a {kind.__name__}, got {type(value).__name__}")


def check_surfaces(surface: Surface, counter_surface: Surface | None) -> None:
    """Raise `InputError` for unhandled holes or surfaces on different grids."""
    for name, body in (("surface", surface), ("counter_surface", counter_surface)):
        if body is not None and body.missing and not body.holes_masked:
            raise InputError(
                f"{name} has {body.missing} missing points: fill them (.filled()), crop them away "
                "(.cropped(...)) or let them never touch (.masked())"
            )
    if counter_surface is None:
        return
    if counter_surface.shape != surface.shape or not np.allclose(
        counter_surface.pixel, surface.pixel, rtol=1e-9, atol=0
    ):
        raise InputError(
            f"has {counter_surface.shape} pixels of {counter_surface.pixel} m, "
            f"surface {surface.shape} of {surface.pixel} m: both bodies need the same grid",
            argument="counter_surface",
        )


def checked_moments(
    moments: tuple[float, float], load: float | None, boundary: Boundary, precision: str
) -> tuple[float, float]:
    """Return the moments as two numbers, or raise `InputError` if they cannot be balanced."""
    try:
        about_y, about_x = (float(moment) for moment in moments)
    except (TypeError, ValueError):
        about_y = about_x = math.nan
    if not (math.isfinite(about_y) and math.isfinite(about_x)):
        raise InputError(
            f"must be a pair (y, x) of numbers [N m], got {moments!r}",
            argument="moments",
            value=moments,
        )
    if load is None:
        raise InputError(
            "need a load to balance; give ",
            Mention("load"),
            " instead of ",
            Mention("approach"),
            argument="moments",
        )
    if boundary.periodic_axes:
        raise InputError(
            "need ", Mention("boundary", "free"), ": a tilt has no period", argument="moments"
        )
    if precision == "single":
        raise InputError(
            "need ", Mention("precision", "double"), " to be balanced to 1e-8", argument="moments"
        )
    return about_y, about_x


def check_balance(
    target: NDArray[np.float64],
    load: float,
    ceiling: float | NDArray[np.float64] | None,
    gap: NDArray[np.float64],
    surface: Surface,
) -> None:
    """Raise if no admissible pressure has its centre where the load acts."""
    touchable = np.isfinite(gap)
    y, x = (np.broadcast_to(v, gap.shape)[touchable] for v in tilt.levers(gap.shape, surface.pixel))
    share: float | NDArray[np.float64] = math.inf
    if ceiling is not None:
        part = np.asarray(ceiling) * (surface.pixel[0] * surface.pixel[1] / load)
        share = part[touchable] if part.ndim else float(part)
    side = max(surface.size)
    outside = tilt.excess(target, y, x, share) * side
    if outside > 0:
        at_y, at_x = target * side
        what = "points that can touch" if ceiling is None else "pressures up to the ceiling"
        raise CapacityError(
            f"moments = ({target[0] * load * side:.6g}, {target[1] * load * side:.6g}) N m put the "
            f"load of {load:.6g} N at ({at_y:.6g}, {at_x:.6g}) m from the centre of the map, "
            f"{outside:.3g} m beyond what {what} can balance; move it inwards"
        )


def check_start(start: ContactResult | ArrayLike, shape: tuple[int, int]) -> None:
    """Raise `InputError` unless a solve can start from this."""
    pressure = np.asarray(start.pressure if isinstance(start, ContactResult) else start)
    if pressure.dtype.kind not in "fiu":
        raise InputError(
            f"must be a ContactResult or a map of pressures [Pa], got {type(start).__name__}",
            argument="start",
        )
    if pressure.shape != shape:
        raise InputError(
            f"has {pressure.shape} pixels and the surface {shape}; "
            "start from a solution on the same grid",
            argument="start",
        )
    if not (np.isfinite(pressure).all() and (pressure >= 0).all()):
        raise InputError("must hold finite pressures that are not negative", argument="start")


def capacity(
    load: float,
    ceiling: float | NDArray[np.float64] | None,
    gap: NDArray[np.float64],
    area: float,
    valid: int,
) -> float:
    """Return the largest load that can be carried, or raise if this one is larger."""
    if ceiling is None:
        return math.inf
    if isinstance(ceiling, np.ndarray):
        capacity = float(ceiling[np.isfinite(gap)].sum()) * area
    else:
        capacity = ceiling * valid * area
    # The full capacity is a load like any other; rounding must not refuse it.
    if load > capacity * (1 + 1e-12):
        raise CapacityError(
            f"= {load:.6g} N is more than the surface can carry: the ceiling times the "
            f"area of its valid pixels is {capacity:.6g} N",
            argument="load",
        )
    return capacity


def memory_estimate(
    shape: tuple[int, int], *, boundary: str = "free", precision: str = "double"
) -> int:
    """Return the memory that `solve` needs beyond the surface itself.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    boundary, precision
        As for `solve`.

    Returns
    -------
    int
        Bytes, for a contact on a small part of the map; a map in full contact needs about
        twice as much.
    """
    real = 8 if precision == "double" else 4
    pixels = shape[0] * shape[1]
    # Initial gap and open gap, coarse grids, then the pressure that is returned.
    maps = 2 * real * pixels + real * pixels // 2 + 8 * pixels
    return Boundary(boundary).operator_memory(shape, precision) + maps


def check_memory(
    shape: tuple[int, int], *, boundary: str = "free", precision: str = "double"
) -> None:
    """Raise an error with a suggestion if a solve on this grid would not fit.

    Parameters
    ----------
    shape, boundary, precision
        As for `memory_estimate`.

    Raises
    ------
    InsufficientMemoryError
        If the estimate exceeds the memory that is free.
    """
    needed = memory_estimate(shape, boundary=boundary, precision=precision)
    points = memory.square_side(needed, shape)
    advice: tuple[Part, ...] = (f"a square grid of up to about {points} × {points} points fits",)
    if precision == "double":
        smaller = memory_estimate(shape, boundary=boundary, precision="single")
        if smaller < memory.free():
            advice += ("; ", Mention("precision", "single"), " fits the whole map")
    memory.require(needed, f"a map of {shape[0]} × {shape[1]} points needs", advice=advice)
