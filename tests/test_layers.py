"""The order of the wings is the architecture: a wing imports only wings below it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "roughcontact"

# From the ground up; what stands beside the wings is a module of its own.
WINGS = (
    "_version", "errors", "units", "files", "memory", "netcdf",
    "material", "theory", "halfspace", "solvers", "surface", "contact", "volume",
    "formats", "plots", "report", "request", "fleet", "cli",
    "__init__", "__main__",
)  # fmt: skip

# One-line methods of the public face that pass `self` on to a wing above, inside the function.
DELEGATIONS: dict[str, set[str]] = {}


def rooms() -> dict[str, Path]:
    """Return the modules of the package by dotted name, without the package's own."""
    return {
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
        for path in sorted(PACKAGE.rglob("*.py"))
    }


def imports(path: Path) -> Iterator[tuple[str, bool]]:
    """Yield (room, deferred) for every import of the package's own modules, type-only ones too."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    inside = {
        id(node)
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
    }
    known = rooms()
    for node in ast.walk(tree):
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
        for name in names:
            room = name if name in known else f"{name}.__init__"
            if room in known:
                yield room, id(node) in inside


def wing_of(room: str) -> str:
    return room.split(".")[0]


def floor_of(room: str) -> int:
    wing = wing_of(room)
    assert wing in WINGS, f"{wing} has no place in the house: add it to WINGS"
    return WINGS.index(wing)


def allowed(room: str, other: str, deferred: bool) -> bool:
    return deferred and other in DELEGATIONS.get(room, set())


@pytest.mark.parametrize("room", sorted(rooms()))
def test_a_wing_imports_only_wings_below(room: str) -> None:
    for other, deferred in imports(rooms()[room]):
        if other == "_version" or allowed(room, other, deferred):
            continue
        assert floor_of(other) <= floor_of(room), f"{room} imports {other} from a wing above"


def test_no_circles_inside_a_wing() -> None:
    graph = {
        room: {
            other
            for other, deferred in imports(path)
            if wing_of(other) == wing_of(room) and not allowed(room, other, deferred)
        }
        for room, path in rooms().items()
    }
    done: set[str] = set()
    while len(done) < len(graph):
        ready = {name for name in graph if name not in done and graph[name] <= done}
        assert ready, f"circle among {sorted(graph.keys() - done)}"
        done |= ready
