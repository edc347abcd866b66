"""Stress below profiles: plane strain against McEwen's line contact, and waves."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.halfspace import stress

RATIO = 0.3
A, P0 = 1e-4, 1e9


def mcewen(x, z):
    """Return σ_xx, σ_zz and τ_xz below a line contact (Johnson 1985, eqs. 4.49)."""
    first = A**2 - x**2 + z**2
    root = np.sqrt(first**2 + 4 * x**2 * z**2)
    m, n = np.sqrt((root + first) / 2), np.sign(x) * np.sqrt(np.maximum(root - first, 0) / 2)
    share = (z**2 + n**2) / (m**2 + n**2)
    shear = P0 / A * n * (m**2 - z**2) / (m**2 + n**2)
    return -P0 / A * (m * (1 + share) - 2 * z), -P0 / A * m * (1 - share), shear


@pytest.mark.parametrize("precision", ["double", "single"])
def test_below_a_line_contact_the_stress_is_mcewens(precision):
    points = 1200
    spacing = 4 * A / points
    x = (np.arange(points) - (points - 1) / 2) * spacing
    pressure = P0 * np.sqrt(np.maximum(1 - (x / A) ** 2, 0))
    depths = np.array([0.3, 0.78, 1.5, 3.0]) * A
    options = {"boundary": "periodic-y", "precision": precision}
    for piece in stress.slices(pressure[None], (1.0, spacing), depths, RATIO, **options):
        along, down, shear = mcewen(x, piece.depth)
        xx, yy, zz, yz, xz, xy = piece.stress[:, 0]
        # The pressure is constant on each point, which is felt to (spacing/a)^(3/2) of it.
        for found, expected in ((xx, along), (zz, down), (yy, RATIO * (along + down))):
            np.testing.assert_allclose(found, expected, atol=5e-5 * P0)
        np.testing.assert_allclose(np.abs(xz), np.abs(shear), atol=5e-5 * P0)
        np.testing.assert_allclose([yz, xy], 0, atol=1e-5 * P0)


@pytest.mark.long
def test_first_yield_of_cylinder_matches_theory():
    steel = rc.Material(210e9, RATIO, yield_strength=1e9)
    x = (np.arange(801) - 400) * A / 200
    surface = rc.Surface(-(x**2) / 0.02, A / 200)
    found = rc.first_yield_load(surface, material=steel)
    # 0.5575 p₀ at 0.704 a (ν = 0.3).
    assert found.solution.max_pressure == pytest.approx(1.7937e9, rel=2e-3)
    half_width = found.solution.contact_area / 2
    assert found.max_von_mises_at[0] == pytest.approx(0.704 * half_width, rel=0.03)
    assert found.max_von_mises == pytest.approx(1e9, rel=1e-3)
    load = math.pi * found.solution.max_pressure**2 * 0.01 / found.solution.contact_modulus
    assert found.solution.load == pytest.approx(load, rel=5e-3)


def test_stress_below_wave_in_full_contact_matches_closed_form():
    points, length, mean = 256, 1e-4, 2e9
    steel = rc.Material(210e9, RATIO, yield_strength=5e9)
    x = np.arange(points) * length / points
    wave = 1e9
    modulus = 210e9 / (1 - RATIO**2)
    amplitude = wave * length / (math.pi * modulus)
    surface = rc.Surface(amplitude * np.cos(2 * np.pi * x / length), length / points)
    result = rc.solve(
        surface,
        material=steel,
        ceiling=None,
        load=mean * length,
        boundary="periodic",
        tolerance=1e-10,
    )
    q = 2 * np.pi / length
    found = rc.subsurface_stress(result, depths=[0.5 / q, 1 / q], precision="double")
    for number, z in enumerate((0.5 / q, 1 / q)):
        shape = np.cos(q * x) * math.exp(-q * z) * wave
        np.testing.assert_allclose(
            found.section_x[2, number], -mean - (1 + q * z) * shape, atol=1e-5 * wave
        )
        sideways = -mean * RATIO / (1 - RATIO)
        np.testing.assert_allclose(
            found.section_x[0, number], sideways - (1 - q * z) * shape, atol=1e-5 * wave
        )
