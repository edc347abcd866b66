"""How often the interval of a number holds what the surface behind a measured map gives.

    python calibration/interval_coverage.py --cases 24          # some twenty minutes on one core
    python calibration/interval_coverage.py --cases 40 --first 100
    python calibration/interval_coverage.py --cases 10 --also
    python calibration/interval_coverage.py --cases 10 --part
    python calibration/interval_coverage.py --cases 200 --first 5100 --keep cases.jsonl
    python calibration/interval_coverage.py --measured ../shared/measurements/*.x3p

Surfaces of 512² points: Hurst exponents from 0.4 to 0.95, a roll-off at 1/2.5 to 1/8 of the side,
shortest waves of 8 to 32 points, slope 0.1; a third isotropic, a third with a lay, a third with
worn summits. A virtual instrument measures them on 128² points, three of four optically (λ50 of 2
to 7 pixels), one with a tip (radius times curvature of 0.2 to 1.5), with noise of 0.1 to 3 % of Sq
and 0, 1 or 4 % of missing points on steep places; the map is filled and leveled. The
intervals are given a resolution, a tip radius and a noise that are wrong by a random deviation of
their standard uncertainty (the resolution of every tenth case by 2). The truth is the contact of
the surface on 768² points, elastic and with a ceiling, with the same constants.

With ``--also`` the map is optical with λ50 of 24 to 40 points of the surface, and three windows of
1/16 of its area are measured with 3.5 points as well. With ``--part`` a quarter of the area is
measured, and the intervals are those of the surface. With ``--measured`` the surfaces are maps of
instruments: the middle 512² points, without waves below four points, measured again on 128² points
with λ50 of 12 to 20 points of the map, pressed free.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import roughcontact as rc
from roughcontact.halfspace import fft
from roughcontact.surface import filters, random_surfaces
from roughcontact.surface.instrument import Instrument
from roughcontact.uncertainty.intervals import Cause, Uncertainty
from roughcontact.uncertainty.measurement import NUMBERS, uncertainty

Array = NDArray[np.float64]
Row = tuple[tuple[str, ...], tuple[float, ...]]
"""Classes, and: held, half width, error, error as measured, closing, ways apart."""

POINTS, MEASURED, TRUTH, SLOPE, PIXEL = 512, 128, 768, 0.1, 1e-7
MATERIAL = rc.Material(1e9, 0.0)
KINDS = ("isotropic", "lay", "worn")
EXACT = {"E": 0.0, "yield": 0.0}


@dataclass(frozen=True)
class Case:
    """A surface, its measured map, and what is stated of the instrument."""

    classes: tuple[str, str]
    surface: Array
    map: rc.Surface
    stated: Instrument
    shortest_wave: float
    load: float
    ceiling: float
    boundary: str = "periodic"
    also: tuple[tuple[rc.Surface, Instrument], ...] = ()


def drawn(number: int, finer: bool = False) -> Case:
    """Return a case, of several maps where finer ones are wanted."""
    rng = np.random.default_rng([36, number])
    kind, tip = KINDS[number % 3], number % 4 == 3 and not finer
    side, wave = POINTS * PIXEL, 8 * PIXEL * 4 ** rng.random()
    heights = _heights(kind, side / rng.uniform(2.5, 8), wave, rng)
    surface = rc.Surface(heights, (PIXEL, PIXEL))
    pixel = PIXEL * POINTS / MEASURED
    if tip:
        bend = np.diff(heights, 2, axis=1).std() / PIXEL**2
        true = Instrument("tip", tip_radius=rng.uniform(0.2, 1.5) / bend)
    else:
        true = Instrument(
            "optical", resolution=rng.uniform(*((6, 10) if finer else (2, 7))) * pixel
        )
    true = replace(true, noise=surface.Sq * 10 ** rng.uniform(-3, math.log10(0.03)))
    image = true.measure(surface, points=(MEASURED, MEASURED), periodic=True, rng=rng)
    missing = _holes(image.heights, (0.0, 0.01, 0.04)[int(rng.integers(3))], rng)
    found = rc.Surface(np.where(missing, np.nan, image.heights), image.pixel)
    wrong = rng.standard_normal(3)
    also = tuple(_windows(surface, rng)) if finer else ()
    if number % 10 == 9:
        wrong[0] = math.copysign(2, wrong[0])
    stated = true.changed(
        resolution=math.exp(-0.15 * wrong[0]),
        tip_radius=math.exp(-0.2 * wrong[1]),
        noise=math.exp(-0.2 * wrong[2]),
    )
    unit = SLOPE * rc.contact_modulus(MATERIAL, rc.RIGID)
    return Case(
        ("tip" if tip else "optical", kind),
        heights,
        found.filled().leveled(),
        stated,
        wave,
        unit * 0.008 * 10 ** rng.random() * side**2,
        unit * 0.06 * (0.4 / 0.06) ** rng.random(),
        also=also,
    )


def of_file(path: Path, number: int) -> Case:
    """Return a case of which the surface is a measured map."""
    rng = np.random.default_rng([37, number])
    surface = rc.read_surface(path).filled(1.0).without_outliers().filled(1.0).leveled()
    side = min(POINTS, *surface.shape)
    corner = [(points - side) // 2 for points in surface.shape]
    surface = surface.cropped(*((start, start + side) for start in corner)).leveled()
    edge = float(np.mean(surface.pixel))
    shape = (POINTS, POINTS)
    size = tuple(side * pixel / POINTS for pixel in surface.pixel)
    heights = filters.resample(surface.heights, shape, "spline")
    edge = float(np.mean(size))
    wave = max(4 * edge, 4 * max(surface.pixel))
    surface = rc.Surface(heights, (size[0], size[1])).filtered(wave)
    true = Instrument("optical", resolution=rng.uniform(12, 20) * edge, noise=0.005 * surface.Sq)
    image = true.measure(surface, points=(MEASURED, MEASURED), rng=rng)
    stated = true.changed(resolution=math.exp(-0.15 * rng.standard_normal()))
    unit = surface.Sdq * rc.contact_modulus(MATERIAL, rc.RIGID)
    area = math.prod(surface.size)
    return Case(
        ("measured", path.stem),
        surface.heights,
        image.filled().leveled(),
        stated,
        wave,
        unit * 0.008 * 10 ** rng.random() * area,
        unit * 0.06 * (0.4 / 0.06) ** rng.random(),
        "free",
    )


def _windows(
    surface: rc.Surface, rng: np.random.Generator
) -> Iterator[tuple[rc.Surface, Instrument]]:
    """Return finer maps of parts of the surface, and what is stated of their instrument."""
    true = Instrument("optical", resolution=3.5 * PIXEL, noise=0.002 * surface.Sq)
    image = true.measure(surface, periodic=True, rng=rng).heights
    stated = true.changed(resolution=math.exp(-0.15 * rng.standard_normal()))
    side = POINTS // 4
    for top, left in rng.integers(POINTS - side, size=(3, 2)):
        part = image[top : top + side, left : left + side]
        yield rc.Surface(part, (PIXEL, PIXEL)).leveled(), stated


def _heights(kind: str, rolloff: float, wave: float, rng: np.random.Generator) -> Array:
    ratio = 1 / rng.uniform(3, 8) if kind == "lay" else 1.0
    spectrum = random_surfaces.Spectrum(
        (POINTS, POINTS),
        (PIXEL, PIXEL),
        max(rolloff, 1.5 * wave),
        wave,
        rng.uniform(0.4, 0.95),
        ratio,
        float(rng.uniform(0, 180)),
    )
    waves = random_surfaces.random_amplitudes(spectrum.shape, spectrum.pixel, rng)
    heights = fft.irfft2(waves * np.sqrt(spectrum.power), spectrum.shape)
    if kind == "worn":
        plane = np.quantile(heights, rng.uniform(0.75, 0.95))
        heights = np.where(heights > plane, plane + 0.15 * (heights - plane), heights)
    return heights * (SLOPE / rc.Surface(heights, (PIXEL, PIXEL)).Sdq)


def _holes(heights: Array, share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return clusters of points on steep places."""
    slope = np.hypot(*np.gradient(heights))
    chance = filters.gaussian_lowpass(rng.random(heights.shape), (1.0, 1.0), 4.0)
    score = chance / chance.std() + slope / slope.std()
    return score > np.quantile(score, 1 - share) if share else np.zeros(heights.shape, bool)


