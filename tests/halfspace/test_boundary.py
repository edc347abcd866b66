import html
import json
import tracemalloc

import numpy as np
import pytest
import xarray

import roughcontact as rc
from roughcontact.cautions import CautionTag
from roughcontact.contact import spots
from roughcontact.contact.memory import MemoryNeed
from roughcontact.errors import InputError
from roughcontact.halfspace import boundary as boundary_module, convolution
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers import bounded, preconditioner
from roughcontact.uncertainty import resolution as resolution_study

STRIPS = [Boundary.PERIODIC_X, Boundary.PERIODIC_Y]
PIXEL = (0.4, 1.0)
MODULUS = 3.0


@pytest.mark.parametrize("value", ["open", "", "Free", "periodic_x", None, 3, ["free"]])
def test_invalid_boundary_raises_input_error_with_choices(value):
    with pytest.raises(InputError, match="boundary must be 'free' or 'periodic' or") as caught:
        Boundary(value)
    assert caught.value.argument == "boundary"
    assert repr(value) in str(caught.value)
    assert "'periodic-x' or 'periodic-y'" in str(caught.value)


@pytest.mark.parametrize("boundary", Boundary)
def test_the_operator_wraps_along_the_periodic_axes(boundary):
    operator = boundary.operator((6, 9), PIXEL, MODULUS)
    assert operator.periodic_axes == tuple(axis in boundary.periodic_axes for axis in (0, 1))
    unit = np.zeros((6, 9))
    unit[0, 0] = 1
    moved = operator(unit)
    for axis, near_seam in enumerate((moved[-1, 0], moved[0, -1])):
        near = moved[1, 0] if axis == 0 else moved[0, 1]
        if axis in boundary.periodic_axes:
            assert near_seam == pytest.approx(near, rel=1e-13)
        else:
            assert near_seam < 0.7 * near


def _soft(shape, pixel, modulus, *, datum, **options):
    return convolution.free(shape, pixel, modulus / 2, **options)


@pytest.fixture
def soft_bed(monkeypatch):
    """A boundary added as in CONTRIBUTING: its name, and one object with all that depends on it."""
    member = str.__new__(Boundary, "soft-bed")
    member._name_, member._value_ = "SOFT_BED", "soft-bed"
    entry = boundary_module._BoundaryModel(
        (), "the map is on a soft bed", ("Barber2003",), _soft, kernel_memory=lambda shape: 10**9
    )
    monkeypatch.setattr(Boundary, "_member_names_", [*Boundary._member_names_, "SOFT_BED"])
    monkeypatch.setitem(Boundary._member_map_, "SOFT_BED", member)
    monkeypatch.setitem(Boundary._value2member_map_, "soft-bed", member)
    monkeypatch.setitem(boundary_module._MODELS, member, entry)
    return member


def test_new_boundary_supports_all_operations(soft_bed, tmp_path):
    heights, pixel = rc.reference_map(32)
    surface, steel = rc.Surface(heights, pixel), rc.Material(210e9, 0.3, 1e9)
    asked = {"material": steel, "load": 1e-3, "ceiling": None}
    result = rc.solve(surface, boundary="soft-bed", **asked)
    soft = rc.Material(210e9 / 2, 0.3, 1e9)
    plain = rc.solve(surface, **{**asked, "material": soft})
    assert result.converged
    assert result.max_pressure == pytest.approx(plain.max_pressure, rel=1e-6)
    assert "Approach" in repr(result)
    works = {work.key for work in result.references()}
    assert "Barber2003" in works
    assert not works & {"Love1929", "Stanley1997"}
    result.save(tmp_path / "out.nc")
    again = rc.read_result(tmp_path / "out.nc")
    assert again.boundary is soft_bed
    np.testing.assert_array_equal(again.pressure, result.pressure)
    # The memory of the kernel.
    assert MemoryNeed((32, 32), soft_bed).estimate() > 10**9
    assert MemoryNeed((32, 32)).estimate() < 10**9
    for refused in (
        lambda: rc.subsurface_stress(result),
        lambda: rc.solve(rc.Surface(heights[0], pixel[1]), boundary="soft-bed", **asked),
    ):
        with pytest.raises(InputError, match=r"'soft-bed' is not available for .*; solve with"):
            refused()


