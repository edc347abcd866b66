import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from numpy.typing import NDArray

import judge
import roughcontact as rc
from roughcontact.cautions import CautionTag
from roughcontact.contact import solve
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.pair import Pair
from roughcontact.contact.validation import check_problem
from roughcontact.halfspace.boundary import Boundary
from roughcontact.solvers import bounded, rigid_tilt as tilt
from roughcontact.solvers.problem import BoundedProblem, shift_to_balance
from roughcontact.solvers.rigid_tilt import rigid_tilt

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
Array = NDArray[np.float64]


def rough(n: int = 48, seed: int = 3) -> rc.Surface:
    return rc.Surface(*rc.reference_map(n, seed))


# --- what can be balanced --------------------------------------------------------------------


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(2, 30),
    ceiling=st.sampled_from(["none", "one", "each", "some"]),
    size=st.floats(0.05, 0.8),
)
def test_excess_is_the_distance_to_what_can_be_balanced(
    seed: int, n: int, ceiling: str, size: float
) -> None:
    from scipy.optimize import linprog

    rng = np.random.default_rng(seed)
    y, x = rng.uniform(-0.5, 0.5, (2, n))
    share: Any = {
        "none": math.inf,
        "one": 1.7 / n,
        "each": rng.uniform(1.05, 3, n) / n,
        "some": np.where(rng.random(n) < 0.5, math.inf, 2 / n),
    }[ceiling]
    if ceiling == "some":
        share[0] = math.inf
    angle = rng.uniform(0, 2 * math.pi)
    target = size * np.array([math.cos(angle), math.sin(angle)])
    outside = tilt.excess(target, y, x, share)
    # The same question as a linear program: are there shares of the load with this moment?
    bounds = [(0, min(float(s), 1.0)) for s in np.broadcast_to(share, n)]
    rows = np.stack([y, x, np.ones(n)])
    program = linprog(np.zeros(n), A_eq=rows, b_eq=[*target, 1.0], bounds=bounds)
    if outside == 0:
        # The program's own tolerance is 1e-7 to 1e-9.
        assert program.status == 0 or _distance(target, rows, bounds) < 1e-6
    else:
        assert program.status == 2 or outside < 1e-6
        assert outside == pytest.approx(_distance(target, rows, bounds), rel=1e-6, abs=1e-8)


def _distance(target: Array, rows: Array, bounds: list[tuple[float, float]]) -> float:
    """Return the distance of a point from a convex set by its support in many directions."""

    def lead(angle: float) -> float:
        direction = np.array([math.cos(angle), math.sin(angle)])
        left, best = 1.0, 0.0
        for value, (_, bound) in sorted(zip(direction @ rows[:2], bounds, strict=True))[::-1]:
            best += value * min(left, bound)
            left -= min(left, bound)
        return float(direction @ target) - best

    middle, width = 0.0, math.pi
    for _ in range(6):
        angles = np.linspace(middle - width, middle + width, 401)
        middle = float(angles[np.argmax([lead(angle) for angle in angles])])
        width /= 100
    return max(0.0, lead(middle))


def test_excess_of_points_on_one_line_and_of_one_point() -> None:
    y, x = np.zeros(5), np.linspace(-0.4, 0.4, 5)
    assert tilt.excess(np.array([0.0, 0.3]), y, x, math.inf) == 0
    assert tilt.excess(np.array([0.1, 0.3]), y, x, math.inf) == pytest.approx(0.1)
    assert tilt.excess(np.array([0.0, -0.5]), y, x, math.inf) == pytest.approx(0.1)
    # Each can carry a quarter: the load cannot act further out than the mean of the last four.
    assert tilt.excess(np.array([0.0, 0.1]), y, x, 0.25) == 0
    assert tilt.excess(np.array([0.0, 0.3]), y, x, 0.25) == pytest.approx(0.2)
    one = np.array([0.2])
    assert tilt.excess(np.array([0.2, 0.2]), one, one, math.inf) == 0
    assert tilt.excess(np.array([0.2, 0.0]), one, one, math.inf) == pytest.approx(0.2)


