import errno
import html
import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

import roughcontact
from reading import measurement, needs_reader
from roughcontact import read_result
from roughcontact._tools import memory
from roughcontact.cautions import CautionTag, explain_tag
from roughcontact.cli import app
from roughcontact.contact import archive, solve as contact
from roughcontact.drawing import maps
from roughcontact.elastoplastic import archive as volume_archive, increments, solve as elastoplastic
from roughcontact.material import catalog, hardening
from roughcontact.request import outputs, run
from roughcontact.solvers.progress import Step
from roughcontact.theory import hertz

PACKAGE = Path(roughcontact.__file__).parents[1]

STEEL = ("--young", "210 GPa", "--poisson", "0.3")
YIELDING = (*STEEL, "--yield-strength", "1 GPa")
# ny ≠ nx and dy ≠ dx, so that a swap of axes shows.
SCALE = ("--unit", "um", "--size", "0.1 mm x 0.2 mm")

FIGURES = ("surface", "pressure", "contact", "gap", "histogram")

Capture = pytest.CaptureFixture[str]


def bumps() -> np.ndarray:
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:40, :64] / 40
    return np.cos(7 * y) * np.cos(5 * x) + 0.1 * rng.standard_normal(y.shape)


@pytest.fixture
def rough(tmp_path: Path) -> Path:
    path = tmp_path / "rough.npy"
    np.save(path, bumps())
    return path


@pytest.fixture
def map_with_holes(tmp_path: Path) -> Path:
    heights = bumps()
    heights[5:8, 9] = np.nan
    path = tmp_path / "holed.npy"
    np.save(path, heights)
    return path


def width(out: str) -> int:
    """Return the longest line that is no path; these are never wrapped."""
    return max(len(line) for line in out.splitlines() if not Path(line).is_absolute())


def solve(path: Path, *options: str, load: str = "0.1 N") -> int:
    return app.main(["solve", str(path), *SCALE, "--load", load, *options])


def assert_rejected(capsys: Capture, status: int, *words: str) -> str:
    """Check that the run before ended with status 2 and one sentence that has these words."""
    out, err = capsys.readouterr()
    assert status == app.BAD_INPUT
    assert out == ""
    assert err.startswith("roughcontact: error: ")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    for word in words:
        assert word in err
    return err


def python(*arguments: str, stdout: int = subprocess.PIPE) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(PACKAGE)},
    )


def files(folder: Path) -> set[str]:
    return {path.name for path in folder.rglob("*") if path.is_file()}


# Output


def test_no_arguments_show_the_help(capsys: Capture) -> None:
    assert app.main([]) == app.SOLVED
    out = capsys.readouterr().out
    assert all(command in out for command in ("solve", "sweep", "info", "demo", "Example"))


@pytest.mark.parametrize("command", ["solve", "sweep", "info", "demo"])
def test_every_command_has_help_with_an_example(command: str, capsys: Capture) -> None:
    assert app.main([command, "--help"]) == app.SOLVED
    assert f"roughcontact {command} " in capsys.readouterr().out.split("Example")[1]


def test_module_runs_as_a_program() -> None:
    done = python("-m", "roughcontact", "--version")
    assert (done.returncode, done.stdout, done.stderr) == (
        0,
        f"roughcontact {roughcontact.__version__}\n",
        "",
    )


def test_solve_prints_a_table_that_fits_80_columns(
    rough: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "33")
    assert solve(rough, *YIELDING, "--verbose") == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80
    assert all(line == line.rstrip() for line in lines)
    cells = (re.split(r"  +", line, maxsplit=1) for line in lines)
    shown = {pair[0]: pair[1] for pair in cells if len(pair) == 2}
    assert shown["Grid (y × x)"] == "40 × 64 points"
    assert shown["Pixel (y × x)"] == "2.5 µm × 3.125 µm"
    assert shown["Preparation"] == "leveled: least-squares plane subtracted"
    assert shown["Contact modulus E*"] == "230.8 GPa"
    assert shown["Pressure ceiling"] == "3 GPa, three times the yield strength"
    assert shown["Load W"] == "100 mN (given)"
    assert shown["Status"] == "converged"
    assert "µm² (" in shown["Contact area"]
    assert set(shown) >= {
        "Source",
        "Size (y × x)",
        "Young's modulus E",
        "Boundary",
        "Approach ω",
        "Largest pressure",
        "Saturated area",
        "Mean gap",
        "Residual indentation",
        "Regime",
        "Certificate ε",
        "Load error",
        "Convolutions on the full grid",
        "Time of the solve",
    }


@pytest.mark.parametrize(
    "words",
    [
        ["law", "s1.x3p", "--counter-maps", "r1.x3p", "r2.x3p", "r3.x3p", "--from", "1 MPa"],
        ["law", "--counter-maps", "r1.x3p", "r2.x3p", "s1.x3p", "--from", "1 MPa"],
        ["law", "--counter-surface=r1.x3p", "r2.x3p", "s1.x3p"],
        ["compare", "a.x3p", "--output", "a.csv", "b.csv"],
        ["compare", "--group", "a=a1.x3p", "a2.x3p", "--group", "b=b1.x3p", "b2.x3p"],
    ],
)
def test_a_pattern_that_a_shell_expanded_is_rejected(words: list[str], capsys: Capture) -> None:
    assert app.main(words) == app.BAD_INPUT
    option = next(word for word in words if word.startswith("--")).partition("=")[0]
    assert f"{option} takes one file, and " in capsys.readouterr().err


def test_files_after_the_options_are_read(capsys: Capture) -> None:
    assert app.main(["law", "--counter-maps", "r1.x3p", "s1.x3p"]) == app.BAD_INPUT
    assert "takes one file" not in capsys.readouterr().err


def test_json_matches_library(rough: Path, capsys: Capture) -> None:
    assert solve(rough, *YIELDING, "--json") == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    record = json.loads(out, parse_constant=pytest.fail)
    surface = roughcontact.read_surface(rough, unit="um", size=(1e-4, 2e-4)).leveled()
    steel = roughcontact.Material(210e9, 0.3, 1e9)
    result = roughcontact.solve(surface, load=0.1, material=steel)
    expected = result.summary()
    for name in set(expected) - {"seconds"}:
        assert record[name] == expected[name]
    assert record["converged"] is True
    assert record["material"] == {
        "rigid": False,
        "young": 210e9,
        "poisson": 0.3,
        "yield_strength": 1e9,
        "hardness": None,
    }
    # Infinity is no JSON.
    assert record["counter_material"]["rigid"] is True
    assert record["counter_material"]["young"] is None


def test_every_option_reaches_the_library(
    rough: Path, map_with_holes: Path, capsys: Capture
) -> None:
    status = app.main(
        [
            "solve",
            str(rough),
            *SCALE,
            "--approach",
            "300 nm",
            *YIELDING,
            *shlex.split(
                "--set counter-young='70 GPa' --set counter-poisson=0.33 "
                "--set counter-yield-strength='300 MPa' --counter-surface"
            ),
            str(map_with_holes),
            *shlex.split(
                "--ceiling '2 GPa' --boundary periodic --level quadric --missing fill "
                "--crop 0:32,:48 --set tolerance=1e-5 --set max-iterations=300 "
                "--set precision=double "
                "--json"
            ),
        ]
    )
    assert status == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert record["approach"] == pytest.approx(3e-7)
    assert record["control"] == "approach"
    assert record["boundary"] == "periodic"
    assert record["ceiling"] == 2e9
    assert record["tolerance"] == 1e-5
    assert record["shape"] == [32, 48]
    assert record["preparation"] == [
        "cropped: rows 0:32, columns 0:48",
        "leveled: least-squares quadric subtracted",
    ]
    assert record["counter_preparation"][2].startswith("filled: 3 missing points")
    assert record["counter_material"] == {
        "rigid": False,
        "young": 70e9,
        "poisson": 0.33,
        "yield_strength": 300e6,
        "hardness": None,
    }
    assert record["contact_modulus"] == pytest.approx(1 / (0.91 / 210e9 + (1 - 0.33**2) / 70e9))


def test_ceiling_option_sets_ceiling(rough: Path, capsys: Capture) -> None:
    for options, ceiling in (
        (YIELDING, 3e9),
        ((*YIELDING, "--ceiling", "none"), None),
        ((*YIELDING, "--ceiling", "auto"), 3e9),
        (STEEL, None),
    ):
        assert solve(rough, *options, "--json") == app.SOLVED
        assert json.loads(capsys.readouterr().out)["ceiling"] == ceiling
    assert solve(rough, *YIELDING, "--ceiling", "none", "--verbose") == app.SOLVED
    assert "none: purely elastic\n" in capsys.readouterr().out
    assert solve(rough, *STEEL, "--verbose") == app.SOLVED
    output = " ".join(capsys.readouterr().out.split())
    assert "none: purely elastic, no yield strength is given" in output


