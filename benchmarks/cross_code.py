"""This program and the stored answers of its peers: the same problems, one certificate.

    python benchmarks/cross_code.py            # print the tables
    python benchmarks/cross_code.py --write    # and renew docs/evidence/cross_code.md

The answers are in ``tests/data/peers`` with the scripts that produced them; no peer is needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import roughcontact as rc
from measuring import EVIDENCE, make_parser, markdown, write_parts
from roughcontact.material.hardening import Linear

# isort: split
# Measuring makes them importable.
import block_with_calculix as block
import indentation
import passage
import problems

import judge

Array = NDArray[np.float64]

PAGE = EVIDENCE / "cross_code.md"
PEERS = ("contactmechanics", "tamaas", "aspher")
TOLERANCE = 1e-10
DIFFERENCES = ("pressure", "peak", "strain")
# Of the plastic strain, in double precision.
STRAIN_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Row:
    """A stored answer and that of this program.

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

    Its approach is the mean over the free pixels.
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
    """Return a stored answer and that of this program."""
    found, load_error = certificate(name, pressure)
    ceiling = problems.PROBLEMS[name].ceiling or math.inf
    full = pressure >= ceiling * (1 - 1e-12)
    return Row(
        peer,
        settings,
        name,
        found,
        load_error,
        own=judge.judge(result).certificate,
        difference=math.dist(pressure.ravel(), result.pressure.ravel())
        / float(np.linalg.norm(result.pressure)),
        touching=int(np.count_nonzero(result.contact)),
        contact=int(np.count_nonzero((pressure > 0) != result.contact)),
        saturated=int(np.count_nonzero(full != result.saturated)),
        peak=abs(float(pressure.max()) / result.max_pressure - 1),
    )


@dataclass(frozen=True)
class Indent:
    """One load of a stored indentation and that of this program.

    Parameters
    ----------
    peer, grid : str
        Whose answer, on which grid.
    load : float
        In units of Young's modulus and the side.
    error, residual : float
        Of the peer's loop, and of the plastic strain of this program.
    pressure : float
        Σ|p - p_peer| / Σ p_peer.
    peak : float
        Relative difference of the largest pressures.
    touching, contact : int
        Points in contact, and those in contact in one answer alone.
    strain : float
        Relative difference of the largest accumulated plastic strains.
    field, profile : float
        ∫|e - e_peer| / ∫ e_peer over the volume, and the largest difference under the apex over
        the largest strain there.
    """

    peer: str
    grid: str
    load: float
    error: float
    residual: float
    pressure: float
    peak: float
    touching: int
    contact: int
    strain: float
    field: float
    profile: float


def around_nodes(nodes: int) -> Array:
    """Return thicknesses of layers that reach half-way from each node to the next."""
    thickness = np.full(nodes, indentation.DEPTH / (nodes - 1))
    thickness[[0, -1]] /= 2
    return thickness


def indent(grid: str) -> list[rc.ElastoplasticResult]:
    """Return this program's answer to the named indentation, load by load."""
    pixel = indentation.SIDE / indentation.GRIDS[grid][1]
    law = Linear(indentation.YIELD, indentation.HARDENING)
    results: list[rc.ElastoplasticResult] = []
    for load in indentation.LOADS:
        start = results[-1] if results else None
        results.append(
            rc.solve_elastoplastic(
                rc.Surface(indentation.heights(grid), (pixel, pixel)),
                material=rc.Material(indentation.YOUNG, indentation.POISSON, hardening=law),
                increments=1,
                loads=[load],
                boundary="periodic",
                layers=None if start else around_nodes(indentation.GRIDS[grid][0]),
                tolerance=STRAIN_TOLERANCE,
                precision="double",
                start=start,
            )
        )
    return results


