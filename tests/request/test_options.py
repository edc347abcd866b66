"""One table behind every command and the project file."""

from __future__ import annotations

import html
import json
import re
import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from roughcontact.analyses.solve import task as solve
from roughcontact.analyses.tasks import COMMANDS, PROJECT_TASKS as TASKS, from_text
from roughcontact.batch.plan import spell_key
from roughcontact.cli import app
from roughcontact.drawing.export import save
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.material import hardening
from roughcontact.request import options, parsing, preparation as maps, run
from roughcontact.request.options import PICTURES, Option, Panel
from roughcontact.request.request import Request

Capture = pytest.CaptureFixture[str]

OPTIONS = [option for command in COMMANDS.values() for option in command.options]
UNCHECKED = {item.function for item in (parsing.as_text, parsing.path)}
NAMES = sorted({option.name for option in OPTIONS})
# Options that describe the surface, and of each task what it cannot do without.
BALL = {
    "body": "sphere 1 mm",
    "points": "24",
    "size": "60 um",
    "young": "210 GPa",
    "poisson": "0.3",
    "yield-strength": "1 GPa",
}
NEEDED = {
    "solve": {"load": "1 N"},
    "stress": {"load": "1 N", "friction": "0.1", "depths": "1 um, 4 um"},
    "sweep": {"from": "0.5 N", "to": "1 N", "steps": "2", "spacing": "linear"},
    "history": {"path": "1 N, 0 N", "passes": "2"},
    "roll": {
        "load": "0.3 N",
        "counter-body": "sphere 1 mm",
        "travel": "10 um",
        "passes": "1",
        "steps": "2",
        "yield-strength": "3 GPa",
    },
    "find": {"contact-fraction": "20 %, 30 %", "mean-gap": "300 nm"},
    "conductance": {
        "load": "0.5 N, 1 N",
        "resistivity": "200 nohm m",
        "counter-resistivity": "40 nohm m",
    },
    "law": {"from": "1 MPa", "to": "100 MPa", "steps": "3", "boundary": "periodic"},
    "leak": {"load": "0.5 N, 1 N", "viscosity": "1 mPa s", "pressure-difference": "1 bar"},
    "tangential": {"load": "1 N", "friction": "0.15", "force": "0.05 N, -0.05 N"},
    "wear": {"load": "0.3 N", "wear": "1e-15 m2/N", "distance": "10 mm"},
    "compare": {"load": "10 MPa", "preload": "100 MPa"},
}


def words(given: dict[str, str]) -> list[str]:
    options = {option.name: option for option in OPTIONS}
    return [word for name, text in given.items() for word in options[name].words(text)]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_offers_the_options_that_fit_it_and_no_other(
    command: str, capsys: Capture
) -> None:
    # Built again: a command remembers the context in which it is parsed first.
    known = app._build_program.__wrapped__(command).commands[command]
    there = {word for parameter in known.params for word in parameter.opts if word.startswith("--")}
    own = [option for option in COMMANDS[command].options if not option.is_setting]
    assert there - {"--help-all", "--set"} == {f"--{option.name}" for option in own}
    assert ("--set" in there) == (len(own) < len(COMMANDS[command].options))
    assert len(there) <= 46
    subject = [] if command in ("generate", "materials", "demo") else ["subject"]
    strange = []
    for name in NAMES:
        fits = [option for option in COMMANDS[command].options if option.name == name]
        assert len(fits) <= 1, "one option of a name for each command"
        strange += [name] * (not fits)
    for name in strange:
        with pytest.raises(Exception, match=rf"No such option:? '?--{name}(?![\w-])"):
            known.make_context(command, [*subject, f"--{name}", "1"])
    # And in the summary.
    assert app.main([command, *subject, f"--{name}", "1"]) == app.BAD_INPUT
    assert f"--{name}" in capsys.readouterr().err


