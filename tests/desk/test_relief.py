"""The 3-D view: what it gives the browser is the map, and what the browser draws and keeps."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageChops

import roughcontact as rc

pytest.importorskip("panel", reason="needs roughcontact[desk]")

from browsing import Seat, Served, browser, lacking
from roughcontact.desk import relief
from roughcontact.desk.maps import PRESSURE, MapsView, result_scales
from roughcontact.desk.session import Session
from roughcontact.drawing.style import OPEN

PIXEL = (2e-6, 1e-6)
STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)
GIVEN = {"material": "100Cr6", "boundary": "periodic"}
PATIENCE = 60.0


@pytest.fixture
def path(tmp_path: Path) -> Path:
    heights = 1e-7 * np.random.default_rng(3).standard_normal((20, 30))
    rc.Surface(heights, PIXEL).save(tmp_path / "map.npz")
    return tmp_path / "map.npz"


@pytest.fixture
def view(tmp_path: Path) -> Iterator[relief.ReliefView]:
    session = Session(tmp_path / "project.toml", lambda _: None)
    yield relief.ReliefView(session, MapsView())
    session.close()


def show_view(view: relief.ReliefView, **given: str) -> Any:
    session = view._session
    for name, value in given.items():
        session.set_option(name, value)
    assert session.wait(PATIENCE)
    outcome = session.outcome
    result = None if outcome is None else outcome.contact
    assert session.prepared is not None
    view._maps.show_contact(session.prepared.surfaces[0], result)
    view.refresh()
    return result


def heights_of(canvas: Any) -> tuple[dict[str, Any], np.ndarray]:
    head = json.loads(canvas.heights[0])
    values = np.frombuffer(canvas.heights[1], np.float32)
    return head, values.reshape(head["ny"], head["nx"])


def levels_of(canvas: Any) -> np.ndarray:
    head = json.loads(canvas.colors[0])
    return np.frombuffer(canvas.colors[1], np.uint8).reshape(head["ny"], head["nx"])


@pytest.mark.long
def test_the_browser_gets_the_heights_and_the_colors_of_the_pressure(
    view: relief.ReliefView, path: Path
) -> None:
    view._session.open_map(path)
    result = show_view(view, **GIVEN, load="50 mN")
    head, values = heights_of(view._canvas)
    own = result.surface.heights
    np.testing.assert_array_equal(values, (own - own.mean()).astype(np.float32))
    assert head["side"] == pytest.approx([20 * 2e-6, 30 * 1e-6])
    assert head["low"] == values.min()
    assert head["high"] == values.max()
    levels = levels_of(view._canvas)
    np.testing.assert_array_equal(levels > 0, result.pressure > 0)
    # A level is as much of the color bar as the pressure is of its top.
    limit = result_scales(result)[PRESSURE].high
    inside = (result.pressure > 0) & (result.pressure <= limit)
    np.testing.assert_allclose(
        (levels[inside] - 0.5) / 254, result.pressure[inside] / limit, atol=0.5001 / 254
    )
    canvas = view._canvas
    assert len(canvas.palette) == 256
    mapper = view._maps.bars[PRESSURE].color_mapper
    assert (canvas.palette[0], canvas.palette[1]) == (OPEN, mapper.palette[0])
    assert canvas.palette[254:] == [mapper.palette[-1], mapper.high_color]


@pytest.mark.long
def test_another_load_sends_no_heights_again(view: relief.ReliefView, path: Path) -> None:
    view._session.open_map(path)
    show_view(view, **GIVEN, load="50 mN")
    sent: list[str] = []
    view._canvas.param.watch(
        lambda *events: sent.extend(e.name for e in events), ["heights", "colors", "palette"]
    )
    show_view(view, load="100 mN")
    assert "heights" not in sent
    assert "colors" in sent
    sent.clear()
    view.refresh()
    assert sent == []
    # Color limits are those of the map.
    view._maps.mappers[PRESSURE].high /= 2
    view.refresh()
    assert sent == ["colors"]


@pytest.mark.long
def test_map_without_contact_has_colors_of_heights(view: relief.ReliefView, path: Path) -> None:
    view._session.open_map(path)
    assert show_view(view) is None
    assert json.loads(view._canvas.colors[0])["title"] == "Heights"
    assert len(np.unique(levels_of(view._canvas))) > 100


def test_missing_points_are_distinct_from_all_heights() -> None:
    heights = np.random.default_rng(0).standard_normal((8, 8))
    heights[2:4, 5] = np.nan
    head, data = relief._heights(rc.Surface(heights, PIXEL))
    values = np.frombuffer(data, np.float32).reshape(8, 8)
    np.testing.assert_array_equal(values < -1e29, np.isnan(heights))
    assert abs(json.loads(head)["low"]) < 10


def test_large_map_is_reduced_with_note() -> None:
    heights = np.random.default_rng(0).standard_normal((700, 1400))
    head, data = relief._heights(rc.Surface(heights, PIXEL))
    about = json.loads(head)
    assert (about["ny"], about["nx"]) == (234, 467)
    assert "234 × 467 cells of 3 × 3 points" in about["note"]
    values = np.frombuffer(data, np.float32).reshape(234, 467)
    assert values[5, 7] == pytest.approx(heights[15:18, 21:24].mean() - heights.mean(), abs=1e-6)


def test_the_exaggeration_is_a_round_factor_that_fills_a_part_of_the_box() -> None:
    for height in (1e-9, 3e-7, 2e-6):
        heights = np.linspace(0, height, 64).reshape(8, 8)
        about = json.loads(relief._heights(rc.Surface(heights, (1e-6, 1e-6)))[0])
        share = about["factor"] * height / 8e-6
        assert 0.1 < share <= 0.3001
        assert f"{about['factor']:e}"[0] in "125"


@pytest.mark.long
def test_profile_is_rejected_in_one_sentence(view: relief.ReliefView, tmp_path: Path) -> None:
    heights = 1e-7 * np.random.default_rng(3).standard_normal(64)
    rc.Surface(heights[None], (1.0, 1e-6)).save(tmp_path / "profile.npz")
    view._session.open_map(tmp_path / "profile.npz")
    show_view(view)
    assert view._canvas.heights == []
    assert "no third dimension" in view._note.object


# In a browser


_LACKING = lacking()


@pytest.fixture(scope="module")
def seat(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Seat]:
    program = Served(tmp_path_factory.mktemp("desk") / "works")
    try:
        with browser() as started:
            sitting = Seat(started, program.home)
            yield sitting
            sitting.page.close()
            assert sitting.foreign == sitting.dialogs == sitting.errors == []
    finally:
        program.kill()


def count_drawings(seat: Seat, more_than: int = 0) -> int:
    """Wait until the scene is drawn again, and return how many times it was."""
    seat.page.wait_for_function("(count) => window.scene().dataset.drawn > count", arg=more_than)
    return int(seat.page.evaluate("Number(window.scene().dataset.drawn)"))


# Components have a shadow root, which selectors of the page do not enter.
_FIND = """() => {
  const within = (root) => [...root.querySelectorAll("*")].flatMap(
    (part) => [part, ...(part.shadowRoot ? within(part.shadowRoot) : [])]);
  window.scene = () => within(document).find((part) => part.className == "relief");
  window.picture = () => window.scene().querySelectorAll("canvas")[1];
}"""


def picture(seat: Seat) -> Image.Image:
    return Image.open(io.BytesIO(seat.page.locator(".scene").screenshot())).convert("RGB")


def are_equal_images(first: Image.Image, second: Image.Image) -> bool:
    """Return whether two pictures are one but for the rounding of the corners of the page."""
    return all(high <= 2 for _, high in ImageChops.difference(first, second).getextrema())


@pytest.mark.process
@pytest.mark.skipif(bool(_LACKING), reason=f"there is no {', no '.join(_LACKING)}")
def test_view_rotates_zooms_and_follows_load(seat: Seat, path: Path) -> None:
    page = seat.page
    seat.choose_file(path, path.name)
    seat.choose("Material", "100Cr6")
    seat.choose("Boundary", "the whole contact")
    seat.type("Value with unit", "20 MPa")
    page.get_by_text("converged, certificate").wait_for()
    seat.turn("3-D")
    scene = page.locator(".scene")
    scene.wait_for()
    page.evaluate(_FIND)
    count = count_drawings(seat)
    label = str(scene.get_attribute("aria-label"))
    assert "exaggerated" in label
    assert "colored by Pressure" in label
    first = picture(seat)
    assert len(first.getcolors(2**20) or []) > 200, "a lit surface has many shades"
    # To turn, to zoom, and back.
    at = scene.bounding_box()
    assert at is not None
    page.mouse.move(at["x"] + 200, at["y"] + 150)
    page.mouse.down()
    page.mouse.move(at["x"] + 320, at["y"] + 180, steps=3)
    page.mouse.up()
    page.mouse.wheel(0, -300)
    count = count_drawings(seat, count)
    page.wait_for_timeout(500)
    assert not are_equal_images(picture(seat), first)
    page.mouse.dblclick(at["x"] + 200, at["y"] + 150)
    page.wait_for_timeout(500)
    assert are_equal_images(picture(seat), first)
    scene.press("ArrowLeft")
    page.wait_for_timeout(500)
    assert not are_equal_images(picture(seat), first)
    scene.press("0")
    # The labels have the color of the text of the page.
    count = count_drawings(seat, count)
    for scheme in ("dark", "light"):
        page.wait_for_timeout(500)
        count = count_drawings(seat)
        page.emulate_media(color_scheme=scheme)
        count_drawings(seat, count)
    # Another load colors the same surface.
    seat.type("Value with unit", "40 MPa")
    page.wait_for_function(
        "() => window.scene().querySelector('.scene').ariaLabel.includes('40 MPa')"
    )


@pytest.mark.process
@pytest.mark.skipif(bool(_LACKING), reason=f"there is no {', no '.join(_LACKING)}")
def test_missing_webgl_is_reported(seat: Seat, path: Path) -> None:
    page = seat.page
    page.add_init_script(
        "HTMLCanvasElement.prototype.getContext = new Proxy("
        "HTMLCanvasElement.prototype.getContext, {apply: (call, canvas, given) =>"
        " given[0] == 'webgl2' ? null : Reflect.apply(call, canvas, given)})"
    )
    page.reload()
    seat.loaded()
    seat.turn("3-D")
    page.get_by_text("The maps show the same values").wait_for()
