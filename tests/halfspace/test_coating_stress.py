"""Stress in coated bodies against an integral of axisymmetric waves that is computed here."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray
from scipy.special import jv

import roughcontact as rc
from roughcontact.halfspace import coating_stress
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace

Array = NDArray[np.float64]
Part = tuple[float, float, float]  # E, ν and thickness, infinite for the base

PIXEL = 0.04
"""Pixel over the contact radius."""


# --- Burmister's layered half-space, by one linear system for each wave ---


def states(wave: float, part: Part, depth: float) -> Array:
    """Return σ_xx, σ_zz, σ_xz, u_x, u_z by the terms of Airy's function, shape (5, terms).

    With t = q z and T = q h the terms of φ/q² are e^(-t) and t e^(-t), and in a layer also e^(t-T)
    and (t - T) e^(t-T); σ_xx = φ″, σ_zz = -q² φ, σ_xz = q φ′ times cosine or sine (plane strain).
    """
    young, poisson, thickness = part
    t, end = wave * depth, wave * thickness
    orders = np.arange(4)
    fall, sign = math.exp(-t), (-1.0) ** orders
    derivatives = [sign * fall, sign * (t - orders) * fall]
    if math.isfinite(end):
        rise = math.exp(t - end)
        derivatives += [np.full(4, rise), (t - end + orders) * rise]
    f, f1, f2, f3 = np.array(derivatives).T
    shear = young / (2 * (1 + poisson))
    along = ((1 - poisson) * f2 + poisson * f) / (2 * shear)
    down = ((1 - poisson) * f3 + poisson * f1) / (2 * shear) - f1 / shear
    return np.array([f2, -f, f1, along, down])


def stress_of_wave(wave: float, parts: list[Part], depth: float) -> Array:
    """Return σ along the wave, across it and into the body, and σ_xz, under unit pressure."""
    columns = np.cumsum([0, *(4 if math.isfinite(part[2]) else 2 for part in parts)])
    matrix = np.zeros((columns[-1], columns[-1]))
    matrix[:2, : columns[1]] = states(wave, parts[0], 0.0)[1:3]
    for number, (upper, lower) in enumerate(itertools.pairwise(parts)):
        rows = slice(2 + 4 * number, 6 + 4 * number)
        matrix[rows, columns[number] : columns[number + 1]] = states(wave, upper, upper[2])[1:]
        matrix[rows, columns[number + 1] : columns[number + 2]] = -states(wave, lower, 0.0)[1:]
    right = np.zeros(columns[-1])
    right[0] = -1
    terms = np.linalg.solve(matrix, right)
    for number, part in enumerate(parts):
        if depth <= part[2]:
            own = terms[columns[number] : columns[number + 1]]
            along, normal, shear = (states(wave, part, depth) @ own)[:3]
            return np.array([along, part[1] * (along + normal), normal, shear])
        depth -= part[2]
    raise AssertionError


def stress_below_hertz(parts: list[Part], depth: float, radii: Array) -> Array:
    """Return σ_rr, σ_θθ, σ_zz and σ_rz under the pressure √(1 - r²), shape (4, n)."""
    ends = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 14), np.arange(4.0, 30 / depth, 3.0)])
    nodes, weights = leggauss(12)
    half = np.diff(ends)[:, None] / 2
    waves = (ends[:-1, None] + half * (1 + nodes)).ravel()
    # Hankel transform of the pressure: (sin q - q cos q)/q³.
    spectrum = np.sqrt(np.pi / 2) * jv(1.5, waves) / waves**1.5
    along, across, normal, shear = np.array(
        [stress_of_wave(wave, parts, depth) for wave in waves.tolist()]
    ).T * (spectrum * waves * (half * weights).ravel())
    zero, one, two = (jv(order, np.outer(radii, waves)) for order in range(3))
    mean, difference = zero @ (along + across) / 2, two @ (along - across) / 2
    return np.array([mean - difference, mean + difference, zero @ normal, one @ shear])


# --- The stress on a map ---


def stress_of_map(
    pressure: Array, body: rc.Material, depth: float, pixel: tuple[float, float] = (PIXEL, PIXEL)
) -> Array:
    """Return the stress at a depth below an isolated map, shape (6, ny, nx)."""
    field = coating_stress.field_of(
        pressure, pixel, body, Boundary.FREE, "double", Workspace(workers=1)
    )
    result = np.empty((6, *field.shape))

    def store_rows(rows: slice, block: Array) -> None:
        result[:, rows] = block * field.unit

    field.stream(depth, store_rows)
    return result


def hertz_map(size: float) -> Array:
    """Return the pressure of a contact of radius 1 on a map of a size, averaged over pixels."""
    points = 2 * round(size / PIXEL / 2) + 1
    fine = 8
    y = (np.arange(points * fine) + 0.5) * PIXEL / fine - points * PIXEL / 2
    values = np.sqrt(np.maximum(1 - y[:, None] ** 2 - y**2, 0))
    return values.reshape(points, fine, points, fine).mean(axis=(1, 3))


BODIES = {
    # E and ν of the base, then E, ν and thickness of the layers.
    "stiff": (1.0, 0.3, [(4.0, 0.3, 0.5)]),
    "very stiff": (1.0, 0.4, [(50.0, 0.2, 0.3)]),
    "soft": (10.0, 0.3, [(1.0, 0.45, 0.4)]),
    "two layers": (1.0, 0.3, [(5.0, 0.25, 0.2), (0.5, 0.4, 0.6)]),
    "equal": (1.0, 0.3, [(1.0, 0.3, 0.5)]),
}


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("depth", [0.125, 0.7])
def test_stress_on_small_map_matches_hankel_integral(name: str, depth: float) -> None:
    young, poisson, layers = BODIES[name]
    coating = [rc.Layer(e * 1e9, nu, h) for e, nu, h in layers]
    body = rc.Material(young * 1e9, poisson, coating=coating)
    found = stress_of_map(hertz_map(2.4), body, depth)
    middle = found.shape[1] // 2
    columns = np.array([0, 5, 12, 28])
    expected = stress_below_hertz([*layers, (young, poisson, math.inf)], depth, columns * PIXEL)
    row = found[:, middle, middle + columns]
    # To 0.2 % of the largest pressure or stress.
    limit = 2e-3 * max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(row[[0, 1, 2, 4]], expected, atol=limit)
    assert np.abs(row[[3, 5]]).max() < 1e-9


@pytest.mark.parametrize("name", ["stiff", "very stiff", "thick", "rigid base"])
@pytest.mark.parametrize("shape", [(40, 36), (6, 100)])
def test_stress_does_not_depend_on_size_of_map(name: str, shape: tuple[int, int]) -> None:
    if name == "rigid base":
        body = rc.Material(math.inf, 0.0, coating=[rc.Layer(1e9, 0.5, 0.5)])
    elif name == "thick":
        body = rc.Material(1e9, 0.3, coating=[rc.Layer(4e9, 0.3, 30.0)])
    else:
        young, poisson, layers = BODIES[name]
        coating = [rc.Layer(e * 1e9, nu, h) for e, nu, h in layers]
        body = rc.Material(young * 1e9, poisson, coating=coating)
    pressure = np.random.default_rng(5).random(shape)
    larger = np.zeros((2 * shape[0] + 3, 3 * shape[1]))
    larger[: shape[0], : shape[1]] = pressure
    for depth in (0.0, 0.2):
        found = stress_of_map(pressure, body, depth, (0.06, PIXEL))
        known = stress_of_map(larger, body, depth, (0.06, PIXEL))[:, : shape[0], : shape[1]]
        np.testing.assert_allclose(found, known, atol=3e-6 * np.abs(known).max())
