"""First yield of a sliding sphere is at its trailing rim: against Hamilton's closed form."""

import math

import numpy as np
import pytest

import roughcontact as rc
from hamilton import rim_stress, sliding_sphere
from roughcontact.cautions import CautionTag
from roughcontact.halfspace import stress_summary
from roughcontact.halfspace.tensors import tresca, von_mises
from roughcontact.theory import hertz

NU, YOUNG, RADIUS, PIXEL = 0.3, 210e9, 1e-2, 1e-6
MODULUS = YOUNG / (1 - NU**2)


def largest(poisson, friction):
    along, across = rim_stress(poisson, friction)
    return math.sqrt(along**2 - along * across + across**2)


def greatest(poisson, friction):
    """Largest von Mises stress on the plane of symmetry but for the cusp at the rim, per p0."""
    x, z = np.meshgrid(np.arange(-1.305, 1.31, 0.01), np.append(1e-9, np.linspace(0.01, 1, 50)))
    return von_mises(sliding_sphere(x, 0.0, z, poisson, friction)).max()


def solve_sphere(radius, offset=(0.0, 0.0), pixel=(1.0, 1.0), boundary="free", points=None):
    """Return a Hertz contact of a radius in units of `PIXEL`, and its largest pressure."""
    edges = [PIXEL * edge for edge in pixel]
    y, x = (
        (np.arange(n) - (n - 1) / 2 + shift) * edge
        for edge, shift in zip(edges, offset, strict=True)
        for n in [points or int(2.4 * radius * PIXEL / edge)]
    )
    surface = rc.Surface(-(x**2 + y[:, None] ** 2) / (2 * RADIUS), tuple(edges))
    load = 4 / 3 * MODULUS * (radius * PIXEL) ** 3 / RADIUS
    steel = rc.Material(YOUNG, NU)
    result = rc.solve(surface, material=steel, load=load, ceiling=None, boundary=boundary)
    return result, hertz.max_pressure(load, RADIUS, MODULUS)


def summarize_surface(result, friction, angle=0.0, poisson=NU):
    return stress_summary.summarize(
        result.pressure,
        result.surface.pixel,
        poisson,
        depths=[0.0],
        boundary=result.boundary,
        friction=friction,
        direction=math.radians(angle),
    )


@pytest.mark.parametrize(
    ("radius", "offset", "pixel"),
    [
        (20.0, (0.0, 0.0), (1.0, 1.0)),
        (20.3, (0.3, 0.2), (1.0, 1.0)),
        (20.5, (0.5, 0.5), (1.0, 1.0)),
        (20.8, (0.1, 0.4), (1.0, 0.7)),
    ],
)
def test_the_rim_is_right_to_a_per_cent_at_20_pixels(radius, offset, pixel):
    result, p0 = solve_sphere(radius, offset, pixel)
    for friction in (0.35, 0.5):
        for angle in (0.0, 30.0, 135.0):
            found = summarize_surface(result, friction, angle)
            # Pixel centres alone are 8 % and 4 % low.
            assert found.max_von_mises == pytest.approx(largest(NU, friction) * p0, rel=0.01)
            assert found.peak.max() == pytest.approx(found.max_von_mises, rel=1e-6)
            (y, x), shape = found.pixel_of_max, result.surface.shape
            towards = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            behind = (x + 0.5 - 0.5 * shape[1] + offset[1]) * pixel[1] * towards[0]
            behind += (y + 0.5 - 0.5 * shape[0] + offset[0]) * pixel[0] * towards[1]
            assert behind == pytest.approx(-radius, abs=1.5)


@pytest.mark.parametrize("poisson", [0.0, 0.45])
def test_the_rim_of_bodies_that_are_more_or_less_compressible(poisson):
    result, p0 = solve_sphere(20.3, (0.3, 0.2))
    found = summarize_surface(result, 0.5, poisson=poisson)
    # At 0.45 it is not the rim: the largest stress at the surface is in the contact.
    expected = max(largest(poisson, 0.5), greatest(poisson, 0.5))
    assert found.max_von_mises == pytest.approx(expected * p0, rel=0.01)
    if poisson == 0:
        along, across = rim_stress(poisson, 0.5)
        expected = float(tresca([along, across, 0, 0, 0, 0]))
        assert found.max_tresca == pytest.approx(expected * p0, rel=0.01)


@pytest.mark.parametrize("friction", [0.35, 0.5])
@pytest.mark.parametrize(("points", "tolerance"), [(128, 0.01), (40, 0.02)])
def test_the_rim_on_a_periodic_map(points, tolerance, friction):
    # Images in a distance of eight contact radii raise p0 by half a per cent. At two and a half
    # the pressure is still an ellipsoid, on a half of the map: its mean holds the body sideways.
    result, _ = solve_sphere(16.0, (0.3, 0.2), boundary="periodic", points=points)
    expected = largest(NU, friction) * result.max_pressure
    for angle in (0.0, 20.0, 90.0):
        found = summarize_surface(result, friction, angle)
        assert found.max_von_mises == pytest.approx(expected, rel=tolerance)


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.35, 0.5])
def test_first_yield_of_a_sliding_sphere(friction):
    result, p0 = solve_sphere(20.0, (0.3, 0.2))
    soft = rc.Material(YOUNG, NU, yield_strength=largest(NU, friction) * p0)
    found = rc.first_yield_load(result.surface, material=soft, friction=friction)
    # The load is that of the stress cubed; 27 % and 14 % too high at pixel centers.
    assert found.solution.load == pytest.approx(result.load, rel=0.03)
    assert found.max_von_mises_at[0] == 0
    (caution,) = (caution for caution in found.cautions if caution.kind == CautionTag.STRESS_PIXEL)
    assert caution.numbers["depth"] == 0


def test_depths_without_surface_give_caution():
    result, _ = solve_sphere(10.0)
    found = rc.subsurface_stress(result, PIXEL * np.array([3.0, 10.0, 30.0]), friction=0.5)
    (found_caution,) = (
        caution for caution in found.cautions if caution.kind == CautionTag.STRESS_DEPTH
    )
    assert found_caution.numbers["depth"] == pytest.approx(3 * PIXEL)
    whole = {caution.kind for caution in rc.subsurface_stress(result).cautions}
    assert not {CautionTag.STRESS_DEPTH, CautionTag.STRESS_PIXEL} & whole


def test_values_beyond_free_edges_are_zero_and_periodic_values_wrap() -> None:
    from types import SimpleNamespace

    from roughcontact.halfspace import stress_summary

    values = np.arange(1.0, 13.0).reshape(3, 4)
    rows, columns = np.array([-1, 0, 2, 3, 0, 0]), np.array([0, 0, 3, 0, -1, 4])
    free = SimpleNamespace(pressure=values, periodic=False)
    wrapped = SimpleNamespace(pressure=values, periodic=True)
    assert stress_summary.Sliding.values_at(free, values, rows, columns).tolist() == [
        0,
        1,
        12,
        0,
        0,
        0,
    ]
    assert stress_summary.Sliding.values_at(wrapped, values, rows, columns).tolist() == [
        9,
        1,
        12,
        1,
        4,
        1,
    ]
