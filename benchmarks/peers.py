"""This program and its peers: the same problems, one table, one independent certificate.

    python benchmarks/peers.py                     # the cases of docs/evidence/performance.md
    python benchmarks/peers.py --cases rough-512-ceiling rough-512-elastic --limit 300
    python benchmarks/peers.py --write             # store the rows in peers.json, renew the page

Runs every installed program, each solve in a separate process, alternating with a padded pair of
``scipy.fft.rfft2`` and ``irfft2`` on the same grid, whose median time T_pair is a unit of time.
Peers (ContactMechanics, Tamaas, ASPHER) may be in another environment: ``--peer-python`` names its
interpreter. The certificate uses NumPy and SciPy only, no code of any program in the table.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy.fft

from measuring import (
    Row,
    is_installed,
    machine,
    make_parser,
    markdown,
    merge_rows,
    pair_time,
    peak_memory,
    try_worker,
    write_parts,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STORED = Path(__file__).with_name("peers.json")

MODULUS = 210e9 / 0.91
SIDE = 1e-4
LOAD = 1.0
RADIUS = 1e-2

# name: (points, ceiling [Pa], precision)
CASES = {
    f"rough-{points}-{kind}": (points, 3e9 if kind == "ceiling" else None, "double")
    for points in (256, 512, 1024, 2048, 4096, 8192)
    for kind in ("ceiling", "elastic")
}
CASES |= {f"hertz-{points}": (points, None, "double") for points in (512, 1024, 2048)}
CASES["rough-16384-ceiling-single"] = (16384, 3e9, "single")
CASES["rough-8192-ceiling-single"] = (8192, 3e9, "single")
CASES["smoke"] = (64, 3e9, "double")
DEFAULT = [
    "rough-512-ceiling",
    "rough-512-elastic",
    "rough-1024-ceiling",
    "rough-1024-elastic",
    "rough-2048-ceiling",
    "rough-2048-elastic",
    "hertz-2048",
]

PROGRAMS = {
    "roughcontact": "roughcontact",
    "contactmechanics": "ContactMechanics",
    "tamaas": "tamaas",
    "aspher-active": "aspher",
    "aspher-fft": "aspher",
    "aspher-h2": "aspher",
}
# Each at the tolerance that brings the certificate to about 1e-6, found by trial:
# elastic, and with a ceiling.
PEER_TOLERANCE = {
    "contactmechanics": (1e-7, 1e-6),
    "tamaas": (1e-7, 1e-8),
    "aspher-active": (1e-8, None),
    "aspher-fft": (1e-8, None),
    "aspher-h2": (1e-8, None),
}
# Order of ASPHER's H² operator: its default of 6 leaves an error of 1e-5 against the exact kernel.
ASPHER_ORDER = 8


def heights_of(case: str) -> np.ndarray:
    """Return the heights [m] of a case."""
    points = CASES[case][0]
    if case.startswith("hertz"):
        x = (np.arange(points) - (points - 1) / 2) * SIDE / points
        return -(x[:, None] ** 2 + x**2) / (2 * RADIUS)
    from roughcontact.surface.random_surfaces import reference_map

    return reference_map(points)[0]


def load_of(case: str) -> float:
    """Return the load [N]; the Hertz contact covers a fifth of the map."""
    if case.startswith("hertz"):
        return 4 * MODULUS * (SIDE * math.sqrt(0.2 / math.pi)) ** 3 / (3 * RADIUS)
    return LOAD


# The programs. Each returns the pressure [Pa], [y, x], and the time of its solve.


def run_roughcontact(
    path: Path, load: float, ceiling: float | None, precision: str
) -> tuple[np.ndarray, float, dict[str, object]]:
    """Solve with this program, as a user calls it."""
    import roughcontact as rc

    surface = rc.read_surface(path, unit="m", size=(SIDE, SIDE))
    body = rc.Material(young=210e9, poisson=0.3)
    began = time.perf_counter()
    result = rc.solve(surface, load=load, material=body, ceiling=ceiling, precision=precision)
    seconds = time.perf_counter() - began
    return (
        result.pressure,
        seconds,
        {"convolutions": result.convolutions, "own": result.certificate},
    )


def run_contactmechanics(
    heights: np.ndarray, load: float, ceiling: float | None, tolerance: float
) -> tuple[np.ndarray, float, dict[str, object]]:
    """Solve with ContactMechanics, which works in forces per pixel."""
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.Optimization import constrained_conjugate_gradients
    from SurfaceTopography import Topography

    points = heights.shape[0]
    edge = SIDE / points
    slope = math.sqrt(
        (np.diff(heights, axis=0) ** 2).mean() / edge**2
        + (np.diff(heights, axis=1) ** 2).mean() / edge**2
    )
    scale = (ceiling if ceiling is not None else 0.5 * MODULUS * slope) * edge**2
    began = time.perf_counter()
    substrate = FreeFFTElasticHalfSpace((points, points), MODULUS, (SIDE, SIDE))
    found = constrained_conjugate_gradients(
        substrate,
        Topography(heights, (SIDE, SIDE)),
        hardness=None if ceiling is None else ceiling * edge**2,
        external_force=load,
        pentol=tolerance * heights.std(),
        forcetol=tolerance * scale,
        thermotol=tolerance,
        maxiter=100000,
    )
    return np.array(found.jac) / edge**2, time.perf_counter() - began, {}


def run_tamaas(
    heights: np.ndarray, load: float, ceiling: float | None, tolerance: float
) -> tuple[np.ndarray, float, dict[str, object]]:
    """Solve with Tamaas at E* = 1 and unit side: its saturated solver fails in SI units."""
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    shape = list(heights.shape)
    began = time.perf_counter()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], shape)
    model.E, model.nu = 1.0, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    surface = np.ascontiguousarray((heights - heights.max()) / SIDE)
    if ceiling is None:
        solver = tamaas.PolonskyKeerRey(model, surface, tolerance)
    else:
        solver = tamaas.KatoSaturated(model, surface, tolerance, ceiling / MODULUS)
    solver.setIntegralOperator("dcfft")
    solver.max_iter = 100000
    solver.solve(load / SIDE**2 / MODULUS)
    return np.array(model.traction) * MODULUS, time.perf_counter() - began, {}


def run_aspher(
    heights: np.ndarray, load: float, mode: str, tolerance: float
) -> tuple[np.ndarray, float, dict[str, object]]:
    """Solve with ASPHER on nested grids; it has no ceiling."""
    import aspher

    options = {
        "active": {"backend": "h2", "active_set": True},
        "fft": {"backend": "fft"},
        "h2": {"backend": "h2"},
    }[mode]
    gap = np.ascontiguousarray(heights.max() - heights).ravel()
    began = time.perf_counter()
    found = aspher.solve_nested(
        grid_size=heights.shape[0],
        gap=gap,
        p_nominal=load / SIDE**2,
        domain_size=SIDE,
        E_star=MODULUS,
        tol=tolerance,
        coarsest=64,
        q=ASPHER_ORDER,
        **options,
    )
    pressure = np.array(found.pressure).reshape(heights.shape)
    return pressure, time.perf_counter() - began, {}


def worker(program: str, case: str, folder: Path, tolerance: float) -> None:
    """Solve one case with one program, in this process."""
    points, ceiling, precision = CASES[case]
    module = __import__(PROGRAMS[program])
    # The memory of imports is not that of the solve; the map is.
    before = peak_memory()
    load = load_of(case)
    path = folder / "heights.npy"
    if program == "roughcontact":
        pressure, seconds, more = run_roughcontact(path, load, ceiling, precision)
    elif program == "contactmechanics":
        pressure, seconds, more = run_contactmechanics(np.load(path), load, ceiling, tolerance)
    elif program == "tamaas":
        pressure, seconds, more = run_tamaas(np.load(path), load, ceiling, tolerance)
    else:
        mode = program.partition("-")[2]
        pressure, seconds, more = run_aspher(np.load(path), load, mode, tolerance)
    more |= {"seconds": seconds, "above": peak_memory() - before}
    more["version"] = str(getattr(module, "__version__", "?"))
    np.save(folder / "pressure.npy", pressure.astype(np.float32 if points > 8192 else np.float64))
    print(json.dumps(more))


# The judge: plain NumPy and SciPy.


def coefficients(points: int, near: int = 16, order: int = 6) -> np.ndarray:
    """Return K [m/Pa] at offsets of 0 … points - 1 pixels.

    The closed form near the origin, elsewhere Gauss quadrature of 1/(π E* r) over the pixel, whose
    error is below (1 / (2 near))^(2 order).
    """
    edge = SIDE / points
    offset = np.arange(points) * edge
    nodes, weights = np.polynomial.legendre.leggauss(order)
    total = np.zeros((points, points))
    for s, w in zip(nodes, weights, strict=True):
        for t, v in zip(nodes, weights, strict=True):
            total += w * v / np.hypot(offset[:, None] + s * edge / 2, offset + t * edge / 2)
    total *= edge**2 / 4
    near = min(near, points)
    y, x, h = offset[:near, None], offset[:near], edge / 2

    def term(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        r1, r2 = np.hypot(u, v + h), np.hypot(u, v - h)
        return u * np.log1p(2 * h * (1 + 2 * v / (r1 + r2)) / (v - h + r2))

    total[:near, :near] = term(x + h, y) - term(x - h, y) + term(y + h, x) - term(y - h, x)
    return total / (math.pi * MODULUS)


def certificate(
    heights: np.ndarray, pressure: np.ndarray, load: float, ceiling: float | None
) -> tuple[float, float]:
    """Return ε and the load error of a pressure."""
    n = heights.shape[0]
    table = coefficients(n)
    unit = table[0, 0]
    # Even sequence of period 2n; the entry at n meets only zeros of the padding.
    wrapped = np.zeros((2 * n, 2 * n))
    wrapped[:n, :n] = table
    wrapped[n + 1 :, :n] = table[:0:-1]
    wrapped[:, n + 1 :] = wrapped[:, n - 1 : 0 : -1]
    spectrum = scipy.fft.rfft2(wrapped, workers=-1)
    del wrapped, table
    spectrum *= scipy.fft.rfft2(pressure, s=(2 * n, 2 * n), workers=-1)
    opened = scipy.fft.irfft2(spectrum, s=(2 * n, 2 * n), workers=-1)[:n, :n]
    opened = opened + (heights.max() - heights)
    limit = math.inf if ceiling is None else ceiling
    free = (pressure > 0) & (pressure < limit)
    if free.any():
        choices = [float(opened[free].mean()), float(np.median(opened[free]))]
    else:
        choices = [0.5 * float(opened[pressure >= limit].max() + opened[pressure <= 0].min())]
    norm = float(np.linalg.norm(pressure))
    errors = [
        float(np.linalg.norm(pressure - np.clip(pressure - (opened - w) / unit, 0, limit))) / norm
        for w in choices
    ]
    carried = float(pressure.sum(dtype=np.float64)) * (SIDE / n) ** 2
    return min(errors), abs(carried - load) / load


def measure(program: str, case: str, folder: Path, options: argparse.Namespace, python: str) -> Row:
    """Run one solve in a separate process and check it here."""
    stated = PEER_TOLERANCE.get(program, (None, None))[CASES[case][1] is not None]
    tolerance = options.tolerance or stated or 0
    words = (program, case, folder, tolerance)
    answer = try_worker(__file__, *words, python=python, limit=options.limit)
    if "failed" not in answer and CASES[case][0] <= 8192:
        heights, pressure = np.load(folder / "heights.npy"), np.load(folder / "pressure.npy")
        answer["certificate"], answer["load_error"] = certificate(
            heights, pressure, load_of(case), CASES[case][1]
        )
    return answer


def run_case(case: str, options: argparse.Namespace) -> list[Row]:
    """Run one case with every program and print its part of the table."""
    points, ceiling, _ = CASES[case]
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "heights.npy", heights_of(case))
        pairs = [pair_time(points)] if points <= 8192 else []
        for program, module in PROGRAMS.items():
            python = sys.executable if program == "roughcontact" else options.peer_python
            if options.programs and program not in options.programs:
                continue
            if not is_installed(python, module) or (ceiling and program.startswith("aspher")):
                continue
            answers: list[Row] = []
            for _ in range(options.repeats if program == "roughcontact" else 1):
                answers.append(measure(program, case, folder, options, python))
                if "failed" in answers[-1]:
                    break
                if points <= 8192:
                    pairs.append(pair_time(points))
            answers.sort(key=lambda answer: answer.get("seconds", math.inf))
            rows.append({"case": case, "program": program, **answers[len(answers) // 2]})
    pair = statistics.median(pairs) if pairs else None
    rows = [row | {"pair": pair} for row in rows]
    print(table(rows), flush=True)
    return rows


def table(rows: list[Row]) -> str:
    """Return the rows as Markdown."""
    own = {row["case"]: row.get("seconds") for row in rows if row["program"] == "roughcontact"}
    cells = []
    for row in rows:
        head = [row["case"], row["program"]]
        if "failed" in row:
            cells.append([*head, row["failed"], "", "", "", ""])
            continue
        certificate = f"{row.get('own', math.nan):.1e} (own)"
        if "certificate" in row:
            certificate = f"{row['certificate']:.1e}"
        seconds, pair = row["seconds"], row["pair"]
        cells.append(
            [
                *head,
                f"{seconds:.3g} s",
                "–" if pair is None else f"{seconds / pair:.1f}",
                f"{seconds / (own.get(row['case']) or math.nan):.3g}",
                certificate,
                f"{1e6 * row['above'] / CASES[row['case']][0] ** 2:.0f} B",
            ]
        )
    head = ("case", "program", "time", "in T_pair", "× roughcontact", "certificate")
    return markdown([*head, "memory per point"], cells)


def plot(rows: list[Row], figure: Figure) -> None:
    """Draw time over grid size, one line a program, with and without a ceiling."""
    panels = figure.subplots(1, 2, sharey=True)
    for axes, kind in zip(panels, ("elastic", "ceiling"), strict=True):
        drawn = [row for row in rows if row["case"].endswith(kind)]
        for program in dict.fromkeys(row["program"] for row in rows):
            chosen = sorted(
                (CASES[row["case"]][0], row["seconds"])
                for row in drawn
                if row["program"] == program and "seconds" in row
            )
            if chosen:
                axes.loglog(*zip(*chosen, strict=True), "o-", label=program)
        pairs = {CASES[row["case"]][0]: row["pair"] for row in drawn if row["pair"] is not None}
        if pairs:
            points = zip(*sorted(pairs.items()), strict=True)
            axes.loglog(*points, "k:", label="one plain FFT pair, T_pair")
        axes.set_xscale("log", base=2)
        axes.set_title("ceiling 3 GPa" if kind == "ceiling" else "elastic")
        axes.set_xlabel("points per side")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    panels[0].set_ylabel("time of one solve [s]")


def main() -> None:
    """Print the table."""
    parser = make_parser(__doc__)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=DEFAULT, metavar="CASE")
    parser.add_argument("--programs", nargs="+", choices=PROGRAMS)
    parser.add_argument("--peer-python", default=sys.executable)
    parser.add_argument("--limit", type=float, default=1800, help="seconds for one solve")
    parser.add_argument("--repeats", type=int, default=3, help="solves of this program")
    parser.add_argument("--tolerance", type=float, help="tolerance argument of the peers")
    parser.add_argument("--write", action="store_true", help="store the rows, renew the page")
    parser.add_argument("--worker", nargs=4, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        program, case, folder, tolerance = options.worker
        worker(program, case, Path(folder), float(tolerance))
        return
    print(machine())
    rows = [row for case in options.cases for row in run_case(case, options)]
    if options.write:
        write_parts("table", table(merge_rows(STORED, rows, CASES)))


if __name__ == "__main__":
    main()
