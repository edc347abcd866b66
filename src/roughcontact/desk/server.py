"""Server of the browser app: by default for this machine only."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import html
import logging
import re
import secrets
import signal
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any, cast
from urllib.parse import urlencode

from tornado import web
from tornado.http1connection import HTTP1Connection

import roughcontact as rc
from roughcontact import errors
from roughcontact._tools import processes
from roughcontact.desk import projects
from roughcontact.desk.access import work_key
from roughcontact.desk.workers import WorkerPool

_log = logging.getLogger(__name__)

HOST, PORT = "127.0.0.1", 5106
"""Default address and port."""

UPLOAD_LIMIT = 2**30
"""Default maximum size of an uploaded file [bytes]."""

MAX_PAGES = 32
"""Maximum number of open pages: each holds its maps in memory."""

MAX_TOTAL_UPLOADS = 8
"""Maximum total size of the files of all projects, over the upload limit of one file."""

UPLOADS = "/upload"
"""Route of uploads: ``POST /upload?work=KEY&name=NAME``, with the file as body."""

OFFERED = "/made"
"""Route of downloads: ``GET /made?work=KEY&page=FOLDER&file=NAME``."""

# Maximum size of messages and of requests other than uploads [bytes]: both are small.
_MAX_MESSAGE_BYTES = 20 * 2**20
_MAX_REQUEST_BYTES = 2**20
# Lifetime of a closed page, interval of checks, delay of the release of its memory [s].
_LINGER, _LOOK, _REST = 20, 5, 2
_EXPIRY = 3600
# Delay before a process is started for the first job [ms].
_WARM = 3000
_FULL = (
    f"{MAX_PAGES} pages are open, the maximum of this program: close one that is "
    "not needed, and reload this page half a minute later."
)
_LOGIN_PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8">
<meta http-equiv="refresh" content="0; url={url}"><title>roughcontact</title></head>
<body><p><a href="{url}">Open the page</a></p></body></html>
"""
_LOOPBACK = ("127.0.0.1", "localhost", "::1")


@dataclass(frozen=True)
class Settings:
    """Options of the command that starts the server."""

    file: Path | None = None  # Map of the first project
    address: str = HOST  # Address to listen on
    port: int | None = None  # Port; None for the default port, or a free one
    origins: tuple[str, ...] = ()  # Allowed origins of requests from other machines
    folder: Path | None = None  # Folder of saved projects
    upload_limit: int = UPLOAD_LIMIT  # Maximum size of an uploaded file [bytes]
    browser: bool = True  # Whether to open the page in a browser

    def __post_init__(self) -> None:
        """Raise `InputError` for an address of other machines without allowed origins."""
        if self.address not in _LOOPBACK and not self.origins:
            raise rc.InputError(
                f"{self.address} admits other machines: give ",
                errors.ArgumentRef("allow_origin"),
                " which address their browsers show, such as ",
                errors.ArgumentRef("allow_origin", "http://lab-pc:5106"),
                argument="address",
            )

    @property
    def is_open(self) -> bool:
        """Whether other machines can connect."""
        return self.address not in _LOOPBACK or bool(self.origins)


@dataclass(frozen=True)
class PageVisit:
    """Open page in a browser, with its project and its resources."""

    work: projects.SavedProject  # Project of the page
    file: Path | None  # Map of the command line, if the project has no state yet
    workers: WorkerPool  # Pool that runs jobs in other processes
    upload_limit: int  # Maximum size of an uploaded file [bytes]
    forget: Callable[[], None]  # Removes the project with all its files
    earlier: Callable[[], list[projects.SavedProject]]  # Returns the other saved projects
    peers: Callable[[], list[PageVisit]] = list  # Returns the other pages of the project
    token: str = ""  # Access token, if the browser stores no cookie
    listeners: list[Callable[[Any], None]] = field(default_factory=list)
    _ends: ExitStack = field(default_factory=ExitStack)
    _files: ExitStack = field(default_factory=ExitStack)

    @cached_property
    def folder(self) -> Path:
        """Temporary folder of the page, created on first use."""
        return self._files.enter_context(self.work.page())

    def close(self) -> None:
        """Release the resources of the page; its files go last."""
        with self._files:
            self._ends.close()

    def offer(self, path: Path) -> str:
        """Return the relative URL of a file in the folder of the page."""
        requested = {"work": self.work.key, "page": self.folder.name, "file": path.name}
        if self.token:
            requested["token"] = self.token
        return f"{OFFERED[1:]}?{urlencode(requested)}"

    def share(self, state: Any) -> None:
        """Send the new state to the other pages of the same project."""
        for visit in self.peers():
            for take in visit.listeners:
                take(state)

    def add_close_callback(self, done: Callable[[], object]) -> None:
        """Register a callback for the end of the page; the last one runs first."""
        self._ends.callback(done)


