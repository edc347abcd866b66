"""Whether the tests notice a wrong operator, number or branch: a sample of mutants, one by one.

    pip install cosmic-ray coverage pytest-cov     # besides what the tests need
    python tests/fuzz/mutants.py cover FOLDER      # which test runs which line
    python tests/fuzz/mutants.py run FOLDER        # 300 mutants; continues where it stopped
    python tests/fuzz/mutants.py again FOLDER      # those that survived, with more tests
    python tests/fuzz/mutants.py report FOLDER     # how many were killed, and which were not

cosmic-ray says what can be mutated and mutates it. The sample is one of places in the code, all
alike, with one of the mutants of each: an operator has eleven, a number two. A mutant is tried in a
copy of the tree by the tests that run its statement, the quickest first, and by the examples in its
module. It is killed by the first test that fails, or by taking far longer than they do.
Annotations, patterns and the stars of arguments are no code here, and are left alone.
``docs/evidence/mutants.md`` has the results.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import functools
import importlib
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tokenize
import traceback
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "roughcontact"
PAGE = ROOT / "docs" / "evidence" / "mutants.md"
START, END = "<!-- result -->", "<!-- end -->"
LAYERS = ("material", "theory", "halfspace", "solvers", "surface")
IMPORTED = ("src", "benchmarks", "calibration", "tests", "tests/fuzz")
COPIED = (
    "src",
    "tests",
    "benchmarks",
    "calibration",
    "docs",
    "pyproject.toml",
    "README.md",
    "CHANGELOG.md",
)
# Tests that import a layer but check what is built on it: they are slow and find faults late.
ELSEWHERE = (
    "contact/test_archive",
    "project/test_assumptions_page",
    "cli/test_app",
    "analyses/compare/test_model",
    "elastoplastic/test_solve",
    "test_errors",
    "project/test_examples",
    "analyses/history/test_model",
    "project/test_howto",
    "elastoplastic/test_increments",
    "fuzz/test_killed_runs",
    "project/test_latency",
    "contact/test_memory_limits",
    "analyses/find/test_model",
    "request/test_options",
    "test_plots",
    "test_references",
    "report/test_page",
    "fuzz/test_problems",
    "analyses/roll/test_model_checkpoints",
    "analyses/roll/test_task",
    "request/test_run",
    "report/test_python_script",
    "drawing/test_export",
    "cli/test_app_signals",
    "analyses/stress/test_figures",
    "analyses/solve/test_volume_report",
)
# Folders of tests that start processes.
PROCESSES = ("batch", "desk", "project", "fuzz")
# Long tests and whole processes run as well.
ASKED = "not slow"
# Tests that a mutant is given at first; seconds of all; processor time over that, and the least.
FEW, MOST, PATIENCE, LEAST_PATIENCE = 12, 60.0, 1.5, 30.0
# Slow imports of tests.
IMPORTED = (
    "pytest",
    "numpy",
    "scipy.special",
    "scipy.optimize",
    "scipy.ndimage",
    "scipy.interpolate",
    "scipy.sparse.linalg",
    "scipy.fft",
    "xarray",
    "h5py",
    "pint",
    "matplotlib.figure",
    "cosmic_ray.mutating",
)


@dataclass(frozen=True, order=True)
class Mutant:
    """A place and what is done there."""

    module: str
    operator: str
    occurrence: int
    place: tuple[int, int]
    first: int
    last: int


def pytest_sessionfinish(session: Any) -> None:
    """Write how long each test took: pytest loads this module as a plugin in `cover`."""
    if not hasattr(session.config, "workerinput"):
        path = Path(os.environ["MUTANTS_TIMES"])
        before = json.loads(path.read_text("utf-8")) if path.exists() else {}
        path.write_text(json.dumps({**before, **_times}), encoding="utf-8")


def pytest_runtest_logreport(report: Any) -> None:
    """Keep how long a test took."""
    _times[report.nodeid] = _times.get(report.nodeid, 0.0) + report.duration


_times: dict[str, float] = {}


def cover(folder: Path, extra: list[str]) -> None:
    """Run the tests once, and keep which of them ran which line, and for how long.

    Other arguments go to pytest: ``--cov-append -k NAME`` adds tests to those that were run.
    """
    folder.mkdir(parents=True, exist_ok=True)
    # Not named after the data: coverage clears away `coverage.*` as it begins.
    rules = folder / "rules.ini"
    rules.write_text(f"[run]\nsource = {PACKAGE}\ndata_file = {folder / 'coverage'}\n")
    files = [str(path.relative_to(ROOT)) for path in _files()]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-n",
        "auto",
        "-m",
        ASKED,
        "-p",
        "mutants",
        "--cov",
        f"--cov-config={rules}",
        "--cov-context=test",
        "--cov-report=",
        *extra,
        *files,
    ]
    subprocess.run(command, cwd=ROOT, env=_surroundings(ROOT, folder), check=False)


def _files() -> Iterator[Path]:
    """Yield the files of tests that import a tested layer."""
    if unknown := [name for name in ELSEWHERE if not (ROOT / f"tests/{name}.py").exists()]:
        raise SystemExit(f"no such tests: {', '.join(unknown)}")
    named = re.compile(rf"roughcontact\.({'|'.join(LAYERS)})\b")
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        name = path.relative_to(ROOT / "tests").with_suffix("").as_posix()
        own = name.partition("/")[0] not in PROCESSES and name not in ELSEWHERE
        if own and named.search(path.read_text(encoding="utf-8")):
            yield path


def _surroundings(tree: Path, folder: Path) -> dict[str, str]:
    path = os.pathsep.join([*(str(tree / folder) for folder in IMPORTED), *sys.path[1:]])
    return {**os.environ, "PYTHONPATH": path, "MUTANTS_TIMES": str(folder / "times.json")}


# --- the mutants ----------------------------------------------------------------------------------


def all_mutants(modules: Iterable[str]) -> Iterator[Mutant]:
    """Yield every mutant of some modules, annotations and stars of arguments left out."""
    from cosmic_ray.ast import ast_nodes, get_ast_from_path
    from cosmic_ray.plugins import get_operator, operator_names

    for module in modules:
        tree = get_ast_from_path(ROOT / module)
        spared = _annotations(module) + _stars(module)
        for name in sorted(operator_names()):
            operator = get_operator(name)
            if operator.arguments() or name == "core/NoOp":
                continue
            places = (
                place for node in ast_nodes(tree) for place in operator().mutation_positions(node)
            )
            for occurrence, (start, _) in enumerate(places):
                if not any(a <= start < b for a, b in spared):
                    first, last = _statement(module, start[0])
                    yield Mutant(module, name, occurrence, start, first, last)


@functools.cache
def _tree(module: str) -> ast.Module:
    return ast.parse((ROOT / module).read_text(encoding="utf-8"))


@functools.cache
def _annotations(module: str) -> tuple[tuple[tuple[int, int], tuple[int, int]], ...]:
    """Return where annotations, imports for types, and patterns of `case` stand."""
    found: list[ast.AST | None] = []
    for node in ast.walk(_tree(module)):
        if isinstance(node, ast.arg | ast.AnnAssign):
            found.append(node.annotation)
        elif isinstance(node, ast.FunctionDef):
            found.append(node.returns)
        elif isinstance(node, ast.MatchOr) or (
            isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        ):
            found.append(node)
    return tuple(
        ((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset))  # type: ignore[attr-defined]
        for node in found
        if node is not None
    )


@functools.cache
def _stars(module: str) -> tuple[tuple[tuple[int, int], tuple[int, int]], ...]:
    """Return where `*` and `**` multiply nothing: of arguments, unpacked or by keyword alone."""
    found = []
    before = "("
    with (ROOT / module).open("rb") as source:
        for token in tokenize.tokenize(source.readline):
            if token.string in ("*", "**") and before[-1:] in tuple("([{,=:"):
                found.append((token.start, token.end))
            if token.type not in (tokenize.NL, tokenize.COMMENT):
                before = token.string
    return tuple(found)


@functools.cache
def _statement(module: str, line: int) -> tuple[int, int]:
    """Return the lines of the innermost statement at a line, without what it holds."""
    best = (line, line)
    smallest = sys.maxsize
    for node in ast.walk(_tree(module)):
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            last = body[0].lineno - 1 if body else node.end_lineno or node.lineno
            if node.lineno <= line <= last and last - node.lineno < smallest:
                best, smallest = (node.lineno, last), last - node.lineno
    return best


def sample(size: int, seed: int, file: Path) -> list[Mutant]:
    """Return the same mutants of the same code again, and keep what they are a sample of."""
    modules = [
        str(path.relative_to(ROOT))
        for layer in LAYERS
        for path in sorted((PACKAGE / layer).glob("*.py"))
    ]
    places: dict[tuple[str, tuple[int, int]], list[Mutant]] = {}
    for mutant in sorted(all_mutants(modules)):
        places.setdefault((mutant.module, mutant.place), []).append(mutant)
    count = sum(map(len, places.values()))
    whole = {"mutants": count, "places": len(places), "modules": len(modules)}
    file.write_text(json.dumps({**whole, "size": size, "seed": seed}), encoding="utf-8")
    print(whole, flush=True)
    draw = random.Random(seed)
    return [draw.choice(places[one]) for one in draw.sample(sorted(places), min(size, len(places)))]


# --- their tests ----------------------------------------------------------------------------------


class Covered:
    """Which tests run which lines, and how long they take."""

    def __init__(self, folder: Path) -> None:
        from coverage import CoverageData

        self.data = CoverageData(str(folder / "coverage"))
        self.data.read()
        self.times: dict[str, float] = json.loads((folder / "times.json").read_text("utf-8"))
        self.files = {
            Path(name).as_posix().partition("/src/roughcontact/")[2]: name
            for name in self.data.measured_files()
        }

    def tests(self, mutant: Mutant) -> list[str]:
        """Return the tests that run a mutant's statement, the quickest first, to a limit."""
        name = self.files.get(mutant.module.removeprefix("src/roughcontact/"), "")
        by_line = self.data.contexts_by_lineno(name)
        lines = range(mutant.first, mutant.last + 1)
        found = {_test(context) for line in lines for context in by_line.get(line, ())} - {""}
        if not found:
            # Run as the module is imported.
            found = {_test(one) for contexts in by_line.values() for one in contexts} - {""}
        # Tests of the module itself before others.
        own = f"test_{Path(mutant.module).stem}.py"
        ordered = sorted(found, key=lambda test: (own not in test, self.times.get(test, MOST)))
        chosen, seconds = [], 0.0
        for test in ordered:
            seconds += self.times.get(test, MOST)
            if seconds > MOST and chosen:
                break
            chosen.append(test)
        return chosen

    def patience(self, tests: list[str]) -> float:
        """Return the seconds of a processor after which they are treated as stuck."""
        return LEAST_PATIENCE + PATIENCE * sum(self.times.get(test, MOST) for test in tests)


