"""Partial slip beside the contact that it is of: time, applications and certificate.

    python benchmarks/partial_slip.py                  # up to 1024 points per side
    python benchmarks/partial_slip.py 2048
    python benchmarks/partial_slip.py FILE "50 MPa"    # a measured map, leveled

The map is `rc.reference_map`, steel on steel, 1 N, friction 0.15, half of the force that slides.
Times are processor times, the smallest of three; contact and partial slip alternate. A pair is one
field transformed forward and backward on the grid of the displacement operator; pairs on smaller
grids count by their points.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, TypeVar

import roughcontact as rc
from roughcontact.analyses.tangential.model import Tangential
from roughcontact.halfspace.convolution import Convolution
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.tangential import TangentialConvolution

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
FRICTION, REPEATS = 0.15, 3
T = TypeVar("T")


def timed(call: Callable[[], T]) -> tuple[T, float]:
    """Return what a call gives, and its processor time [s]."""
    began = time.process_time()
    return call(), time.process_time() - began


def counted(call: Callable[[], object], points: int) -> float:
    """Return the pairs of transforms that a call takes, those of the largest grid as one."""
    pairs = [0.0]
    single, double = Convolution._apply, TangentialConvolution.gather

    def count(fields: int, operator: Convolution) -> None:
        pairs[0] += fields * operator.padded[0] * operator.padded[1] / points

    def one(self: Convolution, *arguments: Any) -> None:
        count(1, self)
        single(self, *arguments)

    def two(self: TangentialConvolution, *arguments: Any) -> Any:
        count(2, self)
        return double(self, *arguments)

    Convolution._apply, TangentialConvolution.gather = one, two  # type: ignore[method-assign]
    try:
        call()
    finally:
        Convolution._apply, TangentialConvolution.gather = single, double  # type: ignore[method-assign]
    return pairs[0]


def row(surface: rc.Surface, boundary: str, load: Any = 1.0) -> str:
    """Return a row of the table."""

    def pressed() -> rc.ContactResult:
        return rc.solve(
            surface,
            material=STEEL,
            counter_material=STEEL,
            load=load,
            boundary=boundary,
            calibrated=False,
        )

    contact = pressed()

    def slipped() -> Tangential:
        return rc.tangential(contact, friction=FRICTION, force=0.5 * FRICTION * contact.load)

    grid = contact.pair.operators("double", Workspace())(contact.pair.shape, (1, 1)).padded
    pairs = [counted(call, grid[0] * grid[1]) for call in (pressed, slipped)]
    times = []
    for _ in range(REPEATS):
        contact, normal = timed(pressed)
        found, slip = timed(slipped)
        times.append((normal, slip))
    normal, slip = (min(column) for column in zip(*times, strict=True))
    last = found.last
    return (
        f"| {' × '.join(map(str, surface.shape))}, {boundary} | {normal:.3g} s, {pairs[0]:.0f} | "
        f"{slip:.3g} s, {pairs[1]:.0f} | "
        f"{slip / normal:.1f}, {pairs[1] / pairs[0]:.1f} | {contact.certificate:.1e} | "
        f"{last.certificate:.1e} |"
    )


def main() -> None:
    """Print the table."""
    asked = sys.argv[1] if len(sys.argv) > 1 else "1024"
    heads = (
        "grid",
        "contact, pairs",
        "partial slip, pairs",
        "ratio of both",
        "certificate",
        "tangential certificate",
    )
    print(f"| {' | '.join(heads)} |", "|---|---|---|---|---|---|", sep="\n")
    if not asked.isdigit():
        measured = rc.read_surface(asked).filled().leveled()
        print(row(measured, "free", rc.NominalPressure(sys.argv[2])))
        return
    points = 256
    while points <= int(asked):
        for boundary in ("free", "periodic"):
            print(row(rc.Surface(*rc.reference_map(points)), boundary), flush=True)
        points *= 2


if __name__ == "__main__":
    main()
