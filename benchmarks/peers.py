"""This program beside its peers: the same problems, one table, one independent certificate.

    python benchmarks/peers.py                     # the cases of docs/evidence/performance.md
    python benchmarks/peers.py --cases rough-512-ceiling rough-512-elastic --limit 300

Runs every program that is installed, each solve in a process of its own, in alternation with one
plain padded ``scipy.fft.rfft2`` + ``irfft2`` pair of the same grid, whose median time T_pair is the
unit of the last column. Nothing is installed. Peers (ContactMechanics, Tamaas, ASPHER) may live in
another environment: ``--peer-python`` names its interpreter.

The certificate uses NumPy and SciPy alone: no code of any program in the table.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy.fft

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
# Each at the tolerance of its own that brings the certificate to about 1e-6, found by trial:
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


def peak_memory() -> float:
    """Return the largest resident memory of this process so far [MB = 10⁶ bytes]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) * 1024 / 1e6
    return math.nan


def worker(program: str, case: str, folder: Path, tolerance: float | None) -> None:
    """Solve one case with one program, in this process."""
    points, ceiling, precision = CASES[case]
    module = __import__(PROGRAMS[program])
    # What the import takes is not the solve's; the map itself is.
    before = peak_memory()
    load = load_of(case)
    path = folder / "heights.npy"
    if program == "roughcontact":
        pressure, seconds, more = run_roughcontact(path, load, ceiling, precision)
        return answer(folder, points, pressure, seconds, before, more, module)
    heights = np.load(path)
    if program == "contactmechanics":
        pressure, seconds, more = run_contactmechanics(heights, load, ceiling, tolerance or 0)
    elif program == "tamaas":
        pressure, seconds, more = run_tamaas(heights, load, ceiling, tolerance or 0)
    else:
        mode = program.partition("-")[2]
        pressure, seconds, more = run_aspher(heights, load, mode, tolerance or 0)
    return answer(folder, points, pressure, seconds, before, more, module)


def answer(
    folder: Path,
    points: int,
    pressure: np.ndarray,
    seconds: float,
    before: float,
    more: dict[str, object],
    module: object,
) -> None:
    """Write what a solve gave, and what it took."""
    more |= {"seconds": seconds, "above": peak_memory() - before}
    more["version"] = str(getattr(module, "__version__", "?"))
    np.save(folder / "pressure.npy", pressure.astype(np.float32 if points > 8192 else np.float64))
    (folder / "answer.json").write_text(json.dumps(more))


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


def pair_time(points: int) -> float:
    """Return the median time [s] of a padded rfft2 + irfft2 pair on all cores."""
    padded = np.zeros((2 * points, 2 * points))
    padded[:points, :points] = np.random.default_rng(0).random((points, points))
    workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    times = []
    for _ in range(3 if points > 4096 else 7):
        began = time.perf_counter()
        scipy.fft.irfft2(scipy.fft.rfft2(padded, workers=workers), padded.shape, workers=workers)
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def measure(
    program: str, case: str, folder: Path, python: str, limit: float, tolerance: float | None
) -> dict[str, object]:
    """Run one solve in a process of its own and judge it here."""
    for name in ("pressure.npy", "answer.json"):
        (folder / name).unlink(missing_ok=True)
    command = [python, __file__, "--worker", program, case, str(folder)]
    if tolerance is not None:
        command += ["--tolerance", repr(tolerance)]
    try:
        done = subprocess.run(command, timeout=limit, capture_output=True, text=True, check=False)
    except subprocess.TimeoutExpired:
        return {"failed": f"no answer in {limit:g} s"}
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        return {"failed": lines[-1] if lines else f"exit status {done.returncode}"}
    answer: dict[str, object] = json.loads((folder / "answer.json").read_text())
    if CASES[case][0] <= 8192:
        heights, pressure = np.load(folder / "heights.npy"), np.load(folder / "pressure.npy")
        answer["certificate"], answer["load_error"] = certificate(
            heights, pressure, load_of(case), CASES[case][1]
        )
    return answer


def installed(python: str, module: str) -> bool:
    """Return whether an interpreter can find a module."""
    if python == sys.executable:
        return importlib.util.find_spec(module) is not None
    probe = f"import importlib.util as u; raise SystemExit(u.find_spec({module!r}) is None)"
    return subprocess.run([python, "-c", probe], check=False).returncode == 0


def run_case(case: str, options: argparse.Namespace) -> list[dict[str, object]]:
    """Run one case with every program and print its part of the table."""
    points, ceiling, _ = CASES[case]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "heights.npy", heights_of(case))
        pairs = [pair_time(points)] if points <= 8192 else []
        for program, module in PROGRAMS.items():
            python = sys.executable if program == "roughcontact" else options.peer_python
            if options.programs and program not in options.programs:
                continue
            if not installed(python, module) or (ceiling and program.startswith("aspher")):
                continue
            own = PEER_TOLERANCE.get(program, (None, None))[ceiling is not None]
            tolerance = options.tolerance or own
            repeats = options.repeats if program == "roughcontact" else 1
            answers = []
            for _ in range(repeats):
                answers.append(measure(program, case, folder, python, options.limit, tolerance))
                if "failed" in answers[-1]:
                    break
                if points <= 8192:
                    pairs.append(pair_time(points))
            answers.sort(key=lambda answer: float(answer.get("seconds", math.inf)))
            rows.append({"case": case, "program": program, **answers[len(answers) // 2]})
    pair = statistics.median(pairs) if pairs else math.nan
    reference = float(rows[0].get("seconds", math.nan)) if rows else math.nan
    print(f"\n{case}: T_pair {1e3 * pair:.1f} ms", flush=True)
    for row in rows:
        row["pair"] = pair
        if "failed" in row:
            print(f"  {row['program']:18s} {row['failed']}", flush=True)
            continue
        seconds = float(row["seconds"])
        print(
            f"  {row['program']:18s} {seconds:9.3f} s  {seconds / pair:8.1f} T_pair"
            f"  {seconds / reference:8.1f} ×"
            f"  certificate {row.get('certificate', row.get('own', math.nan)):.1e}"
            f"  load error {row.get('load_error', math.nan):.1e}"
            f"  memory {row['above']:.0f} MB = {1e6 * float(row['above']) / points**2:.0f} B/pixel"
            f"  {row.get('convolutions', '')}",
            flush=True,
        )
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", nargs="+", choices=CASES, default=DEFAULT, metavar="CASE")
    parser.add_argument("--programs", nargs="+", choices=PROGRAMS)
    parser.add_argument("--peer-python", default=sys.executable)
    parser.add_argument("--limit", type=float, default=1800, help="seconds for one solve")
    parser.add_argument(
        "--repeats", type=int, default=3, help="solves of this program, median told"
    )
    parser.add_argument("--tolerance", type=float, help="tolerance argument of the peers")
    parser.add_argument("--json", type=Path, help="write all rows here")
    parser.add_argument("--worker", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        program, case, folder = options.worker
        worker(program, case, Path(folder), options.tolerance)
        return
    print(
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}"
    )
    rows = [row for case in options.cases for row in run_case(case, options)]
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
