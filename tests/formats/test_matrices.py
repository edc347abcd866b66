from pathlib import Path

import numpy as np
import pytest

from reading import HEIGHTS, assert_rejected, write
from roughcontact.errors import InputError
from roughcontact.formats.read import channels, read_surface
from roughcontact.formats.source import Channel
from roughcontact.surface import provenance

TEXTS = {
    "comma": "0,1,2,3\n4,nan,6,7\n8,9,10,11.5\n",
    "semicolon": "# z [um]\n0;1;2;3\n\n4;;6;7\n8;9;10;11.5 # last\n",
    "tab": "0\t1\t2\t3\r\n4\t***\t6\t7\r\n8\t9\t10\t11.5\r\n",
    "spaces": "  0  1 2   3\n  4 NaN 6 7\n  8 9 1e1 11.5\n",
    "comma and space": "\ufeff0, 1, 2, 3\n4, , 6, 7\n8, 9, 10, 11.5",
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS.keys())
@pytest.mark.parametrize("suffix", [".csv", ".txt", ".asc"])
def test_text_matrix(tmp_path: Path, text: str, suffix: str) -> None:
    path = write(tmp_path, f"map{suffix}", text)
    surface = read_surface(path, unit="um", size=(6e-6, 4e-6))
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-15)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))
    assert channels(path) == (Channel("", "", True, (3, 4)),)


def test_delimiter_at_the_end_of_all_rows_is_no_column(tmp_path: Path) -> None:
    path = write(tmp_path, "map.csv", "1;2;\n3;4;\n")
    surface = read_surface(path, unit="nm", size="20 nm")
    assert surface.shape == (2, 2)
    assert "no column" in surface.provenance.steps[0]
    path = write(tmp_path, "hole.csv", "1;2;\n3;4;5\n")
    assert read_surface(path, unit="nm", size="20 nm x 30 nm").missing == 1


def test_text_without_final_line_end_adds_step(tmp_path: Path) -> None:
    for end, expected in (("", True), ("\n", False), ("\r\n", False), ("\n# end", True)):
        path = write(tmp_path, "map.csv", "1,2\n3,4\n5,6" + end)
        surface = read_surface(path, unit="nm", size="30 nm x 20 nm")
        assert surface.shape == (3, 2)
        assert [("no line end" in step) for step in surface.provenance.steps] == [True] * expected


@pytest.mark.parametrize("mark", [";", " ", "\t"])
def test_unambiguous_decimal_commas_are_read(tmp_path: Path, mark: str) -> None:
    text = "1,5 2\n-3,25 40\n".replace(" ", mark)
    surface = read_surface(write(tmp_path, "map.txt", text), unit="nm", size="20 nm")
    np.testing.assert_allclose(surface.heights, [[1.5e-9, 2e-9], [-3.25e-9, 40e-9]])
    assert "read: decimal commas" in surface.provenance.steps


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1;2\n3;4;5\n", "3 numbers in line 2 but 2 in line 1"),
        ("1,5;2,5\n3,5;4.5\n", "decimal points and, by line 2, decimal commas"),
        ("1.5 2.5\n3 4,5\n", "decimal points and, by line 2, decimal commas"),
        ("1,5,2;2,5\n3,5;4,5\n", "'1,5,2' in line 1"),
        ("x,y\n1,2\n3,4\n", "'x' in line 1, cell 1"),
        ("1 2\n3 inf\n", "'inf' in line 2, cell 2"),
        ("1 2\n3 1_0\n", "'1_0' in line 2, cell 2"),
        ("# nothing\n\n", "holds no numbers"),
        ("1 2 3 4\n", "at least 2 × 2"),
        ("nan nan\nnan nan\n", "no finite value"),
        (b"\xff\xfe1\x00\x00", "no plain text"),
        (b"\x89PNG\r\n\x1a\n\x00", "is a PNG image"),
        (b"# damaged\n-0\x00\x000.5\n1 2\n3 4\n", "line 2 has a character of code zero"),
    ],
)
def test_text_that_is_no_matrix(tmp_path: Path, text: str | bytes, words: str) -> None:
    assert_rejected(
        write(tmp_path, "map.csv", text), "map.csv", words, unit="um", size="1 mm x 1 mm"
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "map.csv gives no unit"),
        ({"unit": "um"}, "map.csv gives no lengths of its sides"),
        ({"size": (1e-3, 1e-3)}, "map.csv gives no unit"),
        ({"unit": "N", "size": (1e-3, 1e-3)}, "unit needs a length"),
        ({"unit": "um", "size": "1 mm"}, "both sides (y, x) of a grid of 3 × 4"),
        ({"unit": "um", "size": "1 x 2"}, "has no unit"),
        ({"unit": "um", "size": (1e-3,)}, "both sides"),
        ({"unit": "um", "size": (1e-3, -1e-3)}, "size must be positive"),
        ({"unit": "um", "size": (1e-3, float("nan"))}, "size must be positive"),
        ({"unit": "um", "size": ("a", "b")}, "size needs a length with its unit"),
        ({"unit": "um", "size": {"y": 1e-3}}, "pair (y, x) in meters"),
        ({"unit": "um", "size": (1, 2, 3)}, "both sides"),
        ({"unit": "um", "size": (1e-3, 1e-3), "channel": 0}, "no channels"),
    ],
)
def test_a_matrix_needs_unit_and_size(
    tmp_path: Path, arguments: dict[str, object], words: str
) -> None:
    path = write(tmp_path, "map.csv", TEXTS["comma"])
    assert_rejected(path, words, kind=InputError, **arguments)


