"""Analyses of a contact: flow through the gap, partial slip, and the influence of the pixel.

    python benchmarks/joint.py leak --points 256 512 1024 --peer PYTHON
    python benchmarks/joint.py turned --points 512
    python benchmarks/joint.py slip --points 256 512 1024
    python benchmarks/joint.py slip --file FILE --pressure "50 MPa"     # a measured map, leveled
    python benchmarks/joint.py scales --points 1024

*leak* lists steps, time and memory of the flow through the gap of R(n), each in a separate process,
and those of `reynoldsflow` if PYTHON has it. *turned* gives the permeability of a turned face,
elastic and with a ceiling. *slip* compares partial slip (R(n), steel on steel, 1 N, friction 0.15,
half of the sliding force) with its contact: processor times, the smallest of three, and pairs of
transforms on the grid of the displacement operator (pairs on smaller grids in proportion to their
points). *scales* gives area, conductance (proportional to the stiffness in unloading), separation
of the mean planes, permeability and narrowest gap of a self-affine map and of the same map on
pixels two, four and eight times as large, without its finer waves, relative to the finest grid.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import roughcontact as rc
from measuring import make_parser, markdown, peak_memory, run_worker
from roughcontact.analyses.leak.flow import flow
from roughcontact.halfspace.convolution import Convolution
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.tangential import TangentialConvolution
from roughcontact.uncertainty.resolution import coarsen_pair

SIDE = 0.1e-3
STEEL = rc.Material(210e9, 0.3, 1e9)
ELASTIC = rc.Material(210e9, 0.3)
UNIT = rc.Conductor(1.0, 1.0)
FRICTION, REPEATS = 0.15, 3
T = TypeVar("T")

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
                  "MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1.024e-3}))
"""


def gap(points: int) -> np.ndarray:
    """Return the gap of R(n), 0 where the bodies touch."""
    surface = rc.Surface(*rc.reference_map(points))
    result = rc.solve(surface, material=STEEL, load=3.0, boundary="periodic")
    return np.where(result.contact, 0.0, np.maximum(result.gap, 0.0))


def worker(path: str) -> None:
    """Print the flow through a stored gap along y, periodic along x, with time and memory."""
    stored = np.load(path)
    pixel = SIDE / len(stored)
    wall, cpu = time.perf_counter(), time.process_time()
    found = flow(stored, (pixel, pixel), 0, (1,))
    row = {
        "k": found.permeability[0],
        "steps": found.steps,
        "unbalanced": found.unbalanced,
        "wall": time.perf_counter() - wall,
        "cpu": time.process_time() - cpu,
        "MB": peak_memory(),
        "bytes per point": 1e6 * peak_memory() / stored.size,
    }
    print(json.dumps(row))


