"""A command loads the modules that it needs and no more."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import roughcontact as rc
from roughcontact.cli import app
from written import HAS_READER

SOURCE = Path(app.__file__).parents[2]

# Modules for reading, drawing and units, which take a tenth of a second to import, or several.
NEVER = (
    "xarray",
    "SurfaceTopography",
    "NuMPI",
    "pandas",
    "h5netcdf",
    "scipy.fft",
    "scipy.ndimage",
    "scipy.special",
    "scipy.optimize",
    "scipy.stats",
    "pint",
    "dask",
    "pydantic",
)
DRAWS = ("matplotlib", "PIL", "jinja2")
TELLS = ("rich",)
SOLVES = (
    "scipy",
    "roughcontact.solvers.bounded",
    "roughcontact.contact.solve",
    "roughcontact.elastoplastic.volume_result",
)


def loaded_modules(*words: str) -> set[str]:
    """Return the modules that a command has loaded at its end, alone or with their package."""
    code = (
        "import sys, roughcontact.__main__ as program; "
        f"sys.argv = {['roughcontact', *words]!r}; status = program.main(); "
        "print(*sys.modules, file=sys.stderr); sys.exit(status)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": str(SOURCE)},
    )
    return set(done.stderr.split())


@pytest.fixture(
    params=[
        ".npz",
        pytest.param(
            ".x3p", marks=pytest.mark.skipif(not HAS_READER, reason="SurfaceTopography is absent")
        ),
    ]
)
def file(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    path = tmp_path / f"map{request.param}"
    rc.Surface(*rc.reference_map(32)).save(path)
    return str(path)


def test_help_loads_no_arrays() -> None:
    found = loaded_modules("--help")
    assert not found & {*NEVER, *DRAWS, *TELLS, *SOLVES, "numpy"}


def test_materials_load_no_solver() -> None:
    assert not loaded_modules("materials", "100Cr6") & {*NEVER, *DRAWS, *SOLVES}


def test_info_loads_no_solver(file: str) -> None:
    assert not loaded_modules("info", file) & {*NEVER, *DRAWS, *SOLVES}
    assert not loaded_modules("info", file, "--json") & {*NEVER, *DRAWS, *SOLVES, *TELLS}


# With yielding, which is judged.
def test_solve_loads_no_drawing_or_report(file: str) -> None:
    found = loaded_modules("solve", file, "--load", "1 N", "--material", "100Cr6", "--json")
    assert not found & {*NEVER, *DRAWS, *TELLS, "scipy.sparse"}
    assert "roughcontact.solvers.bounded" in found


@pytest.mark.process
@pytest.mark.parametrize("file", [".npz"], indirect=True)
def test_report_loads_no_unused_library(file: str, tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    words = ("--load", "1 N", "--material", "100Cr6", "--report", str(report))
    assert not loaded_modules("solve", file, *words) & {*NEVER, "matplotlib.pyplot"}
    assert report.exists()


@pytest.mark.process
@pytest.mark.parametrize("file", [".npz"], indirect=True)
def test_saving_loads_no_xarray(file: str, tmp_path: Path) -> None:
    output = tmp_path / "out.nc"
    words = ("--load", "1 N", "--material", "100Cr6", "--output", str(output))
    assert not loaded_modules("solve", file, *words) & {*NEVER, *DRAWS} - {"h5netcdf"}
    assert output.exists()
