import base64
import csv
import hashlib
import importlib.util
import json
import math
import struct
import zipfile
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.files import to_json
from roughcontact.formats import binary, export, metrology, netcdf, tables, vtk
from roughcontact.material.hardening import Linear
from roughcontact.volume.archive import load_elastoplastic

MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"

# ny ≠ nx and dy ≠ dx, neither of them a binary fraction.
SHAPE, PIXEL = (23, 36), (0.7e-6, 0.9e-6)
STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)

HAS_READER = importlib.util.find_spec("SurfaceTopography") is not None

EXACT = (".npz", ".nc", ".x3p", ".csv")
READABLE = (*EXACT, ".sur")
SURFACE_SUFFIXES = (*READABLE, ".vti")
RESULT_SUFFIXES = (".nc", ".vti", ".csv", ".json")
VOLUME_SUFFIXES = (".nc", ".vtr", ".vti", ".csv", ".json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for all examples of a law: files of the same name replace each other."""
    return tmp_path_factory.mktemp("export")


def rough(holes: bool = True) -> rc.Surface:
    heights = rc.self_affine(
        SHAPE, PIXEL, rms_height=0.1e-6, rolloff_wavelength=9e-6, cutoff_wavelength=2e-6,
        rng=np.random.default_rng(5),
    )  # fmt: skip
    if holes:
        heights = heights.copy()
        heights[3:5, 7:10] = np.nan
        heights[0, 0] = heights[-1, -1] = np.nan
    about = rc.Provenance("ground.opd", "Wyko NT1100", "Raw", ("leveled: plane", "second step"))
    return rc.Surface(heights, PIXEL, about)


@pytest.fixture(scope="module")
def result() -> rc.ContactResult:
    found = rc.solve(rough().masked(), material=STEEL, load=0.15)
    assert found.saturated.any()
    assert found.contact.sum() > found.saturated.sum()
    return found


@pytest.fixture(scope="module")
def pair() -> rc.ContactResult:
    """Two measured bodies, and a ceiling of each pixel, infinite in places."""
    ceiling = np.full(SHAPE, 3e9)
    ceiling[:, 18:] = np.inf
    counter = rc.Surface(rough(False).heights[::-1] / 2, PIXEL, rc.Provenance("other.opd"))
    return rc.solve(
        rough(False), counter_surface=counter, material=STEEL, ceiling=ceiling, load=0.1
    )


def assert_same_bits(one: np.ndarray, two: np.ndarray) -> None:
    assert one.dtype == two.dtype
    np.testing.assert_array_equal(np.isnan(one), np.isnan(two))
    # A zero keeps its sign; only the payload of NaN means nothing.
    assert np.nan_to_num(one).tobytes() == np.nan_to_num(two).tobytes()


def saved_and_read(surface: rc.Surface, path: Path) -> rc.Surface:
    surface.save(path)
    if path.suffix in (".x3p", ".sur") and not HAS_READER:
        pytest.skip("SurfaceTopography is absent")
    return rc.read_surface(path)


def sur_fields(path: Path) -> dict[str, Any]:
    """Bytes at fixed places, as Gwyddion's surffile.c lists them."""
    content = path.read_bytes()
    fields = dict(
        zip(
            ("bits", "zmin", "zmax", "nx", "ny", "points", "dx", "dy", "dz"),
            struct.unpack_from("<H5i3f", content, 98),
            strict=True,
        )
    )
    fields["special"], fields["absolute"] = struct.unpack_from("<2H", content, 86)
    fields["words"] = [content[132 + 16 * n :][:16] for n in range(9)]
    fields["comment"], fields["private"] = struct.unpack_from("<2H", content, 334)
    fields["offsets"] = struct.unpack_from("<3f", content, 466)
    fields["data"] = np.frombuffer(content, "<i4", offset=512).reshape(fields["ny"], fields["nx"])
    return fields


# --- there and back --------------------------------------------------------------------------


@st.composite
def surfaces(draw: st.DrawFn) -> rc.Surface:
    """Maps that `read_surface` finds plausible: sides of 20 nm to 8 mm."""
    shape = draw(st.tuples(st.integers(2, 7), st.integers(2, 7)))
    edges = st.floats(1e-8, 1e-3)
    heights = draw(hnp.arrays(np.float64, shape, elements=st.floats(-5e-7, 5e-7)))
    holes = draw(hnp.arrays(np.bool_, shape))
    heights[holes] = np.nan
    heights[draw(st.integers(0, shape[0] - 1)), draw(st.integers(0, shape[1] - 1))] = draw(
        st.floats(-5e-7, 5e-7)
    )
    return rc.Surface(heights, (draw(edges), draw(edges)))


@pytest.mark.parametrize("suffix", EXACT)
@given(surface=surfaces())
@settings(max_examples=25, deadline=None)
def test_every_height_keeps_its_bits(suffix: str, folder: Path, surface: rc.Surface) -> None:
    again = saved_and_read(surface, folder / f"map{suffix}")
    assert_same_bits(again.heights, surface.heights)
    # SurfaceTopography multiplies the pixel by the number of points, and divides again.
    assert again.pixel == pytest.approx(surface.pixel, rel=1e-15 if suffix == ".x3p" else 0, abs=0)


@given(surface=surfaces())
@settings(max_examples=50, deadline=None)
def test_sur_is_within_half_a_step(folder: Path, surface: rc.Surface) -> None:
    path = folder / "map.sur"
    again = saved_and_read(surface, path)
    largest = float(np.nanmax(np.abs(surface.heights)))
    step = 1e-3 * sur_fields(path)["dz"]
    # Rounded up in single precision, whose smallest normal number is 1.2e-38 (mm).
    assert step <= max(largest / (2**31 - 2) * (1 + 2**-22), 1.2e-41)
    np.testing.assert_array_equal(np.isnan(again.heights), np.isnan(surface.heights))
    error = np.nanmax(np.abs(again.heights - surface.heights))
    # Half a step, and a few roundings of the height in double precision.
    assert error <= 0.5 * step + 4 * np.finfo(float).eps * largest
    assert again.pixel == pytest.approx(surface.pixel, rel=2**-24, abs=0)


@pytest.mark.parametrize("suffix", READABLE)
@pytest.mark.parametrize("holes", [False, True])
def test_rows_columns_and_holes(suffix: str, holes: bool, tmp_path: Path) -> None:
    surface = rough(holes)
    again = saved_and_read(surface, tmp_path / f"map{suffix}")
    assert again.shape == SHAPE
    assert again.missing == surface.missing == (8 if holes else 0)
    np.testing.assert_allclose(again.heights, surface.heights, rtol=0, atol=1e-15)
    assert again.pixel == pytest.approx(PIXEL, rel=1e-7, abs=0)


@pytest.mark.parametrize("suffix", READABLE)
@pytest.mark.parametrize("height", [0.0, -2e-6])
def test_a_flat_map(suffix: str, height: float, tmp_path: Path) -> None:
    surface = rc.Surface(np.full((3, 5), height), PIXEL)
    again = saved_and_read(surface, tmp_path / f"map{suffix}")
    np.testing.assert_allclose(again.heights, surface.heights, rtol=1e-9, atol=0)


# NetCDF and text take long, and treat a measured map as any other.
@pytest.mark.parametrize(
    "suffix",
    [
        ".npz",
        ".x3p",
        ".sur",
        *(pytest.param(name, marks=pytest.mark.slow) for name in (".nc", ".csv")),
    ],
)
@pytest.mark.parametrize(
    "name",
    [
        "wyko_nt1100_test_1.opd", "sur-2.sur", "x3p-2.x3p", "bullet_land_fixed.x3p", "dvd_afm.sur",
        "metropro-1.dat", "opd-1.opd", "mnt-1.mnt", "uncd_afm.001",
    ],
)  # fmt: skip
def test_measurements(name: str, suffix: str, tmp_path: Path) -> None:
    if not HAS_READER:
        pytest.skip("SurfaceTopography is absent")
    if not (MEASUREMENTS / name).exists():
        pytest.skip(f"shared/measurements/{name} is absent")
    surface = rc.read_surface(MEASUREMENTS / name)
    again = saved_and_read(surface, tmp_path / f"map{suffix}")
    assert again.shape == surface.shape
    if suffix == ".sur":
        step = 1e-3 * sur_fields(tmp_path / "map.sur")["dz"]
        np.testing.assert_allclose(again.heights, surface.heights, rtol=0, atol=0.5001 * step)
        assert again.pixel == pytest.approx(surface.pixel, rel=2**-24, abs=0)
    else:
        assert_same_bits(again.heights, surface.heights)
        assert again.pixel == pytest.approx(surface.pixel, rel=1e-15, abs=0)


# --- VTK -------------------------------------------------------------------------------------


def vtk_image(
    path: Path, kind: str = "ImageData", groups: tuple[str, ...] = ("PointData",)
) -> tuple[ElementTree.Element, dict[str, np.ndarray]]:
    """Return the head of a VTK file and its arrays, by the description of the format."""
    root = ElementTree.parse(path).getroot()
    assert root.attrib == {
        "type": kind, "version": "1.0", "byte_order": "LittleEndian",
        "header_type": "UInt64", "compressor": "vtkZLibDataCompressor",
    }  # fmt: skip
    image, appended = root.find(kind), root.find("AppendedData")
    assert image is not None
    assert appended is not None
    assert appended.attrib == {"encoding": "base64"}
    text = (appended.text or "").strip()
    assert text[0] == "_"
    arrays = {}
    assert [group.tag for group in image.iterfind("Piece/*")] == list(groups)
    for entry in image.iterfind("Piece/*/DataArray"):
        rest = text[1 + int(entry.attrib["offset"]) :]
        # Base64 comes in fours: the count of blocks tells how long the table is.
        (count,) = struct.unpack("<Q", base64.b64decode(rest[:12])[:8])
        letters = (8 * (3 + count) + 2) // 3 * 4
        table = struct.unpack(f"<{3 + count}Q", base64.b64decode(rest[:letters], validate=True))
        sizes = table[3:]
        data = rest[letters : letters + (sum(sizes) + 2) // 3 * 4]
        packed = base64.b64decode(data, validate=True)
        assert len(packed) == sum(sizes)
        blocks = []
        for size in sizes:
            blocks.append(zlib.decompress(packed[:size]))
            packed = packed[size:]
        assert all(len(block) == table[1] for block in blocks[:-1])
        assert len(blocks[-1]) == (table[2] or table[1])
        number = {"Float64": "<f8", "Float32": "<f4", "UInt8": "u1"}[entry.attrib["type"]]
        arrays[entry.attrib["Name"]] = np.frombuffer(b"".join(blocks), number)
    return image, arrays


MAPS = {
    "height", "initial_gap", "pressure", "gap", "contact", "saturated", "residual_indentation",
}  # fmt: skip


# All in one block; several with a part left over; and 23 × 36 in blocks of 23 numbers, none left.
@pytest.mark.parametrize("block", [2**20, 1000, 8 * 23])
def test_vtk_holds_all_maps(
    block: int, result: rc.ContactResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(binary, "BLOCK", block)
    result.save(tmp_path / "out.vti")
    image, arrays = vtk_image(tmp_path / "out.vti")
    assert set(arrays) == MAPS
    assert_same_bits(arrays["height"].reshape(SHAPE), result.surface.heights)
    for name in MAPS - {"height"}:
        expected = getattr(result, name)
        np.testing.assert_array_equal(arrays[name].reshape(SHAPE), expected, err_msg=name)
    data = image.find("Piece/PointData")
    assert data is not None
    assert data.attrib == {"Scalars": "pressure"}


def test_vtk_places_the_points_at_the_centres(result: rc.ContactResult, tmp_path: Path) -> None:
    result.save(tmp_path / "out.vti")
    image, _ = vtk_image(tmp_path / "out.vti")
    piece = image.find("Piece")
    assert piece is not None
    assert image.attrib["WholeExtent"] == piece.attrib["Extent"] == "0 35 0 22 0 0"
    origin, spacing = (
        [float(word) for word in image.attrib[name].split()] for name in ("Origin", "Spacing")
    )
    assert spacing == [PIXEL[1], PIXEL[0], 1.0]
    assert origin == [PIXEL[1] / 2, PIXEL[0] / 2, 0.0]


def test_vtk_names_the_units(pair: rc.ContactResult, tmp_path: Path) -> None:
    vtk.save_vtk(pair, tmp_path / "out.vti")
    image, arrays = vtk_image(tmp_path / "out.vti")
    assert set(arrays) == MAPS | {"counter_height", "ceiling"}
    np.testing.assert_array_equal(arrays["ceiling"].reshape(SHAPE), pair.ceiling)
    assert pair.counter_surface is not None
    assert_same_bits(arrays["counter_height"].reshape(SHAPE), pair.counter_surface.heights)
    field = image.find("FieldData/Array")
    assert field is not None
    assert field.attrib["Name"] == "units"
    codes = bytes(int(code) for code in (field.text or "").split())
    words = codes.decode("ascii").split("\0")
    assert words.pop() == ""
    assert int(field.attrib["NumberOfTuples"]) == len(words)
    units = dict(word.split(": ") for word in words)
    assert units.keys() == arrays.keys()
    pascal, ratio = {"pressure", "ceiling"}, {"contact", "saturated"}
    assert {name for name, unit in units.items() if unit == "Pa"} == pascal
    assert {name for name, unit in units.items() if unit == "1"} == ratio
    assert {name for name, unit in units.items() if unit == "m"} == set(units) - pascal - ratio


def test_vtk_of_a_surface(tmp_path: Path) -> None:
    rough().save(tmp_path / "map.vti")
    image, arrays = vtk_image(tmp_path / "map.vti")
    assert set(arrays) == {"height"}
    assert_same_bits(arrays["height"].reshape(SHAPE), rough().heights)
    data = image.find("Piece/PointData")
    assert data is not None
    assert data.attrib == {"Scalars": "height"}


# --- the volume ------------------------------------------------------------------------------


VOLUME_SHAPE = (20, 16)


@pytest.fixture(scope="module")
def volume() -> rc.ElastoplasticResult:
    """Two balls that yield, in a volume that goes on beyond the map."""
    y, x = (
        edge * (np.arange(n) - (n - 1) / 2) for edge, n in zip(PIXEL, VOLUME_SHAPE, strict=True)
    )
    ball = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 50e-6), PIXEL)
    hard, soft = (
        replace(STEEL, yield_strength=None, hardening=Linear(strength, 50e9))
        for strength in (1e9, 0.7e9)
    )
    found = rc.solve_elastoplastic(
        ball, material=hard, counter_material=soft, loads=[0.25], tolerance=1e-3
    )
    assert found.bodies[0].margin > 0
    return found


def volume_grid(
    path: Path, found: rc.ElastoplasticResult
) -> tuple[ElementTree.Element, dict[str, np.ndarray]]:
    """Return the arrays of a .vtr file, those of cells as [z, y, x] or [z, y, x, component]."""
    grid, arrays = vtk_image(path, "RectilinearGrid", ("CellData", "Coordinates"))
    piece = grid.find("Piece")
    assert piece is not None
    x, y, z = (arrays[name].size - 1 for name in "xyz")
    assert piece.attrib["Extent"] == grid.attrib["WholeExtent"] == f"0 {x} 0 {y} 0 {z}"
    for entry in grid.iterfind("Piece/CellData/DataArray"):
        name, about = entry.attrib["Name"], entry.attrib
        components = int(about.get("NumberOfComponents", "1"))
        if components > 1:
            told = [about[f"ComponentName{number}"] for number in range(components)]
            assert told == ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]
        assert arrays[name].dtype == found.bodies[0].stress.dtype
        arrays[name] = arrays[name].reshape(z, y, x, components).squeeze()
    return grid, arrays