def _test(context: str) -> str:
    return context.rpartition("|")[0] if "|" in context else context


# --- trying them ----------------------------------------------------------------------------------


class Watch:
    """Result of pytest: the first test or module that fails."""

    def __init__(self) -> None:
        self.failed = ""

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    pytest_collectreport = pytest_runtest_logreport


def start_trial(
    mutant: Mutant, tree: Path, tests: list[list[str]], patience: float, file: Path
) -> int:
    """Mutate a copy of the tree and try it in a fork; return its process.

    Imports of all tests were done before, which is most of the time of a mutant. Its time is
    limited by that of the processor, for other programs may be at work.
    """
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator

    path = tree / mutant.module
    whole = (ROOT / mutant.module).read_text(encoding="utf-8")
    changed = mutate_code(whole, get_operator(mutant.operator)(), mutant.occurrence)
    process = os.fork()
    if process:
        return process
    status = 1
    try:
        resource.setrlimit(resource.RLIMIT_CPU, (int(patience), int(patience) + 5))
        path.write_text(changed, encoding="utf-8")
        found = {**asdict(mutant), "diff": _difference(whole, changed), "by": ""}
        found["tests"] = sum(map(len, tests)) - 1
        # Kept before it is known: a fork that is ended for its time leaves this.
        file.write_text(json.dumps({**found, "by": "takes too long"}), encoding="utf-8")
        found["by"] = _killer(tree, tests)
        file.write_text(json.dumps(found, ensure_ascii=False), encoding="utf-8")
        status = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(status)


