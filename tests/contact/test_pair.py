import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.pair import BODIES, Pair
from roughcontact.errors import ArgumentRef
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
SOFT = rc.Material(70e9, 0.2, 0.2e9, "soft")
PIXEL = (1e-6, 1.2e-6)
HEIGHTS = np.random.default_rng(3).normal(scale=1e-7, size=(12, 9))


def surface(heights: np.ndarray = HEIGHTS) -> rc.Surface:
    return rc.Surface(heights, PIXEL)


def test_the_gap_is_from_the_first_touch() -> None:
    alone = Pair(surface(), STEEL)
    np.testing.assert_array_equal(alone.initial_gap, HEIGHTS.max() - HEIGHTS)
    both = Pair(surface(), STEEL, surface(HEIGHTS[::-1]), SOFT)
    total = HEIGHTS + HEIGHTS[::-1]
    np.testing.assert_array_equal(both.initial_gap, total.max() - total)
    assert both.highest == total.max()
    # A new array each time: the solver may take it away.
    assert both.initial_gap.flags.writeable
    assert not both.has_holes


def test_missing_points_of_either_body_are_missing_in_gap() -> None:
    holed = HEIGHTS.copy()
    holed[2, 3] = np.nan
    for pair in (
        Pair(surface(holed), STEEL),
        Pair(surface(), STEEL, counter_surface=surface(holed)),
    ):
        assert pair.has_holes
        np.testing.assert_array_equal(np.isnan(pair.initial_gap), np.isnan(holed))


def test_materials_by_the_name_of_the_body() -> None:
    pair = Pair(surface(), STEEL, counter_material=SOFT)
    assert [pair.material_of(body) for body in BODIES] == [STEEL, SOFT]
    assert pair.softer is SOFT
    assert pair.contact_modulus == rc.contact_modulus(STEEL, SOFT)
    with pytest.raises(rc.InputError, match="body must be 'body' or 'counter_body', got 'first'"):
        pair.material_of("first")


@pytest.mark.parametrize("boundary", Boundary)
def test_operators_are_those_of_the_boundary(boundary: Boundary) -> None:
    pair = Pair(surface(), STEEL, boundary=boundary)
    pressure = np.zeros(pair.shape)
    pressure[4, 5] = 1e9
    own = pair.operators("double", Workspace())(pair.shape, (1, 1))
    modulus = rc.contact_modulus(STEEL, rc.RIGID)
    other = boundary.operator(pair.shape, PIXEL, modulus, datum=max(pair.size))
    np.testing.assert_array_equal(own(pressure), other(pressure))


@pytest.mark.parametrize(
    ("bodies", "message"),
    [
        ((HEIGHTS, STEEL), "surface must be a Surface, got ndarray"),
        ((surface(), None), "material must be a Material, got NoneType"),
        ((surface(), STEEL, HEIGHTS), "counter_surface must be a Surface"),
        ((surface(), STEEL, None, "steel"), "counter_material must be a Material, got str"),
        ((surface(), STEEL, surface(HEIGHTS[1:])), "counter_surface has .* the same grid"),
        ((surface(), rc.RIGID), "both bodies are rigid"),
    ],
)
def test_invalid_pairs_raise_input_error(bodies: tuple, message: str) -> None:
    with pytest.raises(rc.InputError, match=message):
        Pair(*bodies)


def test_different_pairs_have_different_records() -> None:
    record = Pair(surface(), STEEL).record()
    assert record == Pair(surface(HEIGHTS.copy()), STEEL).record()
    for other in (
        Pair(surface(1.5 * HEIGHTS), STEEL),
        Pair(surface(), SOFT),
        Pair(surface(), STEEL, surface()),
        Pair(surface(), STEEL, counter_material=SOFT),
        Pair(surface(), STEEL, boundary=Boundary.PERIODIC),
    ):
        assert other.record() != record


def test_unequal_grids_raise_input_error_with_align_option() -> None:
    body = rc.Surface(np.zeros((4, 4)), (1.0982520279867458e-06, 1.0982520279867458e-06))
    with pytest.raises(rc.InputError) as caught:
        Pair(body, STEEL, rc.Surface(np.zeros((3, 4)), (2e-6, 1e-6)))
    words = str(caught.value)
    assert "has 3 × 4 points of 2 µm × 1 µm, the surface 4 × 4 points of 1.098 µm × 1.098" in words
    assert "align=True resamples one" in words
    assert ArgumentRef("align", True) in caught.value.parts


def test_nominal_counter_body_uses_grid_of_map() -> None:
    rough = surface()
    ball = rc.sphere("6 mm", shape=rough.shape, pixel=rough.pixel)
    pairs = [
        Pair.from_arguments(rough, STEEL, body, SOFT, "free") for body in (ball, rc.sphere("6 mm"))
    ]
    assert pairs[0].record() == pairs[1].record()
    with pytest.raises(rc.InputError, match="surface must be a Surface, got ndarray"):
        Pair.from_arguments(HEIGHTS, STEEL, rc.sphere("6 mm"), SOFT, "free")


@pytest.mark.long
def test_every_task_accepts_nominal_counter_body() -> None:
    ball = rc.sphere("6 mm")
    rough: dict = {"surface": surface(), "material": STEEL, "counter_surface": ball}
    once = rc.solve(**rough, load=0.01)
    assert once.counter_surface.provenance.source == ball.sample_body(surface()).provenance.source
    assert rc.sweep(**rough, loads=[0.01]).largest.pressure.tobytes() == once.pressure.tobytes()
    assert rc.first_yield_load(**rough).solution.counter_surface is not None
    assert rc.find_load(**rough, contact_fraction=0.05).largest.counter_surface is not None
    assert rc.history(**rough, path=[0.01, 0.0]).largest.counter_surface is not None
    pressed = rc.solve_elastoplastic(**rough, load=0.01, increments=1)
    assert pressed.solution.counter_surface is not None
