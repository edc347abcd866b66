"""The rule behind ``ceiling="calibrated"``: what it is fitted to, and what it is shown on.

    python calibration/ceiling_rule.py             # table; about an hour on one core
    python calibration/ceiling_rule.py --write     # and the stored numbers and the tables
    python calibration/ceiling_rule.py --quick     # a few cases, a minute
    python calibration/ceiling_rule.py --judge     # the rule as it is now, on the stored volumes

Spheres over Poisson's ratio and load, which the constants of `yielding_sphere.mean_pressure` are
fitted to; pairs of bodies of which one or both yield, line contacts and rough maps, which they are
shown on. All are followed with plasticity of the volume in small steps of the load. What is
compared is contact area and approach, and what stays behind: the largest residual displacement
and the largest permanent indentation, and the plastic work and the dissipated energy of the
ceiling. The stored numbers are those of the tables of the page of assumptions, written with them.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import ceiling_error
import roughcontact as rc
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.surface import random_surfaces, roughness
from roughcontact.theory import hertz, indenters

STORED = Path(__file__).with_suffix(".json")
PAGE = ceiling_error.PAGE
MARKS = {
    name: (f"<!-- {name} -->", f"<!-- end of {name} -->")
    for name in ("rule", "shown", "confined", "imprint")
}

YOUNG, STRENGTH, RADIUS = 210e9, 1e9, 1e-3
# The loads of a path grow by this from one to the next, and begin at a twelfth of the last.
STEP, FIRST = 1.2, 12
FINE_STEP = 1.08
# A middle that is on no pixel: a circle then meets whole pixels in eight times the number of ways.
OFF = (0.31, 0.14)

FITTED = [0.0, 0.15, 0.3, 0.45, 0.49]
LOADS = [8, 40, 200]
# Loads of a path that are compared, over the last.
PARTS = [0.48, 0.69, 1.0]

STEEL = rc.Material(YOUNG, 0.3, STRENGTH)
# Counter-bodies, loads of first yield, and points of the map.
PAIRS: dict[str, tuple[rc.Material, list[float], int]] = {
    "both yield, alike": (STEEL, [40], 40),
    "both yield, 1 : 1.15": (rc.Material(YOUNG, 0.3, 1.15 * STRENGTH), [40], 40),
    "both yield, ν = 0.3 and 0": (rc.Material(YOUNG, 0.0, STRENGTH), [40], 40),
    "elastic counter-body, E": (rc.Material(YOUNG, 0.3), [8, 40, 200], 44),
    "elastic counter-body, E/3": (rc.Material(YOUNG / 3, 0.3), [40], 44),
}
LINES = [(0.1, 10), (0.3, 10), (0.45, 10), (0.1, 20), (0.3, 20), (0.45, 20)]
MAPS = [(nu, index) for index in (6, 12, 30) for nu in (0.1, 0.3, 0.45)]
NOMINAL = [0.01, 0.02, 0.03, 0.04, 0.055, 0.08, 0.1, 0.13, 0.16, 0.2, 0.25, 0.3]
NOMINAL_SEEN = [0.08, 0.16, 0.3]
# Rough maps (ν, E*h'/σ_Y, seed) and bi-sinusoidal ones (E*h'/σ_Y) with nominal pressures up to
# 3.3 σ_Y, which the confinement of spots is fitted to.
CONFINED = [(0.3, 3, 0), (0.3, 6, 0), (0.3, 12, 1), (0.3, 25, 0), (0.3, 50, 2), (0.3, 100, 0)]
CONFINED += [(0.1, 25, 3), (0.45, 25, 4)]
BISINUSOIDAL = [10, 25]
HIGH = [0.01, 0.02, 0.04, 0.08, 0.13, 0.19, 0.25, 0.35, 0.5, 0.7, 1.0, 1.25, 1.5, 1.75, 2.0]
HIGH += [2.25, 2.5, 2.75, 2.9, 3.1, 3.3]
CONFINED_NAMES = {"confined": "rough", "bi-sinusoidal": "bi-sinusoidal"}
SHOWN_NOMINAL = [0.5, 1.0, 2.0, 2.9, 3.3]
HIGH_SEEN = [0.25, 0.5, 0.7, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 2.9, 3.1, 3.3]


@dataclass(frozen=True)
class Case:
    """A problem that is followed with plasticity of the volume.

    Parameters
    ----------
    names : dict
        Description.
    surface, material, counter_material, boundary
        The problem.
    path : list of float
        Loads [N].
    seen : list of int
        Which of them are compared.
    first : float
        Load of first yield of a sphere [N].
    """

    names: dict[str, Any]
    surface: rc.Surface
    material: rc.Material
    path: list[float]
    seen: list[int]
    counter_material: rc.Material = rc.RIGID
    boundary: str = "free"
    first: float = math.nan

    @property
    def bodies(self) -> dict[str, Any]:
        """Arguments of every solver."""
        return {
            "material": self.material,
            "counter_material": self.counter_material,
            "boundary": self.boundary,
        }


def geometric_loads(last: float, step: float) -> list[float]:
    """Return loads that grow in equal ratios of about this step."""
    count = math.ceil(math.log(FIRST) / math.log(step))
    return [last * FIRST ** (number / count - 1) for number in range(count + 1)]


def nearest(path: list[float], parts: list[float]) -> list[int]:
    """Return the places in a path that are nearest to these parts of its last load."""
    return [int(np.argmin(np.abs(np.log(np.array(path) / path[-1] / part)))) for part in parts]


def sphere(
    ratio: float,
    material: rc.Material,
    counter: rc.Material = rc.RIGID,
    step: float = STEP,
    points: int = 44,
    **names: Any,
) -> Case:
    """Return a sphere up to a number of loads of first yield, its map 4.6 contact radii wide."""
    modulus = rc.contact_modulus(material, counter)
    assert material.first_yield_pressure is not None
    first = hertz.first_yield_load(RADIUS, modulus, material.first_yield_pressure)
    radius = hertz.contact_radius(first, RADIUS, modulus)
    radius *= math.sqrt(ceiling_error.expected_area(ratio))
    pixel = 4.6 * radius / points
    y, x = ((np.arange(points) - (points - 1) / 2 + off) * pixel for off in OFF)
    surface = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * RADIUS), (pixel, pixel))
    path = geometric_loads(ratio * first, step)
    return Case(names, surface, material, path, nearest(path, PARTS), counter, first=first)


def line(nu: float, index: float, points: int = 192) -> Case:
    """Return cylinders side by side, eight Hertz half-widths apart, up to this E*b/(σ_Y R)."""
    material = rc.Material(YOUNG, nu, STRENGTH)
    modulus = rc.contact_modulus(material, rc.RIGID)
    half = index * STRENGTH * RADIUS / modulus
    pixel = 8 * half / points
    x = (np.arange(points) - (points - 1) / 2 + OFF[0]) * pixel
    surface = rc.Surface(np.tile(-(x**2) / (2 * RADIUS), (8, 1)), (pixel, pixel))
    mean = {10: 2.1, 20: 2.5}[int(index)] * STRENGTH
    path = geometric_loads(mean * 2 * half * surface.size[0], STEP)
    return Case(
        {"kind": "line", "poisson": nu, "index": index},
        surface,
        material,
        path,
        nearest(path, PARTS),
        boundary="periodic",
    )


def rough_case(nu: float, index: float, points: int = 64, seed: int = 0) -> Case:
    """Return a self-affine period with this plasticity index E* h'/σ_Y."""
    pixel = (1e-6, 1e-6)
    heights = random_surfaces.self_affine(
        (points, points),
        pixel,
        rms_height=1e-7,
        rolloff_wavelength=points / 4 * pixel[0],
        cutoff_wavelength=8 * pixel[0],
        rng=np.random.default_rng(seed),
    )
    names = {"kind": "map", "poisson": nu, "index": index, "points": points, "seed": seed}
    return periodic(names, heights, NOMINAL, NOMINAL_SEEN)