def _killer(tree: Path, tests: list[list[str]]) -> str:
    import pytest

    os.chdir(tree)
    sys.path[:0] = [str(tree / folder) for folder in IMPORTED]
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)
    with (tree / "output").open("w", encoding="utf-8") as output:
        os.dup2(output.fileno(), 1)
        os.dup2(output.fileno(), 2)
    for part in tests:
        watch = Watch()
        status = pytest.main(["-q", "-x", "-m", ASKED, "-p", "no:cacheprovider", *part], [watch])
        # 5: a module without examples, and no test next to it.
        if status not in (0, 5):
            return watch.failed or f"exit status {int(status)}"
    return ""


def _difference(old: str, new: str) -> list[str]:
    lines = difflib.unified_diff(old.splitlines(), new.splitlines(), n=0, lineterm="")
    return [line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---")]


def run(folder: Path, size: int, seed: int, processes: int, again: bool) -> None:
    """Try a sample, some at a time, and keep each result at once."""
    sys.dont_write_bytecode = True
    for name in IMPORTED:
        importlib.import_module(name)
    covered = Covered(folder)
    results = folder / "results.jsonl"
    done = {_which(one) for one in _read_outcomes(results).values() if one["by"] or not again}
    drawn = sample(size, seed, folder / "sample.json")
    left = [mutant for mutant in drawn if _which(asdict(mutant)) not in done]
    free = [_copied(folder / f"tree{number}") for number in range(processes)]
    at_work: dict[int, tuple[Mutant, Path]] = {}
    while left or at_work:
        if left and free:
            mutant, tree = left.pop(0), free.pop()
            tests = covered.tests(mutant)
            parts = [part for part in ([mutant.module, *tests[:FEW]], tests[FEW:]) if part]
            process = start_trial(
                mutant, tree, parts, covered.patience(tests), tree / "outcome.json"
            )
            at_work[process] = mutant, tree
            continue
        process, status = os.wait()
        mutant, tree = at_work.pop(process)
        if os.waitstatus_to_exitcode(status) > 0:
            raise SystemExit(f"not tried: {mutant}; see {tree / 'output'}")
        shutil.copy(ROOT / mutant.module, tree / mutant.module)
        with results.open("a", encoding="utf-8") as file:
            file.write((tree / "outcome.json").read_text(encoding="utf-8") + "\n")
        free.append(tree)


def _copied(tree: Path) -> Path:
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tree / name)
    return tree