@pytest.mark.parametrize("task", TASKS)
def test_no_option_is_parsed_as_another(task: str) -> None:
    for name, option in TASKS[task].by_name.items():
        if option.is_flag or option.parse.function in UNCHECKED:
            continue
        with pytest.raises(InputError) as caught:
            from_text(task, None, {**BALL, **NEEDED[task], name: "rubbish"})
        spelled = " ".join(option.words(True))
        assert caught.value.message_for(TASKS[task].spell_argument).startswith(spelled), name
        assert caught.value.message_for(lambda m: spell_key(m, TASKS[task])).startswith(name)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ("--tolerance 1e-8", "--tolerance is a setting: give --set tolerance=1e-8"),
        ("--tolerance=1e-8", "--tolerance is a setting: give --set tolerance=1e-8"),
        ("--offset '0 um, 1 um'", "--offset is a setting: give --set 'offset=0 um, 1 um'"),
        ("--mirror", "--mirror is a setting: give --set mirror"),
        ("--hertz '2 GPa'", "--hertz is gone: give --load 'hertz 2 GPa'"),
        ("--set tolernce=1e-8", "--set: unknown setting tolernce; did you mean tolerance?"),
        ("--set tolerance", "--set tolerance needs a value, NUMBER"),
        ("--set tolerance=1e-8 --set tolerance=1", "is given 2 times (1e-8, 1); give it once"),
        ("--set precision=half", "--set precision must be one of double, single, got 'half'"),
        ("--set mirror=no", "--set mirror must be true or false, got 'no'"),
    ],
)
def test_setting_is_rejected_in_one_sentence(given: str, sentence: str, capsys: Capture) -> None:
    command = ["solve", *words(BALL), "--load", "1 N", *shlex.split(given)]
    assert app.main(command) == app.BAD_INPUT
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("task", [n for n, t in TASKS.items() if options.DEVICE in t.options])
def test_device_is_opened_before_maps_are_read(task: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    request = from_text(task, None, {**BALL, **NEEDED[task], "device": "cuda"})

    def read(*_: object) -> list[Any]:
        raise AssertionError("a map was read")

    with pytest.raises(InputError, match="device = 'cuda' needs PyTorch"):
        run.run_request(request, lambda _: None, read=read)
    if request.task.pieces is not None:
        with pytest.raises(InputError, match="device = 'cuda' needs PyTorch"):
            request.solve_subtask("0", lambda _: None, lambda _: None)


@pytest.mark.parametrize("task", TASKS)
def test_defaults_match_help(task: str) -> None:
    for name, option in TASKS[task].by_name.items():
        said = re.search(r"default: ([\w.-]+)", option.help)
        if said and option.default is not None and not isinstance(option.default, tuple):
            assert str(option.default).startswith(said[1].rstrip(".")), name


def test_help_is_one_sentence_or_more() -> None:
    for option in OPTIONS:
        # Choices begin with the first of them, as it is typed.
        begins = option.help.split()[0].rstrip(":")
        assert begins[0].isupper() or begins in option.metavar, option.name
        assert option.help.rstrip(")").endswith("."), option.name
        assert "by default" not in option.help
        assert "without." not in option.help


def test_format_of_one_model_names_its_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        solve, "RESULTS", {"ceiling": (".nc", ".obj"), "elastoplastic": (".nc", ".vtr")}
    )
    for model, suffix, other in (
        ("ceiling", ".vtr", "elastoplastic"),
        ("elastoplastic", ".obj", "ceiling"),
    ):
        given = {**BALL, **NEEDED["solve"], "model": model}
        with pytest.raises(InputError) as caught:
            from_text("solve", None, {**given, "output": f"out{suffix}"})
        assert str(caught.value).endswith(f'; {suffix} needs model="{other}"')
        solve._check(from_text("solve", None, {**given, "output": "out.nc"}))


def test_arguments_are_spelled_at_each_edge() -> None:
    for mention, option, key in (
        (ArgumentRef("max_iterations"), "--set max-iterations", "max-iterations"),
        (ArgumentRef("precision", "single"), "--set precision=single", 'precision = "single"'),
        (ArgumentRef("size", "0.1 mm x 1 mm"), "--size '0.1 mm x 1 mm'", 'size = "0.1 mm x 1 mm"'),
        (ArgumentRef("ceiling", 3e9), "--ceiling '3 GPa'", 'ceiling = "3 GPa"'),
        (ArgumentRef("load", 0.5), "--load '500 mN'", 'load = "500 mN"'),
        (ArgumentRef("tolerance", 1e-4), "--set tolerance=0.0001", 'tolerance = "0.0001"'),
        (ArgumentRef("study", True), "--study", "study = true"),
        (ArgumentRef("s"), "--s-filter", "s-filter"),
        (ArgumentRef("heights"), "heights", "heights"),
    ):
        assert (solve.TASK.spell_argument(mention), spell_key(mention, solve.TASK)) == (option, key)
    # A sweep has no single load.
    assert COMMANDS["sweep"].spell_argument(ArgumentRef("load")) == "load"
    assert COMMANDS["history"].option_of_argument("load") is None


