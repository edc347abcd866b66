"""Plastic strain of the bodies against J2 plasticity."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.elastoplastic.plastic_flow import yield_strain


@pytest.mark.parametrize("principal", [(1.0, 0.0, 0.0), (3**-0.5, -(3**-0.5), 0.0)])
def test_yield_strain_is_equivalent_strain_at_first_yield(principal) -> None:
    """Tension and pure shear at a von Mises stress of σ_Y."""
    steel = rc.Material("210 GPa", 0.3, "1 GPa")
    stress = 1e9 * np.diag(principal)
    strain = (1.3 * stress - 0.3 * np.trace(stress) * np.eye(3)) / 210e9
    deviator = strain - np.trace(strain) / 3 * np.eye(3)
    found = np.sqrt(2 / 3 * np.vdot(deviator, deviator))
    assert yield_strain(steel) == pytest.approx(found, rel=1e-12)


def test_yield_strain_needs_no_more_than_initial_strength() -> None:
    law = rc.hardening.Linear("1 GPa", "20 GPa")
    steel = rc.Material("210 GPa", 0.3, hardening=law)
    assert yield_strain(steel) == yield_strain(rc.Material("210 GPa", 0.3, "1 GPa"))
