"""Randomised contact problems, each certified or refused by a judge that shares no code with them.

    python benchmarks/random_problems.py                # 500 problems, some minutes
    python benchmarks/random_problems.py --write        # and docs/robustness.md from what was found
    python benchmarks/random_problems.py --only 17 230  # single ones again

A seed names a problem. What has to come of it, a solution or which error, is reasoned from its
numbers before it is solved; what came is judged by ``tests/judge.py``: plain NumPy and SciPy.
The exit status is 1 if anything was wrong.
"""

from __future__ import annotations

import argparse
import math
import platform
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parents[1]
if str(ROOT / "tests") not in sys.path:
    sys.path.append(str(ROOT / "tests"))

import judge  # noqa: E402 - found beside the tests
import roughcontact as rc  # noqa: E402
from roughcontact.contact.checks import stated  # noqa: E402
from roughcontact.contact.pair import Pair  # noqa: E402
from roughcontact.contact.terms import Terms  # noqa: E402
from roughcontact.halfspace.boundary import Boundary  # noqa: E402

Array = NDArray[np.float64]

PAGE = ROOT / "docs" / "robustness.md"
START, END = "<!-- problems -->", "<!-- end of problems -->"

# What may come. A ConvergenceError is right where the digits of the arithmetic do not hold the
# tolerance, and honest where the convolutions allowed did not suffice.
CERTIFIED = "certified"
REFUSED = "refused with the right error"
ROUNDED = "below the rounding, said so"
GAVE_UP = "gave up, said so"
WRONG = "wrong"
VERDICTS = (CERTIFIED, REFUSED, ROUNDED, GAVE_UP, WRONG)


@dataclass(frozen=True)
class Case:
    """One problem and what has to come of it.

    Parameters
    ----------
    seed : int
        What it was drawn from.
    surface : Surface
        The map.
    options : dict
        Everything else that `solve` is given.
    kind : str
        What the map looks like.
    words : dict
        The problem in words, for the table.
    expected : type or None
        The error that has to come, or ``None`` for a solution.
    """

    seed: int
    surface: rc.Surface
    options: dict[str, Any]
    kind: str
    words: dict[str, str]
    expected: type[Exception] | None


@dataclass(frozen=True)
class Outcome:
    """What came of a problem.

    Parameters
    ----------
    case : Case
        The problem.
    verdict : str
        One of ``VERDICTS``.
    words : str
        What is wrong, or why it was refused.
    certificate : float
        ε by the independent judge; NaN without a solution.
    convolutions : int
        On the full grid.
    seconds : float
        Wall time of the solve.
    """

    case: Case
    verdict: str
    words: str = ""
    certificate: float = math.nan
    convolutions: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        """Return everything in one line."""
        problem = ", ".join(f"{name} {value}" for name, value in self.case.words.items())
        return (
            f"{self.case.seed}: {self.case.kind}, {problem}: {self.verdict}"
            f"{': ' if self.words else ''}{self.words} "
            f"(certificate {self.certificate:.1e}, {self.convolutions} convolutions, "
            f"{self.seconds:.2f} s)"
        )


# Maps, of height and length about one in units of their pixels ------------------------------------