def periodic(names: dict[str, Any], heights: Any, nominal: list[float], seen: list[float]) -> Case:
    """Return a period with this plasticity index, up to these nominal pressures over σ_Y."""
    material, pixel = rc.Material(YOUNG, names["poisson"], STRENGTH), (1e-6, 1e-6)
    slope = names["index"] * STRENGTH / rc.contact_modulus(material, rc.RIGID)
    surface = rc.Surface(heights * slope / roughness.rms_gradient(heights, pixel), pixel)
    return Case(
        names,
        surface,
        material,
        [pressure * STRENGTH * surface.size[0] * surface.size[1] for pressure in nominal],
        [nominal.index(pressure) for pressure in seen],
        boundary="periodic",
    )


def confined_cases(points: int = 64) -> Iterator[Case]:
    """Yield the periodic maps on which neighboring spots confine each other."""
    for nu, index, seed in CONFINED:
        names = {"kind": "confined", "poisson": nu, "index": index, "seed": seed}
        yield periodic(names, rough_case(nu, index, points, seed).surface.heights, HIGH, HIGH_SEEN)
    wave = np.cos(2 * np.pi * np.arange(points) / points)
    for index in BISINUSOIDAL:
        names = {"kind": "bi-sinusoidal", "poisson": 0.3, "index": index, "seed": None}
        yield periodic(names, np.outer(wave, wave), HIGH, HIGH_SEEN)


