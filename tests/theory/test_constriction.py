"""Conductance of contact spots against closed forms and Greenwood's formula."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.sparse.linalg import LinearOperator, cg

import roughcontact as rc
from roughcontact.analyses.conductance.model import filling_of, greenwood
from roughcontact.contact.result import ContactResult
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
def test_ball_conducts_as_whole_disc(ceiling: float | None) -> None:
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


def test_two_distant_discs_add_with_mutual_resistance() -> None:
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
    # Spots that are in the middle of others carry less than in proportion to their radii.
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
    found = rc.conductance(full, UNIT, UNIT, electrical_film=2e-12)
    assert found.steps[0].length == math.inf
    assert found.electrical_resistance[0] == pytest.approx(2e-12 / full.contact_area)
    assert found.thermal_resistance[0] == 0


def theory(separation: float, part: float) -> tuple[float, float]:
    """Return share in contact and h σ/(k m) of Gaussian heights, by the theory itself.

    Each spot of radius a conducts 2 k a/ψ with ψ = (1 - √α)^1.5; number and mean radius of the
    spots are those of the level set of Gaussian heights, their area times ``part``.
    """
    share = 0.5 * math.erfc(separation / math.sqrt(2))
    # Spots over area, (m/σ)² exp(-λ²)/(16 ½ erfc) ½, and a mean radius that makes up the share.
    number = math.exp(-(separation**2)) / (32 * share)
    radius = math.sqrt(8 / math.pi) * math.exp(separation**2 / 2) * 2 * share
    radius *= math.sqrt(part)
    return part * share, 2 * number * radius / (1 - math.sqrt(part * share)) ** 1.5


@pytest.mark.parametrize("separation", np.linspace(2.2, 4.4, 8).tolist())
def test_the_correlations_are_their_theories(separation: float) -> None:
    share, wanted = theory(separation, 1.0)
    found = constriction.plastic_joint(share, 1.0, 1.0, 1.0) / 2
    assert found == pytest.approx(wanted, rel=0.016)
    # Elastic spots have half of the area: α = √2 p/(E* m).
    share, wanted = theory(separation, 0.5)
    found = constriction.elastic_joint(share / math.sqrt(2), 1.0, 1.0, 1.0) / 2
    assert found == pytest.approx(wanted, rel=0.035)


def rough(seed: int, n: int = 256) -> rc.Surface:
    pixel = 256e-6 / n
    heights = rc.self_affine(
        n, pixel, rms_height=0.5e-6, rolloff_wavelength=32e-6, cutoff_wavelength=4e-6, rng=seed
    )
    return rc.Surface(heights, (pixel, pixel))


def test_resistance_depends_less_on_grid_than_contact_area() -> None:
    surface = rough(1)
    fine = rc.solve(surface, load=2.0, material=STEEL, boundary="periodic")
    (coarse,) = (
        rc.solve(part, load=2.0, material=STEEL, boundary="periodic")
        for part in [surface.resampled(pixel=(2e-6, 2e-6), method="bandlimited")]
    )
    found = rc.conductance(fine, UNIT, UNIT).with_coarser_grid(coarse)
    assert found.coarser is not None
    assert found.coarser.pixel == pytest.approx(2e-6)
    assert 0.03 < found.coarser.contact_area < 0.3
    assert abs(found.coarser.length) < found.coarser.contact_area / 3


def test_a_free_map_spreads_from_its_outline_as_well() -> None:
    whole = touching([(127.5, 127.5, 400.0, 400.0)])
    square = constriction.ellipse(256 / math.sqrt(math.pi), 256 / math.sqrt(math.pi))
    # Capacitances of a square and of a disc of unit area, over 4π ε: 0.3668 and 0.3592.
    assert length(whole) == pytest.approx(0.3668 / 0.3592 * square, rel=0.01)
    # Where nearly all touches the spreading alone is left, of both.
    surface = rough(3, 128)
    result = rc.solve(surface, load=40.0, material=STEEL, ceiling=1e9)
    (step,) = rc.conductance(result, UNIT, UNIT).steps
    assert step.contact_area > 0.5 * 256e-6**2
    assert step.correlation_length == pytest.approx(step.length, rel=0.08)


@pytest.mark.parametrize("ceiling", [None, 2e9])
def test_the_correlation_of_rough_joints_is_within_its_scatter(ceiling: float | None) -> None:
    heights = rc.self_affine(
        256, 1e-6, rms_height=0.5e-6, rolloff_wavelength=32e-6, cutoff_wavelength=8e-6, rng=2
    )
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


def coupled_conductance(result: rc.ContactResult, local: np.ndarray, resistivity: float) -> float:
    """Return the conductance per area of half-spaces joined by local conductances, both solved.

    The flux q under a unit drop of temperature: q/h + Σ(1/k) S q = 1, S q of a wave q/|k|.
    """
    edges = zip(local.shape, result.pair.pixel, strict=True)
    y, x = (2 * math.pi * np.fft.fftfreq(points, edge) for points, edge in edges)
    waves = np.hypot(y[:, None], x)
    spread = resistivity / np.where(waves > 0, waves, np.inf)
    joined = local > 0
    series = np.where(joined, 1 / np.where(joined, local, 1), 0)

    def rise(q: np.ndarray) -> np.ndarray:
        q = np.where(joined, q.reshape(local.shape), 0)
        spreading = np.fft.ifft2(np.fft.fft2(q) * spread).real
        return np.where(joined, spreading + series * q, 0).ravel()

    scale = 1 / (series + resistivity * result.pair.pixel[0] / 2)
    n = local.size
    flux, failed = cg(
        LinearOperator((n, n), matvec=rise),
        joined.astype(float).ravel(),
        M=LinearOperator((n, n), matvec=lambda q: q * scale.ravel()),
        rtol=1e-6,
        maxiter=5000,
    )
    assert not failed
    return float(flux.mean())


@pytest.mark.long
def test_gap_conductance_adds_as_in_coupled_solution() -> None:
    surface = rc.generate((96, 96), (2e-6, 2e-6), Sq=0.4e-6, Sal=8e-6, rng=1)
    metal = rc.Material(206e9, 0.3, 0.3e9)
    steel, aluminium = rc.Conductor(conductivity=42.6), rc.Conductor(conductivity=167)
    resistivity = 1 / 42.6 + 1 / 167
    for pressure in (5e6, 80e6):
        result = rc.solve(
            surface, material=metal, load=rc.NominalPressure(pressure), boundary="periodic"
        )
        found = rc.conductance(result, steel, aluminium)
        alone = coupled_conductance(result, np.where(result.contact, np.inf, 0), resistivity)
        assert found.thermal_conductance[0] == pytest.approx(alone, rel=1e-3)
        for name, low, high, near in (
            ("air", 0.75, 1.05, 0.01),
            ("helium", 0.75, 1.05, 0.015),
            ("oil", 1.0, 1.35, 0.08),
            ("grease", 1.0, 1.35, 0.08),
        ):
            fluid = filling_of(name)
            with np.errstate(divide="ignore"):
                gap = fluid.conductivity / (np.fmax(result.gap, 0) + fluid.jump)
            both = coupled_conductance(result, np.where(result.contact, np.inf, gap), resistivity)
            together = rc.conductance(result, steel, aluminium, gap=name)
            added = together.column("filled_gap")[0]
            assert low * (both - alone) < added < high * (both - alone)
            assert together.joint_conductance[0] == pytest.approx(both, rel=near)
            if name in ("air", "oil"):
                assert found.filled_conductance(name) == together.joint_conductance


@pytest.mark.parametrize("voltage", [0.02, 0.1, 0.4])
def test_the_hottest_spot_is_that_of_a_bar_heated_by_its_current(voltage: float) -> None:
    # A bar with k = L T/ρ whose ends are at T₀: (k T′)′ + j² ρ = 0 by shooting from its middle.
    cold, lorenz, resistivity, half = 300.0, 2.44e-8, 2e-8, 1e-3
    density = voltage / (2 * half * resistivity)

    def heat(_: float, state: np.ndarray) -> list[float]:
        temperature, flux = state
        return [-flux * resistivity / (lorenz * temperature), density**2 * resistivity]

    def end(middle: float) -> float:
        path = solve_ivp(heat, (0, half), [middle, 0.0], rtol=1e-9, atol=1e-9)
        return float(path.y[0, -1]) - cold

    found = constriction.hottest_spot(voltage, cold)
    assert end(found) == pytest.approx(0, abs=1e-3)
    assert abs(end(1.001 * found)) > 0.1
