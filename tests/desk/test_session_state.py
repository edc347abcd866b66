from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

import roughcontact as rc
from roughcontact.analyses.law.task import TASK as LAW
from roughcontact.analyses.leak.task import TASK as LEAK
from roughcontact.analyses.stress.task import TASK as STRESS
from roughcontact.analyses.sweep.task import TASK as SWEEP
from roughcontact.analyses.tangential.task import TASK as TANGENTIAL
from roughcontact.batch import project
from roughcontact.desk.session import SessionState, from_script
from roughcontact.errors import FormatError, InputError
from roughcontact.report import python_script
from roughcontact.request.run import run_request


@pytest.fixture
def map_file(tmp_path: Path) -> Path:
    heights = 1e-7 * np.random.default_rng(1).standard_normal((24, 32))
    path = tmp_path / "map.npz"
    rc.Surface(heights, (1e-6, 1e-6)).save(path)
    return path


@pytest.fixture
def complete(map_file: Path) -> SessionState:
    state = SessionState().with_map(map_file, "from <me>.opd")
    for name, value in {"material": "100Cr6", "load": "10 mN", "boundary": "periodic"}.items():
        state = state.with_option(name, value)
    return state


def test_new_state_lists_missing_inputs(map_file: Path) -> None:
    assert SessionState().missing == ("file", "material", "boundary", "load")
    assert SessionState().with_map(map_file).missing == ("material", "boundary", "load")


def test_constants_replace_material(complete: SessionState) -> None:
    state = complete.remove_options("material")
    assert state.missing == ("material",)
    assert state.with_option("young", "210 GPa").with_option("poisson", "0.3").missing == ()


def test_a_smooth_body_needs_no_map() -> None:
    state = (
        SessionState()
        .with_option("body", "sphere 10 mm")
        .with_option("points", "64")
        .with_option("size", "0.1 mm")
    )
    assert "file" not in state.missing


def test_text_that_cannot_be_used_changes_nothing(complete: SessionState) -> None:
    with pytest.raises(InputError, match="level must be one of plane"):
        complete.with_option("level", "flat")
    with pytest.raises(InputError, match="no option of solve"):
        complete.with_option("from", "1 N")


def test_key_of_an_older_version_is_read(tmp_path: Path) -> None:
    text = '[[contact]]\nname = "contact"\nmaterial = "100Cr6"\nhertz = "1 GPa"\n'
    assert from_script(text, tmp_path).specified["load"] == "hertz 1 GPa"


@pytest.mark.parametrize("name", ["output", "report", "quiet", "nonsense"])
def test_options_foreign_to_project_file_raise_input_error(
    complete: SessionState, name: str
) -> None:
    with pytest.raises(InputError) as refused:
        complete.with_option(name, "x.nc")
    assert refused.value.argument == name


def test_one_load_replaces_the_other(complete: SessionState) -> None:
    assert "load" not in complete.with_option("approach", "1 um").specified
    assert (
        complete.with_option("approach", "1 um").with_option("load", "2 N").specified["load"]
        == "2 N"
    )


def test_empty_text_removes_option(complete: SessionState) -> None:
    assert complete.with_option("ceiling", "3 GPa").with_option("ceiling", " ") == complete


def test_another_map_clears_file_options(complete: SessionState, map_file: Path) -> None:
    state = complete.with_option("crop", "0:8,0:8").with_option("unit", "um").with_map(map_file)
    assert set(state.specified) == {"material", "load", "boundary"}


def test_remove_step_of_leveling_sets_level_none(complete: SessionState) -> None:
    assert complete.remove_step("leveled").specified["level"] == "none"
    assert complete.with_option("form", "sphere").remove_step("without_form") == complete


def test_the_project_file_gives_the_same_numbers(complete: SessionState, tmp_path: Path) -> None:
    path = tmp_path / "work.toml"
    path.write_text(complete.script(tmp_path), encoding="utf-8")
    (entry,) = project.read_project(path)
    quiet = lambda *_: None  # noqa: E731
    first, again = (
        run_request(complete.request(), quiet),
        run_request(replace_outputs(entry), quiet),
    )
    assert first.contact is not None
    assert again.contact is not None
    assert np.array_equal(first.contact.pressure, again.contact.pressure)