def cases(quick: bool) -> Iterator[Case]:
    """Yield what is followed: what the rule is fitted to first."""
    for ratio in [8] if quick else LOADS:
        for nu in [0.1] if quick else FITTED:
            material = rc.Material(YOUNG, nu, STRENGTH)
            points = 32 if quick else 44
            yield sphere(ratio, material, points=points, kind="sphere", poisson=nu)
    if quick:
        yield rough_case(0.3, 12, 32)
        return
    for nu, ratio in ((0.3, 8), (0.3, 40), (0.0, 40), (0.3, 200)):
        material = rc.Material(YOUNG, nu, STRENGTH)
        yield sphere(ratio, material, step=FINE_STEP, kind="finer", poisson=nu)
    for name, (counter, loads, points) in PAIRS.items():
        for ratio in loads:
            yield sphere(ratio, STEEL, counter, points=points, kind=name, poisson=0.3)
    for nu, index in LINES:
        yield line(nu, index)
    for nu, index in MAPS:
        yield rough_case(nu, index)
    yield rough_case(0.3, 12, 96, seed=1)
    yield from confined_cases()


def plastic_work(state: ElastoplasticResult) -> float:
    """Return the plastic work of perfectly plastic bodies [J]."""
    found = 0.0
    for body in state.bodies:
        strain = body.accumulated.sum(axis=(1, 2), dtype=float) @ body.thickness
        found += float(strain) * body.pixel_area * (body.material.yield_strength or 0.0)
    return found


def volume_results(case: Case) -> Iterator[dict[str, Any]]:
    """Yield what plasticity of the volume gives at the loads that are compared."""
    state = None
    for number, load in enumerate(case.path):
        state = rc.solve_elastoplastic(
            case.surface, increments=1, loads=[load], start=state, **case.bodies
        )
        if number in case.seen:
            yield {
                **case.names,
                "last": _finite_or_none(case.path[-1] / case.first),
                "load": load,
                "load_ratio": _finite_or_none(load / case.first),
                "area": state.perimeter_corrected_area,
                "approach": state.solution.approach,
                "depth": float(state.residual_displacement.max()),
                "energy": plastic_work(state),
            }


def _finite_or_none(value: float) -> float | None:
    return None if math.isnan(value) else value


def compare_ceilings(case: Case, volume: dict[str, Any]) -> dict[str, Any]:
    """Return the results of both ceilings and of the volume model."""
    row = dict(volume)
    for name in ("auto", "calibrated"):
        # Three yield strengths cannot carry a higher nominal pressure.
        with contextlib.suppress(rc.CapacityError):
            row[name] = ceiling_ratio(case, volume, name)
    return row


def ceiling_ratio(case: Case, volume: dict[str, Any], ceiling: str) -> dict[str, float]:
    """Return the ratio of a ceiling result to that of the volume model."""
    found = rc.solve(case.surface, load=volume["load"], ceiling=ceiling, **case.bodies)
    left = found.residual_indentation
    energy = float((found.pressure * left).sum()) * found.pixel_area
    row = {
        "area": found.perimeter_corrected_area / volume["area"] - 1,
        "approach": found.approach / volume["approach"] - 1,
        "depth": float(left.max()) / volume["depth"],
        "energy": energy / volume["energy"],
    }
    if found.calibration is not None:
        row |= {"factor": found.calibration.factor, "judged": found.calibration.load_ratio}
    return row


