"""The displacement operator of a map, on any grid."""

from __future__ import annotations

from roughcontact.halfspace import convolution
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.operator import Family

_BOUNDARIES = {"free": convolution.free, "periodic": convolution.periodic}


def operators(
    boundary: str,
    pixel: tuple[float, float],
    modulus: float,
    precision: str,
    workspace: Workspace,
) -> Family:
    """Return what makes the displacement operator of a map on any grid.

    Parameters
    ----------
    boundary : {"free", "periodic"}
        As for `solve`.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` of the map [m].
    modulus : float
        E* [Pa].
    precision : {"double", "single"}
        Arithmetic on the grid of the map.
    workspace : Workspace
        Threads and memory that they share.

    Returns
    -------
    callable
        ``operator(shape, (ky, kx))`` as `solver.solve` wants it.
    """

    def operator(shape: tuple[int, int], coarsening: tuple[int, int]) -> convolution.Convolution:
        coarse = (coarsening[0] * pixel[0], coarsening[1] * pixel[1])
        # On coarse grids the error of the grid outweighs that of the arithmetic.
        arithmetic = precision if coarsening == (1, 1) else "single"
        make = _BOUNDARIES[boundary]
        return make(shape, coarse, modulus, precision=arithmetic, workspace=workspace)

    return operator