def _self_affine(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """Power-law spectrum, by a transform of white noise: down to the pixel, any aspect."""
    ny, nx = y.shape
    edges = (y[1, 0] - y[0, 0], x[0, 1] - x[0, 0])
    q = np.hypot(np.fft.fftfreq(ny, edges[0])[:, None], np.fft.rfftfreq(nx, edges[1]))
    shortest = 0.5 / max(edges)
    rolloff = shortest * rng.choice([0.02, 0.1, 0.5])
    cutoff = shortest * rng.choice([0.25, 1.0, math.inf])
    power = np.maximum(q, rolloff) ** -(1 + rng.choice([0.1, 0.5, 0.8, 1.0]))
    power[(q > max(cutoff, 2 * rolloff)) | (q == 0)] = 0
    if not power.any():
        power[:] = 1
    return np.fft.irfft2(np.fft.rfft2(rng.standard_normal((ny, nx))) * power, (ny, nx))


def _spikes(rng: np.random.Generator, y: Array, x: Array) -> Array:
    return np.where(rng.random(y.shape) < 0.02, rng.uniform(5, 50), 1.0) * rng.random(y.shape)


def _spike(rng: np.random.Generator, y: Array, x: Array) -> Array:
    heights = 1e-3 * rng.random(y.shape)
    heights[tuple(rng.integers(0, y.shape))] = 1.0
    return heights


def _punch(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """A flat of any outline; nothing outside."""
    a, b = rng.uniform(0.1, 0.45, 2)
    v, u = y / max(np.ptp(y), 1e-9), x / max(np.ptp(x), 1e-9)
    inside = (
        (u / a) ** 2 + (v / b) ** 2 <= 1
        if rng.random() < 0.5
        else (np.abs(u) <= a) & (np.abs(v) <= b)
    )
    if not inside.any():
        inside[y.shape[0] // 2, y.shape[1] // 2] = True
    return np.where(inside, 0.0, np.nan)


def _honed(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """A plateau with valleys: most points equally high."""
    heights = _self_affine(rng, y, x)
    return np.minimum(heights, np.quantile(heights, rng.uniform(0.1, 0.6)))


def _quantised(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """Heights in steps of the instrument: ties everywhere."""
    heights = _self_affine(rng, y, x)
    step = np.ptp(heights) / rng.choice([3, 30, 1000])
    return np.round(heights / step) * step


def _dirty(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """A rough map with a few particles, of some pixels, high above it."""
    heights = _self_affine(rng, y, x)
    heights /= heights.std()
    for _ in range(rng.integers(1, 5)):
        row, column = rng.integers(0, y.shape)
        extent = rng.integers(1, 4)
        heights[row : row + extent, column : column + extent] += 10 ** rng.uniform(0.5, 3)
    return heights


KINDS = {
    "self-affine": _self_affine,
    "white noise": lambda rng, y, x: rng.standard_normal(y.shape),
    "flat": lambda rng, y, x: np.zeros(y.shape),
    "checkerboard": lambda rng, y, x: (np.indices(y.shape).sum(0) % 2).astype(float),
    "terraces": lambda rng, y, x: np.floor(3 * rng.uniform(0.5, 2) * (x - x.min()) / np.ptp(x)),
    "spikes": _spikes,
    "one spike": _spike,
    "punch": _punch,
    "sphere": lambda rng, y, x: -(x**2 + y**2),
    "bowl": lambda rng, y, x: x**2 + 0.5 * y**2,
    "cone": lambda rng, y, x: -np.hypot(x, y),
    "waves": lambda rng, y, x: np.cos(2 * math.pi * rng.integers(1, 4) * x / (np.ptp(x) + 1)),
    "crossed waves": lambda rng, y, x: (
        np.cos(2 * math.pi * x / (np.ptp(x) + 1)) * np.cos(2 * math.pi * y / (np.ptp(y) + 1))
    ),
    "tilted": lambda rng, y, x: 0.05 * (x + 0.3 * y) + rng.standard_normal(y.shape),
    "honed": _honed,
    "quantised": _quantised,
    "dirty": _dirty,
}


def _shape(rng: np.random.Generator, largest: int) -> tuple[int, int]:
    draw = rng.random()
    if draw < 0.1:
        # A strip: no coarse grid helps, everything is rim.
        shape = (int(rng.integers(2, 5)), int(rng.integers(2, 4 * largest)))
    elif draw < 0.2:
        shape = (int(rng.integers(2, 12)), int(rng.integers(2, 12)))
    else:
        ny, nx = np.exp(rng.uniform(math.log(8), math.log(largest), 2)).astype(int)
        shape = (int(ny), int(nx))
    return shape if rng.random() < 0.5 else shape[::-1]


def _heights(
    rng: np.random.Generator, kind: str, shape: tuple[int, int], pixel: tuple[float, float]
) -> Array:
    """Return a map [m] whose slopes are drawn over six decades."""
    edge = math.sqrt(pixel[0] * pixel[1])
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2) * pixel[0] / edge
    x = (np.arange(shape[1]) - (shape[1] - 1) / 2) * pixel[1] / edge
    heights = KINDS[kind](rng, *np.meshgrid(y, x, indexing="ij"))
    steps = [np.diff(heights, axis=axis) / (pixel[axis] / edge) for axis in (0, 1)]
    slopes = np.concatenate([step[np.isfinite(step)] for step in steps])
    slope = math.sqrt(float((slopes**2).mean())) if slopes.size else 0.0
    scale = 10 ** rng.uniform(-5, 0.5) / slope if slope > 0 else 1.0
    heights = heights * scale * edge
    if rng.random() < 0.1:
        # Measured from somewhere else: the digits below are lost.
        heights = heights + 1e3 * np.nanstd(heights)
    return np.asarray(heights)


def _holes(rng: np.random.Generator, heights: Array) -> tuple[Array, str]:
    """Return the map with holes of some kind, at least one point left."""
    kind = str(rng.choice(["scattered", "patch", "border", "almost everything"]))
    holes = np.zeros(heights.shape, bool)
    ny, nx = heights.shape
    if kind == "scattered":
        holes = rng.random(heights.shape) < rng.choice([0.01, 0.3, 0.7])
    elif kind == "patch":
        holes[rng.integers(0, ny) :, rng.integers(0, nx) :] = True
    elif kind == "border":
        holes[:] = True
        holes[ny // 4 : ny - ny // 4, nx // 4 : nx - nx // 4] = False
    else:
        holes = rng.random(heights.shape) < 0.99
    keep = np.argwhere(np.isfinite(heights))
    holes[tuple(keep[rng.integers(len(keep))])] = False
    return np.where(holes, np.nan, heights), kind


def draw(seed: int, largest: int = 192) -> Case:
    """Return the problem of a seed.

    Parameters
    ----------
    seed : int
        Any.
    largest : int
        Points along the longer side, but for strips, which are up to four times as long.

    Returns
    -------
    Case
        The problem and what has to come of it.
    """
    rng = np.random.default_rng([6, seed])
    # A sixth of them what most measured maps are.
    kind = str(rng.choice(["self-affine", *KINDS, "self-affine"]))
    shape = _shape(rng, largest)
    edge, aspect = 10 ** rng.uniform(-9, -3), 1.0
    if rng.random() < 0.4:
        aspect = float(rng.choice([1.5, 3, 20])) ** rng.choice([-1, 1])
    pixel = (edge * math.sqrt(aspect), edge / math.sqrt(aspect))
    heights = _heights(rng, kind, shape, pixel)
    words = {"points": f"{shape[0]} × {shape[1]}", "pixel dy/dx": f"{aspect:.3g}"}
    expected: type[Exception] | None = None

    counter = None
    if rng.random() < 0.1:
        other = _heights(rng, "self-affine", shape, pixel)
        if rng.random() < 0.3:
            other, _ = _holes(rng, other)
        counter = rc.Surface(other, pixel)
        words["bodies"] = "two maps"
    holed = bool(np.isnan(heights).any())
    if rng.random() < 0.2:
        heights, words["holes"] = _holes(rng, heights)
        holed = bool(np.isnan(heights).any())
    surface = rc.Surface(heights, pixel)
    if holed and rng.random() < 0.07:
        expected, words["holes"] = rc.InputError, "left unhandled"
    elif holed:
        surface = surface.masked()
    if counter is not None and counter.missing:
        counter = counter.masked()
    together = surface.heights + (0.0 if counter is None else counter.heights)
    valid = np.isfinite(together)

    material = rc.Material(10 ** rng.uniform(6, 12), rng.uniform(-0.5, 0.5))
    against = rc.RIGID
    if rng.random() < 0.4:
        against = rc.Material(10 ** rng.uniform(6, 12), rng.uniform(-0.5, 0.5))
    modulus = 1 / sum((1 - body.poisson**2) / body.young for body in (material, against))
    boundary = str(rng.choice(["free", "periodic"]))
    words["boundary"] = boundary

    # Mean pressure: from a few pixels in touch to full contact.
    area = surface.pixel[0] * surface.pixel[1]
    points = max(int(np.count_nonzero(valid)), 1)
    slope = max(_slope(together, pixel), 1e-6)
    decades = [rng.uniform(-1.5, 0.5), rng.uniform(-4, 1), rng.uniform(-9, -4)]
    mean = modulus * slope * 10 ** rng.choice(decades, p=[0.6, 0.3, 0.1])
    load = float(mean * points * area)
    ceiling, capacity, words["ceiling"] = _ceiling(rng, mean, shape, valid)
    if isinstance(ceiling, str):
        material = rc.Material(material.young, material.poisson, yield_strength=capacity / 3)
    by_pixel = np.broadcast_to(
        math.inf if ceiling is None else capacity if isinstance(ceiling, str) else ceiling, shape
    )
    carries = math.fsum(by_pixel[valid]) * area

    options: dict[str, Any] = {
        "material": material, "counter_material": against, "counter_surface": counter,
        "ceiling": ceiling, "boundary": boundary,
    }  # fmt: skip
    if rng.random() < 0.2:
        depth = float(np.nanmax(together) - np.nanmin(together)) if valid.any() else 0.0
        approach = depth * 10 ** rng.uniform(-3, 0.2) if depth else slope * edge
        if rng.random() < 0.2 and valid.any():
            # Where a periodic map just closes.
            gap = float(np.nanmax(together) - together[valid].mean())
            approach = gap * rng.choice([0.9, 0.999, 1.001]) or approach
        options["approach"] = float(approach)
        words["control"] = "approach"
        if boundary == "periodic" and valid.all() and np.isinf(by_pixel).all():
            gap = float((np.max(together) - together).mean())
            if approach >= gap:
                expected = expected or rc.CapacityError
    else:
        options["load"] = load
        words["control"] = "load"
        if load > carries * (1 + 1e-9):
            expected = expected or rc.CapacityError
    if not valid.any():
        expected = expected or rc.CapacityError
    if rng.random() < 0.1:
        options["precision"] = "single"
        words["precision"] = "single"
    elif rng.random() < 0.1:
        options["tolerance"] = 1e-8
        words["tolerance"] = "1e-8"
    if rng.random() < 0.1:
        # The wrong start must cost time only.
        options["start"] = mean * rng.random(shape) * (rng.random(shape) < rng.random())
        words["start"] = "random"
    return Case(seed, surface, options, kind, words, expected)


def _slope(heights: Array, pixel: tuple[float, float]) -> float:
    parts = [np.diff(heights, axis=axis) / pixel[axis] for axis in (0, 1)]
    slopes = np.concatenate([part[np.isfinite(part)] for part in parts])
    return math.sqrt(float((slopes**2).mean())) if slopes.size else 0.0


def _ceiling(
    rng: np.random.Generator, mean: float, shape: tuple[int, int], valid: NDArray[np.bool_]
) -> tuple[str | float | Array | None, float, str]:
    """Return a ceiling [Pa] as `solve` takes it, its scalar value, and its name."""
    # Part of the capacity that the load takes up; two of them refuse it.
    filling = float(
        rng.choice([1e-4, 0.03, 0.2, 0.5, 0.9, 0.99, 0.9999, 1 - 1e-8, 1 - 1e-13, 1.0001, 3.0])
    )
    value = float(mean / filling)
    name = f"filled to {filling:.8g}"
    draw = rng.random()
    if draw < 0.35:
        return None, math.inf, "none"
    if draw < 0.45:
        return "auto", value, name
    if draw < 0.7:
        return value, value, name
    spread = rng.choice([0.3, 3.0])
    field = np.exp(spread * rng.standard_normal(shape))
    if draw < 0.8:
        # A soft part in a hard one.
        field = np.where(rng.random() > np.linspace(0, 1, shape[1]), 1e-3, 1.0) * np.ones(shape)
        name = f"two halves, {name}"
    else:
        name = f"by pixel, {name}"
    sound = field[valid] if valid.any() else field
    field = field * value / sound.mean()
    if rng.random() < 0.3:
        field[rng.random(shape) < 0.2] = math.inf
        name += ", some infinite"
    return field, value, name


def attempt(case: Case) -> Outcome:
    """Solve a problem and judge what comes."""
    began = time.perf_counter()
    try:
        result = rc.solve(case.surface, **case.options)
    except rc.ConvergenceError as error:
        return _given_up(case, error, time.perf_counter() - began)
    except rc.InputError as error:
        seconds = time.perf_counter() - began
        # A CapacityError is an InputError, but either in place of the other is wrong.
        if type(error) is not case.expected:
            return Outcome(case, WRONG, f"{type(error).__name__}: {error}", seconds=seconds)
        if not _refuses(case):
            return Outcome(case, WRONG, "check lets it pass", seconds=seconds)
        return Outcome(case, REFUSED, str(error), seconds=seconds)
    except Exception as error:
        return Outcome(case, WRONG, f"failed with {type(error).__name__}: {error}")
    seconds = time.perf_counter() - began
    faults = judge.faults(result, case.options.get("load"), result.tolerance)
    if case.expected is not None:
        faults.append(f"solved, but {case.expected.__name__} was due")
    return Outcome(
        case, WRONG if faults else CERTIFIED, "; ".join(faults),
        judge.judge(result).certificate, result.convolutions, seconds,
    )  # fmt: skip


def _refuses(case: Case) -> bool:
    terms = dict(case.options)
    start = terms.pop("start", None)
    bodies = {
        name: terms.pop(name)
        for name in ("material", "counter_material", "counter_surface")
        if name in terms
    }
    try:
        boundary = Boundary(terms.pop("boundary", "free"))
        stated(Pair(case.surface, boundary=boundary, **bodies), Terms(**terms), start)
    except rc.InputError:
        return True
    return False


def _given_up(case: Case, error: rc.ConvergenceError, seconds: float) -> Outcome:
    result = error.result
    found = judge.judge(result)
    verdict = GAVE_UP
    if result.converged or case.expected is not None or not found.bounded:
        verdict = WRONG
    elif "rounding" in result.status:
        # Found too early only if the digits would have held a tenth of the tolerance.
        verdict = ROUNDED if found.doubt > 0.1 * result.tolerance else WRONG
    return Outcome(case, verdict, str(error), found.certificate, result.convolutions, seconds)


# The table ----------------------------------------------------------------------------------------


def table(outcomes: list[Outcome]) -> str:
    """Return what came of the problems, by the kind of map, as Markdown."""
    lines = [
        f"| map | problems | {' | '.join(VERDICTS)} | worst certificate / tolerance "
        "| most convolutions |",
        "|---|" + "---|" * (len(VERDICTS) + 3),
    ]
    for kind in [*KINDS, "all"]:
        chosen = [o for o in outcomes if kind in (o.case.kind, "all")]
        solved = [o for o in chosen if o.verdict == CERTIFIED]
        counts = " | ".join(str(sum(o.verdict == v for o in chosen)) for v in VERDICTS)
        worst = max((o.certificate / tolerance_of(o.case) for o in solved), default=math.nan)
        most = max((o.convolutions for o in solved), default=0)
        lines.append(f"| {kind} | {len(chosen)} | {counts} | {worst:.2f} | {most} |")
    return "\n".join(lines)


def tolerance_of(case: Case) -> float:
    """Return the certificate that a problem is solved to."""
    usual = 1e-4 if case.options.get("precision") == "single" else 1e-6
    return float(case.options.get("tolerance", usual))


def page(outcomes: list[Outcome], seconds: float) -> str:
    """Return the part of the documentation that a run renews."""
    solved = [o for o in outcomes if o.verdict == CERTIFIED]
    convolutions = [o.convolutions for o in solved]
    worst = max(solved, key=lambda o: o.certificate / tolerance_of(o.case))
    most = max(solved, key=lambda o: o.convolutions)
    notes = [
        f"{len(outcomes)} problems in {seconds:.0f} s, roughcontact {rc.__version__}, "
        f"Python {platform.python_version()}, NumPy {np.__version__}.",
        f"Convolutions: median {np.median(convolutions):.0f}, "
        f"95 % up to {np.quantile(convolutions, 0.95):.0f}, most {most.convolutions}.",
        f"Worst certificate: {worst}.",
        f"Most convolutions: {most}.",
    ]
    notes += [str(o) for o in outcomes if o.verdict in (GAVE_UP, WRONG)]
    return table(outcomes) + "\n\n" + "\n".join(f"- {note}" for note in notes)


def main() -> None:
    """Run the problems, print the table, and fail if anything was wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=500, help="number of problems")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--largest", type=int, default=1024, help="points along the longer side")
    parser.add_argument("--only", type=int, nargs="+", metavar="SEED", help="these seeds alone")
    parser.add_argument("--write", action="store_true", help=f"renew {PAGE.name}")
    options = parser.parse_args()
    seeds = options.only or range(options.first, options.first + options.count)
    began = time.perf_counter()
    outcomes = []
    for number, seed in enumerate(seeds, start=1):
        outcomes.append(attempt(draw(seed, options.largest)))
        if options.only or outcomes[-1].verdict in (GAVE_UP, WRONG):
            print(outcomes[-1], flush=True)
        elif number % 100 == 0:
            print(f"{number} of {len(seeds)}", flush=True)
    text = page(outcomes, time.perf_counter() - began)
    print(text)
    if options.write:
        before = PAGE.read_text(encoding="utf-8")
        head, tail = before.split(START)[0], before.split(END)[1]
        PAGE.write_text(f"{head}{START}\n{text}\n{END}{tail}", encoding="utf-8")
    if any(outcome.verdict == WRONG for outcome in outcomes):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
