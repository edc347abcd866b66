"""The server: who is let in, what comes from it, and how pages and server end."""

from __future__ import annotations

import contextlib
import http.client
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

pytest.importorskip("panel")

from roughcontact.desk.server import Server, Settings, Visit

PATIENCE = 60.0
WORDS = "the words of the page"


@dataclass(frozen=True)
class Answer:
    status: int
    headers: Any
    text: str


class Desk:
    """A server in a thread, and the visits of its pages."""

    def __init__(self, folder: Path, **more: Any) -> None:
        self.visits: list[Visit] = []
        self.ended: list[str] = []
        self.server = Server(self.page, Settings(folder=folder, port=0, **more))
        self.thread = threading.Thread(target=self.server.run, daemon=True)
        self.thread.start()

    def page(self, visit: Visit) -> Any:
        import panel as pn

        self.visits.append(visit)
        visit.at_end(lambda: self.ended.append(visit.work.key))
        return pn.Column(pn.pane.Str(WORDS), pn.widgets.FloatSlider())

    def close(self) -> None:
        self.server.stop()
        self.thread.join(PATIENCE)
        assert not self.thread.is_alive()

    @property
    def port(self) -> int:
        return self.server.port

    @property
    def home(self) -> str:
        parts = urlsplit(self.server.url)
        return f"{parts.path}?{parts.query}"

    def ask(
        self, path: str, method: str = "GET", body: bytes | None = None, **headers: str
    ) -> Answer:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        sent = {name.replace("_", "-"): value for name, value in headers.items()}
        with contextlib.closing(connection):
            connection.request(method, path, body, sent)
            answer = connection.getresponse()
            return Answer(answer.status, answer.headers, answer.read().decode("utf-8", "replace"))


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    made = Desk(tmp_path_factory.mktemp("desk") / "works", upload_limit=1000)
    yield made
    made.close()


def test_a_page_is_served(desk: Desk) -> None:
    answer = desk.ask(desk.home)
    assert answer.status == 200
    assert "roughcontact" in answer.text
    assert desk.visits[-1].work.key in desk.home
    assert desk.visits[-1].folder.is_dir()


def test_a_page_without_a_work_gets_a_new_one(desk: Desk) -> None:
    answer = desk.ask("/")
    assert answer.status == 302
    place = answer.headers["Location"]
    assert place.startswith("/?work=")
    assert place != desk.home
    assert desk.ask(place).status == 200
    assert desk.visits[-1].work.key in place


def test_a_work_that_is_gone_is_said_to_be(desk: Desk) -> None:
    answer = desk.ask("/?work=" + "x" * 32)
    assert answer.status == 404
    assert "not there any more" in answer.text


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "evil.example:5106"},
        {"Host": "127.0.0.1.evil.example"},
        {"Host": "localhost@evil.example"},
        {"Host": ""},
        {"Origin": "http://evil.example"},
        {"Origin": "http://localhost:3000"},
        {"Origin": "null"},
        {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"},
    ],
)
@pytest.mark.parametrize("path", ["/", "/static/js/bokeh.min.js", "/ws", "/upload"])
def test_strangers_are_refused(desk: Desk, headers: dict[str, str], path: str) -> None:
    # Tornado knows what is no host at all.
    broken = "@" in headers.get("Host", "")
    assert desk.ask(path, **headers).status == (400 if broken else 403)


def test_names_of_this_machine_are_its_own(desk: Desk) -> None:
    for host in ("localhost:8888", "127.0.0.1", f"LOCALHOST:{desk.port}", "[::1]:5106"):
        assert desk.ask("/favicon.ico", Host=host).status == 200
        assert desk.ask("/favicon.ico", Host=host, Origin=f"http://{host}").status == 200
