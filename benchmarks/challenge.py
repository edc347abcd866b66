"""The field's common problem: Müser's Contact-Mechanics Challenge, without its adhesion.

    python benchmarks/challenge.py                        # an own realization, 1024² to 4096²
    python benchmarks/challenge.py --largest 8192         # minutes and memory more
    python benchmarks/challenge.py --map container.zip    # the published surface, or any other
    python benchmarks/challenge.py --peers PYTHON         # and peers of that environment, 1024²

``--write`` renews challenge.json and the page.

The figure of docs/evidence/challenge.md is drawn from challenge.json. Parameters: Müser 2015,
arXiv:1512.02403; results of many groups, with adhesion: Müser et al. 2017, Tribology Letters 65,
118, doi:10.1007/s11249-017-0900-2.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

import roughcontact as rc
from measuring import EVIDENCE, ROOT, make_parser, markdown, write_parts
from roughcontact.surface.spectrum import radial_spectrum
from roughcontact.uncertainty.resolution import limits

Array = NDArray[np.float64]

STORED = Path(__file__).with_name("challenge.json")
PAGE = EVIDENCE / "challenge.md"
PEERS = ROOT / "tests" / "data" / "peers"

SIDE, ROLLOFF, CUTOFF, HURST = 0.1e-3, 20e-6, 0.1e-6, 0.8
MODULUS, PRESSURE, GRADIENT = 25e6, 250e3, 1.0
ENERGY, RANGE = 50e-3, 2.071e-9
POINTS = 2048
LOADS = tuple(PRESSURE * factor for factor in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 40))
BODY = rc.Material(young=MODULUS, poisson=0.0)

QUANTITIES = {
    "contact": "contact fraction",
    "corrected": "perimeter-corrected",
    "gap": "mean gap [µm]",
    "stiffness": "stiffness [E*/Sq]",
    "peak": "largest pressure [E*]",
}

_PEER = """
import importlib, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
import problems
program = importlib.import_module("with_" + sys.argv[2])
heights = np.load(sys.argv[3])
pixel = (float(sys.argv[4]) / len(heights),) * 2
load = float(sys.argv[5]) * float(sys.argv[4]) ** 2 * problems.MODULUS
pressure = program.solve(problems.Problem(heights, pixel, load, None, "periodic"), 1e-10)
np.save(sys.argv[3], pressure / problems.MODULUS)
"""


@dataclass(frozen=True)
class Row:
    """The numbers of one solve; pressures in E*, lengths in µm, stiffness per area in E*/Sq."""

    points: int
    load: float
    contact: float
    corrected: float
    gap: float
    stiffness: float
    peak: float
    spots: int
    certificate: float
    seconds: float


def moments(heights: Array, side: float) -> tuple[float, float, float]:
    """Return rms height [m], rms gradient and R_c [m] of a periodic map by its Fourier sums.

    R_c is the reciprocal rms curvature along a line: of an isotropic map ⟨h_xx²⟩ = 3/8 ⟨(∇²h)²⟩.
    """
    ny, nx = heights.shape
    power = np.abs(scipy.fft.fft2(heights - heights.mean()) / heights.size) ** 2
    q = 2 * math.pi * np.fft.fftfreq(ny, side / ny)[:, None]
    squared = q**2 + (2 * math.pi * np.fft.fftfreq(nx, side / nx)) ** 2
    height, gradient, curvature = (float((power * squared**n).sum()) ** 0.5 for n in range(3))
    return height, gradient, 1 / (curvature * math.sqrt(3 / 8))


def generate(seed: int) -> Array:
    """Return a realization [m] on 2048² points, scaled to the rms gradient of the challenge."""
    heights = rc.self_affine(
        POINTS,
        SIDE / POINTS,
        rms_height=1e-6,
        hurst=HURST,
        rolloff_wavelength=ROLLOFF,
        cutoff_wavelength=CUTOFF,
        rng=np.random.default_rng(seed),
    )
    return heights * (GRADIENT / moments(heights, SIDE)[1])


def sampled(heights: Array, points: int) -> Array:
    """Return a periodic, band-limited square map on another number of points."""
    known = len(heights)
    if points <= known:
        return heights[:: known // points, :: known // points]
    spectrum = np.zeros((points, points // 2 + 1), complex)
    waves = scipy.fft.rfft2(heights) * (points / known) ** 2
    half = known // 2
    spectrum[:half, :half] = waves[:half, :half]
    spectrum[1 - half :, :half] = waves[1 - half :, :half]
    return scipy.fft.irfft2(spectrum, (points, points), workers=-1)


def solve(
    heights: Array, side: float, pressure: float, tolerance: float = 1e-6
) -> tuple[Row, rc.ContactResult]:
    """Solve a periodic map under a nominal pressure [Pa]."""
    began = time.perf_counter()
    points = len(heights)
    result = rc.solve(
        rc.Surface(heights, (side / points,) * 2),
        load=rc.NominalPressure(pressure),
        material=BODY,
        boundary="periodic",
        tolerance=tolerance,
    )
    seconds = time.perf_counter() - began
    return Row(
        points,
        pressure / MODULUS,
        result.contact_fraction,
        result.perimeter_corrected_area / result.nominal_area,
        result.mean_gap * 1e6,
        result.stiffness() / side**2 * float(heights.std()) / MODULUS,
        result.max_pressure / MODULUS,
        result.spots().count,
        result.certificate,
        seconds,
    ), result


def histogram(values: Array, edges: Array) -> list[float]:
    """Return the number of values per unit between edges, over the number of all points."""
    return (np.histogram(values, edges)[0] / np.diff(edges)).tolist()


def distributions(result: rc.ContactResult) -> dict[str, Any]:
    """Return the distributions of pressure, gap and spot size, and the spectrum of the stress.

    Probability densities are those of the whole map over p/E* and gap/µm; spots are counted per
    µm² of the map and µm² of their area; the spectrum is C(q)/E*² [µm²] over q [1/µm].
    """
    points = result.pressure.size
    pressure = np.linspace(0, 2, 41)
    gap = np.linspace(0, 4, 81)
    area = np.geomspace(1e-4, 100, 25)
    q, spectrum, _ = radial_spectrum(result.pressure / MODULUS, result.surface.pixel)
    shells = np.geomspace(q[1], q[-1], 49)
    place = np.digitize(q, shells)
    used = [number for number in range(1, len(shells)) if (place == number).any()]
    touching, clear = result.contact, ~result.contact
    spots = np.histogram(result.spots().area * 1e12, area)[0]
    return {
        "pressure": [
            pressure.tolist(),
            (np.array(histogram(result.pressure[touching] / MODULUS, pressure)) / points).tolist(),
        ],
        "gap": [
            gap.tolist(),
            (np.array(histogram(result.gap[clear] * 1e6, gap)) / points).tolist(),
        ],
        "spots": [area.tolist(), (spots / np.diff(area) / (result.nominal_area * 1e12)).tolist()],
        "stress": [
            [float(q[place == number].mean() / 1e6) for number in used],
            [float(spectrum[place == number].mean() * 1e12) for number in used],
        ],
    }


def peers(python: str, heights: Array, side: float) -> dict[str, Any]:
    """Return contact, largest pressure and difference of each peer in an environment."""
    own = solve(heights, side, PRESSURE, 1e-10)[1].pressure / MODULUS
    answers: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "map.npy"
        for program in ("contactmechanics", "tamaas"):
            np.save(file, heights)
            began = time.perf_counter()
            specified = map(str, (PEERS, program, file, side, PRESSURE / MODULUS))
            subprocess.run([python, "-c", _PEER, *specified], check=True)
            pressure = np.load(file)
            answers[program] = {
                "contact": float(np.mean(pressure > 0)),
                "peak": float(pressure.max()),
                "difference": float(np.linalg.norm(pressure - own) / np.linalg.norm(own)),
                "not_in_both": int(np.count_nonzero((pressure > 0) != (own > 0))),
                "seconds": time.perf_counter() - began,
            }
            print(program, answers[program], flush=True)
    return answers


def run(options: argparse.Namespace) -> dict[str, Any]:
    """Solve on all grids, and under all loads on one."""
    if options.map:
        surface = rc.read_surface(options.map, channel=options.channel).leveled("mean")
        heights, side = surface.heights, surface.size[0]
    else:
        heights, side = generate(options.seed), SIDE
    Sq, gradient, radius = moments(heights, side)
    tabor = radius ** (1 / 3) * (ENERGY / MODULUS) ** (2 / 3) / RANGE
    answer: dict[str, Any] = {"Sq": Sq, "gradient": gradient, "radius": radius, "tabor": tabor}
    print(answer, flush=True)
    grids = [1024 * 2**n for n in range(10) if 1024 * 2**n <= options.largest]
    answer["grids"] = []
    for points in grids:
        row, result = solve(sampled(heights, points), side, PRESSURE)
        print(row, flush=True)
        answer["grids"].append(asdict(row))
        if points == min(4096, grids[-1]):
            answer |= {"distributions": distributions(result), "points": points}
    # The map on 1024² points lacks its shortest waves.
    answer["limits"] = {
        name: limits([row[name] for row in answer["grids"] if row["points"] >= POINTS])
        for name in QUANTITIES
    }
    answer["loads"] = [asdict(solve(heights, side, load)[0]) for load in LOADS]
    if not options.map:
        answer["seeds"] = [
            asdict(solve(generate(seed), SIDE, PRESSURE)[0]) for seed in range(options.seeds)
        ]
    if options.peers:
        answer["peers"] = peers(options.peers, sampled(heights, 1024), side)
    return answer


def shown(name: str, value: float, digits: int = 5) -> str:
    """Return a quantity as the page shows it."""
    return f"{100 * value:.3f} %" if name in ("contact", "corrected") else f"{value:.{digits}g}"


def page(answer: dict[str, Any]) -> str:
    """Return the tables of the page."""
    names = list(QUANTITIES)
    grids = [
        [f"{row['points']}²", *(shown(name, row[name]) for name in names), str(row["spots"])]
        for row in answer["grids"]
    ]
    ends = [" to ".join(shown(n, end) for end in answer["limits"][n]) for n in names]
    scatter = []
    for name in names:
        values = np.array([row[name] for row in answer["seeds"]])
        scatter.append(f"{shown(name, values.mean())} ± {shown(name, values.std(ddof=1), 2)}")
    count = len(answer["seeds"])
    grids += [["limit", *ends, ""], [f"2048², {count} realizations", *scatter, ""]]
    loads = [
        [f"{row['load']:g}", *(shown(name, row[name]) for name in names), str(row["spots"])]
        for row in answer["loads"][::2]
    ]
    programs = [
        [
            name,
            shown("contact", row["contact"]),
            f"{row['peak']:.8g}",
            f"{row['difference']:.1e}",
            str(row["not_in_both"]),
        ]
        for name, row in answer["peers"].items()
    ]
    last = "number of spots"
    return "\n\n".join(
        [
            markdown(("points", *QUANTITIES.values(), last), grids),
            markdown(("pressure [E*]", *QUANTITIES.values(), last), loads),
            markdown(
                (
                    "program, 1024²",
                    "contact fraction",
                    "largest pressure [E*]",
                    "difference of the pressures",
                    "pixels in contact in one only",
                ),
                programs,
            ),
        ]
    )


def main() -> None:
    """Print the numbers, and keep them."""
    parser = make_parser(__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=8, help="realizations for the scatter")
    parser.add_argument("--largest", type=int, default=4096, help="points per side")
    parser.add_argument("--map", type=Path, help="a periodic map in place of an own realization")
    parser.add_argument("--channel", help="its name in the file")
    parser.add_argument("--peers", help="Python of an environment with ContactMechanics and Tamaas")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    if options.write and (options.map or not options.peers):
        parser.error("the page shows an own realization and peers: give --peers, and no --map")
    answer = run(options)
    print(json.dumps(answer, indent=1))
    if options.write:
        STORED.write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
        write_parts("result", page(answer), page=PAGE)


if __name__ == "__main__":
    main()
