"""Exports whose header describes the values by position."""

from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected, write
from roughcontact.errors import InputError
from roughcontact.formats.read import channels, read_surface
from roughcontact.formats.source import Channel
from roughcontact.surface.surface import Surface

DATA = Path(__file__).parents[1] / "data"


def range_in_um(surface: Surface) -> tuple[float, float]:
    return 1e6 * float(np.nanmin(surface.heights)), 1e6 * float(np.nanmax(surface.heights))


def test_keyence_csv_gives_pixel_and_unit() -> None:
    surface = read_surface(DATA / "keyence_vk.csv")
    assert surface.shape == (16, 24)
    assert surface.pixel == pytest.approx((276.912e-9, 276.912e-9))
    assert range_in_um(surface) == pytest.approx((-0.395, 0.029))
    assert surface.heights.std() == pytest.approx(99.41e-9, rel=1e-4)
    assert channels(DATA / "keyence_vk.csv") == (Channel("Height", "um", True, (16, 24)),)


KEYENCE = """\
"{date}","2026-04-15 00:00:00"
"{model}","VK-X1000 Series"
"{kind}","ImageDataCsv"
"{power}","50"
"XY{calibration}","0{mark}5","μm"
"{image}","{height}"
"{horizontal}","3"
"{vertical}","2"
"{unit}","μm"
"{reference}",""

"{height}"
"1{mark}5","-2{mark}0",""
"3","4","5{mark}25"
"""
# Keys of the four languages, whose words the reader does not know.
KEYS = ["date", "model", "kind", "power", "calibration", "image", "height"]
KEYS += ["horizontal", "vertical", "unit", "reference"]
LANGUAGES = {
    "shift_jis": "測定日時 機種 ファイル種別 倍率 キャリブレーション 出力画像 高さ 横 縦 単位 基準",
    "gb18030": "测量日期 机型 文件类型 倍率 校准 输出图像数据 高度 水平 垂直 单位 基准数据名称",
    "utf-8": "Messdatum Modell Datentyp Leistung -Kalibrierung Bild Höhe Breite Länge Einheit Ref",
    "utf-16": "date model type power calibration image height horizontal vertical unit reference",
}


@pytest.mark.parametrize("encoding", LANGUAGES)
@pytest.mark.parametrize("mark", [".", ","])
def test_keyence_csv_is_read_in_any_language(encoding: str, mark: str, tmp_path: Path) -> None:
    words = dict(zip(KEYS, LANGUAGES[encoding].split(), strict=True))
    text = KEYENCE.format(mark=mark, **words)
    surface = read_surface(write(tmp_path, "export.csv", text.encode(encoding)))
    expected = 1e-6 * np.array([[1.5, -2.0, np.nan], [3.0, 4.0, 5.25]])
    np.testing.assert_allclose(surface.heights, expected)
    assert surface.pixel == pytest.approx((0.5e-6, 0.5e-6))


def test_keyence_csv_with_other_content_raises(tmp_path: Path) -> None:
    words = dict(zip(KEYS, KEYS, strict=True))
    text = KEYENCE.format(mark=".", **words)
    path = write(tmp_path, "laser.csv", text.replace('"unit","μm"', '"unit",""'))
    assert_rejected(path, "holds 'height', no heights")
    path = write(tmp_path, "cut.csv", text[: text.index('"3","4"')])
    assert_rejected(path, "announces 2 × 3 points")


def test_zygo_points_have_camera_resolution_and_missing_points() -> None:
    surface = read_surface(DATA / "zygo_format1.xyz")
    assert (surface.shape, surface.missing) == ((16, 24), 1)
    assert surface.pixel == pytest.approx((5.067e-6, 5.067e-6))
    assert np.nanstd(surface.heights) == pytest.approx(99.47e-9, rel=1e-4)
    # Row 4, column 3, as the line "3 4 No Data" says.
    assert np.isnan(surface.heights[4, 3])


def test_zygo_points_without_resolution_need_size(tmp_path: Path) -> None:
    text = (DATA / "zygo_format1.xyz").read_text().replace("5.067e-06", "0")
    path = write(tmp_path, "map.xyz", text)
    assert_rejected(path, "gives no lengths of its sides", kind=InputError)
    surface = read_surface(path, size=(16e-6, 24e-6))
    assert surface.pixel == pytest.approx((1e-6, 1e-6))


# Scale 0.5, wavelength 600 nm, obliquity 1, pixel 5 um, 32768 phases per wave.
PHASES = """\
Zygo ASCII Data File - Format 2
0 7 4 2 "Fri Jan 02 03:04:05 2026     "
0 0 3 2 1 255
0 0 3 2
"comment # of 81 characters"
""
""
0 0.5 6e-07 0 1 0 5e-06 1700000000
3 2 0 0 0 0 "         "
0 1 0 0 0 0 0 1 0 7
1 1 20 2 0 0 0 0 0
0 "            "
1 0
"       "
#
12 13 14 15
16 17
#
32768 -65536 2147483640 0
16384 98304
#
"""


