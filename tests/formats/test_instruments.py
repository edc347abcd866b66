import itertools
import struct
import sys
import warnings
from decimal import Decimal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import vendors
from reading import HEIGHTS, assert_rejected, measurement, needs_reader, write
from roughcontact.errors import InputError
from roughcontact.formats import instruments, readers
from roughcontact.formats.read import SUFFIXES, channels, read_surface
from roughcontact.formats.source import Channel
from roughcontact.report import python_script

# Measured files: the table of shared/measurements/README.md, in µm, columns × rows


@needs_reader
@pytest.mark.parametrize(
    ("name", "grid", "pixel", "span", "sq", "missing"),
    [
        ("wyko_nt1100_test_1.opd", (736, 480), "1.6342 1.9066", "-8.04 10.80", "1.927 1.927", 809),
        ("sur-2.sur", (563, 484), "3.484 3.484", "8.912 10.388", "0.01752 0.01710", 117),
        ("x3p-2.x3p", (650, 650), "0.1277 0.3146", "-0.314 0.240", "0.0773 0.0772", 0),
        ("bullet_land_fixed.x3p", (918, 256), "2.58 2.58", "-79.5 52.5", "34.33 33.64", 25292),
        # README.md prints 0.1192; the standard deviation of the integers in the file, read without
        # any library and times the header's scale, is 0.119147.
        ("dvd_afm.sur", (512, 512), "0.01957 0.01958", "-0.297 0.329", "0.1191 0.0557", 0),
        ("metropro-1.dat", (640, 480), "1.0983 1.0983", "50.11 51.47", "0.0753 0.0133", 0),
        ("opd-1.opd", (640, 480), "0.1967 0.1967", "-0.353 -0.223", "0.00836 0.00671", 116),
        ("mnt-1.mnt", (960, 600), "1.8534 1.8546", "49.37 51.59", "0.02456 0.02437", 0),
        ("uncd_afm.001", (512, 512), "1.95e-4 1.95e-4", "-1.761 -1.648", "0.0278 0.0047", 0),
    ],
)
def test_measurements_agree_with_the_table(
    name: str,
    grid: tuple[int, int],
    pixel: str,
    span: str,
    sq: str,
    missing: int,
    capfd: pytest.CaptureFixture[str],
) -> None:
    surface = read_surface(measurement(name))
    assert surface.shape == grid[::-1]
    assert surface.missing == missing
    read = [
        *surface.pixel[::-1],
        float(np.nanmin(surface.heights)),
        float(np.nanmax(surface.heights)),
        surface.Sq,
        surface.leveled("plane").Sq,
    ]
    for value, printed in zip(read, f"{pixel} {span} {sq}".split(), strict=True):
        # Half a unit of the last digit printed.
        exponent = Decimal(printed).as_tuple().exponent
        assert value * 1e6 == pytest.approx(float(printed), abs=0.51 * 10.0**exponent, rel=0)
    assert surface.provenance.source == name
    assert surface.provenance.instrument
    assert capfd.readouterr().out == ""


