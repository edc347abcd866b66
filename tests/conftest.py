"""What the tests share."""

import numpy as np
import pytest

import judge

# Scripts for other environments.
collect_ignore_glob = ["data/*"]


@pytest.fixture(scope="session")
def independent():
    """The independent judges, for tests that import nothing from there."""
    return judge


@pytest.fixture(scope="session")
def pressed():
    """A hardening ball under load, out of the middle of a map of unequal sides and pixels."""
    import roughcontact as rc
    from roughcontact.material.hardening import Swift

    steel = rc.Material(210e9, 0.3, hardening=Swift(1240e6, 30, 0.085), name="M50")
    y, x = np.mgrid[:28, :32] - np.array([13, 17])[:, None, None]
    heights = -((y * 0.6e-6) ** 2 + (x * 0.5e-6) ** 2) / (2 * 105e-6)
    surface = rc.Surface(heights, (0.6e-6, 0.5e-6), rc.Provenance("ball.nc"))
    return rc.solve_elastoplastic(surface, material=steel, loads=[0.1, 0.2, 0.35])


@pytest.fixture(scope="session")
def unmoved(pressed):
    """The same ball where not even the first load was reached."""
    import roughcontact as rc

    soft = rc.Material(210e9, 0.3, 1e6)
    return rc.solve_elastoplastic(
        pressed.contact.surface, material=soft, loads=[5e-4], max_iterations=1, on_failure="return"
    )


@pytest.fixture(scope="session")
def released(pressed):
    """The same ball when the load is gone."""
    import roughcontact as rc

    return rc.solve_elastoplastic(
        pressed.contact.surface, material=pressed.contact.material, loads=[0.0], start=pressed
    )
