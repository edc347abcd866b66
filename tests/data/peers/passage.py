"""A sphere that passes over a hardening half-space, for programs of any kind; stored answers.

Periodic, in units of the side and of Young's modulus, as in `indentation`. NumPy alone: the
environments of the peers need nothing of this program.
"""

import json
import platform
from dataclasses import dataclass
from pathlib import Path

import indentation
import numpy as np

# Nodes in depth and points along each side; how far the sphere has moved along x, in points.
NODES, POINTS = 24, 48
PLACES = (-3, -1, 1, 3)
# Between the second and the third load of the indentation: 5 points in the radius of the contact.
LOAD = 0.00125


@dataclass(frozen=True)
class Answer:
    """The answers of a program, place by place.

    Parameters
    ----------
    pressure : ndarray, shape (places, ny, nx)
        In units of Young's modulus.
    largest : ndarray, shape (places,)
        Largest accumulated plastic strain so far.
    strain : ndarray, shape (nodes, ny, nx)
        Accumulated plastic strain after the last place, at the nodes, the surface first.
    seconds, error : ndarray, shape (places,)
        Wall time, and the error of the program's own loop.
    """

    pressure: np.ndarray
    largest: np.ndarray
    strain: np.ndarray
    seconds: np.ndarray
    error: np.ndarray


def heights(place: int) -> np.ndarray:
    """Return the heights of the sphere that has moved to a place, over the edge and in again."""
    x = (np.arange(POINTS) - POINTS // 2) * indentation.SIDE / POINTS
    return np.roll(-(x[:, None] ** 2 + x**2) / (2 * indentation.RADIUS), place, axis=1)


def store(program: str, version: str, settings: str, answer: Answer) -> None:
    """Write an answer next to this file: pressures in double, strain in single, without zeros."""
    arrays = {name: getattr(answer, name) for name in ("largest", "seconds", "error")}
    for field, kind in (("pressure", np.float64), ("strain", np.float32)):
        values = getattr(answer, field)
        index = np.flatnonzero(values)
        arrays[field] = values.ravel()[index].astype(kind)
        arrays[f"{field} at"] = index.astype(np.uint32)
    about = {
        "program": program,
        "version": version,
        "settings": settings,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
    arrays["about"] = np.array(json.dumps(about))
    np.savez_compressed(Path(__file__).with_name(f"{program}_passage.npz"), **arrays)


def load(program: str) -> tuple[dict[str, str], Answer]:
    """Return the file that `store` wrote."""
    grid = POINTS, POINTS
    with np.load(Path(__file__).with_name(f"{program}_passage.npz")) as stored:
        fields = {"pressure": np.zeros((len(PLACES), *grid)), "strain": np.zeros((NODES, *grid))}
        for field, values in fields.items():
            values.ravel()[stored[f"{field} at"]] = stored[field]
        rest = {name: stored[name] for name in ("largest", "seconds", "error")}
        return json.loads(str(stored["about"])), Answer(**fields, **rest)
