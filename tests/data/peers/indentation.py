"""A sphere that indents a hardening half-space, for programs of any kind; how answers are stored.

Periodic, in units of the side and of Young's modulus. NumPy alone: the environments of the peers
need nothing of this program.
"""

import json
import platform
from dataclasses import dataclass
from pathlib import Path

import numpy as np

YOUNG, POISSON = 1.0, 0.3
# Yield strength, and slope of it over the plastic strain.
YIELD, HARDENING = 0.02, 0.02
SIDE, DEPTH, RADIUS = 1.0, 0.4, 1.0
# One after the other: E* a/(σ_Y R) from 4 to 7.8, between first yield and full plasticity.
LOADS = tuple(0.0005 * step for step in range(1, 6))
# Nodes in depth, both faces included, and points along each side. The apex is a point.
GRIDS = {"sphere-32": (16, 32), "sphere-64": (32, 64)}


@dataclass(frozen=True)
class Answer:
    """The answers of a program, load by load.

    Parameters
    ----------
    pressure : ndarray, shape (loads, ny, nx)
        In units of Young's modulus.
    strain : ndarray, shape (loads, nodes, ny, nx)
        Accumulated plastic strain at the nodes, the surface first.
    seconds : ndarray, shape (loads,)
        Wall time.
    error : ndarray, shape (loads,)
        Of the program's own loop.
    """

    pressure: np.ndarray
    strain: np.ndarray
    seconds: np.ndarray
    error: np.ndarray


def heights(name: str) -> np.ndarray:
    """Return the heights of the sphere, a paraboloid."""
    points = GRIDS[name][1]
    x = (np.arange(points) - points // 2) * SIDE / points
    return -(x[:, None] ** 2 + x**2) / (2 * RADIUS)


def store(program: str, version: str, settings: str, answers: dict[str, Answer]) -> None:
    """Write answers next to this file: pressures in double, strains in single, without zeros."""
    arrays: dict[str, np.ndarray] = {}
    for name, answer in answers.items():
        for field, kind in (("pressure", np.float64), ("strain", np.float32)):
            values = getattr(answer, field)
            index = np.flatnonzero(values)
            arrays[f"{name}/{field}"] = values.ravel()[index].astype(kind)
            arrays[f"{name}/{field} at"] = index.astype(np.uint32)
        arrays[f"{name}/seconds"], arrays[f"{name}/error"] = answer.seconds, answer.error
    about = {
        "program": program,
        "version": version,
        "settings": settings,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
    arrays["about"] = np.array(json.dumps(about))
    np.savez_compressed(Path(__file__).with_name(f"{program}_indentation.npz"), **arrays)


def load(program: str) -> tuple[dict[str, str], dict[str, Answer]]:
    """Return the file that `store` wrote."""
    answers = {}
    with np.load(Path(__file__).with_name(f"{program}_indentation.npz")) as stored:
        for name, (nodes, points) in GRIDS.items():
            fields = {
                "pressure": np.zeros((len(LOADS), points, points)),
                "strain": np.zeros((len(LOADS), nodes, points, points)),
            }
            for field, values in fields.items():
                values.ravel()[stored[f"{name}/{field} at"]] = stored[f"{name}/{field}"]
            answers[name] = Answer(
                **fields, seconds=stored[f"{name}/seconds"], error=stored[f"{name}/error"]
            )
        return json.loads(str(stored["about"])), answers
