import dataclasses

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.cautions import Caution, Kind
from roughcontact.contact.result import Regime
from roughcontact.errors import Mention, worded
from roughcontact.surface import shapes

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
PIXEL = (1e-6, 1e-6)


def ball(points: int = 32) -> rc.Surface:
    return rc.Surface(shapes.paraboloid((points, points), PIXEL, 1e-3), PIXEL)


def kinds(result: rc.ContactResult | rc.StressResult) -> list[str]:
    return [caution.kind for caution in result.cautions]


def test_a_sound_result_needs_no_caution() -> None:
    result = rc.solve(ball(), material=STEEL, load=1e-2)
    assert result.cautions == result.warnings == ()


def test_each_caution_has_its_kind_and_its_sentence() -> None:
    result = rc.solve(ball(16), material=STEEL, load=2.0, ceiling=None)
    assert kinds(result) == [Kind.EDGE, Kind.BEYOND_CEILING]
    assert result.regime is Regime.BEYOND_CEILING
    assert result.warnings[1] == (
        "the pressure exceeds three times the yield strength of the softer body: "
        "solve with a ceiling"
    )
    heights = np.array(ball().heights)
    heights[0, 0] = np.nan
    holed = rc.solve(rc.Surface(heights, PIXEL).masked(), material=STEEL, load=1e-2)
    assert kinds(holed) == [Kind.MISSING]
    assert holed.warnings == ("1 missing points were treated as never touching",)


@pytest.mark.parametrize(
    ("boundary", "edges"), [("free", 2), ("periodic-x", 1), ("periodic-y", 1), ("periodic", 0)]
)
def test_only_edges_at_which_the_map_ends_are_told_of(boundary: str, edges: int) -> None:
    result = rc.solve(ball(), material=STEEL, load=1e-2, boundary=boundary)
    told = 0
    for axis in (0, 1):
        pressure = np.zeros((32, 32))
        pressure[(0, 5) if axis == 0 else (5, 0)] = 1e8
        told += Kind.EDGE in kinds(dataclasses.replace(result, pressure=pressure))
    assert told == edges


def test_a_result_that_did_not_converge_says_so_in_the_words_of_any_edge() -> None:
    result = rc.solve(ball(64), material=STEEL, load=1e-2, max_iterations=2, on_failure="return")
    (caution,) = (c for c in result.cautions if c.kind == Kind.NOT_CONVERGED)
    assert "stopped at max_iterations; allow more" in caution.text
    assert Mention("max_iterations") in caution.parts
    assert "stopped at --max-iterations" in worded(
        caution.parts, lambda mention: f"--{mention.name.replace('_', '-')}"
    )


def test_cautions_of_the_stress_begin_with_those_of_the_contact() -> None:
    result = rc.solve(ball(16), material=STEEL, load=2.0, ceiling=None)
    stress = rc.subsurface_stress(result)
    assert stress.cautions[: len(result.cautions)] == result.cautions
    assert Kind.BEYOND_YIELD in kinds(stress)
    assert stress.warnings == tuple(caution.text for caution in stress.cautions)


def test_cautions_are_equal_where_they_say_the_same() -> None:
    assert Caution(Kind.EDGE, ("at the edge",)) == Caution(Kind.EDGE, ("at the edge",))
    assert Caution(Kind.EDGE, ("at the edge",)) != Caution(Kind.MISSING, ("at the edge",))
