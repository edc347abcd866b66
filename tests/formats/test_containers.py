"""Containers: several maps of a surface in one archive."""

from __future__ import annotations

import errno
import gzip
import json
import math
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import netcdf_file

import vendors
from reading import HEIGHTS, assert_rejected, needs_reader, write
from roughcontact._tools import memory
from roughcontact.errors import InputError
from roughcontact.formats import containers, source
from roughcontact.formats.read import channels, read_surface
from roughcontact.formats.source import Channel

TEXT = "\n".join(" ".join(map(str, row)) for row in HEIGHTS)
# Sides x, y [µm], as the container has them.
SIZE = [6.0, 4.0]


def squeezed(folder: Path) -> bytes:
    """Return a map as the site stores it: first index along x, missing points in a mask."""
    path = folder / "squeezed.nc"
    with netcdf_file(path, "w") as file:
        for axis, points, side in zip("xy", HEIGHTS.T.shape, SIZE, strict=True):
            file.createDimension(axis, points)
            along = file.createVariable(axis, "f8", (axis,))
            along[:] = (np.arange(points) + 0.5) * side / points
            along.length, along.unit = side, "um"
        values = file.createVariable("heights", "f8", ("x", "y"))
        values[:] = np.nan_to_num(HEIGHTS.T)
        values.unit = "um"
        file.createVariable("mask", "i1", ("x", "y"))[:] = np.isnan(HEIGHTS.T)
    return path.read_bytes()


def measurement(name: str, **more: Any) -> dict[str, Any]:
    described = {"name": name, "size": SIZE, "unit": "um", "height_scale": 2.0}
    return described | {"datafile": {"original": f"{name}.txt"}} | more


def container(path: Path, *surfaces: list[dict[str, Any]], **files: str | bytes) -> Path:
    """Write a container with measurements of some surfaces and their files."""
    described = {
        "surfaces": [
            {"name": f"part {number}", "topographies": topographies}
            for number, topographies in enumerate(surfaces)
        ]
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("index.json", json.dumps(described))
        for name, content in files.items():
            archive.writestr(name.replace("__", "."), content)
    return path


def test_one_map_needs_no_name(tmp_path: Path) -> None:
    prepared = {"datafile": {"original": "a.txt", "squeezed-netcdf": "a.nc"}}
    instrument = {"instrument": {"name": "AFM 3"}}
    path = container(
        tmp_path / "c.zip",
        [measurement("a", **prepared, **instrument)],
        a__txt="lost",
        a__nc=squeezed(tmp_path),
    )
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-12)
    assert surface.pixel == pytest.approx((4e-6 / 3, 6e-6 / 4))
    about = surface.provenance
    assert (about.source, about.instrument, about.channel) == ("c.zip", "AFM 3", "")
    assert "heights as prepared by contact.engineering" in about.in_words()
    assert channels(path) == (Channel("a", "um", True, (3, 4)),)


def test_original_uses_scale_unit_and_size_of_container(tmp_path: Path) -> None:
    path = container(tmp_path / "c.zip", [measurement("a")], a__txt=TEXT)
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, 2 * HEIGHTS * 1e-6, rtol=1e-12)
    assert surface.pixel == pytest.approx((4e-6 / 3, 6e-6 / 4))
    assert "heights times 2, as the container states" in surface.provenance.in_words()
    # A wrong size is replaced as that of any file.
    larger = read_surface(path, size="40 um x 60 um", override_size=True)
    assert larger.size == pytest.approx((40e-6, 60e-6))
    assert_rejected(path, "c.zip contains its unit", kind=InputError, unit="nm")
    assert_rejected(path, "c.zip contains its size", kind=InputError, size="1 mm x 2 mm")


