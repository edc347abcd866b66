"""Text files of other programs: what their heads say is understood, or refused in a sentence."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected, write
from roughcontact.cli import app
from roughcontact.errors import InputError
from roughcontact.formats.read import channels, read_surface
from roughcontact.formats.source import Channel

MATRIX = "1 2 3 4\n5 6 7 8\n9 10 11 12\n"
HEIGHTS = np.arange(1.0, 13).reshape(3, 4)

# Head -> unit [m] of the heights and pixel (dy, dx) [m] of the matrix above.
HEADS = {
    "Gwyddion": (
        "# Channel: Topo\n# Width: 8.000 µm\n# Height: 3.000 µm\n# Value units: nm\n",
        1e-9,
        (1e-6, 2e-6),
    ),
    "Gwyddion in German, with decimal commas": (
        "# Kanal: Topo\n# Breite: 8,000 µm\n# Höhe: 3,000 µm\n# Einheiten: nm\n",
        1e-9,
        (1e-6, 2e-6),
    ),
    "Gwyddion in French": (
        "# Canal : Topo\n# Largeur : 8.0 µm\n# Hauteur : 3 µm\n# Unités : nm\n",
        1e-9,
        (1e-6, 2e-6),
    ),
    "Gwyddion in Japanese": (
        "# チャネル：Topo\n# 幅: 8 µm\n# 高さ： 3 µm\n# 値の単位: nm\n",
        1e-9,
        (1e-6, 2e-6),
    ),
    "SPIP": (
        "# File Format = ASCII\n# Created by SPIP 6.3\n# x-pixels = 4\n# y-pixels = 3\n"
        "# x-length = 2000\n# y-length = 1500\n# x-offset = 0\n# z-unit = nm\n# voidpixels =0\n"
        "# Start of Data:\n",
        1e-9,
        (500e-9, 500e-9),
    ),
    "SPIP without a unit": (
        "# File Format = ASCII\n# x-pixels = 4\n# y-pixels = 3\n# x-length = 400\n"
        "# y-length = 600\n# Bit2nm = 0.5\n# Start of Data:\n",
        0.5e-9,
        (200e-9, 100e-9),
    ),
    "Attocube": (
        "# Daisy frame view snapshot\n# 2009-07-14T10:12:34\n# x-pixels: 4\n# y-pixels: 3\n"
        "# x-length: 8\n# y-length: 3\n# x-unit: um\n# y-unit: um\n# z-unit: nm\n# display: Topo\n",
        1e-9,
        (1e-6, 2e-6),
    ),
    "Nova": (
        "File Format = ASCII\nCreated by Nova\nNX = 4\nNY = 3\nScale X = 0.5\nScale Y = 0.25\n"
        "Unit X = um\nUnit Data = nm\nScale Data = 2\nDataScaleNeeded = no\nStart of Data :\n",
        2e-9,
        (0.25e-6, 0.5e-6),
    ),
    "Koala": (
        "h=3 w=4\npixel size=2.5e-07 m\ndata unit=rad\nheight conversion factor (-> m)=2e-08\n",
        2e-8,
        (2.5e-7, 2.5e-7),
    ),
}


@pytest.mark.parametrize("name", HEADS)
def test_unit_and_pixel_are_those_of_the_head(tmp_path: Path, name: str) -> None:
    head, metre, pixel = HEADS[name]
    path = write(tmp_path, "map.txt", head + MATRIX)
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, HEIGHTS * metre, rtol=1e-12)
    assert surface.pixel == pytest.approx(pixel)
    (channel,) = channels(path)
    assert channel.shape == (3, 4)
    assert channel.is_height
    assert_rejected(path, "contains its size", size="1 mm x 1 mm", kind=InputError)
    larger = read_surface(path, size="1 mm x 1 mm", override_size=True)
    assert larger.size == (1e-3, 1e-3)
    assert "as the file gives them" in larger.provenance.steps[-1]


def test_decimal_comma_is_read_in_head_and_numbers(tmp_path: Path) -> None:
    head = HEADS["Gwyddion in German, with decimal commas"][0]
    text = head + "1,5e-9\t2,5e-9\t-3e-9\n4,0e-9\t5,25e-9\t6e-9\n"
    path = write(tmp_path, "map.txt", text.replace("nm", "m"))
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, [[1.5e-9, 2.5e-9, -3e-9], [4e-9, 5.25e-9, 6e-9]])


def test_lines_of_wyko_run_along_y(tmp_path: Path) -> None:
    lines = [
        "Wyko ASCII Data File Format 0\t{flag}\t1",
        "X Size\t4",
        "Y Size\t3",
        "Block Name\tType\tLength\tValue",
        "Pixel_size\t7\t4\t0.002",
        "Aspect\t7\t4\t1.5",
        "Wavelength\t7\t4\t632.8",
        "Mult\t7\t4\t2",
        "RAW_DATA\t3\t48\t",
        "1\t2\t3",
        "4\tBad\t6",
        "7\t8\t9",
        "10\t11\t12",
    ]
    text = "\n".join(lines) + "\n"
    for flag, metre in ((1, 1e-9), (0, 316.4e-9)):
        surface = read_surface(write(tmp_path, "map.asc", text.replace("{flag}", str(flag))))
        assert surface.shape == (3, 4)
        assert surface.pixel == pytest.approx((2e-6, 3e-6))
        assert np.isnan(surface.heights[1, 1])
        np.testing.assert_allclose(surface.heights[0], np.array([1, 4, 7, 10]) * metre)


def test_unit_argument_overrides_file_and_adds_step(tmp_path: Path, capsys) -> None:
    path = write(tmp_path, "map.txt", HEADS["Gwyddion"][0] + MATRIX)
    surface = read_surface(path, unit="um")
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6)
    result = "read: heights in um, as given, instead of nm in the file"
    assert surface.provenance.steps == (result,)
    assert read_surface(path, unit="nm").provenance.steps == ()
    assert app.main(["info", str(path), "--verbose"]) == app.SOLVED
    shown = capsys.readouterr().out
    assert "0: Topo [nm]" in shown
    assert "3 µm × 8 µm" in shown


@pytest.mark.parametrize(
    ("head", "words"),
    [
        (
            "# Channel: Phase\n# Width: 4 µm\n# Height: 3 µm\n# Value units: deg\n",
            "holds 'Phase' in 'deg', no heights",
        ),
        (
            "h=4 w=3\npixel size=1e-7 m\nheight conversion factor (-> m)=1\n",
            "announces 4 × 3 points, but has 3 × 4",
        ),
        ("# Width: 4 µV\n# Height: 3 µm\n# Value units: nm\n", "states its scale wrongly"),
        (
            "# x-pixels: 4\n# y-pixels: 3\n# x-unit: um\n# y-unit: nm\n# z-unit: nm\n",
            "along x in 'um' and along y in 'nm'",
        ),
    ],
)
def test_contradictory_heads_raise_error(tmp_path: Path, head: str, words: str) -> None:
    text = MATRIX.replace(" ", "\t")
    assert_rejected(
        write(tmp_path, "map.txt", head.replace("title", "title") + text), words.split("'")[0]
    )


def test_missing_head_fields_raise_input_error(tmp_path: Path) -> None:
    head = "# Channel: Topo\n# Width: 8 µm\n# Height: 3 µm\n"
    path = write(tmp_path, "map.txt", head + MATRIX)
    assert_rejected(path, "gives no unit of the heights", kind=InputError)
    assert read_surface(path, unit="nm").pixel == pytest.approx((1e-6, 2e-6))
    for sides in ("# Width: 4\n# Height: 3\n", "# Width: 4 \n# Height: 3 um\n"):
        assert_rejected(
            write(tmp_path, "map.txt", sides + MATRIX), "gives no unit", kind=InputError
        )
        given = {"unit": "nm", "size": "3 um x 8 um"}
        assert read_surface(tmp_path / "map.txt", **given).pixel == pytest.approx((1e-6, 2e-6))
    remark = write(tmp_path, "plain.txt", "# Height of a hill\n" + MATRIX)
    assert channels(remark) == (Channel("", "", True, (3, 4)),)


def test_several_maps_in_one_file_raise_error(tmp_path: Path) -> None:
    text = HEADS["Gwyddion"][0] + MATRIX
    assert_rejected(
        write(tmp_path, "map.txt", text + "\n" + text), "several maps, another from line 9 on"
    )


# Points x, y, z


def list_of_points(order: str = "", head: str = "") -> str:
    points = [(0.5 * i, 0.25 * j, 10.0 * j + i) for j, i in itertools.product(range(3), range(4))]
    if order == "columns":
        points.sort()
    if order == "mixed":
        points = points[1::2] + points[::2]
    return head + "".join(f"{x}\t{y}\t{z}\n" for x, y, z in points)


GRID = np.array([[10.0 * j + i for i in range(4)] for j in range(3)])


@pytest.mark.parametrize("order", ["", "columns", "mixed"])
@pytest.mark.parametrize(
    ("head", "lateral", "metre"),
    [
        ("# Channel: Height\n# Lateral units: µm\n# Value units: nm\n", 1e-6, 1e-9),
        ("X [mm];Y [mm];Z [um]\n", 1e-3, 1e-6),
        ("", 1e-6, 1e-6),
    ],
)
def test_points_on_a_grid(
    tmp_path: Path, order: str, head: str, lateral: float, metre: float
) -> None:
    path = write(tmp_path, "map.xyz", list_of_points(order, head))
    surface = read_surface(path, unit=None if head else "um")
    np.testing.assert_allclose(surface.heights, GRID * metre, rtol=1e-12)
    assert surface.pixel == pytest.approx((0.25 * lateral, 0.5 * lateral))
    assert "read: 12 points x, y, z placed on their grid" in surface.provenance.steps
    assert channels(path)[0].shape == (3, 4)


def test_points_without_head_are_read_with_missing_points(tmp_path: Path) -> None:
    lines = list_of_points().splitlines()
    text = "\n".join([*lines[:5], *lines[6:8], "0.0 0.5 nan", *lines[9:]]).replace("\t", " ")
    surface = read_surface(write(tmp_path, "map.txt", text + "\n"), unit="um")
    assert surface.shape == (3, 4)
    assert surface.missing == 2
    assert "1 of it without a point" in surface.provenance.steps[-1]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            list_of_points() + "0.5 0.25 3\n".replace(" ", "\t"),
            "1 points of its grid more than once",
        ),
        (list_of_points().replace("1.5", "1.63"), "x is not evenly spaced"),
        ("".join(f"{i}\t{i}\t{i}\n" for i in range(20)), "fill no grid"),
        ("".join(f"{i}\t1\t{i}\n" for i in range(20)), "all have the same y"),
        (list_of_points().replace("0.25", "nan"), "x or y is missing"),
    ],
)
def test_points_that_make_no_map(tmp_path: Path, text: str, words: str) -> None:
    assert_rejected(write(tmp_path, "map.xyz", text), words, unit="um")
