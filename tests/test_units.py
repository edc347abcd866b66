import math
import subprocess
import sys

import pytest
from hypothesis import given, strategies as st

from roughcontact import units
from roughcontact.errors import InputError


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("1 N", "force", 1.0),
        ("1e3 N", "force", 1e3),
        ("2.5kN", "force", 2.5e3),
        ("5 mN", "force", 5e-3),
        ("1 lbf", "force", 4.4482216152605),
        ("1 kg*m/s^2", "force", 1.0),
        ("210 GPa", "pressure", 210e9),
        ("1 psi", "pressure", 6894.757293168361),
        ("3 N/mm^2", "pressure", 3e6),
        ("3 N/mm**2", "pressure", 3e6),
        ("3 N/mm²", "pressure", 3e6),
        ("1 mPa", "pressure", 1e-3),
        ("5 \u00b5m", "length", 5e-6),
        ("5 \u03bcm", "length", 5e-6),
        ("5 um", "length", 5e-6),
        ("7\u00a0nm", "length", 7e-9),
        ("1 inch", "length", 25.4e-3),
        ("2 in", "length", 50.8e-3),
        ("1 mil", "length", 25.4e-6),
        ("3 N/mm2", "pressure", 3e6),
        ("210 kN/mm2", "pressure", 210e9),
        ("1e-12 ohm m2", "film", 1e-12),
        (".5 m", "length", 0.5),
        ("5. mm", "length", 5e-3),
        ("600 N/mm", "line load", 6e5),
        ("0.6 kN/mm", "line load", 6e5),
        ("20000 N/m", "line load", 2e4),
        ("2 m2 K/W", "thermal film", 2.0),
        ("4e-15 m2/N", "wear coefficient", 4e-15),
        ("1 mm3/Nm", "wear coefficient", 1e-9),
        ("1 mm³/(N·m)", "wear coefficient", 1e-9),
        ("1 mm^3/N/m", "wear coefficient", 1e-9),
    ],
)
def test_parse_accepts_usual_notations(text: str, dimension: str, value: float) -> None:
    # One rounding in the number, one in the factor, one in their product.
    assert units.parse(text, dimension, "x") == pytest.approx(value, rel=5e-16)


