from __future__ import annotations

import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.desk.session import from_script
from roughcontact.errors import InputError
from roughcontact.request.run import run_request

pytest.importorskip("panel", reason="needs roughcontact[desk]")

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1.1e9)


@pytest.fixture
def surface() -> rc.Surface:
    heights = 1e-7 * np.random.default_rng(1).standard_normal((16, 24))
    return rc.Surface(heights, (1e-6, 2e-6))


@pytest.fixture
def opened_pages(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Any]]:
    from roughcontact.desk import explore

    pages: list[Any] = []
    made = explore.DeskServer

    def record_page(*arguments: Any) -> Any:
        pages.append(made(*arguments))
        return pages[-1]

    monkeypatch.setattr(explore, "DeskServer", record_page)
    yield pages
    for page in pages:
        page.close()


def work_of(page: Any) -> Path:
    """Return the project file behind a page."""
    server = page._end.peek()[2][0]
    return Path(server.first.project)


def test_explored_result_has_same_numbers(surface: rc.Surface, opened_pages: list[Any]) -> None:
    result = rc.solve(
        surface, load=0.0123456789, material=STEEL, counter_material=rc.Material(70e9, 0.33)
    )
    page = result.explore()
    project = work_of(page)
    state = from_script(project.read_text("utf-8"), project.parent)
    again = run_request(state.request(), lambda _: None).contact
    assert again is not None
    assert np.array_equal(again.pressure, result.pressure)


def test_the_page_is_served_and_ends(surface: rc.Surface, opened_pages: list[Any]) -> None:
    page = surface.explore()
    visitor = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with visitor.open(page.url, timeout=60) as answer:
        assert answer.status == 200
    assert page.url in page._repr_html_().replace("&amp;", "&")
    folder = work_of(page).parent
    page.close()
    assert not folder.exists()


def test_explore_of_unsupported_objects_raises_input_error(surface: rc.Surface) -> None:
    with pytest.raises(InputError, match="the page"):
        rc.Surface(surface.heights[0], 1e-6).explore()
    limited = rc.solve(
        surface, load=0.01, material=STEEL, ceiling=np.full(surface.shape, 3e9), tolerance=1e-4
    )
    with pytest.raises(InputError, match="no ceiling per pixel"):
        limited.explore()
