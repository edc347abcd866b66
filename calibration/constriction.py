"""How far estimates of what a contact conducts are off: periodic Gaussian maps.

The correlations of rough joints and Greenwood's formula over the constriction length computed, on
self-affine maps of two Hurst exponents and three breadths of the spectrum, elastic and under a
ceiling, at three shares of the map in contact. `constriction.json` holds what
`python calibration/constriction.py` found.
"""

from __future__ import annotations

import argparse
import itertools
import json
from pathlib import Path

import numpy as np

import roughcontact as rc
from roughcontact.surface import roughness

SIDE, WAVES, RMS, CEILING = 0.5e-3, 8, 0.5e-6, 2e9
STEEL = rc.Material(210e9, 0.3)
UNIT = rc.Conductor(1.0, 1.0)
HURST, BREADTHS, SHARES = (0.5, 0.8), (4, 8, 16), (0.01, 0.03, 0.1)


def cases(points: int, seeds: int) -> list[dict[str, float | bool]]:
    """Return the estimates over what is computed, one case a map, ceiling and share."""
    found = []
    pixel = SIDE / points
    for hurst, breadth, seed in itertools.product(HURST, BREADTHS, range(seeds)):
        heights = rc.self_affine(
            (points, points),
            (pixel, pixel),
            rms_height=RMS,
            hurst=hurst,
            rolloff_wavelength=SIDE / WAVES,
            cutoff_wavelength=SIDE / WAVES / breadth,
            rng=np.random.default_rng(seed),
        )
        surface = rc.Surface(heights, (pixel, pixel))
        slope = roughness.rms_gradient(heights, (pixel, pixel))
        for ceiling, share in itertools.product((None, CEILING), SHARES):
            # Half of E* h' p, or the ceiling: about that share of the map.
            mean = share * (0.5 * 210e9 / 0.91 * slope if ceiling is None else ceiling)
            result = rc.solve(
                surface, load=mean * SIDE**2, material=STEEL, ceiling=ceiling, boundary="periodic"
            )
            (step,) = rc.conductance(result, UNIT, UNIT).steps
            found.append(
                {
                    "hurst": hurst,
                    "breadth": breadth,
                    "seed": seed,
                    "ceiling": ceiling is not None,
                    "contact": round(step.contact_area / SIDE**2, 4),
                    "correlation": round(step.correlation_length / step.length, 4),
                    "greenwood": round(step.greenwood_length / step.length, 4),
                }
            )
            print(found[-1], flush=True)
    return found


def main() -> None:
    """Compute all, store it, and print what bounds 95 % of the cases."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=512)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--store", type=Path, default=Path(__file__).with_suffix(".json"))
    options = parser.parse_args()
    found = cases(options.points, options.seeds)
    spread = {
        name: np.quantile([case[name] for case in found], (0.025, 0.5, 0.975)).round(3).tolist()
        for name in ("correlation", "greenwood")
    }
    head = {"points": options.points, "seeds": options.seeds, "spread": spread}
    lines = ",\n".join(f"  {json.dumps(case)}" for case in found)
    text = f'{json.dumps(head)[:-1]}, "cases": [\n{lines}\n]}}\n'
    options.store.write_text(text, encoding="utf-8")
    print(spread)


if __name__ == "__main__":
    main()
