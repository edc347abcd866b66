"""What a joint does on coarser and coarser grids: which answer hangs on which scales.

One self-affine map with waves down to four of its pixels, and the same on pixels two, four and
eight times as large, which have lost the finer waves: contact area, conductance (in proportion to
the stiffness in unloading), separation of the mean planes, permeability of the gap and its
narrowest place, each over that of the finest grid.
"""

from __future__ import annotations

import argparse

import numpy as np

import roughcontact as rc
from roughcontact.uncertainty.resolution import coarsen_pair

SIDE, RMS = 0.5e-3, 0.5e-6
STEEL = rc.Material(210e9, 0.3, 1e9)
UNIT = rc.Conductor(1.0, 1.0)


def told(pair: rc.contact.pair.Pair, pressure: float, ceiling: float | None) -> dict[str, float]:
    """Return what a joint does under a nominal pressure."""
    result = rc.solve(
        pair.surface,
        load=rc.NominalPressure(pressure),
        material=STEEL,
        ceiling=ceiling,
        boundary="periodic",
    )
    (conducts,) = rc.conductance(result, UNIT, UNIT).steps
    (leaks,) = rc.leakage(result, flow_axis="x").steps
    place = leaks.constriction[1]
    return {
        "contact area": result.contact_fraction,
        "conductance": conducts.length,
        "separation": float(result.gap.mean()),
        "permeability": leaks.permeability[1][1],
        "narrowest gap": 0.0 if place is None else place.gap,
    }


def main() -> None:
    """Print one table for each pressure, elastic and under a ceiling."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1024)
    points = parser.parse_args().points
    pixel = SIDE / points
    heights = rc.self_affine(
        (points, points),
        (pixel, pixel),
        rms_height=RMS,
        hurst=0.8,
        rolloff_wavelength=SIDE / 8,
        cutoff_wavelength=4 * pixel,
        rng=np.random.default_rng(1),
    )
    steel = {"material": STEEL, "boundary": "periodic"}
    fine = rc.solve(rc.Surface(heights, (pixel, pixel)), load=1.0, **steel).pair
    pairs = [fine]
    while len(pairs) < 4:
        pairs.append(coarsen_pair(pairs[-1]))
    for ceiling, pressure in ((None, 300e6), (None, 6e9), (3e9, 300e6), (3e9, 1e9)):
        rows = [told(pair, pressure, ceiling) for pair in pairs]
        share = rows[0]["contact area"]
        print(f"{pressure / 1e6:g} MPa, ceiling {ceiling}, {share:.1%} in contact")
        for name in rows[0]:
            ratios = (row[name] / rows[0][name] for row in rows)
            print(f"  {name:24}", *(f"{ratio:6.2f}" for ratio in ratios))


if __name__ == "__main__":
    main()