def test_several_maps_are_chosen_by_name(tmp_path: Path) -> None:
    scan = measurement("line", size=[6.0])
    path = container(
        tmp_path / "c.zip",
        [measurement("a"), scan],
        [measurement("a"), measurement("a")],
        a__txt=TEXT,
    )
    names = ["part 0: a", "part 0: line", "part 1: a (2)", "part 1: a (3)"]
    assert [channel.name for channel in channels(path)] == names
    assert [channel.is_height for channel in channels(path)] == [True, False, True, True]
    assert_rejected(
        path, "c.zip holds", *(repr(n) for n in names if "line" not in n), kind=InputError
    )
    assert read_surface(path, channel="part 0: a").provenance.channel == "part 0: a"
    assert read_surface(path, channel=2).provenance.channel == "part 1: a (2)"
    assert_rejected(path, "'part 0: line' of c.zip is a line scan", kind=InputError, channel=1)
    # Of a map and a line scan the map is meant.
    only = container(tmp_path / "d.zip", [scan, measurement("a")], a__txt=TEXT)
    assert read_surface(only).provenance.channel == "a"


def test_older_containers_are_yaml(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    path = tmp_path / "c.zip"
    described = """
surfaces:
- name: part
  topographies:
  - name: 2
    datafile: {original: a.txt}
    size: !!python/tuple [6.0, 4.0]
    unit: um
"""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("meta.yml", described)
        archive.writestr("a.txt", TEXT)
    surface = read_surface(path)
    np.testing.assert_allclose(surface.heights, HEIGHTS * 1e-6, rtol=1e-12)
    assert surface.size == pytest.approx((4e-6, 6e-6))
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("meta.yml", "surfaces: !!python/object/apply:os.getcwd []")
    assert_rejected(path, "c.zip cannot be read as a container", "python/object")


def write_yaml(path: Path, text: str) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("meta.yml", text)
        archive.writestr("a.txt", TEXT)
    return path


def test_yaml_with_aliases_is_rejected(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    # 14 levels of nine aliases are 10¹³ values, merged keys 2³⁰.
    laughs = [f"a{i}: &a{i} [" + ",".join([f"*a{i - 1}"] * 9) + "]" for i in range(1, 14)]
    merged = [f"b{i}: &b{i} {{<<: [*b{i - 1}, *b{i - 1}], k: 1}}" for i in range(1, 30)]
    for lines, name in ((["a0: &a0 [x]", *laughs], "*a13"), (["b0: &b0 {k: 1}", *merged], "*b29")):
        entry = f"{{name: {name}, size: [6, 4], unit: um, datafile: {{original: a.txt}}}}"
        text = "\n".join([*lines, f"surfaces: [{{name: s, topographies: [{entry}]}}]"])
        assert_rejected(write_yaml(tmp_path / "c.zip", text), "c.zip holds meta.yml with aliases")


def test_long_indexes_are_rejected_before_they_are_parsed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    yaml = pytest.importorskip("yaml")
    for name in ("load", "parse"):
        monkeypatch.setattr(yaml, name, lambda *_: pytest.fail("parsed"))
    text = "surfaces:\n" + "- {name: s, topographies: []}\n" * 300000
    assert_rejected(
        write_yaml(tmp_path / "c.zip", text), "c.zip holds meta.yml of 9000010 characters"
    )


def test_many_measurements_are_rejected_and_few_listed_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "c.zip"
    same = measurement("a")
    container(path, [same] * 1001, a__txt=TEXT)
    assert_rejected(path, "c.zip lists 1001 measurements, the limit is 1000")
    container(path, [same] * 1000, a__txt=TEXT)
    unpacked = []
    whole = containers._unpack_member
    monkeypatch.setattr(containers, "_unpack_member", lambda *a: unpacked.append(a[1]) or whole(*a))
    listed = channels(path)
    assert [listed[0].name, listed[999].name] == ["a (0)", "a (999)"]
    assert unpacked == ["a.txt"]


@pytest.mark.parametrize("key", ["name", "unit", "datafile"])
@pytest.mark.parametrize("value", [["a"], {"a": "b"}])
def test_an_entry_that_is_no_text_is_rejected(tmp_path: Path, key: str, value: object) -> None:
    more = {"original": value} if key == "datafile" else value
    path = container(tmp_path / "c.zip", [measurement("a") | {key: more}], a__txt=TEXT)
    assert_rejected(path, "c.zip cannot be read as a container", "not a text")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("height_scale", 0),
        ("height_scale", -1),
        ("height_scale", math.nan),
        ("data_source", -1),
        ("size", [1, 2, 3]),
        ("size", [-1, 2]),
    ],
)
def test_values_that_mean_nothing_are_rejected(tmp_path: Path, key: str, value: object) -> None:
    path = container(tmp_path / "c.zip", [measurement("a", **{key: value})], a__txt=TEXT)
    assert_rejected(path, f"c.zip states {key} = ", "of 'a'")