def test_numpy_files(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", HEIGHTS.astype(np.float32))
    size = "6 um × 4 um"
    surface = read_surface(tmp_path / "map.npy", unit="nm", size=size)
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-9, rtol=1e-7)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))
    np.savez(tmp_path / "map.npz", front=HEIGHTS, back=HEIGHTS + 1, label="text")
    path = tmp_path / "map.npz"
    assert [entry.name for entry in channels(path)] == ["front", "back", "label"]
    for channel in ("back", 1, "1"):
        surface = read_surface(path, unit="nm", size=size, channel=channel)
        assert surface.heights[0, 0] == 1e-9
        assert surface.provenance.channel == "back"
    assert_rejected(path, "0: 'front'; 1: 'back'", unit="nm", size=size, kind=InputError)
    assert_rejected(path, "no array 'x'", unit="nm", size=size, channel="x", kind=InputError)
    assert_rejected(path, "real numbers", unit="nm", size=size, channel="label")
    np.savez(tmp_path / "one.npz", HEIGHTS)
    assert read_surface(tmp_path / "one.npz", unit="nm", size=size).shape == (3, 4)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (HEIGHTS * 1j, "complex128"),
        (HEIGHTS[0], "shape (4,)"),
        (HEIGHTS[:1], "shape (1, 4)"),
        (np.zeros((0, 4)), "shape (0, 4)"),
        (np.zeros((2, 2, 2)), "shape (2, 2, 2)"),
        (np.array([["a", "b"], ["c", "d"]]), "<U1"),
        (np.array([[None, 1], [2, 3]]), "Python objects"),
        (np.array([[np.inf, 1], [2, 3]]), "1 infinite values"),
    ],
)
def test_numpy_arrays_that_are_no_map(tmp_path: Path, array: np.ndarray, words: str) -> None:
    np.save(tmp_path / "map.npy", array, allow_pickle=True)
    assert_rejected(tmp_path / "map.npy", "map.npy", words, unit="um", size="1 mm x 1 mm")


@pytest.mark.parametrize("name", ["map.npy", "map.npz"])
def test_truncated_numpy_files(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    if name.endswith("y"):
        np.save(path, HEIGHTS)
    else:
        np.savez(path, HEIGHTS)
    content = path.read_bytes()
    for length in (1, 40, len(content) - 20):
        path.write_bytes(content[:length])
        assert_rejected(path, name, "cannot be read", unit="um", size="1 mm x 1 mm")


# Matrices that give their unit and pixel themselves

HEAD = (
    "# roughcontact map\n# quantity: height\n# unit: um\n# pixel_y: 2 um\n# pixel_x: 1e-6 m\n"
    "# a remark\n"
)


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".asc"])
def test_text_matrix_with_a_head(tmp_path: Path, suffix: str) -> None:
    path = write(tmp_path, f"map{suffix}", "\ufeff" + HEAD + TEXTS["semicolon"])
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-15)
    assert surface.pixel == pytest.approx((2e-6, 1e-6), rel=1e-15, abs=0)
    assert channels(path) == (Channel("height", "um", True, (3, 4)),)
    assert_rejected(path, "contains its unit", unit="um", kind=InputError)
    assert_rejected(path, "contains its size", size=(6e-6, 4e-6), kind=InputError)
    assert_rejected(path, "no channels", channel=0, kind=InputError)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("# unit: um\n", "", "lacks unit in its head"),
        ("pixel_y: 2 um", "pixel", "lacks pixel_y in its head"),
        ("quantity: height", "quantity: pressure", "holds 'pressure', no heights"),
        ("unit: um", "unit: Pa", "unit needs a length"),
        ("2 um", "2", "pixel_y needs a length"),
        ("2 um", "-2 um", "pixel_y must be positive"),
        ("2 um", "2 m", "outside"),
        ("# quantity", "# roughcontact map\n# quantity", None),
    ],
)
def test_text_matrix_with_a_bad_head(tmp_path: Path, old: str, new: str, words: str | None) -> None:
    path = write(tmp_path, "map.csv", HEAD.replace(old, new) + TEXTS["comma"])
    if words is None:
        assert read_surface(path).pixel == pytest.approx((2e-6, 1e-6), rel=1e-15, abs=0)
        return
    assert_rejected(path, "map.csv", words)


def test_late_head_is_ignored_as_remark(tmp_path: Path) -> None:
    path = write(tmp_path, "map.csv", "\n" + HEAD + TEXTS["comma"])
    assert_rejected(path, "map.csv gives no unit", kind=InputError)
    assert channels(path) == (Channel("", "", True, (3, 4)),)