def replace_outputs(entry: project.Entry) -> object:
    given = {key: value for key, value in entry.request.specified.items() if key != "output"}
    return replace(
        entry.request,
        specified=given,
        values={key: value for key, value in entry.request.values.items() if key != "output"},
    )


def test_pinned_state_is_separate_contact(complete: SessionState, tmp_path: Path) -> None:
    state = replace(complete, pinned=complete.with_option("load", "20 mN").specified)
    path = tmp_path / "work.toml"
    path.write_text(state.script(tmp_path), encoding="utf-8")
    assert [entry.request.specified["load"] for entry in project.read_project(path)] == [
        "10 mN",
        "20 mN",
    ]


@given(
    st.text(min_size=1),
    st.none() | st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 4),
)
def test_the_project_file_holds_everything(name: str, line: tuple[float, ...] | None) -> None:
    # Text that UTF-8 cannot encode does not come from a browser.
    name = name.encode("utf-8", "replace").decode()
    path = Path("/some/where/map one.opd")
    state = (
        SessionState().with_map(path, name).with_option("mirror", True).with_option("load", "1 N")
    )
    state = replace(state, pinned=state.specified, line=line, is_first=line is None)
    assert from_script(state.script(path.parent), path.parent) == state
    assert from_script(state.script(Path("/else")), Path("/else")) == state


@pytest.mark.parametrize(
    "text", ["", "[[contact]]", "contact = 3", 'x = "', "[desk]\nline = [1]\n[[contact]]\nname = 1"]
)
def test_damaged_project_file_raises_format_error(text: str, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="project file of this page cannot be read"):
        from_script(text, tmp_path)


def test_names_are_quoted_values_of_project_file(complete: SessionState) -> None:
    state = complete.with_map(Path("/a/x.opd"), 'evil"]\nload = "9 N')
    assert (
        tomllib.loads(state.script(Path("/a")))["desk"]["names"]["x.opd"] == 'evil"]\nload = "9 N'
    )


def test_files_of_a_project_are_found_after_it_moves(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    old.mkdir()
    for name in ("map.npz", "counter.npz"):
        rc.Surface(1e-7 * np.eye(8), (1e-6, 1e-6)).save(old / name)
    state = SessionState().with_map(old / "map.npz").with_counter_surface(old / "counter.npz")
    state = replace(state, pinned=state.specified)
    text = state.script(old)
    assert str(tmp_path) not in text
    assert from_script(text, old) == state
    # Earlier versions wrote absolute paths, or paths relative to the working directory.
    texts = [text, state.script(tmp_path / "elsewhere"), text.replace('"map', '"works/key/map')]
    old.rename(new)
    for text in texts:
        moved = from_script(text, new)
        assert moved.file == new / "map.npz"
        for options in (moved.specified, moved.pinned):
            assert options is not None
            assert options["counter-surface"] == str(new / "counter.npz")


def test_other_tasks_use_applicable_options(complete: SessionState) -> None:
    sweep = complete.request(SWEEP, from_="1 mN", to="10 mN", steps="3")
    assert sweep.specified["from"] == "1 mN"
    assert "load" not in sweep.specified
    assert complete.request(STRESS, friction="0.2").specified["load"] == "10 mN"


def test_downloads_use_file_name_of_user(complete: SessionState, map_file: Path) -> None:
    request = complete.request()
    assert request.command.startswith("roughcontact solve 'from <me>.opd' ")
    assert str(map_file) not in complete.portable_script
    assert 'file = "from <me>.opd"' in complete.portable_script
    result = run_request(request, lambda _: None).contact
    assert result is not None
    assert result.surface.provenance.source == "from <me>.opd"
    assert 'rc.read_surface("from <me>.opd")' in python_script.script_of_result(result)


def test_coated_state_is_rejected_by_analyses_of_bare_bodies() -> None:
    state = SessionState(file=Path("map.npz")).with_option("material", "42CrMo4")
    state = state.with_option("load", "1 N").with_option("coating", "DLC 2 um")
    assert "--coating" in state.request(LEAK).command
    force = {"friction": "0.1", "force": "1 uN"}
    for task, more in ((TANGENTIAL, force), (LAW, {"from_": "1 MPa", "to": "2 MPa"})):
        assert "--coating" not in state.remove_options("coating").request(task, **more).command
        with pytest.raises(InputError) as caught:
            state.request(task, **more)
        assert caught.value.argument == "coating"
