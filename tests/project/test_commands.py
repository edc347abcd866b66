"""Commands of the pages are run and compared: `docs/commands.py`."""

from __future__ import annotations

import importlib
import re
import shlex
from pathlib import Path
from types import ModuleType

import pytest

from paths import ROOT
from roughcontact.cli import app

DOCS = ROOT / "docs"


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(DOCS))
    return importlib.import_module("commands")


SHOWN = """load      1 N
area      5.67 %
certificate   3e-7, 567 ms
"""


@pytest.mark.parametrize(
    ("printed", "alike"),
    [
        (SHOWN, True),
        # Values of the machine, and the last digits.
        (SHOWN.replace("3e-7", "8e-9").replace("5.67", "5.66"), True),
        (SHOWN.replace("567 ms", "1.05 s"), True),
        (SHOWN.replace("5.67", "5.87"), False),
        (SHOWN.replace("area", "contact area"), False),
        (SHOWN.replace("load      1 N", "load 1 N"), True),
        (SHOWN + "caution: so\n", False),
    ],
)
def test_text_is_compared_exactly_and_numbers_to_one_percent(
    commands: ModuleType, printed: str, alike: bool
) -> None:
    assert commands.same(printed, SHOWN) is alike


PAGE = """# A page

```console
$ printf 'one\\ntwo\\n'
one
two
$ printf 'a\\nb\\nc\\n' \\
    | cat
a
…
$ false
$ echo $?
1
```
"""


def test_page_with_current_output_is_unchanged(commands: ModuleType, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE, encoding="utf-8")
    assert commands.check_page(page, tmp_path) == (PAGE, [])


@pytest.mark.parametrize(
    ("shown", "other", "expected"),
    [
        ("\ntwo\n$", "\nthree\n$", "printed\none\ntwo"),
        ("$ echo $?\n1\n", "", "exit status 1 is not shown"),
    ],
)
def test_a_page_that_shows_something_else_is_named_and_mended(
    commands: ModuleType, tmp_path: Path, shown: str, other: str, expected: str
) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE.replace(shown, other, 1), encoding="utf-8")
    mended, (differing,) = commands.check_page(page, tmp_path)
    assert expected in differing
    assert mended == (PAGE if other else PAGE.replace(shown, ""))


def test_the_readme_has_its_scripts_run(commands: ModuleType) -> None:
    scripts = list(commands.scripts((ROOT / "README.md").read_text(encoding="utf-8")))
    together = "".join(scripts)
    for task in ("solve", "sweep", "law", "leak", "compare", "estimate"):
        assert f"roughcontact {task}" in together
    assert "rc.read_surface" in together
    assert "pip install" not in together
    assert "roughcontact desk" not in together


def test_the_joints_of_the_readme_are_periodic() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8").replace("\\\n", " ")
    joints = re.findall(r"^roughcontact (?:law|leak|conductance|compare) .*", text, re.MULTILINE)
    assert len(joints) == 4
    assert all("--boundary periodic" in line for line in joints)


def test_every_page_that_shows_a_command_is_run(commands: ModuleType) -> None:
    run = set(commands.pages())
    for page in DOCS.rglob("*.md"):
        if "_build" not in page.parts and "```console" in page.read_text(encoding="utf-8"):
            assert page in run


@pytest.mark.usefixtures("quick")
@pytest.mark.long
def test_the_console_answers_in_twenty_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "README.md").read_text(encoding="utf-8").replace("\\\n", " ")
    scripts = "".join(re.findall(r"^```sh\n(.*?)^```$", page, re.DOTALL | re.MULTILINE))
    typed = re.findall(r"^\s*(roughcontact .*)", scripts, re.MULTILINE)
    words = [["demo", "--points", "128", "--folder", "."]]
    for line in typed:
        each = [line.replace("$seed", seed) for seed in "123"] if "$seed" in line else [line]
        words += [shlex.split(command)[1:] for command in each]
    assert len(words) > 15
    for typed_words in words:
        # As a shell does.
        command = [
            name
            for word in typed_words
            for name in (
                sorted(map(str, Path().glob(word))) if word.startswith("ground-?") else [word]
            )
        ]
        if "--report" in command:
            del command[command.index("--report") :][:2]
        assert app.main(command) == app.SOLVED, command
        shown = capsys.readouterr().out.partition("\nwritten:\n")[0].rstrip().splitlines()
        assert len(shown) <= 20, "\n".join(shown)
        assert max(map(len, shown)) <= 80, command
