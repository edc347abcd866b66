"""A file that a page sends: written as it comes, under a name of our own."""

from __future__ import annotations

from contextlib import ExitStack
from typing import cast

from tornado.http1connection import HTTP1Connection
from tornado.web import RequestHandler, stream_request_body

from roughcontact.desk.guard import key_of
from roughcontact.desk.works import Upload, Works, require_size, shown
from roughcontact.errors import InputError


@stream_request_body
class Receive(RequestHandler):
    """Takes ``POST /upload?work=KEY&name=NAME``, the bytes of the file as its body.

    Its answer is JSON: ``file``, the name under which it is kept in the folder of the work, and
    ``name``, what the user calls it; or ``error``, a sentence.
    """

    def initialize(self, works: Works, limit: int, together: int) -> None:
        """Keep what it needs."""
        self._works, self._limit, self._together = works, limit, together
        self._ends = ExitStack()
        self._upload: Upload | None = None

    def prepare(self) -> None:
        """Begin a file, before any of its bytes have come."""
        if self.request.method != "POST":
            self._refuse(405, "a file is sent by POST")
            return
        work = self._works.find(key_of(self.request))
        if work is None:
            self._refuse(404, "this piece of work is not there any more")
            return
        name = self.get_query_argument("name", "")
        if "Content-Length" not in self.request.headers:
            self._refuse(411, "a file is sent with its length")
            return
        try:
            size = int(self.request.headers["Content-Length"])
            require_size(shown(name), size, self._limit)
            self._ends.enter_context(self._works.room(shown(name), size, self._together))
        except InputError as error:
            self._refuse(413, str(error))
            return
        # What the server takes of all other requests is far less.
        connection = cast(HTTP1Connection, self.request.connection)
        connection.set_max_body_size(self._limit)
        self._upload = self._ends.enter_context(work.receiving(name, self._limit))

    def data_received(self, chunk: bytes) -> None:
        """Take the next bytes."""
        if self._upload is not None:
            self._upload.take(chunk)

    def post(self) -> None:
        """Tell how it is kept, once it is there."""
        if self._upload is not None:
            self._ends.close()
            self.finish({"file": self._upload.path.name, "name": self._upload.name})

    def on_finish(self) -> None:
        """End a file that did not come to its end."""
        self._abandon()

    def on_connection_close(self) -> None:
        """Do the same where the connection is lost."""
        self._abandon()

    def _abandon(self) -> None:
        try:
            self._ends.__exit__(_Abandoned, _Abandoned(), None)
        except _Abandoned:
            pass

    def _refuse(self, status: int, sentence: str) -> None:
        self.set_status(status)
        self.finish({"error": sentence})


class _Abandoned(Exception):  # noqa: N818 - nobody made a mistake
    """The rest of a file does not come."""
