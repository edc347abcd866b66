"""Named contact problems for programs of any kind, and how their answers are stored.

NumPy alone: the environments of the peers need nothing of this program.
"""

import json
import math
import platform
from dataclasses import dataclass
from pathlib import Path

import numpy as np

MODULUS = 210e9 / 0.91
SIDE = 1e-4
RADIUS = 1e-2


@dataclass(frozen=True)
class Problem:
    """Heights [m] over pixels (dy, dx) [m], pressed with a load [N] under a ceiling [Pa]."""

    heights: np.ndarray
    pixel: tuple[float, float]
    load: float
    ceiling: float | None = None
    boundary: str = "free"

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the sides (y, x) [m]."""
        ny, nx = self.heights.shape
        return ny * self.pixel[0], nx * self.pixel[1]


def _rough(ny: int, nx: int, size: tuple[float, float], shortest: float) -> np.ndarray:
    """Self-affine, H = 0.8: roll-off at a quarter of 0.1 mm, 0.2 µm rms."""
    q = np.hypot(np.fft.fftfreq(ny, size[0] / ny)[:, None], np.fft.rfftfreq(nx, size[1] / nx))
    amplitude = np.maximum(q, 4 / SIDE) ** -1.8
    amplitude[(q > 1 / shortest) | (q == 0)] = 0
    noise = np.random.default_rng(0).standard_normal((ny, nx))
    heights = np.fft.irfft2(np.fft.rfft2(noise) * amplitude, (ny, nx))
    return heights * (0.2e-6 / heights.std())


def _problem(name: str) -> Problem:
    kind, grid, *rest = name.split("-")
    ny, _, nx = grid.partition("x")
    shape = int(ny), int(nx or ny)
    boundary = "periodic" if "periodic" in rest else "free"
    size = (SIDE, SIDE) if shape[0] == shape[1] else (0.6 * SIDE, SIDE)
    pixel = size[0] / shape[0], size[1] / shape[1]
    if kind == "hertz":
        # The elastic contact covers a fifth of the map.
        radius = SIDE * math.sqrt(0.2 / math.pi)
        load = 4 * MODULUS * radius**3 / (3 * RADIUS)
        ceiling = 0.6 * 1.5 * load / (math.pi * radius**2)
        y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(shape, pixel, strict=True))
        heights = -(y[:, None] ** 2 + x**2) / (2 * RADIUS)
    else:
        heights = _rough(*shape, size, 8 * max(pixel))
        load, ceiling = (30.0, 10e9) if kind == "heavy" else (1.0, 3e9)
    return Problem(heights, pixel, load, ceiling if "ceiling" in rest else None, boundary)


NAMES = (
    "hertz-128",
    "hertz-128-ceiling",
    "rough-64",
    "rough-128",
    "rough-256",
    "rough-64-ceiling",
    "rough-128-ceiling",
    "rough-256-ceiling",
    "rough-96x128",
    "rough-96x128-ceiling",
    "rough-64-periodic",
    "rough-64-periodic-ceiling",
    "rough-128-periodic",
    "rough-128-periodic-ceiling",
    "heavy-64",
    "heavy-64-ceiling",
    "heavy-64-periodic",
    "heavy-64-periodic-ceiling",
)
PROBLEMS = {name: _problem(name) for name in NAMES}


def store(program: str, version: str, answers: dict[tuple[str, str], np.ndarray]) -> None:
    """Write pressures [Pa] by (settings, problem) next to this file: the loaded pixels alone."""
    arrays: dict[str, np.ndarray] = {}
    for (settings, name), pressure in answers.items():
        index = np.flatnonzero(pressure)
        arrays[f"{settings}/{name}/index"] = index.astype(np.uint32)
        arrays[f"{settings}/{name}/pressure"] = pressure.ravel()[index]
    about = {
        "program": program,
        "version": version,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
    arrays["about"] = np.array(json.dumps(about))
    np.savez_compressed(Path(__file__).with_name(f"{program}.npz"), **arrays)


def load(program: str) -> tuple[dict[str, str], dict[tuple[str, str], np.ndarray]]:
    """Return the file that `store` wrote."""
    answers = {}
    with np.load(Path(__file__).with_name(f"{program}.npz")) as stored:
        for key in stored.files:
            settings, _, rest = key.partition("/")
            name, _, what = rest.partition("/")
            if what != "index":
                continue
            pressure = np.zeros(PROBLEMS[name].heights.shape)
            pressure.ravel()[stored[key]] = stored[f"{settings}/{name}/pressure"]
            answers[settings, name] = pressure
        return json.loads(str(stored["about"])), answers