def told(
    case: Case, ceiling: float | None, part: bool = False
) -> tuple[dict[str, float], Uncertainty]:
    """Return the numbers of the surface, and the intervals from its map."""
    problem = {
        "material": MATERIAL,
        "load": case.load,
        "ceiling": ceiling,
        "boundary": case.boundary,
        "calibrated": False,
        "on_failure": "return",
    }
    edges = [
        edge * points / TRUTH for edge, points in zip(case.map.pixel, case.map.shape, strict=True)
    ]
    method = "bandlimited" if case.boundary == "periodic" else "spline"
    fine = rc.Surface(filters.resample(case.surface, (TRUTH, TRUTH), method), (edges[0], edges[1]))
    true = rc.solve(fine, **problem, tolerance=1e-4)
    numbers = {name: number.of(true) for name, number in NUMBERS.items()}
    if not part:
        result = rc.solve(case.map, **problem)
        known = uncertainty(result, case.stated, case.shortest_wave, EXACT, also=case.also)
        return numbers, known
    half = MEASURED // 2
    window = rc.Surface(case.map.heights[:half, :half], case.map.pixel).leveled()
    result = rc.solve(window, **{**problem, "load": case.load / 4})
    known = uncertainty(result, case.stated, case.shortest_wave, EXACT, of="surface")
    return numbers | {
        name: numbers[name] / 4 for name in ("stiffness", "constriction_length")
    }, known


