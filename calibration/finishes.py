"""How often the intervals of `rc.estimate` from Ra and finish hold solved contacts.

Generated finishes have random slopes between the ends of the interval of the slope, those of turned
faces follow from feed and nose of the tool; measured maps of a folder have their own.
`finishes.json` holds what `python calibration/finishes.py --measured FOLDER` found.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import atlas_cases
import roughcontact as rc

STORED = Path(__file__).with_suffix(".json")
POINTS = 256
HONED = -1.0  # Skewness of honed faces
MEASURED = {
    "wyko_nt1100_test_1.opd": "lapped",
    "x3p-2.x3p": "ground",
    "bullet_land_fixed.x3p": "planed",
}


def generated_maps(count: int) -> Iterator[tuple[str, rc.Surface]]:
    """Yield finishes and maps."""
    rng = np.random.default_rng(54)
    for index in range(count):
        finish = ("ground", "milled", "lapped", "blasted", "honed", "turned")[index % 6]
        height = 1e-6 * 0.4 * 2.0 ** rng.integers(4)
        drawn = rc.estimate(pressure=1e8, material="C45", Ra=height, finish=finish).roughness
        shape: dict[str, Any] = {
            "Sq": drawn.Sq,
            "Sdq": drawn.Sdq * 2 ** rng.uniform(-1, 1),
            "hurst": rng.uniform(0.5, 0.9),
            "rng": int(rng.integers(1 << 30)),
        }
        if finish in ("ground", "milled"):
            shape |= {"Str": rng.uniform(0.1, 0.3)}
        elif finish == "honed":
            shape |= {"Str": 0.2, "honing": 45.0, "Ssk": HONED}
        side = POINTS * math.pi / 10 * drawn.Sq / shape["Sdq"]
        if finish == "turned":
            nose = 0.8e-3
            feed = math.sqrt(31.2 * nose * height * 0.9)
            shape |= {"turning": (feed, nose), "Sdq": None}
            side = 4 * feed
        yield finish, rc.generate(POINTS, side / POINTS, **shape)


def measured_maps(folder: Path) -> Iterator[tuple[str, rc.Surface]]:
    """Yield finishes and measured maps, continued by their mirror images."""
    for name, finish in MEASURED.items():
        yield finish, atlas_cases.read_measured(folder / name)[0]


def case(finish: str, surface: rc.Surface, index: int) -> dict[str, Any]:
    """Return the quantities of a solved contact of a map."""
    name, pressure = (("C45", 20e6), ("6082-T6", 10e6), ("42CrMo4", 60e6))[index % 3]
    result = rc.solve(
        surface,
        material=name,
        counter_material=name,
        load=rc.NominalPressure(pressure),
        boundary="periodic",
    )
    (step,) = (flow := rc.conductance(result, name, name)).steps
    area = math.prod(surface.size)
    return {
        "finish": finish,
        "Ra": surface.roughness()["Sa"],
        "Ssk": HONED if finish == "honed" else 0.0,
        "material": name,
        "pressure": pressure,
        "contact": result.perimeter_corrected_area / area,
        "gap": result.mean_gap,
        "vacuum_conductance": float(flow.thermal_conductance[0]),
        "air_conductance": float(flow.thermal_conductance[0] + step.air_gap),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--measured", type=Path, required=True, help="folder of measured maps")
    parser.add_argument("--count", type=int, default=18, help="number of generated maps")
    options = parser.parse_args()
    maps = [*generated_maps(options.count), *measured_maps(options.measured)]
    cases = [case(finish, surface, index) for index, (finish, surface) in enumerate(maps)]
    STORED.write_text(json.dumps(cases, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
