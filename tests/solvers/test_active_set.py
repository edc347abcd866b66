"""One step on the free pixels, from where no step has led before."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.active_set import Evaluator, Iterate, step_along_arc
from roughcontact.solvers.problem import BoundedProblem

SHAPE, TOLERANCE = (12, 16), 1e-8


def random_start(height: float, limit: float, total: float) -> tuple[Iterate, Evaluator]:
    """Return a start at random on every pixel of a rough periodic map."""
    rng = np.random.default_rng(3)
    family = Boundary.PERIODIC.operators(SHAPE, (1.0, 1.3), 1.0, workspace=Workspace(1))
    operator = family(SHAPE, (1, 1))
    problem = BoundedProblem(height * rng.random(SHAPE), limit, total)
    viewer = Evaluator(problem, operator, family, (1, 1), TOLERANCE, 500)
    pressure = rng.uniform(0.5, 1.5, math.prod(SHAPE))
    pressure *= total / pressure.sum()
    now = viewer.evaluate(np.arange(pressure.size), pressure)
    return now, viewer


def test_without_a_bound_in_the_way_one_step_solves() -> None:
    now, viewer = random_start(1e-3, math.inf, 100.0)
    after = step_along_arc(now, viewer)
    assert now.certificate > 0.01
    # Seen in single precision.
    assert after.certificate < 1e-6
    assert after.index.size == math.prod(SHAPE)


@pytest.mark.parametrize("limit", [math.inf, 0.8])
@pytest.mark.parametrize("height", [0.3, 3.0, 30.0])
def test_steps_keep_bounds_and_reduce_certificate(height: float, limit: float) -> None:
    now, viewer = random_start(height, limit, 50.0)
    first = now.certificate
    for _ in range(6):
        now = step_along_arc(now, viewer)
        assert (now.pressure >= 0).all()
        assert (now.pressure <= limit).all()
        assert math.fsum(now.pressure) == pytest.approx(50.0, rel=1e-12)
    assert now.certificate < 1e-3 * first


def test_convolution_limit_is_not_exceeded() -> None:
    now, viewer = random_start(3.0, math.inf, 50.0)
    spent = viewer.convolutions
    for most in (spent, spent - 1):
        viewer.max_iterations = most
        assert step_along_arc(now, viewer) is now
        assert viewer.convolutions == spent
