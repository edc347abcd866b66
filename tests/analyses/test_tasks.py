"""An option of a group and a task with its result appear in all places."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact
from roughcontact.analyses.tasks import TASKS
from roughcontact.request import options

OPTION = """
STRETCH = Option(
    "stretch", parsing.number.with_metavar("FACTOR"), "Factor of heights.", 1.0, Panel.MAP,
    "Stretched by", prepares=True,
)
"""
FIRST_GROUP = 'GROUPS: dict[str, tuple[Command, ...]] = {\n    "Solve one contact": ('
ASKED = """
import json
from pathlib import Path
from roughcontact.cli import app
from roughcontact.batch import project
from roughcontact.request.options import CROP
from roughcontact.analyses.tasks import COMMANDS, TASKS
listed = {command.name for command in COMMANDS.values() if "stretch" in command.by_name}
assert listed == {command.name for command in COMMANDS.values() if CROP in command.options}
assert listed >= {task.name for task in TASKS}
for name in listed:
    assert app.main([name, "--help-all"]) == 0
(entry,) = project.read_project("project.toml")
assert entry.request.values["stretch"] == 3.0
"""
ON_PAGE = """
from pathlib import Path
from roughcontact.desk.inputs_panel import GROUPS, PreparationPanel
from roughcontact.desk.session import Session
assert "stretch" in GROUPS["preparation"]
session = Session(Path("page.toml"), lambda what: None)
panel = PreparationPanel(session, session.set_option, lambda: None)
session.set_option("stretch", "3")
assert session.state.specified["stretch"] == "3"
session.close()
print([widget.label for control in panel._group.roots("stretch") for widget in control])
"""

RESULT = """
from dataclasses import dataclass
from roughcontact.result import Result

@dataclass(frozen=True)
class Height(Result):
    height: float
    cautions = ()
"""
KIND = """
from roughcontact.report.kind import Column, Quantity
from roughcontact.report.presentation import Presentation

class HeightPresentation(Presentation):
    table = (Quantity("height", "height $h$ [m]: Multiple of Sq."),)
    columns = (Column("heights", "height [m]", of=lambda found: [found.height]),)
"""
TASK = """
from roughcontact.request import options, parsing
from roughcontact.request.options import Option
from roughcontact.request.outcome import Outcome
from roughcontact.request.task import Analysis, Task

FACTOR = Option("factor", parsing.number, "Of the height.", 2.0)

def _run(request, work):
    from roughcontact.analyses.height.model import Height

    return Outcome(request, Height(request[FACTOR] * work.maps[0].Sq))

TASK = Task(
    "height", "Print a multiple of the height.",
    (*options.MAP, FACTOR, *options.BODIES, *options.OUTPUT), run=_run,
    questions=(Analysis("How high it is", "A multiple of Sq.", (FACTOR,)),),
    presentations={"Height": "analyses.height.report:HeightPresentation"},
)
"""
ANSWERED = """
from pathlib import Path
from roughcontact.desk.analysis_jobs import ANALYSES, run_analysis
from roughcontact.desk.job_panels import AnalysisForm
from roughcontact.desk.session import SessionState
(task, question), = (one for one in ANALYSES if one[0].name == "height")
form = AnalysisForm(task, question)
form.set_option("factor", "3")
state = SessionState(file=Path("map.npy"))
for name, value in {"unit": "um", "size": "24 um", "material": "100Cr6", "load": "1 N"}.items():
    state = state.with_option(name, value)
found = run_analysis(lambda _: None, state.request(task, **form.words))
print(found.facts)
"""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a copy of the package, with a map next to it."""
    package = Path(roughcontact.__file__).parent
    shutil.copytree(package, tmp_path / "roughcontact")
    np.save(tmp_path / "map.npy", np.random.default_rng(1).standard_normal((24, 24)))
    return tmp_path


def add(file: Path, text: str, before: str, row: str) -> None:
    """Write an object before a line of a file, and its row after that line's last bracket."""
    content = file.read_text(encoding="utf-8")
    assert content.count(before) == 1
    file.write_text(content.replace(before, f"{text}{before}{row}"), encoding="utf-8")


def python(folder: Path, *words: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "100"}
    done = subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def project(folder: Path, *lines: str) -> None:
    known = (
        "write = []",
        "[[contact]]",
        'name = "one"',
        'file = "map.npy"',
        'unit = "um"',
        'size = "24 um"',
        'material = "100Cr6"',
    )
    (folder / "project.toml").write_text("\n".join([*known, *lines]), encoding="utf-8")


@pytest.mark.slow
def test_an_option_in_a_group_is_in_help_project_and_page_of_all_tasks(checkout: Path) -> None:
    options = checkout / "roughcontact" / "request" / "options.py"
    add(options, OPTION, "PREPARATION = (", "STRETCH, ")
    project(checkout, 'load = "1 N"', "stretch = 3")
    help_of_all = python(checkout, "-c", ASKED)
    assert help_of_all.count("--stretch FACTOR") == 13
    assert help_of_all.count("Factor of heights.") == 13
    pytest.importorskip("panel", reason="needs roughcontact[desk]")
    assert "Stretched by" in python(checkout, "-c", ON_PAGE)


@pytest.mark.long
def test_a_task_with_its_result_runs_from_command_project_and_page(checkout: Path) -> None:
    package = checkout / "roughcontact"
    own = package / "analyses" / "height"
    own.mkdir()
    for name, text in (("__init__", ""), ("model", RESULT), ("report", KIND), ("task", TASK)):
        (own / f"{name}.py").write_text(text, encoding="utf-8")
    add(
        package / "analyses" / "tasks.py",
        "from roughcontact.analyses.height import task\n",
        FIRST_GROUP,
        "task.TASK, ",
    )
    words = ["height", "map.npy", "--unit", "um", "--size", "24 um", "--material", "100Cr6"]
    shown = python(checkout, "-m", "roughcontact", *words)
    assert "height" in shown
    record = json.loads(python(checkout, "-m", "roughcontact", *words, "--factor", "4", "--json"))
    twice = json.loads(python(checkout, "-m", "roughcontact", *words, "--json"))
    assert record["height"] == pytest.approx(2 * twice["height"])
    project(checkout, 'task = "height"', "factor = 4")
    python(checkout, "-m", "roughcontact", "run", "project.toml", "--workers", "1")
    written = json.loads((checkout / "project" / "one.json").read_text(encoding="utf-8"))
    assert written["height"] == record["height"]
    pytest.importorskip("panel", reason="needs roughcontact[desk]")
    assert "Multiple of Sq." in python(checkout, "-c", ANSWERED)


def test_every_task_with_a_report_takes_its_head() -> None:
    for task in TASKS:
        if options.REPORT in task.options:
            assert set(options.HEAD) <= set(task.options), task.name
