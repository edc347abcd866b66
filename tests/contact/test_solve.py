"""`solve`: surfaces, materials and a load in, a certified result out."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import broken
import roughcontact as rc
from maps import anisotropic_surface
from roughcontact.cautions import CautionTag
from roughcontact.halfspace import convolution

STEEL = rc.Material(young=210e9, poisson=0.3)
YIELDING = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
BOUNDARIES = ["free", "periodic"]
LOAD = 1.0  # [N] on R(N): a mean pressure of 0.1 GPa


def kinds(result: rc.ContactResult) -> set[str]:
    return {caution.kind for caution in result.cautions}


def reference(n, seed=0):
    heights, pixel = rc.reference_map(n, seed)
    return rc.Surface(heights, pixel)


def area(surface):
    return surface.shape[0] * surface.shape[1] * surface.pixel[0] * surface.pixel[1]


def difference(found, expected):
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


# --- the reference problem -------------------------------------------------------------------

CEILINGS = [None, 10e9, 3e9, 1e9, 0.1e9 / 0.5, 0.1e9 / 0.9, 0.1e9 / 0.99]
SIZES = [
    128,
    pytest.param(256, marks=pytest.mark.long),
    pytest.param(512, marks=pytest.mark.slow),
    pytest.param(1024, marks=pytest.mark.slow),
]


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", CEILINGS)
@pytest.mark.parametrize("n", SIZES)
def test_reference_problem(independent, n, ceiling, boundary):
    result = rc.solve(reference(n), material=STEEL, load=LOAD, ceiling=ceiling, boundary=boundary)
    independent.assert_solved(result, LOAD)
    # Nothing crawls: measured 8 to 40.
    assert result.convolutions <= 60


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize(("strain", "factor"), [(0.03, None), (0.03, 3.0), (0.01, 3.0), (0.1, 1.3)])
@pytest.mark.parametrize("kind", ["white", "self-affine"])
def test_maps_rough_down_to_the_pixel(independent, kind, strain, factor, boundary):
    # Measured maps are noisy from pixel to pixel; R(N) is smooth over eight of them. A tenth to
    # nine tenths in contact is the hard range: free, empty and full pixels alternate.
    n = 160
    if kind == "white":
        heights = np.random.default_rng(1).standard_normal((n, n)) * 1e-7
    else:
        heights = rc.self_affine(
            (n, n),
            (1e-6, 1e-6),
            rms_height=1.0,
            rolloff_wavelength=n * 1e-6 / 4,
            cutoff_wavelength=2e-6,
            hurst=0.3,
            rng=np.random.default_rng(1),
        )
        heights *= 0.1 / rc.Surface(heights, (1e-6, 1e-6)).Sdq
    surface = rc.Surface(heights, (1e-6, 1e-6))
    mean = strain * 231e9
    load = mean * area(surface)
    result = rc.solve(
        surface,
        material=STEEL,
        load=load,
        boundary=boundary,
        ceiling=None if factor is None else factor * mean,
    )
    independent.assert_solved(result, load)
    assert 0.1 < result.contact_fraction < 1


# --- any load, any modulus, any ceiling ------------------------------------------------------


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(
    young=st.floats(3, 13).map(lambda x: 10**x),
    poisson=st.floats(-0.9, 0.5),
    counter=st.floats(3, 13).map(lambda x: 10**x),
    strain=st.floats(-7, 0.5).map(lambda x: 10**x),
    filling=st.sampled_from([0.0, 1e-2, 0.5, 0.9, 0.99, 0.999]),
    boundary=st.sampled_from(BOUNDARIES),
    lengths=st.floats(-6, 6).map(lambda x: 10**x),
    seed=st.integers(0, 1000),
)
def test_any_material_and_unit(
    independent, young, poisson, counter, strain, filling, boundary, lengths, seed
):
    one, two = rc.Material(young, poisson), rc.Material(counter, 0.25)
    surface = anisotropic_surface((23, 31), seed=seed)
    surface = rc.Surface(
        surface.heights * lengths, (surface.pixel[0] * lengths, surface.pixel[1] * lengths)
    )
    modulus = rc.contact_modulus(one, two)
    mean = strain * modulus
    load = mean * area(surface)
    ceiling = mean / filling if filling else None
    result = rc.solve(
        surface, material=one, counter_material=two, load=load, ceiling=ceiling, boundary=boundary
    )
    independent.assert_solved(result, load)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("filling", [0.5, 0.9, 0.99, 0.999, 0.9999, 1.0])
def test_ceilings_up_to_full_capacity(independent, filling, boundary):
    surface = anisotropic_surface()
    load = 0.5
    ceiling = load / area(surface) / filling
    if filling == 1.0:
        capacity = ceiling * surface.heights.size * surface.pixel[0] * surface.pixel[1]
        load = min(load, capacity)
    result = rc.solve(surface, material=STEEL, load=load, ceiling=ceiling, boundary=boundary)
    independent.assert_solved(result, load)
    # By counting: of N pixels at most `filling` can be full, and all but a few rim pixels are.
    assert result.saturated_fraction <= filling
    assert result.saturated_fraction >= filling - 0.1
    if filling == 1.0:
        assert result.saturated.all()
        assert result.regime == "saturated at the surface"


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_a_start_within_the_tolerance_is_settled_on_its_bounds(independent, boundary):
    # The uniform pressure is a solution to 1e-8, but none of its pixels is at the ceiling.
    surface = anisotropic_surface()
    load = 0.5
    ceiling = load / area(surface) / (1 - 1e-8)
    result = rc.solve(surface, material=YIELDING, load=load, ceiling=ceiling, boundary=boundary)
    independent.assert_solved(result, load)
    # By counting, all but one; all that touch 1 % of the map are far more than are free.
    assert result.saturated_fraction > 0.99
    assert result.regime == "saturated at the surface"


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_steep_surface_under_a_very_low_ceiling(independent, boundary):
    # Gap over K₀₀ is 1e4 to 1e6 times the ceiling: the multiplier's root find has far to go.
    surface = anisotropic_surface((74, 12))
    surface = rc.Surface(surface.heights * 100, surface.pixel)
    for filling in (0.5, 0.99, 0.9999, 1 - 1e-6):
        mean = 1e-6 * 231e9
        load = mean * area(surface)
        result = rc.solve(
            surface, material=STEEL, load=load, ceiling=mean / filling, boundary=boundary
        )
        independent.assert_solved(result, load)


# --- symmetries ------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", [None, 2e9, "map"])
@pytest.mark.parametrize("change", ["transposed", "upside down"])
def test_transposed_and_mirrored_maps(change, ceiling, boundary):
    apply = {
        "transposed": lambda a: np.ascontiguousarray(a.T),
        "upside down": lambda a: np.ascontiguousarray(a[::-1]),
    }[change]
    surface = anisotropic_surface()
    there = back = ceiling
    if ceiling == "map":
        there = np.random.default_rng(1).uniform(1e9, 4e9, surface.shape)
        back = apply(there)
    pixel = surface.pixel
    if change == "transposed":
        pixel = pixel[::-1]
    options = {"material": STEEL, "load": 0.5, "boundary": boundary, "tolerance": 1e-9}
    one = rc.solve(surface, ceiling=there, **options)
    two = rc.solve(rc.Surface(apply(surface.heights), pixel), ceiling=back, **options)
    assert difference(two.pressure, apply(one.pressure)) < 1e-6
    assert difference(two.gap, apply(one.gap)) < 1e-6
    assert two.approach == pytest.approx(one.approach, rel=1e-6)


@pytest.mark.parametrize("ceiling", [None, 2e9])
def test_a_periodic_map_may_begin_anywhere(ceiling):
    surface = anisotropic_surface()
    options = {
        "material": STEEL,
        "load": 0.5,
        "boundary": "periodic",
        "tolerance": 1e-9,
        "ceiling": ceiling,
    }
    one = rc.solve(surface, **options)
    rolled = rc.Surface(np.roll(surface.heights, (11, 29), (0, 1)), surface.pixel)
    two = rc.solve(rolled, **options)
    assert difference(two.pressure, np.roll(one.pressure, (11, 29), (0, 1))) < 1e-6


def test_heights_may_start_anywhere():
    surface = anisotropic_surface()
    one = rc.solve(surface, material=STEEL, load=0.5, tolerance=1e-9)
    lifted = rc.Surface(surface.heights + 1e-3, surface.pixel)
    two = rc.solve(lifted, material=STEEL, load=0.5, tolerance=1e-9)
    # 1 mm costs 1e-19 m of each height, 1e-12 of the roughness.
    assert difference(two.pressure, one.pressure) < 1e-6
    assert two.approach == pytest.approx(one.approach, rel=1e-6)


# --- masks, ceilings by pixel, two bodies ----------------------------------------------------


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", [None, 2e9, "map"])
@pytest.mark.parametrize("missing", [0.01, 0.4])
def test_masked_pixels_never_touch(independent, missing, ceiling, boundary):
    surface = anisotropic_surface()
    heights = surface.heights.copy()
    rng = np.random.default_rng(2)
    heights[rng.random(heights.shape) < missing] = np.nan
    heights[10:20, 30:40] = np.nan
    if ceiling == "map":
        ceiling = rng.uniform(1e9, 4e9, heights.shape)
    masked = rc.Surface(heights, surface.pixel).masked()
    result = rc.solve(masked, material=STEEL, load=0.5, ceiling=ceiling, boundary=boundary)
    independent.assert_solved(result, 0.5)
    holes = np.isnan(heights)
    assert (result.pressure[holes] == 0).all()
    assert np.isnan(result.gap[holes]).all()
    assert not np.isnan(result.gap[~holes]).any()
    assert CautionTag.MISSING in kinds(result)
    assert math.isfinite(result.mean_gap)


def test_masking_deep_points_keeps_solution():
    surface = anisotropic_surface()
    options = {"material": STEEL, "load": 0.2, "tolerance": 1e-9}
    whole = rc.solve(surface, **options)
    heights = surface.heights.copy()
    deep = whole.gap > np.quantile(whole.gap, 0.5)
    heights[deep] = np.nan
    masked = rc.solve(rc.Surface(heights, surface.pixel).masked(), **options)
    assert difference(masked.pressure, whole.pressure) < 1e-6
    assert masked.approach == pytest.approx(whole.approach, rel=1e-6)


def test_capacity_counts_touchable_pixels_only():
    surface = anisotropic_surface()
    heights = surface.heights.copy()
    heights[:, :35] = np.nan
    masked = rc.Surface(heights, surface.pixel).masked()
    half = 1e9 * area(surface) / 2
    rc.solve(masked, material=STEEL, load=0.99 * half, ceiling=1e9)
    with pytest.raises(rc.CapacityError, match=f"{half:.4g}"):
        rc.solve(masked, material=STEEL, load=1.01 * half, ceiling=1e9)
    by_pixel = np.full(surface.shape, 1e9)
    with pytest.raises(rc.CapacityError, match="carry"):
        rc.solve(masked, material=STEEL, load=1.01 * half, ceiling=by_pixel)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_ceiling_by_pixel(independent, boundary):
    surface = anisotropic_surface()
    ceiling = np.where(np.arange(surface.shape[1]) < 35, 1e9, 3e9) * np.ones((45, 1))
    ceiling[:5] = np.inf
    result = rc.solve(surface, material=STEEL, load=0.8, ceiling=ceiling, boundary=boundary)
    independent.assert_solved(result, 0.8)
    assert result.saturated[5:, :35].any()
    assert result.pressure[5:, :35].max() == 1e9
    assert result.pressure[5:, 35:].max() > 1e9
    # A map of equal values is the scalar.
    same = np.full(surface.shape, 2e9)
    options = {"material": STEEL, "load": 0.8, "boundary": boundary, "tolerance": 1e-9}
    one, two = (rc.solve(surface, ceiling=c, **options) for c in (2e9, same))
    assert difference(two.pressure, one.pressure) < 1e-6


@pytest.mark.parametrize("ceiling", [None, 2e9])
def test_two_measured_bodies_are_their_sum(independent, ceiling):
    one, two = anisotropic_surface(seed=3), anisotropic_surface(seed=4)
    options = {"load": 0.5, "ceiling": ceiling, "tolerance": 1e-9}
    copper = rc.Material(120e9, 0.34)
    pair = rc.solve(one, counter_surface=two, material=STEEL, counter_material=copper, **options)
    independent.assert_solved(pair, 0.5, tolerance=1e-9)
    combined = rc.Surface(one.heights + two.heights, one.pixel)
    alone = rc.solve(combined, material=copper, counter_material=STEEL, **options)
    np.testing.assert_allclose(pair.initial_gap, alone.initial_gap, atol=1e-20)
    assert difference(pair.pressure, alone.pressure) < 1e-6
    # A body against its own negative touches everywhere at once.
    negative = rc.Surface(-one.heights, one.pixel)
    closed = rc.solve(one, counter_surface=negative, material=STEEL, load=0.5, boundary="periodic")
    assert np.ptp(closed.pressure) < 1e-6 * closed.pressure.max()


def test_holes_of_either_body_never_touch():
    one, two = (
        anisotropic_surface(seed=3).heights.copy(),
        anisotropic_surface(seed=4).heights.copy(),
    )
    # Next to the highest points, where the bodies would touch.
    first, second = np.argsort(one + two, axis=None)[[-3, -4]]
    one.flat[first] = two.flat[second] = np.nan
    pixel = anisotropic_surface().pixel
    result = rc.solve(
        rc.Surface(one, pixel).masked(),
        counter_surface=rc.Surface(two, pixel).masked(),
        material=STEEL,
        load=0.5,
    )
    assert np.isnan(result.gap.flat[[first, second]]).all()
    # Both are reported.
    (caution,) = (caution for caution in result.cautions if caution.kind == CautionTag.MISSING)
    assert caution.numbers["missing"] == 2


# --- approach control ------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", [None, 2e9])
def test_approach_control_reproduces_load_control(independent, ceiling, boundary):
    surface = anisotropic_surface()
    options = {"material": STEEL, "ceiling": ceiling, "boundary": boundary, "tolerance": 1e-9}
    one = rc.solve(surface, load=0.5, **options)
    two = rc.solve(surface, approach=one.approach, **options)
    independent.assert_solved(two, tolerance=1e-9)
    assert two.control == "approach"
    assert two.approach == one.approach
    assert two.load_error == 0
    assert difference(two.pressure, one.pressure) < 1e-6
    assert two.load == pytest.approx(0.5, rel=1e-6)


def test_approach_beyond_full_periodic_contact_has_no_load():
    surface = anisotropic_surface()
    full = float(surface.heights.max() - surface.heights.mean())
    with pytest.raises(rc.CapacityError, match=r"approach.*full contact"):
        rc.solve(surface, material=STEEL, approach=1.1 * full, boundary="periodic")
    # With a ceiling there is one: every pixel sinks in.
    result = rc.solve(surface, material=STEEL, approach=3 * full, boundary="periodic", ceiling=1e8)
    assert result.saturated_fraction == 1


@pytest.mark.parametrize("ceiling", [1e3, "map"])
def test_approach_beyond_closing_a_flat_periodic_map_saturates_it(independent, ceiling):
    # Nothing resists a uniform pressure there but the ceiling.
    surface = rc.Surface(np.zeros((13, 29)), (1e-6, 1e-6))
    if ceiling == "map":
        ceiling = np.random.default_rng(0).uniform(1e3, 2e3, surface.shape)
    result = rc.solve(surface, material=STEEL, approach=1e-12, boundary="periodic", ceiling=ceiling)
    independent.assert_solved(result)
    assert result.saturated.all()
    assert result.convolutions < 20


# --- shapes that break solvers ---------------------------------------------------------------


def flat_punch(shape=(40, 50)):
    heights = np.full(shape, -1e-3)
    heights[15:25, 20:35] = 0
    return rc.Surface(heights, (1e-6, 2e-6))


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", [None, 1.05, 1.5, 3.0])
def test_flat_punch(independent, ceiling, boundary):
    surface = flat_punch()
    load = 0.1
    mean = load / (150 * 2e-12)
    result = rc.solve(
        surface,
        material=STEEL,
        load=load,
        boundary=boundary,
        ceiling=None if ceiling is None else ceiling * mean,
    )
    independent.assert_solved(result, load)
    np.testing.assert_array_equal(result.contact, surface.heights == 0)
    # Symmetric, and highest at the corners.
    np.testing.assert_allclose(
        result.pressure[15:25, 20:35], result.pressure[24:14:-1, 34:19:-1], rtol=1e-3
    )
    # 1e-6: the four corners are equal but for rounding and the certificate.
    assert result.pressure[15, 20] == pytest.approx(result.max_pressure, rel=1e-5)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("filling", [None, 0.5, 0.9, 0.99])
def test_flat_everywhere(independent, filling, boundary):
    surface = rc.Surface(np.zeros((30, 41)), (1e-6, 2e-6))
    mean = 1.0 / area(surface)
    result = rc.solve(
        surface,
        material=STEEL,
        load=1.0,
        boundary=boundary,
        ceiling=None if filling is None else mean / filling,
    )
    independent.assert_solved(result, 1.0)
    assert result.contact_fraction == 1
    if boundary == "periodic":
        np.testing.assert_allclose(result.pressure, mean, rtol=1e-6)
        # Zero, but for 1e-6 of what one pixel displaces itself.
        assert abs(result.approach) <= 1e-6 * mean / 231e9 * 2e-6
    else:
        assert CautionTag.EDGE in kinds(result)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_single_spike(independent, boundary):
    heights = np.zeros((37, 52))
    heights[11, 40] = 1e-3
    surface = rc.Surface(heights, (1e-6, 1e-6))
    result = rc.solve(surface, material=STEEL, load=0.01, boundary=boundary)
    independent.assert_solved(result, 0.01)
    np.testing.assert_array_equal(np.flatnonzero(result.pressure), [11 * 52 + 40])
    assert result.max_pressure == pytest.approx(0.01 / 1e-12, rel=1e-10)
    with pytest.raises(rc.CapacityError):
        # One pixel cannot carry it, the flat below it could, but not at this ceiling.
        rc.solve(surface, material=STEEL, load=0.01, ceiling=1e6, boundary=boundary)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("shape", [(2, 2), (2, 3), (32, 300), (256, 5)])
@pytest.mark.parametrize("kind", ["noise", "checkerboard", "steps", "spikes"])
def test_awkward_shapes(independent, kind, shape, boundary):
    rng = np.random.default_rng(5)
    heights = {
        "noise": rng.standard_normal(shape),
        "checkerboard": (np.indices(shape).sum(0) % 2).astype(float),
        "steps": np.broadcast_to(np.arange(shape[1]) * 3 // shape[1], shape).astype(float),
        "spikes": np.where(rng.random(shape) < 0.03, 30.0, rng.random(shape)),
    }[kind] * 0.1e-6
    surface = rc.Surface(heights, (1e-6, 1.5e-6))
    mean = 0.01 * 231e9
    load = mean * area(surface)
    for ceiling in (None, mean / 0.9, mean / 0.999):
        result = rc.solve(surface, material=STEEL, load=load, ceiling=ceiling, boundary=boundary)
        independent.assert_solved(result, load)


def test_full_periodic_contact(independent):
    surface = anisotropic_surface()
    result = rc.solve(surface, material=STEEL, load=1e3, boundary="periodic")
    independent.assert_solved(result, 1e3)
    assert result.contact_fraction == 1
    # Flat: the displacement is the roughness itself, so the approach is the mean gap.
    assert result.approach == pytest.approx(float(result.initial_gap.mean()), rel=1e-6)
    assert result.mean_gap < 1e-6 * result.initial_gap.mean()


# --- start, precision, failure ---------------------------------------------------------------


def test_guess_from_higher_load_saves_convolutions() -> None:
    surface = rc.Surface(*rc.reference_map(256, 1))
    options = {"material": STEEL, "ceiling": 3e9}
    for load in (0.2, 1.0):
        high = rc.solve(surface, load=1.03 * load, **options)
        cold = rc.solve(surface, load=load, **options)
        warm = rc.solve(surface, load=load, initial_guess=high, **options)
        assert warm.convolutions < cold.convolutions
        assert warm.approach == pytest.approx(cold.approach, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("ceiling", [None, 2e9])
def test_start_from_a_neighbouring_load(independent, ceiling):
    surface = anisotropic_surface((90, 140))
    options = {"material": STEEL, "ceiling": ceiling, "tolerance": 1e-9}
    cold = rc.solve(surface, load=0.55, **options)
    for load in (0.5, 0.1, 0.0001, 2.0):
        near = rc.solve(surface, load=load, **options)
        warm = rc.solve(surface, load=0.55, initial_guess=near, **options)
        independent.assert_solved(warm, 0.55, tolerance=1e-9)
        assert difference(warm.pressure, cold.pressure) < 1e-6
    again = rc.solve(surface, load=0.55, initial_guess=cold, **options)
    assert again.convolutions <= 2
    # From another ceiling, and under approach control.
    other = rc.solve(surface, load=0.55, material=STEEL, ceiling=5e9)
    warm = rc.solve(surface, load=0.55, initial_guess=other, **options)
    assert difference(warm.pressure, cold.pressure) < 1e-6
    warm = rc.solve(surface, approach=cold.approach, initial_guess=other, **options)
    assert difference(warm.pressure, cold.pressure) < 1e-6


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("ceiling", [None, 3e9, 0.1e9 / 0.9])
def test_single_precision_reaches_its_tolerance(independent, ceiling, boundary):
    options = {"material": STEEL, "load": LOAD, "ceiling": ceiling, "boundary": boundary}
    surface = reference(128)
    single = rc.solve(surface, precision="single", **options)
    assert single.tolerance == 1e-4
    found = independent.judge(single)
    # The certificate in double precision of what was found in single: honest within rounding.
    assert found.certificate <= 1.5e-4
    assert found.bounded
    assert abs(found.load - LOAD) <= 1e-10 * LOAD
    double = rc.solve(surface, **options)
    assert difference(single.pressure, double.pressure) < 1e-2
    # Really single: it is not the same answer.
    assert (single.pressure != double.pressure).any()


def test_single_precision_does_not_converge_to_1e_10():
    result = rc.solve(
        reference(128),
        material=STEEL,
        load=LOAD,
        precision="single",
        tolerance=1e-10,
        on_failure="return",
    )
    assert not result.converged
    assert "single precision" in result.status
    # Found and reported, not looped on.
    assert result.convolutions < 200


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("mean", [1e2, 1e4, 1e6])
def test_single_precision_includes_rounding(independent, mean, boundary):
    # A steep ball under a low ceiling: the last digit of the gap is worth more than the pressure.
    y, x = np.mgrid[-63:63, -4:4] + 0.5
    surface = rc.Surface(-(x**2 + y**2) * 1e-8, (1e-6, 1e-6))
    result = rc.solve(
        surface,
        material=STEEL,
        load=mean * area(surface),
        ceiling=mean / 0.25,
        boundary=boundary,
        precision="single",
        on_failure="return",
    )
    found = independent.judge(result)
    # By up to 13 % off here. What it says may be ten times too pessimistic, never the reverse.
    assert found.certificate <= 2 * result.certificate
    assert result.converged == (result.certificate <= 1e-4)
    assert not result.converged
    assert "single precision" in result.status
    assert result.convolutions < 100
    assert rc.solve(
        surface, material=STEEL, load=mean * area(surface), ceiling=mean / 0.25, boundary=boundary
    ).converged


@pytest.mark.parametrize("iterations", [20, 40])
def test_the_gap_is_that_of_the_pressure_wherever_the_solver_stops(independent, iterations):
    # Projected gradients return the best pressure seen, which need not be the last one.
    for seed in range(3, 13):
        rng = np.random.default_rng(seed)
        spikes = np.where(rng.random((12, 8)) < 0.1, 30, 1) * rng.random((12, 8)) * 1e-8
        surface = rc.Surface(spikes, (2e-5, 1e-6))
        result = rc.solve(
            surface,
            material=STEEL,
            load=0.01 * 231e9 * area(surface),
            boundary="periodic",
            max_iterations=iterations,
            on_failure="return",
        )
        found = independent.judge(result)
        assert found.certificate == pytest.approx(result.certificate, rel=1e-6)
        np.testing.assert_allclose(result.gap, found.gap, rtol=0, atol=1e-9 * found.scale)


def test_not_converged_is_an_error_with_the_best_result_attached(independent):
    options = {"material": YIELDING, "load": LOAD, "max_iterations": 2, "tolerance": 1e-12}
    with pytest.raises(rc.ConvergenceError, match="not converged: certificate") as caught:
        rc.solve(reference(128), **options)
    returned = rc.solve(reference(128), on_failure="return", **options)
    for result in (caught.value.result, returned):
        assert not result.converged
        assert "max_iterations" in result.status
        assert result.certificate > 1e-12
        found = independent.judge(result)
        assert found.certificate == pytest.approx(result.certificate, rel=1e-3, abs=1e-9)
        assert found.bounded
        assert found.load == pytest.approx(LOAD, rel=1e-10)
        assert CautionTag.NOT_CONVERGED in kinds(result)
    np.testing.assert_array_equal(caught.value.result.pressure, returned.pressure)


def test_a_wrong_operator_is_not_certified_away(independent, monkeypatch):
    # The judge sees what the program cannot: a kernel that is 1 % too large.
    true = convolution.free

    def wrong(shape, pixel, modulus, **options):
        return true(shape, pixel, modulus / 1.01, **options)

    broken.replace_free(monkeypatch, wrong)
    result = rc.solve(reference(64), material=STEEL, load=LOAD)
    assert result.converged
    assert independent.judge(result).certificate > 1e-3


def test_progress_callback_follows_solve():
    seen = []
    result = rc.solve(reference(128), material=YIELDING, load=LOAD, progress=seen.append)
    first, second = (
        [at.step for at in seen if at.label == label] for label in ("", "calibrated ceiling")
    )
    assert {step.shape for step in first} >= {(64, 64), (128, 128)}
    assert first[-1].certificate == result.certificate
    assert first[-1].convolutions == result.convolutions
    # Pixels are put on their bounds after the last step.
    assert second[-1].certificate <= second[-1].tolerance
    assert second[-1].convolutions <= result.calibrated.convolutions


def test_inputs_are_not_changed():
    heights = anisotropic_surface().heights.copy()
    ceiling = np.full(heights.shape, 2e9)
    surface = rc.Surface(heights, anisotropic_surface().pixel)
    kept = heights.copy()
    result = rc.solve(surface, material=STEEL, load=0.5, ceiling=ceiling)
    np.testing.assert_array_equal(heights, kept)
    np.testing.assert_array_equal(surface.heights, kept)
    assert (ceiling == 2e9).all()
    for field in (result.pressure, result.gap, result.ceiling):
        with pytest.raises(ValueError, match="read-only"):
            field[0, 0] = 1


# --- what a result says ----------------------------------------------------------------------


def test_regimes():
    # A smooth ball, ν = 0.3: first yield at a peak pressure of 1.615 σ_Y, ceiling at 3 σ_Y.
    y, x = np.mgrid[-32:32, -32:32] * 1e-6
    ball = rc.Surface(-(x**2 + y**2) / 2 / 1e-3, (1e-6, 1e-6))

    def solve_ball(load, **options):
        return rc.solve(ball, load=load, **{"material": YIELDING, **options})

    # W = π³R²p³/(6E*²): p = 1.615 GPa at 0.41 N, 3 GPa at 2.6 N.
    assert solve_ball(0.3).regime == "below first yield"
    assert solve_ball(0.3).max_pressure < 1.615e9
    assert solve_ball(1.0).regime == "yielding below the surface"
    assert solve_ball(4.0).regime == "saturated at the surface"
    assert solve_ball(4.0).saturated_fraction > 0
    assert solve_ball(4.0, ceiling=None).regime.startswith("elastic pressure beyond three")
    assert CautionTag.ABOVE_CEILING in kinds(solve_ball(4.0, ceiling=None))
    assert solve_ball(0.3, material=STEEL).regime.startswith("unknown")
    # Of a ceramic, which has no yield strength, the hardness is the ceiling.
    ceramic = rc.Material(210e9, 0.3, hardness=3e9)
    assert solve_ball(1.0, material=ceramic).regime.startswith("unknown")
    assert solve_ball(4.0, material=ceramic).regime == "saturated at the surface"
    beyond = solve_ball(4.0, material=ceramic, ceiling=None)
    assert beyond.regime == "elastic pressure beyond the hardness"
    assert CautionTag.ABOVE_CEILING in kinds(beyond)
    # The softer of the two yields.
    soft = rc.Material(210e9, 0.3, yield_strength=0.4e9)
    result = solve_ball(0.3, counter_material=soft)
    assert result.ceiling == pytest.approx(1.2e9)


def test_automatic_ceiling():
    surface = anisotropic_surface()
    assert rc.solve(surface, material=STEEL, load=0.1).ceiling is None
    assert rc.solve(surface, material=YIELDING, load=0.1).ceiling == 3e9
    assert rc.solve(surface, material=YIELDING, load=0.1, ceiling=None).ceiling is None
    harder = rc.Material(600e9, 0.22, yield_strength=4e9)
    result = rc.solve(surface, material=harder, counter_material=YIELDING, load=0.1)
    assert result.ceiling == 3e9
    ceramic = rc.Material(400e9, 0.23, hardness=15e9)
    assert rc.solve(surface, material=ceramic, load=0.1).ceiling == 15e9
    result = rc.solve(surface, material=ceramic, counter_material=YIELDING, load=0.1)
    assert result.ceiling == 3e9


def test_numbers_of_a_result(independent):
    surface = anisotropic_surface()
    result = rc.solve(surface, material=YIELDING, load=0.8)
    found = independent.assert_solved(result, 0.8)
    pixel_area = surface.pixel[0] * surface.pixel[1]
    touching = np.count_nonzero(result.pressure)
    assert result.contact_area == pytest.approx(touching * pixel_area)
    assert result.contact_fraction == pytest.approx(touching / surface.heights.size)
    full = result.pressure == 3e9
    assert full.any()
    assert result.saturated_fraction == pytest.approx(full.mean())
    assert result.max_pressure == 3e9
    np.testing.assert_array_equal(result.saturated, full)
    np.testing.assert_allclose(
        result.residual_indentation, np.where(full, np.maximum(-found.gap, 0), 0), atol=1e-15
    )
    assert result.residual_indentation.max() > 0
    assert result.mean_gap == pytest.approx(np.maximum(found.gap, 0).mean(), rel=1e-6)
    assert result.contact_modulus == pytest.approx(210e9 / 0.91)
    summary = result.summary()
    assert summary["status"] == "converged"
    assert summary["load"] == 0.8
    assert summary["shape"] == [45, 70]


# --- bad input: what, got, do ----------------------------------------------------------------

BAD_SOLVE = [
    ({"load": 0.0}, "load.*0.0"),
    ({"load": -2.5}, "load.*-2.5"),
    ({"load": math.nan}, "load.*nan"),
    ({"load": math.inf}, "load.*inf"),
    ({"load": "1 m"}, "load.*1 m"),
    ({"load": None}, "load or approach"),
    ({"load": 1.0, "approach": 1e-9}, "load or approach"),
    ({"load": None, "approach": -1e-9}, "approach.*-1e-09"),
    ({"load": None, "approach": 0.0}, "approach.*0.0"),
    ({"load": None, "approach": math.nan}, "approach.*nan"),
    ({"ceiling": 0.0}, "ceiling.*0.0"),
    ({"ceiling": -1e9}, "ceiling.*-1000000000.0"),
    ({"ceiling": math.nan}, "ceiling.*nan"),
    ({"ceiling": "hard"}, "ceiling.*hard"),
    ({"ceiling": np.ones((3, 3))}, r"ceiling.*\(3, 3\)"),
    ({"ceiling": np.zeros((45, 70))}, "ceiling.*0.0"),
    ({"ceiling": np.full((45, 70), np.nan)}, "ceiling.*nan"),
    ({"boundary": "open"}, "boundary.*'free' or 'periodic'.*open"),
    ({"precision": "half"}, "precision.*half"),
    ({"on_failure": "ignore"}, "on_failure.*ignore"),
    ({"tolerance": 0.0}, "tolerance.*0.0"),
    ({"tolerance": -1.0}, "tolerance.*-1.0"),
    ({"tolerance": math.nan}, "tolerance.*nan"),
    ({"max_iterations": 0}, "max_iterations.*0"),
    ({"max_iterations": 2.5}, "max_iterations.*2.5"),
    ({"max_iterations": math.nan}, "max_iterations.*nan"),
    ({"max_iterations": math.inf}, "max_iterations.*inf"),
    ({"material": rc.RIGID}, "rigid"),
    (
        {"counter_surface": rc.Surface(np.zeros((4, 4)), (1e-6, 1e-6))},
        "counter_surface has 4 × 4 points",
    ),
    (
        {"counter_surface": rc.Surface(np.zeros((45, 70)), (1e-6, 1e-6))},
        "counter_surface has 45 × 70 points of 1 µm",
    ),
]


@pytest.mark.parametrize(("options", "words"), BAD_SOLVE)
def test_bad_arguments_of_solve(options, words):
    with pytest.raises(rc.InputError, match=words) as caught:
        rc.solve(anisotropic_surface(), **{"material": STEEL, "load": 0.5, **options})
    assert isinstance(caught.value, ValueError)


def test_start_must_fit():
    other = rc.solve(anisotropic_surface((20, 30)), material=STEEL, load=0.1)
    with pytest.raises(rc.InputError, match=r"initial_guess.*\(20, 30\).*\(45, 70\)"):
        rc.solve(anisotropic_surface(), material=STEEL, load=0.5, initial_guess=other)


def test_holes_have_to_be_handled():
    heights = anisotropic_surface().heights.copy()
    heights[3, 4:7] = np.nan
    surface = rc.Surface(heights, anisotropic_surface().pixel)
    with pytest.raises(rc.InputError, match=r"surface has 3 missing.*filled.*cropped.*masked"):
        rc.solve(surface, material=STEEL, load=0.5)
    with pytest.raises(rc.InputError, match=r"counter_surface has 3 missing"):
        rc.solve(anisotropic_surface(), counter_surface=surface, material=STEEL, load=0.5)
    for handled in (surface.filled(), surface.masked(), surface.cropped((10, 40), (0, 70))):
        assert rc.solve(handled, material=STEEL, load=0.1).converged


def test_bodies_without_common_points_raise_error():
    one, two = np.zeros((4, 6)), np.zeros((4, 6))
    one[:, :3] = np.nan
    two[:, 3:] = np.nan
    pair = [rc.Surface(z, (1e-6, 1e-6)).masked() for z in (one, two)]
    for ceiling in (None, 1e9):
        with pytest.raises(rc.CapacityError):
            rc.solve(pair[0], counter_surface=pair[1], material=STEEL, load=1e-3, ceiling=ceiling)


def test_two_rigid_bodies():
    with pytest.raises(rc.InputError, match="rigid"):
        rc.solve(anisotropic_surface(), material=rc.RIGID, counter_material=rc.RIGID, load=0.5)
    # One rigid body is fine, whichever it is.
    options = {"load": 0.5, "tolerance": 1e-9}
    one = rc.solve(anisotropic_surface(), material=STEEL, counter_material=rc.RIGID, **options)
    two = rc.solve(anisotropic_surface(), material=rc.RIGID, counter_material=STEEL, **options)
    np.testing.assert_array_equal(one.pressure, two.pressure)


def test_capacity_error_states_load_and_capacity():
    surface = anisotropic_surface()
    capacity = 1e8 * area(surface)
    with pytest.raises(rc.CapacityError, match=f"load = 0.5 N.*{capacity:.6g} N"):
        rc.solve(surface, material=STEEL, load=0.5, ceiling=1e8)
