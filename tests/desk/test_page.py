from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel", reason="needs roughcontact[desk]")

import panel as pn

from roughcontact.analyses.find.task import TASK as FIND
from roughcontact.analyses.solve import uncertainty_report as uncertainty
from roughcontact.cautions import Caution, Severity
from roughcontact.desk import analysis_jobs, style
from roughcontact.desk.maps import HEIGHTS, NAMES, PRESSURE
from roughcontact.desk.page import ContactView, Page
from roughcontact.desk.projects import ProjectStore, SavedProject
from roughcontact.desk.server import PageVisit
from roughcontact.desk.workers import JobStage, WorkerPool
from visits import GIVEN, PATIENCE, Loop, Pressed, give_all, solve_and_show


@pytest.fixture
def work(tmp_path: Path) -> SavedProject:
    return ProjectStore(tmp_path / "works").create()


@pytest.fixture
def page(work: SavedProject, tmp_path: Path) -> Iterator[Page]:
    bench = WorkerPool(spare=False)
    visit = PageVisit(work, None, bench, 2**20, lambda: None, list)
    made = Page(visit)
    made._document = Loop()
    yield made
    made.close()
    bench.close()


def map_file(folder: Path, holes: int = 0) -> Path:
    heights = 1e-7 * np.random.default_rng(1).standard_normal((24, 32))
    heights.flat[:holes] = np.nan
    path = folder / "map.npz"
    rc.Surface(heights, (1e-6, 1e-6)).save(path)
    return path


def text_of(pane: Any) -> str:
    return str(pane.object)


@pytest.mark.long
def test_page_lists_missing_inputs_and_then_shows_contact(page: Page, tmp_path: Path) -> None:
    assert missing_inputs(page) == ["1 Map", "2 Material", "3 Extent", "4 Load"]
    assert "Next: open a map" in text_of(page._header.state)
    page._run_action(lambda: page.session.open_map(map_file(tmp_path), "<b>mine</b>.npz"))
    solve_and_show(page)
    assert missing_inputs(page) == ["2 Material", "3 Extent", "4 Load"]
    assert "Next: choose a material" in text_of(page._header.state)
    assert page._map_panel.step.root.collapsed
    page._give_option("material", "100Cr6")
    assert missing_inputs(page) == ["3 Extent", "4 Load"]
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    assert "converged" in results_of(page)
    assert "10 mN" in numbers_of(page)
    ends = uncertainty.brief_ends(page.session.outcome.contact)
    assert " to " in ends["contact_fraction"]
    assert f"<small>{ends['contact_fraction']}</small>" in numbers_of(page)
    assert not page._header.checklist.visible
    head = text_of(page._map_panel.step.root.header)
    assert "&lt;b&gt;mine" in head
    assert "<b>mine" not in head


def missing_inputs(page: Page) -> list[str]:
    """Return the missing entries of the checklist."""
    labels = [check.label for check in page._header.checklist if check.visible]
    return [label for label in labels if not label.startswith("✓")]


def numbers_of(page: Page) -> str:
    return text_of(page._header.numbers)


def results_of(page: Page) -> str:
    return text_of(page.view.detail._parts[0])


def is_old(page: Page) -> bool:
    return page._header.numbers.styles == style.OLD


@pytest.mark.long
def test_results_of_another_request_are_gray_until_the_last_is_answered(
    page: Page, tmp_path: Path
) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    assert is_old(page)
    solve_and_show(page)
    assert not is_old(page)
    asked = page.session.number
    assert page._answer == asked
    page._set_option("load", "20 mN")
    assert page.session.number == asked + 1
    assert is_old(page)
    assert page._answer == asked
    solve_and_show(page)
    assert not is_old(page)
    assert "20 mN" in numbers_of(page)
    page._run_action(page.session.undo)
    assert is_old(page)
    # A result for another load is shown and marked as such.
    late = page.session._wanted
    assert page.session.wait(PATIENCE)
    page._set_option("load", "30 mN")
    page._catch_up()
    assert "10 mN" in numbers_of(page)
    assert not page.session.is_wanted(late)
    assert is_old(page)
    solve_and_show(page)
    assert "30 mN" in numbers_of(page)
    assert not is_old(page)


