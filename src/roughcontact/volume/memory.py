"""The memory that plasticity of the volume needs."""

from __future__ import annotations

from typing import Any

from roughcontact import memory
from roughcontact.halfspace import plastic
from roughcontact.halfspace.fft import default_workers
from roughcontact.halfspace.layers import SWEEP_POINTS
from roughcontact.halfspace.shares import TRAVELLING, Share
from roughcontact.volume.problem import Problem


def memory_estimate(
    shape: tuple[int, int],
    layers: int,
    *,
    bodies: int = 1,
    boundary: str = "free",
    precision: str = "single",
    ranks: int = 1,
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
    ranks : int
        On how many ranks the volume lies.

    Returns
    -------
    int
        Bytes of each, if a quarter of the volume yields.
    """
    real = 8 if precision == "double" else 4
    points = shape[0] * shape[1]
    padded = plastic.points_transformed(shape, boundary)
    # Spectra of strain and mean stress and the tables; strain, stresses, and what Anderson's
    # acceleration remembers of a quarter of the points. The bodies share what threads sweep with.
    swept = min(default_workers() * SWEEP_POINTS, padded / 4)
    volume = bodies * layers * (7.5 * padded + 35 * points) + (6 * layers + 28) * swept
    # What is on its way between ranks: a layer for each thread, or some, in six arrays.
    layer = max(TRAVELLING, default_workers() * 5 * real * padded)
    under_way = 0 if ranks == 1 else 6 * layer
    return int(real * volume) // ranks + under_way + 200 * points


def require(
    shape: tuple[int, int],
    layers: int,
    *,
    bodies: int = 1,
    boundary: str = "free",
    precision: str = "single",
    share: Share | None = None,
) -> None:
    """Raise `InsufficientMemoryError` unless a volume fits into the memory that is free.

    Parameters
    ----------
    shape, layers, bodies, boundary, precision
        As for `memory_estimate`.
    share : Share, optional
        Of the volume; without it this process holds all of it.
    """
    count, beside = (1, 1) if share is None else (share.count, share.beside)
    needed = beside * memory_estimate(
        shape, layers, bodies=bodies, boundary=boundary, precision=precision, ranks=count
    )
    points = memory.square_side(needed, shape)
    what = f"{shape[0]} × {shape[1]} points in {layers} layers"
    if count > 1:
        what += f" on {count} ranks, {beside} of them on this machine,"
    memory.require(
        needed,
        f"{what} need",
        advice=(f"a square grid of up to about {points} × {points} points fits, or fewer layers",),
    )


def fits(
    problem: Problem,
    share: Share,
    old: tuple[tuple[int, int], int],
    new: tuple[tuple[int, int], int],
) -> bool:
    """Return whether a volume may grow from some shape and number of layers to others."""
    more, less = (
        memory_estimate(*size, **given(problem), ranks=share.count) for size in (new, old)
    )
    return share.beside * (more - less) < memory.free()


def given(problem: Problem) -> dict[str, Any]:
    """Return what `require` has to know of a problem besides its grid."""
    return {
        "bodies": max(len(problem.yielding), 1),
        "boundary": problem.pair.boundary,
        "precision": problem.precision,
    }
