"""The suffix is a hint, the content decides; packed files, HDF5 and the NetCDF of another."""

from __future__ import annotations

import contextlib
import gzip
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from bounded_reader import Reader
from reading import HEIGHTS, assert_rejected, needs_reader
from roughcontact._tools import memory
from roughcontact.errors import InputError, RoughcontactError
from roughcontact.formats.read import channels, read_surface
from roughcontact.formats.source import Channel

SIZE = "6 um x 4 um"


def close(surface: Any, metre: float = 1e-6) -> None:
    np.testing.assert_allclose(surface.heights, HEIGHTS * metre, rtol=1e-12)


# Files compressed by gzip


def test_compressed_file_is_read_as_its_content(tmp_path: Path) -> None:
    plain = tmp_path / "map.csv"
    np.savetxt(plain, HEIGHTS, delimiter=",")
    packed = tmp_path / "map.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    surface = read_surface(packed, unit="um", size=SIZE)
    close(surface)
    assert surface.provenance.source == "map.csv.gz"
    assert surface.provenance.origin is not None
    assert surface.provenance.origin.arguments["path"] == "map.csv.gz"
    unnamed = tmp_path / "map.gz"
    unnamed.write_bytes(packed.read_bytes())
    close(read_surface(unnamed, unit="um", size=SIZE))
    surface.save(tmp_path / "map.npz")
    again = tmp_path / "map.npz.gz"
    again.write_bytes(gzip.compress((tmp_path / "map.npz").read_bytes()))
    close(read_surface(again))


def test_damaged_compressed_files_raise_format_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = gzip.compress(b"1 2\n3 4\n" * 1000)
    path = tmp_path / "map.txt.gz"
    for content in (whole[:-10], whole[:30], whole[:40] + b"\0\0\0" + whole[43:], whole[:2]):
        path.write_bytes(content)
        assert_rejected(path, "map.txt.gz cannot be unpacked", unit="um", size="1 mm x 1 mm")
    monkeypatch.setattr(memory, "_SMALL", 4000)
    monkeypatch.setattr(memory, "_PACKED", 2)
    path.write_bytes(whole)
    assert_rejected(path, "as no measurement is", unit="um", size="1 mm x 1 mm")


# The content decides


