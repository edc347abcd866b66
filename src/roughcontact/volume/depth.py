"""Profiles and sections through bodies that have yielded, cut from their arrays."""

from __future__ import annotations

import numpy as np

from roughcontact.errors import InputError
from roughcontact.volume.plastic_body import PlasticBody, Window
from roughcontact.volume.profiles import DepthProfile, DepthSection, LayerProfile
from roughcontact.volume.result import ElastoplasticResult
from roughcontact.volume.shared_body import SharedBody


def most_strained(result: ElastoplasticResult, body: int = 0) -> tuple[int, int, int]:
    """Return where the plastic strain is largest below the map.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    body : int
        Which of its bodies.

    Returns
    -------
    (int, int, int)
        Layer, row and column on the map; those of the largest von Mises stress where nothing
        has yielded.

    Raises
    ------
    InputError
        If there is no such body.
    """
    held = _body(result, body)
    return held.most_strained(_map(result, held))


def profile(
    result: ElastoplasticResult, point: tuple[int, int] | None = None, body: int = 0
) -> DepthProfile:
    """Return plastic strain and stress over the depth below a point.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    point : (int, int), optional
        Row and column on the map; by default those of the largest plastic strain.
    body : int
        Which of the bodies that yield, the rough one first.

    Returns
    -------
    DepthProfile
        From the surface down.

    Raises
    ------
    InputError
        If there is no such body, or the point does not lie on the map.
    """
    held = _body(result, body)
    row, column = most_strained(result, body)[1:] if point is None else point
    shape = result.solution.pressure.shape
    if not (0 <= row < shape[0] and 0 <= column < shape[1]):
        raise InputError(
            f"must lie on the map of {shape} points, got {point!r}", argument="point", value=point
        )
    dy, dx = result.solution.surface.pixel
    where = row + held.margin, column + held.margin
    return DepthProfile(
        (int(row), int(column)), ((row + 0.5) * dy, (column + 0.5) * dx), *held.at(where)
    )


def cut(
    result: ElastoplasticResult, along: str = "x", index: int | None = None, body: int = 0
) -> DepthSection:
    """Return plastic strain and stress on a vertical plane.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    along : {"x", "y"}
        The horizontal axis of the plane.
    index : int, optional
        Row of the map that it follows, or its column with ``along="y"``; by default that of the
        largest plastic strain.
    body : int
        Which of the bodies that yield, the rough one first.

    Returns
    -------
    DepthSection
        Over the length of the map.

    Raises
    ------
    InputError
        If there is no such body, ``along`` is something else, or the plane misses the map.
    """
    held = _body(result, body)
    if along not in ("x", "y"):
        raise InputError(f"must be 'x' or 'y', got {along!r}", argument="along", value=along)
    axis = 1 if along == "x" else 0
    pressure, pixel = result.solution.pressure, result.solution.surface.pixel
    shape = pressure.shape
    chosen = most_strained(result, body)[2 - axis] if index is None else index
    if not 0 <= chosen < shape[1 - axis]:
        line = "row" if along == "x" else "column"
        raise InputError(
            f"must be a {line} of {shape[1 - axis]}, got {index!r}", argument="index", value=index
        )
    ends = slice(held.margin, held.margin + shape[axis])
    at = chosen + held.margin
    on_map = np.s_[chosen, :] if along == "x" else np.s_[:, chosen]
    faces, *fields = held.at((at, ends) if along == "x" else (ends, at))
    return DepthSection(
        along,
        int(chosen),
        (chosen + 0.5) * pixel[1 - axis],
        np.arange(shape[axis] + 1) * pixel[axis],
        faces,
        pressure[on_map],
        result.residual_displacement[on_map],
        *fields,
    )


def layers(result: ElastoplasticResult, body: int = 0) -> LayerProfile:
    """Return the largest plastic strain and stresses of each layer below the map.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    body : int
        Which of the bodies that yield, the rough one first.

    Returns
    -------
    LayerProfile
        From the surface down.

    Raises
    ------
    InputError
        If there is no such body.
    """
    held = _body(result, body)
    return held.of_layers(_map(result, held))


def _body(result: ElastoplasticResult, body: int) -> PlasticBody | SharedBody:
    if not 0 <= body < len(result.bodies):
        raise InputError(
            f"must be one of {len(result.bodies)} that yield, got {body!r}",
            argument="body",
            value=body,
        )
    return result.bodies[body]


def _map(result: ElastoplasticResult, body: PlasticBody | SharedBody) -> Window:
    """Return the rows and columns of the volume that lie below the map."""
    ny, nx = result.solution.pressure.shape
    first = body.margin
    return slice(first, first + ny), slice(first, first + nx)
