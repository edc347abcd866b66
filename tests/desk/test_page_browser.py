"""The page in a browser: the main job, its refusals, its ends, and the keyboard."""

from __future__ import annotations

import io
import re
import shlex
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from browsing import FOLDED, Seat, Served, browser, lacking
from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.cli import app
from roughcontact.report.kind import quantity_of

_LACKING = lacking()

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(
        bool(_LACKING), reason=f"no tests of pages without {' and '.join(_LACKING)}"
    ),
]

EVIL = "<img src=x onerror=alert(1)>.npy"


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    program = Served(tmp_path_factory.mktemp("desk") / "works")
    yield program
    program.kill()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as started:
        yield started


@pytest.fixture
def seat(served: Served, chromium: Any) -> Iterator[Seat]:
    """Open a page on a new session; check afterwards that no error was reported."""
    sitting = Seat(chromium, served.home)
    yield sitting
    sitting.page.close()
    assert sitting.foreign == []
    assert sitting.dialogs == []
    assert sitting.errors == []


@pytest.fixture(scope="module")
def measured_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a map as an instrument gives it."""
    heights, pixel = rc.reference_map(128)
    path = tmp_path_factory.mktemp("maps") / "made.x3p"
    rc.Surface(heights[:96], pixel).save(path)
    return path


def array(heights: np.ndarray) -> bytes:
    """Return the bytes of an array file."""
    stream = io.BytesIO()
    np.save(stream, heights)
    return stream.getvalue()


def specify_and_solve(seat: Seat, load: str = "10 MPa") -> None:
    """Give all inputs of a solution, and wait for it."""
    seat.choose("Material", "100Cr6")
    seat.choose("Boundary", "the whole contact")
    seat.type("Value with unit", load)
    seat.page.get_by_text("converged, certificate").wait_for()


def demonstrate(seat: Seat) -> None:
    """Take a demonstration map and press it."""
    seat.choose("Or a demonstration map", "Polished")
    seat.page.locator("p > b").get_by_text("Polished, isotropic.npz", exact=True).wait_for()
    specify_and_solve(seat)


def text_of(place: Any) -> str:
    return str(place.text_content())


def wait_for_change(seat: Seat, name: str, before: str) -> str:
    """Wait until a headline number is another one, and return it."""
    seat.number(name).filter(has_not_text=re.compile(f"^{re.escape(before)}$")).wait_for()
    return text_of(seat.number(name))


def test_a_measured_file_from_drop_to_download(
    seat: Seat, served: Served, measured_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seat.choose_file(measured_file, measured_file.name)
    page = seat.page
    # Prepare: the step is listed, and undone by its own button.
    seat.unfold("Prepare")
    seat.choose("Level", "paraboloid")
    page.get_by_text(re.compile("^leveled: (?!least-squares plane)")).first.wait_for()
    seat.choose("Missing points", "fill")
    specify_and_solve(seat)
    # Drag the load.
    before = text_of(seat.number("Load"))
    slider = page.get_by_role("slider")
    at = slider.bounding_box()
    assert at is not None
    page.mouse.move(at["x"] + at["width"] / 2, at["y"] + at["height"] / 2)
    page.mouse.down()
    page.mouse.move(at["x"] + 0.55 * at["width"], at["y"] + at["height"] / 2, steps=8)
    page.mouse.up()
    wait_for_change(seat, "Load", before)
    # Draw a section.
    (x, y) = seat.ends()[1]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 40, y - 30 if y > 360 else y + 30, steps=5)
    page.mouse.up()
    seat.wait_for_title("at the nearest points")
    assert "\nline = [" in (served.folder / seat.key / "project.toml").read_text()
    # Exported numbers equal those of the command line to the last digit.
    result = seat.download("result (.nc)", tmp_path)
    report = seat.download("report", tmp_path)
    command = text_of(page.locator("pre").first)
    words = shlex.split(command)
    assert words[:3] == ["roughcontact", "solve", measured_file.name]
    shutil.copy(measured_file, tmp_path)
    monkeypatch.chdir(tmp_path)
    assert app.main([*words[1:], "--output", "own.nc", "--quiet"]) == app.SOLVED
    ours, theirs = rc.read_result(result), rc.read_result("own.nc")
    for name in ("pressure", "gap", "residual_indentation"):
        assert np.array_equal(getattr(ours, name), getattr(theirs, name), equal_nan=True)
    assert (ours.load, ours.approach, ours.certificate) == (
        theirs.load,
        theirs.approach,
        theirs.certificate,
    )
    assert ours.max_pressure == theirs.max_pressure
    # The page may still show a load that the slider passed; it ends with what was taken.
    mean = quantity_of(contact_fields.CONTACT, "mean_pressure").format_value(
        ours.load / ours.contact_area
    )
    seat.number("Mean pressure").filter(has_text=mean).wait_for()
    assert mean in report.read_text(encoding="utf-8")


_MAPS = """(frames) => {
  const models = [...Bokeh.documents[0]._all_models.values()];
  const maps = models.filter((m) => m.type == "Figure" && m.frame_width);
  const views = maps.map((m) => Bokeh.index.find_one_by_id(m.id));
  const found = views.map((view) => [view?.frame.bbox.height, view?.frame.bbox.width]);
  // A first layout may differ from the next by a pixel: it rounds before the text is measured.
  return frames == null ? found : found.every((sides, map) => sides.every((side, way) =>
    side != null && Math.abs(side - frames[map][way]) <= 2));
}"""

_DRAWN = "(images) => images.map((one) => one.naturalWidth > 20 && one.width > 20)"


@pytest.mark.slow
def test_maps_return_after_change_of_tab(seat: Seat) -> None:
    demonstrate(seat)
    frames = seat.page.evaluate(_MAPS)
    assert len(frames) == 1
    assert min(frames[0]) > 200
    assert seat.page.locator(".pictured img").evaluate_all(_DRAWN) == [True] * 5
    for load in ("20 MPa", "30 MPa"):
        seat.turn("Compare")
        seat.page.get_by_role("button", name="Keep this state as A").wait_for()
        before = text_of(seat.number("Load"))
        seat.type("Value with unit", load)
        wait_for_change(seat, "Load", before)
        seat.turn("Contact")
        seat.page.wait_for_function(_MAPS, arg=frames, timeout=20000)
        assert seat.page.locator(".pictured img").evaluate_all(_DRAWN) == [True] * 5


@pytest.mark.slow
def test_form_is_chosen_with_its_order_and_removed_on_its_line(seat: Seat, served: Served) -> None:
    demonstrate(seat)
    project = served.folder / seat.key / "project.toml"
    seat.unfold("Prepare")
    seat.choose("Form to remove", "polynomial of order 3")
    wait_for_file(seat, project, lambda text: 'form = "polynomial 3"' in text)
    seat.page.get_by_text("Up to date").wait_for()
    seat.page.get_by_role("button", name="Remove", exact=True).nth(1).click()
    wait_for_file(seat, project, lambda text: "form =" not in text)


def wait_for_value(field: Any, text: str) -> None:
    """Wait until a field holds a text; the page may replace the field meanwhile."""
    for _ in range(100):
        if field.input_value() == text:
            return
        field.page.wait_for_timeout(200)
    raise AssertionError(field.input_value())


def wait_for_file(seat: Seat, path: Path, is_so: Callable[[str], bool]) -> None:
    """Wait until a file holds what it shall."""
    for _ in range(100):
        if is_so(path.read_text()):
            return
        seat.page.wait_for_timeout(200)
    raise AssertionError(path.read_text())


@pytest.mark.slow
def test_long_solve_is_canceled_while_page_responds(seat: Seat) -> None:
    demonstrate(seat)
    page = seat.page
    seat.turn("Analyze")
    page.get_by_label("Resolution study").check()
    page.get_by_role("button", name="Start").click()
    page.get_by_text("s so far").wait_for()
    # The page responds during the job.
    before = text_of(seat.number("Load"))
    seat.type("Value with unit", "20 MPa")
    wait_for_change(seat, "Load", before)
    page.get_by_text("s so far").wait_for()
    page.get_by_role("button", name="Cancel").locator("visible=true").click()
    page.get_by_text("Canceled; nothing is saved.").wait_for()
    assert page.get_by_role("button", name="Start").is_enabled()


@pytest.mark.slow
def test_start_right_after_a_change_of_tab_starts_the_new_panel(seat: Seat) -> None:
    demonstrate(seat)
    page = seat.page
    start = page.get_by_role("button", name="Start").locator("visible=true")
    seat.turn("Analyze")
    start.wait_for()
    # At once: the panel of before is still there.
    seat.turn("Joint")
    start.click()
    page.get_by_text("s so far").locator("visible=true").wait_for()
    assert page.get_by_label("Interface law").is_visible()
    page.get_by_role("button", name="Cancel").locator("visible=true").click()
    page.get_by_text("Canceled; nothing is saved.").wait_for()


@pytest.mark.slow
def test_invalid_file_is_rejected_in_one_sentence(seat: Seat, measured_file: Path) -> None:
    seat.choose_file(measured_file, measured_file.name)
    specify_and_solve(seat)
    load = text_of(seat.number("Load"))
    wrong = {"name": "broken.opd", "mimeType": "", "buffer": b"no map at all" * 100}
    # The step was folded at the first contact.
    seat.unfold("Map")
    seat.page.locator("input[type=file]").first.set_input_files(wrong)
    text = text_of(seat.alert("broken.opd"))
    assert "Traceback" not in text
    assert text.startswith("broken.opd")
    assert "map-" not in text
    # The map and its result stay.
    assert text_of(seat.number("Load")) == load
    assert seat.page.locator("p > b").get_by_text(measured_file.name, exact=True).count() == 1
    seat.choose_file(measured_file, measured_file.name)
    seat.alert("broken.opd").wait_for(state="hidden")


_DROP = """(text) => {
  const data = new DataTransfer();
  data.items.add(new File([text], "grid.txt"));
  const about = { bubbles: true, cancelable: true, composed: true, dataTransfer: data };
  for (const name of ["dragover", "drop"]) {
    const event = new DragEvent(name, about);
    document.body.dispatchEvent(event);
    // Else the browser leaves the page for the file.
    if (!event.defaultPrevented) throw new Error(name);
  }
}"""


def test_file_is_dropped_anywhere_and_typed_text_survives_reload(
    seat: Seat, served: Served
) -> None:
    page = seat.page
    header = (
        "# roughcontact map\n# quantity: height\n# unit: um\n# pixel_y: 1 um\n# pixel_x: 1 um\n"
    )
    rows = "\n".join(" ".join(str((3 * i + 5 * j) % 7) for j in range(16)) for i in range(16))
    page.evaluate(_DROP, header + rows)
    page.locator("p > b").get_by_text("grid.txt", exact=True).wait_for()
    seat.type("Value with unit", "20 MPa")
    field = page.get_by_label("Value with unit")
    project = served.folder / seat.key / "project.toml"
    wait_for_file(seat, project, lambda text: 'load = "20 MPa"' in text)
    # Typed, and not entered.
    field.press("Control+a")
    field.press_sequentially("120 MPa")
    page.reload()
    seat.loaded()
    wait_for_value(field, "120 MPa")
    wait_for_file(seat, project, lambda text: 'load = "120 MPa"' in text)
    # Entered, and reloaded at once.
    field.press("Control+a")
    field.press_sequentially("60 MPa")
    field.press("Enter")
    page.reload()
    seat.loaded()
    wait_for_value(field, "60 MPa")
    # Undo is there after a reload, too.
    page.get_by_role("button", name="Undo").first.click()
    wait_for_value(field, "120 MPa")


@pytest.mark.slow
def test_missing_units_are_requested_and_file_name_is_escaped(seat: Seat) -> None:
    page = seat.page
    seat.choose_file(
        {"name": EVIL, "mimeType": "", "buffer": array(1e6 * rc.reference_map(64)[0])}, EVIL
    )
    # The missing input is named at its control.
    page.get_by_label("Unit of the heights").locator("visible=true").wait_for()
    seat.type("Unit of the heights", "bananas")
    seat.alert("bananas").first.wait_for()
    seat.type("Unit of the heights", "um")
    sides = page.get_by_label("Side lengths (y × x)", exact=True).locator("visible=true").first
    sides.fill("64 um")
    sides.press("Enter")
    specify_and_solve(seat)
    seat.type("Value with unit", "5 bananas")
    seat.alert("bananas").first.wait_for()
    invalid = page.locator("input[aria-invalid=true]")
    invalid.wait_for()
    seat.type("Value with unit", "20 MPa")
    seat.alert("bananas").first.wait_for(state="hidden")
    invalid.wait_for(state="hidden")
    seat.turn("Export")
    page.get_by_role("button", name="Copy").first.click()
    page.get_by_role("button", name="Copied").wait_for()
    page.locator("pre").filter(has_text=EVIL).first.wait_for()
    assert page.locator("img[src=x]").count() == 0


@pytest.mark.slow
def test_project_survives_crash_and_reload(seat: Seat, served: Served) -> None:
    demonstrate(seat)
    load = text_of(seat.number("Load"))
    seat.page.reload()
    seat.loaded()
    seat.number("Load").filter(has_text=load).wait_for()
    served.kill()
    try:
        seat.alert("start the program again").wait_for()
    finally:
        served.start()
    seat.page.reload()
    seat.loaded()
    seat.page.get_by_text("converged, certificate").wait_for()
    assert text_of(seat.number("Load")) == load
    assert seat.page.get_by_label("Value with unit").input_value() == "10 MPa"
    assert seat.alert("start the program again").count() == 0


def test_every_control_has_a_name_and_a_tablet_shows_them(seat: Seat) -> None:
    page = seat.page
    for width, height in ((1280, 800), (1024, 768)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_function("width => document.documentElement.scrollWidth <= width", arg=width)
    unfold(page)
    for tab in ("Contact", "Analyze", "Joint", "Compare", "Export"):
        seat.turn(tab)
        # The text arrives in parts.
        for _ in range(100):
            found = controls_of(page)
            if len(found) > 30 and not nameless(found):
                break
            page.wait_for_timeout(100)
        assert len(found) > 30
        assert nameless(found) == []
        # Otherwise the server receives a known value again, and warns.
        assert page.evaluate("Bokeh.documents[0]._new_models.size") == 0


def unfold(page: Any) -> None:
    """Open all that is folded, and what is folded in it."""
    for _ in range(60):
        folded = page.locator(f"button.card-header:has({FOLDED})").locator("visible=true")
        if folded.count() == 0:
            return
        folded.first.click()
    raise AssertionError("something stays folded")


def controls_of(page: Any) -> list[str]:
    """Return the controls of a page as a screen reader announces them."""
    kinds = r"- (?:textbox|combobox|button|slider|checkbox|radio|spinbutton|tab|link)\b"
    return re.findall(rf"^\s*{kinds}.*$", page.locator("body").aria_snapshot(), re.MULTILINE)


def nameless(controls: list[str]) -> list[str]:
    return [line for line in controls if not re.search(r"- \w+ [\"'/]", line)]


@pytest.mark.slow
def test_main_tasks_work_with_keyboard_only(seat: Seat, tmp_path: Path) -> None:
    """Use each control that Tab reaches with keys only."""
    page = seat.page

    def reach(element: Any) -> None:
        """Go to an element by Tab."""
        element.wait_for()
        for _ in range(150):
            if element.evaluate("(e) => e === e.getRootNode().activeElement"):
                return
            page.keyboard.press("Tab")
        raise AssertionError("Tab does not lead there")

    reach(page.get_by_label("Or a demonstration map"))
    page.keyboard.type("Polished")
    page.locator("p > b").get_by_text("Polished, isotropic.npz", exact=True).wait_for()
    reach(page.get_by_label("Material", exact=True))
    page.keyboard.type("100Cr6")
    reach(page.get_by_role("radio", name="the whole contact: none beyond"))
    page.keyboard.press("Space")
    reach(page.get_by_label("Value with unit"))
    page.keyboard.type("10 MPa")
    page.keyboard.press("Enter")
    page.get_by_text("converged, certificate").wait_for()
    before = text_of(seat.number("Load"))
    reach(page.get_by_role("slider"))
    page.keyboard.press("ArrowRight")
    wait_for_change(seat, "Load", before)
    reach(page.get_by_role("tab", name="Contact", exact=True))
    page.keyboard.press("ArrowLeft")
    page.get_by_role("tab", name="Export", selected=True).wait_for()
    reach(page.get_by_label("File", exact=True))
    page.keyboard.type("result (.nc")
    reach(page.get_by_role("button", name="Save result"))
    page.keyboard.press("Enter")
    link = page.locator("a[download]")
    reach(link)
    with page.expect_download() as coming:
        page.keyboard.press("Enter")
    path = tmp_path / coming.value.suggested_filename
    coming.value.save_as(path)
    assert rc.read_result(path).converged


@pytest.mark.slow
def test_a_page_that_cannot_take_up_a_change_is_loaded_again_and_never_without_end(
    seat: Seat,
) -> None:
    demonstrate(seat)
    page = seat.page
    broken = """() => { try { Bokeh.documents[0].apply_json_patch({events: [
        {kind: "ModelChanged", model: {id: "unknown"}, attr: "text", new: ""}]}) } catch { } }"""
    with page.expect_navigation():
        page.evaluate(broken)
    seat.loaded()
    page.get_by_text("converged, certificate").wait_for()
    page.evaluate(broken)
    seat.alert("old state").wait_for()


@pytest.mark.slow
def test_two_tabs_of_one_project_are_both_live(seat: Seat, served: Served, chromium: Any) -> None:
    demonstrate(seat)
    other = Seat(chromium, f"{served.home}&work={seat.key}")
    other.page.get_by_text("converged, certificate").wait_for()
    for one, load in ((other, "30 MPa"), (seat, "50 MPa")):
        one.type("Value with unit", load)
        for tab in (seat, other):
            tab.number("Load").filter(has_text=load).wait_for()
            assert tab.page.get_by_label("Value with unit").input_value() == load
    assert other.errors == []
    other.page.close()


# Parts that scroll sideways, and parts that scroll inside another that scrolls.
_SCROLLING = """() => {
  const found = [];
  const walk = (root, inside) => {
    for (const one of root.children) {
      const look = getComputedStyle(one);
      const down = /auto|scroll/.test(look.overflowY) && one.scrollHeight > one.clientHeight + 1;
      const across = /auto|scroll/.test(look.overflowX) && one.scrollWidth > one.clientWidth + 1;
      if (across || (down && inside)) found.push(`${one.tagName} ${one.className}`);
      walk(one.shadowRoot ?? one, inside || down);
    }
  };
  walk(document.body, false);
  if (document.documentElement.scrollHeight > window.innerHeight + 1) found.push("page");
  return found;
}"""


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1024, 768), (1280, 800), (1440, 900), (1920, 1080)])
def test_no_sheet_scrolls_inside_a_scroll_or_sideways(seat: Seat, size: tuple[int, int]) -> None:
    page = seat.page
    page.set_viewport_size({"width": size[0], "height": size[1]})
    assert page.evaluate(_SCROLLING) == []
    demonstrate(seat)
    for tab in ("Analyze", "Compare", "Export", "Contact"):
        seat.turn(tab)
        page.wait_for_timeout(500)
        assert page.evaluate(_SCROLLING) == [], tab
    # No tab next to the maps or below them is covered.
    for name, shown in (("Spots", r"^\d+ contact spots"), ("Results", "converged, cert")):
        tab, text = page.get_by_role("tab", name=name), page.get_by_text(re.compile(shown)).first
        tab.click()
        text.wait_for()
        above, below = tab.bounding_box(), text.bounding_box()
        assert above is not None
        assert below is not None
        assert above["y"] + above["height"] <= below["y"]
    page.get_by_role("tab", name="2 Pressure").scroll_into_view_if_needed()
    # The large map and its thumbnails are all within the window.
    page.wait_for_function(
        """(size) => [...Bokeh.documents[0]._all_models.values()]
          .filter((m) => m.type == "Figure" && m.frame_width)
          .map((m) => Bokeh.index.find_one_by_id(m.id)?.el.getBoundingClientRect())
          .every((place) => place && place.right <= size[0] && place.bottom <= size[1])""",
        arg=list(size),
    )
    # The map is true to scale, and more than half as wide as the window.
    wanted, frame, whole = page.evaluate("""() => {
      const map = [...Bokeh.documents[0]._all_models.values()]
        .find((m) => m.type == "Figure" && m.frame_width);
      const view = Bokeh.index.find_one_by_id(map.id), { width, height } = view.frame.bbox;
      return [[map.frame_width, map.frame_height], [width, height],
        view.el.getBoundingClientRect().width];
    }""")
    assert frame == wanted
    assert whole >= (0.55 if size[0] == 1280 else 0.45) * size[0]
    place = page.locator("div.pictured").bounding_box()
    assert place is not None
    assert place["x"] + place["width"] <= size[0]
    assert place["y"] + place["height"] <= size[1]


@pytest.mark.slow
def test_keys_and_clicks_enlarge_a_map_and_open_the_drawers(seat: Seat) -> None:
    demonstrate(seat)
    page = seat.page
    page.get_by_role("heading", name="roughcontact").click()
    page.keyboard.press("4")
    page.get_by_role("tab", name="4 Gap", selected=True).wait_for()
    large = """(text) => [...Bokeh.documents[0]._all_models.values()].some((m) =>
      m.type == "Figure" && m.frame_width > 200 && m.title.text.startsWith(text))"""
    page.wait_for_function(large, arg="Gap")
    page.get_by_role("tab", name="3 Contact").locator("img").click()
    page.get_by_role("tab", name="3 Contact", selected=True).wait_for()
    page.wait_for_function(large, arg="Contact")
    page.keyboard.press("?")
    page.get_by_text("enlarge heights, pressure").wait_for()
    # The drawer begins where the header ends, and the slider is long.
    head = page.locator("button.card-header").first.bounding_box()
    drawer = page.get_by_role("heading", name="Keys").bounding_box()
    slider = page.get_by_role("slider").bounding_box()
    assert head is not None
    assert drawer is not None
    assert slider is not None
    assert 0 <= drawer["y"] - head["y"] < 40
    assert slider["width"] > 220
    page.keyboard.press("Escape")
    page.get_by_text("enlarge heights, pressure").wait_for(state="hidden")
    seat.type("Value with unit", "20 MPa")
    seat.number("Load").filter(has_text="20 MPa").wait_for()
    page.get_by_role("heading", name="roughcontact").click()
    page.keyboard.press("Control+z")
    seat.number("Load").filter(has_text="10 MPa").wait_for()
    page.keyboard.press("Control+Shift+Z")
    seat.number("Load").filter(has_text="20 MPa").wait_for()


_BAR = """() => {
  const models = [...Bokeh.documents[0]._all_models.values()];
  const map = models.find((m) => m.type == "Figure" && m.frame_width);
  const view = Bokeh.index.find_one_by_id(map.id), { frame } = view;
  const at = view.canvas_view.el.getBoundingClientRect();
  const { low, high } = map.right.find((m) => m.type == "ColorBar" && m.visible).color_mapper;
  const { left, right, top, bottom } = frame.bbox, y = map.y_range;
  return { x: at.x + right + 8, top: at.y + top, bottom: at.y + bottom, low, high,
    y: [y.start, y.end] };
}"""


@pytest.mark.slow
def test_color_limits_follow_the_color_bar(seat: Seat) -> None:
    demonstrate(seat)
    page = seat.page
    before = page.evaluate(_BAR)
    third = (before["bottom"] - before["top"]) / 4
    # A color at three quarters of the bar is moved to its middle.
    page.mouse.move(before["x"], before["top"] + third)
    page.mouse.down()
    page.mouse.move(before["x"], before["top"] + 2 * third, steps=6)
    page.mouse.up()
    after = page.evaluate(_BAR)
    assert after["high"] == pytest.approx(1.5 * before["high"], rel=0.02)
    assert after["low"] == before["low"]
    assert after["y"] == before["y"]
    # The limits stay under another load.
    load = text_of(seat.number("Load"))
    seat.type("Value with unit", "30 MPa")
    wait_for_change(seat, "Load", load)
    page.get_by_text("Up to date").wait_for()
    assert page.evaluate(_BAR)["high"] == pytest.approx(after["high"])
    page.mouse.dblclick(before["x"], before["top"] + third)
    page.wait_for_function(f"(high) => ({_BAR})().high < 0.9 * high", arg=after["high"])


@pytest.mark.slow
def test_a_drag_is_live_and_ends_with_the_contact_itself(seat: Seat) -> None:
    demonstrate(seat)
    page = seat.page
    at = page.get_by_role("slider").bounding_box()
    assert at is not None
    page.mouse.move(at["x"] + at["width"] / 2, at["y"] + at["height"] / 2)
    page.mouse.down()
    seen = set()
    for step in range(1, 16):
        page.mouse.move(at["x"] + (0.5 + 0.01 * step) * at["width"], at["y"] + at["height"] / 2)
        page.wait_for_timeout(200)
        seen.add(text_of(seat.number("Load")))
    page.get_by_text("Preview on 256 × 256 pixels").wait_for()
    assert len(seen) > 3
    # The state is that of before until the thumb is let go.
    assert page.get_by_label("Value with unit").input_value() == "10 MPa"
    page.mouse.up()
    page.get_by_text("Up to date").wait_for()
    given = page.get_by_label("Value with unit").input_value()
    assert given != "10 MPa"
    assert page.get_by_role("slider").get_attribute("aria-valuetext") == given
    page.get_by_text("converged, certificate").wait_for()


@pytest.mark.slow
def test_checklist_leads_to_missing_inputs(seat: Seat) -> None:
    page = seat.page
    page.get_by_role("button", name="Polished, isotropic", exact=True).click()
    page.get_by_role("button", name="✓ Map", exact=True).wait_for()
    steps = ("2 Material", "Material"), ("3 Extent", None), ("4 Load", "Load given as")
    for check, control in steps:
        page.get_by_role("button", name=check, exact=True).click()
        field = (
            page.get_by_role("radio").first
            if control is None
            else page.get_by_label(control, exact=True)
        )
        field.wait_for()
    seat.choose("Material", "100Cr6")
    page.get_by_role("button", name="✓ Material", exact=True).wait_for()
    seat.choose("Boundary", "the whole contact")
    page.get_by_role("button", name="✓ Extent", exact=True).wait_for()