@pytest.mark.parametrize(("size", "is_noted"), [(SIZE, False), ([60.0, 40.0], True)])
def test_size_that_contradicts_the_file_is_noted(
    tmp_path: Path, size: list[float], is_noted: bool
) -> None:
    files = {"squeezed-netcdf": "a.nc"}
    entry = measurement("a", size=size, datafile=files, height_scale=1)
    path = container(tmp_path / "c.zip", [entry], a__nc=squeezed(tmp_path))
    surface = read_surface(path)
    assert surface.size == pytest.approx((4e-6, 6e-6))
    note = "the container states a size of 40 µm × 60 µm, the data file 4 µm × 6 µm"
    assert (note in surface.provenance.in_words()) is is_noted


def test_a_full_disk_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = container(tmp_path / "c.zip", [measurement("a")], a__txt=TEXT)

    def fill(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(containers.shutil, "copyfileobj", fill)
    assert_rejected(path, "c.zip cannot be unpacked", "no space left", "TMPDIR")
    packed = tmp_path / "map.csv.gz"
    packed.write_bytes(gzip.compress(TEXT.encode()))
    monkeypatch.setattr(source.gzip.GzipFile, "read", fill)
    assert_rejected(packed, "map.csv.gz cannot be unpacked", "no space left", "TMPDIR")


def test_unreadable_containers_are_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "c.zip"
    for name, words in {
        "notes.txt": "holds neither index.json",
        "index.json": "cannot be read",
    }.items():
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(name, '{"surfaces": [{}]}')
        assert_rejected(path, "c.zip", words)
    path.write_bytes(b"PK\3\4" + b"x" * 100)
    assert_rejected(path, "c.zip cannot be read as a container")
    container(path, [measurement("a")])
    assert_rejected(path, "c.zip cannot be read as a container", "no item named 'a.txt'")
    container(path, [measurement("a", datafile={})])
    assert_rejected(path, "c.zip cannot be read as a container")
    container(path, [measurement("a", datafile={"original": "b.zip"})], b__zip=path.read_bytes())
    assert_rejected(path, "c.zip holds b.zip, another archive")
    array = measurement("a", datafile={"original": "a.h5"})
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["z"] = HEIGHTS
    container(path, [array], a__h5=(tmp_path / "a.h5").read_bytes())
    assert_rejected(path, "c.zip holds a.h5, whose first axis may be x or y")
    container(path, [measurement("a", unit=None)], a__txt=TEXT)
    assert_rejected(path, "a.txt gives no unit", kind=InputError)
    assert read_surface(path, unit="um", size="4 um x 6 um").size == pytest.approx((4e-6, 6e-6))
    monkeypatch.setattr(memory, "_SMALL", 10)
    monkeypatch.setattr(memory, "_PACKED", 1)
    container(path, [measurement("a")], a__txt="0 " * 10000)
    assert_rejected(path, "a.txt in c.zip holds", "packed")


def test_damaged_containers_raise_input_error_or_read_unchanged(tmp_path: Path) -> None:
    whole = container(tmp_path / "c.zip", [measurement("a")], a__txt=TEXT).read_bytes()
    path, expected = tmp_path / "d.zip", read_surface(tmp_path / "c.zip")
    rng = np.random.default_rng(0)
    refusals = 0
    for _ in range(150):
        content = bytearray(whole)
        for place in rng.integers(len(content), size=rng.integers(1, 4)):
            content[place] = rng.integers(256)
        path.write_bytes(
            content[: rng.integers(1, len(content))] if rng.random() < 0.2 else content
        )
        try:
            surface = read_surface(path)
        except InputError:
            refusals += 1
        else:
            np.testing.assert_array_equal(surface.heights, expected.heights)
            assert surface.pixel == expected.pixel
    assert 50 < refusals < 150


# Files of the library of the site, in a process: it warns on import.
PEER = """
import sys
import numpy as np
from SurfaceTopography import Topography
from SurfaceTopography.Container.IO import read_container
from SurfaceTopography.Container.SurfaceContainer import InMemorySurfaceContainer
rng = np.random.default_rng(0)
masked = np.ma.masked_less(rng.random((5, 7)), 0.2)
maps = [
    Topography(masked, (5.0, 14.0), unit="nm", info={"name": "fine"}),
    Topography(rng.random((4, 3)), (1.0, 2.0), unit="mm", periodic=True, info={"name": "wide"}),
]
InMemorySurfaceContainer(maps).to_zip(sys.argv[1])
for number, map in enumerate(read_container(sys.argv[1])[0]):
    heights = np.ma.filled(np.ma.asarray(map.heights(), float), np.nan)
    np.save(f"{sys.argv[2]}/{number}.npy", heights)
    print(map.unit, *map.physical_sizes)
"""


@needs_reader
@pytest.mark.parametrize("order", [1, -1])
def test_keyence_project_lists_its_files_by_name(order: int, tmp_path: Path) -> None:
    content, _, _ = vendors.vk4()
    path = tmp_path / "project.cag"
    with zipfile.ZipFile(path, "w") as archive:
        for item in ("a1", "b2"):
            archive.writestr(f"m/{item}/c3", content)
        tags = [
            [f"<Path>{item}</Path>", rf"<OriginalFileName>C:\data\{name}.vk4</OriginalFileName>"]
            for item, name in (("a1", "ground"), ("b2", "honed"))
        ]
        items = "".join(f"<Item>{''.join(pair[::order])}</Item>" for pair in tags)
        archive.writestr("m/d4", f"\ufeff<Map>{items}</Map>")
        archive.writestr("thumbnail", b"\x89PNG")
    assert [entry.name for entry in channels(path)] == ["ground.vk4", "honed.vk4"]
    assert_rejected(path, "0: 'ground.vk4'; 1: 'honed.vk4'", kind=InputError)
    surface = read_surface(path, channel="honed.vk4")
    single = read_surface(write(tmp_path, "single.vk4", content))
    np.testing.assert_array_equal(surface.heights, single.heights)
    assert surface.pixel == single.pixel


@needs_reader
@pytest.mark.process
def test_heights_units_and_sizes_are_those_of_the_library(tmp_path: Path) -> None:
    path = tmp_path / "c.zip"
    printed = subprocess.run(
        [sys.executable, "-c", PEER, str(path), str(tmp_path)],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.splitlines()
    assert [channel.name for channel in channels(path)] == ["fine", "wide"]
    for number, line in enumerate(printed):
        unit, x, y = line.split()
        metre = {"nm": 1e-9, "mm": 1e-3}[unit]
        surface = read_surface(path, channel=number)
        expected = np.load(tmp_path / f"{number}.npy").T * metre
        np.testing.assert_allclose(surface.heights, expected, rtol=1e-12)
        assert surface.size == pytest.approx((float(y) * metre, float(x) * metre))
