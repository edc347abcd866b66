"""Coated half-spaces against closed forms, quadrature, thin layers, and an integral equation."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

import roughcontact as rc
from roughcontact.halfspace import coating_stress, convolution, kernels, stress
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.coating import Coatings, layer_excess, tabulate
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.stress import Field
from roughcontact.halfspace.tensors import von_mises
from roughcontact.solvers.active_set import _clip_by_block
from roughcontact.theory import hertz

Array = NDArray[np.float64]

STEEL = rc.Material(210e9, 0.3)
PAIRS = {
    "stiff on steel": (450e9, 0.25, STEEL),
    "polymer on steel": (1e9, 0.4, STEEL),
    "stiff on polymer": (200e9, 0.2, rc.Material(2e9, 0.4)),
    "rubber on rigid": (1e9, 0.5, rc.RIGID),
    "film on rigid": (1e9, 0.3, rc.RIGID),
}


def coated(name: str, thickness: float = 1.0) -> rc.Material:
    young, poisson, base = PAIRS[name]
    return rc.Material(base.young, base.poisson, coating=[rc.Layer(young, poisson, thickness)])


def panels(end: float, number: int, first: float = 1e-4) -> tuple[Array, Array]:
    """Return Gauss nodes and weights from 0 to an end, in panels that grow."""
    ends = np.concatenate([[0.0], np.geomspace(first, end, number)])
    nodes, weights = leggauss(16)
    half = np.diff(ends)[:, None] / 2
    return (ends[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


# --- Waves ---


def burmister(young: float, poisson: float, base: rc.Material, h: Array) -> Array:
    """Return 1 + F of one bonded layer in closed form (Burmister 1945)."""
    shear = young / (1 + poisson) * (1 + base.poisson) / base.young
    first = 1 - 4 * (1 - poisson) / (1 + shear * (3 - 4 * base.poisson))
    second = (shear - 1) / (shear + 3 - 4 * poisson)
    fall = np.exp(-2 * h)
    above = 1 + 4 * h * second * fall - first * second * fall**2
    return above / (1 - (first + second + 4 * second * h**2) * fall + first * second * fall**2)


@pytest.mark.parametrize("name", ["stiff on steel", "polymer on steel", "stiff on polymer"])
def test_one_layer_is_the_closed_form(name: str) -> None:
    h = np.geomspace(1e-3, 30, 100)
    np.testing.assert_allclose(
        1 + layer_excess(coated(name), h), burmister(*PAIRS[name], h), rtol=1e-12
    )


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_layers_on_a_rigid_base_are_the_closed_forms(poisson: float) -> None:
    h, k = np.geomspace(1e-2, 15, 60), 3 - 4 * poisson
    layer = [rc.Layer(1e9, poisson, 1e-6)]
    bonded = (2 * k * np.sinh(2 * h) - 4 * h) / (2 * k * np.cosh(2 * h) + 1 + k**2 + 4 * h**2)
    slides = (np.cosh(2 * h) - 1) / (np.sinh(2 * h) + 2 * h)
    on_rigid = rc.Material(math.inf, 0.0, coating=layer)
    on_film = rc.Material(math.inf, 0.0, coating=layer, base="frictionless")
    np.testing.assert_allclose(1 + layer_excess(on_rigid, h), bonded, rtol=1e-9)
    np.testing.assert_allclose(1 + layer_excess(on_film, h), slides, rtol=1e-9)


def test_divided_layer_matches_whole_layer_and_equal_material_has_no_effect() -> None:
    h = np.geomspace(1e-3, 10, 50)
    whole = rc.Material(210e9, 0.3, coating=[rc.Layer(450e9, 0.25, 3e-6)])
    cut = [rc.Layer(450e9, 0.25, thickness) for thickness in (1e-6, 0.5e-6, 1.5e-6)]
    parts = rc.Material(210e9, 0.3, coating=cut)
    np.testing.assert_allclose(layer_excess(parts, h / 3), layer_excess(whole, h), atol=1e-12)
    same = rc.Material(210e9, 0.3, coating=[rc.Layer(210e9, 0.3, 1e-6)])
    assert np.abs(layer_excess(same, h)).max() < 1e-13


def test_limits_of_long_waves() -> None:
    for name in ("stiff on steel", "polymer on steel"):
        young, poisson, base = PAIRS[name]
        limit = young / (1 - poisson**2) * base.compliance
        assert 1 + layer_excess(coated(name), np.array([1e-7]))[0] == pytest.approx(limit, rel=1e-5)
        # On an elastic base the mean of a period is not displaced.
        pair = Coatings.from_bodies(coated(name), rc.RIGID)
        assert pair is not None
        assert pair.uniform() == 0
    # Confined, and with free sides along the wave.
    layer = [rc.Layer(1.0, 0.3, 1.0)]
    for base, value in (("bonded", 0.742857), ("frictionless", 0.91)):
        pair = Coatings.from_bodies(rc.Material(math.inf, 0.0, coating=layer, base=base), rc.RIGID)
        assert pair is not None
        assert 2 * pair.uniform() * (1 - 0.3**2) == pytest.approx(value, rel=1e-5)


# --- Pixels ---


@pytest.mark.long
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("thickness", [0.1, 1.0, 10.0, 100.0])
def test_coefficients_are_the_integral_over_the_pixel(name: str, thickness: float) -> None:
    body, pixel, shape = coated(name, thickness), (1.0, 1.3), (14, 20)
    pair = Coatings.from_bodies(body, rc.RIGID)
    assert pair is not None
    added = pair.pixels(shape, pixel, 0, pair.tables(40.0))
    scale = (
        math.pi
        * kernels.love((1, 1), pixel, 1.0)[0, 0]
        * max(1, 1 + layer_excess(body, np.array([1e-6]))[0])
    )
    table = tabulate(body, 8)

    def kernel(radius: Array) -> Array:
        at = np.arcsinh(radius / thickness) * 4096
        return np.interp(at, np.arange(table.kernel.size), table.kernel) / thickness

    for row, column in ((0, 0), (0, 1), (1, 0), (4, 3), (9, 10), (13, 19)):
        axes = []
        for offset, edge in zip((row, column), pixel, strict=True):
            nodes, weights = panels(edge / 2, 30 if offset < 2 else 2, 1e-4)
            sides = np.concatenate([-nodes, nodes]) + offset * edge
            axes.append((sides, np.concatenate([weights, weights])))
        (y, wide), (x, high) = axes
        integral = (kernel(np.hypot(y[:, None], x)) * wide[:, None] * high).sum()
        assert added[row, column] == pytest.approx(integral, abs=1e-6 * scale)


@pytest.mark.parametrize("is_strip", [False, True], ids=["free", "strip"])
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("thickness", [0.1, 1.0, 10.0])
def test_operator_is_symmetric_positive_definite(
    name: str, thickness: float, is_strip: bool
) -> None:
    body, pixel, shape = coated(name, thickness), (1.0, 1.5), (9, 12)
    if is_strip:
        operator = strip_operator(body, shape, pixel)
        turned = strip_operator(body, shape[::-1], pixel[::-1], axis=0)
    else:
        more: Any = {"contact_modulus": 1 / body.compliance}
        more["coatings"] = Coatings.from_bodies(body, rc.RIGID)
        operator = convolution.free(shape, pixel, **more)
        turned = convolution.free(shape[::-1], pixel[::-1], **more)
    matrix = np.array([operator(unit.reshape(shape)).ravel() for unit in np.eye(math.prod(shape))])
    largest = np.abs(matrix).max()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * largest)
    assert np.linalg.eigvalsh(matrix).min() > 0
    here = np.zeros(shape)
    here[3, 4] = 1
    tolerance = (1e-12 if is_strip else 1e-7) * largest
    np.testing.assert_allclose(turned(here.T), operator(here).T, atol=tolerance)


def test_a_period_is_its_waves() -> None:
    body, shape, pixel = coated("stiff on steel", 2.0), (16, 24), (1.0, 0.8)
    pair = Coatings.from_bodies(body, rc.RIGID)
    operator = convolution.periodic(shape, pixel, 1 / body.compliance, coatings=pair)
    y, x = np.mgrid[:16, :24]
    wave = np.cos(2 * np.pi * (3 * y / 16 + 5 * x / 24))
    q = 2 * np.pi * math.hypot(3 / 16, 5 / (24 * 0.8))
    expected = 2 * body.compliance / q * (1 + layer_excess(body, np.array([2.0 * q]))[0])
    np.testing.assert_allclose(operator(wave), expected * wave, atol=1e-6 * expected)


# --- Strips and profiles ---


def strip_operator(
    body: rc.Material, shape: tuple[int, int], pixel: tuple[float, float], axis: int = 1
) -> convolution.Convolution:
    """Return the operator of a strip."""
    pair = Coatings.from_bodies(body, rc.RIGID)
    return convolution.strip(shape, pixel, 1 / body.compliance, axis, coatings=pair)


def test_layer_of_equal_material_on_strip_has_no_effect() -> None:
    body = rc.Material(1.0, 0.3, coating=[rc.Layer(1.0, 0.3, 2.0)])
    shape, pixel = (20, 14), (0.7, 1.0)
    bare = convolution.strip(shape, pixel, 1 / body.compliance, 1)
    np.testing.assert_allclose(
        strip_operator(body, shape, pixel).spectrum, bare.spectrum, atol=1e-12 * bare.spectrum.max()
    )


def waves_across(first: float, step: float, end: float) -> tuple[Array, Array]:
    """Return Gauss nodes and weights from 0 to an end, in panels that grow up to a step."""
    grown = np.geomspace(first, step, 60)
    ends = np.concatenate([[0.0], grown, np.arange(2 * step, end + 1, step)])
    nodes, weights = leggauss(16)
    half = np.diff(ends)[:, None] / 2
    return (ends[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("thickness", [0.1, 0.5, 3.0])
def test_waves_on_a_strip_are_their_integral(name: str, thickness: float) -> None:
    # Over waves across the strip, of which each pixel takes the mean.
    body, shape, (dy, dx) = coated(name, thickness), (12, 20), (0.9, 1.3)
    pair = Coatings.from_bodies(body, rc.RIGID)
    assert pair is not None
    added = pair.strip(shape, (dy, dx), 30.0, slice(None))
    bare = kernels.strip(shape, (dy, dx), 1.0, 30.0)[0]
    k, weights = waves_across(1e-6, 0.5, 30 / thickness)
    for wave in (1, 4, 10):
        q = 2 * np.pi * wave / (20 * dx)
        kappa = np.hypot(k, q)
        response = (
            layer_excess(body, kappa * thickness) / kappa * dy * np.sinc(k * dy / (2 * np.pi))
        )
        scale = bare[wave] * max(1.0, 1 + layer_excess(body, np.array([q * thickness]))[0])
        for offset in (0, 1, 3, 11):
            integral = 2 / np.pi * (response * np.cos(k * dy * offset)) @ weights
            assert added[offset, wave] == pytest.approx(integral, abs=1e-6 * scale)


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("thickness", [0.03, 1.0, 30.0])
def test_a_profile_is_the_integral_over_its_pixels(name: str, thickness: float) -> None:
    # Differences between pixels, in which neither the datum nor the longest waves matter.
    body, dy = coated(name, thickness), 0.9
    pair = Coatings.from_bodies(body, rc.RIGID)
    assert pair is not None
    added = pair.strip((40, 1), (dy, 1.0), 40.0, slice(None))[:, 0]
    k, weights = waves_across(1e-7, 0.2, 30 / thickness)
    response = layer_excess(body, k * thickness) / k * dy * np.sinc(k * dy / (2 * np.pi)) * weights
    softest = max(1.0, 1 + layer_excess(body, np.array([1e-6]))[0])
    for offset in (1, 2, 9, 12, 39):
        integral = 2 / np.pi * response @ (np.cos(k * dy * offset) - 1)
        assert added[offset] - added[0] == pytest.approx(integral, abs=1e-6 * dy * softest)


def test_the_datum_of_a_coated_profile_is_where_a_line_displaces_nothing() -> None:
    body = coated("stiff on polymer", 2.0)
    pair = Coatings.from_bodies(body, rc.RIGID)
    assert pair is not None
    added = pair.strip((400, 1), (0.1, 1.0), 30.0, slice(None))[:, 0]
    assert abs(added[300]) < 1e-5 * added[0]
    # On a rigid base displacement decays, wherever a datum is.
    film = coated("film on rigid", 2.0)
    pair = Coatings.from_bodies(film, rc.RIGID)
    assert pair is not None
    far = kernels.strip((400, 1), (0.1, 1.0), 1.0, 7.0)[:, 0]
    far = far + pair.strip((400, 1), (0.1, 1.0), 7.0, slice(None))[:, 0]
    assert abs(far[-1]) < 1e-4 * far[0]


@pytest.mark.parametrize(("thickness", "alone"), [(1e-9, 210e9 / 0.91), (0.1, 100e9 / 0.96)])
def test_a_cylinder_is_that_of_the_base_or_of_the_layer(thickness: float, alone: float) -> None:
    body = rc.Material(210e9, 0.3, coating=[rc.Layer(100e9, 0.2, thickness)])
    x, radius = (np.arange(512) - 255.5) * 8e-7, 0.01
    found = rc.solve(
        rc.Surface(-(x**2) / (2 * radius), 8e-7), material=body, load=1e5, ceiling=None
    )
    expected = hertz.line_contact(1e5, radius, alone)
    assert found.max_pressure == pytest.approx(expected.max_pressure, rel=1e-4)
    assert found.contact_area == pytest.approx(2 * expected.half_width, rel=1e-2)


# --- A sphere ---


SPHERES = {
    (0.25, 0.5): (1.330897, 0.634832, 1.319233),
    (0.5, 1.0): (1.206608, 0.704682, 1.227128),
    (2.0, 0.25): (0.920340, 1.073929, 0.955811),
    (2.0, 1.0): (0.818478, 1.475437, 0.826870),
}
"""Radius, peak and approach over Hertz's of the bare base, by E₁/E₂ and h/a₀; ν 0.3 both."""


