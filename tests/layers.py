"""Layers and modules of the package, and the imports between them.

`test_layers` checks the order, and the documentation draws it.
"""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

TESTS = Path(__file__).parent
PACKAGE = TESTS.parent / "src" / "roughcontact"

# From the lowest to the highest; modules outside folders are layers by themselves.
LAYERS = (
    "_version",
    "errors",
    "units",
    "_tools",
    "references",
    "cautions",
    "result",
    "material",
    "theory",
    "halfspace",
    "solvers",
    "surface",
    "contact",
    "uncertainty",
    "elastoplastic",
    "formats",
    "drawing",
    "report",
    "request",
    "analyses.__init__",
    "analyses.estimate",
    "analyses.generate",
    "analyses.solve",
    "analyses.sweep",
    "analyses.history",
    "analyses.compare",
    "analyses.stress",
    "analyses.find",
    "analyses.roll",
    "analyses.conductance",
    "analyses.leak",
    "analyses.tangential",
    "analyses.wear",
    "analyses.law",
    "analyses.reading",
    "analyses.tasks",
    "batch",
    "desk",
    "face",
    "plots",
    "measure",
    "results",
    "cli",
    "__init__",
    "__main__",
)


@cache
def module_paths() -> dict[str, Path]:
    """Return the paths of the modules by dotted name without `roughcontact`."""
    return {
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
        for path in sorted(PACKAGE.rglob("*.py"))
    }


@cache
def parse_module(path: Path) -> ast.Module:
    """Return the syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def tree_of(module: str) -> ast.Module:
    """Return the syntax tree of a module."""
    return parse_module(module_paths()[module])


@cache
def all_nodes(tree: ast.Module) -> tuple[ast.AST, ...]:
    """Return the nodes of a module, cached for all rules."""
    return tuple(ast.walk(tree))


# A function given as text, which is imported on first use.
TEXT_REFERENCE = re.compile(r"(?:roughcontact\.)?([a-z_]+(?:\.[a-z_]+)*):\w+")


@cache
def imported_modules(path: Path) -> tuple[str, ...]:
    """Return the modules that a module imports, including deferred, typing and text imports."""
    known, found = module_paths(), []
    for node in all_nodes(parse_module(path)):
        names: list[str] = []
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "roughcontact":
            base = (node.module or "").removeprefix("roughcontact").strip(".")
            for alias in node.names:
                full = f"{base}.{alias.name}" if base else alias.name
                names.append(full if full in known else base or "__init__")
        elif isinstance(node, ast.Import):
            names = [
                alias.name.removeprefix("roughcontact.")
                for alias in node.names
                if alias.name.startswith("roughcontact.")
            ]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            place = TEXT_REFERENCE.fullmatch(node.value)
            names = [place[1]] if place and place[1] in known else []
        for name in names:
            module = name if name in known else f"{name}.__init__"
            if module in known:
                found.append(module)
    return tuple(found)


def layer_of(module: str) -> str:
    """Return the layer of a module."""
    parts = module.split(".")
    return ".".join(parts[: 1 + (parts[0] == "analyses")])


def level_of(module: str) -> int:
    """Return the position of the layer of a module, counted from the lowest."""
    layer = layer_of(module)
    assert layer in LAYERS, f"{layer} is no layer: add it to LAYERS"
    return LAYERS.index(layer)
