"""Marks that a tool leaves on a turned surface."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.surface.alignment import cosine_sine

Array = NDArray[np.float64]


def turned(
    shape: tuple[int, int],
    pixel: tuple[float, float],
    feed: float,
    nose_radius: float,
    lay: float = 0.0,
) -> Array:
    """Return the heights that a round tool leaves: grooves with parabolic floors, feed apart.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    feed : float
        Distance of the grooves [m]. Where they run along a side, the nearest distance is taken of
        which a whole number fits on the map.
    nose_radius : float
        Radius of the tool [m].
    lay : float
        Direction of the grooves [degrees], counter-clockwise from x as the map is drawn.

    Returns
    -------
    ndarray, shape (ny, nx)
        Heights [m] of zero mean, from floor to ridge f²/(8R).

    Raises
    ------
    InputError
        If the feed is not between four pixels and a side, or the tool smaller than half of it.

    References
    ----------
    Shaw, Metal Cutting Principles (2005), the ideal roughness f²/(8R) of turning

    Examples
    --------
    >>> grooves = turned((4, 64), (1e-6, 1e-6), feed=16e-6, nose_radius=0.4e-3, lay=90)
    >>> round(float(np.ptp(grooves)) / (16e-6**2 / (8 * 0.4e-3)), 2)  # pixel to pixel
    0.88
    """
    (ny, nx), (dy, dx) = shape, pixel
    cosine, sine = cosine_sine(lay)
    sides = ny * dy, nx * dx
    if not 4 * max(pixel) <= feed <= max(sides):
        raise InputError(
            f"has a feed of {feed:.4g} m, which must lie between four pixels, "
            f"{4 * max(pixel):.4g} m, and a side of the map, {max(sides):.4g} m",
            argument="turning",
        )
    if not feed <= 2 * nose_radius < math.inf:
        raise InputError(
            f"has a nose radius of {nose_radius:.4g} m, less than half the feed {feed:.4g} m",
            argument="turning",
        )
    if 0.0 in (cosine, sine):
        across = sides[0] if sine == 0 else sides[1]
        feed = across / max(round(across / feed), 1)
    # Rows count downwards where the map is drawn; middles of the pixels.
    up, right = -(np.arange(ny)[:, None] + 0.5) * dy, (np.arange(nx) + 0.5) * dx
    phase = (up * cosine - right * sine) / feed
    offset = (phase - np.floor(phase) - 0.5) * feed
    grooves: Array = offset * offset / (2 * nose_radius)
    grooves -= grooves.mean()
    return grooves


def joined(grooves: Array, roughness: Array, height: float) -> Array:
    """Return grooves with as much roughness between them as gives a root-mean-square height.

    Parameters
    ----------
    grooves, roughness : ndarray, shape (ny, nx)
        Of zero mean; the second of any scale.
    height : float
        Root-mean-square height Sq [m] of the sum.

    Returns
    -------
    ndarray, shape (ny, nx)
        Heights [m] of zero mean.

    Raises
    ------
    InputError
        If the grooves alone are higher.
    """
    own = float(np.mean(grooves * grooves))
    if own > height**2:
        raise InputError(
            f"must be at least {math.sqrt(own):.4g} m, the Sq of the grooves alone, got "
            f"{height:.4g} m; give a smaller feed or a larger nose radius",
            argument="Sq",
            value=height,
        )
    common = float(np.mean(grooves * roughness))
    square = float(np.mean(roughness * roughness))
    # The positive root of |grooves + scale · roughness|² = height².
    scale = (math.sqrt(common**2 + square * (height**2 - own)) - common) / square
    heights: Array = grooves + scale * roughness
    return heights
