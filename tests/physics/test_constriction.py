"""What contact spots conduct, against closed forms and against Greenwood's formula."""

import dataclasses
import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.result import ContactResult
from roughcontact.joint.spread import greenwood
from roughcontact.theory import constriction, hertz

STEEL = rc.Material(210e9, 0.3)
UNIT = rc.Conductor(resistivity=0.5, conductivity=2.0)
Disc = tuple[float, float, float, float]


def touching(discs: list[Disc], n: int = 256, boundary: str = "free") -> ContactResult:
    """Return a contact on ellipses (y, x, semi-axes y, x), all in points."""
    surface = rc.Surface(*rc.reference_map(n, 1))
    result = rc.solve(surface, material=STEEL, load=1e-3, ceiling=None, boundary=boundary)
    y, x = np.mgrid[:n, :n]
    pressure = np.zeros((n, n))
    for at_y, at_x, half_y, half_x in discs:
        pressure[((y - at_y) / half_y) ** 2 + ((x - at_x) / half_x) ** 2 <= 1] = 1e6
    return dataclasses.replace(result, pressure=pressure)


def length(result: ContactResult) -> float:
    """Return the constriction length in points."""
    return float(rc.conductance(result, UNIT, UNIT).steps[0].length / result.surface.pixel[0])


def equal(discs: list[Disc], result: ContactResult) -> list[float]:
    """Return the radii of the circles of the areas that the spots have, in points."""
    areas = result.spots().area / result.pixel_area
    assert areas.size == len(discs)
    return [math.sqrt(area / math.pi) for area in areas]


def test_a_disc_has_four_radii() -> None:
    discs = [(127.5, 127.5, 30.0, 30.0)]
    result = touching(discs)
    (a,) = equal(discs, result)
    # The pixels of a rim of radius 30 are no circle.
    assert length(result) == pytest.approx(constriction.disc(a), rel=0.01)


@pytest.mark.parametrize("ceiling", [None, 0.6e9])
def test_a_ball_conducts_by_its_whole_contact(ceiling: float | None) -> None:
    side = 1.2e-3 if ceiling is None else 0.8e-3
    n, load = 160, 100.0
    x = (np.arange(n) - (n - 1) / 2) * side / n
    ball = rc.Surface(-(x**2 + x[:, None] ** 2) / 0.02, (side / n, side / n))
    result = rc.solve(ball, load=load, material=STEEL, ceiling=ceiling)
    found = rc.conductance(result, UNIT, UNIT).steps[0]
    a = math.sqrt(result.contact_area / math.pi)
    if ceiling is None:
        a = hertz.contact_radius(load, 0.01, result.contact_modulus)
    else:
        assert found.saturated_area > 0.9 * found.contact_area
    assert found.length == pytest.approx(4 * a, rel=0.01)


def test_an_ellipse_has_its_elliptic_integral() -> None:
    discs = [(127.5, 127.5, 12.0, 60.0)]
    result = touching(discs)
    (a,) = equal(discs, result)
    # Of the same area: the axes of the pixels are those wanted but for a factor.
    factor = a / math.sqrt(12 * 60)
    wanted = constriction.ellipse(12 * factor, 60 * factor)
    assert wanted > 1.12 * 4 * a
    assert length(result) == pytest.approx(wanted, rel=0.01)


def test_two_far_discs_add_but_for_what_each_does_to_the_other() -> None:
    discs = [(60.5, 60.5, 10.0, 10.0), (190.5, 190.5, 10.0, 10.0)]
    result = touching(discs)
    a, other = equal(discs, result)
    alone = length(touching(discs[:1])) + length(touching(discs[1:]))
    # 1/L = 1/(8 a) + 1/(4 π s): the potential of a disc at the distance s of the other.
    distance = math.hypot(130, 130)
    assert a == other
    wanted = 1 / (1 / alone + 1 / (4 * math.pi * distance))
    assert length(result) == pytest.approx(wanted, rel=1e-3)
    assert length(result) == pytest.approx(alone, rel=0.05)


def scattered(number: int) -> list[Disc]:
    rng, found = np.random.default_rng(4), []
    while len(found) < number:
        y, x = rng.uniform(20, 236, 2)
        a = rng.uniform(4, 11)
        if all(math.hypot(y - v, x - u) > 1.5 * (a + b) for v, u, b, _ in found):
            found.append((y, x, a, a))
    return found


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_greenwoods_formula_is_near_on_round_spots(boundary: str) -> None:
    result = touching(scattered(25), boundary=boundary)
    assert result.spots().count == 25
    found = greenwood(result) / result.surface.pixel[0]
    # Spots that stand in the middle of others carry less than in proportion to their radii.
    assert found == pytest.approx(length(result), rel=0.05)


def test_greenwoods_sum_is_that_of_all_pairs() -> None:
    discs = scattered(12)
    result = touching(discs)
    label = result.spots().label
    places = np.array([np.argwhere(label == 1 + number).mean(0) for number in range(12)])
    radii = np.sqrt(result.spots().area / result.pixel_area / math.pi)
    apart = np.hypot(*(places[:, None] - places).T)
    np.fill_diagonal(apart, np.inf)
    pairs = float(radii @ (1 / apart) @ radii)
    wanted = 1 / (1 / (4 * radii.sum()) + pairs / (2 * math.pi * radii.sum() ** 2))
    # Middles are rounded to pixels.
    assert greenwood(result) / result.surface.pixel[0] == pytest.approx(wanted, rel=3e-3)


def test_all_of_a_periodic_map_adds_no_resistance() -> None:
    result = touching([], boundary="periodic")
    full = dataclasses.replace(result, pressure=np.ones((256, 256)))
    found = rc.conductance(full, UNIT, UNIT, film=2e-12)
    assert found.steps[0].length == math.inf
    assert found.electrical_resistance[0] == pytest.approx(2e-12 / full.contact_area)
    assert found.thermal_resistance[0] == 0


@pytest.mark.parametrize("ceiling", [None, 2e9])
def test_the_correlation_of_rough_joints_is_within_its_scatter(ceiling: float | None) -> None:
    heights = rc.self_affine(
        (256, 256), (1e-6, 1e-6), rms_height=0.5e-6, rolloff_wavelength=32e-6,
        cutoff_wavelength=8e-6, rng=np.random.default_rng(2),
    )  # fmt: skip
    surface = rc.Surface(heights, (1e-6, 1e-6))
    contacts = (
        rc.solve(surface, load=w, material=STEEL, ceiling=ceiling, boundary="periodic")
        for w in (0.5, 1.5, 5.0)
    )
    found = rc.conductance(contacts, UNIT, UNIT)
    ratio = found.column("correlation_length") / found.column("length")
    assert ((ratio > 0.7) & (ratio < 1.4)).all()
    # Nearly in proportion to the load, 0.95 and 0.94.
    slope = np.diff(np.log(found.column("length"))) / np.diff(np.log(found.column("load")))
    assert ((slope > 0.85) & (slope < 1.1)).all()
