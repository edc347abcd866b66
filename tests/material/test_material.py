import math
from dataclasses import FrozenInstanceError, replace

import pytest
from hypothesis import given, strategies as st

from roughcontact.errors import InputError, short_repr
from roughcontact.material.material import RIGID, Material, contact_modulus, softer_material

STEEL = Material(young=210e9, poisson=0.3, yield_strength=1e9)
GLASS = Material(young=70e9, poisson=0.22)
ALUMINA = Material(young=400e9, poisson=0.23, hardness=15e9)

moduli = st.floats(1e3, 1e13)
ratios = st.floats(-0.99, 0.5)


def test_contact_modulus_of_two_bodies() -> None:
    # By hand: 0.91 / 210 + 0.9516 / 70 = 0.0179276 1/GPa, and 55.780 GPa.
    expected = 1 / (0.91 / 210e9 + 0.9516 / 70e9)
    assert expected == pytest.approx(55.780e9, abs=0.001e9)
    assert contact_modulus(STEEL, GLASS) == pytest.approx(expected, rel=1e-14)


@given(moduli, ratios, moduli, ratios)
def test_springs_in_series(e1: float, n1: float, e2: float, n2: float) -> None:
    one, two = Material(e1, n1), Material(e2, n2)
    both = contact_modulus(one, two)
    assert both == contact_modulus(two, one)
    assert both <= min(contact_modulus(one, RIGID), contact_modulus(RIGID, two))
    # A body pressed on its like is twice as soft as on a rigid one.
    assert contact_modulus(one, one) == pytest.approx(contact_modulus(one, RIGID) / 2, rel=1e-14)


@given(moduli, ratios)
def test_a_rigid_body_contributes_nothing(young: float, poisson: float) -> None:
    body = Material(young, poisson)
    expected = pytest.approx(young / (1 - poisson**2), rel=1e-14)
    assert contact_modulus(body, RIGID) == expected
    assert contact_modulus(RIGID, body) == expected
    assert contact_modulus(body, Material(young=math.inf, poisson=0.4)) == expected


def test_rigid_neither_deforms_nor_yields() -> None:
    assert RIGID.compliance == 0
    assert RIGID.yield_strength is None
    assert RIGID.first_yield_pressure is None
    with pytest.raises(InputError, match="both bodies are rigid"):
        contact_modulus(RIGID, Material(young=math.inf, poisson=0.3))


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("young", -math.inf),
        ("young", -2.5),
        ("young", 0),
        ("young", 1e-300),
        ("young", 1e300),
        ("young", 10**400),
        ("poisson", 0.5000001),
        ("poisson", -1.5),
        ("poisson", math.inf),
        ("yield_strength", math.inf),
        ("yield_strength", -3.0),
        ("yield_strength", 10**400),
        ("hardness", 0.0),
        ("hardness", math.nan),
    ],
)
def test_constants_that_no_material_has(argument: str, value: float) -> None:
    with pytest.raises(InputError) as caught:
        Material(**{"young": 210e9, "poisson": 0.3, argument: value})
    assert caught.value.argument == argument
    assert caught.value.value is value
    assert short_repr(value) in str(caught.value)


@pytest.mark.parametrize("poisson", [-0.999, 0.0, 0.5])
def test_the_ends_of_the_range_of_poisson(poisson: float) -> None:
    assert Material(1e9, poisson).compliance == pytest.approx((1 - poisson**2) / 1e9, rel=1e-15)


@pytest.mark.parametrize(
    "constants",
    [
        {"young": "210"},
        {"young": None},
        {"poisson": "0.3"},
        {"yield_strength": "1 N"},
        {"hardness": "62"},
    ],
)
def test_constants_that_are_no_numbers(constants: dict) -> None:
    (name,) = constants
    with pytest.raises(InputError, match=f"{name}.*{constants[name]}"):
        Material(**{"young": 210e9, "poisson": 0.3, **constants})


def test_first_yield_of_a_sphere() -> None:
    # Four figures are printed: 1.615 σ_Y.
    assert STEEL.first_yield_pressure == pytest.approx(1.615e9, abs=0.0005e9)
    assert GLASS.first_yield_pressure is None


@given(ratios, st.floats(1e3, 1e12))
def test_first_yield_formula(poisson: float, strength: float) -> None:
    body = Material(1e9, poisson, strength)
    expected = 1.295 * math.exp(0.736 * poisson) * strength
    assert body.first_yield_pressure == pytest.approx(expected, rel=1e-14)


def test_the_ceiling_is_three_yield_strengths_or_the_hardness() -> None:
    assert STEEL.ceiling == 3e9
    assert ALUMINA.ceiling == 15e9
    assert GLASS.ceiling is None
    # With both, the yield strength decides.
    assert replace(STEEL, hardness=3.5e9).ceiling == 3e9


def test_softer_is_the_body_with_the_smaller_ceiling() -> None:
    assert softer_material(ALUMINA, STEEL) is STEEL
    assert softer_material(STEEL, ALUMINA) is STEEL
    hard = replace(STEEL, yield_strength=6e9)
    assert softer_material(ALUMINA, hard) is ALUMINA
    assert softer_material(ALUMINA, GLASS) is ALUMINA


def test_softer_is_the_body_that_yields_first() -> None:
    weak = Material(young=600e9, poisson=0.2, yield_strength=0.3e9)
    # Stiffness does not matter, nor does the order.
    assert softer_material(STEEL, weak) is weak
    assert softer_material(weak, STEEL) is weak
    assert softer_material(STEEL, GLASS) is STEEL
    assert softer_material(GLASS, STEEL) is STEEL
    assert softer_material(GLASS, RIGID) is None


def test_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        STEEL.young = 1.0
    other = replace(STEEL, yield_strength=None)
    assert other != STEEL
    assert other == Material(210e9, 0.3)
    assert hash(replace(other, yield_strength=1e9)) == hash(STEEL)
    with pytest.raises(InputError, match="poisson"):
        replace(STEEL, poisson=0.6)
