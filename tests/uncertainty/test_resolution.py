import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.memory import MemoryNeed
from roughcontact.surface import shapes
from roughcontact.theory import hertz
from roughcontact.uncertainty import resolution as resolution_study

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
PIXEL = (1e-6, 1e-6)
BALL = shapes.paraboloid((128, 128), PIXEL, 0.01)


def looked_at(
    heights: np.ndarray = BALL, load: float = 1.0, **options
) -> rc.results.ResolutionStudy:
    return rc.resolution_study(
        rc.Surface(heights, PIXEL), **{"load": load, "material": STEEL, **options}
    )


def noisy(rms: float = 5e-9) -> np.ndarray:
    return BALL + rms * np.random.default_rng(1).standard_normal(BALL.shape)


def test_everything_is_converged_on_a_smooth_ball() -> None:
    found = looked_at(ceiling=None)
    assert [grid.value for grid in found.grids] == [4, 2, 1, 0.5]
    assert all(found.independent(name) for name in resolution_study.QUANTITIES)
    assert (
        "contact area, perimeter-corrected area, maximum pressure, mean pressure"
        in found.sentences[0]
    )
    assert not any("Not converged" in sentence for sentence in found.sentences)
    modulus = 210e9 / 0.91
    a = hertz.contact_radius(1.0, 0.01, modulus)
    for grid in found.grids:
        # The coarsest radius has 8 pixels; the corrected area is right to a tenth of a pixel.
        area = grid.corrected_fraction * 128e-6**2
        assert area == pytest.approx(np.pi * a**2, rel=0.03)
        assert grid.max_pressure == pytest.approx(hertz.max_pressure(1.0, 0.01, modulus), rel=0.02)


def test_bracket_of_coated_body_studies_contacts_at_the_ceiling_of_the_coating() -> None:
    film = rc.Layer(83e9, 0.37, 5e-6, hardness="264 MPa")
    tool = rc.Material(124e9, 0.34, 180e6, coating=[film])
    terms = {"heights": BALL[::2, ::2], "material": tool}
    both, alone = (looked_at(**terms, ceiling=ceiling) for ceiling in ("bracket", "coating"))
    assert both.grids == alone.grids
    assert both.at_ceiling


def test_noise_at_pixel_is_detected() -> None:
    found = looked_at(noisy(), ceiling=None)
    assert not found.independent("max_pressure")
    assert any(
        "on the maximum pressure changes" in sentence and "reflects the pixel size" in sentence
        for sentence in found.sentences
    )
    # Finer grids show higher noise, hence higher peaks.
    pressures = [grid.max_pressure for grid in found.grids[:3]]
    assert pressures == sorted(pressures)
    assert pressures[2] > 2 * pressures[1]
    # The filter shows the same: shorter waves, higher pressure.
    assert [v.max_pressure for v in found.cutoffs] == sorted(v.max_pressure for v in found.cutoffs)


@pytest.mark.long
def test_maximum_at_ceiling_is_not_convergence() -> None:
    found = looked_at(noisy(50e-9))
    assert found.at_ceiling
    assert any("says nothing about the resolution" in sentence for sentence in found.sentences)
    assert not any("maximum pressure," in s or "maximum pressure." in s for s in found.sentences)
    assert [v.value for v in found.ceilings] == [2.8, 3.0, 3.2]
    assert [v.max_pressure for v in found.ceilings] == pytest.approx([2.8e9, 3e9, 3.2e9])
    fractions = [v.contact_fraction for v in found.ceilings]
    assert fractions == sorted(fractions, reverse=True)
    assert any(s.startswith("Ceiling: as the factor goes from 2.8 to 3.2") for s in found.sentences)


def test_periodic_maps_keep_their_period_and_their_waves() -> None:
    surface = rc.Surface(*rc.reference_map(128))
    found = rc.resolution_study(
        surface, load=1.0, material=STEEL, ceiling=None, boundary="periodic"
    )
    sizes = {(g.shape[0] * g.pixel[0], g.shape[1] * g.pixel[1]) for g in found.grids}
    assert np.ptp(list(sizes), axis=0) == pytest.approx([0, 0], abs=1e-18)
    # Interpolated by its own waves, the map is the same: only the error of the grid is left.
    assert found.grids[-1].contact_fraction == pytest.approx(
        found.grids[-2].contact_fraction, rel=0.05
    )


@pytest.mark.long
def test_measured_grid_is_the_solve_itself() -> None:
    surface = rc.Surface(*rc.reference_map(128))
    found = rc.resolution_study(surface, load=1.0, material=STEEL)
    alone = rc.solve(surface, load=1.0, material=STEEL)
    grid = found.grids[2]
    assert grid.max_pressure == alone.max_pressure
    assert grid.saturated_fraction == alone.saturated_fraction
    assert grid.mean_pressure == pytest.approx(1.0 / alone.contact_area)
    assert grid.contact_fraction == alone.contact_fraction
    assert found.ceilings[1].contact_fraction == grid.contact_fraction


def test_holes_two_bodies_and_odd_sizes() -> None:
    heights = np.pad(BALL, ((0, 3), (0, 2)), mode="edge").copy()
    heights[5:9, 100:103] = np.nan
    surface = rc.Surface(heights, PIXEL).masked()
    counter = rc.Surface(1e-9 * np.random.default_rng(2).standard_normal(heights.shape), PIXEL)
    found = rc.resolution_study(
        surface, load=1.0, material=STEEL, counter_surface=counter, ceiling=np.full((131, 130), 2e9)
    )
    assert [grid.shape for grid in found.grids] == [(32, 32), (64, 64), (128, 128), (256, 256)]
    assert found.ceilings == ()
    assert all(grid.certificate <= 1e-6 for grid in found.grids)


def test_low_ceiling_factor_is_reported() -> None:
    area = 128e-6**2
    found = looked_at(load=2.9e9 * area)
    assert [v.value for v in found.ceilings] == [3.0, 3.2]
    assert any("ceiling factor of 2.8 the load cannot be carried" in s for s in found.sentences)


def test_grid_exceeding_memory_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def small(room: MemoryNeed, contact_fraction: float = 0.0, there: int | None = None) -> None:
        if room.shape[0] > 128:
            raise rc.InsufficientMemoryError("too much")

    monkeypatch.setattr(MemoryNeed, "require", small)
    found = looked_at()
    assert [grid.value for grid in found.grids] == [4, 2, 1]
    assert "0.5 × the pixel was left out: too much" in found.sentences[-1]


def test_bad_input() -> None:
    with pytest.raises(rc.InputError, match="at least 64"):
        looked_at(np.zeros((63, 200)) - np.arange(200) ** 2)
    with pytest.raises(rc.CapacityError):
        looked_at(load=1e3)
    with pytest.raises(rc.InputError, match="name must be one of"):
        looked_at().changes("area")
