"""The law of an interface against closed forms, and against itself."""

import math

import numpy as np
import pytest
from scipy.special import erf

import roughcontact as rc
from roughcontact.analyses.history.model import history as load_history, indented_surface
from roughcontact.analyses.law.curve import asperities
from roughcontact.analyses.law.model import LOADING, UNLOADING
from roughcontact.contact.stiffness import local_stiffness
from roughcontact.theory import persson, waves

STEEL = rc.Material(210e9, 0.3)
E = rc.contact_modulus(STEEL, rc.RIGID)
SOFT = rc.Material(210e9, 0.3, 1e9)


def solve_contacts(
    surface: rc.Surface,
    pressures: list[float],
    material: rc.Material = STEEL,
    boundary: str = "periodic",
) -> list[rc.ContactResult]:
    return [
        rc.solve(surface, material=material, load=rc.NominalPressure(p), boundary=boundary)
        for p in pressures
    ]


def after(
    contacts: list[rc.ContactResult], pressures: list[float], boundary: str = "periodic"
) -> list[rc.ContactResult]:
    left = indented_surface(max(contacts, key=lambda one: one.load))
    return [
        rc.solve(left, material=STEEL, ceiling=None, load=rc.NominalPressure(p), boundary=boundary)
        for p in pressures
    ]


def rough(
    points: int, seed: int, rolloff: float, cutoff: float = 8.0, height: float = 0.5e-6
) -> rc.Surface:
    """Return a map with pixels of 1 µm, its waves between some number of pixels."""
    heights = rc.self_affine(
        (points, points),
        (1e-6, 1e-6),
        rms_height=height,
        rolloff_wavelength=rolloff * 1e-6,
        cutoff_wavelength=cutoff * 1e-6,
        rng=np.random.default_rng(seed),
    )
    return rc.Surface(heights, (1e-6, 1e-6))


def test_a_wavy_surface_has_westergaards_law() -> None:
    length, amplitude, points = 100e-6, 0.2e-6, 512
    x = (np.arange(points) + 0.5) / points
    pixel = length / points
    surface = rc.Surface(np.tile(amplitude * np.cos(2 * np.pi * x), (16, 1)), (pixel, pixel))
    star = waves.wavy_full_contact_pressure(amplitude, length, E)
    pressures = [share * star for share in (0.05, 0.2, 0.5, 0.8)]
    law = rc.interface_law(solve_contacts(surface, pressures))
    assert law.maps[0].first_touch == pytest.approx(amplitude, rel=1e-4)
    for step, p in zip(law.steps, pressures, strict=True):
        gap = waves.wavy_mean_gap(p, star, amplitude)
        # To the pixel of the contact's edge, of which there are 2 in 512.
        assert step.separation == pytest.approx(gap, abs=2e-3 * amplitude)
        width = 2 * waves.wavy_half_width(p, star, length)
        assert step.contact_fraction == pytest.approx(width / length, abs=3 / points)
        h = 1e-4 * p
        slope = waves.wavy_mean_gap(p - h, star, amplitude) - waves.wavy_mean_gap(
            p + h, star, amplitude
        )
        assert step.stiffness == pytest.approx(2 * h / slope, rel=0.02)


def test_one_ball_a_cell_is_hertzs_contact_with_its_images() -> None:
    # A paraboloid in each cell: 1/K = 1/(2 E* a) - M/(π E* L), M = 3.900264920 that of charges on a
    # square lattice in a uniform background (Bonsall and Maradudin 1977, Phys. Rev. B 15, 1959).
    points, pixel, radius = 256, 1e-6, 5e-3
    length = points * pixel
    y, x = (np.mgrid[:points, :points] - points / 2 + 0.5) * pixel
    surface = rc.Surface(-(x**2 + y**2) / (2 * radius), (pixel, pixel))
    pressures = [1e6, 4e6]
    law = rc.interface_law(solve_contacts(surface, pressures))
    for step, p in zip(law.steps, pressures, strict=True):
        a = (3 * p * length**2 * radius / (4 * E)) ** (1 / 3)
        assert 10 * pixel < a < 0.1 * length
        assert step.contact_fraction == pytest.approx(math.pi * a**2 / length**2, rel=0.06)
        compliance = 1 / (2 * E * a) - 3.900264920 / (math.pi * E * length)
        assert step.stiffness == pytest.approx(1 / compliance / length**2, rel=0.015)