Page = Callable[[PageVisit], Any]
"""Function of a `PageVisit` that returns content for Panel."""

Load = Callable[[], Page]
"""Function that imports and returns a `Page`, called after the server listens."""


class Server:
    """Server that listens from its creation on."""

    def __init__(self, load: Load, settings: Settings) -> None:
        self._load, self._settings = load, settings
        self._socket, self.port = _open_socket(settings)
        self._works = projects.ProjectStore(settings.folder)
        self._works.expire()
        self._visits: dict[str, PageVisit] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._server: Any = None
        self._tidying: asyncio.TimerHandle | None = None
        self._ready = threading.Event()
        self._token = secrets.token_urlsafe(24)
        self.first = self._works.reserve()
        self.bench = WorkerPool()

    @property
    def url(self) -> str:
        """URL of the first project, with the access token."""
        origins = self._settings.origins
        base = origins[0] if origins else f"http://{HOST}:{self.port}"
        return f"{base}/?{urlencode({'token': self._token, 'work': self.first.key})}"

    @contextlib.contextmanager
    def login_file(self) -> Iterator[str]:
        """Yield the URL of a temporary file that redirects to `url`."""
        with tempfile.TemporaryDirectory(prefix="open-", dir=self._works.folder) as folder:
            path = Path(folder) / "open.html"
            path.write_text(_LOGIN_PAGE.format(url=html.escape(self.url)), encoding="utf-8")
            yield path.as_uri()

    def run(self) -> None:
        """Serve until `stop` or a termination signal; then close pages and processes."""
        with contextlib.ExitStack() as ends:
            ends.callback(self.bench.close)
            ends.callback(self._socket.close)
            ends.callback(self._leave_all)
            self._loop = loop = asyncio.new_event_loop()
            asyncio.set_event_loop(loop)
            ends.callback(loop.close)
            ends.callback(asyncio.set_event_loop, None)
            if self._settings.file is not None:
                # The process that reads the map starts while Panel is imported.
                self.bench.prestart()
            try:
                # Browsers wait at the open socket meanwhile.
                self._import()
                self._server = self._create_server()
                self._server.start()
            finally:
                self._ready.set()
            ends.callback(self._close, loop)
            with _stop_on_signals(loop):
                loop.run_forever()

    def stop(self) -> None:
        """Stop `run`, from another thread."""
        self._ready.wait()
        assert self._loop is not None
        self._loop.call_soon_threadsafe(self._loop.stop)

    def _close(self, loop: Any) -> None:
        self._server.stop(wait=False)
        # Cancel requests that still wait.
        waiting = asyncio.all_tasks(loop)
        for task in waiting:
            task.cancel()
        loop.run_until_complete(asyncio.wait(waiting) if waiting else _run_callbacks())

    def _import(self) -> None:
        # Imported objects stay: excluding them makes garbage collection ten times as fast.
        gc.disable()
        try:
            import panel.io.server  # noqa: F401

            self._page = self._load()
        finally:
            gc.freeze()
            gc.enable()

    def _create_server(self) -> Any:
        """Return the server of pages, behind the access policy."""
        import bokeh.settings
        from bokeh.core.validation import silence
        from bokeh.core.validation.warnings import EMPTY_LAYOUT
        from bokeh.server.server import BaseServer
        from bokeh.server.tornado import BokehTornado
        from panel.io.application import build_applications
        from panel.io.server import DIST_DIR
        from tornado.httpserver import HTTPServer
        from tornado.ioloop import IOLoop, PeriodicCallback

        from roughcontact.desk import access

        # Empty layouts are filled later.
        silence(EMPTY_LAYOUT)
        bokeh.settings.settings.resources = "server"
        app = BokehTornado(
            build_applications({"/": self._make_page}, title="roughcontact"),
            extra_patterns=[
                (OFFERED, DownloadHandler, {"works": self._works}),
                (
                    UPLOADS,
                    UploadHandler,
                    {
                        "works": self._works,
                        "limit": self._settings.upload_limit,
                        "together": MAX_TOTAL_UPLOADS * self._settings.upload_limit,
                    },
                ),
            ],
            # The access policy has checked the origin.
            extra_websocket_origins=["*"],
            secret_key=secrets.token_bytes(32),
            sign_sessions=True,
            include_headers=[],
            include_cookies=[],
            use_index=False,
            ico_path=str(DIST_DIR / "images" / "favicon.ico"),
            websocket_max_message_size_bytes=_MAX_MESSAGE_BYTES,
            unused_session_lifetime_milliseconds=_LINGER * 1000,
            check_unused_sessions_milliseconds=_LOOK * 1000,
            transforms=[access.GuardedApplication],
            log_function=access.log_nothing,
        )
        # If other machines can connect, their access expires with the program.
        own = not self._settings.is_open
        secret = self._works.secret if own else secrets.token_bytes(32)
        door = access.AccessPolicy(self._settings.origins, self._token, secret, self.port)
        http = HTTPServer(
            access.guard_application(
                door, self._is_known_work, lambda: self._works.reserve().key, app
            ),
            max_body_size=_MAX_REQUEST_BYTES,
        )
        http.add_socket(self._socket)
        self._expiring = PeriodicCallback(self._works.expire, _EXPIRY * 1000)
        self._expiring.start()
        return BaseServer(IOLoop.current(), app, http)

    def _is_known_work(self, key: str) -> bool:
        return self._works.open_project(key) is not None

    def _make_page(self) -> Any:
        """Return the content of a new page."""
        import panel as pn

        from roughcontact.desk import access, widgets

        document = pn.state.curdoc
        assert document is not None
        context = document.session_context
        work = self._works.open_project(access.work_key(context.request))
        if work is None:
            return pn.pane.Str("This project no longer exists.")
        if len(self._visits) >= MAX_PAGES:
            return pn.pane.Str(_FULL)
        fresh = work.key == self.first.key and not work.project.exists()
        visit = PageVisit(
            work,
            self._settings.file if fresh else None,
            self.bench,
            self._settings.upload_limit,
            partial(self._works.remove, work.key),
            partial(self._other_visits, work),
            partial(self._peer_visits, context.id),
            access.query_value(context.request, access.TOKEN),
        )
        self._visits[context.id] = visit
        widgets.send_all_after_pull(document)
        document.on_session_destroyed(lambda context: self._close_page(context.id))
        # Delayed, because the start of a process would slow down this page.
        document.add_timeout_callback(self.bench.prestart, _WARM)
        sheet = pn.Column(sizing_mode="stretch_both", margin=0)
        # The browser loads the scripts first; the content follows.
        document.add_next_tick_callback(partial(self._build_page, sheet, visit, context.id))
        return sheet

    def _build_page(self, sheet: Any, visit: PageVisit, session: str) -> None:
        """Add the content of a page to its layout, or an error message."""
        import panel as pn

        if session not in self._visits:
            return
        try:
            sheet.append(self._page(visit))
        except Exception as error:
            # For example, a project file that was edited by hand is invalid.
            text = str(error)
            if not isinstance(error, rc.RoughcontactError):
                # The page must not stay blank after an internal error.
                _log.exception("a page could not be made")
                text = f"An internal error ended this page ({type(error).__name__}). Report it."
            self._close_visit(session)
            sheet.append(pn.pane.Str(text))

    def _other_visits(self, work: projects.SavedProject) -> list[projects.SavedProject]:
        if self._settings.is_open:
            return []
        return [other for other in self._works.saved_projects() if other.key != work.key]

    def _peer_visits(self, session: str) -> list[PageVisit]:
        own = self._visits.get(session)
        return [
            visit
            for visit in self._visits.values()
            if own is not None and visit is not own and visit.work.key == own.work.key
        ]

    def _close_page(self, session: str) -> None:
        self._close_visit(session)
        assert self._loop is not None
        # Only once if several pages close together.
        if self._tidying is not None:
            self._tidying.cancel()
        self._tidying = self._loop.call_later(_REST, _release_memory)

    def _close_visit(self, session: str) -> None:
        visit = self._visits.pop(session, None)
        if visit is not None:
            visit.close()

    def _leave_all(self) -> None:
        for session in list(self._visits):
            self._close_visit(session)


