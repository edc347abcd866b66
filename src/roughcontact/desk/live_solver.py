"""Live solver: maps are read and prepared once, and only the last request is solved.

A separate thread solves, so that the caller does not wait. A running solve completes unless other
maps are requested; of the requests that arrive meanwhile only the newest is queued.

`LiveSolver`: It stores the maps as read and as prepared, but no result: at most twice the heights
of both bodies.
"""

from __future__ import annotations

import contextlib
import logging
import math
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact.contact.result import ContactResult
from roughcontact.drawing.style import cell_mean
from roughcontact.errors import FormatError, InputError, RoughcontactError
from roughcontact.formats import read
from roughcontact.request import preparation as maps
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request
from roughcontact.request.run import solve_request
from roughcontact.solvers.progress import Progress
from roughcontact.surface.surface import Surface

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class PreparedMaps:
    """The maps of a request, ready to be pressed together."""

    request: Request  # Request
    surfaces: tuple[Surface, ...]  # That of the body, and of the counter-body if it has one


@dataclass(frozen=True)
class FailedRequest:
    """Why a request cannot be done."""

    request: Request | None  # Request, if it was valid
    error: RoughcontactError  # The reason


@dataclass(frozen=True)
class Preview:
    """Preview of a request: on larger pixels, or without the calibrated ceiling."""

    request: Request  # Request
    contact: ContactResult  # Result


Event = PreparedMaps | Preview | Outcome | Progress | FailedRequest | str
"""Events: a stage, prepared maps, solver progress, a result, or a failure."""

PREVIEW_POINTS = 256
"""Points along each side of a preview, at most."""


# Seconds after which a contact no longer waits for those of other pages.
_MAX_WAIT = 5.0


class _Outdated(Exception):  # noqa: N818 - no error: something newer was asked for
    """Other maps were asked for in the meantime, or nothing any more."""


class LiveAnswer(Enum):
    """Answer to a request."""

    MAPS = "maps"
    PREVIEW = "preview"
    CONTACT = "contact"