@pytest.mark.parametrize("block", [2**20, 1000])
def test_the_volume_is_a_grid_of_graded_layers(
    block: int, volume: rc.ElastoplasticResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(binary, "BLOCK", block)
    volume.save(tmp_path / "out.vtr")
    _, arrays = volume_grid(tmp_path / "out.vtr", volume)
    lower, upper = volume.bodies
    layers, margin = lower.thickness.size, lower.margin
    # Faces of the cells: the map from 0 on, the margin around it, both bodies from the surface.
    for axis, n, edge in zip("yx", VOLUME_SHAPE, PIXEL, strict=True):
        np.testing.assert_allclose(arrays[axis], edge * np.arange(-margin, n + margin + 1))
        assert arrays[axis][margin] == 0
    depths = np.cumsum(upper.thickness)
    assert arrays["z"].tolist() == [*-depths[::-1], 0.0, *depths]
    fields = {
        "accumulated_plastic_strain": "accumulated",
        "von_mises": "von_mises",
        "residual_von_mises": "residual_von_mises",
    }
    for name, field in fields.items():
        np.testing.assert_array_equal(arrays[name][:layers][::-1], getattr(lower, field))
        np.testing.assert_array_equal(arrays[name][layers:], getattr(upper, field))
    # Tensors, from the components as they are described; z of the lower body turns round.
    for name, mean in (
        ("plastic_strain", None),
        ("stress", "mean_stress"),
        ("residual_stress", "mean_residual_stress"),
    ):
        for body, side, part in ((lower, -1, slice(layers - 1, None, -1)), (upper, 1, None)):
            found = arrays[name][slice(layers, None) if part is None else part]
            zz, half, xy, xz, yz = getattr(body, name).swapaxes(0, 1)
            third = 0 if mean is None else getattr(body, mean)
            rest = third - zz / 2
            expected = (rest + half, rest - half, third + zz, xy, side * yz, side * xz)
            np.testing.assert_array_equal(found, np.stack(expected, axis=-1), err_msg=name)


def test_the_stress_in_the_file_is_in_equilibrium(tmp_path: Path) -> None:
    # By the file alone: what the pressure on one side of a plane x = const brings in leaves through
    # that plane and through the far end of the body. The rule of the trapezium along x is good to a
    # few percent; shear with the wrong sign would miss by 40.
    shape, edge = (24, 24), 1e-6
    y, x = (edge * (np.arange(n) - (n - 1) / 2) for n in shape)
    ball = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 105e-6), (edge, edge))
    found = rc.solve_elastoplastic(
        ball, material=STEEL, counter_material=STEEL, loads=[0.25], boundary="periodic",
        tolerance=1e-3, depth=1e-5,
    )  # fmt: skip
    found.save(tmp_path / "out.vtr")
    found.save(tmp_path / "out.vti")
    _, cells = volume_grid(tmp_path / "out.vtr", found)
    _, maps = vtk_image(tmp_path / "out.vti")
    pressure = maps["pressure"].reshape(shape)
    heights = np.diff(cells["z"])
    column = 10
    # At the centre of that column; half of its pressure lies on this side.
    weight = np.where(np.arange(24) < column, 1.0, np.where(np.arange(24) == column, 0.5, 0.0))
    brought = (pressure @ weight).sum() * edge**2
    assert 0.2 * 0.25 < brought < 0.4 * 0.25
    through = (cells["stress"][:, :, column, 5].sum(axis=1) * heights * edge).cumsum()
    middle = heights.size // 2
    far = (cells["stress"][..., 2] @ weight).sum(axis=1) * edge**2
    # Forces on the lower body: the pressure presses down, its bottom is pulled down by -σ_zz.
    below, above = through[middle - 1], through[-1] - through[middle - 1]
    assert below - far[0] == pytest.approx(brought, rel=0.05)
    assert above + far[-1] == pytest.approx(-brought, rel=0.05)
    assert min(abs(below), abs(above)) > 0.2 * brought