def bounds(held: int, count: int) -> str:
    """Return the Clopper-Pearson interval of a share."""
    from scipy.special import betaincinv

    low = betaincinv(held, count - held + 1, 0.025) if held else 0.0
    high = betaincinv(held + 1, count - held, 0.975) if held < count else 1.0
    return f"{held / count:.2f} ({low:.2f} to {high:.2f})"


def main() -> None:
    """Count, and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--part", action="store_true", help="a quarter of each surface")
    parser.add_argument("--also", action="store_true", help="a coarse map and three finer ones")
    parser.add_argument("--measured", type=Path, nargs="+", default=[], help="maps of instruments")
    parser.add_argument("--keep", type=Path, help="file of cases that are done; the rest is run")
    options = parser.parse_args()
    known = kept(options.keep) if options.keep else {}
    numbers = range(options.first, len(options.measured) or options.first + options.cases)
    for number in (number for number in numbers if number not in known):
        began = time.process_time()
        if options.measured:
            case = of_file(options.measured[number], number)
        else:
            case = drawn(number, options.also)
        known[number] = judged(number, case, options.part)
        if options.keep:
            with options.keep.open("a", encoding="utf-8") as file:
                print(json.dumps([number, known[number]]), file=file)
        print(f"case {number}: {time.process_time() - began:.0f} s of processor", flush=True)
    tell(known)


def kept(path: Path) -> dict[int, list[Row]]:
    """Return the rows of the cases of earlier runs."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return dict(json.loads(line) for line in lines)


def judged(number: int, case: Case, part: bool) -> list[Row]:
    """Return each number of a case: its classes, and how its interval stands to the truth."""
    rows: list[Row] = []
    for ceiling in (None, case.ceiling):
        try:
            true, known = told(case, ceiling, part)
        except rc.InputError as error:
            print(f"case {number} {case.classes}: {error}", flush=True)
            continue
        model = "elastic" if ceiling is None else "ceiling"
        for one in known.intervals:
            right = true[one.name]
            half = math.log(one.high / one.low) / 2
            # The end that is the ceiling itself is rounded.
            held = one.low <= (1 + 1e-9) * right and right <= (1 + 1e-9) * one.high
            off, raw = math.log(one.value / right), math.log(one.measured / right)
            apart = math.sqrt(one.budget.get(Cause.CORRECTIONS, 0.0))
            row = float(held), half, off, raw, known.closing[one.name], apart
            rows.append(((f"{one.name}, {model}", *case.classes, "all"), row))
            if half and not held:
                print(
                    f"case {number} {case.classes} {model} {one.name}: off {off:+.3f} of "
                    f"{half:.3f}, as measured {raw:+.3f}",
                    flush=True,
                )
    return rows


def tell(known: dict[int, list[Row]]) -> None:
    """Print the table of all cases."""
    rows = defaultdict(list)
    for keys, row in itertools.chain.from_iterable(known.values()):
        for key in keys:
            rows[key].append(row)
    print(f"{sum(not found for found in known.values())} of {len(known)} cases refused")
    for key, values in rows.items():
        held, half, off, raw, closing, apart = np.array(values).T
        rms, before = (math.sqrt(np.mean(part**2)) for part in (off, raw))
        print(
            f"{key:32} held {bounds(int(held.sum()), held.size)}, half width "
            f"{100 * np.median(half):5.1f} %, error {100 * rms:5.1f} % (mean "
            f"{100 * off.mean():+5.1f} %), as measured {100 * before:5.1f} %, ratio "
            f"{np.median(half) / max(rms, 1e-12):4.1f}, budget {np.nanmedian(closing):.2f}, "
            f"ways apart {np.median(apart):.2f}"
        )


if __name__ == "__main__":
    main()