@pytest.mark.parametrize(
    ("text", "dimension", "words"),
    [
        ("1 MPa", "force", "--load needs a force with its unit such as '1 N', got '1 MPa' (a p"),
        ("5 kg", "force", "(a mass)"),
        ("20 degC", "pressure", "(a temperature)"),
        ("210", "pressure", "has no unit"),
        ("210 gpa", "pressure", "did you mean 'GPa'"),
        ("1 pa", "pressure", "did you mean 'Pa'"),
        ("1 furlongs_per_moon", "length", "unknown"),
        ("1,5 N", "force", "decimal point"),
        ("1,000 N", "force", "decimal point"),
        ("inf N", "force", "not a finite number"),
        ("-nan N", "force", "not a finite number"),
        ("1e999 N", "force", "not a finite number"),
        ("3 mm 4", "length", "not one number and one unit"),
        ("9**9**9 N", "force", "not one number and one unit"),
        ("1 N**99", "force", "not one number and one unit"),
        ("1 N\n2 N", "force", "not one number and one unit"),
        ("1 __import__('os')", "force", "not one number and one unit"),
        ("N", "force", "needs a force"),
        ("", "force", "empty"),
        ("   ", "force", "empty"),
        ("1 " + "N*" * 10_000 + "N", "force", "needs a force"),
        ("1e9999999 N", "force", "not a finite number"),
        ("1e99999999999999999999 N", "force", "not a finite number"),
        ("1e-99999999999999999999 N", "force", "must be positive"),
        ("1 N^0", "force", "not one number and one unit"),
        ("1 px", "length", "(a printer's unit)"),
        ("2 pica", "length", "(a printer's unit)"),
        ("1 J/m", "length", "(a force)"),
        ("1 N/m^3*m", "force", "(a pressure)"),
        ("1 Hz", "force", "(of dimension 1 / [time])"),
        ("0 N", "force", "must be positive"),
        ("\u22121 N", "force", "must be positive"),
    ],
)
def test_invalid_text_raises_input_error_in_one_sentence(
    text: str, dimension: str, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        units.parse(text, dimension, "--load")
    message = str(caught.value)
    assert words in message
    assert message.startswith("--load ")
    assert "\n" not in message
    assert len(message) < 250


def test_parse_allows_any_sign_with_option() -> None:
    assert units.parse("-2 um", "length", "--shift", positive=False) == -2e-6
    assert units.parse("0 N", "force", "--load", positive=False) == 0.0


@pytest.mark.parametrize(
    ("value", "unit", "digits", "text"),
    [
        (3e9, "Pa", 4, "3 GPa"),
        (2.31e-7, "m", 4, "231 nm"),
        (-1.5e-6, "m", 4, "-1.5 µm"),
        (0.0, "N", 4, "0 N"),
        (-0.0, "N", 4, "0 N"),
        (math.nan, "Pa", 4, "nan Pa"),
        (-math.inf, "Pa", 4, "-inf Pa"),
        (999.96, "N", 4, "1 kN"),
        (123456.0, "N", 2, "120 kN"),
        (1e-12, "m²", 4, "1 µm²"),
        (2.5e-9, "m²", 4, "2500 µm²"),
        (1.233e-7, "m²", 4, "0.1233 mm²"),
        (9.9999e-8, "m²", 4, "0.1 mm²"),
        (2.858e-13, "m²", 4, "0.2858 µm²"),
        (0.01234567, "", 4, "0.01235"),
        (1e30, "Pa", 4, "1e+30 Pa"),
        (1e-13, "Ω m²", 4, "100 fΩ m²"),
        (3e9, "S/m²", 4, "3 GS/m²"),
        (2e-5, "m² K/W", 4, "20 mm² K/W"),
    ],
)
def test_engineering(value: float, unit: str, digits: int, text: str) -> None:
    assert units.format_engineering(value, unit, digits) == text


@given(
    st.floats(min_value=1e-13, max_value=1e15) | st.floats(min_value=-1e15, max_value=-1e-13),
    st.sampled_from([("m", "length"), ("N", "force"), ("Pa", "pressure")]),
)
def test_parse_reads_format_engineering(value: float, kind: tuple[str, str]) -> None:
    unit, dimension = kind
    text = units.format_engineering(value, unit, digits=17)
    # 17 digits carry a float exactly; the factor of the prefix rounds twice.
    assert units.parse(text, dimension, "x", positive=False) == pytest.approx(value, rel=5e-16)


def test_a_plain_unit_has_the_factor_that_pint_has() -> None:
    registry = units._registry()
    for dimension, factors in units._PLAIN.items():
        for unit, factor in factors.items():
            wanted = registry.parse_units(units._DIMENSIONS[dimension][0])
            found = registry.convert(1.0, registry.parse_units(unit), wanted)
            # Older versions of pint are off in the last digit.
            assert factor == pytest.approx(found, rel=5e-16), unit


@pytest.mark.parametrize("wanted", units._DIMENSIONS)
def test_plain_unit_raises_same_error_as_pint(wanted: str, monkeypatch: pytest.MonkeyPatch) -> None:
    given = [unit for kind, factors in units._PLAIN.items() if kind != wanted for unit in factors]

    def refusals() -> list[str]:
        found = []
        for unit in given:
            with pytest.raises(InputError) as caught:
                units.parse(f"3 {unit}", wanted, "x")
            found.append(str(caught.value))
        return found

    plain = refusals()
    monkeypatch.setattr(units, "_PLAIN", {})
    assert plain == refusals()


def test_a_plain_unit_is_read_without_pint() -> None:
    code = (
        "import sys; from roughcontact.units import parse; "
        "parse('20 MPa', 'pressure', 'load'), parse('5 µm', 'length', 'size')\n"
        "try: parse('20 MPa', 'force', 'load')\n"
        "except ValueError: sys.exit('pint' in sys.modules)\n"
        "sys.exit('not refused')"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0, "0 %"),
        (1, "100 %"),
        (0.5, "50.0 %"),
        (0.0338058, "3.38 %"),
        (0.99967, "99.9670 %"),
        (1e-8, "< 0.0001 %"),
        (1 - 1e-6, "99.9999 %"),
        (0.0009399, "0.0940 %"),
    ],
)
def test_percentages_never_round_to_all_or_nothing(share: float, text: str) -> None:
    assert units.format_percent(share) == text


def test_errors_keep_argument_and_value() -> None:
    for text in ("1", "0 N", "1 m", ""):
        with pytest.raises(InputError) as caught:
            units.parse(text, "force", "load")
        assert (caught.value.argument, caught.value.value) == ("load", text)
        assert str(caught.value).startswith("load ")
    with pytest.raises(InputError, match=r"^load needs a weight, got '1 m'"):
        units.parse("1 m", "force", "load", needs="a weight")


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        ("1.85 GPa", "2.4 GPa", "1.85 to 2.40 GPa"),
        ("2 %", "2.4 %", "2.0 to 2.4 %"),
        ("9.8 %", "12 %", "9.8 to 12 %"),
        ("950 nm", "1.05 µm", "950 nm to 1.05 µm"),
        ("1.5e-06", "2e-05", "1.5e-06 to 2.0e-05"),
        ("0", "0.25", "0 to 0.25"),
        ("< 0.0001 %", "1.5 %", "< 0.0001 % to 1.5 %"),
        ("98 %", "100 %", "98 to 100 %"),
    ],
)
def test_ends_of_an_interval_have_equal_digits(low: str, high: str, text: str) -> None:
    assert units.join_ends(low, high) == text


def test_ends_have_a_least_number_of_digits() -> None:
    assert units.join_ends("2 %", "3 %", 2) == "2.0 to 3.0 %"
    assert units.join_ends("0.2 %", "100 %", 2) == "0.20 to 100 %"
    assert units.join_ends("0 %", "12 %", 2) == "0 to 12 %"
