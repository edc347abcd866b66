"""Laws of preparation, filters and units that hold for all inputs."""

import contextlib
import io
import math
import shlex
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

from maps import rough
from roughcontact import units
from roughcontact.cli import app
from roughcontact.errors import InputError
from roughcontact.formats.read import read_surface
from roughcontact.surface import cleaning, filters
from roughcontact.surface.cleaning import fill_missing
from roughcontact.surface.form import level
from roughcontact.surface.surface import Surface

SEEDS = st.integers(0, 10_000)
HOLES = st.sampled_from([0.0, 0.2])
PIXEL = (2e-6, 3e-6)
SHAPE = (15, 19)

# The first example of each kind imports SciPy or builds pint's registry.
UNHURRIED = settings(deadline=None)

# Forms that a second fit finds nothing of. "robust" ends within its own tolerance.
LINEAR = ("mean", "plane", "quadric")


def surface(seed: int, holes: float = 0.0) -> Surface:
    return Surface(1e-9 * rough(seed, SHAPE, holes), PIXEL)


def outcome(call: Callable[[], Any]) -> Any:
    """Return the result of a call, or the message of its InputError."""
    try:
        return call()
    except InputError as error:
        return str(error)


# --- preparation --------------------------------------------------------------------------------


@UNHURRIED
@given(SEEDS, HOLES, st.sampled_from([*LINEAR, "robust", "three-point"]))
def test_level_finds_nothing_the_second_time(seed: int, holes: float, form: str) -> None:
    heights = rough(seed, SHAPE, holes)
    points = [(0, 0), (3, 17), (14, 4)] if form == "three-point" else None
    for y, x in points or ():
        heights[y, x] = 1.0 + x
    once = level(heights, form, points)
    # The weights of the robust fit settle to 1e-6 of its scatter.
    tolerance = 1e-5 if form == "robust" else 1e-13
    np.testing.assert_allclose(level(once, form, points), once, atol=tolerance)


@UNHURRIED
@given(SEEDS, SEEDS, HOLES, st.floats(-5, 5), st.floats(-5, 5), st.sampled_from(LINEAR))
def test_level_is_linear(
    first: int, second: int, holes: float, a: float, b: float, form: str
) -> None:
    u, v = rough(first, SHAPE, holes), rough(second, SHAPE)
    both = level(a * u + b * v + 0 * u, form)
    # The fit to the points that u has.
    parts = a * level(u, form) + b * level(v + 0 * u, form)
    np.testing.assert_allclose(both, parts, atol=1e-12)


