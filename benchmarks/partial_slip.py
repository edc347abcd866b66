"""Partial slip beside the contact that it is of: time, applications and certificate.

    python benchmarks/partial_slip.py            # up to 1024 points per side
    python benchmarks/partial_slip.py 2048

The map is `rc.reference_map`, steel on steel, 1 N, friction 0.15, half of the force that slides.
Times are processor times, the smallest of three; contact and partial slip alternate.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TypeVar

import roughcontact as rc

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
FRICTION, REPEATS = 0.15, 3
T = TypeVar("T")


def timed(call: Callable[[], T]) -> tuple[T, float]:
    """Return what a call gives, and its processor time [s]."""
    began = time.process_time()
    return call(), time.process_time() - began


def row(points: int, boundary: str) -> str:
    """Return a row of the table."""
    heights, pixel = rc.reference_map(points)
    surface = rc.Surface(heights, pixel)

    def pressed() -> rc.ContactResult:
        return rc.solve(surface, material=STEEL, counter_material=STEEL, load=1.0,
                        boundary=boundary, calibrated=False)  # fmt: skip

    contact = pressed()
    times = []
    for _ in range(REPEATS):
        contact, normal = timed(pressed)
        found, slip = timed(lambda: rc.tangential(contact, friction=FRICTION, force="75 mN"))  # noqa: B023
        times.append((normal, slip))
    normal, slip = (min(column) for column in zip(*times, strict=True))
    last = found.last
    return (
        f"| {points}², {boundary} | {normal:.3g} s, {contact.convolutions} | {slip:.3g} s, "
        f"{last.applications} | {slip / normal:.1f} | {contact.certificate:.1e} | "
        f"{last.certificate:.1e} |"
    )


def main() -> None:
    """Print the table."""
    largest = int(sys.argv[1]) if len(sys.argv) > 1 else 1024
    heads = ("grid", "contact, convolutions", "partial slip, applications", "ratio",
             "certificate", "tangential certificate")  # fmt: skip
    print(f"| {' | '.join(heads)} |", "|---|---|---|---|---|---|", sep="\n")
    points = 256
    while points <= largest:
        for boundary in ("free", "periodic"):
            print(row(points, boundary), flush=True)
        points *= 2


if __name__ == "__main__":
    main()
