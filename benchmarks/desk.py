"""How fast the page is in a browser: from the key on the slider to the picture.

    python benchmarks/desk.py                     # every row; some minutes on two idle cores
    python benchmarks/desk.py --points 512 --steps 60
    python benchmarks/desk.py --visits 200        # and the memory over 200 pages
    python benchmarks/desk.py --quick             # a small map, a few steps

A step is one arrow key on the slider of the load. It ends with the second frame that the browser
draws after the data of the pressure map has changed. The solve alone is timed in a process that
does nothing else, at the same loads. Each row has the load average of the machine: where
it is well above the processors that this takes, the row measures the machine, not the page.
"""

from __future__ import annotations

import argparse
import asyncio
import http.client
import json
import os
import re
import statistics
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urljoin, urlsplit

import numpy as np
import psutil
from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import websocket_connect

import roughcontact as rc
from browsing import TIMEOUT, Seat, Served, browser, lacking
from roughcontact.analyses.tasks import from_text
from roughcontact.desk.projects import ProjectStore
from roughcontact.desk.session import SessionState
from roughcontact.request import preparation as maps
from roughcontact.request.run import solve_request

# From the event of the slider to the second frame after the data of the pressure map changed.
_WATCH = """() => {
  const models = [...Bokeh.documents[0]._all_models.values()];
  const map = models.find((m) => m.type == "Figure" && m.title.text.startsWith("Pressure"));
  const source = map.renderers.find((one) => one.glyph.type == "Image" && one.visible).data_source;
  let begun = 0;
  window.waited = [];
  window.pictures = 0;
  document.addEventListener("input", () => { begun = performance.now(); }, true);
  source.properties.data.change.connect(() => {
    requestAnimationFrame(() => requestAnimationFrame(() => window.pictures++));
    const from = begun;
    begun = 0;
    if (from) requestAnimationFrame(() => requestAnimationFrame(
      () => window.waited.push(performance.now() - from)));
  });
}"""


DRAG = 4.0
"""Seconds of a drag."""


def write_map(folder: Path, points: int) -> Path:
    """Return a rough map of that many points a side."""
    heights = rc.self_affine(
        (points, points),
        (1e-6, 1e-6),
        rms_height=0.4e-6,
        rolloff_wavelength=points * 1e-6 / 8,
        cutoff_wavelength=8e-6,
        rng=np.random.default_rng(1),
    )
    path = folder / f"made-{points}.npz"
    rc.Surface(heights, (1e-6, 1e-6)).save(path)
    return path


def open_contact(started: Any, served: Served, path: Path) -> Seat:
    """Return a page with a contact on it, of which the steps of the slider are watched."""
    seat = Seat(started, served.home)
    seat.choose_file(path, path.name)
    seat.choose("Material", "100Cr6")
    seat.choose("Boundary", "the whole contact")
    seat.type("Value with unit", "20 MPa")
    seat.page.get_by_text("converged, certificate").wait_for()
    # The rest of a new picture belongs to no step.
    seat.page.wait_for_load_state("networkidle")
    seat.page.evaluate(_WATCH)
    return seat


def step(seat: Seat, key: str) -> None:
    """Begin a step."""
    seat.page.get_by_role("slider").press(key, no_wait_after=True)


def measure_steps(seat: Seat, count: int) -> list[float]:
    """Return how long a number of steps took [s], as soon as they are done."""
    seat.page.wait_for_function(
        "(count) => window.waited.length >= count", arg=count, timeout=1000 * TIMEOUT
    )
    return [one / 1000 for one in seat.page.evaluate("window.waited")]


def count_drag_pictures(seat: Seat, seconds: float) -> int:
    """Return how many pictures a drag of the slider over its middle half shows."""
    at = seat.page.get_by_role("slider").bounding_box()
    assert at is not None
    before = seat.page.evaluate("window.pictures")
    x, y = at["x"], at["y"] + at["height"] / 2
    seat.page.mouse.move(x + at["width"] / 4, y)
    seat.page.mouse.down()
    start = time.perf_counter()
    while (share := (time.perf_counter() - start) / seconds) < 1:
        seat.page.mouse.move(x + at["width"] * (1 + 2 * share) / 4, y)
        time.sleep(0.02)
    pictures = int(seat.page.evaluate("window.pictures")) - before
    seat.page.mouse.up()
    return pictures


