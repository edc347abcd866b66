"""How often the interval of a quantity contains the value of the surface behind a measured map.

    python benchmarks/interval_coverage.py --cases 18 --workers 2 --keep cases.jsonl
    python benchmarks/interval_coverage.py --cases 18 --instrument gaussian
    python benchmarks/interval_coverage.py --measured ../shared/measurements/*.x3p

Surfaces and instruments are those of `tests/virtual_microscope.py`, which shares no code with the
package; the kind of instrument is stated right. Maps are filled and leveled by a plane. Loads are
0.008 to 0.08 E* h' (h' the RMS slope) over the area, ceilings 0.06 to 0.4 E* h' and at least twice
the load. The true values are those of the surface on 768² points (within 1 % of those on 1536²),
elastic and with the ceiling. Intervals that are the ceiling itself, the largest pressure, are left
out. With ``--measured`` the surfaces are maps of instruments: their middle 480² points at most,
without waves below four points, measured again, and the inner 96² pixels pressed free.
"""

from __future__ import annotations

import json
import math
import time
from collections import Counter, defaultdict
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage, signal
from scipy.special import betaincinv

import roughcontact as rc
from measuring import make_parser
from roughcontact.halfspace import fft
from roughcontact.results import Uncertainty
from roughcontact.uncertainty.measurement import NUMBERS

import virtual_microscope as microscope  # isort: skip - measuring makes it importable

TRUTH, SPACING, READ, MARGIN = 768, 1e-7, 480, 48
MATERIAL = rc.Material(1e9, 0.0)
STATED_KINDS = {"diffraction": "optical", "gaussian": "gaussian", "tip": "tip"}
EXACT = {"E": 0.0, "yield": 0.0}
Record = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """A surface, its filled and leveled map, and what is stated of the instrument."""

    finish: str
    surface: rc.Surface
    map: rc.Surface
    stated: rc.measure.Instrument
    shortest_wave: float
    load: float
    ceiling: float
    boundary: str