def test_the_content_decides_where_the_suffix_errs(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", HEIGHTS)
    wrong = tmp_path / "map.txt"
    wrong.write_bytes((tmp_path / "map.npy").read_bytes())
    close(read_surface(wrong, unit="um", size=SIZE))
    for name in ("map.dat", "map.prn", "map"):
        np.savetxt(tmp_path / name, HEIGHTS)
        surface = read_surface(tmp_path / name, unit="um", size=SIZE)
        close(surface)
        assert surface.provenance.origin is not None
        assert surface.provenance.origin.found["format"] == "text"
    # A given format decides.
    assert_rejected(wrong, "is no plain text", format="text", unit="um", size=SIZE)
    unknown = tmp_path / "map.bin"
    unknown.write_bytes(bytes(range(256)))
    assert_rejected(unknown, "unknown suffix '.bin'")


@needs_reader
@pytest.mark.parametrize("name", ["map.npy", "map.csv", "map.txt", "map.npz", "map"])
def test_hdf5_that_states_its_scale_is_not_read_as_bare_arrays(name: str, tmp_path: Path) -> None:
    import vendors

    content = vendors.datx(tmp_path)[0]
    given = {"unit": "um", "size": SIZE}
    (tmp_path / name).write_bytes(content)
    assert read_surface(tmp_path / name).provenance.instrument == "Zygo DATX (Zygo)"
    assert_rejected(tmp_path / name, "contains its unit", **given, kind=InputError)
    (tmp_path / "map.h5").write_bytes(content)
    assert_rejected(tmp_path / "map.h5", "contains its unit", **given, kind=InputError)
    surface = rc.Surface(np.nan_to_num(HEIGHTS) * 1e-6, (2e-6, 1e-6))
    surface.save(tmp_path / "map.nc")
    (tmp_path / name).write_bytes((tmp_path / "map.nc").read_bytes())
    read = read_surface(tmp_path / name)
    np.testing.assert_array_equal(read.heights, surface.heights)
    assert read.pixel == surface.pixel
    assert_rejected(tmp_path / name, "contains its unit", **given, kind=InputError)


@needs_reader
def test_complex_numbers_in_an_instrument_file_are_no_heights(tmp_path: Path) -> None:
    import h5py

    import vendors

    path = tmp_path / "map.datx"
    path.write_bytes(vendors.datx(tmp_path)[0])
    with h5py.File(path, "r+") as file:
        attributes = dict(file["Data/Surface/one"].attrs)
        values = file["Data/Surface/one"][()]
        del file["Data/Surface/one"]
        file["Data/Surface/one"] = values.astype(complex)
        file["Data/Surface/one"].attrs.update(attributes)
    assert_rejected(path, "complex numbers in 'Data/Surface/one'")


# HDF5


def test_matrices_in_hdf5_are_channels(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "map.h5"
    with h5py.File(path, "w") as file:
        file["scan/heights"] = HEIGHTS
        file["scan/heights"].attrs["units"] = "nm"
        file["scan/line"] = HEIGHTS[0]
        file["phase"] = HEIGHTS + 1
        file["words"] = np.array([[b"a", b"b"], [b"c", b"d"]])
    found = {entry.name: entry for entry in channels(path)}
    assert found["scan/heights"] == Channel("scan/heights", "nm", True, (3, 4))
    assert set(found) == {"scan/heights", "phase"}
    assert_rejected(path, "choose one with channel", size=SIZE, kind=InputError)
    surface = read_surface(path, channel="scan/heights", size=SIZE)
    close(surface, 1e-9)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))
    result = read_surface(path, channel="scan/heights", size=SIZE, unit="um").provenance.steps
    assert result == ("read: heights in um, as given, instead of nm in the file",)
    assert_rejected(path, "gives no unit", channel="phase", size=SIZE, kind=InputError)
    with h5py.File(path, "w") as file:
        # The names that Zygo takes, for something else.
        file["Data/heights"] = HEIGHTS
        file["MetaData/place"] = 1.0
    close(read_surface(path, unit="um", size=SIZE))
    with h5py.File(path, "w") as file:
        file["scan/heights"] = file["phase"] = HEIGHTS
    assert_rejected(path, "no lengths of its sides", channel="phase", unit="um", kind=InputError)
    with h5py.File(path, "w") as file:
        file["line"] = HEIGHTS[0]
    assert_rejected(path, "holds no matrix")
    content = path.read_bytes()
    for length in (9, 100, len(content) // 2):
        path.write_bytes(content[:length])
        assert_rejected(path, "map.h5 ")


# The NetCDF of SurfaceTopography


def classic(path: Path, *, dimensions: tuple[str, ...] = ("x", "y"), **changes: Any) -> Path:
    from scipy.io import netcdf_file

    given = {"length": True, "unit": b"um", "mask": True, "name": "heights", **changes}
    with netcdf_file(path, "w", version=2) as file:
        for axis, points in (("x", 4), ("y", 3)):
            file.createDimension(axis, points)
            variable = file.createVariable(axis, "f8", (axis,))
            variable[:] = np.arange(points)
            if given["length"]:
                variable.length = 2.0 * points
            if given["unit"]:
                variable.unit = given["unit"]
        values = np.nan_to_num(HEIGHTS.T) if len(dimensions) == 2 else np.arange(4.0)
        heights = file.createVariable(given["name"], "f8", dimensions)
        heights[:] = values
        if given["unit"]:
            heights.unit = given["unit"]
        if given["mask"] and len(dimensions) == 2:
            mask = file.createVariable("mask", "i1", dimensions)
            mask[:] = np.isnan(HEIGHTS.T)
    return path


def test_classic_netcdf_of_surface_topography(tmp_path: Path) -> None:
    path = classic(tmp_path / "map.nc")
    surface = read_surface(path)
    close(surface)
    assert surface.pixel == pytest.approx((2e-6, 2e-6))
    assert channels(path) == (Channel("heights", "um", True, (3, 4)),)
    assert_rejected(path, "contains its unit", unit="nm", kind=InputError)
    bare = classic(tmp_path / "bare.nc", length=False, unit=b"", mask=False)
    assert_rejected(bare, "gives no unit", size=SIZE, kind=InputError)
    assert_rejected(bare, "no lengths of its sides", unit="um", kind=InputError)
    assert read_surface(bare, unit="nm", size=SIZE).pixel == pytest.approx((2e-6, 1e-6))
    assert_rejected(classic(tmp_path / "line.nc", dimensions=("x",)), "'heights' over (x), no map")
    assert_rejected(
        classic(tmp_path / "other.nc", name="other"), "no variable 'heights'", "'other'", "expected"
    )


def test_netcdf_of_surface_topography_matches_its_reader(tmp_path: Path) -> None:
    library = pytest.importorskip("SurfaceTopography", exc_type=ImportError)
    path = tmp_path / "map.nc"
    values = np.arange(12.0).reshape(4, 3)
    library.Topography(values, (8.0, 9.0), unit="um").to_netcdf(path)
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, values.T * 1e-6)
    assert surface.pixel == pytest.approx((3e-6, 2e-6))


def test_damaged_classic_netcdf_raises_format_error(tmp_path: Path) -> None:
    path = classic(tmp_path / "map.nc")
    content = path.read_bytes()
    for length in (4, 20, 100, len(content) - 8):
        path.write_bytes(content[:length])
        assert_rejected(path, "map.nc ")
    rng = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(content)
        for place in rng.integers(4, 300, 3):
            damaged[place] = rng.integers(256)
        path.write_bytes(damaged)
        # Anything but an error of this program ends the test.
        with contextlib.suppress(RoughcontactError):
            read_surface(path)


# Files that need more memory than any machine has


