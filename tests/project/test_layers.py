"""The order of the folders is the architecture: a folder imports only those below it."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from layers import (
    PACKAGE,
    TESTS,
    all_nodes,
    imported_modules,
    layer_of,
    level_of,
    module_paths,
    tree_of,
)

pytestmark = pytest.mark.usefixtures("parsed_sources")


def test_layer_imports_only_layers_below() -> None:
    for module, path in module_paths().items():
        for other in imported_modules(path):
            assert other == "_version" or level_of(other) <= level_of(module), (
                f"{module} imports {other} from a layer above"
            )


def test_imports_include_references_in_text() -> None:
    known = module_paths()
    assert "analyses.law.decks" in imported_modules(known["analyses.law.formats"])
    assert "analyses.leak.report" in imported_modules(known["analyses.leak.task"])


def test_layers_have_no_import_cycles() -> None:
    graph = {
        module: {other for other in imported_modules(path) if layer_of(other) == layer_of(module)}
        for module, path in module_paths().items()
    }
    done: set[str] = set()
    while len(done) < len(graph):
        ready = {name for name in graph if name not in done and graph[name] <= done}
        assert ready, f"circle among {sorted(graph.keys() - done)}"
        done |= ready


def test_modules_have_no_section_comments() -> None:
    # A second subject is a second module.
    marked = [path for path in PACKAGE.rglob("*.py") if "\n# ---" in path.read_text("utf-8")]
    assert marked == []


LONGEST_MODULE, LONGEST_FUNCTION, LONGEST_CODE = 1000, 70, 55

# Functions that are longer, by module and name, each with the reason why taking them apart would
# hide what they do.
LONG: dict[str, str] = {}


def lengths(function: ast.FunctionDef) -> tuple[int, int]:
    """Return the lines of a function, with its docstring and without."""
    assert function.end_lineno is not None
    whole = function.end_lineno - function.lineno + 1
    if ast.get_docstring(function) is None:
        return whole, whole
    first = function.body[0]
    assert first.end_lineno is not None
    return whole, whole - (first.end_lineno - first.lineno + 1)


def too_long(tree: ast.Module) -> list[str]:
    """Return the functions that are too long.

    The docstring of a public function is a contract: it may be as long as it needs to be, where
    the code is short.
    """
    public = {id(node) for node in tree.body if not getattr(node, "name", "_").startswith("_")}
    found = []
    for node in all_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            whole, code = lengths(node)
            contract = id(node) in public and code < LONGEST_CODE
            if whole > LONGEST_FUNCTION and not contract:
                found.append(node.name)
    return found


def test_modules_and_functions_are_short() -> None:
    lines = {
        module: path.read_text(encoding="utf-8").count("\n")
        for module, path in module_paths().items()
    }
    assert [module for module, count in lines.items() if count > LONGEST_MODULE] == []
    found = {f"{module}.{name}" for module in module_paths() for name in too_long(tree_of(module))}
    assert sorted(found - set(LONG)) == [], "take them apart"
    assert sorted(set(LONG) - found) == [], "no longer long"


def test_only_units_imports_pint() -> None:
    users = {
        module
        for module in module_paths()
        for node in all_nodes(tree_of(module))
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
        if name.split(".")[0] == "pint"
    }
    assert users == {"units"}


# Objects that are filled during a computation.
GROWING = {
    "contact.validation": {"ContactProblem"},
    "analyses.find.model": {"_Finder"},
    "uncertainty.resolution": {"_Study"},
    "analyses.law.model": {"_Samples"},
    "elastoplastic.solve": {"_PathRun"},
}


def test_dataclasses_are_frozen() -> None:
    loose = {
        (module, node.name)
        for module in module_paths()
        for node in all_nodes(tree_of(module))
        if isinstance(node, ast.ClassDef)
        for item in [" ".join(map(ast.unparse, node.decorator_list))]
        if "dataclass" in item and "frozen=True" not in item
    }
    assert loose == {(module, name) for module, names in GROWING.items() for name in names}


UNLESS_TOLD = {"angle": "0.0", "mirrored": "False"}


def test_rotation_and_mirroring_are_off_by_default() -> None:
    for module in module_paths():
        for node in all_nodes(tree_of(module)):
            # Functions that rotate need an angle.
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("rotate"):
                continue
            given = node.args
            names = [argument.arg for argument in (*given.posonlyargs, *given.args)]
            defaults = {
                **dict(zip(names[::-1], given.defaults[::-1], strict=False)),
                **{a.arg: d for a, d in zip(given.kwonlyargs, given.kw_defaults, strict=True)},
            }
            for name, usual in UNLESS_TOLD.items():
                if defaults.get(name) is not None:
                    assert ast.unparse(defaults[name]) in (usual, "None"), f"{module}.{node.name}"


# Functions that act on all threads of a process, also if undone at the end of a block.
SHARED = {
    "redirect_stdout",
    "redirect_stderr",
    "catch_warnings",
    "simplefilter",
    "filterwarnings",
    "showwarning",
    "chdir",
    "seterr",
    "seterrcall",
    "set_printoptions",
    "setlocale",
    "umask",
    "basicConfig",
    "setrlimit",
}

# The program owns its process, a library does not.
# Workers have separate processes as well.
# A worker of a cluster lets tasks of another folder wait.
OWNS = {"cli.app": {"basicConfig"}, "_tools.processes": {"setrlimit"}, "batch.jobs": {"chdir"}}


def test_no_module_changes_process_wide_state() -> None:
    for module in module_paths():
        nodes = all_nodes(tree_of(module))
        named = {node.attr for node in nodes if isinstance(node, ast.Attribute)}
        named |= {
            alias.name for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names
        }
        assert named & SHARED <= OWNS.get(module, set()), module


# Where a user or a formula is: there docstrings are contracts, elsewhere one line.
CONTRACTS = {"theory", "drawing", "halfspace", "solvers"}


def offered() -> set[str]:
    """Return the public names of the package, by module and name."""
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    nodes = [*stub.body, *tree_of("measure").body]
    nodes += [*tree_of("results").body, *tree_of("plots").body]
    names = {
        f"{(node.module or '').removeprefix('roughcontact.')}.{alias.name}".strip(".")
        for node in nodes
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    return names | {module for module in names if module in module_paths()}


def contracts(node: ast.Module | ast.ClassDef, owner: str, public: set[str]) -> Iterator[str]:
    """Yield what has a contract and is neither offered nor part of what is."""
    for child in node.body:
        if not isinstance(child, ast.FunctionDef | ast.ClassDef):
            continue
        name = f"{owner}.{child.name}"
        if name in public or (owner in public and not child.name.startswith("_")):
            public.add(name)
        elif "\nParameters\n---" in (ast.get_docstring(child) or ""):
            yield name
        if isinstance(child, ast.ClassDef):
            yield from contracts(child, name, public)


def test_full_docstrings_are_in_public_or_mathematical_code() -> None:
    public = offered()
    # Figures of an analysis are called by users, too.
    inner = [
        module
        for module in module_paths()
        if layer_of(module) not in CONTRACTS and not module.endswith("figures")
    ]
    assert [name for module in inner for name in contracts(tree_of(module), module, public)] == []


# Participles and the like that name nothing, with what to write instead.
BANNED_NAMES = {
    "found": "result",
    "told": "text",
    "asked": "requested",
    "given": "specified",
    "made": "created",
    "kept": "cached",
    "left": "remaining",
    "beside": "reference",
    "apart": "separately",
    "one": "item",
    "at": "index",
    "most": "maximum",
    "least": "minimum",
    "going": "checkpoint",
    "lawful": "interface_law",
    "making": "generation",
    "facing": "sliding_pair",
    "said": "text",
}

# Names of the public face, and a side of a rectangle.
ALLOWED = {
    "solvers.progress.kept",
    "surface.provenance.found",
    "surface.surface.most",
    "desk.rasters.left",
}


def names(tree: ast.Module) -> Iterator[str]:
    """Yield what a module defines: functions, classes, arguments, attributes, constants."""
    owners = [tree, *(node for node in all_nodes(tree) if isinstance(node, ast.ClassDef))]
    for node in (child for owner in owners for child in owner.body):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            yield from (
                (part.id for part in ast.walk(target) if isinstance(part, ast.Name))
                if (target)
                else ()
            )
    for node in all_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr


def test_no_name_is_a_participle() -> None:
    banned = {
        f"{module}.{name}"
        for module in module_paths()
        for name in (module.rpartition(".")[2], *names(tree_of(module)))
        if name.strip("_") in BANNED_NAMES
    }
    assert banned == ALLOWED


# Tests of the project, of damaged input and of whole processes belong to no module.
APART = {"project", "fuzz"}


def test_tests_mirror_the_package() -> None:
    known = set(module_paths())
    for path in sorted(TESTS.rglob("test_*.py")):
        folder = ".".join(path.parent.relative_to(TESTS).parts)
        if folder.partition(".")[0] in APART:
            continue
        words = path.stem.removeprefix("test_").split("_")
        names = ["_".join(words[:count]) for count in range(1, len(words) + 1)]
        prefix = f"{folder}." if folder else ""
        assert any(f"{prefix}{name}" in known for name in names), f"{path} tests no module"
