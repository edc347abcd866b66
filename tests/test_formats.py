import importlib.util
import itertools
import subprocess
import sys
import warnings
from decimal import Decimal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from roughcontact.errors import FormatError, InputError
from roughcontact.formats import instruments
from roughcontact.formats.read import SUFFIXES, channels, read_surface
from roughcontact.formats.source import Channel

MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"

needs_reader = pytest.mark.skipif(
    importlib.util.find_spec("SurfaceTopography") is None, reason="SurfaceTopography is absent"
)

# Anisotropic grid and pixel, so that a swap of axes shows.
HEIGHTS = np.array([[0.0, 1.0, 2.0, 3.0], [4.0, np.nan, 6.0, 7.0], [8.0, 9.0, 10.0, 11.5]])


def measurement(name: str) -> Path:
    path = MEASUREMENTS / name
    if not path.exists():
        pytest.skip(f"shared/measurements/{name} is absent")
    return path


def write(tmp_path: Path, name: str, content: str | bytes) -> Path:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def refused(
    path: Path, *words: str, kind: type[InputError] = FormatError, **arguments: object
) -> None:
    """Check that reading fails with one sentence that names the file and has these words."""
    with pytest.raises(InputError) as caught:
        read_surface(path, **arguments)  # type: ignore[arg-type]
    assert type(caught.value) is kind
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message


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
    # The grid is square, so only the content and the pixel tell the axes apart.
    np.testing.assert_array_equal(surface.heights[3, 7:99], reference.heights()[7:99, 3])
    assert surface.pixel == pytest.approx((3.14582114e-07, 1.27656510e-07), rel=1e-8)


@needs_reader
@pytest.mark.parametrize("name", ["bullet_land_original.x3p", "di_corrupted.di"])
def test_bad_measurements_are_refused(name: str) -> None:
    refused(measurement(name), name, "cannot be read as format", "check that the file is complete")


@needs_reader
def test_bruker_channels_are_told_apart() -> None:
    path = measurement("uncd_afm.001")
    found = channels(path)
    assert [entry.name for entry in found] == ["Height", "Height", "Phase", "AmplitudeError"]
    assert [entry.is_height for entry in found] == [True, True, False, False]
    assert found[0] == Channel("Height", "nm", True, (512, 512))
    assert read_surface(path).provenance.channel == "Height"
    assert not np.array_equal(read_surface(path, channel=1).heights, read_surface(path).heights)
    refused(path, "not a height", "0: 'Height' [nm]", channel="Phase", kind=InputError)
    refused(path, "not a height", channel=3, kind=InputError)
    refused(path, "several channels named 'Height'", channel="Height", kind=InputError)
    refused(path, "no channel 'Z'", channel="Z", kind=InputError)
    refused(path, "no channel 4", channel=4, kind=InputError)
    refused(path, "no channel -1", channel=-1, kind=InputError)


@needs_reader
def test_unit_and_size_in_the_file_are_not_overruled() -> None:
    path = measurement("opd-1.opd")
    refused(path, "gives its unit itself", unit="um", kind=InputError)
    refused(path, "gives its size itself", size="1 mm x 1 mm", kind=InputError)


@needs_reader
@pytest.mark.parametrize("name", ["sur-2.sur", "opd-1.opd", "metropro-1.dat", "mnt-1.mnt"])
@pytest.mark.parametrize("fraction", [0.001, 0.5])
def test_truncated_files_are_refused(tmp_path: Path, name: str, fraction: float) -> None:
    content = measurement(name).read_bytes()
    refused(write(tmp_path, name, content[: int(fraction * len(content))]), name, "cannot be read")


# Instrument files without the shared folder


