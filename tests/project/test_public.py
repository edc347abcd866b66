import ast
import inspect
import re
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from paths import ROOT

README = ROOT / "README.md"
SOURCE = Path(rc.__file__).parents[1]
# Seconds each, or not needed by those who only solve.
LATE = (
    "matplotlib",
    "pint",
    "xarray",
    "h5netcdf",
    "SurfaceTopography",
    "scipy.sparse",
    "click",
    "ast",
    "rich",
    "jinja2",
    "roughcontact.cli.app",
    "roughcontact.drawing.maps",
    "roughcontact.analyses.solve.report",
)


def run_code(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": str(SOURCE)},
    )


def test_import_loads_no_heavy_libraries() -> None:
    code = "import sys, roughcontact; print('\\n'.join(sys.modules))"
    run = run_code(code)
    assert run.stderr == ""
    loaded = set(run.stdout.split())
    assert "roughcontact" in loaded
    assert loaded.isdisjoint(LATE)


def test_public_name_imports_its_module_only() -> None:
    code = (
        "import sys, roughcontact; first = set(sys.modules); roughcontact.solve; "
        "print('roughcontact.contact.solve' in first); "
        "print('roughcontact.contact.solve' in sys.modules); "
        "print('roughcontact.elastoplastic' in sys.modules)"
    )
    run = run_code(code)
    assert run.stdout.split() == ["False", "True", "False"]


def test_all_names_everything_that_is_imported() -> None:
    tree = ast.parse(Path(rc.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imported = {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert set(rc.__all__) == imported | {"__version__"}
    assert all(hasattr(rc, name) for name in rc.__all__)


def test_all_holds_every_public_object() -> None:
    # Nothing public hides behind the modules, which are attributes as well.
    public = {
        name
        for name, value in vars(rc).items()
        if not name.startswith("_") and not isinstance(value, types.ModuleType)
    }
    assert public <= set(rc.__all__)


def test_every_error_is_an_error_of_this_package() -> None:
    errors = [getattr(rc, name) for name in rc.__all__ if name.endswith("Error")]
    assert len(errors) == 6
    assert all(issubclass(error, rc.RoughcontactError) for error in errors)


def callables() -> dict[str, object]:
    """Return all that is public and called, the methods of classes included."""
    found: dict[str, object] = {}
    offered = {name: getattr(rc, name) for name in rc.__all__}
    for name, value in {**offered, **vars(rc.results)}.items():
        if not callable(value) or name.startswith("_"):
            continue
        found[name] = value
        if isinstance(value, type):
            for member, function in vars(value).items():
                if not member.startswith("_") and isinstance(
                    function, types.FunctionType | classmethod | staticmethod | property
                ):
                    found[f"{name}.{member}"] = function
    return found


def test_everything_public_is_documented() -> None:
    values = {name: inspect.getdoc(value) or "" for name, value in callables().items()}
    assert [name for name, words in values.items() if not words] == []
    # Methods that `dataclass` writes.
    assert [name for name, words in values.items() if words.startswith(f"{name}(")] == []


def undocumented_parameters(value: Any) -> set[str]:
    """Return the parameters that are missing in the docstring."""
    (section,) = re.findall(
        r"^Parameters\n-+\n(.*?)(?=^\w[^\n]*\n-{3,}|\Z)",
        f"{inspect.getdoc(value)}\n",
        re.MULTILINE | re.DOTALL,
    ) or [""]
    names = {
        word.strip(" *")
        for line in section.replace("\\\n", " ").splitlines()
        if line[:1].strip()
        for word in line.partition(" : ")[0].split(",")
    }
    return set(inspect.signature(value).parameters) - names


def test_every_public_parameter_is_documented() -> None:
    missing = {
        name: undocumented_parameters(value)
        for name, value in callables().items()
        if "." not in name and not (isinstance(value, type) and issubclass(value, Exception))
    }
    assert {name: names for name, names in missing.items() if names} == {}


def example() -> str:
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 1
    return blocks[0]


@pytest.mark.parametrize("holes", [False, True])
def test_the_example_of_the_readme_runs(
    holes: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    heights, pixel = rc.reference_map(64)
    # Tilted, as from an instrument.
    heights = heights + 1e-3 * pixel[1] * np.arange(64)
    if holes:
        heights[20:22, 30] = np.nan
    ground = rc.Surface(heights, pixel).masked()
    # A result holds its map, and is thereby a file that `read_surface` knows.
    rc.solve(ground, material=rc.Material(210e9, 0.3), load=0.1).save("ground.nc")
    names: dict = {}
    exec(example().replace("ground.x3p", "ground.nc"), names)
    result, again = names["result"], names["again"]
    assert result.converged
    assert result.load == 1.0
    assert result.surface.missing == 0
    assert result.regime == "saturated at the surface"
    assert (tmp_path / "out.nc").exists()
    assert again.pressure.tobytes() == result.pressure.tobytes()
    printed = capsys.readouterr().out
    assert printed.startswith(f"{result.contact_fraction} {result.mean_gap} ")
    assert printed.count("\n") == 1
