import os
import re
from dataclasses import fields, replace
from functools import lru_cache
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

import roughcontact as rc
from paths import ROOT
from roughcontact.cautions import CautionTag
from roughcontact.contact import archive
from roughcontact.contact.archive import save_result
from roughcontact.drawing.sections import linear_bins
from roughcontact.elastoplastic.archive import load_result
from roughcontact.errors import FormatError
from roughcontact.surface.provenance import NOTE
from written import PIXEL, SHAPE, rough

STEEL = rc.Material(young=210e9, poisson=0.3, name="steel")
YIELDING = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9, name="hard steel 1/3")
CERAMIC = rc.Material(young=400e9, poisson=0.23, name="alumina", hardness=15e9 / 7)
ORIGIN = rc.Provenance("ground.opd", "Wyko NT1100", "Raw", ("leveled: plane", "a second step"))
SURFACE = rc.Surface(rough(holes=False).heights, PIXEL, ORIGIN)


def surface_with_holes() -> rc.Surface:
    heights = SURFACE.heights.copy()
    heights[3:5, 7:10] = np.nan
    return rc.Surface(heights, PIXEL, ORIGIN)


def limits() -> np.ndarray:
    ceiling = np.full(SHAPE, 3e9)
    ceiling[:, 18:] = 1e9 / 3
    ceiling[0, 0] = np.inf
    return ceiling


COUNTER = rc.Surface(SURFACE.heights[::-1] / 2, PIXEL, rc.Provenance("counter.opd", "", "", ("x",)))
CASES = {
    "elastic": {"material": STEEL},
    "scalar ceiling": {"material": YIELDING, "load": 0.15},
    "ceiling by pixel": {"material": YIELDING, "ceiling": limits(), "load": 0.1},
    "masked holes": {"surface": surface_with_holes().masked(), "material": YIELDING},
    "two rough bodies": {"material": STEEL, "counter_surface": COUNTER},
    "two soft bodies": {"material": STEEL, "counter_material": YIELDING, "load": 0.01},
    "hardness": {"material": CERAMIC, "load": 0.15},
    "approach": {"material": STEEL, "load": None, "approach": 1e-7},
    "periodic": {"material": YIELDING, "boundary": "periodic", "load": 0.1},
    "tilted": {"material": YIELDING, "moments": (1e-8, -2e-8)},
    "single": {"material": YIELDING, "precision": "single"},
    "not converged": {
        "material": STEEL,
        "tolerance": 1e-14,
        "max_iterations": 2,
        "on_failure": "return",
    },
}


@lru_cache
def solve_case(case: str = "scalar ceiling") -> rc.ContactResult:
    return rc.solve(**{"surface": SURFACE, "load": 0.05, **CASES[case]})


@pytest.fixture(scope="module")
def result() -> rc.ContactResult:
    return solve_case()


def bare(path: Path) -> xarray.Dataset:
    """The file as anybody reads it."""
    with xarray.open_dataset(path, engine="h5netcdf") as dataset:
        return dataset.load()


def assert_same_bits(one: np.ndarray, two: np.ndarray) -> None:
    assert one.dtype == two.dtype
    assert one.shape == two.shape
    assert one.tobytes() == two.tobytes()


# --- there and back --------------------------------------------------------------------------


@pytest.mark.parametrize("case", CASES)
def test_every_number_keeps_its_bits(case: str, tmp_path: Path) -> None:
    result = solve_case(case)
    assert result.converged == (case != "not converged")
    if case.startswith(("scalar", "ceiling by")):
        assert result.saturated.any()
    result.save(tmp_path / "out.nc")
    again = load_result(tmp_path / "out.nc")
    maps = ("pressure", "gap", "initial_gap", "contact", "saturated", "residual_indentation")
    for name in maps:
        assert_same_bits(getattr(again, name), getattr(result, name))
    assert_same_bits(again.surface.heights, result.surface.heights)
    others = {"pair", "ceiling", "pressure", "gap"}
    assert again.totals == result.totals
    bodies = {"material", "counter_material", "boundary", "contact_modulus"}
    for name in {field.name for field in fields(result)} - others | bodies:
        assert getattr(again, name) == getattr(result, name), name
        kind = type(getattr(result, name))
        # The words of Python are kept, not which of them are arguments.
        assert type(getattr(again, name)) is (str if kind is rc.errors.Sentence else kind), name
    assert again.surface.pixel == PIXEL
    assert again.surface.provenance == result.surface.provenance
    assert again.surface.holes_masked == result.surface.holes_masked
    if isinstance(result.ceiling, np.ndarray):
        assert_same_bits(again.ceiling, result.ceiling)
    else:
        assert again.ceiling == result.ceiling
    if result.counter_surface is None:
        assert again.counter_surface is None
    else:
        assert_same_bits(again.counter_surface.heights, result.counter_surface.heights)
    assert again.summary() == result.summary()