@pytest.mark.long
def test_pictures_are_those_that_can_be_saved(tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    for suffix in PICTURES:
        save(Figure(), tmp_path / f"figure{suffix}")


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("task", TASKS)
def test_the_command_of_a_report_repeats_it(task: str, tmp_path: Path, capsys: Capture) -> None:
    y, x = np.mgrid[:24, :24] / 24
    source = tmp_path / "a map's file.npy"
    np.save(source, 1e-3 * np.cos(7 * y) * np.cos(5 * x))
    report = tmp_path / "out file.html"
    given = {
        "unit": "mm",
        "size": "60 um",
        **{k: BALL[k] for k in ("young", "poisson")},
        "ceiling": "2 GPa",
        "level": "none",
        **NEEDED[task],
        "report": str(report),
    }
    given = {name: text for name, text in given.items() if name in TASKS[task].by_name}
    assert app.main([task, str(source), *words(given), "--json"]) == app.SOLVED
    before = json.loads(capsys.readouterr().out)
    text = html.unescape(report.read_text(encoding="utf-8"))
    found = re.search(r"<pre[^>]*>(?:<code>)?(roughcontact .*?)<", text, re.DOTALL)
    assert found is not None
    program, *command = shlex.split(found[1])
    assert program == "roughcontact"
    report.unlink()
    assert app.main([*command, "--json"]) == app.SOLVED
    after = json.loads(capsys.readouterr().out)
    assert report.exists()
    for item in (before, after):
        item.pop("seconds", None)
        for part in ("steps", "volume"):
            item.get(part, {}).pop("seconds", None)
    assert before == after


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("linear 2 GPa", hardening.Linear("1 GPa", "2 GPa")),
        ("swift 945 MPa 20 0.121", hardening.Swift("945 MPa", 20, 0.121)),
        ("kinematic 10 GPa", hardening.Kinematic(hardening.Perfect("1 GPa"), "10 GPa")),
        (
            "linear 2 GPa, kinematic 10 GPa",
            hardening.Kinematic(hardening.Linear("1 GPa", "2 GPa"), "10 GPa"),
        ),
        (
            "kinematic 10 GPa, Swift 945 MPa 20 0.121",
            hardening.Kinematic(hardening.Swift("945 MPa", 20, 0.121), "10 GPa"),
        ),
    ],
)
def test_laws_of_hardening_in_text(text: str, law: hardening.Hardening) -> None:
    given = {**BALL, **NEEDED["solve"], "hardening": text}
    if "wift" in text:
        del given["yield-strength"]
    assert from_text("solve", None, given).bodies[0].hardening == law


def test_a_given_yield_strength_replaces_the_law_of_the_catalogue() -> None:
    plain = {name: text for name, text in BALL.items() if name not in ("young", "poisson")}
    given = {**plain, **NEEDED["solve"], "material": "304"}
    own = from_text("solve", None, given).bodies[0]
    del given["yield-strength"]
    known = from_text("solve", None, given).bodies[0]
    assert known.hardening is not None
    assert own.hardening is None
    assert own.hardness == known.hardness


WORDS = st.text(min_size=1).filter(lambda text: text.strip() == text and "\0" not in text)


@settings(max_examples=30)
@given(name=WORDS, files=st.lists(WORDS, min_size=1))
@example(name="a=b", files=["c,d.npy", 'e".npy', '"f', "g\nh", "i\u2028j"])
@example(name='"a"', files=["c"])
def test_a_group_is_read_as_it_was_written(name: str, files: list[str]) -> None:
    assert parsing.group(parsing.group_text(name, files), "group") == (name, tuple(files))


def test_value_is_read_by_its_option_only() -> None:
    request = from_text("solve", None, {**BALL, "load": "1 N"})
    assert request[options.LOAD_POINT] is None
    other = Option("load-point", parsing.offset, "Another.", None)
    passes = COMMANDS["roll"].by_name["passes"]
    for strange in (other, passes):
        with pytest.raises(KeyError, match=strange.name):
            request[strange]
    # An option of another task is there for what serves several.
    assert request.get(passes) is None
    # And what has the same name serves as well.
    assert request.get(COMMANDS["leak"].by_name["load"]) == request[options.LOAD]


@pytest.mark.parametrize("prepares", [True, False])
def test_new_option_prepares_maps_if_declared(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, prepares: bool
) -> None:
    row = Option("stretch", parsing.number, "Factor.", 1.0, Panel.MAP, prepares=prepares)
    task = replace(solve.TASK, options=(*solve.TASK.options, row))
    step = maps._prepare

    def stretched(request: Any, asked: Any, surface: Any, path: Path) -> Any:
        made = step(request, asked, surface, path)
        return replace(made, heights=asked[row] * made.heights)

    monkeypatch.setattr(maps, "_prepare", stretched)
    np.save(tmp_path / "map.npy", np.random.default_rng(1).standard_normal((16, 16)))
    given = {
        "unit": "nm",
        "size": "16 um",
        "young": "210 GPa",
        "poisson": "0.3",
        "load": "20 mN",
        "ceiling": "none",
    }
    requests = [
        Request.from_text(task, tmp_path / "map.npy", {**given, "stretch": factor})
        for factor in ("1", "4")
    ]
    # Maps that two requests prepare in the same way are read once.
    with run.shared_runner() as carry_out:
        if not prepares:
            with pytest.raises(KeyError, match="stretch"):
                carry_out(requests[0], lambda _: None)
            return
        once, four = (carry_out(one, lambda _: None).contact for one in requests)
    assert np.ptp(four.surface.heights) == pytest.approx(4 * np.ptp(once.surface.heights))
    assert four.contact_fraction < once.contact_fraction
