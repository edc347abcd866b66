"""The saved page: its values are those of the contact, and it needs nothing but a browser."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel", reason="needs roughcontact[desk]")

from browsing import browser, lacking
from roughcontact.analyses.tasks import from_text
from roughcontact.contact.result import ContactResult
from roughcontact.desk import saved_page
from roughcontact.errors import InputError
from roughcontact.request.request import Request
from roughcontact.request.run import run_request

PIXEL = (2e-6, 1e-6)


def contact(folder: Path, shape: tuple[int, int], name: str = "map.npz") -> Request:
    heights = 1e-7 * np.random.default_rng(3).standard_normal(shape)
    heights[1, 2] = np.nan
    rc.Surface(heights, PIXEL).save(folder / name)
    given = {"material": "100Cr6", "boundary": "periodic", "missing": "mask", "load": "20 MPa"}
    return from_text("solve", folder / name, given)


def solve_request(request: Request) -> ContactResult:
    result = run_request(request, lambda _: None).contact
    assert result is not None
    return result


@pytest.mark.long
def test_names_of_files_are_never_markup(tmp_path: Path) -> None:
    request = contact(tmp_path, (8, 8), "<script>alert(1)<script>.npz")
    text = saved_page.render_page(solve_request(request), request)
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text


@pytest.mark.long
def test_a_profile_has_no_page(tmp_path: Path) -> None:
    heights = 1e-7 * np.random.default_rng(3).standard_normal((1, 64))
    rc.Surface(heights, (1.0, 1e-6)).save(tmp_path / "profile.npz")
    given = {"material": "100Cr6", "boundary": "periodic", "load": "1 N/mm"}
    request = from_text("solve", tmp_path / "profile.npz", given)
    with pytest.raises(InputError, match="no maps"):
        saved_page.render_page(solve_request(request), request)


@pytest.mark.slow
def test_a_large_map_stays_below_ten_megabytes(tmp_path: Path) -> None:
    request = contact(tmp_path, (1024, 1024))
    outcome = saved_page.save_page(lambda _: None, request, tmp_path / "page.html")
    assert outcome.written == (tmp_path / "page.html",)
    assert (tmp_path / "page.html").stat().st_size < 10e6
    plots = saved_page._linked_maps(outcome.contact).children[0].children
    for plot in plots:
        data = plot.renderers[0].data_source.data
        assert data["display"][0]["cell"] == [2, 2]
        assert data[plot.renderers[0].glyph.image][0].shape == (512, 512)


# In a browser


_LACKING = lacking()

_STATE = """() => {
  const models = [...Bokeh.documents[0]._all_models.values()];
  const range = (name) => [...new Set(models.filter((m) => m.type == "Figure")
    .map((m) => m[name]))].map((r) => [r.start, r.end]);
  return { figures: models.filter((m) => m.type == "Figure").length,
           x: range("x_range"), y: range("y_range") };
}"""


@pytest.fixture
def sheet(tmp_path: Path) -> Iterator[tuple[Any, ContactResult]]:
    """Open a saved page, and check that it sends no request and reports no error."""
    request = contact(tmp_path, (40, 60))
    outcome = saved_page.save_page(lambda _: None, request, tmp_path / "page.html")
    assert outcome.contact is not None
    with browser() as started:
        page = started.new_page(viewport={"width": 1280, "height": 900})
        asked: list[str] = []
        errors: list[str] = []
        page.on("request", lambda one: asked.append(one.url))
        page.on("pageerror", lambda error: errors.append(str(error)[:300]))
        page.goto((tmp_path / "page.html").as_uri())
        page.wait_for_function(
            "() => window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle"
        )
        yield page, outcome.contact
        assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
        assert errors == []
        page.close()


@pytest.mark.process
@pytest.mark.skipif(bool(_LACKING), reason=f"there is no {', no '.join(_LACKING)}")
def test_saved_page_is_self_contained_with_linked_maps(sheet: Any) -> None:
    page, result = sheet
    before = page.evaluate(_STATE)
    assert before["figures"] == 5
    assert len(before["x"]) == len(before["y"]) == 1, "all maps have one view"
    place = page.evaluate("""() => {
      const map = [...Bokeh.documents[0]._all_models.values()].find((m) => m.type == "Figure");
      const view = Bokeh.index.find_one_by_id(map.id);
      const at = view.canvas_view.el.getBoundingClientRect();
      return [at.x + view.frame.x_scale.compute(20.5), at.y + view.frame.y_scale.compute(31)];
    }""")
    page.mouse.move(*place)
    row = page.locator("tr").filter(has=page.get_by_text("height", exact=True)).locator("td").nth(1)
    row.wait_for()
    number, unit = str(row.text_content()).split()
    surface = result.surface
    height = surface.heights[15, 20] - np.nanmean(surface.heights)
    assert float(number) * {"nm": 1e-9, "µm": 1e-6}[unit] == pytest.approx(height, rel=1e-3)
    page.mouse.wheel(0, -400)
    page.wait_for_function(
        f"(width) => {{const state = ({_STATE})(); return state.x[0][1] - state.x[0][0] < width }}",
        arg=0.9 * (before["x"][0][1] - before["x"][0][0]),
    )
    page.mouse.dblclick(*place)
    page.wait_for_function(
        f"(x) => JSON.stringify(({_STATE})().x) == x",
        arg=json.dumps(before["x"], separators=(",", ":")),
    )
    text = page.locator("body").inner_text()
    command = str(page.locator("pre").first.text_content())
    assert shlex.split(command)[:2] == ["roughcontact", "solve"]
    assert Path(shlex.split(command)[2]).name == "map.npz"
    assert "rc.solve(" in text
    assert " to " in str(page.locator("body > table").text_content())
