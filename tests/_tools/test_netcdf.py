"""NetCDF files that contradict themselves are refused before anything of them is read."""

import warnings
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

import roughcontact as rc


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


def a_link(file: h5py.File) -> None:
    file.move("height", "elsewhere")
    file["height"] = h5py.SoftLink("/elsewhere")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (more_points, r"height has \(6000, 6000\) points, its axes \(3, 4\)"),
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
    # Python 3.12 and later warn of a fork of a process with threads.
    assert [entry for entry in heard if "fork()" not in str(entry.message)] == []
