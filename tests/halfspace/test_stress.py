"""The streamed stress against sums over all pairs of pixels, and its own parts."""

import math
import tracemalloc

import numpy as np
import pytest
from scipy.signal import convolve

from pixel_stress import pixel_stress
from roughcontact.errors import InputError
from roughcontact.halfspace import fft, stress, stress_kernels, stress_summary, tensors

PIXEL = (0.8, 1.3)
PARITIES = [(0, 0), (0, 0), (0, 0), (1, 0), (0, 1), (1, 1)]
FRICTIONS = [(0.0, 0.0), (0.3, 0.0), (0.4, math.pi / 2), (0.2, 2.0)]


def all_offsets(quadrant, odd):
    lower = -quadrant[:0:-1] if odd[0] else quadrant[:0:-1]
    half = np.concatenate([lower, quadrant])
    left = -half[:, :0:-1] if odd[1] else half[:, :0:-1]
    return np.concatenate([left, half], axis=1)


def direct(pressure, pixel, depth, poisson, friction=0.0, direction=0.0):
    """Sum over all pairs of pixels; no transform."""
    ny, nx = pressure.shape
    pulls = {"x": friction * math.cos(direction), "y": friction * math.sin(direction)}
    normal = pixel_stress(pressure.shape, pixel, depth, poisson)
    tables = [all_offsets(normal[n], odd) for n, odd in enumerate(PARITIES)]
    for axis, share in pulls.items():
        pulled = pixel_stress(pressure.shape, pixel, depth, poisson, axis)
        for n, (y, x) in enumerate(PARITIES):
            odd = (y ^ (axis == "y"), x ^ (axis == "x"))
            tables[n] = tables[n] + share * all_offsets(pulled[n], odd)
    return np.array(
        [
            convolve(pressure, k, method="direct")[ny - 1 : 2 * ny - 1, nx - 1 : 2 * nx - 1]
            for k in tables
        ]
    )