def fit_constants(rows: list[dict[str, Any]]) -> list[float]:
    """Return the constants of `yielding_sphere.mean_pressure` that fit the spheres best.

    Smaller steps of the load raise the mean pressure; it is taken to the limit of none.
    """
    from scipy.optimize import least_squares

    spheres = [row for row in rows if row["kind"] == "sphere"]
    load = np.array([row["load"] for row in spheres])
    mean = load / [row["area"] for row in spheres] * (1 + refinement(rows)) / STRENGTH
    poisson = np.array([row["poisson"] for row in spheres])
    first = 1.295 * np.exp(0.736 * poisson)
    ratio = np.array([row["load_ratio"] for row in spheres])
    way = np.log(np.sqrt(ratio * math.pi**2 * first**3 / (6 * mean)) / (math.pi * first / 2))
    distance = indenters.PLATEAU - 2 * first / 3
    # Contacts of few pixels, at the lower loads of a path, are known less well.
    weight = np.where(ratio < 0.6 * np.array([row["last"] for row in spheres]), 0.5, 1.0)

    def missed(constants: Any) -> Any:
        one, two, three = constants
        fall = one * (2 * first / 3) / distance * way + two * way**2 + three * way**3
        return weight * ((indenters.PLATEAU - distance * np.exp(-fall)) / mean - 1)

    return [float(value) for value in least_squares(missed, (1.0, 0.0, 0.0)).x]


def refinement(rows: list[dict[str, Any]]) -> float:
    """Return by which part the mean pressure would rise from the steps taken to none."""
    found = [
        _sphere_row(rows, row["poisson"], row["load_ratio"])["area"] / row["area"] - 1
        for row in rows
        if row["kind"] == "finer" and row["load_ratio"] > 0.99 * row["last"]
    ]
    # The error of a step grows with its logarithm.
    return math.log(STEP) / math.log(STEP / FINE_STEP) * sum(found) / len(found)


# Tables


def percents(*errors: float) -> str:
    """Return relative errors as cells of a table."""
    errors_text = (f"{100 * error:+.0f}\N{NO-BREAK SPACE}%".replace("-", "−") for error in errors)
    return " | ".join(errors_text)


def tables(rows: list[dict[str, Any]]) -> dict[str, str]:
    """Return the tables of the page of assumptions."""
    return {
        "rule": _rule(rows),
        "shown": _sphere_table(rows),
        "confined": _confined_table(rows),
        "imprint": _imprint(rows),
    }


def _sphere_row(rows: list[dict[str, Any]], poisson: float, ratio: float) -> dict[str, Any]:
    known = [r for r in rows if r["kind"] == "sphere" and r["poisson"] == poisson]
    return min(known, key=lambda r: abs(math.log(r["load_ratio"] / ratio)))


def _rule(rows: list[dict[str, Any]]) -> str:
    lines = ["| ν | P/P_c | p̄/σ_Y | factor | area at 3 | area | approach |", "|" + "---|" * 7]
    for poisson in FITTED:
        for ratio in LOADS:
            row = _sphere_row(rows, poisson, ratio)
            mean = row["load"] / row["area"] / STRENGTH
            three, advised = row["auto"], row["calibrated"]
            lines.append(
                f"| {poisson:g} | {ratio:g} | {mean:.2f} | {advised['factor']:.2f} | "
                f"{percents(three['area'], advised['area'], advised['approach'])} |"
            )
    return "\n".join(lines)


def _sphere_table(rows: list[dict[str, Any]]) -> str:
    lines = ["| contact | ν | P/P_c | factor | area at 3 | area | approach |", "|" + "---|" * 7]
    for name, row in last_of_each(rows):
        three, advised = row["auto"], row["calibrated"]
        ratio = float(f"{advised['judged']:.2g}")
        lines.append(
            f"| {name} | {row['poisson']:g} | {ratio:g} | {advised['factor']:.2f} | "
            f"{percents(three['area'], advised['area'], advised['approach'])} |"
        )
    return "\n".join(lines)


