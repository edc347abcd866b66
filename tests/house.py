"""The house as its own imports tell it: wings, rooms, and who imports whom.

`test_layers` holds the order, and the documentation draws it.
"""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "src" / "roughcontact"

# From the ground up; what stands beside the wings is a module of its own.
WINGS = (
    "_version", "errors", "arguments", "units", "files", "pipes", "memory", "limits", "checksums",
    "interrupts", "locks", "processes", "hdf5", "ranks", "netcdf", "statistics", "roots",
    "references", "result",
    "material", "theory", "halfspace", "solvers", "surface", "contact", "volume", "joint",
    "formats", "plots", "report", "request", "fleet", "desk", "face", "wiring", "renamed", "cli",
    "__init__", "__main__",
)  # fmt: skip

# One-line methods of the public face that pass `self` on to a wing above, inside the function.
DELEGATIONS: dict[str, set[str]] = {
    "contact.result": {
        "contact.judgment",
        "contact.solve",
        "contact.stiffness",
        "desk.explore",
        "formats.export",
        "joint.estimate",
        "report.contact",
        "report.results",
        "report.sources",
    },
    "contact.compared": {"report.comparison", "report.results", "report.sources"},
    "contact.curve": {"report.results", "report.sources"},
    "contact.found": {"report.results", "report.sources"},
    "contact.history": {"report.results", "report.sources"},
    "contact.sampling": {"report.results", "report.sources"},
    "contact.stress": {"report.results", "report.sources"},
    "contact.study": {"report.results"},
    "joint.estimate": {"report.results", "report.sources"},
    "joint.interface": {"formats.export", "report.results", "report.sources"},
    "material.material": {"material.catalogue"},
    "surface.surface": {"desk.explore", "formats.export"},
    "volume.result": {
        "formats.export",
        "report.results",
        "report.sources",
        "report.volume",
        "volume.depth",
        "volume.judgment",
    },
    "volume.rolling": {"report.results", "report.rolling", "report.sources"},
}


@cache
def rooms() -> dict[str, Path]:
    """Return the modules of the package by dotted name, without the package's own."""
    return {
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
        for path in sorted(PACKAGE.rglob("*.py"))
    }


@cache
def imports(path: Path) -> tuple[tuple[str, bool], ...]:
    """Return (room, deferred) for every import of the package's own modules, type-only ones too."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    inside = {
        id(node)
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
    }
    known, found = rooms(), []
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
                found.append((room, id(node) in inside))
    return tuple(found)


def wing_of(room: str) -> str:
    return room.split(".")[0]


def floor_of(room: str) -> int:
    wing = wing_of(room)
    assert wing in WINGS, f"{wing} has no place in the house: add it to WINGS"
    return WINGS.index(wing)


def delegated(room: str, other: str, deferred: bool) -> bool:
    return deferred and other in DELEGATIONS.get(room, set())
