"""Laws of preparation, filters and units that hold for all inputs."""

import contextlib
import io
import math
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

from roughcontact import units
from roughcontact.cli import app
from roughcontact.errors import InputError
from roughcontact.formats.read import read_surface
from roughcontact.surface import cleaning, filters
from roughcontact.surface.cleaning import fill_missing
from roughcontact.surface.form import level, remove_form
from roughcontact.surface.surface import Surface

SEEDS = st.integers(0, 10_000)
HOLES = st.sampled_from([0.0, 0.2])
PIXEL = (2e-6, 3e-6)

# The first example of each kind imports SciPy or builds pint's registry.
UNHURRIED = settings(deadline=None)

# Forms that a second fit finds nothing of. "robust" ends within its own tolerance.
LINEAR = ("mean", "plane", "quadric")


def rough(seed: int, shape: tuple[int, int] = (15, 19), holes: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    heights = rng.normal(size=shape)
    heights[rng.random(shape) < holes] = np.nan
    return heights


def surface(seed: int, holes: float = 0.0) -> Surface:
    return Surface(1e-9 * rough(seed, holes=holes), PIXEL)


def outcome(call: Callable[[], Any]) -> Any:
    """Return what a call returns, or the message with which it refuses."""
    try:
        return call()
    except InputError as error:
        return str(error)


# --- preparation --------------------------------------------------------------------------------


@UNHURRIED
@given(SEEDS, HOLES, st.sampled_from([*LINEAR, "robust", "three-point"]))
def test_level_finds_nothing_the_second_time(seed: int, holes: float, form: str) -> None:
    heights = rough(seed, holes=holes)
    points = [(0, 0), (3, 17), (14, 4)] if form == "three-point" else None
    for y, x in points or ():
        heights[y, x] = 1.0 + x
    once = level(heights, form, points)
    # The weights of the robust fit settle to 1e-6 of its scatter.
    tolerance = 1e-5 if form == "robust" else 1e-13
    np.testing.assert_allclose(level(once, form, points), once, atol=tolerance)


@UNHURRIED
@given(SEEDS, HOLES, st.sampled_from(["sphere", "cylinder", "polynomial"]))
def test_removed_forms_are_not_there_the_second_time(seed: int, holes: float, shape: str) -> None:
    # Of height 1 and radius 50 over a map of 15 × 19.
    y, x = np.mgrid[-7:8, -9:10].astype(float)
    square = x**2 + (0 if shape == "cylinder" else y**2)
    heights = np.sqrt(50**2 - square) + 1e-3 * rough(seed, holes=holes)
    degree = 4 if shape == "polynomial" else None
    once, _ = remove_form(heights, (1.0, 1.0), shape, degree)
    answer = outcome(lambda: remove_form(once, (1.0, 1.0), shape, degree))
    if isinstance(answer, str):
        assert "too flat" in answer or "equal curvatures" in answer
        return
    twice, found = answer
    # What is left of the roughness is flat within three standard errors, or seldom beyond.
    assert abs(found.get("radius", 1e9)) > 1e4
    np.testing.assert_allclose(twice, once, atol=1e-12 if degree else 1e-2)


@UNHURRIED
@given(SEEDS, SEEDS, HOLES, st.floats(-5, 5), st.floats(-5, 5), st.sampled_from(LINEAR))
def test_level_is_linear(
    first: int, second: int, holes: float, a: float, b: float, form: str
) -> None:
    u, v = rough(first, holes=holes), rough(second)
    both = level(a * u + b * v + 0 * u, form)
    # The fit to the points that u has.
    parts = a * level(u, form) + b * level(v + 0 * u, form)
    np.testing.assert_allclose(both, parts, atol=1e-12)


@UNHURRIED
@given(SEEDS, HOLES, st.integers(-5, 5), st.sampled_from([*LINEAR, "robust"]))
def test_level_commutes_with_turns(seed: int, holes: float, turns: int, form: str) -> None:
    heights = rough(seed, holes=holes)
    np.testing.assert_allclose(
        level(cleaning.rotate_map(heights, 90 * turns), form),
        cleaning.rotate_map(level(heights, form), 90 * turns),
        atol=1e-12,
    )


@UNHURRIED
@given(SEEDS, st.integers(-9, 9), st.integers(-9, 9))
def test_turns_add_up(seed: int, first: int, second: int) -> None:
    first, second = 90 * first, 90 * second
    given_map = surface(seed, 0.2)
    turned = given_map.rotated(first).rotated(second)
    at_once = given_map.rotated(first + second)
    assert turned.heights.tobytes() == at_once.heights.tobytes()
    assert turned.pixel == at_once.pixel
    assert given_map.rotated(first).rotated(-first).heights.tobytes() == given_map.heights.tobytes()


@st.composite
def parts(draw: st.DrawFn, length: int) -> tuple[int, int]:
    start = draw(st.integers(0, length - 2))
    return start, draw(st.integers(start + 2, length))


@UNHURRIED
@given(SEEDS, parts(15), parts(19))
def test_crop_commutes_with_turns(
    seed: int, rows: tuple[int, int], columns: tuple[int, int]
) -> None:
    given_map = surface(seed, 0.1)
    nx = given_map.shape[1]
    # A quarter turn counter-clockwise: the last column becomes the first row.
    turned_rows = (nx - columns[1], nx - columns[0])
    first = outcome(lambda: given_map.cropped(rows, columns).rotated())
    if isinstance(first, str):
        assert "no finite value" in first  # nothing but holes
        return
    second = given_map.rotated().cropped(turned_rows, rows)
    assert first.heights.tobytes() == second.heights.tobytes()
    assert first.pixel == second.pixel == PIXEL[::-1]


@UNHURRIED
@given(SEEDS, parts(15), parts(19), st.data())
def test_crop_of_crop_is_crop(
    seed: int, rows: tuple[int, int], columns: tuple[int, int], data: st.DataObject
) -> None:
    heights = rough(seed)
    inner = [data.draw(parts(stop - start)) for start, stop in (rows, columns)]
    twice = cleaning.crop_map(cleaning.crop_map(heights, rows, columns), inner[0], inner[1])
    (r, s), (c, d) = inner
    once = cleaning.crop_map(heights, (rows[0] + r, rows[0] + s), (columns[0] + c, columns[0] + d))
    assert twice.tobytes() == once.tobytes()


@UNHURRIED
@given(SEEDS, st.floats(0.05, 0.6), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_filling_is_linear_and_final(seed: int, holes: float, scale: float, offset: float) -> None:
    heights = rough(seed, holes=holes)
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
    heights = rough(seed, holes=holes)
    kept = np.isfinite(cleaning.remove_outliers(heights, 2.5))
    # Only where a deviation meets the limit to the last bits could rounding decide.
    again = np.isfinite(cleaning.remove_outliers(scale * heights + offset * scale, 2.5))
    np.testing.assert_array_equal(kept, again)


# --- filters and resampling ---------------------------------------------------------------------


@UNHURRIED
@given(SEEDS, SEEDS, HOLES, st.floats(-5, 5), st.floats(-5, 5), st.floats(6, 30))
def test_filters_are_linear(
    first: int, second: int, holes: float, a: float, b: float, cutoff: float
) -> None:
    u, v = rough(first, holes=holes), rough(second)
    v = v + 0 * u
    for kind in ("s", "l"):
        both = filters.gaussian_band(a * u + b * v, PIXEL, **{kind: cutoff * 1e-6})
        each = [filters.gaussian_band(w, PIXEL, **{kind: cutoff * 1e-6}) for w in (u, v)]
        np.testing.assert_allclose(both, a * each[0] + b * each[1], atol=1e-12)


@UNHURRIED
@given(SEEDS, HOLES, st.floats(6, 30), st.floats(-1e3, 1e3))
def test_long_waves_stay_within_the_map_and_constants_in_them(
    seed: int, holes: float, cutoff: float, offset: float
) -> None:
    heights = rough(seed, holes=holes)
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
@given(SEEDS, HOLES, st.floats(6, 28), st.integers(0, 3))
def test_filters_commute_with_turns_and_units(
    seed: int, holes: float, cutoff: float, turns: int
) -> None:
    given_map = surface(seed, holes)
    np.testing.assert_allclose(
        given_map.rotated(90 * turns).filtered(s=cutoff * 1e-6).heights,
        given_map.filtered(s=cutoff * 1e-6).rotated(90 * turns).heights,
        atol=1e-21,
    )
    in_mm = Surface(1e3 * given_map.heights, (2e-3, 3e-3))
    np.testing.assert_allclose(
        in_mm.filtered(s=cutoff * 1e-3).heights,
        1e3 * given_map.filtered(s=cutoff * 1e-6).heights,
        atol=1e-18,
    )


@UNHURRIED
@given(SEEDS, SEEDS, *[st.integers(4, 30)] * 2, st.sampled_from(["bandlimited", "spline"]))
def test_resampling_is_linear_and_keeps_constants(
    first: int, second: int, ny: int, nx: int, method: str
) -> None:
    u, v = rough(first), rough(second)
    both = filters.resample(2 * u - 3 * v + 7, (ny, nx), method)
    each = [filters.resample(w, (ny, nx), method) for w in (u, v)]
    np.testing.assert_allclose(both, 2 * each[0] - 3 * each[1] + 7, atol=1e-11)


@settings(UNHURRIED, max_examples=50)
@given(SEEDS, *[st.integers(5, 60)] * 2)
def test_band_limited_resampling_round_trip_keeps_map(seed: int, ny: int, nx: int) -> None:
    # Waves of at most two periods a side fit on five points and more.
    rng = np.random.default_rng(seed)
    y, x = ((np.arange(n) + 0.5) / n for n in (15, 19))
    heights = sum(
        rng.normal() * np.cos(2 * np.pi * (j * y[:, None] + i * x) + rng.uniform(0, 7))
        for j in range(-2, 3)
        for i in range(3)
    )
    given_map = Surface(1e-9 * heights, PIXEL)
    back = given_map.resampled((ny, nx)).resampled(given_map.shape)
    np.testing.assert_allclose(back.heights, given_map.heights, rtol=0, atol=1e-19)
    assert back.pixel == pytest.approx(PIXEL, rel=1e-14)


@UNHURRIED
@given(SEEDS, st.integers(0, 14), st.integers(0, 18))
def test_band_limited_resampling_moves_with_the_map(seed: int, down: int, right: int) -> None:
    # At twice the points, one old pixel is two new ones.
    heights = rough(seed)
    moved = filters.resample(np.roll(heights, (down, right), (0, 1)), (30, 38))
    finer = filters.resample(heights, (30, 38))
    np.testing.assert_allclose(moved, np.roll(finer, (2 * down, 2 * right), (0, 1)), atol=1e-12)


# --- units --------------------------------------------------------------------------------------

PREFIXES = {
    "f": -15,
    "p": -12,
    "n": -9,
    "u": -6,
    "µ": -6,
    "m": -3,
    "c": -2,
    "d": -1,
    "": 0,
    "da": 1,
    "h": 2,
    "k": 3,
    "M": 6,
    "G": 9,
    "T": 12,
    "P": 15,
}
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
    [
        "1",
        "-1",
        "+2.5",
        ".5",
        "5.",
        "1e3",
        "1E-3",
        "1e400",
        "1e99999999999",
        "1e-99999999999",
        "0",
        "-0",
        "0e9999999",
        "nan",
        "inf",
        "-Infinity",
        "1,5",
        "1.000,5",
        "1_0",
        "0x10",
        "1e",
        "--1",
        "\u0661",
        "\u00bd",
        "9" * 70,
        "",
    ]
)
UNIT_TEXTS = st.sampled_from(
    [
        "N",
        "kN",
        "MPa",
        "mpa",
        "GPa",
        "m",
        "um",
        "\u00b5m",
        "\u03bcm",
        "N/mm^2",
        "N/mm**2",
        "N^0",
        "N^-0",
        "m^0 N",
        "N**",
        "N^99",
        "/N",
        "N/",
        "N//m",
        "N N",
        "\u00b7",
        "degC",
        "dB",
        "delta_degC",
        "kg",
        "s",
        "%",
        "percent",
        "pixel",
        "px",
        "furlong",
        "\u00e6m",
        "\u00c5",
        "\u2103",
        "N\x00",
        "N;",
        "__import__('os')",
        "lambda: 1",
        "N if 1 else m",
        "None",
        "e",
        "pi",
        "in",
        "as",
        "m3",
        "m\u00b3/m\u00b2",
        "\u00b2",
        "_",
        "[length]",
        "{}",
        "N*1e3",
        "(N)",
        "",
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
    "--unit": ["N", "MPa", "px", "pixel", "pica", "s", "m^2", "m/m", "5", "5 um", "quux", "µ m"],
    "length": ["1 N", "1 MPa", "1", "1 m^2", "1 px", "1 s", "mm", "1,5 mm", "-1 mm", "0 m"],
    "force": [
        "1 MPa/m",
        "1 mm",
        "1",
        "1 N/m^3",
        "1 kg",
        "1 newtonmeter",
        "1,5 N",
        "-1 N",
        "0 N",
        "N",
    ],
    "pressure": ["1 N", "1 mm", "210", "210e9", "210 gpa", "1 N/mm", "1 kg/mm^2", "-1 GPa", "0 Pa"],
}


@cache
def map_file() -> Path:
    path = Path(tempfile.mkdtemp()) / "map.npy"
    np.save(path, rough(1))
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
    return ["solve", str(map_file()), *(word for pair in chosen.items() for word in pair)]


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
    assert option in message
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


@pytest.mark.parametrize(
    "pixel",
    [
        (2e-6, "x"),
        ("1 N", "1 N"),
        (0, 1),
        (1e-6,),
        5,
        None,
        "1 um",
        (np.nan, 1),
        (1e-6, math.inf),
        (-1e-6, 1e-6),
        [[1e-6, 1e-6]],
        (1 + 2j, 1),
    ],
)
def test_pixels_that_are_no_lengths_are_input_errors(pixel: object) -> None:
    with pytest.raises(InputError) as caught:
        Surface(rough(1), pixel)  # type: ignore[arg-type]
    assert is_one_sentence(str(caught.value))