@UNHURRIED
@given(SEEDS, st.floats(0.05, 0.6), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_filling_is_linear_and_final(seed: int, holes: float, scale: float, offset: float) -> None:
    heights = rough(seed, SHAPE, holes)
    filled = fill_missing(heights, PIXEL)
    assert fill_missing(filled, PIXEL).tobytes() == filled.tobytes()
    # Below the smallest normal number the last digit is no small part.
    size = max(abs(scale) + abs(offset), 1e-280)
    np.testing.assert_allclose(
        fill_missing(scale * heights + offset, PIXEL),
        scale * filled + offset,
        rtol=0,
        atol=1e-11 * size,
    )
    np.testing.assert_allclose(
        fill_missing(cleaning.rotate_map(heights), PIXEL[::-1]),
        cleaning.rotate_map(filled),
        atol=1e-11,
    )


@UNHURRIED
@given(SEEDS, HOLES)
def test_preparation_keeps_measured_bits(seed: int, holes: float) -> None:
    given_map = surface(seed, holes)
    there = np.isfinite(given_map.heights)
    before = given_map.heights[there].tobytes()
    assert given_map.filled().heights[there].tobytes() == before
    assert given_map.masked().heights[there].tobytes() == before
    kept = given_map.without_outliers(limit=3).heights
    stays = np.isfinite(kept)
    assert kept[stays].tobytes() == given_map.heights[stays].tobytes()
    assert not (stays & ~there).any()


@UNHURRIED
@given(SEEDS, HOLES, st.floats(1e-3, 1e3), st.floats(-1e3, 1e3))
def test_outliers_do_not_depend_on_unit_and_level(
    seed: int, holes: float, scale: float, offset: float
) -> None:
    heights = rough(seed, SHAPE, holes)
    kept = np.isfinite(cleaning.remove_outliers(heights, 2.5))
    # Only where a deviation meets the limit to the last bits could rounding decide.
    again = np.isfinite(cleaning.remove_outliers(scale * heights + offset * scale, 2.5))
    np.testing.assert_array_equal(kept, again)


# --- filters and resampling ---------------------------------------------------------------------


@UNHURRIED
@given(SEEDS, HOLES, st.floats(6, 30), st.floats(-1e3, 1e3))
def test_long_waves_stay_within_the_map_and_constants_in_them(
    seed: int, holes: float, cutoff: float, offset: float
) -> None:
    heights = rough(seed, SHAPE, holes)
    smooth = filters.gaussian_lowpass(heights, PIXEL, cutoff * 1e-6)
    # Weights are positive and sum to one; the transforms leave rounding.
    assert np.nanmin(heights) - 1e-13 <= np.nanmin(smooth)
    assert np.nanmax(smooth) <= np.nanmax(heights) + 1e-13
    np.testing.assert_array_equal(np.isnan(smooth), np.isnan(heights))
    raised = heights + offset
    atol = 1e-13 * (1 + abs(offset))
    np.testing.assert_allclose(
        filters.gaussian_lowpass(raised, PIXEL, cutoff * 1e-6), smooth + offset, rtol=0, atol=atol
    )
    # The short waves hold nothing of a constant.
    np.testing.assert_allclose(
        filters.gaussian_band(raised, PIXEL, l=cutoff * 1e-6), heights - smooth, rtol=0, atol=atol
    )


@UNHURRIED
@given(SEEDS, SEEDS, *[st.integers(4, 30)] * 2, st.sampled_from(["bandlimited", "spline"]))
def test_resampling_is_linear_and_keeps_constants(
    first: int, second: int, ny: int, nx: int, method: str
) -> None:
    u, v = rough(first, SHAPE), rough(second, SHAPE)
    both = filters.resample(2 * u - 3 * v + 7, (ny, nx), method)
    each = [filters.resample(w, (ny, nx), method) for w in (u, v)]
    np.testing.assert_allclose(both, 2 * each[0] - 3 * each[1] + 7, atol=1e-11)


# --- units --------------------------------------------------------------------------------------

PREFIXES = dict(
    zip(
        ["f", "p", "n", "u", "µ", "m", "c", "d", "", "da", "h", "k", "M", "G", "T", "P"],
        [-15, -12, -9, -6, -6, -3, -2, -1, 0, 1, 2, 3, 6, 9, 12, 15],
        strict=True,
    )
)
UNITS = {"m": "length", "N": "force", "Pa": "pressure", "N/m^2": "pressure", "J/m": "force"}
NUMBERS = st.floats(1e-9, 1e9)


@UNHURRIED
@given(NUMBERS, st.sampled_from(sorted(PREFIXES)), st.sampled_from(sorted(UNITS)))
def test_a_prefix_is_a_power_of_ten(number: float, prefix: str, unit: str) -> None:
    text = f"{number!r} {prefix}{unit}"
    value = units.parse(text, UNITS[unit], "x")
    # The same decimal number, moved by the prefix; one rounding more of the factor.
    digits, _, exponent = repr(number).partition("e")
    expected = float(f"{digits}e{int(exponent or 0) + PREFIXES[prefix]}")
    assert value == pytest.approx(expected, rel=1e-15)
    # Spaces change nothing.
    assert units.parse(f"  {number!r}{prefix}{unit}\t", UNITS[unit], "x") == value


@UNHURRIED
@given(NUMBERS, NUMBERS, st.sampled_from(sorted(UNITS)))
def test_parsing_keeps_order_and_sign(first: float, second: float, unit: str) -> None:
    a, b = (units.parse(f"{n!r} {unit}", UNITS[unit], "x") for n in (first, second))
    assert (a < b) == (first < second)
    assert units.parse(f"-{first!r} {unit}", UNITS[unit], "x", positive=False) == -a


@UNHURRIED
@given(
    # One digit of the largest floats rounds to infinity; the smallest have no 17 digits.
    st.floats(1e-300, 1e300) | st.floats(-1e300, -1e-300) | st.just(0.0),
    st.sampled_from(
        ["m", "N", "Pa", "m²", "m³", "", "N/m", "Ω m", "Ω m²", "m² K/W", "S/m²", "W/(m² K)", "1/m"]
    ),
    st.integers(1, 17),
)
def test_engineering_text_is_that_number(value: float, unit: str, digits: int) -> None:
    text = units.format_engineering(value, unit, digits)
    if unit == "m" and abs(value) < 1e-12:
        assert text == "0 m"
        return
    number, _, suffix = text.partition(" ")
    assert suffix.endswith(unit)
    prefix = suffix.removesuffix(unit)
    # A prefix goes to the first factor, and is raised with it.
    power = {"m²": 2, "m³": 3, "m² K/W": 2}.get(unit, 1)
    exponent = PREFIXES[prefix] * power
    # Half a unit of the last digit, and the rounding of this check.
    bound = 0.5 * 10.0 ** (1 - digits) * abs(value) * (1 + 1e-9) + 1e-15 * abs(value)
    assert abs(float(number) * 10.0**exponent - value) <= bound
    if suffix and value and "e" not in number and unit[0].isalpha():
        # Areas and volumes, whose prefixes lie far apart, from a tenth on.
        assert (1 if power == 1 else 0.1) <= abs(float(number)) < 1000**power


NUMBER_TEXTS = st.sampled_from(
    shlex.split(
        "1 -1 +2.5 .5 5. 1e3 1E-3 1e400 1e99999999999 1e-99999999999 0 -0 0e9999999 nan inf "
        "-Infinity 1,5 1.000,5 1_0 0x10 1e --1 \u0661 \u00bd '' " + "9" * 70
    )
)
UNIT_TEXTS = st.sampled_from(
    [
        *shlex.split(
            "N kN MPa mpa GPa m um \u00b5m \u03bcm N/mm^2 N/mm**2 N^0 N^-0 'm^0 N' N** N^99 /N N/ "
            "N//m 'N N' \u00b7 degC dB delta_degC kg s % percent pixel px furlong \u00e6m \u00c5 "
            "\u2103 'N;' 'lambda: 1' 'N if 1 else m' None e pi in as m3 m\u00b3/m\u00b2 \u00b2 _ "
            "[length] {} N*1e3 '(N)' ''"
        ),
        "N\x00",
        "__import__('os')",
    ]
)
DIMENSIONS = st.sampled_from(["length", "force", "pressure"])


def is_one_sentence(message: str) -> bool:
    return message.isprintable() and 10 < len(message) < 400


@settings(UNHURRIED, max_examples=500)
@given(
    st.builds(
        "{}{}{}".format, NUMBER_TEXTS, st.sampled_from(["", " ", "  ", "\t", "\n"]), UNIT_TEXTS
    )
    | st.text(max_size=80)
    | st.builds("1 {}".format, st.text("NmPaGku\u00b5^*/\u00b7 -23\u00b2\u00b3_e", max_size=12)),
    DIMENSIONS,
    st.booleans(),
)
def test_any_text_is_a_quantity_or_raises_input_error(
    text: str, dimension: str, positive: bool
) -> None:
    value = outcome(lambda: units.parse(text, dimension, "--option", positive=positive))
    if isinstance(value, str):
        assert is_one_sentence(value)
        assert value.startswith("--option ")
        return
    assert math.isfinite(value)
    assert value > 0 or not positive


@UNHURRIED
@given(NUMBERS, st.sampled_from(sorted(PREFIXES)), st.sampled_from(sorted(UNITS)), DIMENSIONS)
def test_wrong_dimension_raises_input_error(
    number: float, prefix: str, unit: str, dimension: str
) -> None:
    assume(UNITS[unit] != dimension)
    with pytest.raises(InputError) as caught:
        units.parse(f"{number:g} {prefix}{unit}", dimension, "--option")
    assert is_one_sentence(str(caught.value))
    assert f"needs a {dimension}" in str(caught.value)
    assert f"(a {UNITS[unit]})" in str(caught.value)


# --- unit mistakes, from the command line and for files -----------------------------------------

# Option, and the dimension that its text must have.
QUANTITIES = {
    "--load": "force",
    "--approach": "length",
    "--young": "pressure",
    "--yield-strength": "pressure",
    "--counter-young": "pressure",
    "--counter-yield-strength": "pressure",
    "--ceiling": "pressure",
    "--size": "length",
}
WRONG = {
    "--unit": shlex.split("N MPa px pixel pica s m^2 m/m 5 quux 'µ m'"),
    "length": shlex.split("'1 N' '1 MPa' 1 '1 m^2' '1 px' '1 s' mm '1,5 mm' '-1 mm' '0 m'"),
    "force": shlex.split(
        "'1 MPa/m' '1 mm' 1 '1 N/m^3' '1 kg' '1 newtonmeter' '1,5 N' '-1 N' '0 N' N"
    ),
    "pressure": shlex.split(
        "'1 N' '1 mm' 210 210e9 '210 gpa' '1 N/mm' '1 kg/mm^2' '-1 GPa' '0 Pa'"
    ),
}


@cache
def map_file() -> Path:
    path = Path(tempfile.mkdtemp()) / "map.npy"
    np.save(path, rough(1, SHAPE))
    return path


def command(option: str, text: str) -> list[str]:
    chosen = {
        "--unit": "um",
        "--size": "1 mm x 1 mm",
        "--load": "1 N",
        "--young": "210 GPa",
        "--poisson": "0.3",
        "--yield-strength": "1 GPa",
        "--counter-poisson": "0.3",
        "--counter-young": "70 GPa",
        "--counter-yield-strength": "1 GPa",
    }
    if option == "--approach":
        del chosen["--load"]
    chosen[option] = text
    words = ["solve", str(map_file())]
    for name, value in chosen.items():
        is_setting = name.startswith("--counter-")
        words += ["--set", f"{name[2:]}={value}"] if is_setting else [name, value]
    return words


@pytest.mark.long
@settings(UNHURRIED, max_examples=60)
@given(st.sampled_from([*sorted(QUANTITIES), "--unit"]), st.data())
def test_unit_mistakes_on_the_command_line_end_in_one_sentence(
    option: str, data: st.DataObject
) -> None:
    text = data.draw(st.sampled_from(WRONG[QUANTITIES.get(option, option)]))
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = app.main(command(option, text))
    assert status == app.BAD_INPUT
    assert out.getvalue() == ""
    message = err.getvalue()
    assert message.startswith("roughcontact: error: ")
    assert message.count("\n") == 1
    assert option.removeprefix("--") in message
    assert text.lstrip("-0 ") in message


@pytest.mark.parametrize(
    ("argument", "text"),
    [*(("unit", text) for text in WRONG["--unit"]), *(("size", text) for text in WRONG["length"])],
)
def test_unit_mistakes_for_a_file_are_input_errors(argument: str, text: str) -> None:
    scale = {"unit": "um", "size": "1 mm x 1 mm", argument: text}
    with pytest.raises(InputError) as caught:
        read_surface(map_file(), **scale)  # type: ignore[arg-type]
    assert is_one_sentence(str(caught.value))
