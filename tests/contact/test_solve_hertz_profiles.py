"""Radial profiles of a ball under a ceiling, over a_H and p_H, against an axisymmetric solution.

The reference has no maps, pixels or transforms: rings of uniform pressure, each with the
closed displacement of its two discs, in a dense bounded problem.
"""

import math
from functools import cache

import numpy as np
import pytest
from scipy.special import ellipe, ellipkm1

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.theory import hertz

STEEL = rc.Material(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
RADIUS = 10e-3
LOAD = 5.0
A = hertz.contact_radius(LOAD, RADIUS, MODULUS)
P0 = hertz.max_pressure(LOAD, RADIUS, MODULUS)
RATIOS = [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3]


def disc(r, a):
    """Displacement times E* at r under unit pressure on a disc: Johnson (3.25a), (3.25b)."""
    inside, outside = np.minimum(r / a, 1), np.minimum(a / r, 1)
    within = 4 * a / math.pi * ellipe(inside**2)
    m = 1 - outside**2
    with np.errstate(invalid="ignore"):
        beyond = 4 * r / math.pi * (ellipe(outside**2) - np.where(m > 0, m * ellipkm1(m), 0))
    return np.where(r < a, within, beyond)


def first(count, holds):
    """Smallest index below count at which a monotone statement holds, else count."""
    low, high = 0, count
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


@cache
def axisymmetric(ratio, rings=600):
    """Middles of rings/a_H, pressure/p_H, approach/δ_H, contact and saturated radius/a_H.

    Full rings inside, free ones, empty ones outside: both borders by bisection.
    """
    # In units of a_H, p_H and a_H p_H/E*: gap r²/2R with a_H/R = π p_H/(2 E*).
    edges = np.linspace(0, 1.02 * max(math.sqrt(2 / (3 * ratio)), 1.15), rings + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    kernel = np.diff(np.array([disc(middle, edge) for edge in edges[1:]]).T, axis=1, prepend=0)
    gap0, area, load = math.pi / 4 * middle**2, math.pi * np.diff(edges**2), 2 * math.pi / 3

    def solve_rings(inner, outer):
        pressure = np.where(np.arange(rings) < inner, ratio, 0.0)
        free, n = slice(inner, outer), outer - inner
        # On the free rings K p - δ = -gap0, and the load.
        system = np.zeros((n + 1, n + 1))
        system[:n, :n], system[:n, n], system[n, :n] = kernel[free, free], -1, area[free]
        right = np.append(-gap0[free] - kernel[free] @ pressure, load - area @ pressure)
        *pressure[free], approach = np.linalg.solve(system, right)
        return pressure, approach

    def rim(inner, outer):
        return solve_rings(inner, outer)[0][outer - 1]

    def outer_of(inner):
        # Too wide a contact pulls at its rim.
        width = first(rings - inner - 1, lambda n: rim(inner, inner + n + 2) < 0)
        return inner + width + 1

    inner = first(rings - 2, lambda n: solve_rings(n, outer_of(n))[0][n] <= ratio)
    outer = outer_of(inner)
    pressure, approach = solve_rings(inner, outer)
    gap = kernel @ pressure + gap0 - approach
    # All conditions, wherever the borders came from.
    assert pressure.min() >= 0
    assert pressure.max() <= ratio
    assert gap[:inner].max(initial=0) <= 0 <= gap[outer:].min(initial=1)
    return middle, pressure, approach / (math.pi / 2), edges[outer], edges[inner]


def ball(n, side):
    pixel = (side / n, side / n)
    return rc.Surface(shapes.paraboloid((n, n), pixel, RADIUS), pixel)


def distance(surface):
    (ny, nx), (dy, dx) = surface.shape, surface.pixel
    y, x = (np.arange(ny) - (ny - 1) / 2) * dy, (np.arange(nx) - (nx - 1) / 2) * dx
    return np.hypot(y[:, None], x)


@pytest.mark.parametrize("ratio", RATIOS)
def test_profile_under_a_ceiling(independent, ratio):
    n = 256
    surface = ball(n, 4 * A)
    result = rc.solve(surface, material=STEEL, load=LOAD, ceiling=ratio * P0)
    independent.assert_solved(result, LOAD)
    rings, pressure, approach, contact, saturated = axisymmetric(ratio)
    r = distance(surface) / A
    expected = np.interp(r, rings, pressure, right=0.0)
    error = np.linalg.norm(result.pressure / P0 - expected) / np.linalg.norm(expected)
    # A pixel is a_H/64; under low ceilings the pressure falls from there to zero within one: up to
    # half of it on the 500 of 22 000 pixels at the rim would be 8 %.
    assert error < 0.025
    # Off the rims, point by point.
    smooth = (np.abs(r - contact) > 0.05) & (np.abs(r - saturated) > 0.05)
    np.testing.assert_allclose(result.pressure[smooth] / P0, expected[smooth], atol=2e-3)
    # The first touch is between four pixels.
    touch = 0.5 * (surface.pixel[0] ** 2 + surface.pixel[1] ** 2) / 4 / RADIUS
    delta = hertz.approach(LOAD, RADIUS, MODULUS)
    assert (result.approach + touch) / delta == pytest.approx(approach, rel=1e-3)
    counted = [np.count_nonzero(mask) for mask in (result.contact, result.saturated)]
    radii = [math.sqrt(count * result.pixel_area / math.pi) / A for count in counted]
    # A ring of pixels counted whole or not at all, averaged around the circle.
    assert radii == pytest.approx([contact, saturated], abs=0.008)
    # Round: no pixel of the rim is more than a pixel off the circle.
    assert np.abs(r[result.contact].max() - radii[0]) < 1.5 * surface.pixel[0] / A
