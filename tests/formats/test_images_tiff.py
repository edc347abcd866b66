"""Heights in TIFF."""

from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected
from roughcontact.errors import InputError
from roughcontact.formats.read import channels, read_surface
from roughcontact.formats.source import Channel

tifffile = pytest.importorskip("tifffile")

DATA = Path(__file__).parents[1] / "data"
VALUES = np.arange(12.0, dtype=np.float32).reshape(3, 4)
SIZE = {"unit": "um", "size": (6e-6, 4e-6)}


def test_real_numbers_are_heights() -> None:
    path = DATA / "float32.tif"
    surface = read_surface(path, unit="um", size=(32e-6, 48e-6))
    assert surface.shape == (32, 48)
    assert surface.heights.std() == pytest.approx(0.199884e-6, rel=1e-5)
    assert channels(path) == (Channel("page 1", "", True, (32, 48)),)


@pytest.mark.parametrize("kind", ["u1", "u2", "i2"])
def test_integers_need_the_height_of_a_count(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "map.tif"
    tifffile.imwrite(path, VALUES.astype(kind))
    assert_rejected(path, "integers: brightness", "0.1 nm", kind=InputError, **SIZE)
    surface = read_surface(path, unit="0.5 nm", size=(6e-6, 4e-6))
    np.testing.assert_allclose(surface.heights, 0.5e-9 * VALUES)


def test_scale_of_imagej_and_ome_is_read(tmp_path: Path) -> None:
    path = tmp_path / "imagej.tif"
    tifffile.imwrite(
        path, VALUES, imagej=True, resolution=(4, 2), metadata={"unit": "micron", "axes": "YX"}
    )
    assert read_surface(path, unit="um").pixel == pytest.approx((0.5e-6, 0.25e-6))
    path = tmp_path / "map.ome.tif"
    tifffile.imwrite(
        path,
        VALUES,
        metadata={"axes": "YX", "PhysicalSizeX": 0.2, "PhysicalSizeY": 300}
        | {"PhysicalSizeXUnit": "µm", "PhysicalSizeYUnit": "nm"},
    )
    assert read_surface(path, unit="um").pixel == pytest.approx((0.3e-6, 0.2e-6))


def test_dots_per_inch_are_no_scale(tmp_path: Path) -> None:
    path = tmp_path / "map.tif"
    tifffile.imwrite(path, VALUES, resolution=(72, 72), resolutionunit=2)
    assert_rejected(path, "no lengths of its sides", unit="um", kind=InputError)


def test_pages_are_channels_and_nodata_tag_marks_missing(tmp_path: Path) -> None:
    path = tmp_path / "map.tif"
    with tifffile.TiffWriter(path) as file:
        file.write(VALUES)
        file.write(VALUES + 1, extratags=[(42113, "s", 0, "5", True)])
    assert read_surface(path, **SIZE).heights.max() == pytest.approx(11e-6)
    surface = read_surface(path, channel="page 2", **SIZE)
    assert np.isnan(surface.heights[1, 0])
    assert surface.missing == 1


def test_color_image_has_no_heights(tmp_path: Path) -> None:
    path = tmp_path / "photo.tif"
    tifffile.imwrite(path, np.zeros((4, 5, 3), np.uint8), photometric="rgb")
    assert_rejected(path, "color image, no heights")