@pytest.mark.parametrize("shape", [(12, 31), (31, 12), (2, 33), (8, 8)])
def test_strip_along_x_is_transposed_strip_along_y(shape):
    pressure = np.random.default_rng(0).random(shape)
    along_x = Boundary.PERIODIC_X.operator(shape, PIXEL, MODULUS)(pressure)
    turned = Boundary.PERIODIC_Y.operator(shape[::-1], PIXEL[::-1], MODULUS)
    along_y = turned(np.ascontiguousarray(pressure.T)).T
    np.testing.assert_allclose(along_x, along_y, rtol=0, atol=2e-15 * along_x.max())


@pytest.mark.parametrize("boundary", STRIPS)
@pytest.mark.parametrize("shape", [(4, 400), (400, 4), (64, 64), (5, 7)])
def test_the_kernel_of_a_strip_is_positive_definite(boundary, shape):
    # Long or short across: every wave of the padded map resists, the mean as well.
    assert boundary.operator(shape, PIXEL, MODULUS).spectrum.min() > 0


@pytest.mark.parametrize("boundary", STRIPS)
def test_parts_and_coarse_grids_of_a_strip_share_the_datum_of_the_map(boundary):
    # The same uniform pressure on the same pixels displaces them alike on a part of the map.
    # The longer side is that which ends: a part of it is shorter.
    free = boundary.free_axes[0]
    shape = (60, 40) if free == 0 else (40, 60)
    half = (shape[0] // 2, shape[1] // 2)
    family = boundary.operators(shape, (1.0, 1.0), MODULUS)
    whole = np.zeros(shape)
    cut = [slice(None), slice(None)]
    cut[free] = slice(10, 20)
    whole[tuple(cut)] = 1
    expected = family(shape, (1, 1))(whole)[tuple(cut)]
    part = [*shape]
    part[free] = 10
    found = family((part[0], part[1]), (1, 1))(np.ones(part))
    np.testing.assert_allclose(found, expected, rtol=1e-13)
    coarse = np.zeros(half)
    cut[free] = slice(5, 10)
    coarse[tuple(cut)] = 1
    # Larger pixels make 0.3 %, half the datum would make 20 %.
    averaged = family(half, (2, 2))(coarse)[tuple(cut)].mean()
    assert averaged == pytest.approx(expected.mean(), rel=1e-2)


@pytest.mark.parametrize(
    ("boundary", "shape"),
    [
        ("free", (15, 8)),
        ("periodic", (200, 40)),
        ("periodic-x", (15, 40)),
        ("periodic-y", (200, 8)),
    ],
)
def test_patch_covers_whole_period(boundary, shape):
    # A contact of 11 × 4 pixels, and two more on each side where the map ends.
    family = Boundary(boundary).operators((200, 40), PIXEL, MODULUS)
    parts = preconditioner.Patches(family((200, 40), (1, 1)), family, (1, 1))
    rows, columns = np.mgrid[90:101, 20:24]
    index = (40 * rows + columns).ravel()
    patch = parts.make_patch(index)
    assert patch.operator.shape == shape
    # The pixels displace one another as they do on the whole map.
    whole = family((200, 40), (1, 1))
    pressure = np.random.default_rng(0).random(index.size)
    local = patch.operator.support(patch.index(index))
    found = patch.operator.gather(local, pressure)
    expected = whole.gather(whole.support(index), pressure)
    # In single precision.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * expected.max())


@pytest.mark.parametrize("shape", [(512, 512), (300, 700)])
@pytest.mark.parametrize("boundary", list(Boundary))
@pytest.mark.parametrize("precision", ["double", "single"])
def test_operator_memory_matches_allocation(boundary, precision, shape):
    # Once before, for what is imported and kept.
    boundary.operator((8, 8), PIXEL, 1.0, precision=precision, workspace=Workspace(1))
    workspace = Workspace(1)
    tracemalloc.start()
    try:
        boundary.operator(shape, PIXEL, 1.0, precision=precision, workspace=workspace)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    result = boundary.operator_memory(shape, precision)
    # Small objects, and lengths that transform fast; but for full periods, single precision lays
    # its own rows out after its kernel was made in double.
    assert most < 1.06 * result
    if precision == "double" or boundary is Boundary.PERIODIC:
        assert most > result


STEEL = rc.Material(210e9, 0.3, 1e9, "steel")


@pytest.fixture(scope="module")
def rough():
    rng = np.random.default_rng(1)
    heights = np.cumsum(np.cumsum(rng.standard_normal((72, 96)), 0), 1)
    return rc.Surface(1e-7 * heights / heights.std(), (2e-7, 3e-7))


@pytest.fixture(scope="module", params=[str(boundary) for boundary in STRIPS])
def pressed_strip(request, rough):
    load = 3e8 * rough.size[0] * rough.size[1]
    return rc.solve(rough, material=STEEL, load=load, boundary=request.param)


def test_a_result_holds_its_boundary_and_files_its_name(pressed_strip, tmp_path):
    assert isinstance(pressed_strip.boundary, Boundary)
    pressed_strip.save(tmp_path / "strip.nc")
    again = rc.read_result(tmp_path / "strip.nc")
    assert again.boundary is pressed_strip.boundary
    assert again.pressure.tobytes() == pressed_strip.pressure.tobytes()
    assert again.spots().count == pressed_strip.spots().count
    with xarray.open_dataset(tmp_path / "strip.nc") as dataset:
        assert dataset.attrs["boundary"] == str(pressed_strip.boundary)
    assert json.loads(json.dumps(pressed_strip.summary()))["boundary"] == pressed_strip.boundary


def test_spots_and_rims_of_a_strip_wrap_along_its_period(rough):
    # A groove's worth of contact over the seam along x.
    pressure = np.zeros((6, 8))
    pressure[2, [0, -1]] = pressure[[0, -1], 4] = 1.0
    counts = {}
    for boundary in Boundary:
        counts[str(boundary)] = spots.find_spots(pressure, PIXEL, boundary.periodic_axes).count
    assert counts == {"free": 4, "periodic": 2, "periodic-x": 3, "periodic-y": 3}
    touching = pressure > 0
    edges = {str(b): spots.rim_excess(touching, touching, b) for b in Boundary}
    # Edges between contact and none: those at the ends of a map that ends do not count.
    unit = edges["periodic"] / 12
    assert {name: round(value / unit) for name, value in edges.items()} == {
        "free": 12,
        "periodic": 12,
        "periodic-x": 12,
        "periodic-y": 12,
    }
    touching[2, -1] = False
    assert spots.rim_excess(touching, touching, Boundary.PERIODIC_X) > spots.rim_excess(
        touching, touching, Boundary.PERIODIC_Y
    )


@pytest.mark.parametrize(
    ("place", "flagged"),
    [
        ((slice(10, 14), slice(0, 4)), {"free", "periodic-y"}),
        ((slice(0, 4), slice(10, 14)), {"free", "periodic-x"}),
        ((slice(10, 14), slice(10, 14)), set()),
    ],
    ids=["left edge", "upper edge", "inside"],
)
def test_only_an_edge_where_the_map_ends_is_flagged(place, flagged):
    heights = np.zeros((24, 24))
    heights[place] = 1e-6
    surface = rc.Surface(heights, (1e-6, 1e-6))
    found = set()
    for boundary in Boundary:
        result = rc.solve(surface, material=STEEL, load=1e-3, boundary=boundary)
        if CautionTag.EDGE in {caution.kind for caution in result.cautions}:
            found.add(str(boundary))
    assert found == flagged


@pytest.mark.slow
def test_report_of_strip_shows_axis_and_datum(pressed_strip, tmp_path):
    pressed_strip.report(tmp_path / "strip.html")
    page = html.unescape((tmp_path / "strip.html").read_text(encoding="utf-8"))
    axis = str(pressed_strip.boundary)[-1]
    assert f"the map repeats along {axis}" in page
    assert "Datum of the approach" in page


def test_a_load_curve_and_a_study_of_a_strip(pressed_strip, rough):
    load, boundary = pressed_strip.load, pressed_strip.boundary
    options = {"material": STEEL, "boundary": boundary}
    curve = rc.sweep(rough, loads=[load / 2, load], **options)
    last = curve.steps[-1]
    assert last.approach == pytest.approx(pressed_strip.approach, rel=1e-5)
    assert last.spots == pressed_strip.spots().count
    assert last.stiffness == pytest.approx(pressed_strip.stiffness(), rel=1e-3)
    study = rc.resolution_study(rough, load=load, **options)
    shapes = [grid.shape for grid in study.grids]
    assert (72, 96) in shapes
    assert (144, 192) in shapes


def test_grids_of_a_study_keep_the_period_and_the_means_across():
    # Waves along x, steps along y: each axis is coarsened after its own kind.
    wave = np.sin(2 * np.pi * (np.arange(64) + 0.5) / 64)
    steps = np.repeat([0.0, 1.0, 4.0, 9.0], 16)
    surface = rc.Surface(steps[:, None] + wave, (1.0, 1.0))
    coarse = resolution_study._coarsen(surface, 2, Boundary.PERIODIC_X)
    assert coarse.shape == (32, 32)
    expected = np.repeat([0.0, 1.0, 4.0, 9.0], 8)[:, None] + np.sin(
        2 * np.pi * (np.arange(32) + 0.5) / 32
    )
    np.testing.assert_allclose(coarse.heights, expected, rtol=0, atol=1e-12)
    turned = rc.Surface(np.ascontiguousarray(surface.heights.T), (1.0, 1.0))
    other = resolution_study._coarsen(turned, 2, Boundary.PERIODIC_Y)
    np.testing.assert_allclose(other.heights.T, coarse.heights, rtol=0, atol=1e-12)
    # 65 points across lose one, 66 along stay.
    odd = rc.Surface(np.zeros((65, 66)), (1.0, 1.0))
    assert resolution_study._divisible(odd, Boundary.PERIODIC_X).shape == (64, 66)
    assert resolution_study._divisible(odd, Boundary.PERIODIC_Y).shape == (65, 64)
    holed = surface.heights.copy()
    holed[5, 7] = np.nan
    coarse = resolution_study._coarsen(rc.Surface(holed, (1.0, 1.0)), 2, Boundary.PERIODIC_X)
    assert np.isnan(coarse.heights[2, 3])
    assert np.isnan(coarse.heights).sum() == 1


@pytest.mark.parametrize("boundary", STRIPS)
def test_unsupported_analyses_of_strip_raise_input_error_before_solve(boundary, rough, monkeypatch):
    def no_solve(*arguments, **options):
        raise AssertionError("solved something")

    result = rc.solve(rough, material=STEEL, load=1e-3, boundary=boundary)
    monkeypatch.setattr(bounded, "solve", no_solve)
    options = {"material": STEEL, "boundary": boundary}
    with pytest.raises(InputError, match="moments need boundary="):
        rc.solve(rough, load=1.0, moments=(0.0, 0.0), **options)
    for call in (
        lambda: rc.subsurface_stress(result),
        lambda: rc.first_yield_load(rough, **options),
        lambda: rc.solve_elastoplastic(rough, load=1.0, **options),
    ):
        with pytest.raises(InputError, match="is not available for") as caught:
            call()
        assert caught.value.argument == "boundary"
