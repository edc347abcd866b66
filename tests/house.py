"""The house as its own imports tell it: wings, rooms, and who imports whom.

`test_layers` holds the order, and the documentation draws it.
"""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

TESTS = Path(__file__).parent
PACKAGE = TESTS.parent / "src" / "roughcontact"

# From the ground up; what stands beside the wings is a module of its own.
WINGS = (
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
    "analyses.law",
    "analyses.reading",
    "analyses.tasks",
    "batch",
    "desk",
    "face",
    "plots",
    "measure",
    "mpi",
    "results",
    "cli",
    "__init__",
    "__main__",
)


@cache
def rooms() -> dict[str, Path]:
    """Return the modules of the package by dotted name, without the package's own."""
    return {
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
        for path in sorted(PACKAGE.rglob("*.py"))
    }


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def tree(room: str) -> ast.Module:
    return parsed(rooms()[room])


@cache
def all_nodes(tree: ast.Module) -> tuple[ast.AST, ...]:
    """Return the nodes of a module, walked once for all rules."""
    return tuple(ast.walk(tree))


# A place that is imported when it is used.
TEXT_REFERENCE = re.compile(r"(?:roughcontact\.)?([a-z_]+(?:\.[a-z_]+)*):\w+")


@cache
def imports(path: Path) -> tuple[str, ...]:
    """Return the rooms that a module imports: also deferred, for types only, and as text."""
    known, found = rooms(), []
    for node in all_nodes(parsed(path)):
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
            room = name if name in known else f"{name}.__init__"
            if room in known:
                found.append(room)
    return tuple(found)


def wing_of(room: str) -> str:
    parts = room.split(".")
    return ".".join(parts[: 1 + (parts[0] == "analyses")])


def floor_of(room: str) -> int:
    wing = wing_of(room)
    assert wing in WINGS, f"{wing} has no place in the house: add it to WINGS"
    return WINGS.index(wing)
