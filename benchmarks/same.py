"""Whether a change of the code changed any result: some eighty cases, digest by digest.

    python benchmarks/same.py store before        # before the change: before/digests.json
    python benchmarks/same.py compare before      # after it; exit status 1 on any difference
    python benchmarks/same.py compare before --to after   # two stored states
    python benchmarks/same.py store before --only 'cli-*' # some cases

Arrays are compared bit by bit, numbers by every digit, files by what they hold, and reports and
console by their text; wall times, dates, versions and temporary folders are removed first. Bits
depend on processor, FFT and BLAS, so only two states of the code on one machine can be compared.
Everything goes through the public face: the names of ``roughcontact``, the methods of what they
return, and ``python -m roughcontact``. Set ``PYTHONPATH`` to try another checkout.
"""

from __future__ import annotations

import argparse
import difflib
import fnmatch
import functools
import inspect
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
from items import Items, digest, items_of, items_of_file, json_value, normalize_text, value_text

MEASUREMENTS = Path(__file__).parents[2] / "shared" / "measurements"
STEEL = rc.Material(210e9, 0.3, 1e9, name="steel")
ALUMINA = rc.Material(370e9, 0.22, name="alumina", hardness=15e9)
MATERIAL = {"material": STEEL}
SIDE = 1e-4  # of the square maps [m]
PROFILE_STEP = 5e-7  # between the points of the profile [m]
# Older versions count quarter turns here, and turn maps the other way round there.
DEGREES = "angle" in inspect.signature(rc.Surface.rotated).parameters
QUARTER, CLOCKWISE = (90, -1) if DEGREES else (1, 1)


# Maps ---------------------------------------------------------------------------------------------


def rough_surface(
    shape: tuple[int, int] = (64, 64), seed: int = 1, pixel: tuple[float, float] | None = None
) -> rc.Surface:
    """Return a self-affine map of 0.1 mm unless a pixel is given."""
    pixel = pixel or (SIDE / shape[0], SIDE / shape[1])
    heights = rc.self_affine(
        shape,
        pixel,
        rms_height=2e-7,
        rolloff_wavelength=5e-5,
        cutoff_wavelength=max(6e-6, 3 * max(pixel)),
        rng=np.random.default_rng(seed),
    )
    return rc.Surface(heights, pixel)


def surface_with_holes() -> rc.Surface:
    """Return a map with a spike, a round hole and single missing points."""
    heights = np.array(rough_surface(seed=4).heights)
    y, x = np.mgrid[:64, :64]
    heights[(y - 20) ** 2 + (x - 45) ** 2 < 30] = np.nan
    heights[[3, 40, 60], [5, 17, 63]] = np.nan
    heights[50, 12] += 5e-6
    return rc.Surface(heights, (SIDE / 64, SIDE / 64))


def ball(points: int = 64, radius: float = 1e-2) -> rc.Surface:
    """Return a sphere on a map of 0.4 mm."""
    pixel = 4e-4 / points
    x = (np.arange(points) - (points - 1) / 2) * pixel
    return rc.Surface(-(x[:, None] ** 2 + x**2) / (2 * radius), (pixel, pixel))


def trace() -> rc.Surface:
    """Return a rough profile of 0.2 mm."""
    steps = np.random.default_rng(7).standard_normal(410)
    heights = np.convolve(steps, np.ones(11) / 11, "valid")
    return rc.Surface(2e-7 * heights, PROFILE_STEP)