@needs_reader
@pytest.mark.parametrize("suffix", sorted(itertools.chain(*instruments.SUFFIXES.values())))
@pytest.mark.parametrize("content", [b"hello world\n" * 50, b"\0" * 5000, bytes(range(256)) * 20])
def test_other_content_is_refused_for_every_suffix(
    tmp_path: Path, suffix: str, content: bytes
) -> None:
    refused(write(tmp_path, f"wrong{suffix}", content), f"wrong{suffix} cannot be read as format")


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
        "ManufacID": "test", "CreateDate": "010120240000", "ModDate": "010120240000",
        "NumPoints": points, "NumProfiles": 3, "Xscale": x_scale, "Yscale": 2e-6,
        "Zscale": z_scale, "Zresolution": -1, "Compression": 0, "DataType": 7, "CheckType": 0,
    }  # fmt: skip
    lines = ["aISO-1.0", *(f"{key} = {value}" for key, value in header.items()), "*"]
    lines += [" ".join("BAD" if np.isnan(z) else str(z) for z in row) for row in HEIGHTS]
    return "\n".join([*lines, "*"]) + "\n"


@needs_reader
def test_instrument_file_in_our_axes_and_units(
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
def test_implausible_scales_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "map.sdf", sdf(x_scale=1.0))
    refused(path, "map.sdf", "pixel (dy, dx) of 2 µm × 1 m", "check the unit")
    refused(write(tmp_path, "a.sdf", sdf(x_scale=1e-13)), "a.sdf", "sides (y, x)", "400 fm")
    refused(write(tmp_path, "b.sdf", sdf(z_scale=1.0)), "heights that span 11.5 m", "6 µm")


def test_heights_far_from_zero_are_refused(tmp_path: Path) -> None:
    # Few digits are left there for the roughness.
    path = write(tmp_path, "far.csv", "11.0,11.0\n11.0,11.01\n")
    words = ("heights from 11 m to 11.01 m", "further than 10 m from zero")
    refused(path, *words, unit="m", size="10 mm")
    assert read_surface(path, unit="mm", size="10 mm").heights[0, 0] == 0.011


@pytest.mark.parametrize("size", ["1 px", "1 mm x 1 px", "1 mm x"])
def test_an_x_in_a_unit_parts_no_size(tmp_path: Path, size: str) -> None:
    path = write(tmp_path, "map.csv", TEXTS["comma"])
    refused(path, repr(size.split(" x ")[-1]), unit="um", size=size, kind=InputError)
    assert read_surface(path, unit="um", size="6umx4um").pixel == pytest.approx((2e-6, 1e-6))


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
        index=index, name="Height", dim=2, nb_grid_pts=(4, 3), physical_sizes=(4.0, 6.0), unit="µm",
        data_unit="µm", is_height_channel=True, info={}, topography=topography,
    )  # fmt: skip
    given.__dict__.update(changes)
    return given


def fake(monkeypatch: pytest.MonkeyPatch, *entries: SimpleNamespace) -> None:
    def open_topography(stream: object, format: str) -> FakeReader:  # noqa: A002
        print("noise of a parser")
        warnings.warn("noise of a library", UserWarning, stacklevel=1)
        return FakeReader(*entries)

    library = SimpleNamespace(open_topography=open_topography)
    monkeypatch.setattr(instruments, "_surface_topography", lambda path: library)


def test_noise_of_the_reader_stays_inside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    fake(monkeypatch, entry())
    surface = read_surface(write(tmp_path, "map.opd", "x" * 99))
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-15)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))
    assert surface.provenance.channel == ""
    assert capfd.readouterr() == ("", "")


def test_no_unit_and_no_size_in_the_file_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path, "map.opd", "x" * 99)
    fake(monkeypatch, entry(unit=None, data_unit=None))
    refused(path, "map.opd gives no unit", "unit='um'", kind=InputError)
    refused(path, "gives its size itself", unit="nm", size="1 um x 1 um", kind=InputError)
    assert read_surface(path, unit="nm").pixel == pytest.approx((2e-9, 1e-9))
    fake(monkeypatch, entry(physical_sizes=None))
    refused(path, "map.opd gives no lengths of its sides", "(y, x)", kind=InputError)
    assert read_surface(path, size="6 um x 8 um").pixel == pytest.approx((2e-6, 2e-6))
    fake(monkeypatch, entry(unit="quux", data_unit="quux"))
    refused(path, "no height map")


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
def test_what_counts_as_a_height(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, object], is_height: bool
) -> None:
    fake(monkeypatch, entry(**changes))
    path = write(tmp_path, "scan.003", "x" * 99)
    assert channels(path)[0].is_height is is_height
    if not is_height:
        refused(path, "scan.003 holds no height map", "(not a height)")