def last_of_each(rows: list[dict[str, Any]]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield a name and the row at the largest load of every case that the rule is shown on."""
    names = {"line": "line, E\\*b/(σ_Y R) to {}", "map": "rough map, E\\*h′/σ_Y = {}"}
    keys = ("kind", "poisson", "index", "points", "last")
    last = {tuple(row.get(key) for key in keys): row for row in rows}
    for row in last.values():
        if row["kind"] not in ("sphere", "finer", *CONFINED_NAMES):
            yield names.get(row["kind"], row["kind"]).format(row.get("index")), row


def _confined_table(rows: list[dict[str, Any]]) -> str:
    heads = [
        f"{head} {nominal:g}" for nominal in SHOWN_NOMINAL for head in ("contact at", "error at")
    ]
    lines = [f"| surface | ν | E\\*h′/σ_Y | {' | '.join(heads)} |", "|" + "---|" * (3 + len(heads))]
    found = [row for row in rows if row["kind"] in CONFINED_NAMES]
    for start in range(0, len(found), len(HIGH_SEEN)):
        first = found[start]
        cells = [CONFINED_NAMES[first["kind"]], f"{first['poisson']:g}", f"{first['index']:g}"]
        for nominal in SHOWN_NOMINAL:
            row = found[start + HIGH_SEEN.index(nominal)]
            area = row["area"] * nominal * STRENGTH / row["load"]
            cells += [f"{100 * area:.0f}\N{NO-BREAK SPACE}%", percents(row["calibrated"]["area"])]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _imprint(rows: list[dict[str, Any]]) -> str:
    lines = [
        "| contact | P/P_c | ceiling at 3 over recommended | depth at 3 | energy at 3 "
        "| depth | energy |",
        "|" + "---|" * 7,
    ]
    spheres = [("sphere", _sphere_row(rows, 0.3, ratio)) for ratio in (8, 20, 40, 96, 200)]
    spheres += [
        (f"sphere, ν = {nu:g}", _sphere_row(rows, nu, 40)) for nu in (0.0, 0.15, 0.45, 0.49)
    ]
    maps = [(name, row) for name, row in last_of_each(rows) if row["kind"] == "map"]
    for name, row in [*spheres, *maps]:
        three, advised = row["auto"], row["calibrated"]
        cells = " | ".join(
            f"{one[what]:.2f}" for one in (three, advised) for what in ("depth", "energy")
        )
        where = name if row["kind"] == "sphere" else f"{name}, ν = {row['poisson']:g}"
        ratio = float(f"{advised['judged']:.2g}")
        lines.append(f"| {where} | {ratio:g} | {3 / advised['factor']:.2f} | {cells} |")
    return "\n".join(lines)


def read_stored() -> dict[str, Any]:
    """Return the stored file."""
    found: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return found


def write(rows: list[dict[str, Any]]) -> None:
    """Write the numbers, one row a line, and the tables of the page."""
    found = {"version": rc.__version__, "fit": fit_constants(rows), "rows": rows}
    text = json.dumps(ceiling_error.round_values(found, 5), ensure_ascii=False)
    STORED.write_text(text.replace('{"kind"', '\n{"kind"') + "\n", encoding="utf-8")
    page = PAGE.read_text(encoding="utf-8")
    for name, table in tables(read_stored()["rows"]).items():
        start, end = MARKS[name]
        before, after = page.index(start) + len(start), page.index(end)
        page = page[:before] + "\n" + table + "\n" + page[after:]
    PAGE.write_text(page, encoding="utf-8")


def recompute_rows(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return stored rows with what both ceilings give now."""
    found, left = [], list(rows)
    for case in cases(quick=False):
        found += [compare_ceilings(case, left.pop(0)) for _ in case.seen]
    return found


def main() -> None:
    """Compute, print, and write if asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"write {STORED.name}")
    parser.add_argument("--judge", action="store_true", help="take the volumes that are stored")
    parser.add_argument("--quick", action="store_true", help="a few cases on coarse grids")
    options = parser.parse_args()
    if options.quick and (options.write or options.judge):
        parser.error("--quick measures nothing that should be kept: leave out the others")
    began = time.perf_counter()
    if options.judge:
        rows = recompute_rows(read_stored()["rows"])
    else:
        rows = []
        for case in cases(options.quick):
            rows += [compare_ceilings(case, volume) for volume in volume_results(case)]
            print_case(rows[-1])
    for table in () if options.quick else tables(rows).values():
        print(f"\n{table}")
    if not options.quick:
        print("\na, b, c:", *(f"{value:.4g}" for value in fit_constants(rows)))
    print(f"{time.perf_counter() - began:.0f} s")
    if options.write:
        write(rows)


def print_case(row: dict[str, Any]) -> None:
    """Print the last load of a case in a line."""
    three, advised = row["auto"], row["calibrated"]
    print(
        f"{row['kind']}, ν = {row['poisson']:g}: at 3: area {100 * three['area']:+.1f} %   "
        f"recommended {advised.get('factor', 3):.2f}: area {100 * advised['area']:+.1f} %, "
        f"approach {100 * advised['approach']:+.1f} %, depth {advised['depth']:.2f}, "
        f"energy {advised['energy']:.2f}",
        flush=True,
    )


if __name__ == "__main__":
    main()
