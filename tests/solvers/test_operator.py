"""The solver on operators of another make, and on maps whose rows lie on several processes."""

import ast
import math
import threading
from functools import cache

import numpy as np
import pytest

from paths import ROOT
from roughcontact.halfspace import convolution, kernels
from roughcontact.halfspace.convolution import LocalSums
from roughcontact.solvers import active_set, bounded, preconditioner, rigid_tilt
from roughcontact.solvers.problem import BoundedProblem, project, remove_rounding
from roughcontact.solvers.progress import Status

SHAPE, PIXEL, MODULUS = (24, 31), (0.7, 1.0), 1.0
SOLVERS = ROOT / "src" / "roughcontact" / "solvers"


class Group:
    """Processes that wait for each other to exchange what they hold; here they are threads."""

    def __init__(self, edges):
        self.edges = edges
        self.count = len(edges) - 1
        self.barrier = threading.Barrier(self.count, timeout=120)
        self.held = [None] * self.count

    def exchange(self, rank, part):
        self.held[rank] = part
        self.barrier.wait()
        everyone = list(self.held)
        self.barrier.wait()
        return everyone


class GroupSums:
    """Local results, exchanged and added up in the order of the ranks."""

    def __init__(self, group, rank):
        self.group, self.rank = group, rank
        self.calls = 0

    def _parts(self, part):
        self.calls += 1
        return self.group.exchange(self.rank, part)

    def size(self, values):
        return sum(self._parts(values.size))

    def total(self, values):
        return math.fsum(self._parts(float(np.sum(values))))

    def dot(self, first, second):
        return math.fsum(self._parts(float(np.sum(first * second))))

    def count(self, chosen):
        return sum(self._parts(int(np.sum(chosen))))

    def largest(self, values, floor=-math.inf):
        return float(max(self._parts(np.max(values, initial=floor))))

    def smallest(self, values, limit=math.inf):
        return float(min(self._parts(np.min(values, initial=limit))))

    def allreduce(self, parts):
        return np.sum(self._parts(np.asarray(parts)), axis=0)


class Chosen:
    def __init__(self, index, size):
        self.index, self.starts = index, np.array([0, size])


class Dense:
    """A symmetric matrix that keeps the protocol and nothing more: one block of rows, no FFT."""

    real = np.float64
    periodic_axes, is_long_wave_soft = (True, True), False

    def __init__(self, matrix, shape, rows, sums):
        self.matrix, self.shape, self.rows, self.sums = matrix, shape, rows, sums
        self.self_displacement = float(matrix[0, 0])

    def support(self, index):
        return Chosen(index, index.size)

    def each_block(self, task):
        task(0, slice(0, self.rows.stop - self.rows.start))

    def _displaced(self, index, pressure):
        first, last = (row * self.shape[1] for row in (self.rows.start, self.rows.stop))
        mine = np.zeros(last - first)
        mine[index] = pressure
        whole = np.concatenate(self.sums.group.exchange(self.sums.rank, mine))
        return (self.matrix[first:last] @ whole).reshape(-1, self.shape[1])

    def spread(self, support, pressure, visit):
        displacement = self._displaced(support.index, pressure)
        visit(0, slice(0, len(displacement)), displacement)

    def gather(self, support, pressure):
        return self._displaced(support.index, pressure).ravel()[support.index]

    def __call__(self, pressure):
        return (self.matrix @ pressure.ravel()).reshape(self.shape)

    def to_single_precision(self):
        return self

    def approximate_inverse(self):
        # A little resists even where nothing does, so that there is an inverse.
        resisted = self.matrix + self.self_displacement / len(self.matrix)
        inverse = np.linalg.inv(resisted) * self.self_displacement
        return Dense(inverse, self.shape, self.rows, self.sums)