def bare_hertz(contact: float = 1e-4, radius: float = 0.01) -> tuple[float, float, float]:
    """Return load, peak pressure and approach on the bare base."""
    modulus = 210e9 / 0.91
    return (
        4 * modulus * contact**3 / (3 * radius),
        2 * modulus * contact / (np.pi * radius),
        contact**2 / radius,
    )


@pytest.mark.parametrize(("ratio", "depth"), SPHERES)
def test_a_sphere_on_a_map_is_that_of_the_equation(ratio: float, depth: float) -> None:
    body = rc.Material(210e9, 0.3, coating=[rc.Layer(ratio * 210e9, 0.3, depth * 1e-4)])
    size, peak, approach = SPHERES[ratio, depth]
    edge = 3e-4 * max(1.0, size) / 128
    y, x = (np.mgrid[:128, :128] - 63.5) * edge
    load, hertz_peak, hertz_approach = bare_hertz()
    found = rc.solve(
        rc.Surface(-(x**2 + y**2) / 0.02, (edge, edge)), material=body, load=load, ceiling=None
    )
    assert found.converged
    assert found.max_pressure == pytest.approx(peak * hertz_peak, rel=5e-4)
    assert found.approach == pytest.approx(approach * hertz_approach, rel=5e-4)
    assert math.sqrt(found.contact_area / np.pi) == pytest.approx(size * 1e-4, rel=1e-2)


