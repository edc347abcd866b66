"""Adhesion of a sphere against Maugis' solution and the theories at its two ends."""

import math

import pytest
from scipy.optimize import brentq

from roughcontact.theory import indenters

RADIUS, MODULUS = 1e-6, 1e9


def work_of(tabor: float) -> float:
    return MODULUS * math.sqrt((tabor * indenters.ADHESION_RANGE) ** 3 / RADIUS)


def maugis(load: float, strength: float) -> float:
    """Return the area over Hertz' by Maugis (1992), eqs. 6.15 to 6.17; loads over π w R."""

    def load_at(contact: float) -> float:
        def condition(m: float) -> float:
            root, angle = math.sqrt(m * m - 1), math.acos(1 / m)
            near = strength * contact**2 / 2 * (root + (m * m - 2) * angle)
            return near + 4 * strength**2 * contact / 3 * (root * angle - m + 1) - 1

        reach = 2.0
        while condition(reach) < 0:
            reach *= 2
        m = brentq(condition, 1 + 1e-15, reach, xtol=1e-15)
        pull = math.sqrt(m * m - 1) + m * m * math.acos(1 / m)
        return contact**3 - strength * contact**2 * pull

    hertz = math.cbrt(load)
    contact = brentq(lambda a: load_at(a) - load, hertz + 1e-12, 10 + 2 * hertz)
    return (contact / hertz) ** 2


@pytest.mark.parametrize("tabor", [0.02, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0])
def test_the_area_is_that_of_maugis(tabor: float) -> None:
    work = work_of(tabor)
    assert indenters.tabor(RADIUS, MODULUS, work) == pytest.approx(tabor)
    for load in (0.1, 1.0, 10.0, 100.0, 1000.0):
        found = indenters.enlargement(load * math.pi * work * RADIUS, RADIUS, MODULUS, work)
        assert found == pytest.approx(maugis(load, 1.157 * tabor), rel=0.04)


@pytest.mark.parametrize("load", [0.1, 10.0, 293.0, 1120.0])
def test_large_and_soft_spheres_are_those_of_johnson_kendall_and_roberts(load: float) -> None:
    work = work_of(1e4)
    x = 1 / load
    exact = (1 + 3 * x + math.sqrt(6 * x + 9 * x * x)) ** (2 / 3)
    found = indenters.enlargement(load * math.pi * work * RADIUS, RADIUS, MODULUS, work)
    assert found == pytest.approx(exact, rel=0.003)


def test_pull_off_force_is_between_dmt_and_jkr() -> None:
    for tabor, factor in ((1e-4, 2.0), (1e4, 1.5)):
        work = work_of(tabor)
        force = indenters.pull_off(RADIUS, MODULUS, work)
        assert force == pytest.approx(factor * math.pi * work * RADIUS, rel=1e-3)
