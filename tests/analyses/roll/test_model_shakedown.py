"""First yield and shakedown limits of rolling and sliding contacts, each between two pressures.

The judge of a line contact is Melan's theorem on the closed-form stresses of a half-plane
(`melan`), averaged over the layers as the program averages them; without friction it gives the
4.00 k of Johnson, Contact Mechanics (1985), section 9.2. That of a point contact is the orthogonal
shear on its plane of symmetry, which no residual stress can remove (Ponter, Hearle and Johnson
1985).
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import melan
import roughcontact as rc
from rollers import PIXEL, POISSON, SHEAR, STRENGTH, YOUNG, Line
from roughcontact.elastoplastic.problem import ContactSolver
from roughcontact.halfspace.plastic_halfspace import PlasticHalfSpace
from roughcontact.material.hardening import Hardening, Kinematic, Perfect
from roughcontact.surface import nominal_bodies

# Of pressures below and above what theory gives, 3 % apart.
BELOW, ABOVE = 0.985, 1.015
MODULUS = YOUNG / (1 - POISSON**2)


# The judge --------------------------------------------------------------------------------------


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_stresses_of_the_judge_are_those_of_a_half_plane(friction: float) -> None:
    step = 1e-4

    def stress_at(x: float, z: float) -> NDArray[np.float64]:
        return np.array(melan.stress(np.array(x), np.array(z), friction))

    for x, z in itertools.product((-1.4, -0.7, 0.3), (0.2, 0.9)):
        along = (stress_at(x + step, z) - stress_at(x - step, z)) / (2 * step)
        down = (stress_at(x, z + step) - stress_at(x, z - step)) / (2 * step)
        assert along[0] + down[2] == pytest.approx(0, abs=1e-6)
        assert along[2] + down[1] == pytest.approx(0, abs=1e-6)
    surface = np.array(melan.stress(np.array([-0.6, 0.6]), np.full(2, 1e-9), friction))
    np.testing.assert_allclose(surface[1], -0.8, atol=1e-6)
    np.testing.assert_allclose(surface[2], -0.8 * friction, atol=1e-6)
    np.testing.assert_allclose(
        surface[0], [-0.8 + 1.2 * friction, -0.8 - 1.2 * friction], atol=1e-6
    )


def test_melan_limits_match_known_values() -> None:
    assert melan.first_yield(0.0, POISSON) == pytest.approx(3.1, rel=0.01)
    assert melan.limit_at(0.5, 0.0, POISSON) == pytest.approx(4.0, rel=1e-6)
    # At the surface k/μ as long as the stress across the plane takes no part.
    assert melan.limit_at(1e-6, 0.4, 0.5) == pytest.approx(1 / 0.4, rel=1e-4)
    assert melan.limit_at(1e-6, 0.4, 0.3) < 0.94 / 0.4


# First yield ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("share", "yields"), [(BELOW, False), (ABOVE, True)])
def test_first_yield_of_a_line_contact(share: float, yields: bool) -> None:
    # A long period: the mean pressure of a row of rollers adds a separate stress.
    line = Line(melan.first_yield(0.0, POISSON) * share, half_width=10, points=1024)
    line.layers = np.full(20, 1.2 * line.width / 20)
    assert bool(line.solve_path([line.point_at(0)]).plastic_volume) is yields


@pytest.mark.parametrize(("share", "yields"), [(BELOW, False), (ABOVE, True)])
def test_first_yield_of_a_point_contact(share: float, yields: bool) -> None:
    depth = np.linspace(0.2, 1, 4001)
    # Von Mises stress on the axis (Johnson 1985, equation 3.45).
    axis = (1 + POISSON) * (depth * np.arctan(1 / depth) - 1) + 1.5 / (1 + depth**2)
    limit = math.sqrt(3) / axis.max()
    assert limit == pytest.approx(2.8, rel=0.01)
    ball, load = sphere(share * limit, 10, 28)
    result = rc.solve_elastoplastic(
        ball,
        material=rc.Material(YOUNG, POISSON, STRENGTH),
        loads=[load],
        increments=1,
        layers=np.full(20, 1.2e-5 / 20),
        precision="double",
    )
    assert bool(result.plastic_volume) is yields


# Shakedown --------------------------------------------------------------------------------------


def added(
    flat: rc.Surface, load: float, count: int, friction: float = 0.0, **options: Any
) -> tuple[list[float], rc.ElastoplasticResult]:
    """Return the largest strain that each of some passes adds, after one with a rising load.

    Where a body is pressed on at its full load, what is left of that takes many passes to go.
    """
    places = range(0, flat.shape[1], 2)
    solved = rc.solve_elastoplastic(
        flat,
        boundary="periodic",
        path=[
            rc.PathPoint(load * (n + 1) / len(places), (0.0, x * PIXEL[1]), friction)
            for n, x in enumerate(places)
        ],
        **options,
    )
    options.pop("layers")
    path = [rc.PathPoint(load, (0.0, x * PIXEL[1]), friction) for x in places]
    strains = []
    for _ in range(count):
        before = solved.bodies[0].accumulated
        solved = rc.solve_elastoplastic(
            flat, boundary="periodic", path=path, start=solved, **options
        )
        after = solved.bodies[0].accumulated
        strains.append(float((after[: len(before)] - before).max()))
    return strains, solved


def line_passes(
    peak: float, friction: float, layers: NDArray[np.float64], law: Hardening | None, count: int
) -> list[float]:
    line = Line(peak, half_width=7, points=64, law=law)
    return added(
        line.flat,
        line.load,
        count,
        friction,
        counter_surface=line.roller,
        material=line.steel,
        layers=layers * line.width,
    )[0]


EVEN = np.full(14, 1.6 / 14)
# Thin at the surface, where much friction sets the limit.
FINE = np.concatenate([np.full(8, 1 / 40), np.full(12, 1.6 / 12)])
KINEMATIC = Kinematic(Perfect(STRENGTH), 20e9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "layers", "law"),
    [(0.0, EVEN, None), (0.2, EVEN, None), (0.4, FINE, None), (0.0, EVEN, KINEMATIC)],
    ids=["rolling", "friction 0.2", "friction 0.4", "kinematic"],
)
def test_limit_of_a_line_contact(
    friction: float, layers: NDArray[np.float64], law: Hardening | None
) -> None:
    limit = melan.line_limit(friction, POISSON, layers)
    assert limit == pytest.approx({0.0: 4.0, 0.2: 3.2, 0.4: 1 / 0.4}[friction], rel=0.005)
    low, high = (line_passes(share * limit, friction, layers, law, 8) for share in (BELOW, ABOVE))
    # Below it the increment of a pass continues to fall, above it is constant.
    assert low[-1] < 0.4 * low[1]
    assert high[-1] > 0.3 * high[1]
    assert high[-1] > 0.85 * high[-2]
    assert high[-1] > 4 * low[-1]


def sphere(peak: float, radius: int, points: int) -> tuple[rc.Surface, float]:
    """Return a ball and its load: Hertz pressure over k, radius of the contact in pixels."""
    pressure, width = peak * SHEAR, radius * PIXEL[0]
    ball = nominal_bodies.sphere(
        radius=width * MODULUS * 2 / (math.pi * pressure), shape=(points, points), pixel=PIXEL
    )
    return ball, 2 / 3 * math.pi * width**2 * pressure


POINT_LAYERS = np.concatenate([np.full(2, 0.08), np.full(8, 0.07), np.full(6, 0.12)]) * 8e-6


def point_passes(peak: float, count: int) -> tuple[list[float], rc.ElastoplasticResult]:
    ball, load = sphere(peak, 8, 40)
    return added(
        rc.Surface(np.zeros((40, 40)), PIXEL),
        load,
        count,
        counter_surface=ball,
        material=rc.Material(YOUNG, POISSON, STRENGTH),
        layers=POINT_LAYERS,
        tolerance=3e-4,
    )


def point_limit() -> float:
    """Return k over the largest orthogonal shear, on the grid of `point_passes`, times p₀/k."""
    ball, load = sphere(4.0, 8, 40)
    elastic = rc.Material(YOUNG, POISSON)
    pressure = rc.solve(ball, material=elastic, load=load, boundary="periodic").pressure
    space = PlasticHalfSpace(
        pressure.shape, PIXEL, POINT_LAYERS, shear_modulus=1.0, poisson=POISSON, boundary="periodic"
    )
    space.displacement(lambda layer, out: None)
    largest = np.zeros(POINT_LAYERS.size)

    def keep_largest(layer: int, stress: NDArray[np.float64]) -> None:
        largest[layer] = abs(stress[3]).max()

    space.stress(pressure, keep_largest)
    return 4.0 * SHEAR / float(largest.max())


@pytest.mark.slow
def test_limit_of_a_point_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the rut it is that of the orthogonal shear; with it the pressure falls below that."""
    limit = point_limit()
    # Johnson's 4.7 k; 8 pixels in a radius average the shear.
    assert limit == pytest.approx(4.7, rel=0.03)
    rutted, result = point_passes(ABOVE * limit, 5)
    assert rutted[-1] < 0.1 * rutted[1]
    assert result.contact.max_pressure < 0.85 * ABOVE * limit * SHEAR
    press = ContactSolver.solve
    monkeypatch.setattr(
        ContactSolver, "solve", lambda self, gone, load: press(self, np.zeros_like(gone), load)
    )
    low, _ = point_passes(BELOW * limit, 8)
    high, _ = point_passes(ABOVE * limit, 8)
    assert low[-1] < 0.25 * low[1]
    assert high[-1] > 0.3 * high[1]
    assert high[-1] > 3 * low[-1]