def compare_indentations(grids: tuple[str, ...] = tuple(indentation.GRIDS)) -> list[Indent]:
    """Return a row for every load of the stored indentations."""
    rows = []
    about, answers = indentation.load("tamaas")
    for grid in grids:
        answer, weight = answers[grid], around_nodes(indentation.GRIDS[grid][0])[:, None, None]
        middle = indentation.GRIDS[grid][1] // 2
        for number, result in enumerate(indent(grid)):
            theirs, pressure = answer.pressure[number], result.contact.pressure
            # A value at a node and the average over the layer around it.
            nodes, strain = answer.strain[number], result.bodies[0].accumulated
            under, below = nodes[:, middle, middle], strain[:, middle, middle]
            rows.append(
                Indent(
                    about["program"],
                    grid,
                    indentation.LOADS[number],
                    error=float(answer.error[number]),
                    residual=result.increments[-1].residual,
                    pressure=float(np.abs(pressure - theirs).sum() / theirs.sum()),
                    peak=float(abs(pressure.max() / theirs.max() - 1)),
                    touching=int(np.count_nonzero(result.contact.contact)),
                    contact=int(np.count_nonzero((theirs > 0) != result.contact.contact)),
                    strain=float(abs(strain.max() / nodes.max() - 1)),
                    field=float((weight * np.abs(strain - nodes)).sum() / (weight * nodes).sum()),
                    profile=float(np.abs(below - under).max() / under.max()),
                )
            )
    return rows


@dataclass(frozen=True)
class Place:
    """One place of the stored passage of a sphere and that of this program.

    Parameters
    ----------
    peer : str
        Whose answer.
    place : int
        How far the sphere has moved, in points.
    error, residual : float
        Of the peer's loop, and of the plastic strain of this program.
    pressure, peak, strain : float
        As for `Indent`.
    touching, contact : int
        As for `Indent`.
    """

    peer: str
    place: int
    error: float
    residual: float
    pressure: float
    peak: float
    strain: float
    touching: int
    contact: int


def pass_over() -> list[rc.ElastoplasticResult]:
    """Return this program's answer to the passage, place by place."""
    pixel = (indentation.SIDE / passage.POINTS,) * 2
    law = Linear(indentation.YIELD, indentation.HARDENING)
    results: list[rc.ElastoplasticResult] = []
    for place in passage.PLACES:
        start = results[-1] if results else None
        results.append(
            rc.solve_elastoplastic(
                rc.Surface(np.zeros((passage.POINTS,) * 2), pixel),
                counter_surface=rc.Surface(passage.heights(0), pixel),
                material=rc.Material(indentation.YOUNG, indentation.POISSON, hardening=law),
                path=[rc.PathPoint(passage.LOAD, (0.0, place * pixel[1]))],
                boundary="periodic",
                layers=None if start else around_nodes(passage.NODES),
                tolerance=STRAIN_TOLERANCE,
                precision="double",
                start=start,
            )
        )
    return results


def compare_passage() -> tuple[list[Place], float]:
    """Return a row for every place, and ∫|e - e_peer| / ∫ e_peer after the last."""
    about, answer = passage.load("tamaas")
    rows = []
    results = pass_over()
    for number, result in enumerate(results):
        theirs, pressure = answer.pressure[number], result.contact.pressure
        rows.append(
            Place(
                about["program"],
                passage.PLACES[number],
                error=float(answer.error[number]),
                residual=result.increments[-1].residual,
                pressure=float(np.abs(pressure - theirs).sum() / theirs.sum()),
                peak=float(abs(pressure.max() / theirs.max() - 1)),
                strain=float(abs(result.max_plastic_strain / answer.largest[number] - 1)),
                touching=int(np.count_nonzero(result.contact.contact)),
                contact=int(np.count_nonzero((theirs > 0) != result.contact.contact)),
            )
        )
    weight = around_nodes(passage.NODES)[:, None, None]
    difference = weight * np.abs(results[-1].bodies[0].accumulated - answer.strain)
    return rows, float(difference.sum() / (weight * answer.strain).sum())


