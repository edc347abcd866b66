import os
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import h5netcdf
import h5py
import numpy as np
import pytest
import xarray

import roughcontact as rc
from reading import assert_rejected, needs_reader
from roughcontact._tools import memory, netcdf as netcdf_tools
from roughcontact._tools.netcdf import check_hdf5
from roughcontact.errors import FormatError, InsufficientMemoryError
from roughcontact.formats import matrices, netcdf
from roughcontact.formats.read import read_surface

HEIGHTS = np.arange(30.0 * 40).reshape(30, 40) * 1e-9


def map_file(
    path: Path, height: Callable[[h5py.File], h5py.Dataset], shape: tuple[int, int] = (30, 40)
) -> Path:
    """Write a map whose heights a function creates."""
    with h5py.File(path, "w") as file:
        heights = height(file)
        heights.attrs["units"] = "m"
        for number, (name, points) in enumerate(zip("yx", shape, strict=True)):
            axis = file.create_dataset(name, data=(np.arange(points) + 0.5) * 1e-6)
            axis.make_scale(name)
            heights.dims[number].attach_scale(axis)
        file.attrs["pixel_y"] = file.attrs["pixel_x"] = 1e-6
    return path


@pytest.fixture
def other(tmp_path: Path) -> Path:
    """A map in another file, which is not an argument."""
    (tmp_path / "secret.bin").write_bytes(HEIGHTS.tobytes())
    return map_file(tmp_path / "other.nc", lambda file: file.create_dataset("height", data=HEIGHTS))


def test_check_hdf5_lists_arrays_without_reading(other: Path) -> None:
    assert check_hdf5(other) == {
        "height": ((30, 40), 9600, "f"),
        "x": ((40,), 320, "f"),
        "y": ((30,), 240, "f"),
    }
    np.testing.assert_array_equal(read_surface(other).heights, HEIGHTS)


