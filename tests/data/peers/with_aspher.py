"""Solve the named problems with ASPHER 0.1.3 (`pip install aspher` after Debian's libeigen3-dev).

python with_aspher.py, in a separate environment; writes aspher.npz. It has no ceiling, and its
grids are squares of 64 × 2^k points.
"""

from importlib.metadata import version

import numpy as np
from problems import MODULUS, PROBLEMS, Problem, store


def solve(problem: Problem, backend: str, order: int) -> np.ndarray:
    """Return the pressure [Pa]."""
    import aspher

    heights = problem.heights
    found = aspher.solve_nested(
        grid_size=heights.shape[0],
        gap=np.ascontiguousarray(heights.max() - heights).ravel(),
        p_nominal=problem.load / (problem.size[0] * problem.size[1]),
        domain_size=problem.size[0],
        E_star=MODULUS,
        tol=1e-11,
        coarsest=64,
        q=order,
        backend=backend,
    )
    return np.array(found.pressure).reshape(heights.shape)


def main() -> None:
    """Solve all it can, and one with its own default operator."""
    answers = {}
    for name, problem in PROBLEMS.items():
        ny, nx = problem.heights.shape
        if problem.ceiling is None and ny == nx:
            backend = "fft" if problem.boundary == "free" else "periodic"
            answers["tight", name] = solve(problem, backend, 8)
            print(name, flush=True)
    answers["default operator: H², order 6", "rough-256"] = solve(PROBLEMS["rough-256"], "h2", 6)
    store("aspher", version("aspher"), answers)


if __name__ == "__main__":
    main()