class LiveSolver:
    """Solves the last request."""

    def __init__(
        self,
        on_event: Callable[[Event], None],
        reader: maps.Reader = read.read_announced,
        turns: threading.Semaphore | None = None,
    ) -> None:
        self._on_event = on_event
        self._reader = reader
        self._turns = turns or threading.Semaphore()
        self._changed = threading.Condition()
        self._pending: tuple[Request, LiveAnswer] | None = None
        self._under_way: Request | None = None
        self._at_work = False
        self._closed = False
        self._drop = self._is_seen = False
        self._read: dict[Any, Surface] = {}
        self._prepared: tuple[Any, tuple[Surface, ...]] | None = None
        self._coarse: tuple[tuple[Surface, ...], tuple[Surface, ...]] | None = None
        self._thread = threading.Thread(target=self._follow, name="live", daemon=True)
        self._thread.start()

    def request(self, request: Request, answer: LiveAnswer = LiveAnswer.CONTACT) -> None:
        """Solve this next, in place of what waits."""
        with self._changed:
            self._pending = request, answer
            self._changed.notify_all()

    def cancel(self) -> None:
        """Drop the waiting request, and cancel the running one."""
        with self._changed:
            self._pending = None
            self._drop = True
            self._changed.notify_all()

    def close(self) -> None:
        """End the thread without further messages."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def wait(self, seconds: float) -> bool:
        """Wait until no request is waiting or running; return False on timeout."""
        with self._changed:
            return self._changed.wait_for(
                lambda: self._pending is None and not self._at_work, seconds
            )

    # In the thread.

    def _follow(self) -> None:
        while True:
            with self._changed:
                self._at_work = False
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._pending is not None or self._closed)
                if self._closed:
                    self._read, self._prepared = {}, None
                    return
                assert self._pending is not None
                (request, wanted), self._pending = self._pending, None
                self._under_way = request
                self._at_work, self._drop, self._is_seen = True, False, False
            with contextlib.suppress(_Outdated):
                self._notify(self._answer(request, wanted))

    def _answer(self, request: Request, wanted: LiveAnswer) -> Event:
        """Return the result, or the maps where only these are wanted, or why there is none."""
        try:
            surfaces = self._maps(request)
            if wanted is LiveAnswer.PREVIEW:
                if self._coarse is None or self._coarse[0] is not surfaces:
                    self._coarse = surfaces, tuple(map(coarsen_surface, surfaces))
                with self._wait_for_turn():
                    contact = solve_request(
                        request, self._coarse[1], self._notify, self._notify
                    ).contact
                assert contact is not None
                return Preview(request, contact)
            prepared = PreparedMaps(request, surfaces)
            if wanted is LiveAnswer.MAPS:
                return prepared
            self._notify(prepared)
            with self._wait_for_turn():
                show = partial(self._show, request)
                return solve_request(request, surfaces, self._notify, self._notify, show)
        except RoughcontactError as error:
            return FailedRequest(request, error)
        except MemoryError:
            words = "the memory is used up; crop the map, or choose a coarser pixel"
            return FailedRequest(request, InputError(words))
        except OSError as error:
            place = error.filename or "a file"
            return FailedRequest(request, FormatError(f"{place}: {error.strerror or error}"))
        except _Outdated:
            raise
        except Exception as error:
            # A mistake of the program must not leave a page that waits for ever.
            _log.exception("a contact could not be solved")
            words = f"an internal error ended this ({type(error).__name__}): report it"
            return FailedRequest(request, InputError(words))

    @contextlib.contextmanager
    def _wait_for_turn(self) -> Iterator[None]:
        """Wait until at most one other page solves, or `_MAX_WAIT` is over."""
        is_given = self._turns.acquire(timeout=_MAX_WAIT)
        try:
            yield
        finally:
            if is_given:
                self._turns.release()

    def _show(self, request: Request, contact: ContactResult) -> None:
        """Report a contact before its solve with the calibrated ceiling, which requests cancel."""
        self._notify(Preview(request, contact))
        self._is_seen = True

    def _notify(self, what: Event) -> None:
        with self._changed:
            if self._closed or self._drop or self._is_outdated:
                raise _Outdated
        self._on_event(what)

    @property
    def _is_outdated(self) -> bool:
        """Whether the next request ends this solve: other maps are needed, or it is shown."""
        if self._pending is None or self._under_way is None:
            return False
        request, wanted = self._pending
        needs_others = wanted is LiveAnswer.MAPS or _maps_key(request) != _maps_key(self._under_way)
        return self._is_seen or needs_others

    def _maps(self, request: Request) -> tuple[Surface, ...]:
        key = _maps_key(request)
        if self._prepared is None or self._prepared[0] != key:
            self._prepared = self._coarse = None
            result = maps.surfaces(request, self._notify, partial(self._reading, request.inputs))
            self._prepared = key, tuple(result)
        return self._prepared[1]

    def _reading(
        self, inputs: Sequence[Path], path: Path, announced: Callable[..., None], *reading: Any
    ) -> Surface:
        key = path, _modification_times(path), reading
        if key not in self._read:
            # Maps that are no longer requested are removed first.
            self._read = {old: item for old, item in self._read.items() if old[0] in inputs}
            self._read = {old: item for old, item in self._read.items() if old[0] != path}
            self._read[key] = self._reader(path, announced, *reading)
        announced(self._read[key].shape)
        return self._read[key]


def coarsen_surface(surface: Surface) -> Surface:
    """Return a surface with few enough pixels for a preview, each the mean of several."""
    block = math.ceil(max(surface.shape) / PREVIEW_POINTS)
    blocks = min(block, surface.shape[0]), block
    rows, columns = (
        points // size * size for points, size in zip(surface.shape, blocks, strict=True)
    )
    heights = cell_mean(surface.heights[:rows, :columns], blocks)
    dy, dx = surface.pixel
    return replace(surface, heights=heights, pixel=(dy * blocks[0], dx * blocks[1]))


def _maps_key(request: Request) -> tuple[Any, ...]:
    """Return the key of the prepared maps of a request."""
    prepares = (option.name for option in request.task.options if option.prepares)
    return request.file, tuple(map(request.specified.get, prepares))


def _modification_times(path: Path) -> tuple[int, int] | None:
    """Return times and sizes that change with the content of a file; None if there is no file."""
    try:
        result = path.stat()
    except OSError:
        return None
    return result.st_mtime_ns, result.st_size
