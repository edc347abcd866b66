"""Solve the named problems with Tamaas 2.9.0 (`pip install tamaas`).

python with_tamaas.py, in a separate environment; writes tamaas.npz. Lengths are in units of the
longer side and pressures in units of E*, but for the settings that name others.
"""

import numpy as np
from problems import MODULUS, PROBLEMS, Problem, store


def solve(
    problem: Problem, tolerance: float, length: float | None = None, pressure: float = MODULUS
) -> np.ndarray:
    """Return the pressure [Pa], found in units of a length [m] and a pressure [Pa]."""
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    length = length or max(problem.size)
    heights = problem.heights
    model = tamaas.ModelFactory.createModel(
        tamaas.model_type.basic_2d, [side / length for side in problem.size], list(heights.shape)
    )
    model.E, model.nu = MODULUS / pressure, 0.0
    surface = np.ascontiguousarray((heights - heights.max()) / length)
    if problem.ceiling is None:
        solver = tamaas.PolonskyKeerRey(model, surface, tolerance)
    else:
        solver = tamaas.KatoSaturated(model, surface, tolerance, problem.ceiling / pressure)
    if problem.boundary == "free":
        tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
        solver.setIntegralOperator("dcfft")
    solver.max_iter = 20000
    solver.solve(problem.load / (problem.size[0] * problem.size[1]) / pressure)
    return np.array(model.traction) * pressure


def main() -> None:
    """Solve all, and small ones in millimetres and megapascals.

    In metres and pascals the solver with a ceiling gave no answer within a minute.
    """
    import tamaas

    answers = {}
    for name, problem in PROBLEMS.items():
        answers["tight", name] = solve(problem, 1e-10)
        print(name, flush=True)
    for name in ("rough-64", "rough-64-ceiling"):
        answers["in mm and MPa", name] = solve(PROBLEMS[name], 1e-10, 1e-3, 1e6)
    store("tamaas", tamaas.__version__, answers)


if __name__ == "__main__":
    main()