def test_raw_data_outside(other: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    raw = [("secret.bin", 0, h5py.h5f.UNLIMITED)]
    path = map_file(
        tmp_path / "map.nc",
        lambda file: file.create_dataset("height", (30, 40), "f8", external=raw),
    )
    monkeypatch.chdir(tmp_path)
    assert_rejected(path, "map.nc keeps 'height' in another file (raw data outside)")
    with pytest.raises(FormatError, match=r"^map.nc keeps 'height' in another file"):
        rc.read_result(path)


def test_virtual_datasets(other: Path, tmp_path: Path) -> None:
    def virtual(file: h5py.File) -> h5py.Dataset:
        layout = h5py.VirtualLayout((30, 40), "f8")
        layout[:] = h5py.VirtualSource(other, "height", shape=(30, 40))
        return file.create_virtual_dataset("height", layout)

    assert_rejected(
        map_file(tmp_path / "map.nc", virtual), "map.nc keeps 'height' in", "a virtual dataset"
    )


def test_links_into_other_files(other: Path, tmp_path: Path) -> None:
    path = tmp_path / "map.nc"
    with h5py.File(path, "w") as file:
        file["deep/er/height"] = h5py.ExternalLink(other, "/height")
    assert_rejected(path, "map.nc keeps 'deep/er/height' in another file (an external link)")
    # A soft link that leads through it.
    with h5py.File(path, "w") as file:
        file["away"] = h5py.ExternalLink(other, "/")
        for name in ("height", "y", "x"):
            file[name] = h5py.SoftLink(f"/away/{name}")
    assert_rejected(path, "map.nc keeps 'away' in another file")


def test_links_within_the_file(tmp_path: Path) -> None:
    path = map_file(tmp_path / "map.nc", lambda file: file.create_dataset("height", data=HEIGHTS))
    with h5py.File(path, "a") as file:
        # Round in circles, nowhere, and to an array that has another name as well.
        file.create_group("group")["up"] = file["/"]
        file["group/nowhere"] = h5py.SoftLink("/nothing")
        file["group/again"] = file["height"]
        file["group/soft"] = h5py.SoftLink("/height")
        file["type"] = np.dtype("f8")
    assert {"height", "x", "y", "group/again"} >= set(check_hdf5(path)) >= {"x", "y"}
    assert set(check_hdf5(path)) & {"height", "group/again"}


def test_arrays_of_which_little_is_stored(tmp_path: Path) -> None:
    path = map_file(
        tmp_path / "map.nc",
        lambda file: file.create_dataset("height", (60000, 60000), "f8", chunks=(100, 100)),
        (60000, 60000),
    )
    assert path.stat().st_size < 2**21
    assert_rejected(path, "'height' in map.nc holds 26.8 GiB or more, packed into")


def test_huge_axes_raise_format_error(tmp_path: Path) -> None:
    path = map_file(tmp_path / "map.nc", lambda file: file.create_dataset("height", data=HEIGHTS))
    with h5py.File(path, "a") as file:
        file.create_dataset("long", (2**40,), "f8", chunks=(100,)).make_scale("long")
    assert_rejected(path, "'long' in map.nc holds 8192.0 GiB or more, packed into")


@pytest.mark.long
def test_block_larger_than_memory_raises_memory_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = map_file(
        tmp_path / "map.nc",
        lambda file: file.create_dataset(
            "height", data=HEIGHTS, chunks=(3000, 4000), maxshape=(None, None)
        ),
    )
    monkeypatch.setattr(memory, "free_bytes", lambda: 8 * 3000 * 4000 - 1)
    with pytest.raises(InsufficientMemoryError, match=r"one block of 'height' in map.nc needs"):
        read_surface(path)
    monkeypatch.setattr(memory, "free_bytes", lambda: 8 * 3000 * 4000)
    assert read_surface(path).shape == (30, 40)
    path = map_file(tmp_path / "map.nc", lambda file: file.create_dataset("height", data=HEIGHTS))
    monkeypatch.setattr(memory, "free_bytes", lambda: 9600)
    with pytest.raises(InsufficientMemoryError, match=r"the 30 × 40 points of map.nc needs"):
        read_surface(path)
    with pytest.raises(InsufficientMemoryError, match=r"reading map.nc needs"):
        rc.read_result(path)


@needs_reader
def test_instruments_that_write_hdf5(other: Path, tmp_path: Path) -> None:
    path = tmp_path / "map.datx"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["Measurement"] = h5py.ExternalLink(other, "/")
    assert_rejected(path, "map.datx keeps 'Measurement' in another file")
    with h5py.File(path, "w") as file:
        file.create_dataset("Measurement/Surface", (2**20, 2**20), "f8", chunks=(64, 64))
    assert_rejected(path, "'Measurement/Surface' in map.datx holds 8192.0 GiB")


def test_values_of_other_shape_than_axes_raise_format_error(tmp_path: Path) -> None:
    # xarray takes the shape from the axes, and then reads all.
    path = map_file(tmp_path / "map.nc", lambda file: file.create_dataset("height", data=HEIGHTS))
    with h5py.File(path, "a") as file:
        del file["height"]
        large = file.create_dataset("height", (6000, 6000), "f8", chunks=(100, 100))
        large.attrs["units"] = "m"
        for number, name in enumerate("yx"):
            large.dims[number].attach_scale(file[name])
    assert_rejected(path, "height has (6000, 6000) points, its axes (30, 40)")
    with pytest.raises(FormatError, match=r"height has \(6000, 6000\) points"):
        rc.read_result(path)


@pytest.mark.parametrize(
    "attributes",
    [{"_FillValue": HEIGHTS[1, :2]}, {"_FillValue": HEIGHTS[1, 0], "missing_value": HEIGHTS[1, 1]}],
)
def test_all_marks_of_missing_points_are_read(
    tmp_path: Path, attributes: dict[str, object], capfd: pytest.CaptureFixture[str]
) -> None:
    path = map_file(tmp_path / "map.nc", lambda file: file.create_dataset("height", data=HEIGHTS))
    with h5py.File(path, "a") as file:
        file["height"].attrs.update(attributes)
    assert np.argwhere(np.isnan(read_surface(path).heights)).tolist() == [[1, 0], [1, 1]]
    assert capfd.readouterr() == ("", "")


@pytest.mark.long
def test_packed_unsigned_integers_are_unpacked(tmp_path: Path) -> None:
    counts = np.arange(64336, 65536).reshape(30, 40)
    stored = counts.astype("u2").view("i2")
    path = map_file(tmp_path / "map.nc", lambda file: file.create_dataset("height", data=stored))
    packing = {"scale_factor": 1e-9, "add_offset": 1e-6, "_FillValue": stored[:1, 0]}
    with h5py.File(path, "a") as file:
        file["height"].attrs.update({**packing, "_Unsigned": "true"})
    expected = counts * 1e-9 + 1e-6
    expected[0, 0] = np.nan
    np.testing.assert_array_equal(read_surface(path).heights, expected)
    with xarray.open_dataset(path, engine="h5netcdf") as dataset:
        np.testing.assert_allclose(dataset["height"].values, expected, rtol=1e-6)


def test_one_value_that_marks_missing_points(tmp_path: Path) -> None:
    path = map_file(tmp_path / "map.nc", lambda file: file.create_dataset("height", data=HEIGHTS))
    with h5py.File(path, "a") as file:
        file["height"].attrs["_FillValue"] = HEIGHTS[1, 1]
    assert np.argwhere(np.isnan(read_surface(path).heights)).tolist() == [[1, 1]]


@pytest.mark.long
def test_blocks_that_unpack_to_more_than_they_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = np.random.default_rng(0).normal(size=(300, 400)) * 1e-9
    path = map_file(
        tmp_path / "map.nc",
        lambda file: file.create_dataset(
            "height", data=heights, chunks=(100, 100), compression="gzip", shuffle=True
        ),
        (300, 400),
    )
    # All blocks are unpacked before, within this memory.
    monkeypatch.setattr(netcdf_tools, "_DEFLATED", 2**40)
    monkeypatch.setattr(memory, "free_bytes", lambda: 2**26)
    np.testing.assert_array_equal(read_surface(path).heights, heights)
    with h5py.File(path, "a") as file:
        file["height"].id.write_direct_chunk((0, 100), zlib.compress(bytes(2**28)))
    assert_rejected(path, "map.nc cannot be read")


def test_block_larger_than_file_raises_format_error(tmp_path: Path) -> None:
    path = tmp_path / "packed.h5"
    with h5py.File(path, "w") as file:
        made = file.create_dataset(
            "z", data=np.random.default_rng(1).random((64, 64)), chunks=(64, 64), compression="gzip"
        )
        size = made.id.get_chunk_info(0).size
    content = path.read_bytes()
    # The size of the block, in the tree of blocks, and no mask of filters.
    stated, other = (number.to_bytes(4, "little") + bytes(4) for number in (size, 2**31 - 1))
    assert content.count(stated) == 1
    path.write_bytes(content.replace(stated, other))
    assert_rejected(path, "packed.h5 cannot be read as HDF5", unit="um", size="1 mm")


@pytest.mark.parametrize("chunks", [None, (100, 100)])
def test_map_without_stored_values_raises_format_error_unread(
    chunks: tuple[int, int] | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "free_bytes", lambda: 2**60)
    path = tmp_path / "bomb.nc"
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"y": 30000, "x": 30000}
        height = file.create_variable("height", ("y", "x"), "f8", chunks=chunks)
        height.attrs["units"] = "m"
        file.attrs.update({"pixel_y": 1e-6, "pixel_x": 1e-6})
    for channels in (netcdf.channels, matrices.hdf5_channels):
        with pytest.raises(FormatError, match=r"'height' in bomb.nc holds 6.7 GiB or more"):
            channels(path, "")
    # A field over the depth may be zero nearly everywhere.
    with h5py.File(tmp_path / "field.h5", "w") as file:
        file.create_dataset("strain", (1000, 1000, 200), "f8", chunks=(100, 100, 100))
    assert check_hdf5(tmp_path / "field.h5")["strain"].size == 1_600_000_000


