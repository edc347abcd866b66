"""How large an area is needed, by the scatter between parts of a map."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import statistics
from roughcontact.analyses.compare import report as comparison
from roughcontact.cautions import CautionTag
from roughcontact.report.presentation import presentation_of
from roughcontact.surface import form

STEEL = rc.Material(210e9, 0.3, 1e9)
PIXEL = (1e-6, 1e-6)


def patch(side: int, rolloff: float, *seed: int) -> rc.Surface:
    # The whole has the requested RMS height; a small part is as free as one of an endless surface.
    heights = rc.self_affine(
        (4 * side, 4 * side),
        PIXEL,
        rms_height=0.3e-6,
        rolloff_wavelength=rolloff,
        cutoff_wavelength=4e-6,
        rng=np.random.default_rng(seed),
    )
    return rc.Surface(form.level(heights[:side, :side]), PIXEL)


def study(surface: rc.Surface) -> rc.results.SamplingStudy:
    return rc.sampling_study(surface, material=STEEL, pressure="200 MPa", tolerance=1e-4)


@pytest.mark.long
def test_error_of_map_follows_from_contacts_of_its_parts() -> None:
    surface = patch(64, 8e-6, 1)
    found = study(surface)
    assert sorted(found.levels) == [2, 4]
    parts = rc.partition(surface, 4)
    load = 200e6 * parts[0].size[0] * parts[0].size[1]
    alone = [rc.solve(part, material=STEEL, load=load, tolerance=1e-4) for part in parts[:3]]
    values = found.values(4, "contact_fraction")
    assert values[:3] == [one.contact_fraction for one in alone]
    one = found.error("contact_fraction")
    assert (
        one.half == statistics.parts_interval({n: found.values(n, one.name) for n in (2, 4)}).half
    )
    # The half falls with the root of the area.
    assert one.area == pytest.approx(64e-6**2 * (one.relative / 0.05) ** 2)
    assert one.area_low < one.area < one.area_high
    assert one.drift == pytest.approx(np.mean(values) / one.value - 1)
    # 64 parts, which show whether the scatter falls with the area, need 128 points per side.
    assert math.isnan(one.scaling)
    assert (one.falls, one.bound) == (False, "at least")
    assert all(row[-1] == "16 parts; at least" for row in presentation_of(found).listing()[1])
    assert "at least" in comparison.answer(found)
    assert CautionTag.SAMPLING in {caution.kind for caution in found.cautions}
    assert {error.name for error in found.errors} == {
        "contact_fraction",
        "saturated_fraction",
        "mean_gap",
        "Sq",
        "Sa",
        "Sdq",
    }


@pytest.mark.slow
def test_long_waves_give_sampling_caution() -> None:
    y, x = np.mgrid[:128, :128] / 128
    waves = 1.5e-6 * np.cos(2 * np.pi * (2.5 * x + 0.3)) * np.cos(2 * np.pi * 1.5 * y)
    found = study(rc.Surface(patch(128, 8e-6, 2).heights + waves, PIXEL))
    one = found.error("Sq")
    assert one.scaling > 2
    assert not one.falls
    # Slopes are those of the short waves.
    assert found.error("Sdq").falls
    (caution,) = (c for c in found.cautions if c.kind == CautionTag.SAMPLING)
    assert "Sq" in caution.numbers
    assert "Sdq" not in caution.numbers


def test_map_too_small_for_sixteen_parts_raises_input_error() -> None:
    with pytest.raises(rc.InputError, match="needs 64 points") as caught:
        study(patch(63, 8e-6, 3))
    assert caught.value.argument == "surface"


def test_bracket_gives_errors_under_both_ceilings() -> None:
    film = rc.Layer(83e9, 0.37, 5e-6, hardness="264 MPa", name="silver")
    terms = {
        "material": rc.Material(124e9, 0.34, 180e6, coating=[film]),
        "boundary": "periodic",
        "pressure": "20 MPa",
    }
    surface = rc.Surface(*rc.reference_map(64))
    both = rc.sampling_study(surface, ceiling="bracket", **terms)
    assert both.base is not None
    for study, ceiling in ((both, "coating"), (both.base, "base")):
        # NaN differs from itself.
        alone = rc.sampling_study(surface, ceiling=ceiling, **terms)
        assert repr(study.errors) == repr(alone.errors)
    table = both.to_pandas()
    first = table["quantity"] == "contact_fraction"
    assert table["ceiling"][first].tolist() == ["coating", "base"]
    assert table["value"][first].tolist() == [
        study.error("contact_fraction").value for study in (both, both.base)
    ]
    assert "under that of the base" in str(both)
