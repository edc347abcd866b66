"""A flat surface under a uniform pressure that comes and goes, against its closed form.

No strain in the plane: with the yield strength σ_Y + H e and the back stress C e the plastic
strain across the surface follows from one linear equation for each way.
"""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.halfspace import tensors
from roughcontact.material.hardening import Kinematic, Linear, Perfect

YOUNG, POISSON, STRENGTH = 200e9, 0.3, 1e9
# Decrease of the difference of the principal stresses per uniaxial plastic strain.
RELIEF = YOUNG / (2 * (1 - POISSON))
SHARE = (1 - 2 * POISSON) / (1 - POISSON)


def expected(pressures: list[float], rise: float, back: float) -> list[float]:
    """Return the plastic compression after each pressure."""
    plastic = accumulated = 0.0
    found = []
    for pressure in pressures:
        relative = SHARE * pressure - (RELIEF + back) * plastic
        excess = abs(relative) - (STRENGTH + rise * accumulated)
        step = max(excess, 0.0) / (RELIEF + back + rise)
        plastic += float(np.copysign(step, relative))
        accumulated += step
        found.append(plastic)
    return found


@pytest.mark.long
@pytest.mark.parametrize(("rise", "back"), [(0.0, 40e9), (10e9, 30e9), (5e9, 0.0)])
def test_cyclic_pressure_matches_closed_form(rise: float, back: float) -> None:
    pressures = [2.5e9, 4.5e9, 2e9, 0.0, 4.5e9, 0.0]
    law = Linear(STRENGTH, rise) if rise else Perfect(STRENGTH)
    steel = rc.Material(YOUNG, POISSON, hardening=Kinematic(law, back) if back else law)
    surface = rc.Surface(np.zeros((8, 8)), (1e-6, 1e-6))
    area = surface.heights.size * 1e-12
    result, found, stresses = None, [], []
    for pressure in pressures:
        result = rc.solve_elastoplastic(
            surface,
            material=steel,
            loads=[pressure * area],
            boundary="periodic",
            layers=None if result else np.full(4, 2e-6),
            start=result,
            precision="double",
            tolerance=1e-9,
        )
        body = result.bodies[0]
        found.append(float(-tensors.tensor(body.plastic_strain[0])[4, 4, 2, 2]))
        stresses.append(float(body.von_mises[0, 4, 4]))
    plastic = expected(pressures, rise, back)
    assert plastic[3] < plastic[1], "the way back is to yield as well"
    np.testing.assert_allclose(found, plastic, rtol=1e-6)
    remains = [abs(SHARE * p - RELIEF * e) for p, e in zip(pressures, plastic, strict=True)]
    np.testing.assert_allclose(stresses, remains, rtol=1e-6, atol=1e3)
    assert result is not None
    assert result.yield_excess < 1e-6
