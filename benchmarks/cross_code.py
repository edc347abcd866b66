"""This program beside the stored answers of its peers: the same problems, one certificate.

    python benchmarks/cross_code.py            # print the table
    python benchmarks/cross_code.py --write    # and renew docs/cross_code.md

The answers lie in ``tests/data/peers`` with the scripts that made them; no peer is needed here.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parents[1]
for folder in ("tests", "tests/data/peers"):
    if str(ROOT / folder) not in sys.path:
        sys.path.append(str(ROOT / folder))

import problems  # noqa: E402

import judge  # noqa: E402 - found beside the tests
import roughcontact as rc  # noqa: E402

Array = NDArray[np.float64]

PAGE = ROOT / "docs" / "cross_code.md"
START, END = "<!-- result -->", "<!-- end -->"
PEERS = ("contactmechanics", "tamaas", "aspher")
TOLERANCE = 1e-10


@dataclass(frozen=True)
class Row:
    """A stored answer beside that of this program.

    Parameters
    ----------
    peer, settings, problem : str
        Whose answer to what.
    certificate, load_error : float
        Of the peer's pressure, by the independent judge.
    own : float
        Certificate of this program's pressure, by the same judge.
    difference : float
        ‖p - p_peer‖ / ‖p‖.
    touching : int
        Pixels in contact.
    contact, saturated : int
        Pixels that touch, or are at the ceiling, in one of the answers alone.
    peak : float
        Relative difference of the largest pressures.
    """

    peer: str
    settings: str
    problem: str
    certificate: float
    load_error: float
    own: float
    difference: float
    touching: int
    contact: int
    saturated: int
    peak: float


def solve(name: str) -> rc.ContactResult:
    """Return this program's answer to a named problem, finer than any peer's."""
    problem = problems.PROBLEMS[name]
    return rc.solve(
        rc.Surface(problem.heights, problem.pixel),
        material=rc.Material(young=problems.MODULUS, poisson=0.0),
        load=problem.load,
        ceiling=problem.ceiling,
        boundary=problem.boundary,
        tolerance=TOLERANCE,
    )


def certificate(name: str, pressure: Array) -> tuple[float, float]:
    """Return ε and the load error of a bare pressure [Pa].

    Its approach is the mean of what the free pixels ask for.
    """
    problem = problems.PROBLEMS[name]
    limit = np.broadcast_to(problem.ceiling or math.inf, pressure.shape)
    initial = problem.heights.max() - problem.heights
    tail = problem.pixel, problems.MODULUS, problem.boundary
    opened = judge.judge_fields(pressure, initial, None, 0.0, *tail).gap
    # At the ceiling within the rounding of another program's units.
    pressure = np.where(pressure >= limit * (1 - 1e-12), limit, pressure)
    free = (pressure > 0) & (pressure < limit)
    approach = float(opened[free].mean())
    found = judge.judge_fields(pressure, initial, problem.ceiling, approach, *tail)
    return found.certificate, abs(found.load - problem.load) / problem.load


def compare() -> list[Row]:
    """Return a row for every stored answer."""
    own: dict[str, rc.ContactResult] = {}
    rows = []
    for peer in PEERS:
        for (settings, name), pressure in problems.load(peer)[1].items():
            if name not in own:
                own[name] = solve(name)
            rows.append(row_of(peer, settings, name, pressure, own[name]))
    return rows


def row_of(peer: str, settings: str, name: str, pressure: Array, result: rc.ContactResult) -> Row:
    """Return a stored answer beside that of this program."""
    found, load_error = certificate(name, pressure)
    ceiling = problems.PROBLEMS[name].ceiling or math.inf
    full = pressure >= ceiling * (1 - 1e-12)
    return Row(
        peer, settings, name, found, load_error,
        own=judge.judge(result).certificate,
        difference=math.dist(pressure.ravel(), result.pressure.ravel())
        / float(np.linalg.norm(result.pressure)),
        touching=int(np.count_nonzero(result.contact)),
        contact=int(np.count_nonzero((pressure > 0) != result.contact)),
        saturated=int(np.count_nonzero(full != result.saturated)),
        peak=abs(float(pressure.max()) / result.max_pressure - 1),
    )  # fmt: skip


def table(rows: list[Row]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| program | settings | problem | its certificate | its load error | certificate of this "
        "program | difference of the pressures | pixels that touch | of them not in both "
        "| saturated not in both | difference of the peaks |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.peer} | {row.settings} | {row.problem} | {row.certificate:.1e} "
        f"| {row.load_error:.0e} | {row.own:.1e} | {row.difference:.1e} | {row.touching} "
        f"| {row.contact} | {row.saturated} | {row.peak:.0e} |"
        for row in rows
    ]
    return "\n".join(lines)


def page(rows: list[Row]) -> str:
    """Return the part of the documentation that a run renews."""
    abouts = [problems.load(peer)[0] for peer in PEERS]
    made = "; ".join(f"{a['program']} {a['version']} (NumPy {a['numpy']})" for a in abouts)
    return f"Stored answers: {made}. This program: roughcontact {rc.__version__}.\n\n{table(rows)}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help=f"renew {PAGE.name}")
    options = parser.parse_args()
    text = page(compare())
    print(text)
    if options.write:
        before = PAGE.read_text(encoding="utf-8")
        head, tail = before.split(START)[0], before.split(END)[1]
        PAGE.write_text(f"{head}{START}\n{text}\n{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    main()