@dataclass(frozen=True)
class Block:
    """The answer of a program to the rough block on one grid, at the first of two loads.

    Parameters
    ----------
    program : str
        Whose answer.
    points : int
        Elements, or pixels, per side of the block.
    nominal : float
        Nominal pressure [Pa].
    pressure, gap : numpy.ndarray
        At the nodes of the block [Pa], [m].
    share, mean_gap, stiffness : float
        Contact fraction, mean gap [m] and, from both loads, dp̄/dū [Pa/m].
    """

    program: str
    points: int
    nominal: float
    pressure: Array
    gap: Array
    share: float
    mean_gap: float
    stiffness: float


def compare_block() -> list[Block]:
    """Return the stored answers to the rough block, and those of this program."""
    rows = []
    with np.load(block.STORED) as stored:
        for points in block.GRIDS:
            nominal = [float(stored[f"nominal/{points}/{number}"]) for number in (0, 1)]
            pixel = block.SIDE / points * 1e-6
            surface = rc.Surface(block.mirror(block.heights(points)) * 1e-6, (pixel, pixel))
            own = [
                rc.solve(
                    surface,
                    material=rc.Material(block.YOUNG, block.POISSON),
                    load=rc.NominalPressure(pressure),
                    boundary="periodic",
                    tolerance=TOLERANCE,
                )
                for pressure in nominal
            ]
            cut = np.s_[: points + 1, : points + 1]
            answers = {"roughcontact": [(one.pressure[cut], one.gap[cut]) for one in own]}
            for program in ("tamaas", "contactmechanics", "calculix"):
                keys = [f"{program}/{points}/{number}" for number in (0, 1)]
                if f"{keys[0]}/pressure" not in stored.files:
                    continue
                pressures = [stored[f"{key}/pressure"] for key in keys]
                gaps = (
                    [stored[f"{key}/gap"] for key in keys]
                    if program == "calculix"
                    else [gap_below(pressure, surface) for pressure in pressures]
                )
                answers[program] = list(zip(pressures, gaps, strict=True))
            weight = np.outer(*[np.r_[0.5, np.ones(points - 1), 0.5] / points] * 2)
            for program, pairs in reversed(answers.items()):
                means = [float((weight * gap).sum()) for _, gap in pairs]
                pressure, gap = pairs[0]
                rows.append(
                    Block(
                        program,
                        points,
                        nominal[0],
                        pressure,
                        gap,
                        share=float((weight * (pressure > 0)).sum()),
                        mean_gap=means[0],
                        stiffness=(nominal[1] - nominal[0]) / (means[0] - means[1]),
                    )
                )
    return rows


def gap_below(pressure: Array, surface: rc.Surface) -> Array:
    """Return the gap of a pressure at the nodes of the block, by the independent judge [m]."""
    initial = surface.heights.max() - surface.heights
    whole = block.mirror(pressure)
    tail = surface.pixel, problems.MODULUS, "periodic"
    opened = judge.judge_fields(whole, initial, None, 0.0, *tail).gap
    gap: Array = opened - opened[whole > 0].mean()
    return np.maximum(gap, 0)[: len(pressure), : len(pressure)]


def block_table(rows: list[Block]) -> str:
    """Return the numbers of each program, and its difference to this one, as Markdown."""
    own = {row.points: row for row in rows if row.program == "roughcontact"}
    cells = []
    for row in rows:
        ours = own[row.points]
        distance = math.dist(row.pressure.ravel(), ours.pressure.ravel())
        cells.append(
            [
                row.program,
                f"{row.points}²",
                f"{row.nominal / 1e9:.4f} GPa",
                f"{row.share:.2%}",
                f"{row.mean_gap * 1e6:.4f} µm",
                f"{row.stiffness / 1e15:.2f} GPa/µm",
                f"{row.pressure.max() / 1e9:.2f} GPa",
                "" if row is ours else f"{distance / float(np.linalg.norm(ours.pressure)):.1e}",
            ]
        )
    head = ("program", "grid", "nominal pressure", "contact fraction", "mean gap", "stiffness")
    return markdown([*head, "largest pressure", "difference of pressures"], cells)