_Which = tuple[str, str, int]


def _which(one: dict[str, Any]) -> _Which:
    return one["module"], one["operator"], one["occurrence"]


def _read_outcomes(results: Path) -> dict[_Which, dict[str, Any]]:
    """Return the final outcome of each mutant, and whether it survived at first."""
    kept: dict[_Which, dict[str, Any]] = {}
    for line in results.read_text(encoding="utf-8").splitlines() if results.exists() else ():
        one = json.loads(line)
        before = kept.get(_which(one), one)
        kept[_which(one)] = {**one, "survived": before.get("survived", not before["by"])}
    return kept


def print_killed(folder: Path, write: bool) -> None:
    """Print the killed mutants of each layer and the survivors; write the former into a page."""
    found = list(_read_outcomes(folder / "results.jsonl").values())
    of = json.loads((folder / "sample.json").read_text(encoding="utf-8"))
    once = sum(not one["survived"] for one in found)
    late = sum(bool(one["by"]) for one in found) - once
    stuck = sum(one["by"] == "takes too long" for one in found)
    lines = [
        f"Of {of['mutants']} mutants at {of['places']} places in {of['modules']} modules, "
        f"{of['size']} were drawn with seed {of['seed']}, and {len(found)} tried: {once} were "
        f"killed at once, {late} when tried again with more tests, and {len(found) - once - late} "
        f"survive. By their time {stuck} were killed.",
        "",
        "| layer | tried | killed at once | killed now |",
        "|---|---|---|---|",
    ]
    for layer in LAYERS:
        here = [one for one in found if f"/{layer}/" in one["module"]]
        first = sum(not one["survived"] for one in here)
        lines.append(f"| {layer} | {len(here)} | {first} | {sum(bool(o['by']) for o in here)} |")
    print("\n".join(lines))
    for one in found:
        if not one["by"]:
            print(f"\n{one['module']}:{one['first']} {one['operator']}, {one['tests']} tests")
            print("\n".join(one["diff"]))
    if write:
        page = PAGE.read_text(encoding="utf-8")
        before, after = page.partition(START)[0], page.partition(END)[2]
        block = "\n".join([START, *lines, END])
        PAGE.write_text(f"{before}{block}{after}", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("task", choices=("cover", "run", "again", "report"))
    parser.add_argument("folder", type=Path, help="where coverage and results are kept")
    parser.add_argument("--size", type=int, default=300, help="mutants of the sample")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    parser.add_argument("--processes", type=int, default=2, help="mutants tried at a time")
    parser.add_argument("--write", action="store_true", help=f"renew {PAGE.name}")
    given, extra = parser.parse_known_args()
    folder = given.folder.resolve()
    if given.task == "cover":
        cover(folder, extra)
    elif given.task == "report":
        print_killed(folder, given.write)
    else:
        run(folder, given.size, given.seed, given.processes, given.task == "again")


if __name__ == "__main__":
    main()