def test_zygo_phases_are_heights_by_wavelength_and_scale(tmp_path: Path) -> None:
    path = write(tmp_path, "map.dat", PHASES)
    surface = read_surface(path)
    heights = [[0.3, -0.6, np.nan], [0, 0.15, 0.9]]
    np.testing.assert_allclose(1e6 * surface.heights, heights)
    assert surface.pixel == pytest.approx((5e-6, 5e-6))
    assert channels(path) == (Channel("", "m", True, (2, 3)),)
    coarse = write(tmp_path, "map.asc", PHASES.replace("\n1 1 20", "\n0 1 20"))
    np.testing.assert_allclose(1e6 * read_surface(coarse).heights, 8 * np.array(heights))
    unknown = write(tmp_path, "size.asc", PHASES.replace("5e-06", "0"))
    assert read_surface(unknown, size=(2e-6, 3e-6)).pixel == pytest.approx((1e-6, 1e-6))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (PHASES.replace("98304", ""), "cannot reshape array"),
        (PHASES.replace("\n1 1 20", "\n7 1 20"), "phases of Zygo"),
        (PHASES.replace("Format 2", "Format 1"), "export it as XYZ or .dat"),
        (PHASES[:300], "phases of Zygo"),
    ],
)
def test_other_zygo_phases_are_rejected(text: str, words: str, tmp_path: Path) -> None:
    assert_rejected(write(tmp_path, "map.asc", text), words)


def test_points_have_a_lateral_and_a_height_unit() -> None:
    surface = read_surface(DATA / "mountains_points.txt", unit="mm, um")
    assert surface.shape == (5, 4)
    assert surface.pixel == pytest.approx((1e-3, 1e-3))
    values = np.loadtxt(DATA / "mountains_points.txt")
    expected = values[np.lexsort((values[:, 0], values[:, 1])), 2].reshape(5, 4)
    np.testing.assert_allclose(surface.heights, 1e-6 * expected)


@pytest.mark.parametrize(
    ("head", "row", "unit"),
    [
        ("X [mm] Y [mm] Z [um]\n", "{} {} {}", None),
        ("Points of a scan\nx;y;z\n", "{};{};{}", "mm, um"),
        ("Points of a scan\n", "{}\t{}\t{}", "mm, um"),
    ],
)
@pytest.mark.parametrize("comma", [False, True])
def test_points_in_any_order_below_any_header(
    head: str, row: str, unit: str | None, comma: bool, tmp_path: Path
) -> None:
    rng = np.random.default_rng(1)
    heights = rng.normal(size=(4, 3)).round(3) + 0.0005
    rows = [row.format(1.5 * x, 0.5 * y, heights[y, x]) for y in range(4) for x in range(3)]
    text = head + "\n".join(rng.permutation(rows)) + "\n"
    if comma:
        text = text.replace(".", ",")
    surface = read_surface(write(tmp_path, "map.txt", text), unit=unit)
    np.testing.assert_allclose(surface.heights, 1e-6 * heights)
    assert surface.pixel == pytest.approx((0.5e-3, 1.5e-3))


@pytest.mark.parametrize(
    "head",
    [
        "X,Y,Z\nmm,mm,um",
        "X Pos. [mm],Y Pos. [mm],Height [um]",
        "X座標\uff08mm\uff09,Y座標\uff08mm\uff09,高さ\uff08μm\uff09",
    ],
)
def test_units_of_columns_under_any_name(head: str, tmp_path: Path) -> None:
    rows = [f"{x},{y},{x + y}" for y in range(3) for x in range(4)]
    surface = read_surface(write(tmp_path, "map.csv", "\n".join([head, *rows])))
    assert surface.shape == (3, 4)
    assert surface.pixel == pytest.approx((1e-3, 1e-3))
    assert range_in_um(surface) == pytest.approx((0, 5))


def test_units_along_x_and_y_that_differ_are_rejected(tmp_path: Path) -> None:
    rows = [f"{x},{y},{x + y}" for y in range(3) for x in range(4)]
    path = write(tmp_path, "map.csv", "\n".join(["X [mm],Y [um],Z [um]", *rows]))
    assert_rejected(path, "along x in 'mm' and along y in 'um'")


@pytest.mark.parametrize("name", ["map.xyz", "map.txt"])
def test_points_of_four_columns_are_rejected(name: str, tmp_path: Path) -> None:
    rows = "".join(f"{x} {y} {x + y} 9\n" for y in range(3) for x in range(4))
    path = write(tmp_path, name, rows)
    assert_rejected(path, "points in 4 columns; keep x, y", unit="um", size="1 mm x 1 mm")


