"""Curvature of the nominal body under a map, from what the map says of its own making."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.surface.alignment import cosine_sine
from roughcontact.surface.nominal import BODIES
from roughcontact.surface.provenance import Operation, Provenance

Array = NDArray[np.float64]

# Methods that leave the body under the roughness as it is.
_KEEP = frozenset(
    ("note", "without_outliers", "filled", "masked", "cropped", "largest_rectangle", "resampled",
     "indented")
)  # fmt: skip


def of(provenance: Provenance) -> Array | None:
    """Return the curvature of the nominal body that a map was given.

    Parameters
    ----------
    provenance : Provenance
        Where the map came from and what was done to it. A measured map and an array in memory are
        nominally flat: only the bodies of `surface.nominal` count, alone or under roughness.

    Returns
    -------
    ndarray, shape (2, 2), or None
        Second derivatives in (y, x) of the depth below the summit [1/m], convex positive; None
        where the body has no curvature at its summit (punch, cone, wedge), or a step has changed
        it in a way that is not known.
    """
    found = _made(provenance.origin)
    for step in provenance.operations:
        if found is None:
            return None
        if step.method == "with_form":
            form = of(step.arguments["form"])
            found = None if form is None else found + form
        else:
            found = _changed(found, step)
    return found


def _made(origin: Operation | None) -> Array | None:
    """Return the curvature of what made a map."""
    body = None if origin is None else BODIES.get(origin.method.removeprefix("nominal."))
    if origin is None or body is None:
        return np.zeros((2, 2))
    if body.curvatures is None:
        return None
    found = np.diag(body.curvatures(origin.arguments[body.size]))
    return _turned(found, origin.arguments["angle"]) if body.option == "angle" else found


def _changed(curvature: Array, step: Operation) -> Array | None:
    """Return what a step makes of a curvature."""
    given = step.arguments
    if step.method in _KEEP or not curvature.any():
        return curvature
    match step.method:
        case "leveled":
            # A plane has no curvature; a quadric takes all of it.
            return np.zeros((2, 2)) if given["form"] == "quadric" else curvature
        case "rotated":
            return _turned(curvature, given["angle"])
        case "aligned":
            if given["mirrored"]:
                curvature = curvature * [[1, -1], [-1, 1]]
            return _turned(curvature, given["angle"])
        case "filtered":
            # An S-filter of waves far shorter than the body leaves it as it is.
            return curvature if given["l"] is None else None
    return None


def _turned(curvature: Array, angle: float) -> Array:
    """Return a curvature turned by an angle [degrees], counter-clockwise; y points down."""
    c, s = cosine_sine(angle)
    turn = np.array([[c, -s], [s, c]])
    found: Array = turn @ curvature @ turn.T
    return found


def principal(curvature: Array) -> tuple[tuple[float, float], float]:
    """Return the principal radii of a curvature, and the direction of the first.

    Parameters
    ----------
    curvature : ndarray, shape (2, 2)
        As from `of`, positive semi-definite.

    Returns
    -------
    radii : (float, float)
        The larger first [m], infinite along a cylinder.
    angle : float
        Direction of the larger one, counter-clockwise from x [degrees], from 0 up to 180.

    Examples
    --------
    >>> principal(np.array([[200.0, 0.0], [0.0, 0.0]]))
    ((inf, 0.005), 0.0)
    """
    values, vectors = np.linalg.eigh(curvature)
    small, large = (float(value) for value in values)
    if small <= _STRAIGHT * large:
        small = 0.0
    y, x = (float(part) for part in vectors[:, 0])
    angle = math.degrees(math.atan2(-y, x)) % 180
    # Directions a rounding error off an axis are the axis.
    angle = round(angle, 9) % 180
    return (math.inf if small == 0 else 1 / small, 1 / large), angle


# Part of the larger curvature that rounding leaves of none.
_STRAIGHT = 1e-12
