"""Sliding of a counter-body that yields: it takes its strain along, the rough body does not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import roughcontact as rc
from rollers import PIXEL, Line
from roughcontact.elastoplastic.plastic_flow import shift_field
from roughcontact.errors import InputError

FRICTION = 0.2
PLACES = (0, 2.5, 6)
LINE = Line(3.9, half_width=5, points=32)
SOFT, HARD = LINE.steel, rc.Material(LINE.steel.young, LINE.steel.poisson)
# Half the modulus of the contact at the same pressure: half the radius.
ROLLER = rc.Surface(2 * LINE.roller.heights, PIXEL, holes_masked=True)


def solve_sliding(
    surface: rc.Surface, counter: rc.Surface, path: list[rc.PathPoint], soft: str, **more: object
) -> rc.ElastoplasticResult:
    materials = {"material": HARD, "counter_material": HARD} | {soft: SOFT}
    return rc.solve_elastoplastic(
        surface,
        counter_surface=counter,
        path=path,
        boundary="periodic",
        precision="double",
        **({"layers": LINE.layers} | materials | more),
    )


def sliding_path(points: tuple[float, ...] = PLACES, sign: float = 1.0) -> list[rc.PathPoint]:
    direction = 0.0 if sign > 0 else 180.0
    return [LINE.point_at(sign * x, FRICTION, direction) for x in points]


def strain(result: rc.ElastoplasticResult) -> NDArray[np.float64]:
    return result.bodies[0].plastic_strain


@pytest.mark.slow
def test_body_sliding_under_constant_load_yields_once() -> None:
    """A flat that stays elastic leaves the roller under the same load, at the same place in it."""
    alone = solve_sliding(LINE.flat, ROLLER, sliding_path((0,)), "counter_material")
    moved = solve_sliding(LINE.flat, ROLLER, sliding_path((0, 3, 6)), "counter_material")
    largest = alone.max_plastic_strain
    assert largest > 3e-4
    expected = np.roll(strain(alone), 6, axis=-1)
    np.testing.assert_allclose(strain(moved), expected, atol=2e-3 * largest)
    # One that rolls flows on the whole way.
    rolled = solve_sliding(
        LINE.flat, ROLLER, [LINE.point_at(x) for x in (0, 3, 6)], "counter_material"
    )
    still = solve_sliding(LINE.flat, ROLLER, [LINE.point_at(0)], "counter_material")
    assert rolled.plastic_volume > 1.2 * still.plastic_volume


@pytest.mark.slow
@pytest.mark.parametrize(("middle", "error"), [(3, 1e-3), (2.5, 0.05)], ids=["whole", "parts"])
def test_sliding_flat_matches_sliding_roller(middle: float, error: float) -> None:
    """A flat slides under a roller as the roller slides over the flat, the other way.

    Between pixels the rim of the contact falls differently on the grids of the two.
    """
    places = (0, middle, 6)
    over = solve_sliding(LINE.flat, ROLLER, sliding_path(places), "material")
    under = solve_sliding(ROLLER, LINE.flat, sliding_path(places, sign=-1.0), "counter_material")
    assert over.max_plastic_strain > 1e-3
    # In the frame of the flat.
    np.testing.assert_allclose(
        np.roll(strain(under), 6, axis=-1), strain(over), atol=error * over.max_plastic_strain
    )
    np.testing.assert_allclose(
        np.roll(under.residual_displacement, 6, axis=-1),
        over.residual_displacement,
        atol=error / 2 * np.ptp(over.residual_displacement),
    )


def test_fields_are_carried_by_parts_of_a_pixel() -> None:
    x = np.arange(24) * 2 * np.pi / 24
    field = np.tile(np.sin(x), (6, 1))
    np.testing.assert_array_equal(shift_field(field, (2.0, 5.0)), np.roll(field, (2, 5), (0, 1)))
    half = np.tile(np.sin(x - 2.5 * 2 * np.pi / 24), (6, 1))
    np.testing.assert_allclose(shift_field(field, (1.5, 2.5)), half, atol=1e-14)


def test_sliding_over_free_map_raises_input_error() -> None:
    with pytest.raises(InputError, match="slides a counter-body that yields, with its"):
        rc.solve_elastoplastic(
            LINE.flat,
            counter_surface=ROLLER,
            material=SOFT,
            counter_material=SOFT,
            path=sliding_path(),
        )