def make_case(measurement: microscope.Measurement, is_free: bool = False) -> Case:
    """Return the case of a measurement: its period, or the inner part of a map as a free map."""
    binning, is_tip = microscope.BINNING, measurement.kind == "tip"
    heights, image = measurement.heights, measurement.image
    if is_free:
        heights = heights[MARGIN : READ - MARGIN, MARGIN : READ - MARGIN]
        inner = slice(MARGIN // binning, (READ - MARGIN) // binning)
        image = image[inner, inner]
        fine = ndimage.zoom(heights, TRUTH / len(heights), mode="nearest", grid_mode=True)
    else:
        fine = signal.resample(signal.resample(heights, TRUTH, axis=0), TRUTH, axis=1)
    edge = SPACING * len(heights) / TRUTH
    surface = rc.Surface(SPACING * fine, (edge, edge))
    stated = rc.measure.Instrument(
        STATED_KINDS[measurement.kind],
        resolution=None if is_tip else SPACING * measurement.stated_resolution,
        tip_radius=SPACING * measurement.stated_tip_radius if is_tip else None,
        noise=SPACING * measurement.stated_noise,
    )
    unit = surface.Sdq * rc.contact_modulus(MATERIAL, rc.RIGID)
    return Case(
        measurement.finish,
        surface,
        rc.Surface(SPACING * image, (SPACING * binning, SPACING * binning)).filled().leveled(),
        stated,
        SPACING * measurement.shortest_wave,
        measurement.pressure * unit * math.prod(surface.size),
        measurement.ceiling * unit,
        "free" if is_free else "periodic",
    )


def draw_case(number: int, kind: str) -> Case:
    """Return the case of a number."""
    return make_case(microscope.draw_measurement(number, kind))


def read_case(path: Path, number: int, kind: str) -> Case:
    """Return a case of which the surface is a measured map, in points of the virtual microscope."""
    known = rc.read_surface(path).filled(1.0).without_outliers().filled(1.0)
    length = min(*known.size, READ * max(known.pixel))
    sides = [round(length / pixel) for pixel in known.pixel]
    corners = [(points - side) // 2 for points, side in zip(known.shape, sides, strict=True)]
    ranges = [(corner, corner + side) for corner, side in zip(corners, sides, strict=True)]
    heights = known.cropped(*ranges).leveled().heights * READ / length
    heights = ndimage.zoom(heights, [READ / side for side in sides], mode="nearest", grid_mode=True)
    wave = 4 * max(1.0, max(known.pixel) * READ / length)
    # Mirrored, the map is one period without steps.
    heights = microscope.remove_short_waves(np.pad(heights, (0, READ), "symmetric"), wave)
    return make_case(microscope.measure(number, kind, path.stem, heights, wave), is_free=True)


def solve_case(case: Case, ceiling: float | None) -> tuple[dict[str, float], Uncertainty]:
    """Return the quantities of the surface, and the intervals of its map."""
    problem: dict[str, Any] = {
        "material": MATERIAL,
        "load": case.load,
        "ceiling": ceiling,
        "boundary": case.boundary,
        "calibrated": False,
        "on_failure": "return",
    }
    truth = rc.solve(case.surface, **problem, tolerance=1e-4)
    result = rc.solve(case.map, **problem)
    known = result.uncertainty(case.stated, case.shortest_wave, material=EXACT)
    return {name: quantity.of(truth) for name, quantity in NUMBERS.items()}, known


def is_inside(low: float, truth: float, high: float) -> bool:
    """Return whether an interval contains a value; an end that is the ceiling is rounded."""
    return low <= (1 + 1e-9) * truth and truth <= (1 + 1e-9) * high


def judge_case(number: int, kind: str, path: Path | None = None) -> Record:
    """Return all intervals of a case with the true values, or the reason that there are none."""
    began = time.process_time()
    rows: list[list[Any]] = []
    refusals: list[str] = []
    with fft.limit_threads(1):
        case = read_case(path, number, kind) if path else draw_case(number, kind)
        for model, ceiling in (("elastic", None), ("ceiling", case.ceiling)):
            try:
                truth, known = solve_case(case, ceiling)
            except rc.RoughcontactError as error:
                refusals.append(str(error))
                continue
            for item in known.intervals:
                right = truth[item.name]
                if item.low < item.high or not is_inside(item.low, right, item.high):
                    values = right, item.low, item.high, item.value, item.measured
                    rows.append([f"{item.name}, {model}", *values])
    return {
        "number": number,
        "kind": kind,
        "finish": case.finish,
        "rows": rows,
        "refusals": refusals,
        "seconds": time.process_time() - began,
    }


def print_table(records: Iterable[Record]) -> None:
    """Print coverage, widths and errors by quantity, by finish and of all, and what was refused.

    The ratio is one over the RMS of error over half width, case by case: where widths differ
    tenfold, a median width over an RMS error compares the usual case with the widest.
    """
    groups = defaultdict(list)
    refusals: Counter[tuple[str, str]] = Counter()
    solved: Counter[str] = Counter()
    for record in sorted(records, key=lambda record: record["number"]):
        solved[record["finish"]] += 1
        refusals.update((record["finish"], reason) for reason in record["refusals"])
        for quantity, *values in record["rows"]:
            for key in ((0, quantity), (1, record["finish"]), (2, "all")):
                groups[key].append(values)
    print(f"{'':28} {'held (95 % bounds)':27} half width  rms error  mean  as measured  ratio")
    for (_, key), values in sorted(groups.items()):
        truth, low, high, value, measured = np.array(values).T
        held = [is_inside(*part) for part in zip(low, truth, high, strict=True)]
        half, error, raw = np.log(high / low) / 2, np.log(value / truth), np.log(measured / truth)
        rms, before = (math.sqrt(np.mean(part**2)) for part in (error, raw))
        print(
            f"{key:28} {format_share(sum(held), len(held)):27} {100 * np.median(half):8.1f} %"
            f" {100 * rms:8.1f} % {100 * error.mean():+5.1f} {100 * before:10.1f} %"
            f" {1 / max(math.sqrt(np.mean((error / half) ** 2)), 1e-12):6.1f}"
        )
    for (finish, reason), count in sorted(refusals.items()):
        print(f"{finish}: {count} of {2 * solved[finish]} rejected: {reason}")


def format_share(held: int, count: int) -> str:
    """Return a share with its Clopper-Pearson interval."""
    low = betaincinv(held, count - held + 1, 0.025) if held else 0.0
    high = betaincinv(held + 1, count - held, 0.975) if held < count else 1.0
    return f"{held / count:.3f} ({low:.3f} to {high:.3f}) {count}"


def main() -> None:
    """Judge cases in processes, and print the table."""
    parser = make_parser(__doc__)
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--instrument", choices=microscope.KINDS, default="diffraction")
    parser.add_argument("--measured", type=Path, nargs="+", default=[], help="maps of instruments")
    parser.add_argument("--workers", type=int, default=1, help="processes of one thread")
    parser.add_argument("--keep", type=Path, help="finished cases of this command; others are run")
    options = parser.parse_args()
    kind, keep = options.instrument, options.keep
    lines = keep.read_text(encoding="utf-8").splitlines() if keep and keep.exists() else []
    known = {(record["number"], record["kind"]): record for record in map(json.loads, lines)}
    cases = [(number, kind, path) for number, path in enumerate(options.measured)] or [
        (number, kind, None) for number in range(options.first, options.first + options.cases)
    ]
    with ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        tasks = [pool.submit(judge_case, *case) for case in cases if case[:2] not in known]
        for task in as_completed(tasks):
            record = task.result()
            known[record["number"], kind] = record
            print(f"case {record['number']}: {record['seconds']:.0f} s of processor", flush=True)
            if keep:
                with keep.open("a", encoding="utf-8") as file:
                    print(json.dumps(record), file=file)
    print_table(known[case[:2]] for case in cases)


if __name__ == "__main__":
    main()
