import json
from pathlib import Path

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import roughcontact as rc
import written
from roughcontact.elastoplastic.archive import load_elastoplastic
from roughcontact.formats import export, metrology, netcdf, tables, vtk
from written import (
    EXACT,
    HAS_READER,
    MEASUREMENTS,
    PIXEL,
    READABLE,
    RESULT_SUFFIXES,
    SHAPE,
    SURFACE_SUFFIXES,
    VOLUME_SHAPE,
    VOLUME_SUFFIXES,
    assert_same_bits,
    rough,
    saved_and_read,
    sur_fields,
    vtk_image,
)


@pytest.fixture(scope="module")
def result() -> rc.ContactResult:
    return written.contact()


@pytest.fixture(scope="module")
def volume() -> rc.ElastoplasticResult:
    return written.volume()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for all examples of a law: files of the same name replace each other."""
    return tmp_path_factory.mktemp("export")


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
@settings(max_examples=10, deadline=None)
def test_every_height_keeps_its_bits(suffix: str, folder: Path, surface: rc.Surface) -> None:
    again = saved_and_read(surface, folder / f"map{suffix}")
    assert_same_bits(again.heights, surface.heights)
    # SurfaceTopography multiplies the pixel by the number of points, and divides again.
    assert again.pixel == pytest.approx(surface.pixel, rel=1e-15 if suffix == ".x3p" else 0, abs=0)


@pytest.mark.long
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
        "wyko_nt1100_test_1.opd",
        "sur-2.sur",
        "x3p-2.x3p",
        "bullet_land_fixed.x3p",
        "dvd_afm.sur",
        "metropro-1.dat",
        "opd-1.opd",
        "mnt-1.mnt",
        "uncd_afm.001",
    ],
)
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


@pytest.mark.long
def test_maps_pressure_and_numbers_of_a_volume(
    volume: rc.ElastoplasticResult, tmp_path: Path
) -> None:
    for suffix in VOLUME_SUFFIXES:
        volume.save(tmp_path / f"out{suffix}")
    _, arrays = vtk_image(tmp_path / "out.vti")
    # Those of the ceiling are not among them.
    assert set(arrays) == {
        "height",
        "initial_gap",
        "pressure",
        "gap",
        "contact",
        "residual_displacement",
    }
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
    record = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert record["volume"] == volume.summary()
    # The words on yield are those of the volume, not of a contact without ceiling.
    assert record["regime"] == volume.regime != volume.contact.regime
    assert record["max_pressure"] == volume.contact.max_pressure
    assert load_elastoplastic(tmp_path / "out.nc").summary() == volume.summary()


def test_table_lists_every_format() -> None:
    for kind, known in (
        (export.SURFACE, SURFACE_SUFFIXES),
        (export.CONTACT, RESULT_SUFFIXES),
        (export.VOLUME, VOLUME_SUFFIXES),
    ):
        assert sorted(kind.suffixes) == sorted(known)
        assert all(f"{suffix} " in export.list_formats(kind) for suffix in known)
    assert export.list_formats(export.SURFACE).startswith(".nc heights and provenance")
    assert ".csv pressure, " in export.list_formats(export.CONTACT, export.VOLUME)
    assert ".vtr strain and stress" in export.list_formats(export.CONTACT, export.VOLUME)


def test_unknown_suffix_lists_suffixes(
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


def test_wrong_suffix_raises_input_error(
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
            patch.setattr("roughcontact._tools.files.os.replace", full)
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