def test_only_the_counter_body_lies_above(tmp_path: Path) -> None:
    y, x = (1e-6 * (np.arange(n) - 7.5) for n in (16, 16))
    ball = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 105e-6), (1e-6, 1e-6))
    found = rc.solve_elastoplastic(
        ball, material=replace(STEEL, yield_strength=None), counter_material=STEEL, loads=[0.1],
        tolerance=1e-3, depth=8e-6, precision="double",
    )  # fmt: skip
    found.save(tmp_path / "out.vtr")
    _, arrays = volume_grid(tmp_path / "out.vtr", found)
    assert arrays["z"][0] == 0
    assert arrays["z"][-1] == pytest.approx(found.bodies[0].thickness.sum())
    np.testing.assert_array_equal(arrays["von_mises"], found.bodies[0].von_mises)
    assert arrays["von_mises"].dtype == np.float64


def test_maps_pressure_and_numbers_of_a_volume(
    volume: rc.ElastoplasticResult, tmp_path: Path
) -> None:
    for suffix in VOLUME_SUFFIXES:
        volume.save(tmp_path / f"out{suffix}")
    _, arrays = vtk_image(tmp_path / "out.vti")
    # Those of the ceiling are not among them.
    assert set(arrays) == {
        "height", "initial_gap", "pressure", "gap", "contact", "residual_displacement",
    }  # fmt: skip
    for name in ("pressure", "gap", "contact"):
        expected = getattr(volume.contact, name)
        np.testing.assert_array_equal(arrays[name].reshape(VOLUME_SHAPE), expected)
    left = volume.residual_displacement
    assert left.max() > 0
    np.testing.assert_array_equal(arrays["residual_displacement"].reshape(VOLUME_SHAPE), left)
    np.testing.assert_array_equal(
        np.loadtxt(tmp_path / "out.csv", delimiter=","), volume.contact.pressure
    )
    tables.save_csv(volume, tmp_path / "left.csv", "residual_displacement")
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "left.csv", delimiter=","), left)
    assert "# unit: m\n" in (tmp_path / "left.csv").read_text(encoding="utf-8")
    with pytest.raises(rc.InputError, match="field must be one of"):
        tables.save_csv(volume, tmp_path / "left.csv", "saturated")
    told = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert told["volume"] == volume.summary()
    # The words on yield are those of the volume, not of a contact without ceiling.
    assert told["regime"] == volume.regime != volume.contact.regime
    assert told["max_pressure"] == volume.contact.max_pressure
    assert load_elastoplastic(tmp_path / "out.nc").summary() == volume.summary()


