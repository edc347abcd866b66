"""The help on one screen, and words that a shell completes."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from roughcontact.analyses.tasks import COMMANDS, TASKS
from roughcontact.cli import app

Capture = pytest.CaptureFixture[str]

FIRST = {
    name: command.short_help.split() for name, command in COMMANDS.items() if command.short_help
}
SOURCE = Path(app.__file__).parents[2]


def command_output(capsys: Capture, *words: str) -> str:
    assert app.main(list(words)) == app.SOLVED
    return capsys.readouterr().out


@pytest.mark.parametrize("command", FIRST)
def test_help_explains_ten_options_and_lists_others(
    command: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    out = command_output(capsys, command, "--help")
    first, rest = out.split("Common options:")[1].split("More options")
    explained = re.findall(r"^  --([\w-]+)", first, re.MULTILINE)
    assert explained == FIRST[command]
    assert len(set(explained)) == 10
    rest, settings = rest.split("Help:")[0].split("--set NAME=VALUE")
    named = set(re.findall(r"(?<=\s)--([\w-]+)", rest)) | set(settings.split())
    assert named == COMMANDS[command].by_name.keys() - set(explained)
    assert max(map(len, out.splitlines())) <= 80
    assert out.count("\n") < 72


def test_every_command_of_many_options_has_its_ten() -> None:
    assert {name for name in COMMANDS if len(COMMANDS[name].options) > 20} == set(FIRST)
    assert {task.name for task in TASKS} <= set(FIRST)


@pytest.mark.parametrize("command", COMMANDS)
def test_all_options_are_explained_in_their_order(
    command: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    out = command_output(capsys, command, "--help-all" if command in FIRST else "--help")
    assert max(map(len, out.splitlines())) <= 80
    explained = re.findall(r"^  --([\w-]+)", out, re.MULTILINE)
    known = COMMANDS[command].options
    assert [name for name in explained if name not in ("help-all", "set")] == [
        option.name for option in known if not option.is_setting
    ]
    listed = out.partition("\nSettings:")[2].partition("\n\n")[0]
    settings = re.findall(r"^  ([a-z][\w-]+)[= ]", listed, re.MULTILINE)
    assert settings == [option.name for option in known if option.is_setting]
    plain = " ".join(out.split())
    assert all(" ".join(option.help.split()) in plain for option in COMMANDS[command].options)


def test_help_describes_commands(capsys: Capture) -> None:
    plain = " ".join(command_output(capsys, "--help").split())
    assert "solve Compute pressure, real contact area and gap under one load." in plain
    assert [plain.index(f" {name} ") for name in COMMANDS] == sorted(
        plain.index(f" {name} ") for name in COMMANDS
    )


# Completion


@pytest.fixture
def home(tmp_path: Path) -> dict[str, str]:
    """The environment of a user who has the program on the path, and no settings yet."""
    program = tmp_path / "bin" / "roughcontact"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m roughcontact "$@"\n')
    program.chmod(0o755)
    path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "HOME": str(tmp_path), "PATH": path, "PYTHONPATH": str(SOURCE)}


# Steps of bash when TAB is pressed.
PRESS_TAB = r"""
eval "$(_ROUGHCONTACT_COMPLETE=bash_source roughcontact)"
function=$(complete -p roughcontact | sed 's/.*-F \([^ ]*\).*/\1/')
while read -r line; do
    [[ $line == *'|' ]] && line=${line%|} && read -ra COMP_WORDS <<< "$line" && COMP_WORDS+=("") \
        || read -ra COMP_WORDS <<< "$line"
    COMP_CWORD=$(( ${#COMP_WORDS[@]} - 1 )) COMPREPLY=()
    $function roughcontact
    echo "${COMPREPLY[*]}"
done
"""


@pytest.mark.process
@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is absent")
def test_bash_completes_commands_options_and_materials(home: dict[str, str]) -> None:
    typed = {
        "roughcontact so": "solve",
        "roughcontact sweep x.opd --yield": "--yield-strength",
        "roughcontact solve x.opd --material 100": "100Cr6",
        "roughcontact solve x.opd --boundary periodic-": "periodic-x periodic-y",
        "roughcontact materials Ti-": "Ti-6Al-4V",
        "roughcontact solve x.opd --missing|": "error fill fill-all mask crop",
        # Nothing of ours: the shell completes the name of a file.
        "roughcontact solve x.o": "",
    }
    done = subprocess.run(
        ["bash", "-c", PRESS_TAB],
        input="\n".join(typed) + "\n",
        env=home,
        check=True,
        capture_output=True,
        text=True,
    )
    assert done.stdout.splitlines() == list(typed.values())


@pytest.mark.long
@pytest.mark.parametrize(
    ("shell", "given"),
    [
        ("zsh", {"COMP_WORDS": "roughcontact solve x.opd --material 100", "COMP_CWORD": "4"}),
        ("fish", {"COMP_WORDS": "roughcontact solve x.opd --material 100", "COMP_CWORD": "100"}),
    ],
)
def test_other_shells_are_answered_and_have_a_script(
    shell: str, given: dict[str, str], home: dict[str, str]
) -> None:
    about = {**home, "_ROUGHCONTACT_COMPLETE": f"{shell}_complete", **given}
    done = subprocess.run(["roughcontact"], env=about, capture_output=True, text=True, check=True)
    assert "100Cr6" in done.stdout
    assert "42CrMo4" not in done.stdout
    about = {**home, "_ROUGHCONTACT_COMPLETE": f"{shell}_source"}
    done = subprocess.run(["roughcontact"], env=about, capture_output=True, text=True, check=True)
    assert f"{shell}_complete" in done.stdout
