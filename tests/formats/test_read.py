import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from reading import HEIGHTS, assert_rejected, write
from roughcontact.errors import FormatError, InputError
from roughcontact.formats.read import FORMATS, channels, read_surface
from roughcontact.formats.source import Channel

# Files that are none


def test_invalid_paths_raise_error(tmp_path: Path) -> None:
    assert_rejected(tmp_path / "absent.opd", "absent.opd does not exist")
    with pytest.raises(
        FormatError, match=r"absent\.opd does not exist; check the name of the file$"
    ):
        read_surface(tmp_path / "absent.opd")
    assert_rejected(tmp_path, "is a directory")
    assert_rejected(write(tmp_path, "empty.opd", ""), "empty.opd is empty")
    assert_rejected(
        write(tmp_path, "map.abc", b"\0"), "unknown suffix '.abc'", ".x3p", "give format or"
    )
    assert_rejected(write(tmp_path, "map", b"\0"), "unknown suffix ''")
    assert_rejected(write(tmp_path, "map.opd", "1"), "'hgt'", format="hgt", kind=InputError)
    assert_rejected(Path("a\0b.opd"), "does not exist")


# The program's own files


def write_netcdf(path: Path, attributes: dict[str, float] | None = None, **changes: object) -> Path:
    import xarray

    height = {"dims": ("y", "x"), "data": HEIGHTS * 1e-9, "attrs": {"units": "m"}, **changes}
    y, x = (np.arange(3) + 0.5) * 2e-6, (np.arange(4) + 0.5) * 1e-6
    dataset = xarray.Dataset(
        {"height": (height["dims"], height["data"], height["attrs"])},
        coords={"y": y, "x": x},
        attrs=attributes or {},
    )
    dataset.to_netcdf(path, engine="h5netcdf")
    return path


def test_netcdf(tmp_path: Path) -> None:
    path = write_netcdf(tmp_path / "map.nc")
    surface = read_surface(path)
    np.testing.assert_array_equal(surface.heights, HEIGHTS * 1e-9)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))
    assert channels(path) == (Channel("height", "m", True, (3, 4)),)
    path = write_netcdf(tmp_path / "b.nc", {"pixel_y": 3e-6, "pixel_x": 5e-6})
    assert read_surface(path).pixel == (3e-6, 5e-6)
    assert_rejected(path, "contains its unit", unit="m", kind=InputError)


def test_netcdf_of_another_kind(tmp_path: Path) -> None:
    assert_rejected(
        write_netcdf(tmp_path / "a.nc", attrs={"units": "um"}), "units 'um'", "'height' [m]"
    )
    assert_rejected(write_netcdf(tmp_path / "b.nc", attrs={}), "units None")
    assert_rejected(
        write(tmp_path, "c.nc", "no HDF5 at all"), "c.nc cannot be read", "'height' [m]"
    )
    content = write_netcdf(tmp_path / "d.nc").read_bytes()
    assert_rejected(write(tmp_path, "e.nc", content[: len(content) // 2]), "e.nc cannot be read")


def test_import_loads_no_readers() -> None:
    code = (
        "import sys, roughcontact.formats.read; "
        "sys.exit(bool({'SurfaceTopography', 'xarray', 'pint', 'h5py'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_provenance_keeps_arguments_and_findings_of_reading(tmp_path: Path) -> None:
    path = tmp_path / "bare.npz"
    np.savez(path, other=np.eye(4), heights=np.eye(4))
    surface = read_surface(path, channel="other", unit="um", size=(4e-6, np.float64(8e-6)))
    origin = surface.provenance.origin
    assert origin is not None
    assert origin.method == "read_surface"
    assert origin.arguments == {
        "path": "bare.npz",
        "format": None,
        "channel": "other",
        "unit": "um",
        "size": (4e-6, 8e-6),
    }
    assert origin.found == {"format": "npz", "size": (4e-6, 8e-6), "unit": 1e-6, "notes": ()}
    assert surface.provenance.operations == ()


def test_uneven_axes_raise_format_error(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    import xarray

    for number, y in enumerate(([0.0], [0.0, np.inf, 1.0], [1e308, -1e308, 1e308])):
        heights = np.zeros((len(y), 4))
        dataset = xarray.Dataset(
            {"height": (("y", "x"), heights, {"units": "m"})},
            coords={"y": y, "x": np.arange(4) * 1e-6},
        )
        dataset.to_netcdf(tmp_path / f"{number}.nc", engine="h5netcdf")
        assert_rejected(tmp_path / f"{number}.nc", "nor evenly spaced coordinates")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("encoding", ["cp1252", "utf-16", "utf-16-be"])
def test_a_text_is_read_in_its_own_encoding(tmp_path: Path, encoding: str) -> None:
    text = "# Width: 4.000 µm\n# Height: 3.000 µm\n# Value units: µm\n1 2 3 4\n5 6 7 8\n9 8 7 6\n"
    surface = read_surface(write(tmp_path, "map.txt", text.encode(encoding)))
    assert surface.size == pytest.approx((3e-6, 4e-6))
    assert surface.heights[2, 0] == pytest.approx(9e-6)


def test_page_of_formats_describes_every_format() -> None:
    pages = Path(__file__).parents[2] / "docs" / "formats.toml"
    about = tomllib.loads(pages.read_text(encoding="utf-8"))
    assert about.keys() == {known.name for known in FORMATS}
    assert all(entry.keys() == {"maker", "read", "not", "checked"} for entry in about.values())
