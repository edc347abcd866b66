"""Messages on slopes and missing points: those near the contact count, others do not."""

import numpy as np
import pytest

import roughcontact as rc
from messages import fault
from roughcontact.cautions import Caution, CautionTag
from roughcontact.contact import plausibility
from roughcontact.errors import ArgumentRef
from roughcontact.surface import nominal_bodies

STEEL = rc.Material(210e9, 0.3)
R, PIXEL = 5e-6, (1e-6 / 25, 1e-6 / 25)


def kinds(result: rc.ContactResult) -> set[str]:
    return {caution.kind for caution in result.cautions}


def press_sphere(shape: tuple[int, int] = (256, 256), load: float = 1e-5) -> rc.ContactResult:
    body = nominal_bodies.sphere(radius=R, shape=shape, pixel=PIXEL)
    return rc.solve(body, material=STEEL, load=load)


def test_rim_of_a_sphere_gives_no_messages() -> None:
    # The map shows all of the sphere: vertical at the rim, nothing in the corners.
    result = press_sphere()
    assert result.pair.rms_slope > 1
    assert result.surface.missing > 0.2 * result.surface.heights.size
    assert not kinds(result) & {CautionTag.SLOPES, CautionTag.UNITS, CautionTag.MISSING}


def test_near_region_of_a_sphere_is_the_overlap() -> None:
    # Hertz: the undeformed sphere overlaps the plane in √2 times the contact radius, δ = a²/R.
    result = press_sphere(load=5e-3)
    overlap = np.sqrt(2 * R * result.approach)
    near = plausibility.points_near_contact(result)
    assert near[result.contact].all()
    radius = np.sqrt(near.sum() * PIXEL[0] * PIXEL[1] / np.pi)
    assert radius == pytest.approx(overlap, rel=0.02)
    # The mean of (r/R)² over that disk is half of its value at the rim.
    expected = overlap / R / np.sqrt(2)
    assert plausibility.rms_slope(result) == pytest.approx(expected, rel=0.06)


def test_steep_contact_is_reported() -> None:
    body = nominal_bodies.cone(0.5, shape=(64, 64), pixel=PIXEL)
    result = rc.solve(body, material=STEEL, load=1e-4)
    (caution,) = (c for c in result.cautions if c.kind == CautionTag.SLOPES)
    assert caution.numbers["rms_slope"] == pytest.approx(0.5, rel=0.1)
    steep = nominal_bodies.cone(5.0, shape=(64, 64), pixel=PIXEL)
    assert CautionTag.UNITS in kinds(rc.solve(steep, material=STEEL, load=1e-4))


def test_missing_points_count_inside_contact_only() -> None:
    body = nominal_bodies.sphere(radius=R, shape=(64, 64), pixel=PIXEL)
    inside, outside = body.heights.copy(), body.heights.copy()
    inside[32, 31:33] = np.nan
    outside[2:10, 2:60] = np.nan
    one, other = (
        rc.solve(rc.Surface(heights, PIXEL).masked(), material=STEEL, load=1e-4)
        for heights in (inside, outside)
    )
    assert plausibility.missing_points(other) == (0, 0.0)
    assert CautionTag.MISSING not in kinds(other)
    (caution,) = (c for c in one.cautions if c.kind == CautionTag.MISSING)
    near = plausibility.points_near_contact(one).sum()
    assert caution.numbers["missing"] == 2
    assert caution.numbers["share"] == pytest.approx(2 / (2 + near))


def test_map_units_are_checked_by_half_of_slopes() -> None:
    heights = np.random.default_rng(3).normal(size=(64, 64))
    surface = rc.Surface(1e-8 * heights, (1e-6, 1e-6))
    assert not plausibility.map_cautions(surface)
    (caution,) = plausibility.map_cautions(rc.Surface(1e-5 * heights, (1e-6, 1e-6)))
    assert caution.kind == CautionTag.UNITS
    # A few deep pits, as steep as they are, are no wrong unit.
    pits = 1e-8 * heights
    pits[::8, ::8] = -1e-4
    surface = rc.Surface(pits, (1e-6, 1e-6))
    assert surface.Sdq > plausibility.IMPLAUSIBLE_SLOPE
    assert not plausibility.map_cautions(surface)


