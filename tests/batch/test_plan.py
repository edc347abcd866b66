"""Which contacts of a project are solved, and which have to be solved again."""

import json
import os
import pkgutil
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from roughcontact.analyses.tasks import PRESENTATIONS
from roughcontact.batch import plan, project, runner
from roughcontact.cli import app

pytestmark = pytest.mark.process

Capture = pytest.CaptureFixture[str]


def states(path: Path) -> list[str]:
    return [
        report.state
        for report in runner.run_project(project.read_project(path), lambda report: None)
    ]


@pytest.fixture(scope="module")
def solved_project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project of a contact on two maps, with steps and figures, that is solved."""
    folder = tmp_path_factory.mktemp("solved") / "here"
    (folder / "maps").mkdir(parents=True)
    y, x = np.mgrid[:16, :16] / 16
    np.save(folder / "maps" / "rough.npy", np.cos(7 * y) * np.cos(5 * x))
    np.save(folder / "maps" / "other.npy", 0.1 * np.cos(3 * y))
    (folder / "p.toml").write_text(
        """
        write = ["csv", "svg"]
        [[contact]]
        name = "one"
        task = "sweep"
        file = "maps/rough.npy"
        unit = "um"
        size = "0.1 mm"
        counter-surface = "maps/other.npy"
        material = "bearing steel"
        from = "0.1 N"
        to = "1 N"
        steps = 2
        folder = "kept"
        """,
        encoding="utf-8",
    )
    assert states(folder / "p.toml") == [plan.SOLVED]
    return folder


@pytest.fixture
def moved_project(solved_project: Path, tmp_path: Path) -> Path:
    """The same somewhere else."""
    return shutil.copytree(solved_project, tmp_path / "there")


def test_solved_contact_is_recognized_from_any_folder(
    moved_project: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    for start in (moved_project, moved_project.parent, moved_project / "maps"):
        monkeypatch.chdir(start)
        path = os.path.relpath(moved_project / "p.toml", start)
        assert app.main(["run", path, "--json"]) == app.SOLVED
        (report,) = json.loads(capsys.readouterr().out)["contacts"]
        assert report["state"] == plan.KEPT
        written = [Path(name) for name in report["summary"]["written"]]
        # Where they lie now.
        assert [name.resolve() for name in written] == [
            moved_project / "p" / f"one.{suffix}" for suffix in ("csv", "svg")
        ]
    project_file = moved_project / "p.toml"
    (moved_project / "elsewhere").mkdir()
    shutil.move(moved_project / "maps" / "rough.npy", moved_project / "elsewhere" / "rough.npy")
    text = project_file.read_text(encoding="utf-8").replace("maps/rough", "elsewhere/rough")
    project_file.write_text(text, encoding="utf-8")
    assert states(project_file) == [plan.KEPT]


def replace_bytes(path: Path, old: bytes, new: bytes) -> None:
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new, 1))


PRESSURE = b'"max_pressure": [\n    '


@pytest.mark.parametrize(
    "damage",
    [
        lambda here: replace_bytes(here / "p" / "one.csv", b"\n", b""),
        lambda here: os.truncate(here / "p" / "one.svg", 1000),
        lambda here: replace_bytes(here / "p" / "one.json", PRESSURE, PRESSURE + b"1"),
        lambda here: os.truncate(here / "p" / "one.json", 500),
        lambda here: (here / "p" / "one.json").write_text("[]"),
        lambda here: (here / "p" / "one.json").write_text("{}"),
        lambda here: (here / "p" / "one.json").write_text("1"),
        lambda here: (here / "p" / "one.json").write_text("[" * 100000),
    ],
)
def test_damaged_file_is_not_complete(
    damage: Callable[[Path], object], moved_project: Path
) -> None:
    (entry,) = project.read_project(moved_project / "p.toml")
    assert plan.find_complete(entry, plan.request_digest(entry)) is not None
    damage(moved_project)
    assert plan.find_complete(entry, plan.request_digest(entry)) is None


@pytest.mark.parametrize(
    "change",
    [
        lambda here: replace_bytes(here / "maps" / "rough.npy", b"\x00\x00\xf0?", b"\x01\x00\xf0?"),
        lambda here: replace_bytes(here / "maps" / "other.npy", b"\x00", b"\x01"),
        lambda here: replace_bytes(here / "p.toml", b'"1 N"', b'"2 N"'),
        lambda here: (here / "maps" / "rough.npy").unlink(),
    ],
)
def test_content_and_options_decide(change: Callable[[Path], object], moved_project: Path) -> None:
    (entry,) = project.read_project(moved_project / "p.toml")
    before = plan.request_digest(entry)
    change(moved_project)
    (entry,) = project.read_project(moved_project / "p.toml")
    assert plan.request_digest(entry) != before


@pytest.mark.slow
def test_steps_of_previous_options_are_replaced(moved_project: Path) -> None:
    replace_bytes(moved_project / "p.toml", b'"1 N"', b'"2 N"')
    path = moved_project / "p.toml"
    assert states(path) == [plan.SOLVED]
    assert states(path) == [plan.KEPT]
    replace_bytes(moved_project / "maps" / "rough.npy", b"\x00\x00\xf0?", b"\x01\x00\xf0?")
    assert states(path) == [plan.SOLVED]


COMPARED = """
    [defaults]
    unit = "um"
    size = "0.1 mm"
    material = "bearing steel"
    load = "20 MPa"
    steps = 2
    [[contact]]
    name = "one"
    task = "compare"
    {0}
