"""A desk in a separate process and a browser that looks at it: for tests, times and pictures."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
TIMEOUT = 90.0
"""Seconds for anything to come; what fails takes so long, nothing else does."""

FOLDED = ".icon-tabler-chevron-right"
"""Head of a folded part."""

# Where the ends of the section stand on the screen, on the large map.
_ENDS = """() => {
  const models = [...Bokeh.documents[0]._all_models.values()];
  const ends = models.filter((m) => m.type == "BoxAnnotation" && m.resizable == "none");
  const [map] = models.filter((m) => m.type == "Figure" && m.frame_width && m.visible)
    .sort((one, other) => other.frame_width - one.frame_width);
  const view = Bokeh.index.find_one_by_id(map.id);
  const at = view.canvas_view.el.getBoundingClientRect();
  return ends.map((end) => [
    at.x + view.frame.x_scale.compute((end.left + end.right) / 2),
    at.y + view.frame.y_scale.compute((end.top + end.bottom) / 2),
  ]);
}"""

_TITLES = """() => [...Bokeh.documents[0]._all_models.values()]
  .filter((m) => m.type == "Figure").map((m) => m.title.text)"""


def browser_program() -> str:
    """Return the browser of this system, empty where there is none."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((path for path in map(shutil.which, names) if path), "")


def lacking() -> list[str]:
    """Return the missing program for a test of pages, if any."""
    needed = {"browser (Chromium or Chrome)": bool(browser_program())} | {
        f"package {name}": importlib.util.find_spec(name) is not None
        for name in ("playwright", "panel")
    }
    return [name for name, found in needed.items() if not found]


class Served:
    """The program, which can be ended and started again on the same folder."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.folder, self._words = folder, words
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = int(free.getsockname()[1])
        self.process: subprocess.Popen[str] | None = None
        self.token = ""
        # The address of the project with the map of the command.
        self.first = ""
        self.start()

    @property
    def home(self) -> str:
        """The address that starts a new project."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"

    def start(self) -> None:
        """Start it, and wait until it listens."""
        about = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
        command = ["desk", "--no-browser", "--folder", str(self.folder), "--port", str(self.port)]
        command += self._words
        self.process = subprocess.Popen(
            [sys.executable, "-m", "roughcontact", *command],
            stdout=subprocess.PIPE,
            text=True,
            env=about,
        )
        assert self.process.stdout is not None
        self.first = self.process.stdout.readline().strip()
        found = re.match(r"http://.*[?]token=([\w-]+)", self.first)
        assert found is not None
        self.token = found[1]

    def kill(self) -> None:
        """End it as a crash does."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            assert self.process.stdout is not None
            self.process.stdout.close()
            self.process = None


@contextmanager
def browser() -> Iterator[Any]:
    """Start a browser without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        started = play.chromium.launch(
            executable_path=browser_program(), args=["--no-sandbox", "--disable-dev-shm-usage"]
        )
        try:
            yield started
        finally:
            started.close()


class Seat:
    """One page, with what happened on it that must not: other hosts asked, dialogs, errors."""

    def __init__(self, browser: Any, url: str, width: int = 1280, height: int = 800) -> None:
        self.page = browser.new_page(viewport={"width": width, "height": height})
        self.page.set_default_timeout(1000 * TIMEOUT)
        self.foreign: list[str] = []
        self.dialogs: list[str] = []
        self.errors: list[str] = []
        self.page.on("request", self._check_request)
        self.page.on("websocket", lambda socket: self._reached(socket.url))
        self.page.on("dialog", self._spoken)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)[:200]))
        self.open(url)

    def open(self, url: str) -> None:
        """Open an address and wait for the page."""
        self.page.goto(url)
        self.loaded()

    def loaded(self) -> None:
        """Wait for the page."""
        self.page.get_by_label("Value with unit").wait_for()
        self.page.get_by_role("slider").wait_for()

    @property
    def key(self) -> str:
        """The key of its project."""
        found = re.search(r"work=([\w-]+)", self.page.url)
        assert found is not None
        return found[1]

    def number(self, name: str) -> Any:
        """Return where a headline number stands."""
        return self.page.locator("dl.numbers div").filter(has_text=name).locator("dd")

    def alert(self, text: str) -> Any:
        """Return the warnings that contain a text."""
        return self.page.get_by_role("alert").filter(has_text=text)

    def choose_file(self, file: Any, shown: str) -> None:
        """Choose a file, and wait until the page has read it."""
        self.page.locator("input[type=file]").first.set_input_files(file)
        self.page.locator("p > b").get_by_text(shown, exact=True).wait_for()

    def unfold(self, title: str) -> None:
        """Open a step of the left column."""
        head = self.page.locator("button.card-header").filter(has_text=title).first
        if head.locator(FOLDED).count():
            head.click()

    def choose(self, label: str, option: str) -> None:
        """Choose an option by how its words begin, among buttons or in a list."""
        buttons = self.page.get_by_role("radio", name=re.compile(f"^{re.escape(option)}"))
        box = self.page.get_by_label(label, exact=True)
        buttons.or_(box).first.wait_for()
        if buttons.count():
            buttons.check()
            return
        words = box.locator("option").all_text_contents()
        box.select_option(label=next(text for text in words if text.startswith(option)))

    def type(self, label: str, text: str) -> None:
        """Type into a field, and leave it."""
        field = self.page.get_by_label(label, exact=True)
        field.fill(text)
        field.press("Enter")

    def turn(self, name: str) -> None:
        """Turn to a tab."""
        self.page.get_by_role("tab", name=name, exact=True).click()

    def ends(self) -> list[list[float]]:
        """Return the places of the ends of the section on the screen, when the page is at rest."""
        self.page.get_by_role("status").get_by_text("up to date").wait_for()
        before, now = None, self.page.evaluate(_ENDS)
        # The layout moves with the last column of the result.
        while before != now:
            self.page.wait_for_timeout(500)
            before, now = now, self.page.evaluate(_ENDS)
        return [list(end) for end in now]

    def titles(self) -> list[str]:
        """Return the titles of all figures."""
        return [str(title) for title in self.page.evaluate(_TITLES)]

    def wait_for_title(self, text: str) -> None:
        """Wait until a figure has a title with some words."""
        self.page.wait_for_function(
            f"(text) => ({_TITLES})().some((t) => t.includes(text))", arg=text
        )

    def download(self, kind: str, folder: Path) -> Path:
        """Create and download a file."""
        self.turn("Export")
        self.choose("File", kind)
        before = self.page.locator("a[download]").count()
        self.page.get_by_role("button", name=f"Save {kind.partition(' ')[0]}").click()
        link = self.page.locator("a[download]").nth(before)
        link.wait_for()
        with self.page.expect_download() as coming:
            link.click()
        path = folder / coming.value.suggested_filename
        coming.value.save_as(path)
        return path

    def _check_request(self, request: Any) -> None:
        if not request.url.startswith(("data:", "blob:")):
            self._reached(request.url)

    def _reached(self, url: str) -> None:
        if not re.match(r"(http|ws)://127\.0\.0\.1:\d+/", url):
            self.foreign.append(url[:200])

    def _spoken(self, dialog: Any) -> None:
        self.dialogs.append(json.dumps(dialog.message))
        dialog.dismiss()


if __name__ == "__main__":
    missing = lacking()
    if missing:
        words = ", no ".join(missing)
        print(f"browser tests (tests/desk/test_page_browser.py): SKIPPED, there is no {words}")
    else:
        print("browser tests (tests/desk/test_page_browser.py): ran")
