"""The traction under Coulomb's friction: conditions, certificate and force."""

from __future__ import annotations

import numpy as np
import pytest

from roughcontact.halfspace import tangential
from roughcontact.halfspace.boundary import Boundary
from roughcontact.solvers import partial_slip
from roughcontact.solvers.partial_slip import PartialSlipProblem, project_to_discs, project_with_sum
from roughcontact.solvers.progress import Status

SHAPE = 8, 9


def problem(total: float | None = 0.5, shift: float | None = None) -> PartialSlipProblem:
    """Return bounds on some pixels of a small map with a force, or a shift, oblique to the axes."""
    rng = np.random.default_rng(5)
    index = np.flatnonzero(rng.random(SHAPE[0] * SHAPE[1]) < 0.5)
    bound = rng.random(index.size) * 1e8
    direction = np.array([0.6, 0.8])
    return PartialSlipProblem(
        index,
        bound,
        np.zeros((2, index.size)),
        total=None if total is None else total * bound.sum() * direction,
        shift=None if shift is None else shift * direction,
    )


def operator(boundary: str = "free", poisson: float = 0.3) -> tangential.TangentialConvolution:
    return tangential.operator(Boundary(boundary), SHAPE, (1e-6, 1e-6), 200e9, poisson)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("part", [0.01, 0.5, 0.95, 0.9999])
def test_stick_and_slip_obey_coulomb(boundary: str, part: float) -> None:
    stated = problem(part)
    solution = partial_slip.solve(operator(boundary), stated, 1e-9)
    assert solution.status is Status.CONVERGED
    assert solution.certificate <= 1e-9
    assert solution.force_error <= 1e-10
    np.testing.assert_allclose(solution.traction.sum(axis=1), stated.total, rtol=1e-9)
    size, slip = np.hypot(*solution.traction), np.hypot(*solution.slip)
    assert (size <= stated.bound * (1 + 1e-12)).all()
    slips = size > stated.bound * (1 - 1e-9)
    assert 0 < np.count_nonzero(slips)
    assert slip[~slips].max(initial=0) < 1e-7 * np.hypot(*solution.shift)
    along = (solution.traction * solution.slip).sum(axis=0)[slips]
    np.testing.assert_allclose(along, (size * slip)[slips], rtol=1e-6, atol=1e-6 * along.max())


def test_no_admissible_traction_has_less_energy() -> None:
    act, stated = operator(), problem(None, 5e-11)
    support, rng = act.support(stated.index), np.random.default_rng(8)

    def energy(traction: np.ndarray) -> float:
        displacement = act.gather(support, traction)
        return float((traction * (0.5 * displacement - stated.shift[:, None])).sum())

    best = partial_slip.solve(act, stated, 1e-10).traction
    lowest = energy(best)
    assert lowest < 0
    for size in (1e-3, 0.1, 1.0):
        change = size * stated.bound.max() * rng.normal(size=(20, *best.shape))
        assert min(energy(project_to_discs(best + step, stated.bound)) for step in change) > lowest


def test_a_shift_and_its_force_give_one_traction() -> None:
    pushed = partial_slip.solve(operator(), problem(0.6), 1e-10)
    index, bound = problem().index, problem().bound
    moved = PartialSlipProblem(index, bound, np.zeros((2, index.size)), shift=pushed.shift)
    again = partial_slip.solve(operator(), moved, 1e-10)
    assert again.force_error == 0
    np.testing.assert_allclose(again.traction, pushed.traction, rtol=0, atol=1e-6 * bound.max())


def test_the_certificate_notices_a_wrong_traction() -> None:
    stated = problem()
    solver = partial_slip._Solver(operator(), stated)
    state = solver.make_state(
        solver.total[:, None] / solver.bound.sum() * solver.bound, np.zeros(2)
    )
    assert solver.certify(state, 0).certificate > 1e-3


@pytest.mark.parametrize("part", [0.0, 0.3, 0.999999])
def test_projection_gives_the_sum(part: float) -> None:
    rng = np.random.default_rng(7)
    bound = rng.random(200)
    values = rng.normal(size=(2, 200)) * 3
    total = part * bound.sum() * np.array([0.8, -0.6])
    result, shift = project_with_sum(values, bound, total)
    np.testing.assert_allclose(result.sum(axis=1), total, atol=1e-9 * bound.sum())
    np.testing.assert_allclose(result, project_to_discs(values + shift[:, None], bound), atol=1e-12)


def test_full_stick_is_stiffer_than_partial_slip() -> None:
    act, stated = operator(), problem(0.5)
    solution = partial_slip.solve(act, stated, 1e-8)
    direction = np.array([0.6, 0.8])
    initial = partial_slip.stiffness(act, stated.index, direction)
    state = solution.traction, solution.slip, stated.bound
    tangent = partial_slip.stiffness(act, stated.index, direction, state)
    more = partial_slip.solve(act, problem(0.5001), 1e-10)
    fewer = partial_slip.solve(act, problem(0.4999), 1e-10)
    moved = (more.shift - fewer.shift) @ direction
    assert tangent == pytest.approx(2e-4 * stated.bound.sum() / moved, rel=1e-2)
    assert initial > tangent