# --- the nearest pressure with a load and moments --------------------------------------------


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    # Of three entries one choice alone has the sums; where it is nearly singular it has no digits.
    n=st.integers(8, 200),
    limit=st.sampled_from([math.inf, 2.0]),
    depth=st.sampled_from([1e-3, 1.0, 1e3, 1e8]),
)
def test_the_nearest_pressure_keeps_load_and_moments(
    seed: int, n: int, limit: float, depth: float
) -> None:
    rng = np.random.default_rng(seed)
    rows = np.vstack([np.ones(n), rng.uniform(-0.5, 0.5, (2, n))])
    rest = rows @ np.minimum(0.5 * n * rng.dirichlet(np.full(n, 0.1)), limit)
    values = depth * rng.normal(size=n)
    nearest, shift = shift_to_balance(values, limit, rows, rest)
    assert nearest is not None
    np.testing.assert_allclose(rows @ nearest, rest, rtol=0, atol=1e-11 * rest[0])
    # The conditions of the nearest point of a convex set: what lacks is a sum of the rows, but
    # for what a bound holds back.
    at = values + shift @ rows
    np.testing.assert_allclose(nearest, np.clip(at, 0, limit), rtol=0, atol=1e-6 + 1e-7 * depth)


def test_unreachable_sums_return_none() -> None:
    rows = np.vstack([np.ones(20), np.linspace(0.1, 0.5, 20), np.zeros(20)])
    rest = np.array([1.0, 0.0, 0.0])
    assert shift_to_balance(np.zeros(20), math.inf, rows, rest)[0] is None
    assert shift_to_balance(np.zeros(0), math.inf, rows[:, :0], rest)[0] is None


def test_sums_nearly_those_of_the_limits_leave_three_entries_below() -> None:
    row, column = np.divmod(np.arange(300), 20)
    rows = np.stack([np.ones(300), row / 19 - 0.4, column / 19 - 0.5])
    limit = np.ones(300)
    lack = np.zeros(300)
    lack[[40, 155, 277]] = 4e-7, 1e-6, 6e-7
    # Far beyond the limits, as far as the displacement of a whole map is beyond that of a pixel.
    values = 1 + 40 * np.abs(rows[1]) * np.cos(7.0 * row + column)
    rest = rows @ (limit - lack)
    rest[1:] = 0
    rows[1:] -= (rows[1:] @ (limit - lack) / rest[0])[:, None]
    result, shift = shift_to_balance(values, 1.0, rows, rest)
    assert result is not None
    np.testing.assert_allclose(rows @ result, rest, rtol=0, atol=1e-12 * rest[0])
    np.testing.assert_allclose(result, np.clip(values + shift @ rows, 0, 1), rtol=0, atol=1e-12)
    assert np.count_nonzero(result < 1 - 1e-12) <= 3


# --- the contact -----------------------------------------------------------------------------


@pytest.mark.parametrize("load", [1e-7, 0.05, 15.0])
@pytest.mark.parametrize("point", [(0.0, 0.0), (0.11, -0.17)])
@pytest.mark.parametrize("ceiling", [None, "auto"])
def test_a_rough_map_balances_its_moments(
    load: float, point: tuple[float, float], ceiling: str | None, independent: Any
) -> None:
    surface = rough()
    side = surface.size[0]
    moments = (load * point[0] * side, load * point[1] * side)
    result = rc.solve(surface, load=load, moments=moments, material=STEEL, ceiling=ceiling)
    independent.assert_solved(result, load)
    y, x = (np.arange(48) - 23.5) * surface.pixel[0], (np.arange(48) - 23.5) * surface.pixel[1]
    force = result.pressure * result.pixel_area
    assert abs(float(force.sum(axis=1) @ y) - moments[0]) <= 1e-8 * load * side
    assert abs(float(force.sum(axis=0) @ x) - moments[1]) <= 1e-8 * load * side
    assert result.moment_error <= 1e-8
    assert result.center_of_pressure == pytest.approx(
        (point[0] * side, point[1] * side), abs=1e-8 * side
    )
    assert result.moments == moments
    assert math.hypot(*result.tilt) > 0
    # Moments are sums that the solver keeps, as it keeps the load.
    fixed = rc.solve(surface, load=load, material=STEEL, ceiling=ceiling, calibrated=False)
    assert result.convolutions <= 2 * fixed.convolutions


def test_the_moments_of_fixed_bodies_keep_them_where_they_are() -> None:
    fixed = rc.solve(rough(), load=1.0, material=STEEL, tolerance=1e-9)
    assert fixed.tilt == (0, 0)
    assert fixed.moments is None
    assert fixed.moment_error == 0
    moments = fixed.center_of_pressure
    free = rc.solve(rough(), load=1.0, moments=moments, material=STEEL, tolerance=1e-9)
    size = fixed.approach / fixed.surface.size[0]
    assert np.abs(free.tilt).max() < 1e-6 * size
    np.testing.assert_allclose(free.pressure, fixed.pressure, rtol=0, atol=1e-5 * 3e9)


