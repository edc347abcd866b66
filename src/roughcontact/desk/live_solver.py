"""Live solver: maps are read and prepared once, and only the last request is solved.

A separate thread solves, so that the caller does not wait. A running solve completes unless other
maps are requested; of the requests that arrive meanwhile only the newest is queued.

`LiveSolver` stores the maps as read and as prepared, but no result: at most twice the heights of
both bodies.
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
from typing import Any, TypeAlias

import roughcontact as rc
from roughcontact.drawing import style as drawing_style
from roughcontact.formats import read
from roughcontact.request import preparation, run
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class PreparedMaps:
    """Maps of a request, prepared for its solve."""

    request: Request  # Request
    surfaces: tuple[rc.Surface, ...]  # Surface of the body, and of the counter-body if it has a map


@dataclass(frozen=True)
class FailedRequest:
    """Request that failed, and the reason."""

    request: Request | None  # Invalid options have no request
    error: rc.RoughcontactError  # The reason


@dataclass(frozen=True)
class Preview:
    """Preview of a request: on larger pixels, or without the calibrated ceiling."""

    request: Request  # Request
    contact: rc.ContactResult  # Result


Event: TypeAlias = "PreparedMaps | Preview | Outcome | rc.results.Progress | FailedRequest | str"
"""Events: a stage, prepared maps, solver progress, a result, or a failure."""

PREVIEW_POINTS = 256
"""Maximum number of points along each side of a preview."""


# Maximum time that a solve waits for solves of other pages [s].
_MAX_WAIT = 5.0


class _Outdated(Exception):  # noqa: N818 - not an error, only a newer request
    """End of a request that was canceled, or replaced by a newer one."""


class LiveAnswer(Enum):
    """Kind of answer to a request."""

    MAPS = "maps"
    PREVIEW = "preview"
    CONTACT = "contact"


class LiveSolver:
    """Solver of the last request, in a separate thread."""

    def __init__(
        self,
        on_event: Callable[[Event], None],
        reader: preparation.Reader = read.read_announced,
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
        self._read: dict[Any, rc.Surface] = {}
        self._prepared: tuple[Any, tuple[rc.Surface, ...]] | None = None
        self._coarse: tuple[tuple[rc.Surface, ...], tuple[rc.Surface, ...]] | None = None
        self._thread = threading.Thread(target=self._run_solver, name="live", daemon=True)
        self._thread.start()

    def request(self, request: Request, answer: LiveAnswer = LiveAnswer.CONTACT) -> None:
        """Queue a request, in place of the waiting one."""
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
        """End the thread without further events."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def wait(self, seconds: float) -> bool:
        """Wait until no request is waiting or running; return False on timeout."""
        with self._changed:
            return self._changed.wait_for(
                lambda: self._pending is None and not self._at_work, seconds
            )

    # In the solver thread.

    def _run_solver(self) -> None:
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
        """Return the outcome, the preview or the prepared maps of a request, or its failure."""
        try:
            surfaces = self._maps(request)
            if wanted is LiveAnswer.PREVIEW:
                if self._coarse is None or self._coarse[0] is not surfaces:
                    self._coarse = surfaces, tuple(map(coarsen_surface, surfaces))
                with self._wait_for_turn():
                    contact = run.solve_request(
                        request, self._coarse[1], self._notify, self._notify
                    ).contact
                assert contact is not None
                return Preview(request, contact)
            prepared = PreparedMaps(request, surfaces)
            if wanted is LiveAnswer.MAPS:
                return prepared
            self._notify(prepared)
            with self._wait_for_turn():
                show = partial(self._show_preview, request)
                return run.solve_request(request, surfaces, self._notify, self._notify, show)
        except rc.RoughcontactError as error:
            return FailedRequest(request, error)
        except MemoryError:
            words = "the memory is exhausted; crop the map, or choose a coarser pixel"
            return FailedRequest(request, rc.InputError(words))
        except OSError as error:
            place = error.filename or "a file"
            return FailedRequest(request, rc.FormatError(f"{place}: {error.strerror or error}"))
        except _Outdated:
            raise
        except Exception as error:
            # The page must not wait forever after an internal error.
            _log.exception("a contact could not be solved")
            words = f"an internal error ended this ({type(error).__name__}): report it"
            return FailedRequest(request, rc.InputError(words))

    @contextlib.contextmanager
    def _wait_for_turn(self) -> Iterator[None]:
        """Wait for a free solver slot, `_MAX_WAIT` at most."""
        is_given = self._turns.acquire(timeout=_MAX_WAIT)
        try:
            yield
        finally:
            if is_given:
                self._turns.release()

    def _show_preview(self, request: Request, contact: rc.ContactResult) -> None:
        """Report a contact as a preview; the next request cancels its calibrated solve."""
        self._notify(Preview(request, contact))
        self._is_seen = True

    def _notify(self, what: Event) -> None:
        with self._changed:
            if self._closed or self._drop or self._is_outdated:
                raise _Outdated
        self._on_event(what)

    @property
    def _is_outdated(self) -> bool:
        """Whether the waiting request cancels this one: other maps, or a preview is shown."""
        if self._pending is None or self._under_way is None:
            return False
        request, wanted = self._pending
        needs_others = wanted is LiveAnswer.MAPS or _maps_key(request) != _maps_key(self._under_way)
        return self._is_seen or needs_others

    def _maps(self, request: Request) -> tuple[rc.Surface, ...]:
        key = _maps_key(request)
        if self._prepared is None or self._prepared[0] != key:
            self._prepared = self._coarse = None
            reading = partial(self._reading, request.inputs)
            self._prepared = key, tuple(preparation.surfaces(request, self._notify, reading))
        return self._prepared[1]

    def _reading(
        self, inputs: Sequence[Path], path: Path, announced: Callable[..., None], *reading: Any
    ) -> rc.Surface:
        key = path, _modification_times(path), reading
        if key not in self._read:
            # First remove maps that are no longer requested.
            self._read = {old: item for old, item in self._read.items() if old[0] in inputs}
            self._read = {old: item for old, item in self._read.items() if old[0] != path}
            self._read[key] = self._reader(path, announced, *reading)
        announced(self._read[key].shape)
        return self._read[key]


def coarsen_surface(surface: rc.Surface) -> rc.Surface:
    """Return a surface coarsened for a preview, each pixel the mean of a block."""
    block = math.ceil(max(surface.shape) / PREVIEW_POINTS)
    blocks = min(block, surface.shape[0]), block
    rows, columns = (
        points // size * size for points, size in zip(surface.shape, blocks, strict=True)
    )
    heights = drawing_style.cell_mean(surface.heights[:rows, :columns], blocks)
    dy, dx = surface.pixel
    return replace(surface, heights=heights, pixel=(dy * blocks[0], dx * blocks[1]))


def _maps_key(request: Request) -> tuple[Any, ...]:
    """Return the key of the prepared maps of a request."""
    prepares = (option.name for option in request.task.options if option.prepares)
    return request.file, tuple(map(request.specified.get, prepares))


def _modification_times(path: Path) -> tuple[int, int] | None:
    """Return modification time [ns] and size [bytes] of a file; None without a file."""
    try:
        result = path.stat()
    except OSError:
        return None
    return result.st_mtime_ns, result.st_size
