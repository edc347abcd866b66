"""A contact or a piece of it as a task: what a worker is given, does and tells, wherever it is."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact import checksums, files, processes
from roughcontact._version import __version__
from roughcontact.errors import InputError, Mention, OtherRunError, RoughcontactError, worded
from roughcontact.fleet import plan
from roughcontact.fleet.plan import FAILED, SOLVED, Entry, Report
from roughcontact.halfspace import fft
from roughcontact.request import outputs, pieces, run as running
from roughcontact.request.moving import moved
from roughcontact.request.options import FOLDER
from roughcontact.request.outcome import Outcome

MOST = 2**28
"""Bytes that travel with a contact at most, each way, where workers do not see its files."""


@dataclass(frozen=True)
class Part:
    """One thing that is asked of a contact.

    Parameters
    ----------
    number : int
        Among the entries of the project.
    entry : Entry
        What to do.
    digest : str
        What it depends on, from `plan.digest_of`.
    places : tuple of str
        What the user calls the files that it may write, in the order of the request.
    """

    number: int
    entry: Entry
    digest: str
    places: tuple[str, ...]


@dataclass(frozen=True)
class Journey:
    """What a worker needs to know that may be on another machine.

    Parameters
    ----------
    mark : Path
        A file in the folder of the results: who sees it writes there.
    sums : mapping
        Checksum of each file that is read, by path.
    kept : tuple of Path
        Files of an earlier run that the contact may go on from.
    content : mapping
        The bytes of all these files, where not all workers see them.
    """

    mark: Path
    sums: Mapping[Path, str]
    kept: tuple[Path, ...] = ()
    content: Mapping[Path, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Task:
    """All that is asked of one contact, or a piece of it.

    Parameters
    ----------
    parts : tuple of Part
        One or several, which share what they have in common.
    threads : int
        Cores that it may use.
    journey : Journey or None
        None for a worker that surely sees the same files in the same folder.
    version : str
        Of the program that asks.
    piece : str
        Which of the `request.pieces` of the only part this is; empty for all that is asked.
    known : mapping
        What was found of the pieces, by their words, where they were solved before.
    """

    parts: tuple[Part, ...]
    threads: int
    journey: Journey | None = None
    version: str = __version__
    piece: str = ""
    known: Mapping[str, Any] = field(default_factory=dict)

    @property
    def inputs(self) -> list[Path]:
        """The files that it reads."""
        if self.piece or self.known:
            return [*pieces.inputs(self.parts[0].entry.request, self.piece)]
        return [path for part in self.parts for path in part.entry.request.inputs]


@dataclass(frozen=True)
class Answer:
    """How the parts of a contact ended.

    Parameters
    ----------
    reports : dict
        By number.
    lacking : tuple of Path
        Files that the worker does not see; then nothing was done.
    content : dict
        The files that were left, by the path wanted, where the worker does not see that.
    found : object
        What was found of a piece, if that did not fail.
    """

    reports: Mapping[int, Report] = field(default_factory=dict)
    lacking: tuple[Path, ...] = ()
    content: Mapping[Path, bytes] = field(default_factory=dict)
    found: Any = None


def done(task: Task) -> Answer:
    """Do all that is asked of one contact.

    Parameters
    ----------
    task : Task
        What to do. Whatever goes wrong with a part is told in its report.

    Returns
    -------
    Answer
        How it ended.
    """
    if task.version != __version__:
        return refused(
            task,
            f"the worker runs roughcontact {__version__}, not {task.version}; install the same",
        )
    processes.keep_freed()
    with fft.at_most(task.threads):
        if task.journey is None:
            return _answered(task)
        try:
            return _away(task, task.journey)
        except (RoughcontactError, OSError) as error:
            return refused(task, str(error))


def refused(task: Task, reason: str) -> Answer:
    """Return the answer for a contact of which nothing can be done, for one reason."""
    return Answer({part.number: Report(part.entry.name, FAILED, {}, reason) for part in task.parts})


def _answered(task: Task) -> Answer:
    """Do all parts of a contact, one after the other, or one piece."""
    reports, found = {}, None
    with running.together() as carry_out:
        for part in task.parts:
            try:
                if task.piece:
                    found = pieces.found_of(part.entry.request, task.piece, _nothing, _nothing)
                else:
                    seen = task.journey is None or task.journey.mark.exists()
                    reports[part.number] = _done(part, carry_out, task.known, renew=seen)
            except RoughcontactError as error:
                reports[part.number] = _failed(part, error.worded(_words(part.entry)))
            except MemoryError as error:
                reports[part.number] = _failed(part, _starved(error))
            except OSError as error:
                reports[part.number] = _failed(part, f"{type(error).__name__}: {error}")
    return Answer(reports, found=found)


def _starved(error: MemoryError) -> str:
    """Return what to say of a worker whose memory did not suffice."""
    told = f" ({error})" if str(error) else ""
    return (
        f"its worker ran out of memory{told}; give each worker more, with fewer of them on a "
        "machine, or the map a larger pixel"
    )


def _failed(part: Part, reason: str) -> Report:
    return Report(part.entry.name, FAILED, {}, reason)


def _words(entry: Entry) -> Callable[[Mention], str]:
    return partial(plan.spell_key, task=entry.request.task)


def _done(
    part: Part,
    carry_out: Callable[..., Outcome],
    known: Mapping[str, Any],
    *,
    renew: bool,
) -> Report:
    """Do one part; steps that its folder holds of what was asked before may be put aside."""
    entry = part.entry
    try:
        outcome = carry_out(entry.request, _nothing, None, known)
    except OtherRunError:
        if not renew:
            raise
        # The project has given the folder to this contact alone; steps may have taken hours.
        folder = entry.request.get(FOLDER)
        assert folder is not None
        before = folder.with_name(f"{folder.name}.before")
        shutil.rmtree(before, ignore_errors=True)
        folder.rename(before)
        outcome = carry_out(entry.request, _nothing, None, known)
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.converged:
        return _failed(part, worded(outcome.shortfall.parts, _words(entry)))
    # What is told of a single contact is at its own end.
    last_of = entry.request.task.last
    last = {} if last_of is None else {"last": last_of(outcome)}
    called = dict(zip((path for _, path in entry.request.places), part.places, strict=True))
    written = {"written": [called[path] for path in outcome.written]}
    told = plan.sealed({**outcome.record(), **written, **last}, part.digest, outcome.written)
    text = files.to_json(told) + "\n"
    outputs.write([(entry.summary, partial(files.write, content=text))], _nothing)
    return Report(entry.name, SOLVED, told)


def _nothing(of: object) -> None:
    """Say nothing, and look at nothing."""


# Where the files may be those of another machine


def _away(task: Task, journey: Journey) -> Answer:
    """Do all parts of a contact, each file by its path where it is seen, else by its content."""
    seen = journey.mark.exists()
    needed = [path for path, wanted in journey.sums.items() if not _is_seen(path, wanted)]
    needed += [] if seen else journey.kept
    lacking = tuple(path for path in needed if path not in journey.content)
    if lacking:
        return Answer(lacking=lacking)
    if seen and not needed:
        return _answered(task)
    with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
        left = None if seen else Path(folder) / "left"
        lie = _unpacked(journey, needed, Path(folder) / "read", left)
        parts = tuple(_placed(part, lie, left) for part in task.parts)
        answer = _answered(replace(task, parts=parts))
        left_ = {} if left is None else _packed(left)
    content = {path: held for path, held in left_.items() if journey.content.get(path) != held}
    if (size := sum(map(len, content.values()))) > MOST:
        return refused(task, too_large("the files that it leaves", size))
    return replace(answer, content=content)


def too_large(what: str, size: int) -> str:
    """Return why content does not travel."""
    return (
        f"{what} have {size / 1e6:.0f} MB, and at most {MOST / 1e6:.0f} MB travel with a contact; "
        "put the project where all workers see it under the same path"
    )


def _is_seen(path: Path, wanted: str) -> bool:
    try:
        return checksums.of_file(path) == wanted
    except OSError:
        return False


def _unpacked(
    journey: Journey, needed: Iterable[Path], read: Path, left: Path | None
) -> dict[Path, Path]:
    """Write what came as bytes into files of this machine, and return where those read lie."""
    lie = {}
    for number, path in enumerate(needed):
        if path in journey.sums:
            # Two files of one name may come from two folders.
            lie[path] = place = read / str(number) / path.name
        else:
            assert left is not None
            place = _below(left, path)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(journey.content[path])
        if path in journey.sums and not _is_seen(place, journey.sums[path]):
            raise InputError(f"{path} changed while the project ran; run it again")
    return lie


def _placed(part: Part, lie: Mapping[Path, Path], left: Path | None) -> Part:
    """Return a part of which files that are not seen lie in folders of this machine."""

    def written(path: Path) -> Path:
        if left is None:
            return path
        place = _below(left, path)
        place.parent.mkdir(parents=True, exist_ok=True)
        return place

    entry = part.entry
    request = moved(entry.request, lambda path: lie.get(path, path), written)
    return replace(part, entry=replace(entry, request=request, summary=written(entry.summary)))


def _below(folder: Path, path: Path) -> Path:
    """Return where a file lies below a folder, as it is to lie below the root."""
    return folder / path.relative_to(path.anchor)


def _packed(left: Path) -> dict[Path, bytes]:
    """Return what was left below a folder, by where it is wanted."""
    root = Path(Path.cwd().anchor)
    return {
        root / path.relative_to(left): path.read_bytes()
        for path in sorted(left.rglob("*"))
        if path.is_file()
    }
