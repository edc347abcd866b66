"""Laws that hold for every solved contact, closed form or not."""

import math

import numpy as np
import pytest

import roughcontact as rc
from maps import anisotropic_surface
from roughcontact.theory import hertz

STEEL = rc.Material(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
BOUNDARIES = ["free", "periodic"]
CEILINGS = [None, 2e9]


def solve_surface(surface, load, **options):
    return rc.solve(surface, load=load, **{"material": STEEL, "tolerance": 1e-9, **options})


def displacement(result):
    """The displacement, from the gap that the result returns."""
    return result.gap - result.initial_gap + result.approach


# The certificate leaves 1e-9 of ‖p‖; solutions of two problems differ by about ten times that.
TOLERANCES = {"rtol": 0, "atol": 1e-7}


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", CEILINGS)
def test_only_the_contact_modulus_of_the_pair_counts(ceiling, boundary):
    surface = anisotropic_surface()
    copper = rc.Material(120e9, 0.34)
    pair = solve_surface(surface, 0.5, counter_material=copper, ceiling=ceiling, boundary=boundary)
    modulus = 1 / (0.91 / 210e9 + (1 - 0.34**2) / 120e9)
    alone = solve_surface(
        surface, 0.5, material=rc.Material(modulus, 0.0), ceiling=ceiling, boundary=boundary
    )
    swapped = solve_surface(
        surface, 0.5, material=copper, counter_material=STEEL, ceiling=ceiling, boundary=boundary
    )
    for other in (alone, swapped):
        np.testing.assert_allclose(
            other.pressure / pair.max_pressure, pair.pressure / pair.max_pressure, **TOLERANCES
        )


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", CEILINGS)
def test_more_load_presses_every_pixel_at_least_as_much(ceiling, boundary):
    # Comparison principle of the obstacle problem: no pixel opens or unloads under more load.
    surface = anisotropic_surface()
    before = None
    for load in (0.01, 0.1, 0.5, 1.0, 2.0):
        result = solve_surface(surface, load, ceiling=ceiling, boundary=boundary)
        if before is not None:
            scale = result.max_pressure
            assert (result.pressure >= before.pressure - 1e-7 * scale).all()
            assert not (before.contact & ~result.contact & (before.pressure > 1e-6 * scale)).any()
            assert result.approach > before.approach
            # The load is the slope of the work: convex in the approach.
            assert result.stiffness() >= before.stiffness() * (1 - 1e-6) or ceiling is not None
        before = result


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_a_lower_ceiling_spreads_the_contact(boundary):
    surface = anisotropic_surface()
    areas, approaches = [], []
    for ceiling in (None, 20e9, 10e9, 5e9, 3e9, 2e9, 1e9):
        result = solve_surface(surface, 0.5, ceiling=ceiling, boundary=boundary)
        areas.append(result.contact_area)
        approaches.append(result.approach)
    assert (np.diff(areas) >= 0).all()
    assert (np.diff(approaches) >= -1e-9 * approaches[0]).all()
    assert areas[-1] > 1.5 * areas[0]


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", CEILINGS)
def test_the_load_is_the_derivative_of_the_work(ceiling, boundary):
    # E(ω) = min ½⟨p, K p⟩ + ⟨h₀ - ω, p⟩ has the slope -⟨p, 1⟩: the envelope theorem.
    surface = anisotropic_surface()
    middle = solve_surface(surface, 0.5, ceiling=ceiling, boundary=boundary)
    step = 1e-4 * middle.approach
    energies = []
    for approach in (middle.approach - step, middle.approach + step):
        result = rc.solve(
            surface,
            approach=approach,
            material=STEEL,
            ceiling=ceiling,
            boundary=boundary,
            tolerance=1e-9,
        )
        inner = 0.5 * displacement(result) + result.initial_gap - approach
        energies.append(float((result.pressure * inner).sum()) * result.pixel_area)
    assert (energies[0] - energies[1]) / (2 * step) == pytest.approx(0.5, rel=1e-5)


def far_field(ratio):
    """Ball on pixels with dy = ratio dx: displacement far away over Boussinesq's."""
    load, radius, extent = 0.5, 1e-4, 130e-6
    pixel = (0.5e-6 * math.sqrt(ratio), 0.5e-6 / math.sqrt(ratio))
    y, x = ((np.arange(round(extent / d)) - round(extent / d) // 2) * d for d in pixel)
    r = np.hypot(y[:, None], x)
    result = solve_surface(rc.Surface(-(r**2) / 2 / radius, pixel), load)
    a = hertz.contact_radius(load, radius, MODULUS)
    far = r > 5 * a
    # u = W/(π E* r) (1 + ⟨ρ²⟩/4r²) with the second moment ⟨ρ²⟩ = 2a²/5 of Hertz's pressure.
    expected = load / (math.pi * MODULUS * r[far]) * (1 + 0.1 * (a / r[far]) ** 2)
    return displacement(result)[far] / expected


@pytest.mark.parametrize("ratio", [1.0, 4.0, 1 / 4, 20.0, 1 / 20])
def test_far_field_on_anisotropic_pixels(ratio):
    # Whichever edge is the longer, in all directions. At 1:20 the contact is 5 pixels wide.
    np.testing.assert_allclose(far_field(ratio), 1, atol=1e-3 if 0.1 < ratio < 10 else 3e-3)