def move_slider(seat: Seat, steps: int) -> tuple[list[float], list[str]]:
    """Return how long steps took, one after the other [s], and the loads to which they led."""
    loads = []
    for count in range(1, steps + 1):
        # Up and down again, around the load at which it began.
        step(seat, "ArrowRight" if (count - 1) // 15 % 2 == 0 else "ArrowLeft")
        times = measure_steps(seat, count)
        loads.append(seat.page.get_by_label("Value with unit").input_value())
    return times, loads


def ignore_progress(*_: Any) -> None:
    """Ignore a progress message."""


def time_solves(path: Path, loads: list[str]) -> list[float]:
    """Return how long the solves take by themselves [s]."""
    given = {"material": "100Cr6", "boundary": "free"}
    requests = [from_text("solve", path, {**given, "load": load}) for load in loads]
    surfaces = maps.surfaces(requests[0], ignore_progress)
    times = []
    for request in requests:
        start = time.perf_counter()
        solve_request(request, surfaces, ignore_progress, ignore_progress)
        times.append(time.perf_counter() - start)
    return times


@contextmanager
def knocking(port: int) -> Iterator[list[float]]:
    """Ask the server for a small thing again and again; give how long it took [s]."""
    times: list[float] = []
    ended = threading.Event()

    def knock() -> None:
        while not ended.wait(0.05):
            start = time.perf_counter()
            line = http.client.HTTPConnection("127.0.0.1", port, timeout=TIMEOUT)
            line.request("GET", "/favicon.ico")
            line.getresponse().read()
            line.close()
            times.append(time.perf_counter() - start)

    thread = threading.Thread(target=knock)
    thread.start()
    try:
        yield times
    finally:
        ended.set()
        thread.join()


def memory(served: Served) -> float:
    """Return the memory of the server and of its children, nothing counted twice [MB]."""
    assert served.process is not None
    server = psutil.Process(served.process.pid)
    family = [server, *server.children(recursive=True)]
    return sum(one.memory_full_info().uss for one in family) / 1e6


def row(name: str, text: str) -> None:
    """Print a row of the table."""
    print(f"| {name} | {text} | {os.getloadavg()[0]:.1f} |", flush=True)


# The second frame after the heights have arrived.
_FIRST_MAP = """() => new Promise((done) => {
  const look = () => {
    const models = [...(window.Bokeh?.documents?.[0]?._all_models?.values() ?? [])];
    const shown = models.some((m) => m.type == "ColumnDataSource" && m.data.heights?.length);
    requestAnimationFrame(shown ? () => requestAnimationFrame(done) : look);
  };
  look();
})"""


def first_map(started: Any, folder: Path, points: int) -> float:
    """Return the time from the command with a map to its picture [s]."""
    path = write_map(folder, points)
    start = time.perf_counter()
    served = Served(folder / "first", str(path))
    try:
        seat = Seat(started, served.first)
        seat.page.evaluate(_FIRST_MAP)
        seconds = time.perf_counter() - start
        seat.page.close()
    finally:
        served.kill()
    return seconds


def measure(given: argparse.Namespace, folder: Path) -> None:
    """Print the rows."""
    with browser() as started:
        for points in given.points:
            times = [first_map(started, folder, points) for _ in range(3)]
            row(
                f"command to first map, {points}², 3 runs",
                f"median {statistics.median(times):.2f} s",
            )
        start = time.perf_counter()
        served = Served(folder / "works")
        try:
            seat = Seat(started, served.home)
            row("first page after the command", f"{time.perf_counter() - start:.2f} s")
            seat.page.close()
            for points in given.points:
                path = write_map(folder, points)
                seat = open_contact(started, served, path)
                times, loads = move_slider(seat, given.steps)
                row(
                    f"pictures in a drag of {DRAG:g} s, {points}²",
                    str(count_drag_pictures(seat, DRAG)),
                )
                seat.page.close()
                solves = time_solves(path, loads)
                middle = statistics.median(times)
                share = statistics.median(solves) / middle
                row(
                    f"slider to picture, {points}², {len(times)} steps",
                    f"median {middle:.2f} s, 95 % {np.quantile(times, 0.95):.2f} s, "
                    f"longest {max(times):.2f} s; the solve alone {share:.0%} of the median",
                )
            print_pages(started, served, write_map(folder, given.points[0]), given.pages)
            # Playwright has a loop in this thread.
            with ThreadPoolExecutor(1) as beside_it:
                visits = visited(served, write_map(folder, given.points[0]), given.pages)
                beside_it.submit(asyncio.run, visits).result()
                if given.visits:
                    path = write_map(folder, given.points[0])
                    closing = passed(served, path, given.visits, given.pages)
                    beside_it.submit(asyncio.run, closing).result()
        finally:
            served.kill()


def print_pages(started: Any, served: Served, path: Path, pages: int) -> None:
    """Print the rows of several pages at a time."""
    before = memory(served)
    seats = [open_contact(started, served, path) for _ in range(pages)]
    row(f"memory of a page, of {pages}", f"{(memory(served) - before) / pages:.0f} MB")
    rounds = 5
    times: list[float] = []
    with knocking(served.port) as knocks:
        for count in range(1, rounds + 1):
            for seat in seats:
                step(seat, "ArrowRight")
            times = [one for seat in seats for one in measure_steps(seat, count)]
    row(
        f"{pages} pages that step at once",
        f"median {statistics.median(times):.2f} s, longest {max(times):.2f} s; "
        f"another request waits at most {max(knocks):.2f} s",
    )
    for seat in seats:
        seat.page.close()
    start = time.perf_counter()
    folders = served.folder
    while list(folders.glob("*/page-*")) and time.perf_counter() - start < TIMEOUT:
        time.sleep(0.5)
    seconds = time.perf_counter() - start
    # The server gives memory back a little later.
    time.sleep(5)
    row(
        "after they are closed",
        f"files gone in {seconds:.0f} s, {memory(served) - before:.0f} MB more than before",
    )


_MAX_MESSAGE_BYTES = 200 * 2**20
_READY = {
    "kind": "MessageSent",
    "msg_type": "bokeh_event",
    "msg_data": {"type": "event", "name": "document_ready", "values": {"type": "map"}},
}


class Visitor:
    """A client of the page at an address that moves the slider and draws nothing.

    It separates the cost of the server from that of browsers.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        self.position = 0
        self._sent = 0

    async def enter(self) -> None:
        """Open the page, as a browser does."""
        client = AsyncHTTPClient()
        answer = await client.fetch(
            self.address, request_timeout=120, follow_redirects=False, raise_error=False
        )
        about = {"Cookie": answer.headers["Set-Cookie"].partition(";")[0]}
        self.address = urljoin(self.address, answer.headers["Location"])
        answer = await client.fetch(self.address, request_timeout=120, headers=about)
        found = re.search(r'"token":"([^"]+)"', answer.body.decode())
        assert found is not None
        place = urlsplit(self.address)
        self._line: Any = await websocket_connect(
            HTTPRequest(f"ws://{place.netloc}/ws", headers=about),
            subprotocols=["bokeh", found[1]],
            max_message_size=_MAX_MESSAGE_BYTES,
        )
        await self._heard()
        await self._say("PULL-DOC-REQ", {})
        kind, content = await self._heard()
        while kind != "PULL-DOC-REPLY":
            kind, content = await self._heard()
        slider = next(one for one in _objects(content) if one["name"].startswith("Slider"))
        self._slider = slider["id"]
        self.position = slider["attributes"].get("value", 0)
        await self._say("PATCH-DOC", {"events": [_READY]})

    async def slide(self, by: int) -> float:
        """Move the slider; return the time until the picture of the pressure arrives [s]."""
        self.position += by
        moved = {"type": "map", "entries": [["value", self.position], ["done", True]]}
        event = {
            "kind": "ModelChanged",
            "model": {"id": self._slider},
            "attr": "moved",
            "new": moved,
        }
        start = time.perf_counter()
        await self._say("PATCH-DOC", {"events": [event]})
        await self.picture()
        return time.perf_counter() - start

    async def picture(self) -> None:
        """Wait for a picture of the pressure."""
        while True:
            kind, content = await self._heard()
            if kind == "PATCH-DOC" and any(map(_is_picture, content["events"])):
                return

    async def idle(self, seconds: float) -> None:
        """Read messages until none arrives for the given time."""
        with_nothing = False
        while not with_nothing:
            try:
                await asyncio.wait_for(self._heard(), seconds)
            except TimeoutError:
                with_nothing = True

    async def leave(self) -> None:
        """Close the page."""
        self._line.close()
        while await self._line.read_message() is not None:
            pass

    async def _say(self, kind: str, content: Any) -> None:
        self._sent += 1
        for part in ({"msgid": f"visitor-{self._sent}", "msgtype": kind}, {}, content):
            await self._line.write_message(json.dumps(part))

    async def _heard(self) -> tuple[str, Any]:
        head = json.loads(await self._part())
        await self._part()
        content = json.loads(await self._part())
        for _ in range(2 * head.get("num_buffers", 0)):
            await self._part()
        return head["msgtype"], content

    async def _part(self) -> Any:
        message = await self._line.read_message()
        assert message is not None, "the page is closed"
        return message


def _objects(found: Any) -> Iterator[dict[str, Any]]:
    """Yield the models of a document."""
    if isinstance(found, dict):
        if found.get("type") == "object" and "name" in found:
            yield found
        found = list(found.values())
    if isinstance(found, list):
        for part in found:
            yield from _objects(part)


def _is_picture(event: dict[str, Any]) -> bool:
    data = event.get("new", event.get("data"))
    entries = data.get("entries", []) if isinstance(data, dict) else []
    return any(name == "pressure" and len(values) > 0 for name, values in entries)


def visitor(served: Served, path: Path) -> Visitor:
    """Return a visitor of a new project with a contact on a map."""
    state = SessionState().with_map(path)
    for name, value in (("material", "100Cr6"), ("boundary", "free"), ("load", "20 MPa")):
        state = state.with_option(name, value)
    work = ProjectStore(served.folder).create()
    work.project.write_text(state.script(work.folder), encoding="utf-8")
    return Visitor(f"{served.home}&work={work.key}")


async def passed(served: Served, path: Path, visits: int, together: int) -> None:
    """Print the memory of the server while many pages are opened, used and closed."""
    found = []
    for first in range(0, visits, together):
        some = [visitor(served, path) for _ in range(min(together, visits - first))]
        for one in some:
            await one.enter()
        await asyncio.gather(*(one.idle(2.0) for one in some))
        for one in some:
            await one.slide(1)
        for one in some:
            await one.leave()
        while list(served.folder.glob("*/page-*")):
            await asyncio.sleep(1.0)
        found.append(memory(served))
    # Objects that are created once, such as caches of plans, exist after some pages.
    quarter = len(found) // 4
    row(
        f"memory over {visits} pages opened and closed",
        f"after {quarter * together} pages {found[quarter]:.0f} MB, "
        f"after all {found[-1]:.0f} MB: {found[-1] / found[quarter] - 1:+.1%}",
    )


async def visited(served: Served, path: Path, pages: int) -> None:
    """Print the rows of several pages at a time whose browsers draw nothing."""
    visitors = []
    with knocking(served.port) as knocks:
        for _ in range(pages):
            visitors.append(visitor(served, path))
            await visitors[-1].enter()
        await asyncio.gather(*(one.idle(3.0) for one in visitors))
    row(
        f"{pages} pages opened one after the other, no browser",
        f"another request waits at most {max(knocks):.2f} s",
    )
    times = []
    with knocking(served.port) as knocks:
        for _ in range(5):
            times += await asyncio.gather(*(one.slide(1) for one in visitors))
    row(
        f"{pages} pages that step at once, no browser",
        f"median {statistics.median(times):.2f} s, longest {max(times):.2f} s; "
        f"another request waits at most {max(knocks):.2f} s",
    )
    for one in visitors:
        await one.leave()


def main() -> None:
    """Print a table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, nargs="+", default=[512, 1024])
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--pages", type=int, default=10, help="side by side")
    parser.add_argument("--visits", type=int, default=0, help="one after the other")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    missing = lacking()
    if missing:
        print(f"desk: skipped, there is no {', no '.join(missing)}")
        return
    if given.quick:
        given.points, given.steps, given.pages = [64], 3, 2
    print("| what | found | load average |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        measure(given, Path(name))


if __name__ == "__main__":
    main()