# --- CSV -------------------------------------------------------------------------------------


def test_csv_of_every_map(result: rc.ContactResult, pair: rc.ContactResult, tmp_path: Path) -> None:
    path = tmp_path / "map.csv"
    for source, extra in ((result, set()), (pair, {"counter_height", "ceiling"})):
        for field in MAPS | extra:
            tables.save_csv(source, path, field)
            if field == "height":
                expected = source.surface.heights
            elif field == "counter_height":
                expected = pair.counter_surface.heights
            else:
                expected = getattr(source, field)
            read = np.loadtxt(path, delimiter=",")
            np.testing.assert_array_equal(read, expected, err_msg=field)
            head = [line for line in path.read_text().splitlines() if line.startswith("#")]
            assert head[:2] == ["# roughcontact map", f"# quantity: {field}"]
            assert head[3:5] == ["# pixel_y: 7e-07 m", "# pixel_x: 9e-07 m"]
            assert "23 rows" in head[5]
            assert "36 columns" in head[5]


def test_csv_of_a_result_is_its_pressure(result: rc.ContactResult, tmp_path: Path) -> None:
    result.save(tmp_path / "out.csv")
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "out.csv", delimiter=","), result.pressure)
    assert "# unit: Pa\n" in (tmp_path / "out.csv").read_text()
    with pytest.raises(rc.FormatError, match=r"out\.csv holds 'pressure', no heights"):
        rc.read_surface(tmp_path / "out.csv")


