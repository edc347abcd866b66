"""Values that mark points without data in plain matrices."""

from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from reading import assert_rejected, write
from roughcontact.errors import InputError
from roughcontact.formats.no_data import find_code, mark_missing
from roughcontact.formats.read import read_surface
from roughcontact.formats.source import FormatError
from roughcontact.report import python_script

ROUGH = np.random.default_rng(3).normal(0.0, 0.2, (12, 16)).round(4)
HOLES = [(1, 2), (5, 5), (11, 15)]
SCALE = {"unit": "um", "size": "12 um x 16 um"}


def with_code(code: float, heights: np.ndarray = ROUGH) -> np.ndarray:
    marked = heights.copy()
    marked[tuple(zip(*HOLES, strict=True))] = code
    return marked


@pytest.mark.parametrize(
    "code",
    [
        *(-32.768, -32768.0, 32767.0, -3276.8, -2147483648.0),
        *(999.0, -999.0, -9999.0, 99999.0, 1e10, 3.4e38, 1.70141e38),
    ],
)
def test_standard_code_is_found(code: float) -> None:
    assert find_code(with_code(code), 1.0) == (code, 3)
    single = np.float64(np.float32(code)) * 1e-6
    found = find_code(with_code(single, 1e-6 * ROUGH), 1e-6)
    assert found == (pytest.approx(code, rel=1e-6), 3)


def test_zero_is_a_code_only_where_all_else_is_far() -> None:
    assert find_code(with_code(0.0, ROUGH + 50.0), 1.0) == (0.0, 3)
    assert find_code(with_code(0.0), 1.0) is None
    assert find_code(with_code(0.0, np.abs(ROUGH) + 0.1), 1.0) is None


@pytest.mark.parametrize(
    "heights",
    [
        with_code(-5.0),  # no known code
        with_code(999.0, 2000 * np.abs(ROUGH)),  # among the heights
        np.where(ROUGH < 0, 0.0, -1.0),  # a step of two heights
        np.zeros((4, 4)),
        np.full((4, 4), 5e-324),
    ],
)
def test_heights_are_no_code(heights: np.ndarray) -> None:
    assert find_code(heights, 1.0) is None
    once = ROUGH.copy()
    once[3, 3] = -9999
    assert find_code(once, 1.0) is None


def test_several_codes_are_marked_with_auto() -> None:
    heights = with_code(-9999.0)
    heights[7, :3] = 9999.0
    marked, codes = mark_missing("map.csv", heights, 1.0, "auto")
    assert codes == {-9999.0: 3, 9999.0: 3}
    assert np.isnan(marked).sum() == 6
    with pytest.raises(InputError, match='no_data="auto"'):
        mark_missing("map.csv", heights, 1.0, -9999.0)
    assert mark_missing("map.csv", heights, 1.0, "none")[0] is heights


def test_advice_fills_any_share_of_missing_points() -> None:
    for rows, choice in ((3, "fill"), (5, "fill-all")):
        heights = ROUGH.copy()
        heights[:rows] = -9999
        with pytest.raises(InputError, match=f'missing="{choice}"'):
            mark_missing("map.csv", heights, 1.0, None)


