"""Load a contact tangentially with Tamaas 2.9.0 (`pip install tamaas`).

python tangential_with_tamaas.py, in a separate environment; writes tamaas_tangential.npz. Its
half-space is pressed on a rigid flat: with ν = 0.5 pressure and traction are not coupled. Of its
solvers with friction PolonskyKeerTan reaches the conditions of Coulomb's law.
"""

import time
from pathlib import Path

import numpy as np
from problems import MODULUS, PROBLEMS

PROBLEM, FRICTION, PART, POISSON = "heavy-64-periodic", 0.2, 0.5, 0.5
STORED = Path(__file__).with_name("tamaas_tangential.npz")


def main() -> None:
    """Push along the rows with half of the force that slides: the first axis of Tamaas."""
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    problem = PROBLEMS[PROBLEM]
    length = max(problem.size)
    heights = np.ascontiguousarray((problem.heights - problem.heights.max()) / length)
    model = tamaas.ModelFactory.createModel(
        tamaas.model_type.surface_2d, [side / length for side in problem.size], list(heights.shape)
    )
    model.E, model.nu = 1 - POISSON**2, POISSON
    pressure = problem.load / (problem.size[0] * problem.size[1]) / MODULUS
    solver = tamaas.PolonskyKeerTan(model, heights, 1e-10, FRICTION)
    solver.max_iter = 5000
    began = time.process_time()
    solver.solve([PART * FRICTION * pressure, 0.0, pressure])
    print(f"{time.process_time() - began:.1f} s of one core")
    traction = np.moveaxis(np.array(model.traction), -1, 0)
    model.traction[..., 2] = 0
    model.solveNeumann()
    stick = np.hypot(*traction[:2]) < FRICTION * traction[2] * (1 - 1e-6)
    shift = np.array(model.displacement)[stick].mean(axis=0)[:2] * length
    index = np.flatnonzero(traction[2])
    values = traction.reshape(3, -1)[:, index] * MODULUS
    np.savez_compressed(STORED, index=index.astype(np.uint32), traction=values, shift=shift)


if __name__ == "__main__":
    main()