@pytest.mark.parametrize("boundary", ["periodic", "free", "periodic-x"])
def test_stiffness_is_the_slope_of_the_curve(boundary: str) -> None:
    surface = rough(128, 5, 12)
    pressures = [300e6 * factor for factor in (0.99, 1.0, 1.01)]
    contacts = solve_contacts(surface, pressures, SOFT, boundary)
    flowing = rc.interface_law(contacts, after(contacts, pressures, boundary))
    elastic = rc.interface_law(solve_contacts(surface, pressures, STEEL, boundary))
    assert not flowing.is_elastic
    # The outline of an elastic contact hardly matters: no pressure is at its edge.
    for (one,), branch in ((flowing.maps, UNLOADING), (elastic.maps, LOADING)):
        p, u = one.column(branch, "pressure"), one.column(branch, "separation")
        slope = (p[0] - p[2]) / (u[2] - u[0])
        assert one.column(branch, "unloading_stiffness")[1] == pytest.approx(slope, rel=0.01)


def test_unloading_starts_where_loading_ended_and_meets_the_history() -> None:
    surface = rough(64, 2, 16)
    pressures = [100e6, 300e6, 600e6]
    contacts = solve_contacts(surface, pressures, SOFT)
    law = rc.interface_law(contacts, after(contacts, pressures))
    top, down = law.branch_steps(LOADING)[-1], law.branch_steps(UNLOADING)
    assert down[-1].separation == pytest.approx(top.separation, rel=1e-4)
    assert down[-1].contact_fraction == pytest.approx(top.contact_fraction, rel=0.01)
    assert down[-1].unloading_stiffness == pytest.approx(top.unloading_stiffness, rel=0.01)
    # Points that flowed continue to flow in loading, and spring back in unloading.
    assert top.stiffness < 0.7 * top.unloading_stiffness
    area = surface.size[0] * surface.size[1]
    path = [p * area for p in (600e6, 300e6, 100e6)]
    history = load_history(surface, path, material=SOFT, boundary="periodic")
    first_touch = law.maps[0].first_touch
    for step, expected in zip(history.steps, down[::-1], strict=True):
        assert expected.separation == pytest.approx(
            first_touch - step.approach, abs=1e-5 * first_touch
        )
        assert expected.contact_fraction == pytest.approx(step.contact_area / area, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.0, 0.2])
def test_inside_its_rim_a_free_map_has_the_law_of_a_periodic_one(ratio: float) -> None:
    # The same map, free and periodic, evaluated in the same window so that only the
    # boundary differs.
    surface = rc.generate((256, 256), (1e-6, 1e-6), Sq=0.5e-6, Sal=6e-6, Str=ratio, rng=3)
    free = rc.interface_law(solve_contacts(surface, [30e6, 300e6, 1e9, 3e9], boundary="free"))
    (inside,) = free.maps
    assert inside.window is not None
    assert free.rim == pytest.approx(18e-6, rel=0.02)
    around = solve_contacts(surface, np.geomspace(10e6, 5e9, 21).tolist())
    p = np.array([one.pressure[inside.window].mean() for one in around])
    u = np.array([one.gap[inside.window].mean() for one in around])
    nominal = np.array([30e6, 300e6, 1e9, 3e9])
    result = np.interp(-inside.column(LOADING, "separation"), -u, np.log(p))
    assert inside.column(LOADING, "pressure") == pytest.approx(np.exp(result), rel=0.03)
    # The edges carry more: at 3 GPa the inside has some 0.7 of the nominal pressure.
    assert (inside.column(LOADING, "pressure") / nominal)[-1] < 0.85
    stiffness = np.array([local_stiffness(one, inside.window)[0] for one in around])
    result = np.interp(np.log(inside.column(LOADING, "pressure")), np.log(p), np.log(stiffness))
    assert inside.column(LOADING, "stiffness") == pytest.approx(np.exp(result), rel=0.05)


@pytest.mark.long
def test_perssons_exponential_holds_in_the_middle_range() -> None:
    surfaces = [rough(256, seed, 32) for seed in (0, 1)]
    pressures = np.geomspace(100e6, 600e6, 4).tolist()
    law = rc.interface_law(
        one for surface in surfaces for one in solve_contacts(surface, pressures)
    )
    assert law.is_elastic
    assert 0.005 < law.steps[0].contact_fraction < law.steps[-1].contact_fraction < 0.06
    u = np.array([step.separation for step in law.steps])
    decay = -1 / np.polyfit(u, np.log(pressures), 1)[0]
    # u₀ = γ Sq with γ of 0.4 to 0.5 (Persson 2007); these maps, no wider than 8 of their longest
    # waves, lack the highest summits and have a little less: 0.41.
    assert 0.37 < decay / 0.5e-6 < 0.5
    for step in law.steps:
        assert step.stiffness == pytest.approx(step.pressure / decay, rel=0.25)