def bent(points: tuple[int, int] = (64, 80)) -> rc.Surface:
    """Return half a wave along x: the highest edge meets the lowest where the map repeats."""
    nx = points[1]
    rough = 0.02 * np.random.default_rng(3).normal(size=points)
    return rc.Surface(1e-7 * (np.cos(np.pi * (np.arange(nx) + 0.5) / nx) + rough), PIXEL)


def periodic_edge(result: rc.ContactResult) -> Caution:
    (caution,) = (c for c in result.cautions if c.kind == CautionTag.PERIODIC_EDGE)
    return caution


@pytest.mark.parametrize("boundary", ["periodic", "periodic-x"])
def test_edges_of_a_periodic_map_that_differ_are_reported(boundary: str) -> None:
    surface = bent()
    result = rc.solve(surface, material=STEEL, load=1e-4, boundary=boundary)
    caution = periodic_edge(result)
    # The edges are 2 amplitudes apart, Sq is 1/√2 of one.
    assert caution.numbers["step_over_sq"] == pytest.approx(2 * np.sqrt(2), rel=0.02)
    near = 1 - result.pressure[:, 4:-4].sum() / result.pressure.sum()
    assert caution.numbers["edge_load"] == pytest.approx(near)
    assert caution.numbers["even_load"] == pytest.approx(0.1)
    assert near > 0.5
    assert caution.severity == "warning"
    assert ArgumentRef("level", "quadric") in caution.parts
    assert fault(caution) == ""
    along = rc.solve(surface, material=STEEL, load=1e-4, boundary="periodic-y")
    assert CautionTag.PERIODIC_EDGE not in kinds(along)
    # Without a form the advice is another.
    level = rc.solve(surface.leveled("quadric"), material=STEEL, load=1e-4, boundary=boundary)
    assert "larger map" in periodic_edge(level).text


def test_edges_that_differ_under_an_even_load_are_a_note() -> None:
    heights, pixel = rc.reference_map(128)
    cut = rc.Surface(heights[:100, :96], pixel)
    caution = periodic_edge(rc.solve(cut, material=STEEL, load=5e3, boundary="periodic"))
    assert caution.numbers["edge_load"] < 2 * caution.numbers["even_load"]
    assert caution.severity == "note"


def test_periodic_map_has_no_step() -> None:
    sphere = nominal_bodies.sphere(radius=1e-3, shape=(64, 64), pixel=PIXEL)
    noise = rc.Surface(1e-9 * np.random.default_rng(3).normal(size=(64, 64)), PIXEL)
    for surface in (rc.Surface(*rc.reference_map(64)), sphere, noise):
        result = rc.solve(surface, material=STEEL, load=1e-4, boundary="periodic")
        assert plausibility.find_periodic_step(result) is None


def test_one_point_is_near_the_edge_of_a_small_map() -> None:
    small = bent((16, 12))
    result = rc.solve(small, material=STEEL, load=1e-5, boundary="periodic-x")
    found = plausibility.find_periodic_step(result)
    assert found is not None
    assert found.width == 1 / 12
    assert found.area == pytest.approx(2 / 12)
    assert "within 8.33 % of edges" in periodic_edge(result).text


def test_edges_of_a_periodic_profile_are_compared() -> None:
    profile = rc.Surface(bent((4, 200)).heights[0], PIXEL[1])
    result = rc.solve(profile, material=STEEL, load="1 N/mm", boundary="periodic")
    found = plausibility.find_periodic_step(result)
    assert found is not None
    assert found.load > 0.3
    assert found.area == pytest.approx(0.1)


def test_profile_has_a_slope_near_its_contact() -> None:
    x = np.arange(-50, 50) * 1e-6
    result = rc.solve(rc.Surface(-(x**2) / 2e-3, 1e-6), material=STEEL, load="10 N/mm")
    slope = plausibility.rms_slope(result)
    assert 0 < slope < result.pair.rms_slope