@needs_reader
def test_rows_and_columns_are_not_swapped() -> None:
    path = measurement("x3p-2.x3p")
    surface = read_surface(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from SurfaceTopography.IO import read_topography

        reference = read_topography(str(path), format="x3p")
    # The grid is square, so the axes differ in content and pixel only.
    np.testing.assert_array_equal(surface.heights[3, 7:99], reference.heights()[7:99, 3])
    assert surface.pixel == pytest.approx((3.14582114e-07, 1.27656510e-07), rel=1e-8)


@needs_reader
def test_truncated_measurement_raises_format_error() -> None:
    name = "di_corrupted.di"
    assert_rejected(measurement(name), name, "cannot be read as format 'di'")


@needs_reader
def test_archive_in_a_folder_is_read_like_one_without() -> None:
    original, fixed = (
        read_surface(measurement(f"bullet_land_{state}.x3p")) for state in ("original", "fixed")
    )
    np.testing.assert_array_equal(original.heights, fixed.heights)
    assert original.pixel == fixed.pixel == pytest.approx((2.58e-6, 2.58e-6))


@needs_reader
def test_bruker_channels_of_same_name_are_distinguished() -> None:
    path = measurement("uncd_afm.001")
    found = channels(path)
    assert [entry.name for entry in found] == ["Height", "Height", "Phase", "AmplitudeError"]
    assert [entry.is_height for entry in found] == [True, True, False, False]
    assert found[0] == Channel("Height", "nm", True, (512, 512))
    # Two of one name, which are not the same.
    assert read_surface(path).provenance.channel == "Height (index 0)"
    assert read_surface(path, channel=1).provenance.channel == "Height (index 1)"
    assert not np.array_equal(read_surface(path, channel=1).heights, read_surface(path).heights)
    assert_rejected(path, "not a height", "0: 'Height' [nm]", channel="Phase", kind=InputError)
    assert_rejected(path, "not a height", channel=3, kind=InputError)
    assert_rejected(path, "several channels named 'Height'", channel="Height", kind=InputError)
    assert_rejected(path, "no channel 'Z'", channel="Z", kind=InputError)
    assert_rejected(path, "no channel 4", channel=4, kind=InputError)
    assert_rejected(path, "no channel -1", channel=-1, kind=InputError)


@needs_reader
def test_unit_and_size_in_the_file_are_not_overruled() -> None:
    path = measurement("opd-1.opd")
    assert_rejected(path, "contains its unit", unit="um", kind=InputError)
    assert_rejected(path, "contains its size", size="1 mm x 1 mm", kind=InputError)


@needs_reader
def test_spacing_of_nanofocus_is_in_nanometers(tmp_path: Path) -> None:
    content, _, _ = vendors.nms()
    for edge in vendors.PIXEL:
        # Millimeters, as the library assumes.
        content = content.replace(struct.pack("<d", 1e3 * edge), struct.pack("<d", 1e9 * edge))
    assert read_surface(write(tmp_path, "map.nms", content)).pixel == pytest.approx(vendors.PIXEL)


@needs_reader
def test_a_size_a_million_times_too_large_is_replaced(tmp_path: Path) -> None:
    content, _, _ = vendors.zmg()
    path = write(tmp_path, "map.zmg", content)
    sound = read_surface(path)
    for edge in vendors.PIXEL:
        content = content.replace(struct.pack("<f", 1e6 * edge), struct.pack("<f", 1e12 * edge), 1)
    path = write(tmp_path, "map.zmg", content)
    assert_rejected(
        path, "sides (y, x) of 30 m × 44 m", 'size="0.1 mm x 0.2 mm" and override_size=True'
    )
    assert_rejected(path, "leave out size", size="30 um x 44 um", kind=InputError)
    surface = read_surface(path, size="30 um x 44 um", override_size=True)
    assert surface.pixel == pytest.approx(sound.pixel)
    np.testing.assert_array_equal(surface.heights, sound.heights)
    (step,) = surface.provenance.steps
    assert "30 m × 44 m, as the file gives them, replaced by 30 µm × 44 µm" in step
    assert 'size="30 um x 44 um", override_size=True)' in python_script.script_of_map(surface)


@needs_reader
@pytest.mark.parametrize("name", ["sur-2.sur", "opd-1.opd", "metropro-1.dat", "mnt-1.mnt"])
@pytest.mark.parametrize("fraction", [0.001, 0.5])
def test_truncated_files_raise_format_error(tmp_path: Path, name: str, fraction: float) -> None:
    content = measurement(name).read_bytes()
    assert_rejected(write(tmp_path, name, content[: int(fraction * len(content))]), name, "format")


# Instrument files without the shared folder


@needs_reader
@pytest.mark.parametrize("suffix", sorted(itertools.chain(*instruments.SUFFIXES.values())))
@pytest.mark.parametrize("content", [b"hello world\n" * 50, b"\0" * 5000, bytes(range(256)) * 20])
def test_other_content_raises_format_error_for_every_suffix(
    tmp_path: Path, suffix: str, content: bytes
) -> None:
    # Text under a suffix that other programs give to theirs is read as such.
    text = suffix == ".dat" and content.startswith(b"hello")
    words = "has 'hello' in line 1" if text else f"wrong{suffix} "
    assert_rejected(write(tmp_path, f"wrong{suffix}", content), words)


@needs_reader
def test_every_suffix_has_a_reader() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from SurfaceTopography.IO import lookup_reader_by_format
    assert set(instruments.SUFFIXES) <= set(lookup_reader_by_format)
    assert "hgt" not in SUFFIXES.values()


def sdf(x_scale: float = 1e-6, z_scale: float = 1e-9, points: int = 4) -> str:
    """Return an ISO 25178-71 text file of 3 rows with pixel dy = 2 µm."""
    header = {
        "ManufacID": "test",
        "CreateDate": "010120240000",
        "ModDate": "010120240000",
        "NumPoints": points,
        "NumProfiles": 3,
        "Xscale": x_scale,
        "Yscale": 2e-6,
        "Zscale": z_scale,
        "Zresolution": -1,
        "Compression": 0,
        "DataType": 7,
        "CheckType": 0,
    }
    lines = ["aISO-1.0", *(f"{key} = {value}" for key, value in header.items()), "*"]
    lines += [" ".join("BAD" if np.isnan(z) else str(z) for z in row) for row in HEIGHTS]
    return "\n".join([*lines, "*"]) + "\n"


@needs_reader
def test_instrument_file_has_package_axes_and_units(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, "map.sdf", sdf())
    surface = read_surface(path)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-9, rtol=1e-12)
    assert surface.provenance.source == "map.sdf"
    assert channels(path)[0].shape == (3, 4)
    assert capfd.readouterr().out == ""
    np.testing.assert_array_equal(
        read_surface(write(tmp_path, "map.bin", sdf()), format="sdf").heights, surface.heights
    )