def test_the_first_height_where_the_default_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(monkeypatch, entry(name="Phase", data_unit="deg"), entry(1, name="ZSensor"))
    path = write(tmp_path, "scan.spm", "x" * 99)
    assert read_surface(path).provenance.channel == "ZSensor"
    assert read_surface(path, channel="1").provenance.channel == "ZSensor"


def test_absurd_grids_are_refused_before_memory_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(monkeypatch, entry(nb_grid_pts=(10**7, 10**7), topography=None))
    refused(write(tmp_path, "map.opd", "x" * 99), "announces 10000000 × 10000000 points")


@pytest.mark.parametrize("error", [AssertionError(), MemoryError("too\nmuch"), RecursionError("x")])
def test_any_failure_of_the_reader_is_a_format_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def topography() -> None:
        raise error

    fake(monkeypatch, entry(topography=topography))
    path = write(tmp_path, "map.opd", "x" * 99)
    refused(path, "map.opd cannot be read as format 'opd'", type(error).__name__)


def test_missing_library_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    monkeypatch.setitem(sys.modules, "SurfaceTopography.IO", None)
    refused(write(tmp_path, "map.opd", "x"), "pip install 'roughcontact[io]'")


# Files that are none


def test_files_that_are_none(tmp_path: Path) -> None:
    refused(tmp_path / "absent.opd", "absent.opd does not exist")
    with pytest.raises(
        FormatError, match=r"absent\.opd does not exist; check the name of the file$"
    ):
        read_surface(tmp_path / "absent.opd")
    refused(tmp_path, "is a directory")
    refused(write(tmp_path, "empty.opd", ""), "empty.opd is empty")
    refused(write(tmp_path, "map.xyz", "1"), "unknown suffix '.xyz'", ".x3p", "format=")
    refused(write(tmp_path, "map", "1"), "unknown suffix ''")
    refused(write(tmp_path, "map.opd", "1"), "'hgt'", format="hgt", kind=InputError)
    refused(Path("a\0b.opd"), "does not exist")


# Matrices of numbers

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


def test_a_text_that_may_be_cut_off_says_so(tmp_path: Path) -> None:
    for end, told in (("", True), ("\n", False), ("\r\n", False), ("\n# end", True)):
        path = write(tmp_path, "map.csv", "1,2\n3,4\n5,6" + end)
        surface = read_surface(path, unit="nm", size="30 nm x 20 nm")
        assert surface.shape == (3, 2)
        assert [("no line end" in step) for step in surface.provenance.steps] == [True] * told


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1;2\n3;4;5\n", "3 numbers in line 2 but 2 in line 1"),
        ("1,5;2,5\n3,5;4,5\n", "decimal comma '1,5' in line 1"),
        ("1,5 2,5\n3,5 4,5\n", "decimal comma '1,5' in line 1"),
        ("1\t2\n3\t4,5\n", "decimal comma '4,5' in line 2"),
        ("x,y\n1,2\n3,4\n", "'x' in line 1, cell 1"),
        ("1 2\n3 inf\n", "'inf' in line 2, cell 2"),
        ("1 2\n3 1_0\n", "'1_0' in line 2, cell 2"),
        ("# nothing\n\n", "holds no numbers"),
        ("1 2 3 4\n", "at least 2 × 2"),
        ("nan nan\nnan nan\n", "no finite value"),
        ("".join(f"{x} {y} 0.5\n" for y in range(3) for x in range(4)), "points x, y, z"),
        (b"\xff\xfe1\x00", "no text in UTF-8"),
        (b"\x89PNG\r\n\x1a\n\x00", "no text in UTF-8"),
    ],
)
def test_text_that_is_no_matrix(tmp_path: Path, text: str | bytes, words: str) -> None:
    refused(write(tmp_path, "map.csv", text), "map.csv", words, unit="um", size="1 mm x 1 mm")


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
        ({"unit": "um", "size": ("a", "b")}, "pair (y, x) in metres"),
        ({"unit": "um", "size": (1, 2, 3)}, "both sides"),
        ({"unit": "um", "size": (1e-3, 1e-3), "channel": 0}, "no channels"),
    ],
)
def test_a_matrix_needs_unit_and_size(
    tmp_path: Path, arguments: dict[str, object], words: str
) -> None:
    path = write(tmp_path, "map.csv", TEXTS["comma"])
    refused(path, words, kind=InputError, **arguments)


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
    refused(path, "0: 'front'; 1: 'back'", unit="nm", size=size, kind=InputError)
    refused(path, "no array 'x'", unit="nm", size=size, channel="x", kind=InputError)
    refused(path, "real numbers", unit="nm", size=size, channel="label")
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
    refused(tmp_path / "map.npy", "map.npy", words, unit="um", size="1 mm x 1 mm")


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
        refused(path, name, "cannot be read", unit="um", size="1 mm x 1 mm")


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
    refused(path, "gives its unit itself", unit="um", kind=InputError)
    refused(path, "gives its size itself", size=(6e-6, 4e-6), kind=InputError)
    refused(path, "no channels", channel=0, kind=InputError)


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
    refused(path, "map.csv", words)


