"""Names in docstrings, comments and messages exist: a dotted name is a member of its owner."""

from __future__ import annotations

import ast
import builtins
import keyword
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache

import layers

# Of other libraries and programs, and attributes of files.
EXTERNAL = {
    *("numpy", "np", "scipy", "os", "time", "msvcrt", "pickle", "SurfaceTopography", "h5py"),
    *("matplotlib", "threading"),
    *("Figure", "nohup", "timeout", "hgt", "surffile", "stairs", "reduceat", "__init__"),
    *keyword.kwlist,
}
INSTANCES = {"self", "result", "data"}
FILES = {
    "py",
    "pyi",
    "toml",
    "json",
    "gz",
    "npy",
    "nc",
    "csv",
    "xyz",
    "html",
    "png",
    "gif",
    "md",
    "yml",
}
# Words with a capital in the column of types that are no class.
PLAIN = {"One", "Path", "Free", "Seed", "Generator", "Comm", "Pa", "Ellipsis"}
NAME = re.compile(r"(?<!`)`([A-Za-z_][\w.]*)`(?!`)|``([a-z_]\w*\.[a-z_]\w*)(?:\(.*?\))?``")
TYPE = re.compile(r"\s+\*{0,2}\w+ : (.+)$")


def names_of(node: ast.AST) -> Iterator[str]:
    """Yield the names that a node defines."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.arg):
        yield node.arg
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
        yield node.id
    elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
        yield node.attr
    elif isinstance(node, ast.alias):
        yield (node.asname or node.name).split(".")[-1]


@cache
def package() -> tuple[set[str], dict[str, set[str]]]:
    """Return all names of the package, and those of each module and class."""
    defined, members = set(dir(builtins)), defaultdict[str, set[str]](set)
    for path in [*layers.PACKAGE.rglob("*.py"), *layers.PACKAGE.rglob("*.pyi")]:
        module = path.stem if path.stem != "__init__" else path.parent.name
        defined.update(path.relative_to(layers.PACKAGE.parent).with_suffix("").parts)
        members[path.parent.name].add(module)
        for node in ast.walk(layers.parse_module(path)):
            found = set(names_of(node))
            defined |= found
            members[module] |= found
            if isinstance(node, ast.ClassDef):
                members[node.name].update(*(names_of(item) for item in ast.walk(node)))
                members[node.name].update("*" for _ in node.bases)
    members["rc"] = members["roughcontact"] | {"*"}
    return defined, members


def is_known(name: str) -> bool:
    """Return whether a name, plain or dotted, exists in the package or elsewhere."""
    defined, members = package()
    parts = name.split(".")
    if parts[0] in EXTERNAL | INSTANCES or parts[-1] in FILES:
        return True
    if len(parts) == 1:
        return name in defined
    if parts[0] == "roughcontact" and ".".join(parts[1:]) + ".__init__" in layers.module_paths():
        return True
    if parts[-2] not in members:
        return {parts[-2], parts[-1]} <= defined
    return bool(members[parts[-2]] & {parts[-1], "*"})


def names_in(line: str) -> Iterator[str]:
    """Yield the names that a line mentions."""
    yield from (found[1] or found[2] for found in NAME.finditer(line))
    if kind := TYPE.match(line):
        yield from set(re.findall(r"\b[A-Z][a-z]+\w*", kind[1])) - PLAIN


def test_names_in_text_exist() -> None:
    stale = [
        f"{module}:{number} {name}"
        for module, path in layers.module_paths().items()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        for name in names_in(line)
        if not is_known(name)
    ]
    assert stale == []


def test_unknown_names_are_found() -> None:
    assert not is_known("contact.solve.press")
    assert not is_known("RigidPunch")
    assert is_known("contact.solve.solve")
    assert list(names_in("    result : ContactResult")) == ["ContactResult"]