@needs_reader
def test_implausible_scales_raise_format_error(tmp_path: Path) -> None:
    path = write(tmp_path, "map.sdf", sdf(x_scale=1.0))
    assert_rejected(path, "map.sdf", "pixel (dy, dx) of 2 µm × 1 m", "check the unit")
    assert_rejected(write(tmp_path, "a.sdf", sdf(x_scale=1e-13)), "a.sdf", "sides (y, x)", "400 fm")
    assert_rejected(write(tmp_path, "b.sdf", sdf(z_scale=1.0)), "heights that span 11.5 m", "6 µm")


def test_heights_far_from_zero_raise_format_error(tmp_path: Path) -> None:
    # Few digits are left there for the roughness.
    path = write(tmp_path, "far.csv", "11.0,11.0\n11.0,11.01\n")
    words = ("heights from 11 m to 11.01 m", "further than 10 m from zero")
    assert_rejected(path, *words, unit="m", size="10 mm")
    assert read_surface(path, unit="mm", size="10 mm").heights[0, 0] == 0.011


class FakeReader:
    """A reader with channels as SurfaceTopography describes them."""

    def __init__(self, *entries: SimpleNamespace) -> None:
        self.channels = entries
        self.default_channel = entries[0]

    def __enter__(self) -> "FakeReader":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def name(self) -> str:
        return "Fake"


def entry(index: int = 0, **changes: object) -> SimpleNamespace:
    def topography(physical_sizes: tuple[float, float] | None = None) -> SimpleNamespace:
        sizes = given.physical_sizes if physical_sizes is None else physical_sizes
        values = np.ma.masked_invalid(HEIGHTS.T)
        return SimpleNamespace(
            heights=lambda: values, pixel_size=(sizes[0] / 4, sizes[1] / 3), unit=given.unit
        )

    given = SimpleNamespace(
        index=index,
        name="Height",
        dim=2,
        nb_grid_pts=(4, 3),
        physical_sizes=(4.0, 6.0),
        unit="µm",
        data_unit="µm",
        is_height_channel=True,
        info={},
        topography=topography,
    )
    given.__dict__.update(changes)
    return given


def fake(monkeypatch: pytest.MonkeyPatch, *entries: SimpleNamespace) -> None:
    monkeypatch.setattr(
        instruments, "_opener", lambda path, kind: lambda stream: FakeReader(*entries)
    )


