from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import roughcontact as rc
import written
from roughcontact.formats import source, vtk
from written import MAPS, PIXEL, SHAPE, STEEL, VOLUME_SHAPE, assert_same_bits, rough, vtk_image


@pytest.fixture(scope="module")
def result() -> rc.ContactResult:
    return written.contact()


@pytest.fixture(scope="module")
def pair() -> rc.ContactResult:
    return written.two_bodies()


@pytest.fixture(scope="module")
def volume() -> rc.ElastoplasticResult:
    return written.volume()


# All in one block; several with a part left over; and 23 × 36 in blocks of 23 numbers, none left.
@pytest.mark.parametrize("block", [2**20, 1000, 8 * 23])
def test_vtk_holds_all_maps(
    block: int, result: rc.ContactResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source, "BLOCK", block)
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
            lines = [about[f"ComponentName{number}"] for number in range(components)]
            assert lines == ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]
        assert arrays[name].dtype == found.bodies[0].stress.dtype
        arrays[name] = arrays[name].reshape(z, y, x, components).squeeze()
    return grid, arrays


@pytest.mark.parametrize("block", [2**20, 1000])
def test_the_volume_is_a_grid_of_graded_layers(
    block: int, volume: rc.ElastoplasticResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source, "BLOCK", block)
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


@pytest.mark.slow
def test_the_stress_in_the_file_is_in_equilibrium(tmp_path: Path) -> None:
    # By the file alone: what the pressure on one side of a plane x = const brings in leaves through
    # that plane and through the far end of the body. The rule of the trapezium along x is good to a
    # few percent; shear with the wrong sign would miss by 40.
    shape, edge = (24, 24), 1e-6
    y, x = (edge * (np.arange(n) - (n - 1) / 2) for n in shape)
    ball = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 105e-6), (edge, edge))
    found = rc.solve_elastoplastic(
        ball,
        material=STEEL,
        counter_material=STEEL,
        increments=1,
        loads=[0.25],
        boundary="periodic",
        tolerance=1e-3,
        depth=1e-5,
    )
    found.save(tmp_path / "out.vtr")
    found.save(tmp_path / "out.vti")
    _, cells = volume_grid(tmp_path / "out.vtr", found)
    _, maps = vtk_image(tmp_path / "out.vti")
    pressure = maps["pressure"].reshape(shape)
    heights = np.diff(cells["z"])
    column = 10
    # At the center of that column; half of its pressure is on this side.
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


@pytest.mark.long
def test_counter_body_is_above_origin(tmp_path: Path) -> None:
    y, x = (1e-6 * (np.arange(n) - 7.5) for n in (16, 16))
    ball = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 105e-6), (1e-6, 1e-6))
    found = rc.solve_elastoplastic(
        ball,
        material=replace(STEEL, yield_strength=None),
        counter_material=STEEL,
        increments=1,
        loads=[0.1],
        tolerance=1e-3,
        depth=8e-6,
        precision="double",
    )
    found.save(tmp_path / "out.vtr")
    _, arrays = volume_grid(tmp_path / "out.vtr", found)
    assert arrays["z"][0] == 0
    assert arrays["z"][-1] == pytest.approx(found.bodies[0].thickness.sum())
    np.testing.assert_array_equal(arrays["von_mises"], found.bodies[0].von_mises)
    assert arrays["von_mises"].dtype == np.float64
