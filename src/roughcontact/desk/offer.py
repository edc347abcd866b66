"""A file that was made for a page: taken away by the browser."""

from __future__ import annotations

import re
from pathlib import Path

from tornado.web import HTTPError, RequestHandler

from roughcontact.desk.guard import key_of
from roughcontact.desk.works import Works

# A page's folder, and a file in it that we named: no path can be made of them.
_FOLDER, _NAME = re.compile(r"page-[0-9a-f]{16}"), re.compile(r"[a-z]+-[0-9]+(\.[a-z0-9]+)+")
_PIECE = 2**20


class Offer(RequestHandler):
    """Answers ``GET /made?work=KEY&page=FOLDER&file=NAME`` with the file, to be saved."""

    def initialize(self, works: Works) -> None:
        """Keep what it needs."""
        self._works = works

    async def get(self) -> None:
        """Send the file, piece by piece."""
        path = self._asked()
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="{path.name}"')
        self.set_header("Content-Length", str(path.stat().st_size))
        with path.open("rb") as stream:
            while piece := stream.read(_PIECE):
                self.write(piece)
                await self.flush()

    def _asked(self) -> Path:
        work = self._works.find(key_of(self.request))
        folder, name = (self.get_query_argument(key, "") for key in ("page", "file"))
        if work is None or not _FOLDER.fullmatch(folder) or not _NAME.fullmatch(name):
            raise HTTPError(404)
        path = work.folder / folder / name
        if not path.is_file():
            raise HTTPError(404)
        return path