def run_on_processes(edges, run, matrix_of=None):
    """Return what ``run(family, rows)`` returns on each process, and how many sums it took."""
    group, results, errors = Group(edges), {}, []
    matrix_of = matrix_of or love
    calls = {}

    def process(rank):
        sums = GroupSums(group, rank)
        rows = slice(edges[rank], edges[rank + 1])

        def family(shape, coarsening):
            k = coarsening[0]
            pixel = tuple(n * d for n, d in zip(coarsening, PIXEL, strict=True))
            part = slice(rows.start // k, -(-rows.stop // k))
            return Dense(matrix_of(shape, pixel), shape, part, sums)

        try:
            results[rank] = run(family, rows)
        except BaseException as error:
            errors.append(error)
            group.barrier.abort()
        calls[rank] = sums.calls

    threads = [threading.Thread(target=process, args=(rank,)) for rank in range(group.count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for error in errors:
        raise error
    assert len(set(calls.values())) == 1
    return [results[rank] for rank in range(group.count)], calls[0]


def love(shape, pixel):
    quadrant = kernels.love(shape, pixel, MODULUS)
    row, column = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    return quadrant[np.abs(row[:, None] - row), np.abs(column[:, None] - column)]


def waves(shape, pixel):
    unit = np.zeros(shape)
    unit[0, 0] = 1
    response = convolution.periodic(shape, pixel, MODULUS, workers=1)(unit)
    row, column = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    return response[row[:, None] - row, column[:, None] - column]


def by_fft(shape, coarsening):
    edges = tuple(n * d for n, d in zip(coarsening, PIXEL, strict=True))
    return convolution.free(shape, edges, MODULUS, workers=1)


def join_solutions(solutions, edges):
    pressure = np.zeros(SHAPE)
    for solution, first in zip(solutions, edges[:-1], strict=True):
        pressure[first:].ravel()[solution.index] = solution.pressure
    return pressure


@pytest.fixture
def several_levels(monkeypatch):
    """Coarse grids and collective modes on a map small enough for a matrix."""
    monkeypatch.setattr(bounded, "_COARSEST", 4)
    monkeypatch.setattr(preconditioner, "_BLOCK", 4)
    monkeypatch.setattr(preconditioner, "_SMALL", 8)


def gap(kind):
    y, x = (np.arange(n) - n / 2 for n in SHAPE)
    ball = (y[:, None] ** 2 * 0.49 + x**2) / 60
    rough = np.random.default_rng(4).normal(size=SHAPE) * 0.4
    if kind == "rough":
        return ball + rough
    if kind == "holes":
        found = ball + rough
        found[5:9, 4:20] = np.inf
        return found
    # Nothing touches on the last rows.
    return np.hypot(y[:, None] + 9, x) / 4


CASES = {
    "elastic": ("rough", {"total": 60.0}),
    "approach": ("rough", {"approach": 0.3}),
    "ceiling": ("rough", {"total": 60.0, "limit": 0.4}),
    "ceilings": ("holes", {"total": 40.0, "limit": "map"}),
    "holes": ("holes", {"total": 60.0}),
    "one side": ("one side", {"total": 5.0, "limit": 0.6}),
    "full": ("rough", {"total": 9000.0}),
    "loose": ("rough", {"total": 60.0, "limit": 0.4, "tolerance": 3e-2}),
}


@cache
def solve_on_processes(case, edges):
    """Return the solutions of a case on processes, one for each."""
    kind, options = CASES[case]
    h0, limit = gap(kind), options.get("limit", np.inf)
    if isinstance(limit, str):
        limit = np.random.default_rng(5).uniform(0.2, 0.8, SHAPE)
    wanted = {name: options[name] for name in ("total", "approach") if name in options}
    more = {"tolerance": options.get("tolerance", 1e-9), "max_iterations": 300}
    if edges is None:
        return [bounded.solve(BoundedProblem(h0, limit, **wanted), by_fft, **more)]

    def run(family, rows):
        here = limit[rows] if isinstance(limit, np.ndarray) else limit
        return bounded.solve(BoundedProblem(h0[rows], here, **wanted, whole=SHAPE), family, **more)

    solutions, calls = run_on_processes(edges, run)
    assert calls > 20
    return solutions


def same(solutions, edges, expected):
    pressure = join_solutions([expected], (0, 24))
    found = join_solutions(solutions, edges)
    np.testing.assert_array_equal(found > 0, pressure > 0)
    np.testing.assert_allclose(found, pressure, rtol=0, atol=1e-7 * pressure.max())
    assert solutions[0].approach == pytest.approx(expected.approach, rel=1e-8, abs=1e-8)
    gaps = np.concatenate([solution.gap for solution in solutions])
    np.testing.assert_allclose(gaps, expected.gap, rtol=0, atol=1e-7)


@pytest.mark.parametrize("case", CASES)
def test_an_operator_of_another_make(several_levels, case):
    expected, found = solve_on_processes(case, None)[0], solve_on_processes(case, (0, 24))
    assert expected.status is found[0].status is Status.CONVERGED
    if case != "loose":
        same(found, (0, 24), expected)


@pytest.mark.parametrize("edges", [(0, 12, 24), (0, 4, 16, 24)], ids=str)
@pytest.mark.parametrize("case", CASES)
def test_a_map_on_several_processes(several_levels, case, edges):
    expected, solutions = solve_on_processes(case, (0, 24))[0], solve_on_processes(case, edges)
    same(solutions, edges, expected)
    for solution in solutions:
        # All decide alike, to the last bit, and as one process alone does.
        assert solution.status is Status.CONVERGED
        assert solution.approach == solutions[0].approach
        assert solution.history == solutions[0].history
        steps = [(step.shape, step.convolutions) for step in solution.history]
        assert steps == [(step.shape, step.convolutions) for step in expected.history]


def test_a_wave_that_nothing_resists_on_several_processes() -> None:
    # All of a periodic map moves as one until the first pixel, of one process, meets its ceiling.
    limit = np.full(SHAPE, 1.0)
    limit[20, 3] = 0.3
    problem = {"approach": 0.5, "whole": SHAPE}

    def run(family, rows):
        here = BoundedProblem(np.zeros(SHAPE)[rows], limit[rows], **problem)
        return bounded.solve(here, family, tolerance=1e-9, max_iterations=300)

    def way(family, rows):
        full = np.ones(limit[rows].size)
        sums = family((1, 1), (1, 1)).sums
        return active_set._feasible_length(0 * full, full, limit[rows].ravel(), sums)

    assert run_on_processes((0, 16, 24), way)[0] == [0.3, 0.3]
    alone, _ = run_on_processes((0, 24), run, waves)
    several, _ = run_on_processes((0, 16, 24), run, waves)
    same(several, (0, 16, 24), alone[0])
    assert [len(s.history) for s in several] == [len(alone[0].history)] * 2


@pytest.mark.parametrize("limit", [math.inf, 0.5, 1e-3], ids=str)
@pytest.mark.parametrize("edges", [(0, 24), (0, 0, 24), (0, 7, 24, 24)], ids=str)
def test_projection_on_several_processes(edges, limit):
    values = np.random.default_rng(6).normal(size=24)
    values[3] = 1e-14
    total = min(3.0, 0.5 * 24 * limit)
    expected = project(values, limit, total, LocalSums())
    clean = remove_rounding(expected, limit, LocalSums())

    def run(family, rows):
        sums = family((1, 1), (1, 1)).sums
        found = project(values[rows], limit, total, sums)
        return found, remove_rounding(found, limit, sums)

    parts, _ = run_on_processes(edges, run)
    np.testing.assert_allclose(np.concatenate([part[0] for part in parts]), expected, atol=1e-14)
    np.testing.assert_allclose(np.concatenate([part[1] for part in parts]), clean, atol=1e-14)
    # What counts as dust is measured by the largest pressure of all.
    dusty = np.array([5e-13] + 22 * [0.2] + [1.0])
    parts, _ = run_on_processes(
        edges, lambda family, rows: remove_rounding(dusty[rows], 1.0, family((1, 1), (1, 1)).sums)
    )
    assert np.concatenate(parts)[0] == 0


@pytest.mark.parametrize("edges", [(0, 24), (0, 8, 24)], ids=str)
def test_a_tilted_map_on_several_processes(several_levels, edges):
    h0 = gap("rough")
    arguments = (np.array([0.05, -0.02]), PIXEL)
    more = {"tolerance": 1e-8, "max_iterations": 300}
    expected, slope = rigid_tilt.solve(BoundedProblem(h0, 0.5, 60.0), by_fft, *arguments, **more)

    def run(family, rows):
        return rigid_tilt.solve(
            BoundedProblem(h0[rows], 0.5, 60.0, whole=SHAPE), family, *arguments, **more
        )

    found, _ = run_on_processes(edges, run)
    pressure = np.zeros(SHAPE)
    pressure.ravel()[expected.index] = expected.pressure
    for _, other in found:
        assert other == found[0][1]
        assert other == pytest.approx(slope, rel=1e-5)
    np.testing.assert_allclose(
        join_solutions([solution for solution, _ in found], edges),
        pressure,
        atol=1e-5 * pressure.max(),
    )


def test_sums_of_one_process():
    sums, values = LocalSums(), np.array([3.0, -1.0, 2.0])
    assert (sums.size(values), sums.total(values), sums.count(values > 0)) == (3, 4.0, 2)
    assert (sums.largest(values), sums.smallest(values), sums.dot(values, values)) == (3, -1, 14)
    none = np.empty(0)
    assert (sums.largest(none), sums.smallest(none)) == (-math.inf, math.inf)
    assert (sums.largest(-values, floor=2.0), sums.largest(none, floor=0)) == (2.0, 0)
    assert (sums.size(none), sums.total(none), sums.dot(none, none)) == (0, 0, 0)


# What would miss the pixels of other processes.
REDUCTIONS = {
    "all",
    "any",
    "argmax",
    "argmin",
    "average",
    "bincount",
    "count_nonzero",
    "cumsum",
    "dot",
    "einsum",
    "inner",
    "max",
    "mean",
    "median",
    "min",
    "norm",
    "ptp",
    "sum",
    "tensordot",
    "trace",
    "vdot",
}

# Functions that may, and why: module -> function -> reason.
ALLOWED = {
    "aggregation": dict.fromkeys(
        (
            "__init__",
            "excess",
            "smoothed",
            "factors",
            "_sum_by_group",
            "_pair_nodes",
            "conjugate_gradients",
            "_dot",
        ),
        "the flow through a gap, a whole map of which lies on one process",
    ),
    "anderson": {
        "add": "unknowns of one layer, which lies on one process",
        "_products": "parts of the volume, of which `whole` has gathered those of all processes",
        "_least_squares": "a handful of steps",
    },
    "active_set": {
        "select_entries": "whether to copy, where the values are the same either way",
        "_deep_enough": "bins that `allreduce` has summed over the processes",
        "sum_blocks": "parts that `allreduce` sums over the processes",
        "_kept_by_block": "blocks of the map, which all processes hold",
    },
    "partial_slip": {
        **dict.fromkeys(
            ("newton_step", "descend", "iterates", "certified", "merit", "solve", "start"),
            "methods that take the operator's sums, and two components",
        ),
        **dict.fromkeys(
            ("__init__", "_dual", "added"), "parts that `allreduce` sums over the processes"
        ),
        "mean": "a map of half the points, which lies on one process",
        "sum": "parts that `allreduce` sums over the processes",
        "along": "the two components of each pixel",
        "project_with_sum": "two by two",
        "stiffness": "two components",
    },
    "problem": {
        "coarsen_problem": "which of two ways that agree pixel by pixel",
        "prolong_pressure": "places of this process's pixels",
        "_balance_multipliers": "three sums",
    },
    "preconditioner": {
        "restrict_inverse": "parts that `allreduce` sums over the processes",
        "apply": "parts that `allreduce` sums over the processes",
        "_displaced": "blocks of the map, which all processes hold",
        "_dot": "blocks of the map, which all processes hold",
    },
    "rigid_tilt": {
        "rigid_tilt": "a whole map: one on several processes is left out",
        "_outermost": "what a whole map can balance, asked before the solver runs",
        "_nearest": "a handful of moments",
        "excess": "two components",
    },
}


def reductions(path):
    """Yield (function, what) for everything that may sum over a map."""
    tree = ast.parse(path.read_text(encoding="utf-8"))

    def visit(node, function):
        if isinstance(node, ast.FunctionDef):
            function = node.name
        if isinstance(node, ast.MatMult):
            yield function, "@"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            of_sums = ast.unparse(node.func.value).split(".")[-1] == "sums"
            if node.func.attr in REDUCTIONS and not of_sums:
                yield function, ast.unparse(node.func)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "sum":
            yield function, "sum"
        for child in ast.iter_child_nodes(node):
            yield from visit(child, function)

    yield from visit(tree, "")


@pytest.mark.parametrize("path", sorted(SOLVERS.glob("*.py")), ids=lambda path: path.stem)
def test_sums_over_the_map_are_the_operators(path):
    allowed = ALLOWED.get(path.stem, {})
    found = list(reductions(path))
    missed = [(function, what) for function, what in found if function not in allowed]
    assert not missed, "take these from the operator's sums, or say why not"
    assert allowed.keys() == {function for function, _ in found}, "an exception has become idle"