def write_inputs(folder: Path) -> None:
    """Write the maps that the commands read, heights in µm, without the program."""
    maps = {
        "rough.npy": rough_surface().heights,
        "wide.npy": rough_surface((48, 80), 2, (1.5e-6, 1e-6)).heights,
        "other.npy": rough_surface((72, 72), 3).heights,
        "holes.npy": surface_with_holes().heights,
        "small.npy": rough_surface((32, 32), 5).heights,
    }
    for name, heights in maps.items():
        np.save(folder / name, 1e6 * heights)
    np.savetxt(folder / "rough.txt", 1e6 * rough_surface().heights)
    np.savetxt(folder / "rough.csv", 1e6 * rough_surface().heights, delimiter=";")
    (folder / "broken.csv").write_text("1,2,3\n4,five,6\n7,8,9\n", encoding="utf-8")
    (folder / "broken.nc").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(64))
    (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
    (folder / "tasks.toml").write_text(TASKS, encoding="utf-8")
    columns = np.transpose([1e3 * PROFILE_STEP * np.arange(400), 1e6 * trace().heights[0]])
    np.savetxt(
        folder / "trace.txt",
        columns,
        fmt="%.9f",
        header="X [mm]\tZ [um]",
        delimiter="\t",
        comments="",
    )
    bad = PROJECT.replace("poisson = 0.3", "poison = 0.3")
    (folder / "bad.toml").write_text(bad, encoding="utf-8")


PROJECT = """\
folder = "results"
write = ["nc", "csv", "vti"]
materials.steel = {young = "210 GPa", poisson = 0.3, yield-strength = "1 GPa"}
defaults = {unit = "um", size = "0.1 mm", material = "steel"}
contact = [
  {name = "one", file = "rough.npy", load = ["0.1 N", "0.5 N"]},
  {name = "two", file = "other.npy", load = "0.2 N", ceiling = "none"},
  {name = "three", file = "holes.npy", load = "0.2 N"},
]
"""

TASKS = """\
folder = "results"
write = ["nc", "csv"]
materials.steel = {young = "210 GPa", poisson = 0.3, yield-strength = "1 GPa"}
defaults = {unit = "um", size = "0.1 mm", material = "steel"}

[[contact]]
name = "curve"
file = "small.npy"
task = "sweep"
from = "0.1 N"
to = "0.3 N"
steps = 2

[[contact]]
name = "below"
file = "small.npy"
task = "stress"
load = "0.2 N"

[[contact]]
name = "path"
file = "small.npy"
task = "history"
path = "0.3 N, 0 N"

[[contact]]
name = "asked"
file = "small.npy"
task = "find"
contact-fraction = "5 %"

[[contact]]
name = "joint"
file = "small.npy"
task = ["law", "conductance", "leak"]
boundary = "periodic"
material = "42CrMo4"
counter-material = "6061-T6"
from = "10 MPa"
to = "50 MPa"
steps = 3
"""

# Cases in Python ----------------------------------------------------------------------------------

Case = Callable[[Path], dict[str, Any]]
CASES: dict[str, Case] = {}


def case(function: Case) -> Case:
    """Take a function as a case: it is given a folder and returns its results by name."""
    CASES["py-" + function.__name__.replace("_", "-")] = function
    return function


@case
def reading(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, surface in (
        ("wide", rough_surface((48, 80), 2, (1.5e-6, 1e-6))),
        ("holes", surface_with_holes()),
    ):
        for suffix in ("csv", "npz", "x3p", "sur", "nc", "vti"):
            path = folder / f"{name}.{suffix}"
            surface.save(path)
            if suffix != "vti":
                found[f"{name}-{suffix}"] = rc.read_surface(path)
    options: dict[str, Any] = {"unit": "um", "size": (SIDE, 2 * SIDE)}
    micrometres = 1e6 * surface_with_holes().heights
    np.save(folder / "bare.npy", micrometres)
    np.savez(folder / "bare.npz", heights=micrometres)
    np.savetxt(folder / "bare.txt", micrometres)
    np.savetxt(folder / "bare.asc", micrometres, delimiter="\t")
    np.savetxt(folder / "bare.csv", micrometres, delimiter=",")
    for suffix in ("npy", "npz", "txt", "asc", "csv"):
        found[f"bare-{suffix}"] = rc.read_surface(folder / f"bare.{suffix}", **options)
    for path in folder.glob("bare.*"):
        path.unlink()
    return found


@case
def measurements(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for path in sorted(MEASUREMENTS.glob("*.*")):
        if path.suffix == ".md":
            continue
        try:
            surface = rc.read_surface(path).cropped((10, 106), (20, 116))
        except rc.RoughcontactError as error:
            found[path.name] = f"{type(error).__name__}: {error}".replace(str(MEASUREMENTS), "")
            continue
        part = surface.leveled("plane").filled()
        area = part.heights.size * part.pixel[0] * part.pixel[1]
        found[path.name] = surface
        found[f"{path.name}-contact"] = rc.solve(part, material=STEEL, load=1e7 * area)
    return found


@case
def preparation(folder: Path) -> dict[str, Any]:
    whole, gaps = rough_surface((64, 80), 6), surface_with_holes()
    found = {
        f"level-{form}": whole.leveled(form) for form in ("plane", "quadric", "mean", "robust")
    }
    found["level-points"] = whole.leveled("three-point", points=[(0, 0), (60, 3), (5, 70)])
    found |= {f"form-{shape}": whole.without_form(shape) for shape in ("sphere", "cylinder")}
    found["form-polynomial"] = whole.without_form("polynomial", 4)
    found["outliers"] = gaps.without_outliers(6.0)
    found["filled"] = gaps.leveled("robust").without_outliers(5.0, 7).filled()
    found["masked"] = gaps.leveled().masked()
    found["rectangle"] = gaps.largest_rectangle()
    found["cropped"] = whole.cropped((4, 60), (3, 55))
    found["rotated"] = whole.rotated(QUARTER).rotated(2 * QUARTER)
    found["with-form"] = rough_surface().with_form(
        rc.Surface(ball().heights, rough_surface().pixel)
    )
    for method in ("bandlimited", "spline"):
        found[f"resampled-{method}"] = whole.resampled((48, 90), method=method)
    found["resampled-pixel"] = whole.resampled(pixel=(2e-6, 2e-6))
    found["s-filter"] = whole.filtered(s=5e-6)
    found["l-filter"] = whole.filtered(l=4e-5)
    found["both-filters"] = gaps.filled().filtered(s=5e-6, l=4e-5)
    motion = ((3e-6, -5e-6), 2.0 * CLOCKWISE)
    found["aligned"] = rough_surface((72, 72), 3).aligned(rough_surface(), *motion, mirrored=True)
    found["roughness"] = [whole.roughness(), gaps.filled().roughness()]
    found["notes"] = [whole.resolution_notes(), whole.resolution_notes(1e-5)]
    return found


WIDE = rough_surface((48, 80), 2, (1.5e-6, 1e-6))
SOLVED: dict[str, tuple[rc.Surface, dict[str, Any]]] = {
    "elastic": (rough_surface((96, 96)), {"load": 0.3, "ceiling": None}),
    "large": (rough_surface((128, 128)), {"load": 0.2}),
    "wide": (WIDE, {"load": 0.2}),
    "odd": (rough_surface((51, 77), 8), {"load": 0.2}),
    "ball": (ball(), {"load": 20.0}),
    "ceiling-auto": (rough_surface(), {"load": 0.5}),
    "ceiling-scalar": (rough_surface(), {"load": 0.5, "ceiling": 2.5e9}),
    "ceiling-map": (
        rough_surface(),
        {"load": 0.5, "ceiling": np.linspace(2e9, 4e9, 4096).reshape(64, 64)},
    ),
    "ceiling-hardness": (rough_surface(), {"load": 2.0, "material": ALUMINA}),
    "approach": (rough_surface(), {"approach": 3e-7}),
    "tilt": (rough_surface(), {"load": 0.2, "moments": (2e-7, -1e-6)}),
    "tilt-elastic": (WIDE, {"load": 0.2, "moments": (2e-7, -1e-6), "ceiling": None}),
    "periodic": (WIDE, {"load": 0.2, "boundary": "periodic"}),
    "single": (rough_surface(), {"load": 0.2, "precision": "single"}),
    "masked": (surface_with_holes().masked(), {"load": 0.2}),
    "two-bodies": (
        rough_surface(),
        {"load": 0.2, "counter_surface": rough_surface(seed=9), "counter_material": ALUMINA},
    ),
    "tolerance": (rough_surface(), {"load": 0.2, "tolerance": 1e-10}),
    "unfinished": (rough_surface(), {"load": 0.2, "max_iterations": 2, "on_failure": "return"}),
}


def run_solve(surface: rc.Surface, options: dict[str, Any], folder: Path) -> dict[str, Any]:
    return {"": rc.solve(surface, **MATERIAL | options)}


CASES |= {f"py-solve-{name}": functools.partial(run_solve, *SOLVED[name]) for name in SOLVED}


@case
def run_with_progress(folder: Path) -> dict[str, Any]:
    steps: list[Any] = []
    found = rc.solve(
        rough_surface(),
        material=STEEL,
        load=0.2,
        progress=lambda at: steps.append(getattr(at, "step", at)),
    )
    warm = rc.solve(rough_surface(), material=STEEL, load=0.25, initial_guess=found)
    from_array = rc.solve(rough_surface(), material=STEEL, load=0.25, initial_guess=found.pressure)
    words = {"steps": steps, "spots": found.spots(), "stiffness": found.stiffness()}
    return {"warm": warm, "warm-array": from_array, "elastic": found.elastic(), **words}


@case
def results(folder: Path) -> dict[str, Any]:
    found = rc.solve(
        surface_with_holes().masked(), material=STEEL, load=0.2, counter_material=ALUMINA
    )
    found.save(folder / "first.nc")
    for suffix in ("nc", "vti", "csv", "json"):
        found.save(folder / f"second.{suffix}")
    found.report(folder / "report.html", command="the command")
    return {"loaded": rc.read_result(folder / "first.nc")}


@case
def curve(folder: Path) -> dict[str, Any]:
    loads = [0.02, 0.1, 0.5]
    kept_in = folder / "steps"
    first = rc.sweep(rough_surface(), material=STEEL, loads=loads[:2], folder=kept_in)
    try:
        longer: Any = rc.sweep(rough_surface(), material=STEEL, loads=loads, folder=kept_in)
    except rc.RoughcontactError as error:
        longer = f"{type(error).__name__}: {error}"
    again = rc.sweep(rough_surface(), material=STEEL, loads=loads[:2], folder=kept_in)
    found = rc.sweep(rough_surface(), material=STEEL, loads=loads, ceiling=None)
    found.save(folder / "curve.csv")
    found.save(folder / "curve.json")
    by_approach = rc.sweep(rough_surface(), material=STEEL, approaches=[1e-7, 2e-7, 3e-7])
    return {"": found, "first": first, "longer": longer, "again": again, "approach": by_approach}


@case
def history(folder: Path) -> dict[str, Any]:
    dx = rough_surface().pixel[1]
    path = [0.5, 0.1, 0.0, rc.Stage(load=0.5, shift=(0.0, 2 * dx)), rc.Stage(approach=2e-7)]
    found = rc.history(rough_surface(), path, material=STEEL)
    found.save(folder / "history.csv")
    found.residual.save(folder / "residual.x3p")
    return {"": found, "elastic": rc.history(rough_surface(), [0.2, 0.0], material=ALUMINA)}


@case
def stress(folder: Path) -> dict[str, Any]:
    contact = rc.solve(ball(), material=STEEL, load=10.0, ceiling=None)
    found = rc.subsurface_stress(contact)
    found.save(folder / "stress.nc")
    sliding = rc.subsurface_stress(
        contact, [1e-5, 3e-5], friction=0.2, direction=0.5, precision="double"
    )
    onset = rc.first_yield_load(ball(48), material=STEEL, friction=0.1)
    sections = [found.von_mises_section("x"), sliding.von_mises_section("y")]
    return {"": found, "sliding": sliding, "onset": onset, "sections": sections}


@case
def volume(folder: Path) -> dict[str, Any]:
    options: dict[str, Any] = {"material": STEEL, "increments": 3, "tolerance": 1e-3}
    found = rc.solve_elastoplastic(ball(32), load=80.0, **options)
    for suffix in ("nc", "vtr", "vti", "csv", "json"):
        found.save(folder / f"volume.{suffix}")
    found.report(folder / "volume.html")
    path = rc.solve_elastoplastic(
        rough_surface((32, 32), 5), loads=[0.1, 0.3, 0.0], boundary="periodic", **options
    )
    return {
        "": found,
        "path": path,
        "profile": found.profile(),
        "layers": found.layers(),
        "section": found.section("y"),
    }


@case
def studies(folder: Path) -> dict[str, Any]:
    found = rc.compare_models(ball(32), material=STEEL, loads=[30.0, 60.0], factors=[2.8, 3.0])
    found.save(folder / "models.json")
    study = rc.resolution_study(rough_surface(), material=STEEL, load=0.2)
    modulus = [rc.contact_modulus(STEEL, rc.RIGID), rc.contact_modulus(STEEL, ALUMINA)]
    return {
        "models": found,
        "errors": found.map_error(),
        "study": study,
        "modulus": modulus,
        "reference": rc.reference_map(96),
    }


def solve_contacts(
    surface: rc.Surface | None = None, pressures: tuple[float, ...] = (1e7, 5e7), **options: Any
) -> list[rc.ContactResult]:
    """Return contacts of a small endless map under several nominal pressures."""
    surface = surface or rough_surface((32, 32), 5)
    options |= {"material": STEEL, "boundary": "periodic"}
    return [rc.solve(surface, load=pressure * SIDE**2, **options) for pressure in pressures]


@case
def leakage(folder: Path) -> dict[str, Any]:
    contacts = solve_contacts()
    found = rc.leakage(contacts, viscosity=1e-3, pressure_difference=1e5)
    for suffix in ("csv", "json"):
        found.save(folder / f"leak.{suffix}")
    return {
        "": found,
        "ring": rc.leakage(
            contacts[0],
            flow_axis="y",
            viscosity=1e-3,
            pressure_difference=1e5,
            seal_width=0.1,
            seal_length=1e-3,
        ),
    }


@case
def conductance(folder: Path) -> dict[str, Any]:
    contacts = solve_contacts()
    found = rc.conductance(contacts, "42CrMo4", "6061-T6", electrical_film=1e-12, thermal_film=1e-7)
    for suffix in ("csv", "json"):
        found.save(folder / f"conductance.{suffix}")
    return {"": found, "bare": rc.conductance(contacts[0], "42CrMo4", "6061-T6")}


@case
def law(folder: Path) -> dict[str, Any]:
    loading = solve_contacts(pressures=(1e7, 3e7, 9e7))
    unloading = solve_contacts(rc.indented_surface(loading[-1]), (1e7, 3e7), ceiling=None)
    found = rc.interface_law(loading, unloading, conductor="42CrMo4", counter_conductor="6061-T6")
    for suffix in ("npz", "csv", "json", "inp", "ccx", "txt"):
        found.save(folder / f"law.{suffix}")
    maps = (rough_surface((32, 32), seed) for seed in (5, 6))
    several = [contact for surface in maps for contact in solve_contacts(surface)]
    return {"": found, "of-two-maps": rc.interface_law(several)}


@case
def find_load(folder: Path) -> dict[str, Any]:
    found = rc.find_load(
        rough_surface((32, 32), 5),
        material=STEEL,
        contact_fraction=[0.02, 0.05],
        saturated_fraction=0.3,
        approach=2e-7,
        mean_gap=3e-7,
        first_yield=True,
    )
    for suffix in ("csv", "json"):
        found.save(folder / f"loads.{suffix}")
    return {"": found, "answers": list(found.answers)}


@case
def rolling(folder: Path) -> dict[str, Any]:
    roller = rc.Surface(ball(16, 5e-3).heights, (2.5e-5, 2.5e-5))
    found = rc.roll(
        rc.Surface(np.zeros((16, 16)), roller.pixel),
        counter_surface=roller,
        material=STEEL,
        load=60.0,
        passes=2,
        steps=2,
        boundary="periodic",
        tolerance=1e-3,
        friction=0.1,
        folder=folder / "kept",
    )
    for suffix in ("nc", "csv", "json"):
        found.save(folder / f"rolled.{suffix}")
    return {"": found, "rolled": found.rolled_surface}


@case
def estimate(folder: Path) -> dict[str, Any]:
    options: dict[str, Any] = {"material": STEEL, "pressure": 1e8}
    found = rc.estimate(Sq=5e-7, Sdq=0.1, Sal=1.2e-5, **options)
    found.save(folder / "estimate.json")
    return {"": found, "map": rc.estimate(rough_surface(), **options)}


@case
def generation(folder: Path) -> dict[str, Any]:
    pixel = (2e-6, 2e-6)
    return {
        "ground": rc.generate((48, 32), pixel, Sq=4e-7, Sal=1.2e-5, Str=0.3, lay=30.0, rng=2),
        "honed": rc.generate(128, pixel, Sq=4e-7, Sal=1.2e-5, honing=40.0),
        "plateau": rc.generate(48, pixel, Sq=4e-7, Sal=1.2e-5, Ssk=-0.8),
        "turned": rc.generate(48, pixel, Sq=4e-7, rolloff_wavelength=4e-5, turning=(2.4e-5, 8e-4)),
    }


@case
def profile(folder: Path) -> dict[str, Any]:
    line = trace().leveled()
    found = rc.solve(line, material=STEEL, load=2e4)
    found.save(folder / "line.nc")
    found.report(folder / "line.html")
    line.save(folder / "line.csv")
    curve = rc.sweep(line, material=STEEL, loads=[5e3, 2e4])
    return {
        "": found,
        "line": line,
        "read": rc.read_surface(folder / "line.csv"),
        "curve": curve,
        "parameters": line.roughness(),
        "stress": rc.subsurface_stress(found, [1e-6, 5e-6]),
        "filtered": line.filtered(l=8e-5),
    }


@case
def comparison(folder: Path) -> dict[str, Any]:
    maps = {
        "one": [rough_surface((32, 32), n) for n in (1, 2)],
        "two": [rough_surface((32, 32), n) for n in (3, 4)],
    }
    found = rc.compare(maps, material=STEEL, pressure=5e7, steps=2)
    found.save(folder / "comparison.json")
    return {"": found, "sampling": rc.sampling_study(rough_surface(), material=STEEL, pressure=5e7)}


REFUSED: dict[str, dict[str, Any]] = {  # options of `solve`
    "load": {"load": -1.0},
    "both": {"approach": 1e-7},
    "neither": {"load": None},
    "boundary": {"boundary": "closed"},
    "precision": {"precision": "half"},
    "ceiling": {"ceiling": np.ones((3, 3))},
    "ceiling-word": {"ceiling": "high"},
    "capacity": {"load": 1e4},
    "convergence": {"max_iterations": 2},
    "rigid": {"material": rc.RIGID},
    "grids": {"counter_surface": ball(32)},
    "start": {"start": np.ones(3)},
    "moments": {"moments": (1.0, 1.0)},
}
FAILURES: dict[str, Callable[[], Any]] = {
    "poisson": lambda: rc.Material(210e9, 0.7),
    "young": lambda: rc.Material(-1.0, 0.3),
    "young-text": lambda: rc.Material("210 GPa", 0.3),  # type: ignore[arg-type]
    "yield-strength": lambda: rc.Material(210e9, 0.3, 0.0),
    "heights": lambda: rc.Surface([1.0, 2.0], (1.0, 1.0)),
    "pixel": lambda: rc.Surface(np.zeros((4, 4)), (1.0, -1.0)),
    "infinite": lambda: rc.Surface(np.full((4, 4), np.inf), (1.0, 1.0)),
    "holes": lambda: rc.solve(surface_with_holes(), material=STEEL, load=0.1),
    "missing-file": lambda: rc.read_surface("nowhere.csv"),
    "form": lambda: rough_surface().without_form("torus"),
    "level": lambda: rough_surface().leveled("wave"),
    "crop": lambda: rough_surface().cropped((0, 900), (0, 4)),
    "filter": lambda: rough_surface().filtered(s=1.0),
    "save": lambda: rough_surface().save("map.docx"),
    "loads": lambda: rc.sweep(rough_surface(), material=STEEL, loads=[]),
    "stage": lambda: rc.Stage(load=1.0, approach=1.0),
    "volume": lambda: rc.solve_elastoplastic(rough_surface(), material=ALUMINA, load=1.0),
    "stress": lambda: rc.subsurface_stress(
        rc.solve(rough_surface(), material=STEEL, load=0.1), [-1.0]
    ),
}


@case
def errors(folder: Path) -> dict[str, Any]:
    calls = dict(FAILURES)
    for name, options in REFUSED.items():
        all_options = {"material": STEEL, "load": 0.1} | options
        calls[f"solve-{name}"] = functools.partial(rc.solve, rough_surface(), **all_options)
    found = {}
    for name, call in calls.items():
        try:
            found[name] = f"no error: {json_value(call())}"
        except Exception as error:
            found[name] = f"{type(error).__name__}: {error}"
    return found


# Cases on the command line ------------------------------------------------------------------------

_MAP = "--unit um --size '0.1 mm'"
_STEEL = "--young '210 GPa' --poisson 0.3 --yield-strength '1 GPa'"
_ON = f"rough.npy {_MAP} {_STEEL}"
_SOLVE, _HALF = f"solve {_ON} --load '0.2 N'", f"solve {_ON} --load '0.5 N'"
_HOLES = _SOLVE.replace("rough.npy", "holes.npy")
_WIDE = f"solve wide.npy --unit um --size '72 um x 80 um' {_STEEL}"
_BALL = "--points 48 --size '0.4 mm' --material 100Cr6"
_SPHERE = f"{_BALL} --body 'sphere 10 mm'"
_PERFECT = "--model elastoplastic --set increments=2 --set tolerance=1e-3"
_VOLUME = f"solve {_SPHERE.replace('48', '32')} --load '80 N' {_PERFECT}"
_SWEEP = f"sweep {_ON} --from '20 mN' --to '1 N' --steps 4 --folder kept"
_FORMS = (
    "sphere 10 mm",
    "cylinder 5 mm 90 deg",
    "ellipsoid 10 mm 4 mm",
    "punch 20 um",
    "cone 0.01",
    "wedge 0.01",
)

_JOINT = f"small.npy {_MAP} --material 42CrMo4 --boundary periodic"
_LOADS = "--load '0.1 N, 0.3 N'"
_SLIP = f"{_ON} --load '0.2 N' --friction 0.2"
_LEAK = f"leak {_JOINT} {_LOADS} --viscosity '1 mPa s' --pressure-difference '1 bar'"
_CONDUCTANCE = f"conductance {_JOINT} {_LOADS} --counter-material 6061-T6"
_LAW = f"law {_JOINT} --from '10 MPa' --to '90 MPa' --steps 3 --counter-material 6061-T6"
_FIND = (
    f"find small.npy {_MAP} {_STEEL} --contact-fraction '2 %, 5 %' --saturated-fraction '30 %' "
    "--first-yield"
)
_ROLL = (
    "roll --points 16 --size '0.4 mm' --body flat --material 100Cr6 --counter-body "
    "'sphere 5 mm' --load '60 N' --boundary periodic --passes 2 --steps 2 --set tolerance=1e-3"
)
_ESTIMATE = "estimate --sq '0.5 um' --sdq 0.1 --sal '12 um' --pressure '100 MPa' --material 100Cr6"
_GENERATE = "generate --size '0.1 mm' --points 48 --sq '0.4 um' --sal '12 um'"
_PROFILE = f"solve trace.txt {_STEEL} --load '20 N/mm'"

COMMANDS: dict[str, tuple[str, ...]] = {
    "plain": (_SOLVE, f"{_SOLVE} --json", f"{_SOLVE} --quiet"),
    "exports": (
        f"{_SOLVE} --output a.nc --output a.vti --output a.csv --output a.json --report a.html",
        "info a.nc",
    ),
    "figures": (
        f"{_SOLVE} --figures out.png",
        f"{_WIDE} --load '0.2 N' --figures out.svg",
        f"{_SOLVE} --figures out.pdf",
    ),
    "prepared": (
        f"{_HOLES} --crop 2:62,0:60 --outliers 6 --level robust --form 'polynomial 3' "
        "--missing fill --s-filter '4 um' --l-filter '60 um' --pixel '1.2 um' --set rotate=90 "
        "--set tip-radius='2 um' --report a.html",
    ),
    "holes": (f"{_HOLES} --missing mask --output a.nc", f"{_HOLES} --missing crop", _HOLES),
    "ceilings": (
        f"{_HALF} --ceiling none",
        f"{_HALF} --ceiling '2 GPa'",
        f"{_HALF} --ceiling '62 HRC'",
        f"{_HALF} --hardening 'linear 2 GPa'",
    ),
    "approach": (f"{_WIDE} --approach '0.3 um' --boundary periodic --set precision=single",),
    "materials": ("materials", "materials 100Cr6", "materials --json", "materials 'bearing steel'"),
    "catalogue": (
        f"solve rough.npy {_MAP} --load '0.3 N' --material 100Cr6 "
        "--counter-material alumina --json",
    ),
    "counter": (
        f"{_SOLVE} --counter-surface rough.npy --set counter-young='70 GPa' "
        "--set counter-poisson=0.33 --output a.nc",
    ),
    "aligned": (
        f"{_SOLVE} --counter-surface other.npy --align --set offset='2 um, -3 um' "
        f"--set angle={3 * CLOCKWISE} "
        "--set mirror --output a.nc --report a.html",
    ),
    "bodies": tuple(
        f"solve {_BALL} --body '{form}' --load '2 N' --output {form.split()[0]}.json"
        for form in _FORMS
    ),
    "rough-ball": (f"solve {_ON} --body 'sphere 1 mm' --counter-body 'sphere 5 mm' --load '1 N'",),
    "tilt": (f"{_SOLVE} --set load-point='0 um, 5 um' --output a.nc",),
    "study": (f"{_SOLVE} --study --report a.html",),
    "texts": (_SOLVE.replace(".npy", ".txt"), _SOLVE.replace(".npy", ".csv")),
    "info": (f"info rough.npy {_MAP}", f"info holes.npy {_MAP} --json", "info broken.nc"),
    "sweep": (
        f"{_SWEEP} --output c.csv --report a.html --figure c.png",
        f"{_SWEEP} --output c.json",
        _SWEEP.replace("20 mN", "10 mN"),
    ),
    "sweep-approach": (
        f"sweep {_ON} --from '0.1 um' --to '0.3 um' --steps 3 --spacing linear --json",
    ),
    "history": (
        f"history {_ON} --path '0.5 N, 0 N, 0.5 N' --passes 2 --shift '0 um, 3.125 um' "
        "--output h.csv --indented-surface r.x3p --figure h.png --report a.html",
        f"history {_ON} --path '0.5 N, 0 N' --indented-surface r.sur --output h.json --json",
        f"history {_ON} --path '0.5 N, 0 N' --indented-surface r.npz --quiet",
    ),
    "stress": (
        f"stress {_SPHERE} --load '5 N' --output s.nc --report a.html --figures s.png",
        f"stress {_ON} --load '0.2 N' --friction 0.2 --direction 30 --depths '1 um, 2 um' --json",
    ),
    "stress-onset": (
        f"stress {_SPHERE} --load '5 N' --first-yield",
        f"stress {_SPHERE} --first-yield",
    ),
    "volume": (f"{_VOLUME} --report a.html --output v.nc --output v.vtr --figures v.png",),
    "volume-linear": (
        f"{_VOLUME} --hardening 'linear 20 GPa' --unload --folder kept --json",
        f"{_VOLUME} --hardening 'linear 20 GPa' --unload --folder kept",
    ),
    "volume-swift": (f"{_VOLUME} --hardening 'swift 945 MPa 20 0.121'",),
    "volume-periodic": (
        f"solve small.npy {_MAP} {_STEEL} --load '0.3 N' {_PERFECT} "
        "--boundary periodic --output v.json",
    ),
    "demo": ("demo --points 64 --folder out",),
    "project": ("run project.toml", "run project.toml --json", "run bad.toml"),
    "tasks": ("run tasks.toml", "run tasks.toml --json"),
    "leak": (f"{_LEAK} --report a.html", f"{_LEAK} --output l.json --json"),
    "tangential": (
        f"tangential {_SLIP} --force '20 mN' --report a.html",
        f"tangential {_SLIP} --force '20 mN, 0 N' --json",
    ),
    "conductance": (
        f"{_CONDUCTANCE} --electrical-film '1e-12 ohm m^2' --report a.html",
        f"{_CONDUCTANCE} --output c.json --json",
    ),
    "law": (
        f"{_LAW} --report a.html "
        + " ".join(f"--output l.{kind}" for kind in ("npz", "csv", "json", "inp", "ccx", "txt")),
        f"{_LAW} --quarters --json",
    ),
    "find": (f"{_FIND} --output f.csv --report a.html", f"{_FIND} --output f.json --json"),
    "roll": (f"{_ROLL} --output r.nc --output r.csv --report a.html", f"{_ROLL} --json"),
    "estimate": (
        _ESTIMATE,
        f"{_ESTIMATE} --json",
        f"estimate rough.npy {_MAP} {_STEEL} --pressure '50 MPa' --output e.json",
    ),
    "generate": (f"{_GENERATE} --ssk -0.8 --output g.npz --output g.csv", f"{_GENERATE} --json"),
    "profile": (
        f"{_PROFILE} --output p.nc --report a.html",
        f"{_PROFILE} --json",
        "info trace.txt",
        f"sweep trace.txt {_STEEL} --from '5 N/mm' --to '20 N/mm' --steps 2",
    ),
    "compare": (f"compare small.npy other.npy {_MAP} {_STEEL} --load '50 MPa' --json",),
    "verify": (f"{_SOLVE} --output a.nc", "verify a.nc"),
    "help": (
        "--help",
        "--version",
        *(
            f"{name} --help"
            for name in (
                "solve",
                "sweep",
                "stress",
                "history",
                "roll",
                "find",
                "conductance",
                "leak",
                "law",
                "tangential",
                "compare",
                "estimate",
                "generate",
                "run",
                "verify",
                "info",
                "materials",
                "demo",
            )
        ),
    ),
    "errors-usage": (
        "squeeze",
        f"solve {_ON}",
        f"solve {_ON} --load 1",
        f"{_SOLVE} --lod '1 N'",
        f"solve {_ON} --load '1 Pa'",
        f"solve {_ON} --load '90 N'",
    ),
    "errors-map": (
        "solve nowhere.npy --load '1 N' --material 100Cr6",
        f"{_SOLVE} --crop 0:900,0:9",
        "solve rough.npy --load '1 N' --material 100Cr6",
        "info rough.csv",
        f"solve broken.csv {_MAP} --load '1 N' --material 100Cr6",
    ),
    "errors-bodies": (
        f"solve rough.npy {_MAP} --load '1 N' --material cheese",
        f"{_SOLVE} --body 'torus 3 mm'",
        f"{_SOLVE} --counter-surface other.npy",
        f"{_SOLVE} --poisson 0.8",
        f"{_SOLVE} --set max-iterations=2",
    ),
    "errors-options": (
        f"{_SOLVE} --output a.doc",
        f"history {_ON} --path '1 N, x'",
        f"stress {_ON} --load '1 N' --depths '-1 um'",
    ),
}
ENVIRONMENT = {
    "COLUMNS": "200",
    "LINES": "50",
    "NO_COLOR": "1",
    "TERM": "dumb",
    "LC_ALL": "C.UTF-8",
    "PYTHONIOENCODING": "utf-8",
}
# The commands run the code that was imported here, also where PYTHONPATH is relative or not set.
ENVIRONMENT["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(Path(rc.__file__).parents[1]), os.environ.get("PYTHONPATH")])
)


def run_commands(name: str, folder: Path) -> dict[str, Any]:
    """Run the commands of a case one after the other and return what each printed."""
    found = {}
    for number, command in enumerate(COMMANDS[name], 1):
        done = subprocess.run(
            [sys.executable, "-m", "roughcontact", *shlex.split(command)],
            cwd=folder,
            env=os.environ | ENVIRONMENT,
            capture_output=True,
            encoding="utf-8",
        )
        out = done.stdout
        if "--json" in command and done.returncode == 0:
            out = value_text(json.loads(out))
        found[f"console-{number}"] = (
            f"$ {command}\nexit status {done.returncode}\n{out}\n--- errors\n{done.stderr}"
        )
    return found


# Running, storing and comparing -------------------------------------------------------------------


def collect_items(
    call: Callable[[], dict[str, Any]], folder: Path, inputs: dict[str, bytes]
) -> Items:
    """Return the normalised text of what a case returns and of the files that it writes."""
    found: list[tuple[str, str, str]] = []
    try:
        for key, value in call().items():
            found += [(key, item, text) for item, text in items_of(value).items()]
        for path in sorted(entry for entry in folder.rglob("*") if entry.is_file()):
            name = path.relative_to(folder).as_posix()
            if inputs.get(name) != path.read_bytes():
                found += [(name, item, text) for item, text in items_of_file(path).items()]
    except Exception as error:  # a state of the code that cannot do it is a difference too
        found.append(("failed", "", f"{type(error).__name__}: {error}"))
        print(f"failed: {type(error).__name__}: {error}")
    return {".".join(filter(None, names)): normalize_text(text, folder) for *names, text in found}


def run_all(only: str, place: Path) -> Iterator[tuple[str, Items]]:
    """Run every case whose name matches, the commands two at a time, and give its items.

    HDF5 and Matplotlib do not like threads: the threads only wait for the commands.
    """
    names = [f"cli-{name}" for name in COMMANDS]
    python, shell = (fnmatch.filter(group, only) for group in (CASES, names))
    print(f"{len(python) + len(shell)} cases of roughcontact in {Path(rc.__file__).parent}")
    if not MEASUREMENTS.is_dir() and "py-measurements" in python:
        python.remove("py-measurements")
        print("py-measurements: skipped, the instruments' files are not here")
    for name in python:
        folder = place / name
        folder.mkdir()
        yield name, collect_items(functools.partial(CASES[name], folder), folder, {})
    write_inputs(place)
    inputs = {path.name: path.read_bytes() for path in place.iterdir() if path.is_file()}
    for name in shell:
        (place / name).mkdir()
        for file, content in inputs.items():
            (place / name / file).write_bytes(content)
    with ThreadPoolExecutor(2) as pool:
        printed = pool.map(lambda name: run_commands(name[4:], place / name), shell)
        for name, values in zip(shell, printed, strict=True):
            yield name, collect_items(functools.partial(dict, values), place / name, inputs)


def file_of(folder: Path, name: str, item: str) -> Path:
    """Return where the text of an item is stored."""
    return folder / name / (item.replace("/", "+") + ".txt")


def run_cases(only: str) -> Iterator[tuple[str, Items]]:
    """Run the cases in a separate folder and print the time of each."""
    last = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="same-") as place:
        for name, items in run_all(only, Path(place)):
            now = time.perf_counter()
            print(f"{name}: {len(items)} items after {now - last:.1f} s", flush=True)
            last = now
            yield name, items


def store(folder: Path, cases: Iterable[tuple[str, Items]]) -> None:
    """Write digests and texts of cases."""
    began = time.perf_counter()
    digests = {}
    for name, items in cases:
        for item, text in items.items():
            path = file_of(folder, name, item)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            digests[f"{name}/{item}"] = digest(text.encode())
    content = json.dumps(digests, indent=1, sort_keys=True, ensure_ascii=False)
    (folder / "digests.json").write_text(content, encoding="utf-8")
    print(f"{len(digests)} items in {time.perf_counter() - began:.0f} s")


def differences(old: Path, new: Path, only: str) -> Iterator[str]:
    """Give a paragraph on each item that differs, is missing or is new."""
    states = []
    for folder in (old, new):
        digests = json.loads((folder / "digests.json").read_text(encoding="utf-8"))
        states.append({k: v for k, v in digests.items() if fnmatch.fnmatch(k.split("/")[0], only)})
    for key in sorted(states[0].keys() | states[1].keys()):
        first, second = (state.get(key) for state in states)
        if first == second:
            continue
        if first is None or second is None:
            yield f"{key}: {'new' if first is None else 'missing'}"
            continue
        texts = [file_of(folder, *key.split("/", 1)).read_text("utf-8") for folder in (old, new)]
        lines = difflib.unified_diff(
            *(text.splitlines() for text in texts), "old", "new", n=1, lineterm=""
        )
        yield "\n    ".join([f"{key}: differs", *(line[:160] for line in list(lines)[:20])])


def main() -> int:
    """Store or compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("what", choices=("store", "compare"))
    parser.add_argument("folder", type=Path, help="where digests and texts are kept")
    parser.add_argument("--to", type=Path, help="compare with this folder instead of a new run")
    parser.add_argument("--only", default="*", help="cases to take, such as 'cli-*'")
    options = parser.parse_args()
    if options.what == "store":
        store(options.folder, run_cases(options.only))
        return 0
    with tempfile.TemporaryDirectory() as place:
        if options.to is None:
            store(Path(place), run_cases(options.only))
        found = list(differences(options.folder, options.to or Path(place), options.only))
    print("\n".join([*found, f"{len(found)} differences" if found else "no difference"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