def test_two_coated_bodies_add_up() -> None:
    # Two alike are one of half the modulus that is pressed on a rigid flat.
    layer = rc.Layer(420e9, 0.3, 1e-4)
    body = rc.Material(210e9, 0.3, coating=[layer])
    edge = 3e-4 / 64
    y, x = (np.mgrid[:64, :64] - 31.5) * edge
    ball = rc.Surface(-(x**2 + y**2) / 0.02, (edge, edge))
    both = rc.solve(ball, material=body, counter_material=body, load=20.0, ceiling=None)
    half = rc.Material(105e9, 0.3, coating=[rc.Layer(210e9, 0.3, 1e-4)])
    one = rc.solve(ball, material=half, load=20.0, ceiling=None)
    np.testing.assert_allclose(both.pressure, one.pressure, atol=1e-5 * one.max_pressure)


# --- A rough map ---


@pytest.mark.long
@pytest.mark.parametrize("boundary", ["free", "periodic", "periodic-x"])
def test_stiff_film_on_soft_body_needs_few_convolutions(
    boundary: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = rc.Material(2e9, 0.4, coating=[rc.Layer(200e9, 0.2, 2e-6)])

    def solve_film() -> rc.ContactResult:
        surface = rc.Surface(*rc.reference_map(256))
        return rc.solve(surface, material=body, load=1.0, ceiling=None, boundary=boundary)

    quick = solve_film()
    # A solver that takes it for a homogeneous body needs 111 to 278.
    assert quick.convolutions <= 36
    monkeypatch.setattr(Coatings, "is_long_wave_soft", False)
    slow = solve_film()
    assert slow.convolutions > 2 * quick.convolutions
    np.testing.assert_array_equal(quick.contact, slow.contact)
    off = np.linalg.norm(quick.pressure - slow.pressure) / np.linalg.norm(slow.pressure)
    assert off < 5e-6
    assert quick.approach == pytest.approx(slow.approach, rel=1e-7)


@pytest.mark.parametrize("limit", [math.inf, 1.9])
def test_forces_of_blocks_stay_within_the_bounds(limit: float) -> None:
    x = np.array([3.0, -1.0, 0.5, 2.0, -0.5, 1.0, -4.0, 1.0])
    block = np.array([0, 0, 0, 1, 1, 1, 2, 2])
    kept = _clip_by_block(x, limit, block)
    assert kept.min() >= 0
    assert kept.max() <= limit
    force = np.bincount(block, kept)
    np.testing.assert_allclose(force, [2.5, 2.5, 0.0], atol=3e-3)
    assert kept[1] == kept[4] == kept[6] == 0


# --- Stress below a sphere ---


def solve_sphere_on_layer(
    young: float, poisson: float, depth: float
) -> tuple[rc.ContactResult, rc.Material]:
    """Return the contact of a sphere with a layer, its depth over Hertz's radius of the base."""
    body = rc.Material(210e9, 0.3, coating=[rc.Layer(young, poisson, depth * 1e-4)])
    edge = 3e-4 / 96
    y, x = (np.mgrid[:96, :96] - 47.5) * edge
    ball = rc.Surface(-(x**2 + y**2) / 0.02, (edge, edge))
    return rc.solve(ball, material=body, load=bare_hertz()[0], ceiling=None), body


def field(result: rc.ContactResult, body: rc.Material) -> Field:
    return coating_stress.field_of(
        result.pressure, result.surface.pixel, body, result.boundary, "double", Workspace()
    )


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_stress_in_equal_materials_is_that_of_one(boundary: str) -> None:
    body = rc.Material(210e9, 0.3, coating=[rc.Layer(210e9, 0.3, 3.0)])
    y, x = np.mgrid[:40, :46] - 20.3
    pressure, pixel = np.sqrt(np.maximum(1 - ((x + 2) ** 2 + y**2) / 64, 0)), (1.0, 1.2)
    found = coating_stress.field_of(
        pressure, pixel, body, Boundary(boundary), "double", Workspace()
    )
    for depth in (0.0, 1.0, 2.99, 3.01, 9.0):
        (known,) = stress.slices(
            pressure, pixel, [depth], 0.3, boundary=boundary, precision="double"
        )
        np.testing.assert_allclose(stress_at_depth(found, depth), known.stress, atol=2e-7)


def stress_at_depth(found: Field, depth: float) -> Array:
    """Return the stress of a depth."""
    result = np.empty((6, *found.shape))

    def store_rows(rows: slice, block: Array) -> None:
        result[:, rows] = block * found.unit

    found.stream(depth, store_rows)
    return result


def test_residual_stress_is_added_in_its_layer() -> None:
    result, body = solve_sphere_on_layer(450e9, 0.25, 0.5)
    (layer,) = body.coating
    strained = replace(layer, residual_stress=-2e9)
    with_it = field(result, replace(body, coating=[strained]))
    without = field(result, body)
    for depth, added in ((0.4e-4, -2e9), (0.6e-4, 0.0)):
        change = stress_at_depth(with_it, depth) - stress_at_depth(without, depth)
        expected = np.zeros(6)
        expected[:2] = added
        np.testing.assert_allclose(change.mean(axis=(1, 2)), expected, atol=1.0)


STRESSES = {
    # E₁ [GPa], ν₁, h/a₀: largest von Mises stress in the layer and in the base, largest tension at
    # the bottom of the layer, largest shear of the interface; over p₀ of the bare base.
    (450.0, 0.25, 0.5): (1.060, 0.737, 0.193, 0.238),
    (450.0, 0.25, 1.0): (0.900, 0.496, 0.264, 0.140),
    (840.0, 0.3, 0.5): (1.776, 0.825, 0.886, 0.254),
    (105.0, 0.3, 0.5): (0.468, 0.483, None, 0.156),
    (79.0, 0.42, 0.5): (0.358, 0.540, None, 0.182),
}
"""By quadrature of axisymmetric waves, depths a 24th of the layer apart: to 0.2 %."""


@pytest.mark.parametrize(("young", "poisson", "depth"), STRESSES)
def test_stress_below_a_sphere(young: float, poisson: float, depth: float) -> None:
    result, body = solve_sphere_on_layer(young * 1e9, poisson, depth)
    found, peak = field(result, body), bare_hertz()[1]
    depths = coating_stress.depths_with_faces(body, np.linspace(0.2, 0.7, 9) * 1e-4)
    largest = [0.0, 0.0]
    for place in depths.tolist():
        part = coating_stress.part_of(body, place)
        value = float(von_mises(stress_at_depth(found, place)).max()) / peak
        largest[part] = max(largest[part], value)
    layer, base, tension, shear = STRESSES[young, poisson, depth]
    assert largest == pytest.approx([layer, base], rel=5e-3)
    _, bottom, _ = coating_stress.faces(found, body)
    assert bottom.shear.value / peak == pytest.approx(shear, rel=5e-3)
    if tension is not None:
        assert bottom.tension.value / peak == pytest.approx(tension, rel=1e-2)
