"""Partial slip against closed forms, superposition, symmetry and identities of energy."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.tangential.model import Tangential, tangential_compliance
from roughcontact.halfspace import tangential as halfspace
from roughcontact.halfspace.boundary import Boundary
from roughcontact.solvers import partial_slip

FRICTION, YOUNG, RADIUS, LOAD = 0.15, 210e9, 10e-3, 1.0


def steel(poisson: float, **more: float) -> rc.Material:
    return rc.Material(young=YOUNG, poisson=poisson, **more)


def hertz_radius(poisson: float) -> float:
    modulus = rc.contact_modulus(steel(poisson), steel(poisson))
    return (3 * LOAD * RADIUS / (4 * modulus)) ** (1 / 3)


@functools.cache
def sphere(poisson: float, points: int = 128) -> rc.ContactResult:
    """Return a ball on its like, about 50 pixels across in contact of 64 per radius 2.6."""
    side = 2.6 * hertz_radius(poisson)
    y = (np.arange(points) - points / 2 + 0.5) * side / points
    ball = rc.Surface(-(y[:, None] ** 2 + y**2) / (2 * RADIUS), pixel=(side / points,) * 2)
    body = steel(poisson)
    return rc.solve(
        ball, material=body, counter_material=body, load=LOAD, tolerance=1e-9, calibrated=False
    )


@functools.cache
def rough(
    poisson: float, boundary: str = "free", points: int = 64, ceiling: str | None = None
) -> rc.ContactResult:
    """Return a rough map, a smooth one where it is elastic: a tenth of it touches."""
    heights, pixel = rc.reference_map(points)
    body = steel(poisson, yield_strength=1e9)
    heights = heights * (0.3 if ceiling is None else 1.0)
    return rc.solve(
        rc.Surface(heights, pixel),
        material=body,
        counter_material=body,
        load=1.0,
        boundary=boundary,
        ceiling=ceiling,
        tolerance=1e-10,
        calibrated=False,
    )


def pushed(contact: rc.ContactResult, part: float, **more: object) -> Tangential:
    options = {"friction": FRICTION, "force": part * FRICTION * contact.load, "tolerance": 1e-8}
    return rc.tangential(contact, **(options | more))


def compliance(poisson: float) -> float:
    """Return Σ(2 - ν)/G of two like bodies."""
    return 2 * (2 - poisson) * 2 * (1 + poisson) / YOUNG


# --- Cattaneo and Mindlin: the sphere ---


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
@pytest.mark.parametrize(
    ("poisson", "low"), [(0.0, 0.0), (0.3, -1e-3), pytest.param(0.5, -4e-3, marks=pytest.mark.long)]
)
def test_the_shift_of_a_sphere_is_that_of_mindlin(poisson: float, low: float, part: float) -> None:
    result = pushed(sphere(poisson), part)
    formula = (
        3
        * FRICTION
        * LOAD
        / (16 * hertz_radius(poisson))
        * compliance(poisson)
        * (1 - (1 - part) ** (2 / 3))
    )
    # The formula leaves out the traction across the force: the true shift is smaller.
    assert low - 2e-4 < result.last.shift / formula - 1 < 2e-4
    assert result.last.certificate <= 1e-8
    assert result.last.force_error <= 1e-10
    assert math.sqrt(result.last.stick_fraction) == pytest.approx((1 - part) ** (1 / 3), rel=0.02)


@pytest.mark.parametrize(("part", "error"), [(0.1, 0.04), (0.5, 0.01), (0.9, 0.01)])
def test_the_traction_on_a_sphere_is_that_of_cattaneo(part: float, error: float) -> None:
    contact = sphere(0.0)
    result = pushed(contact, part)
    a, (dy, dx) = hertz_radius(0.0), contact.pair.pixel
    y, x = np.indices(contact.pressure.shape)
    middle = (contact.pressure.shape[0] - 1) / 2
    r = np.hypot((y - middle) * dy, (x - middle) * dx) / a
    c = (1 - part) ** (1 / 3)
    peak = 1.5 * LOAD / (math.pi * a**2)
    outer, inner = (np.sqrt(np.maximum(1 - (r / edge) ** 2, 0)) for edge in (1.0, c))
    formula = FRICTION * peak * (outer - c * inner)
    apart = np.linalg.norm(result.traction[1] - formula) / np.linalg.norm(formula)
    assert apart < error


@pytest.mark.long
@pytest.mark.parametrize(("poisson", "error"), [(0.0, 1e-3), (0.3, 5e-3)])
def test_loop_dissipation_matches_mindlin_and_deresiewicz(poisson: float, error: float) -> None:
    contact = sphere(poisson, 64)
    most = 0.6 * FRICTION * LOAD
    loop = pushed(contact, 0.6, force=[most, -most, most])
    f = 0.6
    formula = (
        9
        * FRICTION**2
        * LOAD**2
        / (10 * hertz_radius(poisson))
        * compliance(poisson)
        * (1 - (1 - f) ** (5 / 3) - 5 * f / 6 * (1 + (1 - f) ** (2 / 3)))
    )
    assert loop.cycle_energy == pytest.approx(formula, rel=error)
    assert loop.cycle_energy == pytest.approx(4 * loop.steps[0].energy, rel=1e-3)
    first = pushed(contact, 0.6)
    assert first.cycle_energy == pytest.approx(loop.cycle_energy, rel=1e-3)
    # The loop closes, and its first half is the first loading, turned.
    size = np.linalg.norm(first.traction)
    assert np.linalg.norm(loop.traction - first.traction) / size < 1e-6
    assert loop.last.shift == pytest.approx(first.last.shift, rel=1e-6)
    assert loop.steps[1].shift == pytest.approx(-first.last.shift, rel=1e-6)
    assert loop.loss_factor == pytest.approx(first.loss_factor, rel=1e-3)


def test_masing_reverses_the_backbone_at_half_the_force() -> None:
    contact = sphere(0.0, 64)
    most = 0.8 * FRICTION * LOAD
    path = pushed(contact, 0.8, force=[most, 0.0])
    half = pushed(contact, 0.4)
    assert path.steps[0].shift - path.steps[1].shift == pytest.approx(2 * half.last.shift, rel=1e-6)


def backbone(contact: rc.ContactResult, part: float) -> float:
    return pushed(contact, part).last.shift


@pytest.mark.long
@pytest.mark.parametrize(("poisson", "error"), [(0.0, 1e-6), (0.3, 3e-3)])
def test_inner_loop_closes_without_effect_on_outer_loop(poisson: float, error: float) -> None:
    contact = rough(poisson, "periodic")
    parts = [0.8, -0.5, 0.2, -0.5, 0.8]
    most = FRICTION * contact.load
    path, inner, first = (
        pushed(contact, 0.0, force=[most * part for part in parts[:count]]) for count in (5, 4, 2)
    )
    shift = path.column("shift")
    # Each branch is the first loading at twice its size (Masing).
    for start, part in ((0, -0.5), (1, 0.2), (2, -0.5)):
        turn = (part - parts[start]) / 2
        expected = math.copysign(2 * backbone(contact, abs(turn)), turn)
        assert shift[start + 1] - shift[start] == pytest.approx(expected, rel=error)
    # Back at the reversal the path continues as if the inner loop had not been.
    scale = shift[0]
    assert shift[3] - shift[1] == pytest.approx(0, abs=error * scale)
    assert shift[4] - shift[0] == pytest.approx(0, abs=error * scale)
    size = np.linalg.norm(first.traction)
    assert np.linalg.norm(inner.traction - first.traction) / size < 10 * error
    once = pushed(contact, 0.8).traction
    assert np.linalg.norm(path.traction - once) / np.linalg.norm(once) < 10 * error


# --- Superposition ---


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_superposition_is_exact_without_poisson_ratio(boundary: str) -> None:
    contact = rough(0.0, boundary)
    result = pushed(contact, 0.5, tolerance=1e-10)
    curve = result.superposition
    assert curve.traction_difference < 1e-8
    assert curve.shift[-1] == pytest.approx(result.last.shift, rel=1e-9)
    assert curve.stick_fraction[-1] == pytest.approx(result.last.stick_fraction, rel=1e-12)
    assert curve.cycle_energy[-1] == pytest.approx(result.cycle_energy, rel=1e-7)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_superposition_gives_curve_and_stick_of_rough_steel(boundary: str) -> None:
    result = pushed(rough(0.3, boundary), 0.5)
    curve = result.superposition
    assert 0.03 < curve.traction_difference < 0.12
    assert curve.shift[-1] == pytest.approx(result.last.shift, rel=0.02)
    assert curve.stick_fraction[-1] == pytest.approx(result.last.stick_fraction, abs=0.01)


@pytest.mark.parametrize(("points", "ceiling"), [(64, None), (128, "auto")])
def test_the_backbone_of_a_ground_joint_is_that_of_superposition(
    points: int, ceiling: str | None
) -> None:
    contact = rough(0.3, "periodic", points, ceiling)
    most = 0.9 * FRICTION * contact.load
    result = pushed(contact, 0.9, force=[0.5 * most, most])
    np.testing.assert_allclose(result.column("shift"), result.superposition.shift[1:], rtol=0.02)
    once = pushed(contact, 0.9)
    assert once.last.shift == pytest.approx(result.last.shift, rel=1e-3)
    apart = np.linalg.norm(once.traction - result.traction) / np.linalg.norm(once.traction)
    assert apart < 0.01


def test_superposition_under_a_ceiling_needs_the_unloading_branch() -> None:
    contact = rough(0.0, "free", ceiling="auto")
    assert contact.saturated_fraction > 0.03 * contact.contact_fraction
    low = FRICTION / 3
    part = 0.5 * low * contact.load
    result = rc.tangential(contact, friction=low, force=part, tolerance=1e-9)
    curve = result.superposition
    assert curve.traction_difference < 1e-7
    assert curve.shift[-1] == pytest.approx(result.last.shift, rel=1e-7)
    loading = rc.solve(
        contact.surface,
        material=contact.material,
        load=contact.load / 2,
        counter_material=contact.counter_material,
        calibrated=False,
    )
    other = low * (contact.pressure - loading.pressure)
    apart = np.linalg.norm(result.traction[1] - other) / np.linalg.norm(other)
    assert apart > 0.1


def test_shear_yields_before_it_slips_where_friction_is_high() -> None:
    contact = rough(0.3, "free", ceiling="auto")
    result = rc.tangential(contact, friction=0.4, shift="1 um")
    limit = 1e9 / math.sqrt(3)
    assert np.hypot(*result.traction).max() == pytest.approx(limit)
    assert result.capacity < 0.4 * contact.load
    assert result.superposition is None
    assert "shear-yield" in {caution.kind for caution in result.cautions}


# --- Stiffness ---


def test_sticking_circle_has_mindlin_ratio() -> None:
    points, poisson = 112, 0.3
    y = np.arange(points) - points / 2 + 0.5
    index = np.flatnonzero(np.hypot(y[:, None], y) <= 50)
    operator = halfspace.operator(Boundary.FREE, (points, points), (1.0, 1.0), 1.0, poisson)
    normal = halfspace.operator(Boundary.FREE, (points, points), (1.0, 1.0), 1.0, 0.0)
    along = np.array([0.0, 1.0])
    ratio = partial_slip.stiffness(operator, index, along) / partial_slip.stiffness(
        normal, index, along
    )
    assert ratio == pytest.approx(2 * (1 - poisson) / (2 - poisson), rel=1e-3)


@pytest.mark.parametrize("load", [0.5, 1.0])
def test_sticking_rough_contact_has_mindlin_ratio(load: float) -> None:
    heights, pixel = rc.reference_map(128)
    body = steel(0.3)
    contact = rc.solve(
        rc.Surface(heights * 0.2, pixel),
        material=body,
        counter_material=body,
        load=load,
        boundary="periodic",
        calibrated=False,
    )
    assert contact.contact_fraction < 0.15
    index = np.flatnonzero(contact.pressure)
    operator = halfspace.operator(
        contact.boundary, contact.pair.shape, pixel, contact.contact_modulus, 0.3
    )
    area = contact.pixel_area
    both = [area * partial_slip.stiffness(operator, index, unit) for unit in np.eye(2)]
    ratio = np.mean(both) / contact.stiffness()
    assert ratio * tangential_compliance(contact.pair) == pytest.approx(1, rel=0.01)


def test_a_profile_is_as_stiff_along_as_across() -> None:
    x = np.arange(256) - 127.5
    wavy = 1e-7 * np.cos(x[None] / 9) + 4e-8 * np.cos(x[None] / 3.1)
    body = steel(0.3)
    profile = rc.Surface(wavy - (x[None] * 3e-6) ** 2 / 20, pixel=(1.0, 1e-6))
    contact = rc.solve(
        profile,
        material=body,
        counter_material=body,
        load="20 N/mm",
        tolerance=1e-10,
        calibrated=False,
    )
    result = pushed(contact, 0.5, tolerance=1e-10)
    curve = result.superposition
    assert curve.traction_difference < 1e-7
    assert curve.shift[-1] == pytest.approx(result.last.shift, rel=1e-8)
    # Its linear problem is solved to 1e-2; the error of the energy is a square.
    assert result.initial_stiffness == pytest.approx(contact.stiffness(), rel=1e-5)
    assert not result.traction[0].any()


# --- Paths ---


@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_proportional_loading_gives_proportional_traction(poisson: float) -> None:
    """Without slip the traction of a ball is Q/P times the pressure (Mindlin, Deresiewicz 1953)."""
    contact, ratio = sphere(poisson, 64), 0.5 * FRICTION
    stages = [(LOAD * part, ratio * LOAD * part) for part in (0.25, 0.5, 0.75, 1.0)]
    result = pushed(contact, 0.5, force=None, stages=stages)
    expected = np.stack([np.zeros_like(contact.pressure), ratio * contact.pressure])
    assert np.abs(result.traction - expected).max() < 0.03 * expected.max()
    assert result.last.stick_fraction > 0.99
    shift = tangential_compliance(contact.pair) * ratio * contact.approach
    assert result.last.shift == pytest.approx(shift, rel=1e-4)


def test_a_falling_load_releases_traction() -> None:
    contact = sphere(0.0, 64)
    half = 0.5 * FRICTION * LOAD
    result = pushed(contact, 0.5, force=None, stages=[(LOAD, half), (0.6 * LOAD, half)])
    assert result.solution.load == 0.6 * LOAD
    assert result.steps[1].shift > result.steps[0].shift
    assert result.steps[1].energy > 0
    # At last all loads alike: the load fell at once, or before the force grew.
    plain = pushed(contact, 0.5, force=None, stages=[(0.6 * LOAD, half)])
    assert result.last.stick_fraction < plain.last.stick_fraction


# --- Symmetry and limits ---


@pytest.mark.long
def test_turning_and_mirroring_turns_and_mirrors_the_traction() -> None:
    contact = rough(0.3, "free")
    result = pushed(contact, 0.6, tolerance=1e-11)
    size = np.linalg.norm(result.traction)
    arguments = {
        "material": contact.material,
        "counter_material": contact.counter_material,
        "load": contact.load,
        "tolerance": 1e-11,
        "calibrated": False,
        "ceiling": None,
    }
    heights, pixel = contact.surface.heights, contact.pair.pixel

    turned = rc.solve(rc.Surface(np.rot90(heights).copy(), pixel), **arguments)
    other = pushed(turned, 0.6, direction=90.0, tolerance=1e-11)
    # Counter-clockwise as the map is drawn: x turns to smaller y.
    expected = np.rot90(np.stack([-result.traction[1], result.traction[0]]), axes=(1, 2))
    assert np.linalg.norm(other.traction - expected) / size < 1e-6
    assert other.last.shift == pytest.approx(result.last.shift, rel=1e-9)

    mirrored = rc.solve(rc.Surface(heights[::-1].copy(), pixel), **arguments)
    other = pushed(mirrored, 0.6, tolerance=1e-11)
    expected = result.traction[:, ::-1] * np.array([-1.0, 1.0])[:, None, None]
    assert np.linalg.norm(other.traction - expected) / size < 1e-6
    assert other.last.cross_shift == pytest.approx(-result.last.cross_shift, rel=1e-6)


def test_a_reversed_force_reverses_the_traction() -> None:
    contact = rough(0.3, "periodic")
    there, back = pushed(contact, 0.6), pushed(contact, -0.6)
    size = np.linalg.norm(there.traction)
    assert np.linalg.norm(there.traction + back.traction) / size < 1e-6
    assert back.cycle_energy == pytest.approx(there.cycle_energy, rel=1e-6)


def test_force_near_limit_slides_everywhere() -> None:
    contact = rough(0.0, "free")
    result = pushed(contact, 1 - 1e-6)
    assert result.last.stick_fraction < 0.01
    limit = FRICTION * contact.pressure
    assert np.linalg.norm(result.traction[1] - limit) / np.linalg.norm(limit) < 1e-3
    assert result.last.shift == pytest.approx(FRICTION * contact.approach, rel=1e-3)
    # With ν, slip across the force has to be turned into it: the shift grows without end.
    steep = pushed(rough(0.3, "free"), 1 - 1e-6)
    assert steep.last.stick_fraction < 0.01
    assert steep.last.shift > 2 * FRICTION * contact.approach
    with pytest.raises(rc.CapacityError, match="slides at"):
        pushed(contact, 1.0)


@pytest.mark.parametrize("points", [64, 128])
def test_applications_do_not_grow_with_the_grid(points: int) -> None:
    contact = rough(0.3, "free", points, "auto")
    assert pushed(contact, 0.5, tolerance=1e-6).applications < 20
    # A cycle starts from its first traction, reversed.
    most = 0.5 * FRICTION * contact.load
    cycle = pushed(contact, 0.5, force=[most, -most, most], tolerance=1e-6)
    assert cycle.applications < 30


def test_a_shift_gives_the_force_that_needs_it() -> None:
    contact = rough(0.3, "periodic")
    result = pushed(contact, 0.5)
    # A force along x shifts an anisotropic map across it, too: less than a thousandth here.
    again = pushed(contact, 0.5, force=None, shift=result.last.shift)
    assert again.last.force == pytest.approx(result.last.force, rel=1e-3)
    assert again.last.cross_shift == 0