def test_masks_are_0_and_1(result: rc.ContactResult, tmp_path: Path) -> None:
    tables.save_csv(result, tmp_path / "out.csv", "contact")
    rows = [line for line in (tmp_path / "out.csv").read_text().splitlines() if line[0] != "#"]
    assert set(",".join(rows)) == {"0", "1", ","}


def test_csv_of_a_map_that_is_not_there(result: rc.ContactResult, tmp_path: Path) -> None:
    for source, field, known in (
        (rough(), "pressure", "height"),
        (result, "ceiling", "pressure, gap"),
        (result, "counter_height", "height, initial_gap"),
        (result, "stress", "pressure, gap"),
    ):
        with pytest.raises(rc.InputError, match=f"field must be one of .*{known}.*got '{field}'"):
            tables.save_csv(source, tmp_path / "out.csv", field)
    assert not any(tmp_path.iterdir())


# --- X3P -------------------------------------------------------------------------------------


def tags(element: ElementTree.Element) -> list[Any]:
    return [(child.tag, tags(child)) for child in element]


def test_x3p_after_the_standard(tmp_path: Path) -> None:
    surface = rough()
    surface.save(tmp_path / "map.x3p")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        assert archive.testzip() is None
        names = [entry.filename for entry in archive.infolist()]
        content = {name: archive.read(name) for name in names}
    # As `md5sum main.xml > md5checksum.hex` writes it, with the mark of a binary file.
    digest = hashlib.md5(content["main.xml"]).hexdigest()
    assert content["md5checksum.hex"] == f"{digest} *main.xml\n".encode()
    root = ElementTree.fromstring(content["main.xml"])
    assert root.tag == "{http://www.opengps.eu/2008/ISO5436_2}ISO5436_2"

    def text(path: str) -> str:
        found = root.findtext(path)
        assert found is not None
        return found

    assert text("Record1/FeatureType") == "SUR"
    for axis, edge in (("CX", PIXEL[1]), ("CY", PIXEL[0])):
        assert text(f"Record1/Axes/{axis}/AxisType") == "I"
        assert float(text(f"Record1/Axes/{axis}/Increment")) == edge
        assert float(text(f"Record1/Axes/{axis}/Offset")) == 0
    assert text("Record1/Axes/CZ/AxisType") == "A"
    assert text("Record1/Axes/CZ/DataType") == "D"
    assert [text(f"Record3/MatrixDimension/Size{axis}") for axis in "XYZ"] == ["36", "23", "1"]
    data = content[text("Record3/DataLink/PointDataLink")]
    assert text("Record3/DataLink/MD5ChecksumPointData") == hashlib.md5(data).hexdigest().upper()
    # X runs fastest, metres in little-endian double precision.
    assert_same_bits(np.frombuffer(data, "<f8").reshape(SHAPE).copy(), surface.heights)
    assert text("Record4/ChecksumFile") in names
    assert text("Record2/Instrument/Model") == "Wyko NT1100"
    assert text("Record2/Comment") == "ground.opd\nRaw\nleveled: plane\nsecond step"


