"""Gases in gaps: heat and flow against kinetic theory, closed forms and direct solutions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson, quad
from scipy.optimize import brentq, fsolve

import roughcontact as rc
from roughcontact.analyses.conductance.model import filling_of, gap_conductance
from roughcontact.analyses.leak.flow import GasState, constriction, flow, gas_factor
from roughcontact.analyses.leak.model import Seal
from roughcontact.material import fluids
from roughcontact.theory.rarefied_gas import channel_flow

Array = NDArray[np.float64]

BOTH = (0, 1)
PIXEL = (2e-6, 1e-6)
GASES = [row for row in fluids.entries().values() if isinstance(row, fluids.Gas)]


def helium(inlet: float, outlet: float) -> GasState:
    gas = fluids.gas("helium")
    return GasState("helium", gas.molar_mass.value, gas.viscosity_at(293.15), 293.15, inlet, outlet)


# --- data ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("gas", GASES, ids=lambda gas: gas.name)
def test_gases_obey_kinetic_theory(gas: fluids.Gas) -> None:
    # Eucken 1913: Pr = 4γ/(9γ - 5), 2/3 of one atom and 0.74 of two; measured ones are within 5 %.
    ratio = gas.heat_capacity_ratio.value
    assert gas.prandtl == pytest.approx(4 * ratio / (9 * ratio - 5), rel=0.05)
    assert 0 < gas.accommodation.value <= 1
    assert 0.5 < gas.exponent.value < 1


def test_every_value_of_a_fluid_has_its_source() -> None:
    for row in fluids.entries().values():
        for name, value in vars(row).items():
            if name != "name":
                assert len(value.source.split()) >= 3
                assert "{" not in value.source


# --- heat ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("gas", GASES, ids=lambda gas: gas.name)
def test_a_gap_far_below_the_jump_conducts_as_free_molecules_do(gas: fluids.Gas) -> None:
    # Knudsen 1911, of walls of one accommodation a:
    # h = a/(2 - a) (γ + 1)/(γ - 1) √(R/(8π M T)) p, for any gap.
    pressure, temperature = 10.0, 320.0
    share, ratio = gas.accommodation.value, gas.heat_capacity_ratio.value
    speed = math.sqrt(fluids.GAS_CONSTANT / (8 * math.pi * gas.molar_mass.value * temperature))
    expected = share / (2 - share) * (ratio + 1) / (ratio - 1) * speed * pressure
    filling = filling_of(gas.name, pressure, temperature)
    for width in (1e-9, 1e-8):
        found = gap_conductance(np.full((4, 4), width), filling)
        assert found == pytest.approx(expected, rel=1e-4)
    # Far above it the gas conducts by its conductivity alone.
    wide = gap_conductance(np.full((4, 4), 1.0), filling_of(gas.name, 1e5, temperature))
    assert wide == pytest.approx(gas.conductivity_at(temperature), rel=1e-4)


@pytest.mark.parametrize("separation", [1.5, 2.5, 3.5])
def test_gaussian_gaps_have_yovanovichs_integral(separation: float) -> None:
    # Yovanovich, DeVaal and Hegazy 1982: of heights σ at a separation Y of the mean planes
    # h = k/(σ √2π) ∫ exp(-(Y/σ - t)²/2)/(t + M/σ) dt over t > 0.
    sigma, points = 0.5e-6, 1024
    heights = np.random.default_rng(5).standard_normal((points, points)) * sigma
    gap = separation * sigma - heights
    gap[gap <= 0] = np.nan
    for name, pressure in (("air", 1e5), ("helium", 1e5), ("argon", 1e7)):
        filling = filling_of(name, pressure)
        ratio = filling.jump / sigma

        def density(t: float, ratio: float = ratio) -> float:
            return math.exp(-((separation - t) ** 2) / 2) / (t + ratio)

        integral = quad(density, 0, separation + 8, points=[ratio, separation], limit=200)[0]
        expected = filling.conductivity / sigma / math.sqrt(2 * math.pi) * integral
        # A million pixels leave some 0.2 % of chance.
        assert gap_conductance(gap, filling) == pytest.approx(expected, rel=0.01)


# --- flow through a plane channel ----------------------------------------------------------------


def channel_of_kinetic_theory(rarefaction: float, cells: int = 100) -> float:
    """Return Q of the linearized equation by Bhatnagar, Gross and Krook, diffuse walls.

    ψ(x) = ½ + ∫ T₋₁(|x - y|) ψ(y) dy/√π across the channel of width D (Cercignani and Daneri 1963),
    ψ constant on cells that are finest at the walls; Q = 2/D² (∫ ψ dx - D/2).
    """
    speed = np.exp(np.linspace(-25, 2, 1500))
    weight = speed * np.exp(-(speed**2)) * math.log(speed[1] / speed[0])

    def primitive(distance: Array) -> Array:
        # ∫ T₋₁ = T₀(0) - T₀
        return np.array(
            [math.sqrt(math.pi) / 2 - weight @ np.exp(-row / speed[:, None]) for row in distance]
        )

    edges = rarefaction / 2 * np.sin(np.linspace(-math.pi / 2, math.pi / 2, cells + 1))
    offset = (edges[1:] + edges[:-1])[:, None] / 2 - edges
    seen = np.sign(offset) * primitive(np.abs(offset)) / math.sqrt(math.pi)
    psi = np.linalg.solve(np.eye(cells) - (seen[:, :-1] - seen[:, 1:]), np.full(cells, 0.5))
    return float(2 / rarefaction**2 * ((psi * np.diff(edges)).sum() - rarefaction / 2))


@pytest.mark.slow
def test_a_plane_channel_has_the_flow_of_kinetic_theory() -> None:
    # From Kn = 100 to 0.03, where the cells are wider than a free path; the fits are to 0.7 %.
    for knudsen in (100, 30, 10, 3, 1.5, 1, 0.7, 0.4, 0.3, 0.2, 0.1, 0.05, 0.03):
        rarefaction = math.sqrt(math.pi) / 2 / knudsen
        expected = channel_of_kinetic_theory(rarefaction)
        assert float(channel_flow(rarefaction)) == pytest.approx(expected, rel=0.012)


def test_a_plane_channel_slips_and_has_knudsens_minimum() -> None:
    # To Kn = 0.001: Poiseuille's D/6 with the slip of Kramers' problem, 1.01619 (Albertoni,
    # Cercignani and Gotusso 1963), and the next term 2 · 1.01619² - 1 over D.
    for knudsen in (0.03, 0.01, 0.001):
        d = math.sqrt(math.pi) / 2 / knudsen
        expected = d / 6 + 1.01619 + (2 * 1.01619**2 - 1) / d
        assert float(channel_flow(d)) == pytest.approx(expected, rel=1e-3)
    d = np.geomspace(0.05, 20, 2001)
    flows = channel_flow(d)
    least = int(np.argmin(flows))
    assert flows[least] == pytest.approx(1.539, rel=5e-3)
    assert 0.7 < d[least] < 1.3
    # Below the fits free molecules continue with -ln(D)/√π.
    below = channel_flow([1e-2, 1e-4])
    assert below[1] - below[0] == pytest.approx(math.log(100) / math.sqrt(math.pi))


@pytest.mark.parametrize("periodic", [(), (0,), BOTH], ids=str)
@pytest.mark.parametrize("knudsen", [0.001, 0.1, 1.0, 100.0])
def test_parallel_plates_let_the_integral_of_the_channel_through(
    knudsen: float, periodic: tuple[int, ...]
) -> None:
    gap = np.full((12, 8), 2e-7)
    inlet = helium(1.0, 0.5).knudsen(2e-7, 1.0) / knudsen
    state = helium(inlet, inlet / 50)
    viscous = flow(gap, PIXEL, 0, periodic)
    found = gas_factor(gap, PIXEL, viscous, 2e-7, state, periodic)

    def slope(p: float) -> float:
        d = math.sqrt(math.pi) / 2 / state.knudsen(2e-7, p)
        return p * 6 * float(channel_flow(d)) / d

    through = quad(slope, state.outlet, state.inlet, epsrel=1e-8, limit=400)[0]
    assert found == pytest.approx(through / ((state.inlet**2 - state.outlet**2) / 2), rel=1e-4)
    if knudsen < 0.01:
        assert found == pytest.approx(1, abs=0.02)


# --- flow through a network ----------------------------------------------------------------------


def potential(state: GasState, gap: float) -> Callable[[float], float]:
    """Return ∫ p G dp from the outlet on, for one gap."""

    def slope(p: float) -> float:
        return p * float(state.mobility(gap, p))

    return lambda p: quad(slope, state.outlet, p, epsrel=1e-9, limit=400)[0]


@pytest.mark.parametrize("inlet", [2e4, 2e5, 5e6])
def test_two_gaps_in_series_share_the_pressure(inlet: float) -> None:
    state, gaps, n = helium(inlet, 1e3), (4e-7, 1e-7), 60
    wide, narrow = (potential(state, gap) for gap in gaps)

    def imbalance(p: float) -> float:
        return gaps[0] ** 3 * (wide(inlet) - wide(p)) - gaps[1] ** 3 * narrow(p)

    middle = brentq(imbalance, state.outlet, inlet)
    # Half of the length each: throughput times 12 η over the length.
    expected = 2 * gaps[1] ** 3 * narrow(middle)
    gap = np.repeat([[gaps[0]], [gaps[1]]], n, axis=0) * np.ones(4)
    viscous = flow(gap, PIXEL, 0, (1,))
    found = gas_factor(gap, PIXEL, viscous, gaps[1], state, (1,))
    found *= viscous.permeability[0] * (inlet**2 - state.outlet**2) / 2
    assert found == pytest.approx(expected, rel=2e-3)


def rough(shape: tuple[int, int], seed: int, closed: float = 0.15) -> Array:
    heights = rc.self_affine(
        shape,
        (1e-6, 1e-6),
        rms_height=1e-7,
        rolloff_wavelength=16e-6,
        cutoff_wavelength=4e-6,
        hurst=0.8,
        rng=np.random.default_rng(seed),
    )
    return np.maximum(heights - np.quantile(heights, closed), 0.0)


def test_the_network_balances_as_newtons_method_has_it() -> None:
    # Throughput between pixels: harmonic mean of g³ G over that of the narrowest gap, at the
    # pressures of the pixels, times the fall of the potential; all of it solved at once.
    gap = 1e-9 + rough((7, 5), 3, closed=0.0)
    state = helium(3e5, 1e4)
    narrow = constriction(gap, 0).gap
    table = np.linspace(state.outlet, state.inlet, 3001)
    values = cumulative_simpson(table * state.mobility(narrow, table), x=table, initial=0)
    ny, nx = gap.shape
    dy, dx = PIXEL

    def passed(fallen: Array) -> tuple[Array, float]:
        pressure = np.interp(fallen * values[-1], values, table)
        k = gap**3 * state.mobility(gap, pressure) / state.mobility(narrow, pressure)
        down = 2 / (1 / k[1:] + 1 / k[:-1]) * dx / dy * (fallen[:-1] - fallen[1:])
        right = 2 / (1 / k[:, 1:] + 1 / k[:, :-1]) * dy / dx * (fallen[:, :-1] - fallen[:, 1:])
        balance = np.zeros_like(k)
        balance[:-1] -= down
        balance[1:] += down
        balance[:, :-1] -= right
        balance[:, 1:] += right
        inflow = 2 * k[0] * dx / dy * (1 - fallen[0])
        balance[0] += inflow
        balance[-1] -= 2 * k[-1] * dx / dy * fallen[-1]
        return balance, float(inflow.sum())

    scale = float(gap.max()) ** 3
    start = np.linspace(1, 0, ny)[:, None] * np.ones(nx)
    solved = fsolve(
        lambda u: passed(u.reshape(ny, nx))[0].ravel() / scale, start.ravel(), xtol=1e-13
    )
    expected = passed(solved.reshape(ny, nx))[1] * (ny * dy) / (nx * dx) * values[-1]
    viscous = flow(gap, PIXEL, 0)
    found = gas_factor(gap, PIXEL, viscous, narrow, state)
    found *= viscous.permeability[0] * (state.inlet**2 - state.outlet**2) / 2
    assert found == pytest.approx(expected, rel=1e-4)


def test_gas_flow_of_sample_matches_land_of_twelve_cells() -> None:
    # A land of twelve cells, solved as a whole, against one cell at two pressures.
    cell = rough((24, 24), 6)
    state = helium(2e5, 1e3)
    narrow = constriction(cell, 0, BOTH).gap
    one = flow(cell, PIXEL, 0, BOTH)
    expected = one.permeability[0] * gas_factor(cell, PIXEL, one, narrow, state, BOTH)
    land = np.tile(cell, (12, 1))
    whole = flow(land, PIXEL, 0, (1,))
    found = whole.permeability[0] * gas_factor(land, PIXEL, whole, narrow, state, (1,))
    # The two ends let a little more in than seams do.
    assert found == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(("inlet", "outlet"), [(2e5, 1e2), (2e7, 1e5), (1e2, 1.0)])
def test_two_pressures_of_a_sample_are_enough(inlet: float, outlet: float) -> None:
    cell, state = rough((48, 48), 6), helium(inlet, outlet)
    narrow = constriction(cell, 0, BOTH).gap
    one = flow(cell, PIXEL, 0, BOTH)
    two, many = (gas_factor(cell, PIXEL, one, narrow, state, BOTH, n) for n in (2, 8))
    assert two == pytest.approx(many, rel=7e-3)


def test_a_ring_is_the_logarithm_of_its_radii() -> None:
    for land in (10e-3, 1e-5):
        width, length = Seal(1e-3, 1e5, length=land, ring=40e-3).face_dimensions((1.0, 1.0), 0)
        expected = 2 * math.pi / math.log((40e-3 + land) / (40e-3 - land))
        assert width / length == pytest.approx(expected)
    # A narrow land is a strip as long as the circumference.
    assert width == pytest.approx(math.pi * 40e-3, rel=1e-6)


def test_the_mean_pressure_over_a_land_is_that_of_its_profile() -> None:
    # p² falls evenly along the land.
    x = (np.arange(10000) + 0.5) / 10000
    for inlet, outlet in ((2e5, 1e2), (2e5, 1.9e5)):
        seal = Seal(2e-5, inlet - outlet, gas=helium(inlet, outlet))
        profile = np.sqrt(inlet**2 + x * (outlet**2 - inlet**2))
        assert seal.mean_pressure == pytest.approx(profile.mean() - outlet, rel=1e-4)
    assert Seal(1e-3, 2e5).mean_pressure == 1e5
