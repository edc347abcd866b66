"""Pages without a browser: a client that opens a page, moves its slider, and draws nothing.

What many pages cost the server is told apart from what their browsers cost.
"""

from __future__ import annotations

import asyncio
import json
import re
import time
from collections.abc import Iterator
from typing import Any
from urllib.parse import urljoin, urlsplit

from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import websocket_connect

_LARGEST = 200 * 2**20
_READY = {
    "kind": "MessageSent",
    "msg_type": "bokeh_event",
    "msg_data": {"type": "event", "name": "document_ready", "values": {"type": "map"}},
}


class Visitor:
    """A client of one page.

    Parameters
    ----------
    address : str
        Of the page; one without a work begins one.
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
            max_message_size=_LARGEST,
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
        """Move the slider; return how long it takes until the picture of the pressure is here."""
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
        """Hear what comes, until nothing comes for so long."""
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
    """Go through the models of a document."""
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