def test_x3p_has_the_elements_of_a_file_from_elsewhere(tmp_path: Path) -> None:
    other = MEASUREMENTS / "x3p-2.x3p"
    if not other.exists():
        pytest.skip("shared/measurements/x3p-2.x3p is absent")
    rough().save(tmp_path / "map.x3p")
    found = []
    for path in (tmp_path / "map.x3p", other):
        with zipfile.ZipFile(path) as archive:
            root = ElementTree.fromstring(archive.read("main.xml"))
        axis = root.find("Record1/Axes/CZ")
        assert axis is not None
        # Both may be left out of the axis of the heights.
        for name in ("Increment", "Offset"):
            entry = axis.find(name)
            if entry is not None:
                axis.remove(entry)
        found.append((root.tag, tags(root)))
    assert found[0] == found[1]


def test_names_that_are_no_xml(tmp_path: Path) -> None:
    about = rc.Provenance("a<b>&\x01\udcff\ufffeµ.opd", instrument="<Wyko>\n", steps=("1 < 2",))
    surface = replace(rough(), provenance=about)
    for suffix in SURFACE_SUFFIXES:
        surface.save(tmp_path / f"map{suffix}")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        root = ElementTree.fromstring(archive.read("main.xml"))
    assert root.findtext("Record2/Comment") == "a<b>&   µ.opd\n1 < 2"
    assert root.findtext("Record2/Instrument/Model") == "<Wyko> "


def test_x3p_of_several_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binary, "BLOCK", 1000)
    rough().save(tmp_path / "map.x3p")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        data = archive.read("bindata/data.bin")
    assert_same_bits(np.frombuffer(data, "<f8").reshape(SHAPE).copy(), rough().heights)


def test_x3p_beyond_2_gb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The bounds of the archive and of this program, both lowered for a map of 6.6 kB.
    monkeypatch.setattr(zipfile, "ZIP64_LIMIT", 4000)
    monkeypatch.setattr(metrology, "_LARGE", 4000)
    rough().save(tmp_path / "map.x3p")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        assert [entry.extract_version for entry in archive.infolist()][:2] == [20, 45]
        assert archive.testzip() is None


# --- SUR -------------------------------------------------------------------------------------