def test_a_head_that_comes_later_is_a_remark(tmp_path: Path) -> None:
    path = write(tmp_path, "map.csv", "\n" + HEAD + TEXTS["comma"])
    refused(path, "map.csv gives no unit", kind=InputError)
    assert channels(path) == (Channel("", "", True, (3, 4)),)


def test_a_matrix_with_a_head_is_no_list_of_points(tmp_path: Path) -> None:
    text = "".join(f"{x} {y} 0.5\n" for y in range(3) for x in range(4))
    assert read_surface(write(tmp_path, "map.csv", HEAD + text)).shape == (12, 3)


def test_numpy_archive_with_unit_and_pixel(tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    np.savez(path, heights=HEIGHTS, pixel=[2.0, 1.0], unit="um", note="more")
    for channel in (None, "heights"):
        surface = read_surface(path, channel=channel)
        np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-15)
        assert surface.pixel == pytest.approx((2e-6, 1e-6), rel=1e-15, abs=0)
    refused(path, "gives its unit itself", unit="um", kind=InputError)
    refused(path, "gives its size itself", size="1 um x 2 um", kind=InputError)
    refused(path, "at least 2 × 2", channel="pixel")
    for changes, words in (
        ({"pixel": 1.0}, "two numbers (dy, dx) as pixel"),
        ({"pixel": ["1", "2"]}, "two numbers (dy, dx) as pixel"),
        ({"unit": 1}, "a word as unit"),
        ({"unit": ["um"]}, "a word as unit"),
        ({"pixel": [1.0, np.nan]}, "pixel must be positive"),
        ({"heights": HEIGHTS[0]}, "at least 2 × 2"),
    ):
        np.savez(path, **{"heights": HEIGHTS, "pixel": [2.0, 1.0], "unit": "um", **changes})
        refused(path, words)
    np.savez(path, heights=HEIGHTS, pixel=[2.0, 1.0], unit="Pa")
    refused(path, "map.npz", "unit needs a length")
    # Without a unit it is an archive as any other.
    np.savez(path, heights=HEIGHTS, pixel=[2.0, 1.0])
    refused(path, "0: 'heights'; 1: 'pixel'", kind=InputError)


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
    refused(path, "gives its unit itself", unit="m", kind=InputError)


def test_netcdf_of_another_kind(tmp_path: Path) -> None:
    refused(write_netcdf(tmp_path / "a.nc", attrs={"units": "um"}), "units 'um'", "'height' [m]")
    refused(write_netcdf(tmp_path / "b.nc", attrs={}), "units None")
    refused(write(tmp_path, "c.nc", "no HDF5 at all"), "c.nc cannot be read", "'height' [m]")
    content = write_netcdf(tmp_path / "d.nc").read_bytes()
    refused(write(tmp_path, "e.nc", content[: len(content) // 2]), "e.nc cannot be read")


def test_import_leaves_the_readers_alone() -> None:
    code = (
        "import sys, roughcontact.formats.read; "
        "sys.exit(bool({'SurfaceTopography', 'xarray', 'pint', 'h5py'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