def save_plain(path: Path, heights: np.ndarray) -> dict[str, str]:
    """Write a plain matrix in the format of the suffix; return arguments to read it."""
    if path.suffix == ".npy":
        np.save(path, heights)
    elif path.suffix == ".npz":
        np.savez(path, heights)
    elif path.suffix == ".h5":
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "w") as file:
            file["z"] = heights
    elif path.suffix == ".xlsx":
        openpyxl = pytest.importorskip("openpyxl")
        book = openpyxl.Workbook()
        for row in heights.tolist():
            book.active.append(row)
        book.save(path)
    elif path.suffix == ".xyz":
        points = [(x, y, z) for (y, x), z in np.ndenumerate(heights)]
        np.savetxt(path, points, fmt="%.9g")
        return {"unit": "um"}
    else:
        np.savetxt(path, heights, fmt="%.9g", delimiter=",")
    return SCALE


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".asc", ".npy", ".npz", ".h5", ".xlsx", ".xyz"])
def test_code_in_plain_formats_is_requested_and_set_missing(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"map{suffix}"
    scale = save_plain(path, with_code(-32.768))
    assert_rejected(path, "-32.768 at 3 points", "no_data=-32.768", kind=InputError, **scale)
    surface = read_surface(path, no_data=-32.768, **scale)
    expected = 1e-6 * with_code(np.nan)
    np.testing.assert_allclose(surface.heights, expected, rtol=1e-12, atol=0)
    assert "3 points at -32.768 set missing" in surface.provenance.steps[-1]
    assert "no_data=-32.768" in python_script.script_of_map(surface)
    kept = read_surface(path, no_data="none", **scale)
    np.testing.assert_allclose(kept.heights, 1e-6 * with_code(-32.768), rtol=1e-12, atol=0)


def test_code_of_a_profile_is_marked_before_interpolation(tmp_path: Path) -> None:
    position = np.cumsum(np.random.default_rng(1).uniform(0.8, 1.2, 60))
    heights = np.sin(position)
    heights[[20, 40]] = -9999
    path = tmp_path / "profile.txt"
    np.savetxt(path, np.column_stack([position, heights]), fmt="%.6f")
    assert_rejected(path, "-9999 at 2 points", kind=InputError, unit="um, um")
    surface = read_surface(path, unit="um, um", no_data="auto")
    assert surface.missing
    assert np.nanmin(surface.heights) > -1.1e-6
    assert surface.provenance.origin is not None
    assert surface.provenance.origin.found["no_data"] == ((-9999.0, 2),)


def test_huge_code_does_not_hide_behind_the_scale(tmp_path: Path) -> None:
    path = tmp_path / "map.npy"
    np.save(path, with_code(np.float64(np.float32(3.4028235e38))))
    assert_rejected(path, "no_data=3.40282347e+38", kind=InputError, **SCALE)
    # The six digits of a command line.
    assert read_surface(path, no_data=3.40282e38, **SCALE).missing == 3
    np.save(path, with_code(-12345678.0))
    assert_rejected(path, "no_data=-9999.0", kind=FormatError, **SCALE)
    assert read_surface(path, no_data=-12345678.0, **SCALE).missing == 3


def test_files_with_a_marker_are_read_as_they_are(tmp_path: Path) -> None:
    surface = rc.Surface(1e-6 * with_code(-32.768), (1e-6, 1e-6))
    for name in ("map.nc", "map.csv", "map.npz"):
        surface.save(tmp_path / name)
        np.testing.assert_allclose(
            read_surface(tmp_path / name).heights, surface.heights, rtol=1e-15
        )
    head = "# roughcontact map\n# quantity: height\n# unit: um\n# pixel_y: 1 um\n# pixel_x: 1 um\n"
    text = "\n".join(",".join(map(str, row)) for row in with_code(-32.768).tolist())
    path = write(tmp_path, "own.csv", head + text)
    assert read_surface(path, no_data=-32.768).missing == 3


@pytest.mark.parametrize("value", ["", "a", float("nan"), float("inf"), True, [1]])
def test_no_data_must_be_a_number(tmp_path: Path, value: object) -> None:
    path = write(tmp_path, "map.csv", "1,2\n3,4")
    assert_rejected(path, "no_data", kind=InputError, no_data=value, unit="um", size="2 um x 2 um")


def test_code_of_nines_with_decimals_is_found() -> None:
    assert find_code(with_code(-99999.9999), 1.0) == (-99999.9999, 3)
    assert find_code(with_code(9.99), 1.0) is None


@pytest.mark.parametrize(("name", "value"), [("mask", 1), ("invalid", True), ("valid", 0)])
def test_mask_next_to_an_array_marks_missing_points(name: str, value: int, tmp_path: Path) -> None:
    mask = np.full(ROUGH.shape, not value)
    mask[tuple(zip(*HOLES, strict=True))] = value
    np.savez(tmp_path / "map.npz", **{"z": ROUGH, name: mask})
    surface = read_surface(tmp_path / "map.npz", **SCALE)
    assert np.argwhere(np.isnan(surface.heights)).tolist() == [list(hole) for hole in HOLES]
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file["scan/z"] = ROUGH
        file[f"scan/{name}"] = mask
        file[f"other/{name}"] = np.ones_like(mask)
    surface = read_surface(tmp_path / "map.h5", **SCALE)
    assert np.argwhere(np.isnan(surface.heights)).tolist() == [list(hole) for hole in HOLES]