def _release_memory() -> None:
    """Release the memory of closed pages."""
    gc.collect()
    processes.release_memory()


def serve(load: Load, settings: Settings, say: Callable[[str], None]) -> None:
    """Serve pages until Ctrl-C."""
    server = Server(load, settings)
    say(server.url)
    if settings.is_open:
        say(
            "anyone with this address can read uploaded files and use the processor and memory of "
            "this machine; over http, others on the network can read the traffic"
        )
    with contextlib.ExitStack() as ends:
        if settings.browser:
            opening = ends.enter_context(server.login_file())
            threading.Thread(target=webbrowser.open, args=(opening,), daemon=True).start()
        with contextlib.suppress(KeyboardInterrupt):
            server.run()


def _open_socket(settings: Settings) -> tuple[socket.socket, int]:
    """Return a listening socket, and its port."""
    family = socket.AF_INET6 if ":" in settings.address else socket.AF_INET
    wanted = [PORT, 0] if settings.port is None else [settings.port]
    for port in wanted:
        try:
            listening = socket.create_server((settings.address, port), family=family)
        except OSError as error:
            reason = error.strerror or str(error)
            continue
        listening.setblocking(False)
        return listening, int(listening.getsockname()[1])
    raise rc.InputError(
        f"{wanted[-1]} of {settings.address} cannot be opened ({reason}); give another",
        argument="port",
    )


