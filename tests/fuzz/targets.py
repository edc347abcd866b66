"""Files for `damaged_files`: all that the program reads back, with their readers.

Maps of instruments and of other programs, results, the steps of sweeps and of runs of the volume
model, and what a project keeps of its contacts.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import os
import tempfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
import samples
from plain import Plain, differing, plain_hdf5, plain_mnt
from roughcontact.batch import plan, project
from roughcontact.errors import RoughcontactError
from roughcontact.formats.read import SUFFIXES, channels
from roughcontact.solvers.progress import Progress
from samples import Sample

SOURCE = Path(rc.__file__).parents[1]
STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9, name="steel")
LOADS = (0.01, 0.03, 0.09)
FORCES = (0.02, 0.04)

PLAIN_TEXTS = (".csv", ".txt", ".asc", ".json", ".toml")
# Those and the formats with a head that is text.
TEXTS = (*PLAIN_TEXTS, ".sdf", ".al3d", ".bcr", ".stp", ".mi", ".001")


@dataclass(frozen=True)
class Reading:
    """Outcome of reading: values by name, a map, or an error.

    ``again`` says that something was solved again, ``said`` what the program says of a file that
    it cannot prove.
    """

    facts: dict[str, str] = field(default_factory=dict)
    plain: Plain | None = None
    refused: str = ""
    cause: str = ""
    raised: str = ""
    again: bool = False
    said: str = ""


@dataclass(frozen=True)
class Target:
    """Files of which one is damaged, and how they are read.

    Parameters
    ----------
    name : str
        By what it is known.
    files : dict of bytes
        Files in the folder, by name.
    damaged : tuple of str
        Those that may be damaged.
    read : callable
        ``read(folder, file)`` returns a `Reading`; ``file`` is the damaged one.
    fields : dict
        The bytes of a file that state grid and scale.
    sample : Sample or None
        The map that it is.
    unproven : bool
        Whether it is text that people write, of which any may be right.
    """

    name: str
    files: dict[str, bytes]
    damaged: tuple[str, ...]
    read: Callable[[Path, str], Reading]
    fields: dict[str, tuple[tuple[int, int], ...]] = field(default_factory=dict)
    sample: Sample | None = None
    unproven: bool = False


# Targets ------------------------------------------------------------------------------------

MADE = (
    "made.npy",
    "made.npz",
    "made.csv",
    "made.txt",
    "made.asc",
    "bare.nc",
    "made.nc",
    "made.sdf",
    "made.x3p",
    "stored.x3p",
    "made.sur",
    "made.tmd",
    "made.os3d",
    "made.nms",
    "made.zmg",
    "made.plu",
    "made.vk4",
    "made.al3d",
    "made.bcr",
    "made.stp",
    "made.mi",
    "made.gwy",
    "made.plux",
    "made.datx",
)
SAVED = ("saved.nc", "saved.npz", "saved.csv", "saved.x3p", "saved.sur")
MEASURED = (
    "wyko_nt1100_test_1.opd",
    "opd-1.opd",
    "sur-2.sur",
    "dvd_afm.sur",
    "metropro-1.dat",
    "uncd_afm.001",
    "mnt-1.mnt",
    "x3p-2.x3p",
    "bullet_land_fixed.x3p",
)
RESULTS = {
    "contact.nc": 0.08,
    "bodies.nc": 0.06,
    "volume.nc": 0.06,
    "contact.nc, its map": 0.02,
    "sweep": 0.07,
    "volume steps": 0.03,
    "project": 0.05,
    "project.toml": 0.02,
}
SHARES = {
    **dict.fromkeys(MADE, 0.42 / len(MADE)),
    **dict.fromkeys(SAVED, 0.10 / len(SAVED)),
    **dict.fromkeys(MEASURED, 0.07 / len(MEASURED)),
    **RESULTS,
}
"""How much of the damage falls on each."""

_WORDS = {
    "contact.nc": "contact `.nc`",
    "bodies.nc": "contact `.nc`",
    "volume.nc": "volume `.nc`",
    "contact.nc, its map": "contact `.nc`",
    "sweep": "steps of a sweep",
    "volume steps": "steps of the volume model",
    "project": "records and files of a project",
    "project.toml": "project file",
}


def _group(name: str) -> str:
    suffix = f"`{Path(name).suffix}`"
    if name in SAVED:
        return f"map {suffix} of the program"
    return f"{suffix}, measured" if name in MEASURED else suffix


GROUPS = {name: _WORDS.get(name) or _group(name) for name in SHARES}
"""In which row of the table each is counted."""


def probabilities() -> list[float]:
    """Return the shares, of one."""
    total = sum(SHARES.values())
    return [share / total for share in SHARES.values()]


def other_suffixes(suffix: str) -> list[str]:
    """Return the suffixes that a file could be misnamed by."""
    return sorted({*SUFFIXES, ".000"} - {suffix})


# Making them --------------------------------------------------------------------------------------

_PROJECT = """\
folder = "results"
write = ["nc", "csv"]

