"""The stress under one pixel, from the closed forms that the streamed stress samples."""

import numpy as np

from roughcontact.halfspace import stress_kernels


def pixel_stress(shape, pixel, depth, poisson, direction="z"):
    """Return the stress at one depth under a unit traction on the pixel ``[0, 0]``."""
    y, x = ((np.arange(n + 1.0) - 0.5) * edge for n, edge in zip(shape, pixel, strict=True))
    if direction == "z":
        return np.stack([k.T for k in stress_kernels.uniform_pressure(x, y, depth, poisson)])
    parts = stress_kernels.uniform_parts(x, y, depth, poisson)
    kernels = stress_kernels.sum_parts(parts, poisson, 0.0, [(direction, 1.0)])
    return np.stack([kernel.T for kernel in kernels])