def test_a_tag_is_explained(capsys: Capture) -> None:
    assert app.main(["--explain", "edge"]) == app.SOLVED
    lines = capsys.readouterr().out.splitlines()
    assert " ".join(lines) == explain_tag(CautionTag.EDGE)
    assert max(map(len, lines)) <= 80
    assert app.main(["--explain", "edges"]) == app.BAD_INPUT
    output = capsys.readouterr().err
    assert all(f" {kind}" in output for kind in CautionTag)


@pytest.mark.parametrize(
    "task",
    [
        ("solve", "--load", "10 N", "--set", "uncalibrated"),
        ("stress", "--load", "10 N"),
        ("sweep", "--from", "5 N", "--to", "10 N", "--steps", "2"),
        ("history", "--path", "10 N, 0 N"),
    ],
)
def test_cautions_name_options_in_console_and_report(
    task: tuple[str, ...], tmp_path: Path, capsys: Capture, quick: None
) -> None:
    ball = ("--body", "sphere 1 mm", "--points", "32", "--size", "120 um", *YIELDING)
    name = str(tmp_path / "told.html")
    assert app.main([task[0], *ball, *task[1:], "--report", name]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    report = html.unescape(Path(name).read_text(encoding="utf-8"))
    for item in (shown, report):
        assert "--ceiling calibrated" in item
        assert 'ceiling="' not in item
        assert 'boundary="' not in item
    # Messages of a contact appear once, for any analysis of it.
    assert shown.count("CAUTION ceiling:") == 1
    if task[0] == "stress":
        assert "this elastic stress is an upper bound" in report


def test_unsuitable_ceiling_shows_calibrated_ceiling(capsys: Capture) -> None:
    ball = ("--body", "sphere 1 mm", "--points", "64", "--size", "150 um", "--load", "10 N")
    assert app.main(["solve", *ball, *YIELDING, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    other = record["calibrated"]
    assert 2 < other["factor"] < 2.2
    assert other["contact_area"] > 1.1 * record["contact_area"]
    assert app.main(["solve", *ball, *YIELDING]) == app.SOLVED
    shown = capsys.readouterr().out
    assert f"Calibrated ceiling ({other['factor']:.3g} σ_Y)" in shown
    assert app.main(["solve", *ball, *YIELDING, "--set", "uncalibrated"]) == app.SOLVED
    alone = capsys.readouterr().out
    # The same message with the solved change and with that of the rule.
    change = f"{100 * (other['contact_area'] / record['contact_area'] - 1):.2g} % more"
    message = shown[shown.index("CAUTION ceiling") :]
    assert change in " ".join(message.split())
    assert alone[alone.index("CAUTION ceiling") :].split()[:4] == message.split()[:4]
    # Other commands have the messages of the contact.
    assert app.main(["stress", *ball, *YIELDING]) == app.SOLVED
    assert alone[alone.index("CAUTION ceiling") :].strip() in capsys.readouterr().out
    for better in (f"{other['factor']} GPa", "calibrated"):
        assert app.main(["solve", *ball, *YIELDING, "--ceiling", better, "--json"]) == app.SOLVED
        own = json.loads(capsys.readouterr().out)
        assert own["calibrated"] is None
        assert own["contact_area"] == pytest.approx(other["contact_area"], rel=0.01)


def test_calibrated_ceiling_is_compared_with_three_yield_strengths(
    tmp_path: Path, capsys: Capture
) -> None:
    ball = ("--body", "sphere 1 mm", "--points", "64", "--size", "150 um")
    more = (*ball, *YIELDING, "--ceiling", "calibrated")
    assert app.main(["solve", *more, "--load", "10 N", "--verbose"]) == app.SOLVED
    output = " ".join(capsys.readouterr().out.split())
    assert re.search(r"2\.\d+ GPa, calibrated: 2\.\d+ yield strengths at \d+ times first", output)
    assert re.search(r"With three yield strengths contact area [^(]+µm² \(−\d+ %\), appr", output)
    sweep = ("--from", "5 N", "--to", "10 N", "--steps", "2", "--output", str(tmp_path / "c.csv"))
    assert app.main(["sweep", *more, *sweep]) == app.SOLVED
    assert "pressure_ceiling [Pa]" in (tmp_path / "c.csv").read_text(encoding="utf-8")
    capsys.readouterr()
    assert app.main(["history", *more, "--path", "10 N, 0 N", "--json"]) == app.SOLVED
    found = json.loads(capsys.readouterr().out)
    assert found["calibration"]["factor"] == pytest.approx(found["ceiling"] / 1e9)
    assert CautionTag.INDENTATION in {caution["kind"] for caution in found["cautions"]}
    assert app.main(["stress", *more, "--load", "10 N", "--json"]) == app.SOLVED
    assert json.loads(capsys.readouterr().out)["calibration"]["load"] == 10
    words = "--ceiling calibrated needs the yield strength of the softer body"
    assert app.main(["solve", *ball, *STEEL, "--ceiling", "calibrated", "--load", "10 N"]) == 2
    assert words in " ".join(capsys.readouterr().err.split())


def test_quiet_prints_nothing(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    assert solve(rough, *STEEL, "--quiet", "--output", str(tmp_path / "out.nc")) == app.SOLVED
    assert capsys.readouterr() == ("", "")
    assert (tmp_path / "out.nc").exists()


def test_names_with_markup_and_control_characters_stay_harmless(
    tmp_path: Path, capsys: Capture
) -> None:
    path = tmp_path / "[red]a[nonsense]\x1b[2J.npy"
    np.save(path, bumps())
    assert solve(path, *STEEL) == app.SOLVED
    out = capsys.readouterr().out
    assert "[red]a[nonsense]" in out
    assert "\x1b" not in out


def test_progress_appears_on_terminal_only(
    rough: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    # With this Rich would take a pipe for a terminal.
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert solve(rough, *STEEL, "--json") == app.SOLVED
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert solve(rough, *STEEL, "--json") == app.SOLVED
    out, err = capsys.readouterr()
    json.loads(out)
    assert "solving" in err
    assert "certificate" in err


# Files


@pytest.mark.long
def test_output_and_figures_are_written(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    before = files(tmp_path)
    output = tmp_path / "out.nc"
    figures = ("--figures", str(tmp_path / "run1"))
    assert solve(rough, *YIELDING, "--output", str(output), *figures) == app.SOLVED
    names = {f"run1-{figure}.png" for figure in FIGURES}
    assert files(tmp_path) - before == {"out.nc", *names}
    out = capsys.readouterr().out
    assert all(name in out for name in ("out.nc", *names))
    result = read_result(output)
    assert result.converged
    assert result.load == 0.1
    for name in names:
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.long
def test_demo_writes_and_explains_both_solutions(tmp_path: Path, capsys: Capture) -> None:
    folder = tmp_path / "demo"
    assert app.main(["demo", "--folder", str(folder), "--points", "64"]) == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    names = {
        *[
            "ground.x3p",
            "elastic.nc",
            "ceiling.nc",
            "surface.png",
            "comparison.png",
            "histogram.png",
            "overview.png",
        ]
    }
    assert files(folder) == names
    assert all(name in out for name in names)
    assert width(out) <= 80
    elastic, limited = (read_result(folder / name) for name in ("elastic.nc", "ceiling.nc"))
    assert elastic.ceiling is None
    assert limited.ceiling == 3e9
    assert elastic.load == limited.load == 1.0
    assert elastic.surface.size == pytest.approx((1e-4, 1e-4))
    assert (elastic.contact <= limited.contact).mean() > 0.99


SMALL_BALL = ("--body", "sphere 10 mm", "--points", "16", "--size", "0.4 mm")
WRITERS: dict[str, tuple[tuple[str, ...], dict[str, str]]] = {
    "solve": (("solve", *SMALL_BALL, "--load", "1 N", *YIELDING), {"--output": "a.nc"}),
    "sweep": (
        ("sweep", *SMALL_BALL, "--from", "1 N", "--to", "2 N", "--steps", "2", *YIELDING),
        {"--output": "a.csv", "--figure": "a.png"},
    ),
    "stress": (("stress", *SMALL_BALL, "--load", "1 N", *YIELDING), {"--output": "a.nc"}),
    "history": (
        ("history", *SMALL_BALL, "--path", "1 N", *YIELDING),
        {"--output": "a.csv", "--indented-surface": "a.nc"},
    ),
    "volume": (
        (
            *shlex.split("solve --model elastoplastic --set increments=1"),
            *SMALL_BALL,
            "--load",
            "1 N",
            *YIELDING,
        ),
        {"--output": "a.nc"},
    ),
    "demo": (("demo", "--points", "32"), {"--folder": "files"}),
    "run": (("run",), {}),
}


@pytest.mark.parametrize(
    ("command", "length"),
    [
        *((command, 200) for command in WRITERS if command not in ("demo", "run")),
        ("solve", 0),
        ("solve", 60),
        pytest.param("demo", 200, marks=pytest.mark.long),
        pytest.param("run", 200, marks=pytest.mark.process),
    ],
)
def test_paths_are_unbroken_on_separate_lines(
    command: str, length: int, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A short path is relative to the working folder.
    monkeypatch.chdir(tmp_path)
    folder = Path()
    if length:
        folder = tmp_path / "folder of a name"
        folder /= "x" * max(length - len(str(folder)) - 1, 1)
        folder.mkdir(parents=True)
    arguments, options = WRITERS[command]
    named = {option: folder / name for option, name in options.items()}
    written = [str(path) for path in named.values()]
    words = [*arguments, *(word for pair in named.items() for word in map(str, pair))]
    if command == "run":
        np.save("rough.npy", bumps())
        (tmp_path / "p.toml").write_text(
            f"folder = '{folder / 'files'}'\n[[contact]]\nname = 'one'\nfile = 'rough.npy'\n"
            "unit = 'um'\nsize = '0.1 mm x 0.2 mm'\nload = '1 N'\nyoung = '210 GPa'\n"
            "poisson = 0.3\n",
            encoding="utf-8",
        )
        words.append("p.toml")
        written = [str(folder / "files")]
    assert app.main(words) == app.SOLVED
    assert set(written) <= set(capsys.readouterr().out.splitlines())
    assert all(Path(path).exists() for path in written)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--points", "31"), ("--points", "from 32 to 32768, got 31")),
        (("--points", "many"), ("--points", "whole number", "'many'")),
        (("--folder", "absent/demo"), ("--folder", "'absent' does not exist")),
    ],
)
def test_demo_refuses(
    options: tuple[str, ...],
    words: tuple[str, ...],
    tmp_path: Path,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_rejected(capsys, app.main(["demo", *options]), *words)
    assert files(tmp_path) == set()


# Usage and bad input


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["solve"], ["FILE", "roughcontact solve --help"]),
        (["press"], ["press", "roughcontact --help"]),
        (["solve", "a.npy", "--laod", "1 N"], ["--laod"]),
        (["info"], ["FILE"]),
    ],
)
def test_usage_errors_return_2(arguments: list[str], words: list[str], capsys: Capture) -> None:
    assert_rejected(capsys, app.main(arguments), *words)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--load", "1 mm", *STEEL), ("--load needs a load such as", "'1 mm' (a length)")),
        (("--load", "1", *STEEL), ("--load", "'1' which has no unit")),
        (("--load", "-1 N", *STEEL), ("--load must be positive", "'-1 N'")),
        (("--load", "nan N", *STEEL), ("--load", "'nan N'")),
        (("--approach", "1 N", *STEEL), ("--approach needs a length", "'1 N'")),
        (STEEL, ("--load", "--approach")),
        (("--load", "1 N", "--young", "210", "--poisson", "0.3"), ("--young", "'210'", "no unit")),
        (("--load", "1 N", "--young", "2 GPa", "--poisson", "0.7"), ("--poisson", "0.7", "0.5]")),
        (("--load", "1 N", "--young", "2 GPa"), ("--poisson is needed",)),
        (("--load", "1 N", "--poisson", "0.3"), ("--young is needed",)),
        (
            ("--load", "1 N", *STEEL, "--set", "counter-young=1 GPa"),
            ("--set counter-poisson is needed",),
        ),
        (
            (
                "--load",
                "1 N",
                *STEEL,
                "--set",
                "counter-young=1 GPa",
                "--set",
                "counter-poisson=-1",
            ),
            ("--set counter-poisson", "-1.0"),
        ),
        (("--load", "1 N", *STEEL, "--ceiling", "3"), ("--ceiling", "'3'", "no unit")),
        (("--load", "1 N", *STEEL, "--boundary", "open"), ("--boundary", "periodic", "'open'")),
        (("--load", "1 N", *STEEL, "--set", "tolerance=0"), ("--set tolerance", "positive", "0.0")),
        (("--load", "1 N", *STEEL, "--crop", "1:9"), ("--crop", "0:256,100:356", "'1:9'")),
        (("--load", "1 N", *STEEL, "--crop", "0:99,0:9"), ("--crop must be within 0 to ", "0:99")),
        (("--load", "1 N", *STEEL, "--set", "channel=phase"), ("rough.npy", "'phase'")),
        (
            ("--load", "1 N", *STEEL, "--set", "format=docx"),
            ("--set format must be one of", "'docx'"),
        ),
        # 0.1 mm × 0.2 mm under 3 GPa carries 60 N.
        (("--load", "61 N", *YIELDING), ("--load = 61 N", "60 N")),
    ],
)
def test_invalid_arguments_are_rejected_in_one_sentence(
    options: tuple[str, ...], words: tuple[str, ...], rough: Path, tmp_path: Path, capsys: Capture
) -> None:
    output = ("--output", str(tmp_path / "out.nc"))
    status = app.main(["solve", str(rough), *SCALE, *options, *output])
    assert_rejected(capsys, status, *words)
    assert files(tmp_path) == {"rough.npy"}


@pytest.mark.parametrize("command", ["solve", "info"])
@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("absent.opd", None, ("absent.opd", "does not exist")),
        ("empty.npy", b"", ("empty.npy", "empty")),
        ("cut.npy", "the first half", ("cut.npy", "cannot be read")),
        ("note.npy", b"no numbers here", ("note.npy", "cannot be read")),
        ("map.doc", b"words", ("map.doc", "'words'")),
        ("text.csv", b"high,low\n", ("text.csv", "'high'")),
        ("row.csv", b"1,2,3\n", ("row.csv", "shape (1, 3)")),
        ("infinite.npy", np.array([[1.0, np.inf], [1, 2]]), ("infinite.npy", "1 infinite")),
        ("complex.npy", np.ones((3, 3)) * 1j, ("complex.npy", "complex128")),
    ],
)
def test_invalid_files_are_rejected_in_one_sentence(
    command: str,
    name: str,
    content: bytes | str | np.ndarray | None,
    words: tuple[str, ...],
    tmp_path: Path,
    capsys: Capture,
) -> None:
    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif isinstance(content, str):
        np.save(path, bumps())
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    elif content is not None:
        np.save(path, content)
    options = ["--load", "1 N", *STEEL] if command == "solve" else []
    assert_rejected(capsys, app.main([command, str(path), *SCALE, *options]), *words)


