"""Error of the ceiling model against plasticity of the volume, over load and ceiling.

    python calibration/ceiling_error.py             # table; about a quarter of an hour on one core
    python calibration/ceiling_error.py --write     # and the stored numbers and the tables
    python calibration/ceiling_error.py --quick     # a few cases, half a minute

Spheres from first yield to full plasticity and periodic rough maps, perfectly plastic and
hardening. Each is solved once with plasticity of the volume, with a row of ceilings, and with
``ceiling="calibrated"``. The stored numbers are those of the tables of the page of assumptions,
written with them, and of its chart. The data that the recommended ceiling is fitted to are in
ceiling_rule.py.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
from roughcontact.contact.ceiling import recommended_ceiling
from roughcontact.elastoplastic import ceiling_comparison
from roughcontact.material.hardening import Hardening, Linear, Perfect, Swift
from roughcontact.surface import random_surfaces, roughness
from roughcontact.theory import hertz

STORED = Path(__file__).with_suffix(".json")
PAGE = Path(__file__).parents[1] / "docs" / "assumptions.md"
MARKS = {
    "spheres": ("<!-- spheres -->", "<!-- end of spheres -->"),
    "maps": ("<!-- maps -->", "<!-- end of maps -->"),
}

YOUNG, POISSON, RADIUS = 210e9, 0.3, 1e-3
LAWS: dict[str, Hardening] = {
    "perfect": Perfect(1e9),
    # A fiftieth of Young's modulus.
    "linear": Linear(1e9, YOUNG / 50),
    # The bearing steel of Jacq et al. 2002.
    "Swift": Swift(1240e6, 30, 0.085),
}
FACTORS = [round(0.1 * number, 1) for number in range(14, 52, 2)]
RATIOS = [1.5, 3, 6, 12, 25, 40, 80, 120, 200, 300, 500, 700, 1500, 3000]
POINTS = 48
# A middle that is on no pixel: a circle then meets whole pixels in eight times the number of ways.
OFF = (0.31, 0.14)
# Loads over the last one: in smaller steps the mean pressure rises by another per cent.
PATH = [1.25 ** (number - 9) for number in range(10)]
# Plasticity indices E* h'/σ_Y of the rough maps, and their nominal pressures over σ_Y.
INDICES = {"perfect": [4, 8, 12, 20, 30, 40, 80], "linear": [8, 40], "Swift": [8, 40]}
NOMINAL = [0.03, 0.08, 0.16, 0.3, 0.42]
QUANTITIES = ["contact_area", "mean_pressure", "plateau_pressure", "approach"]


# Hertz's largest pressure at first yield over the yield strength, as in both fits.
FIRST_YIELD = 1.295 * math.exp(0.736 * POISSON)


def steel(law: Hardening, young: float = YOUNG) -> rc.Material:
    """Return an elastic-plastic material."""
    return rc.Material(young=young, poisson=POISSON, hardening=law)


def expected_area(ratio: float) -> float:
    """Return the contact area over that at first yield (Kogut and Etsion 2002), for the map."""
    if ratio < 1.03:
        return ratio ** (2 / 3)
    if ratio < 1.03 * 6**1.425:
        return 0.93 * (ratio / 1.03) ** (1.136 / 1.425)
    if ratio < 1.4 * 110**1.263:
        return 0.94 * (ratio / 1.4) ** (1.146 / 1.263)
    # Full plasticity: 2.8 yield strengths everywhere.
    return 2 / 3 * FIRST_YIELD * ratio / 2.8


def jackson_green_area(ratio: float) -> float:
    """Return the same after Jackson and Green 2005, for the perfectly plastic steel."""
    from scipy.optimize import brentq

    strain = 1e9 * (1 - POISSON**2) / YOUNG
    c, b = 1.295 * math.exp(0.736 * POISSON), 0.14 * math.exp(23 * strain)

    def load_ratio(w: float) -> float:
        if w < 1.9:
            return float(w**1.5)
        slope = math.pi * c * strain / 2 * math.sqrt(w) * (w / 1.9) ** (b / 2)
        hardness = 2.84 * (1 - math.exp(-0.82 * slope**-0.7))
        soft = math.exp(-0.25 * w ** (5 / 12)) * w**1.5
        return float(soft + 4 * hardness / c * (1 - math.exp(-(w ** (5 / 9)) / 25)) * w)

    w = brentq(lambda w: load_ratio(w) - ratio, 1e-3, 1e4)
    return float(w * max(w / 1.9, 1) ** b)


def sphere(
    law: Hardening, ratio: float, points: int, young: float = YOUNG
) -> tuple[rc.Surface, rc.Material, float]:
    """Return a map about 4.6 contact radii wide, its material, and the load."""
    body = steel(law, young)
    modulus = rc.contact_modulus(body, rc.RIGID)
    assert body.first_yield_pressure is not None
    first = hertz.first_yield_load(RADIUS, modulus, body.first_yield_pressure)
    radius = hertz.contact_radius(first, RADIUS, modulus) * math.sqrt(expected_area(ratio))
    pixel = (4.6 * radius / points,) * 2
    y, x = ((np.arange(points) - (points - 1) / 2 + off) * pixel[0] for off in OFF)
    return rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * RADIUS), pixel), body, ratio * first


def rough_case(
    law: Hardening, index: float, seed: int, points: int = 64
) -> tuple[rc.Surface, rc.Material]:
    """Return a self-affine period with this plasticity index, its shortest wave eight pixels."""
    body, pixel = steel(law), (1e-6, 1e-6)
    heights = random_surfaces.self_affine(
        (points, points),
        pixel,
        rms_height=1e-7,
        rolloff_wavelength=points / 4 * pixel[0],
        cutoff_wavelength=8 * pixel[0],
        rng=np.random.default_rng(seed),
    )
    slope = index * law.initial / rc.contact_modulus(body, rc.RIGID)
    return rc.Surface(heights * slope / roughness.rms_gradient(heights, pixel), pixel), body


def recommended_errors(
    both: rc.results.ModelComparison, place: int, boundary: str
) -> dict[str, Any]:
    """Return the recommended ceiling, and its errors."""
    usual = both.ceiling[both.factors.index(3.0)][place]
    again = rc.solve(
        usual.surface,
        material=usual.material,
        load=usual.load,
        boundary=boundary,
        ceiling="calibrated",
    )
    advice = recommended_ceiling(again)
    assert advice is not None
    factor = float(again.ceiling) / both.yield_strength
    alone = ceiling_comparison.ModelComparison(
        (factor,), ((again,),), (both.volume[place],), both.yield_strength
    )
    return {
        "load_ratio": advice.load_ratio,
        "slope": advice.slope,
        "factor": factor,
        **{name: float(alone.excess(name)[0, 0]) for name in QUANTITIES},
        "pressure_map": float(alone.map_error()[0, 0]),
    }


def ceiling_errors(both: rc.results.ModelComparison, place: int, boundary: str) -> dict[str, Any]:
    """Return the errors of all ceilings at one load."""
    state = both.volume[place]
    modulus = state.contact.contact_modulus
    return {
        "mean_pressure_ratio": float(both.mean_pressure_ratio[place]),
        "contact_fraction": state.contact.contact_fraction,
        "elastic_over_yield": modulus / both.yield_strength,
        "max_plastic_strain": state.max_plastic_strain,
        "errors": {
            **{name: both.excess(name)[:, place].tolist() for name in QUANTITIES},
            "pressure_map": both.map_error()[:, place].tolist(),
        },
        "best_factor": {name: float(both.best_factor(name)[place]) for name in QUANTITIES},
        "calibrated": recommended_errors(both, place, boundary),
    }


def mean(values: list[Any]) -> Any:
    """Return the mean of numbers, lists of them and dictionaries, place by place."""
    first = values[0]
    if isinstance(first, dict):
        return {key: mean([value[key] for value in values]) for key in first}
    if isinstance(first, list):
        return [mean(list(column)) for column in zip(*values, strict=True)]
    known = [value for value in values if not math.isnan(value)]
    return sum(known) / len(known) if known else math.nan


def spheres(quick: bool) -> list[dict[str, Any]]:
    """Return the errors on spheres, one row for each law and load."""
    rows = []
    for name, law in LAWS.items():
        ratios = [3, 12, 40] if quick else RATIOS if name == "perfect" else RATIOS[1:12:2]
        for ratio in ratios:
            surface, body, load = sphere(law, ratio, 32 if quick else POINTS)
            path = [load * part for part in (PATH[::3] if quick else PATH)]
            both = rc.compare_models(
                surface, material=body, increments=1, loads=path, factors=FACTORS
            )
            found = ceiling_errors(both, len(path) - 1, "free")
            print_case(f"{name} sphere, P/P_c = {ratio:g}", found)
            rows.append({"law": name, "load_ratio": ratio, **found})
    return rows


def maps(quick: bool) -> list[dict[str, Any]]:
    """Return the errors on rough maps, one row for each law, index, seed and load."""
    rows = []
    for name, law in LAWS.items():
        for index in [20] if quick else INDICES[name]:
            for seed in (0,) if quick else (0, 1):
                surface, body = rough_case(law, index, seed, 32 if quick else 64)
                area = surface.size[0] * surface.size[1]
                path = [nominal * law.initial * area for nominal in NOMINAL]
                both = rc.compare_models(
                    surface,
                    material=body,
                    increments=1,
                    loads=path,
                    factors=FACTORS,
                    boundary="periodic",
                )
                for place, nominal in enumerate(NOMINAL):
                    found = ceiling_errors(both, place, "periodic")
                    case = {"law": name, "index": index, "seed": seed, "nominal": nominal}
                    rows.append({**case, **found})
                    print_case(f"{name} map, E*h'/σ_Y = {index}, p̄/σ_Y = {nominal}", found)
    return rows


def print_case(words: str, found: dict[str, Any]) -> None:
    """Print one case in a line."""
    three, advice = FACTORS.index(3.0), found["calibrated"]
    print(
        f"{words:46} p̄/σ_Y {found['mean_pressure_ratio']:.2f}   "
        f"at 3: area {100 * found['errors']['contact_area'][three]:+5.1f} %, "
        f"approach {100 * found['errors']['approach'][three]:+5.1f} %   "
        f"at {advice['factor']:.2f}: {100 * advice['contact_area']:+5.1f} %, "
        f"{100 * advice['approach']:+5.1f} %",
        flush=True,
    )


def tables(found: dict[str, Any]) -> dict[str, str]:
    """Return the tables of the page of assumptions."""
    three = found["factors"].index(3.0)

    def percents(errors: list[float]) -> str:
        return " | ".join(
            f"{round(100 * error):+d}\N{NO-BREAK SPACE}%".replace("-", "−") for error in errors
        )

    spheres = [
        "| P/P_c | E\\*a/(σ_Y R) | p̄/σ_Y | Kogut and Etsion | Jackson and Green "
        "| factor | area at 3 | approach at 3 | area | approach |",
        "|" + "---|" * 10,
    ]
    for row in found["spheres"]:
        if row["law"] != "perfect":
            continue
        ratio, mean_pressure, advice = (
            row["load_ratio"],
            row["mean_pressure_ratio"],
            row["calibrated"],
        )
        index = math.sqrt(ratio * math.pi**2 * FIRST_YIELD**3 / (6 * mean_pressure))
        others = [
            2 / 3 * FIRST_YIELD * ratio / area
            for area in (expected_area(ratio), jackson_green_area(ratio))
        ]
        errors = [row["errors"][name][three] for name in ("contact_area", "approach")]
        left = [advice[name] for name in ("contact_area", "approach")]
        spheres.append(
            f"| {ratio:g} | {index:.2g} | {mean_pressure:.2f} | {others[0]:.2f} | {others[1]:.2f} "
            f"| {advice['factor']:.2f} | {percents(errors)} | {percents(left)} |"
        )
    maps = [
        "| material | E\\*h′/σ_Y | P/P_c | factor | area at 3 | approach at 3 | map at 3 "
        "| area | approach | map |",
        "|" + "---|" * 10,
    ]
    cases = dict.fromkeys((row["law"], row["index"]) for row in found["maps"])
    for law, index in cases:
        rows = [
            row
            for row in found["maps"]
            if (row["law"], row["index"]) == (law, index) and row["nominal"] > NOMINAL[0]
        ]
        advice = mean([row["calibrated"] for row in rows])
        usual = mean([row["errors"] for row in rows])
        names = ("contact_area", "approach", "pressure_map")
        ratio = float(f"{advice['load_ratio']:.2g}")
        maps.append(
            f"| {law} | {index} | {ratio:g} "
            f"| {advice['factor']:.2f} | {percents([usual[name][0] for name in names])} "
            f"| {percents([advice[name] for name in names])} |"
        )
    return {"spheres": "\n".join(spheres), "maps": "\n".join(maps)}


def read_stored() -> dict[str, Any]:
    """Return the stored file."""
    found: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return found


def write_page() -> None:
    """Write the tables into the page."""
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables(read_stored()).items():
        start, end = MARKS[name]
        before, after = text.index(start) + len(start), text.index(end)
        text = text[:before] + "\n" + table + "\n" + text[after:]
    PAGE.write_text(text, encoding="utf-8")


def main() -> None:
    """Compute, print, and write if asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"write {STORED.name}")
    parser.add_argument("--quick", action="store_true", help="a few cases on coarse grids")
    options = parser.parse_args()
    if options.quick and options.write:
        parser.error("--quick measures nothing that should be kept: leave out --write")
    began = time.perf_counter()
    balls, surfaces = spheres(options.quick), maps(options.quick)
    seconds = time.perf_counter() - began
    print(f"{seconds:.0f} s")
    if options.write:
        three = FACTORS.index(3.0)
        for row in surfaces:
            row["errors"] = {name: [values[three]] for name, values in row["errors"].items()}
        found = {
            "version": rc.__version__,
            "seconds": round(seconds),
            "factors": FACTORS,
            "spheres": balls,
            "maps": surfaces,
        }
        text = json.dumps(round_values(found), ensure_ascii=False)
        # One row a line.
        STORED.write_text(text.replace('{"law"', '\n{"law"') + "\n", encoding="utf-8")
        write_page()


def round_values(value: Any, digits: int = 3) -> Any:
    """Return numbers, lists and dictionaries of them with a number of digits, for JSON."""
    if isinstance(value, float):
        # JSON has no NaN.
        return None if math.isnan(value) else float(f"{value:.{digits}g}")
    if isinstance(value, dict):
        return {name: round_values(item, digits) for name, item in value.items()}
    if isinstance(value, list):
        return [round_values(item, digits) for item in value]
    return value


if __name__ == "__main__":
    main()