def test_a_file_from_before_bodies_could_tilt(tmp_path: Path) -> None:
    dataset = solve_case("tilted").to_xarray()
    assert dataset.attrs["moments_x_units"] == "N m"
    for name in [name for name in dataset.attrs if name.startswith(("tilt", "moments"))]:
        del dataset.attrs[name]
    dataset.to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    again = load_result(tmp_path / "old.nc")
    assert again.tilt == (0, 0)
    assert again.moments is None


def test_a_file_from_before_steps_were_data(tmp_path: Path) -> None:
    result = solve_case("two rough bodies")
    dataset = result.to_xarray()
    del dataset.attrs["provenance"], dataset.attrs["counter_provenance"]
    dataset.to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    again = load_result(tmp_path / "old.nc")
    for body in ("surface", "counter_surface"):
        before, after = (getattr(each, body).provenance for each in (result, again))
        assert after.steps == before.steps
        assert after.source == before.source
        assert after.origin is None
        assert all(step.method == NOTE for step in after.operations)
    # It has no checksums either, and says so.
    summary, note = again.summary(), again.cautions[-1]
    assert note.kind == CautionTag.NO_CHECKSUMS
    cautions = [caution.summary() for caution in (*result.cautions, note)]
    more = {"warnings": [*result.warnings, note.text], "cautions": cautions}
    assert summary == result.summary() | more