def passage_table(rows: list[Place]) -> str:
    """Return the largest differences over the places as Markdown."""
    head = ("program", "places", "pressures", "largest pressure", "largest plastic strain")
    cells = [
        rows[0].peer,
        str(len(rows)),
        *(f"{max(getattr(row, name) for row in rows):.2%}" for name in DIFFERENCES),
        str(sum(row.contact for row in rows)),
    ]
    return markdown([*head, "points in contact in one program only"], [cells])


def indentation_table(rows: list[Indent]) -> str:
    """Return the largest differences over the loads of each grid as Markdown."""
    cells = []
    for grid in dict.fromkeys(row.grid for row in rows):
        of_grid = [row for row in rows if row.grid == grid]
        cells.append(
            [
                of_grid[0].peer,
                grid,
                str(len(of_grid)),
                *(f"{max(getattr(row, name) for row in of_grid):.2%}" for name in DIFFERENCES),
                f"{max(row.field for row in of_grid):.1%}",
                str(sum(row.contact for row in of_grid)),
            ]
        )
    head = ("program", "grid", "loads", "pressures", "largest pressure", "largest plastic strain")
    return markdown([*head, "strain field", "points in contact in one program only"], cells)


def group_rows(rows: list[Row]) -> dict[tuple[str, str, str], list[Row]]:
    """Return the rows by program, settings and limit of the pressure."""
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        limit = "elastic" if problems.PROBLEMS[row.problem].ceiling is None else "ceiling"
        groups.setdefault((row.peer, row.settings, limit), []).append(row)
    return groups


def table(rows: list[Row]) -> str:
    """Return the largest errors and differences of each group as Markdown."""
    cells = [
        [
            *name,
            str(len(group)),
            *(f"{max(getattr(row, n) for row in group):.1e}" for n in ("certificate", "own")),
            f"{max(row.difference for row in group):.1e}",
            f"{sum(row.contact for row in group)}, {sum(row.saturated for row in group)}",
        ]
        for name, group in group_rows(rows).items()
    ]
    head = ("program", "settings", "pressure", "problems", "its certificate")
    compared = ("certificate of this program", "difference of pressures")
    last = "pixels in contact, saturated in one program only"
    return markdown([*head, *compared, last], cells)


def page(rows: list[Row]) -> str:
    """Return the part of the documentation that a run renews."""
    abouts = [problems.load(peer)[0] for peer in PEERS]
    made = "; ".join(f"{a['program']} {a['version']} (NumPy {a['numpy']})" for a in abouts)
    return f"Stored answers: {made}. This program: roughcontact {rc.__version__}.\n\n{table(rows)}"


def indentation_page(rows: list[Indent]) -> str:
    """Return the part on plasticity of the volume that a run renews."""
    about = indentation.load("tamaas")[0]
    made = f"{about['program']} {about['version']} (NumPy {about['numpy']}): {about['settings']}"
    return f"Stored answers: {made}.\n\n{indentation_table(rows)}"


def passage_page(rows: list[Place], field: float) -> str:
    """Return the part on a passage that a run renews."""
    after = f"After the last place the fields of the accumulated strain differ by {field:.1%}."
    return f"{after}\n\n{passage_table(rows)}"


def main() -> None:
    """Print the table."""
    parser = make_parser(__doc__)
    parser.add_argument("--write", action="store_true", help=f"renew {PAGE.name}")
    options = parser.parse_args()
    parts = (
        page(compare()),
        indentation_page(compare_indentations()),
        passage_page(*compare_passage()),
        block_table(compare_block()),
    )
    print(*parts, sep="\n\n")
    if options.write:
        write_parts("result", *parts, page=PAGE)


if __name__ == "__main__":
    main()