@pytest.mark.long
def test_two_pages_on_one_project_follow_each_other(
    page: Page, work: SavedProject, tmp_path: Path
) -> None:
    bench = WorkerPool(spare=False)
    seen: list[PageVisit] = []
    visit = PageVisit(work, None, bench, 2**20, lambda: None, list, lambda: seen)
    first = Page(visit)
    first._document = Loop()
    seen.append(page._visit)
    first._run_action(lambda: first.session.open_map(map_file(tmp_path)))
    first._run_action(lambda: give_all(first.session, dict(GIVEN)))
    for one in (first, page):
        solve_and_show(one)
        assert "10 mN" in numbers_of(one)
    assert page.session.state == first.session.state
    first._remove()
    solve_and_show(page)
    assert "removed" in text_of(page.root[0])
    bench.close()


@pytest.mark.long
def test_map_with_holes_is_shown_and_reported(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path, holes=3)))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    assert "3 missing points" in text_of(page._notice)
    assert page.view.maps.sources[HEIGHTS].data["x"]


@pytest.mark.long
def test_empty_file_is_rejected_with_name_of_user(page: Page, work: SavedProject) -> None:
    path = work.folder / "map-1.opd"
    path.touch()
    page._run_action(lambda: page.session.open_map(path, "mine.opd"))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    assert "mine.opd is empty" in text_of(page._notice)
    assert work.key not in text_of(page._notice)
    page._views.strip.active = 5
    take = page._views._created[5]
    take._working.start()
    assert take._working._job.wait(PATIENCE) is not None
    solve_and_show(page)
    assert "mine.opd is empty" in text_of(take._working._status)
    assert work.key not in text_of(take._working._status)


def test_progress_has_the_name_of_the_user(page: Page, work: SavedProject) -> None:
    path = work.folder / "map-1.npz"
    path.write_bytes(map_file(work.folder).read_bytes())
    page._run_action(lambda: page.session.open_map(path, "mine.npz"))
    page._begun = 0.0
    page._show_running("reading map-1.npz")
    assert "reading mine.npz" in text_of(page._header.state)
    page._views.strip.active = 1
    analyze = page._views._created[1]
    analyze._working._show_stage(JobStage("reading map-1.npz", None, 1.0))
    assert "reading mine.npz; 1 s so far" in text_of(analyze._working._status)
    assert page.session.wait(PATIENCE)


@pytest.mark.long
def test_section_without_map_is_saved_and_not_drawn(page: Page, work: SavedProject) -> None:
    path = work.folder / "map-1.opd"
    path.touch()
    page._run_action(lambda: page.session.open_map(path))
    solve_and_show(page)
    page._handle_line((1e-6, 0.0, 1e-6, 9e-6))
    assert page.session.state.line == pytest.approx((1e-6, 0.0, 1e-6, 9e-6))
    assert page.view.maps.section.line is None


