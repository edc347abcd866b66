"""Expressions of translated English, and names that name nothing: their number only decreases."""

from __future__ import annotations

import ast
import csv
import re
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from paths import ROOT

# Most hits allowed: lower a number when fewer are left, so that none comes back.
LIMITS = {
    "text of src": 1,
    "text of docs": 0,
    "text of tests": 0,
    "text of CHANGELOG.md": 0,
    "changelog": 0,
    "name": 0,
    "constant": 0,
    "test": 0,
}

# Methods of `Surface` that return a changed copy, as in NumPy and pandas; overrides of io, Tornado.
NAMES = {
    *("filled", "without_form", "without_outliers"),
    *("read", "on_finish", "on_connection_close"),
}

# As the formatter writes comments: alone on a line, or after two spaces.
COMMENT = re.compile(r"(?:^|  )[ ]*# ?(.*)$", re.MULTILINE)

# Folders that building the documentation writes.
MADE = {"generated", "_build", "examples"}


def patterns() -> Iterator[tuple[str, re.Pattern[str], str]]:
    """Yield scope, expression and replacement of each row of the table."""
    with Path(__file__).with_name("english.tsv").open(encoding="utf-8") as stream:
        for scope, text, instead in list(csv.reader(stream, delimiter="\t"))[1:]:
            ignored = re.IGNORECASE if scope == "text" and not text.startswith("^") else 0
            yield scope, re.compile(text, ignored), instead


PATTERNS = list(patterns())


def plain(text: str) -> str:
    """Return a text without code, formulas and addresses."""
    return re.sub(r"``[^`]*``|`[^`]*`|\$[^$]*\$|https?://\S+", "x", text)


@lru_cache(1)
def nodes_of(path: Path) -> list[ast.AST]:
    """Return the nodes of a module, whose texts and names are searched one after the other."""
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def texts(path: Path) -> Iterator[str]:
    """Yield the lines of docstrings, comments and messages of a module."""
    for node in nodes_of(path):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield from map(str.strip, node.value.splitlines())
    yield from COMMENT.findall(path.read_text(encoding="utf-8"))


def prose(path: Path) -> Iterator[str]:
    """Yield the lines of a page that are not code."""
    is_code = False
    for line in path.read_text(encoding="utf-8").splitlines():
        is_code ^= line.startswith("```")
        if not is_code:
            yield line


def names(path: Path) -> Iterator[tuple[str, str]]:
    """Yield kind and name of the functions and constants of a module."""
    tree, *nodes = nodes_of(path)
    for node in nodes:
        if isinstance(node, ast.FunctionDef) and node.name not in NAMES:
            yield "name", node.name
    for node in ast.iter_child_nodes(tree):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            if isinstance(target, ast.Name) and target.id.isupper():
                yield "constant", target.id


def material() -> Iterator[tuple[str, str, str]]:
    """Yield place, scope and text of everything that is checked."""
    for path in sorted((ROOT / "src" / "roughcontact").rglob("*.py")):
        for text in texts(path):
            yield "text of src", "text", plain(text)
        for kind, name in names(path):
            yield kind, kind, name
    pages = [path for path in sorted((ROOT / "docs").rglob("*.md")) if not MADE & {*path.parts}]
    for path in [ROOT / "README.md", *pages]:
        for text in prose(path):
            yield "text of docs", "text", plain(text)
    for folder in ("tests", "benchmarks", "calibration", "docs", "scripts"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            # The table of `test_words` has the same expressions.
            if folder not in ("docs", "scripts") and path.name != "test_words.py":
                for text in texts(path):
                    yield "text of tests", "text", plain(text)
            for kind, name in names(path):
                if folder != "tests":
                    yield kind, kind, name
                elif name.startswith("test_"):
                    yield "test", "test", name
    for line in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines():
        yield "changelog", "changelog", line
        yield "text of CHANGELOG.md", "text", plain(line)


def test_no_new_hit_of_the_table() -> None:
    hits: Counter[str] = Counter()
    for place, scope, text in material():
        for wanted, pattern, _ in PATTERNS:
            if wanted == scope:
                hits[place] += len(pattern.findall(text))
    assert {place: count for place, count in hits.items() if count > LIMITS[place]} == {}