def test_missing_unit_or_size_names_option(rough: Path, capsys: Capture) -> None:
    options = ["solve", str(rough), "--load", "1 N", *STEEL]
    assert_rejected(capsys, app.main(options), "no unit", "--unit um")
    assert_rejected(capsys, app.main([*options, "--unit", "um"]), "--size '0.1 mm x 0.2 mm'")
    assert_rejected(capsys, app.main([*options, "--unit", "s"]), "--unit needs a length")


def test_holes_without_choice_are_rejected(map_with_holes: Path, capsys: Capture) -> None:
    choices = ("holed.npy has 3 missing points", "--missing fill", "--missing mask", "--crop")
    assert_rejected(capsys, solve(map_with_holes, *STEEL), *choices)
    for options, steps in (
        (("--missing", "fill"), ["filled: 3 missing points by harmonic interpolation"]),
        (("--missing", "mask"), ["masked: 3 missing points never touch"]),
    ):
        assert solve(map_with_holes, *STEEL, *options, "--json") == app.SOLVED
        assert json.loads(capsys.readouterr().out)["preparation"][1:] == steps
    assert solve(map_with_holes, *STEEL, "--crop", "8:,:") == app.SOLVED


def test_bodies_on_unequal_grids_are_rejected(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    other = tmp_path / "other.npy"
    np.save(other, bumps()[:20])
    status = solve(rough, *STEEL, "--counter-surface", str(other))
    assert_rejected(
        capsys, status, "--counter-surface has 20 × 64 points", "40 × 64", "--align resamples one"
    )


@pytest.mark.parametrize(
    ("option", "name", "words"),
    [
        ("--output", "absent/out.nc", ("--output", "absent", "does not exist")),
        ("--output", "out.txt", ("--output", ".nc", "out.txt")),
        ("--output", "folder.nc", ("--output", "folder.nc", "is a folder")),
        ("--figures", "absent/run1", ("--figures", "absent", "does not exist")),
        ("--figures", "absent/", ("--figures", "absent", "does not exist")),
    ],
)
def test_outputs_are_checked_before_the_solve(
    option: str,
    name: str,
    words: tuple[str, ...],
    rough: Path,
    tmp_path: Path,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "folder.nc").mkdir()
    monkeypatch.setattr(contact, "solve", lambda *_, **__: pytest.fail("solved"))
    assert_rejected(capsys, solve(rough, *STEEL, option, f"{tmp_path}/{name}"), *words)


def test_output_never_replaces_the_input(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "out.nc"
    assert solve(rough, *STEEL, "--output", str(source)) == app.SOLVED
    capsys.readouterr()
    before = source.read_bytes()
    status = app.main(["solve", str(source), "--load", "1 N", *STEEL, "--output", str(source)])
    assert_rejected(capsys, status, "--output", "is an input file")
    assert source.read_bytes() == before


# Runs that do not end well


def test_not_converged_shows_the_best_and_writes_nothing(
    rough: Path, tmp_path: Path, capsys: Capture
) -> None:
    output = tmp_path / "out.nc"
    output.write_text("an older result")
    terms = f"--set max-iterations=2 --set tolerance=1e-12 --output {output}"
    options = (*YIELDING, *terms.split())
    assert solve(rough, *options, "--figures", str(tmp_path / "run1")) == app.NOT_CONVERGED
    out, err = capsys.readouterr()
    assert "Not converged: certificate" in out
    assert "Contact pressure" in out
    assert err.startswith("roughcontact: error: not converged: certificate")
    assert "--set max-iterations" in err
    assert "no file was written" in err
    assert err.count("\n") == 1
    assert output.read_text() == "an older result"
    assert files(tmp_path) == {"rough.npy", "out.nc"}
    assert solve(rough, *options, "--json") == app.NOT_CONVERGED
    record = json.loads(capsys.readouterr().out)
    assert record["converged"] is False
    assert record["certificate"] > 1e-12
    assert record["written"] == []


def test_full_disk_is_reported_after_numbers(
    rough: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    output = tmp_path / "out.nc"
    output.write_text("an older result")
    monkeypatch.setattr("roughcontact._tools.files.os.fsync", full)
    assert solve(rough, *STEEL, "--output", str(output)) == app.BAD_INPUT
    out, err = capsys.readouterr()
    assert "Contact pressure" in out
    assert "written" not in out
    assert err.count("\n") == 1
    assert "out.nc cannot be written (No space left on device)" in err
    assert output.read_text() == "an older result"
    assert files(tmp_path) == {"rough.npy", "out.nc"}


def interrupt(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def interrupted_solver() -> Callable[..., Any]:
    original = contact.bounded.solve

    def solver(*arguments: Any, progress: Callable[[Step], None], **options: Any) -> Any:
        return original(*arguments, progress=interrupt, **options)

    return solver


def test_an_interrupted_solve_writes_nothing(
    rough: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(contact.bounded, "solve", interrupted_solver())
    output = tmp_path / "out.nc"
    output.write_text("an older result")
    assert solve(rough, *STEEL, "--output", str(output)) == app.INTERRUPTED
    assert capsys.readouterr() == ("", "roughcontact: interrupted; nothing was written\n")
    assert output.read_text() == "an older result"
    assert files(tmp_path) == {"rough.npy", "out.nc"}
    folder = tmp_path / "demo"
    assert app.main(["demo", "--folder", str(folder), "--points", "64"]) == app.INTERRUPTED
    assert not folder.exists()


@pytest.mark.long
def test_interrupted_write_lists_complete_files(
    rough: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(maps, "gap", interrupt)
    output = tmp_path / "out.nc"
    options = ("--output", str(output), "--figures", str(tmp_path / "run1"))
    assert solve(rough, *STEEL, *options) == app.INTERRUPTED
    err = capsys.readouterr().err
    complete = {"out.nc", "run1-surface.png", "run1-pressure.png", "run1-contact.png"}
    assert all(name in err for name in complete)
    assert "run1-gap.png" not in err
    assert files(tmp_path) == {"rough.npy", *complete}
    monkeypatch.setattr(archive, "to_dataset", interrupt)
    assert solve(rough, *STEEL, "--output", str(tmp_path / "new.nc")) == app.INTERRUPTED
    assert capsys.readouterr().err == "roughcontact: interrupted; nothing was written\n"
    assert files(tmp_path) == {"rough.npy", *complete}


def test_an_interruption_names_few_of_many_files(
    rough: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*arguments: Any, **named: Any) -> Any:
        raise outputs.UnfinishedError([Path(f"{number}.json") for number in range(1000)])

    monkeypatch.setattr(run, "run_request", stop)
    assert solve(rough, *STEEL) == app.INTERRUPTED
    err = capsys.readouterr().err
    assert err.endswith("6.json, 7.json and 992 more were written\n")
    assert err.count(".json") == 8


def test_insufficient_memory_is_reported_in_one_sentence(
    rough: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as scarce:
        scarce.setattr(memory, "free_bytes", lambda: 10**6)
        assert_rejected(capsys, solve(rough, *STEEL), "40 × 64 points", "GiB are free", "fits")

    def exhausted(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr(contact, "solve_case", exhausted)
    assert_rejected(capsys, solve(rough, *STEEL), "memory", "--crop", "--set precision=single")


# Measured files


def test_a_wrong_size_in_a_file_is_replaced(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "wrong.nc"
    roughcontact.read_surface(rough, unit="um", size=(1e-2, 2e-2)).save(path)
    size = ("--size", "0.1 mm x 0.2 mm")
    words = ("--load", "1 N", *STEEL)
    assert_rejected(
        capsys, app.main(["solve", str(path), *words, *size]), "--set override-size as well"
    )
    assert_rejected(
        capsys, app.main(["solve", str(path), *words, "--set", "override-size"]), "needs a FILE"
    )
    command = ["solve", str(path), *words, *size, "--set", "override-size", "--verbose"]
    assert app.main(command) == app.SOLVED
    output = " ".join(capsys.readouterr().out.split())
    assert "Size (y × x) 100 µm × 200 µm" in output
    assert "10 mm × 20 mm, as the file gives them" in output
    assert app.main(["info", str(path), *size, "--set", "override-size", "--json"]) == app.SOLVED
    assert json.loads(capsys.readouterr().out)["size"] == pytest.approx([1e-4, 2e-4])


def test_info_warns_about_impossible_heights(tmp_path: Path, capsys: Capture) -> None:
    heights = np.random.default_rng(1).standard_normal((40, 40))
    np.save(tmp_path / "map.npy", heights)
    given = ["info", str(tmp_path / "map.npy"), "--size", "0.1 mm", "--unit"]
    for unit, warned in (("nm", False), ("um", False), ("mm", True)):
        assert app.main([*given, unit]) == app.SOLVED
        out = " ".join(capsys.readouterr().out.split())
        assert ("WARNING units: " in out) == warned
    # Of one row of points likewise.
    np.savetxt(tmp_path / "line.txt", np.c_[np.arange(40) * 1e-6, 1e-4 * heights[0]])
    assert app.main(["info", str(tmp_path / "line.txt"), "--unit", "m, m"]) == app.SOLVED
    assert "WARNING units: " in " ".join(capsys.readouterr().out.split())


def test_info_shows_size_and_roughness(map_with_holes: Path, capsys: Capture) -> None:
    assert app.main(["info", str(map_with_holes), *SCALE, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    heights = np.load(map_with_holes) * 1e-6
    assert record["shape"] == [40, 64]
    assert record["pixel"] == pytest.approx([2.5e-6, 3.125e-6])
    assert record["size"] == pytest.approx([1e-4, 2e-4])
    assert record["height_min"] == pytest.approx(np.nanmin(heights))
    assert record["height_max"] == pytest.approx(np.nanmax(heights))
    assert record["Sq"] == pytest.approx(np.nanstd(heights))
    assert record["Sq_leveled"] < record["Sq"]
    surface = roughcontact.read_surface(map_with_holes, unit="um", size=(1e-4, 2e-4)).leveled()
    assert record["roughness_leveled"] == pytest.approx(surface.roughness())
    assert app.main(["info", str(map_with_holes), *SCALE, "--verbose"]) == app.SOLVED
    assert "reduced height of the peaks above the core" in capsys.readouterr().out
    assert record["missing"] == 3
    assert len(record["channels"]) == 1


def test_info_advises_options_of_solve(tmp_path: Path, capsys: Capture) -> None:
    waves, (pixel, _) = roughcontact.reference_map(64)
    noise = 0.02 * waves.std() * np.random.default_rng(3).normal(size=waves.shape)
    np.save(tmp_path / "noisy.npy", waves + noise)
    size = f"{64 * pixel} m"
    assert app.main(["info", str(tmp_path / "noisy.npy"), "--unit", "m", "--size", size]) == 0
    assert "Use --s-filter '" in capsys.readouterr().out


def test_info_of_several_files_prints_a_row_each(tmp_path: Path, capsys: Capture) -> None:
    folder = Path(__file__).parents[1] / "data"
    files = [str(folder / name) for name in ("keyence_vk.csv", "zygo_format1.xyz")]
    assert app.main(["info", *files]) == app.SOLVED
    out = capsys.readouterr().out.replace("\N{NO-BREAK SPACE}", " ")
    assert re.search(r"keyence_vk.csv +16×24 +276.9 nm +none +43.9 nm +265 nm +none", out)
    assert "1 of 2 files ready to solve, 1 with the options" in " ".join(out.split())
    (tmp_path / "a.pdf").write_bytes(b"%PDF-1.7")
    assert app.main(["info", *files, str(tmp_path / "a.pdf"), "--json"]) == app.BAD_INPUT
    shown = capsys.readouterr()
    records = json.loads(shown.out)["files"]
    assert [record.get("shape") for record in records] == [[16, 24], [16, 24], None]
    assert "a.pdf is a PDF document" in records[2]["error"]
    assert "a.pdf is a PDF document" in shown.err


def test_solve_of_several_files_prints_a_row_each(tmp_path: Path, capsys: Capture) -> None:
    for name, seed in (("a.npz", 1), ("b.npz", 2)):
        heights, pixel = roughcontact.reference_map(32, seed)
        roughcontact.Surface(heights, pixel).save(tmp_path / name)
    files = [str(tmp_path / name) for name in ("a.npz", "b.npz")]
    assert app.main(["solve", *files, *FLAT, "--json"]) == app.SOLVED
    records = json.loads(capsys.readouterr().out)["files"]
    alone = [app.main(["solve", file, *FLAT, "--json"]) for file in files]
    assert alone == [app.SOLVED] * 2
    assert [record["source"] for record in records] == ["a.npz", "b.npz"]
    assert app.main(["solve", *files, str(tmp_path / "none.npz"), *FLAT]) == app.BAD_INPUT
    shown = capsys.readouterr()
    text = " ".join(shown.out.split())
    assert "2 of 3 files solved; " in text
    assert re.search(r"CAUTION \w+: [^.]*\([12] of 2 files, ", text)
    assert "none.npz does not exist" in shown.err
    status = app.main(["solve", *files, *FLAT, "--output", str(tmp_path / "a.nc")])
    assert_rejected(capsys, status, "--output takes the result of one file")


NO_DATA = Path(__file__).parents[1] / "data" / "nodata_int16.csv"
FLAT = ("--load", "50 MPa", "--boundary", "periodic", "--material", "42CrMo4")


def options_in(text: str) -> list[str]:
    """Return the options that a headline of `info` names, as a shell would split them."""
    return text.split("solve it with ")[1].split(". ")[0].split()


def test_info_and_solve_name_the_value_of_missing_points(capsys: Capture) -> None:
    given = [str(NO_DATA), "--unit", "um", "--size", "64 um"]
    assert app.main(["info", *given]) == app.SOLVED
    out = " ".join(capsys.readouterr().out.split())
    assert "0.293 % missing (12 points at -32.768); solve it with " in out
    assert_rejected(capsys, app.main(["solve", *given, *FLAT]), "-32.768 at 12 points")
    advice = options_in(out)
    assert advice == ["--no-data", "-32.768", "--missing", "fill"]
    assert app.main(["solve", *given, *FLAT, *advice, "--json"]) == app.SOLVED
    # As a map without these points; 367 nm with pits at -32.768 µm.
    assert json.loads(capsys.readouterr().out)["mean_gap"] == pytest.approx(195e-9, rel=5e-3)
    assert app.main(["info", *given, "--json"]) == app.SOLVED
    shown = json.loads(capsys.readouterr().out)
    assert (shown["no_data"], shown["missing"], shown["cautions"]) == ([-32.768], 12, [])


def test_info_advises_removal_of_spikes_that_solve_finds(tmp_path: Path, capsys: Capture) -> None:
    heights = np.random.default_rng(3).normal(size=(64, 64))
    heights[[5, 20, 40], [7, 50, 31]] = 60.0
    np.save(tmp_path / "spiky.npy", heights)
    given = [str(tmp_path / "spiky.npy"), "--unit", "nm", "--size", "64 um"]
    assert app.main(["info", *given]) == app.SOLVED
    out = " ".join(capsys.readouterr().out.split())
    assert "WARNING spikes: " in out
    advice = options_in(out)
    assert advice == ["--outliers", "6", "--missing", "fill"]
    assert app.main(["solve", *given, *FLAT]) == app.SOLVED
    assert f"Remove with {' '.join(advice)}." in " ".join(capsys.readouterr().out.split())
    assert app.main(["solve", *given, *FLAT, *advice]) == app.SOLVED
    assert "spikes" not in capsys.readouterr().out


@pytest.mark.parametrize("spikes", [0, 3])
def test_info_advises_filling_of_any_share(spikes: int, tmp_path: Path, capsys: Capture) -> None:
    heights = np.random.default_rng(3).normal(size=(64, 64))
    heights.flat[1000 : 1000 + 70 * spikes : 70] = 60.0
    heights[40:] = np.nan
    np.save(tmp_path / "half.npy", heights)
    given = [str(tmp_path / "half.npy"), "--unit", "nm", "--size", "64 um"]
    assert app.main(["info", *given]) == app.SOLVED
    out = " ".join(capsys.readouterr().out.split())
    assert "--missing fill-all" in out
    assert_rejected(capsys, app.main(["solve", *given, *FLAT]), "--missing fill-all")
    advice = options_in(out) if spikes else ["--missing", "fill-all"]
    assert app.main(["solve", *given, *FLAT, *advice, "--quiet"]) == app.SOLVED


@needs_reader
def test_info_prints_the_table_of_a_measured_file(capsys: Capture) -> None:
    assert app.main(["info", str(measurement("uncd_afm.001")), "--verbose"]) == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    assert width(out) <= 80
    for words in (
        "512 × 512 points",
        "195.3 pm × 195.3 pm",
        "−1.761 µm to −1.648 µm",
        "27.79 nm, after plane 4.688 nm",
        "0: Height [nm]",
        "2: Phase, no heights",
    ):
        assert words in out


@pytest.mark.long
@needs_reader
@pytest.mark.parametrize("ceiling", ["auto", "none"])
@pytest.mark.parametrize(
    ("name", "load"),
    [
        ("wyko_nt1100_test_1.opd", "1 N"),
        ("x3p-2.x3p", "1 N"),
        ("sur-2.sur", "1 N"),
        ("metropro-1.dat", "1 N"),
        # 100 nm × 100 nm under 3 GPa carries 30 µN.
        ("uncd_afm.001", "1 uN"),
    ],
)
def test_measured_files_are_solved(name: str, load: str, ceiling: str, capsys: Capture) -> None:
    arguments = ["--load", load, *YIELDING, "--missing", "fill", "--ceiling", ceiling, "--json"]
    assert app.main(["solve", str(measurement(name)), *arguments]) == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    record = json.loads(out, parse_constant=pytest.fail)
    assert record["source"] == name
    assert record["certificate"] <= 1e-6
    assert record["load_error"] <= 1e-10
    if ceiling == "auto":
        assert record["max_pressure"] <= 3e9
        assert record["saturated_fraction"] > 0
    else:
        assert record["saturated_fraction"] == 0
        assert record["max_pressure"] > 3e9


@needs_reader
@pytest.mark.parametrize("command", ["solve", "info"])
def test_damaged_measurement_is_rejected_in_one_sentence(
    command: str, tmp_path: Path, capsys: Capture
) -> None:
    name = "di_corrupted.di"
    options = ["--load", "1 N", *STEEL, "--output", str(tmp_path / "out.nc")]
    arguments = [command, str(measurement(name)), *(options if command == "solve" else [])]
    assert_rejected(capsys, app.main(arguments), name)
    assert files(tmp_path) == set()


# Preparation, study, sweep


def test_every_preparation_reaches_the_library_in_its_order(
    map_with_holes: Path, capsys: Capture
) -> None:
    options = (
        *shlex.split(
            "--crop 0:36,0:60 --outliers 5 --level robust --form 'polynomial 3' --missing fill "
            "--s-filter '12 um' --l-filter '80 um' --pixel '2 um' "
            "--set rotate=90 --set invert --set flip=x"
        ),
    )
    assert solve(map_with_holes, *STEEL, *options, "--json") == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    starts = [step.split(":")[0] for step in record["preparation"]]
    assert starts == [
        "inverted",
        "cropped",
        "outliers removed",
        "leveled",
        "form removed",
        "filled",
        "filtered",
        "resampled",
        "flipped",
        "rotated",
    ]
    surface = roughcontact.read_surface(map_with_holes, unit="um", size=(1e-4, 2e-4))
    prepared = (
        surface.inverted()
        .cropped((0, 36), (0, 60))
        .without_outliers(5)
        .leveled("robust")
        .without_form("polynomial", 3)
        .filled()
        .filtered(12e-6, 80e-6)
        .resampled(pixel=(2e-6, 2e-6), method="spline")
        .flipped("x")
        .rotated()
    )
    assert record["shape"] == list(prepared.shape)
    result = roughcontact.solve(prepared, load=0.1, material=roughcontact.Material(210e9, 0.3))
    assert record["max_pressure"] == result.max_pressure


def test_holes_can_be_cut_away(map_with_holes: Path, capsys: Capture) -> None:
    assert solve(map_with_holes, *STEEL, "--missing", "crop", "--json") == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert record["preparation"][0].startswith("cropped to the largest rectangle without holes")


def sweep(path: Path, *options: str) -> int:
    ends = {"--from": "10 mN", "--to": "1 N"}
    missing = [word for end in ends.items() if end[0] not in options for word in end]
    return app.main(["sweep", str(path), *SCALE, *STEEL, *missing, *options])


def test_sweep_output_matches_library(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    output, workbook, folder = tmp_path / "curve.csv", tmp_path / "curve.xlsx", tmp_path / "steps"
    written = ("--output", str(output), "--output", str(workbook))
    assert sweep(rough, "--steps", "4", *written, "--folder", str(folder)) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert width(out) <= 80
    assert "The contact grows from" in out
    assert files(folder) == {"sweep.json", *(f"step-{n:04d}.npz" for n in range(1, 5))}
    table = np.genfromtxt(output, delimiter=",", names=True, deletechars="")
    surface = roughcontact.read_surface(rough, unit="um", size=(1e-4, 2e-4)).leveled()
    curve = roughcontact.sweep(
        surface, material=roughcontact.Material(210e9, 0.3), loads=np.geomspace(0.01, 1, 4)
    )
    assert table["load_[N]"] == pytest.approx(curve.column("load"))
    assert table["contact_area_[m²]"] == pytest.approx(curve.column("contact_area"))
    head, *rows = openpyxl.load_workbook(workbook).active.values
    loads = dict(zip(head, zip(*rows, strict=True), strict=True))["load [N]"]
    assert loads == pytest.approx(tuple(table["load_[N]"]))
    assert sweep(rough, "--steps", "4", "--folder", str(folder), "--json") == 0
    record = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert record["contact_area"] == table["contact_area_[m²]"].tolist()


Rows = list[tuple[tuple[str, ...], tuple[str, ...]]]
PREPARATIONS: Rows = [
    (("--form", "cone"), ("--form must be sphere", "'cone'")),
    (("--form", "polynomial"), ("--form must be",)),
    (("--form", "polynomial ²"), ("--form must be", "got 'polynomial ²'")),
    (("--outliers", "many"), ("--outliers must be a number",)),
    (("--set", "rotate=45"), ("--set rotate must be a multiple of 90",)),
    (("--s-filter", "3"), ("--s-filter needs a length", "no unit")),
    (("--pixel", "1 N"), ("--pixel needs a length", "(a force)")),
    (("--pixel", "1 m"), ("--pixel must be at most half the map",)),
    (
        ("--pixel", "1 m", "--model", "elastoplastic", "--yield-strength", "1 GPa"),
        ("--pixel must be at most half the map",),
    ),
    (("--s-filter", "1 nm"), ("--s-filter must be between",)),
    (("--body", "sphere 10"), ("--body", "no unit")),
    (("--body", "torus 1 mm"), ("--body must read like one of", "'torus 1 mm'")),
    (("--points", "64"), ("--points needs a nominal --body",)),
    (("--counter-body", "cone 1 mm"), ("--counter-body",)),
]
SWEEPS: Rows = [
    (("--from", "1 J"), ("--from needs a load", "'1 J' (a moment or an energy)")),
    (("--from", "1 MPa"), ("both be loads of one form or both approaches",)),
    (("--from", "1 um"), ("both be loads of one form or both approaches",)),
    (("--to", "1"), ("--to needs a load", "no unit")),
    (("--to", "1 mN"), ("must be positive and below --to",)),
    (("--steps", "1"), ("from 2 to 10000",)),
    (("--steps", "few"), ("--steps must be a whole number",)),
    (("--spacing", "cubic"), ("spacing", "'cubic'")),
    (("--output", "curve.nc"), ("--output needs a name that ends in .csv, .xlsx or .json",)),
    (("--output", "absent/curve.csv"), ("'absent' does not exist",)),
]
VOLUMES: Rows = [
    (("--set", "increments=3"), ("--model elastoplastic",)),
    (("--unload",), ("--unload needs --model elastoplastic",)),
    (("--model", "both"), ("--model must be one of",)),
    (
        ("--model", "elastoplastic", "--set", "increments=0"),
        ("--set increments must be a whole number from 1",),
    ),
    (
        ("--model", "elastoplastic", "--set", "increments=some"),
        ("a whole number, or auto", "'some'"),
    ),
    (("--model", "elastoplastic", "--ceiling", "3 GPa"), ("--ceiling needs --model ceiling",)),
    (
        ("--model", "elastoplastic", "--output", "out.npz"),
        ("ends in .nc, .vtr, .vti, .csv or .json",),
    ),
    (
        ("--output", "out.vtr"),
        ("ends in .nc, .vti, .csv or .json, got 'out.vtr'", ".vtr needs --model elastoplastic"),
    ),
    (("--folder", "steps"), ("--folder needs --model elastoplastic",)),
    (("--model", "elastoplastic", "--folder", __file__), (f"--folder {__file__} is a file",)),
    (
        ("--model", "elastoplastic", "--folder", f"{__file__}/steps"),
        (f"--folder {__file__}/steps cannot be written to", "give another folder"),
    ),
    (
        ("--model", "elastoplastic", "--report", "out.txt"),
        ("--report needs a name that ends in .html",),
    ),
    (("--model", "elastoplastic", "--study"), ("--study needs --model ceiling",)),
    (("--model", "elastoplastic", "--hardening", "linear 2"), ("--hardening",)),
    (("--model", "elastoplastic", "--hardening", "linear -2 GPa"), ("--hardening", "positive")),
    (("--model", "elastoplastic", "--hardening", "swift 1 GPa 20 3"), ("--hardening: exponent",)),
    (
        ("--model", "elastoplastic", "--hardening", "swift 945 MPa 20 0.121"),
        ("--hardening starts at a yield strength of 1.358 GPa", "leave --yield-strength out"),
    ),
    (("--model", "elastoplastic", "--set", "max-iterations=0"), ("--set max-iterations must be",)),
    (("--model", "elastoplastic", "--set", "tolerance=1e-9"), ("--set precision=double",)),
    (("--model", "elastoplastic", "--hardening", "steel"), ("--hardening must read like",)),
    (
        ("--model", "elastoplastic", "--hardening", "kinematic 1 GPa, kinematic 2 GPa"),
        ("--hardening must read like", "'kinematic 10 GPa'"),
    ),
    (("--model", "elastoplastic", "--hardening", "kinematic -1 GPa"), ("--hardening", "positive")),
]


@pytest.mark.parametrize(
    ("command", "options", "words"),
    [("solve", *row) for row in PREPARATIONS]
    + [("sweep", *row) for row in SWEEPS]
    + [("volume", *row) for row in VOLUMES],
)
def test_invalid_options_are_rejected_in_one_sentence(
    command: str, options: tuple[str, ...], words: tuple[str, ...], rough: Path, capsys: Capture
) -> None:
    if command == "sweep":
        status = sweep(rough, *options)
    else:
        status = solve(rough, *(STEEL if command == "solve" else YIELDING), *options)
    assert_rejected(capsys, status, *words)


def test_repeated_single_option_is_rejected(rough: Path, capsys: Capture) -> None:
    assert_rejected(
        capsys, solve(rough, *STEEL, "--load", "1 N"), "--load is given 2 times", "0.1 N, 1 N"
    )


# Bodies and materials


def test_nominal_bodies_need_no_file(capsys: Capture) -> None:
    options = ("--body", "sphere 10 mm", "--points", "64x96", "--size", "0.2 mm x 0.3 mm")
    assert app.main(["solve", *options, "--load", "1 N", *YIELDING, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert record["shape"] == [64, 96]
    radius = 10e-3
    peak = (6 * 1.0 * (210e9 / 0.91) ** 2 / (np.pi**3 * radius**2)) ** (1 / 3)
    assert record["max_pressure"] == pytest.approx(peak, rel=0.01)
    assert record["source"] == "nominal sphere of radius 10 mm"


def test_roughness_on_nominal_bodies(rough: Path, capsys: Capture) -> None:
    options = ("--body", "sphere 10 mm", "--counter-body", "cylinder 5 mm 90 deg", "--json")
    assert solve(rough, *STEEL, *options) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert record["preparation"][-1] == "form added: nominal sphere of radius 10 mm"
    assert record["counter_source"].startswith("nominal cylinder of radius 5 mm")


def test_maps_of_different_grids_are_aligned(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    other = tmp_path / "other.npy"
    np.save(other, bumps()[:30, :50])
    counter = ("--counter-surface", str(other))
    for options in (
        ("--align",),
        ("--set", "offset=5 um, -10 um", "--set", "angle=20"),
        ("--set", "mirror"),
    ):
        assert solve(rough, *STEEL, *counter, *options, "--json") == app.SOLVED
        record = json.loads(capsys.readouterr().out)
        assert any(step.startswith("aligned") for step in record["counter_preparation"])
    assert_rejected(capsys, solve(rough, *STEEL, "--align"), "--counter-surface")
    assert_rejected(
        capsys, solve(rough, *STEEL, *counter, "--set", "offset=5 um"), "--set offset needs two"
    )


def test_materials_are_read_from_catalog(rough: Path, capsys: Capture) -> None:
    options = ("--material", "AISI 52100", "--counter-material", "alumina", "--young", "205 GPa")
    assert solve(rough, *options, "--json") == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    steel = catalog.material("100Cr6")
    assert record["material"]["young"] == 205e9
    assert record["material"]["yield_strength"] == steel.yield_strength
    assert record["counter_material"]["hardness"] > 1e10
    assert record["ceiling"] == 3 * steel.yield_strength
    assert_rejected(
        capsys, solve(rough, "--material", "100Cr7"), "--material", "did you mean 100Cr6"
    )


def test_ceiling_from_a_hardness(rough: Path, capsys: Capture) -> None:
    assert solve(rough, *STEEL, "--ceiling", "700 HV", "--json") == app.SOLVED
    ceiling = json.loads(capsys.readouterr().out)["ceiling"]
    assert ceiling == pytest.approx(700 * 9.80665e6 / np.sin(np.radians(68)))
    assert_rejected(capsys, solve(rough, *STEEL, "--ceiling", "99 HRC"), "--ceiling", "HRC")


def test_materials_lists_the_catalogue_with_sources(capsys: Capture) -> None:
    assert app.main(["materials"]) == app.SOLVED
    out = capsys.readouterr().out
    assert width(out) <= 80
    assert all(entry.key in out for entry in catalog.entries())
    assert app.main(["materials", "bearing steel"]) == app.SOLVED
    assert "source" in capsys.readouterr().out
    assert app.main(["materials", "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert len(record["materials"]) == len(catalog.entries())
    assert_rejected(capsys, app.main(["materials", "unobtainium"]), "'unobtainium' is not in")


# Load histories


@pytest.mark.long
def test_history_writes_steps_and_the_indented_surface(
    rough: Path, tmp_path: Path, capsys: Capture
) -> None:
    output, residual, figure = (tmp_path / name for name in ("h.csv", "h.x3p", "h.png"))
    written = f"--output {output} --indented-surface {residual} --figure {figure}".split()
    path = ("--path", "0.5 N, 0 N, 0.5 N", "--passes", "2", "--shift", "0 um, 6.25 um")
    arguments = ["history", str(rough), *SCALE, *YIELDING, *path]
    assert app.main([*arguments, *written]) == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    assert width(out) <= 80
    assert "keeps an indentation of" in out
    table = np.genfromtxt(output, delimiter=",", names=True, deletechars="")
    assert table["load_[N]"].tolist() == [0.5, 0, 0.5] * 2
    assert table["shift_x_[m]"] == pytest.approx([0] * 3 + [6.25e-6] * 3)
    assert figure.read_bytes().startswith(b"\x89PNG")
    surface = roughcontact.read_surface(rough, unit="um", size=(1e-4, 2e-4)).leveled()
    stages = [
        roughcontact.Stage(load=load, shift=(0.0, shift))
        for shift in (0.0, 6.25e-6)
        for load in (0.5, 0.0, 0.5)
    ]
    expected = roughcontact.history(
        surface, stages, material=roughcontact.Material(210e9, 0.3, 1e9)
    )
    left = roughcontact.read_surface(residual)
    assert left.heights == pytest.approx(expected.residual.heights, abs=1e-12)
    assert app.main([*arguments, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert record["indentation_volume"] == pytest.approx(expected.indentation_volume)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), ("--path is needed",)),
        (("--path", "1 N, 2 J"), ("--path needs a load", "(a moment or an energy)")),
        (("--path", "1 N, -1 N"), ("--path", "positive", "'-1 N'")),
        (("--path", "1 N, 99 N"), ("stage 2", "99 N", "60 N")),
        (("--path", "1 N", "--passes", "0"), ("--passes must be a whole number from 1",)),
        (("--path", "1 N", "--passes", "2", "--shift", "1 um"), ("--shift needs two",)),
        (("--path", "1 N", "--passes", "2", "--shift", "0 um, 1 um"), ("whole number of pixels",)),
        (("--path", "1 N", "--passes", "2", "--shift", "1 mm, 0 um"), ("beyond the map",)),
        (
            ("--path", "1 N", "--indented-surface", "out.opd"),
            ("--indented-surface needs a name that ends in .nc",),
        ),
        (("--path", "1 N", "--output", "out.nc"), ("--output needs a name that ends in .csv",)),
    ],
)
def test_invalid_histories_are_rejected_in_one_sentence(
    options: tuple[str, ...], words: tuple[str, ...], rough: Path, tmp_path: Path, capsys: Capture
) -> None:
    written = (
        []
        if "--indented-surface" in options
        else ["--indented-surface", str(tmp_path / "left.x3p")]
    )
    status = app.main(["history", str(rough), *SCALE, *YIELDING, *options, *written])
    assert_rejected(capsys, status, *words)
    assert files(tmp_path) == {"rough.npy"}


# Reports and resolution


@pytest.mark.usefixtures("quick")
@pytest.mark.long
def test_report_holds_study_notes_and_command(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    heights = np.kron(bumps(), np.ones((2, 2)))
    path, report = tmp_path / "fine.npy", tmp_path / "out.html"
    np.save(path, heights)
    options = (*YIELDING, "--study", "--report", str(report), "--set", "tip-radius=5 um")
    assert solve(path, *options, "--verbose") == app.SOLVED
    assert "tip (radius 5 µm)" in " ".join(capsys.readouterr().out.split())
    text = report.read_text(encoding="utf-8")
    stated = ("Uncertainty", "Ceiling: as the factor goes", "roughcontact solve", "tip-radius=5 um")
    assert all(words in text for words in ("tip (radius 5 µm)", *stated))
    assert_rejected(
        capsys, solve(path, *STEEL, "--report", "out.pdf"), "--report needs a name", ".html"
    )


def test_bodies_tilt_under_a_load_off_the_middle(rough: Path, capsys: Capture) -> None:
    assert solve(rough, *STEEL, "--set", "load-point=3 um, -8 um", "--json") == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert record["moments"] == pytest.approx([0.1 * 3e-6, -0.1 * 8e-6])
    assert record["moment_error"] <= 1e-8
    assert any(record["tilt"])
    assert solve(rough, *STEEL, "--set", "load-point=0 um, 0 um") == app.SOLVED
    assert "Tilt (y, x)" in capsys.readouterr().out
    assert_rejected(capsys, solve(rough, *STEEL, "--set", "load-point=0 um, 1 mm"), "moments")
    assert_rejected(
        capsys, solve(rough, *STEEL, "--set", "load-point=1 um"), "--set load-point needs two"
    )


# Stress below the surface


@pytest.mark.usefixtures("quick")
@pytest.mark.long
def test_stress_of_a_ball_is_hertz(tmp_path: Path, capsys: Capture) -> None:
    ball = ("--body", "sphere 10 mm", "--points", "96", "--size", "0.2 mm", "--load", "1 N")
    output, report = tmp_path / "s.nc", tmp_path / "s.html"
    files_wanted = ("--output", str(output), "--report", str(report), "--figures", str(tmp_path))
    assert app.main(["stress", *ball, *YIELDING, *files_wanted]) == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    assert width(out) <= 80
    assert "von Mises" in out
    assert files(tmp_path) == {
        "s.nc",
        "s.html",
        "stress-depth.png",
        "stress-section.png",
        "stress-map.png",
    }
    assert "How large is the stress below" in report.read_text(encoding="utf-8")
    assert app.main(["stress", *ball, *YIELDING, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    # 0.620 of the largest pressure; radius and depth are known to some of 20 pixels.
    assert record["stress"]["max_von_mises"] == pytest.approx(
        0.62 * record["max_pressure"], rel=0.01
    )
    rubbed = ("--friction", "0.3", "--direction", "90", "--depths", "1 um, 10 um, 14 um", "--json")
    assert app.main(["stress", *ball, *YIELDING, *rubbed]) == app.SOLVED
    other = json.loads(capsys.readouterr().out)["stress"]
    assert other["max_von_mises"] > record["stress"]["max_von_mises"]
    assert other["depths"] == pytest.approx([1e-6, 14e-6])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--depths", "1 um, 0 um"), ("--depths must be positive", "'0 um'")),
        (("--depths", "1 um, -1 um"), ("--depths must be positive",)),
        (("--depths", "1"), ("--depths needs a length",)),
        (("--in-body", "first"), ("--in-body must be one of body, counter-body",)),
        (("--in-body", "counter-body"), ("counter-body is rigid",)),
        (("--friction", "much"), ("--friction must be a number",)),
        (("--output", "out.csv"), ("--output needs a name that ends in .nc",)),
        (("--load", "99 N"), ("60 N",)),
    ],
)
def test_invalid_stress_is_rejected_in_one_sentence(
    options: tuple[str, ...], words: tuple[str, ...], rough: Path, tmp_path: Path, capsys: Capture
) -> None:
    load = () if "--load" in options else ("--load", "0.5 N")
    assert_rejected(
        capsys, app.main(["stress", str(rough), *SCALE, *YIELDING, *load, *options]), *words
    )
    assert files(tmp_path) == {"rough.npy"}


@pytest.mark.long
def test_load_of_first_yield_of_a_ball(capsys: Capture) -> None:
    ball = ("--body", "sphere 10 mm", "--points", "96", "--size", "0.5 mm", "--load", "20 N")
    assert app.main(["stress", *ball, *YIELDING, "--first-yield", "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    expected = hertz.first_yield_load(10e-3, 210e9 / 0.91, 1.615e9)
    # One per cent in the pressure is three in the load.
    assert record["first_yield"]["load"] == pytest.approx(expected, rel=0.03)
    assert app.main(["stress", *ball, *YIELDING, "--first-yield"]) == app.SOLVED
    assert "Yields from" in capsys.readouterr().out


@pytest.mark.long
def test_reports_of_sweep_and_history(rough: Path, tmp_path: Path) -> None:
    report = tmp_path / "out.html"
    assert sweep(rough, "--steps", "3", "--report", str(report)) == app.SOLVED
    page = report.read_text(encoding="utf-8")
    assert "How does the contact of rough.npy grow from" in page
    assert "Contact under 1 N, the largest load" in page
    arguments = ["history", str(rough), *SCALE, *YIELDING, "--path", "0.5 N, 0 N, 0.5 N, 0 N"]
    assert app.main([*arguments, "--report", str(report)]) == app.SOLVED
    page = report.read_text(encoding="utf-8")
    assert "Which indentation does a load history up to 500 mN leave on rough.npy?" in page
    # The map under the largest load, and the heights when it is gone, each named so.
    assert "Contact under 500 mN, the largest load" in page
    assert "Contact pressure under 500 mN, maximum 3 GPa" in page
    assert "Heights of the body after the path, without load." in page
    # The third step adds rounding only.
    table = re.search(r"newly indented.*?</table>", page, re.DOTALL)
    assert table is not None
    assert re.findall(r"<td>([^<]*) µm³", table.group())[1:] == ["0"] * 3


# Plasticity of the volume


@pytest.mark.slow
def test_volume_model_of_a_ball(tmp_path: Path, capsys: Capture) -> None:
    ball = ("--body", "sphere 10 mm", "--points", "32", "--size", "0.4 mm", "--load", "100 N")
    output = tmp_path / "v.nc"
    law = ("--model", "elastoplastic", "--set", "increments=3", "--hardening", "linear 2 GPa")
    command = ["solve", *ball, *YIELDING, *law, "--verbose", "--output", str(output)]
    assert app.main(command) == app.SOLVED
    out, err = capsys.readouterr()
    assert err == ""
    assert width(out) <= 80
    assert "linear hardening, modulus 2 GPa" in out
    stored = volume_archive.load_elastoplastic(output)
    steel = roughcontact.Material(210e9, 0.3, hardening=hardening.Linear(1e9, 2e9))
    expected = roughcontact.solve_elastoplastic(
        stored.contact.surface, material=steel, load=100.0, increments=3
    )
    assert stored.max_plastic_strain == pytest.approx(expected.max_plastic_strain, rel=1e-6)
    assert stored.contact.max_pressure == pytest.approx(expected.contact.max_pressure, rel=1e-6)
    assert app.main(["solve", *ball, *YIELDING, "--model", "elastoplastic", "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert record["volume"]["max_plastic_strain"] > stored.max_plastic_strain
    assert record["volume"]["increments"] == 12
    assert 0 < record["volume"]["step_error"] < 0.01
    few = ("--model", "elastoplastic", "--set", "increments=2")
    assert app.main(["solve", *ball, *YIELDING, *few, "--verbose"]) == app.SOLVED
    assert "pixel-scatter" in capsys.readouterr().out
    single = (
        *ball,
        *YIELDING,
        *shlex.split("--model elastoplastic --set increments=1 --set tolerance=1e-2"),
    )
    assert app.main(["solve", *single]) == app.SOLVED
    assert "1 increment\n" in capsys.readouterr().out


@pytest.mark.long
def test_the_volume_model_ends_without_load(tmp_path: Path, capsys: Capture) -> None:
    output = tmp_path / "out.nc"
    assert app.main(["solve", *BALL, "--unload", "--output", str(output)]) == app.SOLVED
    assert "Unloaded: an indentation of" in capsys.readouterr().out
    stored = volume_archive.load_elastoplastic(output)
    loads = [step.load for step in stored.increments]
    assert loads == pytest.approx([100 / 3, 200 / 3, 100, 0])
    assert not stored.contact.pressure.any()
    assert stored.residual_displacement.max() > 0


def test_hardening_law_enters_calibrated_ceiling(capsys: Capture) -> None:
    ball = ("--body", "sphere 10 mm", "--points", "64", "--size", "3 mm", "--load", "8 kN")
    elastic = ("--young", "210 GPa", "--poisson", "0.3")
    for given, factor in (
        (("--yield-strength", "1.656 GPa"), 2.25),
        (("--hardening", "swift 1240 MPa 30 0.085"), 3.15),
    ):
        assert app.main(["solve", *ball, *elastic, *given, "--json"]) == app.SOLVED
        record = json.loads(capsys.readouterr().out)
        assert record["calibrated"]["factor"] == pytest.approx(factor, abs=0.1)


BALL = (
    *shlex.split("--body 'sphere 10 mm' --points 24 --size '0.4 mm' --load '100 N'"),
    *YIELDING,
    *shlex.split(
        "--model elastoplastic --set increments=3 --hardening 'linear 20 GPa' --set tolerance=1e-3"
    ),
)


def test_resumed_sweep_reports_reused_steps(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    folder = tmp_path / "kept"
    sweep = ["sweep", str(rough), *SCALE, *STEEL, "--from", "10 mN", "--to", "1 N", "--steps", "3"]
    sweep += ["--folder", str(folder)]
    assert app.main(sweep) == app.SOLVED
    assert "earlier run" not in capsys.readouterr().out
    (folder / "step-0002.npz").unlink()
    assert app.main(sweep) == app.SOLVED
    out = capsys.readouterr().out
    assert f"taken from {folder}, solved by an earlier run: 2 loads\n" in out
    assert app.main([*sweep, "--json"]) == app.SOLVED
    assert json.loads(capsys.readouterr().out)["reused"] == 3


@pytest.mark.long
def test_failed_volume_run_reports_saved_steps(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(increments, "_MAX_CUTS", 0)
    original = elastoplastic.solve_elastoplastic
    monkeypatch.setattr(
        elastoplastic, "solve_elastoplastic", lambda *a, **k: original(*a, max_iterations=1, **k)
    )
    folder = tmp_path / "steps"
    assert app.main(["solve", *BALL, "--folder", str(folder)]) == app.NOT_CONVERGED
    err = capsys.readouterr().err
    assert f"earlier loads are saved in {folder}\n" in err
    # The loads before settled: their residual is no reason.
    assert err.startswith("roughcontact: error: not converged: stopped before ")


def test_the_volume_model_needs_a_body_that_yields(rough: Path, capsys: Capture) -> None:
    elastic = ("--young", "210 GPa", "--poisson", "0.3")
    code = solve(rough, *elastic, "--model", "elastoplastic")
    assert_rejected(capsys, code, "--model elastoplastic needs a --yield-strength", "--material")


@pytest.mark.long
def test_volume_model_accepts_solver_options(rough: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "out.json"
    given = ("--model", "elastoplastic", "--set", "increments=1", "--set", "precision=double")
    assert solve(rough, *YIELDING, *given, "--set", "tolerance=1e-3", "--output", str(out)) == 0
    record = json.loads(out.read_text("utf-8"))["volume"]
    assert (record["precision"], record["tolerance"]) == ("double", 1e-3)
    # One iteration never settles: the change from nothing is all of the strain.
    capsys.readouterr()
    assert solve(rough, *YIELDING, *given, "--set", "max-iterations=1") == app.NOT_CONVERGED
    assert "increase --set max-iterations" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["stress", "--load", "1 N", "--first-yield"],
        ["sweep", "--from", "1 N", "--to", "2 N", "--steps", "2"],
        ["find", "--contact-fraction", "1 %"],
        ["conductance", "--load", "1 N"],
    ],
)
def test_loads_of_a_sphere_are_not_shown_as_nominal_pressures(
    words: list[str], capsys: Capture
) -> None:
    body = ["--body", "sphere 5 mm", "--points", "32", "--size", "1 mm", "--material", "42CrMo4"]
    assert app.main([*words, *body, "--counter-material", "42CrMo4"]) == app.SOLVED
    out = capsys.readouterr().out
    assert "nominal)" not in out
    assert "nominal pressure" not in out


@pytest.mark.parametrize("name", ["history", "law", "tangential"])
def test_command_of_bare_bodies_names_the_reason(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert app.main([name, "map.npy", "--coating", "DLC 2 um"]) == app.BAD_INPUT
    printed = capsys.readouterr().err
    assert "--coating is not available: the" in printed
    assert "conductance" in printed


def test_solve_prints_the_range_of_several_profiles(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = []
    for number in (1, 2):
        names.append(str(tmp_path / f"trace{number}.txt"))
        x = np.arange(200) * 0.5
        rows = zip(x, number * np.sin(x / 3), strict=True)
        lines = [f"{place:.1f} {height:.4f}" for place, height in rows]
        Path(names[-1]).write_text("\n".join(["X [um] Z [um]", *lines]), encoding="utf-8")
    given = ["--load", "20 MPa", "--young", "210 GPa", "--poisson", "0.3"]
    assert app.main(["solve", *names, *given]) == app.SOLVED
    last = " ".join(capsys.readouterr().out.split())
    assert re.search(r"2 of 2 files solved; [\d.]+ to [\d.]+ % of the profile is in contact", last)