def test_output_of_reader_has_package_axes_and_units(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(monkeypatch, entry())
    surface = read_surface(write(tmp_path, "map.opd", "x" * 99))
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-15)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))
    assert surface.provenance.channel == ""


def test_missing_unit_or_size_raises_input_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path, "map.opd", "x" * 99)
    fake(monkeypatch, entry(unit=None, data_unit=None))
    assert_rejected(path, "map.opd gives no unit", 'unit="um"', kind=InputError)
    assert_rejected(path, "contains its size", unit="nm", size="1 um x 1 um", kind=InputError)
    assert read_surface(path, unit="nm").pixel == pytest.approx((2e-9, 1e-9))
    fake(monkeypatch, entry(physical_sizes=None))
    assert_rejected(path, "map.opd gives no lengths of its sides", "(y, x)", kind=InputError)
    assert read_surface(path, size="6 um x 8 um").pixel == pytest.approx((2e-6, 2e-6))
    fake(monkeypatch, entry(unit="quux", data_unit="quux"))
    assert_rejected(path, "no height map")


@pytest.mark.parametrize(
    ("changes", "is_height"),
    [
        ({"name": "ZSensor"}, True),
        ({"name": "Height Sensor"}, True),
        ({"name": "Topography", "unit": "Å", "data_unit": "Å"}, True),
        ({"name": "Amplitude Error"}, False),
        ({"name": "Deflection Error"}, False),
        ({"name": "Phase"}, False),
        ({"name": "Input1"}, False),
        ({"unit": ("nm", None), "data_unit": ("nm", None)}, False),
        ({"data_unit": "V"}, False),
        ({"data_unit": "nm"}, False),  # lengths along x and z in different units: not guessed
        ({"dim": 1}, False),
        ({"is_height_channel": False}, False),
    ],
)
def test_channel_is_height_by_its_unit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, object], is_height: bool
) -> None:
    fake(monkeypatch, entry(**changes))
    path = write(tmp_path, "scan.003", "x" * 99)
    assert channels(path)[0].is_height is is_height
    if not is_height:
        assert_rejected(path, "scan.003 holds no height map", "(not a height)")


def test_first_height_channel_is_default(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch, entry(name="Phase", data_unit="deg"), entry(1, name="ZSensor"))
    path = write(tmp_path, "scan.spm", "x" * 99)
    assert read_surface(path).provenance.channel == "ZSensor"
    assert read_surface(path, channel="1").provenance.channel == "ZSensor"


def test_huge_grids_raise_format_error_before_allocation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(monkeypatch, entry(nb_grid_pts=(10**7, 10**7), topography=None))
    assert_rejected(write(tmp_path, "map.opd", "x" * 99), "announces 10000000 × 10000000 points")


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (AssertionError(), "AssertionError"),
        (MemoryError("too\nmuch"), "more memory than is free"),
        (RecursionError("x"), "RecursionError"),
    ],
)
def test_any_failure_of_the_reader_is_a_format_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, words: str
) -> None:
    def topography() -> None:
        raise error

    fake(monkeypatch, entry(topography=topography))
    path = write(tmp_path, "map.opd", "x" * 99)
    assert_rejected(path, "map.opd cannot be read as format 'opd'", words)


def test_missing_library_names_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Another test may have imported the reader.
    for name in [name for name in sys.modules if name.startswith(readers.__name__ + ".")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    monkeypatch.setitem(sys.modules, "SurfaceTopography.IO", None)
    assert_rejected(write(tmp_path, "map.opd", "x"), "pip install 'roughcontact[io]'")


def test_file_without_heights_raises_format_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Also where its header would be compared with them.
    nothing = SimpleNamespace(
        heights=lambda: np.ma.masked_all((4, 3)), pixel_size=(1.0, 2.0), unit="µm"
    )
    fake(monkeypatch, entry(info={"raw_metadata": {"a": 1}}, topography=lambda: nothing))
    for suffix in ("opd", "sur", "mnt"):
        assert_rejected(write(tmp_path, f"map.{suffix}", "x" * 99), "has no finite value")
