"""Flow through the gap of R(n) under a ceiling, beside a peer; and what a ceiling does to a seal.

``python benchmarks/leak.py`` lists steps, time and memory over grids, each in a process of its own;
``--peer PYTHON`` runs the peer `reynoldsflow` by the Python of an environment that has it, right
after each; ``--turned`` presses a turned face elastic and under a ceiling.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

SIDE, LOAD, CEILING = 0.1e-3, 3.0, 3e9
STEEL = {"young": 210e9, "poisson": 0.3}

_PEER = """
import json, resource, sys, time
import numpy as np
from reynoldsflow import transport
transport.warmup_numba_functions()
gap = np.load(sys.argv[1])
wall, cpu = time.perf_counter(), time.process_time()
filtered, pressure, flux = transport.solve_fluid_problem(gap)
flow, _ = transport.compute_total_flux(filtered, flux, gap.shape[0])
print(json.dumps({"k": float(flow), "wall": time.perf_counter() - wall,
                  "cpu": time.process_time() - cpu,
                  "MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))
"""


def gap(points: int) -> np.ndarray:
    """Return the gap of R(n), 0 where the bodies touch."""
    import roughcontact as rc

    heights, pixel = rc.reference_map(points)
    result = rc.solve(
        rc.Surface(heights, pixel),
        material=rc.Material(**STEEL),
        load=LOAD,
        ceiling=CEILING,
        boundary="periodic",
    )
    return np.where(result.contact, 0.0, np.maximum(result.gap, 0.0))


def own(path: str) -> None:
    """Print what the flow through a stored gap is and takes, along y, periodic along x."""
    from roughcontact.analyses.leak.flow import flow

    stored = np.load(path)
    pixel = SIDE / len(stored)
    wall, cpu = time.perf_counter(), time.process_time()
    found = flow(stored, (pixel, pixel), 0, (1,))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(
        json.dumps(
            {
                "k": found.permeability[0],
                "steps": found.steps,
                "unbalanced": found.unbalanced,
                "wall": time.perf_counter() - wall,
                "cpu": time.process_time() - cpu,
                "MiB": peak / 1024,
                "bytes a pixel": peak * 1024 / stored.size,
            }
        )
    )


def grids(points: list[int], peer: str | None) -> None:
    """Print a line for each grid, and one for the peer."""
    with tempfile.TemporaryDirectory() as folder:
        for n in points:
            path = Path(folder) / "gap.npy"
            np.save(path, gap(n))
            run = [sys.executable, __file__, "--own", str(path)]
            told = json.loads(subprocess.run(run, capture_output=True, check=True).stdout)
            print(n, json.dumps(told), "load", os.getloadavg()[0], flush=True)
            if peer is not None:
                run = [peer, "-c", _PEER, str(path)]
                other = json.loads(subprocess.run(run, capture_output=True, check=True).stdout)
                ratios = {name: other[name] / told[name] for name in ("wall", "cpu", "MiB")}
                off = abs(told["k"] / other["k"] - 1)
                print(n, "peer", json.dumps(other), "over own", ratios, "flow off by", off)


def turned(points: int) -> None:
    """Print what leaks across the grooves of a turned face, elastic and under a ceiling."""
    import roughcontact as rc

    edge = 0.8e-3 / points
    steel = rc.Material(210e9, 0.3)
    for seed in (0, 1, 2):
        surface = rc.generate(
            (points, points),
            (edge, edge),
            Sq="0.6 um",
            turning=("0.1 mm", "0.8 mm"),
            lay=0.0,
            rolloff_wavelength="50 um",
            cutoff_wavelength=8 * edge,
            rng=seed,
        )
        for boundary in ("periodic", "periodic-x"):
            for pressure in (25e6, 50e6, 100e6, 200e6):
                told = []
                for ceiling in (None, 1.2e9):
                    result = rc.solve(
                        surface,
                        material=steel,
                        load=pressure * 0.64e-6,
                        ceiling=ceiling,
                        boundary=boundary,
                    )
                    (step,) = rc.leakage(result, flow_axis="y").steps
                    share = step.contact_area / 0.64e-6
                    told.append((share, step.mean_gap, step.permeability[0][0]))
                for name, (share, mean, k) in zip(("elastic", "ceiling"), told, strict=True):
                    print(
                        f"{seed} {boundary} {pressure / 1e6:.0f} MPa {name}: contact "
                        f"{share:.2%}, mean gap {mean:.3g} m, k {k:.3g} m³"
                    )
                ratio = told[1][2] / told[0][2] if told[0][2] else float("nan")
                print(f"{seed} {boundary} {pressure / 1e6:.0f} MPa ratio {ratio:.3g}", flush=True)


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, nargs="+", default=[256, 512, 1024])
    parser.add_argument("--peer", metavar="PYTHON")
    parser.add_argument("--turned", type=int, metavar="POINTS")
    parser.add_argument("--own", metavar="FILE", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.own:
        own(asked.own)
    elif asked.turned:
        turned(asked.turned)
    else:
        grids(asked.points, asked.peer)


if __name__ == "__main__":
    main()
