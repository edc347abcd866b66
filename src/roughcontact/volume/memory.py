"""The memory that plasticity of the volume needs."""

from __future__ import annotations

import math

from roughcontact.errors import InsufficientMemoryError
from roughcontact.halfspace import plastic
from roughcontact.halfspace.fft import default_workers
from roughcontact.halfspace.layers import SWEEP_POINTS


def memory_estimate(
    shape: tuple[int, int],
    layers: int,
    *,
    bodies: int = 1,
    boundary: str = "free",
    precision: str = "single",
) -> int:
    """Return about the memory that `solve_elastoplastic` needs.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    layers : int
        Number of layers.
    bodies : int
        How many of the two yield.
    boundary, precision
        As for `solve_elastoplastic`.

    Returns
    -------
    int
        Bytes, if a quarter of the volume yields.
    """
    real = 8 if precision == "double" else 4
    points = shape[0] * shape[1]
    padded = plastic.points_transformed(shape, boundary)
    # Spectra of strain and mean stress and the tables; strain, stresses, and what Anderson's
    # acceleration remembers of a quarter of the points. The bodies share what threads sweep with.
    swept = min(default_workers() * SWEEP_POINTS, padded / 4)
    volume = bodies * layers * (7.5 * padded + 35 * points) + (6 * layers + 28) * swept
    return int(real * volume) + 200 * points


def check_memory(
    shape: tuple[int, int], layers: int, bodies: int, boundary: str, precision: str
) -> None:
    """Raise `InsufficientMemoryError` unless a volume fits into the memory that is free."""
    import psutil

    needed = memory_estimate(shape, layers, bodies=bodies, boundary=boundary, precision=precision)
    free = psutil.virtual_memory().available
    if needed > free:
        gib = 2**30
        points = int(math.sqrt(free / needed * shape[0] * shape[1]))
        raise InsufficientMemoryError(
            f"{shape[0]} × {shape[1]} points in {layers} layers need about {needed / gib:.1f} GiB, "
            f"{free / gib:.1f} GiB are free; a square grid of up to about {points} × {points} "
            "points fits, or fewer layers"
        )
