"""How often the interval of a number holds what the same heights give on a far finer grid.

    python calibration/intervals.py                  # 200 maps, a quarter of an hour on one core
    python calibration/intervals.py --maps 20 --first 1000
    python calibration/intervals.py --write          # and the table in docs/howto/study.md again

Band-limited self-affine maps of 128² points, of Hurst exponents from 0.2 to 1 and shortest waves of
2.3 to 16 pixels, under a random load, elastic or with a ceiling, periodic or free, every other free
one with a crown that keeps the contact off the edges. The truth is the contact of the same waves on
1024² points; what the study sees of them is the map alone, and makes up the heights in between.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import roughcontact as rc
from roughcontact.surface import filters
from roughcontact.uncertainty import intervals as uncertainty

PAGE = Path(__file__).parents[1] / "docs" / "howto" / "study.md"
START, END = "<!-- intervals -->", "<!-- intervals end -->"

Array = NDArray[np.float64]

POINTS, FINER, SLOPE = 128, 8, 0.1
"""Points a side, pixels over those of the truth, root-mean-square slope."""

MATERIAL = rc.Material(1e9, 0.0)
PIXEL = 1e-6
TOLERANCE = 1e-5

NAMES = {
    "contact_fraction": "contact area",
    "saturated_fraction": "saturated area",
    "max_pressure": "largest pressure",
    "mean_gap": "mean gap",
    "approach": "approach",
}


@dataclass(frozen=True)
class Case:
    """A surface that is known between its points, and how it is pressed."""

    waves: Array
    crown: float
    load: float
    ceiling: float | None
    boundary: str

    @property
    def kind(self) -> str:
        """Labels of the table."""
        return f"{'elastic' if self.ceiling is None else 'ceiling'}, {self.boundary}"

    def surface(self, points: int) -> rc.Surface:
        """Return the map with a number of points per side."""
        heights = filters.resample(self.waves, (points, points))
        across = (np.arange(points) + 0.5) / points - 0.5
        heights -= self.crown * (across[:, None] ** 2 + across**2)
        return rc.Surface(heights, (POINTS * PIXEL / points,) * 2)


def draw_case(number: int, points: int = POINTS, finer: int = FINER) -> Case:
    """Return a random case."""
    rng = np.random.default_rng((32, number))
    shortest = float(rng.choice([2.3, 3, 4, 6, 8, 12, 16]))
    longest = max(points / float(rng.choice([1.5, 3, 6])), 1.5 * shortest)
    waves = rc.self_affine(
        (points * finer,) * 2,
        (PIXEL / finer,) * 2,
        rms_height=PIXEL,
        hurst=rng.uniform(0.2, 1),
        rolloff_wavelength=longest * PIXEL,
        cutoff_wavelength=shortest * PIXEL,
        rng=rng,
    )
    waves *= SLOPE / math.hypot(*(g.std() for g in np.gradient(waves, PIXEL / finer)))
    periodic, crowned, limited = rng.random(3) < (0.4, 0.5, 0.5)
    crown = 0.0 if periodic or not crowned else rng.uniform(3, 12) * float(waves.std())
    touching = (points * PIXEL) ** 2 * (0.4 if crown else 1.0)
    modulus = MATERIAL.young * SLOPE
    load = modulus * touching * math.exp(rng.uniform(math.log(0.004), math.log(0.15)))
    ceiling = modulus * rng.uniform(0.12, 0.5) if limited else None
    if ceiling:
        load = min(load, 0.3 * ceiling * touching)
    return Case(waves, crown, load, ceiling, "periodic" if periodic else "free")


def truth(case: Case, points: int = POINTS, finer: int = FINER) -> dict[str, float]:
    """Return the limit of finer grids; areas, of first order, from the two finest."""
    before, last = (
        rc.solve(
            case.surface(points * factor),
            material=MATERIAL,
            load=case.load,
            ceiling=case.ceiling,
            boundary=case.boundary,
            tolerance=TOLERANCE,
        )
        for factor in (finer // 2, finer)
    )
    found = {name: float(getattr(last, name)) for name in NAMES}
    for name in ("contact_fraction", "saturated_fraction"):
        found[name] = 2 * found[name] - float(getattr(before, name))
    return found


def intervals_of_map(case: Case, points: int = POINTS) -> dict[str, uncertainty.Interval]:
    """Return the intervals of the map alone, by name."""
    surface = case.surface(points)
    given = {
        "material": MATERIAL,
        "load": case.load,
        "ceiling": case.ceiling,
        "boundary": case.boundary,
        "tolerance": TOLERANCE,
    }
    result, study = rc.solve(surface, **given), rc.resolution_study(surface, **given)
    found = uncertainty.uncertainty_intervals(result, study)
    # At the ceiling it is known.
    at = result.max_pressure == case.ceiling
    return {one.name: one for one in found if not (at and one.name == "max_pressure")}


def table(rows: dict[str, dict[str, list[tuple[float, float]]]]) -> str:
    """Return the table in Markdown."""
    lines = [f"| maps | {' | '.join(NAMES.values())} |", f"|---|{'---|' * len(NAMES)}"]
    lines += [
        f"| {kind} | {' | '.join(_cell(found.get(name, [])) for name in NAMES)} |"
        for kind, found in sorted(rows.items())
    ]
    return "\n".join(lines)


def _cell(counted: list[tuple[float, float]]) -> str:
    bounded = [(holds, half) for holds, half in counted if math.isfinite(half)]
    text = "–"
    if bounded:
        share, half = np.mean([b[0] for b in bounded]), np.median([b[1] for b in bounded])
        text = f"{100 * share:.0f} % of {len(bounded)}, ±{100 * half:.2g} %"
    without = len(counted) - len(bounded)
    return f"{text}; {without} without interval" if without else text


def main() -> None:
    """Count, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--maps", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="number of the first map")
    parser.add_argument("--points", type=int, default=POINTS)
    parser.add_argument("--finer", type=int, default=FINER)
    parser.add_argument("--write", action="store_true", help=f"renew the table in {PAGE.name}")
    options = parser.parse_args()
    rows: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for number in range(options.first, options.first + options.maps):
        case = draw_case(number, options.points, options.finer)
        right, found = (
            truth(case, options.points, options.finer),
            intervals_of_map(case, options.points),
        )
        for name, one in found.items():
            half = (one.high - one.low) / 2 / one.value
            counted = rows.setdefault(case.kind, {}).setdefault(name, [])
            counted.append((one.low <= right[name] <= one.high, half))
    text = table(rows)
    print(text)
    if options.write:
        page = PAGE.read_text(encoding="utf-8")
        before, after = page.index(START) + len(START), page.index(END)
        PAGE.write_text(f"{page[:before]}\n{text}\n{page[after:]}", encoding="utf-8")


if __name__ == "__main__":
    main()