def waves(pressure, pixel, depth, poisson, friction=0.0, direction=0.0):
    """Stress of a periodic map from the full complex transform."""
    (ny, nx), (dy, dx) = pressure.shape, pixel
    ky, kx = np.fft.fftfreq(ny, dy) * 2 * np.pi, np.fft.fftfreq(nx, dx) * 2 * np.pi
    pulls = [("x", friction * math.cos(direction)), ("y", friction * math.sin(direction))]
    parts = np.array(stress_kernels.waves(ky[:, None], kx, depth, poisson, pulls))
    found = np.zeros((6, ny, nx))
    for load, flip in enumerate([(0, 0), (0, 1), (1, 0)]):
        for n, (y, x) in enumerate(PARITIES):
            odd = (y ^ flip[0], x ^ flip[1])
            symbol = (-1j) ** sum(odd) * parts[6 * load + n]
            # The lone wave of two points a period carries no sine.
            if odd[0] and ny % 2 == 0:
                symbol[ny // 2] = 0
            if odd[1] and nx % 2 == 0:
                symbol[:, nx // 2] = 0
            found[n] += np.fft.ifft2(symbol * np.fft.fft2(pressure)).real
    return found


def one(pressure, depth, **options):
    return next(stress.slices(pressure, PIXEL, [depth], 0.3, **options)).stress


def hertz(points, radius, center=None):
    """Hertz pressure of peak 1; radius and centre in pixels."""
    cy, cx = center or ((points - 1) / 2, (points - 1) / 2)
    y, x = np.mgrid[:points, :points]
    return np.sqrt(np.maximum(1 - ((y - cy) ** 2 + (x - cx) ** 2) / radius**2, 0))


@pytest.mark.parametrize(("friction", "direction"), FRICTIONS)
@pytest.mark.parametrize("depth", [0.0, 0.4, 5.0, 60.0])
def test_free_slices_are_sums_over_pixels(backend, depth, friction, direction):
    pressure = np.random.default_rng(0).random((11, 17))
    expected = direct(pressure, PIXEL, depth, 0.3, friction, direction)
    options = {"friction": friction, "direction": direction}
    found = one(pressure, depth, precision="double", **options)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)
    found = one(pressure, depth, **options)
    assert found.dtype == np.float32
    # The promise of the docstring.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize(("friction", "direction"), FRICTIONS)
@pytest.mark.parametrize("shape", [(8, 10), (7, 9), (1, 6)])
@pytest.mark.parametrize("depth", [0.0, 0.7, 30.0])
def test_periodic_slices_are_sums_of_waves(backend, shape, depth, friction, direction):
    pressure = np.random.default_rng(1).random(shape)
    expected = waves(pressure, PIXEL, depth, 0.3, friction, direction)
    options = {"boundary": "periodic", "friction": friction, "direction": direction}
    found = one(pressure, depth, precision="double", **options)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(one(pressure, depth, **options), expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(("boundary", "exact"), [("free", direct), ("periodic", waves)])
@pytest.mark.parametrize("depth", [0.0, 0.7, 60.0])
def test_a_traction_map_adds_its_stress(backend, depth, boundary, exact, precision):
    rng = np.random.default_rng(4)
    pressure, along_y, along_x = rng.random((3, 11, 17)) - [[[0.0]], [[0.5]], [[0.3]]]
    expected = exact(pressure, PIXEL, depth, 0.3)
    for load, angle in ((along_x, 0.0), (along_y, math.pi / 2)):
        pulled = exact(load, PIXEL, depth, 0.3, 1.0, angle)
        expected = expected + pulled - exact(load, PIXEL, depth, 0.3)
    found = one(
        pressure, depth, boundary=boundary, traction=[along_y, along_x], precision=precision
    )
    np.testing.assert_allclose(found, expected, atol=2e-14 if precision == "double" else 2e-6)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_a_traction_map_of_full_sliding_is_friction(boundary):
    pressure, angle = hertz(48, 14), 0.7
    friction = {"friction": 0.4, "direction": angle}
    towards = np.array([math.sin(angle), math.cos(angle)])[:, None, None]
    maps = {"traction": 0.4 * pressure * towards}
    found, expected = (
        stress_summary.summarize(pressure, PIXEL, 0.3, boundary=boundary, **load)
        for load in (maps, friction)
    )
    np.testing.assert_allclose(found.von_mises, expected.von_mises, rtol=1e-5)
    assert found.max_tension == pytest.approx(expected.max_tension, rel=1e-5)
    assert found.tension_pixel == expected.tension_pixel


@pytest.mark.parametrize(
    ("traction", "friction"),
    [(np.ones((2, 3, 4)), 0.0), (np.full((2, 4, 4), np.nan), 0.0), (np.ones((2, 4, 4)), 0.1)],
)
def test_invalid_traction_map_raises_input_error(traction, friction):
    with pytest.raises(InputError) as refused:
        one(np.ones((4, 4)), 1.0, traction=traction, friction=friction)
    assert refused.value.argument == "traction"


@pytest.mark.parametrize(("friction", "direction"), FRICTIONS)
def test_friction_in_a_skew_direction_transforms_no_more_than_along_an_axis(
    monkeypatch, friction, direction
):
    lines = []
    transform = fft.half_line_transform

    def record_lines(columns, odd):
        lines.append(columns.shape)
        transform(columns, odd)

    monkeypatch.setattr(fft, "half_line_transform", record_lines)
    for _ in stress.slices(
        np.ones((6, 8)), PIXEL, [0.0, 3.0], 0.3, friction=friction, direction=direction, workers=1
    ):
        pass
    # Two depths, two axes.
    assert len(lines) == 4 * (12 if friction else 6)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("load", ["full", "corner", "sparse"])
def test_few_samples_are_enough_at_depth(boundary, load):
    # 160 × 200 pixels: deep kernels are sampled at every second and fourth pixel. Full load is
    # the worst case, where kernels count up to where they meet their images.
    rng = np.random.default_rng(2)
    pressure = rng.random((160, 200))
    if load == "corner":
        pressure *= np.hypot(*np.mgrid[:160, :200]) < 12
    elif load == "sparse":
        pressure *= rng.random(pressure.shape) < 0.03
    options = {"boundary": boundary, "friction": 0.4, "direction": 0.6}
    for depth in (12.0, 14.0, 27.0, 40.0, 120.0, 500.0):
        if boundary == "free" and depth > 13:
            assert max(stress.steps(pressure.shape, PIXEL, depth)) > 1
        exact = one(pressure, depth, precision="double", **options)
        found = one(pressure, depth, **options)
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-6)


def test_samples_are_dense_enough_in_both_directions():
    # A pixel that is long on the scale of the depth must not become a point.
    assert stress.steps((1000, 1000), (1.0, 10.0), 30.0) == (1, 1)
    # Nor may a narrow map be sampled where its kernels have no room to meet their images.
    assert stress.steps((1000, 20), (1.0, 1.0), 30.0) == (1, 1)
    assert stress.steps((1000, 1000), (1.0, 1.0), 9.9) == (1, 1)
    assert stress.steps((1000, 1000), (1.0, 1.0), 10.0) == (2, 2)
    assert stress.steps((1000, 1000), (1.0, 2.0), 40.0) == (8, 4)
    assert stress.steps((1000, 1000), (1.0, 1.0), 1e9) == (16, 16)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_sections_of_a_summary_pass_through_its_largest_stress(boundary):
    # The largest stress moves to other pixels as the depths pass.
    pressure = np.random.default_rng(5).random((40, 30))
    options = {"boundary": boundary, "friction": 0.2}
    found, *planes = stress_summary.summarize_with_sections(pressure, PIXEL, 0.3, **options)
    assert len({tuple(pixel) for pixel in found.pixels}) > 2
    pieces = [
        piece.stress for piece in stress.slices(pressure, PIXEL, found.depths, 0.3, **options)
    ]
    row, column = found.pixel_of_max
    expected = [piece[:, row] for piece in pieces], [piece[:, :, column] for piece in pieces]
    for plane, section in zip(planes, (np.stack(part, axis=1) for part in expected), strict=True):
        np.testing.assert_array_equal(plane, section)


def test_few_tensors_may_reach_a_tresca_stress():
    # Axisymmetric states, whose angle loses half of its digits, among others.
    values = np.random.default_rng(6).standard_normal((6, 3000))
    values[3:, :1000] = 0
    values[1, :1000] = values[0, :1000]
    exact = tensors.tresca(values)
    for share in (0.5, 0.9, 1.0):
        bound = (share * exact.max()) ** 2
        found = tensors.may_reach_tresca(values, bound)
        assert found[exact**2 >= bound].all()
        np.testing.assert_array_equal(found, exact >= share * exact.max() * (1 - 1e-6))


def test_slices_belong_to_the_caller():
    pieces = list(stress.slices(hertz(16, 5), PIXEL, [1.0, 2.0], 0.3))
    assert not np.shares_memory(pieces[0].stress, pieces[1].stress)
    assert not np.array_equal(pieces[0].stress, pieces[1].stress)


def summed_up(pressure, depths, limit, **options):
    """The values of a summary, from whole slices."""
    volume = np.array([one(pressure, depth, **options) for depth in depths])
    mises = tensors.von_mises(volume.swapaxes(0, 1))
    tresca = tensors.tresca(volume.swapaxes(0, 1))
    ranges = [np.ptp(volume[:, 3], axis=1).max(axis=1), np.ptp(volume[:, 4], axis=2).max(axis=1)]
    return {
        "von_mises": mises.max(axis=(1, 2)),
        "tresca": tresca.max(axis=(1, 2)),
        "pixels": [np.unravel_index(layer.argmax(), layer.shape) for layer in mises],
        "orthogonal_shear": 0.5 * np.stack(ranges, axis=1),
        "peak": mises.max(axis=0),
        "yielded_area": (mises > limit).sum(axis=(1, 2)) * PIXEL[0] * PIXEL[1],
    }


@pytest.mark.parametrize("workers", [1, 3])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_summary_matches_whole_slices(monkeypatch, boundary, workers):
    # Several row blocks, whose order must not matter.
    monkeypatch.setattr(fft, "ROW_BYTES", 1 << 13)
    rng = np.random.default_rng(4)
    pressure = 1e9 * rng.random((40, 30)) * (rng.random((40, 30)) < 0.2)
    depths = [0.0, 0.5, 2.0, 30.0]
    options = {"boundary": boundary, "friction": 0.2, "direction": 0.5}
    found = stress_summary.summarize(
        pressure, PIXEL, 0.3, depths=depths[::-1], yield_strength=2e8, workers=workers, **options
    )
    assert found.depths.tolist() == depths
    for name, expected in summed_up(pressure, depths, 2e8, **options).items():
        value = getattr(found, name)
        if name == "pixels":
            np.testing.assert_array_equal(value, expected)
        else:
            # Rounding of single precision, of the largest pressure.
            np.testing.assert_allclose(value, expected, rtol=1e-6, atol=1e-7 * 1e9)
    deepest = int(np.argmax(found.von_mises))
    assert found.max_von_mises == found.von_mises[deepest] == pytest.approx(found.peak.max())
    assert found.depth_of_max == depths[deepest]
    assert found.pixel_of_max == tuple(found.pixels[deepest])
    assert found.max_tresca == found.tresca.max()
    assert found.max_orthogonal_shear == tuple(found.orthogonal_shear.max(axis=0))
    assert found.yield_factor == pytest.approx(2e8 / found.max_von_mises)
    area = found.yielded_area
    volume = 0.25 * (area[0] + area[1]) + 0.75 * (area[1] + area[2]) + 14 * (area[2] + area[3])
    assert found.yielded_volume == pytest.approx(volume)
    assert found.yielded_volume > 0


def test_summary_without_yield_strength():
    found = stress_summary.summarize(hertz(16, 5), PIXEL, 0.3, depths=[1.0])
    assert found.yield_factor is found.yielded_area is found.yielded_volume is None
    flat = stress_summary.summarize(np.zeros((4, 4)), PIXEL, 0.3, depths=[1.0], yield_strength=1.0)
    assert flat.max_von_mises == 0
    assert flat.yield_factor == math.inf
    assert flat.yielded_volume == 0


def test_graded_depths():
    pressure = hertz(128, 40.0)
    depths = stress.graded_depths(pressure, (2.0, 2.0))
    assert depths[0] == 0
    assert depths[1] == pytest.approx(1.0)
    # a = 80; the second moment of a pixelled contact is good to a percent.
    assert depths[-1] == pytest.approx(240, rel=0.01)
    ratios = depths[2:] / depths[1:-1]
    np.testing.assert_allclose(ratios, ratios[0])
    assert ratios[0] <= 2 ** (1 / 3)
    # The longer side counts, wherever the contact is.
    strip = np.zeros((64, 64))
    strip[5:45, 60] = 1
    assert stress.graded_depths(strip, (1.0, 1.0))[-1] == pytest.approx(
        3 * 40 * math.sqrt(5 / 12), 0.01
    )
    np.testing.assert_allclose(
        stress.graded_depths(strip.T, (1.0, 3.0)), stress.graded_depths(strip, (3.0, 1.0))
    )
    single = np.zeros((8, 8))
    single[3, 3] = 1
    assert stress.graded_depths(single, (1.0, 2.0))[-1] == pytest.approx(6)
    everywhere = stress.graded_depths(np.ones((32, 16)), (1.0, 1.0), boundary="periodic")
    assert everywhere[-1] == pytest.approx(32)
    with pytest.raises(InputError, match="zero everywhere"):
        stress.graded_depths(np.zeros((4, 4)), (1.0, 1.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pressure": np.ones(4)}, r"pressure.*\(4,\)"),
        ({"pressure": np.full((2, 2), np.nan)}, "pressure.*NaN"),
        ({"pixel": (1.0, -1.0)}, "pixel"),
        ({"poisson": 0.6}, "poisson.*0.6"),
        ({"depths": [[1.0]]}, "depths"),
        ({"depths": []}, "depths"),
        ({"depths": [-1.0]}, "depths"),
        ({"depths": [math.inf]}, "depths"),
        ({"depths": [math.nan]}, "depths"),
        ({"boundary": "open"}, "boundary.*'open'"),
        ({"precision": "half"}, "precision.*'half'"),
        ({"friction": math.nan}, "friction.*nan"),
        ({"direction": math.inf}, "direction.*inf"),
    ],
)
def test_bad_arguments(change, message):
    good = {"pressure": np.ones((2, 2)), "pixel": (1.0, 1.0), "poisson": 0.3, "depths": [1.0]}
    for call in (stress.slices, stress_summary.summarize):
        with pytest.raises(InputError, match=message):
            # At the call, not with the first slice.
            call(**(good | change))


def test_bad_strength():
    with pytest.raises(InputError, match=r"yield_strength.*-1"):
        stress_summary.summarize(np.ones((2, 2)), PIXEL, 0.3, yield_strength=-1.0)


@pytest.mark.long
def test_memory_does_not_grow_with_the_number_of_depths():
    def peak(count):
        depths = np.geomspace(0.5, 100, count)
        tracemalloc.start()
        stress_summary.summarize(pressure, (1.0, 1.0), 0.3, depths=depths, workers=1)
        _, largest = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return largest

    pressure = hertz(256, 60)
    few, many = peak(8), peak(64)
    assert many < 1.05 * few
    # Six components in single precision.
    assert many < 6 * 4 * pressure.size * 64 / 4


@pytest.mark.parametrize("precision", ["double", "single"])
def test_no_unit_changes_a_bit(precision):
    # Lengths in units of any power of two: below a map of microns as below one of kilometres.
    pressure = np.random.default_rng(0).random((12, 20))
    small, large = (
        [
            one.stress
            for one in stress.slices(
                pressure,
                (0.7 * unit, 1.1 * unit),
                [0, 0.5 * unit, 3 * unit],
                0.3,
                boundary="periodic",
                friction=0.2,
                direction=30.0,
                precision=precision,
            )
        ]
        for unit in (2.0**-20, 2.0**12)
    )
    np.testing.assert_array_equal(small, large)


def test_number_of_waves_falls_with_depth():
    # In metres as in pixels: deep below a map only the longest are left.
    for unit in (1.0, 1e-6):
        loads = stress.UnitLoads((0.7 * unit, 1.1 * unit), 0.3, ())
        terms = loads.wave_terms()
        highest = [
            stress._waves(loads, terms, (64, 96), depth * unit, 16.0).highest
            for depth in (0.0, 0.5, 10.0, 100.0)
        ]
        assert highest == [(32, 48), (32, 48), (12, 27), (2, 3)]