"""


def write_comparison(folder: Path, asked: str) -> Path:
    """Write a project of a comparison of four maps in a folder with special characters."""
    place = folder / "A, B=[1]"
    place.mkdir(exist_ok=True)
    y, x = np.mgrid[:16, :16] / 16
    for number, name in enumerate(("a,1", "a,2", "b1", "b2")):
        noise = np.random.default_rng(number).standard_normal(y.shape)
        np.save(place / f"{name}.npy", np.cos(7 * y) * np.cos(5 * x) + 0.1 * noise)
    (place / "p.toml").write_text(COMPARED.format(asked), encoding="utf-8")
    return place / "p.toml"


@pytest.mark.slow
def test_group_names_are_part_of_contact(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    groups = 'groups = {{ "{0}/5, N" = ["a,1.npy", "a,2.npy"], "x=y" = ["[b]?.npy"] }}'
    path = write_comparison(tmp_path, groups.format("dry"))
    assert states(path) == [plan.SOLVED]
    text = (path.parent / "p" / "one.json").read_text(encoding="utf-8")
    assert '"dry/5, N"' in text
    assert '"x=y"' in text
    for place in (tmp_path, path.parent):
        monkeypatch.chdir(place)
        assert states(path.relative_to(place)) == [plan.KEPT]
    write_comparison(tmp_path, groups.format("wet"))
    assert states(path) == [plan.SOLVED]
    text = (path.parent / "p" / "one.json").read_text(encoding="utf-8")
    assert '"wet/5, N"' in text
    assert '"dry/5, N"' not in text


@pytest.mark.slow
def test_profile_with_figures_is_recognized(tmp_path: Path) -> None:
    heights = np.cumsum(np.random.default_rng(1).standard_normal(64))
    np.savetxt(tmp_path / "line.txt", np.c_[np.arange(64) * 1e-6, 1e-8 * heights])
    (tmp_path / "p.toml").write_text(
        """
        write = ["nc", "svg"]
        [[contact]]
        name = "one"
        file = "line.txt"
        unit = "m, m"
        material = "bearing steel"
        load = "10 N/m"
        """,
        encoding="utf-8",
    )
    assert states(tmp_path / "p.toml") == [plan.SOLVED]
    assert states(tmp_path / "p.toml") == [plan.KEPT]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_file_without_checksum_is_solved_again(moved_project: Path) -> None:
    (moved_project / "maps" / "rough.npy").unlink()
    os.mkfifo(moved_project / "maps" / "rough.npy")
    (entry,) = project.read_project(moved_project / "p.toml")
    assert plan.request_digest(entry) != plan.request_digest(entry)


def test_only_unreadable_file_fails(moved_project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (entry,) = project.read_project(moved_project / "p.toml")
    before = plan.request_digest(entry)

    def deny_access(path: Path) -> str:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("roughcontact._tools.checkpoints.checksum_file", deny_access)
    assert plan.request_digest(entry) != before
    assert plan.find_complete(entry, before) is None


def test_no_number_has_a_name_that_the_file_keeps_for_itself() -> None:
    values: dict[str, object] = {"load": 1.0}
    assert plan.seal_summary(values, "digest", []).keys() == {"load", *plan.RUN_KEYS}
    with pytest.raises(ValueError, match="keeps seal"):
        plan.seal_summary({**values, "seal": 2.0}, "digest", [])
    shown = [pkgutil.resolve_name(f"roughcontact.{place}") for place in PRESENTATIONS.values()]
    values = [quantity for kind in shown for quantity in (*kind.table, *kind.columns)]
    assert len(values) > 100
    assert not plan.RUN_KEYS & {quantity.key for quantity in values}
