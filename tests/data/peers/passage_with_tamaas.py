"""Pass a sphere over the half-space with Tamaas 2.9.0 (`pip install tamaas scipy`).

python passage_with_tamaas.py, in a separate environment; writes tamaas_passage.npz. Takes some
minutes: the wheel has one thread. The strain stays in the model; each place has a contact of its
own with the surface that has moved there. A loop keeps the residual displacement in the surface of
its contact and adds to it what the strain of a load adds: the next surface has to bring it along.
"""

import time

import numpy as np
from indentation import DEPTH, HARDENING, POISSON, SIDE, YIELD, YOUNG
from indentation_with_tamaas import CONTACT, INNER, MEMORY, SETTINGS, TOLERANCE
from passage import LOAD, NODES, PLACES, POINTS, Answer, heights, store


def solve() -> Answer:
    """Return the answer."""
    import tamaas
    from tamaas.nonlinear_solvers import DFSANESolver

    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(
        tamaas.model_type.volume_2d, [DEPTH, SIDE, SIDE], [NODES, POINTS, POINTS]
    )
    model.E, model.nu = YOUNG, POISSON
    law = tamaas.materials.IsotropicHardening(model, sigma_y=YIELD, hardening=HARDENING)
    inner = DFSANESolver(tamaas.Residual(model, law))
    inner.tolerance = INNER
    kind = tamaas.PolonskyKeerRey.pressure
    pressure, largest, seconds, error = [], [], [], []
    displacement = np.zeros((POINTS, POINTS))
    for place in PLACES:
        surface = np.ascontiguousarray(heights(place) - displacement)
        contact = tamaas.PolonskyKeerRey(model, surface, CONTACT, kind, kind)
        loop = tamaas.AndersonMixing(contact, inner, TOLERANCE, memory=MEMORY)
        began = time.perf_counter()
        error.append(loop.solve(LOAD / SIDE**2))
        seconds.append(time.perf_counter() - began)
        displacement = heights(place) - np.array(contact.surface).reshape(POINTS, POINTS)
        pressure.append(np.array(model.traction)[..., 2])
        strain = np.array(model["cumulated_plastic_strain"])
        largest.append(strain.max())
        print(
            f"place {place}: {seconds[-1]:.1f} s, error {error[-1]:.1e}, {largest[-1]:.5f}",
            flush=True,
        )
    return Answer(np.array(pressure), np.array(largest), strain, np.array(seconds), np.array(error))


def main() -> None:
    """Solve it."""
    import tamaas

    store("tamaas", tamaas.__version__, SETTINGS, solve())


if __name__ == "__main__":
    main()