def test_a_matrix_with_a_head_is_no_list_of_points(tmp_path: Path) -> None:
    text = "".join(f"{x} {y} 0.5\n" for y in range(3) for x in range(4))
    assert read_surface(write(tmp_path, "map.csv", HEAD + text)).shape == (12, 3)


@pytest.mark.parametrize("falling", [False, True])
def test_a_profile_is_no_map(tmp_path: Path, falling: bool) -> None:
    x = np.arange(400.0)[:: -1 if falling else 1]
    profile = np.column_stack([x, np.sin(x)])
    np.savetxt(tmp_path / "rows.txt", profile)
    np.save(tmp_path / "rows.npy", profile)
    for path in (tmp_path / "rows.txt", tmp_path / "rows.npy"):
        assert read_surface(path, unit="um, um").is_profile
    np.savetxt(tmp_path / "columns.txt", profile.T)
    np.save(tmp_path / "columns.npy", profile.T)
    for path in (tmp_path / "columns.txt", tmp_path / "columns.npy"):
        words = ("looks like a profile, 400 points x, z", "positions first")
        assert_rejected(path, path.name, *words, unit="um", size="1 mm x 2 um")
    # A narrow map that is one keeps to be read, and so does one that says so.
    np.save(tmp_path / "map.npy", np.sin(profile))
    assert read_surface(tmp_path / "map.npy", unit="nm", size="1 mm x 5 um").shape == (400, 2)
    head = HEAD + "\n".join(f"{a} {b}" for a, b in profile)
    assert read_surface(write(tmp_path, "map.csv", head)).shape == (400, 2)
    assert channels(tmp_path / "map.csv")[0].shape == (400, 2)


def test_override_size_replaces_size_and_adds_step(tmp_path: Path) -> None:
    path = write(tmp_path, "map.csv", HEAD + TEXTS["semicolon"])
    assert_rejected(
        path, "leave out size", "override_size=True", size=(6e-6, 4e-6), kind=InputError
    )
    assert_rejected(path, "override_size needs a size", override_size=True, kind=InputError)
    surface = read_surface(path, size="3 um x 8 um", override_size=True)
    assert surface.pixel == pytest.approx((1e-6, 2e-6))
    (step,) = surface.provenance.steps
    assert step == ("read: sides of 6 µm × 4 µm, as the file gives them, replaced by 3 µm × 8 µm")
    # The size is a measure of the map: heights keep the unit of the file.
    np.testing.assert_array_equal(surface.heights, read_surface(path).heights)
    assert provenance.from_text(provenance.to_text(surface.provenance)) == surface.provenance
    again = tmp_path / "map.nc"
    surface.save(again)
    assert read_surface(again, size="1 um x 1 um", override_size=True).size == (1e-6, 1e-6)


def test_numpy_archive_with_unit_and_pixel(tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    np.savez(path, heights=HEIGHTS, pixel=[2.0, 1.0], unit="um", note="more")
    for channel in (None, "heights"):
        surface = read_surface(path, channel=channel)
        np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-15)
        assert surface.pixel == pytest.approx((2e-6, 1e-6), rel=1e-15, abs=0)
    assert_rejected(path, "contains its unit", unit="um", kind=InputError)
    assert_rejected(path, "contains its size", size="1 um x 2 um", kind=InputError)
    assert_rejected(path, "at least 2 × 2", channel="pixel")
    for changes, words in (
        ({"pixel": 1.0}, "two numbers (dy, dx) as pixel"),
        ({"pixel": ["1", "2"]}, "two numbers (dy, dx) as pixel"),
        ({"unit": 1}, "a word as unit"),
        ({"unit": ["um"]}, "a word as unit"),
        ({"pixel": [1.0, np.nan]}, "pixel must be positive"),
        ({"heights": HEIGHTS[0]}, "at least 2 × 2"),
    ):
        np.savez(path, **{"heights": HEIGHTS, "pixel": [2.0, 1.0], "unit": "um", **changes})
        assert_rejected(path, words)
    np.savez(path, heights=HEIGHTS, pixel=[2.0, 1.0], unit="Pa")
    assert_rejected(path, "map.npz", "unit needs a length")
    # Without a unit it is an archive as any other.
    np.savez(path, heights=HEIGHTS, pixel=[2.0, 1.0])
    assert_rejected(path, "0: 'heights'; 1: 'pixel'", kind=InputError)


@pytest.mark.parametrize("size", ["1 px", "1 mm x 1 px", "1 mm x"])
def test_an_x_in_a_unit_parts_no_size(tmp_path: Path, size: str) -> None:
    path = write(tmp_path, "map.csv", TEXTS["comma"])
    assert_rejected(path, repr(size.split(" x ")[-1]), unit="um", size=size, kind=InputError)
    assert read_surface(path, unit="um", size="6umx4um").pixel == pytest.approx((2e-6, 1e-6))
