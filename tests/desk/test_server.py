"""The server: who is let in, what comes from it, and how pages and server end."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest

pytest.importorskip("panel")

from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from roughcontact.cli import app
from roughcontact.desk import server
from roughcontact.desk.server import PageVisit, Server, Settings
from roughcontact.errors import InputError

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
        self.visits: list[PageVisit] = []
        self.ended: list[str] = []
        self.cookie = ""
        self.server = Server(lambda: self.page, Settings(**{"folder": folder, "port": 0, **more}))
        self.thread = threading.Thread(target=self.server.run, daemon=True)
        self.thread.start()
        assert self.server._ready.wait(PATIENCE)
        parts = urlsplit(self.server.url)
        shown = self.ask(f"/?{parts.query}", Host=parts.netloc)
        assert shown.status == 302
        self.cookie = shown.headers["Set-Cookie"].partition(";")[0]
        self.home = shown.headers["Location"]

    def page(self, visit: PageVisit) -> Any:
        import panel as pn

        self.visits.append(visit)
        visit.add_close_callback(lambda: self.ended.append(visit.work.key))
        return pn.Column(pn.pane.Str(WORDS), pn.widgets.FloatSlider())

    def close(self) -> None:
        self.server.stop()
        self.thread.join(PATIENCE)
        assert not self.thread.is_alive()

    @property
    def port(self) -> int:
        return self.server.port

    def ask(
        self, path: str, method: str = "GET", body: bytes | None = None, **headers: str
    ) -> Answer:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        sent = {"Cookie": self.cookie} | {
            name.replace("_", "-"): value for name, value in headers.items()
        }
        with contextlib.closing(connection):
            connection.request(method, path, body, sent)
            answer = connection.getresponse()
            return Answer(answer.status, answer.headers, answer.read().decode("utf-8", "replace"))

    def open(self, path: str) -> Answer:
        """Request a page, and wait until it is complete."""
        before = len(self.visits)
        answer = self.ask(path)
        until(lambda: len(self.visits) > before)
        return answer


def until(true: Any) -> None:
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    made = Desk(tmp_path_factory.mktemp("desk") / "works", upload_limit=1000)
    yield made
    made.close()


def test_a_page_is_served(desk: Desk) -> None:
    answer = desk.open(desk.home)
    assert answer.status == 200
    assert "roughcontact" in answer.text
    assert desk.visits[-1].work.key in desk.home
    assert desk.visits[-1].folder.is_dir()


def test_page_without_project_gets_new_project(desk: Desk) -> None:
    answer = desk.ask("/")
    assert answer.status == 302
    place = answer.headers["Location"]
    assert place.startswith("/?work=")
    assert place != desk.home
    assert desk.open(place).status == 200
    assert desk.visits[-1].work.key in place


def test_project_has_no_folder_before_its_first_file(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    before = sorted(os.listdir(tmp_path))
    desk.home = desk.ask("/").headers["Location"]
    desk.open(desk.home)
    assert sorted(os.listdir(tmp_path)) == before
    assert not [name for name in before if len(name) == 32]
    assert upload(desk, "a.npy", b"x").status == 200
    (folder,) = set(os.listdir(tmp_path)) - set(before)
    assert folder == desk.visits[-1].work.key
    desk.close()


def test_removed_project_is_reported(desk: Desk) -> None:
    answer = desk.ask("/?work=" + "x" * 32)
    assert answer.status == 404
    assert "no longer exists" in answer.text


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
def test_requests_of_other_hosts_are_rejected(
    desk: Desk, headers: dict[str, str], path: str
) -> None:
    # Tornado rejects invalid hosts.
    broken = "@" in headers.get("Host", "")
    assert desk.ask(path, **headers).status == (400 if broken else 403)


def test_names_of_this_machine_are_its_own(desk: Desk) -> None:
    for host in ("localhost:8888", "127.0.0.1", f"LOCALHOST:{desk.port}", "[::1]:5106"):
        assert desk.ask("/favicon.ico", Host=host).status == 200
        assert desk.ask("/favicon.ico", Host=host, Origin=f"http://{host}").status == 200


# The websocket of a page


def token_of(page: Answer) -> str:
    found = re.search(r'"token":"([^"]+)"', page.text)
    assert found is not None
    return found[1]


async def connected(desk: Desk, token: str, **headers: str) -> Any:
    sent = {"Cookie": desk.cookie, **headers}
    request = HTTPRequest(f"ws://127.0.0.1:{desk.port}/ws", headers=sent)
    return await websocket_connect(request, subprotocols=["bokeh", token])


async def parted(connection: Any) -> None:
    connection.close()
    while await connection.read_message() is not None:
        pass
    # Its side of the closing has a turn.
    await asyncio.sleep(0.05)


def test_a_page_of_this_server_is_connected_and_no_other(desk: Desk) -> None:
    token = token_of(desk.ask(desk.home))

    async def own() -> Any:
        connection = await connected(desk, token, Origin=f"http://127.0.0.1:{desk.port}")
        first = await connection.read_message()
        await parted(connection)
        return json.loads(first)

    assert asyncio.run(own())["msgtype"] == "ACK"
    for headers in (
        {"Origin": "http://evil.example"},
        {"Origin": f"http://localhost:{desk.port + 1}"},
        {"Host": "evil.example", "Origin": "http://evil.example"},
    ):
        with pytest.raises(HTTPClientError) as caught:
            asyncio.run(connected(desk, token, **headers))
        assert caught.value.code == 403


def test_change_before_first_drawing_is_sent(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """A change between the copy that a browser gets of a page and its first drawing is not lost."""
    import panel as pn

    made: list[Any] = []

    def page(visit: PageVisit) -> Any:
        made[:] = [pn.state.curdoc, pn.Column(pn.pane.Str(WORDS))]
        desk.visits.append(visit)
        return made[1]

    monkeypatch.setattr(desk, "page", page)
    monkeypatch.setattr(desk.server, "_page", page)
    token = token_of(desk.open(desk.home))

    async def expected() -> str:
        connection = await connected(desk, token)
        # The acknowledgment has three parts.
        for _ in range(3):
            await connection.read_message()
        header = {"msgid": "1", "msgtype": "PULL-DOC-REQ"}
        for part in (header, {}, {}):
            await connection.write_message(json.dumps(part))
        heard = ""
        while "PULL-DOC-REPLY" not in heard:
            heard = await connection.read_message()
        document, column = made
        document.add_next_tick_callback(lambda: column.append(pn.pane.Str("what came late")))
        while "what came late" not in heard:
            heard = await asyncio.wait_for(connection.read_message(), 5.0)
        await parted(connection)
        return heard

    assert '"name":"panel.models.markup.HTML"' in asyncio.run(expected())


def test_forged_session_is_rejected(desk: Desk) -> None:
    token = token_of(desk.open(desk.home))
    opened = len(desk.visits)

    async def forged() -> Any:
        connection = await connected(desk, token[:-2] + "xx")
        first = await connection.read_message()
        connection.close()
        return first

    assert asyncio.run(forged()) is None
    assert len(desk.visits) == opened


def test_resources_of_page_are_released_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "_LINGER", 1.0)
    monkeypatch.setattr(server, "_LOOK", 0.05)
    desk = Desk(tmp_path)
    token = token_of(desk.open(desk.home))

    async def stay_and_go() -> PageVisit:
        connection = await connected(desk, token)
        await connection.read_message()
        visit = desk.visits[-1]
        (visit.folder / "result.nc").write_bytes(b"x")
        await asyncio.sleep(1.3)
        assert visit.folder.exists()
        await parted(connection)
        return visit

    visit = asyncio.run(stay_and_go())
    until(lambda: len(desk.ended) == len(desk.visits) and not visit.folder.exists())
    assert visit.work.folder.exists()
    desk.close()


def test_resources_of_open_pages_are_released_with_server(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    desk.open(desk.home)
    assert desk.visits[0].folder.exists()
    desk.close()
    assert desk.ended == [desk.visits[0].work.key]
    assert not desk.visits[0].folder.exists()
    assert desk.visits[0].work.folder.exists()


# Files that are brought


def upload(desk: Desk, name: str, body: bytes, **headers: str) -> Answer:
    return desk.ask(f"/upload{desk.home[1:]}&name={name}", "POST", body, **headers)


def test_file_is_uploaded_and_saved(desk: Desk) -> None:
    before = set(os.listdir(desk.visits[0].work.folder))
    answer = upload(desk, "..%2F%3Cb%3Eground.OPD", b"x" * 1000)
    assert answer.status == 200
    record = json.loads(answer.text)
    assert record["name"] == "<b>ground.OPD"
    path = desk.visits[0].work.folder / record["file"]
    assert path.read_bytes() == b"x" * 1000
    assert set(os.listdir(path.parent)) - before == {path.name}
    assert path.suffix == ".opd"


def test_too_large_file_is_rejected(desk: Desk) -> None:
    before = sorted(os.listdir(desk.visits[0].work.folder))
    answer = upload(desk, "a.opd", b"x" * 1001)
    assert answer.status == 413
    assert json.loads(answer.text)["error"].startswith("a.opd has more than 1000 bytes")
    assert "--upload-limit" in json.loads(answer.text)["error"]
    assert sorted(os.listdir(desk.visits[0].work.folder)) == before


def test_all_files_together_are_bounded(desk: Desk) -> None:
    statuses = [
        upload(desk, "a.npy", b"x" * 1000).status for _ in range(server.MAX_TOTAL_UPLOADS + 1)
    ]
    assert statuses[0] == 200
    assert statuses[-1] == 413
    refused = json.loads(upload(desk, "a.npy", b"x" * 1000).text)
    assert "Remove projects" in refused["error"]
    for path in desk.visits[0].work.folder.glob("map-*"):
        path.unlink()
    assert upload(desk, "a.npy", b"x" * 1000).status == 200


def test_file_without_project_is_rejected(desk: Desk) -> None:
    answer = desk.ask("/upload?work=" + "x" * 32 + "&name=a.opd", "POST", b"x")
    assert answer.status == 404
    assert "no longer exists" in json.loads(answer.text)["error"]
    assert desk.ask(f"/upload{desk.home[1:]}&name=a.opd").status == 405


def test_incomplete_upload_leaves_no_file(desk: Desk) -> None:
    folder = desk.visits[0].work.folder
    before = sorted(os.listdir(folder))
    connection = http.client.HTTPConnection("127.0.0.1", desk.port, timeout=PATIENCE)
    with contextlib.closing(connection):
        connection.putrequest("POST", f"/upload{desk.home[1:]}&name=a.opd")
        connection.putheader("Content-Length", "900")
        connection.putheader("Cookie", desk.cookie)
        connection.endheaders(b"x" * 100)
        until(lambda: sorted(os.listdir(folder)) != before)
    until(lambda: sorted(os.listdir(folder)) == before)


def test_other_requests_are_small(desk: Desk) -> None:
    with contextlib.suppress(ConnectionError):
        assert desk.ask("/", "POST", b"x" * 2**21).status in (400, 405)


# Others


def test_failed_page_reports_reason_and_releases_resources(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(visit: PageVisit) -> Any:
        assert visit.folder.exists()
        desk.visits.append(visit)
        visit.add_close_callback(lambda: desk.ended.append("broken"))
        raise InputError("the project file of this page cannot be read")

    desk.open(desk.home)
    monkeypatch.setattr(desk.server, "_page", broken)
    answer = desk.open(desk.home)
    assert answer.status == 200
    assert "Traceback" not in answer.text
    folder = desk.visits.pop().folder
    until(lambda: not folder.exists())
    assert desk.ended[-1] == "broken"


def test_error_during_import_ends_server(tmp_path: Path) -> None:
    def load() -> Any:
        raise InputError("not installed")

    served = Server(load, Settings(folder=tmp_path, port=0))
    with pytest.raises(InputError, match="not installed"):
        served.run()


def test_too_many_pages_are_reported(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    desk.open(desk.home)
    monkeypatch.setattr(server, "MAX_PAGES", 1)
    opened = len(desk.visits)
    token = token_of(desk.ask(desk.home))
    assert "pages are open" in asyncio.run(pulled(desk, token))
    assert len(desk.visits) == opened


async def pulled(desk: Desk, token: str) -> str:
    """Return the content of a page as sent to the browser."""
    connection = await connected(desk, token)
    for _ in range(3):
        await connection.read_message()
    for part in ({"msgid": "1", "msgtype": "PULL-DOC-REQ"}, {}, {}):
        await connection.write_message(json.dumps(part))
    heard = ""
    while "PULL-DOC-REPLY" not in heard:
        message = await connection.read_message()
        assert message is not None
        heard = str(message)
    await connection.read_message()
    found = str(await connection.read_message())
    await parted(connection)
    return found


def test_a_mistake_leaves_no_white_page(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(visit: PageVisit) -> Any:
        raise ZeroDivisionError

    desk.open(desk.home)
    monkeypatch.setattr(desk.server, "_page", broken)
    token = token_of(desk.ask(desk.home))
    assert "An internal error" in asyncio.run(pulled(desk, token))


def test_page_loads_nothing_from_other_servers(desk: Desk) -> None:
    page = desk.ask(desk.home)
    # A notebook on this machine may frame the page; nothing is fetched from there.
    policy = page.headers["Content-Security-Policy"].partition("frame-ancestors")[0]
    assert "default-src 'self'" in policy
    assert "http:" not in policy
    assert "https:" not in policy
    links = re.findall(r"""(?:src|href)=["']([^"']+)""", page.text)
    assert any("bokeh" in link for link in links)
    for link in links:
        assert not link.startswith(("http", "//"))
        assert desk.ask("/" + link.removeprefix("./").lstrip("/")).status == 200


@pytest.mark.parametrize("origins", [(), ("http://lab-pc:5106",)])
def test_request_without_token_is_rejected(tmp_path: Path, origins: tuple[str, ...]) -> None:
    desk = Desk(tmp_path, origins=origins)
    parts = urlsplit(desk.server.url)
    assert parts.netloc == (f"127.0.0.1:{desk.port}" if not origins else "lab-pc:5106")
    there = {"Host": parts.netloc, "Cookie": ""}
    for path in (
        "/",
        desk.home,
        "/?token=wrong",
        "/?token=%ff",
        f"/upload{desk.home[1:]}",
        "/made",
    ):
        assert desk.ask(path, **there).status == 403
    assert desk.ask("/ws", **there, Origin=f"http://{parts.netloc}").status == 403
    name, _, value = desk.cookie.partition("=")
    assert desk.ask("/", **{**there, "Cookie": f"{name}={value[:-1]}x"}).status == 403
    shown = desk.ask(f"/?{parts.query}", **there)
    assert shown.status == 302
    assert "token" not in shown.headers["Location"]
    cookie = shown.headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Lax" in cookie
    page = desk.ask(shown.headers["Location"], **{**there, "Cookie": cookie.partition(";")[0]})
    assert page.status == 200
    # The page contains nothing of it.
    assert cookie.partition(";")[0].partition("=")[2] not in page.text
    assert desk.ask(shown.headers["Location"], Host="evil.example").status == 403
    desk.close()


@pytest.mark.parametrize(("origins", "status"), [((), 200), (("http://lab-pc:5106",), 403)])
def test_browser_of_same_machine_is_admitted_after_restart(
    tmp_path: Path, origins: tuple[str, ...], status: int
) -> None:
    first = Desk(tmp_path, origins=origins)
    first.close()
    again = Desk(tmp_path, origins=origins, port=first.port)
    assert again.ask(again.home, Cookie=first.cookie).status == status
    again.close()
    assert not origins or not (tmp_path / "secret").exists()
    assert origins or (tmp_path / "secret").stat().st_mode & 0o077 == 0


def test_a_frame_keeps_its_token_for_it_has_no_cookie(desk: Desk) -> None:
    asked = urlsplit(desk.server.url).query
    before = len(desk.visits)
    answer = desk.ask(f"/?{asked}", Cookie="", Sec_Fetch_Dest="iframe")
    assert answer.status == 200
    until(lambda: len(desk.visits) > before)
    assert f"token={desk.visits[-1].token}" in asked
    assert f"token={desk.visits[-1].token}" in desk.visits[-1].offer(Path("a-1.nc"))


def test_token_is_hidden_from_other_programs(desk: Desk) -> None:
    with desk.server.login_file() as address:
        path = Path(url2pathname(urlsplit(address).path))
        assert "token" not in address
        assert desk.server.url.replace("&", "&amp;") in path.read_text(encoding="utf-8")
        assert path.parent.stat().st_mode & 0o077 == 0
    assert not path.exists()


def test_other_hosts_are_admitted_if_allowed() -> None:
    with pytest.raises(InputError, match="admits other machines") as caught:
        Settings(address="0.0.0.0")
    assert caught.value.argument == "address"
    assert not Settings().is_open
    assert Settings(origins=("http://lab-pc:5106",)).is_open


def test_occupied_port_raises_input_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with server._open_socket(Settings(port=0))[0] as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"^port {port} of 127") as caught:
            server._open_socket(Settings(port=port))
        assert caught.value.argument == "port"
        monkeypatch.setattr(server, "PORT", port)
        other, free = server._open_socket(Settings())
        assert free != port
        other.close()