def test_tilt_of_map_is_removed() -> None:
    # A body mounted askew comes to rest as if it had been mounted straight.
    surface = rough()
    y = np.arange(48)[:, None] * surface.pixel[0]
    askew = rc.Surface(surface.heights - 0.003 * y, surface.pixel)
    options: dict[str, Any] = {"load": 1.0, "moments": (1e-6, 2e-6), "material": STEEL}
    one = rc.solve(surface, **options)
    two = rc.solve(askew, **options)
    assert two.tilt[0] - one.tilt[0] == pytest.approx(-0.003, rel=1e-6)
    assert two.tilt[1] == pytest.approx(one.tilt[1], abs=1e-8)
    np.testing.assert_allclose(two.pressure, one.pressure, rtol=0, atol=1e-4 * 3e9)


def test_tilted_result_has_summary_and_serves_as_guess() -> None:
    options: dict[str, Any] = {"load": 1.0, "moments": (5e-6, -1e-5), "material": STEEL}
    result = rc.solve(rough(), **options)
    said = result.summary()
    assert said["tilt"] == list(result.tilt)
    assert said["moments"] == [5e-6, -1e-5]
    assert said["moment_error"] == result.moment_error
    # Another start, the same end; from the solution itself hardly any work.
    again = rc.solve(rough(), initial_guess=result, **options)
    assert again.convolutions <= 4
    assert again.tilt == pytest.approx(result.tilt, rel=1e-5)
    near = rc.solve(rough(), initial_guess=result.pressure, **options)
    assert near.tilt == pytest.approx(result.tilt, rel=1e-4)
    elastic = result.elastic()
    assert elastic.moments == result.moments
    assert elastic.moment_error <= 1e-8
    assert elastic.tilt != result.tilt


def test_a_ceiling_map_and_holes() -> None:
    surface = rough()
    heights = surface.heights.copy()
    heights[10:20, 30:] = np.nan
    ceiling = np.full((48, 48), 2e9)
    ceiling[:, 24:] = 4e9
    result = rc.solve(
        rc.Surface(heights, surface.pixel).masked(),
        load=5.0,
        moments=(1e-5, 5e-5),
        material=STEEL,
        ceiling=ceiling,
    )
    assert result.converged
    assert result.moment_error <= 1e-8
    assert not result.pressure[10:20, 30:].any()
    assert (result.pressure <= ceiling).all()


# --- what cannot be --------------------------------------------------------------------------


def refuse(*_: object, **__: object) -> None:
    raise AssertionError("solved something")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (
            {"moments": (0.0, 0.6e-4)},
            rc.CapacityError,
            r"at \(0, 6e-05\) m from the center.*1\.\d+e-05 m beyond what points that can touch",
        ),
        (
            {"load": 10.0, "moments": (0.0, 3.6e-4), "ceiling": 3e9},
            rc.CapacityError,
            "beyond what pressures up to the ceiling can balance",
        ),
        ({"moments": (0.0, 1e-9), "boundary": "periodic"}, rc.InputError, 'boundary="free"'),
        ({"moments": (0.0, 0.0), "load": None, "approach": 1e-7}, rc.InputError, "need a load"),
        ({"moments": (0.0, 0.0), "precision": "single"}, rc.InputError, 'precision="double"'),
        ({"moments": 1.0}, rc.InputError, "moments must be a pair"),
        ({"moments": (0.0, math.nan)}, rc.InputError, "moments must be a pair"),
        ({"moments": ("a", 0.0)}, rc.InputError, "moments needs a moment with its unit"),
        ({"moments": ({}, 0.0)}, rc.InputError, "moments must be a (list|pair)"),
    ],
)
def test_unbalanced_moments_raise_error_before_solve(
    arguments: dict[str, Any], error: type[Exception], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounded, "solve", refuse)
    options = {"load": 1.0, "material": STEEL, "ceiling": None, **arguments}
    with pytest.raises(error, match=message):
        rc.solve(rough(), **options)
    boundary = Boundary(options.pop("boundary", "free"))
    with pytest.raises(error, match=message):
        check_problem(
            Pair(rough(), options.pop("material"), boundary=boundary), LoadCase(**options)
        )