@pytest.mark.long
def test_perssons_integral_holds_up_to_full_contact() -> None:
    surface = rough(256, 0, 32)
    steps = rc.interface_law(solve_contacts(surface, [3e9, 6e9, 12e9, 24e9])).steps
    # From a fifth of the area in contact on, where ū is 0.66 Sq; measured: 0.014 Sq and less.
    assert 0.2 < steps[0].contact_fraction < 0.3
    assert steps[-1].contact_fraction > 0.8
    for step in steps:
        assert step.separation == pytest.approx(step.persson_separation, abs=0.04 * 0.5e-6)


def test_perssons_separation_is_that_of_its_energy() -> None:
    q = np.linspace(1e5, 4e6, 40)
    m = q**-2.6 / (q**-2.6).sum() * 1e-14
    p = np.geomspace(1e6, 3e11, 1200)
    u = persson.persson_separation(p, E, q, m, 0.45)
    # U = (π/2) E* ∫ q² C W dq with 2π q C dq = dm, each shell spread over itself.
    slopes = q**2 * m
    before = np.concatenate([[0], np.cumsum(slopes)[:-1]])
    t = (np.arange(300) + 0.5) / 300
    energy = np.zeros_like(p)
    for k in range(q.size):
        w = 1 / np.sqrt((before[k] + slopes[k] * t**2) / 2)
        contact = erf(np.multiply.outer(p, w / E))
        stored = contact * (0.45 + 0.55 * contact**2)
        energy += E / 4 * q[k] * m[k] * (stored @ (2 * t / 300))
    assert energy[-1] == pytest.approx(E / 4 * (q * m).sum(), rel=1e-6)
    # dU = -p̄ dū between the pressures.
    work = np.concatenate([[0], np.cumsum(-np.diff(u) * (p[1:] + p[:-1]) / 2)])
    assert work == pytest.approx(energy - energy[0], rel=2e-3, abs=1e-5 * energy[-1])
    # All of it closes in the end, and at small pressure the decay is u₀.
    assert u[-1] < 1e-6 * math.sqrt(m.sum())
    decay = (u[0] - u[1]) / math.log(p[1] / p[0])
    assert decay == pytest.approx(persson.persson_decay(q, m, 0.45), rel=1e-3)


@pytest.mark.long
def test_the_mean_of_n_maps_scatters_as_one_over_root_n() -> None:
    pressures = [100e6, 110e6]
    singles = np.array(
        [solve_contacts(rough(64, seed, 16), pressures[:1])[0].gap.mean() for seed in range(48)]
    )
    groups = singles.reshape(12, 4).mean(axis=1)
    # 12 groups have a deviation known to about 21 %.
    ratio = groups.std(ddof=1) / singles.std(ddof=1)
    assert 0.3 < ratio < 0.75
    law = rc.interface_law(
        one for seed in range(4) for one in solve_contacts(rough(64, seed, 16), pressures)
    )
    step = law.steps[0]
    assert step.separation_deviation == pytest.approx(singles[:4].std(ddof=1), rel=1e-6)
    # Student's 3.182 of 3 degrees of freedom.
    half = 3.182 * step.separation_deviation / 2
    assert step.separation_half == pytest.approx(half, rel=1e-3)


def test_summits_of_a_gaussian_surface_are_those_of_its_moments() -> None:
    # Fine enough for differences of neighbors: 16 pixels for the shortest wave.
    surface = rough(1024, 4, 128, 16, 1e-6)
    found = asperities(surface.heights, surface.pixel)
    z = surface.heights
    around = [
        np.roll(z, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)
    ]
    summits = np.all([z > other for other in around], axis=0)
    density = summits.sum() / (z.size * 1e-12)
    assert density == pytest.approx(found.density, rel=0.05)
    bend = sum(2 * z - np.roll(z, 1, a) - np.roll(z, -1, a) for a in (0, 1)) / (2 * 1e-12)
    assert bend[summits].mean() == pytest.approx(1 / found.radius, rel=0.05)
    assert found.bandwidth > 1.5