# The command


@pytest.mark.long
def test_the_command_serves_a_page_until_it_is_interrupted(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "roughcontact", "desk", "--no-browser"]
    with subprocess.Popen(
        [*command, "--folder", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        parts = urlsplit(process.stdout.readline().strip())
        assert parts.hostname == "127.0.0.1"
        connection = http.client.HTTPConnection("127.0.0.1", parts.port or 0, timeout=PATIENCE)
        with contextlib.closing(connection):
            connection.request("GET", f"/?{parts.query}")
            assert connection.getresponse().status == 302
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == app.SOLVED
    assert out == ""
    assert err == ""
    assert not list(tmp_path.glob("*/page-*"))


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["nothere.opd"], "nothere.opd does not exist; check the name of the file"),
        (
            ["--address", "0.0.0.0"],
            "--address 0.0.0.0 admits other machines: give "
            "--allow-origin which address their browsers show, such as --allow-origin "
            "http://lab-pc:5106",
        ),
        (
            ["--allow-origin", "*"],
            "--allow-origin must be an address such as 'http://lab-pc:5106', got '*'",
        ),
        (
            ["--upload-limit", "much"],
            "--upload-limit must be a size such as '500 MB' or '2 GiB', got 'much'",
        ),
    ],
)
def test_invalid_options_are_rejected_in_one_sentence(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert app.main(["desk", *words]) == app.BAD_INPUT
    assert capsys.readouterr().err == f"roughcontact: error: {sentence}\n"


def test_missing_panel_names_installation(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert app.main(["desk"]) == app.BAD_INPUT
    assert capsys.readouterr().err == (
        "roughcontact: error: the desk needs Panel; run pip install 'roughcontact[desk]'\n"
    )


@pytest.mark.process
def test_server_listens_before_heavy_imports() -> None:
    words = "import sys, roughcontact.desk.server; print(*sys.modules)"
    found = subprocess.run(
        [sys.executable, "-c", words], capture_output=True, text=True, check=True
    )
    heavy = {name.partition(".")[0] for name in found.stdout.split()}
    assert not heavy & {"panel", "bokeh", "matplotlib", "numpy", "scipy"}