@pytest.mark.long
def test_heads_and_points_of_terabytes_raise_format_error(tmp_path: Path) -> None:
    pytest.importorskip("resource", reason="limits of memory are POSIX")
    reader = Reader(tmp_path)
    rows = "1 2\n3 4\n"
    points = "".join(f"{x} {y} 1\n" for x in range(4) for y in range(4))
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "vast.h5", "w") as file:
        file.create_dataset("z", (2**20, 2**20), "f8", chunks=(64, 64))
    huge = {
        "koala.txt": f"h=99999999 w=99999999\npixel size=1e-6 m\n{rows}".encode(),
        "spip.txt": f"# x-pixels = {10**15}\n# y-pixels = 2\n# z-unit = nm\n{rows}".encode(),
        "far.xyz": (points + "1e12 1e12 1\n").encode(),
        "fine.xyz": (points + "1e-9 0.5 1\n").encode(),
        "vast.h5": (tmp_path / "vast.h5").read_bytes(),
        "long.txt": b"# Width: 1 um " + b"-" * 10**6 + b"\n" + f"{'# ' * 10**6}\n{rows}".encode(),
        "vast.nc": classic(tmp_path / "small.nc")
        .read_bytes()
        .replace(b"\0\0\0\1x\0\0\0\0\0\0\4", b"\0\0\0\1x\0\0\0\x7f\xff\xff\xf0"),
    }
    try:
        for name, content in huge.items():
            path = tmp_path / name
            path.write_bytes(content)
            answer = reader.read(path, {"unit": "um", "size": "1 mm x 1 mm"})
            if name == "long.txt":
                assert "pixel" in answer, answer
            else:
                assert name in str(answer.get("refused")), (name, answer)
    finally:
        reader.close()


def test_table_of_examples_counts_outcomes(tmp_path: Path) -> None:
    import example_files

    np.savetxt(tmp_path / "bare.txt", HEIGHTS)
    np.savez(tmp_path / "two.npz", a=HEIGHTS, b=HEIGHTS)
    classic(tmp_path / "map.nc")
    (tmp_path / "words.txt").write_text("this is no map\n")
    paths = sorted(tmp_path.iterdir())
    outcomes = [example_files.judge_file(path) for path in paths]
    hints = "read with unit um, size 1 mm x 1 mm"
    assert [outcome for outcome, _ in outcomes] == [hints, "read", f"{hints}, channel", "refused"]
    assert (
        example_files.count_opened(outcomes) == "of 4: 1 open alone, 2 with a hint, 1 do not open"
    )
    assert "'this' in line 1" in example_files.table(paths, outcomes, []).splitlines()[5]
    assert example_files.table(paths, outcomes, outcomes).splitlines()[2].count(hints) == 2


# Excel


def workbook(path: Path, **sheets: list[list[Any]]) -> Path:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def test_sheets_of_excel_are_matrices_points_or_profiles(tmp_path: Path) -> None:
    matrix = [[None if np.isnan(z) else z for z in row] for row in HEIGHTS.tolist()]
    path = workbook(tmp_path / "map.xlsx", heights=matrix)
    surface = read_surface(path, unit="um", size=SIZE)
    close(surface)
    assert surface.provenance.source == "map.xlsx"
    points = [["x [um]", "y [um]", "z [nm]"]]
    points += [[0.5 * i, 0.25 * j, float(i + 4 * j)] for j in range(3) for i in range(4)]
    path = workbook(tmp_path / "two.xlsx", notes=[["taken", "today"]], points=points)
    surface = read_surface(path, channel="points")
    np.testing.assert_allclose(surface.heights, np.arange(12.0).reshape(3, 4) * 1e-9)
    assert surface.pixel == pytest.approx((0.25e-6, 0.5e-6))
    assert surface.provenance.channel == "points"
    assert [entry.is_height for entry in channels(path)] == [False, True]
    assert_rejected(path, "0: 'notes'; 1: 'points'", kind=InputError)
    assert_rejected(path, "has 'taken' in line 1", channel="notes")
    content = path.read_bytes()
    for length in (10, len(content) // 2, len(content) - 5):
        path.write_bytes(content[:length])
        assert_rejected(path, "two.xlsx cannot be read as an Excel workbook")


def test_sheet_with_wrong_dimensions_is_read_by_its_cells(tmp_path: Path) -> None:
    path = workbook(tmp_path / "map.xlsx", heights=[[1.0, 2.0], [3.0, 4.0]])
    vast = tmp_path / "vast.xlsx"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(vast, "w") as new:
        for name in old.namelist():
            inside = old.read(name).replace(b'ref="A1:B2"', b'ref="A1:XFD1048576"')
            new.writestr(name, inside)
    assert read_surface(vast, unit="nm", size="1 um").shape == (2, 2)


def test_missing_excel_library_names_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "map.xlsx"
    path.write_bytes(b"PK\3\4")
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    assert_rejected(path, "needs openpyxl", "roughcontact[io]")
