"""Solve the named problems with ContactMechanics 1.8.3 (`pip install ContactMechanics`).

python with_contactmechanics.py, in a separate environment; writes contactmechanics.npz.
"""

import math

import numpy as np
from problems import MODULUS, PROBLEMS, Problem, store


def solve(problem: Problem, tolerance: float | None) -> np.ndarray:
    """Return the pressure [Pa]; the program works in forces per pixel."""
    from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
    from ContactMechanics.Optimization import constrained_conjugate_gradients
    from SurfaceTopography import Topography

    kind = FreeFFTElasticHalfSpace if problem.boundary == "free" else PeriodicFFTElasticHalfSpace
    heights, (dy, dx) = problem.heights, problem.pixel
    area = dy * dx
    options: dict[str, float] = {}
    if tolerance is not None:
        slope = math.hypot(np.diff(heights, axis=0).std() / dy, np.diff(heights, axis=1).std() / dx)
        scale = problem.ceiling or 0.5 * MODULUS * slope
        options = {
            "pentol": tolerance * heights.std(),
            "forcetol": tolerance * scale * area,
            "thermotol": tolerance,
        }
    found = constrained_conjugate_gradients(
        kind(heights.shape, MODULUS, problem.size),
        Topography(heights, problem.size, periodic=problem.boundary == "periodic"),
        hardness=None if problem.ceiling is None else problem.ceiling * area,
        external_force=problem.load,
        **options,
    )
    return np.array(found.jac) / area


def main() -> None:
    """Solve all, and those of 128 points with the default tolerances too."""
    import ContactMechanics

    answers = {}
    for name, problem in PROBLEMS.items():
        answers["tight", name] = solve(problem, 1e-8 if problem.ceiling else 1e-10)
        print(name, flush=True)
    for name in ("rough-128", "rough-128-periodic"):
        answers["default tolerances", name] = solve(PROBLEMS[name], None)
    store("contactmechanics", ContactMechanics.__version__, answers)


if __name__ == "__main__":
    main()
