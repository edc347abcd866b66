"""NetCDF files that contradict themselves are refused before anything of them is read."""

import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import netcdf


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "map.nc"
    rc.Surface(np.arange(12.0).reshape(3, 4) * 1e-7, (1e-6, 2e-6)).save(path)
    return path


def replaced(file: h5py.File, **options: object) -> None:
    """Put another array in the place of the heights, on the same axes."""
    units = file["height"].attrs["units"]
    del file["height"]
    heights = file.create_dataset("height", **options)
    heights.attrs["units"] = units
    for axis, name in zip(heights.dims, "yx", strict=True):
        axis.attach_scale(file[name])


def more_points(file: h5py.File) -> None:
    # 288 MB where its axes say twelve points.
    replaced(file, shape=(6000, 6000), dtype="f8", chunks=(100, 100), fillvalue=1e-6)


def no_fill(file: h5py.File) -> None:
    replaced(file, data=np.ones((3, 4), "i4"))
    file["height"].attrs["_FillValue"] = np.nan


def a_link(file: h5py.File) -> None:
    file.move("height", "elsewhere")
    file["height"] = h5py.SoftLink("/elsewhere")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (more_points, r"height has \(6000, 6000\) points, its axes \(3, 4\)"),
        (no_fill, "height holds integers, but marks missing values by nan"),
        (a_link, "height is not a separate array"),
    ],
)
def test_inconsistent_file_raises_format_error(
    change: Callable[[h5py.File], None], words: str, path: Path
) -> None:
    with h5py.File(path, "a") as file:
        change(file)
    with pytest.raises(rc.FormatError, match=words):
        rc.read_surface(path)


def test_other_hdf5_raises_format_error_without_warning(tmp_path: Path) -> None:
    path = tmp_path / "other.nc"
    with h5py.File(path, "w") as file:
        file["numbers"] = np.ones((3, 4))
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        with pytest.raises(rc.FormatError, match="expected a NetCDF file"):
            rc.read_surface(path)
    assert heard == []


def streamed(values: np.ndarray, packed: bool = False) -> netcdf.Streamed:
    parts = (values[:2], values[2:])
    return netcdf.Streamed("gap", "<f8", values.shape, {"units": "m"}, iter(parts), packed)


def framed(attributes: dict[str, float] | None = None) -> netcdf.Dataset:
    result = netcdf.Dataset(attributes)
    result["y"], result["x"] = ("y", np.arange(5.0)), ("x", np.arange(4.0))
    return result


@pytest.mark.parametrize("packed", [False, True])
def test_map_written_in_parts_has_checksum_of_whole_map(tmp_path: Path, packed: bool) -> None:
    values = np.random.default_rng(0).normal(size=(5, 4))
    frame, whole = framed({"load": 1.0}), framed({"load": 1.0})
    whole["gap"] = (("y", "x"), values, {"units": "m"})
    netcdf.write_streamed(frame, [streamed(values, packed)], tmp_path / "parts.nc")
    netcdf.write(whole, tmp_path / "whole.nc")
    for name in ("parts", "whole"):
        with netcdf.open_dataset(tmp_path / f"{name}.nc") as found:
            np.testing.assert_array_equal(found["gap"].values, values)
            assert netcdf.changed_names(found) == ()
            assert (
                found.attrs[netcdf.CHECKSUM] == netcdf.add_checksums(whole).attrs[netcdf.CHECKSUM]
            )


def test_full_disk_raises_os_error_before_writing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=100))
    with pytest.raises(OSError, match="No space left") as error:
        netcdf.write_streamed(framed(), [streamed(np.ones((5, 4)))], tmp_path / "out.nc")
    assert error.value.filename == str(tmp_path / "out.nc")
    assert list(tmp_path.iterdir()) == []