def test_loaded_arrays_are_read_only(tmp_path: Path) -> None:
    solve_case("ceiling by pixel").save(tmp_path / "out.nc")
    again = load_result(tmp_path / "out.nc")
    for name in ("pressure", "gap", "ceiling"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(again, name)[0, 0] = 1


def test_a_loaded_result_is_a_start(tmp_path: Path) -> None:
    # Everything `solve` needs comes out of the file.
    masked = solve_case("masked holes")
    masked.save(tmp_path / "out.nc")
    again = load_result(tmp_path / "out.nc")
    resolved = rc.solve(
        again.surface,
        material=again.material,
        counter_material=again.counter_material,
        ceiling=again.ceiling,
        load=again.load,
        initial_guess=again,
    )
    np.testing.assert_allclose(resolved.pressure, masked.pressure, rtol=0, atol=1e-5 * 3e9)


@pytest.mark.long
def test_the_map_of_a_result_is_a_surface_file(tmp_path: Path) -> None:
    for case in ("scalar ceiling", "masked holes"):
        result = solve_case(case)
        result.save(tmp_path / "out.nc")
        surface = rc.read_surface(tmp_path / "out.nc")
        assert_same_bits(surface.heights, result.surface.heights)
        assert surface.pixel == PIXEL


# --- what the file holds ---------------------------------------------------------------------


def test_variables_and_coordinates(tmp_path: Path, result: rc.ContactResult) -> None:
    result.save(tmp_path / "out.nc")
    dataset = bare(tmp_path / "out.nc")
    units = {"height": "m", "initial_gap": "m", "pressure": "Pa", "gap": "m", "saturated": "1"}
    assert set(dataset.data_vars) == set(units)
    for name, unit in units.items():
        assert dataset[name].dims == ("y", "x")
        assert dataset[name].shape == SHAPE
        assert dataset[name].attrs["units"] == unit
        assert dataset[name].attrs["long_name"]
    for name, edge, points in zip("yx", PIXEL, SHAPE, strict=True):
        assert dataset[name].attrs["units"] == "m"
        np.testing.assert_allclose(np.diff(dataset[name].values), edge, rtol=1e-9)
        assert dataset[name].size == points
    assert dataset["pressure"].dtype == np.float64
    assert set(np.unique(dataset["saturated"])) == {0, 1}
    np.testing.assert_array_equal(dataset["saturated"] == 1, result.saturated)


def test_no_number_with_a_dimension_lacks_its_unit(
    tmp_path: Path, result: rc.ContactResult
) -> None:
    result.save(tmp_path / "out.nc")
    attributes = bare(tmp_path / "out.nc").attrs
    plain = {"iterations", "convolutions", "material_poisson", "counter_material_poisson"}
    numbers = {name for name, value in attributes.items() if isinstance(value, np.number)}
    assert {name for name in numbers - plain if f"{name}_units" not in attributes} == set()


@pytest.mark.parametrize("case", [case for case in CASES if case != "not converged"])
def test_the_solution_is_verified_from_the_file_alone(
    case: str, tmp_path: Path, independent
) -> None:
    solve_case(case).save(tmp_path / "out.nc")
    dataset = bare(tmp_path / "out.nc")
    attributes = dataset.attrs
    if "ceiling" in dataset:
        assert dataset["ceiling"].attrs["units"] == "Pa"
        ceiling = dataset["ceiling"].values
    else:
        ceiling = attributes.get("ceiling")
    heights = dataset["height"].values
    if "counter_height" in dataset:
        heights = heights + dataset["counter_height"].values
    # The gap in the file follows from the heights in the file, to rounding.
    gap = dataset["initial_gap"].values
    np.testing.assert_allclose(gap, np.nanmax(heights) - heights, rtol=0, atol=1e-21)
    compliance = sum(
        (1 - attributes[f"{body}_poisson"] ** 2) / attributes[f"{body}_young"]
        for body in ("material", "counter_material")
    )
    assert attributes["contact_modulus"] == pytest.approx(1 / compliance, rel=1e-14)
    pixel = tuple(float(np.diff(dataset[name].values).mean()) for name in "yx")
    # A tilt turns about the centre of the map.
    tilt = sum(
        attributes[f"tilt_{name}"] * (dataset[name] - dataset[name].mean()) for name in "yx"
    ).values
    found = independent.judge_fields(
        dataset["pressure"].values,
        np.where(np.isnan(gap), np.inf, gap + tilt),
        ceiling,
        attributes["approach"],
        pixel,
        attributes["contact_modulus"],
        attributes["boundary"],
    )
    # The pixel comes from differences of coordinates, to 1e-13; float32 rounds to 1e-7 of h0.
    slack = 1e-4 if attributes["precision"] == "single" else 1e-9
    assert found.bounded
    assert found.certificate <= attributes["tolerance"] + slack
    assert found.certificate == pytest.approx(attributes["certificate"], rel=1e-2, abs=slack)
    assert found.load == pytest.approx(attributes["load"], rel=2e-10)
    np.testing.assert_array_equal(dataset["saturated"] == 1, found.full)
    np.testing.assert_allclose(
        dataset["gap"],
        np.where(np.isfinite(gap), found.gap, np.nan),
        rtol=0,
        atol=1e-12 if slack < 1e-6 else 1e-9,
    )


# --- writing ---------------------------------------------------------------------------------


def raising(error: BaseException):
    def fsync(_: int) -> None:
        raise error

    return fsync


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failing_write_leaves_the_old_file(
    error: BaseException, tmp_path: Path, result: rc.ContactResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "out.nc"
    result.save(path)
    before = path.read_bytes()
    monkeypatch.setattr("roughcontact._tools.files.os.fsync", raising(error))
    with pytest.raises(type(error)):
        result.save(path)
    assert path.read_bytes() == before
    with pytest.raises(type(error)):
        result.save(tmp_path / "new.nc")
    assert os.listdir(tmp_path) == ["out.nc"]


def test_low_memory_writes_same_file_directly(
    tmp_path: Path, result: rc.ContactResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    result.save(tmp_path / "out.nc")
    monkeypatch.setattr("roughcontact._tools.memory.free_bytes", lambda: 0)
    result.save(tmp_path / "direct.nc")
    direct, held = (
        np.frombuffer((tmp_path / name).read_bytes(), np.uint8) for name in ("direct.nc", "out.nc")
    )
    assert direct.size == held.size
    # HDF5 notes the second in some headers, and sums them.
    assert np.count_nonzero(direct != held) < 64
    monkeypatch.setattr("roughcontact._tools.files.os.fsync", raising(OSError(28, "No space left")))
    with pytest.raises(OSError, match="No space left"):
        result.save(tmp_path / "new.nc")
    assert sorted(os.listdir(tmp_path)) == ["direct.nc", "out.nc"]


def test_the_file_appears_only_once_complete(
    tmp_path: Path, result: rc.ContactResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    replace_file = os.replace

    def watched(source: os.PathLike, target: os.PathLike) -> None:
        seen.append((Path(target).exists(), load_result(source).load))
        replace_file(source, target)

    monkeypatch.setattr(archive.os, "replace", watched)
    result.save(tmp_path / "out.nc")
    assert seen == [(False, result.load)]
    assert (tmp_path / "out.nc").exists()


@pytest.mark.parametrize("name", ["out.h5", "out", "out.nc.bak", "out.npz"])
def test_the_suffix_is_nc(name: str, tmp_path: Path, result: rc.ContactResult) -> None:
    with pytest.raises(rc.InputError, match=rf"path must end in \.nc, got.*{name}"):
        save_result(result, tmp_path / name)
    assert os.listdir(tmp_path) == []


def test_file_name_that_is_not_utf_8_is_printable(tmp_path: Path, result: rc.ContactResult) -> None:
    # As Python gives the name of a file whose bytes are not UTF-8.
    surface = replace(result.surface, provenance=rc.Provenance("gr\udcfcn.opd"))
    replace(result, pair=replace(result.pair, surface=surface)).save(tmp_path / "out.nc")
    assert load_result(tmp_path / "out.nc").surface.provenance.source == "gr n.opd"


# --- files that are no result ----------------------------------------------------------------


def assert_rejected(path: Path, *words: str) -> None:
    with pytest.raises(rc.FormatError) as caught:
        load_result(path)
    message = str(caught.value)
    assert all(word in message for word in (path.name, *words)), message
    assert "\n" not in message
    # No chain of the library's errors behind it.
    assert caught.value.__cause__ is None
    assert caught.value.__suppress_context__ or caught.value.__context__ is None


def test_missing_file_raises_error(tmp_path: Path) -> None:
    assert_rejected(tmp_path / "out.nc", "does not exist", "check")


def test_files_of_another_kind(tmp_path: Path) -> None:
    expected = ("expected a NetCDF file written by ContactResult.save",)
    path = tmp_path / "bad.nc"
    for content in (
        b"",
        b"garbage" * 999,
        b"CDF\x01" + bytes(99),
        b"\x89HDF\r\n\x1a\n" + bytes(99),
    ):
        path.write_bytes(content)
        assert_rejected(path, *expected)
    xarray.Dataset({"temperature": ("t", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    assert_rejected(path, *expected)
    height = xarray.Dataset({"height": (("y", "x"), np.eye(3), {"units": "m"})})
    height.to_netcdf(path, engine="h5netcdf")
    assert_rejected(path, *expected)


@pytest.mark.parametrize("fraction", [0.001, 0.1, 0.5, 0.9, 0.999])
def test_truncated_files(fraction: float, tmp_path: Path, result: rc.ContactResult) -> None:
    path = tmp_path / "out.nc"
    result.save(path)
    content = path.read_bytes()
    path.write_bytes(content[: int(fraction * len(content))])
    assert_rejected(path, "expected")


@pytest.mark.parametrize("name", ["height", "pressure", "gap"])
def test_a_variable_is_missing(name: str, tmp_path: Path, result: rc.ContactResult) -> None:
    result.to_xarray().drop_vars(name).to_netcdf(tmp_path / "out.nc", engine="h5netcdf")
    assert_rejected(tmp_path / "out.nc", name)


@pytest.mark.parametrize(
    ("name", "value"),
    [(name, None) for name in ("status", "load", "material_young", "pixel_x", "boundary")]
    + [("pixel_y", -1e-6), ("material_poisson", 0.7), ("material_young", 0.0), ("load", "much")],
)
def test_missing_or_absurd_attribute_raises_format_error(
    name: str, value: object, tmp_path: Path, result: rc.ContactResult
) -> None:
    dataset = result.to_xarray()
    del dataset.attrs[name]
    if value is not None:
        dataset.attrs[name] = value
    dataset.to_netcdf(tmp_path / "out.nc", engine="h5netcdf")
    assert_rejected(tmp_path / "out.nc", name if value is None else "")


def test_a_map_with_its_axes_swapped(tmp_path: Path, result: rc.ContactResult) -> None:
    # Pixel and axes would no longer belong together; read_surface refuses the same file.
    result.to_xarray().transpose().to_netcdf(tmp_path / "out.nc", engine="h5netcdf")
    assert_rejected(tmp_path / "out.nc")


# --- files that are not as they were written -------------------------------------------------


def test_the_documentation_computes_the_checksums(
    tmp_path: Path, result: rc.ContactResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(import hashlib.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    result.save("result.nc")
    exec(code, {})
    with h5py.File("result.nc", "a") as file:
        file.attrs["load"] = 2.0
    with pytest.raises(AssertionError):
        exec(code, {})


@pytest.mark.parametrize("name", ["height", "initial_gap", "pressure", "gap", "saturated", "y"])
def test_a_variable_that_was_changed_is_named(
    name: str, tmp_path: Path, result: rc.ContactResult
) -> None:
    path = tmp_path / "out.nc"
    result.save(path)
    with h5py.File(path, "a") as file:
        values = file[name][...]
        values.ravel()[-1:].view(np.uint8)[0] ^= 1
        file[name][...] = values
    assert_rejected(path, f"written: {name} does not match the checksum", "take a copy")


@pytest.mark.parametrize(
    ("where", "name", "value"),
    [
        ("/", "load", 0.16),
        ("/", "warnings", "none at all"),
        ("/", "remark", "not there before"),
        ("pressure", "units", "MPa"),
        ("/", "checksum_sha256", "0" * 64),
    ],
)
def test_changed_attributes_raise_format_error(
    where: str, name: str, value: object, tmp_path: Path, result: rc.ContactResult
) -> None:
    path = tmp_path / "out.nc"
    result.save(path)
    with h5py.File(path, "a") as file:
        file[where].attrs[name] = value
    assert_rejected(path, "written: attributes do not match the checksum")


@pytest.mark.long
def test_missing_checksum_raises_format_error(tmp_path: Path, result: rc.ContactResult) -> None:
    path = tmp_path / "out.nc"
    for where, words in (("/", "attributes do"), ("gap", "gap and attributes do")):
        result.save(path)
        with h5py.File(path, "a") as file:
            del file[where].attrs["checksum_sha256"]
        assert_rejected(path, f"written: {words} not match the checksum")


@pytest.mark.long
def test_a_map_that_was_changed_is_not_read(tmp_path: Path, result: rc.ContactResult) -> None:
    path = tmp_path / "out.nc"
    for save in (result.save, result.surface.save):
        save(path)
        with h5py.File(path, "a") as file:
            file["height"][3, 4] += 1e-9
        with pytest.raises(FormatError, match=r"out\.nc .* height does not match the checksum"):
            rc.read_surface(path)
        # Unread parts may be damaged.
        if save == result.save:
            save(path)
            with h5py.File(path, "a") as file:
                file["gap"][3, 4] += 1e-9
            assert_same_bits(rc.read_surface(path).heights, result.surface.heights)


@pytest.mark.long
def test_the_note_on_a_file_without_checksums_stays(tmp_path: Path) -> None:
    result = solve_case("two soft bodies")
    result.to_xarray().to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    old = load_result(tmp_path / "old.nc")
    assert old.cautions[:-1] == result.cautions
    assert old.cautions[-1].kind == CautionTag.NO_CHECKSUMS
    # Saved again it has checksums, which prove nothing of what was before.
    old.save(tmp_path / "new.nc")
    assert load_result(tmp_path / "new.nc").cautions == old.cautions


def test_tiny_ceiling_attribute_gives_few_bins(tmp_path: Path) -> None:
    # The ceiling was the width of a bin, and the pressures the range: 3e9 bins.
    dataset = solve_case("scalar ceiling").to_xarray()
    dataset.attrs["ceiling"] = 1.0
    dataset.to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    result = load_result(tmp_path / "old.nc")
    assert linear_bins([result], [result.pressure[result.contact]]).edges.size < 100
