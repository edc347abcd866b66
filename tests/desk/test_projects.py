"""Sessions are private, found only by their keys, and deleted when they are unused."""

from __future__ import annotations

import os
import stat
import sys
import time
from pathlib import Path

import pytest

from roughcontact.desk import projects
from roughcontact.desk.projects import ProjectStore, format_suffix, safe_file_name, state_folder
from roughcontact.errors import InputError

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no modes")


@POSIX
def test_project_is_private_with_long_key(tmp_path: Path) -> None:
    desk = ProjectStore(tmp_path / "desk")
    one, other = desk.create(), desk.create()
    assert one.key != other.key
    assert len(one.key) == 32
    for folder in (desk.folder, one.folder):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    with one.page() as page:
        assert stat.S_IMODE(page.stat().st_mode) == 0o700


def test_project_is_found_by_its_key_only(tmp_path: Path) -> None:
    desk = ProjectStore(tmp_path / "desk")
    work = desk.create()
    assert desk.open_project(work.key) == work
    (tmp_path / ("x" * 32)).mkdir()
    for key in ("", ".", "..", "../" + "x" * 29, work.key[:-1], work.key + "\n", str(work.folder)):
        assert desk.open_project(key) is None
        desk.remove(key)
    assert desk.open_project(work.key) == work
    desk.remove(work.key)
    assert desk.open_project(work.key) is None
    assert not work.folder.exists()


def test_relative_folder_of_projects_is_resolved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    work = ProjectStore(Path("works")).create()
    assert work.project == tmp_path / "works" / work.key / projects.PROJECT


def test_new_project_has_no_folder_before_its_first_file(tmp_path: Path) -> None:
    desk = ProjectStore(tmp_path)
    works = [desk.reserve() for _ in range(3)]
    assert list(tmp_path.iterdir()) == []
    with works[0].open_upload("a.npy", 5) as upload:
        upload.write(b"abc")
    with works[1].page() as page:
        assert page.parent == works[1].folder
    assert {path.name for path in tmp_path.iterdir()} == {work.key for work in works[:2]}
    assert [desk.open_project(work.key) for work in works] == works
    desk.remove(works[2].key)
    assert desk.open_project(works[2].key) is None


def test_upload_is_saved_under_generated_name(tmp_path: Path) -> None:
    work = ProjectStore(tmp_path).create()
    with work.open_upload("../../<b>ground\n.OPD", 100) as upload:
        upload.write(b"abc")
        upload.write(b"def")
    assert upload.path.parent == work.folder
    assert upload.path.suffix == ".opd"
    assert upload.path.read_bytes() == b"abcdef"
    assert "ground" not in upload.path.name
    assert upload.name == "<b>ground .OPD"


def test_a_file_that_is_too_large_leaves_nothing(tmp_path: Path) -> None:
    work = ProjectStore(tmp_path).create()

    def receive() -> None:
        with work.open_upload("map.npy", 5) as upload:
            upload.write(b"abc")
            upload.write(b"def")

    with pytest.raises(InputError, match=r"map\.npy has more than 5 bytes"):
        receive()
    assert list(work.folder.iterdir()) == []


def test_format_suffix_keeps_known_suffixes_only() -> None:
    assert format_suffix("a.b.csv.gz") == ".csv.gz"
    assert format_suffix("scan.001") == ".001"
    assert format_suffix("my.map.X3P") == ".x3p"
    for name in ("map", "a.<b>", "a.b c", ".opd/..", "a." + "x" * 40):
        assert format_suffix(name) == ""


def test_names_are_one_line_without_folders() -> None:
    assert safe_file_name("C:\\data\\a.opd") == "a.opd"
    assert safe_file_name("/etc/\x1b[31m\u202ea.opd") == "[31m a.opd"
    assert safe_file_name("") == safe_file_name("dir/") == "map"
    assert len(safe_file_name("x" * 1000 + ".opd")) == 200


def test_files_of_page_are_removed_with_it(tmp_path: Path) -> None:
    work = ProjectStore(tmp_path).create()
    with work.page() as page:
        (page / "result.nc").write_bytes(b"x")
    assert not page.exists()
    with pytest.raises(ValueError, match="boom"), work.page() as page:
        raise ValueError("boom")
    assert not page.exists()


def test_unused_projects_are_removed(tmp_path: Path) -> None:
    desk = ProjectStore(tmp_path)
    old, new = desk.create(), desk.create()
    stranger = tmp_path / "not-a-key"
    stranger.mkdir()
    past = time.time() - 31 * 86400
    for folder in (old.folder, new.folder, stranger):
        os.utime(folder, (past, past))
    assert desk.open_project(new.key) is not None
    desk.expire()
    assert not old.folder.exists()
    assert new.folder.exists()
    assert stranger.exists()


def test_pages_of_a_server_that_was_killed_go_and_others_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(projects, "_MIN_AGE_SECONDS", -1.0)
    desk = ProjectStore(tmp_path)
    work = desk.create()
    left = work.folder / "page-0123456789abcdef"
    left.mkdir()
    (left / "lock").touch()
    with work.page() as held:
        desk.expire()
        assert not left.exists()
        assert held.exists()


@POSIX
def test_the_folder_is_where_the_system_keeps_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert state_folder() == tmp_path / "roughcontact" / "desk"
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert state_folder() == tmp_path / ".local" / "state" / "roughcontact" / "desk"


def test_folder_that_cannot_be_created_raises_input_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be created") as caught:
        ProjectStore(tmp_path / "file" / "desk")
    assert caught.value.argument == "folder"


def test_saved_projects_are_listed_latest_first(tmp_path: Path) -> None:
    works = ProjectStore(tmp_path)
    first, empty, last = (works.create() for _ in range(3))
    for age, work in ((100, first), (1, last)):
        work.project.write_text("")
        os.utime(work.folder, (time.time() - age,) * 2)
    assert [work.key for work in works.saved_projects()] == [last.key, first.key]
    works.remove(last.key)
    assert [work.key for work in works.saved_projects()] == [first.key]
    assert empty.folder.exists()
