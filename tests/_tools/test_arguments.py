"""Numbers with their units, as text or of pint, wherever the public face takes a number."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pint
import pytest

import roughcontact as rc
from roughcontact._tools.arguments import set_fields
from roughcontact.cautions import CautionTag, Severity
from roughcontact.errors import InputError
from roughcontact.surface import nominal_bodies

UNIT = pint.UnitRegistry()
PIXEL = (1e-6, 1e-6)
STEEL = rc.Material(210e9, 0.3, 1e9)
BALL = nominal_bodies.sphere(radius=0.01, shape=(32, 32), pixel=PIXEL)


def test_material_accepts_units() -> None:
    for young, strength in (("210 GPa", "1e3 MPa"), (210 * UNIT.GPa, 1 * UNIT.kN / UNIT.mm**2)):
        assert rc.Material(young, 0.3, strength) == STEEL
    assert rc.Material("300 GPa", 0.25, hardness="700 HV").hardness == pytest.approx(
        7.40e9, rel=1e-3
    )
    assert rc.Material("300 GPa", 0.25, hardness="15 GPa").hardness == 15e9
    assert rc.hardening.Perfect("1 GPa") == rc.hardening.Perfect(1e9)
    assert rc.hardening.Linear("1 GPa", 2 * UNIT.GPa) == rc.hardening.Linear(1e9, 2e9)
    assert rc.hardening.Swift("945 MPa", 20, 0.121) == rc.hardening.Swift(945e6, 20, 0.121)
    table = rc.hardening.Tabulated((0.0, 0.1), ("1 GPa", "1.2 GPa"))
    assert (
        table
        == rc.hardening.Tabulated([0.0, 0.1], [1.0, 1.2] * UNIT.GPa)
        == rc.hardening.Tabulated((0.0, 0.1), (1e9, 1.2e9))
    )


def test_map_accepts_units() -> None:
    micrometres = np.arange(12.0).reshape(3, 4)
    for pixel in (("1 um", "2 um"), (1 * UNIT.um, 2e-6), [1.0, 2.0] * UNIT.um):
        surface = rc.Surface(micrometres * UNIT.um, pixel)
        np.testing.assert_allclose(surface.heights, 1e-6 * micrometres, rtol=1e-15)
        assert surface.pixel == (1e-6, 2e-6)
    rough = rc.Surface(*rc.reference_map(64))
    edge = rough.pixel[0]
    assert rough.resampled(pixel=(2 * edge * UNIT.m, f"{2 * edge} m")).shape == (32, 32)
    short = rough.filtered(s="10 um")
    assert np.array_equal(short.heights, rough.filtered(s=1e-5).heights)
    assert short.provenance == rough.filtered(s=1e-5).provenance
    assert rough.aligned(rough, offset=("5 um", "0 um")).provenance == (
        rough.aligned(rough, offset=(5e-6, 0.0)).provenance
    )
    with_unit = nominal_bodies.sphere(radius="10 mm", shape=(32, 32), pixel=("1 um", "1 um"))
    assert with_unit.provenance == BALL.provenance
    made = {"rolloff_wavelength": "20 um", "cutoff_wavelength": "4 um"}
    heights = rc.self_affine(32, PIXEL, rms_height="0.1 um", **made, rng=1)
    assert float(np.std(heights)) == pytest.approx(1e-7)


@pytest.mark.parametrize("load", ["100 mN", 0.1 * UNIT.N, 100 * UNIT.mN, "1e-1 kg m/s^2"])
def test_load_accepts_units(load: object) -> None:
    expected = rc.solve(BALL, material=STEEL, load=0.1)
    found = rc.solve(BALL, material=STEEL, load=load)
    assert found.load == expected.load == 0.1
    np.testing.assert_array_equal(found.pressure, expected.pressure)


def test_every_task_accepts_units() -> None:
    result = rc.solve(BALL, material=STEEL, approach="10 nm", ceiling="2 GPa")
    assert (result.approach, result.ceiling) == (1e-8, 2e9)
    tilted = rc.solve(BALL, material=STEEL, load="0.1 N", moments=("0 N m", "1e-5 N mm"))
    assert tilted.moments == (0.0, 1e-8)
    assert rc.solve(BALL, material=STEEL, load=1, ceiling="700 HV").ceiling == pytest.approx(
        7.4e9, rel=1e-3
    )
    curve = rc.sweep(BALL, material=STEEL, loads=["10 mN", 0.1 * UNIT.N])
    assert curve.column("load").tolist() == [0.01, 0.1]
    curve = rc.sweep(BALL, material=STEEL, approaches=[1, 2] * UNIT.nm)
    assert curve.column("approach") == pytest.approx([1e-9, 2e-9])
    stage = rc.Stage(approach="10 nm", shift=("0 um", 1 * UNIT.um))
    assert stage == rc.Stage(approach=1e-8, shift=(0.0, 1e-6))
    history = rc.history(BALL, ["10 mN", 0.0 * UNIT.N, 0.01], material=STEEL)
    assert [step.load for step in history.steps] == [0.01, 0.0, 0.01]
    stress = rc.subsurface_stress(result, ["1 um", 2 * UNIT.um])
    assert stress.profile.depths.tolist() == [1e-6, 2e-6]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rc.solve(BALL, material=STEEL, load="5 mm"), "load needs a load .* '5 mm' .a le"),
        (lambda: rc.solve(BALL, material=STEEL, load="50"), "got '50' which has no unit"),
        (lambda: rc.solve(BALL, material=STEEL, load=5 * UNIT.mm), "got a quantity in millimeter"),
        (lambda: rc.solve(BALL, material=STEEL, load="-1 N"), "load must be positive"),
        (lambda: rc.solve(BALL, material=STEEL, load=1.0, ceiling="soft"), "'auto', 'calibr"),
        (lambda: rc.solve(BALL, material=STEEL, load=1.0, ceiling="1 mm"), "ceiling needs"),
        (lambda: rc.Material("210", 0.3), "young needs a pressure"),
        (lambda: rc.Material("-210 GPa", 0.3), "young must be positive"),
        (lambda: rc.Material(210e9, 0.3, hardness="99 HRC"), "^hardness: 99 HRC is outside"),
        (lambda: rc.Surface(np.ones((3, 3)) * UNIT.N, PIXEL), "heights needs a length"),
        (lambda: rc.history(BALL, ["1 m"], material=STEEL), "stage 1: load needs a load"),
    ],
)
def test_wrong_dimension_raises_input_error(call: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        call()  # type: ignore[operator]


@pytest.mark.parametrize(
    ("surface", "material", "name"),
    [
        (BALL, rc.Material(210, 0.3), "young"),
        (BALL, rc.Material(210e9, 0.3, 1000), "yield_over_young"),
        (rc.Surface(1e6 * BALL.heights, PIXEL), STEEL, "slope"),
        (rc.Surface(1e6 * BALL.heights, (1.0, 1.0)), STEEL, "side"),
    ],
)
def test_a_number_in_another_unit_is_suspected(
    surface: rc.Surface, material: rc.Material, name: str
) -> None:
    result = rc.solve(surface, material=material, load=1e-3, ceiling=None)
    (found,) = (caution for caution in result.cautions if caution.kind == CautionTag.UNITS)
    assert found.severity is Severity.WARNING
    assert list(found.numbers) == [name]


def test_moduli_of_solids_raise_no_error() -> None:
    # Rubber, lead, diamond.
    for young, strength in ((2e6, 5e5), (16e9, 5e6), (1.2e12, None)):
        material = rc.Material(young, 0.3, strength)
        result = rc.solve(BALL, material=material, load=1e-9 * young / 1e6)
        assert CautionTag.UNITS not in [caution.kind for caution in result.cautions]


def test_set_fields_rejects_names_without_field() -> None:
    set_fields(steel := replace(STEEL), name="C45")
    assert (steel.name, STEEL.name) == ("C45", "")
    with pytest.raises(AttributeError, match="Material has no field 'color'"):
        set_fields(steel, color="gray")
    for path in Path(rc.__file__).parent.rglob("*.py"):
        assert "vars(self).update" not in path.read_text("utf-8"), path