def leak(options: argparse.Namespace) -> None:
    """Print a line for each grid, and one for the peer."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "gap.npy"
        for points in options.points:
            np.save(path, gap(points))
            own = run_worker(__file__, path)
            print(points, json.dumps(own), "load average", os.getloadavg()[0], flush=True)
            if options.peer is not None:
                run = [options.peer, "-c", _PEER, str(path)]
                peer = json.loads(subprocess.run(run, capture_output=True, check=True).stdout)
                ratios = {name: peer[name] / own[name] for name in ("wall", "cpu", "MB")}
                error = abs(own["k"] / peer["k"] - 1)
                print(points, "peer", json.dumps(peer), "over own", ratios, "flow off by", error)


def measure_turned_face(options: argparse.Namespace) -> None:
    """Print the permeability across the grooves of a turned face, elastic and with a ceiling."""
    points = options.points[-1]
    edge = 0.8e-3 / points
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
                rows = []
                for ceiling in (None, 1.2e9):
                    result = rc.solve(
                        surface,
                        material=ELASTIC,
                        load=pressure * 0.64e-6,
                        ceiling=ceiling,
                        boundary=boundary,
                    )
                    (step,) = rc.leakage(result, flow_axis="y").steps
                    share = step.contact_area / 0.64e-6
                    rows.append((share, step.mean_gap, step.permeability[0][0]))
                for name, (share, mean, k) in zip(("elastic", "ceiling"), rows, strict=True):
                    print(
                        f"{seed} {boundary} {pressure / 1e6:.0f} MPa {name}: contact "
                        f"{share:.2%}, mean gap {mean:.3g} m, k {k:.3g} m³"
                    )
                ratio = rows[1][2] / rows[0][2] if rows[0][2] else float("nan")
                print(f"{seed} {boundary} {pressure / 1e6:.0f} MPa ratio {ratio:.3g}", flush=True)


def time_call(call: Callable[[], T]) -> tuple[T, float]:
    """Return the result of a call, and its processor time [s]."""
    began = time.process_time()
    return call(), time.process_time() - began


def count_pairs(call: Callable[[], object], points: int) -> float:
    """Return the pairs of transforms of a call, in units of one on the largest grid."""
    pairs = [0.0]
    single, double = Convolution._apply, TangentialConvolution.gather

    def count(fields: int, operator: Convolution) -> None:
        pairs[0] += fields * operator.padded[0] * operator.padded[1] / points

    def one(self: Convolution, *arguments: Any) -> None:
        count(1, self)
        single(self, *arguments)

    def two(self: TangentialConvolution, *arguments: Any) -> Any:
        count(2, self)
        return double(self, *arguments)

    Convolution._apply, TangentialConvolution.gather = one, two  # type: ignore[method-assign]
    try:
        call()
    finally:
        Convolution._apply, TangentialConvolution.gather = single, double  # type: ignore[method-assign]
    return pairs[0]


def compare_slip(surface: rc.Surface, boundary: str, load: Any = 1.0) -> list[str]:
    """Return a row of the table of partial slip."""

    def solve_normal() -> rc.ContactResult:
        return rc.solve(
            surface,
            material=STEEL,
            counter_material=STEEL,
            load=load,
            boundary=boundary,
            calibrated=False,
        )

    contact = solve_normal()

    def slipped() -> rc.results.Tangential:
        return rc.tangential(contact, friction=FRICTION, force=0.5 * FRICTION * contact.load)

    grid = contact.pair.operators("double", Workspace())(contact.pair.shape, (1, 1)).padded
    pairs = [count_pairs(call, grid[0] * grid[1]) for call in (solve_normal, slipped)]
    times = []
    for _ in range(REPEATS):
        contact, normal = time_call(solve_normal)
        found, slip = time_call(slipped)
        times.append((normal, slip))
    normal, slip = (min(column) for column in zip(*times, strict=True))
    last = found.last
    return [
        f"{' × '.join(map(str, surface.shape))}, {boundary}",
        f"{normal:.3g} s, {pairs[0]:.0f}",
        f"{slip:.3g} s, {pairs[1]:.0f}",
        f"{slip / normal:.1f}, {pairs[1] / pairs[0]:.1f}",
        f"{contact.certificate:.1e}",
        f"{last.certificate:.1e}",
    ]


def measure_slip(options: argparse.Namespace) -> None:
    """Print the table of partial slip."""
    head = ["grid", "contact, pairs", "partial slip, pairs", "ratio of both", "certificate"]
    if options.file:
        measured = rc.read_surface(options.file).filled().leveled()
        rows = [compare_slip(measured, "free", rc.NominalPressure(options.pressure))]
    else:
        rows = [
            compare_slip(rc.Surface(*rc.reference_map(points)), boundary)
            for points in options.points
            for boundary in ("free", "periodic")
        ]
    print(markdown([*head, "tangential certificate"], rows))


def describe_joint(
    pair: rc.contact.pair.Pair, pressure: float, ceiling: float | None
) -> dict[str, float]:
    """Return the quantities of a joint under a nominal pressure."""
    result = rc.solve(
        pair.surface,
        load=rc.NominalPressure(pressure),
        material=STEEL,
        ceiling=ceiling,
        boundary="periodic",
    )
    (conducts,) = rc.conductance(result, UNIT, UNIT).steps
    (leaks,) = rc.leakage(result, flow_axis="x").steps
    place = leaks.constriction[1]
    return {
        "contact area": result.contact_fraction,
        "conductance": conducts.length,
        "separation": float(result.gap.mean()),
        "permeability": leaks.permeability[1][1],
        "narrowest gap": 0.0 if place is None else place.gap,
    }


def scales(options: argparse.Namespace) -> None:
    """Print a table for each pressure, elastic and with a ceiling."""
    points, side = options.points[-1], 0.5e-3
    pixel = side / points
    heights = rc.self_affine(
        (points, points),
        (pixel, pixel),
        rms_height=0.5e-6,
        hurst=0.8,
        rolloff_wavelength=side / 8,
        cutoff_wavelength=4 * pixel,
        rng=np.random.default_rng(1),
    )
    surface = rc.Surface(heights, (pixel, pixel))
    pairs = [rc.solve(surface, load=1.0, material=STEEL, boundary="periodic").pair]
    while len(pairs) < 4:
        pairs.append(coarsen_pair(pairs[-1]))
    for ceiling, pressure in ((None, 300e6), (None, 6e9), (3e9, 300e6), (3e9, 1e9)):
        rows = [describe_joint(pair, pressure, ceiling) for pair in pairs]
        share = rows[0]["contact area"]
        print(f"{pressure / 1e6:g} MPa, ceiling {ceiling}, {share:.1%} in contact")
        for name in rows[0]:
            ratios = (row[name] / rows[0][name] for row in rows)
            print(f"  {name:24}", *(f"{ratio:6.2f}" for ratio in ratios))


SUBJECTS = {"leak": leak, "turned": measure_turned_face, "slip": measure_slip, "scales": scales}


def main() -> None:
    """Print the lines of a subject."""
    parser = make_parser(__doc__)
    parser.add_argument("subject", choices=SUBJECTS, nargs="?")
    parser.add_argument("--points", type=int, nargs="+", default=[256, 512, 1024])
    parser.add_argument("--peer", metavar="PYTHON", help="interpreter with reynoldsflow")
    parser.add_argument("--file", help="map for the partial slip")
    parser.add_argument("--pressure", help="nominal pressure on it")
    parser.add_argument("--worker", metavar="FILE", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        worker(options.worker)
    else:
        SUBJECTS[options.subject or "leak"](options)


if __name__ == "__main__":
    main()