@pytest.mark.long
def test_failed_step_can_be_removed(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(lambda: give_all(page.session, {**GIVEN, "crop": "0:9999,:"}))
    solve_and_show(page)
    assert page.session.failure is not None
    steps = page._preparation._steps
    undoing = next(row[1] for row in steps if "0:9999" in text_of(row[0]))
    undoing.clicks += 1
    solve_and_show(page)
    assert page.session.failure is None
    assert "converged" in results_of(page)


@pytest.mark.long
def test_every_panel_is_built_and_shows_contact(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    strip = page._views.strip
    for number in range(len(strip.names)):
        strip.active = number
    page._run_action(page.session.pin)
    page._run_action(lambda: page.session.set_option("load", "20 mN"))
    solve_and_show(page)
    made = page._views._created
    strip.active = 3
    assert "10 mN" in text_of(made[3]._differences)
    strip.active = 5
    assert "roughcontact solve" in text_of(made[5]._words)
    for number in range(4):
        page.view.detail._tabs.strip.active = number
    for number in range(5):
        page._handle_shortcut(Pressed({"name": str(number + 1)}))
        assert page.view.maps.large == list(NAMES)[number]


@pytest.mark.long
def test_views_are_built_with_map(tmp_path: Path) -> None:
    surface = rc.read_surface(map_file(tmp_path))
    start = pn.pane.Str("begin")
    sight = ContactView(lambda line: None, lambda rows, columns: None, lambda done: done(), start)
    sight.clear()
    assert sight.root.objects == [start]
    sight.show_contact(surface, None, None)
    assert start not in sight.root.objects
    assert sight.maps.large == HEIGHTS
    assert not sight.maps.strip.visible
    assert sight.maps.sources[HEIGHTS].data["x"]


def test_large_map_takes_half_of_the_window_and_leaves_room_for_the_section() -> None:
    heights = 1e-7 * np.random.default_rng(1).standard_normal((32, 32))
    square, wide = (rc.Surface(heights[:rows], (1e-6, 1e-6)) for rows in (32, 12))
    view = ContactView(lambda line: None, lambda rows, columns: None, lambda done: done())
    sizes = (1024, 768, 0.54), (1280, 800, 0.55), (1440, 900, 0.55), (1920, 1080, 0.5)
    for width, height, share in sizes:
        view.fit(width, height)
        plot = view.maps.plot
        for surface in square, wide:
            result = rc.solve(surface, load=1e-3, material="100Cr6")
            view.show_contact(surface, result, None)
            # Axes, title and color bar belong to the map.
            assert plot.frame_width + 113 >= share * width
            assert plot.frame_height + 65 + 136 <= height
            assert plot.frame_width * len(surface.heights) == pytest.approx(
                plot.frame_height * 32, rel=0.01
            )
            # The section is in view: right of the map, or below it where the map leaves room.
            below = surface is wide or width < 1240
            assert view._sheet.css_classes == ["below"] * below
            assert surface is square or plot.frame_height + 65 + 140 + 290 <= height


@pytest.mark.long
def test_slider_sets_displayed_load(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(lambda: give_all(page.session, {**GIVEN, "load": "1 MPa"}))
    solve_and_show(page)
    position = page._load.slider.value + 25
    page._load.slider.moved = {"value": position, "done": True, "count": 1}
    assert page._load.slider.texts[position] == page.session.state.specified["load"]
    given = page.session.state.specified["load"]
    assert given != "1 MPa"
    assert page._load.text.value == given
    solve_and_show(page)
    assert page.session.outcome is not None
    assert page.session.outcome.request.specified["load"] == given


@pytest.mark.long
def test_the_load_keeps_its_value_in_another_form(page: Page, tmp_path: Path) -> None:
    from roughcontact.desk import header

    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    page._load.form.value = header.NOMINAL
    assert page.session.state.specified["load"] == "13 MPa"
    page._load.text.value = "13 furlongs"
    assert page._load._wrong.visible
    assert page.session.state.specified["load"] == "13 MPa"


@pytest.mark.long
def test_a_drag_shows_previews_and_its_end_the_contact_of_the_command(
    page: Page, tmp_path: Path
) -> None:
    heights = 1e-7 * np.random.default_rng(1).standard_normal((300, 320))
    path = tmp_path / "map.npz"
    rc.Surface(heights, (1e-6, 1e-6)).save(path)
    page._run_action(lambda: page.session.open_map(path))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    state = page.session.state
    page._load.slider.moved = {"value": 200, "done": False, "count": 1}
    solve_and_show(page)
    assert page.session.state is state
    assert "Preview on 150 × 160 pixels" in text_of(page._header.state)
    assert page.view.maps.sources[PRESSURE].data[PRESSURE][0].shape == (150, 160)
    assert page._load.slider.texts[200] in numbers_of(page)
    # Back where it began: the state is the same, the contact is in sight again.
    page._load.slider.moved = {"value": page._load.slider.value, "done": True, "count": 2}
    solve_and_show(page)
    assert "Up to date" in text_of(page._header.state)
    assert page.view.maps.result.pressure is page.session.outcome.contact.pressure
    page._load.slider.moved = {"value": 200, "done": True, "count": 3}
    solve_and_show(page)
    outcome = page.session.outcome
    exact = rc.solve(
        rc.read_surface(path).leveled(),
        load=page._load.slider.texts[200],
        material="100Cr6",
        boundary="periodic",
    )
    assert np.array_equal(outcome.contact.pressure, exact.pressure)


@pytest.mark.long
def test_a_load_that_is_found_becomes_that_of_the_contact(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    page._views.strip.active = 1
    ask = page._views._created[1]
    ask._choice.value = "Load search"
    _, take, request, _ = ask._prepare()
    take(analysis_jobs.run_analysis(lambda _: None, request, True))
    lead, use = ask._answers["Load search"].root[:2]
    assert "5 % in contact needs" in text_of(lead)
    use.clicks += 1
    solve_and_show(page)
    found = page.session.outcome
    assert found.contact.contact_fraction == pytest.approx(0.05, abs=2 / 768)


@pytest.mark.long
def test_a_caution_is_remedied_by_its_button(page: Page, tmp_path: Path) -> None:
    path = tmp_path / "hollow.npz"
    heights = 1e-7 * np.add.outer(np.linspace(-1, 1, 24) ** 2, np.linspace(-1, 1, 32) ** 2)
    rc.Surface(heights, (1e-6, 1e-6)).save(path)
    page._run_action(lambda: page.session.open_map(path))
    page._run_action(lambda: give_all(page.session, {**GIVEN, "boundary": "free"}))
    solve_and_show(page)
    assert "warning" in page._header.count.label
    page._header.count.clicks += 1
    assert page._header.drawer.visible
    labels = {part.label: part for part in page._header.drawer if hasattr(part, "clicks")}
    labels["Use boundary periodic"].clicks += 1
    assert page.session.state.specified["boundary"] == "periodic"
    solve_and_show(page)
    assert "Use boundary periodic" not in {
        part.label for part in page._header.drawer if hasattr(part, "clicks")
    }
    page._handle_shortcut(Pressed({"name": "Escape"}))
    assert not page._header.drawer.visible
    page._handle_shortcut(Pressed({"name": "undo"}))
    assert page.session.state.specified["boundary"] == "free"


def drop(page: Page, path: Path, name: str) -> None:
    """Drop a file that the server has stored for the project, and wait until it is read."""
    ended = threading.Event()
    check = page._reader.check
    page._reader.check = lambda path, end: check(path, lambda e: (end(e), ended.set()))
    page._window.arrived = {"file": path.name, "name": name, "number": path.name}
    assert ended.wait(PATIENCE)
    page._reader.check = check
    # The first turn of the loop takes the file.
    solve_and_show(page)
    solve_and_show(page)


@pytest.mark.long
def test_refused_file_leaves_map_and_result(page: Page, work: SavedProject, tmp_path: Path) -> None:
    (work.folder / "map-1.npz").write_bytes(map_file(tmp_path).read_bytes())
    drop(page, work.folder / "map-1.npz", "mine.npz")
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    state, numbers = page.session.state, numbers_of(page)
    assert state.name_of(state.file) == "mine.npz"
    for number, content in enumerate((b"", b"%PDF-1.4"), 2):
        path = work.folder / f"map-{number}.pdf"
        path.write_bytes(content)
        drop(page, path, "<b>bad</b>.pdf")
        assert page.session.state == state
        assert numbers_of(page) == numbers
        assert not is_old(page)
        wrong = page._map_panel._wrong
        assert wrong.visible
        assert "&lt;b&gt;bad" in text_of(wrong)
        assert path.stem not in text_of(wrong)
        assert not page._map_panel.step.root.collapsed
        assert not path.exists()
    # A file that only lacks its unit is taken, and the unit requested.
    np.save(work.folder / "map-9.npy", np.eye(8))
    drop(page, work.folder / "map-9.npy", "bare.npy")
    assert page.session.state.name_of(page.session.state.file) == "bare.npy"
    assert not page._map_panel._wrong.visible
    assert len(page._map_panel._group.controls["unit"].root) == 2


@pytest.mark.long
def test_load_is_shown_in_the_unit_of_the_user(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    solve_and_show(page)
    # No load is given: the slider shows none.
    assert page._load.slider.value == -1
    assert page._load.slider.texts
    page._run_action(lambda: give_all(page.session, {**GIVEN, "load": "10 MPa"}))
    solve_and_show(page)
    assert page._load.slider.value > 0
    assert "<dt>Load</dt><dd>10 MPa</dd><small>7.68 mN</small>" in numbers_of(page)
    page._views.strip.active = 1
    analyze = page._views._created[1]
    request = page.session.state.request(FIND, contact_fraction="5 %")
    found = analysis_jobs.run_analysis(lambda _: None, request, True)
    use = analyze._make_views(found, request)[1]
    assert use.label.endswith("MPa as the load")


def test_invalid_load_stays_with_its_error_until_the_load_changes(page: Page) -> None:
    load = page._load
    load.text.value = "5 bananas"
    page._show_state()
    assert (load.text.value, load.text.css_classes) == ("5 bananas", ["invalid"])
    assert load._wrong.visible
    page._give_option("load", "20 MPa")
    assert (load.text.value, load.text.css_classes) == ("20 MPa", [])
    assert not load._wrong.visible


def test_messages_are_counted_from_the_gravest(page: Page) -> None:
    note, warning = (Caution("size", ("",), kind) for kind in (Severity.NOTE, Severity.WARNING))
    for cautions, label in (
        ([note], "1 note"),
        ([note, warning, note, warning], "2 warnings, 2 more"),
    ):
        page._header.show_cautions(cautions)
        assert page._header.count.label == label


@pytest.mark.long
def test_result_of_an_analysis_stays_with_its_form(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(lambda: give_all(page.session, dict(GIVEN)))
    solve_and_show(page)
    page._views.strip.active = 1
    analyze = page._views._created[1]
    name = "Load search"
    analyze._choice.value = name
    analyze._forms[name].set_option("contact-fraction", "5 %")
    work, take, request, over_pressure = analyze._prepare()
    found = work(lambda _: None, request, over_pressure)
    analyze._choice.value = "Load curve"
    # The result arrives while another form is shown.
    take(found)
    assert "press Start" in text_of(analyze._answer[0][0])
    analyze._working.show_refusal("no")
    analyze._choice.value = name
    assert text_of(analyze._working._status) == ""
    assert "5 % in contact" in text_of(analyze._answer[0][0])
    assert analyze._answer[0].styles == style.NEW
    analyze._forms[name].set_option("contact-fraction", "6 %")
    assert analyze._answer[0].styles == style.OLD
    analyze._forms[name].set_option("contact-fraction", "5 %")
    assert analyze._answer[0].styles == style.NEW
    # The search does not depend on the load, but on the bodies.
    page._set_option("load", "1 N")
    assert analyze._answer[0].styles == style.NEW
    page._give_option("material", "42CrMo4")
    assert analyze._answer[0].styles == style.OLD


def test_analyses_of_minutes_are_prepared_commands(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path), "mine.npz"))
    roller = {"counter-body": "cylinder 5 mm 90 deg"}
    page._run_action(lambda: give_all(page.session, {**GIVEN, **roller}))
    page._views.strip.active = 1
    analyze = page._views._created[1]
    for name, task in (("Elastoplastic model", "solve"), ("Repeated passes", "roll")):
        analyze._choice.value = name
        assert not analyze._working.root.visible
        assert f"roughcontact {task} mine.npz --" in text_of(analyze._answer[0][0])
    assert page.session.wait(PATIENCE)


def test_removed_project_is_reported(work: SavedProject, tmp_path: Path) -> None:
    gone: list[bool] = []
    bench = WorkerPool(spare=False)
    made = Page(PageVisit(work, None, bench, 1, lambda: gone.append(True), list))
    made._map_panel._about_works()[1].value = "remove"
    assert gone == [True]
    assert "removed" in text_of(made.root[0])
    bench.close()


@pytest.mark.long
def test_demonstration_map_is_created_and_removed(page: Page) -> None:
    made = threading.Event()
    page._document.add_next_tick_callback = lambda done: (done(), made.set())
    page._map_panel._demonstration.value = "Polished, isotropic"
    assert made.wait(PATIENCE)
    page._document = Loop()
    assert page.session.wait(PATIENCE)
    page._views.strip.active = 5
    take = page._views._created[5]
    assert "Polished, isotropic.npz" in text_of(take._words)


def test_controls_show_defaults_as_one_types_them() -> None:
    from roughcontact.analyses.history.task import TASK as HISTORY
    from roughcontact.analyses.stress.task import TASK as STRESS
    from roughcontact.desk.controls import Control

    shown = {}
    for name, task in (("friction", STRESS), ("shift", HISTORY), ("passes", HISTORY)):
        control = Control(name, lambda name, value: None, task=task)
        control.show_options({})
        shown[name] = control.widget.value
    assert shown == {"friction": "0", "shift": "", "passes": "1"}
    box = Control("mirror", lambda name, value: None)
    box.show_options({"mirror": True})
    assert box.widget.value == box.widget.options
    box.show_options({})
    assert box.widget.value == []


@pytest.mark.long
def test_steps_of_the_preparation_are_removed_at_their_line(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    solve_and_show(page)
    form, steps = page._preparation._group.controls["form"], page._preparation._steps
    form.widget.value = "polynomial 3"
    assert page.session.state.specified["form"] == "polynomial 3"
    solve_and_show(page)
    assert [text_of(line[0])[:13] for line in steps] == ["<span>leveled", "<span>form re"]
    steps[1][1].clicks += 1
    assert "form" not in page.session.state.specified
    assert form.widget.value == ""
    solve_and_show(page)
    steps[0][1].clicks += 1
    solve_and_show(page)
    assert list(steps) == []


@pytest.mark.long
def test_coated_body_is_solved(page: Page, tmp_path: Path) -> None:
    page._run_action(lambda: page.session.open_map(map_file(tmp_path)))
    page._run_action(
        lambda: give_all(page.session, {**GIVEN, "coating": "DLC 2 um", "ceiling": "base"})
    )
    solve_and_show(page)
    contact = page.session.outcome.contact
    assert contact.material.coating
    assert "10 mN" in numbers_of(page)


def test_colors_of_sections_are_visible_on_light_and_dark_pages() -> None:
    def luminance(color: str) -> float:
        parts = np.array([int(color[place : place + 2], 16) for place in (1, 3, 5)]) / 255
        return float(np.dot(parts**2.2, [0.2126, 0.7152, 0.0722]))

    # The ground of light and of dark pages.
    for ground in re.findall(r"--bg: (#\w+)", style.CSS["PAGE"]):
        low, high = sorted(map(luminance, (style.NEUTRAL, ground)))
        assert (high + 0.05) / (low + 0.05) > 3
    assert len(style.GAP) == len("#rrggbbaa")


def test_no_token_of_the_page_has_a_name_of_bokeh() -> None:
    import bokeh

    script = Path(bokeh.__file__).parent / "server" / "static" / "js" / "bokeh.min.js"
    names = set(re.findall(r"(--[a-z-]+):", style.CSS["PAGE"]))
    assert len(names) > 10
    assert not [name for name in names if f"{name}:" in script.read_text("utf-8")]
