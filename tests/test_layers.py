"""Imports point only to rows above: the order of the modules is the architecture."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "roughcontact"

ROWS = [
    {"_version", "errors", "units"},
    {
        "kernels", "influence", "convolution", "projection", "preconditioner", "solver", "tilt",
        "invariants", "stress", "halfspace", "plasticity", "acceleration", "preparation",
        "filling", "filters", "alignment", "roughness", "resolution", "spots", "hertz", "analytic",
        "generate", "hardness",
    },
    {"material", "catalogue", "surface", "bodies", "result"},
    {
        "contact", "loading", "history", "study", "subsurface", "increments", "elastoplastic",
        "comparison", "formats", "netcdf", "archive", "export", "checkpoint", "sections",
    },
    {"drawing", "plots", "volume_plots", "assumptions", "script"},
    {"chapters", "report", "volume_report"},
    {"job", "project"},
    {"console", "cli", "__init__", "__main__"},
]  # fmt: skip

# Methods of the public face that only pass `self` on, inside the function.
FACADE = {
    ("result", "export"),
    ("result", "contact"),
    ("surface", "export"),
    ("result", "report"),
    ("result", "chapters"),
    ("elastoplastic", "volume_report"),
}


def row_of(module: str) -> int:
    for number, row in enumerate(ROWS):
        if module in row:
            return number
    raise AssertionError(f"{module} has no place in the house: add it to a row")


def imports(path: Path) -> list[tuple[str, bool]]:
    """Return (module, deferred) for every import of the package's own modules."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    top = {id(node) for node in tree.body}
    checking = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    found = []
    for node in ast.walk(tree):
        if id(node) in checking:
            continue
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("roughcontact"):
            parts = (node.module or "").split(".")
            names = parts[1:2] or [alias.name for alias in node.names]
            found += [(name, id(node) not in top) for name in names]
        elif isinstance(node, ast.Import):
            found += [
                (alias.name.split(".")[1], id(node) not in top)
                for alias in node.names
                if alias.name.startswith("roughcontact.")
            ]
    return found


@pytest.mark.parametrize("path", sorted(PACKAGE.glob("*.py")), ids=lambda path: path.stem)
def test_imports_point_upwards(path: Path) -> None:
    own = row_of(path.stem)
    for module, deferred in imports(path):
        if module.startswith("__") and path.stem != "__main__":
            continue
        if deferred and (path.stem, module) in FACADE:
            continue
        assert row_of(module) <= own, f"{path.stem} imports {module} from a row below"


def test_no_circles() -> None:
    graph = {
        path.stem: {module for module, deferred in imports(path) if not deferred}
        for path in PACKAGE.glob("*.py")
    }
    done: set[str] = set()
    while len(done) < len(graph):
        ready = {name for name in graph if name not in done and graph[name] & graph.keys() <= done}
        assert ready, f"circle among {sorted(graph.keys() - done)}"
        done |= ready


def test_only_units_knows_pint() -> None:
    users = {
        path.stem for path in PACKAGE.glob("*.py") if "pint" in {
            name.split(".")[0]
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            for name in (
                [alias.name for alias in node.names] if isinstance(node, ast.Import)
                else [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            )
        }
    }  # fmt: skip
    assert users == {"units"}