def test_lines_above_a_matrix_are_skipped_with_a_note(tmp_path: Path) -> None:
    path = write(tmp_path, "map.txt", "Surface 12\nExported by X\n\n1 2 3\n4 5 6\n")
    surface = read_surface(path, unit="um", size=(2e-6, 3e-6))
    np.testing.assert_allclose(surface.heights, 1e-6 * np.arange(1.0, 7).reshape(2, 3))
    assert surface.provenance.steps == ("read: 3 lines above the numbers skipped",)


def test_quoted_cells_are_numbers(tmp_path: Path) -> None:
    expected = 1e-6 * np.array([[1.5, np.nan], [3.0, 4.0]])
    for text in (
        '"A","B"\n"1.5",""\n"3","4"\n',
        '"1,5","nan"\n"3","4"\n',
        '"A";"B"\n"1,5";\n3;4\n',
    ):
        surface = read_surface(write(tmp_path, "map.csv", text), unit="um", size=(2e-6, 2e-6))
        np.testing.assert_allclose(surface.heights, expected)


@pytest.mark.parametrize("first", ["1 x 3", "x 2 3", "1 2 3 x"])
def test_damaged_first_row_is_no_header(first: str, tmp_path: Path) -> None:
    path = write(tmp_path, "map.txt", f"{first}\n4 5 6\n7 8 9\n")
    assert_rejected(path, "'x' in line 1", unit="um", size=(1e-3, 1e-3))


def test_numbers_of_rows_and_columns_are_no_heights(tmp_path: Path) -> None:
    path = write(tmp_path, "map.csv", ",0,1,2\n0,1.5,2,3\n1,4,5,6\n")
    surface = read_surface(path, unit="um", size=(2e-6, 3e-6))
    np.testing.assert_allclose(surface.heights, 1e-6 * np.array([[1.5, 2, 3], [4, 5, 6]]))


@pytest.mark.parametrize("unit", ["\ufffdm", "?m", "~m", "microns", "µm"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_units_of_columns_with_a_lost_micro_sign(unit: str, encoding: str, tmp_path: Path) -> None:
    rows = "".join(f"{0.5 * i}\t{i % 4}\r\n" for i in range(12))
    text = f"X [{unit}]\tZ [{unit}]\r\n{rows}".encode(encoding)
    surface = read_surface(write(tmp_path, "map.txt", text))
    assert surface.pixel[1] == pytest.approx(0.5e-6)
    assert range_in_um(surface) == pytest.approx((0, 3))


def test_numbers_as_fortran_and_spreadsheets_write_them(tmp_path: Path) -> None:
    text = "1.5D+00 -2.0d-1\n\u22123. 4D0\n"
    surface = read_surface(write(tmp_path, "map.txt", text), unit="um", size="2 um x 2 um")
    np.testing.assert_allclose(1e6 * surface.heights, [[1.5, -0.2], [-3, 4]])
    text = "\u22121\u202f200,5;2\n3;4\n"
    surface = read_surface(write(tmp_path, "map.csv", text), unit="um", size="2 mm x 2 mm")
    np.testing.assert_allclose(1e6 * surface.heights, [[-1200.5, 2], [3, 4]])


def test_matrix_with_rising_first_column_is_no_profile(tmp_path: Path) -> None:
    # Heights of a tilted map, or positions of several profiles.
    text = "".join(f"{i} {i % 3} {i % 4} {i % 2}\n" for i in range(12))
    surface = read_surface(write(tmp_path, "map.txt", text), unit="um", size="12 um x 4 um")
    assert surface.shape == (12, 4)
    path = write(tmp_path, "named.txt", "X [mm];A [um];B [um];C [um]\n" + text.replace(" ", ";"))
    assert_rejected(path, "lists 4 columns; keep the positions", unit="um")


def test_coordinates_of_rows_and_columns_are_no_heights(tmp_path: Path) -> None:
    text = ";0,0;0,5;1,0\n0,0;1;2;3\n0,1;4;5;6\n"
    surface = read_surface(write(tmp_path, "map.csv", text), unit="um", size="2 um x 3 um")
    np.testing.assert_allclose(1e6 * surface.heights, [[1, 2, 3], [4, 5, 6]])


def test_single_column_below_remarks_of_an_instrument(tmp_path: Path) -> None:
    text = "SURFCOM\n測定条件\n" + "".join(f"{i % 3}\n" for i in range(20))
    path = write(tmp_path, "map.txt", text.encode("shift_jis"))
    assert read_surface(path, unit="um", size="1 mm").shape == (1, 20)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.pcd", bytes(range(256)) * 4, "Mahr's Perthometer Concept format; let the instrument"),
        ("a.pcd", b"# .PCD v0.7\nDATA ascii\n1 2 3\n", "a point cloud of PCL"),
        ("a.zag", b"KPK0" + bytes(99), "a project of Keyence's VR software; save"),
    ],
)
def test_family_of_files_without_description_is_named(
    name: str, content: bytes, words: str, tmp_path: Path
) -> None:
    assert_rejected(write(tmp_path, name, content), words)
