import json
import math
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
import written
from roughcontact._tools.files import to_json
from roughcontact.formats import tables
from written import MAPS, PIXEL, assert_same_bits, rough


@pytest.fixture(scope="module")
def result() -> rc.ContactResult:
    return written.contact()


@pytest.fixture(scope="module")
def pair() -> rc.ContactResult:
    return written.two_bodies()


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


def test_csv_of_unknown_field_raises_input_error(result: rc.ContactResult, tmp_path: Path) -> None:
    for source, field, known in (
        (rough(), "pressure", "height"),
        (result, "ceiling", "pressure, gap"),
        (result, "counter_height", "height, initial_gap"),
        (result, "stress", "pressure, gap"),
    ):
        with pytest.raises(rc.InputError, match=f"field must be one of .*{known}.*got '{field}'"):
            tables.save_csv(source, tmp_path / "out.csv", field)
    assert not any(tmp_path.iterdir())


def test_npz_as_numpy_reads_it(tmp_path: Path) -> None:
    rough().save(tmp_path / "map.NPZ")
    with np.load(tmp_path / "map.NPZ", allow_pickle=False) as archive:
        assert set(archive.files) == {"heights", "pixel", "unit"}
        assert_same_bits(archive["heights"], rough().heights)
        assert archive["pixel"].tolist() == list(PIXEL)
        assert str(archive["unit"]) == "m"


def test_netcdf_keeps_provenance(tmp_path: Path) -> None:
    import xarray

    rough().save(tmp_path / "map.nc")
    with xarray.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as dataset:
        assert set(dataset.data_vars) == {"height"}
        assert dataset["height"].attrs["units"] == "m"
        np.testing.assert_allclose(dataset["y"], (np.arange(23) + 0.5) * PIXEL[0], rtol=1e-15)
        assert dataset.attrs["source"] == "ground.opd"
        assert dataset.attrs["preparation"] == "leveled: plane\nsecond step"


def refuse(word: str) -> None:
    raise AssertionError(f"{word} is no JSON")


def test_json_holds_the_summary(result: rc.ContactResult, tmp_path: Path) -> None:
    result.save(tmp_path / "out.json")
    text = (tmp_path / "out.json").read_text(encoding="utf-8")
    read = json.loads(text, parse_constant=refuse)
    for name, value in result.summary().items():
        assert read[name] == value, name
    assert read["material"] == {
        "rigid": False,
        "young": 210e9,
        "poisson": 0.3,
        "yield_strength": 1e9,
        "hardness": None,
    }
    # A rigid body's modulus is infinite, which JSON cannot represent.
    assert read["counter_material"]["young"] is None
    assert read["converged"] is True
    assert read["counter_source"] is None


def test_json_of_two_bodies(pair: rc.ContactResult, tmp_path: Path) -> None:
    tables.save_json(pair, tmp_path / "out.json")
    read = json.loads((tmp_path / "out.json").read_text())
    assert read["ceiling"] == "per pixel"
    assert read["counter_source"] == "other.opd"


def test_values_not_finite_are_null() -> None:
    values = {"a": [math.nan, (math.inf, 1.5)], "b": {"c": -math.inf}, "d": "nan", "e": np.inf}
    read = json.loads(to_json(values), parse_constant=refuse)
    assert read == {"a": [None, [None, 1.5]], "b": {"c": None}, "d": "nan", "e": None}
