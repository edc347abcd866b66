"""Images of JPK in HDF5, written after the layout of its files."""

from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected
from roughcontact.errors import InputError
from roughcontact.formats.read import channels, read_surface

h5py = pytest.importorskip("h5py")

COUNTS = np.arange(12, dtype=np.int32).reshape(3, 4)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "image.h5-jpk"
    grid = {"ilength": 4, "jlength": 3, "ulength": 4e-7, "vlength": 6e-7, "unit.unit": b"m"}
    with h5py.File(path, "w") as file:
        group = file.create_group("Measurement_000")
        group.attrs.update({f"position-pattern.grid.{key}": grid[key] for key in grid})
        names = ("Error Signal", b"false"), ("Height", b"false"), ("Height", b"true")
        for number, (name, back) in enumerate(names):
            part = group.create_group(f"Channel_00{number}")
            scaling = {"multiplier": -2e-10, "offset": 1e-7, "unit.unit": b"m"}
            part.attrs.update({f"net-encoder.scaling.{key}": scaling[key] for key in scaling})
            part.attrs.update({"channel.name": b"x", "channel.fancy-name": name, "retrace": back})
            columns = np.stack([COUNTS.ravel() + number, COUNTS.ravel() + 100], axis=1)
            part.create_dataset("Height", data=columns)
            part.create_dataset("thumbnail", data=np.zeros((4, 1), np.int32))
    return path


def test_frame_of_first_height_channel_is_the_default(path: Path) -> None:
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, (1e-7 - 2e-10 * (COUNTS + 1))[::-1])
    assert surface.pixel == pytest.approx((2e-7, 1e-7))
    assert surface.provenance.channel == "Height, frame 1"


def test_other_channels_are_listed_and_not_heights(path: Path) -> None:
    listed = channels(path)
    assert [entry.name for entry in listed if entry.is_height] == [
        f"Height{back}, frame {number}" for back in ("", ", retrace") for number in (1, 2)
    ]
    surface = read_surface(path, channel="Height, retrace, frame 2")
    np.testing.assert_allclose(surface.heights, (1e-7 - 2e-10 * (COUNTS + 100))[::-1])
    assert_rejected(path, "is not a height", channel="Error Signal, frame 1", kind=InputError)