def test_heights_over_other_axes_raise_format_error_unread(tmp_path: Path) -> None:
    path = tmp_path / "stack.nc"
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"t": 900, "y": 1000, "x": 1000}
        file.create_variable("height", ("t", "y", "x"), "f8", chunks=(1, 100, 100))
    with pytest.raises(FormatError, match=r"has 'height' over \('t', 'y', 'x'\)"):
        rc.read_surface(path)


GIVEN = {"map.nc": {}, "map.h5": {"unit": "um", "size": "1 mm x 1 mm"}}


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork") or sys.platform == "darwin", reason="no forks here")
@pytest.mark.parametrize(("name", "size"), [("map.nc", 0), ("map.h5", 2**64 - 16)])
def test_heap_without_end_raises_format_error(
    name: str, size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(netcdf_tools, "_READING_SECONDS", 1)
    path = map_file(tmp_path / name, lambda file: file.create_dataset("height", data=HEIGHTS))
    with h5py.File(path, "a") as file:
        file.attrs["source"] = np.array(["a text", "and another"], h5py.string_dtype())
    content = bytearray(path.read_bytes())
    # HDF5 adds the size of an object, modulo 2⁶⁴, to find the next one.
    struct.pack_into(
        "<HHIQ", content, content.index(b"GCOL") + 16, 0 if size == 0 else 9, 0, 0, size
    )
    path.write_bytes(content)
    assert_rejected(path, f"{name} cannot be read", "of computing", **GIVEN[name])