[materials.steel]
young = "210 GPa"
poisson = 0.3
yield-strength = "1 GPa"

[defaults]
unit = "um"
size = "14 um x 12 um"
material = "steel"

[[contact]]
name = "one"
file = "rough.npy"
load = "0.01 N"

[[contact]]
name = "two"
file = "rough.npy"
load = "0.02 N"
ceiling = "none"
"""


def _rough() -> rc.Surface:
    heights = 5e-8 * np.random.default_rng(8).standard_normal((14, 12))
    return rc.Surface(heights, (1e-6, 1.2e-6), rc.Provenance("ground.opd", "Wyko NT1100", "Raw"))


def _ball() -> rc.Surface:
    y, x = (1e-6 * (np.arange(n) - (n - 1) / 2) for n in (14, 12))
    return rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 50e-6), (1e-6, 1e-6))


def _curve(folder: Path, progress: Any = None) -> rc.results.LoadCurve:
    return rc.sweep(_rough(), material=STEEL, loads=LOADS, folder=folder, progress=progress)


def _solve_ball(folder: Path, progress: Any = None) -> rc.ElastoplasticResult:
    return rc.solve_elastoplastic(
        _ball(),
        material=STEEL,
        increments=1,
        loads=FORCES,
        tolerance=1e-2,
        folder=folder,
        progress=progress,
    )


def prepare(folder: Path) -> None:
    """Solve and write what is not made as bytes; the times in it are set."""
    for name in ("outside", "results", "sweep", "volume steps", "project"):
        (folder / name).mkdir(parents=True)
    results = folder / "results"
    holed = np.array(_rough().heights)
    holed[3, 4] = np.nan
    contact = rc.solve(rc.Surface(holed, _rough().pixel).masked(), material=STEEL, load=0.05)
    dataclasses.replace(contact, seconds=0.25).save(results / "contact.nc")
    ceiling = np.full(holed.shape, 3e9)
    ceiling[:, 6:] = np.inf
    bodies = rc.solve(
        _rough(),
        counter_surface=rc.Surface(_rough().heights[::-1] / 2, _rough().pixel),
        material=STEEL,
        ceiling=ceiling,
        load=0.03,
    )
    dataclasses.replace(bodies, seconds=0.25).save(results / "bodies.nc")
    _curve(folder / "sweep" / "kept")
    volume = _solve_ball(folder / "volume steps" / "kept")
    dataclasses.replace(volume, seconds=0.25).save(results / "volume.nc")
    _run_project(folder / "project")
    # Numbers that would pass for heights, in files that no one is asked to read.
    heights = 1e-7 * np.random.default_rng(9).standard_normal((64, 64))
    (folder / "outside" / "numbers.bin").write_bytes(heights.tobytes())
    (folder / "outside" / "numbers.txt").write_text("3e-6")
    import h5py

    with h5py.File(folder / "outside" / "numbers.h5", "w") as file:
        file["height"] = heights


def _run_project(folder: Path) -> None:
    import subprocess
    import sys

    (folder / "project.toml").write_text(_PROJECT, encoding="utf-8")
    np.save(folder / "rough.npy", _rough().heights * 1e6)
    environment = os.environ | {"PYTHONPATH": str(SOURCE)}
    subprocess.run(
        [sys.executable, "-m", "roughcontact", "run", "project.toml", "--quiet"],
        cwd=folder,
        env=environment,
        check=True,
    )


def load(prepared: Path) -> dict[str, Target]:
    """Return the targets that are here; `prepare` has made what they are of."""
    with tempfile.TemporaryDirectory() as folder:
        maps = [*samples.made(Path(folder)), *samples.saved(Path(folder))]
    found = {sample.name: _make_sample_target(sample) for sample in (*maps, *samples.measured())}
    for file in ("contact.nc", "bodies.nc", "volume.nc"):
        found[file] = _make_result_target(file, file, prepared, rc.read_result)
    found["contact.nc, its map"] = _make_result_target(
        "contact.nc, its map", "contact.nc", prepared, rc.read_surface
    )
    found["sweep"] = _make_folder_target(
        "sweep", prepared / "sweep", functools.partial(_read_steps, _curve), ("kept",)
    )
    steps = prepared / "volume steps"
    found["volume steps"] = _make_folder_target(
        "volume steps", steps, functools.partial(_read_steps, _solve_ball), ("kept",)
    )
    files = _files(prepared / "project")
    found["project"] = _make_folder_target(
        "project", prepared / "project", functools.partial(_read_project, files), ("results",)
    )
    text = {"project.toml": _PROJECT.encode(), "rough.npy": files["rough.npy"]}
    found["project.toml"] = Target(
        "project.toml", text, ("project.toml",), _read_project_file, unproven=True
    )
    return found


def _files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def _make_sample_target(sample: Sample) -> Target:
    if sample.stated is None:
        # The counts of this one are known from its own reading only.
        def stated(content: bytes) -> Plain:
            plain = original(target).plain
            assert plain is not None
            counts = (plain.heights - np.mean(plain.heights)) / 1e-13
            return plain_mnt(sample.content, counts)(content)

        sample = dataclasses.replace(sample, stated=stated)
    if sample.name.endswith(".nc"):
        sample = dataclasses.replace(sample, structured=plain_hdf5)
    target = Target(
        sample.name,
        {sample.name: sample.content},
        (sample.name,),
        functools.partial(_read_map, sample),
        {sample.name: sample.fields},
        sample,
    )
    return target


def _make_result_target(
    name: str, file: str, prepared: Path, read: Callable[[Path], Any]
) -> Target:
    content = (prepared / "results" / file).read_bytes()
    return Target(name, {file: content}, (file,), functools.partial(_read_result, read))


def _make_folder_target(
    name: str, folder: Path, read: Callable[[Path, str], Reading], kept: tuple[str, ...]
) -> Target:
    files = _files(folder)
    # A lock holds nothing.
    damaged = tuple(file for file in files if file.startswith(kept) and files[file])
    return Target(name, files, damaged, read)


# Reading them -------------------------------------------------------------------------------------


@contextlib.contextmanager
def _caught(readings: list[Reading]) -> Iterator[None]:
    """Add what is raised, of the kinds that the program promises or of others."""
    try:
        yield
    except RoughcontactError as error:
        readings.append(Reading(refused=str(error), cause=repr(error.__cause__)))
    except BaseException as error:
        readings.append(Reading(raised=f"raised {error!r}"))


def _reading(work: Callable[[], Reading]) -> Reading:
    readings: list[Reading] = []
    with _caught(readings):
        readings.append(work())
    return readings[0]


def _read_map(sample: Sample, folder: Path, file: str) -> Reading:
    path = folder / file
    matrix = path.suffix in (".npy", ".npz", ".csv", ".txt", ".asc")
    arguments = sample.arguments
    if file != sample.name:
        # Under another name: a file without scale gets one.
        arguments = {"unit": "um", "size": "30 um x 44 um"} if matrix else {}

    def work() -> Reading:
        surface = rc.read_surface(path, **arguments)
        return Reading(plain=Plain(surface.heights, surface.pixel), said=describe_checksum(surface))

    reading = _reading(work)
    if zlib.crc32(path.read_bytes()) % 4 == 0 and not reading.raised:
        # The list of channels is read as well, and may fail.
        listed = _reading(lambda: Reading(facts={"channels": repr(channels(path))}))
        return listed if listed.raised else reading
    return reading


def _read_result(read: Callable[[Path], Any], folder: Path, file: str) -> Reading:
    def work() -> Reading:
        result = read(folder / file)
        return Reading(facts=facts(result), said=describe_checksum(result))

    return _reading(work)


def _read_steps(solve: Callable[..., Any], folder: Path, file: str) -> Reading:
    solved: list[object] = []

    def record_step(at: Progress) -> None:
        if not at.kept:
            solved.append(at)

    def work() -> Reading:
        result = solve(folder / "kept", record_step)
        return Reading(facts=facts(result), again=bool(solved), said=describe_checksum(result))

    return _reading(work)


def _read_project(whole: dict[str, bytes], folder: Path, file: str) -> Reading:
    """Look which contacts are treated as solved; a damaged file of one must not."""

    def work() -> Reading:
        found: dict[str, str] = {}
        again = False
        for entry in project.read_project("project.toml"):
            result = plan.find_complete(entry, plan.request_digest(entry))
            if result is None:
                again = True
                continue
            found |= facts(result, entry.name)
            for path in result["written"]:
                same = Path(path).read_bytes() == whole[Path(path).as_posix()]
                found[f"{entry.name}.{path}"] = (
                    "whole" if same else "damaged, but treated as solved"
                )
        return Reading(facts=found, again=again)

    return _reading(work)


def _read_project_file(folder: Path, file: str) -> Reading:
    def work() -> Reading:
        entries = project.read_project("project.toml")
        return Reading(facts={e.name: repr(sorted(e.request.specified.items())) for e in entries})

    return _reading(work)


def describe_checksum(result: Any) -> str:
    """Return the message of a result about its file, if its checksum could not be proved."""
    return "unsealed" if getattr(result, "without_checksums", False) else ""


def facts(value: Any, name: str = "") -> dict[str, str]:
    """Return every number, text and array of a value by name, each to its last bit."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts: Any = ((f.name, getattr(value, f.name)) for f in dataclasses.fields(value))
    elif isinstance(value, dict):
        parts = value.items()
    elif isinstance(value, list | tuple):
        parts = enumerate(value)
    elif isinstance(value, np.ndarray):
        content = hashlib.sha1(np.ascontiguousarray(value).tobytes()).hexdigest()
        return {name: f"{value.dtype.str} {value.shape} {content}"}
    else:
        return {name: value.hex() if isinstance(value, float) else repr(value)}
    return {
        key: text for part, held in parts for key, text in facts(held, f"{name}.{part}").items()
    }


@functools.cache
def _originals() -> dict[str, Reading]:
    return {}


def original(target: Target) -> Reading:
    """Return the reading of the undamaged files, which must be right."""
    known = _originals()
    if target.name not in known:
        place = Path.cwd()
        with tempfile.TemporaryDirectory() as folder:
            for name, content in target.files.items():
                path = Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
            os.chdir(folder)
            try:
                found = target.read(Path(folder), target.damaged[0])
            finally:
                os.chdir(place)
        if found.refused or found.raised or found.again:
            raise RuntimeError(f"{target.name} is not read where it is sound: {found}")
        known[target.name] = found
        if target.sample is not None:
            assert found.plain is not None
            wrong = differing(found.plain, target.sample.stated(target.sample.content))
            if wrong:
                raise RuntimeError(f"{target.name} is read wrongly: {wrong}")
    return known[target.name]
