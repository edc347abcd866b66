"""Indent the half-space with Tamaas 2.9.0 (`pip install tamaas scipy`).

python indentation_with_tamaas.py, in a separate environment; writes tamaas_indentation.npz.
Takes some minutes: the wheel has one thread.
"""

import time

import numpy as np
from indentation import (
    DEPTH,
    GRIDS,
    HARDENING,
    LOADS,
    POISSON,
    SIDE,
    YIELD,
    YOUNG,
    Answer,
    heights,
    store,
)

# Of the loop over contact and plastic strain, of the plastic strain, and of the contact.
TOLERANCE, INNER, CONTACT = 1e-4, 1e-8, 1e-10
MEMORY = 8
SETTINGS = (
    f"Anderson mixing of memory {MEMORY}, tolerances {TOLERANCE:g} (loop), {INNER:g} (DF-SANE), "
    f"{CONTACT:g} (contact)"
)


def solve(name: str, loads: tuple[float, ...] = LOADS, *, told: bool = False) -> Answer:
    """Return the answer to one grid."""
    import tamaas
    from tamaas.nonlinear_solvers import DFSANESolver

    tamaas.set_log_level(tamaas.LogLevel.error)
    nodes, points = GRIDS[name]
    model = tamaas.ModelFactory.createModel(
        tamaas.model_type.volume_2d, [DEPTH, SIDE, SIDE], [nodes, points, points]
    )
    model.E, model.nu = YOUNG, POISSON
    law = tamaas.materials.IsotropicHardening(model, sigma_y=YIELD, hardening=HARDENING)
    inner = DFSANESolver(tamaas.Residual(model, law))
    inner.tolerance = INNER
    surface = np.ascontiguousarray(heights(name))
    kind = tamaas.PolonskyKeerRey.pressure
    contact = tamaas.PolonskyKeerRey(model, surface, CONTACT, kind, kind)
    loop = tamaas.AndersonMixing(contact, inner, TOLERANCE, memory=MEMORY)
    pressure, strain, seconds, error = [], [], [], []
    for load in loads:
        began = time.perf_counter()
        error.append(loop.solve(load / SIDE**2))
        seconds.append(time.perf_counter() - began)
        pressure.append(np.array(model.traction)[..., 2])
        strain.append(np.array(model["cumulated_plastic_strain"]))
        if told:
            print(f"{name}, load {load:g}: {seconds[-1]:.1f} s, error {error[-1]:.1e}", flush=True)
    return Answer(np.array(pressure), np.array(strain), np.array(seconds), np.array(error))


def main() -> None:
    """Solve all."""
    import tamaas

    answers = {name: solve(name, told=True) for name in GRIDS}
    store("tamaas", tamaas.__version__, SETTINGS, answers)


if __name__ == "__main__":
    main()