@contextlib.contextmanager
def _stop_on_signals(loop: asyncio.AbstractEventLoop) -> Iterator[None]:
    """Stop an event loop between two iterations on termination signals."""
    asking = []
    if threading.current_thread() is threading.main_thread() and sys.platform != "win32":
        wanted = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        # `nohup` ignores one of the signals.
        asking = [item for item in wanted if signal.getsignal(item) is not signal.SIG_IGN]
    for item in asking:
        loop.add_signal_handler(item, loop.stop)
    try:
        yield
    finally:
        for item in asking:
            loop.remove_signal_handler(item)


async def _run_callbacks() -> None:
    """Run the pending callbacks of the event loop."""


# Names of page folders and generated files: no other path can be requested.
_FOLDER, _NAME = re.compile(r"page-[0-9a-f]{16}"), re.compile(r"[a-z]+-[0-9]+(\.[a-z0-9]+)+")
_PIECE = 2**20


class DownloadHandler(web.RequestHandler):
    """Handler of ``GET /made?work=KEY&page=FOLDER&file=NAME``: sends a file to be saved."""

    def initialize(self, works: projects.ProjectStore) -> None:
        """Store the projects."""
        self._works = works

    async def get(self) -> None:
        """Send the file in blocks."""
        path = self._requested_file()
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="{path.name}"')
        self.set_header("Content-Length", str(path.stat().st_size))
        with path.open("rb") as stream:
            while piece := stream.read(_PIECE):
                self.write(piece)
                await self.flush()

    def _requested_file(self) -> Path:
        work = self._works.open_project(work_key(self.request))
        folder, name = (self.get_query_argument(key, "") for key in ("page", "file"))
        if work is not None and _FOLDER.fullmatch(folder) and _NAME.fullmatch(name):
            path = work.folder / folder / name
            if path.is_file():
                return path
        raise web.HTTPError(404)


@web.stream_request_body
class UploadHandler(web.RequestHandler):
    """Handler of ``POST /upload?work=KEY&name=NAME``, with the file as body."""

    def initialize(self, works: projects.ProjectStore, limit: int, together: int) -> None:
        """Store the projects, and the limits of one file and of all files [bytes]."""
        self._works, self._limit, self._together = works, limit, together
        self._ends = ExitStack()
        self._upload: projects.Upload | None = None

    def prepare(self) -> None:
        """Check the request, and open the upload before its body is received."""
        if self.request.method != "POST":
            self._refuse(405, "a file is sent by POST")
            return
        work = self._works.open_project(work_key(self.request))
        if work is None:
            self._refuse(404, "this project no longer exists")
            return
        name = self.get_query_argument("name", "")
        if "Content-Length" not in self.request.headers:
            self._refuse(411, "a file is sent with its length")
            return
        try:
            size = int(self.request.headers["Content-Length"])
            projects.require_size(projects.safe_file_name(name), size, self._limit)
            self._ends.enter_context(
                self._works.reserve_upload(projects.safe_file_name(name), size, self._together)
            )
        except rc.InputError as error:
            # The limit is an option of the command that starts the server.
            self._refuse(413, error.message_for(lambda ref: f"--{ref.name.replace('_', '-')}"))
            return
        # The limit of the server holds for other requests, which are far smaller.
        connection = cast(HTTP1Connection, self.request.connection)
        connection.set_max_body_size(self._limit)
        self._upload = self._ends.enter_context(work.open_upload(name, self._limit))

    def data_received(self, chunk: bytes) -> None:
        """Write the next bytes to the upload."""
        if self._upload is not None:
            self._upload.write(chunk)

    def post(self) -> None:
        """Complete the upload, and send its stored and its original name."""
        if self._upload is not None:
            self._ends.close()
            self.finish({"file": self._upload.path.name, "name": self._upload.name})

    def on_finish(self) -> None:
        """Discard an incomplete upload."""
        with contextlib.suppress(_Abandoned):
            self._ends.__exit__(_Abandoned, _Abandoned(), None)

    def on_connection_close(self) -> None:
        """Discard an incomplete upload after the loss of the connection."""
        self.on_finish()

    def _refuse(self, status: int, sentence: str) -> None:
        self.set_status(status)
        self.finish({"error": sentence})


class _Abandoned(Exception):  # noqa: N818 - not an error of the program
    """End of an incomplete upload."""
