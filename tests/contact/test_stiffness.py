"""Constriction by layers, compared with the integral equation of an equipotential disc."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.stiffness import constriction_length
from roughcontact.halfspace.coating import Coatings, ConductingLayer, ConductingStack

PIXEL, RADIUS = 1e-6, 16e-6


@pytest.fixture(scope="module")
def disc() -> rc.ContactResult:
    y, x = np.mgrid[:72, :72] - 35.5
    heights = np.where(np.hypot(x, y) * PIXEL <= RADIUS, 0.0, -1e-6)
    surface = rc.Surface(heights, (PIXEL, PIXEL))
    return rc.solve(surface, material=rc.Material(210e9, 0.3), load=1e-3, tolerance=1e-4)


def disc_resistance(radius: float, thickness: float, layer: float, base: float) -> float:
    """Return the resistance of an equipotential disc on one layer [Ω].

    The dual integral equations of the half-space, ∫ A N J₀ = 1 on the disc and ∫ k A J₀ = 0
    outside, with N = (1 + λ e^(-2kt))/(1 - λ e^(-2kt)) and λ = (ρ₂ - ρ₁)/(ρ₂ + ρ₁), become
    φ(s) + 2/π ∫ φ(u) Σ λⁿ (p/(p² + (s - u)²) + p/(p² + (s + u)²)) du = 1, p = 2 n t/a (Sneddon
    1966, Mixed Boundary Value Problems in Potential Theory, §4.2).
    """
    share = (base - layer) / (base + layer)
    nodes, weights = np.polynomial.legendre.leggauss(48)
    s, weights = (nodes + 1) / 2, weights / 2
    kernel = np.zeros((s.size, s.size))
    for n in range(1, 2000):
        p = 2 * n * thickness / radius
        near, far = (p / (p**2 + (s[:, None] + sign * s) ** 2) for sign in (-1, 1))
        kernel += share**n * (near + far)
        if abs(share) ** n < 1e-12:
            break
    solved = np.linalg.solve(np.eye(s.size) + 2 / math.pi * kernel * weights, np.ones(s.size))
    return layer / (4 * radius * float(weights @ solved))


def bounded_resistance(radius: float, thickness: float, layer: float, base: float) -> float:
    """Return the resistance with the current of a disc on a half-space, an upper bound [Ω].

    ρ₁/(4 a) (1 + 4/π Σ λⁿ (atan(1/(nτ)) - nτ/2 ln(1 + 1/(nτ)²))), τ = t/a: Antonetti and
    Yovanovich 1985, J. Heat Transfer 107, 513.
    """
    share = (base - layer) / (base + layer)
    total = 0.0
    for n in range(1, 2000):
        tau = n * thickness / radius
        total += share**n * (math.atan(1 / tau) - tau / 2 * math.log1p(1 / tau**2))
    return layer / (4 * radius) * (1 + 4 / math.pi * total)


@pytest.mark.parametrize("depth", [0.1, 1.0, 4.0])
@pytest.mark.parametrize(("layer", "base"), [(1.0, 5.0), (5.0, 1.0), (1.0, 50.0), (15.0, 1.0)])
def test_layer_changes_constriction_as_integral_equation(
    disc: rc.ContactResult, depth: float, layer: float, base: float
) -> None:
    radius = math.sqrt(disc.contact_area / math.pi)
    stack = ConductingStack(base, (ConductingLayer(layer, depth * RADIUS),))
    plated = layer / constriction_length(disc, Coatings.from_bodies(stack))
    ratio = plated * constriction_length(disc) / base
    args = radius, depth * RADIUS, layer, base
    assert ratio == pytest.approx(disc_resistance(*args) / (base / (4 * radius)), rel=0.012)
    # Thomson's principle: the current of another body dissipates more.
    assert disc_resistance(*args) <= bounded_resistance(*args) * (1 + 1e-9)
    assert disc_resistance(*args) > 0.85 * bounded_resistance(*args)


def test_layers_of_one_metal_are_one_layer(disc: rc.ContactResult) -> None:
    one, two, bare = (
        constriction_length(disc, Coatings.from_bodies(ConductingStack(3.0, layers)))
        for layers in (
            (ConductingLayer(1.0, 3e-6),),
            (ConductingLayer(1.0, 1e-6), ConductingLayer(1.0, 2e-6)),
            (ConductingLayer(3.0, 3e-6),),
        )
    )
    assert two == pytest.approx(one, rel=1e-5)
    assert bare == pytest.approx(constriction_length(disc), rel=1e-6)