@pytest.mark.parametrize("block", [2**20, 1000])
@pytest.mark.parametrize("holes", [False, True])
def test_sur_by_its_bytes(
    block: int, holes: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(binary, "BLOCK", block)
    surface = rough(holes)
    path = tmp_path / "map.sur"
    surface.save(path)
    assert path.stat().st_size == 512 + 4 * 23 * 36
    assert path.read_bytes()[:20] == b"DIGITAL SURF" + struct.pack("<4H", 0, 1, 1, 2)
    assert path.read_bytes()[20:50] == b"ground.opd".ljust(30)
    found = sur_fields(path)
    assert (found["bits"], found["nx"], found["ny"], found["points"]) == (32, 36, 23, 23 * 36)
    assert found["words"] == [word.ljust(16) for word in (b"X", b"Y", b"Z", *[b"mm"] * 6)]
    assert found["special"] == holes
    assert found["offsets"] == (0, 0, 0)
    assert (found["comment"], found["private"]) == (0, 0)
    assert found["dx"] == pytest.approx(1e3 * PIXEL[1], rel=2**-24, abs=0)
    assert found["dy"] == pytest.approx(1e3 * PIXEL[0], rel=2**-24, abs=0)
    there = ~np.isnan(surface.heights)
    data = found["data"]
    assert (found["zmin"], found["zmax"]) == (data[there].min(), data[there].max())
    assert (data[~there] == found["zmin"] - 2).all()
    assert max(-found["zmin"], found["zmax"]) > 0.99 * 2**31
    np.testing.assert_allclose(
        data[there] * found["dz"], 1e3 * surface.heights[there], rtol=0, atol=0.5001 * found["dz"]
    )


def test_missing_points_of_the_deepest_map_fit_into_32_bits(tmp_path: Path) -> None:
    # Of all largest heights, some round to a step that is too small in single precision.
    for depth in np.linspace(1e-6, 2e-6, 37):
        surface = rc.Surface([[-depth, np.nan], [0.0, depth]], PIXEL)
        surface.save(tmp_path / "map.sur")
        found = sur_fields(tmp_path / "map.sur")
        assert -(2**31) + 2 <= found["zmin"] <= found["data"][0, 0] < 0 < found["zmax"]
        assert found["data"][0, 1] == found["zmin"] - 2
        error = np.abs(found["data"] * found["dz"] - 1e3 * surface.heights)
        assert np.nanmax(error) <= 0.5001 * found["dz"]


@pytest.mark.parametrize(
    ("height", "pixel"),
    [
        (1e-6, (1e-60, 1e-6)),
        (1e-6, (1e-6, 1e60)),
        (1e60, (1.0, 1.0)),
        (1e306, (1.0, 1.0)),
    ],
)
def test_scales_that_sur_cannot_tell(
    height: float, pixel: tuple[float, float], tmp_path: Path
) -> None:
    with pytest.raises(rc.InputError, match=r"map\.sur keeps pixel and step .*\.x3p or \.npz"):
        rc.Surface([[0, height], [0, 0]], pixel).save(tmp_path / "map.sur")
    assert not any(tmp_path.iterdir())


# --- NumPy and NetCDF ------------------------------------------------------------------------


def test_npz_as_numpy_reads_it(tmp_path: Path) -> None:
    rough().save(tmp_path / "map.NPZ")
    with np.load(tmp_path / "map.NPZ", allow_pickle=False) as archive:
        assert set(archive.files) == {"heights", "pixel", "unit"}
        assert_same_bits(archive["heights"], rough().heights)
        assert archive["pixel"].tolist() == list(PIXEL)
        assert str(archive["unit"]) == "m"


def test_netcdf_says_where_the_map_came_from(tmp_path: Path) -> None:
    import xarray

    rough().save(tmp_path / "map.nc")
    with xarray.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as dataset:
        assert set(dataset.data_vars) == {"height"}
        assert dataset["height"].attrs["units"] == "m"
        np.testing.assert_allclose(dataset["y"], (np.arange(23) + 0.5) * PIXEL[0], rtol=1e-15)
        assert dataset.attrs["source"] == "ground.opd"
        assert dataset.attrs["preparation"] == "leveled: plane\nsecond step"


# --- summaries -------------------------------------------------------------------------------


def refuse(word: str) -> None:
    raise AssertionError(f"{word} is no JSON")


def test_json_holds_the_summary(result: rc.ContactResult, tmp_path: Path) -> None:
    result.save(tmp_path / "out.json")
    text = (tmp_path / "out.json").read_text(encoding="utf-8")
    read = json.loads(text, parse_constant=refuse)
    for name, value in result.summary().items():
        assert read[name] == value, name
    assert read["material"] == {
        "rigid": False, "young": 210e9, "poisson": 0.3, "yield_strength": 1e9, "hardness": None,
    }  # fmt: skip
    # A rigid body's modulus is infinite, of which JSON knows nothing.
    assert read["counter_material"]["young"] is None
    assert read["converged"] is True
    assert read["counter_source"] is None


def test_json_of_two_bodies(pair: rc.ContactResult, tmp_path: Path) -> None:
    tables.save_json(pair, tmp_path / "out.json")
    read = json.loads((tmp_path / "out.json").read_text())
    assert read["ceiling"] == "per pixel"
    assert read["counter_source"] == "other.opd"


def test_what_is_not_finite_is_null() -> None:
    values = {"a": [math.nan, (math.inf, 1.5)], "b": {"c": -math.inf}, "d": "nan", "e": np.inf}
    read = json.loads(to_json(values), parse_constant=refuse)
    assert read == {"a": [None, [None, 1.5]], "b": {"c": None}, "d": "nan", "e": None}


def is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def test_table(pair: rc.ContactResult, tmp_path: Path) -> None:
    tables.save_table(pair, tmp_path / "out.csv")
    with (tmp_path / "out.csv").open(newline="", encoding="utf-8") as stream:
        head, *rows = csv.reader(stream)
    assert head == ["name", "value", "unit"]
    table = {name: (value, unit) for name, value, unit in rows}
    assert len(table) == len(rows)
    assert float(table["max_pressure"][0]) == pair.max_pressure
    assert table["max_pressure"][1] == "Pa"
    assert table["contact_area"] == (repr(pair.contact_area), "m2")
    assert table["pixel"] == ("7e-07; 9e-07", "m")
    assert table["shape"] == ("23; 36", "1")
    assert table["preparation"] == ("leveled: plane; second step", "")
    assert table["ceiling"] == ("per pixel", "")
    assert table["counter_material_young"] == ("inf", "Pa")
    assert table["material_yield_strength"] == ("1000000000.0", "Pa")
    assert table["counter_material_yield_strength"][0] == ""
    # No number without its unit, and no word with one.
    for name, (value, unit) in table.items():
        if value and name not in ("version", "ceiling"):
            assert bool(unit) == all(map(is_number, value.split("; "))), name
    assert set(table) >= set(pair.summary())


# --- files -----------------------------------------------------------------------------------


def test_one_table_knows_every_format() -> None:
    for kind, known in (
        (export.Kind.SURFACE, SURFACE_SUFFIXES),
        (export.Kind.CONTACT, RESULT_SUFFIXES),
        (export.Kind.VOLUME, VOLUME_SUFFIXES),
    ):
        assert sorted(export.suffixes(kind)) == sorted(known)
        assert all(f"{suffix} " in export.told(kind) for suffix in known)
    assert export.told(export.Kind.SURFACE).startswith(".nc heights and provenance")
    assert ".csv pressure, " in export.told(export.Kind.CONTACT, export.Kind.VOLUME)
    assert ".vtr strain and stress" in export.told(export.Kind.CONTACT, export.Kind.VOLUME)


def test_the_suffixes_are_told_where_none_fits(
    result: rc.ContactResult, volume: rc.ElastoplasticResult, tmp_path: Path
) -> None:
    for source, suffixes in (
        (rough(), SURFACE_SUFFIXES),
        (result, RESULT_SUFFIXES),
        (volume, VOLUME_SUFFIXES),
    ):
        for name in ("out", "out.vtk", "out.png", "out.x3p.zip"):
            with pytest.raises(rc.InputError, match="path must end in one of") as caught:
                source.save(tmp_path / name)
            message = str(caught.value)
            assert name in message
            assert all(suffix in message for suffix in suffixes)
            assert "roughcontact.plots" in message
    assert not any(tmp_path.iterdir())


def test_each_function_insists_on_its_suffix(
    result: rc.ContactResult, volume: rc.ElastoplasticResult, tmp_path: Path
) -> None:
    for write, source, suffix in (
        (netcdf.save, rough(), ".nc"),
        (tables.save_npz, rough(), ".npz"),
        (metrology.save_x3p, rough(), ".x3p"),
        (metrology.save_sur, rough(), ".sur"),
        (tables.save_csv, rough(), ".csv"),
        (vtk.save_vtk, rough(), ".vti"),
        (vtk.save_vtr, volume, ".vtr"),
        (tables.save_json, result, ".json"),
        (tables.save_table, result, ".csv"),
    ):
        with pytest.raises(rc.InputError, match=rf"path must end in \{suffix}, got"):
            write(source, tmp_path / "out.txt")  # type: ignore[operator]


@pytest.mark.parametrize("suffix", sorted({*SURFACE_SUFFIXES, *RESULT_SUFFIXES, *VOLUME_SUFFIXES}))
def test_an_old_file_survives_a_failure(
    suffix: str,
    result: rc.ContactResult,
    volume: rc.ElastoplasticResult,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / f"OUT{suffix.upper()}"
    sources = [
        source
        for source, known in (
            (rough(), SURFACE_SUFFIXES),
            (result, RESULT_SUFFIXES),
            (volume, VOLUME_SUFFIXES),
        )
        if suffix in known
    ]
    for source in sources:
        path.write_text("old")

        def full(*_: object) -> None:
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr("roughcontact.files.os.replace", full)
            with pytest.raises(OSError, match="No space left"):
                source.save(path)
        assert path.read_text() == "old"
        source.save(path)
        assert path.read_bytes() != b"old"
        assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_a_surface_without_its_indentation_can_be_saved(
    result: rc.ContactResult, tmp_path: Path
) -> None:
    left = rc.Surface(result.surface.heights - result.residual_indentation, PIXEL)
    again = saved_and_read(left, tmp_path / "left.x3p")
    lower = again.heights < result.surface.heights
    np.testing.assert_array_equal(lower, result.residual_indentation > 0)