def test_a_load_beyond_the_points_that_touch() -> None:
    # The right half of the map is a hole: nothing there can push back.
    heights = rough().heights.copy()
    heights[:, 24:] = np.nan
    surface = rc.Surface(heights, rough().pixel).masked()
    with pytest.raises(rc.CapacityError, match=r"1\.6\d*e-06 m beyond"):
        rc.solve(surface, load=0.1, moments=(0.0, 0.1 * 0.6e-6), material=STEEL, ceiling=None)
    result = rc.solve(surface, load=0.1, moments=(0.0, -0.1 * 1.2e-6), material=STEEL, ceiling=None)
    assert result.moment_error <= 1e-8


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    shape=st.tuples(st.integers(2, 9), st.integers(2, 9)),
    depth=st.sampled_from([1.0, 1e-20, 1e20]),
    filling=st.sampled_from([0.0, 0.3, 0.9]),
)
def test_rigid_bodies_rest_on_points_around_the_load(
    seed: int, shape: tuple[int, int], depth: float, filling: float
) -> None:
    rng = np.random.default_rng(seed)
    gap = depth * rng.random(shape)
    gap[rng.random(shape) < 0.2] = np.inf
    touchable = np.isfinite(gap)
    assume(touchable.any())
    part = rng.random(np.count_nonzero(touchable)) ** 4
    # Capacity of each: everything, or little more than its load.
    part = np.maximum(part / part.sum(), 1e-6)
    part /= part.sum()
    limit = np.full(shape, np.inf)
    if filling:
        limit[touchable] = part / filling
    levers = tilt.moment_arms(shape, (1e-6, 3e-6))
    y, x = (np.broadcast_to(lever, shape)[touchable] for lever in levers)
    target = np.array([part @ y, part @ x])
    problem = BoundedProblem(gap, limit, 1.0)
    found = rigid_tilt(problem, levers, target)
    assert found is not None
    # Those above the plane at rest carry nothing, those below it all that they can.
    opened = gap[touchable] + found[0] * y + found[1] * x
    share = limit[touchable]
    order = np.sort(np.unique(opened))
    held = False
    for at in order:
        on, full = np.abs(opened - at) <= 1e-9 * depth, opened < at - 1e-9 * depth
        rest = 1 - share[full].sum()
        if not 0 < rest <= share[on].sum() * (1 + 1e-9):
            continue
        carried = np.array([share[full] @ y[full], share[full] @ x[full]]) if full.any() else 0.0
        missing = (target - carried) / rest
        held |= tilt.excess(missing, y[on], x[on], share[on] / rest) < 1e-6
    assert held


def test_no_rigid_rest_is_sought_without_points() -> None:
    levers = tilt.moment_arms((4, 4), (1.0, 1.0))
    assert (
        rigid_tilt(BoundedProblem(np.full((4, 4), np.inf), np.inf, 1.0), levers, np.zeros(2))
        is None
    )
    # Where no pressure has the moment there is no rest either.
    flat = BoundedProblem(np.zeros((4, 4)), np.inf, 1.0)
    assert rigid_tilt(flat, levers, np.array([0.9, 0.0])) is None


def solve_tripod(height: float) -> rc.ContactResult:
    heights = np.zeros((12, 16))
    heights[[1, 10, 5], [2, 3, 13]] = np.array([1.0, 1.1, 0.9]) * height
    surface = rc.Surface(heights, (1e-6, 1e-6))
    return rc.solve(surface, load=1e-6, moments=(0.0, 1e-12), material=STEEL, ceiling=None)


def test_a_tripod_far_steeper_than_its_displacement() -> None:
    result = solve_tripod(1e-3)
    assert result.moment_error <= 1e-8
    assert np.count_nonzero(result.contact) == 3
    judge.assert_solved(result, 1e-6)


def test_a_tilt_without_digits_for_the_certificate_does_not_converge() -> None:
    # The last digit of a tilt of 1e9 is more than the displacement of the tips.
    with pytest.raises(rc.ConvergenceError, match="rounding") as caught:
        solve_tripod(1e3)
    assert judge.judge(caught.value.result).certificate > 1e-6


def test_unbalanced_moments_raise_convergence_error(monkeypatch: pytest.MonkeyPatch) -> None:
    options: dict[str, Any] = {"load": 1.0, "moments": (2e-5, 2e-5), "material": STEEL}
    with pytest.raises(rc.ConvergenceError, match=r"moment error .* max_iterations") as caught:
        rc.solve(rough(), max_iterations=2, **options)
    assert caught.value.result.convolutions <= 4
    moved = bounded.solve
    monkeypatch.setattr(
        bounded,
        "solve",
        lambda problem, *others, **named: moved(replace(problem, moments=None), *others, **named),
    )
    with pytest.raises(rc.ConvergenceError, match="moments not balanced"):
        rc.solve(rough(), **options)
    result = rc.solve(rough(), on_failure="return", **options)
    assert result.status == solve.MOMENT_ERROR_TEXT
    assert not result.converged
    assert result.certificate <= 1e-6 < result.moment_error
    assert CautionTag.NOT_CONVERGED in {caution.kind for caution in result.cautions}
